//! The command line: what can be asked for, and what makes no sense.

use std::{path::PathBuf, str::FromStr, time::Duration};

use clap::{Args, Parser, Subcommand, ValueEnum};
use lumivox_core::{Filter, Light, LightKind, Preset, glam::DVec3};
use lumivox_import::RawDescription;
use lumivox_renderer::ToneMap;

use crate::classification::{ClipOption, LabelOption};

const EXIT_CODES: &str = "\
Exit codes:
    0  done
    1  failed: the output cannot be written, for example
    2  wrong usage
    3  bad input: missing, damaged, or not a scan
    4  no usable GPU, or it was lost
  130  stopped by Ctrl-C or SIGTERM; what was rendered is kept";

const INFO_EXAMPLES: &str = "\
Examples:
  lumivox info FOLDER                 geometry, values, series, a preset that suits it
  lumivox info head.nii.gz --json     the same for programs

";

const IMPORT_EXAMPLES: &str = "\
Examples:
  lumivox import FOLDER                      what can be loaded from it, and why other files cannot
  lumivox import study.zip --json            the same for programs
  lumivox import FOLDER --thumbnails DIR     with a picture of each series

";

const PRESETS_EXAMPLES: &str = "\
Example:
  lumivox render FOLDER --preset ct-bone -o bone.png";

const EXAMPLES: &str = "\
Examples:
  lumivox phantom head --out phantom          make a scan to try things on
  lumivox render phantom -o head.png          a DICOM folder to a picture
  lumivox import FOLDER                       which series are in a folder, and what was left out
  lumivox info head.nii.gz                    what is in a file, and a preset that suits it
  lumivox doctor                              which GPUs are seen, and what is missing

'lumivox render --help' has all options of rendering.

";

const RENDER_EXAMPLES: &str = "\
Examples:
  lumivox render FOLDER -o out.png
  lumivox render FOLDER --preset ct-bone --azimuth 35 --elevation 10 -o bone.png
  lumivox render ct.nii.gz --transfer-function skin.tf --environment sky.hdr -o skin.png
  lumivox render FOLDER --keep everything -o table.png
  lumivox render FOLDER --peel 15 -o inside.png
  lumivox render FOLDER --clip-shape plane:0,0,0,-1,0,-1 -o open.png
  lumivox render FOLDER --labels liver.seg.nrrd --label '*=opacity:0.1' --label liver=show,color,opacity:1 -o liver.png
  lumivox render FOLDER --size 1920x1080 --time 60 --background transparent -o hd.png
  lumivox render ct.nrrd pet.nrrd --preset ct-bone --preset mr-head -o both.png
  lumivox render head.raw --raw 256x256x108:i16le:spacing=1,1,1.5 -o raw.png

";

/// Turns CT and MR scans into photorealistic images by tracing light through them.
#[derive(Debug, Parser)]
#[command(name = "lumivox", version, after_help = [EXAMPLES, EXIT_CODES].concat())]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render scans to a PNG
    #[command(after_help = [RENDER_EXAMPLES, EXIT_CODES].concat(), allow_negative_numbers = true)]
    Render(Box<RenderArgs>),
    /// Say what a scan holds: geometry, values, a suggested preset; never the patient's name
    #[command(after_help = [INFO_EXAMPLES, EXIT_CODES].concat())]
    Info(InfoArgs),
    /// List what can be loaded from a folder, archive or file, without loading it, and why other files cannot
    #[command(after_help = [IMPORT_EXAMPLES, EXIT_CODES].concat())]
    Import(ImportArgs),
    /// Make a procedural scan, written as a DICOM series
    #[command(after_help = EXIT_CODES)]
    Phantom(PhantomArgs),
    /// List the presets
    #[command(after_help = PRESETS_EXAMPLES)]
    Presets,
    /// Say which GPUs and drivers are seen, what is missing and how to install it
    #[command(after_help = EXIT_CODES)]
    Doctor,
}

/// Which scans, shared by the commands that read any.
#[derive(Args, Debug)]
pub struct InputArgs {
    /// Scans: a DICOM folder or its files, .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd, .raw, or a .zip of DICOM files
    #[arg(required = true, value_name = "SCAN")]
    pub inputs: Vec<PathBuf>,
    /// DICOM series to take: its place in the list of 'lumivox info', its UID, or a number that no other has
    /// [default: the first of the list]
    #[arg(long, value_name = "SERIES")]
    pub series: Option<String>,
    /// Phase of a series with several, counted from 1 [default: the first that is whole]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub phase: Option<u32>,
    /// Leave missing slices empty [default: filled in from both neighbours' values]
    #[arg(long)]
    pub leave_gaps: bool,
    /// Fill in slices that are there but damaged, as missing ones are [default: left empty, and said]
    #[arg(long, conflicts_with = "leave_gaps")]
    pub fill_damaged: bool,
    /// Let a header (.mhd, .nhdr) name data files anywhere [default: only beside it or below]
    #[arg(long)]
    pub allow_outside_data: bool,
    /// Layout of a RAW scan: size, sample type, then any of spacing (mm), axes (where x, y and z grow), header
    /// (bytes), slope, intercept, modality: 256x256x108:i16le:spacing=0.9,0.9,1.5:axes=LAS
    /// [default: from a file beside it, or its name]
    #[arg(long, value_name = "LAYOUT")]
    pub raw: Option<RawDescription>,
}

/// `lumivox render`.
#[derive(Args, Debug)]
pub struct RenderArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub input: InputArgs,
    /// The PNG to write; an existing file is replaced
    #[arg(short, long, value_name = "FILE.png")]
    pub output: PathBuf,

    /// Named look, one for all scans or one for each [default: what suits the scan; see 'lumivox presets']
    #[arg(long, value_name = "NAME", help_heading = "Look", value_parser = Preset::from_name)]
    pub preset: Vec<Preset>,
    /// File with opacity and colour by value, one for all scans or one for each; UnityVolumeRendering's .tf too
    #[arg(long, value_name = "FILE", help_heading = "Look", conflicts_with = "preset")]
    pub transfer_function: Vec<PathBuf>,
    /// Factor on the extinction [default: the preset's]
    #[arg(long, value_name = "FACTOR", help_heading = "Look", value_parser = number(0.0, 1e3))]
    pub density: Option<f64>,
    /// Fraction of light that survives a scattering, 0 to 1 [default: the preset's]
    #[arg(long, value_name = "FRACTION", help_heading = "Look", value_parser = number(0.0, 1.0))]
    pub albedo: Option<f64>,
    /// Henyey-Greenstein mean cosine g, -0.99 to 0.99; positive scatters forward [default: the preset's]
    #[arg(long, value_name = "G", help_heading = "Look", value_parser = number(-0.99, 0.99))]
    pub anisotropy: Option<f64>,
    /// Most scatterings along a path, 1 to 1000 [default: the preset's]
    #[arg(long, value_name = "N", help_heading = "Look", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub bounces: Option<u32>,
    /// Reflection where the value changes quickly: crisp bone and skin [default: the preset's]
    #[arg(long, help_heading = "Look")]
    pub surface: Option<Switch>,
    /// How values between voxels are found: smooth averages neighbours first, so that surfaces have hardly any
    /// terraces; trilinear is a little sharper, tricubic about as sharp, and takes several times as long
    #[arg(long, help_heading = "Look", default_value = "smooth")]
    pub filter: FilterName,
    /// What of a CT to show: the patient alone, or the table, clothes and cables too, as it was scanned
    #[arg(long, value_name = "WHAT", help_heading = "Look", default_value = "patient")]
    pub keep: Keep,
    /// Millimetres below the skin that are taken off a CT, up to 63 [default: the preset's]
    #[arg(long, value_name = "MM", help_heading = "Look", value_parser = number(0.0, 63.0))]
    pub peel: Option<f64>,
    /// Part to keep, as fractions along the voxel axes: lowx,lowy,lowz,highx,highy,highz
    #[arg(long, value_name = "BOX", help_heading = "Look")]
    pub clip: Option<Clip>,
    /// Cut the volumes open: what the shape keeps is seen, or with a '!' before it what it does not. plane:X,Y,Z,NX,NY,NZ
    /// keeps the side to which its normal N points; box: two corners; sphere: centre and radius; in mm, as --eye.
    /// Once for each
    #[arg(long, value_name = "[!]SHAPE:NUMBERS", help_heading = "Look", allow_hyphen_values = true)]
    pub clip_shape: Vec<ClipOption>,
    /// Labels of the scan's voxels: a DICOM SEG, NIfTI, NRRD or MetaImage file, or 'found' for what is found in a CT by
    /// itself
    #[arg(long, value_name = "FILE|found", help_heading = "Look")]
    pub labels: Option<PathBuf>,
    /// How a label looks, by its name, its number, or * for all; in turn. Words, with commas between them: hide, show,
    /// color (its own), color:#rrggbb, opacity:F, density:F, preset:NAME, matte, uncut (by --clip-shape)
    #[arg(long, value_name = "NAME=WORDS", help_heading = "Look", requires = "labels")]
    pub label: Vec<LabelOption>,

    /// Degrees the camera turns around the patient; 0 sees the face, 90 the patient's left
    #[arg(long, value_name = "DEGREES", help_heading = "Camera", default_value = "0", value_parser = number(-3600.0, 3600.0))]
    pub azimuth: f64,
    /// Degrees the camera rises, -90 to 90
    #[arg(long, value_name = "DEGREES", help_heading = "Camera", default_value = "0", value_parser = number(-90.0, 90.0))]
    pub elevation: f64,
    /// How many times closer than where everything fits
    #[arg(long, value_name = "FACTOR", help_heading = "Camera", default_value = "1", value_parser = number(1e-3, 1e3))]
    pub zoom: f64,
    /// Degrees between the bottom and the top of the image
    #[arg(long, value_name = "DEGREES", help_heading = "Camera", default_value = "28", value_parser = number(0.1, 170.0))]
    pub fov: f64,
    /// Camera position in mm from the first scan's centre: x to the patient's left, y to the head, z to the viewer
    #[arg(long, value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true, conflicts_with_all = ["azimuth", "elevation", "zoom"])]
    pub eye: Option<Point>,
    /// Point looked at, as --eye [default: the centre of what is seen]
    #[arg(long, value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true)]
    pub target: Option<Point>,

    /// Light: studio, uniform, gradient, or an equirectangular .hdr or .exr file
    #[arg(long, value_name = "LIGHT", help_heading = "Light", default_value = "studio")]
    pub environment: EnvironmentName,
    /// Factor on the light
    #[arg(long, value_name = "FACTOR", help_heading = "Light", default_value = "1", value_parser = number(0.0, 1e6))]
    pub environment_strength: f64,
    /// Degrees the light turns around the vertical, as --azimuth turns the camera
    #[arg(long, value_name = "DEGREES", help_heading = "Light", default_value = "0", value_parser = number(-3600.0, 3600.0))]
    pub environment_rotation: f64,
    /// A sun besides, where --azimuth and --elevation would put the camera; once for each. At STRENGTH 1 (the default) a
    /// white surface that faces it is as bright as under a uniform environment; it is DEGREES in radius (default: 0.27)
    #[arg(long, value_name = "sun:AZIMUTH,ELEVATION[,STRENGTH[,DEGREES]]", help_heading = "Light")]
    pub light: Vec<Sun>,

    /// Width and height in pixels
    #[arg(long, value_name = "WxH", help_heading = "Image", default_value = "768x768")]
    pub size: Size,
    /// Paths per pixel: four times as many halve the noise [default: 512, or as many as --time allows;
    /// without a GPU, as many as two minutes allow]
    #[arg(long, value_name = "N", help_heading = "Image", value_parser = clap::value_parser!(u32).range(1..=16_777_216))]
    pub samples: Option<u32>,
    /// Seconds of tracing after which it ends; every pixel gets at least one sample, however long that takes
    #[arg(long, value_name = "SECONDS", help_heading = "Image", value_parser = seconds)]
    pub time: Option<Duration>,
    /// Another seed gives other noise; the same gives the same image
    #[arg(long, value_name = "N", help_heading = "Image", default_value = "0")]
    pub seed: u32,
    /// Smooth out the noise that is left: clean after few samples, but slightly biased
    #[arg(long, help_heading = "Image")]
    pub denoise: bool,
    /// Stops brighter (or darker, if negative)
    #[arg(long, value_name = "EV", help_heading = "Image", default_value = "0", value_parser = number(-32.0, 32.0))]
    pub exposure: f64,
    /// How light becomes pixels: agx and aces are filmic, plain clips
    #[arg(long, help_heading = "Image", default_value = "agx")]
    pub tone: Tone,
    /// Exponent 1/GAMMA on the pixels after the tone map
    #[arg(long, value_name = "GAMMA", help_heading = "Image", default_value = "1", value_parser = number(0.1, 10.0))]
    pub gamma: f64,
    /// What stands behind: transparent, environment, or a colour as #rrggbb
    #[arg(long, value_name = "WHAT", help_heading = "Image", default_value = "#14171c")]
    pub background: Background,

    /// Take the GPU whose name contains this [default: the fastest kind]
    #[arg(long, value_name = "NAME", help_heading = "Running")]
    pub gpu: Option<String>,
    /// Render on the workers of a Dask scheduler, through Python's lumivox.cluster: tcp://HOST:8786
    #[arg(long, value_name = "ADDRESS", help_heading = "Running", conflicts_with_all = ["gpu", "time"])]
    pub cluster: Option<String>,
    /// Say nothing but errors
    #[arg(short, long, help_heading = "Running")]
    pub quiet: bool,
}

/// What of a scan is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Keep {
    /// The patient, where that can be told for sure
    Patient,
    /// All that was scanned
    Everything,
}

/// `lumivox info`.
#[derive(Args, Debug)]
pub struct InfoArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub input: InputArgs,
    /// For programs: one JSON object on stdout
    #[arg(long)]
    pub json: bool,
}

/// `lumivox import`.
#[derive(Args, Debug)]
pub struct ImportArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub input: InputArgs,
    /// For programs: one JSON object on stdout
    #[arg(long)]
    pub json: bool,
    /// Write a PNG of the middle slice of each series into this folder, which is made if it is missing
    #[arg(long, value_name = "FOLDER")]
    pub thumbnails: Option<PathBuf>,
    /// Pixels of the longer side of a thumbnail, 16 to 2048
    #[arg(long, value_name = "N", default_value = "256", value_parser = clap::value_parser!(u32).range(16..=2048))]
    pub thumbnail_size: u32,
}

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

/// On or off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    On,
    Off,
}

/// Tone maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Tone {
    Plain,
    Agx,
    Aces,
}

/// Interpolations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FilterName {
    Nearest,
    Trilinear,
    Tricubic,
    Smooth,
}

impl From<Tone> for ToneMap {
    fn from(tone: Tone) -> Self {
        match tone {
            Tone::Plain => ToneMap::Plain,
            Tone::Agx => ToneMap::Agx,
            Tone::Aces => ToneMap::Aces,
        }
    }
}

impl From<FilterName> for Filter {
    fn from(name: FilterName) -> Self {
        match name {
            FilterName::Nearest => Filter::Nearest,
            FilterName::Trilinear => Filter::Trilinear,
            FilterName::Tricubic => Filter::Tricubic,
            FilterName::Smooth => Filter::Smooth,
        }
    }
}

/// A parser of finite numbers within a range.
fn number(low: f64, high: f64) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.trim().parse::<f64>().map_err(|_| "not a number".to_owned())?;
        if (low..=high).contains(&number) { Ok(number) } else { Err(format!("must be {low} to {high}")) }
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    number(0.01, 1e7)(text.trim_end_matches('s')).map(Duration::from_secs_f64)
}

/// `n` finite numbers between commas.
pub fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let error = || format!("must be {N} numbers with commas between them");
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|part| part.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    numbers.ok_or_else(error)?.try_into().map_err(|_| error())
}

/// Most pixels of an image.
const MOST_PIXELS: u64 = 1 << 28;

/// Memory that a pixel takes until it is written: the film on the GPU and here, its copies, and the picture.
const BYTES_PER_PIXEL: u64 = 100;

/// An image size in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const LARGEST: u32 = 32_768;
        let side = |text: &str| text.trim().parse().ok().filter(|side| (1..=LARGEST).contains(side));
        let (width, height) = text.split_once(['x', 'X']).ok_or("must be WIDTHxHEIGHT, such as 1920x1080")?;
        match (side(width), side(height)) {
            (Some(width), Some(height)) => {
                let pixels = u64::from(width) * u64::from(height);
                if pixels > MOST_PIXELS {
                    return Err(format!(
                        "{} million pixels are too many, they would need {} GB of memory; at most {} million",
                        pixels / 1_000_000,
                        pixels * BYTES_PER_PIXEL / 1_000_000_000,
                        MOST_PIXELS / 1_000_000,
                    ));
                }
                Ok(Self { width, height })
            }
            _ => Err(format!("width and height must be 1 to {LARGEST}")),
        }
    }
}

/// Largest coordinate of a camera in mm: further away, nothing is seen, and 32-bit floats fail.
pub const FURTHEST: f64 = 1e6;

/// A point in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point(pub DVec3);

impl FromStr for Point {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let point = DVec3::from_array(numbers(text)?);
        if point.abs().max_element() > FURTHEST {
            return Err("must be within 1 km (1000000 mm) of the scan".into());
        }
        Ok(Self(point))
    }
}

/// Opposite corners of what is kept, in box coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip(pub [DVec3; 2]);

impl FromStr for Clip {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [a, b, c, d, e, f] = numbers(text)?;
        let corners = [DVec3::new(a, b, c), DVec3::new(d, e, f)];
        let inside = corners.iter().all(|p| p.min_element() >= 0.0 && p.max_element() <= 1.0);
        if inside && corners[0].cmplt(corners[1]).all() {
            Ok(Self(corners))
        } else {
            Err("must be fractions from 0 to 1, each low one below its high one".into())
        }
    }
}

/// A colour as `#rrggbb`.
pub fn hex_color(text: &str) -> Option<[u8; 3]> {
    text.strip_prefix('#')
        .filter(|hex| hex.len() == 6 && hex.bytes().all(|b| b.is_ascii_hexdigit()))
        .and_then(|hex| u32::from_str_radix(hex, 16).ok())
        .map(|rgb| [(rgb >> 16) as u8, (rgb >> 8) as u8, rgb as u8])
}

/// What stands behind the volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Background {
    /// Nothing: the PNG has an alpha channel.
    Transparent,
    /// The light.
    Environment,
    /// A colour, as the screen shows it (sRGB).
    Color([u8; 3]),
}

impl FromStr for Background {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "transparent" => return Ok(Self::Transparent),
            "environment" => return Ok(Self::Environment),
            _ => {}
        }
        hex_color(text)
            .map(Self::Color)
            .ok_or_else(|| "must be transparent, environment or a colour such as #202428".into())
    }
}

/// Where light comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EnvironmentName {
    /// The built-in studio.
    Studio,
    /// The same from everywhere.
    Uniform,
    /// An overcast sky over dim ground.
    Gradient,
    /// A panorama.
    File(PathBuf),
}

impl FromStr for EnvironmentName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "studio" => Ok(Self::Studio),
            "uniform" => Ok(Self::Uniform),
            "gradient" => Ok(Self::Gradient),
            // A bare word is a typing error rather than a file.
            _ if !text.contains(['.', '/', '\\']) => {
                Err("must be studio, uniform, gradient or an .hdr or .exr file".into())
            }
            _ => Ok(Self::File(text.into())),
        }
    }
}

/// A distant light, by where it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun(pub Light);

impl FromStr for Sun {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let values = text.strip_prefix("sun:").ok_or("must start with sun:, such as sun:40,30")?;
        // The radius that the sun has in the sky.
        let [azimuth, elevation, strength, degrees] = match values.split(',').count() {
            2 => numbers(values).map(|[a, e]| [a, e, 1.0, 0.27])?,
            3 => numbers(values).map(|[a, e, s]| [a, e, s, 0.27])?,
            _ => numbers(values).map_err(|_| "must be sun: and 2 to 4 numbers with commas between them")?,
        };
        if !(0.0..=1e6).contains(&strength) || !(0.0..=180.0).contains(&degrees) {
            return Err("STRENGTH must be 0 to 1000000, DEGREES 0 to 180".into());
        }
        let (sin_a, cos_a) = azimuth.to_radians().sin_cos();
        let (sin_e, cos_e) = elevation.to_radians().sin_cos();
        let kind = LightKind::Directional {
            direction: -DVec3::new(sin_a * cos_e, sin_e, cos_a * cos_e),
            irradiance: [strength * std::f64::consts::PI; 3],
            angular_radius: degrees.to_radians(),
        };
        Ok(Self(kind.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn values_are_read_or_refused() {
        assert_eq!("1920x1080".parse(), Ok(Size { width: 1920, height: 1080 }));
        for bad in ["", "100", "0x5", "5x0", "99999x1", "32768x32768", "1x2x3", "-1x5"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
        assert_eq!("1, -2.5,3".parse(), Ok(Point(DVec3::new(1.0, -2.5, 3.0))));
        for bad in ["1,2", "1,2,3,4", "1e7,0,0", "a,b,c", "nan,0,0", "inf,0,0"] {
            assert!(bad.parse::<Point>().is_err(), "{bad}");
        }
        assert!("0,0,0,1,1,0.5".parse::<Clip>().is_ok());
        for bad in ["0,0,0,1,1,0", "0,0,0,1,1,2", "-1,0,0,1,1,1", "0,0,0"] {
            assert!(bad.parse::<Clip>().is_err(), "{bad}");
        }
        assert_eq!("#0a0B0c".parse(), Ok(Background::Color([10, 11, 12])));
        for bad in ["#12345", "#12345g", "red", "#+12345"] {
            assert!(bad.parse::<Background>().is_err(), "{bad}");
        }
        assert_eq!("sky.hdr".parse(), Ok(EnvironmentName::File("sky.hdr".into())));
        assert!("studoi".parse::<EnvironmentName>().is_err());
        let Ok(Sun(Light { kind: LightKind::Directional { direction, irradiance, .. }, .. })) =
            "sun:90,0,2".parse()
        else {
            panic!("a sun");
        };
        assert!(
            direction.distance(DVec3::NEG_X) < 1e-12 && (irradiance[0] - std::f64::consts::TAU).abs() < 1e-6
        );
        for bad in ["90,0", "sun:90", "sun:1,2,-3", "sun:1,2,3,181", "sun:1,2,3,4,5", "sun:nan,0", "moon:1,2"]
        {
            assert!(bad.parse::<Sun>().is_err(), "{bad}");
        }
        assert!(seconds("0").is_err() && seconds("2.5s") == Ok(Duration::from_secs_f64(2.5)));
    }
}
