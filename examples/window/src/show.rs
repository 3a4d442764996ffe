//! What every host of a [`Stage`] does with each of its frames: bring the world up to date, trace the view, tell what became of
//! both. A host with more worlds or views does the same for each, by names of its own in the place of `WORLD` and `VIEW`.

use std::collections::VecDeque;

use lumivox_core::{Camera, Scene};
use lumivox_renderer::recording::{Kernel, TextureOrder};
use lumivox_renderer::stage::{Lent, Recorded, Refusal, Stage, ViewFrame, ViewProgress, Workbench};
use lumivox_renderer::{HostFrame, LiveSettings, ViewKind, VoxelStore};
use lumivox_wgpu::{Executor, Gpu, GpuError, GpuTime, ReadBack, Submission, wgpu};

use crate::Fallible;
use crate::screen::Screen;

/// What tells worlds, and views, from each other. Here is one of each.
const WORLD: u8 = 0;
const VIEW: u8 = 0;

/// A device, and what is shown on it.
pub struct Show {
    pub gpu: Gpu,
    stage: Stage<u8, u8>,
    /// What the GPU may still be at, with the ticket of each.
    under_way: VecDeque<(u64, Submission)>,
    frames: u64,
}

/// What is shown in a frame.
pub struct Picture<'a> {
    pub scene: &'a Scene,
    /// Tells a scene from others: another one with every change.
    pub version: u64,
    pub camera: Camera,
    pub settings: LiveSettings,
    /// What the scan is drawn over.
    pub color: &'a wgpu::Texture,
    /// Milliseconds of the GPU's time for tracing.
    pub budget: f64,
}

impl Show {
    pub fn new(gpu: Gpu) -> Self {
        let stage = Stage::new(gpu.executor.limits());
        Self { gpu, stage, under_way: VecDeque::new(), frames: 0 }
    }

    /// The voxels on the device, for who prepares scenes.
    pub fn store(&self) -> &VoxelStore {
        self.stage.store()
    }

    /// Milliseconds that tracing took in a recent frame.
    pub fn milliseconds(&self) -> f64 {
        self.stage.view_milliseconds(VIEW)
    }

    /// Draws the picture over its colour, as far as it is there; how far that is. `None` while there is nothing to show.
    pub fn frame(&mut self, picture: &Picture<'_>) -> Fallible<Option<ViewProgress>> {
        self.frames += 1;
        self.stage.begin_frame(self.frames);
        self.take_what_came_back()?;
        let bench = Bench(&self.gpu.executor);
        let LiveSettings { guides, kept_light, .. } = picture.settings;
        self.stage.expect(WORLD, ViewKind::Live { guides, kept_light });
        // In pieces that a frame has time for, once what takes long was prepared on other threads.
        let updated = self.stage.update(WORLD, picture.scene, picture.version, false, &bench)?;
        if let Some(recorded) = updated {
            self.replay(recorded)?;
        }
        // The world before would stand in for one that is not there yet.
        let Some(shown) = self.stage.shown(VIEW, WORLD, |_| true) else { return Ok(None) };
        let seen = self.stage.record_view(VIEW, shown, |lent: Lent| {
            // With `with_depth` rays would end at the host's meshes, and with `with_depth_target` later ones meet the scan.
            let host = HostFrame::new(lent.color);
            ViewFrame::new(picture.camera, picture.settings, host, picture.budget)
        })?;
        self.gpu.executor.lend_texture(seen.lent.color, picture.color);
        self.replay(seen.recorded)?;
        // A host whose worlds and views come and go names those that stay.
        if self.stage.wants_sweep()
            && let Some(swept) = self.stage.sweep(|_| true, |_| true)
        {
            self.replay(swept)?;
        }
        Ok(self.stage.view_progress(VIEW, WORLD))
    }

    /// Has the GPU do what was recorded, and tells the stage.
    fn replay(&mut self, recorded: Recorded<u8, u8>) -> Fallible {
        let ticket = recorded.ticket();
        let outcome = match self.gpu.executor.submit(&recorded.recording) {
            Ok(mut submission) => {
                let told = submission.poll_check();
                self.under_way.push_back((ticket, submission));
                told.unwrap_or(Ok(()))
            }
            Err(error) => Err(error),
        };
        let outcome = outcome.map_err(|error| {
            // What of it was done is taken back.
            self.gpu.executor.discard(&recorded.recording);
            match error {
                GpuError::OutOfMemory(_) => Refusal::Memory(error.to_string()),
                other => Refusal::Other(other.to_string()),
            }
        });
        // Of a volume for which there is no room a coarser one comes.
        Ok(self.stage.executed(recorded, outcome)?)
    }

    /// Bytes, faults and times of frames before, in their order and as far as they are there: nothing is waited for.
    fn take_what_came_back(&mut self) -> Fallible {
        self.gpu.check()?;
        while let Some((ticket, submission)) = self.under_way.front_mut() {
            if let Some(told) = submission.poll_check() {
                told?;
            }
            while let Some(bytes) = submission.read_backs.first_mut().and_then(ReadBack::poll) {
                submission.read_backs.remove(0);
                self.stage.feedback(*ticket, &bytes?);
            }
            // 0 where the device tells no times: then the frame rate paces.
            let time = submission.time.as_mut().map_or(Some(0.0), GpuTime::poll);
            let (true, Some(milliseconds)) = (submission.read_backs.is_empty(), time) else { break };
            if *ticket > 0 {
                self.stage.measured(*ticket, milliseconds);
            }
            self.under_way.pop_front();
        }
        Ok(())
    }
}

/// Kernels that a frame would wait for are made on threads of their own, and so are their pipelines for the screen's colour.
struct Bench<'a>(&'a Executor);

impl Workbench for Bench<'_> {
    fn are_ready(&self, kernels: &[Kernel]) -> bool {
        let kernels = || kernels.iter().copied();
        self.0.prepare(kernels());
        self.0.prepare_draws(kernels(), Screen::COLOR_FORMAT, 1);
        self.0.is_prepared(kernels()) && self.0.is_prepared_to_draw(kernels(), Screen::COLOR_FORMAT, 1)
    }

    fn texture_maker(&self) -> Box<dyn FnMut(&TextureOrder) -> bool + Send> {
        Workbench::texture_maker(self.0)
    }
}
