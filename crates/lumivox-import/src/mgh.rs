//! FreeSurfer's volumes: `.mgh`, and gzipped as `.mgz`.
//!
//! After <https://surfer.nmr.mgh.harvard.edu/fswiki/FsTutorial/MghFormat>: a header of 284 bytes in big endian, and the
//! samples. Directions and the centre are RAS: they are turned to LPS here.

use std::{
    io::{BufReader, Read},
    path::Path,
};

use lumivox_core::glam::{DAffine3, DMat3, DVec3};

use crate::{
    error::ImportError,
    files::File,
    payload::{Encoding, GZIP_MAGIC, Payload, fill, inflate},
    sample::SampleType,
    single::{Single, is_placement, lps_from_ras},
};

/// Where the samples begin.
const HEADER_BYTES: usize = 284;
/// Sides of grids that are believed where nothing but numbers tells the format.
const LONGEST_SIDE: i32 = 1 << 16;

/// Whether a file that begins so (after inflating) is a volume of FreeSurfer: it has no word to know it by, but a version
/// and a handful of numbers that have to fit.
pub(crate) fn is_mgh(head: &[u8]) -> bool {
    let long =
        |at: usize| head.get(4 * at..).and_then(|rest| rest.first_chunk()).map(|b| i32::from_be_bytes(*b));
    let side = |at: usize| long(at).is_some_and(|side| (1..=LONGEST_SIDE).contains(&side));
    let flag = head.get(28..30).is_some_and(|flag| flag == [0, 0] || flag == [0, 1]);
    long(0) == Some(1) && (1..=4).all(side) && long(5).is_some_and(|kind| sample_type(kind).is_some()) && flag
}

fn sample_type(kind: i32) -> Option<SampleType> {
    Some(match kind {
        0 => SampleType::U8,
        1 => SampleType::I32,
        3 => SampleType::F32,
        4 => SampleType::I16,
        10 => SampleType::U16,
        _ => return None,
    })
}

/// Reads the header of a volume.
///
/// # Errors
/// [`ImportError`] names the field, or the data that are missing.
pub(crate) fn open(path: &Path) -> Result<Single, ImportError> {
    let io = |fault| ImportError::Io { path: path.to_owned(), source: fault };
    let mut file = BufReader::new(File::open(path).map_err(io)?);
    let mut magic = [0; 2];
    let n = fill(&mut file, &mut magic).map_err(io)?;
    file.seek_relative(-(n as i64)).map_err(io)?;
    let deflated = magic == GZIP_MAGIC;
    let mut input: Box<dyn Read> = if deflated { inflate(file).map_err(io)? } else { Box::new(file) };
    let mut head = [0; HEADER_BYTES];
    let actual = fill(&mut *input, &mut head).map_err(io)?;
    if actual < HEADER_BYTES {
        let (expected, actual) = (HEADER_BYTES as u64, actual as u64);
        return Err(ImportError::Truncated { path: path.to_owned(), expected, actual });
    }
    let four = |at: usize| [head[at], head[at + 1], head[at + 2], head[at + 3]];
    let long = |index: usize| i32::from_be_bytes(four(4 * index));
    let float = |index: usize| f64::from(f32::from_be_bytes(four(30 + 4 * index)));
    let vector = |index: usize| DVec3::new(float(index), float(index + 1), float(index + 2));
    let field = |field: &str, problem: String| ImportError::Field {
        path: path.to_owned(),
        field: field.to_owned(),
        problem,
        remedy: "The header is damaged; export the volume again".to_owned(),
    };
    let mut sizes = [0; 4];
    for (index, (size, name)) in sizes.iter_mut().zip(["width", "height", "depth", "nframes"]).enumerate() {
        let stored = long(index + 1);
        *size = usize::try_from(stored)
            .ok()
            .filter(|size| *size > 0)
            .ok_or_else(|| field(name, format!("is {stored}, not a number of voxels")))?;
    }
    let [x, y, z, phases] = sizes;
    let sample = sample_type(long(5)).ok_or_else(|| {
        field("type", format!("is {}, which stands for no numbers that are known", long(5)))
    })?;
    let mut notes = Vec::new();
    let is_placed = head[28..30] != [0, 0];
    // Where the header does not say, FreeSurfer takes coronal slices of 1 mm around the origin.
    let (spacing, directions, centre) = if is_placed {
        (vector(0), DMat3::from_cols(vector(3), vector(6), vector(9)), vector(12))
    } else {
        notes
            .push("no orientation is given: taken for coronal slices of 1 mm, as FreeSurfer does".to_owned());
        (DVec3::ONE, DMat3::from_cols(DVec3::NEG_X, DVec3::NEG_Z, DVec3::Y), DVec3::ZERO)
    };
    let matrix = directions * DMat3::from_diagonal(spacing);
    let middle = DVec3::new(x as f64, y as f64, z as f64) / 2.0;
    let ras = DAffine3::from_mat3_translation(matrix, centre - matrix * middle);
    if !is_placement(ras) {
        return Err(field("the directions of the axes", "do not make a space".to_owned()));
    }
    let encoding = if deflated { Encoding::Deflate } else { Encoding::Raw };
    Single {
        path: path.to_owned(),
        format: "MGH",
        dims: [x, y, z],
        phases,
        payload: Payload { encoding, ..Payload::in_file(path, sample, true, HEADER_BYTES as u64) }.into(),
        rescale: [1.0, 0.0],
        patient_from_voxel: lps_from_ras() * ras,
        modality: None,
        notes,
    }
    .checked()
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use lumivox_core::{CancelToken, Progress};

    use super::*;

    /// 2 x 3 x 1 voxels of 1 x 2 x 3 mm, axes along R, A and S.
    fn volume(kind: i32, flag: u8, samples: &[u8]) -> Vec<u8> {
        let mut bytes: Vec<u8> =
            [1, 2, 3, 1, 1, kind, 0].iter().flat_map(|n: &i32| n.to_be_bytes()).collect();
        bytes.extend([0, flag]);
        let floats = [1.0f32, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 10.0, 20.0, 30.0];
        bytes.extend(floats.iter().flat_map(|f| f.to_be_bytes()));
        bytes.resize(HEADER_BYTES, 0);
        bytes.extend(samples);
        bytes
    }

    fn load(bytes: &[u8]) -> Result<crate::Imported, ImportError> {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(bytes).unwrap();
        open(file.path())?.load(None, &crate::values::Told::default(), Progress::SILENT, &CancelToken::new())
    }

    #[test]
    fn values_and_places_are_those_of_freesurfer() {
        let samples: Vec<u8> = [-5i16, 1, 2, 3, 4, 500].iter().flat_map(|n| n.to_be_bytes()).collect();
        let bytes = volume(4, 1, &samples);
        assert!(is_mgh(&bytes));
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(&bytes).unwrap();
        for bytes in [bytes, encoder.finish().unwrap()] {
            let volume = load(&bytes).unwrap().volume;
            assert_eq!((volume.dims(), volume.spacing_mm()), ([2, 3, 1], DVec3::new(1.0, 2.0, 3.0)));
            assert_eq!((volume.value([0, 0, 0]), volume.value([1, 2, 0])), (-5.0, 500.0));
            // RAS (10 - 1, 20 - 3, 30 - 1.5) mm.
            assert_eq!(volume.patient_from_voxel().translation, DVec3::new(-9.0, -17.0, 28.5));
        }
        let unplaced = load(&volume(0, 0, &[0, 1, 2, 3, 4, 5])).unwrap();
        assert_eq!(unplaced.volume.patient_from_voxel().matrix3.x_axis, DVec3::X);
        assert_eq!(unplaced.volume.patient_from_voxel().matrix3.y_axis, DVec3::NEG_Z);
        assert!(unplaced.report.notes[0].contains("as FreeSurfer does"));
    }

    #[test]
    fn damage_is_named() {
        let samples = [0; 6];
        let mut flat = volume(0, 1, &samples);
        flat[42..46].fill(0);
        assert!(load(&flat).unwrap_err().to_string().contains("do not make a space"));
        assert!(load(&volume(7, 1, &samples)).unwrap_err().to_string().contains("type is 7"));
        assert!(matches!(load(&volume(0, 1, &samples[..5])), Err(ImportError::Truncated { .. })));
        assert!(matches!(load(&volume(0, 1, &samples)[..100]), Err(ImportError::Truncated { .. })));
        let mut many = volume(0, 1, &samples);
        many[4..8].copy_from_slice(&(-2i32).to_be_bytes());
        assert!(load(&many).unwrap_err().to_string().contains("width is -2"));
        assert!(!is_mgh(&many) && !is_mgh(b"") && !is_mgh(&[0; 300]));
    }
}
