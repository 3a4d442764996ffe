//! Progress that only ever rises, whichever thread reports.

use std::sync::Mutex;

use lumivox_core::{Progress, WorkStage};

/// Parts that the whole is reported in.
const PARTS: u64 = 1000;

/// What was reported so far.
pub struct Steps<'a> {
    progress: Progress<'a>,
    done: Mutex<u64>,
    /// The share of the whole that the steps are.
    share: f64,
}

impl<'a> Steps<'a> {
    /// Steps that are all there is to do.
    pub fn new(progress: Progress<'a>) -> Self {
        Self::first(progress, 1.0)
    }

    /// Steps that are the first `share` of what there is to do.
    pub fn first(progress: Progress<'a>, share: f64) -> Self {
        Self { progress, done: Mutex::new(0), share }
    }

    /// Reports that `part` of the steps between the fractions `from` and `to` is done.
    pub fn report(&self, from: f64, to: f64, part: f64) {
        self.report_whole(self.share * (from + (to - from) * part.clamp(0.0, 1.0)));
    }

    /// Reports that `part` of what follows the steps is done.
    pub fn report_rest(&self, part: f64) {
        self.report_whole(self.share + (1.0 - self.share) * part.clamp(0.0, 1.0));
    }

    fn report_whole(&self, part: f64) {
        let now = (part * PARTS as f64) as u64;
        let mut done = self.done.lock().expect("no report panics halfway");
        if now > *done {
            *done = now;
            self.progress.report(WorkStage::Segmenting, now, PARTS);
        }
    }
}
