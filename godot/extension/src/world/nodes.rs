//! The nodes that matter: volumes tell themselves, the others are found when they enter the tree.

use godot::classes::{Engine, Light3D, SceneTree, Viewport, WorldEnvironment};
use godot::prelude::*;

use crate::nodes::LumivoxVolume3D;

/// Nodes by their instance ids; those that are gone are forgotten when they are asked for.
#[derive(Default)]
pub struct Nodes {
    volumes: Vec<InstanceId>,
    viewports: Vec<InstanceId>,
    environments: Vec<InstanceId>,
    lights: Vec<InstanceId>,
    watched: bool,
}

impl Nodes {
    /// A volume entered a world.
    pub fn add_volume(&mut self, id: InstanceId) {
        self.volumes.push(id);
    }

    /// A volume left its world.
    pub fn remove_volume(&mut self, id: InstanceId) {
        self.volumes.retain(|other| *other != id);
    }

    /// Whether there is any volume.
    pub fn has_volumes(&self) -> bool {
        !self.volumes.is_empty()
    }

    /// A node entered the tree.
    pub fn add(&mut self, node: &Gd<Node>) {
        let list = if node.is_class("Viewport") {
            &mut self.viewports
        } else if node.is_class("Light3D") {
            &mut self.lights
        } else if node.is_class("WorldEnvironment") {
            &mut self.environments
        } else {
            return;
        };
        let id = node.instance_id();
        if !list.contains(&id) {
            list.push(id);
        }
    }

    /// Begins to look, at what is in the tree and, through `added`, at what enters it.
    pub fn watch(&mut self, added: &Callable) {
        if self.watched {
            return;
        }
        let Some(mut tree) = tree() else { return };
        let Some(root) = tree.get_root() else { return };
        tree.connect("node_added", added);
        self.watched = true;
        self.add(&root.clone().upcast());
        for class in ["Viewport", "Light3D", "WorldEnvironment"] {
            let found = root.find_children_ex("*").type_(class).recursive(true).owned(false).done();
            found.iter_shared().for_each(|node| self.add(&node));
        }
    }

    /// No longer looks.
    pub fn unwatch(&mut self, added: &Callable) {
        if let Some(mut tree) = tree().filter(|tree| tree.is_connected("node_added", added)) {
            tree.disconnect("node_added", added);
        }
        *self = Self::default();
    }

    /// The volumes that are in a world.
    pub fn volumes(&mut self) -> Vec<Gd<LumivoxVolume3D>> {
        alive(&mut self.volumes)
    }

    /// The viewports in the tree.
    pub fn viewports(&mut self) -> Vec<Gd<Viewport>> {
        in_tree(alive(&mut self.viewports))
    }

    /// The world environments in the tree.
    pub fn environments(&mut self) -> Vec<Gd<WorldEnvironment>> {
        in_tree(alive(&mut self.environments))
    }

    /// The lights in the tree.
    pub fn lights(&mut self) -> Vec<Gd<Light3D>> {
        in_tree(alive(&mut self.lights))
    }
}

fn tree() -> Option<Gd<SceneTree>> {
    Engine::singleton().get_main_loop()?.try_cast().ok()
}

fn alive<T: GodotClass + Inherits<Object>>(ids: &mut Vec<InstanceId>) -> Vec<Gd<T>> {
    let mut nodes = vec![];
    ids.retain(|id| match Gd::try_from_instance_id(*id) {
        Ok(node) => {
            nodes.push(node);
            true
        }
        Err(_) => false,
    });
    nodes
}

fn in_tree<T: GodotClass + Inherits<Node>>(nodes: Vec<Gd<T>>) -> Vec<Gd<T>> {
    nodes.into_iter().filter(|node| node.upcast_ref::<Node>().is_inside_tree()).collect()
}
