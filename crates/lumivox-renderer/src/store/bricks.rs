//! Volumes in bricks, and the texels of those.
//!
//! A brick holds [`BRICK_SIZE`] voxels along each axis and one more, its neighbours' first: a linear filter between its
//! voxels needs no other brick, and a texture unit filters as it would in a texture of the volume's own.

use lumivox_core::{Volume, Voxels};
use lumivox_shaders::constants::{BRICK_SIZE, BRICK_TEXELS, MAX_BRICKS};
use rayon::prelude::*;

use super::source::Reading;
use super::texels::Quantiser;
use super::{Bricks, Source, TEXELS};
use crate::recording::{Payload, TextureFormat};

/// So many are filled where they are wanted: other threads may be busy for longer than a frame.
const FEW_TEXELS: usize = 8 << 20;

/// The bricks of a volume, or of a copy that was reduced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BrickGrid {
    /// Voxels along each axis.
    pub dims: [u32; 3],
    /// Bricks along each axis.
    pub counts: [u32; 3],
}

/// Bricks next to each other, both in the volume and in a pool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Run {
    /// The first one's place among the volume's bricks.
    pub first: [u32; 3],
    /// Bricks along x and y.
    pub size: [u32; 2],
}

/// Texels of 16 bits, as bytes.
struct Words(Vec<u16>);

impl AsRef<[u8]> for Words {
    fn as_ref(&self) -> &[u8] {
        bytemuck::cast_slice(&self.0)
    }
}

impl Run {
    /// How many they are.
    pub fn bricks(self) -> usize {
        (self.size[0] * self.size[1]) as usize
    }
}

impl BrickGrid {
    /// Of a volume of which each voxel stands for `factor` along each axis.
    pub fn new(dims: [usize; 3], factor: u32) -> Self {
        let dims = dims.map(|n| n.div_ceil(factor as usize) as u32);
        Self { dims, counts: dims.map(|n| n.div_ceil(BRICK_SIZE)) }
    }

    pub fn count(self) -> u64 {
        self.counts.iter().map(|&n| u64::from(n)).product()
    }

    pub fn place(self, index: usize) -> [u32; 3] {
        let [nx, ny, _] = self.counts.map(|n| n as usize);
        [index % nx, index / nx % ny, index / (nx * ny)].map(|n| n as u32)
    }

    fn index(self, [x, y, z]: [u32; 3]) -> usize {
        ((z as usize * self.counts[1] as usize) + y as usize) * self.counts[0] as usize + x as usize
    }
}

/// The least power of two by which a volume has to be reduced for kernels to find its bricks: 1 but for the longest.
pub(super) fn least_factor(dims: [usize; 3]) -> u32 {
    let fits = |factor: &u32| BrickGrid::new(dims, *factor).counts.iter().all(|&n| n <= MAX_BRICKS);
    (0..31).map(|power| 1 << power).find(fits).unwrap_or(1 << 31)
}

/// The longest run of at most so many bricks from one on: whole rows, or a part of one.
pub(super) fn run(bricks: &Bricks, begin: usize, most: usize) -> Run {
    let grid = bricks.grid;
    let first = grid.place(begin);
    let [nx, ny, _] = grid.counts;
    let page = |x: u32, y: u32| bricks.pages[grid.index([x, y, first[2]])];
    let origin = bricks.pages[begin];
    let follows = |x: u32, y: u32| super::pools::is_beside(page(first[0] + x, first[1] + y), origin, [x, y]);
    let mut width = 1;
    while first[0] + width < nx && (width as usize) < most && follows(width, 0) {
        width += 1;
    }
    let mut height = 1;
    if width == nx {
        let row_follows = |y: u32| (0..nx).all(|x| follows(x, y));
        while first[1] + height < ny && (width * (height + 1)) as usize <= most && row_follows(height) {
            height += 1;
        }
    }
    Run { first, size: [width, height] }
}

/// Texels of a run, x fastest, as they are stored. What lies beyond the volume repeats its last voxel.
pub(super) fn texels(
    source: &Source,
    factor: u32,
    grid: BrickGrid,
    run: Run,
    format: TextureFormat,
) -> Payload {
    let volume = &*source.volume;
    if source.reading == Reading::Smooth && factor == 1 {
        return as_stored(smooth_fractions(volume, grid, run), format);
    }
    if factor == 1 {
        match (volume.voxels(), format) {
            (Voxels::U8(v), TextureFormat::R8Unorm) => return Payload::new(gather(v, grid, run, |&x| x)),
            (Voxels::U16(v), TextureFormat::R16Unorm) => {
                return Payload::new(Words(gather(v, grid, run, |&x| x)));
            }
            (Voxels::U16(v), TextureFormat::Rg8Unorm) => {
                return Payload::new(Words(gather(v, grid, run, |&x| high_first(x))));
            }
            _ => {}
        }
    }
    as_stored(fractions(volume, source.reading, factor, grid, run), format)
}

/// 16-bit fractions in a format.
fn as_stored(mut fractions: Vec<u16>, format: TextureFormat) -> Payload {
    match format {
        TextureFormat::R8Unorm => {
            let bytes = fractions.iter().map(|&x| ((u32::from(x) + 128) / 257) as u8);
            return Payload::new(bytes.collect::<Vec<u8>>());
        }
        TextureFormat::Rg8Unorm => fractions.iter_mut().for_each(|x| *x = high_first(*x)),
        TextureFormat::R16Float => {
            for x in &mut fractions {
                *x = half::f16::from_f64(f64::from(*x) / 65535.0).to_bits();
            }
        }
        _ => {}
    }
    Payload::new(Words(fractions))
}

/// A number whose bytes lie in memory as channels do: the high one first.
fn high_first(x: u16) -> u16 {
    u16::from_ne_bytes(x.to_be_bytes())
}

fn fractions(volume: &Volume, reading: Reading, factor: u32, grid: BrickGrid, run: Run) -> Vec<u16> {
    match volume.voxels() {
        Voxels::U8(v) if reading == Reading::Labels && factor > 1 => pick(volume, v, factor, grid, run),
        Voxels::U8(v) => {
            let read = |&x: &u8| u16::from(x) * 257;
            if factor == 1 { gather(v, grid, run, read) } else { average(volume, v, factor, grid, run, read) }
        }
        Voxels::U16(v) => {
            let read = |&x: &u16| x;
            if factor == 1 { gather(v, grid, run, read) } else { average(volume, v, factor, grid, run, read) }
        }
        Voxels::F32(v) => {
            let quantiser = Quantiser::of(volume);
            let read = |&x: &f32| quantiser.fraction(x);
            if factor == 1 { gather(v, grid, run, read) } else { average(volume, v, factor, grid, run, read) }
        }
    }
}

/// The texels of a run of a volume whose voxels are averaged with their neighbours. (One that is reduced is smooth enough.)
fn smooth_fractions(volume: &Volume, grid: BrickGrid, run: Run) -> Vec<u16> {
    match volume.voxels() {
        Voxels::U8(v) => smooth(v, grid, run, |&x| u16::from(x) * 257),
        Voxels::U16(v) => smooth(v, grid, run, |&x| x),
        Voxels::F32(v) => {
            let quantiser = Quantiser::of(volume);
            smooth(v, grid, run, |&x| quantiser.fraction(x))
        }
    }
}

/// The voxel of each texel of a run along an axis.
fn voxels_along(grid: BrickGrid, run: Run, axis: usize) -> impl Iterator<Item = u32> + Clone {
    let bricks = if axis < 2 { run.size[axis] } else { 1 };
    let (first, last) = (run.first[axis], grid.dims[axis] - 1);
    (0..bricks * BRICK_TEXELS).map(move |texel| {
        let voxel = (first + texel / BRICK_TEXELS) * BRICK_SIZE + texel % BRICK_TEXELS;
        voxel.min(last)
    })
}

/// The texels of a run, each read from its sample.
fn gather<S: Sync, T: Copy + Default + Send + Sync>(
    samples: &[S],
    grid: BrickGrid,
    run: Run,
    read: impl Fn(&S) -> T + Sync,
) -> Vec<T> {
    let [nx, ny, _] = grid.dims.map(|n| n as usize);
    fill(grid, run, |[y, z], line| {
        let row = &samples[(z as usize * ny + y as usize) * nx..][..nx];
        for (brick, texels) in line.chunks_exact_mut(BRICK_TEXELS as usize).enumerate() {
            let begin = (run.first[0] as usize + brick) * BRICK_SIZE as usize;
            let end = nx.min(begin + BRICK_TEXELS as usize);
            let (there, beyond) = texels.split_at_mut(end - begin);
            for (texel, sample) in there.iter_mut().zip(&row[begin..end]) {
                *texel = read(sample);
            }
            beyond.fill(read(&row[nx - 1]));
        }
    })
}

/// What lies beside a line of voxels along y or z: its weighed sums, and the least and largest of its neighbours.
#[derive(Clone)]
struct Beside {
    y: usize,
    sums: Vec<i32>,
    least: Vec<u16>,
    most: Vec<u16>,
}

/// The texels of a run, each a mean of the samples around its own: see [`lumivox_core::Filter::Smooth`].
fn smooth<S: Sync>(samples: &[S], grid: BrickGrid, run: Run, read: impl Fn(&S) -> u16 + Sync) -> Vec<u16> {
    let n = grid.dims.map(|n| n as usize);
    // What the texels lie between, read once.
    let begin = run.first.map(|brick| ((brick * BRICK_SIZE) as usize).saturating_sub(2));
    let [width, height, depth] = [run.size[0], run.size[1], 1];
    let end = [0, 1, 2].map(|axis| {
        let bricks = run.first[axis] + [width, height, depth][axis];
        n[axis].min((bricks * BRICK_SIZE) as usize + 3)
    });
    let [wide, tall, deep] = [0, 1, 2].map(|axis| end[axis] - begin[axis]);
    let mut voxels = vec![0u16; wide * tall * deep];
    let copy = |(z, layer): (usize, &mut [u16])| {
        for (y, row) in layer.chunks_exact_mut(wide).enumerate() {
            let first = ((begin[2] + z) * n[1] + begin[1] + y) * n[0] + begin[0];
            for (voxel, sample) in row.iter_mut().zip(&samples[first..][..wide]) {
                *voxel = read(sample);
            }
        }
    };
    if voxels.len() < FEW_TEXELS {
        voxels.chunks_exact_mut(wide * tall).enumerate().for_each(copy);
    } else {
        voxels.par_chunks_exact_mut(wide * tall).enumerate().for_each(copy);
    }
    let around = |i: u32, axis: usize| {
        [0, 1, 2, 3, 4].map(|step| (i as usize + step).clamp(2, n[axis] + 1) - 2 - begin[axis])
    };
    let ys: Vec<u32> = voxels_along(grid, run, 1).collect();
    fill_slices(grid, run, |z, slice| {
        let layers = around(z, 2).map(|z| &voxels[z * wide * tall..][..wide * tall]);
        // Along z, of the five rows that a line lies between.
        let empty = Beside { y: usize::MAX, sums: vec![0; wide], least: vec![0; wide], most: vec![0; wide] };
        let mut rows = [(); 5].map(|()| empty.clone());
        // Along y and z, of a line, and what is beyond its ends: two sums more, one voxel.
        let mut sums = vec![0i32; wide + 4];
        let (mut least, mut most) = (vec![0u16; wide + 2], vec![0u16; wide + 2]);
        let mut means = vec![0u16; wide];
        let line_length = slice.len() / ys.len();
        for (line, y) in slice.chunks_exact_mut(line_length).zip(&ys) {
            let around_y = around(*y, 1);
            for y in around_y {
                let row = &mut rows[y % 5];
                if std::mem::replace(&mut row.y, y) != y {
                    let of = layers.map(|layer| &layer[y * wide..][..wide]);
                    row.sums.iter_mut().zip(weighed(of)).for_each(|(sum, x)| *sum = x);
                    let [_, a, b, c, _] = of;
                    extreme(&mut row.least, [a, b, c], u16::min);
                    extreme(&mut row.most, [a, b, c], u16::max);
                }
            }
            let of = around_y.map(|y| &rows[y % 5].sums[..]);
            sums[2..].iter_mut().zip(weighed(of)).for_each(|(sum, x)| *sum = x);
            let [first, last] = [sums[2], sums[wide + 1]];
            sums[..2].fill(first);
            sums[wide + 2..].fill(last);
            let near = [1, 2, 3].map(|i| &rows[around_y[i] % 5]);
            extreme(&mut least[1..=wide], near.map(|row| &row.least[..]), u16::min);
            extreme(&mut most[1..=wide], near.map(|row| &row.most[..]), u16::max);
            for ends in [&mut least, &mut most] {
                (ends[0], ends[wide + 1]) = (ends[1], ends[wide]);
            }
            let of = [0, 1, 2, 3, 4].map(|i| &sums[i..][..wide]);
            let bounds = least.windows(3).zip(most.windows(3));
            for ((mean, sum), (low, high)) in means.iter_mut().zip(weighed(of)).zip(bounds) {
                let low = low[0].min(low[1]).min(low[2]);
                let high = high[0].max(high[1]).max(high[2]);
                *mean = ((sum + 2048) >> 12).clamp(low.into(), high.into()) as u16;
            }
            for (brick, texels) in line.chunks_exact_mut(BRICK_TEXELS as usize).enumerate() {
                let first = (run.first[0] as usize + brick) * BRICK_SIZE as usize;
                let count = (n[0] - first).min(BRICK_TEXELS as usize);
                let (there, beyond) = texels.split_at_mut(count);
                there.copy_from_slice(&means[first - begin[0]..][..count]);
                beyond.fill(there[count - 1]);
            }
        }
    })
}

/// The least or largest of three rows.
fn extreme(of: &mut [u16], [a, b, c]: [&[u16]; 3], pick: impl Fn(u16, u16) -> u16) {
    for (((of, a), b), c) in of.iter_mut().zip(a).zip(b).zip(c) {
        *of = pick(pick(*a, *b), *c);
    }
}

/// Sums of five rows under the smooth filter's weights, 16 times too large.
fn weighed<'a, T: Copy + Into<i32>>([a, b, c, d, e]: [&'a [T]; 5]) -> impl Iterator<Item = i32> + 'a {
    let sum = |(x, y): (&T, &T)| (*x).into() + (*y).into();
    let [far, near] = [a.iter().zip(e), b.iter().zip(d)].map(|pairs| pairs.map(sum));
    c.iter().zip(near).zip(far).map(|((c, near), far)| 10 * (*c).into() + 4 * near - far)
}

/// The texels of a run of a volume that is reduced, each the mean of what it stands for.
fn average<S: Sync>(
    volume: &Volume,
    samples: &[S],
    factor: u32,
    grid: BrickGrid,
    run: Run,
    read: impl Fn(&S) -> u16 + Sync,
) -> Vec<u16> {
    let n = volume.dims();
    let covered = |voxel: u32, axis: usize| {
        let begin = voxel as usize * factor as usize;
        begin..(begin + factor as usize).min(n[axis])
    };
    fill(grid, run, |[y, z], line| {
        for (texel, x) in line.iter_mut().zip(voxels_along(grid, run, 0)) {
            let (mut sum, mut count) = (0u64, 0u64);
            for z in covered(z, 2) {
                for y in covered(y, 1) {
                    for sample in &samples[(z * n[1] + y) * n[0]..][covered(x, 0)] {
                        sum += u64::from(read(sample));
                        count += 1;
                    }
                }
            }
            *texel = ((sum + count / 2) / count.max(1)) as u16;
        }
    })
}

/// The texels of a run of labels that are reduced, each one of those that it stands for: see [`picked`].
fn pick(volume: &Volume, samples: &[u8], factor: u32, grid: BrickGrid, run: Run) -> Vec<u16> {
    let n = volume.dims();
    let at = |voxel: u32, axis: usize| picked(voxel as usize, factor, n[axis]);
    fill(grid, run, |[y, z], line| {
        let row = &samples[(at(z, 2) * n[1] + at(y, 1)) * n[0]..][..n[0]];
        for (texel, x) in line.iter_mut().zip(voxels_along(grid, run, 0)) {
            *texel = u16::from(row[at(x, 0)]) * 257;
        }
    })
}

/// Of so many voxels along an axis, the one that is taken for those that a voxel of a reduced copy stands for: in the
/// middle of them.
pub(crate) fn picked(voxel: usize, factor: u32, voxels: usize) -> usize {
    (voxel * factor as usize + factor as usize / 2).min(voxels - 1)
}

/// The texels of a run, line by line: the y and z of its voxels, and its texels.
fn fill<T: Copy + Default + Send + Sync>(
    grid: BrickGrid,
    run: Run,
    line: impl Fn([u32; 2], &mut [T]) + Sync,
) -> Vec<T> {
    let width = (run.size[0] * BRICK_TEXELS) as usize;
    let ys: Vec<u32> = voxels_along(grid, run, 1).collect();
    fill_slices(grid, run, |z, slice| {
        for (texels, y) in slice.chunks_exact_mut(width).zip(&ys) {
            line([*y, z], texels);
        }
    })
}

/// The texels of a run, slice by slice: the z of its voxels, and its texels.
fn fill_slices<T: Copy + Default + Send + Sync>(
    grid: BrickGrid,
    run: Run,
    slice: impl Fn(u32, &mut [T]) + Sync,
) -> Vec<T> {
    let [width, height] = run.size.map(|n| (n * BRICK_TEXELS) as usize);
    let mut texels = vec![T::default(); width * height * BRICK_TEXELS as usize];
    let zs = voxels_along(grid, run, 2);
    let of = |(texels, z): (&mut [T], u32)| slice(z, texels);
    if texels.len() < FEW_TEXELS {
        texels.chunks_mut(width * height).zip(zs).for_each(of);
    } else {
        texels.par_chunks_mut(width * height).zip(zs.collect::<Vec<_>>()).for_each(of);
    }
    texels
}

/// All of a reduced volume, brick by brick.
pub(super) fn fractions_of_all(volume: &Volume, reading: Reading, factor: u32) -> Vec<u16> {
    let grid = BrickGrid::new(volume.dims(), factor);
    (0..grid.count() as usize)
        .into_par_iter()
        .flat_map_iter(|index| {
            fractions(volume, reading, factor, grid, Run { first: grid.place(index), size: [1, 1] })
        })
        .collect()
}

/// A run of what was made ahead.
pub(super) fn prepared_texels(prepared: &[u16], bricks: &Bricks, run: Run, format: TextureFormat) -> Payload {
    let side = BRICK_TEXELS as usize;
    let [width, height] = run.size.map(|n| n as usize);
    let mut texels = vec![0u16; width * height * TEXELS as usize];
    for (row, line) in texels.chunks_exact_mut(side).enumerate() {
        let (x, y, z) = (row % width, row / width % (height * side), row / (width * height * side));
        let [first_x, first_y, first_z] = run.first;
        let brick = bricks.grid.index([first_x + x as u32, first_y + (y / side) as u32, first_z]);
        let begin = brick * TEXELS as usize + (z * side + y % side) * side;
        line.copy_from_slice(&prepared[begin..begin + side]);
    }
    as_stored(texels, format)
}

#[cfg(test)]
mod tests {
    use lumivox_core::Modality;
    use lumivox_core::glam::DAffine3;

    use super::*;

    fn volume(dims: [usize; 3], voxels: Voxels) -> Volume {
        Volume::new(dims, voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Other).unwrap()
    }

    /// The mean of a voxel's neighbours by its definition.
    fn mean(volume: &Volume, fractions: &[u16], place: [u32; 3]) -> u16 {
        let n = volume.dims();
        let (mut sum, mut least, mut most) = (0, u16::MAX, 0);
        for neighbour in 0..125 {
            let step = [neighbour % 5, neighbour / 5 % 5, neighbour / 25];
            let [x, y, z] = [0, 1, 2].map(|a| (place[a] as usize + step[a]).clamp(2, n[a] + 1) - 2);
            let weight: i32 = step.iter().map(|&step| [-1, 4, 10, 4, -1][step]).product();
            let value = fractions[(z * n[1] + y) * n[0] + x];
            sum += weight * i32::from(value);
            if step.iter().all(|step| (1..4).contains(step)) {
                (least, most) = (least.min(value), most.max(value));
            }
        }
        (f64::from(sum) / 4096.0 + 0.5).floor().clamp(least.into(), most.into()) as u16
    }

    #[test]
    fn smooth_texels_are_means_whatever_the_volume_and_the_run() {
        let value = |i: usize| (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
        for dims in [[1; 3], [2, 70, 33], [65, 32, 3], [40, 34, 66], [97, 31, 1]] {
            let count = dims.iter().product();
            for voxels in [
                Voxels::U8((0..count).map(|i| value(i) as u8).collect()),
                Voxels::U16((0..count).map(|i| value(i) as u16).collect()),
                Voxels::F32((0..count).map(|i| value(i) as f32 - 1e6).collect()),
            ] {
                let volume = volume(dims, voxels);
                let read: Vec<u16> = match volume.voxels() {
                    Voxels::U8(v) => v.iter().map(|&x| u16::from(x) * 257).collect(),
                    Voxels::U16(v) => v.to_vec(),
                    Voxels::F32(v) => v.iter().map(|&x| Quantiser::of(&volume).fraction(x)).collect(),
                };
                let grid = BrickGrid::new(dims, 1);
                let [wide, high, deep] = grid.counts;
                for (first, size) in [
                    ([0; 3], [wide, high]),
                    ([0, 0, deep - 1], [1, 1]),
                    ([wide - 1, high - 1, deep - 1], [1, 1]),
                    ([wide / 2, high - 1, 0], [wide - wide / 2, 1]),
                ] {
                    let run = Run { first, size };
                    let texels = smooth_fractions(&volume, grid, run);
                    let [xs, ys, zs] = [0, 1, 2].map(|axis| voxels_along(grid, run, axis));
                    let places = zs.flat_map(|z| {
                        let xs = xs.clone();
                        ys.clone().flat_map(move |y| xs.clone().map(move |x| [x, y, z]))
                    });
                    let expected: Vec<u16> = places.map(|place| mean(&volume, &read, place)).collect();
                    assert!(texels == expected, "{dims:?}, {run:?}");
                }
            }
        }
    }

    #[test]
    fn reduced_labels_are_labels_that_there_were() {
        let dims = [7, 5, 6];
        let labels: Vec<u8> = (0..210).map(|i| (i * 37 % 251) as u8).collect();
        let volume = volume(dims, Voxels::U8(labels.clone()));
        for factor in [2, 3, 8] {
            let grid = BrickGrid::new(dims, factor);
            let run = Run { first: [0; 3], size: [1, 1] };
            let texels = fractions(&volume, Reading::Labels, factor, grid, run);
            let side = BRICK_TEXELS as usize;
            let [nx, ny, nz] = grid.dims.map(|n| n as usize);
            for (z, y, x) in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (z, y, x))))
            {
                let [i, j, k] = [picked(x, factor, 7), picked(y, factor, 5), picked(z, factor, 6)];
                let label = labels[(k * 5 + j) * 7 + i];
                assert_eq!(
                    texels[(z * side + y) * side + x],
                    u16::from(label) * 257,
                    "{factor}: {x} {y} {z}"
                );
            }
        }
    }
}
