//! Looks, cuts, slices, the camera, and the one stack of commands over all of it.

use lumivox_core::document::Keep;
use lumivox_core::glam::{DAffine3, DVec2, DVec3};
use lumivox_core::{Modality, Preset, Volume, Voxels};
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
    let parts: [fn(&mut Studio); 5] = [
        a_look_is_chosen_by_its_tile_and_taken_back,
        a_held_slider_is_one_step_and_so_are_all_turns,
        one_point_is_shared_by_all_views_to_half_a_voxel,
        views_have_room_as_keys_and_clicks_say,
        a_cut_opens_the_scan_in_every_view_and_in_the_file,
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
