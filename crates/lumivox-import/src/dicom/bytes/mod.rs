//! Floor: where the bytes of a file come from, and the fragments that compressed frames are made of.

pub(super) mod fragments;
pub(super) mod source;
