//! What a film really holds: hosts compare it with what they asked for.

use super::{FramePass, Use};
use crate::live::images::{FilmImages, pixels};
use crate::recording::{Recording, ResourceId};
use crate::unfinished;

/// Counts the samples of a film. A [`FilmCount`](crate::FilmCount) comes back.
#[derive(Clone, Copy, Debug)]
pub struct CountPass {
    /// The film.
    pub film: FilmImages,
    /// Samples that every pixel should have.
    pub samples: u32,
    /// A buffer as large as a [`FilmCount`](crate::FilmCount).
    pub count: ResourceId,
}

impl FramePass for CountPass {
    fn name(&self) -> &'static str {
        "count"
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::read(self.film.film())]
    }

    fn record(&self, recording: &mut Recording) {
        unfinished::record_count(
            self.count,
            self.film.buffer,
            pixels(self.film.size),
            self.samples,
            recording,
        );
    }
}
