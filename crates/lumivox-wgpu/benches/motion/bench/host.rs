//! An engine in miniature: its textures, its depth, and live views whose frames are timed.

use std::time::Instant;

use lumivox_core::Camera;
use lumivox_core::glam::DAffine3;
use lumivox_renderer::live::LiveImage;
use lumivox_renderer::pacing::{Pacer, Pass};
use lumivox_renderer::{
    HostDepth, HostFrame, LiveSettings, LiveStatus, LiveView, Recording, ResourceId, SceneCache, Step,
    VoxelStore,
};
use lumivox_wgpu::{Gpu, wgpu};

use super::films::{Moment, Motion, RATE, Set};

/// Reversed depth without a far plane: `z = NEAR / depth`, 0 where there is nothing.
const NEAR: f64 = 0.01;

/// Pixel samples of one frame of a converged picture: about a tenth of a second.
const CONVERGING: u64 = 32;

/// Frames in which a view's pace is learnt, and the last ones that it is taken from.
const PACED: usize = 72;
const SETTLED: usize = 24;

/// A picture as a host is given it: premultiplied light, and alpha.
pub type Picture = Vec<[f32; 4]>;

/// A device, and what an engine lends the views on it.
pub struct Host {
    gpu: Gpu,
    store: VoxelStore,
    size: [u32; 2],
    depth: wgpu::Texture,
    /// Colour, depth, and depth that is written.
    names: [ResourceId; 3],
}

/// What a frame took.
pub struct Took {
    /// From its recording to its end.
    pub milliseconds: f64,
    /// On the GPU, where that tells.
    pub gpu_milliseconds: Option<f64>,
    pub pixel_samples: u64,
    is_converged: bool,
}

impl Host {
    /// On the device that `LUMIVOX_GPU` names.
    pub fn open(size: [u32; 2]) -> Result<Self, String> {
        let name = std::env::var("LUMIVOX_GPU").ok();
        let mut gpu = Gpu::open(name.as_deref()).map_err(|error| error.to_string())?;
        let texture = |format, usage| {
            gpu.executor.device().create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let target = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let read = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let color = texture(wgpu::TextureFormat::Rgba16Float, target);
        let depth = texture(wgpu::TextureFormat::R32Float, read);
        let written = texture(wgpu::TextureFormat::Depth32Float, target);
        let names = [(); 3].map(|()| ResourceId::external());
        for (name, texture) in names.iter().zip([&color, &depth, &written]) {
            gpu.executor.lend_texture(*name, texture);
        }
        let store = VoxelStore::new(gpu.executor.limits());
        let host = Self { gpu, store, size, depth, names };
        host.set_depth(&vec![0.0; host.pixels() as usize])?;
        Ok(host)
    }

    /// Name and driver.
    pub fn description(&self) -> [String; 2] {
        [self.gpu.description.name.clone(), self.gpu.description.driver.clone()]
    }

    /// Of an image.
    pub fn pixels(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// Draws meshes: view depths in metres, 0 where there is none.
    pub fn set_depth(&self, depths: &[f64]) -> Result<(), String> {
        let texel = |depth: &f64| if *depth > 0.0 { (NEAR / depth) as f32 } else { 0.0 };
        let texels: Vec<f32> = depths.iter().map(texel).collect();
        let [width, height] = self.size;
        self.gpu.executor.queue().write_texture(
            self.depth.as_image_copy(),
            bytemuck::cast_slice(&texels),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * width),
                rows_per_image: Some(height),
            },
            self.depth.size(),
        );
        // No part of the frame's time.
        self.gpu.executor.queue().submit([]);
        self.gpu.executor.wait().map_err(|error| error.to_string())
    }

    /// Draws the meshes of a moment.
    pub fn draw_meshes(&self, moment: &Moment) -> Result<(), String> {
        match &moment.board {
            Some(board) => self.set_depth(&board.depths(&moment.camera, self.size)),
            None => Ok(()),
        }
    }

    fn frame(&self) -> HostFrame {
        HostFrame::new(self.names[0])
            .with_depth(HostDepth::new(self.names[1], [0.0, NEAR, 1.0, 0.0], 0.0))
            .with_depth_target(self.names[2])
    }

    fn execute(&mut self, recording: &Recording) -> Result<Vec<Vec<u8>>, String> {
        let read_backs = self.gpu.executor.execute(recording).map_err(|error| error.to_string())?;
        read_backs.into_iter().map(|back| back.wait().map_err(|error| error.to_string())).collect()
    }

    /// The converged picture of a moment, by so many samples and numbers that a seed chooses.
    pub fn converge(&mut self, moment: &Moment, samples: u32, seed: u32) -> Result<Picture, String> {
        /// Far more than there are in any number of samples.
        const MOST_FRAMES: u32 = 100_000;
        let settings = self.settings().with(|it| {
            it.target_samples = samples;
            it.seed = seed;
        });
        self.draw_meshes(moment)?;
        let mut view = Showing::new(self, moment, settings, false, 1)?;
        let budget = CONVERGING * self.pixels();
        let mut idle = 0;
        for _ in 0..MOST_FRAMES {
            let took = view.frame(self, moment, budget)?;
            // What came back of the last frame may have opened the film again: only two idle frames are the end.
            idle = if took.is_converged && took.pixel_samples == 0 { idle + 1 } else { 0 };
            if idle == 2 {
                let picture = view.picture(self)?;
                view.free(self)?;
                return Ok(picture);
            }
        }
        Err("a picture that should converge never does".to_owned())
    }

    /// Of a live view that shows what it traces, as it is.
    pub fn settings(&self) -> LiveSettings {
        LiveSettings::new(self.size[0], self.size[1]).with(|it| it.kept_light = false)
    }

    /// Pixel samples of a frame that take the GPU so many milliseconds while the camera moves, as engines pace their views.
    pub fn pace(&mut self, set: &Set, milliseconds: f64) -> Result<u64, String> {
        let mut view = Showing::new(self, &set.at(Motion::Orbit, 0.0), self.settings(), true, 1)?;
        let (mut pacer, mut budgets) = (Pacer::new(), vec![]);
        for frame in 0..PACED {
            let moment = set.at(Motion::Orbit, frame as f64 / RATE);
            let budget = pacer.budget(Pass::Moving, milliseconds);
            let took = view.frame(self, &moment, budget)?;
            pacer.recorded(frame as u64, Pass::Moving, took.pixel_samples, budget, milliseconds);
            pacer.measured(frame as u64, took.gpu_milliseconds.unwrap_or(took.milliseconds));
            budgets.push(budget);
        }
        view.free(self)?;
        let settled = &mut budgets[PACED - SETTLED..];
        settled.sort_unstable();
        Ok(settled[SETTLED / 2])
    }
}

/// A live view of a scene that changes, and what it has on the device.
pub struct Showing {
    cache: SceneCache,
    live: LiveView,
    /// A headset's other eye, whose frame comes first.
    other: Option<LiveView>,
    settings: LiveSettings,
    shown: lumivox_core::Scene,
}

/// Metres between a person's eyes.
const EYES_APART: f64 = 0.063;

impl Showing {
    /// An empty one. What moves follows light as engines do; a converged picture is of one light alone.
    pub fn new(
        host: &mut Host,
        moment: &Moment,
        settings: LiveSettings,
        follows_light: bool,
        eyes: usize,
    ) -> Result<Self, String> {
        let mut cache = SceneCache::new(&host.store);
        if follows_light {
            cache.follow_light();
        }
        let mut recording = Recording::new();
        cache.update(&moment.scene, &mut recording).map_err(|error| error.to_string())?;
        let mut view = || LiveView::new(&settings, &cache, &mut recording).map_err(|error| error.to_string());
        let live = view()?;
        let other = if eyes > 1 { Some(view()?) } else { None };
        host.execute(&recording)?;
        Ok(Self { cache, live, other, settings, shown: moment.scene.clone() })
    }

    /// Draws a frame and waits for it. What the scene needs that differs from the frame before is a part of that.
    pub fn frame(&mut self, host: &mut Host, moment: &Moment, budget: u64) -> Result<Took, String> {
        let begin = Instant::now();
        let (recording, status, of_other) = self.record(host, moment, budget)?;
        let mut submission = host.gpu.executor.submit(&recording).map_err(|error| error.to_string())?;
        host.gpu.executor.wait().map_err(|error| error.to_string())?;
        let milliseconds = begin.elapsed().as_secs_f64() * 1e3;
        if let Some(Err(error)) = submission.poll_check() {
            return Err(error.to_string());
        }
        for (index, read_back) in submission.read_backs.into_iter().enumerate() {
            let bytes = read_back.wait().map_err(|error| error.to_string())?;
            match &mut self.other {
                Some(other) if index < of_other => other.feedback(&bytes),
                _ => self.live.feedback(&bytes),
            }
        }
        let gpu_milliseconds = submission.time.and_then(|mut time| time.poll()).filter(|ms| *ms > 0.0);
        let is_converged = self.live.status().converged;
        Ok(Took { milliseconds, gpu_milliseconds, pixel_samples: status.pixel_samples, is_converged })
    }

    /// A frame whose kernels are submitted one by one, with what each took of the GPU's time.
    pub fn frame_in_parts(
        &mut self,
        host: &mut Host,
        moment: &Moment,
        budget: u64,
    ) -> Result<Vec<(String, f64)>, String> {
        let (recording, ..) = self.record(host, moment, budget)?;
        let mut parts = vec![];
        let mut part = Recording::new();
        for step in recording.steps {
            let name = match &step {
                Step::Dispatch { kernel, .. } | Step::Draw { kernel, .. } => Some(kernel.name()),
                _ => None,
            };
            part.push(step);
            if let Some(name) = name {
                parts.push((name, self.submit_part(host, std::mem::take(&mut part))?));
            }
        }
        self.submit_part(host, part)?;
        Ok(parts)
    }

    /// Milliseconds on the GPU, or on the clock where that tells none.
    fn submit_part(&mut self, host: &mut Host, part: Recording) -> Result<f64, String> {
        let begin = Instant::now();
        let submission = host.gpu.executor.submit(&part).map_err(|error| error.to_string())?;
        host.gpu.executor.wait().map_err(|error| error.to_string())?;
        let milliseconds = begin.elapsed().as_secs_f64() * 1e3;
        for read_back in submission.read_backs {
            self.live.feedback(&read_back.wait().map_err(|error| error.to_string())?);
        }
        let of_gpu = submission.time.and_then(|mut time| time.poll()).filter(|ms| *ms > 0.0);
        Ok(of_gpu.unwrap_or(milliseconds))
    }

    /// A frame of all eyes, and how many read-backs are the other one's.
    fn record(
        &mut self,
        host: &Host,
        moment: &Moment,
        budget: u64,
    ) -> Result<(Recording, LiveStatus, usize), String> {
        let is_changed = !self.shown.is_same(&moment.scene);
        if is_changed {
            self.shown.clone_from(&moment.scene);
        }
        let (camera, lent): (Camera, HostFrame) = (moment.camera, host.frame());
        let mut recording = Recording::new();
        if is_changed {
            self.cache.update(&moment.scene, &mut recording).map_err(|error| error.to_string())?;
        }
        if let Some(other) = &mut self.other {
            let place = camera.world_from_camera;
            let aside = DAffine3::from_translation(-EYES_APART * place.matrix3.x_axis);
            let camera = Camera { world_from_camera: aside * place, ..camera };
            other
                .record_frame(&self.cache, &camera, &self.settings, &lent, budget, &mut recording)
                .map_err(|error| error.to_string())?;
        }
        let of_other = recording.steps.iter().filter(|step| matches!(step, Step::ReadBuffer { .. })).count();
        let status = self
            .live
            .record_frame(&self.cache, &camera, &self.settings, &lent, budget, &mut recording)
            .map_err(|error| error.to_string())?;
        Ok((recording, status, of_other))
    }

    /// What the host was given in the last frame.
    pub fn picture(&self, host: &mut Host) -> Result<Picture, String> {
        let mut recording = Recording::new();
        self.live.record_read(LiveImage::Color, &mut recording).ok_or("the view has no picture")?;
        let bytes = host.execute(&recording)?.pop().ok_or("the picture did not come back")?;
        Ok(bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect())
    }

    /// Gives back what it has on the device, but not the voxels.
    pub fn free(self, host: &mut Host) -> Result<(), String> {
        let mut recording = Recording::new();
        self.other.into_iter().for_each(|other| other.free(&mut recording));
        self.live.free(&mut recording);
        self.cache.free(&mut recording);
        host.execute(&recording).map(drop)
    }
}
