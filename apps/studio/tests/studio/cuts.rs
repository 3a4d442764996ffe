//! Cuts by handles in the picture, and the cube that says how the patient is turned.

use lumivox_core::document::{Entry, Shape, affine, world_rows};
use lumivox_core::glam::{DAffine3, DVec2, DVec3};
use lumivox_core::{ClipKind, Modality, Volume, Voxels};
use lumivox_studio::slices::{self, Geometry, Plane};
use lumivox_studio::words::Word;

use eframe::egui::accesskit::Role;

use super::*;

fn first(studio: &Studio) -> Entry {
    session(studio).document().volumes[0].clone()
}

fn handle(studio: &Studio, number: usize) -> egui::Pos2 {
    studio.get_by_label(&format!("Cut handle {number}")).rect().center()
}

fn last(studio: &Studio) -> Shape {
    *first(studio).clip_shapes.last().unwrap()
}

#[test]
fn cuts_are_dragged_in_the_picture() {
    let _alone = alone();
    let (mut studio, _, _folder) = with_head(32);
    let studio = &mut studio;
    // From half the side, so that nothing points at the eye.
    let middle = view(studio, "3D").center();
    drag(studio, PointerButton::Primary, middle, middle + egui::vec2(-120.0, 60.0));
    studio.key_press(Key::Minus);
    studio.run_steps(2);
    click(studio, "Cut");
    // The scan's own box, by its high face along the first axis: the patient's left.
    let from = handle(studio, 2);
    let to = from + (middle - from) * 0.45;
    drag(studio, PointerButton::Primary, from, to);
    let [low, high] = first(studio).clip.unwrap();
    assert!(high[0] < 0.9 && high[1..] == [1.0; 2] && low == [0.0; 3], "{low:?} {high:?}");
    assert!((handle(studio, 2) - to).length() < 0.3 * (to - from).length(), "it follows the pointer");
    settle(studio);
    screenshot(studio, "22-cut-handles");
    undo(studio);
    assert!(first(studio).clip.is_none(), "one drag is one step");

    // A ball: first its centre, then its edge.
    click(studio, "Cut out a ball");
    let before = affine(last(studio).from_shape);
    assert!(last(studio).kind == ClipKind::Sphere && last(studio).inverted);
    let (center, edge) = (handle(studio, 7), handle(studio, 8));
    drag(studio, PointerButton::Primary, edge, edge + (edge - center));
    let grown = affine(last(studio).from_shape);
    let factor = grown.matrix3.x_axis.length() / before.matrix3.x_axis.length();
    assert!((factor - 2.0).abs() < 0.05 && grown.translation == before.translation, "{factor}");
    drag(studio, PointerButton::Primary, center, center + egui::vec2(30.0, -20.0));
    assert!((handle(studio, 7) - center - egui::vec2(30.0, -20.0)).length() < 1.0);
    assert!(
        (affine(last(studio).from_shape).matrix3.x_axis.length() - grown.matrix3.x_axis.length()).abs()
            < 1e-9
    );
    click(studio, "Remove");
    assert!(first(studio).clip_shapes.is_empty());

    // Wherever it is taken, it keeps its place under the pointer.
    click(studio, "Cut out a ball");
    let center = handle(studio, 7);
    let beside = center + egui::vec2(6.0, -5.0);
    drag(studio, PointerButton::Primary, beside, beside + egui::vec2(24.0, 8.0));
    assert!((handle(studio, 7) - center - egui::vec2(24.0, 8.0)).length() < 0.5);
    // By keys as well, a point at a time, and ten with Shift; the view stays where it is.
    let (from, orbit) = (handle(studio, 7), session(studio).orbit());
    studio.get_by_label("Cut handle 7").focus();
    studio.run_steps(2);
    studio.key_press_modifiers(Modifiers::SHIFT, Key::ArrowRight);
    studio.key_press(Key::ArrowUp);
    studio.run_steps(3);
    assert!((handle(studio, 7) - from - egui::vec2(10.0, -1.0)).length() < 0.5);
    assert_eq!(session(studio).orbit(), orbit);
    click(studio, "Remove");

    // A box keeps what is within; its other face stays.
    click(studio, "Keep a box");
    let before = affine(last(studio).from_shape);
    let (center, face) = (handle(studio, 13), handle(studio, 8));
    drag(studio, PointerButton::Primary, face, face + (center - face) * 0.5);
    let after = affine(last(studio).from_shape);
    let ends = |placed: lumivox_core::glam::DAffine3| {
        [-1.0, 1.0].map(|end| placed.translation + placed.matrix3.x_axis * end)
    };
    assert!((ends(after)[0] - ends(before)[0]).length() < 1e-6, "{before:?} {after:?}");
    assert!(after.matrix3.x_axis.length() < 0.9 * before.matrix3.x_axis.length());
    click(studio, "Remove");

    // A plane: its arrow tilts it about its point, its middle goes along its normal.
    click(studio, "Cut by a plane that faces me");
    drag(studio, PointerButton::Primary, middle + egui::vec2(90.0, 200.0), middle + egui::vec2(190.0, 200.0));
    let before = affine(last(studio).from_shape);
    let tip = handle(studio, 8);
    drag(studio, PointerButton::Primary, tip, tip + egui::vec2(0.0, -50.0));
    let tilted = affine(last(studio).from_shape);
    assert!((tilted.translation - before.translation).length() < 1e-6);
    let cosine = tilted.matrix3.z_axis.dot(before.matrix3.z_axis);
    assert!((0.2..0.99).contains(&cosine), "{cosine}");
    let point = handle(studio, 7);
    let along = (handle(studio, 8) - point) * 0.5;
    drag(studio, PointerButton::Primary, point, point + along);
    let moved = affine(last(studio).from_shape);
    let by = moved.translation - tilted.translation;
    assert!(
        by.cross(tilted.matrix3.z_axis).length() < 1e-6 * by.length().max(1.0) && by.length() > 3.0,
        "{by}"
    );
    settle(studio);
    screenshot(studio, "23-tilted-plane");
    click(studio, "Uncut");
    assert!(first(studio).clip_shapes.is_empty());
    settle(studio);
}

#[test]
fn skin_is_taken_off_by_millimetres() {
    let _alone = alone();
    let (mut studio, _, _folder) = with_head(32);
    let studio = &mut studio;
    click(studio, "Cut");
    studio.get_by_role_and_label(Role::Slider, "Skin off").focus();
    studio.run_steps(2);
    studio.key_press(Key::ArrowRight);
    settle(studio);
    let peel = |studio: &Studio| session(studio).scene().0.volumes[0].peel.clone();
    let wanted = first(studio).peel.unwrap();
    let shown = peel(studio).expect("how deep its points lie");
    assert!(wanted > 0.0 && shown.mm == wanted, "{wanted} {}", shown.mm);
    // Once that is known, how much is taken off is a number: nothing is looked for.
    studio.get_by_role_and_label(Role::Slider, "Skin off").focus();
    studio.key_press(Key::ArrowRight);
    studio.run_steps(2);
    let deeper = peel(studio).unwrap();
    assert!(studio.state().is_quiet() && deeper.mm > shown.mm && deeper.mm == first(studio).peel.unwrap());
    assert!(Arc::ptr_eq(&deeper.depth, &shown.depth));
    settle(studio);
    screenshot(studio, "24-skin-off");
    undo(studio);
    settle(studio);
    click(studio, "Uncut");
    settle(studio);
    assert!(first(studio).peel.is_none() && peel(studio).is_none_or(|peel| !peel.is_active()));
    // Taken off again it is there at once.
    undo(studio);
    assert!(studio.state().is_quiet() && peel(studio).unwrap().is_active());
}

#[test]
fn a_click_on_the_cube_turns_to_that_side() {
    let _alone = alone();
    let (mut studio, _, _folder) = with_head(32);
    let studio = &mut studio;
    click(studio, "Front");
    let orbit = |studio: &Studio| session(studio).orbit();
    let three_d = view(studio, "3D");
    // Dragged to the left, the patient's left comes to the front: the camera goes around to it.
    drag(studio, PointerButton::Primary, three_d.center(), three_d.center() - egui::vec2(150.0, 0.0));
    let turned = orbit(studio);
    assert!((0.3..1.2).contains(&turned.azimuth), "{turned:?}");
    let cube = studio.get_by_label("Orientation cube").rect();
    let on_left = egui::vec2(25.0 * turned.azimuth.cos() as f32, 0.0);
    click_at(studio, cube.center() + on_left);
    let found = orbit(studio);
    assert!((found.azimuth - std::f64::consts::FRAC_PI_2).abs() < 1e-6 && found.elevation.abs() < 1e-6);
    assert!((found.distance - turned.distance).abs() < 1e-6, "as near as before");
    // Never mirrored: seen from the patient's left, the face looks to the left.
    let camera = session(studio).camera().world_from_camera.matrix3;
    assert!(camera.determinant() > 0.999 && camera.x_axis.z < -0.999, "{camera}");
    settle(studio);
    screenshot(studio, "24-cube");

    // Its sides are the patient's, however that lies in the world, and so are those that buttons frame.
    let placed = session(studio).scene().0.volumes[0].world_from_patient;
    let turned = world_rows(DAffine3::from_rotation_y(1.0) * placed);
    studio.state_mut().state.change(Word::Camera, |document| {
        document.volumes[0].world_from_patient = Some(turned);
    });
    studio.run_steps(2);
    for (button, side) in [("Left", DVec3::X), ("Front", DVec3::NEG_Y), ("Above", DVec3::Z)] {
        click(studio, button);
        let opened = session(studio);
        let towards_eye = opened.camera().world_from_camera.matrix3.z_axis;
        let patient = opened.scene().0.volumes[0].world_from_patient.matrix3.inverse() * towards_eye;
        assert!((patient.normalize() - side).length() < 0.011, "{button}: {patient}");
        let before = orbit(studio);
        click_at(studio, cube.center());
        let [old, new] = [before, orbit(studio)].map(|it| [it.azimuth, it.elevation]);
        assert!((0..2).all(|i| (old[i] - new[i]).abs() < 1e-6), "{button}: {old:?} {new:?}");
    }
}

#[test]
fn a_cut_that_changes_is_changed_in_the_scans_that_have_it() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    head(folder.path(), 24);
    let scene = folder.path().join("two.lumivox");
    let entry = r#"{"scan": {"files": ["scan"]}}"#;
    std::fs::write(&scene, format!(r#"{{"lumivox_scene": 1, "volumes": [{entry}, {entry}]}}"#)).unwrap();
    let (mut studio, _) = studio();
    open(&mut studio, &[&scene]);
    let studio = &mut studio;
    let cuts =
        |studio: &Studio| [0, 1].map(|scan| session(studio).document().volumes[scan].clip_shapes.clone());
    click(studio, "Cut");
    click(studio, "Cut by a plane that faces me");
    // Of the second scan somebody took it away.
    studio.state_mut().state.change(Word::Cut, |document| document.volumes[1].clip_shapes.clear());
    studio.run_steps(2);
    click(studio, "Flip");
    let [first, second] = cuts(studio);
    assert!(first[0].inverted && second.is_empty(), "{second:?}");
    // Another cuts both, and is changed in both.
    click(studio, "Cut out a ball");
    assert_eq!(cuts(studio).map(|cuts| cuts.len()), [2, 1]);
    click(studio, "Flip");
    let [first, second] = cuts(studio);
    assert!(first[0].inverted && first[1] == second[0] && !second[0].inverted, "{first:?} {second:?}");
    click(studio, "Remove");
    assert_eq!(cuts(studio).map(|cuts| cuts.len()), [1, 0]);
}

#[test]
fn what_a_cut_leaves_of_a_slice_lies_in_the_scan_however_that_is_turned() {
    let turn = DAffine3::from_axis_angle(DVec3::new(0.2, -0.1, 1.0).normalize(), 0.6);
    let place = turn * DAffine3::from_scale(DVec3::new(1.0, 2.0, 3.0));
    let volume = Volume::new([20; 3], Voxels::U8(vec![0; 8000]), [1.0, 0.0], place, Modality::Other).unwrap();
    let kept = [[0.2, 0.0, 0.1], [0.9, 0.5, 1.0]];
    let center = volume.patient_from_box().transform_point3(DVec3::new(0.5, 0.3, 0.5));
    for plane in [Plane::Axial, Plane::Coronal, Plane::Sagittal] {
        let at = |point| Geometry::new(&volume, plane.axes(), point, [100, 100], 1.0, DVec2::ZERO);
        let geometry = at(center);
        let corners = slices::outline(&volume, kept, &geometry);
        assert!((3..=6).contains(&corners.len()), "{corners:?}");
        // In the plane, on a face of what is kept, around in one sense.
        let box_from_patient = volume.patient_from_box().inverse();
        for (place, corner) in corners.iter().enumerate() {
            assert!(geometry.distance_mm(*corner) < 1e-9);
            let within = box_from_patient.transform_point3(*corner);
            let reach = (0..3).map(|axis| (within[axis] - kept[0][axis]).min(kept[1][axis] - within[axis]));
            assert!(reach.fold(f64::INFINITY, f64::min).abs() < 1e-9, "{within}");
            let [next, after] = [1, 2].map(|by| corners[(place + by) % corners.len()]);
            let bend = (next - *corner).cross(after - next).dot(geometry.axes[0].cross(geometry.axes[1]));
            assert!(bend > 0.0, "{plane:?}: {bend}");
        }
        let beside = at(center + plane.axes()[2] * 500.0);
        assert!(slices::outline(&volume, kept, &beside).is_empty());
    }
}
