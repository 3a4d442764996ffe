//! What cells know, read back.

use lumivox_renderer::{Recording, Step};
use lumivox_shaders::Kernel;
use lumivox_wgpu::Gpu;

use super::Host;

/// What a cell has learnt: means of the light that is sent on there and of its colour, and of how many points.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    pub light: [f64; 3],
    pub color: [f64; 3],
    pub points: f32,
}

/// Two cells along each axis.
#[derive(Clone, Debug)]
pub struct Block {
    /// Of the volume.
    pub number: u32,
    pub tier: u32,
    /// In blocks of the tier.
    pub place: [u32; 3],
    pub cells: [Cell; 8],
}

/// A number that the kernels have.
fn constant(name: &str) -> usize {
    let text = Kernel::LightBegin.wgsl();
    let (_, rest) = text.split_once(&format!("const {name}: u32 = ")).expect("it is a constant");
    let digits = rest.split('u').next().unwrap_or_default();
    digits.parse().expect("it is a plain number")
}

/// Red, green and blue with a common exponent.
fn unpack_rgb(word: u32) -> [f64; 3] {
    let scale = f64::from((word >> 27) as i32 - 24).exp2();
    [0, 9, 18].map(|shift| f64::from((word >> shift) & 0x1ff) * scale)
}

/// All blocks that a view's cells are in.
pub fn read(host: &Host, gpu: &mut Gpu) -> Vec<Block> {
    let (id, size) = host.made["kept light"];
    let recording = Recording { steps: vec![Step::ReadBuffer { id, range: 0..size }] };
    let bytes = gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
    let words: Vec<u32> = bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
    let [header, given_up, block, place, means] =
        ["LIGHT_HEADER", "GIVEN_UP", "BLOCK_WORDS", "BLOCK_PLACE", "BLOCK_MEANS"].map(constant);
    // Buffers are rounded up to 16 bytes.
    let slots = (words.len() - header) / (block + 2);
    let is_taken = |slot: &usize| words[header + slot] > given_up as u32;
    let block_of = |slot: usize| {
        let words = &words[header + 2 * slots + slot * block..][..block];
        let [x, y] = [words[place], words[place + 1]];
        let cell = |i: usize| {
            let [light, color, points] = [0, 1, 2].map(|word| words[means + 3 * i + word]);
            Cell { light: unpack_rgb(light), color: unpack_rgb(color), points: f32::from_bits(points) }
        };
        Block {
            number: (y >> 16) & 0xfff,
            tier: y >> 28,
            place: [x & 0xffff, x >> 16, y & 0xffff],
            cells: std::array::from_fn(cell),
        }
    };
    (0..slots).filter(is_taken).map(block_of).collect()
}
