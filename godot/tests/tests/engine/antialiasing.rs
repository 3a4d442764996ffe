//! Viewports that smooth, scale, blend and see through: the volumes in them stay what they are.

use lumivox_core::glam::DVec3;
use lumivox_testing::png_io::SrgbImage;

use crate::case::{Case, Light, Mesh, Output, Place, Volume};
use crate::expected;
use crate::shown::{Shown, assert_same, difference};

static SHOWN: Shown = Shown::new("antialiasing", cases);

fn with(name: &'static str, change: impl FnOnce(&mut Output)) -> Case {
    let mut case = Case::new(name);
    change(&mut case.output);
    case
}

/// One before the volume, one through it.
fn bars() -> Vec<Mesh> {
    let bar = |z: f64, y: f64, color| Mesh {
        size: [0.1, 0.004, 0.004],
        place: Place::at(DVec3::new(0.0, y, z)),
        color,
    };
    vec![bar(0.02, 0.006, [0.8, 0.1, 0.1]), bar(0.0, -0.003, [0.1, 0.8, 0.2])]
}

fn pane(z: f64) -> Mesh {
    Mesh { size: [0.03, 0.03, 0.0005], place: Place::at(DVec3::new(0.004, 0.004, z)), color: [0.1, 0.1, 0.9] }
}

fn cases() -> Vec<Case> {
    let solid = |name| Case { volumes: vec![Volume::solid()], ..Case::new(name) };
    vec![
        with("msaa_4x", |o| o.msaa = 4),
        Case { meshes: bars(), ..with("msaa_4x_meshes", |o| o.msaa = 4) },
        with("hdr", |o| o.hdr = true),
        Case { exposure: 0.5, ..with("transparent", |o| o.transparent = true) },
        with("transparent_msaa_hdr", |o| (o.transparent, o.msaa, o.hdr) = (true, 4, true)),
        with("half", |o| o.scale = 0.5),
        with("fsr1", |o| (o.scale, o.scaling) = (0.77, 1)),
        with("fsr2", |o| (o.scale, o.scaling) = (0.77, 2)),
        with("taa", |o| o.taa = true),
        with("taa_msaa", |o| (o.taa, o.msaa) = (true, 4)),
        Case { meshes: bars(), ..with("taa_meshes", |o| o.taa = true) },
        Case { glass: vec![pane(0.03)], ..solid("glass_before") },
        Case { glass: vec![pane(-0.03)], ..solid("glass_behind") },
        Case {
            glass: vec![pane(-0.03)],
            output: Output { msaa: 4, ..Case::new("").output },
            ..solid("glass_behind_msaa")
        },
    ]
}

/// Everything but pixels within one of where `mask` changes.
fn away_from_edges<T: PartialEq>(case: &Case, mask: &[T]) -> Vec<bool> {
    let [width, height] = case.size.map(|n| n as usize);
    let at = |x: usize, y: usize| &mask[y.min(height - 1) * width + x.min(width - 1)];
    (0..width * height)
        .map(|i| {
            let (x, y) = (i % width, i / width);
            let around = (0..9).map(|n| at((x + n % 3).max(1) - 1, (y + n / 3).max(1) - 1));
            around.into_iter().all(|m| *m == mask[i])
        })
        .collect()
}

fn assert_as_expected_away_from_meshes(name: &str) {
    let case = SHOWN.case(name);
    let inside = away_from_edges(&case, &expected::seen(&case, &case.meshes));
    assert_same(SHOWN.folder(), name, &expected::picture(&case), |i| inside[i]);
}

#[test]
fn multisampling_changes_nothing_inside() {
    SHOWN.assert_as_expected("msaa_4x");
    assert_as_expected_away_from_meshes("msaa_4x_meshes");
}

#[test]
fn a_viewport_of_high_range_shows_the_same() {
    SHOWN.assert_as_expected("hdr");
}

#[test]
fn a_transparent_viewport_has_the_volumes_alpha() {
    for name in ["transparent", "transparent_msaa_hdr"] {
        let case = SHOWN.case(name);
        let film = expected::film(&case);
        let exposure = case.exposure.exp2();
        let pixels = 0..case.size[0] as usize * case.size[1] as usize;
        // Nothing is behind: the light alone, in proportion to the alpha already.
        let light: Vec<[f64; 3]> = pixels.clone().map(|p| film.radiance(p).map(|c| c * exposure)).collect();
        let [width, height] = case.size.map(|n| n as usize);
        assert_same(SHOWN.folder(), name, &SrgbImage::from_linear(width, height, &light), |_| true);
        let shown = SHOWN.screenshot(name, "_alpha");
        let mut sum = 0.0;
        for p in pixels.clone() {
            sum += (f64::from(shown.pixels[p][0]) / 255.0 - film.alpha(p)).abs();
        }
        let mean = sum / pixels.len() as f64;
        println!("{name}: alpha differs by {mean:.4} on average");
        assert!(mean < 0.004, "{name}: alpha differs by {mean}");
    }
}

/// What a smaller picture shows, stretched by linear interpolation.
fn stretched(small: &Case, size: [u32; 2]) -> SrgbImage {
    let linear = expected::linear(small);
    let [from, to] = [small.size, size].map(|s| s.map(|n| n as usize));
    let place = |i: usize, axis: usize| {
        let x = ((i as f64 + 0.5) * from[axis] as f64 / to[axis] as f64 - 0.5)
            .clamp(0.0, (from[axis] - 1) as f64);
        let low = (x as usize).min(from[axis].saturating_sub(2));
        (low, x - low as f64)
    };
    let mut pixels = vec![];
    for y in 0..to[1] {
        for x in 0..to[0] {
            let ((left, u), (top, v)) = (place(x, 0), place(y, 1));
            let texel = |dx: usize, dy: usize| linear[(top + dy) * from[0] + left + dx];
            pixels.push(std::array::from_fn(|i| {
                let row = |dy| texel(0, dy)[i] * (1.0 - u) + texel(1, dy)[i] * u;
                row(0) * (1.0 - v) + row(1) * v
            }));
        }
    }
    SrgbImage::from_linear(to[0], to[1], &pixels)
}

#[test]
fn a_scaled_viewport_traces_fewer_pixels() {
    for (name, most) in [("half", 0.2), ("fsr1", 2.5)] {
        let case = SHOWN.case(name);
        let size = case.size.map(|n| (f64::from(n) * case.output.scale) as u32);
        let small = Case { size, ..case.clone() };
        let (mean, _) = difference(SHOWN.folder(), name, &stretched(&small, case.size), |_| true);
        assert!(mean < most, "{name}: differs by {mean} of 255");
    }
}

#[test]
fn temporal_antialiasing_neither_blurs_nor_shifts() {
    for (name, most) in [("taa", 0.6), ("taa_msaa", 0.6), ("fsr2", 2.8)] {
        let (mean, _) = difference(SHOWN.folder(), name, &expected::picture(&SHOWN.case(name)), |_| true);
        assert!(mean < most, "{name}: differs by {mean} of 255");
    }
    let case = SHOWN.case("taa_meshes");
    let inside = away_from_edges(&case, &expected::seen(&case, &case.meshes));
    let wanted = expected::picture(&case);
    let (mean, _) = difference(SHOWN.folder(), "taa_meshes", &wanted, |i| inside[i]);
    assert!(mean < 0.6, "taa_meshes: differs by {mean} of 255");
    // It is at work: where meshes end, they are smooth.
    let (_, smooth) = difference(SHOWN.folder(), "taa_meshes", &wanted, |i| !inside[i]);
    assert!(smooth > 0.3, "taa_meshes: {smooth} of the edges are smooth");
}

/// The picture with panes over it, where `over` says so of the pixel.
fn glazed(case: &Case, over: impl Fn(usize) -> bool) -> SrgbImage {
    let mut linear = expected::linear(case);
    let panes = expected::seen(case, &case.glass);
    for (pixel, color) in linear.iter_mut().enumerate() {
        if panes[pixel].is_some() && over(pixel) {
            // Front and back of a box are both culled to what faces the camera.
            *color = std::array::from_fn(|i| 0.5 * color[i] + 0.5 * case.glass[0].color[i]);
        }
    }
    SrgbImage::from_linear(case.size[0] as usize, case.size[1] as usize, &linear)
}

#[test]
fn glass_before_a_volume_tints_it() {
    let case = SHOWN.case("glass_before");
    assert!(matches!(case.light, Light::Color(_)));
    let inside = away_from_edges(&case, &expected::seen(&case, &case.glass));
    assert_same(SHOWN.folder(), "glass_before", &glazed(&case, |_| true), |i| inside[i]);
}

#[test]
fn glass_behind_a_volume_is_hidden() {
    for name in ["glass_behind", "glass_behind_msaa"] {
        let case = SHOWN.case(name);
        let film = expected::film(&case);
        let inside = away_from_edges(&case, &expected::seen(&case, &case.glass));
        let clear_cut = |i: usize| !(0.02..=0.98).contains(&film.alpha(i));
        let panes = expected::seen(&case, &case.glass);
        let hidden = (0..panes.len()).filter(|&i| panes[i].is_some() && film.alpha(i) > 0.98).count();
        let seen = (0..panes.len()).filter(|&i| panes[i].is_some() && film.alpha(i) < 0.02).count();
        println!("{name}: the pane is hidden in {hidden} pixels, seen in {seen}");
        assert!(hidden > 200 && seen > 50, "{name}: {hidden} hidden, {seen} seen");
        let wanted = glazed(&case, |i| film.alpha(i) < 0.5);
        assert_same(SHOWN.folder(), name, &wanted, |i| inside[i] && clear_cut(i));
    }
}
