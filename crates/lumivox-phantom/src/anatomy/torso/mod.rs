//! The torso: a CT of chest and upper belly with contrast, from the base of the neck to about the navel.
//!
//! Coordinates as in the head: patient space (LPS, mm). The origin lies in the chest's middle, at the height of the
//! sternum's lower end; the vertebrae stand in `column.rs`, from T1 at z = 178 to L4 at z = -195. Two lofts carry most
//! of it: the skin, and the rib cage's inside, on which ribs and flat muscles are draped (`drape.rs`). Bronchi and the
//! vessels beside them grow into the lungs by themselves (`tree.rs`). What grows is the same for everybody; the seed
//! warps it, as it warps the head.
//!
//! A man of 340 x 225 mm (chest), who breathed in; late arterial phase at 120 kV.

mod abdomen;
mod airways;
mod body;
mod bowel;
mod column;
mod drape;
mod equipment;
mod girdle;
mod heart;
mod lungs;
mod muscles;
mod part;
mod pet;
mod ribs;
mod tree;
mod vessels;

use glam::{DAffine3, DMat3, DVec3};
use lumivox_core::{CancelToken, Cancelled, Modality, Progress, Volume, Voxels};

use super::{
    Seeds,
    material::Material,
    raster::{self, Grid, Layer, Model, Scan},
};
use crate::maths;
use crate::{INTERCEPT, loft::Loft, sdf::Sdf};
pub use part::TorsoPart;
pub use pet::torso_pet;

/// Edge length of the torso's cube unless asked otherwise, in mm.
pub const TORSO_FIELD_OF_VIEW_MM: f64 = 400.0;

/// The middle of the field of view, in patient mm.
const CENTER_MM: DVec3 = DVec3::new(0.0, 12.0, 0.0);

/// Where the arms are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Arms {
    /// Above the head, as for most scans of the chest: they leave the field of view at its top.
    #[default]
    Raised,
    /// At the sides: the default field of view cuts them off, one of 520 mm holds them.
    AtSides,
}

/// Metal in the patient.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Metal {
    /// None.
    #[default]
    None,
    /// Wires around the sternum, as they stay after operations on the heart.
    SternalWires,
    /// A pacemaker under the left clavicle, with two leads to the heart.
    Pacemaker,
    /// A rod on screws along the lower spine.
    Rod,
}

/// What to grow, and how it is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorsoOptions {
    /// Voxels along each side of the cube.
    pub size: usize,
    /// Draws the noise, and the warp that makes the sides unequal.
    pub seed: u64,
    /// Standard deviation of the noise, in HU.
    pub noise_hu: f64,
    /// Edge length of the cube, in mm.
    pub field_of_view_mm: f64,
    /// By how much the field of view is moved along patient x, y and z, in mm; far enough, and it cuts the body off.
    pub shift_mm: [f64; 3],
    /// By how much the field of view is turned around the patient's left-right axis, in degrees.
    pub tilt_degrees: f64,
    /// Whether what lies outside of the scanner's round field of view is padding of -1024 HU, not air.
    pub padding: bool,
    /// Where the arms are.
    pub arms: Arms,
    /// Whether there are breasts.
    pub breasts: bool,
    /// Whether there are a table and its mattress.
    pub table: bool,
    /// Whether the patient lies under a blanket.
    pub blanket: bool,
    /// Metal in the patient.
    pub metal: Metal,
}

impl Default for TorsoOptions {
    fn default() -> Self {
        Self {
            size: 256,
            seed: 1,
            noise_hu: 12.0,
            field_of_view_mm: TORSO_FIELD_OF_VIEW_MM,
            shift_mm: [0.0; 3],
            tilt_degrees: 0.0,
            padding: false,
            arms: Arms::default(),
            breasts: false,
            table: true,
            blanket: false,
            metal: Metal::None,
        }
    }
}

impl TorsoOptions {
    fn axes(&self) -> DMat3 {
        maths::turn_x_f64(self.tilt_degrees.to_radians())
    }

    fn spacing(&self) -> f64 {
        self.field_of_view_mm / self.size as f64
    }

    /// The centre of the first voxel.
    fn first(&self) -> DVec3 {
        let to_middle = DVec3::splat(self.spacing() * (self.size as f64 - 1.0) / 2.0);
        CENTER_MM + DVec3::from_array(self.shift_mm) - self.axes() * to_middle
    }

    /// LPS mm from voxel indices.
    fn place(&self) -> DAffine3 {
        DAffine3::from_mat3_translation(self.axes() * self.spacing(), self.first())
    }

    fn grid(&self) -> Grid {
        assert!(self.size > 0, "a phantom needs voxels");
        assert!(self.field_of_view_mm > 0.0, "a field of view has a size");
        Grid {
            size: self.size,
            first: self.first().as_vec3(),
            spacing: self.spacing() as f32,
            axes: self.axes().as_mat3(),
        }
    }
}

/// Shared fields of the model, in the order of their evaluation.
mod field {
    /// The surface of the skin.
    pub const SKIN: usize = 0;
    /// The inside of rib cage and belly wall.
    pub const CAGE: usize = 1;
    /// What lies below the diaphragm.
    pub const BELLY: usize = 2;
    /// The heart's muscle and what it encloses.
    pub const HEART: usize = 3;
    /// Both lungs.
    pub const LUNG: usize = 4;
}

/// Grows the torso phantom.
///
/// The same options give the same volume, on any number of threads.
///
/// # Errors
/// [`Cancelled`] when `cancel` was used.
///
/// # Panics
/// When `options.size` is 0 or the field of view has no size.
pub fn torso(
    options: TorsoOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Volume, Cancelled> {
    let padding = options.padding.then_some(INTERCEPT as f32);
    let scan = Scan { seed: options.seed, noise_hu: options.noise_hu, padding };
    let samples = raster::rasterise(&model(&options), options.grid(), scan, progress, cancel)?;
    let volume =
        Volume::new([options.size; 3], Voxels::U16(samples), [1.0, INTERCEPT], options.place(), Modality::Ct);
    Ok(volume.expect("a cube of finite samples"))
}

/// What each voxel of [`torso`] is at its centre, x fastest: the numbers of [`TorsoPart`].
///
/// # Errors
/// [`Cancelled`] when `cancel` was used.
///
/// # Panics
/// As [`torso`].
pub fn torso_parts(
    options: TorsoOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Vec<u8>, Cancelled> {
    let nothing = TorsoPart::OutsideAir as u8;
    let outside = [nothing, if options.padding { TorsoPart::Padding as u8 } else { nothing }];
    raster::rasterise_parts(&model(&options), options.grid(), outside, progress, cancel)
}

/// The truth about a torso, place by place.
pub struct TorsoTruth {
    model: Model,
}

impl TorsoTruth {
    /// Of the torso that these options grow.
    pub fn new(options: TorsoOptions) -> Self {
        Self { model: model(&options) }
    }

    /// What lies at a place in patient mm, whatever the field of view.
    pub fn part(&self, patient_mm: DVec3) -> TorsoPart {
        let number = raster::part_at(&self.model, patient_mm.as_vec3());
        number.and_then(TorsoPart::from_number).unwrap_or(TorsoPart::OutsideAir)
    }
}

/// What all parts of the model need.
struct Stuff {
    seeds: Seeds,
    /// The inside of rib cage and belly wall.
    cage: Loft,
}

impl Stuff {
    fn new(seed: u64) -> Self {
        Self { seeds: Seeds(seed), cage: body::cage() }
    }

    fn seed(&self, name: &str) -> u32 {
        self.seeds.get(name)
    }

    fn layer(&self, part: TorsoPart, shape: Sdf, material: Material) -> Layer {
        Layer::new(shape, material).part(part as u8)
    }

    /// The shape kept `depth` mm under the skin.
    fn under_skin(&self, shape: Sdf, depth: f32) -> Sdf {
        shape.and(Sdf::Field(field::SKIN).grow(-depth), 0.4 * depth)
    }
}

/// Everything in the field of view. Later layers replace earlier ones.
fn model(options: &TorsoOptions) -> Model {
    let stuff = Stuff::new(options.seed);
    let skin = body::skin(options.arms, options.breasts);
    let belly = body::belly();
    let heart = heart::outside();
    let lung = lungs::shape();
    let mut layers = Vec::new();
    if options.table {
        layers.extend(equipment::table(&stuff));
    }
    if options.blanket {
        layers.extend(equipment::blanket(&stuff, options.arms));
    }
    layers.extend(body::layers(&stuff, options.breasts));
    layers.extend(muscles::layers(&stuff, options.arms));
    layers.extend(lungs::cavities(&stuff));
    layers.extend(abdomen::layers(&stuff));
    layers.extend(bowel::layers(&stuff));
    layers.extend(lungs::layers(&stuff));
    layers.extend(heart::layers(&stuff));
    layers.extend(column::layers(&stuff));
    layers.extend(ribs::layers(&stuff));
    layers.extend(girdle::layers(&stuff, options.arms));
    layers.extend(vessels::layers(&stuff));
    layers.extend(airways::layers(&stuff));
    layers.extend(equipment::metal(&stuff, options.metal));
    let fields = vec![skin, Sdf::Loft(stuff.cage.clone()), belly, heart, lung];
    Model { fields, layers, warp_seed: stuff.seed("warp") }
}

#[cfg(test)]
mod tests;
