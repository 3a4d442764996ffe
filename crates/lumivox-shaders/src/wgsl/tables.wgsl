// The buffer of tables, in pairs of 32 bits: devices bind few buffers, so what is short shares one. Expects `tables`.

fn pair_at(index: u32) -> vec2f {
    return bitcast<vec2f>(tables[index]);
}

// Two pairs, that are four numbers or the words of a struct.
fn words_at(index: u32) -> vec4u {
    return vec4u(tables[index], tables[index + 1u]);
}
