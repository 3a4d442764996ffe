//! What is measured: the words of the command line.

use std::path::PathBuf;

use lumivox_core::Preset;
use lumivox_renderer::{LiveSettings, ToneMap};

use super::films::{Body, Motion};
use super::host::Host;

/// What `--help` prints.
pub const HELP: &str = "\
motion OUT [--quick] [OPTION=VALUE ...]: how good the picture is while things move. Writes tables and pictures into OUT.

  --quick                 the head alone; films other than the orbit in ct-muscle alone; fewer frames, 256 samples
  scene=head,torso        what is looked at
  look=ct-skin,ct-muscle,ct-bone
  film=orbit,function,light,mesh,plane
  budget=8,2,.7           milliseconds of the GPU's time for a frame of the view
  spend=2.4,.25,.06       samples a pixel and frame, in place of a time: the same pictures on any GPU
  variant=raw,denoised,kept  settings of the live view: as it is traced, with the denoiser, with light kept in the volumes
  size=1920x1080          pixels
  voxels=384              along a side of the scans
  length=60               frames of a film, which lasts a second at 60
  frames=0,5,15,...       those that are compared; neighbours tell how it flickers
  rest=15,60              frames after the film stops that are compared
  after=16                frames after the cut, which ends the film
  samples=512             of a converged picture
  tone=plain              plain, agx or aces: how light is shown
  converged=DIR           a folder that keeps converged pictures: those that are there are not made again
  kernels=0               frames of each film that are played again, each kernel timed by itself: OUT/kernels.csv
  eyes=1                  2: a headset's, 63 mm apart; times are of both, pictures of the right one
  strip=480               pixels along a side of the pictures in OUT/strips; 0 makes none

LUMIVOX_GPU chooses a device by a part of its name.";

/// Settings of a live view that are compared with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// As it is traced.
    Raw,
    /// With the denoiser.
    Denoised,
    /// With light that is kept in the volumes.
    Kept,
}

impl Variant {
    const ALL: [Self; 3] = [Self::Raw, Self::Denoised, Self::Kept];

    /// Those of a live view.
    pub fn settings(self, host: &Host) -> LiveSettings {
        host.settings().with(|it| {
            it.denoise = self == Self::Denoised;
            it.kept_light = self == Self::Kept;
        })
    }

    /// As options and tables have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Denoised => "denoised",
            Self::Kept => "kept",
        }
    }
}

/// What a frame may cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cost {
    /// Milliseconds of the GPU's time.
    Milliseconds(f64),
    /// Samples a pixel.
    Samples(f64),
}

impl Cost {
    /// As tables and files have it.
    pub fn name(self) -> String {
        match self {
            Self::Milliseconds(ms) => format!("{ms}ms"),
            Self::Samples(samples) => format!("{samples}spp"),
        }
    }
}

/// All that can be chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    pub out: PathBuf,
    /// What is filmed, in which look, how.
    pub films: Vec<(Body, Preset, Motion)>,
    pub costs: Vec<Cost>,
    pub variants: Vec<Variant>,
    pub size: [u32; 2],
    pub voxels: usize,
    pub length: usize,
    /// Sorted.
    pub frames: Vec<usize>,
    /// Sorted.
    pub rest: Vec<usize>,
    pub after: usize,
    pub samples: u32,
    pub tone: ToneMap,
    pub strip: usize,
    /// Frames whose kernels are timed by themselves.
    pub kernels: usize,
    /// Views of a frame: one, or two from a little apart.
    pub eyes: usize,
    /// Where converged pictures are kept.
    pub converged: Option<PathBuf>,
}

const LOOKS: [Preset; 3] = [Preset::CtSkin, Preset::CtMuscle, Preset::CtBone];

/// Frames that are compared, with neighbours of two.
const FRAMES: [usize; 7] = [0, 5, 15, 29, 30, 58, 59];
const QUICK_FRAMES: [usize; 4] = [0, 15, 58, 59];

impl Options {
    /// Of words; `None` where they ask for help.
    ///
    /// # Errors
    /// What is wrong with which word.
    pub fn parse(words: impl IntoIterator<Item = String>) -> Result<Option<Self>, String> {
        let mut out = None;
        let mut quick = false;
        let (mut bodies, mut looks, mut motions) = (None, None, None);
        let (mut frames, mut samples, mut length) = (None, None, 60);
        let mut options = Self {
            out: PathBuf::new(),
            films: vec![],
            costs: [8.0, 2.0, 0.7].map(Cost::Milliseconds).to_vec(),
            variants: Variant::ALL.to_vec(),
            size: [1920, 1080],
            voxels: 384,
            length,
            frames: vec![],
            rest: vec![15, 60],
            after: 16,
            samples: 512,
            tone: ToneMap::Plain,
            strip: 480,
            kernels: 0,
            eyes: 1,
            converged: None,
        };
        for word in words {
            let Some((name, value)) = word.split_once('=') else {
                match word.as_str() {
                    "--help" | "-h" => return Ok(None),
                    "--quick" => quick = true,
                    // Cargo's.
                    "--bench" => {}
                    _ if word.starts_with('-') || out.is_some() => {
                        return Err(format!("'{word}' is no option; --help lists them"));
                    }
                    _ => out = Some(PathBuf::from(word)),
                }
                continue;
            };
            match name {
                "scene" => bodies = Some(named(&word, value, &Body::ALL, |body| body.name())?),
                "look" => looks = Some(named(&word, value, &LOOKS, |look| look.name())?),
                "film" => motions = Some(named(&word, value, &Motion::ALL, |motion| motion.name())?),
                "variant" => {
                    options.variants = named(&word, value, &Variant::ALL, |variant| variant.name())?;
                }
                "budget" => {
                    options.costs = positive(&word, value)?.into_iter().map(Cost::Milliseconds).collect();
                }
                "spend" => {
                    options.costs = positive(&word, value)?.into_iter().map(Cost::Samples).collect();
                }
                "size" => options.size = size(&word, value)?,
                "voxels" => options.voxels = number(&word, value, 16, 1024)?,
                "length" => length = number(&word, value, 2, 600)?,
                "frames" => frames = Some(ascending(&word, value, 0, 599)?),
                "rest" => options.rest = ascending(&word, value, 1, 600)?,
                "after" => options.after = number(&word, value, 1, 600)?,
                "samples" => samples = Some(number(&word, value, 1, 65_536)? as u32),
                "tone" => {
                    let tones = [ToneMap::Plain, ToneMap::Agx, ToneMap::Aces];
                    options.tone = one(&word, named(&word, value, &tones, tone_name)?)?;
                }
                "converged" => options.converged = Some(PathBuf::from(value)),
                "kernels" => options.kernels = number(&word, value, 0, 600)?,
                "eyes" => options.eyes = number(&word, value, 1, 2)?,
                "strip" => options.strip = number(&word, value, 0, 4096)?,
                _ => return Err(format!("'{word}' is no option; --help lists them")),
            }
        }
        options.out = out.ok_or("name a folder that figures and pictures are written into: motion OUT")?;
        options.length = length;
        options.samples = samples.unwrap_or(if quick { 256 } else { 512 });
        options.frames = match frames {
            Some(frames) => match frames.last() {
                Some(last) if *last >= length => {
                    return Err(format!("frames={last}: the film ends with frame {}", length - 1));
                }
                _ => frames,
            },
            None => {
                let usual: &[usize] = if quick { &QUICK_FRAMES } else { &FRAMES };
                usual.iter().copied().filter(|frame| *frame < length).collect()
            }
        };
        let is_chosen = bodies.is_some() || looks.is_some() || motions.is_some();
        let bodies = bodies.unwrap_or(Body::ALL.to_vec());
        let looks = looks.unwrap_or(LOOKS.to_vec());
        let motions = motions.unwrap_or(Motion::ALL.to_vec());
        for body in bodies {
            for &look in &looks {
                let measured = |motion: &Motion| {
                    let is_orbit = *motion == Motion::Orbit;
                    let of_quick = body == Body::Head && (is_orbit || look == Preset::CtMuscle);
                    // All of everything takes twice as long.
                    let of_all = body == Body::Head || is_orbit;
                    is_chosen || if quick { of_quick } else { of_all }
                };
                let motions = motions.iter().copied().filter(measured);
                options.films.extend(motions.map(|motion| (body, look, motion)));
            }
        }
        Ok(Some(options))
    }
}

fn named<T: Copy>(
    word: &str,
    value: &str,
    all: &[T],
    name: impl Fn(&T) -> &'static str,
) -> Result<Vec<T>, String> {
    let find = |wanted: &str| {
        let found = all.iter().find(|item| name(item) == wanted).copied();
        let names: Vec<&str> = all.iter().map(&name).collect();
        found.ok_or_else(|| format!("{word}: there is no '{wanted}', but {}", names.join(", ")))
    };
    value.split(',').map(find).collect()
}

fn one<T>(word: &str, mut values: Vec<T>) -> Result<T, String> {
    let value = values.pop().filter(|_| values.is_empty());
    value.ok_or_else(|| format!("{word}: name one"))
}

fn tone_name(tone: &ToneMap) -> &'static str {
    match tone {
        ToneMap::Plain => "plain",
        ToneMap::Agx => "agx",
        ToneMap::Aces => "aces",
    }
}

fn positive(word: &str, value: &str) -> Result<Vec<f64>, String> {
    let parse = |text: &str| {
        let number: Option<f64> = text.parse().ok().filter(|n| (1e-4..=1e4).contains(n));
        number.ok_or_else(|| format!("{word}: '{text}' is no number between .0001 and 10000"))
    };
    value.split(',').map(parse).collect()
}

fn number(word: &str, value: &str, least: usize, most: usize) -> Result<usize, String> {
    let number: Option<usize> = value.parse().ok().filter(|n| (least..=most).contains(n));
    number.ok_or_else(|| format!("{word}: '{value}' is no whole number between {least} and {most}"))
}

fn ascending(word: &str, value: &str, least: usize, most: usize) -> Result<Vec<usize>, String> {
    let numbers: Result<Vec<usize>, String> =
        value.split(',').map(|text| number(word, text, least, most)).collect();
    let mut numbers = numbers?;
    numbers.sort_unstable();
    numbers.dedup();
    Ok(numbers)
}

fn size(word: &str, value: &str) -> Result<[u32; 2], String> {
    let wrong = || format!("{word}: give it as 1920x1080, each between 8 and 8192");
    let (width, height) = value.split_once('x').ok_or_else(wrong)?;
    let side = |text: &str| text.parse().ok().filter(|n| (8..=8192).contains(n)).ok_or_else(wrong);
    Ok([side(width)?, side(height)?])
}
