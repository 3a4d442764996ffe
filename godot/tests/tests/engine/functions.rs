//! The transfer-function editor with functions that hold little, and with others that edit them too.

use serde_json::json;

use crate::shown::{run_scene_in_window, told};

#[test]
fn an_empty_function_can_be_begun_and_a_disturbed_edit_breaks_nothing() {
    let told = told(&run_scene_in_window("edit_function", "edit_function", &json!([])).1, "function");
    let checks = told.as_object().unwrap();
    let failed: Vec<_> = checks.iter().filter(|(_, ok)| **ok != true).map(|(what, _)| what).collect();
    assert!(failed.is_empty(), "{failed:#?}");
    assert_eq!(checks.len(), 20, "some checks were left out: {checks:#?}");
}
