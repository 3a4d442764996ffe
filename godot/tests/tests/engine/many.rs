//! A hundred volumes in one picture.

use lumivox_core::glam::{DMat3, DQuat, DVec3};

use crate::case::{Case, Place, Volume, look_at};
use crate::shown::Shown;

const COUNT: usize = 100;

/// Numbers in 0..1, always the same.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1 << 24) as f64
    }

    fn vector(&mut self, low: f64, high: f64) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next()) * (high - low) + low
    }
}

fn cases() -> Vec<Case> {
    let mut numbers = Numbers(7);
    let volumes = (0..COUNT).map(|_| {
        let axis = numbers.vector(-1.0, 1.0).normalize_or(DVec3::Y);
        let turn = DMat3::from_quat(DQuat::from_axis_angle(axis, numbers.next() * 6.0));
        let scale = DMat3::from_diagonal(numbers.vector(0.25, 0.9));
        let [r, g, b] = numbers.vector(0.1, 0.95).to_array();
        Volume {
            size: 12,
            place: Place::new(turn * scale, numbers.vector(-0.022, 0.022)),
            stops: vec![[0.0, r, g, b]],
            density: 0.05 + 0.3 * numbers.next(),
            ..Volume::soft()
        }
    });
    vec![Case {
        volumes: volumes.collect(),
        samples: 12,
        camera: look_at(DVec3::new(0.03, 0.03, 0.1), DVec3::ZERO),
        ..Case::new("many_volumes")
    }]
}

#[test]
#[ignore = "slow: script/test --all"]
fn a_hundred_volumes_overlap_in_one_picture() {
    static SHOWN: Shown = Shown::new("many", cases);
    assert_eq!(SHOWN.case("many_volumes").volumes.len(), COUNT);
    SHOWN.assert_as_expected("many_volumes");
}
