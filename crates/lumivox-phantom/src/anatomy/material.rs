//! What tissues measure: in Hounsfield units, and in a T1-weighted MR, whose values have a scale of their own.

use glam::Vec3;

use crate::maths;
use crate::{
    AIR_HU,
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
    /// Muscle as a T1-weighted MR sees it.
    MuscleT1 {
        /// Direction of the fibres, a unit vector.
        fibres: Vec3,
        /// As of [`Material::Muscle`].
        fat: f32,
    },
    /// Brain, and its cerebellum, as a T1-weighted MR sees them.
    BrainT1 {
        /// Seed of the folds; the cerebellum has none.
        seed: Option<u32>,
    },
    /// Air-filled tissue with vessels.
    Lung,
    /// Air-filled tissue whose vessels are modelled: denser where it lies below.
    Parenchyma,
}

/// Values of fluid, grey and white matter.
#[derive(Clone, Copy, Debug)]
struct Matter {
    fluid: f32,
    grey: f32,
    white: f32,
}

const MATTER_HU: Matter = Matter { fluid: 6.0, grey: 40.0, white: 29.0 };
const MATTER_T1: Matter = Matter { fluid: in_t1(110.0), grey: in_t1(380.0), white: in_t1(560.0) };

/// A signal as it goes through what was made for Hounsfield units: air, which has none, is [`AIR_HU`].
const fn in_t1(signal: f32) -> f32 {
    AIR_HU as f32 + signal
}

/// The signal of even tissue, by what it is in Hounsfield units: fat is bright, fluid dark, bone and air have none, and
/// blood that flows in is brightest.
fn even_in_t1(hu: f32) -> f32 {
    let signal = match hu {
        hu if hu < -500.0 => 0.0,
        hu if hu < -50.0 => 820.0,
        // Skin.
        hu if hu < 0.0 => 560.0,
        // Fluid of brain, spine and eye.
        hu if hu < 15.0 => 110.0,
        hu if hu < 45.0 => 400.0,
        hu if hu < 90.0 => 320.0,
        // Cartilage, glands, veins.
        hu if hu < 250.0 => 240.0,
        hu if hu < 600.0 => 1050.0,
        _ => 20.0,
    };
    in_t1(signal)
}

impl Material {
    /// A value with mottles of an amplitude and a size in mm.
    pub(crate) const fn even(hu: f32, amplitude: f32, size: f32) -> Self {
        Material::Even { hu, amplitude, size }
    }

    /// The same tissue in a T1-weighted MR, in which signals are counted from [`AIR_HU`].
    pub(crate) fn in_t1(self) -> Self {
        match self {
            Material::Even { hu, amplitude, size } => {
                Material::Even { hu: even_in_t1(hu), amplitude: 1.5 * amplitude, size }
            }
            Material::Muscle { fibres, fat } => Material::MuscleT1 { fibres, fat },
            // Of bone, marrow is seen, which is fat here.
            Material::Bone { cortex_mm, .. } => {
                Material::Bone { cortex_mm, cortex: in_t1(30.0), spongy: in_t1(520.0) }
            }
            Material::Brain { seed } => Material::BrainT1 { seed: Some(seed) },
            Material::Cerebellum => Material::BrainT1 { seed: None },
            Material::Lung | Material::Parenchyma => Material::even(in_t1(25.0), 10.0, 5.0),
            Material::MuscleT1 { .. } | Material::BrainT1 { .. } => self,
        }
    }

    /// Whether the value depends on the depth under the surface.
    pub(crate) fn has_depth(&self) -> bool {
        matches!(
            self,
            Material::Bone { .. } | Material::Brain { .. } | Material::Cerebellum | Material::BrainT1 { .. }
        )
    }

    /// The value at `p`, `depth` mm under the tissue's surface.
    pub(crate) fn hu(&self, p: Vec3, depth: f32) -> f32 {
        match *self {
            Material::Even { hu, amplitude, size } => hu + amplitude * noise(p / size, 11),
            Material::Muscle { fibres, fat } => {
                let [bundle, septa] = muscle(p, fibres, fat);
                62.0 + 20.0 * bundle - fat * septa
            }
            Material::MuscleT1 { fibres, fat } => {
                let [bundle, septa] = muscle(p, fibres, fat);
                in_t1(330.0 + 35.0 * bundle + 5.0 * fat * septa)
            }
            Material::Bone { cortex_mm, cortex, spongy } => {
                let shell = 1.0 - smoothstep(cortex_mm - 0.4, cortex_mm + 0.9, depth);
                let marrow = spongy + 110.0 * noise2(p / 2.6, 31);
                let compact = cortex + 90.0 * noise(p / 9.0, 32);
                marrow + (compact - marrow) * shell
            }
            Material::Brain { seed } => brain(p, depth, seed, MATTER_HU),
            Material::BrainT1 { seed: Some(seed) } => brain(p, depth, seed, MATTER_T1),
            Material::BrainT1 { seed: None } => cerebellum(p, depth, MATTER_T1.grey, MATTER_T1.fluid),
            Material::Cerebellum => cerebellum(p, depth, 37.0, MATTER_HU.fluid),
            Material::Lung => {
                let vessel =
                    1.0 - smoothstep(0.03, 0.14, noise2(p / 14.0, 41).abs() + noise2(p / 11.0, 42).abs());
                -860.0 + 25.0 * noise(p / 6.0, 43) + 850.0 * vessel
            }
            Material::Parenchyma => -872.0 + 0.20 * p.y + 14.0 * noise(p / 5.0, 43),
        }
    }
}

/// How a place lies in muscle: across bundles of fibres, -1 to 1, and in the fat between them, 0 to 1.
fn muscle(p: Vec3, fibres: Vec3, fat: f32) -> [f32; 2] {
    // Squeezing space along the fibres stretches the noise along them.
    let q = p - fibres * (0.9 * p.dot(fibres));
    let septa = if fat > 0.0 { smoothstep(0.28, 0.6, noise(q / 5.0 + 9.0, 22)) } else { 0.0 };
    [noise(q / 3.6, 21), septa]
}

/// Leaves of a value, with grooves full of fluid between them.
fn cerebellum(p: Vec3, depth: f32, tissue: f32, fluid: f32) -> f32 {
    let q = Vec3::new(p.x * 0.35, p.y - 34.0, p.z + 4.0);
    let leaf = maths::sin((q.length() + 1.5 * noise(p / 9.0, 51)) * 2.0);
    let groove = smoothstep(0.55, 0.95, leaf) * (1.0 - smoothstep(2.0, 12.0, depth));
    tissue + (fluid - tissue) * groove
}

/// Sulci lie where two smooth noises vanish: winding sheets that sink from the surface into the brain. They close with
/// depth, and grey matter lines them.
fn brain(p: Vec3, depth: f32, seed: u32, matter: Matter) -> f32 {
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
    let tissue = matter.white + (matter.grey - matter.white) * grey;
    tissue + (matter.fluid - tissue) * fluid
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
        for tissue in [MATTER_HU.fluid, MATTER_HU.grey, MATTER_HU.white] {
            let share = values.iter().filter(|v| (*v - tissue).abs() < 3.0).count();
            assert!(share > 100, "{share} of {tissue}");
        }
    }
}
