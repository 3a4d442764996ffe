//! Coarse copies of large volumes: what is shown of them while they arrive, made where they are loaded.

use std::sync::Arc;

use lumivox_core::Volume;

use super::bricks;
use super::source::{Reading, Source};
use crate::derived::Derived;

/// Bytes that any frame can bring to the device: volumes that are no larger need no coarse copy.
pub(super) const QUICK_BYTES: u64 = 4 << 20;

/// Voxels of a coarse copy at most: it comes in one frame, whatever that has left.
const COARSE_VOXELS: usize = 100 * 100 * 100;

/// Coarse copies that were made ahead, as 16-bit fractions in the order of bricks; by whether they are of labels.
static COARSE: Derived<Volume, bool, Vec<u16>> = Derived::new();

/// Makes ahead, on this thread and rayon's, what a store shows of a large volume while it arrives: best where it is
/// loaded. Nothing to do for small ones, or if it was done before.
pub fn prepare_volume(volume: &Arc<Volume>) {
    prepare_source(&Source { volume: volume.clone(), reading: Reading::Plain });
}

/// The same for a volume that is read in another way.
pub(crate) fn prepare_source(source: &Source) {
    if needs_coarse_copy(&source.volume) {
        coarse_copy(source);
    }
}

/// A copy reduced by [`coarse_factor`], and whether it was made just now.
pub(super) fn coarse_copy(source: &Source) -> (Arc<Vec<u16>>, bool) {
    let (volume, of_labels) = (&source.volume, source.reading == Reading::Labels);
    let factor = coarse_factor(volume);
    COARSE.get_or(volume, of_labels, || bricks::fractions_of_all(volume, source.reading, factor))
}

/// Whether [`prepare_source`] has nothing to do.
pub(super) fn is_prepared(source: &Source) -> bool {
    let of_labels = source.reading == Reading::Labels;
    !needs_coarse_copy(&source.volume) || COARSE.get(&source.volume, &of_labels).is_some()
}

pub(super) fn needs_coarse_copy(volume: &Volume) -> bool {
    // What pools take for it, at 16 bits.
    2 * volume.voxel_count() as u64 > QUICK_BYTES
}

/// The least factor by which the copy becomes small.
pub(super) fn coarse_factor(volume: &Volume) -> u32 {
    let is_small = |factor: &u32| {
        volume.dims().iter().map(|n| n.div_ceil(*factor as usize)).product::<usize>() <= COARSE_VOXELS
    };
    (2..1 << 16).find(is_small).unwrap_or(1 << 16)
}
