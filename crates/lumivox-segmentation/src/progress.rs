//! Progress that only ever rises, whichever thread reports.

use std::sync::Mutex;

use lumivox_core::{Progress, Stage};

/// Parts that a whole segmentation is reported in.
const PARTS: u64 = 1000;

/// What was reported so far.
pub struct Steps<'a> {
    progress: Progress<'a>,
    done: Mutex<u64>,
}

impl<'a> Steps<'a> {
    pub fn new(progress: Progress<'a>) -> Self {
        Self { progress, done: Mutex::new(0) }
    }

    /// Reports that `part` of the work between the fractions `from` and `to` of the whole is done.
    pub fn report(&self, from: f64, to: f64, part: f64) {
        let now = ((from + (to - from) * part.clamp(0.0, 1.0)) * PARTS as f64) as u64;
        let mut done = self.done.lock().expect("no report panics halfway");
        if now > *done {
            *done = now;
            self.progress.report(Stage::Segmenting, now, PARTS);
        }
    }
}
