//! A body drawn through rounded sections: what trunks are made of.

use std::sync::Arc;

use crate::maths;

use glam::Vec3;

/// A horizontal section: a superellipse, symmetric left and right, of unequal depth in front and behind.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Section {
    /// Height.
    pub z: f32,
    /// Half width, at `y`.
    pub half_width: f32,
    /// Where it is widest.
    pub y: f32,
    /// Foremost and rearmost y.
    pub ends: [f32; 2],
}

/// A section from height, half width, y of the largest width, foremost and rearmost y.
pub(crate) const fn section(z: f32, half_width: f32, y: f32, front: f32, back: f32) -> Section {
    Section { z, half_width, y, ends: [front, back] }
}

/// Sections at even heights, with their slopes: half width, y, depth in front, depth behind.
#[derive(Clone, Debug)]
pub(crate) struct Loft {
    rows: Arc<[[f32; 4]]>,
    low: f32,
    high: f32,
}

/// Distance of a loft's rows, in mm.
const STEP: f32 = 2.0;

/// Exponent of the superellipse: between an ellipse and a box, as chests are. Powers of it need square roots only.
const EXPONENT: f32 = 2.5;

/// Distances deep inside depend on the direction that they are looked at from, by the ratio of the half axes.
pub(crate) const LOFT_LIPSCHITZ: f32 = 1.5;

impl Loft {
    /// Through sections from bottom to top.
    pub(crate) fn new(sections: &[Section]) -> Self {
        let (low, high) = (sections[0].z, sections[sections.len() - 1].z);
        let numbers = |s: &Section| [s.half_width, s.y, s.y - s.ends[0], s.ends[1] - s.y];
        let count = ((high - low) / STEP).ceil() as usize + 1;
        let rows = (0..count).map(|row| {
            let z = (low + row as f32 * STEP).min(high);
            let i = sections.windows(2).position(|w| z <= w[1].z).unwrap_or(sections.len() - 2);
            let (a, b) = (&sections[i], &sections[i + 1]);
            let (before, after) =
                (&sections[i.saturating_sub(1)], &sections[(i + 2).min(sections.len() - 1)]);
            let t = (z - a.z) / (b.z - a.z);
            let span = b.z - a.z;
            std::array::from_fn(|c| {
                let [p, q, r, s] = [before, a, b, after].map(|s| numbers(s)[c]);
                let slope =
                    |from: f32, to: f32, dz: f32| if dz > 0.0 { (to - from) / dz * span } else { 0.0 };
                hermite(q, r, slope(p, r, b.z - before.z), slope(q, s, after.z - a.z), t)
            })
        });
        Self { rows: rows.collect(), low, high }
    }

    /// Half width, y, depth in front and behind, and their slopes.
    fn row(&self, z: f32) -> ([f32; 4], [f32; 4]) {
        let at = ((z.clamp(self.low, self.high) - self.low) / STEP).clamp(0.0, (self.rows.len() - 1) as f32);
        let i = (at as usize).min(self.rows.len() - 2);
        let t = at - i as f32;
        let (a, b) = (&self.rows[i], &self.rows[i + 1]);
        (std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t), std::array::from_fn(|c| (b[c] - a[c]) / STEP))
    }

    pub(crate) fn distance(&self, p: Vec3) -> f32 {
        let ([w, y, front, back], [dw, dy, dfront, dback]) = self.row(p.z);
        let side = p.y - y;
        let (depth, ddepth) = if side < 0.0 { (front, dfront) } else { (back, dback) };
        let (u, v) = (p.x.abs() / w, side.abs() / depth);
        let (u15, v15) = (u * u.sqrt(), v * v.sqrt());
        let s = u15 * u + v15 * v;
        let wall = if s < 1e-6 {
            -w.min(depth)
        } else {
            // Homogeneous of degree 1, so that it grows evenly away from the surface.
            let k = maths::pow(s, 1.0 / EXPONENT);
            let scale = k / s;
            let gx = u15 / w;
            let gy = v15 / depth;
            let gz = u15 * u * dw / w + v15 * (v * ddepth + dy * side.signum()) / depth;
            (k - 1.0) / (scale * (gx * gx + gy * gy + gz * gz).sqrt())
        };
        let past = (p.z - self.high).max(self.low - p.z);
        if past > 0.0 && wall > 0.0 { maths::hypot(past, wall) } else { wall.max(past) }
    }

    /// The point of the surface at an angle around the trunk (0 in front, pi/2 on the left, pi behind), `lift` outside.
    pub(crate) fn at(&self, angle: f32, z: f32, lift: f32) -> Vec3 {
        let ([w, y, front, back], _) = self.row(z);
        let (sin, cos) = (maths::sin(angle), maths::cos(angle));
        let bend = |c: f32| c.signum() * maths::pow(c.abs(), 2.0 / EXPONENT);
        let depth = if cos > 0.0 { front } else { back };
        let p = Vec3::new(w * bend(sin), y - depth * bend(cos), z);
        p + self.normal(p) * lift
    }

    /// The angle of [`Loft::at`] at which the surface is `x` from the middle: in front, or behind.
    pub(crate) fn angle(&self, x: f32, z: f32, behind: bool) -> f32 {
        let ([w, ..], _) = self.row(z);
        let ratio = (x / w).clamp(-1.0, 1.0);
        let angle = maths::asin(ratio.signum() * maths::pow(ratio.abs(), EXPONENT / 2.0));
        if behind { std::f32::consts::PI - angle } else { angle }
    }

    /// The direction in which the distance grows.
    pub(crate) fn normal(&self, p: Vec3) -> Vec3 {
        let d = |q: Vec3| self.distance(q);
        let e = 0.5;
        Vec3::new(
            d(p + Vec3::X * e) - d(p - Vec3::X * e),
            d(p + Vec3::Y * e) - d(p - Vec3::Y * e),
            d(p + Vec3::Z * e) - d(p - Vec3::Z * e),
        )
        .normalize_or(Vec3::NEG_Y)
    }
}

/// The cubic from `a` to `b` with slopes `da` and `db`.
fn hermite(a: f32, b: f32, da: f32, db: f32, t: f32) -> f32 {
    let (t2, t3) = (t * t, t * t * t);
    a * (2.0 * t3 - 3.0 * t2 + 1.0) + da * (t3 - 2.0 * t2 + t) + b * (3.0 * t2 - 2.0 * t3) + db * (t3 - t2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn barrel() -> Loft {
        Loft::new(&[
            section(-100.0, 100.0, 5.0, -70.0, 80.0),
            section(0.0, 130.0, 10.0, -85.0, 90.0),
            section(100.0, 90.0, 12.0, -60.0, 78.0),
        ])
    }

    #[test]
    fn a_loft_passes_through_its_sections() {
        let loft = barrel();
        for p in [
            Vec3::new(130.0, 10.0, 0.0),
            Vec3::new(-130.0, 10.0, 0.0),
            Vec3::new(0.0, -85.0, 0.0),
            Vec3::new(0.0, 90.0, 0.0),
        ] {
            assert!(loft.distance(p).abs() < 0.3, "{p}: {}", loft.distance(p));
        }
        assert!(loft.distance(Vec3::new(0.0, 0.0, 110.0)) > 9.0, "it ends");
    }

    #[test]
    fn points_on_it_are_where_it_is() {
        let loft = barrel();
        for i in 0..200 {
            let (angle, z) = (i as f32 * 0.31, (i as f32 * 7.7) % 180.0 - 90.0);
            assert!(loft.distance(loft.at(angle, z, 0.0)).abs() < 0.2);
            let lifted = loft.distance(loft.at(angle, z, 8.0));
            assert!((6.5..9.5).contains(&lifted), "{lifted} at {angle}, {z}");
        }
        let p = loft.at(loft.angle(40.0, 20.0, true), 20.0, 0.0);
        assert!((p.x - 40.0).abs() < 0.1 && p.y > 60.0);
    }
}
