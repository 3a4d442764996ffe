//! Cuts by handles in the picture, and the cube that says how the patient is turned.

use lumivox_core::ClipKind;
use lumivox_core::document::{Entry, Shape, affine};

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
    assert!((handle(studio, 2) - to).length() < 0.35 * (to - from).length(), "it follows the pointer");
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
}
