//! The spine from C7 to L4, its discs and its canal.

use glam::Vec3;

use super::{Stuff, part::TorsoPart};
use crate::maths;
use crate::{
    anatomy::{material::Material, raster::Layer, spine::Place},
    sdf::{Knot, Sdf, at, block, segment, strap, tube, union},
};

/// A vertebra: y and z of its body's centre, the body's half width, half depth and half height.
#[derive(Clone, Copy)]
struct Level {
    y: f32,
    z: f32,
    half: [f32; 3],
}

const fn level(y: f32, z: f32, half: [f32; 3]) -> Level {
    Level { y, z, half }
}

/// C7, T1 to T12, L1 to L5.
const LEVELS: [Level; 18] = [
    level(10.0, 196.0, [13.0, 8.5, 7.2]),
    level(16.0, 178.0, [13.5, 9.0, 7.8]),
    level(24.0, 158.5, [13.5, 10.0, 8.2]),
    level(32.0, 138.5, [13.5, 11.0, 8.6]),
    level(39.0, 118.0, [13.5, 12.0, 8.9]),
    level(44.0, 97.0, [14.0, 13.0, 9.2]),
    level(47.0, 75.5, [14.5, 14.0, 9.5]),
    level(49.0, 53.5, [15.0, 14.5, 9.7]),
    level(49.0, 31.0, [15.5, 15.0, 10.0]),
    level(47.0, 8.0, [16.5, 15.5, 10.3]),
    level(44.0, -16.0, [17.5, 16.0, 10.8]),
    level(40.0, -41.0, [18.5, 16.0, 11.3]),
    level(36.0, -67.0, [20.0, 16.0, 12.0]),
    level(31.0, -96.0, [21.0, 16.5, 12.8]),
    level(26.0, -128.0, [22.0, 17.0, 13.4]),
    level(22.0, -161.0, [23.0, 17.5, 13.6]),
    level(20.0, -195.0, [24.0, 17.5, 13.6]),
    level(22.0, -229.0, [25.0, 17.5, 13.6]),
];

/// The index of T1 in the column.
const T1: usize = 1;

/// The index of L1 in the column.
const L1: usize = 13;

fn place(index: usize) -> Place {
    let l = LEVELS[index];
    let (above, below) = (LEVELS[index.saturating_sub(1)], LEVELS[(index + 1).min(LEVELS.len() - 1)]);
    let tilt = maths::atan2(above.y - below.y, above.z - below.z);
    Place { center: at(0.0, l.y, l.z), tilt, size: 1.0 }
}

/// Where a rib (1 to 12) meets the spine: beside the body, and before the tip of the transverse process.
pub(crate) fn rib_joints(rib: usize) -> [Vec3; 2] {
    let index = T1 + rib - 1;
    let [w, d, h] = LEVELS[index].half;
    let v = place(index);
    // The last ribs have no joint with a process.
    let out = if rib > 10 { 26.0 } else { 31.0 };
    [v.at(w + 0.5, 0.45 * d, 0.72 * h), v.at(out, d + 13.5, 5.0)]
}

pub(crate) fn layers(stuff: &Stuff) -> Vec<Layer> {
    let bones = (0..LEVELS.len()).map(|i| if i < L1 { thoracic(i) } else { lumbar(i) }).collect();
    let bones = union(bones, 0.4).rough(0.4, 5.0, stuff.seed("spine"));
    let bone = Material::Bone { cortex_mm: 1.1, cortex: 820.0, spongy: 215.0 };
    vec![
        stuff.layer(TorsoPart::Cartilage, discs(), Material::even(88.0, 12.0, 4.0)),
        stuff.layer(TorsoPart::SpinalCanal, canal_line(8.2, LEVELS.len()), Material::even(12.0, 5.0, 4.0)),
        stuff.layer(TorsoPart::SpinalCanal, canal_line(4.8, L1 + 1), Material::even(40.0, 3.0, 4.0)),
        stuff.layer(TorsoPart::Bone, stuff.under_skin(bones, 5.0), bone),
    ]
}

/// The body of a vertebra, drawn in at its waist.
fn body(v: Place, [w, d, h]: [f32; 3]) -> Sdf {
    let waist = v.tube(&[
        [-w - 1.5, -0.2 * d, 0.0, 3.0],
        [-0.75 * w, -0.95 * d, 0.0, 3.2],
        [0.0, -d - 1.8, 0.0, 3.2],
        [0.75 * w, -0.95 * d, 0.0, 3.2],
        [w + 1.5, -0.2 * d, 0.0, 3.0],
    ]);
    block(v.center, [w, d], [w, d], h, 0.55 * d, v.turn()).minus(waist, 4.0)
}

fn thoracic(index: usize) -> Sdf {
    let v = place(index);
    let half @ [_, d, h] = LEVELS[index].half;
    // How steeply the spinous process falls: most in the middle of the chest.
    let middle = (1.0 - (index as f32 - 7.0).abs() / 6.0).clamp(0.0, 1.0);
    let (out, drop) = match index {
        0 | T1 => (44.0, -10.0),
        12 => (32.0, -9.0),
        _ => (41.0 - 3.0 * middle, -16.0 - 19.0 * middle),
    };
    let spinous = union(
        vec![
            v.tube(&[
                [0.0, d + 17.0, -1.0, 3.6],
                [0.0, d + 28.0, 0.5 * drop, 2.9],
                [0.0, d + out, drop, 3.4],
            ]),
            v.tube(&[
                [0.0, d + 17.0, -6.0, 3.0],
                [0.0, d + 28.0, 0.5 * drop - 4.0, 2.6],
                [0.0, d + out, drop - 2.5, 2.8],
            ]),
        ],
        2.0,
    );
    let length = if index >= 11 { 0.7 } else { 1.0 };
    let side = union(
        vec![
            v.tube(&[
                [8.5, 0.7 * d, 0.35 * h, 3.6],
                [9.5, d + 5.0, 0.35 * h, 3.4],
                [11.0, d + 11.0, 0.2 * h, 3.8],
            ]),
            segment(v.at(11.0, d + 12.0, h), v.at(11.0, d + 16.0, -h - 3.0), 3.4, 3.6),
            strap(
                v.at(10.0, d + 13.0, -1.0),
                v.at(1.0, d + 20.0, -5.0),
                at(0.6, -1.0, 0.2),
                [8.0, 8.0],
                [2.4, 2.4],
            ),
            v.tube(&[
                [11.0, d + 11.0, 2.0, 4.6],
                [12.0 + 10.0 * length, d + 16.0, 4.0, 4.2],
                [12.0 + 19.0 * length, d + 19.0, 6.0, 5.2],
            ]),
        ],
        3.0,
    );
    union(vec![body(v, half), side.mirror(), spinous], 3.0)
}

fn lumbar(index: usize) -> Sdf {
    let v = place(index);
    let half @ [w, d, h] = LEVELS[index].half;
    let spinous =
        strap(v.at(0.0, d + 22.0, -5.0), v.at(0.0, d + 44.0, -9.0), Vec3::X, [10.0, 12.0], [2.8, 4.0]);
    let side = union(
        vec![
            v.tube(&[
                [0.55 * w, 0.8 * d, 0.35 * h, 4.6],
                [0.6 * w, d + 6.0, 0.3 * h, 4.4],
                [15.0, d + 12.0, 0.1 * h, 4.8],
            ]),
            v.tube(&[
                [15.0, d + 15.0, h + 3.0, 5.0],
                [15.0, d + 17.0, 0.0, 4.6],
                [13.5, d + 20.0, -h - 3.0, 5.4],
            ]),
            strap(
                v.at(13.0, d + 15.0, -3.0),
                v.at(1.0, d + 23.0, -7.0),
                at(0.6, -1.0, 0.2),
                [9.0, 9.0],
                [2.8, 2.8],
            ),
            v.tube(&[[15.0, d + 9.0, 2.0, 4.2], [28.0, d + 11.0, 3.0, 3.4], [41.0, d + 13.0, 5.0, 3.6]]),
        ],
        3.0,
    );
    union(vec![body(v, half), side.mirror(), spinous], 3.0)
}

fn discs() -> Sdf {
    let between = |i: usize| {
        let (a, b) = (LEVELS[i], LEVELS[i + 1]);
        let (p, q) = (place(i), place(i + 1));
        let center = (p.at(0.0, 0.0, -a.half[2]) + q.at(0.0, 0.0, b.half[2])) / 2.0;
        let gap = p.at(0.0, 0.0, -a.half[2]).distance(q.at(0.0, 0.0, b.half[2]));
        let v = Place { center, tilt: (p.tilt + q.tilt) / 2.0, size: 1.0 };
        let [w, d, _] = b.half;
        block(center, [w, d], [w, d], 0.5 * gap + 0.8, 2.0, v.turn())
    };
    Sdf::Union((0..LEVELS.len() - 1).map(between).collect(), 0.0)
}

/// The middle of the spinal canal, as far down as so many vertebrae.
fn canal_line(radius: f32, count: usize) -> Sdf {
    let knots: Vec<Knot> = (0..count)
        .map(|i| {
            let p = place(i).at(0.0, LEVELS[i].half[1] + 8.5, 0.0);
            [p.x, p.y, p.z, radius]
        })
        .collect();
    tube(&knots)
}

/// Middle and half depth of the body of a vertebra, by its index in the column: for what is screwed into it.
pub(crate) fn vertebral_body(index: usize) -> (Vec3, f32) {
    (place(index).center, LEVELS[index].half[1])
}
