//! MetaImage scans: `.mha` with the samples behind the header, `.mhd` with the samples in other files.
//!
//! After ITK's MetaIO (<https://itk.org/Wiki/ITK/MetaIO/Documentation>). Positions are LPS millimetres, as ITK has
//! them; `AnatomicalOrientation` only repeats them and is not read.

use std::path::Path;

use lumivox_core::{
    Modality,
    glam::{DAffine3, DMat3, DVec3},
};

use crate::{
    error::ImportError,
    payload::{ByteSkip, Encoding, Payload},
    sample::SampleType,
    single::{Single, is_placement},
    text_header::{Field, Fields, HeaderLines, UnknownTail, parse_list},
};

/// Keys that a MetaImage header begins with.
const FIRST_KEYS: [&str; 12] = [
    "ObjectType",
    "NDims",
    "Comment",
    "ObjectSubType",
    "TransformType",
    "Name",
    "ID",
    "ParentID",
    "BinaryData",
    "BinaryDataByteOrderMSB",
    "ElementByteOrderMSB",
    "DimSize",
];

/// Whether a file that begins so is a MetaImage header.
pub(crate) fn is_metaimage(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head);
    let mut keys = text.lines().filter_map(|line| line.split_once('=')).map(|(key, _)| key.trim());
    let first = keys.next();
    first.is_some_and(|key| FIRST_KEYS.contains(&key))
        && (first == Some("ObjectType")
            || first == Some("NDims")
            || keys.any(|k| k == "NDims" || k == "DimSize"))
}

/// A header, and the file names after `ElementDataFile = LIST`.
struct Header<'a> {
    fields: Fields<'a>,
    list: Vec<String>,
    /// Where the samples begin, if they are in the same file.
    end: u64,
}

/// Reads the header of a MetaImage.
///
/// # Errors
/// [`ImportError`] names the field, or the data that are missing.
pub(crate) fn open(path: &Path, allow_outside_data: bool) -> Result<Single, ImportError> {
    let header = read_header(path, allow_outside_data)?;
    let fields = &header.fields;
    let mut notes = Vec::new();
    if let Some(kind) = fields.get(&["ObjectType"]).filter(|f| !f.value.eq_ignore_ascii_case("Image")) {
        return Err(ImportError::Unsupported {
            path: path.to_owned(),
            what: format!("a MetaIO object of type '{}', not an image", kind.value),
            remedy: "Open the image that it belongs to".to_owned(),
        });
    }
    fields.require(&["ElementDataFile"])?;
    let field = fields.require(&["NDims"])?;
    let rank: usize = fields.number(field, "a number of axes")?;
    if !(1..=10).contains(&rank) {
        return Err(fields.bad(field, "a number of axes"));
    }
    let field = fields.require(&["DimSize"])?;
    let mut sizes: Vec<usize> = first_numbers(fields, field, rank, "sizes, one for each axis")?;
    sizes.truncate(rank);
    if sizes.contains(&0) {
        return Err(fields.bad(field, "numbers of voxels"));
    }
    let channels: usize = match fields.get(&["ElementNumberOfChannels"]) {
        Some(field) => fields.number(field, "a number of values for each voxel")?,
        None => 1,
    };
    let payload = Payload { channels, ..payload(&header)? };
    // Of bytes three or four are a colour; of other numbers they may be a direction.
    let are_colours = matches!((channels, payload.sample), (3 | 4, SampleType::U8));
    if channels != 1 && !are_colours {
        let remedy = "Export one component as a scan of its own";
        let what = format!("{channels} values for each voxel (a vector image)");
        return Err(ImportError::Unsupported { path: path.to_owned(), what, remedy: remedy.to_owned() });
    }
    let size = |i: usize| sizes.get(i).copied().unwrap_or(1);
    let dims = [size(0), size(1), size(2)];
    let phases = sizes.iter().skip(3).try_fold(1usize, |n, size| n.checked_mul(*size));
    let phases = phases.ok_or_else(|| fields.bad(field, "sizes that any file can have"))?;
    let patient_from_voxel = placement(fields, rank, &mut notes)?;
    let rescale = rescale(fields)?;
    Single {
        path: path.to_owned(),
        format: "MetaImage",
        dims,
        phases,
        payload: payload.into(),
        rescale,
        patient_from_voxel,
        modality: modality(fields),
        notes,
    }
    .checked()
}

fn read_header(path: &Path, allow_outside_data: bool) -> Result<Header<'_>, ImportError> {
    let mut lines = HeaderLines::open(path)?;
    let mut fields = Fields { path, fields: Vec::new(), allow_outside_data };
    let mut list = Vec::new();
    while let Some(text) = lines.next()? {
        if text.trim().is_empty() {
            continue;
        }
        let Some((name, value)) = text.split_once('=') else {
            let start: String = text.chars().take(40).collect();
            return Err(ImportError::Field {
                path: path.to_owned(),
                field: format!("line {}", lines.line),
                problem: format!("('{start}') is not of the form 'key = value'"),
                remedy: "The header is damaged; copy or export the file again".to_owned(),
            });
        };
        let field = Field { name: name.trim().to_owned(), value: value.trim().to_owned(), line: lines.line };
        // It is the last by definition: the samples or their files' names follow.
        let last = field.name.eq_ignore_ascii_case("ElementDataFile");
        let names_follow = last && field.value.split_whitespace().next() == Some("LIST");
        fields.fields.push(field);
        if last {
            let end = lines.offset;
            while names_follow && let Some(name) = lines.next()? {
                if !name.trim().is_empty() {
                    list.push(name.trim().to_owned());
                }
            }
            return Ok(Header { fields, list, end });
        }
    }
    Ok(Header { fields, list, end: lines.offset })
}

/// The numbers of a field, `count` of which are needed: some writers give those of three axes to an image of two, and ITK
/// reads as many as there are axes.
fn first_numbers<T: std::str::FromStr>(
    fields: &Fields,
    field: &Field,
    count: usize,
    what: &str,
) -> Result<Vec<T>, ImportError> {
    let numbers = parse_list(&field.value).filter(|numbers: &Vec<T>| numbers.len() >= count);
    numbers.ok_or_else(|| fields.bad(field, &format!("{count} {what}")))
}

/// LPS millimetres from voxel indices.
fn placement(fields: &Fields, rank: usize, notes: &mut Vec<String>) -> Result<DAffine3, ImportError> {
    // Everything is cut or filled to three axes.
    let vector = |names: &[&str], default: f64| -> Result<DVec3, ImportError> {
        let Some(field) = fields.get(names) else { return Ok(DVec3::splat(default)) };
        let numbers: Vec<f64> = first_numbers(fields, field, rank, "numbers, one for each axis")?;
        Ok(DVec3::from_array(std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(default))))
    };
    let spacing_names = ["ElementSpacing", "ElementSize"];
    let spacing = vector(&spacing_names, 1.0)?;
    match fields.get(&spacing_names) {
        None => notes.push("ElementSpacing is not given: taken for 1 mm".to_owned()),
        Some(_) if spacing.to_array().iter().all(|mm| mm.is_normal() && *mm > 0.0) => {}
        Some(field) => return Err(fields.bad(field, "positive lengths in mm")),
    }
    let offset = vector(&["Offset", "Position", "Origin"], 0.0)?;
    let mut directions = DMat3::IDENTITY;
    let matrix = fields.get(&["TransformMatrix", "Rotation", "Orientation"]);
    if let Some(field) = matrix {
        let numbers: Vec<f64> = fields.numbers(field, rank * rank, "numbers, a direction for each axis")?;
        // One axis' direction after the other.
        let at = |axis: usize, i: usize| {
            let own = if axis == i { 1.0 } else { 0.0 };
            if axis < rank && i < rank { numbers[axis * rank + i] } else { own }
        };
        let direction = |axis: usize| DVec3::new(at(axis, 0), at(axis, 1), at(axis, 2));
        directions = DMat3::from_cols(direction(0), direction(1), direction(2));
    }
    let patient_from_voxel =
        DAffine3::from_mat3_translation(directions * DMat3::from_diagonal(spacing), offset);
    match matrix.or(fields.get(&["Offset", "Position", "Origin"])) {
        Some(field) if !is_placement(patient_from_voxel) => {
            Err(fields.bad(field, "independent directions with a finite Offset"))
        }
        _ => Ok(patient_from_voxel),
    }
}

/// Slope and intercept, where a header has them.
fn rescale(fields: &Fields) -> Result<[f64; 2], ImportError> {
    let mut rescale = [1.0f64, 0.0];
    if let Some(field) = fields.get(&["ElementToIntensityFunctionSlope"]) {
        rescale[0] = fields.number(field, "a number")?;
        if !rescale[0].is_normal() {
            return Err(fields.bad(field, "a finite number other than 0"));
        }
    }
    if let Some(field) = fields.get(&["ElementToIntensityFunctionOffset"]) {
        rescale[1] = fields.number(field, "a number")?;
        if !rescale[1].is_finite() {
            return Err(fields.bad(field, "a finite number"));
        }
    }
    Ok(rescale)
}

/// Where the samples are.
fn payload(header: &Header) -> Result<Payload, ImportError> {
    let fields = &header.fields;
    let flag = |names: &[&str], default: bool| match fields.get(names) {
        None => Ok(default),
        Some(field) => match field.value.to_ascii_lowercase().as_str() {
            "true" | "t" | "1" => Ok(true),
            "false" | "f" | "0" => Ok(false),
            _ => Err(fields.bad(field, "True or False")),
        },
    };
    let element = fields.require(&["ElementType"])?;
    let sample = sample_type(&element.value)
        .ok_or_else(|| fields.bad(element, "a type of numbers such as MET_SHORT or MET_FLOAT"))?;
    let encoding = match (flag(&["BinaryData"], true)?, flag(&["CompressedData"], false)?) {
        (_, true) => Encoding::Deflate,
        (true, false) => Encoding::Raw,
        (false, false) => Encoding::Text,
    };
    let header_size = fields.byte_skip(&["HeaderSize"], encoding, UnknownTail::IsNothing)?;
    let data_file = fields.require(&["ElementDataFile"])?;
    let (files, start, byte_skip) = match data_file.value.as_str() {
        // Behind the header there is nothing to skip.
        "LOCAL" | "Local" | "local" => (vec![fields.path.to_owned()], header.end, ByteSkip::Bytes(0)),
        _ => (fields.data_files(data_file, &header.list)?, 0, header_size),
    };
    let big_endian = flag(&["BinaryDataByteOrderMSB", "ElementByteOrderMSB"], false)?;
    Ok(Payload {
        files,
        start,
        line_skip: 0,
        byte_skip,
        encoding,
        sample,
        big_endian,
        interleaved: false,
        channels: 1,
    })
}

/// MetaIO's names of types. Its `LONG` has 32 bits on every machine.
fn sample_type(name: &str) -> Option<SampleType> {
    Some(match name.trim() {
        "MET_CHAR" | "MET_ASCII_CHAR" => SampleType::I8,
        "MET_UCHAR" => SampleType::U8,
        "MET_SHORT" => SampleType::I16,
        "MET_USHORT" => SampleType::U16,
        "MET_INT" | "MET_LONG" => SampleType::I32,
        "MET_UINT" | "MET_ULONG" => SampleType::U32,
        "MET_LONG_LONG" => SampleType::I64,
        "MET_ULONG_LONG" => SampleType::U64,
        "MET_FLOAT" => SampleType::F32,
        "MET_DOUBLE" => SampleType::F64,
        _ => return None,
    })
}

fn modality(fields: &Fields) -> Option<Modality> {
    match fields.get(&["Modality"])?.value.trim() {
        "MET_MOD_CT" => Some(Modality::Ct),
        "MET_MOD_MR" => Some(Modality::Mr),
        "MET_MOD_PET" => Some(Modality::Pet),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::{Compression, write::ZlibEncoder};

    use lumivox_core::{CancelToken, Progress};

    use super::*;
    use crate::{Imported, values::Told};

    fn load(path: &Path) -> Result<Imported, ImportError> {
        open(path, false)?.load(None, &Told::default(), Progress::SILENT, &CancelToken::new())
    }

    const GRID: &str = "ObjectType = Image\nNDims = 3\nDimSize = 2 1 2\n";

    fn load_bytes(bytes: &[u8]) -> Result<Imported, ImportError> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        load(file.path())
    }

    fn with(header: &str, data: &[u8]) -> Result<Imported, ImportError> {
        load_bytes(&[format!("{GRID}{header}\nElementDataFile = LOCAL\n").as_bytes(), data].concat())
    }

    fn values(imported: &Imported) -> Vec<f64> {
        let [x, y, z] = imported.volume.dims();
        (0..x * y * z).map(|i| imported.volume.value([i % x, i / x % y, i / (x * y)])).collect()
    }

    #[test]
    fn encodings_and_byte_orders() {
        let data = [1i16, -2, 300, 4];
        let little: Vec<u8> = data.iter().flat_map(|v| v.to_le_bytes()).collect();
        let big: Vec<u8> = data.iter().flat_map(|v| v.to_be_bytes()).collect();
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(&little).unwrap();
        for (header, data) in [
            ("BinaryDataByteOrderMSB = False", &little[..]),
            ("ElementByteOrderMSB = True", &big),
            ("CompressedData = True\nCompressedDataSize = 16", &encoder.finish().unwrap()),
            ("BinaryData = False", b"1 -2 300 4"),
        ] {
            let header = format!("ElementType = MET_SHORT\n{header}");
            assert_eq!(values(&with(&header, data).unwrap()), [1.0, -2.0, 300.0, 4.0], "{header}");
        }
    }

    #[test]
    fn places_are_lps_with_a_direction_for_each_axis() {
        let header = "ElementType = MET_UCHAR\nElementSpacing = 2 3 4\nOffset = 10 20 30\n\
                      TransformMatrix = 0 1 0 -1 0 0 0 0 1\nModality = MET_MOD_CT\n\
                      ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = -1000";
        let volume = with(header, &[1, 2, 3, 4]).unwrap().volume;
        let place = volume.patient_from_voxel();
        assert_eq!(place.translation, DVec3::new(10.0, 20.0, 30.0));
        assert_eq!(place.matrix3.x_axis, DVec3::new(0.0, 2.0, 0.0));
        assert_eq!(place.matrix3.y_axis, DVec3::new(-3.0, 0.0, 0.0));
        assert_eq!(place.matrix3.z_axis, DVec3::new(0.0, 0.0, 4.0));
        assert_eq!(volume.modality(), Modality::Ct);
        assert_eq!(volume.value_range(), [-998.0, -992.0]);
    }

    #[test]
    fn detached_data_with_headers_lists_and_patterns() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scan.mhd");
        for (name, data) in [("a.raw", [0, 1, 2]), ("b.raw", [0, 3, 4])] {
            std::fs::write(folder.path().join(name), data).unwrap();
        }
        std::fs::write(folder.path().join("all.raw"), [9, 1, 2, 3, 4]).unwrap();
        std::fs::write(folder.path().join("s1.raw"), [9, 1, 2]).unwrap();
        std::fs::write(folder.path().join("s2.raw"), [9, 3, 4]).unwrap();
        for (size, data) in [(1, "LIST\na.raw\nb.raw\n"), (-1, "all.raw"), (1, "s%d.raw 1 2 1")] {
            let header =
                format!("{GRID}ElementType = MET_UCHAR\nHeaderSize = {size}\nElementDataFile = {data}");
            std::fs::write(&path, header).unwrap();
            let imported = load(&path).unwrap();
            assert_eq!(values(&imported), [1.0, 2.0, 3.0, 4.0], "{data}");
        }
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        let error = |header: &str| with(header, &[0; 4]).unwrap_err().to_string();
        assert!(error("").contains("ElementType is missing"));
        assert!(error("ElementType = MET_STRING").contains("ElementType (line 4) is 'MET_STRING'"));
        assert!(error("ElementType = MET_UCHAR\nElementSpacing = 1 0 1").contains("positive lengths"));
        assert!(error("ElementType = MET_UCHAR\nElementSpacing = 1 1").contains("ElementSpacing (line 5)"));
        assert!(
            error("ElementType = MET_UCHAR\nElementSpacing = 1 1e-9 1")
                .contains("1 x 0.000000001 x 1 mm, not")
        );
        let vectors = "ElementType = MET_FLOAT\nElementNumberOfChannels = 3";
        assert!(error(vectors).contains("3 values for each voxel"));
        assert!(
            error("ElementType = MET_UCHAR\nTransformMatrix = 1 0 0 1 0 0 0 0 1").contains("independent")
        );
        assert!(error("ElementType = MET_UCHAR\nCompressedData = maybe").contains("True or False"));
        assert!(
            error("ElementType = MET_UCHAR\nElementToIntensityFunctionSlope = 0").contains("other than 0")
        );
        assert!(error("no pair").contains("line 4 ('no pair')"));
        let short = with("ElementType = MET_SHORT", &[0; 7]);
        assert!(matches!(short, Err(ImportError::Truncated { expected: 8, actual: 7, .. })));
        let mesh = load_bytes(b"ObjectType = Mesh\nNDims = 3\n").unwrap_err().to_string();
        assert!(mesh.contains("type 'Mesh', not an image"), "{mesh}");
        assert!(load_bytes(GRID.as_bytes()).unwrap_err().to_string().contains("ElementDataFile is missing"));
    }

    #[test]
    fn no_byte_of_a_header_can_do_harm() {
        let header = format!(
            "{GRID}ElementSpacing = 1 1 1\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\n\
             CompressedData = False\nHeaderSize = 0\nElementType = MET_SHORT\nElementDataFile = LOCAL\n"
        );
        let whole = [header.as_bytes(), &[0; 8]].concat();
        for length in 0..whole.len() {
            assert!(load_bytes(&whole[..length]).is_err(), "cut to {length}");
        }
        for i in 0..whole.len() {
            for value in [b'\n', b'9', b'-', b'=', b' ', 0xff] {
                let mut bytes = whole.clone();
                bytes[i] = value;
                let _ = load_bytes(&bytes);
            }
        }
    }

    #[test]
    fn an_image_of_two_axes_may_have_the_numbers_of_three() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let header = "ObjectType = Image\nNDims = 2\nDimSize = 2 1\nOffset = 5 6 7\nElementSpacing = 1 2 3\n\
                      ElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
        std::fs::write(file.path(), [header.as_bytes(), &[3, 4]].concat()).unwrap();
        let volume = open(file.path(), false)
            .unwrap()
            .load(
                None,
                &crate::values::Told::default(),
                lumivox_core::Progress::SILENT,
                &lumivox_core::CancelToken::new(),
            )
            .unwrap()
            .volume;
        assert_eq!((volume.dims(), volume.spacing_mm()), ([2, 1, 1], DVec3::new(1.0, 2.0, 3.0)));
        assert_eq!(volume.patient_from_voxel().translation, DVec3::new(5.0, 6.0, 7.0));
        std::fs::write(file.path(), header.replace("1 2 3", "1")).unwrap();
        let error = open(file.path(), false).err().unwrap().to_string();
        assert!(error.contains("ElementSpacing (line 5) is '1', not 2 numbers"), "{error}");
    }
}
