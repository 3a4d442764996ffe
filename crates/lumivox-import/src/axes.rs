//! Where a grid's axes point in the patient, for files that do not say: three letters such as `LPS`.

use std::{fmt, str::FromStr};

use lumivox_core::glam::{DAffine3, DMat3, DVec3};

/// The directions in the patient in which x, y and z of a grid grow, as letters: Left or Right, Posterior or Anterior,
/// Superior or Inferior; `LPS`, `RAS`, `ASL`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PatientAxes([Letter; 3]);

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Letter {
    L,
    R,
    P,
    A,
    S,
    I,
}

impl Letter {
    fn parse(letter: char) -> Option<Self> {
        Some(match letter.to_ascii_uppercase() {
            'L' => Self::L,
            'R' => Self::R,
            'P' => Self::P,
            'A' => Self::A,
            // Head and foot.
            'S' | 'H' => Self::S,
            'I' | 'F' => Self::I,
            _ => return None,
        })
    }

    /// Its direction in LPS.
    fn direction(self) -> DVec3 {
        match self {
            Self::L => DVec3::X,
            Self::R => DVec3::NEG_X,
            Self::P => DVec3::Y,
            Self::A => DVec3::NEG_Y,
            Self::S => DVec3::Z,
            Self::I => DVec3::NEG_Z,
        }
    }
}

/// A text is no [`PatientAxes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "three letters are expected: one of L and R, one of P and A, one of S and I, in the order of x, y and z"
)]
pub struct UnknownAxes;

impl PatientAxes {
    /// x to the left, y to the back, z to the head: DICOM's own axes.
    pub const LPS: Self = Self([Letter::L, Letter::P, Letter::S]);

    /// A placement without rotation other than by right angles.
    pub(crate) fn placement(self, spacing_mm: [f64; 3]) -> DAffine3 {
        let [x, y, z] = std::array::from_fn(|i| self.0[i].direction() * spacing_mm[i]);
        DAffine3::from_mat3(DMat3::from_cols(x, y, z))
    }
}

impl FromStr for PatientAxes {
    type Err = UnknownAxes;

    fn from_str(text: &str) -> Result<Self, UnknownAxes> {
        let letters: Option<Vec<Letter>> = text.trim().chars().map(Letter::parse).collect();
        let letters = <[Letter; 3]>::try_from(letters.ok_or(UnknownAxes)?).map_err(|_| UnknownAxes)?;
        let covered: DVec3 = letters.iter().map(|letter| letter.direction().abs()).sum();
        if covered == DVec3::ONE { Ok(Self(letters)) } else { Err(UnknownAxes) }
    }
}

impl fmt::Display for PatientAxes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|letter| write!(f, "{letter:?}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_directions() {
        let axes = |text: &str| text.parse::<PatientAxes>();
        assert_eq!(axes("LPS"), Ok(PatientAxes::LPS));
        assert_eq!(axes("lph"), Ok(PatientAxes::LPS));
        let matrix = axes("FRA").unwrap().placement([1.0, 2.0, 3.0]).matrix3;
        assert_eq!(matrix.x_axis, DVec3::new(0.0, 0.0, -1.0));
        assert_eq!(matrix.y_axis, DVec3::new(-2.0, 0.0, 0.0));
        assert_eq!(matrix.z_axis, DVec3::new(0.0, -3.0, 0.0));
        assert_eq!(axes("FRA").unwrap().to_string(), "IRA");
        for wrong in ["", "LP", "LPSS", "LRS", "SIP", "LPX", "LAP", "LPŚ"] {
            assert_eq!(axes(wrong), Err(UnknownAxes), "{wrong}");
        }
    }
}
