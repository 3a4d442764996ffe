//! What a scan of files that hold one volume reads: headers, and sizes of files. Alone in its process, whose memory it
//! measures.

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
    sync::Mutex,
};

use flate2::{Compression, write::GzEncoder};
use lumivox_core::{CancelToken, Progress, WorkStage};
#[cfg(target_os = "linux")]
use lumivox_import::RawDescription;
use lumivox_import::{ImportError, ImportOptions, Study};

fn open_with(path: &Path, options: &ImportOptions) -> Result<Study, ImportError> {
    Study::open(&[path.to_owned()], options, Progress::SILENT, &CancelToken::new())
}

fn open(path: &Path) -> Result<Study, ImportError> {
    open_with(path, &ImportOptions::default())
}

fn load(study: &mut Study, phase: Option<usize>) -> Result<Vec<f64>, ImportError> {
    let mut options = ImportOptions::default();
    options.phase = phase;
    let volume = study.load(&options, Progress::SILENT, &CancelToken::new())?.volume;
    let value = |i| volume.voxels().get(i) * volume.slope() + volume.intercept();
    Ok((0..volume.voxel_count()).map(value).collect())
}

/// A NIfTI-1 header for samples of 16 bits; spacing 2 x 3 x 4 mm.
fn nifti(dims: &[i16], datatype: i16, bits: i16) -> Vec<u8> {
    let mut header = vec![0; 352];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348i32.to_le_bytes());
    put(40, &(dims.len() as i16).to_le_bytes());
    dims.iter().enumerate().for_each(|(i, n)| put(42 + 2 * i, &n.to_le_bytes()));
    put(70, &datatype.to_le_bytes());
    put(72, &bits.to_le_bytes());
    [1f32, 2.0, 3.0, 4.0, 1.0].iter().enumerate().for_each(|(i, mm)| put(76 + 4 * i, &mm.to_le_bytes()));
    put(108, &352f32.to_le_bytes());
    put(344, b"n+1\0");
    header
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// A file that begins so, and goes on with a hole of zeros.
#[cfg(target_os = "linux")]
fn with_hole(path: &Path, head: &[u8], length: u64) {
    fs::write(path, head).unwrap();
    fs::File::options().write(true).open(path).unwrap().set_len(length).unwrap();
}

#[cfg(target_os = "linux")]
#[test]
fn a_scan_and_its_picture_take_no_memory_for_the_volume() {
    fn peak() -> u64 {
        let status = fs::read_to_string("/proc/self/status").unwrap();
        let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap();
        line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() * 1024
    }
    const SIDE: u64 = 4096;
    const VOLUME: u64 = 2 * SIDE * SIDE * SIDE;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let nrrd = format!(
        "NRRD0004\ntype: short\ndimension: 3\nsizes: {SIDE} {SIDE} {SIDE}\nendian: little\nencoding: raw\n"
    );
    let meta = format!(
        "ObjectType = Image\nNDims = 3\nDimSize = {SIDE} {SIDE} {SIDE}\nElementSpacing = 1 1 1\nElementType = MET_SHORT\n"
    );
    let attached = format!("{nrrd}\n");
    fs::write(at("a.nhdr"), format!("{nrrd}data file: samples\n")).unwrap();
    fs::write(at("a.mhd"), format!("{meta}ElementDataFile = samples\n")).unwrap();
    let local = format!("{meta}ElementDataFile = LOCAL\n");
    with_hole(&at("samples"), b"", VOLUME);
    let described = RawDescription::parse(&format!("{SIDE}x{SIDE}x{SIDE}:i16le")).unwrap();
    let header = nifti(&[SIDE as i16; 3], 4, 16);
    let files: [(&str, &str, &[u8]); 5] = [
        ("a.nii", "NIfTI", &header),
        ("a.nrrd", "NRRD", attached.as_bytes()),
        ("a.mha", "MetaImage", local.as_bytes()),
        ("a.nhdr", "NRRD", b""),
        ("a.mhd", "MetaImage", b""),
    ];
    let mut options = ImportOptions::default();
    for (name, format, head) in files.into_iter().chain([("samples", "RAW", &b""[..])]) {
        let path = at(name);
        if !head.is_empty() {
            with_hole(&path, head, head.len() as u64 + VOLUME);
        }
        options.raw = (format == "RAW").then(|| described.clone());
        let study = open_with(&path, &options).unwrap();
        let (report, series) = (study.report(), &study.report().series[0]);
        assert_eq!((report.format.as_str(), series.dims, series.bytes), (format, [SIDE as usize; 3], VOLUME));
        let thumbnail = study.thumbnail(0, 16, &CancelToken::new()).unwrap();
        assert_eq!(thumbnail.width.max(thumbnail.height), 16, "{name}");
        // A byte less, and the scan says so.
        let data = if head.is_empty() { at("samples") } else { path.clone() };
        fs::File::options().write(true).open(&data).unwrap().set_len(head.len() as u64 + VOLUME - 1).unwrap();
        let error = open_with(&path, &options).err().unwrap().to_string();
        let expected =
            if format == "RAW" { format!("makes {VOLUME} bytes") } else { format!("promises {VOLUME}") };
        assert!(error.contains(&expected), "{name}: {error}");
        fs::File::options().write(true).open(&data).unwrap().set_len(head.len() as u64 + VOLUME).unwrap();
    }
    // A slice of 32 MiB, as samples and as values.
    assert!(peak() < 512 << 20, "{} MiB", peak() >> 20);
}

#[test]
fn a_gzipped_header_is_all_that_is_inflated() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.nii.gz");
    let samples: Vec<u8> = (0..64 * 64 * 64u32).map(|i| (i / 5 % 251) as u8).collect();
    let mut file = gzip(&[nifti(&[64, 64, 64], 2, 8), samples].concat());
    file.truncate(file.len() / 3);
    fs::write(&path, &file).unwrap();
    let mut study = open(&path).unwrap();
    let series = &study.report().series[0];
    assert_eq!((series.dims, series.spacing_mm), ([64; 3], [2.0, 3.0, 4.0]));
    assert_eq!((series.orientation.as_str(), series.files), ("axial", 1));
    assert!(matches!(load(&mut study, None), Err(ImportError::Truncated { .. })));
    let picture = study.thumbnail(0, 16, &CancelToken::new());
    assert!(matches!(picture, Err(ImportError::Truncated { .. })));
    // What no stream of this size can hold shows at once.
    fs::write(&path, gzip(&nifti(&[4096, 4096, 4096], 2, 8))).unwrap();
    assert!(open(&path).err().unwrap().to_string().contains("cannot hold"));
}

#[test]
fn data_files_that_are_not_there_show_when_the_header_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 1 3\nencoding: raw\n";
    let meta = "ObjectType = Image\nNDims = 3\nDimSize = 2 1 3\nElementType = MET_UCHAR\n";
    let headers = [
        ("a.nhdr", format!("{nrrd}data file: s%d.raw 1 3 1\n")),
        ("b.nhdr", format!("{nrrd}data file: LIST\ns1.raw\ns2.raw\ns3.raw\n")),
        ("a.mhd", format!("{meta}ElementDataFile = s%d.raw 1 3 1\n")),
        ("b.mhd", format!("{meta}ElementDataFile = LIST\ns1.raw\ns2.raw\ns3.raw\n")),
    ];
    for (name, header) in &headers {
        fs::write(at(name), header).unwrap();
        (1..=3u8).for_each(|k| fs::write(at(&format!("s{k}.raw")), [k, 10 * k]).unwrap());
        let mut study = open(&at(name)).unwrap();
        assert_eq!(study.report().series[0].files, 4);
        assert_eq!(load(&mut study, None).unwrap(), [1.0, 10.0, 2.0, 20.0, 3.0, 30.0], "{name}");
        fs::write(at("s3.raw"), [1]).unwrap();
        let error = open(&at(name)).err().unwrap();
        assert!(matches!(&error, ImportError::Truncated { expected: 2, actual: 1, .. }), "{name}: {error}");
        assert!(error.to_string().contains("s3.raw"), "{name}: {error}");
        fs::remove_file(at("s3.raw")).unwrap();
        let error = open(&at(name)).err().unwrap().to_string();
        assert!(error.contains(name) && error.contains("s3.raw' is not there"), "{name}: {error}");
    }
}

#[test]
fn phases_are_read_one_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let samples: Vec<u8> = (0..12u16).flat_map(|v| (v + 300).to_le_bytes()).collect();
    let whole = [nifti(&[2, 1, 2, 3], 512, 16), samples.clone()].concat();
    fs::write(at("a.nii"), &whole).unwrap();
    fs::write(at("a.nii.gz"), gzip(&whole)).unwrap();
    let head = "NRRD0004\ntype: ushort\ndimension: 4\nsizes: 2 1 2 3\nendian: little\n";
    fs::write(at("a.nrrd"), [format!("{head}encoding: raw\n\n").as_bytes(), &samples].concat()).unwrap();
    let hex: String = samples.iter().map(|byte| format!("{byte:02x}\n")).collect();
    fs::write(at("hex.nrrd"), format!("{head}encoding: hex\n\n{hex}")).unwrap();
    // 3D Slicer's sequences have the axis of phases first.
    let turned: Vec<u8> = (0..12).flat_map(|i| (300 + (i % 3) * 4 + i / 3u16).to_le_bytes()).collect();
    let head_turned = head.replace("2 1 2 3", "3 2 1 2");
    let kinds = "kinds: list domain domain domain\nspace: left-posterior-superior\n\
                 space directions: none (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n\n";
    fs::write(at("turned.nrrd"), [head_turned.as_bytes(), kinds.as_bytes(), &turned].concat()).unwrap();
    let vectors = kinds.replace("list", "vector");
    fs::write(at("vectors.nrrd"), [head_turned.as_bytes(), vectors.as_bytes(), &turned].concat()).unwrap();
    assert!(open(&at("vectors.nrrd")).err().unwrap().to_string().contains("3 values for each voxel"));
    let text: String = (300..312).map(|v| format!("{v} ")).collect();
    fs::write(at("text.nrrd"), format!("{head}encoding: ascii\n\n{text}")).unwrap();
    // The phases do not end where the files do.
    let meta = "ObjectType = Image\nNDims = 4\nDimSize = 2 1 2 3\nElementType = MET_USHORT\n";
    fs::write(at("a.mhd"), format!("{meta}ElementDataFile = LIST\n0\n1\n")).unwrap();
    samples.chunks(12).enumerate().for_each(|(k, bytes)| fs::write(at(&k.to_string()), bytes).unwrap());
    for name in ["a.nii", "a.nii.gz", "a.nrrd", "hex.nrrd", "text.nrrd", "turned.nrrd", "a.mhd"] {
        let mut study = open(&at(name)).unwrap();
        let series = &study.report().series[0];
        assert_eq!((series.phases, series.dims, series.bytes), (3, [2, 1, 2], 8), "{name}");
        assert!(series.notes.contains(&"3 phases".to_owned()), "{name}: {:?}", series.notes);
        for (phase, first) in [(None, 300.0), (Some(1), 300.0), (Some(2), 304.0), (Some(3), 308.0)] {
            let expected: Vec<f64> = (0..4).map(|i| first + f64::from(i)).collect();
            assert_eq!(load(&mut study, phase).unwrap(), expected, "{name}, {phase:?}");
        }
        for wanted in [0, 4] {
            let error = load(&mut study, Some(wanted)).unwrap_err();
            assert!(matches!(error, ImportError::NoSuchPhase { phases: 3, .. }), "{name}: {error}");
        }
    }
}

#[test]
fn loading_tells_how_far_it_is_and_can_be_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join("a.nii.gz");
    fs::write(&path, gzip(&[nifti(&[256, 256, 64], 2, 8), vec![7; 256 * 256 * 64]].concat())).unwrap();
    let mut study = open(&path).unwrap();
    let steps = Mutex::new(Vec::new());
    let watch = |stage, done, total| {
        assert_eq!((stage, total), (WorkStage::Decoding, 1 << 22));
        steps.lock().unwrap().push(done);
    };
    study.load(&ImportOptions::default(), Progress::new(&watch), &CancelToken::new()).unwrap();
    let steps = steps.into_inner().unwrap();
    assert!(steps.is_sorted() && steps.len() >= 4 && steps.last() == Some(&(1 << 22)), "{steps:?}");

    let cancel = CancelToken::new();
    let stop = |_, done, _| {
        if done > 0 {
            cancel.cancel()
        }
    };
    let result = study.load(&ImportOptions::default(), Progress::new(&stop), &cancel);
    assert!(matches!(result, Err(ImportError::Cancelled(_))));
    assert!(matches!(study.thumbnail(0, 16, &cancel), Err(ImportError::Cancelled(_))));
}
