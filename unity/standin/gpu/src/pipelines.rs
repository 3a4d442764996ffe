//! Kernels and drawn programs, with a pipeline for each way in which they are used.

use std::collections::HashMap;

use crate::spirv::{Kind, Module, Shape};

/// What is bound to one variable, as far as a layout depends on it.
pub type Entry = (u32, wgpu::BindingType);

/// A compute kernel and its pipelines, by what is bound.
#[derive(Debug)]
pub struct Kernel {
    pub module: Module,
    shader: wgpu::ShaderModule,
    pipelines: HashMap<Vec<Entry>, (wgpu::ComputePipeline, wgpu::BindGroupLayout)>,
}

/// A vertex and a fragment stage, in this order, and their pipelines.
#[derive(Debug)]
pub struct Program {
    pub modules: [Module; 2],
    shaders: [wgpu::ShaderModule; 2],
    pipelines: HashMap<(DrawState, Targets, [Vec<Entry>; 2]), Drawn>,
}

/// A pipeline, and the layouts of what its stages bind.
type Drawn = (wgpu::RenderPipeline, [wgpu::BindGroupLayout; 2]);

/// Formats drawn to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Targets {
    pub color: Option<wgpu::TextureFormat>,
    pub depth: Option<wgpu::TextureFormat>,
}

/// The fixed state of a draw, in the numbers of Unity's enumerations. Shared with `Native.cs`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DrawState {
    pub blend: u32,
    /// Source, destination and operation of colour, then of alpha.
    pub blend_factors: [u32; 6],
    pub color_mask: u32,
    pub depth_write: u32,
    pub depth_test: u32,
    pub cull: u32,
    pub topology: u32,
}

fn load(device: &wgpu::Device, module: &Module) -> wgpu::ShaderModule {
    let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
        label: Some(&module.entry),
        spirv: Some(module.words.clone().into()),
        ..Default::default()
    };
    // SAFETY: a compiler made the module, and its bindings were read from it.
    unsafe { device.create_shader_module_passthrough(descriptor) }
}

fn layout(device: &wgpu::Device, entries: &[Entry], visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = entries
        .iter()
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding: *binding,
            visibility,
            ty: *ty,
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
}

/// What a variable's place in a layout is, given the format of the texture that is bound to it.
pub fn binding_type(
    kind: Kind,
    format: Option<wgpu::TextureFormat>,
    constants_in_storage: bool,
) -> wgpu::BindingType {
    let dimension = |shape| match shape {
        Shape::Flat => wgpu::TextureViewDimension::D2,
        Shape::Array => wgpu::TextureViewDimension::D2Array,
        Shape::Cube => wgpu::TextureViewDimension::Cube,
        Shape::Solid => wgpu::TextureViewDimension::D3,
    };
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    match kind {
        Kind::Constant if constants_in_storage => {
            buffer(wgpu::BufferBindingType::Storage { read_only: true })
        }
        Kind::Constant => buffer(wgpu::BufferBindingType::Uniform),
        Kind::Buffer { writable } => buffer(wgpu::BufferBindingType::Storage { read_only: !writable }),
        Kind::Texture(shape) => wgpu::BindingType::Texture {
            sample_type: match format {
                Some(format) if format.is_depth_stencil_format() => wgpu::TextureSampleType::Depth,
                Some(wgpu::TextureFormat::R32Uint) => wgpu::TextureSampleType::Uint,
                Some(
                    wgpu::TextureFormat::R32Float
                    | wgpu::TextureFormat::Rg32Float
                    | wgpu::TextureFormat::Rgba32Float,
                ) => wgpu::TextureSampleType::Float { filterable: false },
                _ => wgpu::TextureSampleType::Float { filterable: true },
            },
            view_dimension: dimension(shape),
            multisampled: false,
        },
        Kind::Image(shape) => wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format: format.unwrap_or(wgpu::TextureFormat::R32Float),
            view_dimension: dimension(shape),
        },
        Kind::Sampler => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
    }
}

impl Kernel {
    pub fn new(device: &wgpu::Device, module: Module) -> Self {
        Self { shader: load(device, &module), module, pipelines: HashMap::new() }
    }

    pub fn pipeline(
        &mut self,
        device: &wgpu::Device,
        entries: Vec<Entry>,
    ) -> &(wgpu::ComputePipeline, wgpu::BindGroupLayout) {
        self.pipelines.entry(entries).or_insert_with_key(|entries| {
            let layout = layout(device, entries, wgpu::ShaderStages::COMPUTE);
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[Some(&layout)],
                ..Default::default()
            });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(&self.module.entry),
                layout: Some(&pipeline_layout),
                module: &self.shader,
                entry_point: Some(&self.module.entry),
                compilation_options: Default::default(),
                cache: None,
            });
            (pipeline, layout)
        })
    }
}

impl Program {
    pub fn new(device: &wgpu::Device, modules: [Module; 2]) -> Self {
        let shaders = [load(device, &modules[0]), load(device, &modules[1])];
        Self { modules, shaders, pipelines: HashMap::new() }
    }

    pub fn pipeline(
        &mut self,
        device: &wgpu::Device,
        state: DrawState,
        targets: Targets,
        entries: [Vec<Entry>; 2],
    ) -> Result<&Drawn, String> {
        let depth_stencil = match targets.depth {
            Some(format) => Some(wgpu::DepthStencilState {
                format,
                depth_write_enabled: Some(state.depth_write != 0),
                depth_compare: Some(compare(state.depth_test)?),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            None => None,
        };
        let color_targets: Vec<_> = match targets.color {
            Some(format) => vec![Some(wgpu::ColorTargetState {
                format,
                blend: blend(&state)?,
                write_mask: color_mask(state.color_mask),
            })],
            None => vec![],
        };
        let cull_mode = match state.cull {
            0 => None,
            1 => Some(wgpu::Face::Front),
            _ => Some(wgpu::Face::Back),
        };
        let topology = match state.topology {
            0 => wgpu::PrimitiveTopology::TriangleList,
            other => return Err(format!("the stand-in draws triangles only, not topology {other}")),
        };
        let Self { modules, shaders, pipelines } = self;
        Ok(pipelines.entry((state, targets, entries)).or_insert_with_key(|(_, _, entries)| {
            let layouts = [
                layout(device, &entries[0], wgpu::ShaderStages::VERTEX),
                layout(device, &entries[1], wgpu::ShaderStages::FRAGMENT),
            ];
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[Some(&layouts[0]), Some(&layouts[1])],
                ..Default::default()
            });
            let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(&modules[1].entry),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &shaders[0],
                    entry_point: Some(&modules[0].entry),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState {
                    topology,
                    // Unity's front faces run clockwise.
                    front_face: wgpu::FrontFace::Cw,
                    cull_mode,
                    ..Default::default()
                },
                depth_stencil,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &shaders[1],
                    entry_point: Some(&modules[1].entry),
                    compilation_options: Default::default(),
                    targets: &color_targets,
                }),
                multiview_mask: None,
                cache: None,
            });
            (pipeline, layouts)
        }))
    }
}

fn compare(number: u32) -> Result<wgpu::CompareFunction, String> {
    use wgpu::CompareFunction::*;
    let all = [Always, Never, Less, Equal, LessEqual, Greater, NotEqual, GreaterEqual, Always];
    all.get(number as usize).copied().ok_or_else(|| format!("{number} is no comparison of depths"))
}

/// Unity's mask has alpha as its lowest bit, red as its highest.
fn color_mask(mask: u32) -> wgpu::ColorWrites {
    let writes =
        [wgpu::ColorWrites::ALPHA, wgpu::ColorWrites::BLUE, wgpu::ColorWrites::GREEN, wgpu::ColorWrites::RED];
    (0..4).filter(|bit| mask >> bit & 1 == 1).map(|bit| writes[bit as usize]).collect()
}

fn blend(state: &DrawState) -> Result<Option<wgpu::BlendState>, String> {
    if state.blend == 0 {
        return Ok(None);
    }
    let factor = |number: u32| {
        use wgpu::BlendFactor::*;
        let all = [
            Zero,
            One,
            Dst,
            Src,
            OneMinusDst,
            SrcAlpha,
            OneMinusSrc,
            DstAlpha,
            OneMinusDstAlpha,
            SrcAlphaSaturated,
            OneMinusSrcAlpha,
        ];
        all.get(number as usize).copied().ok_or_else(|| format!("{number} is no blend factor"))
    };
    let operation = |number: u32| {
        use wgpu::BlendOperation::*;
        let all = [Add, Subtract, ReverseSubtract, Min, Max];
        all.get(number as usize)
            .copied()
            .ok_or_else(|| format!("{number} is no blend operation of the stand-in's"))
    };
    let component = |[source, destination, of]: [u32; 3]| -> Result<_, String> {
        Ok(wgpu::BlendComponent {
            src_factor: factor(source)?,
            dst_factor: factor(destination)?,
            operation: operation(of)?,
        })
    };
    let [a, b, c, d, e, f] = state.blend_factors;
    Ok(Some(wgpu::BlendState { color: component([a, b, c])?, alpha: component([d, e, f])? }))
}
