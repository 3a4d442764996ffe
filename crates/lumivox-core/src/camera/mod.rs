//! Pinhole and parallel cameras, those that hosts describe by matrices, and an orbit around something worth seeing.

mod host;

use glam::{DAffine3, DMat3, DVec3};

pub use self::host::HostCamera;

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

/// What a camera's image plane spans. Where bottom is above top, the image's rows run upwards, as some engines keep them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Rays start at one point. Edges of the image at distance 1 along the view: left, right, bottom, top; not
    /// symmetric for the eyes of a headset.
    Perspective {
        /// Left, right, bottom, top.
        tangents: [f64; 4],
    },
    /// Rays are parallel. Edges of the image in metres: left, right, bottom, top.
    Orthographic {
        /// Left, right, bottom, top.
        extents: [f64; 4],
    },
}

/// A camera of a host, whatever its projection. It looks along its -z axis, +y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// World from camera: a rigid transform.
    pub world_from_camera: DAffine3,
    /// What its image plane spans.
    pub projection: Projection,
}

impl PerspectiveCamera {
    /// The same camera for images of one shape; `aspect` is width over height.
    pub fn with_aspect(&self, aspect: f64) -> Camera {
        let half = (self.vertical_fov / 2.0).tan();
        let tangents = [-half * aspect, half * aspect, -half, half];
        Camera { world_from_camera: self.world_from_camera, projection: Projection::Perspective { tangents } }
    }
}

impl Camera {
    /// The world ray through a point of the image, `(0, 0)` its top left and `(1, 1)` its bottom right corner.
    pub fn ray(&self, [u, v]: [f64; 2]) -> Ray {
        let at = |[left, right, bottom, top]: [f64; 4]| {
            DVec3::new(left + u * (right - left), top + v * (bottom - top), 0.0)
        };
        let (origin, direction) = match self.projection {
            Projection::Perspective { tangents } => (DVec3::ZERO, at(tangents) + DVec3::NEG_Z),
            Projection::Orthographic { extents } => (at(extents), DVec3::NEG_Z),
        };
        Ray {
            origin: self.world_from_camera.transform_point3(origin),
            direction: self.world_from_camera.transform_vector3(direction).normalize(),
        }
    }

    /// Whether it sees anything at all: every number finite, edges in order.
    pub fn is_valid(&self) -> bool {
        let (Projection::Perspective { tangents: edges } | Projection::Orthographic { extents: edges }) =
            self.projection;
        let [left, right, bottom, top] = edges;
        self.world_from_camera.is_finite()
            && edges.iter().all(|e| e.is_finite())
            && left < right
            && bottom != top
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
    fn a_camera_of_a_shape_sees_the_same_rays() {
        let camera = PerspectiveCamera::look_at(DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO, DVec3::Y, 0.7);
        for uv in [[0.0, 0.0], [0.3, 0.9], [1.0, 0.5]] {
            let (a, b) = (camera.ray(uv, 1.5), camera.with_aspect(1.5).ray(uv));
            assert!(a.direction.distance(b.direction) < 1e-12 && a.origin == b.origin);
        }
        let parallel = Camera {
            projection: Projection::Orthographic { extents: [-1.0, 3.0, -1.0, 1.0] },
            ..camera.with_aspect(1.0)
        };
        let (a, b) = (parallel.ray([0.0, 0.5]), parallel.ray([1.0, 0.5]));
        assert_eq!(a.direction, b.direction);
        assert!((a.origin.distance(b.origin) - 4.0).abs() < 1e-12);
        assert!(parallel.is_valid());
        let flat =
            Camera { projection: Projection::Orthographic { extents: [0.0, 0.0, -1.0, 1.0] }, ..parallel };
        assert!(!flat.is_valid());
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
