//! The surface of the skin: head, face, ears, neck and shoulders.

use glam::{Mat3, Vec3};

use super::skull;
use crate::maths;
use crate::sdf::{Knot, Sdf, at, ellipsoid, ribbon, segment, sphere, strap, tube, turned_ellipsoid, union};

/// Everything inside the skin.
pub(crate) fn skin() -> Sdf {
    let mut body = union(vec![head(), neck(), shoulders()], 26.0);
    body = body.or(larynx(), 12.0).minus(hollows_of_the_neck(), 12.0);
    body = face(body);
    body.or(ear().mirror(), 3.5).minus(ear_canal().mirror(), 1.0)
}

/// The mass of the head without its features.
fn head() -> Sdf {
    let side = union(
        vec![
            // Cheek bone, cheek, the chewing muscle, the jaw's body and angle.
            ellipsoid(at(42.0, -65.0, -8.0), at(22.0, 21.0, 18.0)),
            ellipsoid(at(34.5, -48.0, -33.0), at(24.5, 36.0, 33.0)),
            ellipsoid(at(46.5, -22.0, -34.0), at(13.0, 25.0, 38.0)),
            tube(&[[46.0, -63.0, -6.0, 9.0], [55.5, -44.0, -5.0, 9.5], [58.5, -18.0, -2.0, 10.0]]),
            strap(at(12.0, -77.0, -84.0), at(43.0, -22.0, -62.0), Vec3::X, [16.0, 16.0], [13.0, 12.0]),
        ],
        14.0,
    );
    union(
        vec![
            skull::cranium().grow(5.5),
            ellipsoid(at(0.0, -45.0, 8.0), at(62.0, 51.0, 46.0)),
            ellipsoid(at(0.0, -64.0, -45.0), at(38.0, 37.0, 30.0)),
            ellipsoid(at(0.0, -80.0, -84.0), at(19.0, 17.0, 16.0)),
            side.mirror(),
        ],
        12.0,
    )
}

fn neck() -> Sdf {
    let knots = [
        [0.0, 24.0, -10.0, 50.0],
        [0.0, 15.0, -58.0, 47.0],
        [0.0, 15.0, -105.0, 48.0],
        [0.0, 26.0, -145.0, 52.0],
        [0.0, 34.0, -190.0, 60.0],
    ];
    union(knots.windows(2).map(|w| round(w[0], w[1])).collect(), 4.0)
}

fn round(a: Knot, b: Knot) -> Sdf {
    segment(at(a[0], a[1], a[2]), at(b[0], b[1], b[2]), a[3], b[3])
}

fn shoulders() -> Sdf {
    union(
        vec![
            // The slope of the trapezius, the shoulder, the chest.
            segment(at(26.0, 48.0, -118.0), at(130.0, 46.0, -178.0), 24.0, 36.0).mirror(),
            ellipsoid(at(150.0, 30.0, -205.0), at(58.0, 52.0, 58.0)).mirror(),
            ellipsoid(at(0.0, 34.0, -250.0), at(175.0, 84.0, 92.0)),
            // The clavicle shows.
            tube(&[
                [14.0, -32.0, -180.0, 9.5],
                [58.0, -31.0, -168.0, 9.0],
                [110.0, 10.0, -159.0, 10.0],
                [150.0, 20.0, -157.0, 11.0],
            ])
            .mirror(),
        ],
        22.0,
    )
}

/// Adam's apple and the muscles that draw the neck's outline.
fn larynx() -> Sdf {
    union(
        vec![
            tube(&[
                [0.0, -26.0, -92.0, 9.0],
                [0.0, -33.0, -104.0, 8.5],
                [0.0, -28.0, -124.0, 9.0],
                [0.0, -24.0, -150.0, 9.0],
            ]),
            tube(&[
                [54.0, 14.0, -34.0, 9.0],
                [44.0, 4.0, -80.0, 10.0],
                [30.0, -17.0, -130.0, 9.0],
                [13.0, -31.0, -176.0, 7.0],
            ])
            .mirror(),
        ],
        4.0,
    )
}

/// The notch over the breast bone and the hollows over the clavicles.
fn hollows_of_the_neck() -> Sdf {
    union(
        vec![
            sphere(at(0.0, -48.0, -172.0), 15.0),
            ellipsoid(at(58.0, -22.0, -146.0), at(22.0, 14.0, 12.0)).mirror(),
        ],
        2.0,
    )
}

/// Adds the features of the face to the head.
fn face(head: Sdf) -> Sdf {
    // Eye sockets, then the brow over them.
    let sockets = ellipsoid(at(32.0, -99.0, 13.0), at(19.0, 15.0, 12.0)).mirror();
    let brow = tube(&[
        [0.0, -93.0, 34.0, 7.0],
        [12.0, -93.5, 35.0, 7.0],
        [30.0, -89.0, 37.0, 8.0],
        [46.0, -79.5, 33.0, 8.2],
        [53.0, -68.0, 20.0, 8.2],
        [52.0, -66.0, 4.0, 8.2],
    ]);
    let head = head.minus(sockets, 13.0).or(brow.mirror(), 14.0);
    let head = eyes(head);
    let head = nose(head);
    mouth(head)
}

/// Closed eyes: the lids over the globe, their seam and the fold above.
fn eyes(head: Sdf) -> Sdf {
    let globe = ellipsoid(at(32.0, -77.5, 14.0), at(15.0, 13.2, 12.6)).mirror();
    let head = head.or(globe, 5.0);
    let lid = |points: &[[f32; 3]]| on_front(&head, points, 0.0);
    let seam =
        lid(&[[17.0, 10.5, 0.7], [22.0, 9.0, 0.9], [31.0, 7.4, 0.9], [40.0, 9.0, 0.9], [46.5, 12.0, 0.6]]);
    let fold =
        lid(&[[18.0, 15.0, 0.5], [24.0, 20.0, 0.8], [32.0, 21.6, 0.9], [41.0, 19.6, 0.8], [48.0, 14.0, 0.5]]);
    let pouch = lid(&[[19.0, 5.0, 0.4], [27.0, 0.5, 0.7], [36.0, -0.5, 0.7], [45.0, 3.5, 0.4]]);
    let margin =
        lid(&[[19.0, 11.5, 0.9], [24.0, 10.6, 1.3], [31.0, 9.4, 1.5], [39.0, 10.6, 1.3], [45.0, 12.6, 0.8]]);
    head.or(margin.mirror(), 2.0)
        .minus(seam.mirror(), 1.0)
        .minus(fold.mirror(), 1.6)
        .minus(pouch.mirror(), 2.5)
}

fn nose(head: Sdf) -> Sdf {
    let bridge = tube(&[
        [0.0, -91.5, 28.0, 6.5],
        [0.0, -95.0, 17.0, 6.0],
        [0.0, -101.0, 6.0, 6.6],
        [0.0, -106.0, -6.0, 7.2],
        [0.0, -110.0, -13.0, 8.6],
    ]);
    let tip = union(
        vec![
            ellipsoid(at(3.4, -112.0, -14.5), at(6.0, 7.2, 6.4)).mirror(),
            // Columella and the wings.
            tube(&[[0.0, -112.5, -19.0, 4.0], [0.0, -107.0, -24.0, 3.6], [0.0, -101.0, -28.0, 4.5]]),
            turned_ellipsoid(at(12.6, -103.5, -18.0), at(5.8, 9.5, 7.4), maths::turn_z(-0.28)).mirror(),
        ],
        4.0,
    );
    let flank = ellipsoid(at(8.0, -95.0, -4.0), at(9.0, 11.0, 17.0)).mirror();
    let head = head.or(bridge, 9.0).or(flank, 9.0).or(tip, 5.0);
    // The crease around the wing.
    let crease = tube(&[
        [13.5, -111.0, -9.5, 1.0],
        [17.6, -105.0, -10.5, 1.5],
        [20.0, -99.0, -14.5, 1.9],
        [20.2, -95.5, -21.0, 1.9],
    ]);
    let nostril = tube(&[
        [6.9, -107.6, -28.0, 3.2],
        [6.6, -106.0, -22.0, 3.5],
        [5.6, -101.0, -15.0, 4.0],
        [4.6, -94.0, -10.0, 4.5],
    ]);
    head.minus(crease.mirror(), 3.4).minus(nostril.mirror(), 1.6)
}

fn mouth(head: Sdf) -> Sdf {
    // The ring muscle lifts the mouth's surroundings.
    let barrel = ellipsoid(at(0.0, -80.5, -48.0), at(33.0, 21.0, 24.0));
    let head = head.or(barrel, 20.0);
    let upper = ribbon(
        &[
            [0.0, -101.6, -43.4, 5.0],
            [5.0, -101.9, -42.6, 5.2],
            [12.5, -98.8, -44.2, 4.6],
            [19.5, -94.2, -46.4, 2.9],
            [24.0, -90.2, -47.8, 1.4],
        ],
        Vec3::Y,
        0.98,
    );
    let lower = ribbon(
        &[
            [0.0, -101.0, -54.4, 6.2],
            [8.5, -100.0, -54.2, 6.0],
            [16.0, -96.2, -52.2, 4.5],
            [23.5, -90.4, -49.0, 1.6],
        ],
        Vec3::Y,
        0.98,
    );
    let head = head.or(upper.mirror(), 1.8).or(lower.mirror(), 1.8);
    let seam = on_front(
        &head,
        &[[0.0, -48.6, 0.9], [6.0, -47.9, 0.9], [14.0, -48.4, 0.9], [20.0, -48.3, 1.0], [25.0, -48.2, 1.0]],
        0.0,
    );
    let philtrum = on_front(&head, &[[0.0, -30.0, 2.2], [0.0, -38.5, 2.8]], -1.2);
    let chin_fold = on_front(&head, &[[0.0, -65.0, 4.0], [10.0, -64.5, 3.6], [20.0, -61.0, 2.0]], -2.0);
    let smile_fold = on_front(&head, &[[20.5, -19.0, 1.2], [26.5, -29.0, 1.3], [31.0, -40.0, 0.9]], -0.8);
    let corner = on_front(&head, &[[25.0, -48.2, 1.3], [27.5, -48.0, 1.4]], -0.6);
    head.minus(philtrum, 3.0)
        .minus(chin_fold.mirror(), 7.0)
        .minus(smile_fold.mirror(), 6.0)
        .minus(corner.mirror(), 3.0)
        .minus(seam.mirror(), 1.4)
}

/// A tube along points `(x, z, radius)` of the front of a body, `depth` mm under its surface.
fn on_front(body: &Sdf, points: &[[f32; 3]], depth: f32) -> Sdf {
    let knots: Vec<Knot> = points
        .iter()
        .map(|&[x, z, radius]| {
            let p = project(body, at(x, -170.0, z), Vec3::Y) + Vec3::Y * depth;
            [p.x, p.y, p.z, radius]
        })
        .collect();
    tube(&knots)
}

/// The direction in which a body that uses no shared field ends soonest.
pub(crate) fn normal(body: &Sdf, p: Vec3) -> Vec3 {
    const STEP: f32 = 0.5;
    let slope = |axis: Vec3| body.distance(p + axis * STEP, &[]) - body.distance(p - axis * STEP, &[]);
    at(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z)).normalize_or_zero()
}

/// Where a ray first meets a body that uses no shared field.
pub(crate) fn project(body: &Sdf, from: Vec3, direction: Vec3) -> Vec3 {
    let mut p = from;
    for _ in 0..400 {
        let d = body.distance(p, &[]);
        if d < 0.02 {
            break;
        }
        // Blends overestimate distances a little.
        p += direction * (0.7 * d);
    }
    p
}

/// Patient space from the ear's own axes: u to the back along the auricle, v up, w out, origin at the canal.
fn ear_place(u: f32, v: f32, w: f32) -> Vec3 {
    EAR_ORIGIN + ear_axes() * at(u, v, w)
}

const EAR_ORIGIN: Vec3 = at(71.5, -3.0, -2.0);

fn ear_axes() -> Mat3 {
    // The auricle stands off by 20 degrees and leans back by 12.
    maths::turn_x(-0.2) * maths::turn_z(-0.36) * Mat3::from_cols(Vec3::Y, Vec3::Z, Vec3::X)
}

/// The auricle of the left ear.
pub(crate) fn ear() -> Sdf {
    let axes = ear_axes();
    let body = |u: f32, v: f32, w: f32, radii: Vec3| turned_ellipsoid(ear_place(u, v, w), radii, axes);
    let line = |points: &[[f32; 4]]| {
        let knots: Vec<Knot> = points
            .iter()
            .map(|&[u, v, w, r]| {
                let p = ear_place(u, v, w);
                [p.x, p.y, p.z, r]
            })
            .collect();
        tube(&knots)
    };
    let sheet = union(
        vec![
            body(14.0, 8.0, 1.0, at(15.0, 25.0, 2.4)),
            body(17.0, -9.0, 2.2, at(11.0, 14.0, 2.2)),
            body(7.0, -21.0, -0.5, at(9.0, 11.0, 3.2)),
            body(9.0, 0.0, -4.0, at(12.0, 14.0, 8.0)),
        ],
        4.0,
    );
    let concha = body(7.5, -1.0, 4.5, at(9.5, 12.0, 8.0));
    let scapha = line(&[
        [12.0, 27.0, 3.2, 1.6],
        [22.0, 21.0, 3.6, 2.2],
        [26.0, 8.0, 3.6, 2.2],
        [23.0, -6.0, 3.4, 1.6],
    ]);
    let helix = line(&[
        [6.0, 3.0, 0.0, 2.0],
        [0.0, 8.0, 2.5, 2.3],
        [-1.5, 17.0, 4.0, 2.6],
        [4.0, 28.0, 4.5, 2.9],
        [14.0, 33.5, 5.0, 3.0],
        [24.0, 29.0, 5.5, 3.0],
        [30.0, 17.0, 5.5, 2.8],
        [29.5, 3.0, 4.5, 2.5],
        [25.0, -9.0, 3.5, 2.2],
        [18.0, -19.0, 2.0, 2.2],
    ]);
    let antihelix = line(&[
        [7.0, -13.5, 3.0, 2.6],
        [15.0, -11.0, 4.0, 2.8],
        [20.0, -3.0, 5.0, 2.8],
        [20.5, 7.0, 5.5, 2.7],
        [17.0, 16.0, 4.5, 2.4],
        [11.0, 24.0, 2.5, 2.0],
    ]);
    let lower_crus = line(&[[19.5, 10.0, 4.8, 2.2], [12.0, 15.0, 3.0, 2.0], [4.0, 15.0, 1.5, 1.8]]);
    let tragus = body(-2.6, -2.0, 2.4, at(3.0, 6.0, 3.4));
    sheet
        .minus(concha, 2.5)
        .minus(scapha, 2.0)
        .or(union(vec![helix, antihelix, lower_crus], 1.5), 2.0)
        .or(tragus, 4.0)
}

fn ear_canal() -> Sdf {
    tube(&[[74.0, -1.0, -2.0, 3.4], [64.0, -3.0, -1.0, 3.2], [52.0, -6.0, 0.0, 3.0]])
}
