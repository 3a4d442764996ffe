//! From the options to how each scan looks.

use std::path::PathBuf;

use lumivox_core::{Medium, Modality, Preset, SurfaceReflection, Volume, presets};

use crate::{
    args::{LookName, LookNames, RenderArgs, Switch, Window},
    exit::Failure,
    inputs,
    progress::Reporter,
};

/// How one scan is to look.
#[derive(Clone, Debug)]
pub struct Look {
    /// What it begins with.
    pub kind: LookKind,
    tuning: Tuning,
}

/// What a look begins with.
#[derive(Clone, Debug)]
pub enum LookKind {
    /// What suits the scan.
    Automatic,
    /// What was asked for.
    Preset(Preset),
    /// Opacity and colour of a file, the rest from what suits the scan.
    File(PathBuf),
}

/// What is altered of it.
#[derive(Clone, Copy, Debug, Default)]
struct Tuning {
    shift: Option<f64>,
    window_scale: Option<f64>,
    window: Option<Window>,
    density: Option<f64>,
}

/// The values of an option that was given once for all scans, once for each, or not at all.
fn per_scan<T: Clone>(option: &str, given: &[T], scans: usize) -> Result<Vec<Option<T>>, Failure> {
    match given {
        [] => Ok(vec![None; scans]),
        [one] => Ok(vec![Some(one.clone()); scans]),
        all if all.len() == scans => Ok(all.iter().cloned().map(Some).collect()),
        all => {
            let (n, are) = (all.len(), if option.contains(" and ") { "are together" } else { "is" });
            Err(Failure::usage(format!(
                "{option} {are} given {n} times for {scans} scans; give it once for all, or once for each"
            )))
        }
    }
}

/// One look per scan.
///
/// # Errors
/// Options that were given for another number of scans, and files that cannot be read.
pub fn looks(args: &RenderArgs, scans: usize) -> Result<Vec<Look>, Failure> {
    // Read again once the scan is known: here only to find faults early.
    for path in args.looks.files() {
        lumivox_import::load_transfer_function_2d(path, [0.0, 1.0])?;
    }
    let LookNames(names) = &args.looks;
    let names = per_scan(args.looks.options(), names, scans)?;
    let tuning = &args.tuning;
    let shifts = per_scan("--shift", &tuning.shift, scans)?;
    let scales = per_scan("--window-scale", &tuning.window_scale, scans)?;
    let windows = per_scan("--window", &tuning.window, scans)?;
    let densities = per_scan("--density", &tuning.density, scans)?;
    let look = |(scan, name): (usize, Option<LookName>)| Look {
        kind: match name {
            None => LookKind::Automatic,
            Some(LookName::Preset(preset)) => LookKind::Preset(preset),
            Some(LookName::File(path)) => LookKind::File(path),
        },
        tuning: Tuning {
            shift: shifts[scan],
            window_scale: scales[scan],
            window: windows[scan],
            density: densities[scan],
        },
    };
    Ok(names.into_iter().enumerate().map(look).collect())
}

impl Look {
    /// The same for a scan that none was asked for.
    pub fn automatic(&self) -> Self {
        Self { kind: LookKind::Automatic, ..self.clone() }
    }

    /// What the scan looks like, and what is worth saying of it.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn medium(&self, args: &RenderArgs, volume: &Volume, reporter: Reporter) -> Result<Medium, Failure> {
        let mut medium = match &self.kind {
            LookKind::Preset(preset) => {
                let name = preset.name();
                let is_ct =
                    volume.is_hounsfield() || volume.may_be_hounsfield() || volume.modality() == Modality::Ct;
                if name.starts_with("ct-") && !is_ct {
                    reporter.say(&format!(
                        "  note: {name} is a look of CT, placed here by where air and soft tissue seem to lie"
                    ));
                }
                preset.medium(volume)
            }
            LookKind::Automatic => {
                let preset = Preset::default_for(volume);
                reporter.say(&format!("  preset {} ({})", preset.name(), preset.description()));
                preset.medium(volume)
            }
            // The rest of the look comes from the preset that suits the scan.
            LookKind::File(path) => {
                let loaded = lumivox_import::load_transfer_function_2d(path, volume.value_range())?;
                let (transfer_function, gradients) = loaded;
                Medium { transfer_function, gradients, ..Preset::default_for(volume).medium(volume) }
            }
        };
        let Tuning { shift, window_scale, window, density } = self.tuning;
        if let Some(Window { level, width }) = window {
            medium = medium.in_window(level, width);
        } else if shift.is_some() || window_scale.is_some() {
            medium = medium.windowed(shift.unwrap_or(0.0), window_scale.unwrap_or(1.0));
        }
        let factor = presets::size_factor(volume);
        if factor != 1.0 && density.is_none() {
            let size = volume.size_mm().max_element();
            reporter.say(&format!(
                "  note: {} across is no body's size: extinction follows it, {} times that of a body; --density {} is a \
                 body's",
                inputs::lengths([size], 1),
                inputs::number(factor),
                inputs::number(medium.density_scale / factor),
            ));
        }
        medium.density_scale = density.unwrap_or(medium.density_scale);
        medium.albedo = args.albedo.unwrap_or(medium.albedo);
        medium.anisotropy = args.anisotropy.unwrap_or(medium.anisotropy);
        medium.max_bounces = args.bounces.unwrap_or(medium.max_bounces);
        medium.filter = args.filter.into();
        match args.surface {
            Some(Switch::Off) => medium.surface = SurfaceReflection::OFF,
            Some(Switch::On) if medium.surface.strength == 0.0 => medium.surface.strength = 1.0,
            Some(Switch::On) | None => {}
        }
        Ok(medium.sanitized())
    }
}
