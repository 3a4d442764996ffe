//! What lies under a pixel: a ray through the scene's own extinction, without a GPU.
//!
//! Where a path ends is up to chance; half of those that end at all end before the point that is picked. It is the depth that a
//! person would point at, to half a voxel where something is dense, and the same at every noise.

use lumivox_core::glam::DVec3;
use lumivox_core::{Camera, ExtinctionSpace, Ray, Scene, VolumeInstance};

/// Less than that share of the light ends in what is not seen.
const SEEN: f64 = 0.05;

/// Behind so many mean free paths nothing ends that counts: one part in a hundred million.
const OPAQUE: f64 = 18.5;

/// Steps along a ray, in the smallest edges of voxels.
const STEP: f64 = 0.5;

/// More steps than any ray through a scan takes.
const MOST_STEPS: f64 = 65_536.0;

/// What is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picked {
    /// Where, in the world's metres.
    pub world: DVec3,
    /// Metres from where the ray starts.
    pub distance: f64,
    /// Which volume of the scene it is, the densest of several there.
    pub volume: usize,
    /// Where, in that patient's millimetres (LPS).
    pub patient_mm: DVec3,
    /// The voxel that it lies in.
    pub voxel: [usize; 3],
    /// The volume's value there, between the voxels.
    pub value: f64,
}

/// A volume along a ray.
struct Crossed<'a> {
    index: usize,
    instance: &'a VolumeInstance,
    extinction: Box<dyn Fn(DVec3, f64) -> f64 + 'a>,
    /// Metres along the ray at which it enters and leaves what the clip box keeps.
    span: [f64; 2],
    /// The ray's start and direction in voxels and in the patient's millimetres, by metres along it.
    voxel: Ray,
    patient: Ray,
    /// Millimetres that extinction is measured in, by metres along the ray.
    mm_per_metre: f64,
}

impl Crossed<'_> {
    /// Extinction per metre of the ray.
    fn per_metre(&self, t: f64) -> f64 {
        let value = self.instance.volume.interpolated(self.voxel.origin + t * self.voxel.direction);
        let point = self.patient.origin + t * self.patient.direction;
        value.map_or(0.0, |value| (self.extinction)(point, value) * self.mm_per_metre)
    }

    fn covers(&self, t: f64) -> bool {
        self.span[0] <= t && t <= self.span[1]
    }
}

/// What a camera sees at a point of its image, `(0, 0)` its top left and `(1, 1)` its bottom right corner. `None` where hardly
/// anything is.
pub fn pick(scene: &Scene, camera: &Camera, uv: [f64; 2]) -> Option<Picked> {
    let ray = camera.ray(uv);
    let volumes = scene.volumes.iter().enumerate();
    let crossed: Vec<Crossed<'_>> = volumes.filter_map(|(index, it)| cross(index, it, ray)).collect();
    let begin = crossed.iter().map(|it| it.span[0]).reduce(f64::min)?;
    let end = crossed.iter().map(|it| it.span[1]).reduce(f64::max)?;
    // Metres that the ray takes through the smallest edge of a voxel.
    let edge = crossed.iter().map(|it| 1.0 / it.voxel.direction.abs().max_element()).reduce(f64::min)?;
    let step = (STEP * edge).max((end - begin) / MOST_STEPS);
    let steps = ((end - begin) / step).ceil().max(1.0);
    let step = (end - begin) / steps;
    let (mut depths, mut all) = (vec![], 0.0);
    for i in 0..steps as usize {
        let t = begin + (i as f64 + 0.5) * step;
        let own = crossed.iter().filter(|it| it.covers(t)).map(|it| it.per_metre(t)).sum::<f64>() * step;
        depths.push(own);
        all += own;
        if all > OPAQUE {
            break;
        }
    }
    let ended = 1.0 - (-all).exp();
    if ended < SEEN {
        return None;
    }
    // Half of what ends at all has ended there.
    let wanted = -(1.0 - ended / 2.0).ln();
    let mut depth = 0.0;
    let within = depths.iter().position(|own| {
        depth += own;
        depth >= wanted
    })?;
    let share = 1.0 - (depth - wanted) / depths[within].max(f64::MIN_POSITIVE);
    let distance = begin + (within as f64 + share) * step;
    let own = crossed.iter().filter(|it| it.covers(distance));
    let own = own.max_by(|a, b| a.per_metre(distance).total_cmp(&b.per_metre(distance)))?;
    let voxel = own.voxel.origin + distance * own.voxel.direction;
    let last = DVec3::from_array(own.instance.volume.dims().map(|n| n as f64 - 1.0));
    Some(Picked {
        world: ray.origin + distance * ray.direction,
        distance,
        volume: own.index,
        patient_mm: own.patient.origin + distance * own.patient.direction,
        voxel: voxel.round().clamp(DVec3::ZERO, last).to_array().map(|x| x as usize),
        value: own.instance.volume.interpolated(voxel)?,
    })
}

/// A volume as a ray meets it, if it does.
fn cross(index: usize, instance: &VolumeInstance, ray: Ray) -> Option<Crossed<'_>> {
    let through = |from_world: lumivox_core::glam::DAffine3| Ray {
        origin: from_world.transform_point3(ray.origin),
        direction: from_world.transform_vector3(ray.direction),
    };
    let patient_from_world = instance.world_from_patient.inverse();
    let patient = through(patient_from_world);
    let voxel = through(instance.volume.patient_from_voxel().inverse() * patient_from_world);
    let in_box = through(instance.world_from_box().inverse());
    let [low, high] = instance.clip_box;
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let (from, along) = (in_box.origin[axis], in_box.direction[axis]);
        if along == 0.0 {
            if !(low[axis]..=high[axis]).contains(&from) {
                return None;
            }
            continue;
        }
        let [a, b] = [low, high].map(|corner| (corner[axis] - from) / along);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    let mm_per_metre = match instance.medium.extinction_space {
        ExtinctionSpace::Volume => patient.direction.length(),
        ExtinctionSpace::World => 1e3,
    };
    let extinction = Box::new(instance.extinctions_of_values());
    (enter < leave && leave.is_finite()).then_some(Crossed {
        index,
        instance,
        extinction,
        span: [enter, leave],
        voxel,
        patient,
        mm_per_metre,
    })
}
