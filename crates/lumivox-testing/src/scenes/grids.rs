//! What the test scenes are made of: values on grids, and volumes of them.

use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{Modality, Volume, Voxels};

/// Smooth noise between about -1000 and 1000, kept as unsigned 16-bit samples at a spacing of (1, 1, 1.2) mm.
pub fn noise_volume(seed: u64, dims: [usize; 3]) -> Arc<Volume> {
    let lattice = |cells: f64, salt: u64, p: DVec3| {
        let p = p * cells;
        let base = p.floor();
        let f = p - base;
        let f = f * f * (3.0 - 2.0 * f);
        let mut sum = 0.0;
        for corner in 0..8u64 {
            let offset = DVec3::from_array([0, 1, 2].map(|axis| (corner >> axis & 1) as f64));
            let w = offset * f + (1.0 - offset) * (1.0 - f);
            let node = base + offset;
            let key = [node.x, node.y, node.z].iter().fold(seed ^ salt << 32, |key, c| hash(key ^ *c as u64));
            sum += w.x * w.y * w.z * (key >> 11) as f64 / (1u64 << 53) as f64;
        }
        2.0 * sum - 1.0
    };
    fill(dims, DAffine3::from_scale(DVec3::new(1.0, 1.0, 1.2)), |p| {
        1100.0 * (lattice(3.7, 1, p) + 0.4 * lattice(8.3, 2, p))
    })
    .signed_16()
}

/// SplitMix64's finaliser (Steele, Lea and Flood 2014).
fn hash(key: u64) -> u64 {
    let z = key.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ z >> 31
}

/// Values on a grid, on their way to become a volume of some sample type.
#[derive(Clone, Debug)]
pub struct Grid {
    dims: [usize; 3],
    place: DAffine3,
    values: Vec<f64>,
}

/// A grid of `value(p)` with `p` in box coordinates.
pub fn fill(dims: [usize; 3], place: DAffine3, value: impl Fn(DVec3) -> f64) -> Grid {
    let mut values = Vec::with_capacity(dims.iter().product());
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let index = DVec3::new(x as f64, y as f64, z as f64);
                values.push(value((index + 0.5) / DVec3::from_array(dims.map(|n| n as f64))));
            }
        }
    }
    Grid { dims, place, values }
}

/// A ball in a grid of `n` mm: 1 in its middle, falling to 0 from a radius of 0.28 to one of 0.46 of the box.
pub fn ball(n: usize) -> Grid {
    fill([n; 3], DAffine3::IDENTITY, |p| ((0.46 - (p - 0.5).length()) / 0.18).clamp(0.0, 1.0))
}

impl Grid {
    pub fn placed(mut self, place: DAffine3) -> Self {
        self.place = place;
        self
    }

    pub fn spacing(self, spacing_mm: DVec3) -> Self {
        self.placed(DAffine3::from_scale(spacing_mm))
    }

    fn volume(self, voxels: Voxels, rescale: [f64; 2]) -> Arc<Volume> {
        Arc::new(Volume::new(self.dims, voxels, rescale, self.place, Modality::Other).expect("a valid grid"))
    }

    /// Values of 0 to 1 in 8 bits.
    pub fn u8(self) -> Arc<Volume> {
        let samples = self.values.iter().map(|v| (v * 250.0).round() as u8).collect();
        self.volume(Voxels::U8(samples), [1.0 / 250.0, 0.0])
    }

    /// Values of 0 to 1 in 16 bits.
    pub fn u16(self) -> Arc<Volume> {
        let samples = self.values.iter().map(|v| (v * 50_000.0).round() as u16).collect();
        self.volume(Voxels::U16(samples), [1.0 / 50_000.0, 0.0])
    }

    /// Values as a CT keeps them: whole numbers with an offset.
    pub fn signed_16(self) -> Arc<Volume> {
        let samples = self.values.iter().map(|v| (v + 32_768.0).round() as u16).collect();
        self.volume(Voxels::U16(samples), [1.0, -32_768.0])
    }

    /// Values as they are.
    pub fn f32(self) -> Arc<Volume> {
        let samples = self.values.iter().map(|v| *v as f32).collect();
        self.volume(Voxels::F32(samples), [1.0, 0.0])
    }
}
