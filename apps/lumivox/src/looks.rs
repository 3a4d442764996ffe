//! From the options to how each scan looks.

use std::path::PathBuf;

use lumivox_core::document::{Look, Surface};

use crate::{
    args::{LookName, LookNames, SceneArgs, Switch, Window},
    exit::Failure,
};

/// What the options say of one scan's look.
#[derive(Clone, Debug)]
pub struct LookOptions {
    name: Option<LookName>,
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

/// What the options say of each scan's look.
///
/// # Errors
/// Options that were given for another number of scans, and files that cannot be read.
pub fn looks(args: &SceneArgs, scans: usize) -> Result<Vec<LookOptions>, Failure> {
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
    let look = |(scan, name): (usize, Option<LookName>)| LookOptions {
        name,
        shift: shifts[scan],
        window_scale: scales[scan],
        window: windows[scan],
        density: densities[scan],
    };
    Ok(names.into_iter().enumerate().map(look).collect())
}

impl LookOptions {
    /// The same for a scan for which none was named.
    pub fn unnamed(&self) -> Self {
        Self { name: None, ..self.clone() }
    }

    /// The file that has the scan's transfer function, if it is one's.
    pub fn file(&self) -> Option<&PathBuf> {
        match &self.name {
            Some(LookName::File(path)) => Some(path),
            Some(LookName::Preset(_)) | None => None,
        }
    }

    /// Changes a look; a transfer function that is in a file is told by the scan's values, later.
    pub fn apply(&self, args: &SceneArgs, look: &mut Look) {
        match &self.name {
            Some(LookName::Preset(preset)) => {
                *look = Look { filter: look.filter, ..Look::of_preset(*preset) }
            }
            Some(LookName::File(_)) => *look = Look { preset: None, ..look.clone() },
            None => {}
        }
        if let Some(Window { level, width }) = self.window {
            *look = Look { window: Some([level, width]), shift: None, window_scale: None, ..look.clone() };
        } else if self.shift.is_some() || self.window_scale.is_some() {
            look.window = None;
            look.shift = self.shift.or(look.shift);
            look.window_scale = self.window_scale.or(look.window_scale);
        }
        look.density = self.density.or(look.density);
        look.albedo = args.albedo.or(look.albedo);
        look.anisotropy = args.anisotropy.or(look.anisotropy);
        look.bounces = args.bounces.or(look.bounces);
        look.filter = args.filter.map(Into::into).or(look.filter);
        look.surface = args.surface.map(|switch| Surface::Switched(switch == Switch::On)).or(look.surface);
    }
}
