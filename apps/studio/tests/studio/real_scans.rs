//! Real scans, where they are.

use super::*;

/// Opens, and says what there is: the sentences of the banner, or why it is refused.
fn open(studio: &mut Studio, file: &Path) -> Result<Vec<String>, String> {
    studio.state_mut().state.session = None;
    studio.state_mut().state.failed = None;
    drop_files(studio, &[file]);
    wait(studio, "it opens", |app| app.state.session.is_some() || app.state.failed.is_some());
    if let Some((_, why)) = studio.state().state.failed.clone() {
        return Err(why);
    }
    Ok(session(studio).report.notes.clone())
}

#[test]
fn a_tilted_gantry_is_told_and_damage_refused_by_name() {
    let _alone = alone();
    let (Some(tilt), Some(bad)) = (shared("ct_tilt"), shared("bad")) else { return };
    let (mut studio, _) = studio();
    let notes = open(&mut studio, &tilt).unwrap();
    assert!(notes.iter().any(|note| note.contains("tilt")), "{notes:?}");
    settle(&mut studio);
    assert!(says(&studio, "tilt"));
    screenshot(&mut studio, "14-tilt");
    let mut refused = 0;
    for entry in std::fs::read_dir(bad).unwrap() {
        let file = entry.unwrap().path();
        if let Err(why) = open(&mut studio, &file) {
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            assert!(why.contains(&name), "{name}: {why}");
            refused += 1;
        }
    }
    assert!(refused > 15, "{refused}");
}

#[test]
#[ignore = "slow: script/test --all"]
fn zipped_studies_open_with_all_their_series() {
    let _alone = alone();
    let (mut studio, _) = studio();
    for (name, least) in [("mr_missing_slices.zip", 3), ("ct_mixed_folder.zip", 2), ("ct_torso.zip", 1)] {
        let Some(file) = shared(name) else { return };
        open(&mut studio, &file).unwrap();
        settle(&mut studio);
        assert!(studio.state().state.strip.series.len() >= least, "{name}");
        screenshot(&mut studio, &format!("15-{}", name.trim_end_matches(".zip")));
    }
}
