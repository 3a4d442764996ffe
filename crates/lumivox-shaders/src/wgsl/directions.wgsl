// Distributions of the direction that light takes at a collision, each normalised: no event makes or loses energy.
//
// wo points back along the ray, wi onwards; both away from the collision. Expects `SURFACE`.

// What happens at a collision: each lobe with its share of the light, which add up to 1.
struct Event {
    // Henyey and Greenstein's phase function, about the way on.
    phase: f32,
    onward: vec3f,
    anisotropy: f32,
    // Of the light that is not reflected like by a mirror, what remains.
    albedo: vec3f,
    // How much of that colour mirrors have, too: 0 none, as of skin, 1 all, as of metal.
    metallic: f32,
    // Surfaces, where there are any: another such lobe about the mirror direction, and a diffuse one about the normal.
    specular: f32,
    diffuse: f32,
    mirror: vec3f,
    normal: vec3f,
    lobe_anisotropy: f32,
}

// Without a surface.
fn event_of_phase(onward: vec3f, anisotropy: f32, albedo: vec3f) -> Event {
    return Event(1.0, onward, anisotropy, albedo, 0.0, 0.0, 0.0, onward, onward, 0.0);
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

// A direction, by the lobes' shares.
fn event_sample(event: Event, pick: f32, u: vec2f) -> vec3f {
    if (SURFACE && pick >= event.phase) {
        if (pick - event.phase < event.diffuse) {
            return to_world(event.normal, sample_cosine_hemisphere(u));
        }
        return to_world(event.mirror, sample_henyey_greenstein(event.lobe_anisotropy, u));
    }
    return to_world(event.onward, sample_henyey_greenstein(event.anisotropy, u));
}

// Over solid angle: x the density of wi among those that `event_sample` draws, y the part of it that mirrors.
fn event_densities(event: Event, wi: vec3f) -> vec2f {
    var density = henyey_greenstein(dot(event.onward, wi), event.anisotropy);
    var mirrored = 0.0;
    if (SURFACE && event.phase < 1.0) {
        mirrored = event.specular * henyey_greenstein(dot(event.mirror, wi), event.lobe_anisotropy);
        density = event.phase * density + event.diffuse * max(dot(event.normal, wi), 0.0) / PI + mirrored;
    }
    return vec2f(density, mirrored);
}

fn event_pdf(event: Event, wi: vec3f) -> f32 {
    return event_densities(event, wi).x;
}

// What remains of the light that is reflected like by a mirror.
fn mirrored_color(event: Event) -> vec3f {
    return mix(vec3f(1.0), event.albedo, event.metallic);
}

// What is sent on towards wi, over its density: between the albedo and 1.
fn event_weight(event: Event, densities: vec2f) -> vec3f {
    if (SURFACE && densities.y > 0.0) {
        return mix(event.albedo, mirrored_color(event), min(densities.y / densities.x, 1.0));
    }
    return event.albedo;
}

// What is sent on in all directions.
fn event_total(event: Event) -> vec3f {
    return mix(event.albedo, mirrored_color(event), event.specular);
}
