//! From a film to pixels: background, exposure, tone map. The CPU twin of `display.wgsl` and `tone_map.wgsl`, for
//! hosts that keep the image after their GPU is gone, and the test of the GPU's.

use lumivox_core::color::{linear_from_srgb, srgb_from_linear};
use lumivox_core::{Environment, PerspectiveCamera, document};
use lumivox_shaders::constants;
use lumivox_shaders::layout::DisplayParams;
use rayon::prelude::*;

use crate::film::Film;

/// What is seen where no volume is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// Nothing: the image has an alpha channel.
    Transparent,
    /// A linear RGB colour, before exposure.
    Color([f64; 3]),
    /// The environment that lights the scene.
    Environment,
}

/// How scene-linear light becomes display values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ToneMap {
    /// Clamped, with the sRGB transfer function.
    Plain,
    /// A soft film-like curve in the manner of AgX: bright colours fade to white.
    #[default]
    Agx,
    /// A contrasty film-like curve in the manner of ACES.
    Aces,
}

/// How a film is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplaySettings {
    /// What is seen where no volume is.
    pub background: Background,
    /// Stops: +1 doubles the light.
    pub exposure_ev: f64,
    /// The curve.
    pub tone_map: ToneMap,
    /// Brightens the mid-tones above 1, darkens them below.
    pub gamma: f64,
}

impl Default for DisplaySettings {
    fn default() -> Self {
        Self { background: Background::Color([0.0; 3]), exposure_ev: 0.0, tone_map: ToneMap::Agx, gamma: 1.0 }
    }
}

impl From<document::Tone> for ToneMap {
    fn from(tone: document::Tone) -> Self {
        match tone {
            document::Tone::Plain => Self::Plain,
            document::Tone::Agx => Self::Agx,
            document::Tone::Aces => Self::Aces,
        }
    }
}

/// Of a document's colour nothing is left: it is what the screen is to show, not a light, and is [put behind](put_on) the pixels.
impl From<&document::Display> for DisplaySettings {
    fn from(display: &document::Display) -> Self {
        Self {
            background: match display.background {
                document::Backdrop::Environment => Background::Environment,
                document::Backdrop::Transparent | document::Backdrop::Color(_) => Background::Transparent,
            },
            exposure_ev: display.exposure,
            tone_map: display.tone.into(),
            gamma: display.gamma,
        }
    }
}

impl DisplaySettings {
    /// What multiplies the light.
    fn exposure_scale(&self) -> f64 {
        if self.exposure_ev.is_finite() { self.exposure_ev.clamp(-64.0, 64.0).exp2() } else { 1.0 }
    }

    fn inverse_gamma(&self) -> f64 {
        if self.gamma.is_finite() && self.gamma > 0.0 { 1.0 / self.gamma.clamp(0.05, 20.0) } else { 1.0 }
    }

    pub(crate) fn params(&self) -> DisplayParams {
        let (background_kind, background) = match self.background {
            Background::Transparent => (constants::BACKGROUND_TRANSPARENT, [0.0; 3]),
            Background::Color(color) => (constants::BACKGROUND_COLOR, color.map(|c| c as f32)),
            Background::Environment => (constants::BACKGROUND_ENVIRONMENT, [0.0; 3]),
        };
        DisplayParams {
            background,
            background_kind,
            exposure_scale: self.exposure_scale() as f32,
            tone_operator: match self.tone_map {
                ToneMap::Plain => constants::TONE_PLAIN,
                ToneMap::Agx => constants::TONE_AGX,
                ToneMap::Aces => constants::TONE_ACES,
            },
            inverse_gamma: self.inverse_gamma() as f32,
            padding: 0.0,
        }
    }

    /// The film as pixels of four bytes, red first, alpha not premultiplied, rows from the top.
    pub fn pixels(&self, film: &Film, environment: &Environment, camera: &PerspectiveCamera) -> Vec<[u8; 4]> {
        let [width, height] = film.size().map(|n| n as usize);
        let exposure = self.exposure_scale();
        let map = environment.to_map();
        let light_source =
            Environment { source: lumivox_core::EnvironmentSource::Map(map), ..environment.clone() };
        let quantise = |c: f64| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        let shown = |light: [f64; 3]| {
            self.tone_map.apply(light.map(|c| c * exposure)).map(|c| c.powf(self.inverse_gamma()))
        };
        let [r, g, b] = shown([0.0; 3]).map(quantise);
        let nothing = [r, g, b, 0];
        (0..width * height)
            .into_par_iter()
            .map(|pixel| {
                let coverage = film.alpha(pixel);
                // Most of a picture that is stopped early, or of something small.
                if coverage == 0.0 && self.background == Background::Transparent {
                    return nothing;
                }
                let mut light = film.radiance(pixel);
                let mut alpha = 1.0;
                match self.background {
                    Background::Transparent => {
                        alpha = coverage;
                        light = light.map(|c| if coverage > 0.0 { c / coverage.max(1e-6) } else { 0.0 });
                    }
                    Background::Color(color) => {
                        (0..3).for_each(|i| light[i] += (1.0 - coverage) * color[i]);
                    }
                    Background::Environment => {
                        let at = [pixel % width, pixel / width];
                        let uv = [(at[0] as f64 + 0.5) / width as f64, (at[1] as f64 + 0.5) / height as f64];
                        let ray = camera.ray(uv, width as f64 / height as f64);
                        let behind = light_source.radiance(ray.direction);
                        (0..3).for_each(|i| light[i] += (1.0 - coverage) * behind[i]);
                    }
                }
                let [r, g, b] = shown(light).map(quantise);
                [r, g, b, quantise(alpha)]
            })
            .collect()
    }
}

/// Puts an opaque sRGB colour behind a picture of red, green, blue and straight alpha, 8 bits each. Light adds up, so the
/// blend is linear.
pub fn put_on(rgba: &mut [u8], color: [u8; 3]) {
    let linear: [f64; 256] = std::array::from_fn(|code| linear_from_srgb(code as f64 / 255.0));
    let [red, green, blue] = color;
    rgba.par_chunks_exact_mut(4).with_min_len(1 << 12).for_each(|pixel| {
        let alpha = f64::from(pixel[3]) / 255.0;
        match pixel[3] {
            0 => pixel[..3].copy_from_slice(&[red, green, blue]),
            1..255 => {
                for (channel, behind) in pixel.iter_mut().zip(color) {
                    let light =
                        alpha * linear[usize::from(*channel)] + (1.0 - alpha) * linear[usize::from(behind)];
                    *channel = (srgb_from_linear(light) * 255.0 + 0.5) as u8;
                }
            }
            255 => {}
        }
        pixel[3] = 255;
    });
}

impl ToneMap {
    /// Scene-linear RGB to display values in [0, 1].
    pub fn apply(self, light: [f64; 3]) -> [f64; 3] {
        match self {
            ToneMap::Plain => light.map(|c| srgb_from_linear(c.clamp(0.0, 1.0))),
            ToneMap::Agx => agx(light),
            ToneMap::Aces => light.map(|c| srgb_from_linear(aces(c))),
        }
    }
}

fn agx(light: [f64; 3]) -> [f64; 3] {
    const MIX: f64 = 0.10;
    const UNMIX: f64 = 0.22;
    let mean = light.iter().sum::<f64>() / 3.0;
    let curved = light.map(|c| {
        let mixed = (c + (mean - c) * MIX).max(1e-10);
        agx_curve((((mixed / 0.18).log2() + 10.0) / 16.5).clamp(0.0, 1.0))
    });
    let mean = curved.iter().sum::<f64>() / 3.0;
    curved.map(|c| ((c - UNMIX * mean) / (1.0 - UNMIX)).clamp(0.0, 1.0))
}

fn agx_curve(x: f64) -> f64 {
    const GREY: f64 = 0.4613;
    const SLOPE: f64 = 2.35;
    let d = x - 10.0 / 16.5;
    let (room, power) = if d >= 0.0 { (1.0 - GREY, 2.2) } else { (GREY, 2.6) };
    let linear = SLOPE * d;
    GREY + linear / (1.0 + (linear.abs() / room).powf(power)).powf(1.0 / power)
}

fn aces(c: f64) -> f64 {
    let x = c * 0.6;
    (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tone_maps_rise_from_black_to_white_and_keep_grey_grey() {
        for tone_map in [ToneMap::Plain, ToneMap::Agx, ToneMap::Aces] {
            let curve: Vec<f64> =
                (0..=60).map(|i| tone_map.apply([(f64::from(i) / 3.0 - 14.0).exp2(); 3])[0]).collect();
            assert!(curve.windows(2).all(|w| w[1] >= w[0]), "{tone_map:?}");
            assert!(curve[0] < 0.03 && curve[60] > 0.9, "{tone_map:?}: {} {}", curve[0], curve[60]);
            let [r, g, b] = tone_map.apply([0.18; 3]);
            assert!((r - g).abs() < 1e-12 && (g - b).abs() < 1e-12);
            assert!((0.3..0.6).contains(&r), "{tone_map:?} sends middle grey to {r}");
        }
        let [r, _, b] = ToneMap::Agx.apply([60.0, 3.0, 3.0]);
        assert!(r - b < 0.6, "bright red fades to white");
    }
}
