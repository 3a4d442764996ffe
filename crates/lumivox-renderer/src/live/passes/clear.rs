//! A film begins: no pixel has a sample, and no ray ends.

use super::{FramePass, Use};
use crate::live::images::FilmImages;
use crate::recording::{Recording, Step};

/// Empties a film.
#[derive(Clone, Copy, Debug)]
pub struct ClearPass {
    /// The film.
    pub film: FilmImages,
}

impl FramePass for ClearPass {
    fn name(&self) -> &'static str {
        "clear"
    }

    fn uses(&self) -> Vec<Use> {
        self.film.all().map(Use::make).collect()
    }

    fn record(&self, recording: &mut Recording) {
        recording.push(Step::ClearBuffer { id: self.film.buffer });
    }
}
