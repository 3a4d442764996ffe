//! How we know that an image is right: statistical tests, image differences, and scenes worth testing.
//!
//! A dev-dependency only. Random results are judged by tests with a stated significance ([`chi_square`] for samplers
//! of directions, [`z_test`] for images), finished pictures by how different they look ([`flip`], [`golden`]), moving ones
//! also by how steady they are ([`motion`]).
//! [`orthanc`] runs an archive of a hospital. [`scenes`] holds the scenes that the GPU kernel and the f64 reference both render, [`hosts`] scenes as hosts wrote them.

pub mod chi_square;
pub mod failures;
pub mod flip;
pub mod golden;
pub mod hosts;
pub mod motion;
pub mod orthanc;
pub mod png_io;
pub mod scenes;
pub mod special;
pub mod z_test;
