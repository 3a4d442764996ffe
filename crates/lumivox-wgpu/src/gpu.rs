//! Finding and opening a GPU where no host owns one.

use std::sync::{Arc, Mutex, PoisonError};

use crate::error::GpuError;
use crate::executor::Executor;

/// A device that could render.
#[derive(Clone, Debug)]
pub struct GpuDescription {
    /// The name its driver gives it.
    pub name: String,
    /// The driver's name and version.
    pub driver: String,
    /// `Vulkan`, `Metal` or `Dx12`.
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

/// What a device must have beyond WebGPU's baseline: 16-bit scans stay 16-bit.
const FEATURES: wgpu::Features = wgpu::Features::TEXTURE_FORMAT_16BIT_NORM;

fn adapters() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::PRIMARY;
    descriptor.flags = wgpu::InstanceFlags::empty().with_env();
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    // The most capable first; the order of equals is the driver's.
    adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
    adapters
}

fn describe(adapter: &wgpu::Adapter) -> GpuDescription {
    let info = adapter.get_info();
    let unsuitable = (!adapter.features().contains(FEATURES)).then(|| "it has no 16-bit textures".to_owned());
    GpuDescription {
        name: info.name,
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        backend: format!("{:?}", info.backend),
        software: info.device_type == wgpu::DeviceType::Cpu,
        unsuitable,
    }
}

impl Gpu {
    /// Every device seen, the most capable first.
    pub fn list() -> Vec<GpuDescription> {
        adapters().iter().map(describe).collect()
    }

    /// Opens the most capable device, or the first whose name contains `name` in any case.
    ///
    /// # Errors
    /// [`GpuError`] when there is none, or it lacks something.
    pub fn open(name: Option<&str>) -> Result<Self, GpuError> {
        let adapters = adapters();
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
        let description = describe(adapter);
        if let Some(reason) = &description.unsuitable {
            return Err(GpuError::Unsuitable { gpu: description.name, reason: reason.clone() });
        }
        // Everything the device has: volumes and films are large.
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("lumivox"),
            required_features: FEATURES,
            required_limits: adapter.limits(),
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| GpuError::Unsuitable { gpu: description.name.clone(), reason: e.to_string() })?;
        let lost = Arc::new(Mutex::new(None));
        let record = lost.clone();
        device.set_device_lost_callback(move |_, message| {
            *record.lock().unwrap_or_else(PoisonError::into_inner) = Some(message);
        });
        Ok(Self { description, executor: Executor::new(device, queue), lost })
    }

    /// [`GpuError::Lost`] once the driver has given the device up.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn check(&self) -> Result<(), GpuError> {
        match self.lost.lock().unwrap_or_else(PoisonError::into_inner).clone() {
            Some(message) => Err(GpuError::Lost(message)),
            None => Ok(()),
        }
    }
}
