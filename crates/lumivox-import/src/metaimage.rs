//! MetaImage scans: `.mha` with the samples behind the header, `.mhd` with the samples in other files.
//!
//! After ITK's MetaIO (<https://itk.org/Wiki/ITK/MetaIO/Documentation>). Positions are LPS millimetres, as ITK has
//! them; `AnatomicalOrientation` only repeats them and is not read.

use std::path::{Path, PathBuf};

use lumivox_core::{
    CancelToken, Modality, Progress,
    glam::{DAffine3, DMat3, DVec3},
};

use crate::{
    Imported,
    error::ImportError,
    payload::{ByteSkip, Encoding, Payload},
    sample::SampleType,
    scan::{Scan, is_placement},
    text_header::{Field, Fields, HeaderLines, expand_pattern, parse_list},
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
        && (first == Some("ObjectType") || first == Some("NDims") || keys.any(|k| k == "NDims" || k == "DimSize"))
}

/// A header, and the file names after `ElementDataFile = LIST`.
struct Header<'a> {
    fields: Fields<'a>,
    list: Vec<String>,
    /// Where the samples begin, if they are in the same file.
    end: u64,
}

/// Loads a MetaImage; of several phases the first.
pub(crate) fn load(path: &Path, progress: Progress<'_>, cancel: &CancelToken) -> Result<Imported, ImportError> {
    let header = read_header(path)?;
    let fields = &header.fields;
    let mut notes = Vec::new();
    if let Some(kind) = fields.get(&["ObjectType"]).filter(|f| !f.value.eq_ignore_ascii_case("Image")) {
        return Err(ImportError::Unsupported {
            path: path.to_owned(),
            what: format!("a MetaIO object of type '{}', not an image", kind.value),
            remedy: "Open the image that it belongs to".to_owned(),
        });
    }
    let field = fields.require(&["NDims"])?;
    let rank: usize = fields.number(field, "a number of axes")?;
    if !(1..=10).contains(&rank) {
        return Err(fields.bad(field, "a number of axes"));
    }
    let field = fields.require(&["DimSize"])?;
    let sizes: Vec<usize> = fields.numbers(field, rank, "sizes, one for each axis")?;
    if sizes.contains(&0) {
        return Err(fields.bad(field, "numbers of voxels"));
    }
    if let Some(channels) = fields.get(&["ElementNumberOfChannels"]).filter(|f| f.value.trim() != "1") {
        let remedy = "Export one component as a scan of its own";
        let what = format!("{} values for each voxel (a colour or vector image)", channels.value);
        return Err(ImportError::Unsupported { path: path.to_owned(), what, remedy: remedy.to_owned() });
    }
    let size = |i: usize| sizes.get(i).copied().unwrap_or(1);
    let dims = [size(0), size(1), size(2)];
    let phases = sizes.iter().skip(3).try_fold(1usize, |n, size| n.checked_mul(*size));
    let phases = phases.ok_or_else(|| fields.bad(field, "sizes that any file can have"))?;
    if phases > 1 {
        notes.push(format!("the first of {phases} phases is shown"));
    }
    let payload = payload(&header, rank)?;
    let patient_from_voxel = placement(fields, rank, &mut notes)?;
    let rescale = rescale(fields)?;
    let decoded = payload.read(path, dims, phases, progress, cancel)?;
    let detached = payload.files[0] != path;
    Scan {
        path,
        format: "MetaImage",
        dims,
        files: payload.files.len() + usize::from(detached),
        decoded,
        rescale,
        patient_from_voxel,
        modality: modality(fields),
        notes,
    }
    .import()
}

fn read_header(path: &Path) -> Result<Header<'_>, ImportError> {
    let mut lines = HeaderLines::open(path)?;
    let mut fields = Fields { path, fields: Vec::new() };
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
    fields.require(&["ElementDataFile"])?;
    Ok(Header { fields, list, end: lines.offset })
}

/// LPS millimetres from voxel indices.
fn placement(fields: &Fields, rank: usize, notes: &mut Vec<String>) -> Result<DAffine3, ImportError> {
    // Everything is cut or filled to three axes.
    let vector = |names: &[&str], default: f64| -> Result<DVec3, ImportError> {
        let Some(field) = fields.get(names) else { return Ok(DVec3::splat(default)) };
        let numbers: Vec<f64> = fields.numbers(field, rank, "numbers, one for each axis")?;
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
    let number = |name: &str, default: f64| match fields.get(&[name]) {
        Some(field) => fields.number(field, "a number"),
        None => Ok(default),
    };
    Ok([
        number("ElementToIntensityFunctionSlope", 1.0)?,
        number("ElementToIntensityFunctionOffset", 0.0)?,
    ])
}

/// Where the samples are.
fn payload(header: &Header, rank: usize) -> Result<Payload, ImportError> {
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
    let byte_skip = match fields.get(&["HeaderSize"]) {
        None => ByteSkip::Bytes(0),
        Some(field) => match fields.number::<i64>(field, "a number of bytes, or -1")? {
            -1 => ByteSkip::Tail,
            skip => {
                ByteSkip::Bytes(u64::try_from(skip).map_err(|_| fields.bad(field, "a number of bytes, or -1"))?)
            }
        },
    };
    let files = data_files(header, rank)?;
    let start = if files.is_empty() { header.end } else { 0 };
    let files = if files.is_empty() { vec![fields.path.to_owned()] } else { files };
    // Behind the header there is nothing to skip, and a compressed file has no known tail.
    let byte_skip = if start > 0 || (byte_skip == ByteSkip::Tail && encoding != Encoding::Raw) {
        ByteSkip::Bytes(0)
    } else {
        byte_skip
    };
    let big_endian = flag(&["BinaryDataByteOrderMSB", "ElementByteOrderMSB"], false)?;
    Ok(Payload { files, start, line_skip: 0, byte_skip, encoding, sample, big_endian })
}

/// The files that hold the samples; none when they follow the header.
fn data_files(header: &Header, rank: usize) -> Result<Vec<PathBuf>, ImportError> {
    let fields = &header.fields;
    let field = fields.require(&["ElementDataFile"])?;
    let folder = fields.path.parent().unwrap_or(Path::new(""));
    let words: Vec<&str> = field.value.split_whitespace().collect();
    let names = match words[..] {
        [] => return Err(fields.complain(field, "names no file", "Name the file that holds the samples")),
        ["LOCAL" | "Local" | "local"] => return Ok(Vec::new()),
        ["LIST", ..] if header.list.is_empty() => {
            return Err(fields.complain(field, "is followed by no file name", "List one file for each slice"));
        }
        ["LIST", ..] => header.list.clone(),
        [pattern, .., _, _, _] if pattern.contains('%') => {
            let numbers: Option<Vec<i64>> = parse_list(&words[words.len() - 3..].join(" "));
            numbers
                .and_then(|n| expand_pattern(pattern, [n[0], n[1], n[2]]))
                .filter(|names| rank >= 1 && !names.is_empty())
                .ok_or_else(|| fields.bad(field, "a pattern such as 'slice%03d.raw 1 100 1'"))?
        }
        _ => vec![field.value.clone()],
    };
    Ok(names.iter().map(|name| folder.join(name)).collect())
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
