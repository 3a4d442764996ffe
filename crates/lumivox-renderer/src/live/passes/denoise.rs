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
    /// Whether a pixel of the film is many times as large as one of the finest. Those that outshine their neighbours are
    /// held back then.
    pub is_coarse: bool,
}

impl FramePass for DenoisePass {
    fn name(&self) -> &'static str {
        "denoise"
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::read(self.film.film()), Use::read(self.film.ray_limits()), Use::make(self.denoised)]
    }

    fn record(&self, recording: &mut Recording) {
        let size = self.film.size;
        let steps = if self.is_coarse { COARSE_STEPS } else { STEPS };
        // The last round writes what is shown.
        let [mut from, mut to] = match steps.len() % 2 {
            0 => [self.denoised.buffer, self.spare],
            _ => [self.spare, self.denoised.buffer],
        };
        let params =
            |step| layout::DenoiseParams { film_size: size, step, bounded: u32::from(self.is_coarse) };
        dispatch(Kernel::DenoisePrepare, &params(0), vec![self.film.buffer, from], size, recording);
        for &step in steps {
            dispatch(Kernel::DenoiseWavelet, &params(step), vec![from, to], size, recording);
            std::mem::swap(&mut from, &mut to);
        }
    }
}
