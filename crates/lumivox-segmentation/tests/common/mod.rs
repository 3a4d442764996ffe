//! Comparisons with a known truth.

#[allow(dead_code, reason = "not every test program uses every helper")]
pub mod chest;

use lumivox_core::{CancelToken, Progress, Volume};
use lumivox_segmentation::{Class, Segmentation, segment};

/// Segments, and says what was found when a test fails.
#[allow(dead_code, reason = "not every test program uses every helper")]
pub fn run(volume: &Volume) -> Segmentation {
    let found = segment(volume, Progress::SILENT, &CancelToken::new()).unwrap();
    println!("{}", found.report);
    found
}

/// The share of the voxels that are `wanted` which got a label that is `right`; 1 where none is wanted.
#[allow(dead_code, reason = "not every test program uses every helper")]
pub fn share(
    found: &Segmentation,
    wanted: impl Fn(usize) -> bool,
    right: impl Fn(Option<Class>) -> bool,
) -> f64 {
    let (mut all, mut hits) = (0u64, 0u64);
    for (_, &label) in found.labels.voxels().iter().enumerate().filter(|&(i, _)| wanted(i)) {
        all += 1;
        hits += u64::from(right(Class::of(label)));
    }
    if all == 0 { 1.0 } else { hits as f64 / all as f64 }
}

/// Dice's coefficient of the voxels of a class and those that are `wanted`.
#[allow(dead_code, reason = "not every test program uses every helper")]
pub fn dice(found: &Segmentation, class: Class, wanted: impl Fn(usize) -> bool) -> f64 {
    let (mut both, mut sum) = (0u64, 0u64);
    for (i, &label) in found.labels.voxels().iter().enumerate() {
        let (is, should) = (label == class.value(), wanted(i));
        both += u64::from(is && should);
        sum += u64::from(is) + u64::from(should);
    }
    if sum == 0 { 1.0 } else { 2.0 * both as f64 / sum as f64 }
}
