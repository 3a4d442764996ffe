//! Errors as exceptions: a class for each kind, with the words that all hosts have.

use std::fmt::Display;

use lumivox_import::ImportError;
use lumivox_wgpu::HeadlessError;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt, PyValueError};
use pyo3::{PyErr, create_exception};

create_exception!(lumivox, LumivoxError, PyException, "What goes wrong in Lumivox.");
create_exception!(lumivox, ScanError, LumivoxError, "A scan cannot be read, or its parts make no volume.");
create_exception!(lumivox, GpuError, LumivoxError, "There is no usable GPU, or it was lost.");
create_exception!(lumivox, RenderError, LumivoxError, "A scene cannot be rendered.");

/// An argument that makes no sense.
pub fn value(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A scan that is none.
pub fn scan(error: impl Display) -> PyErr {
    ScanError::new_err(error.to_string())
}

/// What an import ends with.
pub fn import(error: ImportError) -> PyErr {
    match error {
        ImportError::Cancelled(_) => cancelled(),
        error => scan(error),
    }
}

/// Somebody stopped it who was not a signal; a signal's own exception wins over this.
pub fn cancelled() -> PyErr {
    PyKeyboardInterrupt::new_err("cancelled")
}

/// A GPU that fails.
pub fn gpu(error: lumivox_wgpu::GpuError) -> PyErr {
    match error {
        lumivox_wgpu::GpuError::Samples(error) => RenderError::new_err(error.to_string()),
        error => GpuError::new_err(error.to_string()),
    }
}

/// An image that could not be begun.
pub fn headless(error: HeadlessError) -> PyErr {
    match error {
        HeadlessError::Render(error) => RenderError::new_err(error.to_string()),
        HeadlessError::Gpu(error) => gpu(error),
    }
}
