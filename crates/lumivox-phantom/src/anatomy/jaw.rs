//! The lower jaw and the teeth.

use glam::{Mat3, Vec3};

use super::{Seeds, material::Material, raster::Layer};
use crate::maths;
use crate::sdf::{Sdf, at, block, ellipsoid, plate, segment, sphere, tube, turned_ellipsoid, union};

pub(crate) fn layers(noise: &Seeds) -> Vec<Layer> {
    let bone = Material::Bone { cortex_mm: 2.3, cortex: 1350.0, spongy: 380.0 };
    let canal = tube(&[
        [45.5, -26.0, -40.0, 1.2],
        [42.0, -31.0, -64.0, 1.2],
        [28.0, -57.0, -77.0, 1.2],
        [23.5, -67.0, -78.0, 1.4],
    ]);
    let foramen = segment(at(24.0, -70.0, -78.0), at(27.0, -80.0, -77.0), 1.8, 2.0);
    let jaw =
        mandible().minus(union(vec![canal, foramen], 0.5).mirror(), 0.8).rough(0.35, 6.0, noise.get("jaw"));
    vec![Layer::new(jaw, bone)]
}

fn mandible() -> Sdf {
    let side = union(
        vec![
            // Lower border, body, alveolar border.
            tube(&[
                [0.0, -80.5, -91.0, 6.2],
                [14.0, -76.5, -90.5, 6.2],
                [28.0, -62.0, -86.5, 5.6],
                [39.0, -42.0, -79.0, 5.2],
                [46.0, -25.0, -68.0, 4.8],
            ]),
            tube(&[
                [0.0, -81.5, -80.0, 5.6],
                [13.0, -77.5, -80.0, 5.6],
                [26.0, -63.0, -77.0, 5.6],
                [36.5, -45.0, -71.0, 5.4],
                [45.0, -28.0, -62.0, 4.6],
            ]),
            tube(&[
                [0.0, -86.5, -69.0, 5.2],
                [10.0, -84.6, -69.0, 5.2],
                [18.5, -77.8, -68.5, 5.4],
                [25.0, -66.0, -67.5, 5.5],
                [30.0, -51.0, -65.0, 5.6],
                [37.0, -37.0, -60.0, 4.6],
            ]),
            // The ramus with angle, coronoid process and neck.
            plate(at(46.0, -19.0, -66.0), at(42.0, -40.0, -62.0), at(49.0, -14.0, -18.0), 3.4),
            plate(at(42.0, -40.0, -62.0), at(46.0, -38.0, -18.0), at(49.0, -14.0, -18.0), 2.8),
            plate(at(42.0, -42.0, -55.0), at(45.5, -40.0, -8.0), at(46.5, -30.0, -24.0), 2.2),
            segment(at(48.5, -14.0, -24.0), at(50.5, -13.0, -9.0), 4.0, 3.8),
            turned_ellipsoid(at(51.0, -13.0, -6.5), at(9.0, 4.6, 4.8), maths::turn_z(-0.3)),
            tube(&[[49.0, -12.0, -24.0, 3.6], [47.5, -12.5, -45.0, 3.8], [46.0, -18.0, -64.0, 4.2]]),
        ],
        4.0,
    );
    let notch = ellipsoid(at(48.0, -26.5, -12.0), at(9.0, 8.5, 10.0));
    let side = side.minus(notch, 3.0);
    union(
        vec![
            side.mirror(),
            // The chin.
            ellipsoid(at(0.0, -85.5, -86.0), at(9.0, 5.0, 7.0)),
            ellipsoid(at(11.0, -82.5, -91.0), at(6.0, 4.5, 4.5)).mirror(),
        ],
        5.0,
    )
}

/// One tooth for x > 0: where it stands on the arch and how large it is, in mm.
struct Tooth {
    /// Width along the arch and thickness across it.
    width: f32,
    thickness: f32,
    /// Height of the crown and length of the root.
    crown: f32,
    root: f32,
    /// Thickness of the biting edge over the crown's own.
    edge: f32,
    roots: usize,
}

const fn tooth(width: f32, thickness: f32, crown: f32, root: f32, edge: f32, roots: usize) -> Tooth {
    Tooth { width, thickness, crown, root, edge, roots }
}

/// From the midline to the wisdom tooth.
const UPPER: [Tooth; 8] = [
    tooth(8.6, 7.0, 10.5, 12.5, 0.34, 1),
    tooth(6.8, 6.2, 9.6, 12.5, 0.34, 1),
    tooth(7.8, 8.0, 10.2, 16.0, 0.42, 1),
    tooth(7.1, 9.0, 8.4, 13.5, 0.84, 1),
    tooth(6.9, 9.0, 8.0, 13.5, 0.86, 1),
    tooth(10.2, 11.0, 7.4, 12.5, 0.9, 3),
    tooth(9.6, 11.0, 7.2, 11.5, 0.9, 3),
    tooth(8.8, 10.0, 6.6, 10.5, 0.9, 2),
];

const LOWER: [Tooth; 8] = [
    tooth(5.3, 6.0, 9.0, 12.0, 0.34, 1),
    tooth(5.9, 6.3, 9.2, 13.0, 0.34, 1),
    tooth(6.9, 7.6, 10.4, 15.0, 0.42, 1),
    tooth(7.0, 7.7, 8.6, 13.5, 0.8, 1),
    tooth(7.1, 8.2, 8.0, 13.5, 0.86, 1),
    tooth(11.0, 10.3, 7.4, 13.0, 0.9, 2),
    tooth(10.5, 10.0, 7.2, 12.5, 0.9, 2),
    tooth(9.8, 9.5, 6.8, 11.0, 0.9, 2),
];

/// The lower first molar carries the filling.
const FILLED_TOOTH: usize = 5;

/// A row of teeth: where the crowns' necks stand on the arch.
struct Arch {
    teeth: &'static [Tooth; 8],
    /// Half width and depth of the arch, and its front.
    half_width: f32,
    depth: f32,
    front: f32,
    /// Height of the biting edge at the front, its fall per mm to the back, and +1 where crowns point down.
    edge: f32,
    slope: f32,
    root_up: f32,
}

const UPPER_ARCH: Arch = Arch {
    teeth: &UPPER,
    half_width: 29.5,
    depth: 50.0,
    front: -93.0,
    edge: -54.0,
    slope: 0.04,
    root_up: 1.0,
};

const LOWER_ARCH: Arch = Arch {
    teeth: &LOWER,
    half_width: 28.0,
    depth: 49.0,
    front: -90.2,
    edge: -52.6,
    slope: 0.02,
    root_up: -1.0,
};

impl Arch {
    /// The place on the arch (half an ellipse) at `length` mm from the midline, with its outward direction.
    fn place(&self, length: f32) -> (Vec3, Vec3) {
        let point = |t: f32| {
            at(self.half_width * maths::sin(t), self.front + self.depth * (1.0 - maths::cos(t)), 0.0)
        };
        let (mut t, mut walked) = (0.0f32, 0.0);
        while walked < length {
            walked += point(t).distance(point(t + 0.002));
            t += 0.002;
        }
        let tangent = (point(t + 0.01) - point(t - 0.01)).normalize();
        let p = point(t);
        let back = p.y - self.front;
        (p + Vec3::Z * (self.edge + self.slope * back), at(tangent.y, -tangent.x, 0.0))
    }
}

struct Row {
    enamel: Sdf,
    dentin: Sdf,
    filling: Vec3,
}

fn row(arch: &Arch) -> Row {
    let (mut enamel, mut dentin) = (Vec::new(), Vec::new());
    let mut filling = Vec3::ZERO;
    let mut along = 0.0;
    for (i, tooth) in arch.teeth.iter().enumerate() {
        let (edge, out) = arch.place(along + tooth.width / 2.0);
        along += tooth.width * 0.985;
        let root = Vec3::Z * arch.root_up;
        let side = out.cross(root);
        // Local axes: along the arch, across it, from the neck to the edge.
        let axes = Mat3::from_cols(side, out, -root);
        let middle = edge + root * (tooth.crown / 2.0);
        let neck = edge + root * tooth.crown;
        let (w, t) = (tooth.width / 2.0 - 0.15, tooth.thickness / 2.0);
        let front = if tooth.edge < 0.5 { 0.12 } else { 0.0 };
        let tilt = axes * maths::turn_x(front);
        let mut crown =
            block(middle, [w * 0.78, t * 0.86], [w, t * tooth.edge], tooth.crown / 2.0, 1.3, tilt)
                .or(turned_ellipsoid(middle + root * 1.2, at(w, t * 0.96, tooth.crown * 0.42), axes), 1.6);
        if tooth.edge > 0.5 {
            // Fissures between the cusps.
            crown = crown
                .minus(segment(edge + side * (w + 1.0), edge - side * (w + 1.0), 0.8, 0.8), 1.4)
                .minus(segment(edge + out * (t + 1.0), edge - out * (t + 1.0), 0.6, 0.6), 1.2);
        }
        enamel.push(crown);
        let apex = neck + root * tooth.root - out * if tooth.edge < 0.5 { 2.5 } else { 0.5 };
        let roots = (0..tooth.roots).map(|r| {
            let spread =
                if tooth.roots == 1 { 0.0 } else { (r as f32 / (tooth.roots - 1) as f32 - 0.5) * 1.0 };
            segment(neck + side * (spread * w), apex + side * (spread * w * 1.4), t.min(w) * 0.72, 1.0)
        });
        dentin.push(union(roots.collect(), 2.0));
        dentin.push(block(
            middle + root * 0.9,
            [w * 0.7, t * 0.7],
            [w * 0.6, t * tooth.edge * 0.5],
            tooth.crown / 2.0 - 0.9,
            0.8,
            tilt,
        ));
        if i == FILLED_TOOTH {
            filling = edge + root * 0.6;
        }
    }
    Row { enamel: Sdf::Union(enamel, 0.0), dentin: Sdf::Union(dentin, 0.0), filling }
}

/// Dentin, enamel, and an amalgam filling in the patient's left lower first molar.
pub(crate) fn tooth_layers() -> Vec<Layer> {
    let (upper, lower) = (row(&UPPER_ARCH), row(&LOWER_ARCH));
    let both = |a: Sdf, b: Sdf| Sdf::Union(vec![a, b], 0.0).mirror();
    let filling = union(vec![sphere(lower.filling, 2.4), sphere(lower.filling + Vec3::Y * 2.0, 1.8)], 1.0);
    vec![
        Layer::new(both(upper.enamel, lower.enamel), Material::even(2450.0, 80.0, 2.0)),
        Layer::new(both(upper.dentin, lower.dentin), Material::even(1650.0, 60.0, 2.0)),
        Layer::new(filling, Material::even(3071.0, 0.0, 1.0)),
    ]
}

/// Where the filling is, in patient mm.
#[cfg(test)]
pub(crate) fn filling() -> Vec3 {
    row(&LOWER_ARCH).filling
}
