//! Cases as the engine shows them, each compared with what the renderer makes of it.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use lumivox_testing::png_io::SrgbImage;
use serde::Serialize;
use serde_json::Value;

use crate::case::Case;
use crate::engine::{Run, engine};
use crate::expected;

/// Cases that are shown in one run of the engine, when the first of them is asked for.
pub struct Shown {
    name: &'static str,
    cases: fn() -> Vec<Case>,
    folder: OnceLock<PathBuf>,
}

impl Shown {
    pub const fn new(name: &'static str, cases: fn() -> Vec<Case>) -> Self {
        Self { name, cases, folder: OnceLock::new() }
    }

    pub fn case(&self, name: &str) -> Case {
        (self.cases)().into_iter().find(|c| c.name == name).unwrap()
    }

    /// The folder of screenshots, `NAME.png` each.
    pub fn folder(&self) -> &Path {
        self.folder.get_or_init(|| run_scene(self.name, "show_cases", &(self.cases)()).0)
    }

    /// What was shown of a case; `part` is empty or `_alpha`.
    pub fn screenshot(&self, name: &str, part: &str) -> SrgbImage {
        SrgbImage::read(&self.folder().join(format!("{name}{part}.png"))).unwrap()
    }

    pub fn assert_as_expected(&self, name: &str) {
        let wanted = expected::picture(&self.case(name));
        assert_same(self.folder(), name, &wanted, |_| true);
    }
}

/// Runs a scene of `project/` in the engine with what it is to do. Returns the folder of what it writes, and its log. The window is
/// small: what tests look at is in viewports of its own.
pub fn run_scene(name: &str, scene: &str, what: &impl Serialize) -> (PathBuf, Run) {
    run_scene_with(&["--resolution", "160x90"], name, scene, what)
}

/// The same in a window of the usual size, which is used.
pub fn run_scene_in_window(name: &str, scene: &str, what: &impl Serialize) -> (PathBuf, Run) {
    run_scene_with(&[], name, scene, what)
}

/// The same with options of the engine.
pub fn run_scene_with(options: &[&str], name: &str, scene: &str, what: &impl Serialize) -> (PathBuf, Run) {
    let engine = engine();
    let (folder, file) = engine.write_cases(name, what);
    let scene = format!("res://tests/{scene}.tscn");
    let [cases, out] = [&file, &folder].map(|path| path.to_str().unwrap());
    let arguments = [options, &[&scene, "--", "--cases", cases, "--out", out]].concat();
    let run = engine.run(name, &arguments);
    (folder, run)
}

/// What a script told of `name`, in lines `TELL NAME JSON`.
pub fn told(run: &Run, name: &str) -> Value {
    let begin = format!("TELL {name} ");
    let line = run.log.lines().find_map(|line| line.strip_prefix(&begin));
    let line = line.unwrap_or_else(|| panic!("the script says nothing of {name}; it ended early"));
    serde_json::from_str(line).unwrap_or_else(|e| panic!("{name}: {e} in {line}"))
}

/// Compares the screenshot of `name` with a picture, where `counts` says so of the pixel.
///
/// The same random numbers make the same paths; now and then rounding sends one elsewhere, and the edge of a mesh falls
/// on another pixel.
pub fn assert_same(folder: &Path, name: &str, wanted: &SrgbImage, counts: impl Fn(usize) -> bool) {
    let (mean, far) = difference(folder, name, wanted, counts);
    assert!(mean < 0.5 && far < 0.01, "{name}: differs by {mean} of 255, in {far} of all pixels");
}

/// The mean difference in steps of 255, and the share of pixels that differ by more than 2.
pub fn difference(
    folder: &Path,
    name: &str,
    wanted: &SrgbImage,
    counts: impl Fn(usize) -> bool,
) -> (f64, f64) {
    let shown = SrgbImage::read(&folder.join(format!("{name}.png"))).unwrap();
    let _ = wanted.write(&folder.join(format!("{name}_wanted.png")));
    assert_eq!((shown.width, shown.height), (wanted.width, wanted.height), "{name}");
    assert!(is_a_picture(wanted), "{name} shows nothing");
    let (mean, far, counted) = distance(&shown, wanted, counts);
    println!(
        "{name}: differs by {mean:.3} of 255 on average, by more than 2 in {:.2}% of {counted} pixels",
        far * 100.0
    );
    (mean, far)
}

/// The same of two pictures, and the number of pixels that counted.
pub fn distance(shown: &SrgbImage, wanted: &SrgbImage, counts: impl Fn(usize) -> bool) -> (f64, f64, usize) {
    let (mut sum, mut far, mut counted) = (0.0, 0, 0);
    for (i, (a, b)) in shown.pixels.iter().zip(&wanted.pixels).enumerate() {
        if counts(i) {
            let difference = (0..3).map(|i| a[i].abs_diff(b[i])).max().unwrap();
            sum += f64::from(difference);
            far += usize::from(difference > 2);
            counted += 1;
        }
    }
    assert!(counted > wanted.pixels.len() / 50, "there is next to nothing to compare");
    (sum / counted as f64, far as f64 / counted as f64, counted)
}

fn is_a_picture(image: &SrgbImage) -> bool {
    let distinct: std::collections::HashSet<_> = image.pixels.iter().collect();
    distinct.len() > (image.pixels.len() / 40).min(150)
}
