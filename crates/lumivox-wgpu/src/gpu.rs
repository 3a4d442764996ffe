//! Finding and opening a GPU where no host owns one, and what hosts that open their own should ask for.

use std::sync::{Arc, Mutex, PoisonError};

use crate::error::GpuError;
use crate::executor::Executor;
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
/// With 16-bit norms, scans of 16 bits stay as they are; without, they are stored as half floats, of 11 bits. Timestamps
/// tell what a frame took ([`GpuTime`](crate::GpuTime)); without, the frame rate has to pace live views. Nothing else
/// depends on them.
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

/// Every adapter, the most capable first.
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
    adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
    adapters
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

    /// Opens the most capable device, or the first whose name contains `name` in any case. Blocks until it is there:
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
        let Some(adapter) = adapters.iter().find(matches).or(name.is_none().then(|| &adapters[0])) else {
            return Err(GpuError::NoSuchGpu {
                wanted: name.unwrap_or_default().to_owned(),
                available: adapters.iter().map(|a| a.get_info().name).collect::<Vec<_>>().join(", "),
            });
        };
        Self::request_on(adapter).await
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
        Ok(Self::of_device(device, queue))
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
