//! `lumivox render --cluster`: the same picture by Python's `lumivox.cluster`, on the workers of a Dask scheduler.
//!
//! Everything is loaded, looked at and framed here, and shown here; `python3 -m lumivox.cluster` gets the scene on its
//! standard input (a line of JSON, then voxels and texels as they lie in memory) and gives back lines of progress and the
//! film's sums. Its input ends when the picture is no longer wanted.

use std::{
    io::{self, BufRead, BufReader, Read, Write},
    process::{Child, ChildStdin, Command, Stdio},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::Duration,
};

use lumivox_core::{
    CancelToken, ClipKind, ClipShape, Cone, Ease, EnvironmentMap, EnvironmentSource, ExtinctionSpace, Filter,
    LabelStyle, LabelVolume, Labelling, Light, LightKind, Medium, PerspectiveCamera, Scene,
    SurfaceReflection, TransferFunction, VolumeInstance, Voxels,
    glam::{DAffine3, DVec3},
};
use lumivox_renderer::Film;
use lumivox_wgpu::{RenderProgress, RenderRequest};
use serde_json::{Value, json};

use crate::{
    exit::{Exit, Failure},
    inputs,
    progress::Reporter,
};

/// Names another interpreter than `python3`.
const INTERPRETER: &str = "LUMIVOX_PYTHON";

/// Python has millimetres.
const MM_PER_METRE: f64 = 1e3;

/// How often it is asked whether the picture is still wanted.
const LOOK: Duration = Duration::from_millis(50);

/// The film that a cluster renders, and whether it is whole.
pub fn render(
    address: &str,
    scene: &Scene,
    camera: &PerspectiveCamera,
    request: &RenderRequest,
    reporter: Reporter,
    cancel: &CancelToken,
) -> Result<(Film, bool), Failure> {
    let interpreter = std::env::var(INTERPRETER).unwrap_or_else(|_| "python3".into());
    let header = header(address, scene, camera, request)?;
    let mut child = Command::new(&interpreter)
        .args(["-m", "lumivox.cluster"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| unusable(&interpreter, &error.to_string()))?;
    reporter.say(&format!("tracing on the cluster at {address}"));
    let errors = child.stderr.take().expect("a pipe");
    // Read all along: a full pipe would hold it up.
    let errors = thread::spawn(move || {
        let mut text = String::new();
        let _ = BufReader::new(errors).read_to_string(&mut text);
        text
    });
    let input = child.stdin.take().expect("a pipe");
    let done = AtomicBool::new(false);
    let answer = thread::scope(|scope| {
        scope.spawn(|| send(input, &header, scene, || done.load(Ordering::Relaxed) || cancel.is_cancelled()));
        let answer = hear(&mut child, reporter);
        // Whatever came of it, nothing more is sent.
        if answer.is_err() {
            let _ = child.kill();
        }
        done.store(true, Ordering::Relaxed);
        answer
    });
    let status = child.wait();
    let said = errors.join().unwrap_or_default();
    match answer {
        Ok(Answer::Film(film, complete)) => Ok((film, complete)),
        Ok(Answer::Failure(kind, words)) => Err(Failure::new(
            match kind.as_str() {
                "gpu" => Exit::Gpu,
                "cancelled" => Exit::Interrupted,
                _ => Exit::Failure,
            },
            words,
        )),
        // It ended before it said anything of ours: no such module, most likely.
        Ok(Answer::Nothing) => {
            let last = said.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("it said nothing");
            let status = status.map(|status| status.to_string()).unwrap_or_default();
            Err(unusable(&interpreter, &format!("{last} ({status})")))
        }
        Err(error) => Err(Failure::other(format!("the cluster's film did not arrive: {error}"))),
    }
}

fn unusable(interpreter: &str, why: &str) -> Failure {
    Failure::other(format!(
        "--cluster needs Python with Lumivox, and '{interpreter} -m lumivox.cluster' does not run: {why}\n\
         Install it with {interpreter} -m pip install 'lumivox[cluster]'; {INTERPRETER} names another interpreter."
    ))
}

/// Sends the scene, and holds the pipe open as long as the picture is wanted. An end that is gone is heard elsewhere.
fn send(mut input: ChildStdin, header: &Value, scene: &Scene, enough: impl Fn() -> bool) {
    let mut all = || -> io::Result<()> {
        writeln!(input, "{header}")?;
        for instance in &scene.volumes {
            input.write_all(instance.volume.voxels().as_bytes())?;
        }
        for labels in label_volumes(scene) {
            input.write_all(labels.voxels())?;
        }
        if let Some(map) = map_of(scene) {
            for texel in map.texels.as_flattened() {
                input.write_all(&texel.to_ne_bytes())?;
            }
        }
        input.flush()
    };
    if all().is_ok() {
        while !enough() {
            thread::sleep(LOOK);
        }
    }
}

/// What came back.
enum Answer {
    Film(Film, bool),
    Failure(String, String),
    Nothing,
}

fn hear(child: &mut Child, reporter: Reporter) -> io::Result<Answer> {
    let mut output = BufReader::new(child.stdout.take().expect("a pipe"));
    let mut bar = reporter.tracing();
    let mut line = String::new();
    loop {
        line.clear();
        if output.read_line(&mut line)? == 0 {
            return Ok(Answer::Nothing);
        }
        let Ok(said) = serde_json::from_str::<Value>(&line) else { continue };
        if let Some(words) = said["error"].as_str() {
            let kind = said["kind"].as_str().unwrap_or_default();
            return Ok(Answer::Failure(kind.to_owned(), words.to_owned()));
        }
        if let Some(words) = said["note"].as_str() {
            reporter.say(&format!("note: {words}"));
            continue;
        }
        if let Some([planes, height, width]) = said["film"].as_array().map(Vec::as_slice) {
            let [planes, height, width] = [planes, height, width].map(|n| n.as_u64().unwrap_or(0) as usize);
            let mut film = vec![];
            for _ in 0..planes {
                let mut bytes = vec![0; height * width * 16];
                output.read_exact(&mut bytes)?;
                let number = |b: &[u8]| f32::from_ne_bytes([b[0], b[1], b[2], b[3]]);
                let pixel = |pixel: &[u8]| [0, 4, 8, 12].map(|at| number(&pixel[at..]));
                film.push(bytes.chunks_exact(16).map(pixel).collect());
            }
            bar.finish();
            let complete = said["complete"] == true;
            return Film::from_planes(width as u32, height as u32, film)
                .map(|film| Answer::Film(film, complete))
                .ok_or_else(|| io::ErrorKind::InvalidData.into());
        }
        let number = |name: &str| said[name].as_f64().unwrap_or(0.0);
        let seconds = |name: &str| Duration::try_from_secs_f64(number(name)).unwrap_or(Duration::MAX);
        bar.update(&RenderProgress {
            samples: number("samples"),
            target: number("target") as u32,
            elapsed: seconds("elapsed"),
            left: seconds("left").min(Duration::from_secs(1_000_000_000)),
            noise: None,
        });
    }
}

/// All but voxels and texels, in the words of the Python package.
fn header(
    address: &str,
    scene: &Scene,
    camera: &PerspectiveCamera,
    request: &RenderRequest,
) -> Result<Value, Failure> {
    if scene.volumes.iter().any(|instance| instance.peel.is_some()) {
        return Err(Failure::usage(
            "a cluster takes no scene that is peeled while it is seen; give --peel in place of the scene's 'peel'",
        ));
    }
    let lights = scene.lights.iter().map(light).collect::<Result<Vec<_>, _>>()?;
    Ok(json!({
        "version": env!("CARGO_PKG_VERSION"),
        "address": address,
        "labels": label_volumes(scene).iter().map(|labels| labels_of(labels)).collect::<Vec<_>>(),
        "volumes": scene.volumes.iter().map(|instance| volume(instance, scene)).collect::<Vec<_>>(),
        "environment": environment(scene),
        "lights": lights,
        "camera": rows(DAffine3 {
            translation: camera.world_from_camera.translation * MM_PER_METRE,
            ..camera.world_from_camera
        }),
        "fov": camera.vertical_fov.to_degrees(),
        "size": [request.width, request.height],
        "samples": request.samples,
        "seed": request.seed,
        "guides": request.guides,
    }))
}

fn rows(affine: DAffine3) -> Value {
    let m = affine.matrix3;
    json!([0, 1, 2].map(|row| [m.x_axis[row], m.y_axis[row], m.z_axis[row], affine.translation[row]]))
}

/// The labels of all volumes, each once.
fn label_volumes(scene: &Scene) -> Vec<&Arc<LabelVolume>> {
    let mut all: Vec<&Arc<LabelVolume>> = vec![];
    for labelling in scene.volumes.iter().filter_map(|instance| instance.labels.as_ref()) {
        if !all.iter().any(|labels| Arc::ptr_eq(labels, &labelling.labels)) {
            all.push(&labelling.labels);
        }
    }
    all
}

fn labels_of(labels: &LabelVolume) -> Value {
    let [x, y, z] = labels.dims();
    let entries = labels.labels().iter().map(|label| json!([label.value, label.name, label.color]));
    json!({
        "shape": [z, y, x],
        "patient_from_voxel": rows(labels.patient_from_voxel()),
        "entries": entries.collect::<Vec<_>>(),
    })
}

fn labelling(labelling: &Labelling, scene: &Scene) -> Value {
    let of = label_volumes(scene).iter().position(|labels| Arc::ptr_eq(labels, &labelling.labels));
    let styles = labelling.styles.iter().map(|(value, style)| json!([value, self::style(style)]));
    json!({ "of": of, "styles": styles.collect::<Vec<_>>() })
}

fn style(style: &LabelStyle) -> Value {
    json!({
        "visible": style.visible,
        "color": style.color,
        "opacity": style.opacity,
        "density": style.density_scale,
        "transfer_function": style.transfer_function.as_ref().map(curve),
        "surface": style.surface.map(surface),
        "clipped": style.clipped,
    })
}

fn clip_shape(shape: &ClipShape) -> Value {
    let kind = match shape.kind {
        ClipKind::Plane => "plane",
        ClipKind::Box => "box",
        ClipKind::Sphere => "sphere",
    };
    json!({ "kind": kind, "from_shape": rows(shape.patient_from_shape), "inverted": shape.inverted, "space": "patient" })
}

fn volume(instance: &VolumeInstance, scene: &Scene) -> Value {
    let volume = &instance.volume;
    let [x, y, z] = volume.dims();
    json!({
        "shape": [z, y, x],
        "type": match volume.voxels() {
            Voxels::U8(_) => "uint8",
            Voxels::U16(_) => "uint16",
            Voxels::F32(_) => "float32",
        },
        "slope": volume.slope(),
        "intercept": volume.intercept(),
        "patient_from_voxel": rows(volume.patient_from_voxel()),
        "modality": inputs::modality(volume).unwrap_or_default(),
        "unit": volume.unit(),
        "medium": medium(&instance.medium),
        "clip": instance.clip_box.map(|corner| corner.to_array()),
        "world_from_patient": rows(DAffine3::from_scale(DVec3::splat(MM_PER_METRE)) * instance.world_from_patient),
        "layers": instance.layers,
        "labels": instance.labels.as_ref().map(|labels| labelling(labels, scene)),
        "clip_shapes": instance.clip_shapes.iter().map(clip_shape).collect::<Vec<_>>(),
    })
}

fn curve(curve: &TransferFunction) -> Value {
    let ease = |ease| match ease {
        Ease::Linear => "linear",
        Ease::InOut => "in-out",
    };
    let knots = curve.opacity_knots().iter().map(|knot| json!([knot.value, knot.opacity, ease(knot.ease)]));
    let stops = curve.color_stops().iter().map(|stop| json!([stop.value, stop.color]));
    json!({ "opacity": knots.collect::<Vec<_>>(), "color": stops.collect::<Vec<_>>() })
}

fn surface(surface: SurfaceReflection) -> Value {
    json!([surface.strength, surface.gradient_per_mm, surface.roughness, surface.specular])
}

fn medium(medium: &Medium) -> Value {
    let rows = medium.gradients.iter().map(|row| json!([row.per_mm, curve(&row.transfer_function)]));
    json!({
        "transfer_function": curve(&medium.transfer_function),
        "gradients": rows.collect::<Vec<_>>(),
        "density": medium.density_scale,
        "albedo": medium.albedo,
        "anisotropy": medium.anisotropy,
        "bounces": medium.max_bounces,
        "filter": match medium.filter {
            Filter::Nearest => "nearest",
            Filter::Trilinear => "trilinear",
            Filter::Tricubic => "tricubic",
            Filter::Smooth => "smooth",
        },
        "surface": surface(medium.surface),
        "extinction_space": match medium.extinction_space {
            ExtinctionSpace::Volume => "volume",
            ExtinctionSpace::World => "world",
        },
    })
}

fn map_of(scene: &Scene) -> Option<&EnvironmentMap> {
    match &scene.environment.source {
        EnvironmentSource::Map(map) => Some(map),
        _ => None,
    }
}

fn environment(scene: &Scene) -> Value {
    let environment = &scene.environment;
    let common = json!({ "strength": environment.strength, "rotation": environment.rotation.to_degrees() });
    let source = match &environment.source {
        EnvironmentSource::Studio => json!({ "source": "studio" }),
        EnvironmentSource::Uniform(color) => json!({ "source": "uniform", "color": color }),
        EnvironmentSource::Gradient { zenith, horizon, nadir } => {
            json!({ "source": "gradient", "zenith": zenith, "horizon": horizon, "nadir": nadir })
        }
        EnvironmentSource::Map(map) => json!({ "source": "map", "shape": [map.height, map.width, 3] }),
    };
    let mut all = common;
    all.as_object_mut()
        .into_iter()
        .for_each(|all| all.extend(source.as_object().cloned().unwrap_or_default()));
    all
}

/// Suns: the command line has no other lights, and a cluster is given none of a scene's.
fn light(light: &Light) -> Result<Value, Failure> {
    match light.kind {
        LightKind::Directional { direction, irradiance, angular_radius } => {
            let from = -direction.normalize_or_zero();
            Ok(json!({
                "azimuth": from.x.atan2(from.z).to_degrees(),
                "elevation": from.y.clamp(-1.0, 1.0).asin().to_degrees(),
                "strength": irradiance[0] / std::f64::consts::PI,
                "degrees": angular_radius.to_degrees(),
            }))
        }
        LightKind::Point(_) | LightKind::Spot { cone: Cone::Power { .. } | Cone::Between { .. }, .. } => {
            Err(Failure::usage("a cluster takes no lights but suns; render the scene here"))
        }
    }
}
