//! NRRD scans: `.nrrd` with the samples behind the header, `.nhdr` with the samples in other files.
//!
//! After Gordon Kindlmann's "Definition of NRRD File Format" (<https://teem.sourceforge.net/nrrd/format.html>).

use std::path::Path;

use lumivox_core::{
    Modality,
    glam::{DAffine3, DMat3, DVec3},
};

use crate::{
    error::ImportError,
    lengths,
    payload::{Encoding, Payload},
    sample::SampleType,
    single::{Single, axis_aligned, is_placement, lps_from_ras},
    text_header::{Field, Fields, HeaderLines, UnknownTail, parse_list},
};

/// What every NRRD file begins with, before its version.
pub(crate) const MAGIC: &[u8] = b"NRRD000";

/// What people call it.
pub(crate) const NAME: &str = "NRRD";

/// The newest version that has been published.
const NEWEST: char = '5';

/// A header, and what the lines after it say.
struct Header<'a> {
    fields: Fields<'a>,
    /// Lines after `data file: LIST`.
    list: Vec<String>,
    /// Where the samples begin, if they are in the same file.
    end: u64,
}

/// The axes of the grid that lie in space, and how many grids follow each other.
struct Axes {
    dims: [usize; 3],
    /// Positions of the spatial axes among all, in order; two for an image.
    spatial: Vec<usize>,
    phases: usize,
    /// Whether the axis of phases is the fastest, as in sequences of 3D Slicer.
    interleaved: bool,
    /// Samples of each voxel: more than one are a colour.
    channels: usize,
}

/// Reads the header of a NRRD scan.
///
/// # Errors
/// [`ImportError`] names the field, or the data that are missing.
pub(crate) fn open(path: &Path, allow_outside_data: bool) -> Result<Single, ImportError> {
    let header = read_header(path, allow_outside_data)?;
    let fields = &header.fields;
    let mut notes = Vec::new();
    let axes = axes(fields)?;
    let payload =
        Payload { interleaved: axes.interleaved, channels: axes.channels, ..payload(&header, &mut notes)? };
    let patient_from_voxel = placement(fields, &axes, &mut notes)?;
    Single {
        path: path.to_owned(),
        format: NAME,
        dims: axes.dims,
        phases: axes.phases,
        payload: payload.into(),
        rescale: [1.0, 0.0],
        patient_from_voxel,
        modality: modality(fields),
        notes,
    }
    .checked()
}

/// The fields of a NRRD header.
///
/// # Errors
/// [`ImportError`] names the line.
pub(crate) fn fields(path: &Path, allow_outside_data: bool) -> Result<Fields<'_>, ImportError> {
    Ok(read_header(path, allow_outside_data)?.fields)
}

fn read_header(path: &Path, allow_outside_data: bool) -> Result<Header<'_>, ImportError> {
    let mut lines = HeaderLines::open(path)?;
    let magic = lines.next()?.unwrap_or_default();
    let version = magic.strip_prefix("NRRD000").and_then(|v| v.chars().next());
    match version {
        Some('1'..=NEWEST) => {}
        _ => {
            return Err(ImportError::Unsupported {
                path: path.to_owned(),
                what: format!(
                    "NRRD of an unknown version ('{}')",
                    magic.chars().take(20).collect::<String>()
                ),
                remedy: format!("Save it as NRRD000{NEWEST} or older"),
            });
        }
    }
    let mut fields = Vec::new();
    let mut list = Vec::new();
    let mut in_list = false;
    while let Some(text) = lines.next()? {
        if in_list {
            if !text.trim().is_empty() {
                list.push(text.trim().to_owned());
            }
            continue;
        }
        if text.is_empty() {
            break;
        }
        if text.starts_with('#') {
            continue;
        }
        // `key:=value` holds anything; `field: description` belongs to the format.
        let split = match (text.split_once(":="), text.split_once(": ")) {
            (Some(pair), None) => Some(pair),
            (Some(pair), Some(field)) if pair.0.len() < field.0.len() => Some(pair),
            (_, Some(field)) => Some(field),
            (None, None) => text.strip_suffix(':').map(|name| (name, "")),
        };
        let Some((name, value)) = split else {
            let start: String = text.chars().take(40).collect();
            return Err(ImportError::Field {
                path: path.to_owned(),
                field: format!("line {}", lines.line),
                problem: format!("('{start}') is neither a field nor a comment"),
                remedy: "The header is damaged; copy or export the file again".to_owned(),
            });
        };
        let field = Field { name: name.to_owned(), value: value.trim().to_owned(), line: lines.line };
        let data_file = ["data file", "datafile"].iter().any(|n| field.name.eq_ignore_ascii_case(n));
        in_list = data_file && field.value.split_whitespace().next() == Some("LIST");
        fields.push(field);
    }
    Ok(Header { fields: Fields { path, fields, allow_outside_data }, list, end: lines.offset })
}

/// Sorts the axes into those in space and one of phases.
fn axes(fields: &Fields) -> Result<Axes, ImportError> {
    let dimension = fields.require(&["dimension"])?;
    let rank: usize = fields.number(dimension, "a number of axes")?;
    if !(1..=16).contains(&rank) {
        return Err(fields.bad(dimension, "a number of axes"));
    }
    let field = fields.require(&["sizes"])?;
    let sizes: Vec<usize> = fields.numbers(field, rank, "sizes, one for each axis")?;
    if sizes.contains(&0) {
        return Err(fields.bad(field, "numbers of voxels"));
    }

    let kinds: Vec<&str> = fields.get(&["kinds"]).map_or(vec![], |f| f.value.split_whitespace().collect());
    let directions: Vec<Option<Vec<f64>>> =
        fields.get(&["space directions"]).map_or(Ok(vec![]), |f| vectors(fields, f))?;
    let spatial: Vec<usize> = (0..rank)
        .filter(|&axis| {
            let kind = kinds.get(axis).is_none_or(|k| ["domain", "space", "???", "none"].contains(k));
            kind && directions.get(axis).is_none_or(Option::is_some)
        })
        .collect();
    // Of more than three, the slowest axes are taken for phases.
    let spatial: Vec<usize> = spatial.into_iter().take(3).collect();
    let other: Vec<usize> = (0..rank).filter(|axis| !spatial.contains(axis)).collect();
    let interleaved = other.iter().any(|axis| sizes[*axis] > 1 && spatial.iter().any(|s| s > axis));
    // A list is one of volumes; vectors, colours and the like are parts of one.
    let is_list = other == [0] && kinds.first().is_some_and(|kind| ["list", "time"].contains(kind));
    let colours = other == [0]
        && kinds.first().is_some_and(|kind| ["RGB-color", "RGBA-color"].contains(kind))
        && [3, 4].contains(&sizes[0]);
    if !spatial.is_empty() && colours {
        let size = |i: usize| spatial.get(i).map_or(1, |axis| sizes[*axis]);
        let dims = [size(0), size(1), size(2)];
        return Ok(Axes { dims, spatial, phases: 1, interleaved: false, channels: sizes[0] });
    }
    if spatial.is_empty() || interleaved && !is_list {
        let what = format!(
            "{} values for each voxel (sizes {}, kinds {})",
            sizes[0],
            field.value,
            if kinds.is_empty() { "not given".to_owned() } else { kinds.join(" ") }
        );
        return Err(ImportError::Unsupported {
            path: fields.path.to_owned(),
            what,
            remedy: "Export one component (not a colour or vector volume) as a scan of its own".to_owned(),
        });
    }
    // Sizes that overflow here are refused by the payload, which sees them all.
    let product = other.iter().try_fold(1usize, |n, axis| n.checked_mul(sizes[*axis]));
    let phases = product.ok_or_else(|| fields.bad(field, "sizes that any file can have"))?;
    let size = |i: usize| spatial.get(i).map_or(1, |axis| sizes[*axis]);
    Ok(Axes { dims: [size(0), size(1), size(2)], spatial, phases, interleaved, channels: 1 })
}

/// The vectors of a field; `none` where an axis is not in space.
fn vectors(fields: &Fields, field: &Field) -> Result<Vec<Option<Vec<f64>>>, ImportError> {
    let mut rest = field.value.trim();
    let mut vectors = Vec::new();
    while !rest.is_empty() {
        if let Some(after) = rest.strip_prefix("none") {
            vectors.push(None);
            rest = after.trim_start();
            continue;
        }
        let vector = rest.strip_prefix('(').and_then(|r| r.split_once(')'));
        let Some((vector, after)) = vector else { return Err(fields.bad(field, "vectors as (1,0,0)")) };
        let numbers: Vec<f64> =
            parse_list(vector).ok_or_else(|| fields.bad(field, "vectors of numbers as (1,0,0)"))?;
        // An axis outside of space may also be written as a vector of NaN.
        vectors.push(if numbers.iter().all(|n| n.is_nan()) { None } else { Some(numbers) });
        rest = after.trim_start();
    }
    Ok(vectors)
}

/// LPS millimetres from voxel indices.
fn placement(fields: &Fields, axes: &Axes, notes: &mut Vec<String>) -> Result<DAffine3, ImportError> {
    let Some(directions) = fields.get(&["space directions"]) else {
        notes.push("no orientation is given: axes are taken for left, posterior, superior".to_owned());
        return Ok(axis_aligned(spacings(fields, axes, notes)?, [0.0; 3]));
    };
    let vectors = vectors(fields, directions)?;
    let expected = "one vector of 3 numbers for each axis in space";
    let mut columns = Vec::new();
    for axis in &axes.spatial {
        match vectors.get(*axis) {
            Some(Some(v)) if v.len() >= 3 => columns.push(DVec3::new(v[0], v[1], v[2])),
            Some(Some(v)) if v.len() == 2 => columns.push(DVec3::new(v[0], v[1], 0.0)),
            _ => return Err(fields.bad(directions, expected)),
        }
    }
    // An image has no third direction: it is one voxel thick across its plane.
    while columns.len() < 3 {
        let across = match columns[..] {
            [] => DVec3::X,
            [x] => x.any_orthonormal_vector(),
            _ => columns[0].cross(columns[1]).normalize_or(DVec3::Z),
        };
        columns.push(across);
    }
    let origin = match fields.get(&["space origin"]) {
        None => DVec3::ZERO,
        Some(field) => match parse_list::<f64>(&field.value).as_deref() {
            Some([x, y]) => DVec3::new(*x, *y, 0.0),
            Some([x, y, z, ..]) => DVec3::new(*x, *y, *z),
            _ => return Err(fields.bad(field, "a point as (0,0,0)")),
        },
    };
    let space_from_voxel =
        DAffine3::from_mat3_translation(DMat3::from_cols(columns[0], columns[1], columns[2]), origin);
    let patient_from_voxel = match old_segmentation_start(fields, axes)? {
        Some(start) => lps_from_ras() * space_from_voxel * DAffine3::from_translation(start),
        None => patient_from_space(fields, notes)? * space_from_voxel,
    };
    if !is_placement(patient_from_voxel) {
        return Err(fields.bad(directions, "three independent directions with a finite space origin"));
    }
    Ok(patient_from_voxel)
}

/// Where the samples of a segmentation begin that 3D Slicer wrote before 4.7, in voxels: its space, of four axes, is RAS, the
/// origin is that of the scan's first voxel, and the samples are those of an extent. `None` for any other header.
fn old_segmentation_start(fields: &Fields, axes: &Axes) -> Result<Option<DVec3>, ImportError> {
    let is_old = fields.get(&["space"]).is_none()
        && fields.get(&["space dimension"]).is_some_and(|field| field.value.trim() == "4");
    let Some(field) = fields.get(&["Segmentation_Extent", "Segment0_Extent"]).filter(|_| is_old) else {
        return Ok(None);
    };
    let ends: Vec<i64> = fields.numbers(field, 6, "first and last voxels along three axes")?;
    let fits = |axis: usize| {
        let side = ends[2 * axis + 1].checked_sub(ends[2 * axis]).and_then(|side| side.checked_add(1));
        side == i64::try_from(axes.dims[axis]).ok()
    };
    if !(0..3).all(fits) {
        let problem = "is not the extent of the samples, so that their place is not known";
        return Err(fields.complain(field, problem, "Open it in 3D Slicer and save it again"));
    }
    Ok(Some(DVec3::new(ends[0] as f64, ends[2] as f64, ends[4] as f64)))
}

/// LPS millimetres from the header's space.
fn patient_from_space(fields: &Fields, notes: &mut Vec<String>) -> Result<DAffine3, ImportError> {
    let flips = match fields.get(&["space"]) {
        None => {
            notes.push("space is not given: taken for left-posterior-superior".to_owned());
            DAffine3::IDENTITY
        }
        Some(space) => {
            let name = space.value.to_ascii_lowercase();
            match name.strip_suffix("-time").unwrap_or(&name) {
                "left-posterior-superior" | "lps" | "lpst" => DAffine3::IDENTITY,
                "right-anterior-superior" | "ras" | "rast" => lps_from_ras(),
                "left-anterior-superior" | "las" | "last" => DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0)),
                "scanner-xyz" | "3d-right-handed" | "3d-left-handed" => {
                    notes.push(format!("space {name} says nothing of the patient: taken for LPS"));
                    DAffine3::IDENTITY
                }
                _ => return Err(fields.bad(space, "a space such as left-posterior-superior")),
            }
        }
    };
    let mm = match fields.get(&["space units"]) {
        None => DVec3::ONE,
        Some(units) => {
            let lengths = mm_per_unit(fields, units)?;
            DVec3::from_array(
                [0, 1, 2].map(|axis| lengths.get(axis).or(lengths.first()).copied().unwrap_or(1.0)),
            )
        }
    };
    Ok(DAffine3::from_scale(mm) * flips)
}

/// Millimetres in each of the units of a field, which are in quotes; an empty one says nothing.
fn mm_per_unit(fields: &Fields, field: &Field) -> Result<Vec<f64>, ImportError> {
    // What is between the first and the second quote, the third and the fourth, and so on; of a writer without any, words.
    let names: Vec<&str> = if field.value.contains('"') {
        field.value.split('"').skip(1).step_by(2).collect()
    } else {
        field.value.split_whitespace().collect()
    };
    let length = |name: &&str| {
        mm_in(name.trim())
            .ok_or_else(|| fields.bad(field, "lengths such as \"mm\", \"um\", \"m\" or \"inch\""))
    };
    names.iter().map(length).collect()
}

/// Millimetres in a unit of length; 1 where there is none to speak of.
fn mm_in(unit: &str) -> Option<f64> {
    let is_none = matches!(unit.to_lowercase().as_str(), "" | "???" | "none");
    if is_none { Some(1.0) } else { lengths::mm_per_unit(unit) }
}

/// Distances between voxels where there are no directions; an axis with a negative one counts the other way.
fn spacings(fields: &Fields, axes: &Axes, notes: &mut Vec<String>) -> Result<[f64; 3], ImportError> {
    let mut spacing = [1.0; 3];
    let Some(field) = fields.get(&["spacings"]) else { return Ok(spacing) };
    // Without a space, each axis has a unit of its own.
    let units = fields.get(&["units"]).map_or(Ok(Vec::new()), |units| mm_per_unit(fields, units))?;
    let all: Vec<f64> =
        parse_list(&field.value).ok_or_else(|| fields.bad(field, "one length for each axis"))?;
    for (mm, axis) in spacing.iter_mut().zip(&axes.spatial) {
        match all.get(*axis) {
            Some(length) if length.is_normal() => *mm = *length * units.get(*axis).unwrap_or(&1.0),
            // NRRD writes NaN for what is not known.
            Some(length) if length.is_nan() => {
                notes.push(format!("the spacing of axis {} is not given (nan): taken as 1 mm", axis + 1));
            }
            _ => return Err(fields.bad(field, "one length for each axis")),
        }
    }
    Ok(spacing)
}

/// Where the samples are.
fn payload(header: &Header, notes: &mut Vec<String>) -> Result<Payload, ImportError> {
    let fields = &header.fields;
    let unsupported = |what: String, remedy: &str| ImportError::Unsupported {
        path: fields.path.to_owned(),
        what,
        remedy: remedy.to_owned(),
    };
    let sample_field = fields.require(&["type"])?;
    let sample: SampleType = sample_field
        .value
        .parse()
        .map_err(|_| fields.bad(sample_field, "a type of numbers such as 'short' or 'float'"))?;
    let encoding_field = fields.require(&["encoding"])?;
    let encoding = match encoding_field.value.to_ascii_lowercase().as_str() {
        "raw" => Encoding::Raw,
        "gz" | "gzip" => Encoding::Deflate,
        "txt" | "text" | "ascii" => Encoding::Text,
        "hex" => Encoding::Hex,
        other @ ("bz2" | "bzip2" | "zrl" | "zstd") => {
            return Err(unsupported(
                format!("NRRD data encoded as {other}"),
                "Save it with encoding gzip or raw",
            ));
        }
        _ => return Err(fields.bad(encoding_field, "raw, gzip, text or hex")),
    };
    let big_endian = match fields.get(&["endian"]) {
        Some(endian) => match endian.value.to_ascii_lowercase().as_str() {
            "little" => false,
            "big" => true,
            _ => return Err(fields.bad(endian, "'little' or 'big'")),
        },
        None => {
            if sample.bytes() > 1 && encoding != Encoding::Text {
                notes.push("the byte order is not given: taken for little endian".to_owned());
            }
            false
        }
    };
    let line_skip =
        fields.get(&["line skip", "lineskip"]).map_or(Ok(0), |f| fields.number(f, "a number of lines"))?;
    let byte_skip = fields.byte_skip(&["byte skip", "byteskip"], encoding, UnknownTail::IsCounted)?;
    let (files, start) = match fields.get(&["data file", "datafile"]) {
        Some(field) => (fields.data_files(field, &header.list)?, 0),
        None => (vec![fields.path.to_owned()], header.end),
    };
    Ok(Payload {
        files,
        start,
        line_skip,
        byte_skip,
        encoding,
        sample,
        big_endian,
        interleaved: false,
        channels: 1,
    })
}

/// The modality, where a program such as 3D Slicer left it.
fn modality(fields: &Fields) -> Option<Modality> {
    let field = fields.get(&["modality", "DICOM_0008_0060_Modality", "dicom.modality"])?;
    match field.value.to_ascii_uppercase().as_str() {
        "CT" => Some(Modality::Ct),
        "MR" => Some(Modality::Mr),
        "PT" | "PET" => Some(Modality::Pet),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
