//! The frames of a file as they are stored: opened, found, unpacked from bits.

use std::io;

use lumivox_core::CancelToken;

use super::{
    codec::CodecFault,
    header::{self, ImageFile, PixelFormat},
    source::Input,
};
use crate::ImportError;

/// Opens a file at the value of its pixel data. Reading fails once `cancel` is cancelled.
///
/// # Errors
/// [`ImportError::Damaged`] or [`ImportError::Io`].
pub(crate) fn open_pixels(file: &ImageFile, cancel: &CancelToken) -> Result<Input, ImportError> {
    let open = || {
        let mut input = file.source.open_cancellable(cancel)?;
        if let Some(start) = file.format.deflated_from {
            input.skip(start)?;
            input = input.inflate(Vec::new());
        }
        input.skip(file.format.offset)?;
        Ok(input)
    };
    open().map_err(|fault| reading(file, &fault))
}

/// The error about pixel data that could not be read.
pub(crate) fn reading(file: &ImageFile, fault: &io::Error) -> ImportError {
    let path = file.source.path();
    match fault.kind() {
        io::ErrorKind::UnexpectedEof => {
            ImportError::Damaged { path, problem: "ends in the middle of its pixel data".to_owned() }
        }
        io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput | io::ErrorKind::Other => {
            ImportError::Damaged { path, problem: format!("cannot be unpacked ({fault})") }
        }
        kind => ImportError::Io { path, source: io::Error::new(kind, fault.to_string()) },
    }
}

/// The error about a frame that could not be decoded.
pub(crate) fn decoding(file: &ImageFile, fault: CodecFault) -> ImportError {
    match fault {
        CodecFault::Damaged(problem) => ImportError::Damaged { path: file.source.path(), problem },
        CodecFault::Unsupported(what) => header::undecodable(&file.source, what),
    }
}

/// Reads frames that are not compressed, in rising order.
pub(crate) struct NativeFrames<'a> {
    format: &'a PixelFormat,
    input: &'a mut Input,
    start: u64,
    buffer: Vec<u8>,
    /// All frames of single bits, since they do not begin at whole bytes.
    bits: Option<Vec<u8>>,
}

impl<'a> NativeFrames<'a> {
    /// `input` is at the first frame.
    pub(crate) fn new(format: &'a PixelFormat, input: &'a mut Input) -> Self {
        let start = input.position();
        Self { format, input, start, buffer: Vec::new(), bits: None }
    }

    /// Frame `index`: samples in the file's byte order, [`PixelFormat::bytes`] each.
    ///
    /// # Errors
    /// What the system or a stream's decoder says; an early end is [`io::ErrorKind::UnexpectedEof`].
    pub(crate) fn read(&mut self, index: usize) -> io::Result<&[u8]> {
        self.buffer.resize(self.format.frame_bytes(), 0);
        if self.format.packed {
            self.unpack_bits(index)?;
            return Ok(&self.buffer);
        }
        self.skip_to(index)?;
        self.input.read_exact(&mut self.buffer)?;
        if self.format.swapped_pairs {
            self.buffer.chunks_exact_mut(2).for_each(|pair| pair.swap(0, 1));
        }
        Ok(&self.buffer)
    }

    /// Frame `index` of samples of 16 bits, in the file's byte order.
    ///
    /// # Errors
    /// As [`NativeFrames::read`].
    pub(crate) fn read_words(&mut self, index: usize, words: &mut [u16]) -> io::Result<()> {
        self.skip_to(index)?;
        self.input.read_exact(bytemuck::cast_slice_mut(words))
    }

    fn skip_to(&mut self, index: usize) -> io::Result<()> {
        let at = self.start + (index * self.format.frame_bytes()) as u64;
        // Only behind a frame that failed is the input elsewhere.
        let step = at.checked_sub(self.input.position()).ok_or(io::ErrorKind::UnexpectedEof)?;
        self.input.skip(step)
    }

    fn unpack_bits(&mut self, index: usize) -> io::Result<()> {
        let samples = self.buffer.len();
        if self.bits.is_none() {
            let all = (samples as u64).saturating_mul(self.format.frames as u64).div_ceil(8);
            let there = self.input.remaining().map_or(all, |remaining| remaining.min(all));
            self.bits = Some(self.input.read_vec(there)?);
        }
        let bits = self.bits.as_deref().unwrap_or_default();
        let first = index * samples;
        if (first + samples).div_ceil(8) > bits.len() {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        // The first sample is the lowest bit (PS3.5 8.1.1); big endian words are swapped.
        let swap = usize::from(self.format.big_endian);
        for (i, sample) in self.buffer.iter_mut().enumerate() {
            let bit = first + i;
            let byte = bits.get((bit / 8) ^ swap).copied().unwrap_or(0);
            *sample = (byte >> (bit % 8)) & 1;
        }
        Ok(())
    }
}
