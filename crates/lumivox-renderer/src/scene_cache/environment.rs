//! The environment on the GPU: its map, and where to draw directions from.

use std::sync::Arc;

use lumivox_core::{Environment, EnvironmentMap, EnvironmentSource};
use lumivox_shaders::layout::ImportanceCell;

use super::DeviceLimits;
use super::importance::{self, ImportanceGrid};
use super::mirror::Part;
use crate::error::RenderError;
use crate::recording::{Payload, Recording, ResourceId, Step, TextureFormat};

/// Light that is brighter leaves what 32 bits can sum the squares of.
const MAX_STRENGTH: f64 = 1e9;

/// A scene's environment.
#[derive(Debug)]
pub(super) struct CachedEnvironment {
    source: Option<EnvironmentSource>,
    pub map: Option<ResourceId>,
    /// Where directions are drawn from, in the buffer of tables.
    pub importance: Part<ImportanceCell>,
    pub rotation: f64,
    pub strength: f64,
    pub map_size: [u32; 2],
    pub importance_size: [u32; 2],
    /// Of its radiance at strength 1.
    pub mean_luminance: f64,
}

impl Default for CachedEnvironment {
    fn default() -> Self {
        Self {
            source: None,
            map: None,
            importance: Part::default(),
            rotation: 0.0,
            strength: 1.0,
            map_size: [1, 1],
            importance_size: [1, 1],
            mean_luminance: 0.0,
        }
    }
}

/// Whether the device has room for the environment's map.
pub(super) fn check(environment: &Environment, limits: &DeviceLimits) -> Result<(), RenderError> {
    let limit = limits.max_texture_2d;
    match &environment.source {
        EnvironmentSource::Map(map) if map.width.max(map.height) > limit as usize => {
            Err(RenderError::EnvironmentTooLarge { width: map.width, height: map.height, limit })
        }
        _ => Ok(()),
    }
}

/// The map of another source, and where to draw directions from it.
pub(super) struct NewMap {
    map: Arc<EnvironmentMap>,
    grid: Arc<ImportanceGrid>,
}

impl NewMap {
    pub fn cells(&self) -> usize {
        self.grid.cells.len()
    }
}

impl CachedEnvironment {
    /// Whether this is the source that it has.
    pub fn holds(&self, source: &EnvironmentSource) -> bool {
        self.source.as_ref().is_some_and(|held| same(held, source))
    }

    /// What a source brings, unless it is there.
    pub fn new_map(&self, source: &EnvironmentSource, unprepared: &mut u64) -> Option<NewMap> {
        if self.holds(source) {
            return None;
        }
        let (map, grid, computed) = importance::of(source);
        *unprepared += u64::from(computed);
        Some(NewMap { map, grid })
    }

    /// Records what differs; returns whether anything did. The device has room, see [`check`].
    pub fn update(
        &mut self,
        environment: &Environment,
        new_map: Option<NewMap>,
        recording: &mut Recording,
    ) -> bool {
        let rotation = if environment.rotation.is_finite() { environment.rotation } else { 0.0 };
        let strength = if environment.strength.is_finite() {
            environment.strength.clamp(0.0, MAX_STRENGTH)
        } else {
            1.0
        };
        let turned = [rotation, strength] != [self.rotation, self.strength];
        (self.rotation, self.strength) = (rotation, strength);
        let Some(NewMap { map, grid }) = new_map else { return turned };
        self.free(recording);
        self.map_size = [map.width as u32, map.height as u32];
        self.importance_size = grid.size.map(|n| n as u32);
        self.mean_luminance = grid.mean_luminance;
        let [width, height] = self.map_size;
        let id = recording.create_texture("environment", TextureFormat::Rgba32Float, [width, height, 0]);
        let texels: Vec<[f32; 4]> = map.texels.iter().map(|&[r, g, b]| [r, g, b, 0.0]).collect();
        let data = Payload::copy_of(&texels);
        recording.push(Step::WriteTexture { id, origin: [0; 3], size: [width, height, 1], data });
        self.map = Some(id);
        self.importance.update(grid.cells.clone(), recording);
        self.source = Some(environment.source.clone());
        true
    }

    pub fn free(&mut self, recording: &mut Recording) {
        recording.free(self.map.take());
    }
}

/// Whether two sources are the same; maps are compared by identity first, for they are large.
fn same(a: &EnvironmentSource, b: &EnvironmentSource) -> bool {
    match (a, b) {
        (EnvironmentSource::Map(a), EnvironmentSource::Map(b)) => Arc::ptr_eq(a, b) || a == b,
        _ => a == b,
    }
}
