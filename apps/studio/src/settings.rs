//! What the Studio remembers between sessions. Nothing of any scan.

use std::path::PathBuf;

use lumivox_viewport::Profile;
use serde::{Deserialize, Serialize};

use crate::words::Language;

/// What a person chose.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Of the interface.
    pub language: Language,
    /// Bright letters on dark, as reading rooms have it, or the other way round.
    pub is_dark: bool,
    /// Whether it was read that this is no medical device.
    pub has_agreed: bool,
    /// Which button does what.
    pub mouse: Mouse,
    /// Whether structures have their names beside the 3D picture.
    pub shows_names: bool,
    /// The address of the archive that was asked last; empty before that.
    pub archive: String,
    /// Who asked it: a name without its password.
    pub archive_name: String,
}

/// Whose mouse a person is used to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mouse {
    /// That of OHIF's viewers.
    #[default]
    Ohif,
    /// That of 3D Slicer.
    Slicer,
}

impl Mouse {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Ohif, Self::Slicer];

    /// Which button does what.
    pub fn profile(self) -> Profile {
        match self {
            Self::Ohif => Profile::OHIF,
            Self::Slicer => Profile::SLICER,
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            language: Language::English,
            is_dark: true,
            has_agreed: false,
            mouse: Mouse::Ohif,
            shows_names: true,
            archive: String::new(),
            archive_name: String::new(),
        }
    }
}

/// Where settings are kept: a file natively, the browser's storage in a page, nowhere in tests.
pub trait Drawer {
    /// What was kept, if anything was.
    fn read(&self) -> Option<Settings>;

    /// Keeps it. What cannot be kept is chosen again next time.
    fn write(&self, settings: &Settings);

    /// The folder where unsaved work is kept, if it is.
    fn rescue_folder(&self) -> Option<PathBuf> {
        None
    }

    /// The folder where images of archives are kept, if there is one.
    fn archive_folder(&self) -> Option<PathBuf> {
        None
    }
}

/// Nothing is kept.
pub struct Forgetful(pub Settings);

impl Drawer for Forgetful {
    fn read(&self) -> Option<Settings> {
        Some(self.0.clone())
    }

    fn write(&self, _: &Settings) {}
}
