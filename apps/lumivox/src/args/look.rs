//! The options of looks: which one each scan has, and what of it is altered. Each is given once for all scans, or once for
//! each, in their order.

use std::path::PathBuf;

use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, value_parser};
use lumivox_core::Preset;

use super::values::{Window, number};

const HEADING: &str = "Look";

/// A look that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum LookName {
    /// A named one.
    Preset(Preset),
    /// One of a file.
    File(PathBuf),
}

/// The looks in the order in which they were given, whatever their kind: one scan may have a preset and the next a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LookNames(pub Vec<LookName>);

impl LookNames {
    const PRESET: &str = "preset";
    const FILE: &str = "transfer_function";

    /// The files among them.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.0.iter().filter_map(|look| match look {
            LookName::Preset(_) => None,
            LookName::File(path) => Some(path),
        })
    }

    /// The options that gave them, for people.
    pub fn options(&self) -> &'static str {
        match (self.files().count(), self.0.len()) {
            (0, _) => "--preset",
            (files, all) if files == all => "--transfer-function",
            _ => "--preset and --transfer-function",
        }
    }
}

impl FromArgMatches for LookNames {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let presets = matches.get_many::<Preset>(Self::PRESET).into_iter().flatten();
        let files = matches.get_many::<PathBuf>(Self::FILE).into_iter().flatten();
        let places = |id| matches.indices_of(id).into_iter().flatten();
        let presets = places(Self::PRESET).zip(presets.map(|preset| LookName::Preset(*preset)));
        let files = places(Self::FILE).zip(files.map(|path| LookName::File(path.clone())));
        let mut looks: Vec<(usize, LookName)> = presets.chain(files).collect();
        looks.sort_by_key(|(place, _)| *place);
        Ok(Self(looks.into_iter().map(|(_, look)| look).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for LookNames {
    fn augment_args(command: Command) -> Command {
        let option = |id: &'static str, long: &'static str, value: &'static str| {
            Arg::new(id).long(long).value_name(value).help_heading(HEADING).action(ArgAction::Append)
        };
        command
            .arg(option(Self::PRESET, "preset", "NAME").value_parser(Preset::from_name).help(
                "Named look, one for all scans or one for each [default: what suits the scan; see 'lumivox presets']",
            ))
            .arg(option(Self::FILE, "transfer-function", "FILE").value_parser(value_parser!(PathBuf)).help(
                "File with opacity and colour by value, one for all scans or one for each, beside presets of others; \
                 UnityVolumeRendering's .tf too",
            ))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// What is altered of looks.
#[derive(Args, Clone, Debug, Default)]
pub struct TuningArgs {
    /// Move opacity and colour to higher values, in the scan's unit (HU for CT): a window's level; one for all scans or
    /// one for each, as of the next three
    #[arg(long, value_name = "VALUE", help_heading = HEADING, allow_negative_numbers = true)]
    #[arg(value_parser = number(-1e9, 1e9))]
    pub shift: Vec<f64>,
    /// Widen opacity and colour about their centre, 0.01 to 100: a window's width
    #[arg(long, value_name = "FACTOR", help_heading = HEADING, value_parser = number(0.01, 100.0))]
    pub window_scale: Vec<f64>,
    /// Stretch opacity and colour over so many of the scan's units (HU for CT) around a level: 40,400
    #[arg(long, value_name = "LEVEL,WIDTH", help_heading = HEADING, allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["shift", "window_scale"])]
    pub window: Vec<Window>,
    /// Factor on the extinction, per millimetre however large the scan is [default: the preset's]
    #[arg(long, value_name = "FACTOR", help_heading = HEADING, value_parser = number(0.0, 1e9))]
    pub density: Vec<f64>,
}
