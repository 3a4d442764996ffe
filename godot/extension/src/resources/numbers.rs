//! Numbers that scripts give.

use godot::prelude::*;

/// Whether a property takes a number, or a vector, that may not be `finite`. Says so where it does not.
pub fn takes(property: &str, finite: bool) -> bool {
    if !finite {
        godot_error!("{property} takes neither NaN nor infinity, and stays as it was.");
    }
    finite
}
