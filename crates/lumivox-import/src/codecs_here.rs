//! Decoders in this process, where there are no others.

use lumivox_core::CancelToken;

use crate::codec::{self, CodecFault, Decoded, FrameShape};

/// The decoders of one import.
pub(crate) struct Codecs;

impl Codecs {
    pub(crate) fn new(_: usize, _: &CancelToken) -> Self {
        Self
    }

    /// Decodes one frame.
    ///
    /// # Errors
    /// [`CodecFault`].
    pub(crate) fn decode(&self, stream: &[u8], shape: &FrameShape) -> Result<Decoded, CodecFault> {
        codec::decode(stream, shape)
    }
}
