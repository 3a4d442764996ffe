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
mod frame;
mod host;
mod images;
mod light;
mod light_cells;
mod looks;
pub mod passes;
mod reprojection;
mod schedule;
mod velocity;

use lumivox_core::Camera;
use lumivox_shaders::constants::KEPT_LIGHT_UNTIL;
use lumivox_shaders::layout;

use self::changing_light::LightOfFilm;
use self::counts::{CountOfWhole, PathsOfScene};
use self::film::LiveFilm;
pub use self::fog::{DistanceFog, Fog, HeightFog};
pub use self::frame::LiveFrame;
pub use self::host::{HostDepth, HostFrame, HostVelocity, LiveSettings, LiveStatus};
pub use self::images::{FilmImages, Grain, Image, LiveImage, PixelFormat};
use self::images::{PictureImages, pixels};
use self::light::KeptLight;
pub use self::light::LightFields;
pub(crate) use self::light_cells::CellsOfScene;
use self::reprojection::Seen;
use self::schedule::Schedule;
use crate::error::RenderError;
use crate::film::Film;
use crate::noise_end::NoiseEnd;
use crate::recording::{Recording, ResourceId, Step};
use crate::scene_cache::SceneCache;

/// One view of an engine: a camera of a viewport, an eye of a headset. None knows of another, but for the light that is
/// [kept](LiveSettings::kept_light) in a scene's volumes, which those of one [`SceneCache`] share that see it alike.
///
/// A frame is a list of [passes](passes::FramePass) over [images](LiveImage) that have names: `schedule` plans what is traced,
/// `frame` makes the list, `counts` holds what the GPU says of the films frames later.
#[derive(Debug)]
pub struct LiveView {
    schedule: Schedule,
    fine: LiveFilm,
    coarse: Option<LiveFilm>,
    /// Half as coarse, and hidden until it is whole.
    finer: Option<LiveFilm>,
    picture: PictureImages,
    /// Shown while the fine film has few samples.
    kept_light: Option<KeptLight>,
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
    /// What the last frame showed, where a host wants to know how far that has moved.
    seen: Option<Seen>,
    /// Another view that shares light taught it in the last frame, which moved.
    awaits_turn: bool,
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

impl Key {
    fn new(cache: &SceneCache, camera: &Camera, settings: &LiveSettings, host: &HostFrame) -> Self {
        Self {
            camera: *camera,
            scene_version: cache.version(),
            seed: settings.seed,
            roulette_start: settings.roulette_start,
            has_depth: host.depth.is_some(),
        }
    }
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
        PictureImages::check(settings.size, cache)?;
        let most_samples = cache.limits().max_samples_per_dispatch;
        Ok(Self {
            schedule: Schedule::new(settings.film_size(), most_samples, settings.target_samples),
            fine: LiveFilm::new(settings.film_size(), settings.guides, cache, recording)?,
            picture: PictureImages::new(settings.size, recording),
            coarse: None,
            finer: None,
            kept_light: None,
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
            awaits_turn: false,
            seen: None,
        })
    }

    /// Records one frame: about `budget` pixel samples (eight rows at least, while any are missing), and the picture so
    /// far over the host's. Starts over if the camera, the scene, seed or roulette changed, or the host begins or ceases to give
    /// depth; makes new films if the size changed, or whether they keep guides. Where light (or [ambient light](LiveSettings::ambient)) has changed a little,
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
        let frame = self.plan_frame(cache, camera, settings, host, budget, recording)?;
        let status = frame.status;
        frame.record(recording);
        Ok(status)
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
            awaits_turn: self.awaits_turn,
            lost_pixels: self.count.lost,
            light_bytes: self.kept_light.as_ref().map_or(0, KeptLight::bytes),
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
        if bytes.len() as u64 == self.read_bytes() {
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

    /// Those of the film that is looked at for its noise.
    fn read_bytes(&self) -> u64 {
        let bytes = self.fine.images(Grain::Fine).film().bytes();
        bytes.end - bytes.start
    }

    fn start_over(&mut self, count: u64) {
        self.count.forget();
        self.schedule.start_over(count);
        if let Some(light) = &mut self.kept_light {
            // What stands before it is another.
            light.looks().look_again();
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

    fn drop_coarse(&mut self, recording: &mut Recording) {
        for film in [self.coarse.take(), self.finer.take()].into_iter().flatten() {
            film.free(recording);
        }
        self.schedule.drop_coarse();
    }

    /// The coarse film, while it is shown.
    fn shown_coarse(&self) -> Option<&LiveFilm> {
        self.coarse.as_ref().filter(|_| self.schedule.has_coarse())
    }

    /// The light that is kept, while it is shown.
    fn shown_light(&self) -> Option<&KeptLight> {
        // Not where the image before has its place, which is better.
        let is_wanted = !self.schedule.is_held() && !self.schedule.is_done();
        let is_wanted = is_wanted && self.schedule.complete() < KEPT_LIGHT_UNTIL;
        self.kept_light.as_ref().filter(|light| is_wanted && light.is_filled())
    }

    /// Where an image lies that holds something now, for a host that binds it. That is so until the next frame is planned.
    pub fn image(&self, name: LiveImage) -> Option<Image> {
        let film = |grain| match grain {
            Grain::Fine => Some(&self.fine),
            Grain::Coarse => self.shown_coarse(),
            Grain::Finer => self.finer.as_ref().filter(|_| self.schedule.fills_finer()),
            Grain::Points => None,
        };
        match name {
            LiveImage::Film(grain) => Some(film(grain)?.images(grain).film()),
            LiveImage::RayLimits(grain) => Some(film(grain)?.images(grain).ray_limits()),
            LiveImage::Denoised(grain) => film(grain)?.denoised(grain),
            LiveImage::Albedo => Some(self.fine.images(Grain::Fine).guides()?[0]),
            LiveImage::Normal => Some(self.fine.images(Grain::Fine).guides()?[1]),
            LiveImage::KeptLight => Some(self.shown_light()?.picture()),
            LiveImage::Color => Some(self.picture.color),
            LiveImage::Depth => Some(self.picture.depth),
        }
    }

    /// Records that an image comes back, and says what it is like; `None`, and nothing recorded, where it holds nothing now.
    /// The bytes of a film are those that [`Film::insert`](crate::Film::insert) takes.
    pub fn record_read(&self, name: LiveImage, recording: &mut Recording) -> Option<Image> {
        let image = self.image(name)?;
        image.record_read(recording);
        Some(image)
    }

    /// Pixels of the fine film.
    pub fn film_size(&self) -> [u32; 2] {
        self.fine.size
    }

    /// Records that the light is freed which is kept for it. It learns anew when something moves, where the settings and the room
    /// there is allow it.
    pub fn drop_light(&mut self, recording: &mut Recording) {
        if let Some(light) = self.kept_light.take() {
            light.free(recording);
        }
    }

    /// Records that everything is freed.
    pub fn free(mut self, recording: &mut Recording) {
        self.drop_coarse(recording);
        self.drop_light(recording);
        self.fine.free(recording);
        self.picture.free(recording);
        recording.push(Step::Free { id: self.restarts });
    }
}
