//! Sees to it that worlds with volumes have an effect that draws them.

use std::collections::{HashMap, HashSet};

use godot::classes::rendering_server::{CompositorEffectCallbackType, CompositorEffectFlags};
use godot::classes::{Camera3D, Compositor, CompositorEffect, RenderingServer, World3D};
use godot::prelude::*;

use super::Nodes;
use crate::effect::LumivoxEffect;
use crate::server::Lumivox;

/// The effect for worlds without one of their own, and where it was put.
#[derive(Default)]
pub struct Compositors {
    default: Option<Default>,
    /// Worlds that were given a compositor, by scenario.
    worlds: HashMap<Rid, InstanceId>,
    /// Compositors that were given effects besides their own.
    extended: HashSet<InstanceId>,
    /// Those of them that have been given them for this frame.
    fresh: HashSet<InstanceId>,
}

struct Default {
    effect: Gd<LumivoxEffect>,
    /// Goes along with every effect that draws volumes, the scene's own too: at the last stage before what is
    /// transparent it draws what no stage before could, and for its sake the engine resolves a multisampled depth before
    /// any stage that has the sky.
    last: Rid,
    compositor: Rid,
}

impl Compositors {
    /// The effect that draws what a camera sees in a world: the scene's own, or the default one in its place. `None` if
    /// the scene's own are disabled.
    pub fn ensure(
        &mut self,
        nodes: &mut Nodes,
        world: &Gd<World3D>,
        camera: &Gd<Camera3D>,
    ) -> Option<Gd<LumivoxEffect>> {
        let scenario = world.get_scenario();
        let of_world = compositor_of(nodes, world);
        if of_world.is_some() {
            // The engine has replaced ours.
            self.worlds.remove(&scenario);
        }
        let Some(compositor) = camera.get_compositor().or(of_world) else {
            let Default { effect, compositor, .. } = self.default();
            let (effect, compositor) = (effect.clone(), *compositor);
            self.worlds.insert(scenario, world.instance_id());
            // Each time: a compositor that comes and goes leaves none behind.
            RenderingServer::singleton().scenario_set_compositor(scenario, compositor);
            return Some(effect);
        };
        let effects = effects_of(&compositor);
        let own: Vec<Gd<LumivoxEffect>> =
            effects.iter().filter_map(|effect| effect.clone().try_cast().ok()).collect();
        let Default { effect: ours, last, .. } = self.default();
        let (shown, besides) = if own.is_empty() {
            (ours.clone(), vec![ours.get_rid(), *last])
        } else {
            let besides = vec![*last];
            let first = own.into_iter().find(|effect| effect.get_enabled())?;
            first.bind().draw_by_singleton();
            (first, besides)
        };
        // Again in each frame, once: whoever sets the list, be it to what it is, takes ours away, and the engine tells
        // nobody.
        if self.fresh.insert(compositor.instance_id()) {
            show(&compositor, effects.iter().map(|effect| effect.get_rid()).chain(besides));
            self.extended.insert(compositor.instance_id());
        }
        Some(shown)
    }

    /// Ends a frame: takes the effect away from worlds that are not among `scenarios`, and gives them back what their
    /// scenes have.
    pub fn retain(&mut self, nodes: &mut Nodes, scenarios: &HashSet<Rid>) {
        self.fresh.clear();
        self.worlds.retain(|scenario, world| {
            let stays = scenarios.contains(scenario);
            if !stays && let Ok(world) = Gd::try_from_instance_id(*world) {
                let own = compositor_of(nodes, &world).map_or(Rid::Invalid, |own| own.get_rid());
                RenderingServer::singleton().scenario_set_compositor(*scenario, own);
            }
            stays
        });
        if scenarios.is_empty() {
            self.restore_extended();
        }
    }

    /// Takes the effect away from everywhere and frees it.
    pub fn release(&mut self, nodes: &mut Nodes) {
        self.retain(nodes, &HashSet::new());
        if let Some(default) = self.default.take() {
            let mut server = RenderingServer::singleton();
            server.free_rid(default.compositor);
            server.free_rid(default.last);
        }
    }

    fn restore_extended(&mut self) {
        for id in self.extended.drain() {
            if let Ok(compositor) = Gd::<Compositor>::try_from_instance_id(id) {
                show(&compositor, effects_of(&compositor).iter().map(|effect| effect.get_rid()));
            }
        }
    }

    fn default(&mut self) -> &Default {
        self.default.get_or_insert_with(|| {
            let effect = LumivoxEffect::new_gd();
            effect.bind().draw_by_singleton();
            let mut server = RenderingServer::singleton();
            let last = server.compositor_effect_create();
            let draw = Lumivox::singleton().callable("_draw");
            server.compositor_effect_set_callback(last, CompositorEffectCallbackType::PRE_TRANSPARENT, &draw);
            server.compositor_effect_set_flag(last, CompositorEffectFlags::ACCESS_RESOLVED_DEPTH, true);
            let compositor = server.compositor_create();
            server.compositor_set_compositor_effects(compositor, &array![effect.get_rid(), last]);
            Default { effect, last, compositor }
        })
    }
}

/// The effects that a compositor was given by its owner. The inspector adds entries that are empty at first.
fn effects_of(compositor: &Gd<Compositor>) -> Vec<Gd<CompositorEffect>> {
    let effects = compositor.get_compositor_effects().upcast_any_array();
    effects.iter_shared().filter_map(|effect| effect.try_to().ok()).collect()
}

/// Has a compositor run `effects`, whatever its owner gave it.
fn show(compositor: &Gd<Compositor>, effects: impl Iterator<Item = Rid>) {
    RenderingServer::singleton().compositor_set_compositor_effects(compositor.get_rid(), &effects.collect());
}

/// The compositor that the scene gives a world.
fn compositor_of(nodes: &mut Nodes, world: &Gd<World3D>) -> Option<Gd<Compositor>> {
    nodes.environments().into_iter().find_map(|environment| {
        let its_world = environment.get_viewport()?.find_world_3d()?;
        if its_world == *world { environment.get_compositor() } else { None }
    })
}
