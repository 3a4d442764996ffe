//! Lumivox behind a C ABI, as the Unity package calls it (`unity/com.lumivox`, `Runtime/Native`).
//!
//! Unity's half gathers what stands in its scenes and replays recordings with its own graphics API; everything else is
//! here. A frame goes: [`stage`] takes worlds and views and gives recordings, [`steps`] lays them out as flat structs whose
//! payloads point into the renderer's own memory, and takes what became of them. `volume` and `look` are what worlds
//! are made of, `labels` and `clips` what parts of a volume are and are left, `parts` what is seen of it in place of the
//! patient, `jobs` what takes long, and `import` what one of those is told. [`scene`] opens scene documents, and [`saving`]
//! makes one of a world.
//!
//! # The border
//! - Functions that give a pointer give null, those that give an `int32_t` a negative number where something is wrong;
//!   `lumivox_last_error` says what, to the thread that asked. No panic crosses: it becomes such an error.
//! - Handles are freed once by the function of their name; to free null does nothing. Scans, transfer functions and maps
//!   are counted inside: whatever shows them goes on.
//! - Any thread may call anything, but a stage and its recordings belong to one thread at a time.
//! - Strings are UTF-8, ended by 0.
//!
//! `include/lumivox_unity.h` is made from this by a test, which fails where it is not what is here.

pub mod abi;
mod border;
mod clips;
mod convert;
mod import;
mod jobs;
mod labels;
mod look;
mod parts;
mod picture;
mod pose;
pub mod saving;
pub mod scene;
pub mod scene_light;
pub mod stage;
pub mod steps;
mod stored;
mod volume;

pub use border::{
    LumivoxText, lumivox_abi_version, lumivox_check_layout, lumivox_last_error, lumivox_text,
    lumivox_text_free, lumivox_version,
};
pub use jobs::*;
pub use labels::*;
pub use look::*;
pub use volume::*;
