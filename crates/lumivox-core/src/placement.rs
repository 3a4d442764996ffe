//! How a scan lies in an engine's object (a node): upright, facing +z, and which of its axes runs along which of the
//! node's.

use glam::{DAffine3, DVec3};

use crate::scene::world_from_patient;
use crate::volume::Volume;

/// Node metres from patient millimetres: the volume's centre at the node's origin, the patient upright, facing +z.
pub fn node_from_patient(volume: &Volume) -> DAffine3 {
    world_from_patient() * DAffine3::from_translation(-volume.center_mm())
}

/// Which axis of the volume's box runs along each axis of the node, and whether it runs the other way.
///
/// An oblique scan's axes run along none: those with the smallest angles in all are taken.
pub fn box_axes(volume: &Volume) -> [(usize, bool); 3] {
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let directions = world_from_patient().matrix3 * volume.directions();
    let along = |node: usize, axis: usize| directions.col(axis).normalize()[node];
    let fit = |order: &[usize; 3]| (0..3).map(|node| along(node, order[node]).abs()).sum::<f64>();
    let order = ORDERS.into_iter().max_by(|a, b| fit(a).total_cmp(&fit(b))).expect("there are orders");
    [0, 1, 2].map(|node| (order[node], along(node, order[node]) < 0.0))
}

/// The node's box, `[0, 1]^3` along the node's axes, in node metres: what clipping is told in.
pub fn node_from_clip(volume: &Volume) -> DAffine3 {
    let node_from_box = node_from_patient(volume) * volume.patient_from_box();
    let mut origin = DVec3::ZERO;
    let mut columns = [DVec3::ZERO; 3];
    for (node, (axis, reversed)) in box_axes(volume).into_iter().enumerate() {
        let column = node_from_box.matrix3.col(axis);
        origin += if reversed { column } else { DVec3::ZERO };
        columns[node] = if reversed { -column } else { column };
    }
    DAffine3::from_cols(columns[0], columns[1], columns[2], node_from_box.translation + origin)
}

/// A clip box along the node's axes as one along the volume's.
pub fn clip_box(volume: &Volume, low: DVec3, high: DVec3) -> [DVec3; 2] {
    let [low, high] = [low.min(high), low.max(high)].map(|v| v.clamp(DVec3::ZERO, DVec3::ONE));
    let mut clip = [DVec3::ZERO, DVec3::ONE];
    for (node, (axis, reversed)) in box_axes(volume).into_iter().enumerate() {
        let [a, b] = if reversed { [1.0 - high[node], 1.0 - low[node]] } else { [low[node], high[node]] };
        (clip[0][axis], clip[1][axis]) = (a, b);
    }
    clip
}

/// The way back: a clip box along the volume's axes as one along the node's, its low corner first.
pub fn node_clip(volume: &Volume, [low, high]: [DVec3; 2]) -> [DVec3; 2] {
    let mut clip = [DVec3::ZERO, DVec3::ONE];
    for (node, (axis, reversed)) in box_axes(volume).into_iter().enumerate() {
        let [a, b] = if reversed { [1.0 - high[axis], 1.0 - low[axis]] } else { [low[axis], high[axis]] };
        (clip[0][node], clip[1][node]) = (a, b);
    }
    clip
}

/// The corners of what the volume fills along the node's axes, in node metres.
pub fn bounds(volume: &Volume) -> [DVec3; 2] {
    let map = node_from_clip(volume);
    let corners = (0..8).map(|i| {
        map.transform_point3(DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
    });
    corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

/// Towards which sides of the patient a direction (LPS) runs, in DICOM's letters, the one that it runs along most first: `A`, or
/// `AR` where it is oblique. Of a side along which no more than `least` of it runs nothing is said.
pub fn side_letters(direction: DVec3, least: f64) -> String {
    let sides = [["R", "L"], ["A", "P"], ["F", "H"]];
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| direction[*b].abs().total_cmp(&direction[*a].abs()));
    let said = axes.into_iter().filter(|axis| direction[*axis].abs() > least);
    said.map(|axis| sides[axis][usize::from(direction[axis] > 0.0)]).collect()
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use crate::volume::{Modality, Voxels};

    fn scan(matrix: DMat3) -> Volume {
        let place = DAffine3::from_mat3_translation(matrix, DVec3::new(7.0, -3.0, 90.0));
        Volume::new([2, 3, 4], Voxels::U8(vec![0; 24]), [1.0, 0.0], place, Modality::Ct).unwrap()
    }

    fn axial() -> Volume {
        scan(DMat3::from_diagonal(DVec3::new(10.0, 20.0, 30.0)))
    }

    #[test]
    fn directions_have_dicoms_letters() {
        assert_eq!(side_letters(DVec3::X, 0.1), "L");
        assert_eq!(side_letters(DVec3::NEG_Y, 0.1), "A");
        assert_eq!(side_letters(DVec3::new(0.0, -0.3, -0.95), 0.1), "FA");
        assert_eq!(side_letters(DVec3::new(0.05, 0.0, 1.0), 0.1), "H");
        assert_eq!(side_letters(DVec3::new(0.0, -0.3, -0.95), 0.4), "F");
    }

    #[test]
    fn clip_boxes_come_back() {
        let clip = [DVec3::new(0.125, 0.25, 0.0), DVec3::new(0.5, 1.0, 0.75)];
        for volume in [axial(), sagittal()] {
            let [low, high] = node_clip(&volume, clip);
            assert_eq!(clip_box(&volume, low, high), clip);
        }
    }

    /// A sagittal scan from feet to head: x to the back, y to the feet, z to the left.
    fn sagittal() -> Volume {
        scan(DMat3::from_cols(DVec3::Y * 5.0, DVec3::NEG_Z * 4.0, DVec3::X * 3.0))
    }

    #[test]
    fn the_nodes_axes_are_right_up_and_towards_the_viewer() {
        // Axial: x to the left (the viewer's right), y to the back, z to the head.
        assert_eq!(box_axes(&axial()), [(0, false), (2, false), (1, true)]);
        assert_eq!(box_axes(&sagittal()), [(2, false), (1, true), (0, true)]);
    }

    #[test]
    fn a_box_is_centred_and_of_true_size() {
        let [low, high] = bounds(&axial());
        assert!((high - low).distance(DVec3::new(0.02, 0.12, 0.06)) < 1e-12);
        assert!((high + low).length() < 1e-12);
    }

    #[test]
    fn clipping_keeps_the_same_part_in_both_systems() {
        for volume in [axial(), sagittal()] {
            let (low, high) = (DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.6, 0.7, 0.8));
            let clip = clip_box(&volume, low, high);
            let node_from_box = node_from_patient(&volume) * volume.patient_from_box();
            let from_box = clip.map(|p| node_from_box.transform_point3(p));
            let from_node = [low, high].map(|p| node_from_clip(&volume).transform_point3(p));
            assert!(from_box[0].min(from_box[1]).distance(from_node[0]) < 1e-12);
            assert!(from_box[0].max(from_box[1]).distance(from_node[1]) < 1e-12);
        }
    }
}
