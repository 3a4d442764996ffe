//! Kernels made before scenes want them: what [`Lumivox.warm_up`](crate::server::Lumivox) does over a few frames.

use std::sync::{Mutex, MutexGuard, PoisonError};

use lumivox_renderer::recording::Kernel;
use lumivox_renderer::{Features, ViewKind};

use crate::executor::workshop;
use crate::render;
use crate::server::on_render_thread;

/// What scenes may hold, by the names that scripts use.
const NAMES: [(&str, Features); 5] = {
    const NONE: Features =
        Features { environment: false, surface: false, filters: false, lights: false, many_volumes: false };
    [
        ("environment", Features { environment: true, ..NONE }),
        ("surface", Features { surface: true, ..NONE }),
        ("filters", Features { filters: true, ..NONE }),
        ("lights", Features { lights: true, ..NONE }),
        ("many_volumes", Features { many_volumes: true, ..NONE }),
    ]
};

/// What was asked for and not announced yet.
struct WarmUp {
    kernels: Vec<Kernel>,
    /// How many of them have run, where they have to.
    primed: usize,
}

static WARM_UP: Mutex<Option<WarmUp>> = Mutex::new(None);

fn warm_up() -> MutexGuard<'static, Option<WarmUp>> {
    WARM_UP.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The features of these names, all where there is no name; or the name that stands for none.
pub fn features(names: &[String]) -> Result<Features, String> {
    if names.is_empty() {
        return Ok(Features::ALL);
    }
    names.iter().try_fold(Features::default(), |all, name| {
        let known = NAMES.iter().find(|(known, _)| known == name);
        known.map(|(_, one)| all.union(*one)).ok_or_else(|| {
            let names: Vec<&str> = NAMES.iter().map(|(name, _)| *name).collect();
            format!("There is no feature '{name}' to warm up for. There are '{}'.", names.join("', '"))
        })
    })
}

/// Has the kernels made for scenes that hold some of `features` or all; without a device there is nothing to do.
pub fn begin(features: Features, has_device: bool) {
    let view = ViewKind::Live { denoise: true };
    let mut kernels = vec![];
    for kernel in features.subsets().filter(|_| has_device).flat_map(|part| part.kernels(view)) {
        if !kernels.contains(&kernel) {
            kernels.push(kernel);
        }
    }
    workshop().prepare(kernels.iter().copied());
    let mut warm_up = warm_up();
    let all = warm_up.get_or_insert(WarmUp { kernels: vec![], primed: 0 });
    kernels.retain(|kernel| !all.kernels.contains(kernel));
    all.kernels.append(&mut kernels);
}

/// The part of it that is done, 0 to 1.
pub fn progress() -> f64 {
    let warm_up = warm_up();
    let Some(all) = warm_up.as_ref().filter(|all| !all.kernels.is_empty()) else { return 1.0 };
    let ready = all.kernels.iter().filter(|kernel| workshop().is_ready(**kernel)).count();
    let primed = if render::is_primed_by_running() { all.primed } else { ready };
    (ready + primed) as f64 / (2 * all.kernels.len()) as f64
}

/// Whether it has ended since the last time. Once per frame, in which it may have one kernel run.
pub fn take_end() -> bool {
    let mut warm_up = warm_up();
    let Some(all) = warm_up.as_mut() else { return false };
    if !all.kernels.iter().all(|kernel| workshop().is_ready(*kernel)) {
        return false;
    }
    if let Some(kernel) = all.kernels.get(all.primed).filter(|_| render::is_primed_by_running()) {
        all.primed += 1;
        let kernel = *kernel;
        on_render_thread(move || render::prime(kernel));
        return false;
    }
    *warm_up = None;
    true
}
