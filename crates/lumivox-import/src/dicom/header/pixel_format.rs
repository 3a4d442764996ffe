//! How a file's samples are stored, and which of its frames are there.

use std::sync::Arc;

use crate::{
    ImportError,
    codec::{Encoding, FrameShape},
    dicom::{
        bytes::source::Source,
        elements::{
            attributes::{self as attr, Attribute},
            data_set::{DataSet, Header, PixelElement},
            values::FieldFault,
        },
        header::{
            frame_counts::{FramesThere, frame_counts, missing_frames},
            modality_lut::ModalityLut,
            refusal::Refusal,
            segments,
        },
    },
};

/// GE's own transfer syntax: implicit little endian, but samples of the pixels are big endian.
const GE_PRIVATE: &str = "1.2.840.113619.5.2";

const DECOMPRESS: &str = "Lumivox cannot decode that: convert it to an uncompressed transfer syntax, for example with DCMTK's 'dcmdjpeg' or with 'gdcmconv --raw'";

/// How a picture is tiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mosaic {
    /// Tiles from left to right.
    pub(crate) across: usize,
    /// Tiles from top to bottom.
    pub(crate) down: usize,
    /// Tiles that are slices; the last ones are empty.
    pub(crate) slices: usize,
}

/// What a sample is before any rescale.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SampleKind {
    /// Integers of [`PixelFormat::bytes`].
    Integer,
    /// `FloatPixelData` and `DoubleFloatPixelData`.
    Float,
}

/// How a file's samples are stored.
#[derive(Clone, Debug)]
pub(crate) struct PixelFormat {
    /// Of a slice; a tile where the picture is a mosaic.
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// How a picture is made of slices, if it is.
    pub(crate) mosaic: Option<Mosaic>,
    pub(crate) kind: SampleKind,
    /// Bytes of a sample: 1, 2, 4 or 8.
    pub(crate) bytes: usize,
    /// Bits of a sample (1 or 12) where they follow each other, frame after frame without a gap.
    pub(crate) packed: Option<usize>,
    /// Whether samples are single bits.
    pub(crate) single_bits: bool,
    pub(crate) bits_stored: u32,
    pub(crate) high_bit: u32,
    pub(crate) signed: bool,
    /// MONOCHROME1: the lowest value is shown white.
    pub(crate) inverted: bool,
    pub(crate) big_endian: bool,
    /// Whether bits beside the stored ones hold an overlay (retired in 2004), and no part of a number.
    pub(crate) has_overlay: bool,
    /// Samples of less than 16 bits in big endian 16-bit words, pairwise swapped.
    pub(crate) swapped_pairs: bool,
    pub(crate) encoding: Encoding,
    /// Frames that the file says it has.
    pub(crate) frames: usize,
    /// Raw samples, lowest and highest, that mean `nothing was measured here`.
    pub(crate) padding: Option<[u32; 2]>,
    /// A floating-point sample that means the same.
    pub(crate) float_padding: Option<f64>,
    /// What makes values of samples, in place of slope and intercept.
    pub(crate) lut: Option<Arc<ModalityLut>>,
    /// Where the frames of encapsulated pixel data start by the extended offset table; mostly empty.
    pub(crate) frame_offsets: Vec<u64>,
    /// Offset of the pixel data's value.
    pub(crate) offset: u64,
    /// Where a deflated data set starts in the file.
    pub(crate) deflated_from: Option<u64>,
}

impl PixelFormat {
    /// Bytes of one frame, decoded.
    pub(crate) fn frame_bytes(&self) -> usize {
        self.frame_len() * self.bytes
    }

    /// Samples of one frame.
    pub(crate) fn frame_len(&self) -> usize {
        let [columns, rows] = self.picture();
        columns * rows
    }

    /// Columns and rows of one frame, which are more than a slice's where it is a mosaic.
    pub(crate) fn picture(&self) -> [usize; 2] {
        let [across, down] = self.mosaic.map_or([1, 1], |mosaic| [mosaic.across, mosaic.down]);
        [self.columns * across, self.rows * down]
    }

    /// What a codec has to know of a frame.
    pub(crate) fn shape(&self) -> FrameShape {
        let [columns, rows] = self.picture();
        FrameShape {
            encoding: self.encoding,
            columns,
            rows,
            bytes: self.bytes,
            single_bits: self.single_bits,
        }
    }

    /// Slices in one frame.
    pub(crate) fn slices_in_frame(&self) -> usize {
        self.mosaic.map_or(1, |mosaic| mosaic.slices)
    }
}

/// The error about a compression that no decoder is there for.
pub(crate) fn undecodable(source: &Source, what: String) -> ImportError {
    ImportError::Unsupported { path: source.path(), what, remedy: DECOMPRESS.to_owned() }
}

/// The pixel format, and how many of its frames are there.
pub(crate) fn pixel_format(
    header: &Header,
    notes: &mut Vec<String>,
) -> Result<(PixelFormat, FramesThere), Refusal> {
    let data = &header.data;
    let pixels = grey_pixels(header)?;
    let (rows, columns) = (side(data, attr::ROWS)?, side(data, attr::COLUMNS)?);
    let Bits { allocated, stored, high } = Bits::of(data, pixels.attribute)?;
    let encoding = encoding(header, &pixels)?;
    let (frames, there) = frame_counts(data, &pixels, [columns, rows, allocated as usize], encoding)?;
    notes.extend(wrong_length(&pixels, encoding, there));
    notes.extend(missing_frames(frames, there));
    if frames > 1 && data.bytes(attr::NUMBER_OF_FRAMES).is_none() {
        notes.push(format!("NumberOfFrames is not given; the file describes {frames}"));
    }
    let format = PixelFormat {
        columns,
        rows,
        kind: if pixels.attribute == attr::PIXEL_DATA { SampleKind::Integer } else { SampleKind::Float },
        bytes: allocated.div_ceil(8) as usize,
        packed: (encoding == Encoding::Native && [1, 12].contains(&allocated)).then_some(allocated as usize),
        single_bits: allocated == 1,
        mosaic: None,
        bits_stored: stored,
        high_bit: high,
        signed: data.unsigned(attr::PIXEL_REPRESENTATION) == Some(1),
        inverted: photometric(data) == "MONOCHROME1",
        big_endian: data.big_endian || header.transfer_syntax == GE_PRIVATE,
        has_overlay: data.unsigned(attr::OVERLAY_BIT_POSITION).is_some_and(|bit| bit > 0),
        swapped_pairs: data.big_endian && allocated < 16 && pixels.words,
        encoding,
        frames,
        padding: data.unsigned(attr::PIXEL_PADDING_VALUE).map(|value| {
            // Either may be the lower one.
            [value, data.unsigned(attr::PIXEL_PADDING_RANGE_LIMIT).unwrap_or(value)]
        }),
        float_padding: match pixels.attribute {
            attr::FLOAT_PIXEL_DATA => data.float(attr::FLOAT_PIXEL_PADDING_VALUE),
            attr::DOUBLE_FLOAT_PIXEL_DATA => data.float(attr::DOUBLE_FLOAT_PIXEL_PADDING_VALUE),
            _ => None,
        },
        lut: None,
        frame_offsets: frame_offsets(data),
        offset: pixels.offset,
        deflated_from: header.deflated_from,
    };
    Ok((format, there))
}

/// The pixel data of an image with physical values; a refusal of everything else.
fn grey_pixels(header: &Header) -> Result<PixelElement, Refusal> {
    const OTHER_FILES: &str = "Open the series of images that it belongs to";
    let unsupported = |what: &str, remedy| Err(Refusal::Unsupported(what.to_owned(), remedy));
    let data = &header.data;
    if header.is_directory {
        return unsupported("it is a DICOMDIR, an index of other files", "Open the folder that it lies in");
    }
    let Some(pixels) = header.pixels else {
        return unsupported(without_pixels(data), OTHER_FILES);
    };
    // Of labels a palette says how they are best shown.
    if photometric(data) == "PALETTE COLOR" && !segments::is_segmentation(data) {
        return unsupported("a colour image (by a palette), which has no physical values", OTHER_FILES);
    }
    if data.unsigned(attr::SAMPLES_PER_PIXEL).unwrap_or(1) != 1 {
        return unsupported("a colour image, which has no physical values", OTHER_FILES);
    }
    Ok(pixels)
}

fn photometric(data: &DataSet) -> String {
    data.text(attr::PHOTOMETRIC_INTERPRETATION).unwrap_or_default()
}

/// Rows or columns.
fn side(data: &DataSet, attribute: Attribute) -> Result<usize, FieldFault> {
    match data.unsigned(attribute) {
        None => Err(FieldFault::missing(attribute)),
        Some(n @ 1..=65535) => Ok(n as usize),
        Some(n) => Err(FieldFault::new(attribute, format!("is {n}, not a length from 1 to 65535"))),
    }
}

/// Which bits of a sample mean something.
struct Bits {
    allocated: u32,
    stored: u32,
    high: u32,
}

impl Bits {
    /// Of samples in `pixels`: PixelData, or one of those that hold floats.
    fn of(data: &DataSet, pixels: Attribute) -> Result<Self, FieldFault> {
        let allocated = match pixels {
            attr::FLOAT_PIXEL_DATA => 32,
            attr::DOUBLE_FLOAT_PIXEL_DATA => 64,
            _ => match data.unsigned(attr::BITS_ALLOCATED) {
                None => return Err(FieldFault::missing(attr::BITS_ALLOCATED)),
                Some(bits @ (1 | 8 | 12 | 16 | 32)) => bits,
                Some(bits) => {
                    let problem = format!("is {bits}, not 1, 8, 12, 16 or 32");
                    return Err(FieldFault::new(attr::BITS_ALLOCATED, problem));
                }
            },
        };
        let stored = data.unsigned(attr::BITS_STORED).unwrap_or(allocated);
        if stored == 0 || stored > allocated {
            let problem = format!("is {stored} where {allocated} bits are allocated");
            return Err(FieldFault::new(attr::BITS_STORED, problem));
        }
        let high = data.unsigned(attr::HIGH_BIT).unwrap_or(stored - 1);
        if high >= allocated || high + 1 < stored {
            let problem = format!("is {high} where {stored} of {allocated} bits are stored");
            return Err(FieldFault::new(attr::HIGH_BIT, problem));
        }
        Ok(Self { allocated, stored, high })
    }
}

/// How frames are compressed, if they are, in a way that is known.
fn encoding(header: &Header, pixels: &PixelElement) -> Result<Encoding, Refusal> {
    if pixels.length.is_some() {
        return Ok(Encoding::Native);
    }
    let encoding = Encoding::of_transfer_syntax(&header.transfer_syntax)
        .map_err(|name| Refusal::Unsupported(format!("it is compressed as {name}"), DECOMPRESS))?;
    match encoding.left_out() {
        Some(codec) => Err(Refusal::Unsupported(codec.what.to_owned(), codec.remedy)),
        None => Ok(encoding),
    }
}

/// What to tell of a declared length that reaches beyond the end of the file, where all frames that count are there.
fn wrong_length(pixels: &PixelElement, encoding: Encoding, frames: FramesThere) -> Option<String> {
    let (declared, there) = (pixels.length?, pixels.available?);
    // One byte of padding is often left out.
    let is_wrong = encoding == Encoding::Native && frames.is_ok() && declared > there.saturating_add(1);
    is_wrong.then(|| {
        format!(
            "{} declares {declared} bytes where the file has {there} left; read by the size of the image instead",
            pixels.attribute
        )
    })
}

/// What a DICOM file without pixels is.
fn without_pixels(data: &DataSet) -> &'static str {
    let sop_class = data.text(attr::SOP_CLASS_UID).unwrap_or_default();
    match sop_class.strip_prefix("1.2.840.10008.5.1.4.1.1.") {
        Some("66") => "raw data of a scanner, which hold no image",
        Some("66.1" | "66.2" | "66.3") => "a registration or fiducials, which hold no image",
        Some("66.5") => "a surface segmentation, which holds no image",
        Some("481.3") => "an RT structure set (contours), which holds no image",
        Some("481.5" | "481.8") => "a radiotherapy plan, which holds no image",
        Some(sr) if sr.starts_with("88.") => "a structured report, which holds no image",
        Some(pr) if pr.starts_with("11.") => "a presentation state, which holds no image",
        Some("104.1") => "a PDF document",
        _ => "it holds no image",
    }
}

/// The extended offset table.
fn frame_offsets(data: &DataSet) -> Vec<u64> {
    let bytes = data.bytes(attr::EXTENDED_OFFSET_TABLE).unwrap_or_default();
    bytes
        .chunks_exact(8)
        .map(|b| u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]))
        .collect()
}
