//! Light that is kept in volumes, for pictures while things move (`light_cells.wgsl` says how).
//!
//! Light does not depend on the camera. Paths that collide leave points behind; cells in the volumes' own space learn of them
//! what the matter there sends on, frame after frame, wherever the camera is. A picture of that has next to no noise.

use lumivox_core::{Camera, Projection};
use lumivox_shaders::layout;

use super::changing_light::FrameLight;
use super::film::LiveFilm;
use super::images::{Grain, Image, LiveImage, PixelFormat, pixels};
use super::light_cells::{Lesson, PATHS_A_POINT, POINT_BYTES, SharedCells, Sight};
use super::looks::{Look, Looks};
use super::passes::{
    ClearPass, LightCellsPass, LightPicturePass, LightResources, PathSettings, Share, TracePass,
};
use super::reprojection::Seen;
use crate::error::RenderError;
use crate::frame;
use crate::recording::{Recording, ResourceId, Step};
use crate::scene_cache::{Numbered, SceneCache};
use crate::store::LightRoom;

/// Shadow rays of each kind at a point's collision, where there are fewer points than pixels: then a tenth more time brings as
/// much as a quarter more points. Where there are many, they cost a third more and bring nothing.
const RAYS_OF_FEW_POINTS: u32 = 3;

/// Frames after which the film of points is emptied where paths are put aside: of those some may starve, that nobody helps, and their
/// pixels leave no points any more.
const STARVED_FOR: u32 = 256;

/// And those after which it is emptied anyway, for samples are counted in floats.
const COUNTED_FOR: u32 = 1 << 16;

/// First collisions of a pixel, where there are several volumes.
const COLLISIONS: u32 = 8;

/// Films of points that a view empties before its random numbers are those of the next that shares its cells.
const OTHERS_TURNS: u32 = 1 << 16;

/// What a view has of the light that is kept: cells, which others may share, the paths by which they learn, and the picture of them.
#[derive(Debug)]
pub(super) struct KeptLight {
    cells: SharedCells,
    /// What the rest takes of the device's memory.
    room: LightRoom,
    /// What points' paths go into: it keeps those that are put aside, and counts for nothing else.
    film: Option<LiveFilm>,
    /// How often it was emptied: each time its random numbers are others.
    films: u32,
    /// Which volumes its paths may have begun in.
    volumes: Vec<Numbered>,
    /// How often cells have learnt from it.
    frame: u32,
    /// For its host depth.
    restarts: ResourceId,
    picture: ResourceId,
    size: [u32; 2],
    looks: Looks,
}

impl KeptLight {
    /// For pictures of so many pixels of what is seen; `None` where the device does not bind as large a picture, or the voxels
    /// leave no room.
    pub fn new(size: [u32; 2], sight: &Sight, cache: &SceneCache, recording: &mut Recording) -> Option<Self> {
        if picture_bytes(size) > cache.limits().max_storage_binding {
            return None;
        }
        // A good part of a film of points finds room beside it, and as many points.
        let later_bytes =
            (pixels(size) / 4).max(64) * (LiveFilm::bytes_of_points(cache.limits()) + POINT_BYTES);
        let bytes = picture_bytes(size) + later_bytes;
        let mut room = cache.store().light_room(bytes, bytes)?;
        let cells = SharedCells::new(sight, cache, recording)?;
        room.resize(picture_bytes(size));
        Some(Self {
            cells,
            room,
            film: None,
            films: 0,
            volumes: cache.numbers().unwrap_or_default().to_vec(),
            frame: 0,
            restarts: recording.create_buffer("restarts of points", 16),
            picture: recording.create_buffer("picture of kept light", picture_bytes(size)),
            size,
            looks: Looks::new(),
        })
    }

    /// Whether it can go on for what is seen now.
    pub fn fits(&self, sight: &Sight, cache: &SceneCache, gone: &mut Recording) -> bool {
        self.cells.fits(sight, cache, gone) && self.room.is_left()
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

    /// What it takes of the device's memory; of what it shares with others, its part.
    pub fn bytes(&self) -> u64 {
        self.room.bytes() + self.cells.bytes()
    }

    /// Whether anything is known.
    pub fn is_filled(&self) -> bool {
        self.cells.lock().is_filled()
    }

    /// Whether light learns from this view in this frame, or from another that sees the same.
    pub fn take_turn(&mut self, light: FrameLight, cache: &SceneCache) -> bool {
        let is_its_turn = self.cells.take_turn(light, cache);
        if !is_its_turn {
            self.looks.go_on();
        }
        is_its_turn
    }

    /// Sees to it that there are a film and room for the points of so many paths a frame. A new film has to be cleared.
    pub fn prepare(
        &mut self,
        paths: u64,
        cache: &SceneCache,
        gone: &mut Recording,
        recording: &mut Recording,
    ) -> Result<Option<ClearPass>, RenderError> {
        self.cells.lock().make_room(paths, gone, recording);
        let samples = samples_of(paths, self.size);
        let most = pixels(self.size).min(self.most_pixels(cache)).max(64);
        let wanted = (paths / u64::from(samples)).clamp(64, most) as f64;
        let has = self.film.as_ref().map_or(0.0, |film| pixels(film.size) as f64);
        if (0.8..=1.25).contains(&(wanted / has.max(1.0))) {
            // Paths that were put aside may have begun in a volume that is gone.
            let now = cache.numbers().unwrap_or_default();
            let is_old = self.frame % STARVED_FOR == STARVED_FOR - 1 || now != self.volumes;
            if is_old {
                self.volumes = now.to_vec();
            }
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
        self.cells.lock().most_paths()
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
        let density = paths as f64 / pixels(self.size) as f64;
        let lesson = Lesson { density, light, camera: settings.camera };
        let learns = self.cells.learn(&lesson, cache, recording);
        // A path that was put aside goes on with the numbers that it began with: else it would be drawn anew for being long. Those
        // of another view that sees the same are others.
        let turn = self.films.wrapping_add(self.cells.viewer().wrapping_mul(OTHERS_TURNS));
        let seed = settings.seed ^ turn.wrapping_mul(0x85eb_ca6b);
        let settings = PathSettings { seed, ..*settings };
        let fields = self.fields(&settings.camera, paths);
        let film = self.film.as_ref()?;
        let all = Share::of_all(film.size, samples_of(paths, self.size), u32::MAX);
        self.looks.go_on();
        let (points, capacity) = (learns.resources.points, learns.params.points);
        let trace = film.trace(Grain::Points, cache, &settings, all).with_points(points, capacity, fields);
        Some((trace, learns))
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
            seed: settings.seed ^ self.cells.lock().frame(),
            image_size: self.size,
            film_size: self.size,
            samples: COLLISIONS,
            turn_limit: u32::MAX,
            march_first: self.looks.begin(look),
            march_stride: look.stride,
            ..frame::of(cache, &settings.camera)
        };
        let seen = Seen { camera: settings.camera, volumes: cache.places() };
        let LightResources { cells, points } = self.cells.lock().resources();
        // Where there is no room for pictures, something has to be bound all the same.
        let unused = [cells, points];
        let mut fill = self.looks.before(look, seen, self.size, unused, &mut self.room, recording);
        fill.params.light_scale = self.cells.lock().scale();
        LightPicturePass {
            scene: cache,
            cells,
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

    fn fields(&self, camera: &Camera, paths: u64) -> LightFields {
        let cells = self.cells.lock();
        let share = f64::from(cells.capacity()) * PATHS_A_POINT / paths.max(1) as f64;
        let rays = if paths < pixels(self.size) { RAYS_OF_FEW_POINTS } else { 1 };
        LightFields {
            point_rays: rays,
            point_share: share.min(1.0) as f32,
            pixel_size: pixel_size(camera, self.size),
            light_slots: cells.slots(),
            light_scale: cells.scale(),
        }
    }

    pub fn free(mut self, recording: &mut Recording) {
        self.looks.forget(self.size, &mut self.room, recording);
        if let Some(film) = self.film {
            film.free(recording);
        }
        for id in [self.restarts, self.picture] {
            recording.push(Step::Free { id });
        }
        self.cells.free(recording);
    }
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

fn pixel_size(camera: &Camera, [_, height]: [u32; 2]) -> f32 {
    let (Projection::Perspective { tangents: edges } | Projection::Orthographic { extents: edges }) =
        camera.projection;
    ((edges[3] - edges[2]).abs() / f64::from(height.max(1))) as f32
}
