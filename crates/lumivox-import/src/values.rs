//! What a volume's values mean, where its file does not say it, says it wrongly, or the user knows better.

use lumivox_core::{Modality, Volume, Voxels, calibration};
use rayon::prelude::*;

use crate::ImportOptions;

/// What the user says of a scan's values, in place of what its file does.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Told {
    pub slope: Option<f64>,
    pub intercept: Option<f64>,
    pub modality: Option<Modality>,
    pub unit: Option<String>,
}

impl Told {
    pub fn by(options: &ImportOptions) -> Self {
        let ImportOptions { slope, intercept, modality, unit, .. } = options;
        Self { slope: *slope, intercept: *intercept, modality: *modality, unit: unit.clone() }
    }

    /// Slope and intercept of stored numbers, of which the file says `own`.
    pub fn rescale(&self, own: [f64; 2]) -> [f64; 2] {
        [self.slope.unwrap_or(own[0]), self.intercept.unwrap_or(own[1])]
    }

    /// The volume with the modality and the unit that were told. Of values that were given another scale, the file's unit
    /// says nothing any more, but where it is a modality's usual one.
    pub fn apply(&self, volume: Volume) -> Volume {
        let is_rescaled = self.slope.is_some() || self.intercept.is_some();
        let volume = match self.modality {
            Some(modality) => volume.with_modality(modality),
            None if is_rescaled => {
                let usual = volume.modality().usual_unit();
                volume.with_unit(usual)
            }
            None => volume,
        };
        match &self.unit {
            Some(unit) => volume.with_unit(unit.clone()),
            None => volume,
        }
    }
}

/// Says what is odd about values, and takes the unit from a CT whose values cannot be Hounsfield units; unless the user said
/// that they are.
pub(crate) fn judged(volume: Volume, told: &Told, notes: &mut Vec<String>) -> Volume {
    notes.extend(wrapped(volume.dims(), volume.voxels()));
    if told.unit.is_some() {
        return volume;
    }
    let Some(peaks) = calibration::uncalibrated(&volume) else { return volume };
    notes.push(format!(
        "values are not calibrated: air lies at {:.0} and tissue at {:.0}, which are no Hounsfield units; looks of CT are \
         placed by these two",
        peaks.air, peaks.tissue
    ));
    volume.with_unit("")
}

/// Air at -1000 and bone above 300 in one scan of integers are hardly ever anything but CT. A few voxels may be beyond.
pub(crate) fn looks_like_hounsfield(volume: &Volume) -> bool {
    /// What the range of a CT is told by, as parts of all voxels.
    const LEAST: f64 = 5e-4;
    const AIR: [f64; 2] = [-1150.0, -850.0];
    const SOME: f64 = 0.005;
    let [min, max] = volume.value_range();
    if min > -900.0 || max < 300.0 {
        return false;
    }
    let statistics = volume.statistics();
    let [low, high] = [LEAST, 1.0 - LEAST].map(|p| statistics.percentile(p));
    low >= -10_000.0
        && high <= 70_000.0
        && !calibration::goes_below_air(volume)
        && (statistics.share(AIR) >= SOME || low <= -900.0 && !volume.is_signed_map())
}

/// A sentence about voxels whose values were too large for 16 bits with a sign, and so became the lowest, beside others that
/// nearly were.
fn wrapped([columns, ..]: [usize; 3], voxels: &Voxels) -> Option<String> {
    /// Neighbours that are so far apart are no edge of anything.
    const JUMP: u16 = 60_000;
    /// As many may be noise.
    const LEAST: usize = 8;
    /// More voxels with such values are no exception.
    const PART: usize = 100;
    let Voxels::U16(samples) = voxels else { return None };
    let is_extreme = |sample: u16| !(u16::MAX - JUMP..=JUMP).contains(&sample);
    let of_row = |row: &[u16]| {
        let jumps = row.windows(2).filter(|pair| pair[0].abs_diff(pair[1]) >= JUMP).count();
        (jumps, row.iter().filter(|sample| is_extreme(**sample)).count())
    };
    let sum = |a: (usize, usize), b: (usize, usize)| (a.0 + b.0, a.1 + b.1);
    let (jumps, extreme) = samples.par_chunks(columns).map(of_row).reduce(|| (0, 0), sum);
    (jumps >= LEAST && extreme * PART < samples.len()).then(|| {
        format!(
            "in {jumps} places the highest values of 16 bits lie beside the lowest: values too large for them have wrapped \
             around, as at metal, and look like air"
        )
    })
}

#[cfg(test)]
mod tests {
    use lumivox_core::glam::DAffine3;

    use super::*;

    fn volume(voxels: Voxels, rescale: [f64; 2], modality: Modality) -> Volume {
        Volume::new([20, voxels.len() / 20, 1], voxels, rescale, DAffine3::IDENTITY, modality).unwrap()
    }

    #[test]
    fn metal_that_wrapped_is_told() {
        // A body with a rod of metal, whose brightest voxels came out as the lowest.
        let sample = |i: usize| match i {
            4000..4040 if i.is_multiple_of(2) => 65_500u16,
            4000..4040 => 40,
            _ => 31_800 + (i * 37 % 1800) as u16,
        };
        let ct = volume(Voxels::U16((0..20_000).map(sample).collect()), [1.0, -32768.0], Modality::Ct);
        let mut notes = Vec::new();
        let judged = judged(ct, &Told::default(), &mut notes);
        assert!(judged.is_hounsfield());
        assert!(notes[0].contains("have wrapped around"), "{notes:?}");
        let mask =
            Voxels::U16((0..20_000usize).map(|i| if i.is_multiple_of(3) { u16::MAX } else { 0 }).collect());
        assert_eq!(wrapped([20, 1000, 1], &mask), None);
    }

    #[test]
    fn a_phase_image_is_no_ct() {
        // Noise of all phases in the air, a slow change in the body.
        let noise = |i: usize| (i * 7919 % 8191) as i32 - 4095;
        let phase = |i: usize| if i.is_multiple_of(3) { (i / 3 % 2000) as i32 - 1000 } else { noise(i) };
        let ct = |i: usize| match i % 10 {
            0..5 => -1000 + (i % 41) as i32 - 20,
            5 => -2000,
            6 => 1200,
            _ => 40 + (i % 41) as i32 - 20,
        };
        let is_ct = |value: &dyn Fn(usize) -> i32| {
            let voxels = Voxels::U16((0..30_000).map(|i| (value(i) + 32768) as u16).collect());
            let volume = volume(voxels, [1.0, -32768.0], Modality::Other);
            [looks_like_hounsfield(&volume), volume.may_be_hounsfield()]
        };
        assert_eq!(is_ct(&phase), [false; 2]);
        assert_eq!(is_ct(&noise), [false; 2]);
        assert_eq!(is_ct(&ct), [true; 2]);
    }

    #[test]
    fn what_the_user_says_goes_first() {
        let voxels =
            || Voxels::U16((0..8000usize).map(|i| if i.is_multiple_of(3) { 24 } else { 1064 }).collect());
        let mut notes = Vec::new();
        let ct = volume(voxels(), [1.0, 0.0], Modality::Ct);
        let told = Told { modality: Some(Modality::Ct), ..Told::default() };
        let found = judged(told.apply(ct.clone()), &told, &mut notes);
        assert_eq!((found.unit(), notes.len()), ("", 1), "{notes:?}");
        assert!(notes[0].contains("air lies at 24 and tissue at 1064"), "{notes:?}");
        let told = Told { unit: Some("HU".into()), ..told };
        assert_eq!(judged(told.apply(ct), &told, &mut notes).unit(), "HU");
        let told = Told { intercept: Some(-1024.0), ..Told::default() };
        assert_eq!(told.rescale([2.0, 5.0]), [2.0, -1024.0]);
        let pet = volume(voxels(), [1.0, -1024.0], Modality::Pet).with_unit("SUV");
        assert_eq!(told.apply(pet).unit(), "");
        assert_eq!(notes.len(), 1);
    }
}
