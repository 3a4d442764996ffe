//! The node that shows a scan.

use godot::classes::notify::Node3DNotification;
use godot::classes::{Engine, IVisualInstance3D, RenderingServer, Resource, VisualInstance3D};
use godot::prelude::*;
use godot::register::info::{PropertyHint, PropertyHintInfo, PropertyInfo};
use lumivox_core::{ExtinctionSpace, Filter, Medium, Preset, SurfaceReflection, VolumeInstance};

use super::placement;
use crate::convert;
use crate::resources::{LumivoxTransferFunction, LumivoxVolume, OptionalVolume, no_scan};
use crate::{server, shared};

/// A scan in a scene, path traced: it scatters the scene's light, hides meshes behind it and is hidden by those before
/// it. Any number may overlap.
///
/// The scan stands upright at its true size, its centre at the node's origin, and faces +z. It needs the Forward+ or the
/// Mobile renderer. How the image converges is set by the [LumivoxEffect] of the scene's [Compositor]; without one,
/// its defaults hold.
///
/// [DirectionalLight3D], [OmniLight3D] and [SpotLight3D] light it with their colour, energy, size, range, attenuation
/// and cull mask, in physical light units too where the project uses them, and so does the sky or the ambient colour of
/// the environment. Volumes cast shadows on volumes whether a light has shadows or not. Projectors and distance fades of
/// lights are not followed, and lights with [member Light3D.light_negative] do not shine on volumes at all.
/// [ReflectionProbe], [VoxelGI], SDFGI and lightmaps do nothing to volumes.
#[derive(GodotClass)]
#[class(tool, init, base = VisualInstance3D)]
pub struct LumivoxVolume3D {
    /// The scan.
    #[export]
    #[var(get, set)]
    volume: Option<Gd<LumivoxVolume>>,
    /// Opacity and colour of the scan's values. Empty: those of the preset that suits the scan.
    #[export]
    #[var(get, set)]
    transfer_function: Option<Gd<LumivoxTransferFunction>>,
    /// A look that suits a kind of scan at once. Choosing one replaces [member transfer_function] and everything in
    /// this group and the next; what is changed afterwards stays changed.
    #[export_group(name = "Medium")]
    #[var(get, set, usage_flags = [EDITOR])]
    preset: PhantomVar<GString>,
    /// The preset that was chosen last, for the inspector.
    #[var(usage_flags = [STORAGE])]
    chosen_preset: GString,
    /// Multiplies the extinction, which is 1 per millimetre at an opacity of 1. Low: glass and mist; high: solid.
    #[export(range = (0.0, 100.0, 0.001, exp, or_greater))]
    #[init(val = 2.0)]
    density: f64,
    /// Fraction of the light that survives each scattering.
    #[export(range = (0.0, 1.0, 0.001))]
    #[init(val = 1.0)]
    albedo: f64,
    /// Where light goes when it scatters: 0 in all directions alike, towards 1 onwards, towards -1 back.
    #[export(range = (-0.99, 0.99, 0.01))]
    anisotropy: f64,
    /// Scatterings after which light is no longer followed. 1 is single scattering: fast and dark.
    #[export(range = (1.0, 1000.0, 1.0, exp))]
    #[init(val = 100)]
    max_bounces: i64,
    /// How values between voxels are found. Nearest shows the voxels; Tricubic is the smoothest and the slowest.
    #[export(enum = (Nearest, Trilinear, Tricubic))]
    #[init(val = 1)]
    filter: i64,
    /// What a millimetre of extinction is measured in. Volume: scaling the node never changes its look. World: twice as
    /// large is twice as opaque.
    #[export(enum = (Volume, World))]
    extinction_space: i64,
    /// How strongly boundaries inside the scan, such as that of bone, reflect like surfaces; 0 is off.
    #[export_group(name = "Surface", prefix = "surface_")]
    #[export(range = (0.0, 1.0, 0.001))]
    #[init(val = 1.0)]
    surface_strength: f64,
    /// How steep a boundary must be, in value units (HU for CT) per millimetre. 0: as suits the scan.
    #[export(range = (0.0, 1000.0, 0.1, or_greater))]
    surface_gradient: f64,
    /// Width of the highlights: 0 glossy, 1 matt.
    #[export(range = (0.0, 1.0, 0.001))]
    #[init(val = 0.4)]
    surface_roughness: f64,
    /// Brightness of the highlights seen head-on. Skin and bone have about 0.04.
    #[export(range = (0.0, 1.0, 0.001))]
    #[init(val = 0.04)]
    surface_specular: f64,
    /// The corner of what is kept of the scan with the smallest coordinates, as fractions of its box: x to the right, y
    /// up, z towards the viewer.
    #[export_group(name = "Clip", prefix = "clip_")]
    #[export]
    #[var(get, set, hint = RANGE, hint_string = "0,1,0.001")]
    clip_min: Vector3,
    /// The opposite corner of what is kept.
    #[export]
    #[var(get, set, hint = RANGE, hint_string = "0,1,0.001")]
    #[init(val = Vector3::ONE)]
    clip_max: Vector3,
    base: Base<VisualInstance3D>,
}

#[godot_api]
impl LumivoxVolume3D {
    #[func]
    fn get_volume(&self) -> Option<Gd<LumivoxVolume>> {
        self.volume.clone()
    }

    #[func]
    fn set_volume(&mut self, volume: Option<Gd<LumivoxVolume>>) {
        self.watch(self.volume.clone().map(Gd::upcast), volume.clone().map(Gd::upcast));
        self.volume = volume;
        self._contents_changed();
    }

    #[func]
    fn get_transfer_function(&self) -> Option<Gd<LumivoxTransferFunction>> {
        self.transfer_function.clone()
    }

    #[func]
    fn set_transfer_function(&mut self, transfer_function: Option<Gd<LumivoxTransferFunction>>) {
        self.watch(self.transfer_function.clone().map(Gd::upcast), transfer_function.clone().map(Gd::upcast));
        self.transfer_function = transfer_function;
        self.request_redraw();
    }

    #[func]
    fn get_preset(&self) -> GString {
        self.chosen_preset.clone()
    }

    #[func]
    fn set_preset(&mut self, name: GString) {
        if name.is_empty() {
            self.chosen_preset = name;
        } else {
            self.apply_preset(name);
        }
    }

    #[func]
    fn get_clip_min(&self) -> Vector3 {
        self.clip_min
    }

    #[func]
    fn set_clip_min(&mut self, corner: Vector3) {
        self.clip_min = unit_cube(corner, Vector3::ZERO);
        self.base_mut().update_gizmos();
        self.request_redraw();
    }

    #[func]
    fn get_clip_max(&self) -> Vector3 {
        self.clip_max
    }

    #[func]
    fn set_clip_max(&mut self, corner: Vector3) {
        self.clip_max = unit_cube(corner, Vector3::ONE);
        self.base_mut().update_gizmos();
        self.request_redraw();
    }

    /// Takes over the look of a preset: its transfer function, medium and surface. Returns whether there is one of that
    /// name. Presets for MR place themselves by the scan's values and need [member volume].
    #[func]
    pub fn apply_preset(&mut self, name: GString) -> bool {
        let Some(curve) = LumivoxTransferFunction::preset(name.clone(), OptionalVolume(self.volume.clone()))
        else {
            return false;
        };
        let Ok(preset) = Preset::from_name(&name.to_string()) else { return false };
        let scan = self.volume.as_ref().and_then(|volume| volume.bind().volume().cloned());
        let medium = match scan {
            Some(scan) => preset.medium(&scan),
            None => preset.medium(&no_scan()),
        };
        self.chosen_preset = GString::from(preset.name());
        self.density = medium.density_scale;
        self.albedo = medium.albedo;
        self.anisotropy = medium.anisotropy;
        self.max_bounces = i64::from(medium.max_bounces);
        self.surface_strength = medium.surface.strength;
        self.surface_gradient = medium.surface.gradient_per_mm;
        self.surface_roughness = medium.surface.roughness;
        self.surface_specular = medium.surface.specular;
        self.set_transfer_function(Some(curve));
        self.base_mut().notify_property_list_changed();
        true
    }

    /// The names of all presets.
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
    /// An oblique scan's box is turned against the node.
    #[func]
    pub fn get_clip_transform(&self) -> Transform3D {
        self.with_volume(|volume| convert::transform(placement::node_from_clip(volume))).unwrap_or_default()
    }

    #[func]
    fn _contents_changed(&mut self) {
        let mut base = self.base_mut();
        base.update_gizmos();
        base.update_configuration_warnings();
        drop(base);
        self.request_redraw();
    }
}

#[godot_api]
impl IVisualInstance3D for LumivoxVolume3D {
    fn get_aabb(&self) -> Aabb {
        self.get_local_box()
    }

    fn get_configuration_warnings(&self) -> PackedStringArray {
        let mut warnings = vec![];
        if plugin_is_off() {
            warnings.push(GString::from(
                "The Lumivox plugin is off: scans are not imported, and there are no handles. Switch it on in \
                 Project Settings, Plugins.",
            ));
        }
        if self.with_volume(|_| ()).is_none() {
            warnings.push(GString::from(
                "There is no scan to show. Set 'Volume', or drop a DICOM folder on the FileSystem dock.",
            ));
        }
        if RenderingServer::singleton().get_rendering_device().is_none() {
            warnings.push(GString::from(server::NO_DEVICE));
        } else if let Some(error) = &shared::lock().error {
            warnings.push(GString::from(&format!("Volumes cannot be drawn: {error}.")));
        }
        warnings.into()
    }

    fn on_notification(&mut self, what: Node3DNotification) {
        match what {
            Node3DNotification::ENTER_WORLD => server::add_volume(self.base().instance_id()),
            Node3DNotification::EXIT_WORLD => server::remove_volume(self.base().instance_id()),
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
    /// The volume as it stands in the world; `None` without a scan.
    pub fn instance(&self) -> Option<VolumeInstance> {
        let resource = self.volume.as_ref()?.bind();
        let volume = resource.volume()?.clone();
        let suited = resource.default_medium()?;
        let (low, high) = (convert::dvec(self.clip_min), convert::dvec(self.clip_max));
        let world_from_node = convert::affine(self.to_gd().get_global_transform_interpolated());
        Some(VolumeInstance {
            world_from_patient: world_from_node * placement::node_from_patient(&volume),
            clip_box: placement::clip_box(&volume, low, high),
            medium: self.medium(suited),
            layers: self.base().get_layer_mask(),
            volume,
        })
    }

    fn medium(&self, suited: &Medium) -> Medium {
        let transfer_function = match &self.transfer_function {
            Some(chosen) => chosen.bind().curve(),
            None => suited.transfer_function.clone(),
        };
        Medium {
            transfer_function,
            density_scale: self.density,
            albedo: self.albedo,
            anisotropy: self.anisotropy,
            max_bounces: self.max_bounces.clamp(1, 1000) as u32,
            filter: match self.filter {
                0 => Filter::Nearest,
                2 => Filter::Tricubic,
                _ => Filter::Trilinear,
            },
            surface: SurfaceReflection {
                strength: self.surface_strength,
                gradient_per_mm: if self.surface_gradient > 0.0 {
                    self.surface_gradient
                } else {
                    suited.surface.gradient_per_mm
                },
                roughness: self.surface_roughness,
                specular: self.surface_specular,
            },
            extinction_space: match self.extinction_space {
                1 => ExtinctionSpace::World,
                _ => ExtinctionSpace::Volume,
            },
        }
        .sanitized()
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

    /// Listens to one resource instead of another.
    fn watch(&mut self, old: Option<Gd<Resource>>, new: Option<Gd<Resource>>) {
        let changed = self.base().callable("_contents_changed");
        if let Some(mut old) = old.filter(|old| old.is_connected("changed", &changed)) {
            old.disconnect("changed", &changed);
        }
        if let Some(mut new) = new.filter(|new| !new.is_connected("changed", &changed)) {
            new.connect("changed", &changed);
        }
    }
}

/// Whether the editor runs without the half of the addon that is a plugin.
fn plugin_is_off() -> bool {
    let engine = Engine::singleton();
    let editor = if engine.is_editor_hint() { engine.get_singleton("EditorInterface") } else { None };
    editor.is_some_and(|mut editor| !editor.call("is_plugin_enabled", &["lumivox".to_variant()]).booleanize())
}

fn unit_cube(v: Vector3, otherwise: Vector3) -> Vector3 {
    if v.is_finite() { v.clamp(Vector3::ZERO, Vector3::ONE) } else { otherwise }
}
