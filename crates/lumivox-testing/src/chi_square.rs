//! Does a sampler of directions draw from the density it claims? Pearson's chi-square goodness-of-fit test.
//!
//! As in Mitsuba's `chi2.py`: the sphere is cut into bins of equal solid angle, the density is integrated over each,
//! bins that expect too little are pooled, and the statistic's tail probability is compared with a significance
//! corrected for the number of tests ([`sidak`]).

use std::f64::consts::{PI, TAU};
use std::fmt;

use lumivox_core::glam::DVec3;

use crate::special::{chi_square_p_value, sidak};

/// Under this expectation a bin's count is not close enough to normal.
const SMALLEST_EXPECTATION: f64 = 5.0;

/// A goodness-of-fit test for samplers of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereTest {
    /// Bins from pole to pole (in the cosine); there are twice as many around.
    pub polar_bins: usize,
    /// Directions to draw.
    pub samples: usize,
    /// Probability that a family of `tests` rejects a correct sampler.
    pub significance: f64,
    /// How many tests are made together.
    pub tests: usize,
    /// Each bin's density is integrated over this many cells per axis, two Gauss points each: more for a sharp peak.
    pub cells: usize,
}

impl Default for SphereTest {
    fn default() -> Self {
        Self { polar_bins: 20, samples: 200_000, significance: 0.01, tests: 1, cells: 8 }
    }
}

/// Whether sampler and density agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing speaks against it.
    Accepted,
    /// The counts are too far from the density.
    Mismatch,
    /// Directions came from where the density is zero.
    Impossible,
    /// The density does not integrate to 1.
    NotNormalised,
    /// A direction is not a unit vector.
    NotUnit,
}

/// The outcome of a goodness-of-fit test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GoodnessOfFit {
    /// The decision.
    pub verdict: Verdict,
    /// Pearson's statistic.
    pub statistic: f64,
    /// Pooled bins, less one.
    pub degrees_of_freedom: usize,
    /// Probability of a statistic at least as large, were the sampler correct.
    pub p_value: f64,
    /// The p-value under which a sampler is rejected.
    pub threshold: f64,
    /// The density's integral over the sphere.
    pub integral: f64,
}

impl fmt::Display for GoodnessOfFit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "{:?}: chi^2 = {:.1} with {} degrees of freedom, p = {:.2e} (threshold {:.2e}); the density integrates to {:.5}",
            self.verdict,
            self.statistic,
            self.degrees_of_freedom,
            self.p_value,
            self.threshold,
            self.integral
        )
    }
}

impl SphereTest {
    /// Draws unit directions from `sample` and compares them with `density` (per steradian).
    pub fn run(&self, density: impl Fn(DVec3) -> f64, mut sample: impl FnMut() -> DVec3) -> GoodnessOfFit {
        let around = 2 * self.polar_bins;
        let mut observed = vec![0.0; self.polar_bins * around];
        let mut unit = true;
        for _ in 0..self.samples {
            let d = sample();
            unit &= (d.length_squared() - 1.0).abs() < 1e-6;
            let row = ((d.y + 1.0) / 2.0 * self.polar_bins as f64) as usize;
            let column = ((d.z.atan2(d.x) + PI) / TAU * around as f64) as usize;
            observed[row.min(self.polar_bins - 1) * around + column.min(around - 1)] += 1.0;
        }
        let probabilities = self.integrate(density);
        let integral: f64 = probabilities.iter().sum();
        let expected: Vec<f64> = probabilities.iter().map(|p| p * self.samples as f64).collect();
        let (statistic, cells, impossible) = pearson(&observed, &expected);
        let degrees_of_freedom = cells.saturating_sub(1);
        let p_value = if degrees_of_freedom == 0 {
            1.0
        } else {
            chi_square_p_value(statistic, degrees_of_freedom as f64)
        };
        let threshold = sidak(self.significance, self.tests);
        let verdict = if !unit {
            Verdict::NotUnit
        } else if (integral - 1.0).abs() > 1e-3 {
            Verdict::NotNormalised
        } else if impossible {
            Verdict::Impossible
        } else if p_value < threshold {
            Verdict::Mismatch
        } else {
            Verdict::Accepted
        };
        GoodnessOfFit { verdict, statistic, degrees_of_freedom, p_value, threshold, integral }
    }

    /// The density's integral over every bin: two-point Gauss-Legendre on a grid of cells.
    fn integrate(&self, density: impl Fn(DVec3) -> f64) -> Vec<f64> {
        let around = 2 * self.polar_bins;
        let fine = (self.polar_bins * self.cells, around * self.cells);
        let solid_angle = 4.0 * PI / (fine.0 * fine.1) as f64;
        let gauss = [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()];
        let mut probabilities = vec![0.0; self.polar_bins * around];
        for i in 0..fine.0 {
            for u in gauss {
                let y = -1.0 + 2.0 * (i as f64 + u) / fine.0 as f64;
                let r = (1.0 - y * y).sqrt();
                for j in 0..fine.1 {
                    for v in gauss {
                        let (sin, cos) = (-PI + TAU * (j as f64 + v) / fine.1 as f64).sin_cos();
                        probabilities[i / self.cells * around + j / self.cells] +=
                            density(DVec3::new(r * cos, y, r * sin)) * solid_angle / 4.0;
                    }
                }
            }
        }
        probabilities
    }
}

/// Pearson's statistic over bins pooled to a sufficient expectation, the number of pooled bins, and whether anything
/// fell into a bin of probability zero.
fn pearson(observed: &[f64], expected: &[f64]) -> (f64, usize, bool) {
    let mut bins: Vec<(f64, f64)> = observed.iter().copied().zip(expected.iter().copied()).collect();
    let impossible = bins.iter().any(|&(o, e)| e == 0.0 && o > 0.0);
    bins.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut pooled: Vec<(f64, f64)> = Vec::new();
    let mut open = (0.0, 0.0);
    for (o, e) in bins {
        open = (open.0 + o, open.1 + e);
        if open.1 >= SMALLEST_EXPECTATION {
            pooled.push(std::mem::take(&mut open));
        }
    }
    // What is left over joins the last pool.
    if let Some(last) = pooled.last_mut() {
        *last = (last.0 + open.0, last.1 + open.1);
    }
    let statistic = pooled.iter().map(|(o, e)| (o - e).powi(2) / e).sum();
    (statistic, pooled.len(), impossible)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniform numbers of a 64-bit linear congruential generator, high bits only.
    fn uniform(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1u64 << 31) as f64
        }
    }

    fn direction(y: f64, v: f64) -> DVec3 {
        let r = (1.0 - y * y).max(0.0).sqrt();
        DVec3::new(r * (TAU * v).cos(), y, r * (TAU * v).sin())
    }

    #[test]
    fn a_correct_sampler_passes_and_rarely_fails_by_chance() {
        let mut random = uniform(1);
        let test = SphereTest { samples: 20_000, polar_bins: 10, ..SphereTest::default() };
        let p_values: Vec<f64> = (0..40)
            .map(|_| test.run(|_| 0.25 / PI, || direction(2.0 * random() - 1.0, random())).p_value)
            .collect();
        // p-values of a true hypothesis are uniform.
        let mean = p_values.iter().sum::<f64>() / 40.0;
        assert!((mean - 0.5).abs() < 4.0 / (12.0 * 40.0f64).sqrt(), "{mean}");
    }

    #[test]
    fn a_forgotten_sine_is_found() {
        // Uniform in the angle instead of its cosine: what a light sampler without sin(theta) does.
        let mut random = uniform(2);
        let result = SphereTest::default().run(|_| 0.25 / PI, || direction((PI * random()).cos(), random()));
        assert_eq!(result.verdict, Verdict::Mismatch, "{result}");
    }

    #[test]
    fn broken_densities_and_directions_are_named() {
        let test = SphereTest { samples: 2000, ..SphereTest::default() };
        let mut random = uniform(3);
        let mut anywhere = || direction(2.0 * random() - 1.0, random());
        assert_eq!(test.run(|_| 0.5 / PI, &mut anywhere).verdict, Verdict::NotNormalised);
        let upper = |d: DVec3| if d.y > 0.0 { 0.5 / PI } else { 0.0 };
        assert_eq!(test.run(upper, &mut anywhere).verdict, Verdict::Impossible);
        assert_eq!(test.run(|_| 0.25 / PI, || anywhere() * 2.0).verdict, Verdict::NotUnit);
    }
}
