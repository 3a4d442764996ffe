//! Rust twins of the WGSL structs, byte for byte; `tests/reflection.rs` compares them with what naga says.

use bytemuck::{Pod, Zeroable};

/// Entries of a transfer function's table.
pub const TABLE_SIZE: usize = crate::constants::TABLE_SIZE as usize;

/// Pairs of numbers of a transfer function on the GPU: opacities with their successors', then colours in two pairs each.
pub const TABLE_PAIRS: usize = crate::constants::TABLE_PAIRS as usize;

const _: () = assert!(TABLE_PAIRS == 3 * TABLE_SIZE);

/// Pools that a kernel can read.
pub const POOL_COUNT: usize = crate::constants::MAX_POOLS as usize;

// A number in `Frame`: the compiler of Rust 1.95 fails at closures that copy a struct whose array has a constant's size.
const _: () = assert!(POOL_COUNT == 4);

/// Levels of a range-maximum table over [`TABLE_SIZE`] entries.
pub const RANGE_MAXIMUM_LEVELS: usize = TABLE_SIZE.ilog2() as usize + 1;

/// Twin of `Frame`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in frame.wgsl")]
pub struct Frame {
    pub camera_position: [f32; 3],
    pub seed: u32,
    pub camera_right: [f32; 3],
    pub volume_count: u32,
    pub camera_up: [f32; 3],
    pub samples: u32,
    pub camera_forward: [f32; 3],
    pub sample_limit: u32,
    pub image_size: [u32; 2],
    pub film_origin: [u32; 2],
    pub film_size: [u32; 2],
    pub row_begin: u32,
    pub row_end: u32,
    pub environment_strength: f32,
    pub light_count: u32,
    pub environment_rotation: [f32; 2],
    pub environment_size: [u32; 2],
    pub importance_size: [u32; 2],
    pub roulette_start: u32,
    pub orthographic: u32,
    pub turn_limit: u32,
    pub lone_invocation: u32,
    pub view_axis: [f32; 3],
    pub group_stride: u32,
    pub ambient: [f32; 3],
    pub sharers: u32,
    pub only_below: u32,
    pub first_node: u32,
    pub first_light: u32,
    pub point_share: f32,
    pub pixel_size: f32,
    pub light_slots: u32,
    pub light_scale: f32,
    pub point_rays: u32,
    pub march_first: [u32; 2],
    pub march_stride: u32,
    pub padding: u32,
    pub inverse_pool_sizes: [[f32; 4]; 4],
}

/// Twin of `Child`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in frame.wgsl")]
pub struct Child {
    pub low: [f32; 3],
    pub index: u32,
    pub high: [f32; 3],
    pub padding: u32,
}

/// Twin of `Instance`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in frame.wgsl")]
pub struct Instance {
    pub voxel_from_world: [[f32; 4]; 3],
    pub patient_from_world: [[f32; 4]; 3],
    pub patient_gradient_from_voxel: [[f32; 4]; 3],
    pub clip_low: [f32; 3],
    pub density: f32,
    pub clip_high: [f32; 3],
    pub albedo: f32,
    pub bricks: [u32; 3],
    pub anisotropy: f32,
    pub dims: [f32; 3],
    pub max_bounces: u32,
    pub grid_dims: [u32; 3],
    pub grid_offset: u32,
    pub cell_size: f32,
    pub cells_per_voxel: f32,
    pub table_scale: f32,
    pub table_bias: f32,
    pub table_offset: u32,
    pub filter_kind: u32,
    pub value_per_texel: f32,
    pub world_millimetres: f32,
    pub surface_strength: f32,
    pub surface_inverse_gradient: f32,
    pub surface_lobe_anisotropy: f32,
    pub surface_specular: f32,
    pub layers: u32,
    pub cells_per_brick: u32,
    pub classes: u32,
    pub full_looks: u32,
    pub surface_metallic: f32,
    pub light_number: u32,
    pub takes_shares: u32,
    pub labels: u32,
}

/// Twin of `Light`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in lights.wgsl")]
pub struct Light {
    pub position: [f32; 3],
    pub kind: u32,
    pub color: [f32; 3],
    pub size: f32,
    pub axis: [f32; 3],
    pub layers: u32,
    pub inverse_range: f32,
    pub decay: f32,
    pub inverse_cone: f32,
    pub cone_attenuation: f32,
}

/// Twin of `ImportanceCell`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in environment_sampling.wgsl")]
pub struct ImportanceCell {
    pub threshold: f32,
    pub alias_index: u32,
    pub density: f32,
    pub alias_density: f32,
}

/// Twin of `ValueRangeParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in value_ranges.wgsl")]
pub struct ValueRangeParams {
    pub dims: [u32; 3],
    pub cell_size: u32,
    pub grid_dims: [u32; 3],
    pub reach: u32,
    pub bricks: [u32; 3],
    pub first_cell: u32,
    pub cell_count: u32,
    pub row_length: u32,
    pub split_pools: u32,
    pub padding: u32,
}

/// Twin of `MajorantParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in majorant_grid.wgsl")]
pub struct MajorantParams {
    pub cell_count: u32,
    pub majorant_offset: u32,
    pub row_length: u32,
    pub cells_per_brick: u32,
    pub style_count: u32,
    pub has_labels: u32,
    pub shape_count: u32,
    pub has_depth: u32,
    pub grid_dims: [u32; 3],
    pub cell_size: f32,
    pub bricks: [u32; 3],
    pub peel_mm: f32,
    pub dims: [f32; 3],
    pub peel_inverse_width: f32,
    pub depth_from_voxel: [[f32; 4]; 3],
    pub depth_grid_dims: [u32; 3],
    pub depth_cell_size: f32,
    pub depth_scale: f32,
    pub depth_bias: f32,
    pub shapes_of_rays: u32,
    pub padding: u32,
}

/// Twin of `EmptySpaceParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in empty_space.wgsl")]
pub struct EmptySpaceParams {
    pub cell_count: u32,
    pub majorant_offset: u32,
    pub row_length: u32,
    pub axis: u32,
    pub grid_dims: [u32; 3],
    pub padding: u32,
}

/// Twin of `DisplayParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in display.wgsl")]
pub struct DisplayParams {
    pub background: [f32; 3],
    pub background_kind: u32,
    pub exposure_scale: f32,
    pub tone_operator: u32,
    pub inverse_gamma: f32,
    pub padding: f32,
}

/// Twin of `FilmCountParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in film_count.wgsl")]
pub struct FilmCountParams {
    pub pixels: u32,
    pub invocations: u32,
    pub target_samples: u32,
    pub padding: u32,
}

/// Twin of `FilmCount`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in film_count.wgsl")]
pub struct FilmCount {
    pub samples: u32,
    pub short: u32,
    pub aside: u32,
    pub starved: u32,
    pub stuck: u32,
}

/// Twin of `FilmFadeParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in film_fade.wgsl")]
pub struct FilmFadeParams {
    pub film_size: [u32; 2],
    pub kept: f32,
    pub scale: f32,
    pub guides: u32,
    pub padding_x: u32,
    pub padding_y: u32,
    pub padding_z: u32,
}

/// Twin of `LightParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in light_params.wgsl")]
pub struct LightParams {
    pub slots: u32,
    pub frame: u32,
    pub points: u32,
    pub tier: u32,
    pub kept: f32,
    pub most_points: f32,
    pub most_mirrored: f32,
    pub trusted_points: f32,
    pub coarse_share: f32,
    pub coarsest_share: f32,
    pub is_changing: u32,
    pub forgets: u32,
    pub scale: f32,
    pub padding_x: u32,
    pub padding_y: u32,
    pub padding_z: u32,
}

/// Twin of `HostDepthParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in host_depth.wgsl")]
pub struct HostDepthParams {
    pub view_depth_from_ndc: [f32; 4],
    pub film_size: [u32; 2],
    pub clear: f32,
    pub jittered: u32,
    pub farthest: f32,
    pub guides: u32,
    pub padding_x: u32,
    pub padding_y: u32,
}

/// Twin of `LightSmoothParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in light_smooth.wgsl")]
pub struct LightSmoothParams {
    pub film_size: [u32; 2],
    pub first: [u32; 2],
    pub stride: u32,
    pub step: u32,
    pub flips: u32,
    pub is_last: u32,
    pub sure: f32,
    pub pixel_size: f32,
    pub camera_parallel: u32,
    pub padding: u32,
}

/// Twin of `LightFillParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in light_fill.wgsl")]
pub struct LightFillParams {
    pub before_from_now: [[f32; 4]; 4],
    pub film_size: [u32; 2],
    pub first: [u32; 2],
    pub stride: u32,
    pub has_before: u32,
    pub camera_parallel: u32,
    pub keeps: u32,
    pub light_scale: f32,
    pub padding_x: u32,
    pub padding_y: u32,
    pub padding_z: u32,
}

/// Twin of `DenoiseParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in denoise_prepare.wgsl")]
pub struct DenoiseParams {
    pub film_size: [u32; 2],
    pub step: u32,
    pub bounded: u32,
    pub kept_light: u32,
    pub padding_x: u32,
    pub padding_y: u32,
    pub padding_z: u32,
}

/// Twin of `CompositeParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in composite.wgsl")]
pub struct CompositeParams {
    pub width: u32,
    pub padding_x: u32,
    pub padding_y: u32,
    pub padding_z: u32,
}

/// Twin of `VelocityParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in composite_velocity.wgsl")]
pub struct VelocityParams {
    pub before_from_now: [[f32; 4]; 4],
    pub view_depth_from_ndc: [f32; 4],
    pub scale: [f32; 2],
    pub picture_size: [u32; 2],
    pub camera_parallel: u32,
    pub padding_x: u32,
    pub padding_y: u32,
    pub padding_z: u32,
}

/// Twin of `LivePictureParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in live_picture.wgsl")]
pub struct LivePictureParams {
    pub view_depth_from_ndc: [f32; 4],
    pub ndc_from_view_depth: [f32; 4],
    pub picture_size: [u32; 2],
    pub first_size: [u32; 2],
    pub second_size: [u32; 2],
    pub exposure: f32,
    pub clear: f32,
    pub has_host_depth: u32,
    pub denoised: u32,
    pub camera_parallel: u32,
    pub fog_kind: u32,
    pub fog_distance: [f32; 4],
    pub fog_color: [f32; 3],
    pub farthest: f32,
    pub camera_edges: [f32; 4],
    pub world_height: [f32; 4],
    pub fog_height: [f32; 2],
    pub coarse_alone: u32,
    pub kept_light: u32,
    pub film_is_shown: u32,
    pub padding_x: u32,
    pub padding_y: u32,
    pub padding_z: u32,
}

/// Twin of `SampleParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[expect(missing_docs, reason = "documented in sample_directions.wgsl")]
pub struct SampleParams {
    pub axis: [f32; 3],
    pub sampler: u32,
    pub anisotropy: f32,
    pub count: u32,
    pub padding: [u32; 2],
}
