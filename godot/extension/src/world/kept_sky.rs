//! The light of a scene file as the engine's sky: a panorama that remembers what the file says.

use std::path::PathBuf;
use std::sync::Arc;

use godot::classes::environment::{AmbientSource, BgMode, ReflectionSource, ToneMapper};
use godot::classes::image::Format;
use godot::classes::{Environment, Image, ImageTexture, PanoramaSkyMaterial, Sky, Texture2D};
use godot::prelude::*;
use lumivox_core::color::linear_from_srgb;
use lumivox_core::document::{Backdrop, Display, Surroundings, Tone};
use lumivox_core::{EnvironmentMap, EnvironmentSource};

use super::sky::MAX_PANORAMA_WIDTH;
use crate::{convert, kept_paths};

/// Metadata of a panorama's texture: what a scene file says of the light that it is a picture of.
const EXACT: &str = "lumivox_environment";

/// What a scene file says of a sky, and the sky's material.
pub struct KeptSky {
    said: Surroundings,
    material: Gd<PanoramaSkyMaterial>,
}

impl KeptSky {
    /// What was kept of a sky; `None` of one that no scene file made.
    pub fn of(sky: &Gd<Sky>) -> Option<Self> {
        let material = sky.get_material()?.try_cast::<PanoramaSkyMaterial>().ok()?;
        let texture = material.get_panorama()?;
        if !texture.has_meta(EXACT) {
            return None;
        }
        let said = serde_json::from_str(&texture.get_meta(EXACT).stringify().to_string()).ok()?;
        Some(Self { said, material })
    }

    /// The file of its map; `None` where there is none, or it is out of reach.
    pub fn file(&self) -> Option<PathBuf> {
        kept_paths::found_path(self.said.file()?.to_str()?)
    }

    /// The light: what the file says as far as nobody changed the sky's own numbers, and `brighter` times as bright. `None` where
    /// it is turned about more than the vertical, or its map is not there.
    pub fn environment(
        &self,
        environment: &Gd<Environment>,
        map: Option<&Arc<EnvironmentMap>>,
        brighter: f64,
    ) -> Option<lumivox_core::Environment> {
        let turned = environment.get_sky_rotation();
        if turned.x != 0.0 || turned.z != 0.0 {
            return None;
        }
        let map = if self.said.file().is_some() { Some(map?.clone()) } else { None };
        let said = self.said.environment(map);
        let unless = |own: f32, exact: f64| if own == exact as f32 { exact } else { f64::from(own) };
        Some(lumivox_core::Environment {
            rotation: unless(turned.y, said.rotation),
            strength: unless(self.material.get_energy_multiplier(), said.strength) * brighter,
            source: said.source,
        })
    }
}

/// The engine's environment of a scene file's light and display.
pub fn opened(said: &Surroundings, light: &lumivox_core::Environment, display: &Display) -> Gd<Environment> {
    let mut texture = texture_of(light);
    let mut said = said.clone();
    if let Some(kept) = said.file().and_then(kept_paths::kept_path) {
        said.source = kept.into();
    }
    if let (Some(texture), Ok(text)) = (&mut texture, serde_json::to_string(&said)) {
        texture.set_meta(EXACT, &text.to_variant());
    }
    let mut material = PanoramaSkyMaterial::new_gd();
    material.set_panorama(texture.as_ref());
    material.set_energy_multiplier(light.strength as f32);
    let mut sky = Sky::new_gd();
    sky.set_material(&material);
    let mut environment = Environment::new_gd();
    environment.set_sky(&sky);
    environment.set_sky_rotation(Vector3::new(0.0, light.rotation as f32, 0.0));
    environment.set_ambient_source(AmbientSource::SKY);
    environment.set_reflection_source(ReflectionSource::SKY);
    let exposure = tonemap_exposure(display);
    environment.set_tonemap_exposure(exposure);
    environment.set_tonemapper(match display.tone {
        Tone::Plain => ToneMapper::LINEAR,
        Tone::Agx => ToneMapper::AGX,
        Tone::Aces => ToneMapper::ACES,
    });
    match display.background {
        Backdrop::Environment => environment.set_background(BgMode::SKY),
        Backdrop::Transparent => environment.set_background(BgMode::CLEAR_COLOR),
        Backdrop::Color(color) => {
            environment.set_background(BgMode::COLOR);
            // The colour that the screen shows is behind the exposure.
            let by = if display.tone == Tone::Plain { f64::from(exposure) } else { 1.0 };
            let linear = color.map(|code| linear_from_srgb(f64::from(code) / 255.0) / by);
            environment.set_bg_color(convert::color_from_linear(linear));
        }
    }
    environment
}

/// What a display's exposure is in the engine's tone mapping.
pub fn tonemap_exposure(display: &Display) -> f32 {
    display.exposure.exp2() as f32
}

/// The light, unturned and of strength 1, as a panorama.
fn texture_of(light: &lumivox_core::Environment) -> Option<Gd<Texture2D>> {
    /// Texels around light that has no map; a gradient is as high as it is fine.
    const BAKED_WIDTH: usize = 512;
    let widest = MAX_PANORAMA_WIDTH as usize;
    let plain = lumivox_core::Environment { rotation: 0.0, strength: 1.0, ..light.clone() };
    let map = match &light.source {
        EnvironmentSource::Map(map) if map.width <= widest => map.clone(),
        EnvironmentSource::Map(_) => Arc::new(baked(&plain, widest)),
        EnvironmentSource::Uniform(_) => Arc::new(baked(&plain, 4)),
        _ => Arc::new(baked(&plain, BAKED_WIDTH)),
    };
    let mut texels = map.texels.clone();
    // Godot begins panoramas at -z, where ours have their middle.
    texels.chunks_exact_mut(map.width).for_each(|row| row.rotate_right(row.len() / 2));
    let bytes: Vec<u8> = texels.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    let (width, height) = (map.width as i32, map.height as i32);
    let image = Image::create_from_data(width, height, false, Format::RGBF, &PackedByteArray::from(bytes))?;
    Some(ImageTexture::create_from_image(&image)?.upcast())
}

fn baked(light: &lumivox_core::Environment, width: usize) -> EnvironmentMap {
    EnvironmentMap::from_fn(width, width / 2, |direction| light.radiance(direction))
}
