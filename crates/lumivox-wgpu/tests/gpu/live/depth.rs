//! The host's depth ends rays, wakes pixels, and is written for what comes later.

use lumivox_renderer::LiveSettings;
use lumivox_testing::scenes;
use lumivox_wgpu::RenderRequest;

use super::{Host, NEAR, assert_same, oblique};
use crate::{film, gpu};

#[test]
fn where_the_hosts_depth_changes_pixels_start_over_and_no_others() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings::new(24, 24).with(|it| {
        it.target_samples = 8;
        // Its points are samples, too.
        it.kept_light = false;
    });
    let distance = camera.world_from_camera.translation.length();
    let mesh = |left: u32| move |at: [u32; 2]| if (left..left + 8).contains(&at[0]) { distance } else { 0.0 };

    let mut host = Host::new(&mut gpu, &test, settings);
    host.set_depth(&gpu, mesh(4));
    host.converge(&mut gpu, &camera, 3000);
    host.set_depth(&gpu, mesh(6));
    // Two columns were left, two were entered: four of 24, eight samples each.
    let traced = host.converge(&mut gpu, &camera, 3000);
    assert_eq!(traced, 4 * 24 * 8);
    let moved = host.film(&mut gpu);

    let mut fresh = Host::new(&mut gpu, &test, settings);
    fresh.set_depth(&gpu, mesh(6));
    fresh.converge(&mut gpu, &camera, u64::MAX);
    assert_same(&moved, &fresh.film(&mut gpu), 0..24 * 24);
}

/// Whether only the host's depth changed the GPU alone knows: a host that draws on demand asks once more before it rests.
#[test]
fn a_mesh_that_moved_once_wakes_a_host_that_idles() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings::new(24, 24).with(|it| it.target_samples = 12);
    let distance = camera.world_from_camera.translation.length();
    let mesh = |left: u32| move |at: [u32; 2]| if (left..left + 8).contains(&at[0]) { distance } else { 0.0 };
    let mut host = Host::new(&mut gpu, &test, settings);
    host.set_depth(&gpu, mesh(4));
    host.converge(&mut gpu, &camera, u64::MAX);

    host.set_depth(&gpu, mesh(10));
    // The one frame that the move draws.
    let mut status = host.frame(&mut gpu, &camera, 3000);
    while !status.converged || status.awaits_feedback {
        if !status.converged {
            host.frame(&mut gpu, &camera, 3000);
        }
        // `frame` has handed over all that came back.
        status = host.live.status();
    }
    let film = host.film(&mut gpu);
    let lacking = (0..24 * 24).filter(|&pixel| film.samples(pixel) < 12.0).count();
    assert_eq!(lacking, 0, "pixels are short of samples, and nobody draws them");
}

/// Under jitter a depth of the neighbourhood passes for none changed; that of another camera must not.
#[test]
fn a_camera_that_moves_under_jitter_leaves_no_ends_of_rays_behind() {
    let test = scenes::noise();
    let before = test.camera.with_aspect(1.0);
    let mut after = before;
    // About a third of a pixel.
    after.world_from_camera.translation.x +=
        0.3 * 2.0 * before.world_from_camera.translation.length() * (test.camera.vertical_fov / 2.0).tan()
            / 24.0;
    let mut gpu = gpu();
    let settings = LiveSettings::new(24, 24).with(|it| it.target_samples = 8);
    for budget in [u64::MAX, 300] {
        let mut moved = Host::new(&mut gpu, &test, settings);
        moved.jittered = true;
        moved.set_depth(&gpu, |at| oblique(&before, [24, 24], at));
        moved.converge(&mut gpu, &before, budget);
        moved.set_depth(&gpu, |at| oblique(&after, [24, 24], at));
        moved.converge(&mut gpu, &after, budget);
        let mut fresh = Host::new(&mut gpu, &test, settings);
        fresh.set_depth(&gpu, |at| oblique(&after, [24, 24], at));
        fresh.converge(&mut gpu, &after, u64::MAX);
        assert_same(&moved.film(&mut gpu), &fresh.film(&mut gpu), 0..24 * 24);
    }
}

/// Where nothing is behind it either, there is no other depth in the neighbourhood.
#[test]
fn a_mesh_that_passed_under_jitter_ends_no_rays() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let wanted = film(&test, &RenderRequest::new(24, 24, 8));
    let mut gpu = gpu();
    let mut host = Host::new(&mut gpu, &test, LiveSettings::new(24, 24).with(|it| it.target_samples = 8));
    host.jittered = true;
    let distance = camera.world_from_camera.translation.length();
    for left in [0, 6, 12, 18] {
        let mesh = |at: [u32; 2]| if (left..left + 8).contains(&at[0]) { 0.3 * distance } else { 0.0 };
        host.set_depth(&gpu, mesh);
        host.converge(&mut gpu, &camera, u64::MAX);
    }
    host.set_depth(&gpu, |_| 0.0);
    host.converge(&mut gpu, &camera, u64::MAX);
    assert_same(&host.film(&mut gpu), &wanted, 0..24 * 24);
}

#[test]
fn a_host_that_gives_no_depth_any_more_ends_no_rays() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let wanted = film(&test, &RenderRequest::new(24, 24, 8));
    let mut gpu = gpu();
    let settings = LiveSettings::new(24, 24).with(|it| it.target_samples = 8);
    let mut host = Host::new(&mut gpu, &test, settings);
    let distance = camera.world_from_camera.translation.length();
    host.set_depth(&gpu, |_| distance);
    host.converge(&mut gpu, &camera, u64::MAX);
    host.gives_depth = false;
    host.converge(&mut gpu, &camera, u64::MAX);
    assert_same(&host.film(&mut gpu), &wanted, 0..24 * 24);
}

/// A mesh that moves in every frame keeps pixels starting over; none of them may be a hole for a single frame.
#[test]
fn a_moving_mesh_tears_no_holes() {
    let mut test = scenes::noise();
    test.scene.volumes[0].medium.density_scale = 50.0;
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings::new(96, 96).with(|it| it.target_samples = 64);
    // A row's alpha is that of hundreds of samples.
    let wanted = settings.with(|it| (it.target_samples, it.kept_light) = (16, false));
    let mut host = Host::new(&mut gpu, &test, wanted);
    host.converge(&mut gpu, &camera, u64::MAX);
    let done = host.film(&mut gpu);
    let distance = camera.world_from_camera.translation.length();
    // With much time the mesh passes before the volume alone.
    for (budget, frames) in [(600, 0..40), (2400, 0..40), (20_000, 12..28)] {
        let mut host = Host::new(&mut gpu, &test, settings);
        for frame in frames {
            // In the middle of the volume: it hides next to nothing, and makes pixels start over all the same.
            let mesh =
                |at: [u32; 2]| if (2 * frame..2 * frame + 16).contains(&at[0]) { distance } else { 0.0 };
            host.set_depth(&gpu, mesh);
            host.set_color(&gpu, |_| [0.0; 4]);
            host.frame(&mut gpu, &camera, budget);
            let shown = host.read_color(&gpu);
            // Coarse films are blurred at the volume's outline.
            for row in 28..68 {
                let pixels = row * 96..(row + 1) * 96;
                let wanted: f64 = pixels.clone().map(|p| done.alpha(p)).sum();
                let seen: f64 = pixels.map(|p| f64::from(shown[p * 4 + 3])).sum();
                let share = seen / wanted;
                assert!(share > 0.75, "budget {budget}, frame {frame}, row {row}: {share} of the volume");
            }
        }
    }
}

/// The depth that is written is the mean depth of the first hits, where the volume hides more than it shows.
#[test]
fn what_is_drawn_later_meets_the_volumes_depth() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings::new(24, 24).with(|it| it.target_samples = 40);
    let mut host = Host::new(&mut gpu, &test, settings);
    host.converge(&mut gpu, &camera, u64::MAX);
    let (film, written) = (host.film(&mut gpu), host.read_depth(&gpu));
    let (mut opaque, mut clear) = (0, 0);
    for (pixel, z) in written.into_iter().enumerate() {
        let z = f64::from(z);
        if film.alpha(pixel) < 0.5 {
            clear += 1;
            assert_eq!(z, 0.0, "pixel {pixel} is not touched");
        } else {
            opaque += 1;
            let (depth, wanted) = (NEAR / z, film.depth(pixel));
            assert!((depth - wanted).abs() < 1e-4 * wanted, "pixel {pixel}: {depth} is not {wanted}");
        }
    }
    assert!(opaque > 20 && clear > 20, "{opaque} {clear}");
}
