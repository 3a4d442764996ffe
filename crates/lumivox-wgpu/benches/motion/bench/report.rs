//! What was measured, as text, CSV and JSON.

use std::fmt::Write;
use std::path::Path;

use lumivox_core::Preset;
use lumivox_testing::motion::{lag, percentile};
use serde_json::{Value, json};

use super::films::{Body, Motion};
use super::judge::{BLURS, Judged};
use super::options::{Cost, Options, Variant};

/// The part of a film in which a frame is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// While it moves; frames from 0.
    Moving,
    /// After it stopped; frames from 1.
    Rest,
    /// After the cut that follows; frames from 0.
    Cut,
}

impl Phase {
    fn name(self) -> &'static str {
        match self {
            Self::Moving => "moving",
            Self::Rest => "rest",
            Self::Cut => "cut",
        }
    }
}

/// A frame that was compared.
#[derive(Debug)]
pub struct Shot {
    pub phase: Phase,
    pub frame: usize,
    pub judged: Judged,
}

/// A film at one cost in one variant.
#[derive(Debug)]
pub struct Run {
    pub body: Body,
    pub look: Preset,
    pub motion: Motion,
    pub cost: Cost,
    pub variant: Variant,
    /// That a frame may trace.
    pub samples_per_pixel: f64,
    /// FLIP of two converged pictures.
    pub floor: Option<f64>,
    /// Milliseconds of each moving frame, on the clock and on the GPU.
    pub times: Vec<f64>,
    pub gpu_times: Vec<f64>,
    /// Of kernels in the order in which they run, what each takes of the GPU's time in a frame in the mean.
    pub kernels: Vec<(String, f64)>,
    pub shots: Vec<Shot>,
}

/// A run in one line.
struct Summary {
    flip: Option<f64>,
    psnr: Option<f64>,
    brightness: Option<f64>,
    flicker: [Option<f64>; 3],
    first: Option<f64>,
    cut: Option<f64>,
    /// Frames; `None` where it was not caught up with, or nothing is known.
    lag: Option<u32>,
    uncovered: Option<f64>,
    median: Option<f64>,
    p99: Option<f64>,
    gpu: Option<f64>,
}

impl Run {
    /// Of which nothing is known.
    pub fn new(body: Body, look: Preset, motion: Motion, cost: Cost, variant: Variant) -> Self {
        Self {
            body,
            look,
            motion,
            cost,
            variant,
            samples_per_pixel: 0.0,
            floor: None,
            times: vec![],
            gpu_times: vec![],
            kernels: vec![],
            shots: vec![],
        }
    }

    /// A name for files.
    pub fn name(&self) -> String {
        let cost = self.cost.name();
        format!("{}-{cost}-{}", self.film_name(), self.variant.name())
    }

    /// The same without cost and variant.
    pub fn film_name(&self) -> String {
        format!("{}-{}-{}", self.body.name(), self.look.name(), self.motion.name())
    }

    fn of(&self, phase: Phase) -> impl Iterator<Item = &Shot> {
        self.shots.iter().filter(move |shot| shot.phase == phase)
    }

    /// FLIP of a frame.
    fn flip(&self, phase: Phase, frame: usize) -> Option<f64> {
        self.of(phase).find(|shot| shot.frame == frame)?.judged.flip
    }

    /// Times of moving frames: not of the first, which has images to make, nor of those before which a picture came back, for
    /// the GPU idled meanwhile. Of all where there are no others.
    fn undisturbed(&self) -> Vec<f64> {
        let follows = |frame: usize| self.of(Phase::Moving).any(|shot| shot.frame + 1 == frame);
        let times = self.times.iter().enumerate().skip(1).filter(|(frame, _)| !follows(*frame));
        let times: Vec<f64> = times.map(|(_, time)| *time).collect();
        if times.is_empty() { self.times.clone() } else { times }
    }

    fn summary(&self) -> Summary {
        // A view that began a moment ago is not what it is in motion.
        let steady: Vec<&Judged> = self
            .of(Phase::Moving)
            .filter(|shot| shot.frame >= self.times.len() / 4)
            .map(|shot| &shot.judged)
            .collect();
        let over =
            |value: &dyn Fn(&Judged) -> Option<f64>| mean(steady.iter().filter_map(|judged| value(judged)));
        let flip = over(&|judged| judged.flip);
        let errors: Vec<(u32, f64)> =
            self.of(Phase::Cut).filter_map(|shot| Some((shot.frame as u32, shot.judged.flip?))).collect();
        let times = self.undisturbed();
        Summary {
            flip,
            psnr: over(&|judged| judged.psnr.filter(|psnr| psnr.is_finite())),
            brightness: over(&|judged| judged.brightness),
            flicker: [0, 1, 2].map(|i| over(&|judged| Some(judged.flicker?[i]))),
            first: self.flip(Phase::Moving, 0),
            cut: self.flip(Phase::Cut, 0),
            lag: flip.and_then(|flip| lag(&errors, flip)),
            uncovered: over(&|judged| Some(judged.uncovered? / judged.flip?)),
            median: percentile(&times, 0.5),
            p99: percentile(&times, 0.99),
            gpu: percentile(&self.gpu_times, 0.5),
        }
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, n), value| (sum + value, n + 1));
    (count > 0).then(|| sum / count as f64)
}

/// All runs.
pub struct Report {
    /// Name and driver.
    pub device: [String; 2],
    pub runs: Vec<Run>,
    costs: Vec<Cost>,
    rest: Vec<usize>,
    settings: Value,
}

/// Its columns from the left.
const COLUMNS: [&str; 6] = ["scene", "look", "film", "budget", "variant", "spp"];
const MEASURES: [&str; 15] = [
    "flip",
    "psnr_db",
    "light",
    "flicker0",
    "flicker8",
    "flicker32",
    "first",
    "cut",
    "lag",
    "uncovered",
    "light_rest",
    "floor",
    "ms",
    "p99_ms",
    "gpu_ms",
];

impl Report {
    /// Of nothing yet.
    pub fn new(options: &Options) -> Self {
        let Options { size, voxels, length, samples, after, .. } = options;
        let settings = json!({
            "size": size, "voxels": voxels, "length": length, "frames": options.frames,
            "rest": options.rest, "after": after, "samples": samples, "tone": format!("{:?}", options.tone),
        });
        Self {
            device: Default::default(),
            runs: vec![],
            costs: options.costs.clone(),
            rest: options.rest.clone(),
            settings,
        }
    }

    /// What budgets buy.
    pub fn budgets(&self, budgets: &[u64]) -> String {
        let pixels = self.settings["size"]
            .as_array()
            .map_or(1.0, |size| size.iter().filter_map(Value::as_f64).product());
        let one = |(cost, budget): (&Cost, &u64)| {
            format!("{}: {:.3} samples a pixel", cost.name(), *budget as f64 / pixels)
        };
        self.costs.iter().zip(budgets).map(one).collect::<Vec<_>>().join(", ")
    }

    fn header(&self) -> Vec<String> {
        let rest = self.rest.iter().map(|frames| format!("rest{frames}"));
        COLUMNS.iter().chain(&MEASURES).map(|name| (*name).to_owned()).chain(rest).collect()
    }

    /// A run's values in the header's order.
    fn cells(&self, run: &Run) -> Vec<String> {
        let summary = run.summary();
        let [small, large] = [3, 2].map(|digits| move |value: Option<f64>| cell(value, digits));
        let last_rest = run.of(Phase::Rest).last().and_then(|shot| shot.judged.brightness);
        let after = run.of(Phase::Cut).last().map_or(0, |shot| shot.frame);
        let mut cells = vec![
            run.body.name().to_owned(),
            run.look.name().to_owned(),
            run.motion.name().to_owned(),
            run.cost.name(),
            run.variant.name().to_owned(),
            format!("{:.3}", run.samples_per_pixel),
            small(summary.flip),
            large(summary.psnr),
            small(summary.brightness),
        ];
        cells.extend(summary.flicker.map(large));
        cells.extend([summary.first, summary.cut].map(small));
        cells.push(match (summary.lag, summary.flip) {
            (Some(frames), _) => frames.to_string(),
            (None, Some(_)) => format!(">{after}"),
            (None, None) => String::new(),
        });
        cells.push(large(summary.uncovered));
        cells.extend([last_rest, run.floor].map(small));
        cells.extend([summary.median, summary.p99, summary.gpu].map(large));
        cells.extend(self.rest.iter().map(|frames| small(run.flip(Phase::Rest, *frames))));
        cells
    }

    /// A run as one line.
    pub fn line(&self, run: &Run) -> String {
        let named = self.header().into_iter().zip(self.cells(run)).skip(COLUMNS.len());
        let shown =
            named.filter(|(name, _)| ["flip", "first", "lag", "light", "ms"].contains(&name.as_str()));
        let shown: Vec<String> = shown.map(|(name, value)| format!("{name} {value}")).collect();
        format!("{}: {}", run.name(), shown.join(", "))
    }

    /// All runs as text.
    pub fn table(&self) -> String {
        let mut rows = vec![self.header()];
        rows.extend(self.runs.iter().map(|run| self.cells(run)));
        let width = |column: usize| rows.iter().map(|row| row[column].len()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..rows[0].len()).map(width).collect();
        let mut text = String::new();
        for row in &rows {
            for (i, (cell, width)) in row.iter().zip(&widths).enumerate() {
                let gap = if i == 0 { "" } else { "  " };
                // Words to the left, numbers to the right.
                let padded = if i < 5 { format!("{cell:<width$}") } else { format!("{cell:>width$}") };
                text += gap;
                text += &padded;
            }
            text.truncate(text.trim_end().len());
            text.push('\n');
        }
        text
    }

    /// Writes all files anew.
    pub fn write(&self, folder: &Path) -> Result<(), String> {
        let files = [
            ("motion.txt", format!("{} ({})\n\n{}", self.device[0], self.device[1], self.table())),
            ("runs.csv", self.runs_csv()),
            ("pictures.csv", self.pictures_csv()),
            ("kernels.csv", self.kernels_csv()),
            ("motion.json", format!("{:#}\n", self.json())),
        ];
        for (name, text) in files {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
        }
        Ok(())
    }

    fn runs_csv(&self) -> String {
        let mut csv = self.header().join(",") + "\n";
        for run in &self.runs {
            csv += &self.cells(run).join(",");
            csv.push('\n');
        }
        csv
    }

    fn kernels_csv(&self) -> String {
        let mut csv = COLUMNS.join(",") + ",kernel,gpu_ms\n";
        for run in &self.runs {
            for (kernel, milliseconds) in &run.kernels {
                let begin = self.cells(run)[..COLUMNS.len()].join(",");
                // A string takes whatever is written into it.
                _ = writeln!(csv, "{begin},{kernel},{milliseconds:.3}");
            }
        }
        csv
    }

    fn pictures_csv(&self) -> String {
        let blurs = BLURS.map(|blur| format!("flicker{blur}")).join(",");
        let mut csv = COLUMNS.join(",") + ",phase,frame,flip,psnr_db,light," + &blurs + ",uncovered_flip\n";
        for run in &self.runs {
            for Shot { phase, frame, judged } in &run.shots {
                let begin = self.cells(run)[..COLUMNS.len()].join(",");
                let flicker = [0, 1, 2].map(|i| judged.flicker.map(|flicker| flicker[i]));
                let values = [judged.flip, judged.psnr, judged.brightness]
                    .into_iter()
                    .chain(flicker)
                    .chain([judged.uncovered]);
                let values: Vec<String> = values.map(|value| cell(value, 5)).collect();
                // A string takes whatever is written into it.
                _ = writeln!(csv, "{begin},{},{frame},{}", phase.name(), values.join(","));
            }
        }
        csv
    }

    fn json(&self) -> Value {
        let shot = |Shot { phase, frame, judged }: &Shot| {
            json!({
                "phase": phase.name(), "frame": frame, "flip": judged.flip,
                // Infinite where the pictures are equal, which JSON does not know.
                "psnr_db": judged.psnr.filter(|psnr| psnr.is_finite()),
                "light": judged.brightness, "flicker": judged.flicker, "uncovered_flip": judged.uncovered,
            })
        };
        let run = |run: &Run| {
            let summary = run.summary();
            json!({
                "scene": run.body.name(), "look": run.look.name(), "film": run.motion.name(),
                "budget": run.cost.name(), "variant": run.variant.name(), "spp": run.samples_per_pixel,
                "floor": run.floor, "flip": summary.flip, "psnr_db": summary.psnr,
                "light": summary.brightness, "flicker": summary.flicker, "first": summary.first,
                "cut": summary.cut, "lag": summary.lag, "uncovered": summary.uncovered,
                "ms": summary.median, "p99_ms": summary.p99, "gpu_ms": summary.gpu,
                "frames_ms": run.times, "frames_gpu_ms": run.gpu_times,
                "pictures": run.shots.iter().map(shot).collect::<Vec<_>>(),
            })
        };
        json!({
            "device": self.device[0], "driver": self.device[1], "settings": self.settings, "blurs": BLURS,
            "runs": self.runs.iter().map(run).collect::<Vec<_>>(),
        })
    }
}

/// A value, or nothing.
fn cell(value: Option<f64>, digits: usize) -> String {
    value.map_or(String::new(), |value| format!("{value:.digits$}"))
}
