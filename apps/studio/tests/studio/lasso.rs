//! The lasso: what is drawn around is cut away, in 3D and through slices, kept in the scene's file, and taken back.

use lumivox_core::Lasso;
use lumivox_core::glam::DVec3;

use super::*;

/// Draws a closed line with the left button.
fn draw(studio: &mut Studio, corners: &[Pos2]) {
    let first = corners[0];
    studio.event(egui::Event::PointerMoved(first));
    studio.step();
    press(studio, first, PointerButton::Primary, true);
    for pair in corners.windows(2) {
        for share in [0.5, 1.0] {
            studio.event(egui::Event::PointerMoved(pair[0] + (pair[1] - pair[0]) * share));
            studio.step();
        }
    }
    press(studio, corners[corners.len() - 1], PointerButton::Primary, false);
    settle(studio);
}

/// The corners of a part of the window.
fn around(part: egui::Rect) -> [Pos2; 4] {
    [part.left_top(), part.right_top(), part.right_bottom(), part.left_bottom()]
}

fn lassos(studio: &Studio) -> Vec<Lasso> {
    session(studio).document().volumes[0].lassos.clone()
}

/// How bright a part of the window is, once the picture is that of what there is to see.
fn seen(studio: &mut Studio, name: &str, part: egui::Rect) -> f64 {
    studio.run_steps(3);
    wait(studio, "the picture rests", |app| app.state.progress.rests);
    screenshot(studio, name).mean(part)
}

#[test]
fn what_a_line_is_drawn_around_is_cut_away() {
    let _alone = alone();
    let (mut studio, answers, folder) = with_head(40);
    let studio = &mut studio;
    click(studio, "Front");
    settle(studio);
    let view_3d = view(studio, "3D");
    // The upper left of the picture: the head's right half above the eyes, and what lies behind that.
    let part = egui::Rect::from_min_max(view_3d.min + egui::vec2(40.0, 30.0), view_3d.center());
    let middle =
        egui::Rect::from_center_size(view_3d.center() - egui::vec2(45.0, 80.0), egui::vec2(30.0, 30.0));
    let before = seen(studio, "40-before-the-lasso", middle);
    let orbit = session(studio).orbit();
    studio.key_press(Key::L);
    studio.run_steps(2);
    // A line around nothing, and one that is given up, cut nothing.
    let at = view_3d.center();
    drag(studio, PointerButton::Primary, at, at + egui::vec2(60.0, 0.0));
    assert!(lassos(studio).is_empty());
    press(studio, at, PointerButton::Primary, true);
    for by in [egui::vec2(40.0, 0.0), egui::vec2(40.0, 40.0), egui::vec2(0.0, 40.0)] {
        studio.event(egui::Event::PointerMoved(at + by));
        studio.step();
    }
    assert!(studio.state().state.lasso.is_some());
    studio.key_press(Key::Escape);
    studio.run_steps(2);
    press(studio, at + egui::vec2(0.0, 40.0), PointerButton::Primary, false);
    studio.run_steps(2);
    assert!(lassos(studio).is_empty() && studio.state().state.tool == lumivox_studio::state::Tool::Lasso);

    draw(studio, &around(part));
    let [lasso] = &lassos(studio)[..] else { panic!("one lasso") };
    assert!(!lasso.parallel && lasso.points.len() >= 4, "{lasso:?}");
    assert_eq!(session(studio).orbit(), orbit, "the view stays");
    let after = seen(studio, "41-cut-by-a-lasso", middle);
    assert!(after < 0.4 * before, "{before} {after}");
    // Half of the head, as deep as it is: nothing of that quarter is left, and all of the others.
    let scene = session(studio).scene().0.clone();
    let instance = &scene.volumes[0];
    let labels = instance.labels.as_ref().unwrap();
    let value = labels.labels.cut_away().unwrap().value;
    let [low, high] = lumivox_studio::slices::bounds_mm(&instance.volume);
    let at = |x: f64, y: f64, z: f64| {
        let point = low + (high - low) * DVec3::new(x, y, z);
        let voxel = instance.volume.patient_from_voxel().inverse().transform_point3(point).round();
        labels.labels.value(voxel.to_array().map(|n| n as usize))
    };
    for depth in [0.1, 0.5, 0.9] {
        assert_eq!(at(0.25, depth, 0.75), value, "the patient's right, at the picture's left");
        assert!(at(0.75, depth, 0.75) != value && at(0.25, depth, 0.25) != value);
    }

    // Turned, it is what was cut; kept is what was cut away, and the other way around.
    click(studio, "Flip");
    settle(studio);
    let flipped = seen(studio, "42-flipped-lasso", middle);
    assert!(lassos(studio)[0].inverted && flipped > 0.7 * before, "{before} {flipped}");
    undo(studio);
    settle(studio);
    assert!(!lassos(studio)[0].inverted);

    // Its file has it, and opens with it.
    let file = folder.path().join("cut.lumivox");
    answers.next(&file);
    studio.key_press_modifiers(Modifiers::COMMAND, Key::S);
    settle(studio);
    let kept = lassos(studio);
    open(studio, &[&file]);
    assert_eq!(lassos(studio), kept);
    let again = seen(studio, "43-opened-again", middle);
    // Handles stand there again.
    assert!(again < 0.6 * before, "{before} {again}");

    // All is there again.
    click(studio, "Cut");
    click(studio, "Uncut");
    settle(studio);
    assert!(lassos(studio).is_empty());
    assert!(session(studio).scene().0.volumes[0].labels.is_none(), "as if nothing had been cut");
    let uncut = seen(studio, "44-uncut", middle);
    assert!((uncut - before).abs() < 0.15 * before, "{before} {uncut}");
}

#[test]
fn a_line_in_a_slice_cuts_square_to_it_and_structures_stay() {
    let _alone = alone();
    let (mut studio, _, _folder) = with_head(32);
    let studio = &mut studio;
    click(studio, "Structures");
    click(studio, "Find in this scan");
    settle(studio);
    let labels =
        |studio: &Studio| session(studio).scene().0.volumes[0].labels.as_ref().unwrap().labels.clone();
    let found = labels(studio);
    studio.key_press(Key::L);
    studio.run_steps(2);
    let axial = view(studio, "Axial");
    let right = egui::Rect::from_min_max(axial.left_top(), axial.center_bottom()).shrink(3.0);
    let bright = seen(studio, "45-before-a-slices-lasso", right);
    draw(studio, &around(right));
    let [lasso] = &lassos(studio)[..] else { panic!("one lasso") };
    assert!(lasso.parallel);
    let cut = labels(studio);
    let value = cut.cut_away().unwrap().value;
    let [nx, ny, nz] = cut.dims();
    for (x, y, z) in [(1, 1, 0), (nx / 4, ny / 2, nz / 2), (nx / 4, ny / 2, nz - 1)] {
        assert_eq!(cut.value([x, y, z]), value, "{x} {y} {z}");
        assert_eq!(cut.value([nx - 1 - x, y, z]), found.value([nx - 1 - x, y, z]));
    }
    assert!(!says(studio, "cut away"), "no structure of the patient's");
    // What was cut is dark in slices.
    let dark = seen(studio, "46-a-slices-lasso", right);
    assert!(dark < 0.6 * bright, "{bright} {dark}");
    click(studio, "Remove");
    settle(studio);
    assert_eq!(labels(studio), found);
}
