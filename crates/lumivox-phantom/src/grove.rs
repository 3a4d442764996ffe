//! Thousands of branches as one shape, in a hierarchy of balls, so that a block of voxels meets only those near it.

use glam::Vec3;

use crate::sdf::{Knot, Sdf, segment, xyz};

/// A piece of a branch: its ends, and the radius at each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Twig {
    pub a: Vec3,
    pub b: Vec3,
    pub radii: [f32; 2],
}

impl Twig {
    /// The same branch, so much thicker.
    pub(crate) fn grown(self, by: f32) -> Self {
        Self { radii: self.radii.map(|r| r + by), ..self }
    }
}

/// Shapes around some points, in a ball that holds them all.
pub(crate) fn bounded(shapes: Vec<Sdf>, points: &[Knot], k: f32) -> Sdf {
    let widest = points.iter().fold(0.0f32, |r, p| r.max(p[3]));
    let (low, high) =
        points.iter().fold((Vec3::MAX, Vec3::MIN), |(low, high), p| (low.min(xyz(*p)), high.max(xyz(*p))));
    let radius = (high - low).length() / 2.0 + widest + 2.0 * k;
    Sdf::Bounded(Box::new(Sdf::Union(shapes, k)), (low + high) / 2.0, radius)
}

/// Branches that share a ball of their own.
const LEAF: usize = 6;

/// All branches, blended over `k` mm where they meet.
pub(crate) fn grove(mut twigs: Vec<Twig>, k: f32) -> Sdf {
    gather(&mut twigs, k)
}

fn gather(twigs: &mut [Twig], k: f32) -> Sdf {
    let corners = twigs.iter().flat_map(|t| [(t.a, t.radii[0]), (t.b, t.radii[1])]);
    let (low, high) =
        corners.fold((Vec3::MAX, Vec3::MIN), |(low, high), (p, r)| (low.min(p - r), high.max(p + r)));
    if twigs.is_empty() {
        return Sdf::Empty;
    }
    let children = if twigs.len() <= LEAF {
        twigs.iter().map(|t| segment(t.a, t.b, t.radii[0], t.radii[1])).collect()
    } else {
        let extent = high - low;
        let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
        let middle = twigs.len() / 2;
        let place = |t: &Twig| t.a[axis] + t.b[axis];
        twigs.select_nth_unstable_by(middle, |s, t| place(s).total_cmp(&place(t)));
        let (left, right) = twigs.split_at_mut(middle);
        vec![gather(left, k), gather(right, k)]
    };
    // The blend lets the shape bulge a little.
    Sdf::Bounded(Box::new(Sdf::Union(children, k)), (low + high) / 2.0, (high - low).length() / 2.0 + k)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{noise::hash64, sdf::Region};

    #[test]
    fn a_pruned_grove_is_the_same_nearby() {
        let unit = |i: u64| (hash64(i) >> 40) as f32 / (1 << 24) as f32 - 0.5;
        let point = |i: u64| Vec3::new(unit(3 * i), unit(3 * i + 1), unit(3 * i + 2)) * 200.0;
        let twigs: Vec<Twig> = (0..500)
            .map(|i| Twig { a: point(i), b: point(i) + point(i + 9000) * 0.1, radii: [2.0, 1.0] })
            .collect();
        let tree = grove(twigs, 0.6);
        for i in 0..300 {
            let center = point(i + 20_000);
            let (coarse, _) = tree.prune(&Region { center, radius: 20.0, fields: &[] });
            let (fine, [low, high]) = coarse.prune(&Region { center, radius: 4.0, fields: &[] });
            for j in 0..10 {
                let p = center + point(i * 10 + j).normalize() * 3.9;
                let d = tree.distance(p, &[]);
                assert!((low - 1e-3..=high + 1e-3).contains(&d));
                assert!(d > 5.0 || (fine.distance(p, &[]) - d).abs() < 1e-3);
            }
        }
    }
}
