//! Structures: found in the scan, and opened from a file.

use eframe::egui::accesskit::Role;
use lumivox_core::document::{Labels, SceneDocument, Style};
use lumivox_core::{LabelVolume, UNLABELLED};
use lumivox_studio::state::Action;
use lumivox_studio::words::Word;

use super::*;

fn styles(studio: &Studio) -> Vec<Style> {
    let entry = &session(studio).document().volumes[0];
    entry.labels.as_ref().map_or(vec![], |labels| labels.styles.clone())
}

fn labels(studio: &Studio) -> Option<Arc<LabelVolume>> {
    let session = session(studio);
    session.scene().0.volumes[0].labels.as_ref().map(|labelling| labelling.labels.clone())
}

/// What has its name beside the picture.
fn names(studio: &Studio) -> Vec<String> {
    studio.state().state.named.names().map(str::to_owned).collect()
}

/// The middle of the scan in the patient, where the ball is.
fn center(studio: &Studio) -> lumivox_core::glam::DVec3 {
    let scan = session(studio).scan();
    let middle = scan.dims().map(|n| 0.5 * n as f64);
    scan.patient_from_voxel().transform_point3(middle.into())
}

/// A ball in the middle of the shown scan, as 3D Slicer writes it; with its volume in ml.
fn ball(studio: &Studio, folder: &Path) -> (PathBuf, f64) {
    let scan = session(studio).scan().clone();
    let (dims, place) = (scan.dims(), scan.patient_from_voxel());
    let mut bytes = vec![0_u8; dims.iter().product()];
    let mut count = 0.0;
    for (i, byte) in bytes.iter_mut().enumerate() {
        let at = [i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]];
        let by: f64 = (0..3).map(|axis| (at[axis] as f64 - 0.5 * dims[axis] as f64).powi(2)).sum();
        if by <= 25.0 {
            (*byte, count) = (1, count + 1.0);
        }
    }
    let column = |v: lumivox_core::glam::DVec3| format!("({},{},{})", v.x, v.y, v.z);
    let m = place.matrix3;
    let header = format!(
        "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: {} {} {}\n\
         space directions: {} {} {}\nspace origin: {}\nencoding: raw\n\
         Segment0_Name:=Tumour\nSegment0_LabelValue:=1\nSegment0_Color:=0.9 0.2 0.1\nSegment0_ID:=a\nSegment0_Layer:=0\n\n",
        dims[0],
        dims[1],
        dims[2],
        column(m.x_axis),
        column(m.y_axis),
        column(m.z_axis),
        column(place.translation)
    );
    let file = folder.join("ball.seg.nrrd");
    std::fs::write(&file, [header.as_bytes(), &bytes].concat()).unwrap();
    (file, count * m.determinant().abs() / 1e3)
}

#[test]
fn structures_are_found_and_opened_and_each_has_eye_colour_and_size() {
    let _alone = alone();
    let (mut studio, answers, folder) = with_head(48);
    let studio = &mut studio;
    click(studio, "Structures");
    click(studio, "Find in this scan");
    settle(studio);
    let found = labels(studio).expect("labels");
    assert!(found.labels().len() >= 2, "{:?}", found.labels());
    let name = found.labels()[0].name.clone();
    assert!(says(studio, &name) && says(studio, " ml"), "{:?}", texts(studio));
    screenshot(studio, "25-structures");

    // The head is all skin from outside.
    studio.run_steps(3);
    assert!(names(studio).len() <= found.labels().len(), "{:?}", names(studio));

    // Of a file: its name, its volume, its colour over slices.
    let (file, ml) = ball(studio, folder.path());
    answers.next(&file);
    click(studio, "Open segmentation…");
    settle(studio);
    assert_eq!(studio.state().state.failed, None);
    assert_eq!(labels(studio).unwrap().labels()[0].name, "Tumour");
    let radius_mm = 5.0 * session(studio).scan().spacing_mm().max_element();
    let said = if ml < 10.0 { format!("{ml:.1} ml") } else { format!("{ml:.0} ml") };
    assert!(says(studio, &said), "{said}: {:?}", texts(studio));
    let middle = view(studio, "Axial").center() + egui::vec2(8.0, 8.0);
    let redness = |seen: &Seen| {
        let [red, _, blue, _] = seen.color(middle).map(i32::from);
        red - blue
    };
    let tinted = redness(&screenshot(studio, "26-segmentation"));
    assert!(tinted > 40, "{tinted}");
    // It is seen through the nose: its name stands beside the picture, and leads to it.
    studio.run_steps(3);
    assert_eq!(names(studio), ["Tumour"]);
    let name = studio.get_all_by_role_and_label(Role::Link, "Tumour").next().unwrap().rect();
    let three_d = view(studio, "3D");
    assert!(three_d.contains_rect(name) && name.max.x < three_d.center().x + 0.5 * three_d.width() - 20.0);
    click_at(studio, name.center());
    let away = studio.state().state.cross - center(studio);
    assert!(away.length() < 1.5 * radius_mm, "{away}");
    click(studio, "Names beside the 3D picture");
    assert!(studio.query_all_by_role_and_label(Role::Link, "Tumour").next().is_none());
    click(studio, "Names beside the 3D picture");
    // Its eye.
    studio.get_by_role_and_label(Role::CheckBox, "Tumour").click();
    studio.run_steps(4);
    assert!(!session(studio).scene().0.volumes[0].labels.as_ref().unwrap().style(1).visible);
    studio.run_steps(2);
    let plain = redness(&screenshot(studio, "27-hidden"));
    assert!(plain.abs() < 8, "{plain}");
    undo(studio);
    // The rest of the scan.
    click(studio, "The rest of the scan");
    assert!(!session(studio).scene().0.volumes[0].labels.as_ref().unwrap().style(UNLABELLED).visible);
    // Solid, whatever its values are.
    click(studio, "Look of the structure: Tumour");
    click(studio, "Solid");
    assert!(styles(studio).iter().any(|style| style.label == "Tumour" && style.transfer_function.is_some()));
    settle(studio);
    screenshot(studio, "28-solid");
    // Cuts go around it.
    click(studio, "Look of the structure: Tumour");
    click(studio, "Spared by cuts");
    assert!(!session(studio).scene().0.volumes[0].labels.as_ref().unwrap().style(1).clipped);

    // What is no label map is told by its name, and what was there stays.
    let wrong = folder.path().join("wrong.nrrd");
    std::fs::write(&wrong, "NRRD0004\ntype: uint8\n\n").unwrap();
    answers.next(&wrong);
    let before = styles(studio);
    click(studio, "Open segmentation…");
    wait(studio, "it is told", |app| app.state.failed.is_some());
    assert!(says(studio, "wrong.nrrd"));
    click(studio, "Close");
    settle(studio);
    assert_eq!(styles(studio), before);
    assert_eq!(labels(studio).unwrap().labels()[0].name, "Tumour");
    click(studio, "Forget");
    settle(studio);
    assert!(labels(studio).is_none());
}

/// A copy of the document that wants such structures.
fn with_labels(document: &SceneDocument, labels: Labels) -> Box<SceneDocument> {
    let mut document = Box::new(document.clone());
    document.volumes[0].labels = Some(labels);
    document
}

#[test]
fn what_is_cancelled_or_refused_while_it_is_found_leaves_the_scan_as_it_is_shown() {
    let _alone = alone();
    let (mut studio, _, folder) = with_head(24);
    let studio = &mut studio;
    let start = session(studio).document().clone();
    let act = |studio: &mut Studio, actions: Vec<Action>| {
        actions.into_iter().for_each(|action| studio.state_mut().state.act(action));
        studio.run_steps(2);
    };
    // Both in one frame: nothing is found so soon.
    let found = with_labels(&start, Labels::default());
    act(studio, vec![Action::Change(Word::StructuresFind, found.clone()), Action::Cancel]);
    assert!(studio.state().is_quiet() && labels(studio).is_none());
    assert_eq!(session(studio).document(), &start);
    // Back from there it is asked for once more.
    undo(studio);
    settle(studio);
    assert_eq!(session(studio).document(), &*found);
    assert!(labels(studio).is_some());
    undo(studio);
    settle(studio);
    assert_eq!(session(studio).document(), &start);
    assert!(labels(studio).is_none());

    // What cannot be shown is as if it had never been asked for; what was changed meanwhile stays.
    let gone = folder.path().join("gone.nrrd");
    let refused = with_labels(&start, Labels { files: vec![gone], ..Labels::default() });
    let mut brighter = refused.clone();
    brighter.display.exposure = 1.5;
    let changes = [(Word::StructuresOpen, refused), (Word::Exposure, brighter.clone())];
    act(studio, changes.map(|(what, document)| Action::Change(what, document)).to_vec());
    wait(studio, "it is told", |app| app.state.failed.is_some());
    assert!(says(studio, "gone.nrrd"));
    click(studio, "Close");
    let wanted = SceneDocument { display: brighter.display, ..start.clone() };
    assert_eq!(session(studio).document(), &wanted);
    undo(studio);
    settle(studio);
    assert_eq!((session(studio).document(), session(studio).history().next()[0]), (&start, None));
    assert!(studio.state().state.failed.is_none());
}
