//! Kernels run once on nothing. Drivers of GPUs compile a kernel with its pipeline, those in software when it first runs:
//! hosts on these let it run before a frame waits for it.

use lumivox_shaders::layout::Frame;
use lumivox_shaders::{BindingKind, Kernel};

use crate::recording::{Recording, Step, TextureFormat};

/// More than any element of a kernel's buffers.
const BUFFER_BYTES: u64 = 1024;

/// Texels along a side. Drivers compile for textures whose sides are powers of two by themselves; of volumes few are.
const TEXELS: u32 = 3;

/// Records a run of each kernel that traces paths, over no pixel at all. Others are small.
pub fn record_priming(kernels: impl IntoIterator<Item = Kernel>, recording: &mut Recording) {
    let mut made = vec![];
    for kernel in kernels.into_iter().filter(|kernel| matches!(kernel, Kernel::PathTrace(_))) {
        let mut resources = vec![];
        for kind in kernel.bindings() {
            resources.extend(match kind {
                BindingKind::Uniform | BindingKind::LinearSampler => None,
                BindingKind::StorageRead | BindingKind::StorageReadWrite => {
                    Some(recording.create_buffer("priming", BUFFER_BYTES))
                }
                BindingKind::Texture3dFiltered => {
                    Some(recording.create_texture("priming", TextureFormat::R16Unorm, [TEXELS; 3]))
                }
                BindingKind::Texture2dLoaded => {
                    Some(recording.create_texture("priming", TextureFormat::Rgba32Float, [1, 1, 0]))
                }
            });
        }
        // No row is wanted of it.
        let frame =
            Frame { sharers: 1, group_stride: 1, group_count: 1, film_size: [1; 2], ..Frame::default() };
        made.extend(resources.iter().copied());
        recording.push(Step::Dispatch {
            kernel,
            uniforms: vec![bytemuck::bytes_of(&frame).to_vec()],
            resources,
            workgroups: [1, 1],
        });
    }
    for id in made {
        recording.push(Step::Free { id });
    }
}
