// `select` component by component: HLSL's choice takes one condition for all of a vector.

fn choose(no: vec3f, yes: vec3f, which: vec3<bool>) -> vec3f {
    return vec3f(select(no.x, yes.x, which.x), select(no.y, yes.y, which.y), select(no.z, yes.z, which.z));
}

fn choose_int(no: vec3i, yes: vec3i, which: vec3<bool>) -> vec3i {
    return vec3i(select(no.x, yes.x, which.x), select(no.y, yes.y, which.y), select(no.z, yes.z, which.z));
}
