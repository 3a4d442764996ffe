//! The engine's lights against formulas, and what they must not change.

use std::f64::consts::PI;
use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{
    Cone, Environment, Falloff, Lamp, Light, LightKind, Medium, Modality, PerspectiveCamera, Scene,
    TransferFunction, Volume, VolumeInstance, Voxels,
};
use lumivox_reference::quadrature::{half_space_beam_radiance, slab_beam_single_scattering};
use lumivox_renderer::{EnvironmentSampling, Film};
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::RenderRequest;

use crate::film;

/// A homogeneous plate 1 mm thick and so wide that nothing reaches its rim, seen from 200 mm in front.
fn plate(optical_thickness: f64, albedo: f64, lights: Vec<Light>) -> TestScene {
    let place = DAffine3::from_scale(DVec3::new(1000.0, 1.0, 1000.0));
    let volume = Volume::new([1; 3], Voxels::U8(vec![0]), [1.0, 0.0], place, Modality::Other).unwrap();
    let medium = Medium {
        density_scale: optical_thickness,
        albedo,
        max_bounces: 1000,
        ..Medium::new(TransferFunction::constant(1.0, [1.0; 3]))
    };
    let scene = Scene {
        volumes: vec![VolumeInstance::centered(Arc::new(volume), medium)],
        environment: Environment::uniform(0.0),
        lights,
    };
    let camera = PerspectiveCamera::look_at(DVec3::Z * 0.2, DVec3::ZERO, DVec3::Y, 1e-6);
    TestScene { name: "plate", scene, camera }
}

/// Mean luminance and its standard error.
fn mean(film: &Film, pixels: usize) -> (f64, f64) {
    let sums = (0..pixels).map(|p| film.luminance(p)).fold((0.0, 0.0), |s, l| (s.0 + l.0, s.1 + l.1));
    (sums.0 / pixels as f64, sums.1.sqrt() / pixels as f64)
}

#[track_caller]
fn assert_mean(test: &TestScene, samples: u32, expected: f64, what: &str) {
    let (mean, error) = mean(&film(test, &RenderRequest::new(16, 16, samples)), 256);
    assert!(
        (mean - expected).abs() < 4.5 * error + 1e-4 * expected,
        "{what}: {mean} +- {error} is not {expected}"
    );
    assert!(error < 0.02 * expected, "{what}: too noisy to tell, {mean} +- {error}");
}

/// Light of unit irradiance that travels along -z, tilted to come in at that cosine.
fn beam(mu_0: f64) -> Light {
    Light::directional(-DVec3::new(0.0, (1.0 - mu_0 * mu_0).sqrt(), mu_0), [1.0; 3])
}

#[test]
fn a_beam_is_scattered_once_as_its_formula_says() {
    for (optical_thickness, albedo, mu_0) in [(0.1, 1.0, 1.0), (1.0, 0.6, 0.4), (2.0, 0.9, 0.7)] {
        let mut test = plate(optical_thickness, albedo, vec![beam(mu_0)]);
        test.scene.volumes[0].medium.max_bounces = 1;
        let expected = slab_beam_single_scattering(albedo, optical_thickness, 1.0, mu_0);
        assert_mean(&test, 256, expected, "single scattering");
    }
}

#[test]
fn a_half_space_returns_of_beams_what_chandrasekhar_says() {
    // Lights add up, whichever of them a collision asks.
    let test = plate(40.0, 0.9, vec![beam(0.3), beam(0.7), beam(1.0)]);
    let expected = [0.3, 0.7, 1.0].map(|mu_0| half_space_beam_radiance(0.9, 1.0, mu_0)).iter().sum();
    assert_mean(&test, 128, expected, "half-space");
}

#[test]
fn lamps_light_a_thin_plate_by_their_distance() {
    // Right above the point seen; at half the thickness the distance is the height.
    let (thickness, height) = (0.1f64, 0.05);
    let lamp = Lamp::new(DVec3::Z * height, [1.0; 3]);
    let falloff = Falloff::Power { range: 0.08, decay: 0.5 };
    let spot = |tilt: f64, cone| LightKind::Spot {
        lamp,
        direction: DVec3::new(tilt.sin(), 0.0, -tilt.cos()),
        half_angle: 0.5,
        cone,
    };
    let rim = |tilt: f64| (1.0 - tilt.cos()) / (1.0 - 0.5f64.cos());
    let power = |attenuation| Cone::Power { attenuation };
    let between = Cone::Between { inner_half_angle: 0.3 };
    let cases: [(&str, Light, f64); 11] = [
        ("inverse square", Light::point(lamp), 400.0),
        ("range", Light::point(Lamp { falloff, ..lamp }), {
            (1.0 - (0.05f64 / 0.08).powi(4)).powi(2) / 0.05f64.sqrt()
        }),
        (
            "out of range",
            Light::point(Lamp { falloff: Falloff::Power { range: 0.04, decay: 2.0 }, ..lamp }),
            0.0,
        ),
        ("relative", Light::point(Lamp { falloff: Falloff::Relative { range: 0.1 }, ..lamp }), 1.0 / 7.25),
        ("its end", Light::point(Lamp { falloff: Falloff::Relative { range: 0.055 }, ..lamp }), {
            (5.0 - 5.0 / 1.1) / (1.0 + 25.0 / 1.21)
        }),
        ("spot", spot(0.2, power(1.0)).into(), 400.0 * (1.0 - rim(0.2))),
        ("soft edge", spot(0.3, power(2.5)).into(), 400.0 * (1.0 - rim(0.3).powf(2.5))),
        ("beside the spot", spot(0.6, power(1.0)).into(), 0.0),
        ("within the inner cone", spot(0.2, between).into(), 400.0),
        ("between the cones", spot(0.4, between).into(), {
            400.0 * ((0.4f64.cos() - 0.5f64.cos()) / (0.3f64.cos() - 0.5f64.cos())).powi(2)
        }),
        ("beside both cones", spot(0.6, between).into(), 0.0),
    ];
    for (what, light, irradiance) in cases {
        let mut test = plate(thickness, 1.0, vec![light]);
        test.scene.volumes[0].medium.max_bounces = 1;
        let expected = irradiance * slab_beam_single_scattering(1.0, thickness, 1.0, 1.0);
        if expected == 0.0 {
            let film = film(&test, &RenderRequest::new(16, 16, 64));
            assert!(film.alpha(0) >= 0.0 && mean(&film, 256).0 == 0.0, "{what}");
        } else {
            // The plate is 1 mm thick: the distance varies by a percent, its mean square by 1e-4, and its mean by 3e-4: more
            // light comes from the nearer half. What can be told apart is a percent.
            assert_mean(&test, 256, expected * (1.0 + 1e-4), what);
        }
    }
}

#[test]
fn a_sun_from_everywhere_is_a_furnace() {
    for test in [scenes::overlapping_volumes(), scenes::glossy_surface()] {
        let mut test = scenes::furnace(test);
        test.scene.environment = Environment::uniform(0.0);
        let (irradiance, angular_radius) = ([4.0 * PI; 3], PI);
        test.scene.lights =
            vec![LightKind::Directional { direction: DVec3::Y, irradiance, angular_radius }.into()];
        for environment_sampling in
            [EnvironmentSampling::Auto, EnvironmentSampling::Always, EnvironmentSampling::Never]
        {
            let request =
                RenderRequest::new(16, 16, 128).with(|it| it.environment_sampling = environment_sampling);
            let film = film(&test, &request);
            let (mean, error) = mean(&film, 256);
            let alpha = (0..256).map(|p| film.alpha(p)).sum::<f64>() / 256.0;
            assert!((mean - alpha).abs() < 4.5 * error, "{}: {mean} +- {error}, not {alpha}", test.name);
        }
    }
}

/// The film of a scene that holds these lights.
fn film_with(test: &TestScene, lights: &[Light]) -> Film {
    let mut test = test.clone();
    test.scene.lights = lights.to_vec();
    film(&test, &RenderRequest::new(24, 24, 8))
}

#[test]
fn a_light_for_other_layers_changes_no_bit() {
    let mut test = scenes::overlapping_volumes();
    let bulb = Light::point(Lamp { radius: 0.004, ..Lamp::new(DVec3::new(0.02, 0.02, 0.02), [1e-3; 3]) });
    let sun = |layers| Light { layers, ..Light::directional(DVec3::NEG_Y, [1.0; 3]) };
    // For no volume at all.
    let alone = film_with(&test, &[bulb]);
    assert_eq!(film_with(&test, &[sun(2), bulb, sun(4)]), alone);
    assert_eq!(film_with(&test, &[sun(2)]), film_with(&test, &[]));
    // For a volume that is too thin to be hit: the kernel holds the light and leaves it out.
    test.scene.volumes[1].layers = 2;
    test.scene.volumes[1].medium.density_scale = 0.0;
    let alone = film_with(&test, &[bulb]);
    assert_eq!(film_with(&test, &[sun(2), bulb]), alone);
    assert_ne!(film_with(&test, &[sun(3), bulb]), alone);
}

/// The nearest corner of the volumes' box is just within a lamp's range, or just beyond: what the cache leaves out
/// brought nothing, and what it keeps is all there is.
#[test]
fn a_light_out_of_reach_changes_no_bit() {
    let test = scenes::overlapping_volumes();
    let bulb = Light::point(Lamp { radius: 0.004, ..Lamp::new(DVec3::new(0.02, 0.02, 0.02), [1e-3; 3]) });
    let far = |range| {
        let falloff = Falloff::Power { range, decay: 2.0 };
        Light::point(Lamp { radius: 0.01, falloff, ..Lamp::new(DVec3::X * 1.0, [1.0; 3]) })
    };
    let alone = film_with(&test, &[bulb]);
    let same: Vec<bool> = [0.5, 0.9, 0.93, 0.96, 0.99, 1.02, 1.05, 2.0]
        .map(|range| film_with(&test, &[far(range), bulb]) == alone)
        .to_vec();
    // Once it reaches something it stays: there is no gap in which it is culled and would have been seen.
    assert!(same[0] && !same[7] && same.is_sorted_by(|a, b| a >= b), "{same:?}");
    assert_eq!(film_with(&test, &[far(0.5)]), film_with(&test, &[]));
}

#[test]
fn lights_that_are_no_lights_are_not_there() {
    let test = scenes::noise();
    let broken = [
        Light::directional(DVec3::ZERO, [1.0; 3]),
        Light::directional(DVec3::X, [f64::NAN; 3]),
        Light::point(Lamp::new(DVec3::NAN, [1.0; 3])),
        Light::point(Lamp::new(DVec3::ZERO, [0.0; 3])),
    ];
    assert_eq!(film_with(&test, &broken), film_with(&test, &[]));
    // At the camera, in the volume, and far too bright: whatever happens is finite.
    let extreme = [
        Light::point(Lamp::new(test.camera.world_from_camera.translation, [1e9; 3])),
        Light::point(Lamp {
            falloff: Falloff::Power { range: 1e-9, decay: 8.0 },
            ..Lamp::new(DVec3::ZERO, [1.0; 3])
        }),
        Light::spot(Lamp::new(DVec3::splat(1e9), [1.0; 3]), DVec3::NEG_ONE, 0.0),
    ];
    let film = film_with(&test, &extreme);
    assert!((0..576).all(|p| film.radiance(p).iter().all(|c| c.is_finite())));
}
