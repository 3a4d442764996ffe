//! Bytes on their way back from the device.

use std::sync::mpsc;

use super::commands::Command;
use super::{Gpu, ROW, Region};
use crate::formats::{self, extent, origin};

/// Bytes on their way back.
#[derive(Debug)]
pub(super) struct Ticket {
    pub(super) buffer: wgpu::Buffer,
    pub(super) arrived: Option<mpsc::Receiver<Result<(), wgpu::BufferAsyncError>>>,
    /// Bytes of a row as they lie, and as they are wanted; and how many rows there are.
    rows: (usize, usize, usize),
}

impl Gpu {
    pub fn read_buffer(&mut self, from: u32, offset: u64, size: u64) -> Result<u32, String> {
        let from = self.buffer(from)?;
        if offset + size > from.size() {
            return Err(format!("{size} bytes from byte {offset} are wanted of a buffer of {}", from.size()));
        }
        let (start, end) = (offset / 4 * 4, (offset + size).next_multiple_of(4).min(from.size()));
        let to = self.landing(end - start);
        self.commands.push(Command::ReadBuffer { from, offset: start, to: to.clone(), size: end - start });
        if start != offset {
            return Err(format!("a read-back starts at byte {offset}, which is no multiple of 4"));
        }
        Ok(self.ticket(to, (size as usize, size as usize, 1)))
    }

    pub fn read_texture(&mut self, from: Region, size: [u32; 3]) -> Result<u32, String> {
        let texture = self.texture(from.texture)?;
        let tight = size[0] * formats::texel_bytes(texture.format());
        let (row, rows) = (tight.next_multiple_of(ROW), size[1] * size[2]);
        let to = self.landing(u64::from(row) * u64::from(rows));
        self.commands.push(Command::ReadTexture {
            from: texture,
            level: from.level,
            origin: origin(from.origin),
            size: extent(size),
            to: to.clone(),
            row,
        });
        Ok(self.ticket(to, (row as usize, tight as usize, rows as usize)))
    }

    fn landing(&self, size: u64) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    fn ticket(&mut self, buffer: wgpu::Buffer, rows: (usize, usize, usize)) -> u32 {
        let number = self.next;
        self.next += 1;
        self.tickets.insert(number, Ticket { buffer, arrived: None, rows });
        self.pending.push(number);
        number
    }

    /// The bytes of a read-back that was submitted; waits for them.
    pub fn collect(&mut self, ticket: u32, bytes: &mut [u8]) -> Result<(), String> {
        let Ticket { buffer, arrived, rows: (row, tight, count) } =
            self.tickets.remove(&ticket).ok_or("there is no such read-back")?;
        let arrived = arrived.ok_or("the read-back was not submitted")?;
        if bytes.len() != tight * count {
            return Err(format!("{} bytes are wanted of a read-back of {}", bytes.len(), tight * count));
        }
        self.device
            .poll(wgpu::PollType::Wait { submission_index: None, timeout: None })
            .map_err(|error| error.to_string())?;
        match arrived.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(error.to_string()),
            Err(_) => return Err("the device was lost".into()),
        }
        let mapped = buffer.slice(..).get_mapped_range();
        for index in 0..count {
            bytes[index * tight..][..tight].copy_from_slice(&mapped[index * row..][..tight]);
        }
        Ok(())
    }
}
