//! Imports on a thread of their own, for editors and games that go on meanwhile.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use godot::classes::image::Format;
use godot::classes::{Image, PackedScene};
use godot::global::Error;
use godot::prelude::*;
use lumivox_core::{CancelToken, LabelVolume, Progress, Volume, WorkStage};
use lumivox_import::{LabelOptions, RawDescription, Study, Thumbnail};

use crate::load_options::{LoadOptions, Loaded};
use crate::resources::{LumivoxLabels, LumivoxVolume, Options, report_dictionary};
use crate::scene_file::{self, OpenedScene};
use crate::{codecs, convert};

/// What is under way. Its owner may have dropped it; it lives until its last signal.
#[derive(PartialEq)]
struct Running(Gd<LumivoxImporter>);

// SAFETY: the engine counts references atomically, and the cell around an importer lets one thread at a time
// change it.
unsafe impl Send for Running {}

/// Everything that is under way, whichever thread began it.
fn running() -> MutexGuard<'static, Vec<Running>> {
    static RUNNING: Mutex<Vec<Running>> = Mutex::new(vec![]);
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What the thread tells.
enum Event {
    Progress(WorkStage, u64, u64),
    Ended(Result<Outcome, Failure>),
}

/// Why it came to nothing, as a sentence.
struct Failure(String);

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self(error.to_string())
    }
}

/// What a thread has found: the files whose headers it has read, or a volume of them.
enum Outcome {
    Scanned(Box<Study>),
    /// With the study that it came from, if there was one.
    Imported(Box<Loaded>, Option<(usize, SharedStudy)>),
    /// With what is to be known of them.
    Labelled(Box<LabelVolume>, Vec<String>),
    /// With what it is called.
    Opened(Box<OpenedScene>, String),
}

/// What is done with files.
enum Task {
    /// Their headers are read.
    Scan,
    /// A volume is loaded from them; from a study of them, if there is one.
    Import(Option<SharedStudy>),
    /// Labels are found in a scan.
    FindLabels(Arc<Volume>),
    /// Labels are loaded.
    LoadLabels,
    /// A scene file is opened; headers may name data anywhere if it says so.
    OpenScene(bool),
}

/// What a thread that pictures a series and one that loads it take turns at.
type SharedStudy = Arc<Mutex<Study>>;

struct Job {
    source: Source,
    cancel: CancelToken,
    events: Receiver<Event>,
    thread: JoinHandle<()>,
}

/// A picture of a series that is being made.
struct Picture {
    series: i64,
    cancel: CancelToken,
    /// What became of it; none if the slice cannot be decoded.
    made: Receiver<Option<Thumbnail>>,
    thread: JoinHandle<()>,
}

/// What was found by reading headers.
struct Known {
    source: Source,
    /// How many series there are.
    series: usize,
    study: SharedStudy,
}

/// What a study was read from.
#[derive(Clone, PartialEq)]
struct Source {
    paths: Vec<PathBuf>,
    /// What was said of a RAW file.
    raw: Option<RawDescription>,
}

/// Loads scans, labels and scene files without holding up the editor or the game: DICOM files, folders and zip archives, NIfTI, NRRD, MetaImage
/// and RAW. Every thread may call it; signals are emitted on the main thread, before a frame. An importer that nobody
/// holds any more goes on until its last signal. JPEG-LS and JPEG 2000 are decoded by a program of their own,
/// [code]lumivox-codecs[/code] beside the extension's library, so that a damaged file which crashes the decoder costs a
/// slice and not the engine; without that program, in this process.
///
/// [codeblock]
/// var importer := LumivoxImporter.new()
/// importer.finished.connect(func(volume): $LumivoxVolume3D.volume = volume)
/// importer.failed.connect(func(message): print(message))
/// importer.start(["user://scan"])
/// [/codeblock]
#[derive(GodotClass)]
#[class(tool, init, base = RefCounted)]
pub struct LumivoxImporter {
    job: Option<Job>,
    picture: Option<Picture>,
    /// What was read last, so that it is not read again.
    known: Option<Known>,
    base: Base<RefCounted>,
}

#[godot_api]
impl LumivoxImporter {
    /// How far it is: [param done] of [param total] steps of [param stage], a phrase for people. At most once per
    /// frame; stages follow each other, and each counts anew.
    #[signal]
    pub fn progress(stage: GString, done: i64, total: i64);

    /// What [method scan] was asked for is known. See [method LumivoxVolume.get_report] for what is in [param report].
    #[signal]
    pub fn scanned(report: VarDictionary);

    /// What [method start] was asked for is loaded. [param volume] is saved nowhere yet.
    #[signal]
    pub fn finished(volume: Gd<LumivoxVolume>);

    /// What [method find_labels] or [method load_labels] was asked for is there. [param labels] is saved nowhere yet.
    #[signal]
    pub fn labelled(labels: Gd<LumivoxLabels>);

    /// What [method open_scene] was asked for is there: add an instance of [param scene] where it is to be seen. What
    /// is worth telling of it, such as that a scan is another than it was, is in [param notes], as sentences.
    #[signal]
    pub fn scene_opened(scene: Gd<PackedScene>, notes: PackedStringArray);

    /// A scan or an import came to nothing; [param message] says why and what to do. It names files, but no patient.
    #[signal]
    pub fn failed(message: GString);

    /// A scan or an import was stopped by [method cancel].
    #[signal]
    pub fn cancelled();

    /// The picture that [method request_thumbnail] asked for, of the series in place [param series] of the report.
    /// [param image] is [code]null[/code] if the slice cannot be decoded.
    #[signal]
    pub fn thumbnail_ready(series: i64, image: Option<Gd<Image>>);

    /// Finds out what [param paths] hold, from the headers of DICOM files alone, and emits [signal scanned]. A
    /// [method start] of the same paths afterwards does not read the headers again. Paths may begin with
    /// [code]res://[/code] or [code]user://[/code]. [param options] are those of [method start]; only
    /// [code]raw[/code] matters here. Returns [constant ERR_BUSY] while a scan or an import is under way,
    /// [constant ERR_INVALID_PARAMETER] without paths or if the options cannot be understood, and
    /// [constant ERR_CANT_FORK] if there is no thread for it; of these nothing is emitted. Whatever else is wrong,
    /// [signal failed] says.
    #[func]
    pub fn scan(
        &mut self,
        paths: PackedStringArray,
        #[opt(default = &Options::none())] options: Options,
    ) -> Error {
        self.launch(Task::Scan, &paths, &options)
    }

    /// The middle slice of a series that [method scan] has found, as a grey image of at most [param size] pixels along
    /// a side, 1 to 4096; [param series] is its place in the report, from 0. Decodes one slice, and waits for it.
    /// [code]null[/code] before [signal scanned], while an import is under way, if there is no such series, and if the
    /// slice cannot be decoded.
    #[func]
    pub fn thumbnail(&self, series: i64, #[opt(default = 128)] size: i64) -> Option<Gd<Image>> {
        let (study, series, size) = self.pictured(series, size)?;
        codecs::name_worker();
        let study = study.lock().unwrap_or_else(PoisonError::into_inner);
        image(study.thumbnail(series, size, &CancelToken::new()).ok()?)
    }

    /// Makes the picture of [method thumbnail] without waiting, and emits [signal thumbnail_ready]. A request that is
    /// not done yet gives way to the next one, to [method cancel], and to [method scan] and [method start]: of those
    /// nothing is emitted. Returns [constant ERR_UNAVAILABLE] where there is no such series: before [signal scanned]
    /// and while an import is under way there is none.
    #[func]
    pub fn request_thumbnail(&mut self, series: i64, #[opt(default = 128)] size: i64) -> Error {
        let before = self.stop_picture();
        let Some((study, place, size)) = self.pictured(series, size) else { return Error::ERR_UNAVAILABLE };
        let (send, made) = channel();
        let cancel = CancelToken::new();
        let spawned = {
            let cancel = cancel.clone();
            std::thread::Builder::new().name("lumivox picture".to_owned()).spawn(move || {
                // Nobody else waits for it, and no thread may outlive the library.
                if let Some(before) = before {
                    let _ = before.join();
                }
                codecs::name_worker();
                let study = study.lock().unwrap_or_else(PoisonError::into_inner);
                // Nobody listens any more where another picture was asked for.
                let _ = send.send(study.thumbnail(place, size, &cancel).ok());
            })
        };
        let Ok(thread) = spawned else { return Error::ERR_CANT_FORK };
        self.picture = Some(Picture { series, cancel, made, thread });
        self.listen();
        Error::OK
    }

    /// Loads the scan in [param paths] (one file, one folder, one archive, or several DICOM files) and emits
    /// [signal finished]. Paths may begin with [code]res://[/code] or [code]user://[/code]. [param options] are those
    /// of [method LumivoxVolume.load_file]. Returns what [method scan] does.
    #[func]
    pub fn start(
        &mut self,
        paths: PackedStringArray,
        #[opt(default = &Options::none())] options: Options,
    ) -> Error {
        self.launch(Task::Import(None), &paths, &options)
    }

    /// Finds the parts of a scan, as [method LumivoxLabels.found_in] does, without waiting, and emits [signal labelled].
    /// Returns [constant ERR_BUSY] while something is under way, [constant ERR_INVALID_PARAMETER] for a volume without a
    /// scan, and [constant ERR_CANT_FORK] if there is no thread for it; of these nothing is emitted.
    #[func]
    pub fn find_labels(&mut self, volume: Option<Gd<LumivoxVolume>>) -> Error {
        let Some(scan) = volume.and_then(|volume| volume.bind().volume().cloned()) else {
            godot_error!("LumivoxImporter: there is no scan to find labels in");
            return Error::ERR_INVALID_PARAMETER;
        };
        self.begin(Task::FindLabels(scan), Source { paths: vec![], raw: None }, LoadOptions::default())
    }

    /// Loads a segmentation, as [method LumivoxLabels.load_file] does, without waiting, and emits [signal labelled].
    /// Returns what [method find_labels] does.
    #[func]
    pub fn load_labels(&mut self, path: GString) -> Error {
        if path.is_empty() {
            godot_error!("LumivoxImporter: there are no labels to read: name a file or a folder");
            return Error::ERR_INVALID_PARAMETER;
        }
        let source = Source { paths: vec![convert::system_path(&path)], raw: None };
        self.begin(Task::LoadLabels, source, LoadOptions::default())
    }

    /// Opens a scene file and loads the scans that it names, as [method Lumivox.load_scene] does, without waiting, and emits
    /// [signal scene_opened]. Returns what [method find_labels] does.
    #[func]
    pub fn open_scene(&mut self, path: GString, #[opt(default = false)] allow_outside_data: bool) -> Error {
        if path.is_empty() {
            godot_error!("LumivoxImporter: there is no scene to open: name its file");
            return Error::ERR_INVALID_PARAMETER;
        }
        let source = Source { paths: vec![convert::system_path(&path)], raw: None };
        self.begin(Task::OpenScene(allow_outside_data), source, LoadOptions::default())
    }

    /// Stops what is under way; [signal cancelled] follows in a later frame. A picture that was requested is stopped,
    /// too, without a signal.
    #[func]
    pub fn cancel(&mut self) {
        if let Some(picture) = &self.picture {
            picture.cancel.cancel();
        }
        if let Some(job) = &self.job {
            job.cancel.cancel();
        }
    }

    /// Whether a scan or an import is under way: from [method scan] or [method start] until its last signal.
    #[func]
    pub fn is_running(&self) -> bool {
        self.job.is_some()
    }
}

/// A picture as Godot has it.
fn image(picture: Thumbnail) -> Option<Gd<Image>> {
    let (width, height) = (picture.width as i32, picture.height as i32);
    Image::create_from_data(width, height, false, Format::L8, &PackedByteArray::from(picture.grey))
}

impl LumivoxImporter {
    /// The study of a series that was found, its place and a size in pixels that can be.
    fn pictured(&self, series: i64, size: i64) -> Option<(SharedStudy, usize, usize)> {
        let known = self.known.as_ref()?;
        let series = usize::try_from(series).ok().filter(|&i| i < known.series)?;
        Some((known.study.clone(), series, size.clamp(1, 4096) as usize))
    }

    /// Ends the picture that is being made, unseen. Its thread has to be waited for.
    fn stop_picture(&mut self) -> Option<JoinHandle<()>> {
        let picture = self.picture.take()?;
        picture.cancel.cancel();
        Some(picture.thread)
    }

    /// Is asked for news once per frame from now on.
    fn listen(&self) {
        add(&mut running(), Running(self.to_gd()));
    }

    fn launch(&mut self, mut task: Task, paths: &PackedStringArray, options: &Options) -> Error {
        if self.job.is_some() {
            return Error::ERR_BUSY;
        }
        let options = match LoadOptions::parse(&options.0) {
            Ok(options) => options,
            Err(message) => {
                godot_error!("{message}");
                return Error::ERR_INVALID_PARAMETER;
            }
        };
        if paths.as_slice().iter().all(GString::is_empty) {
            godot_error!("LumivoxImporter: there is nothing to read: name a file, a folder or an archive");
            return Error::ERR_INVALID_PARAMETER;
        }
        let paths = paths.as_slice().iter().map(convert::system_path).collect();
        let source = Source { paths, raw: options.import.raw.clone() };
        let known = self.known.take().filter(|known| known.source == source);
        if let (Task::Import(study), Some(known)) = (&mut task, known) {
            *study = Some(known.study);
        }
        self.begin(task, source, options)
    }

    fn begin(&mut self, task: Task, source: Source, options: LoadOptions) -> Error {
        if self.job.is_some() {
            return Error::ERR_BUSY;
        }
        let picture = self.stop_picture();
        let (send, events) = channel();
        let cancel = CancelToken::new();
        let spawned = {
            let (source, cancel) = (source.clone(), cancel.clone());
            std::thread::Builder::new().name("lumivox import".to_owned()).spawn(move || {
                if let Some(picture) = picture {
                    let _ = picture.join();
                }
                run(task, &source.paths, &options, &cancel, &send);
            })
        };
        let Ok(thread) = spawned else { return Error::ERR_CANT_FORK };
        self.job = Some(Job { source, cancel, events, thread });
        self.listen();
        Error::OK
    }

    /// Emits what has happened since the last time. Returns whether nothing more will.
    fn deliver(this: Gd<Self>) -> bool {
        Self::deliver_job(this.clone());
        Self::deliver_picture(this.clone());
        // What has just been heard may have been answered with the next request.
        let this = this.bind();
        this.job.is_none() && this.picture.is_none()
    }

    fn deliver_picture(mut this: Gd<Self>) {
        let made = match this.bind().picture.as_ref().map(|picture| picture.made.try_recv()) {
            Some(Ok(made)) => made,
            // The thread is gone without a word: it panicked, and said so.
            Some(Err(TryRecvError::Disconnected)) => None,
            Some(Err(TryRecvError::Empty)) | None => return,
        };
        let Some(picture) = this.bind_mut().picture.take() else { return };
        // It has nothing left to do but to end.
        let _ = picture.thread.join();
        if !picture.cancel.is_cancelled() {
            let image = made.and_then(image);
            this.signals().thumbnail_ready().emit(picture.series, image.as_ref());
        }
    }

    fn deliver_job(mut this: Gd<Self>) {
        let mut latest = None;
        let ended = loop {
            let event = this.bind().job.as_ref().map(|job| job.events.try_recv());
            match event {
                Some(Ok(Event::Progress(stage, done, total))) => latest = Some((stage, done, total)),
                Some(Ok(Event::Ended(result))) => break Some(result),
                // The thread is gone without a word: it panicked, and said so.
                Some(Err(TryRecvError::Disconnected)) => {
                    this.bind_mut().job = None;
                    let message = GString::from("The import stopped because of a fault in Lumivox.");
                    this.signals().failed().emit(&message);
                    return;
                }
                Some(Err(TryRecvError::Empty)) => break None,
                None => return,
            }
        };
        if let Some((stage, done, total)) = latest {
            this.signals().progress().emit(&GString::from(stage.label()), done as i64, total as i64);
        }
        let Some(result) = ended else { return };
        let Some(job) = this.bind_mut().job.take() else { return };
        // It has nothing left to do but to end.
        let _ = job.thread.join();
        match result {
            _ if job.cancel.is_cancelled() => this.signals().cancelled().emit(),
            Err(Failure(why)) => this.signals().failed().emit(&GString::from(&why)),
            Ok(Outcome::Scanned(study)) => {
                let report = report_dictionary(study.report());
                let series = study.report().series.len();
                let study = Arc::new(Mutex::new(*study));
                this.bind_mut().known = Some(Known { source: job.source, series, study });
                this.signals().scanned().emit(&report);
            }
            Ok(Outcome::Imported(imported, study)) => {
                let source = job.source;
                this.bind_mut().known = study.map(|(series, study)| Known { source, series, study });
                this.signals().finished().emit(&LumivoxVolume::loaded(*imported));
            }
            Ok(Outcome::Opened(opened, name)) => match scene_file::packed(&opened, &name) {
                Ok(scene) => {
                    let notes = opened.notes.iter().map(GString::from).collect();
                    this.signals().scene_opened().emit(&scene, &notes);
                }
                Err(why) => this.signals().failed().emit(&GString::from(&why)),
            },
            Ok(Outcome::Labelled(labels, notes)) => {
                this.signals().labelled().emit(&LumivoxLabels::of(*labels, notes));
            }
        }
    }
}

/// Emits what importers have to say, on the main thread, once per frame.
pub fn deliver() {
    // Listeners, and other threads, may start another import meanwhile.
    let before = std::mem::take(&mut *running());
    let going_on: Vec<_> =
        before.into_iter().filter(|importer| !LumivoxImporter::deliver(importer.0.clone())).collect();
    let mut running = running();
    for importer in going_on {
        add(&mut running, importer);
    }
}

fn add(running: &mut Vec<Running>, importer: Running) {
    if !running.contains(&importer) {
        running.push(importer);
    }
}

/// Ends every import, silently.
pub fn stop_all() {
    let all = std::mem::take(&mut *running());
    for Running(mut importer) in all {
        if let Some(job) = importer.bind_mut().job.take() {
            job.cancel.cancel();
            // A thread must not outlive the library that holds its code.
            let _ = job.thread.join();
        }
        let picture = importer.bind_mut().stop_picture();
        if let Some(thread) = picture {
            let _ = thread.join();
        }
    }
}

fn run(task: Task, paths: &[PathBuf], options: &LoadOptions, cancel: &CancelToken, send: &Sender<Event>) {
    let sender = Mutex::new(send.clone());
    let report = |stage, done, total| {
        // Whoever cannot have the lock at once lets another tell.
        if let Ok(sender) = sender.try_lock() {
            tell(&sender, Event::Progress(stage, done, total));
        }
    };
    let progress = Progress::new(&report);
    codecs::name_worker();
    let work = || -> Result<Outcome, Failure> {
        match task {
            Task::Scan => {
                let study = Study::open(paths, &options.import, progress, cancel)?;
                Ok(Outcome::Scanned(Box::new(study)))
            }
            Task::Import(None) => {
                let imported = lumivox_import::load(paths, &options.import, progress, cancel)?;
                let imported = options.keep(imported, progress, cancel)?;
                Ok(Outcome::Imported(Box::new(imported), None))
            }
            Task::Import(Some(shared)) => {
                let mut study = shared.lock().unwrap_or_else(PoisonError::into_inner);
                let imported = study.load(&options.import, progress, cancel)?;
                let series = study.report().series.len();
                drop(study);
                let imported = options.keep(imported, progress, cancel)?;
                Ok(Outcome::Imported(Box::new(imported), Some((series, shared))))
            }
            Task::FindLabels(scan) => {
                let found = lumivox_segmentation::segment(&scan, progress, cancel)?;
                Ok(Outcome::Labelled(Box::new(found.labels), found.report.notes))
            }
            Task::LoadLabels => {
                let loaded =
                    lumivox_import::load_labels(&paths[0], &LabelOptions::default(), progress, cancel)?;
                Ok(Outcome::Labelled(Box::new(loaded.labels), loaded.report.notes))
            }
            Task::OpenScene(allow_outside_data) => {
                let path = &paths[0];
                let opened = scene_file::open(path, allow_outside_data, progress, cancel).map_err(Failure)?;
                Ok(Outcome::Opened(Box::new(opened), scene_file::name_of(path)))
            }
        }
    };
    tell(send, Event::Ended(work()));
}

/// Nobody listens any more where the importer was stopped.
fn tell(send: &Sender<Event>, event: Event) {
    let _ = send.send(event);
}
