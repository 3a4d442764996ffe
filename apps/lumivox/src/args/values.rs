//! What single options take, and what of it makes no sense.

use std::{path::PathBuf, str::FromStr, time::Duration};

use clap::ValueEnum;
use lumivox_core::{Filter, Light, LightKind, Modality, document, glam::DVec3};

/// On or off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    On,
    Off,
}

/// Tone maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Tone {
    Plain,
    Agx,
    Aces,
}

/// Interpolations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FilterName {
    Nearest,
    Trilinear,
    Tricubic,
    Smooth,
}

impl From<Tone> for document::Tone {
    fn from(tone: Tone) -> Self {
        match tone {
            Tone::Plain => Self::Plain,
            Tone::Agx => Self::Agx,
            Tone::Aces => Self::Aces,
        }
    }
}

impl From<FilterName> for Filter {
    fn from(name: FilterName) -> Self {
        match name {
            FilterName::Nearest => Filter::Nearest,
            FilterName::Trilinear => Filter::Trilinear,
            FilterName::Tricubic => Filter::Tricubic,
            FilterName::Smooth => Filter::Smooth,
        }
    }
}

/// A parser of finite numbers within a range.
pub fn number(low: f64, high: f64) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.trim().parse::<f64>().map_err(|_| "not a number".to_owned())?;
        if (low..=high).contains(&number) { Ok(number) } else { Err(format!("must be {low} to {high}")) }
    }
}

pub fn seconds(text: &str) -> Result<Duration, String> {
    number(0.01, 1e7)(text.trim_end_matches('s')).map(Duration::from_secs_f64)
}

/// A parser of slopes.
pub fn slope(text: &str) -> Result<f64, String> {
    number(-1e9, 1e9)(text)
        .and_then(|slope| if slope.is_normal() { Ok(slope) } else { Err("must not be 0".into()) })
}

/// A parser of modalities.
pub fn modality(text: &str) -> Result<Modality, String> {
    lumivox_import::modality_of_word(text).ok_or_else(|| "must be CT, MR, PET or other".into())
}

/// Over which values a look is stretched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Its centre.
    pub level: f64,
    /// From its lowest value to its highest.
    pub width: f64,
}

impl FromStr for Window {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [level, width] = numbers(text).map_err(|_| "must be LEVEL,WIDTH, such as 40,400")?;
        if level.abs() > 1e9 || !(1e-9..=1e9).contains(&width) {
            return Err("WIDTH must be above 0, and both below 1e9".into());
        }
        Ok(Self { level, width })
    }
}

/// `n` finite numbers between commas.
pub fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let error = || format!("must be {N} numbers with commas between them");
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|part| part.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    numbers.ok_or_else(error)?.try_into().map_err(|_| error())
}

/// Most pixels of an image.
const MOST_PIXELS: u64 = 1 << 28;

/// Memory that a pixel takes until it is written: the film on the GPU and here, its copies, and the picture.
pub const BYTES_PER_PIXEL: u64 = 100;

/// An image size in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const LARGEST: u32 = 32_768;
        let side = |text: &str| text.trim().parse().ok().filter(|side| (1..=LARGEST).contains(side));
        let (width, height) = text.split_once(['x', 'X']).ok_or("must be WIDTHxHEIGHT, such as 1920x1080")?;
        match (side(width), side(height)) {
            (Some(width), Some(height)) => {
                let pixels = u64::from(width) * u64::from(height);
                if pixels > MOST_PIXELS {
                    return Err(format!(
                        "{} million pixels are too many, they would need {} GB of memory; at most {} million",
                        pixels / 1_000_000,
                        pixels * BYTES_PER_PIXEL / 1_000_000_000,
                        MOST_PIXELS / 1_000_000,
                    ));
                }
                Ok(Self { width, height })
            }
            _ => Err(format!("width and height must be 1 to {LARGEST}")),
        }
    }
}

/// Largest coordinate of a camera in mm: further away, nothing is seen, and 32-bit floats fail.
pub const FURTHEST: f64 = 1e6;

/// A point in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point(pub DVec3);

impl FromStr for Point {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let point = DVec3::from_array(numbers(text)?);
        if point.abs().max_element() > FURTHEST {
            return Err("must be within 1 km (1000000 mm) of the scan".into());
        }
        Ok(Self(point))
    }
}

/// Opposite corners of what is kept, in box coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip(pub [DVec3; 2]);

impl FromStr for Clip {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [a, b, c, d, e, f] = numbers(text)?;
        let corners = [DVec3::new(a, b, c), DVec3::new(d, e, f)];
        let inside = corners.iter().all(|p| p.min_element() >= 0.0 && p.max_element() <= 1.0);
        if inside && corners[0].cmplt(corners[1]).all() {
            Ok(Self(corners))
        } else {
            Err("must be fractions from 0 to 1, each low one below its high one".into())
        }
    }
}

/// Where light comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EnvironmentName {
    /// The built-in studio.
    Studio,
    /// The same from everywhere.
    Uniform,
    /// An overcast sky over dim ground.
    Gradient,
    /// A panorama.
    File(PathBuf),
}

impl FromStr for EnvironmentName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "studio" => Ok(Self::Studio),
            "uniform" => Ok(Self::Uniform),
            "gradient" => Ok(Self::Gradient),
            // A bare word is a typing error rather than a file.
            _ if !text.contains(['.', '/', '\\']) => {
                Err("must be studio, uniform, gradient or an .hdr or .exr file".into())
            }
            _ => Ok(Self::File(text.into())),
        }
    }
}

/// A distant light, by where it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun(pub Light);

impl FromStr for Sun {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let values = text.strip_prefix("sun:").ok_or("must start with sun:, such as sun:40,30")?;
        // The radius that the sun has in the sky.
        let [azimuth, elevation, strength, degrees] = match values.split(',').count() {
            2 => numbers(values).map(|[a, e]| [a, e, 1.0, 0.27])?,
            3 => numbers(values).map(|[a, e, s]| [a, e, s, 0.27])?,
            _ => numbers(values).map_err(|_| "must be sun: and 2 to 4 numbers with commas between them")?,
        };
        if !(0.0..=1e6).contains(&strength) || !(0.0..=180.0).contains(&degrees) {
            return Err("STRENGTH must be 0 to 1000000, DEGREES 0 to 180".into());
        }
        let (sin_a, cos_a) = azimuth.to_radians().sin_cos();
        let (sin_e, cos_e) = elevation.to_radians().sin_cos();
        let kind = LightKind::Directional {
            direction: -DVec3::new(sin_a * cos_e, sin_e, cos_a * cos_e),
            irradiance: [strength * std::f64::consts::PI; 3],
            angular_radius: degrees.to_radians(),
        };
        Ok(Self(kind.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lumivox_core::document::Backdrop;

    #[test]
    fn values_are_read_or_refused() {
        assert_eq!("1920x1080".parse(), Ok(Size { width: 1920, height: 1080 }));
        for bad in ["", "100", "0x5", "5x0", "99999x1", "32768x32768", "1x2x3", "-1x5"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
        assert_eq!("-40,400".parse(), Ok(Window { level: -40.0, width: 400.0 }));
        for bad in ["40", "40,0", "40,-5", "40,400,1", "a,b"] {
            assert!(bad.parse::<Window>().is_err(), "{bad}");
        }
        assert!(slope("0").is_err() && slope("-2") == Ok(-2.0));
        assert!(modality("pt") == Ok(Modality::Pet) && modality("US").is_err());
        assert_eq!("1, -2.5,3".parse(), Ok(Point(DVec3::new(1.0, -2.5, 3.0))));
        for bad in ["1,2", "1,2,3,4", "1e7,0,0", "a,b,c", "nan,0,0", "inf,0,0"] {
            assert!(bad.parse::<Point>().is_err(), "{bad}");
        }
        assert!("0,0,0,1,1,0.5".parse::<Clip>().is_ok());
        for bad in ["0,0,0,1,1,0", "0,0,0,1,1,2", "-1,0,0,1,1,1", "0,0,0"] {
            assert!(bad.parse::<Clip>().is_err(), "{bad}");
        }
        assert_eq!("#0a0B0c".parse(), Ok(Backdrop::Color([10, 11, 12])));
        for bad in ["#12345", "#12345g", "red", "#+12345"] {
            assert!(bad.parse::<Backdrop>().is_err(), "{bad}");
        }
        assert_eq!("sky.hdr".parse(), Ok(EnvironmentName::File("sky.hdr".into())));
        assert!("studoi".parse::<EnvironmentName>().is_err());
        let Ok(Sun(Light { kind: LightKind::Directional { direction, irradiance, .. }, .. })) =
            "sun:90,0,2".parse()
        else {
            panic!("a sun");
        };
        assert!(
            direction.distance(DVec3::NEG_X) < 1e-12 && (irradiance[0] - std::f64::consts::TAU).abs() < 1e-6
        );
        for bad in ["90,0", "sun:90", "sun:1,2,-3", "sun:1,2,3,181", "sun:1,2,3,4,5", "sun:nan,0", "moon:1,2"]
        {
            assert!(bad.parse::<Sun>().is_err(), "{bad}");
        }
        assert!(seconds("0").is_err() && seconds("2.5s") == Ok(Duration::from_secs_f64(2.5)));
    }
}
