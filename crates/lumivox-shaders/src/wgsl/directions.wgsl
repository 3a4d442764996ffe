// Distributions of the direction that light takes at a collision, each normalised: no event makes or loses energy.
//
// wo points back along the ray, wi onwards; both away from the collision. Expects `SURFACE`.

const PHASE: u32 = 0u;
const SPECULAR: u32 = 1u;
const DIFFUSE: u32 = 2u;

struct Event {
    kind: u32,
    axis: vec3f,        // of the distribution: onward direction, mirror direction, or normal
    anisotropy: f32,    // of the Henyey-Greenstein lobes
    weight: vec3f,      // what remains of the light
}

// Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
fn to_world(axis: vec3f, local: vec3f) -> vec3f {
    let s = select(-1.0, 1.0, axis.z >= 0.0);
    let a = -1.0 / (s + axis.z);
    let b = axis.x * axis.y * a;
    let x = vec3f(1.0 + s * axis.x * axis.x * a, s * b, -s * axis.x);
    let y = vec3f(b, s + axis.y * axis.y * a, -axis.y);
    return normalize(x * local.x + y * local.y + axis * local.z);
}

// Henyey and Greenstein 1941, with the cosine between the lobe's axis and wi: g > 0 scatters along the axis.
fn henyey_greenstein(cosine: f32, g: f32) -> f32 {
    let d = max(1.0 + g * g - 2.0 * g * cosine, 1e-7);
    return (1.0 - g * g) / (4.0 * PI * d * sqrt(d));
}

fn sample_henyey_greenstein(g: f32, u: vec2f) -> vec3f {
    let a = 1.0 - 2.0 * u.x;
    // To first order in g: the closed form divides by it.
    var cosine = a + 1.5 * g * (1.0 - a * a);
    if (abs(g) > 1e-3) {
        let s = (1.0 - g * g) / (1.0 + g * a);
        cosine = clamp((1.0 + g * g - s * s) / (2.0 * g), -1.0, 1.0);
    }
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    let phi = 2.0 * PI * u.y;
    return vec3f(sine * cos(phi), sine * sin(phi), cosine);
}

fn sample_cosine_hemisphere(u: vec2f) -> vec3f {
    let r = sqrt(u.x);
    let phi = 2.0 * PI * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// Uniform over the solid angle of a cone about +z whose half angle's cosine is 1 - height.
fn sample_cone(height: f32, u: vec2f) -> vec3f {
    let h = u.x * height;
    let sine = sqrt(h * (2.0 - h));
    let phi = 2.0 * PI * u.y;
    return vec3f(sine * cos(phi), sine * sin(phi), 1.0 - h);
}

// The way to a point on a disc about `centre` that faces where one is: uniform over its area.
fn sample_disc(centre: vec3f, radius: f32, u: vec2f) -> vec3f {
    let distance = length(centre);
    // At the very centre any disc is as good.
    let axis = select(vec3f(0.0, 1.0, 0.0), centre / max(distance, 1e-20), distance > 1e-12);
    let phi = 2.0 * PI * u.y;
    return centre + radius * sqrt(u.x) * to_world(axis, vec3f(cos(phi), sin(phi), 0.0));
}

fn event_sample(event: Event, u: vec2f) -> vec3f {
    if (SURFACE && event.kind == DIFFUSE) {
        return to_world(event.axis, sample_cosine_hemisphere(u));
    }
    return to_world(event.axis, sample_henyey_greenstein(event.anisotropy, u));
}

// The density of wi over solid angle.
fn event_pdf(event: Event, wi: vec3f) -> f32 {
    let cosine = dot(event.axis, wi);
    if (SURFACE && event.kind == DIFFUSE) {
        return max(cosine, 0.0) / PI;
    }
    return henyey_greenstein(cosine, event.anisotropy);
}
