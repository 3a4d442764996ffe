//! The table of kernels: a row says all that there is to say of one, but for the WGSL of its modules.

use crate::{
    BindingKind::{self, LinearSampler, StorageRead, StorageReadWrite, Texture2dLoaded, Texture3d, Uniform},
    Kernel, KernelKind, PathTraceVariant,
};

/// A kernel as data.
#[derive(Clone, Copy)]
pub(crate) struct Row {
    /// Of the fragment shader, where it is drawn.
    pub entry_point: &'static str,
    pub kind: KernelKind,
    /// Invocations of a workgroup along x and y; 1 where it is drawn.
    pub workgroup_size: [u32; 2],
    /// Of group 0, in order.
    pub bindings: &'static [BindingKind],
    /// What its text is made of, in order.
    pub modules: &'static [Module],
    /// Constants before the modules, besides those of all kernels and those of its variant.
    pub constants: &'static str,
}

/// A part of a kernel's text.
#[derive(Clone, Copy)]
pub(crate) enum Module {
    Always(&'static str),
    /// The first where the variant asks for it, else the second.
    Either(fn(&PathTraceVariant) -> bool, &'static str, &'static str),
}

macro_rules! text {
    ($name:literal) => {
        include_str!(concat!("wgsl/", $name, ".wgsl"))
    };
}

/// A list of modules: names of those that are always there, `flag ? this : that` or `flag ? this`, where `classified` is any of the classes.
macro_rules! modules {
    (@one $name:literal) => { Module::Always(text!($name)) };
    (@one classified ? $then:literal : $otherwise:literal) => {
        Module::Either(|variant| variant.classes.any(), text!($then), text!($otherwise))
    };
    (@one $flag:ident ? $then:literal : $otherwise:literal) => {
        Module::Either(|variant| variant.$flag, text!($then), text!($otherwise))
    };
    (@one $flag:ident ? $then:literal) => { Module::Either(|variant| variant.$flag, text!($then), "") };
    ($([$($part:tt)+]),* $(,)?) => { &[$(modules!(@one $($part)+)),*] };
}

/// The binding of the points that paths leave: behind what is put aside of them.
pub(crate) fn points_binding(variant: &PathTraceVariant) -> u32 {
    PATHS_BINDING + u32::from(variant.limited_turns)
}

/// Bindings, and behind them the pools: one, or as many as a kernel can read.
macro_rules! bindings_and_pools {
    ($one_pool:expr, $($kind:ident),*) => {
        if $one_pool {
            &[$($kind),*, Texture3d]
        } else {
            &[$($kind),*, Texture3d, Texture3d, Texture3d, Texture3d]
        }
    };
}

const TILE: [u32; 2] = [8, 8];
const LINE: [u32; 2] = [64, 1];

/// Where a path-tracing kernel's film is bound.
const FILM_BINDING: u32 = 6;

/// Where it puts paths aside: behind the film, before the pools.
pub(crate) const PATHS_BINDING: u32 = FILM_BINDING + 1;

/// What only computes, without further constants.
const fn compute(
    entry_point: &'static str,
    workgroup_size: [u32; 2],
    bindings: &'static [BindingKind],
    modules: &'static [Module],
) -> Row {
    Row { entry_point, kind: KernelKind::Compute, workgroup_size, bindings, modules, constants: "" }
}

/// What is drawn.
const fn draw(entry_point: &'static str, kind: KernelKind, modules: &'static [Module]) -> Row {
    let bindings = &[Uniform, StorageRead];
    Row { entry_point, kind, workgroup_size: [1, 1], bindings, modules, constants: "" }
}

/// A kernel's row.
pub(crate) fn row(kernel: Kernel) -> Row {
    match kernel {
        Kernel::PathTrace(variant) => {
            compute("path_trace", TILE, path_trace_bindings(variant), PATH_TRACE_MODULES)
        }
        Kernel::ValueRanges { one_pool } => compute(
            "value_ranges",
            LINE,
            bindings_and_pools!(one_pool, Uniform, StorageRead, StorageReadWrite),
            modules![["pools"], [one_pool ? "one_pool" : "many_pools"], ["split_texels"], ["value_ranges"]],
        ),
        Kernel::MajorantGrid => compute(
            "majorant_grid",
            LINE,
            &[
                Uniform,
                StorageRead,
                StorageRead,
                StorageRead,
                StorageRead,
                StorageRead,
                StorageRead,
                StorageReadWrite,
            ],
            modules![["pools"], ["cells"], ["majorant_grid"]],
        ),
        Kernel::EmptySpace => compute(
            "empty_space",
            LINE,
            &[Uniform, StorageReadWrite, StorageReadWrite],
            modules![["cells"], ["empty_space"]],
        ),
        Kernel::Display => compute(
            "display",
            TILE,
            &[Uniform, Uniform, StorageRead, Texture2dLoaded, StorageReadWrite],
            modules![["frame"], ["camera"], ["environment"], ["choose"], ["tone_map"], ["display"]],
        ),
        Kernel::HostDepth => compute(
            "host_depth",
            TILE,
            &[Uniform, Texture2dLoaded, StorageReadWrite, StorageReadWrite],
            modules![["depth_convention"], ["ray_limits"], ["host_depth"]],
        ),
        Kernel::DenoisePrepare => compute(
            "denoise_prepare",
            TILE,
            &[Uniform, StorageRead, StorageReadWrite, StorageRead],
            modules![["live_pixel"], ["luminance"], ["ray_limits"], ["denoise_prepare"]],
        ),
        Kernel::DenoiseWavelet => compute(
            "denoise_wavelet",
            TILE,
            &[Uniform, StorageRead, StorageReadWrite],
            modules![["live_pixel"], ["luminance"], ["likeness"], ["denoise_wavelet"]],
        ),
        Kernel::LivePicture => compute(
            "live_picture",
            TILE,
            &[
                Uniform,
                StorageRead,
                StorageRead,
                StorageRead,
                StorageRead,
                Texture2dLoaded,
                StorageReadWrite,
                StorageReadWrite,
            ],
            modules![
                ["depth_convention"],
                ["luminance"],
                ["likeness"],
                ["ray_limits"],
                ["fog"],
                ["live_picture"],
            ],
        ),
        Kernel::CompositeColor => {
            let modules = modules![["composite"], ["fullscreen"], ["composite_color"]];
            draw("composite_color", KernelKind::DrawColor, modules)
        }
        Kernel::CompositeDepth => {
            let modules = modules![["composite"], ["fullscreen"], ["composite_depth"]];
            draw("composite_depth", KernelKind::DrawDepth, modules)
        }
        Kernel::CompositeVelocity => {
            draw("composite_velocity", KernelKind::DrawOver, modules![["fullscreen"], ["composite_velocity"]])
        }
        Kernel::FilmCount => {
            compute("film_count", LINE, &[Uniform, StorageRead, StorageReadWrite], modules![["film_count"]])
        }
        Kernel::FilmFade => {
            compute("film_fade", TILE, &[Uniform, StorageReadWrite], modules![["ray_limits"], ["film_fade"]])
        }
        Kernel::LightBegin => compute(
            "light_begin",
            LINE,
            &[Uniform, StorageReadWrite],
            modules![["random"], ["light_cells"], ["light_params"], ["light_begin"]],
        ),
        Kernel::LightInsert => compute(
            "light_insert",
            LINE,
            &[Uniform, StorageReadWrite, StorageReadWrite],
            modules![["random"], ["light_cells"], ["light_params"], ["light_insert"]],
        ),
        Kernel::LightGather => compute(
            "light_gather",
            LINE,
            &[Uniform, StorageReadWrite, StorageRead],
            modules![["random"], ["light_cells"], ["light_params"], ["light_gather"]],
        ),
        Kernel::LightResolve => compute(
            "light_resolve",
            LINE,
            &[Uniform, StorageReadWrite],
            modules![
                ["random"],
                ["choose"],
                ["light_cells"],
                ["light_read"],
                ["light_params"],
                ["light_resolve"],
            ],
        ),
        Kernel::LightSmooth => compute(
            "light_smooth",
            TILE,
            &[Uniform, StorageReadWrite],
            modules![["random"], ["light_cells"], ["light_picture"], ["light_smooth"]],
        ),
        Kernel::LightFill => compute(
            "light_fill",
            TILE,
            &[Uniform, StorageRead, StorageReadWrite, StorageRead, StorageReadWrite],
            modules![
                ["random"],
                ["light_cells"],
                ["likeness"],
                ["ray_limits"],
                ["light_picture"],
                ["light_fill"]
            ],
        ),
        Kernel::LightMarch(variant) => {
            compute("light_march", TILE, light_march_bindings(variant), LIGHT_MARCH_MODULES)
        }
        Kernel::SampleDirections => Row {
            constants: "const SURFACE: bool = true;\n",
            ..compute(
                "sample_directions",
                LINE,
                &[Uniform, Uniform, Texture2dLoaded, StorageRead, StorageReadWrite],
                modules![
                    ["frame"],
                    ["random"],
                    ["tables"],
                    ["environment"],
                    ["environment_sampling"],
                    ["directions"],
                    ["sample_directions"],
                ],
            )
        },
    }
}

/// Scene and film; then what is put aside of paths, and the pools.
fn path_trace_bindings(variant: PathTraceVariant) -> &'static [BindingKind] {
    macro_rules! scene_and_film_and {
        ($($more:ident),*) => {
            bindings_and_pools!(
                variant.one_pool,
                Uniform,
                StorageRead,
                StorageRead,
                StorageRead,
                LinearSampler,
                Texture2dLoaded,
                StorageReadWrite
                $(, $more)*
            )
        };
    }
    match (variant.limited_turns, variant.points) {
        (false, false) => scene_and_film_and![],
        (true, true) => scene_and_film_and![StorageReadWrite, StorageReadWrite],
        _ => scene_and_film_and![StorageReadWrite],
    }
}

/// The scene without what lights it, the light that is kept of it, where rays end, and the picture; then the pools.
fn light_march_bindings(variant: PathTraceVariant) -> &'static [BindingKind] {
    bindings_and_pools!(
        variant.one_pool,
        Uniform,
        StorageRead,
        StorageRead,
        StorageRead,
        LinearSampler,
        StorageRead,
        StorageRead,
        StorageReadWrite
    )
}

const LIGHT_MARCH_MODULES: &[Module] = modules![
    ["frame"],
    ["choose"],
    ["camera"],
    ["ray_limits"],
    ["random"],
    ["cells"],
    [one_pool ? "one_pool" : "many_pools"],
    [one_pool ? "one_pool_filtered" : "many_pools_filtered"],
    [split_texels ? "split_texels" : "whole_texels"],
    ["volume"],
    ["tables"],
    ["medium"],
    [classified ? "classified_media" : "plain_media"],
    [many_volumes ? "volume_hierarchy" : "volume_list"],
    ["tracking"],
    ["directions"],
    ["events"],
    ["light_cells"],
    ["light_events"],
    ["light_read"],
    ["light_picture"],
    [several ? "light_collisions" : "light_steps"],
    ["light_march"],
];

const PATH_TRACE_MODULES: &[Module] = modules![
    ["frame"],
    ["choose"],
    ["luminance"],
    ["camera"],
    ["ray_limits"],
    [shared ? "shared_pixels" : "unshared_pixels"],
    [live ? "live_tracing" : "still_tracing"],
    [limited_turns ? "limited_turns" : "unlimited_turns"],
    ["random"],
    ["cells"],
    [one_pool ? "one_pool" : "many_pools"],
    [one_pool ? "one_pool_filtered" : "many_pools_filtered"],
    [split_texels ? "split_texels" : "whole_texels"],
    ["volume"],
    ["tables"],
    ["medium"],
    [classified ? "classified_media" : "plain_media"],
    [many_volumes ? "volume_hierarchy" : "volume_list"],
    ["tracking"],
    ["environment"],
    ["environment_sampling"],
    ["directions"],
    ["events"],
    ["scattering"],
    ["lights"],
    [points ? "light_cells"],
    [points ? "light_events"],
    [points ? "light_points" : "no_points"],
    ["path_trace"],
];
