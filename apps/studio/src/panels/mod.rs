//! The parts of the window, each a function of the state that may ask for actions.

pub mod cube;
pub mod curve;
pub mod cut;
pub mod dialogs;
pub mod handles;
pub mod lasso;
pub mod light;
pub mod look;
pub mod marks;
pub mod measure;
pub mod names;
pub mod side;
pub mod slice;
pub mod strip;
pub mod structures;
pub mod three_d;
pub mod tools;
pub mod top;
pub mod views;
pub mod welcome;
