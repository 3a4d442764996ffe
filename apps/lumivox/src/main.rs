//! The `lumivox` command: medical scans to path-traced images.

mod args;
mod commands;
mod exit;
mod inputs;
mod output;
mod progress;
mod trace;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};

fn main() -> ExitCode {
    quiet_mesa();
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
            eprintln!("{failure}");
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
