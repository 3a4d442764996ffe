//! Linear sRGB: its codes, and how bright it is.

/// The code of a linear intensity, both 0 to 1 (IEC 61966-2-1).
pub fn srgb_from_linear(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The linear intensity of a code, both 0 to 1 (IEC 61966-2-1).
pub fn linear_from_srgb(code: f64) -> f64 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB codes of `#rrggbb`.
pub fn srgb_from_hex(text: &str) -> Option<[u8; 3]> {
    text.strip_prefix('#')
        .filter(|hex| hex.len() == 6 && hex.bytes().all(|b| b.is_ascii_hexdigit()))
        .and_then(|hex| u32::from_str_radix(hex, 16).ok())
        .map(|rgb| [(rgb >> 16) as u8, (rgb >> 8) as u8, rgb as u8])
}

/// Relative luminance (ITU-R BT.709).
pub fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_and_intensities_are_inverse() {
        assert!((linear_from_srgb(0.5) - 0.214_041_14).abs() < 1e-8);
        for i in 0..=100 {
            let code = f64::from(i) / 100.0;
            assert!((srgb_from_linear(linear_from_srgb(code)) - code).abs() < 1e-6, "{code}");
        }
    }

    #[test]
    fn white_has_a_luminance_of_one() {
        assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-12);
    }
}
