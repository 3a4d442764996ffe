//! Which voxels of a scan are what: a small number beside every voxel, and what the numbers mean.
//!
//! A segmentation makes a [`LabelVolume`] on the grid of a [`Volume`]; a renderer hides or colours by it.

use std::{path::PathBuf, sync::Arc};

use glam::{DAffine3, DVec3};

use crate::{
    lasso::Lasso,
    volume::{Modality, Volume, VolumeError, Voxels},
};

/// The value of voxels that belong to no label.
pub const UNLABELLED: u8 = 0;

/// What one value of a [`LabelVolume`] means.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// The voxels' value, 1 to 255.
    pub value: u8,
    /// For people: `lungs`.
    pub name: String,
    /// Linear, sRGB primaries, each part 0 to 1.
    pub color: [f64; 3],
}

/// Why a [`LabelVolume`] could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LabelError {
    /// A side of the grid has no voxel.
    #[error("labels need at least one voxel along each axis, not {0:?}")]
    Empty([usize; 3]),
    /// The grid and the number of voxels disagree.
    #[error("a grid of {dims:?} has {expected} voxels, but {actual} were given")]
    VoxelCount {
        /// Voxels along x, y, z.
        dims: [usize; 3],
        /// Product of `dims`; `usize::MAX` if it overflows.
        expected: usize,
        /// Voxels given.
        actual: usize,
    },
    /// `patient_from_voxel` is singular or not finite.
    #[error("patient_from_voxel is not an invertible, finite transform")]
    Transform,
    /// The table names 0, which stands for voxels without a label.
    #[error("label {name:?} has the value 0, which stands for voxels without a label")]
    Reserved {
        /// Its name.
        name: String,
    },
    /// Two labels of the table have the same value.
    #[error("two labels have the value {0}")]
    Duplicate(u8),
    /// A colour is not within 0 to 1.
    #[error("the colour {color:?} of label {value} is not within 0 to 1")]
    Color {
        /// The label's value.
        value: u8,
        /// Its colour.
        color: [f64; 3],
    },
    /// A voxel has a value that the table does not know.
    #[error("voxels have the value {0}, which no label has")]
    Unknown(u8),
}

/// A label for every voxel of a grid, with its place in the patient.
#[derive(Clone, Debug)]
pub struct LabelVolume {
    /// Of 8-bit samples, which are values.
    volume: Arc<Volume>,
    labels: Vec<Label>,
    source: Option<Arc<LabelSource>>,
    cut: Option<Arc<CutAway>>,
}

/// Where labels come from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LabelSource {
    /// Their files; none where they were found in the scan itself.
    pub files: Vec<PathBuf>,
    /// The file that names them, besides their own.
    pub table: Option<PathBuf>,
    /// The numbers that labels have in their files, and their values here.
    pub numbers: Vec<(i128, u8)>,
}

/// What lassos cut away, see [`cut_by_lassos`](crate::lasso::cut_by_lassos).
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct CutAway {
    /// They.
    pub lassos: Vec<Lasso>,
    /// The label of what is cut away.
    pub value: u8,
    /// The labels without it, if there were any. Nothing that is written down has them.
    #[serde(skip)]
    pub before: Option<Arc<LabelVolume>>,
}

impl PartialEq for LabelVolume {
    fn eq(&self, other: &Self) -> bool {
        self.dims() == other.dims()
            && self.patient_from_voxel() == other.patient_from_voxel()
            && self.labels == other.labels
            && self.voxels() == other.voxels()
    }
}

/// That labels seem not to be those of a volume.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Misplaced {
    /// None of them lies in it.
    pub all: bool,
    /// What that means, and what to do.
    pub why: String,
}

impl LabelVolume {
    /// Labels of `dims` voxels, x fastest, then y, then z; [`UNLABELLED`] belongs to none of `labels`.
    ///
    /// `patient_from_voxel` maps voxel indices (centres at integers) to LPS millimetres, as that of the scan does.
    ///
    /// # Errors
    /// [`LabelError`] when the parts do not fit together.
    pub fn new(
        dims: [usize; 3],
        voxels: Vec<u8>,
        patient_from_voxel: DAffine3,
        mut labels: Vec<Label>,
    ) -> Result<Self, LabelError> {
        let made = Volume::new(dims, Voxels::U8(voxels), [1.0, 0.0], patient_from_voxel, Modality::Other);
        let volume = made.map_err(|error| match error {
            VolumeError::Empty(dims) => LabelError::Empty(dims),
            VolumeError::SampleCount { dims, expected, actual } => {
                LabelError::VoxelCount { dims, expected, actual }
            }
            _ => LabelError::Transform,
        })?;
        labels.sort_by_key(|label| label.value);
        if let Some(label) = labels.iter().find(|label| label.value == UNLABELLED) {
            return Err(LabelError::Reserved { name: label.name.clone() });
        }
        if let Some(pair) = labels.windows(2).find(|pair| pair[0].value == pair[1].value) {
            return Err(LabelError::Duplicate(pair[0].value));
        }
        let possible = |color: [f64; 3]| color.iter().all(|part| (0.0..=1.0).contains(part));
        if let Some(label) = labels.iter().find(|label| !possible(label.color)) {
            return Err(LabelError::Color { value: label.value, color: label.color });
        }
        let labels = Self { volume: Arc::new(volume), labels, source: None, cut: None };
        let counts = labels.counts();
        let known = |value: u8| value == UNLABELLED || labels.label(value).is_some();
        match (0..=u8::MAX).find(|&value| counts[usize::from(value)] > 0 && !known(value)) {
            Some(value) => Err(LabelError::Unknown(value)),
            None => Ok(labels),
        }
    }

    /// Voxels along x (fastest), y and z.
    pub fn dims(&self) -> [usize; 3] {
        self.volume.dims()
    }

    /// The voxels as a volume whose values are those of the labels.
    pub fn volume(&self) -> &Arc<Volume> {
        &self.volume
    }

    /// The voxels' values, x fastest, then y, then z.
    pub fn voxels(&self) -> &[u8] {
        self.volume.voxels().as_bytes()
    }

    /// LPS millimetres from voxel indices.
    pub fn patient_from_voxel(&self) -> DAffine3 {
        self.volume.patient_from_voxel()
    }

    /// What the values mean, by rising value.
    pub fn labels(&self) -> &[Label] {
        &self.labels
    }

    /// Where they come from, if that is known.
    pub fn source(&self) -> Option<&LabelSource> {
        self.source.as_deref()
    }

    /// The same labels, said to come from somewhere.
    #[must_use]
    pub fn with_source(mut self, source: LabelSource) -> Self {
        self.source = Some(Arc::new(source));
        self
    }

    /// The same labels, of which nobody is told where they come from.
    #[must_use]
    pub fn without_source(mut self) -> Self {
        self.source = None;
        self
    }

    /// What lassos cut away of them.
    pub fn cut_away(&self) -> Option<&CutAway> {
        self.cut.as_deref()
    }

    /// The same labels, one of which is said to be what lassos cut away; they come from where those before came from.
    #[must_use]
    pub fn with_cut(mut self, cut: CutAway) -> Self {
        if let Some(before) = &cut.before {
            self.source.clone_from(&before.source);
        } else if self.source.is_none() && self.labels.iter().all(|label| label.value == cut.value) {
            // Of no file: cut again wherever the scan is.
            self.source = Some(Arc::default());
        }
        self.cut = Some(Arc::new(cut));
        self
    }

    /// What people know as labels: all but what lassos cut away.
    pub fn own_labels(&self) -> impl Iterator<Item = &Label> {
        let cut = self.cut.as_ref().map(|cut| cut.value);
        self.labels.iter().filter(move |label| Some(label.value) != cut)
    }

    /// Whether they are what a person knows as labels: all but what lassos cut away alone.
    pub fn has_own(&self) -> bool {
        let has_files = self.source.as_ref().is_none_or(|source| !source.files.is_empty());
        self.cut.is_none() || has_files || self.own_labels().next().is_some()
    }

    /// What a voxel's value means; `None` for [`UNLABELLED`] and for values that no voxel has.
    pub fn label(&self, value: u8) -> Option<&Label> {
        self.labels.binary_search_by_key(&value, |label| label.value).ok().map(|at| &self.labels[at])
    }

    /// The value of voxel `(x, y, z)`.
    ///
    /// # Panics
    /// When the index is outside the grid.
    #[inline]
    pub fn value(&self, [x, y, z]: [usize; 3]) -> u8 {
        let [nx, ny, nz] = self.dims();
        assert!(x < nx && y < ny && z < nz, "voxel {:?} is outside a grid of {:?}", [x, y, z], self.dims());
        self.voxels()[(z * ny + y) * nx + x]
    }

    /// Voxels of each value.
    pub fn counts(&self) -> [u64; 256] {
        use rayon::prelude::*;
        let count = |chunk: &[u8]| {
            let mut counts = [0u64; 256];
            chunk.iter().for_each(|&value| counts[usize::from(value)] += 1);
            counts
        };
        self.voxels().par_chunks(1 << 18).map(count).reduce(
            || [0; 256],
            |mut a, b| {
                a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
                a
            },
        )
    }

    /// The numbers by which people know labels, each with its value: those of their file, else their values.
    pub fn numbers(&self) -> Vec<(i128, u8)> {
        let own = || self.labels.iter().map(|label| (i128::from(label.value), label.value)).collect();
        self.source.as_ref().map_or_else(own, |source| source.numbers.clone())
    }

    /// Why they seem not to be those of a volume: by where they lie, in words for people.
    pub fn misplaced(&self, volume: &Volume) -> Option<Misplaced> {
        /// Of the scan's size.
        const LOST: &str = "the labels have as many voxels as the scan along each axis, but lie elsewhere: if they were drawn on \
                            it, their file has lost its place (a NIfTI's affine, for example); save them with that of the scan";
        let has_lost = self.is_of_size_but_elsewhere(volume);
        let (all, why) = match self.share_within(volume) {
            Some(0.0) if has_lost => (true, format!("none of its labels lies in the scan: {LOST}")),
            Some(0.0) => {
                let why = "none of its labels lies in the scan: they are of another patient, or of another place; take the labels \
                           of this scan";
                (true, why.to_owned())
            }
            Some(_) if has_lost => (false, LOST.to_owned()),
            Some(share) if share < 0.5 => {
                let beyond = 100.0 * (1.0 - share);
                (
                    false,
                    format!(
                        "{beyond:.0}% of what is labelled lies beyond the scan: are they of the same patient?"
                    ),
                )
            }
            // That there are none was said when they were read.
            None | Some(_) => return None,
        };
        Some(Misplaced { all, why })
    }

    /// The word by which a value is meant alone: the label's name where that is the only one, else its number in the file.
    pub fn word_of(&self, value: u8) -> String {
        let numbers = self.numbers();
        let name = match value {
            UNLABELLED => "unlabelled",
            _ => self.label(value).map_or("", |label| label.name.as_str()),
        };
        if self.values_of(name, &numbers) == [value] {
            return name.to_owned();
        }
        let number =
            numbers.iter().find(|(_, own)| *own == value).map_or(i128::from(value), |(number, _)| *number);
        format!("#{number}")
    }

    /// The values that people mean by a word: a label's name, in upper or lower case; `unlabelled`; `*` for all; else one of
    /// the `numbers` that labels have in their file. `#2` is always a number.
    pub fn values_of(&self, word: &str, numbers: &[(i128, u8)]) -> Vec<u8> {
        let (only_number, name) = match word.strip_prefix('#') {
            Some(number) => (true, number),
            None => (false, word),
        };
        if !only_number {
            if name == "*" {
                return self.labels.iter().map(|label| label.value).chain([UNLABELLED]).collect();
            }
            // Files and programs write `kidney_right` for what is called `kidney right`.
            let is_it = |own: &str| {
                let own = own.bytes().map(|byte| if byte == b'_' { b' ' } else { byte.to_ascii_lowercase() });
                own.eq(name.bytes().map(|byte| if byte == b'_' { b' ' } else { byte.to_ascii_lowercase() }))
            };
            let named = self.labels.iter().filter(|label| is_it(&label.name));
            let named: Vec<u8> = named.map(|label| label.value).collect();
            if !named.is_empty() {
                return named;
            }
            if name.eq_ignore_ascii_case("unlabelled") {
                return vec![UNLABELLED];
            }
        }
        match name.parse::<i128>() {
            Ok(0) => vec![UNLABELLED],
            Ok(number) => numbers.iter().filter(|(own, _)| *own == number).map(|(_, value)| *value).collect(),
            Err(_) => vec![],
        }
    }

    /// The share of labelled voxels whose centres lie in a volume, of a sample of them where they are many; `None` where none
    /// is labelled.
    pub fn share_within(&self, volume: &Volume) -> Option<f64> {
        const MOST_LOOKS: usize = 1 << 18;
        let voxel_from_label = volume.patient_from_voxel().inverse() * self.patient_from_voxel();
        let dims = DVec3::from_array(volume.dims().map(|n| n as f64));
        let [nx, ny, _] = self.dims();
        let step = self.counts()[1..].iter().sum::<u64>() as usize / MOST_LOOKS + 1;
        let labelled = (0..self.voxels().len()).filter(|&i| self.voxels()[i] != UNLABELLED).step_by(step);
        let (mut inside, mut all) = (0u32, 0u32);
        for i in labelled {
            let at = [i % nx, i / nx % ny, i / (nx * ny)].map(|n| n as f64);
            let p = voxel_from_label.transform_point3(DVec3::from_array(at)) + 0.5;
            inside += u32::from(p.cmpge(DVec3::ZERO).all() && p.cmple(dims).all());
            all += 1;
        }
        (all > 0).then(|| f64::from(inside) / f64::from(all))
    }

    /// Whether it has as many voxels as a volume along each axis but fills another box: what it was drawn on may be that volume,
    /// and its place lost.
    pub fn is_of_size_but_elsewhere(&self, volume: &Volume) -> bool {
        /// Voxels by which corners may be off.
        const NEAR: f64 = 2.0;
        let dims = DVec3::from_array(volume.dims().map(|n| n as f64));
        let box_from_own = volume.patient_from_box().inverse() * self.volume.patient_from_box();
        // Axes may be stored in another order or direction: corners lie on corners all the same.
        let is_corner = |corner: usize| {
            let own = DVec3::from_array([0, 1, 2].map(|axis| (corner >> axis & 1) as f64));
            let place = box_from_own.transform_point3(own);
            let off = (place - place.round().clamp(DVec3::ZERO, DVec3::ONE)).abs() * dims;
            off.max_element() <= NEAR
        };
        self.dims() == volume.dims() && !(0..8).all(is_corner)
    }

    /// The volume of one voxel, in mm^3.
    pub fn voxel_mm3(&self) -> f64 {
        self.patient_from_voxel().matrix3.determinant().abs()
    }

    /// Distance between neighbouring voxel centres along each axis, in mm.
    pub fn spacing_mm(&self) -> DVec3 {
        self.volume.spacing_mm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn label(value: u8) -> Label {
        Label { value, name: format!("label {value}"), color: [0.5, 0.25, 1.0] }
    }

    #[test]
    fn x_is_fastest_and_values_have_names() {
        let place = DAffine3::from_scale(DVec3::new(0.5, 2.0, 3.0));
        let labels = LabelVolume::new([2, 2, 1], vec![0, 9, 3, 9], place, vec![label(9), label(3)]).unwrap();
        assert_eq!([labels.value([1, 0, 0]), labels.value([0, 1, 0])], [9, 3]);
        assert_eq!(labels.label(9).unwrap().name, "label 9");
        assert_eq!(labels.label(UNLABELLED), None);
        assert_eq!(labels.labels().iter().map(|label| label.value).collect::<Vec<_>>(), [3, 9]);
        let counts = labels.counts();
        assert_eq!([counts[0], counts[3], counts[9]], [1, 1, 2]);
        assert_eq!(labels.voxel_mm3(), 3.0);
        assert_eq!(labels.spacing_mm(), DVec3::new(0.5, 2.0, 3.0));
    }

    #[test]
    fn parts_that_do_not_fit_are_refused() {
        let id = DAffine3::IDENTITY;
        let new = |dims, voxels, place, labels| LabelVolume::new(dims, voxels, place, labels).unwrap_err();
        assert_eq!(new([1, 0, 1], vec![], id, vec![]), LabelError::Empty([1, 0, 1]));
        assert!(matches!(
            new([usize::MAX, 2, 1], vec![0], id, vec![]),
            LabelError::VoxelCount { expected: usize::MAX, actual: 1, .. }
        ));
        assert_eq!(new([1; 3], vec![0], DAffine3::ZERO, vec![]), LabelError::Transform);
        assert!(matches!(new([1; 3], vec![0], id, vec![label(0)]), LabelError::Reserved { .. }));
        assert_eq!(new([1; 3], vec![0], id, vec![label(2), label(2)]), LabelError::Duplicate(2));
        let bright = Label { color: [0.0, f64::NAN, 0.0], ..label(1) };
        assert!(matches!(new([1; 3], vec![0], id, vec![bright]), LabelError::Color { value: 1, .. }));
        assert_eq!(new([1; 3], vec![7], id, vec![label(2)]), LabelError::Unknown(7));
    }

    #[test]
    fn names_go_before_numbers() {
        let label = |value, name: &str| Label { value, name: name.into(), color: [0.25; 3] };
        let named = vec![label(1, "2"), label(2, "*"), label(3, "Liver")];
        let labels = LabelVolume::new([3, 1, 1], vec![1, 2, 3], DAffine3::IDENTITY, named).unwrap();
        let values = |word: &str| labels.values_of(word, &labels.numbers());
        assert_eq!([values("2"), values("#2"), values("1"), values("LIVER")], [[1], [2], [1], [3]]);
        assert_eq!(values("*"), [1, 2, 3, 0], "all, whatever one is called");
        assert_eq!((values("0"), values("unlabelled")), (vec![0], vec![0]));
        assert_eq!((values("#*"), values("7"), values("spleen")), (vec![], vec![], vec![]));
        // By the number of the file, and not by the one that it has here.
        let of_file = [(1024, 1), (7, 3)];
        assert_eq!([labels.values_of("1024", &of_file), labels.values_of("#7", &of_file)], [[1], [3]]);
        assert!(labels.values_of("3", &of_file).is_empty());
    }

    #[test]
    fn labels_beside_a_scan_are_told() {
        let volume =
            |place| Volume::new([4; 3], Voxels::U8(vec![0; 64]), [1.0, 0.0], place, Modality::Ct).unwrap();
        let labels = LabelVolume::new([4; 3], vec![1; 64], DAffine3::IDENTITY, vec![label(1)]).unwrap();
        let at = |x: f64| labels.share_within(&volume(DAffine3::from_translation(DVec3::X * x)));
        assert_eq!([at(0.0), at(2.0), at(5000.0)], [Some(1.0), Some(0.5), Some(0.0)]);
        let empty = LabelVolume::new([1; 3], vec![0], DAffine3::IDENTITY, vec![]).unwrap();
        assert_eq!(empty.share_within(&volume(DAffine3::IDENTITY)), None);
    }

    #[test]
    fn labels_of_the_scans_size_at_another_place_are_told_in_words() {
        let place = DAffine3::from_scale(DVec3::splat(1.5));
        let scan = Volume::new([8; 3], Voxels::U8(vec![0; 512]), [1.0, 0.0], place, Modality::Ct).unwrap();
        let told = |place| {
            let labels = LabelVolume::new([8; 3], vec![1; 512], place, vec![label(1)]).unwrap();
            labels.misplaced(&scan)
        };
        assert_eq!(told(place), None);
        let some = told(DAffine3::IDENTITY).unwrap();
        assert!(!some.all && some.why.contains("their file has lost its place"), "{some:?}");
        let all = told(DAffine3::from_translation(DVec3::X * 500.0)).unwrap();
        assert!(
            all.all && all.why.starts_with("none of its labels lies in the scan: the labels have"),
            "{all:?}"
        );
    }

    #[test]
    fn labels_that_lost_their_place_are_told() {
        let place = DAffine3::from_scale_rotation_translation(
            DVec3::new(0.7, 0.7, 1.5),
            glam::DQuat::IDENTITY,
            DVec3::new(-20.0, -30.0, 5.0),
        );
        let volume = |dims: [usize; 3]| {
            let n = dims.iter().product();
            Volume::new(dims, Voxels::U8(vec![0; n]), [1.0, 0.0], place, Modality::Ct).unwrap()
        };
        let labels = |place| LabelVolume::new([40, 40, 10], vec![1; 16_000], place, vec![label(1)]).unwrap();
        let scan = volume([40, 40, 10]);
        assert!(labels(DAffine3::IDENTITY).is_of_size_but_elsewhere(&scan));
        assert!(!labels(place).is_of_size_but_elsewhere(&scan));
        // The same box, stored from right to left; a scan of another size.
        let turned = place
            * DAffine3::from_translation(DVec3::X * 39.0)
            * DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        assert!(!labels(turned).is_of_size_but_elsewhere(&scan));
        assert!(!labels(DAffine3::IDENTITY).is_of_size_but_elsewhere(&volume([40, 40, 11])));
    }

    #[test]
    #[should_panic(expected = "outside a grid")]
    fn voxels_beyond_a_row_are_not_the_next_row() {
        let labels = LabelVolume::new([2, 2, 1], vec![0; 4], DAffine3::IDENTITY, vec![]).unwrap();
        labels.value([2, 0, 0]);
    }
}
