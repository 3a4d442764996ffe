//! A scan as a scalar grid in physical units, at its true place in the patient.
//!
//! The first stop of the walk: an importer or a phantom makes a [`Volume`], and everything after it reads one.

use std::{
    borrow::Cow,
    sync::{Arc, OnceLock},
};

use glam::{DAffine3, DMat3, DVec3};

use crate::{
    background::Background, calibration, document::Scan, statistics::ValueStatistics, subject::Subject,
};

/// The stored samples of a [`Volume`], x fastest, then y, then z.
///
/// A physical value is `stored * slope + intercept` (see [`Volume::slope`]). Signed 16-bit scans are kept as `U16`
/// with their offset in the intercept, so that they go to a GPU as they are, without loss and without a copy.
#[derive(Clone, Debug, PartialEq)]
pub enum Voxels {
    /// 8-bit samples.
    U8(Vec<u8>),
    /// 16-bit samples.
    U16(Vec<u16>),
    /// Floating-point samples; every one is finite.
    F32(Vec<f32>),
}

impl Voxels {
    /// The number of samples.
    pub fn len(&self) -> usize {
        match self {
            Voxels::U8(v) => v.len(),
            Voxels::U16(v) => v.len(),
            Voxels::F32(v) => v.len(),
        }
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes of one sample.
    pub fn bytes_per_sample(&self) -> usize {
        match self {
            Voxels::U8(_) => 1,
            Voxels::U16(_) => 2,
            Voxels::F32(_) => 4,
        }
    }

    /// The samples as they lie in memory.
    pub fn as_bytes(&self) -> &[u8] {
        match self {
            Voxels::U8(v) => v,
            Voxels::U16(v) => bytemuck::cast_slice(v),
            Voxels::F32(v) => bytemuck::cast_slice(v),
        }
    }

    /// The stored sample at a linear index.
    #[inline]
    pub fn get(&self, index: usize) -> f64 {
        match self {
            Voxels::U8(v) => v[index] as f64,
            Voxels::U16(v) => v[index] as f64,
            Voxels::F32(v) => v[index] as f64,
        }
    }
}

/// The unit of what most CT shows.
const HOUNSFIELD: &str = "HU";

/// What made the scan; mostly this says what its values mean, see [`Volume::unit`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub enum Modality {
    /// Computed tomography: values are Hounsfield units (air -1000, water 0), unless the volume's unit says otherwise.
    #[serde(rename = "CT")]
    Ct,
    /// Magnetic resonance: values have no fixed scale.
    #[serde(rename = "MR")]
    Mr,
    /// Positron emission tomography.
    #[serde(rename = "PET")]
    Pet,
    /// Anything else, or not known.
    #[serde(rename = "other")]
    #[default]
    Other,
}

impl Modality {
    /// The unit that its values usually have, for people. A volume says its own: [`Volume::unit`].
    pub fn usual_unit(self) -> &'static str {
        match self {
            Modality::Ct => HOUNSFIELD,
            _ => "",
        }
    }
}

/// Why a [`Volume`] could not be made.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum VolumeError {
    /// A side of the grid has no voxel.
    #[error("a volume needs at least one voxel along each axis, not {0:?}")]
    Empty([usize; 3]),
    /// The grid and the number of samples disagree.
    #[error("a grid of {dims:?} has {expected} voxels, but {actual} samples were given")]
    SampleCount {
        /// Voxels along x, y, z.
        dims: [usize; 3],
        /// Product of `dims`; `usize::MAX` if it overflows.
        expected: usize,
        /// Samples given.
        actual: usize,
    },
    /// `patient_from_voxel` is singular or not finite.
    #[error("patient_from_voxel is not an invertible, finite transform")]
    Transform,
    /// Slope and intercept are not finite, the slope is zero, or values come out that 32-bit floats do not hold.
    #[error(
        "rescale slope {slope} and intercept {intercept} do not map samples to values that 32-bit floats hold"
    )]
    Rescale {
        /// The slope.
        slope: f64,
        /// The intercept.
        intercept: f64,
    },
    /// A floating-point sample is NaN or infinite.
    #[error("sample {0} is not a finite number")]
    NotFinite(usize),
}

/// A scalar grid in physical units (HU for CT) with its place in the patient.
#[derive(Clone, Debug)]
pub struct Volume {
    dims: [usize; 3],
    voxels: Voxels,
    slope: f64,
    intercept: f64,
    patient_from_voxel: DAffine3,
    modality: Modality,
    unit: Cow<'static, str>,
    stored_range: [f64; 2],
    subject: Subject,
    source: Option<Arc<Scan>>,
    /// Counted when somebody asks.
    statistics: OnceLock<Arc<ValueStatistics>>,
}

impl Volume {
    /// A volume of `dims` voxels whose physical value is `stored * slope + intercept`, in the modality's usual unit.
    ///
    /// `patient_from_voxel` maps voxel indices (centres at integers) to LPS millimetres; it may shear (a tilted
    /// gantry) and mirror.
    ///
    /// # Errors
    /// [`VolumeError`] when the parts do not fit together, a sample is not finite, or values or their differences are
    /// beyond 32-bit floats, in which renderers compute.
    pub fn new(
        dims: [usize; 3],
        voxels: Voxels,
        [slope, intercept]: [f64; 2],
        patient_from_voxel: DAffine3,
        modality: Modality,
    ) -> Result<Self, VolumeError> {
        if dims.contains(&0) {
            return Err(VolumeError::Empty(dims));
        }
        let expected =
            dims[0].checked_mul(dims[1]).and_then(|n| n.checked_mul(dims[2])).unwrap_or(usize::MAX);
        if expected != voxels.len() {
            return Err(VolumeError::SampleCount { dims, expected, actual: voxels.len() });
        }
        let determinant = patient_from_voxel.matrix3.determinant();
        if !patient_from_voxel.is_finite() || !determinant.is_normal() {
            return Err(VolumeError::Transform);
        }
        if !slope.is_normal() || !intercept.is_finite() {
            return Err(VolumeError::Rescale { slope, intercept });
        }
        let stored_range = crate::statistics::stored_range(&voxels)?;
        let unit = modality.usual_unit().into();
        let volume = Self {
            dims,
            voxels,
            slope,
            intercept,
            patient_from_voxel,
            modality,
            unit,
            stored_range,
            subject: Subject::default(),
            source: None,
            statistics: OnceLock::new(),
        };
        if !volume.fits_single_precision() {
            return Err(VolumeError::Rescale { slope, intercept });
        }
        Ok(volume)
    }

    /// Whether 32-bit floats hold every value, and the value of the whole range of a texture's texel: of all samples
    /// that integers can be, of the samples that floats are.
    fn fits_single_precision(&self) -> bool {
        let samples = match self.voxels {
            Voxels::U8(_) => f64::from(u8::MAX),
            Voxels::U16(_) => f64::from(u16::MAX),
            Voxels::F32(_) => self.stored_range[1] - self.stored_range[0],
        };
        let per_texel = (samples * self.slope) as f32;
        self.value_range().iter().all(|value| (*value as f32).is_finite())
            && (per_texel.is_normal() || samples == 0.0)
    }

    /// Voxels along x (fastest), y and z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// The number of voxels.
    pub fn voxel_count(&self) -> usize {
        self.voxels.len()
    }

    /// The samples.
    pub fn voxels(&self) -> &Voxels {
        &self.voxels
    }

    /// Physical units per stored unit.
    pub fn slope(&self) -> f64 {
        self.slope
    }

    /// The physical value of a stored 0.
    pub fn intercept(&self) -> f64 {
        self.intercept
    }

    /// LPS millimetres from voxel indices.
    pub fn patient_from_voxel(&self) -> DAffine3 {
        self.patient_from_voxel
    }

    /// What made the scan.
    pub fn modality(&self) -> Modality {
        self.modality
    }

    /// The same volume, said to come from another modality, in its usual unit.
    #[must_use]
    pub fn with_modality(mut self, modality: Modality) -> Self {
        self.modality = modality;
        self.unit = modality.usual_unit().into();
        self
    }

    /// What values are measured in, for people: `HU`, `mg/ml`, `SUV`; empty where that is not known.
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// The same volume, said to be measured in another unit: iodine maps come from a CT and are no Hounsfield units.
    #[must_use]
    pub fn with_unit(mut self, unit: impl Into<Cow<'static, str>>) -> Self {
        self.unit = unit.into();
        self
    }

    /// The same volume with other samples: `change` may alter each, not their number. Nothing is copied.
    ///
    /// # Errors
    /// [`VolumeError`] as of [`Self::new`].
    pub fn edit(self, change: impl FnOnce(&mut Voxels)) -> Result<Self, VolumeError> {
        let Self {
            dims,
            mut voxels,
            slope,
            intercept,
            patient_from_voxel,
            modality,
            unit,
            subject,
            source,
            ..
        } = self;
        change(&mut voxels);
        let changed = Self::new(dims, voxels, [slope, intercept], patient_from_voxel, modality)?;
        Ok(Self { source, ..changed.with_unit(unit).with_subject(subject) })
    }

    /// The files that it is of, and what was done to it, where that is known: what a scene document says of it.
    pub fn source(&self) -> Option<&Scan> {
        self.source.as_deref()
    }

    /// The same volume, said to be of files.
    #[must_use]
    pub fn with_source(mut self, source: Scan) -> Self {
        self.source = Some(Arc::new(source));
        self
    }

    /// The same volume, of which nobody is told what files it is of.
    #[must_use]
    pub fn without_source(mut self) -> Self {
        self.source = None;
        self
    }

    /// The same volume, to which more was done; where its files are not known, nothing is said.
    #[must_use]
    pub fn with_source_changed(self, change: impl FnOnce(&mut Scan)) -> Self {
        match self.source.as_deref().cloned() {
            None => self,
            Some(mut source) => {
                change(&mut source);
                self.with_source(source)
            }
        }
    }

    /// What the scan is of, as far as its file says.
    pub fn subject(&self) -> Subject {
        self.subject
    }

    /// The same volume, said to be of something.
    #[must_use]
    pub fn with_subject(mut self, subject: Subject) -> Self {
        self.subject = subject;
        self
    }

    /// Whether values are Hounsfield units: air -1000, water 0.
    pub fn is_hounsfield(&self) -> bool {
        self.unit == HOUNSFIELD
    }

    /// Whether a scan of which nothing says what it is, as formats without a modality leave it, has the range of
    /// Hounsfield units, and not about a background that is neither air nor tissue.
    pub fn may_be_hounsfield(&self) -> bool {
        /// A map that goes so far below 0 has few such values.
        const AIR: [f64; 2] = [-1150.0, -850.0];
        const LEAST_AIR: f64 = 0.01;
        let [min, max] = self.value_range();
        let has_range =
            self.modality == Modality::Other && self.unit.is_empty() && min <= -500.0 && max >= 300.0;
        has_range
            && !calibration::goes_below_air(self)
            && (self.statistics().share(AIR) >= LEAST_AIR || !self.is_signed_map())
    }

    /// How many voxels have which values; counted once.
    pub fn statistics(&self) -> &ValueStatistics {
        self.statistics.get_or_init(|| Arc::new(ValueStatistics::fine(self)))
    }

    /// Whether it shows what lies below its commonest value, alone or besides what lies above: a map around 0, of statistics,
    /// differences, susceptibility or deformation; or dark vessels. A normalised scan is none ([`Self::is_normalised`]).
    pub fn is_signed_map(&self) -> bool {
        let statistics = self.statistics();
        let background = Background::of(statistics);
        background.is_within(statistics) && !background.is_of_a_mask(statistics)
    }

    /// Whether it is a scan whose values were made to go to both sides of 0, and which was cut out by a mask: what is 0 is
    /// nothing, and darker than some of the scan and brighter than the rest.
    pub fn is_normalised(&self) -> bool {
        let statistics = self.statistics();
        let background = Background::of(statistics);
        background.is_within(statistics) && background.is_of_a_mask(statistics)
    }

    /// Smallest and largest stored sample.
    pub fn stored_range(&self) -> [f64; 2] {
        self.stored_range
    }

    /// Smallest and largest physical value.
    pub fn value_range(&self) -> [f64; 2] {
        let [a, b] = self.stored_range.map(|s| s * self.slope + self.intercept);
        [a.min(b), a.max(b)]
    }

    /// The physical value of voxel `(x, y, z)`.
    ///
    /// # Panics
    /// When the index is outside the grid.
    #[inline]
    pub fn value(&self, [x, y, z]: [usize; 3]) -> f64 {
        // Beyond the end of a row lies the next one: the samples' own bounds do not tell.
        let [nx, ny, nz] = self.dims;
        assert!(x < nx && y < ny && z < nz, "voxel {:?} is outside a grid of {:?}", [x, y, z], self.dims);
        self.voxels.get((z * ny + y) * nx + x) * self.slope + self.intercept
    }

    /// The physical value at a point of voxel space, trilinear between the centres of voxels; half a voxel beyond the outermost
    /// ones it is theirs. `None` outside the volume.
    pub fn interpolated(&self, voxel: DVec3) -> Option<f64> {
        let last = DVec3::from_array(self.dims.map(|n| n as f64 - 1.0));
        // Also for what is no number.
        let is_inside = voxel.cmpge(DVec3::splat(-0.5)).all() && voxel.cmple(last + 0.5).all();
        if !is_inside {
            return None;
        }
        let at = voxel.clamp(DVec3::ZERO, last);
        let low = at.floor().min((last - 1.0).max(DVec3::ZERO));
        let share = at - low;
        let low = low.to_array().map(|x| x as usize);
        let [nx, ny, _] = self.dims;
        let step = [0, 1, 2].map(|axis| usize::from(self.dims[axis] > 1));
        let first = (low[2] * ny + low[1]) * nx + low[0];
        let (dx, dy, dz) = (step[0], step[1] * nx, step[2] * nx * ny);
        let along_x = |index: usize| {
            let [a, b] = [index, index + dx].map(|index| self.voxels.get(index));
            a + (b - a) * share.x
        };
        let in_slice = |index: usize| {
            let [a, b] = [index, index + dy].map(along_x);
            a + (b - a) * share.y
        };
        let [a, b] = [first, first + dz].map(in_slice);
        Some((a + (b - a) * share.z) * self.slope + self.intercept)
    }

    /// Distance between neighbouring voxel centres along each axis, in mm.
    pub fn spacing_mm(&self) -> DVec3 {
        let m = self.patient_from_voxel.matrix3;
        DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length())
    }

    /// Unit directions of the voxel axes in the patient, as the columns of a matrix.
    pub fn directions(&self) -> DMat3 {
        let m = self.patient_from_voxel.matrix3;
        DMat3::from_cols(m.x_axis.normalize(), m.y_axis.normalize(), m.z_axis.normalize())
    }

    /// Patient millimetres from box coordinates, where the volume fills the unit cube `[0, 1]^3`.
    pub fn patient_from_box(&self) -> DAffine3 {
        let size = DVec3::from_array(self.dims.map(|n| n as f64));
        self.patient_from_voxel * DAffine3::from_translation(DVec3::splat(-0.5)) * DAffine3::from_scale(size)
    }

    /// The centre of the volume in patient millimetres.
    pub fn center_mm(&self) -> DVec3 {
        self.patient_from_box().transform_point3(DVec3::splat(0.5))
    }

    /// The edge lengths of the volume's box, in mm.
    pub fn size_mm(&self) -> DVec3 {
        self.spacing_mm() * DVec3::from_array(self.dims.map(|n| n as f64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Volume {
        let place = DAffine3::from_scale_rotation_translation(
            DVec3::new(0.5, 0.5, 2.0),
            glam::DQuat::IDENTITY,
            DVec3::new(10.0, 20.0, 30.0),
        );
        Volume::new([2, 3, 4], Voxels::U16((0..24).collect()), [2.0, -1000.0], place, Modality::Ct).unwrap()
    }

    #[test]
    fn x_is_fastest_and_values_are_rescaled() {
        let volume = ramp();
        assert_eq!(volume.value([1, 0, 0]), -998.0);
        assert_eq!(volume.value([0, 1, 0]), -996.0);
        assert_eq!(volume.value([0, 0, 1]), -988.0);
        assert_eq!(volume.value_range(), [-1000.0, -954.0]);
    }

    #[test]
    fn samples_can_be_edited_and_all_else_stays() {
        let volume = ramp().with_unit("mg/ml");
        let place = volume.patient_from_voxel();
        let edited = volume.edit(|voxels| {
            let Voxels::U16(all) = voxels else { unreachable!() };
            all[0] = 30;
        });
        let edited = edited.unwrap();
        assert_eq!((edited.value([0, 0, 0]), edited.value([1, 0, 0])), (-940.0, -998.0));
        assert_eq!(edited.value_range(), [-998.0, -940.0]);
        assert_eq!((edited.unit(), edited.patient_from_voxel()), ("mg/ml", place));
        let cut = edited.edit(|voxels| *voxels = Voxels::U8(vec![1]));
        assert!(matches!(cut, Err(VolumeError::SampleCount { actual: 1, .. })));
    }

    #[test]
    fn the_box_spans_half_a_voxel_beyond_the_outer_centres() {
        let volume = ramp();
        let corner = volume.patient_from_box().transform_point3(DVec3::ZERO);
        assert_eq!(corner, DVec3::new(9.75, 19.75, 29.0));
        assert_eq!(volume.size_mm(), DVec3::new(1.0, 1.5, 8.0));
    }

    #[test]
    fn parts_that_do_not_fit_are_refused() {
        let new = |dims, voxels, rescale, place| {
            Volume::new(dims, voxels, rescale, place, Modality::Other).map(|_| ()).unwrap_err()
        };
        let id = DAffine3::IDENTITY;
        assert_eq!(new([0, 1, 1], Voxels::U8(vec![]), [1.0, 0.0], id), VolumeError::Empty([0, 1, 1]));
        assert!(matches!(
            new([usize::MAX, 2, 1], Voxels::U8(vec![1]), [1.0, 0.0], id),
            VolumeError::SampleCount { .. }
        ));
        assert_eq!(new([1; 3], Voxels::U8(vec![1]), [1.0, 0.0], DAffine3::ZERO), VolumeError::Transform);
        assert!(matches!(new([1; 3], Voxels::U8(vec![1]), [0.0, 0.0], id), VolumeError::Rescale { .. }));
        assert_eq!(new([1; 3], Voxels::F32(vec![f32::NAN]), [1.0, 0.0], id), VolumeError::NotFinite(0));
    }

    #[test]
    fn values_beyond_32_bit_floats_are_refused() {
        let new = |voxels: Voxels, rescale| {
            let dims = [voxels.len(), 1, 1];
            Volume::new(dims, voxels, rescale, DAffine3::IDENTITY, Modality::Other).map(|v| v.value_range())
        };
        let bytes = Voxels::U8(vec![0, 200]);
        let (most, least) = (f64::from(f32::MAX), f64::from(f32::MIN_POSITIVE));
        for rescale in [
            [1e308, 0.0],
            [-1e308, 0.0],
            [1e307, -1e308],
            [1e37, 0.0],
            [1.0, 1e39],
            [1.0, -1e39],
            [1e-300, 0.0],
        ] {
            let [slope, intercept] = rescale;
            assert_eq!(new(bytes.clone(), rescale), Err(VolumeError::Rescale { slope, intercept }));
        }
        // A texel is worth its type's whole range, whatever samples occur.
        assert!(new(Voxels::U16(vec![0, 1]), [1e34, 0.0]).is_err());
        assert_eq!(new(Voxels::U16(vec![0, 1]), [1e33, 0.0]), Ok([0.0, 1e33]));
        // Of floats it is worth the samples that are there; their difference may be too much although they are not.
        assert!(new(Voxels::F32(vec![f32::MIN, f32::MAX]), [1.0, 0.0]).is_err());
        assert_eq!(new(Voxels::F32(vec![0.0, f32::MAX]), [1.0, 0.0]), Ok([0.0, most]));
        assert_eq!(new(Voxels::F32(vec![0.0, f32::MIN_POSITIVE]), [1.0, 0.0]), Ok([0.0, least]));
        assert_eq!(new(Voxels::F32(vec![0.0; 2]), [1.0, 0.0]), Ok([0.0; 2]));
    }

    #[test]
    fn a_voxel_outside_the_grid_is_no_other_voxel() {
        let volume = ramp();
        for outside in [[2, 0, 0], [0, 3, 0], [0, 0, 4], [0, 0, usize::MAX]] {
            assert!(std::panic::catch_unwind(|| volume.value(outside)).is_err(), "{outside:?}");
        }
    }

    #[test]
    fn values_between_voxels_are_those_of_the_straight_line() {
        let samples = Voxels::U16((0..24).map(|i| i * 10).collect());
        let volume =
            Volume::new([2, 3, 4], samples, [0.5, -3.0], DAffine3::IDENTITY, Modality::Other).unwrap();
        let exact = |p: DVec3| (10.0 * p.x + 20.0 * p.y + 60.0 * p.z) * 0.5 - 3.0;
        for p in [DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.25, 1.5, 2.75)] {
            assert!((volume.interpolated(p).unwrap() - exact(p)).abs() < 1e-9, "{p}");
        }
        assert_eq!(volume.interpolated(DVec3::splat(-0.5)), Some(-3.0), "the outermost voxel's own");
        assert_eq!(volume.interpolated(DVec3::new(0.0, 0.0, 3.51)), None);
        assert_eq!(volume.interpolated(DVec3::new(0.0, f64::NAN, 0.0)), None);
        let slice = Voxels::U8(vec![1, 3]);
        let slice = Volume::new([2, 1, 1], slice, [1.0, 0.0], DAffine3::IDENTITY, Modality::Other).unwrap();
        assert_eq!(slice.interpolated(DVec3::new(0.5, 0.2, 0.0)), Some(2.0));
    }
}
