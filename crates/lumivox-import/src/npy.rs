//! Arrays of NumPy: `.npy`.
//!
//! After <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>: a magic word, a version, and a header
//! that is a dictionary in Python's own words. An array has no places: its axes are z, y and x by custom, the last of them
//! the fastest, of 1 mm; [`ImportOptions`] say it otherwise.

use std::{io::Read, path::Path};

use crate::{
    ImportOptions, error::ImportError, files::File, layout::ArrayLayout, payload::Payload,
    placement::placement, sample::SampleType, single::Single,
};

/// What every file begins with.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";
/// No header is longer.
const LONGEST_HEADER: usize = 1 << 16;

/// What a header says.
#[derive(Debug, PartialEq)]
struct Header {
    descr: String,
    /// Whether the first axis is the fastest.
    fortran_order: bool,
    shape: Vec<usize>,
}

/// Reads the header of an array.
///
/// # Errors
/// [`ImportError`] names the field, or the data that are missing.
pub(crate) fn open(path: &Path, options: &ImportOptions) -> Result<Single, ImportError> {
    let field = |field: &str, problem: String, remedy: &str| ImportError::Field {
        path: path.to_owned(),
        field: field.to_owned(),
        problem,
        remedy: remedy.to_owned(),
    };
    const DAMAGED: &str = "The file is damaged; save the array again with numpy.save";
    let mut file = File::open(path).map_err(ImportError::io(path))?;
    let mut head = Vec::new();
    (&mut file).take(LONGEST_HEADER as u64).read_to_end(&mut head).map_err(ImportError::io(path))?;
    let (text, start) = header_text(&head)
        .ok_or_else(|| field("the header", "ends before it says what the array is".to_owned(), DAMAGED))?;
    let header = parse(text)
        .ok_or_else(|| field("the header", "says no descr, fortran_order and shape".to_owned(), DAMAGED))?;
    let (sample, big_endian) = sample_type(&header.descr).ok_or_else(|| ImportError::Unsupported {
        path: path.to_owned(),
        what: "an array of what are no real numbers".to_owned(),
        remedy: "Save it as numbers: numpy.save(path, array.astype('float32'))".to_owned(),
    })?;
    // Colours of a voxel follow each other.
    let may_be_colours = !header.fortran_order && matches!(sample, SampleType::U8 | SampleType::U16);
    let layout = match &options.layout {
        Some(layout) => layout.clone(),
        None => ArrayLayout::usual(&header.shape, may_be_colours).ok_or_else(|| {
            field(
                "shape",
                format!("has {} axes", header.shape.len()),
                "Give one with two to four axes, or a layout (the option layout)",
            )
        })?,
    };
    // From the fastest axis on.
    let mut sizes = header.shape;
    if !header.fortran_order {
        sizes.reverse();
    }
    let letters = layout.letters_by_speed(header.fortran_order);
    if letters.len() != sizes.len() {
        let problem = format!("has {} axes where the layout {layout} names {}", sizes.len(), letters.len());
        return Err(field("shape", problem, "Give a layout with a letter for each axis"));
    }
    let grid = layout.grid(&letters, &sizes).ok_or_else(|| ImportError::Unsupported {
        path: path.to_owned(),
        what: format!("an array whose layout {layout} has moments or channels between the axes of space"),
        remedy: "Save it with numpy.moveaxis, so that they come first or last".to_owned(),
    })?;
    let mut notes = vec![format!("an array of {}, taken as {layout}", grid.words())];
    let patient_from_voxel = placement(options, &grid.space, None, &mut notes);
    Single {
        path: path.to_owned(),
        format: "NPY",
        dims: grid.dims,
        phases: grid.phases,
        payload: Payload {
            interleaved: grid.interleaved,
            channels: grid.channels,
            ..Payload::in_file(path, sample, big_endian, start as u64)
        }
        .into(),
        rescale: [1.0, 0.0],
        patient_from_voxel,
        modality: None,
        notes,
    }
    .checked()
}

/// The dictionary in a file's first bytes, and where the samples begin.
fn header_text(head: &[u8]) -> Option<(&str, usize)> {
    let version = *head.get(6)?;
    let (length, from) = match version {
        1 => (usize::from(u16::from_le_bytes([*head.get(8)?, *head.get(9)?])), 10),
        _ => (u32::from_le_bytes(*head.get(8..)?.first_chunk()?) as usize, 12),
    };
    let end = length.checked_add(from)?;
    Some((std::str::from_utf8(head.get(from..end)?).ok()?, end))
}

/// The parts of a dictionary such as `{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }`.
fn parse(text: &str) -> Option<Header> {
    let after = |key: &str| {
        let (_, rest) = text.split_once(&format!("'{key}'"))?;
        rest.trim_start().strip_prefix(':').map(str::trim_start)
    };
    let descr = after("descr")?.strip_prefix('\'')?.split('\'').next()?.to_owned();
    let order = after("fortran_order")?;
    let fortran_order = if order.starts_with("True") {
        true
    } else if order.starts_with("False") {
        false
    } else {
        return None;
    };
    let shape = after("shape")?.strip_prefix('(')?.split_once(')')?.0;
    let sizes = shape.split(',').map(str::trim).filter(|size| !size.is_empty());
    // Python 2 wrote long numbers with an L.
    let sizes: Option<Vec<usize>> = sizes.map(|size| size.trim_end_matches('L').parse().ok()).collect();
    Some(Header { descr, fortran_order, shape: sizes? })
}

/// The type of numbers such as `<f4`, and whether they are big endian.
fn sample_type(descr: &str) -> Option<(SampleType, bool)> {
    let (order, name) = descr.split_at_checked(1)?;
    let big_endian = match order {
        "<" | "|" | "=" => false,
        ">" => true,
        _ => return None,
    };
    let sample = match name {
        "b1" | "u1" => SampleType::U8,
        "i1" => SampleType::I8,
        "u2" => SampleType::U16,
        "i2" => SampleType::I16,
        "u4" => SampleType::U32,
        "i4" => SampleType::I32,
        "u8" => SampleType::U64,
        "i8" => SampleType::I64,
        "f4" => SampleType::F32,
        "f8" => SampleType::F64,
        _ => return None,
    };
    Some((sample, big_endian))
}

#[cfg(test)]
mod tests {
    use lumivox_core::{CancelToken, Progress, glam::DVec3};

    use super::*;

    fn array(descr: &str, fortran: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let text = format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}\n");
        let mut bytes = [MAGIC, &[1, 0], &(text.len() as u16).to_le_bytes(), text.as_bytes()].concat();
        bytes.extend(data);
        bytes
    }

    fn load(bytes: &[u8], options: &ImportOptions) -> Result<crate::Imported, ImportError> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        open(file.path(), options)?.load(
            options.phase,
            &crate::values::Told::by(options),
            Progress::SILENT,
            &CancelToken::new(),
        )
    }

    fn values(imported: &crate::Imported) -> Vec<f64> {
        (0..imported.volume.voxel_count())
            .map(|i| imported.volume.voxels().get(i) * imported.volume.slope() + imported.volume.intercept())
            .collect()
    }

    #[test]
    fn arrays_are_z_y_x_unless_said_otherwise() {
        let data: Vec<u8> = (0..6u16).flat_map(u16::to_be_bytes).collect();
        let mut options = ImportOptions::default();
        let plain = load(&array(">u2", "False", "(1, 2, 3)", &data), &options).unwrap();
        assert_eq!((plain.volume.dims(), values(&plain)), ([3, 2, 1], vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]));
        assert!(plain.report.notes[0].contains("taken as zyx"), "{:?}", plain.report.notes);
        // Of MATLAB's order the first axis is the fastest.
        let fortran = load(&array(">u2", "True", "(1, 2, 3)", &data), &options).unwrap();
        assert_eq!(fortran.volume.dims(), [1, 2, 3]);
        options.layout = Some("xyz".parse().unwrap());
        options.spacing_mm = Some([0.5, 2.0, 4.0]);
        // The fastest axis is z, whatever the order of voxels in memory.
        let turned = load(&array(">u2", "False", "(1, 2, 3)", &data), &options).unwrap();
        let matrix = turned.volume.patient_from_voxel().matrix3;
        assert_eq!(
            [matrix.x_axis, matrix.y_axis, matrix.z_axis],
            [DVec3::new(0.0, 0.0, 4.0), DVec3::new(0.0, 2.0, 0.0), DVec3::new(0.5, 0.0, 0.0)]
        );
        options.axes = Some("RAS".parse().unwrap());
        let ras = load(&array(">u2", "False", "(1, 2, 3)", &data), &options).unwrap();
        assert_eq!(ras.volume.patient_from_voxel().matrix3.z_axis, DVec3::new(-0.5, 0.0, 0.0));
    }

    #[test]
    fn moments_and_colours_are_told_by_the_layout() {
        let mut options = ImportOptions::default();
        let two = array("|u1", "False", "(2, 1, 1, 2)", &[1, 2, 3, 4]);
        let first = load(&two, &options).unwrap();
        assert_eq!((first.volume.dims(), values(&first)), ([2, 1, 1], vec![1.0, 2.0]));
        options.phase = Some(2);
        assert_eq!(values(&load(&two, &options).unwrap()), [3.0, 4.0]);
        let colours = array("|u1", "False", "(1, 1, 2, 3)", &[255, 255, 255, 0, 255, 0]);
        let options = ImportOptions { layout: Some("zyxc".parse().unwrap()), ..ImportOptions::default() };
        let grey = load(&colours, &options).unwrap();
        assert_eq!(values(&grey), [255.0, 182.0]);
        assert!(grey.report.notes.iter().any(|note| note.contains("luminance")), "{:?}", grey.report.notes);
    }

    #[test]
    fn what_is_no_array_is_refused_in_words() {
        let options = ImportOptions::default();
        for (bytes, words) in [
            (array("<c8", "False", "(1, 1, 1)", &[0; 8]), "no real numbers"),
            (array("<f4", "maybe", "(1,)", &[]), "says no descr"),
            (array("<f4", "False", "(5,)", &[0; 20]), "has 1 axes"),
            (array("<f4", "False", "(5, 5, 5)", &[0; 20]), "promises 500"),
            (array("<f4", "False", "(0, 5, 5)", &[]), "no voxel"),
            (array("<f4", "False", "(99999999999, 99999999999, 99999999999)", &[0; 20]), "impossible"),
            (MAGIC.to_vec(), "ends before"),
        ] {
            let error = load(&bytes, &options).unwrap_err().to_string();
            assert!(error.contains(words), "{words}: {error}");
        }
        let options = ImportOptions { layout: Some("tzyx".parse().unwrap()), ..ImportOptions::default() };
        let error = load(&array("|u1", "False", "(1, 1, 1)", &[0]), &options).unwrap_err().to_string();
        assert!(error.contains("where the layout tzyx names 4"), "{error}");
    }
}
