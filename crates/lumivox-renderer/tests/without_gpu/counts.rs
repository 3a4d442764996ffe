//! What counts of a live view's film say, on devices that put paths aside, and when a view may say that it is done.

use lumivox_core::TransferFunction;
use lumivox_renderer::{
    FilmCount, HostFrame, LiveSettings, LiveStatus, LiveView, LoopTurns, Recording, ResourceId, SceneCache,
    VoxelStore,
};

use crate::scenes::*;

const SIZE: u32 = 16;
const TARGET: u32 = 4;
const ALL_AT_ONCE: u64 = 1 << 20;

/// Of a film that is whole.
const WHOLE: FilmCount = FilmCount { samples: TARGET, short: 0, aside: 0, starved: 0, stuck: 0 };

struct Host {
    cache: SceneCache,
    live: LiveView,
    settings: LiveSettings,
}

impl Host {
    fn new() -> Self {
        let loop_turns = Some(LoopTurns { shared: 100, alone: 64_000 });
        let mut cache = SceneCache::new(&VoxelStore::new(LIMITS.with(|it| it.loop_turns = loop_turns)));
        cache.update(&scene(&[volume(8)]), &mut Recording::new()).unwrap();
        let settings = LiveSettings::new(SIZE, SIZE).with(|it| it.target_samples = TARGET);
        let live = LiveView::new(&settings, &cache, &mut Recording::new()).unwrap();
        Self { cache, live, settings }
    }

    fn frame(&mut self, x: f64) -> LiveStatus {
        let host = HostFrame::new(ResourceId::external());
        let mut camera = camera().with_aspect(1.0);
        camera.world_from_camera.translation.x = x;
        let Self { cache, live, settings } = self;
        live.record_frame(cache, &camera, settings, &host, ALL_AT_ONCE, &mut Recording::new()).unwrap()
    }

    /// Hands over a count of the film for each that is on its way.
    fn counts_come(&mut self, count: FilmCount) {
        while self.live.status().awaits_feedback {
            self.live.feedback(bytemuck::bytes_of(&count));
        }
    }

    /// Draws what there is to draw, without losses.
    fn converge(&mut self, x: f64) {
        for _ in 0..4 {
            self.frame(x);
            self.counts_come(WHOLE);
        }
        assert!(self.live.status().converged);
    }
}

/// Paths of one image say nothing of those of the next: until its count is there, pixels may lack samples.
#[test]
fn a_view_is_done_when_its_own_image_was_counted() {
    let mut host = Host::new();
    host.converge(0.0);

    let mut other = scene(&[volume(8)]);
    other.volumes[0].medium.transfer_function = TransferFunction::constant(0.9, [0.5; 3]);
    let Host { cache, .. } = &mut host;
    cache.update(&other, &mut Recording::new()).unwrap();
    for frame in 0..3 {
        let status = host.frame(0.0);
        assert!(!status.converged, "another scene, in frame {frame}: {status:?}");
    }
    host.counts_come(FilmCount { short: 9, aside: 9, ..WHOLE });
    assert!(!host.live.status().converged, "nine pixels lack samples");
    host.converge(0.0);

    for frame in 0..3 {
        let status = host.frame(0.25);
        assert!(!status.converged, "another camera, in frame {frame}: {status:?}");
    }
    host.counts_come(WHOLE);
    assert!(host.live.status().converged);

    // As where a mesh moved.
    host.live.feedback(&10u32.to_le_bytes());
    let status = host.frame(0.25);
    assert!(!status.converged, "pixels started over: {status:?}");
    host.counts_come(WHOLE);
    assert!(host.live.status().converged);
}
