//! What is kept of unsaved work, what is asked before it is lost, and what leaves by the clipboard and as a turn.

use std::process::Command;

use eframe::egui::{Color32, ColorImage, OutputCommand, ViewportCommand, ViewportEvent, ViewportId};
use lumivox_core::Preset;
use lumivox_studio::darkroom::ExportDraft;
use lumivox_studio::settings::{Drawer, Mouse};
use lumivox_studio::slices::Plane;
use lumivox_studio::state::{Action, Dialog, ViewId};
use lumivox_studio::turntable::film;

use super::*;

/// Settings that forget, and a folder for unsaved work.
struct Keeps(PathBuf);

impl Drawer for Keeps {
    fn read(&self) -> Option<Settings> {
        Some(Settings { has_agreed: true, ..Settings::default() })
    }

    fn write(&self, _: &Settings) {}

    fn rescue_folder(&self) -> Option<PathBuf> {
        Some(self.0.clone())
    }
}

fn keeping(folder: &Path) -> (Studio, Answers) {
    launch_with(Box::new(Keeps(folder.to_owned())), false)
}

fn commands(studio: &Studio) -> Vec<ViewportCommand> {
    studio.output().viewport_output[&ViewportId::ROOT].commands.clone()
}

/// The window's own button to close it.
fn ask_to_close(studio: &mut Studio) {
    let viewport = studio.input_mut().viewports.entry(ViewportId::ROOT).or_default();
    viewport.events.push(ViewportEvent::Close);
    studio.step();
    let viewport = studio.input_mut().viewports.entry(ViewportId::ROOT).or_default();
    viewport.events.clear();
}

fn kept(folder: &Path) -> Vec<PathBuf> {
    let all = std::fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path());
    all.filter(|file| file.extension().is_some_and(|extension| extension == "lumivox")).collect()
}

fn preset(studio: &Studio) -> Option<Preset> {
    session(studio).document().volumes[0].look.preset
}

#[test]
fn a_program_that_is_killed_loses_less_than_a_minute_and_the_next_one_asks() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("kept");
    let scan = head(folder.path(), 32);
    let (mut studio, _) = keeping(&place);
    open(&mut studio, &[&scan]);
    // What was only looked at is not work.
    ask_to_close(&mut studio);
    assert!(!commands(&studio).contains(&ViewportCommand::CancelClose));
    click(&mut studio, "Skin");
    // Frames of tests are a quarter of a second. However many there are, the next look is always asked for.
    for _ in 0..100 {
        studio.step();
        let delay = studio.output().viewport_output[&ViewportId::ROOT].repaint_delay;
        assert!(delay <= Duration::from_secs(20), "{delay:?}");
    }
    let files = kept(&place);
    let text = std::fs::read_to_string(&files[0]).unwrap();
    assert!(files.len() == 1 && text.contains("ct-skin") && !text.contains("Doe"), "{files:?}");
    // It ends as by a kill: nothing is said, and nothing is tidied up.
    drop(studio);
    let (mut next, answers) = keeping(&place);
    assert!(says(&next, "Unsaved work"));
    screenshot(&mut next, "29-unsaved");
    // Another one beside it has a place of its own, and nothing to ask.
    let (other, _) = keeping(&place);
    assert!(!says(&other, "Unsaved work"));
    drop(other);
    // What is dropped meanwhile comes afterwards, and asks as it always does.
    drop_files(&mut next, &[&scan]);
    click(&mut next, "Restore");
    wait(&mut next, "it is read", |app| app.state.session.is_some());
    settle(&mut next);
    assert_eq!(preset(&next), Some(Preset::CtSkin));
    assert!(says(&next, "Open another without saving?"));
    click(&mut next, "Cancel");
    // It is still unsaved: the window asks.
    ask_to_close(&mut next);
    assert!(commands(&next).contains(&ViewportCommand::CancelClose));
    next.run_steps(2);
    assert!(says(&next, "Close without saving?"));
    screenshot(&mut next, "30-leave");
    click(&mut next, "Cancel");
    assert!(!says(&next, "Close without saving?") && !kept(&place).is_empty());
    // So does what would take its place.
    drop_files(&mut next, &[&scan]);
    next.run_steps(2);
    assert!(says(&next, "Open another without saving?"));
    click(&mut next, "Cancel");
    assert!(preset(&next) == Some(Preset::CtSkin) && !kept(&place).is_empty());
    drop_files(&mut next, &[&scan]);
    next.run_steps(2);
    click(&mut next, "Open anyway");
    let is_another = |app: &App| {
        let session = app.state.session.as_ref();
        session.is_some_and(|it| it.document().volumes[0].look.preset != Some(Preset::CtSkin))
    };
    wait(&mut next, "the other one is read", is_another);
    settle(&mut next);
    click(&mut next, "Skin");
    // Saved, and closed.
    ask_to_close(&mut next);
    next.run_steps(2);
    let scene = folder.path().join("kept.lumivox");
    answers.next(&scene);
    next.get_all_by_label("Save scene…").last().unwrap().click();
    let mut is_closed = false;
    for _ in 0..200 {
        next.step();
        is_closed |= commands(&next).contains(&ViewportCommand::Close);
        if is_closed {
            break;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(is_closed && scene.exists());
    assert!(kept(&place).is_empty());
}

#[test]
fn unsaved_work_is_thrown_away_only_when_that_is_said() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("kept");
    std::fs::create_dir(&place).unwrap();
    std::fs::write(place.join("unsaved-3.lumivox"), "{}").unwrap();
    let (mut studio, _) = keeping(&place);
    assert!(says(&studio, "Unsaved work"));
    ask_to_close(&mut studio);
    assert_eq!(kept(&place).len(), 1, "no answer is no");
    click(&mut studio, "Discard");
    assert!(kept(&place).is_empty() && !says(&studio, "Unsaved work"));
}

#[test]
fn what_cannot_be_restored_is_asked_about_again() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("kept");
    std::fs::create_dir(&place).unwrap();
    let gone = "{\"lumivox_scene\": 1, \"volumes\": [{\"scan\": {\"files\": [\"gone\"]}}]}";
    std::fs::write(place.join("unsaved-3.lumivox"), gone).unwrap();
    let scan = head(folder.path(), 24);
    let (mut studio, _) = keeping(&place);
    // What is dropped waits for the answer.
    drop_files(&mut studio, &[&scan]);
    studio.run_steps(2);
    assert!(studio.state().state.busy.is_none() && says(&studio, "Unsaved work"));
    click(&mut studio, "Restore");
    wait(&mut studio, "it is told", |app| app.state.failed.is_some());
    settle(&mut studio);
    ask_to_close(&mut studio);
    assert_eq!(kept(&place).len(), 1, "what failed is kept");
    click(&mut studio, "Close");
    assert!(says(&studio, "Unsaved work"));
    // So is what was cancelled.
    studio.state_mut().state.dialog = None;
    studio.state_mut().state.act(Action::Restore(true));
    studio.state_mut().state.act(Action::Cancel);
    studio.run_steps(2);
    assert!(says(&studio, "Unsaved work") && kept(&place).len() == 1);
    click(&mut studio, "Discard");
    wait(&mut studio, "what was dropped is read", |app| app.state.session.is_some());
    settle(&mut studio);
    assert!(kept(&place).is_empty() && !session(&studio).has_work());
}

#[test]
fn what_is_chosen_asks_for_unsaved_work_as_what_is_dropped_does() {
    let _alone = alone();
    let (mut studio, answers, folder) = with_head(24);
    let scan = folder.path().join("scan");
    click(&mut studio, "Skin");
    for button in ["Open folder…", "Open files…"] {
        answers.next(&scan);
        click(&mut studio, button);
        settle(&mut studio);
        assert!(says(&studio, "Open another without saving?") && preset(&studio) == Some(Preset::CtSkin));
        click(&mut studio, "Cancel");
    }
    // While a file dialog is up there is no other: the question stays, and the window does not close with what is saved later.
    let held = answers.hold();
    click(&mut studio, "Open files…");
    ask_to_close(&mut studio);
    studio.run_steps(2);
    click(&mut studio, "Save scene…");
    assert!(says(&studio, "Close without saving?"));
    click(&mut studio, "Cancel");
    held.send(scan).unwrap();
    settle(&mut studio);
    click(&mut studio, "Cancel");
    let scene = folder.path().join("view.lumivox");
    answers.next(&scene);
    click(&mut studio, "Save scene…");
    wait(&mut studio, "it is saved", |app| app.state.done.is_some());
    for _ in 0..3 {
        assert!(!commands(&studio).contains(&ViewportCommand::Close));
        studio.step();
    }
    assert!(scene.exists() && preset(&studio) == Some(Preset::CtSkin));
}

#[test]
fn the_view_goes_to_the_clipboard() {
    let _alone = alone();
    let (mut studio, _, _folder) = with_head(32);
    studio.key_press(egui::Key::Num2);
    studio.run_steps(2);
    studio.input_mut().events.push(egui::Event::Copy);
    studio.step();
    let asked = commands(&studio);
    assert!(asked.iter().any(|command| matches!(command, ViewportCommand::Screenshot(_))), "{asked:?}");
    // What the desktop answers: the window, in which the slice is.
    let seen = screenshot(&mut studio, "31-copied");
    let image = ColorImage::from_rgba_unmultiplied(seen.size.map(|n| n as usize), &seen.rgba);
    let (viewport_id, user_data) = (ViewportId::ROOT, Default::default());
    let wanted = view(&studio, "Axial");
    let [red, green, blue, _] = seen.color(wanted.min);
    let corner = Color32::from_rgb(red, green, blue);
    studio.input_mut().events.push(egui::Event::Screenshot {
        viewport_id,
        user_data,
        image: Arc::new(image),
    });
    studio.step();
    let copied = studio.output().platform_output.commands.iter().find_map(|command| match command {
        OutputCommand::CopyImage(image) => Some(image.clone()),
        _ => None,
    });
    let copied = copied.expect("a picture");
    let size = [wanted.width(), wanted.height()];
    assert!(
        (0..2).all(|axis| (copied.size[axis] as f32 - size[axis]).abs() <= 1.0),
        "{:?} {size:?}",
        copied.size
    );
    assert!(copied.pixels[0] == corner && copied.pixels.iter().any(|pixel| *pixel != Color32::BLACK));
    studio.step();
    assert!(says(&studio, "Copied to the clipboard"));
}

#[test]
fn a_film_is_of_its_own_pictures_alone() {
    let command = film(Path::new("/scans/100%.png"), 36);
    let told: Vec<_> = command.get_args().map(|arg| arg.to_string_lossy()).collect();
    let after = |name: &str| &told[told.iter().position(|arg| arg == name).unwrap() + 1];
    assert_eq!((after("-start_number").as_ref(), after("-frames:v").as_ref()), ("0", "36"));
    assert_eq!(Path::new(after("-i").as_ref()), Path::new("/scans/100%%-%03d.png"));
    assert_eq!(Path::new(told[told.len() - 1].as_ref()), Path::new("/scans/100%.mp4"));
}

#[test]
fn a_turn_is_a_picture_for_each_step_and_a_film_where_ffmpeg_is() {
    let _alone = alone();
    let (mut studio, answers, folder) = with_head(32);
    click(&mut studio, "Export picture…");
    click(&mut studio, "Turn around the scan");
    let Some(Dialog::Export(draft)) = studio.state().state.dialog.clone() else { panic!("a dialog") };
    assert_eq!(draft.turn, Some(72));
    screenshot(&mut studio, "32-turn");
    let small = ExportDraft { size: [40, 41], samples: 2, turn: Some(4), denoise: false, ..draft };
    studio.state_mut().state.dialog = Some(Dialog::Export(small));
    studio.step();
    answers.next(folder.path().join("turn"));
    click(&mut studio, "Save as PNGs…");
    settle(&mut studio);
    let pictures: Vec<Vec<u8>> =
        (0..4).map(|step| std::fs::read(folder.path().join(format!("turn-00{step}.png"))).unwrap()).collect();
    assert!(pictures[0] != pictures[1] && pictures[0] != pictures[2]);
    let text = String::from_utf8_lossy(&pictures[0]).into_owned();
    assert!(text.contains("Not a medical device"));
    let has_ffmpeg = Command::new("ffmpeg").arg("-version").output().is_ok_and(|told| told.status.success());
    assert_eq!(folder.path().join("turn.mp4").exists(), has_ffmpeg);
    let said = "Saved: turn-000.png, turn-001.png, turn-002.png, turn-003.png";
    assert!(says(&studio, said) && says(&studio, "ffmpeg") != has_ffmpeg, "{:?}", texts(&studio));
    // Another of that name replaces nothing unasked, for the file dialog has asked for a name that no file has.
    for replaces in [false, true] {
        click(&mut studio, "Export picture…");
        studio.state_mut().state.dialog =
            Some(Dialog::Export(ExportDraft { samples: 3, turn: Some(2), ..small }));
        studio.step();
        answers.next(folder.path().join("turn"));
        click(&mut studio, "Save as PNGs…");
        settle(&mut studio);
        assert!(says(&studio, "Replace these files?") && says(&studio, "turn-000.png, turn-001.png"));
        click(&mut studio, if replaces { "Replace them" } else { "Cancel" });
        settle(&mut studio);
        let now = std::fs::read(folder.path().join("turn-001.png")).unwrap();
        assert_eq!(now != pictures[1], replaces);
    }
    assert!(says(&studio, "Saved: turn-000.png, turn-001.png") && !says(&studio, "turn-002.png"));
}

#[test]
fn the_mouse_is_that_of_ohif_or_of_3d_slicer() {
    let _alone = alone();
    let (mut studio, _, _folder) = with_head(32);
    let studio = &mut studio;
    let axial = view(studio, "Axial");
    let (from, to) = (axial.center() + egui::vec2(20.0, 20.0), axial.center() + egui::vec2(50.0, 40.0));
    let (window, cross) = (studio.state().state.window, studio.state().state.cross);
    drag(studio, PointerButton::Primary, from, to);
    assert!(studio.state().state.window != window && studio.state().state.cross == cross);
    click(studio, "English");
    click(studio, "3D Slicer");
    assert_eq!(studio.state().state.settings.mouse, Mouse::Slicer);
    let window = studio.state().state.window;
    drag(studio, PointerButton::Primary, from, to);
    assert!(studio.state().state.window == window && studio.state().state.cross != cross);
    assert_eq!(studio.state().state.active, ViewId::Slice(Plane::Axial));
}
