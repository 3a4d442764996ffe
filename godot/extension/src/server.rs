//! The main thread's side: once per frame, worlds go to the render thread; and the singleton that scripts ask.

use std::cell::{Cell, RefCell};
use std::collections::{HashMap, HashSet};

use godot::classes::{DisplayServer, PackedScene, RenderData, RenderingServer, Viewport};
use godot::prelude::*;
use lumivox_core::{CancelToken, Progress};
use lumivox_renderer::recording::Kernel;
use lumivox_renderer::{DeviceLimits, Features, ViewKind};

use crate::executor::{self, Executor, workshop};
use crate::nodes::LumivoxVolume3D;
use crate::shared::{Status, Target};
use crate::world::{Gatherer, Nodes, View, render_target};
use crate::{codecs, convert, render, scene_file, shared, warm_up};

thread_local! {
    static NODES: RefCell<Nodes> = RefCell::default();
    static GATHERER: RefCell<Gatherer> = RefCell::default();
    /// The error that nodes show in the editor, and how many of them have a scan that is shown reduced.
    static WARNED_OF: RefCell<(Option<String>, usize)> = const { RefCell::new((None, 0)) };
    static CALLBACKS: RefCell<Option<Callbacks>> = const { RefCell::new(None) };
    /// What was announced.
    static REACHED: RefCell<Reached> = RefCell::default();
    /// Whether a frame was drawn since the main loop last came by.
    static DRAWN: Cell<bool> = const { Cell::new(false) };
}

/// How the volumes on screen are doing, for scripts.
#[derive(GodotClass)]
#[class(tool, init, singleton, base = Object)]
pub struct Lumivox {
    base: Base<Object>,
}

#[godot_api]
impl Lumivox {
    /// How far the image of [param viewport] is: [code]samples[/code] that every pixel has of [code]target[/code],
    /// [code]progress[/code] (0 to 1: the part of its samples that is traced, for progress bars; it moves also while some pixel
    /// has none), [code]arrived[/code] (whether its scans are there as finely as they will be), [code]converged[/code], [code]ms_per_frame[/code] (the GPU's time that tracing took in a recent frame; 0
    /// where the driver does not tell), [code]pixel_samples[/code] traced in the last frame, and [code]kept_light_bytes[/code] of the
    /// GPU's memory for [member LumivoxEffect.kept_light] (0 where none is kept). Empty if it shows no
    /// volume, be it because its [LumivoxEffect] is disabled.
    ///
    /// This is known of the frame that was drawn last: after a change, await
    /// [signal RenderingServer.frame_post_draw] first.
    #[func]
    pub fn get_status(&self, viewport: Option<Gd<Viewport>>) -> VarDictionary {
        let Some(viewport) = viewport else {
            godot_error!("Lumivox.get_status: there is no viewport: it is null");
            return VarDictionary::new();
        };
        // Asked for first: the render thread, which answers, may be waiting for the lock.
        let target = render_target(&viewport);
        let status = shared::lock().statuses.get(&target).copied();
        status.map_or_else(VarDictionary::new, |status| {
            vdict! {
                "samples" => i64::from(status.samples),
                "target" => i64::from(status.target),
                "progress" => f64::from(status.progress),
                "arrived" => status.arrived,
                "converged" => status.converged,
                "ms_per_frame" => status.milliseconds,
                "pixel_samples" => status.pixel_samples as i64,
                "kept_light_bytes" => status.light_bytes as i64,
            }
        })
    }

    /// Whether the image of [param viewport] is done, and nothing of its volumes is still computed (see
    /// [method LumivoxVolume3D.is_preparing]). Also true if it shows no volume, be it because its
    /// [LumivoxEffect] is disabled. Samples are added while the viewport is drawn: with
    /// [constant SubViewport.UPDATE_ONCE] it is drawn once, and may never be done.
    ///
    /// This is known of the frame that was drawn last: after a change, be it a volume that was just added, await
    /// [signal RenderingServer.frame_post_draw] first.
    #[func]
    pub fn is_converged(&self, viewport: Option<Gd<Viewport>>) -> bool {
        let Some(viewport) = viewport else {
            godot_error!("Lumivox.is_converged: there is no viewport: it is null");
            return false;
        };
        let target = render_target(&viewport);
        let shared = shared::lock();
        match shared.statuses.get(&target) {
            Some(status) => {
                let is_preparing = shared.targets.get(&target).is_some_and(|target| target.preparing);
                status.converged && !is_preparing
            }
            // A volume that was not drawn yet is not done.
            None => !shared.targets.contains_key(&target),
        }
    }

    /// The image of a viewport is done: [method is_converged] has become true of it.
    #[signal]
    fn converged(viewport: Gd<Viewport>);

    /// The scans that a viewport shows are there as finely as they will be: large ones are coarse at first.
    #[signal]
    fn arrived(viewport: Gd<Viewport>);

    /// Why volumes cannot be drawn, or an empty string.
    #[func]
    pub fn last_error(&self) -> GString {
        GString::from(shared::lock().error.as_deref().unwrap_or_default())
    }

    /// Writes what [param viewport] shows of volumes as a scene file, which Lumivox' command, Python and other engines render:
    /// volumes with their looks, cuts, labels and place, the light, the camera, and how the picture is made. Scans are
    /// not copied: the file names theirs, as seen from its own folder. A sky that came from no file is written beside it, as
    /// OpenEXR. Meshes and fog are no part of it. [param path] may begin with [code]res://[/code] or [code]user://[/code], and
    /// ends as [code].lumivox[/code] by custom.
    ///
    /// Returns an empty string, or what cannot be saved and why: a scan that was made in memory has no file, nor has one
    /// of the project in an exported game.
    #[func]
    fn save_scene(&self, viewport: Option<Gd<Viewport>>, path: GString) -> GString {
        let Some(viewport) = viewport else { return GString::from("there is no viewport: it is null") };
        if path.is_empty() {
            return GString::from("the scene needs a file to be written to");
        }
        match scene_file::save(&viewport, &convert::system_path(&path)) {
            Ok(()) => GString::new(),
            Err(why) => GString::from(&why),
        }
    }

    /// Loads a scene file and the scans that it names, and waits for them: [method LumivoxImporter.open_scene] does it in the
    /// background. The scene has a node for each volume and light, a [Camera3D] and a [WorldEnvironment]. With
    /// [param allow_outside_data], headers such as [code].mhd[/code] may name data files anywhere. Returns [code]null[/code] and
    /// says in the output what is wrong, and on which line, if it cannot be opened; what is to be known of it otherwise is a warning.
    #[func]
    fn load_scene(
        path: GString,
        #[opt(default = false)] allow_outside_data: bool,
    ) -> Option<Gd<PackedScene>> {
        let (silent, never) = (Progress::SILENT, CancelToken::new());
        let file = convert::system_path(&path);
        codecs::name_worker();
        let opened = scene_file::open(&file, allow_outside_data, silent, &never);
        match opened
            .and_then(|opened| Ok((scene_file::packed(&opened, &scene_file::name_of(&file))?, opened)))
        {
            Ok((scene, opened)) => {
                opened.notes.iter().for_each(|note| godot_warn!("{path}: {note}"));
                Some(scene)
            }
            Err(why) => {
                godot_error!("{why}");
                None
            }
        }
    }

    /// All that [method warm_up] was asked for is prepared.
    #[signal]
    fn warmed_up();

    /// Prepares what scenes with volumes need of the GPU's programs, in the background, so that their first frames do
    /// not wait for it: for loading screens. Emits [signal warmed_up] in a later frame.
    ///
    /// [param features] says what the scenes will hold, be it some of it or all at once: [code]environment[/code] (a sky
    /// or Lumivox' studio light, anything that is not one colour), [code]surface[/code] (volumes whose
    /// [member LumivoxVolume3D.surface_strength] is above 0), [code]filters[/code] (volumes whose [member LumivoxVolume3D.filter] is nearest or tricubic),
    /// [code]lights[/code] (lights that reach volumes), [code]many_volumes[/code] (four or more), [code]labels[/code],
    /// [code]functions[/code] (labels with transfer functions of their own), [code]gradients[/code] (functions of value and
    /// gradient), [code]peeling[/code] and [code]clip_shapes[/code] ([LumivoxClip3D]), and [code]classes[/code] for these five. Nothing named
    /// stands for all but those: 32 programs and as many again for [member LumivoxEffect.kept_light]; each named feature doubles their number. Name what there will be: in software a
    /// program takes a second or more. Programs that are there already cost nothing.
    ///
    /// Without it nothing is wrong, only later: while a program is missing, a viewport goes on with the scene before,
    /// and shows no volumes where there was none.
    #[func]
    fn warm_up(&self, #[opt(default = &PackedStringArray::new())] features: PackedStringArray) {
        let names: Vec<String> = features.as_slice().iter().map(|name| name.to_string()).collect();
        match warm_up::features(&names) {
            Ok(features) => {
                warm_up::begin(features, device_limits());
            }
            Err(why) => godot_error!("{why}"),
        }
    }

    /// The part of what [method warm_up] was asked for that is done, from 0 to 1; 1 where nothing was.
    #[func]
    fn get_warm_up_progress(&self) -> f64 {
        warm_up::progress()
    }

    /// For tests: how often the render thread waited for a kernel or made one, how often it computed something of a
    /// volume or an environment, and how many frames showed the scene before because a kernel was missing.
    #[func]
    fn _get_stalls(&self) -> VarDictionary {
        let [computed, postponed] = render::stalls();
        vdict! {
            "kernels" => workshop().waits() as i64,
            "computed" => computed as i64,
            "postponed" => postponed as i64,
        }
    }

    /// The version of Lumivox.
    #[func]
    pub fn version(&self) -> GString {
        GString::from(env!("CARGO_PKG_VERSION"))
    }

    /// Called on the render thread, in the place of effects. Nothing is bound while the main thread goes on.
    #[func(gd_self)]
    fn _draw(_this: Gd<Self>, stage: i32, data: Option<Gd<RenderData>>) {
        if let Some(data) = data {
            render::draw(stage, &data);
        }
    }

    #[func]
    fn _before_frame(&self) {
        before_frame();
    }

    #[func]
    fn _after_frame(&self) {
        after_frame();
    }

    #[func]
    fn _node_added(&self, node: Gd<Node>) {
        NODES.with_borrow_mut(|nodes| nodes.add(&node));
    }
}

/// What the engine calls, so that it can be told not to any more. Methods, not closures: of these the binding warns
/// when the editor ends, though they were disconnected long before.
struct Callbacks {
    before_frame: Callable,
    after_frame: Callable,
    node_added: Callable,
}

/// What the engine's device can do, where it has one.
fn device_limits() -> Option<DeviceLimits> {
    RenderingServer::singleton().get_rendering_device().map(|device| Executor::limits(&device))
}

/// A volume entered a world.
pub fn add_volume(id: InstanceId) {
    if CALLBACKS.with_borrow(Option::is_none) {
        tell_no_device();
    } else {
        let view = ViewKind::Live { guides: false, kept_light: false };
        let of_any_scene = |kernel: &Kernel| !matches!(kernel, Kernel::PathTrace(_));
        let kernels = device_limits().map(|limits| Features::default().kernels(view, limits));
        // With what viewports want that are smoothed over time.
        let kernels = kernels.into_iter().flat_map(|all| all.into_iter().chain([Kernel::CompositeVelocity]));
        workshop().prepare(kernels.filter(of_any_scene));
    }
    NODES.with_borrow_mut(|nodes| nodes.add_volume(id));
}

/// A volume left its world.
pub fn remove_volume(id: InstanceId) {
    NODES.with_borrow_mut(|nodes| nodes.remove_volume(id));
}

/// What a renderer without a RenderingDevice is told.
pub const NO_DEVICE: &str =
    "Volumes need the Forward+ or the Mobile renderer (Project Settings, Rendering, Renderer).";

/// Says once that this renderer draws no volumes. Without a screen nobody expects it to.
fn tell_no_device() {
    let mut shared = shared::lock();
    shared.error = Some(NO_DEVICE.to_owned());
    let news = shared.take_news();
    drop(shared);
    if let Some(error) = news.filter(|_| DisplayServer::singleton().get_name() != "headless") {
        godot_error!("Lumivox cannot draw the volumes: {error}");
    }
}

/// The engine is up.
pub fn start() {
    let mut server = RenderingServer::singleton();
    if server.get_rendering_device().is_none() {
        return;
    }
    executor::open();
    let lumivox = Lumivox::singleton();
    let callbacks = Callbacks {
        before_frame: lumivox.callable("_before_frame"),
        after_frame: lumivox.callable("_after_frame"),
        node_added: lumivox.callable("_node_added"),
    };
    server.connect("frame_pre_draw", &callbacks.before_frame);
    server.connect("frame_post_draw", &callbacks.after_frame);
    CALLBACKS.set(Some(callbacks));
}

/// What became of other threads' work, in each frame.
pub fn deliver() {
    if warm_up::take_end() {
        Lumivox::singleton().signals().warmed_up().emit();
    }
}

/// The engine goes down.
pub fn stop() {
    let Some(callbacks) = CALLBACKS.take() else { return };
    let mut server = RenderingServer::singleton();
    server.disconnect("frame_pre_draw", &callbacks.before_frame);
    server.disconnect("frame_post_draw", &callbacks.after_frame);
    NODES.with_borrow_mut(|nodes| {
        GATHERER.with_borrow_mut(|all| all.release(nodes));
        nodes.unwatch(&callbacks.node_added);
    });
    shared::lock().targets.clear();
    on_render_thread(render::free);
    server.force_sync();
}

/// Leaves the worlds for the render thread.
fn before_frame() {
    let nothing = NODES.with_borrow(|nodes| !nodes.has_volumes());
    let mut shared = shared::lock();
    shared.drawn.clear();
    shared.frame += 1;
    if nothing && shared.targets.is_empty() {
        return;
    }
    drop(shared);
    CALLBACKS.with_borrow(|callbacks| {
        if let Some(callbacks) = callbacks {
            NODES.with_borrow_mut(|nodes| nodes.watch(&callbacks.node_added));
        }
    });
    let targets = NODES.with_borrow_mut(|nodes| GATHERER.with_borrow_mut(|all| all.gather(nodes)));
    let mut shared = shared::lock();
    let keys = |targets: &HashMap<Rid, Target>| -> HashSet<_> {
        targets.iter().map(|(rid, target)| (*rid, target.snapshot.key)).collect()
    };
    let (before, now) = (keys(&shared.targets), keys(&targets));
    let versions = |targets: &HashMap<Rid, Target>| -> HashSet<u64> {
        targets.values().map(|target| target.snapshot.version).collect()
    };
    if versions(&shared.targets) != versions(&targets) {
        // What could not be drawn has changed, and may fit now.
        shared.error = None;
    }
    shared.statuses.retain(|rid, _| targets.contains_key(rid));
    shared.targets = targets;
    drop(shared);
    if !before.is_subset(&now) {
        on_render_thread(render::sweep);
    }
}

/// All that a viewport shows of volumes.
///
/// # Errors
/// A sentence about a viewport that shows none.
pub fn view(viewport: &Gd<Viewport>) -> Result<View, String> {
    if CALLBACKS.with_borrow(Option::is_none) {
        return Err(NO_DEVICE.to_owned());
    }
    let view = NODES.with_borrow_mut(|nodes| GATHERER.with_borrow_mut(|all| all.view(nodes, viewport)));
    let nothing = "the viewport shows no volume: it has no camera or no LumivoxVolume3D with a scan, its LumivoxEffect is \
                   disabled, or no frame was drawn since (await RenderingServer.frame_post_draw)";
    view.ok_or_else(|| nothing.to_owned())
}

/// Which viewports show an image that is done, and which one whose scans are there.
#[derive(Default)]
struct Reached {
    converged: HashSet<Rid>,
    arrived: HashSet<Rid>,
}

impl Reached {
    fn now() -> Self {
        let shared = shared::lock();
        let of = |is: fn(&Status) -> bool| {
            let reached = shared.statuses.iter().filter(|(_, status)| is(status)).map(|(target, _)| *target);
            reached.collect::<HashSet<Rid>>()
        };
        let is_prepared = |target: &Rid| shared.targets.get(target).is_some_and(|target| !target.preparing);
        let mut converged = of(|status| status.converged);
        converged.retain(is_prepared);
        Self { converged, arrived: of(|status| status.arrived) }
    }
}

/// Tells scripts which images are done that were not.
fn announce() {
    let now = Reached::now();
    let before = REACHED.with_borrow(|before| {
        now.converged.is_subset(&before.converged) && now.arrived.is_subset(&before.arrived)
    });
    if before {
        REACHED.set(now);
        return;
    }
    let viewports = NODES.with_borrow_mut(Nodes::viewports);
    let lumivox = Lumivox::singleton();
    let new = |now: &HashSet<Rid>, before: &HashSet<Rid>| -> Vec<Gd<Viewport>> {
        let is_new = |target: Rid| now.contains(&target) && !before.contains(&target);
        viewports.iter().filter(|viewport| is_new(render_target(viewport))).cloned().collect()
    };
    let [arrived, converged] = REACHED
        .with_borrow(|before| [new(&now.arrived, &before.arrived), new(&now.converged, &before.converged)]);
    REACHED.set(now);
    arrived.iter().for_each(|viewport| lumivox.signals().arrived().emit(viewport));
    converged.iter().for_each(|viewport| lumivox.signals().converged().emit(viewport));
}

/// Tells what went wrong, and has an engine that idles draw again while an image is not done.
fn after_frame() {
    DRAWN.set(true);
    request_wanted_frame();
    announce();
    let mut shared = shared::lock();
    let error = shared.error.clone();
    let news = shared.take_news();
    let store = shared.store.clone();
    drop(shared);
    let reduced = store.map_or(0, |store| store.reduced());
    if reduced > WARNED_OF.with_borrow(|(_, reduced)| *reduced) {
        godot_warn!(
            "The GPU has no room for {reduced} of Lumivox' scans: they are shown at a lower resolution."
        );
    }
    if let Some(error) = news {
        godot_error!("Lumivox cannot draw the volumes: {error}");
    }
    let state = (error, reduced);
    if WARNED_OF.replace(state.clone()) != state {
        for mut volume in NODES.with_borrow_mut(Nodes::volumes) {
            volume.update_configuration_warnings();
        }
    }
}

/// Whether meshes moved the GPU alone knows, and what it tells comes with later frames. An engine that draws on demand
/// may draw none: once a turn of the main loop has passed without one, the GPU is asked. Called once a turn.
pub fn settle_if_idle() {
    if DRAWN.replace(false) {
        return;
    }
    let awaits_feedback = std::mem::take(&mut shared::lock().awaits_feedback);
    if awaits_feedback {
        on_render_thread(render::settle);
    }
    announce();
    request_wanted_frame();
}

/// Has an engine that idles draw again while an image is not done.
fn request_wanted_frame() {
    let wants_frame = std::mem::take(&mut shared::lock().wants_frame);
    if wants_frame {
        let volumes = NODES.with_borrow_mut(Nodes::volumes);
        if let Some(volume) = volumes.first() {
            LumivoxVolume3D::request_redraw(&volume.bind());
        }
    }
}

fn on_render_thread(task: fn()) {
    let task = Callable::from_sync_fn("lumivox_render_task", move |_: &[&Variant]| task());
    RenderingServer::singleton().call_on_render_thread(&task);
}
