//! From where a scene is seen, and the picture that becomes of it.

use glam::DVec3;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{
    numbers::{Faults, METRES_PER_MM, Rows, affine, rows},
    ranges, read,
};
use crate::{camera::PerspectiveCamera, framing, scene::Scene};

/// From where a scene is seen: exactly, by `world_from_camera`; else from an `eye`; else from around what there is to see.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct View {
    /// Where the camera's space, in which it looks along -z with y up, lies in the world; a turn and a place, in mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::COORDINATE.said()))]
    pub world_from_camera: Option<Rows>,
    /// Degrees around the vertical; 0 sees the face, and a single slice is seen from its front where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::AZIMUTH.said()))]
    pub azimuth: Option<f64>,
    /// Degrees above the horizon.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::ELEVATION.said()))]
    pub elevation: Option<f64>,
    /// How many times closer than where everything fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::ZOOM.said()))]
    pub zoom: Option<f64>,
    /// Where the camera is, in mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::EYE.said()))]
    pub eye: Option<[f64; 3]>,
    /// The point looked at, in mm; the centre of what is seen where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::EYE.said()))]
    pub target: Option<[f64; 3]>,
    /// Degrees between the bottom and the top of the image.
    #[cfg_attr(test, schemars(transform = ranges::FOV.said()))]
    pub fov: f64,
}

impl Default for View {
    fn default() -> Self {
        Self {
            world_from_camera: None,
            azimuth: None,
            elevation: None,
            zoom: None,
            eye: None,
            target: None,
            fov: 28.0,
        }
    }
}

impl View {
    /// A camera as it stands.
    pub fn of(camera: &PerspectiveCamera) -> Self {
        let mut world_from_camera = camera.world_from_camera;
        // Its own space is of metres, too: only where it stands is scaled.
        world_from_camera.translation /= METRES_PER_MM;
        Self {
            world_from_camera: Some(rows(world_from_camera)),
            fov: camera.vertical_fov.to_degrees(),
            ..Self::default()
        }
    }

    /// The camera for a scene; `aspect` is width over height. `None` where it is the point looked at.
    pub fn camera(&self, scene: &Scene, aspect: f64) -> Option<PerspectiveCamera> {
        let fov = self.fov.to_radians();
        if let Some(rows) = self.world_from_camera {
            let mut world_from_camera = affine(rows);
            world_from_camera.translation *= METRES_PER_MM;
            return Some(PerspectiveCamera { world_from_camera, vertical_fov: fov });
        }
        let metres = |point: [f64; 3]| DVec3::from_array(point) * METRES_PER_MM;
        let look_at = |eye: [f64; 3], target: DVec3| {
            let eye = metres(eye);
            (eye.distance(target) > 1e-9).then(|| PerspectiveCamera::look_at(eye, target, DVec3::Y, fov))
        };
        if let (Some(eye), Some(target)) = (self.eye, self.target) {
            return look_at(eye, metres(target));
        }
        let front = scene.volumes.first().and_then(framing::front);
        let front = front.filter(|_| (self.azimuth, self.elevation) == (None, None));
        let [azimuth, elevation] =
            front.unwrap_or([self.azimuth, self.elevation].map(|angle| angle.unwrap_or(0.0).to_radians()));
        let mut orbit = framing::frame(scene, azimuth, elevation, fov, aspect);
        if let Some(target) = self.target {
            orbit.target = metres(target);
        }
        if let Some(eye) = self.eye {
            return look_at(eye, orbit.target);
        }
        orbit.distance /= self.zoom.unwrap_or(1.0);
        Some(orbit.camera())
    }

    pub(super) fn check(&self, faults: &mut Faults) {
        if let Some(rows) = self.world_from_camera {
            let turn = affine(rows).matrix3;
            let is_near = rows.iter().flatten().all(|number| ranges::COORDINATE.holds(*number));
            let is_rigid = (turn * turn.transpose()).abs_diff_eq(glam::DMat3::IDENTITY, 1e-3)
                && turn.determinant() > 0.0;
            faults.unless(is_rigid && is_near, "world_from_camera", || {
                "world_from_camera is not a turn and a place: three rows of four numbers".into()
            });
            let others = [self.azimuth, self.elevation, self.zoom].iter().all(Option::is_none);
            faults.unless(others && self.eye.is_none() && self.target.is_none(), "world_from_camera", || {
                "world_from_camera says all: leave azimuth, elevation, zoom, eye and target out".into()
            });
        }
        faults.unless(
            self.eye.is_none() || (self.azimuth, self.elevation, self.zoom) == (None, None, None),
            "eye",
            || "eye says where the camera is: leave azimuth, elevation and zoom out".into(),
        );
        faults.number("azimuth", self.azimuth, ranges::AZIMUTH);
        faults.number("elevation", self.elevation, ranges::ELEVATION);
        faults.number("zoom", self.zoom, ranges::ZOOM);
        faults.numbers("eye", self.eye, ranges::EYE);
        faults.numbers("target", self.target, ranges::EYE);
        faults.number("fov", Some(self.fov), ranges::FOV);
    }
}

/// The image that is rendered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Film {
    /// Width and height in pixels.
    #[cfg_attr(test, schemars(transform = ranges::SIDE.said()))]
    pub size: [u32; 2],
    /// Paths per pixel; where nothing is said, as many as the host finds enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::SAMPLES.said()))]
    pub samples: Option<u32>,
    /// The same seed gives the same noise.
    #[cfg_attr(test, schemars(transform = ranges::WORD.said()))]
    pub seed: u32,
    /// Relative noise at which it is done before it has all samples, such as 0.02.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::NOISE.said()))]
    pub noise: Option<f64>,
    /// Whether the noise that is left is smoothed out.
    pub denoise: bool,
}

impl Default for Film {
    fn default() -> Self {
        Self { size: [768, 768], samples: None, seed: 0, noise: None, denoise: false }
    }
}

impl Film {
    /// Width over height.
    pub fn aspect(&self) -> f64 {
        f64::from(self.size[0]) / f64::from(self.size[1])
    }

    /// Width times height.
    pub fn pixels(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    pub(super) fn check(&self, faults: &mut Faults) {
        let [width, height] = self.size;
        let is_image = self.size.iter().all(|side| ranges::SIDE.holds(f64::from(*side)))
            && self.pixels() <= ranges::MOST_PIXELS;
        faults.unless(is_image, "size", || {
            format!(
                "{width} x {height} is no image: sides are {} to {}, and pixels at most {}",
                ranges::SIDE.low,
                ranges::SIDE.high,
                ranges::MOST_PIXELS
            )
        });
        faults.number("samples", self.samples.map(f64::from), ranges::SAMPLES);
        faults.number("noise", self.noise, ranges::NOISE);
    }
}

/// How light becomes pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Display {
    /// What stands behind.
    pub background: Backdrop,
    /// Stops brighter.
    #[cfg_attr(test, schemars(transform = ranges::EXPOSURE.said()))]
    pub exposure: f64,
    /// The curve.
    pub tone: Tone,
    /// Brightens the mid-tones above 1.
    #[cfg_attr(test, schemars(transform = ranges::GAMMA.said()))]
    pub gamma: f64,
}

impl Default for Display {
    fn default() -> Self {
        Self { background: Backdrop::default(), exposure: 0.0, tone: Tone::default(), gamma: 1.0 }
    }
}

impl Display {
    pub(super) fn check(&self, faults: &mut Faults) {
        faults.number("exposure", Some(self.exposure), ranges::EXPOSURE);
        faults.number("gamma", Some(self.gamma), ranges::GAMMA);
    }
}

/// The curve from light to pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Tone {
    /// Clipped.
    Plain,
    /// Film-like, soft.
    #[default]
    Agx,
    /// Film-like, of more contrast.
    Aces,
}

/// What stands behind a scene: `transparent`, `environment`, or the colour that the screen shows, `#rrggbb`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backdrop {
    /// Nothing: the picture has an alpha channel.
    Transparent,
    /// The light.
    Environment,
    /// A colour (sRGB).
    Color([u8; 3]),
}

impl Default for Backdrop {
    fn default() -> Self {
        Self::Color([0x14, 0x17, 0x1c])
    }
}

impl std::fmt::Display for Backdrop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Transparent => f.write_str("transparent"),
            Self::Environment => f.write_str("environment"),
            Self::Color([r, g, b]) => write!(f, "#{r:02x}{g:02x}{b:02x}"),
        }
    }
}

impl std::str::FromStr for Backdrop {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "transparent" => return Ok(Self::Transparent),
            "environment" => return Ok(Self::Environment),
            _ => {}
        }
        crate::color::srgb_from_hex(text)
            .map(Self::Color)
            .ok_or_else(|| "must be transparent, environment or a colour such as #202428".into())
    }
}

impl Serialize for Backdrop {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Backdrop {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let expected = "transparent, environment or a colour, in quotes";
        read::word(deserializer, expected, |text| {
            text.parse().map_err(|why| format!("the background '{text}' {why}"))
        })
    }
}

#[cfg(test)]
impl schemars::JsonSchema for Backdrop {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Backdrop".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "What stands behind a scene: transparent, environment, or the colour that the screen shows.",
            "type": "string",
            "pattern": "^(transparent|environment|#[0-9a-fA-F]{6})$"
        })
    }
}
