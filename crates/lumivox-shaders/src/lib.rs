//! The GPU code of Lumivox: WGSL modules, the kernels made of them, and their Rust twins.
//!
//! A kernel is its modules, joined in a fixed order after a preamble of constants that selects a variant; WGSL
//! does not mind the order of declarations, so that is all the linking there is (docs/adr/0002). Every host starts
//! from the text of [`Kernel::wgsl`]: wgpu takes it as it is, others turn it into SPIR-V, HLSL or MSL with naga.

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
    /// A 3D texture that a sampler filters.
    Texture3dFiltered,
    /// A 2D texture of floats that is only loaded from.
    Texture2dLoaded,
    /// A sampler: linear, clamped to the edge, normalised coordinates.
    LinearSampler,
}

/// What a path-tracing kernel is specialised for. What is off costs nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct PathTraceVariant {
    /// Next-event estimation with multiple importance sampling. A uniform environment needs none: sampling the phase
    /// function is already perfect.
    pub light_sampling: bool,
    /// Some volume reflects at surfaces.
    pub surface: bool,
    /// The film also holds first-hit albedo and normal.
    pub guides: bool,
    /// Some volume is filtered otherwise than trilinearly.
    pub mixed_filters: bool,
    /// Some light of the engine reaches some volume.
    pub lights: bool,
}

impl PathTraceVariant {
    /// Every combination.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..32u32).map(|bits| Self {
            light_sampling: bits & 1 != 0,
            surface: bits & 2 != 0,
            guides: bits & 4 != 0,
            mixed_filters: bits & 8 != 0,
            lights: bits & 16 != 0,
        })
    }
}

/// A compute kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// Adds samples to a film.
    PathTrace(PathTraceVariant),
    /// Value ranges and a transfer function to majorants.
    MajorantGrid,
    /// A film to displayable pixels.
    Display,
    /// Draws from the samplers, for tests.
    SampleDirections,
}

/// Candidates from which next-event estimation resamples one.
const LIGHT_CANDIDATES: u32 = 4;

macro_rules! module {
    ($name:literal) => {
        include_str!(concat!("wgsl/", $name, ".wgsl"))
    };
}

impl Kernel {
    /// Every kernel in every variant.
    pub fn all() -> impl Iterator<Item = Self> {
        [Kernel::MajorantGrid, Kernel::Display, Kernel::SampleDirections]
            .into_iter()
            .chain(PathTraceVariant::all().map(Kernel::PathTrace))
    }

    /// The name of the entry point.
    pub fn entry_point(self) -> &'static str {
        match self {
            Kernel::PathTrace(_) => "path_trace",
            Kernel::MajorantGrid => "majorant_grid",
            Kernel::Display => "display",
            Kernel::SampleDirections => "sample_directions",
        }
    }

    /// Invocations of a workgroup along x and y.
    pub fn workgroup_size(self) -> [u32; 2] {
        match self {
            Kernel::PathTrace(_) | Kernel::Display => [8, 8],
            Kernel::MajorantGrid | Kernel::SampleDirections => [64, 1],
        }
    }

    /// The bindings of group 0, in order.
    pub fn bindings(self) -> &'static [BindingKind] {
        use BindingKind::*;
        match self {
            Kernel::PathTrace(_) => &[
                Uniform,
                StorageRead,
                StorageRead,
                StorageRead,
                StorageRead,
                Texture3dFiltered,
                LinearSampler,
                Texture2dLoaded,
                StorageRead,
                StorageRead,
                StorageReadWrite,
            ],
            Kernel::MajorantGrid => &[Uniform, StorageRead, StorageRead, StorageReadWrite],
            Kernel::Display => &[Uniform, Uniform, StorageRead, Texture2dLoaded, StorageReadWrite],
            Kernel::SampleDirections => &[Uniform, Uniform, Texture2dLoaded, StorageRead, StorageReadWrite],
        }
    }

    /// The complete WGSL text.
    pub fn wgsl(self) -> String {
        let modules: &[&str] = match self {
            Kernel::PathTrace(_) => &[
                module!("frame"),
                module!("random"),
                module!("volume"),
                module!("tracking"),
                module!("environment"),
                module!("light_sampling"),
                module!("directions"),
                module!("scattering"),
                module!("lights"),
                module!("path_trace"),
            ],
            Kernel::MajorantGrid => &[module!("frame"), module!("majorant_grid")],
            Kernel::Display => {
                &[module!("frame"), module!("environment"), module!("tone_map"), module!("display")]
            }
            Kernel::SampleDirections => &[
                module!("frame"),
                module!("random"),
                module!("environment"),
                module!("light_sampling"),
                module!("directions"),
                module!("sample_directions"),
            ],
        };
        let mut text = String::new();
        if self == Kernel::SampleDirections {
            text += "const SURFACE: bool = true;\n";
        }
        if let Kernel::PathTrace(variant) = self {
            let [x, y] = self.workgroup_size();
            text += &format!(
                "const LIGHT_SAMPLING: bool = {};\nconst SURFACE: bool = {};\nconst GUIDES: bool = {};\n\
                 const MIXED_FILTERS: bool = {};\nconst WORKGROUP_X: u32 = {x}u;\nconst WORKGROUP_Y: u32 = {y}u;\n\
                 const LIGHT_CANDIDATES: u32 = {LIGHT_CANDIDATES}u;\nconst LIGHTS: bool = {};\n",
                variant.light_sampling,
                variant.surface,
                variant.guides,
                variant.mixed_filters,
                variant.lights
            );
        }
        for module in modules {
            text += module;
            text.push('\n');
        }
        text
    }
}
