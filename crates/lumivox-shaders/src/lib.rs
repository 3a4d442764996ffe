//! The GPU code of Lumivox: WGSL modules, the kernels made of them, and their Rust twins.
//!
//! A kernel is its modules, joined in a fixed order after a preamble: the [`constants`] that Rust shares, and those that
//! select a variant. WGSL does not mind the order of declarations, so that is all the linking there is (docs/adr/0002).
//! Every host starts from the text of [`Kernel::wgsl`]: wgpu takes it as it is, others turn it into SPIR-V, HLSL or MSL
//! with naga.
//!
//! # Loops end
//! Executors let no compiler count the turns of loops, which costs 8 to 15%: kernels that are added keep to what follows.
//! - Loops over taps, neighbours, kinds of light, candidates, sharers, clip shapes, labels, cells of depths and rows of
//!   functions have a constant or a number of the host's as their bound, and step by one. `film_count` steps by its number of
//!   invocations, at least a workgroup; `value_ranges` visits a box of voxels.
//! - The walk through majorant cells (`march_to_tentative`) passes a face of the grid each turn. It ends before it
//!   could leave the grid, if its numbers are numbers: `march_begin` makes a walk empty that has others.
//! - Tentative collisions (`next_collision`, `transmittance`) move along the ray by more than its rounding.
//! - Marches through kept light (`light_steps`) pass a face of the grid each turn, too, and take 256 steps between two at most.
//!   Light is read in boxes of two blocks along an axis, and of two cells, from tier to tier (`light_read`).
//!   A slot of it is looked for in one bucket (`light_cells`), and taken by whoever exchanges its key: who fails has another's
//!   before them. Of a list of points so many are looked at.
//! - The search for volumes asks each of a list once, or goes down a tree that the host has built, each branch once.
//! - Every event of a path adds to its bounces, of which a medium allows a thousand at most; a path that is lost at no
//!   number meets no volume, and ends. A sample ends with its path, and the host says how many samples there are.

pub mod constants;
pub mod layout;
mod table;
mod variant;

use table::{Module, PATHS_BINDING, points_binding, row};
pub use variant::{Classes, PathTraceVariant};

/// What a binding of group 0 is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BindingKind {
    /// A uniform buffer.
    Uniform,
    /// A storage buffer that the kernel only reads.
    StorageRead,
    /// A storage buffer that the kernel reads and writes.
    StorageReadWrite,
    /// A 3D texture, loaded from or filtered by the sampler.
    Texture3d,
    /// A 2D texture of floats that is only loaded from.
    Texture2dLoaded,
    /// A sampler: linear, clamped to the edge, normalised coordinates.
    LinearSampler,
}

/// How a kernel runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum KernelKind {
    /// In workgroups.
    Compute,
    /// As the fragment shader of one triangle that covers a colour target, whose contents it is blended over with
    /// premultiplied alpha: `source + (1 - source alpha) * target`, alpha too. No depth test, no culling.
    DrawColor,
    /// The same, but that it takes the place of what was there.
    DrawOver,
    /// As the fragment shader of one triangle that covers a depth target: every fragment that is not discarded is
    /// written. No colour, no culling.
    DrawDepth,
}

/// A program for the GPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// Adds samples to a film.
    PathTrace(PathTraceVariant),
    /// Voxels to value ranges.
    ValueRanges {
        /// All voxels lie in one pool.
        one_pool: bool,
    },
    /// Value ranges and a transfer function to majorants.
    MajorantGrid,
    /// Majorants to distances through empty cells, along one axis.
    EmptySpace,
    /// A film to displayable pixels.
    Display,
    /// The host's depth buffer to the ends of primary rays.
    HostDepth,
    /// A live film to the denoiser's pixels.
    DenoisePrepare,
    /// One pass of the denoiser of live films.
    DenoiseWavelet,
    /// Live films to the picture that is drawn over the host's.
    LivePicture,
    /// The picture of a live view over the host's colour.
    CompositeColor,
    /// The depth of what a live view shows into the host's.
    CompositeDepth,
    /// How far what a live view shows has moved, into the host's velocity.
    CompositeVelocity,
    /// What a film really holds.
    FilmCount,
    /// What a live film keeps where light has changed a little.
    FilmFade,
    /// A frame's points for the light that is kept in volumes: room is made for them.
    LightBegin,
    /// They are sorted into the cells that they lie in.
    LightInsert,
    /// Cells learn of their points.
    LightGather,
    /// What cells of a tier have learnt to what is read of them.
    LightResolve,
    /// A picture from the light that is kept. Of the variant it heeds what media are, and whether there are several.
    LightMarch(PathTraceVariant),
    /// What of that picture is known of few points is smoothed, where its surfaces are.
    LightSmooth,
    /// The pixels of that picture between those whose rays were marched.
    LightFill,
    /// Draws from the samplers, for tests.
    #[doc(hidden)]
    SampleDirections,
}

impl Kernel {
    /// Every kernel in every variant.
    pub fn all() -> impl Iterator<Item = Self> {
        [
            Kernel::ValueRanges { one_pool: false },
            Kernel::ValueRanges { one_pool: true },
            Kernel::MajorantGrid,
            Kernel::EmptySpace,
            Kernel::Display,
            Kernel::HostDepth,
            Kernel::DenoisePrepare,
            Kernel::DenoiseWavelet,
            Kernel::LivePicture,
            Kernel::CompositeColor,
            Kernel::CompositeDepth,
            Kernel::CompositeVelocity,
            Kernel::FilmCount,
            Kernel::FilmFade,
            Kernel::LightBegin,
            Kernel::LightInsert,
            Kernel::LightGather,
            Kernel::LightResolve,
            Kernel::LightSmooth,
            Kernel::LightFill,
            Kernel::SampleDirections,
        ]
        .into_iter()
        .chain(PathTraceVariant::all().map(Kernel::PathTrace))
        .chain([false, true].into_iter().flat_map(|several| {
            let of_picture = PathTraceVariant::all().map(move |v| PathTraceVariant { several, ..v });
            of_picture.filter(move |v| *v == v.of_picture(several)).map(Kernel::LightMarch)
        }))
    }

    /// The vertex shader of what is drawn: three vertices, no buffer.
    pub const VERTEX_ENTRY_POINT: &str = "fullscreen";

    /// How it runs.
    pub fn kind(self) -> KernelKind {
        row(self).kind
    }

    /// The name of the entry point; of the fragment shader where it is drawn.
    pub fn entry_point(self) -> &'static str {
        row(self).entry_point
    }

    /// A name of its own for each kernel in each variant, fit for a file's: `path_trace_live_environment_many_shared`.
    pub fn name(self) -> String {
        let parts = match self {
            Kernel::PathTrace(variant) | Kernel::LightMarch(variant) => variant.names(),
            Kernel::ValueRanges { one_pool: true } => vec!["pool"],
            _ => vec![],
        };
        std::iter::once(self.entry_point()).chain(parts).collect::<Vec<_>>().join("_")
    }

    /// Invocations of a workgroup along x and y; 1 where it is drawn.
    pub fn workgroup_size(self) -> [u32; 2] {
        row(self).workgroup_size
    }

    /// The bindings of group 0, in order.
    pub fn bindings(self) -> &'static [BindingKind] {
        row(self).bindings
    }

    /// The complete WGSL text, with storage buffers in the place of uniform ones: for lavapipe, Mesa's Vulkan in software.
    ///
    /// It compiles a kernel anew for the values that branches find in uniform buffers: as of Mesa 22.3 with every dispatch,
    /// which takes milliseconds, and the code of each, most of a megabyte, is kept for good.
    pub fn wgsl_without_uniforms(self) -> String {
        self.wgsl().replace("var<uniform>", "var<storage, read>")
    }

    /// Storage buffers that it binds, uniform ones included.
    pub fn buffers(self) -> usize {
        use BindingKind::{StorageRead, StorageReadWrite, Uniform};
        self.bindings().iter().filter(|kind| matches!(kind, Uniform | StorageRead | StorageReadWrite)).count()
    }

    /// The complete WGSL text.
    pub fn wgsl(self) -> String {
        let row = row(self);
        let variant = match self {
            Kernel::PathTrace(variant) | Kernel::LightMarch(variant) => variant,
            Kernel::ValueRanges { one_pool } => PathTraceVariant { one_pool, ..Default::default() },
            _ => PathTraceVariant::default(),
        };
        let mut text = constants::wgsl() + row.constants;
        if let Kernel::PathTrace(_) | Kernel::LightMarch(_) = self {
            let [x, y] = row.workgroup_size;
            let points = points_binding(&variant);
            text += &variant.constants();
            text += &format!(
                "const WORKGROUP_X: u32 = {x}u;\nconst WORKGROUP_Y: u32 = {y}u;\nconst PATHS_BINDING: u32 = {PATHS_BINDING}u;\n\
                 const POINTS_BINDING: u32 = {points}u;\n"
            );
        }
        let pools = row.bindings.iter().position(|kind| *kind == BindingKind::Texture3d);
        if let Some(first) = pools {
            text += &format!("const POOL_BINDING: u32 = {first}u;\n");
        }
        for module in row.modules {
            text += match *module {
                Module::Always(module) => module,
                Module::Either(is_on, then, otherwise) => {
                    if is_on(&variant) {
                        then
                    } else {
                        otherwise
                    }
                }
            };
            text.push('\n');
        }
        text
    }
}

/// WGSL for hosts that show scene-linear light by a shader of their own: `tone_map(color: vec3f, curve: u32, inverse_gamma: f32)`
/// gives display values in [0, 1], as [`Kernel::Display`] does, with the curves `TONE_PLAIN`, `TONE_AGX` and `TONE_ACES`;
/// `srgb_encode` is the sRGB transfer function.
pub fn tone_map_wgsl() -> String {
    constants::wgsl() + include_str!("wgsl/choose.wgsl") + "\n" + include_str!("wgsl/tone_map.wgsl")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_kernel_has_a_name_of_its_own_that_files_can_have() {
        let mut names = HashSet::new();
        for kernel in Kernel::all() {
            let name = kernel.name();
            assert!(name.bytes().all(|b| b.is_ascii_lowercase() || b == b'_'), "{name}");
            assert!(name.starts_with(kernel.entry_point()), "{name}");
            assert!(names.insert(name.clone()), "two kernels are called {name}");
        }
        let variant = PathTraceVariant {
            live: true,
            environment_sampling: true,
            many_volumes: true,
            shared: true,
            ..Default::default()
        };
        assert_eq!(Kernel::PathTrace(variant).name(), "path_trace_live_environment_many_shared");
    }
}

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
