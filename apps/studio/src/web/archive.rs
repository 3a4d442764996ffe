//! A page asks no archive: it makes no request after it is loaded.

use std::path::PathBuf;

use eframe::egui;

use crate::jobs::{Busy, Wake};
use crate::settings::Settings;
use crate::state::State;
use crate::words::Language;

/// Whether archives are asked here.
pub const IS_THERE: bool = false;

/// There is none.
#[derive(Clone, Debug)]
pub enum Request {}

/// Nothing.
pub struct Archive;

impl Archive {
    /// Nothing.
    pub fn new(_: Option<PathBuf>, _: &Settings) -> Self {
        Self
    }

    /// Never.
    pub fn fetch(&mut self, request: Request, _: &Wake) {
        match request {}
    }

    /// Nothing.
    pub fn poll(&mut self, _: Language) -> Option<Result<PathBuf, String>> {
        None
    }

    /// Nothing.
    pub fn busy(&self) -> Option<Busy> {
        None
    }

    /// Nothing.
    pub fn give_up(&mut self) {}

    /// Draws nothing.
    pub fn show(&mut self, _: &egui::Context, _: &mut State, _: &Wake) {}
}
