//! `lumivox render`: scans to a PNG.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use lumivox_core::{
    CancelToken, Environment, EnvironmentSource, LabelVolume, MOST_CLIP_SHAPES, PerspectiveCamera, Preset,
    Scene, Volume, VolumeInstance, framing,
    glam::{DAffine3, DVec3},
    world_from_patient,
};
use lumivox_renderer::{Background, DisplaySettings};
use lumivox_segmentation::{SegmentationReport, has_organ, skin_is_dense};
use lumivox_wgpu::RenderRequest;

use crate::{
    args::{self, EnvironmentName, Fusion, Keep, RenderArgs},
    classification::{self, Numbered},
    cluster,
    exit::{self, Failure},
    inputs::{self, Peel},
    looks::{Look, LookKind, looks},
    output,
    output::PngOutput,
    progress::{Reporter, human_duration},
    trace,
};

/// Paths per pixel unless asked otherwise: little noise, and seconds on a GPU.
const DEFAULT_SAMPLES: u32 = 512;

/// Where that would take long, for want of a GPU, it ends after so much time unless asked otherwise.
const DEFAULT_SOFTWARE_TIME: Duration = Duration::from_secs(120);

/// Noise that people see, as a fraction of the brightness.
const VISIBLE_NOISE: f64 = 0.12;

/// The film counts in 32-bit floats, which are exact up to here.
const MOST_SAMPLES: u32 = 1 << 24;

const METRES_PER_MM: f64 = 1e-3;

/// Loads, traces and writes.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    let start = Instant::now();
    let reporter = Reporter::new(args.quiet);
    // Everything that can be wrong is looked at before the long work.
    let mut output = PngOutput::prepare(&args.output, files_read(args))?;
    if let (Some(eye), Some(target)) = (args.eye, args.target) {
        check_view(eye.0, target.0)?;
    }
    if args.keep == Keep::Everything && args.peel.is_some_and(|peel| peel > 0.0) {
        return Err(Failure::usage(
            "--peel takes the patient's skin off; it goes with '--keep patient' only",
        ));
    }
    if args.clip_shape.len() > MOST_CLIP_SHAPES {
        let (given, most) = (args.clip_shape.len(), MOST_CLIP_SHAPES);
        return Err(Failure::usage(format!(
            "--clip-shape is given {given} times, of which {most} are possible"
        )));
    }
    inputs::check(&args.input)?;
    let label_files: Vec<PathBuf> = args.labels.iter().filter(|file| !is_found(file)).cloned().collect();
    if !label_files.is_empty() && label_files.len() < args.labels.len() {
        return Err(Failure::usage("--labels found finds labels by itself; it goes with no file of labels"));
    }
    for file in &label_files {
        inputs::check_file(file)?;
    }
    let environment = environment(args)?;
    let count = inputs::count(&args.input);
    let is_chosen = !args.looks.0.is_empty() || args.input.series.is_some();
    let fuses = match args.fusion {
        Fusion::Auto => count == 1 && !is_chosen,
        Fusion::On if count > 1 => {
            return Err(Failure::usage(
                "--fusion on is for one folder; of several scans all are shown anyway",
            ));
        }
        Fusion::On => true,
        Fusion::Off => false,
    };
    let mut looks = looks(args, if args.fusion == Fusion::On { 2 } else { count })?;
    let cancel = exit::cancel_on_ctrl_c()?;
    // None is wanted here where others render.
    let mut gpu = match args.cluster {
        Some(_) => None,
        None => Some(trace::open(args.gpu.as_deref())?),
    };

    let scans = match fuses {
        true => inputs::load_fusion(&args.input, reporter, &cancel)?,
        false => inputs::load(&args.input, reporter, &cancel)?,
    };
    if args.fusion == Fusion::On && scans.len() < 2 {
        return Err(Failure::input(
            "--fusion on: there are no CT or MR and PET of one place; 'lumivox info' lists what there is, and files of \
             both may be named one after the other",
        ));
    }
    if scans.len() > count {
        let names: Vec<&str> =
            scans.iter().map(|scan| scan.report.series[scan.report.chosen].name.as_str()).collect();
        reporter.say(&format!(
            "{} of one place are shown at once ('--fusion off' shows one)",
            names.join(" and ")
        ));
        let one = looks[0].automatic();
        looks.resize(scans.len(), one);
    }
    if args.fusion != Fusion::Off && !is_chosen {
        let volumes: Vec<&Volume> = scans.iter().map(|scan| &scan.volume).collect();
        if let Some(presets) = Preset::fusion_of(&volumes) {
            looks.iter_mut().zip(presets).for_each(|(look, preset)| look.kind = LookKind::Preset(preset));
        }
    }
    if let [a, b] = &scans[..]
        && !lie_together(&a.volume, &b.volume)
    {
        reporter.say("note: the scans lie apart: are they of one patient, and of one place?");
    }
    let mut volumes = Vec::with_capacity(scans.len());
    let from_file = (!label_files.is_empty())
        .then(|| inputs::label_files(&args.input, &label_files, reporter, &cancel))
        .transpose()?;
    for scan in scans {
        reporter.say(&format!("{}: {}", scan.report.format, inputs::describe(&scan.volume)));
        scan.report.notes.iter().for_each(|note| reporter.say(&format!("  note: {note}")));
        if !scan.report.skipped.is_empty() {
            let count = scan.report.skipped.len();
            let were = if count == 1 { "file was" } else { "files were" };
            reporter.say(&format!("  note: {count} {were} left out; 'lumivox info' says why"));
        }
        let look = &looks[volumes.len()];
        let (volume, found) = shown(args, scan.volume, look, reporter, &cancel)?;
        if let (Some(numbered), Some(file)) = (&from_file, label_files.first()) {
            match numbered.labels.share_within(&volume) {
                Some(0.0) if looks.len() == 1 => {
                    return Err(Failure::input(format!(
                        "{}: none of its labels lies in the scan: they are of another patient, or of another place; take \
                         the labels of this scan",
                        file.display()
                    )));
                }
                Some(share) if share < 0.5 => reporter.say(&format!(
                    "  note: {:.0}% of what is labelled lies beyond the scan: are they of the same patient?",
                    100.0 * (1.0 - share)
                )),
                // That was said when they were read.
                None | Some(_) => {}
            }
        }
        let labels = match &from_file {
            Some(labels) => Some(labels.clone()),
            None => found.filter(|_| !args.labels.is_empty()).map(Numbered::new),
        };
        volumes.push((Arc::new(volume), labels));
    }
    let scene = scene(args, volumes, &looks, environment, reporter)?;
    let camera = camera(args, &scene)?;
    cancel.check()?;

    let samples = args.samples.unwrap_or(if args.time.is_some() { MOST_SAMPLES } else { DEFAULT_SAMPLES });
    let unbounded = args.samples.is_none() && args.time.is_none();
    let in_software = gpu.as_ref().is_some_and(|gpu| gpu.description.software);
    let time = args.time.or((unbounded && in_software).then_some(DEFAULT_SOFTWARE_TIME));
    let request = RenderRequest {
        seed: args.seed,
        time,
        guides: args.denoise,
        ..RenderRequest::new(args.size.width, args.size.height, samples)
    };
    let mut traced = match (&mut gpu, &args.cluster) {
        (Some(gpu), _) => trace::trace(&scene, &camera, &request, gpu, reporter, &cancel)?,
        (None, address) => {
            let address = address.as_deref().unwrap_or_default();
            let (film, complete) = cluster::render(address, &scene, &camera, &request, reporter, &cancel)?;
            trace::traced_elsewhere(film, complete)?
        }
    };
    if traced.time_up && samples < MOST_SAMPLES {
        let reached = traced.samples;
        reporter.say(&format!("note: the time was over at {reached} of the {samples} samples per pixel"));
    }
    if args.denoise {
        reporter.say("denoising");
        traced.denoise();
    } else if traced.noise().is_some_and(|noise| noise > VISIBLE_NOISE) {
        reporter.say("note: noise is visible; --denoise smooths it, more --samples or --time take it away");
    }
    let mut picture = traced.picture(&display(args), &scene, &camera);
    if let args::Background::Color(color) = args.background {
        picture.put_on(color);
    }
    let mut shown = args.output.clone();
    if traced.samples == 0 {
        output = output.sparing_the_earlier();
        shown = output.path().to_owned();
    }
    output.write(&picture)?;

    let wrote = format!(
        "{} ({} x {}, {}{}, {})",
        shown.display(),
        picture.width,
        picture.height,
        traced.reached(),
        if args.denoise { ", denoised" } else { "" },
        human_duration(start.elapsed()),
    );
    if let Some(failure) = traced.cut_short {
        let message = format!("{}\nWhat there was is in {wrote}", failure.message);
        return Err(Failure { message, ..failure });
    }
    if !args.quiet {
        output::print(&format!("Wrote {wrote}\n"))?;
    }
    Ok(())
}

/// Whether the boxes of two scans meet in the patient's space.
fn lie_together(a: &Volume, b: &Volume) -> bool {
    let bounds = |volume: &Volume| {
        let size = DVec3::from_array(volume.dims().map(|n| n as f64));
        let corner = |i: usize| {
            let at = DVec3::from_array([i & 1, i >> 1 & 1, i >> 2].map(|k| k as f64)) * size - 0.5;
            volume.patient_from_voxel().transform_point3(at)
        };
        (1..8).map(corner).fold([corner(0); 2], |[low, high], p| [low.min(p), high.max(p)])
    };
    let ([a_low, a_high], [b_low, b_high]) = (bounds(a), bounds(b));
    a_low.cmple(b_high).all() && b_low.cmple(a_high).all()
}

/// Whether labels are what is found in the scan itself, and no file: `found`, unless there is a file of that name in other
/// letters.
fn is_found(labels: &Path) -> bool {
    const FOUND: &str = "found";
    let is_word = labels.to_str().is_some_and(|word| word.eq_ignore_ascii_case(FOUND));
    labels == Path::new(FOUND) || is_word && !labels.exists()
}

/// What of a scan is shown: the patient alone, without the skin where that hides what the look is for. And what was found
/// in it.
fn shown(
    args: &RenderArgs,
    scan: Volume,
    look: &Look,
    reporter: Reporter,
    cancel: &CancelToken,
) -> Result<(Volume, Option<LabelVolume>), Failure> {
    let wants_labels = args.labels.iter().any(|labels| is_found(labels));
    if args.keep == Keep::Everything {
        let found = wants_labels.then(|| inputs::segment(&scan, reporter, cancel)).transpose()?;
        return Ok((scan, found));
    }
    let mut alone = inputs::patient_alone(scan, reporter, cancel)?;
    if wants_labels && alone.labels.is_none() {
        // What is not looked for in what is no CT: body and air, of an MR.
        alone.labels = Some(inputs::segment(&alone.volume, reporter, cancel)?);
    }
    if let Some(note) = alone.note() {
        let more = if alone.changed > 0 { " ('--keep everything' shows it)" } else { "" };
        reporter.say(&format!("  note: {note}{more}"));
    }
    let sure = alone.report.as_ref().is_some_and(SegmentationReport::is_sure);
    let preset = match look.kind {
        LookKind::Preset(preset) => Some(preset),
        LookKind::Automatic => Some(Preset::default_for(&alone.volume)),
        LookKind::File(_) => None,
    };
    if let Some(organ) = preset.and_then(Preset::organ) {
        return match &alone.labels {
            Some(labels) if sure && has_organ(labels, organ) => {
                let volume = inputs::organ_alone(alone.volume, labels, organ, reporter, cancel)?;
                Ok((volume, alone.labels))
            }
            _ => {
                reporter.say("  note: no lungs with airways were found: all is shown");
                Ok((alone.volume, alone.labels))
            }
        };
    }
    let skin = preset.map_or(0.0, Preset::peel_mm);
    let (peel, mm) = args.peel.map_or((Peel::Skin(skin), skin), |mm| (Peel::Depth(mm), mm));
    match alone.labels {
        Some(labels)
            if sure && mm > 0.0 && (args.peel.is_some() || skin_is_dense(&alone.volume, &labels)) =>
        {
            let what = if args.peel.is_some() { "below the skin are" } else { "of skin are" };
            reporter.say(&format!("  {} mm {what} taken off", inputs::number(mm)));
            let volume = inputs::peel(alone.volume, &labels, peel, reporter, cancel)?;
            Ok((volume, Some(labels)))
        }
        labels => {
            if args.peel.is_some_and(|peel| peel > 0.0) {
                reporter
                    .say("  note: nothing is peeled: no skin was found, as in all that is no CT of a body");
            }
            Ok((alone.volume, labels))
        }
    }
}

fn display(args: &RenderArgs) -> DisplaySettings {
    DisplaySettings {
        background: match args.background {
            args::Background::Environment => Background::Environment,
            // A colour is put behind the finished picture: it is what the screen is to show, not a light.
            args::Background::Transparent | args::Background::Color(_) => Background::Transparent,
        },
        exposure_ev: args.exposure,
        tone_map: args.tone.into(),
        gamma: args.gamma,
    }
}

/// All scans in the patient space they share, around the centre of the first.
fn scene(
    args: &RenderArgs,
    volumes: Vec<(Arc<Volume>, Option<Numbered>)>,
    looks: &[Look],
    environment: Environment,
    reporter: Reporter,
) -> Result<Scene, Failure> {
    let center = volumes.first().map(|(volume, _)| volume.center_mm()).unwrap_or_default();
    let world_from_patient = world_from_patient() * DAffine3::from_translation(-center);
    let clip_box = args.clip.map_or([DVec3::ZERO, DVec3::ONE], |clip| clip.0);
    let volumes = volumes
        .into_iter()
        .zip(looks)
        .map(|((volume, labels), look)| {
            let medium = look.medium(args, &volume, reporter)?;
            let labelling = |labels: &Numbered| classification::labelling(labels, &args.label, &volume);
            let labels = labels.as_ref().map(labelling).transpose()?;
            let clip_shapes = args.clip_shape.iter().map(|clip| clip.shape(world_from_patient)).collect();
            let whole = VolumeInstance::new(volume, medium, world_from_patient);
            Ok(VolumeInstance { clip_box, labels, clip_shapes, ..whole })
        })
        .collect::<Result<_, Failure>>()?;
    let lights = args.light.iter().map(|sun| sun.0).collect();
    Ok(Scene { volumes, environment, lights })
}

/// Every file that the command line names for reading.
fn files_read(args: &RenderArgs) -> impl Iterator<Item = &Path> {
    let map = match &args.environment {
        EnvironmentName::File(path) => Some(path),
        _ => None,
    };
    let files = args.input.inputs.iter().chain(args.looks.files()).chain(&args.labels).chain(map);
    files.map(PathBuf::as_path)
}

/// A camera that looks at the place where it stands looks nowhere.
fn check_view(eye: DVec3, target: DVec3) -> Result<(), Failure> {
    if eye.distance(target) > 1e-6 {
        return Ok(());
    }
    Err(Failure::usage("--eye is the point looked at; move it, or give another --target"))
}

fn camera(args: &RenderArgs, scene: &Scene) -> Result<PerspectiveCamera, Failure> {
    let aspect = f64::from(args.size.width) / f64::from(args.size.height);
    let fov = args.fov.to_radians();
    let front = scene
        .volumes
        .first()
        .and_then(framing::front)
        .filter(|_| (args.azimuth, args.elevation) == (None, None));
    let [azimuth, elevation] =
        front.unwrap_or([args.azimuth, args.elevation].map(|angle| angle.unwrap_or(0.0).to_radians()));
    let mut orbit = framing::frame(scene, azimuth, elevation, fov, aspect);
    if let Some(target) = args.target {
        orbit.target = target.0 * METRES_PER_MM;
    }
    match args.eye {
        Some(eye) => {
            check_view(eye.0, orbit.target / METRES_PER_MM)?;
            Ok(PerspectiveCamera::look_at(eye.0 * METRES_PER_MM, orbit.target, DVec3::Y, fov))
        }
        None => {
            orbit.distance /= args.zoom;
            Ok(orbit.camera())
        }
    }
}

fn environment(args: &RenderArgs) -> Result<Environment, Failure> {
    let source = match &args.environment {
        EnvironmentName::Studio => EnvironmentSource::Studio,
        EnvironmentName::Uniform => EnvironmentSource::Uniform([1.0; 3]),
        EnvironmentName::Gradient => EnvironmentSource::Gradient {
            zenith: [1.5, 1.6, 1.8],
            horizon: [1.0, 1.0, 1.0],
            nadir: [0.16, 0.15, 0.14],
        },
        EnvironmentName::File(path) => {
            EnvironmentSource::Map(Arc::new(lumivox_import::load_environment(path)?))
        }
    };
    let rotation = args.environment_rotation.to_radians();
    Ok(Environment { source, rotation, strength: args.environment_strength })
}
