//! Scenes as files: what the command saves renders to the same pixels, and what is wrong with one is told by its line.

use lumivox_testing::hosts;
use std::{
    fs::{self, File},
    io::BufReader,
    path::Path,
    process::{Command, Output, Stdio},
};

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lumivox"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null()).output().expect("the command runs")
}

#[track_caller]
fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}\n{said}");
    said
}

fn pixels(path: &Path) -> Vec<u8> {
    let decoder = png::Decoder::new(BufReader::new(File::open(path).expect("the picture is there")));
    let mut reader = decoder.read_info().expect("it is a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut pixels).expect("it is whole");
    pixels
}

/// A folder with a small head as a CT in `scan`.
fn folder_with_head() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    done(folder.path(), &["phantom", "head", "--size", "48", "--out", "scan", "--quiet"]);
    folder
}

/// Saves and renders in two ways, of the options and of the scene; the scene's text.
#[track_caller]
fn same(folder: &Path, options: &[&str]) -> String {
    let small = ["--size", "32x24", "--samples", "3", "--quiet"];
    done(folder, &[&["render", "scan", "-o", "direct.png"], &small[..], options].concat());
    fs::create_dir_all(folder.join("scenes")).unwrap();
    done(folder, &[&["scene", "save", "scenes/a.lumivox", "scan"], &small[..], options].concat());
    done(folder, &["render", "scenes/a.lumivox", "-o", "again.png", "--quiet"]);
    assert!(pixels(&folder.join("direct.png")) == pixels(&folder.join("again.png")), "{options:?}");
    fs::read_to_string(folder.join("scenes/a.lumivox")).unwrap()
}

#[test]
fn a_saved_scene_is_the_same_picture() {
    let folder = folder_with_head();
    let text = same(folder.path(), &[]);
    assert!(text.contains("\"../scan\"") && text.contains("\"content\": \"sha256:"), "{text}");
    assert!(text.contains("\"preset\": \"ct-"), "the preset that suits is named: {text}");
    // What was taken off for a look is said by the millimetre, and a look for an organ leaves that alone.
    let text = same(folder.path(), &["--preset", "ct-bone", "--peel", "9", "--background", "transparent"]);
    assert!(text.contains("\"depth\": 9"), "{text}");
    let parts =
        ["--labels", "found", "--label", "*=opacity:0.5", "--label", "body=color:#ff2010,preset:ct-bone"];
    let light = ["--environment", "gradient", "--environment-rotation", "40", "--light", "sun:40,30,2"];
    let view =
        ["--azimuth", "35", "--elevation", "20", "--zoom", "1.3", "--tone", "aces", "--exposure", "0.5"];
    let cuts = ["--clip-shape", "!sphere:0,40,60,30", "--clip", "0,0,0,1,1,0.9", "--window", "200,900"];
    same(folder.path(), &[&parts[..], &light, &view, &cuts].concat());
    same(folder.path(), &["--eye", "300,100,400", "--fov", "50", "--keep", "everything", "--density", "0.5"]);
}

/// A scene of every host's, and what the command saves of it: one picture.
#[test]
fn what_every_host_saved_is_the_same_picture_once_more_saved() {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let at = folder.path();
    let size = hosts::SCAN_SIZE.to_string();
    done(at, &["phantom", "head", "--size", &size, "--out", hosts::SCAN, "--quiet"]);
    hosts::copy_scenes(at);
    let film = ["--size", "40x32", "--samples", "4", "--seed", "7", "--background", "#203040"];
    let look = ["--preset", "ct-muscle", "--density", "0.9", "--bounces", "12"];
    let parts = ["--labels", "found", "--label", "body=opacity:0.8", "--label", "air outside=hide"];
    let cuts = ["--clip-shape", "!sphere:20,-40,60,40", "--clip", "0,0,0,1,1,0.9"];
    let light = ["--light", "sun:40,30,2", "--environment", "gradient", "--environment-rotation", "20"];
    let view = ["--azimuth", "35", "--elevation", "10", "--tone", "aces", "--exposure", "-0.5"];
    let options = [&film[..], &look, &parts, &cuts, &light, &view].concat();
    done(at, &[&["scene", "save", "own.lumivox", hosts::SCAN, "--quiet"], &options[..]].concat());
    // A lasso is drawn by hand: from 300 mm before the face, around the brow and the skull above it.
    let whole = fs::read_to_string(at.join("own.lumivox")).unwrap();
    let mut drawn: serde_json::Value = serde_json::from_str(&whole).unwrap();
    drawn["volumes"][0]["lassos"] = serde_json::json!([{
        "from_picture": [[1, 0, 0, 0], [0, 0, -1, -300], [0, 1, 0, 40]],
        "points": [[-0.25, 0.05], [-0.02, 0.0625], [0.1, 1.0 / 3.0], [-0.25, 0.3]],
    }]);
    fs::write(at.join("drawn.lumivox"), drawn.to_string()).unwrap();
    done(at, &["scene", "save", "own.lumivox", "drawn.lumivox", "--quiet"]);
    hosts::assert_written("command", &at.join("own.lumivox"));
    for host in hosts::HOSTS {
        let (scene, again) = (format!("{host}.lumivox"), format!("of-{host}.lumivox"));
        let said = done(at, &["scene", "check", &scene]);
        assert!(!said.contains("not the scan"), "{host}: {said}");
        done(at, &["scene", "save", &again, &scene, "--quiet"]);
        for (scene, picture) in [(&scene, "one.png"), (&again, "other.png")] {
            done(at, &["render", scene, "-o", picture, "--quiet"]);
        }
        let [one, other] = ["one.png", "other.png"].map(|picture| pixels(&at.join(picture)));
        assert!(one == other, "{host}");
    }
}

/// The page says what the suites of all hosts hold: of each one's scene, as each one saves it, no pixel is another.
#[test]
fn the_table_of_hosts_has_them_all() {
    let page =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scenes.md")).unwrap();
    let mut rows: Vec<Vec<&str>> = page
        .lines()
        .skip_while(|line| *line != "## From host to host")
        .filter_map(|line| line.strip_prefix("| ")?.strip_suffix(" |"))
        .map(|line| line.split(" | ").map(str::trim).collect())
        .collect();
    assert!(rows.len() > 2 && rows.remove(1)[0].starts_with("---"), "{rows:?}");
    let names: Vec<String> = hosts::HOSTS.map(|host| host[..1].to_uppercase() + &host[1..]).to_vec();
    assert_eq!(rows[0][1..], names, "those that open it");
    for (row, name) in rows[1..].iter().zip(&names) {
        assert!(row[0] == name && row[1..].iter().all(|cell| *cell == "0"), "{name}: {row:?}");
    }
    assert_eq!(rows.len(), 1 + names.len(), "a heading, and the hosts");
}

/// A CT and the PET of its place, out of one folder: the scene names both.
#[test]
fn a_fusion_is_saved_as_both_of_its_scans() {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let at = folder.path();
    done(at, &["phantom", "torso", "--size", "48", "--out", "scan/ct", "--quiet"]);
    done(at, &["phantom", "torso-pet", "--size", "24", "--out", "scan/pet", "--quiet"]);
    let text = same(at, &["--density", "0.7"]);
    for preset in ["\"preset\": \"fusion\"", "\"preset\": \"pet-hot\""] {
        assert_eq!(text.matches(preset).count(), 1, "{text}");
    }
    assert_eq!(text.matches("\"series\": \"").count(), 2, "{text}");
}

/// What a file is called is nobody's business until it is written down.
#[cfg(unix)]
#[test]
fn names_that_are_no_unicode_are_rendered_and_not_saved() {
    use std::os::unix::ffi::OsStrExt;
    let folder = folder_with_head();
    let at = folder.path();
    let name = std::ffi::OsStr::from_bytes(b"M\xfcller [1,2]");
    fs::rename(at.join("scan"), at.join(name)).unwrap();
    let render = |first: &[&str], last: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lumivox"));
        command.current_dir(at).args(first).arg(name).args(last).stdin(Stdio::null()).output().unwrap()
    };
    let small = ["--size", "8x8", "--samples", "1", "--quiet", "-o", "a.png"];
    assert_eq!(render(&["render"], &small).status.code(), Some(0));
    let output = render(&["scene", "save", "a.json"], &["--quiet"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(1) && said.contains("no Unicode"), "{said}");
    assert_eq!(fs::read_dir(at).unwrap().count(), 2, "the scan and the picture");
}

#[test]
fn options_win_over_what_the_scene_says() {
    let folder = folder_with_head();
    let small = ["--size", "32x24", "--samples", "3", "--quiet"];
    let skin =
        [&["scene", "save", "a.json", "scan", "--preset", "ct-skin", "--azimuth", "20"], &small[..]].concat();
    done(folder.path(), &skin);
    done(
        folder.path(),
        &["render", "a.json", "-o", "a.png", "--preset", "ct-bone", "--azimuth", "90", "--quiet"],
    );
    let direct =
        [&["render", "scan", "-o", "b.png", "--preset", "ct-bone", "--azimuth", "90"], &small[..]].concat();
    done(folder.path(), &direct);
    assert!(pixels(&folder.path().join("a.png")) == pixels(&folder.path().join("b.png")));
    // A scene may be saved over itself.
    done(
        folder.path(),
        &["scene", "save", "a.json", "a.json", "--preset", "ct-bone", "--azimuth", "90", "--quiet"],
    );
    done(folder.path(), &["render", "a.json", "-o", "c.png", "--quiet"]);
    assert!(pixels(&folder.path().join("c.png")) == pixels(&folder.path().join("b.png")));
}

/// Which samples are looked at depends on nothing but the image.
#[test]
fn a_scene_may_end_by_its_noise() {
    let folder = folder_with_head();
    let at = folder.path();
    done(at, &["scene", "save", "a.json", "scan", "--size", "32x24", "--noise", "0.2", "--quiet"]);
    let said = done(at, &["render", "a.json", "-o", "a.png"]);
    // The last: a slow machine tells how far it is before.
    let noise = said.rsplit(", noise ").next().and_then(|rest| rest.split('%').next()).expect("it is said");
    assert!(noise.parse::<f64>().unwrap() <= 20.0, "{said}");
    done(at, &["render", "scan", "-o", "b.png", "--size", "32x24", "--noise", "0.2", "--quiet"]);
    assert!(pixels(&at.join("a.png")) == pixels(&at.join("b.png")));
    let cluster = ["render", "a.json", "-o", "c.png", "--cluster", "tcp://nowhere:1"];
    assert_eq!(run(at, &cluster).status.code(), Some(2));
}

#[test]
fn what_is_wrong_with_a_scene_is_told_by_its_line() {
    let folder = folder_with_head();
    let at = folder.path();
    done(at, &["scene", "save", "a.json", "scan", "--labels", "found", "--label", "lungs=hide", "--quiet"]);
    done(at, &["scene", "check", "a.json"]);
    let text = fs::read_to_string(at.join("a.json")).unwrap();
    let refused = |text: &str, arguments: &[&str]| {
        fs::write(at.join("b.json"), text).unwrap();
        let output = run(at, arguments);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), said.lines().last().unwrap_or_default().to_owned())
    };
    let line = |word: &str| text.lines().position(|line| line.contains(word)).unwrap() + 1;
    let check = ["scene", "check", "b.json"];
    for (old, new, line, word) in [
        ("\"scan\"\n", "\"scam\"\n", line("\"files\""), "scam"),
        (
            "\"label\": \"lungs\"",
            "\"label\": \"lumgs\"",
            line("\"label\""),
            "there is no such label; there are",
        ),
        ("\"seed\": 0", "\"sead\": 0", line("\"seed\""), "there is no key 'sead' here, did you mean 'seed'?"),
        ("\"lumivox_scene\": 1", "\"lumivox_scene\": 7", 2, "a newer Lumivox opens it"),
    ] {
        assert!(text.contains(old), "{old} in {text}");
        let (exit, said) = refused(&text.replacen(old, new, 1), &check);
        let place = format!("error: b.json, line {line}, column ");
        assert!(
            exit == Some(3) && said.starts_with(&place) && said.contains(word),
            "{exit:?} {said}, not {place}"
        );
    }
    let render = ["render", "b.json", "-o", "b.png", "--samples", "1", "--size", "8x8"];
    let (exit, said) = refused("{\"lumivox_scene\": 1, \"film\": {\"size\": [0, 1]}}", &render);
    assert!(exit == Some(3) && said.contains("line 1, column 39: 0 x 1 is no image"), "{said}");

    // Another scan in its place is told, and shown.
    fs::remove_dir_all(at.join("scan")).unwrap();
    done(at, &["phantom", "head", "--size", "40", "--out", "scan", "--quiet"]);
    let check = run(at, &["scene", "check", "a.json"]);
    let said = String::from_utf8_lossy(&check.stderr).into_owned();
    assert!(
        check.status.code() == Some(3)
            && said.contains("error: a.json, line 6, column ")
            && said.contains("this is not the scan that the scene was saved with"),
        "{said}"
    );
    assert_eq!(said.matches("this is not the scan").count(), 1, "{said}");
    // In the scan's own folder, too.
    done(at, &["scene", "save", "scan/own.json", "scan", "--quiet"]);
    done(at, &["scene", "check", "scan/own.json"]);
    let both = run(at, &["render", "a.json", "scan", "-o", "c.png"]);
    let said = String::from_utf8_lossy(&both.stderr).into_owned();
    assert!(
        both.status.code() == Some(2) && said.contains("a.json is a scene, which has its own scans"),
        "{said}"
    );
    // A folder stands for whatever else is no file.
    let folder = run(at, &["scene", "check", "scan"]);
    let said = String::from_utf8_lossy(&folder.stderr).into_owned();
    assert!(folder.status.code() == Some(3) && said.contains("scan: it is not a plain file"), "{said}");
    let own = run(at, &["scene", "save", "scan/a.txt", "scan"]);
    assert_eq!(own.status.code(), Some(2));
}

/// A scene is no scan: what it is, and which commands take it.
#[test]
fn what_takes_scans_says_what_a_scene_is() {
    let folder = folder_with_head();
    let at = folder.path();
    done(at, &["scene", "save", "a.lumivox", "scan", "-q"]);
    assert_eq!(done(at, &["scene", "check", "a.lumivox", "-q"]), "");
    for command in ["info", "import"] {
        let output = run(at, &[command, "a.lumivox"]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            output.status.code() == Some(3)
                && said.contains("a.lumivox is a scene of Lumivox's, and no scan")
                && said.contains("'lumivox render a.lumivox -o PICTURE.png'"),
            "{command}: {said}"
        );
    }
    // And what is no scene where one is wanted.
    let scan = fs::read_dir(at.join("scan")).unwrap().next().unwrap().unwrap().path();
    let output = run(at, &["scene", "check", &scan.to_string_lossy()]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(3) && said.contains("is no scene of Lumivox's"), "{said}");
}

/// What a machine may have no room or time for is no fault of the scene, and is said.
#[test]
fn a_check_says_what_is_hard_to_render() {
    let folder = folder_with_head();
    let at = folder.path();
    let shape =
        r#"{"kind": "sphere", "inverted": true, "from_shape": [[9, 0, 0, 500], [0, 9, 0, 0], [0, 0, 9, 0]]}"#;
    let write = |shapes: usize, size: u32, density: &str| {
        let shapes = vec![shape; shapes].join(", ");
        let text = format!(
            r#"{{"lumivox_scene": 1, "film": {{"size": [{size}, {size}]}}, "volumes": [{{"scan": {{"files": ["scan"]}},
            "look": {{"density": {density}}}, "clip_shapes": [{shapes}]}}]}}"#
        );
        fs::write(at.join("a.json"), text).unwrap();
        let output = run(at, &["scene", "check", "a.json"]);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (exit, said) = write(1, 1024, "0.5");
    assert!(exit == Some(0) && !said.contains("GB of memory") && !said.contains("shapes cut"), "{said}");
    let (exit, said) = write(1000, 16_384, "1e9");
    assert_eq!(exit, Some(0), "{said}");
    for words in [
        "16384 x 16384 pixels takes 27 GB of memory",
        "1000 shapes cut scan 1",
        "a density of 1.000e9 is more than",
    ] {
        assert_eq!(said.matches(words).count(), 1, "{words}: {said}");
    }
    let entry = r#"{"scan": {"files": ["scan"]}}"#;
    let camera = r#""camera": {"world_from_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 900]]}"#;
    let text = format!(r#"{{"lumivox_scene": 1, {camera}, "volumes": [{}]}}"#, vec![entry; 1001].join(", "));
    fs::write(at.join("many.json"), text).unwrap();
    let said = done(at, &["scene", "check", "many.json"]);
    assert!(said.contains("1001 scans, each with a look of its own"), "{said}");
    // What no renderer takes is refused.
    for (shapes, size, density, words) in [
        (1025, 1024, "1", "there are 1025 shapes, of which 1024 are possible"),
        (1, 16_385, "1", "16385 x 16385 is no image"),
        (1, 1024, "1.1e9", "density is 1100000000, and must be 0 to 1000000000"),
    ] {
        let (exit, said) = write(shapes, size, density);
        assert!(exit == Some(3) && said.contains(words), "{words}: {said}");
    }
}

/// Paths of a scene are seen from where it stands, and not from a link to it.
#[cfg(unix)]
#[test]
fn a_link_to_a_scene_is_the_scene() {
    let folder = folder_with_head();
    let at = folder.path();
    fs::create_dir_all(at.join("links/deeper")).unwrap();
    done(at, &["scene", "save", "a.lumivox", "scan", "--size", "16x12", "--samples", "1", "--quiet"]);
    std::os::unix::fs::symlink("../../a.lumivox", at.join("links/deeper/b.lumivox")).unwrap();
    done(at, &["scene", "check", "links/deeper/b.lumivox"]);
    done(at, &["render", "links/deeper/b.lumivox", "-o", "b.png", "--quiet"]);
    // Saved through the link it is the same file again.
    let again =
        ["scene", "save", "links/deeper/b.lumivox", "links/deeper/b.lumivox", "--azimuth", "20", "--quiet"];
    done(at, &again);
    assert!(at.join("links/deeper/b.lumivox").is_symlink());
    assert!(fs::read_to_string(at.join("a.lumivox")).unwrap().contains("\"azimuth\": 20"));
    done(at, &["scene", "check", "a.lumivox"]);
}

/// Colours as screens show them, and the numbers that they are.
#[test]
fn colours_may_be_those_of_screens() {
    let folder = folder_with_head();
    let at = folder.path();
    let scene = |color: &str| {
        format!(
            r#"{{"lumivox_scene": 1, "film": {{"size": [16, 12], "samples": 2}},
            "environment": {{"source": "uniform", "color": {color}}},
            "volumes": [{{"scan": {{"files": ["scan"]}},
            "look": {{"transfer_function": {{"opacity": [[0, 0], [100, 1]], "color": [[0, {color}]]}}}},
            "labels": {{"styles": [{{"label": "lungs", "color": {color}}}]}}}}]}}"#
        )
    };
    let linear = [0xc0, 0x50, 0x3c].map(|code| {
        let code = f64::from(code) / 255.0;
        ((code + 0.055) / 1.055).powf(2.4)
    });
    fs::write(at.join("a.json"), scene("\"#c0503c\"")).unwrap();
    fs::write(at.join("b.json"), scene(&format!("{linear:?}"))).unwrap();
    for name in ["a", "b"] {
        done(at, &["render", &format!("{name}.json"), "-o", &format!("{name}.png"), "--quiet"]);
        done(at, &["scene", "save", &format!("{name}2.json"), &format!("{name}.json"), "--quiet"]);
    }
    assert!(pixels(&at.join("a.png")) == pixels(&at.join("b.png")));
    let saved = ["a2.json", "b2.json"].map(|name| fs::read_to_string(at.join(name)).unwrap());
    assert!(saved[0] == saved[1] && !saved[0].contains("#c0503c"), "{}", saved[0]);
}
