//! RAW scans: samples without a header, described by a file beside them, by their name, or by the user.
//!
//! | description | example |
//! |---|---|
//! | a [`RawDescription`], from a flag | `256x256x108:i16le:spacing=1,1,2` |
//! | a file beside it: `head.raw.ini`, `head.ini`, `head.raw.toml`, `head.toml` | see below |
//! | the file's own name | `head_256x256x108_int16_0.5x0.5x2mm_LAS.raw` |
//!
//! A file beside it has one `key: value` or `key = value` per line:
//!
//! ```text
//! dims: 256 256 108        (or dimx, dimy, dimz on three lines, as UnityVolumeRendering has them)
//! format: int16            (type does as well)
//! endianness: LittleEndian
//! skip: 0                  (header_bytes does as well)
//! spacing: 0.957 0.957 1.5
//! axes: LAS                (where x, y and z grow to; LPS if it is not said)
//! slope: 1
//! intercept: -1024
//! modality: CT
//! ```

use std::{
    io::Read,
    path::{Path, PathBuf},
};

use lumivox_core::{CancelToken, Progress};

use crate::{
    Imported,
    axes::PatientAxes,
    error::ImportError,
    files::File,
    payload::Payload,
    raw_description::{RawDescription, parse_dims, parse_sample},
    single::Single,
    text_header::{Field, Fields, parse_list},
    values::Told,
};

/// Loads the samples of `path` as a description says.
///
/// # Errors
/// [`ImportError`] when the file cannot be read, or is not as long as the description makes it.
pub fn load_raw(
    path: &Path,
    description: &RawDescription,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Imported, ImportError> {
    open_described(path, description, "as described")?.load(None, &Told::default(), progress, cancel)
}

/// A RAW scan that the user describes.
///
/// # Errors
/// When the file cannot be read, or is not as long as the description makes it.
pub(crate) fn open_as(path: &Path, description: &RawDescription) -> Result<Single, ImportError> {
    open_described(path, description, "as described")
}

/// A RAW scan that a file beside it or its own name describes.
///
/// # Errors
/// When nothing describes it, when the file cannot be read, or is not as long as the description makes it.
pub(crate) fn open(path: &Path) -> Result<Single, ImportError> {
    let (description, source) = find_description(path)?.ok_or_else(|| ImportError::UnknownFormat {
        path: path.to_owned(),
        found: "nothing beside it and nothing in its name says how many voxels of which type it has"
            .to_owned(),
    })?;
    open_described(path, &description, &source)
}

/// The description of a RAW file and where it was found, if there is one.
pub(crate) fn find_description(path: &Path) -> Result<Option<(RawDescription, String)>, ImportError> {
    if let Some(sidecar) = sidecar(path) {
        let name = sidecar.file_name().unwrap_or_default().to_string_lossy().into_owned();
        return Ok(Some((read_sidecar(&sidecar)?, format!("described by {name}"))));
    }
    Ok(RawDescription::from_file_name(path).map(|d| (d, "described by its name".to_owned())))
}

fn open_described(path: &Path, description: &RawDescription, source: &str) -> Result<Single, ImportError> {
    let RawDescription { dims, sample, big_endian, header_bytes, slope, intercept, .. } = *description;
    let metadata = crate::files::metadata(path).map_err(ImportError::io(path))?;
    // Pipes and devices have no size to compare with.
    if !metadata.is_file() {
        return Err(ImportError::Unsupported {
            path: path.to_owned(),
            what: "it is not a plain file".to_owned(),
            remedy: "Save the samples in a file and open that".to_owned(),
        });
    }
    let actual = metadata.length();
    let expected = description.file_bytes();
    if expected != Some(actual) {
        let makes = expected.map_or("more".to_owned(), |expected| expected.to_string());
        let too_many = expected.and_then(|expected| actual.checked_sub(expected));
        return Err(ImportError::Field {
            path: path.to_owned(),
            field: "the description".to_owned(),
            problem: format!("({description}) makes {makes} bytes, but the file has {actual}"),
            remedy: match too_many {
                Some(too_many) => format!(
                    "Correct the size or the type, or give the {} bytes before the samples as the header",
                    header_bytes.saturating_add(too_many)
                ),
                None => "Correct the size, the type or the header".to_owned(),
            },
        });
    }
    let mut notes = vec![format!("{source}: {description}")];
    if description.axes.is_none() {
        notes.push(
            "RAW has no orientation: taken as LPS (x to the left, y to the back, z to the head); if it is shown from \
             behind or upside down, add axes=LAS, axes=LPI or the like to its description"
                .to_owned(),
        );
    }
    Single {
        path: path.to_owned(),
        format: "RAW",
        dims,
        phases: 1,
        payload: Payload::in_file(path, sample, big_endian, header_bytes).into(),
        rescale: [slope, intercept],
        patient_from_voxel: description.axes.unwrap_or(PatientAxes::LPS).placement(description.spacing_mm),
        modality: description.modality,
        notes,
    }
    .checked()
}

/// The file beside `path` that describes it.
fn sidecar(path: &Path) -> Option<PathBuf> {
    let appended = |extension: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(extension);
        PathBuf::from(name)
    };
    [appended(".ini"), appended(".toml"), path.with_extension("ini"), path.with_extension("toml")]
        .into_iter()
        .find(|candidate| crate::files::is_file(candidate) && candidate != path)
}

fn read_sidecar(path: &Path) -> Result<RawDescription, ImportError> {
    /// Longer than any description.
    const LONGEST: u64 = 1 << 16;
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(ImportError::io(path))?;
    file.take(LONGEST + 1).read_to_end(&mut bytes).map_err(ImportError::io(path))?;
    if bytes.len() as u64 > LONGEST {
        return Err(ImportError::Unsupported {
            path: path.to_owned(),
            what: "it is too long to describe the RAW volume beside it".to_owned(),
            remedy: "Rename it, if it is something else".to_owned(),
        });
    }
    let text = String::from_utf8_lossy(&bytes);
    let fields = text
        .lines()
        .enumerate()
        .filter(|(_, text)| !text.trim_start().starts_with(['#', ';', '[']))
        .filter_map(|(i, text)| {
            let (name, value) = text.split_once([':', '='])?;
            let value = value.trim().trim_matches(['"', '\'']).to_owned();
            Some(Field { name: name.trim().to_owned(), value, line: i + 1 })
        })
        .collect();
    let fields = Fields { path, fields, allow_outside_data: false };

    let dims = match fields.get(&["dims"]) {
        Some(field) => {
            let list = field.value.trim_matches(['[', ']']);
            let dims =
                parse_list(list).and_then(|d: Vec<usize>| d.try_into().ok()).or_else(|| parse_dims(list));
            dims.ok_or_else(|| fields.bad(field, "three numbers of voxels"))?
        }
        None => {
            let size = |name: &str| fields.number(fields.require(&[name])?, "a number of voxels");
            [size("dimx")?, size("dimy")?, size("dimz")?]
        }
    };
    let format = fields.require(&["format", "type"])?;
    let (sample, big_endian) = parse_sample(&format.value)
        .ok_or_else(|| fields.bad(format, "a type such as uint8, int16, uint16 or float32"))?;
    let mut description = RawDescription { big_endian, ..RawDescription::new(dims, sample) };
    for field in &fields.fields {
        match field.name.to_ascii_lowercase().as_str() {
            "dims" | "dimx" | "dimy" | "dimz" | "format" | "type" => {}
            "endian" | "endianness" | "big_endian" => {
                description.big_endian = match field.value.to_ascii_lowercase().as_str() {
                    "little" | "littleendian" | "le" | "false" => false,
                    "big" | "bigendian" | "be" | "true" => true,
                    _ => return Err(fields.bad(field, "LittleEndian or BigEndian")),
                };
            }
            key => {
                let known =
                    description.set(key, &field.value).map_err(|expected| fields.bad(field, expected))?;
                if !known {
                    let known = "It may hold dims, format, endianness, skip, spacing, axes, slope, intercept, modality";
                    return Err(fields.complain(field, "means nothing here", known));
                }
            }
        }
    }
    Ok(description)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder_with(sidecar: &str, text: &str, data: &[u8]) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("head.raw");
        std::fs::write(&path, data).unwrap();
        std::fs::write(folder.path().join(sidecar), text).unwrap();
        (folder, path)
    }

    fn load_raw_file(path: &Path) -> Result<Imported, ImportError> {
        open(path)?.load(None, &Told::default(), Progress::SILENT, &CancelToken::new())
    }

    #[test]
    fn files_beside_it_describe_it() {
        let data = [9, 9, 0xff, 0xfe, 0x00, 0x07];
        let unity = "dimx:2\ndimy:1\ndimz:1\nskip:2\nformat:int16\nendianness:BigEndian";
        let own =
            "# ours\ndims = [2, 1, 1]\ntype = \"i16be\"\nheader_bytes = 2\nspacing = [1, 2, 3]\nslope = 2.0";
        for (name, text, low) in
            [("head.raw.ini", unity, -2.0), ("head.ini", unity, -2.0), ("head.raw.toml", own, -4.0)]
        {
            let (_folder, path) = folder_with(name, text, &data);
            let imported = load_raw_file(&path).unwrap();
            assert_eq!(imported.volume.value_range()[0], low, "{name}");
            assert!(imported.report.notes[0].contains(name), "{:?}", imported.report.notes);
        }
    }

    #[test]
    fn axes_place_it_in_the_patient() {
        let text = "dims: 2 1 1\nformat: uint8\nspacing: 1 2 3\naxes: LAS";
        let (_folder, path) = folder_with("head.ini", text, &[1, 2]);
        let Imported { volume, report, .. } = load_raw_file(&path).unwrap();
        assert_eq!(volume.patient_from_voxel().matrix3.y_axis.to_array(), [0.0, -2.0, 0.0]);
        assert!(!report.notes.iter().any(|note| note.contains("orientation")), "{:?}", report.notes);
        let (_folder, path) = folder_with("head.ini", &text.replace("axes: LAS", ""), &[1, 2]);
        let Imported { volume, report, .. } = load_raw_file(&path).unwrap();
        assert_eq!(volume.patient_from_voxel().matrix3.y_axis.to_array(), [0.0, 2.0, 0.0]);
        assert!(report.notes[1].contains("taken as LPS") && report.notes[1].contains("add axes=LAS"));
    }

    #[test]
    fn impossible_spacings_are_refused() {
        let (_folder, path) = folder_with("other.txt", "", &[1, 2]);
        for spacing in ["1e-7,1,1", "1,1,2e6", "1,1e300,1"] {
            let description = RawDescription::parse(&format!("2x1x1:u8:spacing={spacing}")).unwrap();
            let error = load_raw(&path, &description, Progress::SILENT, &CancelToken::new()).unwrap_err();
            assert!(error.to_string().contains("the distance between voxels is"), "{error}");
        }
    }

    #[test]
    fn only_plain_files_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let description = RawDescription::parse("1x1x1:u8").unwrap();
        let error = load_raw(folder.path(), &description, Progress::SILENT, &CancelToken::new()).unwrap_err();
        assert!(error.to_string().contains("it is not a plain file"), "{error}");
    }

    #[test]
    fn mistakes_beside_it_are_named_with_their_line() {
        let good = "dimx:2\ndimy:1\ndimz:1\nformat:uint8\n";
        for (text, message) in [
            (good.replace("dimz:1\n", ""), "dimz is missing"),
            (good.replace("uint8", "int12"), "format (line 4) is 'int12'"),
            (good.replace("dimy:1", "dimy:-1"), "dimy (line 2) is '-1'"),
            (format!("{good}spacing: 1 0 1"), "spacing (line 5) is '1 0 1'"),
            (format!("{good}colour: red"), "colour (line 5) means nothing here"),
            (String::new(), "dimx is missing"),
            (format!("{good}{}", "#\n".repeat(1 << 15)), "it is too long"),
            (format!("{good}axes: LLS"), "axes (line 5) is 'LLS', not three letters such as LPS"),
        ] {
            let (_folder, path) = folder_with("head.raw.ini", &text, &[1, 2]);
            let error = load_raw_file(&path).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        }
    }

    #[test]
    fn the_size_must_fit_the_file() {
        let (_folder, path) = folder_with("other.txt", "", &[1, 2, 3, 4]);
        let with = |text: &str| {
            let description = RawDescription::parse(text).unwrap();
            load_raw(&path, &description, Progress::SILENT, &CancelToken::new())
        };
        assert_eq!(with("2x2x1:u8").unwrap().volume.value_range(), [1.0, 4.0]);
        let error = with("5x1x1:u8").unwrap_err().to_string();
        assert!(error.contains("makes 5 bytes, but the file has 4. Correct the size"), "{error}");
        let error = with("3x1x1:u8").unwrap_err().to_string();
        assert!(error.contains("makes 3 bytes, but the file has 4"), "{error}");
        assert!(error.contains("give the 1 bytes"), "{error}");
        for too_large in ["4294967296x4294967296x4294967296:f64", "2x1x1:u8:header=18446744073709551615"] {
            let error = with(too_large).unwrap_err().to_string();
            assert!(error.contains("makes more bytes, but the file has 4"), "{error}");
        }
        assert!(load_raw_file(&path).unwrap_err().to_string().contains("nothing beside it"));
    }
}
