//! Clavicles, shoulder blades and the bones of the arms.

use glam::Vec3;

use super::{Arms, Stuff, part::TorsoPart};
use crate::{
    anatomy::{material::Material, raster::Layer},
    sdf::{Sdf, at, ellipsoid, plate, segment, sphere, tube, union},
};

/// The middle of the left humeral head, and of its shaft further on.
pub(crate) fn humerus_line(arms: Arms) -> [Vec3; 2] {
    match arms {
        Arms::Raised => [at(150.0, 16.0, 163.0), at(188.0, 4.0, 262.0)],
        Arms::AtSides => [at(160.0, 18.0, 144.0), at(210.0, 24.0, -130.0)],
    }
}

pub(crate) fn layers(stuff: &Stuff, arms: Arms) -> Vec<Layer> {
    let shape = union(vec![clavicle(), scapula()], 0.0).mirror().rough(0.4, 6.0, stuff.seed("girdle"));
    let shape = stuff.under_skin(shape, 4.5);
    let arm = humerus(arms).mirror().rough(0.4, 7.0, stuff.seed("arms"));
    vec![
        stuff.layer(TorsoPart::Bone, shape, Material::Bone { cortex_mm: 1.3, cortex: 1050.0, spongy: 260.0 }),
        stuff.layer(TorsoPart::Bone, arm, Material::Bone { cortex_mm: 2.4, cortex: 1180.0, spongy: 170.0 }),
    ]
}

/// An S, lying.
fn clavicle() -> Sdf {
    tube(&[
        [19.0, -41.0, 149.0, 9.0],
        [30.0, -46.0, 153.0, 7.4],
        [55.0, -48.0, 159.0, 6.0],
        [85.0, -34.0, 166.0, 5.8],
        [112.0, -10.0, 171.0, 5.8],
        [136.0, 8.0, 175.0, 6.4],
        [146.0, 14.0, 176.0, 6.6],
    ])
}

fn scapula() -> Sdf {
    // From the inner border to the outer one, in rows from the upper to the lower angle: bent around the chest.
    let rows = [
        [at(76.0, 72.0, 156.0), at(92.0, 62.0, 152.0), at(118.0, 42.0, 150.0)],
        [at(71.0, 83.0, 128.0), at(94.0, 74.0, 126.0), at(124.0, 44.0, 128.0)],
        [at(72.0, 90.0, 94.0), at(92.0, 84.0, 94.0), at(116.0, 61.0, 98.0)],
        [at(78.0, 94.0, 60.0), at(92.0, 90.0, 60.0), at(107.0, 76.0, 66.0)],
        [at(87.0, 94.0, 28.0), at(92.0, 92.0, 27.0), at(98.0, 87.0, 30.0)],
    ];
    let mut parts = Vec::new();
    for pair in rows.windows(2) {
        for i in 0..2 {
            let [a, b, c, d] = [pair[0][i], pair[0][i + 1], pair[1][i + 1], pair[1][i]];
            parts.push(plate(a, b, c, 1.5));
            parts.push(plate(a, c, d, 1.5));
        }
    }
    let border =
        |column: usize, r: f32| tube(&rows.map(|row| [row[column].x, row[column].y, row[column].z, r]));
    let spine = |lift: f32, r: f32| {
        tube(&[
            [70.0, 84.0 + 0.2 * lift, 126.0, r],
            [92.0, 77.0 + 0.8 * lift, 134.0, r],
            [118.0, 55.0 + lift, 150.0, 1.2 * r],
            [142.0, 36.0 + lift, 168.0, 1.6 * r],
            [154.0, 22.0 + 0.5 * lift, 176.0, 1.7 * r],
        ])
    };
    let glenoid = ellipsoid(at(132.0, 24.0, 146.0), at(7.0, 13.0, 18.0));
    parts.extend([
        border(0, 2.6),
        border(2, 3.8),
        tube(&[[118.0, 46.0, 146.0, 5.0], [126.0, 34.0, 144.0, 8.0], [131.0, 25.0, 146.0, 10.0]]),
        glenoid,
        spine(4.0, 2.4),
        spine(9.0, 2.6),
        spine(14.0, 3.0),
        // The coracoid process points forward.
        tube(&[[122.0, 30.0, 160.0, 6.0], [120.0, 10.0, 166.0, 5.4], [126.0, -6.0, 158.0, 4.8]]),
    ]);
    union(parts, 2.5)
}

fn humerus(arms: Arms) -> Sdf {
    let [head, end] = humerus_line(arms);
    let along = (end - head).normalize();
    let side = match arms {
        Arms::Raised => at(0.2, -0.97, 0.1),
        Arms::AtSides => at(0.9, -0.4, 0.1),
    };
    let neck = head + along * 34.0;
    let mut parts = vec![
        sphere(head, 23.0),
        sphere(head + along * 6.0 + side * 14.0, 13.0),
        segment(head + along * 4.0, neck, 17.0, 12.0),
        segment(neck, neck + along * 40.0, 12.0, 10.5),
        segment(neck + along * 40.0, end, 10.5, 10.5),
    ];
    if arms == Arms::AtSides {
        parts.push(segment(end, end - along * 22.0 + at(-22.0, 4.0, 0.0), 12.0, 10.0));
        parts.push(segment(end - along * 4.0 + at(-14.0, 2.0, 0.0), end + at(16.0, 2.0, 0.0), 13.0, 12.0));
        // Ulna and radius.
        parts.push(tube(&[
            [206.0, 36.0, -126.0, 10.0],
            [208.0, 30.0, -150.0, 9.0],
            [212.0, 4.0, -262.0, 6.5],
        ]));
        parts.push(tube(&[
            [220.0, 14.0, -146.0, 9.5],
            [226.0, 2.0, -176.0, 7.0],
            [232.0, -14.0, -262.0, 7.5],
        ]));
    }
    union(parts, 6.0)
}
