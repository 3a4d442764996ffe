//! A folder of DICOM files that changes while the editor is open, or between two of its runs: `project/folders`.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::engine::{Start, engine};
use crate::scans::write_series;
use crate::shown::told;

/// What the addon says of a scan that moved, and of files that are none in the end; and the engine, when it is told to
/// quit.
const EXCUSED: &[&str] = &["is now imported as", "res://scans/ct", "/scans/ct", "Scan thread aborted"];

/// How many slices the scan has that a file holds, which file the others point to, and how many do.
#[track_caller]
fn assert_holds(told: &Value, first: u64, slices: u64) {
    let holder = format!("CT{first:04}.dcm");
    let files = told["files"].as_object().unwrap();
    for (name, what) in files {
        let wanted = if *name == holder { json!(slices) } else { json!(holder) };
        assert_eq!(*what, wanted, "{name}: {told}");
    }
    assert_eq!(files.len() as u64, slices, "{told}");
}

fn copy_slices(from: &Path, to: &Path, numbers: std::ops::RangeInclusive<u32>) {
    for number in numbers {
        let name = format!("CT{number:04}.dcm");
        fs::copy(from.join(&name), to.join(&name)).unwrap();
    }
}

#[test]
fn a_folder_that_changes_is_imported_again_once_it_rests() {
    let engine = engine();
    let project = engine.copy_project("folders");
    let slices = engine.out.join("folders/slices");
    write_series(&lumivox_phantom::cube(32), &slices);
    let folder = project.join("scans/ct");
    fs::create_dir_all(&folder).unwrap();
    copy_slices(&slices, &folder, 10..=19);
    let settings = fs::read_to_string(project.join("project.godot")).unwrap();
    let settings = settings.replace("plugin.cfg\")", "plugin.cfg\", \"res://tests/folders/plugin.cfg\")");
    let lines = settings.lines().filter(|line| !line.starts_with("run/main_scene"));
    fs::write(project.join("project.godot"), lines.collect::<Vec<_>>().join("\n")).unwrap();
    let [path, from] = [&project, &slices].map(|path| path.to_str().unwrap());
    let start = Start { excused: EXCUSED, ..Start::default() };
    let import = ["--path", path, "--headless", "--import"];
    engine.run_as(&engine.godot, "folders_import", &import, &start);

    // Without a display nothing waits.
    copy_slices(&slices, &folder, 20..=21);
    let run = engine.run_as(&engine.godot, "folders_import_again", &import, &start);
    assert!(run.log.contains("it had 10 files and has 12 now"), "{}", run.log);

    let arguments = ["--path", path, "--editor", "--", "--slices", from];
    let start = Start { unseen: true, ..start };
    let run = engine.run_as(&engine.godot, "folders", &arguments, &start);
    let telling = |name: &str| told(&run, name);
    assert_holds(&telling("first"), 10, 12);

    let more = telling("more");
    assert_holds(&more, 10, 19);
    assert_eq!((&more["imports"]["CT0010.dcm"], &more["shown"]), (&json!(1), &json!(19)), "{more}");
    assert!(run.log.contains("res://scans/ct is imported again: it had 12 files and has 19 now"));

    let last = telling("last");
    assert_holds(&last, 10, 21);
    assert_eq!(last["imports"]["CT0010.dcm"], 1, "{last}");

    let earlier = telling("earlier");
    assert_holds(&earlier, 5, 26);
    assert!(run.log.contains("is now imported as CT0005.dcm"), "{}", run.log);
    assert_holds(&telling("removed"), 6, 25);

    let replaced = telling("replaced");
    assert_holds(&replaced, 6, 25);
    assert_eq!(replaced["largest"], 3071.0, "{replaced}");

    // Tried once, and said why.
    let broken = telling("broken");
    assert_eq!(broken["imports"]["CT0006.dcm"], 1, "{broken}");
    assert!(run.log.contains("res://scans/ct was not imported; the line above says why"));
    assert_eq!(telling("idle")["imports"], json!({}));
    // Nor is anything wrong with a folder that is gone.
    let (_, gone) = run.log.split_once("TELL idle").unwrap();
    assert!(gone.contains("GONE") && !gone.contains("ERROR"), "{gone}");
}
