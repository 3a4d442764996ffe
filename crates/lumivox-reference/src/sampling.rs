//! Directions: the Henyey-Greenstein lobe and the cosine-weighted hemisphere.

use std::f64::consts::{PI, TAU};

use lumivox_core::glam::DVec3;

/// Henyey-Greenstein density per steradian of a direction whose cosine with the lobe's axis is `cos_theta`.
///
/// Henyey and Greenstein, *Diffuse radiation in the galaxy*, ApJ 93, 1941, equation 2. The cosine is between two
/// directions of *travel*, so `g > 0` scatters forward and the mean cosine is `g`.
pub fn henyey_greenstein(cos_theta: f64, g: f64) -> f64 {
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos_theta).powf(1.5))
}

/// A direction with the density [`henyey_greenstein`] around a unit `axis`, from two uniform numbers.
pub fn sample_henyey_greenstein(axis: DVec3, g: f64, [u, v]: [f64; 2]) -> DVec3 {
    // The inverse of the cumulative distribution divides by g; under 1e-6 the lobe is isotropic to six digits.
    let cos_theta = if g.abs() < 1e-6 {
        2.0 * u - 1.0
    } else {
        (1.0 + g * g - ((1.0 - g * g) / (1.0 - g + 2.0 * g * u)).powi(2)) / (2.0 * g)
    };
    around(axis, cos_theta.clamp(-1.0, 1.0), v)
}

/// Lambert's density per steradian, `cos / pi` above the surface, of a direction with that cosine to the normal.
pub fn cosine_hemisphere(cos_theta: f64) -> f64 {
    cos_theta.max(0.0) / PI
}

/// A direction with the density [`cosine_hemisphere`] around a unit `normal`, from two uniform numbers.
pub fn sample_cosine_hemisphere(normal: DVec3, [u, v]: [f64; 2]) -> DVec3 {
    around(normal, (1.0 - u).sqrt(), v)
}

/// The direction at `cos_theta` to a unit `axis` and at the fraction `v` of the way around it.
fn around(axis: DVec3, cos_theta: f64, v: f64) -> DVec3 {
    let (x, y) = axis.any_orthonormal_pair();
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    let (sin_phi, cos_phi) = (TAU * v).sin_cos();
    // Paths of a thousand bounces add up the rounding of the frame, hence the normalisation.
    (x * (sin_theta * cos_phi) + y * (sin_theta * sin_phi) + axis * cos_theta).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use lumivox_testing::chi_square::{SphereTest, Verdict};

    const ANISOTROPIES: [f64; 7] = [-0.9, -0.5, 0.0, 1e-7, 0.3, 0.8, 0.95];

    #[test]
    fn henyey_greenstein_integrates_to_one_and_has_mean_cosine_g() {
        for g in ANISOTROPIES {
            let n = 400_000;
            let (mut sum, mut mean) = (0.0, 0.0);
            for i in 0..n {
                let cos = -1.0 + 2.0 * (i as f64 + 0.5) / n as f64;
                let weight = henyey_greenstein(cos, g) * TAU * 2.0 / n as f64;
                sum += weight;
                mean += weight * cos;
            }
            assert!((sum - 1.0).abs() < 1e-6 && (mean - g).abs() < 1e-6, "g {g}: {sum} {mean}");
        }
    }

    #[test]
    fn sampled_henyey_greenstein_has_mean_cosine_g() {
        let axis = DVec3::new(1.0, -2.0, 0.5).normalize();
        for (i, g) in ANISOTROPIES.into_iter().enumerate() {
            let mut rng = Rng::new(i as u64, 0, 0);
            let n = 100_000;
            let cosines: Vec<f64> =
                (0..n).map(|_| sample_henyey_greenstein(axis, g, rng.uniform_2d()).dot(axis)).collect();
            let mean = cosines.iter().sum::<f64>() / n as f64;
            let variance = cosines.iter().map(|c| (c - mean).powi(2)).sum::<f64>() / n as f64;
            let error = (variance / n as f64).sqrt();
            assert!((mean - g).abs() < 4.5 * error, "g {g}: {mean} +- {error}");
        }
    }

    #[test]
    fn samplers_follow_their_densities() {
        let axis = DVec3::new(0.3, 0.9, -0.4).normalize();
        let test = SphereTest { tests: ANISOTROPIES.len() + 1, ..SphereTest::default() };
        for (i, g) in ANISOTROPIES.into_iter().enumerate() {
            let mut rng = Rng::new(i as u64, 1, 0);
            let result = test.run(
                |d| henyey_greenstein(d.dot(axis), g),
                || sample_henyey_greenstein(axis, g, rng.uniform_2d()),
            );
            assert_eq!(result.verdict, Verdict::Accepted, "g {g}: {result}");
        }
        let mut rng = Rng::new(0, 2, 0);
        let result =
            test.run(|d| cosine_hemisphere(d.dot(axis)), || sample_cosine_hemisphere(axis, rng.uniform_2d()));
        assert_eq!(result.verdict, Verdict::Accepted, "{result}");
    }
}
