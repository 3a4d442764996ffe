//! Images in OME-Zarr, and plain arrays of Zarr: folders with a description in JSON and a file for each chunk.
//!
//! After <https://ngff.openmicroscopy.org> (0.1 to 0.5) and the Zarr specifications 2 and 3. Of a pyramid the finest level is
//! taken that memory holds; channels are volumes of their own, moments phases. What is not read: sharded arrays, filters,
//! and chunks in Fortran's order.

mod array;
mod blosc;
mod chunks;
mod streams;

use std::path::{Path, PathBuf};

use lumivox_core::{
    CancelToken,
    glam::{DAffine3, DVec3},
};
use serde_json::Value;

use crate::{
    ImportOptions,
    error::ImportError,
    layout::ArrayLayout,
    lengths::mm_per_unit,
    placement::{Spacing, placement},
    sample::SampleType,
    samples::Samples,
    single::Single,
};
use array::{Array, Volume};

/// What people call it.
pub(crate) const NAME: &str = "OME-Zarr";
/// No description is longer.
const LONGEST: u64 = 4 << 20;
/// Voxels of the largest level that is taken: a finer one is there for those who open it by itself.
const MOST_VOXELS: usize = 1 << 30;
/// Channels beyond these are no scan's.
const MOST_CHANNELS: usize = 256;

/// Whether a folder is an image or an array of Zarr.
pub(crate) fn is_zarr(folder: &Path) -> bool {
    ["zarr.json", ".zattrs", ".zgroup", ".zarray"].iter().any(|name| crate::files::is_file(folder.join(name)))
}

/// An axis of an image, and millimetres in its unit.
#[derive(Clone, Debug, PartialEq)]
struct Axis {
    /// `x`, `y`, `z`, `t` or `c`.
    letter: char,
    mm: Option<f64>,
}

/// A level of a pyramid.
struct Level {
    path: PathBuf,
    /// Steps along each axis of the image, and where the first voxel lies, in the axes' units.
    scale: Vec<f64>,
    translation: Vec<f64>,
}

/// The volumes of a folder, one for each channel.
///
/// # Errors
/// [`ImportError`] names the file, and what is wrong with it.
pub(crate) fn open(
    folder: &Path,
    options: &ImportOptions,
    cancel: &CancelToken,
) -> Result<Vec<Single>, ImportError> {
    let mut notes = Vec::new();
    let attributes = attributes(folder)?;
    let Some(image) = attributes.as_ref().and_then(multiscale) else {
        return plain_array(folder, options);
    };
    let (axes, levels) = pyramid(folder, image)?;
    if levels.is_empty() {
        return Err(damaged(folder, "names no level of its pyramid"));
    }
    // From the finest on; where all are too large, the last is tried.
    let mut found = None;
    for (place, level) in levels.iter().enumerate() {
        cancel.check()?;
        let array = Array::open(&level.path)?;
        let fits = voxels(&array, &axes).is_some_and(|voxels| voxels <= MOST_VOXELS);
        if fits || place + 1 == levels.len() {
            found = Some((place, level, array));
            break;
        }
    }
    let Some((place, level, array)) = found else {
        return Err(damaged(folder, "names no level of its pyramid"));
    };
    if array.shape.len() != axes.len() {
        let problem = format!("has an array of {} axes where {} are named", array.shape.len(), axes.len());
        return Err(damaged(folder, &problem));
    }
    if place > 0 {
        notes.push(format!(
            "level {} of {} is taken: finer ones hold more than {} million voxels; open the folder of one to have it",
            place + 1,
            levels.len(),
            MOST_VOXELS >> 20
        ));
    }
    let layout: String = axes.iter().map(|axis| axis.letter).collect();
    let of = |letter: char, values: &[f64]| {
        let at = axes.iter().position(|axis| axis.letter == letter)?;
        Some(values.get(at)? * axes[at].mm?)
    };
    let own = spacing(&axes, level).and_then(|spacing| spacing.mm(options, &mut notes));
    let origin = ['x', 'y', 'z']
        .map(|letter| of(letter, &level.translation).filter(|mm| mm.abs() < 1e6).unwrap_or(0.0));
    volumes(folder, options, array, &layout, own, origin, notes)
}

/// How far apart the voxels of a level lie.
fn spacing(axes: &[Axis], level: &Level) -> Option<Spacing> {
    let of = |letter: char| {
        let at = axes.iter().position(|axis| axis.letter == letter)?;
        Some((*level.scale.get(at)?, axes[at].mm)).filter(|(step, _)| step.is_normal() && *step > 0.0)
    };
    let mm = |letter: char| of(letter).and_then(|(step, mm)| Some(step * mm?)).filter(|mm| mm.is_normal());
    let step = |letter: char| of(letter).map(|(step, _)| step);
    match (mm('x').zip(mm('y')), step('x').zip(step('y'))) {
        (Some((x, y)), _) => Some(Spacing::Mm([x, y, mm('z').unwrap_or(x)])),
        (None, Some((x, y))) => Some(Spacing::OfUnknownUnit([x, y, step('z').unwrap_or(x)])),
        (None, None) => None,
    }
}

/// An array by itself.
fn plain_array(folder: &Path, options: &ImportOptions) -> Result<Vec<Single>, ImportError> {
    let array = Array::open(folder)?;
    // A level of a pyramid has its place in the image around it.
    let around = folder.parent().and_then(|image| {
        let attributes = attributes(image).ok()??;
        let (axes, levels) = pyramid(image, multiscale(&attributes)?).ok()?;
        let level = levels.into_iter().find(|level| level.path == folder)?;
        (axes.len() == array.shape.len()).then_some((axes, level))
    });
    let usual = || match &options.layout {
        Some(layout) => Some(layout.to_string()),
        None => match array.shape.len() {
            5 => Some("tczyx".to_owned()),
            _ => ArrayLayout::usual(&array.shape, false).map(|layout| layout.to_string()),
        },
    };
    let layout = match &around {
        Some((axes, _)) => Some(axes.iter().map(|axis| axis.letter).collect()),
        None => usual(),
    };
    let Some(layout) = layout.filter(|layout: &String| layout.chars().count() == array.shape.len()) else {
        return Err(ImportError::Unsupported {
            path: folder.to_owned(),
            what: format!("an array of {} axes, which do not say what they are", array.shape.len()),
            remedy: "Give a layout with a letter for each of them (the option layout)".to_owned(),
        });
    };
    let mut notes = vec![format!("an array of Zarr, taken as {layout}")];
    let own = around
        .and_then(|(axes, level)| spacing(&axes, &level))
        .and_then(|spacing| spacing.mm(options, &mut notes));
    volumes(folder, options, array, &layout, own, [0.0; 3], notes)
}

/// A volume for each channel of an array whose axes are `layout`.
fn volumes(
    folder: &Path,
    options: &ImportOptions,
    array: Array,
    layout: &str,
    spacing_mm: Option<[f64; 3]>,
    origin_mm: [f64; 3],
    mut notes: Vec<String>,
) -> Result<Vec<Single>, ImportError> {
    let letters: Vec<char> = layout.chars().collect();
    let size = |letter: char| letters.iter().position(|own| *own == letter).map_or(1, |at| array.shape[at]);
    let [columns, rows, depth, moments, channels] = ['x', 'y', 'z', 't', 'c'].map(size);
    let dims = [columns, rows, depth];
    let has_plane =
        letters.ends_with(&['y', 'x']) && letters.iter().filter(|letter| **letter == 'z').count() <= 1;
    if !has_plane {
        return Err(ImportError::Unsupported {
            path: folder.to_owned(),
            what: format!("an image whose axes are {layout}, not y and x at last"),
            remedy: "Save it with the axes t, c, z, y, x".to_owned(),
        });
    }
    if channels > MOST_CHANNELS {
        return Err(damaged(folder, &format!("has {channels} channels")));
    }
    array.check(dims, moments.saturating_mul(channels))?;
    let mut patient_from_voxel = placement(options, &[0, 1, 2], spacing_mm, &mut notes);
    if options.axes.is_none() {
        patient_from_voxel = DAffine3::from_translation(DVec3::from_array(origin_mm)) * patient_from_voxel;
    }
    let (sample, path) = (array.sample, array.description.clone());
    let array = std::sync::Arc::new(array);
    let single = |channel: usize| {
        let volume = Volume::new(array.clone(), &letters, channel, dims);
        let mut notes = notes.clone();
        if channels > 1 {
            notes.push(format!("channel {} of {channels}", channel + 1));
        }
        Single {
            path: folder.to_owned(),
            format: NAME,
            dims,
            phases: moments,
            payload: Samples::Planes {
                planes: Box::new(volume),
                sample,
                channels: 1,
                files: vec![path.clone()],
            },
            rescale: [1.0, 0.0],
            patient_from_voxel,
            modality: None,
            notes,
        }
        .checked()
    };
    (0..channels).map(single).collect()
}

/// Voxels of one channel and moment; `None` for more than numbers hold.
fn voxels(array: &Array, axes: &[Axis]) -> Option<usize> {
    let sides = array.shape.iter().zip(axes).filter(|(_, axis)| "xyz".contains(axis.letter));
    sides.map(|(side, _)| *side).try_fold(1usize, |voxels, side| voxels.checked_mul(side))
}

/// A folder's own description, if it has one.
fn attributes(folder: &Path) -> Result<Option<Value>, ImportError> {
    let three = folder.join("zarr.json");
    if crate::files::is_file(&three) {
        return Ok(Some(read_json(&three)?["attributes"].take()));
    }
    let two = folder.join(".zattrs");
    if crate::files::is_file(&two) { read_json(&two).map(Some) } else { Ok(None) }
}

/// The first image that attributes describe.
fn multiscale(attributes: &Value) -> Option<&Value> {
    let of = |value: &Value| value.get("multiscales")?.as_array()?.first().map(|_| ());
    let place = if of(attributes).is_some() { attributes } else { attributes.get("ome")? };
    place.get("multiscales")?.as_array()?.first()
}

/// Axes and levels of an image.
fn pyramid(folder: &Path, image: &Value) -> Result<(Vec<Axis>, Vec<Level>), ImportError> {
    /// Levels of a pyramid; each is half as large as the one before.
    const MOST_LEVELS: usize = 64;
    let letter = |name: &str| {
        let mut letters = name.chars();
        let letter = letters.next().map(|letter| letter.to_ascii_lowercase());
        letter.filter(|letter| letters.next().is_none() && "xyztc".contains(*letter))
    };
    let axis = |axis: &Value| {
        let (name, unit) = match axis {
            Value::String(name) => (name.as_str(), None),
            other => (other["name"].as_str()?, other["unit"].as_str()),
        };
        // Without a unit it is that of microscopes only by custom: that is not known.
        Some(Axis { letter: letter(name)?, mm: unit.and_then(mm_per_unit) })
    };
    let axes: Option<Vec<Axis>> = match image["axes"].as_array() {
        Some(axes) => axes.iter().map(axis).collect(),
        // Before 0.3 they were always these.
        None => Some("tczyx".chars().map(|letter| Axis { letter, mm: None }).collect()),
    };
    let Some(axes) = axes.filter(|axes| !axes.is_empty() && axes.len() <= 5) else {
        return Err(damaged(folder, "names axes that are none of t, c, z, y and x"));
    };
    let whole = transform(&image["coordinateTransformations"], axes.len());
    let mut levels = Vec::new();
    for level in image["datasets"].as_array().into_iter().flatten().take(MOST_LEVELS) {
        let Some(name) = level["path"].as_str() else { continue };
        // A description comes from strangers; it must not choose which folders of the user's are read.
        if !crate::text_header::is_below(folder, Path::new(name)) {
            return Err(damaged(folder, "names a level that does not lie below it"));
        }
        let (scale, translation) = transform(&level["coordinateTransformations"], axes.len());
        let scale: Vec<f64> = scale.iter().zip(&whole.0).map(|(own, whole)| own * whole).collect();
        let moved =
            translation.iter().zip(&whole.0).zip(&whole.1).map(|((own, scale), whole)| own * scale + whole);
        levels.push(Level { path: folder.join(name), scale, translation: moved.collect() });
    }
    Ok((axes, levels))
}

/// Scale and translation of some transformations.
fn transform(value: &Value, axes: usize) -> (Vec<f64>, Vec<f64>) {
    let numbers = |kind: &str| {
        let found = value.as_array()?.iter().find(|one| one["type"] == kind)?;
        let numbers: Option<Vec<f64>> = found[kind].as_array()?.iter().map(Value::as_f64).collect();
        numbers.filter(|numbers| numbers.len() == axes && numbers.iter().all(|number| number.is_finite()))
    };
    (numbers("scale").unwrap_or(vec![1.0; axes]), numbers("translation").unwrap_or(vec![0.0; axes]))
}

fn read_json(path: &Path) -> Result<Value, ImportError> {
    use std::io::Read;
    let file = crate::files::File::open(path).map_err(ImportError::io(path))?;
    let mut text = Vec::new();
    file.take(LONGEST + 1).read_to_end(&mut text).map_err(ImportError::io(path))?;
    if text.len() as u64 > LONGEST {
        return Err(damaged(path, "is too long for a description"));
    }
    serde_json::from_slice(&text)
        .map_err(|fault| damaged(path, &format!("is no JSON (line {})", fault.line())))
}

fn damaged(path: &Path, problem: &str) -> ImportError {
    ImportError::Damaged { path: path.to_owned(), problem: problem.to_owned() }
}

/// The type of samples by the names of Zarr 2 (`<u2`) and 3 (`uint16`), and whether they are big endian, where that says.
fn sample_type(name: &str) -> Option<(SampleType, bool)> {
    let (big_endian, name) = match name.split_at_checked(1)? {
        ("<" | "|", rest) => (false, rest),
        (">", rest) => (true, rest),
        _ => (false, name),
    };
    let sample = match name {
        "b1" | "bool" | "u1" | "uint8" => SampleType::U8,
        "i1" | "int8" => SampleType::I8,
        "u2" | "uint16" => SampleType::U16,
        "i2" | "int16" => SampleType::I16,
        "u4" | "uint32" => SampleType::U32,
        "i4" | "int32" => SampleType::I32,
        "u8" | "uint64" => SampleType::U64,
        "i8" | "int64" => SampleType::I64,
        "f4" | "float32" => SampleType::F32,
        "f8" | "float64" => SampleType::F64,
        _ => return None,
    };
    Some((sample, big_endian))
}

#[cfg(test)]
mod tests;
