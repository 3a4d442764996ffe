//! The skull without the lower jaw: braincase of three layers, base, face.

use glam::{Mat3, Vec3};

use super::{Seeds, field, material::Material, raster::Layer};
use crate::maths;
use crate::sdf::{
    Sdf, at, block, ellipsoid, plate, quad, ring, segment, sphere, strap, tube, turned_ellipsoid, union,
};

/// Compact bone outside, spongy inside: the three layers of the braincase follow from its two surfaces.
pub(crate) const BONE: Material = Material::Bone { cortex_mm: 1.7, cortex: 1250.0, spongy: 420.0 };

/// The outside of the braincase.
pub(crate) fn cranium() -> Sdf {
    let mass = union(
        vec![
            ellipsoid(at(0.0, -27.0, 56.0), at(58.5, 62.0, 62.5)),
            ellipsoid(at(0.0, 19.0, 57.0), at(68.0, 65.0, 65.0)),
            ellipsoid(at(0.0, 36.0, 26.0), at(55.0, 49.0, 46.0)),
            ellipsoid(at(0.0, 0.0, 24.0), at(63.0, 54.0, 44.0)),
        ],
        20.0,
    );
    // The temporal fossa: behind the brow the head is narrow.
    mass.minus(ellipsoid(at(74.0, -54.0, 20.0), at(20.0, 34.0, 36.0)).mirror(), 16.0)
}

/// The inside of the braincase; uses the cranium's field.
pub(crate) fn cavity() -> Sdf {
    let inner = || Sdf::Field(field::CRANIUM).grow(-6.2);
    // Over the orbits and the tentorium, then the middle and the posterior fossa.
    let normal = at(0.0, -0.16, -0.987);
    let upper = inner().and(Sdf::HalfSpace { normal, offset: normal.dot(at(0.0, -80.0, 37.0)) }, 6.0);
    // The groove of the olfactory nerves between the orbits' roofs.
    let olfactory = ellipsoid(at(0.0, -58.0, 33.0), at(8.0, 20.0, 6.0));
    let temporal = ellipsoid(at(37.0, -17.0, 17.0), at(24.0, 31.0, 21.0)).mirror().and(inner(), 3.0);
    let posterior = ellipsoid(at(0.0, 38.0, 8.0), at(50.0, 44.0, 31.0)).and(inner(), 3.0);
    let stem = tube(&[
        [0.0, -4.0, 22.0, 13.0],
        [0.0, 8.0, 0.0, 13.0],
        [0.0, 14.0, -22.0, 14.5],
        [0.0, 16.0, -44.0, 14.0],
    ]);
    union(vec![upper, olfactory, temporal, posterior, stem], 8.0)
}

/// The cone of the orbit, from its rim to its apex.
pub(crate) fn orbit() -> Sdf {
    let apex = at(16.0, -42.0, 19.0);
    union(
        vec![
            strap(at(34.0, -88.0, 15.5), at(31.0, -76.0, 16.0), Vec3::Z, [20.5, 19.5], [17.5, 17.0]),
            segment(at(31.0, -77.0, 16.5), apex, 17.0, 4.5),
        ],
        4.0,
    )
    .mirror()
}

/// The bony nasal cavity with its pear-shaped opening.
pub(crate) fn nasal_cavity() -> Sdf {
    union(
        vec![
            block(at(0.0, -63.0, -5.0), [14.0, 24.0], [5.0, 20.0], 23.0, 5.0, Mat3::IDENTITY),
            // The opening: wide and two-lobed below, pointed above.
            ellipsoid(at(5.6, -95.0, -17.5), at(7.0, 16.0, 9.0)).mirror(),
            ellipsoid(at(0.0, -97.0, -7.5), at(6.2, 16.0, 13.5)),
        ],
        3.0,
    )
}

/// Air-filled rooms of the bone.
pub(crate) fn sinuses(noise: &Seeds) -> Sdf {
    let cells =
        (0..4).map(|i| sphere(at(8.0, -66.0 + 9.0 * i as f32, 22.0 - 1.5 * i as f32), 4.6 - 0.2 * i as f32));
    let rooms = vec![
        // Maxillary, frontal, sphenoid.
        union(
            vec![
                ellipsoid(at(29.0, -66.0, -12.0), at(11.5, 14.0, 14.0)),
                ellipsoid(at(36.0, -66.0, -6.0), at(9.0, 9.0, 7.0)),
            ],
            6.0,
        ),
        ellipsoid(at(8.0, -82.5, 37.0), at(6.5, 2.6, 6.5)),
        ellipsoid(at(8.5, -31.0, 10.0), at(7.6, 12.0, 8.5)),
    ];
    let mastoid_cells =
        ellipsoid(at(51.0, 12.0, -8.0), at(7.0, 9.0, 13.0)).rough(4.5, 5.0, noise.get("mastoid"));
    Sdf::Union(rooms.into_iter().chain(cells).chain([mastoid_cells]).collect(), 0.0).mirror()
}

pub(crate) fn layers(noise: &Seeds) -> Vec<Layer> {
    let vault = Sdf::Field(field::CRANIUM);
    let solid = union(vec![vault, base().mirror(), face().mirror(), midline()], 7.0);
    let openings = union(
        vec![
            orbit(),
            nasal_cavity(),
            segment(at(0.0, 16.0, 0.0), at(0.0, 16.0, -46.0), 15.0, 17.0),
            foramina().mirror(),
        ],
        1.0,
    );
    let bone = solid
        .minus(Sdf::Field(field::CAVITY), 1.5)
        .minus(openings, 2.0)
        .minus(sinuses(noise), 0.8)
        .minus(sutures(), 0.6)
        .rough(0.35, 6.0, noise.get("bone"));
    let thin = Material::Bone { cortex_mm: 1.4, cortex: 700.0, spongy: 400.0 };
    vec![Layer::new(bone, BONE), Layer::new(septum_and_turbinates(), thin)]
}

/// Temporal bone, occiput, sphenoid: what lies under the braincase. For x > 0.
fn base() -> Sdf {
    let occiput = vec![
        // Mastoid, its ridge, the petrous pyramid, the condyle.
        strap(at(56.0, 8.0, -2.0), at(52.0, 9.0, -27.0), Vec3::X, [13.0, 6.5], [9.0, 5.0]),
        tube(&[[65.0, -6.0, 3.0, 4.5], [64.0, 12.0, 7.0, 6.0], [57.0, 34.0, 10.0, 4.5]]),
        segment(at(54.0, 0.0, -2.0), at(16.0, -20.0, 2.0), 11.0, 8.0),
        ellipsoid(at(19.0, 8.0, -24.0), at(6.5, 11.0, 6.0)),
        // Nuchal lines.
        tube(&[[2.0, 84.0, 10.0, 4.5], [26.0, 75.0, 14.0, 3.5], [46.0, 52.0, 8.0, 3.0]]),
        tube(&[[2.0, 66.0, -10.0, 3.0], [24.0, 58.0, -10.0, 2.5], [40.0, 40.0, -12.0, 2.5]]),
        // Styloid process, the joint's socket.
        segment(at(45.0, -3.0, -16.0), at(38.0, -16.0, -46.0), 2.6, 1.1),
        ellipsoid(at(52.0, -19.0, 0.0), at(11.0, 9.0, 5.0)),
    ];
    let sphenoid = vec![
        // Clivus, greater wing, pterygoid plates.
        strap(at(4.0, -20.0, 6.0), at(4.0, -1.0, -20.0), Vec3::Y, [13.0, 10.0], [7.0, 5.0]),
        quad(
            [at(24.0, -42.0, 2.0), at(42.0, -52.0, 12.0), at(46.0, -38.0, 22.0), at(26.0, -40.0, 24.0)],
            2.6,
        ),
        quad(
            [at(16.0, -40.0, 2.0), at(21.0, -42.0, -26.0), at(24.0, -30.0, -22.0), at(22.0, -28.0, 0.0)],
            1.8,
        ),
        quad(
            [at(14.0, -38.0, 2.0), at(13.0, -41.0, -28.0), at(13.0, -30.0, -24.0), at(14.0, -28.0, 0.0)],
            1.6,
        ),
    ];
    union(occiput.into_iter().chain(sphenoid).collect(), 5.0)
}

/// The bones of the face. For x > 0.
fn face() -> Sdf {
    let rim = ring(&[
        [16.0, -85.0, 30.5, 4.4],
        [27.0, -86.5, 35.0, 4.8],
        [40.0, -82.5, 35.0, 4.8],
        [49.0, -74.0, 28.5, 4.4],
        [51.5, -66.5, 15.0, 4.4],
        [49.0, -68.5, 2.0, 4.8],
        [39.0, -76.5, -4.5, 4.8],
        [27.0, -82.0, -3.5, 4.2],
        [17.0, -84.5, 5.0, 3.2],
        [13.5, -85.0, 18.0, 3.4],
    ]);
    // The temporal line runs on from the brow over the side of the vault.
    let outer = cranium();
    let temporal_line =
        [at(50.0, -66.0, 36.0), at(52.0, -58.0, 48.0), at(54.0, -44.0, 62.0), at(56.0, -20.0, 76.0)].map(
            |p| {
                let inward = (at(0.0, -10.0, 40.0) - p).normalize();
                let p = super::face::project(&outer, p - inward * 50.0, inward) + inward * 2.4;
                [p.x, p.y, p.z, 3.0]
            },
        );
    let temporal_line = tube(&[&[[49.5, -73.0, 28.0, 4.0]], &temporal_line[..]].concat());
    let cheek = union(
        vec![
            turned_ellipsoid(at(45.5, -67.5, -9.0), at(13.0, 8.0, 12.0), maths::turn_z(0.75)),
            arch(),
            // The buttress down to the molars.
            segment(at(42.0, -68.0, -14.0), at(31.0, -62.0, -32.0), 7.0, 5.0),
        ],
        5.0,
    );
    let walls = union(
        vec![
            // Around the orbit's cone: floor, side and roof.
            segment(at(32.0, -74.0, 16.0), at(17.0, -42.0, 19.0), 20.0, 9.0),
            segment(at(46.0, -66.0, 16.0), at(37.0, -50.0, 14.0), 7.0, 6.0),
        ],
        4.0,
    );
    let maxilla = union(
        vec![
            ellipsoid(at(25.0, -68.0, -14.0), at(20.0, 19.0, 19.0)),
            ellipsoid(at(14.0, -80.0, -27.0), at(13.0, 10.0, 10.0)),
            // The margin of the nasal opening, up to the brow.
            tube(&[
                [9.0, -89.0, 26.0, 3.4],
                [9.5, -93.0, 10.0, 3.2],
                [13.5, -90.0, -4.0, 3.2],
                [15.8, -88.0, -17.0, 3.4],
                [10.0, -89.5, -27.5, 3.8],
            ]),
            // The sockets of the teeth bulge.
            tube(&[
                [0.0, -90.5, -35.4, 5.8],
                [9.0, -89.0, -35.4, 5.8],
                [17.5, -82.5, -35.4, 6.0],
                [23.0, -73.0, -35.0, 6.2],
                [27.0, -60.0, -34.5, 6.6],
                [28.5, -50.0, -33.0, 6.4],
            ]),
            segment(at(18.0, -86.5, -40.0), at(17.0, -86.0, -18.0), 4.0, 2.5),
        ],
        6.0,
    )
    .minus(ellipsoid(at(28.0, -93.0, -15.0), at(9.0, 9.0, 9.0)), 8.0);
    let nasal_bone = union(
        vec![
            strap(at(2.6, -89.5, 27.0), at(3.2, -102.0, 6.0), at(0.5, -0.86, -0.5), [5.0, 5.0], [3.0, 1.7]),
            segment(at(5.0, -91.0, 22.0), at(8.0, -95.0, 8.0), 3.4, 2.2),
        ],
        3.0,
    );
    union(vec![rim, temporal_line, cheek, walls, maxilla, nasal_bone], 5.0)
}

/// The zygomatic arch: a flat bar from the cheek to the ear.
fn arch() -> Sdf {
    let bar = |dz: f32| {
        tube(&[
            [49.0, -65.0, -9.0 + dz, 3.6],
            [57.5, -54.0, -7.5 + dz, 2.9],
            [61.5, -38.0, -5.0 + dz, 2.5],
            [63.0, -22.0, -2.0 + dz, 2.6],
            [62.0, -10.0, 1.0 + dz, 3.2],
            [56.0, -2.0, 3.0 + dz, 3.6],
        ])
    };
    union(vec![bar(1.5), bar(-2.0)], 3.0)
}

/// Glabella, nasal spine and palate.
fn midline() -> Sdf {
    let floor = ellipsoid(at(0.0, -62.0, -31.0), at(26.0, 28.0, 4.5));
    union(
        vec![
            ellipsoid(at(0.0, -85.0, 34.0), at(17.0, 7.0, 9.0)),
            floor,
            segment(at(0.0, -86.0, -29.0), at(0.0, -96.0, -27.5), 3.2, 1.3),
            // The occipital protuberance.
            ellipsoid(at(0.0, 84.0, 8.0), at(9.0, 5.0, 6.0)),
        ],
        4.0,
    )
}

/// Where nerves and vessels pass. For x > 0.
fn foramina() -> Sdf {
    Sdf::Union(
        vec![
            // Ear canal, carotid canal, jugular foramen, foramen ovale.
            tube(&[[76.0, -2.0, -1.5, 4.2], [62.0, -4.0, -1.0, 3.8], [46.0, -7.0, 0.0, 3.6]]),
            tube(&[
                [26.0, 1.0, -34.0, 3.6],
                [26.0, 0.0, -8.0, 3.6],
                [18.0, -14.0, -1.0, 3.4],
                [13.0, -22.0, 8.0, 3.4],
            ]),
            segment(at(30.0, 8.0, -34.0), at(30.0, 12.0, -6.0), 4.5, 5.0),
            segment(at(25.0, -20.0, -14.0), at(25.0, -19.0, 6.0), 2.6, 2.6),
            // Superior and inferior orbital fissures, the foramen under the eye.
            segment(at(20.0, -44.0, 20.0), at(30.0, -46.0, 26.0), 2.6, 1.4),
            segment(at(22.0, -48.0, 8.0), at(38.0, -66.0, 2.0), 2.4, 1.2),
            segment(at(28.0, -90.0, -13.0), at(30.0, -78.0, -6.0), 1.9, 1.4),
            // The notch over the eye.
            sphere(at(24.0, -92.0, 30.0), 1.8),
        ],
        0.0,
    )
}

/// Wavy seams of the vault: coronal, sagittal, lambdoid and squamous.
fn sutures() -> Sdf {
    let outer = cranium();
    let seam = |points: Vec<Vec3>| {
        let n = points.len();
        let knots: Vec<_> = points
            .iter()
            .enumerate()
            .map(|(i, &p)| {
                let along = (points[(i + 1).min(n - 1)] - points[i.saturating_sub(1)]).normalize_or_zero();
                let out = (p - at(0.0, 0.0, 40.0)).normalize();
                // Teeth of a few millimetres, of uneven length.
                let swing = if i % 2 == 0 { 1.0 } else { -1.0 } * (1.5 + 0.8 * maths::sin(i as f32 * 1.7));
                let q = p + along.cross(out) * swing;
                let q = super::face::project(&outer, q + out * 40.0, -out);
                [q.x, q.y, q.z, 0.85]
            })
            .collect();
        Sdf::Union(
            knots
                .windows(2)
                .map(|w| segment(at(w[0][0], w[0][1], w[0][2]), at(w[1][0], w[1][1], w[1][2]), 0.85, 0.85))
                .collect(),
            0.0,
        )
    };
    let sweep = |from: f32, to: f32, step: f32, f: &dyn Fn(f32) -> Vec3| -> Vec<Vec3> {
        let n = ((to - from) / step) as usize;
        (0..=n).map(|i| f(from + step * i as f32)).collect()
    };
    let center = at(0.0, 0.0, 40.0);
    let out = |d: Vec3| center + d.normalize() * 80.0;
    let coronal = seam(sweep(-1.45, 1.45, 0.045, &|a| {
        out(at(maths::sin(a), -0.22 - 0.10 * (1.0 - maths::cos(a)), maths::cos(a)))
    }));
    let sagittal = seam(sweep(-0.24, 1.25, 0.042, &|a| out(at(0.0, maths::sin(a), maths::cos(a)))));
    let lambdoid = seam(sweep(0.0, 1.0, 0.036, &|t| out(at(0.92 * t, 0.95 - 0.15 * t, 0.34 - 0.62 * t))));
    let squamous = seam(sweep(0.0, 1.0, 0.03, &|t| {
        let a = -1.2 + 2.6 * t;
        out(at(1.0, 0.08 + 0.52 * maths::sin(a), -0.42 + 0.5 * maths::cos(a)))
    }));
    Sdf::Union(vec![coronal, sagittal, lambdoid.mirror(), squamous.mirror()], 0.0)
}

/// The thin bones inside the nose.
fn septum_and_turbinates() -> Sdf {
    let septum = Sdf::Union(
        vec![
            plate(at(0.3, -94.0, -26.0), at(0.8, -98.0, 6.0), at(0.0, -44.0, 16.0), 0.8),
            plate(at(0.3, -94.0, -26.0), at(0.0, -44.0, 16.0), at(-0.4, -40.0, -26.0), 0.8),
        ],
        0.0,
    );
    let turbinate = |x: f32, z: f32, front: f32| {
        tube(&[[x, front, z, 1.0], [x - 0.5, front + 16.0, z - 1.0, 1.2], [x, -48.0, z, 1.0]])
    };
    Sdf::Union(vec![septum, turbinate(7.5, -15.0, -84.0).mirror(), turbinate(6.0, -1.0, -78.0).mirror()], 0.0)
}
