//! How much of the voxels on their way a frame brings.

use lumivox_core::host::Moment;

use crate::pacing::UploadPacer;

/// A window in the background, drawn once a second, does not draw long frames.
const MOST_MILLISECONDS: f64 = 500.0;

/// Less is not worth what any upload takes.
const LEAST_BYTES: u64 = 256 << 10;

/// What frames bring of voxels, all viewports together.
#[derive(Debug, Default)]
pub struct Uploads {
    pacer: UploadPacer,
    /// The last frame that was asked about, and when.
    frame: u64,
    began: Option<Moment>,
    /// Milliseconds of the frame before it; 0 where they are not known.
    took: f64,
    /// Bytes that are left of its budget.
    left: u64,
}

impl Uploads {
    /// What is left for this frame. Never nothing: what there is nothing of yet asks for a little of it.
    pub fn budget(&mut self, frame: u64) -> u64 {
        if self.frame != frame {
            // Nothing was on its way in the frames between, and the engine may have idled.
            let follows = frame == self.frame + 1;
            self.frame = frame;
            let began = self.began.replace(Moment::now()).filter(|_| follows);
            let took = began.map_or(0.0, |began| began.elapsed().as_secs_f64() * 1e3).min(MOST_MILLISECONDS);
            // The shorter of two: a frame that was late for once leaves no room for more.
            let usual = took.min(std::mem::replace(&mut self.took, took));
            self.left = self.pacer.budget(usual);
        }
        self.left.max(1)
    }

    /// Whether next to nothing is left for this frame.
    pub fn is_used_up(&self, frame: u64) -> bool {
        self.frame == frame && self.left < LEAST_BYTES
    }

    /// Of what was granted, so many bytes were brought, which held the frame up for so long.
    pub fn took(&mut self, bytes: u64, granted: u64, milliseconds: f64) {
        self.pacer.measured(bytes, granted, milliseconds);
        self.left = self.left.saturating_sub(bytes);
    }
}

#[cfg(test)]
mod tests {
    use std::thread::sleep;
    use std::time::Duration;

    use super::*;

    /// Budgets of frames that are asked about after so many milliseconds each.
    fn budgets(frames: [u64; 4], milliseconds: u64) -> [u64; 4] {
        let mut uploads = Uploads::default();
        frames.map(|frame| {
            sleep(Duration::from_millis(milliseconds));
            uploads.budget(frame)
        })
    }

    #[test]
    fn only_frames_that_follow_each_other_are_long() {
        let [first, _, _, last] = budgets([1, 2, 3, 4], 90);
        assert!(last > 2 * first, "{first} to {last}");
        let apart = budgets([1, 31, 61, 91], 90);
        assert_eq!(apart, [first; 4], "between them, none was asked about");
    }
}
