//! Aorta and venae cavae with their branches, and the vessels of the liver.

use glam::Vec3;

use super::{Stuff, abdomen, heart::AORTIC_ROOT, part::TorsoPart, tree};
use crate::{
    anatomy::{material::Material, raster::Layer},
    grove::{Twig, grove},
    noise::noise,
    sdf::{Knot, Sdf, at, spline, tube, union, xyz},
};

/// The middle of the aorta, from the heart down.
pub(crate) const AORTA: [Knot; 15] = [
    [AORTIC_ROOT.x, AORTIC_ROOT.y, AORTIC_ROOT.z, 15.0],
    [-8.0, -28.0, 76.0, 15.0],
    [-13.0, -27.0, 98.0, 15.0],
    [-8.0, -19.0, 114.0, 14.2],
    [6.0, -3.0, 121.0, 13.6],
    [19.0, 16.0, 117.0, 13.0],
    [26.0, 32.0, 103.0, 12.6],
    [26.0, 38.0, 80.0, 12.2],
    [23.0, 33.0, 40.0, 11.8],
    [19.0, 25.0, 0.0, 11.4],
    [13.0, 16.0, -40.0, 10.8],
    [7.0, 7.0, -75.0, 10.2],
    [4.0, 0.0, -105.0, 9.6],
    [3.0, -5.0, -140.0, 9.0],
    [2.0, -9.5, -198.0, 8.4],
];

/// Branches of the aorta. Those for both sides are given for the left.
const BRANCHES: [&[Knot]; 14] = [
    // Common iliac arteries.
    &[[2.0, -10.0, -198.0, 6.4], [14.0, -10.0, -224.0, 5.4], [36.0, 0.0, -264.0, 5.0]],
    &[[2.0, -10.0, -198.0, 6.4], [-12.0, -11.0, -224.0, 5.4], [-34.0, 0.0, -264.0, 5.0]],
    // Brachiocephalic trunk, right subclavian and carotid artery.
    &[[-8.0, -16.0, 122.0, 7.0], [-18.0, -13.0, 146.0, 6.4], [-26.0, -6.0, 162.0, 6.0]],
    &[
        [-26.0, -6.0, 162.0, 4.8],
        [-44.0, 4.0, 171.0, 4.6],
        [-74.0, 2.0, 166.0, 4.4],
        [-104.0, 2.0, 154.0, 4.2],
        [-132.0, 8.0, 142.0, 4.0],
    ],
    &[[-26.0, -6.0, 162.0, 4.2], [-28.0, -6.0, 190.0, 3.8], [-30.0, -6.0, 262.0, 3.6]],
    // Left carotid and subclavian artery.
    &[[5.0, -5.0, 126.0, 4.6], [14.0, -5.0, 150.0, 4.0], [27.0, -6.0, 190.0, 3.8], [30.0, -6.0, 262.0, 3.6]],
    &[
        [16.0, 10.0, 124.0, 5.4],
        [24.0, 12.0, 152.0, 5.0],
        [40.0, 8.0, 171.0, 4.7],
        [74.0, 2.0, 166.0, 4.4],
        [104.0, 2.0, 154.0, 4.2],
        [132.0, 8.0, 142.0, 4.0],
    ],
    // Coeliac trunk: hepatic, splenic and left gastric artery.
    &[
        [5.0, 0.0, -88.0, 4.4],
        [6.0, -14.0, -87.0, 4.0],
        [-6.0, -24.0, -88.0, 3.4],
        [-30.0, -22.0, -84.0, 3.0],
        [-46.0, -18.0, -70.0, 2.4],
    ],
    &[
        [6.0, -14.0, -87.0, 3.4],
        [26.0, -14.0, -80.0, 3.2],
        [40.0, -4.0, -90.0, 3.1],
        [58.0, 6.0, -80.0, 3.0],
        [74.0, 22.0, -84.0, 2.8],
        [88.0, 32.0, -72.0, 2.4],
    ],
    &[
        [6.0, -14.0, -87.0, 2.4],
        [14.0, -22.0, -72.0, 2.1],
        [28.0, -20.0, -60.0, 1.8],
        [38.0, -30.0, -76.0, 1.5],
    ],
    // Superior mesenteric artery, and what it sends to the bowel.
    &[
        [4.0, -6.0, -103.0, 4.2],
        [4.0, -18.0, -112.0, 3.8],
        [2.0, -26.0, -138.0, 3.4],
        [-4.0, -30.0, -172.0, 2.8],
        [-14.0, -32.0, -215.0, 2.2],
    ],
    &[[2.0, -26.0, -138.0, 2.0], [22.0, -34.0, -148.0, 1.8], [46.0, -40.0, -152.0, 1.4]],
    &[[0.0, -28.0, -156.0, 2.0], [20.0, -38.0, -174.0, 1.7], [40.0, -42.0, -186.0, 1.3]],
    &[[0.0, -27.0, -146.0, 2.0], [-30.0, -40.0, -150.0, 1.8], [-64.0, -40.0, -156.0, 1.4]],
];

const PAIRED: [&[Knot]; 3] = [
    // Vertebral and internal thoracic artery, suprascapular.
    &[[36.0, 9.0, 168.0, 2.0], [24.0, 12.0, 182.0, 1.9], [18.0, 10.0, 262.0, 1.8]],
    &[
        [40.0, 6.0, 168.0, 1.8],
        [26.0, -14.0, 148.0, 1.6],
        [22.0, -40.0, 124.0, 1.5],
        [22.0, -61.0, 92.0, 1.4],
        [22.0, -73.0, 60.0, 1.3],
        [23.0, -80.0, 10.0, 1.1],
        [24.0, -82.0, -40.0, 1.0],
    ],
    &[[44.0, 8.0, 170.0, 1.7], [70.0, 30.0, 168.0, 1.5], [108.0, 48.0, 150.0, 1.2]],
];

/// The renal arteries, left and right, and where they part in the kidneys.
const RENAL: [&[Knot]; 8] = [
    &[[8.0, 0.0, -112.0, 3.4], [30.0, 14.0, -114.0, 3.2], [46.0, 28.0, -110.0, 2.8]],
    &[[46.0, 28.0, -110.0, 2.2], [54.0, 33.0, -92.0, 1.7], [60.0, 36.0, -80.0, 1.2]],
    &[[46.0, 28.0, -110.0, 2.2], [56.0, 35.0, -110.0, 1.8], [66.0, 38.0, -106.0, 1.2]],
    &[[46.0, 28.0, -110.0, 2.2], [54.0, 33.0, -126.0, 1.7], [60.0, 36.0, -136.0, 1.2]],
    &[[-2.0, 0.0, -116.0, 3.4], [-26.0, 14.0, -120.0, 3.2], [-46.0, 28.0, -124.0, 2.8]],
    &[[-46.0, 28.0, -124.0, 2.2], [-54.0, 33.0, -106.0, 1.7], [-60.0, 36.0, -94.0, 1.2]],
    &[[-46.0, 28.0, -124.0, 2.2], [-56.0, 35.0, -124.0, 1.8], [-66.0, 38.0, -120.0, 1.2]],
    &[[-46.0, 28.0, -124.0, 2.2], [-54.0, 33.0, -140.0, 1.7], [-60.0, 36.0, -150.0, 1.2]],
];

const VEINS: [&[Knot]; 9] = [
    // Upper vena cava with both brachiocephalic veins.
    &[
        [-30.0, -13.0, 156.0, 7.4],
        [-29.0, -16.0, 130.0, 9.0],
        [-28.0, -12.0, 98.0, 10.0],
        [-27.0, -6.0, 70.0, 10.5],
    ],
    &[
        [31.0, -13.0, 158.0, 7.0],
        [14.0, -28.0, 143.0, 7.0],
        [-10.0, -30.0, 132.0, 7.2],
        [-27.0, -18.0, 124.0, 7.6],
    ],
    // Azygos vein and its arch.
    &[
        [-2.0, 22.0, -60.0, 2.6],
        [-6.0, 31.0, 0.0, 3.0],
        [-8.0, 33.0, 60.0, 3.4],
        [-10.0, 27.0, 100.0, 3.8],
        [-20.0, 12.0, 108.0, 4.0],
        [-27.0, -4.0, 104.0, 4.2],
    ],
    // Lower vena cava, renal veins.
    &[
        [-24.0, -2.0, 14.0, 12.0],
        [-23.0, 2.0, -10.0, 12.0],
        [-25.0, 2.0, -50.0, 12.0],
        [-22.0, -4.0, -100.0, 11.0],
        [-19.0, -7.0, -150.0, 10.6],
        [-18.0, -8.0, -215.0, 10.0],
    ],
    &[
        [56.0, 32.0, -112.0, 3.0],
        [44.0, 22.0, -115.0, 4.0],
        [22.0, 0.0, -115.0, 4.4],
        [3.0, -15.0, -114.0, 4.2],
        [-16.0, -8.0, -114.0, 5.0],
    ],
    &[[-56.0, 32.0, -126.0, 3.0], [-44.0, 20.0, -127.0, 4.2], [-28.0, 2.0, -124.0, 5.0]],
    // Portal vein, of the splenic and the superior mesenteric one.
    &[[-5.0, -24.0, -103.0, 6.8], [-24.0, -26.0, -88.0, 6.4], [-42.0, -20.0, -72.0, 6.0]],
    &[
        [92.0, 36.0, -76.0, 3.0],
        [72.0, 18.0, -90.0, 4.0],
        [40.0, -4.0, -97.0, 4.4],
        [14.0, -20.0, -101.0, 4.8],
        [-5.0, -24.0, -103.0, 5.6],
    ],
    &[
        [-18.0, -34.0, -215.0, 3.6],
        [-10.0, -30.0, -160.0, 5.0],
        [-7.0, -28.0, -125.0, 5.6],
        [-5.0, -24.0, -103.0, 6.0],
    ],
];

const PAIRED_VEINS: [&[Knot]; 2] = [
    // Internal jugular and subclavian vein.
    &[[37.0, -10.0, 262.0, 6.0], [38.0, -10.0, 190.0, 6.4], [31.0, -13.0, 157.0, 7.0]],
    &[
        [128.0, -6.0, 140.0, 4.6],
        [96.0, -14.0, 150.0, 5.0],
        [62.0, -18.0, 160.0, 5.4],
        [31.0, -13.0, 157.0, 6.0],
    ],
];

/// The tubes of vessels that wind a little, except at their ends.
fn wound(knots: &[Knot], side: f32, seed: u32) -> Sdf {
    let points = spline(knots);
    let last = points.len() - 1;
    let wound: Vec<Knot> = points
        .iter()
        .enumerate()
        .map(|(i, &[x, y, z, r])| {
            let p = at(x * side, y, z);
            let free = 1.2 * (i.min(last - i) as f32 / 3.0).min(1.0);
            let shift = |s: u32| free * noise(p / 11.0, seed ^ s);
            [p.x + shift(1), y + shift(2), z + shift(3), r]
        })
        .collect();
    tube(&wound)
}

/// The vessels of the liver: portal branches with arteries beside them, hepatic veins between.
fn liver_vessels(stuff: &Stuff) -> [Vec<Twig>; 3] {
    let points = abdomen::liver_points(stuff);
    let habit = tree::Habit { reach: 0.40, thinnest: 0.8, fewest: 12, turn: 0.0 };
    let portal = tree::grow(&mut points.clone(), at(-42.0, -20.0, -72.0), at(-0.7, 0.1, 0.5), 6.0, habit);
    let habit = tree::Habit { turn: 0.8, reach: 0.46, ..habit };
    let hepatic = tree::grow(&mut points.clone(), at(-24.0, -1.0, -24.0), at(-0.35, -0.4, -0.8), 7.5, habit);
    let side = at(0.3, -0.8, 0.4).normalize();
    let arteries = portal.iter().filter(|b| b.radius > 1.6).map(|b| b.beside(side, 1.0));
    [
        portal.iter().flat_map(|b| b.twigs(|r| r)).collect(),
        hepatic.iter().flat_map(|b| b.twigs(|r| r)).collect(),
        arteries.flat_map(|b| b.twigs(|r| 0.4 * r)).collect(),
    ]
}

pub(crate) fn layers(stuff: &Stuff) -> Vec<Layer> {
    let seed = stuff.seed("torso vessels");
    let both = |list: &[&[Knot]]| -> Vec<Sdf> {
        list.iter().flat_map(|knots| [1.0, -1.0].map(|side| wound(knots, side, seed))).collect()
    };
    let single =
        |list: &[&[Knot]]| -> Vec<Sdf> { list.iter().map(|knots| wound(knots, 1.0, seed)).collect() };
    let [portal, hepatic, hepatic_arteries] = liver_vessels(stuff);
    let arteries = [vec![tube(&AORTA)], single(&BRANCHES), single(&RENAL), both(&PAIRED)].concat();
    let veins = union([single(&VEINS), both(&PAIRED_VEINS)].concat(), 1.2);
    // Late arterial phase: the renal veins and the portal vein have blood with contrast already, those of the legs
    // and of the liver hardly.
    let even = |hu: f32, amplitude: f32| Material::even(hu, amplitude, 9.0);
    vec![
        stuff.layer(TorsoPart::Vein, grove(hepatic, 1.0), even(122.0, 5.0)),
        stuff.layer(TorsoPart::Vein, grove(portal, 1.0), even(156.0, 6.0)),
        stuff.layer(TorsoPart::Vein, veins, even(152.0, 10.0)),
        stuff.layer(TorsoPart::Artery, grove(hepatic_arteries, 0.5), even(280.0, 6.0)),
        stuff.layer(TorsoPart::Artery, union(arteries, 1.5), even(305.0, 8.0)),
        stuff.layer(TorsoPart::Artery, plaques(), even(620.0, 160.0)),
    ]
}

/// Lime in the wall of the aorta, as most people above fifty have it.
fn plaques() -> Sdf {
    let plaque = |(x, y, z, r): (f32, f32, f32, f32)| {
        let p: Vec3 = at(x, y, z);
        let line = spline(&AORTA);
        let nearest = line.iter().min_by(|a, b| xyz(**a).distance(p).total_cmp(&xyz(**b).distance(p)));
        let k = nearest.copied().unwrap_or(AORTA[0]);
        let out = (p - xyz(k)).normalize_or(Vec3::X);
        let q = xyz(k) + out * (k[3] - 0.6);
        let (u, _) = out.any_orthonormal_pair();
        tube(&[
            [q.x - u.x * r, q.y - u.y * r, q.z - u.z * r, 0.8],
            [q.x, q.y, q.z, 1.1],
            [q.x + u.x * r, q.y + u.y * r, q.z + u.z * r, 0.7],
        ])
    };
    let places = [
        (16.0, 0.0, 136.0, 3.0),
        (40.0, 30.0, 104.0, 2.0),
        (10.0, -10.0, -120.0, 2.5),
        (-10.0, -6.0, -150.0, 3.0),
        (14.0, -14.0, -170.0, 3.5),
        (-6.0, -22.0, -190.0, 3.0),
    ];
    Sdf::Union(places.into_iter().map(plaque).collect(), 0.0)
}
