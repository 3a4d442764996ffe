//! Optional arguments of types that gdext gives no defaults.

use godot::meta::GodotImmutable;
use godot::meta::conv::ByValue;
use godot::meta::error::ConvertError;
use godot::meta::shape::GodotShape;
use godot::prelude::*;

use super::LumivoxVolume;

/// A volume, or none.
#[derive(Clone, Debug)]
pub struct OptionalVolume(pub Option<Gd<LumivoxVolume>>);

impl GodotConvert for OptionalVolume {
    type Via = Option<Gd<LumivoxVolume>>;

    fn godot_shape() -> GodotShape {
        Self::Via::godot_shape()
    }
}

impl ToGodot for OptionalVolume {
    type Pass = ByValue;

    fn to_godot(&self) -> Self::Via {
        self.0.clone()
    }
}

impl FromGodot for OptionalVolume {
    fn try_from_godot(via: Self::Via) -> Result<Self, ConvertError> {
        Ok(Self(via))
    }
}

impl OptionalVolume {
    /// The default.
    pub fn none() -> Self {
        Self(None)
    }
}

// SAFETY: the only default is null, which nobody can change.
unsafe impl GodotImmutable for OptionalVolume {}

/// A dictionary of options.
#[derive(Clone, Debug, GodotConvert)]
#[godot(transparent)]
pub struct Options(pub VarDictionary);

impl Options {
    /// The default.
    pub fn none() -> Self {
        Self(VarDictionary::new().into_read_only())
    }
}

// SAFETY: the only default is a read-only dictionary.
unsafe impl GodotImmutable for Options {}
