//! Images that end by their noise.

use lumivox_core::glam::DVec3;
use lumivox_renderer::LiveSettings;
use lumivox_testing::scenes;

use super::Host;
use crate::gpu;

#[test]
fn an_image_ends_by_its_noise_and_goes_on_for_less() {
    let mut gpu = gpu();
    let test = scenes::overlapping_volumes();
    let camera = test.camera.with_aspect(1.0);
    let settings = LiveSettings::new(24, 24).with(|it| {
        it.target_samples = 4096;
        it.target_noise = 0.1;
    });
    let mut host = Host::new(&mut gpu, &test, settings);
    host.converge(&mut gpu, &camera, 40_000);
    let film = host.film(&mut gpu);
    let (noise, samples) = (film.noise().unwrap(), film.min_samples());
    assert!(noise <= 0.1 && (16..2048).contains(&samples), "{noise} after {samples}");
    assert_eq!(host.live.status().samples, samples);
    // The same image, half as noisy: four times the samples, about, in the same film.
    host.settings.target_noise = 0.05;
    host.converge(&mut gpu, &camera, 40_000);
    let film = host.film(&mut gpu);
    let (less, more) = (film.noise().unwrap(), film.min_samples());
    assert!(less <= 0.05 && more > samples && more < 8 * samples, "{less} after {more}, not {samples}");
    // Another picture begins anew, and ends by its own noise.
    let mut moved = test.scene.clone();
    moved.volumes[0].world_from_patient.translation += DVec3::splat(0.001);
    host.set_scene(&mut gpu, &moved);
    host.converge(&mut gpu, &camera, 40_000);
    assert!(host.film(&mut gpu).noise().unwrap() <= 0.05);
    // By its samples, where those are fewer.
    host.settings.target_samples = 8;
    host.converge(&mut gpu, &camera, 40_000);
    assert_eq!(host.live.status().samples, 8);
}
