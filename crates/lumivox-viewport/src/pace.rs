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
}

impl Pace {
    /// Of a device that computes in software or not. A processor that traces has to draw the interface, too.
    pub fn of(software: bool) -> Self {
        if software { Self { moving: 40.0, resting: 120.0 } } else { Self { moving: 10.0, resting: 25.0 } }
    }

    /// So long after the last change.
    pub fn milliseconds(&self, since_change: Duration) -> f64 {
        if since_change < AT_REST { self.moving } else { self.resting }
    }
}
