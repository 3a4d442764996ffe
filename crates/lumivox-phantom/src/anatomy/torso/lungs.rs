//! The lungs: their shape between ribs, diaphragm and mediastinum, their lobes and what parts them.

use glam::Vec3;

use super::{Stuff, body, field, heart, part::TorsoPart, tree};
use crate::{
    anatomy::{material::Material, raster::Layer},
    sdf::{Sdf, at, block, tube, union},
};

/// A lobe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lobe {
    RightUpper,
    RightMiddle,
    RightLower,
    LeftUpper,
    LeftLower,
}

/// The oblique fissures: above and before them lies the upper lobe (on the right the middle one, too).
const OBLIQUE: (Vec3, f32) = (at(0.0, -0.695, 0.719), 24.0);

/// The right lung's horizontal fissure.
const HORIZONTAL: (Vec3, f32) = (at(0.05, 0.10, 0.994), 42.0);

/// Both lungs.
pub(crate) fn shape() -> Sdf {
    Sdf::Intersection(
        vec![
            Sdf::Field(field::CAGE).grow(-2.5),
            Sdf::Not(Box::new(Sdf::Field(field::BELLY).grow(2.5))),
            Sdf::Not(Box::new(mediastinum())),
        ],
        5.0,
    )
}

/// What lies between the lungs, but the heart's chambers, and the spine behind it.
fn mediastinum() -> Sdf {
    let spine = tube(&[
        [0.0, 24.0, 190.0, 22.0],
        [0.0, 42.0, 138.0, 22.0],
        [0.0, 54.0, 97.0, 22.0],
        [0.0, 59.0, 53.0, 23.0],
        [0.0, 58.0, 8.0, 24.0],
        [0.0, 52.0, -41.0, 25.0],
        [0.0, 46.0, -110.0, 26.0],
    ]);
    let upper = tube(&[
        [0.0, -6.0, 190.0, 26.0],
        [1.0, -10.0, 150.0, 32.0],
        [3.0, -10.0, 120.0, 32.0],
        [3.0, -10.0, 95.0, 34.0],
        [2.0, -8.0, 62.0, 34.0],
    ]);
    let behind = tube(&[[8.0, 26.0, 110.0, 22.0], [4.0, 26.0, 60.0, 20.0], [4.0, 20.0, -30.0, 20.0]]);
    let aorta = tube(&[
        [20.0, 12.0, 118.0, 17.0],
        [25.0, 32.0, 104.0, 16.0],
        [25.0, 38.0, 80.0, 15.0],
        [22.0, 34.0, 30.0, 15.0],
        [17.0, 26.0, -20.0, 15.0],
        [10.0, 16.0, -70.0, 15.0],
    ]);
    // Both lungs almost meet behind the sternum.
    let front = block(at(2.0, -66.0, 60.0), [5.0, 34.0], [4.0, 34.0], 66.0, 3.0, glam::Mat3::IDENTITY);
    union(vec![spine, upper, behind, aorta, front, Sdf::Field(field::HEART).grow(5.0)], 12.0)
}

/// The fat around all organs of the trunk, and the diaphragm.
pub(crate) fn cavities(stuff: &Stuff) -> Vec<Layer> {
    let inside = || Sdf::Field(field::CAGE).grow(-1.0);
    let fat = Material::even(-104.0, 10.0, 7.0);
    // Where no lung is between them, the diaphragm lies on the ribs.
    let dome = Sdf::Field(field::BELLY).sheet(1.7).and(inside(), 2.0);
    let crura = tube(&[
        [15.0, 14.0, -66.0, 6.0],
        [13.0, 8.0, -90.0, 6.5],
        [15.0, 8.0, -118.0, 5.5],
        [15.0, 10.0, -150.0, 3.5],
    ])
    .mirror();
    vec![
        stuff.layer(TorsoPart::Fat, inside(), fat),
        stuff.layer(TorsoPart::Muscle, Sdf::Union(vec![dome, crura], 3.0), Material::even(58.0, 8.0, 3.0)),
    ]
}

/// The lungs themselves.
pub(crate) fn layers(stuff: &Stuff) -> Vec<Layer> {
    let lung = || Sdf::Field(field::LUNG);
    let plane = |(normal, offset): (Vec3, f32)| Sdf::HalfSpace { normal, offset };
    let right = || Sdf::HalfSpace { normal: Vec3::X, offset: -8.0 };
    let oblique = plane(OBLIQUE).rough(1.6, 34.0, stuff.seed("fissure"));
    let horizontal = plane(HORIZONTAL)
        .rough(2.0, 30.0, stuff.seed("fissure") ^ 1)
        .sheet(0.3)
        .and(right(), 0.0)
        .minus(plane(OBLIQUE), 0.0);
    let fissures = Sdf::Union(vec![oblique.sheet(0.3), horizontal], 0.0).and(lung(), 0.0);
    vec![
        // Pleura and the fluid film under it.
        stuff.layer(TorsoPart::Lung, lung(), Material::Parenchyma),
        stuff.layer(TorsoPart::Lung, fissures, Material::even(-620.0, 60.0, 9.0)),
    ]
}

/// The lobe of a place in a lung.
fn lobe(p: Vec3) -> Lobe {
    let above = |(normal, offset): (Vec3, f32)| normal.dot(p) > offset;
    match (p.x > 0.0, above(OBLIQUE), above(HORIZONTAL)) {
        (true, true, _) => Lobe::LeftUpper,
        (true, false, _) => Lobe::LeftLower,
        (false, true, true) => Lobe::RightUpper,
        (false, true, false) => Lobe::RightMiddle,
        (false, false, _) => Lobe::RightLower,
    }
}

/// Points all over the lungs, a few mm under the pleura, by lobe.
pub(crate) fn points(stuff: &Stuff) -> Vec<(Lobe, Vec<Vec3>)> {
    const STEP_MM: f32 = 6.0;
    let (belly, heart, lung) = (body::belly(), heart::outside(), shape());
    let inside = |p: Vec3| {
        let mut fields = [f32::MAX; 5];
        fields[field::CAGE] = stuff.cage.distance(p);
        if fields[field::CAGE] > -4.0 {
            return false;
        }
        fields[field::BELLY] = belly.distance(p, &fields);
        if fields[field::BELLY] < 4.0 {
            return false;
        }
        fields[field::HEART] = heart.distance(p, &fields);
        lung.distance(p, &fields) < -2.0
    };
    let all = tree::points_in(at(-132.0, -86.0, -110.0), at(132.0, 92.0, 176.0), STEP_MM, inside);
    [Lobe::RightUpper, Lobe::RightMiddle, Lobe::RightLower, Lobe::LeftUpper, Lobe::LeftLower]
        .into_iter()
        .map(|wanted| (wanted, all.iter().copied().filter(|p| lobe(*p) == wanted).collect()))
        .collect()
}
