//! JPEG-LS, which is decoded by a program beside the extension: it is, and its crash costs a slice, not the engine.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde_json::{Value, json};

use crate::engine::{BIN, CODECS, Engine, Run, Start, engine, once};
use crate::shown::told;

#[allow(dead_code, reason = "the import crate's tests write much more")]
#[path = "../../../../crates/lumivox-import/tests/common/writer.rs"]
mod writer;

use writer::{BITS_ALLOCATED, BITS_STORED, HIGH_BIT, IMAGE_POSITION_PATIENT, PIXEL_DATA, Syntax, image};

/// What the slices of the series hold.
pub const VALUES: [u8; 5] = [10, 20, 30, 40, 50];

/// Writes a series of slices in JPEG-LS, each of one value.
pub fn write_jpeg_ls(folder: &Path) {
    fs::create_dir_all(folder).unwrap();
    for (k, value) in VALUES.into_iter().enumerate() {
        let info = charls::FrameInfo { width: 4, height: 3, bits_per_sample: 8, component_count: 1 };
        let mut stream = charls::CharLS::default().encode(info, 0, &[value; 12]).expect("CharLS encodes");
        stream.resize(stream.len().next_multiple_of(2), 0);
        let mut slice = image("MR", 4, 3, vec![])
            .short(BITS_ALLOCATED, 8)
            .short(BITS_STORED, 8)
            .short(HIGH_BIT, 7)
            .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, 2.0 * k as f64]);
        slice.set(PIXEL_DATA, "OB", writer::Value::Fragments(vec![stream]));
        slice.write(&folder.join(format!("{k}.dcm")), Syntax::JpegLs);
    }
}

/// Puts a program in the place of `program` that leaves a mark before it becomes that.
pub fn mark(program: &Path) {
    fs::rename(program, program.with_extension("real")).unwrap();
    fs::copy(env!("CARGO_BIN_EXE_tests-marked-codecs"), program).unwrap();
}

/// How often the marked program was started for frames.
pub fn marks(program: &Path) -> usize {
    fs::read(program.with_extension("marks")).map_or(0, |marks| marks.len())
}

/// A run of the engine that imports the series, and the program beside its extension.
struct Imported {
    run: Run,
    program: PathBuf,
}

/// Imports the series in a project of its own, whose program is as `prepare` leaves it.
fn import(engine: &Engine, name: &str, prepare: impl FnOnce(&Path)) -> Imported {
    let project = engine.copy_project(name);
    let scan = engine.out.join(name).join("scan");
    write_jpeg_ls(&scan);
    let (_, cases) = engine.write_cases(name, &json!({ "path": scan }));
    let program = project.join(BIN).join(CODECS);
    prepare(&program);
    let [path, cases] = [&project, &cases].map(|path| path.to_str().unwrap());
    let arguments = ["--headless", "--path", path, "res://tests/codecs.tscn", "--", "--cases", cases];
    let run = engine.run_as(&engine.godot, name, &arguments, &Start::default());
    Imported { run, program }
}

fn marked() -> &'static Imported {
    static MARKED: OnceLock<Option<Imported>> = OnceLock::new();
    once(&MARKED, || import(&engine(), "codecs", mark))
}

/// The histogram of the values that were written, and of 0.
fn counts(told: &Value) -> Vec<u64> {
    let bins = told["histogram"].as_array().unwrap_or_else(|| panic!("nothing was imported: {told}"));
    bins.iter().map(|bin| bin.as_f64().unwrap() as u64).collect()
}

#[test]
fn frames_are_decoded_by_the_program_beside_the_extension() {
    let Imported { run, program } = marked();
    let told = told(run, "imported");
    assert_eq!(counts(&told), [0, 12, 12, 12, 12, 12], "{told}");
    assert!(marks(program) > 0, "{} was not started for a frame", program.display());
}

#[test]
fn a_decoder_that_crashes_costs_its_slice_and_not_the_engine() {
    let Imported { run, program } = import(&engine(), "codecs_crash", |program| {
        mark(program);
        fs::write(program.with_extension("crash"), "").unwrap();
    });
    let told = told(&run, "imported");
    assert!(!program.with_extension("crash").exists(), "nothing crashed");
    // Any of the slices, whichever was decoded first; it has the lowest value of the others.
    let counts = counts(&told);
    assert_eq!(counts.iter().filter(|&&count| count >= 12).count(), 4, "{told}");
    assert_eq!(counts.iter().sum::<u64>(), 60, "{told}");
    let skipped = told["report"]["skipped"].as_array().unwrap();
    assert_eq!(skipped.len(), 1, "{told}");
    assert!(skipped[0]["reason"].as_str().unwrap().contains("crashed its decoder"), "{told}");
}

#[test]
fn without_a_program_that_runs_frames_are_decoded_in_the_engine() {
    // None, and one that cannot be executed, as if it were for another system.
    type Prepare = fn(&Path);
    let programs: [(&str, Prepare); 2] = [
        ("codecs_none", |program| fs::remove_file(program).unwrap()),
        ("codecs_other", |program| fs::write(program, "no program").unwrap()),
    ];
    for (name, prepare) in programs {
        let told = told(&import(&engine(), name, prepare).run, "imported");
        assert_eq!(counts(&told), [0, 12, 12, 12, 12, 12], "{name}: {told}");
    }
}
