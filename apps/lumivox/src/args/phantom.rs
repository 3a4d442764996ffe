//! The options of `lumivox phantom`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// `lumivox phantom`.
#[derive(Args, Debug)]
pub struct PhantomArgs {
    /// Which one
    pub kind: PhantomKind,
    /// The folder to write the series to; new, or empty but for an earlier run's files
    #[arg(short, long, value_name = "FOLDER")]
    pub out: PathBuf,
    /// Voxels along the longest side, 8 to 1024 [default: 256]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(8..=1024))]
    pub size: Option<u32>,
    /// Seed of noise and anatomical variation
    #[arg(long, value_name = "N", default_value = "1")]
    pub seed: u64,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// What only the torso has
    #[command(flatten)]
    pub torso: TorsoArgs,
}

/// Options of `lumivox phantom torso`.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Torso")]
pub struct TorsoArgs {
    /// Leave out the table and its mattress
    #[arg(long)]
    pub no_table: bool,
    /// Lay a blanket over the patient
    #[arg(long)]
    pub blanket: bool,
    /// Give the patient breasts
    #[arg(long)]
    pub breasts: bool,
    /// Where the arms are [default: raised]
    #[arg(long, value_name = "WHERE")]
    pub arms: Option<ArmsArg>,
    /// Metal in the patient
    #[arg(long, value_name = "WHAT")]
    pub metal: Option<MetalArg>,
    /// Edge length of the field of view in mm, 50 to 1000 [default: 400]
    #[arg(long, value_name = "MM", value_parser = field_of_view)]
    pub field_of_view: Option<f64>,
    /// Move the field of view along patient x (left), y (back) and z (head), in mm
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    pub shift: Option<[f64; 3]>,
    /// Turn the field of view around the patient's left-right axis, in degrees
    #[arg(long, value_name = "DEGREES", value_parser = tilt, allow_hyphen_values = true)]
    pub tilt: Option<f64>,
    /// Store padding of -1024 HU, not air, outside of the scanner's round field of view
    #[arg(long)]
    pub padding: bool,
}

/// Where a torso's arms are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ArmsArg {
    /// Above the head
    Raised,
    /// At the sides; a field of view of 520 mm holds them
    Sides,
}

/// Metal in a torso.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MetalArg {
    /// Wires around the sternum
    SternalWires,
    /// A pacemaker with two leads
    Pacemaker,
    /// Rods on screws along the lower spine
    Rod,
}

fn field_of_view(text: &str) -> Result<f64, String> {
    number_within(text, 50.0, 1000.0)
}

fn tilt(text: &str) -> Result<f64, String> {
    number_within(text, -90.0, 90.0)
}

fn number_within(text: &str, low: f64, high: f64) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if (low..=high).contains(&number) => Ok(number),
        _ => Err(format!("expected a number from {low} to {high}")),
    }
}

fn triple(text: &str) -> Result<[f64; 3], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    match (text.matches(',').count(), <[f64; 3]>::try_from(numbers)) {
        (2, Ok(mm)) if mm.iter().all(|n| n.abs() <= 1000.0) => Ok(mm),
        _ => Err("expected 3 numbers of at most 1000, as in 60,0,-20".into()),
    }
}

/// The phantoms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PhantomKind {
    /// A human head as a CT sees it
    Head,
    /// A human chest and upper belly as a CT sees them, on the table
    Torso,
    /// The torso as a PET sees it, an hour after FDG was given, in the same place; 128 voxels along a side by default
    TorsoPet,
    /// A human head as a T1-weighted MR sees it
    MrHead,
    /// Its brain alone
    MrBrain,
    /// Density falling from the centre of a cube to its corners
    Cube,
    /// A homogeneous slab
    Slab,
    /// A homogeneous sphere
    Sphere,
}
