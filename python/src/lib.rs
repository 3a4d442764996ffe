//! The native half of the Python package `lumivox`: volumes, films and the way to the GPU. What people call is in
//! `python/lumivox`; the types that they see of this are in `_native.pyi` there.
//!
//! Scenes are plain Python objects, which can be pickled and compared, and which a cluster sends. They come as documents, the same
//! as scenes in files (`description.rs`). Only voxels, films and GPUs live here.

mod clip_shapes;
mod description;
mod ending;
mod errors;
mod film;
mod fork;
mod gpus;
mod labels;
mod looks;
mod memory;
mod phantoms;
mod pictures;
mod volume;
mod wait;

use pyo3::prelude::*;

#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::clip_shapes::{clip_shape, is_solid};
    #[pymodule_export]
    use crate::description::{frame, load_scene, look_at, save_scene, unseen_labels, usual_angles};
    #[pymodule_export]
    use crate::errors::{GpuError, LumivoxError, RenderError, ScanError};
    #[pymodule_export]
    use crate::film::Film;
    #[pymodule_export]
    use crate::gpus::{Moving, Renderer, Still, gpus};
    #[pymodule_export]
    use crate::labels::{Labels, load_labels};
    #[pymodule_export]
    use crate::looks::{
        Map, default_preset, load_environment, load_transfer_function, preset_look, presets,
        save_transfer_function, transfer_function_at,
    };
    #[pymodule_export]
    use crate::memory::volume_of_samples;
    #[pymodule_export]
    use crate::phantoms::{phantom, write_dicom_series};
    #[pymodule_export]
    use crate::pictures::{encode_exr, encode_png};
    #[pymodule_export]
    use crate::volume::{Volume, load, scan, serve_codecs, set_codec_worker};

    use pyo3::prelude::*;

    /// The version that everything of Lumivox has.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        crate::gpus::quiet_mesa();
        crate::fork::imported();
        crate::ending::imported(module)
    }
}
