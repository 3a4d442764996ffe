//! Colours of labels: those that files give, as linear sRGB, and those of labels without one.

use lumivox_core::color::linear_from_srgb;

/// Linear from sRGB codes, 0 to 1 each; what lies outside is clipped.
pub(crate) fn from_srgb(codes: [f64; 3]) -> [f64; 3] {
    codes.map(|code| linear_from_srgb(code.clamp(0.0, 1.0)))
}

/// Linear from sRGB codes, 0 to 255 each.
pub(crate) fn from_bytes(codes: [f64; 3]) -> [f64; 3] {
    from_srgb(codes.map(|code| code / 255.0))
}

/// Linear from DICOM's 16-bit CIELab values (PS3.3 C.10.7.1.1): L* 0 to 100, a* and b* -128 to 127, of the light D50.
pub(crate) fn from_dicom_lab([l, a, b]: [u16; 3]) -> [f64; 3] {
    let part = |stored: u16| f64::from(stored) / 65535.0;
    let (l, a, b) = (part(l) * 100.0, part(a) * 255.0 - 128.0, part(b) * 255.0 - 128.0);
    // CIE 15: L*a*b* to XYZ.
    let fy = (l + 16.0) / 116.0;
    let inverse = |f: f64| {
        const LINEAR: f64 = 6.0 / 29.0;
        if f > LINEAR { f.powi(3) } else { 3.0 * LINEAR * LINEAR * (f - 4.0 / 29.0) }
    };
    const D50: [f64; 3] = [0.964_22, 1.0, 0.825_21];
    let [x, y, z] =
        [D50[0] * inverse(fy + a / 500.0), D50[1] * inverse(fy), D50[2] * inverse(fy - b / 200.0)];
    // sRGB from XYZ of D50, by Bradford's adaptation (Lindbloom).
    const RGB: [[f64; 3]; 3] = [
        [3.133_856_1, -1.616_866_7, -0.490_614_6],
        [-0.978_768_4, 1.916_141_5, 0.033_454_0],
        [0.071_945_3, -0.228_991_4, 1.405_242_7],
    ];
    RGB.map(|row| (row[0] * x + row[1] * y + row[2] * z).clamp(0.0, 1.0))
}

/// The colour of a label that has none: neighbours differ in hue, and far ones in lightness.
pub(crate) fn default_color(value: u8) -> [f64; 3] {
    /// The golden section of a circle: each hue lies in the largest gap of those before.
    const TURN: f64 = 0.618_033_988_749_895;
    let n = usize::from(value.wrapping_sub(1));
    let hue = (0.02 + n as f64 * TURN).fract() * 6.0;
    let (saturation, most) = [(0.62, 0.90), (0.45, 0.98), (0.72, 0.72)][n / 8 % 3];
    let code = |offset: f64| {
        let k = (offset + hue) % 6.0;
        most - most * saturation * k.min(4.0 - k).clamp(0.0, 1.0)
    };
    from_srgb([code(5.0), code(3.0), code(1.0)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// DICOM's numbers for L*, a*, b*.
    fn lab([l, a, b]: [f64; 3]) -> [u16; 3] {
        [l / 100.0, (a + 128.0) / 255.0, (b + 128.0) / 255.0].map(|part| (part * 65535.0).round() as u16)
    }

    #[test]
    fn cielab_becomes_srgb() {
        // White, black, and the primaries and a skin tone by Lindbloom's calculator (D50).
        for (from, to) in [
            ([100.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
            ([0.0, 0.0, 0.0], [0.0; 3]),
            ([54.29, 80.81, 69.89], [1.0, 0.0, 0.0]),
            ([87.82, -79.27, 80.99], [0.0, 1.0, 0.0]),
            ([29.57, 68.30, -112.03], [0.0, 0.0, 1.0]),
            ([50.0, 0.0, 0.0], [0.184_2; 3]),
        ] {
            let color = from_dicom_lab(lab(from));
            assert!(color.iter().zip(to).all(|(a, b)| (a - b).abs() < 4e-3), "{from:?}: {color:?}");
        }
    }

    #[test]
    fn default_colors_differ_and_are_colors() {
        let all: Vec<_> = (1..=255).map(default_color).collect();
        assert!(all.iter().flatten().all(|part| (0.0..=1.0).contains(part)));
        for (n, color) in all.iter().enumerate() {
            for other in &all[n + 1..(n + 13).min(all.len())] {
                let apart: f64 = color.iter().zip(other).map(|(a, b)| (a - b).abs()).sum();
                assert!(apart > 0.05, "{n}: {color:?} {other:?}");
            }
        }
    }
}
