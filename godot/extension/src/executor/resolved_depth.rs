//! Writes the depth of volumes into what the engine has resolved of a multisampled depth.
//!
//! The engine resolves before volumes are drawn, and copies the outcome for materials that look at what is behind them. What
//! was drawn into the multisampled depth since is not in it, and it cannot be drawn to; the Forward+ renderer lets it be
//! stored to.

use std::collections::HashMap;

use godot::classes::rendering_device::{ShaderStage, TextureUsageBits, UniformType};
use godot::classes::{RdShaderSpirv, RdUniform, RenderingDevice};
use godot::prelude::*;

use super::spirv;

const NAME: &str = "resolved_depth";
const WGSL: &str = include_str!("resolved_depth.wgsl");
/// Pixels of a workgroup along a side.
const WORKGROUP: u32 = 8;

/// The program for it, and what it was bound to.
#[derive(Default)]
pub struct ResolvedDepth {
    program: Option<(Rid, Rid)>,
    /// By picture and target.
    sets: HashMap<[Rid; 2], Rid>,
}

impl ResolvedDepth {
    /// Stores the depth in `picture`, a buffer with one for each pixel, in `target`; nothing where the engine keeps that from
    /// being stored to.
    ///
    /// # Errors
    /// The program's name, and why the driver does not run it.
    pub fn store(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        picture: Rid,
        target: Rid,
    ) -> Result<(), (&'static str, String)> {
        let Some(format) = device.texture_get_format(target) else { return Ok(()) };
        if !format.get_usage_bits().is_set(TextureUsageBits::STORAGE_BIT) {
            return Ok(());
        }
        let failed = |why: String| (NAME, why);
        let (shader, pipeline) = match self.program {
            Some(program) => program,
            None => *self.program.insert(make(device).map_err(failed)?),
        };
        self.sets.retain(|_, set| device.uniform_set_is_valid(*set));
        let set = match self.sets.get(&[picture, target]) {
            Some(set) => *set,
            None => {
                let bound = [(UniformType::STORAGE_BUFFER, picture), (UniformType::IMAGE, target)];
                let mut uniforms = Array::<Gd<RdUniform>>::new();
                for (binding, (kind, rid)) in (0..).zip(bound) {
                    let mut uniform = RdUniform::new_gd();
                    uniform.set_uniform_type(kind);
                    uniform.set_binding(binding);
                    uniform.add_id(rid);
                    uniforms.push(&uniform);
                }
                let set = device.uniform_set_create(&uniforms, shader, 0);
                if !set.is_valid() {
                    return Err(failed("the resolved depth cannot be bound".to_owned()));
                }
                self.sets.insert([picture, target], set);
                set
            }
        };
        let list = device.compute_list_begin();
        device.compute_list_bind_compute_pipeline(list, pipeline);
        device.compute_list_bind_uniform_set(list, set, 0);
        let [x, y] = [format.get_width(), format.get_height()].map(|n| n.div_ceil(WORKGROUP));
        device.compute_list_dispatch(list, x, y, 1);
        device.compute_list_end();
        Ok(())
    }

    /// Frees everything.
    pub fn free(&mut self, device: &mut Gd<RenderingDevice>) {
        for (_, set) in self.sets.drain() {
            if device.uniform_set_is_valid(set) {
                device.free_rid(set);
            }
        }
        if let Some((shader, _)) = self.program.take() {
            // It takes its pipeline with it.
            device.free_rid(shader);
        }
    }
}

fn make(device: &mut Gd<RenderingDevice>) -> Result<(Rid, Rid), String> {
    let mut binary = RdShaderSpirv::new_gd();
    let bytes = spirv::compile_compute(WGSL)?;
    binary.set_stage_bytecode(ShaderStage::COMPUTE, &PackedByteArray::from(bytes));
    let shader = device.shader_create_from_spirv(&binary);
    if !shader.is_valid() {
        return Err("the driver refuses it".to_owned());
    }
    let pipeline = device.compute_pipeline_create(shader);
    if !pipeline.is_valid() {
        device.free_rid(shader);
        return Err("the driver makes no pipeline of it".to_owned());
    }
    Ok((shader, pipeline))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_becomes_spirv() {
        assert!(spirv::compile_compute(WGSL).is_ok_and(|bytes| !bytes.is_empty()));
    }
}
