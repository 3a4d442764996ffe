//! Kernels as the SPIR-V that Godot's RenderingDevice takes.

use lumivox_renderer::recording::{Kernel, KernelKind};
use naga::ShaderStage;
use naga::back::spv;
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

/// The name of every entry point.
const MAIN: &str = "main";

/// A kernel's shader stages: one for what is dispatched, vertex and fragment for what is drawn.
#[derive(Debug)]
pub enum Binary {
    /// A compute shader.
    Compute(Vec<u8>),
    /// A vertex and a fragment shader.
    Draw([Vec<u8>; 2]),
}

/// Compiles the text of a kernel, one of its two, to SPIR-V 1.3.
///
/// # Errors
/// What naga says, should the kernel be beyond it.
pub fn compile(kernel: Kernel, wgsl: &str) -> Result<Binary, String> {
    let text = Text::new(wgsl)?;
    Ok(match kernel.kind() {
        KernelKind::Compute => Binary::Compute(text.stage(ShaderStage::Compute)?),
        KernelKind::DrawColor | KernelKind::DrawOver | KernelKind::DrawDepth => {
            Binary::Draw([text.stage(ShaderStage::Vertex)?, text.stage(ShaderStage::Fragment)?])
        }
    })
}

/// Compiles a compute shader that is no kernel of the renderer's.
///
/// # Errors
/// What naga says of it.
pub fn compile_compute(wgsl: &str) -> Result<Vec<u8>, String> {
    Text::new(wgsl)?.stage(ShaderStage::Compute)
}

/// WGSL that was understood.
struct Text {
    module: naga::Module,
    info: ModuleInfo,
}

impl Text {
    fn new(wgsl: &str) -> Result<Self, String> {
        let mut module = naga::front::wgsl::parse_str(wgsl).map_err(|error| error.emit_to_string(wgsl))?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::SHADER_FLOAT16_IN_FLOAT32)
            .validate(&module)
            .map_err(|error| error.emit_to_string(wgsl))?;
        // The only name that Godot looks for.
        module.entry_points.iter_mut().for_each(|entry| entry.name = MAIN.to_owned());
        Ok(Self { module, info })
    }

    fn stage(&self, shader_stage: ShaderStage) -> Result<Vec<u8>, String> {
        let options = spv::Options {
            lang_version: (1, 3),
            // A check of a buffer's bounds asks for its length (OpArrayLength), which Godot 4.6's SPIR-V optimiser cannot
            // take: kernels keep within their buffers by themselves.
            bounds_check_policies: BoundsCheckPolicies {
                index: BoundsCheckPolicy::Restrict,
                buffer: BoundsCheckPolicy::Unchecked,
                image_load: BoundsCheckPolicy::Restrict,
                binding_array: BoundsCheckPolicy::Unchecked,
            },
            // All loops end: the documentation of `lumivox_shaders` says why.
            force_loop_bounding: false,
            // Kernels write what they read.
            zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
            ..Default::default()
        };
        let pipeline = spv::PipelineOptions { shader_stage, entry_point: MAIN.to_owned() };
        spv::write_vec(&self.module, &self.info, &options, Some(&pipeline))
            .map(|words| words.into_iter().flat_map(u32::to_le_bytes).collect())
            .map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// OpArrayLength.
    const ARRAY_LENGTH: u16 = 68;

    fn opcodes(binary: &[u8]) -> Vec<u16> {
        let word = |at: usize| u32::from_le_bytes(binary[4 * at..][..4].try_into().unwrap());
        let (mut at, mut found) = (5, vec![]);
        while 4 * at < binary.len() {
            found.push(word(at) as u16);
            at += (word(at) >> 16) as usize;
        }
        found
    }

    #[test]
    fn every_kernel_becomes_spirv() {
        const MAGIC: [u8; 4] = 0x0723_0203_u32.to_le_bytes();
        const VERSION: [u8; 4] = 0x0001_0300_u32.to_le_bytes();
        for kernel in Kernel::all() {
            let stages =
                match compile(kernel, &kernel.wgsl()).unwrap_or_else(|why| panic!("{kernel:?}: {why}")) {
                    Binary::Compute(one) => vec![one],
                    Binary::Draw(two) => two.into(),
                };
            for stage in stages {
                assert_eq!((&stage[..4], &stage[4..8]), (&MAGIC[..], &VERSION[..]), "{kernel:?}");
                assert!(!opcodes(&stage).contains(&ARRAY_LENGTH), "Godot's optimiser crashes on {kernel:?}");
            }
        }
    }
}
