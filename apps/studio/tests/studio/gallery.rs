//! Ten pictures of the Studio as people see it, for the guide: of a fine head, and clean, where they are kept, which wants a GPU. Else
//! they are of a coarse one.
//!
//! `LUMIVOX_SCREENSHOTS=FOLDER cargo test --release -p lumivox-studio gallery -- --ignored` keeps them.

use lumivox_core::document::Keep;
use lumivox_studio::state::{Layout, Tab, Tool};
use lumivox_studio::words::{Language, Word};

use super::*;

/// Voxels of the head along each axis, where its pictures are kept and where they are not.
const FINE: usize = 256;
const COARSE: usize = 40;

/// The picture, once it is clean.
fn keep(studio: &mut Studio, name: &str) {
    settle(studio);
    studio.run_steps(4);
    wait(studio, name, |app| app.state.progress.rests);
    let seen = screenshot(studio, name);
    let three_d = view(studio, "3D");
    assert!(seen.mean(three_d.shrink(0.3 * three_d.width())) > 15.0, "{name}");
}

#[test]
#[ignore = "slow: script/test --all"]
fn ten_pictures() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let is_kept = pictures_folder().is_some();
    let scan = head(folder.path(), if is_kept { FINE } else { COARSE });
    let (mut studio, _) = launch(Settings { has_agreed: true, ..Settings::default() }, is_kept);
    let studio = &mut studio;
    if is_kept {
        let live = studio.state_mut().live_mut().unwrap();
        live.set_samples(512);
        *live.viewport_mut().pace_mut() = Pace::of(false);
        live.set_most_pixels(u32::MAX);
    }
    open(studio, &[&scan]);
    if is_kept {
        wait(studio, "all looks have their pictures", |app| {
            app.state.looks.iter().all(|look| app.has_tile(*look))
        });
    }
    click(studio, "Left");
    keep(studio, "gallery-01-muscle");
    click(studio, "Bone");
    keep(studio, "gallery-02-bone");
    click(studio, "Skin");
    let middle = view(studio, "3D").center();
    drag(studio, PointerButton::Primary, middle, middle + egui::vec2(150.0, 30.0));
    keep(studio, "gallery-03-skin");

    // Four slices and a measurement.
    click(studio, "Muscle");
    settle(studio);
    click(studio, "Front");
    studio.key_press(Key::O);
    studio.state_mut().state.layout = Layout::Grid;
    studio.state_mut().state.take(Tool::Navigate);
    keep(studio, "gallery-04-oblique");
    studio.key_press(Key::O);
    click(studio, "3D and slices");
    studio.key_press(Key::D);
    studio.run_steps(2);
    let axial = view(studio, "Axial").center();
    drag(studio, PointerButton::Primary, axial - egui::vec2(44.0, 0.0), axial + egui::vec2(44.0, 0.0));
    studio.key_press(Key::E);
    let sagittal = view(studio, "Sagittal").center();
    drag(studio, PointerButton::Primary, sagittal - egui::vec2(20.0, 50.0), sagittal + egui::vec2(50.0, 0.0));
    keep(studio, "gallery-05-measured");
    studio.key_press(Key::V);
    studio.state_mut().state.change(Word::Delete, |document| document.measurements.clear());
    studio.state_mut().state.tab = Tab::Look;
    studio.run_steps(2);

    // Cut open, and without skin.
    click(studio, "Bone");
    settle(studio);
    click(studio, "Cut");
    click(studio, "Keep a box");
    keep(studio, "gallery-06-cut");
    click(studio, "Uncut");
    settle(studio);
    studio.state_mut().state.tab = Tab::Look;
    studio.run_steps(2);
    click(studio, "Skin");
    settle(studio);
    click(studio, "Cut");
    studio.state_mut().state.change(Word::Peel, |document| document.volumes[0].peel = Some(9.0));
    keep(studio, "gallery-07-skin-off");
    click(studio, "Uncut");
    settle(studio);
    studio.state_mut().state.tab = Tab::Look;
    studio.run_steps(2);
    click(studio, "Bone");
    settle(studio);

    click(studio, "Structures");
    click(studio, "Find in this scan");
    keep(studio, "gallery-08-structures");
    click(studio, "Share…");
    studio.run_steps(4);
    screenshot(studio, "gallery-09-share");
    click(studio, "Cancel");
    let settings =
        Settings { is_dark: false, language: Language::German, ..studio.state().state.settings.clone() };
    studio.state_mut().state.settings = settings;
    studio.state_mut().state.tab = Tab::Look;
    studio.run_steps(4);
    keep(studio, "gallery-10-german");
    assert_eq!(session(studio).document().volumes[0].scan.keep, Keep::Patient);
}
