//! Why a scene cannot be recorded.

/// Why a scene cannot be recorded for a device.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// Not even the coarsest copies of all volumes fit into the GPU's textures.
    #[error("this GPU has no room for {count} volumes, however coarse. Leave some out")]
    NoRoom {
        /// Volumes in the scene.
        count: usize,
    },
    /// A buffer is larger than the GPU binds at once.
    #[error("the {what} needs {bytes} bytes, more than the {limit} that this GPU can bind. {remedy}")]
    BufferTooLarge {
        /// What it holds.
        what: &'static str,
        /// Its size.
        bytes: u64,
        /// The GPU's limit.
        limit: u64,
        /// What to do.
        remedy: &'static str,
    },
    /// The environment map has more texels along an axis than the GPU's textures.
    #[error(
        "an environment map of {width} x {height} texels is larger than this GPU's textures ({limit}). Scale it down"
    )]
    EnvironmentTooLarge {
        /// Texels around.
        width: usize,
        /// Texels from pole to pole.
        height: usize,
        /// Largest side.
        limit: u32,
    },
    /// The camera's place or field of view is not a number, or it sees nothing.
    #[error(
        "the camera's position, direction and field of view must be finite, and the field of view between 0 and 180 degrees"
    )]
    Camera,
    /// Pixels whose paths the driver ended: what was asked for is more than what there is.
    #[error(
        "{pixels} pixels lack samples: the GPU's driver ended their paths before their time. Lower the density, use \
         fewer clip shapes, or render on another GPU"
    )]
    SamplesLost {
        /// Pixels concerned.
        pixels: u32,
    },
    /// An image without pixels.
    #[error("an image needs at least one pixel, not {width} x {height}")]
    EmptyImage {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
}
