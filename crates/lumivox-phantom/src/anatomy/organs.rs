//! Eyes, airways, larynx and glands.

use glam::{Mat3, Vec3};

use super::{Seeds, face, field, material::Material, raster::Layer, skull};
use crate::maths;
use crate::sdf::{
    Sdf, at, block, ellipsoid, plate, quad, ribbon, ring, segment, sphere, strap, tube, turned_ellipsoid,
    union,
};

const MUCOSA: Material = Material::even(35.0, 6.0, 3.0);
const AIR: Material = Material::even(-1000.0, 0.0, 1.0);

pub(crate) fn layers(noise: &Seeds) -> Vec<Layer> {
    let mut layers = glands(noise);
    layers.extend(eyes());
    layers.extend(larynx());
    layers.extend(cartilage_of_nose_and_ear());
    layers.extend(airways(noise));
    layers
}

/// Where the globes are, patient's left.
const EYE: Vec3 = at(32.0, -76.5, 14.5);

fn eyes() -> Vec<Layer> {
    let orbit = skull::orbit().and(Sdf::Field(field::SKIN).grow(-4.0), 1.0);
    let apex = at(17.0, -43.0, 19.0);
    let rectus = |dx: f32, dz: f32| {
        let side = EYE + at(dx * 12.4, 3.0, dz * 12.4);
        let belly = (side + apex) / 2.0 + at(dx * 4.0 + 1.0, 4.0, dz * 4.0);
        ribbon(
            &[
                [side.x, side.y - 6.0, side.z, 3.6],
                [belly.x, belly.y, belly.z, 5.0],
                [apex.x, apex.y, apex.z, 2.2],
            ],
            at(dx, 0.2, dz),
            0.45,
        )
    };
    let recti =
        Sdf::Union(vec![rectus(1.0, 0.0), rectus(-1.0, 0.0), rectus(0.0, 1.0), rectus(0.0, -1.0)], 0.0);
    let nerve = tube(&[
        [30.5, -66.0, 15.0, 2.4],
        [25.0, -55.0, 18.5, 2.3],
        [17.0, -42.0, 20.0, 2.2],
        [6.0, -30.0, 22.0, 2.4],
    ]);
    let cornea = union(vec![sphere(EYE, 12.1), sphere(EYE - Vec3::Y * 5.2, 8.0)], 1.5);
    let lacrimal = ellipsoid(at(46.0, -76.0, 25.0), at(5.0, 7.0, 6.0));
    vec![
        Layer::new(orbit, Material::even(-85.0, 15.0, 4.0)),
        Layer::new(lacrimal.mirror(), Material::even(40.0, 8.0, 2.0)),
        Layer::new(recti.mirror(), Material::even(58.0, 10.0, 2.5)),
        Layer::new(nerve.mirror(), Material::even(40.0, 4.0, 3.0)),
        Layer::new(cornea.mirror(), Material::even(62.0, 5.0, 3.0)),
        Layer::new(sphere(EYE, 10.9).mirror(), Material::even(8.0, 3.0, 3.0)),
        Layer::new(
            ellipsoid(EYE - Vec3::Y * 7.2, at(4.8, 2.3, 4.8)).mirror(),
            Material::even(115.0, 4.0, 2.0),
        ),
    ]
}

/// Nose, sinuses, throat and windpipe.
fn airways(noise: &Seeds) -> Vec<Layer> {
    let nasal = || {
        let vestibule =
            tube(&[[6.6, -106.0, -23.0, 5.2], [5.6, -100.0, -14.0, 5.6], [5.0, -92.0, -8.0, 5.0]]).mirror();
        skull::nasal_cavity()
            .and(Sdf::HalfSpace { normal: at(0.0, -1.0, 0.0), offset: 92.0 }, 3.0)
            .or(vestibule, 3.0)
    };
    // Curled shells leave narrow passages.
    let septum = strap(at(0.0, -100.0, -4.0), at(0.0, -40.0, -4.0), Vec3::X, [24.0, 24.0], [1.9, 1.9]);
    let turbinate = |x: f32, z: f32, front: f32, r: f32| {
        tube(&[[x, front, z, r * 0.8], [x - 0.5, front + 16.0, z - 1.0, r], [x, -48.0, z, r * 0.7]])
    };
    let shells =
        union(vec![turbinate(7.5, -15.0, -84.0, 4.4), turbinate(6.0, -1.0, -78.0, 3.2)], 0.0).mirror();
    let nostril = tube(&[
        [6.9, -109.0, -30.0, 3.0],
        [6.6, -106.0, -22.0, 3.5],
        [5.6, -101.0, -15.0, 4.0],
        [5.0, -90.0, -9.0, 4.0],
    ])
    .mirror();
    let passages = nasal().grow(-1.3).minus(septum, 1.0).minus(shells, 1.0).or(nostril, 1.5);
    let throat = tube(&[
        [0.0, -36.0, -8.0, 9.0],
        [0.0, -24.0, -22.0, 8.0],
        [0.0, -17.0, -42.0, 6.5],
        [0.0, -17.0, -66.0, 6.5],
        [0.0, -18.0, -84.0, 7.5],
        [0.0, -19.0, -96.0, 6.0],
    ]);
    let glottis = strap(at(0.0, -21.0, -95.0), at(0.0, -20.0, -113.0), Vec3::X, [9.0, 8.0], [6.5, 2.4]);
    let trachea = tube(&[
        [0.0, -20.0, -112.0, 6.0],
        [0.0, -19.0, -124.0, 8.4],
        [0.0, -11.0, -155.0, 8.6],
        [0.0, 3.0, -190.0, 8.6],
    ]);
    let larynx_air = |by: f32| union(vec![throat.clone(), glottis.clone(), trachea.clone()], 3.0).grow(by);
    let epiglottis = strap(at(0.0, -24.0, -92.0), at(0.0, -21.0, -78.0), Vec3::Y, [5.0, 8.0], [1.4, 1.2]);
    let mouth = strap(at(-9.0, -66.0, -36.5), at(9.0, -66.0, -36.5), Vec3::Z, [14.0, 14.0], [1.2, 1.2]);
    let sinuses = || skull::sinuses(noise);
    let ear_canal =
        tube(&[[76.0, -1.0, -2.0, 3.2], [64.0, -3.0, -1.0, 3.0], [50.0, -6.5, 0.0, 2.8]]).mirror();
    vec![
        Layer::new(larynx_air(2.2), MUCOSA),
        Layer::new(nasal(), MUCOSA),
        Layer::new(sinuses(), MUCOSA),
        Layer::new(sinuses().grow(-0.9), AIR),
        Layer::open(
            Sdf::Union(vec![passages, larynx_air(0.0).minus(epiglottis, 0.6), mouth, ear_canal], 0.0),
            AIR,
        ),
    ]
}

/// Thyroid and cricoid cartilage, the rings of the windpipe, epiglottis.
fn larynx() -> Vec<Layer> {
    let lamina = quad(
        [at(0.8, -40.5, -99.0), at(1.0, -37.5, -115.0), at(18.0, -18.0, -117.0), at(19.5, -14.0, -98.0)],
        1.6,
    );
    let horns = tube(&[[19.5, -14.0, -86.0, 1.3], [19.5, -14.0, -100.0, 1.7], [17.5, -17.0, -121.0, 1.4]]);
    let cricoid = ring(&[
        [0.0, -33.0, -120.0, 2.6],
        [10.0, -26.0, -119.0, 2.8],
        [9.0, -13.0, -117.0, 3.8],
        [0.0, -9.0, -116.0, 4.4],
        [-9.0, -13.0, -117.0, 3.8],
        [-10.0, -26.0, -119.0, 2.8],
    ]);
    let rings = (0..8).map(|i| {
        let t = i as f32 / 7.0;
        let (y, z) = (-18.0 + 17.0 * t, -128.0 - 52.0 * t);
        tube(&[
            [7.5, y + 6.0, z, 1.3],
            [9.6, y, z, 1.5],
            [6.8, y - 7.2, z, 1.5],
            [0.0, y - 10.2, z, 1.5],
            [-6.8, y - 7.2, z, 1.5],
            [-9.6, y, z, 1.5],
            [-7.5, y + 6.0, z, 1.3],
        ])
    });
    let cartilage = Material::even(108.0, 22.0, 3.0);
    vec![
        Layer::new(union(vec![lamina, horns], 1.5).mirror(), cartilage),
        Layer::new(cricoid, cartilage),
        Layer::new(Sdf::Union(rings.collect(), 0.0), Material::even(100.0, 15.0, 3.0)),
    ]
}

/// What gives the nose and the ears their shape.
fn cartilage_of_nose_and_ear() -> Vec<Layer> {
    let lateral = plate(at(1.5, -101.5, 8.0), at(1.5, -113.0, -8.0), at(11.0, -102.0, -8.0), 1.3);
    let alar = tube(&[
        [1.6, -111.5, -23.0, 1.3],
        [2.4, -116.0, -17.0, 1.7],
        [6.0, -115.5, -13.0, 1.9],
        [11.5, -109.0, -12.5, 1.9],
        [14.0, -102.5, -15.0, 1.5],
    ]);
    let septal = plate(at(0.0, -99.0, 10.0), at(0.0, -114.0, -14.0), at(0.0, -97.0, -26.0), 1.2);
    let cartilage = Material::even(95.0, 14.0, 2.5);
    vec![
        Layer::new(union(vec![lateral, alar], 1.0).mirror(), cartilage),
        Layer::new(septal, cartilage),
        Layer::open(face::ear().mirror().grow(-1.3), cartilage),
    ]
}

fn glands(noise: &Seeds) -> Vec<Layer> {
    let lobe = union(
        vec![
            ellipsoid(at(17.0, -19.0, -133.0), at(8.0, 9.5, 22.0)),
            segment(at(0.0, -29.0, -134.0), at(13.0, -25.0, -134.0), 4.0, 5.0),
        ],
        6.0,
    );
    let parotid = union(
        vec![
            turned_ellipsoid(at(62.0, -14.0, -28.0), at(7.0, 16.0, 26.0), maths::turn_z(-0.2)),
            ellipsoid(at(50.0, -4.0, -34.0), at(9.0, 8.0, 18.0)),
        ],
        6.0,
    );
    let submandibular = ellipsoid(at(32.0, -42.0, -88.0), at(8.0, 16.0, 11.0));
    let under_skin = || Sdf::Field(field::SKIN).grow(-3.5);
    let oesophagus = tube(&[[-1.0, -6.0, -122.0, 5.5], [-3.0, 4.0, -150.0, 6.0], [-3.0, 18.0, -190.0, 6.5]]);
    let tonsil = ellipsoid(at(15.0, -28.0, -48.0), at(5.0, 7.0, 11.0));
    // Buccal fat, in front of the chewing muscle, is purer than the fat around it.
    let buccal = ellipsoid(at(44.0, -50.0, -30.0), at(7.0, 14.0, 20.0));
    let soft_palate = plate(at(-9.0, -42.0, -32.0), at(9.0, -42.0, -32.0), at(0.0, -22.0, -47.0), 3.2);
    let airway_front = block(at(0.0, -24.0, -120.0), [6.0, 4.0], [6.0, 4.0], 8.0, 2.0, Mat3::IDENTITY);
    vec![
        Layer::new(buccal.mirror(), Material::even(-108.0, 6.0, 5.0)),
        Layer::new(
            parotid.mirror().and(under_skin(), 1.5).rough(1.2, 5.0, noise.get("parotid")),
            Material::even(26.0, 26.0, 3.2),
        ),
        Layer::new(
            submandibular.mirror().and(under_skin(), 1.5).rough(0.8, 4.0, noise.get("gland")),
            Material::even(88.0, 12.0, 3.0),
        ),
        Layer::new(tonsil.mirror(), Material::even(75.0, 8.0, 3.0)),
        Layer::new(soft_palate, Material::even(55.0, 8.0, 3.0)),
        Layer::new(oesophagus, Material::even(52.0, 10.0, 3.0)),
        Layer::new(airway_front, Material::even(50.0, 8.0, 3.0)),
        Layer::new(lobe.mirror().rough(0.8, 5.0, noise.get("thyroid")), Material::even(110.0, 8.0, 3.0)),
    ]
}
