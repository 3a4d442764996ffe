//! Signed distance fields: negative inside, in millimetres; the clay that the anatomy is modelled in.
//!
//! A shape is a tree of primitives under smooth unions and intersections (the quadratic smooth minimum of I. Quilez).
//! Before a block of voxels is filled, [`Sdf::prune`] evaluates the tree once over the ball around the block and drops
//! every branch that cannot matter there (as M. Keeter, *Massively Parallel Rendering of Complex Closed-Form Implicit
//! Surfaces*, SIGGRAPH 2020, does with intervals). A body of thousands of primitives then costs a handful per voxel.

use glam::{Mat3, Vec2, Vec2Swizzles, Vec3};

use crate::{
    grove::bounded,
    loft::{LOFT_LIPSCHITZ, Loft},
    noise::noise2,
};

/// A point of a tube: x, y, z and radius, in mm.
pub(crate) type Knot = [f32; 4];

/// A signed distance field.
#[derive(Clone, Debug)]
pub(crate) enum Sdf {
    /// Nothing anywhere.
    Empty,
    /// Everything.
    Full,
    /// A segment with an elliptic cross-section that may taper.
    Strap(Strap),
    /// An ellipsoid.
    Ellipsoid(Ellipsoid),
    /// A rounded box that may taper along its z axis.
    Block(Block),
    /// A rounded triangular plate.
    Plate(Plate),
    /// A body drawn through sections.
    Loft(Loft),
    /// A child that lies within a ball around a centre: where that is far off, nobody looks at the child.
    Bounded(Box<Sdf>, Vec3, f32),
    /// Everything below a plane: `dot(normal, p) < offset`.
    HalfSpace { normal: Vec3, offset: f32 },
    /// A field that several shapes share, evaluated once per point; see [`Region`].
    Field(usize),
    /// Everything in any child, joined over a blend width.
    Union(Vec<Sdf>, f32),
    /// What is in all children, with edges rounded over a blend width.
    Intersection(Vec<Sdf>, f32),
    /// Everything but the child.
    Not(Box<Sdf>),
    /// The child grown by a distance.
    Grow(Box<Sdf>, f32),
    /// A sheet of a half thickness along the child's surface.
    Sheet(Box<Sdf>, f32),
    /// The child, modelled for x > 0, on both sides.
    Mirror(Box<Sdf>),
    /// The child with an uneven surface.
    Rough(Box<Sdf>, Roughness),
}

/// A segment from `a` to `a + ab` of elliptic cross-section: half width `wide`, half thickness `thin` along `normal`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strap {
    a: Vec3,
    ab: Vec3,
    inv_length2: f32,
    normal: Vec3,
    wide: Vec2,
    thin: Vec2,
}

/// An ellipsoid; `local_from_world` turns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ellipsoid {
    center: Vec3,
    inv_radii: Vec3,
    local_from_world: Mat3,
}

/// A rounded box around `center`, with half sizes `low` at its bottom and `high` at its top.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    center: Vec3,
    local_from_world: Mat3,
    low: Vec2,
    high: Vec2,
    half_height: f32,
    round: f32,
}

/// A triangle with a thickness.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plate {
    corners: [Vec3; 3],
    half_thickness: f32,
}

/// Two octaves of noise added to a distance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Roughness {
    /// Largest displacement, in mm.
    pub amplitude: f32,
    /// Size of the bumps, in mm.
    pub size: f32,
    /// Seed of the noise.
    pub seed: u32,
}

/// The ball for which a tree is pruned, and the shared fields' ranges in it.
pub(crate) struct Region<'a> {
    /// Centre.
    pub center: Vec3,
    /// Radius.
    pub radius: f32,
    /// Lowest and highest value of each shared field.
    pub fields: &'a [[f32; 2]],
}

/// Distance at which rough surfaces count as smooth: deeper inside, nobody sees the bumps.
const ROUGHNESS_REACH: f32 = 8.0;

/// Distance from which a ball stands in for all that it bounds. Nothing is grown or blended over so many mm.
const FAR: f32 = 30.0;

/// The smaller of two distances, blended over `k`.
pub(crate) fn smooth_min(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0);
    a.min(b) - if k > 0.0 { h * h / (4.0 * k) } else { 0.0 }
}

/// 0 below `low`, 1 above `high`, smooth between.
pub(crate) fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The usual approximation of the distance to an ellipse or ellipsoid from scaled coordinates.
fn elliptic(scaled: Vec3, inv_radii: Vec3) -> f32 {
    let k0 = scaled.length();
    if k0 < 1e-6 {
        return -1.0 / inv_radii.max_element();
    }
    let k1 = (scaled * inv_radii).length();
    k0 * (k0 - 1.0) / k1
}

/// The range of [`elliptic`] where scaled coordinates differ by up to `spread` from `scaled`.
///
/// It is no distance: inside and beside a flat ellipse it jumps between the radii, the least and the largest.
fn elliptic_range(scaled: Vec3, spread: Vec3, inv_radii: [Vec3; 2], radii: [f32; 2]) -> [f32; 2] {
    let (near, far) = ((scaled.abs() - spread).max(Vec3::ZERO), scaled.abs() + spread);
    let (low, high) = (near.length(), far.length());
    // How many mm a unit of the scaled coordinates is.
    let [flattest, steepest] = inv_radii;
    let least = radii[0].max(low / (far * steepest).length());
    let most = radii[1].min(high / (near * flattest).length().max(1e-9));
    let bound = |k: f32, outside: f32, inside: f32| (k - 1.0) * if k > 1.0 { outside } else { inside };
    [bound(low, least, most), bound(high, most, least)]
}

impl Sdf {
    /// Distance at `p`; `fields` holds the shared fields' values there.
    pub(crate) fn distance(&self, p: Vec3, fields: &[f32]) -> f32 {
        match self {
            Sdf::Empty => f32::MAX,
            Sdf::Full => f32::MIN,
            Sdf::Strap(s) => s.distance(p),
            Sdf::Ellipsoid(e) => {
                let q = e.local_from_world * (p - e.center);
                elliptic(q * e.inv_radii, e.inv_radii)
            }
            Sdf::Block(b) => b.distance(p),
            Sdf::Plate(t) => t.distance(p),
            Sdf::Loft(l) => l.distance(p),
            Sdf::Bounded(child, ..) => child.distance(p, fields),
            Sdf::HalfSpace { normal, offset } => normal.dot(p) - offset,
            Sdf::Field(index) => fields[*index],
            Sdf::Union(children, k) => {
                children.iter().fold(f32::MAX, |d, c| smooth_min(d, c.distance(p, fields), *k))
            }
            Sdf::Intersection(children, k) => {
                children.iter().fold(f32::MIN, |d, c| -smooth_min(-d, -c.distance(p, fields), *k))
            }
            Sdf::Not(child) => -child.distance(p, fields),
            Sdf::Grow(child, by) => child.distance(p, fields) - by,
            Sdf::Sheet(child, half) => child.distance(p, fields).abs() - half,
            Sdf::Mirror(child) => child.distance(Vec3::new(p.x.abs(), p.y, p.z), fields),
            Sdf::Rough(child, r) => {
                let d = child.distance(p, fields);
                if d.abs() > ROUGHNESS_REACH { d } else { d + r.amplitude * noise2(p / r.size, r.seed) }
            }
        }
    }

    /// The shared fields that the tree asks for, as bits.
    pub(crate) fn fields(&self) -> u32 {
        match self {
            Sdf::Field(index) => 1 << index,
            Sdf::Union(children, _) | Sdf::Intersection(children, _) => {
                children.iter().fold(0, |asked, c| asked | c.fields())
            }
            Sdf::Bounded(c, ..)
            | Sdf::Not(c)
            | Sdf::Grow(c, _)
            | Sdf::Sheet(c, _)
            | Sdf::Mirror(c)
            | Sdf::Rough(c, _) => c.fields(),
            _ => 0,
        }
    }

    /// The tree without what cannot matter in a region, and the lowest and highest distance in it.
    pub(crate) fn prune(&self, region: &Region) -> (Sdf, [f32; 2]) {
        let around = |d: f32, lipschitz: f32| [d - region.radius * lipschitz, d + region.radius * lipschitz];
        match self {
            Sdf::Empty => (Sdf::Empty, [f32::MAX; 2]),
            Sdf::Full => (Sdf::Full, [f32::MIN; 2]),
            Sdf::Strap(s) => {
                let range = s.range(region);
                (self.clone(), range.unwrap_or_else(|| around(s.distance(region.center), s.lipschitz())))
            }
            Sdf::Ellipsoid(e) => (self.clone(), e.range(region)),
            Sdf::Block(b) => (self.clone(), around(b.distance(region.center), b.lipschitz())),
            Sdf::Loft(l) => (self.clone(), around(l.distance(region.center), LOFT_LIPSCHITZ)),
            Sdf::Bounded(child, center, radius) => {
                let d = region.center.distance(*center);
                if d - radius - region.radius > FAR {
                    let range = [d - radius - region.radius, d + radius + region.radius];
                    return (sphere(*center, *radius), range);
                }
                match child.prune(region) {
                    (child @ Sdf::Union(..), range) => {
                        (Sdf::Bounded(Box::new(child), *center, *radius), range)
                    }
                    single => single,
                }
            }
            Sdf::Plate(_) | Sdf::HalfSpace { .. } => {
                (self.clone(), around(self.distance(region.center, &[]), 1.0))
            }
            Sdf::Field(index) => (self.clone(), region.fields[*index]),
            Sdf::Union(children, k) => {
                let mut pruned: Vec<_> = children.iter().map(|c| c.prune(region)).collect();
                let high = pruned.iter().fold(f32::MAX, |m, (_, [_, high])| m.min(*high));
                // Blends of several children reach further than one blend width.
                pruned.retain(|(c, [low, _])| !matches!(c, Sdf::Empty) && *low <= high + 2.0 * k);
                let low = pruned.iter().fold(f32::MAX, |m, (_, [low, _])| m.min(*low)) - 0.5 * k;
                (unwrap_single(pruned, |c| Sdf::Union(c, *k)).unwrap_or(Sdf::Empty), [low, high])
            }
            Sdf::Intersection(children, k) => {
                let mut pruned: Vec<_> = children.iter().map(|c| c.prune(region)).collect();
                let low = pruned.iter().fold(f32::MIN, |m, (_, [low, _])| m.max(*low));
                pruned.retain(|(_, [_, high])| *high >= low - 2.0 * k);
                let high = pruned.iter().fold(f32::MIN, |m, (_, [_, high])| m.max(*high)) + 0.5 * k;
                (unwrap_single(pruned, |c| Sdf::Intersection(c, *k)).unwrap_or(Sdf::Empty), [low, high])
            }
            Sdf::Not(child) => {
                let (child, [low, high]) = child.prune(region);
                (Sdf::Not(Box::new(child)), [-high, -low])
            }
            Sdf::Grow(child, by) => {
                let (child, range) = child.prune(region);
                (Sdf::Grow(Box::new(child), *by), range.map(|d| d - by))
            }
            Sdf::Sheet(child, half) => {
                let (child, [low, high]) = child.prune(region);
                let nearest = if low > 0.0 { low } else { (-high).max(0.0) };
                let range = [nearest - half, low.abs().max(high.abs()) - half];
                (Sdf::Sheet(Box::new(child), *half), range)
            }
            Sdf::Mirror(child) => {
                let c = region.center;
                let folded = Region {
                    center: Vec3::new(c.x.abs(), c.y, c.z),
                    ..Region { fields: region.fields, ..*region }
                };
                let (child, range) = child.prune(&folded);
                (Sdf::Mirror(Box::new(child)), range)
            }
            Sdf::Rough(child, r) => {
                let (child, [low, high]) = child.prune(region);
                if low > ROUGHNESS_REACH || high < -ROUGHNESS_REACH {
                    return (child, [low, high]);
                }
                let a = 1.2 * r.amplitude;
                (Sdf::Rough(Box::new(child), *r), [low - a, high + a])
            }
        }
    }

    /// The child grown by `by` mm.
    pub(crate) fn grow(self, by: f32) -> Sdf {
        Sdf::Grow(Box::new(self), by)
    }

    /// A sheet `2 * half` mm thick along the surface.
    pub(crate) fn sheet(self, half: f32) -> Sdf {
        Sdf::Sheet(Box::new(self), half)
    }

    /// The shape and its mirror image.
    pub(crate) fn mirror(self) -> Sdf {
        Sdf::Mirror(Box::new(self))
    }

    /// What of the shape is not in `other`.
    pub(crate) fn minus(self, other: Sdf, k: f32) -> Sdf {
        Sdf::Intersection(vec![self, Sdf::Not(Box::new(other))], k)
    }

    /// What of the shape is in `other` too.
    pub(crate) fn and(self, other: Sdf, k: f32) -> Sdf {
        Sdf::Intersection(vec![self, other], k)
    }

    /// Both shapes, blended.
    pub(crate) fn or(self, other: Sdf, k: f32) -> Sdf {
        Sdf::Union(vec![self, other], k)
    }

    /// The shape with an uneven surface.
    pub(crate) fn rough(self, amplitude: f32, size: f32, seed: u32) -> Sdf {
        Sdf::Rough(Box::new(self), Roughness { amplitude, size, seed })
    }
}

/// The children under their operator, or the only child as it is.
fn unwrap_single(mut pruned: Vec<(Sdf, [f32; 2])>, wrap: impl Fn(Vec<Sdf>) -> Sdf) -> Option<Sdf> {
    match pruned.len() {
        0 => None,
        1 => pruned.pop().map(|(c, _)| c),
        _ => Some(wrap(pruned.into_iter().map(|(c, _)| c).collect())),
    }
}

impl Strap {
    /// The offset from the segment, and the radii there.
    fn offset(&self, p: Vec3) -> (Vec3, f32, f32) {
        let ap = p - self.a;
        let t = (ap.dot(self.ab) * self.inv_length2).clamp(0.0, 1.0);
        let wide = self.wide.x + (self.wide.y - self.wide.x) * t;
        let thin = self.thin.x + (self.thin.y - self.thin.x) * t;
        (ap - self.ab * t, wide, thin)
    }

    /// An offset along and across the normal, and the inverse radii.
    fn scaled(&self, q: Vec3, wide: f32, thin: f32) -> (Vec3, Vec3) {
        let along = q.dot(self.normal);
        let across = (q.length_squared() - along * along).max(0.0).sqrt();
        let inv = Vec3::new(1.0 / wide, 1.0 / thin, 0.0);
        (Vec3::new(across, along, 0.0) * inv, inv)
    }

    fn distance(&self, p: Vec3) -> f32 {
        let (q, wide, thin) = self.offset(p);
        if wide == thin {
            return q.length() - wide;
        }
        let (scaled, inv) = self.scaled(q, wide, thin);
        elliptic(scaled, inv)
    }

    /// The range in a region, if the strap is flat.
    fn range(&self, region: &Region) -> Option<[f32; 2]> {
        if self.wide == self.thin {
            return None;
        }
        let (q, wide, thin) = self.offset(region.center);
        let radii = [self.wide.min(self.thin).min_element(), self.wide.max(self.thin).max_element()];
        let taper = (self.wide - self.wide.yx()).abs().max((self.thin - self.thin.yx()).abs()).max_element()
            * self.inv_length2.sqrt();
        let steepest = Vec3::new(1.0 / self.wide.min_element(), 1.0 / self.thin.min_element(), 0.0);
        let spread = region.radius * (1.0 + taper) * steepest;
        let flattest = Vec3::new(1.0 / self.wide.max_element(), 1.0 / self.thin.max_element(), 0.0);
        Some(elliptic_range(self.scaled(q, wide, thin).0, spread, [flattest, steepest], radii))
    }

    fn lipschitz(&self) -> f32 {
        1.0 + ((self.wide.x - self.wide.y).abs() * self.inv_length2.sqrt()).min(2.0)
    }
}

impl Ellipsoid {
    fn range(&self, region: &Region) -> [f32; 2] {
        let scaled = self.local_from_world * (region.center - self.center) * self.inv_radii;
        let radii = [1.0 / self.inv_radii.max_element(), 1.0 / self.inv_radii.min_element()];
        elliptic_range(scaled, region.radius * self.inv_radii, [self.inv_radii; 2], radii)
    }
}

impl Block {
    fn distance(&self, p: Vec3) -> f32 {
        let q = self.local_from_world * (p - self.center);
        let t = (q.z / (2.0 * self.half_height) + 0.5).clamp(0.0, 1.0);
        let half = self.low + (self.high - self.low) * t;
        let d = q.abs() - half.extend(self.half_height) + self.round;
        d.max(Vec3::ZERO).length() + d.max_element().min(0.0) - self.round
    }

    fn lipschitz(&self) -> f32 {
        1.0 + (self.high - self.low).abs().max_element() / (2.0 * self.half_height)
    }
}

impl Plate {
    fn distance(&self, p: Vec3) -> f32 {
        let [a, b, c] = self.corners;
        let normal = (b - a).cross(a - c);
        let edge = |from: Vec3, to: Vec3| {
            let (e, v) = (to - from, p - from);
            (e * (v.dot(e) / e.length_squared()).clamp(0.0, 1.0) - v).length_squared()
        };
        let side = |from: Vec3, to: Vec3| (to - from).cross(normal).dot(p - from).signum();
        let outside = side(a, b) + side(b, c) + side(c, a) < 2.0;
        let d2 = if outside {
            edge(a, b).min(edge(b, c)).min(edge(c, a))
        } else {
            let h = normal.dot(p - a);
            h * h / normal.length_squared()
        };
        d2.sqrt() - self.half_thickness
    }
}

/// A point.
pub(crate) const fn at(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// A sphere.
pub(crate) fn sphere(center: Vec3, radius: f32) -> Sdf {
    segment(center, center + Vec3::Z * 1e-3, radius, radius)
}

/// A round segment whose radius goes from `ra` to `rb`.
pub(crate) fn segment(a: Vec3, b: Vec3, ra: f32, rb: f32) -> Sdf {
    strap(a, b, Vec3::X, [ra, rb], [ra, rb])
}

/// A segment of elliptic cross-section: half widths and half thicknesses (along `normal`) at both ends.
pub(crate) fn strap(a: Vec3, b: Vec3, normal: Vec3, wide: [f32; 2], thin: [f32; 2]) -> Sdf {
    let ab = b - a;
    Sdf::Strap(Strap {
        a,
        ab,
        inv_length2: 1.0 / ab.length_squared().max(1e-12),
        normal: normal.normalize(),
        wide: Vec2::from(wide),
        thin: Vec2::from(thin),
    })
}

/// An ellipsoid along the axes.
pub(crate) fn ellipsoid(center: Vec3, radii: Vec3) -> Sdf {
    turned_ellipsoid(center, radii, Mat3::IDENTITY)
}

/// An ellipsoid whose axes are the columns of `axes`.
pub(crate) fn turned_ellipsoid(center: Vec3, radii: Vec3, axes: Mat3) -> Sdf {
    Sdf::Ellipsoid(Ellipsoid { center, inv_radii: radii.recip(), local_from_world: axes.transpose() })
}

/// A rounded box along the columns of `axes`; half sizes (x, y) at its low and high end, half height z.
pub(crate) fn block(
    center: Vec3,
    low: [f32; 2],
    high: [f32; 2],
    half_height: f32,
    round: f32,
    axes: Mat3,
) -> Sdf {
    Sdf::Block(Block {
        center,
        local_from_world: axes.transpose(),
        low: Vec2::from(low),
        high: Vec2::from(high),
        half_height,
        round,
    })
}

/// A triangular plate.
pub(crate) fn plate(a: Vec3, b: Vec3, c: Vec3, half_thickness: f32) -> Sdf {
    Sdf::Plate(Plate { corners: [a, b, c], half_thickness })
}

/// A four-cornered plate.
pub(crate) fn quad(corners: [Vec3; 4], half_thickness: f32) -> Sdf {
    let [a, b, c, d] = corners;
    Sdf::Union(vec![plate(a, b, c, half_thickness), plate(a, c, d, half_thickness)], 0.0)
}

/// Shapes joined over a blend width of `k` mm.
pub(crate) fn union(children: Vec<Sdf>, k: f32) -> Sdf {
    Sdf::Union(children, k)
}

/// A tube through knots, along a Catmull-Rom spline.
pub(crate) fn tube(knots: &[Knot]) -> Sdf {
    let points = spline(knots);
    bounded(points.windows(2).map(|w| knot_segment(w[0], w[1])).collect(), &points, 0.4)
}

/// A closed tube.
pub(crate) fn ring(knots: &[Knot]) -> Sdf {
    let n = knots.len();
    let wrapped: Vec<Knot> = (0..n + 3).map(|i| knots[(i + n - 1) % n]).collect();
    let points = spline(&wrapped);
    // The spline passes through every knot: cut off the run-in before the first and after the last.
    let index = |k: &Knot| points.iter().position(|p| p == k).expect("the spline passes through its knots");
    let start = index(&knots[0]);
    let end = points.iter().rposition(|p| *p == knots[0]).unwrap_or(points.len() - 1);
    Sdf::Union(points[start..=end].windows(2).map(|w| knot_segment(w[0], w[1])).collect(), 0.4)
}

/// A ribbon through knots: the knot's radius is its half width, its half thickness along `normal` is
/// `flatness` times that.
pub(crate) fn ribbon(knots: &[Knot], normal: Vec3, flatness: f32) -> Sdf {
    let points = spline(knots);
    let part = |w: &[Knot]| {
        let (a, b) = (w[0], w[1]);
        strap(xyz(a), xyz(b), normal, [a[3], b[3]], [a[3] * flatness, b[3] * flatness])
    };
    Sdf::Union(points.windows(2).map(part).collect(), 0.8)
}

/// The position of a knot.
pub(crate) fn xyz(k: Knot) -> Vec3 {
    Vec3::new(k[0], k[1], k[2])
}

fn knot_segment(a: Knot, b: Knot) -> Sdf {
    segment(xyz(a), xyz(b), a[3], b[3])
}

/// Points of a Catmull-Rom spline through `knots`, a few millimetres apart.
pub(crate) fn spline(knots: &[Knot]) -> Vec<Knot> {
    let n = knots.len();
    let mut points = vec![knots[0]];
    for i in 0..n - 1 {
        let k = [knots[i.saturating_sub(1)], knots[i], knots[i + 1], knots[(i + 2).min(n - 1)]];
        let length = xyz(k[1]).distance(xyz(k[2]));
        let steps = (length / (1.2 * k[1][3].max(k[2][3])).clamp(1.6, 6.0)).ceil().max(1.0) as usize;
        for step in 1..=steps {
            if step == steps {
                points.push(k[2]);
                continue;
            }
            let t = step as f32 / steps as f32;
            let weights = [
                ((2.0 - t) * t - 1.0) * t,
                (3.0 * t - 5.0) * t * t + 2.0,
                ((4.0 - 3.0 * t) * t + 1.0) * t,
                (t - 1.0) * t * t,
            ];
            points.push(std::array::from_fn(|c| 0.5 * (0..4).map(|j| weights[j] * k[j][c]).sum::<f32>()));
        }
    }
    points
}

#[cfg(test)]
mod tests;
