//! Samples that are written as characters, as the bytes that they stand for.

use std::io::{self, BufRead, Read};

use crate::sample::SampleType;

/// Bytes that are written as two hexadecimal digits each.
pub(crate) struct HexBytes<R>(pub R);

impl<R: BufRead> HexBytes<R> {
    /// The next digit; none at the end.
    fn digit(&mut self) -> io::Result<Option<u8>> {
        loop {
            let Some(&byte) = self.0.fill_buf()?.first() else { return Ok(None) };
            self.0.consume(1);
            match (byte as char).to_digit(16) {
                Some(digit) => return Ok(Some(digit as u8)),
                None if byte.is_ascii_whitespace() => {}
                None => {
                    let message = "it is not a list of hexadecimal digits";
                    return Err(io::Error::new(io::ErrorKind::InvalidData, message));
                }
            }
        }
    }
}

impl<R: BufRead> Read for HexBytes<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        for (filled, byte) in buffer.iter_mut().enumerate() {
            let (Some(high), Some(low)) = (self.digit()?, self.digit()?) else { return Ok(filled) };
            *byte = high << 4 | low;
        }
        Ok(buffer.len())
    }
}

/// Decimal numbers, read as the bytes of the type that the header names.
pub(crate) struct TextSamples<R> {
    input: R,
    sample: SampleType,
    big_endian: bool,
    pending: Vec<u8>,
}

impl<R: BufRead> TextSamples<R> {
    pub fn new(input: R, sample: SampleType, big_endian: bool) -> Self {
        Self { input, sample, big_endian, pending: Vec::new() }
    }

    /// The next number's characters; none at the end.
    fn token(&mut self) -> io::Result<String> {
        /// Longer than any number that a program writes.
        const LONGEST: usize = 400;
        let mut token = String::new();
        loop {
            let buffer = self.input.fill_buf()?;
            let Some(&byte) = buffer.first() else { return Ok(token) };
            self.input.consume(1);
            if byte.is_ascii_whitespace() || byte == b',' {
                if !token.is_empty() {
                    return Ok(token);
                }
            } else {
                token.push(byte as char);
                if token.len() > LONGEST {
                    return Err(io::Error::new(io::ErrorKind::InvalidData, "it is not a list of numbers"));
                }
            }
        }
    }

    fn encode(&self, token: &str) -> Option<Vec<u8>> {
        macro_rules! bytes {
            ($type:ty) => {
                token.parse::<$type>().ok()?.to_le_bytes().to_vec()
            };
        }
        let mut bytes = match self.sample {
            SampleType::U8 => bytes!(u8),
            SampleType::I8 => bytes!(i8),
            SampleType::U16 => bytes!(u16),
            SampleType::I16 => bytes!(i16),
            SampleType::U32 => bytes!(u32),
            SampleType::I32 => bytes!(i32),
            SampleType::U64 => bytes!(u64),
            SampleType::I64 => bytes!(i64),
            SampleType::F32 => bytes!(f32),
            SampleType::F64 => bytes!(f64),
        };
        if self.big_endian {
            bytes.reverse();
        }
        Some(bytes)
    }
}

impl<R: BufRead> Read for TextSamples<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.pending.is_empty() {
            let token = self.token()?;
            if token.is_empty() {
                return Ok(0);
            }
            self.pending = self.encode(&token).ok_or_else(|| {
                let message = format!("'{token}' is no number of type {}", self.sample);
                io::Error::new(io::ErrorKind::InvalidData, message)
            })?;
        }
        let n = self.pending.len().min(buffer.len());
        buffer[..n].copy_from_slice(&self.pending[..n]);
        self.pending.drain(..n);
        Ok(n)
    }
}
