//! The anatomical phantom: a head-and-neck CT with contrast, modelled in signed distance fields.
//!
//! Anatomical space is patient space (LPS, mm): +x is the patient's left, -y the front, +z the head; the origin lies
//! midway between the ear canals, in the Frankfort plane. Shapes given for x > 0 are mirrored; a gentle warp of space,
//! drawn from the seed, then makes the sides unequal as they are in people. The patient's left lower first molar has
//! an amalgam filling: a renderer or an importer that mirrors the patient shows it on the wrong side.
//!
//! Proportions follow the usual anthropometry of an adult man (head 150 mm wide, 195 mm deep, 230 mm from chin to
//! vertex); Hounsfield values those of an arterial-phase scan at 120 kV.

mod brain;
mod face;
mod jaw;
mod material;
mod muscles;
mod organs;
mod raster;
mod skull;
mod spine;
pub(crate) mod torso;
mod vessels;

use glam::{DAffine3, DMat3, DVec3, Mat3, Vec3};
use lumivox_core::{CancelToken, Cancelled, Modality, Progress, Volume, Voxels};

use crate::{
    AIR_HU, INTERCEPT,
    noise::hash64,
    sdf::{Sdf, ellipsoid},
    stored,
};
use material::Material;
use raster::{Grid, Layer, Model, Scan};

/// Edge length of the phantom's cube, in mm.
pub const FIELD_OF_VIEW_MM: f64 = 320.0;

/// The corner of the field of view with the smallest coordinates, in patient mm.
const LOW_CORNER_MM: DVec3 = DVec3::new(-160.0, -172.0, -184.0);

/// What to grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnatomyOptions {
    /// Voxels along each side of the cube of [`FIELD_OF_VIEW_MM`].
    pub size: usize,
    /// Draws everything in which two people or two scans differ.
    pub seed: u64,
    /// Standard deviation of the noise, in HU.
    pub noise_hu: f64,
}

impl Default for AnatomyOptions {
    fn default() -> Self {
        Self { size: 256, seed: 1, noise_hu: 12.0 }
    }
}

/// Shared fields of the model, in the order of their evaluation.
mod field {
    /// The surface of the skin.
    pub const SKIN: usize = 0;
    /// The outside of the braincase.
    pub const CRANIUM: usize = 1;
    /// The inside of the braincase.
    pub const CAVITY: usize = 2;
}

/// Grows the anatomical phantom: a CT of head, neck and the top of the shoulders after contrast.
///
/// The same options give the same volume, on any number of threads.
///
/// # Errors
/// [`Cancelled`] when `cancel` was used.
///
/// # Panics
/// When `options.size` is 0.
pub fn anatomy(
    options: AnatomyOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Volume, Cancelled> {
    let samples = samples(&model(options.seed), options, progress, cancel)?;
    let (size, place) = (options.size, place(options.size));
    Ok(Volume::new([size; 3], Voxels::U16(samples), [1.0, INTERCEPT], place, Modality::Ct)
        .expect("a cube of finite samples"))
}

/// Which part of the head an MR shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MrPart {
    /// All of it, down to the shoulders.
    Head,
    /// The brain with the fluid around it, as programs that strip the skull leave it.
    Brain,
}

/// Grows the anatomical phantom as a T1-weighted MR sees it: fat is bright, white matter brighter than grey, fluid dark;
/// bone and air have no signal, and blood that flows in has the most. [`AnatomyOptions::noise_hu`] is in its units, in which
/// white matter has 560.
///
/// The same options give the same volume, on any number of threads.
///
/// # Errors
/// [`Cancelled`] when `cancel` was used.
///
/// # Panics
/// When `options.size` is 0.
pub fn anatomy_mr(
    options: AnatomyOptions,
    part: MrPart,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Volume, Cancelled> {
    let mut model = model(options.seed);
    if part == MrPart::Brain {
        model.layers = brain::layers(&Seeds(options.seed));
    }
    // A stripped brain has nothing around it, noise neither.
    let noise_hu = if part == MrPart::Brain { 0.0 } else { options.noise_hu };
    let mut samples = samples(&model.in_t1(), AnatomyOptions { noise_hu, ..options }, progress, cancel)?;
    // The magnitude is what is shown: noise in air is on one side of nothing.
    let nothing = stored(AIR_HU);
    samples.iter_mut().for_each(|sample| *sample = sample.abs_diff(nothing));
    let (size, place) = (options.size, place(options.size));
    Ok(Volume::new([size; 3], Voxels::U16(samples), [1.0, 0.0], place, Modality::Mr)
        .expect("a cube of finite samples"))
}

/// Where the voxels of a cube of so many along each side lie.
fn place(size: usize) -> DAffine3 {
    let spacing = FIELD_OF_VIEW_MM / size as f64;
    DAffine3::from_mat3_translation(
        DMat3::from_diagonal(DVec3::splat(spacing)),
        LOW_CORNER_MM + spacing / 2.0,
    )
}

fn samples(
    model: &Model,
    options: AnatomyOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Vec<u16>, Cancelled> {
    assert!(options.size > 0, "a phantom needs voxels");
    let size = options.size;
    let spacing = FIELD_OF_VIEW_MM / size as f64;
    let first = LOW_CORNER_MM + spacing / 2.0;
    let grid = Grid { size, first: first.as_vec3(), spacing: spacing as f32, axes: Mat3::IDENTITY };
    let scan = Scan { seed: options.seed, noise_hu: options.noise_hu, padding: None };
    raster::rasterise(model, grid, scan, progress, cancel)
}

/// Everything in the field of view. Later layers replace earlier ones.
fn model(seed: u64) -> Model {
    let noise = Seeds(seed);
    let skin = face::skin();
    // Whatever lies under the skin is kept under it, and bone under muscle and fat.
    let under_skin = |layers: Vec<Layer>, depth: f32| {
        layers.into_iter().map(move |l| l.within(Sdf::Field(field::SKIN).grow(-depth), 0.4 * depth))
    };
    let bones = [skull::layers(&noise), jaw::layers(&noise)].concat();
    let mut layers = soft_tissue(&noise);
    layers.extend(under_skin(muscles::layers(&noise), 2.6));
    layers.extend(under_skin(organs::layers(&noise), 2.6));
    layers.extend(under_skin(muscles::expression_layers(&skin), 2.4));
    layers.extend(under_skin(spine::layers(&noise), 4.0));
    layers.extend(brain::layers(&noise));
    layers.extend(under_skin(bones, 4.2));
    layers.extend(under_skin(vessels::layers(&skin, &noise), 2.4));
    layers.extend(jaw::tooth_layers());
    Model { fields: vec![skin, skull::cranium(), skull::cavity()], layers, warp_seed: noise.get("warp") }
}

/// Skin and the fat under it, with its septa.
fn soft_tissue(noise: &Seeds) -> Vec<Layer> {
    let skin = Sdf::Field(field::SKIN);
    let lungs = ellipsoid(Vec3::new(48.0, 30.0, -196.0), Vec3::new(33.0, 42.0, 38.0)).mirror();
    // Skin holds some fat: at its lower values, looks that show muscle see through it.
    vec![
        Layer::new(skin.clone().rough(0.12, 3.0, noise.get("pores")), Material::even(-20.0, 5.0, 3.0)),
        Layer::new(skin.grow(-1.7), Material::even(-98.0, 14.0, 5.0)),
        Layer::new(lungs.clone().grow(1.5), Material::even(30.0, 5.0, 4.0)),
        Layer::new(lungs, Material::Lung),
    ]
}

/// Independent seeds by name, from one.
struct Seeds(u64);

impl Seeds {
    fn get(&self, name: &str) -> u32 {
        name.bytes().fold(hash64(self.0), |h, b| hash64(h ^ u64::from(b))) as u32
    }
}

#[cfg(test)]
mod tests;
