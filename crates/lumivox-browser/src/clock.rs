//! The browser's clock, and its turns.

use std::time::Duration;

use js_sys::{Function, Promise, Reflect};
use lumivox_core::host::{Host, Work, set_host};
use wasm_bindgen::prelude::*;
use wasm_bindgen_futures::JsFuture;

/// The browser's clock, and no thread.
struct Browser;

/// A function of the window's or the Worker's, with what it belongs to.
fn of_global(path: &[&str]) -> Option<(JsValue, Function)> {
    let (name, owners) = path.split_last()?;
    let owner = owners.iter().try_fold(JsValue::from(js_sys::global()), |owner, name| {
        Reflect::get(&owner, &JsValue::from_str(name)).ok()
    })?;
    let function = Reflect::get(&owner, &JsValue::from_str(name)).ok()?.dyn_into().ok()?;
    Some((owner, function))
}

impl Host for Browser {
    fn now(&self) -> Duration {
        thread_local! {
            static NOW: Option<(JsValue, Function)> = of_global(&["performance", "now"]);
        }
        let milliseconds =
            NOW.with(|now| now.as_ref().and_then(|(clock, now)| now.call0(clock).ok()?.as_f64()));
        Duration::from_secs_f64(milliseconds.unwrap_or(0.0).max(0.0) / 1000.0)
    }

    fn spare_threads(&self) -> usize {
        0
    }

    fn spawn(&self, _: &str, work: Work) -> Result<(), Work> {
        Err(work)
    }

    fn sleep(&self, _: Duration) {}
}

/// Makes the browser the host, before anything else in a page, and in each of its Workers.
pub fn begin() {
    // A second program on the same memory there is not.
    let _ = set_host(Box::new(Browser));
}

/// Lets the browser do what waits: draw, hear of the mouse, finish what a GPU was asked for.
pub async fn pause() {
    let Some((owner, set_timeout)) = of_global(&["setTimeout"]) else { return };
    let turn = Promise::new(&mut |done, _| {
        let _ = set_timeout.call2(&owner, &done, &0.into());
    });
    let _ = JsFuture::from(turn).await;
}
