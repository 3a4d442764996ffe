//! Files become a session: headers, the best series, the scene of it, thumbnails. All of it is done beside the interface.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use lumivox_core::document::{Entry, SceneDocument, View};
use lumivox_core::{EnvironmentMap, PerspectiveCamera, Preset, Progress, Scene, Volume};
use lumivox_import::files::{self, File};
use lumivox_import::{ImportError, ImportOptions, ImportReport, SeriesSummary, Study, Thumbnail};
use lumivox_scene::{Notes, OpenErrorKind, Opening, Part, Remedy};

use crate::jobs::Desk;

/// A study, for the job that loads another of its series. Its headers are read once where that job shares memory with the one
/// before, and again where it does not.
#[derive(Clone)]
pub struct SharedStudy {
    files: Arc<[PathBuf]>,
    study: Arc<Mutex<Option<Study>>>,
}

impl SharedStudy {
    /// That of these files, of which nothing is read yet.
    pub fn of(files: &[PathBuf]) -> Self {
        Self { files: files.into(), study: Arc::default() }
    }

    fn read(files: &[PathBuf], study: Study) -> Self {
        Self { files: files.into(), study: Arc::new(Mutex::new(Some(study))) }
    }

    /// Its files and folders.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Whether it is the same.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.study, &other.study)
    }

    /// Works with it; reads it before where that was not done.
    fn locked<M: Send, T>(&self, desk: &Desk<M>, work: impl FnOnce(&mut Study) -> T) -> Result<T, String> {
        let mut study = self.study.lock().unwrap_or_else(PoisonError::into_inner);
        if study.is_none() {
            let options = ImportOptions::default();
            let open = |progress: Progress<'_>| Study::open(&self.files, &options, progress, desk.cancel());
            *study = Some(desk.watch(open).map_err(words)?);
        }
        study.as_mut().map(work).ok_or_else(String::new)
    }
}

/// The side of thumbnails, in pixels.
const THUMBNAIL: usize = 160;

/// What is opened.
#[derive(Clone)]
pub enum Source {
    /// Files and folders: a scan, or a scene's file.
    Files(Vec<PathBuf>),
    /// Another series of a study, by its place in the list.
    Series(SharedStudy, usize),
}

/// What is told while something is opened.
pub enum Told {
    /// What could be loaded, and what is.
    Series {
        /// All of it, the best first.
        series: Vec<SeriesSummary>,
        /// Which of them is loaded now.
        chosen: usize,
        /// To load another.
        study: SharedStudy,
    },
    /// A picture of a series, by its place in the list.
    Thumbnail(usize, Thumbnail),
    /// It is there.
    Opened(Box<Opened>),
    /// A scan is read, and its slices can be seen. What of it is shown is still looked for: its scene has all that was scanned.
    Scan(Box<Opened>),
    /// What tells the scan that was told before from others, as documents say it.
    Content(String),
    /// What is shown of the scan that was told before, and what is worth telling of that.
    Found(Scene, Vec<String>),
    /// Why it is not, in a sentence that names the file.
    Failed(String),
}

/// A scene with all that it was made of.
pub struct Opened {
    /// What it is, with whole paths.
    pub document: SceneDocument,
    /// Scans as they lie in their files.
    pub scans: Vec<Arc<Volume>>,
    /// What there is to see.
    pub scene: Scene,
    /// From where.
    pub camera: PerspectiveCamera,
    /// Whether nobody said so: then all that is seen is to fit the view.
    pub is_framed: bool,
    /// How the first scan was read.
    pub report: ImportReport,
    /// What else is worth telling.
    pub notes: Vec<String>,
}

/// Opens, and tells all about it.
pub fn open(source: Source, desk: &Desk<Told>) {
    let opened = match &source {
        // A scene may come with the scan that it names.
        Source::Files(files) => match files.iter().find(|file| is_scene(file)) {
            Some(scene) => open_scene(scene, desk),
            None => open_study(files, desk),
        },
        Source::Series(study, place) => open_series(study.clone(), *place, desk),
    };
    match opened {
        Ok(()) => {}
        Err(why) if !desk.cancel().is_cancelled() => desk.tell(Told::Failed(why)),
        Err(_) => {}
    }
}

/// Whether a file is a scene's, by how it begins.
fn is_scene(file: &Path) -> bool {
    let mut beginning = vec![];
    let read = File::open(file).and_then(|file| file.take(4096).read_to_end(&mut beginning));
    files::is_file(file) && read.is_ok() && SceneDocument::is_one(&beginning)
}

fn open_study(files: &[PathBuf], desk: &Desk<Told>) -> Result<(), String> {
    let options = ImportOptions::default();
    let study =
        desk.watch(|progress| Study::open(files, &options, progress, desk.cancel())).map_err(words)?;
    let chosen = study.report().chosen;
    if study.report().series.is_empty() {
        let why = study
            .report()
            .skipped
            .first()
            .map_or(String::new(), |file| format!(": {}: {}", file.path.display(), file.reason));
        let folder = files.first().map_or(String::new(), |file| file.display().to_string());
        return Err(format!("{folder}: there is no series of images that makes up a volume{why}"));
    }
    let study = SharedStudy::read(files, study);
    open_series(study.clone(), chosen, desk)?;
    tell_thumbnails(&study, desk)
}

fn words(error: ImportError) -> String {
    error.to_string()
}

/// Loads a series of a study, and makes the scene of it that suits.
fn open_series(study: SharedStudy, place: usize, desk: &Desk<Told>) -> Result<(), String> {
    let series = study.locked(desk, |study| study.report().series.clone())?;
    let mut options = ImportOptions::default();
    if series.len() > 1 {
        options.series = Some((place + 1).to_string());
    }
    desk.tell(Told::Series { series, chosen: place, study: study.clone() });
    let load = |study: &mut Study| {
        desk.watch(|progress| study.load(&options, progress, desk.cancel())).map_err(words)
    };
    let imported = study.locked(desk, load)??;
    present(imported.volume, imported.report, desk)
}

/// Makes the scene of a volume that suits: its slices can be seen before what is shown of it is found.
///
/// # Errors
/// Why it cannot be shown.
pub fn present(volume: Volume, report: ImportReport, desk: &Desk<Told>) -> Result<(), String> {
    let source = volume.source().cloned().unwrap_or_default();
    let is_of_file = volume.source().is_some_and(|scan| scan.content.is_none());
    let scan = lumivox_core::document::Scan { keep: Default::default(), taken_off: None, ..source };
    let mut document = SceneDocument { volumes: vec![Entry::new(scan)], ..SceneDocument::default() };
    let scans = vec![Arc::new(volume)];
    find_looks(&mut document, &scans);
    // Looking for the patient takes longer than to read one. Slices do not wait for it.
    let whole = scans.iter().map(|scan| Part { volume: scan.clone(), labels: None, peel: None });
    let scene =
        lumivox_scene::assemble(&document, whole.collect(), None).map_err(|error| error.to_string())?;
    let camera = camera(&document, &scene)?;
    let (notes, is_framed) = (vec![], true);
    let read =
        Opened { document: document.clone(), scans: scans.clone(), scene, camera, is_framed, report, notes };
    desk.tell(Told::Scan(Box::new(read)));
    let mut content = None;
    let scan = scans[0].clone();
    let shown = rayon::in_place_scope(|scope| {
        if is_of_file {
            scope.spawn(|_| content = Some(lumivox_scene::content_of(&scan)));
        }
        show(&document, scans, desk)
    });
    content.into_iter().for_each(|content| desk.tell(Told::Content(content)));
    let (scene, notes) = shown?;
    desk.tell(Told::Found(scene, notes));
    Ok(())
}

/// Which look suits is found once, and is the first thing that a person may change.
fn find_looks(document: &mut SceneDocument, scans: &[Arc<Volume>]) {
    for (entry, scan) in document.volumes.iter_mut().zip(scans) {
        if entry.look.preset.is_none() && entry.look.transfer_function.is_none() {
            entry.look.preset = Some(Preset::default_for(scan));
        }
    }
}

fn camera(document: &SceneDocument, scene: &Scene) -> Result<PerspectiveCamera, String> {
    let camera = document.camera.camera(scene, document.film.aspect());
    camera.ok_or_else(|| "the camera is the point looked at".to_owned())
}

/// What a note's remedy is called here: the switch that does it.
fn remedy(remedy: Remedy) -> Option<String> {
    Some(match remedy {
        Remedy::KeepEverything => " (All that was scanned shows it)".to_owned(),
        _ => String::new(),
    })
}

/// The scene of scans that are loaded.
fn assemble(
    mut document: SceneDocument,
    scans: Vec<Arc<Volume>>,
    report: ImportReport,
    mut notes: Vec<String>,
    desk: &Desk<Told>,
) -> Result<(), String> {
    find_looks(&mut document, &scans);
    let (scene, told) = show(&document, scans.clone(), desk)?;
    notes.extend(told);
    let is_framed = document.camera == View::default();
    let camera = camera(&document, &scene)?;
    desk.tell(Told::Opened(Box::new(Opened { document, scans, scene, camera, is_framed, report, notes })));
    Ok(())
}

/// What showing a scan anew tells: the scene with what is worth telling, or why there is none.
pub type Shown = Result<(Scene, Vec<String>), String>;

/// What of scans is shown, with what is told of it.
///
/// # Errors
/// Why nothing is.
pub fn show<M: Send>(document: &SceneDocument, scans: Vec<Arc<Volume>>, desk: &Desk<M>) -> Shown {
    desk.watch(|progress| {
        let notes = Notes::new(progress, remedy);
        let opening = Opening { identify: true, ..Opening::default() };
        let opened =
            lumivox_scene::open_loaded(document, scans, Path::new(""), &opening, &notes, desk.cancel());
        opened.map(|opened| (opened.scene, notes.into_sentences())).map_err(|error| error.to_string())
    })
}

/// What is shown of scans, of which lassos cut away something else now.
///
/// # Errors
/// Why it is not.
pub fn cut_anew<M: Send>(
    document: &SceneDocument,
    parts: Vec<Part>,
    map: Option<Arc<EnvironmentMap>>,
    desk: &Desk<M>,
) -> Shown {
    desk.watch(|progress| {
        let notes = Notes::new(progress, remedy);
        let scene = lumivox_scene::cut_anew(document, parts, map, &notes, desk.cancel());
        scene.map(|scene| (scene, notes.into_sentences())).map_err(|error| error.to_string())
    })
}

/// Opens a scene's file: its first scan is the one that slices show.
fn open_scene(file: &Path, desk: &Desk<Told>) -> Result<(), String> {
    let written = lumivox_scene::read(file).map_err(|error| error.to_string())?;
    let folder = files::absolute(written.folder()).unwrap_or_else(|_| written.folder().to_owned());
    let mut document = written.document.clone();
    if document.volumes.is_empty() {
        return Err(format!("{}: the scene names no scan", file.display()));
    }
    let opening = Opening { identify: true, ..Opening::default() };
    let (scans, notes) = desk.watch(|progress| {
        let notes = Notes::new(progress, remedy).with_lines(&written);
        let scans = lumivox_scene::load_scans(&document, &folder, &opening, &notes, desk.cancel());
        let place = |error: lumivox_scene::OpenError| match &error.kind {
            OpenErrorKind::Cancelled(_) => error.to_string(),
            _ => format!("{}: {error}", error.place(&written)),
        };
        scans.map(|scans| (scans, notes.into_sentences())).map_err(place)
    })?;
    with_whole_paths(&mut document, &folder);
    let report = scans.first().map(|scan| (*scan.report).clone()).unwrap_or_default();
    let first = document.volumes.first().map(|entry| entry.scan.clone());
    let volumes = scans.into_iter().map(|scan| scan.volume).collect();
    assemble(document, volumes, report, notes, desk)?;
    // Its other series, for the strip.
    if let Some(scan) = first
        && let Ok(options) = ImportOptions::of_scan(&scan)
        && let Ok(study) = desk.watch(|progress| Study::open(&scan.files, &options, progress, desk.cancel()))
    {
        let (series, chosen) = (study.report().series.clone(), study.report().chosen);
        let study = SharedStudy::read(&scan.files, study);
        desk.tell(Told::Series { series, chosen, study: study.clone() });
        tell_thumbnails(&study, desk)?;
    }
    Ok(())
}

/// Every file of a document by its whole path, so that it can be saved anywhere.
fn with_whole_paths(document: &mut SceneDocument, folder: &Path) {
    for entry in &mut document.volumes {
        entry.scan.files.iter_mut().for_each(|file| *file = folder.join(&file));
        if let Some(labels) = &mut entry.labels {
            labels.files.iter_mut().chain(&mut labels.table).for_each(|file| *file = folder.join(&file));
        }
    }
    if let Some(map) = document.environment.file().map(|file| folder.join(file)) {
        document.environment.source = map;
    }
}

/// One after the other; what cannot be decoded has none.
fn tell_thumbnails(study: &SharedStudy, desk: &Desk<Told>) -> Result<(), String> {
    for place in 0..study.locked(desk, |study| study.report().series.len())? {
        if desk.cancel().is_cancelled() {
            break;
        }
        let draw = |study: &mut Study| study.thumbnail(place, THUMBNAIL, desk.cancel());
        if let Ok(picture) = study.locked(desk, draw)? {
            desk.tell(Told::Thumbnail(place, picture));
        }
    }
    Ok(())
}
