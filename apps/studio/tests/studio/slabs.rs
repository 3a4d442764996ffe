//! Slices that are turned, and thick ones.

use lumivox_core::glam::{DAffine3, DVec2, DVec3};
use lumivox_core::{Modality, Volume, Voxels};
use lumivox_studio::slices::{self, Geometry, Plane, Projection, Slab, bounds_mm};
use lumivox_studio::state::{Layout, ViewId};

use super::*;

/// A step of brightness from slice to slice, with one bright and one dark voxel.
fn steps() -> Volume {
    let mut samples: Vec<u16> = (0..9 * 9 * 9).map(|i| 100 + 10 * (i / 81) as u16).collect();
    samples[(3 * 9 + 4) * 9 + 4] = 900;
    samples[(5 * 9 + 4) * 9 + 6] = 0;
    let place = DAffine3::from_scale(DVec3::splat(2.0));
    Volume::new([9; 3], Voxels::U16(samples), [1.0, 0.0], place, Modality::Other).unwrap()
}

#[test]
fn slabs_show_the_largest_the_mean_or_the_smallest_value() {
    let volume = steps();
    let at = |projection, thickness_mm, voxel: [f64; 3]| {
        let slab = Slab { projection, thickness_mm };
        slices::value_at(&volume, DVec3::from_array(voxel) * 2.0, DVec3::Z, slab).unwrap()
    };
    let middle = [2.0, 2.0, 4.0];
    assert_eq!(at(Projection::Thin, 8.0, middle), 140.0);
    // 8 mm are two slices to each side.
    assert_eq!(at(Projection::Maximum, 8.0, middle), 160.0);
    assert_eq!(at(Projection::Minimum, 8.0, middle), 120.0);
    assert_eq!(at(Projection::Mean, 8.0, middle), 140.0);
    assert_eq!(at(Projection::Maximum, 4.0, [4.0, 4.0, 4.0]), 900.0);
    assert_eq!(at(Projection::Minimum, 4.0, [6.0, 4.0, 4.0]), 0.0);
    // The plane itself is always looked at: a slab is never darker than the thin slice.
    assert_eq!(at(Projection::Maximum, 2.0, [4.0, 4.0, 3.0]), 900.0);
    assert_eq!(at(Projection::Minimum, 6.0, [6.0, 4.0, 5.0]), 0.0);
    assert_eq!(
        at(Projection::Maximum, 1.0, [4.0, 4.0, 5.0]),
        152.5,
        "a quarter of a slice is as much of a step"
    );
    // At the scan's edge what is there counts.
    assert_eq!(at(Projection::Mean, 8.0, [2.0, 2.0, 0.0]), 110.0);
    // What is seen is what is told.
    let axes = Plane::Axial.axes();
    let geometry = Geometry::new(&volume, axes, DVec3::splat(8.0), [60, 60], 1.0, DVec2::ZERO);
    let slab = Slab { projection: Projection::Maximum, thickness_mm: 4.0 };
    let image = slices::image(&volume, &geometry, [500.0, 1000.0], slab, None);
    for [x, y] in [[30, 30], [12, 40], [45, 30]] {
        let told =
            slices::value_at(&volume, geometry.point([x as f64 + 0.5, y as f64 + 0.5]), DVec3::Z, slab);
        let seen = f64::from(image.pixels[y * 60 + x].r()) / 255.0 * 1000.0;
        assert!((told.unwrap() - seen).abs() < 3.0, "{told:?} {seen}");
    }
}

#[test]
fn letters_say_where_a_turned_plane_looks() {
    let turned = |degrees: f64| {
        let turn = lumivox_core::glam::DMat3::from_rotation_z(degrees.to_radians());
        slices::edge_letters(Plane::Coronal.axes().map(|axis| turn * axis))
    };
    assert_eq!(turned(0.0), ["R", "L", "H", "F"]);
    assert_eq!(turned(30.0), ["RA", "LP", "H", "F"]);
    assert_eq!(turned(60.0), ["AR", "PL", "H", "F"]);
    assert_eq!(turned(10.0), ["R", "L", "H", "F"]);
}

#[test]
fn an_oblique_slice_is_turned_by_its_handles_and_shares_the_cross() {
    let _alone = alone();
    let (mut studio, answers, folder) = with_head(32);
    let studio = &mut studio;
    click(studio, "Oblique");
    studio.run_steps(2);
    assert!(studio.state().state.shows_oblique && studio.state().state.layout == Layout::Grid);
    let before = studio.state().state.axes(Plane::Oblique);
    assert!(before.iter().zip(Plane::Coronal.axes()).any(|(own, axis)| own.dot(axis) < 0.9), "it is turned");
    // A quarter more by a handle of its line in the axial slice.
    let axial = view(studio, "Axial");
    let state = &studio.state().state;
    let scan = state.session.as_ref().unwrap().scan().clone();
    let size = [axial.width() as usize, axial.height() as usize];
    let geometry = Geometry::new(&scan, Plane::Axial.axes(), state.cross, size, 1.0, DVec2::ZERO);
    let [x, y] = geometry.pixel(state.cross).map(|n| n as f32);
    let cross = axial.min + egui::vec2(x, y);
    let label = "Turn the oblique slice (Axial)";
    let handle = studio.get_all_by_label(label).next().unwrap().rect().center();
    let arm = handle - cross;
    drag(studio, PointerButton::Primary, handle, cross + egui::vec2(-arm.y, arm.x));
    let axes = studio.state().state.axes(Plane::Oblique);
    assert!(axes[2].dot(before[2]).abs() < 0.02, "a quarter turn: {before:?} {axes:?}");
    assert!((axes[1] - before[1]).length() < 1e-6, "about the patient's length");
    // The other way in the sagittal slice: it is tilted, too.
    let label = "Turn the oblique slice (Coronal)";
    let handle = studio.get_all_by_label(label).next().unwrap().rect().center();
    drag(studio, PointerButton::Primary, handle, handle + egui::vec2(40.0, 0.0));
    let axes = studio.state().state.axes(Plane::Oblique);
    assert!((axes[1] - before[1]).length() > 0.05);
    assert!((axes[0].cross(axes[1]) - axes[2]).length() < 1e-9, "never mirrored");
    settle(studio);
    screenshot(studio, "18-oblique");

    // A click lands in the patient to half a voxel, and stays in the plane.
    let oblique = view(studio, "Oblique");
    let state = &studio.state().state;
    let from = state.cross;
    let size = [oblique.width() as usize, oblique.height() as usize];
    let geometry = Geometry::new(&scan, axes, from, size, 1.0, DVec2::ZERO);
    let at = oblique.center() + egui::vec2(-31.0, 22.0);
    click_at(studio, at);
    let hit = studio.state().state.cross;
    let wanted = geometry.point([f64::from(at.x - oblique.min.x), f64::from(at.y - oblique.min.y)]);
    assert!((hit - wanted).length() < 0.5 * scan.spacing_mm().min_element(), "{hit} {wanted}");
    assert!((hit - from).dot(axes[2]).abs() < 1e-6);
    // The value under the pointer is told.
    studio.event(egui::Event::PointerMoved(at + egui::vec2(1.0, 0.0)));
    studio.step();
    studio.step();
    let probe = studio.state().state.probe.unwrap();
    assert!((probe.patient_mm - hit).length() < 2.0 * geometry.mm_per_pixel);
    assert!(says(studio, "HU") && says(studio, "mm"));
    // The wheel goes through slices along the plane's own way.
    studio.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 2.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    studio.run_steps(2);
    let moved = studio.state().state.cross - hit;
    assert!((moved - axes[2] * moved.dot(axes[2])).length() < 1e-9 && moved.length() > 1.0, "{moved}");

    // A scene's file has all of that, though it is no work that would be asked about.
    let state = &mut studio.state_mut().state;
    state.slab = Slab { projection: Projection::Mean, thickness_mm: 7.5 };
    state.window = [300.25, 1200.5];
    let kept = (state.cross, state.axes(Plane::Oblique), state.slab, state.window);
    assert!(!session(studio).has_work());
    let file = folder.path().join("seen.lumivox");
    answers.next(&file);
    studio.key_press_modifiers(Modifiers::COMMAND, Key::S);
    settle(studio);
    click(studio, "Oblique");
    open(studio, &[&file]);
    let state = &studio.state().state;
    assert!(state.shows_oblique);
    assert_eq!((state.cross, state.slab, state.window), (kept.0, kept.2, kept.3));
    assert!(state.axes(Plane::Oblique).iter().zip(kept.1).all(|(own, was)| (*own - was).length() < 1e-9));
    studio.state_mut().state.slab = Slab::default();

    // Two clicks make it fill the window, two more bring all back.
    for wanted in [Layout::One, Layout::Grid] {
        let at = view(studio, "Oblique").center();
        studio.event(egui::Event::PointerMoved(at));
        studio.step();
        // As quick as a hand: frames of tests are a quarter of a second.
        for pressed in [true, false, true, false] {
            let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
            let event = egui::Event::PointerButton { pos: at, button, pressed, modifiers };
            studio.input_mut().events.push(event);
        }
        studio.run_steps(3);
        assert_eq!(studio.state().state.layout, wanted);
        assert_eq!(studio.state().state.active, ViewId::Slice(Plane::Oblique));
    }
    // A slab by its key: a maximum is as bright as the thin slice, or brighter.
    let [low, high] = bounds_mm(&scan);
    let middle = 0.5 * (low + high);
    studio.key_press(Key::S);
    studio.run_steps(2);
    assert_eq!(studio.state().state.slab.projection, Projection::Maximum);
    let slab = studio.state().state.slab;
    let [thick, thin] =
        [slab, Slab::default()].map(|slab| slices::value_at(&scan, middle, DVec3::Z, slab).unwrap());
    assert!(thick >= thin);
    assert!(says(studio, "Slab: MIP"));
    screenshot(studio, "19-slab");
    studio.key_press(Key::O);
    studio.run_steps(2);
    assert!(!studio.state().state.shows_oblique);
}
