//! What tells one scan from another.

use lumivox_core::{
    Volume,
    document::{self, Scan},
};
use sha2::{Digest, Sha256};

/// A scan as it was read, whose source says its content, so that documents that are saved of it do. What came from no file, or
/// says it already, stays as it is.
#[must_use]
pub fn identified(volume: Volume) -> Volume {
    if volume.source().is_none_or(|scan| scan.content.is_some()) {
        return volume;
    }
    let content = content_of(&volume);
    volume.with_source_changed(|scan| scan.content = Some(content))
}

/// Whether a volume that is [identified] is another than the scan that a document was saved with, as far as that says.
pub fn is_another(scan: &Scan, volume: &Volume) -> bool {
    let found = volume.source().and_then(|source| source.content.as_ref());
    scan.content.is_some() && found != scan.content.as_ref()
}

/// The hash of a scan's grid, place and values, as documents say it: `sha256:` and hexadecimal digits. Of scans as they were
/// read, before anything was taken out of them.
pub fn content_of(volume: &Volume) -> String {
    let mut hash = Sha256::new();
    volume.dims().iter().for_each(|n| hash.update((*n as u64).to_le_bytes()));
    let place = document::rows(volume.patient_from_voxel());
    let numbers = place
        .as_flattened()
        .iter()
        .chain([volume.slope(), volume.intercept()].iter())
        .copied()
        .collect::<Vec<_>>();
    numbers.iter().for_each(|number| hash.update(number.to_bits().to_le_bytes()));
    hash.update([volume.voxels().bytes_per_sample() as u8]);
    // As little-endian machines have them, which all are that anybody runs this on.
    hash.update(volume.voxels().as_bytes());
    let digits: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    format!("sha256:{digits}")
}
