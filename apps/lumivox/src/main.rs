//! The `lumivox` command: medical scans to path-traced images.

mod args;
mod classification;
mod cluster;
mod commands;
mod exit;
mod inputs;
mod looks;
mod opening;
mod output;
mod progress;
mod trace;

use std::{
    backtrace::{Backtrace, BacktraceStatus},
    panic::PanicHookInfo,
    process::ExitCode,
    sync::{Mutex, PoisonError},
    thread::{self, available_parallelism},
};

use clap::Parser;

use args::{Cli, Command, ManualArgs};
use exit::{Exit, Failure};
use lumivox_import::CodecWorker;

/// What the process exits with after a fault of ours, as Rust programs do.
const EXIT_PANIC: u8 = 101;

/// The last panic, in words. Only one that reaches `main` is said: damaged files make libraries panic, and the
/// importer turns that into an error about the file.
static PANIC: Mutex<String> = Mutex::new(String::new());

fn main() -> ExitCode {
    if std::env::args_os().nth(1).is_some_and(|first| first == CODEC_WORKER) {
        return decode_frames();
    }
    quiet_mesa();
    std::panic::set_hook(Box::new(remember_panic));
    ignore_file_size_signal();
    start_workers();
    if let Ok(program) = std::env::current_exe() {
        lumivox_import::set_codec_worker(Some(CodecWorker::new(program, [CODEC_WORKER])));
    }
    match std::panic::catch_unwind(run) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(failure)) => {
            progress::say(&failure.to_string());
            tell_programs(&failure.message, failure.exit as u8);
            failure.exit.into()
        }
        Err(_) => {
            let panic = PANIC.lock().unwrap_or_else(PoisonError::into_inner);
            let message = format!("this is a bug in Lumivox, please report it: {panic}");
            progress::say(&format!("error: {message}"));
            tell_programs(&message, EXIT_PANIC);
            ExitCode::from(EXIT_PANIC)
        }
    }
}

/// With `--json` there is an object on stdout, whatever goes wrong.
fn tell_programs(message: &str, exit: u8) {
    if std::env::args_os().any(|argument| argument == "--json") && !output::has_printed() {
        // Where nobody reads, nobody is told.
        let _ = output::print(&format!("{:#}\n", commands::error_object(message, exit)));
    }
}

/// The first argument of this program where it is a decoder for another run of it, which survives its crashes.
const CODEC_WORKER: &str = "--codec-worker";

fn decode_frames() -> ExitCode {
    // What a decoder panics about, the other end hears as a damaged frame.
    std::panic::set_hook(Box::new(|_| {}));
    match lumivox_import::serve_codecs(std::io::stdin().lock(), std::io::stdout().lock()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => ExitCode::FAILURE,
    }
}

fn run() -> Result<(), Failure> {
    // clap ends the process itself for --help and --version (0).
    if std::env::args_os().nth(1).is_some_and(|first| first == "manual") {
        return commands::manual::run(&ManualArgs::parse_from(std::env::args_os().skip(1)).out);
    }
    let cli = Cli::try_parse().unwrap_or_else(|error| {
        if error.use_stderr() {
            tell_programs(error.to_string().trim_start_matches("error: ").trim_end(), Exit::Usage as u8);
        }
        error.exit()
    });
    match cli.command {
        Command::Render(args) => commands::render::run(&args),
        Command::Scene(command) => commands::scene::run(&command),
        Command::Info(args) => commands::info::run(&args),
        Command::Import(args) => commands::import::run(&args),
        Command::Phantom(args) => commands::phantom::run(&args),
        Command::Presets => commands::presets::run(),
        Command::Doctor(args) => commands::doctor::run(&args),
    }
}

/// Mesa's device-select layer asks the Wayland server which GPU is the desktop's, and complains on stderr where there
/// is no desktop. Nothing is lost by leaving it out there.
fn quiet_mesa() {
    if cfg!(target_os = "linux") && std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: the process has no other thread yet.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

/// Keeps a panic's message and place, and with `RUST_BACKTRACE` set the way there.
fn remember_panic(info: &PanicHookInfo<'_>) {
    let mut words = info.payload_as_str().unwrap_or("a panic").to_owned();
    if let Some(place) = info.location() {
        words += &format!(" ({place})");
    }
    let backtrace = Backtrace::capture();
    if backtrace.status() == BacktraceStatus::Captured {
        words += &format!("\n{backtrace}");
    }
    *PANIC.lock().unwrap_or_else(PoisonError::into_inner) = words;
}

/// A file that grows over its limit (`ulimit -f`) is to be an error of the write, not the end of the process.
fn ignore_file_size_signal() {
    #[cfg(unix)]
    // SAFETY: no handler is installed, the signal is only ignored.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}

/// Threads that Ctrl-C and the GPU's driver need.
const OTHER_THREADS: usize = 4;

/// Where fewer threads may start than there are cores (`ulimit -u`, a container's limit), the work is done by fewer;
/// rayon alone would give up.
fn start_workers() {
    let wanted = available_parallelism().map_or(1, |n| n.get());
    let gate = Mutex::new(());
    let started = thread::scope(|scope| {
        let _closed = gate.lock();
        let start = |_: &usize| thread::Builder::new().spawn_scoped(scope, || drop(gate.lock())).is_ok();
        (0..wanted + OTHER_THREADS).take_while(start).count()
    });
    let workers = started.saturating_sub(OTHER_THREADS);
    let pool = rayon::ThreadPoolBuilder::new();
    let pool = match workers {
        0 => pool.num_threads(1).use_current_thread(),
        _ if workers < wanted => pool.num_threads(workers),
        _ => pool,
    };
    // Now, before the GPU's driver takes its threads.
    if let Err(error) = pool.build_global() {
        progress::say(&format!("note: cannot start worker threads: {error}"));
    }
}
