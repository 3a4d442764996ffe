//! Shapes that cut volumes open, from Unity's objects to the scan's millimetres.

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{ClipKind, ClipShape};

use crate::abi::LumivoxClipShape;
use crate::convert;

/// A shape for a volume whose millimetres are those of the patient.
pub(crate) fn clip_shape(clip: &LumivoxClipShape, world_from_patient: DAffine3) -> ClipShape {
    let half_metre = || DAffine3::from_scale(DVec3::splat(0.5));
    let (kind, object_from_shape) = match clip.kind {
        // Its z is the object's y.
        0 => (ClipKind::Plane, DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2)),
        1 => (ClipKind::Box, half_metre()),
        _ => (ClipKind::Sphere, half_metre()),
    };
    let patient_from_object =
        world_from_patient.inverse() * convert::world_from_object(&clip.world_from_shape);
    ClipShape {
        kind,
        patient_from_shape: patient_from_object * object_from_shape,
        inverted: clip.inverted != 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lumivox_core::glam::{DMat4, DQuat};

    #[test]
    fn shapes_keep_what_lies_on_their_side_in_unity() {
        // Unity's matrices, and a scan that stands somewhere.
        let turned = DAffine3::from_scale_rotation_translation(
            DVec3::new(0.2, 0.5, 0.1),
            DQuat::from_rotation_z(0.7),
            DVec3::X,
        );
        let world_from_shape = DMat4::from(turned).to_cols_array().map(|x| x as f32);
        let world_from_patient = DAffine3::from_scale_rotation_translation(
            DVec3::splat(1e-3),
            DQuat::from_rotation_x(1.2),
            DVec3::new(0.3, -0.1, 0.2),
        );
        let keeps = |kind, inverted, point: DVec3| {
            let clip = LumivoxClipShape { world_from_shape, kind, inverted };
            let shape = clip_shape(&clip, world_from_patient);
            // A point of the object's, seen from Lumivox' world, in the patient.
            let in_world = convert::mirrored(turned.transform_point3(point));
            let at = shape.patient_from_shape.inverse() * world_from_patient.inverse();
            let at = at.transform_point3(in_world);
            let inside = match shape.kind {
                ClipKind::Plane => at.z >= 0.0,
                ClipKind::Box => at.abs().max_element() <= 1.0,
                ClipKind::Sphere => at.length() <= 1.0,
            };
            inside != shape.inverted
        };
        let (above, beside) = (DVec3::new(0.3, 0.1, -0.4), DVec3::new(-0.4, -0.1, 0.45));
        assert!(keeps(0, 0, above) && !keeps(0, 0, beside) && keeps(0, 1, beside));
        assert!(keeps(1, 0, beside) && !keeps(1, 0, DVec3::Z * 0.51) && keeps(1, 1, DVec3::Z * 0.51));
        assert!(keeps(2, 0, DVec3::Z * 0.49) && !keeps(2, 0, beside));
    }
}
