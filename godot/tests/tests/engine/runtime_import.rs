//! Scans that the running game imports: what the library says of them, without a frame that waits.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use lumivox_core::{CancelToken, Progress, Volume};
use lumivox_import::{ImportOptions, Imported};
use lumivox_segmentation::patient_alone;
use serde::Serialize;
use serde_json::{Value, json};

use crate::case::Case;
use crate::engine::{Run, engine};
use crate::scans;
use crate::shown::{run_scene_in_window, told};

/// What `project/runtime_import.gd` loads.
#[derive(Clone, Serialize)]
struct Job {
    name: String,
    path: String,
    /// The folder that `path` becomes a zip archive of, if any.
    zip: String,
    /// The file that is copied to `path`, if any.
    copy: String,
    /// Whether it is loaded once more, while the game waits.
    blocking: bool,
}

#[derive(Serialize)]
struct Script {
    case: Case,
    jobs: Vec<Job>,
    series: String,
    large: String,
    mixed: String,
    torso: String,
}

struct Imports {
    jobs: Vec<Job>,
    /// Where Rust finds what the script calls `user://`.
    copied: PathBuf,
    run: Run,
}

fn imports() -> &'static Imports {
    static IMPORTS: OnceLock<Imports> = OnceLock::new();
    IMPORTS.get_or_init(|| {
        let folder = engine().out.join("scans");
        fs::create_dir_all(&folder).unwrap();
        let at = |name: &str| folder.join(name).to_str().unwrap().to_owned();
        let job = |name: &str, path: String| Job {
            name: name.to_owned(),
            path,
            zip: String::new(),
            copy: String::new(),
            blocking: false,
        };
        write_files(&folder);
        let mut jobs = vec![
            Job { blocking: true, ..job("series", at("series")) },
            Job { zip: at("series"), ..job("zip", at("study.zip")) },
            Job { blocking: true, ..job("large", at("large")) },
            job("nifti", at("scan.nii")),
            job("nrrd", at("scan.nrrd")),
            Job { copy: at("scan.nrrd"), ..job("user", "user://scan.nrrd".to_owned()) },
            job("mixed", at("mixed")),
            job("bad_folder", at("bad_folder")),
            job("cut_short", at("cut_short.dcm")),
            job("words", at("words.dcm")),
            job("short_nrrd", at("short.nrrd")),
            job("missing", at("nowhere")),
        ];
        for (name, path) in real_scans() {
            jobs.push(Job { blocking: true, ..job(name, path.to_str().unwrap().to_owned()) });
        }
        let case = Case { samples: 64, budget: 5.0, ..Case::new("importing") };
        let script = Script {
            case,
            jobs: jobs.clone(),
            series: at("series"),
            large: at("large"),
            mixed: at("mixed"),
            torso: at("torso"),
        };
        let (_, run) = run_scene_in_window("runtime_import", "runtime_import", &script);
        Imports { jobs, copied: folder.join("scan.nrrd"), run }
    })
}

/// Scans of real patients, where they are there.
fn real_scans() -> Vec<(&'static str, PathBuf)> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let mut found = vec![];
    for (name, path) in
        [("ct_tilt", "ct_tilt"), ("mr_fragmented", "fragmented"), ("ct_mixed", "ct_mixed_folder.zip")]
    {
        match data.join(path).canonicalize() {
            Ok(path) => found.push((name, path)),
            Err(_) => println!("{name}: {} is not here, nothing is compared", data.join(path).display()),
        }
    }
    found
}

fn write_files(folder: &Path) {
    scans::write_series(&lumivox_phantom::cube(24), &folder.join("series"));
    scans::write_series(&lumivox_phantom::cube(256), &folder.join("large"));
    scans::write_series(&scans::torso(64), &folder.join("torso"));
    let mut slices: Vec<PathBuf> =
        fs::read_dir(folder.join("series")).unwrap().map(|e| e.unwrap().path()).collect();
    slices.sort();
    let slice = fs::read(&slices[0]).unwrap();
    fs::write(folder.join("cut_short.dcm"), &slice[..slice.len() / 3]).unwrap();
    fs::write(folder.join("words.dcm"), "<html>Not found</html>\n").unwrap();
    fs::create_dir(folder.join("bad_folder")).unwrap();
    fs::write(folder.join("bad_folder/notes.txt"), "Nothing to see here.\n").unwrap();
    fs::write(folder.join("bad_folder/cut_short.dcm"), &slice[..200]).unwrap();
    // A series with what lies about in folders.
    fs::create_dir(folder.join("mixed")).unwrap();
    for path in &slices[..20] {
        fs::copy(path, folder.join("mixed").join(path.file_name().unwrap())).unwrap();
    }
    fs::write(folder.join("mixed/notes.txt"), "Patient moved.\n").unwrap();
    fs::write(folder.join("mixed/cut_short.dcm"), &slice[..300]).unwrap();

    let (dims, values) = ([20usize, 16, 12], 20 * 16 * 12);
    let samples: Vec<i16> = (0..values).map(|i| (i as i16) - 700).collect();
    let bytes: Vec<u8> = samples.iter().flat_map(|s| s.to_le_bytes()).collect();
    let header = format!(
        "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: {} {} {}\n\
         space directions: (0.5,0,0) (0,0.75,0) (0,0,2)\nspace origin: (-5,3,9)\nendian: little\nencoding: raw\n\n",
        dims[0], dims[1], dims[2]
    );
    fs::write(folder.join("scan.nrrd"), [header.as_bytes(), &bytes].concat()).unwrap();
    fs::write(folder.join("short.nrrd"), [header.as_bytes(), &bytes[..1000]].concat()).unwrap();
    fs::write(folder.join("scan.nii"), [scans::nifti_header(dims, [0.5, 0.75, 2.0]), bytes].concat())
        .unwrap();
}

/// What the library makes of the files that a script imports by default.
fn library(path: &Path) -> Imported {
    let (paths, never) = ([path.to_owned()], CancelToken::new());
    let mut scan = lumivox_import::load(&paths, &ImportOptions::default(), Progress::SILENT, &never).unwrap();
    scan.volume = patient_alone(scan.volume, Progress::SILENT, &never).unwrap().volume;
    scan
}

fn job(name: &str) -> (Job, Value) {
    let imports = imports();
    let job = imports.jobs.iter().find(|job| job.name == name).unwrap();
    (job.clone(), told(&imports.run, name))
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let list: Vec<f64> = serde_json::from_value(value.clone()).unwrap_or_else(|e| panic!("{value}: {e}"));
    list.try_into().unwrap()
}

/// What the script was given is what the library says of the same files.
fn assert_as_the_library(name: &str, described: &Value, library: &Imported) {
    let volume = &library.volume;
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-5 * b.abs().max(1.0);
    assert_eq!(numbers::<3>(&described["dims"]), volume.dims().map(|n| n as f64), "{name}");
    let spacing = numbers::<3>(&described["spacing"]);
    assert!(spacing.iter().zip(volume.spacing_mm().to_array()).all(|(a, b)| close(*a, b)), "{name}");
    let range = numbers::<2>(&described["range"]);
    assert!(range.iter().zip(volume.value_range()).all(|(a, b)| close(*a, b)), "{name}");
    assert_eq!(described["unit"], volume.unit(), "{name}");
    assert_eq!(described["counted"].as_f64().unwrap(), volume.voxel_count() as f64, "{name}");
    let report = &described["report"];
    assert_eq!(report["format"], library.report.format, "{name}");
    assert_eq!(report["series"].as_array().unwrap().len(), library.report.series.len(), "{name}");
    assert_eq!(report["skipped"].as_array().unwrap().len(), library.report.skipped.len(), "{name}");
    println!(
        "{name}: {:?} voxels of {spacing:?} mm, {range:?} {}, {}",
        volume.dims(),
        volume.unit(),
        library.report.format
    );
}

/// What a job told was loaded without a frame that waits for it.
fn assert_loads(name: &str) -> Value {
    let (job, told) = job(name);
    assert_eq!(told["error"], 0, "{name}: {told}");
    assert_eq!(told["running"], false);
    let heard = told["heard"].as_array().unwrap();
    assert_eq!(heard.last().unwrap()[0], "finished", "{name}: {heard:?}");
    let path = if name == "user" { imports().copied.clone() } else { PathBuf::from(&job.path) };
    let library = library(&path);
    assert_as_the_library(name, &told["volume"], &library);
    let progress: Vec<&Value> = heard.iter().filter(|one| one[0] == "progress").collect();
    for one in &progress {
        assert!(one[2].as_i64().unwrap() <= one[3].as_i64().unwrap(), "{name}: {one}");
    }
    println!(
        "{name}: {} frames in {:.0} ms, the longest {:.0} ms, progress {} times",
        told["frames"],
        told["ms"].as_f64().unwrap(),
        told["longest_ms"].as_f64().unwrap(),
        progress.len()
    );
    if job.blocking {
        assert_as_the_library(name, &told["blocking"], &library);
    }
    told
}

/// A main loop that waits makes one frame of the whole import.
fn assert_goes_on(name: &str, told: &Value) {
    let [longest, all, blocking] = ["longest_ms", "ms", "blocking_ms"].map(|key| told[key].as_f64().unwrap());
    let frames = told["frames"].as_u64().unwrap();
    println!(
        "{name}: {frames} frames of {longest:.0} ms at most in {all:.0} ms; a game that waits, {blocking:.0} ms"
    );
    // Where it is done in no time, there is nothing to wait for.
    if all > 60.0 {
        assert!(frames >= 3 && longest < 0.8 * all, "{name}: {frames} frames, one of {longest} of {all} ms");
    }
}

#[test]
fn a_series_arrives_as_a_folder_and_as_an_archive() {
    let series = assert_loads("series");
    assert_eq!(series["volume"]["dims"], json!([24, 24, 24]));
    assert_loads("zip");
}

#[test]
fn the_game_goes_on_while_a_scan_is_loaded() {
    let told = assert_loads("large");
    assert_goes_on("large", &told);
    let heard = told["heard"].as_array().unwrap();
    let stages: HashSet<&str> =
        heard.iter().filter(|one| one[0] == "progress").map(|one| one[1].as_str().unwrap()).collect();
    println!("large: stages {stages:?}");
    assert!(heard.len() >= 2, "{heard:?}");
    assert!(stages.contains("reading headers") || stages.contains("decoding slices"), "{stages:?}");
}

#[test]
fn other_formats_have_the_numbers_that_were_written() {
    let nrrd = assert_loads("nrrd");
    assert_eq!(numbers(&nrrd["volume"]["dims"]), [20.0, 16.0, 12.0]);
    assert_eq!(numbers(&nrrd["volume"]["spacing"]), [0.5, 0.75, 2.0]);
    assert_eq!(numbers(&nrrd["volume"]["range"]), [-700.0, 3139.0]);
    let nifti = assert_loads("nifti");
    assert_eq!(numbers(&nifti["volume"]["dims"]), [20.0, 16.0, 12.0]);
    assert_eq!(numbers(&nifti["volume"]["range"]), [-1410.0, 6268.0]);
    assert_loads("user");
}

#[test]
fn a_folder_with_rubbish_loads_and_tells_what_was_left_out() {
    let told = assert_loads("mixed");
    let skipped = told["volume"]["report"]["skipped"].as_array().unwrap();
    for file in ["notes.txt", "cut_short.dcm"] {
        let one = skipped.iter().find(|s| s["path"].as_str().unwrap().ends_with(file));
        println!("{file}: {}", one.unwrap_or_else(|| panic!("{file} is not told of: {skipped:?}"))["reason"]);
    }
}

#[test]
fn what_cannot_be_loaded_is_told_with_its_name() {
    for (name, words) in [
        ("bad_folder", &["bad_folder", "none of its 2 files"][..]),
        ("cut_short", &["cut_short.dcm"]),
        ("words", &["words.dcm"]),
        ("short_nrrd", &["short.nrrd", "cut short"]),
        ("missing", &["nowhere"]),
    ] {
        let (_, told) = job(name);
        let last = told["heard"].as_array().unwrap().last().unwrap().clone();
        println!("{name}: {last}");
        assert_eq!(last[0], "failed", "{name}");
        assert!(told["volume"].is_null(), "{name}");
        let message = last[1].as_str().unwrap();
        assert!(words.iter().all(|word| message.contains(word)), "{name}: {message}");
    }
}

#[test]
fn an_import_can_be_cancelled_and_started_again() {
    let run = &imports().run;
    let told_of = told(run, "cancelling");
    println!("cancelling: {}", told_of["cancelled"]);
    // ERR_BUSY.
    assert_eq!(told_of["busy"], 44);
    let last = |list: &Value| list.as_array().unwrap().last().unwrap()[0].clone();
    assert_eq!(last(&told_of["cancelled"]), "cancelled");
    assert!(told_of["cancelled"].as_array().unwrap().iter().all(|one| one[0] != "finished"));
    assert_eq!(last(&told_of["again"]), "finished");
    assert_eq!(told(run, "dropped")[0], "finished");
}

#[test]
fn a_scan_tells_before_it_loads() {
    let told = told(&imports().run, "scanning");
    println!("scanning: {told}");
    assert_eq!(told["scanned"][0], "scanned");
    let series = &told["scanned"][1]["series"];
    assert_eq!(series[0]["files"], 24);
    let library = library(Path::new(&job("series").0.path));
    assert_eq!(series[0]["description"], library.report.series[0].description);
    assert_eq!(series[0]["id"], library.report.series[0].id);
    assert_eq!(told["started"][0], "finished");
}

#[test]
fn the_patient_is_imported_alone_unless_everything_is_asked_for() {
    let told = told(&imports().run, "keeping");
    println!("keeping: {told}");
    let dense = |volume: &Volume| {
        let values = (0..volume.voxel_count()).map(|i| volume.voxels().get(i) + volume.intercept());
        values.filter(|value| (-700.0..=3000.0).contains(value)).count() as f64
    };
    let all = scans::torso(64);
    let alone = patient_alone(all.clone(), Progress::SILENT, &CancelToken::new()).unwrap().volume;
    assert!(dense(&alone) < 0.95 * dense(&all));
    for way in ["scanned", "started", "waited"] {
        let [patient, everything] = ["patient", "everything"].map(|name| &told[name][way]);
        let close = |a: &Value, b: f64| (a.as_f64().unwrap() - b).abs() <= 0.002 * b;
        assert!(close(&patient["dense"], dense(&alone)), "{way}: {patient}, not {}", dense(&alone));
        assert!(close(&everything["dense"], dense(&all)), "{way}: {everything}, not {}", dense(&all));
        let hidden = |notes: &Value| {
            let notes = notes.as_array().unwrap();
            notes.iter().any(|note| note.as_str().unwrap().starts_with("hidden: "))
        };
        assert!(hidden(&patient["notes"]) && !hidden(&everything["notes"]), "{way}");
    }
    let finds = |name: &str| told[name]["stages"].as_array().unwrap().contains(&json!("finding the patient"));
    assert!(!finds("everything"));
    // Put aside, and saved with it.
    assert_eq!(told["patient"]["aside"], json!([true, true]));
    assert_eq!(told["everything"]["aside"], json!([false, false]));
    assert_eq!(told["wrong"], true);
}

#[test]
fn labels_are_found_while_the_game_goes_on() {
    let told = told(&imports().run, "labelling");
    println!("labelling: {told}");
    // OK and ERR_BUSY.
    assert_eq!((&told["started"], &told["busy"]), (&json!(0), &json!(44)));
    assert_eq!(told["stopped"], json!(["cancelled"]));
    assert_eq!((&told["same"], &told["missing"]), (&json!(true), &json!("failed")));
    assert!(told["names"].as_array().unwrap().contains(&json!("lungs")), "{told}");
    assert!(told["frames"].as_u64().unwrap() > 1, "frames go on meanwhile: {told}");
    assert!(told["stages"].as_array().unwrap().contains(&json!("finding the patient")), "{told}");
    // ERR_INVALID_PARAMETER.
    assert_eq!(told["nothing"], json!([31, 31]));
}

/// Saved scans are copied, and go into exported games.
#[test]
fn a_saved_scan_tells_where_it_came_from_and_nothing_of_its_study() {
    let told = told(&imports().run, "saving");
    let session = &told["session"];
    assert!(!session["skipped"].as_array().unwrap().is_empty(), "{session}");
    let series = &session["series"][0];
    let saved = fs::read(told["file"].as_str().unwrap()).unwrap();
    let uid = series["id"].as_str().unwrap();
    // Of what lies outside of the project a word alone, which another file explains.
    let folder = Path::new(told["path"].as_str().unwrap()).parent().unwrap().to_str().unwrap();
    assert!(Path::new(folder).is_absolute(), "{folder}");
    for word in [uid, "cut_short", "notes.txt", folder] {
        let found = saved.windows(word.len()).any(|bytes| bytes == word.as_bytes());
        assert!(!found, "'{word}' is in the file");
    }
    // An older Lumivox kept none.
    assert_eq!(told["sources"], json!([[told["path"]], [told["path"]], []]), "{told}");
    for how in ["loaded", "older"] {
        let volume = &told[how];
        assert_eq!(volume["dims"], json!([24, 24, 20]), "{how}");
        let report = volume["report"].as_object().unwrap();
        let keys: HashSet<&str> = report.keys().map(String::as_str).collect();
        assert_eq!(keys, HashSet::from(["format", "notes", "series", "chosen"]), "{how}");
        assert_eq!(report["notes"], session["notes"], "{how}");
        let mut kept = series.clone();
        kept.as_object_mut().unwrap().remove("id");
        assert_eq!((&report["series"], &report["chosen"]), (&json!([kept]), &json!(0)), "{how}");
    }
}

#[test]
fn pictures_are_made_while_the_game_goes_on() {
    let told = told(&imports().run, "picturing");
    println!("picturing: {told}");
    // ERR_UNAVAILABLE.
    assert_eq!((&told["unknown"], &told["beyond"]), (&Value::from(2), &Value::from(2)));
    assert_eq!((&told["requested"], &told["at_once"]), (&Value::from(0), &Value::from(0)));
    // The last one only, as somebody who waits gets it.
    assert_eq!(told["kinds"], json!(["picture"]));
    assert_eq!((&told["size"], &told["same"]), (&Value::from(16), &Value::from(true)));
    assert_eq!((&told["started"], &told["imported"]), (&Value::from(0), &json!(["finished"])));
}

#[test]
fn the_panel_opens_the_scan_that_was_asked_for_last() {
    let told = told(&imports().run, "panelling");
    assert_eq!(told["second"], json!([true, true, true]), "the one before ends the one after: {told}");
    assert_eq!(told["stopped"], json!([true, true, false]), "{told}");
    assert_eq!((&told["shown"], &told["kept"]), (&json!(true), &json!(true)), "{told}");
    assert!(told["gone"].as_str().unwrap().contains("the node that it was for is gone"), "{told}");
}

#[test]
fn misuse_is_refused_at_once() {
    let told = told(&imports().run, "misuse");
    // ERR_INVALID_PARAMETER.
    assert_eq!((&told["nothing"], &told["option"]), (&Value::from(31), &Value::from(31)));
    assert_eq!((&told["status"], &told["heard"]), (&json!({}), &json!([])));
}

#[test]
fn real_scans_load() {
    for (name, _) in real_scans() {
        assert_goes_on(name, &assert_loads(name));
    }
}

/// C# has no classes of an extension: it calls by name, and the README says how.
#[test]
fn members_are_reached_by_the_names_in_the_readmes_c_sharp() {
    let told = told(&imports().run, "by_name");
    assert_eq!(told["unknown"], json!([]));
    assert_eq!(told["names"], 9);
    assert_eq!(told["heard"], json!([["finished"]]));
    assert_eq!(told["converged"], "bool");
    assert_eq!(told["volume"], "LumivoxVolume");
    assert_eq!(told["clip_max"], 0.5);
}
