//! Slices as PNG.

use std::{
    io::BufReader,
    path::{Path, PathBuf},
};

use png::{BitDepth, ColorType, Decoder, DecodingError, Limits, Reader, Transformations};

use super::{Shape, damaged};
use crate::{error::ImportError, files::File, sample::SampleType};

/// What the decoder may take beside the picture itself.
const MEMORY: usize = 64 << 20;

pub(super) struct Source(pub(super) Vec<PathBuf>);

fn open(path: &Path) -> Result<Reader<BufReader<File>>, ImportError> {
    let file = BufReader::new(File::open(path).map_err(ImportError::io(path))?);
    let mut decoder = Decoder::new_with_limits(file, Limits { bytes: MEMORY });
    // Palettes become colours, fewer bits eight.
    decoder.set_transformations(Transformations::EXPAND);
    decoder.read_info().map_err(|fault| of(path, &fault))
}

fn of(path: &Path, fault: &DecodingError) -> ImportError {
    damaged(path, &format!("is a damaged PNG ({fault})"))
}

/// What a file's header says.
pub(super) fn shape(path: &Path) -> Result<Shape, ImportError> {
    let reader = open(path)?;
    let (width, height) = reader.info().size();
    let (color, depth) = reader.output_color_type();
    Ok(Shape {
        width: width as usize,
        height: height as usize,
        sample: if depth == BitDepth::Sixteen { SampleType::U16 } else { SampleType::U8 },
        channels: match color {
            ColorType::Grayscale | ColorType::Indexed => 1,
            ColorType::GrayscaleAlpha => 2,
            ColorType::Rgb => 3,
            ColorType::Rgba => 4,
        },
    })
}

impl super::Source for Source {
    fn decode(&self, index: usize, out: &mut [u8]) -> Result<(), ImportError> {
        let path = &self.0[index];
        let mut reader = open(path)?;
        // It may have changed since.
        if reader.output_buffer_size() != Some(out.len()) {
            return Err(damaged(path, "is not as large as its header said"));
        }
        let info = reader.next_frame(out).map_err(|fault| of(path, &fault))?;
        if info.bit_depth == BitDepth::Sixteen {
            out.chunks_exact_mut(2).for_each(|pair| pair.swap(0, 1));
        }
        Ok(())
    }

    fn path(&self, index: usize) -> &Path {
        &self.0[index]
    }
}
