//! Units of length, by the names that programs give them, and lengths that are believed.

use std::ops::RangeInclusive;

/// Distances between voxels that are believed, in mm: from atoms to a kilometre.
pub(crate) const SPACING_MM: RangeInclusive<f64> = 1e-6..=1e6;

/// Millimetres in a unit; `None` for what is none, such as pixels.
pub(crate) fn mm_per_unit(name: &str) -> Option<f64> {
    let name = name.trim().trim_matches('"').to_lowercase().replace("metre", "meter");
    Some(match name.strip_suffix('s').unwrap_or(&name) {
        "km" | "kilometer" => 1e6,
        "m" | "meter" => 1e3,
        "dm" | "decimeter" => 100.0,
        "cm" | "centimeter" => 10.0,
        "mm" | "millimeter" => 1.0,
        // The micro sign, the Greek letter, and an escape of ImageJ's.
        "um" | "\u{b5}m" | "\u{3bc}m" | "\\u00b5m" | "micron" | "micrometer" => 1e-3,
        "nm" | "nanometer" => 1e-6,
        "a" | "\u{e5}" | "angstrom" | "\u{e5}ngstr\u{f6}m" => 1e-7,
        "pm" | "picometer" => 1e-9,
        "in" | "inch" | "inche" => 25.4,
        "ft" | "foot" | "feet" => 304.8,
        "mi" | "mile" => 1_609_344.0,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn units_go_by_many_names() {
        for (name, mm) in [
            ("µm", 1e-3),
            ("μm", 1e-3),
            ("Micron", 1e-3),
            ("millimeter", 1.0),
            ("inches", 25.4),
            ("Millimetres", 1.0),
            ("\u{c5}ngstr\u{f6}m", 1e-7),
            (" nm ", 1e-6),
        ] {
            assert_eq!(super::mm_per_unit(name), Some(mm), "{name}");
        }
        for none in ["pixel", "s", "", "mmm"] {
            assert_eq!(super::mm_per_unit(none), None, "{none}");
        }
    }
}
