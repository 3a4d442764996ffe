//! The node that shows a scan. `shown.rs`: what of the scan; `warnings.rs` and `hidden_paint.rs`: why it is not what one may
//! expect; `opened.rs`: one of a scene file.

mod hidden_paint;
mod instance;
mod opened;
mod shown;
mod warnings;

use std::cell::{Cell, RefCell};

use godot::classes::notify::Node3DNotification;
use godot::classes::object::ConnectFlags;
use godot::classes::{Engine, IVisualInstance3D, RenderingServer, Resource, VisualInstance3D};
use godot::init::is_main_thread;
use godot::prelude::*;
use godot::register::info::{PropertyHint, PropertyHintInfo, PropertyInfo};
use lumivox_core::medium::MAX_DENSITY_SCALE;
use lumivox_core::{Preset, placement};

use self::hidden_paint::Compared;
use self::shown::ShownPart;
use self::warnings::whole_scan;
use crate::convert;
use crate::resources::{LumivoxLabels, LumivoxTransferFunction, LumivoxVolume, OptionalVolume, takes};
use crate::server;

/// Largest [member LumivoxVolume3D.surface_gradient]: that of a medium.
pub const MAX_GRADIENT: f64 = 1e12;

/// Largest [member LumivoxVolume3D.peel_mm]: what depths are told apart to.
const MOST_PEELED_MM: f64 = 63.0;

/// A scan in a scene, path traced: it scatters the scene's light, hides meshes behind it and is hidden by those before
/// it. Any number may overlap.
///
/// The scan stands upright at its true size, its centre at the node's origin, and faces +z. It needs the Forward+ or
/// the Mobile renderer. How the image converges is set by the [LumivoxEffect] of the scene's [Compositor]; without one,
/// its defaults hold.
///
/// [DirectionalLight3D], [OmniLight3D] and [SpotLight3D] light it with their colour, energy, size, range, attenuation
/// and cull mask, in physical light units too where the project uses them, and so does the sky or the ambient colour of
/// the environment. Volumes cast shadows on volumes whether a light has shadows or not. Projectors and distance fades of
/// lights are not followed, and lights with [member Light3D.light_negative] do not shine on volumes at all.
/// [ReflectionProbe], [VoxelGI], SDFGI and lightmaps do nothing to volumes.
///
/// Numbers beyond the range of their property become the nearest one in it. NaN and infinity are refused with an error,
/// and the property stays as it was.
#[derive(GodotClass)]
#[class(tool, init, base = VisualInstance3D)]
pub struct LumivoxVolume3D {
    /// The scan. Save it as a file of its own ([code].res[/code]): kept in the scene's file it makes that large. One
    /// slice of a folder of DICOM files shows nothing: the folder's first file is the scan.
    #[export]
    #[var(get, set)]
    volume: Option<Gd<LumivoxVolume>>,
    /// Opacity and colour of the scan's values. Empty: those of the preset that suits the scan. What changes in it is
    /// shown in the next frame; nodes may share it.
    #[export]
    #[var(get, set)]
    transfer_function: Option<Gd<LumivoxTransferFunction>>,
    /// A look that suits a kind of scan at once. Choosing one replaces [member transfer_function], [member density],
    /// [member albedo], [member anisotropy], [member max_bounces] and the surface; what is changed afterwards stays
    /// changed. See [method apply_preset]. While it is [code]ct-airways[/code] or [code]ct-lung-vessels[/code], that organ
    /// of the scan is seen alone: it is looked for on another thread, and where it is not found for sure all is seen, and
    /// a warning says so.
    #[export_group(name = "Medium")]
    #[var(get, set, usage_flags = [EDITOR])]
    preset: PhantomVar<GString>,
    // What `preset` was set to last: scenes keep it without taking over the preset again when they are loaded.
    #[var(get = _get_chosen_preset, set = _set_chosen_preset, usage_flags = [STORAGE, INTERNAL])]
    chosen_preset: GString,
    /// Multiplies the extinction, which is 1 per millimetre at an opacity of 1: 0 (nothing is seen) to 1000. Low: glass
    /// and mist; high: solid.
    #[export(range = (0.0, 100.0, 0.001, exp, or_greater))]
    #[var(set)]
    #[init(val = 2.0)]
    density: f64,
    /// Fraction of the light that survives each scattering, 0 to 1.
    #[export(range = (0.0, 1.0, 0.001))]
    #[var(set)]
    #[init(val = 1.0)]
    albedo: f64,
    /// Where light goes when it scatters: 0 in all directions alike, towards 0.99 onwards, towards -0.99 back.
    #[export(range = (-0.99, 0.99, 0.01))]
    #[var(set)]
    anisotropy: f64,
    /// Scatterings after which light is no longer followed, 1 to 1000. 1 is single scattering: fast and dark.
    #[export(range = (1.0, 1000.0, 1.0, exp))]
    #[var(set)]
    #[init(val = 100)]
    max_bounces: i64,
    /// How values between voxels are found: [constant FILTER_NEAREST], [constant FILTER_TRILINEAR],
    /// [constant FILTER_TRICUBIC] or [constant FILTER_SMOOTH].
    #[export(enum = (Nearest, Trilinear, Tricubic, Smooth))]
    #[var(set)]
    #[init(val = Self::FILTER_SMOOTH)]
    filter: i64,
    /// What a millimetre of extinction is measured in: [constant EXTINCTION_VOLUME] or [constant EXTINCTION_WORLD].
    #[export(enum = (Volume, World))]
    #[var(set)]
    extinction_space: i64,
    /// How strongly boundaries inside the scan, such as that of bone, reflect like surfaces: 0 (off) to 1.
    #[export_group(name = "Surface", prefix = "surface_")]
    #[export(range = (0.0, 1.0, 0.001))]
    #[var(set)]
    #[init(val = Self::SURFACE.strength)]
    surface_strength: f64,
    /// How steep a boundary must be, in value units (HU for CT) per millimetre. 0: as suits the scan.
    #[export(range = (0.0, 1000.0, 0.1, or_greater, suffix = "/mm"))]
    #[var(set)]
    surface_gradient: f64,
    /// Width of the highlights: 0 glossy, 1 matt.
    #[export(range = (0.0, 1.0, 0.001))]
    #[var(set)]
    #[init(val = Self::SURFACE.roughness)]
    surface_roughness: f64,
    /// Share of the light, 0 to 1, that the highlights reflect seen head-on. Skin and bone have about 0.04.
    #[export(range = (0.0, 1.0, 0.001))]
    #[var(set)]
    #[init(val = Self::SURFACE.specular)]
    surface_specular: f64,
    /// How much of the scan's own colour the highlights have, 0 to 1: 0 of skin and bone, whose highlights have the light's; 1
    /// of metal, such as implants and fillings, which want a high [member surface_specular], too.
    #[export(range = (0.0, 1.0, 0.001))]
    #[var(set)]
    surface_metallic: f64,
    /// What the scan's parts are, and how each looks. See [LumivoxLabels].
    #[export_group(name = "Parts")]
    #[export]
    #[var(get, set)]
    labels: Option<Gd<LumivoxLabels>>,
    /// Whether what lies around the patient in a CT is seen, too: the table, clothes, cables, where the import has put them
    /// aside (see [method LumivoxVolume.has_surroundings]). They come back within a moment, from another thread.
    /// With it, a preset that shows one organ shows all, and [member peel_mm] takes them off with the skin.
    #[export]
    #[var(set)]
    keep_everything: bool,
    /// Millimetres below the skin that are taken off, up to 63. The skin of a CT or MR is found on another thread, which
    /// takes a few seconds the first time; where none is found for sure, nothing is taken off. May be animated.
    #[export(range = (0.0, 63.0, 0.1, suffix = "mm"))]
    #[var(set)]
    peel_mm: f64,
    /// The corner of what is kept of the scan with the smallest coordinates, as fractions of its box, 0 to 1: x to the
    /// right, y up, z towards the viewer. Where it lies beyond [member clip_max], what is between them is kept.
    #[export_group(name = "Clip", prefix = "clip_")]
    #[export]
    #[var(get, set, hint = RANGE, hint_string = "0,1,0.001")]
    clip_min: Vector3,
    /// The opposite corner of what is kept. Where it is as large as [member clip_min] along an axis, nothing is.
    #[export]
    #[var(get, set, hint = RANGE, hint_string = "0,1,0.001")]
    #[init(val = Vector3::ONE)]
    clip_max: Vector3,
    // Where a scene file places it and what it keeps of it, to more digits than the node's own: world from patient, then the
    // clip box along the scan's axes. Each holds as long as the node is where that is.
    #[var(rename = _exact, get = _get_exact, set = _set_exact, usage_flags = [STORAGE, INTERNAL])]
    exact: PackedFloat64Array,
    /// What is shown in place of the patient.
    part: RefCell<Option<ShownPart>>,
    /// Whether something was still computed when a frame was last drawn.
    is_waiting: Cell<bool>,
    /// What its look is asked about its labels with.
    compared: RefCell<Option<Compared>>,
    /// The labels that were painted when a game was last told of hidden ones.
    painted: RefCell<Vec<u8>>,
    base: Base<VisualInstance3D>,
}

/// Sets a number to the nearest in its range: the inspector's, or where that may be exceeded the renderer's.
macro_rules! put {
    ($this:ident.$name:ident = $value:ident in [$low:expr, $high:expr]) => {
        if takes(concat!("LumivoxVolume3D.", stringify!($name)), ($value as f64).is_finite()) {
            $this.$name = $value.clamp($low, $high);
            $this.changed();
        }
    };
}

#[godot_api]
impl LumivoxVolume3D {
    /// [member filter] that shows the voxels: each value reaches to the middle between two.
    #[constant]
    pub const FILTER_NEAREST: i64 = 0;
    /// [member filter] that goes straight from voxel to voxel, which shows as terraces on smooth surfaces.
    #[constant]
    pub const FILTER_TRILINEAR: i64 = 1;
    /// [member filter] of cubic B-splines: with hardly any terraces, about as sharp as [constant FILTER_SMOOTH], and slow.
    #[constant]
    pub const FILTER_TRICUBIC: i64 = 2;
    /// [member filter] that averages voxels with their neighbours and goes straight from one to the next: as fast as
    /// [constant FILTER_TRILINEAR], with hardly any terraces, and a little softer.
    /// Where one node shows a scan so and another otherwise, the GPU holds it twice.
    #[constant]
    pub const FILTER_SMOOTH: i64 = 3;
    /// [member extinction_space] of the scan's own millimetres: scaling the node never changes its look.
    #[constant]
    pub const EXTINCTION_VOLUME: i64 = 0;
    /// [member extinction_space] of the scene's millimetres: twice as large is twice as opaque.
    #[constant]
    pub const EXTINCTION_WORLD: i64 = 1;

    #[func]
    fn get_volume(&self) -> Option<Gd<LumivoxVolume>> {
        self.volume.clone()
    }

    #[func]
    fn set_volume(&mut self, volume: Option<Gd<LumivoxVolume>>) {
        self.watch(self.volume.clone().map(Gd::upcast), volume.clone().map(Gd::upcast));
        if let Some(whole) = volume.as_ref().and_then(whole_scan)
            && !Engine::singleton().is_editor_hint()
        {
            godot_warn!(
                "LumivoxVolume3D.volume is one slice of a scan, and shows nothing: load {whole} instead."
            );
        }
        let had_scan = self.has_scan();
        self.volume = volume;
        self.tell_misplaced_labels();
        self._contents_changed();
        if !(had_scan && self.has_scan()) {
            // The inspector offers ways to a scan, or from one slice to all.
            self.base_mut().notify_property_list_changed();
        }
    }

    #[func]
    fn get_transfer_function(&self) -> Option<Gd<LumivoxTransferFunction>> {
        self.transfer_function.clone()
    }

    #[func]
    fn set_transfer_function(&mut self, transfer_function: Option<Gd<LumivoxTransferFunction>>) {
        self.watch(self.transfer_function.clone().map(Gd::upcast), transfer_function.clone().map(Gd::upcast));
        self.transfer_function = transfer_function;
        self.changed();
    }

    #[func]
    fn get_preset(&self) -> GString {
        self.chosen_preset.clone()
    }

    #[func]
    fn set_preset(&mut self, name: GString) {
        if name.is_empty() {
            self._set_chosen_preset(name);
        } else {
            self.apply_preset(name);
        }
    }

    #[func]
    fn set_density(&mut self, value: f64) {
        put!(self.density = value in [0.0, MAX_DENSITY_SCALE]);
    }

    #[func]
    fn set_albedo(&mut self, value: f64) {
        put!(self.albedo = value in [0.0, 1.0]);
    }

    #[func]
    fn set_anisotropy(&mut self, value: f64) {
        put!(self.anisotropy = value in [-0.99, 0.99]);
    }

    #[func]
    fn set_max_bounces(&mut self, value: i64) {
        put!(self.max_bounces = value in [1, 1000]);
    }

    #[func]
    fn set_filter(&mut self, value: i64) {
        put!(self.filter = value in [Self::FILTER_NEAREST, Self::FILTER_SMOOTH]);
    }

    #[func]
    fn set_extinction_space(&mut self, value: i64) {
        put!(self.extinction_space = value in [Self::EXTINCTION_VOLUME, Self::EXTINCTION_WORLD]);
    }

    #[func]
    fn set_surface_strength(&mut self, value: f64) {
        put!(self.surface_strength = value in [0.0, 1.0]);
    }

    #[func]
    fn set_surface_gradient(&mut self, value: f64) {
        put!(self.surface_gradient = value in [0.0, MAX_GRADIENT]);
    }

    #[func]
    fn set_surface_roughness(&mut self, value: f64) {
        put!(self.surface_roughness = value in [0.0, 1.0]);
    }

    #[func]
    fn set_surface_specular(&mut self, value: f64) {
        put!(self.surface_specular = value in [0.0, 1.0]);
    }

    #[func]
    fn set_surface_metallic(&mut self, value: f64) {
        put!(self.surface_metallic = value in [0.0, 1.0]);
    }

    #[func]
    fn _get_chosen_preset(&self) -> GString {
        self.chosen_preset.clone()
    }

    #[func]
    fn _set_chosen_preset(&mut self, name: GString) {
        self.chosen_preset = name;
        self.changed();
    }

    #[func]
    fn _get_exact(&self) -> PackedFloat64Array {
        self.exact.clone()
    }

    #[func]
    fn _set_exact(&mut self, numbers: PackedFloat64Array) {
        self.exact = numbers;
        self.changed();
    }

    #[func]
    fn get_labels(&self) -> Option<Gd<LumivoxLabels>> {
        self.labels.clone()
    }

    #[func]
    fn set_labels(&mut self, labels: Option<Gd<LumivoxLabels>>) {
        self.watch(self.labels.clone().map(Gd::upcast), labels.clone().map(Gd::upcast));
        self.labels = labels;
        self.tell_misplaced_labels();
        self.changed();
        // Not now: its look may be set next.
        self.base_mut().call_deferred("_contents_changed", &[]);
    }

    #[func]
    fn set_keep_everything(&mut self, value: bool) {
        self.keep_everything = value;
        self.changed();
    }

    #[func]
    fn set_peel_mm(&mut self, value: f64) {
        put!(self.peel_mm = value in [0.0, MOST_PEELED_MM]);
    }

    #[func]
    fn get_clip_min(&self) -> Vector3 {
        self.clip_min
    }

    #[func]
    fn set_clip_min(&mut self, corner: Vector3) {
        if takes("LumivoxVolume3D.clip_min", corner.is_finite()) {
            self.clip_min = corner.clamp(Vector3::ZERO, Vector3::ONE);
            self._contents_changed();
        }
    }

    #[func]
    fn get_clip_max(&self) -> Vector3 {
        self.clip_max
    }

    #[func]
    fn set_clip_max(&mut self, corner: Vector3) {
        if takes("LumivoxVolume3D.clip_max", corner.is_finite()) {
            self.clip_max = corner.clamp(Vector3::ZERO, Vector3::ONE);
            self._contents_changed();
        }
    }

    /// Takes over the look of a preset: its transfer function (a new one), [member density], [member albedo],
    /// [member anisotropy], [member max_bounces] and the surface. [member filter], [member extinction_space] and the
    /// clip box stay. Presets for MR place themselves by the scan's values and need [member volume]. Returns whether it
    /// could; if not, an error in the output says why, and nothing changes.
    #[func]
    pub fn apply_preset(&mut self, name: GString) -> bool {
        let Some(curve) = LumivoxTransferFunction::preset(name.clone(), OptionalVolume(self.volume.clone()))
        else {
            return false;
        };
        let Ok(preset) = Preset::from_name(&name.to_string()) else { return false };
        let scan = self.volume.as_ref().and_then(|volume| volume.bind().volume().cloned());
        let medium = scan.map(|scan| preset.medium(&scan)).or_else(|| preset.medium_without_scan());
        let Some(medium) = medium else { return false };
        self.chosen_preset = GString::from(preset.name());
        self.density = medium.density_scale;
        self.albedo = medium.albedo;
        self.anisotropy = medium.anisotropy;
        self.max_bounces = i64::from(medium.max_bounces);
        self.take_surface(medium.surface);
        self.set_transfer_function(Some(curve));
        self.base_mut().notify_property_list_changed();
        true
    }

    /// Whether another thread still computes something that this node shows: the surroundings of the patient, the organ of
    /// its preset, the skin below which it peels. Until then it is seen without.
    #[func]
    pub fn is_preparing(&self) -> bool {
        let is_depth_coming =
            || self.peel_mm > 0.0 && self.volume.as_ref().is_some_and(|v| v.bind().depth().1);
        self.shown().is_some_and(|shown| shown.is_coming) || is_depth_coming()
    }

    /// What another thread computed for this node is there, and shown from now on: [method is_preparing] has become false.
    #[signal]
    fn prepared();

    /// What another thread was to compute for this node is not there, and [param why] says it: no such organ or skin was found
    /// in the scan for sure, and all of it is seen.
    #[signal]
    fn prepare_failed(why: GString);

    #[func]
    fn _tell_prepared(&mut self) {
        match self.preparation_failure() {
            Some(why) => self.signals().prepare_failed().emit(&GString::from(&why)),
            None => self.signals().prepared().emit(),
        }
    }

    /// The names of all presets, for [member preset] and [method apply_preset].
    #[func]
    pub fn preset_names() -> PackedStringArray {
        LumivoxTransferFunction::preset_names()
    }

    /// What the scan fills along the node's axes, in metres; empty without a scan.
    #[func]
    pub fn get_local_box(&self) -> Aabb {
        self.with_volume(|volume| {
            let [low, high] = placement::bounds(volume);
            Aabb::new(convert::vector(low), convert::vector(high - low))
        })
        .unwrap_or_default()
    }

    /// From clip coordinates, [code]0[/code] to [code]1[/code] along each edge of the scan's box, to the node's metres.
    /// An oblique scan's box is turned against the node. The identity without a scan.
    #[func]
    pub fn get_clip_transform(&self) -> Transform3D {
        self.with_volume(|volume| convert::transform(placement::node_from_clip(volume))).unwrap_or_default()
    }

    /// From the patient's millimetres, as DICOM has them (x to the left, y to the back, z to the head), to the node's metres.
    /// The identity without a scan.
    #[func]
    pub fn get_patient_transform(&self) -> Transform3D {
        self.with_volume(|volume| convert::transform(placement::node_from_patient(volume)))
            .unwrap_or_default()
    }

    /// Moves the node so that its scan lies in [param other]'s as it does in the patient: a PET in its CT, an MR on a CT.
    /// Both must be of one frame of reference. A scan's centre is at its node's origin, so that two nodes in one place
    /// are not aligned yet. Returns whether both have a scan.
    #[func]
    pub fn align_with(&mut self, other: Option<Gd<LumivoxVolume3D>>) -> bool {
        let Some(other) = other.filter(|other| *other != self.to_gd()) else { return false };
        let theirs = other.bind();
        if !self.has_scan() || !theirs.has_scan() {
            return false;
        }
        let are_in_tree = self.base().is_inside_tree() && theirs.base().is_inside_tree();
        // Those that are not are taken for children of one parent.
        let place = |node: &Gd<VisualInstance3D>| match are_in_tree {
            true => node.get_global_transform(),
            false => node.get_transform(),
        };
        let from_patient = |node: &Self| convert::affine(node.get_patient_transform());
        let theirs_from_mine = from_patient(&theirs) * from_patient(self).inverse();
        let wanted = convert::transform(convert::affine(place(&theirs.base())) * theirs_from_mine);
        drop(theirs);
        match are_in_tree {
            true => self.base_mut().set_global_transform(wanted),
            false => self.base_mut().set_transform(wanted),
        }
        true
    }

    #[func]
    fn _contents_changed(&mut self) {
        self.base_mut().update_gizmos();
        self.changed();
        if !Engine::singleton().is_editor_hint() {
            self.tell_hidden_paint();
        }
    }
}

#[godot_api]
impl IVisualInstance3D for LumivoxVolume3D {
    fn get_aabb(&self) -> Aabb {
        self.get_local_box()
    }

    fn get_configuration_warnings(&self) -> PackedStringArray {
        self.warnings().into()
    }

    fn on_notification(&mut self, what: Node3DNotification) {
        match what {
            Node3DNotification::ENTER_WORLD => server::add_volume(self.base().instance_id()),
            Node3DNotification::EXIT_WORLD => server::remove_volume(self.base().instance_id()),
            // The scan may have gone into the scene's file.
            Node3DNotification::EDITOR_POST_SAVE => self.base_mut().update_configuration_warnings(),
            _ => {}
        }
    }

    fn on_validate_property(&self, property: &mut PropertyInfo) {
        if property.property_name == "preset" {
            property.hint_info = PropertyHintInfo {
                hint: PropertyHint::ENUM,
                hint_string: GString::from(&format!(",{}", Preset::names().join(","))),
            };
        }
    }
}

impl LumivoxVolume3D {
    /// What is seen, and perhaps warned of, is another.
    fn changed(&mut self) {
        // The scene dock is the main thread's.
        if is_main_thread() {
            self.base_mut().update_configuration_warnings();
        }
        self.request_redraw();
    }

    fn has_scan(&self) -> bool {
        self.with_volume(|_| ()).is_some()
    }

    /// An engine that idles draws again.
    pub fn request_redraw(&self) {
        let base = self.base();
        if base.is_inside_tree() {
            // The cheapest change that the rendering server notices.
            RenderingServer::singleton().instance_set_layer_mask(base.get_instance(), base.get_layer_mask());
        }
    }

    fn with_volume<T>(&self, ask: impl FnOnce(&lumivox_core::Volume) -> T) -> Option<T> {
        self.volume.as_ref()?.bind().volume().map(|volume| ask(volume))
    }

    /// Listens to one resource instead of another. Deferred: on the main thread, whichever changes it, and not while
    /// that holds the resource.
    fn watch(&mut self, old: Option<Gd<Resource>>, new: Option<Gd<Resource>>) {
        let changed = self.base().callable("_contents_changed");
        if let Some(mut old) = old.filter(|old| old.is_connected("changed", &changed)) {
            old.disconnect("changed", &changed);
        }
        if let Some(mut new) = new.filter(|new| !new.is_connected("changed", &changed)) {
            new.connect_flags("changed", &changed, ConnectFlags::DEFERRED);
        }
    }
}
