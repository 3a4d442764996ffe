//! The integrator: analog delta tracking, one path per sample.
//!
//! Woodcock et al., *Techniques used in the GEM code for Monte Carlo neutronics calculations*, 1965, as told by
//! Novák, Georgiev, Hanika and Jarosz, *Monte Carlo Methods for Volumetric Light Transport Simulation*, CGF 37(2),
//! 2018, section 5.1. A path does what a photon would do, backwards: it flies, collides, scatters and at last escapes
//! to the light. Nothing is weighted but by albedo, so there is no density that could be wrong. The engine's lights
//! have no extent to escape to: each collision connects to each of them.

use lumivox_core::glam::DVec3;
use lumivox_core::{Environment, EnvironmentSource, PerspectiveCamera, Ray, Scene};
use rayon::prelude::*;

use crate::image::{PixelSums, ReferenceImage};
use crate::lights::{beam, lights};
use crate::medium::{PlacedMedium, place};
use crate::rng::Rng;
use crate::scattering::Collision;

/// How the environment is looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EnvironmentLookup {
    /// In its equirectangular map, as every host sees it: an image is then compared under identical light.
    #[default]
    Map,
    /// By its formula, where it has one.
    Exact,
}

/// What to render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReferenceSettings {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Paths per pixel; at least 2, or no variance can be known.
    pub samples: u32,
    /// Images of different seeds are independent.
    pub seed: u64,
    /// How the environment is looked up.
    pub environment: EnvironmentLookup,
}

impl Default for ReferenceSettings {
    fn default() -> Self {
        Self { width: 64, height: 64, samples: 256, seed: 0, environment: EnvironmentLookup::Map }
    }
}

/// Renders a scene without its background; rows are shared among threads, the image is the same for any number.
pub fn render(scene: &Scene, camera: &PerspectiveCamera, settings: &ReferenceSettings) -> ReferenceImage {
    let (media, lights) = (place(scene), lights(scene));
    let environment = match settings.environment {
        EnvironmentLookup::Exact => scene.environment.clone(),
        EnvironmentLookup::Map => {
            Environment { source: EnvironmentSource::Map(scene.environment.to_map()), ..scene.environment }
        }
    };
    let (width, height) = (settings.width, settings.height);
    let forward = -camera.world_from_camera.matrix3.z_axis.normalize();
    let eye = camera.world_from_camera.translation;
    let pixels: Vec<PixelSums> = (0..width * height)
        .into_par_iter()
        .with_min_len(width.max(1))
        .map(|pixel| {
            let (x, y) = ((pixel % width) as f64, (pixel / width) as f64);
            let mut sums = PixelSums::default();
            for sample in 0..settings.samples {
                let mut rng = Rng::new(settings.seed, pixel as u64, sample);
                // The pixel's filter is a box: uniform over its square.
                let uv = [(x + rng.uniform()) / width as f64, (y + rng.uniform()) / height as f64];
                let ray = camera.ray(uv, width as f64 / height as f64);
                let path = trace(&media, &environment, &lights, ray, &mut rng);
                sums.add(&path, |point| (point - eye).dot(forward));
            }
            sums
        })
        .collect();
    ReferenceImage::new(width, height, settings.samples, &pixels)
}

/// One path from the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathSample {
    /// Radiance that arrives at the camera; zero if nothing was hit, since the background is hidden.
    pub radiance: [f64; 3],
    /// Where and what the path first collided with.
    pub first_hit: Option<FirstHit>,
}

/// The first collision of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstHit {
    /// Where, in the world.
    pub point: DVec3,
    /// Albedo there, colour included.
    pub albedo: [f64; 3],
    /// Unit normal towards the viewer, or zero.
    pub normal: DVec3,
}

/// Traces one path to its end.
pub fn trace(
    media: &[PlacedMedium],
    environment: &Environment,
    lights: &[lumivox_core::Light],
    ray: Ray,
    rng: &mut Rng,
) -> PathSample {
    let Some((medium, t)) = nearest_collision(media, &ray, rng) else { return PathSample::default() };
    let point = ray.origin + t * ray.direction;
    let collision = Collision::new(medium, &medium.pick(point, rng.uniform()), ray.direction);
    let first_hit = FirstHit { point, albedo: collision.albedo, normal: collision.normal };
    let world = World { media, environment, lights };
    let radiance = world.sent_on(medium, point, &collision, rng);
    PathSample { radiance, first_hit: Some(first_hit) }
}

/// What a point of a medium sends on diffusely, by its phase function or by a surface, and not by the surface's mirroring.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DiffuseSample {
    /// Radiance, an estimate, towards who looks along the direction in which the point was met.
    pub light: [f64; 3],
    /// The part of all light that is sent on so, per colour.
    pub color: [f64; 3],
}

/// One estimate of what a point sends on diffusely that was met by a ray in a direction of travel.
pub fn sent_diffusely<'w, 'v>(
    media: &'w [PlacedMedium<'v>],
    environment: &Environment,
    lights: &[lumivox_core::Light],
    medium: &'w PlacedMedium<'v>,
    point: DVec3,
    travel: DVec3,
    rng: &mut Rng,
) -> DiffuseSample {
    let mut collision = Collision::new(medium, &medium.pick(point, rng.uniform()), travel);
    let color = collision.diffuse_color();
    // A surface that mirrors, but in which nothing is to be seen.
    collision.gloss = [0.0; 3];
    let world = World { media, environment, lights };
    DiffuseSample { light: world.sent_on(medium, point, &collision, rng), color }
}

/// What paths are traced in.
struct World<'w, 'v> {
    media: &'w [PlacedMedium<'v>],
    environment: &'w Environment,
    lights: &'w [lumivox_core::Light],
}

impl<'w, 'v> World<'w, 'v> {
    /// What the first collision of a path sends on to where the path came from.
    fn sent_on(
        &self,
        mut medium: &'w PlacedMedium<'v>,
        mut point: DVec3,
        first: &Collision,
        rng: &mut Rng,
    ) -> [f64; 3] {
        let mut collision = *first;
        let mut radiance = [0.0; 3];
        let mut throughput = [1.0; 3];
        let mut bounces = 1;
        loop {
            if bounces > medium.medium().max_bounces {
                return radiance;
            }
            // No path can hit the engine's lights: every collision asks each of them.
            for light in self.lights.iter().filter(|light| light.layers & medium.layers() != 0) {
                let beam = beam(light, point, rng.uniform_2d());
                let shadow = Ray { origin: point, direction: beam.wi };
                if beam.irradiance != [0.0; 3] && is_clear(self.media, &shadow, beam.distance, rng) {
                    let f = collision.evaluate(beam.wi);
                    radiance =
                        std::array::from_fn(|i| radiance[i] + throughput[i] * beam.irradiance[i] * f[i]);
                }
            }
            let (wi, weight) = collision.sample(rng);
            throughput = std::array::from_fn(|i| throughput[i] * weight[i]);
            // Nothing can come back from black.
            if throughput == [0.0; 3] {
                return radiance;
            }
            let ray = Ray { origin: point, direction: wi };
            let Some((next, t)) = nearest_collision(self.media, &ray, rng) else {
                let light = self.environment.radiance(wi);
                return std::array::from_fn(|i| radiance[i] + throughput[i] * light[i]);
            };
            (medium, point) = (next, ray.origin + t * ray.direction);
            collision = Collision::new(medium, &medium.pick(point, rng.uniform()), wi);
            bounces += 1;
        }
    }
}

/// Whether light gets through to `t_max`, as a photon would: an unbiased estimate of the transmittance, 0 or 1.
fn is_clear(media: &[PlacedMedium], ray: &Ray, t_max: f64, rng: &mut Rng) -> bool {
    media.iter().all(|medium| free_flight(medium, ray, t_max, rng).is_none())
}

/// The collision that comes first: every medium has its own free flight, since independent Poisson processes superpose.
pub fn nearest_collision<'m, 'v>(
    media: &'m [PlacedMedium<'v>],
    ray: &Ray,
    rng: &mut Rng,
) -> Option<(&'m PlacedMedium<'v>, f64)> {
    let mut nearest = None;
    let mut t_max = f64::INFINITY;
    for medium in media {
        if let Some(t) = free_flight(medium, ray, t_max, rng) {
            t_max = t;
            nearest = Some((medium, t));
        }
    }
    nearest
}

/// Delta tracking in one medium: the distance in metres to its first real collision before `t_max`.
fn free_flight(medium: &PlacedMedium, ray: &Ray, t_max: f64, rng: &mut Rng) -> Option<f64> {
    let [near, far] = medium.interval(ray)?;
    let sigma_maj = medium.sigma_maj_per_mm() * medium.mm_per_metre(ray.direction);
    if sigma_maj == 0.0 {
        return None;
    }
    let end = far.min(t_max);
    let mut t = near;
    loop {
        // 1 - u lies in (0, 1], where the logarithm is finite.
        t -= (1.0 - rng.uniform()).ln() / sigma_maj;
        if t >= end {
            return None;
        }
        let sigma_t = medium.sigma_t_per_mm(ray.origin + t * ray.direction);
        if rng.uniform() * medium.sigma_maj_per_mm() < sigma_t {
            return Some(t);
        }
    }
}
