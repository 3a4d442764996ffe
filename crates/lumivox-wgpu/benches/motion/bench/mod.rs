//! The bench's walk: films, their converged pictures, and what live views make of them.

mod films;
mod host;
mod judge;
mod options;
mod plot;
mod report;

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::{Arc, mpsc};
use std::time::Instant;

use lumivox_core::Preset;

use self::films::{Body, Moment, Motion, RATE, Set};
use self::host::{Host, Picture, Showing};
use self::judge::{Converged, ConvergedLater, Judged, Judges};
use self::options::{Cost, HELP, Options};
use self::report::{Phase, Report, Run, Shot};

/// Seeds of converged pictures: none of what is compared with them.
const SEED: u32 = 0x51ed_270b;
const OTHER_SEED: u32 = 0x2545_f491;

/// Frames for which a pixel counts as uncovered a moment ago.
const MOMENT: usize = 4;

/// Frames after a cut that are compared.
const AFTER_CUT: [usize; 11] = [0, 1, 2, 3, 4, 6, 8, 12, 16, 32, 60];

/// Frames before those that count, in which kernels are made.
const PRELUDE: usize = 3;

/// Does what the words of a command line say, and tells how far it is.
///
/// # Errors
/// What is wrong with a word, a file or the device.
pub fn run(words: impl IntoIterator<Item = String>, log: &mut dyn Write) -> Result<(), String> {
    let mut log = Log { out: log, begin: Instant::now() };
    let Some(options) = Options::parse(words)? else { return log.plain(HELP) };
    std::fs::create_dir_all(&options.out).map_err(|error| format!("{}: {error}", options.out.display()))?;
    let mut bench = Bench {
        host: Host::open(options.size)?,
        judges: Judges::new(),
        report: Report::new(&options),
        options,
    };
    bench.report.device = bench.host.description();
    let Options { size, voxels, samples, .. } = bench.options;
    log.say(&format!(
        "{} ({}), {} x {}, {voxels} voxels, converged: {samples} samples",
        bench.report.device[0], bench.report.device[1], size[0], size[1]
    ))?;
    let films = bench.options.films.clone();
    let mut bodies: Vec<Body> = films.iter().map(|film| film.0).collect();
    bodies.dedup();
    for body in bodies {
        let volume = body.volume(voxels)?;
        log.say(&format!("made the {}", body.name()))?;
        let mut looks: Vec<Preset> = films.iter().filter(|film| film.0 == body).map(|film| film.1).collect();
        looks.dedup();
        for look in looks {
            let set = Set::new(body, &volume, look, f64::from(size[0]) / f64::from(size[1]));
            let budgets = bench.budgets(&set)?;
            log.say(&format!("{} {}: {}", body.name(), look.name(), bench.report.budgets(&budgets)))?;
            let mut floor = None;
            for film in films.iter().filter(|film| (film.0, film.1) == (body, look)) {
                let runs = bench.film(&set, *film, &budgets, &mut floor)?;
                for run in runs {
                    log.say(&bench.report.line(&run))?;
                    bench.report.runs.push(run);
                }
                // What is there so far is kept, whatever comes.
                bench.report.write(&bench.options.out)?;
            }
        }
    }
    log.plain("")?;
    log.plain(&bench.report.table())?;
    log.say(&format!("written to {}", bench.options.out.display()))
}

/// Where it is told how far the bench is.
struct Log<'a> {
    out: &'a mut dyn Write,
    begin: Instant,
}

impl Log<'_> {
    fn say(&mut self, what: &str) -> Result<(), String> {
        self.plain(&format!("{:>5.0} s  {what}", self.begin.elapsed().as_secs_f64()))
    }

    fn plain(&mut self, what: &str) -> Result<(), String> {
        let written = writeln!(self.out, "{what}").and_then(|()| self.out.flush());
        written.map_err(|error| format!("the output: {error}"))
    }
}

struct Bench {
    options: Options,
    host: Host,
    judges: Judges,
    report: Report,
}

/// A film and the converged pictures of it.
struct Reel {
    name: String,
    moments: Vec<Moment>,
    cut: Moment,
    converged: BTreeMap<usize, ConvergedLater>,
    converged_cut: ConvergedLater,
}

impl Bench {
    /// Pixel samples of a frame, by what it may cost.
    fn budgets(&mut self, set: &Set) -> Result<Vec<u64>, String> {
        let pixels = self.host.pixels() as f64;
        if let (true, Some(Cost::Milliseconds(ms))) =
            (self.report.runs.is_empty(), self.options.costs.first())
        {
            // Once in vain: a GPU that was idle takes a while until its clock is what it is at work.
            self.host.pace(set, *ms)?;
        }
        let budget = |cost: &Cost| match cost {
            Cost::Milliseconds(ms) => self.host.pace(set, *ms),
            Cost::Samples(samples) => Ok((samples * pixels).round().max(1.0) as u64),
        };
        self.options.costs.iter().map(budget).collect()
    }

    /// A film at every cost, in every variant. `floor` is the difference of two converged pictures of the set, once it is known.
    fn film(
        &mut self,
        set: &Set,
        (body, look, motion): (Body, Preset, Motion),
        budgets: &[u64],
        floor: &mut Option<f64>,
    ) -> Result<Vec<Run>, String> {
        let reel = self.reel(set, motion)?;
        if floor.is_none() {
            *floor = self.floor(&reel)?;
        }
        let (tell, told) = mpsc::channel();
        let mut runs = vec![];
        for (&cost, &budget) in self.options.costs.clone().iter().zip(budgets) {
            for variant in self.options.variants.clone() {
                let mut run = Run::new(body, look, motion, cost, variant);
                run.samples_per_pixel = budget as f64 / self.host.pixels() as f64;
                run.floor = *floor;
                self.shoot(&reel, &mut run, budget, &tell, runs.len())?;
                self.time_kernels(&reel, &mut run, budget)?;
                runs.push(run);
            }
        }
        drop(tell);
        let awaited: usize = runs.iter().map(|run| run.shots.len()).sum();
        let mut came = 0;
        for judged in told {
            let (run, shot, judged): (usize, usize, Judged) = judged?;
            runs[run].shots[shot].judged = judged;
            came += 1;
        }
        if came < awaited {
            return Err(format!("{} of {awaited} comparisons did not end", awaited - came));
        }
        plot::write(&self.options, &runs)?;
        Ok(runs)
    }

    /// Moments, and the converged pictures of those that are compared.
    fn reel(&mut self, set: &Set, motion: Motion) -> Result<Reel, String> {
        let Options { length, ref frames, samples, .. } = self.options;
        let frames = frames.clone();
        let seconds = |frame: usize| frame as f64 / RATE;
        let moments: Vec<Moment> = (0..length).map(|frame| set.at(motion, seconds(frame))).collect();
        // Back to a frame that is compared anyway.
        let back = frames.iter().copied().find(|frame| *frame >= length / 4).unwrap_or(0);
        let cut = set.after_cut(motion, seconds(length - 1), seconds(back));
        self.host.set_depth(&vec![0.0; self.host.pixels() as usize])?;
        let mut wanted = frames;
        wanted.extend([length - 1, back]);
        wanted.sort_unstable();
        wanted.dedup();
        let mut converged = BTreeMap::new();
        for frame in wanted {
            let name = format!("{}-{}", set.name(motion), frame);
            let picture = self.converge(&name, &moments[frame], samples, SEED)?;
            converged.insert(frame, self.converged(picture, self.uncovered(&moments, frame)));
        }
        let converged_cut = if motion == Motion::Orbit {
            let picture =
                self.converge(&format!("{}-cut-{length}", set.name(motion)), &cut, samples, SEED)?;
            self.converged(picture, vec![false; self.host.pixels() as usize])
        } else {
            converged[&back].clone()
        };
        let name = set.name(motion);
        Ok(Reel { name, moments, cut, converged, converged_cut })
    }

    /// A converged picture, made or found where such are kept.
    fn converge(&mut self, name: &str, moment: &Moment, samples: u32, seed: u32) -> Result<Picture, String> {
        let Some(folder) = self.options.converged.clone() else {
            return self.host.converge(moment, samples, seed);
        };
        let Options { size: [width, height], voxels, .. } = self.options;
        let path = folder.join(format!("{name}-{width}x{height}-{voxels}-{samples}-{seed:x}.rgba32f"));
        let told = |error: std::io::Error| format!("{}: {error}", path.display());
        if let Ok(bytes) = std::fs::read(&path)
            && bytes.len() as u64 == 16 * self.host.pixels()
        {
            return Ok(bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect());
        }
        let picture = self.host.converge(moment, samples, seed)?;
        std::fs::create_dir_all(&folder).map_err(told)?;
        std::fs::write(&path, bytemuck::cast_slice(&picture)).map_err(told)?;
        Ok(picture)
    }

    fn converged(&self, picture: Picture, uncovered: Vec<bool>) -> ConvergedLater {
        let converged =
            Converged::later(picture, uncovered, self.options.size[0] as usize, self.options.tone);
        // Begun ahead of those who want it.
        let ahead = converged.clone();
        self.judges.ask(move || _ = &**ahead);
        converged
    }

    /// The pixels in which there was a mesh a moment ago and is none now.
    fn uncovered(&self, moments: &[Moment], frame: usize) -> Vec<bool> {
        let mut uncovered = vec![false; self.host.pixels() as usize];
        let depths = |frame: usize| {
            let Moment { board, camera, .. } = &moments[frame];
            board.as_ref().map(|board| board.depths(camera, self.options.size))
        };
        let Some(now) = depths(frame) else { return uncovered };
        for before in (frame.saturating_sub(MOMENT)..frame).filter_map(depths) {
            for (uncovered, (before, now)) in uncovered.iter_mut().zip(before.iter().zip(&now)) {
                *uncovered |= *before > 0.0 && *now == 0.0;
            }
        }
        uncovered
    }

    /// How far two converged pictures of other seeds differ: no picture gets below that.
    fn floor(&mut self, reel: &Reel) -> Result<Option<f64>, String> {
        let Some(last) = reel.moments.last() else { return Ok(None) };
        let name = format!("{}-{}", reel.name, reel.moments.len() - 1);
        let picture = self.converge(&name, last, self.options.samples, OTHER_SEED)?;
        let converged = &reel.converged[&(reel.moments.len() - 1)];
        Ok(converged.judge(&picture, None, 0).flip)
    }

    /// Plays a film to a live view. The comparisons are told later, by the number of the run and the place among its shots.
    fn shoot(
        &mut self,
        reel: &Reel,
        run: &mut Run,
        budget: u64,
        tell: &mpsc::Sender<Result<(usize, usize, Judged), String>>,
        number: usize,
    ) -> Result<(), String> {
        let strip_path = (self.options.strip > 0).then(|| {
            let strips = self.options.out.join("strips");
            strips.join(format!("{}.png", run.name()))
        });
        let host = &mut self.host;
        let settings = run.variant.settings(host);
        let length = reel.moments.len();
        host.draw_meshes(&reel.moments[0])?;
        let mut prelude = Showing::new(host, &reel.moments[0], settings, true, 1)?;
        for frame in 0..PRELUDE {
            prelude.frame(host, &reel.moments[frame.min(1)], budget)?;
        }
        prelude.free(host)?;

        let last_rest = self.options.rest.last().copied().unwrap_or(0);
        let moving = (0..length).map(|frame| (Phase::Moving, frame, &reel.moments[frame]));
        let rest = (1..=last_rest).map(|frame| (Phase::Rest, frame, &reel.moments[length - 1]));
        let cut = (0..=self.options.after).map(|frame| (Phase::Cut, frame, &reel.cut));
        let mut showing = Showing::new(host, &reel.moments[0], settings, true, self.options.eyes)?;
        let mut before: Option<(Arc<Picture>, ConvergedLater)> = None;
        for (phase, frame, moment) in moving.chain(rest).chain(cut) {
            // Meshes that do not move are there already.
            if phase == Phase::Moving || frame == 0 {
                host.draw_meshes(moment)?;
            }
            let took = showing.frame(host, moment, budget)?;
            if phase == Phase::Moving {
                run.times.push(took.milliseconds);
                run.gpu_times.extend(took.gpu_milliseconds);
            }
            let compared = match phase {
                Phase::Moving => &self.options.frames[..],
                Phase::Rest => &self.options.rest,
                Phase::Cut => &AFTER_CUT,
            };
            if !compared.contains(&frame) {
                before = None;
                continue;
            }
            let converged = match phase {
                Phase::Moving => reel.converged[&frame].clone(),
                Phase::Rest => reel.converged[&(length - 1)].clone(),
                Phase::Cut => reel.converged_cut.clone(),
            };
            let picture = Arc::new(showing.picture(host)?);
            let is_last = phase == Phase::Moving && Some(&frame) == self.options.frames.last();
            let strip = strip_path.as_ref().filter(|_| is_last).cloned();
            // Of still pictures it is not asked how they change.
            let earlier = before.take().filter(|_| phase == Phase::Moving);
            before = Some((picture.clone(), converged.clone()));
            let place = run.shots.len();
            run.shots.push(Shot { phase, frame, judged: Judged::default() });
            let (tell, side) = (tell.clone(), self.options.strip);
            self.judges.ask(move || {
                let before = earlier.as_ref().map(|(picture, converged)| (&**picture, &***converged));
                let mut judged = converged.judge(&picture, before, if strip.is_some() { side } else { 0 });
                let written = match (judged.strip.take(), strip) {
                    (Some(image), Some(path)) => {
                        image.write(&path).map_err(|error| format!("{}: {error}", path.display()))
                    }
                    _ => Ok(()),
                };
                // Who does not listen any more has failed already.
                _ = tell.send(written.map(|()| (number, place, judged)));
            });
        }
        showing.free(host)
    }

    /// Plays the last frames of a film again, each kernel by itself.
    fn time_kernels(&mut self, reel: &Reel, run: &mut Run, budget: u64) -> Result<(), String> {
        let count = self.options.kernels.min(reel.moments.len());
        if count == 0 {
            return Ok(());
        }
        let host = &mut self.host;
        let settings = run.variant.settings(host);
        let mut showing = Showing::new(host, &reel.moments[0], settings, true, 1)?;
        let (before, timed) = reel.moments.split_at(reel.moments.len() - count);
        for moment in before {
            host.draw_meshes(moment)?;
            showing.frame(host, moment, budget)?;
        }
        for moment in timed {
            host.draw_meshes(moment)?;
            for (kernel, milliseconds) in showing.frame_in_parts(host, moment, budget)? {
                match run.kernels.iter_mut().find(|(name, _)| *name == kernel) {
                    Some((_, sum)) => *sum += milliseconds / count as f64,
                    None => run.kernels.push((kernel, milliseconds / count as f64)),
                }
            }
        }
        showing.free(host)
    }
}
