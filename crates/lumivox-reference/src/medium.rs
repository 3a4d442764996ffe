//! A volume at its place in the world: filtered values, gradients, extinction.
//!
//! Everything is evaluated from its definition at every call. No table, no cell, no footprint: what these functions
//! return is what the words in `lumivox-core` mean.

use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::{ExtinctionSpace, Filter, Medium, Ray, Scene, SurfaceReflection, Volume, VolumeInstance};

use crate::classification::{Classification, largest_sigma_t_per_mm, sigma_per_opacity};

/// A volume, its medium, and the transforms that its place implies.
#[derive(Clone, Debug)]
pub struct PlacedMedium<'a> {
    volume: &'a Volume,
    medium: Medium,
    voxel_from_world: DAffine3,
    box_from_world: DAffine3,
    patient_from_world: DMat3,
    clip_box: [DVec3; 2],
    layers: u32,
    sigma_maj_per_mm: f64,
    classification: Classification<'a>,
}

/// What is at a point of one label's, or of none: media are mixtures of these.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Its share of the extinction there, in 1/mm.
    pub sigma_t_per_mm: f64,
    /// Linear RGB.
    pub color: [f64; 3],
    /// How it reflects.
    pub surface: SurfaceReflection,
    /// The gradient of the value, in value units per mm of patient space.
    pub gradient_per_mm: DVec3,
    /// From the nearest cut by a clip shape in mm, and across it in patient space; infinitely far where there is none.
    pub cut: (f64, DVec3),
}

/// The media of a scene; volumes of no extent (a singular transform) are left out.
pub fn place(scene: &Scene) -> Vec<PlacedMedium<'_>> {
    scene.volumes.iter().filter_map(PlacedMedium::new).collect()
}

impl<'a> PlacedMedium<'a> {
    /// The medium of an instance, or `None` if its transform squeezes it into nothing.
    pub fn new(instance: &'a VolumeInstance) -> Option<Self> {
        let determinant = instance.world_from_patient.matrix3.determinant();
        if !instance.world_from_patient.is_finite() || !determinant.is_normal() {
            return None;
        }
        let volume = &*instance.volume;
        let mut medium = instance.medium.clone().sanitized();
        medium.density_scale = medium.density_scale_in(volume);
        let patient_from_world = instance.world_from_patient.inverse();
        let classification = Classification::new(instance, patient_from_world);
        let most = |style| largest_sigma_t_per_mm(&medium, style, volume.value_range());
        let sigma_maj_per_mm = classification.styles.iter().map(most).fold(0.0, f64::max);
        Some(Self {
            voxel_from_world: volume.patient_from_voxel().inverse() * patient_from_world,
            box_from_world: instance.world_from_box().inverse(),
            patient_from_world: patient_from_world.matrix3,
            clip_box: [instance.clip_box[0].max(DVec3::ZERO), instance.clip_box[1].min(DVec3::ONE)],
            layers: instance.layers,
            sigma_maj_per_mm,
            classification,
            volume,
            medium,
        })
    }

    /// The look, every number inside its documented range.
    pub fn medium(&self) -> &Medium {
        &self.medium
    }

    /// The layers whose lights reach it.
    pub fn layers(&self) -> u32 {
        self.layers
    }

    /// The largest extinction anywhere in the volume, in 1/mm.
    pub fn sigma_maj_per_mm(&self) -> f64 {
        self.sigma_maj_per_mm
    }

    /// Extinction in 1/mm at a world point inside the box.
    pub fn sigma_t_per_mm(&self, point: DVec3) -> f64 {
        if self.classification.is_plain() && self.medium.gradients.is_empty() {
            return self.medium.sigma_t_per_mm(self.value(point));
        }
        let gradient =
            if self.medium.gradients.is_empty() { DVec3::ZERO } else { self.gradient_per_mm(point) };
        self.parts_at(point, gradient).iter().map(|part| part.sigma_t_per_mm).sum()
    }

    /// What is at a world point inside the box.
    pub fn parts(&self, point: DVec3) -> Vec<Part> {
        self.parts_at(point, self.gradient_per_mm(point))
    }

    fn parts_at(&self, point: DVec3, gradient_per_mm: DVec3) -> Vec<Part> {
        let value = self.value(point);
        let left = self.classification.left_of_peeling(point);
        let cut = self.classification.cut(point);
        let part = |(label, share): (u8, f64)| {
            let style = &self.classification.styles[usize::from(label)];
            let (opacity, color) = match &style.transfer_function {
                Some(own) => (own.opacity(value), own.color(value)),
                None => self.medium.opacity_and_color(value, gradient_per_mm.length()),
            };
            let cut = cut.filter(|_| style.clipped);
            let kept = if cut.is_some_and(|cut| cut.distance_mm < 0.0) { 0.0 } else { left };
            Part {
                sigma_t_per_mm: share * kept * opacity * sigma_per_opacity(style, &self.medium),
                color: style.color.unwrap_or(color),
                surface: style.surface.unwrap_or(self.medium.surface),
                gradient_per_mm,
                cut: cut.map_or((f64::INFINITY, DVec3::ZERO), |cut| (cut.distance_mm, cut.gradient)),
            }
        };
        self.classification.labels(point).into_iter().map(part).collect()
    }

    /// The part that a collision at a world point is with: `u` is uniform in `[0, 1)`.
    pub fn pick(&self, point: DVec3, u: f64) -> Part {
        let parts = self.parts(point);
        let mut rest = u * parts.iter().map(|part| part.sigma_t_per_mm).sum::<f64>();
        let last = parts[parts.len() - 1];
        for part in parts {
            rest -= part.sigma_t_per_mm;
            if rest < 0.0 {
                return part;
            }
        }
        last
    }

    /// The width in mm of the surface that a cut leaves: a voxel's.
    pub fn cut_width_mm(&self) -> f64 {
        self.volume.spacing_mm().min_element()
    }

    /// Millimetres, in the sense of the medium's extinction space, that a ray passes per world metre.
    pub fn mm_per_metre(&self, direction: DVec3) -> f64 {
        match self.medium.extinction_space {
            ExtinctionSpace::Volume => (self.patient_from_world * direction).length(),
            ExtinctionSpace::World => 1000.0,
        }
    }

    /// The part of a ray, in world metres from its origin, that lies in the clipped box; `None` if there is none.
    pub fn interval(&self, ray: &Ray) -> Option<[f64; 2]> {
        let origin = self.box_from_world.transform_point3(ray.origin);
        let direction = self.box_from_world.transform_vector3(ray.direction);
        let [low, high] = self.clip_box;
        if low.cmpge(high).any() {
            return None;
        }
        let (mut near, mut far) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            let (o, d) = (origin[axis], direction[axis]);
            if d == 0.0 {
                if o < low[axis] || o > high[axis] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low[axis] - o) / d, (high[axis] - o) / d);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        (near < far && far.is_finite()).then_some([near, far])
    }

    /// The filtered physical value at a world point.
    pub fn value(&self, point: DVec3) -> f64 {
        self.value_at_voxel(self.voxel_from_world.transform_point3(point))
    }

    /// The filtered physical value at continuous voxel coordinates; beyond the grid its edge goes on.
    pub fn value_at_voxel(&self, p: DVec3) -> f64 {
        match self.medium.filter {
            Filter::Nearest => {
                let i = (p + 0.5).floor();
                self.tap([i.x, i.y, i.z])
            }
            Filter::Trilinear => self.weighted(p, 0, [|t| [1.0 - t, t]; 3]),
            Filter::Tricubic => self.weighted(p, -1, [cubic_b_spline; 3]),
            Filter::Smooth => {
                let base = p.floor();
                let [x, y, z] = (p - base).to_array().map(|t| [1.0 - t, t]);
                let corner = |i: usize| [i & 1, i >> 1 & 1, i >> 2];
                (0..8).map(corner).fold(0.0, |sum, [i, j, k]| {
                    sum + x[i]
                        * y[j]
                        * z[k]
                        * self.mean_around(base + DVec3::new(i as f64, j as f64, k as f64))
                })
            }
        }
    }

    /// Sum of the taps around `p` under `weights` of its fraction along each axis; `first` is the offset of the first tap.
    fn weighted<const N: usize>(&self, p: DVec3, first: i32, weights: [fn(f64) -> [f64; N]; 3]) -> f64 {
        let base = p.floor();
        let fraction = (p - base).to_array();
        let weights: [[f64; N]; 3] = std::array::from_fn(|axis| weights[axis](fraction[axis]));
        let tap = |axis: usize, i: usize| base[axis] + f64::from(first) + i as f64;
        let mut sum = 0.0;
        for k in 0..N {
            for j in 0..N {
                for i in 0..N {
                    let weight = weights[0][i] * weights[1][j] * weights[2][k];
                    sum += weight * self.tap([tap(0, i), tap(1, j), tap(2, k)]);
                }
            }
        }
        sum
    }

    /// The smooth filter's mean of a voxel, clamped to the grid, and those around it.
    fn mean_around(&self, voxel: DVec3) -> f64 {
        let [x, y, z] = std::array::from_fn(|axis| {
            let last = self.volume.dims()[axis] as f64 - 1.0;
            let middle = voxel[axis].clamp(0.0, last);
            [-2.0, -1.0, 0.0, 1.0, 2.0].map(|step| (middle + step).clamp(0.0, last) as usize)
        });
        let mean = |[a, b, c, d, e]: [f64; 5]| (10.0 * c + 4.0 * (b + d) - (a + e)) / 16.0;
        let along_x = |y, z| mean(x.map(|x| self.volume.value([x, y, z])));
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for neighbour in 0..27 {
            let [i, j, k] = [neighbour % 3, neighbour / 3 % 3, neighbour / 9].map(|step| step + 1);
            let value = self.volume.value([x[i], y[j], z[k]]);
            (low, high) = (low.min(value), high.max(value));
        }
        mean(z.map(|z| mean(y.map(|y| along_x(y, z))))).clamp(low, high)
    }

    /// The value of the voxel at integer coordinates, clamped to the grid.
    fn tap(&self, index: [f64; 3]) -> f64 {
        let dims = self.volume.dims();
        // A float-to-integer cast saturates: what lies below zero becomes zero.
        self.volume.value(std::array::from_fn(|axis| (index[axis] as usize).min(dims[axis] - 1)))
    }

    /// Gradient in value units per mm of patient space at a world point: the cubic filter's derivative, or central
    /// differences of the filtered value over one voxel to each side. Where the value is constant it is exactly zero.
    pub fn gradient_per_mm(&self, point: DVec3) -> DVec3 {
        let p = self.voxel_from_world.transform_point3(point);
        // The weights of a filter add up to 1 but for rounding, which must not pass for a direction.
        let [low, high] = self.volume.value_range();
        let rounding = 1e-13 * low.abs().max(high.abs());
        let voxel_gradient = DVec3::from_array([0, 1, 2].map(|axis| {
            let slope = if self.medium.filter == Filter::Tricubic {
                let mut weights: [fn(f64) -> [f64; 4]; 3] = [cubic_b_spline; 3];
                weights[axis] = cubic_b_spline_slopes;
                self.weighted(p, -1, weights)
            } else {
                let step = DVec3::AXES[axis];
                (self.value_at_voxel(p + step) - self.value_at_voxel(p - step)) / 2.0
            };
            if slope.abs() > rounding { slope } else { 0.0 }
        }));
        // A gradient is a covector: it goes over by the inverse transpose.
        self.volume.patient_from_voxel().matrix3.inverse().transpose() * voxel_gradient
    }

    /// The unit normal in the world of a gradient in patient space; `None` where there is no gradient.
    pub fn world_normal(&self, gradient_per_mm: DVec3) -> Option<DVec3> {
        (self.patient_from_world.transpose() * gradient_per_mm).try_normalize()
    }
}

/// The four weights of a cubic B-spline at fraction `t` between its two middle taps (de Boor, *A Practical Guide to
/// Splines*, 1978).
pub fn cubic_b_spline(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [
        s * s * s / 6.0,
        (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
        (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
        t * t * t / 6.0,
    ]
}

/// The derivatives of [`cubic_b_spline`]'s weights with respect to `t`.
pub fn cubic_b_spline_slopes(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [-s * s / 2.0, (3.0 * t * t - 4.0 * t) / 2.0, (4.0 * s - 3.0 * s * s) / 2.0, t * t / 2.0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use lumivox_core::medium::{MAX_DENSITY_SCALE, SIGMA_UNIT_PER_MM, most_density_scale};
    use lumivox_core::{Ease, LabelStyle, Modality, TransferFunction, Voxels};
    use lumivox_testing::scenes;
    use std::sync::Arc;

    /// A volume with spacing (0.5, 1, 2) mm whose voxel (x, y, z) is `value(x, y, z)`.
    fn grid(dims: [usize; 3], filter: Filter, value: impl Fn(DVec3) -> f64) -> VolumeInstance {
        let mut samples = Vec::new();
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                for x in 0..dims[0] {
                    samples.push(value(DVec3::new(x as f64, y as f64, z as f64)) as f32);
                }
            }
        }
        let place = DAffine3::from_scale(DVec3::new(0.5, 1.0, 2.0));
        let volume = Volume::new(dims, Voxels::F32(samples), [1.0, 0.0], place, Modality::Other).unwrap();
        let tf = TransferFunction::from_points(
            Ease::Linear,
            &[(0.0, 0.0), (3.0, 0.9), (3.5, 0.2), (9.0, 0.5)],
            &[(0.0, [1.0; 3])],
        )
        .unwrap();
        VolumeInstance::centered(Arc::new(volume), Medium { filter, ..Medium::new(tf) })
    }

    #[test]
    fn the_b_spline_is_a_partition_of_unity_and_reproduces_lines() {
        for i in 0..=100 {
            let t = i as f64 / 100.0;
            let weights = cubic_b_spline(t);
            assert!(weights.iter().all(|w| *w >= 0.0));
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            let line: f64 = weights.iter().zip([-1.0, 0.0, 1.0, 2.0]).map(|(w, x)| w * x).sum();
            assert!((line - t).abs() < 1e-15);
        }
        assert_eq!(cubic_b_spline(0.0), [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0, 0.0]);
        for i in 1..100 {
            let t = i as f64 / 100.0;
            let h = 1e-6;
            let [after, before] = [cubic_b_spline(t + h), cubic_b_spline(t - h)];
            for (k, slope) in cubic_b_spline_slopes(t).into_iter().enumerate() {
                assert!(((after[k] - before[k]) / (2.0 * h) - slope).abs() < 1e-9, "weight {k} at {t}");
            }
        }
    }

    #[test]
    fn smooth_filters_reproduce_a_plane_and_its_gradient() {
        for filter in [Filter::Trilinear, Filter::Tricubic, Filter::Smooth] {
            let plane = |p: DVec3| 2.0 + 0.5 * p.x - 0.25 * p.y + 0.125 * p.z;
            let instance = grid([10, 9, 8], filter, plane);
            let placed = PlacedMedium::new(&instance).unwrap();
            let p = DVec3::new(4.3, 4.6, 3.9);
            assert!((placed.value_at_voxel(p) - plane(p)).abs() < 1e-12, "{filter:?}");
            let world = placed.voxel_from_world.inverse().transform_point3(p);
            assert!((placed.value(world) - plane(p)).abs() < 1e-9, "{filter:?}");
            let gradient = placed.gradient_per_mm(world);
            assert!(gradient.distance(DVec3::new(1.0, -0.25, 0.0625)) < 1e-9, "{filter:?} {gradient}");
        }
    }

    #[test]
    fn the_smooth_filter_keeps_curvature_drops_alternation_and_stays_in_range() {
        let value = |value: fn(DVec3) -> f64, p: DVec3| {
            let instance = grid([11, 10, 9], Filter::Smooth, value);
            PlacedMedium::new(&instance).unwrap().value_at_voxel(p)
        };
        let bowl = |p: DVec3| p.x * p.x - 2.0 * p.y * p.y + p.x * p.z;
        let p = DVec3::new(5.0, 4.0, 6.0);
        assert!((value(bowl, p) - bowl(p)).abs() < 1e-12);
        for axis in [|p: DVec3| p.x % 2.0, |p: DVec3| p.y % 2.0, |p: DVec3| p.z % 2.0] {
            assert!((value(axis, DVec3::new(5.25, 4.5, 3.875)) - 0.5).abs() < 1e-12);
        }
        let step = |p: DVec3| if p.x < 5.0 { -3.0 } else { 7.0 };
        let across = (2..9).map(|x| value(step, DVec3::new(f64::from(x), 4.0, 4.0)));
        let wanted = [-3.0, -3.0, -3.0 + 10.0 * 3.0 / 16.0, 7.0 - 10.0 * 3.0 / 16.0, 7.0, 7.0, 7.0];
        assert!(across.zip(wanted).all(|(x, wanted): (f64, f64)| (x - wanted).abs() < 1e-12));
    }

    #[test]
    fn filters_agree_with_their_definitions_and_clamp_at_the_edge() {
        let value = |p: DVec3| (p.x * 7.0 + p.y * 3.0 + p.z * 5.0) % 4.0;
        let nearest = grid([4, 4, 4], Filter::Nearest, value);
        let placed = PlacedMedium::new(&nearest).unwrap();
        assert_eq!(placed.value_at_voxel(DVec3::new(1.4, 1.6, -0.3)), value(DVec3::new(1.0, 2.0, 0.0)));
        assert_eq!(placed.value_at_voxel(DVec3::new(3.49, -0.49, 9.0)), value(DVec3::new(3.0, 0.0, 3.0)));
        let linear = grid([4, 4, 4], Filter::Trilinear, value);
        let placed = PlacedMedium::new(&linear).unwrap();
        let between = 0.75 * value(DVec3::new(1.0, 2.0, 3.0)) + 0.25 * value(DVec3::new(2.0, 2.0, 3.0));
        assert!((placed.value_at_voxel(DVec3::new(1.25, 2.0, 3.4)) - between).abs() < 1e-15);
        assert!((placed.value_at_voxel(DVec3::new(-0.4, 0.0, 0.0)) - value(DVec3::ZERO)).abs() < 1e-15);
    }

    #[test]
    fn no_point_exceeds_the_majorant() {
        let mut rng = Rng::new(0, 0, 0);
        for test in scenes::all() {
            for instance in &test.scene.volumes {
                let placed = PlacedMedium::new(instance).unwrap();
                for _ in 0..2000 {
                    let p = DVec3::from_array(std::array::from_fn(|_| rng.uniform()));
                    let sigma_t = placed.sigma_t_per_mm(instance.world_from_box().transform_point3(p));
                    assert!(sigma_t <= placed.sigma_maj_per_mm() * (1.0 + 1e-12), "{}", test.name);
                }
            }
        }
    }

    #[test]
    fn neither_a_medium_nor_a_label_is_denser_than_a_volume_takes() {
        let mut test = scenes::labels();
        let instance = &mut test.scene.volumes[0];
        let most = most_density_scale(&instance.volume) * SIGMA_UNIT_PER_MM;
        instance.medium.transfer_function = TransferFunction::constant(1.0, [1.0; 3]);
        let sigma_maj = |instance: &VolumeInstance| PlacedMedium::new(instance).unwrap().sigma_maj_per_mm();
        let labelling = instance.labels.as_mut().unwrap();
        let dense = LabelStyle { density_scale: Some(MAX_DENSITY_SCALE), ..labelling.style(5) };
        labelling.set_style(5, dense);
        assert_eq!(sigma_maj(instance), most);
        instance.labels = None;
        instance.medium.density_scale = MAX_DENSITY_SCALE;
        assert_eq!(sigma_maj(instance), most);
    }

    #[test]
    fn a_ray_meets_the_clipped_box_where_it_should() {
        let mut instance = grid([10, 10, 10], Filter::Trilinear, |_| 1.0);
        instance.world_from_patient =
            DAffine3::from_scale(DVec3::new(2.0, 1.0, 1.0)) * instance.world_from_patient;
        instance.clip_box = [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(0.5, 1.0, 1.0)];
        let placed = PlacedMedium::new(&instance).unwrap();
        // 10 voxels of 0.5 mm, stretched twofold, in the middle of the world; the right half is clipped.
        let ray = |x: f64, y: f64, d: DVec3| Ray { origin: DVec3::new(x, y, 0.0), direction: d };
        let [near, far] = placed.interval(&ray(-1.0, 0.0, DVec3::X)).unwrap();
        assert!((near - 0.995).abs() < 1e-12 && (far - 1.0).abs() < 1e-12);
        let [near, far] = placed.interval(&ray(-0.001, 0.0, DVec3::X)).unwrap();
        assert!(near == 0.0 && (far - 0.001).abs() < 1e-12);
        assert!(placed.interval(&ray(1.0, 0.0, DVec3::X)).is_none());
        assert!(placed.interval(&ray(-1.0, 0.2, DVec3::X)).is_none());
        assert!(placed.interval(&ray(0.001, 0.0, DVec3::Y)).is_none());
        // 5 mm of patient space became 10 mm of the world.
        assert!((placed.mm_per_metre(DVec3::X) - 500.0).abs() < 1e-9);
        assert!((placed.mm_per_metre(DVec3::Y) - 1000.0).abs() < 1e-9);
    }
}
