#![allow(clippy::disallowed_methods, reason = "tests round as they like")]

use super::*;
use crate::noise::hash64;

fn random_points(n: u64) -> impl Iterator<Item = Vec3> {
    let unit = |i: u64| (hash64(i) >> 40) as f32 / (1 << 24) as f32;
    (0..n).map(move |i| (Vec3::new(unit(3 * i), unit(3 * i + 1), unit(3 * i + 2)) - 0.5) * 80.0)
}

#[test]
fn primitives_know_their_surfaces() {
    assert!((sphere(Vec3::ZERO, 5.0).distance(at(8.0, 0.0, 0.0), &[]) - 3.0).abs() < 1e-3);
    let e = ellipsoid(Vec3::ZERO, at(10.0, 5.0, 3.0));
    for p in [at(10.0, 0.0, 0.0), at(0.0, -5.0, 0.0), at(0.0, 0.0, 3.0)] {
        assert!(e.distance(p, &[]).abs() < 1e-4);
    }
    let b = block(Vec3::ZERO, [4.0, 2.0], [2.0, 1.0], 5.0, 0.5, Mat3::IDENTITY);
    assert!(b.distance(at(4.0, 0.0, -4.5), &[]).abs() < 0.3);
    assert!(b.distance(Vec3::ZERO, &[]) < -1.0);
    let p = plate(Vec3::ZERO, at(10.0, 0.0, 0.0), at(0.0, 10.0, 0.0), 1.0);
    assert!((p.distance(at(2.0, 2.0, 4.0), &[]) - 3.0).abs() < 1e-5);
    let t = tube(&[[0.0, 0.0, 0.0, 2.0], [20.0, 0.0, 0.0, 2.0], [40.0, 0.0, 0.0, 2.0]]);
    assert!((t.distance(at(20.0, 6.0, 0.0), &[]) - 4.0).abs() < 0.2);
}

#[test]
fn a_ring_is_closed() {
    let circle: Vec<Knot> = (0..8)
        .map(|i| (i as f32 * std::f32::consts::TAU / 8.0).sin_cos())
        .map(|(s, c)| [20.0 * c, 20.0 * s, 0.0, 2.0])
        .collect();
    let ring = ring(&circle);
    for i in 0..64 {
        let (s, c) = (i as f32 * 0.0982).sin_cos();
        assert!(ring.distance(at(20.0 * c, 20.0 * s, 0.0), &[]) < -1.0, "{i}");
    }
}

#[test]
fn pruning_does_not_change_what_is_near() {
    let ball =
        |i: f32| sphere(at(i * 7.0 - 30.0, (i * 1.7).sin() * 20.0, (i * 2.3).cos() * 20.0), 4.0 + i * 0.3);
    let shape = union((0..10).map(|i| ball(i as f32)).collect(), 5.0)
        .minus(ellipsoid(at(5.0, 5.0, 0.0), at(12.0, 7.0, 9.0)), 3.0)
        .rough(0.7, 5.0, 1)
        .mirror();
    for center in random_points(200) {
        let region = Region { center, radius: 6.0, fields: &[] };
        let (pruned, [low, high]) = shape.prune(&region);
        for offset in random_points(20) {
            let p = center + offset.normalize() * 6.0 * (offset.x / 40.0).abs();
            let d = shape.distance(p, &[]);
            assert!((low - 1e-3..=high + 1e-3).contains(&d), "{d} in {low}..{high}");
            if d.abs() < 4.0 {
                assert!((pruned.distance(p, &[]) - d).abs() < 1e-3);
            }
        }
    }
}
