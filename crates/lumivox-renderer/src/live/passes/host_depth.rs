//! The host's depth to the ends of primary rays. Pixels where it changed start over, and only those.

use lumivox_shaders::{Kernel, layout};

use super::{FramePass, Use, dispatch};
use crate::live::HostDepth;
use crate::live::images::FilmImages;
use crate::recording::{Recording, ResourceId, Step};

/// Ends the primary rays of films at the host's surfaces.
#[derive(Clone, Debug)]
pub struct HostDepthPass {
    /// What the host has drawn.
    pub depth: HostDepth,
    /// No surface counts whose view depth is larger.
    pub farthest: f64,
    /// The films.
    pub films: Vec<FilmImages>,
    /// A buffer of 16 bytes. Its first four come back, if anybody asks: the number of pixels that started over.
    pub restarts: ResourceId,
    /// Whether they do.
    pub is_asked: bool,
}

impl FramePass for HostDepthPass {
    fn name(&self) -> &'static str {
        "host depth"
    }

    fn uses(&self) -> Vec<Use> {
        self.films.iter().flat_map(FilmImages::all).map(Use::change).collect()
    }

    fn record(&self, recording: &mut Recording) {
        recording.push(Step::ClearBuffer { id: self.restarts });
        for film in &self.films {
            let params = layout::HostDepthParams {
                view_depth_from_ndc: self.depth.view_depth_from_ndc.map(|x| x as f32),
                film_size: film.size,
                clear: self.depth.clear as f32,
                jittered: u32::from(self.depth.jittered),
                farthest: self.farthest as f32,
                guides: u32::from(film.guides),
                ..Default::default()
            };
            let resources = vec![self.depth.texture, film.buffer, self.restarts];
            dispatch(Kernel::HostDepth, &params, resources, film.size, recording);
        }
        if self.is_asked {
            recording.push(Step::ReadBuffer { id: self.restarts, range: 0..4 });
        }
    }
}
