//! What a place of the torso phantom is: the truth that a segmentation is compared with.

/// What lies at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
#[non_exhaustive]
pub enum TorsoPart {
    /// Outside of the scanner's field of view.
    Padding,
    /// Air around patient and table.
    OutsideAir,
    /// The table: carbon shell and foam core.
    Table,
    /// The mattress on the table.
    Mattress,
    /// The blanket over the patient.
    Blanket,
    /// Skin.
    Skin,
    /// Fat, under the skin and between organs.
    Fat,
    /// Muscles, the diaphragm among them.
    Muscle,
    /// Glands of the breast.
    Gland,
    /// Aerated tissue of the lungs, with what is too fine to be modelled by itself.
    Lung,
    /// Air in windpipe and bronchi.
    AirwayAir,
    /// Walls of windpipe and bronchi.
    AirwayWall,
    /// Blood of pulmonary arteries and of the right heart.
    PulmonaryArtery,
    /// Blood of pulmonary veins.
    PulmonaryVein,
    /// Blood of the left heart, the aorta and its branches.
    Artery,
    /// Blood of the veins of the body, the portal vein among them.
    Vein,
    /// The wall of the heart.
    Myocardium,
    /// Bone, cortical and spongy.
    Bone,
    /// Cartilage of ribs, and discs of the spine.
    Cartilage,
    /// The spinal canal: fluid and cord.
    SpinalCanal,
    /// Liver.
    Liver,
    /// Gallbladder.
    Gallbladder,
    /// Spleen.
    Spleen,
    /// Kidneys.
    Kidney,
    /// Pancreas.
    Pancreas,
    /// Gullet, stomach and bowel: their walls and what they hold, but gas.
    Gut,
    /// Gas in the stomach and the bowel.
    GutGas,
    /// Anything of metal in the patient.
    Metal,
    /// What else there is: thyroid gland, adrenal glands.
    SoftTissue,
}

impl TorsoPart {
    /// Every part, in the order of their numbers.
    pub const ALL: [TorsoPart; 29] = [
        Self::Padding,
        Self::OutsideAir,
        Self::Table,
        Self::Mattress,
        Self::Blanket,
        Self::Skin,
        Self::Fat,
        Self::Muscle,
        Self::Gland,
        Self::Lung,
        Self::AirwayAir,
        Self::AirwayWall,
        Self::PulmonaryArtery,
        Self::PulmonaryVein,
        Self::Artery,
        Self::Vein,
        Self::Myocardium,
        Self::Bone,
        Self::Cartilage,
        Self::SpinalCanal,
        Self::Liver,
        Self::Gallbladder,
        Self::Spleen,
        Self::Kidney,
        Self::Pancreas,
        Self::Gut,
        Self::GutGas,
        Self::Metal,
        Self::SoftTissue,
    ];

    /// The part of a number, as [`torso_parts`](crate::torso_parts) gives it.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// Whether it is part of the patient, gas inside included.
    pub fn is_body(self) -> bool {
        !self.is_outside() && !self.is_equipment()
    }

    /// Whether it is air around the patient, or not measured at all.
    pub fn is_outside(self) -> bool {
        matches!(self, Self::Padding | Self::OutsideAir)
    }

    /// Whether it is what the patient lies on or under.
    pub fn is_equipment(self) -> bool {
        matches!(self, Self::Table | Self::Mattress | Self::Blanket)
    }

    /// Whether blood flows in it.
    pub fn is_blood(self) -> bool {
        matches!(self, Self::PulmonaryArtery | Self::PulmonaryVein | Self::Artery | Self::Vein)
    }

    /// Whether it is air or another gas.
    pub fn is_gas(self) -> bool {
        matches!(self, Self::OutsideAir | Self::AirwayAir | Self::GutGas)
    }
}
