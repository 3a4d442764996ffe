//! What a render knows about every pixel: means, and how far off they may be.

use lumivox_core::glam::DVec3;

use crate::path::PathSample;

/// A rendered image with the variance of every estimate. Rows run from the top, pixels of a row from the left.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceImage {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Paths per pixel.
    pub samples: u32,
    /// Mean radiance of paths that hit something, linear RGB. Others count as 0: it is premultiplied by alpha.
    pub radiance: Vec<[f64; 3]>,
    /// Variance of the mean radiance; infinite under two samples.
    pub radiance_variance: Vec<[f64; 3]>,
    /// Fraction of primary rays that hit something.
    pub alpha: Vec<f64>,
    /// Variance of alpha; infinite under two samples.
    pub alpha_variance: Vec<f64>,
    /// Distance of the first hit along the camera's forward axis in metres, averaged over hits; 0 without hits.
    pub depth: Vec<f64>,
    /// Variance of the mean depth; infinite under two hits.
    pub depth_variance: Vec<f64>,
    /// Albedo of the first hit, colour included, averaged over hits; 0 without hits.
    pub albedo: Vec<[f64; 3]>,
    /// Unit world normal of the first hit on the viewer's side, averaged over hits; 0 without hits.
    pub normal: Vec<[f64; 3]>,
}

impl ReferenceImage {
    pub(crate) fn new(width: usize, height: usize, samples: u32, pixels: &[PixelSums]) -> Self {
        let means = |sums: fn(&PixelSums) -> &[Moments; 3]| -> Vec<[f64; 3]> {
            pixels.iter().map(|p| sums(p).map(|m| m.mean)).collect()
        };
        Self {
            width,
            height,
            samples,
            radiance: means(|p| &p.radiance),
            radiance_variance: pixels.iter().map(|p| p.radiance.map(|m| m.variance_of_mean())).collect(),
            alpha: pixels.iter().map(|p| p.alpha.mean).collect(),
            alpha_variance: pixels.iter().map(|p| p.alpha.variance_of_mean()).collect(),
            depth: pixels.iter().map(|p| p.depth.mean).collect(),
            depth_variance: pixels.iter().map(|p| p.depth.variance_of_mean()).collect(),
            albedo: means(|p| &p.albedo),
            normal: means(|p| &p.normal),
        }
    }

    /// Mean radiance over the whole image, and its standard error.
    pub fn mean_radiance(&self) -> [(f64, f64); 3] {
        let n = self.radiance.len() as f64;
        std::array::from_fn(|i| {
            let sum: f64 = self.radiance.iter().map(|c| c[i]).sum();
            let variance: f64 = self.radiance_variance.iter().map(|c| c[i]).sum();
            (sum / n, variance.sqrt() / n)
        })
    }

    /// Mean alpha over the whole image, and its standard error.
    pub fn mean_alpha(&self) -> (f64, f64) {
        let n = self.alpha.len() as f64;
        (self.alpha.iter().sum::<f64>() / n, self.alpha_variance.iter().sum::<f64>().sqrt() / n)
    }
}

/// Count, mean and sum of squared deviations of a stream of numbers.
///
/// Welford, *Note on a Method for Calculating Corrected Sums of Squares and Products*, Technometrics 4(3), 1962.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, x: f64) {
        self.count += 1.0;
        let delta = x - self.mean;
        self.mean += delta / self.count;
        self.squares += delta * (x - self.mean);
    }

    /// Unbiased variance of the mean; infinite where nothing can be said.
    fn variance_of_mean(&self) -> f64 {
        if self.count < 2.0 { f64::INFINITY } else { self.squares / (self.count - 1.0) / self.count }
    }
}

/// What the samples of one pixel add up to.
#[derive(Clone, Debug, Default)]
pub(crate) struct PixelSums {
    radiance: [Moments; 3],
    alpha: Moments,
    depth: Moments,
    albedo: [Moments; 3],
    normal: [Moments; 3],
}

impl PixelSums {
    /// Adds a path; `depth` gives the view depth of a world point.
    pub(crate) fn add(&mut self, path: &PathSample, depth: impl Fn(DVec3) -> f64) {
        let add = |moments: &mut [Moments; 3], values: [f64; 3]| {
            moments.iter_mut().zip(values).for_each(|(m, x)| m.add(x));
        };
        add(&mut self.radiance, path.radiance);
        self.alpha.add(if path.first_hit.is_some() { 1.0 } else { 0.0 });
        if let Some(hit) = path.first_hit {
            self.depth.add(depth(hit.point));
            add(&mut self.albedo, hit.albedo);
            add(&mut self.normal, hit.normal.to_array());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_textbook() {
        let mut moments = Moments::default();
        assert_eq!(moments.variance_of_mean(), f64::INFINITY);
        for x in [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0] {
            moments.add(x);
        }
        assert_eq!(moments.mean, 5.0);
        assert!((moments.variance_of_mean() - 32.0 / 7.0 / 8.0).abs() < 1e-15);
    }

    #[test]
    fn misses_count_in_alpha_and_radiance_but_not_in_depth() {
        let hit = crate::path::FirstHit { point: DVec3::Z, albedo: [0.5; 3], normal: DVec3::Y };
        let mut sums = PixelSums::default();
        sums.add(&PathSample { radiance: [1.0; 3], first_hit: Some(hit) }, |p| p.z);
        sums.add(&PathSample::default(), |p| p.z);
        let image = ReferenceImage::new(1, 1, 2, &[sums]);
        assert_eq!((image.radiance[0], image.alpha[0], image.depth[0]), ([0.5; 3], 0.5, 1.0));
        assert_eq!((image.albedo[0], image.normal[0]), ([0.5; 3], [0.0, 1.0, 0.0]));
        assert_eq!(image.depth_variance[0], f64::INFINITY);
    }
}
