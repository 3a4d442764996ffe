//! Finding and opening a GPU where no host owns one, and what hosts that open their own should ask for.

use std::sync::{Arc, Mutex, PoisonError};

use lumivox_core::glam::DAffine3;
use lumivox_core::{Ease, Medium, Modality, Scene, TransferFunction, Volume, Voxels};
use lumivox_renderer::{Recording, SceneCache, VoxelStore};

use crate::error::GpuError;
use crate::executor::Executor;
#[cfg(not(target_family = "wasm"))]
use crate::filtering::FilterTest;
use crate::submission;

/// A device that could render.
#[derive(Clone, Debug)]
pub struct GpuDescription {
    /// The name its driver gives it.
    pub name: String,
    /// The driver's name and version.
    pub driver: String,
    /// `Vulkan`, `Metal`, `Dx12` or `BrowserWebGpu`.
    pub backend: String,
    /// Whether it computes on the CPU.
    pub software: bool,
    /// What it lacks, where it cannot be used.
    pub unsuitable: Option<String>,
}

/// An opened device and its executor.
#[derive(Debug)]
pub struct Gpu {
    /// What it is.
    pub description: GpuDescription,
    /// Replays recordings on it.
    pub executor: Executor,
    lost: Arc<Mutex<Option<String>>>,
}

/// What a host that opens its own device should enable, each where its adapter has it:
/// `adapter.features() & WANTED_FEATURES`.
///
/// With 16-bit norms, voxels of 16 bits have one channel. Without, as in browsers, they have two of 8 bits where a
/// [`FilterTest`](crate::FilterTest) says that these are filtered precisely, by kernels that take 1 to 2% longer; elsewhere they are half
/// floats, of 11 bits. Timestamps tell what a frame took ([`GpuTime`](crate::GpuTime)); without, the frame rate has to pace live views.
/// Nothing else depends on them.
pub const WANTED_FEATURES: wgpu::Features =
    wgpu::Features::TEXTURE_FORMAT_16BIT_NORM.union(wgpu::Features::TIMESTAMP_QUERY);

/// The limits that a host should ask for, all of which the adapter has.
///
/// WebGPU's own, `wgpu::Limits::default()`, suffice for everything; these differ in how large films, textures of voxels
/// and environment maps may be, and in how many storage buffers: in software, more than WebGPU's spare memory and time. A host with needs of its own joins the two: `wanted_limits(..).or_better_values_from(..)`.
pub fn wanted_limits(adapter: &wgpu::Adapter) -> wgpu::Limits {
    let has = adapter.limits();
    let default = wgpu::Limits::default();
    wgpu::Limits {
        max_texture_dimension_2d: has.max_texture_dimension_2d,
        max_texture_dimension_3d: has.max_texture_dimension_3d,
        max_buffer_size: has.max_buffer_size,
        max_storage_buffer_binding_size: has.max_storage_buffer_binding_size,
        // In software, uniforms are in storage buffers: see `Kernel::wgsl_without_uniforms`.
        max_storage_buffers_per_shader_stage: has.max_storage_buffers_per_shader_stage.min(16),
        ..default.or_worse_values_from(&has)
    }
}

/// Every adapter, those first that [`place`] says.
async fn adapters() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::PRIMARY;
    descriptor.flags = wgpu::InstanceFlags::empty().with_env();
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = instance.enumerate_adapters(wgpu::Backends::PRIMARY).await;
    if adapters.is_empty() {
        // Browsers show one at a time.
        adapters.extend(instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await);
    }
    // The order of equals is the driver's.
    adapters.sort_by_key(|adapter| {
        let info = adapter.get_info();
        place(info.device_type, info.backend)
    });
    adapters
}

/// Where an adapter stands among others: the most capable device first, and each by Vulkan before Direct3D, whose compiler takes
/// minutes for what Vulkan's take seconds for.
fn place(device: wgpu::DeviceType, backend: wgpu::Backend) -> (u8, u8) {
    let of_device = match device {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    (of_device, u8::from(backend == wgpu::Backend::Dx12))
}

/// The first of the candidates that opens and does what it is tried with. The only one there is is not tried: what is rendered
/// will tell.
///
/// # Errors
/// What the first of them has against it.
async fn first_that_works<C, G, E>(
    candidates: impl IntoIterator<Item = C>,
    open: impl AsyncFn(C) -> Result<G, E>,
    mut try_out: impl FnMut(&mut G) -> Result<(), E>,
) -> Option<Result<G, E>> {
    let mut candidates = candidates.into_iter().peekable();
    let mut first_error = None;
    while let Some(candidate) = candidates.next() {
        let is_only = first_error.is_none() && candidates.peek().is_none();
        let opened = open(candidate).await;
        let tried =
            opened.and_then(|mut gpu| if is_only { Ok(gpu) } else { try_out(&mut gpu).map(|()| gpu) });
        match tried {
            Ok(gpu) => return Some(Ok(gpu)),
            Err(error) => first_error = first_error.or(Some(error)),
        }
    }
    first_error.map(Err)
}

/// A scan of a few voxels, by which devices are tried.
fn trial() -> Scene {
    let voxels = Voxels::U8((0..64).collect());
    let volume = Volume::new([4; 3], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Other)
        .expect("voxels are as many as it says");
    let look = TransferFunction::from_points(Ease::Linear, &[(0.0, 0.0), (64.0, 1.0)], &[(0.0, [1.0; 3])])
        .expect("points are in order");
    Scene::with_volume(Arc::new(volume), Medium::new(look))
}

impl GpuDescription {
    fn of(info: wgpu::AdapterInfo) -> Self {
        Self {
            name: info.name,
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
            backend: format!("{:?}", info.backend),
            software: info.device_type == wgpu::DeviceType::Cpu,
            unsuitable: None,
        }
    }
}

fn describe(adapter: &wgpu::Adapter) -> GpuDescription {
    let mut unsuitable = None;
    wgpu::Limits::default().check_limits_with_fail_fn(&adapter.limits(), true, |name, needed, has| {
        unsuitable =
            Some(format!("it is less than WebGPU asks of a device: its {name} is {has}, not {needed}"));
    });
    GpuDescription { unsuitable, ..GpuDescription::of(adapter.get_info()) }
}

impl Gpu {
    /// Every device seen, the most capable first.
    pub fn list() -> Vec<GpuDescription> {
        pollster::block_on(adapters()).iter().map(describe).collect()
    }

    /// Opens the most capable device that works, or the first such whose name contains `name` in any case: where there are
    /// several, each is [tried](Self::try_out) first. Blocks until it is there:
    /// where that is impossible, as in a browser, [`request`](Self::request) does the same.
    ///
    /// # Errors
    /// [`GpuError`] when there is none, or it lacks something.
    pub fn open(name: Option<&str>) -> Result<Self, GpuError> {
        pollster::block_on(Self::request(name))
    }

    /// What [`open`](Self::open) does, without blocking.
    ///
    /// # Errors
    /// [`GpuError`] when there is none, or it lacks something.
    pub async fn request(name: Option<&str>) -> Result<Self, GpuError> {
        let adapters = adapters().await;
        if adapters.is_empty() {
            return Err(GpuError::NoAdapter);
        }
        let matches = |adapter: &&wgpu::Adapter| match name {
            Some(name) => adapter.get_info().name.to_lowercase().contains(&name.to_lowercase()),
            None => describe(adapter).unsuitable.is_none(),
        };
        let candidates = adapters.iter().filter(matches);
        match first_that_works(candidates, async |adapter| Self::request_on(adapter).await, Self::try_out)
            .await
        {
            Some(outcome) => outcome,
            None if name.is_none() => Self::request_on(&adapters[0]).await,
            None => Err(GpuError::NoSuchGpu {
                wanted: name.unwrap_or_default().to_owned(),
                available: adapters.iter().map(|a| a.get_info().name).collect::<Vec<_>>().join(", "),
            }),
        }
    }

    /// Opens the device at a place in [`list`](Self::list), where several have one name.
    ///
    /// # Errors
    /// [`GpuError`] when there is none, or it lacks something.
    pub fn open_at(index: usize) -> Result<Self, GpuError> {
        let adapters = pollster::block_on(adapters());
        match adapters.get(index) {
            Some(adapter) => pollster::block_on(Self::request_on(adapter)),
            None if adapters.is_empty() => Err(GpuError::NoAdapter),
            None => {
                let numbered =
                    |(at, adapter): (usize, &wgpu::Adapter)| format!("{at} {}", adapter.get_info().name);
                let available = adapters.iter().enumerate().map(numbered).collect::<Vec<_>>().join(", ");
                Err(GpuError::NoSuchIndex { index, available })
            }
        }
    }

    /// Opens the device of an adapter that the host chose, for one that shows its surface.
    ///
    /// # Errors
    /// [`GpuError`] when it lacks something.
    pub async fn request_on(adapter: &wgpu::Adapter) -> Result<Self, GpuError> {
        let description = describe(adapter);
        if let Some(reason) = &description.unsuitable {
            return Err(GpuError::Unsuitable { gpu: description.name, reason: reason.clone() });
        }
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("lumivox"),
            required_features: adapter.features() & WANTED_FEATURES,
            required_limits: wanted_limits(adapter),
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..Default::default()
        };
        let (device, queue) = adapter
            .request_device(&descriptor)
            .await
            .map_err(|e| GpuError::Unsuitable { gpu: description.name.clone(), reason: e.to_string() })?;
        let gpu = Self::of_device(device, queue);
        // Who may not wait asks by himself.
        #[cfg(not(target_family = "wasm"))]
        let gpu = {
            let mut gpu = gpu;
            let fine_texels = FilterTest::begin(gpu.executor.device(), gpu.executor.queue()).wait()?;
            gpu.executor.store_as(fine_texels);
            gpu
        };
        Ok(gpu)
    }

    /// A device that the host opened; [`WANTED_FEATURES`] and [`wanted_limits`] say how. Who calls this is told of its loss
    /// by [`check`](Self::check), and not by a callback of the device's set before.
    pub fn of_device(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let lost = Arc::new(Mutex::new(None));
        let record = lost.clone();
        device.set_device_lost_callback(move |_, message| {
            *record.lock().unwrap_or_else(PoisonError::into_inner) = Some(message);
        });
        let description = GpuDescription::of(device.adapter_info());
        Self { description, executor: Executor::new(device, queue), lost }
    }

    /// Has the device do what every render begins with, for a scan of a few voxels: a driver may be there, offer all that is
    /// asked of it, and fail at the first kernel. Its pipelines are kept for what is rendered next. Blocks.
    ///
    /// # Errors
    /// [`GpuError::Unsuitable`] when it fails.
    pub fn try_out(&mut self) -> Result<(), GpuError> {
        let scene = trial();
        let store = VoxelStore::new(self.executor.limits());
        let mut cache = SceneCache::new(&store);
        let mut recording = Recording::new();
        let updated = cache.update(&scene, &mut recording).map_err(|error| error.to_string());
        cache.free(&mut recording);
        store.free(&mut recording);
        updated
            .and_then(|()| {
                let done = self.executor.execute(&recording).and_then(|_| self.executor.wait());
                done.map_err(|error| match self.cause(error) {
                    // The last cause is the driver's, and no fault of ours.
                    GpuError::Refused(causes) => {
                        causes.trim().lines().last().unwrap_or_default().trim().to_owned()
                    }
                    other => other.to_string(),
                })
            })
            .map_err(|reason| {
                self.executor.discard(&recording);
                GpuError::Unsuitable {
                    gpu: self.description.name.clone(),
                    reason: format!("it fails at a first kernel: {reason}"),
                }
            })
    }

    /// The cause of an error: that the device is lost, where it is, or what the error says.
    pub(crate) fn cause(&self, error: GpuError) -> GpuError {
        // It may be lost without having said so.
        let polled = submission::poll(self.executor.device(), wgpu::PollType::Poll);
        self.check().and(polled).err().unwrap_or(error)
    }

    /// [`GpuError::Lost`] once the driver has given the device up, or the host has destroyed it.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn check(&self) -> Result<(), GpuError> {
        match self.lost.lock().unwrap_or_else(PoisonError::into_inner).clone() {
            Some(message) if message.is_empty() => Err(GpuError::Lost("its device was destroyed".to_owned())),
            Some(message) => Err(GpuError::Lost(message)),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vulkan_comes_before_direct3d_of_the_same_kind_of_device() {
        use wgpu::{Backend::*, DeviceType::*};
        let mut seen =
            [(Cpu, Dx12), (DiscreteGpu, Dx12), (Cpu, Vulkan), (IntegratedGpu, Vulkan), (DiscreteGpu, Vulkan)];
        seen.sort_by_key(|(device, backend)| place(*device, *backend));
        let wanted =
            [(DiscreteGpu, Vulkan), (DiscreteGpu, Dx12), (IntegratedGpu, Vulkan), (Cpu, Vulkan), (Cpu, Dx12)];
        assert_eq!(seen, wanted);
    }

    /// Wine has Direct3D devices that fail at the first kernel, and sorted first.
    #[test]
    fn what_fails_is_passed_over() {
        let open = async |candidate: &'static str| match candidate {
            "closed" => Err("does not open"),
            other => Ok(other),
        };
        let try_out = |gpu: &mut &str| if gpu.starts_with("broken") { Err("fails") } else { Ok(()) };
        let first = |candidates: &[&'static str]| {
            pollster::block_on(first_that_works(candidates.iter().copied(), open, try_out))
        };
        assert_eq!(first(&["good", "broken"]), Some(Ok("good")));
        assert_eq!(first(&["broken", "closed", "good"]), Some(Ok("good")));
        assert_eq!(first(&["broken", "closed"]), Some(Err("fails")));
        assert_eq!(first(&["closed", "broken"]), Some(Err("does not open")), "the last one is tried, too");
        assert_eq!(first(&["broken"]), Some(Ok("broken")), "nothing is left to take instead");
        assert_eq!(first(&["closed"]), Some(Err("does not open")));
        assert_eq!(first(&[]), None);
    }
}
