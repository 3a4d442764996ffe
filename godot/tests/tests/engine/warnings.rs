//! What the editor's scene dock warns of at a volume's node, driven by `project/warnings/driver.gd`.

use std::fs;
use std::sync::OnceLock;

use lumivox_core::{CancelToken, Progress};
use lumivox_phantom::{SeriesDescription, cube, write_dicom_series};

use crate::engine::{Run, Start, engine, once};
use crate::shown::told;

/// The engine's own complaints, when it is told to quit and a look for changed files is cut off.
const EXCUSED: &[&str] =
    &["Scan thread aborted", "Can't use get_node() with absolute paths from outside the active scene tree"];

fn run() -> &'static Run {
    static RUN: OnceLock<Option<Run>> = OnceLock::new();
    once(&RUN, || {
        let engine = engine();
        let project = engine.copy_project("warnings");
        let settings = fs::read_to_string(project.join("project.godot")).unwrap();
        let settings =
            settings.replace("plugin.cfg\")", "plugin.cfg\", \"res://tests/warnings/plugin.cfg\")");
        // The editor would begin with the main scene, and grow its phantom.
        let lines = settings.lines().filter(|line| !line.starts_with("run/main_scene"));
        fs::write(project.join("project.godot"), lines.collect::<Vec<_>>().join("\n")).unwrap();
        let series = project.join("scans/ct");
        let description = SeriesDescription::default();
        write_dicom_series(&cube(12), &series, &description, Progress::SILENT, &CancelToken::new()).unwrap();
        let arguments = ["--path", project.to_str().unwrap(), "--editor", "--", "--cases", "none"];
        let start = Start { excused: EXCUSED, unseen: true, ..Start::default() };
        engine.run_as(&engine.godot, "warnings", &arguments, &start)
    })
}

#[test]
fn the_scene_dock_warns_of_what_shows_nothing_and_only_then() {
    for step in [
        "content",
        "density",
        "knots",
        "knots_added",
        "flat",
        "inverted",
        "clipped",
        "slice",
        "slice_only",
        "none",
        "whole",
        "embedded",
        "own_file",
    ] {
        assert_eq!(told(run(), step), true, "{step}");
    }
}

#[test]
fn a_slice_has_the_inspector_offer_the_whole_scan_at_once() {
    assert_eq!(told(run(), "offered"), true);
    assert_eq!(told(run(), "taken_back"), true);
}

#[test]
fn the_gizmo_shows_the_same_clip_box_whichever_corner_is_larger() {
    assert_eq!(told(run(), "gizmo"), true);
}
