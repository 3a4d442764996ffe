//! Words for what makes scans.

use lumivox_core::Modality;

/// The modality that a word means, in any case: `CT`, `MR` (`MRI`), `PET` (`PT`), `other`.
pub fn modality_of_word(word: &str) -> Option<Modality> {
    Some(match word.trim().to_ascii_uppercase().as_str() {
        "CT" => Modality::Ct,
        "MR" | "MRI" => Modality::Mr,
        "PET" | "PT" => Modality::Pet,
        "OTHER" => Modality::Other,
        _ => return None,
    })
}
