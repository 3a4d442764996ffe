//! How good a picture is while things move: what is measured of a frame against the converged picture of the same frame.
//!
//! Everything counts only within a mask, which is usually the subject: an empty background is right in any picture, and would
//! make all of them look better the more there is of it. Where the mask is empty there is nothing to measure: `None`.

use crate::png_io::SrgbImage;

/// A frame's error counts as that of steady motion from here on, as a multiple of that error.
pub const STEADY: f64 = 1.2;

/// Mean of the values within the mask.
///
/// # Panics
/// When there are not as many of both.
pub fn mean_within(values: &[f64], mask: &[bool]) -> Option<f64> {
    assert_eq!(values.len(), mask.len(), "a mask of the picture's size");
    let (sum, count) = within(values, mask).fold((0.0, 0usize), |(sum, n), v| (sum + v, n + 1));
    (count > 0).then(|| sum / count as f64)
}

/// Peak signal-to-noise ratio in dB of the sRGB codes within the mask, all channels alike; infinite where they are equal.
///
/// # Panics
/// When pictures or mask differ in size.
pub fn psnr_within(reference: &SrgbImage, test: &SrgbImage, mask: &[bool]) -> Option<f64> {
    assert_eq!((reference.width, reference.height), (test.width, test.height), "pictures of one size");
    let square = |(a, b): (&[u8; 3], &[u8; 3])| {
        (0..3).map(|i| (f64::from(a[i]) - f64::from(b[i])).powi(2)).sum::<f64>() / 3.0
    };
    let squares: Vec<f64> = reference.pixels.iter().zip(&test.pixels).map(square).collect();
    Some(-10.0 * (mean_within(&squares, mask)? / (255.0 * 255.0)).log10())
}

/// How bright a picture is within the mask, by all its linear light, as a multiple of the reference.
///
/// # Panics
/// When pictures or mask differ in size.
pub fn brightness_within(reference: &[[f32; 4]], test: &[[f32; 4]], mask: &[bool]) -> Option<f64> {
    let light = |pixels: &[[f32; 4]]| {
        let sums: Vec<f64> = pixels.iter().map(|p| p[..3].iter().map(|c| f64::from(*c)).sum()).collect();
        mean_within(&sums, mask)
    };
    let (reference, test) = (light(reference)?, light(test)?);
    (reference > 0.0).then(|| test / reference)
}

/// How much a picture flickers: how its difference from the frame before differs from what it should be, in levels of 255, root
/// mean square over the mask. `before` and `now` are each the reference, then the test. With a blur that is a mean over
/// squares of so many pixels of the mask along a side: what is seen of flicker from afar.
///
/// # Panics
/// When pictures or mask differ in size.
pub fn flicker_within(
    before: [&SrgbImage; 2],
    now: [&SrgbImage; 2],
    mask: &[bool],
    blur: usize,
) -> Option<f64> {
    let size = |image: &SrgbImage| [image.width, image.height];
    let [width, height] = size(now[0]);
    assert!(before.iter().chain(&now).all(|image| size(image) == [width, height]), "pictures of one size");
    assert_eq!(mask.len(), width * height, "a mask of the picture's size");
    // Of the codes, with Rec. 709's weights: near enough to what an eye takes for bright.
    let luma = |image: &SrgbImage, i: usize| {
        let [r, g, b] = image.pixels[i].map(f64::from);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let change = |which: usize, i: usize| luma(now[which], i) - luma(before[which], i);
    let error = |i: usize| if mask[i] { change(1, i) - change(0, i) } else { 0.0 };
    let errors: Vec<f64> = (0..mask.len()).map(error).collect();
    let squares: Vec<f64> = if blur <= 1 {
        errors.iter().map(|e| e * e).collect()
    } else {
        let ones: Vec<f64> = mask.iter().map(|&m| f64::from(u8::from(m))).collect();
        let [sums, counts] = [&errors, &ones].map(|plane| box_sums(plane, [width, height], blur));
        sums.iter().zip(counts).map(|(sum, n)| (sum / n.max(1.0)).powi(2)).collect()
    };
    Some(mean_within(&squares, mask)?.sqrt())
}

/// Sums over squares of `side` pixels around every pixel, of what of them lies in the picture.
fn box_sums(plane: &[f64], [width, height]: [usize; 2], side: usize) -> Vec<f64> {
    // An even square reaches one pixel farther to the left and up.
    let range = |at: usize, n: usize| [at.saturating_sub(side / 2), (at + side.div_ceil(2)).min(n)];
    // Sums over all pixels to the left and above.
    let stride = width + 1;
    let mut sums = vec![0.0; stride * (height + 1)];
    for y in 0..height {
        let mut row = 0.0;
        for x in 0..width {
            row += plane[y * width + x];
            sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + row;
        }
    }
    (0..width * height)
        .map(|i| {
            let ([left, right], [top, bottom]) = (range(i % width, width), range(i / width, height));
            let at = |x: usize, y: usize| sums[y * stride + x];
            at(right, bottom) - at(left, bottom) - at(right, top) + at(left, top)
        })
        .collect()
}

/// Frames after a change until the error is within [`STEADY`] times the `steady` one, of `(frames after the change, error)` in
/// their order; `None` where it never is.
pub fn lag(errors: &[(u32, f64)], steady: f64) -> Option<u32> {
    errors.iter().find(|(_, error)| *error <= STEADY * steady).map(|(frame, _)| *frame)
}

/// The value that a part of all values (0 to 1) does not exceed, by the nearest rank: never one that was not measured.
pub fn percentile(values: &[f64], part: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (part.clamp(0.0, 1.0) * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied()
}

fn within<'a>(values: &'a [f64], mask: &'a [bool]) -> impl Iterator<Item = f64> {
    values.iter().zip(mask).filter(|(_, inside)| **inside).map(|(value, _)| *value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(levels: &[u8]) -> SrgbImage {
        SrgbImage { width: 4, height: levels.len() / 4, pixels: levels.iter().map(|&g| [g; 3]).collect() }
    }

    const LEFT: [bool; 8] = [true, true, false, false, true, true, false, false];

    #[test]
    fn only_what_is_within_the_mask_counts() {
        let (reference, mut test) = (gray(&[100; 8]), gray(&[110; 8]));
        assert_eq!(mean_within(&[1.0, 2.0, 9.0, 9.0, 3.0, 4.0, 9.0, 9.0], &LEFT), Some(2.5));
        // 10 of 255 levels: 20 log10(25.5).
        let tenth = psnr_within(&reference, &test, &LEFT).unwrap();
        assert!((tenth - 28.130_803_608_679_1).abs() < 1e-9, "{tenth}");
        test.pixels[2] = [255; 3];
        assert_eq!(psnr_within(&reference, &test, &LEFT), Some(tenth));
        assert_eq!(psnr_within(&reference, &reference, &LEFT), Some(f64::INFINITY));
        assert_eq!(psnr_within(&reference, &test, &[false; 8]), None);
    }

    #[test]
    fn brightness_is_a_ratio_of_light() {
        let light = |c: f32, outside: f32| -> Vec<[f32; 4]> {
            LEFT.iter().map(|&m| if m { [c, 2.0 * c, 0.0, 1.0] } else { [outside; 4] }).collect()
        };
        let ratio = brightness_within(&light(0.5, 3.0), &light(0.45, 8.0), &LEFT).unwrap();
        assert!((ratio - 0.9).abs() < 1e-6, "{ratio}");
        assert_eq!(brightness_within(&light(0.0, 3.0), &light(0.5, 8.0), &LEFT), None);
    }

    #[test]
    fn a_change_that_should_be_is_no_flicker() {
        let all = [true; 8];
        let [before, now] = [gray(&[10; 8]), gray(&[30; 8])];
        assert_eq!(flicker_within([&before, &before], [&now, &now], &all, 0), Some(0.0));
        // Brighter than it should be in both frames: wrong, but it does not flicker.
        let [off, off_now] = [gray(&[15; 8]), gray(&[35; 8])];
        assert_eq!(flicker_within([&before, &off], [&now, &off_now], &all, 0), Some(0.0));
        // It stays where it should have changed.
        let flicker = flicker_within([&before, &before], [&now, &before], &all, 0).unwrap();
        assert!((flicker - 20.0).abs() < 1e-9, "{flicker}");
    }

    #[test]
    fn a_blur_hides_what_averages_out_and_nothing_else() {
        let still = gray(&[100; 16]);
        let checker: Vec<u8> = (0..16).map(|i| if (i % 4 + i / 4) % 2 == 0 { 112 } else { 88 }).collect();
        let checker = gray(&checker);
        let measure = |test: &SrgbImage, mask: &[bool], blur| {
            flicker_within([&still, &still], [&still, test], mask, blur).unwrap()
        };
        assert!((measure(&checker, &[true; 16], 0) - 12.0).abs() < 1e-9);
        assert!(measure(&checker, &[true; 16], 8) < 1e-9);
        // Every square of two pixels averages out, but for the one that a corner cuts down to one pixel.
        let half = measure(&checker, &[true; 16], 2);
        assert!((half - (144.0f64 / 16.0).sqrt()).abs() < 1e-9, "{half}");
        let flash = gray(&[112; 16]);
        let mask: Vec<bool> = (0..16).map(|i| i % 4 < 2).collect();
        for blur in [0, 2, 8, 32] {
            assert!((measure(&flash, &mask, blur) - 12.0).abs() < 1e-9, "what is outside dims nothing");
        }
    }

    #[test]
    fn lag_is_the_first_frame_that_is_as_good_as_steady_motion() {
        let errors = [(0, 0.3), (1, 0.2), (2, 0.119), (4, 0.13)];
        assert_eq!(lag(&errors, 0.1), Some(2));
        assert_eq!(lag(&errors, 0.3), Some(0));
        assert_eq!(lag(&errors, 0.05), None);
    }

    #[test]
    fn percentiles_are_values_that_were_measured() {
        let times: Vec<f64> = (1..=60).rev().map(f64::from).collect();
        assert_eq!(percentile(&times, 0.99), Some(60.0));
        assert_eq!(percentile(&times, 0.5), Some(30.0));
        assert_eq!(percentile(&times, 0.0), Some(1.0));
        assert_eq!(percentile(&[], 0.5), None);
    }
}
