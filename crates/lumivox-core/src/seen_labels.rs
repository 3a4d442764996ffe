//! Whether a look shows the parts of a scan: paint on what is clear is not seen, and whoever paints it is to be told.

use std::collections::BTreeMap;

use crate::{
    classification::LabelStyle,
    framing::SEEN_DEPTH,
    labels::LabelVolume,
    medium::Medium,
    scene::{VolumeInstance, nearest},
    volume::Volume,
};

/// Bins that a scan's values are told apart by.
const BINS: usize = 1024;

/// Labelled voxels that are looked at, about and at most.
const LOOKS: usize = 1 << 20;

/// The scan's values in each label. Taking them looks at a million voxels; to ask them of a look costs next to nothing.
#[derive(Clone, Debug)]
pub struct LabelValues {
    low: f64,
    /// Values of a bin.
    width: f64,
    labels: BTreeMap<u8, OfLabel>,
    /// Of a voxel that was looked at, in mm^3.
    volume_of_look: f64,
}

#[derive(Clone, Debug)]
struct OfLabel {
    counts: Vec<u32>,
    total: u64,
}

impl LabelValues {
    /// Those of `volume` in `labels`, which may lie on another grid.
    pub fn of(volume: &Volume, labels: &LabelVolume) -> Self {
        let [low, high] = volume.value_range();
        let width = ((high - low) / BINS as f64).max(f64::MIN_POSITIVE);
        let voxels = labels.voxels();
        // Odd: grids are often even, and every look would lie in one plane.
        let stride = (voxels.len() / LOOKS) | 1;
        let [nx, ny, _] = labels.dims();
        let to_scan = volume.patient_from_voxel().inverse() * labels.patient_from_voxel();
        let mut known = BTreeMap::new();
        for at in (0..voxels.len()).step_by(stride) {
            let here = [at % nx, at / nx % ny, at / (nx * ny)].map(|i| i as f64);
            let Some(voxel) = nearest(volume, to_scan.transform_point3(here.into())) else {
                continue;
            };
            let of = known.entry(voxels[at]).or_insert_with(|| OfLabel { counts: vec![0; BINS], total: 0 });
            let bin = ((volume.value(voxel) - low) / width) as usize;
            of.counts[bin.min(BINS - 1)] += 1;
            of.total += 1;
        }
        let of_voxel = labels.patient_from_voxel().matrix3.determinant().abs();
        Self { low, width, labels: known, volume_of_look: of_voxel * stride as f64 }
    }

    /// Whether a label is seen in a look: whether a ball of its size and its mean extinction would be. Also true of a label
    /// of which nothing is known.
    pub fn shows(&self, label: u8, style: &LabelStyle, medium: &Medium, volume: &Volume) -> bool {
        let Some(of) = self.labels.get(&label) else { return true };
        let opacity = |value: f64| match &style.transfer_function {
            Some(function) => function.opacity(value),
            None => {
                let rows = medium.gradients.iter().map(|row| row.transfer_function.opacity(value));
                rows.fold(medium.transfer_function.opacity(value), f64::max)
            }
        };
        let occupied = (0..BINS).filter(|&bin| of.counts[bin] > 0);
        let sum: f64 = occupied
            .map(|bin| f64::from(of.counts[bin]) * opacity(self.low + (bin as f64 + 0.5) * self.width))
            .sum();
        let size_mm = (of.total as f64 * self.volume_of_look).cbrt();
        let per_mm = crate::medium::SIGMA_UNIT_PER_MM * style.density(medium, volume) * sum / of.total as f64;
        per_mm * size_mm >= SEEN_DEPTH
    }
}

impl VolumeInstance {
    /// Those of `asked` that are meant to be seen and of which hardly anything is, for the look makes their values clear: whoever
    /// asks for them by name is to be told.
    pub fn unseen_labels(&self, asked: &[u8]) -> Vec<u8> {
        let Some(labelling) = self.labels.as_ref().filter(|_| !asked.is_empty()) else { return vec![] };
        let values = LabelValues::of(&self.volume, &labelling.labels);
        let is_unseen = |value: &u8| {
            let style = labelling.style(*value);
            let is_meant = style.visible && style.opacity > 0.0;
            is_meant && !values.shows(*value, &style, &self.medium, &self.volume)
        };
        asked.iter().copied().filter(is_unseen).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        labels::Label,
        presets::Preset,
        transfer_function::TransferFunction,
        volume::{Modality, Voxels},
    };
    use glam::{DAffine3, DVec3};

    /// A soft organ, a bone and a lung in air, 40 mm each, with labels of half the resolution that begin elsewhere.
    fn body() -> (Volume, LabelVolume) {
        // Stored with 1024 added.
        let of = |x: usize| [24, 1084, 1924, 324][x / 20];
        let samples = (0..80 * 20 * 20).map(|i| of(i % 80)).collect();
        let place = DAffine3::from_scale(DVec3::splat(2.0));
        let scan =
            Volume::new([80, 20, 20], Voxels::U16(samples), [1.0, -1024.0], place, Modality::Ct).unwrap();
        let values = (0..40 * 10 * 10).map(|i| ((2 * (i % 40) + 1) / 20) as u8).collect();
        let coarse = DAffine3::from_translation(DVec3::splat(1.0)) * DAffine3::from_scale(DVec3::splat(4.0));
        let label = |value: u8| Label { value, name: format!("part {value}"), color: [1.0; 3] };
        let labels = LabelVolume::new([40, 10, 10], values, coarse, (1..=4).map(label).collect()).unwrap();
        (scan, labels)
    }

    #[test]
    fn a_look_shows_the_parts_whose_values_it_makes_opaque() {
        let (scan, labels) = body();
        let values = LabelValues::of(&scan, &labels);
        let style = LabelStyle { color: Some([1.0, 0.0, 0.0]), ..LabelStyle::default() };
        let shown = |preset: Preset, style: &LabelStyle| {
            let medium = preset.medium(&scan);
            [1, 2, 3].map(|label| values.shows(label, style, &medium, &scan))
        };
        assert_eq!(shown(Preset::CtBone, &style), [false, true, false]);
        assert_eq!(shown(Preset::CtSkin, &style), [true, true, false]);
        // A function of the label's own is what counts for it; so is its own density, and its opacity.
        let own = LabelStyle {
            transfer_function: Some(TransferFunction::constant(0.5, [1.0; 3])),
            ..style.clone()
        };
        assert_eq!(shown(Preset::CtBone, &own), [true; 3]);
        assert_eq!(
            shown(Preset::CtSkin, &LabelStyle { density_scale: Some(1e-5), ..style.clone() }),
            [false; 3]
        );
        assert_eq!(shown(Preset::CtSkin, &LabelStyle { opacity: 0.0, ..style }), [false; 3]);
        // Of a label that no voxel has, nothing is known.
        assert!(values.shows(4, &LabelStyle::default(), &Preset::CtBone.medium(&scan), &scan));
    }
}
