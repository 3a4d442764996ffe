//! Fluid, hemispheres with folds, ventricles, deep nuclei, cerebellum and brain stem.

use super::{Seeds, field, material::Material, raster::Layer};
use crate::sdf::{Sdf, at, ellipsoid, segment, tube, union};

pub(crate) fn layers(noise: &Seeds) -> Vec<Layer> {
    let cavity = || Sdf::Field(field::CAVITY);
    // The tentorium parts the cerebrum from the cerebellum.
    let normal = at(0.0, 0.12, -0.993);
    let tentorium = |z: f32| Sdf::HalfSpace { normal, offset: normal.dot(at(0.0, 40.0, z)) };
    let behind = Sdf::HalfSpace { normal: at(0.0, -1.0, -0.35), offset: 2.0 };
    let lower_back = tentorium(22.0);
    let cerebrum = cavity().grow(-2.2).minus(Sdf::Not(Box::new(lower_back)).and(behind, 4.0), 4.0);
    let cerebellum = ellipsoid(at(0.0, 44.0, 0.0), at(46.0, 33.0, 21.0))
        .minus(segment(at(0.0, 80.0, -20.0), at(0.0, 70.0, 16.0), 5.0, 3.0), 8.0)
        .and(cavity().grow(-2.0), 2.0);
    let stem = tube(&[
        [0.0, 0.0, 26.0, 13.0],
        [0.0, 2.0, 10.0, 14.5],
        [0.0, 9.0, -6.0, 10.0],
        [0.0, 14.0, -20.0, 6.5],
        [0.0, 19.0, -40.0, 5.0],
    ]);
    let ventricle = union(
        vec![
            // Frontal horn, body, trigone, occipital and temporal horns.
            tube(&[
                [7.0, -38.0, 52.0, 4.0],
                [7.5, -18.0, 59.0, 4.6],
                [11.0, 6.0, 60.0, 4.4],
                [21.0, 28.0, 50.0, 5.6],
                [22.0, 50.0, 44.0, 2.4],
            ]),
            tube(&[[21.0, 28.0, 50.0, 5.0], [29.0, 18.0, 36.0, 2.6], [31.0, -2.0, 26.0, 1.8]]),
        ],
        3.0,
    );
    let middle = union(
        vec![
            ellipsoid(at(0.0, -8.0, 40.0), at(2.2, 12.0, 9.0)),
            ellipsoid(at(0.0, 24.0, 6.0), at(6.0, 5.0, 10.0)),
            segment(at(0.0, 6.0, 28.0), at(0.0, 18.0, 14.0), 1.2, 1.4),
        ],
        2.0,
    );
    let thalamus = ellipsoid(at(11.0, 2.0, 44.0), at(8.0, 14.0, 9.0));
    let basal = ellipsoid(at(24.0, -16.0, 44.0), at(6.0, 16.0, 10.0));
    let choroid = ellipsoid(at(21.0, 27.0, 49.0), at(3.0, 5.0, 3.0));
    let sella = ellipsoid(at(0.0, -25.0, 21.0), at(6.5, 5.0, 4.0));
    let csf = Material::even(6.0, 3.0, 5.0);
    vec![
        Layer::new(cavity(), csf),
        Layer::new(cerebrum, Material::Brain { seed: noise.get("folds") }),
        Layer::new(stem, Material::even(31.0, 3.0, 5.0)),
        Layer::new(cerebellum, Material::Cerebellum),
        Layer::new(Sdf::Union(vec![thalamus, basal], 0.0).mirror(), Material::even(39.0, 3.0, 4.0)),
        Layer::new(Sdf::Union(vec![ventricle.mirror(), middle], 0.0), csf),
        Layer::new(choroid.mirror(), Material::even(130.0, 60.0, 3.0)),
        Layer::new(sella, Material::even(95.0, 10.0, 3.0)),
    ]
}
