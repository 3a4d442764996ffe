//! Bytes as the engine takes them, in memory that is used again. On the render thread.

use std::cell::RefCell;

use godot::prelude::*;

/// Bytes that are worth keeping: few cost little, and more than what a frame brings is not kept.
const KEPT: std::ops::RangeInclusive<usize> = 64 << 10..=4 << 20;

thread_local! {
    // Nothing before it is used, and after `free`: what the engine made goes while that is up.
    static USED: RefCell<Option<PackedByteArray>> = const { RefCell::new(None) };
}

/// A copy of `bytes`; who keeps it keeps it as it is. Its memory is that of the copy before, if nobody does: new memory
/// costs a fault for every page of it, a millisecond for what a frame brings.
pub fn copy_of(bytes: &[u8]) -> PackedByteArray {
    if !KEPT.contains(&bytes.len()) {
        return bytes.into();
    }
    USED.with_borrow_mut(|used| {
        let used = used.get_or_insert_default();
        if used.len() != bytes.len() {
            used.resize(bytes.len());
        }
        used.as_mut_slice().copy_from_slice(bytes);
        used.clone()
    })
}

/// Gives the memory back.
pub fn free() {
    drop(USED.take());
}
