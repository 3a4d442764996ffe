//! What can go wrong on a GPU.

use lumivox_renderer::RenderError;

/// What went wrong on the GPU.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No Vulkan, Metal or Direct3D 12 device was found.
    #[error("no GPU and no software Vulkan was found")]
    NoAdapter,
    /// No device has the name asked for.
    #[error("no GPU's name contains '{wanted}'. There are: {available}")]
    NoSuchGpu {
        /// What was asked for.
        wanted: String,
        /// The devices there are.
        available: String,
    },
    /// There are not so many devices.
    #[error("there is no GPU {index}. There are: {available}")]
    NoSuchIndex {
        /// What was asked for, counted from 0.
        index: usize,
        /// The devices there are.
        available: String,
    },
    /// The device lacks something that rendering needs.
    #[error("{gpu} cannot be used: {reason}")]
    Unsuitable {
        /// The device.
        gpu: String,
        /// What is missing.
        reason: String,
    },
    /// The device's memory is full.
    #[error("the GPU's memory is full: {0}. Render a smaller image, fewer volumes, or on another GPU")]
    OutOfMemory(String),
    /// The driver stopped: it was reset, unplugged, or a dispatch took longer than the system allows.
    #[error("the GPU was lost: {0}")]
    Lost(String),
    /// The driver ended paths before their time.
    #[error(transparent)]
    Samples(RenderError),
    /// The device refused a command; a fault of ours.
    #[error("the GPU refused a command, which is a fault in Lumivox; please report it: {0}")]
    Refused(String),
}

/// Why an image could not be begun.
#[derive(Clone, Debug, thiserror::Error)]
pub enum HeadlessError {
    /// The scene does not fit the device.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The device failed before there was anything to keep.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}
