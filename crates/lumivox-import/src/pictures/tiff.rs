//! Pages of TIFF files.

use std::{
    io::BufReader,
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use lumivox_core::CancelToken;
use tiff::{
    ColorType, TiffError,
    decoder::{Decoder, DecodingSampleType, Limits, ifd::Value},
    tags::Tag,
};

use super::{MOST_PICTURES, Shape, damaged};
use crate::{error::ImportError, files::File, sample::SampleType};

/// What the decoder may take for a strip or tile, and for a value.
const MEMORY: usize = 512 << 20;
const LONGEST_VALUE: usize = 16 << 20;

/// ResolutionUnit of inches.
const INCH: u32 = 2;

/// What a file's headers say.
pub(super) struct Document {
    pub(super) shape: Shape,
    pub(super) pages: usize,
    /// ImageDescription of the first page, in which programs leave what TIFF has no field for.
    pub(super) description: Description,
    pub(super) notes: Vec<String>,
}

/// What the first page says beside its picture.
#[derive(Debug, Default)]
pub(super) struct Description {
    pub(super) text: String,
    /// Pixels in a unit of length, along x and y.
    pub(super) resolution: Option<[f64; 2]>,
}

type Pages = Decoder<BufReader<File>>;

fn open(path: &Path) -> Result<Pages, ImportError> {
    let file = BufReader::new(File::open(path).map_err(ImportError::io(path))?);
    let mut limits = Limits::default();
    // Of texts, too: pictures have memory of their own.
    limits.decoding_buffer_size = LONGEST_VALUE;
    limits.intermediate_buffer_size = MEMORY;
    limits.ifd_value_size = LONGEST_VALUE;
    Ok(Decoder::new(file).map_err(|fault| of(path, fault))?.with_limits(limits))
}

fn of(path: &Path, fault: TiffError) -> ImportError {
    match fault {
        TiffError::UnsupportedError(what) => unsupported(path, &format!("a TIFF that is not read ({what})")),
        fault => damaged(path, &format!("is a damaged TIFF ({fault})")),
    }
}

fn unsupported(path: &Path, what: &str) -> ImportError {
    ImportError::Unsupported {
        path: path.to_owned(),
        what: what.to_owned(),
        remedy: "Save it as grey values of 8 or 16 bits, uncompressed or deflated, for example with Fiji"
            .to_owned(),
    }
}

/// Reads the headers of all pages.
pub(super) fn read(path: &Path, cancel: &CancelToken) -> Result<Document, ImportError> {
    let mut pages = open(path)?;
    let shape = shape(path, &mut pages)?;
    // Rational by the standard; some programs write floats.
    let resolution = |pages: &mut Pages, tag| {
        let per_unit = match pages.get_tag(tag).ok()? {
            Value::Rational(pixels, units) => f64::from(pixels) / f64::from(units),
            Value::Float(pixels) => pixels.into(),
            Value::Double(pixels) => pixels,
            _ => return None,
        };
        Some(per_unit).filter(|pixels| pixels.is_finite() && *pixels > 0.0)
    };
    let resolution = resolution(&mut pages, Tag::XResolution).zip(resolution(&mut pages, Tag::YResolution));
    // Programs that know of no distance write 72 dots an inch.
    let is_inch = pages.get_tag_u32(Tag::ResolutionUnit).is_ok_and(|unit| unit == INCH);
    let resolution = resolution.filter(|both| !(is_inch && *both == (72.0, 72.0)));
    let description = Description {
        text: pages.get_tag_ascii_string(Tag::ImageDescription).unwrap_or_default(),
        resolution: resolution.map(|(x, y)| [x, y]),
    };
    let mut count = 1;
    let mut notes = Vec::new();
    while pages.more_images() {
        cancel.check()?;
        if count == MOST_PICTURES {
            return Err(unsupported(path, &format!("a TIFF of more than {MOST_PICTURES} pages")));
        }
        pages.next_image().map_err(|fault| of(path, fault))?;
        // Behind the slices some programs keep a picture of another size, to show which file it is.
        if self::shape(path, &mut pages)? != shape {
            notes.push(format!("pages from number {} on, which have another size, are left out", count + 1));
            break;
        }
        count += 1;
    }
    Ok(Document { shape, pages: count, description, notes })
}

/// What the current page is made of.
fn shape(path: &Path, pages: &mut Pages) -> Result<Shape, ImportError> {
    let (width, height) = pages.dimensions().map_err(|fault| of(path, fault))?;
    let color = pages.colortype().map_err(|fault| of(path, fault))?;
    let layout = pages.image_buffer_layout().map_err(|fault| of(path, fault))?;
    let channels = match color {
        ColorType::Gray(8..) | ColorType::Palette(8..) => 1,
        ColorType::GrayA(8..) => 2,
        ColorType::RGB(8..) => 3,
        ColorType::RGBA(8..) => 4,
        ColorType::Multiband { bit_depth: 8.., num_samples: 1 } => 1,
        other => {
            return Err(unsupported(
                path,
                &format!("a TIFF of another kind of pixels than grey and colours ({other:?})"),
            ));
        }
    };
    let sample = match layout.sample_type {
        Some(DecodingSampleType::U8) => SampleType::U8,
        Some(DecodingSampleType::I8) => SampleType::I8,
        Some(DecodingSampleType::U16) => SampleType::U16,
        Some(DecodingSampleType::I16) => SampleType::I16,
        Some(DecodingSampleType::U32) => SampleType::U32,
        Some(DecodingSampleType::I32) => SampleType::I32,
        Some(DecodingSampleType::U64) => SampleType::U64,
        Some(DecodingSampleType::I64) => SampleType::I64,
        Some(DecodingSampleType::F32) => SampleType::F32,
        Some(DecodingSampleType::F64) => SampleType::F64,
        _ => return Err(unsupported(path, "a TIFF of an unusual type of numbers")),
    };
    let shape = Shape { width: width as usize, height: height as usize, sample, channels };
    // Of 12 bits in 16, and of planes for each colour, lengths differ.
    if layout.planes != 1 || Some(layout.len) != shape.bytes() {
        return Err(unsupported(path, "a TIFF whose samples are packed, or in a plane for each colour"));
    }
    Ok(shape)
}

/// Decodes pages: each of several files has one, or one file has all.
pub(super) struct Source {
    paths: Vec<PathBuf>,
    /// The file that was read last: its pages follow each other.
    last: Mutex<Option<(usize, Pages)>>,
}

impl Source {
    pub(super) fn new(paths: Vec<PathBuf>) -> Self {
        Self { paths, last: Mutex::new(None) }
    }

    /// The file that a picture is in, and which page of it.
    fn place(&self, index: usize) -> (usize, usize) {
        if self.paths.len() == 1 { (0, index) } else { (index, 0) }
    }
}

impl super::Source for Source {
    fn decode(&self, index: usize, out: &mut [u8]) -> Result<(), ImportError> {
        let (file, page) = self.place(index);
        let path = &self.paths[file];
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let mut pages = match last.take() {
            Some((own, pages)) if own == file => pages,
            _ => open(path)?,
        };
        pages.seek_to_image(page).map_err(|fault| of(path, fault))?;
        if shape(path, &mut pages)?.bytes() != Some(out.len()) {
            return Err(damaged(path, "is not as large as its header said"));
        }
        pages.read_image_bytes(out).map_err(|fault| of(path, fault))?;
        // The decoder gives samples in this machine's order.
        if cfg!(target_endian = "big") {
            let bytes = shape(path, &mut pages)?.sample.bytes();
            out.chunks_exact_mut(bytes).for_each(<[u8]>::reverse);
        }
        *last = Some((file, pages));
        Ok(())
    }

    fn path(&self, index: usize) -> &Path {
        &self.paths[self.place(index).0]
    }
}
