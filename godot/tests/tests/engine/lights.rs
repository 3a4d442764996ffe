//! The engine's lights: on volumes as the core has them, on the engine's own surfaces as its manual has them.

use lumivox_core::glam::{DMat3, DVec3};

use crate::case::{Case, Lamp, LampKind, Light, Mesh, Place, Volume, look_at};
use crate::expected;
use crate::shown::{Shown, assert_same};

static SHOWN: Shown = Shown::new("lights", cases);

/// A place at `from` whose -z points at `target`.
fn aimed(from: [f64; 3], target: [f64; 3]) -> Place {
    look_at(DVec3::from_array(from), DVec3::from_array(target))
}

fn dark(name: &'static str, lamps: Vec<Lamp>) -> Case {
    Case { light: Light::Color([0.0; 3]), lamps, ..Case::new(name) }
}

fn sun() -> Lamp {
    let place = aimed([0.05, 0.08, 0.06], [0.0; 3]);
    Lamp { color: [1.0, 0.8, 0.5], energy: 1.5, ..Lamp::new(LampKind::Directional, place) }
}

/// Near a corner, so that range and falloff are seen on the way to the others.
fn bulb() -> Lamp {
    Lamp {
        color: [0.4, 0.7, 1.0],
        energy: 0.05,
        range: 0.05,
        ..Lamp::new(LampKind::Omni, aimed([0.02, 0.016, 0.018], [0.0; 3]))
    }
}

fn spot() -> Lamp {
    Lamp {
        energy: 0.2,
        range: 0.2,
        attenuation: 1.5,
        spot_angle: 9.0,
        spot_attenuation: 0.7,
        ..Lamp::new(LampKind::Spot, aimed([-0.03, 0.05, 0.05], [0.002, 0.0, 0.004]))
    }
}

fn cases() -> Vec<Case> {
    let beside = |x: f64, layers: u32| Volume {
        place: Place::new(DMat3::from_diagonal(DVec3::splat(0.8)), DVec3::new(x, 0.0, 0.0)),
        layers,
        ..Volume::soft()
    };
    let wall = |place: Place| Mesh { size: [0.08, 0.06, 0.01], place, color: [1.0; 3] };
    let facing = wall(Place::at(DVec3::new(0.0, 0.0, -0.005)));
    let before_wall = |name, lamps| Case {
        volumes: vec![Volume { visible: false, ..Volume::soft() }],
        lit_meshes: vec![facing],
        camera: look_at(DVec3::new(0.0, 0.0, 0.085), DVec3::ZERO),
        samples: 1,
        ..dark(name, lamps)
    };
    vec![
        dark("sun", vec![sun()]),
        dark("wide_sun", vec![Lamp { size: 60.0, ..sun() }]),
        dark("bulb", vec![bulb()]),
        dark("large_bulb", vec![Lamp { size: 0.015, attenuation: 2.0, energy: 1e-3, ..bulb() }]),
        dark("spot", vec![spot()]),
        dark("large_spot", vec![Lamp { size: 0.01, spot_angle: 30.0, spot_attenuation: 3.0, ..spot() }]),
        Case {
            volumes: vec![beside(-0.014, 1), beside(0.014, 2), beside(0.0, 4 | 8)],
            ..dark(
                "layers",
                vec![
                    Lamp { layers: 1, color: [1.0, 0.1, 0.1], ..sun() },
                    Lamp { layers: 2, color: [0.1, 1.0, 0.1], energy: 0.1, ..spot() },
                    Lamp { layers: 8 | 16, ..bulb() },
                ],
            )
        },
        Case {
            light: Light::Color([0.05, 0.06, 0.1]),
            volumes: vec![Volume { surface: [0.8, 20.0, 0.3, 0.2, 0.0], filter: 2, ..Volume::soft() }],
            ..dark(
                "many_lights",
                vec![
                    Lamp { energy: 0.5, size: 5.0, ..sun() },
                    bulb(),
                    Lamp { size: 0.004, ..spot() },
                    Lamp {
                        energy: 0.1,
                        color: [1.0, 0.2, 0.6],
                        ..Lamp::new(LampKind::Omni, Place::at(DVec3::new(-0.03, -0.01, 0.03)))
                    },
                ],
            )
        },
        before_wall("sun_on_wall", vec![Lamp::new(LampKind::Directional, aimed([0.0, 0.0, 1.0], [0.0; 3]))]),
        before_wall(
            "lamps_on_wall",
            vec![
                Lamp {
                    energy: 0.3,
                    color: [0.5, 0.8, 1.0],
                    ..Lamp::new(LampKind::Directional, aimed([0.5, 0.5, 1.0], [0.0; 3]))
                },
                Lamp {
                    energy: 1e-5,
                    range: 0.05,
                    attenuation: 2.5,
                    ..Lamp::new(LampKind::Omni, Place::at(DVec3::new(-0.02, 0.01, 0.012)))
                },
                Lamp {
                    energy: 0.02,
                    color: [1.0, 0.6, 0.3],
                    range: 0.06,
                    attenuation: 0.8,
                    spot_angle: 25.0,
                    spot_attenuation: 2.0,
                    ..Lamp::new(LampKind::Spot, aimed([0.03, -0.01, 0.025], [0.012, -0.004, 0.0]))
                },
            ],
        ),
    ]
}

#[test]
fn suns_light_volumes() {
    SHOWN.assert_as_expected("sun");
    SHOWN.assert_as_expected("wide_sun");
}

#[test]
fn bulbs_reach_as_far_as_they_do() {
    SHOWN.assert_as_expected("bulb");
    SHOWN.assert_as_expected("large_bulb");
}

#[test]
fn spots_fall_off_to_their_edge() {
    SHOWN.assert_as_expected("spot");
    SHOWN.assert_as_expected("large_spot");
}

#[test]
fn lights_and_volumes_meet_on_layers() {
    SHOWN.assert_as_expected("layers");
}

#[test]
fn many_lights_add_up() {
    SHOWN.assert_as_expected("many_lights");
}

/// The engine's own shader says what an energy of 1 is.
#[test]
fn a_sun_of_energy_one_makes_a_white_wall_white() {
    let shown = SHOWN.screenshot("sun_on_wall", "");
    let middle = shown.pixels[shown.width * (shown.height / 2) + shown.width / 2];
    println!("a white wall in a sun of energy 1 is {middle:?}");
    assert!(middle.iter().all(|&c| c >= 254), "{middle:?}");
    // As a volume has it: an environment of radiance 1 makes a white surface white, so pi arrives.
    let core = SHOWN.case("sun_on_wall").lamps[0].light();
    let lumivox_core::light::LightKind::Directional { irradiance, .. } = core.kind else { panic!() };
    assert_eq!(irradiance, [std::f64::consts::PI; 3]);
}

/// Falloff, cone and angle on the engine's own surface, by the core's formulas.
#[test]
fn the_engines_lamps_follow_the_cores_formulas() {
    let case = SHOWN.case("lamps_on_wall");
    let wanted = expected::picture(&case);
    assert_same(SHOWN.folder(), "lamps_on_wall", &wanted, |_| true);
}
