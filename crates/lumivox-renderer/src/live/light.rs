//! Light that is kept in volumes, for pictures while things move (`light_cells.wgsl` says how).
//!
//! Light does not depend on the camera. Paths that collide leave points behind; cells in the volumes' own space learn of them
//! what the matter there sends on, frame after frame, wherever the camera is. A picture of that has next to no noise.

use lumivox_core::glam::DVec3;
use lumivox_core::{Camera, Projection};
use lumivox_shaders::layout;

use super::changing_light::{FrameLight, LEAST_KEPT};
use super::film::LiveFilm;
use super::images::{Grain, Image, LiveImage, PixelFormat, pixels};
use super::looks::{Look, Looks};
use super::passes::{
    ClearPass, LightCellsPass, LightPicturePass, LightResources, PathSettings, Share, TracePass,
};
use super::reprojection::Seen;
use crate::error::RenderError;
use crate::frame;
use crate::recording::{Payload, Recording, ResourceId, Step};
use crate::scene_cache::{Numbered, SceneCache};
use crate::store::LightRoom;

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

/// Points of a frame that there is room for, at least and at most.
const FEWEST_POINTS: u64 = 1 << 16;
const MOST_POINTS: u64 = 1 << 22;

/// Paths that leave one: about every second one meets a volume, where it fills a good part of the image.
const PATHS_A_POINT: f64 = 2.0;

/// Shadow rays of each kind at a point's collision, where there are fewer points than pixels: then a tenth more time brings as
/// much as a quarter more points. Where there are many, they cost a third more and bring nothing.
const RAYS_OF_FEW_POINTS: u32 = 3;

/// Points that cells remember at most, of light that is sent on diffusely and of what surfaces mirror, which is another for
/// who looks from elsewhere.
const MOST_REMEMBERED: f32 = 1024.0;
const MOST_MIRRORED: f32 = 128.0;

/// Points for each pixel of the picture that cells of the next tier are told of, and those of the one after that.
const COARSE_POINTS: f64 = 0.25;
const COARSEST_POINTS: f64 = 0.03;

/// Points after which a cell is trusted as much as the cells around it.
const TRUSTED: f32 = 12.0;

/// Points that what cells know counts for at most when the scene has changed, whatever changed of it. Less where new points say
/// otherwise (`light_gather.wgsl`).
const REMEMBERED_OF_ANOTHER_SCENE: f32 = 64.0;

/// And when light fell on it that is another altogether.
const REMEMBERED_OF_OTHER_LIGHT: f32 = 2.0;

/// The part that cells keep from frame to frame after that, for so many frames: what few points fall into forgets, too.
const KEPT_WHILE_SETTLING: f32 = 0.9;
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
    /// What it takes of the device's memory.
    room: LightRoom,
    cells: ResourceId,
    slots: u32,
    /// As many as there would be, were there room.
    wanted_slots: u32,
    points: ResourceId,
    capacity: u32,
    most_points: u64,
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
    looks: Looks,
}

impl KeptLight {
    /// Empty cells for the volumes of a scene, for pictures of so many pixels; `None` where the device does not bind as large a
    /// picture, or the voxels leave no room.
    pub fn new(
        size: [u32; 2],
        exposure: f64,
        light: FrameLight,
        cache: &SceneCache,
        recording: &mut Recording,
    ) -> Option<Self> {
        let limit = cache.limits().max_storage_binding;
        if picture_bytes(size) > limit {
            return None;
        }
        let wanted_slots = slots_for(cache);
        let all_bytes = |slots: u64| cells_bytes(slots) + points_bytes(FEWEST_POINTS) + picture_bytes(size);
        // A good part of a film of points finds room beside them, and as many points.
        let later_bytes =
            (pixels(size) / 4).max(64) * (LiveFilm::bytes_of_points(cache.limits()) + POINT_BYTES);
        let fewest = all_bytes(u64::from(wanted_slots).min(FEWEST_BLOCKS as u64)) + later_bytes;
        let mut room = cache.store().light_room(fewest, all_bytes(wanted_slots.into()) + later_bytes)?;
        let fitting = (room.bytes() - later_bytes - all_bytes(0)) / (BLOCK_WORDS * 4);
        let slots = u64::from(wanted_slots).min(fitting) as u32 / BUCKET * BUCKET;
        room.resize(all_bytes(slots.into()));
        let cells = recording.create_buffer("kept light", cells_bytes(slots.into()));
        recording.push(Step::ClearBuffer { id: cells });
        Some(Self {
            room,
            cells,
            slots,
            wanted_slots,
            points: recording.create_buffer("points of light", points_bytes(FEWEST_POINTS)),
            capacity: FEWEST_POINTS as u32,
            most_points: MOST_POINTS.min(limit / POINT_BYTES - 1),
            film: None,
            films: 0,
            restarts: recording.create_buffer("restarts of points", 16),
            picture: recording.create_buffer("picture of kept light", picture_bytes(size)),
            size,
            volumes: cache.numbers().unwrap_or_default().to_vec(),
            scene_version: cache.version(),
            light,
            eye: DVec3::ZERO,
            scale: scale_of(exposure * cache.light_scale()),
            frame: 0,
            settling: 0,
            is_filled: false,
            looks: Looks::new(),
        })
    }

    /// Whether it can go on for pictures as bright as that, and for the volumes that there are: it holds what it knows of those that
    /// stay, unless there would be far more room for it now, or far less, or voxels leave it none.
    pub fn fits(&self, exposure: f64, cache: &SceneCache) -> bool {
        let shown = exposure * cache.light_scale();
        let ratio = scale_of(shown) / self.scale;
        let slots = slots_for(cache);
        (shown == 0.0 || (1.0 / BRIGHTER..=BRIGHTER).contains(&ratio))
            && slots < 2 * self.wanted_slots
            && slots > self.wanted_slots / 4
            && self.room.is_left()
    }

    /// When and how pictures are made of it.
    pub fn looks(&mut self) -> &mut Looks {
        &mut self.looks
    }

    /// How the next picture is made, see [`Looks::plan`].
    pub fn plan_look(&mut self, budget: u64, is_at_rest: bool) -> Option<Look> {
        self.looks.plan(self.size, budget, is_at_rest)
    }

    /// Makes pictures of so many pixels from now on; returns whether it can.
    pub fn resize(
        &mut self,
        size: [u32; 2],
        cache: &SceneCache,
        gone: &mut Recording,
        recording: &mut Recording,
    ) -> bool {
        if self.size == size {
            return true;
        }
        let [old, new] = [self.size, size].map(picture_bytes);
        if new > cache.limits().max_storage_binding || self.room.bytes() - old + new > self.room.most() {
            return false;
        }
        self.room.resize(self.room.bytes() - old + new);
        let picture = recording.create_buffer("picture of kept light", new);
        gone.push(Step::Free { id: std::mem::replace(&mut self.picture, picture) });
        self.looks.forget(self.size, &mut self.room, gone);
        self.size = size;
        true
    }

    /// What it takes of the device's memory.
    pub fn bytes(&self) -> u64 {
        self.room.bytes()
    }

    /// Whether it knows anything.
    pub fn is_filled(&self) -> bool {
        self.is_filled
    }

    /// Sees to it that there are a film and room for the points of so many paths a frame. A new film has to be cleared.
    pub fn prepare(
        &mut self,
        paths: u64,
        cache: &SceneCache,
        gone: &mut Recording,
        recording: &mut Recording,
    ) -> Result<Option<ClearPass>, RenderError> {
        self.make_room(paths, gone, recording);
        let samples = samples_of(paths, self.size);
        let most = pixels(self.size).min(self.most_pixels(cache)).max(64);
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
            let before = self.film_bytes(cache);
            if let Some(small) = self.film.replace(larger) {
                small.free(gone);
            }
            self.room.resize(self.room.bytes() - before + self.film_bytes(cache));
        }
        Ok(self.film.as_mut().map(|film| {
            self.films += 1;
            film.size = size;
            film.clear(Grain::Points)
        }))
    }

    /// Room for the points of so many paths, if there is any.
    fn make_room(&mut self, paths: u64, gone: &mut Recording, recording: &mut Recording) {
        let wanted = paths as f64 / PATHS_A_POINT;
        let before = u64::from(self.capacity);
        // A quarter more, for budgets change from frame to frame.
        let spare = self.room.most() - self.room.bytes();
        let capacity = ((1.25 * wanted) as u64).min(self.most_points).min(before + spare / POINT_BYTES);
        if wanted > before as f64 && capacity > before {
            gone.push(Step::Free { id: self.points });
            self.points = recording.create_buffer("points of light", points_bytes(capacity));
            self.capacity = capacity as u32;
            self.room.resize(self.room.bytes() - points_bytes(before) + points_bytes(capacity));
        }
    }

    /// What the film of points takes.
    fn film_bytes(&self, cache: &SceneCache) -> u64 {
        self.film.as_ref().map_or(0, |film| film.capacity * LiveFilm::bytes_of_points(cache.limits()))
    }

    /// Pixels of the film of points at most: what the device binds, and what there is room for.
    fn most_pixels(&self, cache: &SceneCache) -> u64 {
        let spare = self.room.most() - self.room.bytes() + self.film_bytes(cache);
        spare.min(cache.limits().max_storage_binding) / LiveFilm::bytes_of_points(cache.limits())
    }

    /// Paths of a frame at most: of more not all would leave points.
    pub fn most_paths(&self) -> u64 {
        (self.most_points as f64 * PATHS_A_POINT) as u64
    }

    /// The passes by which cells learn from so many paths, that were prepared for: where their rays end comes before them.
    pub fn learn<'a>(
        &mut self,
        paths: u64,
        light: FrameLight,
        settings: &PathSettings,
        cache: &'a SceneCache,
        recording: &mut Recording,
    ) -> Option<(TracePass<'a>, LightCellsPass)> {
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
        let is_changing = u32::from(self.settling > 0);
        let (resources, frame, slots, capacity) = (self.resources(), self.frame, self.slots, self.capacity);
        // A path that was put aside goes on with the numbers that it began with: else it would be drawn anew for being long.
        let seed = settings.seed ^ self.films.wrapping_mul(0x85eb_ca6b);
        let settings = PathSettings { seed, ..*settings };
        let fields = self.fields(&settings.camera, paths);
        let film = self.film.as_ref()?;
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
            is_changing,
            coarse_share: (COARSE_POINTS / density).min(1.0) as f32,
            coarsest_share: (COARSEST_POINTS / density).min(1.0) as f32,
            forgets: u32::from(forgets),
            scale: scale as f32,
            ..Default::default()
        };
        self.is_filled = true;
        self.looks.go_on();
        let trace =
            film.trace(Grain::Points, cache, &settings, all).with_points(resources.points, capacity, fields);
        Some((trace, LightCellsPass { resources, params }))
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

    /// The picture of it. Rays end where those of `film` do.
    pub fn look<'a>(
        &mut self,
        look: Look,
        film: &LiveFilm,
        settings: &PathSettings,
        cache: &'a SceneCache,
        recording: &mut Recording,
    ) -> LightPicturePass<'a> {
        let frame = layout::Frame {
            seed: settings.seed ^ self.frame,
            image_size: self.size,
            film_size: self.size,
            samples: COLLISIONS,
            turn_limit: u32::MAX,
            march_first: self.looks.begin(look),
            march_stride: look.stride,
            ..frame::of(cache, &settings.camera)
        };
        let seen = Seen { camera: settings.camera, volumes: cache.places() };
        // Where there is no room for pictures, something has to be bound all the same.
        let unused = [self.cells, self.points];
        let mut fill = self.looks.before(look, seen, self.size, unused, &mut self.room, recording);
        fill.params.light_scale = self.scale as f32;
        LightPicturePass {
            scene: cache,
            cells: self.cells,
            film: film.images(Grain::Fine),
            picture: self.picture(),
            fill,
            frame: self.fields(&settings.camera, 0).put_into(frame),
        }
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
        let share = f64::from(self.capacity) * PATHS_A_POINT / paths.max(1) as f64;
        let rays = if paths < pixels(self.size) { RAYS_OF_FEW_POINTS } else { 1 };
        LightFields {
            point_rays: rays,
            point_share: share.min(1.0) as f32,
            pixel_size: pixel_size(camera, self.size),
            light_slots: self.slots,
            light_scale: self.scale as f32,
        }
    }

    pub fn free(mut self, recording: &mut Recording) {
        self.looks.forget(self.size, &mut self.room, recording);
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

fn cells_bytes(slots: u64) -> u64 {
    (HEADER_WORDS + slots * BLOCK_WORDS) * 4
}

fn points_bytes(capacity: u64) -> u64 {
    POINT_BYTES * (capacity + 1)
}

fn picture_bytes(size: [u32; 2]) -> u64 {
    pixels(size) * 2 * PixelFormat::FourFloats.bytes()
}

/// What of a frame's parameters is about kept light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightFields {
    /// Shadow rays of each kind at a point's collision.
    pub point_rays: u32,
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
        let Self { point_rays, point_share, pixel_size, light_slots, light_scale } = self;
        layout::Frame { point_rays, point_share, pixel_size, light_slots, light_scale, ..frame }
    }
}

/// Samples that one invocation traces. As few as can be: of one sample each, neighbours collide and ask for light together.
fn samples_of(paths: u64, size: [u32; 2]) -> u32 {
    paths.div_ceil(pixels(size).max(1)).max(1) as u32
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
