//! How many samples fit into a frame where the driver tells no times: as many as leave the frame rate alone.
//!
//! The time from frame to frame bounds what the GPU did in it, but is mostly something else: the engine's own work, and
//! the wait for the screen. So nothing is learnt of the cost of samples. The budget grows while frames come as soon as they
//! do without tracing, and shrinks when they come later by more than tracing may take; what was too much is remembered
//! for a while, or a screen's beat would be missed every few frames.

use super::{LEAST_BUDGET, Pass};

/// Growth from frame to frame while nothing speaks against it.
const GROWTH: f64 = 1.06;

/// Least that is left of a budget that was too much.
const LEAST_LEFT: f64 = 0.25;

/// Share of a budget that was too much up to which it grows again.
const SAFE_SHARE: f64 = 0.75;

/// Frames for which that holds.
const CAREFUL_FRAMES: u32 = 600;

/// Frames until a budget shows in the time between frames: those that are queued.
const LATENCY: u32 = 3;

/// Milliseconds that a frame is believed to take without tracing, until it is seen to do.
const MOST_REST: f64 = 20.0;

/// Weight of a time in the mean of those without tracing.
const REST_WEIGHT: f64 = 0.1;

/// The time between a view's frames, and what follows from it.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameRate {
    /// Milliseconds from one frame to the next: the last two, since one that is late tells of anything.
    intervals: [Option<f64>; 2],
    /// The same without tracing.
    rest: Option<f64>,
    /// What the last frames traced, and since how many.
    traced: Option<(Pass, u32)>,
    /// Frames that are not to be judged: the budget has just shrunk.
    unsettled: u32,
    paces: [Pace; 2],
}

#[derive(Clone, Copy, Debug, Default)]
struct Pace {
    /// A budget that was too much, and for how many frames it is remembered.
    too_much: Option<(f64, u32)>,
}

impl FrameRate {
    /// A frame begins so long after the one before, and did not idle in between.
    pub fn interval(&mut self, milliseconds: f64) {
        self.intervals = [self.intervals[1], Some(milliseconds)];
    }

    /// The budget for the next frame after one of `budget`, which traced that much of it or next to nothing.
    pub fn next(&mut self, pass: Pass, budget: f64, was_used: bool, target: f64) -> f64 {
        let [Some(before), Some(last)] = self.intervals else { return budget };
        let interval = before.min(last);
        let rest = self.rest.get_or_insert(interval.min(MOST_REST));
        if interval < *rest {
            *rest = interval;
        } else if !was_used || budget <= LEAST_BUDGET {
            // It is not tracing that takes this time, or there is no less of it; what was blamed on it was something else.
            if interval - *rest > target {
                self.paces = Default::default();
            }
            *rest += (interval - *rest) * REST_WEIGHT;
        }
        let excess = interval - *rest;
        if !was_used {
            self.traced = None;
            return budget;
        }
        let since = match self.traced {
            Some((traced, since)) if traced == pass => since + 1,
            _ => 0,
        };
        self.traced = Some((pass, since));
        let pace = &mut self.paces[pass as usize];
        pace.too_much =
            pace.too_much.filter(|&(_, frames)| frames > 0).map(|(most, frames)| (most, frames - 1));
        if self.unsettled > 0 {
            self.unsettled -= 1;
            return budget;
        }
        if since < LATENCY {
            return budget;
        }
        if excess > target {
            pace.too_much = Some((budget, CAREFUL_FRAMES));
            self.unsettled = LATENCY;
            return (budget * (target / excess).max(LEAST_LEFT)).max(LEAST_BUDGET);
        }
        // At the least it is not tracing: what a frame takes without any has to be known before there is more.
        let little = if budget <= LEAST_BUDGET { target / 10.0 } else { target / 2.0 };
        if excess < little {
            let most = pace.too_much.map_or(f64::INFINITY, |(budget, _)| budget * SAFE_SHARE);
            return (budget * GROWTH).min(most).max(budget.min(most));
        }
        budget
    }
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use super::*;
    use crate::pacing::Pacer;

    const TARGET: f64 = 8.0;

    /// A GPU and a screen that are not there; of its times the driver says 0, or nothing.
    struct Blind {
        pacer: Pacer,
        /// Milliseconds of a pixel sample, of the engine's own work, and between two beats of the screen, if it waits.
        cost: f64,
        engine: f64,
        beat: Option<f64>,
        says_zero: bool,
        /// Pixel samples that there are to trace in a frame.
        most: u64,
        /// What frames take that are queued.
        queue: VecDeque<f64>,
        serial: u64,
    }

    impl Blind {
        fn new(cost: f64, engine: f64, beat: Option<f64>) -> Self {
            Self {
                pacer: Pacer::new(),
                cost,
                engine,
                beat,
                says_zero: true,
                most: u64::MAX,
                queue: VecDeque::from([engine; 2]),
                serial: 0,
            }
        }

        /// Milliseconds that a frame's tracing takes, and until the next begins.
        fn frame(&mut self, pass: Pass) -> (f64, f64) {
            let budget = self.pacer.budget(pass, TARGET);
            let samples = budget.min(self.most);
            let traces = samples as f64 * self.cost;
            self.serial += 1;
            self.pacer.recorded(self.serial, pass, samples, budget, TARGET);
            self.queue.push_back(self.engine + traces);
            let busy = self.queue.pop_front().unwrap();
            let interval = self.beat.map_or(busy, |beat| (busy / beat).ceil() * beat);
            self.pacer.interval(interval);
            if self.says_zero && self.serial > 2 {
                self.pacer.measured(self.serial - 2, 0.0);
            }
            (traces, interval)
        }

        fn run(&mut self, frames: usize) -> Vec<(f64, f64)> {
            (0..frames).map(|_| self.frame(Pass::Still)).collect()
        }
    }

    fn mean(list: impl Iterator<Item = f64>) -> f64 {
        let list: Vec<f64> = list.collect();
        list.iter().sum::<f64>() / list.len() as f64
    }

    #[test]
    fn tracing_takes_about_its_time_where_nothing_waits_for_a_screen() {
        for (cost, says_zero) in [(1e-6, true), (1e-5, true), (1e-4, true), (1e-5, false)] {
            let mut gpu = Blind { says_zero, ..Blind::new(cost, 4.0, None) };
            gpu.run(200);
            let frames = gpu.run(400);
            let traces = mean(frames.iter().map(|f| f.0));
            let longest = frames.iter().map(|f| f.0).fold(0.0, f64::max);
            assert!(traces > 0.3 * TARGET && traces < 1.25 * TARGET, "{traces} ms at {cost} a sample");
            assert!(longest < 1.75 * TARGET, "{longest} ms at {cost} a sample");
        }
    }

    #[test]
    fn a_screens_beat_is_neither_taken_for_tracing_nor_missed() {
        let beat = 1000.0 / 60.0;
        for cost in [1e-6, 1e-5, 1e-4] {
            let mut gpu = Blind::new(cost, 4.0, Some(beat));
            gpu.run(300);
            let frames = gpu.run(2000);
            let traces = mean(frames.iter().map(|f| f.0));
            let missed = frames.iter().filter(|f| f.1 > 1.5 * beat).count();
            assert!(traces > 0.4 * TARGET, "{traces} ms at {cost} a sample");
            assert!(missed * 50 < frames.len(), "{missed} of {} beats are missed", frames.len());
        }
    }

    #[test]
    fn a_gpu_that_is_too_slow_gets_the_least() {
        for beat in [None, Some(1000.0 / 60.0)] {
            let mut gpu = Blind::new(0.02, 4.0, beat);
            gpu.run(60);
            // The least takes 82 ms. Of more a screen's beat says nothing before it is missed.
            let traces = mean(gpu.run(1000).into_iter().map(|f| f.0));
            assert!(traces < 1.25 * 0.02 * LEAST_BUDGET, "{traces} ms");
        }
    }

    #[test]
    fn a_cost_that_grows_tenfold_is_noticed() {
        let mut gpu = Blind::new(1e-5, 4.0, None);
        gpu.run(200);
        gpu.cost *= 10.0;
        gpu.run(40);
        let longest = gpu.run(200).into_iter().map(|f| f.0).fold(0.0, f64::max);
        assert!(longest < 1.75 * TARGET, "{longest} ms");
    }

    #[test]
    fn an_engine_that_gets_slow_by_itself_is_not_mistaken_for_ever() {
        let mut gpu = Blind::new(1e-5, 4.0, None);
        gpu.run(200);
        gpu.engine = 50.0;
        gpu.run(400);
        let traces = mean(gpu.run(200).iter().map(|f| f.0));
        assert!(traces > 0.3 * TARGET && traces < 1.25 * TARGET, "{traces} ms");
    }

    #[test]
    fn frames_with_nothing_to_trace_buy_no_more() {
        let mut gpu = Blind::new(1e-5, 4.0, None);
        gpu.run(200);
        let before = gpu.pacer.budget(Pass::Still, TARGET);
        gpu.most = 0;
        gpu.run(1000);
        assert_eq!(gpu.pacer.budget(Pass::Still, TARGET), before);
    }
}
