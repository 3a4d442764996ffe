//! A list that the GPU has a copy of.

use crate::recording::{Payload, Recording, ResourceId, Step};

/// What is in a storage buffer.
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
