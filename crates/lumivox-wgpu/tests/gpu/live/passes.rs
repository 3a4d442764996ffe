//! Each pass of a live view alone: an image goes in, another comes out.

use lumivox_renderer::live::passes::*;
use lumivox_renderer::live::{FilmImages, Grain, Image, LiveImage, PixelFormat};
use lumivox_renderer::recording::Payload;
use lumivox_renderer::{Film, FilmCount, LiveSettings, Recording, ResourceId, Step};
use lumivox_testing::scenes;
use lumivox_wgpu::{Gpu, RenderRequest};

use super::{Host, NEAR, assert_same};
use crate::{film, gpu};

const SIZE: [u32; 2] = [24, 24];
const PIXELS: usize = 24 * 24;

fn buffer(bytes: u64, recording: &mut Recording) -> ResourceId {
    let id = ResourceId::external();
    recording.push(Step::CreateBuffer { id, label: "an image of a test", size: bytes.next_multiple_of(16) });
    id
}

fn write<T: bytemuck::NoUninit>(image: &Image, pixels: &[T], recording: &mut Recording) {
    assert_eq!(size_of_val(pixels) as u64, image.bytes().end - image.bytes().start);
    let (id, offset, data) = (image.buffer, image.offset, Payload::copy_of(pixels));
    recording.push(Step::WriteBuffer { id, offset, data });
}

/// First hits of a film's samples. A fine one has guides.
const ALBEDO: [f32; 4] = [0.5, 0.25, 0.75, 0.0];
const NORMAL: [f32; 4] = [0.0, -1.0, 0.5, 0.0];

/// A film with such planes, whose rays end so.
fn film_of(
    grain: Grain,
    planes: impl Fn(usize) -> [[f32; 4]; 2],
    limit: impl Fn(usize) -> f32,
    recording: &mut Recording,
) -> FilmImages {
    let buffer = buffer(FilmImages::buffer_bytes(PIXELS as u64, true), recording);
    let guides = grain == Grain::Fine;
    let images = FilmImages { grain, buffer, size: SIZE, guides };
    let sums: Vec<[f32; 4]> =
        (0..2).flat_map(|plane| (0..PIXELS).map(move |i| (plane, i))).map(|(p, i)| planes(i)[p]).collect();
    write(&images.film(), &sums, recording);
    write(&images.ray_limits(), &(0..PIXELS).map(limit).collect::<Vec<f32>>(), recording);
    for (guide, value) in images.guides().into_iter().flatten().zip([ALBEDO, NORMAL]) {
        write(
            &guide,
            &(0..PIXELS).map(|i| value.map(|x| x * planes(i)[0][3])).collect::<Vec<_>>(),
            recording,
        );
    }
    images
}

fn plane(name: LiveImage, planes: u32, format: PixelFormat, recording: &mut Recording) -> Image {
    let buffer = buffer(u64::from(planes) * PIXELS as u64 * format.bytes(), recording);
    Image { name, buffer, offset: 0, size: SIZE, planes, format }
}

/// What comes back, in its order.
fn run(gpu: &mut Gpu, recording: &Recording) -> Vec<Vec<u8>> {
    let read_backs = gpu.executor.execute(recording).unwrap();
    read_backs.into_iter().map(|read_back| read_back.wait().unwrap()).collect()
}

/// The last of that.
fn last<T: bytemuck::AnyBitPattern>(gpu: &mut Gpu, recording: &Recording) -> Vec<T> {
    run(gpu, recording)
        .pop()
        .unwrap()
        .chunks_exact(size_of::<T>())
        .map(bytemuck::pod_read_unaligned)
        .collect()
}

fn host(gpu: &mut Gpu) -> Host {
    let settings = LiveSettings::new(SIZE[0], SIZE[1]).with(|it| it.kept_light = false);
    Host::new(gpu, &scenes::noise(), settings)
}

fn column(pixel: usize) -> usize {
    pixel % 24
}

/// Four samples that are alike.
fn four(light: [f32; 3], alpha: f32, depth: f32) -> [[f32; 4]; 2] {
    let [r, g, b] = light;
    let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    [[r, g, b, alpha].map(|x| 4.0 * x), [4.0 * alpha * depth, 4.0 * luminance * luminance, 4.0, 0.0]]
}

#[test]
fn a_film_is_counted_and_emptied() {
    let mut gpu = gpu();
    let mut recording = Recording::new();
    let film = film_of(Grain::Fine, |_| four([1.0; 3], 1.0, 2.0), |_| 3.0, &mut recording);
    let count = buffer(size_of::<FilmCount>() as u64, &mut recording);
    let count = CountPass { film, samples: 4, count };
    count.record(&mut recording);
    ClearPass { film }.record(&mut recording);
    count.record(&mut recording);
    for image in film.all() {
        ReadPass { image }.record(&mut recording);
    }
    let came = run(&mut gpu, &recording);
    let counts = [&came[0], &came[1]].map(|bytes| bytemuck::pod_read_unaligned::<FilmCount>(bytes));
    assert_eq!(counts.map(|count| (count.samples, count.short)), [(4, 0), (0, PIXELS as u32)]);
    assert!(came[2..].iter().flatten().all(|byte| *byte == 0), "it is empty");
}

#[test]
fn a_film_keeps_a_part() {
    let mut gpu = gpu();
    let mut recording = Recording::new();
    let sums = |pixel| if column(pixel) < 20 { four([1.0, 2.0, 3.0], 0.5, 2.0) } else { [[0.0; 4]; 2] };
    let film = film_of(Grain::Fine, sums, |_| 3.0, &mut recording);
    FadePass { film, kept: 0.5, scale: 2.0 }.record(&mut recording);
    film.film().record_read(&mut recording);
    let kept: Vec<[f32; 4]> = last(&mut gpu, &recording);
    for pixel in 0..PIXELS {
        let [light, moments] = sums(pixel);
        assert_eq!(
            kept[pixel],
            [light[0], light[1], light[2], 0.5 * light[3]],
            "half of it, twice as bright"
        );
        let wanted = [0.5 * moments[0], 2.0 * moments[1], 0.5 * moments[2], 0.0];
        assert_eq!(kept[PIXELS + pixel], wanted);
    }
    // As many hits fewer.
    for (guide, value) in film.guides().unwrap().into_iter().zip([ALBEDO, NORMAL]) {
        let mut recording = Recording::new();
        guide.record_read(&mut recording);
        let sums: Vec<[f32; 4]> = last(&mut gpu, &recording);
        assert!(
            (0..PIXELS).all(|pixel| sums[pixel] == value.map(|x| x * kept[pixel][3])),
            "{:?}",
            guide.name
        );
    }
}

#[test]
fn a_films_pixels_start_over_where_the_hosts_depth_changed() {
    let mut gpu = gpu();
    let host = host(&mut gpu);
    // A mesh was in eight columns, and is in four of them.
    host.set_depth(&gpu, |at| if at[0] < 4 { 2.0 } else { 0.0 });
    let mut recording = Recording::new();
    let before = |pixel| if column(pixel) < 8 { 2.0 } else { 0.0 };
    let film = film_of(Grain::Fine, |_| four([1.0; 3], 1.0, 1.0), before, &mut recording);
    let pass = HostDepthPass {
        depth: host.host_depth(),
        farthest: 10.0,
        films: vec![film],
        restarts: buffer(16, &mut recording),
        is_asked: true,
    };
    pass.record(&mut recording);
    let images = [film.film(), film.ray_limits()].into_iter().chain(film.guides().unwrap());
    images.for_each(|image| image.record_read(&mut recording));
    let came = run(&mut gpu, &recording);
    assert_eq!(came[0], (4u32 * 24).to_le_bytes());
    let [sums, albedo, normal] = [1, 3, 4].map(|i| -> &[[f32; 4]] { bytemuck::cast_slice(&came[i]) });
    let limits: &[f32] = bytemuck::cast_slice(&came[2]);
    for pixel in 0..PIXELS {
        let starts_over = (4..8).contains(&column(pixel));
        let wanted = if starts_over { [[0.0; 4]; 2] } else { four([1.0; 3], 1.0, 1.0) };
        assert_eq!([sums[pixel], sums[PIXELS + pixel]], wanted, "pixel {pixel}");
        assert_eq!(limits[pixel], if column(pixel) < 4 { 2.0 } else { 0.0 });
        let guides =
            [ALBEDO, NORMAL].map(|guide| if starts_over { [0.0; 4] } else { guide.map(|x| 4.0 * x) });
        assert_eq!([albedo[pixel], normal[pixel]], guides, "pixel {pixel}");
    }
}

#[test]
fn a_film_is_traced() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let wanted = film(&test, &RenderRequest::new(SIZE[0], SIZE[1], 8));
    let mut gpu = gpu();
    let host = host(&mut gpu);
    let limits = gpu.executor.limits();
    let mut recording = Recording::new();
    // Rays of the left columns end before they begin.
    let limit = |pixel| if column(pixel) < 4 { 1e-3 } else { 0.0 };
    let images = film_of(Grain::Coarse, |_| [[0.0; 4]; 2], limit, &mut recording);
    let paths = limits.loop_turns.map(|_| buffer(64 * PIXELS as u64, &mut recording));
    let settings = PathSettings { camera, seed: 0, roulette_start: 4, ambient: [0.0; 3] };
    let pass = TracePass::new(&host.cache, images, paths, &settings, Share::of_all(SIZE, 8, 8));
    // Where paths are put aside, the next dispatch goes on with them.
    let mut traced = Film::new(SIZE[0], SIZE[1], false);
    for _ in 0..100 {
        pass.record(&mut recording);
        images.film().record_read(&mut recording);
        let bytes = run(&mut gpu, &recording).pop().unwrap();
        traced.insert([0, 0], SIZE, &bytes);
        if traced.min_samples() == 8 {
            break;
        }
        recording = Recording::new();
    }
    assert_eq!(traced.min_samples(), 8);
    assert_same(&traced, &wanted, (0..PIXELS).filter(|pixel| column(*pixel) >= 4));
    assert!((0..PIXELS).filter(|pixel| column(*pixel) < 4).all(|pixel| traced.alpha(pixel) == 0.0));
}

#[test]
fn noise_is_filtered_and_what_is_even_stays() {
    let mut gpu = gpu();
    let checks = |pixel: usize| (pixel % 24 + pixel / 24).is_multiple_of(2);
    for is_coarse in [false, true] {
        let mut recording = Recording::new();
        // On the left one light, on the right one that is noisy, with a pixel that outshines all others.
        let outshines = 5 * 24 + 18;
        let sums = |pixel| {
            let light = match pixel {
                _ if column(pixel) < 12 => 1.0,
                _ if pixel == outshines => 1000.0,
                _ if checks(pixel) => 0.5,
                _ => 1.5,
            };
            let [light_sum, mut moments] = four([light; 3], 1.0, 2.0);
            if column(pixel) >= 12 {
                // Its samples were as different.
                moments[1] = 4.0 * (light * light + 4.0);
            }
            [light_sum, moments]
        };
        let film = film_of(Grain::Coarse, sums, |_| 0.0, &mut recording);
        let denoised = plane(LiveImage::Denoised(Grain::Coarse), 2, PixelFormat::FourFloats, &mut recording);
        let spare = buffer(32 * PIXELS as u64, &mut recording);
        DenoisePass { film, denoised, spare, kept_light: None, is_coarse }.record(&mut recording);
        denoised.record_read(&mut recording);
        let shown: Vec<[f32; 4]> = last(&mut gpu, &recording);
        for pixel in (0..PIXELS).filter(|pixel| column(*pixel) < 8) {
            assert!((shown[pixel][0] - 1.0).abs() < 0.05, "{is_coarse}: {pixel}: {:?}", shown[pixel]);
        }
        let spread = |film: &dyn Fn(usize) -> f32| {
            let calm = (0..PIXELS).filter(|pixel| column(*pixel) >= 14 && pixel / 24 >= 14);
            let lights: Vec<f32> = calm.map(film).collect();
            lights.iter().cloned().fold(0.0, f32::max) - lights.iter().cloned().fold(f32::INFINITY, f32::min)
        };
        assert!(spread(&|pixel| shown[pixel][0]) < 0.5, "{is_coarse}: {}", spread(&|pixel| shown[pixel][0]));
        if is_coarse {
            assert!(shown[outshines][0] < 4.0, "{:?}", shown[outshines]);
        }
    }
}

#[test]
fn a_picture_is_made_of_a_film() {
    let mut gpu = gpu();
    let host = host(&mut gpu);
    host.set_depth(&gpu, |_| 0.0);
    let camera = scenes::noise().camera.with_aspect(1.0);
    let mut recording = Recording::new();
    let sums = |pixel| four([0.5, 0.25, 0.125], if column(pixel) < 12 { 0.75 } else { 0.25 }, 2.0);
    let film = film_of(Grain::Fine, sums, |_| 0.0, &mut recording);
    let pass = PicturePass {
        films: PictureFilms::Fine(ShownFilm { film, denoised: None }),
        is_denoised: false,
        camera,
        farthest: 10.0,
        exposure: 2.0,
        host_depth: Some(host.host_depth()),
        any_texture: host.names[1],
        fog: None,
        color: plane(LiveImage::Color, 1, PixelFormat::FourFloats, &mut recording),
        depth: plane(LiveImage::Depth, 1, PixelFormat::Float, &mut recording),
    };
    pass.record(&mut recording);
    pass.color.record_read(&mut recording);
    pass.depth.record_read(&mut recording);
    let came = run(&mut gpu, &recording);
    let (colors, depths): (&[[f32; 4]], &[f32]) =
        (bytemuck::cast_slice(&came[0]), bytemuck::cast_slice(&came[1]));
    for pixel in 0..PIXELS {
        let alpha = if column(pixel) < 12 { 0.75 } else { 0.25 };
        assert_eq!(colors[pixel], [1.0, 0.5, 0.25, alpha]);
        // What is mostly seen through has none.
        let depth = if alpha > 0.5 { NEAR as f32 / 2.0 } else { -1.0 };
        assert!((depths[pixel] - depth).abs() < 1e-6, "pixel {pixel}: {} is not {depth}", depths[pixel]);
    }
}

#[test]
fn a_picture_is_drawn() {
    let mut gpu = gpu();
    let host = host(&mut gpu);
    host.set_color(&gpu, |_| [0.0, 0.0, 1.0, 1.0]);
    let mut recording = Recording::new();
    let color = plane(LiveImage::Color, 1, PixelFormat::FourFloats, &mut recording);
    let depth = plane(LiveImage::Depth, 1, PixelFormat::Float, &mut recording);
    let colors: Vec<_> = (0..PIXELS).map(|i| [column(i) as f32 / 32.0, 0.25, 0.0, 0.5]).collect();
    write(&color, &colors, &mut recording);
    let depths: Vec<f32> = (0..PIXELS).map(|i| if column(i) < 6 { 0.25 } else { -1.0 }).collect();
    write(&depth, &depths, &mut recording);
    DrawPass { image: color, target: host.names[0] }.record(&mut recording);
    DrawPass { image: depth, target: host.names[2] }.record(&mut recording);
    run(&mut gpu, &recording);
    let (shown, written) = (host.read_color(&gpu), host.read_depth(&gpu));
    for pixel in 0..PIXELS {
        let wanted = [column(pixel) as f32 / 32.0, 0.25, 0.5, 1.0];
        assert_eq!(shown[4 * pixel..4 * pixel + 4], wanted, "pixel {pixel}");
        assert_eq!(written[pixel], if column(pixel) < 6 { 0.25 } else { 0.0 });
    }
}

/// A denoiser of somebody else's: it paints.
#[derive(Debug)]
struct Paint {
    denoised: Image,
}

impl FramePass for Paint {
    fn name(&self) -> &'static str {
        "paint"
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use { image: self.denoised, access: Access::Make }]
    }

    fn record(&self, recording: &mut Recording) {
        let pixels = self.denoised.size.iter().product::<u32>() as usize;
        let mut planes = vec![[0.25f32, 0.5, 0.75, 1.0]; pixels];
        planes.extend(vec![[0.0, 0.0, 0.0, 1.0]; pixels]);
        write(&self.denoised, &planes, recording);
    }
}

#[test]
fn a_pass_takes_the_place_of_another() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let mut host = host(&mut gpu);
    host.set_color(&gpu, |_| [0.0, 0.0, 0.0, 1.0]);
    let frame = host.host_frame();
    let mut recording = Recording::new();
    // A coarse image, which is always denoised.
    let mut planned = host
        .live
        .plan_frame(&host.cache, &camera, &host.settings, &frame, PIXELS as u64, &mut recording)
        .unwrap();
    let mut replaced = 0;
    for pass in &mut planned.passes {
        if pass.name() == "denoise" {
            let made = pass.uses().into_iter().find(|used| used.access == Access::Make).unwrap();
            *pass = Box::new(Paint { denoised: made.image });
            replaced += 1;
        }
    }
    assert_eq!(replaced, 1);
    planned.record(&mut recording);
    run(&mut gpu, &recording);
    for (pixel, shown) in host.read_color(&gpu).chunks(4).enumerate() {
        let painted = [0.25, 0.5, 0.75, 1.0].iter().zip(shown);
        assert!(painted.into_iter().all(|(a, b)| (a - b).abs() < 1e-3), "pixel {pixel}: {shown:?}");
    }
}

/// Red, green and blue in 9 bits each with a common exponent, as cells have light: of a value between a half and one.
fn packed(value: f32) -> u32 {
    let mantissa = (value * 512.0).round() as u32;
    mantissa | (mantissa << 9) | (mantissa << 18) | (15 << 27)
}

fn unpacked(word: u32) -> f32 {
    (word & 0x1ff) as f32 * ((word >> 27) as f32 - 24.0).exp2()
}

/// A slope to the left of the middle and another behind it to the right, opaque and white. Light over colour is .9 at every
/// second pixel and .6 at the others to the left, and .5 to the right.
#[test]
fn what_few_points_tell_is_smoothed_along_its_surface_and_no_farther() {
    const WHITE: u32 = u32::MAX;
    let mut gpu = gpu();
    let noisy = |pixel: usize| match (column(pixel) < 12, (pixel / 24 + column(pixel)).is_multiple_of(2)) {
        (true, true) => 0.9,
        (true, false) => 0.6,
        (false, _) => 0.5,
    };
    let depth = |pixel: usize| if column(pixel) < 12 { 1.0 + 0.01 * column(pixel) as f32 } else { 1.5 };
    let smooth = |sureness: f32, gpu: &mut Gpu| {
        let mut recording = Recording::new();
        let picture = plane(LiveImage::KeptLight, 2, PixelFormat::FourFloats, &mut recording);
        let first = (0..PIXELS).map(|pixel| [packed(noisy(pixel)), 0, 0, sureness.to_bits()]);
        let second = (0..PIXELS).map(|pixel| [packed(noisy(pixel)), 0, WHITE, depth(pixel).to_bits()]);
        write(&picture, &first.chain(second).collect::<Vec<_>>(), &mut recording);
        let frame = lumivox_shaders::layout::Frame {
            march_stride: 1,
            pixel_size: 0.01,
            ..bytemuck::Zeroable::zeroed()
        };
        LightSmoothPass { picture, frame }.record(&mut recording);
        picture.record_read(&mut recording);
        let words: Vec<[u32; 4]> = last(gpu, &recording);
        (0..PIXELS).map(|pixel| unpacked(words[PIXELS + pixel][0])).collect::<Vec<f32>>()
    };
    let smoothed = smooth(0.0, &mut gpu);
    for (pixel, light) in smoothed.iter().enumerate() {
        let wanted = if column(pixel) < 12 { 0.75 } else { 0.5 };
        // At its edges a surface has neighbours to one side alone.
        let is_inner = [column(pixel), pixel / 24].into_iter().all(|at| at % 12 > 1 && at % 12 < 10);
        let reach = if is_inner { 0.02 } else { 0.06 };
        assert!((light - wanted).abs() < reach, "pixel {pixel}: {light} for {wanted}");
    }
    let sure = smooth(9.0, &mut gpu);
    assert!((0..PIXELS).all(|pixel| (sure[pixel] - noisy(pixel)).abs() < 0.002), "what is sure stays");
}
