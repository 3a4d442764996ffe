//! The engine's worlds as core scenes, gathered on the main thread before each frame.

mod compositors;
mod exposure;
mod fog;
mod kept_sky;
mod lamp_node;
mod lights;
mod nodes;
mod sky;

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use godot::classes::sub_viewport::UpdateMode;
use godot::classes::{Camera3D, Environment, Os, RenderingServer, SubViewport, Viewport, World3D};
use godot::prelude::*;
use lumivox_core::{Scene, VolumeInstance};

use self::compositors::Compositors;
pub use self::exposure::physical_units;
pub use self::kept_sky::{opened as opened_environment, tonemap_exposure};
pub use self::lamp_node::LampNode;
use self::lights::WorldLight;
pub use self::nodes::Nodes;
use self::sky::{Skies, Surroundings};
use crate::effect::LumivoxEffect;
use crate::nodes::LumivoxVolume3D;
use crate::render::Settings;
use crate::shared::{Snapshot, Target, WorldKey};

/// A volume, the layers that it is on, and its node.
struct LayeredVolume {
    layers: u32,
    instance: VolumeInstance,
    node: InstanceId,
}

/// A scene, and [what else](Surroundings::ambient) lights it.
type Lit = (Arc<Snapshot>, [f64; 3]);

/// What a viewport shows.
struct Seen<'a> {
    target: Rid,
    world: &'a Gd<World3D>,
    camera: &'a Gd<Camera3D>,
    volumes: &'a [LayeredVolume],
    /// Whether its environment lights it.
    from_scene: bool,
    /// Whether no frame follows that could show what this one lacks.
    at_once: bool,
}

/// All that a viewport shows of volumes, for a scene file.
pub struct View {
    pub scene: Scene,
    pub settings: Settings,
    pub effect: Gd<LumivoxEffect>,
    pub camera: Gd<Camera3D>,
    pub environment: Option<Gd<Environment>>,
    /// Whether something of its volumes is still computed.
    pub is_preparing: bool,
    /// The nodes of the scene's volumes.
    pub nodes: Vec<InstanceId>,
}

/// What is remembered from frame to frame.
#[derive(Default)]
pub struct Gatherer {
    skies: Skies,
    compositors: Compositors,
    snapshots: HashMap<WorldKey, Lit>,
    /// What each render target showed last.
    shown: HashMap<Rid, Lit>,
    last_version: u64,
    frame: u64,
}

impl Gatherer {
    /// What each render target shows in the frame that begins.
    pub fn gather(&mut self, nodes: &mut Nodes) -> HashMap<Rid, Target> {
        self.frame += 1;
        self.look(nodes)
    }

    /// What a viewport shows as the scene is now, which no frame may have drawn yet. `None` where it shows no volume.
    pub fn view(&mut self, nodes: &mut Nodes, viewport: &Gd<Viewport>) -> Option<View> {
        let target = self.look(nodes).remove(&render_target(viewport))?;
        let (world, camera) = (viewport.find_world_3d()?, viewport.get_camera_3d()?);
        let (volumes, _) = volumes_by_scenario(nodes);
        let seen = volumes.get(&world.get_scenario())?.iter();
        let layers = target.snapshot.key.layers;
        let effect = self.compositors.ensure(nodes, &world, &camera)?;
        Some(View {
            scene: target.snapshot.scene.clone(),
            settings: target.settings,
            effect,
            environment: environment(&world, &camera),
            is_preparing: target.preparing,
            nodes: seen.filter(|one| one.layers & layers != 0).map(|one| one.node).collect(),
            camera,
        })
    }

    fn look(&mut self, nodes: &mut Nodes) -> HashMap<Rid, Target> {
        let (volumes, preparing) = volumes_by_scenario(nodes);
        let mut targets = HashMap::new();
        let mut gathered = HashMap::new();
        let mut shown = HashMap::new();
        let mut worlds = HashSet::new();
        for viewport in nodes.viewports() {
            let Some(world) = viewport.find_world_3d() else { continue };
            let scenario = world.get_scenario();
            let Some(volumes) = volumes.get(&scenario) else { continue };
            let Some(camera) = viewport.get_camera_3d() else { continue };
            worlds.insert(scenario);
            // None: its effect is disabled.
            let Some(effect) = self.compositors.ensure(nodes, &world, &camera) else { continue };
            let stage = effect.get_effect_callback_type().ord();
            let (mut settings, from_scene) = {
                let effect = effect.bind();
                (effect.settings(), effect.uses_scene_environment())
            };
            let target = render_target(&viewport);
            let at_once = no_frame_follows(&viewport);
            let seen = Seen { target, world: &world, camera: &camera, volumes, from_scene, at_once };
            let Some(lit) = self.snapshot(nodes, &seen, &mut gathered) else { continue };
            shown.insert(target, lit.clone());
            let (snapshot, ambient) = lit;
            let exposure = exposure::of(&world, &camera);
            settings.exposure *= exposure;
            settings.ambient = ambient.map(|c| if exposure > 0.0 { c / exposure } else { 0.0 });
            let fog = environment(&world, &camera).and_then(|environment| fog::of(&environment, &camera));
            let preparing = preparing.contains(&scenario);
            targets.insert(target, Target { snapshot, settings, stage, fog, at_once, preparing });
        }
        self.compositors.retain(nodes, &worlds);
        self.skies.retain();
        self.snapshots = gathered;
        self.shown = shown;
        targets
    }

    /// Undoes what was done to the engine.
    pub fn release(&mut self, nodes: &mut Nodes) {
        self.compositors.release(nodes);
        self.snapshots.clear();
        self.shown.clear();
    }

    fn snapshot(
        &mut self,
        nodes: &mut Nodes,
        &Seen { target, world, camera, volumes, from_scene, at_once }: &Seen,
        gathered: &mut HashMap<WorldKey, Lit>,
    ) -> Option<Lit> {
        let environment = environment(world, camera);
        let layers = volumes.iter().fold(0, |all, one| all | one.layers) & camera.get_cull_mask();
        let key = WorldKey {
            scenario: world.get_scenario(),
            environment: environment.as_ref().map_or(0, |e| e.instance_id().to_i64()),
            layers,
            studio: !from_scene,
        };
        if let Some(lit) = gathered.get(&key) {
            return Some(lit.clone());
        }
        let lights = lights::gather(nodes, key.scenario);
        let lit = if from_scene {
            self.surroundings(environment.as_ref(), &lights, exposure::of(world, camera))
        } else {
            Some(Surroundings::studio())
        };
        // While the engine has yet to draw what does now, what lit the viewport before.
        let before = || {
            let (snapshot, ambient) = self.shown.get(&target)?;
            Some(Surroundings { environment: snapshot.scene.environment.clone(), ambient: *ambient })
        };
        // Another light is better than no volumes in a viewport's only frame, or the first of a film.
        let instead = || at_once.then(Surroundings::studio);
        let Surroundings { environment, ambient } = lit.or_else(before).or_else(instead)?;
        let scene = Scene {
            volumes: volumes
                .iter()
                .filter(|one| one.layers & layers != 0)
                .map(|one| one.instance.clone())
                .collect(),
            environment,
            lights: lights.iter().filter(|light| light.in_scene).map(|light| light.light).collect(),
        };
        let known = self.snapshots.get(&key).filter(|(known, _)| known.scene.is_same(&scene));
        let snapshot = known.map(|(known, _)| known.clone()).unwrap_or_else(|| {
            self.last_version += 1;
            Arc::new(Snapshot { key, scene, version: self.last_version })
        });
        gathered.insert(key, (snapshot.clone(), ambient));
        Some((snapshot, ambient))
    }

    /// The light around a scene; `None` while the engine has not drawn its sky yet.
    fn surroundings(
        &mut self,
        environment: Option<&Gd<Environment>>,
        lights: &[WorldLight],
        exposure: f64,
    ) -> Option<Surroundings> {
        match environment {
            Some(environment) => self.skies.light(environment, lights, exposure, self.frame),
            None if lights.iter().any(|light| light.in_scene) => Some(Surroundings::plain([0.0; 3])),
            // Nothing lights the scene: a studio does, so that a volume alone is seen.
            None => Some(Surroundings::studio()),
        }
    }
}

/// The texture that a viewport is drawn into, the same for its whole life. To ask the engine waits for a render thread
/// of its own, where there is one.
pub fn render_target(viewport: &Gd<Viewport>) -> Rid {
    const ENOUGH: usize = 1024;
    thread_local! {
        static KNOWN: RefCell<HashMap<Rid, Rid>> = RefCell::default();
    }
    let viewport = viewport.get_viewport_rid();
    KNOWN.with_borrow_mut(|known| {
        if known.len() > ENOUGH {
            known.clear();
        }
        let ask = || RenderingServer::singleton().viewport_get_render_target(viewport);
        *known.entry(viewport).or_insert_with(ask)
    })
}

/// Whether a frame of a viewport has to hold everything: it is the only one, or goes into a film.
fn no_frame_follows(viewport: &Gd<Viewport>) -> bool {
    thread_local! {
        static FILMING: bool = Os::singleton().has_feature("movie");
    }
    let once = |viewport: Gd<SubViewport>| viewport.get_update_mode() == UpdateMode::ONCE;
    FILMING.with(|filming| *filming) || viewport.clone().try_cast().is_ok_and(once)
}

fn environment(world: &Gd<World3D>, camera: &Gd<Camera3D>) -> Option<Gd<Environment>> {
    camera.get_environment().or_else(|| world.get_environment()).or_else(|| world.get_fallback_environment())
}

/// The volumes of each world, and the worlds in which something of one is still computed.
fn volumes_by_scenario(nodes: &mut Nodes) -> (HashMap<Rid, Vec<LayeredVolume>>, HashSet<Rid>) {
    let mut scenarios: HashMap<Rid, Vec<LayeredVolume>> = HashMap::new();
    let mut preparing = HashSet::new();
    for volume in nodes.volumes() {
        if !volume.is_visible_in_tree() {
            continue;
        }
        let Some(world) = volume.get_world_3d() else { continue };
        if let Some(instance) = LumivoxVolume3D::instance(&volume.bind()) {
            let (layers, node) = (volume.get_layer_mask(), volume.instance_id());
            let layered = LayeredVolume { layers, instance, node };
            scenarios.entry(world.get_scenario()).or_default().push(layered);
        }
        if volume.bind().is_waiting() {
            preparing.insert(world.get_scenario());
        }
    }
    (scenarios, preparing)
}
