//! Muscles of the face, of chewing, of the neck and the shoulders.
//!
//! The muscles of expression lie in the fat a few millimetres under the skin, so they are cut from sheets at a fixed
//! depth; those that move bones are modelled between their origins and insertions.

use glam::Vec3;

use super::{Seeds, face, field, material::Material, raster::Layer};
use crate::maths;
use crate::sdf::{
    Knot, Sdf, at, ellipsoid, plate, quad, ribbon, segment, strap, tube, turned_ellipsoid, union,
};

/// The muscles that move bones.
pub(crate) fn layers(noise: &Seeds) -> Vec<Layer> {
    let rough = noise.get("muscle");
    let muscle = |(shape, fibres): (Sdf, Vec3)| {
        let material = Material::Muscle { fibres: fibres.normalize(), fat: 55.0 };
        Layer::new(shape.mirror().rough(0.5, 4.0, rough), material)
    };
    deep().into_iter().chain(neck()).chain(chewing()).map(muscle).collect()
}

/// The muscles that move the skin of the face; too thin for fat between their bundles.
pub(crate) fn expression_layers(skin: &Sdf) -> Vec<Layer> {
    let muscle = |(shape, fibres): (Sdf, Vec3)| {
        Layer::new(shape.mirror(), Material::Muscle { fibres: fibres.normalize(), fat: 0.0 })
    };
    expression(skin).into_iter().map(muscle).collect()
}

type Muscles = Vec<(Sdf, Vec3)>;

/// Along the spine and around the throat.
fn deep() -> Muscles {
    vec![
        // Semispinalis, splenius, the muscles under the occiput, longus colli.
        (
            tube(&[
                [13.0, 66.0, -2.0, 12.0],
                [14.0, 52.0, -50.0, 15.0],
                [15.0, 50.0, -100.0, 15.0],
                [18.0, 62.0, -150.0, 16.0],
                [20.0, 74.0, -200.0, 16.0],
            ]),
            at(0.05, 0.1, 1.0),
        ),
        (
            tube(&[
                [52.0, 26.0, -14.0, 7.0],
                [38.0, 40.0, -50.0, 10.0],
                [20.0, 62.0, -100.0, 9.0],
                [10.0, 78.0, -150.0, 6.0],
            ]),
            at(0.4, -0.35, 0.9),
        ),
        (tube(&[[24.0, 52.0, -18.0, 8.0], [12.0, 46.0, -50.0, 8.0]]), at(0.3, 0.2, 0.9)),
        (
            tube(&[
                [9.0, -4.0, -40.0, 4.5],
                [10.0, -6.0, -90.0, 5.0],
                [12.0, 2.0, -140.0, 5.0],
                [12.0, 20.0, -190.0, 5.0],
            ]),
            Vec3::Z,
        ),
        // Levator scapulae, the scalenes.
        (
            tube(&[
                [34.0, 14.0, -44.0, 5.0],
                [44.0, 34.0, -95.0, 7.5],
                [62.0, 64.0, -150.0, 8.0],
                [76.0, 82.0, -190.0, 7.0],
            ]),
            at(-0.25, -0.4, 1.0),
        ),
        (
            tube(&[[24.0, 4.0, -76.0, 4.0], [32.0, 4.0, -115.0, 6.0], [44.0, 0.0, -164.0, 6.0]]),
            at(-0.2, 0.0, 1.0),
        ),
        (
            tube(&[[26.0, 14.0, -80.0, 5.0], [38.0, 20.0, -120.0, 8.0], [56.0, 26.0, -170.0, 8.0]]),
            at(-0.3, -0.1, 1.0),
        ),
        // The pharynx's wall.
        (
            strap(at(0.1, -9.0, -24.0), at(0.1, -8.0, -122.0), Vec3::Y, [19.0, 15.0], [8.0, 6.0]),
            at(1.0, 0.2, 0.4),
        ),
    ]
}

/// What is seen on the neck and the shoulders when skin and fat are taken off.
fn neck() -> Muscles {
    let out = at(0.75, -0.62, 0.1);
    let sternomastoid = |end: [Knot; 2]| {
        let mut knots = vec![[56.0, 11.0, -22.0, 8.0], [55.0, 8.0, -46.0, 10.0], [49.0, -2.0, -84.0, 12.0]];
        knots.extend(end);
        ribbon(&knots, out, 0.52)
    };
    vec![
        // Trapezius: from the occiput down to the spines and out to the shoulder.
        (
            union(
                vec![
                    ribbon(
                        &[
                            [9.0, 78.0, 6.0, 8.0],
                            [13.0, 70.0, -40.0, 11.0],
                            [22.0, 72.0, -90.0, 16.0],
                            [34.0, 78.0, -130.0, 22.0],
                        ],
                        at(0.3, 0.95, 0.1),
                        0.3,
                    ),
                    quad(
                        [
                            at(8.0, 76.0, -60.0),
                            at(10.0, 92.0, -190.0),
                            at(120.0, 70.0, -172.0),
                            at(44.0, 62.0, -112.0),
                        ],
                        5.0,
                    ),
                    ribbon(
                        &[
                            [36.0, 58.0, -96.0, 12.0],
                            [60.0, 52.0, -132.0, 15.0],
                            [100.0, 44.0, -154.0, 14.0],
                            [150.0, 34.0, -158.0, 10.0],
                        ],
                        at(0.4, 0.2, 0.9),
                        0.55,
                    ),
                ],
                8.0,
            ),
            at(0.55, 0.1, -0.8),
        ),
        // Sternocleidomastoid: one belly, two heads.
        (
            union(
                vec![
                    sternomastoid([[30.0, -24.0, -134.0, 8.5], [12.0, -36.0, -178.0, 4.5]]),
                    sternomastoid([[40.0, -20.0, -134.0, 9.0], [42.0, -30.0, -170.0, 8.0]]),
                ],
                3.0,
            ),
            at(0.35, 0.35, 0.87),
        ),
        // Sternohyoid, omohyoid, thyrohyoid.
        (
            ribbon(
                &[[7.0, -35.0, -91.0, 5.0], [9.0, -38.0, -118.0, 6.0], [10.0, -36.0, -182.0, 6.5]],
                at(0.25, -1.0, 0.1),
                0.34,
            ),
            Vec3::Z,
        ),
        (
            ribbon(
                &[
                    [13.0, -33.0, -91.0, 4.0],
                    [20.0, -30.0, -120.0, 4.6],
                    [38.0, -16.0, -150.0, 3.6],
                    [80.0, 22.0, -158.0, 4.0],
                ],
                at(0.5, -0.8, 0.2),
                0.45,
            ),
            at(-0.4, -0.2, 0.9),
        ),
        // Digastric and mylohyoid make the floor of the mouth, stylohyoid hangs it up.
        (
            tube(&[
                [8.0, -78.0, -91.0, 4.4],
                [11.0, -58.0, -94.0, 5.4],
                [20.0, -36.0, -88.0, 2.4],
                [36.0, -14.0, -64.0, 4.4],
                [50.0, 9.0, -24.0, 4.0],
            ]),
            at(0.4, 0.6, 0.4),
        ),
        (plate(at(0.0, -74.0, -84.0), at(0.0, -36.0, -88.0), at(34.0, -40.0, -72.0), 2.4), at(0.7, 0.5, 0.1)),
        // Deltoid, pectoralis, the muscles of the shoulder blade.
        (ellipsoid(at(152.0, 26.0, -196.0), at(34.0, 40.0, 42.0)), at(0.3, 0.0, -1.0)),
        (
            turned_ellipsoid(at(70.0, -26.0, -208.0), at(72.0, 15.0, 34.0), maths::turn_z(0.25)),
            at(1.0, 0.2, 0.5),
        ),
        (
            tube(&[[76.0, 78.0, -178.0, 10.0], [110.0, 62.0, -170.0, 12.0], [140.0, 38.0, -168.0, 8.0]]),
            at(1.0, -0.4, 0.1),
        ),
        (tube(&[[50.0, 70.0, -170.0, 16.0], [60.0, 78.0, -210.0, 20.0]]), at(0.2, 0.0, 1.0)),
    ]
}

/// Temporalis, masseter, pterygoids, buccinator, tongue.
fn chewing() -> Muscles {
    let temporal_fossa = turned_ellipsoid(at(66.0, -22.0, 34.0), at(26.0, 50.0, 42.0), maths::turn_x(0.25));
    vec![
        (
            union(
                vec![
                    Sdf::Field(field::CRANIUM).grow(5.0).and(temporal_fossa, 6.0),
                    ribbon(
                        &[[58.0, -42.0, 22.0, 14.0], [55.0, -42.0, 2.0, 9.0], [47.0, -40.0, -14.0, 4.0]],
                        Vec3::X,
                        0.5,
                    ),
                ],
                5.0,
            ),
            at(0.1, -0.35, -1.0),
        ),
        (
            union(
                vec![
                    ribbon(
                        &[[58.5, -48.0, -10.0, 13.0], [57.0, -38.0, -34.0, 15.0], [51.0, -26.0, -62.0, 12.0]],
                        at(0.95, -0.25, 0.15),
                        0.48,
                    ),
                    ribbon(&[[60.0, -28.0, -8.0, 10.0], [55.0, -24.0, -34.0, 9.0]], Vec3::X, 0.5),
                ],
                3.0,
            ),
            at(0.12, -0.4, 0.9),
        ),
        (
            ribbon(
                &[[20.0, -36.0, -8.0, 7.0], [32.0, -30.0, -34.0, 9.0], [42.0, -22.0, -60.0, 7.0]],
                at(0.8, -0.4, 0.3),
                0.6,
            ),
            at(0.4, 0.2, -0.9),
        ),
        (tube(&[[24.0, -40.0, -6.0, 8.0], [46.0, -18.0, -10.0, 5.0]]), at(0.7, 0.7, 0.0)),
        (
            quad(
                [
                    at(36.0, -64.0, -34.0),
                    at(34.0, -42.0, -30.0),
                    at(36.0, -42.0, -62.0),
                    at(32.0, -70.0, -62.0),
                ],
                1.8,
            ),
            at(0.1, 1.0, 0.0),
        ),
        // The tongue fills the mouth.
        (
            union(
                vec![
                    ellipsoid(at(0.0, -60.0, -50.0), at(21.0, 27.0, 15.0)),
                    ellipsoid(at(0.0, -38.0, -62.0), at(19.0, 20.0, 25.0)),
                    ellipsoid(at(0.0, -56.0, -74.0), at(14.0, 22.0, 14.0)),
                ],
                8.0,
            ),
            at(0.1, 0.6, 0.8),
        ),
    ]
}

/// The muscles that move the skin of the face, in a sheet under it.
fn expression(skin: &Sdf) -> Muscles {
    let sheet = |depth: f32, half: f32| Sdf::Field(field::SKIN).grow(-depth).sheet(half);
    // A band of half width `w` along points (x, z) of the face.
    let band = |points: &[[f32; 3]]| {
        let knots: Vec<Knot> = points
            .iter()
            .map(|&[x, z, w]| {
                let p = face::project(skin, at(x, -170.0, z), Vec3::Y);
                [p.x, p.y + 3.0, p.z, w]
            })
            .collect();
        tube(&knots)
    };
    let eye = strap(at(32.0, -110.0, 14.0), at(34.0, -60.0, 14.0), Vec3::Z, [28.0, 28.0], [22.0, 22.0]);
    let lids = strap(at(32.0, -110.0, 12.5), at(34.0, -60.0, 12.5), Vec3::Z, [14.0, 14.0], [3.0, 3.0]);
    let mouth = strap(at(0.0, -120.0, -48.0), at(0.0, -70.0, -48.0), Vec3::Z, [34.0, 34.0], [20.0, 20.0]);
    let lips = strap(at(0.0, -120.0, -48.5), at(0.0, -70.0, -48.5), Vec3::Z, [26.0, 26.0], [2.0, 2.0]);
    let forehead = ellipsoid(at(27.0, -88.0, 58.0), at(25.0, 26.0, 33.0));
    let back_of_head = ellipsoid(at(34.0, 84.0, 28.0), at(28.0, 24.0, 24.0));
    let scalp = || Sdf::Field(field::CRANIUM).grow(2.4).sheet(1.4);
    let depth = 3.5;
    vec![
        (scalp().and(forehead, 2.0), Vec3::Z),
        (scalp().and(back_of_head, 2.0), Vec3::Z),
        (sheet(depth, 1.2).and(eye, 1.0).minus(lids, 1.0), at(1.0, 0.3, 0.1)),
        (sheet(depth + 0.6, 2.0).and(mouth, 2.0).minus(lips, 1.0), at(1.0, 0.3, 0.0)),
        // Zygomaticus major and minor, levators, risorius, depressors, mentalis, nasalis, corrugator.
        (
            sheet(depth, 1.3).and(band(&[[52.0, -8.0, 4.5], [42.0, -28.0, 4.5], [31.0, -46.0, 4.0]]), 1.0),
            at(-0.5, -0.3, -0.8),
        ),
        (
            sheet(depth, 1.3).and(band(&[[43.0, -3.0, 3.4], [33.0, -22.0, 3.4], [22.0, -38.0, 3.0]]), 1.0),
            at(-0.5, -0.3, -0.8),
        ),
        (
            sheet(depth, 1.3).and(band(&[[29.0, -1.0, 6.0], [24.0, -18.0, 5.0], [17.0, -37.0, 4.0]]), 1.0),
            at(-0.3, -0.2, -0.9),
        ),
        (
            sheet(depth, 1.3).and(band(&[[11.0, 10.0, 3.0], [15.0, -8.0, 3.0], [16.0, -30.0, 3.0]]), 1.0),
            at(0.1, -0.1, -1.0),
        ),
        (
            sheet(depth, 1.3).and(band(&[[56.0, -46.0, 4.0], [44.0, -49.0, 4.0], [31.0, -49.0, 3.5]]), 1.0),
            at(-1.0, -0.4, 0.0),
        ),
        (
            sheet(depth, 1.3).and(band(&[[29.0, -51.0, 3.6], [28.0, -66.0, 5.6], [25.0, -84.0, 7.5]]), 1.0),
            at(-0.1, 0.1, -1.0),
        ),
        (sheet(depth, 1.3).and(band(&[[12.0, -60.0, 6.0], [20.0, -82.0, 7.0]]), 1.0), at(0.4, 0.1, -1.0)),
        (sheet(depth + 0.8, 2.2).and(band(&[[5.0, -72.0, 5.0], [6.0, -86.0, 6.0]]), 1.0), at(0.1, 0.1, -1.0)),
        (
            sheet(3.5, 1.2).and(band(&[[2.0, 4.0, 5.0], [9.0, -4.0, 5.0], [15.0, -14.0, 4.0]]), 1.0),
            at(0.7, 0.2, -0.6),
        ),
        (
            sheet(depth, 1.3).and(band(&[[6.0, 24.0, 4.0], [14.0, 33.0, 3.6], [27.0, 38.0, 3.0]]), 1.0),
            at(0.8, 0.2, 0.5),
        ),
        // Auricular muscles.
        (segment(at(70.0, 10.0, 2.0), at(66.0, 28.0, 6.0), 3.0, 2.0), at(0.0, 1.0, 0.1)),
    ]
}
