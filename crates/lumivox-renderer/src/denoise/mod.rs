//! Removes what noise is left in a finished film, at the price of a little bias: joint non-local means.
//!
//! Rousselle, Manzi and Zwicker, *Robust Denoising using Feature and Color Information*, Pacific Graphics 2013, on the
//! weights of Rousselle, Knaus and Zwicker, *Adaptive Rendering with Non-Local Means Filtering*, SIGGRAPH Asia 2012.
//! A pixel becomes the mean of those around it whose neighbourhoods look alike, where "alike" is measured in standard
//! errors: what differs by no more than the noise is averaged, what differs by more is kept, so that a converged film
//! stays as it is. First hits (coverage, depth, normal, albedo) are less noisy than light and guard the edges that
//! noise hides. They are averages over a depth range, noisy themselves, and are filtered first, by the same filter.
//!
//! What is filtered is not radiance but light per coverage and albedo, multiplied back afterwards: silhouettes and
//! texture then pass through. Where something is translucent, few samples may all pass through it: see [`misses`].

mod misses;

use std::ops::Range;

use rayon::prelude::*;

use crate::film::Film;

/// Pixels from the centre to the side of the window that a pixel's mean is taken over.
const WINDOW: usize = 8;

/// The same for the first hits, which need less.
const FEATURE_WINDOW: usize = 3;

/// Pixels from the centre to the side of the patches that are compared.
const PATCH: usize = 2;

/// Standard errors within which light is alike: the papers' k.
const LIGHT_TOLERANCE: f32 = 0.8;

/// The same for the first hits when they are filtered themselves.
const FEATURE_TOLERANCE: f32 = 0.7;

/// Differences of first hits at which a weight falls to a third.
const COVERAGE_TOLERANCE: f32 = 0.1;
const NORMAL_TOLERANCE: f32 = 0.2;
const ALBEDO_TOLERANCE: f32 = 0.1;
/// As a fraction of depth, and in slopes over the window's radius.
const DEPTH_TOLERANCE: f32 = 1e-3;
const SLOPE_TOLERANCE: f32 = 0.5;

/// Albedos below this do not divide.
const LEAST_ALBEDO: f32 = 0.02;

/// A pixel so many typical standard errors above its neighbours' median is a firefly.
const FIREFLY: f32 = 6.0;

/// Rows that one task filters.
const BAND: usize = 32;

/// Zeros around a plane, so that no shift leaves it.
const MARGIN: usize = WINDOW + PATCH;

impl Film {
    /// The film with less noise and a little bias. Radiance and coverage change; samples, depth and guides do not, nor
    /// does the variance, which remains that of the samples. Pixels of something translucent that all samples passed
    /// through by chance get all of it from those around them. Edges that are seen in the guides are kept best, so a
    /// film should have them. The result does not depend on the number of threads.
    pub fn denoised(&self) -> Film {
        self.denoised_while(&|| true).expect("it may take as long as it does")
    }

    /// The same, for who may lose patience: `None` once `has_time` says no, which it is asked now and then, by any thread, and
    /// to which it keeps.
    pub fn denoised_while(&self, has_time: &(dyn Fn() -> bool + Sync)) -> Option<Film> {
        let shape = Shape::new(self.size());
        // What is not a number stays where it is: it neither gives nor takes.
        let only_hit = shape.plane(|pixel| {
            if self.alpha(pixel) > 0.0 && self.luminance(pixel).0.is_finite() { 1.0 } else { 0.0 }
        });
        let missed = misses::missed(self, shape, &only_hit);
        let both = |a: &Plane, b: &Plane| -> Plane { a.iter().zip(b).map(|(a, b)| a + b).collect() };

        let mut features = features(self, shape);
        let (hits, first_hits) = features.split_at_mut(DEPTH);
        misses::fill(shape, &only_hit, &missed, &hits[0], first_hits);
        let features = smooth_features(shape, &both(&only_hit, &missed), features, has_time);
        if !has_time() {
            return None;
        }
        // A gap that nothing around it is like stays one.
        let missed = shape.plane(|pixel| {
            let at = shape.at(pixel);
            if features[0].values[at] > 0.0 { missed[at] } else { 0.0 }
        });
        let hit = both(&only_hit, &missed);
        let (coverage, albedo) = (&features[0].values, features.get(ALBEDO));
        let albedo =
            |channel: usize, at: usize| albedo.map_or(1.0, |a| a[channel].values[at].max(LEAST_ALBEDO));

        // Light per albedo, and its luminance per coverage with the variance of that.
        let mut light: [Plane; 3] = std::array::from_fn(|channel| {
            shape.plane(|pixel| {
                let at = shape.at(pixel);
                if hit[at] > 0.0 { self.radiance(pixel)[channel] as f32 / albedo(channel, at) } else { 0.0 }
            })
        });
        let mut luminance = Noisy { values: shape.plane(|_| 0.0), variance: shape.plane(|_| 0.0) };
        for pixel in 0..shape.pixels() {
            let at = shape.at(pixel);
            if hit[at] > 0.0 {
                let (mean, variance) = self.luminance(pixel);
                let per_coverage = luminance_of([0, 1, 2].map(|c| light[c][at])) / coverage[at];
                // Relative errors survive a division. One sample tells nothing: it may be all noise.
                let relative = if variance.is_finite() { variance / (mean * mean).max(1e-30) } else { 1.0 };
                luminance.values[at] = per_coverage;
                luminance.variance[at] = relative as f32 * per_coverage * per_coverage;
            }
        }
        // Among those that were hit: what shines among misses is no firefly.
        tame_fireflies(shape, &only_hit, &mut luminance, &mut light);
        luminance.variance = box_mean(shape, &hit, &luminance.variance);

        let guides = guides(shape, &hit, &features);
        let [red, green, blue] = &light;
        let means = nl_means(
            shape,
            &hit,
            &[luminance],
            LIGHT_TOLERANCE,
            WINDOW,
            &guides,
            &[red, green, blue, coverage],
            has_time,
        );
        if !has_time() {
            return None;
        }
        let mut film = self.clone();
        for pixel in (0..shape.pixels()).filter(|&pixel| hit[shape.at(pixel)] > 0.0) {
            let at = shape.at(pixel);
            let mut light_per_coverage = [0, 1, 2].map(|c| means[c][at] / means[3][at]);
            if missed[at] > 0.0 {
                // One that is like nothing around it would be a dark spot.
                let around = misses::light_around(shape, &hit, &light, coverage, at);
                if luminance_of(light_per_coverage) < 0.5 * luminance_of(around) {
                    light_per_coverage = around;
                }
                film.set_first_hit(pixel, features.iter().skip(DEPTH).map(|feature| feature.values[at]));
            }
            let radiance = [0, 1, 2].map(|c| f64::from(light_per_coverage[c] * coverage[at] * albedo(c, at)));
            film.set_light(pixel, radiance, f64::from(coverage[at]));
        }
        Some(film)
    }
}

/// Where the features are among their planes.
const COVERAGE: Range<usize> = 0..1;
const DEPTH: usize = 1;
const NORMAL: Range<usize> = 2..5;
const ALBEDO: Range<usize> = 5..8;

/// One float per pixel, with a margin.
type Plane = Vec<f32>;

/// Values, and the variances of their errors.
struct Noisy {
    values: Plane,
    variance: Plane,
}

/// A plane that may veto: weights fall as the squared difference times the precision grows.
struct Guide<'a> {
    values: &'a Plane,
    precision: Plane,
}

/// Where pixels are in a [`Plane`].
#[derive(Clone, Copy)]
struct Shape {
    width: usize,
    height: usize,
    stride: usize,
}

impl Shape {
    fn new([width, height]: [u32; 2]) -> Self {
        let (width, height) = (width as usize, height as usize);
        Self { width, height, stride: width + 2 * MARGIN }
    }

    fn pixels(self) -> usize {
        self.width * self.height
    }

    fn at(self, pixel: usize) -> usize {
        (pixel / self.width + MARGIN) * self.stride + pixel % self.width + MARGIN
    }

    fn plane(self, value: impl Fn(usize) -> f32 + Sync) -> Plane {
        let mut plane = vec![0.0; self.stride * (self.height + 2 * MARGIN)];
        plane[MARGIN * self.stride..]
            .par_chunks_exact_mut(self.stride)
            .take(self.height)
            .enumerate()
            .for_each(|(y, row)| {
                let row = row[MARGIN..MARGIN + self.width].iter_mut().enumerate();
                row.for_each(|(x, out)| *out = value(y * self.width + x));
            });
        plane
    }

    /// The squares of pixels around one, itself among them.
    fn around(self, at: usize, radius: usize) -> impl Iterator<Item = usize> {
        let first = at - radius * (self.stride + 1);
        (0..=2 * radius).flat_map(move |y| (0..=2 * radius).map(move |x| first + y * self.stride + x))
    }
}

fn luminance_of([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Coverage, depth, and with guides: normal, albedo.
fn features(film: &Film, shape: Shape) -> Vec<Plane> {
    let finite = |x: f64| if x.is_finite() { x as f32 } else { 0.0 };
    let mut planes =
        vec![shape.plane(|pixel| film.alpha(pixel) as f32), shape.plane(|pixel| finite(film.depth(pixel)))];
    if film.has_guides() {
        for guide in [Film::normal, Film::albedo] {
            for axis in 0..3 {
                planes.push(shape.plane(|pixel| guide(film, pixel).map_or(0.0, |g| finite(g[axis]))));
            }
        }
    }
    planes
}

/// Features with the noise taken off that can be told from their own variation. Each is filtered by itself: of a
/// surface that turns away, albedo may be averaged where normal and depth may not.
fn smooth_features(
    shape: Shape,
    hit: &Plane,
    planes: Vec<Plane>,
    has_time: &(dyn Fn() -> bool + Sync),
) -> Vec<Noisy> {
    let mut noisy: Vec<Noisy> = planes
        .into_iter()
        .map(|values| Noisy { variance: variance_by_second_differences(shape, hit, &values), values })
        .collect();
    // Depth varies more from pixel to pixel than from sample to sample, and has nothing to gain.
    for feature in [COVERAGE, NORMAL, ALBEDO] {
        if let Some(alike) = noisy.get_mut(feature) {
            let sources: Vec<&Plane> = alike.iter().map(|n| &n.values).collect();
            let (tolerance, window) = (FEATURE_TOLERANCE, FEATURE_WINDOW);
            let smooth = nl_means(shape, hit, alike, tolerance, window, &[], &sources, has_time);
            alike.iter_mut().zip(smooth).for_each(|(noisy, values)| noisy.values = values);
        }
    }
    noisy
}

/// The variance of a plane that does not come with one: Immerkær, *Fast Noise Variance Estimation*, 1996. Its mask is
/// blind to slopes and straight edges; the median around a pixel makes little of other edges.
fn variance_by_second_differences(shape: Shape, hit: &Plane, values: &Plane) -> Plane {
    const MASK: [f32; 9] = [1.0, -2.0, 1.0, -2.0, 4.0, -2.0, 1.0, -2.0, 1.0];
    /// The median of a squared standard normal number.
    const MEDIAN_OF_SQUARE: f32 = 0.455;
    let squares = shape.plane(|pixel| {
        let at = shape.at(pixel);
        if shape.around(at, 1).any(|i| hit[i] == 0.0) {
            return f32::NAN;
        }
        let response: f32 = shape.around(at, 1).zip(MASK).map(|(i, m)| m * values[i]).sum();
        response * response / 36.0
    });
    shape.plane(|pixel| {
        let around = shape.around(shape.at(pixel), 2).filter(|&i| hit[i] > 0.0).map(|i| squares[i]);
        median(around.filter(|s| !s.is_nan())).unwrap_or(0.0) / MEDIAN_OF_SQUARE
    })
}

/// The median of at most 25 numbers.
fn median(numbers: impl Iterator<Item = f32>) -> Option<f32> {
    let mut sorted = [0.0; 25];
    let mut count = 0;
    for number in numbers {
        sorted[count] = number;
        count += 1;
    }
    (count > 0).then(|| *sorted[..count].select_nth_unstable_by(count / 2, f32::total_cmp).1)
}

/// The mean of the hit pixels in squares of nine.
fn box_mean(shape: Shape, hit: &Plane, values: &Plane) -> Plane {
    shape.plane(|pixel| {
        let (sum, count) = shape
            .around(shape.at(pixel), 1)
            .fold((0.0, 0.0), |(sum, count), i| (sum + hit[i] * values[i], count + hit[i]));
        if count > 0.0 { sum / count } else { 0.0 }
    })
}

/// Pulls pixels down that one rare, bright path lifts far above all around them: no mean of few would hide them.
/// A pixel that is bright for good says so by its small variance, and stays.
fn tame_fireflies(shape: Shape, hit: &Plane, luminance: &mut Noisy, light: &mut [Plane; 3]) {
    let Noisy { values, variance } = &*luminance;
    let factors = shape.plane(|pixel| {
        let at = shape.at(pixel);
        if hit[at] == 0.0 {
            return 1.0;
        }
        let around = || shape.around(at, 2).filter(|&i| hit[i] > 0.0);
        let center = median(around().map(|i| values[i])).unwrap_or(0.0);
        let error = median(around().map(|i| variance[i])).unwrap_or(0.0).sqrt();
        let most = center + FIREFLY * error;
        let excess = values[at] - center;
        if values[at] > most && excess * excess < 9.0 * variance[at] { most / values[at] } else { 1.0 }
    });
    for (i, &factor) in factors.iter().enumerate() {
        luminance.values[i] *= factor;
        luminance.variance[i] *= factor * factor;
        light.iter_mut().for_each(|plane| plane[i] *= factor);
    }
}

/// How precisely each feature is to be met, by what it is and by its noise.
fn guides<'a>(shape: Shape, hit: &Plane, features: &'a [Noisy]) -> Vec<Guide<'a>> {
    let guide = |(index, Noisy { values, variance }): (usize, &'a Noisy)| {
        let tolerance = |at: usize| match index {
            DEPTH => {
                let slope = slope(shape, hit, values, at);
                DEPTH_TOLERANCE * values[at] + SLOPE_TOLERANCE * WINDOW as f32 * slope
            }
            _ if NORMAL.contains(&index) => NORMAL_TOLERANCE,
            _ if ALBEDO.contains(&index) => ALBEDO_TOLERANCE,
            _ => COVERAGE_TOLERANCE,
        };
        let precision = shape.plane(|pixel| {
            let at = shape.at(pixel);
            1.0 / (tolerance(at).powi(2) + variance[at]).max(1e-20)
        });
        Guide { values, precision }
    };
    features.iter().enumerate().map(guide).collect()
}

/// Change per pixel, the lesser of both sides along each axis: an edge is no slope.
fn slope(shape: Shape, hit: &Plane, values: &Plane, at: usize) -> f32 {
    let along = |step: usize| {
        let side = |i: usize| if hit[i] > 0.0 { (values[i] - values[at]).abs() } else { f32::INFINITY };
        let least = side(at - step).min(side(at + step));
        if least.is_finite() { least } else { 0.0 }
    };
    along(1).hypot(along(shape.stride))
}

/// Weighted means of `sources` over windows. A weight is the lesser of what patches of `alike` and what `guides` say.
#[expect(clippy::too_many_arguments, reason = "the filter's whole state, used twice")]
fn nl_means(
    shape: Shape,
    hit: &Plane,
    alike: &[Noisy],
    tolerance: f32,
    window: usize,
    guides: &[Guide],
    sources: &[&Plane],
    has_time: &(dyn Fn() -> bool + Sync),
) -> Vec<Plane> {
    let bands: Vec<Vec<Vec<f32>>> = (0..shape.height.div_ceil(BAND))
        .into_par_iter()
        .map(|band| {
            let rows = band * BAND..((band + 1) * BAND).min(shape.height);
            let mut filter = Band::new(shape, rows, sources.len());
            let window = window as isize;
            for dy in (-window..=window).take_while(|_| has_time()) {
                for dx in -window..=window {
                    filter.add(hit, alike, tolerance, guides, sources, dy * shape.stride as isize + dx);
                }
            }
            filter.means()
        })
        .collect();
    (0..sources.len())
        .map(|source| {
            shape.plane(|pixel| bands[pixel / shape.width / BAND][source][pixel % (shape.width * BAND)])
        })
        .collect()
}

/// Sums of a band of rows, to which windows are added shift by shift: plain loops over rows, which compilers turn into
/// vector code.
struct Band {
    shape: Shape,
    rows: Range<usize>,
    weights: Vec<f32>,
    sums: Vec<Vec<f32>>,
    /// Differences between the pixels and those a shift away, with `PATCH` more around the band.
    differences: Vec<f32>,
    columns: Vec<f32>,
    distances: Vec<f32>,
    vetoes: Vec<f32>,
}

impl Band {
    fn new(shape: Shape, rows: Range<usize>, sources: usize) -> Self {
        let pixels = rows.len() * shape.width;
        let long = shape.width + 2 * PATCH;
        Self {
            weights: vec![0.0; pixels],
            sums: vec![vec![0.0; pixels]; sources],
            differences: vec![0.0; (rows.len() + 2 * PATCH) * long],
            columns: vec![0.0; long],
            distances: vec![0.0; shape.width],
            vetoes: vec![0.0; shape.width],
            shape,
            rows,
        }
    }

    fn add(
        &mut self,
        hit: &Plane,
        alike: &[Noisy],
        tolerance: f32,
        guides: &[Guide],
        sources: &[&Plane],
        shift: isize,
    ) {
        let Shape { width, stride, .. } = self.shape;
        let long = width + 2 * PATCH;
        for (y, differences) in self.differences.chunks_exact_mut(long).enumerate() {
            let here = (self.rows.start + y + MARGIN - PATCH) * stride + MARGIN - PATCH;
            let pair = Pair { here, there: here.wrapping_add_signed(shift), count: long };
            differences.fill(0.0);
            for noisy in alike {
                let (a, b) = pair.of(&noisy.values);
                let (va, vb) = pair.of(&noisy.variance);
                for x in 0..long {
                    differences[x] += squared_difference([a[x], b[x]], [va[x], vb[x]], tolerance);
                }
            }
            // Where nothing was hit there is nothing to differ.
            let (a, b) = pair.of(hit);
            for x in 0..long {
                differences[x] = differences[x].min(1e4) * a[x] * b[x];
            }
        }

        const SIDE: usize = 2 * PATCH + 1;
        let pixels = 1.0 / (SIDE * SIDE) as f32;
        for y in 0..self.rows.len() {
            self.columns.fill(0.0);
            for row in self.differences[y * long..].chunks_exact(long).take(SIDE) {
                self.columns.iter_mut().zip(row).for_each(|(sum, d)| *sum += d);
            }
            for x in 0..width {
                self.distances[x] = self.columns[x..x + SIDE].iter().sum::<f32>() * pixels;
            }
            let here = (self.rows.start + y + MARGIN) * stride + MARGIN;
            let pair = Pair { here, there: here.wrapping_add_signed(shift), count: width };
            self.vetoes.fill(0.0);
            for guide in guides {
                let (a, b) = pair.of(guide.values);
                let (precision, _) = pair.of(&guide.precision);
                for x in 0..width {
                    self.vetoes[x] += (a[x] - b[x]) * (a[x] - b[x]) * precision[x];
                }
            }
            let (_, hit) = pair.of(hit);
            let row = y * width..(y + 1) * width;
            let weights = &mut self.distances;
            for x in 0..width {
                weights[x] = falloff(weights[x].max(self.vetoes[x])) * hit[x];
            }
            self.weights[row.clone()].iter_mut().zip(&*weights).for_each(|(sum, w)| *sum += w);
            for (sums, source) in self.sums.iter_mut().zip(sources) {
                let (_, source) = pair.of(source);
                for (x, sum) in sums[row.clone()].iter_mut().enumerate() {
                    *sum += weights[x] * source[x];
                }
            }
        }
    }

    fn means(mut self) -> Vec<Vec<f32>> {
        for sums in &mut self.sums {
            for (sum, &weight) in sums.iter_mut().zip(&self.weights) {
                *sum = if weight > 0.0 { *sum / weight } else { 0.0 };
            }
        }
        self.sums
    }
}

/// A run of pixels, and the run that it is compared with.
struct Pair {
    here: usize,
    there: usize,
    count: usize,
}

impl Pair {
    fn of<'a>(&self, plane: &'a Plane) -> (&'a [f32], &'a [f32]) {
        (&plane[self.here..self.here + self.count], &plane[self.there..self.there + self.count])
    }
}

/// Equation 4 of the 2012 paper: 0 on average where only noise differs.
fn squared_difference([a, b]: [f32; 2], [va, vb]: [f32; 2], tolerance: f32) -> f32 {
    ((a - b) * (a - b) - (va + va.min(vb)))
        / (1e-10 * (a * a + b * b) + 1e-30 + tolerance * tolerance * (va + vb))
}

/// Nearly exp(-x), but 0 from 4 on, and quickly computed for many.
fn falloff(x: f32) -> f32 {
    let y = (1.0 - 0.25 * x.max(0.0)).max(0.0);
    (y * y) * (y * y)
}

#[cfg(test)]
mod tests;
