//! The options of looks: which one each scan has, and what of it is altered. Each is given once for all scans, or once for
//! each, in their order.

use std::{ffi::OsStr, path::PathBuf};

use clap::{
    Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches,
    builder::{PossibleValue, TypedValueParser},
    value_parser,
};
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
            .arg(option(Self::PRESET, "preset", "NAME").value_parser(PresetParser).hide_possible_values(true).help(
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

/// Reads a preset's name, and knows all of them, for shells to complete.
#[derive(Clone)]
struct PresetParser;

impl TypedValueParser for PresetParser {
    type Value = Preset;

    fn parse_ref(
        &self,
        command: &Command,
        option: Option<&Arg>,
        value: &OsStr,
    ) -> Result<Preset, clap::Error> {
        (|name: &str| Preset::from_name(name)).parse_ref(command, option, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let value = |preset: Preset| PossibleValue::new(preset.name()).help(preset.description());
        Some(Box::new(Preset::ALL.into_iter().map(value)))
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

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::{Cli, Command, RenderArgs};

    fn render(options: &[&str]) -> Result<Box<RenderArgs>, clap::Error> {
        let all = [&["lumivox", "render", "a.nii", "b.nii", "-o", "c.png"][..], options].concat();
        Cli::try_parse_from(all).map(|cli| match cli.command {
            Command::Render(args) => args,
            other => panic!("{other:?}"),
        })
    }

    #[test]
    fn looks_keep_the_order_in_which_they_were_given() {
        let bone = LookName::Preset(Preset::CtBone);
        let file = LookName::File("a.tf".into());
        let names = |options: &[&str]| render(options).unwrap().scene.looks;
        let mixed = names(&["--transfer-function", "a.tf", "--preset", "ct-bone"]);
        assert_eq!(mixed.0, [file.clone(), bone.clone()]);
        assert_eq!(mixed.options(), "--preset and --transfer-function");
        let other = names(&["--preset", "ct-bone", "--transfer-function", "a.tf"]);
        assert_eq!(
            (other.0.clone(), other.options()),
            (vec![bone.clone(), file], "--preset and --transfer-function")
        );
        let twice = names(&["--preset", "ct-bone", "--preset", "CT_bone"]);
        assert_eq!((twice.0.len(), twice.options()), (2, "--preset"));
        assert!(names(&[]).0.is_empty());
        let error = render(&["--preset", "ct-bome"]).unwrap_err().to_string();
        assert!(error.contains("did you mean 'ct-bone'"), "{error}");
    }

    #[test]
    fn what_is_altered_may_differ_from_scan_to_scan() {
        let tuning = render(&["--shift", "-20", "--shift", "30", "--density", "2"]).unwrap().scene.tuning;
        assert_eq!((tuning.shift, tuning.density), (vec![-20.0, 30.0], vec![2.0]));
        let tuning = render(&["--window", "-600,1500", "--window", "40,400"]).unwrap().scene.tuning;
        assert_eq!(tuning.window[0], Window { level: -600.0, width: 1500.0 });
        assert!(
            render(&["--window", "40,400", "--shift", "5"]).is_err(),
            "a window says all that a shift does"
        );
    }
}
