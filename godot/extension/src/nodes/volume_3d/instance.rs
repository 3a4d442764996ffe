//! The node as the renderer's volume: what is shown of its scan, its look, and where it stands.

use godot::prelude::*;
use lumivox_core::{ExtinctionSpace, Filter, Medium, Peel, SurfaceReflection, VolumeInstance, placement};

use super::LumivoxVolume3D;
use crate::convert;
use crate::nodes::clip_3d::clip_shapes_of;

impl LumivoxVolume3D {
    /// The surface of a new node, and of a label's that has one of its own; a gradient of 0 is what suits the scan.
    pub const SURFACE: SurfaceReflection = SurfaceReflection {
        strength: 1.0,
        gradient_per_mm: 0.0,
        roughness: 0.4,
        specular: 0.04,
        metallic: 0.0,
    };

    /// The volume as it stands in the world; `None` without a scan.
    pub fn instance(&self) -> Option<VolumeInstance> {
        let suited = self.volume.as_ref()?.bind().default_medium()?.clone();
        let (shown, peel) = (self.shown()?, self.peel());
        self.follow(shown.is_coming || peel.1);
        let volume = shown.volume;
        let (low, high) = (convert::dvec(self.clip_min), convert::dvec(self.clip_max));
        let place = self.to_gd().get_global_transform_interpolated();
        let medium = self.medium(&suited);
        let rounded = || convert::affine(place) * placement::node_from_patient(&volume);
        let world_from_patient = self.exact_place(&volume, place).unwrap_or_else(rounded);
        Some(VolumeInstance {
            world_from_patient,
            clip_box: self.exact_clip(&volume).unwrap_or_else(|| placement::clip_box(&volume, low, high)),
            layers: self.base().get_layer_mask(),
            labels: self.labels.as_ref().and_then(|labels| labels.bind().labelling(medium.surface)),
            medium,
            peel: peel.0,
            clip_shapes: clip_shapes_of(
                &self.base(),
                world_from_patient,
                placement::node_from_patient(&volume),
            ),
            volume,
        })
    }

    /// A corner of what is kept, in clip coordinates.
    pub fn clip_corner(&self, largest: bool) -> Vector3 {
        let (a, b) = (self.clip_min, self.clip_max);
        if largest { a.coord_max(b) } else { a.coord_min(b) }
    }

    /// What is taken off, once the skin was found; and whether it is still looked for.
    pub(super) fn peel(&self) -> (Option<Peel>, bool) {
        let resource = self.volume.as_ref().filter(|_| self.peel_mm > 0.0);
        let (depth, is_coming) = resource.map_or((None, false), |resource| resource.bind().depth());
        (depth.map(|depth| Peel { depth, mm: self.peel_mm }), is_coming)
    }

    /// Takes over a look's surface.
    pub(super) fn take_surface(&mut self, surface: SurfaceReflection) {
        let SurfaceReflection { strength, gradient_per_mm, roughness, specular, metallic } = surface;
        self.surface_strength = strength;
        self.surface_gradient = gradient_per_mm;
        self.surface_roughness = roughness;
        self.surface_specular = specular;
        self.surface_metallic = metallic;
    }

    pub(super) fn medium(&self, suited: &Medium) -> Medium {
        let (transfer_function, gradients) = match &self.transfer_function {
            Some(chosen) => (chosen.bind().curve(), chosen.bind().gradients()),
            None => (suited.transfer_function.clone(), vec![]),
        };
        Medium {
            transfer_function,
            gradients,
            density_scale: self.density,
            albedo: self.albedo,
            anisotropy: self.anisotropy,
            max_bounces: self.max_bounces as u32,
            filter: match self.filter {
                Self::FILTER_NEAREST => Filter::Nearest,
                Self::FILTER_TRILINEAR => Filter::Trilinear,
                Self::FILTER_TRICUBIC => Filter::Tricubic,
                _ => Filter::Smooth,
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
                metallic: self.surface_metallic,
            },
            extinction_space: match self.extinction_space {
                Self::EXTINCTION_WORLD => ExtinctionSpace::World,
                _ => ExtinctionSpace::Volume,
            },
        }
        .sanitized()
    }
}
