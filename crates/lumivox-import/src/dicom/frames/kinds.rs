//! What images of one series show: magnitude and phase, real and imaginary parts, maps, water and fat. Images of different
//! kinds are volumes of their own, never phases of one.
//!
//! Words of ImageType and FrameType beyond the first two are the manufacturers' own. What they spell in many ways is told by
//! the parts of a word: `P`, `PHASE MAP`, `SW_P_FFE` and `P_FFE` are all phases.

use lumivox_core::Modality;

use crate::dicom::{
    elements::{
        attributes::{self as attr, Attribute},
        data_set::DataSet,
    },
    frames::scope::FrameScope,
};

/// GE's numbers of what an image is a part of (GEMS_PARM_01, RawDataType_ImageType).
const GE_PARTS: [&str; 4] = ["", "phase", "real", "imaginary"];

/// Kinds whose values lie around 0, and whose picture is no picture of the body.
const SIGNED: [&str; 4] = ["phase", "real", "imaginary", "field map"];

/// What keeps frames of one series apart: derived images, the parts of complex ones, maps.
pub(crate) fn frame_kind(scope: &FrameScope<'_>) -> String {
    for sequence in [
        attr::MR_IMAGE_FRAME_TYPE_SEQUENCE,
        attr::CT_IMAGE_FRAME_TYPE_SEQUENCE,
        attr::PET_FRAME_TYPE_SEQUENCE,
    ] {
        let item = scope.find(sequence, attr::FRAME_TYPE);
        if item.bytes(attr::FRAME_TYPE).is_some() {
            return kind_of_frame_type(scope, sequence, item);
        }
    }
    let data = scope.data;
    let values = data.texts(attr::IMAGE_TYPE);
    let has = |names: &[&str]| values.iter().skip(2).any(|value| names.contains(&value.as_str()));
    let component = data.text(attr::COMPLEX_IMAGE_COMPONENT);
    let words = || values.iter().skip(2).chain(&component).map(String::as_str);
    let part = if modality(data) == Modality::Mr {
        let told = words().find_map(part_of_word);
        told.or_else(|| words().find_map(kind_of_word)).or_else(|| ge_part(data)).unwrap_or_default()
    } else {
        words().find_map(whole_word).unwrap_or_default().to_owned()
    };
    let origin = if values[0] == "DERIVED" { "derived " } else { "" };
    let localizer = if has(&["LOCALIZER"]) { "localizer " } else { "" };
    format!("{origin}{localizer}{part}").trim_end().to_owned()
}

fn kind_of_frame_type(scope: &FrameScope<'_>, sequence: Attribute, item: &DataSet) -> String {
    let part = scope.find(sequence, attr::COMPLEX_IMAGE_COMPONENT).text(attr::COMPLEX_IMAGE_COMPONENT);
    let mut words: Vec<String> = item.texts(attr::FRAME_TYPE).into_iter().chain(part).collect();
    words.retain(|word| !["ORIGINAL", "PRIMARY", "NONE", ""].contains(&word.as_str()));
    words.retain(|word| is_coded(word));
    // One part of a complex image is said twice, by a letter too; the magnitude is what an image is anyway.
    let mut told: Vec<String> = Vec::new();
    for word in words {
        let word = match (word.as_str(), whole_word(&word)) {
            ("M" | "MAGNITUDE", _) => continue,
            (_, Some(part)) => part.to_owned(),
            (_, None) => word.to_lowercase(),
        };
        if !told.contains(&word) {
            told.push(word);
        }
    }
    told.join(" ")
}

/// Whether a word is what a coded one can be (PS3.5 6.2), and no longer: it is told, and may be a patient's name in a
/// damaged file.
fn is_coded(word: &str) -> bool {
    let is_coded = |byte: u8| byte.is_ascii_uppercase() || byte.is_ascii_digit() || b" _".contains(&byte);
    word.len() <= 16 && word.bytes().all(is_coded)
}

fn modality(data: &DataSet) -> Modality {
    match data.text(attr::MODALITY).as_deref() {
        Some("MR") => Modality::Mr,
        _ => Modality::Other,
    }
}

/// The part of complex images that a word is by itself.
fn whole_word(word: &str) -> Option<&'static str> {
    Some(match word {
        "P" | "PHASE" | "PHASE MAP" => "phase",
        "R" | "REAL" => "real",
        "I" | "IMAGINARY" => "imaginary",
        _ => return None,
    })
}

/// The pieces of a word of an MR: `SW_P_FFE` has three.
fn pieces(word: &str) -> Vec<&str> {
    word.split(|c: char| !c.is_ascii_alphanumeric()).filter(|piece| !piece.is_empty()).collect()
}

/// The part of complex images in a word of an MR.
fn part_of_word(word: &str) -> Option<String> {
    let pieces = pieces(word);
    let has = |names: &[&str]| pieces.iter().any(|piece| names.contains(piece));
    // `IN_PHASE` and `PHASE CONTRAST M` are no phases.
    let is_phase = has(&["P", "PHA", "PHASE"]) && !has(&["IN", "OUT", "OPP", "OPPOSED", "CONTRAST"]);
    let part = match () {
        () if is_phase => "phase",
        () if has(&["R", "RE", "REAL"]) => "real",
        () if has(&["I", "IM", "IMAG", "IMAGINARY"]) => "imaginary",
        () => return None,
    };
    Some(part.to_owned())
}

/// The map, or the kind of tissue, in a word of an MR.
fn kind_of_word(word: &str) -> Option<String> {
    let pieces = pieces(word);
    let has = |names: &[&str]| pieces.iter().any(|piece| names.contains(piece));
    let kind = match () {
        () if word == "B0" || has(&["FIELDMAP", "B0MAP"]) || has(&["FIELD", "B0"]) && has(&["MAP"]) => {
            "field map"
        }
        () if has(&["IN", "IP"]) && has(&["PHASE"]) => "in phase",
        () if has(&["OUT", "OPP", "OPPOSED", "OP"]) && has(&["PHASE"]) => "opposed phase",
        () if has(&["WATER"]) => "water",
        () if has(&["FAT"]) && !has(&["SAT", "SUPP"]) => "fat",
        () if has(&["VELOCITY"]) => "velocity",
        () if has(&["ADC"]) => "adc",
        () if has(&["MAP"]) && is_coded(word) => return Some(pieces.join(" ").to_lowercase()),
        () => return None,
    };
    Some(kind.to_owned())
}

/// The part that GE's own number tells, where ImageType says `OTHER`.
fn ge_part(data: &DataSet) -> Option<String> {
    let number = ge_number(data, attr::GE_IMAGE_PART)?;
    GE_PARTS.get(usize::try_from(number).ok()?).map(|part| (*part).to_owned())
}

/// What GE's number for maps and directions of flow says: images of one series and place that differ in it are of
/// different kinds, where they are not diffusion-weighted. 0 where there is none.
pub(crate) fn ge_collapse(data: &DataSet) -> i16 {
    ge_number(data, attr::GE_VAS_COLLAPSE).unwrap_or(0)
}

fn ge_number(data: &DataSet, private: attr::Private) -> Option<i16> {
    let words = data.words(data.find_private(private)?)?;
    words.first().map(|word| *word as i16)
}

/// Whether an image of an MR is a map of numbers around 0, and not a picture: by its kind, or by values that it says it
/// has. `rescale` is slope and intercept.
pub(crate) fn is_signed_map(data: &DataSet, kind: &str, rescale: [f64; 2], stored_signed: bool) -> bool {
    if modality(data) != Modality::Mr {
        return false;
    }
    let [slope, intercept] = rescale;
    let smallest = data.words(attr::SMALLEST_IMAGE_PIXEL_VALUE).and_then(|words| words.first().copied());
    let lowest = match smallest {
        Some(word) if stored_signed => f64::from(word as i16),
        Some(word) => f64::from(word),
        None => 0.0,
    };
    let is_of_kind = kind.split_whitespace().any(|word| SIGNED.contains(&word));
    // The middle of the window: a picture's grey lies above 0.
    let centre = data.decimal(attr::WINDOW_CENTER).ok().flatten();
    is_of_kind
        || kind.contains("field map")
        || lowest * slope + intercept < 0.0 && centre.is_none_or(|centre| centre <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_spelt_in_many_ways() {
        for (word, part) in [
            ("P", "phase"),
            ("PHASE", "phase"),
            ("PHASE MAP", "phase"),
            ("SW_P_FFE", "phase"),
            ("P_FFE", "phase"),
            ("R_IR", "real"),
            ("REAL", "real"),
            ("I_FFE", "imaginary"),
            ("IMAG", "imaginary"),
        ] {
            assert_eq!(part_of_word(word).as_deref(), Some(part), "{word}");
        }
        for word in
            ["M", "SW_M_FFE", "IN_PHASE", "OPP_PHASE", "PHASE CONTRAST M", "SWI", "MPR", "R2 MAP", "DIS2D"]
        {
            assert_eq!(part_of_word(word), None, "{word}");
        }
    }

    #[test]
    fn maps_and_tissues_are_kinds() {
        for (word, kind) in [
            ("B0", "field map"),
            ("DELTA_B0_MAP", "field map"),
            ("FIELD MAP", "field map"),
            ("T1 MAP", "t1 map"),
            ("T2_STAR_MAP", "t2 star map"),
            ("WATER", "water"),
            ("DIXON_FAT", "fat"),
            ("OPP_PHASE", "opposed phase"),
            ("VELOCITY MAP", "velocity"),
        ] {
            assert_eq!(kind_of_word(word).as_deref(), Some(kind), "{word}");
        }
        assert_eq!(kind_of_word("NORM"), None);
        assert_eq!(kind_of_word("MAP OF JANE DOE MILLER"), None, "it may be a name");
    }
}
