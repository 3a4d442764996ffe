//! The heart: chambers, walls, the trunk of the pulmonary artery, coronary arteries in their grooves.

use glam::{Mat3, Vec3};

use super::{Stuff, body, field, part::TorsoPart};
use crate::{
    anatomy::{material::Material, raster::Layer},
    sdf::{Knot, Sdf, at, ellipsoid, segment, sphere, spline, tube, turned_ellipsoid, union, xyz},
};

/// From the base of the left ventricle to the apex.
const AXIS: Vec3 = at(0.632, -0.559, -0.537);

/// Where the aorta begins.
pub(crate) const AORTIC_ROOT: Vec3 = at(2.0, -22.0, 57.0);

/// Axes of an ellipsoid along [`AXIS`].
fn along_axis() -> Mat3 {
    let (u, v) = AXIS.normalize().any_orthonormal_pair();
    Mat3::from_cols(u, v, AXIS.normalize())
}

fn left_ventricle() -> Sdf {
    turned_ellipsoid(at(42.0, -29.0, 22.0), at(31.5, 31.5, 47.0), along_axis())
}

fn left_cavity() -> Sdf {
    let chamber = turned_ellipsoid(at(38.0, -26.0, 25.5), at(20.5, 20.5, 36.0), along_axis());
    // Papillary muscles, and the way out.
    let papillary = |p: Vec3| segment(p, p - AXIS * 22.0, 5.5, 3.5);
    let outlet = segment(at(24.0, -20.0, 42.0), AORTIC_ROOT, 12.0, 12.5);
    chamber
        .minus(papillary(at(60.0, -26.0, 16.0)), 2.0)
        .minus(papillary(at(42.0, -28.0, 0.0)), 2.0)
        .or(outlet, 6.0)
}

/// The right ventricle wraps itself around the septum, and narrows upwards to the pulmonary trunk.
fn right_ventricle() -> Sdf {
    union(
        vec![
            segment(at(-12.0, -40.0, 22.0), at(46.0, -58.0, 0.0), 25.0, 12.0),
            segment(at(-4.0, -46.0, 30.0), at(10.0, -52.0, 74.0), 23.0, 14.5),
            ellipsoid(at(14.0, -50.0, 18.0), at(34.0, 20.0, 26.0)),
        ],
        12.0,
    )
}

fn right_atrium() -> Sdf {
    union(
        vec![
            ellipsoid(at(-35.0, -14.0, 34.0), at(23.0, 27.0, 32.0)),
            // Its auricle lies around the aorta.
            tube(&[[-36.0, -26.0, 54.0, 12.0], [-24.0, -44.0, 66.0, 9.0], [-10.0, -52.0, 70.0, 5.0]]),
            segment(at(-26.0, -6.0, 80.0), at(-29.0, -8.0, 50.0), 10.5, 13.0),
            segment(at(-23.0, -1.0, -6.0), at(-28.0, -6.0, 20.0), 12.0, 14.0),
        ],
        8.0,
    )
}

fn left_atrium() -> Sdf {
    union(
        vec![
            ellipsoid(at(6.0, 5.0, 48.0), at(31.0, 17.0, 22.0)),
            segment(at(12.0, 0.0, 46.0), at(26.0, -14.0, 40.0), 15.0, 15.0),
            tube(&[[30.0, -4.0, 58.0, 9.0], [44.0, -18.0, 66.0, 8.0], [46.0, -32.0, 64.0, 5.0]]),
            segment(at(-10.0, 6.0, 54.0), at(-22.0, 3.0, 57.0), 9.0, 7.5),
            segment(at(-8.0, 10.0, 44.0), at(-20.0, 18.0, 38.0), 9.0, 7.5),
            segment(at(22.0, 5.0, 54.0), at(32.0, 1.0, 59.0), 9.0, 7.5),
            segment(at(20.0, 10.0, 45.0), at(30.0, 16.0, 41.0), 9.0, 7.5),
        ],
        5.0,
    )
}

/// Muscle and all that it encloses.
pub(crate) fn outside() -> Sdf {
    let walls = vec![left_ventricle(), right_ventricle(), right_atrium(), left_atrium()];
    union(walls, 4.0)
}

fn pulmonary_trunk() -> Sdf {
    tube(&[
        [9.0, -52.0, 70.0, 13.0],
        [13.0, -44.0, 82.0, 13.5],
        [15.0, -28.0, 89.0, 13.0],
        [15.0, -13.0, 88.0, 12.0],
    ])
}

pub(crate) fn layers(stuff: &Stuff) -> Vec<Layer> {
    let outside = || Sdf::Field(field::HEART);
    let septum = left_ventricle();
    let blood = |hu: f32| Material::even(hu, 8.0, 9.0);
    let right = right_ventricle().grow(-4.0).minus(septum.clone(), 3.0);
    // The mitral valve stands open, so that both sides are one.
    let left = left_cavity().or(left_atrium().grow(-2.4), 4.0);
    let sinuses = union(
        vec![
            sphere(AORTIC_ROOT + at(8.0, 3.0, 3.0), 12.0),
            sphere(AORTIC_ROOT + at(-5.0, 7.0, 3.0), 12.0),
            sphere(AORTIC_ROOT + at(-5.0, -7.0, 4.0), 12.0),
        ],
        4.0,
    );
    vec![
        stuff.layer(TorsoPart::SoftTissue, outside().grow(4.4).sheet(0.7), Material::even(24.0, 8.0, 5.0)),
        stuff.layer(TorsoPart::Myocardium, outside(), Material::even(104.0, 9.0, 4.0)),
        stuff.layer(TorsoPart::PulmonaryArtery, right_atrium().grow(-2.6), Material::even(205.0, 26.0, 16.0)),
        stuff.layer(
            TorsoPart::PulmonaryArtery,
            right.rough(1.4, 6.0, stuff.seed("trabeculae")),
            Material::even(255.0, 14.0, 12.0),
        ),
        stuff.layer(TorsoPart::Artery, left.rough(0.7, 6.0, stuff.seed("trabeculae")), blood(300.0)),
        stuff.layer(TorsoPart::PulmonaryArtery, pulmonary_trunk(), blood(280.0)),
        stuff.layer(TorsoPart::Artery, sinuses, blood(305.0)),
        stuff.layer(TorsoPart::Artery, coronaries(), Material::even(300.0, 8.0, 6.0)),
    ]
}

/// The coronary arteries, laid on the surface of the heart.
fn coronaries() -> Sdf {
    const MAIN: &[Knot] = &[[6.0, -24.0, 61.0, 2.3], [20.0, -28.0, 63.0, 2.3], [29.0, -33.0, 60.0, 2.2]];
    const DESCENDING: &[Knot] = &[
        [29.0, -33.0, 60.0, 2.1],
        [30.0, -52.0, 50.0, 2.0],
        [40.0, -62.0, 32.0, 1.9],
        [54.0, -66.0, 12.0, 1.6],
        [66.0, -60.0, -4.0, 1.3],
        [62.0, -46.0, -14.0, 1.0],
    ];
    const DIAGONALS: [&[Knot]; 2] = [
        &[
            [31.0, -52.0, 49.0, 1.5],
            [54.0, -52.0, 42.0, 1.4],
            [70.0, -42.0, 26.0, 1.1],
            [76.0, -32.0, 10.0, 0.9],
        ],
        &[[42.0, -63.0, 30.0, 1.4], [60.0, -58.0, 20.0, 1.2], [74.0, -46.0, 4.0, 0.9]],
    ];
    const CIRCUMFLEX: &[Knot] = &[
        [29.0, -33.0, 60.0, 2.0],
        [42.0, -16.0, 54.0, 1.9],
        [48.0, 0.0, 42.0, 1.7],
        [42.0, 10.0, 26.0, 1.4],
        [30.0, 8.0, 10.0, 1.1],
    ];
    const MARGINALS: [&[Knot]; 2] = [
        &[[44.0, -14.0, 53.0, 1.5], [66.0, -18.0, 38.0, 1.3], [76.0, -26.0, 18.0, 1.0]],
        &[[47.0, 2.0, 40.0, 1.4], [64.0, -4.0, 22.0, 1.2], [70.0, -16.0, 2.0, 0.9]],
    ];
    const RIGHT: &[Knot] = &[
        [-4.0, -30.0, 62.0, 2.3],
        [-14.0, -54.0, 56.0, 2.2],
        [-28.0, -52.0, 36.0, 2.1],
        [-34.0, -42.0, 14.0, 2.0],
        [-22.0, -28.0, -6.0, 1.8],
        [2.0, -14.0, -8.0, 1.7],
        [14.0, -10.0, -6.0, 1.5],
    ];
    const POSTERIOR: &[Knot] =
        &[[10.0, -12.0, -6.0, 1.4], [28.0, -26.0, -14.0, 1.3], [46.0, -40.0, -18.0, 1.0]];
    const ACUTE: &[Knot] = &[
        [-32.0, -46.0, 20.0, 1.4],
        [-10.0, -66.0, 2.0, 1.2],
        [18.0, -72.0, -8.0, 1.0],
        [38.0, -68.0, -12.0, 0.8],
    ];
    const CONUS: &[Knot] = &[[-12.0, -52.0, 57.0, 1.2], [4.0, -70.0, 52.0, 1.0], [16.0, -74.0, 40.0, 0.8]];
    let surface = outside();
    let laid = |knots: &[Knot]| {
        let from_root = knots[0][3] > 2.2;
        let mut points = spline(knots);
        for (i, k) in points.iter_mut().enumerate() {
            // The first stretch comes out of the aorta.
            if i > 2 || !from_root {
                let p = body::onto(&surface, xyz(*k), 1.3);
                *k = [p.x, p.y, p.z, k[3]];
            }
        }
        tube(&points)
    };
    let all = [&[MAIN, DESCENDING, CIRCUMFLEX, RIGHT, POSTERIOR, ACUTE, CONUS][..], &DIAGONALS, &MARGINALS]
        .concat();
    union(all.into_iter().map(laid).collect(), 0.6)
}
