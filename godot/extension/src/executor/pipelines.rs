//! Shaders, pipelines and framebuffers on Godot's RenderingDevice, made when they are first needed.

use std::collections::HashMap;

use godot::classes::rendering_device::{
    BlendFactor, BlendOperation, CompareOperator, RenderPrimitive, ShaderStage,
};
use godot::classes::{
    RdPipelineColorBlendState, RdPipelineColorBlendStateAttachment, RdPipelineDepthStencilState,
    RdPipelineMultisampleState, RdPipelineRasterizationState, RdShaderSpirv, RenderingDevice,
};
use godot::prelude::*;
use lumivox_renderer::recording::{Kernel, Stage};

use super::ExecuteError;
use super::spirv::{self, Binary};

/// RenderingDevice's name for "no vertex buffers".
const NO_VERTICES: i64 = -1;

/// What was made so far.
#[derive(Default)]
pub struct Pipelines {
    shaders: HashMap<Kernel, Rid>,
    computes: HashMap<Kernel, Rid>,
    draws: HashMap<(Kernel, i64), Rid>,
    framebuffers: HashMap<Rid, Rid>,
}

impl Pipelines {
    /// A kernel's shader, for its uniform sets.
    pub fn shader(&mut self, device: &mut Gd<RenderingDevice>, kernel: Kernel) -> Result<Rid, ExecuteError> {
        if let Some(shader) = self.shaders.get(&kernel) {
            return Ok(*shader);
        }
        let refused = |why| ExecuteError::Kernel { kernel: kernel.entry_point(), why };
        let mut binary = RdShaderSpirv::new_gd();
        match spirv::compile(kernel).map_err(refused)? {
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
            return Err(refused("the driver refuses it".to_owned()));
        }
        self.shaders.insert(kernel, shader);
        Ok(shader)
    }

    /// The pipeline of a kernel that is dispatched.
    pub fn compute(&mut self, device: &mut Gd<RenderingDevice>, kernel: Kernel) -> Result<Rid, ExecuteError> {
        if let Some(pipeline) = self.computes.get(&kernel) {
            return Ok(*pipeline);
        }
        let shader = self.shader(device, kernel)?;
        let pipeline = device.compute_pipeline_create(shader);
        if !pipeline.is_valid() {
            return Err(no_pipeline(kernel));
        }
        self.computes.insert(kernel, pipeline);
        Ok(pipeline)
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
        let shader = self.shader(device, kernel)?;
        let mut multisample = RdPipelineMultisampleState::new_gd();
        multisample.set_sample_count(device.framebuffer_format_get_texture_samples(format));
        let pipeline = device.render_pipeline_create(
            shader,
            format,
            NO_VERTICES,
            RenderPrimitive::TRIANGLES,
            &RdPipelineRasterizationState::new_gd(),
            &multisample,
            &depth_state(kernel.stage()),
            &blend_state(kernel.stage()),
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
        self.computes.clear();
        for (_, shader) in self.shaders.drain() {
            device.free_rid(shader);
        }
    }
}

fn no_pipeline(kernel: Kernel) -> ExecuteError {
    let why = "the driver makes no pipeline of it".to_owned();
    ExecuteError::Kernel { kernel: kernel.entry_point(), why }
}

fn depth_state(stage: Stage) -> Gd<RdPipelineDepthStencilState> {
    let mut state = RdPipelineDepthStencilState::new_gd();
    if stage == Stage::DrawDepth {
        state.set_enable_depth_test(true);
        state.set_enable_depth_write(true);
        state.set_depth_compare_operator(CompareOperator::ALWAYS);
    }
    state
}

fn blend_state(stage: Stage) -> Gd<RdPipelineColorBlendState> {
    let mut state = RdPipelineColorBlendState::new_gd();
    if stage == Stage::DrawColor {
        let mut over = RdPipelineColorBlendStateAttachment::new_gd();
        over.set_enable_blend(true);
        over.set_src_color_blend_factor(BlendFactor::ONE);
        over.set_dst_color_blend_factor(BlendFactor::ONE_MINUS_SRC_ALPHA);
        over.set_color_blend_op(BlendOperation::ADD);
        over.set_src_alpha_blend_factor(BlendFactor::ONE);
        over.set_dst_alpha_blend_factor(BlendFactor::ONE_MINUS_SRC_ALPHA);
        over.set_alpha_blend_op(BlendOperation::ADD);
        state.set_attachments(&array![&over]);
    }
    state
}
