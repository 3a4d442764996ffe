//! A view inside an engine's frame: traced within a budget, ended by the engine's depth, drawn over its colour.
//!
//! Two films make the picture. The fine one converges while nothing moves. When the camera or the scene changes and the
//! budget does not buy a fine image at once, a coarse one answers in the same frame, is shown alone until every fine
//! pixel has a sample, and fades out as more come in. What is shown of it is denoised and without outliers; while the fine
//! one takes long it gets more samples, and gives way to one of half its grain. Where only the engine's depth changes,
//! because a mesh moved, the pixels concerned start over and no others: every pixel counts its own samples, so a finished
//! live film is the film of a [`View`](crate::View), sample by sample. Where only light changes, and a little, the film follows
//! it (`changing_light`).

mod changing_light;
mod counts;
mod film;
mod fog;
mod host;
mod picture;
mod schedule;

use lumivox_core::Camera;
use lumivox_shaders::layout;

use self::changing_light::{Change, FrameLight, LightOfFilm};
use self::counts::{CountOfWhole, PathsOfScene};
use self::film::{LiveFilm, padded_height, pixels};
pub use self::fog::{DistanceFog, Fog, HeightFog};
pub use self::host::{HostDepth, HostFrame, LiveSettings, LiveStatus};
use self::picture::Picture;
use self::schedule::{Plan, Schedule, Which, Work};
use crate::error::RenderError;
use crate::film::Film;
use crate::noise_end::NoiseEnd;
use crate::recording::{Recording, ResourceId, Step};
use crate::scene_cache::SceneCache;

/// One view of an engine: a camera of a viewport, an eye of a headset. None knows of another.
///
/// `schedule` plans what is traced, `film` records that, `counts` holds what the GPU says of it frames later, and
/// `picture` makes of the films what is shown; this ties them together.
#[derive(Debug)]
pub struct LiveView {
    schedule: Schedule,
    fine: LiveFilm,
    coarse: Option<LiveFilm>,
    /// Half as coarse, and hidden until it is whole.
    finer: Option<LiveFilm>,
    picture: Picture,
    restarts: ResourceId,
    key: Option<Key>,
    light: LightOfFilm,
    /// Read-backs that have not come.
    awaited: u32,
    /// What the counts of the fine film say once it should be whole.
    count: CountOfWhole,
    /// What counts of the scene's films said.
    paths: PathsOfScene,
    /// Samples after which the image is done at the latest, and whether its noise ends it before.
    most_samples: u32,
    noise: NoiseEnd,
    /// Samples of the last frame's film, and those that it traces.
    target_samples: u32,
    pixel_samples: u64,
}

/// What a film shows, but for its light; another key, another image.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    camera: Camera,
    scene_version: u64,
    seed: u32,
    roulette_start: u32,
    /// Whether the host's surfaces end rays.
    has_depth: bool,
}

/// What is traced of it in a frame.
#[derive(Clone, Copy, Debug)]
struct Traced {
    key: Key,
    seed: u32,
    /// Radiance from everywhere besides the surroundings.
    ambient: [f32; 3],
}

impl LiveView {
    /// A view with an empty film.
    ///
    /// # Errors
    /// [`RenderError`] when the image has no pixel, or film or picture are larger than the device binds.
    pub fn new(
        settings: &LiveSettings,
        cache: &SceneCache,
        recording: &mut Recording,
    ) -> Result<Self, RenderError> {
        let [width, height] = settings.size;
        if width == 0 || height == 0 {
            return Err(RenderError::EmptyImage { width, height });
        }
        Picture::check(settings.size, cache)?;
        let most_samples = cache.limits().max_samples_per_dispatch;
        Ok(Self {
            schedule: Schedule::new(settings.film_size(), most_samples, settings.target_samples),
            fine: LiveFilm::new(settings.film_size(), cache, recording)?,
            picture: Picture::new(settings.size, recording),
            coarse: None,
            finer: None,
            restarts: recording.create_buffer("restarts", 16),
            key: None,
            light: LightOfFilm::default(),
            awaited: 0,
            count: CountOfWhole::default(),
            paths: PathsOfScene::default(),
            most_samples: settings.target_samples,
            noise: NoiseEnd::default(),
            target_samples: settings.target_samples,
            pixel_samples: 0,
        })
    }

    /// Records one frame: about `budget` pixel samples (eight rows at least, while any are missing), and the picture so
    /// far over the host's. Starts over if the camera, the scene, seed or roulette changed, or the host begins or ceases to give
    /// depth; makes new films if the size changed. Where light (or [ambient light](LiveSettings::ambient)) has changed a little,
    /// the film keeps a part of what it has, until that rests.
    ///
    /// The recording holds a [`Step::ReadBuffer`] where the host's depth is given, and another where the film should be
    /// whole and is counted, and one where it is looked at for its [noise](LiveSettings::target_noise). The bytes of each go to [`feedback`](Self::feedback) in their order, as soon as they are
    /// there: frames later if the host likes, but before it [rests](LiveStatus::awaits_feedback).
    ///
    /// # Errors
    /// [`RenderError`] when the image has no pixel, film or picture are larger than the device binds or the camera sees
    /// nothing; then nothing is recorded or changed.
    pub fn record_frame(
        &mut self,
        cache: &SceneCache,
        camera: &Camera,
        settings: &LiveSettings,
        host: &HostFrame,
        budget: u64,
        recording: &mut Recording,
    ) -> Result<LiveStatus, RenderError> {
        let [width, height] = settings.size;
        if width == 0 || height == 0 {
            return Err(RenderError::EmptyImage { width, height });
        }
        if !camera.is_valid() {
            return Err(RenderError::Camera);
        }
        Picture::check(settings.size, cache)?;
        if settings.film_size() != self.fine.size {
            let fine = LiveFilm::new(settings.film_size(), cache, recording)?;
            std::mem::replace(&mut self.fine, fine).free(recording);
            self.drop_coarse(recording);
            self.key = None;
        }
        if settings.size != self.picture.size() {
            let picture = Picture::new(settings.size, recording);
            std::mem::replace(&mut self.picture, picture).free(recording);
        }
        let key = Key {
            camera: *camera,
            scene_version: cache.version(),
            seed: settings.seed,
            roulette_start: settings.roulette_start,
            has_depth: host.depth.is_some(),
        };
        let light = FrameLight {
            past: cache.light_past(),
            // What is shown of it is scaled with the scene's light.
            ambient: settings
                .ambient
                .map(|c| if c.is_finite() { (c.max(0.0) / cache.light_scale()) as f32 } else { 0.0 }),
        };
        let change = self.light.follow(light);
        let was_held = self.schedule.is_held();
        let restarted = match self.key {
            Some(shown) => change == Change::Much || shown != key,
            None => true,
        };
        self.noise.set_target(settings.target_noise);
        if restarted {
            self.noise.restart();
        }
        self.most_samples = settings.target_samples;
        self.target_samples = self.noise.samples(self.most_samples);
        self.schedule.set_target(self.target_samples);
        if restarted {
            if self.key.is_none_or(|shown| shown.scene_version != key.scene_version) {
                self.paths.are_of_this_scene = false;
            }
            self.restart(budget, cache, recording)?;
            self.key = Some(key);
            self.light = LightOfFilm::new(light);
        } else if let Change::Little(kept) = change {
            self.fade(kept, budget, cache, recording)?;
        } else if self.schedule.is_covered() && self.light.rests(self.schedule.is_done()) {
            self.restart_behind(cache, recording)?;
            self.light = LightOfFilm::new(light);
        } else {
            self.begin_finer(budget, cache, recording)?;
        }
        let traced = Traced { seed: self.light.seed(key.seed), ambient: light.ambient, key };
        self.record_host_depth(host, cache.farthest(camera), recording);
        self.pixel_samples = if restarted && self.schedule.factor() > 1 {
            let plan = self.schedule.answer(budget);
            self.record_plan(&plan, traced, cache, recording);
            plan.pixel_samples
        } else {
            let plan = match change {
                Change::Little(_) => self.schedule.follow(budget / 2),
                _ => Plan::default(),
            };
            self.record_plan(&plan, traced, cache, recording);
            let more = self.record_refinement(traced, cache, budget - plan.pixel_samples, recording);
            plan.pixel_samples + more
        };
        if self.fine.unfinished.puts_aside() && self.pixel_samples > 0 {
            self.record_starved(traced, cache, recording);
        }
        if was_held && !self.schedule.is_held() {
            self.free_held(recording);
        }
        self.record_denoise(settings, recording);
        self.picture.record(self.shown(), settings, host, camera, cache, recording);
        Ok(self.status())
    }

    /// How far it is by what is known now.
    pub fn status(&self) -> LiveStatus {
        LiveStatus {
            samples: self.schedule.complete(),
            progress: self.progress(),
            converged: !self.is_open()
                && self.schedule.is_done()
                && self.is_counted_whole()
                && !self.light.is_mixed()
                && !self.schedule.has_coarse(),
            awaits_feedback: self.awaited > 0,
            pixel_samples: self.pixel_samples,
            lost_pixels: self.count.lost,
        }
    }

    /// Of all samples that may follow, as far as is known.
    fn progress(&self) -> f32 {
        let share = self.target_samples as f32 / self.most_samples.max(1) as f32;
        self.schedule.progress() * if self.is_open() { share } else { 1.0 }
    }

    /// Whether more samples may follow, for the sake of noise.
    fn is_open(&self) -> bool {
        self.noise.is_open(self.most_samples)
    }

    /// Whether the fine film, where it should be whole, is so by its last count. Until that comes the host must not
    /// rest, nor take its picture for done; where paths of the scene are put aside, pixels may have fewer samples than
    /// were traced by then, even none. What is known of other images counts for nothing here.
    fn is_counted_whole(&self) -> bool {
        let none_lags = !self.fine.unfinished.puts_aside();
        self.count.confirmed || none_lags && self.fine.unfinished.missing() == 0
    }

    /// Whether it most likely is: by what is known of the image before, too. Where meshes move, no count comes in time.
    fn seems_whole(&self) -> bool {
        let none_lags = self.paths.are_known && !self.paths.lag;
        self.is_counted_whole() || none_lags && self.fine.unfinished.missing() == 0
    }

    /// Takes the bytes of a read-back: how many pixels started over because the host's depth changed there, a count of the
    /// film, or the film. None, if it got lost.
    pub fn feedback(&mut self, bytes: &[u8]) {
        self.awaited = self.awaited.saturating_sub(1);
        if bytes.is_empty() {
            // Any pixel may have started over.
            self.start_over(pixels(self.fine.size));
            self.count.outdated = 0;
            self.noise.lost();
            return;
        }
        if bytes.len() as u64 == self.fine.read_bytes() {
            let [width, height] = self.fine.size;
            let mut film = Film::new(width, height, false);
            film.insert([0, 0], self.fine.size, bytes);
            self.noise.look(&film);
            return;
        }
        if bytes.len() == size_of::<layout::FilmCount>() {
            self.take_count(bytes);
            return;
        }
        let count = bytes.first_chunk().map_or(0, |b| u32::from_le_bytes(*b));
        if count > 0 {
            self.start_over(count.into());
        }
    }

    fn start_over(&mut self, count: u64) {
        self.count.forget();
        self.schedule.start_over(count);
    }

    fn take_count(&mut self, bytes: &[u8]) {
        if self.count.outdated > 0 {
            self.count.outdated -= 1;
            self.paths.learn(&bytemuck::pod_read_unaligned(bytes));
            return;
        }
        self.count.under_way = false;
        if let Err(RenderError::SamplesLost { pixels }) = self.fine.unfinished.counted(bytes) {
            self.count.lost = pixels;
        }
        self.count.confirmed = self.fine.unfinished.missing() == 0;
    }

    /// What is shown is looked at long before it is whole: paths that starve would be missing from it all the while. Takes
    /// them up where some are known to be, and has others found.
    fn record_starved(&mut self, traced: Traced, cache: &SceneCache, recording: &mut Recording) {
        let (samples, target) = (self.schedule.pass_samples(), self.target_samples);
        let shows_fine = self.schedule.shows_fine();
        let Some(shown) = (if shows_fine { Some(&mut self.fine) } else { self.coarse.as_mut() }) else {
            return;
        };
        if self.count.outdated == 0
            && !self.count.under_way
            && !(self.paths.are_of_this_scene && self.paths.starve)
        {
            shown.record_count(target, recording);
            self.count.outdated = 1;
            self.awaited += 1;
        }
        if self.paths.starve {
            shown.record_starved(traced, cache, samples, target, recording);
            shown.stale = true;
        }
    }

    /// Has a fine film that should be whole counted, and what was found missing traced. Returns how many samples.
    fn record_confirmation(&mut self, traced: Traced, cache: &SceneCache, recording: &mut Recording) -> u64 {
        if self.count.confirmed || self.count.under_way {
            return 0;
        }
        let mut recorded = 0;
        let target = self.target_samples;
        if self.fine.unfinished.begin_retry() {
            recorded = u64::from(self.fine.unfinished.missing());
            let rows = [0, padded_height(self.fine.size)];
            self.fine.record_samples(traced, cache, target, target, rows, recording);
        }
        self.fine.record_count(target, recording);
        self.count.under_way = true;
        self.awaited += 1;
        recorded
    }

    /// Begins an empty image, as coarse as the budget demands.
    fn restart(
        &mut self,
        budget: u64,
        cache: &SceneCache,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        let schedule = self.schedule.restarted(self.fine.size, budget, self.key.is_some());
        if let Some(size) = schedule.coarse_size() {
            make_room(&mut self.coarse, size, cache, recording)?;
        }
        self.schedule = schedule;
        if let Some((coarse, size)) = self.coarse.as_mut().zip(self.schedule.coarse_size()) {
            coarse.size = size;
            coarse.clear(recording);
        }
        self.fine.clear(recording);
        self.count.forget();
        Ok(())
    }

    /// Keeps a part of the image, for its light has changed a little.
    fn fade(
        &mut self,
        [kept, scale]: [f64; 2],
        budget: u64,
        cache: &SceneCache,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        let kept = self.schedule.kept_of_frames(kept, budget);
        for film in self.live_films() {
            film.record_fade([kept, scale], recording);
        }
        let coarse = self.schedule.fade(kept, budget);
        self.count.forget();
        self.noise.restart();
        if let Some(size) = coarse {
            make_room(&mut self.coarse, size, cache, recording)?;
            if let Some(coarse) = &mut self.coarse {
                coarse.size = size;
                coarse.clear(recording);
            }
        }
        Ok(())
    }

    /// Begins an empty image, before which this one stays to be seen until that is as good.
    fn restart_behind(&mut self, cache: &SceneCache, recording: &mut Recording) -> Result<(), RenderError> {
        make_room(&mut self.coarse, self.fine.size, cache, recording)?;
        if let Some(held) = &mut self.coarse {
            held.size = self.fine.size;
            std::mem::swap(held, &mut self.fine);
        }
        self.schedule = self.schedule.restarted_behind();
        self.fine.clear(recording);
        self.count.forget();
        self.noise.restart();
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
        cache: &SceneCache,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        let Some(size) = self.schedule.finer_to_begin(budget) else { return Ok(()) };
        make_room(&mut self.finer, size, cache, recording)?;
        if let Some(finer) = &mut self.finer {
            finer.size = size;
            finer.clear(recording);
            self.schedule.begin_finer();
        }
        Ok(())
    }

    fn drop_coarse(&mut self, recording: &mut Recording) {
        for film in [self.coarse.take(), self.finer.take()].into_iter().flatten() {
            film.free(recording);
        }
        self.schedule.drop_coarse();
    }

    /// The films that samples go into.
    fn live_films(&mut self) -> impl Iterator<Item = &mut LiveFilm> {
        let coarse = self.coarse.as_mut().filter(|_| self.schedule.has_coarse());
        let finer = self.finer.as_mut().filter(|_| self.schedule.fills_finer());
        [Some(&mut self.fine), coarse, finer].into_iter().flatten()
    }

    /// The coarse film, while samples go into it.
    fn live_coarse(&self) -> Option<&LiveFilm> {
        self.coarse.as_ref().filter(|_| self.schedule.has_coarse())
    }

    fn record_host_depth(&mut self, host: &HostFrame, farthest: f64, recording: &mut Recording) {
        recording.push(Step::ClearBuffer { id: self.restarts });
        // Without depth no ray ends, nor does any of an empty film; whether there is any is part of the key.
        let Some(depth) = host.depth else { return };
        let restarts = self.restarts;
        for film in self.live_films() {
            film.record_host_depth(&depth, farthest, restarts, recording);
        }
        recording.push(Step::ReadBuffer { id: self.restarts, range: 0..4 });
        self.awaited += 1;
    }

    /// More samples of the same image, and what its counts ask for once it should be whole; returns how many.
    fn record_refinement(
        &mut self,
        traced: Traced,
        cache: &SceneCache,
        budget: u64,
        recording: &mut Recording,
    ) -> u64 {
        let plan = self.schedule.refine(budget);
        self.record_plan(&plan, traced, cache, recording);
        let missing = match self.schedule.is_done() {
            true => self.record_confirmation(traced, cache, recording),
            false => 0,
        };
        let is_still = self.schedule.is_done() && plan.pixel_samples + missing == 0;
        let is_whole = self.is_counted_whole() && !self.light.is_mixed();
        if is_still && is_whole && self.noise.begin_look(self.most_samples) {
            self.fine.record_read(recording);
            self.awaited += 1;
        }
        if self.seems_whole() {
            self.schedule.retire_coarse(self.is_open());
        }
        self.fine.stale |= plan.pixel_samples > 0 || missing > 0;
        plan.pixel_samples + missing
    }

    fn record_plan(&mut self, plan: &Plan, traced: Traced, cache: &SceneCache, recording: &mut Recording) {
        for &work in &plan.works {
            match work {
                Work::Replace => std::mem::swap(&mut self.finer, &mut self.coarse),
                Work::AllCoarse { samples } => {
                    if let Some(coarse) = self.film(Which::Coarse) {
                        coarse.record_all(traced, cache, samples, recording);
                        coarse.stale = true;
                    }
                }
                Work::FirstAid { film, samples, below } => {
                    // Where it only shows through it is not denoised anew for a few pixels.
                    let is_alone = !self.schedule.is_covered();
                    if let Some(film) = self.film(film) {
                        film.record_first_aid(traced, cache, samples, below, recording);
                        film.stale |= is_alone;
                    }
                }
                Work::Samples { film, samples, limit, rows } => {
                    if film == Which::Fine {
                        self.count.forget();
                    }
                    if let Some(film) = self.film(film) {
                        film.record_samples(traced, cache, samples, limit, rows, recording);
                        film.stale = true;
                    }
                }
            }
        }
    }

    fn film(&mut self, which: Which) -> Option<&mut LiveFilm> {
        match which {
            Which::Fine => Some(&mut self.fine),
            Which::Coarse => self.coarse.as_mut(),
            Which::Finer => self.finer.as_mut(),
        }
    }

    /// The denoiser's pixels of every film that is shown, made anew where samples or the switch changed. A coarse film
    /// has them always: it is never the last word.
    fn record_denoise(&mut self, settings: &LiveSettings, recording: &mut Recording) {
        if !settings.denoise {
            self.fine.drop_denoised(recording);
        } else if self.schedule.shows_fine() {
            self.fine.record_denoise(1, recording);
        }
        if let Some(coarse) = self.coarse.as_mut().filter(|_| self.schedule.has_coarse()) {
            coarse.record_denoise(self.schedule.factor(), recording);
        }
    }

    /// The films that make the picture, the second fading out behind the first.
    fn shown(&self) -> picture::Films<'_> {
        match self.live_coarse() {
            Some(coarse) if !self.schedule.shows_fine() => picture::Films::Coarse(coarse),
            Some(coarse) => picture::Films::Both { fine: &self.fine, coarse },
            None => picture::Films::Fine(&self.fine),
        }
    }

    /// Records that the fine film comes back, for [`Film::insert`](crate::Film::insert).
    pub fn record_read_film(&self, recording: &mut Recording) {
        self.fine.record_read(recording);
    }

    /// The same of the coarse film, while there is one; returns its pixels across and down.
    pub fn record_read_coarse_film(&self, recording: &mut Recording) -> Option<[u32; 2]> {
        let coarse = self.live_coarse()?;
        coarse.record_read(recording);
        Some(coarse.size)
    }

    /// Pixels of the fine film.
    pub fn film_size(&self) -> [u32; 2] {
        self.fine.size
    }

    /// Records that everything is freed.
    pub fn free(mut self, recording: &mut Recording) {
        self.drop_coarse(recording);
        self.fine.free(recording);
        self.picture.free(recording);
        recording.push(Step::Free { id: self.restarts });
    }
}

/// Sees to it that there is a film of so many pixels.
fn make_room(
    film: &mut Option<LiveFilm>,
    size: [u32; 2],
    cache: &SceneCache,
    recording: &mut Recording,
) -> Result<(), RenderError> {
    if film.as_ref().is_none_or(|film| film.capacity < pixels(size)) {
        let larger = LiveFilm::new(size, cache, recording)?;
        if let Some(small) = film.replace(larger) {
            small.free(recording);
        }
    }
    Ok(())
}
