//! The curve of opacity and colour, the light, and the look by dragging over the picture.

use lumivox_core::EnvironmentMap;
use lumivox_core::document::{Entry, Lighting, SceneDocument};
use lumivox_core::glam::DVec3;
use lumivox_studio::state::CurvePoint;

use super::*;

fn document(studio: &Studio) -> SceneDocument {
    session(studio).document().clone()
}

fn first(studio: &Studio) -> Entry {
    document(studio).volumes[0].clone()
}

/// Where something is that is spoken of by that name; it is scrolled to.
fn place(studio: &mut Studio, label: &str) -> egui::Rect {
    studio.get_all_by_label(label).last().unwrap().scroll_to_me();
    studio.run_steps(4);
    studio.get_all_by_label(label).last().unwrap().rect()
}

#[test]
fn the_curve_is_dragged_over_the_histogram() {
    let _alone = alone();
    let (mut studio, _, _folder) = with_head(32);
    let studio = &mut studio;
    let start = document(studio);
    let shown = |studio: &Studio| {
        let session = session(studio);
        session.scene().0.volumes[0].medium.transfer_function.clone()
    };
    let before = shown(studio);
    let last = before.opacity_knots().len();
    let label = format!("Opacity point {last}");
    let point = place(studio, &label).center();
    drag(studio, PointerButton::Primary, point, point + egui::vec2(40.0, 25.0));
    let after = shown(studio);
    let [old, new] = [&before, &after].map(|function| function.opacity_knots()[last - 1]);
    assert!(new.opacity < old.opacity - 0.1 && new.value > old.value + 100.0, "{old:?} {new:?}");
    assert_eq!(before.opacity_knots()[..last - 1], after.opacity_knots()[..last - 1], "others stay");
    assert_eq!(before.color_stops(), after.color_stops());
    assert_eq!(first(studio).look.preset, start.volumes[0].look.preset, "the rest is the look's");
    assert_eq!(studio.state().state.curve_point, Some(CurvePoint::Opacity(last - 1)));
    // A point stays between its neighbours.
    let point = place(studio, &label).center();
    drag(studio, PointerButton::Primary, point, point - egui::vec2(200.0, 0.0));
    let knots = shown(studio).opacity_knots().to_vec();
    assert_eq!(knots[last - 1].value, knots[last - 2].value);
    settle(studio);
    screenshot(studio, "20-curve");
    // Each drag is a step.
    undo(studio);
    assert_eq!(shown(studio), after);
    undo(studio);
    assert_eq!(document(studio), start);
    // Points come and go.
    click(studio, "Add point");
    assert_eq!(shown(studio).opacity_knots().len(), before.opacity_knots().len() + 1);
    click(studio, "Remove point");
    assert_eq!(shown(studio).opacity_knots(), before.opacity_knots());
    let at = place(studio, "Opacity point 3").center();
    click_with(studio, at, PointerButton::Secondary);
    assert_eq!(shown(studio).opacity_knots().len(), before.opacity_knots().len() - 1);
    click(studio, "Add colour");
    assert_eq!(shown(studio).color_stops().len(), before.color_stops().len() + 1);
    let last = before.color_stops().len();
    let stop = place(studio, &format!("Colour point {}", last + 1)).center();
    drag(studio, PointerButton::Primary, stop, stop + egui::vec2(20.0, 0.0));
    assert!(shown(studio).color_stops()[last].value > before.color_stops()[last - 1].value + 50.0);
    // A look's tile begins anew.
    let panel = place(studio, "Width").center();
    studio.event(egui::Event::PointerMoved(panel));
    studio.step();
    studio.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 50.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    studio.run_steps(8);
    click(studio, "Bone");
    assert!(first(studio).look.transfer_function.is_none());
    settle(studio);
}

#[test]
fn the_look_is_shifted_and_widened_over_the_picture() {
    let _alone = alone();
    let (mut studio, _, _folder) = with_head(32);
    let studio = &mut studio;
    let start = document(studio);
    let at = view(studio, "3D").center();
    click(studio, "Shift and width");
    drag(studio, PointerButton::Primary, at, at + egui::vec2(80.0, 40.0));
    let look = first(studio).look;
    assert!(look.shift.unwrap() > 20.0 && look.window_scale.unwrap() > 1.02, "{look:?}");
    assert_eq!(document(studio).camera, start.camera, "the camera stays");
    undo(studio);
    assert_eq!(document(studio), start, "one drag is one step");
    // With Alt whatever the tool.
    studio.key_press(Key::Escape);
    studio.run_steps(2);
    let alt = Modifiers::ALT;
    studio.input_mut().modifiers = alt;
    studio.event(egui::Event::PointerMoved(at));
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: alt,
    };
    studio.event(button(at, true));
    studio.step();
    for x in [20.0, 40.0, 60.0] {
        studio.event(egui::Event::PointerMoved(at - egui::vec2(x, 0.0)));
        studio.step();
    }
    studio.event(button(at - egui::vec2(60.0, 0.0), false));
    studio.step();
    studio.input_mut().modifiers = Modifiers::NONE;
    studio.run_steps(2);
    assert!(first(studio).look.shift.unwrap() < -20.0);
    assert_eq!(document(studio).camera, start.camera);
    settle(studio);
}

#[test]
fn light_comes_from_a_panorama_in_a_file() {
    let _alone = alone();
    let (mut studio, answers, folder) = with_head(24);
    let studio = &mut studio;
    let start = document(studio);
    // Red from above, hardly anything from below.
    let texels = (0..16 * 8).map(|i| if i < 64 { [6.0, 0.5, 0.2] } else { [0.01; 3] }).collect();
    let map = EnvironmentMap::new(16, 8, texels).unwrap();
    let [file, wrong] = ["sunset.exr", "wrong.hdr"].map(|name| folder.path().join(name));
    lumivox_import::save_environment(&file, &map).unwrap();
    std::fs::write(&wrong, "no panorama").unwrap();
    let redness = |seen: Seen, rect: egui::Rect| {
        let mut colors = (0..40).map(|i| seen.color(rect.center() + egui::vec2(i as f32 - 20.0, 0.0)));
        colors.by_ref().map(|[red, _, blue, _]| i32::from(red) - i32::from(blue)).sum::<i32>() / 40
    };
    let rect = view(studio, "3D");
    let plain = redness(screenshot(studio, "24-light-plain"), rect);
    place(studio, "Panorama…");
    answers.next(&file);
    click(studio, "Panorama…");
    settle(studio);
    assert_eq!(studio.state().state.failed, None);
    assert_eq!(document(studio).environment.source, file);
    let is_map = |studio: &Studio| {
        matches!(session(studio).scene().0.environment.source, lumivox_core::EnvironmentSource::Map(_))
    };
    assert!(is_map(studio) && says(studio, "sunset.exr"));
    let red = redness(screenshot(studio, "24-light-of-a-file"), rect);
    assert!(red > plain + 30, "{plain} {red}");
    undo(studio);
    settle(studio);
    assert!(!is_map(studio) && document(studio) == start);
    studio.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    settle(studio);
    assert!(is_map(studio));
    // What is no panorama is told by its name, and the light stays.
    answers.next(&wrong);
    click(studio, "Panorama…");
    wait(studio, "it is told", |app| app.state.failed.is_some());
    assert!(says(studio, "wrong.hdr"), "{:?}", texts(studio));
    click(studio, "Close");
    settle(studio);
    assert!(is_map(studio) && document(studio).environment.source == file);
}

#[test]
fn the_key_light_follows_the_ball() {
    let _alone = alone();
    let (mut studio, _, _folder) = with_head(32);
    let studio = &mut studio;
    let start = document(studio);
    assert!(start.lights.is_empty());
    let from = |studio: &Studio| {
        let session = session(studio);
        let axes = session.camera().world_from_camera.matrix3;
        match session.document().lights[..] {
            [Lighting::Sun { direction, .. }] => axes.transpose() * -DVec3::from_array(direction),
            _ => panic!("one light from afar"),
        }
    };
    let ball = place(studio, "Direction of the key light");
    let reach = 0.5 * ball.width();
    drag(
        studio,
        PointerButton::Primary,
        ball.center(),
        ball.center() + egui::vec2(0.6 * reach, -0.5 * reach),
    );
    let light = from(studio);
    assert!((light - DVec3::new(0.6, 0.5, 0.39_f64.sqrt())).length() < 0.03, "{light}");
    settle(studio);
    screenshot(studio, "21-key-light");
    let lit = document(studio);
    // Over the edge it comes from behind.
    let at = ball.center() + egui::vec2(-1.4 * reach, 0.0);
    drag(studio, PointerButton::Primary, ball.center() + egui::vec2(0.5 * reach, 0.0), at);
    let light = from(studio);
    assert!((light - DVec3::new(-0.6, 0.0, -0.8)).length() < 0.03, "{light}");
    undo(studio);
    assert_eq!(document(studio), lit);
    // By keys, two degrees a time.
    let before = from(studio);
    studio.get_by_label("Direction of the key light").focus();
    studio.run_steps(2);
    studio.key_press(Key::ArrowRight);
    studio.run_steps(2);
    let by = from(studio).angle_between(DVec3::Y).to_degrees() - before.angle_between(DVec3::Y).to_degrees();
    let turned = from(studio).angle_between(before).to_degrees();
    assert!(by.abs() < 0.1 && (1.0..2.1).contains(&turned) && from(studio).x > before.x, "{by} {turned}");
    undo(studio);
    // It stands in the world: from the other side of the patient it comes from behind.
    click(studio, "Back");
    studio.run_steps(2);
    assert!(from(studio).z < -0.3);
    undo(studio);
    place(studio, "Key light");
    click(studio, "Key light");
    assert!(document(studio).lights.is_empty());
    place(studio, "Even");
    click(studio, "Even");
    assert_eq!(document(studio).environment.source, PathBuf::from("uniform"));
    settle(studio);
    for _ in 0..3 {
        undo(studio);
    }
    assert_eq!(document(studio), start);
    settle(studio);
}
