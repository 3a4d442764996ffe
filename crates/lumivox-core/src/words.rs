//! Numbers as people want to read them, and names of files as programs do.

use std::path::{MAIN_SEPARATOR, Path};

/// Lengths in mm with so many digits behind the point, in the unit that fits the longest: `0.78 x 0.78 x 1.00 mm`.
pub fn lengths<const N: usize>(mm: [f64; N], digits: usize) -> String {
    /// Units, in mm, and from how many mm on they fit.
    const UNITS: [(&str, f64, f64); 5] =
        [("km", 1e6, 1e6), ("m", 1e3, 1e4), ("mm", 1.0, 0.1), ("\u{b5}m", 1e-3, 1e-4), ("nm", 1e-6, 0.0)];
    let longest = mm.iter().copied().fold(0.0, f64::max);
    let (unit, in_mm, _) = UNITS.into_iter().find(|(_, _, least)| longest >= *least).unwrap_or(UNITS[2]);
    let numbers = mm.map(|length| format!("{:.digits$}", length / in_mm));
    format!("{} {unit}", numbers.join(" x "))
}

/// A value with as many digits as people want to read.
pub fn number(value: f64) -> String {
    if value == 0.0 || (0.01..1e7).contains(&value.abs()) {
        let digits = if value.abs() >= 100.0 || value.fract() == 0.0 { 0 } else { 2 };
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}

/// A file's path for programs: the same on all systems, with `/` between names, which Windows reads, too.
pub fn path(path: &Path) -> String {
    with_slashes(&path.to_string_lossy(), MAIN_SEPARATOR)
}

/// `path` with `/` in place of what separates names.
fn with_slashes(path: &str, separator: char) -> String {
    path.replace(separator, "/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_the_unit_that_fits() {
        assert_eq!(lengths([0.78125, 0.78125, 1.0], 2), "0.78 x 0.78 x 1.00 mm");
        assert_eq!(lengths([0.005, 0.005, 0.03], 2), "5.00 x 5.00 x 30.00 \u{b5}m");
        assert_eq!(lengths([4e-6; 3], 1), "4.0 x 4.0 x 4.0 nm");
        assert_eq!(lengths([500.0], 1), "500.0 mm");
        assert_eq!(lengths([64_000.0], 1), "64.0 m");
        assert_eq!(lengths([3e6], 1), "3.0 km");
    }

    #[test]
    fn numbers_read_well() {
        assert_eq!(
            [-1000.0, 0.0, 12.5, 0.001, 3e9].map(number),
            ["-1000", "0", "12.50", "1.000e-3", "3.000e9"]
        );
    }

    #[test]
    fn paths_are_the_same_on_all_systems() {
        assert_eq!(
            path(&["series", "a b", "1.dcm"].iter().collect::<std::path::PathBuf>()),
            "series/a b/1.dcm"
        );
        assert_eq!(with_slashes(r"D:\scans\series/1.dcm", '\\'), "D:/scans/series/1.dcm");
        // Where it separates nothing, it is part of a name.
        assert_eq!(with_slashes(r"scans/a\b.dcm", '/'), r"scans/a\b.dcm");
    }
}
