//! The patient alone: what a scan shows besides the patient becomes air.

use lumivox_core::{CancelToken, Cancelled, LabelVolume, Progress, Volume, Voxels, document::Keep};
use rayon::prelude::*;

use crate::{
    class::Class,
    progress::Steps,
    report::SegmentationReport,
    surroundings::{Removed, Surroundings},
};

/// A thing is blurred into the air around it so far, in mm, and at least one voxel; that goes, too.
const RIM_MM: f64 = 1.5;

/// The most voxels of that, where they are small.
const MOST_RIM: usize = 4;

/// Where a thing touches the skin, it becomes skin in part, so that the skin has no stairs: no denser than water, whatever
/// the thing is of.
const WATER_HU: f64 = 0.0;

/// Air is worth the median of so many voxels.
const AIR_SAMPLES: usize = 1 << 20;

/// Voxels that are looked through at a time.
const CHUNK: usize = 1 << 18;

/// The share of the work that finding the patient is; the rest makes things air.
const FINDING: f64 = 0.7;

/// A scan without the things around the patient.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct PatientAlone {
    /// The scan; every voxel of the patient is as it was.
    pub volume: Volume,
    /// What was found; `None` where nothing was looked for: values are, and may be, no Hounsfield units.
    pub report: Option<SegmentationReport>,
    /// What belongs to what; `None` where nothing was looked for.
    pub labels: Option<LabelVolume>,
    /// Voxels that were changed.
    pub changed: usize,
    /// What they were before; `None` where none was changed.
    pub surroundings: Option<Surroundings>,
}

impl PatientAlone {
    /// What was hidden, or why nothing was, as a sentence for people; `None` where there was nothing to hide.
    pub fn note(&self) -> Option<String> {
        let report = self.report.as_ref()?;
        if !report.is_sure() {
            let why = report.notes.first().map_or(String::new(), |why| format!(": {why}"));
            return Some(format!(
                "what lies around the patient stays visible, for it could not be told apart{why}"
            ));
        }
        let things: Vec<String> = (report.findings.iter())
            .filter(|found| found.class.is_thing() && found.class != Class::Noise)
            .map(|found| format!("{} ({})", found.class.name(), found.size()))
            .collect();
        let sure = report.confidence;
        (!things.is_empty()).then(|| format!("hidden: {}; confidence {sure:.2}", things.join(", ")))
    }
}

/// Finds in a CT in Hounsfield units, or in what has their range, what is not the patient (table, head-rest, blankets, cables, specks) and makes it air,
/// with the rim that it blurs into the air around it. Air, the patient and the voxels that are skin in part stay as they
/// are, to the bit. Any other scan, and one in which the patient is not told apart for sure
/// ([`LEAST_CONFIDENCE`](crate::LEAST_CONFIDENCE)), comes back as it was.
///
/// # Errors
/// [`Cancelled`] when `cancel` was used.
pub fn patient_alone(
    volume: Volume,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<PatientAlone, Cancelled> {
    if !volume.is_hounsfield() && !volume.may_be_hounsfield() {
        let volume = volume.with_source_changed(|scan| scan.keep = Keep::Patient);
        return Ok(PatientAlone { volume, report: None, labels: None, changed: 0, surroundings: None });
    }
    let steps = Steps::first(progress, FINDING);
    let (labels, report) = crate::labels_of(&volume, &steps, cancel)?;
    let things = report.findings.iter().any(|found| found.class.is_thing());
    let (volume, surroundings) = if report.is_sure() && things {
        without_things(volume, &labels, cancel, &|part| steps.report_rest(part))?
    } else {
        (volume, None)
    };
    steps.report_rest(1.0);
    let volume = volume.with_source_changed(|scan| scan.keep = Keep::Patient);
    let changed = surroundings.as_ref().map_or(0, Surroundings::voxel_count);
    Ok(PatientAlone { volume, report: Some(report), labels: Some(labels), changed, surroundings })
}

/// The volume with air where things are, and what was there.
fn without_things(
    volume: Volume,
    labels: &LabelVolume,
    cancel: &CancelToken,
    step: &(dyn Fn(f64) + Sync),
) -> Result<(Volume, Option<Surroundings>), Cancelled> {
    let mask = Mask::new(&volume, labels, cancel)?;
    step(0.3);
    let stored = |value: f64| (value - volume.intercept()) / volume.slope();
    let (air, water) = (stored(air_value(&volume, labels)), stored(WATER_HU));
    let mut taken = Ok(None);
    let volume = volume
        .edit(|voxels| {
            let step = |part: f64| step(0.3 + 0.6 * part);
            let values = [air, water];
            taken = match voxels {
                Voxels::U8(all) => mask
                    .hide(all, values, |v| v.round() as u8, cancel, &step)
                    .map(|removed| Surroundings::of(removed, Voxels::U8)),
                Voxels::U16(all) => mask
                    .hide(all, values, |v| v.round() as u16, cancel, &step)
                    .map(|removed| Surroundings::of(removed, Voxels::U16)),
                Voxels::F32(all) => mask
                    .hide(all, values, |v| v as f32, cancel, &step)
                    .map(|removed| Surroundings::of(removed, Voxels::F32)),
            };
        })
        .expect("values between those of a volume make one");
    Ok((volume, taken?))
}

/// What air is worth: the median of what was found to be air, within the scan's values.
pub fn air_value(volume: &Volume, labels: &LabelVolume) -> f64 {
    let is_air = |label: &u8| *label == Class::Air.value();
    let chunks = || labels.voxels().par_chunks(CHUNK);
    let counts: Vec<usize> = chunks().map(|chunk| chunk.iter().filter(|&it| is_air(it)).count()).collect();
    let stride = (counts.iter().sum::<usize>() / AIR_SAMPLES).max(1);
    // Of those before each chunk the last that was taken says where it goes on.
    let before = counts.iter().scan(0, |sum, count| Some(std::mem::replace(sum, *sum + count)));
    let before: Vec<usize> = before.collect();
    let values = chunks().zip(before).enumerate().flat_map_iter(|(place, (chunk, before))| {
        let air = chunk.iter().enumerate().filter(|&(_, label)| is_air(label));
        let air = air.skip(before.next_multiple_of(stride) - before).step_by(stride);
        air.map(move |(i, _)| volume.voxels().get(place * CHUNK + i))
    });
    let mut values: Vec<f64> = values.collect();
    let [low, high] = volume.value_range();
    if values.is_empty() {
        return (-1000f64).clamp(low, high);
    }
    let middle = values.len() / 2;
    let stored = *values.select_nth_unstable_by(middle, f64::total_cmp).1;
    stored * volume.slope() + volume.intercept()
}

/// Which voxels are near a thing, and which near the patient: a bit for each, in rows along x.
struct Mask<'a> {
    dims: [usize; 3],
    labels: &'a [u8],
    /// Voxels along each axis that a thing's rim is wide.
    rim: [usize; 3],
    /// Words of a row.
    words: usize,
    /// What is so near to a thing of its own row.
    things: Vec<u64>,
    /// What is next to a voxel of the patient's of its own row, or is one.
    patient: Vec<u64>,
}

fn is_thing(label: u8) -> bool {
    Class::of(label).is_some_and(Class::is_thing)
}

fn is_patient(label: u8) -> bool {
    Class::of(label).is_some_and(Class::is_patient)
}

/// From `reach` before `at` to `reach` behind it, within `n`.
fn around(at: usize, reach: usize, n: usize) -> std::ops::Range<usize> {
    at.saturating_sub(reach)..(at + reach + 1).min(n)
}

/// Sets the bits beside those that are set, too.
fn widen(row: &mut [u64]) {
    let mut before = 0;
    for i in 0..row.len() {
        let (own, next) = (row[i], row.get(i + 1).copied().unwrap_or(0));
        row[i] = own | own << 1 | own >> 1 | before >> 63 | next << 63;
        before = own;
    }
}

impl<'a> Mask<'a> {
    fn new(volume: &Volume, labels: &'a LabelVolume, cancel: &CancelToken) -> Result<Self, Cancelled> {
        let dims = labels.dims();
        let rim = volume.spacing_mm().to_array().map(|mm| ((RIM_MM / mm).ceil() as usize).clamp(1, MOST_RIM));
        let labels = labels.voxels();
        let [is_thing, is_patient]: [[bool; 256]; 2] =
            [is_thing, is_patient].map(|is: fn(u8) -> bool| std::array::from_fn(|label| is(label as u8)));
        let all = |is: bool| if is { u64::MAX } else { 0 };
        let words = dims[0].div_ceil(64);
        let [mut things, mut patient] = [0, 1].map(|_| vec![0u64; words * dims[1] * dims[2]]);
        let rows = labels.par_chunks(dims[0]);
        let rows = rows.zip(things.par_chunks_mut(words)).zip(patient.par_chunks_mut(words));
        rows.try_for_each(|((row, things), patient)| {
            cancel.check()?;
            for ((labels, things), patient) in row.chunks(64).zip(things.iter_mut()).zip(patient.iter_mut()) {
                let first = labels[0];
                if labels.iter().all(|&label| label == first) {
                    // Most are, and bits beyond the row are asked of nobody.
                    (*things, *patient) =
                        (all(is_thing[usize::from(first)]), all(is_patient[usize::from(first)]));
                    continue;
                }
                for (bit, &label) in labels.iter().enumerate() {
                    *things |= u64::from(is_thing[usize::from(label)]) << bit;
                    *patient |= u64::from(is_patient[usize::from(label)]) << bit;
                }
            }
            (0..rim[0]).for_each(|_| widen(things));
            widen(patient);
            Ok(())
        })?;
        Ok(Self { dims, labels, rim, words, things, patient })
    }

    fn row(&self, y: usize, z: usize) -> &[u8] {
        let [nx, ny, _] = self.dims;
        &self.labels[(z * ny + y) * nx..][..nx]
    }

    /// Makes things air, in the samples' own unit; what they were, slice by slice.
    fn hide<T: Copy + PartialEq + Into<f64> + Send>(
        &self,
        samples: &mut [T],
        [air, water]: [f64; 2],
        from_f64: impl Fn(f64) -> T + Sync,
        cancel: &CancelToken,
        step: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<Removed<T>>, Cancelled> {
        let [nx, ny, nz] = self.dims;
        let done = std::sync::atomic::AtomicUsize::new(0);
        let slice = |(z, slice): (usize, &mut [T])| {
            cancel.check()?;
            let mut removed = Removed::default();
            let [mut near, mut at_patient] = [0, 1].map(|_| vec![0u64; self.words]);
            for (y, samples) in slice.chunks_exact_mut(nx).enumerate() {
                self.gather(&self.things, [y, z], [self.rim[1], self.rim[2]], &mut near);
                if near.iter().all(|&bits| bits == 0) {
                    continue;
                }
                self.gather(&self.patient, [y, z], [1, 1], &mut at_patient);
                let labels = self.row(y, z);
                let is_set = |bits: &[u64], x: usize| bits[x / 64] >> (x % 64) & 1 == 1;
                let share = |x: usize| match is_set(&at_patient, x) {
                    true => self.patient_share([x, y, z]),
                    false => 0.0,
                };
                for x in (0..nx).filter(|&x| is_set(&near, x)) {
                    let share = match labels[x] {
                        label if is_thing(label) => share(x),
                        // Skin in part.
                        label if label == Class::Air.value() && share(x) == 0.0 => 0.0,
                        _ => continue,
                    };
                    let was: f64 = samples[x].into();
                    // Slopes may be negative: then what is denser than water is less.
                    let most = if air < water { was.min(water) } else { was.max(water) };
                    let value = from_f64(air + (most - air) * share);
                    if value != samples[x] {
                        removed.push((z * ny + y) * nx + x, samples[x]);
                        samples[x] = value;
                    }
                }
            }
            let finished = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
            step(finished as f64 / nz as f64);
            Ok(removed)
        };
        samples.par_chunks_mut(nx * ny).enumerate().map(slice).collect()
    }

    /// The bits of a row and of those around it, as far as `reach` says.
    fn gather(&self, bits: &[u64], [y, z]: [usize; 2], reach: [usize; 2], into: &mut [u64]) {
        let [_, ny, nz] = self.dims;
        into.fill(0);
        for z in around(z, reach[1], nz) {
            for y in around(y, reach[0], ny) {
                let row = &bits[(z * ny + y) * self.words..][..self.words];
                into.iter_mut().zip(row).for_each(|(into, bits)| *into |= bits);
            }
        }
    }

    /// How much of a voxel and its neighbours is the patient, by binomial weights.
    fn patient_share(&self, at: [usize; 3]) -> f64 {
        let [nx, ny, nz] = self.dims;
        let [x, y, z] = at;
        let weight = |a: usize, b: usize| if a == b { 2 } else { 1 };
        let mut sum = 0;
        for near_z in around(z, 1, nz) {
            for near_y in around(y, 1, ny) {
                let row = self.row(near_y, near_z);
                for near_x in around(x, 1, nx).filter(|&near| is_patient(row[near])) {
                    sum += weight(x, near_x) * weight(y, near_y) * weight(z, near_z);
                }
            }
        }
        f64::from(sum) / 64.0
    }
}
