//! Small scenes that between them use everything an integrator can get wrong.
//!
//! Optical depths are moderate (one to four across), so that a few hundred samples are enough for a statistical test.
//! No sample lies exactly on a jump of its transfer function: there, f32 and f64 may rightly disagree.

mod classified;
mod grids;
mod lamps;

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DMat3, DQuat, DVec3};
use lumivox_core::{
    ColorStop, Ease, Environment, EnvironmentMap, EnvironmentSource, ExtinctionSpace, Filter, Medium,
    PerspectiveCamera, Scene, SurfaceReflection, TransferFunction, VolumeInstance, framing,
};

pub use classified::{clip_shapes, gradients, labels, painted};
pub use grids::noise_volume;
pub use lamps::{bulb_inside, bulbs, soft_sun, stage, sun};

use grids::{ball, fill};

/// A scene, a camera that sees it in a square image, and a name.
#[derive(Clone, Debug)]
pub struct TestScene {
    /// In snake case; fit for a file name.
    pub name: &'static str,
    /// What to render.
    pub scene: Scene,
    /// From where; meant for an aspect ratio of 1.
    pub camera: PerspectiveCamera,
}

/// Every test scene.
pub fn all() -> Vec<TestScene> {
    vec![
        homogeneous_cube(),
        homogeneous_sphere(),
        slab(),
        noise(),
        stretched_sphere(),
        overlapping_volumes(),
        crowd(),
        peaky_environment(),
        forward_scattering(),
        backward_scattering(),
        surface_reflection(),
        glossy_surface(),
        metallic_surface(),
        tricubic(),
        nearest(),
        smooth(),
        many_bricks(),
        camera_inside(),
        clip_box(),
        world_extinction(),
        tilted_gantry(),
        two_bounces(),
        sun(),
        soft_sun(),
        bulbs(),
        bulb_inside(),
        stage(),
        classified::labels(),
        classified::painted(),
        classified::clip_shapes(),
        classified::gradients(),
    ]
}

/// Four of them, for tests that are slow in each: volumes in one another, a light that is sampled, lamps and a sun, and what
/// is known by labels.
pub fn essential() -> Vec<TestScene> {
    vec![overlapping_volumes(), peaky_environment(), stage(), classified::labels()]
}

/// The same scene as a white furnace: nothing absorbs, unit light comes from everywhere and from no lamp, paths do not
/// end early. Every pixel's radiance is then its alpha.
#[must_use]
pub fn furnace(mut test: TestScene) -> TestScene {
    test.scene.environment = Environment::uniform(1.0);
    test.scene.lights.clear();
    for instance in &mut test.scene.volumes {
        let whiten = |function: &mut TransferFunction| {
            let white = vec![ColorStop { value: 0.0, color: [1.0; 3] }];
            *function = TransferFunction::new(function.opacity_knots().to_vec(), white).expect("valid knots");
        };
        for (_, style) in instance.labels.iter_mut().flat_map(|labelling| &mut labelling.styles) {
            style.transfer_function.iter_mut().for_each(whiten);
            style.color = None;
        }
        let medium = &mut instance.medium;
        whiten(&mut medium.transfer_function);
        medium.gradients.iter_mut().for_each(|row| whiten(&mut row.transfer_function));
        medium.albedo = 1.0;
        medium.max_bounces = 1000;
    }
    test
}

/// A white furnace whose paths are long and take many turns: a ball of dense grains that scatter forward and absorb
/// nothing, its majorants dozens of times the mean opacity.
pub fn dense_furnace() -> TestScene {
    let n = 64;
    let grains = fill([n; 3], DAffine3::IDENTITY, |p| {
        let is_grain = (p * n as f64).floor() % 3.0 == DVec3::ZERO;
        if is_grain && (p - 0.5).length() < 0.46 { 1.0 } else { 0.0 }
    });
    let medium = Medium { anisotropy: 0.8, density_scale: 40.0, ..soft_ball_medium() };
    furnace(scene("dense_furnace", vec![VolumeInstance::centered(grains.u16(), medium)], gradient_light()))
}

/// A cube of one value: 24 mm, optical depth 2.
pub fn homogeneous_cube() -> TestScene {
    let volume = fill([6; 3], DAffine3::from_scale(DVec3::splat(4.0)), |_| 1.0).u8();
    let medium = Medium { density_scale: 2.0 / 24.0, albedo: 0.9, ..Medium::new(flat([0.9, 0.8, 0.6])) };
    scene("homogeneous_cube", vec![VolumeInstance::centered(volume, medium)], gradient_light())
}

/// A sphere of one value with a soft edge, in the studio.
pub fn homogeneous_sphere() -> TestScene {
    let instance = VolumeInstance::centered(ball(24).u16(), Medium { albedo: 0.95, ..soft_ball_medium() });
    scene("homogeneous_sphere", vec![instance], Environment::default())
}

/// A plate of 40 x 4 x 40 mm of a single voxel, seen at a slant.
pub fn slab() -> TestScene {
    let place = DAffine3::from_scale(DVec3::new(40.0, 40.0, 4.0));
    let medium = Medium { density_scale: 0.25, albedo: 0.8, ..Medium::new(flat([1.0; 3])) };
    let instance = VolumeInstance::centered(fill([1; 3], place, |_| 1.0).u8(), medium);
    scene("slab", vec![instance], gradient_light())
}

/// Smooth noise of signed 16-bit values under a non-monotone transfer function.
pub fn noise() -> TestScene {
    let medium = Medium { density_scale: 0.35, albedo: 0.9, anisotropy: 0.3, ..Medium::new(two_tissues()) };
    let instance = VolumeInstance::centered(noise_volume(7, [28, 24, 20]), medium);
    scene("noise", vec![instance], Environment::default())
}

/// A sphere whose spacing, scale and rotation make it an ellipsoid, with its surface reflecting.
pub fn stretched_sphere() -> TestScene {
    let mut instance =
        VolumeInstance::centered(ball(24).spacing(DVec3::new(0.7, 1.0, 1.4)).f32(), glossy_ball());
    instance.world_from_patient = rotate_scale(0.5, DVec3::new(1.6, 0.8, 1.0)) * instance.world_from_patient;
    scene("stretched_sphere", vec![instance], gradient_light())
}

/// Two volumes through one another, rotated and scaled unevenly, each with its own look.
pub fn overlapping_volumes() -> TestScene {
    let medium = Medium { density_scale: 0.3, albedo: 0.8, anisotropy: 0.5, ..Medium::new(two_tissues()) };
    let mut a = VolumeInstance::centered(noise_volume(3, [20, 24, 22]), medium);
    a.world_from_patient = rotate_scale(0.7, DVec3::new(1.3, 0.8, 1.0)) * a.world_from_patient;
    let mut b = VolumeInstance::centered(
        ball(20).u8(),
        Medium { surface: reflection(0.4), albedo: 0.9, anisotropy: -0.3, ..soft_ball_medium() },
    );
    b.world_from_patient = DAffine3::from_translation(DVec3::new(0.006, 0.003, 0.004))
        * rotate_scale(-1.1, DVec3::new(0.9, 1.1, 0.6))
        * b.world_from_patient;
    scene("overlapping_volumes", vec![a, b], gradient_light())
}

/// Eleven small volumes of five shapes in no order, many through one another, some clipped; more than are asked one after
/// the other.
pub fn crowd() -> TestScene {
    let media = [two_tissues(), flat([0.9, 0.6, 0.4]), two_tissues()].map(|look| Medium {
        density_scale: 0.5,
        albedo: 0.85,
        anisotropy: 0.2,
        ..Medium::new(look)
    });
    let volumes = (0..11u32).map(|i| {
        let n = f64::from(i);
        let dims = [8 + (i % 3) as usize * 4, 10, 14 - (i % 5) as usize * 2];
        let mut instance =
            VolumeInstance::centered(noise_volume(u64::from(i % 5), dims), media[i as usize % 3].clone());
        let place = DVec3::new((5.0 * n).sin(), (3.0 * n).cos(), (7.0 * n).sin()) * 0.012;
        instance.world_from_patient = DAffine3::from_translation(place)
            * rotate_scale(n, DVec3::new(1.2, 0.7 + 0.1 * n, 1.0))
            * instance.world_from_patient;
        if i % 4 == 0 {
            instance.clip_box = [DVec3::new(0.2, 0.0, 0.1), DVec3::new(1.0, 0.6, 0.9)];
        }
        instance
    });
    scene("crowd", volumes.collect(), gradient_light())
}

/// Small suns near the zenith and the horizon: a light sampler that forgets the sine of the polar angle shows.
pub fn peaky_environment() -> TestScene {
    let instance = VolumeInstance::centered(ball(24).u16(), soft_ball_medium());
    scene("peaky_environment", vec![instance], two_suns())
}

/// Strong forward scattering.
pub fn forward_scattering() -> TestScene {
    let medium = Medium { anisotropy: 0.8, density_scale: 0.25, ..soft_ball_medium() };
    let instance = VolumeInstance::centered(ball(24).u16(), medium);
    scene(
        "forward_scattering",
        vec![instance],
        Environment { strength: 0.7, rotation: 2.0, ..Environment::default() },
    )
}

/// Backward scattering.
pub fn backward_scattering() -> TestScene {
    let instance =
        VolumeInstance::centered(ball(24).u16(), Medium { anisotropy: -0.6, ..soft_ball_medium() });
    scene("backward_scattering", vec![instance], Environment { rotation: 2.0, ..two_suns() })
}

/// Noise whose gradients reflect.
pub fn surface_reflection() -> TestScene {
    let medium = Medium {
        density_scale: 0.35,
        albedo: 0.9,
        surface: SurfaceReflection { gradient_per_mm: 60.0, ..reflection(0.7) },
        ..Medium::new(two_tissues())
    };
    let instance = VolumeInstance::centered(noise_volume(11, [24; 3]), medium);
    scene("surface_reflection", vec![instance], gradient_light())
}

/// A ball of strong, sharp gloss that reflects most of its light in the specular lobe.
pub fn glossy_surface() -> TestScene {
    let surface = SurfaceReflection { specular: 0.5, ..reflection(0.3) };
    let instance =
        VolumeInstance::centered(ball(24).u16(), Medium { surface, density_scale: 0.6, ..glossy_ball() });
    scene("glossy_surface", vec![instance], Environment::default())
}

/// Gloss of the medium's own colour, by which a path loses light in mirrors, too.
pub fn metallic_surface() -> TestScene {
    let medium = Medium {
        density_scale: 0.4,
        albedo: 0.8,
        surface: SurfaceReflection { gradient_per_mm: 60.0, specular: 0.6, metallic: 0.9, ..reflection(0.4) },
        ..Medium::new(two_tissues())
    };
    let instance = VolumeInstance::centered(noise_volume(29, [20; 3]), medium);
    scene("metallic_surface", vec![instance], gradient_light())
}

/// Coarse noise through the cubic B-spline.
pub fn tricubic() -> TestScene {
    filtered("tricubic", Filter::Tricubic, [9, 8, 10], DVec3::splat(2.5))
}

/// Coarse noise without interpolation.
pub fn nearest() -> TestScene {
    filtered("nearest", Filter::Nearest, [9, 8, 10], DVec3::splat(2.5))
}

/// Coarse noise of averaged voxels, along x as many as a renderer keeps together.
pub fn smooth() -> TestScene {
    filtered("smooth", Filter::Smooth, [32, 8, 10], DVec3::new(0.8, 2.5, 2.5))
}

/// Volumes of more voxels along each axis than a renderer keeps together, so that filters read across: one through the
/// cubic B-spline, and one without interpolation.
pub fn many_bricks() -> TestScene {
    let volume = noise_volume(7, [67, 40, 70]);
    let instance = |filter, x: f64| {
        let medium = Medium {
            filter,
            density_scale: 0.1,
            albedo: 0.9,
            surface: SurfaceReflection { gradient_per_mm: 10.0, ..reflection(0.6) },
            ..Medium::new(two_tissues())
        };
        let mut instance = VolumeInstance::centered(volume.clone(), medium);
        instance.world_from_patient = DAffine3::from_translation(DVec3::X * x)
            * DAffine3::from_scale(DVec3::splat(0.35))
            * instance.world_from_patient;
        instance
    };
    let volumes = vec![instance(Filter::Tricubic, -0.006), instance(Filter::Nearest, 0.006)];
    scene("many_bricks", volumes, gradient_light())
}

fn filtered(name: &'static str, filter: Filter, dims: [usize; 3], stretch: DVec3) -> TestScene {
    let medium = Medium {
        filter,
        density_scale: 0.3,
        albedo: 0.9,
        surface: SurfaceReflection { gradient_per_mm: 60.0, ..reflection(0.6) },
        ..Medium::new(two_tissues())
    };
    let mut instance = VolumeInstance::centered(noise_volume(5, dims), medium);
    instance.world_from_patient = DAffine3::from_scale(stretch) * instance.world_from_patient;
    instance.medium.density_scale *= 2.5;
    scene(name, vec![instance], gradient_light())
}

/// A camera within the medium.
pub fn camera_inside() -> TestScene {
    let mut test = noise();
    test.name = "camera_inside";
    let eye = DVec3::new(0.002, 0.001, 0.003);
    test.camera = PerspectiveCamera::look_at(eye, DVec3::new(-0.01, 0.002, -0.02), DVec3::Y, 1.2);
    test
}

/// A volume cut open.
pub fn clip_box() -> TestScene {
    let mut test = noise();
    test.name = "clip_box";
    // The box's y runs to the patient's back: what is cut away faces the camera.
    test.scene.volumes[0].clip_box = [DVec3::new(0.15, 0.4, 0.0), DVec3::new(1.0, 1.0, 0.85)];
    test
}

/// Extinction measured in the world, of a volume stretched unevenly.
pub fn world_extinction() -> TestScene {
    let mut test = stretched_sphere();
    test.name = "world_extinction";
    test.scene.volumes[0].medium.extinction_space = ExtinctionSpace::World;
    test
}

/// A sheared, mirrored grid, as a tilted gantry or a flipped series has.
pub fn tilted_gantry() -> TestScene {
    let shear =
        DMat3::from_cols(DVec3::new(-1.0, 0.0, 0.0), DVec3::new(0.0, 1.1, 0.0), DVec3::new(0.1, 0.6, 1.3));
    let medium = Medium { surface: reflection(0.5), albedo: 0.9, anisotropy: 0.4, ..soft_ball_medium() };
    let volume =
        ball(20).placed(DAffine3::from_mat3_translation(shear, DVec3::new(50.0, -30.0, 200.0))).f32();
    let mut instance = VolumeInstance::centered(volume, medium);
    instance.world_from_patient = rotate_scale(0.4, DVec3::ONE) * instance.world_from_patient;
    scene("tilted_gantry", vec![instance], gradient_light())
}

/// Paths that end at their third collision, in a dense, colourful ball.
pub fn two_bounces() -> TestScene {
    let medium = Medium { max_bounces: 2, density_scale: 0.5, albedo: 1.0, ..soft_ball_medium() };
    let instance = VolumeInstance::centered(ball(24).u8(), medium);
    scene("two_bounces", vec![instance], Environment::default())
}

/// Light from a blue zenith, a white horizon and a dim red nadir.
pub fn gradient_light() -> Environment {
    Environment {
        source: EnvironmentSource::Gradient {
            zenith: [0.6, 1.0, 2.0],
            horizon: [0.8, 0.8, 0.8],
            nadir: [0.3, 0.1, 0.05],
        },
        rotation: 0.0,
        strength: 1.0,
    }
}

/// A dim gradient with two suns of 9 degrees' radius: one 15 degrees from the zenith, one just above the horizon.
pub fn two_suns() -> Environment {
    let sun = |azimuth: f64, elevation: f64| {
        DVec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos())
    };
    let suns = [(sun(0.7, FRAC_PI_2 - PI / 12.0), [30.0, 28.0, 22.0]), (sun(-0.9, 0.1), [30.0, 16.0, 8.0])];
    let map = EnvironmentMap::from_fn(128, 64, |d| {
        let sky = 0.1 + 0.1 * d.y;
        suns.iter()
            .find(|(center, _)| d.dot(*center) > (PI / 20.0).cos())
            .map_or([sky, sky, 1.5 * sky], |(_, radiance)| *radiance)
    });
    Environment { source: EnvironmentSource::Map(Arc::new(map)), rotation: 0.0, strength: 1.0 }
}

/// Two ranges of values that show, with a gap between and a jump: a range of values has its maximum inside.
fn two_tissues() -> TransferFunction {
    TransferFunction::from_points(
        Ease::InOut,
        &[(-400.0, 0.0), (-150.0, 0.8), (50.0, 0.05), (300.0, 0.1), (300.5, 0.6), (600.0, 1.0)],
        &[(-400.0, [0.9, 0.4, 0.3]), (0.0, [0.95, 0.8, 0.5]), (500.0, [0.9, 0.95, 1.0])],
    )
    .expect("valid points")
}

/// Full opacity and one colour at every value.
fn flat(color: [f64; 3]) -> TransferFunction {
    TransferFunction::from_points(Ease::Linear, &[(0.0, 1.0)], &[(0.0, color)]).expect("valid points")
}

/// A ball's look: clear outside, optical depth about 3 through its middle.
fn soft_ball_medium() -> Medium {
    let tf = TransferFunction::from_points(
        Ease::Linear,
        &[(0.3, 0.0), (0.7, 1.0)],
        &[(0.0, [0.9, 0.5, 0.4]), (1.0, [0.9, 0.9, 0.7])],
    )
    .expect("valid points");
    Medium { density_scale: 0.18, ..Medium::new(tf) }
}

fn glossy_ball() -> Medium {
    Medium { surface: reflection(0.5), anisotropy: 0.2, albedo: 0.9, ..soft_ball_medium() }
}

/// Reflection for values that change by about 0.2 per mm.
fn reflection(roughness: f64) -> SurfaceReflection {
    SurfaceReflection { strength: 0.9, gradient_per_mm: 0.15, roughness, specular: 0.1, metallic: 0.0 }
}

/// Turns around a slanted axis and scales along the world's axes before.
fn rotate_scale(angle: f64, scale: DVec3) -> DAffine3 {
    let axis = DVec3::new(1.0, 2.0, -0.5).normalize();
    DAffine3::from_scale_rotation_translation(scale, DQuat::from_axis_angle(axis, angle), DVec3::ZERO)
}

fn scene(name: &'static str, volumes: Vec<VolumeInstance>, environment: Environment) -> TestScene {
    let scene = Scene { volumes, environment, ..Default::default() };
    let camera = framing::frame(&scene, 0.5, 0.3, 0.6, 1.0).camera();
    TestScene { name, scene, camera }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn names_are_unique_and_fit_for_files() {
        let names: HashSet<_> = all().iter().map(|t| t.name).collect();
        assert_eq!(names.len(), all().len());
        assert!(names.iter().all(|n| n.chars().all(|c| c.is_ascii_lowercase() || c == '_')));
    }

    #[test]
    fn scenes_are_the_same_every_time_and_cover_every_option() {
        let scenes = all();
        let instances: Vec<&VolumeInstance> = scenes.iter().flat_map(|t| &t.scene.volumes).collect();
        for filter in [Filter::Nearest, Filter::Trilinear, Filter::Tricubic, Filter::Smooth] {
            assert!(instances.iter().any(|i| i.medium.filter == filter));
        }
        for bytes in [1, 2, 4] {
            assert!(instances.iter().any(|i| i.volume.voxels().bytes_per_sample() == bytes));
        }
        assert!(instances.iter().any(|i| i.medium.extinction_space == ExtinctionSpace::World));
        assert!(instances.iter().any(|i| i.world_from_box().matrix3.determinant() < 0.0));
        assert_eq!(noise_volume(1, [8; 3]).voxels(), noise_volume(1, [8; 3]).voxels());
        assert_ne!(noise_volume(1, [8; 3]).voxels(), noise_volume(2, [8; 3]).voxels());
    }
}
