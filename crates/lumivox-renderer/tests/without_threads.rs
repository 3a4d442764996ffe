//! A host without threads, as a page in a browser is: nothing that hosts wait for may wait for a thread. A process has one
//! host, so this has a program for itself.

use std::sync::Arc;
use std::thread::{self, ThreadId};
use std::time::Duration;

use lumivox_core::glam::DAffine3;
use lumivox_core::host::{self, Host, Work};
use lumivox_core::{Medium, Modality, Scene, TransferFunction, Volume, Voxels};
use lumivox_renderer::recording::{Kernel, TextureOrder};
use lumivox_renderer::stage::{Stage, Workbench, WorldState};
use lumivox_renderer::{DeviceLimits, Workshop};

/// Its clock stands still, as where nobody gave one.
struct Page;

impl Host for Page {
    fn now(&self) -> Duration {
        Duration::ZERO
    }

    fn spare_threads(&self) -> usize {
        0
    }

    fn spawn(&self, _: &str, work: Work) -> Result<(), Work> {
        Err(work)
    }

    fn sleep(&self, _: Duration) {
        panic!("a page must not be held up");
    }
}

struct Bench(Workshop<ThreadId>);

impl Workbench for Bench {
    fn are_ready(&self, kernels: &[Kernel]) -> bool {
        self.0.prepare(kernels.iter().copied());
        kernels.iter().all(|kernel| self.0.is_ready(*kernel))
    }

    fn texture_maker(&self) -> Box<dyn FnMut(&TextureOrder) -> bool + Send> {
        Box::new(|_| false)
    }
}

fn scene() -> Scene {
    let voxels = Voxels::U8((0..80 * 80 * 80).map(|i| (i / 7) as u8).collect());
    let volume = Volume::new([80; 3], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Ct).unwrap();
    Scene::with_volume(Arc::new(volume), Medium::new(TransferFunction::constant(0.5, [1.0; 3])))
}

#[test]
fn kernels_and_worlds_are_made_where_they_are_asked_for() {
    assert!(host::set_host(Box::new(Page)).is_ok());
    let bench = Bench(Workshop::new(|_| Ok(thread::current().id())));
    bench.0.prepare([Kernel::Display, Kernel::HostDepth]);
    assert_eq!(bench.0.outstanding(), 0);
    assert_eq!(bench.0.get(Kernel::Display), Ok(thread::current().id()));
    bench.0.hurry([Kernel::FilmCount]);
    assert!(bench.0.is_ready(Kernel::FilmCount));
    assert_eq!(bench.0.waits(), 0);

    let mut stage: Stage<u64, u64> = Stage::new(DeviceLimits::webgpu_default());
    let (scene, mut frame) = (scene(), 0);
    while stage.world_state(1) != WorldState::Done {
        frame += 1;
        assert!(frame < 100, "the world never comes");
        stage.begin_frame(frame);
        if let Some(recorded) = stage.update(1, &scene, 1, false, &bench).unwrap() {
            stage.executed(recorded, Ok(())).unwrap();
        }
    }
    // What nobody shows any more goes where it stands.
    drop(scene);
    let freed = stage.sweep(|_| false, |_| false).expect("there is something to free");
    assert!(!freed.recording.is_empty());
    assert!(!bench.0.clear().is_empty());
}
