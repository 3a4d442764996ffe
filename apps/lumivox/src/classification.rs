//! What the options say of labels and clip shapes.

use std::{str::FromStr, sync::Arc};

use lumivox_core::{
    ClipShape, LabelStyle, LabelVolume, Labelling, Preset, SurfaceReflection, Volume, color,
    glam::{DAffine3, DVec3},
};

use crate::exit::Failure;

/// `--label NAME=WORDS`.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelOption {
    /// The label's name, its number, or `*` for all. A name goes before a number; `#2` is the number.
    name: String,
    words: Vec<Word>,
}

/// One word of a label's look.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Word {
    Hide,
    Show,
    OwnColor,
    Color([f64; 3]),
    Opacity(f64),
    Density(f64),
    Preset(Preset),
    Matte,
    Uncut,
}

impl FromStr for LabelOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, words) = text.rsplit_once('=').ok_or("must be NAME=WORD, as in lungs=hide")?;
        let words = words.split(',').map(|word| word.trim().parse()).collect::<Result<_, _>>()?;
        Ok(Self { name: name.trim().to_owned(), words })
    }
}

impl FromStr for Word {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (word, value) = text.split_once(':').map_or((text, None), |(word, value)| (word, Some(value)));
        let number = |high: f64| {
            let number = value.and_then(|value| value.trim().parse().ok());
            number
                .filter(|x| (0.0..=high).contains(x))
                .ok_or_else(|| format!("'{word}' wants a number from 0 to {high}, as in {word}:0.5"))
        };
        match (word, value) {
            ("hide", None) => Ok(Self::Hide),
            ("show", None) => Ok(Self::Show),
            ("matte", None) => Ok(Self::Matte),
            ("uncut", None) => Ok(Self::Uncut),
            ("color", None) => Ok(Self::OwnColor),
            ("color", Some(value)) => {
                let rgb = crate::args::hex_color(value)
                    .ok_or_else(|| format!("'{value}' is no colour; write it as color:#c04030"))?;
                Ok(Self::Color(rgb.map(|c| color::linear_from_srgb(f64::from(c) / 255.0))))
            }
            ("opacity", _) => number(1.0).map(Self::Opacity),
            ("density", _) => number(1e9).map(Self::Density),
            ("preset", Some(name)) => Preset::from_name(name).map(Self::Preset).map_err(|e| e.to_string()),
            _ => Err(format!(
                "'{text}' is none of hide, show, color, color:#rrggbb, opacity:F, density:F, preset:NAME, matte, \
                 uncut"
            )),
        }
    }
}

/// Labels, and the numbers by which people know them.
#[derive(Clone)]
pub struct Numbered {
    /// The labels.
    pub labels: Arc<LabelVolume>,
    /// The numbers that they have in their file, which may be others than their values.
    pub numbers: Vec<(i128, u8)>,
}

impl Numbered {
    /// Labels whose numbers are their values.
    pub fn new(labels: LabelVolume) -> Self {
        Self { numbers: labels.numbers(), labels: Arc::new(labels) }
    }
}

/// Labels with the looks that the options give them, in their order.
///
/// # Errors
/// A label that there is not.
pub fn labelling(
    numbered: &Numbered,
    options: &[LabelOption],
    volume: &Volume,
) -> Result<Labelling, Failure> {
    let mut labelling = Labelling::new(numbered.labels.clone());
    for option in options {
        let values = numbered.labels.values_of(&option.name, &numbered.numbers);
        if values.is_empty() {
            let names = labelling.labels.labels().iter().map(|label| label.name.as_str());
            let names: Vec<&str> = names.chain(["unlabelled"]).collect();
            return Err(Failure::usage(format!(
                "--label {}: there is no such label; there are {} and *",
                option.name,
                names.join(", ")
            )));
        }
        for value in values {
            let own = labelling.labels.label(value).map(|label| label.color);
            let mut style = labelling.style(value);
            for word in &option.words {
                apply(*word, own, volume, &mut style);
            }
            labelling.set_style(value, style);
        }
    }
    Ok(labelling)
}

fn apply(word: Word, own_color: Option<[f64; 3]>, volume: &Volume, style: &mut LabelStyle) {
    match word {
        Word::Hide => style.visible = false,
        Word::Show => style.visible = true,
        Word::OwnColor => style.color = own_color,
        Word::Color(color) => style.color = Some(color),
        Word::Opacity(opacity) => style.opacity = opacity,
        Word::Density(density) => style.density_scale = Some(density),
        Word::Preset(preset) => {
            let medium = preset.medium(volume);
            style.transfer_function = Some(medium.transfer_function);
            style.density_scale = Some(medium.density_scale);
            style.surface = Some(medium.surface);
        }
        Word::Matte => style.surface = Some(SurfaceReflection::OFF),
        Word::Uncut => style.clipped = false,
    }
}

/// `--clip-shape`: a shape in mm from the first scan's centre, x to the patient's left, y to the head, z to the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipOption(ClipShape);

impl FromStr for ClipOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (inverted, rest) = text.strip_prefix('!').map_or((false, text), |rest| (true, rest));
        let (kind, numbers) = rest.split_once(':').unwrap_or((rest, ""));
        let point = |numbers: &[f64]| DVec3::from_slice(numbers);
        if numbers
            .split(',')
            .filter_map(|n| n.trim().parse().ok())
            .any(|n: f64| n.abs() > crate::args::FURTHEST)
        {
            return Err("must be within 1 km (1000000 mm) of the scan".into());
        }
        let shape = match kind {
            "plane" => {
                let n: [f64; 6] = crate::args::numbers(numbers)?;
                if point(&n[3..]).length() < 1e-12 {
                    return Err("the plane's normal, the last three numbers, must not be zero".into());
                }
                ClipShape::plane(point(&n[..3]), point(&n[3..]))
            }
            "box" => {
                let n: [f64; 6] = crate::args::numbers(numbers)?;
                ClipShape::aligned_box(point(&n[..3]), point(&n[3..]))
            }
            "sphere" => {
                let n: [f64; 4] = crate::args::numbers(numbers)?;
                if n[3] <= 0.0 {
                    return Err("the sphere's radius, the last number, must be above 0".into());
                }
                ClipShape::sphere(point(&n[..3]), n[3])
            }
            _ => return Err("must be plane:, box: or sphere: with numbers, perhaps after a '!'".into()),
        };
        if !shape.is_solid() {
            return Err(format!("the {kind} has no inside"));
        }
        Ok(Self(if inverted { shape.invert() } else { shape }))
    }
}

impl ClipOption {
    /// The shape for a volume that is placed so; world metres.
    pub fn shape(self, world_from_patient: DAffine3) -> ClipShape {
        let world_from_mm = DAffine3::from_scale(DVec3::splat(1e-3));
        let patient_from_shape = world_from_patient.inverse() * world_from_mm * self.0.patient_from_shape;
        ClipShape { patient_from_shape, ..self.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lumivox_core::{Label, Modality, Voxels};

    #[test]
    fn words_make_styles_in_their_order() {
        let label = |value, name: &str| Label { value, name: name.into(), color: [0.25; 3] };
        let named = vec![label(1, "left lung"), label(2, "bone")];
        let labels = LabelVolume::new([2, 1, 1], vec![1, 2], DAffine3::IDENTITY, named).unwrap();
        let volume = Volume::new([1; 3], Voxels::U8(vec![0]), [1.0, 0.0], DAffine3::IDENTITY, Modality::Ct);
        let volume = volume.unwrap();
        let options = ["*=hide", "bone=show,color,opacity:0.5,uncut", "0=color:#ffffff,matte"];
        let options: Vec<LabelOption> = options.iter().map(|text| text.parse().unwrap()).collect();
        let numbered = Numbered { numbers: vec![(1024, 1), (2, 2)], ..Numbered::new(labels) };
        let labelling = labelling(&numbered, &options, &volume).unwrap();
        assert!(!labelling.style(1).visible && !labelling.style(0).visible);
        let bone = labelling.style(2);
        assert!(bone.visible && !bone.clipped && bone.color == Some([0.25; 3]) && bone.opacity == 0.5);
        assert_eq!(labelling.style(0).color, Some([1.0; 3]));
        let unknown = ["liver=hide".parse().unwrap()];
        let error = super::labelling(&numbered, &unknown, &volume).unwrap_err();
        assert!(error.message.contains("left lung, bone, unlabelled"), "{}", error.message);
        for bad in ["bone", "bone=", "bone=color:red", "bone=opacity:2", "bone=opacity", "bone=preset:x"] {
            assert!(bad.parse::<LabelOption>().is_err(), "{bad}");
        }
    }

    #[test]
    fn shapes_are_placed_as_the_camera_is() {
        let ClipOption(plane) = "plane:0,10,0,0,1,0".parse().unwrap();
        assert!(!plane.inverted);
        let world_from_patient = lumivox_core::world_from_patient();
        let shape = "!plane:0,10,0,0,1,0".parse::<ClipOption>().unwrap().shape(world_from_patient);
        // 10 mm towards the head is z in the patient.
        let point = shape.patient_from_shape.transform_point3(DVec3::ZERO);
        assert!(point.distance(DVec3::Z * 10.0) < 1e-9 && shape.inverted);
        let normal = shape.patient_from_shape.transform_vector3(DVec3::Z).normalize();
        assert!(normal.distance(DVec3::Z) < 1e-9);
        for bad in [
            "cube:1",
            "plane:0,0,0,0,0,0",
            "sphere:0,0,0,0",
            "sphere:0,0,0,-5",
            "box:0,0,0,1,1,0",
            "sphere:0,0,0",
            "plane:1e300,0,0,1,0,0",
        ] {
            assert!(bad.parse::<ClipOption>().is_err(), "{bad}");
        }
    }
}
