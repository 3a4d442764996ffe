//! Kernels as wgpu pipelines.

use std::sync::Arc;

use lumivox_renderer::Workshop;
use lumivox_renderer::recording::{BindingKind, Kernel, KernelKind};

use crate::submission::at_once;

/// A pipeline and the layout of its only bind group.
#[derive(Debug)]
pub(crate) struct Pipeline<T> {
    pub layout: wgpu::BindGroupLayout,
    pub pipeline: T,
}

/// In buffers of which kind kernels find their uniforms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Uniforms {
    Uniform,
    /// Where the driver is one of software: see [`Kernel::wgsl_without_uniforms`].
    Storage,
}

impl Uniforms {
    /// For a device.
    pub fn on(device: &wgpu::Device) -> Self {
        let in_software = device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        let most = device.limits().max_storage_buffers_per_shader_stage as usize;
        let fit = || Kernel::all().all(|kernel| kernel.buffers() <= most);
        if in_software && fit() { Self::Storage } else { Self::Uniform }
    }

    fn binding_type(self) -> wgpu::BufferBindingType {
        match self {
            Self::Uniform => wgpu::BufferBindingType::Uniform,
            Self::Storage => wgpu::BufferBindingType::Storage { read_only: true },
        }
    }

    /// What the buffer is used for that they are written to.
    pub fn usage(self) -> wgpu::BufferUsages {
        match self {
            Self::Uniform => wgpu::BufferUsages::UNIFORM,
            Self::Storage => wgpu::BufferUsages::STORAGE,
        }
    }

    /// A multiple of this is where those of a step begin.
    pub fn alignment(self, limits: &wgpu::Limits) -> u64 {
        u64::from(match self {
            Self::Uniform => limits.min_uniform_buffer_offset_alignment,
            Self::Storage => limits.min_storage_buffer_offset_alignment,
        })
    }
}

/// What the pipeline of a kernel that is drawn depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct DrawKey {
    pub kernel: Kernel,
    /// Of the target.
    pub format: wgpu::TextureFormat,
    pub samples: u32,
}

/// Of those of the kernels that are drawn onto such a target.
pub(crate) fn draw_keys(
    kernels: impl IntoIterator<Item = Kernel>,
    format: wgpu::TextureFormat,
    samples: u32,
) -> impl Iterator<Item = DrawKey> {
    let is_depth = format.has_depth_aspect();
    let of_kind = kernels.into_iter().filter(move |kernel| match kernel.kind() {
        KernelKind::Compute => false,
        KernelKind::DrawDepth => is_depth,
        KernelKind::DrawColor | KernelKind::DrawOver => !is_depth,
    });
    of_kind.map(move |kernel| DrawKey { kernel, format, samples })
}

/// Makes the pipelines of kernels that run in workgroups, ahead and on threads of their own.
pub(crate) fn dispatches(
    device: wgpu::Device,
    uniforms: Uniforms,
) -> Workshop<Arc<Pipeline<wgpu::ComputePipeline>>> {
    Workshop::new(move |kernel| checked(&device, || compute(&device, kernel, uniforms)))
}

/// The same of kernels that are drawn.
pub(crate) fn draws(
    device: wgpu::Device,
    uniforms: Uniforms,
) -> Workshop<Arc<Pipeline<wgpu::RenderPipeline>>, DrawKey> {
    Workshop::new(move |key| checked(&device, || render(&device, key, uniforms)))
}

/// Makes a pipeline, or says why the device does not.
fn checked<T>(device: &wgpu::Device, make: impl FnOnce() -> Pipeline<T>) -> Result<Arc<Pipeline<T>>, String> {
    // Scopes catch what goes wrong on their own thread. Want of memory is no kernel's fault: the device's own handler
    // takes it.
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let internal = device.push_error_scope(wgpu::ErrorFilter::Internal);
    let pipeline = make();
    // Browsers tell later, which cannot be waited for; there, what was submitted with the pipeline is refused.
    let errors = [internal, validation].map(|scope| at_once(Box::pin(scope.pop())).flatten());
    match errors.into_iter().flatten().next() {
        Some(error) => Err(error.to_string()),
        None => Ok(Arc::new(pipeline)),
    }
}

/// A kernel that runs in workgroups.
fn compute(device: &wgpu::Device, kernel: Kernel, uniforms: Uniforms) -> Pipeline<wgpu::ComputePipeline> {
    let (layout, pipeline_layout, module) = parts(device, kernel, uniforms, wgpu::ShaderStages::COMPUTE);
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(kernel.entry_point()),
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some(kernel.entry_point()),
        // Kernels write what they read.
        compilation_options: wgpu::PipelineCompilationOptions {
            zero_initialize_workgroup_memory: false,
            ..Default::default()
        },
        cache: None,
    });
    Pipeline { layout, pipeline }
}

/// A kernel that is drawn over a target.
fn render(device: &wgpu::Device, key: DrawKey, uniforms: Uniforms) -> Pipeline<wgpu::RenderPipeline> {
    let DrawKey { kernel, format, samples } = key;
    let (layout, pipeline_layout, module) = parts(device, kernel, uniforms, wgpu::ShaderStages::FRAGMENT);
    let color = kernel.kind() != KernelKind::DrawDepth;
    let is_blended = kernel.kind() == KernelKind::DrawColor;
    let targets = [Some(wgpu::ColorTargetState {
        format,
        blend: is_blended.then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
        write_mask: wgpu::ColorWrites::ALL,
    })];
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(kernel.entry_point()),
        layout: Some(&pipeline_layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(Kernel::VERTEX_ENTRY_POINT),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: (!color).then_some(wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Always),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(kernel.entry_point()),
            compilation_options: Default::default(),
            targets: if color { &targets } else { &[] },
        }),
        multiview_mask: None,
        cache: None,
    });
    Pipeline { layout, pipeline }
}

fn parts(
    device: &wgpu::Device,
    kernel: Kernel,
    uniforms: Uniforms,
    visibility: wgpu::ShaderStages,
) -> (wgpu::BindGroupLayout, wgpu::PipelineLayout, wgpu::ShaderModule) {
    let label = Some(kernel.entry_point());
    let entries: Vec<_> = (0..)
        .zip(kernel.bindings())
        .map(|(binding, kind)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility,
            ty: binding_type(*kind, uniforms),
            count: None,
        })
        .collect();
    let layout =
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    let text = match uniforms {
        Uniforms::Uniform => kernel.wgsl(),
        Uniforms::Storage => kernel.wgsl_without_uniforms(),
    };
    let descriptor = wgpu::ShaderModuleDescriptor { label, source: wgpu::ShaderSource::Wgsl(text.into()) };
    // Counting every loop's turns costs a path tracer 8 to 15% on an H200.
    let checks = wgpu::ShaderRuntimeChecks { force_loop_bounding: false, ..Default::default() };
    // SAFETY: the one check that is left out asks that no loop runs forever. The text is a kernel's own, and all of its
    // loops end, whatever numbers they meet: the documentation of `lumivox_shaders` says why. Indices stay checked.
    let module = unsafe { device.create_shader_module_trusted(descriptor, checks) };
    (layout, pipeline_layout, module)
}

fn binding_type(kind: BindingKind, uniforms: Uniforms) -> wgpu::BindingType {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let texture = |filterable, view_dimension| wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable },
        view_dimension,
        multisampled: false,
    };
    match kind {
        BindingKind::Uniform => buffer(uniforms.binding_type()),
        BindingKind::StorageRead => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
        BindingKind::StorageReadWrite => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
        BindingKind::Texture3d => texture(true, wgpu::TextureViewDimension::D3),
        BindingKind::Texture2dLoaded => texture(false, wgpu::TextureViewDimension::D2),
        BindingKind::LinearSampler => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
    }
}
