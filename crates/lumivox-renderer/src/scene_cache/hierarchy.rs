//! Boxes around volumes, and boxes around those: a ray asks few of many.

use std::ops::Range;

use lumivox_core::glam::DVec3;
use lumivox_core::{Camera, VolumeInstance};
use lumivox_shaders::constants::IS_VOLUME;
use lumivox_shaders::layout::Child;

use super::SceneCache;

/// Volumes from which on a hierarchy is worth its walk.
pub(crate) const MANY: usize = 4;

/// An axis-parallel box, relative to the GPU's origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    /// Around what is kept of a volume, a little too large for the rounding of rays.
    pub fn of(instance: &VolumeInstance, origin: DVec3) -> Self {
        let corners = instance.clip_box.map(|corner| corner.clamp(DVec3::ZERO, DVec3::ONE));
        let world_from_box = instance.world_from_box();
        let points = (0..8).map(|i| {
            let pick = |axis: usize| corners[i >> axis & 1][axis];
            world_from_box.transform_point3(DVec3::new(pick(0), pick(1), pick(2))) - origin
        });
        let (low, high) = points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| {
            (low.min(point), high.max(point))
        });
        let slack = DVec3::splat(1e-3 * (high - low).max_element()) + 1e-6 * low.abs().max(high.abs());
        Self { low: low - slack, high: high + slack }
    }

    pub const NOTHING: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    /// From a point to the nearest in it; 0 inside.
    pub fn distance(&self, point: DVec3) -> f64 {
        point.distance(point.clamp(self.low, self.high))
    }

    /// From corner to corner.
    pub fn size(&self) -> f64 {
        self.low.distance(self.high)
    }

    /// The greatest distance of a point in it from `origin` along `axis`, a unit vector; negative infinity of none.
    pub fn farthest_along(&self, origin: DVec3, axis: DVec3) -> f64 {
        let (a, b) = ((self.low - origin) * axis, (self.high - origin) * axis);
        if self.low.x > self.high.x { f64::NEG_INFINITY } else { a.max(b).element_sum() }
    }

    pub fn around(list: impl Iterator<Item = Self>) -> Self {
        list.fold(Self::NOTHING, |a, b| Self { low: a.low.min(b.low), high: a.high.max(b.high) })
    }

    /// Around the origin.
    #[cfg(test)]
    pub fn cube(half: f64) -> Self {
        Self { low: DVec3::splat(-half), high: DVec3::splat(half) }
    }

    fn child(self, index: u32) -> Child {
        Child { low: self.low.as_vec3().to_array(), index, high: self.high.as_vec3().to_array(), padding: 0 }
    }
}

impl SceneCache {
    /// The greatest view depth, in metres, at which a ray meets anything; negative infinity where it never does.
    pub(crate) fn farthest(&self, camera: &Camera) -> f64 {
        let axis = -camera.world_from_camera.matrix3.z_axis;
        self.around.farthest_along(camera.world_from_camera.translation - self.origin, axis)
    }
}

/// The halves of some volumes.
pub(super) type Node = [Child; 2];

/// Where no ray comes.
const NOWHERE: f32 = 3e38;

/// Nodes over so many volumes: one fewer, at least one.
pub(super) fn node_count(volumes: usize) -> usize {
    volumes.saturating_sub(1).max(1)
}

/// The [nodes](node_count) over volumes with these bounds, the root first. Of a scene of at least
/// [`MANY`] volumes few may be there yet, and where few kernels should do all that is classified goes through one.
///
/// Every node halves its volumes at the median of their centres along the axis on which those lie farthest apart, so the
/// depth is the logarithm of their number, whatever their places.
pub(super) fn build(bounds: &[Bounds]) -> Vec<Node> {
    if bounds.len() < 2 {
        let nothing = Child { low: [NOWHERE; 3], index: IS_VOLUME, high: [NOWHERE; 3], padding: 0 };
        let child = |index: u32| bounds.get(index as usize).map_or(nothing, |b| b.child(index | IS_VOLUME));
        return vec![[child(0), child(1)]];
    }
    let mut order: Vec<u32> = (0..bounds.len() as u32).collect();
    let mut nodes = Vec::with_capacity(bounds.len() - 1);
    split(bounds, &mut order, 0..bounds.len(), &mut nodes);
    nodes
}

/// Adds the nodes over `order[range]`, at least two volumes; returns the index of their root.
fn split(bounds: &[Bounds], order: &mut [u32], range: Range<usize>, nodes: &mut Vec<Node>) -> u32 {
    let index = nodes.len() as u32;
    nodes.push(Node::default());
    let center = |volume: u32| bounds[volume as usize].low + bounds[volume as usize].high;
    let members = &mut order[range.clone()];
    let (low, high) = members.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &v| {
        (low.min(center(v)), high.max(center(v)))
    });
    let axis = (high - low).max_position();
    let half = members.len() / 2;
    members.select_nth_unstable_by(half, |&a, &b| center(a)[axis].total_cmp(&center(b)[axis]));
    let middle = range.start + half;
    let children = [range.start..middle, middle..range.end].map(|part| {
        let around = Bounds::around(order[part.clone()].iter().map(|&v| bounds[v as usize]));
        let child = match part.len() {
            1 => order[part.start] | IS_VOLUME,
            _ => split(bounds, order, part, nodes),
        };
        around.child(child)
    });
    nodes[index as usize] = children;
    index
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scattered(count: usize) -> Vec<Bounds> {
        let place = |i: usize, k: usize| ((i * k) % 101) as f64 / 10.0;
        (0..count)
            .map(|i| {
                let low = DVec3::new(place(i, 37), place(i, 59), place(i, 83));
                Bounds { low, high: low + DVec3::new(1.0, 0.5, 1.5) }
            })
            .collect()
    }

    /// Volumes below a child, which all lie in its box, and the greatest depth.
    fn below(nodes: &[Node], bounds: &[Bounds], child: &Child) -> (Vec<u32>, usize) {
        let (volumes, depth) = if child.index & IS_VOLUME != 0 {
            (vec![child.index & !IS_VOLUME], 0)
        } else {
            let [a, b] = nodes[child.index as usize].each_ref().map(|c| below(nodes, bounds, c));
            ([a.0, b.0].concat(), 1 + a.1.max(b.1))
        };
        for &volume in &volumes {
            let inside = bounds[volume as usize];
            assert!(inside.low.as_vec3().cmpge(child.low.into()).all(), "{volume} sticks out below");
            assert!(inside.high.as_vec3().cmple(child.high.into()).all(), "{volume} sticks out above");
        }
        (volumes, depth)
    }

    #[test]
    fn every_volume_is_below_the_root_once_and_not_deep() {
        for count in [2, 3, 4, 5, 7, 8, 9, 100, 1000] {
            let bounds = scattered(count);
            let nodes = build(&bounds);
            assert_eq!(nodes.len(), count - 1);
            let root = Bounds::around(bounds.iter().copied()).child(0);
            let (mut volumes, depth) = below(&nodes, &bounds, &root);
            volumes.sort_unstable();
            assert_eq!(volumes, (0..count as u32).collect::<Vec<_>>());
            assert_eq!(depth, count.next_power_of_two().ilog2() as usize, "{count} volumes");
        }
    }

    #[test]
    fn volumes_in_one_place_are_halved_all_the_same() {
        let bounds = vec![Bounds { low: DVec3::ZERO, high: DVec3::ONE }; 64];
        let root = Bounds::around(bounds.iter().copied()).child(0);
        assert_eq!(below(&build(&bounds), &bounds, &root).1, 6);
    }

    /// A scene's volumes come one after the other, and its kernel looks for them in a hierarchy from the beginning.
    #[test]
    fn what_is_not_there_yet_is_nowhere() {
        for count in 0..2 {
            let [children] = build(&scattered(count))[..] else { panic!("one node") };
            for (i, child) in children.iter().enumerate() {
                let is_there = child.low[0] < NOWHERE;
                assert_eq!((is_there, child.index & IS_VOLUME), (i < count, IS_VOLUME));
            }
        }
    }
}
