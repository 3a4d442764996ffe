//! Light that is kept in volumes, for pictures while things move (`light_cells.wgsl` says how).
//!
//! Light does not depend on the camera. Paths that collide leave points behind; cells in the volumes' own space learn of them
//! what the matter there sends on, frame after frame, wherever the camera is. A picture of that has next to no noise.

use lumivox_core::Camera;
use lumivox_shaders::layout;

use super::film::{GROUP_ROWS, LiveFilm};
use super::images::{Grain, Image, LiveImage, PixelFormat, pixels};
use super::passes::{
    ClearPass, LightCellsPass, LightPicturePass, LightResources, PathSettings, Share, TracePass,
};
use crate::error::RenderError;
use crate::frame;
use crate::recording::{Recording, ResourceId, Step};
use crate::scene_cache::SceneCache;
use crate::store::LightRoom;

/// The part of the voxels' memory that cells take at most.
const OF_VOXELS: f64 = 0.25;

/// Blocks of cells, at least and at most.
const FEWEST_BLOCKS: f64 = 4096.0;
const MOST_BLOCKS: f64 = 262_144.0;

/// Words of the buffer of cells: before all, and of a block with its key and its stamp. As `light_cells.wgsl` has them.
const HEADER_WORDS: u64 = 16;
const BLOCK_WORDS: u64 = 40 + 2;
const BUCKET: u32 = 16;

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

/// The part that cells keep from frame to frame after that, for so many frames: what few points fall into forgets, too.
const KEPT_WHILE_SETTLING: f32 = 0.85;
const SETTLING: u32 = 24;

/// Frames after which the film of points is emptied where paths are put aside: of those some may starve, that nobody helps, and their
/// pixels leave no points any more.
const STARVED_FOR: u32 = 256;

/// First collisions of a pixel, where there are several volumes.
const COLLISIONS: u32 = 8;

/// The cells, and the picture of them.
#[derive(Debug)]
pub(super) struct KeptLight {
    /// What it takes of the device's memory, and that without the film of points.
    room: LightRoom,
    own_bytes: u64,
    cells: ResourceId,
    slots: u32,
    points: ResourceId,
    capacity: u32,
    /// What points' paths go into: it keeps those that are put aside, and counts for nothing else.
    film: Option<LiveFilm>,
    /// For its host depth.
    restarts: ResourceId,
    picture: ResourceId,
    size: [u32; 2],
    /// Which volumes' cells they are.
    shapes: u64,
    scene_version: u64,
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
    /// Empty cells for the volumes of a scene, for pictures of so many pixels; `None` where the device does not bind as large a
    /// picture, or the voxels leave no room.
    pub fn new(size: [u32; 2], exposure: f64, cache: &SceneCache, recording: &mut Recording) -> Option<Self> {
        let limit = cache.limits().max_storage_binding;
        let affordable = ((limit / 4).saturating_sub(HEADER_WORDS) / BLOCK_WORDS) as f64;
        let blocks = cache.voxel_bytes() as f64 * OF_VOXELS / (BLOCK_WORDS * 4) as f64;
        let blocks = blocks.clamp(FEWEST_BLOCKS, MOST_BLOCKS).min(affordable) as u64;
        let capacity = (pixels(size) / 2).clamp(1 << 17, MOST_POINTS).min(limit / POINT_BYTES - 1) as u32;
        let points_bytes = POINT_BYTES * (u64::from(capacity) + 1);
        let picture_bytes = pixels(size) * 2 * PixelFormat::FourFloats.bytes();
        if picture_bytes > limit {
            return None;
        }
        let cells_bytes = |blocks: u64| (HEADER_WORDS + blocks * BLOCK_WORDS) * 4;
        let all_bytes = |blocks| cells_bytes(blocks) + points_bytes + picture_bytes;
        // A good part of a film of points finds room beside them.
        let film_bytes = (pixels(size) / 4).max(64) * LiveFilm::bytes_of_points(cache.limits());
        let fewest = all_bytes(blocks.min(FEWEST_BLOCKS as u64)) + film_bytes;
        let mut room = cache.store().light_room(fewest, all_bytes(blocks) + film_bytes)?;
        let fitting = (room.bytes() - film_bytes - all_bytes(0)) / (BLOCK_WORDS * 4);
        let slots = blocks.min(fitting) as u32 / BUCKET * BUCKET;
        let own_bytes = all_bytes(slots.into());
        room.resize(own_bytes);
        let cells = recording.create_buffer("kept light", cells_bytes(slots.into()));
        recording.push(Step::ClearBuffer { id: cells });
        Some(Self {
            room,
            own_bytes,
            cells,
            slots,
            points: recording.create_buffer("points of light", points_bytes),
            capacity,
            film: None,
            restarts: recording.create_buffer("restarts of points", 16),
            picture: recording.create_buffer("picture of kept light", picture_bytes),
            size,
            shapes: cache.shapes(),
            scene_version: cache.version(),
            scale: scale_of(exposure),
            frame: 0,
            settling: 0,
            is_filled: false,
            is_stale: true,
        })
    }

    /// Whether it can go on for pictures of so many pixels, as bright as that.
    pub fn fits(&self, size: [u32; 2], exposure: f64, cache: &SceneCache) -> bool {
        let ratio = scale_of(exposure) / self.scale;
        let is_as_bright = (1.0 / 16.0..=16.0).contains(&ratio);
        self.size == size && self.shapes == cache.shapes() && is_as_bright && self.room.is_left()
    }

    /// What it takes of the device's memory.
    pub fn bytes(&self) -> u64 {
        self.room.bytes()
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
        let bytes = LiveFilm::bytes_of_points(cache.limits());
        let bindable = cache.limits().max_storage_binding / bytes;
        // A tenth less: sides are rounded.
        let most = pixels(self.size)
            .min((self.room.most() - self.own_bytes) / bytes * 9 / 10)
            .min(bindable * 9 / 10);
        let wanted = (paths / u64::from(samples)).clamp(64, most.max(64)) as f64;
        let has = self.film.as_ref().map_or(0.0, |film| pixels(film.size) as f64);
        if (0.8..=1.25).contains(&(wanted / has.max(1.0))) {
            let is_old = self.frame % STARVED_FOR == STARVED_FOR - 1;
            let starves = |film: &LiveFilm| film.unfinished.puts_aside() && is_old;
            return Ok(self.film.as_mut().filter(|film| starves(film)).map(|film| film.clear(Grain::Points)));
        }
        let [width, height] = self.size.map(f64::from);
        let scale = (wanted / (width * height)).sqrt();
        let size = [width, height].map(|n| ((n * scale).round() as u32).max(1));
        let mut film = LiveFilm::for_points(size, cache, recording)?;
        self.room.resize(self.own_bytes + pixels(size) * bytes);
        let clear = film.clear(Grain::Points);
        if let Some(old) = self.film.replace(film) {
            old.free(gone);
        }
        Ok(Some(clear))
    }

    /// The passes by which cells learn from so many paths, that were prepared for: where their rays end comes before them.
    pub fn learn<'a>(
        &mut self,
        paths: u64,
        kept: f64,
        settings: &PathSettings,
        cache: &'a SceneCache,
    ) -> Vec<(TracePass<'a>, LightCellsPass)> {
        self.frame += 1;
        let other_scene = std::mem::replace(&mut self.scene_version, cache.version()) != cache.version();
        // Where light has changed a little and films keep a part of theirs, fewer than usual, and not all of those.
        let most = match other_scene {
            true if kept < 1.0 => REMEMBERED_OF_ANOTHER_SCENE / (1.0 - kept as f32),
            true => REMEMBERED_OF_ANOTHER_SCENE,
            false => MOST_REMEMBERED,
        };
        let is_settling = self.settling > 0;
        self.settling =
            if most == REMEMBERED_OF_ANOTHER_SCENE { SETTLING } else { self.settling.saturating_sub(1) };
        let kept = kept as f32 * if is_settling { KEPT_WHILE_SETTLING } else { 1.0 };
        let (resources, frame, slots, capacity) = (self.resources(), self.frame, self.slots, self.capacity);
        let seed = settings.seed ^ frame.wrapping_mul(0x85eb_ca6b);
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
            let kept = if i == 0 { params.kept } else { 1.0 };
            let params = layout::LightParams { kept, ..params };
            let (is_first, is_last) = (i == 0, i + 1 == bands);
            (
                trace.with_points(resources.points, capacity, fields),
                LightCellsPass { resources, params, is_first, is_last },
            )
        };
        (0..bands).map(band).collect()
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
    use lumivox_core::Projection::{Orthographic, Perspective};
    let (Perspective { tangents: edges } | Orthographic { extents: edges }) = camera.projection;
    ((edges[3] - edges[2]).abs() / f64::from(height.max(1))) as f32
}
