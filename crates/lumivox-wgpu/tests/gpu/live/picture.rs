//! What is seen over the host's colour.

use lumivox_core::{Camera, Projection};
use lumivox_renderer::{DistanceFog, Fog, HeightFog, LiveSettings};
use lumivox_testing::scenes;

use super::Host;
use crate::gpu;

#[test]
fn the_picture_is_light_over_the_hosts_colour() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings::new(24, 24).with(|it| {
        it.target_samples = 40;
        it.exposure = 2.0;
    });
    let mut host = Host::new(&mut gpu, &test, settings);
    host.converge(&mut gpu, &camera, u64::MAX);
    let behind = |at: [u32; 2]| [at[0] as f32 / 24.0, 0.5, 3.0, 1.0];
    host.set_color(&gpu, behind);
    host.frame(&mut gpu, &camera, u64::MAX);
    let (film, shown) = (host.film(&mut gpu), host.read_color(&gpu));
    for pixel in 0..24 * 24 {
        let host_color = behind([pixel as u32 % 24, pixel as u32 / 24]);
        let (light, alpha) = (film.radiance(pixel), film.alpha(pixel));
        for i in 0..3 {
            let wanted = 2.0 * light[i] + (1.0 - alpha) * f64::from(host_color[i]);
            let got = f64::from(shown[pixel * 4 + i]);
            assert!((got - wanted).abs() < 2e-3 * (1.0 + wanted), "pixel {pixel}: {got} is not {wanted}");
        }
    }
}

/// While a coarse film is shown alone, and while it shows through.
#[test]
fn a_mesh_that_moves_in_front_of_a_volume_hides_it_at_once() {
    const SIZE: u32 = 64;
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let distance = camera.world_from_camera.translation.length();
    let columns = |left: u32| left..left + 11;
    let mesh =
        |left: u32| move |at: [u32; 2]| if columns(left).contains(&at[0]) { 0.3 * distance } else { 0.0 };
    let mut gpu = gpu();
    for samples in [0, 1, 8] {
        let mut host = Host::new(&mut gpu, &test, LiveSettings::new(SIZE, SIZE));
        host.set_depth(&gpu, mesh(8));
        let budget = u64::from(SIZE * SIZE / 8);
        while host.frame(&mut gpu, &camera, budget).samples < samples {}
        for left in 9..40 {
            host.set_depth(&gpu, mesh(left));
            host.set_color(&gpu, |_| [0.0, 0.0, 0.0, 1.0]);
            host.frame(&mut gpu, &camera, budget);
            let shown = host.read_color(&gpu);
            let light = |at: [u32; 2]| shown[((at[1] * SIZE + at[0]) * 4) as usize];
            let painted =
                (0..SIZE).flat_map(|y| columns(left).map(move |x| [x, y])).filter(|&at| light(at) > 0.02);
            assert_eq!(painted.count(), 0, "{samples} samples, mesh from column {left}");
            assert!(light([SIZE / 2 + 20, SIZE / 2]) > 0.02 || light([SIZE / 2 - 20, SIZE / 2]) > 0.02);
        }
    }
}

#[test]
fn fog_hides_volumes_by_distance_and_by_height() {
    let test = scenes::noise();
    let centred = test.camera.with_aspect(1.0);
    let world_from_camera = centred.world_from_camera;
    let distance = world_from_camera.translation.length();
    let half = (test.camera.vertical_fov / 2.0).tan();
    let tangents = [-1.3 * half, 0.8 * half, -0.7 * half, 1.1 * half];
    let extents = [-0.9, 1.1, -1.0, 0.8].map(|x| x * half * distance);
    let cameras = [
        Camera { world_from_camera, projection: Projection::Perspective { tangents } },
        Camera { world_from_camera, projection: Projection::Orthographic { extents } },
    ];
    let far = DistanceFog::Exponential { density: 0.5 / distance };
    let near = DistanceFog::Between { begin: 0.9 * distance, end: 1.2 * distance, curve: 1.5, density: 0.8 };
    let low = HeightFog { height: 0.2 * distance, density: 3.0 / distance };
    let color = [0.2, 0.7, 1.5];
    let in_depth = |by_distance| Fog { color, by_distance, by_height: None };
    let counts_depth =
        |fog: &Fog| !matches!(fog.by_distance, DistanceFog::Exponential { .. } | DistanceFog::Between { .. });
    let fogs = [
        Fog { color, by_distance: far, by_height: None },
        Fog { color, by_distance: near, by_height: None },
        Fog { color, by_distance: far, by_height: Some(low) },
        in_depth(DistanceFog::LinearInDepth { begin: 0.8 * distance, end: 1.4 * distance }),
        in_depth(DistanceFog::ExponentialInDepth { density: 0.5 / distance }),
        in_depth(DistanceFog::ExponentialSquaredInDepth { density: 0.7 / distance }),
    ];
    let mut gpu = gpu();
    for (camera, fog) in cameras.iter().flat_map(|camera| fogs.map(|fog| (camera, fog))) {
        let settings = LiveSettings::new(24, 24).with(|it| it.target_samples = 8);
        let mut host = Host::new(&mut gpu, &test, settings);
        host.converge(&mut gpu, camera, u64::MAX);
        host.fog = Some(fog);
        host.set_color(&gpu, |_| [0.0; 4]);
        // The film is done: fog starts nothing over.
        assert_eq!(host.frame(&mut gpu, camera, u64::MAX).pixel_samples, 0);
        let (film, shown) = (host.film(&mut gpu), host.read_color(&gpu));
        let (mut least, mut most) = (1.0f64, 0.0f64);
        for pixel in (0..24 * 24).filter(|&pixel| film.alpha(pixel) > 0.0) {
            let uv = [pixel % 24, pixel / 24].map(|x| (x as f64 + 0.5) / 24.0);
            let ray = camera.ray(uv);
            let t = film.depth(pixel) / ray.direction.dot(-world_from_camera.matrix3.z_axis);
            let point = ray.origin + t * ray.direction;
            let distance = match counts_depth(&fog) {
                true => film.depth(pixel),
                false => point.distance(world_from_camera.translation),
            };
            let amount = fog.amount(distance, point.y);
            (least, most) = (least.min(amount), most.max(amount));
            let (light, alpha) = (film.radiance(pixel), film.alpha(pixel));
            for i in 0..3 {
                let wanted = (1.0 - amount) * light[i] + amount * alpha * color[i];
                let got = f64::from(shown[pixel * 4 + i]);
                assert!((got - wanted).abs() < 2e-3 * (1.0 + wanted), "{fog:?}: {pixel}: {got}, {wanted}");
            }
        }
        assert!(most > 0.2 && least < most, "{fog:?} hides {least} to {most}");
    }
}

#[test]
fn the_first_frame_shows_everything_however_small_the_budget() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings::new(64, 64).with(|it| it.target_samples = 64);
    let mut host = Host::new(&mut gpu, &test, settings);
    host.converge(&mut gpu, &camera, u64::MAX);
    let done = host.film(&mut gpu);

    let mut host = Host::new(&mut gpu, &test, settings);
    host.set_color(&gpu, |_| [0.0; 4]);
    host.frame(&mut gpu, &camera, 300);
    let shown = host.read_color(&gpu);
    let (mut seen, mut wanted) = (0.0, 0.0);
    for pixel in 0..64 * 64 {
        seen += f64::from(shown[pixel * 4 + 3]);
        wanted += done.alpha(pixel);
    }
    assert!((seen / wanted - 1.0).abs() < 0.15, "{seen} of {wanted}");
}

/// However few samples are asked for, a finished picture is the same whether a coarse film went before it or not.
#[test]
fn a_finished_picture_does_not_show_what_was_before() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings::new(32, 32).with(|it| it.target_samples = 4);
    let mut picture = |budget| {
        let mut host = Host::new(&mut gpu, &test, settings);
        host.converge(&mut gpu, &camera, budget);
        host.set_color(&gpu, |_| [0.0; 4]);
        host.frame(&mut gpu, &camera, budget);
        host.read_color(&gpu)
    };
    let (at_once, slowly) = (picture(u64::MAX), picture(200));
    assert!(difference(&at_once, &slowly) < 1e-3, "{}", difference(&at_once, &slowly));
}

#[test]
fn a_small_film_does_not_leak_over_the_hosts_edges() {
    let mut test = scenes::noise();
    test.scene.volumes[0].medium.density_scale = 50.0;
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings::new(48, 48).with(|it| {
        it.target_samples = 32;
        it.resolution_scale = 0.5;
    });
    let mut host = Host::new(&mut gpu, &test, settings);
    // A mesh in front of everything, its edge in the middle of a pixel of the film.
    host.set_depth(&gpu, |at| if at[0] < 25 { 0.02 } else { 0.0 });
    host.converge(&mut gpu, &camera, u64::MAX);
    host.set_color(&gpu, |_| [0.0; 4]);
    host.frame(&mut gpu, &camera, u64::MAX);
    let shown = host.read_color(&gpu);
    let alpha = |x: usize| shown[(24 * 48 + x) * 4 + 3];
    assert!(alpha(23) < 0.02 && alpha(27) > 0.8, "{} {} {} {}", alpha(23), alpha(24), alpha(25), alpha(27));
}

/// Root mean square difference of colours.
fn difference(a: &[f32], b: &[f32]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (squares / a.len() as f64).sqrt()
}

#[test]
fn the_denoiser_takes_noise_away_and_leaves_what_has_converged() {
    let test = scenes::overlapping_volumes();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let mut picture = |size, samples, seed, denoise| {
        let settings = LiveSettings::new(size, size).with(|it| {
            it.target_samples = samples;
            it.seed = seed;
            it.denoise = denoise;
            // Of which nothing is left in a finished picture.
            it.kept_light = false;
        });
        let mut host = Host::new(&mut gpu, &test, settings);
        host.converge(&mut gpu, &camera, u64::MAX);
        host.set_color(&gpu, |_| [0.0; 4]);
        host.frame(&mut gpu, &camera, u64::MAX);
        host.read_color(&gpu)
    };
    // Against the noise of 4 samples, that of 192 is none; where little is left to compare, there are fewer pixels.
    let truth = picture(64, 192, 0, false);
    let (noisy, filtered) = (picture(64, 4, 1, false), picture(64, 4, 1, true));
    let (before, after) = (difference(&noisy, &truth), difference(&filtered, &truth));
    println!("error of 4 samples: {before:.4} before, {after:.4} after");
    assert!(after < 0.5 * before, "{before} becomes {after}");
    let truth = picture(32, 1024, 0, false);
    let (fine, kept) = (picture(32, 256, 1, false), picture(32, 256, 1, true));
    let (before, after) = (difference(&fine, &truth), difference(&kept, &truth));
    println!("error of 256 samples: {before:.4} before, {after:.4} after");
    assert!(after < 1.01 * before, "{before} becomes {after}");
}
