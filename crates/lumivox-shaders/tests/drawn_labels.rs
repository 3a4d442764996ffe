//! A label is drawn by where a point comes to be that is moved by the sum of three numbers along each axis. They are bytes of three
//! products of one random number: as good as three random numbers, if the sums are spread as theirs.
//!
//! The same number has decided whether light may collide at the point, by being small, or how far it came: so its products have to be
//! spread alike wherever it lies.

use lumivox_shaders::constants::{BRICK_SIZE, FIRST_DRAW, MAX_BRICKS, PLACE_ZERO, SECOND_DRAW, THIRD_DRAW};

/// Sums of three bytes.
const SUMS: usize = 3 * 255 + 1;

/// How likely a sum of three independent bytes is to be at most this.
fn independent() -> Vec<f64> {
    let mut density = vec![1.0];
    for _ in 0..3 {
        let mut wider = vec![0.0; density.len() + 255];
        for (i, p) in density.iter().enumerate() {
            wider[i..i + 256].iter_mut().for_each(|w| *w += p / 256.0);
        }
        density = wider;
    }
    cumulative(&density)
}

fn cumulative(density: &[f64]) -> Vec<f64> {
    density
        .iter()
        .scan(0.0, |sum, p| {
            Some({
                *sum += p;
                *sum
            })
        })
        .collect()
}

fn sum(drawn: u32, axis: usize) -> usize {
    let bits = drawn.wrapping_mul(FIRST_DRAW);
    let byte = |word: u32, axis: usize| (word >> (8 * (axis % 3 + 1)) & 255) as usize;
    byte(bits, axis)
        + byte(bits.wrapping_mul(SECOND_DRAW), axis + 1)
        + byte(bits.wrapping_mul(THIRD_DRAW), axis + 2)
}

/// Random numbers that are spread over all there are: every 64th, and a different one of each 64.
fn random_numbers() -> impl Iterator<Item = u32> {
    (0..1u32 << 26).map(|i| i << 6 | i.wrapping_mul(0x9e37_79b9) >> 26)
}

/// How far the sums of some numbers along an axis are from being spread as those of three independent bytes.
fn apart(numbers: impl Iterator<Item = u32>, axis: usize) -> f64 {
    let mut counts = [0u32; SUMS];
    let mut total = 0.0;
    for drawn in numbers {
        counts[sum(drawn, axis)] += 1;
        total += 1.0;
    }
    let got = cumulative(&counts.map(|n| f64::from(n) / total));
    got.iter().zip(&independent()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn a_label_is_drawn_along_each_axis_as_by_independent_numbers() {
    for axis in 0..3 {
        let apart = apart(random_numbers(), axis);
        println!("axis {axis}: {apart:.1e}");
        assert!(apart < 3e-5, "axis {axis}: {apart}");
    }
}

/// Of light that collides seldom, one time in 256 or 65536, or came so far and no farther. Better than as many random numbers would be
/// spread, which is one over their root.
#[test]
fn a_label_does_not_depend_on_what_else_its_number_decides() {
    for bits in [24, 20, 16] {
        let limit = 0.25 / f64::from(1u32 << bits).sqrt();
        for first in [0u32, 5, 11].map(|part| part << bits) {
            for axis in 0..3 {
                let apart = apart(first..first + (1 << bits), axis);
                println!("{bits} bits from {first:#x}, axis {axis}: {apart:.1e}");
                assert!(apart < limit, "{bits} bits from {first:#x}, axis {axis}: {apart}");
            }
            for axes in [[0, 1], [0, 2], [1, 2]] {
                let apart = axes_apart(first..first + (1 << bits), axes);
                println!("{bits} bits from {first:#x}, axes {axes:?}: {apart:.1e}");
                assert!(apart < 2.0 * limit, "{bits} bits from {first:#x}, axes {axes:?}: {apart}");
            }
        }
    }
}

/// How far the sums of some numbers along two axes are from independent ones, by the share of each of 24 times 24 ranges.
fn axes_apart(numbers: impl Iterator<Item = u32>, axes: [usize; 2]) -> f64 {
    const WIDTH: usize = 32;
    const RANGES: usize = SUMS.div_ceil(WIDTH);
    let wanted: Vec<f64> =
        independent().chunks(WIDTH).map(|chunk| *chunk.last().expect("not empty")).collect();
    let mut counts = [[0u32; RANGES]; RANGES];
    let mut total = 0.0;
    for drawn in numbers {
        let [a, b] = axes.map(|axis| sum(drawn, axis) / WIDTH);
        counts[a][b] += 1;
        total += 1.0;
    }
    let mut column = [0.0; RANGES];
    let mut apart = 0.0f64;
    for (row, of_row) in counts.iter().zip(&wanted) {
        let mut sum = 0.0;
        for ((n, column), of_column) in row.iter().zip(&mut column).zip(&wanted) {
            *column += f64::from(*n) / total;
            sum += *column;
            apart = apart.max((sum - of_row * of_column).abs());
        }
    }
    apart
}

#[test]
fn axes_are_independent_of_each_other() {
    for axes in [[0, 1], [0, 2], [1, 2]] {
        let apart = axes_apart(random_numbers(), axes);
        println!("axes {axes:?}: {apart:.1e}");
        assert!(apart < 3e-5, "axes {axes:?}: {apart}");
    }
}

/// As `style_at` finds a voxel along an axis, in the last bits of floats.
fn voxel(here: f32, moved: u32, dims: f32) -> u32 {
    let from_corner = (here + (PLACE_ZERO - 1.5 + 3.0 / 512.0)).to_bits() + 2 * moved;
    let inside = from_corner.clamp(PLACE_ZERO.to_bits(), (dims + PLACE_ZERO).to_bits() - 1);
    inside >> 9 & 0x1fff
}

/// Up to the largest grid that there is.
#[test]
fn the_voxel_of_a_label_is_the_nearest_to_a_moved_point() {
    let most = (MAX_BRICKS * BRICK_SIZE) as f32;
    for dims in [1.0f32, 2.0, 31.0, 511.0, most] {
        for i in 0..20_000u32 {
            let here = dims * (i as f32 / 20_000.0);
            let moved = i.wrapping_mul(0x9e37_79b9) % SUMS as u32;
            // In the middle of each byte's step, of 256 to a voxel.
            let wanted = f64::from(here) + (f64::from(moved) + 1.5) / 256.0 - 1.5;
            let found = f64::from(voxel(here, moved, dims)) + 0.5;
            let inside = wanted.clamp(0.5, f64::from(dims) - 0.5);
            assert!(
                (found - inside).abs() <= 0.5 + 1.0 / 512.0,
                "{here} of {dims}, {moved}: {found}, {wanted}"
            );
        }
    }
}
