//! `lumivox phantom`: a procedural scan, written as the files a scanner would have sent.

use std::path::Path;

use lumivox_core::Volume;
use lumivox_phantom::{AnatomyOptions, Arms, Metal, MrPart, SeriesDescription, TorsoOptions, WriteError};

use crate::{
    args::{ArmsArg, MetalArg, PhantomArgs, PhantomKind, TorsoArgs},
    exit::{self, Exit, Failure},
    inputs, output,
    progress::Reporter,
};

/// Voxels along the longest side unless asked otherwise.
const DEFAULT_SIZE: u32 = 256;

/// The same of a PET, which is coarser.
const DEFAULT_PET_SIZE: u32 = 128;

/// Hounsfield units of the homogeneous bodies: bone, which every CT preset shows.
const BODY_HU: f64 = 1000.0;

/// Voxels of air that the phantoms put around a homogeneous body, on both sides together.
const AIR_VOXELS: u32 = 6;

/// Makes the phantom and writes it.
pub fn run(args: &PhantomArgs) -> Result<(), Failure> {
    let is_torso = matches!(args.kind, PhantomKind::Torso | PhantomKind::TorsoPet);
    if !is_torso && args.torso != TorsoArgs::default() {
        return Err(Failure::usage(
            "Of the phantoms, only the torso has these options; see 'lumivox phantom --help'.",
        ));
    }
    let reporter = Reporter::new(args.quiet);
    let cancel = exit::cancel_on_ctrl_c()?;
    let default = if args.kind == PhantomKind::TorsoPet { DEFAULT_PET_SIZE } else { DEFAULT_SIZE };
    let size = args.size.unwrap_or(default);
    let inside = f64::from(size.saturating_sub(AIR_VOXELS).max(1));
    let volume: Volume = match args.kind {
        PhantomKind::Head => {
            let options =
                AnatomyOptions { size: size as usize, seed: args.seed, ..AnatomyOptions::default() };
            reporter.stages(|progress| lumivox_phantom::anatomy(options, progress, &cancel))?
        }
        PhantomKind::MrHead | PhantomKind::MrBrain => {
            let options =
                AnatomyOptions { size: size as usize, seed: args.seed, ..AnatomyOptions::default() };
            let part = if args.kind == PhantomKind::MrHead { MrPart::Head } else { MrPart::Brain };
            reporter.stages(|progress| lumivox_phantom::anatomy_mr(options, part, progress, &cancel))?
        }
        PhantomKind::Torso => {
            let options = torso_options(args, size as usize);
            reporter.stages(|progress| lumivox_phantom::torso(options, progress, &cancel))?
        }
        PhantomKind::TorsoPet => {
            let options = torso_options(args, size as usize);
            reporter.stages(|progress| lumivox_phantom::torso_pet(options, progress, &cancel))?
        }
        PhantomKind::Cube => lumivox_phantom::cube(size as usize),
        PhantomKind::Slab => lumivox_phantom::slab(BODY_HU, inside / 10.0, 1.0),
        PhantomKind::Sphere => lumivox_phantom::sphere(BODY_HU, inside / 2.0 - 0.5, 1.0),
    };
    cancel.check()?;
    reporter.say(&inputs::describe(&volume));

    let description = SeriesDescription {
        series: description(args.kind).into(),
        body_part: body_part(args.kind).into(),
        // Another series of the study that the torso's CT is of, in its frame of reference.
        series_number: if args.kind == PhantomKind::TorsoPet { 2 } else { 1 },
        seed: args.seed,
        ..SeriesDescription::default()
    };
    let shown = args.out.display();
    let written = reporter.stages(|progress| {
        lumivox_phantom::write_dicom_series(&volume, &args.out, &description, progress, &cancel)
    });
    let files = written.map_err(|error| match error {
        WriteError::Cancelled(_) => {
            Failure::new(Exit::Interrupted, format!("Stopped; the series in {shown} is not complete."))
        }
        error @ (WriteError::Io { .. } | WriteError::Encode { .. }) if has_files(&args.out) => {
            Failure::other(format!("{error}\nThe series in {shown} is not complete."))
        }
        error => Failure::other(error.to_string()),
    })?;
    if !args.quiet {
        output::print(&format!(
            "Wrote {files} DICOM {} to {shown}\n",
            if files == 1 { "file" } else { "files" }
        ))?;
    }
    Ok(())
}

fn torso_options(args: &PhantomArgs, size: usize) -> TorsoOptions {
    let default = TorsoOptions::default();
    let torso = &args.torso;
    TorsoOptions {
        size,
        seed: args.seed,
        field_of_view_mm: torso.field_of_view.unwrap_or(default.field_of_view_mm),
        shift_mm: torso.shift.unwrap_or(default.shift_mm),
        tilt_degrees: torso.tilt.unwrap_or(default.tilt_degrees),
        padding: torso.padding,
        arms: match torso.arms {
            None => default.arms,
            Some(ArmsArg::Raised) => Arms::Raised,
            Some(ArmsArg::Sides) => Arms::AtSides,
        },
        breasts: torso.breasts,
        table: !torso.no_table,
        blanket: torso.blanket,
        metal: match torso.metal {
            None => Metal::None,
            Some(MetalArg::SternalWires) => Metal::SternalWires,
            Some(MetalArg::Pacemaker) => Metal::Pacemaker,
            Some(MetalArg::Rod) => Metal::Rod,
        },
        ..default
    }
}

fn has_files(folder: &Path) -> bool {
    std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some())
}

fn description(kind: PhantomKind) -> &'static str {
    match kind {
        PhantomKind::Head => "Head and neck, contrast",
        PhantomKind::Torso => "Chest and upper abdomen, contrast",
        PhantomKind::TorsoPet => "Chest and upper abdomen, FDG PET",
        PhantomKind::MrHead => "Head and neck, T1",
        PhantomKind::MrBrain => "Brain, skull stripped, T1",
        PhantomKind::Cube => "Test cube",
        PhantomKind::Slab => "Homogeneous slab",
        PhantomKind::Sphere => "Homogeneous sphere",
    }
}

fn body_part(kind: PhantomKind) -> &'static str {
    match kind {
        PhantomKind::Torso | PhantomKind::TorsoPet => "CHESTABDOMEN",
        PhantomKind::MrBrain => "BRAIN",
        _ => "HEADNECK",
    }
}
