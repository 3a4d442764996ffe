//! What the user sees while waiting: bars on a terminal, a few lines elsewhere, nothing if asked to be quiet.

use std::{
    borrow::Cow,
    io::{self, IsTerminal, Write},
    sync::Mutex,
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use lumivox_core::{Progress, WorkStage};
use lumivox_wgpu::RenderProgress;

/// Seconds between two lines about the same work where there is no terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

/// Work that took less needs no line of its own.
const WORTH_SAYING: Duration = Duration::from_secs(1);

/// Says a line on stderr. Where nobody listens any more, the work goes on: its result is a file.
pub fn say(line: &str) {
    let _ = writeln!(io::stderr(), "{}", without_controls(line));
}

/// A text whose control characters are seen and not obeyed: names of files may hold a terminal's commands.
pub fn without_controls(text: &str) -> Cow<'_, str> {
    let obeyed = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    if !text.contains(obeyed) {
        return Cow::Borrowed(text);
    }
    let seen = |c: char| if obeyed(c) { c.escape_default().to_string() } else { c.to_string() };
    Cow::Owned(text.chars().map(seen).collect())
}

/// Talks to the user on stderr.
#[derive(Clone, Copy, Debug)]
pub struct Reporter {
    quiet: bool,
    bars: bool,
}

impl Reporter {
    /// A reporter that is quiet if asked to.
    pub fn new(quiet: bool) -> Self {
        Self { quiet, bars: !quiet && io::stderr().is_terminal() }
    }

    /// Says a line.
    pub fn say(&self, line: &str) {
        if !self.quiet {
            say(line);
        }
    }

    /// Runs `work` and shows how far it is.
    pub fn stages<T>(&self, work: impl FnOnce(Progress<'_>) -> T) -> T {
        if self.quiet {
            return work(Progress::SILENT);
        }
        let current: Mutex<Option<(WorkStage, Line)>> = Mutex::new(None);
        let result = work(Progress::new(&|stage, done, total| {
            let mut current = current.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            if current.as_ref().is_none_or(|(shown, _)| *shown != stage) {
                if let Some((_, line)) = current.take() {
                    line.finish();
                }
                *current = Some((stage, Line::new(self.bars, stage.label())));
            }
            if let Some((_, line)) = current.as_mut() {
                line.update(done, total, "");
            }
        }));
        if let Some((_, line)) = current.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()) {
            line.finish();
        }
        result
    }

    /// Shows how far the tracing is.
    pub fn tracing(&self) -> TracingLine {
        TracingLine((!self.quiet).then(|| Line::new(self.bars, "tracing light")))
    }
}

/// The line about the tracing; nothing when quiet.
pub struct TracingLine(Option<Line>);

impl TracingLine {
    /// Shows how far it is.
    pub fn update(&mut self, progress: &RenderProgress) {
        let Some(line) = &mut self.0 else { return };
        let mut words = match progress.samples {
            0.0..1.0 => format!("{:.0}% of the first sample", progress.samples * 100.0),
            1.0..1.5 => "1 sample".into(),
            samples => format!("{samples:.0} samples"),
        };
        if let Some(noise) = progress.noise {
            words += &format!(", noise {:.1}%", noise * 100.0);
        }
        // The first pace means little.
        if progress.elapsed > Duration::from_millis(500) {
            words += &format!(", {} left", human_duration(progress.left));
        }
        let (elapsed, left) = (progress.elapsed.as_secs_f64(), progress.left.as_secs_f64());
        line.update((elapsed / (elapsed + left).max(1e-9) * 1000.0) as u64, 1000, &words);
    }

    /// Leaves the last state on screen.
    pub fn finish(self) {
        if let Some(line) = self.0 {
            line.finish();
        }
    }
}

/// `7 s`, `2 min 5 s`, `1 h 3 min`.
pub fn human_duration(duration: Duration) -> String {
    let seconds = duration.as_secs_f64().round() as u64;
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{} min {} s", seconds / 60, seconds % 60),
        _ => format!("{} h {} min", seconds / 3600, seconds / 60 % 60),
    }
}

/// One piece of work: a bar, or lines now and then.
struct Line {
    bar: Option<ProgressBar>,
    label: &'static str,
    start: Instant,
    said: Instant,
    words: String,
}

impl Line {
    fn new(bars: bool, label: &'static str) -> Self {
        let bar = bars.then(|| {
            let style = ProgressStyle::with_template("{prefix:>18} [{bar:36}] {percent:>3}%  {msg}");
            let style = style.expect("a valid template").progress_chars("=> ");
            let bar = ProgressBar::with_draw_target(Some(0), ProgressDrawTarget::stderr_with_hz(10));
            bar.with_style(style).with_prefix(label)
        });
        let now = Instant::now();
        Self { bar, label, start: now, said: now, words: String::new() }
    }

    fn update(&mut self, done: u64, total: u64, words: &str) {
        if self.words != words {
            words.clone_into(&mut self.words);
        }
        if let Some(bar) = &self.bar {
            // Each of these may draw: a length that moves along would make the bar jump.
            if bar.length() != Some(total) {
                bar.set_length(total);
            }
            bar.set_position(done);
            if !words.is_empty() {
                bar.set_message(words.to_owned());
            }
        } else if self.said.elapsed() >= LINE_INTERVAL {
            self.said = Instant::now();
            let percent = done.saturating_mul(100) / total.max(1);
            let gap = if words.is_empty() { "" } else { ", " };
            say(&format!("{}: {percent}%{gap}{words}", self.label));
        }
    }

    fn finish(self) {
        // What was left a moment ago is not worth keeping on screen.
        let words = match self.words.rsplit_once(", ") {
            Some((before, last)) if last.ends_with(" left") => before.to_owned(),
            _ => self.words,
        };
        if let Some(bar) = self.bar {
            bar.set_message(words);
            bar.abandon();
        } else if self.start.elapsed() >= WORTH_SAYING {
            let gap = if words.is_empty() { "" } else { ", " };
            let seconds = self.start.elapsed().as_secs_f64();
            say(&format!("{}: {seconds:.1} s{gap}{words}", self.label));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_terminal_obeys_no_name_of_a_file() {
        assert_eq!(without_controls("a\tb\nc"), "a\tb\nc");
        assert_eq!(without_controls("\u{1b}[31mred\r\u{9b}2J"), "\\u{1b}[31mred\\r\\u{9b}2J");
    }

    #[test]
    fn durations_read_well() {
        let read = |seconds: f64| human_duration(Duration::from_secs_f64(seconds));
        assert_eq!(
            [read(0.2), read(59.4), read(125.0), read(3780.0)],
            ["0 s", "59 s", "2 min 5 s", "1 h 3 min"]
        );
    }
}
