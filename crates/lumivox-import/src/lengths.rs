//! Units of length, by the names that programs give them.

/// Millimetres in a unit; `None` for what is none, such as pixels.
pub(crate) fn mm_per_unit(name: &str) -> Option<f64> {
    let name = name.trim().trim_matches('"').to_lowercase();
    Some(match name.as_str() {
        "km" | "kilometer" | "kilometre" => 1e6,
        "m" | "meter" | "metre" | "meters" | "metres" => 1e3,
        "cm" | "centimeter" | "centimetre" => 10.0,
        "mm" | "millimeter" | "millimetre" | "millimeters" | "millimetres" => 1.0,
        // The micro sign and the Greek letter.
        "um" | "\u{b5}m" | "\u{3bc}m" | "\\u00b5m" | "micron" | "microns" | "micrometer" | "micrometre" => {
            1e-3
        }
        "nm" | "nanometer" | "nanometre" => 1e-6,
        "\u{e5}" | "angstrom" => 1e-7,
        "pm" | "picometer" | "picometre" => 1e-9,
        "in" | "inch" | "inches" => 25.4,
        "ft" | "foot" | "feet" => 304.8,
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
            ("inch", 25.4),
            (" nm ", 1e-6),
        ] {
            assert_eq!(super::mm_per_unit(name), Some(mm), "{name}");
        }
        assert_eq!(super::mm_per_unit("pixel"), None);
    }
}
