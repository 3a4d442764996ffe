//! Liver, gallbladder, spleen, kidneys, pancreas; the thyroid and the adrenal glands.

use glam::Vec3;

use super::{Stuff, body, field, muscles, part::TorsoPart, tree};
use crate::maths;
use crate::{
    anatomy::{material::Material, raster::Layer},
    sdf::{Sdf, at, ellipsoid, plate, segment, sphere, tube, turned_ellipsoid, union},
};

/// Under the diaphragm and inside the ribs.
fn under_dome(shape: Sdf) -> Sdf {
    Sdf::Intersection(
        vec![shape, Sdf::Field(field::BELLY).grow(-2.6), Sdf::Field(field::CAGE).grow(-3.2)],
        4.0,
    )
}

fn liver() -> Sdf {
    let right = ellipsoid(at(-66.0, -2.0, -72.0), at(68.0, 88.0, 88.0));
    let left = turned_ellipsoid(at(6.0, -44.0, -44.0), at(66.0, 40.0, 36.0), maths::turn_y(0.30));
    let visceral = Sdf::HalfSpace { normal: at(0.51, 0.26, -0.82).normalize(), offset: 70.0 };
    // Where the gullet, the spine and the vena cava pass behind, and the cleft between the lobes.
    let hollow = tube(&[[6.0, 40.0, -10.0, 30.0], [2.0, 38.0, -60.0, 32.0], [0.0, 30.0, -120.0, 36.0]]);
    let cleft = plate(at(-6.0, -100.0, -90.0), at(-10.0, -40.0, -96.0), at(-6.0, -100.0, -56.0), 3.0);
    union(vec![right, left], 16.0).and(visceral, 16.0).minus(hollow, 10.0).minus(cleft, 6.0)
}

/// Points all over the liver, for its vessels.
pub(crate) fn liver_points(stuff: &Stuff) -> Vec<Vec3> {
    let (liver, belly) = (liver(), body::belly());
    let inside = |p: Vec3| {
        liver.distance(p, &[]) < -3.0 && belly.distance(p, &[]) < -6.0 && stuff.cage.distance(p) < -7.0
    };
    tree::points_in(at(-132.0, -86.0, -160.0), at(70.0, 92.0, 0.0), 8.0, inside)
}

/// The middle of the left kidney; the right one lies lower.
const KIDNEYS: [(Vec3, f32); 2] = [(at(63.0, 40.0, -108.0), 1.0), (at(-63.0, 40.0, -122.0), -1.0)];

fn kidneys(stuff: &Stuff) -> Vec<Layer> {
    let mut layers = Vec::new();
    for (center, side) in KIDNEYS {
        // The lower end is further out, and the hilum looks forward and inward.
        let axes = maths::turn_y(-0.20 * side) * maths::turn_z(0.45 * side) * maths::turn_x(-0.12);
        let place = |x: f32, y: f32, z: f32| center + axes * at(x * side, y, z);
        let whole = turned_ellipsoid(center, at(26.0, 21.0, 54.0), axes);
        let hilum = segment(place(-30.0, -4.0, -9.0), place(-30.0, -4.0, 9.0), 15.0, 15.0);
        let whole = whole.minus(hilum, 10.0);
        let sinus = union(
            vec![
                segment(place(-6.0, -1.0, -20.0), place(-6.0, -1.0, 20.0), 8.0, 8.0),
                segment(place(-22.0, -4.0, 0.0), place(-6.0, -1.0, 0.0), 12.0, 11.0),
            ],
            8.0,
        );
        let pyramid = |i: usize| {
            let angle = i as f32 / 9.0 * 4.9 - 2.45;
            let (dx, dz) = (maths::cos(angle), maths::sin(angle));
            let (near, far) =
                (place(-4.0 + 7.0 * dx, 0.0, 22.0 * dz), place(-3.0 + 17.0 * dx, 0.0, 39.0 * dz));
            segment(near, far, 3.5, 6.5)
        };
        let pyramids = Sdf::Union((0..10).map(pyramid).collect(), 0.0).and(whole.clone().grow(-6.0), 3.0);
        let pelvis = union(
            vec![
                tube(&[
                    [place(-4.0, -1.0, 0.0).x, place(-4.0, -1.0, 0.0).y, center.z, 4.0],
                    [place(-24.0, -3.0, -4.0).x, place(-24.0, -3.0, -4.0).y, center.z - 6.0, 6.0],
                    [28.0 * side, 14.0, center.z - 44.0, 2.2],
                    [34.0 * side, 4.0, -215.0, 2.0],
                ]),
                segment(place(-6.0, -1.0, -18.0), place(-6.0, -1.0, 18.0), 3.0, 3.0),
            ],
            3.0,
        );
        let blood = stuff.seed("kidney");
        layers.extend([
            stuff.layer(TorsoPart::Kidney, whole.rough(0.6, 14.0, blood), Material::even(196.0, 10.0, 4.0)),
            stuff.layer(TorsoPart::Kidney, pyramids, Material::even(108.0, 8.0, 3.0)),
            stuff.layer(TorsoPart::Fat, sinus, Material::even(-88.0, 14.0, 4.0)),
            stuff.layer(TorsoPart::SoftTissue, pelvis, Material::even(12.0, 4.0, 4.0)),
        ]);
    }
    layers
}

pub(crate) fn layers(stuff: &Stuff) -> Vec<Layer> {
    let spleen = under_dome(
        turned_ellipsoid(at(100.0, 42.0, -66.0), at(25.0, 37.0, 52.0), maths::turn_x(0.45))
            .minus(sphere(at(64.0, 12.0, -64.0), 34.0), 8.0),
    );
    let gallbladder =
        tube(&[[-44.0, -34.0, -92.0, 7.0], [-50.0, -48.0, -104.0, 12.0], [-56.0, -62.0, -116.0, 13.5]]);
    let pancreas = union(
        vec![
            tube(&[
                [-26.0, -22.0, -118.0, 14.0],
                [-14.0, -30.0, -106.0, 13.0],
                [8.0, -30.0, -96.0, 10.0],
                [36.0, -12.0, -92.0, 10.5],
                [64.0, 8.0, -86.0, 9.5],
                [82.0, 22.0, -80.0, 7.0],
            ]),
            tube(&[[-26.0, -22.0, -118.0, 13.0], [-18.0, -20.0, -132.0, 9.0]]),
        ],
        4.0,
    );
    let adrenal = union(
        vec![
            plate(at(34.0, 22.0, -60.0), at(46.0, 30.0, -84.0), at(36.0, 16.0, -84.0), 2.0),
            plate(at(34.0, 22.0, -60.0), at(30.0, 30.0, -84.0), at(36.0, 18.0, -82.0), 2.0),
        ],
        2.0,
    )
    .mirror();
    let thyroid = union(
        vec![
            ellipsoid(at(18.0, -17.0, 202.0), at(8.0, 9.5, 22.0)),
            segment(at(0.0, -27.0, 196.0), at(13.0, -23.0, 198.0), 3.4, 5.0),
        ],
        5.0,
    )
    .mirror();
    let mut layers = muscles::inner(stuff);
    layers.extend(kidneys(stuff));
    layers.extend([
        stuff.layer(TorsoPart::SoftTissue, adrenal, Material::even(62.0, 6.0, 3.0)),
        stuff.layer(
            TorsoPart::SoftTissue,
            thyroid.rough(0.8, 5.0, stuff.seed("thyroid")),
            Material::even(150.0, 10.0, 3.0),
        ),
        stuff.layer(
            TorsoPart::Pancreas,
            pancreas.rough(1.6, 5.0, stuff.seed("pancreas")),
            Material::even(92.0, 22.0, 4.0),
        ),
        // In this phase blood flows through the spleen's pulp unevenly.
        stuff.layer(
            TorsoPart::Spleen,
            spleen.rough(0.8, 16.0, stuff.seed("spleen")),
            Material::even(112.0, 22.0, 7.0),
        ),
        stuff.layer(
            TorsoPart::Liver,
            under_dome(liver()).rough(0.5, 18.0, stuff.seed("liver")),
            Material::even(88.0, 6.0, 8.0),
        ),
        stuff.layer(TorsoPart::Gallbladder, gallbladder.clone(), Material::even(45.0, 6.0, 3.0)),
        stuff.layer(TorsoPart::Gallbladder, gallbladder.grow(-1.6), Material::even(8.0, 4.0, 6.0)),
    ]);
    layers
}
