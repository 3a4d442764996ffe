// Live films to the picture that is drawn over the host's own: once for each pixel of it, for colour and depth.
//
// Two films make the picture. A coarse one answers at once while something moves; a fine one takes over as its samples
// come in. The coarse one is always denoised, and interpolated by a spline, whose slopes have no breaks. Both may be
// smaller than the picture: taps that lie behind another surface of the host do not leak over its edges, in the manner
// of joint bilateral upsampling (Kopf et al., SIGGRAPH 2007). Surfaces that an opaque volume hides have no such edges.

struct LivePictureParams {
    // View depth is (x * ndc + y) / (z * ndc + w), and the other way round.
    view_depth_from_ndc: vec4f,
    ndc_from_view_depth: vec4f,
    // Pixels of the host's image.
    picture_size: vec2u,
    first_size: vec2u,
    // 0 without a second film.
    second_size: vec2u,
    exposure: f32,
    // The depth buffer's value where nothing was drawn.
    clear: f32,
    has_host_depth: u32,
    // Whether light and alpha come from the denoiser's pixels instead of the films.
    denoised: u32,
    // Whether x and y of what is seen grow with its depth, or do not.
    camera_parallel: u32,
    // FOG_NONE, FOG_EXPONENTIAL or FOG_BETWEEN.
    fog_kind: u32,
    fog_distance: vec4f,
    fog_color: vec3f,
    // View depth of the farthest point of all volumes.
    farthest: f32,
    // The camera's left, right, bottom and top edge, in metres: at depth 1 unless parallel.
    camera_edges: vec4f,
    // World y of a point in the camera's frame: (x, y, z) * point + w.
    world_height: vec4f,
    fog_height: vec2f,
    // Whether the first film is the coarse one, and there is no other yet.
    coarse_alone: u32,
    // Whether the second film is a picture of kept light.
    kept_light: u32,
    // Whether the first film is shown beside it: not while it has holes.
    film_is_shown: u32,
    padding_x: u32,
    padding_y: u32,
    padding_z: u32,
}

@group(0) @binding(0) var<uniform> params: LivePictureParams;
@group(0) @binding(1) var<storage, read> first_film: array<vec4f>;
@group(0) @binding(2) var<storage, read> second_film: array<vec4f>;
@group(0) @binding(3) var<storage, read> first_pixels: array<vec4f>;
@group(0) @binding(4) var<storage, read> second_pixels: array<vec4f>;
// Only loaded from where `has_host_depth` says that it is one.
@group(0) @binding(5) var host_depth_map: texture_2d<f32>;
// Premultiplied light and alpha.
@group(0) @binding(6) var<storage, read_write> picture_color: array<vec4f>;
// As the host's depth buffer has it; negative where nothing is seen.
@group(0) @binding(7) var<storage, read_write> picture_depth: array<f32>;

// Samples of a pixel after which the denoiser is out of it: a finished picture is unbiased.
const DENOISED_UNTIL: f32 = 256.0;
// Samples of a fine pixel that weigh as much as the coarse film at the beginning.
const COARSE_WEIGHT: f32 = 8.0;
// And as much as kept light.
const KEPT_LIGHT_WEIGHT: f32 = 1.0;
// Samples of a fine pixel up to which it does not outshine the coarse film, and how many times at first.
const BOUNDED_UNTIL: f32 = 8.0;
const BRIGHTEST_OVER_COARSE: f32 = 4.0;
// Variances of a fine pixel, by its samples, by which the coarse film may differ in square and still be taken for the same.
const SAME_VARIANCES: f32 = 4.0;
// Samples of a fine pixel from which they tell their variance.
const TELLING_SAMPLES: f32 = 4.0;
// What is more transparent than this has no depth: what lies behind it is seen better than it is itself.
const LEAST_ALPHA: f32 = 0.5;
// A tap whose ray ends less alike than this saw another surface of the host than the pixel shows.
const ALIKE: f32 = 0.1;
// The largest that a half float holds is 65504.
const BRIGHTEST: f32 = 65000.0;

struct Estimate {
    light: vec3f,
    alpha: f32,
    // View depth of what is seen, where a sample has hit; the share of those that have.
    depth: f32,
    hits: f32,
    samples: f32,
    // How alike the ends of its rays and the pixel's are at best, where they count.
    alike: f32,
    // Of the light's luminance.
    variance: f32,
}

// Sums over pixels, weighted.
struct Weighted {
    light: vec3f,
    alpha: f32,
    depth: f32,
    hits: f32,
    samples: f32,
    // At best.
    alike: f32,
    variance: f32,
    weights: f32,
}

fn add(sums: ptr<function, Weighted>, e: Estimate, w: f32, alike: f32) {
    (*sums).light += w * e.light;
    (*sums).alpha += w * e.alpha;
    (*sums).depth += w * e.hits * e.depth;
    (*sums).hits += w * e.hits;
    (*sums).samples += w * e.samples;
    (*sums).variance += w * e.variance;
    (*sums).alike = max((*sums).alike, alike);
    (*sums).weights += w;
}

// The first film may be the coarse one, the second always is.
fn is_coarse(second: bool) -> bool {
    return second || params.coarse_alone != 0u;
}

fn film_pixel(second: bool, at: vec2u) -> Estimate {
    var e: Estimate;
    let size = select(params.first_size, params.second_size, second);
    let index = at.y * size.x + at.x;
    let plane = size.x * size.y;
    if (second && params.kept_light != 0u) {
        let seen = second_pixels[index];
        e.light = seen.rgb;
        e.alpha = seen.a;
        e.hits = seen.a;
        e.depth = second_pixels[plane + index].w;
        e.samples = 1.0;
        return e;
    }
    var sum: vec4f;
    var moments: vec4f;
    if (second) {
        sum = second_film[index];
        moments = second_film[plane + index];
    } else {
        sum = first_film[index];
        moments = first_film[plane + index];
    }
    e.samples = moments.z;
    if (e.samples == 0.0) {
        return e;
    }
    e.light = sum.rgb / e.samples;
    e.alpha = sum.a / e.samples;
    e.hits = e.alpha;
    e.depth = moments.x / max(sum.a, 1.0);
    let mean = luminance(e.light);
    e.variance = max(moments.y / e.samples - mean * mean, 0.0) / max(e.samples - 1.0, 1.0);
    if (is_coarse(second) || (params.denoised != 0u && e.samples < DENOISED_UNTIL)) {
        var filtered: vec4f;
        // Variance, limit and samples as they were then.
        var then: vec4f;
        if (second) {
            filtered = second_pixels[index];
            then = second_pixels[plane + index];
        } else {
            filtered = first_pixels[index];
            then = first_pixels[plane + index];
        }
        if (!second && params.kept_light != 0u) {
            // Filtered was what the film shows more than that.
            filtered = vec4f(filtered.rgb + second_pixels[index].rgb, second_pixels[index].a);
        }
        // What started over since it was filtered is another surface's.
        if (e.samples >= then.z && film_limit(second, at) == then.y) {
            let kept = select(e.samples / DENOISED_UNTIL, 0.0, is_coarse(second));
            e.light = mix(filtered.rgb, e.light, kept);
            e.alpha = mix(filtered.a, e.alpha, kept);
        }
    }
    return e;
}

fn film_limit(second: bool, at: vec2u) -> f32 {
    let size = select(params.first_size, params.second_size, second);
    let index = at.y * size.x + at.x;
    if (second && params.kept_light != 0u) {
        return second_pixels[size.x * size.y + index].y;
    }
    let entry = ray_limit_entry(size.x * size.y, index);
    if (second) {
        return second_film[entry][index % 4u];
    }
    return first_film[entry][index % 4u];
}

// A film at a point of the picture in [0, 1], where the host's surface lies at view depth `limit`.
fn film_at(second: bool, uv: vec2f, limit: f32) -> Estimate {
    let size = select(params.first_size, params.second_size, second);
    let last = vec2i(size) - 1;
    if (all(size == params.picture_size)) {
        let at = vec2u(clamp(vec2i(uv * vec2f(size)), vec2i(0), last));
        var own = film_pixel(second, at);
        own.alike = 1.0;
        if (second && params.kept_light != 0u) {
            // It may be of a frame before, in which the host's surface was another: film and picture tell the same of one.
            own.alike = max(likeness(film_limit(true, at), film_limit(false, at)), hidden(own.alpha));
            if (own.alike < ALIKE && limit > 0.0 && own.depth > limit) {
                own.light = vec3f(0.0);
                own.alpha = 0.0;
                own.hits = 0.0;
            }
        }
        return own;
    }
    // Weights of two or three pixels along each axis: linear, or the quadratic B-spline's.
    let smooth_taps = is_coarse(second);
    let q = uv * vec2f(size) - select(0.5, 0.0, smooth_taps);
    let f = q - floor(q);
    let taps = select(2, 3, smooth_taps);
    let base = vec2i(floor(q)) - select(0, 1, smooth_taps);
    var along_x = vec3f(1.0 - f.x, f.x, 0.0);
    var along_y = vec3f(1.0 - f.y, f.y, 0.0);
    if (smooth_taps) {
        along_x = vec3f(0.5 * (1.0 - f.x) * (1.0 - f.x), 0.75 - (f.x - 0.5) * (f.x - 0.5), 0.5 * f.x * f.x);
        along_y = vec3f(0.5 * (1.0 - f.y) * (1.0 - f.y), 0.75 - (f.y - 0.5) * (f.y - 0.5), 0.5 * f.y * f.y);
    }
    var mean: Weighted;
    // What counts as far as a volume hides the pixel's surface.
    var through: Weighted;
    for (var i = 0; i < taps * taps; i++) {
        let tap = vec2i(i % taps, i / taps);
        let at = vec2u(clamp(base + tap, vec2i(0), last));
        var e = film_pixel(second, at);
        if (e.samples > 0.0) {
            let alike = likeness(film_limit(second, at), limit);
            if (alike < ALIKE && limit > 0.0 && e.depth > limit) {
                // What a ray met that passed by the pixel's surface is hidden behind that.
                e.light = vec3f(0.0);
                e.alpha = 0.0;
                e.hits = 0.0;
            }
            let w = along_x[tap.x] * along_y[tap.y] + 1e-4;
            add(&mean, e, w * alike, alike);
            let unlike = (1.0 - alike) * hidden(e.alpha);
            add(&through, e, w * unlike, unlike);
        }
    }
    if (mean.weights == 0.0) {
        return Estimate();
    }
    let behind = hidden(mean.alpha / mean.weights);
    let hits = mean.hits + behind * through.hits;
    let weights = mean.weights + behind * through.weights;
    var e: Estimate;
    e.light = (mean.light + behind * through.light) / weights;
    e.alpha = (mean.alpha + behind * through.alpha) / weights;
    e.samples = (mean.samples + behind * through.samples) / weights;
    e.variance = (mean.variance + behind * through.variance) / weights;
    e.depth = (mean.depth + behind * through.depth) / max(hits, 1e-9);
    e.hits = hits / weights;
    e.alike = max(mean.alike, behind * through.alike);
    return e;
}

// How much of the coarse film's blur can be the fine one's noise: the share that is best mixed in where a difference is
// what both amount to (James and Stein 1961). A socket that a cut has opened is dark as soon as its samples say so.
fn agreement(fine: Estimate, coarse: Estimate) -> f32 {
    if (fine.samples < TELLING_SAMPLES) {
        return 1.0;
    }
    let of_light = luminance(fine.light) - luminance(coarse.light);
    let of_alpha = fine.alpha - coarse.alpha;
    // With a hit and a miss more than there were, see `denoise_wavelet`.
    let a = (fine.alpha * fine.samples + 1.0) / (fine.samples + 2.0);
    let alpha_variance = a * (1.0 - a) / (fine.samples + 2.0);
    return min(
        min(SAME_VARIANCES * fine.variance / max(of_light * of_light, 1e-12), 1.0),
        min(SAME_VARIANCES * alpha_variance / max(of_alpha * of_alpha, 1e-12), 1.0));
}

fn both_films_at(uv: vec2f, limit: f32) -> Estimate {
    var fine = film_at(false, uv, limit);
    let alone = f32(select(FINE_ALONE, KEPT_LIGHT_UNTIL, params.kept_light != 0u));
    if (params.second_size.x == 0u || fine.samples >= alone) {
        return fine;
    }
    let coarse = film_at(true, uv, limit);
    if (coarse.samples == 0.0 || (coarse.alike < ALIKE && fine.samples > 0.0)) {
        return fine;
    }
    var w = 1.0;
    if (params.kept_light != 0u) {
        // What is known by kept light is in the fine film's pixels already, once they are filtered.
        w = select(0.0, fine.samples / (fine.samples + KEPT_LIGHT_WEIGHT), params.film_is_shown != 0u);
    } else {
        let fade = (1.0 - fine.samples / alone) * agreement(fine, coarse);
        w = fine.samples / (fine.samples + COARSE_WEIGHT * fade);
    }
    fine.depth = mix(coarse.hits * coarse.depth, fine.hits * fine.depth, w)
        / max(mix(coarse.hits, fine.hits, w), 1e-9);
    let few = 1.0 - fine.samples / BOUNDED_UNTIL;
    if (few > 0.0 && params.kept_light == 0u) {
        let most = BRIGHTEST_OVER_COARSE / few * luminance(coarse.light);
        fine.light *= min(most / max(luminance(fine.light), 1e-30), 1.0);
    }
    fine.light = mix(coarse.light, fine.light, w);
    fine.alpha = mix(coarse.alpha, fine.alpha, w);
    return fine;
}

@compute @workgroup_size(8, 8)
fn live_picture(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= params.picture_size)) {
        return;
    }
    var limit = 0.0;
    if (params.has_host_depth != 0u) {
        let ndc = textureLoad(host_depth_map, vec2i(id.xy), 0).r;
        limit = view_depth_from_ndc(ndc, params.view_depth_from_ndc, params.clear, params.farthest);
    }
    let uv = (vec2f(id.xy) + 0.5) / vec2f(params.picture_size);
    let e = both_films_at(uv, limit);
    let light = fogged(e.light * params.exposure, e.alpha, uv, e.depth);
    let index = id.y * params.picture_size.x + id.x;
    picture_color[index] = vec4f(min(light, vec3f(BRIGHTEST)), e.alpha);

    var depth = -1.0;
    if (e.alpha >= LEAST_ALPHA && e.depth > 0.0) {
        let map = params.ndc_from_view_depth;
        depth = clamp((map.x * e.depth + map.y) / (map.z * e.depth + map.w), 0.0, 1.0);
    }
    picture_depth[index] = depth;
}
