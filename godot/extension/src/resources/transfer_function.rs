//! A transfer function as a Godot resource.

use godot::classes::{IResource, Resource};
use godot::init::is_main_thread;
use godot::prelude::*;
use lumivox_core::{ColorStop, Ease, OpacityKnot, Preset, TransferFunction};

use super::{OptionalVolume, takes};
use crate::convert;

/// Narrowest and widest [member LumivoxTransferFunction.window_scale].
const WINDOW_SCALES: [f64; 2] = [0.01, 100.0];

/// Opacity and colour of a scan's physical values (Hounsfield units for CT), so that it means the same on every scan.
///
/// Opacity knots and colours are apart: one shapes what is seen, the other how it is painted. Before the first and
/// after the last point the end's value holds; at two points of the same value the curve jumps. Without knots nothing
/// is seen, without colours it is white; points that are not finite are passed over. Every change emits
/// [signal Resource.changed], and what is on screen follows. Other threads may change it: then the signal is emitted on
/// the main thread, at the end of its frame.
#[derive(GodotClass)]
#[class(tool, init, base = Resource)]
pub struct LumivoxTransferFunction {
    /// Points of the opacity curve: x is the value in the scan's unit (HU for CT), y the opacity from 0 to 1. Kept
    /// sorted by value.
    #[export]
    #[var(get, set)]
    opacity_knots: PackedVector2Array,
    /// How the curve leaves each opacity knot towards the next: 0 along a straight line, 1 slowly at both ends. One for
    /// each of [member opacity_knots]; those that are missing are 0.
    #[export]
    #[var(get, set)]
    opacity_eases: PackedByteArray,
    /// The values of [member colors], in the scan's unit (HU for CT). Kept sorted.
    #[export]
    #[var(get, set)]
    color_values: PackedFloat32Array,
    /// Colours at [member color_values]; alpha is not used. Between them light is mixed linearly. Where one list is
    /// longer than the other, its rest is not used.
    #[export]
    #[var(get, set)]
    colors: PackedColorArray,
    /// Moves the whole function along the values, in their unit (HU for CT).
    #[export_group(name = "Window")]
    #[export(range = (-2000.0, 2000.0, 1.0, or_greater, or_less))]
    #[var(get, set)]
    shift: f64,
    /// Widens (above 1) or narrows (below 1) the whole function about its centre: a factor, 0.01 to 100.
    #[export(range = (0.01, 100.0, 0.01, exp))]
    #[var(get, set)]
    #[init(val = 1.0)]
    window_scale: f64,
    /// What the arrays mean; made when it is asked for.
    curve: Option<TransferFunction>,
    base: Base<Resource>,
}

#[godot_api]
impl LumivoxTransferFunction {
    /// Replaces all points at once, with a single [signal Resource.changed]. See [member opacity_knots],
    /// [member opacity_eases], [member color_values] and [member colors] for what they mean.
    #[func]
    pub fn set_points(
        &mut self,
        opacity_knots: PackedVector2Array,
        opacity_eases: PackedByteArray,
        color_values: PackedFloat32Array,
        colors: PackedColorArray,
    ) {
        (self.opacity_knots, self.opacity_eases) = sorted_knots(&opacity_knots, &opacity_eases);
        (self.color_values, self.colors) = sorted_colors(&color_values, &colors);
        self.touch();
    }

    #[func]
    fn get_opacity_knots(&self) -> PackedVector2Array {
        self.opacity_knots.clone()
    }

    #[func]
    fn set_opacity_knots(&mut self, knots: PackedVector2Array) {
        // While a file is loaded the eases may not be there yet: sorting must not invent any.
        if self.opacity_eases.len() == knots.len() {
            (self.opacity_knots, self.opacity_eases) = sorted_knots(&knots, &self.opacity_eases);
        } else {
            self.opacity_knots = sorted_knots(&knots, &PackedByteArray::new()).0;
        }
        self.touch();
    }

    #[func]
    fn get_opacity_eases(&self) -> PackedByteArray {
        self.opacity_eases.clone()
    }

    #[func]
    fn set_opacity_eases(&mut self, eases: PackedByteArray) {
        self.opacity_eases = eases;
        self.touch();
    }

    #[func]
    fn get_color_values(&self) -> PackedFloat32Array {
        self.color_values.clone()
    }

    #[func]
    fn set_color_values(&mut self, values: PackedFloat32Array) {
        if self.colors.len() == values.len() {
            (self.color_values, self.colors) = sorted_colors(&values, &self.colors);
        } else {
            self.color_values = values;
        }
        self.touch();
    }

    #[func]
    fn get_colors(&self) -> PackedColorArray {
        self.colors.clone()
    }

    #[func]
    fn set_colors(&mut self, colors: PackedColorArray) {
        if self.color_values.len() == colors.len() {
            (self.color_values, self.colors) = sorted_colors(&self.color_values, &colors);
        } else {
            self.colors = colors;
        }
        self.touch();
    }

    #[func]
    fn get_shift(&self) -> f64 {
        self.shift
    }

    #[func]
    fn set_shift(&mut self, shift: f64) {
        if takes("LumivoxTransferFunction.shift", shift.is_finite()) {
            self.shift = shift;
            self.touch();
        }
    }

    #[func]
    fn get_window_scale(&self) -> f64 {
        self.window_scale
    }

    #[func]
    fn set_window_scale(&mut self, scale: f64) {
        if takes("LumivoxTransferFunction.window_scale", scale.is_finite()) {
            let [narrowest, widest] = WINDOW_SCALES;
            self.window_scale = scale.clamp(narrowest, widest);
            self.touch();
        }
    }

    /// The opacity, 0 to 1, of a value in the scan's unit (HU for CT), with [member shift] and [member window_scale]
    /// applied.
    #[func]
    pub fn get_opacity(&self, value: f64) -> f64 {
        self.curve().opacity(value)
    }

    /// The colour of a value in the scan's unit (HU for CT), with [member shift] and [member window_scale] applied.
    #[func]
    pub fn get_color(&self, value: f64) -> Color {
        convert::color_from_linear(self.curve().color(value))
    }

    /// The transfer function of a preset (see [method preset_names]). Presets for MR place themselves by the values of
    /// [param volume]; those for CT need none. [code]null[/code] and an error in the output if there is no preset of
    /// that name, and if one for MR is given no volume.
    #[func]
    pub fn preset(
        name: GString,
        #[opt(default = OptionalVolume::none())] volume: OptionalVolume,
    ) -> Option<Gd<Self>> {
        let preset = match Preset::from_name(&name.to_string()) {
            Ok(preset) => preset,
            Err(error) => {
                godot_error!("{error}");
                return None;
            }
        };
        let scan = volume.0.as_ref().and_then(|volume| volume.bind().volume().cloned());
        let medium = scan.map(|scan| preset.medium(&scan)).or_else(|| preset.medium_without_scan());
        let Some(medium) = medium else {
            godot_error!("The preset '{name}' places itself by a scan's values: give it a volume.");
            return None;
        };
        Some(Self::of(&medium.transfer_function))
    }

    /// The names of all presets.
    #[func]
    pub fn preset_names() -> PackedStringArray {
        Preset::names().into_iter().map(GString::from).collect()
    }

    /// Writes it as a Lumivox transfer function file (JSON), which the other Lumivox programs read too, with
    /// [member shift] and [member window_scale] applied. [param path] may begin with [code]res://[/code] or
    /// [code]user://[/code]. Returns an empty string, or what went wrong.
    #[func]
    pub fn save_file(&self, path: GString) -> GString {
        let path = convert::system_path(&path);
        match lumivox_import::save_transfer_function(&path, &self.curve(), "") {
            Ok(()) => GString::new(),
            Err(error) => GString::from(&error.to_string()),
        }
    }

    /// Reads a transfer function of Lumivox's or of UnityVolumeRendering's making. [param path] may begin with
    /// [code]res://[/code] or [code]user://[/code]. Returns [code]null[/code] and says why in the output if it cannot
    /// be read.
    #[func]
    pub fn load_file(path: GString) -> Option<Gd<Self>> {
        // Old files are relative to the values of a CT scan.
        const CT_RANGE: [f64; 2] = [-1024.0, 3071.0];
        match lumivox_import::load_transfer_function(&convert::system_path(&path), CT_RANGE) {
            Ok(curve) => Some(Self::of(&curve)),
            Err(error) => {
                godot_error!("{error}");
                None
            }
        }
    }
}

#[godot_api]
impl IResource for LumivoxTransferFunction {}

impl LumivoxTransferFunction {
    /// A resource of these points.
    pub fn of(curve: &TransferFunction) -> Gd<Self> {
        let mut resource = Self::new_gd();
        {
            let mut this = resource.bind_mut();
            let knots = curve.opacity_knots();
            this.opacity_knots =
                knots.iter().map(|k| Vector2::new(k.value as f32, k.opacity as f32)).collect();
            this.opacity_eases = knots.iter().map(|k| u8::from(k.ease == Ease::InOut)).collect();
            let stops = curve.color_stops();
            this.color_values = stops.iter().map(|s| s.value as f32).collect();
            this.colors = stops.iter().map(|s| convert::color_from_linear(s.color)).collect();
        }
        resource
    }

    /// What the points mean, shifted and scaled. Without knots nothing is seen, without colours it is white.
    pub fn curve(&self) -> TransferFunction {
        self.curve.clone().unwrap_or_else(|| self.build())
    }

    /// Whether there is nothing that gives opacity.
    pub fn is_without_knots(&self) -> bool {
        self.opacity_knots.is_empty()
    }

    fn build(&self) -> TransferFunction {
        let (knots, eases) = (self.opacity_knots.as_slice(), self.opacity_eases.as_slice());
        let knots = knots.iter().enumerate().map(|(i, knot)| OpacityKnot {
            value: f64::from(knot.x),
            opacity: f64::from(knot.y),
            ease: if eases.get(i) == Some(&1) { Ease::InOut } else { Ease::Linear },
        });
        let values = self.color_values.as_slice().iter();
        let stops = values.zip(self.colors.as_slice()).map(|(&value, &color)| ColorStop {
            value: f64::from(value),
            color: convert::linear_from_color(color),
        });
        TransferFunction::windowed(knots, stops, self.shift, self.window_scale)
    }

    fn touch(&mut self) {
        self.curve = Some(self.build());
        let mut base = self.base_mut();
        // Whoever listens shows it, which only the main thread may.
        if is_main_thread() {
            base.emit_changed();
        } else {
            base.call_deferred("emit_changed", &[]);
        }
    }
}

/// Knots by rising value, each with its ease.
fn sorted_knots(
    knots: &PackedVector2Array,
    eases: &PackedByteArray,
) -> (PackedVector2Array, PackedByteArray) {
    let ease = |i: usize| eases.get(i).unwrap_or(0);
    let mut points: Vec<(Vector2, u8)> =
        knots.as_slice().iter().enumerate().map(|(i, knot)| (*knot, ease(i))).collect();
    points.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
    points.into_iter().unzip::<_, _, Vec<_>, Vec<_>>().into_arrays()
}

/// Colours by rising value.
fn sorted_colors(
    values: &PackedFloat32Array,
    colors: &PackedColorArray,
) -> (PackedFloat32Array, PackedColorArray) {
    let mut points: Vec<(f32, Color)> =
        values.as_slice().iter().copied().zip(colors.as_slice().iter().copied()).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.into_iter().unzip::<_, _, Vec<_>, Vec<_>>().into_arrays()
}

/// Two lists as two packed arrays.
trait IntoArrays<A, B> {
    fn into_arrays(self) -> (A, B);
}

impl<T, U, A: From<Vec<T>>, B: From<Vec<U>>> IntoArrays<A, B> for (Vec<T>, Vec<U>) {
    fn into_arrays(self) -> (A, B) {
        (self.0.into(), self.1.into())
    }
}
