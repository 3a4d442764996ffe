//! What an opaque volume hides is not seen, neither as itself nor by what its edges do to the picture.

use lumivox_core::Camera;
use lumivox_core::glam::DAffine3;
use lumivox_renderer::LiveSettings;
use lumivox_testing::failures;
use lumivox_testing::png_io::SrgbImage;
use lumivox_testing::scenes::{self, TestScene};

use super::Host;
use crate::{first_pictures, gpu};

const SIZE: [u32; 2] = [120, 96];

/// Two samples for each pixel of the coarsest film.
const COARSE: u64 = 2 * (SIZE[0] as u64 / 8) * (SIZE[1] as u64 / 8);

/// Pixels about one that a picture of it may be made of.
const REACH: i64 = 14;

/// View depths of bars and of a capsule, in metres: they stand in the head's middle, under its skin everywhere.
fn meshes(distance: f64) -> impl Fn([u32; 2]) -> f64 {
    move |[x, y]| {
        let (across, down) = ((f64::from(x) - 60.0) / 10.0, (f64::from(y) - 48.0) / 30.0);
        match across * across + down * down {
            r if r < 1.0 => distance - 0.02 * (1.0 - r).sqrt(),
            _ if x % 12 < 2 || y % 32 < 2 => distance + 0.001 * f64::from(x % 12),
            _ => 0.0,
        }
    }
}

/// Dense enough to let nothing through.
fn opaque_head() -> TestScene {
    let mut test = first_pictures::head();
    test.scene.volumes[0].medium.density_scale *= 8.0;
    test
}

/// A frame over black, and then its pixels.
fn picture(host: &mut Host, gpu: &mut lumivox_wgpu::Gpu, camera: &Camera, budget: u64) -> SrgbImage {
    host.set_color(gpu, |_| [0.0, 0.0, 0.0, 1.0]);
    host.frame(gpu, camera, budget);
    let linear = host.read_color(gpu);
    let linear: Vec<[f64; 3]> = linear.chunks_exact(4).map(|p| [p[0], p[1], p[2]].map(f64::from)).collect();
    SrgbImage::from_linear(SIZE[0] as usize, SIZE[1] as usize, &linear)
}

/// Pixels that nothing behind the head's surface counts for: all about them is opaque and before the meshes.
fn opaque_pixels(gpu: &mut lumivox_wgpu::Gpu, camera: &Camera, distance: f64) -> Vec<usize> {
    let settings = LiveSettings::new(SIZE[0], SIZE[1]).with(|it| it.target_samples = 12);
    let mut host = Host::new(gpu, &opaque_head(), settings);
    host.set_depth(gpu, |_| distance - 0.02);
    host.converge(gpu, camera, u64::MAX);
    let film = host.film(gpu);
    let [width, height] = SIZE.map(i64::from);
    let is_opaque = |x: i64, y: i64| {
        (0..width).contains(&x) && (0..height).contains(&y) && film.alpha((y * width + x) as usize) == 1.0
    };
    let all_about = |at: i64| {
        (-REACH..=REACH).all(|dy| (-REACH..=REACH).all(|dx| is_opaque(at % width + dx, at / width + dy)))
    };
    (0..width * height).filter(|&at| all_about(at)).map(|at| at as usize).collect()
}

/// The largest difference of a pixel's channel, in codes of 255.
fn largest_difference(a: &SrgbImage, b: &SrgbImage, pixels: &[usize]) -> u8 {
    let channels = |&at: &usize| (0..3).map(move |i| a.pixels[at][i].abs_diff(b.pixels[at][i]));
    pixels.iter().flat_map(channels).max().unwrap()
}

#[test]
fn meshes_behind_an_opaque_volume_leave_no_trace_in_the_picture() {
    assert_no_trace(&["moving", "fading", "denoised"]);
}

#[test]
#[ignore = "slow: script/test --all"]
fn meshes_behind_an_opaque_volume_leave_no_trace_in_later_and_smaller_pictures() {
    assert_no_trace(&["resting", "longer denoised", "half as large"]);
}

/// In the pictures of those names.
fn assert_no_trace(of: &[&str]) {
    let test = opaque_head();
    let camera = test.camera.with_aspect(1.25);
    let distance = camera.world_from_camera.translation.length();
    let turned = |frame: u32| {
        let mut moved = camera;
        moved.world_from_camera =
            DAffine3::from_rotation_y(0.01 * f64::from(frame)) * camera.world_from_camera;
        moved
    };
    let mut gpu = gpu();
    let opaque = opaque_pixels(&mut gpu, &camera, distance);
    println!("{} pixels are opaque all about", opaque.len());
    assert!(opaque.len() > 60, "{} pixels", opaque.len());
    let folder = failures::folder("behind");
    let plain = LiveSettings::new(SIZE[0], SIZE[1]).with(|it| {
        it.target_samples = 64;
        // What is known of it depends on the order in which the GPU does its work.
        it.kept_light = false;
    });
    let fine = u64::from(SIZE[0] * SIZE[1]);
    // What is shown, the budget of a frame, and how many frames go by without motion.
    let shown = [
        ("moving", plain, COARSE, 0),
        ("resting", plain, COARSE, 12),
        ("fading", plain, fine / 3, 8),
        ("denoised", plain.with(|it| it.denoise = true), fine, 3),
        ("longer denoised", plain.with(|it| it.denoise = true), 3 * fine, 3),
        ("half as large", plain.with(|it| it.resolution_scale = 0.5), fine, 3),
    ];
    let mut worst = vec![];
    for (name, settings, budget, resting) in shown.into_iter().filter(|(name, ..)| of.contains(name)) {
        let mut pictures = [true, false].map(|has_meshes| {
            let mut host = Host::new(&mut gpu, &test, settings);
            match has_meshes {
                true => host.set_depth(&gpu, meshes(distance)),
                false => host.set_depth(&gpu, |_| 0.0),
            }
            for frame in (1..4).rev() {
                picture(&mut host, &mut gpu, &turned(frame), budget);
            }
            let mut last = picture(&mut host, &mut gpu, &camera, budget);
            for _ in 0..resting {
                last = picture(&mut host, &mut gpu, &camera, budget);
            }
            last
        });
        let far = largest_difference(&pictures[0], &pictures[1], &opaque);
        println!("{name}: {far} of 255 at most");
        for (picture, what) in pictures.iter_mut().zip(["with", "without"]) {
            picture.write(&folder.join(format!("{name} {what} meshes.png"))).unwrap();
        }
        worst.push((name, far));
    }
    // Half floats and sums in another order.
    let seen: Vec<_> = worst.into_iter().filter(|(_, far)| *far > 2).collect();
    assert!(seen.is_empty(), "what is hidden shows through, by so many codes of 255: {seen:?}");
}

/// Where the volume lets them be seen as anywhere else: they end none of its rays, standing or moving.
#[test]
fn meshes_behind_all_volumes_are_none_to_a_film() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let distance = camera.world_from_camera.translation.length();
    let mut gpu = gpu();
    let settings = LiveSettings::new(48, 48).with(|it| {
        it.denoise = true;
        it.kept_light = false;
    });
    let mut pictures = [2.0, 0.0].map(|factor| {
        let mut host = Host::new(&mut gpu, &test, settings);
        (0..6)
            .map(|frame| {
                host.set_depth(&gpu, |at| if at[0] % 12 < 3 + frame { factor * distance } else { 0.0 });
                host.set_color(&gpu, |_| [0.0, 0.0, 0.0, 1.0]);
                host.frame(&mut gpu, &camera, 48 * 48 / 3);
                host.read_color(&gpu)
            })
            .collect::<Vec<_>>()
    });
    let without = pictures[1].pop();
    assert!(without.iter().flatten().any(|light| *light > 0.1 && *light < 1.0));
    assert!(pictures[0].pop() == without, "what is behind the volume changes how that is seen");
}
