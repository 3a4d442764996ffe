//! Windpipe and bronchi, and the vessels of the lungs: arteries beside the bronchi, veins between them.

use glam::Vec3;

use super::{
    Stuff,
    lungs::{self, Lobe},
    part::TorsoPart,
    tree::{Branch, Habit, grow},
};
use crate::maths;
use crate::{
    anatomy::{material::Material, raster::Layer},
    grove::{Twig, grove},
    sdf::{Knot, Sdf, at, spline, tube, xyz},
};

/// Where the windpipe parts.
pub(crate) const CARINA: Vec3 = at(1.0, 19.0, 94.0);

/// The middle of the windpipe, from the neck down.
const TRACHEA: [Knot; 5] = [
    [0.0, -20.0, 262.0, 8.6],
    [0.0, -15.0, 200.0, 8.8],
    [-1.0, -6.0, 160.0, 8.8],
    [-1.0, 8.0, 125.0, 8.8],
    [CARINA.x, CARINA.y, CARINA.z, 8.6],
];

/// A stem that the tree of a lobe grows from: its knots, of which the last is where growing begins.
type Stem = (Lobe, &'static [Knot]);

/// The bronchi as far as those of the lobes.
const BRONCHI: [Stem; 5] = [
    (
        Lobe::RightUpper,
        &[
            [1.0, 19.0, 94.0, 7.6],
            [-20.0, 20.0, 76.0, 6.6],
            [-30.0, 18.0, 78.0, 5.0],
            [-42.0, 14.0, 84.0, 4.6],
        ],
    ),
    (Lobe::RightMiddle, &[[-32.0, 16.0, 46.0, 4.6], [-38.0, 6.0, 39.0, 3.6], [-46.0, -8.0, 32.0, 3.3]]),
    (
        Lobe::RightLower,
        &[
            [-20.0, 20.0, 76.0, 6.4],
            [-28.0, 18.0, 60.0, 5.6],
            [-32.0, 17.0, 46.0, 5.2],
            [-40.0, 24.0, 28.0, 4.6],
        ],
    ),
    (
        Lobe::LeftUpper,
        &[
            [1.0, 19.0, 94.0, 7.2],
            [20.0, 21.0, 78.0, 6.2],
            [40.0, 21.0, 65.0, 5.8],
            [50.0, 13.0, 66.0, 4.8],
            [56.0, 6.0, 70.0, 4.6],
        ],
    ),
    (Lobe::LeftLower, &[[40.0, 21.0, 65.0, 5.6], [45.0, 26.0, 54.0, 4.9], [50.0, 31.0, 40.0, 4.6]]),
];

/// The pulmonary arteries as far as the lobes; their trunk is the heart's.
const ARTERIES: [Stem; 5] = [
    (
        Lobe::RightUpper,
        &[
            [15.0, -14.0, 88.0, 11.5],
            [-10.0, -5.0, 83.0, 10.0],
            [-30.0, 0.0, 80.0, 8.0],
            [-42.0, 4.0, 90.0, 5.2],
        ],
    ),
    (Lobe::RightMiddle, &[[-44.0, 6.0, 56.0, 5.0], [-49.0, -2.0, 44.0, 4.0], [-53.0, -12.0, 38.0, 3.4]]),
    (
        Lobe::RightLower,
        &[
            [-22.0, -2.0, 81.0, 9.6],
            [-38.0, 2.0, 72.0, 8.6],
            [-46.0, 11.0, 52.0, 7.0],
            [-50.0, 22.0, 32.0, 5.2],
        ],
    ),
    (Lobe::LeftUpper, &[[24.0, -4.0, 92.0, 9.6], [40.0, 6.0, 94.0, 7.0], [56.0, 0.0, 84.0, 5.2]]),
    (
        Lobe::LeftLower,
        &[
            [15.0, -14.0, 88.0, 11.0],
            [28.0, 0.0, 94.0, 10.0],
            [42.0, 16.0, 89.0, 9.0],
            [53.0, 26.0, 68.0, 7.2],
            [58.0, 34.0, 44.0, 5.4],
        ],
    ),
];

/// The pulmonary veins, from the left atrium.
const VEINS: [Stem; 5] = [
    (Lobe::RightUpper, &[[-16.0, 6.0, 56.0, 7.5], [-36.0, -4.0, 60.0, 6.4], [-46.0, -8.0, 70.0, 5.0]]),
    (Lobe::RightMiddle, &[[-32.0, -2.0, 58.0, 4.6], [-44.0, -12.0, 50.0, 3.6], [-50.0, -20.0, 42.0, 3.2]]),
    (Lobe::RightLower, &[[-14.0, 14.0, 42.0, 7.5], [-34.0, 26.0, 32.0, 6.4], [-44.0, 34.0, 20.0, 5.2]]),
    (Lobe::LeftUpper, &[[26.0, 4.0, 58.0, 7.2], [44.0, -4.0, 62.0, 6.2], [56.0, -10.0, 70.0, 5.2]]),
    (Lobe::LeftLower, &[[26.0, 14.0, 44.0, 7.2], [44.0, 24.0, 36.0, 6.0], [54.0, 36.0, 26.0, 5.2]]),
];

const AIR: Material = Material::even(-1000.0, 0.0, 1.0);

/// Bronchi of smaller radius have walls too thin to be told from the lung, in mm.
const FINEST_BRONCHUS: f32 = 0.85;

/// A stem's end and the way it points.
fn tip(knots: &[Knot]) -> (Vec3, Vec3, f32) {
    let [.., a, b] = knots else { unreachable!("stems have two knots") };
    (xyz(*b), (xyz(*b) - xyz(*a)).normalize(), b[3])
}

/// The lobes' trees, grown from stems.
fn trees(points: &[(Lobe, Vec<Vec3>)], stems: &[Stem], habit: Habit) -> Vec<Branch> {
    let grown = |(lobe, knots): &Stem| {
        let mut points = points.iter().find(|(l, _)| l == lobe).map(|(_, p)| p.clone()).unwrap_or_default();
        let (from, along, radius) = tip(knots);
        grow(&mut points, from, along, radius, habit)
    };
    stems.iter().flat_map(grown).collect()
}

fn stem_twigs(stems: &[Stem]) -> Vec<Twig> {
    let piece = |w: &[Knot]| Twig { a: xyz(w[0]), b: xyz(w[1]), radii: [w[0][3], w[1][3]] };
    stems.iter().flat_map(|(_, knots)| spline(knots).windows(2).map(piece).collect::<Vec<_>>()).collect()
}

pub(crate) fn layers(stuff: &Stuff) -> Vec<Layer> {
    let points = lungs::points(stuff);
    let habit = Habit { reach: 0.40, thinnest: 0.55, fewest: 9, turn: 0.0 };
    let bronchi = trees(&points, &BRONCHI, habit);
    // Arteries keep to the upper and outer side of their bronchi, but start where the hilum has them.
    let beside = |b: &Branch| {
        let side = at(0.62 * b.to.x.signum(), -0.16, 0.77);
        let mut artery = b.beside(side, 1.9);
        if b.generation == 1 {
            let (start, _, radius) = nearest(&ARTERIES, b.from);
            artery.from = start;
            artery.bend = start.lerp(artery.to, 0.45);
            artery.parent_radius = radius;
        }
        artery
    };
    let arteries: Vec<Twig> = bronchi
        .iter()
        .flat_map(|b| beside(b).twigs(|r| 1.04 * r + 0.12))
        .chain(stem_twigs(&ARTERIES))
        .collect();
    let veins = trees(&points, &VEINS, Habit { turn: 0.9, reach: 0.46, ..habit });
    let veins: Vec<Twig> =
        veins.iter().flat_map(|b| b.twigs(|r| 0.95 * r + 0.12)).chain(stem_twigs(&VEINS)).collect();
    let airways: Vec<Twig> = bronchi
        .iter()
        .filter(|b| b.radius > FINEST_BRONCHUS)
        .flat_map(|b| b.twigs(|r| r))
        .chain(stem_twigs(&BRONCHI))
        .collect();
    // Walls: a fifth of the radius, and never thinner than half a millimetre.
    let walls = airways.iter().map(|t| t.grown(0.5 + 0.12 * t.radii[0])).collect();
    let windpipe = tube(&TRACHEA);
    let wall = Sdf::Union(vec![grove(walls, 0.5), windpipe.clone().grow(1.6)], 2.0);
    let air = Sdf::Union(vec![grove(airways, 0.8), windpipe], 3.0);
    let blood = |hu: f32| Material::even(hu, 8.0, 6.0);
    vec![
        stuff.layer(TorsoPart::PulmonaryVein, grove(veins, 0.7), blood(295.0)),
        stuff.layer(TorsoPart::PulmonaryArtery, grove(arteries, 0.7), blood(280.0)),
        stuff.layer(TorsoPart::AirwayWall, wall, Material::even(30.0, 10.0, 3.0)),
        stuff.layer(TorsoPart::AirwayWall, rings(), Material::even(105.0, 20.0, 4.0)),
        stuff.layer(TorsoPart::AirwayAir, air, AIR),
    ]
}

/// The stem that ends nearest to a place.
fn nearest(stems: &[Stem], p: Vec3) -> (Vec3, Vec3, f32) {
    let mut tips: Vec<_> = stems.iter().map(|(_, knots)| tip(knots)).collect();
    tips.sort_by(|s, t| s.0.distance(p).total_cmp(&t.0.distance(p)));
    tips[0]
}

/// The windpipe's cartilage: horseshoes that are open behind.
fn rings() -> Sdf {
    let line = spline(&TRACHEA);
    let ring = |i: usize| {
        let z = 196.0 - 5.6 * i as f32;
        let p = line.iter().map(|k| xyz(*k)).min_by(|a, b| (a.z - z).abs().total_cmp(&(b.z - z).abs()))?;
        let knots: Vec<Knot> = (0..7)
            .map(|j| (j as f32 / 6.0 - 0.5) * 4.2)
            .map(|a| [p.x + 9.6 * maths::sin(a), p.y - 9.6 * maths::cos(a), z, 1.2])
            .collect();
        Some(tube(&knots))
    };
    Sdf::Union((0..17).filter_map(ring).collect(), 0.0)
}
