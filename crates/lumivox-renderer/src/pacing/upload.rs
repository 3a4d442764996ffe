//! How many bytes of voxels a frame can bring without being late.

/// Milliseconds that a frame may take longer for what arrives.
const MILLISECONDS: f64 = 1.5;

/// Part of a frame that they may be where frames take long.
const SHARE: f64 = 0.05;

/// Bytes of a frame at least: voxels have to come, and no machine takes long for so few.
const LEAST: f64 = (1 << 20) as f64;

/// And at most.
const MOST: f64 = (64 << 20) as f64;

/// By how much an upload grows that took less time than it may.
const GROWTH: f64 = 1.25;

/// Learns how much a host uploads in the time that there is, and says how much fits into a frame.
///
/// What an upload takes besides its bytes is not known, so that it is no rate that is learnt, but the size that fits.
#[derive(Clone, Copy, Debug)]
pub struct UploadPacer {
    bytes: f64,
}

impl Default for UploadPacer {
    fn default() -> Self {
        Self { bytes: 2.0 * LEAST }
    }
}

impl UploadPacer {
    /// Nothing is known yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Bytes for a frame where the last ones took so many milliseconds each; 0 if that is not known.
    pub fn budget(&self, frame_milliseconds: f64) -> u64 {
        (self.bytes * (SHARE * frame_milliseconds / MILLISECONDS).max(1.0)) as u64
    }

    /// An upload of so many bytes, of those that were granted, held the frame up for so long.
    pub fn measured(&mut self, bytes: u64, granted: u64, milliseconds: f64) {
        // Less than was granted tells nothing of more, nor does a part of what fits.
        let is_part = (granted as f64) < 0.5 * self.bytes;
        if bytes == 0
            || bytes < granted / 2
            || is_part
            || granted as f64 > 1.5 * self.bytes
            || milliseconds.is_nan()
        {
            return;
        }
        let factor = (MILLISECONDS / milliseconds.max(1e-3)).clamp(0.5, GROWTH);
        self.bytes = (self.bytes * factor).clamp(LEAST, MOST);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_upload_gets_the_size_that_fits() {
        let mut pacer = UploadPacer::new();
        let first = pacer.budget(16.0);
        // Half a millisecond for anything, and 4 MiB in another.
        let took = |bytes: u64| 0.5 + bytes as f64 / (4 << 20) as f64;
        for _ in 0..40 {
            let budget = pacer.budget(16.0);
            pacer.measured(budget, budget, took(budget));
        }
        let settled = pacer.budget(16.0);
        assert!(settled > first && (1.2..1.9).contains(&took(settled)), "{settled} take {}", took(settled));
        pacer.measured(100, settled, 1e-3);
        pacer.measured(72_000, 1, 0.1);
        pacer.measured(0, 0, f64::NAN);
        assert_eq!(pacer.budget(16.0), settled, "that tells nothing");
        assert!(pacer.budget(300.0) >= 9 * settled, "a long frame has room for more");
        for _ in 0..20 {
            pacer.measured(pacer.budget(16.0), pacer.budget(16.0), 1000.0);
        }
        assert_eq!(pacer.budget(16.0), 1 << 20, "something has to come");
    }
}
