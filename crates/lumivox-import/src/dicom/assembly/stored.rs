//! The frames of a file as they are stored: opened, found, unpacked from bits.

use std::io;

use lumivox_core::CancelToken;

use crate::{
    ImportError,
    codec::CodecFault,
    dicom::{
        bytes::source::Input,
        header::pixel_format::{PixelFormat, undecodable},
        images::image_file::ImageFile,
    },
};

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
        CodecFault::Unsupported(what) => undecodable(&file.source, what),
    }
}

/// Reads frames that are not compressed, in rising order.
pub(crate) struct NativeFrames<'a> {
    format: &'a PixelFormat,
    input: &'a mut Input,
    start: u64,
    buffer: Vec<u8>,
    /// All frames of packed samples, since they do not begin at whole bytes.
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
        if let Some(bits) = self.format.packed {
            self.unpack_bits(index, bits)?;
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

    /// Unpacks the samples of frame `index`, `each` bits of every one.
    fn unpack_bits(&mut self, index: usize, each: usize) -> io::Result<()> {
        let samples = self.format.frame_len();
        if self.bits.is_none() {
            let of_frame = (samples as u64).saturating_mul(each as u64);
            let all = of_frame.saturating_mul(self.format.frames as u64).div_ceil(8);
            let there = self.input.remaining().map_or(all, |remaining| remaining.min(all));
            self.bits = Some(self.input.read_vec(there)?);
        }
        let bits = self.bits.as_deref().unwrap_or_default();
        let first = index * samples;
        if ((first + samples) * each).div_ceil(8) > bits.len() {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        // The first sample is in the lowest bits (PS3.5 8.1.1); big endian words are swapped.
        let swap = usize::from(self.format.swapped_pairs);
        let byte = |at: usize| u16::from(bits.get(at ^ swap).copied().unwrap_or(0));
        for (i, sample) in self.buffer.chunks_exact_mut(self.format.bytes).enumerate() {
            let bit = (first + i) * each;
            let low = (byte(bit / 8) | byte(bit / 8 + 1) << 8) >> (bit % 8);
            match sample {
                [one] => *one = (low & 1) as u8,
                two if self.format.big_endian => two.copy_from_slice(&(low & 0xFFF).to_be_bytes()),
                two => two.copy_from_slice(&(low & 0xFFF).to_le_bytes()),
            }
        }
        Ok(())
    }
}
