//! A label is drawn by where a point comes to be that is moved by the sum of three numbers along each axis. They are bytes of one
//! random number and of two products of it: as good as three random numbers, if the sums are spread as theirs.

use lumivox_shaders::constants::{SECOND_DRAW, THIRD_DRAW};

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

fn sum(bits: u32, axis: usize) -> usize {
    let byte = |word: u32, axis: usize| (word >> (8 * (axis % 3 + 1)) & 255) as usize;
    byte(bits, axis)
        + byte(bits.wrapping_mul(SECOND_DRAW), axis + 1)
        + byte(bits.wrapping_mul(THIRD_DRAW), axis + 2)
}

/// Random numbers that are spread over all there are: every 64th, and a different one of each 64.
fn random_numbers() -> impl Iterator<Item = u32> {
    (0..1u32 << 26).map(|i| i << 6 | i.wrapping_mul(0x9e37_79b9) >> 26)
}

#[test]
fn a_label_is_drawn_along_each_axis_as_by_independent_numbers() {
    let mut counts = [[0u32; SUMS]; 3];
    let mut total = 0.0;
    for bits in random_numbers() {
        for (axis, counts) in counts.iter_mut().enumerate() {
            counts[sum(bits, axis)] += 1;
        }
        total += 1.0;
    }
    let wanted = independent();
    for (axis, counts) in counts.iter().enumerate() {
        let got = cumulative(&counts.map(|n| f64::from(n) / total));
        let apart = got.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("axis {axis}: {apart:.1e}");
        assert!(apart < 3e-5, "axis {axis}: {apart}");
    }
}

/// Of two axes, the share of each of 24 times 24 ranges of sums.
#[test]
fn axes_are_independent_of_each_other() {
    const WIDTH: usize = 32;
    const RANGES: usize = SUMS.div_ceil(WIDTH);
    let wanted: Vec<f64> =
        independent().chunks(WIDTH).map(|chunk| *chunk.last().expect("not empty")).collect();
    for axes in [[0, 1], [0, 2], [1, 2]] {
        let mut counts = [[0u32; RANGES]; RANGES];
        let mut total = 0.0;
        for bits in random_numbers() {
            let [a, b] = axes.map(|axis| sum(bits, axis) / WIDTH);
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
        println!("axes {axes:?}: {apart:.1e}");
        assert!(apart < 3e-5, "axes {axes:?}: {apart}");
    }
}
