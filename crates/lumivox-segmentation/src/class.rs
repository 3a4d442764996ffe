//! What a voxel can belong to.

use lumivox_core::Label;

/// What a voxel belongs to; the number is that of its label. Voxels outside a round field of view, where nothing was
/// measured, have no label.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
#[non_exhaustive]
pub enum Class {
    /// The patient's soft tissue and bone, and what is in them; in a scan that is not understood, everything.
    Body = 1,
    /// Lungs, with their vessels and small airways.
    Lungs = 2,
    /// Trachea and bronchi.
    Airways = 3,
    /// Gas in the body that is in neither: in bowel, sinuses, mastoid, pharynx.
    Gas = 4,
    /// What carries the patient: table, head-rest.
    Table = 5,
    /// Other things that lie around: blankets, clothes, pads, cables.
    Objects = 6,
    /// Air around the patient.
    Air = 7,
    /// Specks in the air.
    Noise = 8,
}

impl Class {
    /// All, by rising label.
    pub const ALL: [Self; 8] = [
        Self::Body,
        Self::Lungs,
        Self::Airways,
        Self::Gas,
        Self::Table,
        Self::Objects,
        Self::Air,
        Self::Noise,
    ];

    /// The value of its voxels.
    pub fn value(self) -> u8 {
        self as u8
    }

    /// The class of a value; `None` for voxels without a label.
    pub fn of(value: u8) -> Option<Self> {
        Self::ALL.get(usize::from(value).wrapping_sub(1)).copied()
    }

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Body => "body",
            Self::Lungs => "lungs",
            Self::Airways => "airways",
            Self::Gas => "gas in the body",
            Self::Table => "table and supports",
            Self::Objects => "other objects",
            Self::Air => "air outside",
            Self::Noise => "noise",
        }
    }

    /// Whether it belongs to the patient: lies within the skin.
    pub fn is_patient(self) -> bool {
        matches!(self, Self::Body | Self::Lungs | Self::Airways | Self::Gas)
    }

    /// Whether it is a thing that is no part of the patient, and hidden by who wants to see only that.
    pub fn is_thing(self) -> bool {
        matches!(self, Self::Table | Self::Objects | Self::Noise)
    }

    /// Its label.
    pub fn label(self) -> Label {
        let color = match self {
            Self::Body => [0.80, 0.55, 0.42],
            Self::Lungs => [0.90, 0.38, 0.40],
            Self::Airways => [0.20, 0.65, 0.85],
            Self::Gas => [0.85, 0.80, 0.25],
            Self::Table => [0.35, 0.35, 0.40],
            Self::Objects => [0.25, 0.45, 0.30],
            Self::Air => [0.02, 0.03, 0.06],
            Self::Noise => [0.50, 0.10, 0.50],
        };
        Label { value: self.value(), name: self.name().to_owned(), color }
    }
}
