//! What scans look like and are lit by: transfer functions, presets, maps of light.

use std::ffi::{CString, c_char};
use std::sync::{Arc, LazyLock};

use lumivox_core::{
    ColorStop, Ease, EnvironmentMap, ExtinctionSpace, Filter, GradientFunction, Medium, OpacityKnot, Preset,
    SurfaceReflection, TransferFunction, medium::MOST_GRADIENTS,
};

use crate::abi::{LumivoxColorStop, LumivoxMedium, LumivoxOpacityKnot};
use crate::border::{
    LumivoxText, Outcome, free, guard, guard_handle, guard_quietly, guard_status, known, known_mut, list,
    needed_text, path,
};
use crate::convert;
use crate::parts::Part;
use crate::volume::LumivoxVolume;

/// Opacity and colour of values, and of values where they change steeply.
pub struct LumivoxTransferFunction {
    pub(crate) function: TransferFunction,
    /// Rows of a function of value and gradient.
    gradients: Vec<GradientFunction>,
    /// Where the window has sent values: `value * scale + shift`.
    window: [f64; 2],
}

impl LumivoxTransferFunction {
    pub(crate) fn new(function: TransferFunction, gradients: Vec<GradientFunction>) -> Self {
        Self { function, gradients, window: [1.0, 0.0] }
    }
}

/// A panorama of light. Handles share it.
pub struct LumivoxMap(pub(crate) Arc<EnvironmentMap>);

/// The medium of an instance: its own numbers, and where they leave it open what suits the scan.
pub(crate) fn medium(
    own: &LumivoxMedium,
    function: Option<&LumivoxTransferFunction>,
    suited: &Medium,
) -> Medium {
    let (transfer_function, gradients) = match function {
        Some(own) => (&own.function, &own.gradients),
        None => (&suited.transfer_function, &suited.gradients),
    };
    Medium {
        transfer_function: transfer_function.clone(),
        gradients: gradients.clone(),
        density_scale: f64::from(own.density),
        albedo: f64::from(own.albedo),
        anisotropy: f64::from(own.anisotropy),
        max_bounces: own.max_bounces.clamp(1, 1000),
        filter: match own.filter {
            0 => Filter::Nearest,
            1 => Filter::Trilinear,
            2 => Filter::Tricubic,
            _ => Filter::Smooth,
        },
        surface: match convert::reflection(&own.surface) {
            own if own.gradient_per_mm > 0.0 => own,
            own => SurfaceReflection { gradient_per_mm: suited.surface.gradient_per_mm, ..own },
        },
        extinction_space: match own.extinction_space {
            1 => ExtinctionSpace::World,
            _ => ExtinctionSpace::Volume,
        },
    }
    .sanitized()
}

/// A transfer function of points in any order; those that are not finite are passed over. Without knots nothing is seen,
/// without stops it is white. The whole is widened by `window_scale` about its centre and moved by `shift`.
///
/// # Safety
/// `knots` and `stops` point to so many.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_transfer_function_new(
    knots: *const LumivoxOpacityKnot,
    knot_count: u32,
    stops: *const LumivoxColorStop,
    stop_count: u32,
    shift: f64,
    window_scale: f64,
) -> *mut LumivoxTransferFunction {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let (knots, stops) = unsafe {
            (list(knots, knot_count as usize, "knots")?, list(stops, stop_count as usize, "stops")?)
        };
        let plain = curve(knots, stops);
        let window = plain.window(shift, window_scale);
        let function = plain.remapped(window[0], window[1]);
        Ok(LumivoxTransferFunction { function, gradients: vec![], window })
    })
}

fn curve(knots: &[LumivoxOpacityKnot], stops: &[LumivoxColorStop]) -> TransferFunction {
    let knots = knots.iter().map(|knot| OpacityKnot {
        value: knot.value,
        opacity: knot.opacity,
        ease: if knot.ease == 1 { Ease::InOut } else { Ease::Linear },
    });
    let stops =
        stops.iter().map(|stop| ColorStop { value: stop.value, color: [stop.red, stop.green, stop.blue] });
    TransferFunction::windowed(knots, stops, 0.0, 1.0)
}

/// Adds what holds where values change by `per_mm` per millimetre, moved and widened as the function itself is: a row of a
/// function of value and gradient. To be called before anything else has the function.
///
/// # Safety
/// `function` is a live handle, `knots` and `stops` point to so many.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_transfer_function_add_gradient(
    function: *mut LumivoxTransferFunction,
    per_mm: f64,
    knots: *const LumivoxOpacityKnot,
    knot_count: u32,
    stops: *const LumivoxColorStop,
    stop_count: u32,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (to, knots, stops) = unsafe {
            (
                known_mut(function, "transfer function")?,
                list(knots, knot_count as usize, "knots")?,
                list(stops, stop_count as usize, "stops")?,
            )
        };
        if !(per_mm > 0.0 && per_mm < 1e12) {
            return Err(format!("a gradient is a number above 0 per millimetre, not {per_mm}"));
        }
        if to.gradients.len() >= MOST_GRADIENTS {
            return Err(format!("a transfer function has at most {MOST_GRADIENTS} rows for gradients"));
        }
        let [scale, shift] = to.window;
        let transfer_function = curve(knots, stops).remapped(scale, shift);
        to.gradients.push(GradientFunction { per_mm, transfer_function });
        Ok(())
    })
}

/// How many rows for gradients it has; 0 for a function of the value alone.
///
/// # Safety
/// `function` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_transfer_function_gradient_count(
    function: *const LumivoxTransferFunction,
) -> u32 {
    // SAFETY: as the caller promises.
    guard(|| Ok(unsafe { known(function, "transfer function") }?.gradients.len() as u32)).unwrap_or(0)
}

/// A row for a gradient, which is written to `per_mm`, as a function of its own.
///
/// # Safety
/// `function` is a live handle, `per_mm` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_transfer_function_gradient(
    function: *const LumivoxTransferFunction,
    index: u32,
    per_mm: *mut f64,
) -> *mut LumivoxTransferFunction {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let (function, per_mm) =
            unsafe { (known(function, "transfer function")?, known_mut(per_mm, "place for the gradient")?) };
        let row = function.gradients.get(index as usize).ok_or_else(|| format!("there is no row {index}"))?;
        *per_mm = row.per_mm;
        Ok(LumivoxTransferFunction::new(row.transfer_function.clone(), vec![]))
    })
}

/// Frees a transfer function.
///
/// # Safety
/// `function` is null, or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_transfer_function_free(function: *mut LumivoxTransferFunction) {
    // SAFETY: as the caller promises.
    unsafe { free(function) };
}

/// `count` samples of it from the value `low` to `high`: linear RGB and opacity of each.
///
/// # Safety
/// `function` is a live handle, `rgba` can hold `4 * count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_transfer_function_sample(
    function: *const LumivoxTransferFunction,
    low: f64,
    high: f64,
    count: u32,
    rgba: *mut f32,
) -> i32 {
    guard_status(|| {
        if count == 0 || rgba.is_null() {
            return Err("there is no place for samples".to_owned());
        }
        // SAFETY: as the caller promises.
        let (function, rgba) = unsafe {
            (
                &known(function, "transfer function")?.function,
                std::slice::from_raw_parts_mut(rgba, 4 * count as usize),
            )
        };
        for (i, texel) in rgba.chunks_exact_mut(4).enumerate() {
            let value = low + (high - low) * i as f64 / f64::from(count.max(2) - 1);
            let [r, g, b] = function.color(value);
            texel.copy_from_slice(&[r, g, b, function.opacity(value)].map(|x| x as f32));
        }
        Ok(())
    })
}

/// A transfer function of Lumivox' or of UnityVolumeRendering's making.
///
/// # Safety
/// `file` is a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_transfer_function_load(file: *const c_char) -> *mut LumivoxTransferFunction {
    /// Old files are relative to the values of a CT scan.
    const CT_RANGE: [f64; 2] = [-1024.0, 3071.0];
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let file = unsafe { path(file, "file") }?;
        let loaded = lumivox_import::load_transfer_function_2d(&file, CT_RANGE);
        let (function, gradients) = loaded.map_err(|error| error.to_string())?;
        Ok(LumivoxTransferFunction::new(function, gradients))
    })
}

/// Writes it as Lumivox' JSON, with its rows for gradients.
///
/// # Safety
/// `function` is a live handle, `file` a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_transfer_function_save(
    function: *const LumivoxTransferFunction,
    file: *const c_char,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (of, file) = unsafe { (known(function, "transfer function")?, path(file, "file")?) };
        let saved = lumivox_import::save_transfer_function_2d(&file, &of.function, &of.gradients, "");
        saved.map_err(|error| error.to_string())
    })
}

/// Its opacity knots by rising value, as many as there is room for; returns how many there are.
///
/// # Safety
/// `function` is a live handle, `out` can hold `capacity`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_transfer_function_knots(
    function: *const LumivoxTransferFunction,
    out: *mut LumivoxOpacityKnot,
    capacity: u32,
) -> u32 {
    let copied = guard(|| {
        // SAFETY: as the caller promises.
        let knots = unsafe { known(function, "transfer function") }?.function.opacity_knots();
        let knots = knots.iter().map(|knot| LumivoxOpacityKnot {
            value: knot.value,
            opacity: knot.opacity,
            ease: u32::from(knot.ease == Ease::InOut),
            padding: 0,
        });
        // SAFETY: as the caller promises.
        Ok(unsafe { copy(knots, out, capacity) })
    });
    copied.unwrap_or(0)
}

/// Its colour stops by rising value, as many as there is room for; returns how many there are.
///
/// # Safety
/// `function` is a live handle, `out` can hold `capacity`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_transfer_function_stops(
    function: *const LumivoxTransferFunction,
    out: *mut LumivoxColorStop,
    capacity: u32,
) -> u32 {
    let copied = guard(|| {
        // SAFETY: as the caller promises.
        let stops = unsafe { known(function, "transfer function") }?.function.color_stops();
        let stops = stops.iter().map(|stop| {
            let [red, green, blue] = stop.color;
            LumivoxColorStop { value: stop.value, red, green, blue }
        });
        // SAFETY: as the caller promises.
        Ok(unsafe { copy(stops, out, capacity) })
    });
    copied.unwrap_or(0)
}

/// # Safety
/// `out` can hold `capacity`.
unsafe fn copy<T>(items: impl ExactSizeIterator<Item = T>, out: *mut T, capacity: u32) -> u32 {
    let count = items.len() as u32;
    if !out.is_null() {
        for (i, item) in items.take(capacity as usize).enumerate() {
            // SAFETY: i is less than the capacity.
            unsafe { out.add(i).write(item) };
        }
    }
    count
}

/// Names and descriptions as C has them.
fn preset_texts() -> &'static [[CString; 2]] {
    static TEXTS: LazyLock<Vec<[CString; 2]>> = LazyLock::new(|| {
        let text = |text: &str| CString::new(text).unwrap_or_default();
        Preset::ALL.iter().map(|preset| [text(preset.name()), text(preset.description())]).collect()
    });
    &TEXTS
}

/// How many presets there are.
#[unsafe(no_mangle)]
pub extern "C" fn lumivox_preset_count() -> u32 {
    guard_quietly(0, || Preset::ALL.len() as u32)
}

/// The name of a preset; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn lumivox_preset_name(index: u32) -> *const c_char {
    guard_quietly(std::ptr::null(), || {
        preset_texts().get(index as usize).map_or(std::ptr::null(), |[name, _]| name.as_ptr())
    })
}

/// What a preset shows; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn lumivox_preset_description(index: u32) -> *const c_char {
    guard_quietly(std::ptr::null(), || {
        preset_texts().get(index as usize).map_or(std::ptr::null(), |[_, text]| text.as_ptr())
    })
}

/// The name of the preset that suits a scan.
///
/// # Safety
/// `volume` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_preset_for(volume: *const LumivoxVolume) -> *const c_char {
    let name = guard(|| {
        // SAFETY: as the caller promises.
        let preset = Preset::default_for(unsafe { known(volume, "scan") }?.volume());
        let place = Preset::ALL.iter().position(|known| *known == preset);
        Ok(place.map_or(std::ptr::null(), |place| lumivox_preset_name(place as u32)))
    });
    name.unwrap_or(std::ptr::null())
}

/// The part of a scan that a preset is for, see `lumivox_part_find`; 0: all that is seen without it.
///
/// # Safety
/// `name` is a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_preset_part(name: *const c_char) -> u32 {
    let part = guard(|| {
        // SAFETY: as the caller promises.
        let preset = preset(unsafe { needed_text(name, "name of a preset") }?)?;
        Ok(preset.organ().map_or(0, |organ| Part::Organ(organ).number()))
    });
    part.unwrap_or(0)
}

/// The look of a preset. `volume` may be null for those of CT; others place themselves by its values. What a preset says
/// nothing of (filter, extinction space) is left as it is in `medium`.
///
/// # Safety
/// `name` is a string, `volume` null or a live handle, `out` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_preset(
    name: *const c_char,
    volume: *const LumivoxVolume,
    out: *mut LumivoxMedium,
) -> *mut LumivoxTransferFunction {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let (name, volume, out) = unsafe {
            (needed_text(name, "name of a preset")?, volume.as_ref(), known_mut(out, "place for the medium")?)
        };
        let look = look(preset(name)?, volume)?;
        *out = LumivoxMedium {
            density: look.density_scale as f32,
            albedo: look.albedo as f32,
            anisotropy: look.anisotropy as f32,
            max_bounces: look.max_bounces,
            surface: convert::surface(look.surface),
            ..*out
        };
        Ok(LumivoxTransferFunction::new(look.transfer_function, look.gradients))
    })
}

/// The preset of a name.
pub(crate) fn preset(name: &str) -> Outcome<Preset> {
    Preset::from_name(name).map_err(|error| error.to_string())
}

fn look(preset: Preset, volume: Option<&LumivoxVolume>) -> Outcome<Medium> {
    match volume {
        Some(volume) => Ok(preset.medium(volume.volume())),
        None => preset.medium_without_scan().ok_or_else(|| {
            let name = preset.name();
            format!("The preset '{name}' places itself by a scan's values: give it a volume.")
        }),
    }
}

/// A panorama of `width * height` linear RGB texels, rows from the top (straight up); the middle column is Unity's +z. They
/// are copied.
///
/// # Safety
/// `rgb` points to `3 * width * height` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_map_new(width: u32, height: u32, rgb: *const f32) -> *mut LumivoxMap {
    guard_handle(|| {
        let texels = width as usize * height as usize;
        // SAFETY: as the caller promises.
        let rgb = unsafe { list(rgb, 3 * texels, "texels") }?;
        let texels = rgb.as_chunks().0.to_vec();
        Ok(LumivoxMap(Arc::new(EnvironmentMap::new(width as usize, height as usize, texels)?)))
    })
}

/// A panorama from a Radiance (`.hdr`) file.
///
/// # Safety
/// `file` is a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_map_load(file: *const c_char) -> *mut LumivoxMap {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let file = unsafe { path(file, "file") }?;
        let map = lumivox_import::load_environment(&file).map_err(|error| error.to_string())?;
        Ok(LumivoxMap(Arc::new(map)))
    })
}

/// Says which file a map was read from, which scene documents name; otherwise they come with a copy of it.
///
/// # Safety
/// `map` is a live handle that nothing shows yet, `file` a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_map_set_file(map: *mut LumivoxMap, file: *const c_char) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (map, file) = unsafe { (known_mut(map, "map")?, path(file, "file")?) };
        map.0 = Arc::new((*map.0).clone().with_file(&file));
        Ok(())
    })
}

/// The file that a map was read from; empty where that is not known.
///
/// # Safety
/// `map` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_map_file(map: *const LumivoxMap) -> *mut LumivoxText {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let file = unsafe { known(map, "map") }?.0.file();
        Ok(LumivoxText::new(file.and_then(|file| file.to_str()).unwrap_or("")))
    })
}

/// The texels of a map, as `lumivox_map_new` takes them, valid until it is freed; writes its width and height.
///
/// # Safety
/// `map` is a live handle, `size` can hold two numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_map_texels(map: *const LumivoxMap, size: *mut u32) -> *const f32 {
    let texels = guard(|| {
        // SAFETY: as the caller promises.
        let (map, size) =
            unsafe { (&known(map, "map")?.0, known_mut(size.cast::<[u32; 2]>(), "place for the size")?) };
        *size = [map.width as u32, map.height as u32];
        Ok(map.texels.as_ptr().cast::<f32>())
    });
    texels.unwrap_or(std::ptr::null())
}

/// Frees a map.
///
/// # Safety
/// `map` is null, or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_map_free(map: *mut LumivoxMap) {
    // SAFETY: as the caller promises.
    unsafe { free(map) };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_come_with_a_look() {
        let mut medium = LumivoxMedium {
            density: 0.0,
            albedo: 0.0,
            anisotropy: 0.0,
            max_bounces: 0,
            filter: 3,
            extinction_space: 1,
            surface: convert::surface(SurfaceReflection::OFF),
        };
        let null = std::ptr::null();
        // SAFETY: strings and a struct are there.
        let function = unsafe { lumivox_preset(c"ct-bone".as_ptr(), null, &mut medium) };
        assert!(!function.is_null());
        assert!(medium.density > 0.0 && medium.surface.strength == 1.0);
        assert_eq!((medium.filter, medium.extinction_space), (3, 1));
        // SAFETY: it is a handle, and there is room for none.
        let count = unsafe { lumivox_transfer_function_knots(function, std::ptr::null_mut(), 0) };
        assert!(count > 1);
        // SAFETY: it is a handle.
        unsafe { lumivox_transfer_function_free(function) };
        // SAFETY: as above.
        assert!(unsafe { lumivox_preset(c"mr-head".as_ptr(), null, &mut medium) }.is_null());
        assert_eq!(lumivox_preset_count() as usize, Preset::ALL.len());
        assert!(lumivox_preset_name(lumivox_preset_count()).is_null());
    }
}
