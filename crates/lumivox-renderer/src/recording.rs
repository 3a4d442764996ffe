//! What a host has to do on its GPU, as data.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

pub use lumivox_shaders::{BindingKind, Classes, Kernel, KernelKind};

/// A buffer or texture, from its creation until it is freed, in one or in many recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ResourceId(pub u64);

impl ResourceId {
    /// A name for a texture of the host's own: its executor is told what it stands for before it meets it.
    pub fn external() -> Self {
        crate::ids::next()
    }
}

/// How a texture's texels are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TextureFormat {
    /// One 8-bit channel in [0, 1].
    R8Unorm,
    /// One 16-bit channel in [0, 1].
    R16Unorm,
    /// Two 8-bit channels in [0, 1].
    Rg8Unorm,
    /// One half float.
    R16Float,
    /// Four floats; never filtered.
    Rgba32Float,
}

impl TextureFormat {
    /// Bytes of one texel.
    pub fn bytes_per_texel(self) -> usize {
        match self {
            TextureFormat::R8Unorm => 1,
            TextureFormat::R16Unorm | TextureFormat::Rg8Unorm | TextureFormat::R16Float => 2,
            TextureFormat::Rgba32Float => 16,
        }
    }
}

/// A texture that a recording will make under a name: a host may make it before, on another thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureOrder {
    /// Its name.
    pub id: ResourceId,
    /// For debuggers.
    pub label: &'static str,
    /// Its texels.
    pub format: TextureFormat,
    /// Texels along x, y and z.
    pub size: [u32; 3],
}

/// Bytes to upload, shared with whoever owns them: a volume goes to the GPU without a copy.
#[derive(Clone)]
pub struct Payload {
    owner: Arc<dyn AsRef<[u8]> + Send + Sync>,
    range: Range<usize>,
}

impl Payload {
    /// All bytes of `owner`.
    pub fn new(owner: impl AsRef<[u8]> + Send + Sync + 'static) -> Self {
        let range = 0..owner.as_ref().len();
        Self { owner: Arc::new(owner), range }
    }

    /// The bytes `range` of a shared owner.
    pub fn slice(owner: Arc<dyn AsRef<[u8]> + Send + Sync>, range: Range<usize>) -> Self {
        Self { owner, range }
    }

    /// A copy of plain data.
    pub fn copy_of<T: bytemuck::NoUninit>(data: &[T]) -> Self {
        Self::new(bytemuck::cast_slice::<T, u8>(data).to_vec())
    }

    /// The bytes.
    pub fn bytes(&self) -> &[u8] {
        &(*self.owner).as_ref()[self.range.clone()]
    }
}

impl fmt::Debug for Payload {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes", self.range.len())
    }
}

/// One thing to do. Steps take effect in order: a dispatch sees every write before it and none after.
#[derive(Clone, Debug)]
pub enum Step {
    /// Make a storage buffer, filled with zeros.
    CreateBuffer {
        /// Its name from now on.
        id: ResourceId,
        /// For debuggers.
        label: &'static str,
        /// Bytes; a multiple of 16, at least 16.
        size: u64,
    },
    /// Make a texture; 2D where `size[2]` is 0. One that was [made ahead](crate::Preparation::run_with) under its name is
    /// taken.
    CreateTexture {
        /// Its name from now on.
        id: ResourceId,
        /// For debuggers.
        label: &'static str,
        /// Its texels.
        format: TextureFormat,
        /// Texels along x, y and z.
        size: [u32; 3],
    },
    /// Replace part of a buffer.
    WriteBuffer {
        /// The buffer.
        id: ResourceId,
        /// First byte.
        offset: u64,
        /// The bytes, a multiple of 4.
        data: Payload,
    },
    /// Replace a box of a texture.
    WriteTexture {
        /// The texture.
        id: ResourceId,
        /// First texel.
        origin: [u32; 3],
        /// Texels along x, y and z (1 for a 2D texture).
        size: [u32; 3],
        /// The texels without padding, x fastest.
        data: Payload,
    },
    /// Copy a box of a 3D texture to the same place in another of the same format.
    CopyTexture {
        /// Where the texels come from.
        from: ResourceId,
        /// Where they go.
        to: ResourceId,
        /// First texel.
        origin: [u32; 3],
        /// Texels along x, y and z.
        size: [u32; 3],
    },
    /// Set a buffer to zeros.
    ClearBuffer {
        /// The buffer.
        id: ResourceId,
    },
    /// Run a kernel.
    Dispatch {
        /// Which one.
        kernel: Kernel,
        /// The contents of its uniform bindings, in the order of [`Kernel::bindings`].
        uniforms: Vec<Vec<u8>>,
        /// Its buffers and textures, in that order too, samplers left out: the executor has the one there is.
        resources: Vec<ResourceId>,
        /// Workgroups along x and y.
        workgroups: [u32; 2],
    },
    /// Draw one triangle that covers a texture of the host's, which may be multisampled.
    Draw {
        /// What it draws; its [`KernelKind`] says how.
        kernel: Kernel,
        /// As for [`Step::Dispatch`].
        uniforms: Vec<Vec<u8>>,
        /// As for [`Step::Dispatch`].
        resources: Vec<ResourceId>,
        /// The texture drawn to.
        target: ResourceId,
    },
    /// Bring part of a buffer back. The executor hands read-backs over in the order of their steps.
    ReadBuffer {
        /// The buffer.
        id: ResourceId,
        /// The bytes, a multiple of 4.
        range: Range<u64>,
    },
    /// The resource is not used again.
    Free {
        /// Its name until now.
        id: ResourceId,
    },
}

/// Steps for a GPU, in order.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// The steps.
    pub steps: Vec<Step>,
}

impl Recording {
    /// No steps yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether there is nothing to do.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// Appends a step.
    pub fn push(&mut self, step: Step) {
        self.steps.push(step);
    }

    /// Makes a buffer of at least 16 bytes.
    pub(crate) fn create_buffer(&mut self, label: &'static str, size: u64) -> ResourceId {
        let id = crate::ids::next();
        self.push(Step::CreateBuffer { id, label, size: size.next_multiple_of(16).max(16) });
        id
    }

    /// Makes a buffer with contents.
    pub(crate) fn create_buffer_with<T: bytemuck::NoUninit>(
        &mut self,
        label: &'static str,
        data: &[T],
    ) -> ResourceId {
        let id = self.create_buffer(label, size_of_val(data) as u64);
        if !data.is_empty() {
            self.push(Step::WriteBuffer { id, offset: 0, data: Payload::copy_of(data) });
        }
        id
    }

    /// Makes a texture.
    pub(crate) fn create_texture(
        &mut self,
        label: &'static str,
        format: TextureFormat,
        size: [u32; 3],
    ) -> ResourceId {
        let id = crate::ids::next();
        self.push(Step::CreateTexture { id, label, format, size });
        id
    }

    /// Frees a resource that may not exist.
    pub(crate) fn free(&mut self, id: Option<ResourceId>) {
        if let Some(id) = id {
            self.push(Step::Free { id });
        }
    }
}
