//! An image on its way to the host.

use super::{FramePass, Use};
use crate::live::images::Image;
use crate::recording::Recording;

/// Brings an image back.
#[derive(Clone, Copy, Debug)]
pub struct ReadPass {
    /// Which one.
    pub image: Image,
}

impl FramePass for ReadPass {
    fn name(&self) -> &'static str {
        "read"
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::read(self.image)]
    }

    fn record(&self, recording: &mut Recording) {
        self.image.record_read(recording);
    }
}
