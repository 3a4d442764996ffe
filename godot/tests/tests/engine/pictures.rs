//! What viewports show is what the renderer makes of the same scenes, pixel by pixel.

use lumivox_core::glam::{DMat3, DVec3};

use crate::case::{Case, Clip, Fog, Light, Mesh, Place, Volume, look_at};
use crate::shown::Shown;

/// Every case, in one run of the engine.
fn cases() -> Vec<Case> {
    let translucent = Volume::soft();
    let turned = Volume {
        place: Place::new(
            DMat3::from_rotation_y(0.7)
                * DMat3::from_rotation_x(0.4)
                * DMat3::from_diagonal(DVec3::new(1.4, 0.7, 1.1)),
            DVec3::new(0.012, 0.004, 0.01),
        ),
        stops: vec![[0.0, 0.2, 0.5, 0.9]],
        anisotropy: -0.3,
        filter: 2,
        ..translucent.clone()
    };
    let far_turned =
        |x: f64, y: f64, z: f64, angle: f64| Place::new(DMat3::from_rotation_y(angle), DVec3::new(x, y, z));
    // By distance above, by height below.
    let fog = Fog {
        color: [0.5, 0.1, 0.3],
        energy: 1.2,
        density: 4.0,
        depth: None,
        height: 0.004,
        height_density: 80.0,
    };
    let behind =
        Mesh { size: [0.2, 0.012, 0.002], place: far_turned(0.0, 0.0, -0.03, 0.0), color: [0.1, 0.8, 0.1] };
    // A plane, what is left of a turned box, and a sphere; half of the head's plane is below.
    let scaled = |x: f64, y: f64, z: f64, size: DVec3| {
        Place::new(DMat3::from_rotation_z(0.5) * DMat3::from_diagonal(size), DVec3::new(x, y, z))
    };
    let clips = vec![
        Clip { shape: 0, place: scaled(0.0, -0.05, 0.0, DVec3::ONE), inverted: false },
        Clip { shape: 1, place: scaled(0.06, 0.05, 0.05, DVec3::new(0.1, 0.14, 0.12)), inverted: true },
        Clip { shape: 2, place: scaled(0.0, 0.0, 0.0, DVec3::splat(0.24)), inverted: false },
    ];
    let haze = vec![[-960.0, 0.0, 1.0], [-850.0, 0.1, 1.0], [500.0, 1.0, 0.0]];
    let behind_table = look_at(DVec3::new(0.5, 0.1, -0.9), DVec3::ZERO);
    vec![
        // As scenes are by default.
        Case { kept_light: true, ..Case::new("cube") },
        Case {
            volumes: vec![Volume {
                clips,
                shown_labels: vec![("air outside", false), ("body", true)],
                ..Volume::head()
            }],
            camera: look_at(DVec3::new(0.25, 0.15, 0.6), DVec3::ZERO),
            ..Case::new("cut_open")
        },
        Case {
            volumes: vec![Volume::head()],
            camera: look_at(DVec3::new(0.35, 0.1, 0.6), DVec3::ZERO),
            ..Case::new("head")
        },
        Case {
            volumes: vec![Volume::borders()],
            camera: look_at(DVec3::new(0.35, 0.1, 0.6), DVec3::ZERO),
            ..Case::new("borders")
        },
        Case { volumes: vec![Volume::table()], camera: behind_table, ..Case::new("patient") },
        Case {
            volumes: vec![Volume { keep_everything: true, ..Volume::table() }],
            camera: behind_table,
            ..Case::new("everything")
        },
        Case {
            volumes: vec![Volume { preset: "ct-airways", knots: haze, ..Volume::table() }],
            camera: behind_table,
            ..Case::new("airways")
        },
        Case {
            volumes: vec![Volume { filter: 3, ..translucent.clone() }, turned.clone()],
            kept_light: true,
            ..Case::new("several_volumes")
        },
        Case {
            volumes: vec![Volume {
                clip_min: [0.1, 0.45, 0.0],
                clip_max: [0.9, 1.0, 0.6],
                filter: 0,
                ..translucent.clone()
            }],
            ..Case::new("clipped")
        },
        Case {
            meshes: vec![
                // In front, behind, and through the middle of the volume.
                Mesh {
                    size: [0.006, 0.02, 0.002],
                    place: far_turned(0.004, 0.004, 0.025, 0.3),
                    color: [0.8, 0.1, 0.1],
                },
                Mesh {
                    size: [0.2, 0.012, 0.002],
                    place: far_turned(0.0, 0.0, -0.03, 0.0),
                    color: [0.1, 0.8, 0.1],
                },
                Mesh {
                    size: [0.003, 0.03, 0.003],
                    place: far_turned(0.0, 0.0, 0.0, 0.6),
                    color: [0.1, 0.2, 0.9],
                },
            ],
            ..Case::new("occlusion")
        },
        Case { fov: 0.0, height: 0.06, volumes: vec![turned.clone()], ..Case::new("parallel") },
        Case { exposure: 1.0, light: Light::Color([0.15, 0.2, 0.3]), ..Case::new("exposure") },
        Case { light: panorama(), volumes: vec![turned], ..Case::new("panorama") },
        // Godot 4.6 makes backgrounds of one colour darker where there is fog: a sky it is.
        Case { fog: Some(fog), light: panorama(), meshes: vec![behind], ..Case::new("fog") },
        Case {
            fog: Some(Fog { density: 0.8, depth: Some([0.07, 0.12, 1.5]), height_density: 0.0, ..fog }),
            light: panorama(),
            meshes: vec![behind],
            ..Case::new("depth_fog")
        },
    ]
}

/// A sky with a bright patch to one side of a turned horizon.
fn panorama() -> Light {
    let (width, height) = (64, 32);
    let texel = |i: usize| {
        let (x, y) = (i % width, i / width);
        let up = 1.0 - y as f32 / height as f32;
        // Once where the camera sees its edge, once where only the volume does.
        let seen = (50..55).contains(&x) && (15..22).contains(&y);
        let bright = (10..16).contains(&x) && (6..12).contains(&y);
        let patch = if bright {
            8.0
        } else if seen {
            0.5
        } else {
            0.0
        };
        [0.1 + 0.3 * up + patch, 0.1 + 0.4 * up + 0.8 * patch, 0.1 + 0.6 * up + 0.5 * patch]
    };
    Light::Panorama {
        width,
        height,
        texels: (0..width * height).map(texel).collect(),
        rotation: 0.9,
        energy: 0.6,
    }
}

fn assert_as_expected(name: &str) {
    static SHOWN: Shown = Shown::new("pictures", cases);
    SHOWN.assert_as_expected(name);
}

#[test]
fn a_volume_looks_as_the_renderer_makes_it() {
    assert_as_expected("cube");
    assert_as_expected("head");
}

#[test]
fn volumes_overlap_rotated_and_scaled() {
    assert_as_expected("several_volumes");
}

#[test]
fn a_clip_box_cuts_along_the_nodes_axes() {
    assert_as_expected("clipped");
}

#[test]
fn shapes_cut_and_labels_hide_as_the_renderer_has_it() {
    assert_as_expected("cut_open");
}

/// A file, saved as a resource, loaded, written and read again.
#[test]
fn a_function_of_value_and_gradient_is_kept_and_shown() {
    assert_as_expected("borders");
}

/// Once the other volume is there: until then, neither is done.
#[test]
fn a_switch_brings_the_table_back_and_a_preset_shows_an_organ_alone() {
    for name in ["patient", "everything", "airways"] {
        assert_as_expected(name);
    }
}

#[test]
fn meshes_hide_and_are_hidden_pixel_by_pixel() {
    assert_as_expected("occlusion");
}

#[test]
fn a_parallel_camera_sees_parallel_rays() {
    assert_as_expected("parallel");
}

#[test]
fn exposure_is_in_stops() {
    assert_as_expected("exposure");
}

#[test]
fn a_panorama_lights_volumes_turned_and_scaled() {
    assert_as_expected("panorama");
}

/// Meshes say whether it is the engine's fog.
#[test]
fn fog_hides_volumes_as_it_hides_meshes() {
    assert_as_expected("fog");
    assert_as_expected("depth_fog");
}
