// From scene-linear light to display values in [0, 1]. CPU twin: `ToneMap` in lumivox-renderer's `display.rs`.

// The sRGB transfer function, IEC 61966-2-1.
fn srgb_encode(c: vec3f) -> vec3f {
    return choose(1.055 * pow(max(c, vec3f(0.0031308)), vec3f(1.0 / 2.4)) - 0.055, c * 12.92, c <= vec3f(0.0031308));
}

// A filmic curve in the manner of AgX (T. Sobotka): mix the primaries so that bright colours fade to white, take the
// logarithm over 16.5 stops around middle grey, apply an S-curve that keeps 0.18 at its place, unmix a little more
// than was mixed, as its "punchy" look does. Gives display values already encoded.
const AGX_MIX: f32 = 0.10;
const AGX_UNMIX: f32 = 0.22;

fn agx(c: vec3f) -> vec3f {
    let mean = (c.r + c.g + c.b) / 3.0;
    let mixed = max(mix(c, vec3f(mean), AGX_MIX), vec3f(1e-10));
    let stops = clamp((log2(mixed / 0.18) + 10.0) / 16.5, vec3f(0.0), vec3f(1.0));
    let curved = agx_curve(stops);
    let curved_mean = (curved.r + curved.g + curved.b) / 3.0;
    return clamp((curved - AGX_UNMIX * curved_mean) / (1.0 - AGX_UNMIX), vec3f(0.0), vec3f(1.0));
}

// An S-curve through (pivot, middle grey encoded), slope 2.35 there, flat at both ends: x = pivot + d is sent to
// grey + slope * d / (1 + (slope * |d| / room)^power)^(1 / power).
fn agx_curve(x: vec3f) -> vec3f {
    let pivot = 10.0 / 16.5;
    let grey = 0.4613;
    let slope = 2.35;
    let d = x - pivot;
    let room = choose(vec3f(grey), vec3f(1.0 - grey), d >= vec3f(0.0));
    // The power that lets the curve reach its end value at the end of the range would be infinite; this leaves 1%.
    let power = choose(vec3f(2.6), vec3f(2.2), d >= vec3f(0.0));
    let linear = slope * d;
    return grey + linear / pow(1.0 + pow(abs(linear) / room, power), 1.0 / power);
}

// K. Narkowicz's fit of the ACES reference rendering, 2016.
fn aces(c: vec3f) -> vec3f {
    let x = c * 0.6;
    return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), vec3f(0.0), vec3f(1.0));
}

fn tone_map(c: vec3f, curve: u32, inverse_gamma: f32) -> vec3f {
    var display: vec3f;
    switch curve {
        case TONE_AGX: { display = agx(c); }
        case TONE_ACES: { display = srgb_encode(aces(c)); }
        default: { display = srgb_encode(clamp(c, vec3f(0.0), vec3f(1.0))); }
    }
    return pow(display, vec3f(inverse_gamma));
}
