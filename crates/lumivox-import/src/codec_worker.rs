//! Native decoders in a process of their own, where a crash, a hang or a hunger for memory costs a slice and not the
//! program.
//!
//! JPEG-LS and JPEG 2000 are decoded by C and C++ libraries. A host that names a program for it ([`set_codec_worker`])
//! has them decode there: frames go through a pipe, and a worker that dies or takes too long is replaced. Without one
//! they run in this process.

use std::{
    ffi::OsString,
    io::{self, BufReader, BufWriter, Read, Write},
    path::PathBuf,
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use lumivox_core::CancelToken;

use crate::broken_pipe::BrokenPipesAreErrors;
use crate::codec::{self, CodecFault, Decoded, Encoding, FrameShape};

/// A program that decodes frames: it calls [`serve_codecs`] with its standard input and output.
#[derive(Clone, Debug)]
pub struct CodecWorker {
    /// The program; the host's own, mostly.
    pub program: PathBuf,
    /// Its arguments.
    pub args: Vec<OsString>,
    /// How long it may take for one frame before it is ended.
    pub timeout: Duration,
}

impl CodecWorker {
    /// A worker with ten seconds for each frame.
    pub fn new(program: impl Into<PathBuf>, args: impl IntoIterator<Item = impl Into<OsString>>) -> Self {
        let args = args.into_iter().map(Into::into).collect();
        Self { program: program.into(), args, timeout: Duration::from_secs(10) }
    }
}

static WORKER: Mutex<Option<CodecWorker>> = Mutex::new(None);

/// Names the program that decodes JPEG-LS and JPEG 2000 from now on, for the whole process; `None` decodes them here.
pub fn set_codec_worker(worker: Option<CodecWorker>) {
    *lock(&WORKER) = worker;
}

/// A panic while a lock is held leaves nothing half done here.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Memory that a worker may take besides so much for each pixel.
const MEMORY: u64 = 512 << 20;
const MEMORY_OF_PIXEL: u64 = 96;
/// What Windows calls a process without a window.
#[cfg(windows)]
const CREATE_NO_WINDOW: u32 = 0x0800_0000;
/// How often running work is looked at.
const LOOK: Duration = Duration::from_millis(20);

/// Words of a request before its codestream: encoding, columns, rows, bytes of a sample, memory, length.
const REQUEST_WORDS: usize = 6;
/// Words of an answer before its bytes: what it is, bytes of a sample, length.
const ANSWER_WORDS: usize = 3;
const SAMPLES: u64 = 0;
const DAMAGED: u64 = 1;
const UNSUPPORTED: u64 = 2;
/// Messages are not longer.
const LONGEST_MESSAGE: u64 = 4096;

/// Decodes frames until `input` ends. This is what the program of a [`CodecWorker`] runs, with its standard input and
/// output; nothing else may write to the latter.
///
/// # Errors
/// Where the other end of a pipe is gone, or sends what is no request.
pub fn serve_codecs(input: impl Read, output: impl Write) -> io::Result<()> {
    let (mut input, mut output) = (BufReader::new(input), BufWriter::new(output));
    let mut limited = false;
    loop {
        let request = match read_words::<REQUEST_WORDS>(&mut input) {
            Ok(request) => request,
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(()),
            Err(error) => return Err(error),
        };
        let [encoding, columns, rows, bytes, memory, length] = request;
        if !limited {
            limit_memory(memory);
            limited = true;
        }
        let encoding = match encoding {
            0 => Encoding::JpegLs,
            1 => Encoding::Jpeg2000,
            _ => return Err(io::ErrorKind::InvalidData.into()),
        };
        let mut stream = Vec::new();
        if (&mut input).take(length).read_to_end(&mut stream)? as u64 != length {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let [columns, rows, bytes] = [columns, rows, bytes].map(|word| word as usize);
        let shape = FrameShape { encoding, columns, rows, bytes, single_bits: false };
        match codec::decode(&stream, &shape) {
            Ok(Decoded { samples, bytes }) => {
                write_words(&mut output, [SAMPLES, bytes as u64, samples.len() as u64])?;
                output.write_all(&samples)?;
            }
            Err(fault) => {
                let (code, message) = match fault {
                    CodecFault::Damaged(message) => (DAMAGED, message),
                    CodecFault::Unsupported(message) => (UNSUPPORTED, message),
                };
                let message = &message.as_bytes()[..message.len().min(LONGEST_MESSAGE as usize)];
                write_words(&mut output, [code, 0, message.len() as u64])?;
                output.write_all(message)?;
            }
        }
        output.flush()?;
    }
}

/// Lets this process have no more than so many bytes of address space; its crashes leave no core behind.
fn limit_memory(bytes: u64) {
    #[cfg(unix)]
    for (resource, bytes) in [(libc::RLIMIT_AS, bytes), (libc::RLIMIT_CORE, 0)] {
        let limit = libc::rlimit { rlim_cur: bytes as libc::rlim_t, rlim_max: bytes as libc::rlim_t };
        // SAFETY: the struct is valid for the call. Where it fails, the limit is as it was.
        unsafe { libc::setrlimit(resource, &limit) };
    }
    #[cfg(windows)]
    limit_memory_by_job(bytes);
    #[cfg(not(any(unix, windows)))]
    let _ = bytes;
}

/// Lets this process commit no more than so many bytes, as the only one of a job; it ends without a dialog if it
/// crashes.
#[cfg(windows)]
fn limit_memory_by_job(bytes: u64) {
    use windows_sys::Win32::System::{
        JobObjects::{
            AssignProcessToJobObject, CreateJobObjectW, JOB_OBJECT_LIMIT_DIE_ON_UNHANDLED_EXCEPTION,
            JOB_OBJECT_LIMIT_PROCESS_MEMORY, JOBOBJECT_EXTENDED_LIMIT_INFORMATION,
            JobObjectExtendedLimitInformation, SetInformationJobObject,
        },
        Threading::GetCurrentProcess,
    };
    let mut limit = JOBOBJECT_EXTENDED_LIMIT_INFORMATION {
        ProcessMemoryLimit: usize::try_from(bytes).unwrap_or(usize::MAX),
        ..Default::default()
    };
    limit.BasicLimitInformation.LimitFlags =
        JOB_OBJECT_LIMIT_PROCESS_MEMORY | JOB_OBJECT_LIMIT_DIE_ON_UNHANDLED_EXCEPTION;
    let length = size_of_val(&limit) as u32;
    // SAFETY: the struct is valid for the call and has the length given. Where a call fails, the limit is as it was. The
    // job's handle stays open, for the job lasts as long as the process.
    unsafe {
        let job = CreateJobObjectW(std::ptr::null(), std::ptr::null());
        if !job.is_null() {
            let limit = std::ptr::from_ref(&limit).cast();
            SetInformationJobObject(job, JobObjectExtendedLimitInformation, limit, length);
            AssignProcessToJobObject(job, GetCurrentProcess());
        }
    }
}

fn read_words<const N: usize>(input: &mut impl Read) -> io::Result<[u64; N]> {
    let mut words = [0; N];
    for word in &mut words {
        let mut bytes = [0; 8];
        input.read_exact(&mut bytes)?;
        *word = u64::from_le_bytes(bytes);
    }
    Ok(words)
}

fn write_words<const N: usize>(output: &mut impl Write, words: [u64; N]) -> io::Result<()> {
    words.iter().try_for_each(|word| output.write_all(&word.to_le_bytes()))
}

/// The decoders of one import: in this process, and in workers as many as threads need at a time.
pub(crate) struct Codecs {
    worker: Option<CodecWorker>,
    memory: u64,
    idle: Mutex<Vec<Worker>>,
    watch: Arc<Watch>,
    watcher: Mutex<Option<JoinHandle<()>>>,
}

/// A running worker.
struct Worker {
    child: Arc<Mutex<Child>>,
    stdin: ChildStdin,
    stdout: BufReader<ChildStdout>,
}

impl Worker {
    fn end(self) {
        let mut child = lock(&self.child);
        let _ = child.kill();
        let _ = child.wait();
    }
}

/// Ends workers that take too long or too much memory, and all of them once the work is cancelled.
struct Watch {
    cancel: CancelToken,
    memory: u64,
    done: AtomicBool,
    running: Mutex<Vec<(Instant, Arc<Mutex<Child>>)>>,
}

impl Watch {
    fn run(&self) {
        while !self.done.load(Ordering::Acquire) {
            thread::park_timeout(LOOK);
            let now = Instant::now();
            for (deadline, child) in lock(&self.running).iter() {
                let mut child = lock(child);
                if *deadline <= now || self.cancel.is_cancelled() || takes_more(&child, self.memory) {
                    let _ = child.kill();
                }
            }
        }
    }
}

/// Whether a worker has taken more memory than it is to: a system may accept a job's limit and not keep it, as Wine does.
#[cfg(windows)]
fn takes_more(child: &Child, bytes: u64) -> bool {
    use std::os::windows::io::AsRawHandle;
    use windows_sys::Win32::System::ProcessStatus::{K32GetProcessMemoryInfo, PROCESS_MEMORY_COUNTERS_EX};
    let mut counters = PROCESS_MEMORY_COUNTERS_EX::default();
    let length = size_of_val(&counters) as u32;
    counters.cb = length;
    let told = std::ptr::from_mut(&mut counters).cast();
    // SAFETY: the struct is valid for the call and has the length given; the handle is the child's, which is not waited for yet.
    let is_told = unsafe { K32GetProcessMemoryInfo(child.as_raw_handle(), told, length) };
    // What is committed, and what of that has pages: Wine tells of the latter alone.
    is_told != 0 && counters.PrivateUsage.max(counters.WorkingSetSize) as u64 > bytes
}

/// Here the system keeps the limit that a worker gives itself.
#[cfg(not(windows))]
fn takes_more(_: &Child, _: u64) -> bool {
    false
}

impl Codecs {
    /// Decoders for frames of `frame_len` samples.
    pub(crate) fn new(frame_len: usize, cancel: &CancelToken) -> Self {
        let memory = (frame_len as u64).saturating_mul(MEMORY_OF_PIXEL).saturating_add(MEMORY);
        let (cancel, done, running) = (cancel.clone(), AtomicBool::new(false), Mutex::default());
        Self {
            worker: lock(&WORKER).clone(),
            memory,
            idle: Mutex::default(),
            watch: Arc::new(Watch { cancel, memory, done, running }),
            watcher: Mutex::default(),
        }
    }

    /// Decodes one frame.
    ///
    /// # Errors
    /// [`CodecFault`]; a worker that died is one, too.
    pub(crate) fn decode(&self, stream: &[u8], shape: &FrameShape) -> Result<Decoded, CodecFault> {
        let code = match shape.encoding {
            Encoding::JpegLs => 0,
            Encoding::Jpeg2000 => 1,
            _ => return codec::decode(stream, shape),
        };
        let Some(settings) = &self.worker else { return codec::decode(stream, shape) };
        let request = [
            code,
            shape.columns as u64,
            shape.rows as u64,
            shape.bytes as u64,
            self.memory,
            stream.len() as u64,
        ];
        // A worker may die while it is written to.
        let _guard = BrokenPipesAreErrors::new();
        let Ok(mut worker) = self.worker_for(settings, request) else {
            return Err("needs a decoder in a process of its own, which cannot be started".into());
        };
        let deadline = Instant::now() + settings.timeout;
        lock(&self.watch.running).push((deadline, worker.child.clone()));
        let answer = exchange(&mut worker, stream, shape);
        lock(&self.watch.running).retain(|(_, child)| !Arc::ptr_eq(child, &worker.child));
        match answer {
            Ok(answer) => {
                self.take_back(worker, deadline);
                answer
            }
            Err(_) => {
                worker.end();
                Err(if Instant::now() >= deadline {
                    format!("kept its decoder busy for {} s", settings.timeout.as_secs_f64()).into()
                } else {
                    "crashed its decoder, or asked it for too much memory".into()
                })
            }
        }
    }

    /// A worker that was given `request`: an idle one, or a new one where there is none or it has died meanwhile.
    /// A request fits into the pipe, so that writing it takes no time that would have to be watched.
    fn worker_for(&self, settings: &CodecWorker, request: [u64; REQUEST_WORDS]) -> io::Result<Worker> {
        let idle = lock(&self.idle).pop();
        if let Some(mut worker) = idle {
            if write_words(&mut worker.stdin, request).is_ok() {
                return Ok(worker);
            }
            worker.end();
        }
        let mut worker = self.spawn(settings)?;
        // One that has crashed by now is found out like one that crashes later: it does not answer.
        let _ = write_words(&mut worker.stdin, request);
        Ok(worker)
    }

    /// Keeps a worker that has answered for the next frame, unless the watch may have ended it since.
    fn take_back(&self, worker: Worker, deadline: Instant) {
        if Instant::now() < deadline {
            lock(&self.idle).push(worker);
        } else {
            worker.end();
        }
    }

    fn spawn(&self, settings: &CodecWorker) -> io::Result<Worker> {
        let mut command = Command::new(&settings.program);
        command.args(&settings.args).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        // A program without a console would get one to see.
        #[cfg(windows)]
        std::os::windows::process::CommandExt::creation_flags(&mut command, CREATE_NO_WINDOW);
        let mut child = command.spawn()?;
        let (Some(stdin), Some(stdout)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(io::ErrorKind::BrokenPipe.into());
        };
        let mut watcher = lock(&self.watcher);
        if watcher.is_none() {
            let watch = self.watch.clone();
            *watcher =
                Some(thread::Builder::new().name("codec watch".to_owned()).spawn(move || watch.run())?);
        }
        Ok(Worker { child: Arc::new(Mutex::new(child)), stdin, stdout: BufReader::new(stdout) })
    }
}

impl Drop for Codecs {
    fn drop(&mut self) {
        lock(&self.idle).drain(..).for_each(Worker::end);
        self.watch.done.store(true, Ordering::Release);
        if let Some(watcher) = lock(&self.watcher).take() {
            watcher.thread().unpark();
            let _ = watcher.join();
        }
    }
}

/// Sends the codestream of a request and waits for what becomes of it.
fn exchange(
    worker: &mut Worker,
    stream: &[u8],
    shape: &FrameShape,
) -> io::Result<Result<Decoded, CodecFault>> {
    worker.stdin.write_all(stream)?;
    worker.stdin.flush()?;
    let [kind, bytes, length] = read_words::<ANSWER_WORDS>(&mut worker.stdout)?;
    // Memory is taken for what can be asked for only.
    let largest = match kind {
        SAMPLES => (shape.columns as u64).saturating_mul(shape.rows as u64).saturating_mul(4),
        _ => LONGEST_MESSAGE,
    };
    if length > largest {
        return Err(io::ErrorKind::InvalidData.into());
    }
    let mut content = vec![0; length as usize];
    worker.stdout.read_exact(&mut content)?;
    let message = |content: &[u8]| String::from_utf8_lossy(content).into_owned();
    Ok(match kind {
        SAMPLES if shape.holds(&content, bytes) => Ok(Decoded { samples: content, bytes: bytes as usize }),
        DAMAGED => Err(CodecFault::Damaged(message(&content))),
        UNSUPPORTED => Err(CodecFault::Unsupported(message(&content))),
        _ => return Err(io::ErrorKind::InvalidData.into()),
    })
}

impl FrameShape {
    /// Whether these are enough samples of so many bytes.
    fn holds(&self, samples: &[u8], bytes: u64) -> bool {
        matches!(bytes, 1 | 2 | 4) && samples.len() as u64 >= bytes * (self.columns * self.rows) as u64
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// Whether it dies before it is written to or after makes no difference.
    #[test]
    fn a_worker_that_dies_at_once_has_crashed() {
        let mut codecs = Codecs::new(1, &CancelToken::new());
        codecs.worker = Some(CodecWorker::new("false", [""; 0]));
        let shape =
            FrameShape { encoding: Encoding::JpegLs, columns: 1, rows: 1, bytes: 1, single_bits: false };
        for _ in 0..100 {
            let Err(CodecFault::Damaged(message)) = codecs.decode(&[0; 70_000], &shape) else {
                panic!("it decodes nothing");
            };
            assert!(message.starts_with("crashed its decoder"), "{message}");
        }
    }

    /// Past its deadline a worker may be dead, although it has answered.
    #[test]
    fn a_late_worker_gets_no_other_frame() {
        let codecs = Codecs::new(1, &CancelToken::new());
        let settings = CodecWorker::new("cat", [""; 0]);
        for (left, kept) in [(Duration::ZERO, 0), (settings.timeout, 1)] {
            let worker = codecs.spawn(&settings).unwrap();
            codecs.take_back(worker, Instant::now() + left);
            assert_eq!(lock(&codecs.idle).len(), kept, "{left:?}");
        }
    }
}
