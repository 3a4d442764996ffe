//! A view that is traced within the frames of a host, and what of it is shown.

use std::collections::VecDeque;

use lumivox_core::document::Display;
use lumivox_core::host::Moment;
use lumivox_core::{PerspectiveCamera, Scene};
use lumivox_renderer::recording::{Kernel, TextureOrder};
use lumivox_renderer::stage::{Lent, Recorded, Refusal, Stage, StageError, ViewFrame, Workbench, WorldState};
use lumivox_renderer::{Features, FineTexels, HostFrame, LiveSettings, ViewKind};
use lumivox_wgpu::{Executor, Gpu, GpuError, GpuTime, ReadBack, Submission, wgpu};

use crate::display::{COLOR_FORMAT, DisplayPass, SHOWN_FORMAT, clear, texture};
use crate::pace::Pace;

/// A viewport has one world and one view of it.
const WORLD: u8 = 0;
const VIEW: u8 = 0;

/// Why nothing is shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewportError {
    /// The device failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The scene cannot be shown.
    #[error(transparent)]
    Stage(#[from] StageError),
}

/// What is shown.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// What there is to see.
    pub scene: &'a Scene,
    /// Tells the scene from others: another one with every change.
    pub version: u64,
    /// From where.
    pub camera: &'a PerspectiveCamera,
    /// How light becomes pixels. Changes of it cost no path.
    pub display: &'a Display,
    /// Samples of a pixel at which the picture is done.
    pub samples: u32,
    /// Chooses the random numbers.
    pub seed: u32,
}

/// How far the picture is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PictureProgress {
    /// Samples that every pixel has.
    pub samples: u32,
    /// The part of the picture's samples that is traced, 0 to 1.
    pub part: f32,
    /// Whether something of the scene is seen; until then the texture shows the background.
    pub is_shown: bool,
    /// Whether there is nothing more to do until something changes: the host need not ask for a frame.
    pub rests: bool,
    /// Milliseconds that tracing took in a recent frame; 0 where the device does not tell.
    pub milliseconds: f64,
}

/// What of a picture decides what is traced.
#[derive(Clone, Copy, PartialEq)]
struct Traced {
    version: u64,
    camera: PerspectiveCamera,
    size: [u32; 2],
    samples: u32,
    seed: u32,
}

/// Frames that the GPU may have before it at most. Where a host's own frames do not wait for it, as in browsers, more and more would: what
/// is seen would lag behind, and the picture never rest.
const MOST_UNDER_WAY: u64 = 3;

/// A view of a scene in a texture.
pub struct Viewport {
    gpu: Gpu,
    stage: Stage<u8, u8>,
    /// What the GPU may still be at, with the ticket of each, and its frame.
    under_way: VecDeque<(u64, Submission, u64)>,
    frames: u64,
    pace: Pace,
    color: wgpu::Texture,
    shown: wgpu::Texture,
    pass: DisplayPass,
    traced: Option<(Traced, Moment)>,
    displayed: Option<Display>,
    progress: PictureProgress,
}

impl Viewport {
    /// A view on the host's device, of so many pixels. [`lumivox_wgpu::WANTED_FEATURES`] and [`lumivox_wgpu::wanted_limits`] say
    /// what the device should have.
    pub fn new(gpu: Gpu, size: [u32; 2]) -> Self {
        let device = gpu.executor.device();
        let [color, shown] = textures(device, size);
        let pass = DisplayPass::new(device);
        Self {
            stage: Stage::new(gpu.executor.limits()),
            pace: Pace::of(gpu.description.software),
            gpu,
            under_way: VecDeque::new(),
            frames: 0,
            color,
            shown,
            pass,
            traced: None,
            displayed: None,
            progress: PictureProgress::default(),
        }
    }

    /// Stores voxels of more than 8 bits as a [`FilterTest`](lumivox_wgpu::FilterTest) says that the device does best: before the first
    /// frame.
    pub fn store_as(&mut self, fine_texels: FineTexels) {
        self.gpu.executor.store_as(fine_texels);
        self.stage = Stage::new(self.gpu.executor.limits());
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// How much of a frame goes into tracing.
    pub fn pace_mut(&mut self) -> &mut Pace {
        &mut self.pace
    }

    /// What a host shows: opaque, sRGB in a format that does not say so. It is another one after [`resize`](Self::resize).
    pub fn texture(&self) -> &wgpu::Texture {
        &self.shown
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        [self.shown.width(), self.shown.height()]
    }

    /// Gives the view another size, at least a pixel and at most what the device has; true where it had another.
    pub fn resize(&mut self, size: [u32; 2]) -> bool {
        let device = self.gpu.executor.device();
        let most = device.limits().max_texture_dimension_2d;
        let size = size.map(|n| n.clamp(1, most));
        if size == self.size() {
            return false;
        }
        [self.color, self.shown] = textures(device, size);
        (self.traced, self.displayed) = (None, None);
        true
    }

    /// How far the picture is by the last frame.
    pub fn progress(&self) -> PictureProgress {
        self.progress
    }

    /// Has the kernels made that a scene like this one wants, on threads of their own where there are any: for hosts that still look for
    /// what there is to see.
    pub fn prepare(&self, scene: &Scene) {
        let LiveSettings { guides, kept_light, .. } = LiveSettings::new(1, 1);
        let executor = &self.gpu.executor;
        let kernels = Features::of(scene).kernels(ViewKind::Live { guides, kept_light }, executor.limits());
        Bench(executor).are_ready(&kernels);
    }

    /// Brings the picture further, within a frame's time, and draws it. Of what rests nothing is done.
    ///
    /// # Errors
    /// Why nothing is shown. It may be tried again: a scene that does not fit the device is not until it changes.
    pub fn frame(&mut self, picture: &Picture<'_>) -> Result<PictureProgress, ViewportError> {
        let Picture { version, camera, samples, seed, .. } = *picture;
        let wanted = Traced { version, camera: *camera, size: self.size(), samples, seed };
        let is_same = matches!(&self.traced, Some((traced, _)) if *traced == wanted);
        let is_displayed = self.displayed == Some(*picture.display);
        if is_same && self.progress.rests {
            if !is_displayed {
                self.display(picture);
            }
            return Ok(self.progress);
        }
        let changed = match &self.traced {
            Some((_, at)) if is_same => *at,
            _ => Moment::now(),
        };
        self.traced = Some((wanted, changed));
        let outcome = self.advance(picture, self.pace.milliseconds(changed.elapsed()));
        if outcome.is_err() {
            // What could not be shown is asked for again only by a change.
            self.progress = PictureProgress { rests: true, ..PictureProgress::default() };
        }
        outcome.map(|()| self.progress)
    }

    /// Traces and draws, unless the GPU has enough to do.
    fn advance(&mut self, picture: &Picture<'_>, budget: f64) -> Result<(), ViewportError> {
        if self.is_behind()? {
            self.progress.rests = false;
            return Ok(());
        }
        self.trace(picture, budget)?;
        self.display(picture);
        Ok(())
    }

    /// Whether the GPU has enough to do.
    fn is_behind(&mut self) -> Result<bool, ViewportError> {
        let is_behind =
            |it: &Self| it.under_way.front().is_some_and(|(_, _, frame)| it.frames - frame >= MOST_UNDER_WAY);
        if !is_behind(self) {
            return Ok(false);
        }
        self.take_what_came_back()?;
        Ok(is_behind(self))
    }

    /// Frees what is on the device of scenes that were shown: for a host that closes a scan.
    ///
    /// # Errors
    /// When the device failed.
    pub fn forget(&mut self) -> Result<(), ViewportError> {
        if let Some(swept) = self.stage.sweep(|_| false, |_| false) {
            self.replay(swept)?;
        }
        (self.traced, self.displayed, self.progress) = (None, None, PictureProgress::default());
        Ok(())
    }

    fn display(&mut self, picture: &Picture<'_>) {
        let executor = &self.gpu.executor;
        let gpu = (executor.device(), executor.queue());
        let behind = (&picture.scene.environment, picture.camera);
        self.pass.draw(gpu, &self.color, &self.shown, picture.display, behind);
        self.displayed = Some(*picture.display);
    }

    fn trace(&mut self, picture: &Picture<'_>, budget: f64) -> Result<(), ViewportError> {
        self.frames += 1;
        self.stage.begin_frame(self.frames);
        self.take_what_came_back()?;
        let [width, height] = self.size();
        let settings = LiveSettings::new(width, height).with(|it| {
            it.target_samples = picture.samples;
            it.seed = picture.seed;
            it.denoise = true;
            it.resolution_scale = self.pace.resolution_scale([width, height]);
        });
        let LiveSettings { guides, kept_light, .. } = settings;
        let bench = Bench(&self.gpu.executor);
        self.stage.expect(WORLD, ViewKind::Live { guides, kept_light });
        let updated = self.stage.update(WORLD, picture.scene, picture.version, false, &bench)?;
        if let Some(recorded) = updated {
            self.replay(recorded)?;
        }
        self.clear();
        let Some(shown) = self.stage.shown(VIEW, WORLD, |_| true) else {
            self.progress = PictureProgress::default();
            return Ok(());
        };
        let camera = picture.camera.with_aspect(f64::from(width) / f64::from(height));
        let seen = self.stage.record_view(VIEW, shown, |lent: Lent| {
            ViewFrame::new(camera, settings, HostFrame::new(lent.color), budget)
        })?;
        self.gpu.executor.lend_texture(seen.lent.color, &self.color);
        self.replay(seen.recorded)?;
        if self.stage.wants_sweep()
            && let Some(swept) = self.stage.sweep(|_| true, |_| true)
        {
            self.replay(swept)?;
        }
        let of_view = self.stage.view_progress(VIEW, WORLD);
        let is_current = self.stage.world_state(WORLD) != WorldState::Before;
        self.progress = of_view.map_or(PictureProgress::default(), |it| PictureProgress {
            samples: it.live.samples,
            part: it.live.progress,
            is_shown: true,
            rests: is_current && it.is_converged && !it.live.awaits_feedback,
            milliseconds: self.stage.view_milliseconds(VIEW),
        });
        Ok(())
    }

    /// Volumes are drawn over nothing.
    fn clear(&self) {
        let executor = &self.gpu.executor;
        let mut encoder = executor.device().create_command_encoder(&Default::default());
        drop(clear(&mut encoder, &self.color));
        executor.queue().submit([encoder.finish()]);
    }

    /// Has the GPU do what was recorded, and tells the stage.
    fn replay(&mut self, recorded: Recorded<u8, u8>) -> Result<(), ViewportError> {
        let ticket = recorded.ticket();
        let outcome = match self.gpu.executor.submit(&recorded.recording) {
            Ok(mut submission) => {
                let told = submission.poll_check();
                self.under_way.push_back((ticket, submission, self.frames));
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
    fn take_what_came_back(&mut self) -> Result<(), ViewportError> {
        self.gpu.check()?;
        while let Some((ticket, submission, _)) = self.under_way.front_mut() {
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

fn textures(device: &wgpu::Device, size: [u32; 2]) -> [wgpu::Texture; 2] {
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
    let size = size.map(|n| n.max(1));
    [
        texture(device, "picture", size, COLOR_FORMAT, usage),
        texture(device, "shown", size, SHOWN_FORMAT, usage | wgpu::TextureUsages::COPY_SRC),
    ]
}

/// Kernels that a frame would wait for are made on threads of their own, and so are their pipelines for the colour.
struct Bench<'a>(&'a Executor);

impl Workbench for Bench<'_> {
    fn are_ready(&self, kernels: &[Kernel]) -> bool {
        let kernels = || kernels.iter().copied();
        self.0.prepare(kernels());
        self.0.prepare_draws(kernels(), COLOR_FORMAT, 1);
        self.0.is_prepared(kernels()) && self.0.is_prepared_to_draw(kernels(), COLOR_FORMAT, 1)
    }

    fn texture_maker(&self) -> Box<dyn FnMut(&TextureOrder) -> bool + Send> {
        Workbench::texture_maker(self.0)
    }
}
