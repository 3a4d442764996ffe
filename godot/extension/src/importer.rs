//! Imports on a thread of their own, for editors and games that go on meanwhile.

use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;

use godot::global::Error;
use godot::prelude::*;
use lumivox_core::{CancelToken, Progress, Stage};
use lumivox_import::{ImportError, ImportOptions, Imported};

use crate::convert;
use crate::resources::{LumivoxVolume, Options, import_options, report_dictionary};

thread_local! {
    /// What is under way. Its owner may have dropped it; it lives until its last signal.
    static RUNNING: RefCell<Vec<Gd<LumivoxImporter>>> = const { RefCell::new(vec![]) };
}

/// What the thread tells.
enum Event {
    Progress(Stage, u64, u64),
    Ended(Result<Box<Imported>, ImportError>),
}

/// What is done with a scan that was read.
#[derive(Clone, Copy, PartialEq)]
enum Purpose {
    Scan,
    Import,
}

struct Job {
    purpose: Purpose,
    paths: Vec<PathBuf>,
    cancel: CancelToken,
    events: Receiver<Event>,
    thread: JoinHandle<()>,
}

/// Loads scans without holding up the editor or the game: DICOM files, folders and zip archives, NIfTI, NRRD,
/// MetaImage and RAW. Signals arrive on the main thread.
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
    /// What the last scan read, so that starting it does not read it again.
    scanned: Option<(Vec<PathBuf>, Box<Imported>)>,
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

    /// Finds out what [param paths] hold and emits [signal scanned]. A [method start] of the same paths afterwards
    /// is quicker. Paths may begin with [code]res://[/code] or [code]user://[/code]. Returns [constant ERR_BUSY] while
    /// something is under way.
    #[func]
    pub fn scan(&mut self, paths: PackedStringArray) -> Error {
        self.launch(Purpose::Scan, &paths, ImportOptions::default())
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
        match import_options(&options.0) {
            Ok(options) => self.launch(Purpose::Import, &paths, options),
            Err(message) => {
                godot_error!("{message}");
                Error::ERR_INVALID_PARAMETER
            }
        }
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
    fn launch(&mut self, purpose: Purpose, paths: &PackedStringArray, options: ImportOptions) -> Error {
        if self.job.is_some() {
            return Error::ERR_BUSY;
        }
        if paths.is_empty() {
            return Error::ERR_INVALID_PARAMETER;
        }
        let paths: Vec<PathBuf> = paths.as_slice().iter().map(convert::system_path).collect();
        let ready = self.scanned.take().filter(|(scanned, _)| {
            purpose == Purpose::Import
                && *scanned == paths
                && options.series.is_none()
                && options.raw.is_none()
        });
        let (send, events) = channel();
        let cancel = CancelToken::new();
        let spawned = {
            let (paths, cancel) = (paths.clone(), cancel.clone());
            std::thread::Builder::new().name("lumivox import".to_owned()).spawn(move || match ready {
                Some((_, imported)) => tell(&send, Event::Ended(Ok(imported))),
                None => read(&paths, &options, &cancel, &send),
            })
        };
        let Ok(thread) = spawned else { return Error::ERR_CANT_FORK };
        self.job = Some(Job { purpose, paths, cancel, events, thread });
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
            Ok(imported) if job.purpose == Purpose::Scan => {
                let report = report_dictionary(&imported.report);
                this.bind_mut().scanned = Some((job.paths, imported));
                this.signals().scanned().emit(&report);
            }
            Ok(imported) => this.signals().finished().emit(&LumivoxVolume::imported(*imported)),
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

fn read(paths: &[PathBuf], options: &ImportOptions, cancel: &CancelToken, send: &Sender<Event>) {
    let sender = std::sync::Mutex::new(send.clone());
    let report = |stage, done, total| {
        // Whoever cannot have the lock at once lets another tell.
        if let Ok(sender) = sender.try_lock() {
            tell(&sender, Event::Progress(stage, done, total));
        }
    };
    let result = lumivox_import::load(paths, options, Progress::new(&report), cancel);
    tell(send, Event::Ended(result.map(Box::new)));
}

/// Nobody listens any more where the importer was stopped.
fn tell(send: &Sender<Event>, event: Event) {
    let _ = send.send(event);
}
