//! Slow, clear, independent f64 integrators on the CPU: the evidence the GPU is checked against.
//!
//! Nothing here is clever. Where the GPU kernel walks local majorants through lookup tables and connects every vertex
//! to the light, this crate takes the estimator that is easiest to believe: *analog* delta tracking under one global
//! majorant per volume, no next-event estimation but to the engine's lights, one by one, no multiple importance
//! sampling, no Russian roulette, and curves and filters evaluated from their definitions in f64. The two share the
//! definitions of `lumivox-core` and nothing else, so an error in one does not hide in the other.
//!
//! The integrator itself is held against mathematics: [`quadrature`] knows transmittance, single scattering and the
//! light that a half-space returns without drawing a random number.
//!
//! ```
//! use lumivox_reference::{ReferenceSettings, render};
//! # let scene = lumivox_core::Scene::default();
//! # let camera = lumivox_core::Orbit {
//! #     target: Default::default(), azimuth: 0.0, elevation: 0.0, distance: 1.0, vertical_fov: 0.5 }.camera();
//! let image = render(&scene, &camera, &ReferenceSettings { width: 8, height: 8, samples: 4, ..Default::default() });
//! assert_eq!(image.radiance.len(), 64);
//! ```
//!
//! # Directions
//! A direction of travel points the way the path is traced, away from the camera. `wo` points back along it, towards
//! the viewer; `wi` points the way the path goes on, towards the light.

mod classification;
pub mod image;
pub mod lights;
pub mod medium;
pub mod path;
pub mod quadrature;
pub mod rng;
pub mod sampling;
pub mod scattering;

pub use image::ReferenceImage;
pub use path::{DiffuseSample, EnvironmentLookup, ReferenceSettings, render, sent_diffusely};

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
