//! A frame of a live view as a list of passes: what its films keep, where rays end, what is traced, and what is shown.
//!
//! Here the list is made, and all of it: `schedule` says what is traced, `passes` what each pass does.

use lumivox_core::Camera;

use super::changing_light::{Change, FrameLight, LightOfFilm};
use super::film::LiveFilm;
use super::images::{Grain, PictureImages, pixels};
use super::light::KeptLight;
use super::light_cells::Sight;
use super::looks::Look;
use super::passes::{
    DrawPass, FramePass, HostDepthPass, PathSettings, PictureFilms, PicturePass, ReadPass, Share,
};
use super::schedule::{Plan, Work};
use super::{HostFrame, Key, LiveSettings, LiveStatus, LiveView};
use crate::error::RenderError;
use crate::recording::Recording;
use crate::scene_cache::SceneCache;

/// The passes of a frame, not recorded yet. A host may put passes of its own between them, or in their places. Those that bring
/// something back stay, in their order: the view waits for their [feedback](LiveView::feedback).
#[derive(Debug)]
#[must_use]
pub struct LiveFrame<'a> {
    /// In their order.
    pub passes: Vec<Box<dyn FramePass + 'a>>,
    /// How far the view is when they are recorded.
    pub status: LiveStatus,
    /// What goes after them.
    gone: Recording,
}

impl LiveFrame<'_> {
    /// Records all passes.
    pub fn record(self, recording: &mut Recording) {
        for pass in &self.passes {
            pass.record(recording);
        }
        recording.steps.extend(self.gone.steps);
    }
}

/// Samples of the film from which on light learns no more: paths serve the film better.
const LEARNS_UNTIL: u32 = 16;

/// A frame that is planned.
struct Planned<'a> {
    cache: &'a SceneCache,
    paths: PathSettings,
    passes: Vec<Box<dyn FramePass + 'a>>,
    gone: Recording,
}

impl<'a> Planned<'a> {
    fn push(&mut self, pass: impl FramePass + 'a) {
        self.passes.push(Box::new(pass));
    }
}

impl LiveView {
    /// Plans a frame, as [`record_frame`](Self::record_frame) records it. What its passes need and is not there yet is made in
    /// `recording`; they are to be recorded behind that, for the view takes them for done.
    ///
    /// # Errors
    /// As [`record_frame`](Self::record_frame).
    pub fn plan_frame<'a>(
        &mut self,
        cache: &'a SceneCache,
        camera: &Camera,
        settings: &LiveSettings,
        host: &HostFrame,
        budget: u64,
        recording: &mut Recording,
    ) -> Result<LiveFrame<'a>, RenderError> {
        let before = self.seen.take();
        check(cache, camera, settings)?;
        self.fit(settings, cache, recording)?;
        let key = Key::new(cache, camera, settings, host);
        let light = FrameLight::of(cache, settings.ambient);
        let change = self.change(key, light, settings);
        let was_held = self.schedule.is_held();
        let paths = PathSettings {
            camera: *camera,
            seed: 0,
            roulette_start: settings.roulette_start,
            ambient: light.ambient,
        };
        let mut frame = Planned { cache, paths, passes: vec![], gone: Recording::new() };

        // What the films keep.
        self.fit_light(change, light, settings, budget, &mut frame, recording);
        match change {
            Change::Much => self.restart(key, light, budget, &mut frame, recording)?,
            Change::Little(kept) => self.fade(kept, budget, &mut frame, recording)?,
            Change::None if self.schedule.is_covered() && self.light.rests(self.schedule.is_done()) => {
                self.restart_behind(light, &mut frame, recording)?;
            }
            Change::None => self.begin_finer(budget, &mut frame, recording)?,
        }
        frame.paths.seed = self.light.seed(settings.seed);
        let look = self.plan_look(change, budget);
        // However small it is: light has to learn.
        let budget = budget - look.map_or(0, |look| look.pixel_samples.min(budget / 2));
        let granted = self.paths_of_light(change, budget);
        let is_its_turn = |kept: &mut KeptLight| granted > 0 && kept.take_turn(light, cache);
        let paths = if self.kept_light.as_mut().is_some_and(is_its_turn) { granted } else { 0 };
        if let Some(light) = self.kept_light.as_mut().filter(|_| paths > 0) {
            let clear = light.prepare(paths, cache, &mut frame.gone, recording)?;
            frame.passes.extend(clear.map(|pass| Box::new(pass) as Box<dyn FramePass>));
        }
        // Where their rays end. Without depth none does, nor any of an empty film; whether there is any is part of the key.
        if let Some(depth) = host.depth {
            let films = self.traced_films().map(|(grain, film)| film.images(grain)).collect();
            let farthest = cache.farthest(camera);
            frame.push(HostDepthPass { depth, farthest, films, restarts: self.restarts, is_asked: true });
            self.awaited += 1;
            let light = self.kept_light.as_ref().filter(|_| paths > 0);
            if let Some((film, restarts)) = light.and_then(KeptLight::host_depth) {
                frame.push(HostDepthPass { depth, farthest, films: vec![film], restarts, is_asked: false });
            }
        }
        // What light learns.
        let learns = self.kept_light.as_mut().filter(|_| paths > 0);
        if let Some((trace, cells)) =
            learns.and_then(|it| it.learn(paths, light, &frame.paths, cache, recording))
        {
            frame.push(trace);
            frame.push(cells);
        }
        // While things move a film of a moment shows no more than light does, whoever that learns from.
        let is_for_light = change == Change::Much && granted > 0;
        self.awaits_turn = is_for_light && paths == 0;
        let budget = if is_for_light { 0 } else { budget - paths };
        // What is traced: all of a coarse film in answer to a change, then more of the fine one.
        self.pixel_samples = if change == Change::Much && self.schedule.factor() > 1 {
            let plan = self.schedule.answer(budget);
            self.trace(&plan, &mut frame)
        } else {
            let plan = match change {
                Change::Little(_) => self.schedule.follow(budget / 2),
                _ => Plan::default(),
            };
            let followed = self.trace(&plan, &mut frame);
            let refined = if budget > followed { self.refine(budget - followed, &mut frame) } else { 0 };
            followed + refined
        };
        if self.fine.unfinished.puts_aside() && self.pixel_samples > 0 {
            self.trace_starved(&mut frame);
        }
        self.pixel_samples += paths;
        if was_held && !self.schedule.is_held() {
            self.free_held(&mut frame.gone);
        }
        // What is shown of it.
        self.look_at_light(look, change, &mut frame, recording);
        self.denoise(settings, &mut frame, recording);
        frame.push(self.picture(settings, host, camera, cache));
        self.draw(host, &mut frame);
        frame.passes.extend(
            self.velocity(before, host, camera, cache).map(|pass| Box::new(pass) as Box<dyn FramePass>),
        );

        Ok(LiveFrame { passes: frame.passes, status: self.status(), gone: frame.gone })
    }

    /// Makes films and picture anew where they are of another size, or keep guides or not.
    fn fit(
        &mut self,
        settings: &LiveSettings,
        cache: &SceneCache,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        if settings.film_size() != self.fine.size || settings.guides != self.fine.has_guides {
            let fine = LiveFilm::new(settings.film_size(), settings.guides, cache, recording)?;
            std::mem::replace(&mut self.fine, fine).free(recording);
            self.drop_coarse(recording);
            self.key = None;
        }
        if settings.size != self.picture.size() {
            let picture = PictureImages::new(settings.size, recording);
            std::mem::replace(&mut self.picture, picture).free(recording);
        }
        Ok(())
    }

    /// Light is kept where the settings say so and there is room for it, of the volumes that there are.
    fn fit_light(
        &mut self,
        change: Change,
        light: FrameLight,
        settings: &LiveSettings,
        budget: u64,
        frame: &mut Planned<'_>,
        recording: &mut Recording,
    ) {
        let size = settings.film_size();
        let sight = Sight::new(&frame.paths.camera, light, settings.exposure, frame.cache);
        let is_wanted = settings.kept_light && frame.cache.numbers().is_some();
        let mut fits = |light: &mut KeptLight| {
            is_wanted
                && light.fits(&sight, frame.cache, &mut frame.gone)
                && light.resize(size, frame.cache, &mut frame.gone, recording)
        };
        if let Some(light) = self.kept_light.take_if(|light| !fits(light)) {
            light.free(&mut frame.gone);
        }
        // It is for what moves: a view that is at rest does without until then, and one whose frames are whole for ever.
        let is_for_it = change != Change::None && budget < self.whole();
        if is_wanted && self.kept_light.is_none() && is_for_it {
            self.kept_light = KeptLight::new(size, &sight, frame.cache, recording);
        }
    }

    /// Paths from which light learns in this frame: all that there are while something moves, and half of them until the
    /// film shows more than light knows. None where they buy the whole film.
    fn paths_of_light(&self, change: Change, budget: u64) -> u64 {
        let Some(light) = &self.kept_light else { return 0 };
        let wanted = match change {
            _ if budget >= self.whole() => 0,
            Change::Much => budget,
            _ if !self.schedule.is_done() && self.schedule.complete() < LEARNS_UNTIL => budget / 2,
            _ => 0,
        };
        wanted.min(light.most_paths())
    }

    /// How the picture of kept light is made, if it is shown and there is a new one.
    fn plan_look(&mut self, change: Change, budget: u64) -> Option<Look> {
        let learns = !self.schedule.is_done() && self.schedule.complete() < LEARNS_UNTIL;
        let (is_at_rest, is_shown) = (change == Change::None, self.shown_light().is_some());
        let whole = self.whole();
        let light = self.kept_light.as_mut().filter(|_| budget < whole)?;
        let is_wanted = !is_at_rest || learns || is_shown && light.looks().is_stale();
        is_wanted.then(|| light.plan_look(budget, is_at_rest)).flatten()
    }

    /// Samples of the whole film.
    fn whole(&self) -> u64 {
        pixels(self.fine.size) * u64::from(self.target_samples)
    }

    /// The picture of kept light, if that is what is seen, and another than before.
    fn look_at_light(
        &mut self,
        look: Option<Look>,
        change: Change,
        frame: &mut Planned<'_>,
        recording: &mut Recording,
    ) {
        if self.shown_light().is_none() {
            return;
        }
        let Some(light) = &mut self.kept_light else { return };
        // Or light has learnt, which it knows.
        if change != Change::None {
            light.looks().look_again();
        }
        if let Some(look) = look.filter(|_| light.looks().is_stale()) {
            self.pixel_samples += look.pixel_samples;
            frame.push(light.look(look, &self.fine, &frame.paths, frame.cache, recording));
        }
    }

    /// How the image differs from the one before, and how many samples it is to have.
    fn change(&mut self, key: Key, light: FrameLight, settings: &LiveSettings) -> Change {
        let of_light = self.light.follow(light);
        let change = if self.key == Some(key) { of_light } else { Change::Much };
        self.noise.set_target(settings.target_noise);
        if change == Change::Much {
            self.noise.restart();
        }
        self.most_samples = settings.target_samples;
        self.target_samples = self.noise.samples(self.most_samples);
        self.schedule.set_target(self.target_samples);
        change
    }

    /// Begins an empty image, as coarse as the budget demands.
    fn restart(
        &mut self,
        key: Key,
        light: FrameLight,
        budget: u64,
        frame: &mut Planned<'_>,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        if self.key.is_none_or(|shown| shown.scene_version != key.scene_version) {
            self.paths.are_of_this_scene = false;
        }
        let schedule = match self.kept_light {
            Some(_) => self.schedule.restarted_alone(self.fine.size),
            None => self.schedule.restarted(self.fine.size, budget, self.key.is_some()),
        };
        if let Some(size) = schedule.coarse_size() {
            begin(&mut self.coarse, Grain::Coarse, size, frame, recording)?;
        }
        self.schedule = schedule;
        frame.push(self.fine.clear(Grain::Fine));
        self.count.forget();
        self.key = Some(key);
        self.light = LightOfFilm::new(light);
        Ok(())
    }

    /// Keeps a part of the image, for its light has changed a little.
    fn fade(
        &mut self,
        [kept, scale]: [f64; 2],
        budget: u64,
        frame: &mut Planned<'_>,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        let kept = self.schedule.kept_of_frames(kept, budget);
        let coarse = self.schedule.fade(kept, budget);
        for (grain, film) in self.traced_films() {
            // One that begins has nothing to keep.
            if coarse.is_none() || grain != Grain::Coarse {
                frame.push(film.fade(grain, [kept, scale]));
            }
        }
        self.count.forget();
        self.noise.restart();
        if let Some(size) = coarse {
            begin(&mut self.coarse, Grain::Coarse, size, frame, recording)?;
        }
        Ok(())
    }

    /// Begins an empty image, before which this one stays to be seen until that is as good.
    fn restart_behind(
        &mut self,
        light: FrameLight,
        frame: &mut Planned<'_>,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        let size = self.fine.size;
        let held = make_room(&mut self.coarse, size, self.fine.has_guides, frame, recording)?;
        held.size = size;
        std::mem::swap(held, &mut self.fine);
        self.schedule = self.schedule.restarted_behind();
        frame.push(self.fine.clear(Grain::Fine));
        self.count.forget();
        self.noise.restart();
        self.light = LightOfFilm::new(light);
        Ok(())
    }

    /// Gives back what was shown before this image, unless a coarse film has its place.
    fn free_held(&mut self, recording: &mut Recording) {
        let held = if self.schedule.has_coarse() { None } else { self.coarse.take() };
        held.into_iter().for_each(|held| held.free(recording));
    }

    /// Begins a film of half the coarse one's grain, where it is time for that.
    fn begin_finer(
        &mut self,
        budget: u64,
        frame: &mut Planned<'_>,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        if let Some(size) = self.schedule.finer_to_begin(budget) {
            begin(&mut self.finer, Grain::Finer, size, frame, recording)?;
            self.schedule.begin_finer();
        }
        Ok(())
    }

    /// The films that samples go into.
    fn traced_films(&mut self) -> impl Iterator<Item = (Grain, &mut LiveFilm)> {
        let coarse = self.coarse.as_mut().filter(|_| self.schedule.has_coarse());
        let finer = self.finer.as_mut().filter(|_| self.schedule.fills_finer());
        let films = [(Grain::Fine, Some(&mut self.fine)), (Grain::Coarse, coarse), (Grain::Finer, finer)];
        films.into_iter().filter_map(|(grain, film)| Some((grain, film?)))
    }

    /// What was planned; returns how many pixel samples that are.
    fn trace(&mut self, plan: &Plan, frame: &mut Planned<'_>) -> u64 {
        for &work in &plan.works {
            let (grain, samples, limit) = match work {
                Work::Replace => {
                    std::mem::swap(&mut self.finer, &mut self.coarse);
                    continue;
                }
                Work::AllCoarse { samples } => (Grain::Coarse, samples, samples),
                Work::FirstAid { film, samples, .. } => (film, samples, samples),
                Work::Samples { film, samples, limit, .. } => (film, samples, limit),
            };
            let film = match grain {
                Grain::Fine => Some(&mut self.fine),
                Grain::Coarse => self.coarse.as_mut(),
                Grain::Finer => self.finer.as_mut(),
                Grain::Points => None,
            };
            let Some(film) = film else { continue };
            let mut share = Share::of_all(film.size, samples, limit);
            match work {
                // By as many invocations as may share a pixel: there are few pixels, and a large GPU is to be busy.
                Work::AllCoarse { samples } => {
                    let most = frame.cache.variant(false, true).most_sharers();
                    share.sharers = 1 << samples.clamp(1, most).ilog2();
                    film.stale = true;
                }
                // Where it only shows through it is not denoised anew for a few pixels.
                Work::FirstAid { below, .. } => {
                    share.only_below = below;
                    film.stale |= !self.schedule.is_covered();
                }
                Work::Samples { rows, .. } => {
                    share.rows = rows;
                    film.stale = true;
                    if grain == Grain::Fine {
                        self.count.forget();
                    }
                }
                Work::Replace => {}
            }
            frame.push(film.trace(grain, frame.cache, &frame.paths, share));
        }
        plan.pixel_samples
    }

    /// More samples of the same image, and what its counts ask for once it should be whole; returns how many.
    fn refine(&mut self, budget: u64, frame: &mut Planned<'_>) -> u64 {
        let plan = self.schedule.refine(budget);
        let planned = self.trace(&plan, frame);
        let missing = if self.schedule.is_done() { self.confirm(frame) } else { 0 };
        let is_still = self.schedule.is_done() && planned + missing == 0;
        let is_whole = self.is_counted_whole() && !self.light.is_mixed();
        if is_still && is_whole && self.noise.begin_look(self.most_samples) {
            frame.push(ReadPass { image: self.fine.images(Grain::Fine).film() });
            self.awaited += 1;
        }
        if self.seems_whole() {
            self.schedule.retire_coarse(self.is_open());
        }
        self.fine.stale |= planned + missing > 0;
        planned + missing
    }

    /// Has a fine film that should be whole counted, and what was found missing traced. Returns how many samples.
    fn confirm(&mut self, frame: &mut Planned<'_>) -> u64 {
        if self.count.confirmed || self.count.under_way {
            return 0;
        }
        let mut recorded = 0;
        let target = self.target_samples;
        if self.fine.unfinished.begin_retry() {
            recorded = u64::from(self.fine.unfinished.missing());
            let share = Share::of_all(self.fine.size, target, target);
            frame.push(self.fine.trace(Grain::Fine, frame.cache, &frame.paths, share));
        }
        frame.push(self.fine.count(Grain::Fine, target));
        self.count.under_way = true;
        self.awaited += 1;
        recorded
    }

    /// What is shown is looked at long before it is whole: paths that starve would be missing from it all the while. Takes
    /// them up where some are known to be, and has others found.
    fn trace_starved(&mut self, frame: &mut Planned<'_>) {
        let (samples, target) = (self.schedule.pass_samples(), self.target_samples);
        let (grain, shown) = match self.schedule.shows_fine() {
            true => (Grain::Fine, Some(&mut self.fine)),
            false => (Grain::Coarse, self.coarse.as_mut()),
        };
        let Some(shown) = shown else { return };
        if self.count.outdated == 0
            && !self.count.under_way
            && !(self.paths.are_of_this_scene && self.paths.starve)
        {
            frame.push(shown.count(grain, target));
            self.count.outdated = 1;
            self.awaited += 1;
        }
        if self.paths.starve {
            let share = Share::of_all(shown.size, samples, target);
            frame.push(shown.trace_starved(grain, frame.cache, &frame.paths, share));
            shown.stale = true;
        }
    }

    /// The denoiser's image of every film that is shown, made anew where samples or the switch changed. A coarse film
    /// has one always: it is never the last word.
    fn denoise(&mut self, settings: &LiveSettings, frame: &mut Planned<'_>, recording: &mut Recording) {
        let kept_light = self.shown_light().map(KeptLight::picture);
        let shows_fine = match kept_light {
            Some(_) => self.schedule.is_covered(),
            None => self.schedule.shows_fine(),
        };
        let is_denoised = settings.denoise || kept_light.is_some() && shows_fine;
        if !is_denoised {
            self.fine.drop_denoised(&mut frame.gone);
        } else if shows_fine && let Some(pass) = self.fine.denoise(Grain::Fine, 1, kept_light, recording) {
            frame.push(pass);
        }
        let factor = self.schedule.factor();
        if let Some(coarse) = self.coarse.as_mut().filter(|_| self.schedule.has_coarse())
            && let Some(pass) = coarse.denoise(Grain::Coarse, factor, None, recording)
        {
            frame.push(pass);
        }
    }

    /// The picture of the films that are shown, the coarse one fading out behind the fine one.
    fn picture(
        &self,
        settings: &LiveSettings,
        host: &HostFrame,
        camera: &Camera,
        cache: &SceneCache,
    ) -> PicturePass {
        let fine = self.fine.shown(Grain::Fine);
        let coarse = self.shown_coarse().map(|film| film.shown(Grain::Coarse));
        let films = match coarse {
            _ if let Some(light) = self.shown_light() => {
                let is_whole = self.schedule.is_covered();
                PictureFilms::Kept { fine, light: light.picture(), is_whole }
            }
            Some(coarse) if !self.schedule.shows_fine() => PictureFilms::Coarse(coarse),
            Some(coarse) => PictureFilms::Both { fine, coarse },
            None => PictureFilms::Fine(fine),
        };
        PicturePass {
            films,
            is_denoised: settings.denoise || self.shown_light().is_some() && self.schedule.is_covered(),
            camera: *camera,
            farthest: cache.farthest(camera),
            exposure: settings.exposure * cache.light_scale(),
            host_depth: host.depth,
            any_texture: cache.environment_resources()[0],
            fog: host.fog,
            color: self.picture.color,
            depth: self.picture.depth,
        }
    }

    /// The picture over the host's.
    fn draw(&self, host: &HostFrame, frame: &mut Planned<'_>) {
        let PictureImages { color, depth } = self.picture;
        frame.push(DrawPass { image: color, target: host.color_target });
        if let Some(target) = host.depth_target.filter(|_| host.depth.is_some()) {
            frame.push(DrawPass { image: depth, target });
        }
    }
}

fn check(cache: &SceneCache, camera: &Camera, settings: &LiveSettings) -> Result<(), RenderError> {
    let [width, height] = settings.size;
    if width == 0 || height == 0 {
        return Err(RenderError::EmptyImage { width, height });
    }
    if !camera.is_valid() {
        return Err(RenderError::Camera);
    }
    PictureImages::check(settings.size, cache)
}

/// Begins an empty film of so many pixels.
fn begin(
    film: &mut Option<LiveFilm>,
    grain: Grain,
    size: [u32; 2],
    frame: &mut Planned<'_>,
    recording: &mut Recording,
) -> Result<(), RenderError> {
    let film = make_room(film, size, false, frame, recording)?;
    film.size = size;
    frame.push(film.clear(grain));
    Ok(())
}

/// Sees to it that there is a film of so many pixels, and of guides where they are wanted.
fn make_room<'a>(
    film: &'a mut Option<LiveFilm>,
    size: [u32; 2],
    guides: bool,
    frame: &mut Planned<'_>,
    recording: &mut Recording,
) -> Result<&'a mut LiveFilm, RenderError> {
    let lacks_room = |film: &LiveFilm| film.capacity < pixels(size) || guides && !film.has_guides;
    if film.as_ref().is_none_or(lacks_room) {
        let larger = LiveFilm::new(size, guides, frame.cache, recording)?;
        if let Some(small) = film.replace(larger) {
            // A pass of this frame may have it.
            small.free(&mut frame.gone);
        }
    }
    Ok(film.as_mut().expect("one is there, or was made"))
}
