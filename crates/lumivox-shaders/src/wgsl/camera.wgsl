// Primary rays.

struct CameraRay {
    origin: vec3f,
    direction: vec3f,
}

// Through a point of a pixel of the whole image.
fn camera_ray(pixel: vec2u, jitter: vec2f) -> CameraRay {
    let uv = (vec2f(pixel) + jitter) / vec2f(frame.image_size) * 2.0 - 1.0;
    let offset = frame.camera_right * uv.x - frame.camera_up * uv.y;
    if (frame.orthographic != 0u) {
        return CameraRay(frame.camera_position + offset, frame.camera_forward);
    }
    return CameraRay(frame.camera_position, normalize(offset + frame.camera_forward));
}
