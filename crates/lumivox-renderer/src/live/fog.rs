//! Fog as rasterising engines have it: a colour over what is seen, not a medium that light goes through.

use lumivox_core::{Camera, Projection};
use lumivox_shaders::{constants, layout};

/// Hides what is far or low. Nothing is traced, and nothing starts over when it changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fog {
    /// What is seen where it hides everything, in the scene-linear units of the host's colour: exposure leaves it alone.
    pub color: [f64; 3],
    /// What hides things that are far.
    pub by_distance: DistanceFog,
    /// What hides things that are low, if anything does.
    pub by_height: Option<HeightFog>,
}

/// How much fog there is at a distance of some metres from the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DistanceFog {
    /// `1 - exp(-density * distance)`.
    Exponential {
        /// Per metre.
        density: f64,
    },
    /// `density * smoothstep(begin, end, distance)^curve`.
    Between {
        /// Metres where it begins.
        begin: f64,
        /// Metres where it gets no thicker.
        end: f64,
        /// 1 or more: late and steep.
        curve: f64,
        /// At the end, 0 to 1.
        density: f64,
    },
    /// `(depth - begin) / (end - begin)`, 0 to 1, where the depth is the distance along the view: Unity's linear fog.
    LinearInDepth {
        /// Metres where it begins.
        begin: f64,
        /// Metres where it hides everything.
        end: f64,
    },
    /// `1 - exp(-density * depth)`: Unity's exponential fog.
    ExponentialInDepth {
        /// Per metre.
        density: f64,
    },
    /// `1 - exp(-(density * depth)^2)`: Unity's exponential squared fog.
    ExponentialSquaredInDepth {
        /// Per metre.
        density: f64,
    },
}

/// Fog below a height, above it if `density` is negative: `1 - exp(min(0, (y - height) * density))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightFog {
    /// World y in metres where it begins.
    pub height: f64,
    /// Per metre.
    pub density: f64,
}

impl Fog {
    /// The share of what is seen that it hides, 0 to 1: at `distance` metres from the camera (of fog in depth, along its
    /// view), at world y `height`.
    ///
    /// The larger of both kinds, as Godot's `fog_process` has it; `fog.wgsl` is its twin.
    pub fn amount(&self, distance: f64, height: f64) -> f64 {
        let by_distance = match self.by_distance {
            DistanceFog::Exponential { density } => 1.0 - (-distance * density).exp(),
            DistanceFog::Between { begin, end, curve, density } => {
                let t = ((distance - begin) / (end - begin)).clamp(0.0, 1.0);
                (t * t * (3.0 - 2.0 * t)).powf(curve) * density
            }
            DistanceFog::LinearInDepth { begin, end } => ((distance - begin) / (end - begin)).clamp(0.0, 1.0),
            DistanceFog::ExponentialInDepth { density } => 1.0 - (-distance * density).exp(),
            DistanceFog::ExponentialSquaredInDepth { density } => 1.0 - (-(distance * density).powi(2)).exp(),
        };
        let by_height =
            self.by_height.map_or(0.0, |fog| 1.0 - ((height - fog.height) * fog.density).min(0.0).exp());
        by_distance.max(by_height).clamp(0.0, 1.0)
    }

    pub(super) fn write(&self, camera: &Camera, params: &mut layout::LivePictureParams) {
        let narrow = |numbers: [f64; 4]| numbers.map(|x| x as f32);
        let (kind, distance) = match self.by_distance {
            DistanceFog::Exponential { density } => (constants::FOG_EXPONENTIAL, [density, 0.0, 0.0, 0.0]),
            DistanceFog::Between { begin, end, curve, density } => {
                (constants::FOG_BETWEEN, [begin, end, curve, density])
            }
            DistanceFog::LinearInDepth { begin, end } => {
                (constants::FOG_LINEAR_IN_DEPTH, [begin, end, 0.0, 0.0])
            }
            DistanceFog::ExponentialInDepth { density } => {
                (constants::FOG_EXPONENTIAL_IN_DEPTH, [density, 0.0, 0.0, 0.0])
            }
            DistanceFog::ExponentialSquaredInDepth { density } => {
                (constants::FOG_EXPONENTIAL_SQUARED_IN_DEPTH, [density, 0.0, 0.0, 0.0])
            }
        };
        let (edges, parallel) = match camera.projection {
            Projection::Perspective { tangents } => (tangents, false),
            Projection::Orthographic { extents } => (extents, true),
        };
        let below = self.by_height.unwrap_or(HeightFog { height: 0.0, density: 0.0 });
        let world = camera.world_from_camera;
        let up = world.matrix3.row(1);
        params.fog_color = self.color.map(|c| c as f32);
        params.fog_kind = kind;
        params.fog_distance = narrow(distance);
        params.fog_height = [below.height as f32, below.density as f32];
        params.camera_edges = narrow(edges);
        params.camera_parallel = u32::from(parallel);
        params.world_height = narrow([up.x, up.y, up.z, world.translation.y]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_thicker_of_both_kinds_hides() {
        let far = DistanceFog::Exponential { density: 0.5 };
        let fog = Fog { color: [1.0; 3], by_distance: far, by_height: None };
        assert_eq!(fog.amount(0.0, 0.0), 0.0);
        assert!((fog.amount(2.0, 0.0) - (1.0 - (-1.0f64).exp())).abs() < 1e-12);
        let low = Fog { by_height: Some(HeightFog { height: 1.0, density: 2.0 }), ..fog };
        assert_eq!(low.amount(0.0, 1.5), 0.0, "above");
        assert!((low.amount(2.0, 0.0) - (1.0 - (-2.0f64).exp())).abs() < 1e-12, "below");
        let high = Fog { by_height: Some(HeightFog { height: 1.0, density: -2.0 }), ..fog };
        assert!((high.amount(0.0, 2.0) - (1.0 - (-2.0f64).exp())).abs() < 1e-12, "upwards");
    }

    #[test]
    fn fog_between_two_distances_is_bounded() {
        let by_distance = DistanceFog::Between { begin: 1.0, end: 3.0, curve: 2.0, density: 0.75 };
        let fog = Fog { color: [1.0; 3], by_distance, by_height: None };
        assert_eq!(fog.amount(0.5, 0.0), 0.0);
        assert_eq!(fog.amount(2.0, 0.0), 0.75 / 4.0);
        assert_eq!(fog.amount(9.0, 0.0), 0.75);
        let thick = Fog {
            by_distance: DistanceFog::Between { begin: 1.0, end: 3.0, curve: 2.0, density: 9.0 },
            ..fog
        };
        assert_eq!(thick.amount(9.0, 0.0), 1.0);
        let linear = Fog { by_distance: DistanceFog::LinearInDepth { begin: 1.0, end: 3.0 }, ..fog };
        assert_eq!([0.5, 1.5, 9.0].map(|d| linear.amount(d, 0.0)), [0.0, 0.25, 1.0]);
        let squared = DistanceFog::ExponentialSquaredInDepth { density: 0.5 };
        let squared = Fog { by_distance: squared, ..fog };
        assert!((squared.amount(4.0, 0.0) - (1.0 - (-4.0f64).exp())).abs() < 1e-12);
    }
}
