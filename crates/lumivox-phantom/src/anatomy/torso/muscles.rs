//! Muscles of chest, back, shoulder, belly and neck. Thin fat parts them from each other.

use glam::Vec3;

use super::{
    Arms, Stuff,
    drape::{drape, lay},
    field, girdle,
    part::TorsoPart,
};
use crate::{
    anatomy::{material::Material, raster::Layer},
    sdf::{Knot, Sdf, at, plate, spline, tube, union, xyz},
};

/// Half of the fat between two muscles, in mm.
const SEPTUM_MM: f32 = 0.8;

/// A muscle of the left side and the direction of its fibres.
type Muscle = (Sdf, Vec3);

pub(crate) fn layers(stuff: &Stuff, arms: Arms) -> Vec<Layer> {
    let mut layers = wall(stuff);
    let rough = stuff.seed("muscle");
    let groups = [
        deep_back(),
        belly(stuff),
        side(stuff),
        back(stuff, arms),
        shoulder(arms),
        chest(stuff, arms),
        neck(),
    ];
    for (shape, fibres) in groups.into_iter().flatten() {
        let shape = shape.mirror().rough(0.5, 5.0, rough);
        let around = stuff.under_skin(shape.clone().grow(SEPTUM_MM), 3.4);
        layers.push(stuff.layer(TorsoPart::Fat, around, Material::even(-92.0, 12.0, 5.0)));
        let material = Material::Muscle { fibres: fibres.normalize(), fat: 45.0 };
        layers.push(stuff.layer(TorsoPart::Muscle, stuff.under_skin(shape, 4.4), material));
    }
    layers
}

/// Muscles inside the cage: psoas and the square muscle of the loins.
pub(crate) fn inner(stuff: &Stuff) -> Vec<Layer> {
    let psoas = tube(&[
        [23.0, 28.0, -84.0, 7.0],
        [29.0, 26.0, -115.0, 12.0],
        [36.0, 20.0, -150.0, 17.0],
        [42.0, 12.0, -190.0, 21.0],
        [46.0, 4.0, -230.0, 22.0],
    ]);
    let square = tube(&[
        [34.0, 60.0, -88.0, 8.0],
        [48.0, 56.0, -120.0, 14.0],
        [60.0, 54.0, -170.0, 15.0],
        [68.0, 54.0, -225.0, 14.0],
    ]);
    [(psoas, at(0.2, -0.2, -1.0)), (square, Vec3::Z)]
        .map(|(shape, fibres)| {
            let material = Material::Muscle { fibres: fibres.normalize(), fat: 35.0 };
            stuff.layer(TorsoPart::Muscle, shape.mirror().rough(0.6, 6.0, stuff.seed("muscle")), material)
        })
        .to_vec()
}

/// The wall of chest and belly: three sheets whose fibres cross, between ribs and below them.
fn wall(stuff: &Stuff) -> Vec<Layer> {
    let cage = |by: f32| stuff.under_skin(Sdf::Field(field::CAGE).grow(by), 4.4);
    let muscle = |fibres: Vec3| Material::Muscle { fibres: fibres.normalize(), fat: 20.0 };
    let fat = Material::even(-80.0, 15.0, 5.0);
    vec![
        stuff.layer(TorsoPart::Muscle, cage(12.6), muscle(at(0.4, -0.5, -0.75))),
        stuff.layer(TorsoPart::Fat, cage(8.2), fat),
        stuff.layer(TorsoPart::Muscle, cage(7.6), muscle(at(0.4, -0.5, 0.75))),
        stuff.layer(TorsoPart::Fat, cage(3.6), fat),
        stuff.layer(TorsoPart::Muscle, cage(3.0), muscle(Vec3::X)),
    ]
}

/// Along the spine.
fn deep_back() -> Vec<Muscle> {
    let spinalis: &[Knot] = &[
        [11.0, 62.0, 215.0, 10.0],
        [11.0, 76.0, 170.0, 10.0],
        [11.0, 92.0, 110.0, 10.0],
        [11.0, 98.0, 40.0, 10.0],
        [12.0, 92.0, -40.0, 12.0],
        [14.0, 80.0, -130.0, 15.0],
        [15.0, 76.0, -225.0, 16.0],
    ];
    let longissimus: &[Knot] = &[
        [26.0, 58.0, 215.0, 10.0],
        [30.0, 72.0, 165.0, 9.0],
        [33.0, 92.0, 100.0, 10.0],
        [33.0, 99.0, 40.0, 11.0],
        [34.0, 95.0, -30.0, 15.0],
        [36.0, 83.0, -110.0, 20.0],
        [36.0, 78.0, -225.0, 20.0],
    ];
    let iliocostalis: &[Knot] = &[
        [52.0, 84.0, 110.0, 5.0],
        [56.0, 95.0, 40.0, 6.0],
        [58.0, 92.0, -30.0, 10.0],
        [60.0, 80.0, -110.0, 15.0],
        [60.0, 74.0, -225.0, 17.0],
    ];
    [spinalis, longissimus, iliocostalis].map(|knots| (tube(knots), Vec3::Z)).to_vec()
}

/// The straight muscle of the belly, with the tendons across it.
fn belly(stuff: &Stuff) -> Vec<Muscle> {
    let cage = &stuff.cage;
    let points: Vec<Knot> = spline(&[
        [40.0, 16.0, 0.0, 20.0],
        [38.0, -12.0, 0.0, 31.0],
        [37.0, -60.0, 0.0, 32.0],
        [36.0, -120.0, 0.0, 30.0],
        [34.0, -190.0, 0.0, 27.0],
        [30.0, -250.0, 0.0, 24.0],
    ])
    .into_iter()
    .map(|[x, z, _, width]| {
        let p = cage.at(cage.angle(x, z.max(-210.0), false), z.max(-210.0), 12.5);
        [p.x, p.y, z, width]
    })
    .collect();
    let tendon = |z: f32| {
        let p = |x: f32, dz: f32| {
            let p = cage.at(cage.angle(x, z + dz, false), z + dz, 16.5);
            [p.x, p.y, p.z, 2.6]
        };
        tube(&[p(2.0, 0.0), p(20.0, 2.5), p(38.0, -1.5), p(56.0, 3.0), p(72.0, 2.0)])
    };
    let tendons = Sdf::Union(vec![tendon(-36.0), tendon(-82.0), tendon(-130.0)], 0.0);
    vec![(lay(cage, &points, [6.0, 7.0]).minus(tendons, 3.0), Vec3::Z)]
}

/// Serrated muscle and the outer oblique one, whose heads interlock at the ribs.
fn side(stuff: &Stuff) -> Vec<Muscle> {
    let cage = &stuff.cage;
    let mut muscles = Vec::new();
    for i in 0..6 {
        let i = i as f32;
        let z = 52.0 - 23.0 * i;
        let oblique = drape(
            cage,
            &[
                [72.0 + 7.0 * i, z - 8.0 - 8.0 * i, 12.6, 6.0],
                [63.0 + 5.0 * i, z - 24.0 - 9.0 * i, 13.0, 13.0],
                [52.0 + 2.0 * i, z - 50.0 - 9.0 * i, 12.6, 15.0],
                [40.0, z - 80.0 - 8.0 * i, 11.0, 11.0],
            ],
        );
        if i < 5.0 {
            muscles.push((lay(cage, &clamped(oblique), [2.4, 4.0]), at(-0.5, -0.4, -0.75)));
        }
        let serratus = drape(
            cage,
            &[
                [62.0 + 4.5 * i, z + 8.0, 12.6, 4.0],
                [74.0 + 4.0 * i, z + 14.0, 13.4, 8.0],
                [92.0 + 2.0 * i, z + 26.0, 14.0, 10.0],
                [116.0, z + 44.0 + 3.0 * i, 14.0, 11.0],
            ],
        );
        muscles.push((lay(cage, &serratus, [2.6, 4.6]), at(0.3, 0.85, 0.4)));
    }
    muscles
}

/// The points within the cage's heights.
fn clamped(points: Vec<Knot>) -> Vec<Knot> {
    points.into_iter().filter(|p| p[2] > -208.0).collect()
}

fn back(stuff: &Stuff, arms: Arms) -> Vec<Muscle> {
    let cage = &stuff.cage;
    // Where the broad muscle of the back ends: in front of the humerus.
    let [insertion, fold] = match arms {
        Arms::Raised => [at(158.0, 0.0, 196.0), at(134.0, 34.0, 130.0)],
        Arms::AtSides => [at(164.0, 2.0, 108.0), at(136.0, 40.0, 92.0)],
    };
    let bundle = |i: usize| {
        let t = i as f32 / 5.0;
        let z = 18.0 - 180.0 * t;
        let mut path = drape(
            cage,
            &[
                [172.0 - 10.0 * t, z, 24.0 - 3.0 * t, 14.0],
                [150.0 - 16.0 * t, z + 12.0 + 30.0 * t, 17.0, 16.0],
                [122.0 - 14.0 * t, z + 36.0 + 84.0 * t, 16.0, 17.0],
                [110.0 - 10.0 * t, 58.0 - 14.0 * t, 19.0, 15.0],
            ],
        );
        path.push([fold.x, fold.y - 8.0 * t, fold.z - 8.0 * t, 13.0]);
        path.push([insertion.x, insertion.y, insertion.z, 8.0]);
        lay(cage, &spline(&path), [3.4, 5.0])
    };
    let broad = union((0..6).map(bundle).collect(), 5.0);
    let trapezius = union(
        vec![
            plate(at(4.0, 84.0, 196.0), at(4.0, 106.0, 120.0), at(146.0, 30.0, 176.0), 4.0),
            plate(at(4.0, 106.0, 128.0), at(4.0, 111.0, 0.0), at(92.0, 90.0, 142.0), 3.6),
            plate(at(4.0, 106.0, 128.0), at(92.0, 90.0, 142.0), at(140.0, 42.0, 172.0), 4.0),
            tube(&[
                [12.0, 66.0, 250.0, 11.0],
                [26.0, 60.0, 205.0, 13.0],
                [60.0, 52.0, 187.0, 12.0],
                [112.0, 32.0, 180.0, 8.0],
                [140.0, 20.0, 181.0, 6.0],
            ]),
        ],
        6.0,
    );
    let rhomboid = plate(at(10.0, 95.0, 150.0), at(12.0, 104.0, 84.0), at(72.0, 94.0, 76.0), 3.0);
    let below_spine = union(
        vec![
            tube(&[
                [84.0, 97.0, 52.0, 6.0],
                [102.0, 84.0, 84.0, 13.0],
                [124.0, 60.0, 120.0, 14.0],
                [150.0, 34.0, 152.0, 8.0],
            ]),
            tube(&[
                [80.0, 98.0, 84.0, 7.0],
                [100.0, 82.0, 106.0, 13.0],
                [126.0, 58.0, 134.0, 13.0],
                [150.0, 32.0, 158.0, 7.0],
            ]),
            plate(at(80.0, 98.0, 110.0), at(88.0, 98.0, 44.0), at(118.0, 66.0, 118.0), 6.5),
        ],
        10.0,
    );
    let above_spine = tube(&[
        [80.0, 78.0, 146.0, 8.0],
        [104.0, 58.0, 154.0, 10.0],
        [130.0, 32.0, 168.0, 7.0],
        [150.0, 16.0, 178.0, 5.0],
    ]);
    let under_blade = union(
        vec![
            tube(&[
                [82.0, 84.0, 60.0, 5.0],
                [100.0, 68.0, 96.0, 8.0],
                [124.0, 34.0, 134.0, 9.0],
                [146.0, 6.0, 150.0, 7.0],
            ]),
            tube(&[
                [78.0, 76.0, 110.0, 5.0],
                [102.0, 58.0, 124.0, 8.0],
                [126.0, 30.0, 142.0, 8.0],
                [146.0, 4.0, 154.0, 6.0],
            ]),
        ],
        8.0,
    );
    let round = tube(&[
        [92.0, 97.0, 36.0, 9.0],
        [114.0, 78.0, 70.0, 13.0],
        [fold.x + 4.0, fold.y + 8.0, fold.z, 11.0],
        [insertion.x, insertion.y + 4.0, insertion.z, 7.0],
    ]);
    vec![
        (rhomboid, at(0.9, 0.0, -0.5)),
        (under_blade, at(0.6, -0.6, 0.5)),
        (above_spine, at(0.8, -0.6, 0.3)),
        (below_spine, at(0.7, -0.6, 0.4)),
        (round, at(0.6, -0.5, 0.6)),
        (broad, at(0.6, -0.1, 0.7)),
        (trapezius, at(0.8, -0.3, 0.4)),
    ]
}

/// The deltoid's three parts, and the arm.
fn shoulder(arms: Arms) -> Vec<Muscle> {
    let [head, end] = girdle::humerus_line(arms);
    let along = (end - head).normalize();
    let heads: [&[Knot]; 3] = match arms {
        Arms::Raised => [
            &[
                [100.0, -24.0, 172.0, 7.0],
                [134.0, -24.0, 174.0, 15.0],
                [166.0, -22.0, 200.0, 15.0],
                [186.0, -10.0, 262.0, 8.0],
            ],
            &[
                [144.0, 26.0, 180.0, 8.0],
                [172.0, 18.0, 170.0, 17.0],
                [190.0, 10.0, 206.0, 16.0],
                [196.0, 0.0, 268.0, 8.0],
            ],
            &[
                [118.0, 66.0, 154.0, 7.0],
                [150.0, 54.0, 158.0, 16.0],
                [178.0, 34.0, 200.0, 14.0],
                [194.0, 10.0, 264.0, 8.0],
            ],
        ],
        Arms::AtSides => [
            &[
                [100.0, -24.0, 170.0, 7.0],
                [140.0, -22.0, 162.0, 15.0],
                [172.0, -14.0, 122.0, 15.0],
                [188.0, 8.0, 46.0, 6.0],
            ],
            &[
                [150.0, 20.0, 180.0, 8.0],
                [182.0, 18.0, 158.0, 17.0],
                [192.0, 16.0, 112.0, 16.0],
                [192.0, 16.0, 46.0, 6.0],
            ],
            &[
                [116.0, 68.0, 152.0, 7.0],
                [154.0, 54.0, 152.0, 16.0],
                [182.0, 38.0, 114.0, 15.0],
                [192.0, 22.0, 46.0, 6.0],
            ],
        ],
    };
    let mut muscles: Vec<Muscle> = heads.iter().map(|k| (tube(k), xyz(k[3]) - xyz(k[0]))).collect();
    // Biceps in front of the bone, brachialis, triceps behind it.
    let front = match arms {
        Arms::Raised => at(-0.25, -0.95, 0.0),
        Arms::AtSides => at(0.1, -0.99, 0.0),
    };
    let inward = at(-1.0, 0.0, 0.0);
    let reach = (end - head).length();
    let belly = |aside: Vec3, from: f32, to: f32, r: f32| {
        let line = [0.0, 0.3, 0.62, 1.0].map(|t| {
            let p = head
                + along * (from + (to - from) * t).min(reach)
                + aside * (1.0 - 0.5 * (2.0 * t - 1.0).powi(2));
            [p.x, p.y, p.z, r * [0.45, 0.95, 1.0, 0.4][(t * 3.2) as usize]]
        });
        tube(&line)
    };
    muscles.push((belly(front * 28.0 + inward * 8.0, 30.0, 270.0, 17.0), along));
    muscles.push((belly(front * 26.0 - inward * 8.0, 40.0, 265.0, 14.0), along));
    muscles.push((belly(front * -26.0 + inward * 10.0, 30.0, 268.0, 18.0), along));
    muscles.push((belly(front * -27.0 - inward * 8.0, 50.0, 265.0, 17.0), along));
    if arms == Arms::AtSides {
        muscles.push((
            tube(&[[224.0, 2.0, -108.0, 13.0], [232.0, -10.0, -165.0, 15.0], [226.0, -20.0, -250.0, 9.0]]),
            Vec3::Z,
        ));
        muscles.push((
            tube(&[[202.0, 16.0, -120.0, 13.0], [206.0, -2.0, -165.0, 16.0], [212.0, -16.0, -250.0, 9.0]]),
            Vec3::Z,
        ));
        muscles.push((
            tube(&[[216.0, 36.0, -136.0, 10.0], [222.0, 24.0, -180.0, 13.0], [224.0, 6.0, -250.0, 8.0]]),
            Vec3::Z,
        ));
    }
    muscles
}

/// The fan of the large pectoral muscle; the small one lies under it.
fn chest(stuff: &Stuff, arms: Arms) -> Vec<Muscle> {
    let cage = &stuff.cage;
    let insertion = match arms {
        Arms::Raised => at(162.0, -16.0, 190.0),
        Arms::AtSides => at(172.0, -8.0, 112.0),
    };
    // Origin (x, z, half width), and the x, z and lift that the bundle passes over.
    let bundles: [([f32; 3], [f32; 3]); 7] = [
        ([64.0, 154.0, 12.0], [104.0, 146.0, 30.0]),
        ([36.0, 146.0, 9.0], [92.0, 136.0, 31.0]),
        ([20.0, 124.0, 16.0], [88.0, 122.0, 29.0]),
        ([20.0, 100.0, 16.0], [90.0, 108.0, 27.0]),
        ([21.0, 76.0, 16.0], [92.0, 94.0, 25.0]),
        ([25.0, 53.0, 16.0], [94.0, 79.0, 24.0]),
        ([40.0, 36.0, 14.0], [98.0, 66.0, 23.0]),
    ];
    let bundle = |(origin, over): &([f32; 3], [f32; 3])| {
        let on = |x: f32, z: f32, lift: f32, r: f32| {
            let p = cage.at(cage.angle(x, z, false), z, lift);
            [p.x, p.y, p.z, r]
        };
        let [x, z, r] = *origin;
        let middle = [(x + over[0]) / 2.0, (z + over[1]) / 2.0];
        let knots = [
            on(x, z.min(148.0), 13.0, r),
            on(middle[0], middle[1], 16.5, 1.2 * r),
            [over[0] + 4.0, on(over[0].min(84.0), over[1], over[2] - 9.0, 0.0)[1], over[1], 1.15 * r],
            [insertion.x, insertion.y, insertion.z, 9.0],
        ];
        let points = spline(&knots);
        (lay(cage, &points, [4.0, 7.6]), insertion - xyz(knots[0]))
    };
    let (shapes, fibres): (Vec<Sdf>, Vec<Vec3>) = bundles.iter().map(bundle).unzip();
    let small = drape(cage, &[[46.0, 40.0, 12.0, 12.0], [52.0, 80.0, 14.0, 16.0], [62.0, 116.0, 17.0, 12.0]]);
    let mut small_points = small;
    small_points.push([122.0, -2.0, 156.0, 6.0]);
    let mut muscles = vec![(lay(cage, &spline(&small_points), [3.0, 4.0]), at(0.4, 0.3, 0.85))];
    // Bundles are parted by furrows, not by fat all the way down: in pairs.
    let mut shapes = shapes.into_iter().zip(fibres);
    if let (Some(a), Some(b)) = (shapes.next(), shapes.next()) {
        muscles.push((union(vec![a.0, b.0], 2.0), a.1));
    }
    let (rest, fibres): (Vec<Sdf>, Vec<Vec3>) = shapes.unzip();
    muscles.push((union(rest, 4.0), fibres.into_iter().sum()));
    muscles
}

fn neck() -> Vec<Muscle> {
    let mastoid =
        |end: &[Knot]| tube(&[&[[50.0, 2.0, 262.0, 11.0], [38.0, -12.0, 220.0, 11.0]], end].concat());
    let scalene = tube(&[[24.0, 10.0, 262.0, 7.0], [32.0, 10.0, 215.0, 9.0], [40.0, 4.0, 172.0, 7.0]]);
    let scalene_behind =
        tube(&[[28.0, 20.0, 262.0, 8.0], [38.0, 24.0, 215.0, 10.0], [52.0, 24.0, 166.0, 8.0]]);
    let levator = tube(&[[40.0, 30.0, 262.0, 8.0], [52.0, 44.0, 215.0, 10.0], [70.0, 70.0, 166.0, 8.0]]);
    let longus = tube(&[[8.0, -6.0, 262.0, 6.0], [9.0, 0.0, 200.0, 6.0], [9.0, 12.0, 160.0, 4.0]]);
    let strap = tube(&[
        [9.0, -36.0, 262.0, 5.0],
        [10.0, -34.0, 200.0, 5.5],
        [12.0, -33.0, 160.0, 5.0],
        [14.0, -32.0, 140.0, 4.0],
    ]);
    let splenius = tube(&[[30.0, 52.0, 262.0, 12.0], [24.0, 66.0, 215.0, 11.0], [12.0, 88.0, 160.0, 6.0]]);
    vec![
        (longus, Vec3::Z),
        (scalene, at(-0.2, 0.0, 1.0)),
        (scalene_behind, at(-0.2, 0.0, 1.0)),
        (levator, at(-0.3, -0.3, 1.0)),
        (splenius, at(0.2, -0.3, 1.0)),
        (strap, Vec3::Z),
        (
            mastoid(&[[28.0, -27.0, 190.0, 8.0], [14.0, -40.0, 158.0, 5.0], [10.0, -42.0, 146.0, 4.0]]),
            at(0.35, 0.35, 0.87),
        ),
        (
            mastoid(&[[38.0, -24.0, 190.0, 8.0], [40.0, -40.0, 166.0, 6.5], [42.0, -44.0, 160.0, 5.0]]),
            at(0.2, 0.35, 0.87),
        ),
    ]
}
