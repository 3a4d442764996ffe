//! A film forgets a part of its samples, for light has changed a little.

use lumivox_shaders::{Kernel, layout};

use super::{FramePass, Use, dispatch};
use crate::live::images::FilmImages;
use crate::recording::Recording;

/// Keeps a part of a film.
#[derive(Clone, Copy, Debug)]
pub struct FadePass {
    /// The film.
    pub film: FilmImages,
    /// The part of its samples that a pixel keeps, 0 to 1; of its samples one remains.
    pub kept: f64,
    /// How many times as bright light is as when they were traced.
    pub scale: f64,
}

impl FramePass for FadePass {
    fn name(&self) -> &'static str {
        "fade"
    }

    fn uses(&self) -> Vec<Use> {
        self.film.sums().map(Use::change).collect()
    }

    fn record(&self, recording: &mut Recording) {
        let params = layout::FilmFadeParams {
            film_size: self.film.size,
            kept: self.kept as f32,
            scale: self.scale as f32,
            guides: u32::from(self.film.guides),
            ..Default::default()
        };
        dispatch(Kernel::FilmFade, &params, vec![self.film.buffer], self.film.size, recording);
    }
}
