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
    CancelToken, EnvironmentMap, EnvironmentSource, LabelVolume, PerspectiveCamera, Scene, Volume,
    VolumeInstance, Voxels,
    document::{self, Scan, SceneDocument, View},
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
        for depth in depths(scene) {
            input.write_all(depth.voxels().as_bytes())?;
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

/// All but voxels and texels: the scene's document, and on which grids they lie.
fn header(
    address: &str,
    scene: &Scene,
    camera: &PerspectiveCamera,
    request: &RenderRequest,
) -> Result<Value, Failure> {
    let mut document = SceneDocument { camera: View::of(camera), ..SceneDocument::described(scene) };
    for entry in &mut document.volumes {
        // What files they are of is nobody's business there.
        entry.scan = Scan::default();
        entry.labels.iter_mut().for_each(|labels| (labels.files, labels.table) = (vec![], None));
    }
    let document = serde_json::to_value(&document).map_err(|error| Failure::other(error.to_string()))?;
    let of = |instance: &VolumeInstance| {
        let labels =
            instance.labels.as_ref().map(|labelling| place_of(&label_volumes(scene), &labelling.labels));
        json!({ "labels": labels, "depth": instance.peel.as_ref().map(|peel| place_of(&depths(scene), &peel.depth)) })
    };
    Ok(json!({
        "version": env!("CARGO_PKG_VERSION"),
        "address": address,
        "scene": document,
        "volumes": scene.volumes.iter().map(|instance| grid(&instance.volume)).collect::<Vec<_>>(),
        "labels": label_volumes(scene).iter().map(|labels| labels_of(labels)).collect::<Vec<_>>(),
        "depths": depths(scene).iter().map(|depth| grid(depth)).collect::<Vec<_>>(),
        "parts": scene.volumes.iter().map(of).collect::<Vec<_>>(),
        "map": map_of(scene).map(|map| [map.height, map.width, 3]),
        "size": [request.width, request.height],
        "samples": request.samples,
        "seed": request.seed,
        "guides": request.guides,
    }))
}

/// What volumes share, each once.
fn each_once<'a, T>(all: impl Iterator<Item = &'a Arc<T>>) -> Vec<&'a Arc<T>> {
    let mut once: Vec<&Arc<T>> = vec![];
    for one in all {
        if !once.iter().any(|other| Arc::ptr_eq(other, one)) {
            once.push(one);
        }
    }
    once
}

fn label_volumes(scene: &Scene) -> Vec<&Arc<LabelVolume>> {
    each_once(scene.volumes.iter().filter_map(|instance| instance.labels.as_ref()).map(|l| &l.labels))
}

fn depths(scene: &Scene) -> Vec<&Arc<Volume>> {
    each_once(scene.volumes.iter().filter_map(|instance| instance.peel.as_ref()).map(|peel| &peel.depth))
}

fn place_of<T>(all: &[&Arc<T>], wanted: &Arc<T>) -> Option<usize> {
    all.iter().position(|one| Arc::ptr_eq(one, wanted))
}

fn labels_of(labels: &LabelVolume) -> Value {
    let [x, y, z] = labels.dims();
    let entries = labels.labels().iter().map(|label| json!([label.value, label.name, label.color]));
    // JSON's numbers are no larger.
    let numbers =
        labels.numbers().into_iter().filter_map(|(number, value)| Some((i64::try_from(number).ok()?, value)));
    json!({
        "shape": [z, y, x],
        "patient_from_voxel": document::rows(labels.patient_from_voxel()),
        "entries": entries.collect::<Vec<_>>(),
        "numbers": numbers.collect::<Vec<_>>(),
    })
}

fn grid(volume: &Volume) -> Value {
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
        "patient_from_voxel": document::rows(volume.patient_from_voxel()),
        "modality": inputs::modality(volume).unwrap_or_default(),
        "unit": volume.unit(),
    })
}

fn map_of(scene: &Scene) -> Option<&EnvironmentMap> {
    match &scene.environment.source {
        EnvironmentSource::Map(map) => Some(map),
        _ => None,
    }
}
