//! What devices can do, as far as recordings depend on it.

use lumivox_shaders::constants;

/// What the host's GPU can do. A host begins with [what every device has](Self::webgpu_default), and says [what differs](Self::with).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct DeviceLimits {
    /// Largest side of a 3D texture.
    pub max_texture_3d: u32,
    /// Bytes of a texture at most.
    pub max_texture_bytes: u64,
    /// How voxels of more than 8 bits are stored.
    pub fine_texels: FineTexels,
    /// Whether all voxels have to be in one texture: where a choice between textures costs as much as a look at each.
    pub one_pool: bool,
    /// Largest side of a 2D texture.
    pub max_texture_2d: u32,
    /// Largest storage buffer that can be bound, in bytes.
    pub max_storage_binding: u64,
    /// Samples that one invocation traces in one dispatch at most; see [`SAMPLES_OF_GPU`](Self::SAMPLES_OF_GPU).
    pub max_samples_per_dispatch: u32,
    /// Where the driver ends invocations after so many turns of their loops: what they may take.
    pub loop_turns: Option<LoopTurns>,
    /// Whether kernels take so long to make that few of them should do: scenes that need less are traced with those that
    /// can do more. Of media that depend on more than values no light is kept then.
    pub few_kernels: bool,
}

/// How textures hold voxels of more than 8 bits so that they can be filtered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FineTexels {
    /// As 16-bit norms.
    Norms,
    /// Each as two 8-bit norms, which are filtered apart: where there are no others. No bit is lost by a device that filters them to
    /// more bits than they have.
    TwoBytes,
    /// As half floats, which have 11 bits: where nothing else can be had, or is known of.
    Halves,
}

/// Turns that all loops of an invocation may take together before its driver ends it, and says nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoopTurns {
    /// While the invocations with which it shares a vector, and the turns, work as well.
    pub shared: u32,
    /// While they rest.
    pub alone: u32,
}

impl LoopTurns {
    /// Of Mesa's llvmpipe (65,535, `LP_MAX_TGSI_LOOP_ITERATIONS`), for each vector of at most `width` invocations. Some
    /// are left for loops that are short and go on to their ends when there are no more: less than 60 turns of each of
    /// 16 invocations.
    pub fn of_software(width: u32) -> Self {
        let alone = 64_000;
        Self { shared: alone / width.clamp(1, constants::TOGETHER), alone }
    }
}

impl DeviceLimits {
    /// What most drivers give a texture: a little less than 4 GiB.
    pub const TEXTURE_BYTES_OF_GPU: u64 = 4000 << 20;

    /// What Mesa's llvmpipe gives one (`LP_MAX_TEXTURE_SIZE`).
    pub const TEXTURE_BYTES_OF_SOFTWARE: u64 = 1 << 30;

    /// Enough samples of a dispatch to keep a GPU's lanes busy, few enough to keep it responsive.
    pub const SAMPLES_OF_GPU: u32 = 64;

    /// Of a device in software, whose dispatches take long.
    pub const SAMPLES_OF_SOFTWARE: u32 = 4;

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
            fine_texels: FineTexels::Halves,
            one_pool: false,
            max_texture_2d: 8192,
            max_storage_binding: 128 << 20,
            max_samples_per_dispatch: Self::SAMPLES_OF_GPU,
            loop_turns: None,
            few_kernels: false,
        }
    }

    /// The same with changes.
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }
}
