//! Shaders, pipelines and framebuffers on Godot's RenderingDevice. Shaders and the pipelines of what is dispatched are
//! made ahead, on threads of their own: the device lets any thread make them.

use std::collections::HashMap;
use std::sync::LazyLock;

use godot::classes::rendering_device::{
    BlendFactor, BlendOperation, CompareOperator, DeviceType, RenderPrimitive, ShaderStage,
};
use godot::classes::{
    RdPipelineColorBlendState, RdPipelineColorBlendStateAttachment, RdPipelineDepthStencilState,
    RdPipelineMultisampleState, RdPipelineRasterizationState, RdShaderSpirv, RenderingDevice,
    RenderingServer,
};
use godot::prelude::*;
use lumivox_renderer::Workshop;
use lumivox_renderer::recording::{Kernel, KernelKind};

use super::ExecuteError;
use super::spirv::{self, Binary};

/// RenderingDevice's name for "no vertex buffers".
const NO_VERTICES: i64 = -1;

/// A kernel on the device.
#[derive(Clone, Copy)]
pub struct Program {
    shader: Rid,
    /// Of what is dispatched; what is drawn has one for each kind of target.
    pipeline: Option<Rid>,
}

/// Whether the driver is one of software, where uniforms are in storage buffers: see [`Kernel::wgsl_without_uniforms`].
pub fn is_software() -> bool {
    RenderingServer::singleton().get_video_adapter_type() == DeviceType::CPU
}

/// What makes kernels, for every thread.
pub fn workshop() -> &'static Workshop<Program> {
    static WORKSHOP: LazyLock<Workshop<Program>> = LazyLock::new(|| Workshop::new(make));
    &WORKSHOP
}

fn make(kernel: Kernel) -> Result<Program, String> {
    let Some(mut device) = RenderingServer::singleton().get_rendering_device() else {
        return Err("there is no device".to_owned());
    };
    let mut binary = RdShaderSpirv::new_gd();
    let wgsl = if is_software() { kernel.wgsl_without_uniforms() } else { kernel.wgsl() };
    match spirv::compile(kernel, &wgsl)? {
        Binary::Compute(bytes) => {
            binary.set_stage_bytecode(ShaderStage::COMPUTE, &PackedByteArray::from(bytes));
        }
        Binary::Draw([vertex, fragment]) => {
            binary.set_stage_bytecode(ShaderStage::VERTEX, &PackedByteArray::from(vertex));
            binary.set_stage_bytecode(ShaderStage::FRAGMENT, &PackedByteArray::from(fragment));
        }
    }
    let shader = device.shader_create_from_spirv(&binary);
    if !shader.is_valid() {
        return Err("the driver refuses it".to_owned());
    }
    let pipeline = (kernel.kind() == KernelKind::Compute).then(|| device.compute_pipeline_create(shader));
    if pipeline.is_some_and(|pipeline| !pipeline.is_valid()) {
        device.free_rid(shader);
        return Err(NO_PIPELINE.to_owned());
    }
    Ok(Program { shader, pipeline })
}

/// What was made so far for the render thread alone.
#[derive(Default)]
pub struct Pipelines {
    draws: HashMap<(Kernel, i64), Rid>,
    framebuffers: HashMap<Rid, Rid>,
}

impl Pipelines {
    /// A kernel's shader, for its uniform sets.
    pub fn shader(&self, kernel: Kernel) -> Result<Rid, ExecuteError> {
        Ok(program(kernel)?.shader)
    }

    /// The pipeline of a kernel that is dispatched.
    pub fn compute(&self, kernel: Kernel) -> Result<Rid, ExecuteError> {
        program(kernel)?.pipeline.ok_or_else(|| no_pipeline(kernel))
    }

    /// The framebuffer of a texture alone, and the pipeline that draws a kernel into it.
    pub fn draw(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        kernel: Kernel,
        target: Rid,
    ) -> Result<(Rid, Rid), ExecuteError> {
        let framebuffer = match self.framebuffers.get(&target) {
            // It goes with its texture.
            Some(framebuffer) if device.framebuffer_is_valid(*framebuffer) => *framebuffer,
            _ => {
                let framebuffer = device.framebuffer_create(&array![target]);
                if !framebuffer.is_valid() {
                    return Err(no_pipeline(kernel));
                }
                self.framebuffers.retain(|_, other| device.framebuffer_is_valid(*other));
                self.framebuffers.insert(target, framebuffer);
                framebuffer
            }
        };
        let format = device.framebuffer_get_format(framebuffer);
        if let Some(pipeline) = self.draws.get(&(kernel, format)) {
            return Ok((framebuffer, *pipeline));
        }
        let shader = self.shader(kernel)?;
        let mut multisample = RdPipelineMultisampleState::new_gd();
        multisample.set_sample_count(device.framebuffer_format_get_texture_samples(format));
        let pipeline = device.render_pipeline_create(
            shader,
            format,
            NO_VERTICES,
            RenderPrimitive::TRIANGLES,
            &RdPipelineRasterizationState::new_gd(),
            &multisample,
            &depth_state(kernel.kind()),
            &blend_state(kernel.kind()),
        );
        if !pipeline.is_valid() {
            return Err(no_pipeline(kernel));
        }
        self.draws.insert((kernel, format), pipeline);
        Ok((framebuffer, pipeline))
    }

    /// Frees everything.
    pub fn free(&mut self, device: &mut Gd<RenderingDevice>) {
        for (_, framebuffer) in self.framebuffers.drain() {
            if device.framebuffer_is_valid(framebuffer) {
                device.free_rid(framebuffer);
            }
        }
        // A shader takes its pipelines with it.
        self.draws.clear();
        for program in workshop().clear() {
            device.free_rid(program.shader);
        }
    }
}

fn program(kernel: Kernel) -> Result<Program, ExecuteError> {
    workshop().get(kernel).map_err(|why| ExecuteError::Kernel { kernel: kernel.entry_point(), why })
}

const NO_PIPELINE: &str = "the driver makes no pipeline of it";

fn no_pipeline(kernel: Kernel) -> ExecuteError {
    ExecuteError::Kernel { kernel: kernel.entry_point(), why: NO_PIPELINE.to_owned() }
}

fn depth_state(kind: KernelKind) -> Gd<RdPipelineDepthStencilState> {
    let mut state = RdPipelineDepthStencilState::new_gd();
    if kind == KernelKind::DrawDepth {
        state.set_enable_depth_test(true);
        state.set_enable_depth_write(true);
        state.set_depth_compare_operator(CompareOperator::ALWAYS);
    }
    state
}

fn blend_state(kind: KernelKind) -> Gd<RdPipelineColorBlendState> {
    let mut state = RdPipelineColorBlendState::new_gd();
    if kind == KernelKind::DrawColor {
        let mut over = RdPipelineColorBlendStateAttachment::new_gd();
        over.set_enable_blend(true);
        over.set_src_color_blend_factor(BlendFactor::ONE);
        over.set_dst_color_blend_factor(BlendFactor::ONE_MINUS_SRC_ALPHA);
        over.set_color_blend_op(BlendOperation::ADD);
        over.set_src_alpha_blend_factor(BlendFactor::ONE);
        over.set_dst_alpha_blend_factor(BlendFactor::ONE_MINUS_SRC_ALPHA);
        over.set_alpha_blend_op(BlendOperation::ADD);
        state.set_attachments(&array![&over]);
    } else if kind == KernelKind::DrawOver {
        state.set_attachments(&array![&RdPipelineColorBlendStateAttachment::new_gd()]);
    }
    state
}
