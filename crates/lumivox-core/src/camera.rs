//! A pinhole camera, and an orbit around something worth seeing.

use glam::{DAffine3, DMat3, DVec3};

/// A half-line `origin + t * direction`, `t >= 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Where it goes; of unit length.
    pub direction: DVec3,
}

/// A perspective camera in world space. It looks along its -z axis, +y up, like a game engine's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerspectiveCamera {
    /// World from camera: a rigid transform.
    pub world_from_camera: DAffine3,
    /// Angle between the bottom and the top edge of the image, in radians.
    pub vertical_fov: f64,
}

impl PerspectiveCamera {
    /// A camera at `eye` that looks at `target`, with `up` upwards in the image. Where `up` is parallel to the view,
    /// another axis takes its place.
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, vertical_fov: f64) -> Self {
        let back = (eye - target).try_normalize().unwrap_or(DVec3::Z);
        let right = up.cross(back).try_normalize().unwrap_or_else(|| back.any_orthonormal_vector());
        let rotation = DMat3::from_cols(right, back.cross(right), back);
        Self { world_from_camera: DAffine3::from_mat3_translation(rotation, eye), vertical_fov }
    }

    /// The world ray through a point of the image, `(0, 0)` its top left and `(1, 1)` its bottom right corner.
    pub fn ray(&self, [u, v]: [f64; 2], aspect: f64) -> Ray {
        let half = (self.vertical_fov / 2.0).tan();
        let direction = DVec3::new((2.0 * u - 1.0) * half * aspect, (1.0 - 2.0 * v) * half, -1.0);
        Ray {
            origin: self.world_from_camera.translation,
            direction: self.world_from_camera.transform_vector3(direction).normalize(),
        }
    }
}

/// A camera placed by angles around a target, as people turn an object in their hands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// The point looked at, in world metres.
    pub target: DVec3,
    /// Angle around the vertical axis in radians; 0 looks from +z, positive turns the camera to +x.
    pub azimuth: f64,
    /// Angle above the horizon in radians.
    pub elevation: f64,
    /// Distance from the target in metres.
    pub distance: f64,
    /// Angle between the bottom and the top edge of the image, in radians.
    pub vertical_fov: f64,
}

impl Orbit {
    /// The camera of this orbit.
    pub fn camera(&self) -> PerspectiveCamera {
        let (sin_a, cos_a) = self.azimuth.sin_cos();
        let (sin_e, cos_e) = self.elevation.sin_cos();
        let out = DVec3::new(sin_a * cos_e, sin_e, cos_a * cos_e);
        // Straight above or below, the head of the image is where a smaller elevation would have had it.
        let up = DVec3::new(-sin_a * sin_e, cos_e, -cos_a * sin_e);
        let eye = self.target + out * self.distance;
        PerspectiveCamera::look_at(eye, self.target, up, self.vertical_fov)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centre_of_the_image_is_the_target_and_up_is_up() {
        let camera = PerspectiveCamera::look_at(DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO, DVec3::Y, 0.7);
        let centre = camera.ray([0.5, 0.5], 1.5);
        assert!(centre.direction.distance(-DVec3::new(1.0, 2.0, 3.0).normalize()) < 1e-12);
        assert!(camera.ray([0.5, 0.0], 1.5).direction.y > centre.direction.y);
        let top = camera.ray([0.5, 0.0], 1.5).direction.angle_between(camera.ray([0.5, 1.0], 1.5).direction);
        assert!((top - 0.7).abs() < 1e-12);
    }

    #[test]
    fn an_orbit_at_azimuth_zero_sees_the_left_of_the_patient_on_the_right() {
        let orbit =
            Orbit { target: DVec3::ZERO, azimuth: 0.0, elevation: 0.0, distance: 1.0, vertical_fov: 0.7 };
        assert!(orbit.camera().ray([1.0, 0.5], 1.0).direction.x > 0.0);
        let above = Orbit { elevation: std::f64::consts::FRAC_PI_2, ..orbit }.camera();
        assert!(above.world_from_camera.matrix3.is_finite());
        assert!(above.ray([0.5, 0.0], 1.0).direction.z < 0.0, "up in the image is away from the viewer");
    }
}
