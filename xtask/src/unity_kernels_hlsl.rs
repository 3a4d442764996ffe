//! A kernel as HLSL that Unity's compilers take and that its executor binds by name: naga's, with its registers taken out.
//!
//! Unity finds buffers and textures by the names of their variables, and says itself where they go. A uniform buffer is
//! bound as a whole, by the name of its block (`SetComputeConstantBufferParam`, `SetConstantBuffer`): what is in it is one
//! struct, as Rust's twin of it, and no member has to survive Unity's reflection. Samplers are Unity's own, chosen by name.

use std::collections::HashMap;

use lumivox_shaders::{BindingKind, Kernel};
use naga::back::hlsl;
use naga::valid::{Capabilities, ValidationFlags, Validator};

/// Unity makes the sampler that a name describes.
const LINEAR_SAMPLER: &str = "sampler_linear_clamp";

/// The number of the highest bit that is set. What Unity translates FXC's code with for Vulkan, Metal and OpenGL, HLSLcc,
/// takes `firstbithigh` for GLSL's `findMSB` in its public version, though FXC counts from the other end: cells of the
/// majorant grid came out wrong, and pictures empty. So the exponent of a float says it, exact for all numbers: without
/// the bit below its highest one, none is rounded up to the next power of two.
const HIGHEST_BIT: &str = "\
uint highest_bit(uint x)
{
    return x == 0u ? 0xffffffffu : (asuint(float(x & ~(x >> 1u))) >> 23u) - 127u;
}

";

/// How Unity binds something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A constant buffer, by the name of its block.
    Uniform,
    /// A raw buffer.
    Buffer,
    /// A texture.
    Texture,
}

/// A kernel in HLSL.
#[derive(Debug)]
pub struct Translated {
    /// Its text, without what Unity wants around it.
    pub text: String,
    /// What it binds, in the order of [`Kernel::bindings`]; samplers are left out.
    pub bindings: Vec<(Place, String)>,
}

/// # Errors
/// What naga says, should the kernel be beyond it; or what was looked for in vain in its HLSL.
pub fn translate(kernel: Kernel) -> Result<Translated, String> {
    let wgsl = kernel.wgsl();
    let module = naga::front::wgsl::parse_str(&wgsl).map_err(|error| error.emit_to_string(&wgsl))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::SHADER_FLOAT16_IN_FLOAT32)
        .validate(&module)
        .map_err(|error| error.emit_to_string(&wgsl))?;
    let options = hlsl::Options {
        shader_model: hlsl::ShaderModel::V5_0,
        // Registers are the numbers of the bindings.
        fake_missing_bindings: true,
        // All loops end: the documentation of `lumivox_shaders` says why.
        force_loop_bounding: false,
        // Places in arrays are computed from what bounds them, and buffers and textures have bounds of their own here.
        // With these, FXC takes three times as long.
        restrict_indexing: false,
        // Kernels write what they read.
        zero_initialize_workgroup_memory: false,
        ..Default::default()
    };
    let mut text = String::new();
    hlsl::Writer::new(&mut text, &options, &hlsl::PipelineOptions::default())
        .write(&module, &info, None)
        .map_err(|error| error.to_string())?;
    bind_by_name(&text, kernel.bindings())
}

/// Takes registers and naga's heap of samplers out of `text`, whose register numbers are those of `bindings`.
fn bind_by_name(text: &str, bindings: &[BindingKind]) -> Result<Translated, String> {
    let mut lines: Vec<String> = vec![];
    let mut names: HashMap<u32, (Place, String)> = HashMap::new();
    let mut sampler = None;
    for line in text.lines().map(str::trim_end) {
        if line.starts_with("SamplerState nagaSamplerHeap")
            || line.starts_with("SamplerComparisonState nagaComparisonSamplerHeap")
            || line.contains("SamplerIndexArray : register")
        {
            continue;
        }
        if let Some(rest) = line.strip_prefix("static const SamplerState ") {
            let name = first_word(rest);
            if sampler.replace(name.to_owned()).is_some() {
                return Err("more than one sampler".into());
            }
            lines.push(format!("SamplerState {LINEAR_SAMPLER};"));
            continue;
        }
        let Some((declared, register, rest)) = split_register(line) else {
            lines.push(line.to_owned());
            continue;
        };
        let name = declared.split_whitespace().next_back().ok_or_else(|| format!("no name: {line}"))?;
        let (place, name, line) = if declared.starts_with("cbuffer ") {
            // Block and struct have one name in naga's.
            let block = format!("{name}_buffer");
            (Place::Uniform, block.clone(), format!("cbuffer {block}{rest}"))
        } else if declared.starts_with("Texture") {
            (Place::Texture, name.to_owned(), format!("{declared}{rest}"))
        } else if declared.starts_with("ByteAddressBuffer ") || declared.starts_with("RWByteAddressBuffer ") {
            (Place::Buffer, name.to_owned(), format!("{declared}{rest}"))
        } else {
            return Err(format!("a binding of no known kind: {line}"));
        };
        if names.insert(register, (place, name)).is_some() {
            return Err(format!("two bindings of one number: {line}"));
        }
        lines.push(line);
    }
    // naga's quotient of vectors: a choice by many conditions, which DXC refuses.
    let mut text = lines.join("\n").replace("(rhs == 0u ? 1u : rhs)", "max(rhs, 1u)");
    text.push('\n');
    if let Some(sampler) = &sampler {
        text = replace_word(&text, sampler, LINEAR_SAMPLER);
    }
    if text.contains("asint(firstbithigh(") {
        return Err("the highest bit of a signed number, which highest_bit does not know".into());
    }
    if text.contains("firstbithigh") {
        text = HIGHEST_BIT.to_owned() + &replace_word(&text, "firstbithigh", "highest_bit");
    }

    let mut found = vec![];
    for (number, kind) in (0..).zip(bindings) {
        let place = match kind {
            BindingKind::Uniform => Place::Uniform,
            BindingKind::StorageRead | BindingKind::StorageReadWrite => Place::Buffer,
            BindingKind::Texture3d | BindingKind::Texture2dLoaded => Place::Texture,
            BindingKind::LinearSampler if sampler.is_some() => continue,
            BindingKind::LinearSampler => return Err(format!("binding {number}, a sampler, is not there")),
        };
        match names.remove(&number) {
            Some((p, name)) if p == place => found.push((place, name)),
            other => return Err(format!("binding {number} should be a {place:?}, and is {other:?}")),
        }
    }
    if names.is_empty() {
        Ok(Translated { text, bindings: found })
    } else {
        Err(format!("bindings that nobody has declared: {names:?}"))
    }
}

/// `what : register(x7)more` as what, 7 and more.
fn split_register(line: &str) -> Option<(&str, u32, &str)> {
    let (declared, rest) = line.split_once(" : register(")?;
    let (register, rest) = rest.split_once(')')?;
    let number = register.get(1..)?.split(',').next()?.parse().ok()?;
    Some((declared, number, rest))
}

fn first_word(text: &str) -> &str {
    text.split(|c: char| !is_of_word(c)).next().unwrap_or(text)
}

fn is_of_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// Where `word` stands alone, not where it is a part of another.
fn replace_word(text: &str, word: &str, by: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut copied = 0;
    for (at, _) in text.match_indices(word) {
        let (before, after) = (&text[..at], &text[at + word.len()..]);
        if !before.ends_with(is_of_word) && !after.starts_with(is_of_word) {
            out += &text[copied..at];
            out += by;
            copied = at + word.len();
        }
    }
    out + &text[copied..]
}

#[cfg(test)]
mod tests {
    use super::*;
    use lumivox_shaders::PathTraceVariant;

    #[test]
    fn what_is_bound_is_bound_by_name() {
        let translated = translate(Kernel::PathTrace(PathTraceVariant::default())).unwrap();
        let names: Vec<_> = translated.bindings.iter().map(|(place, name)| (*place, name.as_str())).collect();
        assert_eq!(
            names[..3],
            [(Place::Uniform, "frame_buffer"), (Place::Buffer, "instances"), (Place::Buffer, "tables")]
        );
        assert_eq!(names.iter().filter(|(place, _)| *place == Place::Texture).count(), 5);
        for (place, name) in names {
            let declaration = match place {
                Place::Uniform => format!("cbuffer {name} {{ "),
                Place::Buffer => format!("ByteAddressBuffer {name};"),
                Place::Texture => format!("<float4> {name};"),
            };
            assert!(translated.text.contains(&declaration), "no `{declaration}`");
        }
        assert!(!translated.text.contains("register("));
        assert!(!translated.text.contains("nagaSampler") && !translated.text.contains("linear_sampler"));
        assert_eq!(translated.text.matches("SamplerState sampler_linear_clamp;").count(), 1);
        assert!(translated.text.contains(".SampleLevel(sampler_linear_clamp, "));
    }

    #[test]
    fn what_is_not_as_declared_is_an_error() {
        let line = "ByteAddressBuffer film : register(t0);\n";
        assert!(bind_by_name(line, &[BindingKind::StorageRead]).is_ok());
        for bindings in
            [&[][..], &[BindingKind::Uniform], &[BindingKind::StorageRead, BindingKind::Texture3d]]
        {
            assert!(bind_by_name(line, bindings).is_err(), "{bindings:?}");
        }
        assert!(bind_by_name("", &[BindingKind::LinearSampler]).is_err());
    }

    #[test]
    fn no_kernel_asks_for_what_unitys_translator_gets_wrong() {
        let text = translate(Kernel::MajorantGrid).unwrap().text;
        assert!(!text.contains("firstbithigh"));
        assert_eq!(text.matches("uint highest_bit(uint x)").count(), 1);
        assert_eq!(text.matches("= highest_bit(").count(), 1);
        assert!(bind_by_name("x = asint(firstbithigh(y));\n", &[]).is_err());
    }

    #[test]
    fn the_exponent_of_a_float_is_the_highest_bit() {
        let highest = |x: u32| (((x & !(x >> 1)) as f32).to_bits() >> 23) - 127;
        let around = (0..32).flat_map(|bit| (-2..=2).map(move |by| (1_i64 << bit) + by));
        let spread = (0..100_000_u32).map(|i| i64::from(i.wrapping_mul(2_654_435_761)));
        for x in around.chain(spread).filter_map(|x| u32::try_from(x).ok()).filter(|&x| x > 0) {
            assert_eq!(highest(x), x.ilog2(), "{x}");
        }
        assert_eq!(highest(u32::MAX), 31);
    }

    #[test]
    fn words_are_not_replaced_within_others() {
        assert_eq!(replace_word("a, aa, a_1 (a)", "a", "bc"), "bc, aa, a_1 (bc)");
    }
}
