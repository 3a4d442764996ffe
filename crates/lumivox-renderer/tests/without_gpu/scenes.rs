//! Small scenes, and the device that they are recorded for.

use std::collections::HashSet;
use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{
    Medium, Modality, PerspectiveCamera, Scene, TransferFunction, Volume, VolumeInstance, Voxels,
};
use lumivox_renderer::{DeviceLimits, FineTexels, Recording, ResourceId, Step};

pub const LIMITS: DeviceLimits = {
    let mut limits = DeviceLimits::webgpu_default();
    limits.max_texture_3d = 256;
    limits.max_texture_bytes = 1 << 30;
    limits.fine_texels = FineTexels::Norms;
    limits.max_texture_2d = 1024;
    limits.max_storage_binding = 4 << 20;
    limits.max_samples_per_dispatch = DeviceLimits::SAMPLES_OF_GPU;
    limits
};

pub fn volume(size: usize) -> Arc<Volume> {
    let voxels = Voxels::U16((0..size * size * size).map(|i| (i % 1000) as u16).collect());
    Arc::new(Volume::new([size; 3], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Other).unwrap())
}

pub fn instance(volume: &Arc<Volume>) -> VolumeInstance {
    VolumeInstance::centered(volume.clone(), Medium::new(TransferFunction::constant(0.5, [0.5; 3])))
}

pub fn scene(volumes: &[Arc<Volume>]) -> Scene {
    Scene { volumes: volumes.iter().map(instance).collect(), ..Default::default() }
}

pub fn camera() -> PerspectiveCamera {
    PerspectiveCamera::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y, 0.5)
}

/// Every step uses only what exists; what is freed existed.
pub fn replay(recording: &Recording, alive: &mut HashSet<ResourceId>) {
    for step in &recording.steps {
        match step {
            Step::CreateBuffer { id, .. } | Step::CreateTexture { id, .. } => assert!(alive.insert(*id)),
            Step::Free { id } => assert!(alive.remove(id), "{id:?} is freed twice"),
            Step::Dispatch { resources, .. } => assert!(resources.iter().all(|id| alive.contains(id))),
            Step::Draw { resources, target, .. } => {
                assert!(resources.iter().all(|id| alive.contains(id)) && alive.contains(target));
            }
            Step::CopyTexture { from, to, .. } => {
                assert!(alive.contains(from) && alive.contains(to));
            }
            Step::WriteBuffer { id, .. }
            | Step::WriteTexture { id, .. }
            | Step::ClearBuffer { id }
            | Step::ReadBuffer { id, .. } => assert!(alive.contains(id)),
        }
    }
}
