//! What a camera's exposure and physical light units do to light.

use std::sync::OnceLock;

use godot::classes::{Camera3D, CameraAttributesPhysical, ProjectSettings, World3D};
use godot::prelude::*;

/// Nits that the engine gives a sky: what radiance 1 is where it tells nits.
pub const SKY_NITS: f64 = 30_000.0;

/// Whether lights are told in lumens and lux, and skies in nits. The engine asks once, too.
pub fn physical_units() -> bool {
    static PHYSICAL: OnceLock<bool> = OnceLock::new();
    *PHYSICAL.get_or_init(|| {
        let setting = "rendering/lights_and_shadows/use_physical_light_units";
        ProjectSettings::singleton().get_setting(setting).try_to().unwrap_or_default()
    })
}

/// What the attributes of a camera, or of its world, multiply all light by.
pub fn of(world: &Gd<World3D>, camera: &Gd<Camera3D>) -> f64 {
    let Some(attributes) = camera.get_attributes().or_else(|| world.get_camera_attributes()) else {
        return 1.0;
    };
    let multiplier = f64::from(attributes.get_exposure_multiplier());
    if !physical_units() {
        return multiplier;
    }
    let sensitivity = f64::from(attributes.get_exposure_sensitivity());
    let [aperture, shutter] = match attributes.try_cast::<CameraAttributesPhysical>() {
        Ok(physical) => [physical.get_aperture(), physical.get_shutter_speed()].map(f64::from),
        // Those that the engine takes all others for.
        Err(_) => [16.0, 100.0],
    };
    multiplier * from_nits(aperture, shutter, sensitivity)
}

/// The image's value for a nit: by the saturation of a sensor of ISO `sensitivity` at f/`aperture` and 1/`shutter` s.
fn from_nits(aperture: f64, shutter: f64, sensitivity: f64) -> f64 {
    sensitivity / (100.0 * 1.2 * aperture * aperture * shutter)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sunny_sixteen_shows_a_sunlit_sky_as_white() {
        // A clear sky has some ten thousand nits, and a sunlit white wall 30000.
        let wall = 30_000.0 * from_nits(16.0, 100.0, 100.0);
        assert!((wall - 0.977).abs() < 1e-3, "{wall}");
        let stop = from_nits(16.0, 50.0, 100.0) / from_nits(16.0, 100.0, 100.0);
        assert!((stop - 2.0).abs() < 1e-12);
    }
}
