//! Where the commands of a recording go: into an encoder of ours, which is submitted when it is full, or into one that the host
//! lends and submits itself.

use std::collections::HashSet;

use lumivox_renderer::{ResourceId, Step};

use crate::timing::Timing;

/// Bytes of uniforms between two submissions of ours.
pub(crate) const UNIFORM_BYTES: u64 = 1 << 16;

/// Bytes of uniforms that a step may take.
const STEP_UNIFORM_BYTES: u64 = 4096;

/// Bytes of texels that are copied at once.
const PIECE_BYTES: u64 = 16 << 20;

/// A row of texels in a buffer begins at a multiple of this.
const ROW_ALIGNMENT: u64 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as u64;

enum Encoder<'a> {
    Own(wgpu::CommandEncoder),
    Lent(&'a mut wgpu::CommandEncoder),
}

/// Commands that are submitted together.
pub(crate) struct Commands<'a> {
    encoder: Encoder<'a>,
    is_empty: bool,
    /// Where uniforms go, and the next of them in there.
    pub uniforms: wgpu::Buffer,
    pub uniform_cursor: u64,
    pub timing: Option<Timing>,
    /// What this recording made and no command has used.
    fresh: HashSet<ResourceId>,
}

impl<'a> Commands<'a> {
    /// In an encoder of ours.
    pub fn own(device: &wgpu::Device, uniforms: wgpu::Buffer, timing: Option<Timing>) -> Self {
        Self::new(Encoder::Own(new_encoder(device)), uniforms, timing)
    }

    /// In one of the host's. The uniforms are for these commands alone.
    pub fn lent(
        encoder: &'a mut wgpu::CommandEncoder,
        uniforms: wgpu::Buffer,
        timing: Option<Timing>,
    ) -> Self {
        Self::new(Encoder::Lent(encoder), uniforms, timing)
    }

    fn new(encoder: Encoder<'a>, uniforms: wgpu::Buffer, timing: Option<Timing>) -> Self {
        Self { encoder, is_empty: true, uniforms, uniform_cursor: 0, timing, fresh: HashSet::new() }
    }

    /// Where the next command goes.
    pub fn encoder(&mut self) -> &mut wgpu::CommandEncoder {
        self.encoder_and_timing().0
    }

    /// The same, and what times it if it is a pass.
    pub fn encoder_and_timing(&mut self) -> (&mut wgpu::CommandEncoder, Option<&mut Timing>) {
        self.is_empty = false;
        let encoder = match &mut self.encoder {
            Encoder::Own(encoder) => encoder,
            Encoder::Lent(encoder) => encoder,
        };
        (encoder, self.timing.as_mut())
    }

    /// Before a step: submits what has to be done by then, where that is up to us.
    pub fn prepare_for(&mut self, step: &Step, device: &wgpu::Device, queue: &wgpu::Queue) {
        if self.must_go_before(step)
            && let Encoder::Own(encoder) = &mut self.encoder
        {
            let full = std::mem::replace(encoder, new_encoder(device));
            queue.submit([full.finish()]);
            (self.is_empty, self.uniform_cursor) = (true, 0);
        }
        match step {
            Step::CreateBuffer { id, .. } | Step::CreateTexture { id, .. } => {
                self.fresh.insert(*id);
            }
            Step::ClearBuffer { id } | Step::ReadBuffer { id, .. } | Step::Free { id } => {
                self.fresh.remove(id);
            }
            Step::CopyTexture { from, to, .. } => {
                self.fresh.remove(from);
                self.fresh.remove(to);
            }
            Step::Dispatch { resources, .. } => resources.iter().for_each(|id| _ = self.fresh.remove(id)),
            Step::Draw { resources, target, .. } => {
                resources.iter().chain([target]).for_each(|id| _ = self.fresh.remove(id));
            }
            Step::WriteBuffer { .. } | Step::WriteTexture { .. } => {}
        }
    }

    /// Whether it has to be submitted before a step. The queue's writes take effect before the commands of the next
    /// submission, and uniforms are written by the queue.
    fn must_go_before(&self, step: &Step) -> bool {
        let needed = match step {
            Step::WriteBuffer { .. } | Step::WriteTexture { .. } => return !self.is_empty,
            Step::Dispatch { .. } | Step::Draw { .. } => STEP_UNIFORM_BYTES,
            _ => 0,
        };
        !self.is_empty && self.uniform_cursor + needed > UNIFORM_BYTES
    }

    /// Whether the queue may write to a resource now. Before the host's commands it may write only to what they do not know:
    /// else a command before this step would find what it should not see yet.
    fn queue_may_write(&self, id: ResourceId) -> bool {
        matches!(self.encoder, Encoder::Own(_)) || self.fresh.contains(&id)
    }

    /// Replaces part of a buffer.
    pub fn write_buffer(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        id: ResourceId,
        buffer: &wgpu::Buffer,
        offset: u64,
        bytes: &[u8],
    ) {
        if self.queue_may_write(id) {
            queue.write_buffer(buffer, offset, bytes);
        } else {
            let staged = stage(device, queue, bytes);
            self.encoder().copy_buffer_to_buffer(&staged, 0, buffer, offset, bytes.len() as u64);
        }
    }

    /// Replaces a box of a texture by texels without padding.
    pub fn write_texture(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        id: ResourceId,
        texture: &wgpu::Texture,
        origin: [u32; 3],
        size: [u32; 3],
        bytes: &[u8],
    ) {
        let texel = texture.format().block_copy_size(None).unwrap_or(1);
        let row_bytes = u64::from(size[0] * texel);
        if self.queue_may_write(id) {
            let layout = layout(row_bytes, size[1]);
            queue.write_texture(place(texture, origin), bytes, layout, extent(size));
            // An empty submission lets the staging memory of a large upload go as soon as it is copied.
            if matches!(self.encoder, Encoder::Own(_)) {
                queue.submit([]);
            }
            return;
        }
        let padded = row_bytes.next_multiple_of(ROW_ALIGNMENT);
        for ([_, y, z], part) in pieces(size, padded) {
            let mut rows = Vec::with_capacity((padded * u64::from(part[1]) * u64::from(part[2])) as usize);
            // The parts of a slice are of that slice alone: their rows follow each other.
            let first = u64::from(z) * u64::from(size[1]) + u64::from(y);
            for row in first..first + u64::from(part[1]) * u64::from(part[2]) {
                let from = (row * row_bytes) as usize;
                rows.extend_from_slice(bytes.get(from..from + row_bytes as usize).unwrap_or_default());
                rows.resize(rows.len().next_multiple_of(ROW_ALIGNMENT as usize), 0);
            }
            let staged = stage(device, queue, &rows);
            let from = wgpu::TexelCopyBufferInfo { buffer: &staged, layout: layout(padded, part[1]) };
            let to = place(texture, [origin[0], origin[1] + y, origin[2] + z]);
            self.encoder().copy_buffer_to_texture(from, to, extent(part));
        }
    }

    /// Submits the rest, where that is up to us.
    pub fn submit(mut self, queue: &wgpu::Queue) -> (Option<wgpu::SubmissionIndex>, Option<Timing>) {
        if let (encoder, Some(timing)) = self.encoder_and_timing() {
            timing.resolve(encoder);
        }
        let submission = match self.encoder {
            Encoder::Own(encoder) => Some(queue.submit([encoder.finish()])),
            Encoder::Lent(_) => None,
        };
        (submission, self.timing)
    }
}

fn new_encoder(device: &wgpu::Device) -> wgpu::CommandEncoder {
    device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("recording") })
}

/// A buffer that holds bytes for a copy. It is written by the queue and not mapped: where there is no memory for it, that is a
/// fault which the device tells.
fn stage(device: &wgpu::Device, queue: &wgpu::Queue, bytes: &[u8]) -> wgpu::Buffer {
    let staged = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("upload"),
        size: bytes.len() as u64,
        usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    queue.write_buffer(&staged, 0, bytes);
    staged
}

/// Parts of a box of texels, where each begins and its size: slices as many as fit a piece, or rows of one.
fn pieces([width, height, depth]: [u32; 3], row_bytes: u64) -> Vec<([u32; 3], [u32; 3])> {
    let most = |bytes: u64| (PIECE_BYTES / bytes.max(1)).clamp(1, u64::from(u32::MAX)) as u32;
    let slice_bytes = row_bytes * u64::from(height);
    let (rows, slices) =
        if slice_bytes <= PIECE_BYTES { (height.max(1), most(slice_bytes)) } else { (most(row_bytes), 1) };
    let mut parts = vec![];
    for z in (0..depth).step_by(slices as usize) {
        for y in (0..height).step_by(rows as usize) {
            parts.push(([0, y, z], [width, rows.min(height - y), slices.min(depth - z)]));
        }
    }
    parts
}

fn layout(row_bytes: u64, rows: u32) -> wgpu::TexelCopyBufferLayout {
    wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(row_bytes as u32),
        rows_per_image: Some(rows),
    }
}

fn place(texture: &wgpu::Texture, [x, y, z]: [u32; 3]) -> wgpu::TexelCopyTextureInfo<'_> {
    wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x, y, z }, ..texture.as_image_copy() }
}

fn extent([width, height, depth_or_array_layers]: [u32; 3]) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_the_whole_box_once_and_none_is_too_large() {
        for size in [[34, 34, 34], [8192, 4096, 1], [2048, 2048, 40], [1, 1, 1], [70_000, 3, 2]] {
            let row_bytes = (u64::from(size[0]) * 16).next_multiple_of(ROW_ALIGNMENT);
            let mut rows = vec![0; (size[1] * size[2]) as usize];
            for ([x, y, z], [width, height, depth]) in pieces(size, row_bytes) {
                assert_eq!((x, width), (0, size[0]));
                assert!(row_bytes * u64::from(height * depth) <= PIECE_BYTES, "{size:?}");
                assert!(depth == 1 || (y == 0 && height == size[1]), "rows of a piece follow each other");
                for z in z..z + depth {
                    for y in y..y + height {
                        rows[(z * size[1] + y) as usize] += 1;
                    }
                }
            }
            assert!(rows.iter().all(|times| *times == 1), "{size:?}");
        }
    }
}
