//! How a volume interacts with light: transfer function, phase function, scale factors.
//!
//! The extinction coefficient at a point is
//! `sigma_t = opacity(value) * density_scale * SIGMA_UNIT_PER_MM` in 1/mm **of the volume's own space**, so that
//! scaling an object in a scene never changes its look. `sigma_s = sigma_t * albedo * color(value)`.

use crate::{transfer_function::TransferFunction, volume::Volume};

/// Extinction in 1/mm of an opacity of 1 at a density scale of 1.
pub const SIGMA_UNIT_PER_MM: f64 = 1.0;

/// Largest [`Medium::density_scale`], which what is seen by an electron microscope needs. Of a volume as large as a body less
/// is taken: see [`MOST_FREE_PATHS`].
pub const MAX_DENSITY_SCALE: f64 = 1e9;

/// Mean free paths along the longest edge of a volume at most. Shorter ones vanish in the rounding of a 32-bit ray parameter,
/// and a ray would never move on: in a metre, a micrometre.
pub const MOST_FREE_PATHS: f64 = 1e6;

/// The largest density scale that a volume takes: no more than makes [`MOST_FREE_PATHS`] of it.
pub fn most_density_scale(volume: &Volume) -> f64 {
    (MOST_FREE_PATHS / (SIGMA_UNIT_PER_MM * volume.size_mm().max_element())).max(1.0)
}

/// How a value between voxel centres is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Filter {
    /// The nearest voxel's value.
    Nearest,
    /// Linear interpolation along each axis.
    #[default]
    Trilinear,
    /// Cubic B-spline: smooth in value and gradient, slightly blurred (it does not interpolate).
    Tricubic,
    /// Linear interpolation of voxels that are averaged with their neighbours, under weights of (-1, 4, 10, 4, -1) / 16
    /// along each axis; beyond the volume its nearest voxel goes on, and means keep to the range of the 27 voxels around.
    ///
    /// As fast as linear interpolation, with hardly any of the terraces that it has at every voxel: the weights' response
    /// is zero at half the sampling rate, so that voxels which alternate become their mean. Their second moment, the sum
    /// of weight times offset squared, is zero too: slopes and curvature pass unchanged, and what is thin keeps most of
    /// its strength, a sheet of one voxel 10/16, of two 14/16. Beside a step the weights alone would go up to 1/16 of it too
    /// far, which would show skin before air as muscle.
    Smooth,
}

/// In which space a millimetre of extinction is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum ExtinctionSpace {
    /// In the volume's own space: the look does not depend on the object's scale.
    #[default]
    Volume,
    /// In the world: an object twice as large is twice as opaque.
    World,
}

/// Gradient-based reflection that gives bone and skin their crisp look.
///
/// At a scattering event light is reflected by a surface instead of scattered by the phase function with probability
/// `strength * (1 - exp(-(|gradient| / gradient_per_mm)^2))` (the hybrid of Kroes, Post and Botha, *Exposure Render*,
/// PLoS ONE 2012, with a Gaussian fall-off so that noise does not act as a surface). The surface reflects a Fresnel
/// fraction (Schlick) into a lobe around the mirror direction and the rest diffusely (Lambert); both are normalised,
/// so no energy is made or lost. The gradient is that of the filter where it has one, the cubic one; of others, differences
/// over one voxel to each side.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SurfaceReflection {
    /// Largest probability of a surface event, 0 (off) to 1.
    pub strength: f64,
    /// Gradient, in value units per mm, where a surface event reaches 63% of `strength`.
    pub gradient_per_mm: f64,
    /// Width of the specular lobe, 0 (narrow: a mean cosine of 0.98) to 1 (all around).
    pub roughness: f64,
    /// Reflectance seen head-on, 0 to 1; skin and bone have about 0.04.
    pub specular: f64,
    /// How much of the medium's colour the specular lobe has: 0 none, as of skin, bone and plastic, to 1 all, as of metal.
    /// The colour is the albedo: what of the light is left, too.
    pub metallic: f64,
}

impl Default for SurfaceReflection {
    fn default() -> Self {
        Self::OFF
    }
}

impl SurfaceReflection {
    /// No surface reflection.
    pub const OFF: Self =
        Self { strength: 0.0, gradient_per_mm: 1.0, roughness: 0.5, specular: 0.0, metallic: 0.0 };

    /// The same with every number inside its documented range; what is not a number becomes the default.
    #[must_use]
    pub fn sanitized(mut self) -> Self {
        let clamp = |x: f64, lo: f64, hi: f64, or: f64| if x.is_nan() { or } else { x.clamp(lo, hi) };
        self.strength = clamp(self.strength, 0.0, 1.0, 0.0);
        self.gradient_per_mm = clamp(self.gradient_per_mm, 1e-9, 1e12, 1.0);
        self.roughness = clamp(self.roughness, 0.0, 1.0, 0.5);
        self.specular = clamp(self.specular, 0.0, 1.0, 0.0);
        self.metallic = clamp(self.metallic, 0.0, 1.0, 0.0);
        self
    }

    /// Mean cosine of the specular lobe, a Henyey-Greenstein lobe about the mirror direction.
    pub fn lobe_anisotropy(&self) -> f64 {
        (1.0 - self.roughness.clamp(0.0, 1.0).powi(2)).clamp(0.0, 0.98)
    }
}

/// A transfer function for points where the value changes so much.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GradientFunction {
    /// Gradient, in value units per mm.
    #[cfg_attr(test, schemars(transform = crate::document::ranges::PER_MM.said()))]
    pub per_mm: f64,
    /// Opacity and colour of a value there.
    pub transfer_function: TransferFunction,
}

/// Rows of a two-dimensional transfer function at most, besides the first.
pub const MOST_GRADIENTS: usize = 32;

/// Everything about a volume's look but the volume itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// Opacity and colour of a physical value.
    pub transfer_function: TransferFunction,
    /// Transfer functions for steeper places: with the one above, which is that of flat ones, rows of a two-dimensional
    /// function of value and gradient magnitude (Kniss, Kindlmann and Hansen, *Interactive Volume Rendering Using
    /// Multi-Dimensional Transfer Functions*, IEEE Visualization 2001). Linear between rows; beyond the last, it holds.
    /// Empty for a function of the value alone, which costs nothing more. At most [`MOST_GRADIENTS`].
    pub gradients: Vec<GradientFunction>,
    /// Multiplies the extinction, 1/mm per unit of opacity; 0 to [`MAX_DENSITY_SCALE`].
    pub density_scale: f64,
    /// Fraction of light that survives a scattering event, times the transfer function's colour; 0 to 1.
    pub albedo: f64,
    /// Henyey-Greenstein mean cosine g, -0.99 to 0.99; 0 is isotropic, positive is forward.
    pub anisotropy: f64,
    /// A path ends at its `max_bounces + 1`-th collision; 1 is single scattering. 1 to 1000.
    pub max_bounces: u32,
    /// How values between voxel centres are found.
    pub filter: Filter,
    /// Gradient-based surface reflection.
    pub surface: SurfaceReflection,
    /// Where a millimetre is measured.
    pub extinction_space: ExtinctionSpace,
}

impl Medium {
    /// A medium that scatters isotropically, with an albedo of 1 and up to 100 bounces.
    pub fn new(transfer_function: TransferFunction) -> Self {
        Self {
            transfer_function,
            gradients: vec![],
            density_scale: 1.0,
            albedo: 1.0,
            anisotropy: 0.0,
            max_bounces: 100,
            filter: Filter::Trilinear,
            surface: SurfaceReflection::OFF,
            extinction_space: ExtinctionSpace::Volume,
        }
    }

    /// The density scale as `volume` takes it, see [`most_density_scale`].
    pub fn density_scale_in(&self, volume: &Volume) -> f64 {
        self.density_scale.min(most_density_scale(volume))
    }

    /// Extinction in 1/mm at a physical value where it does not change.
    pub fn sigma_t_per_mm(&self, value: f64) -> f64 {
        self.transfer_function.opacity(value) * self.density_scale * SIGMA_UNIT_PER_MM
    }

    /// Opacity and colour at a value and a gradient magnitude, in value units per mm.
    pub fn opacity_and_color(&self, value: f64, gradient_per_mm: f64) -> (f64, [f64; 3]) {
        let of = |function: &TransferFunction| (function.opacity(value), function.color(value));
        let next = self.gradients.partition_point(|row| row.per_mm <= gradient_per_mm);
        let (from, low) = match next.checked_sub(1) {
            None => (0.0, of(&self.transfer_function)),
            Some(row) => (self.gradients[row].per_mm, of(&self.gradients[row].transfer_function)),
        };
        let Some(row) = self.gradients.get(next) else { return low };
        let (t, high) = ((gradient_per_mm - from) / (row.per_mm - from), of(&row.transfer_function));
        (low.0 + (high.0 - low.0) * t, std::array::from_fn(|i| low.1[i] + (high.1[i] - low.1[i]) * t))
    }

    /// The same medium with its functions widened by `window_scale`, 0.01 to 100, about the centre of that for values that do
    /// not change, and moved by `shift` in the volume's unit: a window's width and level.
    #[must_use]
    pub fn windowed(mut self, shift: f64, window_scale: f64) -> Self {
        let [scale, offset] = self.transfer_function.window(shift, window_scale);
        self.transfer_function = self.transfer_function.remapped(scale, offset);
        for row in &mut self.gradients {
            row.transfer_function = row.transfer_function.remapped(scale, offset);
        }
        self
    }

    /// The same medium with its functions stretched over `width` of the volume's units around `level`, as radiologists give a
    /// window: the function for values that do not change begins and ends there, and others go along.
    #[must_use]
    pub fn in_window(mut self, level: f64, width: f64) -> Self {
        let [low, high] = self.transfer_function.value_range();
        let is_window = level.is_finite() && width.is_finite() && width > 0.0;
        if !is_window || high <= low {
            return self;
        }
        let scale = width / (high - low);
        let offset = level - scale * (low + high) / 2.0;
        self.transfer_function = self.transfer_function.remapped(scale, offset);
        for row in &mut self.gradients {
            row.transfer_function = row.transfer_function.remapped(scale, offset);
        }
        self
    }

    /// The same medium with every number inside its documented range; what is not a number becomes the default.
    #[must_use]
    pub fn sanitized(mut self) -> Self {
        let defaults = Self::new(self.transfer_function.clone());
        let clamp = |x: f64, lo: f64, hi: f64, or: f64| if x.is_nan() { or } else { x.clamp(lo, hi) };
        self.density_scale = clamp(self.density_scale, 0.0, MAX_DENSITY_SCALE, defaults.density_scale);
        self.albedo = clamp(self.albedo, 0.0, 1.0, defaults.albedo);
        self.anisotropy = clamp(self.anisotropy, -0.99, 0.99, defaults.anisotropy);
        self.max_bounces = self.max_bounces.clamp(1, 1000);
        self.surface = self.surface.sanitized();
        self.gradients.retain(|row| row.per_mm > 0.0 && row.per_mm < 1e12);
        self.gradients.sort_by(|a, b| a.per_mm.total_cmp(&b.per_mm));
        self.gradients.dedup_by_key(|row| row.per_mm as f32);
        self.gradients.truncate(MOST_GRADIENTS);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_moves_all_functions_alike() {
        let curve = |from: f64| {
            TransferFunction::from_points(
                crate::Ease::Linear,
                &[(from, 0.0), (from + 200.0, 1.0)],
                &[(from, [1.0; 3])],
            )
            .unwrap()
        };
        let mut medium = Medium::new(curve(100.0));
        medium.gradients = vec![GradientFunction { per_mm: 10.0, transfer_function: curve(150.0) }];
        // About 200: 100 to 300 become 0 to 400, and then 50 to 450.
        let wide = medium.clone().windowed(50.0, 2.0);
        assert_eq!(wide.transfer_function.value_range(), [50.0, 450.0]);
        assert_eq!(wide.gradients[0].transfer_function.value_range(), [150.0, 550.0]);
        assert_eq!(wide.transfer_function.opacity(250.0), medium.transfer_function.opacity(200.0));
        assert_eq!(medium.clone().windowed(f64::NAN, f64::INFINITY), medium);
        // Level 40, width 400.
        let window = medium.clone().in_window(40.0, 400.0);
        assert_eq!(window.transfer_function.value_range(), [-160.0, 240.0]);
        assert_eq!(window.gradients[0].transfer_function.value_range(), [-60.0, 340.0]);
        assert_eq!(medium.clone().in_window(40.0, 0.0), medium);
    }
}
