//! Every DICOM file of the shared scans, read within 1 GiB of address space and ten seconds, as another reader reads it.
//! The reading is done by a child process, whose limit it is.

mod common;

use std::{
    collections::HashMap,
    io::{BufRead, BufReader},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::Instant,
};

/// The list of files for the child.
const LIST: &str = "LUMIVOX_TEST_LIST";
const LIMIT: u64 = 1 << 30;
const MOST_SECONDS: f64 = 10.0;

/// The child: reads each file of a list, and says what it found. Does nothing in an ordinary run.
#[test]
fn child() {
    let Some(list) = std::env::var_os(LIST) else { return };
    #[cfg(unix)]
    {
        let limit = libc::rlimit { rlim_cur: LIMIT, rlim_max: LIMIT };
        // SAFETY: the struct is valid for the call.
        assert_eq!(unsafe { libc::setrlimit(libc::RLIMIT_AS, &limit) }, 0);
    }
    for path in std::fs::read_to_string(list).unwrap().lines() {
        println!("\nBEGIN\t{path}");
        let start = Instant::now();
        let result = common::load(Path::new(path));
        let seconds = start.elapsed().as_secs_f64();
        match result {
            Ok(imported) => {
                let volume = imported.volume;
                let depth = volume.dims()[2];
                let sum: f64 = (0..depth).map(|z| common::slice_sum(&volume, z).0).sum();
                let [low, high] = volume.value_range();
                let series = &imported.report.series;
                let phases: usize = series.iter().map(|series| series.phases).sum();
                println!("\nOK\t{path}\t{seconds}\t{depth}\t{phases}\t{sum}\t{low}\t{high}");
            }
            Err(error) => println!("\nERROR\t{path}\t{seconds}\t{error}"),
        }
    }
}

/// What became of a file.
#[derive(Debug)]
enum Outcome {
    Read { slices: usize, phases: usize, sum: f64, range: [f64; 2] },
    Refused(String),
    Died,
}

/// Reads `files` in child processes: a new one after each that dies.
fn outcomes(files: &[PathBuf]) -> HashMap<PathBuf, (f64, Outcome)> {
    let mut outcomes = HashMap::new();
    let list = tempfile::NamedTempFile::new().unwrap();
    let mut rest = files;
    while !rest.is_empty() {
        let text: Vec<String> = rest.iter().map(|path| path.display().to_string()).collect();
        std::fs::write(list.path(), text.join("\n")).unwrap();
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "child", "--nocapture", "--test-threads=1"])
            .env(LIST, list.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut current = None;
        for line in BufReader::new(child.stdout.take().unwrap()).lines() {
            let line = line.unwrap();
            let fields: Vec<&str> = line.split('\t').collect();
            let number = |k: usize| fields[k].parse::<f64>().unwrap();
            match fields[0] {
                "BEGIN" => current = Some(PathBuf::from(fields[1])),
                "OK" => {
                    let range = [number(6), number(7)];
                    let read = Outcome::Read {
                        slices: number(3) as usize,
                        phases: number(4) as usize,
                        sum: number(5),
                        range,
                    };
                    outcomes.insert(current.take().unwrap(), (number(2), read));
                }
                "ERROR" => {
                    let refused = Outcome::Refused(fields[3..].join("\t"));
                    outcomes.insert(current.take().unwrap(), (number(2), refused));
                }
                _ => {}
            }
        }
        let status = child.wait().unwrap();
        if let Some(path) = current {
            println!("{} ended the process: {status}", path.display());
            outcomes.insert(path, (0.0, Outcome::Died));
        }
        rest = &rest[rest.iter().take_while(|path| outcomes.contains_key(*path)).count()..];
    }
    outcomes
}

/// Files, by the beginning of their paths, where this reader and the reference differ, and why this one is right.
const DIFFERENT: [(&str, &str); 8] = [
    (
        "pydicom_files/JPGExtended.dcm",
        "lossy: the inverse transform is rounded here, and cut there, to 0.1% of the sum",
    ),
    ("ct_tilt/", "the reference keeps PixelPaddingValue -1500; here padding is air"),
    ("mr_missing_slices/36747043", "the reference keeps PixelPaddingValue; here padding is the lowest value"),
    ("mr_missing_slices/36747062", "the reference keeps PixelPaddingValue; here padding is the lowest value"),
    ("pydicom_files/693_J2KI.dcm", "the reference keeps PixelPaddingValue; here padding is air"),
    (
        "pydicom_files/J2K_pixelrep_mismatch.dcm",
        "the reference keeps the -2000 around the round field; here what was not measured is air, and told",
    ),
    ("pydicom_files/rtdose", "the reference knows nothing of DoseGridScaling; here doses are in Gy"),
    (
        "enhanced/philips/1901_WIP_3DpCASL_real.dcm",
        "the reference knows nothing of the frames' own rescale, of slope 0.1",
    ),
];

/// Files of the shared scans, those of them that are read, and those that another reader reads alike.
const FILES: usize = 881;
const READ: usize = 802;
const AGREE: usize = 755;

#[test]
fn every_file_is_read_or_refused_within_its_limits() {
    let (Some(root), Some(_)) = (common::shared(""), common::shared("reference.csv")) else { return };
    let lines = common::reference("");
    // Zipped studies as they come out of their archives.
    let archives: Vec<_> = ["ct_torso", "ct_mixed_folder", "mr_missing_slices"]
        .into_iter()
        .filter_map(|name| common::unzip(&format!("{name}.zip")))
        .collect();
    let find = |name: &str| {
        let in_archive = archives.iter().map(|folder| folder.path().join(name)).find(|path| path.exists());
        in_archive.or_else(|| Some(root.join(name)).filter(|path| path.exists()))
    };
    let mut files: Vec<(String, PathBuf)> =
        lines.keys().filter_map(|name| Some((name.clone(), find(name)?))).collect();
    files.sort();
    // Whole studies too, and files that the reference could not open.
    let mut paths: Vec<PathBuf> = archives.iter().map(|folder| folder.path().to_owned()).collect();
    for name in
        ["ct_torso.zip", "ct_mixed_folder.zip", "mr_missing_slices.zip", "ct_tilt", "enhanced", "fragmented"]
    {
        paths.push(root.join(name));
    }
    paths.extend(std::fs::read_dir(root.join("bad")).unwrap().map(|entry| entry.unwrap().path()));
    paths.extend(files.iter().map(|(_, path)| path.clone()));
    let outcomes = outcomes(&paths);

    let mut faults = Vec::new();
    for (path, (seconds, outcome)) in &outcomes {
        if matches!(outcome, Outcome::Died) {
            faults.push(format!("{} ended the process", path.display()));
        }
        if *seconds > MOST_SECONDS {
            faults.push(format!("{} took {seconds} s", path.display()));
        }
    }
    let (mut agree, mut differ, mut read, mut refused, mut slowest) = (0, 0, 0, 0, 0.0f64);
    for (name, path) in &files {
        let (seconds, outcome) = &outcomes[path];
        let line = &lines[name];
        slowest = slowest.max(*seconds);
        match outcome {
            Outcome::Died => {}
            Outcome::Refused(error) => {
                refused += 1;
                let why = ["colour", "is missing"];
                if line.status == "ok" && !why.iter().any(|why| error.contains(why)) {
                    faults.push(format!("{name} is refused: {error}"));
                }
            }
            Outcome::Read { slices, phases, sum, range } => {
                read += 1;
                // The reference knows one rescale for all frames, and nothing of phases.
                if line.status == "ok" && *slices >= line.frames && *phases == 1 {
                    let near = |a: f64, b: f64| (a - b).abs() <= 1e-6 * a.abs().max(b.abs());
                    if near(*sum, line.sum) && near(range[0], line.range[0]) && near(range[1], line.range[1])
                    {
                        agree += 1;
                    } else if DIFFERENT.iter().any(|(known, _)| name.starts_with(known)) {
                        differ += 1;
                    } else {
                        faults.push(format!("{name}: {sum} {range:?}, not {} {:?}", line.sum, line.range));
                    }
                }
            }
        }
    }
    println!(
        "{} files: {read} read, of which {agree} agree with the reference and {differ} differ as explained, {refused} \
         refused; slowest {slowest:.2} s",
        files.len()
    );
    DIFFERENT.iter().for_each(|(name, why)| println!("{name} differs: {why}"));
    assert!(faults.is_empty(), "{:#?}", faults);
    // What docs/import.md says; more of them is no fault.
    for (count, least) in [(files.len(), FILES), (read, READ), (agree, AGREE)] {
        assert!(count >= least, "{count} of {} files, not {least}", files.len());
    }
}
