//! Pixels of something translucent that all samples passed through by chance: they show what is around them, and not nothing.
//!
//! Around such a pixel there is something on all sides. Beside a silhouette, and in a gap that is wide enough to be seen,
//! there is a side without.

use rayon::prelude::*;

use super::{Plane, Shape, WINDOW};
use crate::film::Film;

/// What nobody believes to be chance, as the logarithm of its probability: one pixel in a million.
const IMPLAUSIBLE: f64 = -14.0;

/// 1 where all samples of a pixel passed by chance, else 0. `hit` says where any did not.
pub fn missed(film: &Film, shape: Shape, hit: &Plane) -> Plane {
    let is_hit = |pixel: usize| hit[shape.at(pixel)] > 0.0;
    let is_sampled =
        |pixel: usize| film.samples(pixel) > 0.0 && (is_hit(pixel) || film.luminance(pixel).0 == 0.0);
    let coverage = Sums::new(shape, |pixel| if is_hit(pixel) { film.alpha(pixel) } else { 0.0 });
    let sampled = Sums::new(shape, |pixel| f64::from(is_sampled(pixel)));
    shape.plane(|pixel| {
        if is_hit(pixel) || !is_sampled(pixel) {
            return 0.0;
        }
        let quadrants = quadrants(shape, pixel).map(|of| (coverage.of(of), sampled.of(of)));
        let least = quadrants.iter().map(|(sum, pixels)| sum / pixels.max(1.0)).fold(1.0, f64::min);
        let chance = f64::from(film.samples(pixel)) * (1.0 - least).ln();
        if least > 0.0 && chance > IMPLAUSIBLE { 1.0 } else { 0.0 }
    })
}

/// Gives missed pixels the means of what was hit around them, the nearest first, weighted by how often.
pub fn fill(shape: Shape, hit: &Plane, missed: &Plane, coverage: &Plane, planes: &mut [Plane]) {
    let holes: Vec<usize> =
        (0..shape.pixels()).map(|pixel| shape.at(pixel)).filter(|&at| missed[at] > 0.0).collect();
    let weights: Vec<Vec<(usize, f32)>> =
        holes.par_iter().map(|&at| neighbours(shape, hit, coverage, at)).collect();
    for plane in planes {
        for (&at, weights) in holes.iter().zip(&weights) {
            let sum: f32 = weights.iter().map(|(_, weight)| weight).sum();
            let mean = weights.iter().map(|&(i, weight)| weight * plane[i]).sum::<f32>() / sum;
            plane[at] = if sum > 0.0 { mean } else { 0.0 };
        }
    }
}

/// The pixels that were hit in the smallest square around one that has some, and their weights.
fn neighbours(shape: Shape, hit: &Plane, coverage: &Plane, at: usize) -> Vec<(usize, f32)> {
    /// Fewer have too much noise.
    const ENOUGH: usize = 4;
    let mut found = vec![];
    for radius in 1..=WINDOW {
        found = shape.around(at, radius).filter(|&i| hit[i] > 0.0).map(|i| (i, coverage[i])).collect();
        if found.len() >= ENOUGH {
            break;
        }
    }
    found
}

/// Light per coverage around a pixel, itself among it.
pub fn light_around(shape: Shape, hit: &Plane, light: &[Plane; 3], coverage: &Plane, at: usize) -> [f32; 3] {
    let sum = |plane: &Plane| shape.around(at, 2).map(|i| hit[i] * plane[i]).sum::<f32>();
    [0, 1, 2].map(|channel| sum(&light[channel]) / sum(coverage).max(1e-20))
}

/// Columns and rows from, and up to, of the four squares that touch a pixel by their corners, within the picture. Of its outermost
/// rows and columns, which have none beyond, they are the own.
fn quadrants(shape: Shape, pixel: usize) -> [[usize; 4]; 4] {
    let (x, y) = (pixel % shape.width, pixel / shape.width);
    let sides = |at: usize, end: usize| {
        [[at.saturating_sub(WINDOW), at.max(1)], [(at + 1).min(end - 1), (at + 1 + WINDOW).min(end)]]
    };
    let (columns, rows) = (sides(x, shape.width), sides(y, shape.height));
    [0, 1, 2, 3].map(|i| {
        let ([left, right], [top, bottom]) = (columns[i % 2], rows[i / 2]);
        [left, right, top, bottom]
    })
}

/// Sums over rectangles, in no time: Crow, *Summed-Area Tables for Texture Mapping*, SIGGRAPH 1984.
struct Sums {
    stride: usize,
    table: Vec<f64>,
}

impl Sums {
    fn new(shape: Shape, value: impl Fn(usize) -> f64) -> Self {
        let stride = shape.width + 1;
        let mut table = vec![0.0; stride * (shape.height + 1)];
        for y in 0..shape.height {
            let mut row = 0.0;
            for x in 0..shape.width {
                row += value(y * shape.width + x);
                table[(y + 1) * stride + x + 1] = table[y * stride + x + 1] + row;
            }
        }
        Self { stride, table }
    }

    fn of(&self, [left, right, top, bottom]: [usize; 4]) -> f64 {
        let at = |x: usize, y: usize| self.table[y * self.stride + x];
        // Differences of large sums have a rest.
        let sum = at(right, bottom) - at(left, bottom) - at(right, top) + at(left, top);
        if sum < 1e-6 { 0.0 } else { sum }
    }
}
