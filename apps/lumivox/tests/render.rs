//! Rendering through the command, on whatever GPU there is: software Vulkan counts, none at all is a failure.

use std::{
    fs::{self, File},
    io::{BufRead, BufReader, Lines},
    path::Path,
    process::{Child, ChildStderr, Command, Output, Stdio},
    time::Duration,
};

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lumivox"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null());
    command
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("the command runs")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with a small sphere of bone as DICOM in `scan`.
fn folder_with_scan() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let output = run(folder.path(), &["phantom", "sphere", "--size", "24", "--out", "scan", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    folder
}

/// Renders `scan` to `name` in a few samples and reads the picture back.
#[track_caller]
fn render(folder: &Path, name: &str, more: &[&str]) -> (png::ColorType, [u32; 2], Vec<u8>) {
    let arguments = ["render", "scan", "-o", name, "--preset", "ct-bone", "--samples", "4", "--quiet"];
    let arguments = [&arguments[..], &["--size", "24x16"], more].concat();
    let output = run(folder, &arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}\n{}", stderr(&output));
    assert_eq!((stderr(&output).as_str(), output.stdout.as_slice()), ("", &b""[..]), "quiet");
    read_png(&folder.join(name))
}

fn read_png(path: &Path) -> (png::ColorType, [u32; 2], Vec<u8>) {
    let decoder = png::Decoder::new(BufReader::new(File::open(path).expect("the picture is there")));
    let mut reader = decoder.read_info().expect("it is a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut pixels).expect("it is whole");
    let info = reader.info();
    (info.color_type, [info.width, info.height], pixels)
}

#[test]
fn a_dicom_folder_becomes_a_picture() {
    let folder = folder_with_scan();
    let (color, size, pixels) = render(folder.path(), "a.png", &["--background", "#102030"]);
    assert_eq!((color, size), (png::ColorType::Rgb, [24, 16]));
    assert_eq!(pixels[..3], [0x10, 0x20, 0x30], "nothing but background in the corner");
    let centre = (8 * 24 + 12) * 3;
    assert!(
        pixels[centre..centre + 3].iter().all(|&c| c > 60),
        "lit bone in the centre: {:?}",
        &pixels[centre..centre + 3]
    );
    let left = fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(left, 2, "the scan and the picture, nothing else");
}

#[test]
fn a_seed_is_an_image() {
    let folder = folder_with_scan();
    let first = render(folder.path(), "a.png", &["--seed", "5"]);
    assert_eq!(render(folder.path(), "b.png", &["--seed", "5"]), first);
    assert_ne!(render(folder.path(), "c.png", &["--seed", "6"]), first);
}

#[test]
fn transparent_pictures_have_alpha() {
    let folder = folder_with_scan();
    let (color, _, pixels) = render(folder.path(), "a.png", &["--background", "transparent"]);
    assert_eq!(color, png::ColorType::Rgba);
    assert_eq!(pixels[3], 0);
    assert_eq!(pixels[(8 * 24 + 12) * 4 + 3], 255);
}

#[test]
fn slices_listed_by_a_shell_are_one_scan_and_folders_are_many() {
    let folder = folder_with_scan();
    let whole = render(folder.path(), "a.png", &[]);
    let mut slices: Vec<String> = fs::read_dir(folder.path().join("scan"))
        .unwrap()
        .map(|entry| format!("scan/{}", entry.unwrap().file_name().to_str().unwrap()))
        .collect();
    slices.sort();
    let options = ["-o", "b.png", "--preset", "ct-bone", "--samples", "4", "--quiet", "--size", "24x16"];
    let slices: Vec<&str> = slices.iter().map(String::as_str).collect();
    let output = run(folder.path(), &[&["render"][..], &slices, &options].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(read_png(&folder.path().join("b.png")), whole);

    // Twice the same body in one place is denser, not another shape.
    let output = run(folder.path(), &[&["render", "scan", "scan"], &options[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

/// The same scan by two paths is rendered as it was asked for, and that is said; with two looks it is meant so.
#[test]
fn a_scan_that_is_given_twice_is_told() {
    let folder = folder_with_scan();
    let path = folder.path();
    fs::create_dir(path.join("copy")).unwrap();
    for slice in fs::read_dir(path.join("scan")).unwrap().map(Result::unwrap) {
        fs::copy(slice.path(), path.join("copy").join(slice.file_name())).unwrap();
    }
    let note = "scan 2 is scan 1 once more";
    let looks = ["--preset", "ct-bone", "--preset", "ct-skin"];
    for (scans, more, is_told) in [
        (["scan", "./scan"], &[][..], true),
        (["scan", "copy"], &[], true),
        (["scan", "copy"], &looks, false),
        (["scan", "scan"], &looks, false),
    ] {
        let (code, told) = said(path, &[&scans[..], more].concat());
        assert_eq!((code, told.contains(note)), (Some(0), is_told), "{scans:?} {more:?}: {told}");
    }
    let (code, told) = said(path, &["scan"]);
    assert!(code == Some(0) && !told.contains("once more"), "{told}");
}

#[test]
fn time_limits_end_a_render() {
    let folder = folder_with_scan();
    let output = run(folder.path(), &["render", "scan", "-o", "a.png", "--size", "16x16", "--time", "0.5"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(stdout.starts_with("Wrote a.png (16 x 16, "), "{stdout}");
    assert!(stderr(&output).contains("ms per sample"), "{}", stderr(&output));
    assert!(
        !stderr(&output).contains("the time was over"),
        "as many as there is time for: {}",
        stderr(&output)
    );

    let both = ["render", "scan", "-o", "a.png", "--size", "16x16", "--time", "0.1", "--samples", "1000000"];
    let output = run(folder.path(), &both);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("of the 1000000 samples per pixel"), "{}", stderr(&output));
}

/// A scene whose first sample takes far longer than there is time: what there is of it is kept, and it is said.
#[test]
fn time_limits_hold_before_the_first_sample() {
    let folder = folder_with_scan();
    let size = ["--size", "1024x1024", "--preset", "ct-xray", "--density", "1000", "--time", "0.2"];
    let begin = std::time::Instant::now();
    let output = run(folder.path(), &[&["render", "scan", "-o", "a.png"][..], &size].concat());
    // On a GPU it may be quick enough.
    if output.status.code() != Some(0) {
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        assert!(
            stderr(&output).contains("The time was over before every pixel had a sample"),
            "{}",
            stderr(&output)
        );
    }
    assert!(folder.path().join("a.png").is_file());
    assert!(begin.elapsed() < Duration::from_secs(60), "{:?}", begin.elapsed());
}

/// A render of `scan` to `a.png` that traces and would go on for ten minutes, and what it says from then on.
#[cfg(unix)]
fn tracing(folder: &Path) -> (Child, Lines<BufReader<ChildStderr>>) {
    let arguments = ["render", "scan", "-o", "a.png", "--size", "32x32", "--time", "600"];
    let mut child = command(folder, &arguments).stderr(Stdio::piped()).spawn().expect("it starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    let tracing = lines.by_ref().map_while(Result::ok).find(|line| line.starts_with("tracing on"));
    assert!(tracing.is_some(), "it says when it begins to trace");
    (child, lines)
}

/// Ctrl-C while tracing: the picture so far is there, and the exit code says that it is not finished.
#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_picture() {
    let folder = folder_with_scan();
    let (mut child, lines) = tracing(folder.path());
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.is_ok_and(|status| status.success()));
    let rest: Vec<String> = lines.map_while(Result::ok).collect();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest:?}");
    assert!(rest.last().is_some_and(|line| line.contains("a.png")), "{rest:?}");
    assert_eq!(read_png(&folder.path().join("a.png")).1, [32, 32]);
}

/// Drivers in software kept the code of every dispatch, some 30 MB a second.
#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_samples() {
    let folder = folder_with_scan();
    let (mut child, _lines) = tracing(folder.path());
    let status = format!("/proc/{}/status", child.id());
    let kilobytes = || -> u64 {
        let status = fs::read_to_string(&status).expect("it runs");
        let line = status.lines().find(|line| line.starts_with("VmRSS:")).expect("it has memory");
        line.split_whitespace().nth(1).and_then(|number| number.parse().ok()).expect("kB")
    };
    std::thread::sleep(Duration::from_secs(2));
    let before = kilobytes();
    std::thread::sleep(Duration::from_secs(3));
    let after = kilobytes();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(after < before + (24 << 10), "{before} kB became {after} kB in three seconds");
}

#[test]
fn a_gpu_that_is_not_there_exits_4_and_names_those_that_are() {
    let folder = folder_with_scan();
    let output = run(folder.path(), &["render", "scan", "-o", "a.png", "--gpu", "Voodoo 2"]);
    assert_eq!(output.status.code(), Some(4));
    assert!(
        stderr(&output).contains("no GPU's name contains 'Voodoo 2'. There are: "),
        "{}",
        stderr(&output)
    );
}

/// Elsewhere drivers are not found through files.
#[cfg(target_os = "linux")]
#[test]
fn without_any_gpu_the_exit_code_is_4_and_the_remedy_is_named() {
    let folder = folder_with_scan();
    for arguments in [&["render", "scan", "-o", "a.png"][..], &["doctor"]] {
        let output = command(folder.path(), arguments)
            .env("VK_DRIVER_FILES", "/nonexistent.json")
            .env("VK_ICD_FILENAMES", "/nonexistent.json")
            .output()
            .expect("the command runs");
        assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
        let remedy = if arguments[0] == "doctor" { "VK_DRIVER_FILES is set" } else { "lumivox doctor" };
        assert!(stderr(&output).contains(remedy), "{}", stderr(&output));
    }
    assert!(!folder.path().join("a.png").exists());
}

/// `lumivox render ... 2>&1 | head -1`, and a log on a full disk: nobody reads, but the picture is made.
#[cfg(unix)]
#[test]
fn the_picture_is_made_though_nobody_listens() {
    let folder = folder_with_scan();
    let sinks: &[&str] = if cfg!(target_os = "linux") { &["| true", ">/dev/full"] } else { &["| true"] };
    for sink in sinks {
        let script = format!(
            "(\"$0\" render scan -o a.png --samples 2 --size 16x16 2>&1 >/dev/null; echo $? >code) 2>&1 {sink}"
        );
        let mut shell = Command::new("sh");
        shell.current_dir(folder.path()).args(["-c", &script, env!("CARGO_BIN_EXE_lumivox")]);
        shell.output().expect("sh runs");
        // The reader of the pipe does not wait for the writer.
        let code = folder.path().join("code");
        let begin = std::time::Instant::now();
        while fs::read_to_string(&code).unwrap_or_default().is_empty() && begin.elapsed().as_secs() < 60 {
            std::thread::sleep(std::time::Duration::from_millis(50));
        }
        assert_eq!(fs::read_to_string(&code).unwrap().trim(), "0", "{sink}");
        assert_eq!(read_png(&folder.path().join("a.png")).1, [16, 16], "{sink}");
        fs::remove_file(code).unwrap();
        fs::remove_file(folder.path().join("a.png")).unwrap();
    }
}

/// The signal of a file-size limit would end the process with a half-written file beside the picture.
#[cfg(unix)]
#[test]
fn a_file_size_limit_is_an_error_and_leaves_nothing() {
    let folder = folder_with_scan();
    fs::create_dir(folder.path().join("temporary")).unwrap();
    let script = "ulimit -f 1; exec \"$0\" render scan -o a.png --samples 1 --size 96x96 --quiet";
    let output = Command::new("sh")
        .current_dir(folder.path())
        .env("TMPDIR", folder.path().join("temporary"))
        // Drivers write caches; not here.
        .env("MESA_SHADER_CACHE_DISABLE", "true")
        .args(["-c", script, env!("CARGO_BIN_EXE_lumivox")])
        .output()
        .expect("sh runs");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("cannot write a.png"), "{}", stderr(&output));
    let names = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    assert_eq!(names.filter(|name| name != "scan" && name != "temporary").count(), 0);
    assert_eq!(fs::read_dir(folder.path().join("temporary")).unwrap().count(), 0);
}

/// Ctrl-C before every pixel has a sample: the earlier picture is worth more.
#[cfg(unix)]
#[test]
fn an_early_ctrl_c_spares_the_earlier_picture() {
    let folder = folder_with_scan();
    fs::write(folder.path().join("a.png"), "good").unwrap();
    let arguments = ["render", "scan", "-o", "a.png", "--size", "2048x2048", "--bounces", "1000"];
    let mut child = command(folder.path(), &arguments).stderr(Stdio::piped()).spawn().expect("it starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    assert!(lines.by_ref().map_while(Result::ok).any(|line| line.starts_with("tracing on")));
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.is_ok_and(|status| status.success()));
    let rest: Vec<String> = lines.map_while(Result::ok).collect();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest:?}");
    let all = rest.join("\n");
    if all.contains("% of the picture") {
        assert!(all.contains("a.partial.png"), "{all}");
        assert!(!all.contains("per sample"), "{all}");
        assert_eq!(fs::read(folder.path().join("a.png")).unwrap(), b"good");
    } else {
        // A GPU that is through with its first sample by then.
        assert!(all.contains("sample"), "{all}");
    }
}

#[test]
fn a_picture_of_nothing_is_said_to_be() {
    let folder = folder_with_scan();
    let arguments = ["render", "scan", "-o", "a.png", "--size", "8x8", "--samples", "1"];
    let output = run(folder.path(), &[&arguments[..], &["--eye", "0,0,500", "--target", "0,0,900"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("no ray met the scan"), "{}", stderr(&output));
    let output = run(folder.path(), &arguments);
    assert!(!stderr(&output).contains("no ray met the scan"), "{}", stderr(&output));
}

#[test]
fn the_patient_is_shown_alone_unless_everything_is_asked_for() {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let path = folder.path();
    let output = run(path, &["phantom", "torso", "--size", "64", "--out", "scan", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    // From behind the table hides the back.
    let picture = |name: &str, more: &[&str]| {
        let looks = ["--preset", "ct-skin", "--azimuth", "180", "--background", "transparent"];
        let small = ["--size", "24x24", "--samples", "16"];
        let output = run(path, &[&["render", "scan", "-o", name], &looks[..], &small[..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        (read_png(&path.join(name)).2, stderr(&output))
    };
    let (alone, says) = picture("alone.png", &[]);
    assert!(says.contains("note: hidden: ") && says.contains("'--keep everything' shows it"), "{says}");
    let (peeled, says) = picture("peeled.png", &["--peel", "40"]);
    assert!(says.contains("40 mm below the skin are taken off"), "{says}");
    let (all, says) = picture("all.png", &["--keep", "everything"]);
    assert!(!says.contains("hidden"), "{says}");
    assert!(alone != all && alone != peeled);
    let info = run(path, &["info", "scan", "--json"]);
    let info: serde_json::Value = serde_json::from_slice(&info.stdout).expect("JSON");
    let shows = &info["scans"][0]["shows"];
    assert!(shows["confidence"].as_f64().unwrap() > 0.8, "{shows}");
    let parts = shows["parts"].as_array().unwrap();
    let lungs = parts.iter().find(|part| part["what"] == "lungs").expect("lungs");
    assert!(lungs["volume_mm3"].as_f64().unwrap() > 1e6, "{shows}");
    // Numbers are of what was scanned.
    assert!(info["scans"][0]["value_range"][1].as_f64().unwrap() > 500.0, "{info}");

    let output = run(path, &["render", "scan", "-o", "no.png", "--keep", "everything", "--peel", "3"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("--peel"), "{}", stderr(&output));
}

/// The shares of a transparent picture's pixels that show anything, in its left and in its right half.
fn seen_in_halves(folder: &Path, name: &str, more: &[&str]) -> [f64; 2] {
    // The camera must not frame what is left.
    let view = ["--background", "transparent", "--eye", "0,0,60", "--target", "0,0,0", "--fov", "28"];
    let (_, [width, height], pixels) = render(folder, name, &[&view[..], more].concat());
    let seen = |columns: std::ops::Range<u32>| {
        let all = columns.len() as f64 * f64::from(height);
        let shown = |x: u32, y: u32| pixels[((y * width + x) * 4 + 3) as usize] > 40;
        let count =
            columns.flat_map(|x| (0..height).map(move |y| (x, y))).filter(|&(x, y)| shown(x, y)).count();
        count as f64 / all
    };
    [seen(0..width / 2), seen(width / 2..width)]
}

#[test]
fn a_clip_shape_keeps_its_side_and_inverted_the_other() {
    let folder = folder_with_scan();
    let seen = |name: &str, more: &[&str]| seen_in_halves(folder.path(), name, more);
    let whole = seen("whole.png", &[]);
    assert!(whole[0] > 0.1 && (whole[0] - whole[1]).abs() < 0.06, "{whole:?}");
    // The patient's left, at the viewer's right.
    let right = seen("right.png", &["--clip-shape", "plane:0,0,0,1,0,0"]);
    assert!(right[0] < 0.02 && (right[1] - whole[1]).abs() < 0.06, "{right:?}");
    let left = seen("left.png", &["--clip-shape", "!plane:0,0,0,1,0,0"]);
    assert!((left[0] - whole[0]).abs() < 0.06 && left[1] < 0.02, "{left:?}");
    let nothing = seen("nothing.png", &["--clip-shape", "sphere:0,0,900,10"]);
    assert_eq!(nothing, [0.0; 2]);
}

#[test]
fn a_window_moves_what_is_seen() {
    let folder = folder_with_scan();
    let seen = |name, more: &[&str]| seen_in_halves(folder.path(), name, more);
    let whole = seen("whole.png", &[]);
    assert!(whole[0] > 0.05, "{whole:?}");
    assert_eq!(seen("beyond.png", &["--shift", "5000"]), [0.0; 2], "no voxel is so dense");
    assert_eq!(seen("as-it-was.png", &["--shift", "0", "--window-scale", "1"]), whole);
    let early = seen("early.png", &["--shift", "-300", "--window-scale", "0.9"]);
    assert!(early[0] >= whole[0], "{early:?} {whole:?}");
}

#[test]
fn labels_hide_and_spare_parts_of_a_scan() {
    let folder = folder_with_scan();
    // Coarser than the scan; what is on the patient's left of its centre has the label 1.
    let mut file =
        b"NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 16 16 16\n".to_vec();
    file.extend(b"space directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (-15,-15,-15)\nencoding: raw\n\n");
    file.extend((0..16usize.pow(3)).map(|i| u8::from(i % 16 >= 8)));
    fs::write(folder.path().join("half.nrrd"), file).unwrap();
    let labels = ["--labels", "half.nrrd"];
    let seen = |name: &str, more: &[&str]| seen_in_halves(folder.path(), name, &[&labels[..], more].concat());
    let whole = seen("whole.png", &[]);
    assert!(whole[0] > 0.1 && whole[1] > 0.1, "{whole:?}");
    let cut = ["--clip-shape", "sphere:0,0,900,10", "--label", "1=uncut"];
    let spared = seen("spared.png", &cut);
    // Borders of labels are smooth: a column of pixels beyond them shows something, too.
    assert!(spared[0] < 0.6 * spared[1] && spared[1] > 0.1, "what is labelled is not cut: {spared:?}");
    let hidden = seen("hidden.png", &["--label", "*=hide"]);
    assert_eq!(hidden, [0.0; 2]);
    let wrong = run(
        folder.path(),
        &["render", "scan", "-o", "a.png", "--labels", "half.nrrd", "--label", "liver=hide"],
    );
    assert_eq!(wrong.status.code(), Some(2), "{}", stderr(&wrong));
    assert!(stderr(&wrong).contains("there is no such label"), "{}", stderr(&wrong));
    let elsewhere = String::from_utf8_lossy(&fs::read(folder.path().join("half.nrrd")).unwrap()).into_owned();
    fs::write(folder.path().join("far.nrrd"), elsewhere.replace("(-15,-15,-15)", "(9985,-15,-15)")).unwrap();
    let far = run(folder.path(), &["render", "scan", "-o", "a.png", "--labels", "far.nrrd"]);
    assert!(stderr(&far).contains("far.nrrd: none of its labels lies in the scan"), "{}", stderr(&far));
    let missing = run(folder.path(), &["render", "scan", "-o", "a.png", "--labels", "no.nrrd"]);
    assert!(stderr(&missing).contains("no.nrrd") && !folder.path().join("a.png").exists());
}

/// What a render of a folder says of what it does.
fn said(folder: &Path, more: &[&str]) -> (Option<i32>, String) {
    let arguments = ["render", "-o", "a.png", "--samples", "1", "--size", "16x16"];
    let output = run(folder, &[&arguments[..], more].concat());
    (output.status.code(), stderr(&output))
}

#[test]
fn a_pet_is_seen_in_the_ct_of_its_place() {
    let folder = tempfile::tempdir().unwrap();
    for (kind, size, out) in [("torso", "40", "study/ct"), ("torso-pet", "32", "study/pet")] {
        let made = run(folder.path(), &["phantom", kind, "--size", size, "--out", out, "--quiet"]);
        assert_eq!(made.status.code(), Some(0), "{}", stderr(&made));
    }
    let fused = |more: &[&str]| {
        let (code, told) = said(folder.path(), more);
        assert_eq!(code, Some(0), "{more:?}: {told}");
        let is_told = told.contains("CT series 1 and PT series 2 of one place are shown at once");
        assert_eq!(is_told, told.contains("0 to") && told.contains("SUV"), "{told}");
        is_told
    };
    assert!(fused(&["study"]));
    assert!(fused(&["study", "--fusion", "on", "--preset", "ct-bone", "--preset", "pet-hot"]));
    // Who chose one, or a look for one, gets that.
    for one in [&["--fusion", "off"], &["--preset", "ct-bone"], &["--series", "1"]] {
        assert!(!fused(&[&["study"], &one[..]].concat()), "{one:?}");
    }
    // Named one after the other, in any order, and of places of their own.
    let (code, told) = said(folder.path(), &["study/pet", "study/ct"]);
    assert!(code == Some(0) && !told.contains("lie apart"), "{told}");
    let (code, told) = said(folder.path(), &["study/ct", "--fusion", "on"]);
    assert!(code == Some(3) && told.contains("there are no CT or MR and PET of one place"), "{told}");
    let (code, told) = said(folder.path(), &["study/ct", "study/pet", "--fusion", "on"]);
    assert!(code == Some(2) && told.contains("--fusion on is for one folder"), "{told}");
}

#[test]
fn misuse_of_labels_and_looks_is_told() {
    let folder = folder_with_scan();
    let nrrd = |kind: &str, voxels: &[u8]| {
        let mut file = format!(
            "NRRD0004\ntype: {kind}\ndimension: 3\nspace: left-posterior-superior\nsizes: 16 16 16\nspace directions: \
             (2,0,0) (0,2,0) (0,0,2)\nspace origin: (-15,-15,-15)\nendian: little\nencoding: raw\n\n"
        )
        .into_bytes();
        file.extend(voxels);
        file
    };
    // Numbered anew: 1024 becomes 1, and is still called so; so is the file, alone in a folder.
    fs::create_dir(folder.path().join("alone")).unwrap();
    let voxels: Vec<u8> = (0..16u32.pow(3)).flat_map(|i| [0, if i % 16 >= 8 { 4 } else { 3 }]).collect();
    fs::write(folder.path().join("alone/large.nrrd"), nrrd("uint16", &voxels)).unwrap();
    let (code, told) = said(folder.path(), &["scan", "--labels", "alone", "--label", "1024=hide"]);
    assert!(code == Some(0) && told.contains("alone: 2 labels"), "{told}");
    let (code, told) = said(folder.path(), &["scan", "--labels", "alone", "--label", "1=hide"]);
    assert!(code == Some(2) && told.contains("there is no such label"), "{told}");
    // Nothing is labelled: said once.
    fs::write(folder.path().join("empty.nrrd"), nrrd("uint8", &[0; 4096])).unwrap();
    let (code, told) = said(folder.path(), &["scan", "--labels", "empty.nrrd"]);
    assert!(code == Some(0) && told.contains("empty.nrrd: no labels"), "{told}");
    assert_eq!(told.matches("no voxel has a label").count(), 1, "{told}");
    // What is found is found in any letters, and names of none are refused in an MR, too.
    let (code, told) = said(folder.path(), &["scan", "--labels", "Found", "--label", "lnugs=hide"]);
    assert!(code == Some(2) && told.contains("there is no such label; there are body"), "{told}");
    let made = run(folder.path(), &["phantom", "mr-head", "--size", "24", "--out", "mr", "--quiet"]);
    assert_eq!(made.status.code(), Some(0));
    let (code, told) = said(folder.path(), &["mr", "--labels", "found", "--label", "lnugs=hide"]);
    assert!(code == Some(2) && told.contains("there is no such label"), "{told}");
    let (code, told) = said(folder.path(), &["mr", "--preset", "ct-bone"]);
    assert!(code == Some(0) && told.contains("ct-bone is a look of CT, placed here by"), "{told}");
    assert!(!said(folder.path(), &["scan", "--preset", "ct-bone"]).1.contains("is a look of CT"));
}
