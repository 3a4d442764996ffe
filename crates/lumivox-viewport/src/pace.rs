//! How much of a frame's time goes into tracing: little while something moves, more once it rests.

use std::time::Duration;

/// After so much time without a change nobody is turning anything.
const AT_REST: Duration = Duration::from_millis(300);

/// Milliseconds of the GPU's time for a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// While something moves.
    pub moving: f64,
    /// While nothing does: every frame costs the host its own share, too, so that fewer and longer ones are done sooner.
    pub resting: f64,
    /// Pixels of the film at most; what is shown has all of the view's. Of more a processor would not answer in time.
    pub most_pixels: u32,
}

impl Pace {
    /// Of a device that computes in software or not. A processor that traces has to draw the interface, too.
    pub fn of(software: bool) -> Self {
        if software {
            Self { moving: 40.0, resting: 200.0, most_pixels: 1 << 16 }
        } else {
            Self { moving: 10.0, resting: 25.0, most_pixels: u32::MAX }
        }
    }

    /// Pixels of the film per pixel of the view along a side.
    pub fn resolution_scale(&self, [width, height]: [u32; 2]) -> f64 {
        let pixels = f64::from(width) * f64::from(height);
        (f64::from(self.most_pixels) / pixels.max(1.0)).sqrt().min(1.0)
    }

    /// So long after the last change.
    pub fn milliseconds(&self, since_change: Duration) -> f64 {
        if since_change < AT_REST { self.moving } else { self.resting }
    }
}
