//! What a viewport shows, written down.

use std::path::Path;
use std::sync::Arc;

use godot::classes::camera_3d::{KeepAspect, ProjectionType};
use godot::classes::environment::{BgMode, ToneMapper};
use godot::classes::{Camera3D, Environment, Node, RenderingServer, Viewport};
use godot::prelude::*;
use lumivox_core::color::srgb_from_linear;
use lumivox_core::document::{Backdrop, Display, Film, SceneDocument, Tone, Unsaved, View as Seen};
use lumivox_core::{EnvironmentMap, EnvironmentSource, PerspectiveCamera, Scene};

use super::EXACT_CAMERA;
use crate::world::{View, tonemap_exposure};
use crate::{convert, server};

/// Exposures that a document has room for, in stops.
const STOPS: [f64; 2] = [-32.0, 32.0];

/// Writes what a viewport shows to a file, with its sky beside it where that came from no file.
///
/// # Errors
/// A sentence that says what cannot be saved, and what to do.
pub fn save(viewport: &Gd<Viewport>, file: &Path) -> Result<(), String> {
    let view = server::view(viewport)?;
    if view.is_preparing {
        return Err(
            "something of its volumes is still computed: save once LumivoxVolume3D.prepared was emitted"
                .into(),
        );
    }
    let size = viewport.get_texture().map(|texture| [texture.get_width(), texture.get_height()]);
    let size = size.map(|size| size.map(|side| side.max(1) as u32)).unwrap_or([1, 1]);
    let camera = camera_of(&view.camera, f64::from(size[0]) / f64::from(size[1]))?;
    let image = view.effect.bind().image();
    let mut scene = view.scene.clone();
    add_ambient(&mut scene, view.settings.ambient);
    let display = display_of(&view, viewport, image.display);
    lumivox_scene::save_scene(scene, file, |scene| {
        Ok(SceneDocument {
            camera: Seen::of(&camera),
            film: Film { size, ..image.film },
            display,
            ..SceneDocument::of(scene).map_err(|unsaved| words(unsaved, &view.nodes))?
        })
    })
}

/// Names the node of what cannot be saved.
fn words(unsaved: Unsaved, nodes: &[InstanceId]) -> String {
    let (Unsaved::Volume(index) | Unsaved::Labels(index)) = unsaved else { return unsaved.to_string() };
    let node = nodes.get(index).and_then(|id| Gd::<Node>::try_from_instance_id(*id).ok());
    let name = node.map_or_else(String::new, |node| format!("{}: ", node.get_name()));
    format!("{name}{unsaved}. One that was saved before Lumivox kept its files has to be imported again")
}

/// The camera as documents have it: as the scene file that it came from says, where it is still that.
fn camera_of(camera: &Gd<Camera3D>, aspect: f64) -> Result<PerspectiveCamera, String> {
    if camera.get_projection() != ProjectionType::PERSPECTIVE {
        return Err("the camera is not a perspective one, and scene files have no others".into());
    }
    let place = camera.clone().get_camera_transform();
    let fov = camera.get_fov();
    if let Some(exact) = exact_camera(camera, place) {
        return Ok(exact);
    }
    let angle = f64::from(fov).to_radians();
    let vertical_fov = match camera.get_keep_aspect_mode() {
        KeepAspect::WIDTH => 2.0 * ((angle / 2.0).tan() / aspect).atan(),
        _ => angle,
    };
    Ok(PerspectiveCamera { world_from_camera: convert::affine(place.orthonormalized()), vertical_fov })
}

fn exact_camera(camera: &Gd<Camera3D>, place: Transform3D) -> Option<PerspectiveCamera> {
    if !camera.has_meta(EXACT_CAMERA) || camera.get_keep_aspect_mode() != KeepAspect::HEIGHT {
        return None;
    }
    let numbers: PackedFloat64Array = camera.get_meta(EXACT_CAMERA).try_to().ok()?;
    let (vertical_fov, matrix) = numbers.as_slice().split_last()?;
    let world_from_camera = convert::affine_of(matrix)?;
    let is_unchanged = convert::is_same_place(convert::transform(world_from_camera), place)
        && vertical_fov.to_degrees() as f32 == camera.get_fov();
    is_unchanged.then_some(PerspectiveCamera { world_from_camera, vertical_fov: *vertical_fov })
}

/// Light of one colour, which the engine exposes apart, as a part of the environment.
fn add_ambient(scene: &mut Scene, ambient: [f64; 3]) {
    let environment = &mut scene.environment;
    if ambient == [0.0; 3] {
        return;
    }
    let is_dark = environment.strength == 0.0
        || matches!(environment.source, EnvironmentSource::Uniform(color) if color == [0.0; 3]);
    if is_dark {
        *environment = lumivox_core::Environment {
            source: EnvironmentSource::Uniform(ambient),
            ..lumivox_core::Environment::uniform(1.0)
        };
        return;
    }
    let strength = environment.strength;
    let mut map = (*environment.to_map()).clone();
    for texel in &mut map.texels {
        *texel = std::array::from_fn(|i| texel[i] + (ambient[i] / strength) as f32);
    }
    // A new map is of no file.
    let map = EnvironmentMap::new(map.width, map.height, map.texels)
        .unwrap_or_else(|_| (*environment.to_map()).clone());
    environment.source = EnvironmentSource::Map(Arc::new(map));
}

/// How light becomes pixels; `said` is what the scene file says that it came from.
fn display_of(view: &View, viewport: &Gd<Viewport>, said: Display) -> Display {
    let environment = view.environment.as_ref();
    let shown = environment.map_or(1.0, |environment| environment.get_tonemap_exposure());
    // What is no other number stays as it was said.
    let toned = if shown == tonemap_exposure(&said) { said.exposure } else { f64::from(shown).log2() };
    let stops = view.effect.bind().stops();
    let of_camera = (view.settings.exposure / stops.exp2()).log2();
    let exposure = (toned + stops + of_camera).clamp(STOPS[0], STOPS[1]);
    let tone = match environment.map(|environment| environment.get_tonemapper()) {
        None | Some(ToneMapper::LINEAR) => Tone::Plain,
        Some(ToneMapper::ACES) => Tone::Aces,
        Some(_) => Tone::Agx,
    };
    let background = background_of(environment, viewport, said.background);
    Display { background, exposure, tone, ..said }
}

/// What stands behind.
fn background_of(environment: Option<&Gd<Environment>>, viewport: &Gd<Viewport>, said: Backdrop) -> Backdrop {
    let clear = || {
        if viewport.has_transparent_background() || said == Backdrop::Transparent {
            return Backdrop::Transparent;
        }
        color(RenderingServer::singleton().get_default_clear_color(), 1.0)
    };
    let Some(environment) = environment else { return clear() };
    match environment.get_background() {
        BgMode::SKY => Backdrop::Environment,
        BgMode::COLOR => {
            let is_plain = environment.get_tonemapper() == ToneMapper::LINEAR;
            let exposure = if is_plain { environment.get_tonemap_exposure() } else { 1.0 };
            let by = f64::from(environment.get_bg_energy_multiplier()) * f64::from(exposure);
            color(environment.get_bg_color(), by)
        }
        _ => clear(),
    }
}

fn color(color: Color, by: f64) -> Backdrop {
    let linear = convert::linear_from_color(color);
    Backdrop::Color(linear.map(|c| (srgb_from_linear((c * by).clamp(0.0, 1.0)) * 255.0).round() as u8))
}
