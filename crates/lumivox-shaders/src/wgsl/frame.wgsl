// What one dispatch needs to know, and where a volume lies. Twins of `layout.rs`, checked by reflection.
//
// Spaces: `world` is the scene's, in metres. `voxel` is continuous: a volume of `dims` voxels fills [0, dims], voxel
// i's centre lies at i + 0.5. A ray keeps one parameter t in all spaces: positions are origin + t * direction, with
// the direction of unit length in the world only.

struct Frame {
    // The camera's image plane: with x and y in [-1, 1], right * x + up * y + forward is a pixel's direction in a
    // perspective, and right * x + up * y moves its origin in an orthographic view, where forward is the direction.
    camera_position: vec3f,
    seed: u32,
    camera_right: vec3f,
    volume_count: u32,
    camera_up: vec3f,
    // More samples for each pixel of this dispatch, and what a pixel has at most.
    samples: u32,
    camera_forward: vec3f,
    sample_limit: u32,
    // The whole image, and the window of it that the film holds, in pixels.
    image_size: vec2u,
    film_origin: vec2u,
    film_size: vec2u,
    // The film's rows of this dispatch.
    row_begin: u32,
    row_end: u32,
    environment_strength: f32,
    light_count: u32,
    // Cosine and sine of the environment's rotation.
    environment_rotation: vec2f,
    environment_size: vec2u,
    // Cells of the environment's importance grid.
    importance_size: vec2u,
    // Bounces before Russian roulette may end a path.
    roulette_start: u32,
    orthographic: u32,
    // Where drivers count: turns of its loops that an invocation may take, and which of those that run TOGETHER works
    // while the others rest, or NONE_IS_ALONE.
    turn_limit: u32,
    lone_invocation: u32,
    // Unit vector along which view depth is measured.
    view_axis: vec3f,
    // Live films: groups of a workgroup's rows are traced in strides, so that every band of them costs about the same.
    group_stride: u32,
    // Radiance from everywhere besides the environment's map.
    ambient: vec3f,
    // Invocations that share the samples of a pixel: see `shared_pixels.wgsl`.
    sharers: u32,
    // Live films: only pixels that have fewer samples get any; 0 for all of them.
    only_below: u32,
    // Where nodes and lights begin in the buffer of tables, in pairs.
    first_node: u32,
    first_light: u32,
    // Of paths that leave points for the light that is kept, the share that does.
    point_share: f32,
    // What a pixel of the picture sees at depth 1, or at any depth of an orthographic view, in metres.
    pixel_size: f32,
    // Blocks there is room for in the light that is kept, and what light is multiplied by there.
    light_slots: u32,
    light_scale: f32,
    // Shadow rays of each kind at a point's collision.
    point_rays: u32,
    // Where rays are marched through the light that is kept: from the first pixel of the film on, and so many pixels apart.
    march_first: vec2u,
    march_stride: u32,
    padding: u32,
    // One over the texels of each pool along each axis; w is the weight of the second channel of its texels.
    inverse_pool_sizes: array<vec4f, MAX_POOLS>,
}

// One half of the volumes below a node, and a box around them in the world. A node of the hierarchy over all volumes is
// two of these; there is one node fewer than volumes, and node 0 is the root.
struct Child {
    low: vec3f,
    // Of the node that parts them further or, with IS_VOLUME, of the only one.
    index: u32,
    high: vec3f,
    padding: u32,
}

struct Instance {
    // Rows of the affine map to voxel space.
    voxel_from_world: array<vec4f, 3>,
    // Rows of the linear map of directions to patient millimetres; w is unused.
    patient_from_world: array<vec4f, 3>,
    // Rows of the map of a voxel-space gradient to one per patient millimetre; w is unused.
    patient_gradient_from_voxel: array<vec4f, 3>,
    // What is kept of the volume, in voxels.
    clip_low: vec3f,
    // Extinction per millimetre at opacity 1.
    density: f32,
    clip_high: vec3f,
    albedo: f32,
    // Bricks along each axis.
    bricks: vec3u,
    anisotropy: f32,
    dims: vec3f,
    max_bounces: u32,
    // Cells of the majorant grid, and its first cell in the buffer of grids. The first of them begins one cell before the
    // first voxel's centre.
    grid_dims: vec3u,
    grid_offset: u32,
    // Voxels along a side of a majorant cell, and its inverse.
    cell_size: f32,
    cells_per_voxel: f32,
    // Transfer function table coordinate of a texel: texel * table_scale + table_bias, in [0, TABLE_SIZE - 1].
    table_scale: f32,
    table_bias: f32,
    // The first pair of its transfer function in the buffer of tables; of the largest opacities of all its functions where
    // there are several.
    table_offset: u32,
    // 0 nearest, 1 trilinear, 2 tricubic.
    filter_kind: u32,
    // Physical value units per texel unit.
    value_per_texel: f32,
    // Millimetres per world unit, or 0 where the volume's own millimetres count.
    world_millimetres: f32,
    surface_strength: f32,
    // One over the gradient, in value units per mm, of a full surface.
    surface_inverse_gradient: f32,
    surface_lobe_anisotropy: f32,
    surface_specular: f32,
    // A light reaches the volume if its mask shares a bit.
    layers: u32,
    // Cells along a side of a brick.
    cells_per_brick: u32,
    // Where its classification begins in the buffer of tables: see `classified_media.wgsl`.
    classes: u32,
    // Of the looks that cells can name, the first so many leave the opacity as it is.
    full_looks: u32,
    // How much of the medium's colour a mirroring surface has.
    surface_metallic: f32,
    // By which the light that is kept in it knows it.
    light_number: u32,
    // Whether some of its points have a share of their value's opacity alone: by labels, peeling or clip shapes.
    takes_shares: u32,
    // The instance that is its field of labels, with LABELS_LIE_ON_VOXELS where that has the same voxels, or NO_VOLUME.
    labels: u32,
}

const NO_VOLUME: u32 = 0xffffffffu;
const PI: f32 = 3.14159265358979;
