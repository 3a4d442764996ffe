//! Bounds of what is read, on machines of 32 bits too: a browser's memory has no more.

/// So many bytes or things, or as many as memory can have addresses for.
pub(crate) const fn at_most(count: u64) -> usize {
    // No allocation is larger than that.
    if count > isize::MAX as u64 { isize::MAX as usize } else { count as usize }
}
