//! When an image is done by its noise: films are looked at now and then, and traced on until they are as clean as asked for.

use crate::film::Film;

/// Samples before which the noise of a pixel is not known: what shines rarely has not shone yet.
const FIRST: u32 = 16;

/// How many times as many samples the next look comes after, at most: what is foreseen of few is not believed further.
const MOST_GROWTH: f64 = 4.0;

/// Samples beyond those that should do, as a part: looks cost time, too.
const SPARE: f64 = 1.05;

/// The end of an image by its noise, and where its looks are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseEnd {
    /// What [`Film::noise`] is to say; 0: the image ends by its samples alone.
    target: f64,
    /// Samples that are traced before the next look.
    stage: u32,
    /// A look is on its way.
    is_looking: bool,
    /// So many looks on their way are of another image.
    outdated: u32,
    is_reached: bool,
}

impl Default for NoiseEnd {
    fn default() -> Self {
        Self { target: 0.0, stage: FIRST, is_looking: false, outdated: 0, is_reached: false }
    }
}

impl NoiseEnd {
    /// An image that ends where [`Film::noise`] says `target`.
    pub fn at(target: f64) -> Self {
        let mut end = Self::default();
        end.set_target(target);
        end
    }

    /// Changes what is clean enough.
    pub fn set_target(&mut self, target: f64) {
        let target = if target.is_finite() { target.max(0.0) } else { 0.0 };
        if target != self.target {
            self.target = target;
            self.restart();
        }
    }

    /// The image begins.
    pub fn restart(&mut self) {
        let outdated = self.outdated + u32::from(self.is_looking);
        *self = Self { target: self.target, outdated, ..Self::default() };
    }

    /// Samples to trace by what is known now, of `most`.
    pub fn samples(&self, most: u32) -> u32 {
        if self.target > 0.0 { self.stage.min(most) } else { most }
    }

    /// Whether more samples may follow those, of `most`.
    pub fn is_open(&self, most: u32) -> bool {
        self.target > 0.0 && !self.is_reached && self.stage < most
    }

    /// Whether the film, which has its samples, is to be looked at; the look is taken for under way then.
    pub fn begin_look(&mut self, most: u32) -> bool {
        let begins = self.is_open(most) && !self.is_looking;
        self.is_looking |= begins;
        begins
    }

    /// A read-back is lost, perhaps a look.
    pub fn lost(&mut self) {
        self.outdated += u32::from(std::mem::take(&mut self.is_looking));
    }

    /// Takes a look. Where it is not clean enough, as many more samples follow as should make it so.
    pub fn look(&mut self, film: &Film) {
        let is_looking = std::mem::take(&mut self.is_looking);
        if self.outdated > 0 {
            self.outdated -= 1;
            return;
        }
        if !is_looking {
            return;
        }
        let samples = film.min_samples().max(1);
        // Where nothing is seen there is no noise.
        let noise = film.noise().unwrap_or(0.0);
        self.is_reached = noise <= self.target;
        if !self.is_reached {
            let growth = (SPARE * (noise / self.target).powi(2)).min(MOST_GROWTH);
            let wanted = (f64::from(samples) * growth).ceil() as u32;
            self.stage = wanted.max(self.stage + (self.stage / 8).max(1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A film of one pixel, whose samples are `1 - spread` and `1 + spread` by turns.
    fn film(samples: u32, spread: f32) -> Film {
        let n = samples as f32;
        let squares = n * (1.0 + spread * spread);
        Film::from_planes(1, 1, vec![vec![[n, n, n, n]], vec![[1.0, squares, n, 0.0]]]).unwrap()
    }

    #[test]
    fn it_goes_on_until_the_film_is_clean() {
        let mut end = NoiseEnd::default();
        assert_eq!((end.samples(512), end.is_open(512), end.begin_look(512)), (512, false, false));
        end.set_target(0.05);
        assert_eq!((end.samples(512), end.samples(8), end.is_open(512)), (FIRST, 8, true));
        assert!(end.begin_look(512) && !end.begin_look(512), "one at a time");
        // 0.25 of noise after 16 samples are 0.05 after 400, of which it goes a part of the way first.
        end.look(&film(16, 1.0));
        assert_eq!(end.samples(512), 64);
        assert!(end.begin_look(512));
        end.look(&film(64, 1.0));
        assert_eq!((end.samples(512), end.is_open(256)), (256, false));
        assert!(end.begin_look(512));
        end.look(&film(256, 1.0));
        assert!((400..450).contains(&end.samples(512)), "{end:?}");
        assert!(end.begin_look(512));
        end.look(&film(end.samples(512), 1.0));
        assert!(!end.is_open(512) && end.samples(512) < 450, "{end:?}");
        // What is cleaner at once ends at once; nothing has no noise.
        for shown in [film(16, 0.01), film(16, 0.0), Film::new(3, 2, false)] {
            end.restart();
            assert!(end.begin_look(512));
            end.look(&shown);
            assert_eq!((end.samples(512), end.is_open(512)), (FIRST, false));
        }
    }

    #[test]
    fn looks_at_another_image_and_lost_ones_decide_nothing() {
        let mut end = NoiseEnd::default();
        end.set_target(0.05);
        assert!(end.begin_look(512));
        end.restart();
        assert!(end.begin_look(512));
        end.look(&film(16, 0.0));
        assert!(end.is_open(512), "that was the image before");
        assert!(end.begin_look(512));
        end.lost();
        assert!(end.begin_look(512), "another is asked for");
        // Whichever of them came, one after it decides.
        for _ in 0..2 {
            end.look(&film(16, 0.0));
            end.begin_look(512);
        }
        assert!(!end.is_open(512));
    }
}
