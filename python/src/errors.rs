//! Errors as exceptions: a class for each kind, with the words that all hosts have.

use std::fmt::Display;
use std::io;
use std::path::Path;

use lumivox_import::ImportError;
use lumivox_wgpu::HeadlessError;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use pyo3::{PyErr, create_exception};

create_exception!(lumivox, LumivoxError, PyException, "What goes wrong in Lumivox.");
create_exception!(lumivox, ScanError, LumivoxError, "A scan cannot be read, or its parts make no volume.");
create_exception!(lumivox, GpuError, LumivoxError, "There is no usable GPU, or it was lost.");
create_exception!(lumivox, RenderError, LumivoxError, "A scene cannot be rendered.");

/// An argument that makes no sense.
pub fn value(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// What is wrong with what was described.
pub fn words(error: serde_json::Error) -> PyErr {
    let all = error.to_string();
    // Its own place stands at the end of its words, and nobody sees that text.
    value(all.rsplit_once(" at line ").map_or(all.as_str(), |(why, _)| why))
}

/// A scan that is none.
pub fn scan(error: impl Display) -> PyErr {
    ScanError::new_err(error.to_string())
}

/// What an import ends with.
pub fn import(error: ImportError) -> PyErr {
    match error {
        ImportError::Cancelled(_) => cancelled(),
        ImportError::Io { ref path, ref source } => file_error(path, source, &error.to_string()),
        error => scan(error),
    }
}

/// What an import ends with that a place of a scene asks for.
pub fn import_at(place: &str, error: ImportError) -> PyErr {
    match error {
        ImportError::Cancelled(_) => cancelled(),
        ImportError::Io { ref path, ref source } => file_error(path, source, &format!("{place}: {error}")),
        error => scan(format!("{place}: {error}")),
    }
}

/// A file that cannot be read or written.
pub fn file(path: &Path, error: &io::Error) -> PyErr {
    file_error(path, error, &format!("{}: {error}", path.display()))
}

/// The package's own class, which is the system's, too.
fn file_error(path: &Path, error: &io::Error, words: &str) -> PyErr {
    let class = match error.kind() {
        io::ErrorKind::NotFound => "MissingFileError",
        _ => "FileError",
    };
    Python::attach(|py| {
        let made = py.import("lumivox.errors").and_then(|module| module.getattr(class));
        made.and_then(|class| class.call1((words, path, error.raw_os_error())))
            // The program that decodes has the native half alone.
            .map_or_else(|_| scan(words), PyErr::from_value)
    })
}

/// Somebody stopped it who was not a signal; a signal's own exception wins over this.
pub fn cancelled() -> PyErr {
    PyKeyboardInterrupt::new_err("cancelled")
}

/// A GPU that fails.
pub fn gpu(error: lumivox_wgpu::GpuError) -> PyErr {
    match error {
        lumivox_wgpu::GpuError::Samples(error) => RenderError::new_err(error.to_string()),
        error @ (lumivox_wgpu::GpuError::NoAdapter | lumivox_wgpu::GpuError::Unsuitable { .. }) => {
            GpuError::new_err(format!("{error}. 'python -m lumivox doctor' says what to install"))
        }
        error => GpuError::new_err(error.to_string()),
    }
}

/// A GPU in a process that was forked from one that used it.
pub fn forked() -> PyErr {
    GpuError::new_err(
        "this process was forked from one that had asked for its GPUs, which do not come along. Have processes started, not \
         forked: multiprocessing.set_start_method('spawn') or a ProcessPoolExecutor(mp_context=get_context('spawn')); or ask \
         for GPUs in the child alone",
    )
}

/// An image that could not be begun.
pub fn headless(error: HeadlessError) -> PyErr {
    match error {
        HeadlessError::Render(error) => RenderError::new_err(error.to_string()),
        HeadlessError::Gpu(error) => gpu(error),
    }
}
