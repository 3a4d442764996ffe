//! What is not the patient: the table, its mattress, a blanket; and metal inside.

use glam::Vec3;

use super::{Arms, Metal, Stuff, column, part::TorsoPart};
use crate::maths;
use crate::{
    anatomy::{material::Material, raster::Layer},
    loft::{Loft, section},
    sdf::{Knot, Sdf, at, block, ellipsoid, segment, spline, tube, union},
};

/// The cylinder along the table that a radius and the y of its lowest line give.
fn trough(radius: f32, lowest: f32) -> Sdf {
    let center = lowest - radius;
    segment(at(0.0, center, -2000.0), at(0.0, center, 2000.0), radius, radius)
}

/// Lowest line and radius of the table's upper surface: a shallow trough.
const TABLE_TOP: [f32; 2] = [131.0, 330.0];

/// The same of its lower surface, which meets the upper one at the edges.
const TABLE_BOTTOM: [f32; 2] = [171.0, 243.6];

/// Thickness of the mattress that the patient lies on, in mm.
const MATTRESS_MM: f32 = 13.0;

/// The table and its mattress.
pub(crate) fn table(stuff: &Stuff) -> Vec<Layer> {
    let above = |by: f32| trough(TABLE_TOP[1], TABLE_TOP[0]).grow(by);
    let below = trough(TABLE_BOTTOM[1], TABLE_BOTTOM[0]);
    let edges = Sdf::HalfSpace { normal: Vec3::NEG_Y, offset: -40.0 };
    let table = || below.clone().minus(above(0.0), 2.0).and(edges.clone(), 0.0);
    let wide = segment(at(0.0, 60.0, -2000.0), at(0.0, 60.0, 2000.0), 186.0, 186.0);
    let mattress = above(-0.6).minus(above(-MATTRESS_MM), 3.0).and(wide, 4.0).and(edges.clone(), 0.0);
    // Carbon fibre around hard foam; foam in a thin cover.
    vec![
        stuff.layer(TorsoPart::Table, table(), Material::even(95.0, 15.0, 20.0)).rigid(),
        stuff.layer(TorsoPart::Table, table().grow(-1.7), Material::even(-928.0, 6.0, 6.0)).rigid(),
        stuff.layer(TorsoPart::Mattress, mattress.clone(), Material::even(-420.0, 30.0, 9.0)).rigid(),
        stuff.layer(TorsoPart::Mattress, mattress.grow(-0.8), Material::even(-905.0, 12.0, 5.0)).rigid(),
    ]
}

/// A blanket from the belly to the chest, in folds, down to the table at both sides.
pub(crate) fn blanket(stuff: &Stuff, arms: Arms) -> Vec<Layer> {
    let wide = if arms == Arms::AtSides { 262.0 } else { 180.0 };
    let hull = Sdf::Loft(Loft::new(&[
        section(-2000.0, wide, 16.0, -126.0, 150.0),
        section(-120.0, wide, 16.0, -126.0, 150.0),
        section(10.0, wide + 3.0, 16.0, -128.0, 150.0),
        section(70.0, wide + 4.0, 18.0, -124.0, 150.0),
    ]));
    let upper = Sdf::HalfSpace { normal: at(0.0, 0.1, 1.0).normalize(), offset: 40.0 };
    let front = Sdf::HalfSpace { normal: Vec3::Y, offset: 84.0 };
    let cloth = hull.rough(5.0, 46.0, stuff.seed("folds")).rough(1.6, 13.0, stuff.seed("creases"));
    let shape = cloth.sheet(1.9).and(upper, 1.0).and(front, 1.0);
    vec![stuff.layer(TorsoPart::Blanket, shape, Material::even(-780.0, 60.0, 4.0)).rigid()]
}

/// Metal, as it is left in patients.
pub(crate) fn metal(stuff: &Stuff, metal: Metal) -> Vec<Layer> {
    let steel = Material::even(3050.0, 0.0, 1.0);
    match metal {
        Metal::None => Vec::new(),
        Metal::SternalWires => vec![stuff.layer(TorsoPart::Metal, sternal_wires(stuff), steel)],
        Metal::Pacemaker => {
            // The can holds a battery and much air; leads are thin coils.
            let lead = |knots: &[Knot]| tube(knots);
            let ventricle = lead(&[
                [74.0, -58.0, 134.0, 1.2],
                [62.0, -34.0, 156.0, 1.2],
                [31.0, -13.0, 157.0, 1.1],
                [4.0, -28.0, 140.0, 1.1],
                [-26.0, -14.0, 116.0, 1.1],
                [-29.0, -8.0, 70.0, 1.1],
                [-34.0, -24.0, 30.0, 1.1],
                [-4.0, -44.0, 8.0, 1.1],
                [34.0, -56.0, 2.0, 1.3],
            ]);
            let atrium = lead(&[
                [80.0, -58.0, 132.0, 1.2],
                [66.0, -30.0, 157.0, 1.2],
                [34.0, -11.0, 159.0, 1.1],
                [4.0, -26.0, 143.0, 1.1],
                [-24.0, -12.0, 118.0, 1.1],
                [-30.0, -10.0, 76.0, 1.1],
                [-40.0, -18.0, 50.0, 1.1],
                [-24.0, -42.0, 64.0, 1.3],
            ]);
            let turn = maths::turn_y(0.35) * maths::turn_x(-0.5) * maths::turn_z(0.35);
            let can = block(at(84.0, -66.0, 116.0), [20.0, 4.0], [22.0, 4.0], 22.0, 3.6, turn);
            let can = stuff.under_skin(can, 3.5);
            let header = block(at(80.0, -61.0, 134.0), [13.0, 3.6], [10.0, 3.4], 6.0, 3.0, turn);
            vec![
                stuff.layer(
                    TorsoPart::Metal,
                    stuff.under_skin(union(vec![ventricle, atrium], 0.0), 3.5),
                    steel,
                ),
                stuff.layer(
                    TorsoPart::Metal,
                    stuff.under_skin(header, 3.5),
                    Material::even(320.0, 20.0, 3.0),
                ),
                stuff.layer(TorsoPart::Metal, can.clone(), steel),
                stuff.layer(TorsoPart::Metal, can.grow(-1.2), Material::even(2400.0, 600.0, 9.0)),
            ]
        }
        Metal::Rod => {
            const SCREWED: [usize; 4] = [12, 13, 14, 15];
            let mut parts = Vec::new();
            let mut rod = Vec::new();
            for index in SCREWED {
                let (center, depth) = column::vertebral_body(index);
                let tail = center + at(21.0, depth + 26.0, 5.0);
                parts.push(segment(center + at(11.0, -0.4 * depth, 3.0), tail, 2.4, 3.0));
                parts.push(ellipsoid(tail + at(0.0, 4.0, 0.0), at(6.5, 7.0, 7.5)));
                rod.push([tail.x, tail.y + 5.0, tail.z, 2.8]);
            }
            parts.push(tube(&rod));
            vec![stuff.layer(TorsoPart::Metal, Sdf::Union(parts, 0.0).mirror(), steel)]
        }
    }
}

/// Loops around the sternum with twisted ends.
fn sternal_wires(stuff: &Stuff) -> Sdf {
    let cage = &stuff.cage;
    let wire = |(z, half): (f32, f32)| {
        let front = cage.at(0.0, z, 14.0);
        let back = cage.at(0.0, z, -0.5);
        let knots: [Knot; 7] = [
            [2.0, front.y, z, 0.7],
            [half, front.y + 2.0, z + 1.0, 0.7],
            [half + 2.0, (front.y + back.y) / 2.0, z, 0.7],
            [0.0, back.y, z, 0.7],
            [-half - 2.0, (front.y + back.y) / 2.0, z, 0.7],
            [-half, front.y + 2.0, z - 1.0, 0.7],
            [0.0, front.y, z, 0.7],
        ];
        let twist: Vec<Knot> = (0..14)
            .map(|i| i as f32)
            .map(|i| {
                [
                    1.0 + 1.1 * maths::cos(i * 1.3),
                    front.y - 0.5 - 0.2 * i,
                    z + 0.9 * i + 1.1 * maths::sin(i * 1.3),
                    0.8,
                ]
            })
            .collect();
        union(vec![tube(&spline(&knots)), tube(&twist)], 0.3)
    };
    let places = [(130.0, 22.0), (114.0, 18.0), (90.0, 15.0), (68.0, 15.0), (44.0, 16.0), (20.0, 18.0)];
    Sdf::Union(places.into_iter().map(wire).collect(), 0.0)
}
