//! The command line: what can be asked for. `values.rs`: what single options take, and what makes no sense.

mod look;
mod phantom;
mod values;

use std::{path::PathBuf, time::Duration};

use clap::{Args, Parser, Subcommand, ValueEnum};
use lumivox_core::{Modality, document::Backdrop};
use lumivox_import::{ArrayLayout, PatientAxes, RawDescription, parse_spacing};

pub use look::{LookName, LookNames, TuningArgs};
pub use phantom::{ArmsArg, MetalArg, PhantomArgs, PhantomKind, TorsoArgs};
pub use values::{
    BYTES_PER_PIXEL, Clip, EnvironmentName, FURTHEST, FilterName, Point, Size, Sun, Switch, Tone, Window,
    numbers,
};
use values::{modality, number, seconds, slope};

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

const SAVE_EXAMPLES: &str = "\
Examples:
  lumivox scene save head.json FOLDER --preset ct-bone --azimuth 35
  lumivox render head.json -o head.png                               the same picture
  lumivox render head.json --preset ct-skin -o skin.png              options win over what the scene says
  lumivox scene save skin.json head.json --preset ct-skin            and can be saved

";

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
  lumivox render ct.nrrd pet.nrrd --preset fusion --preset pet-hot -o both.png
  lumivox render brain.nii.gz zmap.nii.gz -o activity.png
  lumivox render FOLDER --preset ct-soft-tissue --window 60,400 -o liver.png
  lumivox render cbct.nii.gz --modality CT --intercept -1024 -o skull.png
  lumivox render head.json --azimuth 90 -o left.png
  lumivox render head.raw --raw 256x256x108:i16le:spacing=1,1,1.5 -o raw.png

";

/// Turns CT and MR scans into photorealistic images by tracing light through them.
#[derive(Debug, Parser)]
// Called `lumivox` wherever it says how it is used, not as the file is named: on Windows `lumivox.exe`.
#[command(name = "lumivox", bin_name = "lumivox", version, after_help = [EXAMPLES, EXIT_CODES].concat())]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// Options of `lumivox doctor`.
#[derive(Debug, Args)]
pub struct DoctorArgs {
    /// Write each GPU's test picture, a small head, there
    #[arg(long, value_name = "FOLDER")]
    pub pictures: Option<PathBuf>,
    /// Do not say which GPU is tried
    #[arg(short, long)]
    pub quiet: bool,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render scans to a PNG
    #[command(after_help = [RENDER_EXAMPLES, EXIT_CODES].concat(), allow_negative_numbers = true)]
    Render(Box<RenderArgs>),
    /// Save a scene to one file, or check one
    #[command(subcommand)]
    Scene(SceneCommand),
    /// Say what a scan holds: geometry, values, a suggested preset; never the patient's name
    #[command(after_help = [INFO_EXAMPLES, EXIT_CODES].concat(), allow_negative_numbers = true)]
    Info(InfoArgs),
    /// List what can be loaded from a folder, archive or file, without loading it, and why other files cannot
    #[command(after_help = [IMPORT_EXAMPLES, EXIT_CODES].concat(), allow_negative_numbers = true)]
    Import(ImportArgs),
    /// Make a procedural scan, written as a DICOM series
    #[command(after_help = EXIT_CODES, allow_negative_numbers = true)]
    Phantom(PhantomArgs),
    /// List the presets
    #[command(after_help = PRESETS_EXAMPLES)]
    Presets,
    /// Say which GPUs and drivers are seen, have each render, and say what is missing and how to install it
    #[command(after_help = EXIT_CODES)]
    Doctor(DoctorArgs),
}

// Not one of the above, which completions offer even where they are hidden.
/// Write man pages and shell completions, for packages
#[derive(Debug, Parser)]
#[command(name = "lumivox manual")]
pub struct ManualArgs {
    /// The folder, which is made where it is not there
    #[arg(value_name = "FOLDER")]
    pub out: PathBuf,
}

/// Which scans, shared by the commands that read any.
#[derive(Args, Debug)]
pub struct InputArgs {
    /// Scans: a DICOM folder or its files, .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd, .mgh, .mgz, .npy, .raw, a .zip of DICOM
    /// files, a TIFF stack, a folder of TIFF or PNG slices, or an OME-Zarr; to render, a scene of 'lumivox scene save', too
    #[arg(required = true, value_name = "SCAN")]
    pub inputs: Vec<PathBuf>,
    /// DICOM series to take: its place in the list of 'lumivox info', its UID, or a number that no other has; of TIFF and
    /// OME-Zarr the channel
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
    /// Distances between voxels along x, y and z in mm, for arrays, stacks of pictures and OME-Zarr [default: the file's, else
    /// 1]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_spacing, allow_hyphen_values = true)]
    pub spacing: Option<[f64; 3]>,
    /// Where x, y and z of such files grow to in the patient: LPS, RAS, ... [default: LPS]
    #[arg(long, value_name = "AXES")]
    pub axes: Option<PatientAxes>,
    /// Axes of an array, as its shape lists them: x, y, z, t for moments, c for colours [default: zyx, or tzyx where there are
    /// four]
    #[arg(long, value_name = "LETTERS")]
    pub layout: Option<ArrayLayout>,
    /// Units of a scan's values per stored one, in place of what its file says
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true, value_parser = slope)]
    pub slope: Option<f64>,
    /// Value of a stored 0, in place of what the file says: -1024 where a CT's was lost
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true, value_parser = number(-1e9, 1e9))]
    pub intercept: Option<f64>,
    /// What made the scan, in place of what its file says: CT, MR, PET or other
    #[arg(long, value_name = "MODALITY", value_parser = modality)]
    pub modality: Option<Modality>,
    /// What values are measured in, in place of what the file says; HU where a CT's are Hounsfield units
    #[arg(long, value_name = "UNIT")]
    pub unit: Option<String>,
}

/// `lumivox render`.
#[derive(Args, Debug)]
pub struct RenderArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub scene: SceneArgs,
    /// The PNG to write; an existing file is replaced
    #[arg(short, long, value_name = "FILE.png")]
    pub output: PathBuf,
    /// Seconds of tracing after which it ends; every pixel gets at least one sample, if that takes no more than twice as long
    #[arg(long, value_name = "SECONDS", help_heading = "Image", value_parser = seconds)]
    pub time: Option<Duration>,
    /// Take the GPU whose name contains this [default: the fastest kind]
    #[arg(long, value_name = "NAME", help_heading = "Running")]
    pub gpu: Option<String>,
    /// Render on the workers of a Dask scheduler, through Python's lumivox.cluster: tls://HOST:8786
    #[arg(long, value_name = "ADDRESS", help_heading = "Running", conflicts_with_all = ["gpu", "time"])]
    pub cluster: Option<String>,
    /// Say nothing but errors
    #[arg(short, long, help_heading = "Running")]
    pub quiet: bool,
}

/// `lumivox scene`.
#[derive(Debug, Subcommand)]
pub enum SceneCommand {
    /// Write scans, look, light and camera to one file that renders to the same picture
    #[command(after_help = [SAVE_EXAMPLES, EXIT_CODES].concat(), allow_negative_numbers = true)]
    Save(Box<SaveArgs>),
    /// Say whether a scene can be opened, and what is wrong with it, by line
    #[command(after_help = EXIT_CODES)]
    Check(CheckArgs),
}

/// `lumivox scene save`.
#[derive(Args, Debug)]
pub struct SaveArgs {
    /// The scene to write; an existing file is replaced
    #[arg(value_name = "SCENE.json")]
    pub output: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub scene: SceneArgs,
    /// Say nothing but errors
    #[arg(short, long, help_heading = "Running")]
    pub quiet: bool,
}

/// `lumivox scene check`.
#[derive(Args, Debug)]
pub struct CheckArgs {
    /// The scene
    #[arg(value_name = "SCENE.json")]
    pub file: PathBuf,
    /// Let headers (.mhd, .nhdr) name data files anywhere [default: only beside them or below]
    #[arg(long)]
    pub allow_outside_data: bool,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// What is seen, how, and from where. What is not given is as the scene says, and where there is none, as help says.
#[derive(Args, Debug)]
pub struct SceneArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub input: InputArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub looks: LookNames,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub tuning: TuningArgs,
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
    /// [default: smooth]
    #[arg(long, help_heading = "Look")]
    pub filter: Option<FilterName>,
    /// What of a CT to show: the patient alone, or the table, clothes and cables too, as it was scanned
    /// [default: patient]
    #[arg(long, value_name = "WHAT", help_heading = "Look")]
    pub keep: Option<Keep>,
    /// Millimetres below the skin that are taken off a CT, up to 63 [default: the preset's]
    #[arg(long, value_name = "MM", help_heading = "Look", value_parser = number(0.0, 63.0))]
    pub peel: Option<f64>,
    /// Show a PET in the CT or MR of its place, where a folder holds both: auto does where no look was chosen; with on,
    /// --preset is the CT's, given twice the PET's too
    #[arg(long, value_name = "WHEN", help_heading = "Look", default_value = "auto")]
    pub fusion: Fusion,
    /// Part to keep, as fractions along the voxel axes: lowx,lowy,lowz,highx,highy,highz
    #[arg(long, value_name = "BOX", help_heading = "Look", allow_hyphen_values = true)]
    pub clip: Option<Clip>,
    /// Cut the volumes open: what the shape keeps is seen, or with a '!' before it what it does not. plane:X,Y,Z,NX,NY,NZ
    /// keeps the side to which its normal N points; box: two corners; sphere: centre and radius; in mm, as --eye.
    /// Once for each
    #[arg(long, value_name = "[!]SHAPE:NUMBERS", help_heading = "Look", allow_hyphen_values = true)]
    pub clip_shape: Vec<ClipOption>,
    /// Labels of the scan's voxels: a DICOM SEG, NIfTI, NRRD or MetaImage file, or a folder with a mask for each organ; or
    /// 'found' for what is found in a CT by itself. Given several times, all files are one label map
    #[arg(long, value_name = "FILE|found", help_heading = "Look")]
    pub labels: Vec<PathBuf>,
    /// How a label looks, by its name, else its number in the file (#2 where a name is a number), or * for all; in turn.
    /// Words, with commas between them: hide, show, color (its own), color:#rrggbb, opacity:F, density:F, preset:NAME, matte,
    /// uncut (by --clip-shape)
    #[arg(long, value_name = "NAME=WORDS", help_heading = "Look")]
    pub label: Vec<LabelOption>,

    /// Degrees the camera turns around the patient; 0 sees the face, 90 the patient's left [default: 0; a single slice is
    /// seen from its front]
    #[arg(long, value_name = "DEGREES", help_heading = "Camera", value_parser = number(-3600.0, 3600.0))]
    pub azimuth: Option<f64>,
    /// Degrees the camera rises, -90 to 90 [default: 0, as of --azimuth]
    #[arg(long, value_name = "DEGREES", help_heading = "Camera", value_parser = number(-90.0, 90.0))]
    pub elevation: Option<f64>,
    /// How many times closer than where everything fits [default: 1]
    #[arg(long, value_name = "FACTOR", help_heading = "Camera", value_parser = number(1e-3, 1e3))]
    pub zoom: Option<f64>,
    /// Degrees between the bottom and the top of the image [default: 28]
    #[arg(long, value_name = "DEGREES", help_heading = "Camera", value_parser = number(0.1, 170.0))]
    pub fov: Option<f64>,
    /// Camera position in mm from the first scan's centre: x to the patient's left, y to the head, z to the viewer
    #[arg(long, value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true, conflicts_with_all = ["azimuth", "elevation", "zoom"])]
    pub eye: Option<Point>,
    /// Point looked at, as --eye [default: the centre of what is seen]
    #[arg(long, value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true)]
    pub target: Option<Point>,

    /// Light: studio, uniform, gradient, or an equirectangular .hdr or .exr file [default: studio]
    #[arg(long, value_name = "LIGHT", help_heading = "Light")]
    pub environment: Option<EnvironmentName>,
    /// Factor on the light [default: 1]
    #[arg(long, value_name = "FACTOR", help_heading = "Light", value_parser = number(0.0, 1e6))]
    pub environment_strength: Option<f64>,
    /// Degrees the light turns around the vertical, as --azimuth turns the camera [default: 0]
    #[arg(long, value_name = "DEGREES", help_heading = "Light", value_parser = number(-3600.0, 3600.0))]
    pub environment_rotation: Option<f64>,
    /// A sun besides, where --azimuth and --elevation would put the camera; once for each. At STRENGTH 1 (the default) a
    /// white surface that faces it is as bright as under a uniform environment; it is DEGREES in radius (default: 0.27)
    #[arg(long, value_name = "sun:AZIMUTH,ELEVATION[,STRENGTH[,DEGREES]]", help_heading = "Light")]
    pub light: Vec<Sun>,

    /// Width and height in pixels [default: 768x768]
    #[arg(long, value_name = "WxH", help_heading = "Image", allow_hyphen_values = true)]
    pub size: Option<Size>,
    /// Paths per pixel: four times as many halve the noise [default: 512, or as many as --time allows;
    /// without a GPU, as many as two minutes allow]
    #[arg(long, value_name = "N", help_heading = "Image", value_parser = clap::value_parser!(u32).range(1..=16_777_216))]
    pub samples: Option<u32>,
    /// Noise at which it ends before it has all samples, as a fraction of the brightness, such as 0.02 [default: none]
    #[arg(long, value_name = "FRACTION", help_heading = "Image", value_parser = number(1e-4, 1.0))]
    pub noise: Option<f64>,
    /// Another seed gives other noise; the same gives the same image [default: 0]
    #[arg(long, value_name = "N", help_heading = "Image")]
    pub seed: Option<u32>,
    /// Smooth out the noise that is left: clean after few samples, but slightly biased
    #[arg(long, help_heading = "Image")]
    pub denoise: bool,
    /// Stops brighter (or darker, if negative) [default: 0]
    #[arg(long, value_name = "EV", help_heading = "Image", value_parser = number(-32.0, 32.0))]
    pub exposure: Option<f64>,
    /// How light becomes pixels: agx and aces are filmic, plain clips [default: agx]
    #[arg(long, help_heading = "Image")]
    pub tone: Option<Tone>,
    /// Exponent 1/GAMMA on the pixels after the tone map [default: 1]
    #[arg(long, value_name = "GAMMA", help_heading = "Image", value_parser = number(0.1, 10.0))]
    pub gamma: Option<f64>,
    /// What stands behind.
    // Said here for people: in documentation its default would be a link.
    #[arg(long, value_name = "WHAT", help_heading = "Image")]
    #[arg(help = "What stands behind: transparent, environment, or a colour as #rrggbb [default: #14171c]")]
    pub background: Option<Backdrop>,
}

/// What of a scan is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Keep {
    /// The patient, where that can be told for sure
    Patient,
    /// All that was scanned
    Everything,
}

/// When two scans of a folder are shown at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Fusion {
    /// Where neither a series nor a look was chosen
    Auto,
    /// Always
    On,
    /// Never
    Off,
}

/// `lumivox info`.
#[derive(Args, Debug)]
pub struct InfoArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub input: InputArgs,
    /// For programs: one JSON object on stdout, of an error too
    #[arg(long)]
    pub json: bool,
    /// Do not say how far it is
    #[arg(short, long)]
    pub quiet: bool,
}

/// `lumivox import`.
#[derive(Args, Debug)]
pub struct ImportArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub input: InputArgs,
    /// For programs: one JSON object on stdout, of an error too
    #[arg(long)]
    pub json: bool,
    /// Do not say how far it is
    #[arg(short, long)]
    pub quiet: bool,
    /// Write a PNG of the middle slice of each series into this folder, which is made if it is missing
    #[arg(long, value_name = "FOLDER")]
    pub thumbnails: Option<PathBuf>,
    /// Pixels of the longer side of a thumbnail, 16 to 2048
    #[arg(long, value_name = "N", default_value = "256", value_parser = clap::value_parser!(u32).range(16..=2048))]
    pub thumbnail_size: u32,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::Cli::command().debug_assert();
    }

    /// Help says what happens where nothing is said: what documents have by default.
    #[test]
    fn help_tells_the_defaults_of_scenes() {
        use lumivox_core::document::{Display, Film, View};
        let (film, display, view) = (Film::default(), Display::default(), View::default());
        let mut command = super::Cli::command();
        let render = command.find_subcommand_mut("render").unwrap();
        let defaults = [
            ("size", format!("{}x{}", film.size[0], film.size[1])),
            ("seed", film.seed.to_string()),
            ("background", display.background.to_string()),
            ("exposure", display.exposure.to_string()),
            ("gamma", display.gamma.to_string()),
            ("tone", "agx".to_owned()),
            ("fov", view.fov.to_string()),
            ("filter", "smooth".to_owned()),
            ("keep", "patient".to_owned()),
            ("environment", "studio".to_owned()),
        ];
        for (option, default) in defaults {
            let argument = render.get_arguments().find(|argument| argument.get_id() == option).unwrap();
            let help = argument.get_help().unwrap().to_string();
            assert!(help.ends_with(&format!("[default: {default}]")), "--{option}: {help}");
        }
    }
}
