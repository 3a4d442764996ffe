//! A view inside an engine's frame: traced within a budget, ended by the engine's depth, drawn over its colour.
//!
//! Two films make the picture. The fine one converges while nothing moves. When the camera or the scene changes and the
//! budget does not buy a fine image at once, a coarse one answers in the same frame, is shown alone until every fine
//! pixel has a sample, and fades out as more come in. What is shown of it is denoised and without outliers; while the fine
//! one takes long it gets more samples, and gives way to one of half its grain. Where only the engine's depth changes,
//! because a mesh moved, the pixels concerned start over and no others: every pixel counts its own samples, so a finished
//! live film is the film of a [`View`](crate::View), sample by sample.

mod counts;
mod film;
mod fog;
mod host;
mod picture;

use lumivox_core::Camera;
use lumivox_shaders::constants::FINE_ALONE;
use lumivox_shaders::layout;

use self::counts::{CountOfWhole, PathsOfScene};
use self::film::{GROUP_ROWS, LiveFilm, pixels};
pub use self::fog::{DistanceFog, Fog, HeightFog};
pub use self::host::{HostDepth, HostFrame, LiveSettings, LiveStatus};
use self::picture::Picture;
use crate::error::RenderError;
use crate::recording::{Recording, ResourceId, Step};
use crate::scene_cache::SceneCache;

/// Pixels along a side of the fine film that share one of the coarse film, at most.
const COARSEST: u32 = 8;

/// Samples that a pixel gets at once where the host's depth changed.
const FIRST_AID: u32 = 4;

/// Samples of a coarse pixel that are worth halving its film's resolution for.
const LEAST_COARSE_SAMPLES: u64 = 2;

/// A first fine image that is done in so many frames needs no better coarse one until then.
const SOON_FRAMES: f64 = 4.0;

/// The share of the budget after which the coarse film gets no more in a frame.
const COARSE_SHARE: f64 = 0.9;

/// Samples that a coarse pixel gets at most while the first fine image takes longer, before a finer film follows. They
/// are a quarter of a fine pass.
fn most_coarse_samples(factor: u32) -> u32 {
    (factor * factor / 4).max(LEAST_COARSE_SAMPLES as u32)
}

/// One view of an engine: a camera of a viewport, an eye of a headset. None knows of another.
#[derive(Debug)]
pub struct LiveView {
    fine: LiveFilm,
    coarse: Option<LiveFilm>,
    /// Half as coarse, and hidden until it is whole; its next row while it is filled.
    finer: Option<LiveFilm>,
    finer_row: Option<u32>,
    picture: Picture,
    restarts: ResourceId,
    key: Option<Key>,
    /// Fine pixels along a side of a coarse one; 1 while no coarse film is shown.
    factor: u32,
    /// Samples that every pixel of the coarse film has, and the next row that gets one more.
    coarse_complete: u32,
    coarse_row: u32,
    /// Samples that every pixel of the fine film has.
    complete: u32,
    /// Samples that every pixel has that never started over.
    common: u32,
    pass_samples: u32,
    /// In the order in which rows are traced, see [`LiveFilm::padded_height`].
    next_row: u32,
    /// Whether every pixel of the fine film has had a sample since the film was empty.
    covered: bool,
    /// Some pixel started over while a pass was under way: when the pass ends, no count of samples holds for all.
    restarted_in_pass: bool,
    /// Pixels that lack samples, as far as is known: what a pass costs.
    open_pixels: u64,
    /// Read-backs that have not come.
    awaited: u32,
    /// What the counts of the fine film say once it should be whole.
    count: CountOfWhole,
    /// What counts of the scene's films said.
    paths: PathsOfScene,
    /// Of the last frame: the samples after which it is done, and those that it traces.
    target_samples: u32,
    pixel_samples: u64,
}

/// What a film shows; another key, another image.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    camera: Camera,
    scene_version: u64,
    ambient: [f32; 3],
    seed: u32,
    roulette_start: u32,
    /// Whether the host's surfaces end rays.
    has_depth: bool,
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
        Ok(Self {
            fine: LiveFilm::new(settings.film_size(), cache, recording)?,
            picture: Picture::new(settings.size, recording),
            coarse: None,
            finer: None,
            finer_row: None,
            restarts: recording.create_buffer("restarts", 16),
            key: None,
            factor: 1,
            coarse_complete: 0,
            coarse_row: 0,
            complete: 0,
            common: 0,
            pass_samples: 0,
            next_row: 0,
            covered: false,
            restarted_in_pass: false,
            open_pixels: 0,
            awaited: 0,
            count: CountOfWhole::default(),
            paths: PathsOfScene::default(),
            target_samples: settings.target_samples,
            pixel_samples: 0,
        })
    }

    /// Records one frame: about `budget` pixel samples (eight rows at least, while any are missing), and the picture so
    /// far over the host's. Starts over if the camera, the scene, [ambient light](LiveSettings::ambient), seed or roulette
    /// changed, or the host begins or ceases to give depth; makes new films if the size changed.
    ///
    /// The recording holds a [`Step::ReadBuffer`] where the host's depth is given, and another where the film should be
    /// whole and is counted. The bytes of each go to [`feedback`](Self::feedback) in their order, as soon as they are
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
        if settings.target_samples > self.target_samples {
            // However few of them were open.
            self.open_pixels = pixels(self.fine.size);
        }
        self.target_samples = settings.target_samples;
        let key = Key {
            camera: *camera,
            scene_version: cache.version(),
            ambient: settings.ambient.map(|c| if c.is_finite() { c.max(0.0) as f32 } else { 0.0 }),
            seed: settings.seed,
            roulette_start: settings.roulette_start,
            has_depth: host.depth.is_some(),
        };
        let restarted = self.key != Some(key);
        if restarted {
            if self.key.is_none_or(|shown| shown.scene_version != key.scene_version) {
                self.paths.are_of_this_scene = false;
            }
            self.restart(budget, cache, recording)?;
            self.key = Some(key);
        } else {
            self.begin_finer(budget, cache, recording)?;
        }
        self.record_host_depth(host, restarted, recording);
        let coarse_only = restarted && self.factor > 1;
        self.pixel_samples = if coarse_only {
            self.record_coarse(key, cache, budget, recording)
        } else {
            self.record_fine(key, cache, settings.target_samples, budget, recording)
        };
        if self.fine.unfinished.puts_aside() && self.pixel_samples > 0 {
            self.record_starved(key, cache, recording);
        }
        self.record_denoise(settings, recording);
        self.picture.record(self.shown(), settings, host, camera, cache, recording);
        Ok(self.status())
    }

    /// How far it is by what is known now.
    pub fn status(&self) -> LiveStatus {
        LiveStatus {
            samples: self.complete.min(self.target_samples),
            converged: self.complete >= self.target_samples && self.is_whole() && self.factor == 1,
            awaits_feedback: self.awaited > 0,
            pixel_samples: self.pixel_samples,
            lost_pixels: self.count.lost,
        }
    }

    /// Whether the fine film, where it should be whole, is so by its last count. Until that comes the host must not
    /// rest; where paths of the scene are put aside, pixels may have fewer samples than were traced by then, even none.
    fn is_whole(&self) -> bool {
        let none_lags = self.paths.are_known && !self.paths.lag || !self.fine.unfinished.puts_aside();
        self.count.confirmed || none_lags && self.fine.unfinished.missing() == 0
    }

    /// Takes the bytes of a read-back: how many pixels started over because the host's depth changed there, or a count
    /// of the film. None, if it got lost.
    pub fn feedback(&mut self, bytes: &[u8]) {
        self.awaited = self.awaited.saturating_sub(1);
        if bytes.is_empty() {
            // Any pixel may have started over.
            self.open_pixels = pixels(self.fine.size);
            self.some_started_over();
            self.count.outdated = 0;
            return;
        }
        if bytes.len() == size_of::<layout::FilmCount>() {
            self.take_count(bytes);
            return;
        }
        let count = bytes.first_chunk().map_or(0, |b| u32::from_le_bytes(*b));
        if count == 0 {
            return;
        }
        // Only those cost anything from here on, unless others are still missing.
        let open = if self.complete >= self.target_samples { 0 } else { self.open_pixels };
        self.open_pixels = (open + u64::from(count)).min(pixels(self.fine.size));
        self.some_started_over();
    }

    /// No count of samples holds for all pixels any more.
    fn some_started_over(&mut self) {
        self.count.forget();
        if self.next_row == 0 {
            self.complete = 0;
        } else {
            self.restarted_in_pass = true;
        }
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
    fn record_starved(&mut self, key: Key, cache: &SceneCache, recording: &mut Recording) {
        let (samples, target) = (self.pass_samples.max(1), self.target_samples);
        let shows_fine = self.shows_fine();
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
            shown.record_starved(key, cache, samples, target, recording);
            shown.stale = true;
        }
    }

    /// Has a fine film that should be whole counted, and what was found missing traced. Returns how many samples.
    fn record_confirmation(
        &mut self,
        key: Key,
        cache: &SceneCache,
        target: u32,
        recording: &mut Recording,
    ) -> u64 {
        if self.count.confirmed || self.count.under_way {
            return 0;
        }
        let mut recorded = 0;
        if self.fine.unfinished.begin_retry() {
            recorded = u64::from(self.fine.unfinished.missing());
            let rows = [0, self.fine.padded_height()];
            self.fine.record_samples(key, cache, target, target, rows, recording);
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
        let size = self.fine.size;
        let coarse_size = |factor: u32| size.map(|n| n.div_ceil(factor));
        let affords = |factor: u32| pixels(coarse_size(factor)) * LEAST_COARSE_SAMPLES <= budget;
        // A finer film than the last has to be well affordable, or the picture's grain would jump to and fro.
        let affords_easily = |factor: u32| pixels(coarse_size(factor)) * LEAST_COARSE_SAMPLES * 2 <= budget;
        let mut factor = 1;
        while factor < COARSEST
            && !(if self.key.is_some() && factor < self.factor {
                affords_easily(factor)
            } else {
                affords(factor)
            })
        {
            factor *= 2;
        }
        if factor > 1 {
            let wanted = coarse_size(factor);
            if self.coarse.as_ref().is_none_or(|c| c.capacity < pixels(wanted)) {
                let film = LiveFilm::new(wanted, cache, recording)?;
                self.drop_coarse(recording);
                self.coarse = Some(film);
            }
        }
        self.factor = factor;
        if let Some(coarse) = self.coarse.as_mut().filter(|_| factor > 1) {
            coarse.size = coarse_size(factor);
            coarse.clear(recording);
        }
        self.fine.clear(recording);
        (self.complete, self.common, self.pass_samples, self.next_row) = (0, 0, 0, 0);
        (self.covered, self.restarted_in_pass) = (false, false);
        self.open_pixels = pixels(size);
        self.finer_row = None;
        self.count.forget();
        Ok(())
    }

    /// Begins a film of half the coarse one's grain, if that has enough samples and the fine one is far.
    fn begin_finer(
        &mut self,
        budget: u64,
        cache: &SceneCache,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        let has_enough = self.coarse_complete >= most_coarse_samples(self.factor);
        if self.factor <= 2 || self.finer_row.is_some() || !has_enough || !self.fine_is_far(budget) {
            return Ok(());
        }
        let size = self.fine.size.map(|n| n.div_ceil(self.factor / 2));
        if self.finer.as_ref().is_none_or(|film| film.capacity < pixels(size)) {
            let film = LiveFilm::new(size, cache, recording)?;
            if let Some(small) = self.finer.replace(film) {
                small.free(recording);
            }
        }
        if let Some(finer) = &mut self.finer {
            finer.size = size;
            finer.clear(recording);
            // Of an image before, when there may have been depth.
            recording.push(Step::ClearBuffer { id: finer.limits });
            self.finer_row = Some(0);
        }
        Ok(())
    }

    /// Pixels that lack samples in a row of the fine film, about: those where none are missing cost next to nothing.
    fn open_pixels_per_row(&self) -> f64 {
        self.open_pixels.clamp(1, pixels(self.fine.size)) as f64 / f64::from(self.fine.padded_height())
    }

    /// Whether the first fine image takes so long that the coarse one is to get better until then.
    fn fine_is_far(&self, budget: u64) -> bool {
        let rows_left = self.fine.padded_height() - self.next_row;
        self.factor > 1
            && !self.covered
            && self.open_pixels_per_row() * f64::from(rows_left) > SOON_FRAMES * budget as f64
    }

    fn drop_coarse(&mut self, recording: &mut Recording) {
        for film in [self.coarse.take(), self.finer.take()].into_iter().flatten() {
            film.free(recording);
        }
        self.finer_row = None;
        self.factor = 1;
    }

    /// The films that samples go into.
    fn live_films(&mut self) -> impl Iterator<Item = &mut LiveFilm> {
        let coarse = self.coarse.as_mut().filter(|_| self.factor > 1);
        let finer = self.finer.as_mut().filter(|_| self.finer_row.is_some());
        [Some(&mut self.fine), coarse, finer].into_iter().flatten()
    }

    /// The coarse film, while samples go into it.
    fn live_coarse(&self) -> Option<&LiveFilm> {
        self.coarse.as_ref().filter(|_| self.factor > 1)
    }

    /// Not while it has holes: bands of sharp rows would wander through the coarse picture.
    fn shows_fine(&self) -> bool {
        self.covered || self.factor == 1
    }

    fn record_host_depth(&mut self, host: &HostFrame, restarted: bool, recording: &mut Recording) {
        recording.push(Step::ClearBuffer { id: self.restarts });
        let Some(depth) = host.depth else {
            // Without depth no ray ends; whether there is any is part of the key.
            for film in self.live_films().filter(|_| restarted) {
                recording.push(Step::ClearBuffer { id: film.limits });
            }
            return;
        };
        let restarts = self.restarts;
        for film in self.live_films() {
            film.record_host_depth(&depth, restarts, recording);
        }
        recording.push(Step::ReadBuffer { id: self.restarts, range: 0..4 });
        self.awaited += 1;
    }

    /// All of the coarse film, as often as the budget allows.
    fn record_coarse(&mut self, key: Key, cache: &SceneCache, budget: u64, recording: &mut Recording) -> u64 {
        let Some(coarse) = &mut self.coarse else { return 0 };
        let area = pixels(coarse.size);
        let samples = (budget / area).clamp(1, u64::from(cache.limits().max_samples_per_dispatch)) as u32;
        coarse.record_all(key, cache, samples, recording);
        coarse.stale = true;
        (self.coarse_complete, self.coarse_row) = (samples, 0);
        area * u64::from(samples)
    }

    /// More samples for the coarse film while it is all that is shown; returns how many.
    fn record_more_coarse(
        &mut self,
        key: Key,
        cache: &SceneCache,
        budget: u64,
        recording: &mut Recording,
    ) -> u64 {
        let Some(coarse) = self.coarse.as_mut().filter(|_| self.factor > 1) else { return 0 };
        let most = most_coarse_samples(self.factor);
        if self.coarse_complete >= most {
            return self.record_finer(key, cache, budget, recording);
        }
        let height = coarse.padded_height();
        let row = pixels(coarse.size) as f64 / f64::from(height);
        let rows = (budget as f64 / row) as u32 / GROUP_ROWS * GROUP_ROWS;
        let rows = rows.clamp(GROUP_ROWS, height - self.coarse_row);
        let band = [self.coarse_row, self.coarse_row + rows];
        coarse.record_samples(key, cache, 1, most, band, recording);
        coarse.stale = true;
        self.coarse_row += rows;
        if self.coarse_row == height {
            (self.coarse_row, self.coarse_complete) = (0, self.coarse_complete + 1);
        }
        (row * f64::from(rows)) as u64
    }

    /// Rows of the film that follows the coarse one, which it replaces with its last; returns how many samples.
    fn record_finer(&mut self, key: Key, cache: &SceneCache, budget: u64, recording: &mut Recording) -> u64 {
        let (Some(finer), Some(begin)) = (&mut self.finer, self.finer_row) else { return 0 };
        let samples = LEAST_COARSE_SAMPLES as u32;
        let height = finer.padded_height();
        let row = (pixels(finer.size) * LEAST_COARSE_SAMPLES) as f64 / f64::from(height);
        let rows = (budget as f64 / row) as u32 / GROUP_ROWS * GROUP_ROWS;
        let end = begin + rows.clamp(GROUP_ROWS, height - begin);
        finer.record_samples(key, cache, samples, samples, [begin, end], recording);
        self.finer_row = Some(end).filter(|&end| end < height);
        if self.finer_row.is_none() {
            // What started over on the way is no hole.
            finer.record_samples(key, cache, samples, samples, [0, height], recording);
            std::mem::swap(&mut self.finer, &mut self.coarse);
            self.factor /= 2;
            (self.coarse_complete, self.coarse_row) = (samples, 0);
        }
        (row * f64::from(end - begin)) as u64
    }

    /// Rows of the fine film, as many as the budget allows.
    fn record_fine(
        &mut self,
        key: Key,
        cache: &SceneCache,
        target: u32,
        budget: u64,
        recording: &mut Recording,
    ) -> u64 {
        let height = self.fine.padded_height();
        let row = self.open_pixels_per_row();
        let mut recorded = 0.0;
        // What started over in this very frame must not be a hole in the picture. Other pixels only look, and return.
        let samples = FIRST_AID.min(target);
        if self.covered {
            self.fine.record_first_aid(key, cache, samples, self.common, recording);
            if let Some(coarse) = self.coarse.as_mut().filter(|_| self.factor > 1) {
                // It still shows through.
                coarse.record_first_aid(key, cache, samples, self.coarse_complete.max(1), recording);
            }
        } else if let Some(coarse) = self.coarse.as_mut().filter(|_| self.factor > 1) {
            coarse.record_first_aid(key, cache, samples, self.coarse_complete.max(1), recording);
            coarse.stale = true;
            // All of the budget, but for what buys no whole group of rows.
            while self.fine_is_far(budget) && recorded < COARSE_SHARE * budget as f64 {
                let left = budget - recorded as u64;
                match self.record_more_coarse(key, cache, left, recording) {
                    0 => break,
                    more => recorded += more as f64,
                }
            }
        }
        let budget = budget as f64;
        while self.complete < target {
            let affordable = budget - recorded;
            if self.next_row == 0 {
                let left = u64::from(target - self.complete);
                let passes = (affordable / (row * f64::from(height))) as u64;
                self.pass_samples =
                    passes.clamp(1, left.min(u64::from(cache.limits().max_samples_per_dispatch))) as u32;
            }
            let rows = (affordable / (row * f64::from(self.pass_samples))) as u32;
            let rows = (rows / GROUP_ROWS * GROUP_ROWS).min(height - self.next_row);
            if rows == 0 && recorded > 0.0 {
                break;
            }
            // A group is the least that is done, however small the budget: it makes progress.
            let rows = rows.max(GROUP_ROWS);
            let band = [self.next_row, self.next_row + rows];
            self.fine.record_samples(key, cache, self.pass_samples, target, band, recording);
            self.count.forget();
            recorded += row * f64::from(rows) * f64::from(self.pass_samples);
            self.next_row += rows;
            if self.next_row == height {
                self.next_row = 0;
                self.covered = true;
                self.finer_row = None;
                self.common += self.pass_samples;
                self.complete = if self.restarted_in_pass { 0 } else { self.complete + self.pass_samples };
                self.restarted_in_pass = false;
            }
            if recorded >= budget {
                break;
            }
        }
        let missing = match self.complete >= target {
            true => self.record_confirmation(key, cache, target, recording),
            false => 0,
        };
        // A finished picture must not depend on what was shown before it.
        if self.complete >= FINE_ALONE.min(target) && self.is_whole() {
            self.factor = 1;
        }
        self.fine.stale |= recorded > 0.0 || missing > 0;
        recorded.round() as u64 + missing
    }

    /// The denoiser's pixels of every film that is shown, made anew where samples or the switch changed. A coarse film
    /// has them always: it is never the last word.
    fn record_denoise(&mut self, settings: &LiveSettings, recording: &mut Recording) {
        if !settings.denoise {
            self.fine.drop_denoised(recording);
        } else if self.shows_fine() {
            self.fine.record_denoise(1, recording);
        }
        if let Some(coarse) = self.coarse.as_mut().filter(|_| self.factor > 1) {
            coarse.record_denoise(self.factor, recording);
        }
    }

    /// The films that make the picture, the second fading out behind the first.
    fn shown(&self) -> picture::Films<'_> {
        match self.live_coarse() {
            Some(coarse) if !self.shows_fine() => picture::Films::Coarse(coarse),
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
