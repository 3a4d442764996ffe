//! Where objects of Unity's stand so that volumes, shapes, lights and cameras stand where a scene has them: the way back from
//! what `convert` and `clips` do, as a place, a turn and a scale.

use lumivox_core::glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use lumivox_core::{ClipKind, ClipShape, Volume, VolumeInstance, placement};

use crate::abi::LumivoxPose;
use crate::convert;

/// An object's place, turn and scale, in Unity's left-handed world or in its parent's object.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    position: DVec3,
    rotation: DQuat,
    scale: DVec3,
}

impl Pose {
    /// Of an object's matrix; `None` where its axes are not at right angles, or it has no extent.
    pub fn of(matrix: DAffine3) -> Option<Self> {
        /// What is left of a right angle's cosine after a few roundings of 32 bits.
        const SLANTED: f64 = 1e-4;
        let axes = matrix.matrix3;
        let mut scale = DVec3::new(axes.x_axis.length(), axes.y_axis.length(), axes.z_axis.length());
        if axes.determinant() < 0.0 {
            scale.x = -scale.x;
        }
        let turn = DMat3::from_cols(axes.x_axis / scale.x, axes.y_axis / scale.y, axes.z_axis / scale.z);
        let is_turn = turn.is_finite() && (turn * turn.transpose()).abs_diff_eq(DMat3::IDENTITY, SLANTED);
        is_turn.then(|| Self { position: matrix.translation, rotation: DQuat::from_mat3(&turn), scale })
    }

    /// At a place of Unity's, its +z along a direction.
    pub fn towards(position: DVec3, direction: DVec3) -> Self {
        let forward = direction.try_normalize().unwrap_or(DVec3::Z);
        Self { position, rotation: DQuat::from_rotation_arc(DVec3::Z, forward), scale: DVec3::ONE }
    }

    /// Of a camera's object, which looks along its +z.
    pub fn of_camera(world_from_camera: DAffine3) -> Self {
        let turn = mirror() * world_from_camera.matrix3 * mirror();
        Self {
            position: convert::mirrored(world_from_camera.translation),
            rotation: DQuat::from_mat3(&turn),
            scale: DVec3::ONE,
        }
    }

    /// For a struct of the border. What is left of roundings is nothing.
    pub fn narrow(&self) -> LumivoxPose {
        let plain = |x: f64| if x.abs() < 1e-9 { 0.0 } else { x as f32 };
        LumivoxPose {
            position: self.position.to_array().map(plain),
            rotation: self.rotation.to_array().map(plain),
            scale: self.scale.to_array().map(plain),
        }
    }

    /// As `Matrix4x4` has it.
    pub fn matrix(&self) -> [f32; 16] {
        matrix(DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.position))
    }
}

fn mirror() -> DMat3 {
    DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0))
}

/// A matrix of Lumivox' as the same in Unity's objects.
fn in_unity(matrix: DAffine3) -> DAffine3 {
    DAffine3::from_mat3(mirror()) * matrix * DAffine3::from_mat3(mirror())
}

/// As `Matrix4x4` lies in memory.
pub fn matrix(affine: DAffine3) -> [f32; 16] {
    DMat4::from(affine).to_cols_array().map(|x| x as f32)
}

/// The matrix of the object of Unity's whose scan stands where an instance's does.
pub fn object_from_node(instance: &VolumeInstance) -> DAffine3 {
    let patient_from_node = placement::node_from_patient(&instance.volume).inverse();
    in_unity(instance.world_from_patient * patient_from_node)
}

/// A clip shape in the object of its volume: see `clips`.
pub fn of_clip(shape: &ClipShape, volume: &Volume) -> Option<Pose> {
    let node_from_shape = placement::node_from_patient(volume) * shape.patient_from_shape;
    if shape.kind != ClipKind::Plane {
        // Unity's are half as large.
        return Pose::of(in_unity(node_from_shape * DAffine3::from_scale(DVec3::splat(2.0))));
    }
    // Of a plane all but its place and the side that it keeps is nothing.
    let normal = (node_from_shape.matrix3.inverse().transpose() * DVec3::Z).try_normalize()?;
    Some(Pose {
        position: convert::mirrored(node_from_shape.translation),
        rotation: DQuat::from_rotation_arc(DVec3::Y, convert::mirrored(normal)),
        scale: DVec3::ONE,
    })
}

/// The number that the border has for a kind of shape.
pub fn clip_kind(kind: ClipKind) -> u32 {
    match kind {
        ClipKind::Plane => 0,
        ClipKind::Box => 1,
        ClipKind::Sphere => 2,
    }
}

/// The corners of what is kept of an instance, along its object's axes.
pub fn clip_corners(instance: &VolumeInstance) -> [[f32; 3]; 2] {
    let [low, high] = instance.clip_box;
    let (mut min, mut max) = (DVec3::ZERO, DVec3::ONE);
    for (node, (axis, reversed)) in placement::box_axes(&instance.volume).into_iter().enumerate() {
        let (a, b) = (low[axis], high[axis]);
        (min[node], max[node]) = if reversed { (1.0 - b, 1.0 - a) } else { (a, b) };
    }
    // Mirrored, as the object is.
    (min.z, max.z) = (1.0 - max.z, 1.0 - min.z);
    [convert::narrow(min), convert::narrow(max)]
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use lumivox_core::{Medium, Modality, Preset, Voxels};

    use super::*;
    use crate::abi::LumivoxClipShape;
    use crate::clips::clip_shape;

    fn instance(world_from_patient: DAffine3) -> VolumeInstance {
        let place = DAffine3::from_mat3_translation(
            DMat3::from_diagonal(DVec3::new(2.0, 3.0, 4.0)),
            DVec3::new(7.0, -3.0, 90.0),
        );
        let volume = Volume::new([4, 5, 6], Voxels::U8(vec![0; 120]), [1.0, 0.0], place, Modality::Ct);
        let volume = Arc::new(volume.unwrap());
        let medium: Medium = Preset::CtBone.medium(&volume);
        VolumeInstance::new(volume, medium, world_from_patient)
    }

    fn turned() -> DAffine3 {
        DAffine3::from_scale_rotation_translation(
            DVec3::splat(1.5),
            DQuat::from_euler(lumivox_core::glam::EulerRot::YXZ, 0.4, -0.3, 0.2),
            DVec3::new(0.1, 0.2, -0.3),
        )
    }

    fn recomposed(pose: &LumivoxPose) -> [f32; 16] {
        let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let rotation = DQuat::from_array(pose.rotation.map(f64::from));
        matrix(DAffine3::from_scale_rotation_translation(wide(pose.scale), rotation, wide(pose.position)))
    }

    #[test]
    fn a_scan_without_a_place_stands_at_the_origin_to_the_bit() {
        let mut instance = instance(DAffine3::IDENTITY);
        instance.world_from_patient = placement::node_from_patient(&instance.volume);
        let pose = Pose::of(object_from_node(&instance)).unwrap().narrow();
        assert_eq!((pose.position, pose.rotation, pose.scale), ([0.0; 3], [0.0, 0.0, 0.0, 1.0], [1.0; 3]));
    }

    #[test]
    fn a_scan_stands_where_the_scene_has_it() {
        let of = instance(DAffine3::IDENTITY);
        let instance = instance(turned() * placement::node_from_patient(&of.volume));
        let pose = Pose::of(object_from_node(&instance)).unwrap().narrow();
        let again =
            convert::world_from_object(&recomposed(&pose)) * placement::node_from_patient(&instance.volume);
        assert!(again.abs_diff_eq(instance.world_from_patient, 1e-6), "{again} {pose:?}");
    }

    #[test]
    fn a_mirrored_scan_has_a_scale_below_zero_and_a_slanted_one_no_pose() {
        let mirrored = DAffine3::from_scale(DVec3::new(1.0, -2.0, 1.0));
        let pose = Pose::of(mirrored).unwrap();
        assert!(matrix(mirrored).iter().zip(pose.matrix()).all(|(a, b)| (a - b).abs() < 1e-6));
        let slanted = DMat3::from_cols(DVec3::X, DVec3::new(0.3, 1.0, 0.0), DVec3::Z);
        assert!(Pose::of(DAffine3::from_mat3(slanted)).is_none());
        assert!(Pose::of(DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))).is_none());
    }

    #[test]
    fn shapes_come_back_as_they_were() {
        let of = instance(DAffine3::IDENTITY);
        let world_from_patient = placement::node_from_patient(&of.volume);
        for kind in [ClipKind::Plane, ClipKind::Box, ClipKind::Sphere] {
            let scale = if kind == ClipKind::Plane { DVec3::ONE } else { DVec3::new(0.1, 0.2, 0.3) };
            let patient_from_shape = world_from_patient.inverse() * turned() * DAffine3::from_scale(scale);
            let shape = ClipShape { kind, patient_from_shape, inverted: true };
            let pose = of_clip(&shape, &of.volume).unwrap().narrow();
            let clip =
                LumivoxClipShape { world_from_shape: recomposed(&pose), kind: clip_kind(kind), inverted: 1 };
            let again = clip_shape(&clip, world_from_patient);
            assert_eq!((again.kind, again.inverted), (kind, true));
            let [a, b] = [shape, again].map(|shape| shape.patient_from_shape);
            if kind == ClipKind::Plane {
                let normal = |m: DAffine3| (m.matrix3.inverse().transpose() * DVec3::Z).normalize();
                assert!(normal(a).distance(normal(b)) < 1e-6);
                assert!(normal(a).dot(a.translation - b.translation).abs() < 1e-3);
            } else {
                assert!(a.abs_diff_eq(b, 1e-3), "{a} {b}");
            }
        }
    }

    #[test]
    fn what_is_kept_is_told_along_the_objects_axes() {
        let mut instance = instance(DAffine3::IDENTITY);
        instance.clip_box = [DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.6, 0.7, 0.8)];
        let [a, b] = clip_corners(&instance).map(convert::wide);
        let [a, b] = [a, b].map(|corner| DVec3::new(corner.x, corner.y, 1.0 - corner.z));
        let [low, high] = placement::clip_box(&instance.volume, a, b);
        assert!(low.distance(instance.clip_box[0]) < 1e-6 && high.distance(instance.clip_box[1]) < 1e-6);
    }

    #[test]
    fn a_camera_looks_the_same_way() {
        let camera = turned();
        let camera = DAffine3::from_rotation_translation(
            DQuat::from_mat3(&(camera.matrix3 * (1.0 / 1.5))),
            camera.translation,
        );
        let pose = Pose::of_camera(camera);
        // Unity mirrors z of a camera's object for its matrix.
        let object = DAffine3::from_rotation_translation(pose.rotation, pose.position);
        let camera_to_world = matrix(object * DAffine3::from_mat3(mirror()));
        assert!(convert::world_from_camera(&camera_to_world).abs_diff_eq(camera, 1e-6));
    }
}
