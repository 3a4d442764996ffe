//! The light around a scene: radiance from every direction.
//!
//! Whatever its source, an environment becomes one equirectangular [`EnvironmentMap`], so that every host has one
//! code path and one importance sampler.

use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

/// An equirectangular map of radiance, linear RGB.
///
/// Row 0 is straight up (+y), the last row straight down; the centre column looks along -z, a quarter to its right
/// along +x. Between texel centres radiance is bilinear, wrapping around horizontally and clamping at the poles.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    /// Texels around the horizon.
    pub width: usize,
    /// Texels from pole to pole.
    pub height: usize,
    /// `width * height` texels, rows from the top.
    pub texels: Vec<[f32; 3]>,
    file: Option<Arc<Path>>,
}

impl EnvironmentMap {
    /// A map from `width * height` finite, non-negative texels, rows from the top.
    ///
    /// # Errors
    /// Says which texel is not a radiance, or that their number is wrong.
    pub fn new(width: usize, height: usize, texels: Vec<[f32; 3]>) -> Result<Self, String> {
        if width == 0 || height == 0 || width.checked_mul(height) != Some(texels.len()) {
            return Err(format!(
                "an environment map of {width} x {height} cannot have {} texels",
                texels.len()
            ));
        }
        if let Some(i) = texels.iter().position(|t| t.iter().any(|c| !c.is_finite() || *c < 0.0)) {
            return Err(format!("texel ({}, {}) is {:?}, not a radiance", i % width, i / width, texels[i]));
        }
        Ok(Self { width, height, texels, file: None })
    }

    /// A map that samples `radiance(direction)` at texel centres; what is no radiance becomes 0.
    pub fn from_fn(width: usize, height: usize, radiance: impl Fn(DVec3) -> [f64; 3]) -> Self {
        let texels = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| {
                let uv = [(x as f64 + 0.5) / width as f64, (y as f64 + 0.5) / height as f64];
                radiance(direction_from_uv(uv)).map(|c| if c.is_finite() { c.max(0.0) as f32 } else { 0.0 })
            })
            .collect();
        Self { width, height, texels, file: None }
    }

    /// The file that it was read from, if that is known.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// The same map, said to be read from a file.
    #[must_use]
    pub fn with_file(mut self, file: &Path) -> Self {
        self.file = Some(file.into());
        self
    }

    /// Bilinear radiance from a unit direction.
    pub fn radiance(&self, direction: DVec3) -> [f64; 3] {
        let [u, v] = uv_from_direction(direction);
        let (x, y) = (u * self.width as f64 - 0.5, v * self.height as f64 - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let texel = |dx: i64, dy: i64| {
            let column = (x.floor() as i64 + dx).rem_euclid(self.width as i64) as usize;
            let row = (y.floor() as i64 + dy).clamp(0, self.height as i64 - 1) as usize;
            self.texels[row * self.width + column].map(f64::from)
        };
        let (a, b, c, d) = (texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1));
        std::array::from_fn(|i| {
            (a[i] * (1.0 - fx) + b[i] * fx) * (1.0 - fy) + (c[i] * (1.0 - fx) + d[i] * fx) * fy
        })
    }
}

/// Map coordinates in `[0, 1]` of a unit direction.
pub fn uv_from_direction(d: DVec3) -> [f64; 2] {
    [d.x.atan2(-d.z) / TAU + 0.5, d.y.clamp(-1.0, 1.0).acos() / PI]
}

/// The unit direction of map coordinates in `[0, 1]`.
pub fn direction_from_uv([u, v]: [f64; 2]) -> DVec3 {
    let (sin_phi, cos_phi) = ((u - 0.5) * TAU).sin_cos();
    let (sin_theta, cos_theta) = (v * PI).sin_cos();
    DVec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta)
}

/// Where an environment's radiance comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentSource {
    /// The same radiance from everywhere.
    Uniform([f64; 3]),
    /// Blends from nadir over horizon to zenith with the sine of the elevation.
    Gradient {
        /// Radiance from straight up.
        zenith: [f64; 3],
        /// Radiance from the horizon.
        horizon: [f64; 3],
        /// Radiance from straight down.
        nadir: [f64; 3],
    },
    /// A photographer's studio: a warm key light from the upper left, a cool fill from the right, two rim lights
    /// behind and a dim room.
    Studio,
    /// A map, typically a photographed HDR panorama.
    Map(Arc<EnvironmentMap>),
}

/// The light around a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Radiance before rotation and strength.
    pub source: EnvironmentSource,
    /// Turns the light around the vertical axis, in radians; positive turns it from +z to +x, as an
    /// [`Orbit`](crate::Orbit)'s azimuth turns a camera.
    pub rotation: f64,
    /// Multiplies the radiance.
    pub strength: f64,
}

impl Default for Environment {
    fn default() -> Self {
        Self { source: EnvironmentSource::Studio, rotation: 0.0, strength: 1.0 }
    }
}

impl Environment {
    /// White light of radiance `strength` from everywhere.
    pub fn uniform(strength: f64) -> Self {
        Self { source: EnvironmentSource::Uniform([1.0; 3]), rotation: 0.0, strength }
    }

    /// The file of its map, where that is known.
    pub fn file(&self) -> Option<&Path> {
        match &self.source {
            EnvironmentSource::Map(map) => map.file(),
            _ => None,
        }
    }

    /// Whether another is the same, maps by their identity.
    pub fn is_same(&self, other: &Self) -> bool {
        let same_source = match (&self.source, &other.source) {
            (EnvironmentSource::Map(a), EnvironmentSource::Map(b)) => Arc::ptr_eq(a, b),
            (a, b) => a == b,
        };
        same_source && self.rotation == other.rotation && self.strength == other.strength
    }

    /// Radiance that arrives from a unit world direction.
    pub fn radiance(&self, direction: DVec3) -> [f64; 3] {
        let (sin, cos) = self.rotation.sin_cos();
        let d = DVec3::new(
            direction.x * cos - direction.z * sin,
            direction.y,
            direction.x * sin + direction.z * cos,
        );
        let radiance = match &self.source {
            EnvironmentSource::Uniform(radiance) => *radiance,
            EnvironmentSource::Gradient { zenith, horizon, nadir } => {
                let end = if d.y > 0.0 { zenith } else { nadir };
                std::array::from_fn(|i| horizon[i] + (end[i] - horizon[i]) * d.y.abs())
            }
            EnvironmentSource::Studio => studio(d),
            EnvironmentSource::Map(map) => map.radiance(d),
        };
        radiance.map(|c| c * self.strength)
    }

    /// The unrotated source as a map: the source's own, or one fine enough for what it holds.
    pub fn to_map(&self) -> Arc<EnvironmentMap> {
        let unturned = Environment { source: self.source.clone(), rotation: 0.0, strength: 1.0 };
        let bake = |width, height| Arc::new(EnvironmentMap::from_fn(width, height, |d| unturned.radiance(d)));
        match &self.source {
            EnvironmentSource::Map(map) => map.clone(),
            EnvironmentSource::Uniform(_) => bake(1, 1),
            EnvironmentSource::Gradient { .. } => bake(4, 256),
            EnvironmentSource::Studio => bake(512, 256),
        }
    }

    /// Whether the same radiance comes from everywhere.
    pub fn is_uniform(&self) -> bool {
        match &self.source {
            EnvironmentSource::Uniform(_) => true,
            EnvironmentSource::Map(map) => map.texels.iter().all(|t| *t == map.texels[0]),
            _ => false,
        }
    }
}

/// A soft light panel: full radiance inside `half_angle`, fading over `soft`, both in radians from its centre.
struct Panel {
    azimuth: f64,
    elevation: f64,
    half_angle: f64,
    soft: f64,
    radiance: [f64; 3],
}

/// The default studio in its own frame: the camera stands at +z.
fn studio(d: DVec3) -> [f64; 3] {
    const PANELS: [Panel; 4] = [
        // Key: large, warm, upper left of the camera.
        Panel { azimuth: -0.85, elevation: 0.75, half_angle: 0.32, soft: 0.22, radiance: [13.0, 11.6, 9.9] },
        // Fill: wide, cool, dim, to the right.
        Panel { azimuth: 1.15, elevation: 0.15, half_angle: 0.40, soft: 0.45, radiance: [0.95, 1.15, 1.5] },
        // Rims: behind the subject on both sides; they draw its outline.
        Panel { azimuth: 2.45, elevation: 0.55, half_angle: 0.22, soft: 0.15, radiance: [11.0, 12.4, 15.0] },
        Panel { azimuth: -2.55, elevation: 0.20, half_angle: 0.18, soft: 0.15, radiance: [7.5, 6.4, 5.2] },
    ];
    let up = 0.5 + 0.5 * d.y;
    let mut radiance = [0.10 + 0.16 * up, 0.11 + 0.18 * up, 0.13 + 0.22 * up];
    for panel in &PANELS {
        let (sin_a, cos_a) = panel.azimuth.sin_cos();
        let (sin_e, cos_e) = panel.elevation.sin_cos();
        let angle = d.dot(DVec3::new(sin_a * cos_e, sin_e, cos_a * cos_e)).clamp(-1.0, 1.0).acos();
        let t = ((panel.half_angle + panel.soft - angle) / panel.soft).clamp(0.0, 1.0);
        let weight = t * t * (3.0 - 2.0 * t);
        for (sum, light) in radiance.iter_mut().zip(panel.radiance) {
            *sum += weight * light;
        }
    }
    radiance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uv_and_direction_are_inverse() {
        for uv in [[0.1, 0.2], [0.5, 0.5], [0.9, 0.7]] {
            let back = uv_from_direction(direction_from_uv(uv));
            assert!((back[0] - uv[0]).abs() < 1e-12 && (back[1] - uv[1]).abs() < 1e-12);
        }
        assert!(direction_from_uv([0.5, 0.5]).distance(DVec3::NEG_Z) < 1e-12);
        assert!(direction_from_uv([0.75, 0.5]).distance(DVec3::X) < 1e-12);
    }

    #[test]
    fn rotation_turns_light_as_an_orbit_turns_a_camera() {
        let front = EnvironmentMap::from_fn(64, 32, |d| [if d.z > 0.9 { 1.0 } else { 0.0 }; 3]);
        let mut light =
            Environment { source: EnvironmentSource::Map(Arc::new(front)), rotation: 0.0, strength: 2.0 };
        assert_eq!(light.radiance(DVec3::Z), [2.0; 3]);
        light.rotation = PI / 2.0;
        assert_eq!(light.radiance(DVec3::X), [2.0; 3]);
        assert_eq!(light.radiance(DVec3::Z), [0.0; 3]);
    }

    #[test]
    fn maps_that_are_not_radiance_are_refused() {
        assert!(EnvironmentMap::new(2, 1, vec![[0.0; 3]]).is_err());
        assert!(EnvironmentMap::new(1, 1, vec![[-1.0, 0.0, 0.0]]).is_err());
        assert!(EnvironmentMap::new(1, 1, vec![[f32::NAN, 0.0, 0.0]]).is_err());
    }
}
