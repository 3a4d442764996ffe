//! Imports on a thread of their own, for editors and games that go on meanwhile.

use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;

use godot::classes::Image;
use godot::classes::image::Format;
use godot::global::Error;
use godot::prelude::*;
use lumivox_core::{CancelToken, Progress, Stage};
use lumivox_import::{ImportError, ImportOptions, Imported, RawDescription, Study};

use crate::convert;
use crate::resources::{LumivoxVolume, Options, import_options, report_dictionary};

thread_local! {
    /// What is under way. Its owner may have dropped it; it lives until its last signal.
    static RUNNING: RefCell<Vec<Gd<LumivoxImporter>>> = const { RefCell::new(vec![]) };
}

/// What the thread tells.
enum Event {
    Progress(Stage, u64, u64),
    Ended(Result<Outcome, ImportError>),
}

/// What a thread has found: the files whose headers it has read, or a volume of them.
enum Outcome {
    Scanned(Box<Study>),
    /// With the study that it came from, if there was one.
    Imported(Box<Imported>, Option<Box<Study>>),
}

/// What is done with files.
enum Task {
    /// Their headers are read.
    Scan,
    /// A volume is loaded from them; from a study of them, if there is one.
    Import(Option<Box<Study>>),
}

struct Job {
    source: Source,
    cancel: CancelToken,
    events: Receiver<Event>,
    thread: JoinHandle<()>,
}

/// What a study was read from.
#[derive(Clone, PartialEq)]
struct Source {
    paths: Vec<PathBuf>,
    /// What was said of a RAW file.
    raw: Option<RawDescription>,
}

/// Loads scans without holding up the editor or the game: DICOM files, folders and zip archives, NIfTI, NRRD,
/// MetaImage and RAW. Signals arrive on the main thread. Compressed slices are decoded in this process: a library
/// inside an engine has no program of its own to hand them to.
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
    /// What was read last, so that it is not read again.
    study: Option<(Source, Box<Study>)>,
    base: Base<RefCounted>,
}

#[godot_api]
impl LumivoxImporter {
    /// How far it is: [param done] of [param total] steps of [param stage], a phrase for people.
    #[signal]
    pub fn progress(stage: GString, done: i64, total: i64);

    /// The scan is over. See [method LumivoxVolume.get_report] for what is in [param report].
    #[signal]
    pub fn scanned(report: VarDictionary);

    /// The import is over.
    #[signal]
    pub fn finished(volume: Gd<LumivoxVolume>);

    /// It came to nothing; [param message] says why and what to do.
    #[signal]
    pub fn failed(message: GString);

    /// It was stopped by [method cancel].
    #[signal]
    pub fn cancelled();

    /// Finds out what [param paths] hold, from the headers of DICOM files alone, and emits [signal scanned]. A
    /// [method start] of the same paths afterwards does not read the headers again. Paths may begin with
    /// [code]res://[/code] or [code]user://[/code]. [param options] are those of [method start]; only
    /// [code]raw[/code] matters here. Returns [constant ERR_BUSY] while something is under way, and
    /// [constant ERR_INVALID_PARAMETER] if the options cannot be understood.
    #[func]
    pub fn scan(
        &mut self,
        paths: PackedStringArray,
        #[opt(default = &Options::none())] options: Options,
    ) -> Error {
        self.launch(Task::Scan, &paths, &options)
    }

    /// The middle slice of a series that [method scan] has found, as a grey image of at most [param size] pixels along
    /// a side; [param series] is its place in the report, from 0. Decodes one slice, and waits for it. [code]null[/code]
    /// before [signal scanned], while an import is under way, and if the slice cannot be decoded.
    #[func]
    pub fn thumbnail(&self, series: i64, #[opt(default = 128)] size: i64) -> Option<Gd<Image>> {
        let (_, study) = self.study.as_ref()?;
        let series = usize::try_from(series).ok().filter(|&i| i < study.report().series.len())?;
        let size = size.clamp(1, 4096) as usize;
        let picture = study.thumbnail(series, size, &CancelToken::new()).ok()?;
        let (width, height) = (picture.width as i32, picture.height as i32);
        Image::create_from_data(width, height, false, Format::L8, &PackedByteArray::from(picture.grey))
    }

    /// Loads the scan in [param paths] (one file, one folder, one archive, or several DICOM files) and emits
    /// [signal finished]. [param options] are those of [method LumivoxVolume.load_file]. Returns
    /// [constant ERR_BUSY] while something is under way, and [constant ERR_INVALID_PARAMETER] if the options cannot be
    /// understood.
    #[func]
    pub fn start(
        &mut self,
        paths: PackedStringArray,
        #[opt(default = &Options::none())] options: Options,
    ) -> Error {
        self.launch(Task::Import(None), &paths, &options)
    }

    /// Stops what is under way; [signal cancelled] follows.
    #[func]
    pub fn cancel(&mut self) {
        if let Some(job) = &self.job {
            job.cancel.cancel();
        }
    }

    /// Whether something is under way.
    #[func]
    pub fn is_running(&self) -> bool {
        self.job.is_some()
    }
}

impl LumivoxImporter {
    fn launch(&mut self, mut task: Task, paths: &PackedStringArray, options: &Options) -> Error {
        if self.job.is_some() {
            return Error::ERR_BUSY;
        }
        let options = match import_options(&options.0) {
            Ok(options) => options,
            Err(message) => {
                godot_error!("{message}");
                return Error::ERR_INVALID_PARAMETER;
            }
        };
        if paths.is_empty() {
            return Error::ERR_INVALID_PARAMETER;
        }
        let paths = paths.as_slice().iter().map(convert::system_path).collect();
        let source = Source { paths, raw: options.raw.clone() };
        let known = self.study.take().filter(|(known, _)| *known == source);
        if let (Task::Import(study), Some((_, known))) = (&mut task, known) {
            *study = Some(known);
        }
        let (send, events) = channel();
        let cancel = CancelToken::new();
        let spawned = {
            let (source, cancel) = (source.clone(), cancel.clone());
            std::thread::Builder::new()
                .name("lumivox import".to_owned())
                .spawn(move || run(task, &source.paths, &options, &cancel, &send))
        };
        let Ok(thread) = spawned else { return Error::ERR_CANT_FORK };
        self.job = Some(Job { source, cancel, events, thread });
        let this = self.to_gd();
        RUNNING.with_borrow_mut(|running| running.push(this));
        Error::OK
    }

    /// Emits what has happened since the last time. Returns whether it is over.
    fn deliver(mut this: Gd<Self>) -> bool {
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
                    return true;
                }
                Some(Err(TryRecvError::Empty)) => break None,
                None => return true,
            }
        };
        if let Some((stage, done, total)) = latest {
            this.signals().progress().emit(&GString::from(stage.label()), done as i64, total as i64);
        }
        let Some(result) = ended else { return false };
        let Some(job) = this.bind_mut().job.take() else { return true };
        // It has nothing left to do but to end.
        let _ = job.thread.join();
        match result {
            _ if job.cancel.is_cancelled() => this.signals().cancelled().emit(),
            Err(error) => this.signals().failed().emit(&GString::from(&error.to_string())),
            Ok(Outcome::Scanned(study)) => {
                let report = report_dictionary(study.report());
                this.bind_mut().study = Some((job.source, study));
                this.signals().scanned().emit(&report);
            }
            Ok(Outcome::Imported(imported, study)) => {
                this.bind_mut().study = study.map(|study| (job.source, study));
                this.signals().finished().emit(&LumivoxVolume::imported(*imported));
            }
        }
        true
    }
}

/// Emits what importers have to say, on the main thread, once per frame.
pub fn deliver() {
    // Listeners may start another import meanwhile.
    let running = RUNNING.take();
    let going_on: Vec<_> =
        running.into_iter().filter(|importer| !LumivoxImporter::deliver(importer.clone())).collect();
    RUNNING.with_borrow_mut(|running| running.extend(going_on));
}

/// Ends every import, silently.
pub fn stop_all() {
    for mut importer in RUNNING.take() {
        if let Some(job) = importer.bind_mut().job.take() {
            job.cancel.cancel();
            // A thread must not outlive the library that holds its code.
            let _ = job.thread.join();
        }
    }
}

fn run(task: Task, paths: &[PathBuf], options: &ImportOptions, cancel: &CancelToken, send: &Sender<Event>) {
    let sender = Mutex::new(send.clone());
    let report = |stage, done, total| {
        // Whoever cannot have the lock at once lets another tell.
        if let Ok(sender) = sender.try_lock() {
            tell(&sender, Event::Progress(stage, done, total));
        }
    };
    let progress = Progress::new(&report);
    let work = || match task {
        Task::Scan => {
            let study = Study::open(paths, options, progress, cancel)?;
            Ok(Outcome::Scanned(Box::new(study)))
        }
        Task::Import(None) => {
            let imported = lumivox_import::load(paths, options, progress, cancel)?;
            Ok(Outcome::Imported(Box::new(imported), None))
        }
        Task::Import(Some(mut study)) => {
            let imported = study.load(options, progress, cancel)?;
            Ok(Outcome::Imported(Box::new(imported), Some(study)))
        }
    };
    tell(send, Event::Ended(work()));
}

/// Nobody listens any more where the importer was stopped.
fn tell(send: &Sender<Event>, event: Event) {
    let _ = send.send(event);
}
