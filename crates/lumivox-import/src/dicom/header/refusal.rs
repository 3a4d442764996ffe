//! Why an image is refused whose header can be read.

use lumivox_core::Cancelled;

use crate::dicom::elements::values::FieldFault;

/// Why a header is not that of a usable image.
pub(crate) enum Refusal {
    Field(FieldFault),
    Unsupported(String, &'static str),
    Cancelled(Cancelled),
}

impl From<Cancelled> for Refusal {
    fn from(cancelled: Cancelled) -> Self {
        Refusal::Cancelled(cancelled)
    }
}

impl From<FieldFault> for Refusal {
    fn from(fault: FieldFault) -> Self {
        Refusal::Field(fault)
    }
}
