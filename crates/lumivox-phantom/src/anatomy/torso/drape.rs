//! Straps and ribbons that follow the rib cage.

use glam::Vec3;

use crate::{
    grove::bounded,
    loft::Loft,
    sdf::{Knot, Sdf, spline, strap, xyz},
};

/// Points on the cage: angle around it in degrees (0 in front, 90 on the left, 180 behind), height, distance outside of
/// it and half width.
pub(crate) fn drape(cage: &Loft, path: &[[f32; 4]]) -> Vec<Knot> {
    let place = |&[degrees, z, lift, half_width]: &[f32; 4]| {
        let p = cage.at(degrees.to_radians(), z, lift);
        [p.x, p.y, p.z, half_width]
    };
    spline(path).iter().map(place).collect()
}

/// A ribbon through points, flat towards the cage, of a half thickness at its ends and in its middle.
pub(crate) fn lay(cage: &Loft, points: &[Knot], thin: [f32; 2]) -> Sdf {
    let last = (points.len() - 1) as f32;
    let thickness = |i: usize| {
        let t = i as f32 / last;
        thin[0] + (thin[1] - thin[0]) * 4.0 * t * (1.0 - t)
    };
    let part = |(i, w): (usize, &[Knot])| {
        let (a, b) = (xyz(w[0]), xyz(w[1]));
        let normal = cage.normal((a + b) / 2.0);
        // Flat is what lies across the ribbon, too.
        let along = (b - a).normalize_or(Vec3::Z);
        let normal = (normal - along * normal.dot(along)).normalize_or(Vec3::Y);
        strap(a, b, normal, [w[0][3], w[1][3]], [thickness(i), thickness(i + 1)])
    };
    bounded(points.windows(2).enumerate().map(part).collect(), points, 0.8)
}
