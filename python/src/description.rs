//! Scenes, cameras and requests as Python describes them. A scene comes as its document (`lumivox_core::document`) beside the
//! scans, labels and the map that are in it; cameras and requests are read by the names of their attributes. Lengths are
//! millimetres and angles degrees, as on the command line.

use std::num::NonZeroU32;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use lumivox_core::glam::DVec3;
use lumivox_core::{
    self as core, Environment, EnvironmentMap, PerspectiveCamera,
    document::{self, Display, Film, Look, SceneDocument, View},
    framing,
};
use lumivox_scene::{Notes, OpenErrorKind, Opened, Opening, Part, ReadError, Remedy, assemble, open};
use lumivox_wgpu::RenderRequest;
use pyo3::prelude::*;

use crate::errors;
use crate::fork;
use crate::labels::Labels;
use crate::looks;
use crate::volume::{Rows, Volume, affine};
use crate::wait;

const METRES_PER_MM: f64 = 1e-3;

/// A volume, its labels, and depths below its skin.
type Given = (Py<Volume>, Option<Py<Labels>>, Option<Py<Volume>>);

/// `lumivox.Scene`.
#[derive(FromPyObject)]
pub struct Scene {
    #[pyo3(attribute("_written"))]
    document: String,
    #[pyo3(attribute("_parts"))]
    parts: Vec<Given>,
    #[pyo3(attribute("_map"))]
    map: Option<Py<looks::Map>>,
}

impl Scene {
    fn document(&self) -> PyResult<SceneDocument> {
        SceneDocument::parse_described(&self.document).map_err(|error| errors::value(error.why))
    }

    fn map(&self) -> Option<Arc<EnvironmentMap>> {
        self.map.as_ref().map(|map| map.get().0.clone())
    }

    /// The scene described. Volumes that are placed nowhere share the first one's patient space, its centre at the origin.
    pub fn build(&self) -> PyResult<core::Scene> {
        let document = self.document()?;
        let part = |((volume, labels, depth), entry): (&Given, &document::Entry)| Part {
            volume: volume.get().shared(),
            labels: labels.as_ref().map(|labels| labels.get().shared()),
            peel: (depth.as_ref().zip(entry.peel))
                .map(|(depth, mm)| core::Peel { depth: depth.get().shared(), mm }),
        };
        let parts = self.parts.iter().zip(&document.volumes).map(part).collect();
        assemble(&document, parts, self.map()).map_err(errors::value)
    }

    /// Its light, without what it falls on.
    pub fn environment(&self) -> PyResult<Environment> {
        Ok(self.document()?.environment.environment(self.map()))
    }
}

/// A medium of a look that is written out.
pub fn written_out(look: &str) -> PyResult<core::Medium> {
    let look: Look = serde_json::from_str(look).map_err(errors::words)?;
    let function = look.transfer_function.ok_or_else(|| errors::value("a look needs a transfer function"))?;
    Ok(core::Medium { gradients: look.gradients, ..core::Medium::new(function) }.sanitized())
}

/// `lumivox.Camera`.
#[derive(FromPyObject)]
pub struct Camera {
    world_from_camera: Rows,
    fov: f64,
}

impl Camera {
    /// The camera described.
    pub fn build(&self) -> PerspectiveCamera {
        // Its own space is of metres, too: only where it stands is scaled.
        let mut world_from_camera = affine(self.world_from_camera);
        world_from_camera.translation *= METRES_PER_MM;
        PerspectiveCamera { world_from_camera, vertical_fov: self.fov.to_radians() }
    }
}

/// A camera's place as rows in mm.
fn rows_of(camera: &PerspectiveCamera) -> Rows {
    View::of(camera).world_from_camera.unwrap_or_default()
}

/// A camera around what a scene shows, or at an `eye` in mm, as rows in mm.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "what the command asks for, one by one")]
pub fn frame(
    py: Python<'_>,
    scene: Scene,
    azimuth: Option<f64>,
    elevation: Option<f64>,
    zoom: Option<f64>,
    fov: f64,
    aspect: f64,
    eye: Option<[f64; 3]>,
    target: Option<[f64; 3]>,
) -> PyResult<Rows> {
    let scene = scene.build()?;
    let view = View { azimuth, elevation, zoom, eye, target, fov, ..View::default() };
    let camera = fork::detach(py, || view.camera(&scene, aspect));
    camera.as_ref().map(rows_of).ok_or_else(looks_at_itself)
}

/// Degrees around the vertical and above the horizon from which a scene is seen where nothing is said.
#[pyfunction]
pub fn usual_angles(scene: Scene) -> PyResult<[f64; 2]> {
    let scene = scene.build()?;
    let front = scene.volumes.first().and_then(framing::front);
    Ok(front.unwrap_or_default().map(f64::to_degrees))
}

/// Those of the first volume's labels that are asked for and of which hardly anything is seen.
#[pyfunction]
pub fn unseen_labels(py: Python<'_>, scene: Scene, asked: Vec<u8>) -> PyResult<Vec<u8>> {
    let scene = scene.build()?;
    let first = scene.volumes.first();
    Ok(fork::detach(py, || first.map(|first| first.unseen_labels(&asked)).unwrap_or_default()))
}

/// Writes a scene down, seen by a camera, with the JSON of its film and display.
#[pyfunction]
pub fn save_scene(
    py: Python<'_>,
    path: PathBuf,
    scene: Scene,
    camera: Option<Camera>,
    film: &str,
    display: &str,
) -> PyResult<()> {
    let scene = scene.build()?;
    let film: Film = serde_json::from_str(film).map_err(errors::words)?;
    let display: Display = serde_json::from_str(display).map_err(errors::words)?;
    let camera = camera.map(|camera| View::of(&camera.build())).unwrap_or_default();
    let document = SceneDocument::of(&scene).map_err(errors::value)?;
    let document = SceneDocument { camera, film, display, ..document };
    fork::detach(py, || lumivox_scene::save(&document, &path)).map_err(|error| errors::file(&path, &error))
}

/// What would change what a note tells, in Python's words.
fn remedy(remedy: Remedy) -> Option<String> {
    match remedy {
        // What is hidden is no warning, as of scans that are loaded.
        Remedy::KeepEverything => None,
        Remedy::Density(density) => Some(format!("; \"density\" of its look: {density} is that of a body")),
        _ => Some("; give the label a preset of its own".to_owned()),
    }
}

/// A scene of a file: its document, written out; its volumes, their labels and depths; the light's map; the camera; and what is
/// worth saying.
type Loaded = (String, Vec<Given>, Option<Py<looks::Map>>, Rows, f64, Vec<String>);

/// Opens a scene.
#[pyfunction]
pub fn load_scene(
    py: Python<'_>,
    path: PathBuf,
    allow_outside_data: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Loaded> {
    let written = lumivox_scene::read(&path).map_err(|error| match error {
        ReadError::Io { error, .. } => errors::file(&path, &error),
        error => errors::scan(error),
    })?;
    let opening = Opening { allow_outside_data, identify: true };
    let (opened, notes) = wait::stages(py, progress, |progress, cancel| {
        let listener = Notes::new(progress, remedy);
        let opened = open(&written.document, written.folder(), &opening, &listener, cancel);
        (opened, listener.into_sentences())
    })?;
    let Opened { scene, camera } = opened.map_err(|error| {
        let place = error.place(&written);
        match error.kind {
            OpenErrorKind::Cancelled(_) => errors::cancelled(),
            OpenErrorKind::Import(error) => errors::import_at(&place, *error),
            kind => errors::scan(format!("{place}: {kind}")),
        }
    })?;
    let SceneDocument { film, display, .. } = written.document;
    let described = SceneDocument { film, display, ..SceneDocument::described(&scene) };
    let parts = scene.volumes.iter().map(|instance| {
        let labels = instance.labels.as_ref().map(|labelling| Labels::new(labelling.labels.clone(), true));
        let depth = instance.peel.as_ref().map(|peel| Volume::of(peel.depth.clone()));
        Ok((
            Py::new(py, Volume::of(instance.volume.clone()))?,
            labels.map(|labels| Py::new(py, labels)).transpose()?,
            depth.map(|depth| Py::new(py, depth)).transpose()?,
        ))
    });
    let parts = parts.collect::<PyResult<_>>()?;
    let map = match &scene.environment.source {
        core::EnvironmentSource::Map(map) => Some(Py::new(py, looks::Map(map.clone()))?),
        _ => None,
    };
    let text = described.to_json().map_err(errors::words)?;
    Ok((text, parts, map, rows_of(&camera), camera.vertical_fov.to_degrees(), notes))
}

fn looks_at_itself() -> PyErr {
    errors::value("eye is the point looked at; move it, or give another target")
}

/// A camera at a place in mm that looks at another, as rows in mm.
#[pyfunction]
pub fn look_at(eye: [f64; 3], target: [f64; 3], up: [f64; 3], fov: f64) -> PyResult<Rows> {
    let [eye, target, up] = [eye, target, up].map(DVec3::from_array);
    if eye.distance(target) <= 1e-6 {
        return Err(looks_at_itself());
    }
    let camera =
        PerspectiveCamera::look_at(eye * METRES_PER_MM, target * METRES_PER_MM, up, fov.to_radians());
    Ok(rows_of(&camera))
}

/// `lumivox.rendering.Request`.
#[derive(FromPyObject)]
pub struct Request {
    size: [u32; 2],
    samples: u32,
    time: Option<f64>,
    seed: u32,
    guides: bool,
    first_sample: u32,
    pass_samples: Option<u32>,
    window: Option<[u32; 4]>,
    noise: Option<f64>,
}

impl Request {
    /// The request described.
    pub fn build(&self) -> PyResult<RenderRequest> {
        let [width, height] = self.size;
        let time = self.time.map(Duration::try_from_secs_f64).transpose().map_err(errors::value)?;
        let pass_samples = self.pass_samples.map(|samples| {
            NonZeroU32::new(samples).ok_or_else(|| errors::value("pass_samples must be at least 1"))
        });
        let pass_samples = pass_samples.transpose()?;
        if self.first_sample >= self.samples {
            return Err(errors::value("first_sample must be below samples"));
        }
        Ok(RenderRequest::new(width, height, self.samples).with(|it| {
            it.time = time;
            it.seed = self.seed;
            it.guides = self.guides;
            it.first_sample = self.first_sample;
            it.pass_samples = pass_samples;
            it.noise = self.noise;
            it.window = self.window.map(|[x, y, width, height]| [[x, y], [width, height]]);
        }))
    }
}

/// A map, checked.
pub fn environment_map(width: usize, height: usize, texels: Vec<[f32; 3]>) -> PyResult<Arc<EnvironmentMap>> {
    EnvironmentMap::new(width, height, texels).map(Arc::new).map_err(errors::value)
}
