//! `lumivox render`: scans, or a scene, to a PNG.

use std::time::{Duration, Instant};

use lumivox_core::document::Backdrop;
use lumivox_renderer::DisplaySettings;
use lumivox_wgpu::RenderRequest;

use crate::{
    args::RenderArgs,
    cluster,
    exit::{self, Exit, Failure},
    opening::{Opened, Plan, files_named},
    output::{self, PngOutput},
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

/// Loads, traces and writes.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    let start = Instant::now();
    let reporter = Reporter::new(args.quiet);
    // Everything that can be wrong is looked at before the long work.
    let mut output = PngOutput::prepare(&args.output, files_named(&args.scene))?;
    let plan = Plan::new(&args.scene)?;
    plan.check_output(&args.output)?;
    if args.cluster.is_some() && plan.film().noise.is_some() {
        match plan.film().samples {
            Some(samples) => {
                reporter.say(&format!("note: a cluster traces all {samples} samples, whatever the noise"))
            }
            None => return Err(Failure::usage("a cluster does not look at the noise; give it --samples")),
        }
    }
    let cancel = exit::cancel_on_ctrl_c()?;
    // None is wanted here where others render.
    let mut gpu = match args.cluster {
        Some(_) => None,
        None => Some(trace::open(args.gpu.as_deref())?),
    };
    let Opened { document, scene, camera } = plan.open(&args.scene, false, reporter, &cancel)?;

    let film = document.film;
    let ends = args.time.is_some() || film.noise.is_some();
    let samples = film.samples.unwrap_or(if ends { MOST_SAMPLES } else { DEFAULT_SAMPLES });
    let unbounded = film.samples.is_none() && args.time.is_none();
    let in_software = gpu.as_ref().is_some_and(|gpu| gpu.description.software);
    let time = args.time.or((unbounded && in_software).then_some(DEFAULT_SOFTWARE_TIME));
    let request = RenderRequest::new(film.size[0], film.size[1], samples).with(|it| {
        it.seed = film.seed;
        it.time = time;
        it.noise = film.noise;
        it.guides = film.denoise;
    });
    exit::keep(reporter);
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
    let mut denoised = film.denoise;
    if film.denoise {
        reporter.say("denoising");
        denoised = traced.denoise(&exit::has_time);
        if !denoised && traced.cut_short.is_none() {
            traced.cut_short = Some(Failure::new(Exit::Interrupted, "Stopped before it was denoised."));
        }
    } else if traced.noise().is_some_and(|noise| noise > VISIBLE_NOISE) {
        reporter.say("note: noise is visible; --denoise smooths it, more --samples or --time take it away");
    }
    let mut picture = traced.picture(&DisplaySettings::from(&document.display), &scene, &camera);
    if let Backdrop::Color(color) = document.display.background {
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
        if denoised { ", denoised" } else { "" },
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
