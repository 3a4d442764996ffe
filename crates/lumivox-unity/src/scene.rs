//! Scene documents for Unity: a document is opened on a job's thread, and its parts are handed over in Unity's conventions; its
//! light by `scene_light.rs`.

use std::ffi::c_char;
use std::path::{Path, PathBuf};

use lumivox_core::document::{Backdrop, SceneDocument, Tone, View};
use lumivox_core::{CancelToken, EnvironmentSource, PerspectiveCamera, Progress, Scene, VolumeInstance};
use lumivox_core::{ExtinctionSpace, Filter, LabelStyle, Medium};
use lumivox_scene::{Notes, OpenError, OpenErrorKind, Opening, Remedy};
use serde_json::Value;

use crate::abi::*;
use crate::border::{
    LumivoxText, Outcome, free, guard, guard_handle, guard_option, guard_status, known, known_mut, path,
};
use crate::convert;
use crate::jobs::{LumivoxJob, Made, start, take};
use crate::look::{LumivoxMap, LumivoxTransferFunction};
use crate::pose::{self, Pose};
use crate::volume::LumivoxVolume;

/// A scene document that was opened.
pub struct LumivoxScene {
    document: SceneDocument,
    pub(crate) scene: Scene,
    camera: PerspectiveCamera,
    parts: Vec<Part>,
    pub(crate) map: Option<LumivoxMap>,
    notes: Vec<String>,
    files: Vec<PathBuf>,
}

/// What is handed over of a volume.
struct Part {
    volume: LumivoxVolume,
    labels: Option<LumivoxVolume>,
    pose: Pose,
    /// In the volume's object.
    clips: Vec<Pose>,
    /// Of the styles of its labels.
    functions: Vec<Option<Box<LumivoxTransferFunction>>>,
}

/// Opens a scene document. The job gives the scene.
///
/// # Safety
/// `file` is a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_open(file: *const c_char, allow_outside_data: u32) -> *mut LumivoxJob {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let file = unsafe { path(file, "file") }?;
        let opening = Opening { allow_outside_data: allow_outside_data != 0, identify: true };
        start(move |progress, cancel| LumivoxScene::open(&file, &opening, progress, cancel).map(Made::scene))
    })
}

/// The scene that a job has opened.
///
/// # Safety
/// `job` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_job_take_scene(job: *mut LumivoxJob) -> *mut LumivoxScene {
    // SAFETY: as the caller promises.
    unsafe { take(job, Made::take_scene) }
}

/// Whether a file is a scene document, by how it begins: 1 or 0; -1 where it cannot be read.
///
/// # Safety
/// `file` is a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_is_one(file: *const c_char) -> i32 {
    use std::io::Read;
    let is_one = guard(|| {
        // SAFETY: as the caller promises.
        let file = unsafe { path(file, "file") }?;
        let mut beginning = vec![];
        std::fs::File::open(&file)
            .and_then(|open| open.take(4096).read_to_end(&mut beginning))
            .map_err(|error| format!("cannot read {}: {error}", file.display()))?;
        Ok(SceneDocument::is_one(&beginning))
    });
    is_one.map_or(-1, i32::from)
}

/// Frees a scene. What was taken of it goes on.
///
/// # Safety
/// `scene` is null, or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_free(scene: *mut LumivoxScene) {
    // SAFETY: as the caller promises.
    unsafe { free(scene) };
}

/// What would change what a note tells, in the words of documents.
fn remedy(remedy: Remedy) -> Option<String> {
    Some(match remedy {
        Remedy::KeepEverything => " (\"keep\": \"everything\" of the scan leaves it there)".to_owned(),
        Remedy::Density(density) => format!(" (\"density\": {density} of the look undoes that)"),
        Remedy::LabelPreset => " (a \"preset\" of the label's style shows it)".to_owned(),
        _ => String::new(),
    })
}

impl LumivoxScene {
    fn open(file: &Path, opening: &Opening, progress: Progress<'_>, cancel: &CancelToken) -> Outcome<Self> {
        let written = lumivox_scene::read(file).map_err(|error| error.to_string())?;
        let placed = |error: OpenError| match &error.kind {
            OpenErrorKind::Cancelled(cancelled) => cancelled.to_string(),
            kind => format!("{}: {kind}", error.place(&written)),
        };
        let (document, folder) = (&written.document, written.folder());
        let told = Notes::new(progress, remedy).with_lines(&written);
        let loaded = lumivox_scene::load_scans(document, folder, opening, &told, cancel).map_err(placed)?;
        let mut notes = told.into_sentences();
        for (index, scan) in loaded.iter().enumerate().filter(|(_, scan)| !scan.is_shared) {
            let place = written.place(&["volumes".into(), index.into(), "scan".into()]);
            notes.extend(scan.report.notes.iter().map(|note| format!("{place}: {note}")));
        }
        let scans = loaded.into_iter().map(|scan| scan.volume).collect();
        let told = Notes::new(progress, remedy);
        let opened = lumivox_scene::open_loaded(document, scans, folder, opening, &told, cancel);
        let lumivox_scene::Opened { scene, camera } = opened.map_err(placed)?;
        let part = |(index, instance)| Part::new(index, instance).map_err(placed);
        let parts = scene.volumes.iter().enumerate().map(part).collect::<Outcome<_>>()?;
        let map = match &scene.environment.source {
            EnvironmentSource::Map(map) => Some(LumivoxMap(map.clone())),
            _ => None,
        };
        let files = files(document).map(|file| folder.join(file)).collect();
        notes.extend(told.into_sentences());
        Ok(Self { document: document.clone(), scene, camera, parts, map, notes, files })
    }

    fn instance(&self, index: u32) -> Outcome<(&VolumeInstance, &Part)> {
        let found = self.scene.volumes.get(index as usize).zip(self.parts.get(index as usize));
        found.ok_or_else(|| format!("the scene has no volume {index}"))
    }
}

/// All that a document names.
fn files(document: &SceneDocument) -> impl Iterator<Item = &Path> {
    let of_entries = document.volumes.iter().flat_map(|entry| {
        let labels = entry.labels.iter().flat_map(|labels| labels.files.iter().chain(&labels.table));
        entry.scan.files.iter().chain(labels).map(PathBuf::as_path)
    });
    of_entries.chain(document.environment.file())
}

impl Part {
    fn new(index: usize, instance: &VolumeInstance) -> Result<Self, OpenError> {
        let wrong = |keys, what: &str| {
            let why = format!(
                "{what} is slanted, as no object of Unity's can be: it takes a turn, a place and a scale along its own axes"
            );
            OpenError::of(index, keys, OpenErrorKind::Wrong(why))
        };
        let object_from_node = pose::object_from_node(instance);
        let volume = LumivoxVolume::of_another(instance.volume.clone());
        if let Some(peel) = &instance.peel {
            volume.keep_skin(Some(peel.depth.clone()));
        }
        let clips = instance.clip_shapes.iter().map(|shape| pose::of_clip(shape, &instance.volume));
        let labels = instance.labels.as_ref();
        Ok(Self {
            volume,
            labels: labels
                .map(|labelling| LumivoxVolume::of_shared_labels(labelling.labels.clone(), Value::Null)),
            pose: Pose::of(object_from_node).ok_or_else(|| wrong(&["world_from_patient"], "the scan"))?,
            clips: clips
                .map(|pose| pose.ok_or_else(|| wrong(&["clip_shapes"], "a shape")))
                .collect::<Result<_, _>>()?,
            functions: labels.map_or_else(Vec::new, |labelling| {
                let function = |style: &LabelStyle| {
                    let own = style.transfer_function.clone()?;
                    Some(Box::new(LumivoxTransferFunction::new(own, vec![])))
                };
                labelling.styles.iter().map(|(_, style)| function(style)).collect()
            }),
        })
    }
}

/// What people should know of a scene, a line each; empty where all is well.
///
/// # Safety
/// `scene` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_notes(scene: *const LumivoxScene) -> *mut LumivoxText {
    // SAFETY: as the caller promises.
    guard_handle(|| Ok(LumivoxText::new(&unsafe { known(scene, "scene") }?.notes.join("\n"))))
}

/// The document of a scene as it was opened, written out: what 32 bits would round of it is kept in this, for
/// `lumivox_stage_save_world`. It names no files: players of a built game need not know whose they were.
///
/// # Safety
/// `scene` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_document(scene: *const LumivoxScene) -> *mut LumivoxText {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let opened = unsafe { known(scene, "scene") }?;
        let mut document = SceneDocument {
            camera: View { fov: opened.document.camera.fov, ..View::of(&opened.camera) },
            film: opened.document.film,
            display: opened.document.display,
            ..SceneDocument::described(&opened.scene)
        };
        for entry in &mut document.volumes {
            entry.scan = Default::default();
            if let Some(labels) = &mut entry.labels {
                labels.files.clear();
                labels.table = None;
            }
        }
        // As it was said: by way of radians it would be a little less.
        document.environment.rotation = opened.document.environment.rotation;
        if document.environment.file().is_some() {
            document.environment.source = Default::default();
        }
        Ok(LumivoxText::new(&document.to_json().map_err(|error| error.to_string())?))
    })
}

/// The files that a scene names, a line each, as seen from where the program is.
///
/// # Safety
/// `scene` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_files(scene: *const LumivoxScene) -> *mut LumivoxText {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let files = &unsafe { known(scene, "scene") }?.files;
        let files: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
        Ok(LumivoxText::new(&files.join("\n")))
    })
}

/// How many volumes a scene has.
///
/// # Safety
/// `scene` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_volume_count(scene: *const LumivoxScene) -> u32 {
    // SAFETY: as the caller promises.
    guard(|| Ok(unsafe { known(scene, "scene") }?.parts.len() as u32)).unwrap_or(0)
}

/// A volume's scan.
///
/// # Safety
/// `scene` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_volume(scene: *const LumivoxScene, index: u32) -> *mut LumivoxVolume {
    // SAFETY: as the caller promises.
    guard_handle(|| Ok(unsafe { known(scene, "scene") }?.instance(index)?.1.volume.share()))
}

/// A volume's label map; null where it has none, and `lumivox_last_error` then says nothing.
///
/// # Safety
/// `scene` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_labels(scene: *const LumivoxScene, index: u32) -> *mut LumivoxVolume {
    guard_option(|| {
        // SAFETY: as the caller promises.
        let part = unsafe { known(scene, "scene") }?.instance(index)?.1;
        Ok(part.labels.as_ref().map(LumivoxVolume::share))
    })
}

/// A volume's transfer function.
///
/// # Safety
/// `scene` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_transfer_function(
    scene: *const LumivoxScene,
    index: u32,
) -> *mut LumivoxTransferFunction {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let medium = &unsafe { known(scene, "scene") }?.instance(index)?.0.medium;
        Ok(LumivoxTransferFunction::new(medium.transfer_function.clone(), medium.gradients.clone()))
    })
}

/// How a volume stands, without handles; `clip_count` shapes cut it, see `lumivox_scene_clip`.
///
/// # Safety
/// `scene` is a live handle, `out` and `pose` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_instance(
    scene: *const LumivoxScene,
    index: u32,
    out: *mut LumivoxInstance,
    pose: *mut LumivoxPose,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (scene, out, pose) = unsafe {
            (known(scene, "scene")?, known_mut(out, "place for it")?, known_mut(pose, "place for its pose")?)
        };
        let (instance, part) = scene.instance(index)?;
        let [clip_min, clip_max] = pose::clip_corners(instance);
        *pose = part.pose.narrow();
        *out = LumivoxInstance {
            volume: std::ptr::null(),
            part: std::ptr::null(),
            transfer_function: std::ptr::null(),
            labelling: std::ptr::null(),
            world_from_object: pose::matrix(pose::object_from_node(instance)),
            clip_min,
            clip_max,
            layers: instance.layers,
            medium: medium(&instance.medium),
            peel_mm: instance.peel.as_ref().map_or(0.0, |peel| peel.mm as f32),
            first_clip: 0,
            clip_count: part.clips.len() as u32,
        };
        Ok(())
    })
}

fn medium(medium: &Medium) -> LumivoxMedium {
    LumivoxMedium {
        density: medium.density_scale as f32,
        albedo: medium.albedo as f32,
        anisotropy: medium.anisotropy as f32,
        max_bounces: medium.max_bounces,
        filter: match medium.filter {
            Filter::Nearest => 0,
            Filter::Trilinear => 1,
            Filter::Tricubic => 2,
            Filter::Smooth => 3,
        },
        extinction_space: match medium.extinction_space {
            ExtinctionSpace::Volume => 0,
            ExtinctionSpace::World => 1,
        },
        surface: convert::surface(medium.surface),
    }
}

/// A shape that cuts a volume, and where it stands in the volume's object.
///
/// # Safety
/// `scene` is a live handle, `out` and `pose` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_clip(
    scene: *const LumivoxScene,
    index: u32,
    clip: u32,
    out: *mut LumivoxClipShape,
    pose: *mut LumivoxPose,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (scene, out, pose) = unsafe {
            (known(scene, "scene")?, known_mut(out, "place for it")?, known_mut(pose, "place for its pose")?)
        };
        let (instance, part) = scene.instance(index)?;
        let found = instance.clip_shapes.get(clip as usize).zip(part.clips.get(clip as usize));
        let (shape, own) = found.ok_or_else(|| format!("the volume has no shape {clip}"))?;
        *pose = own.narrow();
        *out = LumivoxClipShape {
            world_from_shape: own.matrix(),
            kind: pose::clip_kind(shape.kind),
            inverted: u32::from(shape.inverted),
        };
        Ok(())
    })
}

/// How many labels of a volume have a style.
///
/// # Safety
/// `scene` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_style_count(scene: *const LumivoxScene, index: u32) -> u32 {
    // SAFETY: as the caller promises.
    guard(|| Ok(unsafe { known(scene, "scene") }?.instance(index)?.1.functions.len() as u32)).unwrap_or(0)
}

/// A style of a volume's labels; its transfer function is the scene's.
///
/// # Safety
/// `scene` is a live handle, `out` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_style(
    scene: *const LumivoxScene,
    index: u32,
    style: u32,
    out: *mut LumivoxLabelStyle,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (scene, out) = unsafe { (known(scene, "scene")?, known_mut(out, "place for it")?) };
        let (instance, part) = scene.instance(index)?;
        let styles = instance.labels.as_ref().map_or(&[][..], |labelling| &labelling.styles);
        let found = styles.get(style as usize).zip(part.functions.get(style as usize));
        let ((value, style), function) = found.ok_or_else(|| format!("the volume has no style {style}"))?;
        let surface = style.surface.unwrap_or(instance.medium.surface);
        *out = LumivoxLabelStyle {
            value: u32::from(*value),
            visible: u32::from(style.visible),
            painted: u32::from(style.color.is_some()),
            clipped: u32::from(style.clipped),
            color: style.color.unwrap_or([1.0; 3]).map(|c| c as f32),
            opacity: style.opacity as f32,
            density: style.density_scale.map_or(-1.0, |density| density as f32),
            has_surface: u32::from(style.surface.is_some()),
            surface: convert::surface(surface),
            transfer_function: function.as_deref().map_or(std::ptr::null(), std::ptr::from_ref),
        };
        Ok(())
    })
}

/// From where a scene is seen, its image and display.
///
/// # Safety
/// `scene` is a live handle, `out` and `pose` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_view(
    scene: *const LumivoxScene,
    out: *mut LumivoxSavedView,
    pose: *mut LumivoxPose,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (scene, out, pose) = unsafe {
            (known(scene, "scene")?, known_mut(out, "place for it")?, known_mut(pose, "place for its pose")?)
        };
        let SceneDocument { film, display, .. } = &scene.document;
        *pose = Pose::of_camera(scene.camera.world_from_camera).narrow();
        *out = LumivoxSavedView {
            world_from_camera: convert::object_from(scene.camera.world_from_camera),
            field_of_view: scene.camera.vertical_fov.to_degrees() as f32,
            width: film.size[0],
            height: film.size[1],
            samples: film.samples.unwrap_or(0),
            seed: film.seed,
            noise: film.noise.unwrap_or(0.0) as f32,
            denoise: u32::from(film.denoise),
            background: match display.background {
                Backdrop::Transparent => 0,
                Backdrop::Environment => 1,
                Backdrop::Color(_) => 2,
            },
            color: match display.background {
                Backdrop::Color(color) => color.map(|c| f32::from(c) / 255.0),
                _ => [0.0; 3],
            },
            exposure: display.exposure as f32,
            tone: match display.tone {
                Tone::Plain => 0,
                Tone::Agx => 1,
                Tone::Aces => 2,
            },
            gamma: display.gamma as f32,
        };
        Ok(())
    })
}
