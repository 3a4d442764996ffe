use std::fs;

use lumivox_core::Progress;

use super::*;
use crate::Imported;

fn load(single: &Single, phase: usize) -> Imported {
    single.load(Some(phase), &crate::values::Told::default(), Progress::SILENT, &CancelToken::new()).unwrap()
}

fn values(imported: &Imported) -> Vec<f64> {
    let volume = &imported.volume;
    (0..volume.voxel_count()).map(|i| volume.voxels().get(i) * volume.slope() + volume.intercept()).collect()
}

fn open_default(folder: &Path) -> Result<Vec<Single>, ImportError> {
    open(folder, &ImportOptions::default(), &CancelToken::new())
}

/// Voxel of an image: 1000 t + 100 c + 10 z + 4 y + x.
fn voxel([t, c, z, y, x]: [usize; 5]) -> u16 {
    (1000 * t + 100 * c + 10 * z + 4 * y + x) as u16
}

const SHAPE: [usize; 5] = [2, 2, 3, 2, 3];
const CHUNK: [usize; 5] = [1, 1, 2, 2, 2];

/// Writes the chunks of an array, `pack` as they are compressed, `name` as they are called.
fn write_chunks(folder: &Path, name: impl Fn(&[usize]) -> String, pack: impl Fn(&[u8]) -> Vec<u8>) {
    let counts: Vec<usize> = SHAPE.iter().zip(CHUNK).map(|(side, chunk)| side.div_ceil(chunk)).collect();
    for at in 0..counts.iter().product::<usize>() {
        let mut rest = at;
        let mut index = [0; 5];
        for axis in (0..5).rev() {
            index[axis] = rest % counts[axis];
            rest /= counts[axis];
        }
        let mut bytes = Vec::new();
        for k in 0..CHUNK.iter().product::<usize>() {
            let mut rest = k;
            let mut place = [0; 5];
            for axis in (0..5).rev() {
                place[axis] = index[axis] * CHUNK[axis] + rest % CHUNK[axis];
                rest /= CHUNK[axis];
            }
            bytes.extend(voxel(place).to_le_bytes());
        }
        let path = folder.join(name(&index));
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, pack(&bytes)).unwrap();
    }
}

fn blosc(bytes: &[u8]) -> Vec<u8> {
    let shuffled: Vec<u8> = bytes.iter().step_by(2).chain(bytes.iter().skip(1).step_by(2)).copied().collect();
    let packed = lz4_flex::block::compress(&shuffled);
    let mut out = vec![2, 1, 1 << 5 | 16 | 1, 2];
    out.extend((bytes.len() as u32).to_le_bytes());
    out.extend((bytes.len() as u32).to_le_bytes());
    out.extend([0; 4]);
    out.extend(20u32.to_le_bytes());
    out.extend((packed.len() as u32).to_le_bytes());
    out.extend(packed);
    out
}

const IMAGE: &str = r#"{"multiscales": [{"version": "0.4",
    "axes": [{"name": "t", "type": "time"}, {"name": "c", "type": "channel"}, {"name": "z", "type": "space", "unit": "micrometer"},
             {"name": "y", "type": "space", "unit": "micrometer"}, {"name": "x", "type": "space", "unit": "micrometer"}],
    "datasets": [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 2.0, 0.5, 0.5]},
                                                            {"type": "translation", "translation": [0, 0, 10, 0, 0]}]}]}]}"#;

fn array(compressor: &str) -> String {
    format!(
        r#"{{"zarr_format": 2, "shape": [2,2,3,2,3], "chunks": [1,1,2,2,2], "dtype": "<u2", "order": "C", "fill_value": 7,
            "filters": null, "dimension_separator": "/", "compressor": {compressor}}}"#
    )
}

/// An image of Zarr 2.
fn image(compressor: &str, pack: impl Fn(&[u8]) -> Vec<u8>) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("0")).unwrap();
    fs::write(folder.path().join(".zattrs"), IMAGE).unwrap();
    fs::write(folder.path().join("0/.zarray"), array(compressor)).unwrap();
    let name = |index: &[usize]| {
        let names: Vec<String> = index.iter().map(usize::to_string).collect();
        format!("0/{}", names.join("/"))
    };
    write_chunks(folder.path(), name, pack);
    folder
}

fn expected(t: usize, c: usize) -> Vec<f64> {
    let places = (0..3).flat_map(|z| (0..2).flat_map(move |y| (0..3).map(move |x| [t, c, z, y, x])));
    places.map(|place| f64::from(voxel(place))).collect()
}

#[test]
fn channels_and_moments_are_told_apart() {
    for (compressor, packed) in [("null", false), (r#"{"id": "blosc", "cname": "lz4", "shuffle": 1}"#, true)]
    {
        let folder = image(compressor, |bytes| if packed { blosc(bytes) } else { bytes.to_vec() });
        assert!(is_zarr(folder.path()));
        let channels = open_default(folder.path()).unwrap();
        assert_eq!((channels.len(), channels[0].dims, channels[0].phases), (2, [3, 2, 3], 2));
        for (c, channel) in channels.iter().enumerate() {
            for t in 0..2 {
                assert_eq!(values(&load(channel, t + 1)), expected(t, c), "{compressor} {t} {c}");
            }
        }
        let volume = load(&channels[0], 1).volume;
        assert!(volume.spacing_mm().distance(DVec3::new(5e-4, 5e-4, 2e-3)) < 1e-12);
        assert!((volume.patient_from_voxel().translation.z - 0.01).abs() < 1e-12);
        // A level by itself has the same places.
        let level = open_default(&folder.path().join("0")).unwrap();
        assert_eq!(values(&load(&level[1], 2)), expected(1, 1));
        assert!(load(&level[0], 1).volume.spacing_mm().distance(DVec3::new(5e-4, 5e-4, 2e-3)) < 1e-12);
    }
}

#[test]
fn proportions_are_kept_where_the_unit_is_unknown() {
    let folder = image("null", <[u8]>::to_vec);
    fs::write(folder.path().join(".zattrs"), IMAGE.replace(r#", "unit": "micrometer""#, "")).unwrap();
    for path in [folder.path().to_owned(), folder.path().join("0")] {
        let imported = load(&open_default(&path).unwrap()[0], 1);
        assert_eq!(imported.volume.spacing_mm(), DVec3::new(0.5, 0.5, 2.0));
        let notes = &imported.report.notes;
        assert!(notes.iter().any(|note| note.contains("0.5 x 0.5 x 2, have no known unit")), "{notes:?}");
    }
    // Steps that are alike say nothing.
    let alike = IMAGE.replace(r#", "unit": "micrometer""#, "").replace("2.0, 0.5, 0.5", "0.5, 0.5, 0.5");
    fs::write(folder.path().join(".zattrs"), alike).unwrap();
    let imported = load(&open_default(folder.path()).unwrap()[0], 1);
    assert_eq!(imported.volume.spacing_mm(), DVec3::ONE);
}

#[test]
fn zarr_3_is_read_and_what_was_never_written_is_filled() {
    let folder = tempfile::tempdir().unwrap();
    let json = r#"{"zarr_format": 3, "node_type": "array", "shape": [2,2,3,2,3], "data_type": "uint16", "fill_value": 7,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [1,1,2,2,2]}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
        "codecs": [{"name": "bytes", "configuration": {"endian": "little"}}, {"name": "zstd", "configuration": {"level": 0}}]}"#;
    fs::create_dir(folder.path().join("s0")).unwrap();
    fs::write(folder.path().join("s0/zarr.json"), json).unwrap();
    let image = IMAGE.replace("\"path\": \"0\"", "\"path\": \"s0\"");
    let group = format!(r#"{{"zarr_format": 3, "node_type": "group", "attributes": {{"ome": {image}}}}}"#);
    fs::write(folder.path().join("zarr.json"), group).unwrap();
    let name = |index: &[usize]| {
        format!("s0/c/{}", index.iter().map(usize::to_string).collect::<Vec<_>>().join("/"))
    };
    let zstd =
        |bytes: &[u8]| ruzstd::encoding::compress_to_vec(bytes, ruzstd::encoding::CompressionLevel::Fastest);
    write_chunks(folder.path(), name, zstd);
    let channels = open_default(folder.path()).unwrap();
    assert_eq!(values(&load(&channels[1], 1)), expected(0, 1));
    fs::remove_file(folder.path().join("s0/c/0/1/0/0/1")).unwrap();
    let filled = values(&load(&channels[1], 1));
    assert_eq!(filled[..6], [100.0, 101.0, 7.0, 104.0, 105.0, 7.0]);
    let sharded = json.replace("\"name\": \"bytes\"", "\"name\": \"sharding_indexed\"");
    fs::write(folder.path().join("s0/zarr.json"), sharded).unwrap();
    assert!(open_default(folder.path()).err().unwrap().to_string().contains("a sharded array"));
}

#[test]
fn strangers_numbers_cost_nothing() {
    let folder = image("null", |bytes| bytes.to_vec());
    let path = folder.path().join("0/.zarray");
    let whole = array("null");
    for (from, to, words) in [
        ("[2,2,3,2,3]", "[2,2,999999999,99999,99999]", "more than can be read"),
        // Not too large, but never written.
        (
            "[2,2,3,2,3], \"chunks\": [1,1,2,2,2]",
            "[2,2,600,600,600], \"chunks\": [1,1,300,300,300]",
            "hardly a chunk",
        ),
        ("[1,1,2,2,2]", "[1,1,99999,99999,99999]", "do not fit together"),
        ("[1,1,2,2,2]", "[1,1,0,2,2]", "no size of chunks"),
        ("[2,2,3,2,3]", "[2,2,3]", "do not fit together"),
        ("\"<u2\"", "\"<c8\"", "no real numbers"),
        ("\"C\"", "\"F\"", "Fortran"),
        ("null, \"dim", "[{}], \"dim", "filters"),
        ("\"compressor\": null", "\"compressor\": {\"id\": \"lzma\"}", "compressed as 'lzma'"),
    ] {
        let changed = whole.replace(from, to);
        assert_ne!(changed, whole, "{from}");
        fs::write(&path, changed).unwrap();
        let error = open_default(folder.path()).err().unwrap().to_string();
        assert!(error.contains(words), "{words}: {error}");
    }
    fs::write(&path, &whole).unwrap();
    let attributes = folder.path().join(".zattrs");
    for (from, to, words) in [
        ("\"path\": \"0\"", "\"path\": \"../0\"", "does not lie below"),
        ("\"path\": \"0\"", "\"path\": \"/etc\"", "does not lie below"),
        ("\"name\": \"z\"", "\"name\": \"depth\"", "names axes"),
        ("[{\"path\": \"0\"", "[], \"x\": [{\"path\": \"0\"", "names no level"),
        ("{\"multiscales\"", "{multiscales", "is no JSON"),
    ] {
        let changed = IMAGE.replace(from, to);
        assert_ne!(changed, IMAGE, "{from}");
        fs::write(&attributes, changed).unwrap();
        let error = open_default(folder.path()).err().unwrap().to_string();
        assert!(error.contains(words), "{words}: {error}");
    }
    // A chunk that is cut short is named.
    fs::write(&attributes, IMAGE).unwrap();
    let chunk = folder.path().join("0/0/0/0/0/0");
    let bytes = fs::read(&chunk).unwrap();
    fs::write(&chunk, &bytes[..bytes.len() - 1]).unwrap();
    let channels = open_default(folder.path()).unwrap();
    let error = channels[0]
        .load(Some(1), &crate::values::Told::default(), Progress::SILENT, &CancelToken::new())
        .unwrap_err()
        .to_string();
    assert!(error.contains("holds 15 bytes where 16 belong"), "{error}");
}

/// Bytes of descriptions and chunks that are changed at random: read or refused in words, and soon.
#[test]
fn damaged_images_are_read_or_refused() {
    let folder = image(r#"{"id": "blosc"}"#, blosc);
    let files = [".zattrs", "0/.zarray", "0/0/0/0/0/0"].map(|name| folder.path().join(name));
    let mut state = 1u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for _ in 0..600 {
        let path = &files[random(files.len())];
        let whole = fs::read(path).unwrap();
        let mut bytes = whole.clone();
        let at = random(bytes.len());
        match random(4) {
            0 => bytes[at] = random(256) as u8,
            1 => bytes[at] = b"0129-e[]{}\"NaN."[random(15)],
            2 => bytes.truncate(at),
            _ => drop(bytes.splice(at..at, *b"99999")),
        }
        fs::write(path, &bytes).unwrap();
        if let Ok(channels) = open_default(folder.path()) {
            let _ = channels[0].load(
                None,
                &crate::values::Told::default(),
                Progress::SILENT,
                &CancelToken::new(),
            );
        }
        fs::write(path, whole).unwrap();
    }
}

#[test]
fn an_image_of_labels_is_a_label_map() {
    let folder = image("null", |bytes| bytes.to_vec());
    let mut options = crate::LabelOptions::default();
    options.import.series = Some("1".to_owned());
    let loaded = crate::load_labels(folder.path(), &options, Progress::SILENT, &CancelToken::new()).unwrap();
    assert_eq!(loaded.labels.dims(), [3, 2, 3]);
    assert_eq!(loaded.labels.voxels()[..6], [0, 1, 2, 4, 5, 6]);
}
