//! How good a live view's picture is while things move: `cargo bench -p lumivox-wgpu --bench motion OUT [--quick] [OPTION ...]`.
//!
//! Films of 60 frames a second, each with so many milliseconds of tracing a frame; chosen frames are compared with the converged
//! picture of the same frame. `benches/README.md` says what is measured and what the options are; `--help` lists them.

mod bench;

use std::process::ExitCode;

fn main() -> ExitCode {
    match bench::run(std::env::args().skip(1), &mut std::io::stdout()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("motion: {why}");
            ExitCode::FAILURE
        }
    }
}
