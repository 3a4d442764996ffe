//! What the parts of a scan are, and how they look: label maps, which are scans of labels, and looks of them.

use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::{CancelToken, Label, LabelStyle, LabelVolume, Labelling, Medium, Progress, Volume};
use serde_json::json;

use crate::abi::{LumivoxLabel, LumivoxLabelStyle};
use crate::border::{
    LumivoxText, Outcome, free, guard, guard_handle, guard_status, known, list, needed_text,
};
use crate::convert;
use crate::volume::{Labels, LumivoxVolume};

/// A label map with the looks of its labels. What shows it goes on without the handle.
pub struct LumivoxLabelling(Labelling);

impl LumivoxLabelling {
    /// For an instance of a medium, which says what a surface leaves open.
    pub(crate) fn of(&self, medium: &Medium) -> Labelling {
        let mut labelling = self.0.clone();
        for surface in labelling.styles.iter_mut().filter_map(|(_, style)| style.surface.as_mut()) {
            if surface.gradient_per_mm == 0.0 {
                surface.gradient_per_mm = medium.surface.gradient_per_mm;
            }
        }
        labelling.without_cut()
    }
}

/// A label map of voxels that are copied: values of labels, 0 where there is none, `dimensions` along x (fastest), y and z;
/// `patient_from_voxel` as in `lumivox_volume_new`.
///
/// # Safety
/// `dimensions` points to 3 numbers, `voxels` to `length` bytes, `patient_from_voxel` to 12 numbers, `labels` to `count` labels
/// and `names` to as many strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_labels_new(
    dimensions: *const u32,
    voxels: *const u8,
    length: u64,
    patient_from_voxel: *const f64,
    labels: *const LumivoxLabel,
    names: *const *const std::ffi::c_char,
    count: u32,
) -> *mut LumivoxVolume {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let (dimensions, voxels, place, labels, names) = unsafe {
            (
                list(dimensions, 3, "dimensions")?,
                list(voxels, length as usize, "voxels")?,
                list(patient_from_voxel, 12, "numbers of patient_from_voxel")?,
                list(labels, count as usize, "labels")?,
                list(names, count as usize, "names")?,
            )
        };
        let column = |i: usize| DVec3::new(place[3 * i], place[3 * i + 1], place[3 * i + 2]);
        let axes = DMat3::from_cols(column(0), column(1), column(2));
        let named = labels.iter().zip(names).map(|(label, name)| {
            Ok(Label {
                value: u8::try_from(label.value)
                    .map_err(|_| format!("a label has a value of 1 to 255, not {}", label.value))?,
                // SAFETY: as the caller promises.
                name: unsafe { needed_text(*name, "name of a label") }?.to_owned(),
                color: convert::color(label.color),
            })
        });
        let labels = LabelVolume::new(
            [0, 1, 2].map(|i| dimensions[i] as usize),
            voxels.to_vec(),
            DAffine3::from_mat3_translation(axes, column(3)),
            named.collect::<Outcome<_>>()?,
        );
        Ok(LumivoxVolume::of_labels(labels.map_err(|error| error.to_string())?, serde_json::Value::Null))
    })
}

/// How many labels a label map has; -1 for a scan that is none.
///
/// # Safety
/// `map` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_labels_count(map: *const LumivoxVolume) -> i32 {
    // SAFETY: as the caller promises.
    let count = guard(|| Ok(unsafe { labels(map) }?.map.own_labels().count() as i32));
    count.unwrap_or(-1)
}

/// The labels of a map by rising value, as many as there is room for.
///
/// # Safety
/// `map` is a live handle, `out` can hold `capacity`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_labels_list(
    map: *const LumivoxVolume,
    out: *mut LumivoxLabel,
    capacity: u32,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let Labels { map, counts } = unsafe { labels(map) }?;
        if out.is_null() && capacity > 0 {
            return Err("there is no place for labels".to_owned());
        }
        for (i, label) in map.own_labels().take(capacity as usize).enumerate() {
            let milliliters = counts[usize::from(label.value)] as f64 * map.voxel_mm3() / 1000.0;
            let color = label.color.map(|c| c as f32);
            // SAFETY: i is less than the capacity.
            unsafe { out.add(i).write(LumivoxLabel { value: u32::from(label.value), color, milliliters }) };
        }
        Ok(())
    })
}

/// What the label at a place of that list is called.
///
/// # Safety
/// `map` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_labels_name(map: *const LumivoxVolume, index: u32) -> *mut LumivoxText {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let label = unsafe { labels(map) }?.map.own_labels().nth(index as usize);
        Ok(LumivoxText::new(&label.ok_or_else(|| format!("there is no label {index}"))?.name))
    })
}

/// The share of a map's labelled voxels that lie in a scan, 0 where they are of another patient or place; -1 where nothing is
/// labelled. Some of the voxels are looked at.
///
/// # Safety
/// `map` and `volume` are live handles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_labels_share_in(
    map: *const LumivoxVolume,
    volume: *const LumivoxVolume,
) -> f64 {
    let share = guard(|| {
        // SAFETY: as the caller promises.
        let (labels, volume) = unsafe { (labels(map)?, known(volume, "scan")?) };
        Ok(labels.map.share_within(volume.volume()).unwrap_or(-1.0))
    });
    share.unwrap_or(-1.0)
}

/// Looks of the labels of a map; of those that are not listed, the default.
///
/// # Safety
/// `map` is a live handle, `styles` points to `count` of them, whose transfer functions are null or live handles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_labelling_new(
    map: *const LumivoxVolume,
    styles: *const LumivoxLabelStyle,
    count: u32,
) -> *mut LumivoxLabelling {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let (labels, styles) = unsafe { (labels(map)?, list(styles, count as usize, "looks of labels")?) };
        let mut labelling = Labelling::new(labels.map.clone());
        for style in styles {
            let Ok(value) = u8::try_from(style.value) else { continue };
            // SAFETY: as the caller promises.
            let style = unsafe { label_style(style) };
            if style != LabelStyle::default() {
                // As they are: 0 for a gradient means something until `LumivoxLabelling::of`.
                labelling.styles.push((value, style));
            }
        }
        Ok(LumivoxLabelling(labelling))
    })
}

/// Frees looks of labels.
///
/// # Safety
/// `labelling` is null, or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_labelling_free(labelling: *mut LumivoxLabelling) {
    // SAFETY: as the caller promises.
    unsafe { free(labelling) };
}

/// Whether a scan's skin was found: 0 nobody has looked, 1 it was, 2 none is there for sure, and nothing is peeled.
///
/// # Safety
/// `volume` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_volume_skin(volume: *const LumivoxVolume) -> u32 {
    // SAFETY: as the caller promises.
    let skin = guard(|| Ok(unsafe { known(volume, "scan") }?.skin().map(Option::is_some)));
    match skin.flatten() {
        None => 0,
        Some(true) => 1,
        Some(false) => 2,
    }
}

/// # Safety
/// `map` is null or a live handle.
unsafe fn labels<'a>(map: *const LumivoxVolume) -> Outcome<&'a Labels> {
    // SAFETY: as the caller promises.
    let map = unsafe { known(map, "label map") }?;
    map.labels().ok_or_else(|| "it is a scan and no label map".to_owned())
}

/// # Safety
/// Its transfer function is null or a live handle.
unsafe fn label_style(style: &LumivoxLabelStyle) -> LabelStyle {
    // SAFETY: as the caller promises.
    let function = unsafe { style.transfer_function.as_ref() };
    LabelStyle {
        visible: style.visible != 0,
        color: (style.painted != 0).then(|| convert::color(style.color)),
        transfer_function: function.map(|own| own.function.clone()),
        density_scale: (style.density >= 0.0).then(|| f64::from(style.density)),
        opacity: f64::from(style.opacity),
        surface: (style.has_surface != 0).then(|| convert::reflection(&style.surface)),
        clipped: style.clipped != 0,
    }
}

/// What is found in a scan by itself, as a label map.
pub(crate) fn found(
    volume: &LumivoxVolume,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Outcome<LumivoxVolume> {
    let found = lumivox_segmentation::segment(volume.volume(), progress, cancel);
    let found = found.map_err(|error| error.to_string())?;
    let text = found.report.to_string();
    let report = json!({ "format": "found in the scan", "notes": text.lines().collect::<Vec<_>>() });
    Ok(LumivoxVolume::of_labels(found.labels, report))
}

/// Depths below the skin, where there is one for sure.
pub(crate) fn skin(
    volume: &LumivoxVolume,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Outcome<Option<Arc<Volume>>> {
    let of = volume.volume();
    let stopped = |error: lumivox_core::Cancelled| error.to_string();
    let found = lumivox_segmentation::segment(of, progress, cancel).map_err(stopped)?;
    if !found.report.is_sure() {
        return Ok(None);
    }
    let depth = lumivox_segmentation::skin_depth(of, &found.labels, progress, cancel).map_err(stopped)?;
    Ok(Some(Arc::new(depth)))
}
