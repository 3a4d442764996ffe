//! Looks, cuts, slices, the camera, and the one stack of commands over all of it.

use lumivox_core::document::Keep;
use lumivox_core::glam::{DAffine3, DVec2, DVec3};
use lumivox_core::{Modality, Orbit, Preset, Volume, Voxels};
use lumivox_studio::slices::{self, Geometry, Plane, Slab, bounds_mm};
use lumivox_studio::state::{Layout, ViewId};

use super::*;

/// One program for all of it, as a person would have: the scan is opened anew for each part.
#[test]
fn a_session_of_clicks() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let scan = head(folder.path(), 32);
    let (mut studio, _) = studio();
    let parts: [fn(&mut Studio); 6] = [
        a_look_is_chosen_by_its_tile_and_taken_back,
        a_held_slider_is_one_step_and_so_are_all_turns,
        one_point_is_shared_by_all_views_to_half_a_voxel,
        views_have_room_as_keys_and_clicks_say,
        a_cut_opens_the_scan_in_every_view_and_in_the_file,
        fingers_turn_move_and_zoom,
    ];
    for part in parts {
        studio.state_mut().state.session = None;
        open(&mut studio, &[&scan]);
        part(&mut studio);
    }
}

fn preset(studio: &Studio) -> Option<Preset> {
    session(studio).document().volumes[0].look.preset
}

fn a_look_is_chosen_by_its_tile_and_taken_back(studio: &mut Studio) {
    let first = preset(studio);
    let before = session(studio).scene().1;
    click(studio, "Skin");
    assert_eq!(preset(studio), Some(Preset::CtSkin));
    settle(studio);
    assert_ne!(session(studio).scene().1, before);
    screenshot(studio, "08-skin");
    click(studio, "Undo");
    assert_eq!(preset(studio), first);
    studio.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    studio.run_steps(2);
    assert_eq!(preset(studio), Some(Preset::CtSkin));
    // All that was scanned is another set of voxels, which is found beside the interface.
    click(studio, "All that was scanned");
    settle(studio);
    let keep = session(studio).document().volumes[0].scan.keep;
    assert_eq!(keep, Keep::Everything);
    let session = session(studio);
    assert_eq!(session.scene().0.volumes[0].volume.voxels(), session.scan().voxels(), "nothing is taken out");
}

fn a_held_slider_is_one_step_and_so_are_all_turns(studio: &mut Studio) {
    let document = |studio: &Studio| session(studio).document().clone();
    let start = document(studio);
    let sliders = studio.get_all_by_label("Exposure").map(|node| node.rect());
    let slider = sliders.max_by(|a, b| a.min.x.total_cmp(&b.min.x)).unwrap();
    let at = |share: f32| egui::pos2(slider.left() + share * 100.0, slider.center().y);
    drag(studio, PointerButton::Primary, at(0.6), at(0.95));
    let brighter = document(studio);
    assert_ne!(brighter.display.exposure, start.display.exposure);
    let view = view(studio, "3D");
    for _ in 0..2 {
        drag(studio, PointerButton::Primary, view.center(), view.center() + egui::vec2(60.0, 10.0));
    }
    let turned = document(studio);
    assert_ne!(turned.camera, brighter.camera);
    undo(studio);
    assert_eq!(document(studio), brighter, "both turns are one step");
    undo(studio);
    assert_eq!(document(studio), start, "and the slider another");
    settle(studio);
}

fn one_point_is_shared_by_all_views_to_half_a_voxel(studio: &mut Studio) {
    let scan = session(studio).scan().clone();
    let half = 0.5 * scan.spacing_mm().max_element();
    // In a slice: where a click lands is where it is in the patient.
    let axial = view(studio, "Axial");
    let before = studio.state().state.cross;
    let at = axial.center() + egui::vec2(24.0, -12.0);
    click_at(studio, at);
    let cross = studio.state().state.cross;
    let size = [axial.width() as usize, axial.height() as usize];
    let geometry = Geometry::new(&scan, Plane::Axial.axes(), before, size, 1.0, DVec2::ZERO);
    let wanted = geometry.point([f64::from(at.x - axial.min.x), f64::from(at.y - axial.min.y)]);
    assert!((cross - wanted).length() < half, "{cross} {wanted}");
    assert_eq!(cross.z, before.z, "the slice stays");
    assert!(cross.x > before.x, "to the right is the patient's left");
    assert!(cross.y < before.y, "up is the front");
    // In the picture: the face is hit from the front, on the skin or below it, and never behind the middle.
    let three_d = view(studio, "3D");
    let middle = three_d.center();
    click_at(studio, middle);
    let hit = studio.state().state.cross;
    let [low, high] = bounds_mm(&scan);
    assert!(hit.y < 0.5 * (low.y + high.y), "{hit}");
    assert!(hit.cmpge(low).all() && hit.cmple(high).all());
    settle(studio);
    screenshot(studio, "09-crosshair");
    // The wheel and keys step through slices, one each.
    studio.event(egui::Event::PointerMoved(axial.center()));
    studio.step();
    let z = studio.state().state.cross.z;
    studio.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 1.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    studio.run_steps(2);
    let spacing = scan.spacing_mm().z;
    assert!((studio.state().state.cross.z - z - spacing).abs() < 1e-6, "towards the head");
    studio.key_press(Key::Num2);
    studio.step();
    studio.key_press(Key::ArrowDown);
    studio.run_steps(2);
    assert!((studio.state().state.cross.z - z).abs() < 1e-6, "and back");
}

fn views_have_room_as_keys_and_clicks_say(studio: &mut Studio) {
    let area = |studio: &Studio, name: &str| {
        let all = studio.query_all_by_label(name).map(|node| node.rect().area());
        all.fold(0.0_f32, f32::max)
    };
    assert!(area(studio, "3D") > 3.0 * area(studio, "Axial"));
    click(studio, "Four views");
    assert_eq!(studio.state().state.layout, Layout::Grid);
    assert!((area(studio, "3D") / area(studio, "Axial") - 1.0).abs() < 0.02);
    settle(studio);
    screenshot(studio, "10-four-views");
    studio.key_press(Key::Num3);
    studio.step();
    studio.key_press(Key::Space);
    studio.run_steps(2);
    assert_eq!(
        (studio.state().state.layout, studio.state().state.active),
        (Layout::One, ViewId::Slice(Plane::Coronal))
    );
    assert!(area(studio, "Coronal") > 100_000.0 && area(studio, "Axial") == 0.0);
    screenshot(studio, "11-coronal");
    studio.key_press(Key::Space);
    studio.run_steps(2);
    assert_eq!(studio.state().state.layout, Layout::Grid);
    click(studio, "3D and slices");
    assert_eq!(studio.state().state.layout, Layout::Main);
}

fn a_cut_opens_the_scan_in_every_view_and_in_the_file(studio: &mut Studio) {
    click(studio, "Cut");
    let rect = studio.get_all_by_label("From the front").map(|node| node.rect());
    let slider = rect.max_by(|a, b| a.min.x.total_cmp(&b.min.x)).unwrap();
    let at = |x: f32| egui::pos2(slider.left() + x, slider.center().y);
    drag(studio, PointerButton::Primary, at(9.0), at(50.0));
    let clip = session(studio).document().volumes[0].clip.unwrap();
    // The front is where y of the patient is least.
    assert!(clip[0][1] > 0.15 && clip[1] == [1.0; 3] && clip[0][0] == 0.0, "{clip:?}");
    settle(studio);
    screenshot(studio, "12-cut");
    click(studio, "Cut by a plane that faces me");
    let document = session(studio).document().clone();
    assert_eq!(document.volumes[0].clip_shapes.len(), 1);
    let opened = session(studio);
    let forward = -opened.camera().world_from_camera.matrix3.z_axis;
    let scan_center = opened.center();
    let shape = opened.scene().0.volumes[0].clip_shapes[0];
    let to_shape =
        shape.patient_from_shape.inverse() * opened.scene().0.volumes[0].world_from_patient.inverse();
    // A plane keeps where its z is 0 and more.
    let side = |metres: f64| to_shape.transform_point3(scan_center + forward * metres).z;
    assert!(side(0.5) > 0.0 && side(-0.5) < 0.0, "what is before is cut, what is behind kept");
    click(studio, "Uncut");
    let document = session(studio).document();
    assert!(document.volumes[0].clip.is_none() && document.volumes[0].clip_shapes.is_empty());
    click(studio, "Look");
    settle(studio);
}

#[test]
fn slices_are_radiological_and_true() {
    // A voxel of its own at the patient's right, front and head.
    let mut samples = vec![0_u16; 9 * 9 * 9];
    let index = |x: usize, y: usize, z: usize| (z * 9 + y) * 9 + x;
    samples[index(1, 1, 7)] = 1000;
    let place = DAffine3::from_scale(DVec3::splat(10.0));
    let volume = Volume::new([9; 3], Voxels::U16(samples), [1.0, 0.0], place, Modality::Other).unwrap();
    let through = DVec3::new(10.0, 10.0, 70.0);
    for (plane, right, down) in
        [(Plane::Axial, false, false), (Plane::Coronal, false, false), (Plane::Sagittal, false, false)]
    {
        let geometry = Geometry::new(&volume, plane.axes(), through, [101, 101], 1.0, DVec2::ZERO);
        let image = slices::image(&volume, &geometry, [500.0, 1000.0], Slab::default(), None);
        let brightest = (0..image.pixels.len()).max_by_key(|i| image.pixels[*i].r()).unwrap();
        let [x, y] = [brightest % 101, brightest / 101];
        assert_eq!((x > 50, y > 50), (right, down), "{plane:?}: {x} {y}");
        assert!(image.pixels[brightest].r() > 230 && image.pixels[0].a() == 0, "outside is clear");
        let found = geometry.point([x as f64 + 0.5, y as f64 + 0.5]);
        assert!((found - through).abs().max_element() < 5.0, "{plane:?}: {found}");
        let [px, py] = geometry.pixel(through);
        assert!((px - x as f64 - 0.5).abs() < 5.0 && (py - y as f64 - 0.5).abs() < 5.0);
    }
    assert_eq!(slices::edge_letters(Plane::Axial.axes()), ["R", "L", "A", "P"]);
    assert_eq!(slices::edge_letters(Plane::Coronal.axes()), ["R", "L", "H", "F"]);
    assert_eq!(slices::edge_letters(Plane::Sagittal.axes()), ["A", "P", "H", "F"]);
    let ct = volume.clone().with_modality(Modality::Ct).with_unit("HU");
    assert_eq!(slices::window_for(&ct), [40.0, 400.0]);
    let [level, width] = slices::window_for(&volume);
    assert!(level.is_finite() && width > 0.0);
}

/// Fingers at these places, each where it is in every frame.
fn fingers(studio: &mut Studio, frames: &[&[Pos2]]) {
    let touch = |studio: &mut Studio, id: usize, phase: egui::TouchPhase, pos: Pos2| {
        let id = egui::TouchId::from(id as u64);
        studio.event(egui::Event::Touch { device_id: egui::TouchDeviceId(0), id, phase, pos, force: None });
        // As windows tell of the first finger.
        if id == egui::TouchId::from(0_u64) {
            studio.event(egui::Event::PointerMoved(pos));
            if phase != egui::TouchPhase::Move {
                let pressed = phase == egui::TouchPhase::Start;
                let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
                studio.event(egui::Event::PointerButton { pos, button, pressed, modifiers });
            }
        }
    };
    let phases = std::iter::once(egui::TouchPhase::Start).chain(std::iter::repeat(egui::TouchPhase::Move));
    for (places, phase) in frames.iter().zip(phases) {
        places.iter().enumerate().for_each(|(id, at)| touch(studio, id, phase, *at));
        studio.step();
    }
    let last = frames.last().unwrap().iter().enumerate();
    last.for_each(|(id, at)| touch(studio, id, egui::TouchPhase::End, *at));
    studio.event(egui::Event::PointerGone);
    studio.run_steps(2);
}

fn fingers_turn_move_and_zoom(studio: &mut Studio) {
    use eframe::egui::vec2;
    let at = view(studio, "3D").center();
    let orbit = |studio: &Studio| session(studio).orbit();
    let pair = |half: egui::Vec2, by: egui::Vec2| [at - half + by, at + half + by];
    // Apart: as much larger.
    let start = orbit(studio);
    let frames = [60.0, 75.0, 90.0].map(|half| pair(vec2(half, 0.0), vec2(0.0, 0.0)));
    fingers(studio, &frames.each_ref().map(|places| &places[..]));
    let zoomed = orbit(studio);
    assert!((start.distance / zoomed.distance - 1.5).abs() < 0.02, "{start:?} {zoomed:?}");
    // Windows tell of one finger after the other, between which what is seen moves a little.
    let stays =
        |a: Orbit, b: Orbit| (a.azimuth - b.azimuth).abs() < 1e-3 && a.target.distance(b.target) < 3e-3;
    assert!(stays(start, zoomed), "{start:?} {zoomed:?}");
    // Together: moved.
    let frames = [0.0, 15.0, 30.0].map(|by| pair(vec2(60.0, 0.0), vec2(by, 0.0)));
    fingers(studio, &frames.each_ref().map(|places| &places[..]));
    let moved = orbit(studio);
    assert!(
        (moved.distance - zoomed.distance).abs() < 1e-6 && (moved.target - zoomed.target).length() > 1e-3
    );
    // About each other: turned by as much.
    let frames = [0.0_f32, 0.15, 0.3].map(|turn| pair(egui::Vec2::angled(turn) * 60.0, vec2(0.0, 0.0)));
    fingers(studio, &frames.each_ref().map(|places| &places[..]));
    let turned = orbit(studio);
    let by = (moved.azimuth - turned.azimuth).rem_euclid(std::f64::consts::TAU);
    assert!((by - 0.3).abs() < 0.01 && (turned.distance / moved.distance - 1.0).abs() < 0.01, "{by}");
    // One finger: as the left button.
    fingers(studio, &[&[at], &[at + vec2(40.0, 0.0)], &[at + vec2(80.0, 0.0)]]);
    assert!((orbit(studio).azimuth - turned.azimuth).abs() > 0.1);

    // In slices one finger leafs, and two zoom and move.
    let at = view(studio, "Axial").center();
    let (cross, window) = (studio.state().state.cross, studio.state().state.window);
    fingers(studio, &[&[at], &[at - vec2(0.0, 20.0)], &[at - vec2(0.0, 40.0)]]);
    let by = studio.state().state.cross - cross;
    assert!(by.z > 1.0 && by.x == 0.0 && by.y == 0.0, "{by}");
    assert_eq!(studio.state().state.window, window);
    let slice = |studio: &Studio| {
        let own = &studio.state().state.slices[Plane::Axial.index()];
        (own.zoom, own.moved)
    };
    let pair = |half: f32, by: f32| [at + vec2(by - half, 0.0), at + vec2(by + half, 0.0)];
    let frames = [pair(30.0, 0.0), pair(45.0, 10.0), pair(60.0, 20.0)];
    fingers(studio, &frames.each_ref().map(|places| &places[..]));
    let (zoom, moved) = slice(studio);
    assert!((zoom - 2.0).abs() < 0.05 && moved.x > 0.0 && moved.y.abs() < 1e-6, "{zoom} {moved}");
    assert_eq!(studio.state().state.window, window);
    // Two that only touch place nothing, and one does.
    let (cross, layout) = (studio.state().state.cross, studio.state().state.layout);
    for _ in 0..2 {
        let touch = pair(30.0, 12.0);
        fingers(studio, &[&touch, &touch]);
    }
    assert_eq!((studio.state().state.cross, studio.state().state.layout), (cross, layout));
    fingers(studio, &[&[at + vec2(20.0, 5.0)]]);
    assert_ne!(studio.state().state.cross, cross);
    settle(studio);
}
