//! Cells in which a scene's light is kept (`light_cells.wgsl` says how), and which views share them.
//!
//! Light does not depend on the camera, but for what surfaces mirror and phase functions send on to one side. Views that look at a
//! scene from about the same side in the same light learn together, as both eyes of a headset: they take turns, and each sees what all
//! of them have learnt. Where one goes another way it leaves the others, and learns for itself.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use lumivox_core::glam::DVec3;
use lumivox_core::{Camera, Projection};
use lumivox_shaders::layout;

use super::changing_light::{FrameLight, LEAST_KEPT};
use super::passes::{LightCellsPass, LightResources};
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
pub(super) const POINT_BYTES: u64 = 32;

/// Points of a frame that there is room for, at least and at most.
const FEWEST_POINTS: u64 = 1 << 16;
const MOST_POINTS: u64 = 1 << 22;

/// Paths that leave one: about every second one meets a volume, where it fills a good part of the image.
pub(super) const PATHS_A_POINT: f64 = 2.0;

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

/// How many times as bright or dark light may be shown as it was when cells were made: there are bits enough for that.
const BRIGHTER: f64 = 1024.0;

/// Radians between the directions from which views see a scene with surfaces, when cells are no longer shared: they mirror another
/// part of what is around.
const OTHER_SIDE: f64 = 0.5;

/// Times that cells have learnt since a view learnt with them, for each of those that share them: one that has rested for longer has
/// no say in who does.
const RECENT: u32 = 3;

/// The cells of a scene, as many as there are.
#[derive(Clone, Debug, Default)]
pub(crate) struct CellsOfScene(Arc<Mutex<Vec<Weak<Mutex<LightCells>>>>>);

/// Cells, and a view that shares them.
#[derive(Debug)]
pub(super) struct SharedCells {
    all: Arc<Mutex<LightCells>>,
    scene: CellsOfScene,
    /// Which of those that share them it is.
    viewer: u32,
}

/// One of those that share cells.
#[derive(Clone, Copy, Debug)]
struct Viewer {
    id: u32,
    /// From where it saw the scene when it learnt last, see [`eye_of`], in what light, and when that was.
    eye: DVec3,
    light: FrameLight,
    frame: u32,
    /// The last one that it took part in.
    round: u32,
}

/// What a view sees of a scene: cells are for what looks alike.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    eye: DVec3,
    light: FrameLight,
    exposure: f64,
}

impl Sight {
    pub fn new(camera: &Camera, light: FrameLight, exposure: f64, cache: &SceneCache) -> Self {
        Self { eye: eye_of(camera, cache), light, exposure }
    }
}

/// The cells.
#[derive(Debug)]
pub(super) struct LightCells {
    /// What it takes of the device's memory.
    room: LightRoom,
    cells: ResourceId,
    slots: u32,
    /// As many as there would be, were there room.
    wanted_slots: u32,
    points: ResourceId,
    capacity: u32,
    most_points: u64,
    /// Which volumes' cells they are.
    volumes: Vec<Numbered>,
    scene_version: u64,
    /// In which they have learnt.
    light: FrameLight,
    /// What light is multiplied by in cells.
    scale: f64,
    /// Counts how often they have learnt.
    frame: u32,
    /// Times for which they forget faster, for the scene has changed.
    settling: u32,
    viewers: Vec<Viewer>,
    viewers_so_far: u32,
    /// Counts rounds of their frames, as a headset's: one teaches in each.
    round: u32,
    /// The device has them no more.
    is_over: bool,
}

/// What paths of a view teach cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lesson {
    /// So many of them for each pixel of its picture.
    pub density: f64,
    pub light: FrameLight,
    pub camera: Camera,
}

impl SharedCells {
    /// Those that another view learns with, if it sees the same, or new ones; `None` where voxels leave no room.
    pub fn new(sight: &Sight, cache: &SceneCache, recording: &mut Recording) -> Option<Self> {
        let scene = cache.kept_cells();
        let found = scene.find(sight, cache);
        let all = match found {
            Some(all) => all,
            None => {
                let new = Arc::new(Mutex::new(LightCells::new(sight, cache, recording)?));
                scene.lock().push(Arc::downgrade(&new));
                new
            }
        };
        let mut cells = lock(&all);
        let viewer = cells.viewers_so_far;
        cells.viewers_so_far += 1;
        let (frame, round) = (cells.frame, cells.round.wrapping_sub(1));
        cells.viewers.push(Viewer { id: viewer, eye: sight.eye, light: sight.light, frame, round });
        drop(cells);
        Some(Self { all, scene: scene.clone(), viewer })
    }

    pub fn lock(&self) -> MutexGuard<'_, LightCells> {
        lock(&self.all)
    }

    /// Which of those that share them this is, from 0 on.
    pub fn viewer(&self) -> u32 {
        self.viewer
    }

    /// Whether a view can go on with them that sees the scene like this. They hold what they know of volumes that stay, unless there
    /// would be far more room for them now, or far less, or voxels leave them none: then nobody can.
    pub fn fits(&self, sight: &Sight, cache: &SceneCache, gone: &mut Recording) -> bool {
        let mut cells = self.lock();
        if !cells.is_over && !cells.has_room(cache) {
            cells.free(gone);
        }
        !cells.is_over
            && Arc::ptr_eq(&self.scene.0, &cache.kept_cells().0)
            && cells.shows(sight.exposure, cache)
            && cells.agrees(self.viewer, sight, cache)
    }

    /// Bytes of the device's memory, of which each of those that share them has a part.
    pub fn bytes(&self) -> u64 {
        let cells = self.lock();
        let sharers = cells.viewers.len().max(1) as u64;
        let is_first = cells.viewers.first().is_some_and(|it| it.id == self.viewer);
        cells.room.bytes() / sharers + if is_first { cells.room.bytes() % sharers } else { 0 }
    }

    /// Whether they learn from this view in this frame. What has changed they all have to be told at once.
    pub fn take_turn(&self, light: FrameLight, cache: &SceneCache) -> bool {
        let mut cells = self.lock();
        let is_changed = cells.scene_version != cache.version() || cells.light != light;
        let (sharers, place) = cells.place_among_recent(self.viewer);
        let LightCells { viewers, round, .. } = &mut *cells;
        let Some(own) = viewers.iter_mut().find(|it| it.id == self.viewer) else { return true };
        // Whoever comes again begins the next one.
        if own.round == *round {
            *round = round.wrapping_add(1);
        }
        own.round = *round;
        is_changed || *round % sharers == place
    }

    /// The passes by which cells learn from a view's paths: where their rays end, and the paths, come before them.
    pub fn learn(&self, lesson: &Lesson, cache: &SceneCache, recording: &mut Recording) -> LightCellsPass {
        self.lock().learn(self.viewer, lesson, cache, recording)
    }

    /// The view goes without them from now on. The last one takes them along.
    pub fn free(self, gone: &mut Recording) {
        let mut cells = self.lock();
        if cells.viewers.len() == 1 && !cells.is_over {
            cells.free(gone);
        }
    }
}

impl Drop for SharedCells {
    /// One that was not [freed](Self::free) is none of those that share them any more, either.
    fn drop(&mut self) {
        self.lock().viewers.retain(|viewer| viewer.id != self.viewer);
    }
}

impl CellsOfScene {
    fn lock(&self) -> MutexGuard<'_, Vec<Weak<Mutex<LightCells>>>> {
        lock(&self.0)
    }

    /// Cells for what is seen like this.
    fn find(&self, sight: &Sight, cache: &SceneCache) -> Option<Arc<Mutex<LightCells>>> {
        let mut all = self.lock();
        all.retain(|cells| cells.strong_count() > 0);
        all.iter().filter_map(Weak::upgrade).find(|all| {
            let cells = lock(all);
            // Whoever has just come has no light of its own that they could follow.
            !cells.is_over
                && cells.light == sight.light
                && cells.has_room(cache)
                && cells.shows(sight.exposure, cache)
                && cells.viewers.iter().all(|other| is_alike(other.eye, sight.eye, cache))
        })
    }
}

impl LightCells {
    /// Empty ones, if voxels leave room.
    fn new(sight: &Sight, cache: &SceneCache, recording: &mut Recording) -> Option<Self> {
        let limit = cache.limits().max_storage_binding;
        let wanted_slots = slots_for(cache);
        let all_bytes = |slots: u64| cells_bytes(slots) + points_bytes(FEWEST_POINTS);
        let fewest = all_bytes(u64::from(wanted_slots).min(FEWEST_BLOCKS as u64));
        let mut room = cache.store().light_room(fewest, all_bytes(wanted_slots.into()))?;
        let fitting = (room.bytes() - all_bytes(0)) / (BLOCK_WORDS * 4);
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
            volumes: cache.numbers().unwrap_or_default().to_vec(),
            scene_version: cache.version(),
            light: sight.light,
            scale: scale_of(sight.exposure * cache.light_scale()),
            frame: 0,
            settling: 0,
            viewers: vec![],
            viewers_so_far: 0,
            round: 0,
            is_over: false,
        })
    }

    /// Whether they are about as many as there should be, and voxels leave them room.
    fn has_room(&self, cache: &SceneCache) -> bool {
        let slots = slots_for(cache);
        slots < 2 * self.wanted_slots && slots > self.wanted_slots / 4 && self.room.is_left()
    }

    /// Whether pictures can be as bright as that.
    fn shows(&self, exposure: f64, cache: &SceneCache) -> bool {
        let shown = exposure * cache.light_scale();
        let ratio = scale_of(shown) / self.scale;
        shown == 0.0 || (1.0 / BRIGHTER..=BRIGHTER).contains(&ratio)
    }

    /// Those of late, and one that is here now.
    fn recent(&self, viewer: u32) -> impl Iterator<Item = &Viewer> {
        let rest = RECENT * self.viewers.len() as u32;
        self.viewers.iter().filter(move |it| it.id == viewer || self.frame - it.frame <= rest)
    }

    /// How many those are, one at least, and how many of them come before it.
    fn place_among_recent(&self, viewer: u32) -> (u32, u32) {
        let before = self.recent(viewer).take_while(|it| it.id != viewer).count() as u32;
        (self.recent(viewer).count().max(1) as u32, before)
    }

    /// Whether one of those that share them can go on with the others.
    fn agrees(&self, viewer: u32, sight: &Sight, cache: &SceneCache) -> bool {
        let mut others = self.recent(viewer).filter(|it| it.id != viewer).peekable();
        let own = self.viewers.iter().find(|it| it.id == viewer);
        // Another's light, which was never this one's.
        let is_others = self.light != sight.light && own.is_none_or(|own| own.light != self.light);
        others.peek().is_none() || !is_others && others.all(|other| is_alike(other.eye, sight.eye, cache))
    }

    /// Whether any point was ever taken.
    pub fn is_filled(&self) -> bool {
        self.frame > 0
    }

    /// Counts how often they have learnt.
    pub fn frame(&self) -> u32 {
        self.frame
    }

    pub fn most_paths(&self) -> u64 {
        (self.most_points as f64 * PATHS_A_POINT) as u64
    }

    pub fn resources(&self) -> LightResources {
        LightResources { cells: self.cells, points: self.points }
    }

    /// Points there is room for.
    pub fn capacity(&self) -> u32 {
        self.capacity
    }

    /// Blocks there is room for.
    pub fn slots(&self) -> u32 {
        self.slots
    }

    /// What light is multiplied by in cells.
    pub fn scale(&self) -> f32 {
        self.scale as f32
    }

    /// Room for the points of so many paths, if there is any.
    pub fn make_room(&mut self, paths: u64, gone: &mut Recording, recording: &mut Recording) {
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

    fn learn(
        &mut self,
        viewer: u32,
        lesson: &Lesson,
        cache: &SceneCache,
        recording: &mut Recording,
    ) -> LightCellsPass {
        self.frame += 1;
        let forgets = self.forget_gone(cache, recording);
        // Whatever cameras do, and films with them: light that has changed a little lets cells keep a part of theirs.
        let [kept, scale] = lesson.light.since(&std::mem::replace(&mut self.light, lesson.light));
        let other_scene = std::mem::replace(&mut self.scene_version, cache.version()) != cache.version();
        let other_light = kept < LEAST_KEPT;
        let most = match (other_light, other_scene) {
            (true, _) => REMEMBERED_OF_OTHER_LIGHT,
            (false, true) => REMEMBERED_OF_ANOTHER_SCENE,
            (false, false) => MOST_REMEMBERED,
        };
        let kept = if other_light { 1.0 } else { kept } * self.kept_from(viewer, lesson, cache);
        let kept = kept as f32 * if self.settling > 0 { KEPT_WHILE_SETTLING } else { 1.0 };
        self.settling = match most {
            MOST_REMEMBERED => self.settling.saturating_sub(1),
            _ => SETTLING,
        };
        let params = layout::LightParams {
            slots: self.slots,
            frame: self.frame,
            points: self.capacity,
            kept,
            most_points: most.min(MOST_REMEMBERED),
            most_mirrored: most.min(MOST_MIRRORED),
            trusted_points: TRUSTED,
            is_changing: u32::from(self.settling > 0),
            coarse_share: (COARSE_POINTS / lesson.density).min(1.0) as f32,
            coarsest_share: (COARSEST_POINTS / lesson.density).min(1.0) as f32,
            forgets: u32::from(forgets),
            scale: scale as f32,
            ..Default::default()
        };
        LightCellsPass { resources: self.resources(), params }
    }

    /// The part that is kept by what is looked at from elsewhere than before.
    fn kept_from(&mut self, viewer: u32, lesson: &Lesson, cache: &SceneCache) -> f64 {
        let eye = eye_of(&lesson.camera, cache);
        let Some(own) = self.viewers.iter_mut().find(|it| it.id == viewer) else { return 1.0 };
        let before = std::mem::replace(own, Viewer { eye, light: lesson.light, frame: self.frame, ..*own });
        // None has seen anything before the first time.
        if self.frame == 1 {
            return 1.0;
        }
        // Another may have been here meanwhile.
        let others = self.viewers.iter().filter(|it| it.id != viewer).map(|it| it.eye);
        let turned = others.map(|other| angle(other, eye)).fold(angle(before.eye, eye), f64::min);
        (-turned * cache.steepest_phase() / OTHER_PHASE).exp()
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

    fn free(&mut self, gone: &mut Recording) {
        self.is_over = true;
        self.room.resize(0);
        for id in [self.cells, self.points] {
            gone.push(Step::Free { id });
        }
    }
}

/// Of what can be broken by a panic nothing is left half done.
fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The direction from which a camera sees a scene's middle; zero from within that.
fn eye_of(camera: &Camera, cache: &SceneCache) -> DVec3 {
    let place = camera.world_from_camera;
    let eye = match camera.projection {
        Projection::Perspective { .. } => place.translation - cache.origin(),
        Projection::Orthographic { .. } => place.matrix3.z_axis,
    };
    eye.normalize_or_zero()
}

/// Between directions, in radians; 0 where there is none.
fn angle(a: DVec3, b: DVec3) -> f64 {
    if a == DVec3::ZERO || b == DVec3::ZERO { 0.0 } else { a.angle_between(b) }
}

/// Whether what is sent on to both is about the same.
fn is_alike(a: DVec3, b: DVec3, cache: &SceneCache) -> bool {
    let by_surfaces = if cache.reflects() { 1.0 / OTHER_SIDE } else { 0.0 };
    angle(a, b) * (by_surfaces + cache.steepest_phase() / OTHER_PHASE) <= 1.0
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

/// A power of two near the exposure: in cells light is about as bright as it is shown, whatever its unit.
fn scale_of(exposure: f64) -> f64 {
    let bounded = if exposure.is_finite() { exposure.clamp(1e-12, 1e12) } else { 1.0 };
    bounded.log2().round().exp2()
}
