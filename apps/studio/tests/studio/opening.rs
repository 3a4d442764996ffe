//! Scans arrive: dropped, chosen, damaged; and what is told of them.

use lumivox_core::Preset;
use lumivox_core::document::Keep;
use lumivox_studio::darkroom::looks_for;
use lumivox_studio::jobs::{Desk, Job, elsewhere, start};
use lumivox_studio::opening::{self, Source, Told};
use lumivox_studio::state::Action;
use lumivox_studio::words::Word;

use super::*;

#[test]
fn what_goes_wrong_is_said() {
    let _alone = alone();
    let (mut studio, answers) = studio();
    reading_is_cancelled_by_its_button(&mut studio, &answers);
    what_is_wrong_with_a_scan_is_never_silent(&mut studio, &answers);
    errors_name_the_file_and_leave_what_was_open(&mut studio, &answers);
}

#[test]
fn a_dropped_folder_becomes_a_picture_of_the_patient() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let scan = head(folder.path(), 40);
    let (mut studio, _) = launch(Settings { has_agreed: true, ..Settings::default() }, true);
    open(&mut studio, &[&scan]);
    wait(&mut studio, "it rests", |app| app.state.progress.rests);
    // What is opened meanwhile and fails leaves strip and tiles as they are, and those that are left come.
    wait(&mut studio, "a tile", |app| !app.state.tiles.is_empty());
    let strip = &studio.state().state.strip;
    let (series, study) = (strip.series[0].clone(), strip.study.clone().unwrap());
    let wake = studio.state().wake().clone();
    let fails = start("fails", wake, move |desk: &Desk<Told>| {
        desk.tell(Told::Series { series: vec![series.clone(), series], chosen: 1, study });
        desk.tell(Told::Failed("in a test".into()));
    });
    studio.state_mut().begin(fails);
    wait(&mut studio, "it fails", |app| app.state.failed.is_some());
    click(&mut studio, "Close");
    let state = &studio.state().state;
    assert_eq!((state.strip.series.len(), state.strip.chosen), (1, 0));
    let known: Vec<_> = state.tiles.iter().map(|(look, tile)| (*look, tile.id())).collect();
    wait(&mut studio, "tiles", |app| app.state.looks.iter().all(|look| app.has_tile(*look)));
    let seen = screenshot(&mut studio, "05-opened");
    let state = &studio.state().state;
    assert!(known.iter().all(|(look, tile)| state.tiles[look].id() == *tile), "no tile is made twice");
    let session = state.session.as_ref().unwrap();
    assert_eq!(state.failed, None);
    assert_eq!(session.document().volumes[0].look.preset, Some(Preset::default_for(session.scan())));
    // All four views show something, on black.
    let names = ["3D", "Axial", "Coronal", "Sagittal"];
    for name in names {
        let rect = view(&studio, name);
        let middle = egui::Rect::from_center_size(rect.center(), rect.size() * 0.3);
        assert!(seen.mean(middle) > 25.0, "{name}: {}", seen.mean(middle));
    }
    // The series has a picture, and every look a tile.
    assert_eq!((state.strip.series.len(), state.strip.thumbnails.len()), (1, 1));
    assert_eq!(state.looks, looks_for(session.scan()));
    assert!(state.looks.len() > 15 && state.looks[0] == Preset::default_for(session.scan()));
    // Whose it is, nobody sees; nor is it in the names of files.
    let name = session.file_name("png");
    assert!(texts(&studio).iter().chain([&name]).all(|text| !text.contains("Doe") && !text.contains("Jane")));
    assert!(says(&studio, "CT"));
}

fn what_is_wrong_with_a_scan_is_never_silent(studio: &mut Studio, answers: &Answers) {
    let folder = tempfile::tempdir().unwrap();
    let scan = head(folder.path(), 24);
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(&scan).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    std::fs::remove_file(&files[files.len() / 2]).unwrap();
    std::fs::write(scan.join("letter.txt"), "no scan").unwrap();
    answers.next(&scan);
    click(studio, "Open folder…");
    wait(studio, "it is read", |app| app.state.session.is_some());
    settle(studio);
    assert!(says(studio, "is missing"), "{:?}", texts(studio));
    assert!(says(studio, "Files left out: 1"), "{:?}", texts(studio));
    screenshot(studio, "06-banner");
}

fn errors_name_the_file_and_leave_what_was_open(studio: &mut Studio, _: &Answers) {
    let folder = tempfile::tempdir().unwrap();
    let scan = head(folder.path(), 24);
    let wrong = folder.path().join("notes.dcm");
    std::fs::write(&wrong, "this is no scan").unwrap();
    let broken = folder.path().join("broken.lumivox");
    std::fs::write(&broken, "{\"lumivox_scene\": 1,\n \"volumes\": [{\"scan\": {\"files\": [\"gone\"]}}]}")
        .unwrap();
    open(studio, &[&scan]);
    for (file, words) in
        [(&wrong, "notes.dcm"), (&broken, "broken.lumivox, line 2"), (&folder.path().join("none"), "none")]
    {
        drop_files(studio, &[file]);
        wait(studio, words, |app| app.state.failed.is_some());
        studio.step();
        assert!(says(studio, words), "{words}: {:?}", texts(studio));
        assert!(says(studio, "It cannot be opened"));
        screenshot(studio, "07-failed");
        click(studio, "Close");
        assert!(studio.state().state.failed.is_none() && studio.state().state.session.is_some());
    }
}

fn reading_is_cancelled_by_its_button(studio: &mut Studio, _: &Answers) {
    let folder = tempfile::tempdir().unwrap();
    let scan = head(folder.path(), 24);
    // However quick the machine, nothing is read before the button was seen and clicked.
    let (begins, gate) = channel::<()>();
    let (ended, ends) = channel();
    let wake = studio.state().wake().clone();
    let reads = start("reads", wake, move |desk: &Desk<Told>| {
        let _ = gate.recv();
        opening::open(Source::Files(vec![scan]), desk);
        let _ = ended.send(());
    });
    studio.state_mut().begin(reads);
    studio.run_steps(2);
    assert!(says(studio, "Reading"), "{:?}", texts(studio));
    click(studio, "Cancel");
    begins.send(()).unwrap();
    ends.recv_timeout(LONGEST).unwrap();
    studio.run_steps(3);
    let state = &studio.state().state;
    assert!(state.session.is_none() && state.failed.is_none() && state.busy.is_none());
    assert!(says(studio, "Drop a scan here"));
}

/// What panics beside the interface is told, and does not look as if nothing had been asked for.
#[test]
fn a_job_that_breaks_is_no_job_that_is_done() {
    let over = |mut job: Job<u8>| {
        let begin = Instant::now();
        let mut told = vec![];
        while !job.is_over() {
            told.extend(job.poll());
            assert!(begin.elapsed() < LONGEST);
            std::thread::sleep(Duration::from_millis(1));
        }
        (told, job.is_broken())
    };
    let wake: lumivox_studio::jobs::Wake = Arc::new(|| {});
    let done = start("tells", wake.clone(), |desk: &Desk<u8>| desk.tell(7));
    assert_eq!(over(done), (vec![7], false));
    let broken = start("breaks", wake, |desk: &Desk<u8>| {
        desk.tell(7);
        panic!("in a test");
    });
    assert_eq!(over(broken), (vec![7], true));
}

/// The program, and a head of so many voxels that it has not opened; the folder goes with the test.
fn beside_a_head(size: usize) -> (Studio, PathBuf, TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let scan = head(folder.path(), size);
    (studio().0, scan, folder)
}

/// All that is told of a scan while it is opened.
fn told_of(scan: &Path) -> Vec<Told> {
    let (mut job, desk) = elsewhere(Arc::new(|| {}), || {});
    opening::open(Source::Files(vec![scan.to_owned()]), &desk);
    job.poll()
}

/// A scan of which it is looked for what is shown until somebody says what came of that.
fn begin_scan(studio: &mut Studio, scan: &Path) -> (Sender<Told>, Told) {
    let mut told = told_of(scan).into_iter();
    let (send, words) = channel::<Told>();
    let wake = studio.state().wake().clone();
    let opens = start("opens", wake, move |desk: &Desk<Told>| words.into_iter().for_each(|it| desk.tell(it)));
    studio.state_mut().begin(opens);
    told.by_ref().take(3).for_each(|told| send.send(told).unwrap());
    let found = told.next().unwrap();
    assert!(matches!(found, Told::Found(..)));
    wait(studio, "it is read", |app| app.state.session.as_ref().is_some_and(Session::is_coming));
    studio.run_steps(2);
    (send, found)
}

/// Whether all that was scanned is shown.
fn is_whole(studio: &Studio) -> bool {
    Arc::ptr_eq(&session(studio).scene().0.volumes[0].volume, session(studio).scan())
}

fn keep(studio: &Studio) -> Keep {
    session(studio).document().volumes[0].scan.keep
}

/// Looking for the patient takes a browser long.
#[test]
fn all_that_was_scanned_is_seen_meanwhile_where_a_gpu_has_time_for_that() {
    let _alone = alone();
    let (mut studio, scan, _folder) = beside_a_head(32);
    let studio = &mut studio;
    studio.state_mut().live_mut().unwrap().set_patience(Some(Duration::ZERO));
    let (send, found) = begin_scan(studio, &scan);
    wait(studio, "all of it is seen", |app| app.state.progress.is_shown);
    assert!(session(studio).is_coming() && is_whole(studio));
    let seen = screenshot(studio, "08-all-meanwhile");
    let rect = view(studio, "3D");
    let middle = egui::Rect::from_center_size(rect.center(), rect.size() * 0.2);
    assert!(seen.mean(middle) > 40.0, "{}", seen.mean(middle));
    send.send(found).unwrap();
    wait(studio, "it is found", |app| app.state.session.as_ref().is_some_and(|session| !session.is_coming()));
    assert!(!is_whole(studio));
    wait(studio, "the patient is seen", |app| app.state.progress.is_shown);
}

#[test]
fn slices_are_seen_before_it_is_found_what_is_shown() {
    let _alone = alone();
    let (mut studio, scan, _folder) = beside_a_head(32);
    let studio = &mut studio;
    let (send, found) = begin_scan(studio, &scan);
    let content = session(studio).document().volumes[0].scan.content.clone();
    assert!(content.is_some_and(|content| content.starts_with("sha256:")));
    assert!(!session(studio).is_changed());
    let seen = screenshot(studio, "08-slices-first");
    for name in ["Axial", "Coronal", "Sagittal"] {
        let rect = view(studio, name);
        let middle = egui::Rect::from_center_size(rect.center(), rect.size() * 0.3);
        assert!(seen.mean(middle) > 25.0, "{name}: {}", seen.mean(middle));
    }
    assert!(says(studio, "Preparing the look"), "{:?}", texts(studio));
    assert!(!studio.state().state.progress.is_shown && !studio.state().is_quiet());
    // There is no picture to export yet, and what is changed waits.
    let looks = [Action::ExportDialog, Action::Look(Preset::CtBone)];
    looks.into_iter().for_each(|action| studio.state_mut().state.act(action));
    studio.run_steps(2);
    assert!(studio.state().state.dialog.is_none());
    send.send(found).unwrap();
    drop(send);
    settle(studio);
    assert!(!is_whole(studio) && studio.state().state.progress.is_shown);
    assert_eq!(keep(studio), Keep::Patient);
    assert_eq!(session(studio).document().volumes[0].look.preset, Some(Preset::CtBone));
    // It is framed as if the look had been chosen later.
    let framed = session(studio).document().camera;
    undo(studio);
    settle(studio);
    assert_eq!(session(studio).document().camera, framed);
    assert!(!session(studio).is_changed());
}

#[test]
fn of_what_is_not_found_all_is_shown() {
    let _alone = alone();
    let (mut studio, scan, _folder) = beside_a_head(24);
    let studio = &mut studio;
    let all_of_it = |studio: &mut Studio| {
        settle(studio);
        assert!(is_whole(studio) && keep(studio) == Keep::Everything);
        assert!(!session(studio).is_changed() && session(studio).history().next() == [None; 2]);
    };
    // Nobody waits for it.
    let (send, found) = begin_scan(studio, &scan);
    click(studio, "Cancel");
    let _ = send.send(found);
    all_of_it(studio);
    // It fails.
    let (send, _) = begin_scan(studio, &scan);
    send.send(Told::Failed("in a test".into())).unwrap();
    drop(send);
    wait(studio, "it fails", |app| app.state.failed.is_some());
    click(studio, "Close");
    all_of_it(studio);
    // It is asked for again by the switch that is off.
    let mut document = Box::new(session(studio).document().clone());
    document.volumes[0].scan.keep = Keep::Patient;
    studio.state_mut().state.act(Action::Change(Word::Everything, document));
    settle(studio);
    assert!(!is_whole(studio));
}

#[test]
fn what_is_wanted_while_it_is_found_what_is_shown_comes_after_it() {
    let _alone = alone();
    let (mut studio, scan, _folder) = beside_a_head(24);
    let studio = &mut studio;
    let (send, found) = begin_scan(studio, &scan);
    let mut document = Box::new(session(studio).document().clone());
    document.volumes[0].scan.keep = Keep::Everything;
    studio.state_mut().state.act(Action::Change(Word::Everything, document));
    studio.run_steps(2);
    send.send(found).unwrap();
    drop(send);
    settle(studio);
    // Voxels of the whole scan, by a job of its own.
    let shown = session(studio).scene().0.volumes[0].volume.clone();
    assert!(keep(studio) == Keep::Everything && shown.voxels() == session(studio).scan().voxels());

    // What is opened next and fails leaves the scan, of which it is found what is shown.
    let _left = begin_scan(studio, &scan);
    drop_files(studio, &[&scan.with_file_name("none")]);
    wait(studio, "it fails", |app| app.state.failed.is_some());
    click(studio, "Close");
    settle(studio);
    assert!(!is_whole(studio) && keep(studio) == Keep::Patient);
}
