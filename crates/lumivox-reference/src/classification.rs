//! What a point of a volume is besides its value, from the definitions in `lumivox-core`: labels with their styles, depth
//! below the skin, clip shapes.

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::medium::{SIGMA_UNIT_PER_MM, most_density_scale};
use lumivox_core::{
    ClipKind, ClipShape, LabelStyle, Labelling, Medium, Peel, TransferFunction, Volume, VolumeInstance,
};

use crate::medium::cubic_b_spline;

/// All that a [`VolumeInstance`] says of its points.
#[derive(Clone, Debug)]
pub(crate) struct Classification<'a> {
    labels: Option<(&'a Labelling, DAffine3)>,
    /// Of each label's value; one where there are no labels.
    pub styles: Vec<LabelStyle>,
    peel: Option<(&'a Peel, DAffine3)>,
    /// Each with the map to its own space.
    shapes: Vec<(ClipShape, DAffine3)>,
}

/// Where a clip shape cuts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cut {
    /// From the cut in mm of the patient; negative where it is cut away.
    pub distance_mm: f64,
    /// Across the cut, in patient space; of any length.
    pub gradient: DVec3,
}

impl<'a> Classification<'a> {
    pub fn new(instance: &'a VolumeInstance, patient_from_world: DAffine3) -> Self {
        let voxel_from_world = |volume: &Volume| volume.patient_from_voxel().inverse() * patient_from_world;
        let labels = instance.labels.as_ref().map(|l| (l, voxel_from_world(l.labels.volume())));
        let peel = instance.peel.as_ref().filter(|peel| peel.is_active());
        // As the medium's own.
        let most = most_density_scale(&instance.volume);
        let styled = |mut style: LabelStyle| {
            style.density_scale = style.density_scale.map(|own| own.min(most));
            style
        };
        Self {
            styles: match &instance.labels {
                Some(labelling) => (0..=u8::MAX).map(|value| styled(labelling.style(value))).collect(),
                None => vec![LabelStyle::default()],
            },
            labels,
            peel: peel.map(|peel| (peel, voxel_from_world(&peel.depth))),
            shapes: instance
                .cuts()
                .map(|shape| (*shape, shape.patient_from_shape.inverse() * patient_from_world))
                .collect(),
        }
    }

    /// Whether it says nothing.
    pub fn is_plain(&self) -> bool {
        self.labels.is_none() && self.peel.is_none() && self.shapes.is_empty()
    }

    /// The labels of a world point and their shares, which add up to 1.
    pub fn labels(&self, point: DVec3) -> Vec<(u8, f64)> {
        let Some((labelling, voxel_from_world)) = &self.labels else { return vec![(0, 1.0)] };
        let labels = &labelling.labels;
        let p = voxel_from_world.transform_point3(point);
        let last = DVec3::from_array(labels.dims().map(|n| n as f64)) - 1.0;
        if p.cmplt(DVec3::splat(-0.5)).any() || p.cmpge(last + 0.5).any() {
            return vec![(0, 1.0)];
        }
        let base = p.floor();
        let weights = (p - base).to_array().map(cubic_b_spline);
        let mut shares = [0.0; 256];
        for tap in 0..64 {
            let [i, j, k] = [tap % 4, tap / 4 % 4, tap / 16];
            let at = base + DVec3::new(i as f64, j as f64, k as f64) - 1.0;
            let value = labels.value(at.clamp(DVec3::ZERO, last).to_array().map(|x| x as usize));
            shares[usize::from(value)] += weights[0][i] * weights[1][j] * weights[2][k];
        }
        (0..=u8::MAX).zip(shares).filter(|(_, share)| *share > 0.0).collect()
    }

    /// The share that peeling leaves at a world point.
    pub fn left_of_peeling(&self, point: DVec3) -> f64 {
        let Some((peel, voxel_from_world)) = &self.peel else { return 1.0 };
        let depth = &*peel.depth;
        let p = voxel_from_world.transform_point3(point);
        let base = p.floor();
        let f = (p - base).to_array().map(|t| [1.0 - t, t]);
        let tap = |corner: usize| {
            let at = [corner & 1, corner >> 1 & 1, corner >> 2];
            let index = std::array::from_fn(|axis| {
                ((base[axis] + at[axis] as f64).max(0.0) as usize).min(depth.dims()[axis] - 1)
            });
            f[0][at[0]] * f[1][at[1]] * f[2][at[2]] * depth.value(index)
        };
        peel.share((0..8).map(tap).sum())
    }

    /// The cut that is nearest, or that cuts a world point away; `None` where there are no shapes. `gradient` is of the
    /// patient's space.
    pub fn cut(&self, point: DVec3) -> Option<Cut> {
        let cuts = self.shapes.iter().map(|(shape, shape_from_world)| {
            let q = shape_from_world.transform_point3(point);
            let (level, slope) = match shape.kind {
                ClipKind::Plane => (q.z, DVec3::Z),
                ClipKind::Box => {
                    let size = q.abs();
                    let axis = if size.x >= size.y && size.x >= size.z {
                        0
                    } else if size.y >= size.z {
                        1
                    } else {
                        2
                    };
                    (1.0 - size[axis], -q[axis].signum() * DVec3::AXES[axis])
                }
                ClipKind::Sphere => (1.0 - q.length(), -q.normalize_or_zero()),
            };
            let sign = if shape.inverted { -1.0 } else { 1.0 };
            // A covector: by the transposed map from the patient to the shape.
            let shape_from_patient = shape.patient_from_shape.matrix3.inverse();
            let gradient = shape_from_patient.transpose() * (sign * slope);
            Cut { distance_mm: sign * level / gradient.length().max(1e-300), gradient }
        });
        cuts.min_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm))
    }
}

/// Extinction in 1/mm of a label where its transfer function is opaque. A density of its own takes the place of the medium's.
pub(crate) fn sigma_per_opacity(style: &LabelStyle, medium: &Medium) -> f64 {
    if !style.visible {
        return 0.0;
    }
    let density = match style.density_scale {
        Some(own) => own,
        None => medium.density_scale,
    };
    density * style.opacity * SIGMA_UNIT_PER_MM
}

/// The largest extinction in 1/mm that a label can have over a range of values.
pub(crate) fn largest_sigma_t_per_mm(medium: &Medium, style: &LabelStyle, range: [f64; 2]) -> f64 {
    let own = style.transfer_function.as_ref();
    let rows = medium.gradients.iter().map(|row| &row.transfer_function).filter(|_| own.is_none());
    let curves = std::iter::once(own.unwrap_or(&medium.transfer_function)).chain(rows);
    curves.map(|curve| largest(curve, range)).fold(0.0, f64::max) * sigma_per_opacity(style, medium)
}

/// Between two knots the curve is monotone, so the largest lies at a knot or an end.
fn largest(curve: &TransferFunction, [low, high]: [f64; 2]) -> f64 {
    let inside = curve.opacity_knots().iter().filter(|k| (low..=high).contains(&k.value));
    inside.map(|k| k.opacity).fold(curve.opacity(low).max(curve.opacity(high)), f64::max)
}
