//! A scan as a page for others: what is asked before, what is in it, and what is not.

use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use lumivox_core::glam::DAffine3;
use lumivox_core::{Lasso, Preset, Volume, Voxels};
use lumivox_studio::sharing::{self, Sharing, Viewer};
use lumivox_studio::state::Action;

use super::*;

fn viewer() -> Viewer {
    Viewer::new([b"calls".to_vec(), b"binding".to_vec(), b"program".to_vec()])
}

fn sharing_of(studio: &Studio, side: usize) -> Sharing {
    let session = session(studio);
    Sharing {
        scene: session.scene().0.clone(),
        document: session.document().clone(),
        camera: *session.camera(),
        title: "Head".to_owned(),
        looks: session.looks_of_shown(&studio.state().state.looks),
        language: Language::English,
        side,
    }
}

fn shared(studio: &Studio, title: &str, side: usize) -> String {
    let sharing = Sharing { title: title.to_owned(), ..sharing_of(studio, side) };
    sharing::page(&sharing, &viewer(), &CancelToken::new()).unwrap()
}

/// What is between two words of a page, for the first time.
fn between<'a>(page: &'a str, before: &str, behind: &str) -> &'a str {
    page.split_once(before).unwrap().1.split_once(behind).unwrap().0
}

fn told(page: &str) -> serde_json::Value {
    serde_json::from_str(between(page, "<script type=\"application/json\" id=\"scene\">", "</script>"))
        .unwrap()
}

fn blocks(page: &str) -> Vec<Vec<u8>> {
    let parts = page.split("<script type=\"application/gzip\">").skip(1);
    let unpacked = parts.map(|part| {
        let packed = STANDARD.decode(part.split_once("</script>").unwrap().0).unwrap();
        let mut bytes = vec![];
        flate2::read::GzDecoder::new(&packed[..]).read_to_end(&mut bytes).unwrap();
        bytes
    });
    unpacked.collect()
}

fn stored(volume: &Volume) -> Vec<u8> {
    let Voxels::U16(voxels) = volume.voxels() else { panic!("16 bits") };
    voxels.iter().flat_map(|voxel| voxel.to_le_bytes()).collect()
}

#[test]
fn a_page_holds_the_scan_and_not_where_it_came_from() {
    let _alone = alone();
    let (studio, _, folder) = with_head(24);
    let page = shared(&studio, "Head <1> & \"2\"", 96);
    let shown = session(&studio).scene().0.volumes[0].volume.clone();
    let blocks = blocks(&page);
    assert_eq!(blocks.len(), 4);
    assert_eq!(&blocks[..3], [&b"calls"[..], b"binding", b"program"]);
    assert!(blocks[3] == stored(&shown), "what is seen, to the bit: the patient alone");

    let told = told(&page);
    let [scan] = &told["scans"].as_array().unwrap()[..] else { panic!("one scan") };
    assert_eq!((&scan["kind"], &scan["description"]["modality"]), (&"uint16".into(), &"CT".into()));
    assert_eq!(scan["description"]["dims"], serde_json::json!([24, 24, 24]));
    let document =
        lumivox_core::document::SceneDocument::parse_described(&told["document"].to_string()).unwrap();
    assert!(document.volumes[0].scan.files.is_empty());
    assert_eq!(document.camera, session(&studio).document().camera);
    // What is seen has no skin: bone can be seen in it, and skin cannot.
    assert_eq!(session(&studio).document().volumes[0].look.preset, Some(Preset::CtMuscle));
    let looks: Vec<&str> =
        told["looks"].as_array().unwrap().iter().map(|look| look["preset"].as_str().unwrap()).collect();
    assert!(
        looks.contains(&"ct-bone") && !looks.contains(&"ct-skin") && !looks.contains(&"ct-muscle"),
        "{looks:?}"
    );

    // Nobody's name, no folder; what people wrote is no HTML.
    let path = folder.path().to_string_lossy();
    assert!(!page.contains("Doe") && !page.contains(&*path) && !page.contains("{{"));
    let holds_doe = |block: &Vec<u8>| block.windows(3).any(|part| part == b"Doe");
    assert!(!blocks.iter().any(holds_doe));
    assert!(page.contains("<h1>Head &#60;1&#62; &#38; &#34;2&#34;</h1>"));
    assert!(page.contains("Not a medical device") && page.contains("default-src 'none'"));
}

/// Whatever voxels were where nothing is left, the page is the same: as fine as the scan, and coarser.
fn assert_tells_nothing_of(studio: &Studio, is_gone: impl Fn([usize; 3]) -> bool) {
    for side in [96, 12] {
        let mut others = sharing_of(studio, side);
        let volume = (*others.scene.volumes[0].volume).clone();
        let ([nx, ny, _], mut count) = (volume.dims(), 0);
        let [low, high] = volume.value_range();
        let stored = |value: f64| ((value - volume.intercept()) / volume.slope()) as u16;
        let middle = stored(0.5 * (low + high));
        let extremes = [low, high].map(stored);
        let changed = volume.edit(|voxels| {
            let Voxels::U16(samples) = voxels else { panic!("16 bits") };
            for (index, sample) in samples.iter_mut().enumerate() {
                let is_extreme = extremes.contains(sample);
                if !is_extreme && is_gone([index % nx, index / nx % ny, index / (nx * ny)]) {
                    *sample = middle ^ (index % 251) as u16;
                    count += 1;
                }
            }
        });
        others.scene.volumes[0].volume = Arc::new(changed.unwrap());
        assert!(count > 500, "{count}");
        let [one, other] = [sharing_of(studio, side), others]
            .map(|it| sharing::page(&it, &viewer(), &CancelToken::new()).unwrap());
        assert!(one == other, "{side} voxels a side tell of what is gone");
    }
}

#[test]
fn what_was_taken_off_the_skin_is_in_no_page() {
    let _alone = alone();
    let (mut studio, _, _folder) = with_head(40);
    let studio = &mut studio;
    click(studio, "Skin");
    settle(studio);
    studio.state_mut().state.change(lumivox_studio::words::Word::Peel, |document| {
        document.volumes[0].peel = Some(6.0);
    });
    settle(studio);
    let instance = session(studio).scene().0.volumes[0].clone();
    let peel = instance.peel.expect("skin was found");
    let place = peel.depth.patient_from_voxel().inverse() * instance.volume.patient_from_voxel();
    let last = peel.depth.dims().map(|n| n as f64 - 1.0);
    let depth_at = |voxel: [usize; 3]| {
        let at = place.transform_point3(voxel.map(|i| i as f64).into());
        peel.depth.interpolated(at.clamp(Default::default(), last.into())).unwrap()
    };
    assert_tells_nothing_of(studio, |voxel| peel.share(depth_at(voxel)) <= 0.0);
    // Nor is it told how deep points lie beyond the border.
    let page = shared(studio, "Head", 96);
    let told = told(&page);
    let depth = &told["scans"][0]["depth"]["description"];
    let number = |name: &str| depth[name].as_f64().unwrap();
    let all = blocks(&page).pop().unwrap();
    let depths: Vec<f64> = all
        .chunks_exact(2)
        .map(|it| number("intercept") + number("slope") * f64::from(u16::from_le_bytes([it[0], it[1]])))
        .collect();
    let reach = 0.51 * peel.width_mm();
    assert!(depths.iter().all(|mm| (mm - 6.0).abs() <= reach), "{reach}");
    assert_eq!(told["document"]["volumes"][0]["peel"], 6.0);
}

#[test]
fn a_page_has_what_is_wanted_now_or_nothing() {
    let _alone = alone();
    let (mut studio, _, folder) = with_head(32);
    let studio = &mut studio;
    let file = folder.path().join("early.html");
    let state = &mut studio.state_mut().state;
    state.change(lumivox_studio::words::Word::Peel, |document| document.volumes[0].peel = Some(6.0));
    state.act(Action::ShareDialog);
    studio.run_steps(2);
    assert!(studio.state().state.dialog.is_none(), "what is seen has its skin still");
    settle(studio);
    studio.state_mut().state.act(Action::ShareDialog);
    studio.run_steps(2);
    assert!(studio.state().state.dialog.is_some() && !file.exists());
}

#[test]
fn what_was_cut_away_is_in_no_page() {
    let _alone = alone();
    let (mut studio, _, _folder) = with_head(32);
    let studio = &mut studio;
    let scan = session(studio).scan().clone();
    let middle = scan.patient_from_voxel().transform_point3(scan.dims().map(|n| 0.5 * n as f64).into());
    // All of the patient's left half.
    let far = 1e4;
    let half = vec![[0.0, -far], [far, -far], [far, far], [0.0, far]];
    let lasso = Lasso::new(DAffine3::from_translation(middle), true, half);
    studio.state_mut().state.change(lumivox_studio::words::Word::Cut, |document| {
        document.volumes[0].lassos.push(lasso);
    });
    settle(studio);
    let instance = session(studio).scene().0.volumes[0].clone();
    let labels = instance.labels.unwrap().labels;
    let cut = labels.cut_away().expect("it cuts").value;
    assert_tells_nothing_of(studio, |voxel| labels.value(voxel) == cut);
    let page = shared(studio, "Head", 96);
    let told = told(&page);
    assert_eq!(blocks(&page).len(), 5, "labels come along");
    // Of what is left at its border nothing is seen.
    let styles = &told["document"]["volumes"][0]["labels"]["styles"];
    let hidden = styles.as_array().unwrap().iter().find(|style| style["label"] == format!("#{cut}")).unwrap();
    assert_eq!(hidden["visible"], false);
    assert!(
        told["document"]["volumes"][0]["lassos"].is_null() && told["structures"] == serde_json::json!([])
    );
}

#[test]
fn it_is_asked_whether_a_scan_may_be_given_away() {
    let _alone = alone();
    let (mut studio, answers, folder) = with_head(24);
    let studio = &mut studio;
    // Beside the program, as packages have it.
    let beside = std::env::current_exe().unwrap().parent().unwrap().join("viewer");
    let _ = std::fs::remove_dir_all(&beside);
    let file = folder.path().join("shared.html");
    let share = |studio: &mut Studio, answers: &Answers| {
        studio.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::E);
        studio.run_steps(3);
        assert!(says(studio, "A face identifies a person"), "{:?}", texts(studio));
        let save = studio.get_by_label("Save page…");
        assert!(save.accesskit_node().is_disabled(), "nobody has said so yet");
        click(studio, "I may give this scan to others");
        answers.next(file.with_extension(""));
        click(studio, "Save page…");
        settle(studio);
    };
    share(studio, &answers);
    assert!(says(studio, "The program for pages is not here") && !file.exists(), "{:?}", texts(studio));
    click(studio, "Close");
    std::fs::create_dir(&beside).unwrap();
    Viewer::FILES.iter().for_each(|name| std::fs::write(beside.join(name), name).unwrap());
    share(studio, &answers);
    std::fs::remove_dir_all(&beside).unwrap();
    assert!(says(studio, "Saved: shared.html"), "{:?}", texts(studio));
    let page = std::fs::read_to_string(&file).unwrap();
    assert_eq!(blocks(&page)[2], b"lumivox_wasm_bg.wasm");
    click(studio, "Share…");
    screenshot(studio, "14-share");
}
