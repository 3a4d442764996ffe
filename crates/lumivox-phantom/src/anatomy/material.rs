//! What tissues measure, in Hounsfield units.

use glam::Vec3;

use crate::{
    noise::{noise, noise2},
    sdf::smoothstep,
};

/// How a tissue's value varies inside it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Material {
    /// A value with soft mottling.
    Even {
        /// Mean value.
        hu: f32,
        /// Amplitude of the mottling.
        amplitude: f32,
        /// Size of the mottles, in mm.
        size: f32,
    },
    /// Muscle: bundles of fibres with fat between them.
    Muscle {
        /// Direction of the fibres, a unit vector.
        fibres: Vec3,
        /// By how much the fat between bundles lowers the value.
        fat: f32,
    },
    /// Bone: a cortical shell around spongy bone.
    Bone {
        /// Thickness of the shell, in mm.
        cortex_mm: f32,
        /// Value of the shell.
        cortex: f32,
        /// Mean value of the spongy bone.
        spongy: f32,
    },
    /// Brain: cortex folded around sulci, white matter within.
    Brain {
        /// Seed of the folds.
        seed: u32,
    },
    /// The fine parallel folds of the cerebellum.
    Cerebellum,
    /// Air-filled tissue with vessels.
    Lung,
    /// Air-filled tissue whose vessels are modelled: denser where it lies below.
    Parenchyma,
}

const CSF: f32 = 6.0;
const GREY_MATTER: f32 = 40.0;
const WHITE_MATTER: f32 = 29.0;

impl Material {
    /// A value with mottles of an amplitude and a size in mm.
    pub(crate) const fn even(hu: f32, amplitude: f32, size: f32) -> Self {
        Material::Even { hu, amplitude, size }
    }

    /// Whether the value depends on the depth under the surface.
    pub(crate) fn has_depth(&self) -> bool {
        matches!(self, Material::Bone { .. } | Material::Brain { .. } | Material::Cerebellum)
    }

    /// The value at `p`, `depth` mm under the tissue's surface.
    pub(crate) fn hu(&self, p: Vec3, depth: f32) -> f32 {
        match *self {
            Material::Even { hu, amplitude, size } => hu + amplitude * noise(p / size, 11),
            Material::Muscle { fibres, fat } => {
                // Squeezing space along the fibres stretches the noise along them.
                let q = p - fibres * (0.9 * p.dot(fibres));
                let bundle = noise(q / 3.6, 21);
                let septa =
                    if fat > 0.0 { fat * smoothstep(0.28, 0.6, noise(q / 5.0 + 9.0, 22)) } else { 0.0 };
                62.0 + 20.0 * bundle - septa
            }
            Material::Bone { cortex_mm, cortex, spongy } => {
                let shell = 1.0 - smoothstep(cortex_mm - 0.4, cortex_mm + 0.9, depth);
                let marrow = spongy + 110.0 * noise2(p / 2.6, 31);
                let compact = cortex + 90.0 * noise(p / 9.0, 32);
                marrow + (compact - marrow) * shell
            }
            Material::Brain { seed } => brain(p, depth, seed),
            Material::Cerebellum => {
                let q = Vec3::new(p.x * 0.35, p.y - 34.0, p.z + 4.0);
                let leaf = ((q.length() + 1.5 * noise(p / 9.0, 51)) * 2.0).sin();
                let groove = smoothstep(0.55, 0.95, leaf) * (1.0 - smoothstep(2.0, 12.0, depth));
                37.0 + (CSF - 37.0) * groove
            }
            Material::Lung => {
                let vessel =
                    1.0 - smoothstep(0.03, 0.14, noise2(p / 14.0, 41).abs() + noise2(p / 11.0, 42).abs());
                -860.0 + 25.0 * noise(p / 6.0, 43) + 850.0 * vessel
            }
            Material::Parenchyma => -872.0 + 0.20 * p.y + 14.0 * noise(p / 5.0, 43),
        }
    }
}

/// Sulci lie where two smooth noises vanish: winding sheets that sink from the surface into the brain. They close with
/// depth, and grey matter lines them.
fn brain(p: Vec3, depth: f32, seed: u32) -> f32 {
    const DEEPEST_MM: f32 = 17.0;
    // The falx parts the hemispheres.
    let falx = p.x.abs() - 0.9;
    let to_sulcus = if depth < DEEPEST_MM + 6.0 {
        let bend = Vec3::new(noise(p / 16.0, seed ^ 1), noise(p / 16.0, seed ^ 2), noise(p / 16.0, seed ^ 3));
        let q = p + 5.0 * bend;
        // The noise's slope is about 1.6 per lattice step: near a zero this is a distance in mm.
        let sheet = |size: f32, seed: u32| (noise(q / size, seed) * size / 1.6).abs();
        let main = sheet(19.0, seed ^ 4) + (depth - DEEPEST_MM).max(0.0);
        let side = sheet(11.5, seed ^ 5) + (depth - 0.5 * DEEPEST_MM).max(0.0);
        main.min(side) - 0.9 * (1.0 - depth / (1.6 * DEEPEST_MM)).max(0.25)
    } else {
        f32::MAX
    };
    let pial = depth.min(to_sulcus).min(falx + 0.6);
    let fluid = 1.0 - smoothstep(-0.4, 0.5, to_sulcus.min(falx));
    let grey = 1.0 - smoothstep(2.3, 3.6, pial);
    let tissue = WHITE_MATTER + (GREY_MATTER - WHITE_MATTER) * grey;
    tissue + (CSF - tissue) * fluid
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bone_is_hard_outside_and_spongy_inside() {
        let bone = Material::Bone { cortex_mm: 2.0, cortex: 1300.0, spongy: 300.0 };
        let p = Vec3::new(3.0, 4.0, 5.0);
        assert!((1150.0..1450.0).contains(&bone.hu(p, 0.5)));
        assert!((100.0..500.0).contains(&bone.hu(p, 6.0)));
    }

    #[test]
    fn the_brain_has_grey_and_white_matter_and_fluid() {
        let values: Vec<f32> = (0..4000)
            .map(|i| {
                let p = Vec3::new(20.0 + (i % 50) as f32, 1.7 * (i / 50) as f32, 30.0);
                Material::Brain { seed: 5 }.hu(p, (i % 17) as f32)
            })
            .collect();
        for tissue in [CSF, GREY_MATTER, WHITE_MATTER] {
            let share = values.iter().filter(|v| (*v - tissue).abs() < 3.0).count();
            assert!(share > 100, "{share} of {tissue}");
        }
    }
}
