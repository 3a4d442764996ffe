//! One file's header as an image: its pixel format and, frame by frame, the place in the patient.
//!
//! A classic file is an image with one frame. Enhanced multi-frame files say everything frame by frame in functional
//! groups (PS3.3 C.7.6.16), so that each frame is treated like a file of its own from here on.

use std::{
    hash::{DefaultHasher, Hash, Hasher},
    sync::Arc,
};

use lumivox_core::{CancelToken, Cancelled, Modality, Subject};

use super::{
    attributes::{self as attr, Attribute},
    codec::{Encoding, FrameShape},
    elements::{DataSet, Fault, Header, PixelElement, read_header},
    frame_counts::{FramesThere, frame_counts, missing_frames},
    frames::{Frame, frames},
    mosaic::{Layout, Mosaic, is_mosaic},
    multi_frame,
    quantity::{ModalityLut, quantity},
    scan::Rejected,
    segmentation::{self, Segmentation},
    source::Source,
    subject::subject,
    units::{self, Unit},
    values::FieldFault,
    words,
};
use crate::ImportError;

/// Frames that are cut off may always take so many bytes, and beyond it up to [`LOST_RATIO`] times those that are there.
const LOST_AT_LEAST: usize = 64 << 20;
const LOST_RATIO: usize = 8;

/// GE's own transfer syntax: implicit little endian, but samples of the pixels are big endian.
const GE_PRIVATE: &str = "1.2.840.113619.5.2";

const DECOMPRESS: &str = "Lumivox cannot decode that: convert it to an uncompressed transfer syntax, for example with DCMTK's 'dcmdjpeg' or with 'gdcmconv --raw'";

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

/// A file that holds images.
#[derive(Clone, Debug)]
pub(crate) struct ImageFile {
    pub(crate) source: Source,
    pub(crate) series_uid: Option<String>,
    pub(crate) series_number: Option<i64>,
    pub(crate) modality: Modality,
    /// DICOM's code for the modality: `CT`; `other` for an unknown one, empty where there is none.
    pub(crate) modality_code: &'static str,
    pub(crate) is_localizer: bool,
    pub(crate) frame_of_reference: Option<String>,
    /// A number that stands for the patient, so that nobody's own one is kept.
    pub(crate) patient: u64,
    /// SOPInstanceUID.
    pub(crate) instance_uid: Option<String>,
    /// What tells the series from others, in words that are no names: what it is called, how it is weighted or filtered,
    /// when it was made. Some are empty.
    pub(crate) labels: [String; 3],
    /// ConvolutionKernel: images of several make several volumes.
    pub(crate) kernel: Option<String>,
    /// What values are measured in; empty where that is not known.
    pub(crate) unit: Unit,
    /// What it is of, as far as the header says.
    pub(crate) subject: Subject,
    /// What it is where it is no image, but labels.
    pub(crate) segmentation: Option<Segmentation>,
    pub(crate) format: PixelFormat,
    pub(crate) frames: Vec<Frame>,
    /// How many of them have pixels, as far as the header and the file's size tell; the others mark their places.
    pub(crate) whole: usize,
    /// What the header promises of pixel data and what is there, in bytes, where that is not even one frame. Its place
    /// is known all the same.
    pub(crate) truncated: Option<Truncated>,
    /// Whether its frames, if there are several, are moments of one place.
    pub(crate) is_film: bool,
    /// Sentences about liberties taken.
    pub(crate) notes: Vec<String>,
}

/// Pixel data that end before their first frame does, in bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Truncated {
    pub(crate) expected: u64,
    pub(crate) actual: u64,
}

impl ImageFile {
    /// Whether values are Hounsfield units of a CT, of which padding is air.
    pub(crate) fn is_hounsfield(&self) -> bool {
        self.modality == Modality::Ct && self.unit == units::HOUNSFIELD
    }

    /// Whether the pixels of a frame are there, as far as is known before they are read.
    pub(crate) fn has(&self, frame: usize) -> bool {
        frame < self.whole
    }

    /// Whether frames are missing at the end of the file and marked by nothing, so that it is not known what they showed.
    pub(crate) fn is_cut_short(&self) -> bool {
        self.frames.len() < self.format.frames * self.format.slices_in_frame()
    }

    /// The error about pixel data that end before their first frame does.
    pub(crate) fn truncation(&self) -> Option<ImportError> {
        let Truncated { expected, actual } = self.truncated?;
        Some(ImportError::Truncated { path: self.source.path(), expected, actual })
    }
}

/// Reads the header of the image at `source`.
///
/// # Errors
/// [`Rejected`] says why it is not an image that can be part of a volume.
pub(crate) fn read_image(source: &Source, cancel: &CancelToken) -> Result<ImageFile, Box<Rejected>> {
    let path = || source.path();
    let header = read_header(source, cancel).map_err(|fault| match fault {
        Fault::NotDicom(found) => ImportError::UnknownFormat { path: path(), found: found.to_owned() },
        Fault::Damaged(problem) => ImportError::Damaged { path: path(), problem },
        Fault::Io(source) => ImportError::Io { path: path(), source },
    });
    let header = header.map_err(|error| Box::new(Rejected::new(path(), error)))?;
    let result = interpret(source, &header, cancel).map_err(|refusal| match refusal {
        Refusal::Cancelled(cancelled) => cancelled.into(),
        Refusal::Field(FieldFault { attribute, problem, remedy }) => ImportError::Field {
            path: path(),
            field: attribute.to_string(),
            problem,
            remedy: remedy.to_owned(),
        },
        Refusal::Unsupported(what, remedy) => {
            ImportError::Unsupported { path: path(), what, remedy: remedy.to_owned() }
        }
    });
    result.map_err(|error| {
        Box::new(Rejected { series_uid: series_uid(&header.data), ..Rejected::new(path(), error) })
    })
}

fn series_uid(data: &DataSet) -> Option<String> {
    data.text(attr::SERIES_INSTANCE_UID)
}

/// The error about a compression that no decoder is there for.
pub(crate) fn undecodable(source: &Source, what: String) -> ImportError {
    ImportError::Unsupported { path: source.path(), what, remedy: DECOMPRESS.to_owned() }
}

/// Why a header is not that of a usable image.
pub(crate) enum Refusal {
    Field(FieldFault),
    Unsupported(String, &'static str),
    Cancelled(Cancelled),
}

impl From<Cancelled> for Refusal {
    fn from(cancelled: Cancelled) -> Self {
        Refusal::Cancelled(cancelled)
    }
}

impl From<FieldFault> for Refusal {
    fn from(fault: FieldFault) -> Self {
        Refusal::Field(fault)
    }
}

fn interpret(source: &Source, header: &Header, cancel: &CancelToken) -> Result<ImageFile, Refusal> {
    let data = &header.data;
    let mut notes = Vec::new();
    let (mut format, there) = pixel_format(header, &mut notes)?;
    let modality_code = modality_code(data.text(attr::MODALITY).as_deref());
    let modality = match modality_code {
        "CT" => Modality::Ct,
        "MR" => Modality::Mr,
        "PT" => Modality::Pet,
        _ => Modality::Other,
    };
    let image_type = data.texts(attr::IMAGE_TYPE);
    let is_mosaic = is_mosaic(data);
    let layout = is_mosaic.then(|| Layout::of(data, format.columns, format.rows)).flatten();
    let mut frames = frames(data, &format, &mut notes, cancel)?;
    let is_segmentation = segmentation::is_segmentation(data);
    let stacked = if is_segmentation {
        segmentation::number_frames(&mut frames, data)?;
        segmentation::stack_frames(&mut frames, data)?
    } else {
        None
    };
    let has_places = stacked.is_none();
    notes.extend(stacked);
    let whole = there.unwrap_or(0);
    if whole < format.frames && !marks_lost_frames(data, &format, whole) {
        frames.truncate(whole.max(1));
    }
    match layout {
        Some(layout) => {
            format.columns /= layout.mosaic.across;
            format.rows /= layout.mosaic.down;
            format.mosaic = Some(layout.mosaic);
            frames = frames.iter().flat_map(|f| layout.slices(f, format.columns, format.rows)).collect();
            notes.push(format!("a mosaic, parted into its {} slices", layout.mosaic.slices));
        }
        None if is_mosaic => notes.push(
            "a mosaic without the private header that tells its slices: shown as one picture".to_owned(),
        ),
        None => {}
    }
    let quantity = quantity(data, modality, modality_code, &mut frames)?;
    let signed = format.signed;
    format.lut = ModalityLut::of(data, signed)?.map(Arc::new);
    for frame in &mut frames {
        frame.rescale = match &format.lut {
            Some(_) => [quantity.factor, 0.0],
            None => frame.rescale.map(|part| part * quantity.factor),
        };
    }
    notes.extend(quantity.note);
    if format.lut.is_some() {
        notes.push("values are given by a table (ModalityLUTSequence)".to_owned());
    }
    let labels = labels(data, modality, &frames);
    let segmentation = is_segmentation.then(|| Segmentation::of(data, has_places));
    notes.extend(segmentation.iter().flat_map(Segmentation::notes));
    Ok(ImageFile {
        source: source.clone(),
        series_uid: series_uid(data),
        // Of no use for anything but choosing, so nonsense is as good as nothing.
        series_number: data.integer_text(attr::SERIES_NUMBER).unwrap_or(None),
        modality,
        modality_code,
        is_localizer: image_type.iter().any(|value| value == "LOCALIZER"),
        frame_of_reference: data.text(attr::FRAME_OF_REFERENCE_UID),
        patient: {
            let mut hasher = DefaultHasher::new();
            data.bytes(attr::PATIENT_ID).map(<[u8]>::trim_ascii).hash(&mut hasher);
            hasher.finish()
        },
        instance_uid: data.text(attr::SOP_INSTANCE_UID),
        labels,
        kernel: data.text(attr::CONVOLUTION_KERNEL),
        subject: {
            let mut subject = subject(data);
            // A map that a CT was made of is none, though no unit says so.
            let is_map = modality == Modality::Ct && quantity.unit.is_empty();
            subject.is_other = modality == Modality::Other || is_map;
            subject
        },
        unit: if segmentation.is_some() { "".into() } else { quantity.unit },
        segmentation,
        whole: whole * format.slices_in_frame(),
        format,
        frames,
        truncated: there.err(),
        is_film: multi_frame::is_film(data),
        notes,
    })
}

/// [`ImageFile::labels`].
fn labels(data: &DataSet, modality: Modality, frames: &[Frame]) -> [String; 3] {
    let kernel = words::kernel_label(data);
    let filter = match modality {
        Modality::Mr => {
            let first = frames.first();
            let b_value = first.map_or(0.0, |frame| frame.phase.b_value as f64);
            words::weighting(data, first.and_then(|frame| frame.contrast.as_deref()), b_value)
        }
        _ if kernel.is_empty() => kernel,
        _ => format!("kernel {kernel}"),
    };
    [words::series_label(data), filter, words::time_label(data)]
}

/// Whether frames that are cut off keep their places, as empty slices: where the file tells these, and the frames that
/// are there vouch for the memory.
fn marks_lost_frames(data: &DataSet, format: &PixelFormat, whole: usize) -> bool {
    let is_told = !data.items(attr::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE).is_empty()
        || data.bytes(attr::GRID_FRAME_OFFSET_VECTOR).is_some();
    let bytes = |frames: usize| frames.saturating_mul(format.frame_bytes());
    whole > 0 && is_told && bytes(format.frames) <= LOST_AT_LEAST.max(bytes(whole).saturating_mul(LOST_RATIO))
}

/// A code for a modality as it may be shown. An unknown one is not: it may be anything, a patient's name too.
fn modality_code(text: Option<&str>) -> &'static str {
    // PS3.3 C.7.3.1.1.1, as far as there are images.
    const KNOWN: [&str; 40] = [
        "BDUS", "BI", "BMD", "CR", "CT", "DG", "DX", "ES", "FID", "GM", "HC", "IO", "IVOCT", "IVUS", "LS",
        "M3D", "MG", "MR", "NM", "OAM", "OCT", "OP", "OPM", "OPT", "OPTBSV", "OPTENF", "OT", "PA", "PT",
        "PX", "REG", "RF", "RG", "RTDOSE", "RTIMAGE", "SEG", "SM", "US", "XA", "XC",
    ];
    match text {
        None => "",
        Some(text) => KNOWN.into_iter().find(|known| *known == text).unwrap_or("other"),
    }
}

/// The pixel format, and how many of its frames are there.
fn pixel_format(header: &Header, notes: &mut Vec<String>) -> Result<(PixelFormat, FramesThere), Refusal> {
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
    if photometric(data) == "PALETTE COLOR" && !segmentation::is_segmentation(data) {
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
