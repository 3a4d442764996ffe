//! What every device of WebGPU has.

use crate::scene_cache::DeviceLimits;

impl DeviceLimits {
    /// The limits that WebGPU guarantees and a browser gives unasked (<https://www.w3.org/TR/webgpu/#limits>): storage
    /// buffers of 128 MiB, textures of 2048 texels along each axis or 8192 by 8192, no 16-bit norms.
    ///
    /// What else a recording keeps to needs no field here, for no device gets more: 8 storage buffers, 12 uniform ones, 16
    /// textures and 16 samplers of a kernel, 256 invocations of a workgroup, 65,535 workgroups along an axis. A film of more
    /// pixels than a buffer of 128 MiB holds is refused: a host that shows larger ones asks its adapter for more.
    pub const fn webgpu_default() -> Self {
        Self {
            max_texture_3d: 2048,
            // Not guaranteed, and not to be asked for: voxels that a device refuses come reduced.
            max_texture_bytes: Self::TEXTURE_BYTES_OF_GPU,
            unorm16: false,
            one_pool: false,
            max_texture_2d: 8192,
            max_storage_binding: 128 << 20,
            max_samples_per_dispatch: Self::SAMPLES_OF_GPU,
            loop_turns: None,
            few_kernels: false,
        }
    }
}
