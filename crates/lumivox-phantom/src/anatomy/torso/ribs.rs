//! Twelve pairs of ribs with their cartilage, and the sternum.

use super::{
    Stuff, column,
    drape::{drape, lay},
    part::TorsoPart,
};
use crate::{
    anatomy::{material::Material, raster::Layer},
    loft::Loft,
    sdf::{Knot, Sdf, at, segment, sphere, spline, strap, tube, union},
};

/// Where the bone of a rib ends: distance from the middle, or the angle around the chest in degrees where it ends free;
/// height. Then the course of its cartilage: x and z.
struct Rib {
    end: End,
    cartilage: &'static [[f32; 2]],
}

enum End {
    Front { x: f32, z: f32 },
    Free { degrees: f32, z: f32 },
}

const RIBS: [Rib; 12] = [
    Rib { end: End::Front { x: 34.0, z: 133.0 }, cartilage: &[[34.0, 133.0], [27.0, 131.0], [20.0, 130.0]] },
    Rib { end: End::Front { x: 44.0, z: 99.0 }, cartilage: &[[44.0, 99.0], [32.0, 97.0], [17.0, 98.0]] },
    Rib { end: End::Front { x: 54.0, z: 72.0 }, cartilage: &[[54.0, 72.0], [38.0, 71.0], [15.0, 77.0]] },
    Rib { end: End::Front { x: 62.0, z: 44.0 }, cartilage: &[[62.0, 44.0], [44.0, 46.0], [16.0, 56.0]] },
    Rib {
        end: End::Front { x: 71.0, z: 15.0 },
        cartilage: &[[71.0, 15.0], [50.0, 18.0], [30.0, 30.0], [17.0, 37.0]],
    },
    Rib {
        end: End::Front { x: 82.0, z: -16.0 },
        cartilage: &[[82.0, -16.0], [62.0, -16.0], [38.0, 4.0], [18.0, 21.0]],
    },
    Rib {
        end: End::Front { x: 94.0, z: -46.0 },
        cartilage: &[[94.0, -46.0], [74.0, -46.0], [42.0, -20.0], [17.0, 7.0]],
    },
    Rib {
        end: End::Front { x: 105.0, z: -70.0 },
        cartilage: &[[105.0, -70.0], [88.0, -70.0], [68.0, -46.0], [54.0, -30.0]],
    },
    Rib {
        end: End::Front { x: 112.0, z: -92.0 },
        cartilage: &[[112.0, -92.0], [100.0, -92.0], [86.0, -74.0], [78.0, -62.0]],
    },
    Rib {
        end: End::Front { x: 115.0, z: -112.0 },
        cartilage: &[[115.0, -112.0], [108.0, -112.0], [99.0, -97.0], [94.0, -88.0]],
    },
    Rib { end: End::Free { degrees: 94.0, z: -120.0 }, cartilage: &[] },
    Rib { end: End::Free { degrees: 128.0, z: -116.0 }, cartilage: &[] },
];

/// How far the middle of a rib lies outside of the pleura, in mm.
const RIB_LIFT: f32 = 4.6;

/// How far the sternum's middle does.
const STERNUM_LIFT: f32 = 6.5;

/// The course of a rib from its head, with its half height: patient's left.
fn course(cage: &Loft, number: usize) -> Vec<Knot> {
    let [head, tubercle] = column::rib_joints(number);
    let size = if number == 1 { 7.4 } else { 6.6 - 0.16 * (number as f32 - 6.0).abs() };
    // Behind, where the rib turns forward, and then down around the chest.
    let z0 = tubercle.z - 3.0;
    let widest = cage.at(90f32.to_radians(), z0, 0.0).x;
    let start = cage.angle((0.44 * widest).max(20.0), z0, true).to_degrees();
    let (end, z1) = match RIBS[number - 1].end {
        End::Front { x, z } => (cage.angle(x, z, false).to_degrees(), z),
        End::Free { degrees, z } => (degrees, z),
    };
    const STEPS: usize = 12;
    let shaft: Vec<[f32; 4]> = (0..=STEPS)
        .map(|i| {
            let t = i as f32 / STEPS as f32;
            // Steepest at the side.
            let fall = 0.45 * t + 0.55 * (t * t * (3.0 - 2.0 * t));
            let taper =
                if matches!(RIBS[number - 1].end, End::Free { .. }) { 1.0 - 0.45 * t * t } else { 1.0 };
            [start + (end - start) * t, z0 + (z1 - z0) * fall, RIB_LIFT, size * taper]
        })
        .collect();
    let mut knots = vec![
        [head.x, head.y, head.z, 4.4],
        [(head.x + tubercle.x) / 2.0, (head.y + tubercle.y) / 2.0 + 0.5, (head.z + tubercle.z) / 2.0, 4.4],
        [tubercle.x, tubercle.y - 3.5, tubercle.z, 5.4],
    ];
    let neck = spline(&[knots[1], knots[2], drape(cage, &shaft[..2])[0]]);
    knots.truncate(1);
    knots.extend(neck);
    knots.extend(drape(cage, &shaft).into_iter().skip(1));
    knots
}

pub(crate) fn layers(stuff: &Stuff) -> Vec<Layer> {
    let cage = &stuff.cage;
    let bones = (1..=12).map(|i| lay(cage, &course(cage, i), [3.6, 3.9])).collect();
    let ribs = Sdf::Union(bones, 0.0).mirror();
    let cartilage = RIBS.iter().filter(|r| !r.cartilage.is_empty()).map(|r| {
        let place = |&[x, z]: &[f32; 2]| {
            let p = cage.at(cage.angle(x, z, false), z, RIB_LIFT + 0.6);
            [p.x, p.y, p.z, 6.4]
        };
        let knots: Vec<Knot> = spline(&r.cartilage.iter().map(place).collect::<Vec<_>>());
        lay(cage, &knots, [4.2, 4.6])
    });
    let cartilage = union(cartilage.collect(), 1.6).mirror();
    // Cartilage turns to bone from its rim inwards as one grows old.
    let flecks = cartilage.clone().sheet(0.8).rough(1.6, 5.0, stuff.seed("flecks")).grow(-0.55);
    let bone = Material::Bone { cortex_mm: 0.9, cortex: 900.0, spongy: 240.0 };
    vec![
        stuff.layer(TorsoPart::Cartilage, cartilage, Material::even(150.0, 20.0, 5.0)),
        stuff.layer(TorsoPart::Cartilage, flecks, Material::even(310.0, 110.0, 4.0)),
        stuff.layer(TorsoPart::Bone, ribs.rough(0.35, 6.0, stuff.seed("ribs")), bone),
        stuff.layer(
            TorsoPart::Bone,
            sternum(cage).rough(0.4, 6.0, stuff.seed("sternum")),
            Material::Bone { cortex_mm: 1.0, cortex: 700.0, spongy: 190.0 },
        ),
    ]
}

/// Heights and half widths of the sternum from its tip up: notches where the cartilage meets it, broad between.
const STERNUM: [[f32; 2]; 17] = [
    [-1.0, 9.0],
    [7.0, 13.0],
    [14.0, 17.5],
    [21.0, 16.5],
    [29.0, 19.0],
    [37.0, 17.0],
    [46.0, 18.5],
    [56.0, 15.5],
    [66.0, 17.0],
    [77.0, 14.5],
    [87.0, 15.5],
    [97.0, 15.0],
    [104.0, 19.0],
    [114.0, 23.0],
    [124.0, 29.0],
    [135.0, 30.0],
    [143.0, 25.0],
];

fn sternum(cage: &Loft) -> Sdf {
    let on = |z: f32, lift: f32, r: f32| {
        let p = cage.at(0.0, z, lift);
        [p.x, p.y, p.z, r]
    };
    let knots: Vec<Knot> = STERNUM.iter().map(|&[z, half]| on(z, STERNUM_LIFT, half)).collect();
    let top = cage.at(0.0, 150.0, STERNUM_LIFT);
    let facets = at(29.0, top.y - 4.0, 151.0);
    // The angle between manubrium and body, and the seams of the four pieces that the body grew from.
    let seam = |z: f32, r: f32| {
        let [_, y, z, _] = on(z, STERNUM_LIFT + 7.0, 0.0);
        tube(&[[-20.0, y + 1.0, z, r], [0.0, y, z, r], [20.0, y + 1.0, z, r]])
    };
    let seams = Sdf::Union(vec![seam(97.0, 1.6), seam(74.0, 1.1), seam(54.0, 1.1), seam(35.0, 1.1)], 0.0);
    let bone = lay(cage, &knots, [4.6, 6.2])
        .minus(segment(top - at(0.0, 30.0, -6.0), top + at(0.0, 30.0, 6.0), 12.0, 12.0), 4.0)
        .minus(sphere(facets, 8.0).mirror(), 4.0)
        .minus(seams, 2.0);
    let tip = |z: f32| cage.at(0.0, z, 6.0);
    let xiphoid = strap(tip(6.0), tip(-26.0), at(0.0, 1.0, 0.1), [8.0, 4.0], [3.2, 2.2]);
    union(vec![bone, xiphoid], 2.0)
}
