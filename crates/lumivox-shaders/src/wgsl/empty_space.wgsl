// How far it is from every empty cell of a volume to the nearest that is not, so that rays walk through empty space in long
// steps: the distance transform by the maximum norm, one axis after the other (as Rosenfeld and Pfaltz, "Distance Functions
// on Digital Pictures", 1968; Cohen and Sheffer, "Proximity Clouds", 1994, walk so). Expects `cells`.

struct EmptySpaceParams {
    cell_count: u32,
    // First cell of the volume.
    majorant_offset: u32,
    // Cells in a row of workgroups: a dispatch has at most 65535 workgroups along an axis.
    row_length: u32,
    // Of this pass: 0, then 1, then 2.
    axis: u32,
    grid_dims: vec3u,
    padding: u32,
}

@group(0) @binding(0) var<uniform> params: EmptySpaceParams;
@group(0) @binding(1) var<storage, read_write> grids: array<Cell>;
// Distances within rows, then within planes.
@group(0) @binding(2) var<storage, read_write> distances: array<u32>;

// The distance as far as the passes before have looked.
fn distance_before(index: u32) -> u32 {
    if (params.axis == 0u) {
        return select(0u, MAX_EMPTY_DISTANCE, cell_majorant(grids[params.majorant_offset + index]) == 0.0);
    }
    return distances[(params.axis - 1u) * params.cell_count + index];
}

// A vector's component by a number that is not known beforehand is beyond Godot 4.6's SPIR-V optimiser.
fn along_axis(v: vec3u) -> u32 {
    return select(select(v.z, v.y, params.axis == 1u), v.x, params.axis == 0u);
}

@compute @workgroup_size(64)
fn empty_space(@builtin(global_invocation_id) id: vec3u) {
    let index = id.y * params.row_length + id.x;
    if (index >= params.cell_count) {
        return;
    }
    let n = params.grid_dims;
    let cell = vec3u(index % n.x, index / n.x % n.y, index / (n.x * n.y));
    let stride = along_axis(vec3u(1u, n.x, n.x * n.y));
    let place = along_axis(cell);
    let last = along_axis(n) - 1u;
    var nearest = distance_before(index);
    // Beyond the grid there is nothing, where rays end.
    for (var away = 1u; away < nearest; away++) {
        if (place >= away) {
            nearest = min(nearest, max(away, distance_before(index - away * stride)));
        }
        if (place + away <= last) {
            nearest = min(nearest, max(away, distance_before(index + away * stride)));
        }
    }
    if (params.axis < 2u) {
        distances[params.axis * params.cell_count + index] = nearest;
    } else if (nearest > 0u) {
        let at = params.majorant_offset + index;
        grids[at] = cell_empty(grids[at], nearest);
    }
}
