// What is seen of the light that is kept in several volumes, or in none: by first collisions, as many as the frame has samples.

// At a pixel whose rays end at a view depth; nowhere where that is 0.
fn see(pixel: vec2u, t_end: f32) -> Seen {
    var seen = Seen();
    for (var i = 0u; i < frame.samples; i++) {
        var rng = rng_new(pixel, i, frame.seed);
        let ray = camera_ray(pixel, rng_next2(&rng));
        var t_max = 1e30;
        if (t_end > 0.0) {
            t_max = t_end / dot(ray.direction, frame.view_axis);
        }
        let hit = next_collision(ray.origin, ray.direction, t_max, &rng);
        if (hit.kind == IN_VOLUME) {
            let position = ray.origin + hit.t * ray.direction;
            let sent = sent_light(hit.volume, position, ray.direction, hit.reading);
            seen.light += sent.light;
            seen.color += sent.color;
            seen.sureness += sent.sureness;
            seen.depth += dot(position - frame.camera_position, frame.view_axis);
            seen.alpha += 1.0;
        }
    }
    let inverse = 1.0 / f32(frame.samples);
    return seen_times(inverse, seen);
}
