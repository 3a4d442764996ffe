//! What the options say of labels and clip shapes, as documents have it.

use std::str::FromStr;

use lumivox_core::{
    ClipShape, Preset, color,
    document::{Color, Shape, Space, Style, Surface, rows},
    glam::DVec3,
};

/// `--label NAME=WORDS`.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelOption(pub Style);

impl FromStr for LabelOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, words) = text.rsplit_once('=').ok_or("must be NAME=WORD, as in lungs=hide")?;
        let mut style = Style { label: name.trim().to_owned(), ..Style::default() };
        words.split(',').try_for_each(|word| add(word.trim(), &mut style))?;
        Ok(Self(style))
    }
}

/// One word of a label's look.
fn add(text: &str, style: &mut Style) -> Result<(), String> {
    let (word, value) = text.split_once(':').map_or((text, None), |(word, value)| (word, Some(value)));
    let number = |high: f64| {
        let number = value.and_then(|value| value.trim().parse().ok());
        number
            .filter(|x| (0.0..=high).contains(x))
            .ok_or_else(|| format!("'{word}' wants a number from 0 to {high}, as in {word}:0.5"))
    };
    match (word, value) {
        ("hide", None) => style.visible = Some(false),
        ("show", None) => style.visible = Some(true),
        ("matte", None) => style.surface = Some(Surface::Switched(false)),
        ("uncut", None) => style.clipped = Some(false),
        ("color", None) => style.color = Some(Color::Own(true)),
        ("color", Some(value)) => {
            let rgb = color::srgb_from_hex(value)
                .ok_or_else(|| format!("'{value}' is no colour; write it as color:#c04030"))?;
            let linear = rgb.map(|c| color::linear_from_srgb(f64::from(c) / 255.0));
            style.color = Some(Color::Rgb(linear));
        }
        ("opacity", _) => style.opacity = Some(number(1.0)?),
        ("density", _) => style.density = Some(number(1e9)?),
        ("preset", Some(name)) => style.preset = Some(Preset::from_name(name).map_err(|e| e.to_string())?),
        _ => {
            return Err(format!(
                "'{text}' is none of hide, show, color, color:#rrggbb, opacity:F, density:F, preset:NAME, matte, \
                 uncut"
            ));
        }
    }
    Ok(())
}

/// `--clip-shape`: a shape in mm from the first scan's centre, x to the patient's left, y to the head, z to the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipOption(pub Shape);

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
        // Here it is made as if the world were a patient.
        let from_shape = rows(shape.patient_from_shape);
        Ok(Self(Shape { kind: shape.kind, from_shape, space: Space::World, inverted }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_make_styles() {
        let style = |text: &str| text.parse::<LabelOption>().unwrap().0;
        let bone = style("bone=show,color,opacity:0.5,uncut");
        let own = Some(Color::Own(true));
        assert_eq!((bone.label.as_str(), bone.visible, bone.color), ("bone", Some(true), own));
        assert_eq!((bone.opacity, bone.clipped, bone.surface), (Some(0.5), Some(false), None));
        let white = style("0=color:#ffffff,matte");
        assert_eq!(
            (white.color, white.surface),
            (Some(Color::Rgb([1.0; 3])), Some(Surface::Switched(false)))
        );
        for bad in ["bone", "bone=", "bone=color:red", "bone=opacity:2", "bone=opacity", "bone=preset:x"] {
            assert!(bad.parse::<LabelOption>().is_err(), "{bad}");
        }
    }

    #[test]
    fn shapes_are_placed_as_the_camera_is() {
        let world_from_patient = lumivox_core::world_from_patient();
        let shape = "!plane:0,10,0,0,1,0".parse::<ClipOption>().unwrap().0.placed(world_from_patient);
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
