//! The worlds and views of one device, a frame at a time: what every engine does between gathering its scenes and
//! replaying recordings.
//!
//! An engine draws frames, each frame some views, each view one world; several views may show one. In each frame it asks
//! the [`Stage`] for the recording that brings a view's world up to date, replays it, and tells what became of it; then for
//! the one that traces the view and draws it, and so on. A world whose kernels or voxels take long is prepared on other
//! threads: until it is there, a view goes on with what it showed before. Nothing here knows an engine or a GPU.

mod eye;
mod kept_light;
mod uploads;
mod world;

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fmt::Debug;
use std::hash::Hash;

use lumivox_core::host::Moment;
use lumivox_core::{Camera, Scene};

use self::eye::{Eye, Trace};
use self::uploads::Uploads;
use self::world::World;
use crate::error::RenderError;
use crate::limits::DeviceLimits;
use crate::live::{HostFrame, Image, LiveImage, LiveSettings, LiveStatus};
use crate::recording::{Kernel, Recording, ResourceId, Step, TextureOrder};
use crate::store::VoxelStore;

/// What tells worlds, or views, from each other: the engine's own names.
pub trait Key: Copy + Eq + Hash + Debug {}

impl<T: Copy + Eq + Hash + Debug> Key for T {}

/// What a host makes on other threads, ahead of the frame that wants it.
pub trait Workbench {
    /// Whether these kernels are made; those that are not are on their way then.
    fn are_ready(&self, kernels: &[Kernel]) -> bool;

    /// What [makes textures ahead](crate::Preparation::run_with), on whatever thread.
    fn texture_maker(&self) -> Box<dyn FnMut(&TextureOrder) -> bool + Send>;
}

/// A host whose kernels come with it, and that makes textures where recordings say so.
#[derive(Clone, Copy, Debug, Default)]
pub struct NothingAhead;

impl Workbench for NothingAhead {
    fn are_ready(&self, _: &[Kernel]) -> bool {
        true
    }

    fn texture_maker(&self) -> Box<dyn FnMut(&TextureOrder) -> bool + Send> {
        Box::new(|_| false)
    }
}

/// The renderer's names of the textures that a host lends to a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lent {
    /// The depth that ends rays.
    pub depth: ResourceId,
    /// The colour that volumes are drawn over.
    pub color: ResourceId,
    /// Where volumes write their depth.
    pub written_depth: ResourceId,
    /// What the host has resolved of a multisampled colour.
    pub resolved_color: ResourceId,
    /// Where volumes write how far they have moved.
    pub velocity: ResourceId,
}

impl Lent {
    fn new() -> Self {
        Self {
            depth: ResourceId::external(),
            color: ResourceId::external(),
            written_depth: ResourceId::external(),
            resolved_color: ResourceId::external(),
            velocity: ResourceId::external(),
        }
    }

    fn ids(self) -> [ResourceId; 5] {
        [self.depth, self.color, self.written_depth, self.resolved_color, self.velocity]
    }
}

/// What a view shows in this frame.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct ViewFrame {
    /// Where it is seen from.
    pub camera: Camera,
    /// How it is traced and shown.
    pub settings: LiveSettings,
    /// What the host lends, by the names of [`Lent`].
    pub host: HostFrame,
    /// Milliseconds of the GPU's time that it has.
    pub budget_milliseconds: f64,
}

impl ViewFrame {
    /// All of it.
    pub fn new(camera: Camera, settings: LiveSettings, host: HostFrame, budget_milliseconds: f64) -> Self {
        Self { camera, settings, host, budget_milliseconds }
    }
}

/// How far a world's copy on the device is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorldState {
    /// It is there.
    Done,
    /// It is there, but for finer voxels that are on their way.
    Arriving,
    /// The one before is there while something is prepared for the next.
    Before,
    /// Nothing is there yet.
    Nothing,
}

/// A world that a view shows in this frame: the one that it is to show, or another in its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shown<W> {
    wanted: W,
    world: W,
}

/// How far a view is, with the world that it is to show.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct ViewProgress {
    /// Of what was traced in this frame; none of it counts while the world before is shown.
    pub live: LiveStatus,
    /// Whether there is nothing more to do unless something changes.
    pub is_converged: bool,
}

/// What a host is to replay, and what to [tell](Stage::executed) afterwards.
#[derive(Debug)]
#[must_use]
pub struct Recorded<W, V> {
    /// The steps.
    pub recording: Recording,
    part: Part<W, V>,
}

/// A frame of a view.
#[derive(Debug)]
#[must_use]
pub struct ViewRecorded<W, V> {
    /// What is replayed.
    pub recorded: Recorded<W, V>,
    /// How far the view is by what is known now.
    pub status: LiveStatus,
    /// What the steps call the textures that the host lends.
    pub lent: Lent,
}

#[derive(Debug)]
enum Part<W, V> {
    World {
        world: W,
        version: u64,
        granted: u64,
        left: u64,
        began: Moment,
        error: Option<StageError>,
    },
    View {
        view: V,
        ticket: u64,
        trace: Trace,
    },
    /// Nothing depends on it.
    Rest,
}

impl<W, V> Recorded<W, V> {
    /// Whom the read-backs belong to; 0 where there are none.
    pub fn ticket(&self) -> u64 {
        match &self.part {
            Part::View { ticket, .. } => *ticket,
            _ => 0,
        }
    }
}

/// A recording on which nothing of a stage depends.
impl<W, V> From<Recording> for Recorded<W, V> {
    fn from(recording: Recording) -> Self {
        Self { recording, part: Part::Rest }
    }
}

/// Why a host could not replay a recording. What the recording made, and what it would have freed, is freed by the host.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// The device has no room.
    #[error("{0}")]
    Memory(String),
    /// Anything else.
    #[error("{0}")]
    Other(String),
}

/// Why nothing is shown of a world or a view.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StageError {
    /// It cannot be recorded.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The host could not replay what was recorded.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// A fault of the host's: the world was [swept](Stage::sweep) after it was said to be [shown](Stage::shown).
    #[error("a fault in Lumivox: a world was swept before it was shown")]
    Swept,
}

/// For hosts that say it in words.
impl From<StageError> for String {
    fn from(error: StageError) -> Self {
        error.to_string()
    }
}

/// All that is shown on one device. `W` names worlds, `V` views.
#[derive(Debug)]
pub struct Stage<W, V> {
    store: VoxelStore,
    worlds: HashMap<W, World>,
    eyes: HashMap<V, Eye<W>>,
    uploads: Uploads,
    /// The engine's number.
    frame: u64,
    last_ticket: u64,
    /// Steps that go with the next recording.
    left_over: Vec<Step>,
    /// Whether a view left a world since the last sweep.
    wants_sweep: bool,
    computed: u64,
    postponed: u64,
    /// Whether the host could not replay what light is kept with.
    refuses_light: bool,
}

impl<W: Key, V: Key> Stage<W, V> {
    /// Nothing is shown yet.
    pub fn new(limits: DeviceLimits) -> Self {
        Self {
            store: VoxelStore::new(limits),
            worlds: HashMap::new(),
            eyes: HashMap::new(),
            uploads: Uploads::default(),
            frame: 0,
            last_ticket: 0,
            left_over: vec![],
            wants_sweep: false,
            computed: 0,
            postponed: 0,
            refuses_light: false,
        }
    }

    /// The voxels on the device.
    pub fn store(&self) -> &VoxelStore {
        &self.store
    }

    /// The engine begins a frame, or goes on with it, by a number that goes up by one with each. What voxels a frame brings
    /// is shared by all its worlds.
    pub fn begin_frame(&mut self, number: u64) {
        self.frame = number;
    }

    /// How often an update had to compute something that takes long, and how many frames showed a world's predecessor
    /// because a kernel was missing: 0 where all was prepared in time.
    pub fn stalls(&self) -> [u64; 2] {
        [self.computed, self.postponed]
    }

    /// Records what brings a world's copy up to date with `scene`, whose `version` tells it from others; `None` where there
    /// is nothing to record. `at_once`: this frame has to show it, however long that takes.
    ///
    /// # Errors
    /// Why it does not fit. That is not tried again until the scene changes.
    pub fn update(
        &mut self,
        world: W,
        scene: &Scene,
        version: u64,
        at_once: bool,
        workbench: &impl Workbench,
    ) -> Result<Option<Recorded<W, V>>, StageError> {
        let mut recording = self.begin_recording();
        self.store.collect(&mut recording);
        let place = self.worlds.entry(world).or_insert_with(|| World::new(&self.store));
        let is_another = place.version != version;
        if !is_another && (place.error.is_some() || place.cache.is_settled()) {
            return match &place.error {
                Some(error) => {
                    let error = error.clone();
                    self.left_over.extend(recording.steps);
                    Err(error)
                }
                None => {
                    place.state = WorldState::Done;
                    place.prepare_light(scene, at_once, workbench);
                    Ok(rest(recording))
                }
            };
        }
        if !is_another
            && !at_once
            && place.is_whole
            && self.uploads.is_used_up(self.frame)
            && !place.was_skipped
        {
            // Another view of this frame has brought what it may. Another world's may do so with every frame: not twice.
            place.was_skipped = true;
            return Ok(rest(recording));
        }
        place.was_skipped = false;
        if is_another
            && !at_once
            && let Some(missing) = place.unprepared(scene, workbench)
        {
            self.postponed += u64::from(missing == world::Missing::Kernels);
            place.state = if place.is_whole { WorldState::Before } else { WorldState::Nothing };
            return Ok(rest(recording));
        }
        place.version = version;
        place.prepare_light(scene, at_once, workbench);
        let computed = place.cache.unprepared();
        let granted = if at_once { u64::MAX } else { self.uploads.budget(self.frame) };
        let (mut left, began) = (granted, Moment::now());
        let updated = place.cache.update_within(scene, &mut left, &mut recording);
        self.computed += place.cache.unprepared() - computed;
        // Also after an error: that room was made may be recorded.
        let error = updated.err().map(StageError::from);
        let part = Part::World { world, version, granted, left, began, error };
        Ok(Some(Recorded { recording, part }))
    }

    /// How far a world is. One that nobody updated is not there.
    pub fn world_state(&self, world: W) -> WorldState {
        self.worlds.get(&world).map_or(WorldState::Nothing, |world| world.state)
    }

    /// Whether a world's copy is that of a version, or came to nothing with it.
    pub fn holds(&self, world: W, version: u64) -> bool {
        self.worlds.get(&world).is_some_and(|world| world.version == version)
    }

    /// What there is to show of `wanted`: that, or while there is nothing of it yet, the world that `view` showed before, if
    /// that one `may_stand_in`. `None` where there is nothing to show.
    pub fn shown(&self, view: V, wanted: W, may_stand_in: impl FnOnce(&W) -> bool) -> Option<Shown<W>> {
        let is_whole = |world: &W| self.worlds.get(world).is_some_and(|world| world.is_whole);
        let before = || self.eyes.get(&view).map(|eye| eye.world).filter(may_stand_in);
        let world = Some(wanted).filter(is_whole).or_else(|| before().filter(is_whole))?;
        Some(Shown { wanted, world })
    }

    /// Records a view's frame of what is [shown](Self::shown); `frame` says how, given the names of what is lent.
    ///
    /// # Errors
    /// Why it cannot be shown.
    pub fn record_view(
        &mut self,
        view: V,
        shown: Shown<W>,
        frame: impl FnOnce(Lent) -> ViewFrame,
    ) -> Result<ViewRecorded<W, V>, StageError> {
        let Shown { wanted, world: shown } = shown;
        if !self.worlds.contains_key(&shown) {
            return Err(StageError::Swept);
        }
        let is_before = shown != wanted || self.world_state(wanted) == WorldState::Before;
        let mut recording = self.begin_recording();
        let known = self.eyes.get_mut(&view);
        let lent = known.as_ref().map_or_else(Lent::new, |eye| eye.lent);
        let mut frame = frame(lent);
        frame.settings.kept_light &= !self.refuses_light;
        if let Some(eye) = known {
            if eye.world != shown {
                eye.pacer.distrust();
            } else if is_before && let Some(ambient) = eye.ambient() {
                // A scene goes with its own light, also when it is the one before.
                frame.settings.ambient = ambient;
            }
        }
        let recorded = self.record_eye(view, shown, lent, &mut frame, &mut recording);
        match recorded {
            Ok(trace) => {
                let status = trace.status;
                let part = Part::View { view, ticket: self.last_ticket, trace };
                Ok(ViewRecorded { recorded: Recorded { recording, part }, status, lent })
            }
            Err(error) => {
                // What a new eye's films are made of goes with the next recording: the next frame counts on them.
                self.left_over = recording.steps;
                Err(error.into())
            }
        }
    }

    /// Records a frame of an eye that is made where there is none.
    fn record_eye(
        &mut self,
        view: V,
        shown: W,
        lent: Lent,
        frame: &mut ViewFrame,
        recording: &mut Recording,
    ) -> Result<Trace, RenderError> {
        let Self { eyes, wants_sweep, worlds, .. } = self;
        let world = worlds.get_mut(&shown).expect("it is known");
        world.has_guides |= frame.settings.guides;
        world.wants_light |= frame.settings.kept_light;
        // Not before its kernels are made.
        frame.settings.kept_light &= world.keeps_light;
        let eye = match eyes.entry(view) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(vacant) => vacant.insert(Eye::new(&frame.settings, world, shown, lent, recording)?),
        };
        let trace = eye.record(world, frame, recording)?;
        // It starts over there, in the films that it has.
        *wants_sweep |= std::mem::replace(&mut eye.world, shown) != shown;
        self.last_ticket += 1;
        eye.ticket_began(self.last_ticket);
        Ok(trace)
    }

    /// How far a view is with the world that it is to show. What is known by now, read-backs included.
    pub fn view_progress(&self, view: V, wanted: W) -> Option<ViewProgress> {
        let eye = self.eyes.get(&view)?;
        let live = eye.live.status();
        let state = self.world_state(wanted);
        if eye.world != wanted || !matches!(state, WorldState::Done | WorldState::Arriving) {
            // An image of the world before counts for nothing.
            return Some(ViewProgress {
                live: LiveStatus { samples: 0, progress: 0.0, ..live },
                is_converged: false,
            });
        }
        Some(ViewProgress { live, is_converged: live.converged && state == WorldState::Done })
    }

    /// Where an image of a view lies that holds something after its last recording, as [`LiveView::image`] says it.
    ///
    /// [`LiveView::image`]: crate::LiveView::image
    pub fn image(&self, view: V, name: LiveImage) -> Option<Image> {
        self.eyes.get(&view)?.live.image(name)
    }

    /// Milliseconds that tracing a view took in a recent frame; 0 where the host does not tell.
    pub fn view_milliseconds(&self, view: V) -> f64 {
        self.eyes.get(&view).map_or(0.0, |eye| eye.pacer.milliseconds())
    }

    /// Tells what became of a recording, in the order in which they were recorded.
    ///
    /// # Errors
    /// Why nothing is shown of it. A volume that the device refused comes reduced, if that may help, and a view goes on without
    /// the light that was kept for it: that is none.
    pub fn executed(
        &mut self,
        recorded: Recorded<W, V>,
        outcome: Result<(), Refusal>,
    ) -> Result<(), StageError> {
        let Recorded { recording, part } = recorded;
        match part {
            Part::World { world, version, granted, left, began, mut error } => {
                match outcome {
                    Ok(()) => {
                        if granted < u64::MAX {
                            let took = began.elapsed().as_secs_f64() * 1e3;
                            self.uploads.took(granted - left, granted, took);
                        }
                    }
                    Err(refusal) => {
                        let may_come_reduced = self.store.refused(&recording);
                        self.drop_light();
                        self.forget_world(world);
                        self.forget_broken_worlds();
                        if matches!(refusal, Refusal::Memory(_)) && may_come_reduced {
                            return Ok(());
                        }
                        error = Some(refusal.into());
                    }
                }
                if let Some(place) = self.worlds.get_mut(&world) {
                    place.updated(version, error.clone());
                }
                error.map_or(Ok(()), Err)
            }
            Part::View { view, ticket, trace } => match outcome {
                Ok(()) => {
                    if let Some(eye) = self.eyes.get_mut(&view) {
                        eye.executed(ticket, &trace);
                    }
                    Ok(())
                }
                Err(refusal) => self.view_refused(view, refusal),
            },
            Part::Rest => Ok(()),
        }
    }

    /// Hands over the bytes of a read-back; none, if it got lost. Those of one ticket come in the order of their steps.
    /// Of a view that is gone or started anew they are passed over.
    pub fn feedback(&mut self, ticket: u64, bytes: &[u8]) {
        if let Some(eye) = self.eyes.values_mut().find(|eye| eye.has_ticket(ticket)) {
            eye.live.feedback(bytes);
        }
    }

    /// The GPU took so long to trace the frame of a ticket.
    pub fn measured(&mut self, ticket: u64, milliseconds: f64) {
        if let Some(eye) = self.eyes.values_mut().find(|eye| eye.has_ticket(ticket)) {
            eye.pacer.measured(ticket, milliseconds);
        }
    }

    /// Whether a view has left a world since the last [sweep](Self::sweep). Perhaps nobody else shows it.
    pub fn wants_sweep(&self) -> bool {
        self.wants_sweep
    }

    /// Records that everything is freed that belongs to no view or world that is `kept`. A view goes on with its world until
    /// the next is there.
    pub fn sweep(
        &mut self,
        keeps_view: impl Fn(&V) -> bool,
        keeps_world: impl Fn(&W) -> bool,
    ) -> Option<Recorded<W, V>> {
        self.wants_sweep = false;
        let mut recording = self.begin_recording();
        let gone: Vec<V> = self.eyes.keys().filter(|view| !keeps_view(view)).copied().collect();
        for view in gone {
            if let Some(eye) = self.eyes.remove(&view) {
                eye.free(&mut recording);
            }
        }
        let in_use: Vec<W> = self.eyes.values().map(|eye| eye.world).collect();
        let is_gone = |world: &&W| !keeps_world(world) && !in_use.contains(world);
        let gone: Vec<W> = self.worlds.keys().filter(is_gone).copied().collect();
        for world in gone {
            self.forget_world(world);
            self.worlds.remove(&world);
        }
        recording.steps.append(&mut self.left_over);
        self.store.collect(&mut recording);
        rest(recording)
    }

    /// Hands over what would go with the next recording: what is freed after an error. For a host that does not want to wait,
    /// as there may be no next one for long.
    pub fn left_over(&mut self) -> Option<Recorded<W, V>> {
        rest(self.begin_recording())
    }

    /// Starts a world over whose copy is not whole.
    fn forget_world(&mut self, world: W) {
        let Some(place) = self.worlds.get_mut(&world) else { return };
        let mut frees = Recording::new();
        place.forget(&self.store).free(&mut frees);
        self.left_over.extend(frees.steps);
    }

    /// Those that showed what a refused recording took along are made anew before they are drawn.
    fn forget_broken_worlds(&mut self) {
        let is_broken = |(_, place): &(&W, &World)| !place.cache.is_intact();
        let broken: Vec<W> = self.worlds.iter().filter(is_broken).map(|(world, _)| *world).collect();
        for world in broken {
            self.forget_world(world);
        }
    }

    fn begin_recording(&mut self) -> Recording {
        Recording { steps: std::mem::take(&mut self.left_over) }
    }
}

/// A recording on which nothing depends; `None` where it is empty.
fn rest<W, V>(recording: Recording) -> Option<Recorded<W, V>> {
    (!recording.is_empty()).then(|| recording.into())
}

#[cfg(test)]
mod tests;
