//! All volumes of a scene in one 3D texture, so that a kernel binds one texture whatever the number of volumes.

use std::sync::Arc;

use lumivox_core::{Volume, Voxels};
use rayon::prelude::*;

use super::value_ranges::GridKey;
use crate::error::RenderError;
use crate::recording::{Payload, Recording, ResourceId, Step, TextureFormat};

/// Bytes of one upload: small enough to bound the memory of staging, large enough to be fast.
const UPLOAD_BYTES: usize = 32 << 20;

/// The texture, and what of it no volume is in.
#[derive(Debug)]
pub(crate) struct Atlas {
    pub texture: ResourceId,
    format: TextureFormat,
    /// Voxels along each axis.
    pub size: [u32; 3],
    /// Where volumes were that have gone.
    pub free: Vec<Slot>,
}

/// A box of an atlas for a volume no larger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slot {
    /// Its first voxel.
    pub origin: [u32; 3],
    /// Voxels along each axis.
    pub size: [u32; 3],
}

impl Slot {
    pub fn fits(self, dims: [usize; 3]) -> bool {
        (0..3).all(|axis| dims[axis] <= self.size[axis] as usize)
    }

    pub fn voxels(self) -> u64 {
        voxels(self.size)
    }
}

/// Voxels of a box.
pub(crate) fn voxels(size: [u32; 3]) -> u64 {
    size.iter().map(|&n| u64::from(n)).product()
}

/// Where each volume lies in an atlas.
#[derive(Debug, PartialEq)]
pub(crate) struct Arrangement {
    /// The place of each volume.
    pub slots: Vec<Slot>,
    /// The atlas' size.
    pub size: [u32; 3],
}

/// How a stored texel in [0, 1] becomes a physical value: `texel * per_texel + at_zero`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TexelScale {
    pub per_texel: f64,
    pub at_zero: f64,
}

impl TexelScale {
    pub fn of(volume: &Volume) -> Self {
        let (slope, intercept) = (volume.slope(), volume.intercept());
        match volume.voxels() {
            Voxels::U8(_) => Self { per_texel: slope * 255.0, at_zero: intercept },
            Voxels::U16(_) => Self { per_texel: slope * 65535.0, at_zero: intercept },
            // Floats are quantised to 16 bits over their range: an error of at most 1/131070 of it.
            Voxels::F32(_) => {
                let [min, max] = volume.stored_range();
                Self { per_texel: slope * (max - min), at_zero: intercept + slope * min }
            }
        }
    }
}

/// A float as a 16-bit fraction of the range of stored values.
pub(crate) fn quantise(x: f32, [min, max]: [f64; 2]) -> u16 {
    let scale = if max > min { 65535.0 / (max - min) } else { 0.0 };
    ((f64::from(x) - min) * scale).round() as u16
}

/// The stored samples `range` as 16-bit fractions.
pub(crate) fn fractions(volume: &Volume, range: std::ops::Range<usize>) -> Vec<u16> {
    match volume.voxels() {
        Voxels::U8(v) => v[range].iter().map(|&x| u16::from(x) * 257).collect(),
        Voxels::U16(v) => v[range].to_vec(),
        Voxels::F32(v) => {
            let range_of_values = volume.stored_range();
            v[range].par_iter().map(|&x| quantise(x, range_of_values)).collect()
        }
    }
}

impl Atlas {
    /// Records a texture for `volumes`.
    pub fn new(volumes: &[(Arc<Volume>, GridKey)], size: [u32; 3], recording: &mut Recording) -> Self {
        let eight_bit =
            !volumes.is_empty() && volumes.iter().all(|(v, _)| matches!(v.voxels(), Voxels::U8(_)));
        let format = if eight_bit { TextureFormat::R8Unorm } else { TextureFormat::R16Unorm };
        let texture = recording.create_texture("volume atlas", format, size);
        Self { texture, format, size, free: vec![] }
    }

    /// Whether its texels are fine enough for a volume.
    pub fn holds(&self, volume: &Volume) -> bool {
        self.format == TextureFormat::R16Unorm || matches!(volume.voxels(), Voxels::U8(_))
    }

    /// Its size in voxels.
    pub fn voxels(&self) -> u64 {
        voxels(self.size)
    }

    /// Records the upload of a volume.
    pub fn record_upload(&self, volume: &Arc<Volume>, slot: Slot, recording: &mut Recording) {
        record_upload(volume, self.texture, self.format, slot.origin, recording);
    }
}

/// Finds room for volumes in an atlas of at most `max_size` along each axis.
pub(crate) fn arrange(volumes: &[(Arc<Volume>, GridKey)], max_size: u32) -> Result<Arrangement, RenderError> {
    let mut sizes = Vec::with_capacity(volumes.len());
    for (volume, _) in volumes {
        let dims = volume.dims();
        if dims.iter().any(|&n| n > max_size as usize) {
            return Err(RenderError::VolumeTooLarge { dims, limit: max_size });
        }
        sizes.push(dims.map(|n| n as u32));
    }
    pack(&sizes, max_size).ok_or(RenderError::TooManyVolumes { count: volumes.len(), limit: max_size })
}

/// A volume's samples as they lie in memory, kept alive by the recording.
struct StoredBytes(Arc<Volume>);

impl AsRef<[u8]> for StoredBytes {
    fn as_ref(&self) -> &[u8] {
        self.0.voxels().as_bytes()
    }
}

fn record_upload(
    volume: &Arc<Volume>,
    texture: ResourceId,
    format: TextureFormat,
    origin: [u32; 3],
    recording: &mut Recording,
) {
    let [nx, ny, nz] = volume.dims();
    let slice = nx * ny;
    let slices_per_upload = (UPLOAD_BYTES / (slice * format.bytes_per_texel())).max(1);
    let as_stored = volume.voxels().bytes_per_sample() == format.bytes_per_texel();
    let bytes: Arc<dyn AsRef<[u8]> + Send + Sync> = Arc::new(StoredBytes(volume.clone()));
    for z in (0..nz).step_by(slices_per_upload) {
        let depth = slices_per_upload.min(nz - z);
        let samples = z * slice..(z + depth) * slice;
        let data = if as_stored {
            let width = format.bytes_per_texel();
            Payload::slice(bytes.clone(), samples.start * width..samples.end * width)
        } else {
            Payload::copy_of(&fractions(volume, samples))
        };
        recording.push(Step::WriteTexture {
            id: texture,
            origin: [origin[0], origin[1], origin[2] + z as u32],
            size: [nx as u32, ny as u32, depth as u32],
            data,
        });
    }
}

/// Origins for boxes in one box of at most `max` along each axis, and its size. One box is packed without waste;
/// several lie on shelves: rows along x, rows along y into layers, layers along z, large boxes first.
fn pack(sizes: &[[u32; 3]], max: u32) -> Option<Arrangement> {
    if sizes.is_empty() {
        return Some(Arrangement { slots: vec![], size: [1, 1, 1] });
    }
    let widest = |axis: usize| sizes.iter().map(|s| s[axis]).max().unwrap_or(1);
    // Shelves of every number of the widest boxes: the arrangement that fits with the least waste is kept.
    let ends =
        |axis: usize| (1..=sizes.len() as u32).map(move |n| n * widest(axis)).take_while(|&end| end <= max);
    ends(0)
        .take(32)
        .flat_map(|row_end| ends(1).take(32).map(move |layer_end| [row_end, layer_end]))
        .map(|ends| pack_shelves(sizes, ends))
        .filter(|a| a.size.iter().all(|&n| n <= max))
        .min_by_key(|a| voxels(a.size))
}

/// Fills rows up to `row_end` along x and layers up to `layer_end` along y.
fn pack_shelves(sizes: &[[u32; 3]], [row_end, layer_end]: [u32; 2]) -> Arrangement {
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse((sizes[i][2], sizes[i][1], sizes[i][0])));
    let mut slots: Vec<Slot> = sizes.iter().map(|&size| Slot { origin: [0; 3], size }).collect();
    let (mut cursor, mut row_height, mut layer_depth, mut used) = ([0u32; 3], 0, 0, [0u32; 3]);
    for i in order {
        let size = sizes[i];
        if cursor[0] + size[0] > row_end {
            cursor = [0, cursor[1] + row_height, cursor[2]];
            row_height = 0;
        }
        if cursor[1] + size[1] > layer_end {
            cursor = [0, 0, cursor[2] + layer_depth];
            (row_height, layer_depth) = (0, 0);
        }
        slots[i].origin = cursor;
        for axis in 0..3 {
            used[axis] = used[axis].max(cursor[axis] + size[axis]);
        }
        cursor[0] += size[0];
        row_height = row_height.max(size[1]);
        layer_depth = layer_depth.max(size[2]);
    }
    Arrangement { slots, size: used }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_do_not_overlap_and_one_wastes_nothing() {
        assert_eq!(
            pack(&[[512, 300, 7]], 2048),
            Some(Arrangement {
                slots: vec![Slot { origin: [0; 3], size: [512, 300, 7] }],
                size: [512, 300, 7]
            })
        );
        let sizes: Vec<[u32; 3]> =
            (0..100).map(|i| [20 + i % 7 * 5, 30 + i % 11 * 3, 10 + i % 13 * 4]).collect();
        let Arrangement { slots, size } = pack(&sizes, 2048).unwrap();
        let origins: Vec<[u32; 3]> = slots.iter().map(|slot| slot.origin).collect();
        for i in 0..sizes.len() {
            assert!((0..3).all(|a| origins[i][a] + sizes[i][a] <= size[a]));
            for j in 0..i {
                let apart = (0..3).any(|a| {
                    origins[i][a] + sizes[i][a] <= origins[j][a]
                        || origins[j][a] + sizes[j][a] <= origins[i][a]
                });
                assert!(apart, "{i} and {j} overlap");
            }
        }
        let used: u64 = sizes.iter().map(|s| s.iter().map(|&n| u64::from(n)).product::<u64>()).sum();
        let taken: u64 = size.iter().map(|&n| u64::from(n)).product();
        assert!(taken < used * 3, "{taken} voxels for {used}");
        assert_eq!(pack(&[[2000; 3], [2000; 3], [2000; 3]], 2048), None);
        for count in 1..=12 {
            assert!(pack(&vec![[512, 512, 400]; count], 2048).is_some(), "{count} scans fit");
        }
    }
}
