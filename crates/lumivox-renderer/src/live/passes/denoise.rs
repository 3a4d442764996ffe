//! What is shown of a film that is noisy: biased, and never what the film sums up.

use lumivox_shaders::{Kernel, layout};

use super::{FramePass, Use, dispatch};
use crate::live::images::{FilmImages, Image};
use crate::recording::{Recording, ResourceId};

/// Pixels between the taps of the wavelet's rounds.
const STEPS: &[u32] = &[1, 2, 4, 8];

/// Those of a coarse film: its pixels are many times as large, and it would blend a head with what is behind it.
const COARSE_STEPS: &[u32] = &[1];

/// Filters noise out of a film.
#[derive(Clone, Copy, Debug)]
pub struct DenoisePass {
    /// The film.
    pub film: FilmImages,
    /// What is made of it.
    pub denoised: Image,
    /// A buffer as large as that, for what is in between.
    pub spare: ResourceId,
    /// A picture of kept light, of which it is known that it has no noise: what the film shows more than that is filtered.
    pub kept_light: Option<Image>,
    /// Whether a pixel of the film is many times as large as one of the finest. Those that outshine their neighbours are
    /// held back then.
    pub is_coarse: bool,
}

impl FramePass for DenoisePass {
    fn name(&self) -> &'static str {
        "denoise"
    }

    fn uses(&self) -> Vec<Use> {
        let film = [self.film.film(), self.film.ray_limits()].into_iter();
        film.chain(self.kept_light).map(Use::read).chain([Use::make(self.denoised)]).collect()
    }

    fn record(&self, recording: &mut Recording) {
        let size = self.film.size;
        let steps = if self.is_coarse { COARSE_STEPS } else { STEPS };
        // The last round writes what is shown.
        let [mut from, mut to] = match steps.len() % 2 {
            0 => [self.denoised.buffer, self.spare],
            _ => [self.spare, self.denoised.buffer],
        };
        let params = |step| layout::DenoiseParams {
            film_size: size,
            step,
            bounded: u32::from(self.is_coarse),
            kept_light: u32::from(self.kept_light.is_some()),
            ..Default::default()
        };
        let kept_light = self.kept_light.map_or(self.film.buffer, |image| image.buffer);
        let resources = vec![self.film.buffer, from, kept_light];
        dispatch(Kernel::DenoisePrepare, &params(0), resources, size, recording);
        for &step in steps {
            dispatch(Kernel::DenoiseWavelet, &params(step), vec![from, to], size, recording);
            std::mem::swap(&mut from, &mut to);
        }
    }
}
