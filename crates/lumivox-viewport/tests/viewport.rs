//! The viewport on a real device, software Vulkan where there is no other, against the command's way to pixels.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use lumivox_core::document::{Backdrop, Display, Tone};
use lumivox_core::glam::DVec3;
use lumivox_core::{
    CancelToken, Ease, Environment, Medium, Orbit, PerspectiveCamera, Preset, Scene, TransferFunction, Volume,
};
use lumivox_phantom::{AnatomyOptions, anatomy, sphere};
use lumivox_renderer::{DisplaySettings, display};
use lumivox_viewport::{Button, Gesture, Held, Pace, Picture, Profile, Viewport, orbit_of, pick};
use lumivox_wgpu::{Gpu, RenderRequest, render, wgpu};

fn gpu() -> Gpu {
    let name = std::env::var("LUMIVOX_GPU").ok();
    Gpu::open(name.as_deref())
        .expect("a GPU or software Vulkan (Debian: apt-get install mesa-vulkan-drivers)")
}

/// A ball that looks solid, 40 mm in radius.
fn ball() -> (Scene, Arc<Volume>) {
    let volume = Arc::new(sphere(1000.0, 40.0, 2.0));
    let opacity = [(-500.0, 0.0), (0.0, 0.95)];
    let look = TransferFunction::from_points(Ease::Linear, &opacity, &[(0.0, [0.8, 0.5, 0.3])]).unwrap();
    let mut medium = Medium::new(look);
    medium.density_scale = 50.0;
    (Scene::with_volume(volume.clone(), medium), volume)
}

fn front(distance: f64) -> PerspectiveCamera {
    Orbit { target: DVec3::ZERO, azimuth: 0.0, elevation: 0.0, distance, vertical_fov: 0.5 }.camera()
}

/// What the texture holds; waits for it.
fn pixels(viewport: &Viewport) -> Vec<[u8; 4]> {
    let executor = &viewport.gpu().executor;
    let [width, height] = viewport.size();
    let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = executor.device().create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = executor.device().create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let target = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(viewport.texture().as_image_copy(), target, viewport.texture().size());
    executor.queue().submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| ());
    executor.wait().unwrap();
    let bytes = buffer.slice(..).get_mapped_range();
    let rows = bytes.chunks_exact(row as usize).map(|row| &row[..4 * width as usize]);
    rows.flat_map(|row| row.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect::<Vec<_>>()).collect()
}

/// Frames until the picture rests.
fn settle(viewport: &mut Viewport, picture: &Picture<'_>) -> u32 {
    let begin = Instant::now();
    loop {
        let progress = viewport.frame(picture).unwrap();
        if progress.rests {
            return progress.samples;
        }
        assert!(begin.elapsed() < Duration::from_secs(240), "{progress:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// The mean difference of two pictures' colours, in codes.
fn difference(a: &[[u8; 4]], b: &[[u8; 4]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let of = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).map(|i| f64::from(a[i].abs_diff(b[i]))).sum::<f64>();
    a.iter().zip(b).map(of).sum::<f64>() / (3 * a.len()) as f64
}

#[test]
fn a_view_at_rest_is_the_commands_picture() {
    let volume = anatomy(
        AnatomyOptions { size: 40, ..Default::default() },
        lumivox_core::Progress::SILENT,
        &CancelToken::new(),
    );
    let volume = Arc::new(volume.unwrap());
    let scene = Scene {
        environment: Environment { rotation: 0.7, ..Environment::default() },
        ..Scene::with_volume(volume.clone(), Preset::CtBone.medium(&volume))
    };
    let camera = front(0.7);
    let (size, samples) = ([72, 48], 96);
    let mut device = gpu();
    let request = RenderRequest::new(size[0], size[1], samples);
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let film = render(&mut device, &scene, &camera, &request, go_on).unwrap().film;
    let mut viewport = Viewport::new(device, size);
    let color = Display { background: Backdrop::Color([40, 80, 160]), exposure: 0.5, ..Display::default() };
    let others = [
        Display { background: Backdrop::Environment, tone: Tone::Aces, ..Display::default() },
        Display { tone: Tone::Plain, gamma: 1.4, exposure: -1.0, ..color },
    ];
    let mut frames = 0;
    for shown in [color].iter().chain(&others) {
        let picture =
            Picture { scene: &scene, version: 1, camera: &camera, display: shown, samples, seed: 0 };
        let reached = settle(&mut viewport, &picture);
        assert!(reached >= samples, "{reached}");
        let mut wanted =
            DisplaySettings::from(shown).pixels(&film, &scene.environment, &camera).into_flattened();
        if let Backdrop::Color(color) = shown.background {
            display::put_on(&mut wanted, color);
        }
        let wanted: Vec<[u8; 4]> = wanted.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
        let found = pixels(&viewport);
        assert!(found.iter().all(|pixel| pixel[3] == 255), "it is opaque");
        let off = difference(&found, &wanted);
        assert!(off < 1.5, "{shown:?}: {off} codes");
        // It is no picture of nothing, either.
        let flat = vec![found[0]; found.len()];
        assert!(difference(&found, &flat) > 5.0);
        frames += 1;
    }
    assert_eq!(frames, 3);
}

#[test]
fn what_rests_is_not_traced_again_and_what_changes_is() {
    let (scene, _) = ball();
    let mut viewport = Viewport::new(gpu(), [40, 30]);
    assert!(!viewport.resize([40, 30]) && viewport.resize([48, 32]));
    let display = Display::default();
    let [near, far] = [0.3, 0.6].map(front);
    let picture =
        |camera| Picture { scene: &scene, version: 7, camera, display: &display, samples: 8, seed: 0 };
    settle(&mut viewport, &picture(&near));
    let before = pixels(&viewport);
    let rested = viewport.frame(&picture(&near)).unwrap();
    assert!(rested.rests && rested.is_shown && pixels(&viewport) == before);
    assert!(!viewport.frame(&picture(&far)).unwrap().rests);
    settle(&mut viewport, &picture(&far));
    let covered = |pixels: &[[u8; 4]]| pixels.iter().filter(|p| p[0] > 60).count();
    let [large, small] = [covered(&before), covered(&pixels(&viewport))];
    assert!(small > 10 && large > 3 * small, "{large} {small}");
    viewport.forget().unwrap();
    assert!(!viewport.progress().is_shown);
    settle(&mut viewport, &picture(&near));
    assert!(difference(&pixels(&viewport), &before) < 1.0, "it comes back");
}

#[test]
fn what_is_picked_lies_where_it_is_seen() {
    let (mut scene, volume) = ball();
    let camera = front(0.5).with_aspect(1.0);
    let half_voxel = 1.0;
    let picked = pick(&scene, &camera, [0.5, 0.5]).unwrap();
    let wanted = DVec3::new(0.0, 0.0, 0.040);
    assert!((picked.world - wanted).length() * 1e3 < half_voxel + 0.5, "{picked:?}");
    assert!((picked.distance - 0.46).abs() * 1e3 < half_voxel + 0.5);
    assert_eq!(picked.volume, 0);
    let voxel = DVec3::from_array(picked.voxel.map(|i| i as f64));
    let there = volume.patient_from_voxel().transform_point3(voxel);
    assert!((there - picked.patient_mm).abs().max_element() <= half_voxel + 1e-9);
    assert!(picked.value > -600.0 && picked.value <= 1000.0, "{}", picked.value);
    // The ball's edge is 0.080 from the axis at distance 1, the image's 0.255.
    let at = |v| pick(&scene, &camera, [0.5, v]);
    assert!(at(0.5 - 0.5 * 0.070 / 0.255).is_some() && at(0.5 - 0.5 * 0.090 / 0.255).is_none());
    assert_eq!(pick(&scene, &camera, [0.0, 0.0]), None, "beside the volume");
    let away = PerspectiveCamera::look_at(DVec3::new(0.0, 0.0, 0.5), DVec3::Z, DVec3::Y, 0.5);
    assert_eq!(pick(&scene, &away.with_aspect(1.0), [0.5, 0.5]), None, "behind the camera");
    // What is cut away is not there: the front half.
    scene.volumes[0].clip_box[0].y = 0.5;
    let behind = pick(&scene, &camera, [0.5, 0.5]).unwrap();
    assert!(behind.world.z.abs() * 1e3 < half_voxel + 0.5, "{behind:?}");
    // And what hardly takes light away is not, either.
    scene.volumes[0].medium.density_scale = 1e-6;
    assert_eq!(pick(&scene, &camera, [0.5, 0.5]), None);
}

#[test]
fn a_mouse_turns_moves_and_brings_closer() {
    let start = Orbit { target: DVec3::ZERO, azimuth: 0.2, elevation: 0.1, distance: 1.0, vertical_fov: 0.6 };
    let after = |gesture: Gesture, by| {
        let mut orbit = start;
        gesture.apply(&mut orbit, by);
        orbit
    };
    let held = |shift, command| Held { shift, command };
    let ohif = Profile::OHIF;
    assert_eq!(ohif.gesture(Button::Primary, held(false, false)), Some(Gesture::Turn));
    assert_eq!(ohif.gesture(Button::Middle, held(false, false)), Some(Gesture::Pan));
    assert_eq!(ohif.gesture(Button::Secondary, held(false, false)), Some(Gesture::Dolly));
    assert_eq!(ohif.gesture(Button::Primary, held(true, false)), Some(Gesture::Pan));
    assert_eq!(ohif.gesture(Button::Middle, held(true, true)), None);
    // Dragged to the right, what is in front moves to the right: the camera goes to the left.
    assert!(
        after(Gesture::Turn, [0.1, 0.0]).camera().world_from_camera.translation.x
            < start.camera().world_from_camera.translation.x
    );
    assert!(after(Gesture::Turn, [0.0, 9.0]).elevation < std::f64::consts::FRAC_PI_2);
    assert!(
        after(Gesture::Dolly, [0.0, 0.2]).distance < 1.0
            && after(Gesture::Dolly, [0.0, -99.0]).distance <= 50.0
    );
    // The point under the pointer stays there: a tenth of the view's height to the right and down.
    let moved = after(Gesture::Pan, [0.1, 0.1]).camera().with_aspect(1.0);
    let ray = moved.ray([0.6, 0.6]);
    let nearest = ray.origin + ray.direction * (DVec3::ZERO - ray.origin).dot(ray.direction);
    assert!(nearest.length() < 1e-9, "{nearest}");
    let mut closer = start;
    Gesture::wheel(&mut closer, 1.0);
    assert!(closer.distance < 1.0);
    // A camera is an orbit again.
    let back = orbit_of(&start.camera(), DVec3::ZERO);
    assert!((back.azimuth - 0.2).abs() < 1e-9 && (back.elevation - 0.1).abs() < 1e-9);
    assert!((back.distance - 1.0).abs() < 1e-9 && back.target.length() < 1e-9);
}

#[test]
fn little_is_traced_while_something_moves() {
    let [gpu, software] = [false, true].map(|software| Pace::of(software).resolution_scale([1920, 1080]));
    assert!(gpu == 1.0 && software < 0.5, "{gpu} {software}");
    for software in [false, true] {
        let pace = Pace::of(software);
        assert_eq!(pace.milliseconds(Duration::ZERO), pace.moving);
        assert_eq!(pace.milliseconds(Duration::from_secs(1)), pace.resting);
        assert!(pace.moving < pace.resting);
        assert_eq!(pace.resolution_scale([64, 48]), 1.0);
    }
}
