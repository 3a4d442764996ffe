//! Counter-based random numbers: Philox4x32-10.
//!
//! Salmon, Moraes, Dror and Shaw, *Parallel Random Numbers: As Easy as 1, 2, 3*, SC 2011, section 4.2. Every
//! (pixel, sample) owns a stream that cannot overlap another's, so an image does not depend on how its rows are
//! shared among threads.

/// Multipliers of the two halves of a round.
const MULTIPLIERS: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];

/// What a round adds to the key: the golden ratio and sqrt(3) - 1.
const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];

/// Sets this crate's streams apart from another Philox with the same seed: estimates that are compared statistically
/// must not share their noise.
const DOMAIN: u64 = 0x7265_6665_7265_6E63;

/// The Philox4x32-10 block function: 128 random bits of a counter under a key.
pub fn philox4x32_10(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    for _ in 0..10 {
        let [a, b] = [0, 1].map(|i| u64::from(MULTIPLIERS[i]) * u64::from(counter[2 * i]));
        counter = [
            (b >> 32) as u32 ^ counter[1] ^ key[0],
            b as u32,
            (a >> 32) as u32 ^ counter[3] ^ key[1],
            a as u32,
        ];
        key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
    }
    counter
}

/// A stream of uniform numbers.
#[derive(Clone, Debug)]
pub struct Rng {
    key: [u32; 2],
    /// Block, sample, and the two halves of the pixel.
    counter: [u32; 4],
    second: Option<f64>,
}

impl Rng {
    /// The stream of one sample of one pixel.
    pub fn new(seed: u64, pixel: u64, sample: u32) -> Self {
        let key = seed ^ DOMAIN;
        Self {
            key: [key as u32, (key >> 32) as u32],
            counter: [0, sample, pixel as u32, (pixel >> 32) as u32],
            second: None,
        }
    }

    /// The next number, uniform in `[0, 1)` with 53 bits.
    pub fn uniform(&mut self) -> f64 {
        if let Some(second) = self.second.take() {
            return second;
        }
        let [a, b, c, d] = philox4x32_10(self.counter, self.key);
        self.counter[0] = self.counter[0].checked_add(1).expect("a path draws fewer than 2^33 numbers");
        let unit = |high: u32, low: u32| {
            let bits = u64::from(high) << 32 | u64::from(low);
            (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
        };
        self.second = Some(unit(c, d));
        unit(a, b)
    }

    /// The next two numbers.
    pub fn uniform_2d(&mut self) -> [f64; 2] {
        [self.uniform(), self.uniform()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_answers_of_random123() {
        assert_eq!(philox4x32_10([0; 4], [0; 2]), [0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8]);
        assert_eq!(
            philox4x32_10([u32::MAX; 4], [u32::MAX; 2]),
            [0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd]
        );
        assert_eq!(
            philox4x32_10([0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344], [0xa4093822, 0x299f31d0]),
            [0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1]
        );
    }

    #[test]
    fn streams_are_uniform_and_differ() {
        let n = 100_000;
        let mut rng = Rng::new(1, 2, 3);
        let numbers: Vec<f64> = (0..n).map(|_| rng.uniform()).collect();
        assert!(numbers.iter().all(|u| (0.0..1.0).contains(u)));
        let mean = numbers.iter().sum::<f64>() / n as f64;
        let square = numbers.iter().map(|u| u * u).sum::<f64>() / n as f64;
        // Standard errors: sqrt(1/12 / n) and sqrt(4/45 / n), both about 1e-3.
        assert!((mean - 0.5).abs() < 4e-3 && (square - 1.0 / 3.0).abs() < 4e-3);
        let first = |seed, pixel, sample| Rng::new(seed, pixel, sample).uniform();
        assert_ne!(first(1, 2, 3), first(2, 2, 3));
        assert_ne!(first(1, 2, 3), first(1, 3, 3));
        assert_ne!(first(1, 2, 3), first(1, 2, 4));
    }
}
