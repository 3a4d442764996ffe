//! From Unity's left-handed world to Lumivox' right-handed one: z is mirrored, in worlds and in objects.

use lumivox_core::SurfaceReflection;
use lumivox_core::glam::{DAffine3, DMat3, DMat4, DVec3};

use crate::abi::LumivoxSurface;

/// A point or a direction, either way.
pub fn mirrored(v: DVec3) -> DVec3 {
    DVec3::new(v.x, v.y, -v.z)
}

/// A point or a direction of Unity's.
pub fn vector(v: [f32; 3]) -> DVec3 {
    mirrored(wide(v))
}

/// Three numbers that are no place: clip coordinates.
pub fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// For a struct of the border.
pub fn narrow(v: DVec3) -> [f32; 3] {
    v.to_array().map(|x| x as f32)
}

/// A colour.
pub fn color(c: [f32; 3]) -> [f64; 3] {
    c.map(f64::from)
}

/// A matrix as it lies in memory.
pub fn matrix(m: &[f32; 16]) -> DMat4 {
    DMat4::from_cols_array(&m.map(f64::from))
}

fn affine(m: &[f32; 16]) -> DAffine3 {
    DAffine3::from_mat4(matrix(m))
}

fn mirror() -> DAffine3 {
    DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0)))
}

/// World from object: both are mirrored.
pub fn world_from_object(m: &[f32; 16]) -> DAffine3 {
    mirror() * affine(m) * mirror()
}

/// World from camera: Unity's cameras look along their -z, in coordinates that are right-handed already.
pub fn world_from_camera(m: &[f32; 16]) -> DAffine3 {
    mirror() * affine(m)
}

/// Coordinates of Unity's object from Lumivox' by any map into the latter.
pub fn object_from(m: DAffine3) -> [f32; 16] {
    let m = DMat4::from(mirror() * m);
    m.to_cols_array().map(|x| x as f32)
}

/// A surface as C# has it.
pub fn surface(of: SurfaceReflection) -> LumivoxSurface {
    let SurfaceReflection { strength, gradient_per_mm, roughness, specular, metallic } = of;
    let [strength, gradient, roughness, specular, metallic] =
        [strength, gradient_per_mm, roughness, specular, metallic].map(|x| x as f32);
    LumivoxSurface { strength, gradient, roughness, specular, metallic }
}

/// The surface that C# describes. Its gradient is 0 where that is left open.
pub fn reflection(of: &LumivoxSurface) -> SurfaceReflection {
    let LumivoxSurface { strength, gradient, roughness, specular, metallic } = *of;
    let [strength, gradient_per_mm, roughness, specular, metallic] =
        [strength, gradient.max(0.0), roughness, specular, metallic].map(f64::from);
    SurfaceReflection { strength, gradient_per_mm, roughness, specular, metallic }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `Matrix4x4.TRS` of a turn about y: Unity turns +z to +x.
    fn turned(degrees: f32, place: [f32; 3]) -> [f32; 16] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let [x, y, z] = place;
        [cos, 0.0, -sin, 0.0, 0.0, 1.0, 0.0, 0.0, sin, 0.0, cos, 0.0, x, y, z, 1.0]
    }

    #[test]
    fn a_point_keeps_its_place_seen_from_either_world() {
        let unity = turned(30.0, [1.0, 2.0, 3.0]);
        let point = DVec3::new(0.1, 0.2, 0.3);
        let in_unity = affine(&unity).transform_point3(point);
        let in_lumivox = world_from_object(&unity).transform_point3(mirrored(point));
        assert!(mirrored(in_unity).distance(in_lumivox) < 1e-6);
        assert!(world_from_object(&unity).matrix3.determinant() > 0.0);
    }

    #[test]
    fn a_camera_that_unity_has_look_along_z_looks_there() {
        // A transform without a turn looks along +z; its cameraToWorldMatrix mirrors z for that.
        let mut camera_to_world = turned(0.0, [0.0, 1.0, -10.0]);
        camera_to_world[10] = -1.0;
        let camera = world_from_camera(&camera_to_world);
        let ahead = camera.transform_vector3(DVec3::NEG_Z);
        assert!(mirrored(ahead).distance(DVec3::Z) < 1e-12);
        assert!(camera.matrix3.determinant() > 0.0);
        assert_eq!(camera.translation, DVec3::new(0.0, 1.0, 10.0));
    }
}
