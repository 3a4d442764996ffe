//! The bench of moving pictures runs, at a size at which it takes seconds: what it measures is measured elsewhere, and no time is
//! asserted.

#[path = "../../benches/motion/bench/mod.rs"]
mod bench;

use std::path::Path;

/// What it says, and what went wrong.
fn run(out: &Path, words: &str) -> (String, Result<(), String>) {
    let mut log = vec![];
    let words = std::iter::once(out.to_str().unwrap()).chain(words.split_whitespace());
    let result = bench::run(words.map(str::to_owned), &mut log);
    (String::from_utf8(log).unwrap(), result)
}

#[test]
fn the_motion_bench_runs() {
    // Others wait for the device meanwhile.
    let _gpu = super::gpu();
    let folder = tempfile::tempdir().unwrap();
    let (log, result) = run(
        folder.path(),
        "scene=head look=ct-skin spend=.5 size=96x54 voxels=48 length=2 frames=0,1 rest=1 after=1 samples=8 strip=32",
    );
    result.unwrap();
    let csv = std::fs::read_to_string(folder.path().join("runs.csv")).unwrap();
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    // Six films, raw, denoised and with kept light.
    assert_eq!(rows.len(), 1 + 6 * 3, "{log}");
    let column = |name: &str| rows[0].iter().position(|column| *column == name).unwrap();
    for row in &rows[1..] {
        assert_eq!(row.len(), rows[0].len());
        for name in ["flip", "light", "first", "cut", "rest1", "floor", "ms", "flicker32"] {
            let value: f64 = row[column(name)].parse().unwrap();
            assert!(value.is_finite() && value >= 0.0, "{name} of {row:?}");
        }
        let light: f64 = row[column("light")].parse().unwrap();
        assert!((0.7..1.4).contains(&light), "{row:?}");
        let name = format!("{}-{}-{}-{}-{}", row[0], row[1], row[2], row[3], row[4]);
        assert!(folder.path().join(format!("strips/{name}.png")).exists(), "{name}");
    }
    let json = std::fs::read_to_string(folder.path().join("motion.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["runs"].as_array().unwrap().len(), 18);
    assert_eq!(json["runs"][0]["frames_ms"].as_array().unwrap().len(), 2);
    // Two frames in motion, one at rest, two after the cut.
    let pictures = std::fs::read_to_string(folder.path().join("pictures.csv")).unwrap();
    assert_eq!(pictures.lines().count(), 1 + 18 * 5);
    for film in ["orbit", "function", "light", "mesh", "plane", "turn"] {
        let svg =
            std::fs::read_to_string(folder.path().join(format!("plots/head-ct-skin-{film}.svg"))).unwrap();
        assert!(svg.ends_with("</svg>\n"));
    }
}

#[test]
fn the_motion_bench_finds_what_a_frame_affords() {
    let _gpu = super::gpu();
    let folder = tempfile::tempdir().unwrap();
    let (log, result) = run(
        folder.path(),
        "scene=torso look=ct-bone film=orbit variant=raw budget=8 size=32x18 voxels=32 length=2 frames=0,1 rest=1 \
         after=1 samples=2 strip=0",
    );
    result.unwrap();
    let json = std::fs::read_to_string(folder.path().join("motion.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["runs"].as_array().unwrap().len(), 1, "{log}");
    assert!(json["runs"][0]["spp"].as_f64().unwrap() > 0.0, "{log}");
    assert!(!folder.path().join("strips").exists());
}

#[test]
fn the_motion_bench_says_what_is_wrong_with_its_words() {
    let folder = tempfile::tempdir().unwrap();
    for (words, wanted) in [
        ("film=orbitt", "there is no 'orbitt', but orbit, function, light, mesh, plane, turn"),
        ("budget=0", "'0' is no number between"),
        ("size=1920", "give it as 1920x1080"),
        ("length=10 frames=0,10", "the film ends with frame 9"),
        ("tone=plain,agx", "name one"),
        ("fast", "'fast' is no option"),
        ("speed=8", "'speed=8' is no option"),
    ] {
        let (_, result) = run(folder.path(), words);
        let why = result.expect_err(words);
        assert!(why.contains(wanted), "{words}: {why}");
    }
    let nowhere = bench::run(["--quick".to_owned()], &mut vec![]).expect_err("no folder");
    assert!(nowhere.contains("name a folder"), "{nowhere}");
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let (_, result) = run(&file, "size=16x16");
    assert!(result.unwrap_err().contains("file"), "it names what is in the way");
    let (help, result) = run(folder.path(), "--help");
    assert!(result.is_ok() && help.contains("film=orbit,function,light,mesh,plane"));
}
