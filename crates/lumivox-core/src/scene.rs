//! Volumes placed in a world, and the light around them.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use crate::{environment::Environment, light::Light, medium::Medium, volume::Volume};

/// One volume in a scene. Any number may overlap, rotated and scaled at will: their media superpose.
#[derive(Clone, Debug)]
pub struct VolumeInstance {
    /// The scan; instances may share it.
    pub volume: Arc<Volume>,
    /// Its look.
    pub medium: Medium,
    /// World metres from patient millimetres.
    pub world_from_patient: DAffine3,
    /// What is kept of the volume, as opposite corners in box coordinates (`[0, 1]^3` is everything).
    pub clip_box: [DVec3; 2],
    /// Its layers, a bit each: a [`Light`] reaches it if its mask shares one. The environment always does.
    pub layers: u32,
}

impl VolumeInstance {
    /// A volume at true size, its centre at the world's origin, upright and facing +z.
    pub fn centered(volume: Arc<Volume>, medium: Medium) -> Self {
        let world_from_patient = world_from_patient() * DAffine3::from_translation(-volume.center_mm());
        Self { volume, medium, world_from_patient, clip_box: [DVec3::ZERO, DVec3::ONE], layers: 1 }
    }

    /// Whether another looks the same, see [`Scene::is_same`].
    fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.volume, &other.volume)
            && self.world_from_patient == other.world_from_patient
            && self.clip_box == other.clip_box
            && self.medium == other.medium
            && self.layers == other.layers
    }

    /// World metres from box coordinates, where the volume fills `[0, 1]^3`.
    pub fn world_from_box(&self) -> DAffine3 {
        self.world_from_patient * self.volume.patient_from_box()
    }
}

/// What is rendered: volumes in the light of an environment and of any number of lamps.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The volumes, in any order.
    pub volumes: Vec<VolumeInstance>,
    /// The light from all around.
    pub environment: Environment,
    /// The engine's lights, in any order; one that is not finite is not there.
    pub lights: Vec<Light>,
}

impl Scene {
    /// A scene with one centred volume in the default environment.
    pub fn with_volume(volume: Arc<Volume>, medium: Medium) -> Self {
        Self { volumes: vec![VolumeInstance::centered(volume, medium)], ..Self::default() }
    }

    /// Whether another looks the same, by the identity of volumes and maps and not by what is in them: what an engine asks
    /// in every frame.
    pub fn is_same(&self, other: &Self) -> bool {
        self.volumes.len() == other.volumes.len()
            && self.volumes.iter().zip(&other.volumes).all(|(a, b)| a.is_same(b))
            && self.lights == other.lights
            && self.environment.is_same(&other.environment)
    }
}

/// World metres from patient millimetres (LPS) for an upright patient who faces +z: left is +x, head is +y.
pub fn world_from_patient() -> DAffine3 {
    const METRES_PER_MM: f64 = 1e-3;
    DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y) * METRES_PER_MM)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_patient_stands_upright_faces_the_viewer_and_is_not_mirrored() {
        let world = world_from_patient();
        let along = |lps: DVec3| world.transform_vector3(lps * 1000.0);
        assert_eq!(along(DVec3::Z), DVec3::Y, "head up");
        assert_eq!(along(DVec3::NEG_Y), DVec3::Z, "face towards the viewer");
        assert_eq!(along(DVec3::X), DVec3::X, "the patient's left is at the viewer's right");
        assert!(world.matrix3.determinant() > 0.0);
    }
}
