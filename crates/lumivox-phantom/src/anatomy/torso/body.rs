//! The trunk's outlines: skin, rib cage, and the domes of the diaphragm; the breasts.

use glam::Vec3;

use super::{Arms, Stuff, part::TorsoPart};
use crate::maths;
use crate::{
    anatomy::{material::Material, raster::Layer},
    loft::{Loft, section},
    sdf::{Sdf, at, ellipsoid, segment, sphere, tube, turned_ellipsoid, union},
};

/// The inside of the rib cage, and below it that of the belly's wall.
pub(crate) fn cage() -> Loft {
    Loft::new(&[
        section(-264.0, 132.0, 0.0, -84.0, 76.0),
        section(-212.0, 126.0, 2.0, -86.0, 76.0),
        section(-180.0, 120.0, 4.0, -88.0, 74.0),
        section(-140.0, 119.0, 6.0, -87.0, 77.0),
        section(-100.0, 123.0, 8.0, -85.0, 82.0),
        section(-60.0, 129.0, 10.0, -86.0, 86.0),
        section(-20.0, 132.0, 10.0, -86.0, 90.0),
        section(20.0, 130.0, 10.0, -83.0, 91.0),
        section(60.0, 122.0, 10.0, -77.0, 90.0),
        section(100.0, 107.0, 12.0, -63.0, 84.0),
        section(130.0, 88.0, 17.0, -43.0, 76.0),
        section(150.0, 68.0, 22.0, -20.0, 67.0),
        section(165.0, 47.0, 26.0, 0.0, 58.0),
        section(174.0, 24.0, 28.0, 14.0, 44.0),
    ])
}

/// Everything inside the skin.
pub(crate) fn skin(arms: Arms, breasts: bool) -> Sdf {
    let trunk = Sdf::Loft(Loft::new(&[
        section(-260.0, 162.0, 5.0, -106.0, 98.0),
        section(-212.0, 154.0, 5.0, -107.0, 100.0),
        section(-170.0, 148.0, 5.0, -106.0, 101.0),
        section(-130.0, 147.0, 5.0, -105.0, 104.0),
        section(-90.0, 152.0, 6.0, -105.0, 108.0),
        section(-50.0, 158.0, 7.0, -106.0, 111.0),
        section(-10.0, 163.0, 8.0, -107.0, 113.0),
        section(30.0, 165.0, 10.0, -106.0, 115.0),
        section(70.0, 162.0, 12.0, -100.0, 116.0),
        section(105.0, 152.0, 14.0, -87.0, 113.0),
        section(135.0, 132.0, 18.0, -68.0, 107.0),
        section(160.0, 104.0, 22.0, -46.0, 98.0),
        section(182.0, 66.0, 24.0, -36.0, 88.0),
        section(205.0, 58.0, 20.0, -39.0, 80.0),
        section(260.0, 56.0, 12.0, -46.0, 68.0),
    ]));
    let (shoulder, arm) = match arms {
        Arms::Raised => (
            union(
                vec![
                    segment(at(44.0, 46.0, 178.0), at(128.0, 34.0, 166.0), 30.0, 32.0),
                    ellipsoid(at(150.0, 16.0, 154.0), at(42.0, 48.0, 50.0)),
                ],
                20.0,
            ),
            segment(at(152.0, 16.0, 165.0), at(192.0, 4.0, 268.0), 46.0, 46.0),
        ),
        Arms::AtSides => (
            union(
                vec![
                    segment(at(44.0, 46.0, 182.0), at(138.0, 30.0, 154.0), 28.0, 26.0),
                    ellipsoid(at(162.0, 16.0, 138.0), at(42.0, 47.0, 52.0)),
                ],
                22.0,
            ),
            union(
                vec![
                    tube(&[
                        [172.0, 16.0, 132.0, 46.0],
                        [196.0, 20.0, 30.0, 45.0],
                        [212.0, 26.0, -90.0, 37.0],
                    ]),
                    tube(&[
                        [212.0, 26.0, -90.0, 38.0],
                        [217.0, 18.0, -130.0, 39.0],
                        [222.0, -6.0, -260.0, 28.0],
                    ]),
                ],
                10.0,
            ),
        ),
    };
    // Chest muscles, the furrow between them, the groove of the back, the straight muscles' and the navel.
    let pectoral = turned_ellipsoid(at(74.0, -76.0, 66.0), at(64.0, 25.0, 42.0), maths::turn_z(0.42));
    let lat = ellipsoid(at(128.0, 42.0, 60.0), at(34.0, 44.0, 70.0));
    let blade = union(
        vec![
            ellipsoid(at(88.0, 68.0, 90.0), at(50.0, 44.0, 74.0)),
            segment(at(78.0, 66.0, 144.0), at(132.0, 40.0, 160.0), 32.0, 30.0),
        ],
        16.0,
    );
    let groove = tube(&[
        [0.0, 137.0, 110.0, 15.0],
        [0.0, 139.0, 40.0, 17.0],
        [0.0, 134.0, -40.0, 18.0],
        [0.0, 125.0, -120.0, 19.0],
        [0.0, 120.0, -220.0, 19.0],
    ]);
    let alba = tube(&[
        [0.0, -120.0, 70.0, 10.0],
        [0.0, -118.0, -20.0, 11.5],
        [0.0, -115.5, -100.0, 11.0],
        [0.0, -116.0, -176.0, 10.0],
    ]);
    let clavicles = tube(&[
        [18.0, -38.0, 152.0, 11.0],
        [50.0, -42.0, 159.0, 10.0],
        [95.0, -22.0, 168.0, 10.0],
        [140.0, 12.0, 175.0, 11.0],
    ]);
    let mastoid = tube(&[[14.0, -42.0, 156.0, 8.0], [24.0, -28.0, 185.0, 11.0], [36.0, -8.0, 225.0, 12.0]]);
    let notch = sphere(at(0.0, -62.0, 168.0), 17.0);
    let fossa = ellipsoid(at(66.0, -28.0, 190.0), at(26.0, 17.0, 12.0)).mirror();
    let body = union(
        vec![
            trunk,
            shoulder.mirror(),
            pectoral.mirror(),
            lat.mirror(),
            blade.mirror(),
            clavicles.mirror(),
            mastoid.mirror(),
        ],
        20.0,
    );
    // The armpit's fold stays a fold.
    let mut body = body.or(arm.mirror(), 12.0);
    if breasts {
        body = body.or(breast().mirror(), 16.0);
    }
    let nipple = if breasts { at(90.0, -130.0, 22.0) } else { at(88.0, -103.0, 44.0) };
    body.minus(groove, 14.0)
        .minus(alba, 12.0)
        .minus(notch, 10.0)
        .minus(fossa, 12.0)
        .minus(segment(at(0.0, -116.0, -186.0), at(0.0, -98.0, -184.0), 5.5, 4.0), 8.0)
        .or(segment(nipple, nipple + at(1.0, -4.0, 0.0), 3.6, 3.0).mirror(), 3.0)
}

/// A breast of somebody who lies on her back.
fn breast() -> Sdf {
    union(
        vec![
            ellipsoid(at(86.0, -88.0, 26.0), at(60.0, 40.0, 55.0)),
            ellipsoid(at(98.0, -82.0, 12.0), at(56.0, 38.0, 46.0)),
            segment(at(90.0, -120.0, 22.0), at(90.0, -125.0, 22.0), 10.0, 8.0),
        ],
        14.0,
    )
}

/// The domes of the diaphragm, and all of the belly below them.
pub(crate) fn belly() -> Sdf {
    let tilt = maths::turn_x(-0.20);
    let low = at(0.0, -0.36, -0.93).normalize();
    union(
        vec![
            turned_ellipsoid(at(-64.0, -4.0, -92.0), at(66.0, 82.0, 90.0), tilt),
            turned_ellipsoid(at(66.0, -4.0, -102.0), at(62.0, 80.0, 84.0), tilt),
            ellipsoid(at(8.0, -26.0, -70.0), at(56.0, 56.0, 56.0)),
            // Lungs end where the diaphragm rises from the ribs: higher in front than behind.
            Sdf::HalfSpace { normal: -low, offset: -low.dot(at(0.0, 0.0, -72.0)) },
        ],
        14.0,
    )
}

/// Skin, the fat under it and the fat between the organs, from the outside to the inside.
pub(crate) fn layers(stuff: &Stuff, breasts: bool) -> Vec<Layer> {
    let skin = || Sdf::Field(super::field::SKIN);
    let mut layers = vec![
        stuff.layer(
            TorsoPart::Skin,
            skin().rough(0.12, 3.0, stuff.seed("pores")),
            Material::even(-15.0, 6.0, 3.0),
        ),
        stuff.layer(TorsoPart::Fat, skin().grow(-2.0), Material::even(-101.0, 12.0, 6.0)),
    ];
    if breasts {
        // Ducts and lobes spread from the nipple into the fat.
        let lobes = (0..9).map(|i| {
            let turn = i as f32 * 0.7;
            let end = at(
                96.0 + 30.0 * maths::cos(turn),
                -96.0 + 4.0 * maths::sin(turn * 2.3),
                23.0 + 30.0 * maths::sin(turn),
            );
            tube(&[
                [90.0, -126.0, 22.0, 1.6],
                [91.0 + 10.0 * maths::cos(turn), -115.0, 22.0 + 10.0 * maths::sin(turn), 4.5],
                [end.x, end.y - 6.0, end.z, 8.5],
                [end.x + 6.0 * maths::cos(turn), end.y, end.z + 6.0 * maths::sin(turn), 4.0],
            ])
        });
        let gland = union(lobes.collect(), 5.0).mirror().rough(2.2, 7.0, stuff.seed("gland"));
        layers.push(stuff.layer(
            TorsoPart::Gland,
            stuff.under_skin(gland, 5.0),
            Material::even(32.0, 14.0, 5.0),
        ));
    }
    layers
}

/// Moves a point along a shape's slope until it lies `lift` mm outside of it.
pub(crate) fn onto(shape: &Sdf, p: Vec3, lift: f32) -> Vec3 {
    let d = |q: Vec3| shape.distance(q, &[]);
    let e = 0.5;
    let mut p = p;
    for _ in 0..12 {
        let slope = Vec3::new(
            d(p + Vec3::X * e) - d(p - Vec3::X * e),
            d(p + Vec3::Y * e) - d(p - Vec3::Y * e),
            d(p + Vec3::Z * e) - d(p - Vec3::Z * e),
        );
        p -= slope.normalize_or(Vec3::NEG_Y) * (d(p) - lift);
    }
    p
}
