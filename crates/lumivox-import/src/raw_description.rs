//! What the bytes of a file without a header mean, in words: those of a flag, or of the file's own name.

use std::{fmt, path::Path, str::FromStr};

use lumivox_core::Modality;

use crate::{axes::PatientAxes, modality::modality_of_word, sample::SampleType, text_header::parse_list};

/// What a description may hold after the size and the type.
const KEYS: &str = "spacing, axes, header, slope, intercept and modality";

/// What the bytes of a file without a header mean.
#[derive(Clone, Debug, PartialEq)]
pub struct RawDescription {
    /// Voxels along x (fastest), y and z.
    pub dims: [usize; 3],
    /// The type of each sample.
    pub sample: SampleType,
    /// Whether the most significant byte comes first.
    pub big_endian: bool,
    /// Bytes before the first sample.
    pub header_bytes: u64,
    /// Distances between voxels, in mm.
    pub spacing_mm: [f64; 3],
    /// Where the axes point in the patient; [`PatientAxes::LPS`] is assumed if it is not known.
    pub axes: Option<PatientAxes>,
    /// Physical units per stored unit.
    pub slope: f64,
    /// The physical value of a stored 0.
    pub intercept: f64,
    /// What made the scan, if known.
    pub modality: Option<Modality>,
}

/// Why a text is no [`RawDescription`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "'{part}' is not {expected}. A RAW volume is described as 256x256x108:i16le:spacing=1,1,2 with any of {KEYS}"
)]
pub struct RawDescriptionError {
    /// The part of the text that is wrong.
    pub part: String,
    /// What it should be.
    pub expected: &'static str,
}

impl RawDescription {
    /// Little-endian samples without a header at 1 mm.
    pub fn new(dims: [usize; 3], sample: SampleType) -> Self {
        Self {
            dims,
            sample,
            big_endian: false,
            header_bytes: 0,
            spacing_mm: [1.0; 3],
            axes: None,
            slope: 1.0,
            intercept: 0.0,
            modality: None,
        }
    }

    /// Parses `256x256x108:i16le:spacing=1,1,2`: the size, the type with `le` or `be`, then any of `spacing` (mm),
    /// `axes` (`LPS`, `RAS` and so on: where x, y and z grow to), `header` (bytes), `slope`, `intercept` and `modality`
    /// (`CT`, `MR`, `PET`).
    ///
    /// # Errors
    /// [`RawDescriptionError`] names the part that cannot be understood.
    pub fn parse(text: &str) -> Result<Self, RawDescriptionError> {
        let wrong = |part: &str, expected| RawDescriptionError { part: part.to_owned(), expected };
        let mut parts = text.trim().split(':');
        let size = parts.next().unwrap_or_default();
        let dims = parse_dims(size).ok_or_else(|| wrong(size, "a size such as 256x256x108"))?;
        let name = parts.next().unwrap_or_default();
        let (sample, big_endian) =
            parse_sample(name).ok_or_else(|| wrong(name, "a type such as u8, i16le, u16be or f32le"))?;
        let mut description = Self { big_endian, ..Self::new(dims, sample) };
        for part in parts {
            let (key, value) = part.split_once('=').ok_or_else(|| wrong(part, "of the form key=value"))?;
            match description.set(key.trim(), value.trim()) {
                Ok(true) => {}
                Ok(false) => {
                    return Err(wrong(key, "one of the keys"));
                }
                Err(expected) => return Err(wrong(part, expected)),
            }
        }
        Ok(description)
    }

    /// What the name of a file tells: `head_256x256x108_int16_0.957x0.957x1.5mm_LAS.raw`. It must hold the size and the
    /// type. Axes are capitals, since names have words such as `lip`.
    pub fn from_file_name(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?;
        let name = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
        let words = || name.split(|c: char| "_- ,()[]".contains(c)).filter(|word| !word.is_empty());
        let dims = words().find_map(parse_dims)?;
        let (sample, big_endian) = words().find_map(parse_sample)?;
        let spacing = words().find_map(|word| {
            let lengths: Option<Vec<f64>> =
                word.strip_suffix("mm")?.split('x').map(|n| n.parse().ok()).collect();
            parse_spacing(&lengths?)
        });
        let spacing_mm = spacing.unwrap_or([1.0; 3]);
        let axes = words().filter(|word| word.chars().all(|c| c.is_ascii_uppercase()));
        let axes = axes.filter_map(|word| word.parse().ok()).next();
        Some(Self { big_endian, spacing_mm, axes, ..Self::new(dims, sample) })
    }

    /// Sets a field by name. `false` when there is none of that name, an error when the value does not fit.
    pub(crate) fn set(&mut self, key: &str, value: &str) -> Result<bool, &'static str> {
        fn number(value: &str) -> Result<f64, &'static str> {
            value.parse().ok().filter(|n: &f64| n.is_finite()).ok_or("a finite number")
        }
        match key.to_ascii_lowercase().as_str() {
            "spacing" | "spacing_mm" => {
                let lengths = parse_list(value.trim_matches(['[', ']'])).unwrap_or_default();
                self.spacing_mm =
                    parse_spacing(&lengths).ok_or("three positive lengths in mm such as 0.5,0.5,2")?;
            }
            "axes" => {
                self.axes = Some(value.parse().map_err(|_| {
                    "three letters such as LPS or RAS: where x, y and z grow to, each of L/R, P/A and S/I once"
                })?);
            }
            "header" | "header_bytes" | "skip" | "bytestoskip" => {
                self.header_bytes = value.parse().map_err(|_| "a number of bytes")?;
            }
            "slope" => {
                self.slope = number(value)?;
                if !self.slope.is_normal() {
                    return Err("a number other than 0");
                }
            }
            "intercept" => self.intercept = number(value)?,
            "modality" => {
                self.modality = Some(modality_of_word(value).ok_or("one of CT, MR, PET and other")?);
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Bytes that a file of this description has; `None` when that is more than any file.
    pub(crate) fn file_bytes(&self) -> Option<u64> {
        let samples = self.dims.iter().try_fold(1u64, |n, size| n.checked_mul(*size as u64))?;
        samples.checked_mul(self.sample.bytes() as u64)?.checked_add(self.header_bytes)
    }
}

impl FromStr for RawDescription {
    type Err = RawDescriptionError;

    fn from_str(text: &str) -> Result<Self, RawDescriptionError> {
        Self::parse(text)
    }
}

impl fmt::Display for RawDescription {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.dims;
        write!(f, "{x}x{y}x{z}:{}{}", self.sample, if self.big_endian { "be" } else { "le" })?;
        let [sx, sy, sz] = self.spacing_mm;
        write!(f, ":spacing={sx},{sy},{sz}")?;
        if let Some(axes) = self.axes {
            write!(f, ":axes={axes}")?;
        }
        if self.header_bytes != 0 {
            write!(f, ":header={}", self.header_bytes)?;
        }
        if (self.slope, self.intercept) != (1.0, 0.0) {
            write!(f, ":slope={}:intercept={}", self.slope, self.intercept)?;
        }
        match self.modality {
            None => Ok(()),
            Some(Modality::Ct) => f.write_str(":modality=CT"),
            Some(Modality::Mr) => f.write_str(":modality=MR"),
            Some(Modality::Pet) => f.write_str(":modality=PET"),
            Some(Modality::Other) => f.write_str(":modality=other"),
        }
    }
}

/// `256x256x108`.
pub(crate) fn parse_dims(text: &str) -> Option<[usize; 3]> {
    let sizes: Option<Vec<usize>> = text.trim().split(['x', 'X']).map(|n| n.parse().ok()).collect();
    <[usize; 3]>::try_from(sizes?).ok().filter(|dims| !dims.contains(&0))
}

/// A type with its byte order: `i16le`, `int16`, `u16be`.
pub(crate) fn parse_sample(text: &str) -> Option<(SampleType, bool)> {
    let text = text.trim().to_ascii_lowercase();
    if let Ok(sample) = text.parse() {
        return Some((sample, false));
    }
    let (name, big_endian) = match (text.strip_suffix("le"), text.strip_suffix("be")) {
        (Some(name), _) => (name, false),
        (_, Some(name)) => (name, true),
        _ => return None,
    };
    Some((name.parse().ok()?, big_endian))
}

fn parse_spacing(lengths: &[f64]) -> Option<[f64; 3]> {
    <[f64; 3]>::try_from(lengths).ok().filter(|mm| mm.iter().all(|mm| mm.is_normal() && *mm > 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn descriptions_are_parsed_and_printed() {
        let text =
            "256x256x108:i16be:spacing=0.5,1,2.25:axes=LAS:header=12:slope=2:intercept=-1024:modality=CT";
        let description = RawDescription::parse(text).unwrap();
        let expected = RawDescription {
            dims: [256, 256, 108],
            sample: SampleType::I16,
            big_endian: true,
            header_bytes: 12,
            spacing_mm: [0.5, 1.0, 2.25],
            axes: Some("LAS".parse().unwrap()),
            slope: 2.0,
            intercept: -1024.0,
            modality: Some(Modality::Ct),
        };
        assert_eq!(description, expected);
        assert_eq!(description.to_string(), text);
        assert_eq!(text.parse(), Ok(expected));
        let plain = RawDescription::parse("2x3x4:u8").unwrap();
        assert_eq!(plain, RawDescription::new([2, 3, 4], SampleType::U8));
        assert_eq!(RawDescription::parse(&plain.to_string()), Ok(plain));
    }

    #[test]
    fn what_is_wrong_with_a_description_is_named() {
        for (text, part) in [
            ("", "''"),
            ("256x256:u8", "'256x256'"),
            ("0x1x1:u8", "'0x1x1'"),
            ("1x1x1", "''"),
            ("1x1x1:i12", "'i12'"),
            ("1x1x1:u8:spacing", "'spacing'"),
            ("1x1x1:u8:spacing=1,2", "'spacing=1,2'"),
            ("1x1x1:u8:spacing=1,2,NaN", "'spacing=1,2,NaN'"),
            ("1x1x1:u8:slope=0", "'slope=0'"),
            ("1x1x1:u8:header=-1", "'header=-1'"),
            ("1x1x1:u8:axes=LLS", "'axes=LLS'"),
            ("1x1x1:u8:size=5", "'size'"),
            ("99999999999999999999x1x1:u8", "'99999999999999999999x1x1'"),
        ] {
            let error = RawDescription::parse(text).unwrap_err().to_string();
            assert!(error.starts_with(part), "{text}: {error}");
        }
    }

    #[test]
    fn names_tell_size_type_and_spacing() {
        let of = |name: &str| RawDescription::from_file_name(Path::new(name));
        let head = of("head_ct_256x256x108_int16_0.957x0.957x1.5mm.raw").unwrap();
        assert_eq!((head.dims, head.sample), ([256, 256, 108], SampleType::I16));
        assert_eq!(head.spacing_mm, [0.957, 0.957, 1.5]);
        assert_eq!(of("bonsai_64x32x16_uint8.raw").unwrap().spacing_mm, [1.0; 3]);
        assert!(of("a-4x4x4-uint16be.raw").unwrap().big_endian);
        assert_eq!(of("lip_4x4x4_uint8_LAS.raw").unwrap().axes, "LAS".parse().ok());
        assert_eq!(of("lip_4x4x4_uint8.raw").unwrap().axes, None);
        assert_eq!(of("bonsai_64x32x16.raw"), None);
        assert_eq!(of("uint8.raw"), None);
    }
}
