//! Functions that give the same to the last bit on every system. Those of `std` are the system's own, and round otherwise from
//! one to the next: a voxel at the edge of an organ would be bone here and fat there. `clippy.toml` keeps them out of this
//! crate. What the processor computes itself, a square root too, is rounded alike everywhere.

use glam::{DMat3, DVec3, Mat3, Vec3};

pub(crate) fn sin(x: f32) -> f32 {
    libm::sinf(x)
}

pub(crate) fn cos(x: f32) -> f32 {
    libm::cosf(x)
}

pub(crate) fn asin(x: f32) -> f32 {
    libm::asinf(x)
}

pub(crate) fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}

pub(crate) fn atan2_f64(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

pub(crate) fn hypot(x: f32, y: f32) -> f32 {
    libm::hypotf(x, y)
}

pub(crate) fn pow(x: f32, exponent: f32) -> f32 {
    libm::powf(x, exponent)
}

pub(crate) fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// What `Mat3::from_rotation_x` gives, about: a turn of so many radians around the x axis.
pub(crate) fn turn_x(angle: f32) -> Mat3 {
    let (sin, cos) = (sin(angle), cos(angle));
    Mat3::from_cols(Vec3::X, Vec3::new(0.0, cos, sin), Vec3::new(0.0, -sin, cos))
}

pub(crate) fn turn_y(angle: f32) -> Mat3 {
    let (sin, cos) = (sin(angle), cos(angle));
    Mat3::from_cols(Vec3::new(cos, 0.0, -sin), Vec3::Y, Vec3::new(sin, 0.0, cos))
}

pub(crate) fn turn_z(angle: f32) -> Mat3 {
    let (sin, cos) = (sin(angle), cos(angle));
    Mat3::from_cols(Vec3::new(cos, sin, 0.0), Vec3::new(-sin, cos, 0.0), Vec3::Z)
}

pub(crate) fn turn_x_f64(angle: f64) -> DMat3 {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    DMat3::from_cols(DVec3::X, DVec3::new(0.0, cos, sin), DVec3::new(0.0, -sin, cos))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[allow(clippy::disallowed_methods, reason = "what it is compared with")]
    #[test]
    fn turns_are_those_that_others_make() {
        for angle in [-2.0f32, -0.36, 0.0, 0.75, 3.0] {
            let pairs = [
                (turn_x(angle), Mat3::from_rotation_x(angle)),
                (turn_y(angle), Mat3::from_rotation_y(angle)),
                (turn_z(angle), Mat3::from_rotation_z(angle)),
            ];
            assert!(pairs.iter().all(|(own, other)| own.abs_diff_eq(*other, 1e-6)), "{angle}: {pairs:?}");
            let (own, other) = (turn_x_f64(angle.into()), DMat3::from_rotation_x(angle.into()));
            assert!(own.abs_diff_eq(other, 1e-12), "{angle}: {own} {other}");
        }
    }

    /// What this is, every system has to find: written down from one, for all.
    #[test]
    fn the_last_bit_is_the_same_everywhere() {
        let (mut hash, mut x) = (0xcbf2_9ce4_8422_2325u64, 0.001f32);
        let mut add = |bits: u64| hash = (hash ^ bits).wrapping_mul(0x0000_0100_0000_01b3);
        while x < 40.0 {
            for value in [sin(x), cos(x), asin(x / 40.0), atan2(x, 1.7), hypot(x, 0.3), pow(x, 0.4)] {
                add(value.to_bits().into());
            }
            let x64 = f64::from(x);
            for value in [exp(-x64), atan2_f64(x64, 1.7), turn_x_f64(x64).y_axis.z] {
                add(value.to_bits());
            }
            x *= 1.003;
        }
        assert_eq!(hash, 0xe776_b4d6_0309_c13b, "{hash:#x}");
    }
}
