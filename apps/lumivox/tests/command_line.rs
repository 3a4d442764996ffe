//! What the command says and how it exits, run as users run it. Rendering itself is tested in `render.rs`.

use std::{
    fs,
    path::Path,
    process::{Command, Output, Stdio},
};

struct Run {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).expect("stdout is UTF-8"),
            stderr: String::from_utf8(output.stderr).expect("stderr is UTF-8"),
        }
    }
}

fn lumivox(folder: &Path, arguments: &[&str]) -> Run {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lumivox"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null());
    Run::from(command.output().expect("the command runs"))
}

/// Checks the exit code and that stderr holds every one of `words`, without a panic.
#[track_caller]
fn fails(folder: &Path, arguments: &[&str], code: i32, words: &[&str]) {
    let run = lumivox(folder, arguments);
    assert_eq!(run.code, Some(code), "{arguments:?}\n{}", run.stderr);
    for word in words {
        assert!(run.stderr.contains(word), "'{word}' is missing for {arguments:?}:\n{}", run.stderr);
    }
    assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
    assert_eq!(run.stdout, "", "{arguments:?}");
}

/// A folder with a small scan `head` of real DICOM files.
fn folder_with_scan() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let run = lumivox(folder.path(), &["phantom", "sphere", "--size", "16", "--out", "scan", "--quiet"]);
    assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (Some(0), "", ""));
    folder
}

fn empty_folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder for temporary files")
}

#[test]
fn help_has_examples_and_exit_codes() {
    let folder = empty_folder();
    for arguments in [&["--help"][..], &["render", "--help"]] {
        let run = lumivox(folder.path(), arguments);
        assert_eq!(run.code, Some(0));
        assert!(run.stdout.contains("Examples:") && run.stdout.contains("Exit codes:"), "{}", run.stdout);
        assert!(run.stdout.contains("130"));
    }
    let run = lumivox(folder.path(), &["--version"]);
    assert_eq!((run.code, run.stdout.starts_with("lumivox ")), (Some(0), true));
}

#[test]
fn wrong_usage_exits_2_and_says_what_is_right() {
    let folder = empty_folder();
    let render = |more: &[&str], words: &[&str]| {
        fails(folder.path(), &[&["render", "scan", "-o", "a.png"], more].concat(), 2, words);
    };
    fails(folder.path(), &[], 2, &["Usage"]);
    fails(folder.path(), &["rendr"], 2, &["render"]);
    fails(folder.path(), &["render", "scan"], 2, &["--output"]);
    fails(folder.path(), &["render", "-o", "a.png"], 2, &["SCAN"]);
    render(&["--preset", "ct-bome"], &["ct-bome", "did you mean 'ct-bone'", "ct-skin"]);
    render(&["--samples", "0"], &["--samples", "1.."]);
    render(&["--samples", "many"], &["--samples"]);
    render(&["--time", "0"], &["--time"]);
    render(&["--size", "0x100"], &["--size", "1 to"]);
    render(&["--size", "100"], &["1920x1080"]);
    // What begins with a minus is a value, too, and no option of which clap has something to say.
    render(&["--size", "-5x5"], &["'-5x5'", "--size", "must be 1 to"]);
    render(&["--clip", "-1,0,0,1,1,1"], &["--clip", "from 0 to 1"]);
    render(&["--spacing", "-1,1,1"], &["'-1,1,1'", "--spacing"]);
    fails(folder.path(), &["phantom", "head", "--size", "-5", "--out", "a"], 2, &["-5 is not in 8..=1024"]);
    render(&["--size", "99999999999x2"], &["--size"]);
    render(&["--bounces", "1001"], &["1..=1000"]);
    render(&["--albedo", "1.5"], &["must be 0 to 1"]);
    render(&["--anisotropy", "nan"], &["--anisotropy"]);
    render(&["--density", "-1"], &["--density"]);
    render(&["--window-scale", "0"], &["--window-scale", "0.01 to 100"]);
    render(&["--shift", "up"], &["--shift", "not a number"]);
    render(&["--tone", "agy"], &["agx"]);
    render(&["--environment", "studoi"], &["studio, uniform, gradient"]);
    render(&["--background", "grey"], &["#202428"]);
    render(&["--clip", "0,0,0,1,1"], &["6 numbers"]);
    render(&["--eye", "0,0,9", "--azimuth", "3"], &["cannot be used with"]);
    render(&["--raw", "12"], &["--raw"]);
    render(&["--eye", "0,0,5e6"], &["within 1 km"]);
    render(&["--eye", "1,2,3", "--target", "1,2,3"], &["--eye is the point looked at"]);
    render(&["--size", "32768x32768"], &["1073 million", "memory"]);
    fails(folder.path(), &["render", "scan", "-o", "a.jpg"], 2, &["a.jpg", ".png"]);
    fails(folder.path(), &["phantom", "foot", "--out", "a"], 2, &["head", "torso", "cube"]);
    fails(folder.path(), &["phantom", "head", "--blanket", "--out", "a"], 2, &["torso"]);
    fails(folder.path(), &["phantom", "torso", "--shift", "1,2", "--out", "a"], 2, &["3 numbers"]);
    fails(folder.path(), &["phantom", "torso", "--field-of-view", "9", "--out", "a"], 2, &["50 to 1000"]);
    fails(folder.path(), &["phantom", "cube", "--size", "0", "--out", "a"], 2, &["--size"]);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing was written");
}

#[test]
fn bad_input_exits_3_and_names_the_file() {
    let folder = empty_folder();
    let path = folder.path();
    fs::create_dir(path.join("empty")).unwrap();
    fs::write(path.join("nothing.dcm"), "").unwrap();
    fs::write(path.join("page.dcm"), "<html><body>not a scan</body></html>").unwrap();
    fs::write(path.join("cut.nii"), [0x5c, 1, 0, 0, 7]).unwrap();
    fs::write(path.join("cut.nrrd"), "NRRD0004\ntype: short\ndimension: 3\nsizes: 9 9 9\n").unwrap();
    for name in ["missing", "empty", "nothing.dcm", "page.dcm", "cut.nii", "cut.nrrd"] {
        fails(path, &["info", name], 3, &[name]);
        fails(path, &["render", name, "-o", "a.png"], 3, &[name]);
    }
    // Values that no renderer can compute with.
    let header = "ObjectType = Image\nNDims = 3\nDimSize = 2 1 1\nElementType = MET_USHORT\n\
                  ElementToIntensityFunctionSlope = 1e308\nElementDataFile = LOCAL\n";
    fs::write(path.join("steep.mha"), [header.as_bytes(), &[0, 0, 255, 255]].concat()).unwrap();
    for command in [&["info", "steep.mha"][..], &["render", "steep.mha", "-o", "a.png"]] {
        fails(path, command, 3, &["steep.mha", "rescale slope 1", "Correct the header, or export"]);
    }
    assert!(!path.join("a.png").exists());
    // What no reader knows may be samples; the command's own words say how to describe them.
    fails(path, &["info", "page.dcm"], 3, &["an HTML page", "'lumivox render --help' shows", "--raw"]);
}

#[test]
fn looks_and_lights_that_cannot_be_read_exit_3() {
    let folder = folder_with_scan();
    let path = folder.path();
    fs::write(path.join("broken.tf"), "{ \"colourPoints\": [").unwrap();
    fs::write(path.join("page.hdr"), "<html>").unwrap();
    let render = |more: &[&str], words: &[&str]| {
        fails(path, &[&["render", "scan", "-o", "a.png"], more].concat(), 3, words);
    };
    render(&["--transfer-function", "broken.tf"], &["broken.tf"]);
    render(&["--transfer-function", "missing.tf"], &["missing.tf"]);
    render(&["--environment", "page.hdr"], &["page.hdr"]);
    render(&["--environment", "missing.hdr"], &["missing.hdr"]);
    render(&["--series", "77"], &["77"]);
}

#[test]
fn an_output_that_cannot_be_written_fails_before_any_work() {
    let folder = empty_folder();
    let path = folder.path();
    fs::create_dir(path.join("folder.png")).unwrap();
    // The scan is missing too: the output is looked at first.
    fails(path, &["render", "missing", "-o", "no/such/a.png"], 1, &["no/such"]);
    fails(path, &["render", "missing", "-o", "folder.png"], 1, &["folder.png"]);
}

/// A file that is read is never written, by whatever name and in whatever role.
#[test]
fn the_output_is_none_of_the_inputs() {
    let folder = empty_folder();
    let path = folder.path();
    fs::create_dir(path.join("sub")).unwrap();
    for name in ["a.png", "b.png"] {
        fs::write(path.join(name), [7; 64]).unwrap();
    }
    let words = ["the output is one of the inputs"];
    for output in ["a.png", "./sub/../a.png"] {
        fails(path, &["render", "a.png", "-o", output, "--raw", "4x4x4:u8"], 2, &words);
        fails(path, &["render", "b.png", "-o", output, "--transfer-function", "a.png"], 2, &words);
        fails(path, &["render", "b.png", "-o", output, "--environment", "a.png"], 2, &words);
    }
    assert_eq!(fs::read(path.join("a.png")).unwrap(), [7; 64]);
}

#[test]
fn every_input_is_looked_for_before_the_first_is_read() {
    let folder = folder_with_scan();
    fails(folder.path(), &["render", "scan", "missing", "-o", "a.png"], 3, &["missing"]);
}

#[test]
fn looks_must_be_one_or_as_many_as_scans() {
    let folder = folder_with_scan();
    let presets = ["--preset", "ct-bone", "--preset", "ct-skin", "--preset", "ct-lung"];
    let arguments = [&["render", "scan", "scan", "-o", "a.png"][..], &presets].concat();
    fails(folder.path(), &arguments, 2, &["--preset", "3 times for 2 scans"]);
}

#[test]
fn presets_are_listed() {
    let run = lumivox(empty_folder().path(), &["presets"]);
    assert_eq!(run.code, Some(0));
    for preset in lumivox_core::Preset::ALL {
        assert!(run.stdout.contains(preset.name()) && run.stdout.contains(preset.description()));
    }
}

#[test]
fn a_phantom_becomes_dicom_and_info_reads_it() {
    let folder = folder_with_scan();
    let run = lumivox(folder.path(), &["info", "scan"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for words in ["DICOM", "CT", "1.0000 x 1.0000 x 1.0000 mm", "HU", "ct-muscle", "█"] {
        assert!(run.stdout.contains(words), "'{words}' is missing:\n{}", run.stdout);
    }

    let run = lumivox(folder.path(), &["info", "scan", "--json"]);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let json: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    let scan = &json["scans"][0];
    assert_eq!(scan["modality"], "CT");
    assert_eq!(scan["value_range"][1], 1000.0);
    let voxels: u64 = scan["dims"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).product();
    let counted = scan["histogram"]["counts"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap());
    assert_eq!(counted.sum::<u64>(), voxels);
}

/// A NIfTI scan of 2 x 2 x 2 bytes.
fn nifti() -> Vec<u8> {
    let mut bytes = vec![0; 352];
    bytes[0..4].copy_from_slice(&348i32.to_le_bytes());
    for (at, value) in [(40, 3i16), (42, 2), (44, 2), (46, 2), (70, 2), (72, 8)] {
        bytes[at..at + 2].copy_from_slice(&value.to_le_bytes());
    }
    for (at, value) in [(80, 1.0f32), (84, 1.0), (88, 1.0), (108, 352.0)] {
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
    bytes[344..348].copy_from_slice(b"n+1\0");
    bytes.extend([0, 1, 2, 3, 4, 5, 6, 7]);
    bytes
}

#[test]
fn info_lists_the_labels_of_a_label_map() {
    let folder = tempfile::tempdir().unwrap();
    let header = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 10 10 10\nspace: left-posterior-superior\n\
                  space directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (0,0,0)\nencoding: raw\n\
                  Segment0_Name:=right lung\nSegment0_Color:=1 0.501961 0\nSegment0_LabelValue:=3\n\
                  Segment0_Layer:=0\n\n";
    let mut voxels = vec![3; 500];
    voxels.resize(1000, 0);
    std::fs::write(folder.path().join("a.seg.nrrd"), [header.as_bytes(), &voxels].concat()).unwrap();
    let run = lumivox(folder.path(), &["info", "a.seg.nrrd"]);
    let text = &run.stdout;
    assert!(text.contains("           3  #ff8000        4.00 ml  right lung\n"), "{text}");
    assert!(text.contains("preset  plain"), "{text}");
    assert!(!text.contains("logarithmic"), "{text}");
    let run = lumivox(folder.path(), &["info", "a.seg.nrrd", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let expected =
        serde_json::json!([{"value": 3, "name": "right lung", "color": "#ff8000", "volume_mm3": 4000.0}]);
    assert_eq!(json["scans"][0]["labels"], expected);
}

#[test]
fn phantoms_of_mr_become_mr_and_their_looks_suit_them() {
    let folder = tempfile::tempdir().unwrap();
    for (kind, preset) in [("mr-head", "mr-head"), ("mr-brain", "mr-brain")] {
        let made = lumivox(folder.path(), &["phantom", kind, "--size", "128", "--out", kind]);
        assert!(made.stdout.contains("Wrote 128 DICOM files"), "{}", made.stderr);
        let run = lumivox(folder.path(), &["info", kind]);
        assert!(run.stdout.contains("modality  MR\n"), "{}", run.stdout);
        assert!(run.stdout.contains(&format!("preset  {preset} ")), "{}", run.stdout);
    }
}

#[test]
fn info_never_names_the_patient() {
    let folder = folder_with_scan();
    let path = folder.path();
    // The phantom's patient is called Phantom^Lumivox; a file name may hold a name too.
    fs::write(path.join("scan/Mustermann_Erika.txt"), "letter").unwrap();
    fs::write(path.join("Mustermann_Erika_1970.nii"), nifti()).unwrap();
    // A slice whose SeriesInstanceUID has another tag; one whose is text.
    let slice = fs::read_dir(path.join("scan")).unwrap().map(|entry| entry.unwrap().path());
    let mut slice =
        fs::read(slice.into_iter().find(|path| path.extension().unwrap() == "dcm").unwrap()).unwrap();
    let uid = slice.windows(6).position(|head| head == b"\x20\0\x0E\0UI").expect("an explicit element");
    slice[uid + 8] = b'M';
    fs::write(path.join("Mustermann_Erika_1971.dcm"), &slice).unwrap();
    slice[uid + 2] = 0x0F;
    fs::write(path.join("Mustermann_Erika_1972.dcm"), &slice).unwrap();
    for (scan, has_uid) in [
        ("scan", true),
        ("Mustermann_Erika_1970.nii", false),
        ("Mustermann_Erika_1971.dcm", false),
        ("Mustermann_Erika_1972.dcm", false),
    ] {
        for more in [&[][..], &["--json"]] {
            let run = lumivox(path, &[&["info", scan], more].concat());
            assert_eq!(run.code, Some(0), "{}", run.stderr);
            if !more.is_empty() {
                let json: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
                let id = &json["scans"][0]["series"][0]["id"];
                assert_eq!(id.as_str().is_some(), has_uid, "{scan}: {id}");
            }
            let all = (run.stdout + &run.stderr).to_lowercase();
            for name in ["phantom^", "lumivox-phantom", "mustermann", "erika"] {
                assert!(!all.contains(name), "{name} of {scan} in:\n{all}");
            }
        }
    }
}

#[test]
fn a_phantom_does_not_mix_with_other_files() {
    let folder = empty_folder();
    fs::create_dir(folder.path().join("mine")).unwrap();
    fs::write(folder.path().join("mine/letter.txt"), "dear").unwrap();
    let arguments = ["phantom", "cube", "--size", "8", "--out", "mine", "--quiet"];
    fails(folder.path(), &arguments, 1, &["letter.txt", "empty folder"]);
    fs::write(folder.path().join("file"), "").unwrap();
    fails(folder.path(), &["phantom", "cube", "--size", "8", "--out", "file", "--quiet"], 1, &["file"]);
}

/// A file-size limit stands in for a full disk: the write fails in the middle.
#[cfg(unix)]
#[test]
fn a_full_disk_is_an_error_and_leaves_no_half_slices() {
    let folder = empty_folder();
    let script = "ulimit -f 4; exec \"$0\" phantom cube --size 64 --out scan --quiet";
    let output = Command::new("sh")
        .current_dir(folder.path())
        .args(["-c", script, env!("CARGO_BIN_EXE_lumivox")])
        .output()
        .expect("sh runs");
    let run = Run::from(output);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(run.stderr.contains("scan") && run.stderr.contains("error: cannot"), "{}", run.stderr);
    let slices = fs::read_dir(folder.path().join("scan")).unwrap().flatten();
    assert_eq!(slices.filter(|entry| entry.path().extension().is_some_and(|e| e == "dcm")).count(), 0);
}

/// `lumivox presets | head -1` must not panic because nobody reads on.
#[cfg(unix)]
#[test]
fn a_reader_that_stops_early_is_no_error() {
    let script = "\"$0\" render --help | true; \"$0\" presets | true";
    let output =
        Command::new("sh").args(["-c", script, env!("CARGO_BIN_EXE_lumivox")]).output().expect("sh runs");
    let run = Run::from(output);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
}

#[test]
fn doctor_reports_and_its_exit_code_tells_whether_rendering_works() {
    let folder = empty_folder();
    let run = lumivox(folder.path(), &["doctor", "--pictures", "made/here"]);
    assert!(run.stdout.starts_with("lumivox "), "{}", run.stdout);
    let pictures = fs::read_dir(folder.path().join("made/here")).unwrap().count();
    assert_eq!(pictures, run.stdout.matches(": a test picture in ").count(), "{}", run.stdout);
    let works = run.stdout.contains("All is well") || run.stdout.contains("Rendering works");
    assert_eq!(run.code, Some(if works { 0 } else { 4 }), "{}\n{}", run.stdout, run.stderr);
}

#[test]
fn import_lists_series_and_what_was_left_out_and_writes_pictures() {
    let folder = folder_with_scan();
    fs::write(folder.path().join("scan/README.txt"), "not a scan").unwrap();
    let run = lumivox(folder.path(), &["import", "scan", "--thumbnails", "pictures"]);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    for words in
        ["DICOM, 1 series", "17 x 17 x 17 voxels", "axial, HU", "it is not a DICOM file", "README.txt"]
    {
        assert!(run.stdout.contains(words), "'{words}' is missing:\n{}", run.stdout);
    }
    let picture = fs::read(folder.path().join("pictures/series-001.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));

    let run = lumivox(folder.path(), &["import", "scan", "--json", "--thumbnails", "pictures"]);
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let series = &json["scans"][0]["series"][0];
    assert_eq!(series["dims"], serde_json::json!([17, 17, 17]));
    assert_eq!((&series["phases"], &series["unit"]), (&1.into(), &"HU".into()));
    assert_eq!((&series["reason"], &series["segments_series"]), (&"".into(), &serde_json::Value::Null));
    assert!(series["thumbnail"].as_str().unwrap().ends_with("series-001.png"));
    assert_eq!(json["scans"][0]["skipped_by_reason"]["it is not a DICOM file"], 1);
    assert_eq!(json["scans"][0]["skipped"][0]["path"], "README.txt", "the folder may be called by a name");

    fails(folder.path(), &["import", "missing"], 3, &["missing"]);
    fails(folder.path(), &["import", "scan/README.txt"], 3, &["this is a text file"]);
    fails(folder.path(), &["info", "scan", "--phase", "2"], 3, &["there is no phase 2; it has 1"]);

    // Of a damaged scan beside other files the error names the scan.
    let slice = fs::read_dir(folder.path().join("scan")).unwrap().map(|entry| entry.unwrap().path());
    let slice = fs::read(slice.into_iter().find(|path| !path.ends_with("README.txt")).unwrap()).unwrap();
    fs::create_dir(folder.path().join("cut")).unwrap();
    fs::write(folder.path().join("cut/README.txt"), "not a scan").unwrap();
    fs::write(folder.path().join("cut/1.dcm"), &slice[..slice.len() - 9]).unwrap();
    let named = "'1.dcm' was left out: cut short: ";
    for command in [&["info", "cut"][..], &["render", "cut", "-o", "a.png"]] {
        fails(folder.path(), command, 3, &[named]);
    }
    let run = lumivox(folder.path(), &["import", "cut"]);
    assert!(run.code == Some(3) && run.stderr.contains(named), "{}", run.stderr);

    // Of one that is damaged within a scan it is said what fills it in.
    let slices = fs::read_dir(folder.path().join("scan")).unwrap().map(|entry| entry.unwrap().path());
    let mut slices: Vec<_> = slices.filter(|path| !path.ends_with("README.txt")).collect();
    slices.sort();
    fs::write(&slices[8], &slice[..slice.len() / 2]).unwrap();
    for (options, says) in [(&["info", "scan"][..], true), (&["info", "scan", "--fill-damaged"], false)] {
        let run = lumivox(folder.path(), options);
        assert_eq!(run.stdout.contains("--fill-damaged fills in slices"), says, "{}", run.stdout);
    }
}

/// The hidden decoder stays a decoder: it reads frames, and ends with its input.
#[test]
fn the_codec_worker_ends_with_its_input() {
    let folder = empty_folder();
    let run = lumivox(folder.path(), &["--codec-worker"]);
    assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (Some(0), "", ""));
}

#[test]
fn a_header_names_no_file_elsewhere_unless_that_is_allowed() {
    let folder = empty_folder();
    fs::create_dir(folder.path().join("scan")).unwrap();
    fs::write(folder.path().join("private"), [1, 2, 3, 4]).unwrap();
    let header = "ObjectType = Image\nNDims = 3\nDimSize = 2 2 1\nElementType = MET_UCHAR\n\
                  ElementDataFile = ../private\n";
    fs::write(folder.path().join("scan/a.mhd"), header).unwrap();
    fails(
        folder.path(),
        &["info", "scan/a.mhd"],
        3,
        &["does not lie beside the header", "--allow-outside-data"],
    );
    let run = lumivox(folder.path(), &["info", "scan/a.mhd", "--allow-outside-data", "--json"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(json["scans"][0]["dims"], serde_json::json!([2, 2, 1]));
}

/// With --json there is one object on stdout, whatever happens; words for people are on stderr, and the exit code is the same.
#[test]
fn errors_are_json_too_where_that_is_asked_for() {
    let folder = folder_with_scan();
    let path = folder.path();
    fs::create_dir(path.join("empty")).unwrap();
    fs::write(path.join("page.dcm"), "<html><body>not a scan</body></html>").unwrap();
    fs::create_dir(path.join("pages")).unwrap();
    fs::copy(path.join("page.dcm"), path.join("pages/a.dcm")).unwrap();
    let cases: [(&[&str], i32, &str); 8] = [
        (&["import", "missing"], 3, "missing"),
        (&["import", "empty"], 3, "empty"),
        (&["import", "page.dcm"], 3, "page.dcm"),
        (&["import", "pages"], 3, "pages"),
        (&["info", "missing"], 3, "missing"),
        (&["info", "scan", "--phase", "2"], 3, "there is no phase 2"),
        (&["import", "scan", "--series", "77"], 3, "77"),
        (&["import", "scan", "--thumbnail-size", "-5"], 2, "-5"),
    ];
    for (arguments, code, word) in cases {
        for arguments in
            [[arguments, &["--json"]].concat(), [&[arguments[0], "--json"], &arguments[1..]].concat()]
        {
            let run = lumivox(path, &arguments);
            assert_eq!(run.code, Some(code), "{arguments:?}: {}", run.stderr);
            let json: serde_json::Value = serde_json::from_str(&run.stdout)
                .unwrap_or_else(|error| panic!("{arguments:?}: {error} in '{}'", run.stdout));
            assert_eq!(json["exit_code"], code, "{arguments:?}");
            assert!(json["error"].as_str().unwrap().contains(word), "{arguments:?}: {json}");
            assert!(run.stderr.contains(word), "{arguments:?}: {}", run.stderr);
        }
    }
    // Of a study without a volume it is told, too, what it has.
    fs::create_dir(path.join("cut")).unwrap();
    let slice = fs::read_dir(path.join("scan")).unwrap().next().unwrap().unwrap().path();
    let slice = fs::read(slice).unwrap();
    fs::write(path.join("cut/1.dcm"), &slice[..slice.len() - 9]).unwrap();
    let run = lumivox(path, &["import", "cut", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!((run.code, &json["exit_code"]), (Some(3), &3.into()));
    assert_eq!(json["scans"][0]["skipped"][0]["path"], "1.dcm", "{json}");
    let run = lumivox(path, &["import", "scan", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(json.get("error").is_none() && json.get("exit_code").is_none(), "{json}");
}

/// Who wants nothing but errors says so to every command that says how far it is.
#[test]
fn quiet_is_heard_everywhere() {
    let folder = folder_with_scan();
    for command in [&["import", "scan"][..], &["info", "scan"], &["doctor"]] {
        for quiet in ["-q", "--quiet"] {
            let run = lumivox(folder.path(), &[command, &[quiet]].concat());
            assert_ne!(run.code, Some(2), "{}", run.stderr);
            assert_eq!(run.stderr, "", "{command:?}");
            assert!(!run.stdout.is_empty());
        }
    }
}

fn write_slices(folder: &Path, names: &[&str]) {
    fs::create_dir_all(folder).unwrap();
    for name in names {
        let file = fs::File::create(folder.join(name)).unwrap();
        let mut encoder = png::Encoder::new(file, 4, 4);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.write_header().unwrap().write_image_data(&[7; 16]).unwrap();
    }
}

/// A picture among the slices of a scan would be one of them at the next run.
#[test]
fn no_output_lies_among_slices() {
    let folder = empty_folder();
    let path = folder.path();
    write_slices(&path.join("slices"), &["1.png", "2.png", "3.png"]);
    let words = ["among the slices of a scan", "another folder"];
    fails(path, &["render", "slices", "-o", "slices/out.png"], 2, &words);
    fails(&path.join("slices"), &["render", ".", "-o", "out.png"], 2, &words);
    fails(path, &["render", "slices", "-o", "slices/2.png"], 2, &words);
    fails(path, &["render", "slices/1.png", "slices/2.png", "-o", "slices/out.png"], 2, &words);
    fails(path, &["scene", "save", "slices/out.json", "slices"], 2, &words);
    fails(path, &["import", "slices", "--thumbnails", "slices"], 2, &words);
    assert_eq!(fs::read_dir(path.join("slices")).unwrap().count(), 3);
    // Where one got there all the same, it is named, and not the slices.
    let file = fs::File::create(path.join("slices/0-out.png")).unwrap();
    png::Encoder::new(file, 2, 2).write_header().unwrap().write_image_data(&[7; 4]).unwrap();
    fails(path, &["info", "slices"], 3, &["0-out.png", "2 x 2 pixels", "Move it elsewhere"]);
}

/// A slice that is dropped alone is part of a scan, mostly.
#[test]
fn a_slice_alone_tells_of_the_others() {
    let folder = folder_with_scan();
    let path = folder.path();
    let mut slices: Vec<_> =
        fs::read_dir(path.join("scan")).unwrap().map(|entry| entry.unwrap().path()).collect();
    slices.sort();
    let first = slices[0].to_str().unwrap();
    let note = "16 other files of this series lie beside it; give its folder to see all";
    for command in ["info", "import"] {
        let run = lumivox(path, &[command, first]);
        assert_eq!((run.code, run.stdout.matches(note).count()), (Some(0), 1), "{}", run.stdout);
        let run = lumivox(path, &[command, "scan"]);
        assert!(!run.stdout.contains("lie beside it"), "{}", run.stdout);
    }
    fs::create_dir(path.join("alone")).unwrap();
    fs::copy(first, path.join("alone/1.dcm")).unwrap();
    let run = lumivox(path, &["info", "alone/1.dcm"]);
    assert!(run.code == Some(0) && !run.stdout.contains("beside it"), "{}", run.stdout);
}

/// Completions of shells know the names of presets.
#[test]
fn shells_complete_presets() {
    let folder = empty_folder();
    let run = lumivox(folder.path(), &["manual", "made"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for shell in ["lumivox.bash", "_lumivox", "lumivox.fish"] {
        let text = fs::read_to_string(folder.path().join("made/completions").join(shell)).unwrap();
        for preset in lumivox_core::Preset::ALL {
            assert!(text.contains(preset.name()), "{shell} lacks {}", preset.name());
        }
    }
    let help = lumivox(folder.path(), &["render", "--help"]).stdout;
    assert!(!help.contains("possible values: ct-bone"), "{help}");
}
