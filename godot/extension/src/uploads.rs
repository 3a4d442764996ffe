//! How much of the voxels on their way a frame brings.

use std::time::Instant;

use lumivox_renderer::pacing::UploadPacer;

/// An engine that idled has not drawn one long frame.
const MOST_MILLISECONDS: f64 = 500.0;

/// What frames bring of voxels, all viewports together.
#[derive(Default)]
pub struct Uploads {
    pacer: UploadPacer,
    /// The frame, and when it began.
    frame: u64,
    began: Option<Instant>,
    /// Milliseconds of the frame before.
    took: f64,
    /// Bytes that are left of its budget.
    left: u64,
}

impl Uploads {
    /// What is left for this frame. Never nothing: what there is nothing of yet asks for a little of it.
    pub fn budget(&mut self, frame: u64) -> u64 {
        if self.frame != frame {
            self.frame = frame;
            let began = self.began.replace(Instant::now());
            let took = began.map_or(0.0, |began| began.elapsed().as_secs_f64() * 1e3).min(MOST_MILLISECONDS);
            // The shorter of two: a frame that was late for once leaves no room for more.
            let usual = took.min(std::mem::replace(&mut self.took, took));
            self.left = self.pacer.budget(usual);
        }
        self.left.max(1)
    }

    /// Of what was granted, so many bytes were brought, which held the frame up for so long.
    pub fn took(&mut self, bytes: u64, granted: u64, milliseconds: f64) {
        self.pacer.measured(bytes, granted, milliseconds);
        self.left = self.left.saturating_sub(bytes);
    }
}
