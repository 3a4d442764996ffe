//! Trees that grow until they reach every part of a space, as bronchi and vessels do.
//!
//! After Tawhai, Pullan and Hunter, *Generation of an anatomically based three-dimensional model of the conducting
//! airways* (Annals of Biomedical Engineering, 2000): the points of a space are parted by a plane along the branch that
//! supplies them, and a child grows part of the way to the middle of each half. Radii follow Murray's law.

use glam::Vec3;

use crate::maths;
use crate::{grove::Twig, noise::hash64};

/// A branch, from where it leaves its parent to where it parts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Branch {
    pub from: Vec3,
    /// Where it aims when it leaves: a bend, not a corner.
    pub bend: Vec3,
    pub to: Vec3,
    pub radius: f32,
    /// The parent's.
    pub parent_radius: f32,
    /// Branchings since the root.
    pub generation: u32,
}

/// How a tree grows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Habit {
    /// How much of the way to the middle of its space a branch goes.
    pub reach: f32,
    /// Branches thinner than this grow no more.
    pub thinnest: f32,
    /// So do those with fewer points than this.
    pub fewest: usize,
    /// By how much the plane that parts a space is turned, in radians: another habit gives another tree.
    pub turn: f32,
}

/// Exponent of Murray's law, as measured in lungs.
const MURRAY: f32 = 2.75;

/// The steepest angle of a child to its parent, as a cosine.
const STEEPEST: f32 = 0.2;

/// Grows a tree from a stem that ends in `from`, into all `points`.
pub(crate) fn grow(points: &mut [Vec3], from: Vec3, along: Vec3, radius: f32, habit: Habit) -> Vec<Branch> {
    let mut branches = Vec::new();
    part(points, from, along.normalize(), radius, 1, habit, &mut branches);
    branches
}

fn part(
    points: &mut [Vec3],
    from: Vec3,
    along: Vec3,
    radius: f32,
    generation: u32,
    habit: Habit,
    branches: &mut Vec<Branch>,
) {
    if points.len() < habit.fewest || radius < habit.thinnest || generation > 24 {
        return;
    }
    let count = points.len() as f32;
    let normal = widest(points, along, habit.turn);
    let middle = mean(points).dot(normal);
    points.sort_unstable_by(|p, q| p.dot(normal).total_cmp(&q.dot(normal)));
    let cut = points.partition_point(|p| p.dot(normal) < middle).clamp(1, points.len() - 1);
    let (low, high) = points.split_at_mut(cut);
    for half in [low, high] {
        let share = half.len() as f32 / count;
        let own = radius * maths::pow(share, 1.0 / MURRAY);
        let aim = mean(half) - from;
        let way = limited(aim.normalize_or(along), along);
        let length = (aim.length() * habit.reach).clamp(2.0 * own, 34.0);
        let to = from + way * length;
        let bend = from + along.lerp(way, 0.35).normalize() * (0.45 * length);
        branches.push(Branch { from, bend, to, radius: own, parent_radius: radius, generation });
        part(half, to, (to - bend).normalize_or(way), own, generation + 1, habit, branches);
    }
}

/// The direction turned towards `along` until it is no steeper than branches are.
fn limited(way: Vec3, along: Vec3) -> Vec3 {
    let cos = way.dot(along);
    if cos >= STEEPEST {
        return way;
    }
    let across = (way - along * cos).normalize_or(along.any_orthonormal_vector());
    along * STEEPEST + across * (1.0 - STEEPEST * STEEPEST).sqrt()
}

fn mean(points: &[Vec3]) -> Vec3 {
    points.iter().copied().sum::<Vec3>() / points.len().max(1) as f32
}

/// The direction across `along` in which the points spread most.
fn widest(points: &[Vec3], along: Vec3, turn: f32) -> Vec3 {
    let (u, v) = along.any_orthonormal_pair();
    let center = mean(points);
    let (mut uu, mut uv, mut vv) = (0.0f64, 0.0f64, 0.0f64);
    // A sample of a large set says as much.
    for p in points.iter().step_by(points.len() / 256 + 1) {
        let (a, b) = (f64::from((*p - center).dot(u)), f64::from((*p - center).dot(v)));
        uu += a * a;
        uv += a * b;
        vv += b * b;
    }
    let angle = 0.5 * maths::atan2_f64(2.0 * uv, uu - vv) as f32 + turn;
    u * maths::cos(angle) + v * maths::sin(angle)
}

/// Points spread evenly over what of a box `inside` accepts, `step` mm apart.
pub(crate) fn points_in(low: Vec3, high: Vec3, step: f32, inside: impl Fn(Vec3) -> bool) -> Vec<Vec3> {
    let [nx, ny, nz] = ((high - low) / step).to_array().map(|n| n.ceil() as u64);
    let jitter = |i: u64| (hash64(i) >> 40) as f32 / (1 << 24) as f32 - 0.5;
    let mut points = Vec::new();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let i = ((z * ny + y) * nx + x) * 3;
                let offset = Vec3::new(jitter(i), jitter(i + 1), jitter(i + 2)) * 0.9 + 0.5;
                let p = low + (Vec3::new(x as f32, y as f32, z as f32) + offset) * step;
                if inside(p) {
                    points.push(p);
                }
            }
        }
    }
    points
}

impl Branch {
    /// The branch as straight pieces, its radius changed by `size`.
    pub(crate) fn twigs(&self, size: impl Fn(f32) -> f32) -> Vec<Twig> {
        let start = size(0.5 * (self.radius + self.parent_radius).min(2.4 * self.radius));
        let (middle, end) = (size(self.radius), size(0.96 * self.radius));
        if self.from.distance(self.to) < 5.0 {
            return vec![Twig { a: self.from, b: self.to, radii: [middle, end] }];
        }
        let at = |t: f32| self.from.lerp(self.bend, t).lerp(self.bend.lerp(self.to, t), t);
        let (p, q) = (at(0.35), at(0.68));
        vec![
            Twig { a: self.from, b: p, radii: [start.min(1.25 * middle), middle] },
            Twig { a: p, b: q, radii: [middle, middle] },
            Twig { a: q, b: self.to, radii: [middle, end] },
        ]
    }

    /// The branch that runs beside this one, `apart` radii away towards `side`.
    pub(crate) fn beside(&self, side: Vec3, apart: f32) -> Branch {
        let shift = |radius: f32| side * (apart * radius + 0.7);
        Branch {
            from: self.from + shift(self.parent_radius),
            bend: self.bend + shift(0.5 * (self.radius + self.parent_radius)),
            to: self.to + shift(self.radius),
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tree_reaches_all_of_its_space() {
        let mut points = points_in(Vec3::splat(-50.0), Vec3::splat(50.0), 6.0, |p| p.length() < 50.0);
        let all = points.clone();
        let habit = Habit { reach: 0.42, thinnest: 0.4, fewest: 6, turn: 0.0 };
        let branches = grow(&mut points, Vec3::new(0.0, 0.0, 45.0), Vec3::NEG_Z, 4.0, habit);
        let far = |p: &&Vec3| branches.iter().all(|b| b.to.distance(**p) > 20.0);
        let missed = all.iter().filter(far).count();
        assert!(missed * 20 < all.len(), "{missed} of {} points are far from it", all.len());
        // Every branch starts where another one, or the stem, ends.
        let starts = branches
            .iter()
            .filter(|b| b.generation == 1 || branches.iter().any(|parent| parent.to == b.from));
        assert_eq!(starts.count(), branches.len());
        assert!(branches.iter().all(|b| b.radius < b.parent_radius));
    }
}
