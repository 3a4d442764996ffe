//! Kernels made before scenes want them: what [`Lumivox.warm_up`](crate::server::Lumivox) does over a few frames.

use std::sync::{Mutex, MutexGuard, PoisonError};

use lumivox_renderer::recording::{Classes, Kernel};
use lumivox_renderer::{DeviceLimits, Features, ViewKind};

use crate::executor::workshop;

/// What scenes may hold, by the names that scripts use.
const NAMES: [(&str, Features); 11] = {
    const NONE: Features = Features {
        environment: false,
        surface: false,
        filters: false,
        lights: false,
        many_volumes: false,
        classes: Classes::NONE,
    };
    const fn classes(classes: Classes) -> Features {
        // Whether shares of the opacity are taken off too, or not.
        Features { classes: Classes { shares: true, ..classes }, ..NONE }
    }
    [
        ("environment", Features { environment: true, ..NONE }),
        ("surface", Features { surface: true, ..NONE }),
        ("filters", Features { filters: true, ..NONE }),
        ("lights", Features { lights: true, ..NONE }),
        ("many_volumes", Features { many_volumes: true, ..NONE }),
        ("classes", classes(Classes::ALL)),
        ("labels", classes(Classes { labels: true, ..Classes::NONE })),
        ("functions", classes(Classes { functions: true, ..Classes::NONE })),
        ("gradients", classes(Classes { functions: true, gradients: true, ..Classes::NONE })),
        ("peeling", classes(Classes { depth: true, ..Classes::NONE })),
        ("clip_shapes", classes(Classes { clip_shapes: true, ..Classes::NONE })),
    ]
};

/// The kernels that were asked for, until that they are made is announced.
static KERNELS: Mutex<Option<Vec<Kernel>>> = Mutex::new(None);

fn asked_for() -> MutexGuard<'static, Option<Vec<Kernel>>> {
    KERNELS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The features of these names, all but classes where there is no name; or the name that stands for none.
pub fn features(names: &[String]) -> Result<Features, String> {
    if names.is_empty() {
        return Ok(Features { classes: Classes::NONE, ..Features::ALL });
    }
    names.iter().try_fold(Features::default(), |all, name| {
        let known = NAMES.iter().find(|(known, _)| known == name);
        known.map(|(_, one)| all.union(*one)).ok_or_else(|| {
            let names: Vec<&str> = NAMES.iter().map(|(name, _)| *name).collect();
            format!("There is no feature '{name}' to warm up for. There are '{}'.", names.join("', '"))
        })
    })
}

/// Has the kernels made for scenes that hold some of `features` or all, for a device of such limits; without one there
/// is nothing to do.
pub fn begin(features: Features, limits: Option<DeviceLimits>) {
    let view = ViewKind::Live { guides: false, kept_light: true };
    let mut kernels = vec![];
    let wanted = limits.map(|limits| features.subsets().flat_map(move |part| part.kernels(view, limits)));
    for kernel in wanted.into_iter().flatten() {
        if !kernels.contains(&kernel) {
            kernels.push(kernel);
        }
    }
    workshop().prepare(kernels.iter().copied());
    let mut asked_for = asked_for();
    let all = asked_for.get_or_insert_default();
    kernels.retain(|kernel| !all.contains(kernel));
    all.append(&mut kernels);
}

/// The part of it that is done, 0 to 1.
pub fn progress() -> f64 {
    let asked_for = asked_for();
    let kernels = asked_for.as_deref().unwrap_or_default();
    let ready = kernels.iter().filter(|kernel| workshop().is_ready(**kernel)).count();
    if kernels.is_empty() { 1.0 } else { ready as f64 / kernels.len() as f64 }
}

/// Whether it has ended since the last time. Once per frame.
pub fn take_end() -> bool {
    let mut asked_for = asked_for();
    let made = |kernels: &Vec<Kernel>| kernels.iter().all(|kernel| workshop().is_ready(*kernel));
    let ended = asked_for.as_ref().is_some_and(made);
    if ended {
        *asked_for = None;
    }
    ended
}
