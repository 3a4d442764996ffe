//! One file's header as an image: its pixel format and, frame by frame, the place in the patient.
//!
//! A classic file is an image with one frame. Enhanced multi-frame files say everything frame by frame in functional
//! groups (PS3.3 C.7.6.16), so that each frame is treated like a file of its own from here on.

use lumivox_core::{
    Modality,
    glam::{DVec2, DVec3},
};

use super::{
    attributes::{self as attr, Attribute},
    codec::Encoding,
    elements::{DataSet, Fault, Header, read_header},
    source::Source,
    values::FieldFault,
};
use crate::{ImportError, scan::SPACING_MM};

/// More frames than any scan has; each costs memory before a pixel is read.
const MOST_FRAMES: i64 = 100_000;
/// A compressed frame may always grow to this size, and beyond it to [`LARGEST_RATIO`] times its own.
const COMPRESSED_AT_LEAST: u64 = 64 << 20;
const LARGEST_RATIO: u64 = 256;

const DECOMPRESS: &str = "Lumivox cannot decode that: convert it to an uncompressed transfer syntax, for example with 'gdcmconv --raw'";

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
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    pub(crate) kind: SampleKind,
    /// Bytes of a sample: 1, 2, 4 or 8.
    pub(crate) bytes: usize,
    pub(crate) bits_stored: u32,
    pub(crate) high_bit: u32,
    pub(crate) signed: bool,
    /// MONOCHROME1: the lowest value is shown white.
    pub(crate) inverted: bool,
    pub(crate) big_endian: bool,
    /// 8-bit samples in big endian 16-bit words, pairwise swapped.
    pub(crate) swapped_pairs: bool,
    pub(crate) encoding: Encoding,
    /// Frames that the file says it has.
    pub(crate) frames: usize,
    /// Raw samples, lowest and highest, that mean `nothing was measured here`.
    pub(crate) padding: Option<[u32; 2]>,
    /// Offset of the pixel data's value.
    pub(crate) offset: u64,
    /// Where a deflated data set starts in the file.
    pub(crate) deflated_from: Option<u64>,
}

impl PixelFormat {
    /// Bytes of one frame, decoded.
    pub(crate) fn frame_bytes(&self) -> usize {
        self.columns * self.rows * self.bytes
    }
}

/// Breaks ties between images of one place: the first of several phases or echoes. Never used to order slices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Sequence {
    temporal_position: i64,
    acquisition: i64,
    echo: i64,
    instance: i64,
}

/// One image of a file.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    /// Centre of the first pixel, in LPS millimetres; `None` where the file does not say.
    pub(crate) position: Option<DVec3>,
    /// Unit direction of growing column index.
    pub(crate) row_direction: DVec3,
    /// Unit direction of growing row index.
    pub(crate) column_direction: DVec3,
    /// Distance of neighbouring columns (x) and rows (y), in mm.
    pub(crate) spacing_mm: DVec2,
    /// Distance to the next slice by the header's word, for single slices only.
    pub(crate) thickness_mm: f64,
    /// Slope and intercept.
    pub(crate) rescale: [f64; 2],
    /// What it shows, in words beyond its series': images of different kinds never make one volume.
    pub(crate) kind: String,
    pub(crate) sequence: Sequence,
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
    pub(crate) format: PixelFormat,
    pub(crate) frames: Vec<Frame>,
    /// Sentences about liberties taken.
    pub(crate) notes: Vec<String>,
}

/// Reads the header of the image at `source`.
///
/// # Errors
/// [`ImportError`] says why it is not an image that can be part of a volume.
pub(crate) fn read_image(source: &Source) -> Result<ImageFile, ImportError> {
    let path = || source.path();
    let header = read_header(source).map_err(|fault| match fault {
        Fault::NotDicom(found) => ImportError::UnknownFormat { path: path(), found: found.to_owned() },
        Fault::Damaged(problem) => ImportError::Damaged { path: path(), problem },
        Fault::Io(source) => ImportError::Io { path: path(), source },
    })?;
    interpret(source, &header).map_err(|refusal| match refusal {
        Refusal::Field(FieldFault { attribute, problem, remedy }) => ImportError::Field {
            path: path(),
            field: attribute.to_string(),
            problem,
            remedy: remedy.to_owned(),
        },
        Refusal::Unsupported(what, remedy) => {
            ImportError::Unsupported { path: path(), what, remedy: remedy.to_owned() }
        }
        Refusal::Truncated { expected, actual } => ImportError::Truncated { path: path(), expected, actual },
    })
}

/// The error about a compression that no decoder is there for.
pub(crate) fn undecodable(source: &Source, what: String) -> ImportError {
    ImportError::Unsupported { path: source.path(), what, remedy: DECOMPRESS.to_owned() }
}

/// Why a header is not that of a usable image.
enum Refusal {
    Field(FieldFault),
    Unsupported(String, &'static str),
    Truncated { expected: u64, actual: u64 },
}

impl From<FieldFault> for Refusal {
    fn from(fault: FieldFault) -> Self {
        Refusal::Field(fault)
    }
}

fn interpret(source: &Source, header: &Header) -> Result<ImageFile, Refusal> {
    let data = &header.data;
    let mut notes = Vec::new();
    let (format, complete_frames) = pixel_format(header, &mut notes)?;
    let modality_code = modality_code(data.text(attr::MODALITY).as_deref());
    let modality = match modality_code {
        "CT" => Modality::Ct,
        "MR" => Modality::Mr,
        "PT" => Modality::Pet,
        _ => Modality::Other,
    };
    let image_type = data.texts(attr::IMAGE_TYPE);
    if image_type.iter().any(|value| value == "MOSAIC") {
        notes.push("the image is a mosaic: its slices are tiled in one picture and shown so".to_owned());
    }
    let mut frames = frames(data, &format, &mut notes)?;
    frames.truncate(complete_frames);
    Ok(ImageFile {
        source: source.clone(),
        series_uid: data.text(attr::SERIES_INSTANCE_UID),
        // Of no use for anything but choosing, so nonsense is as good as nothing.
        series_number: data.integer_text(attr::SERIES_NUMBER).unwrap_or(None),
        modality,
        modality_code,
        is_localizer: image_type.iter().any(|value| value == "LOCALIZER"),
        format,
        frames,
        notes,
    })
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
fn pixel_format(header: &Header, notes: &mut Vec<String>) -> Result<(PixelFormat, usize), Refusal> {
    let data = &header.data;
    let unsupported = |what: &str, remedy| Err(Refusal::Unsupported(what.to_owned(), remedy));
    const OTHER_FILES: &str = "Open the series of images that it belongs to";
    if header.is_directory {
        return unsupported("it is a DICOMDIR, an index of other files", "Open the folder that it lies in");
    }
    let sop_class = data.text(attr::SOP_CLASS_UID).unwrap_or_default();
    if sop_class == "1.2.840.10008.5.1.4.1.1.66.4" {
        return unsupported("it is a segmentation, not an image", OTHER_FILES);
    }
    let Some(pixels) = header.pixels else {
        return unsupported("it holds no image", OTHER_FILES);
    };
    let samples = data.unsigned(attr::SAMPLES_PER_PIXEL).unwrap_or(1);
    let photometric = data.text(attr::PHOTOMETRIC_INTERPRETATION).unwrap_or_default();
    if samples != 1 || photometric == "PALETTE COLOR" {
        return unsupported("it is a colour image, which has no physical values", OTHER_FILES);
    }
    if !data.items(attr::MODALITY_LUT_SEQUENCE).is_empty() {
        return unsupported(
            "its values are given by a table (ModalityLUTSequence)",
            "Convert it with a DICOM tool that applies the modality LUT",
        );
    }
    let side = |attribute| match data.unsigned(attribute) {
        None => Err(FieldFault::missing(attribute)),
        Some(n @ 1..=65535) => Ok(n as usize),
        Some(n) => Err(FieldFault::new(attribute, format!("is {n}, not a length from 1 to 65535"))),
    };
    let (rows, columns) = (side(attr::ROWS)?, side(attr::COLUMNS)?);

    let allocated = match pixels.attribute {
        attr::FLOAT_PIXEL_DATA => 32,
        attr::DOUBLE_FLOAT_PIXEL_DATA => 64,
        _ => match data.unsigned(attr::BITS_ALLOCATED) {
            None => return Err(FieldFault::missing(attr::BITS_ALLOCATED).into()),
            Some(bits @ (8 | 16 | 32)) => bits,
            Some(bits) => {
                return Err(
                    FieldFault::new(attr::BITS_ALLOCATED, format!("is {bits}, not 8, 16 or 32")).into()
                );
            }
        },
    };
    let bits_stored = data.unsigned(attr::BITS_STORED).unwrap_or(allocated);
    if bits_stored == 0 || bits_stored > allocated {
        let problem = format!("is {bits_stored} where {allocated} bits are allocated");
        return Err(FieldFault::new(attr::BITS_STORED, problem).into());
    }
    let high_bit = data.unsigned(attr::HIGH_BIT).unwrap_or(bits_stored - 1);
    if high_bit >= allocated || high_bit + 1 < bits_stored {
        let problem = format!("is {high_bit} where {bits_stored} of {allocated} bits are stored");
        return Err(FieldFault::new(attr::HIGH_BIT, problem).into());
    }
    let is_float = pixels.attribute != attr::PIXEL_DATA;
    let encoding = match pixels.length {
        Some(_) => Encoding::Native,
        None => Encoding::of_transfer_syntax(&header.transfer_syntax)
            .map_err(|name| Refusal::Unsupported(format!("it is compressed as {name}"), DECOMPRESS))?,
    };
    let (frames, complete_frames) = frame_counts(header, [columns, rows, allocated as usize / 8], encoding)?;
    if encoding == Encoding::Native
        && let (Some(declared), Some(there)) = (pixels.length, pixels.available)
        // One byte of padding is often left out.
        && declared > there.saturating_add(1)
    {
        notes.push(format!(
            "{} declares {declared} bytes where the file has {there} left; read by the size of the image instead",
            pixels.attribute
        ));
    }
    if complete_frames < frames {
        notes.push(format!("the file is cut short: {complete_frames} of {frames} frames are there"));
    }
    let format = PixelFormat {
        columns,
        rows,
        kind: if is_float { SampleKind::Float } else { SampleKind::Integer },
        bytes: allocated as usize / 8,
        bits_stored,
        high_bit,
        signed: data.unsigned(attr::PIXEL_REPRESENTATION) == Some(1),
        inverted: photometric == "MONOCHROME1",
        big_endian: data.big_endian,
        swapped_pairs: data.big_endian && allocated == 8 && pixels.words,
        encoding,
        frames,
        padding: data.unsigned(attr::PIXEL_PADDING_VALUE).map(|value| {
            // Either may be the lower one.
            [value, data.unsigned(attr::PIXEL_PADDING_RANGE_LIMIT).unwrap_or(value)]
        }),
        offset: pixels.offset,
        deflated_from: header.deflated_from,
    };
    Ok((format, complete_frames))
}

/// How many frames the file declares, and how many it can hold: what is declared is checked against the bytes that are
/// there before memory is taken for it.
fn frame_counts(
    header: &Header,
    [columns, rows, bytes]: [usize; 3],
    encoding: Encoding,
) -> Result<(usize, usize), Refusal> {
    let pixels = header.pixels.expect("checked by the caller");
    let frames = match header.data.integer_text(attr::NUMBER_OF_FRAMES)?.unwrap_or(1) {
        // Written so by some that mean a single image.
        0 => 1,
        n @ 1..=MOST_FRAMES => n as usize,
        n => {
            let problem = format!("is {n}, not a number from 1 to {MOST_FRAMES}");
            return Err(FieldFault::new(attr::NUMBER_OF_FRAMES, problem).into());
        }
    };
    let frame_bytes = columns as u64 * rows as u64 * bytes as u64;
    if frame_bytes > isize::MAX as u64 {
        return Err(FieldFault::new(
            attr::ROWS,
            format!("is {rows}, with {columns} columns more than memory"),
        )
        .into());
    }
    let available = match (pixels.length, pixels.available) {
        (declared, Some(there)) => declared.unwrap_or(there).min(there),
        // The length of an inflated data set is known at its end only, but it has a limit.
        (declared, None) => declared.unwrap_or(0).min(super::source::inflation_limit(u64::from(u32::MAX))),
    };
    if encoding == Encoding::Native {
        let complete = (available / frame_bytes).min(frames as u64) as usize;
        if complete == 0 {
            let expected = frame_bytes.saturating_mul(frames as u64);
            return Err(Refusal::Truncated { expected, actual: available });
        }
        return Ok((frames, complete));
    }
    // Every frame has at least one fragment with a head of 8 bytes.
    if frames as u64 > available / 8 {
        let problem = format!("is {frames}, more than {available} bytes of pixel data can hold");
        return Err(FieldFault::new(attr::NUMBER_OF_FRAMES, problem).into());
    }
    if frame_bytes > COMPRESSED_AT_LEAST.max(available.saturating_mul(LARGEST_RATIO)) {
        let problem = format!("is {rows}, with {columns} columns more than {available} bytes can hold");
        return Err(FieldFault::new(attr::ROWS, problem).into());
    }
    Ok((frames, frames))
}

/// A frame's own functional groups, those shared by all frames, and the data set: the first that has an attribute says
/// it.
struct FrameScope<'a> {
    own: Option<&'a DataSet>,
    shared: Option<&'a DataSet>,
    data: &'a DataSet,
}

impl<'a> FrameScope<'a> {
    /// The macro `sequence` of this frame, or the data set, where `attribute` is.
    fn find(&self, sequence: Attribute, attribute: Attribute) -> &'a DataSet {
        [self.own, self.shared]
            .into_iter()
            .flatten()
            .filter_map(|group| group.items(sequence).first())
            .find(|item| item.bytes(attribute).is_some())
            .unwrap_or(self.data)
    }
}

/// Where and what each frame is.
fn frames(data: &DataSet, format: &PixelFormat, notes: &mut Vec<String>) -> Result<Vec<Frame>, Refusal> {
    let per_frame = data.items(attr::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE);
    if !per_frame.is_empty() && per_frame.len() < format.frames {
        let problem = format!("has {} items for {} frames", per_frame.len(), format.frames);
        return Err(FieldFault::new(attr::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE, problem).into());
    }
    let shared = data.items(attr::SHARED_FUNCTIONAL_GROUPS_SEQUENCE).first();
    let mut frames = (0..format.frames)
        .map(|index| frame(index, &FrameScope { own: per_frame.get(index), shared, data }, notes))
        .collect::<Result<Vec<_>, FieldFault>>()?;
    if frames.len() > 1 && per_frame.is_empty() {
        stack_frames(&mut frames, data, notes)?;
    }
    Ok(frames)
}

fn frame(index: usize, scope: &FrameScope<'_>, notes: &mut Vec<String>) -> Result<Frame, FieldFault> {
    let position = scope
        .find(attr::PLANE_POSITION_SEQUENCE, attr::IMAGE_POSITION_PATIENT)
        .decimals::<3>(attr::IMAGE_POSITION_PATIENT)?
        .map(DVec3::from_array);
    if let Some(position) = position
        && position.abs().max_element() > 1e6
    {
        let problem = "lies more than a kilometre away";
        return Err(FieldFault::new(attr::IMAGE_POSITION_PATIENT, problem));
    }
    let [row_direction, column_direction] = orientation(scope)?;
    let measures = |attribute| scope.find(attr::PIXEL_MEASURES_SEQUENCE, attribute);
    let spacing_mm = match pixel_spacing(measures(attr::PIXEL_SPACING))? {
        Some(spacing) => spacing,
        None => {
            if index == 0 {
                notes.push("the pixel spacing is not given; taken as 1 mm".to_owned());
            }
            DVec2::ONE
        }
    };
    // Only a fallback where there is one slice: nonsense is as good as nothing.
    let length = |attribute| {
        let value = measures(attribute).decimal(attribute).ok().flatten();
        value.map(f64::abs).filter(|mm| (1e-3..1e3).contains(mm))
    };
    let thickness_mm = length(attr::SPACING_BETWEEN_SLICES)
        .or_else(|| length(attr::SLICE_THICKNESS))
        .unwrap_or(spacing_mm.max_element());
    Ok(Frame {
        position,
        row_direction,
        column_direction,
        spacing_mm,
        thickness_mm,
        rescale: rescale(scope)?,
        kind: frame_kind(scope),
        sequence: sequence(scope),
    })
}

fn orientation(scope: &FrameScope<'_>) -> Result<[DVec3; 2], FieldFault> {
    const ORIENTATION: Attribute = attr::IMAGE_ORIENTATION_PATIENT;
    let values = scope.find(attr::PLANE_ORIENTATION_SEQUENCE, ORIENTATION).decimals::<6>(ORIENTATION)?;
    let Some([a, b, c, d, e, f]) = values else { return Ok([DVec3::X, DVec3::Y]) };
    let directions = [DVec3::new(a, b, c), DVec3::new(d, e, f)].map(DVec3::try_normalize);
    let [Some(row), Some(column)] = directions else {
        return Err(FieldFault::new(ORIENTATION, "has a direction of no length"));
    };
    // Rounded to a few decimals the two are never quite perpendicular.
    if row.dot(column).abs() > 0.01 {
        return Err(FieldFault::new(ORIENTATION, "has directions that are not perpendicular"));
    }
    Ok([row, column])
}

/// PixelSpacing is the distance of rows, then of columns: y before x.
fn pixel_spacing(measures: &DataSet) -> Result<Option<DVec2>, FieldFault> {
    for attribute in [attr::PIXEL_SPACING, attr::IMAGER_PIXEL_SPACING] {
        let Some([row_mm, column_mm]) = measures.decimals::<2>(attribute)? else { continue };
        if [row_mm, column_mm].iter().all(|mm| SPACING_MM.contains(mm)) {
            return Ok(Some(DVec2::new(column_mm, row_mm)));
        }
        let (least, most) = (SPACING_MM.start(), SPACING_MM.end());
        let problem =
            format!("is {row_mm}\\{column_mm}, not two positive lengths in mm from {least} to {most}");
        return Err(FieldFault::new(attribute, problem));
    }
    Ok(None)
}

fn rescale(scope: &FrameScope<'_>) -> Result<[f64; 2], FieldFault> {
    let find =
        |attribute| scope.find(attr::PIXEL_VALUE_TRANSFORMATION_SEQUENCE, attribute).decimal(attribute);
    let slope = find(attr::RESCALE_SLOPE)?.unwrap_or(1.0);
    let intercept = find(attr::RESCALE_INTERCEPT)?.unwrap_or(0.0);
    if !slope.is_normal() || slope.abs() > 1e30 {
        return Err(FieldFault::new(
            attr::RESCALE_SLOPE,
            format!("is {slope}, which maps every sample to one value"),
        ));
    }
    if intercept.abs() > 1e30 {
        return Err(FieldFault::new(attr::RESCALE_INTERCEPT, format!("is {intercept}, beyond any value")));
    }
    Ok([slope, intercept])
}

/// What keeps frames of one series apart: derived images, and the parts of complex ones.
fn frame_kind(scope: &FrameScope<'_>) -> String {
    for sequence in [
        attr::MR_IMAGE_FRAME_TYPE_SEQUENCE,
        attr::CT_IMAGE_FRAME_TYPE_SEQUENCE,
        attr::PET_FRAME_TYPE_SEQUENCE,
    ] {
        let item = scope.find(sequence, attr::FRAME_TYPE);
        if item.bytes(attr::FRAME_TYPE).is_some() {
            let part =
                scope.find(sequence, attr::COMPLEX_IMAGE_COMPONENT).text(attr::COMPLEX_IMAGE_COMPONENT);
            let mut words: Vec<String> = item.texts(attr::FRAME_TYPE).into_iter().chain(part).collect();
            words.retain(|word| !["ORIGINAL", "PRIMARY", "NONE", ""].contains(&word.as_str()));
            return words.join(" ").to_lowercase();
        }
    }
    let values = scope.data.texts(attr::IMAGE_TYPE);
    let has = |names: &[&str]| values.iter().skip(2).any(|value| names.contains(&value.as_str()));
    let part = if has(&["P", "PHASE", "PHASE MAP"]) {
        "phase"
    } else if has(&["R", "REAL"]) {
        "real"
    } else if has(&["I", "IMAGINARY"]) {
        "imaginary"
    } else {
        ""
    };
    let origin = if values[0] == "DERIVED" { "derived " } else { "" };
    let localizer = if has(&["LOCALIZER"]) { "localizer " } else { "" };
    format!("{origin}{localizer}{part}").trim_end().to_owned()
}

fn sequence(scope: &FrameScope<'_>) -> Sequence {
    let number = |attribute| scope.data.integer_text(attribute).ok().flatten().unwrap_or(0);
    let content = scope.find(attr::FRAME_CONTENT_SEQUENCE, attr::TEMPORAL_POSITION_INDEX);
    let temporal_position = match content.unsigned(attr::TEMPORAL_POSITION_INDEX) {
        Some(index) => index.into(),
        None => number(attr::TEMPORAL_POSITION_IDENTIFIER),
    };
    Sequence {
        temporal_position,
        acquisition: number(attr::ACQUISITION_NUMBER),
        echo: number(attr::ECHO_NUMBERS),
        instance: number(attr::INSTANCE_NUMBER),
    }
}

/// Places the frames of a multi-frame file without functional groups, which says where the first is.
fn stack_frames(frames: &mut [Frame], data: &DataSet, notes: &mut Vec<String>) -> Result<(), Refusal> {
    let offsets = match data.decimal_list(attr::GRID_FRAME_OFFSET_VECTOR)? {
        Some(offsets) if offsets.len() >= frames.len() => {
            // They are relative to the first image's plane, or absolute (PS3.3 C.8.8.3.2).
            offsets.iter().map(|offset| offset - offsets[0]).collect()
        }
        Some(offsets) => {
            let problem = format!("has {} values for {} frames", offsets.len(), frames.len());
            return Err(FieldFault::new(attr::GRID_FRAME_OFFSET_VECTOR, problem).into());
        }
        None => {
            let step = frames[0].thickness_mm;
            notes.push(format!(
                "the places of the {} frames are not given; stacked {step} mm apart",
                frames.len()
            ));
            (0..frames.len()).map(|k| k as f64 * step).collect::<Vec<_>>()
        }
    };
    let normal = frames[0].row_direction.cross(frames[0].column_direction);
    let first = frames[0].position.unwrap_or(DVec3::ZERO);
    for (frame, offset) in frames.iter_mut().zip(offsets) {
        frame.position = Some(first + normal * offset);
    }
    Ok(())
}
