//! Vertebrae, discs, ribs, clavicles, breast bone, shoulder blades and the hyoid.

use glam::{Mat3, Vec3};

use super::{Seeds, material::Material, raster::Layer};
use crate::maths;
use crate::sdf::{Knot, Sdf, at, block, ellipsoid, quad, ring, segment, strap, tube, union};

const BONE: Material = Material::Bone { cortex_mm: 1.2, cortex: 1000.0, spongy: 300.0 };

/// A vertebra's place: centre of the body, forward tilt in radians, size relative to C4.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub center: Vec3,
    pub tilt: f32,
    pub size: f32,
}

/// C3 to T4.
const COLUMN: [Place; 9] = [
    Place { center: at(0.0, 8.0, -74.0), tilt: 0.12, size: 0.98 },
    Place { center: at(0.0, 7.0, -90.5), tilt: 0.06, size: 1.0 },
    Place { center: at(0.0, 8.0, -107.0), tilt: -0.04, size: 1.02 },
    Place { center: at(0.0, 11.5, -123.5), tilt: -0.16, size: 1.06 },
    Place { center: at(0.0, 17.0, -140.0), tilt: -0.28, size: 1.12 },
    Place { center: at(0.0, 24.5, -157.0), tilt: -0.38, size: 1.18 },
    Place { center: at(0.0, 32.5, -175.0), tilt: -0.40, size: 1.22 },
    Place { center: at(0.0, 40.0, -194.0), tilt: -0.36, size: 1.26 },
    Place { center: at(0.0, 46.0, -213.0), tilt: -0.3, size: 1.3 },
];

/// The first of `COLUMN` that carries ribs.
const FIRST_THORACIC: usize = 5;

pub(crate) fn layers(noise: &Seeds) -> Vec<Layer> {
    let mut bones = vec![atlas(), axis()];
    bones.extend(COLUMN.iter().enumerate().map(|(i, place)| vertebra(*place, i)));
    let rough = |bones: Vec<Sdf>, k: f32| union(bones, k).rough(0.35, 5.0, noise.get("spine"));
    let compact = Material::Bone { cortex_mm: 2.0, cortex: 1150.0, spongy: 320.0 };
    vec![
        Layer::new(discs(), Material::even(85.0, 12.0, 4.0)),
        Layer::new(canal(), Material::even(5.0, 3.0, 4.0)),
        Layer::new(cord(), Material::even(38.0, 3.0, 4.0)),
        Layer::new(rough(bones, 0.6), BONE),
        Layer::new(rough(girdle(), 1.5), compact),
        Layer::new(hyoid(), BONE),
    ]
}

impl Place {
    pub(crate) fn turn(&self) -> Mat3 {
        maths::turn_x(-self.tilt)
    }

    /// Patient space from the vertebra's own.
    pub(crate) fn at(&self, x: f32, y: f32, z: f32) -> Vec3 {
        self.center + self.turn() * at(x, y, z) * self.size
    }

    pub(crate) fn tube(&self, knots: &[Knot]) -> Sdf {
        let placed: Vec<Knot> = knots
            .iter()
            .map(|&[x, y, z, r]| {
                let p = self.at(x, y, z);
                [p.x, p.y, p.z, r * self.size]
            })
            .collect();
        tube(&placed)
    }
}

fn vertebra(v: Place, index: usize) -> Sdf {
    let s = v.size;
    let thoracic = index >= FIRST_THORACIC;
    let body = block(v.center, [12.5 * s, 8.5 * s], [11.5 * s, 8.0 * s], 6.3 * s, 2.5, v.turn());
    let uncus = v.tube(&[[10.5, -3.0, 6.0, 1.8], [11.5, 2.0, 7.5, 2.2], [10.5, 6.0, 6.5, 1.8]]).mirror();
    let waist = v.tube(&[[-11.0, -9.5, 0.0, 2.2], [0.0, -12.0, 0.0, 2.6], [11.0, -9.5, 0.0, 2.2]]);
    let arch = union(
        vec![
            v.tube(&[[9.0, 6.0, 1.0, 3.2], [14.0, 13.0, 1.0, 3.4], [13.5, 19.0, 0.0, 4.0]]),
            // Joint pillar and lamina.
            segment(v.at(14.5, 14.0, 8.0), v.at(15.0, 20.0, -8.0), 4.4 * s, 4.6 * s),
            strap(
                v.at(13.0, 20.0, 0.0),
                v.at(2.0, 28.0, -3.0),
                at(0.5, -1.0, 0.25),
                [5.5 * s, 5.5 * s],
                [2.4 * s, 2.4 * s],
            ),
        ],
        3.0,
    );
    let transverse = if thoracic {
        v.tube(&[[13.0, 15.0, 2.0, 4.6], [22.0, 20.0, 4.0, 4.0], [31.0, 24.0, 5.0, 4.6]])
    } else {
        // Two roots around the vertebral artery.
        union(
            vec![
                v.tube(&[[10.0, -2.0, 0.0, 2.4], [16.5, -2.5, -1.0, 2.4], [21.5, 1.0, -3.0, 2.8]]),
                v.tube(&[[13.0, 12.0, 0.0, 2.6], [18.5, 9.0, -2.0, 2.4], [22.0, 4.5, -3.5, 2.8]]),
            ],
            2.0,
        )
    };
    let length = [10.0, 10.5, 12.5, 17.0, 27.0, 30.0, 30.0, 30.0, 30.0][index];
    let drop = if thoracic { 0.75 } else { 0.4 };
    let spine = if index < 4 {
        // Bifid: two tips.
        let tip = v.tube(&[
            [0.0, 28.0, -2.0, 3.6],
            [0.5, 28.0 + 0.6 * length, -2.0 - drop * 0.6 * length, 2.6],
            [4.0, 28.0 + length, -3.0 - drop * length, 2.4],
        ]);
        tip.mirror()
    } else {
        v.tube(&[
            [0.0, 28.0, -2.0, 3.8],
            [0.0, 28.0 + 0.6 * length, -2.0 - drop * 0.6 * length, 2.8],
            [0.0, 28.0 + length, -2.0 - drop * length, 4.0],
        ])
    };
    union(vec![body.minus(waist, 3.0).or(uncus, 1.5), arch.mirror(), transverse.mirror(), spine], 3.0)
}

/// C1: a ring.
fn atlas() -> Sdf {
    let z = -36.0;
    let hoop = ring(&[
        [0.0, -7.0, z, 4.2],
        [14.0, -3.0, z, 4.2],
        [21.0, 9.0, z, 4.4],
        [17.0, 28.0, z - 1.0, 3.4],
        [0.0, 38.0, z - 2.0, 3.8],
        [-17.0, 28.0, z - 1.0, 3.4],
        [-21.0, 9.0, z, 4.4],
        [-14.0, -3.0, z, 4.2],
    ]);
    let mass = union(
        vec![
            block(at(20.0, 9.0, z + 0.5), [8.0, 9.5], [7.5, 10.5], 6.5, 3.0, Mat3::IDENTITY),
            tube(&[[24.0, 7.0, z, 4.0], [32.0, 8.0, z - 1.0, 3.2], [40.0, 11.0, z - 2.0, 4.4]]),
        ],
        3.0,
    )
    .minus(segment(at(30.5, 9.5, z - 20.0), at(30.5, 9.5, z + 20.0), 3.0, 3.0), 1.5)
    .minus(ellipsoid(at(19.5, 9.0, z + 12.5), at(7.0, 11.0, 5.5)), 2.0);
    union(vec![hoop, mass.mirror()], 3.0)
}

/// C2: a body with a tooth, around which the head turns.
fn axis() -> Sdf {
    let v = Place { center: at(0.0, 8.0, -57.0), tilt: 0.1, size: 1.02 };
    let side = union(
        vec![
            block(at(16.0, 8.5, -47.5), [8.0, 8.0], [7.5, 8.5], 4.5, 2.5, maths::turn_y(0.3)),
            v.tube(&[[12.0, 4.0, 2.0, 4.2], [15.0, 14.0, -3.0, 4.4], [13.0, 20.0, -6.0, 4.4]]),
            strap(v.at(13.0, 19.0, -4.0), v.at(2.0, 30.0, -5.0), at(0.5, -1.0, 0.4), [7.5, 8.0], [3.0, 3.4]),
            v.tube(&[[14.0, 4.0, 0.0, 3.2], [22.0, 5.0, -4.0, 3.4]]),
            v.tube(&[[1.0, 29.0, -3.0, 5.0], [1.5, 38.0, -6.0, 4.4], [5.5, 43.0, -9.0, 3.4]]),
        ],
        3.0,
    );
    union(
        vec![
            block(v.center, [11.5, 8.5], [9.0, 7.5], 9.0, 2.5, v.turn()),
            tube(&[
                [0.0, 7.0, -50.0, 5.6],
                [0.0, 4.0, -40.0, 4.4],
                [0.0, 4.0, -31.0, 4.2],
                [0.0, 5.5, -26.0, 2.4],
            ]),
            side.mirror(),
        ],
        3.0,
    )
}

fn discs() -> Sdf {
    let first = Place { center: at(0.0, 8.0, -66.0), tilt: 0.1, size: 0.95 };
    let between = COLUMN.windows(2).map(|w| Place {
        center: (w[0].center + w[1].center) / 2.0,
        tilt: (w[0].tilt + w[1].tilt) / 2.0,
        size: w[1].size,
    });
    let disc = |v: Place| {
        block(v.center, [12.0 * v.size, 8.6 * v.size], [12.0 * v.size, 8.6 * v.size], 3.2, 2.4, v.turn())
    };
    Sdf::Union([first].into_iter().chain(between).map(disc).collect(), 0.0)
}

/// The line of the spinal cord, with a radius.
fn canal_line(radius: f32) -> Sdf {
    let mut knots: Vec<Knot> =
        vec![[0.0, 15.0, -18.0, radius], [0.0, 20.0, -40.0, radius], [0.0, 22.0, -57.0, radius]];
    knots.extend(COLUMN.iter().map(|v| {
        let p = v.at(0.0, 17.0, 0.0);
        [p.x, p.y, p.z, radius]
    }));
    tube(&knots)
}

fn canal() -> Sdf {
    canal_line(7.6)
}

fn cord() -> Sdf {
    canal_line(4.6)
}

/// First ribs, clavicles, breast bone and shoulder blades.
fn girdle() -> Vec<Sdf> {
    let rib = |place: Place, reach: f32, fall: f32, r: f32| {
        let (a, b) = (place.at(12.0, 12.0, 4.0), place.at(32.0, 21.0, 3.0));
        let upper = [
            [a.x, a.y, a.z, 3.6],
            [b.x, b.y, b.z, 3.6],
            [b.x + 0.55 * reach, b.y - 8.0, b.z - 0.1 * fall, r],
            [b.x + 0.8 * reach, b.y - 34.0, b.z - 0.4 * fall, r],
            [b.x + 0.55 * reach, b.y - 62.0, b.z - 0.75 * fall, r],
            [b.x - 0.35 * reach, b.y - 80.0, b.z - fall, r],
        ];
        let mut lower = upper;
        for knot in lower.iter_mut().skip(2) {
            knot[0] += 2.5;
            knot[2] -= 3.0;
        }
        union(vec![tube(&upper), tube(&lower)], 2.5).mirror()
    };
    let clavicle = tube(&[
        [15.0, -28.0, -181.0, 8.0],
        [30.0, -31.0, -176.0, 6.2],
        [58.0, -29.0, -168.0, 5.4],
        [88.0, -10.0, -162.0, 5.4],
        [112.0, 12.0, -159.0, 5.8],
        [138.0, 22.0, -157.0, 6.4],
        [152.0, 22.0, -158.0, 7.0],
    ]);
    let scapula = union(
        vec![
            tube(&[
                [74.0, 92.0, -184.0, 4.0],
                [100.0, 84.0, -174.0, 4.6],
                [130.0, 64.0, -164.0, 5.6],
                [154.0, 40.0, -160.0, 7.0],
            ]),
            quad(
                [
                    at(66.0, 92.0, -186.0),
                    at(70.0, 84.0, -168.0),
                    at(104.0, 66.0, -170.0),
                    at(110.0, 66.0, -210.0),
                ],
                2.0,
            ),
            tube(&[[118.0, 50.0, -172.0, 6.0], [124.0, 30.0, -168.0, 5.0], [134.0, 22.0, -176.0, 4.6]]),
        ],
        3.0,
    );
    let manubrium = block(at(0.0, -32.0, -196.0), [20.0, 5.5], [25.0, 6.5], 18.0, 4.0, maths::turn_x(0.25))
        .minus(segment(at(0.0, -60.0, -174.0), at(0.0, 0.0, -174.0), 9.0, 9.0), 4.0);
    vec![
        rib(COLUMN[FIRST_THORACIC], 26.0, 26.0, 3.6),
        rib(COLUMN[FIRST_THORACIC + 1], 44.0, 40.0, 3.6),
        rib(COLUMN[FIRST_THORACIC + 2], 58.0, 48.0, 3.8),
        clavicle.mirror(),
        scapula.mirror(),
        manubrium,
    ]
}

fn hyoid() -> Sdf {
    union(
        vec![
            strap(at(-8.0, -33.0, -88.0), at(8.0, -33.0, -88.0), Vec3::Y, [4.6, 4.6], [2.6, 2.6]),
            tube(&[[8.0, -33.0, -88.0, 2.8], [17.0, -24.0, -86.0, 2.0], [23.0, -8.0, -82.0, 1.9]]).mirror(),
        ],
        2.0,
    )
}
