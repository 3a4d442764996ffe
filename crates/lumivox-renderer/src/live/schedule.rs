//! What a live view traces in a frame: so many samples of which film, in which rows. Numbers alone: nothing here knows a
//! GPU, and what is planned here is taken for done.

use lumivox_shaders::constants::FINE_ALONE;

use super::film::{GROUP_ROWS, padded_height};
use super::images::{Grain, pixels};

/// Pixels along a side of the fine film that share one of the coarse film, at most.
const COARSEST: u32 = 8;

/// Samples that a pixel gets at once where the host's depth changed.
const FIRST_AID: u32 = 4;

/// Samples of a coarse pixel that are worth halving its film's resolution for.
const LEAST_COARSE_SAMPLES: u32 = 2;

/// Frames whose samples are remembered when light changes.
const REMEMBERED_FRAMES: f64 = 16.0;

/// Samples that a pixel remembers where the budget brings few: fewer, and the coarse film takes over, which is blurred.
const LEAST_REMEMBERED: f64 = 10.0;

/// A first fine image that is done in so many frames needs no better coarse one until then.
const SOON_FRAMES: f64 = 4.0;

/// The share of the budget after which the coarse film gets no more in a frame.
const COARSE_SHARE: f64 = 0.9;

/// Samples that a coarse pixel gets at most while the first fine image takes longer, before a finer film follows. They
/// are a quarter of a fine pass.
fn most_coarse_samples(factor: u32) -> u32 {
    (factor * factor / 4).max(LEAST_COARSE_SAMPLES)
}

/// Something to do to films.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Work {
    /// So many samples for each pixel that has fewer than `below`: those that started over. Others only look, and return.
    FirstAid { film: Grain, samples: u32, below: u32 },
    /// So many more for each pixel of some rows, `limit` at most in all.
    Samples { film: Grain, samples: u32, limit: u32, rows: [u32; 2] },
    /// So many for all of the coarse film at once.
    AllCoarse { samples: u32 },
    /// The finer film takes the coarse one's place.
    Replace,
}

/// A frame's work, and about how many pixel samples that is.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Plan {
    pub works: Vec<Work>,
    pub pixel_samples: u64,
}

/// How far the films of one image are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Schedule {
    /// Pixels of the fine film.
    size: [u32; 2],
    /// Samples that one invocation traces in one dispatch at most.
    most_samples: u32,
    /// Samples of a pixel after which the image is done.
    target: u32,
    /// Fine pixels along a side of a coarse one; 1 while no coarse film is shown, or one that is as fine.
    factor: u32,
    /// The coarse film is what the fine one was before this image, and of its grain.
    is_held: bool,
    /// What the samples of the fine film count that has forgotten a part of them, about.
    faded: Option<f64>,
    /// Samples that every pixel of the coarse film has, and the next row that gets one more.
    coarse_complete: u32,
    coarse_row: u32,
    /// The next row of the finer film while it is filled.
    finer_row: Option<u32>,
    /// Samples that every pixel of the fine film has.
    complete: u32,
    /// Samples that every pixel has that never started over.
    common: u32,
    pass_samples: u32,
    /// In the order in which rows are traced, see [`padded_height`].
    next_row: u32,
    /// Whether every pixel of the fine film has had a sample since the film was empty.
    covered: bool,
    /// Some pixel started over while a pass was under way: when the pass ends, no count of samples holds for all.
    restarted_in_pass: bool,
    /// Pixels that lack samples, as far as is known: what a pass costs.
    open_pixels: u64,
}

impl Schedule {
    /// An empty image of so many pixels.
    pub fn new(size: [u32; 2], most_samples: u32, target: u32) -> Self {
        Self {
            size,
            most_samples,
            target,
            factor: 1,
            is_held: false,
            faded: None,
            coarse_complete: 0,
            coarse_row: 0,
            finer_row: None,
            complete: 0,
            common: 0,
            pass_samples: 0,
            next_row: 0,
            covered: false,
            restarted_in_pass: false,
            open_pixels: pixels(size),
        }
    }

    /// An empty image after this one, as coarse as the budget demands. Where it `follows` another that was shown, one that
    /// is less coarse has to be well affordable, or the picture's grain would jump to and fro.
    pub fn restarted(&self, size: [u32; 2], budget: u64, follows: bool) -> Self {
        let new = Self::new(size, self.most_samples, self.target);
        let shown = Self { factor: self.factor, ..new };
        Self { factor: shown.affordable_factor(budget, follows), ..new }
    }

    /// An empty image after this one, in whose place something else is shown.
    pub fn restarted_alone(&self, size: [u32; 2]) -> Self {
        Self::new(size, self.most_samples, self.target)
    }

    /// How coarse a film is that the budget buys at once.
    fn affordable_factor(&self, budget: u64, follows: bool) -> u32 {
        let cost =
            |factor: u32| pixels(self.size.map(|n| n.div_ceil(factor))) * u64::from(LEAST_COARSE_SAMPLES);
        let reserve = |factor: u32| if follows && factor < self.factor { 2 } else { 1 };
        let mut factor = 1;
        while factor < COARSEST && cost(factor) * reserve(factor) > budget {
            factor *= 2;
        }
        factor
    }

    /// An empty image of the same size, before which this one stays to be seen in the place of a coarse one.
    pub fn restarted_behind(&self) -> Self {
        let held = Self::new(self.size, self.most_samples, self.target);
        Self { is_held: true, coarse_complete: 1, ..held }
    }

    /// Of a part that the films may keep, the one that leaves no more samples than a few frames of the budget bring: a light that
    /// is dimmed is to be seen so at once, however long the image was traced before.
    pub fn kept_of_frames(&self, kept: f64, budget: u64) -> f64 {
        let most = (REMEMBERED_FRAMES * budget as f64 / pixels(self.size) as f64).max(LEAST_REMEMBERED);
        let samples = self.faded.unwrap_or(self.complete.into());
        kept.min(most / samples.max(most))
    }

    /// The films keep a part of their samples. Returns the pixels of a coarse film that is to begin then: one that takes so
    /// many samples that it helps the fine one, which has few.
    pub fn fade(&mut self, kept: f64, budget: u64) -> Option<[u32; 2]> {
        // As `film_fade` has it: whoever has any keeps one.
        let left = (self.faded.unwrap_or(self.complete.into()) * kept).max(self.complete.min(1).into());
        self.faded = Some(left);
        self.complete = left as u32;
        self.common = self.common.min(1);
        self.coarse_complete = self.coarse_complete.min(1);
        self.open_pixels = pixels(self.size);
        // What was held is of a light that is gone, and gets no samples of today's.
        self.is_held &= !self.covered;
        if self.has_coarse() || self.complete >= FINE_ALONE {
            return None;
        }
        self.factor = self.affordable_factor(budget, false);
        (self.coarse_complete, self.coarse_row) = (0, 0);
        self.coarse_size()
    }

    /// The coarse film's part of a frame after that.
    pub fn follow(&mut self, budget: u64) -> Plan {
        let Some(size) = self.coarse_size().filter(|_| self.factor > 1) else { return Plan::default() };
        let samples = if self.coarse_complete == 0 { LEAST_COARSE_SAMPLES } else { 1 };
        let pixel_samples = pixels(size) * u64::from(samples);
        if pixel_samples > budget {
            return Plan::default();
        }
        self.coarse_complete = self.coarse_complete.max(1);
        Plan { works: vec![Work::AllCoarse { samples }], pixel_samples }
    }

    /// Changes how many samples are enough.
    pub fn set_target(&mut self, target: u32) {
        if target > self.target {
            // However few of them were open.
            self.open_pixels = pixels(self.size);
        }
        self.target = target;
    }

    /// Whether a film is shown before the fine one, or shows through.
    pub fn has_coarse(&self) -> bool {
        self.factor > 1 || self.is_held
    }

    /// Whether that is what the fine film was before this image.
    pub fn is_held(&self) -> bool {
        self.is_held
    }

    /// Pixels of the coarse film, while there is one.
    pub fn coarse_size(&self) -> Option<[u32; 2]> {
        self.has_coarse().then(|| self.size.map(|n| n.div_ceil(self.factor)))
    }

    /// Pixels of a film of half the coarse one's grain, if it is time to begin one: the coarse one has enough samples, and
    /// the fine one is far.
    pub fn finer_to_begin(&self, budget: u64) -> Option<[u32; 2]> {
        let has_enough = self.coarse_complete >= most_coarse_samples(self.factor);
        let begins = self.factor > 2 && self.finer_row.is_none() && has_enough && self.fine_is_far(budget);
        begins.then(|| self.finer_size())
    }

    /// It is there, and empty.
    pub fn begin_finer(&mut self) {
        self.finer_row = Some(0);
    }

    fn finer_size(&self) -> [u32; 2] {
        self.size.map(|n| n.div_ceil(self.factor / 2))
    }

    /// Whether a finer film is being filled.
    pub fn fills_finer(&self) -> bool {
        self.finer_row.is_some()
    }

    /// Fine pixels along a side of a coarse one; 1 while no coarse film is shown, or one that is as fine.
    pub fn factor(&self) -> u32 {
        self.factor
    }

    /// Samples that every pixel of the fine film has.
    pub fn complete(&self) -> u32 {
        self.complete.min(self.target)
    }

    /// The part of the samples that is traced of pixels that never started over, 0 to 1.
    pub fn progress(&self) -> f32 {
        let of_pass = self.next_row as f32 / padded_height(self.size) as f32;
        let traced = self.common as f32 + self.pass_samples as f32 * of_pass;
        if self.is_done() { 1.0 } else { (traced / self.target.max(1) as f32).min(0.99) }
    }

    /// Whether every pixel has its samples, as far as is known.
    pub fn is_done(&self) -> bool {
        self.complete >= self.target
    }

    /// Samples of a pass over the fine film.
    pub fn pass_samples(&self) -> u32 {
        self.pass_samples.max(1)
    }

    /// Whether every pixel of the fine film has had a sample since the film was empty.
    pub fn is_covered(&self) -> bool {
        self.covered
    }

    /// Not while it has holes: bands of sharp rows would wander through the coarse picture.
    pub fn shows_fine(&self) -> bool {
        self.covered || !self.has_coarse()
    }

    /// There is no coarse film any more.
    pub fn drop_coarse(&mut self) {
        (self.factor, self.is_held, self.finer_row) = (1, false, None);
    }

    /// The fine film is as good as the coarse one can make it: a finished picture must not depend on what was shown
    /// before it. Where more samples may follow those of the target, it shows through until there are many.
    pub fn retire_coarse(&mut self, more_may_follow: bool) {
        let enough = if more_may_follow { FINE_ALONE } else { FINE_ALONE.min(self.target) };
        if self.complete >= enough {
            (self.factor, self.is_held) = (1, false);
        }
    }

    /// The host's depth changed in so many pixels: no count of samples holds for all any more.
    pub fn start_over(&mut self, count: u64) {
        // Only those cost anything from here on, unless others are still missing.
        let open = if self.is_done() { 0 } else { self.open_pixels };
        self.open_pixels = (open + count).min(pixels(self.size));
        if self.next_row == 0 {
            self.complete = 0;
        } else {
            self.restarted_in_pass = true;
        }
    }

    /// All of the coarse film, as often as the budget allows: the answer to a change, in its frame.
    pub fn answer(&mut self, budget: u64) -> Plan {
        let Some(size) = self.coarse_size() else { return Plan::default() };
        let area = pixels(size);
        let samples = (budget / area).clamp(1, u64::from(self.most_samples)) as u32;
        (self.coarse_complete, self.coarse_row) = (samples, 0);
        Plan { works: vec![Work::AllCoarse { samples }], pixel_samples: area * u64::from(samples) }
    }

    /// Rows of the fine film, as many as the budget allows; before, more of the coarse one while it is all that is shown,
    /// and the fine one far.
    pub fn refine(&mut self, budget: u64) -> Plan {
        let mut works = vec![];
        let mut planned = 0.0;
        // What started over in this very frame must not be a hole in the picture.
        let samples = FIRST_AID.min(self.target);
        if self.covered {
            works.push(Work::FirstAid { film: Grain::Fine, samples, below: self.common });
        }
        if self.has_coarse() {
            // It is all that is shown, or shows through.
            works.push(Work::FirstAid { film: Grain::Coarse, samples, below: self.coarse_complete.max(1) });
            // All of the budget, but for what buys no whole group of rows.
            while self.fine_is_far(budget) && planned < COARSE_SHARE * budget as f64 {
                match self.more_coarse(budget - planned as u64, &mut works) {
                    0 => break,
                    more => planned += more as f64,
                }
            }
        }
        planned = self.more_fine(budget as f64, planned, &mut works);
        Plan { works, pixel_samples: planned.round() as u64 }
    }

    /// More rows of the fine film until so much is planned; returns what is.
    fn more_fine(&mut self, budget: f64, mut planned: f64, works: &mut Vec<Work>) -> f64 {
        let height = padded_height(self.size);
        let row = self.open_pixels_per_row();
        while !self.is_done() {
            let affordable = budget - planned;
            if self.next_row == 0 {
                let left = self.target - self.complete;
                let passes = (affordable / (row * f64::from(height))) as u64;
                self.pass_samples = passes.clamp(1, u64::from(left.min(self.most_samples))) as u32;
            }
            let rows = (affordable / (row * f64::from(self.pass_samples))) as u32;
            let rows = (rows / GROUP_ROWS * GROUP_ROWS).min(height - self.next_row);
            if rows == 0 && planned > 0.0 {
                break;
            }
            // A group is the least that is done, however small the budget: it makes progress.
            let rows = rows.max(GROUP_ROWS);
            works.push(Work::Samples {
                film: Grain::Fine,
                samples: self.pass_samples,
                limit: self.target,
                rows: [self.next_row, self.next_row + rows],
            });
            planned += row * f64::from(rows) * f64::from(self.pass_samples);
            self.next_row += rows;
            if self.next_row == height {
                self.end_pass();
            }
            if planned >= budget {
                break;
            }
        }
        planned
    }

    fn end_pass(&mut self) {
        self.next_row = 0;
        self.covered = true;
        self.finer_row = None;
        self.common = if self.faded.is_some() { 1 } else { self.common + self.pass_samples };
        self.complete = if self.restarted_in_pass { 0 } else { self.complete + self.pass_samples };
        self.faded = self.faded.map(|left| left + f64::from(self.pass_samples));
        self.restarted_in_pass = false;
    }

    /// Pixels that lack samples in a row of the fine film, about: those where none are missing cost next to nothing.
    fn open_pixels_per_row(&self) -> f64 {
        self.open_pixels.clamp(1, pixels(self.size)) as f64 / f64::from(padded_height(self.size))
    }

    /// Whether the first fine image takes so long that the coarse one is to get better until then.
    fn fine_is_far(&self, budget: u64) -> bool {
        let rows_left = padded_height(self.size) - self.next_row;
        self.factor > 1
            && !self.covered
            && self.open_pixels_per_row() * f64::from(rows_left) > SOON_FRAMES * budget as f64
    }

    /// More samples for the coarse film while it is all that is shown; returns how many.
    fn more_coarse(&mut self, budget: u64, works: &mut Vec<Work>) -> u64 {
        let Some(size) = self.coarse_size() else { return 0 };
        let limit = most_coarse_samples(self.factor);
        if self.coarse_complete >= limit {
            return self.more_finer(budget, works);
        }
        let (rows, pixel_samples) = affordable_rows(size, 1, self.coarse_row, budget);
        works.push(Work::Samples {
            film: Grain::Coarse,
            samples: 1,
            limit,
            rows: [self.coarse_row, self.coarse_row + rows],
        });
        self.coarse_row += rows;
        if self.coarse_row == padded_height(size) {
            (self.coarse_row, self.coarse_complete) = (0, self.coarse_complete + 1);
        }
        pixel_samples
    }

    /// Rows of the film that follows the coarse one, which it replaces with its last; returns how many samples.
    fn more_finer(&mut self, budget: u64, works: &mut Vec<Work>) -> u64 {
        let Some(begin) = self.finer_row else { return 0 };
        let (film, samples, size) = (Grain::Finer, LEAST_COARSE_SAMPLES, self.finer_size());
        let (rows, pixel_samples) = affordable_rows(size, samples, begin, budget);
        let (end, height) = (begin + rows, padded_height(size));
        works.push(Work::Samples { film, samples, limit: samples, rows: [begin, end] });
        self.finer_row = Some(end).filter(|&end| end < height);
        if self.finer_row.is_none() {
            // What started over on the way is no hole.
            works.push(Work::Samples { film, samples, limit: samples, rows: [0, height] });
            works.push(Work::Replace);
            self.factor /= 2;
            (self.coarse_complete, self.coarse_row) = (samples, 0);
        }
        pixel_samples
    }
}

/// Rows of a film from `begin` on that a budget buys so many samples for, a group at least; and what they cost.
fn affordable_rows(size: [u32; 2], samples: u32, begin: u32, budget: u64) -> (u32, u64) {
    let height = padded_height(size);
    let row = (pixels(size) * u64::from(samples)) as f64 / f64::from(height);
    let rows = (budget as f64 / row) as u32 / GROUP_ROWS * GROUP_ROWS;
    let rows = rows.clamp(GROUP_ROWS, height - begin);
    (rows, (row * f64::from(rows)) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [640, 361];
    const AREA: u64 = 640 * 361;
    const TARGET: u32 = 24;

    /// Samples of each row of the films, as works leave them.
    struct Films {
        schedule: Schedule,
        fine: Vec<u32>,
        coarse: Vec<u32>,
        finer: Vec<u32>,
    }

    impl Films {
        fn new(budget: u64) -> Self {
            let schedule = Schedule::new(SIZE, 64, TARGET).restarted(SIZE, budget, false);
            let rows = |size: Option<[u32; 2]>| vec![0; size.map_or(0, |size| padded_height(size) as usize)];
            Self { fine: rows(Some(SIZE)), coarse: rows(schedule.coarse_size()), finer: vec![], schedule }
        }

        /// One frame; returns the pixel samples that it said and that its works add up to.
        fn frame(&mut self, budget: u64, answers: bool) -> [u64; 2] {
            if let Some(size) = self.schedule.finer_to_begin(budget).filter(|_| !answers) {
                self.finer = vec![0; padded_height(size) as usize];
                self.schedule.begin_finer();
            }
            let plan = if answers { self.schedule.answer(budget) } else { self.schedule.refine(budget) };
            let mut traced = 0;
            for work in plan.works {
                match work {
                    Work::FirstAid { .. } => {}
                    Work::AllCoarse { samples } => {
                        self.coarse.fill(samples);
                        let size = self.schedule.coarse_size().unwrap();
                        traced += pixels(size) * u64::from(samples);
                    }
                    Work::Replace => self.coarse = std::mem::take(&mut self.finer),
                    Work::Samples { film, samples, limit, rows: [begin, end] } => {
                        let rows = match film {
                            Grain::Fine => &mut self.fine,
                            Grain::Coarse => &mut self.coarse,
                            Grain::Finer => &mut self.finer,
                            Grain::Points => panic!("no plan is for points"),
                        };
                        let width = u64::from(SIZE[0]) * rows.len() as u64 / u64::from(padded_height(SIZE));
                        for row in &mut rows[begin as usize..end as usize] {
                            let more = samples.min(limit - (*row).min(limit));
                            *row += more;
                            traced += u64::from(more) * width;
                        }
                    }
                }
            }
            [plan.pixel_samples, traced]
        }
    }

    #[test]
    fn every_row_gets_every_sample_once_within_the_budget() {
        for budget in [1000, AREA / 100, AREA / 10, AREA / 3, AREA, 7 * AREA, 1000 * AREA] {
            let mut films = Films::new(budget);
            let mut answers = films.schedule.coarse_size().is_some();
            for frame in 0.. {
                let [said, traced] = films.frame(budget, answers);
                answers = false;
                let least = AREA * u64::from(GROUP_ROWS) / u64::from(SIZE[1]);
                assert!(said <= budget.max(AREA / 64) + 2 * least, "{said} of {budget} in frame {frame}");
                // About: of a film's last group of rows not all are there.
                assert!(traced <= said + said / 10 + least, "{traced} where {said} are said");
                if films.schedule.is_done() {
                    break;
                }
                assert!(frame < 100_000, "it makes no progress with {budget}");
            }
            assert!(films.fine.iter().all(|&samples| samples == TARGET), "budget {budget}");
        }
    }

    #[test]
    fn a_change_is_answered_by_a_film_that_the_budget_buys() {
        let answer = |budget| {
            let mut films = Films::new(budget);
            let coarse = films.schedule.coarse_size().is_some();
            (films.schedule.factor(), films.frame(budget, coarse)[0])
        };
        assert_eq!(answer(2 * AREA).0, 1, "a fine image at once");
        for (budget, factor) in [(AREA / 2 + 2000, 2), (AREA / 8 + 2000, 4), (AREA / 32 + 2000, 8), (10, 8)] {
            let (chosen, samples) = answer(budget);
            assert_eq!(chosen, factor, "budget {budget}");
            assert!(samples <= budget.max(AREA / 64 + 2000), "{samples} of {budget}");
        }
    }

    #[test]
    fn the_grain_does_not_jump_to_and_fro() {
        let at = AREA / 8 + 2000;
        let schedule = Schedule::new(SIZE, 64, TARGET).restarted(SIZE, at, false);
        let after = |budget| schedule.restarted(SIZE, budget, true).factor();
        assert_eq!((schedule.factor(), after(at)), (4, 4));
        assert_eq!(after(at * 4), 4, "barely affordable");
        assert_eq!(after(at * 8), 2);
        assert_eq!(after(at / 2), 8, "coarser at once");
    }

    #[test]
    fn pixels_that_start_over_are_waited_for() {
        let mut films = Films::new(10 * AREA);
        films.frame(10 * AREA, false);
        while !films.schedule.is_done() {
            films.frame(10 * AREA, false);
        }
        films.schedule.start_over(100);
        assert_eq!(films.schedule.complete(), 0);
        // All rows are looked at, for as much as a hundred pixels cost.
        let plan = films.schedule.refine(100 * u64::from(TARGET));
        assert!(films.schedule.is_done(), "{plan:?}");
        assert!(plan.pixel_samples <= 101 * u64::from(TARGET));

        // In the midst of a pass: the counts hold again after the next one.
        let mut films = Films::new(10 * AREA);
        films.frame(AREA / 2, false);
        films.schedule.start_over(1);
        films.frame(AREA, false);
        assert_eq!(films.schedule.complete(), 0);
    }
}
