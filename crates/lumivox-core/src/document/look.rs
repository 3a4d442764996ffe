//! How a scan looks: a preset by its name, what is altered of it, or all of it.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{MapAccess, Visitor, value::MapAccessDeserializer},
};

use super::{numbers::Faults, ranges};
use crate::{
    medium::{ExtinctionSpace, Filter, GradientFunction, MOST_GRADIENTS, Medium, SurfaceReflection},
    presets::Preset,
    transfer_function::TransferFunction,
    volume::Volume,
};

/// How a scan looks. What is not said is as the preset has it, and without a preset as the one has it that suits the scan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Look {
    /// What it begins with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<Preset>,
    /// Opacity and colour of values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transfer_function: Option<TransferFunction>,
    /// Opacity and colour where values change quickly; goes with a transfer function.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(test, schemars(length(max = MOST_GRADIENTS)))]
    pub gradients: Vec<GradientFunction>,
    /// Moves opacity and colour to higher values, in the scan's unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::SHIFT.said()))]
    pub shift: Option<f64>,
    /// Widens opacity and colour about their centre.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::WINDOW_SCALE.said()))]
    pub window_scale: Option<f64>,
    /// Stretches opacity and colour over so many units around a level: level, width.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::schema::window))]
    pub window: Option<[f64; 2]>,
    /// Factor on the extinction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::DENSITY.said()))]
    pub density: Option<f64>,
    /// Fraction of light that survives a scattering.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::FRACTION.said()))]
    pub albedo: Option<f64>,
    /// Henyey-Greenstein mean cosine g.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::ANISOTROPY.said()))]
    pub anisotropy: Option<f64>,
    /// Most scatterings along a path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::BOUNCES.said()))]
    pub bounces: Option<u32>,
    /// How values between voxels are found; smooth where nothing is said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filter: Option<Filter>,
    /// Reflection where values change quickly.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<Surface>,
    /// In which space a millimetre of extinction is measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extinction_space: Option<ExtinctionSpace>,
}

/// Reflection: on or off, or what it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Surface {
    /// Off, or as the preset has it; of full strength where that has none.
    Switched(bool),
    /// What of it is said.
    Is(Reflection),
}

/// One after the other, so that what is wrong in it is told at its own place.
impl<'de> Deserialize<'de> for Surface {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;

        impl<'de> Visitor<'de> for Read {
            type Value = Surface;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                let words =
                    "true, false, or a block of strength, gradient_per_mm, roughness, specular and metallic";
                formatter.write_str(words)
            }

            fn visit_bool<E>(self, is_on: bool) -> Result<Surface, E> {
                Ok(Surface::Switched(is_on))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Surface, A::Error> {
                Reflection::deserialize(MapAccessDeserializer::new(map)).map(Surface::Is)
            }
        }

        deserializer.deserialize_any(Read)
    }
}

/// What is said of a [`SurfaceReflection`]; whatever is not is as the look has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Reflection {
    /// Largest probability of a surface event, 0 (off) to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::FRACTION.said()))]
    pub strength: Option<f64>,
    /// Gradient, in value units per mm, of a surface that reflects 63% of that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::GRADIENT.said()))]
    pub gradient_per_mm: Option<f64>,
    /// Width of the specular lobe, 0 (narrow) to 1 (all around).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::FRACTION.said()))]
    pub roughness: Option<f64>,
    /// Reflectance seen head-on, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::FRACTION.said()))]
    pub specular: Option<f64>,
    /// How much of the medium's colour the specular lobe has, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::FRACTION.said()))]
    pub metallic: Option<f64>,
}

impl Reflection {
    /// All of a reflection.
    pub fn of(surface: SurfaceReflection) -> Self {
        let SurfaceReflection { strength, gradient_per_mm, roughness, specular, metallic } = surface;
        let [strength, gradient_per_mm, roughness, specular, metallic] =
            [strength, gradient_per_mm, roughness, specular, metallic].map(Some);
        Self { strength, gradient_per_mm, roughness, specular, metallic }
    }

    /// The reflection, where what is not said is another's.
    pub fn over(self, other: SurfaceReflection) -> SurfaceReflection {
        SurfaceReflection {
            strength: self.strength.unwrap_or(other.strength),
            gradient_per_mm: self.gradient_per_mm.unwrap_or(other.gradient_per_mm),
            roughness: self.roughness.unwrap_or(other.roughness),
            specular: self.specular.unwrap_or(other.specular),
            metallic: self.metallic.unwrap_or(other.metallic),
        }
    }

    /// Whether nothing of another is left.
    fn is_whole(&self) -> bool {
        *self == Self::of(self.over(SurfaceReflection::OFF))
    }
}

impl Look {
    /// A preset's look.
    pub fn of_preset(preset: Preset) -> Self {
        Self { preset: Some(preset), ..Self::default() }
    }

    /// A medium, written out: nothing of it depends on the scan.
    pub fn of_medium(medium: &Medium) -> Self {
        Self {
            preset: None,
            transfer_function: Some(medium.transfer_function.clone()),
            gradients: medium.gradients.clone(),
            shift: None,
            window_scale: None,
            window: None,
            density: Some(medium.density_scale),
            albedo: Some(medium.albedo),
            anisotropy: Some(medium.anisotropy),
            bounces: Some(medium.max_bounces),
            filter: Some(medium.filter),
            surface: Some(Surface::Is(Reflection::of(medium.surface))),
            extinction_space: Some(medium.extinction_space),
        }
    }

    /// What it begins with for a scan.
    pub fn base(&self, volume: &Volume) -> Preset {
        self.preset.unwrap_or_else(|| Preset::default_for(volume))
    }

    /// Whether nothing of a preset is left.
    fn is_written_out(&self) -> bool {
        self.transfer_function.is_some()
            && [self.density, self.albedo, self.anisotropy].iter().all(Option::is_some)
            && self.bounces.is_some()
            && match self.surface {
                Some(Surface::Is(reflection)) => reflection.is_whole(),
                Some(Surface::Switched(on)) => !on,
                None => false,
            }
    }

    /// The look, placed for a scan.
    pub fn medium(&self, volume: &Volume) -> Medium {
        // Which preset suits a scan is found by all its voxels.
        let mut medium = match &self.transfer_function {
            Some(function) if self.is_written_out() => Medium::new(function.clone()),
            _ => self.base(volume).medium(volume),
        };
        if let Some(function) = &self.transfer_function {
            medium.transfer_function = function.clone();
            medium.gradients.clone_from(&self.gradients);
        }
        if let Some([level, width]) = self.window {
            medium = medium.in_window(level, width);
        } else if self.shift.is_some() || self.window_scale.is_some() {
            medium = medium.windowed(self.shift.unwrap_or(0.0), self.window_scale.unwrap_or(1.0));
        }
        medium.density_scale = self.density.unwrap_or(medium.density_scale);
        medium.albedo = self.albedo.unwrap_or(medium.albedo);
        medium.anisotropy = self.anisotropy.unwrap_or(medium.anisotropy);
        medium.max_bounces = self.bounces.unwrap_or(medium.max_bounces);
        medium.filter = self.filter.unwrap_or(Filter::Smooth);
        match self.surface {
            Some(Surface::Is(reflection)) => medium.surface = reflection.over(medium.surface),
            Some(Surface::Switched(false)) => medium.surface = SurfaceReflection::OFF,
            Some(Surface::Switched(true)) if medium.surface.strength == 0.0 => medium.surface.strength = 1.0,
            Some(Surface::Switched(true)) | None => {}
        }
        medium.extinction_space = self.extinction_space.unwrap_or(medium.extinction_space);
        medium.sanitized()
    }

    pub(super) fn check(&self, faults: &mut Faults) {
        faults.number("shift", self.shift, ranges::SHIFT);
        faults.number("window_scale", self.window_scale, ranges::WINDOW_SCALE);
        if let Some([level, width]) = self.window {
            let is_window = ranges::LEVEL.holds(level) && ranges::WIDTH.holds(width);
            faults.unless(is_window, "window", || "a window is a level and a width above 0".into());
        }
        faults.unless(
            self.window.is_none() || (self.shift, self.window_scale) == (None, None),
            "window",
            || "a window says all that shift and window_scale do: leave those out".into(),
        );
        faults.unless(self.gradients.is_empty() || self.transfer_function.is_some(), "gradients", || {
            "gradients go with a transfer_function".into()
        });
        faults.unless(self.gradients.len() <= MOST_GRADIENTS, "gradients", || {
            format!(
                "there are {} gradients, of which {MOST_GRADIENTS} can be told apart",
                self.gradients.len()
            )
        });
        for (index, row) in self.gradients.iter().enumerate() {
            faults.within(&["gradients".into(), index.into()], |faults| {
                faults.number("per_mm", Some(row.per_mm), ranges::PER_MM);
            });
        }
        faults.number("density", self.density, ranges::DENSITY);
        faults.number("albedo", self.albedo, ranges::FRACTION);
        faults.number("anisotropy", self.anisotropy, ranges::ANISOTROPY);
        faults.number("bounces", self.bounces.map(f64::from), ranges::BOUNCES);
        if let Some(Surface::Is(reflection)) = self.surface {
            surface(faults, reflection);
        }
    }
}

/// Reflection that is within its ranges.
pub(super) fn surface(faults: &mut Faults, reflection: Reflection) {
    faults.within(&["surface".into()], |faults| {
        faults.number("strength", reflection.strength, ranges::FRACTION);
        faults.number("gradient_per_mm", reflection.gradient_per_mm, ranges::GRADIENT);
        faults.number("roughness", reflection.roughness, ranges::FRACTION);
        faults.number("specular", reflection.specular, ranges::FRACTION);
        faults.number("metallic", reflection.metallic, ranges::FRACTION);
    });
}
