//! What a script wants of a scan's files: which of them, and what of what they show.

use godot::prelude::*;
use lumivox_core::{CancelToken, Cancelled, Progress};
use lumivox_import::{
    ImportOptions, Imported, RawDescription, UnknownAxes, UnknownLayout, modality_of_word, parse_spacing,
};
use lumivox_segmentation::{Surroundings, patient_alone};

/// Options of an import.
#[derive(Clone, Default)]
pub struct LoadOptions {
    /// What the files' reader is to know.
    pub import: ImportOptions,
    /// Whether what lies around the patient stays.
    pub keep_everything: bool,
}

/// What a script gets of a scan's files.
pub struct Loaded {
    /// The scan: the patient alone, unless everything was asked for.
    pub imported: Imported,
    /// What was taken out of it.
    pub surroundings: Option<Surroundings>,
}

impl LoadOptions {
    /// The options of a dictionary from a script; empty texts are as if they were not there.
    ///
    /// # Errors
    /// A sentence about the one that cannot be understood.
    pub fn parse(dictionary: &VarDictionary) -> Result<Self, String> {
        let mut all = Self::default();
        let options = &mut all.import;
        for (key, value) in dictionary.iter_shared() {
            let key = key.stringify().to_string();
            let text = value.stringify().to_string();
            let flag = || {
                let wrong = |_| format!("The import option '{key}' is true or false, and not '{text}'.");
                text.parse().map_err(wrong)
            };
            let number = || text.parse::<f64>().ok().filter(|number| number.is_finite());
            let no_number =
                || format!("The import option '{key}' is a number, the slope not 0, and not '{text}'.");
            match key.as_str() {
                _ if text.is_empty() => {}
                "series" => options.series = Some(text),
                "phase" => {
                    let phase = text.parse().ok().filter(|phase| *phase > 0);
                    let wrong = || format!("The import option 'phase' counts from 1, and is not '{text}'.");
                    options.phase = Some(phase.ok_or_else(wrong)?);
                }
                "allow_outside_data" => options.allow_outside_data = flag()?,
                "keep_everything" => all.keep_everything = flag()?,
                "spacing" => {
                    let wrong = |error| format!("The import option 'spacing' is '{text}': {error}.");
                    options.spacing_mm = Some(parse_spacing(&text).map_err(wrong)?);
                }
                "axes" => {
                    let wrong =
                        |error: UnknownAxes| format!("The import option 'axes' is '{text}': {error}.");
                    options.axes = Some(text.parse().map_err(wrong)?);
                }
                "layout" => {
                    let wrong =
                        |error: UnknownLayout| format!("The import option 'layout' is '{text}': {error}.");
                    options.layout = Some(text.parse().map_err(wrong)?);
                }
                "slope" => {
                    options.slope = Some(number().filter(|slope| slope.is_normal()).ok_or_else(no_number)?)
                }
                "intercept" => options.intercept = Some(number().ok_or_else(no_number)?),
                "modality" => {
                    let wrong =
                        || format!("The import option 'modality' is CT, MR, PET or other, and not '{text}'.");
                    options.modality = Some(modality_of_word(&text).ok_or_else(wrong)?);
                }
                "unit" => options.unit = Some(text),
                "raw" => {
                    options.raw = Some(RawDescription::parse(&text).map_err(|error| error.to_string())?);
                }
                other => {
                    return Err(format!(
                        "There is no import option '{other}'. There are 'series', 'phase', 'raw', 'slope', 'intercept', \
                         'modality', 'unit', 'spacing', 'axes', 'layout', 'allow_outside_data' and 'keep_everything'."
                    ));
                }
            }
        }
        Ok(all)
    }

    /// What of a scan is kept: the patient alone, unless everything was asked for.
    ///
    /// # Errors
    /// [`Cancelled`] when `cancel` was used.
    pub fn keep(
        &self,
        mut imported: Imported,
        progress: Progress<'_>,
        cancel: &CancelToken,
    ) -> Result<Loaded, Cancelled> {
        if self.keep_everything {
            return Ok(Loaded { imported, surroundings: None });
        }
        let alone = patient_alone(imported.volume, progress, cancel)?;
        if let Some(note) = alone.note() {
            let more = if alone.changed > 0 { " ('keep_everything' shows it)" } else { "" };
            imported.report.notes.push(format!("{note}{more}"));
        }
        imported.volume = alone.volume;
        Ok(Loaded { imported, surroundings: alone.surroundings })
    }
}
