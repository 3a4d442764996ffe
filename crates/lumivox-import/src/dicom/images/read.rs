//! One file's header as an image: its pixel format and, frame by frame, the place in the patient.
//!
//! A classic file is an image with one frame. Enhanced multi-frame files say everything frame by frame in functional
//! groups (PS3.3 C.7.6.16), so that each frame is treated like a file of its own from here on.

use std::{
    hash::{DefaultHasher, Hash, Hasher},
    sync::Arc,
};

use lumivox_core::{CancelToken, Modality};

use crate::{
    ImportError,
    dicom::{
        bytes::source::Source,
        elements::{
            attributes as attr,
            data_set::{DataSet, Fault, Header, read_header},
            values::FieldFault,
        },
        frames::{
            frame::Frame,
            label_frames,
            mosaic::{Layout, is_mosaic},
            multi_frame,
            quantity::quantity,
            read::frames,
        },
        header::{
            modality_lut::ModalityLut,
            pixel_format::{PixelFormat, pixel_format},
            refusal::Refusal,
            segments::{self, Segmentation},
            subject::subject,
            words,
        },
        images::{image_file::ImageFile, rejected::Rejected},
    },
};

/// Frames that are cut off may always take so many bytes, and beyond it up to [`LOST_RATIO`] times those that are there.
const LOST_AT_LEAST: usize = 64 << 20;
const LOST_RATIO: usize = 8;

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
    let is_segmentation = segments::is_segmentation(data);
    let stacked = if is_segmentation {
        label_frames::number_frames(&mut frames, data)?;
        label_frames::stack_frames(&mut frames, data)?
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
