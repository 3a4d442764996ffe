//! Long work on threads of its own: how far it is, stopping it, and what it made.

use std::ffi::{CString, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use lumivox_core::document::Keep;
use lumivox_core::{CancelToken, Progress, WorkStage, looks_like_labels};
use lumivox_import::{ImportError, ImportReport, Imported, ImportedLabels, Study};
use lumivox_segmentation::Surroundings;

use crate::abi::{LumivoxImportOptions, LumivoxJobState, LumivoxPicture, LumivoxProgress};
use crate::border::{
    LumivoxText, Outcome, free, guard, guard_handle, guard_option, guard_quietly, guard_status, known,
    known_mut, list, needed_text, panic_message, path, text,
};
use crate::import::{files, import_options, keeps_everything, label_map, read_labels, without_things};
use crate::labels::{found, skin};
use crate::look;
use crate::parts;
use crate::picture::Picture;
use crate::scene::LumivoxScene;
use crate::stored;
use crate::volume::{LumivoxVolume, kept, phantom};

/// Files whose headers were read. Handles share it.
pub struct LumivoxStudy(Arc<Mutex<Study>>);

/// Long work, and what it makes.
pub struct LumivoxJob(Arc<Work>);

struct Work {
    cancel: CancelToken,
    progress: Mutex<(Option<WorkStage>, u64, u64)>,
    result: Mutex<Option<Result<Made, String>>>,
    has_ended: AtomicBool,
}

/// What was made; what is taken is gone.
#[derive(Default)]
pub(crate) struct Made {
    volume: Option<LumivoxVolume>,
    study: Option<LumivoxStudy>,
    report: Option<ImportReport>,
    picture: Option<Picture>,
    scene: Option<LumivoxScene>,
}

impl Made {
    fn volume(volume: LumivoxVolume) -> Self {
        Self { volume: Some(volume), ..Self::default() }
    }

    pub(crate) fn scene(scene: LumivoxScene) -> Self {
        Self { scene: Some(scene), ..Self::default() }
    }

    pub(crate) fn take_scene(&mut self) -> Option<LumivoxScene> {
        self.scene.take()
    }

    fn picture(picture: Picture) -> Self {
        Self { picture: Some(picture), ..Self::default() }
    }

    fn labels(ImportedLabels { labels, report, .. }: ImportedLabels) -> Self {
        Self {
            volume: Some(LumivoxVolume::of_labels(labels, kept(&report))),
            report: Some(report),
            ..Self::default()
        }
    }

    fn imported(Imported { volume, report, .. }: Imported, surroundings: Option<Surroundings>) -> Self {
        Self {
            volume: Some(LumivoxVolume::with_surroundings(volume, surroundings, kept(&report))),
            report: Some(report),
            ..Self::default()
        }
    }
}

/// Threads that run, and their work: none may outlive the library.
static RUNNING: Mutex<Vec<(Arc<Work>, JoinHandle<()>)>> = Mutex::new(vec![]);

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // What a panic left behind was reported as the job's error.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Starts work on a thread of its own.
pub(crate) fn start(
    task: impl FnOnce(Progress<'_>, &CancelToken) -> Outcome<Made> + Send + 'static,
) -> Outcome<LumivoxJob> {
    let work = Arc::new(Work {
        cancel: CancelToken::new(),
        progress: Mutex::new((None, 0, 0)),
        result: Mutex::new(None),
        has_ended: AtomicBool::new(false),
    });
    let own = work.clone();
    let run = move || {
        let tell = |stage, done, total| {
            // Whoever cannot have the lock at once lets another tell.
            if let Ok(mut progress) = own.progress.try_lock() {
                *progress = (Some(stage), done, total);
            }
        };
        let result = catch_unwind(AssertUnwindSafe(|| task(Progress::new(&tell), &own.cancel)))
            .unwrap_or_else(|panic| Err(format!("a fault in Lumivox: {}", panic_message(&*panic))));
        *lock(&own.result) = Some(result);
        own.has_ended.store(true, Ordering::Release);
    };
    let spawned = std::thread::Builder::new().name("lumivox job".to_owned()).spawn(run);
    let thread = spawned.map_err(|error| format!("there is no thread for it: {error}"))?;
    let mut running = lock(&RUNNING);
    running.retain(|(_, thread)| !thread.is_finished());
    running.push((work.clone(), thread));
    Ok(LumivoxJob(work))
}

/// Reads the headers of one file of any format, a folder, a zip archive, or several DICOM files. The job gives a study and
/// its report.
///
/// # Safety
/// `paths` points to `count` strings, `options` is null or points to options.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_import_scan(
    paths: *const *const c_char,
    count: u32,
    options: *const LumivoxImportOptions,
) -> *mut LumivoxJob {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let (paths, options) = unsafe { (files(paths, count)?, import_options(options)?) };
        start(move |progress, cancel| {
            let study = Study::open(&paths, &options, progress, cancel).map_err(|error| error.to_string())?;
            let report = Some(study.report().clone());
            Ok(Made { study: Some(LumivoxStudy(Arc::new(Mutex::new(study)))), report, ..Made::default() })
        })
    })
}

/// Loads a scan; from `study`, whose headers are not read again, where it is not null. The job gives the scan and the
/// report. A label map is the first of `paths`, whatever the study.
///
/// # Safety
/// As [`lumivox_import_scan`]; `study` is null or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_import_load(
    paths: *const *const c_char,
    count: u32,
    options: *const LumivoxImportOptions,
    study: *const LumivoxStudy,
) -> *mut LumivoxJob {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let (keep, labels, options, study) = unsafe {
            (keeps_everything(options), label_map(options), import_options(options)?, study.as_ref())
        };
        // SAFETY: as the caller promises.
        let file = if labels == 0 { None } else { Some(unsafe { files(paths, count) }?.swap_remove(0)) };
        let (label_file, label_options) = (file.clone(), options.clone());
        let finish = move |mut imported: Imported, progress: Progress<'_>, cancel: &CancelToken| {
            if let Some(file) = file.filter(|_| looks_like_labels(&imported.volume)) {
                match read_labels(&file, &label_options, progress, cancel) {
                    Ok(labels) => return Ok(Made::labels(labels)),
                    Err(ImportError::Cancelled(stopped)) => return Err(stopped.to_string()),
                    // It only looked like one.
                    Err(_) => {}
                }
            }
            // As it was read: scene documents tell by it whether another lies in its place.
            let kept = if keep { Keep::Everything } else { Keep::Patient };
            imported.volume =
                lumivox_scene::identified(imported.volume).with_source_changed(|scan| scan.keep = kept);
            if keep {
                return Ok(Made::imported(imported, None));
            }
            let alone = without_things(imported, progress, cancel).map_err(|error| error.to_string())?;
            Ok(Made::imported(alone.0, alone.1))
        };
        if let Some(file) = label_file.filter(|_| labels == 1) {
            return start(move |progress, cancel| {
                let labels = read_labels(&file, &options, progress, cancel);
                labels.map(Made::labels).map_err(|error| error.to_string())
            });
        }
        if let Some(LumivoxStudy(study)) = study {
            let study = study.clone();
            return start(move |progress, cancel| {
                let imported = lock(&study).load(&options, progress, cancel);
                finish(imported.map_err(|error| error.to_string())?, progress, cancel)
            });
        }
        // SAFETY: as the caller promises.
        let paths = unsafe { files(paths, count) }?;
        start(move |progress, cancel| {
            let imported = lumivox_import::load(&paths, &options, progress, cancel);
            finish(imported.map_err(|error| error.to_string())?, progress, cancel)
        })
    })
}

/// Finds by itself what a scan shows: of a CT the body, lungs, airways and gas, table and clothes; of an MR the body. The
/// job gives a label map, whose report says how sure it is.
///
/// # Safety
/// `volume` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_labels_find(volume: *const LumivoxVolume) -> *mut LumivoxJob {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let volume = unsafe { known(volume, "scan") }?.share();
        start(move |progress, cancel| found(&volume, progress, cancel).map(Made::volume))
    })
}

/// Finds the skin of a scan, for what is peeled of it: see `lumivox_volume_skin`. The scan keeps it.
///
/// # Safety
/// `volume` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_skin_find(volume: *const LumivoxVolume) -> *mut LumivoxJob {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let volume = unsafe { known(volume, "scan") }?.share();
        start(move |progress, cancel| {
            volume.keep_skin(skin(&volume, progress, cancel)?);
            Ok(Made::default())
        })
    })
}

/// What of a scan is seen in place of the patient: 1 all that was scanned, 2 the airways alone, 3 the vessels of the lungs
/// alone. The job gives a scan for `LumivoxInstance::part`; none where there is no such part, or it is not found for sure.
///
/// # Safety
/// `volume` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_part_find(volume: *const LumivoxVolume, part: u32) -> *mut LumivoxJob {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let volume = unsafe { known(volume, "scan") }?.share();
        let part = parts::Part::from_number(part)?;
        start(move |progress, cancel| {
            let found = parts::find(&volume, part, progress, cancel)?;
            Ok(Made { volume: found, ..Made::default() })
        })
    })
}

/// A picture of the middle slice of a series of a study, counted from 0, at most `side` pixels wide and high.
///
/// # Safety
/// `study` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_study_thumbnail(
    study: *const LumivoxStudy,
    series: u32,
    side: u32,
) -> *mut LumivoxJob {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let study = unsafe { known(study, "study") }?.0.clone();
        start(move |_, cancel| {
            let study = lock(&study);
            let count = study.report().series.len();
            if series as usize >= count {
                return Err(format!("There is no series {series}: there are {count}, counted from 0."));
            }
            let picture = study.thumbnail(series as usize, side.clamp(1, 4096) as usize, cancel);
            Ok(Made::picture(picture.map_err(|error| error.to_string())?.into()))
        })
    })
}

/// A picture of a scan from the front, at most `side` pixels (256 or fewer) wide and high, transparent where nothing is
/// seen: as a preset shows it, or, where `preset` is null, as the one that suits it.
///
/// # Safety
/// `volume` is a live handle, `preset` null or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_volume_picture(
    volume: *const LumivoxVolume,
    preset: *const c_char,
    side: u32,
) -> *mut LumivoxJob {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let (volume, preset) = unsafe { (known(volume, "scan")?.share(), text(preset, "name of a preset")?) };
        let preset = preset.map(look::preset).transpose()?;
        start(move |_, cancel| {
            let own = preset.map(|preset| preset.medium(volume.volume()));
            let medium = own.as_ref().unwrap_or_else(|| volume.suited());
            Picture::of(volume.volume(), medium, side as usize, cancel).map(Made::picture)
        })
    })
}

/// Frees a study.
///
/// # Safety
/// `study` is null, or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_study_free(study: *mut LumivoxStudy) {
    // SAFETY: as the caller promises.
    unsafe { free(study) };
}

/// As `lumivox_volume_phantom`, without waiting.
///
/// # Safety
/// `kind` is a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_phantom_start(kind: *const c_char, size: u32) -> *mut LumivoxJob {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let kind = unsafe { needed_text(kind, "kind of phantom") }?.to_owned();
        start(move |progress, cancel| phantom(&kind, size, progress, cancel).map(Made::volume))
    })
}

/// Stores a scan as a file that opens at once; whole, or not at all.
///
/// # Safety
/// `volume` is a live handle, `file` a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_volume_save(
    volume: *const LumivoxVolume,
    file: *const c_char,
) -> *mut LumivoxJob {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let (volume, file) = unsafe { (known(volume, "scan")?.share(), path(file, "file")?) };
        start(move |progress, cancel| {
            stored::save(&volume, &file, progress, cancel).map(|()| Made::default())
        })
    })
}

/// Copies the file of a stored scan without what tells where the scan was read from: for a game that is given to others.
///
/// # Safety
/// `from` and `to` are strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stored_copy_nameless(from: *const c_char, to: *const c_char) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (from, to) = unsafe { (path(from, "file")?, path(to, "file")?) };
        stored::copy_nameless(&from, &to)
    })
}

/// Opens a stored scan.
///
/// # Safety
/// `file` is a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_volume_open(file: *const c_char) -> *mut LumivoxJob {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let file = unsafe { path(file, "file") }?;
        start(move |progress, cancel| stored::open(&file, progress, cancel).map(Made::volume))
    })
}

/// Opens a stored scan whose file is in memory, for platforms that keep a game's files in an archive. The bytes are
/// copied before this returns.
///
/// # Safety
/// `data` points to `length` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_volume_open_bytes(data: *const c_void, length: u64) -> *mut LumivoxJob {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let bytes = unsafe { list(data.cast::<u8>(), length as usize, "bytes") }?.to_vec();
        start(move |progress, cancel| {
            let length = bytes.len() as u64;
            stored::read(&bytes[..], length, "the stored scan", progress, cancel).map(Made::volume)
        })
    })
}

/// How far a job is. `out` may be null.
///
/// # Safety
/// `job` is a live handle, `out` null or can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_job_poll(
    job: *const LumivoxJob,
    out: *mut LumivoxProgress,
) -> LumivoxJobState {
    let state = guard(|| {
        // SAFETY: as the caller promises.
        let (work, out) = unsafe { (&known(job, "job")?.0, out.as_mut()) };
        if let Some(out) = out {
            let (stage, done, total) = *lock(&work.progress);
            *out = LumivoxProgress { stage: label(stage), done, total };
        }
        if !work.has_ended.load(Ordering::Acquire) {
            return Ok(LumivoxJobState::Running);
        }
        Ok(match &*lock(&work.result) {
            _ if work.cancel.is_cancelled() => LumivoxJobState::Cancelled,
            Some(Ok(_)) => LumivoxJobState::Done,
            _ => LumivoxJobState::Failed,
        })
    });
    state.unwrap_or(LumivoxJobState::Failed)
}

/// What a progress bar says, as C has it.
fn label(stage: Option<WorkStage>) -> *const c_char {
    static LABELS: Mutex<Vec<(WorkStage, CString)>> = Mutex::new(vec![]);
    let Some(stage) = stage else { return c"".as_ptr() };
    let mut labels = lock(&LABELS);
    if let Some((_, label)) = labels.iter().find(|(known, _)| *known == stage) {
        return label.as_ptr();
    }
    let label = CString::new(stage.label()).unwrap_or_default();
    // The characters stay where they are when the list moves.
    let pointer = label.as_ptr();
    labels.push((stage, label));
    pointer
}

/// Asks a job to stop. It says that it was once it has.
///
/// # Safety
/// `job` is null, or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_job_cancel(job: *const LumivoxJob) {
    guard_quietly((), || {
        // SAFETY: as the caller promises.
        if let Some(job) = unsafe { job.as_ref() } {
            job.0.cancel.cancel();
        }
    });
}

/// Frees a job; one that is under way is asked to stop, and not waited for.
///
/// # Safety
/// `job` is null, or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_job_free(job: *mut LumivoxJob) {
    // SAFETY: as the caller promises.
    unsafe {
        lumivox_job_cancel(job);
        free(job);
    }
}

/// Why a job has failed; empty if it has not.
///
/// # Safety
/// `job` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_job_error(job: *const LumivoxJob) -> *mut LumivoxText {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let work = &unsafe { known(job, "job") }?.0;
        let result = lock(&work.result);
        let error = result.as_ref().and_then(|result| result.as_ref().err());
        Ok(LumivoxText::new(error.map_or("", String::as_str)))
    })
}

/// Takes something of what a job has made; null where it has made none, or it was taken.
///
/// # Safety
/// `job` is a live handle.
pub(crate) unsafe fn take<T>(job: *const LumivoxJob, part: impl FnOnce(&mut Made) -> Option<T>) -> *mut T {
    guard_option(|| {
        // SAFETY: as the caller promises.
        let work = &unsafe { known(job, "job") }?.0;
        Ok(lock(&work.result).as_mut().and_then(|result| part(result.as_mut().ok()?)))
    })
}

/// The scan that a job has made.
///
/// # Safety
/// `job` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_job_take_volume(job: *mut LumivoxJob) -> *mut LumivoxVolume {
    // SAFETY: as the caller promises.
    unsafe { take(job, |made| made.volume.take()) }
}

/// The study that a job has made.
///
/// # Safety
/// `job` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_job_take_study(job: *mut LumivoxJob) -> *mut LumivoxStudy {
    // SAFETY: as the caller promises.
    unsafe { take(job, |made| made.study.take()) }
}

/// What an import found and did, as JSON; null for jobs that are none.
///
/// # Safety
/// `job` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_job_report(job: *const LumivoxJob) -> *mut LumivoxText {
    // SAFETY: as the caller promises.
    unsafe {
        take(job, |made| {
            let report = serde_json::to_string(made.report.as_ref()?).ok()?;
            Some(LumivoxText::new(&report))
        })
    }
}

/// The picture that a job has made; valid until the job is freed.
///
/// # Safety
/// `job` is a live handle, `out` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_job_picture(job: *const LumivoxJob, out: *mut LumivoxPicture) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (work, out) = unsafe { (&known(job, "job")?.0, known_mut(out, "place for it")?) };
        let result = lock(&work.result);
        let made = result.as_ref().and_then(|result| result.as_ref().ok());
        let picture = made.and_then(|made| made.picture.as_ref()).ok_or("this job has made no picture")?;
        *out = LumivoxPicture {
            width: picture.width as u32,
            height: picture.height as u32,
            rgba: picture.rgba.as_ptr(),
        };
        Ok(())
    })
}

/// Jobs whose threads still run, freed ones too.
#[unsafe(no_mangle)]
pub extern "C" fn lumivox_jobs_running() -> u32 {
    guard_quietly(0, || lock(&RUNNING).iter().filter(|(_, thread)| !thread.is_finished()).count() as u32)
}

/// Stops all jobs and waits for them: before the library is unloaded.
#[unsafe(no_mangle)]
pub extern "C" fn lumivox_jobs_stop_all() {
    guard_quietly((), || {
        let all = std::mem::take(&mut *lock(&RUNNING));
        all.iter().for_each(|(work, _)| work.cancel.cancel());
        for (_, thread) in all {
            // Its panics were caught.
            let _ = thread.join();
        }
    });
}
