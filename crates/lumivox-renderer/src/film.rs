//! A film brought back to the CPU: sums over samples, and what they mean.

use lumivox_core::color;

/// Floats of a pixel in one plane.
const CHANNELS: usize = 4;

/// A film's sums. Planes of `(radiance, alpha)`, `(view depth, squared luminance, samples, 0)` and, where the view
/// has guides, `(first-hit albedo, 0)` and `(first-hit normal, 0)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    planes: Vec<Vec<[f32; CHANNELS]>>,
}

impl Film {
    /// A film of 2 or 4 planes without a sample.
    pub fn new(width: u32, height: u32, guides: bool) -> Self {
        let pixels = width as usize * height as usize;
        Self { width, height, planes: vec![vec![[0.0; CHANNELS]; pixels]; plane_count(guides)] }
    }

    /// Replaces the window at `origin` by a read-back of a view's film buffer.
    ///
    /// # Panics
    /// When the bytes are not a window of that size, or it does not fit.
    pub fn insert(&mut self, origin: [u32; 2], size: [u32; 2], bytes: &[u8]) {
        self.insert_samples(origin, size, bytes, 0);
    }

    /// As [`insert`](Self::insert), of a view whose first sample is not 0: what its counts include of others is taken off.
    ///
    /// # Panics
    /// As [`insert`](Self::insert).
    pub fn insert_samples(
        &mut self,
        origin: [u32; 2],
        [width, height]: [u32; 2],
        bytes: &[u8],
        first_sample: u32,
    ) {
        let pixels: Vec<[f32; CHANNELS]> = bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect();
        let count = width as usize * height as usize;
        assert_eq!(pixels.len(), count * self.planes.len(), "a window has as many planes as the film");
        for (plane, window) in self.planes.iter_mut().zip(pixels.chunks_exact(count)) {
            for (y, row) in window.chunks_exact(width as usize).enumerate() {
                let start = (origin[1] as usize + y) * self.width as usize + origin[0] as usize;
                plane[start..start + width as usize].copy_from_slice(row);
            }
        }
        for y in 0..height as usize {
            let start = (origin[1] as usize + y) * self.width as usize + origin[0] as usize;
            // Counts are exact below 2^24.
            self.planes[1][start..start + width as usize]
                .iter_mut()
                .for_each(|moments| moments[2] -= first_sample as f32);
        }
    }

    /// The sums as they are: planes of four floats a pixel, rows from the top.
    pub fn planes(&self) -> &[Vec<[f32; CHANNELS]>] {
        &self.planes
    }

    /// A film of sums as [`planes`](Self::planes) gives them: 2, or 4 with guides; `None` where they are not that many, or
    /// not of that size.
    pub fn from_planes(width: u32, height: u32, planes: Vec<Vec<[f32; CHANNELS]>>) -> Option<Self> {
        let pixels = width as usize * height as usize;
        let known = [plane_count(false), plane_count(true)].contains(&planes.len());
        let fit = known && planes.iter().all(|plane| plane.len() == pixels);
        fit.then_some(Self { width, height, planes })
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// The number of samples of a pixel, rows from the top.
    pub fn samples(&self, pixel: usize) -> f32 {
        self.planes[1][pixel][2]
    }

    /// The fewest samples of any pixel.
    pub fn min_samples(&self) -> u32 {
        self.planes[1].iter().map(|m| m[2]).fold(f32::INFINITY, f32::min) as u32
    }

    fn mean(&self, plane: usize, pixel: usize) -> [f64; CHANNELS] {
        let n = f64::from(self.samples(pixel).max(1.0));
        self.planes[plane][pixel].map(|x| f64::from(x) / n)
    }

    /// Mean radiance scattered by the volumes, linear RGB; the background is not in it.
    pub fn radiance(&self, pixel: usize) -> [f64; 3] {
        let [r, g, b, _] = self.mean(0, pixel);
        [r, g, b]
    }

    /// The fraction of primary rays that hit something.
    pub fn alpha(&self, pixel: usize) -> f64 {
        self.mean(0, pixel)[3]
    }

    /// Distance along the view direction to the first collision, in world units, averaged over hits; infinite
    /// without any.
    pub fn depth(&self, pixel: usize) -> f64 {
        let hits = f64::from(self.planes[0][pixel][3]);
        if hits > 0.0 { f64::from(self.planes[1][pixel][0]) / hits } else { f64::INFINITY }
    }

    /// Mean albedo of the first hits; `None` where the film has no guides.
    pub fn albedo(&self, pixel: usize) -> Option<[f64; 3]> {
        self.guide(2, pixel)
    }

    /// Mean normal of the first hits, in world space; `None` where the film has no guides.
    pub fn normal(&self, pixel: usize) -> Option<[f64; 3]> {
        self.guide(3, pixel)
    }

    fn guide(&self, plane: usize, pixel: usize) -> Option<[f64; 3]> {
        let sum = self.planes.get(plane)?[pixel];
        let hits = f64::from(self.planes[0][pixel][3].max(f32::MIN_POSITIVE));
        Some([0, 1, 2].map(|i| f64::from(sum[i]) / hits))
    }

    /// Whether first-hit albedo and normal were kept.
    pub fn has_guides(&self) -> bool {
        self.planes.len() > plane_count(false)
    }

    /// Gives a pixel that no sample hit, as if one had, a first hit: depth, and with guides normal and albedo, in a row.
    pub(crate) fn set_first_hit(&mut self, pixel: usize, mut first_hit: impl Iterator<Item = f32>) {
        let mut next = || first_hit.next().unwrap_or(0.0);
        self.planes[0][pixel][3] = 1.0;
        self.planes[1][pixel][0] = next();
        for plane in self.planes[2..].iter_mut().rev() {
            plane[pixel] = [next(), next(), next(), 0.0];
        }
    }

    /// Replaces the means of radiance and alpha. All else remains, the variance too.
    pub(crate) fn set_light(&mut self, pixel: usize, radiance: [f64; 3], alpha: f64) {
        let n = f64::from(self.samples(pixel));
        let (before, depth) = (self.luminance(pixel).0, self.depth(pixel));
        let [albedo, normal] = [self.albedo(pixel), self.normal(pixel)];
        let [r, g, b] = radiance;
        self.planes[0][pixel] = [r, g, b, alpha].map(|mean| (mean * n) as f32);
        let after = self.luminance(pixel).0;
        let moments = &mut self.planes[1][pixel];
        moments[1] += (n * (after * after - before * before)) as f32;
        // Sums over hits follow the number of hits.
        let hits = alpha * n;
        moments[0] = (depth * hits) as f32;
        for (plane, mean) in self.planes[2..].iter_mut().zip([albedo, normal]) {
            let [x, y, z] = mean.unwrap_or_default().map(|mean| (mean * hits) as f32);
            plane[pixel] = [x, y, z, 0.0];
        }
    }

    /// Mean luminance, and the variance of that mean.
    pub fn luminance(&self, pixel: usize) -> (f64, f64) {
        let n = f64::from(self.samples(pixel));
        let mean = color::luminance(self.radiance(pixel));
        let squares = f64::from(self.planes[1][pixel][1]);
        // Unbiased sample variance, over n for the mean's.
        let variance =
            if n > 1.0 { (squares - n * mean * mean).max(0.0) / (n - 1.0) / n } else { f64::INFINITY };
        (mean, variance)
    }

    /// The noise left: root mean square standard error of the pixels that show something, as a fraction of their
    /// mean luminance. `None` before a second sample, or where nothing is seen.
    pub fn noise(&self) -> Option<f64> {
        let (mut variance, mut mean, mut seen) = (0.0, 0.0, 0.0);
        for pixel in 0..self.planes[0].len() {
            if self.planes[0][pixel][3] > 0.0 && self.samples(pixel) > 1.0 {
                let (m, v) = self.luminance(pixel);
                variance += v;
                mean += m;
                seen += 1.0;
            }
        }
        (mean > 0.0).then(|| (variance / seen).sqrt() / (mean / seen))
    }
}

/// Planes of a film.
pub(crate) fn plane_count(guides: bool) -> usize {
    if guides { 4 } else { 2 }
}

/// Bytes of a pixel in all planes.
pub(crate) fn bytes_per_pixel(guides: bool) -> u64 {
    (plane_count(guides) * CHANNELS * size_of::<f32>()) as u64
}
