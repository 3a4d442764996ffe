//! Scenes whose media depend on more than the value: labels, gradients, depth below the skin, clip shapes.

use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{
    ClipShape, Filter, GradientFunction, Label, LabelStyle, LabelVolume, Labelling, Medium, Modality, Peel,
    SurfaceReflection, TransferFunction, Volume, VolumeInstance, Voxels,
};

use super::{TestScene, flat, gradient_light, noise_volume, reflection, rotate_scale, scene, two_tissues};

/// Noise whose gradients reflect.
fn tissue(seed: u64) -> VolumeInstance {
    let medium = Medium {
        density_scale: 0.35,
        albedo: 0.9,
        surface: SurfaceReflection { gradient_per_mm: 60.0, ..reflection(0.6) },
        ..Medium::new(two_tissues())
    };
    VolumeInstance::centered(noise_volume(seed, [24; 3]), medium)
}

/// Blobs of ten labels on a turned grid of larger voxels, which the scan reaches beyond.
fn blobs(volume: &Volume) -> Arc<LabelVolume> {
    let dims = [11, 9, 10];
    let value = |i: usize| {
        let p = [i % 11, i / 11 % 9, i / 99].map(|x| x as f64 * 0.9);
        let sum = p[0].sin() + (p[1] * 1.3 + 1.0).cos() + (p[2] * 0.8).sin() * 1.4;
        ((sum + 3.4) / 6.8 * 10.0) as u8
    };
    let place = DAffine3::from_translation(volume.center_mm())
        * rotate_scale(0.6, DVec3::splat(1.7))
        * DAffine3::from_translation(DVec3::new(-5.0, -3.5, -4.0));
    let named =
        (1..10).map(|value| Label { value, name: format!("blob {value}"), color: [0.5; 3] }).collect();
    let voxels = (0..dims.iter().product()).map(value).collect();
    Arc::new(LabelVolume::new(dims, voxels, place, named).expect("values of 0 to 9"))
}

/// Labels that are hidden, painted, thin, dense, glossy, and of a function of their own.
pub fn labels() -> TestScene {
    let mut instance = tissue(19);
    let mut labelling = Labelling::new(blobs(&instance.volume));
    let gloss = SurfaceReflection { gradient_per_mm: 20.0, specular: 0.4, metallic: 0.8, ..reflection(0.2) };
    let styles = [
        LabelStyle { opacity: 0.7, ..Default::default() },
        LabelStyle::hidden(),
        LabelStyle { color: Some([0.2, 0.4, 0.9]), ..Default::default() },
        LabelStyle { density_scale: Some(0.8), surface: Some(SurfaceReflection::OFF), ..Default::default() },
        LabelStyle { surface: Some(gloss), ..Default::default() },
        LabelStyle { transfer_function: Some(flat([0.9, 0.8, 0.3])), opacity: 0.3, ..Default::default() },
    ];
    for (value, style) in [0, 3, 4, 5, 6, 7].into_iter().zip(styles) {
        labelling.set_style(value, style);
    }
    instance.labels = Some(labelling);
    scene("labels", vec![instance], gradient_light())
}

/// Labels that are painted, dull and glossy, and all as opaque as they were, cut by a plane and within a sphere: points are asked
/// for their labels where light collides alone.
pub fn painted() -> TestScene {
    let mut instance = tissue(37);
    let center = instance.volume.center_mm();
    let mut labelling = Labelling::new(blobs(&instance.volume));
    let gloss = SurfaceReflection { gradient_per_mm: 20.0, specular: 0.4, metallic: 0.8, ..reflection(0.2) };
    let styles = [
        LabelStyle { color: Some([0.2, 0.4, 0.9]), ..Default::default() },
        LabelStyle { surface: Some(SurfaceReflection::OFF), ..Default::default() },
        LabelStyle { surface: Some(gloss), ..Default::default() },
        LabelStyle { color: Some([0.9, 0.5, 0.2]), surface: Some(gloss), ..Default::default() },
    ];
    for (value, style) in [3, 4, 5, 6].into_iter().zip(styles) {
        labelling.set_style(value, style);
    }
    instance.labels = Some(labelling);
    instance.clip_shapes = vec![
        ClipShape::plane(center + DVec3::X * 4.0, DVec3::new(-1.0, 0.3, -0.2)),
        ClipShape::sphere(center, 11.0),
    ];
    scene("painted", vec![instance], gradient_light())
}

/// A scan without its outermost millimetres, cut by a plane, without a box and within a sphere, all turned; one label is
/// not cut. Beside it, a volume without any of that, which is read otherwise.
pub fn clip_shapes() -> TestScene {
    let mut instance = tissue(23);
    let center = instance.volume.center_mm();
    let place = DAffine3::from_translation(center - 12.0) * DAffine3::from_scale(DVec3::splat(2.4));
    let depth = |i: usize| {
        let p = DVec3::from_array([i % 11, i / 11 % 11, i / 121].map(|x| x as f64 - 5.0));
        (13.0 - 2.4 * p.length()).max(0.0) as f32
    };
    let depths = Voxels::F32((0..1331).map(depth).collect());
    let depth = Volume::new([11; 3], depths, [1.0, 0.0], place, Modality::Other).expect("finite depths");
    instance.peel = Some(Peel { depth: Arc::new(depth), mm: 2.0 });
    let mut labelling = Labelling::new(blobs(&instance.volume));
    labelling.set_style(5, LabelStyle { clipped: false, ..Default::default() });
    instance.labels = Some(labelling);
    let turned_box = ClipShape {
        patient_from_shape: DAffine3::from_translation(center + DVec3::new(2.0, -6.0, 5.0))
            * rotate_scale(0.8, DVec3::new(5.0, 7.0, 6.0)),
        ..ClipShape::aligned_box(DVec3::ZERO, DVec3::ONE)
    };
    let ellipsoid = ClipShape {
        patient_from_shape: DAffine3::from_translation(center)
            * rotate_scale(-0.4, DVec3::new(11.0, 10.0, 12.0)),
        ..ClipShape::sphere(DVec3::ZERO, 1.0)
    };
    instance.clip_shapes = vec![
        ClipShape::plane(center + DVec3::X * 4.0, DVec3::new(-1.0, 0.3, -0.2)),
        turned_box.invert(),
        ellipsoid,
    ];
    let mut other = tissue(29);
    other.medium.filter = Filter::Nearest;
    other.world_from_patient = DAffine3::from_translation(DVec3::new(0.014, 0.004, 0.0))
        * DAffine3::from_scale(DVec3::splat(0.4))
        * other.world_from_patient;
    scene("clip_shapes", vec![instance, other], gradient_light())
}

/// A function of value and gradient: other opacities and colours where values change.
pub fn gradients() -> TestScene {
    let mut instance = tissue(31);
    let steep = TransferFunction::from_points(
        lumivox_core::Ease::Linear,
        &[(-600.0, 0.9), (0.0, 0.2), (700.0, 0.6)],
        &[(-600.0, [0.2, 0.5, 0.9]), (700.0, [0.9, 0.3, 0.6])],
    )
    .expect("valid points");
    instance.medium.gradients = vec![
        GradientFunction { per_mm: 120.0, transfer_function: steep },
        GradientFunction { per_mm: 260.0, transfer_function: flat([0.4, 0.9, 0.4]) },
    ];
    scene("gradients", vec![instance], gradient_light())
}
