//! Answers without a random number, for the integrator to be held against.
//!
//! Two kinds: formulas for media simple enough to have one, and integrals over any scene by the midpoint rule.

use std::f64::consts::PI;

use lumivox_core::glam::DVec3;
use lumivox_core::{Ray, Scene};
use rayon::prelude::*;

use crate::lights::{beam, lights};
use crate::medium::{PlacedMedium, place};
use crate::scattering::Collision;

/// Transmittance of a homogeneous medium, `exp(-sigma_t * distance)`: Beer and Lambert's law.
pub fn slab_transmittance(sigma_t: f64, distance: f64) -> f64 {
    (-sigma_t * distance).exp()
}

/// Transmittance of a scene between two world points, each volume's part in `steps` steps of the midpoint rule.
pub fn transmittance(scene: &Scene, a: DVec3, b: DVec3, steps: usize) -> f64 {
    let distance = a.distance(b);
    if distance == 0.0 {
        return 1.0;
    }
    let ray = Ray { origin: a, direction: (b - a) / distance };
    (-optical_depth(&place(scene), &ray, distance, steps)).exp()
}

/// Optical depth along a ray up to `t_max` metres: the sum over media of the integral of sigma_t.
fn optical_depth(media: &[PlacedMedium], ray: &Ray, t_max: f64, steps: usize) -> f64 {
    let along = |medium: &PlacedMedium| {
        let Some([near, far]) = medium.interval(ray) else { return 0.0 };
        let step = (far.min(t_max) - near).max(0.0) / steps as f64;
        let sum: f64 = (0..steps)
            .map(|i| medium.sigma_t_per_mm(ray.origin + (near + (i as f64 + 0.5) * step) * ray.direction))
            .sum();
        sum * step * medium.mm_per_metre(ray.direction)
    };
    media.iter().map(along).sum()
}

/// How finely [`single_scattering`] integrates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Steps {
    /// Steps along the primary ray, and as many up to each of them.
    pub primary: usize,
    /// Steps along every ray to the light.
    pub shadow: usize,
    /// Directions from pole to pole; there are twice as many around. Also the rows and columns of parts of a light.
    pub polar: usize,
}

/// Radiance along a camera ray from paths of exactly one bounce (`max_bounces` of 1), under the environment's own
/// formula and the engine's lights.
///
/// The integral form of the radiative transfer equation (Novák et al. 2018, equation 3) cut off after one scattering:
/// transmittance * sigma_t * (what a collision returns of the light around it), along the ray.
pub fn single_scattering(scene: &Scene, ray: &Ray, steps: Steps) -> [f64; 3] {
    let media = place(scene);
    let mut radiance = [0.0; 3];
    for medium in &media {
        let Some([near, far]) = medium.interval(ray) else { continue };
        let step = (far - near) / steps.primary as f64;
        let terms: Vec<[f64; 3]> = (0..steps.primary)
            .into_par_iter()
            .map(|i| {
                let t = near + (i as f64 + 0.5) * step;
                let point = ray.origin + t * ray.direction;
                if medium.sigma_t_per_mm(point) == 0.0 {
                    return [0.0; 3];
                }
                let gets_through = (-optical_depth(&media, ray, t, steps.primary)).exp();
                let mut sum = [0.0; 3];
                for part in medium.parts(point).iter().filter(|part| part.sigma_t_per_mm > 0.0) {
                    let seen = part.sigma_t_per_mm * medium.mm_per_metre(ray.direction) * step * gets_through;
                    let collision = Collision::new(medium, part, ray.direction);
                    let around = scattered(scene, &media, &collision, point, steps);
                    let from_lights =
                        scattered_of_lights(scene, &media, medium.layers(), &collision, point, steps);
                    sum = std::array::from_fn(|i| sum[i] + (around[i] + from_lights[i]) * seen);
                }
                sum
            })
            .collect();
        for term in terms {
            radiance = std::array::from_fn(|i| radiance[i] + term[i]);
        }
    }
    radiance
}

/// What a collision returns of the light that reaches it unscattered.
fn scattered(
    scene: &Scene,
    media: &[PlacedMedium],
    collision: &Collision,
    point: DVec3,
    steps: Steps,
) -> [f64; 3] {
    let around = 2 * steps.polar;
    let solid_angle = 4.0 * PI / (steps.polar * around) as f64;
    let mut sum = [0.0; 3];
    for i in 0..steps.polar {
        // Equal steps in the cosine are equal solid angles.
        let y = 1.0 - 2.0 * (i as f64 + 0.5) / steps.polar as f64;
        let r = (1.0 - y * y).sqrt();
        for j in 0..around {
            let (sin, cos) = (2.0 * PI * (j as f64 + 0.5) / around as f64).sin_cos();
            let wi = DVec3::new(r * sin, y, r * cos);
            let shadow = Ray { origin: point, direction: wi };
            let visible = (-optical_depth(media, &shadow, f64::INFINITY, steps.shadow)).exp();
            let (light, f) = (scene.environment.radiance(wi), collision.evaluate(wi));
            sum = std::array::from_fn(|c| sum[c] + f[c] * light[c] * visible * solid_angle);
        }
    }
    sum
}

/// What a collision of a medium on those layers returns of the lights: each at the middles of equal parts of it.
fn scattered_of_lights(
    scene: &Scene,
    media: &[PlacedMedium],
    layers: u32,
    collision: &Collision,
    point: DVec3,
    steps: Steps,
) -> [f64; 3] {
    let n = steps.polar;
    let mut sum = [0.0; 3];
    for light in lights(scene).iter().filter(|light| light.layers & layers != 0) {
        for part in 0..n * n {
            let uv = [part % n, part / n].map(|i| (i as f64 + 0.5) / n as f64);
            let beam = beam(light, point, uv);
            let shadow = Ray { origin: point, direction: beam.wi };
            let visible = (-optical_depth(media, &shadow, beam.distance, steps.shadow)).exp();
            let f = collision.evaluate(beam.wi);
            sum = std::array::from_fn(|c| sum[c] + f[c] * beam.irradiance[c] * visible / (n * n) as f64);
        }
    }
    sum
}

/// Radiance of once-scattered light that leaves a homogeneous, isotropic, infinitely wide slab at right angles, under
/// unit light from everywhere.
///
/// At optical depth x a fraction `(E2(x) + E2(thickness - x)) / 2` of the sphere's light arrives, E2 the exponential
/// integral (Chandrasekhar, *Radiative Transfer*, 1950, appendix I).
pub fn slab_single_scattering(albedo: f64, optical_thickness: f64) -> f64 {
    let n = 2000;
    let step = optical_thickness / n as f64;
    let sum: f64 = (0..n)
        .map(|i| {
            let x = (i as f64 + 0.5) * step;
            (-x).exp() * (exponential_integral_2(x) + exponential_integral_2(optical_thickness - x)) / 2.0
        })
        .sum();
    albedo * sum * step
}

/// `E2(x)`, the integral of `exp(-x / mu)` over mu in `[0, 1]`.
fn exponential_integral_2(x: f64) -> f64 {
    let n = 1000;
    (0..n).map(|i| (-x * n as f64 / (i as f64 + 0.5)).exp()).sum::<f64>() / n as f64
}

/// Radiance that an isotropic half-space returns at cosine `mu` to its normal, all orders of scattering, under unit
/// light from everywhere: `1 - sqrt(1 - albedo) * H(mu)`.
///
/// Chandrasekhar, *Radiative Transfer*, 1950, chapter V: the fraction of a beam at `mu` that the half-space reflects,
/// read backwards by reciprocity.
pub fn half_space_radiance(albedo: f64, mu: f64) -> f64 {
    1.0 - (1.0 - albedo).sqrt() * chandrasekhar_h(albedo, mu)
}

/// Radiance that an isotropic half-space returns at cosine `mu` to its normal, all orders of scattering, of a beam of
/// unit irradiance across it that comes in at cosine `mu_0`: `albedo / (4 pi) * mu_0 / (mu + mu_0) * H(mu) H(mu_0)`.
///
/// Chandrasekhar, *Radiative Transfer*, 1950: the law of diffuse reflection by a half-space, chapter V's H.
pub fn half_space_beam_radiance(albedo: f64, mu: f64, mu_0: f64) -> f64 {
    let h = chandrasekhar_h(albedo, mu) * chandrasekhar_h(albedo, mu_0);
    albedo / (4.0 * PI) * mu_0 / (mu + mu_0) * h
}

/// The part of [`half_space_beam_radiance`] that a slab scatters once.
pub fn slab_beam_single_scattering(albedo: f64, optical_thickness: f64, mu: f64, mu_0: f64) -> f64 {
    let lost = 1.0 - (-optical_thickness * (1.0 / mu + 1.0 / mu_0)).exp();
    albedo / (4.0 * PI) * mu_0 / (mu + mu_0) * lost
}

/// Chandrasekhar's H function for isotropic scattering, by iterating
/// `1 / H(mu) = sqrt(1 - albedo) + albedo/2 * integral of m H(m) / (mu + m) over m in [0, 1]`.
fn chandrasekhar_h(albedo: f64, mu: f64) -> f64 {
    let n = 500;
    let nodes: Vec<f64> = (0..n).map(|i| (i as f64 + 0.5) / n as f64).collect();
    let next = |h: &[f64], mu: f64| {
        let integral: f64 = nodes.iter().zip(h).map(|(m, h)| m * h / (mu + m)).sum::<f64>() / n as f64;
        1.0 / ((1.0 - albedo).sqrt() + albedo / 2.0 * integral)
    };
    let mut h = vec![1.0; n];
    loop {
        let updated: Vec<f64> = nodes.iter().map(|&mu| next(&h, mu)).collect();
        let change = h.iter().zip(&updated).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        h = updated;
        if change < 1e-9 {
            return next(&h, mu);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_integral_has_its_tabulated_values() {
        // Abramowitz and Stegun, table 5.1: E2(0) = 1, E2(0.5) = 0.3266439, E2(1) = 0.1484955, E2(2) = 0.0375343.
        for (x, e2) in [(0.0, 1.0), (0.5, 0.326_643_9), (1.0, 0.148_495_5), (2.0, 0.037_534_3)] {
            assert!((exponential_integral_2(x) - e2).abs() < 1e-5, "{x}");
        }
    }

    #[test]
    fn h_has_its_known_moment_and_limits() {
        for albedo in [0.3, 0.9, 0.98] {
            let n = 25;
            let moment: f64 =
                (0..n).map(|i| chandrasekhar_h(albedo, (i as f64 + 0.5) / n as f64)).sum::<f64>() / n as f64;
            // Radiative Transfer, chapter V, theorem 1.
            let expected = 2.0 / albedo * (1.0 - (1.0 - albedo).sqrt());
            assert!((moment - expected).abs() < 1e-3, "{albedo}: {moment} {expected}");
        }
        assert!((chandrasekhar_h(1e-9, 0.7) - 1.0).abs() < 1e-6);
        // Light that grazes the surface is scattered once at most: H(0) = 1.
        assert!((chandrasekhar_h(0.8, 1e-12) - 1.0).abs() < 1e-3);
    }
}
