//! Pictures of a scene while it moves, for hosts that have no frame to keep: each is made when it is asked for, of the light that
//! is kept in the volumes ([`LiveSettings::kept_light`]), and comes back.

use lumivox_core::color::luminance;
use lumivox_core::{PerspectiveCamera, Scene};
use lumivox_renderer::live::LiveImage;
use lumivox_renderer::{
    Film, HostFrame, LiveSettings, LiveView, Recording, RenderError, ResourceId, SceneCache, VoxelStore,
};

use crate::error::{GpuError, HeadlessError};
use crate::gpu::Gpu;

/// Paths of a picture for each of its pixels: on a GPU, and in software, where they take long.
const PATHS: f64 = 2.0;
const PATHS_IN_SOFTWARE: f64 = 0.25;

/// A view of a scene that moves. Light that it has learnt serves the next pictures, wherever they are seen from.
#[derive(Debug)]
pub struct MovingView {
    store: VoxelStore,
    cache: SceneCache,
    live: Option<LiveView>,
}

impl MovingView {
    /// One that knows nothing yet. It is for this GPU alone.
    pub fn new(gpu: &Gpu) -> Self {
        let store = VoxelStore::new(gpu.executor.limits());
        let cache = SceneCache::new(&store);
        Self { store, cache, live: None }
    }

    /// What is seen of a scene now, as a film of one sample without noise: biased, and better with each picture. `None` where
    /// the GPU has no room for it.
    ///
    /// # Errors
    /// [`HeadlessError`] when the scene cannot be rendered.
    pub fn picture(
        &mut self,
        gpu: &mut Gpu,
        scene: &Scene,
        camera: &PerspectiveCamera,
        size: [u32; 2],
    ) -> Result<Option<Film>, HeadlessError> {
        let pictured = self.try_picture(gpu, scene, camera, size);
        if pictured.is_err() {
            // The next one begins anew.
            std::mem::replace(self, Self::new(gpu)).free(gpu);
        }
        match pictured {
            Err(HeadlessError::Gpu(GpuError::OutOfMemory(_))) => Ok(None),
            pictured => pictured,
        }
    }

    fn try_picture(
        &mut self,
        gpu: &mut Gpu,
        scene: &Scene,
        camera: &PerspectiveCamera,
        size: [u32; 2],
    ) -> Result<Option<Film>, HeadlessError> {
        let [width, height] = size;
        let sees = camera.vertical_fov > 0.0 && camera.vertical_fov < std::f64::consts::PI;
        if !sees || !camera.world_from_camera.is_finite() {
            return Err(RenderError::Camera.into());
        }
        // Its film never ends: light is all that is asked for.
        let settings = LiveSettings::new(width, height).with(|it| it.target_samples = u32::MAX);
        let mut recording = Recording::new();
        self.store.collect(&mut recording);
        self.cache.update(scene, &mut recording)?;
        let live = match &mut self.live {
            Some(live) => live,
            None => self.live.insert(LiveView::new(&settings, &self.cache, &mut recording)?),
        };
        let paths = if gpu.description.software { PATHS_IN_SOFTWARE } else { PATHS };
        let budget = (paths * f64::from(width) * f64::from(height)).max(64.0) as u64;
        let seen = camera.with_aspect(f64::from(width) / f64::from(height));
        let host = HostFrame::new(ResourceId::external());
        let mut frame = live.plan_frame(&self.cache, &seen, &settings, &host, budget, &mut recording)?;
        // Nobody draws anything.
        frame.passes.retain(|pass| !["picture", "draw"].contains(&pass.name()));
        frame.record(&mut recording);
        let image = live.record_read(LiveImage::KeptLight, &mut recording);
        let executed = gpu.executor.execute(&recording).and_then(|read_backs| {
            read_backs.into_iter().map(|read_back| read_back.wait()).collect::<Result<Vec<_>, _>>()
        });
        let mut bytes = match executed {
            Ok(bytes) => bytes,
            Err(error) => {
                gpu.executor.discard(&recording);
                return Err(gpu.cause(error).into());
            }
        };
        let picture = image.and_then(|_| bytes.pop());
        bytes.iter().for_each(|bytes| live.feedback(bytes));
        Ok(picture.map(|bytes| film(size, &bytes)))
    }

    /// Frees what is on the GPU.
    pub fn free(self, gpu: &mut Gpu) {
        let mut recording = Recording::new();
        if let Some(live) = self.live {
            live.free(&mut recording);
        }
        self.cache.free(&mut recording);
        self.store.free(&mut recording);
        // A device that is gone has freed everything already.
        let _ = gpu.executor.execute(&recording);
    }
}

/// A picture of kept light, planes of `(light, alpha)` and of numbers whose last is the depth, as a film of one sample.
fn film([width, height]: [u32; 2], bytes: &[u8]) -> Film {
    let pixels: Vec<[f32; 4]> = bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect();
    let (seen, told) = pixels.split_at(pixels.len() / 2);
    let moments = seen.iter().zip(told).map(|([r, g, b, alpha], [.., depth])| {
        let luminance = luminance([*r, *g, *b].map(f64::from)) as f32;
        [depth * alpha, luminance * luminance, 1.0, 0.0]
    });
    let planes = vec![seen.to_vec(), moments.collect()];
    Film::from_planes(width, height, planes).expect("two planes of all pixels")
}
