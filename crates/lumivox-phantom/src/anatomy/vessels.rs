//! Arteries and veins, filled with contrast as some 25 seconds after the injection: arteries bright, veins far
//! less.

use super::{Seeds, face, material::Material, raster::Layer};
use crate::{
    noise::noise,
    sdf::{Knot, Sdf, at, tube, union},
};

pub(crate) fn layers(skin: &Sdf, noise: &Seeds) -> Vec<Layer> {
    let course = Course { skin, seed: noise.get("vessels") };
    let veins = course.both(&veins(), &superficial_veins());
    let arteries = course.both(&arteries(), &superficial_arteries());
    let midline = Sdf::Union(
        [
            // Basilar artery, the anterior communicating and the pericallosal arteries.
            tube(&[[0.0, 6.0, -12.0, 2.0], [0.0, -9.0, 6.0, 1.9], [0.0, -13.0, 20.0, 2.0]]),
            tube(&[
                [1.5, -38.0, 30.0, 1.3],
                [1.6, -46.0, 46.0, 1.3],
                [1.8, -38.0, 66.0, 1.2],
                [1.8, -10.0, 74.0, 1.1],
                [1.8, 20.0, 70.0, 1.0],
            ]),
        ]
        .to_vec(),
        0.0,
    );
    let sinus = tube(&[
        [0.0, -77.0, 66.0, 1.8],
        [0.0, -50.0, 99.0, 2.4],
        [0.0, 0.0, 113.0, 3.0],
        [0.0, 46.0, 102.0, 3.4],
        [0.0, 73.0, 68.0, 3.8],
        [0.0, 77.0, 30.0, 4.2],
        [0.0, 77.0, 18.0, 4.6],
    ]);
    vec![
        Layer::new(union(vec![veins, sinus], 1.5), Material::even(114.0, 5.0, 6.0)),
        Layer::new(union(vec![arteries, midline], 1.0), Material::even(335.0, 8.0, 6.0)),
    ]
}

/// Lays vessels out: those under the skin follow it, all wind a little, and differently on both sides.
struct Course<'a> {
    skin: &'a Sdf,
    seed: u32,
}

impl Course<'_> {
    /// Deep vessels by their knots, and superficial ones by (x, y, z, radius) near the skin, on both sides.
    fn both(&self, deep: &[&[Knot]], superficial: &[&[Knot]]) -> Sdf {
        let mut tubes = Vec::new();
        for side in [1.0, -1.0] {
            for knots in deep {
                tubes.push(self.wind(knots, side, 0.8));
            }
            for knots in superficial {
                let laid: Vec<Knot> = knots.iter().map(|k| self.under_skin(*k)).collect();
                tubes.push(self.wind(&laid, side, 1.0));
            }
        }
        union(tubes, 0.8)
    }

    fn wind(&self, knots: &[Knot], side: f32, amount: f32) -> Sdf {
        let points = crate::sdf::spline(knots);
        let last = points.len() - 1;
        let wound: Vec<Knot> = points
            .iter()
            .enumerate()
            .map(|(i, &[x, y, z, r])| {
                let p = at(x * side, y, z);
                // Branches stay where they join.
                let free = amount * (i.min(last - i) as f32 / 3.0).min(1.0);
                let shift = |s: u32| 1.5 * free * noise(p / 7.0, self.seed ^ s);
                [p.x + shift(1), y + shift(2), z + shift(3), r]
            })
            .collect();
        tube(&wound)
    }

    /// The knot moved along the skin's normal until its tube lies just under the skin.
    fn under_skin(&self, [x, y, z, r]: Knot) -> Knot {
        let mut p = at(x, y, z);
        for _ in 0..12 {
            p -= face::normal(self.skin, p) * (self.skin.distance(p, &[]) + r + 2.2);
        }
        [p.x, p.y, p.z, r]
    }
}

fn arteries() -> Vec<&'static [Knot]> {
    const COMMON: &[Knot] = &[
        [18.0, 4.0, -196.0, 4.2],
        [22.0, 2.0, -160.0, 3.7],
        [24.0, -3.0, -125.0, 3.6],
        [27.0, -5.0, -96.0, 4.4],
    ];
    const INTERNAL: &[Knot] = &[
        [27.0, -5.0, -96.0, 4.2],
        [29.0, 1.0, -76.0, 3.0],
        [28.0, -2.0, -50.0, 2.6],
        [26.0, 1.0, -28.0, 2.5],
        [26.0, 0.0, -10.0, 2.5],
        [18.0, -14.0, -1.0, 2.4],
        [13.0, -20.0, 8.0, 2.4],
        [12.0, -32.0, 14.0, 2.4],
        [13.0, -36.0, 21.0, 2.3],
        [14.0, -30.0, 27.0, 2.2],
    ];
    const MIDDLE_CEREBRAL: &[Knot] = &[
        [14.0, -30.0, 27.0, 2.0],
        [26.0, -30.0, 28.0, 1.8],
        [40.0, -26.0, 32.0, 1.6],
        [46.0, -14.0, 42.0, 1.4],
        [50.0, 6.0, 54.0, 1.2],
        [54.0, 24.0, 66.0, 1.0],
    ];
    const MIDDLE_CEREBRAL_LOW: &[Knot] = &[
        [40.0, -26.0, 32.0, 1.5],
        [50.0, -8.0, 34.0, 1.2],
        [54.0, 14.0, 38.0, 1.1],
        [50.0, 36.0, 44.0, 0.9],
    ];
    const ANTERIOR_CEREBRAL: &[Knot] =
        &[[14.0, -30.0, 27.0, 1.7], [7.0, -35.0, 28.0, 1.5], [1.5, -38.0, 30.0, 1.4]];
    const POSTERIOR_CEREBRAL: &[Knot] = &[
        [0.0, -13.0, 20.0, 1.8],
        [8.0, -12.0, 22.0, 1.6],
        [17.0, 2.0, 25.0, 1.5],
        [16.0, 22.0, 28.0, 1.3],
        [12.0, 48.0, 34.0, 1.1],
    ];
    const COMMUNICATING: &[Knot] =
        &[[14.0, -30.0, 25.0, 1.1], [11.0, -20.0, 23.0, 1.1], [9.0, -12.0, 22.0, 1.1]];
    const VERTEBRAL: &[Knot] = &[
        [24.0, 12.0, -178.0, 2.2],
        [18.0, 12.0, -140.0, 2.1],
        [18.5, 11.5, -107.0, 2.0],
        [18.0, 12.0, -74.0, 2.0],
        [22.0, 14.0, -58.0, 2.0],
        [30.5, 9.5, -40.0, 2.0],
        [27.0, 22.0, -29.0, 2.0],
        [12.0, 22.0, -22.0, 2.0],
        [5.0, 8.0, -14.0, 1.9],
        [0.0, 5.0, -11.0, 1.9],
    ];
    const EXTERNAL: &[Knot] = &[
        [27.0, -5.0, -96.0, 3.4],
        [26.0, -14.0, -80.0, 2.7],
        [33.0, -14.0, -60.0, 2.5],
        [46.0, -8.0, -38.0, 2.2],
        [55.0, -8.0, -16.0, 2.0],
    ];
    const MAXILLARY: &[Knot] = &[
        [52.0, -8.0, -22.0, 1.8],
        [46.0, -24.0, -18.0, 1.7],
        [36.0, -38.0, -14.0, 1.6],
        [26.0, -46.0, -8.0, 1.4],
    ];
    const LINGUAL: &[Knot] = &[
        [26.0, -14.0, -84.0, 1.7],
        [20.0, -32.0, -82.0, 1.6],
        [13.0, -52.0, -76.0, 1.4],
        [8.0, -70.0, -66.0, 1.1],
    ];
    const SUPERIOR_THYROID: &[Knot] = &[
        [27.0, -8.0, -92.0, 1.6],
        [23.0, -24.0, -98.0, 1.5],
        [21.0, -24.0, -116.0, 1.3],
        [18.0, -26.0, -130.0, 1.1],
    ];
    const OCCIPITAL: &[Knot] = &[
        [27.0, -8.0, -76.0, 1.7],
        [38.0, 6.0, -52.0, 1.6],
        [48.0, 26.0, -26.0, 1.5],
        [44.0, 50.0, -14.0, 1.4],
        [36.0, 68.0, 0.0, 1.3],
    ];
    const SUBCLAVIAN: &[Knot] = &[
        [14.0, 10.0, -196.0, 5.0],
        [24.0, 12.0, -180.0, 4.8],
        [44.0, 8.0, -166.0, 4.4],
        [64.0, 2.0, -170.0, 4.2],
        [96.0, 4.0, -186.0, 4.0],
    ];
    const THYROCERVICAL: &[Knot] =
        &[[34.0, 10.0, -172.0, 1.8], [34.0, 2.0, -148.0, 1.5], [22.0, 0.0, -138.0, 1.2]];
    const SUPRASCAPULAR: &[Knot] =
        &[[34.0, 8.0, -166.0, 1.5], [60.0, 12.0, -164.0, 1.4], [96.0, 36.0, -172.0, 1.2]];
    vec![
        COMMON,
        INTERNAL,
        MIDDLE_CEREBRAL,
        MIDDLE_CEREBRAL_LOW,
        ANTERIOR_CEREBRAL,
        POSTERIOR_CEREBRAL,
        COMMUNICATING,
        VERTEBRAL,
        EXTERNAL,
        MAXILLARY,
        LINGUAL,
        SUPERIOR_THYROID,
        OCCIPITAL,
        SUBCLAVIAN,
        THYROCERVICAL,
        SUPRASCAPULAR,
    ]
}

/// Arteries in front of the muscles: the facial, and the temporal with its two branches.
fn superficial_arteries() -> Vec<&'static [Knot]> {
    const FACIAL: &[Knot] = &[
        [40.0, -44.0, -84.0, 1.9],
        [46.0, -52.0, -74.0, 1.8],
        [41.0, -66.0, -62.0, 1.7],
        [33.0, -84.0, -50.0, 1.6],
        [25.0, -92.0, -34.0, 1.5],
        [19.0, -98.0, -14.0, 1.3],
        [13.0, -96.0, 8.0, 1.1],
    ];
    const LABIAL: &[Knot] =
        &[[32.0, -84.0, -48.0, 1.3], [20.0, -98.0, -42.0, 1.2], [6.0, -104.0, -40.0, 1.0]];
    const TEMPORAL: &[Knot] = &[[64.0, -12.0, -10.0, 1.9], [68.0, -14.0, 8.0, 1.8], [70.0, -17.0, 26.0, 1.7]];
    const FRONTAL_BRANCH: &[Knot] = &[
        [70.0, -17.0, 26.0, 1.5],
        [66.0, -38.0, 42.0, 1.4],
        [58.0, -58.0, 54.0, 1.3],
        [44.0, -76.0, 68.0, 1.2],
        [30.0, -80.0, 84.0, 1.0],
    ];
    const PARIETAL_BRANCH: &[Knot] = &[
        [70.0, -17.0, 26.0, 1.5],
        [72.0, -8.0, 48.0, 1.4],
        [68.0, 2.0, 70.0, 1.3],
        [58.0, 6.0, 92.0, 1.2],
        [42.0, 8.0, 110.0, 1.0],
    ];
    const OCCIPITAL_BRANCH: &[Knot] =
        &[[36.0, 70.0, 0.0, 1.4], [34.0, 84.0, 20.0, 1.3], [38.0, 84.0, 44.0, 1.2], [32.0, 80.0, 66.0, 1.0]];
    const TRANSVERSE_FACIAL: &[Knot] =
        &[[64.0, -14.0, -14.0, 1.2], [62.0, -36.0, -16.0, 1.1], [52.0, -62.0, -22.0, 0.9]];
    vec![FACIAL, LABIAL, TEMPORAL, FRONTAL_BRANCH, PARIETAL_BRANCH, OCCIPITAL_BRANCH, TRANSVERSE_FACIAL]
}

fn veins() -> Vec<&'static [Knot]> {
    const INTERNAL_JUGULAR: &[Knot] = &[
        [30.0, 10.0, -16.0, 4.2],
        [33.0, 8.0, -44.0, 5.0],
        [36.0, 4.0, -80.0, 5.6],
        [37.0, -2.0, -120.0, 6.2],
        [32.0, -8.0, -160.0, 6.6],
        [24.0, -12.0, -186.0, 6.6],
    ];
    const SIGMOID: &[Knot] = &[
        [2.0, 77.0, 18.0, 4.2],
        [26.0, 70.0, 16.0, 4.0],
        [46.0, 48.0, 12.0, 4.0],
        [48.0, 26.0, 2.0, 4.0],
        [38.0, 16.0, -10.0, 4.0],
        [30.0, 10.0, -16.0, 4.2],
    ];
    const SUBCLAVIAN: &[Knot] =
        &[[24.0, -14.0, -184.0, 5.6], [50.0, -16.0, -178.0, 5.0], [96.0, -4.0, -190.0, 4.6]];
    const COMMON_FACIAL: &[Knot] =
        &[[42.0, -44.0, -82.0, 2.2], [42.0, -26.0, -84.0, 2.4], [37.0, 0.0, -96.0, 2.8]];
    const RETROMANDIBULAR: &[Knot] =
        &[[60.0, -8.0, -8.0, 1.9], [57.0, -4.0, -38.0, 2.2], [52.0, -6.0, -66.0, 2.2]];
    vec![INTERNAL_JUGULAR, SIGMOID, SUBCLAVIAN, COMMON_FACIAL, RETROMANDIBULAR]
}

fn superficial_veins() -> Vec<&'static [Knot]> {
    const EXTERNAL_JUGULAR: &[Knot] = &[
        [54.0, -6.0, -66.0, 2.2],
        [56.0, 4.0, -92.0, 2.4],
        [56.0, 6.0, -122.0, 2.4],
        [58.0, -4.0, -150.0, 2.5],
    ];
    const ANTERIOR_JUGULAR: &[Knot] =
        &[[11.0, -40.0, -110.0, 1.4], [12.0, -38.0, -130.0, 1.5], [14.0, -36.0, -160.0, 1.6]];
    const FACIAL: &[Knot] = &[
        [44.0, -44.0, -82.0, 2.0],
        [51.0, -50.0, -70.0, 1.9],
        [45.0, -66.0, -48.0, 1.8],
        [33.0, -86.0, -22.0, 1.6],
        [18.0, -92.0, 4.0, 1.4],
        [9.0, -96.0, 30.0, 1.2],
        [10.0, -94.0, 60.0, 1.0],
    ];
    const TEMPORAL: &[Knot] =
        &[[66.0, -4.0, -4.0, 1.7], [70.0, -2.0, 20.0, 1.6], [72.0, 8.0, 44.0, 1.4], [66.0, 18.0, 76.0, 1.2]];
    vec![EXTERNAL_JUGULAR, ANTERIOR_JUGULAR, FACIAL, TEMPORAL]
}

/// Where the patient's left common carotid artery runs at the height of the thyroid gland, in patient mm.
#[cfg(test)]
pub(crate) const LEFT_CAROTID: glam::Vec3 = at(24.0, -3.0, -125.0);
