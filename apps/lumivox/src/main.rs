//! The `lumivox` command: medical scans to path-traced images.

mod args;
mod commands;
mod exit;
mod inputs;
mod output;
mod progress;
mod trace;

use std::{
    panic::PanicHookInfo,
    process::ExitCode,
    sync::Mutex,
    thread::{self, available_parallelism},
};

use clap::Parser;

use args::{Cli, Command};

fn main() -> ExitCode {
    quiet_mesa();
    std::panic::set_hook(Box::new(report_panic));
    ignore_file_size_signal();
    limit_workers();
    // clap ends the process itself on wrong usage (2) and for --help and --version (0).
    let result = match Cli::parse().command {
        Command::Render(args) => commands::render::run(&args),
        Command::Info(args) => commands::info::run(&args),
        Command::Phantom(args) => commands::phantom::run(&args),
        Command::Presets => commands::presets::run(),
        Command::Doctor => commands::doctor::run(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            progress::say(&failure.to_string());
            failure.exit.into()
        }
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

/// A fault of ours is said in words that help; with `RUST_BACKTRACE` set, also where it came from.
fn report_panic(info: &PanicHookInfo<'_>) {
    let what = info.payload_as_str().unwrap_or("a panic");
    let place = info.location().map(|place| format!(" ({place})")).unwrap_or_default();
    progress::say(&format!("error: this is a bug in Lumivox, please report it: {what}{place}"));
    let backtrace = std::backtrace::Backtrace::capture();
    if backtrace.status() == std::backtrace::BacktraceStatus::Captured {
        progress::say(&backtrace.to_string());
    }
}

/// A file that grows over its limit (`ulimit -f`) is to be an error of the write, not the end of the process.
fn ignore_file_size_signal() {
    #[cfg(unix)]
    // SAFETY: no handler is installed, the signal is only ignored.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}

/// Where fewer threads may start than there are cores (`ulimit -u`, a container's limit), the work is done by fewer;
/// rayon alone would give up.
fn limit_workers() {
    let wanted = available_parallelism().map_or(1, |n| n.get());
    let gate = Mutex::new(());
    let started = thread::scope(|scope| {
        let _closed = gate.lock();
        let start = |_: &usize| thread::Builder::new().spawn_scoped(scope, || drop(gate.lock())).is_ok();
        (0..wanted).take_while(start).count()
    });
    if started < wanted {
        // The GPU's driver and Ctrl-C need some as well.
        let builder = rayon::ThreadPoolBuilder::new();
        let builder = match started / 2 {
            0 => builder.num_threads(1).use_current_thread(),
            workers => builder.num_threads(workers),
        };
        if let Err(error) = builder.build_global() {
            progress::say(&format!("note: cannot start worker threads: {error}"));
        }
    }
}
