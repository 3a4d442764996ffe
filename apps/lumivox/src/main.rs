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
