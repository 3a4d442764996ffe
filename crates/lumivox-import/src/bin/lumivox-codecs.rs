//! Decodes frames for a host that cannot run itself a second time, such as an engine's extension: the program of a
//! [`CodecWorker`](lumivox_import::CodecWorker), which survives its crashes.

use std::io::{stdin, stdout};
use std::process::ExitCode;

fn main() -> ExitCode {
    // Only the host reads what is said here, and it knows by the pipe's end.
    match lumivox_import::serve_codecs(stdin().lock(), stdout().lock()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => ExitCode::FAILURE,
    }
}
