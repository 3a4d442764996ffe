//! The engine's environment as the core's: what lights its objects lights volumes.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use godot::classes::environment::{AmbientSource, BgMode};
use godot::classes::image::Format;
use godot::classes::{Environment, Image, PanoramaSkyMaterial, RenderingServer, Sky};
use godot::prelude::*;
use godot::register::info::PropertyUsageFlags;
use lumivox_core::{EnvironmentMap, EnvironmentSource};

use super::exposure::{SKY_NITS, physical_units};
use super::kept_sky::KeptSky;
use super::lights::{self, WorldLight};
use crate::convert;

/// Texels of a sky that the engine draws for us.
const BAKED_SIZE: [i32; 2] = [512, 256];

/// Most texels around a panorama; finer ones are scaled down.
pub const MAX_PANORAMA_WIDTH: i32 = 2048;

/// Frames between two looks at what a sky is made of: a bake waits for the GPU.
const FRAMES_BETWEEN_LOOKS: u64 = 10;

/// Frames after which a sky that cannot be had is done without.
const MAX_TRIES: u64 = 30;

/// Skies as maps, kept while they are in use.
#[derive(Default)]
pub struct Skies(HashMap<InstanceId, BakedSky>);

#[derive(Default)]
struct BakedSky {
    /// Of what the map shows.
    fingerprint: u64,
    /// The material, when it was looked at last.
    material: Option<InstanceId>,
    next_look: u64,
    /// The sky has changed, and the engine has to draw it before there is a picture of it.
    is_awaited: bool,
    /// The picture was taken again after a while, should the engine have been late.
    is_confirmed: bool,
    tries: u64,
    used: bool,
    brightness: Brightness,
    map: Option<Arc<EnvironmentMap>>,
    /// The map turned about more than the vertical axis, and by what.
    turned: Option<(Vector3, Arc<EnvironmentMap>)>,
}

/// How bright the engine draws a sky. What it bakes was drawn in the frame before.
#[derive(Clone, Copy, Default)]
struct Brightness {
    frame: u64,
    now: f64,
    before: f64,
}

/// The light around a world.
#[derive(Clone)]
pub struct Surroundings {
    /// What cameras see as bright as they are exposed.
    pub environment: lumivox_core::Environment,
    /// Radiance from everywhere besides, as cameras show it: the engine's exposure leaves light that is one colour as it
    /// is.
    pub ambient: [f64; 3],
}

impl Surroundings {
    /// One colour, or darkness.
    pub fn plain(ambient: [f64; 3]) -> Self {
        Self { environment: lumivox_core::Environment::uniform(0.0), ambient }
    }

    /// Lumivox' own light, as bright beside the engine's as a sky.
    pub fn studio() -> Self {
        let studio = lumivox_core::Environment::default();
        let strength = studio.strength * if physical_units() { SKY_NITS } else { 1.0 };
        let environment = lumivox_core::Environment { strength, ..studio };
        Self { environment, ambient: [0.0; 3] }
    }
}

impl Skies {
    /// The light of an environment; `None` while the engine has not drawn its sky yet, or not as it is now. A camera of
    /// this `exposure` has it drawn.
    pub fn light(
        &mut self,
        environment: &Gd<Environment>,
        world_lights: &[WorldLight],
        exposure: f64,
        frame: u64,
    ) -> Option<Surroundings> {
        let intensity = if physical_units() { f64::from(environment.get_bg_intensity()) } else { 1.0 };
        let energy = f64::from(environment.get_bg_energy_multiplier()) * intensity;
        let background = environment.get_background();
        let scaled = |color: Color, by: f64| convert::linear_from_color(color).map(|c| c * by);
        let ambient =
            scaled(environment.get_ambient_light_color(), f64::from(environment.get_ambient_light_energy()));
        let multiplier = energy / intensity.max(f64::MIN_POSITIVE);
        let plain = |ambient| Some(Surroundings::plain(ambient));
        match environment.get_ambient_source() {
            AmbientSource::DISABLED => return plain([0.0; 3]),
            AmbientSource::COLOR => return plain(ambient),
            AmbientSource::BG if background == BgMode::COLOR => {
                return plain(scaled(environment.get_bg_color(), multiplier));
            }
            AmbientSource::BG if background == BgMode::CLEAR_COLOR => {
                let color = RenderingServer::singleton().get_default_clear_color();
                return plain(scaled(color, multiplier));
            }
            AmbientSource::BG if background != BgMode::SKY => return plain([0.0; 3]),
            _ => {}
        }
        let share = f64::from(environment.get_ambient_light_sky_contribution());
        let ambient = ambient.map(|c| c * (1.0 - share));
        let Some(sky) = environment.get_sky() else { return plain(ambient) };
        let sky = &sky;
        let baked = self.0.entry(sky.instance_id()).or_default();
        baked.used = true;
        // What the engine bakes is as bright as the camera saw it then.
        if energy * exposure * share <= 0.0 {
            return plain(ambient);
        }
        baked.look(sky, world_lights, energy * exposure, frame);
        if baked.is_awaited && baked.tries <= MAX_TRIES {
            return None;
        }
        if let Some(kept) = KeptSky::of(sky)
            && let Some(environment) = kept.environment(environment, baked.map.as_ref(), energy * share)
        {
            return Some(Surroundings { environment, ambient });
        }
        // Where the engine has no picture of its sky, the studio is better than the dark.
        let Some(map) = baked.map.clone() else { return Some(Surroundings::studio()) };
        let rotation = environment.get_sky_rotation();
        let upright = rotation.x.abs() < 1e-6 && rotation.z.abs() < 1e-6;
        let environment = lumivox_core::Environment {
            source: EnvironmentSource::Map(if upright { map } else { baked.turn(&map, rotation) }),
            rotation: if upright { f64::from(rotation.y) } else { 0.0 },
            strength: energy * share,
        };
        Some(Surroundings { environment, ambient })
    }

    /// Forgets what was not used since the last time.
    pub fn retain(&mut self) {
        self.0.retain(|_, sky| std::mem::take(&mut sky.used));
    }
}

impl BakedSky {
    /// Takes a new picture if the sky changed.
    fn look(&mut self, sky: &Gd<Sky>, world_lights: &[WorldLight], brightness: f64, frame: u64) {
        self.brightness.is(brightness, frame);
        let is_time = frame >= self.next_look;
        if self.is_awaited {
            // Also where it has changed again, as in a fade: the next look sees that.
            if self.tries <= MAX_TRIES || is_time {
                self.next_look = frame + FRAMES_BETWEEN_LOOKS;
                self.take(sky);
            }
            return;
        }
        let material = sky.get_material().map(|material| material.instance_id());
        if !is_time && material == self.material && self.map.is_some() {
            return;
        }
        (self.material, self.next_look) = (material, frame + FRAMES_BETWEEN_LOOKS);
        let fingerprint = fingerprint(sky, world_lights);
        if fingerprint != self.fingerprint {
            (self.fingerprint, self.tries) = (fingerprint, 0);
            (self.is_awaited, self.is_confirmed) = (true, false);
            // What the engine has of a sky that it has not drawn yet is anything.
            if is_panorama(sky) {
                self.take(sky);
            }
        } else if !self.is_confirmed {
            self.is_confirmed = true;
            self.take(sky);
        }
    }

    fn take(&mut self, sky: &Gd<Sky>) {
        self.tries += 1;
        // A sky that was never drawn is black; after a few frames, one that is black means it.
        let drawn = |map: &EnvironmentMap| {
            self.tries >= FRAMES_BETWEEN_LOOKS || map.texels.iter().any(|texel| *texel != [0.0; 3])
        };
        let Some(map) = picture(sky, self.brightness.before).filter(drawn) else { return };
        self.is_awaited = false;
        // The same picture again starts no image over.
        if self.map.as_deref() != Some(&map) {
            self.map = Some(Arc::new(map));
            self.turned = None;
        }
    }

    fn turn(&mut self, map: &EnvironmentMap, euler: Vector3) -> Arc<EnvironmentMap> {
        if let Some((known, turned)) = &self.turned
            && *known == euler
        {
            return turned.clone();
        }
        let basis = Basis::from_euler(EulerOrder::YXZ, euler);
        let world_from_sky = convert::affine(Transform3D::new(basis, Vector3::ZERO)).matrix3;
        let turned = Arc::new(EnvironmentMap::from_fn(map.width, map.height, |direction| {
            map.radiance(world_from_sky.transpose() * direction)
        }));
        self.turned = Some((euler, turned.clone()));
        turned
    }
}

impl Brightness {
    fn is(&mut self, brightness: f64, frame: u64) {
        if frame != self.frame {
            let follows = frame == self.frame + 1;
            *self = Self { frame, now: brightness, before: if follows { self.now } else { brightness } };
        }
        self.now = brightness;
    }
}

/// Changes whenever the sky's look may.
fn fingerprint(sky: &Gd<Sky>, world_lights: &[WorldLight]) -> u64 {
    let mut hasher = DefaultHasher::new();
    if let Some(material) = sky.get_material() {
        material.instance_id().to_i64().hash(&mut hasher);
        for property in material.get_property_list().iter_shared() {
            let usage = property.get("usage").and_then(|u| u.try_to::<i64>().ok()).unwrap_or(0);
            if usage as u64 & PropertyUsageFlags::STORAGE.ord() == 0 {
                continue;
            }
            if let Some(name) = property.get("name") {
                material.get(&StringName::from(&name.stringify())).hash_u32().hash(&mut hasher);
            }
        }
    }
    lights::sky_fingerprint(world_lights, &mut hasher);
    // 0 is that of none.
    hasher.finish().max(1)
}

fn is_panorama(sky: &Gd<Sky>) -> bool {
    sky.get_material().is_some_and(|material| material.is_class("PanoramaSkyMaterial"))
}

/// A sky's radiance at an energy of 1, unturned. The engine has drawn it `brightness` times as bright.
fn picture(sky: &Gd<Sky>, brightness: f64) -> Option<EnvironmentMap> {
    let panorama = sky.get_material().and_then(|m| m.try_cast::<PanoramaSkyMaterial>().ok());
    if let Some(material) = panorama {
        let kept = KeptSky::of(sky);
        let mut image = material.get_panorama()?.get_image()?;
        if image.is_compressed() && image.decompress() != godot::global::Error::OK {
            return None;
        }
        let high_range = [Format::RF, Format::RGF, Format::RGBF, Format::RGBAF, Format::RH]
            .into_iter()
            .chain([Format::RGH, Format::RGBH, Format::RGBAH, Format::RGBE9995])
            .any(|format| format == image.get_format());
        let width = image.get_width();
        if width > MAX_PANORAMA_WIDTH {
            let height = image.get_height() * MAX_PANORAMA_WIDTH / width;
            image.resize(MAX_PANORAMA_WIDTH, height.max(1));
        }
        // A scene file's strength is beside its map, not in it.
        let energy = if kept.is_some() { 1.0 } else { f64::from(material.get_energy_multiplier()) };
        let mut map = map_of(image, energy, !high_range)?;
        // Godot begins panoramas at -z, where ours have their middle.
        map.texels.chunks_exact_mut(map.width).for_each(|row| row.rotate_left(row.len() / 2));
        return Some(match kept.and_then(|kept| kept.file()) {
            Some(file) => map.with_file(&file),
            None => map,
        });
    }
    let [width, height] = BAKED_SIZE;
    let baked = RenderingServer::singleton().sky_bake_panorama(
        sky.get_rid(),
        1.0,
        false,
        Vector2i::new(width, height),
    )?;
    let mut map = map_of(baked, 1.0 / brightness, false)?;
    // What Godot bakes begins at -z too, and runs the other way round.
    map.texels.chunks_exact_mut(map.width).for_each(|row| {
        row.reverse();
        row.rotate_left(row.len() / 2);
    });
    Some(map)
}

fn map_of(mut image: Gd<Image>, energy: f64, srgb: bool) -> Option<EnvironmentMap> {
    if image.is_empty() {
        return None;
    }
    image.convert(Format::RGBAF);
    let (width, height) = (image.get_width() as usize, image.get_height() as usize);
    let data = image.get_data();
    let floats: Vec<f32> = data.as_slice().as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let texels = floats.as_chunks::<4>().0.iter().take(width * height).map(|[r, g, b, _]| {
        let light = if srgb {
            convert::linear_from_color(Color::from_rgb(*r, *g, *b))
        } else {
            [*r, *g, *b].map(f64::from)
        };
        light.map(|c| if c.is_finite() { (c * energy).max(0.0) as f32 } else { 0.0 })
    });
    EnvironmentMap::new(width, height, texels.collect()).ok()
}
