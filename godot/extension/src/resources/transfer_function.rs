//! A transfer function as a Godot resource.

use godot::classes::object::ConnectFlags;
use godot::classes::{IResource, Resource};
use godot::init::is_main_thread;
use godot::prelude::*;
use lumivox_core::{ColorStop, Ease, GradientFunction, OpacityKnot, Preset, TransferFunction};

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
///
/// Borders can look otherwise than what lies between them: [member gradient_functions] are for places where values change,
/// and make it a two-dimensional transfer function. Without them it costs less.
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
    /// How steeply values change where each of [member gradient_functions] holds, in their unit per millimetre (HU/mm for
    /// CT), above 0. Between them functions are mixed linearly, with this one at 0; beyond the last, it holds. At most 32;
    /// where one list is longer than the other, its rest is not used.
    #[export_group(name = "Gradients")]
    #[export]
    #[var(get, set)]
    gradients_per_mm: PackedFloat32Array,
    /// The functions of steeper places. Their own windows and gradients are not used: [member shift] and
    /// [member window_scale] of this one move them along.
    #[export]
    #[var(get, set)]
    gradient_functions: Array<Gd<LumivoxTransferFunction>>,
    // What a scene file says, where 32 bits round it: it holds as long as the points are those.
    #[var(rename = _exact, get = _get_exact, set = _set_exact, usage_flags = [STORAGE, INTERNAL])]
    stored_exact: PhantomVar<GString>,
    #[var(rename = _exact_per_mm, get = _get_exact_per_mm, set = _set_exact_per_mm, usage_flags = [STORAGE, INTERNAL])]
    exact_per_mm: PackedFloat64Array,
    exact: Option<TransferFunction>,
    /// What the arrays mean; made when it is asked for.
    curve: Option<TransferFunction>,
    /// What [`Self::gradients_per_mm`] and [`Self::gradient_functions`] mean.
    rows: Option<Vec<GradientFunction>>,
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

    #[func]
    fn get_gradients_per_mm(&self) -> PackedFloat32Array {
        self.gradients_per_mm.clone()
    }

    #[func]
    fn set_gradients_per_mm(&mut self, per_mm: PackedFloat32Array) {
        self.gradients_per_mm = per_mm;
        self.touch();
    }

    #[func]
    fn get_gradient_functions(&self) -> Array<Gd<LumivoxTransferFunction>> {
        self.gradient_functions.clone()
    }

    #[func]
    fn set_gradient_functions(&mut self, functions: Array<Gd<LumivoxTransferFunction>>) {
        let changed = self.base().callable("_row_changed");
        for mut row in self.row_functions().into_iter().filter(|row| row.is_connected("changed", &changed)) {
            row.disconnect("changed", &changed);
        }
        self.gradient_functions = functions;
        for mut row in self.row_functions().into_iter().filter(|row| !row.is_connected("changed", &changed)) {
            // Whoever changes a row holds it.
            row.connect_flags("changed", &changed, ConnectFlags::DEFERRED);
        }
        self.touch();
    }

    #[func]
    fn _get_exact(&self) -> GString {
        let text = self.exact.as_ref().and_then(|exact| serde_json::to_string(exact).ok());
        GString::from(&text.unwrap_or_default())
    }

    #[func]
    fn _set_exact(&mut self, text: GString) {
        self.exact = serde_json::from_str(&text.to_string()).ok();
        self.touch();
    }

    #[func]
    fn _get_exact_per_mm(&self) -> PackedFloat64Array {
        self.exact_per_mm.clone()
    }

    #[func]
    fn _set_exact_per_mm(&mut self, per_mm: PackedFloat64Array) {
        self.exact_per_mm = per_mm;
        self.touch();
    }

    #[func]
    fn _row_changed(&mut self) {
        self.touch();
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
    /// [member shift] and [member window_scale] applied, and with its gradients. [param path] may begin with [code]res://[/code] or
    /// [code]user://[/code]. Returns an empty string, or what went wrong.
    #[func]
    pub fn save_file(&self, path: GString) -> GString {
        let path = convert::system_path(&path);
        match lumivox_import::save_transfer_function_2d(&path, &self.curve(), &self.gradients(), "") {
            Ok(()) => GString::new(),
            Err(error) => GString::from(&error.to_string()),
        }
    }

    /// Reads a transfer function of Lumivox's or of UnityVolumeRendering's making, with its gradients. [param path] may begin with
    /// [code]res://[/code] or [code]user://[/code]. Returns [code]null[/code] and says why in the output if it cannot
    /// be read.
    #[func]
    pub fn load_file(path: GString) -> Option<Gd<Self>> {
        // Old files are relative to the values of a CT scan.
        const CT_RANGE: [f64; 2] = [-1024.0, 3071.0];
        match lumivox_import::load_transfer_function_2d(&convert::system_path(&path), CT_RANGE) {
            Ok((curve, gradients)) => {
                let mut function = Self::of(&curve);
                function.bind_mut().put_gradients(&gradients, Self::of);
                Some(function)
            }
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
            let points = Points::of(curve);
            (this.opacity_knots, this.opacity_eases) = (points.knots, points.eases);
            (this.color_values, this.colors) = (points.values, points.colors);
        }
        resource
    }

    /// A resource that means these functions to the bit, as long as nobody changes its points.
    pub fn exactly(curve: &TransferFunction, gradients: &[GradientFunction]) -> Gd<Self> {
        let mut resource = Self::of(curve);
        {
            let mut this = resource.bind_mut();
            this.exact = Some(curve.clone());
            this.exact_per_mm = gradients.iter().map(|row| row.per_mm).collect();
            this.put_gradients(gradients, |row| Self::exactly(row, &[]));
            this.touch();
        }
        resource
    }

    fn put_gradients(&mut self, gradients: &[GradientFunction], row: impl Fn(&TransferFunction) -> Gd<Self>) {
        if !gradients.is_empty() {
            self.gradients_per_mm = gradients.iter().map(|row| row.per_mm as f32).collect();
            self.set_gradient_functions(gradients.iter().map(|one| row(&one.transfer_function)).collect());
        }
    }

    /// What the points mean, shifted and scaled. Without knots nothing is seen, without colours it is white.
    pub fn curve(&self) -> TransferFunction {
        self.curve.clone().unwrap_or_else(|| self.build())
    }

    /// Functions for steeper places, moved as this one is.
    pub fn gradients(&self) -> Vec<GradientFunction> {
        self.rows.clone().unwrap_or_else(|| self.build_rows())
    }

    /// Whether there is nothing that gives opacity.
    pub fn is_without_knots(&self) -> bool {
        let is_empty = |row: &Gd<Self>| row.bind().opacity_knots.is_empty();
        self.opacity_knots.is_empty() && self.row_functions().iter().all(is_empty)
    }

    /// The functions that can be rows: neither empty places of the list, nor this one.
    fn row_functions(&self) -> Vec<Gd<Self>> {
        let own = self.base().instance_id();
        let all = self.gradient_functions.clone().upcast_any_array();
        let rows = all.iter_shared().filter_map(|row| row.try_to::<Gd<Self>>().ok());
        rows.filter(|row| row.instance_id() != own).collect()
    }

    fn build_rows(&self) -> Vec<GradientFunction> {
        if self.gradient_functions.is_empty() {
            return vec![];
        }
        let own = self.base().instance_id();
        let [scale, offset] = self.moved(0.0, 1.0).window(self.shift, self.window_scale);
        let all = self.gradient_functions.clone().upcast_any_array();
        let rows = all.iter_shared().zip(self.gradients_per_mm.as_slice()).enumerate();
        rows.filter_map(|(i, (row, &per_mm))| {
            let row = row.try_to::<Gd<Self>>().ok().filter(|row| row.instance_id() != own)?;
            let transfer_function = row.bind().moved(0.0, 1.0);
            let transfer_function = transfer_function.remapped(scale, offset);
            let exact = self.exact_per_mm.get(i).filter(|exact| *exact as f32 == per_mm);
            Some(GradientFunction { per_mm: exact.unwrap_or(f64::from(per_mm)), transfer_function })
        })
        .collect()
    }

    fn build(&self) -> TransferFunction {
        self.moved(self.shift, self.window_scale)
    }

    fn moved(&self, shift: f64, window_scale: f64) -> TransferFunction {
        if let Some(exact) = self.exact.as_ref().filter(|exact| self.points() == Points::of(exact)) {
            let [scale, offset] = exact.window(shift, window_scale);
            return exact.remapped(scale, offset);
        }
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
        TransferFunction::windowed(knots, stops, shift, window_scale)
    }

    fn points(&self) -> Points {
        Points {
            knots: self.opacity_knots.clone(),
            eases: self.opacity_eases.clone(),
            values: self.color_values.clone(),
            colors: self.colors.clone(),
        }
    }

    fn touch(&mut self) {
        self.curve = Some(self.build());
        self.rows = Some(self.build_rows());
        let mut base = self.base_mut();
        // Whoever listens shows it, which only the main thread may.
        if is_main_thread() {
            base.emit_changed();
        } else {
            base.call_deferred("emit_changed", &[]);
        }
    }
}

/// The points of a function as the resource has them.
#[derive(PartialEq)]
struct Points {
    knots: PackedVector2Array,
    eases: PackedByteArray,
    values: PackedFloat32Array,
    colors: PackedColorArray,
}

impl Points {
    fn of(curve: &TransferFunction) -> Self {
        let (knots, stops) = (curve.opacity_knots(), curve.color_stops());
        Self {
            knots: knots.iter().map(|k| Vector2::new(k.value as f32, k.opacity as f32)).collect(),
            eases: knots.iter().map(|k| u8::from(k.ease == Ease::InOut)).collect(),
            values: stops.iter().map(|s| s.value as f32).collect(),
            colors: stops.iter().map(|s| convert::color_from_linear(s.color)).collect(),
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
