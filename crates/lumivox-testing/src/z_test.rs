//! Are two noisy images estimates of the same thing? A z-test of every pixel, and of the whole.
//!
//! After Mitsuba's `test_renders.py`, which follows Subr and Arvo, *Statistical Hypothesis Testing for Assessing Monte
//! Carlo Estimators*, Pacific Graphics 2007. Under the hypothesis that both have the same mean, the difference of two
//! averages over their joint standard error is nearly standard normal. Every pixel's p-value is compared with a
//! significance corrected for their number ([`sidak`]). Two tests of the whole come on top, since a small bias
//! everywhere hides in every single pixel: of the mean over the image, and of the sum of z^2, which follows a
//! chi-square distribution and finds biases that cancel in the mean.

use std::fmt;

use crate::failures::Difference;
use crate::special::{chi_square_p_value, normal_two_sided_p_value, sidak};

/// An image's means and the variances of those means, all channels of a pixel side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Values per pixel: 1 or 3.
    pub channels: usize,
    /// `width * height * channels` means.
    pub mean: Vec<f64>,
    /// The variance of each mean; infinite where nothing is known, which no test then rejects.
    pub variance: Vec<f64>,
}

impl Estimate {
    /// One value per pixel.
    ///
    /// # Panics
    /// When the lengths do not fit.
    pub fn gray(width: usize, height: usize, mean: &[f64], variance: &[f64]) -> Self {
        Self::new(width, height, 1, mean.to_vec(), variance.to_vec())
    }

    /// Three values per pixel.
    ///
    /// # Panics
    /// When the lengths do not fit.
    pub fn rgb(width: usize, height: usize, mean: &[[f64; 3]], variance: &[[f64; 3]]) -> Self {
        Self::new(width, height, 3, mean.as_flattened().to_vec(), variance.as_flattened().to_vec())
    }

    /// The estimate of several independent runs of the same render (different seeds), for renderers that do not know
    /// their variance. From under 16 runs the variance is itself too uncertain for a z-test.
    ///
    /// # Panics
    /// When there are fewer than two runs, or the lengths do not fit.
    pub fn from_runs(width: usize, height: usize, channels: usize, runs: &[Vec<f64>]) -> Self {
        assert!(runs.len() >= 2, "a variance needs two runs");
        let n = runs.len() as f64;
        let length = width * height * channels;
        assert!(runs.iter().all(|r| r.len() == length), "runs of one size");
        let mean: Vec<f64> = (0..length).map(|i| runs.iter().map(|r| r[i]).sum::<f64>() / n).collect();
        let variance = (0..length)
            .map(|i| runs.iter().map(|r| (r[i] - mean[i]).powi(2)).sum::<f64>() / (n - 1.0) / n)
            .collect();
        Self::new(width, height, channels, mean, variance)
    }

    fn new(width: usize, height: usize, channels: usize, mean: Vec<f64>, variance: Vec<f64>) -> Self {
        let length = width * height * channels;
        assert!(mean.len() == length && variance.len() == length, "one value per pixel and channel");
        Self { width, height, channels, mean, variance }
    }

    /// Averages over blocks of `size * size` pixels (fewer at the right and bottom edge).
    ///
    /// Few samples of a rare bright event are far from normal, and their variance follows their mean: a pixel that
    /// missed the sun believes itself exact. Larger averages are closer to what the z-test assumes and see smaller
    /// biases. A block should expect dozens of the rarest event that matters, above all when the other image has
    /// little noise.
    #[must_use]
    pub fn blocks(&self, size: usize) -> Self {
        let size = size.max(1);
        let (width, height) = (self.width.div_ceil(size), self.height.div_ceil(size));
        let mut mean = vec![0.0; width * height * self.channels];
        let mut variance = mean.clone();
        let mut count = mean.clone();
        for y in 0..self.height {
            for x in 0..self.width {
                for c in 0..self.channels {
                    let from = (y * self.width + x) * self.channels + c;
                    let to = (y / size * width + x / size) * self.channels + c;
                    mean[to] += self.mean[from];
                    variance[to] += self.variance[from];
                    count[to] += 1.0;
                }
            }
        }
        for i in 0..mean.len() {
            mean[i] /= count[i];
            variance[i] /= count[i] * count[i];
        }
        Self::new(width, height, self.channels, mean, variance)
    }
}

/// What a z-test tolerates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZTest {
    /// Probability of each of the three parts (pixels, means, spreads) to reject images that agree.
    pub significance: f64,
    /// Fraction of values that may be rejected all the same: the noise of rare events is not quite normal.
    pub allowed_fraction: f64,
    /// A bias up to this fraction of the reference is let pass (f32 sums, quantised tables), pixels and mean alike.
    pub relative_tolerance: f64,
    /// A bias up to this much is let pass.
    pub absolute_tolerance: f64,
    /// Test blocks of that many pixels across instead of single ones; see [`Estimate::blocks`].
    pub block: usize,
    /// Whether no value's variance may be less than its mean is worth by the image's average (variance per mean).
    ///
    /// A block that met fewer of a rare bright event than it should has both too low a mean and too low a variance,
    /// and looks wrong with confidence. Noise of rare events is like Poisson noise, its variance in proportion to the
    /// mean, so the whole image tells what a block could not know. Costs some power where noise is truly low.
    pub pool_variance: bool,
    /// How many z-tests are made together.
    pub tests: usize,
}

impl Default for ZTest {
    fn default() -> Self {
        Self {
            significance: 0.01,
            allowed_fraction: 0.0025,
            relative_tolerance: 0.0,
            absolute_tolerance: 0.0,
            block: 1,
            pool_variance: true,
            tests: 1,
        }
    }
}

/// A test of one channel's mean over the whole image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanTest {
    /// Mean of the image under test.
    pub image: f64,
    /// Mean of the reference.
    pub reference: f64,
    /// Standard error of their difference.
    pub standard_error: f64,
    /// Probability of such a difference, were the images equal.
    pub p_value: f64,
}

/// A test of how far one channel's z spread over the whole image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpreadTest {
    /// Mean of z^2 over values that have noise: near 1 when the variances are honest and the images agree.
    pub mean_square_z: f64,
    /// Number of these values.
    pub count: usize,
    /// Probability of z as large, were the images equal.
    pub p_value: f64,
}

/// The outcome of a z-test.
#[derive(Clone, Debug, PartialEq)]
pub struct ZTestResult {
    /// Whether the images agree.
    pub accepted: bool,
    /// p-value of every value (of a block, if blocks were tested).
    pub p_values: Vec<f64>,
    /// The p-value under which a value is rejected.
    pub threshold: f64,
    /// Number of rejected values.
    pub rejected: usize,
    /// Number of values that may be rejected.
    pub allowed: usize,
    /// The test of each channel's mean.
    pub means: Vec<MeanTest>,
    /// The test of each channel's spread.
    pub spreads: Vec<SpreadTest>,
    /// The p-value under which a mean or a spread is rejected.
    pub whole_threshold: f64,
}

impl fmt::Display for ZTestResult {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let smallest = self.p_values.iter().copied().fold(1.0, f64::min);
        write!(
            f,
            "{} of {} values rejected ({} allowed; smallest p {smallest:.1e}, threshold {:.1e}); means and spreads (threshold {:.1e}):",
            self.rejected,
            self.p_values.len(),
            self.allowed,
            self.threshold,
            self.whole_threshold
        )?;
        for (m, s) in self.means.iter().zip(&self.spreads) {
            let difference = m.image - m.reference;
            write!(
                f,
                " {:.6} - {:.6} = {difference:+.6} +- {:.6} (p {:.1e}), mean z^2 {:.3} (p {:.1e});",
                m.image, m.reference, m.standard_error, m.p_value, s.mean_square_z, s.p_value
            )?;
        }
        Ok(())
    }
}

impl ZTest {
    /// Tests whether two independent estimates have the same mean, everywhere.
    ///
    /// # Panics
    /// When the images differ in size.
    pub fn run(&self, image: &Estimate, reference: &Estimate) -> ZTestResult {
        assert_eq!(
            (image.width, image.height, image.channels),
            (reference.width, reference.height, reference.channels),
            "images of one size"
        );
        let (mut a, mut b) = (image.blocks(self.block), reference.blocks(self.block));
        if self.pool_variance {
            pool_variances(&mut a, &mut b);
        }
        let z = |i: usize| self.z(a.mean[i], b.mean[i], a.variance[i] + b.variance[i]);
        let p_values: Vec<f64> = (0..a.mean.len()).map(|i| normal_two_sided_p_value(z(i))).collect();
        let threshold = sidak(self.significance, p_values.len() * self.tests);
        let passed = p_values.iter().filter(|p| **p >= threshold).count();
        // What is not a number did not pass either.
        let rejected = p_values.len() - passed;
        let allowed = (self.allowed_fraction * p_values.len() as f64) as usize;

        let channels = 0..image.channels;
        let means: Vec<MeanTest> = channels.clone().map(|c| self.mean_test(image, reference, c)).collect();
        let spreads: Vec<SpreadTest> = channels
            .map(|channel| {
                let noisy = |i: &usize| {
                    let variance = a.variance[*i] + b.variance[*i];
                    variance > 0.0 && variance.is_finite()
                };
                let values = (channel..a.mean.len()).step_by(a.channels).filter(noisy);
                SpreadTest::new(&values.map(z).collect::<Vec<f64>>())
            })
            .collect();
        let whole_threshold = sidak(self.significance, image.channels * self.tests);
        let accepted = rejected <= allowed
            && means.iter().all(|m| m.p_value >= whole_threshold)
            && spreads.iter().all(|s| s.p_value >= whole_threshold);
        ZTestResult { accepted, p_values, threshold, rejected, allowed, means, spreads, whole_threshold }
    }

    /// [`run`](Self::run), and on rejection pictures of what differs.
    ///
    /// # Panics
    /// When the images do not agree; the message has the figures and says where the pictures are.
    pub fn assert_agree(&self, test: &str, image: &Estimate, reference: &Estimate) {
        let result = self.run(image, reference);
        if result.accepted {
            return;
        }
        let (a, b) = (image.blocks(self.block), reference.blocks(self.block));
        let difference = Difference {
            width: a.width,
            height: a.height,
            channels: a.channels,
            image: &a.mean,
            reference: &b.mean,
            p_values: &result.p_values,
            threshold: result.threshold,
        };
        let pictures = match difference.write(test) {
            Ok(folder) => format!("see {}", folder.display()),
            Err(error) => format!("no pictures: {error}"),
        };
        panic!("{test}: the images differ by more than noise: {result}\n{pictures}");
    }

    /// How many standard errors two means are apart, beyond what is tolerated.
    fn z(&self, image: f64, reference: f64, variance: f64) -> f64 {
        let tolerated = self.absolute_tolerance + self.relative_tolerance * reference.abs();
        let difference = (image - reference).abs();
        if difference <= tolerated { 0.0 } else { (difference - tolerated) / variance.sqrt() }
    }

    /// Pixels of infinite variance count as equal, not as noise without end.
    fn mean_test(&self, image: &Estimate, reference: &Estimate, channel: usize) -> MeanTest {
        let (mut a, mut b, mut variance, mut n) = (0.0, 0.0, 0.0, 0.0);
        for i in (channel..image.mean.len()).step_by(image.channels) {
            let v = image.variance[i] + reference.variance[i];
            if v == f64::INFINITY {
                continue;
            }
            a += image.mean[i];
            b += reference.mean[i];
            variance += v;
            n += 1.0;
        }
        let n = f64::max(n, 1.0);
        let z = self.z(a / n, b / n, variance / (n * n));
        MeanTest {
            image: a / n,
            reference: b / n,
            standard_error: variance.sqrt() / n,
            p_value: normal_two_sided_p_value(z),
        }
    }
}

/// Raises each variance to what the larger of the two means is worth by its image's average.
fn pool_variances(a: &mut Estimate, b: &mut Estimate) {
    let means: Vec<f64> = a.mean.iter().zip(&b.mean).map(|(a, b)| a.abs().max(b.abs())).collect();
    for estimate in [a, b] {
        for channel in 0..estimate.channels {
            let indices = || (channel..means.len()).step_by(estimate.channels);
            let known = || indices().filter(|i| estimate.variance[*i].is_finite());
            let mean: f64 = known().map(|i| means[i]).sum();
            let variance_per_mean = known().map(|i| estimate.variance[i]).sum::<f64>() / mean;
            if mean > 0.0 {
                indices().for_each(|i| {
                    estimate.variance[i] = estimate.variance[i].max(variance_per_mean * means[i]);
                });
            }
        }
    }
}

impl SpreadTest {
    fn new(z: &[f64]) -> Self {
        let sum: f64 = z.iter().map(|z| z * z).sum();
        let count = z.len();
        let p_value = if count == 0 { 1.0 } else { chi_square_p_value(sum, count as f64) };
        Self { mean_square_z: sum / count.max(1) as f64, count, p_value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For noise that does not depend on the mean.
    const UNPOOLED: ZTest = ZTest {
        significance: 0.01,
        allowed_fraction: 0.0025,
        relative_tolerance: 0.0,
        absolute_tolerance: 0.0,
        block: 1,
        pool_variance: false,
        tests: 1,
    };

    /// Nearly normal numbers of mean 0 and variance 1: twelve uniform ones.
    fn normal(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            let mut sum = -6.0;
            for _ in 0..12 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                sum += (state >> 33) as f64 / (1u64 << 31) as f64;
            }
            sum
        }
    }

    fn noisy(seed: u64, mean: impl Fn(usize) -> f64, sigma: f64) -> Estimate {
        let mut normal = normal(seed);
        let values: Vec<f64> = (0..64 * 64).map(|i| mean(i) + sigma * normal()).collect();
        Estimate::gray(64, 64, &values, &vec![sigma * sigma; 64 * 64])
    }

    #[test]
    fn images_that_agree_are_accepted() {
        for seed in 0..20 {
            let a = noisy(2 * seed, |i| i as f64, 0.1);
            let b = noisy(2 * seed + 1, |i| i as f64, 0.3);
            let result = ZTest { tests: 20, ..UNPOOLED }.run(&a, &b);
            assert!(result.accepted, "{result}");
            assert!((result.spreads[0].mean_square_z - 1.0).abs() < 0.15, "{result}");
        }
    }

    #[test]
    fn a_wrong_region_is_rejected() {
        let a = noisy(1, |_| 1.0, 0.1);
        let b = noisy(2, |i| if i < 64 { 2.0 } else { 1.0 }, 0.1);
        let result = UNPOOLED.run(&a, &b);
        assert!(!result.accepted && result.rejected >= 60, "{result}");
    }

    #[test]
    fn a_bias_too_small_for_any_pixel_is_found_in_the_mean_and_can_be_tolerated() {
        let a = noisy(1, |_| 1.0, 0.1);
        let b = noisy(2, |_| 1.02, 0.1);
        let result = UNPOOLED.run(&a, &b);
        assert!(!result.accepted && result.rejected == 0, "{result}");
        assert!(ZTest { relative_tolerance: 0.03, ..UNPOOLED }.run(&a, &b).accepted);
        assert!(!ZTest { block: 16, ..UNPOOLED }.run(&a, &b).accepted);
    }

    #[test]
    fn biases_that_cancel_in_the_mean_are_found_in_the_spread() {
        let a = noisy(1, |_| 1.0, 0.1);
        let b = noisy(2, |i| if i % 2 == 0 { 1.05 } else { 0.95 }, 0.1);
        let result = UNPOOLED.run(&a, &b);
        assert!(!result.accepted && result.rejected == 0, "{result}");
        assert!(result.means[0].p_value > 0.01 && result.spreads[0].p_value < 1e-4, "{result}");
    }

    #[test]
    fn rare_events_are_forgiven_when_variances_are_pooled_but_a_bias_is_not() {
        // Every sample is 1000 with probability 1/1000; a pixel takes 1000 of them, so one in three sees none.
        let poisson = |seed: u64, rate: f64| {
            let mut state = seed;
            let mut estimate = noisy(seed, |_| 0.0, 0.0);
            for i in 0..64 * 64 {
                let hits = (0..1000)
                    .filter(|_| {
                        state = state
                            .wrapping_mul(6_364_136_223_846_793_005)
                            .wrapping_add(1_442_695_040_888_963_407);
                        ((state >> 33) as f64 / (1u64 << 31) as f64) < rate * 1e-3
                    })
                    .count() as f64;
                (estimate.mean[i], estimate.variance[i]) = (hits, hits);
            }
            estimate
        };
        let exact = noisy(0, |_| 1.0, 0.0);
        let pooled = ZTest { block: 2, allowed_fraction: 0.0, ..ZTest::default() };
        let unpooled = ZTest { pool_variance: false, ..pooled };
        assert!(!unpooled.run(&poisson(1, 1.0), &exact).accepted);
        let result = pooled.run(&poisson(1, 1.0), &exact);
        assert!(result.accepted, "{result}");
        assert!(!pooled.run(&poisson(2, 1.1), &exact).accepted);
    }

    #[test]
    fn without_noise_only_equality_passes() {
        let exact = |v: f64| Estimate::gray(2, 1, &[v, v], &[0.0, 0.0]);
        assert!(UNPOOLED.run(&exact(1.0), &exact(1.0)).accepted);
        assert!(!UNPOOLED.run(&exact(1.0), &exact(1.0 + 1e-9)).accepted);
        assert!(!UNPOOLED.run(&exact(f64::NAN), &exact(1.0)).accepted);
        let unknown = Estimate::gray(2, 1, &[5.0, 5.0], &[f64::INFINITY; 2]);
        assert!(UNPOOLED.run(&unknown, &exact(1.0)).accepted);
    }

    #[test]
    fn runs_give_the_variance_of_their_mean() {
        let runs = [vec![1.0], vec![3.0], vec![5.0], vec![7.0]];
        let estimate = Estimate::from_runs(1, 1, 1, &runs);
        assert_eq!((estimate.mean[0], estimate.variance[0]), (4.0, 20.0 / 3.0 / 4.0));
    }

    #[test]
    fn a_rejection_leaves_pictures() {
        let a = noisy(1, |_| 1.0, 0.1);
        let b = noisy(2, |i| if i % 64 < 32 { 2.0 } else { 1.0 }, 0.1);
        let test = "selftest-of-the-z-test";
        let panic = std::panic::catch_unwind(|| UNPOOLED.assert_agree(test, &a, &b)).unwrap_err();
        let message = panic.downcast_ref::<String>().unwrap();
        let folder = crate::failures::folder(test);
        assert!(message.contains(&folder.display().to_string()), "{message}");
        for name in ["image", "reference", "error", "p_value"] {
            let picture = crate::png_io::SrgbImage::read(&folder.join(format!("{name}.png"))).unwrap();
            assert_eq!((picture.width, picture.height), (64, 64));
        }
        std::fs::remove_dir_all(folder).unwrap();
    }
}
