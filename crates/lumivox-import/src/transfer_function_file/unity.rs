//! UnityVolumeRendering's transfer functions.

use std::path::Path;

use lumivox_core::color::linear_from_srgb;
use lumivox_core::{ColorStop, Ease, OpacityKnot, TransferFunction};
use serde::Deserialize;

use super::{build, field};
use crate::error::ImportError;

/// UnityVolumeRendering's file.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Unity {
    #[serde(default)]
    version: u64,
    colour_points: Vec<UnityColor>,
    alpha_points: Vec<UnityAlpha>,
    min_data_value: Option<f64>,
    max_data_value: Option<f64>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct UnityColor {
    data_value: f64,
    colour_value: UnityRgb,
}

#[derive(Deserialize)]
struct UnityRgb {
    r: f64,
    g: f64,
    b: f64,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct UnityAlpha {
    data_value: f64,
    alpha_value: f64,
}

impl Unity {
    pub(super) fn transfer_function(
        self,
        path: &Path,
        value_range: [f64; 2],
    ) -> Result<TransferFunction, ImportError> {
        /// Later versions may change what values mean.
        const NEWEST: u64 = 2;
        if self.version > NEWEST {
            return Err(field(
                path,
                "version",
                format!("is {}, but UnityVolumeRendering's files are known up to {NEWEST}", self.version),
                "Update Lumivox",
            ));
        }
        let values = || {
            let alphas = self.alpha_points.iter().map(|p| p.data_value);
            self.colour_points.iter().map(|p| p.data_value).chain(alphas)
        };
        let own_range = match (self.min_data_value, self.max_data_value) {
            (Some(min), Some(max)) if max > min => Some([min, max]),
            _ => None,
        };
        // Programs that borrowed the format write HU under version 1 too.
        let relative =
            values().all(|v| (0.0..=1.0).contains(&v)) && (self.version <= 1 || own_range.is_some());
        let [min, max] = if relative { own_range.unwrap_or(value_range) } else { [0.0, 1.0] };
        let physical = |v: f64| if relative { min + v * (max - min) } else { v };
        let knots = self.alpha_points.iter().map(|p| OpacityKnot {
            value: physical(p.data_value),
            opacity: p.alpha_value.clamp(0.0, 1.0),
            ease: Ease::Linear,
        });
        let stops = self.colour_points.iter().map(|p| {
            let UnityRgb { r, g, b } = p.colour_value;
            let color = [r, g, b].map(|c| linear_from_srgb(c.clamp(0.0, 1.0)));
            ColorStop { value: physical(p.data_value), color }
        });
        build(path, knots.collect(), stops.collect())
    }
}
