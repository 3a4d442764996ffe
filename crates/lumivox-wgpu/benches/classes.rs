//! What labels, cuts and peeling cost: `cargo bench -p lumivox-wgpu --bench classes [VOXELS] [WIDTHxHEIGHT]`.
//!
//! Each beside a picture that shows the same without them: labels whose looks hardly differ beside no labels, a plane that cuts
//! the torso open beside a clip box that does, skin that is peeled live beside a scan without it. Milliseconds per sample.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use lumivox_core::glam::DVec3;
use lumivox_core::{
    CancelToken, ClipShape, Label, LabelStyle, LabelVolume, Labelling, Peel, Preset, Progress, Scene,
    SurfaceReflection, Volume, framing,
};
use lumivox_phantom::{AnatomyOptions, TorsoOptions, anatomy, torso};
use lumivox_segmentation::{peel, segment, skin_depth};
use lumivox_wgpu::{Gpu, Outcome, RenderRequest, render};

const SAMPLES: u32 = 256;
const LONGEST: Duration = Duration::from_secs(20);
const WARM_UP: Duration = Duration::from_secs(1);

const LOOKS: [Preset; 3] = [Preset::CtBone, Preset::CtSkin, Preset::CtMuscle];

/// What is peeled, in mm.
const PEELED_MM: f64 = 6.0;

fn main() {
    let (mut voxels, mut size) = (512, [1920, 1080]);
    // Cargo itself adds `--bench`.
    for word in std::env::args().skip(1).filter(|word| !word.starts_with("--")) {
        match (word.parse(), word.split_once('x').map(|(width, height)| [width.parse(), height.parse()])) {
            (Ok(number), _) => voxels = number,
            (_, Some([Ok(width), Ok(height)])) => size = [width, height],
            _ => panic!("'{word}' is no option"),
        }
    }
    let mut gpu = Gpu::open(std::env::var("LUMIVOX_GPU").ok().as_deref()).expect("a GPU or software Vulkan");
    println!(
        "{} ({}), {voxels} voxels, {} x {}",
        gpu.description.name, gpu.description.driver, size[0], size[1]
    );
    let (silent, never) = (Progress::SILENT, CancelToken::new());
    let head = |noise_hu| {
        let options = AnatomyOptions { size: voxels, noise_hu, ..Default::default() };
        anatomy(options, silent, &never).expect("nobody cancels")
    };
    let labels = Arc::new(tissues(&head(0.0)));
    let head = Arc::new(head(12.0));
    let options = TorsoOptions { size: voxels, ..Default::default() };
    let torso = Arc::new(torso(options, silent, &never).expect("nobody cancels"));

    println!("\n{:<12} {:<28} {:>8} {:>8}", "look", "", "ms", "times");
    let mut row = |look: Preset, what: &str, scene: &Scene, plain: Option<f64>| {
        let ms = measure(&mut gpu, scene, size);
        let times = plain.map_or(String::new(), |plain| format!("{:.2}", ms / plain));
        println!("{:<12} {what:<28} {ms:>8.2} {times:>8}", look.name());
        ms
    };
    for look in LOOKS {
        let plain = Scene::with_volume(head.clone(), look.medium(&head));
        let ms = row(look, "head", &plain, None);
        let mut scene = plain.clone();
        scene.volumes[0].labels = Some(Labelling::new(labels.clone()));
        row(look, "one look of five labels", &scene, Some(ms));
        // The picture is that of one look.
        let surface = scene.volumes[0].medium.surface;
        let less = |value: u8, x: f64| x * (1.0 - 1e-4 * f64::from(value));
        let mut styled = |what: &str, style: &dyn Fn(u8) -> LabelStyle| {
            let labels = scene.volumes[0].labels.as_mut().expect("set above");
            (0..=5).for_each(|value| labels.set_style(value, style(value)));
            row(look, what, &scene, Some(ms));
        };
        styled("five surfaces", &|value| LabelStyle {
            surface: Some(SurfaceReflection { strength: less(value, surface.strength), ..surface }),
            ..LabelStyle::default()
        });
        styled("five opacities", &|value| LabelStyle { opacity: less(value, 1.0), ..LabelStyle::default() });
    }
    for look in LOOKS {
        let mut boxed = Scene::with_volume(torso.clone(), look.medium(&torso));
        // The front half is taken off.
        boxed.volumes[0].clip_box[0].y = 0.5;
        let ms = row(look, "torso, half of it by a box", &boxed, None);
        let mut cut = Scene::with_volume(torso.clone(), look.medium(&torso));
        let half = torso.dims().map(|n| n as f64 / 2.0 - 0.5);
        let middle = torso.patient_from_voxel().transform_point3(DVec3::from_array(half));
        cut.volumes[0].clip_shapes = vec![ClipShape::plane(middle, DVec3::Y)];
        row(look, "cut open by a plane", &cut, Some(ms));
    }
    let found = segment(&head, silent, &never).expect("nobody cancels").labels;
    let depth = Arc::new(skin_depth(&head, &found, silent, &never).expect("nobody cancels"));
    let without = peel(Volume::clone(&head), &found, PEELED_MM, silent, &never).expect("nobody cancels");
    let without = Arc::new(without);
    for look in LOOKS {
        let plain = Scene::with_volume(without.clone(), look.medium(&head));
        let ms = row(look, "head without its skin", &plain, None);
        let mut peeled = Scene::with_volume(head.clone(), look.medium(&head));
        peeled.volumes[0].peel = Some(Peel { depth: depth.clone(), mm: PEELED_MM });
        row(look, "peeled live", &peeled, Some(ms));
    }
}

/// What a head without noise consists of, by its values: fat, soft tissue to the left and to the right, bone and its rind.
fn tissues(head: &Volume) -> LabelVolume {
    let [nx, ny, nz] = head.dims();
    let label = |at: usize| {
        let hu = head.value([at % nx, at / nx % ny, at / (nx * ny)]);
        match hu {
            ..-500.0 => 0,
            ..-20.0 => 1,
            ..150.0 => 2 + u8::from(at % nx > nx / 2),
            ..700.0 => 4,
            _ => 5,
        }
    };
    let names = ["fat", "left", "right", "bone", "rind"];
    let named = |(index, name): (usize, &&str)| Label {
        value: index as u8 + 1,
        name: (*name).to_owned(),
        color: [0.5; 3],
    };
    let voxels = (0..nx * ny * nz).map(label).collect();
    let names = names.iter().enumerate().map(named).collect();
    LabelVolume::new(head.dims(), voxels, head.patient_from_voxel(), names).expect("of the head's size")
}

/// Milliseconds of a sample of all pixels.
fn measure(gpu: &mut Gpu, scene: &Scene, [width, height]: [u32; 2]) -> f64 {
    let aspect = f64::from(width) / f64::from(height);
    let camera = framing::frame(scene, 25f64.to_radians(), 0.0, 28f64.to_radians(), aspect).camera();
    let mut run = |samples, time| {
        let request = RenderRequest::new(width, height, samples).with(|it| it.time = Some(time));
        render(gpu, scene, &camera, &request, &mut |_| ControlFlow::Continue(())).expect("a render")
    };
    // Kernels are made.
    run(1, LONGEST);
    run(SAMPLES, WARM_UP);
    let rendered = run(SAMPLES, LONGEST);
    if let Outcome::Failed(why) = &rendered.outcome {
        panic!("{why}");
    }
    let pixels = width as usize * height as usize;
    let samples =
        (0..pixels).map(|pixel| f64::from(rendered.film.samples(pixel))).sum::<f64>() / pixels as f64;
    rendered.trace.as_secs_f64() * 1e3 / samples
}
