//! The parts of the window, each a function of the state that may ask for actions.

pub mod dialogs;
pub mod look;
pub mod strip;
pub mod top;
pub mod views;
pub mod welcome;
