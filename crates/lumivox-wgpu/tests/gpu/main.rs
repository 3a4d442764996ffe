//! The kernels on a real device: against physics, against the reference, against themselves.
//!
//! A missing device fails these tests; they never skip. `LUMIVOX_GPU` chooses one by a part of its name.

mod changes;
mod first_pictures;
mod golden;
mod hosts;
mod images;
mod labels;
mod lights;
mod live;
mod majorants;
mod motion;
mod physics;
mod reference;
mod samplers;
mod stage;
mod store;

use std::ops::ControlFlow;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use lumivox_renderer::Film;
use lumivox_testing::scenes::TestScene;
use lumivox_wgpu::{Gpu, Outcome, RenderRequest, render};

/// The one device that all tests share, one at a time.
fn gpu() -> MutexGuard<'static, Gpu> {
    static GPU: OnceLock<Mutex<Gpu>> = OnceLock::new();
    GPU.get_or_init(|| {
        let name = std::env::var("LUMIVOX_GPU").ok();
        let gpu = Gpu::open(name.as_deref())
            .expect("GPU tests need a GPU or software Vulkan (Debian: apt-get install mesa-vulkan-drivers)");
        eprintln!("testing on {} ({})", gpu.description.name, gpu.description.driver);
        Mutex::new(gpu)
    })
    .lock()
    .unwrap_or_else(PoisonError::into_inner)
}

/// A finished film of a test scene.
fn film(test: &TestScene, request: &RenderRequest) -> Film {
    let rendered = render(&mut gpu(), &test.scene, &test.camera, request, &mut |_| ControlFlow::Continue(()))
        .unwrap_or_else(|e| panic!("{}: {e}", test.name));
    assert!(matches!(rendered.outcome, Outcome::Complete), "{}: {:?}", test.name, rendered.outcome);
    assert_eq!(rendered.film.min_samples(), request.samples);
    rendered.film
}
