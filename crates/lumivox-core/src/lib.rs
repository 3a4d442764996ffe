//! The vocabulary of Lumivox: what is rendered, from where, and in which light.
//!
//! Nothing here knows a GPU, a file format, a window or an engine. The walk of a scan starts with a
//! [`Volume`], is given a look by a [`TransferFunction`] inside a [`Medium`], is placed in a [`Scene`] and seen
//! by a [`PerspectiveCamera`].
//!
//! # Conventions
//! - **Patient space** is DICOM's LPS in millimetres: +x to the patient's left, +y to the back, +z to the head.
//! - **World space** is right-handed, +y up, in metres; a camera looks along -z. [`world_from_patient`] places an
//!   upright patient so that a viewer on the +z side sees the face.
//! - **Voxel space** has voxel `(i, j, k)`'s *centre* at `(i, j, k)`; the volume fills `-0.5 ..= dims - 0.5`.
//! - Transforms are named `a_from_b`: they take coordinates in `b` and give coordinates in `a`.
//! - Colours are linear, with sRGB primaries.

pub mod background;
pub mod calibration;
pub mod camera;
pub mod classification;
pub mod color;
pub mod document;
pub mod environment;
pub mod fill;
pub mod framing;
mod histogram;
pub mod host;
pub mod labels;
pub mod lasso;
pub mod light;
pub mod medium;
mod percentiles;
pub mod placement;
pub mod presets;
pub mod scene;
mod seen_labels;
pub mod spelling;
pub mod statistics;
pub mod subject;
pub mod task;
pub mod transfer_function;
pub mod volume;
pub mod words;

pub use glam;

pub use background::Background;
pub use calibration::CtPeaks;
pub use camera::{Camera, HostCamera, Orbit, PerspectiveCamera, Projection, Ray};
pub use classification::{ClipKind, ClipShape, LabelStyle, Labelling, MOST_CLIP_SHAPES, Peel};
pub use environment::{Environment, EnvironmentMap, EnvironmentSource};
pub use histogram::Histogram;
pub use labels::{Label, LabelError, LabelVolume, Misplaced, UNLABELLED};
pub use lasso::Lasso;
pub use light::{Cone, Falloff, Lamp, Light, LightKind};
pub use medium::{ExtinctionSpace, Filter, GradientFunction, Medium, SurfaceReflection};
pub use presets::{Organ, Preset, UnknownPreset};
pub use scene::{Scene, VolumeInstance, world_from_patient};
pub use seen_labels::LabelValues;
pub use statistics::{ValueStatistics, looks_like_labels};
pub use subject::{BodyPart, Focus, Subject};
pub use task::{CancelToken, Cancelled, Progress, WorkStage};
pub use transfer_function::{ColorStop, Ease, OpacityKnot, TransferFunction, TransferFunctionError};
pub use volume::{Modality, Volume, VolumeError, Voxels};

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
