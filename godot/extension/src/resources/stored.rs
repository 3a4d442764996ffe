//! A volume as the dictionary that Godot saves: one value, so that a volume is there entirely or not at all.

use std::path::PathBuf;

use godot::prelude::*;
use lumivox_core::document::Scan;
use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::labels::LabelSource;
use lumivox_core::{Modality, Volume, Voxels};
use lumivox_segmentation::Surroundings;

use crate::kept_paths;

/// Raised when the meaning of an entry changes.
const VERSION: i64 = 1;

/// The dictionary of a volume and what may be kept of the report of its import.
pub fn to_dictionary(volume: &Volume, report: &VarDictionary) -> VarDictionary {
    let place = volume.patient_from_voxel();
    let numbers: PackedFloat64Array =
        place.matrix3.to_cols_array().into_iter().chain(place.translation.to_array()).collect();
    let dims: PackedInt64Array = volume.dims().into_iter().map(|n| n as i64).collect();
    let rescale = PackedFloat64Array::from([volume.slope(), volume.intercept()]);
    vdict! {
        "version" => VERSION,
        "dims" => &dims,
        "sample" => match volume.voxels() {
            Voxels::U8(_) => "u8",
            Voxels::U16(_) => "u16",
            Voxels::F32(_) => "f32",
        },
        "rescale" => &rescale,
        "patient_from_voxel" => &numbers,
        "modality" => match volume.modality() {
            Modality::Ct => "CT",
            Modality::Mr => "MR",
            Modality::Pet => "PET",
            Modality::Other => "",
        },
        "unit" => volume.unit(),
        "report" => &kept(report),
        // As they lie in memory; every platform that Godot runs on is little-endian.
        "voxels" => &PackedByteArray::from(volume.voxels().as_bytes()),
    }
}

/// The volume of a dictionary and what was kept of the report of its import.
pub fn from_dictionary(stored: &VarDictionary) -> Result<(Volume, VarDictionary), String> {
    let version = entry::<i64>(stored, "version")?;
    if version != VERSION {
        return Err(format!("it was saved by another Lumivox (version {version} of the format)"));
    }
    let dims = entry::<PackedInt64Array>(stored, "dims")?;
    let dims: Vec<usize> = dims.as_slice().iter().filter_map(|&n| n.try_into().ok()).collect();
    let dims: [usize; 3] = dims.try_into().map_err(|_| "its dimensions are not three numbers")?;
    let voxels = samples(stored, "voxels")?;
    let rescale = numbers::<2>(stored, "rescale")?;
    let place = numbers::<12>(stored, "patient_from_voxel")?;
    let column = |i: usize| DVec3::new(place[3 * i], place[3 * i + 1], place[3 * i + 2]);
    let place = DAffine3::from_mat3_translation(DMat3::from_cols(column(0), column(1), column(2)), column(3));
    let modality = match entry::<GString>(stored, "modality")?.to_string().as_str() {
        "CT" => Modality::Ct,
        "MR" => Modality::Mr,
        "PET" => Modality::Pet,
        _ => Modality::Other,
    };
    let mut volume =
        Volume::new(dims, voxels, rescale, place, modality).map_err(|error| error.to_string())?;
    // Older files have none.
    if let Some(unit) = stored.get("unit") {
        volume = volume.with_unit(unit.stringify().to_string());
    }
    // Older files have none.
    if let Some(source) = stored.get("source").and_then(|text| scan_of(&text.stringify().to_string())) {
        volume = volume.with_source(source);
    }
    // Older files hold all of it.
    Ok((volume, kept(&entry(stored, "report")?)))
}

/// Adds what files a volume is of to its dictionary. The place of a series stands for its UID, which names the patient's
/// study.
pub fn put_source(stored: &mut VarDictionary, volume: &Volume, report: &VarDictionary) {
    let Some(source) = volume.source() else { return };
    let mut source = source.clone();
    if let Some(place) = place_of_series(report).filter(|_| source.series.is_some()) {
        source.series = Some(place.to_string());
    }
    if let Some(text) = text_of(source) {
        stored.set("source", text.as_str());
    }
}

/// The place from 1 of the series that a report is about, of several.
fn place_of_series(report: &VarDictionary) -> Option<i64> {
    let series = report.get("series")?.try_to::<VarArray>().ok()?;
    let chosen = report.get("chosen")?.try_to::<i64>().ok()?;
    (series.len() > 1).then_some(chosen + 1)
}

/// What a document says of a scan, with paths as they are kept. `None` where a path is no Unicode.
fn text_of(mut source: Scan) -> Option<String> {
    source.files =
        source.files.iter().map(|file| kept_paths::kept_path(file).map(Into::into)).collect::<Option<_>>()?;
    serde_json::to_string(&source).ok()
}

/// The way back. `None` where the files are out of reach.
fn scan_of(text: &str) -> Option<Scan> {
    let mut source: Scan = serde_json::from_str(text).ok()?;
    source.files = found(source.files.iter().filter_map(|file| file.to_str()), source.files.len())?;
    Some(source)
}

/// So many paths, as the operating system knows them.
fn found<'a>(kept: impl Iterator<Item = &'a str>, count: usize) -> Option<Vec<PathBuf>> {
    kept.map(kept_paths::found_path).collect::<Option<Vec<_>>>().filter(|found| found.len() == count)
}

/// Adds where labels come from to their dictionary.
pub fn put_label_source(stored: &mut VarDictionary, source: &LabelSource) {
    let kept =
        |files: &[PathBuf]| files.iter().map(|file| kept_paths::kept_path(file)).collect::<Option<Vec<_>>>();
    let (Some(files), Some(table)) = (kept(&source.files), kept(source.table.as_slice())) else { return };
    let list = |names: &[String]| names.iter().map(GString::from).collect::<PackedStringArray>();
    let numbers: Vec<String> = source.numbers.iter().map(|(number, _)| number.to_string()).collect();
    let values: PackedByteArray = source.numbers.iter().map(|(_, value)| *value).collect();
    stored.set("label_files", &list(&files));
    stored.set("label_table", &list(&table));
    stored.set("label_numbers", &list(&numbers));
    stored.set("label_numbers_values", &values);
}

/// Where the labels of a dictionary come from, if that is known.
pub fn label_source(stored: &VarDictionary) -> Option<LabelSource> {
    let list = |key: &str| -> Option<Vec<String>> {
        let list: PackedStringArray = entry(stored, key).ok()?;
        Some(list.as_slice().iter().map(|text| text.to_string()).collect())
    };
    let paths = |key: &str| {
        let kept = list(key)?;
        found(kept.iter().map(String::as_str), kept.len())
    };
    let values: PackedByteArray = entry(stored, "label_numbers_values").ok()?;
    let numbers =
        list("label_numbers")?.iter().map(|text| text.parse().ok()).collect::<Option<Vec<i128>>>()?;
    Some(LabelSource {
        files: paths("label_files")?,
        table: paths("label_table")?.pop(),
        numbers: numbers.into_iter().zip(values.to_vec()).collect(),
    })
}

/// Adds what was taken out of a volume to its dictionary.
pub fn put_surroundings(stored: &mut VarDictionary, surroundings: &Surroundings) {
    let runs: PackedInt64Array = surroundings.runs().as_flattened().iter().map(|&n| n as i64).collect();
    stored.set("surroundings_runs", &runs);
    stored.set("surroundings", &PackedByteArray::from(surroundings.samples().as_bytes()));
}

/// What was taken out of the volume of a dictionary, if anything was.
pub fn surroundings(stored: &VarDictionary, volume: &Volume) -> Result<Option<Surroundings>, String> {
    // Older files have none.
    if stored.get("surroundings").is_none() {
        return Ok(None);
    }
    let runs = entry::<PackedInt64Array>(stored, "surroundings_runs")?;
    let runs: Vec<usize> = runs.as_slice().iter().filter_map(|&n| n.try_into().ok()).collect();
    let all = Surroundings::from_parts(runs.as_chunks().0.to_vec(), samples(stored, "surroundings")?);
    let all = all.map_err(|error| error.to_string())?;
    if all.fits(volume) {
        Ok(Some(all))
    } else {
        Err("what lies around the patient is of another scan".into())
    }
}

/// Samples of the volume's type.
fn samples(stored: &VarDictionary, key: &str) -> Result<Voxels, String> {
    let bytes = entry::<PackedByteArray>(stored, key)?;
    let bytes = bytes.as_slice();
    match entry::<GString>(stored, "sample")?.to_string().as_str() {
        "u8" => Ok(Voxels::U8(bytes.to_vec())),
        "u16" => Ok(Voxels::U16(bytes.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).collect())),
        "f32" => Ok(Voxels::F32(bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect())),
        other => Err(format!("its samples are of an unknown type '{other}'")),
    }
}

/// What of a report goes with a scan to wherever it is copied: neither what the files on this machine are called, nor
/// what names the patient's study, nor its other series.
fn kept(report: &VarDictionary) -> VarDictionary {
    let mut kept = VarDictionary::new();
    for key in ["format", "notes"] {
        if let Some(value) = report.get(key) {
            kept.set(key, &value);
        }
    }
    if let Some(mut series) = chosen_series(report) {
        series.remove("id");
        kept.set("series", &varray![&series]);
        kept.set("chosen", 0);
    }
    kept
}

/// A copy of the series that a report is about.
fn chosen_series(report: &VarDictionary) -> Option<VarDictionary> {
    let series = report.get("series")?.try_to::<VarArray>().ok()?;
    let chosen = report.get("chosen")?.try_to::<i64>().ok()?;
    let one = series.get(usize::try_from(chosen).ok()?)?.try_to::<VarDictionary>().ok()?;
    Some(one.duplicate_shallow())
}

fn entry<T: FromGodot>(stored: &VarDictionary, key: &str) -> Result<T, String> {
    stored
        .get(key)
        .and_then(|value| value.try_to::<T>().ok())
        .ok_or_else(|| format!("its entry '{key}' is missing or of another type"))
}

fn numbers<const N: usize>(stored: &VarDictionary, key: &str) -> Result<[f64; N], String> {
    let numbers = entry::<PackedFloat64Array>(stored, key)?;
    numbers.as_slice().try_into().map_err(|_| format!("its entry '{key}' does not hold {N} numbers"))
}
