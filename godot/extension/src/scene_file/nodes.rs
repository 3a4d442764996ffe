//! A scene file as the engine's own kind of scene.

use godot::classes::{
    Camera3D, CameraAttributesPractical, Compositor, CompositorEffect, Node3D, PackedScene, WorldEnvironment,
};
use godot::global::Error;
use godot::prelude::*;

use super::EXACT_CAMERA;
use super::open::OpenedScene;
use crate::convert;
use crate::effect::{Image, LumivoxEffect};
use crate::nodes::LumivoxVolume3D;
use crate::resources::{LumivoxVolume, report_dictionary};
use crate::world::{LampNode, opened_environment, physical_units};

/// Nearest thing that a camera of a scene file sees, in metres: closer than the engine's own, for small scans.
const NEAR: f32 = 0.005;

/// A scene that holds a document's volumes, lights, environment and camera, its root called `name`. On the main thread.
///
/// # Errors
/// The engine's own.
pub fn packed(scene: &OpenedScene, name: &str) -> Result<Gd<PackedScene>, String> {
    let root = nodes(scene, name);
    own(&root, &root);
    let mut packed = PackedScene::new_gd();
    let result = packed.pack(&root);
    root.free();
    match result {
        Error::OK => Ok(packed),
        error => Err(format!("the engine cannot keep the scene: {error:?}")),
    }
}

fn nodes(scene: &OpenedScene, name: &str) -> Gd<Node3D> {
    let OpenedScene { document, opened, reports, .. } = scene;
    let mut root = Node3D::new_alloc();
    root.set_name(name);
    let scans = opened.scene.volumes.iter().zip(&document.volumes).zip(reports);
    for ((instance, entry), report) in scans {
        let depth = instance.peel.as_ref().map(|peel| peel.depth.clone());
        let mut volume = LumivoxVolume::shared(instance.volume.clone(), report_dictionary(report), depth);
        // By what it is: files and folders are often called by the patient's name.
        let scan_name = volume.bind().get_scan_name();
        volume.set_name(&scan_name);
        let mut node = LumivoxVolume3D::opened(instance, volume, entry.look.preset);
        node.set_name(&StringName::from(&scan_name));
        add(&mut root, &node);
    }
    for lighting in &document.lights {
        let mut node = LampNode::opened(lighting);
        node.set_name("Light");
        add(&mut root, &node);
    }
    add(&mut root, &camera(scene));
    add(&mut root, &world(scene));
    root
}

/// Adds a child, whose name becomes another where there is one of that name.
fn add(root: &mut Gd<Node3D>, node: &Gd<impl Inherits<Node>>) {
    root.add_child_ex(node).force_readable_name(true).done();
}

/// What a scene packs is owned by its root.
fn own(node: &Gd<impl Inherits<Node>>, root: &Gd<Node3D>) {
    for mut child in node.upcast_ref::<Node>().get_children().iter_shared() {
        child.set_owner(root);
        own(&child, root);
    }
}

fn camera(scene: &OpenedScene) -> Gd<Camera3D> {
    let camera = &scene.opened.camera;
    let mut node = Camera3D::new_alloc();
    node.set_name("Camera");
    node.set_transform(convert::transform(camera.world_from_camera));
    node.set_fov(camera.vertical_fov.to_degrees() as f32);
    node.set_near(NEAR);
    if physical_units() {
        // With the exposure of a sunny day: the sky's nits are those of one.
        node.set_attributes(&CameraAttributesPractical::new_gd());
    }
    let mut exact = convert::numbers(camera.world_from_camera);
    exact.push(camera.vertical_fov);
    node.set_meta(EXACT_CAMERA, &exact.to_variant());
    node
}

fn world(scene: &OpenedScene) -> Gd<WorldEnvironment> {
    let OpenedScene { document, opened, .. } = scene;
    let image = Image { film: document.film, display: document.display };
    let mut compositor = Compositor::new_gd();
    let effect: Gd<CompositorEffect> = LumivoxEffect::opened(&image).upcast();
    compositor.set_compositor_effects(&array![&effect]);
    let mut node = WorldEnvironment::new_alloc();
    node.set_name("Environment");
    node.set_environment(&opened_environment(
        &document.environment,
        &opened.scene.environment,
        &document.display,
    ));
    node.set_compositor(&compositor);
    node
}
