//! Lists that the GPU has a copy of.

use std::sync::Arc;

use crate::recording::{Payload, Recording, ResourceId, Step};

/// What has a storage buffer of its own.
#[derive(Debug)]
pub(super) struct Mirror<T> {
    pub list: Vec<T>,
    pub buffer: Option<ResourceId>,
}

impl<T> Default for Mirror<T> {
    fn default() -> Self {
        Self { list: vec![], buffer: None }
    }
}

impl<T: bytemuck::NoUninit> Mirror<T> {
    /// Records what differs; returns whether anything did. The buffer has room for one element at least: there is
    /// something to bind however few there are.
    pub fn update(&mut self, label: &'static str, list: Vec<T>, recording: &mut Recording) -> bool {
        let bytes = |list: &[T]| -> Vec<u8> { bytemuck::cast_slice(list).to_vec() };
        let same = bytes(&list) == bytes(&self.list);
        if self.buffer.is_some() && same {
            return false;
        }
        if list.len() != self.list.len() {
            recording.free(self.buffer.take());
        }
        let size = (size_of::<T>() * list.len().max(1)) as u64;
        let id = *self.buffer.get_or_insert_with(|| recording.create_buffer(label, size));
        if !list.is_empty() {
            recording.push(Step::WriteBuffer { id, offset: 0, data: Payload::copy_of(&list) });
        }
        self.list = list;
        !same
    }

    pub fn free(&mut self, recording: &mut Recording) {
        recording.free(self.buffer.take());
    }
}

/// What shares one with others.
#[derive(Debug)]
pub(super) struct Part<T> {
    pub list: Arc<[T]>,
    /// The buffer, and its first byte there.
    place: Option<(ResourceId, u64)>,
}

impl<T> Default for Part<T> {
    fn default() -> Self {
        Self { list: Arc::new([]), place: None }
    }
}

impl<T: bytemuck::NoUninit + Send + Sync> Part<T> {
    /// Bytes to set aside for so many elements.
    pub fn room(count: usize) -> u64 {
        (size_of::<T>() * count) as u64
    }

    /// The same with a few more: not each that comes is to take another buffer.
    pub fn ample_room(count: usize) -> u64 {
        Self::room(count.next_power_of_two().max(8))
    }

    /// Sees to it that all of it is where it has room for so many. More than that are to be replaced soon.
    pub fn put(&mut self, buffer: ResourceId, offset: u64, count: usize, recording: &mut Recording) {
        if self.place != Some((buffer, offset)) {
            self.place = Some((buffer, offset));
            if self.list.len() <= count {
                self.write(recording);
            }
        }
    }

    /// Records what differs; returns whether anything did. There is room for it where it [was put](Self::put).
    pub fn update(&mut self, list: Arc<[T]>, recording: &mut Recording) -> bool {
        let bytes = bytemuck::cast_slice::<T, u8>;
        if Arc::ptr_eq(&list, &self.list) || bytes(&list) == bytes(&self.list) {
            return false;
        }
        self.list = list;
        self.write(recording);
        true
    }

    /// Its first byte in the buffer.
    pub fn offset(&self) -> u64 {
        self.place.map_or(0, |(_, offset)| offset)
    }

    fn write(&self, recording: &mut Recording) {
        if let Some((id, offset)) = self.place.filter(|_| !self.list.is_empty()) {
            let data = Payload::new(Bytes(self.list.clone()));
            recording.push(Step::WriteBuffer { id, offset, data });
        }
    }
}

struct Bytes<T>(Arc<[T]>);

impl<T: bytemuck::NoUninit> AsRef<[u8]> for Bytes<T> {
    fn as_ref(&self) -> &[u8] {
        bytemuck::cast_slice(&self.0)
    }
}
