//! Words that tell series apart: of DICOM's free texts those that are terms of the field, since any other may be a name.

use crate::dicom::{
    elements::{attributes as attr, data_set::DataSet},
    header::names::PatientNames,
};

/// Terms that descriptions of series and kernels are made of, in lower case.
const TERMS: &[&str] = &[
    "abdomen",
    "abd",
    "ac",
    "adc",
    "angio",
    "aorta",
    "arm",
    "arterial",
    "asl",
    "ax",
    "axial",
    "axials",
    "ankle",
    "attenuation",
    "average",
    "axl",
    "b",
    "base",
    "baseline",
    "bh",
    "biphasic",
    "black",
    "blood",
    "body",
    "bold",
    "bone",
    "boneplus",
    "brain",
    "breast",
    "bright",
    "brust",
    "c",
    "cardiac",
    "carotid",
    "cbf",
    "cbv",
    "ce",
    "cerebral",
    "cervical",
    "chest",
    "cine",
    "ciss",
    "contrast",
    "cor",
    "coronal",
    "coronary",
    "corrected",
    "cspine",
    "ct",
    "cta",
    "ctac",
    "cube",
    "delayed",
    "derived",
    "detail",
    "diffusion",
    "dixon",
    "dose",
    "dual",
    "dwi",
    "dti",
    "dynamic",
    "early",
    "echo",
    "edge",
    "elbow",
    "energy",
    "epi",
    "extremity",
    "fa",
    "face",
    "fast",
    "fat",
    "fdg",
    "fiesta",
    "filtered",
    "fl",
    "flair",
    "flash",
    "fmri",
    "foot",
    "fs",
    "fse",
    "fsat",
    "gated",
    "gd",
    "gre",
    "grase",
    "hand",
    "haste",
    "head",
    "heart",
    "high",
    "hip",
    "hr",
    "in",
    "inner",
    "iodine",
    "ir",
    "irm",
    "iv",
    "kidney",
    "knee",
    "kopf",
    "late",
    "lateral",
    "leg",
    "left",
    "liver",
    "localizer",
    "loc",
    "low",
    "lspine",
    "lumbar",
    "lung",
    "lungs",
    "map",
    "medium",
    "mip",
    "mmpr",
    "mono",
    "moco",
    "mpr",
    "mprage",
    "mr",
    "mra",
    "mrcp",
    "mri",
    "mtt",
    "multiphase",
    "nac",
    "native",
    "neck",
    "no",
    "non",
    "oblique",
    "obl",
    "opp",
    "orbit",
    "out",
    "pancreas",
    "parallel",
    "part",
    "pc",
    "pd",
    "pelvis",
    "perfusion",
    "pet",
    "phase",
    "plain",
    "portal",
    "post",
    "pre",
    "prone",
    "prostate",
    "recon",
    "reformat",
    "rest",
    "right",
    "sag",
    "sagittal",
    "scan",
    "scout",
    "se",
    "series",
    "sharp",
    "shoulder",
    "sinus",
    "skull",
    "slab",
    "smooth",
    "soft",
    "space",
    "spgr",
    "spin",
    "spine",
    "spoiled",
    "standard",
    "stir",
    "stress",
    "surview",
    "swi",
    "te",
    "temporal",
    "thick",
    "thin",
    "thorax",
    "thx",
    "tirm",
    "tissue",
    "tof",
    "topogram",
    "tra",
    "trace",
    "transverse",
    "tse",
    "tspine",
    "vascular",
    "venous",
    "vibe",
    "virtual",
    "vol",
    "water",
    "weighted",
    "whole",
    "with",
    "wo",
];

/// Whether a word names nothing but a thing of the field: a term, or a short code with a digit (`T2`, `B30f`, `1.0`).
/// Nothing of it is one of `names`.
fn is_told(word: &str, names: &PatientNames) -> bool {
    let lower = word.to_ascii_lowercase();
    if names.is_named(&lower) {
        return false;
    }
    let (digits, letters) = word.bytes().fold((0, 0), |(digits, letters), byte| {
        (digits + usize::from(byte.is_ascii_digit()), letters + usize::from(byte.is_ascii_alphabetic()))
    });
    // Numbers of patients, and dates, are longer.
    let is_code = (1..=4).contains(&digits) && letters <= 4 && word.len() <= 8;
    is_code || TERMS.contains(&&*lower)
}

/// The words of SeriesDescription that may be told; empty where none may.
pub(crate) fn series_label(data: &DataSet) -> String {
    told_words(&data.text(attr::SERIES_DESCRIPTION).unwrap_or_default(), &PatientNames::of(data))
}

/// The words of a text that are terms or codes, and nothing of `names`.
fn told_words(text: &str, names: &PatientNames) -> String {
    let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || ".+-".contains(c)));
    let told = |word: &str| -> Option<String> {
        // `T1-weighted` is two words.
        let mut parts = word.split(['-', '+']).filter(|part| !part.is_empty()).peekable();
        let is_any = parts.peek().is_some();
        (is_any && parts.all(|part| is_told(part, names)))
            .then(|| word.trim_matches(['-', '+', '.']).to_owned())
    };
    words.filter_map(told).take(MOST_WORDS).collect::<Vec<_>>().join(" ")
}

/// Words of a description; longer ones do not tell series apart at a glance.
const MOST_WORDS: usize = 6;

/// ConvolutionKernel as it may be told: `B30f`, `STANDARD`, `Br40d`.
pub(crate) fn kernel_label(data: &DataSet) -> String {
    let kernel = data.texts(attr::CONVOLUTION_KERNEL).swap_remove(0);
    if is_told_kernel(&kernel, &PatientNames::of(data)) { kernel } else { String::new() }
}

fn is_told_kernel(kernel: &str, names: &PatientNames) -> bool {
    // Philips and Canon have kernels of one letter or two.
    let is_short = kernel.len() <= 2 && kernel.bytes().all(|b| b.is_ascii_alphanumeric());
    is_told(kernel, names) || is_short && !names.has(&kernel.to_ascii_lowercase())
}

/// When a series was made, as `10:31:05`; empty where that is not given.
pub(crate) fn time_label(data: &DataSet) -> String {
    let seconds =
        data.seconds_of_day(attr::SERIES_TIME).or_else(|| data.seconds_of_day(attr::ACQUISITION_TIME));
    let Some(seconds) = seconds.filter(|seconds| (0.0..86_400.0).contains(seconds)) else {
        return String::new();
    };
    let seconds = seconds as u32;
    format!("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}

/// How an MR image is weighted, by its sequence and times; empty where they do not tell. `contrast` is what an enhanced
/// image says itself.
pub(crate) fn weighting(data: &DataSet, contrast: Option<&str>, b_value: f64) -> String {
    const CONTRASTS: [(&str, &str); 9] = [
        ("DIFFUSION", "diffusion"),
        ("FLOW_ENCODED", "flow"),
        ("FLUID_ATTENUATED", "FLAIR"),
        ("PERFUSION", "perfusion"),
        ("PROTON_DENSITY", "PD-weighted"),
        ("STIR", "STIR"),
        ("T1", "T1-weighted"),
        ("T2", "T2-weighted"),
        ("T2_STAR", "T2*-weighted"),
    ];
    if let Some((_, word)) = CONTRASTS.iter().find(|(term, _)| Some(*term) == contrast) {
        return (*word).to_owned();
    }
    let sequence = data.texts(attr::SCANNING_SEQUENCE);
    let has = |kind: &str| sequence.iter().any(|word| word == kind);
    let is_spoiled = data.texts(attr::SEQUENCE_VARIANT).iter().any(|word| word == "SP");
    let time = |attribute| data.decimal(attribute).ok().flatten().filter(|ms| (0.0..1e5).contains(ms));
    let (tr, te) = (time(attr::REPETITION_TIME), time(attr::ECHO_TIME));
    let inversion = time(attr::INVERSION_TIME).unwrap_or(0.0);
    let (Some(tr), Some(te)) = (tr, te) else { return String::new() };
    let word = match () {
        () if b_value > 0.0 => "diffusion",
        () if data.text(attr::ANGIO_FLAG).as_deref() == Some("Y") => "angiography",
        () if has("IR") && inversion >= 1500.0 && te >= 60.0 => "FLAIR",
        () if has("IR") && (80.0..=300.0).contains(&inversion) && te >= 15.0 => "STIR",
        () if has("EP") && te >= 20.0 => "T2*-weighted",
        () if has("GR") && te >= 15.0 => "T2*-weighted",
        // Of steady states that are not spoiled neither T1 nor T2 is told.
        () if has("GR") && te < 10.0 && (has("IR") || is_spoiled) => "T1-weighted",
        () if has("SE") && tr < 1000.0 && te <= 30.0 => "T1-weighted",
        () if has("SE") && tr >= 1500.0 && te >= 60.0 => "T2-weighted",
        () if has("SE") && tr >= 1500.0 && te < 50.0 => "PD-weighted",
        () => "",
    };
    let times = format!("TR {tr:.0} TE {te:.0} ms");
    if word.is_empty() { times } else { format!("{word} by {times}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_and_codes_are_told_and_names_are_not() {
        let nobody = PatientNames::default();
        for word in ["Thorax", "T2", "B30f", "1.0", "0.625", "b1000", "mprage"] {
            assert!(is_told(word, &nobody), "{word}");
        }
        for word in ["Miller", "JANE", "19500312", "AB123456", "P1234567", "Dr", ""] {
            assert!(!is_told(word, &nobody), "{word}");
        }
        assert!(!is_told("Brain", &PatientNames::called("Brain")), "somebody is called so");
        for (kernel, is_told) in [("Br40d", true), ("YA", true), ("Jane Doe", false)] {
            assert_eq!(is_told_kernel(kernel, &nobody), is_told, "{kernel}");
        }
    }
}
