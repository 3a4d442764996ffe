//! Gullet, stomach, duodenum, small and large bowel, with what they hold.

use glam::Vec3;

use super::{Stuff, field, part::TorsoPart};
use crate::maths;
use crate::{
    anatomy::{material::Material, raster::Layer},
    noise::noise,
    sdf::{Knot, Sdf, at, spline, tube, xyz},
};

const WALL: Material = Material::even(62.0, 10.0, 4.0);
const GAS: Material = Material::even(-990.0, 4.0, 6.0);

const GULLET: [Knot; 9] = [
    [2.0, -2.0, 262.0, 7.0],
    [4.0, 1.0, 190.0, 7.4],
    [6.0, 14.0, 150.0, 7.6],
    [7.0, 26.0, 110.0, 7.4],
    [5.0, 31.0, 80.0, 6.8],
    [4.0, 31.0, 48.0, 6.4],
    [5.0, 24.0, 10.0, 7.4],
    [14.0, 10.0, -24.0, 7.6],
    [30.0, 4.0, -46.0, 8.0],
];

const STOMACH: [Knot; 8] = [
    [62.0, 30.0, -48.0, 24.0],
    [66.0, 16.0, -58.0, 33.0],
    [66.0, -14.0, -78.0, 33.0],
    [58.0, -40.0, -106.0, 29.0],
    [36.0, -54.0, -126.0, 24.0],
    [6.0, -52.0, -126.0, 19.0],
    [-14.0, -44.0, -116.0, 13.0],
    [-24.0, -38.0, -110.0, 9.0],
];

const DUODENUM: [Knot; 7] = [
    [-24.0, -38.0, -110.0, 10.0],
    [-40.0, -26.0, -108.0, 13.0],
    [-46.0, -14.0, -128.0, 12.5],
    [-40.0, -14.0, -154.0, 12.5],
    [-8.0, -20.0, -160.0, 10.5],
    [24.0, -16.0, -146.0, 11.0],
    [34.0, -26.0, -128.0, 11.5],
];

const COLON: [Knot; 15] = [
    [-92.0, -14.0, -235.0, 25.0],
    [-96.0, -8.0, -196.0, 25.0],
    [-94.0, -4.0, -166.0, 24.0],
    [-86.0, -22.0, -148.0, 22.0],
    [-72.0, -50.0, -154.0, 21.0],
    [-40.0, -62.0, -164.0, 20.0],
    [0.0, -64.0, -168.0, 19.5],
    [40.0, -62.0, -158.0, 19.0],
    [76.0, -48.0, -136.0, 19.0],
    [96.0, -14.0, -108.0, 18.0],
    [98.0, 20.0, -112.0, 16.0],
    [96.0, 26.0, -140.0, 15.0],
    [96.0, 22.0, -170.0, 14.0],
    [94.0, 16.0, -200.0, 14.0],
    [88.0, 10.0, -235.0, 14.0],
];

/// The part of a hollow organ where gas rises: patients lie on their backs.
fn gas(lumen: Sdf, level: f32) -> Sdf {
    lumen.and(Sdf::HalfSpace { normal: Vec3::Y, offset: level }, 0.8)
}

/// Kept off the wall of the belly and the diaphragm.
fn inside(shape: Sdf) -> Sdf {
    Sdf::Intersection(
        vec![shape, Sdf::Field(field::CAGE).grow(-3.4), Sdf::Field(field::BELLY).grow(-2.8)],
        4.0,
    )
}

/// The colon's bulges, three rows of them between its bands.
fn colon() -> Vec<Knot> {
    let mut length = 0.0;
    let points = spline(&COLON);
    let mut before = xyz(points[0]);
    points
        .iter()
        .map(|k| {
            length += xyz(*k).distance(before);
            before = xyz(*k);
            let bulge = maths::sin(length * std::f32::consts::TAU / 27.0);
            [k[0], k[1], k[2], k[3] * (0.86 + 0.13 * bulge)]
        })
        .collect()
}

/// Loops of the small bowel: a line that winds through the lower belly.
fn loops() -> Vec<Knot> {
    let step = |i: usize| {
        let t = i as f32;
        let row = (t / 6.0).floor();
        let along = t % 6.0;
        let x = if row % 2.0 == 0.0 { -58.0 + 23.0 * along } else { 57.0 - 23.0 * along };
        let sway = noise(at(t * 0.71, 3.0, 1.0), 77);
        at(
            x,
            -34.0 + 16.0 * maths::sin(t * 1.9) + 10.0 * sway,
            -183.0 - 15.0 * row + 7.0 * maths::cos(t * 2.7),
        )
    };
    (0..24).map(step).map(|p| [p.x, p.y, p.z, 11.5]).collect()
}

pub(crate) fn layers(stuff: &Stuff) -> Vec<Layer> {
    let gullet = tube(&GULLET);
    let stomach = tube(&STOMACH).rough(1.6, 22.0, stuff.seed("stomach"));
    let duodenum = tube(&DUODENUM).rough(0.8, 8.0, stuff.seed("duodenum"));
    let small = tube(&loops()).rough(1.2, 8.0, stuff.seed("bowel"));
    let colon = tube(&colon()).rough(0.8, 9.0, stuff.seed("colon"));
    let gut = |shape: Sdf, material: Material| stuff.layer(TorsoPart::Gut, shape, material);
    let lumen = |shape: &Sdf, wall: f32| inside(shape.clone().grow(-wall));
    vec![
        gut(inside(small.clone()), Material::even(78.0, 14.0, 4.0)),
        gut(lumen(&small, 2.4), Material::even(24.0, 14.0, 6.0)),
        gut(inside(duodenum.clone()), WALL),
        gut(lumen(&duodenum, 2.6), Material::even(18.0, 12.0, 6.0)),
        gut(inside(colon.clone()), WALL),
        gut(lumen(&colon, 2.2), Material::even(8.0, 120.0, 7.0)),
        stuff.layer(TorsoPart::GutGas, gas(lumen(&colon, 2.2), -44.0), GAS),
        gut(gullet.clone(), WALL),
        stuff.layer(TorsoPart::GutGas, gullet.grow(-5.6), Material::even(-700.0, 200.0, 9.0)),
        gut(inside(stomach.clone()), WALL),
        // A meal in water.
        gut(lumen(&stomach, 4.2), Material::even(26.0, 24.0, 8.0)),
        stuff.layer(TorsoPart::GutGas, gas(lumen(&stomach, 4.2), -40.0), GAS),
    ]
}
