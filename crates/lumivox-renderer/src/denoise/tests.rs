//! The denoiser on synthetic films whose truth is known.

use super::*;

const SIZE: u32 = 64;

/// What is seen at a pixel when there is no noise.
#[derive(Clone, Copy)]
struct Truth {
    radiance: [f64; 3],
    alpha: f64,
    depth: f64,
    normal: [f64; 3],
    albedo: [f64; 3],
}

/// A disc before nothing: shaded from left to right, of two albedos, with a step in depth and normal at half
/// height that is as bright on both sides.
fn disc(x: u32, y: u32) -> Truth {
    let [u, v] = [x, y].map(|i| (f64::from(i) + 0.5) / f64::from(SIZE) * 2.0 - 1.0);
    let alpha = ((0.9 - u.hypot(v)) * 32.0).clamp(0.0, 1.0);
    let albedo = if (x / 8).is_multiple_of(2) { [0.8, 0.6, 0.5] } else { [0.5, 0.2, 0.1] };
    let (depth, normal) = if v < 0.0 { (1.0, [0.0, 0.0, 1.0]) } else { (1.3, [0.0, 0.6, 0.8]) };
    Truth { radiance: albedo.map(|a| a * alpha * (1.2 + u)), alpha, depth, normal, albedo }
}

struct Random(u64);

impl Random {
    /// In [0, 1).
    fn uniform(&mut self) -> f64 {
        // SplitMix64.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A film of samples with exponentially distributed brightness, about as bad as path tracing.
fn film(truth: impl Fn(u32, u32) -> Truth, samples: u32, guides: bool) -> Film {
    film_with_firefly(truth, samples, guides, None)
}

/// One of the samples of a pixel may be hundreds of times as bright.
fn film_with_firefly(
    truth: impl Fn(u32, u32) -> Truth,
    samples: u32,
    guides: bool,
    firefly: Option<usize>,
) -> Film {
    let mut random = Random(7);
    let pixels = (SIZE * SIZE) as usize;
    let mut planes = vec![[0.0f32; 4]; pixels * if guides { 4 } else { 2 }];
    for pixel in 0..pixels {
        let t = truth(pixel as u32 % SIZE, pixel as u32 / SIZE);
        let mut sums = [[0.0f64; 4]; 4];
        for sample in 0..samples {
            sums[1][2] += 1.0;
            if random.uniform() >= t.alpha {
                continue;
            }
            let mut brightness = -(1.0 - random.uniform()).ln() / t.alpha;
            if sample == 0 && firefly == Some(pixel) {
                brightness = 500.0;
            }
            let light = t.radiance.map(|c| c * brightness);
            let luminance = 0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2];
            let jitter = 1.0 + 0.02 * (random.uniform() - 0.5);
            (0..3).for_each(|c| sums[0][c] += light[c]);
            sums[0][3] += 1.0;
            sums[1][0] += t.depth * jitter;
            sums[1][1] += luminance * luminance;
            (0..3).for_each(|c| sums[2][c] += t.albedo[c] * jitter);
            (0..3).for_each(|c| sums[3][c] += t.normal[c]);
        }
        for plane in 0..planes.len() / pixels {
            planes[plane * pixels + pixel] = sums[plane].map(|sum| sum as f32);
        }
    }
    let mut film = Film::new(SIZE, SIZE, guides);
    film.insert([0, 0], [SIZE; 2], bytemuck::cast_slice(&planes));
    film
}

fn all() -> impl Iterator<Item = (usize, Truth)> {
    (0..SIZE * SIZE).map(|i| (i as usize, disc(i % SIZE, i / SIZE)))
}

/// Root mean square error as a fraction of the root mean square.
fn error(film: &Film) -> f64 {
    let (mut errors, mut squares) = (0.0, 0.0);
    for (pixel, truth) in all() {
        for (c, t) in film.radiance(pixel).into_iter().zip(truth.radiance) {
            errors += (c - t) * (c - t);
            squares += t * t;
        }
    }
    (errors / squares).sqrt()
}

fn mean(film: &Film) -> f64 {
    all().map(|(pixel, _)| film.luminance(pixel).0).sum::<f64>() / f64::from(SIZE * SIZE)
}

#[test]
fn noise_goes_and_brightness_stays() {
    for (guides, gain, bias) in [(true, 3.0, 0.01), (false, 1.5, 0.02)] {
        let noisy = film(disc, 16, guides);
        let clean = noisy.denoised();
        assert!(error(&clean) * gain < error(&noisy), "{guides}: {} -> {}", error(&noisy), error(&clean));
        let ratio = mean(&clean) / mean(&noisy);
        assert!((ratio - 1.0).abs() < bias, "{guides}: brightness times {ratio}");
    }
}

#[test]
fn a_converged_film_is_almost_unchanged() {
    let noisy = film(disc, 4096, true);
    let clean = noisy.denoised();
    assert!(error(&clean) <= error(&noisy), "{} -> {}", error(&noisy), error(&clean));
    let largest = all()
        .flat_map(|(pixel, _)| (0..3).map(move |c| (pixel, c)))
        .map(|(pixel, c)| (clean.radiance(pixel)[c] - noisy.radiance(pixel)[c]).abs())
        .fold(0.0, f64::max);
    assert!(largest < 0.1, "{largest}");
}

#[test]
fn edges_stay_where_they_are() {
    // Light that changes only where depth and normal do, by less than the noise.
    let step = |x, y| {
        let t = disc(x, y);
        Truth { radiance: [if y < SIZE / 2 { 0.5 } else { 0.6 } * t.alpha; 3], albedo: [0.8; 3], ..t }
    };
    let clean = film(step, 16, true).denoised();
    let row = |y: u32| {
        let pixels = (20..44).map(|x| clean.luminance((y * SIZE + x) as usize).0);
        pixels.sum::<f64>() / 24.0
    };
    let (above, below) = (row(SIZE / 2 - 1), row(SIZE / 2));
    assert!((above - 0.5).abs() < 0.03 && (below - 0.6).abs() < 0.03, "{above} {below}");
}

#[test]
fn what_is_transparent_stays_so_and_silhouettes_keep_their_coverage() {
    let noisy = film(disc, 16, true);
    let clean = noisy.denoised();
    for (pixel, _) in all() {
        assert_eq!(clean.samples(pixel), noisy.samples(pixel));
        let alpha = noisy.alpha(pixel);
        if alpha == 0.0 || alpha == 1.0 {
            assert!((clean.alpha(pixel) - alpha).abs() < 1e-6, "{alpha} became {}", clean.alpha(pixel));
        }
        if alpha == 0.0 {
            assert_eq!(clean.radiance(pixel), [0.0; 3]);
        } else {
            assert!((clean.depth(pixel) - noisy.depth(pixel)).abs() < 1e-5);
        }
    }
}

#[test]
fn haze_is_smoothed_and_as_dense_as_before() {
    let haze = |_, _| Truth { alpha: 0.3, radiance: [0.3; 3], ..disc(SIZE / 2, 0) };
    let (noisy, clean) = (film(haze, 16, true), film(haze, 16, true).denoised());
    let deviation =
        |film: &Film| all().map(|(p, _)| (film.alpha(p) - 0.3).powi(2)).sum::<f64>().sqrt() / f64::from(SIZE);
    let mean = |film: &Film| all().map(|(p, _)| film.alpha(p)).sum::<f64>() / f64::from(SIZE * SIZE);
    assert!(deviation(&clean) < 0.5 * deviation(&noisy), "{} {}", deviation(&clean), deviation(&noisy));
    assert!((mean(&clean) - mean(&noisy)).abs() < 0.003, "{} {}", mean(&clean), mean(&noisy));
}

/// Most samples pass through thin haze: what none of few met is as hazy as what is around it, and no dot.
#[test]
fn haze_of_few_samples_has_hardly_a_hole_and_is_as_dense_as_before() {
    let haze = |_, _| Truth { alpha: 0.3, radiance: [0.15; 3], ..disc(SIZE / 2, 0) };
    for (samples, guides, holes_left, bias) in
        [(1, true, 0.1, 0.15), (2, true, 0.05, 0.1), (4, true, 0.05, 0.1), (4, false, 0.05, 0.1)]
    {
        let noisy = film(haze, samples, guides);
        let clean = noisy.denoised();
        let missed = all().filter(|&(p, _)| noisy.alpha(p) == 0.0).count() as f64;
        let is_dark = |p: usize| clean.alpha(p) < 0.05 || clean.luminance(p).0 < 0.02;
        let dark = all().filter(|&(p, _)| is_dark(p)).count() as f64;
        assert!(missed > 100.0 && dark <= holes_left * missed, "{samples}: {dark} of {missed}");
        let mean = |value: &dyn Fn(usize) -> f64| all().map(|(p, _)| value(p)).sum::<f64>() / 4096.0;
        for (before, after) in [
            (mean(&|p| noisy.alpha(p)), mean(&|p| clean.alpha(p))),
            (mean(&|p| noisy.luminance(p).0), mean(&|p| clean.luminance(p).0)),
        ] {
            assert!((after / before - 1.0).abs() < bias, "{samples} samples: {before} became {after}");
        }
        for p in (0..(SIZE * SIZE) as usize).filter(|&p| clean.alpha(p) > 0.0) {
            assert!((clean.depth(p) - haze(0, 0).depth).abs() < 0.02, "{}", clean.depth(p));
        }
    }
}

/// Between solid bars there is nothing, and there remains nothing.
#[test]
fn gaps_between_solids_stay_empty() {
    let bars = |x: u32, _| {
        let alpha = if x % 8 < 4 { 1.0 } else { 0.0 };
        Truth { alpha, radiance: [0.5 * alpha; 3], ..disc(SIZE / 2, 0) }
    };
    for samples in [1, 4] {
        let noisy = film(bars, samples, true);
        let clean = noisy.denoised();
        for (p, _) in all() {
            assert!((clean.alpha(p) - noisy.alpha(p)).abs() < 1e-6, "{} at {p}", clean.alpha(p));
        }
    }
}

#[test]
fn fireflies_go_out() {
    let center = (SIZE / 2 * SIZE + SIZE / 2) as usize;
    let with = film_with_firefly(disc, 16, true, Some(center)).denoised();
    let without = film(disc, 16, true).denoised();
    for (pixel, truth) in all().filter(|(_, t)| t.alpha > 0.0) {
        let (a, b) = (with.luminance(pixel).0, without.luminance(pixel).0);
        assert!((a - b).abs() < 0.5 * truth.radiance[0], "{a} rather than {b} at {pixel}");
    }
}

#[test]
fn what_is_not_a_number_does_not_spread() {
    let mut broken = film(disc, 4, true);
    let center = (SIZE / 2 * SIZE + SIZE / 2) as usize;
    broken.set_light(center, [f64::NAN; 3], 1.0);
    let clean = broken.denoised();
    assert!(all().all(|(p, _)| p == center || clean.radiance(p)[0].is_finite()));
}

#[test]
fn one_thread_and_many_give_the_same() {
    let noisy = film(disc, 4, true);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| noisy.denoised())
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn films_of_no_or_one_sample_are_no_trouble() {
    for samples in [0, 1] {
        let clean = film(disc, samples, true).denoised();
        assert!(all().all(|(p, _)| clean.radiance(p).iter().all(|c| c.is_finite() && *c >= 0.0)));
    }
}

#[test]
fn who_has_no_time_gets_nothing() {
    assert!(film(disc, 4, true).denoised_while(&|| false).is_none());
}
