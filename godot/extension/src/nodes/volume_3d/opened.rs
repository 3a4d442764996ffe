//! The node of a scene file's volume, and the digits of it that the node's own properties have no room for.

use godot::prelude::*;
use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{ExtinctionSpace, Filter, Preset, Volume, VolumeInstance, placement};

use super::LumivoxVolume3D;
use crate::convert;
use crate::nodes::LumivoxClip3D;
use crate::resources::{LumivoxLabels, LumivoxTransferFunction, LumivoxVolume};

impl LumivoxVolume3D {
    /// The node of a volume of a scene, in the world's own space, with the shapes that cut it as children.
    pub fn opened(instance: &VolumeInstance, volume: Gd<LumivoxVolume>, preset: Option<Preset>) -> Gd<Self> {
        let medium = &instance.medium;
        let node_from_patient = placement::node_from_patient(&instance.volume);
        let mut node = Self::new_alloc();
        node.bind_mut().set_volume(Some(volume));
        let function = LumivoxTransferFunction::exactly(&medium.transfer_function, &medium.gradients);
        node.bind_mut().set_transfer_function(Some(function));
        if let Some(labelling) = &instance.labels {
            node.bind_mut().set_labels(Some(LumivoxLabels::exactly(labelling)));
        }
        {
            let mut this = node.bind_mut();
            // That of an organ would look for it once more, in what is that organ already.
            let named = preset.filter(|preset| preset.organ().is_none());
            this.chosen_preset = named.map_or(GString::new(), |preset| GString::from(preset.name()));
            this.density = medium.density_scale;
            this.albedo = medium.albedo;
            this.anisotropy = medium.anisotropy;
            this.max_bounces = i64::from(medium.max_bounces);
            this.filter = match medium.filter {
                Filter::Nearest => Self::FILTER_NEAREST,
                Filter::Trilinear => Self::FILTER_TRILINEAR,
                Filter::Tricubic => Self::FILTER_TRICUBIC,
                Filter::Smooth => Self::FILTER_SMOOTH,
            };
            this.extinction_space = match medium.extinction_space {
                ExtinctionSpace::World => Self::EXTINCTION_WORLD,
                ExtinctionSpace::Volume => Self::EXTINCTION_VOLUME,
            };
            this.take_surface(medium.surface);
            this.peel_mm = instance.peel.as_ref().map_or(0.0, |peel| peel.mm);
            let [low, high] = placement::node_clip(&instance.volume, instance.clip_box).map(convert::vector);
            (this.clip_min, this.clip_max) = (low, high);
            let [low, high] = instance.clip_box.map(|corner| corner.to_array());
            let place = convert::numbers(instance.world_from_patient);
            this.exact = place.as_slice().iter().copied().chain(low).chain(high).collect();
        }
        node.set_transform(convert::transform(instance.world_from_patient * node_from_patient.inverse()));
        node.set_layer_mask(instance.layers);
        for shape in &instance.clip_shapes {
            node.add_child(&LumivoxClip3D::opened(shape, node_from_patient));
        }
        node
    }

    /// The world from the patient as a scene file had it, where the node still stands there.
    pub(super) fn exact_place(&self, volume: &Volume, place: Transform3D) -> Option<DAffine3> {
        let exact = convert::affine_of(self.exact.as_slice().get(..12)?)?;
        let node_from_patient = placement::node_from_patient(volume);
        (convert::transform(exact * node_from_patient.inverse()) == place).then_some(exact)
    }

    /// The clip box along the scan's axes as a scene file had it, where the node still has it.
    pub(super) fn exact_clip(&self, volume: &Volume) -> Option<[DVec3; 2]> {
        let numbers: &[f64; 6] = self.exact.as_slice().get(12..)?.try_into().ok()?;
        let exact = [DVec3::from_slice(&numbers[..3]), DVec3::from_slice(&numbers[3..])];
        let own = placement::node_clip(volume, exact).map(convert::vector);
        (own == [self.clip_min, self.clip_max]).then_some(exact)
    }
}
