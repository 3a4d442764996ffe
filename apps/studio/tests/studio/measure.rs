//! Measurements: what is read off a phantom of known size, in slices and in 3D.

use eframe::egui::accesskit::Role;
use lumivox_core::document::{Measured, Measurement, MeasurementKind};
use lumivox_core::glam::{DAffine3, DVec2, DVec3};
use lumivox_core::{Modality, Volume, Voxels};
use lumivox_studio::measuring;
use lumivox_studio::slices::{Geometry, Plane, Projection, Slab};
use lumivox_studio::state::Tool;

use super::*;

/// Voxels of the block in the phantom, along each axis.
const BLOCK: [std::ops::Range<usize>; 3] = [12..36, 10..34, 8..24];

/// A block of bone in air: in turn 900 and 1100 HU, in voxels of 2 x 2 x 3 mm.
fn block(folder: &Path) -> PathBuf {
    let dims = [48, 44, 32];
    let value = |i: usize| {
        let at = [i % 48, i / 48 % 44, i / 2112];
        let is_inside = (0..3).all(|axis| BLOCK[axis].contains(&at[axis]));
        let of_block = if at.iter().sum::<usize>() % 2 == 0 { 900 } else { 1100 };
        (1024 + if is_inside { of_block } else { -1000 }) as u16
    };
    let place = DAffine3::from_scale(DVec3::new(2.0, 2.0, 3.0));
    let samples = Voxels::U16((0..dims.iter().product()).map(value).collect());
    let volume = Volume::new(dims, samples, [1.0, -1024.0], place, Modality::Ct).unwrap().with_unit("HU");
    let scan = folder.join("block");
    let series = SeriesDescription { patient_name: PATIENT.into(), ..SeriesDescription::default() };
    write_dicom_series(&volume, &scan, &series, Progress::SILENT, &CancelToken::new()).unwrap();
    scan
}

fn measured(studio: &Studio, index: usize) -> Measured {
    let session = session(studio);
    session.document().measurements[index].measured(session.scan()).unwrap()
}

fn count(studio: &Studio) -> usize {
    session(studio).document().measurements.len()
}

/// Where a voxel is in the axial slice.
fn in_axial(studio: &Studio, voxel: [f64; 3]) -> Pos2 {
    let rect = view(studio, "Axial");
    let state = &studio.state().state;
    let scan = state.session.as_ref().unwrap().scan();
    let size = [rect.width() as usize, rect.height() as usize];
    let geometry = Geometry::new(scan, Plane::Axial.axes(), state.cross, size, 1.0, DVec2::ZERO);
    let [x, y] = geometry.pixel(scan.patient_from_voxel().transform_point3(DVec3::from_array(voxel)));
    rect.min + egui::vec2(x as f32, y as f32)
}

/// Where a voxel is in the 3D view, by its camera alone.
fn in_3d(studio: &Studio, voxel: [f64; 3]) -> Pos2 {
    let rect = view(studio, "3D");
    let session = session(studio);
    let patient = session.scan().patient_from_voxel().transform_point3(DVec3::from_array(voxel));
    let world = session.scene().0.volumes[0].world_from_patient.transform_point3(patient);
    let own = session.camera().world_from_camera.inverse().transform_point3(world);
    let half = (session.camera().vertical_fov / 2.0).tan() * -own.z;
    rect.center() + egui::vec2((own.x / half) as f32, (-own.y / half) as f32) * (rect.height() / 2.0)
}

#[test]
fn a_region_over_two_slices_lies_in_the_second() {
    let corners = [DVec3::new(0.0, 0.0, 3.0), DVec3::new(20.0, 10.0, 9.0)];
    let region = measuring::made(MeasurementKind::Region, &corners, Plane::Axial.axes()).unwrap();
    assert_eq!(region.points, [[10.0, 5.0, 9.0], [20.0, 5.0, 9.0], [10.0, 10.0, 9.0]]);
}

#[test]
fn values_have_the_scans_own_unit() {
    let pet = Volume::new([8; 3], Voxels::U8(vec![7; 512]), [1.0, 0.0], DAffine3::IDENTITY, Modality::Pet);
    let pet = pet.unwrap().with_unit("SUVbw");
    let points = [[3.0, 3.0, 3.0], [5.0, 3.0, 3.0], [3.0, 5.0, 3.0]].to_vec();
    let region = Measurement { kind: MeasurementKind::Region, points };
    assert!(measuring::lines(&region, &pet, Language::English)[0].contains("7.0 SUVbw"));
    let mr = pet.with_unit("");
    assert!(measuring::lines(&region, &mr, Language::English)[0].contains("7.0 \u{b1}"));
}

#[test]
fn lengths_angles_and_regions_are_those_of_the_phantom() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let scan = block(folder.path());
    let (mut studio, answers) = studio();
    open(&mut studio, &[&scan]);
    click(&mut studio, "All that was scanned");
    click(&mut studio, "Front");
    settle(&mut studio);
    let studio = &mut studio;

    // From edge to edge of the block: 24 voxels of 2 mm, dragged in a slice.
    click(studio, "Distance");
    assert_eq!(studio.state().state.tool, Tool::Measure(MeasurementKind::Distance));
    let window = studio.state().state.window;
    let [from, to] = [[11.5, 22.0, 15.0], [35.5, 22.0, 15.0]].map(|voxel| in_axial(studio, voxel));
    drag(studio, PointerButton::Primary, from, to);
    let Measured::Length(mm) = measured(studio, 0) else { panic!("a length") };
    assert!((mm - 48.0).abs() < 1.0, "{mm}");
    assert!(says(studio, &format!("{mm:.1} mm")), "{:?}", texts(studio));
    assert_eq!(studio.state().state.window, window, "the left button measures");
    // The right one has the window meanwhile.
    let beside = in_axial(studio, [22.0, 36.0, 15.0]);
    drag(studio, PointerButton::Secondary, beside, beside + egui::vec2(20.0, 0.0));
    assert!(studio.state().state.window[1] > window[1]);

    // A corner of the block, by three clicks.
    click(studio, "Angle");
    for voxel in [[35.5, 9.5, 15.0], [11.5, 9.5, 15.0], [11.5, 33.5, 15.0]] {
        let at = in_axial(studio, voxel);
        click_at(studio, at);
    }
    let Measured::Angle(degrees) = measured(studio, 1) else { panic!("an angle") };
    assert!((degrees - 90.0).abs() < 0.5, "{degrees}");

    // Half of the voxels of an ellipse inside have 900 HU, half 1100.
    click(studio, "Region");
    let [from, to] = [[16.0, 14.0, 15.0], [32.0, 30.0, 15.0]].map(|voxel| in_axial(studio, voxel));
    drag(studio, PointerButton::Primary, from, to);
    let Measured::Region { area_mm2, values: Some(values) } = measured(studio, 2) else { panic!("a region") };
    assert!((area_mm2 - std::f64::consts::PI * 16.0 * 16.0).abs() < 32.0, "{area_mm2}");
    assert!(
        (values.mean - 1000.0).abs() < 5.0 && (values.standard_deviation - 100.0).abs() < 1.0,
        "{values:?}"
    );
    assert_eq!((values.min, values.max), (900.0, 1100.0));
    assert!((values.count as f64 - area_mm2 / 4.0).abs() < 12.0, "{values:?}");
    settle(studio);
    screenshot(studio, "16-measurements");

    // In 3D by clicks on the front of the block, at its depth: 20 voxels across, 10 up.
    click(studio, "Distance");
    for voxel in [[14.0, 9.5, 10.0], [34.0, 9.5, 20.0]] {
        let at = in_3d(studio, voxel);
        click_at(studio, at);
    }
    let Measured::Length(mm) = measured(studio, 3) else { panic!("a length") };
    let wanted = 40.0_f64.hypot(30.0);
    assert!((mm - wanted).abs() < 1.0, "{mm} {wanted}");
    settle(studio);
    screenshot(studio, "17-measured-in-3d");

    // What a region says is found once, however many frames and views there are.
    let count_of = |studio: &Studio| studio.state().state.said.borrow().count;
    let found = count_of(studio);
    studio.run_steps(3);
    assert!(found > 0 && count_of(studio) == found);

    // A point that is dragged is one step, and stays as far from the pointer as where it was taken.
    click(studio, "Navigate");
    let before = session(studio).document().clone();
    let axial = view(studio, "Axial");
    let handle = |studio: &Studio| {
        let all = studio.get_all_by_label("Measurement 1, 2").map(|node| node.rect().center());
        all.into_iter().find(|at| axial.contains(*at)).unwrap()
    };
    let beside = egui::vec2(5.0, -4.0);
    let point = handle(studio);
    click_at(studio, point + beside);
    assert_eq!(session(studio).document(), &before, "a click moves nothing");
    let shorter = in_axial(studio, [23.5, 22.0, 15.0]);
    drag(studio, PointerButton::Primary, point + beside, shorter + beside);
    let Measured::Length(mm) = measured(studio, 0) else { panic!("a length") };
    assert!((mm - 24.0).abs() < 0.5, "{mm}");
    assert!((handle(studio) - shorter).length() < 0.5);
    undo(studio);
    // By keys, too: the view stays where it is.
    let (old, cross) = (handle(studio), studio.state().state.cross);
    let all = studio.get_all_by_label("Measurement 1, 2");
    all.into_iter().find(|node| axial.contains(node.rect().center())).unwrap().focus();
    studio.run_steps(2);
    studio.key_press_modifiers(Modifiers::SHIFT, Key::ArrowLeft);
    studio.key_press(Key::ArrowDown);
    studio.run_steps(3);
    assert!((handle(studio) - old - egui::vec2(-10.0, 1.0)).length() < 0.5, "{:?}", handle(studio) - old);
    assert_eq!(studio.state().state.cross, cross);
    undo(studio);
    undo(studio);
    assert_eq!(session(studio).document(), &before);
    // In a slab it keeps its depth.
    let state = &mut studio.state_mut().state;
    state.slab = Slab { projection: Projection::Mean, thickness_mm: 20.0 };
    state.cross.z += 6.0;
    studio.run_steps(2);
    let depth = |studio: &Studio| session(studio).document().measurements[0].points[1][2];
    let old = depth(studio);
    let point = handle(studio);
    drag(studio, PointerButton::Primary, point, point + egui::vec2(-30.0, 0.0));
    assert!((depth(studio) - old).abs() < 1e-6 && session(studio).document() != &before);
    undo(studio);
    let state = &mut studio.state_mut().state;
    (state.slab, state.cross.z) = (Slab::default(), state.cross.z - 6.0);
    studio.run_steps(2);
    assert_eq!(session(studio).document(), &before);

    // As a table.
    let file = folder.path().join("table");
    answers.next(&file);
    click(studio, "Save as CSV…");
    settle(studio);
    let table = std::fs::read_to_string(file.with_extension("csv")).unwrap();
    let rows: Vec<&str> = table.lines().collect();
    assert!(rows[0].contains("Not a medical device") && rows.len() == 6, "{table}");
    let columns: Vec<usize> = rows[1..].iter().map(|row| row.split(',').count()).collect();
    assert_eq!(columns, [12; 5], "{table}");
    assert!(rows[4].starts_with("3,region,,,") && rows[4].contains(",900.0000,1100.0000,HU,"), "{table}");
    assert!(!table.contains("Doe"));

    // Deleted, and back.
    click(studio, "Delete 2");
    assert_eq!(count(studio), 3);
    studio.key_press(Key::Delete);
    studio.run_steps(2);
    assert_eq!(count(studio), 2);
    for _ in 0..2 {
        undo(studio);
    }
    assert_eq!(session(studio).document(), &before);
    // The scene's file has them.
    let scene = folder.path().join("block.lumivox");
    answers.next(&scene);
    click(studio, "Save scene…");
    settle(studio);
    open(studio, &[&scene]);
    let back = session(studio).document();
    assert_eq!(back.measurements, before.measurements);
}

#[test]
fn keys_alone_measure() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let (mut studio, _) = studio();
    let studio = &mut studio;
    open(studio, &[&block(folder.path())]);
    studio.key_press(Key::Num2);
    studio.key_press(Key::D);
    studio.run_steps(2);
    let from = studio.state().state.cross;
    studio.key_press(Key::Enter);
    studio.run_steps(2);
    for _ in 0..7 {
        studio.key_press_modifiers(Modifiers::ALT, Key::ArrowRight);
    }
    studio.key_press_modifiers(Modifiers::ALT, Key::ArrowDown);
    studio.run_steps(2);
    let by = studio.state().state.cross - from;
    assert!((by - DVec3::new(14.0, 2.0, 0.0)).length() < 1e-9, "voxels of 2 mm: {by}");
    assert_eq!(count(studio), 0);
    studio.key_press(Key::Enter);
    studio.run_steps(2);
    let Measured::Length(mm) = measured(studio, 0) else { panic!("a distance") };
    assert!((mm - by.length()).abs() < 1e-9, "{mm}");
    // A window is typed.
    click(studio, "Window");
    let level = studio.get_by_role_and_label(Role::SpinButton, "Level");
    level.focus();
    studio.run_steps(2);
    studio.key_press(Key::ArrowUp);
    studio.run_steps(2);
    assert!(studio.state().state.window[0] > 40.0, "{:?}", studio.state().state.window);
}
