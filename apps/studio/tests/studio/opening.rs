//! Scans arrive: dropped, chosen, damaged; and what is told of them.

use lumivox_core::Preset;
use lumivox_studio::darkroom::looks_for;
use lumivox_studio::jobs::{Desk, Job, start};
use lumivox_studio::opening::Told;

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
    let scan = head(folder.path(), 64);
    drop_files(studio, &[&scan]);
    studio.step();
    assert!(says(studio, "Reading"), "{:?}", texts(studio));
    click(studio, "Cancel");
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
