//! How many samples fit into a frame's budget, learnt from what earlier frames took.

use std::collections::VecDeque;

/// Pixel samples of the first frame, when nothing is known of the GPU.
const FIRST_GUESS: f64 = 65_536.0;

/// Frames whose times may still come.
const MEMORY: usize = 16;

/// The pace of one view.
#[derive(Debug)]
pub struct Pacer {
    /// Pixel samples that fit into a millisecond.
    per_millisecond: Option<f64>,
    /// Frames whose time is not known yet: serial number, pixel samples.
    under_way: VecDeque<(u64, u64)>,
    milliseconds: f64,
}

impl Pacer {
    /// Knows nothing yet.
    pub fn new() -> Self {
        Self { per_millisecond: None, under_way: VecDeque::new(), milliseconds: 0.0 }
    }

    /// Pixel samples that take about so long.
    pub fn budget(&self, milliseconds: f64) -> u64 {
        let samples = self.per_millisecond.map_or(FIRST_GUESS, |pace| pace * milliseconds);
        samples.clamp(1.0, 1e12) as u64
    }

    /// A frame was recorded.
    pub fn recorded(&mut self, serial: u64, pixel_samples: u64) {
        if pixel_samples > 0 {
            self.under_way.push_back((serial, pixel_samples));
            if self.under_way.len() > MEMORY {
                self.under_way.pop_front();
            }
        }
    }

    /// A recorded frame's time is known.
    pub fn measured(&mut self, serial: u64, milliseconds: f64) {
        let Some(at) = self.under_way.iter().position(|(other, _)| *other == serial) else { return };
        let (_, pixel_samples) = self.under_way.drain(..=at).next_back().expect("it was found");
        self.milliseconds = milliseconds;
        let pace = pixel_samples as f64 / milliseconds.max(1e-3);
        // Slower at once, faster bit by bit: a frame too long is seen, one too short is not.
        self.per_millisecond = Some(match self.per_millisecond {
            Some(before) if pace > before => (before + (pace - before) * 0.25).min(before * 4.0),
            _ => pace,
        });
    }

    /// What the last measured frame took.
    pub fn milliseconds(&self) -> f64 {
        self.milliseconds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_budget_settles_at_what_fits() {
        let mut pacer = Pacer::new();
        // A GPU that traces 1000 pixel samples in a millisecond, and tells two frames later.
        let mut times = VecDeque::new();
        for serial in 0..60 {
            let budget = pacer.budget(8.0);
            pacer.recorded(serial, budget);
            times.push_back((serial, budget as f64 / 1000.0));
            if times.len() > 2 {
                let (serial, milliseconds) = times.pop_front().unwrap();
                pacer.measured(serial, milliseconds);
            }
        }
        assert!((7_500..=8_000).contains(&pacer.budget(8.0)), "{}", pacer.budget(8.0));
        pacer.recorded(99, 8_000);
        pacer.measured(99, 80.0);
        assert_eq!(pacer.budget(8.0), 800, "a slower GPU is noticed at once");
        pacer.measured(7, 1.0);
        assert_eq!(pacer.budget(8.0), 800, "times nobody waits for change nothing");
    }
}
