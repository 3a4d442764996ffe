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
//!   functions have a constant or a number of the host's as their bound, and step by one. `film_count` steps by its number of invocations, at least a workgroup; `value_ranges` visits
//!   a box of voxels.
//! - The walk through majorant cells (`march_to_tentative`) passes a face of the grid each turn. It ends before it
//!   could leave the grid, if its numbers are numbers: `march_begin` makes a walk empty that has others.
//! - Tentative collisions (`next_collision`, `transmittance`) move along the ray by more than its rounding.
//! - The search for volumes asks each of a list once, or goes down a tree that the host has built, each branch once.
//! - Every event of a path adds to its bounces, of which a medium allows a thousand at most; a path that is lost at no
//!   number meets no volume, and ends. A sample ends with its path, and the host says how many samples there are.

pub mod constants;
pub mod layout;

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

/// What media may depend on besides values. Each costs a kernel registers, whether a point asks for it or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Classes {
    /// Labels with looks of their own.
    pub labels: bool,
    /// Several transfer functions of a volume: labels' own, or rows by gradients.
    pub functions: bool,
    /// The gradient's magnitude. Comes with several functions.
    pub gradients: bool,
    /// Depth below the skin, by which is peeled.
    pub depth: bool,
    /// Shapes that clip.
    pub clip_shapes: bool,
}

impl Classes {
    /// Nothing.
    pub const NONE: Self =
        Self { labels: false, functions: false, gradients: false, depth: false, clip_shapes: false };

    /// All of it.
    pub const ALL: Self =
        Self { labels: true, functions: true, gradients: true, depth: true, clip_shapes: true };

    /// Every set of them that there is.
    pub fn sets() -> impl Iterator<Item = Self> {
        let all = (0..32u32).map(|bits| Self {
            labels: bits & 1 != 0,
            functions: bits & 2 != 0,
            gradients: bits & 4 != 0,
            depth: bits & 8 != 0,
            clip_shapes: bits & 16 != 0,
        });
        all.filter(|classes| {
            let has_several = classes.labels || classes.gradients;
            if classes.functions { has_several } else { !classes.gradients }
        })
    }

    /// Whether it is anything.
    pub fn any(self) -> bool {
        self != Self::NONE
    }

    /// What either holds.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            labels: self.labels | other.labels,
            functions: self.functions | other.functions,
            gradients: self.gradients | other.gradients,
            depth: self.depth | other.depth,
            clip_shapes: self.clip_shapes | other.clip_shapes,
        }
    }
}

/// What a path-tracing kernel is specialised for. What is off costs nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct PathTraceVariant {
    /// Next-event estimation with multiple importance sampling. A uniform environment needs none: sampling the phase
    /// function is already perfect.
    pub environment_sampling: bool,
    /// Some volume reflects at surfaces.
    pub surface: bool,
    /// The film also holds first-hit albedo and normal.
    pub guides: bool,
    /// Some volume is filtered otherwise than linearly.
    pub mixed_filters: bool,
    /// Into a host's image: primary rays end at what the host has drawn, and every pixel counts its own samples.
    pub live: bool,
    /// Some light of the engine reaches some volume.
    pub lights: bool,
    /// There are so many volumes that rays look for them in a hierarchy.
    pub many_volumes: bool,
    /// The medium of some volume depends on more than its values: on these.
    pub classes: Classes,
    /// All voxels lie in one pool.
    pub one_pool: bool,
    /// The driver ends invocations after so many turns of their loops: paths are put aside in time, and taken up by the
    /// next dispatch.
    pub limited_turns: bool,
    /// Several invocations may share the samples of a pixel, as many as each dispatch says. Not with guides, nor where paths
    /// are put aside: those belong to a pixel.
    pub shared: bool,
}

impl PathTraceVariant {
    /// Every combination that there is. But of classes: some of them come with nothing else and with everything else alone.
    pub fn all() -> impl Iterator<Item = Self> {
        let all = Classes::sets().flat_map(|classes| {
            let is_whole = !classes.any() || classes == Classes::ALL;
            (0..1024u32).filter(move |bits| is_whole || [0, 1023 & !4 & !256].contains(bits)).map(
                move |bits| Self {
                    environment_sampling: bits & 1 != 0,
                    surface: bits & 2 != 0,
                    guides: bits & 4 != 0,
                    mixed_filters: bits & 8 != 0,
                    live: bits & 16 != 0,
                    lights: bits & 32 != 0,
                    many_volumes: bits & 64 != 0,
                    one_pool: bits & 128 != 0,
                    limited_turns: bits & 256 != 0,
                    shared: bits & 512 != 0,
                    classes,
                },
            )
        });
        all.filter(|variant| !variant.shared || variant.most_sharers() > 1)
    }

    /// The kernel where so many invocations share a pixel: one of its own, or the same.
    pub fn for_sharers(self, sharers: u32) -> Self {
        Self { shared: self.shared || sharers > 1, ..self }
    }

    /// Invocations that may share a pixel where the kernel is the one for that; 1 where there is no such kernel.
    pub fn most_sharers(self) -> u32 {
        let [in_a_row, _] = Kernel::PathTrace(self).workgroup_size();
        if self.guides || self.limited_turns { 1 } else { in_a_row }
    }
}

/// How a kernel runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// In workgroups.
    Compute,
    /// As the fragment shader of one triangle that covers a colour target, whose contents it is blended over with
    /// premultiplied alpha: `source + (1 - source alpha) * target`, alpha too. No depth test, no culling.
    DrawColor,
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
    /// What a film really holds.
    FilmCount,
    /// What a live film keeps where light has changed a little.
    FilmFade,
    /// Draws from the samplers, for tests.
    #[doc(hidden)]
    SampleDirections,
}

/// Where a path-tracing kernel's film is bound.
const FILM_BINDING: u32 = 9;

macro_rules! module {
    ($name:literal) => {
        include_str!(concat!("wgsl/", $name, ".wgsl"))
    };
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
            Kernel::FilmCount,
            Kernel::FilmFade,
            Kernel::SampleDirections,
        ]
        .into_iter()
        .chain(PathTraceVariant::all().map(Kernel::PathTrace))
    }

    /// The vertex shader of what is drawn: three vertices, no buffer.
    pub const VERTEX_ENTRY_POINT: &str = "fullscreen";

    /// How it runs.
    pub fn stage(self) -> Stage {
        match self {
            Kernel::CompositeColor => Stage::DrawColor,
            Kernel::CompositeDepth => Stage::DrawDepth,
            _ => Stage::Compute,
        }
    }

    /// The name of the entry point; of the fragment shader where it is drawn.
    pub fn entry_point(self) -> &'static str {
        match self {
            Kernel::PathTrace(_) => "path_trace",
            Kernel::ValueRanges { .. } => "value_ranges",
            Kernel::MajorantGrid => "majorant_grid",
            Kernel::EmptySpace => "empty_space",
            Kernel::Display => "display",
            Kernel::HostDepth => "host_depth",
            Kernel::DenoisePrepare => "denoise_prepare",
            Kernel::DenoiseWavelet => "denoise_wavelet",
            Kernel::LivePicture => "live_picture",
            Kernel::CompositeColor => "composite_color",
            Kernel::CompositeDepth => "composite_depth",
            Kernel::FilmCount => "film_count",
            Kernel::FilmFade => "film_fade",
            Kernel::SampleDirections => "sample_directions",
        }
    }

    /// A name of its own for each kernel in each variant, fit for a file's: `path_trace_live_environment_many_shared`.
    pub fn name(self) -> String {
        let mut name = self.entry_point().to_owned();
        let mut add = |is_on: bool, part: &str| {
            if is_on {
                name.push('_');
                name += part;
            }
        };
        match self {
            Kernel::PathTrace(variant) => {
                add(variant.live, "live");
                add(variant.guides, "guides");
                add(variant.environment_sampling, "environment");
                add(variant.surface, "surface");
                add(variant.lights, "lights");
                add(variant.mixed_filters, "filters");
                add(variant.many_volumes, "many");
                add(variant.classes == Classes::ALL, "classes");
                if variant.classes != Classes::ALL {
                    add(variant.classes.labels, "labels");
                    add(variant.classes.functions, "functions");
                    add(variant.classes.gradients, "gradients");
                    add(variant.classes.depth, "depth");
                    add(variant.classes.clip_shapes, "clips");
                }
                add(variant.one_pool, "pool");
                add(variant.limited_turns, "turns");
                add(variant.shared, "shared");
            }
            Kernel::ValueRanges { one_pool } => add(one_pool, "pool"),
            _ => {}
        }
        name
    }

    /// Invocations of a workgroup along x and y; 1 where it is drawn.
    pub fn workgroup_size(self) -> [u32; 2] {
        match self {
            Kernel::PathTrace(_)
            | Kernel::Display
            | Kernel::HostDepth
            | Kernel::DenoisePrepare
            | Kernel::DenoiseWavelet
            | Kernel::FilmFade
            | Kernel::LivePicture => [8, 8],
            Kernel::CompositeColor | Kernel::CompositeDepth => [1, 1],
            Kernel::ValueRanges { .. }
            | Kernel::MajorantGrid
            | Kernel::EmptySpace
            | Kernel::FilmCount
            | Kernel::SampleDirections => [64, 1],
        }
    }

    /// The bindings of group 0, in order.
    pub fn bindings(self) -> &'static [BindingKind] {
        use BindingKind::*;
        macro_rules! bindings_and_pools {
            ($one_pool:expr, $($kind:ident),*) => {
                if $one_pool {
                    &[$($kind),*, Texture3d]
                } else {
                    const ALL: &[BindingKind] = &[
                        $($kind),*,
                        Texture3d,
                        Texture3d,
                        Texture3d,
                        Texture3d,
                    ];
                    ALL
                }
            };
        }
        match self {
            Kernel::PathTrace(variant) => {
                // Scene and film; then what is put aside of paths, and the pools.
                macro_rules! scene_and_film_and {
                    ($($more:ident),*) => {
                        bindings_and_pools!(
                            variant.one_pool,
                            Uniform,
                            StorageRead,
                            StorageRead,
                            StorageRead,
                            StorageRead,
                            LinearSampler,
                            Texture2dLoaded,
                            StorageRead,
                            StorageRead,
                            StorageReadWrite
                            $(, $more)*
                        )
                    };
                }
                if variant.limited_turns {
                    scene_and_film_and![StorageReadWrite]
                } else {
                    scene_and_film_and![]
                }
            }
            Kernel::ValueRanges { one_pool } => {
                bindings_and_pools!(one_pool, Uniform, StorageRead, StorageReadWrite)
            }
            Kernel::MajorantGrid => &[
                Uniform,
                StorageRead,
                StorageRead,
                StorageRead,
                StorageRead,
                StorageRead,
                StorageRead,
                StorageReadWrite,
            ],
            Kernel::EmptySpace => &[Uniform, StorageReadWrite, StorageReadWrite],
            Kernel::Display => &[Uniform, Uniform, StorageRead, Texture2dLoaded, StorageReadWrite],
            Kernel::HostDepth => &[Uniform, Texture2dLoaded, StorageReadWrite, StorageReadWrite],
            Kernel::LivePicture => &[
                Uniform,
                StorageRead,
                StorageRead,
                StorageRead,
                StorageRead,
                Texture2dLoaded,
                StorageReadWrite,
                StorageReadWrite,
            ],
            Kernel::CompositeColor | Kernel::CompositeDepth => &[Uniform, StorageRead],
            Kernel::DenoisePrepare => &[Uniform, StorageRead, StorageReadWrite],
            Kernel::DenoiseWavelet => &[Uniform, StorageRead, StorageReadWrite],
            Kernel::FilmCount => &[Uniform, StorageRead, StorageReadWrite],
            Kernel::FilmFade => &[Uniform, StorageReadWrite],
            Kernel::SampleDirections => &[Uniform, Uniform, Texture2dLoaded, StorageRead, StorageReadWrite],
        }
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
        let modules: &[&str] = match self {
            Kernel::PathTrace(variant) => &[
                module!("frame"),
                module!("choose"),
                module!("luminance"),
                module!("camera"),
                module!("ray_limits"),
                if variant.shared { module!("shared_pixels") } else { module!("unshared_pixels") },
                if variant.live { module!("live_tracing") } else { module!("still_tracing") },
                if variant.limited_turns { module!("limited_turns") } else { module!("unlimited_turns") },
                module!("random"),
                module!("cells"),
                if variant.one_pool { module!("one_pool") } else { module!("many_pools") },
                if variant.one_pool { module!("one_pool_filtered") } else { module!("many_pools_filtered") },
                module!("volume"),
                module!("medium"),
                if variant.classes.any() { module!("classified_media") } else { module!("plain_media") },
                if variant.many_volumes { module!("volume_hierarchy") } else { module!("volume_list") },
                module!("tracking"),
                module!("environment"),
                module!("environment_sampling"),
                module!("directions"),
                module!("scattering"),
                module!("lights"),
                module!("path_trace"),
            ],
            Kernel::ValueRanges { one_pool } => &[
                module!("pools"),
                if one_pool { module!("one_pool") } else { module!("many_pools") },
                module!("value_ranges"),
            ],
            Kernel::MajorantGrid => &[module!("pools"), module!("cells"), module!("majorant_grid")],
            Kernel::EmptySpace => &[module!("cells"), module!("empty_space")],
            Kernel::Display => &[
                module!("frame"),
                module!("camera"),
                module!("environment"),
                module!("choose"),
                module!("tone_map"),
                module!("display"),
            ],
            Kernel::HostDepth => &[module!("depth_convention"), module!("ray_limits"), module!("host_depth")],
            Kernel::LivePicture => &[
                module!("depth_convention"),
                module!("luminance"),
                module!("likeness"),
                module!("ray_limits"),
                module!("fog"),
                module!("live_picture"),
            ],
            Kernel::CompositeColor => &[module!("composite"), module!("composite_color")],
            Kernel::CompositeDepth => &[module!("composite"), module!("composite_depth")],
            Kernel::DenoisePrepare => &[
                module!("live_pixel"),
                module!("luminance"),
                module!("ray_limits"),
                module!("denoise_prepare"),
            ],
            Kernel::DenoiseWavelet => &[
                module!("live_pixel"),
                module!("luminance"),
                module!("likeness"),
                module!("denoise_wavelet"),
            ],
            Kernel::FilmCount => &[module!("film_count")],
            Kernel::FilmFade => &[module!("film_fade")],
            Kernel::SampleDirections => &[
                module!("frame"),
                module!("random"),
                module!("environment"),
                module!("environment_sampling"),
                module!("directions"),
                module!("sample_directions"),
            ],
        };
        let mut text = constants::wgsl();
        if self == Kernel::SampleDirections {
            text += "const SURFACE: bool = true;\n";
        }
        if let Kernel::PathTrace(variant) = self {
            let [x, y] = self.workgroup_size();
            // Behind the film, before the pools.
            let paths = FILM_BINDING + 1;
            text += &format!(
                "const ENVIRONMENT_SAMPLING: bool = {};\nconst SURFACE: bool = {};\nconst GUIDES: bool = {};\n\
                 const MIXED_FILTERS: bool = {};\nconst LIVE: bool = {};\nconst LIGHTS: bool = {};\n\
                 const CLASSES: bool = {};\nconst LABELS: bool = {};\nconst FUNCTIONS: bool = {};\nconst GRADIENTS: bool = {};\n\
                 const PEELING: bool = {};\nconst CLIP_SHAPES: bool = {};\n\
                 const WORKGROUP_X: u32 = {x}u;\nconst WORKGROUP_Y: u32 = {y}u;\n\
                 const PATHS_BINDING: u32 = {paths}u;\n",
                variant.environment_sampling,
                variant.surface,
                variant.guides,
                variant.mixed_filters,
                variant.live,
                variant.lights,
                variant.classes.any(),
                variant.classes.labels,
                variant.classes.functions,
                variant.classes.gradients,
                variant.classes.depth,
                variant.classes.clip_shapes,
            );
        }
        let pools = self.bindings().iter().position(|kind| *kind == BindingKind::Texture3d);
        if let Some(first) = pools {
            text += &format!("const POOL_BINDING: u32 = {first}u;\n");
        }
        for module in modules {
            text += module;
            text.push('\n');
        }
        text
    }
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
