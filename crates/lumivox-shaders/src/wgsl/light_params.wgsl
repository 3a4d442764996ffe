// What passes over the light that is kept need to know.

struct LightParams {
    // Blocks there is room for: a multiple of BUCKET.
    slots: u32,
    // Counts frames, from 1 on.
    frame: u32,
    // Points there is room for.
    points: u32,
    // Whose blocks `light_resolve` is for.
    tier: u32,
    // The part that is kept of what was learnt before this frame.
    kept: f32,
    // Points that what was learnt counts for at most, of diffuse light and of mirrored.
    most_points: f32,
    most_mirrored: f32,
    // Points after which a cell is trusted as much as what is known around it.
    trusted_points: f32,
    // Of points, the share that cells of the next tier are told of, and those of the one after that: not more.
    coarse_share: f32,
    coarsest_share: f32,
    // Whether light may be another than it was.
    is_changing: u32,
    // Whether there are volumes that are gone, see LIGHT_GONE.
    forgets: u32,
    // By what all that was learnt is multiplied, for the unit of light is another.
    scale: f32,
    padding_x: u32,
    padding_y: u32,
    padding_z: u32,
}

// Invocations in a row of dispatches over points and cells: there are more of them than workgroups along an axis.
const ROW: u32 = 32768u;

@group(0) @binding(0) var<uniform> params: LightParams;
