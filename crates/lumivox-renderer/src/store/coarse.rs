//! Coarse copies of large volumes: what is shown of them while they arrive, made where they are loaded.

use std::sync::Arc;

use lumivox_core::Volume;

use super::bricks;
use crate::derived::Derived;

/// Bytes that any frame can bring to the device: volumes that are no larger need no coarse copy.
pub(super) const QUICK_BYTES: u64 = 4 << 20;

/// Voxels of a coarse copy at most: it comes in one frame, whatever that has left.
const COARSE_VOXELS: usize = 100 * 100 * 100;

/// Coarse copies that were made ahead, as 16-bit fractions in the order of bricks.
static COARSE: Derived<Volume, (), Vec<u16>> = Derived::new();

/// Makes ahead, on this thread and rayon's, what a store shows of a large volume while it arrives: best where it is
/// loaded. Nothing to do for small ones, or if it was done before.
pub fn prepare_volume(volume: &Arc<Volume>) {
    if needs_coarse_copy(volume) {
        coarse_copy(volume);
    }
}

/// A copy reduced by [`coarse_factor`], and whether it was made just now.
pub(super) fn coarse_copy(volume: &Arc<Volume>) -> (Arc<Vec<u16>>, bool) {
    COARSE.get_or(volume, (), || bricks::fractions_of_all(volume, coarse_factor(volume)))
}

/// Whether [`prepare_volume`] has nothing to do.
pub(super) fn is_prepared(volume: &Arc<Volume>) -> bool {
    !needs_coarse_copy(volume) || COARSE.get(volume, &()).is_some()
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
