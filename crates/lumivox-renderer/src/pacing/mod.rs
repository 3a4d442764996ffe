//! How many samples fit into a frame's budget, learnt from what earlier frames took.
//!
//! A GPU tells frames later what a frame took, its times are noisy, and what a sample costs may change by a factor of
//! ten from one frame to the next. So the pace follows the cost per sample, which does not depend on how many were
//! asked for, rather than the time, which does and would make it swing.
//!
//! Some drivers tell no times (Godot's Metal says 0): there the frame rate has to do (`frame_rate.rs`).
//!
//! Voxels that arrive have a pace of their own ([`UploadPacer`]).
//!
//! A host asks [`Pacer::budget`] before it records a frame, tells what was recorded, and what it took once it knows.

mod frame_rate;
mod upload;

use std::collections::VecDeque;

use self::frame_rate::FrameRate;
pub use self::upload::UploadPacer;

/// Pixel samples of the first frame, when nothing is known of the GPU.
const FIRST_BUDGET: f64 = 32_768.0;

/// Pixel samples that are asked for however slow the GPU is: an image has to get done.
const LEAST_BUDGET: f64 = 4096.0;

/// Most that a budget grows from one measured frame to the next.
const GROWTH: f64 = 1.5;

/// Frames with a smaller share of what was granted tell nothing of the cost of samples.
const TELLING_SHARE: f64 = 0.25;

/// Weight of a new cost in the mean, if it is above: a frame too long is seen.
const WEIGHT_OF_MORE: f64 = 0.4;

/// And if it is below: one too short is not seen, and after the empty rows of an image come others.
const WEIGHT_OF_LESS: f64 = 0.1;

/// A cost so many times the mean is no noise: the mean jumps.
const JUMP: f64 = 2.5;

/// What a budget is divided by after a change, until a frame tells what samples cost since.
const CAUTION: f64 = 3.0;

/// By how much caution lessens with a change that made nothing dearer: what is animated changes with every frame.
const TRUST: f64 = 0.7;

/// By how much it grows with a frame before which nothing changed.
const DISTRUST: f64 = 1.05;

/// Fewer samples cost more each. A cost that is not above so many times the mean is none that a change made.
const NO_DEARER: f64 = 1.5;

/// Frames whose times may still come.
const MEMORY: usize = 16;

/// What a frame traces; samples of one kind tell little of what the other's cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// A new image, coarse if need be.
    Moving,
    /// More samples of the image before.
    Still,
}

/// The pace of one view.
#[derive(Debug)]
pub struct Pacer {
    paces: [Pace; 2],
    /// Changes so far.
    changes: u64,
    caution: f64,
    /// Frames whose time is not known yet.
    under_way: VecDeque<Frame>,
    milliseconds: f64,
    frame_rate: FrameRate,
    /// Whether times are missing, and the frame rate decides.
    blind: bool,
}

/// What is known of one kind of pass.
#[derive(Clone, Copy, Debug)]
struct Pace {
    /// Pixel samples that are granted at most.
    budget: f64,
    /// Milliseconds that a pixel sample takes.
    cost: Option<f64>,
    /// Changes before the frames that told so.
    changes: u64,
}

#[derive(Clone, Copy, Debug)]
struct Frame {
    serial: u64,
    pass: Pass,
    changes: u64,
    pixel_samples: u64,
    granted: f64,
    target: f64,
}

impl Default for Pacer {
    fn default() -> Self {
        Self::new()
    }
}

impl Pacer {
    /// Knows nothing yet.
    pub fn new() -> Self {
        Self {
            paces: [Pace { budget: FIRST_BUDGET, cost: None, changes: 0 }; 2],
            changes: 0,
            caution: CAUTION,
            under_way: VecDeque::new(),
            milliseconds: 0.0,
            frame_rate: FrameRate::default(),
            blind: false,
        }
    }

    /// What is traced from now on is not what it was: its samples may cost more, and the GPU tells frames later.
    pub fn changed(&mut self) {
        self.changes += 1;
    }

    /// What is traced from now on has nothing to do with what was.
    pub fn distrust(&mut self) {
        self.caution = CAUTION;
    }

    /// Pixel samples that take about so long.
    pub fn budget(&self, pass: Pass, milliseconds: f64) -> u64 {
        let [pace, other] = match pass {
            Pass::Moving => self.paces,
            Pass::Still => [self.paces[1], self.paces[0]],
        };
        let budget = match (pace.cost, other.cost) {
            _ if self.blind => pace.budget,
            (Some(cost), _) => pace.budget.min(milliseconds / cost),
            // Better than nothing, but to be taken with care.
            (None, Some(cost)) => other.budget.min(milliseconds / cost) / 2.0,
            (None, None) => pace.budget,
        };
        let told = match (pace.cost, other.cost) {
            (Some(_), _) => pace.changes,
            (None, Some(_)) => other.changes,
            (None, None) => self.changes,
        };
        let is_known = self.blind || told == self.changes;
        let budget = if is_known { budget } else { budget / self.caution };
        budget.clamp(LEAST_BUDGET, 1e12) as u64
    }

    /// So much time has passed since the frame before began, in which the engine drew as fast as it could.
    pub fn interval(&mut self, milliseconds: f64) {
        self.frame_rate.interval(milliseconds);
    }

    /// A frame was recorded that traces `pixel_samples` where `budget` was what [`Pacer::budget`] said for
    /// `milliseconds`.
    pub fn recorded(&mut self, serial: u64, pass: Pass, pixel_samples: u64, budget: u64, milliseconds: f64) {
        let granted = budget as f64;
        self.under_way.push_back(Frame {
            serial,
            pass,
            changes: self.changes,
            pixel_samples,
            granted,
            target: milliseconds,
        });
        if self.under_way.len() > MEMORY {
            self.under_way.pop_front();
            self.blind = true;
        }
        if self.blind {
            let was_used = tells(pixel_samples, granted);
            let pace = &mut self.paces[pass as usize];
            pace.budget = self.frame_rate.next(pass, pace.budget, was_used, milliseconds);
        }
    }

    /// A recorded frame's time is known; 0 says that it is not.
    pub fn measured(&mut self, serial: u64, milliseconds: f64) {
        let Some(at) = self.under_way.iter().position(|frame| frame.serial == serial) else { return };
        let frame = self.under_way.drain(..=at).next_back().expect("it was found");
        self.milliseconds = milliseconds;
        if !tells(frame.pixel_samples, frame.granted) {
            return;
        }
        self.blind = milliseconds <= 0.0;
        if self.blind {
            return;
        }
        let samples = frame.pixel_samples as f64;
        let cost = milliseconds.max(1e-3) / samples;
        let pace = &mut self.paces[frame.pass as usize];
        let after_change = frame.changes > pace.changes;
        pace.changes = frame.changes.max(pace.changes);
        if let Some(mean) = pace.cost {
            let dearer = if cost > mean * NO_DEARER { cost / mean } else { 1.0 };
            let caution = self.caution * if after_change { TRUST } else { DISTRUST };
            self.caution = if after_change { caution.max(dearer) } else { caution }.clamp(1.0, CAUTION);
        }
        let mean = match pace.cost {
            Some(mean) if cost > mean * if after_change { NO_DEARER } else { JUMP } => cost,
            Some(mean) if cost > mean => mean + (cost - mean) * WEIGHT_OF_MORE,
            Some(mean) => mean + (cost - mean) * WEIGHT_OF_LESS,
            None => cost,
        };
        pace.cost = Some(mean);
        // What was granted may have been more: the first frame of this kind went by the pace of the other.
        let most = pace.budget.max(frame.granted) * GROWTH;
        pace.budget = (frame.target / mean).min(most).max(LEAST_BUDGET);
    }

    /// What tracing took in the last frame that was measured; 0 where the driver does not tell.
    pub fn milliseconds(&self) -> f64 {
        self.milliseconds
    }
}

/// Whether a frame traced so much of what it was granted that its time says something of the cost.
fn tells(pixel_samples: u64, granted: f64) -> bool {
    pixel_samples as f64 >= (granted * TELLING_SHARE).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames after which a GPU tells what one took.
    const LATENCY: usize = 3;

    const TARGET: f64 = 8.0;

    /// A GPU that is not there.
    struct Gpu {
        pacer: Pacer,
        /// Milliseconds of a pixel sample, and of a frame whatever it traces.
        cost: f64,
        overhead: f64,
        /// Pixel samples that it cannot do less of at once.
        row: u64,
        times: VecDeque<(u64, f64)>,
        serial: u64,
        random: u32,
    }

    impl Gpu {
        fn new(cost: f64) -> Self {
            let times = VecDeque::new();
            Self { pacer: Pacer::new(), cost, overhead: 0.3, row: 1280, times, serial: 0, random: 1 }
        }

        /// -1 to 1.
        fn noise(&mut self) -> f64 {
            self.random = self.random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(self.random >> 8) / f64::from(1 << 23) - 1.0
        }

        /// One frame: what it was granted and what it took.
        fn frame(&mut self, pass: Pass) -> (u64, f64) {
            let budget = self.pacer.budget(pass, TARGET);
            let samples = budget.next_multiple_of(self.row);
            let took = (samples as f64 * self.cost + self.overhead) * (1.0 + 0.35 * self.noise());
            self.serial += 1;
            self.pacer.recorded(self.serial, pass, samples, budget, TARGET);
            self.times.push_back((self.serial, took));
            if self.times.len() > LATENCY {
                let (serial, milliseconds) = self.times.pop_front().unwrap();
                self.pacer.measured(serial, milliseconds);
            }
            (budget, took)
        }

        /// The mean time of so many frames, and the longest.
        fn run(&mut self, frames: usize) -> (f64, f64) {
            let times: Vec<f64> = (0..frames).map(|_| self.frame(Pass::Still).1).collect();
            (times.iter().sum::<f64>() / frames as f64, times.iter().copied().fold(0.0, f64::max))
        }
    }

    fn assert_settled((mean, longest): (f64, f64)) {
        assert!((mean - TARGET).abs() < TARGET / 4.0, "{mean} ms on average");
        assert!(longest < TARGET * 1.75, "{longest} ms");
    }

    #[test]
    fn noisy_times_that_come_late_keep_to_the_budget() {
        // From a hundredth of what the first guess suits to a hundred times as much.
        for cost in [2.5e-6, 2.5e-5, 2.5e-4, 1e-3] {
            let mut gpu = Gpu::new(cost);
            gpu.run(60);
            assert_settled(gpu.run(400));
        }
    }

    #[test]
    fn a_cost_that_changes_tenfold_is_followed_without_a_runaway() {
        let mut gpu = Gpu::new(5e-5);
        gpu.run(60);
        gpu.cost *= 10.0;
        // Nobody can know before the first slow frame is measured.
        gpu.run(LATENCY + 1);
        let (_, longest) = gpu.run(20);
        assert!(longest < TARGET * 1.75, "{longest} ms after it was known");
        assert_settled(gpu.run(200));
        gpu.cost /= 10.0;
        let (_, longest) = gpu.run(40);
        assert!(longest < TARGET * 1.75, "{longest} ms on the way up");
        assert_settled(gpu.run(200));
    }

    #[test]
    fn after_a_change_no_frame_is_late() {
        for (pass, dearer) in [(Pass::Moving, 2.0), (Pass::Still, 2.5)] {
            let mut gpu = Gpu::new(5e-5);
            for _ in 0..60 {
                gpu.frame(pass);
            }
            gpu.cost *= dearer;
            gpu.pacer.changed();
            let longest = (0..20).map(|_| gpu.frame(pass).1).fold(0.0, f64::max);
            assert!(longest < TARGET * 1.4, "{longest} ms");
            let mean = (0..100).map(|_| gpu.frame(pass).1).sum::<f64>() / 100.0;
            assert!((mean - TARGET).abs() < TARGET / 4.0, "{mean} ms on average");
        }
    }

    #[test]
    fn what_changes_with_every_frame_is_trusted_in_time() {
        let mut gpu = Gpu::new(5e-5);
        for _ in 0..60 {
            gpu.frame(Pass::Moving);
        }
        let frame = |gpu: &mut Gpu| {
            gpu.pacer.changed();
            gpu.frame(Pass::Moving).1
        };
        let cautious = (0..3).map(|_| frame(&mut gpu)).fold(0.0, f64::max);
        assert!(cautious < TARGET / 2.0, "{cautious} ms at first");
        for _ in 0..60 {
            frame(&mut gpu);
        }
        let mean = (0..200).map(|_| frame(&mut gpu)).sum::<f64>() / 200.0;
        assert!((mean - TARGET).abs() < TARGET / 4.0, "{mean} ms on average");
    }

    #[test]
    fn rows_where_there_is_nothing_do_not_lead_astray() {
        let mut gpu = Gpu::new(0.0);
        let (mut traced, mut times) = (0, vec![]);
        for _ in 0..600 {
            // A third of the rows, in the midst of the image, take twenty times as long as the others.
            let row = traced / gpu.row % 720;
            gpu.cost = if (240..480).contains(&row) { 1e-4 } else { 5e-6 };
            let (budget, took) = gpu.frame(Pass::Still);
            traced += budget;
            times.push(took);
        }
        times.drain(..100);
        let mean = times.iter().sum::<f64>() / times.len() as f64;
        let long = times.iter().filter(|&&took| took > 2.0 * TARGET).count();
        assert!(mean < TARGET * 1.25, "{mean} ms on average");
        assert!(long * 10 < times.len(), "{long} of {} frames are twice too long", times.len());
    }

    #[test]
    fn budgets_grow_by_half_at_most() {
        let mut gpu = Gpu::new(1e-7);
        let mut before = FIRST_BUDGET as u64;
        assert_eq!(gpu.pacer.budget(Pass::Still, TARGET), before);
        for _ in 0..40 {
            let (budget, _) = gpu.frame(Pass::Still);
            assert!(budget as f64 <= before as f64 * GROWTH + 1.0, "{before} to {budget}");
            before = budget;
        }
        assert!(before > 10_000_000);
    }

    #[test]
    fn a_gpu_that_is_too_slow_still_makes_progress() {
        let mut gpu = Gpu::new(1.0);
        gpu.run(20);
        assert_eq!(gpu.frame(Pass::Still).0, LEAST_BUDGET as u64);
    }

    #[test]
    fn frames_with_next_to_nothing_to_do_tell_nothing() {
        let mut gpu = Gpu::new(1e-4);
        gpu.run(60);
        let before = gpu.pacer.budget(Pass::Still, TARGET);
        gpu.pacer.recorded(1000, Pass::Still, 10, before, TARGET);
        gpu.pacer.measured(1000, 5.0);
        assert_eq!(gpu.pacer.budget(Pass::Still, TARGET), before);
        assert_eq!(gpu.pacer.milliseconds(), 5.0);
        gpu.pacer.measured(7, 100.0);
        assert_eq!(gpu.pacer.milliseconds(), 5.0, "nobody waits for this one");
    }

    #[test]
    fn the_first_rest_goes_on_at_the_pace_of_the_movement() {
        let mut gpu = Gpu::new(1e-6);
        for _ in 0..60 {
            gpu.frame(Pass::Moving);
        }
        let (first, _) = gpu.frame(Pass::Still);
        assert!(first > 50 * FIRST_BUDGET as u64, "{first} after a minute of movement");
        for _ in 0..10 {
            let (granted, _) = gpu.frame(Pass::Still);
            assert!(granted as f64 > 0.7 * first as f64, "{granted} after {first}");
        }
    }

    #[test]
    fn each_kind_of_pass_has_its_own_pace() {
        let mut gpu = Gpu::new(1e-4);
        gpu.run(60);
        let (still, first) = (gpu.pacer.budget(Pass::Still, TARGET), gpu.pacer.budget(Pass::Moving, TARGET));
        assert!(first <= still / 2 + 1, "a first guess is made with care");
        // The last times of the other kind come in.
        for _ in 0..LATENCY {
            gpu.frame(Pass::Moving);
        }
        let still = gpu.pacer.budget(Pass::Still, TARGET);
        gpu.cost *= 4.0;
        for _ in 0..60 {
            gpu.frame(Pass::Moving);
        }
        assert!(gpu.pacer.budget(Pass::Moving, TARGET) < still / 3);
        assert_eq!(gpu.pacer.budget(Pass::Still, TARGET), still);
        assert!(gpu.pacer.budget(Pass::Still, TARGET / 2.0) <= still / 2 + 1, "a lower budget holds at once");
    }
}
