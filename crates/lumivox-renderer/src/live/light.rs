//! Light that is kept in volumes, for pictures while things move (`light_cells.wgsl` says how).
//!
//! Light does not depend on the camera. Paths that collide leave points behind; cells in the volumes' own space learn of them
//! what the matter there sends on, frame after frame, wherever the camera is. A picture of that has next to no noise.

use lumivox_core::glam::DVec3;
use lumivox_core::{Camera, Projection};
use lumivox_shaders::layout;

use super::changing_light::{FrameLight, LEAST_KEPT};
use super::film::{GROUP_ROWS, LiveFilm};
use super::images::{Grain, Image, LiveImage, PixelFormat, pixels};
use super::passes::{
    ClearPass, LightCellsPass, LightPicturePass, LightResources, PathSettings, Share, TracePass,
};
use crate::error::RenderError;
use crate::frame;
use crate::recording::{Payload, Recording, ResourceId, Step};
use crate::scene_cache::{Numbered, SceneCache, check_binding};

/// The part of the voxels' memory that cells take at most.
const OF_VOXELS: f64 = 0.25;

/// Blocks of cells, at least and at most.
const FEWEST_BLOCKS: f64 = 4096.0;
const MOST_BLOCKS: f64 = 262_144.0;

/// Words of the buffer of cells: before all, and of a block with its key and its stamp. As `light_cells.wgsl` has them.
const HEADER_WORDS: u64 = 144;
const BLOCK_WORDS: u64 = 40 + 2;
const BUCKET: u32 = 16;

/// Of those before all, the first of as many as have a bit for each number of a volume.
const GONE_WORD: u64 = 16;
const GONE_WORDS: usize = 128;

/// Bytes of a point, and of what stands before them all.
const POINT_BYTES: u64 = 32;

/// Points of a frame that there is room for, at most.
const MOST_POINTS: u64 = 1 << 20;

/// Of paths about every second one meets a volume, where it fills a good part of the image.
const PATHS_A_POINT: f64 = 2.0;

/// Dispatches of a frame's points at most: of more paths not all leave one.
const MOST_BANDS: u64 = 4;

/// Invocations below which a large GPU is not busy: they trace one path each then.
const BUSY: u64 = 1 << 17;

/// Points that cells remember at most, of light that is sent on diffusely and of what surfaces mirror, which is another for
/// who looks from elsewhere.
const MOST_REMEMBERED: f32 = 1024.0;
const MOST_MIRRORED: f32 = 128.0;

/// Points for each pixel of the picture that cells of the next tier are told of, and those of the one after that.
const COARSE_POINTS: f64 = 0.25;
const COARSEST_POINTS: f64 = 0.03;

/// Points after which a cell is trusted as much as the cells around it.
const TRUSTED: f32 = 12.0;

/// Points that what cells know counts for at most when the scene has changed, whatever changed of it: what comes is soon more.
const REMEMBERED_OF_ANOTHER_SCENE: f32 = 8.0;

/// And when light fell on it that is another altogether.
const REMEMBERED_OF_OTHER_LIGHT: f32 = 2.0;

/// The part that cells keep from frame to frame after that, for so many frames: what few points fall into forgets, too.
const KEPT_WHILE_SETTLING: f32 = 0.85;
const SETTLING: u32 = 24;

/// By how much what is sent on may have changed, for it is looked at from elsewhere, when a part of 1 / e is left of what was learnt:
/// by phase functions, for what surfaces mirror is kept apart.
const OTHER_PHASE: f64 = 0.25;

/// Frames after which the film of points is emptied where paths are put aside: of those some may starve, that nobody helps, and their
/// pixels leave no points any more.
const STARVED_FOR: u32 = 256;

/// And those after which it is emptied anyway, for samples are counted in floats.
const COUNTED_FOR: u32 = 1 << 16;

/// How many times as bright or dark light may be shown as it was when cells were made: there are bits enough for that.
const BRIGHTER: f64 = 1024.0;

/// First collisions of a pixel, where there are several volumes.
const COLLISIONS: u32 = 8;

/// The cells, and the picture of them.
#[derive(Debug)]
pub(super) struct KeptLight {
    cells: ResourceId,
    slots: u32,
    points: ResourceId,
    capacity: u32,
    /// What points' paths go into: it keeps those that are put aside, and counts for nothing else.
    film: Option<LiveFilm>,
    /// How often it was emptied: each time its random numbers are others.
    films: u32,
    /// For its host depth.
    restarts: ResourceId,
    picture: ResourceId,
    size: [u32; 2],
    /// Which volumes' cells they are.
    volumes: Vec<Numbered>,
    scene_version: u64,
    /// In which they have learnt, and from where.
    light: FrameLight,
    eye: DVec3,
    /// What light is multiplied by in cells.
    scale: f64,
    frame: u32,
    /// Frames for which cells forget faster, for the scene has changed.
    settling: u32,
    /// Whether any point was ever taken.
    is_filled: bool,
    /// Whether the picture is another than what was made last.
    is_stale: bool,
}

impl KeptLight {
    /// Empty cells for the volumes of a scene, for pictures of so many pixels.
    pub fn new(
        size: [u32; 2],
        exposure: f64,
        light: FrameLight,
        cache: &SceneCache,
        recording: &mut Recording,
    ) -> Result<Self, RenderError> {
        let slots = slots_for(cache);
        let (points, capacity) = make_points(size, recording);
        let picture = make_picture(size, cache, recording)?;
        let cells =
            recording.create_buffer("kept light", (HEADER_WORDS + u64::from(slots) * BLOCK_WORDS) * 4);
        recording.push(Step::ClearBuffer { id: cells });
        Ok(Self {
            cells,
            slots,
            points,
            capacity,
            film: None,
            films: 0,
            restarts: recording.create_buffer("restarts of points", 16),
            picture,
            size,
            volumes: cache.numbers().unwrap_or_default().to_vec(),
            scene_version: cache.version(),
            light,
            eye: DVec3::ZERO,
            scale: scale_of(exposure * cache.light_scale()),
            frame: 0,
            settling: 0,
            is_filled: false,
            is_stale: true,
        })
    }

    /// Whether it can go on for pictures as bright as that, and for the volumes that there are: it holds what it knows of those that
    /// stay, unless there is room for far more of it now, or far less.
    pub fn fits(&self, exposure: f64, cache: &SceneCache) -> bool {
        let shown = exposure * cache.light_scale();
        let ratio = scale_of(shown) / self.scale;
        let slots = slots_for(cache);
        (shown == 0.0 || (1.0 / BRIGHTER..=BRIGHTER).contains(&ratio))
            && slots < 2 * self.slots
            && slots > self.slots / 4
    }

    /// Makes pictures of so many pixels from now on.
    pub fn resize(
        &mut self,
        size: [u32; 2],
        cache: &SceneCache,
        gone: &mut Recording,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        if self.size != size {
            let picture = make_picture(size, cache, recording)?;
            let (points, capacity) = make_points(size, recording);
            for old in
                [std::mem::replace(&mut self.picture, picture), std::mem::replace(&mut self.points, points)]
            {
                gone.push(Step::Free { id: old });
            }
            (self.size, self.capacity, self.is_stale) = (size, capacity, true);
        }
        Ok(())
    }

    /// Whether it knows anything.
    pub fn is_filled(&self) -> bool {
        self.is_filled
    }

    /// The camera has moved, or something else that is seen.
    pub fn look_again(&mut self) {
        self.is_stale = true;
    }

    /// Sees to it that there is a film of points for so many paths a frame. A new one has to be cleared.
    pub fn prepare(
        &mut self,
        paths: u64,
        cache: &SceneCache,
        gone: &mut Recording,
        recording: &mut Recording,
    ) -> Result<Option<ClearPass>, RenderError> {
        let samples = samples_of(paths, self.size);
        let most = pixels(self.size).min(LiveFilm::most_for_points(cache)).max(64);
        let wanted = (paths / u64::from(samples)).clamp(64, most) as f64;
        let has = self.film.as_ref().map_or(0.0, |film| pixels(film.size) as f64);
        if (0.8..=1.25).contains(&(wanted / has.max(1.0))) {
            // Paths that were put aside may have begun in a volume that is gone.
            let is_old = self.frame % STARVED_FOR == STARVED_FOR - 1
                || cache.numbers().is_some_and(|now| now != self.volumes);
            let counts_far = self.frame % COUNTED_FOR == COUNTED_FOR - 1;
            let is_over = |film: &LiveFilm| film.unfinished.puts_aside() && is_old || counts_far;
            return Ok(self.film.as_mut().filter(|film| is_over(film)).map(|film| {
                self.films += 1;
                film.clear(Grain::Points)
            }));
        }
        let [width, height] = self.size.map(f64::from);
        let scale = (wanted / (width * height)).sqrt();
        let size = [width, height].map(|n| ((n * scale).floor() as u32).max(1));
        if self.film.as_ref().is_none_or(|film| film.capacity < pixels(size)) {
            let larger = LiveFilm::for_points(size, cache, recording)?;
            if let Some(small) = self.film.replace(larger) {
                small.free(gone);
            }
        }
        Ok(self.film.as_mut().map(|film| {
            self.films += 1;
            film.size = size;
            film.clear(Grain::Points)
        }))
    }

    /// Paths of a frame at most: of more not all would leave points.
    pub fn most_paths(&self) -> u64 {
        (f64::from(self.capacity) * PATHS_A_POINT) as u64 * MOST_BANDS
    }

    /// The passes by which cells learn from so many paths, that were prepared for: where their rays end comes before them.
    pub fn learn<'a>(
        &mut self,
        paths: u64,
        light: FrameLight,
        settings: &PathSettings,
        cache: &'a SceneCache,
        recording: &mut Recording,
    ) -> Vec<(TracePass<'a>, LightCellsPass)> {
        self.frame += 1;
        let forgets = self.forget_gone(cache, recording);
        // Whatever the camera does, and the film with it: light that has changed a little lets cells keep a part of theirs.
        let [kept, scale] = light.since(&std::mem::replace(&mut self.light, light));
        let other_scene = std::mem::replace(&mut self.scene_version, cache.version()) != cache.version();
        let other_light = kept < LEAST_KEPT;
        let most = match (other_light, other_scene) {
            (true, _) => REMEMBERED_OF_OTHER_LIGHT,
            (false, true) => REMEMBERED_OF_ANOTHER_SCENE,
            (false, false) => MOST_REMEMBERED,
        };
        let kept = if other_light { 1.0 } else { kept } * self.kept_from(&settings.camera, cache);
        let kept = kept as f32 * if self.settling > 0 { KEPT_WHILE_SETTLING } else { 1.0 };
        self.settling = match most {
            MOST_REMEMBERED => self.settling.saturating_sub(1),
            _ => SETTLING,
        };
        let (resources, frame, slots, capacity) = (self.resources(), self.frame, self.slots, self.capacity);
        // A path that was put aside goes on with the numbers that it began with: else it would be drawn anew for being long.
        let seed = settings.seed ^ self.films.wrapping_mul(0x85eb_ca6b);
        let settings = PathSettings { seed, ..*settings };
        let fields = self.fields(&settings.camera, paths);
        let Some(film) = &self.film else { return vec![] };
        let all = Share::of_all(film.size, samples_of(paths, self.size), u32::MAX);
        let density = paths as f64 / pixels(self.size) as f64;
        let params = layout::LightParams {
            slots,
            frame,
            points: capacity,
            kept,
            most_points: most.min(MOST_REMEMBERED),
            most_mirrored: most.min(MOST_MIRRORED),
            trusted_points: TRUSTED,
            coarse_share: (COARSE_POINTS / density).min(1.0) as f32,
            coarsest_share: (COARSEST_POINTS / density).min(1.0) as f32,
            forgets: u32::from(forgets),
            scale: scale as f32,
            ..Default::default()
        };
        self.is_filled = true;
        self.is_stale = true;
        // In bands of rows, each with as many points as there is room for.
        let bands = paths.div_ceil((f64::from(capacity) * PATHS_A_POINT) as u64).clamp(1, MOST_BANDS) as u32;
        let groups = all.rows[1] / GROUP_ROWS;
        let bands = bands.min(groups);
        let band = |i: u32| {
            let rows = [i, i + 1].map(|i| groups * i / bands * GROUP_ROWS);
            let trace = film.trace(Grain::Points, cache, &settings, Share { rows, ..all });
            let [kept, scale] = if i == 0 { [params.kept, params.scale] } else { [1.0; 2] };
            let params = layout::LightParams { kept, scale, ..params };
            let (is_first, is_last) = (i == 0, i + 1 == bands);
            (
                trace.with_points(resources.points, fields),
                LightCellsPass { resources, params, is_first, is_last },
            )
        };
        (0..bands).map(band).collect()
    }

    /// The part that is kept by what is looked at from elsewhere than in the frame before.
    fn kept_from(&mut self, camera: &Camera, cache: &SceneCache) -> f64 {
        let place = camera.world_from_camera;
        let eye = match camera.projection {
            Projection::Perspective { .. } => place.translation - cache.origin(),
            Projection::Orthographic { .. } => place.matrix3.z_axis,
        };
        let before = std::mem::replace(&mut self.eye, eye.normalize_or_zero());
        if before == DVec3::ZERO || self.eye == DVec3::ZERO {
            return 1.0;
        }
        (-before.angle_between(self.eye) * cache.steepest_phase() / OTHER_PHASE).exp()
    }

    /// Tells cells which volumes are gone, whose numbers others may have some day; returns whether any are.
    fn forget_gone(&mut self, cache: &SceneCache, recording: &mut Recording) -> bool {
        let now = cache.numbers().unwrap_or_default();
        if now == self.volumes {
            return false;
        }
        let before = std::mem::replace(&mut self.volumes, now.to_vec());
        let mut gone = [0u32; GONE_WORDS];
        for (number, _) in before.iter().filter(|volume| now.binary_search(volume).is_err()) {
            gone[*number as usize / 32] |= 1 << (number % 32);
        }
        let data = Payload::copy_of(&gone);
        recording.push(Step::WriteBuffer { id: self.cells, offset: 4 * GONE_WORD, data });
        gone.iter().any(|word| *word != 0)
    }

    /// Where the rays of points end, if the host's surfaces end any: a film, and a buffer for what nobody asks for.
    pub fn host_depth(&self) -> Option<(super::FilmImages, ResourceId)> {
        Some((self.film.as_ref()?.images(Grain::Points), self.restarts))
    }

    /// The picture of it, if it is another one than before. Rays end where those of `film` do.
    pub fn look<'a>(
        &mut self,
        film: &LiveFilm,
        settings: &PathSettings,
        cache: &'a SceneCache,
    ) -> Option<LightPicturePass<'a>> {
        if !std::mem::take(&mut self.is_stale) {
            return None;
        }
        let frame = layout::Frame {
            seed: settings.seed ^ self.frame,
            image_size: self.size,
            film_size: self.size,
            samples: COLLISIONS,
            turn_limit: u32::MAX,
            ..frame::of(cache, &settings.camera)
        };
        Some(LightPicturePass {
            scene: cache,
            cells: self.cells,
            film: film.images(Grain::Fine),
            picture: self.picture(),
            frame: self.fields(&settings.camera, 0).put_into(frame),
        })
    }

    /// What was made last.
    pub fn picture(&self) -> Image {
        Image {
            name: LiveImage::KeptLight,
            buffer: self.picture,
            offset: 0,
            size: self.size,
            planes: 2,
            format: PixelFormat::FourFloats,
        }
    }

    fn resources(&self) -> LightResources {
        LightResources { cells: self.cells, points: self.points }
    }

    fn fields(&self, camera: &Camera, paths: u64) -> LightFields {
        let share = f64::from(self.capacity) * PATHS_A_POINT * MOST_BANDS as f64 / paths.max(1) as f64;
        LightFields {
            point_share: share.min(1.0) as f32,
            pixel_size: pixel_size(camera, self.size),
            light_slots: self.slots,
            light_scale: self.scale as f32,
        }
    }

    pub fn free(self, recording: &mut Recording) {
        if let Some(film) = self.film {
            film.free(recording);
        }
        for id in [self.cells, self.points, self.restarts, self.picture] {
            recording.push(Step::Free { id });
        }
    }
}

/// Blocks that there is to be room for.
fn slots_for(cache: &SceneCache) -> u32 {
    let affordable = (cache.limits().max_storage_binding / 4).saturating_sub(HEADER_WORDS) / BLOCK_WORDS;
    let blocks = cache.voxel_bytes() as f64 * OF_VOXELS / (BLOCK_WORDS * 4) as f64;
    blocks.clamp(FEWEST_BLOCKS, MOST_BLOCKS).min(affordable as f64) as u32 / BUCKET * BUCKET
}

/// Room for the points of a frame, and for how many.
fn make_points(size: [u32; 2], recording: &mut Recording) -> (ResourceId, u32) {
    let capacity = (pixels(size) / 2).clamp(1 << 17, MOST_POINTS) as u32;
    (recording.create_buffer("points of light", POINT_BYTES * (u64::from(capacity) + 1)), capacity)
}

fn make_picture(
    size: [u32; 2],
    cache: &SceneCache,
    recording: &mut Recording,
) -> Result<ResourceId, RenderError> {
    let bytes = pixels(size) * 2 * PixelFormat::FourFloats.bytes();
    let limit = cache.limits().max_storage_binding;
    check_binding("picture of kept light", bytes, limit, "Lower the resolution scale")?;
    Ok(recording.create_buffer("picture of kept light", bytes))
}

/// What of a frame's parameters is about kept light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightFields {
    /// Of paths, the share that leaves points.
    pub point_share: f32,
    /// Metres that a pixel of the picture sees at depth 1, or at any depth of an orthographic view.
    pub pixel_size: f32,
    /// Blocks there is room for.
    pub light_slots: u32,
    /// What light is multiplied by in cells.
    pub light_scale: f32,
}

impl LightFields {
    /// A frame's parameters with these.
    pub fn put_into(self, frame: layout::Frame) -> layout::Frame {
        let Self { point_share, pixel_size, light_slots, light_scale } = self;
        layout::Frame { point_share, pixel_size, light_slots, light_scale, ..frame }
    }
}

/// Samples that one invocation traces, where each has a pixel of its own of a picture of so many.
fn samples_of(paths: u64, size: [u32; 2]) -> u32 {
    (paths / BUSY).clamp(1, 4).max(paths.div_ceil(pixels(size).max(1))) as u32
}

/// A power of two near the exposure: in cells light is about as bright as it is shown, whatever its unit.
fn scale_of(exposure: f64) -> f64 {
    let bounded = if exposure.is_finite() { exposure.clamp(1e-12, 1e12) } else { 1.0 };
    bounded.log2().round().exp2()
}

fn pixel_size(camera: &Camera, [_, height]: [u32; 2]) -> f32 {
    let (Projection::Perspective { tangents: edges } | Projection::Orthographic { extents: edges }) =
        camera.projection;
    ((edges[3] - edges[2]).abs() / f64::from(height.max(1))) as f32
}
