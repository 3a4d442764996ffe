//! How different two pictures look: the LDR-FLIP difference.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, *FLIP: A Difference Evaluator for Alternating
//! Images*, HPG 2020. Per pixel, what an observer would notice when flipping between two pictures: 0 is nothing, 1 the
//! largest difference there is; one 8-bit level of grey is already about 0.03. A colour pipeline (section 4.1: blurred as the eye blurs at a distance, then
//! compared in a perceptual space) and a feature pipeline (section 4.2: edges and points) meet in equation 12.

use std::f64::consts::PI;

use crate::png_io::{SrgbImage, linear_from_srgb};

/// Pixels per degree of an observer 0.7 m before a display 0.7 m wide with 3840 pixels: the paper's default.
pub const PIXELS_PER_DEGREE: f64 = 0.7 * 3840.0 / 0.7 * PI / 180.0;

/// Differences of two pictures, pixel by pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct FlipMap {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Difference of every pixel, 0 to 1.
    pub values: Vec<f64>,
}

impl FlipMap {
    /// Mean difference.
    pub fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len().max(1) as f64
    }

    /// Largest difference.
    pub fn max(&self) -> f64 {
        self.values.iter().copied().fold(0.0, f64::max)
    }

    /// A grey picture, white where the difference is 1.
    pub fn to_image(&self) -> SrgbImage {
        let gray: Vec<[f64; 3]> = self.values.iter().map(|v| [linear_from_srgb(*v); 3]).collect();
        SrgbImage::from_linear(self.width, self.height, &gray)
    }
}

/// The difference of `test` from `reference` at [`PIXELS_PER_DEGREE`].
///
/// # Panics
/// When the pictures differ in size.
pub fn flip(reference: &SrgbImage, test: &SrgbImage) -> FlipMap {
    flip_at(reference, test, PIXELS_PER_DEGREE)
}

/// The difference of `test` from `reference`, seen at a number of pixels per degree.
///
/// # Panics
/// When the pictures differ in size.
pub fn flip_at(reference: &SrgbImage, test: &SrgbImage, pixels_per_degree: f64) -> FlipMap {
    FlipReference::new_at(reference, pixels_per_degree).flip(test)
}

/// How far around a pixel its difference sees, at a number of pixels per degree: who cuts out a part of two pictures keeps so
/// much around it, and the part's differences are those of the whole.
pub fn reach(pixels_per_degree: f64) -> usize {
    color_radius(pixels_per_degree).max(feature_radius(pixels_per_degree)) as usize
}

/// A picture that others are compared with: half of the work, which is done once for all of them.
#[derive(Clone, Debug)]
pub struct FlipReference {
    seen: Seen,
    pixels_per_degree: f64,
}

impl FlipReference {
    /// A reference that is seen at [`PIXELS_PER_DEGREE`].
    pub fn new(reference: &SrgbImage) -> Self {
        Self::new_at(reference, PIXELS_PER_DEGREE)
    }

    /// A reference that is seen at a number of pixels per degree.
    pub fn new_at(reference: &SrgbImage, pixels_per_degree: f64) -> Self {
        Self { seen: Seen::new(reference, pixels_per_degree), pixels_per_degree }
    }

    /// The difference of `test` from it, as [`flip_at`] has it.
    ///
    /// # Panics
    /// When the pictures differ in size.
    pub fn flip(&self, test: &SrgbImage) -> FlipMap {
        let [width, height] = self.seen.size;
        assert_eq!([width, height], [test.width, test.height], "pictures of one size");
        let test = Seen::new(test, self.pixels_per_degree);
        let color = color_difference(&self.seen.colors, &test.colors);
        let feature = feature_difference(&self.seen.features, &test.features);
        let values = color.iter().zip(feature).map(|(c, f)| c.powf(1.0 - f)).collect();
        FlipMap { width, height, values }
    }
}

/// What an eye sees of one picture.
#[derive(Clone, Debug)]
struct Seen {
    size: [usize; 2],
    /// Lab colours with Hunt's effect, blurred as the eye blurs.
    colors: Vec<[f64; 3]>,
    /// How much of an edge and of a point there is at each pixel.
    features: [Vec<f64>; 2],
}

impl Seen {
    fn new(image: &SrgbImage, pixels_per_degree: f64) -> Self {
        let opponent = Opponent::new(image);
        Self {
            size: [image.width, image.height],
            colors: opponent.filtered(pixels_per_degree),
            features: opponent.edges_and_points(pixels_per_degree),
        }
    }
}

/// Width of the smallest feature the eye resolves, in degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// Pixels to each side that a colour is blurred over.
fn color_radius(pixels_per_degree: f64) -> i64 {
    (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i64
}

/// Pixels to each side that an edge or a point is looked for in.
fn feature_radius(pixels_per_degree: f64) -> i64 {
    (3.0 * 0.5 * FEATURE_WIDTH * pixels_per_degree).ceil() as i64
}

/// XYZ of the reference white, D65.
const WHITE: [f64; 3] = [0.950_428_545, 1.0, 1.088_900_371];

fn xyz_from_linear(c: [f64; 3]) -> [f64; 3] {
    // The sRGB primaries as exact fractions, as in the authors' code.
    [
        (10_135_552.0 * c[0] + 8_788_810.0 * c[1] + 4_435_075.0 * c[2]) / 24_577_794.0,
        (2_613_072.0 * c[0] + 8_788_810.0 * c[1] + 887_015.0 * c[2]) / 12_288_897.0,
        (1_425_312.0 * c[0] + 8_788_810.0 * c[1] + 70_074_185.0 * c[2]) / 73_733_382.0,
    ]
}

/// Linear RGB of XYZ: the inverse of [`xyz_from_linear`].
fn linear_from_xyz(c: [f64; 3]) -> [f64; 3] {
    [
        3.241_003_232_976_358 * c[0] - 1.537_398_969_488_785 * c[1] - 0.498_615_881_996_363 * c[2],
        -0.969_224_252_202_516 * c[0] + 1.875_929_983_695_176 * c[1] + 0.041_554_226_340_085 * c[2],
        0.055_639_419_851_975 * c[0] - 0.204_011_206_123_910 * c[1] + 1.057_148_977_187_533 * c[2],
    ]
}

/// CIELAB with Hunt's effect: the darker a colour, the less of it is seen (section 4.1.2).
fn hunt_lab(linear: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let xyz = xyz_from_linear(linear);
    let [x, y, z] = std::array::from_fn(|i| {
        let t = xyz[i] / WHITE[i];
        if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    });
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// The HyAB distance: city block in lightness, Euclidean in colour (equation 5).
fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// A picture in the linear opponent space YCxCz, one plane per channel.
struct Opponent {
    width: usize,
    height: usize,
    planes: [Vec<f64>; 3],
}

impl Opponent {
    fn new(image: &SrgbImage) -> Self {
        let mut planes: [Vec<f64>; 3] = Default::default();
        for linear in image.to_linear() {
            let xyz = xyz_from_linear(linear);
            let [x, y, z] = std::array::from_fn(|i| xyz[i] / WHITE[i]);
            planes[0].push(116.0 * y - 16.0);
            planes[1].push(500.0 * (x - y));
            planes[2].push(200.0 * (y - z));
        }
        Self { width: image.width, height: image.height, planes }
    }

    /// The picture through the eye's contrast sensitivity (section 4.1.1), as Lab colours with Hunt's effect.
    fn filtered(&self, pixels_per_degree: f64) -> Vec<[f64; 3]> {
        /// Weights a and widths b of each channel's Gaussians, in degrees (table 1).
        const SENSITIVITY: [[(f64, f64); 2]; 3] =
            [[(1.0, 0.0047), (0.0, 1e-5)], [(1.0, 0.0053), (0.0, 1e-5)], [(34.1, 0.04), (13.5, 0.025)]];
        let radius = color_radius(pixels_per_degree);
        let channels: [Vec<f64>; 3] = std::array::from_fn(|channel| {
            // Every Gaussian is separable, their sum is not: filter with each, and add.
            let gaussians = SENSITIVITY[channel].map(|(a, b)| {
                let kernel: Vec<f64> = (-radius..=radius)
                    .map(|i| (-PI * PI * (i as f64 / pixels_per_degree).powi(2) / b).exp())
                    .collect();
                let sum: f64 = kernel.iter().sum();
                (a * (PI / b).sqrt(), kernel, sum * sum)
            });
            let total: f64 = gaussians.iter().map(|(weight, _, sum)| weight * sum).sum();
            let mut result = vec![0.0; self.planes[channel].len()];
            for (weight, kernel, _) in gaussians.iter().filter(|(weight, ..)| *weight > 0.0) {
                let blurred = self.convolve(&self.planes[channel], kernel, kernel);
                result.iter_mut().zip(blurred).for_each(|(r, b)| *r += b * weight / total);
            }
            result
        });
        (0..self.width * self.height)
            .map(|i| {
                let y = (channels[0][i] + 16.0) / 116.0;
                let x = y + channels[1][i] / 500.0;
                let z = y - channels[2][i] / 200.0;
                hunt_lab(
                    linear_from_xyz([x * WHITE[0], y * WHITE[1], z * WHITE[2]]).map(|c| c.clamp(0.0, 1.0)),
                )
            })
            .collect()
    }

    /// Separable filter; beyond the border the picture's edge goes on.
    fn convolve(&self, plane: &[f64], horizontal: &[f64], vertical: &[f64]) -> Vec<f64> {
        let (width, height) = (self.width, self.height);
        if plane.is_empty() {
            return vec![];
        }
        let mut across = Vec::with_capacity(plane.len());
        let radius = horizontal.len() / 2;
        let mut padded = vec![0.0; width + 2 * radius];
        for row in plane.chunks_exact(width) {
            padded[..radius].fill(row[0]);
            padded[radius..radius + width].copy_from_slice(row);
            padded[radius + width..].fill(row[width - 1]);
            let window = |w: &[f64]| w.iter().zip(horizontal).map(|(x, k)| k * x).sum::<f64>();
            across.extend(padded.windows(horizontal.len()).map(window));
        }
        // Row by row, in the order in which they lie in memory.
        let radius = vertical.len() / 2;
        let mut result = vec![0.0; plane.len()];
        for (y, sums) in result.chunks_exact_mut(width).enumerate() {
            for (i, k) in vertical.iter().enumerate() {
                let from = (y + i).saturating_sub(radius).min(height - 1) * width;
                sums.iter_mut().zip(&across[from..from + width]).for_each(|(sum, x)| *sum += k * x);
            }
        }
        result
    }

    /// Length of the plane's response to a filter along x and the same along y.
    fn features(&self, luminance: &[f64], filter: &[f64], across: &[f64]) -> Vec<f64> {
        let x = self.convolve(luminance, filter, across);
        let y = self.convolve(luminance, across, filter);
        x.iter().zip(y).map(|(x, y)| x.hypot(y)).collect()
    }

    /// What of an edge and of a point there is at each pixel (section 4.2).
    fn edges_and_points(&self, pixels_per_degree: f64) -> [Vec<f64>; 2] {
        let sigma = 0.5 * FEATURE_WIDTH * pixels_per_degree;
        let radius = feature_radius(pixels_per_degree);
        let offsets: Vec<f64> = (-radius..=radius).map(|i| i as f64).collect();
        let gaussian: Vec<f64> = offsets.iter().map(|x| (-x * x / (2.0 * sigma * sigma)).exp()).collect();
        let sum: f64 = gaussian.iter().sum();
        let smooth: Vec<f64> = gaussian.iter().map(|g| g / sum).collect();
        // Positive and negative weights add up to +1 and -1.
        let balanced = |weight: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let raw: Vec<f64> = offsets.iter().zip(&gaussian).map(|(x, g)| weight(*x) * g).collect();
            let positive: f64 = raw.iter().filter(|w| **w > 0.0).sum();
            let negative: f64 = -raw.iter().filter(|w| **w < 0.0).sum::<f64>();
            raw.iter().map(|w| if *w > 0.0 { w / positive } else { w / negative }).collect()
        };
        let edge = balanced(&|x| -x);
        let point = balanced(&|x| x * x / (sigma * sigma) - 1.0);
        let luminance: Vec<f64> = self.planes[0].iter().map(|y| (y + 16.0) / 116.0).collect();
        [edge, point].map(|filter| self.features(&luminance, &filter, &smooth))
    }
}

/// Colour differences, 0 to 1 (sections 4.1.3 and 4.1.4).
fn color_difference(reference: &[[f64; 3]], test: &[[f64; 3]]) -> Vec<f64> {
    const EXPONENT: f64 = 0.7;
    /// Differences up to this fraction of the largest are spread over 0..0.95.
    const CUT: f64 = 0.4;
    const CUT_VALUE: f64 = 0.95;
    let largest = hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(EXPONENT);
    let cut = CUT * largest;
    reference
        .iter()
        .zip(test)
        .map(|(a, b)| {
            let difference = hyab(*a, *b).powf(EXPONENT);
            if difference < cut {
                CUT_VALUE / cut * difference
            } else {
                CUT_VALUE + (difference - cut) / (largest - cut) * (1.0 - CUT_VALUE)
            }
        })
        .map(|e: f64| e.clamp(0.0, 1.0))
        .collect()
}

/// Differences of edges and points, 0 to 1 (section 4.2).
fn feature_difference(reference: &[Vec<f64>; 2], test: &[Vec<f64>; 2]) -> Vec<f64> {
    const EXPONENT: f64 = 0.5;
    let [edges, points] = [0, 1].map(|i| reference[i].iter().zip(&test[i]).map(|(a, b)| (a - b).abs()));
    edges
        .zip(points)
        .map(|(e, p)| (e.max(p) * std::f64::consts::FRAC_1_SQRT_2).powf(EXPONENT).clamp(0.0, 1.0))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(color: impl Fn(usize, usize) -> [u8; 3]) -> SrgbImage {
        let (width, height) = (48, 32);
        let pixels = (0..width * height).map(|i| color(i % width, i / width)).collect();
        SrgbImage { width, height, pixels }
    }

    fn texture(x: usize, y: usize) -> [u8; 3] {
        [(x * 5) as u8, (y * 7) as u8, ((x * y) % 200) as u8]
    }

    #[test]
    fn identical_pictures_do_not_differ_and_black_differs_from_white_by_almost_one() {
        assert_eq!(flip(&picture(texture), &picture(texture)).max(), 0.0);
        let black_white = flip(&picture(|_, _| [0; 3]), &picture(|_, _| [255; 3]));
        assert!(black_white.mean() > 0.95 && black_white.max() <= 1.0, "{}", black_white.mean());
        // Green and blue are the paper's largest difference: 1 by definition.
        let green_blue = flip(&picture(|_, _| [0, 255, 0]), &picture(|_, _| [0, 0, 255]));
        assert!((green_blue.mean() - 1.0).abs() < 1e-6, "{}", green_blue.mean());
    }

    #[test]
    fn the_difference_is_symmetric_and_bounded() {
        let other = picture(|x, y| texture(y, x));
        let (ab, ba) = (flip(&picture(texture), &other), flip(&other, &picture(texture)));
        assert!(ab.values.iter().all(|v| (0.0..=1.0).contains(v)));
        assert!(ab.values.iter().zip(&ba.values).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn larger_changes_differ_more_and_distance_hides_detail() {
        let changed = |by: u8| picture(move |x, y| texture(x, y).map(|c| c.saturating_add(by)));
        let means = [1, 4, 16, 64].map(|by| flip(&picture(texture), &changed(by)).mean());
        assert!(means.windows(2).all(|w| w[0] < w[1]), "{means:?}");
        assert!(means[0] < 0.05, "{means:?}");
        // A fine checkerboard against its inverse: from afar both are grey.
        let checker = |odd: usize| picture(move |x, y| if (x + y) % 2 == odd { [160; 3] } else { [96; 3] });
        let (near, far) =
            (flip_at(&checker(0), &checker(1), 10.0).mean(), flip_at(&checker(0), &checker(1), 67.0).mean());
        assert!(far < near / 2.0, "{near} {far}");
    }

    #[test]
    fn a_point_is_noticed_where_it_is() {
        let dot = picture(|x, y| if (x, y) == (24, 16) { [255; 3] } else { [40; 3] });
        let map = flip(&picture(|_, _| [40; 3]), &dot);
        let at = |x: usize, y: usize| map.values[y * map.width + x];
        assert!(at(24, 16) > 0.1 && at(2, 2) < 1e-6, "{} {}", at(24, 16), at(2, 2));
    }

    #[test]
    fn values_are_those_of_the_authors_program() {
        // From the authors' flip-evaluator at its default of 67.02 pixels per degree; it computes in f32.
        let dot = picture(|x, y| if (x, y) == (24, 16) { [255; 3] } else { [40; 3] });
        let brighter = picture(|x, y| texture(x, y).map(|c| c.saturating_add(4)));
        let swapped = picture(|x, y| texture(y, x));
        let cases = [
            (picture(texture), swapped, 0.793_464_7, [0.0, 0.834_640_1, 0.974_158_0]),
            (picture(texture), brighter, 0.109_745_3, [0.066_214_6, 0.095_229_7, 0.114_397_9]),
            (picture(|_, _| [40; 3]), dot, 0.006_677_87, [0.0, 0.708_112_9, 0.0]),
            (picture(|_, _| [0; 3]), picture(|_, _| [255; 3]), 0.967_399_1, [0.967_388_3; 3]),
        ];
        for (reference, test, mean, at) in cases {
            let map = flip(&reference, &test);
            assert!((map.mean() - mean).abs() < 5e-5, "{} {mean}", map.mean());
            let found = [0, 16 * 48 + 24, 31 * 48 + 47].map(|i| map.values[i]);
            assert!(found.iter().zip(at).all(|(a, b)| (a - b).abs() < 2e-4), "{found:?} {at:?}");
        }
    }

    #[test]
    fn a_part_that_is_cut_out_with_its_surroundings_differs_as_it_does_in_the_whole() {
        let (whole, other) = (picture(texture), picture(|x, y| texture(y, x)));
        let cut = |from: &SrgbImage, [left, top, width, height]: [usize; 4]| SrgbImage {
            width,
            height,
            pixels: (0..width * height)
                .map(|i| from.pixels[(top + i / width) * from.width + left + i % width])
                .collect(),
        };
        let degree = 30.0;
        let reach = reach(degree);
        assert_eq!(reach, 5);
        let all = flip_at(&whole, &other, degree);
        let part = [20 - reach, 12 - reach, 4 + 2 * reach, 6 + 2 * reach];
        let reference = FlipReference::new_at(&cut(&whole, part), degree);
        for _ in 0..2 {
            let found = reference.flip(&cut(&other, part));
            for (x, y) in (0..24).map(|i| (i % 4, i / 4)) {
                let inner = found.values[(y + reach) * part[2] + x + reach];
                assert_eq!(inner, all.values[(y + 12) * whole.width + x + 20]);
            }
        }
    }

    #[test]
    fn colour_spaces_are_inverse() {
        for c in [[0.2, 0.5, 0.9], [1.0, 0.0, 0.3]] {
            let back = linear_from_xyz(xyz_from_linear(c));
            assert!(back.iter().zip(c).all(|(a, b)| (a - b).abs() < 1e-4), "{back:?} {c:?}");
        }
        assert!((hunt_lab([1.0; 3])[0] - 100.0).abs() < 1e-9);
    }
}
