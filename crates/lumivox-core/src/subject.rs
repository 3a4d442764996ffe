//! What a scan is of, as far as its file says: hints from which a look is suggested where nobody chose one.

use serde::{Deserialize, Serialize};

/// A part of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub enum BodyPart {
    /// Skull, brain, face, jaws.
    Head,
    /// Neck without its spine.
    Neck,
    /// Chest, with lungs.
    Chest,
    /// The heart alone.
    Heart,
    /// Abdomen, with or without pelvis.
    Abdomen,
    /// Any part of the spine.
    Spine,
    /// Arms, legs, and the joints that they hang on; hip and pelvis.
    Limb,
}

/// What a scan, or its reconstruction, is meant to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Focus {
    /// Vessels: an angiogram.
    Vessels,
    /// Bone, by a sharp filter.
    Bone,
    /// Lungs, by a sharp filter.
    Lungs,
    /// Teeth.
    Teeth,
    /// A brain without what lies around it.
    BrainAlone,
}

/// What a file says of a scan beyond its values. Nothing of it need be there, or true.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Subject {
    /// Which part of the body was scanned.
    pub part: Option<BodyPart>,
    /// What it is meant to show.
    pub focus: Option<Focus>,
    /// Whether contrast agent was given.
    pub contrast: Option<bool>,
    /// Whether its file says that it is something else than a CT, an MR or a PET: a dose, an ultrasound, counts of a SPECT.
    pub is_other: bool,
}

/// Words that mean a part, in lower case; those that say more come first.
const PARTS: [(BodyPart, &[&str]); 7] = [
    (
        BodyPart::Spine,
        &[
            "spine",
            "tlspine",
            "lsspine",
            "cspine",
            "tspine",
            "lspine",
            "lumbar",
            "wirbelsäule",
            "ws",
            "hws",
            "bws",
            "lws",
        ],
    ),
    (BodyPart::Heart, &["heart", "cardiac", "coronary", "coronaries", "herz", "koronar", "calcium", "tavi"]),
    (
        BodyPart::Limb,
        &[
            "knee",
            "ankle",
            "foot",
            "hand",
            "wrist",
            "elbow",
            "shoulder",
            "arm",
            "leg",
            "hip",
            "pelvis",
            "extremity",
            "femur",
            "tibia",
            "humerus",
            "forearm",
            "thigh",
            "calf",
            "finger",
            "toe",
            "knie",
            "fuss",
            "hüfte",
            "schulter",
            "becken",
        ],
    ),
    (
        BodyPart::Head,
        &[
            "headneck",
            "head",
            "brain",
            "skull",
            "cranium",
            "kopf",
            "schädel",
            "sinus",
            "sinuses",
            "orbit",
            "face",
            "facial",
            "cerebral",
            "mandible",
            "maxilla",
            "jaw",
            "temporal",
            "dental",
            "pituitary",
            "iac",
            "crane",
        ],
    ),
    (
        BodyPart::Chest,
        &[
            "chestabdomen",
            "chestabdpelvis",
            "neckchest",
            "chest",
            "thorax",
            "thx",
            "lung",
            "lungs",
            "lunge",
            "breast",
            "brust",
            "thoracic",
        ],
    ),
    (
        BodyPart::Abdomen,
        &[
            "abdomenpelvis",
            "abdpelvis",
            "abdomen",
            "abd",
            "abdominal",
            "liver",
            "leber",
            "kidney",
            "kidneys",
            "pancreas",
            "colon",
            "renal",
            "niere",
        ],
    ),
    (BodyPart::Neck, &["neck", "carotid", "carotids", "hals", "larynx", "thyroid"]),
];

/// Words that mean what is to be shown.
const FOCI: [(Focus, &[&str]); 5] = [
    (
        Focus::Vessels,
        &[
            "angio",
            "angiography",
            "angiogram",
            "cta",
            "mra",
            "tof",
            "aorta",
            "coronary",
            "coronaries",
            "venography",
        ],
    ),
    (Focus::Teeth, &["teeth", "tooth", "dental", "dentascan", "zähne"]),
    (Focus::Lungs, &["lung", "lungs", "lunge", "hrct"]),
    (Focus::Bone, &["bone", "boneplus", "bones", "knochen"]),
    (Focus::BrainAlone, &["stripped", "skullstripped", "bet", "brainmask"]),
];

/// Words that say that no contrast agent was given, or that it was.
const CONTRAST: [(bool, &[&str]); 2] = [
    (false, &["native", "nativ", "noncontrast", "unenhanced", "plain"]),
    (true, &["contrast", "cta", "arterial", "portal", "venous", "biphasic", "postcontrast", "km"]),
];

impl Subject {
    /// What words of descriptions, protocols and filters mean, in the order of their weight: what the first text says
    /// of a thing goes before what later ones do.
    pub fn of_texts<'a>(texts: impl IntoIterator<Item = &'a str>) -> Self {
        let mut subject = Self::default();
        for text in texts {
            let lower = text.to_lowercase();
            let words: Vec<&str> =
                lower.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
            fn find<T: Copy>(table: &[(T, &[&str])], words: &[&str]) -> Option<T> {
                table
                    .iter()
                    .find(|(_, known)| words.iter().any(|word| known.contains(word)))
                    .map(|(what, _)| *what)
            }
            // `non contrast` and `w/o contrast` are the opposite of what their last word says.
            let denies = words.windows(2).any(|pair| {
                ["non", "no", "without", "o", "wo", "ohne"].contains(&pair[0])
                    && ["contrast", "km", "iv"].contains(&pair[1])
            });
            subject.part = subject.part.or_else(|| find(&PARTS, &words));
            subject.focus = subject.focus.or_else(|| find(&FOCI, &words));
            let contrast = || if denies { Some(false) } else { find(&CONTRAST, &words) };
            subject.contrast = subject.contrast.or_else(contrast);
        }
        subject
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_the_field_are_understood() {
        let of = |text: &str| Subject::of_texts([text]);
        assert_eq!(of("CHEST").part, Some(BodyPart::Chest));
        assert_eq!(of("HEADNECK").part, Some(BodyPart::Head));
        assert_eq!(of("CHESTABDPELVIS").part, Some(BodyPart::Chest));
        assert_eq!(of("CTA_Head-Neck 0.75").part, Some(BodyPart::Head));
        assert_eq!(of("CTA_Head-Neck 0.75").focus, Some(Focus::Vessels));
        assert_eq!(of("C-SPINE").part, Some(BodyPart::Spine));
        assert_eq!(of("Thorax 1.0 lung").focus, Some(Focus::Lungs));
        assert_eq!(of("Brain, skull stripped, T1").focus, Some(Focus::BrainAlone));
        assert_eq!(of("BONEPLUS").focus, Some(Focus::Bone));
        assert_eq!(of("Abd w/o contrast").contrast, Some(false));
        assert_eq!(of("Abd arterial").contrast, Some(true));
        assert_eq!(of("scan 7, Headley"), Subject::default(), "only whole words");
        let both = Subject::of_texts(["", "KNEE", "chest native"]);
        assert_eq!((both.part, both.contrast), (Some(BodyPart::Limb), Some(false)), "the first counts");
    }
}
