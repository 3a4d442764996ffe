//! Where each frame lies in the patient, what it shows, and what tells it from others at its place.
//!
//! Enhanced multi-frame files say everything frame by frame in functional groups (PS3.3 C.7.6.16); classic ones say it
//! once.

use std::hash::{DefaultHasher, Hash, Hasher};

use lumivox_core::{
    CancelToken,
    glam::{DVec2, DVec3},
};

use crate::{
    dicom::{
        elements::{
            attributes::{self as attr, Attribute},
            data_set::DataSet,
            values::FieldFault,
        },
        frames::{
            frame::{Frame, PhaseKey, RealWorld, RescaleType},
            kinds, multi_frame,
            scope::FrameScope,
        },
        header::{
            pixel_format::{PixelFormat, SampleKind},
            refusal::Refusal,
            segments,
            units::{self, Unit},
        },
    },
    lengths::SPACING_MM,
};

/// Added to b-values by some of GE's programs.
const GE_B_VALUE_OFFSET: f64 = 1e9;
/// Its planes lie in a volume's space, not the patient's.
const ENHANCED_ULTRASOUND: &str = "1.2.840.10008.5.1.4.1.1.6.2";
/// Mappings to real world values that are looked at in a frame.
const MOST_MAPPINGS: usize = 16;

/// Where and what each frame is.
///
/// # Errors
/// Where the file does not say that, and on cancel.
pub(crate) fn frames(
    data: &DataSet,
    format: &PixelFormat,
    notes: &mut Vec<String>,
    cancel: &CancelToken,
) -> Result<Vec<Frame>, Refusal> {
    multi_frame::refuse_pictures(data, format.frames)?;
    let per_frame = data.items(attr::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE);
    if !per_frame.is_empty() && per_frame.len() < format.frames {
        let problem = format!("has {} items for {} frames", per_frame.len(), format.frames);
        return Err(FieldFault::new(attr::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE, problem).into());
    }
    let shared = data.items(attr::SHARED_FUNCTIONAL_GROUPS_SEQUENCE).first();
    let detectors = match per_frame {
        [] => multi_frame::detectors(data, format.frames)?,
        _ => vec![data.items(attr::DETECTOR_INFORMATION_SEQUENCE).first(); format.frames],
    };
    if data.text(attr::SOP_CLASS_UID).as_deref() == Some(ENHANCED_ULTRASOUND) {
        notes
            .push("it lies in a space of its own, which does not say where the patient's left is".to_owned());
    }
    let contrast_agent = contrast_agent(data);
    let mut frames = Vec::with_capacity(format.frames);
    for (index, detector) in detectors.into_iter().enumerate() {
        cancel.check()?;
        let scope = FrameScope { own: per_frame.get(index), shared, detector, data };
        let mut frame = frame(index, &scope, format, notes)?;
        frame.phase.contrast = contrast_agent;
        frames.push(frame);
    }
    match frames.len() > 1 && per_frame.is_empty() {
        // Of a segment in each frame, a place of the file is that of none.
        true if segments::is_segmentation(data) => {
            frames.iter_mut().for_each(|frame| frame.position = None);
        }
        true => multi_frame::place_frames(&mut frames, data, notes)?,
        false => {}
    }
    Ok(frames)
}

fn frame(
    index: usize,
    scope: &FrameScope<'_>,
    format: &PixelFormat,
    notes: &mut Vec<String>,
) -> Result<Frame, FieldFault> {
    let position = position(scope)?;
    if let Some(position) = position
        && position.abs().max_element() > 1e6
    {
        let problem = "lies more than a kilometre away";
        return Err(FieldFault::new(attr::IMAGE_POSITION_PATIENT, problem));
    }
    let directions = orientation(scope)?;
    let [row_direction, column_direction] = directions.unwrap_or([DVec3::X, DVec3::Y]);
    if directions.is_none() && position.is_some() && index == 0 {
        notes.push(format!(
            "{} is missing: slices are taken as axial, with the patient's left on the right of the picture",
            attr::IMAGE_ORIENTATION_PATIENT
        ));
    }
    let measures = |attribute| scope.find(attr::PIXEL_MEASURES_SEQUENCE, attribute);
    let spacing_mm = match pixel_spacing(measures(attr::PIXEL_SPACING), notes)? {
        Some(spacing) => spacing,
        None => {
            if index == 0 {
                notes.push("the pixel spacing is not given; taken as 1 mm".to_owned());
            }
            DVec2::ONE
        }
    };
    // Wherever it counts there is something to fall back to: nonsense is as good as nothing.
    let length = |attribute| {
        let value = measures(attribute).decimal(attribute).ok().flatten();
        value.map(f64::abs).filter(|mm| (1e-3..1e3).contains(mm))
    };
    let thickness_mm = length(attr::SPACING_BETWEEN_SLICES)
        .or_else(|| length(attr::SLICE_THICKNESS))
        .unwrap_or(spacing_mm.max_element());
    let (kind, rescale) = (kinds::frame_kind(scope), rescale(scope)?);
    Ok(Frame {
        position,
        row_direction,
        column_direction,
        is_oriented: directions.is_some(),
        spacing_mm,
        thickness_mm,
        rescale,
        rescale_type: rescale_type(scope),
        real_world: real_world(scope, format, notes),
        collapse: kinds::ge_collapse(scope.data),
        is_signed_map: kinds::is_signed_map(scope.data, &kind, rescale, format.signed),
        kind,
        contrast: {
            let sequence = attr::MR_IMAGE_FRAME_TYPE_SEQUENCE;
            scope.find(sequence, attr::ACQUISITION_CONTRAST).text(attr::ACQUISITION_CONTRAST)
        },
        phase: phase_key(scope),
        segment: segment(scope),
    })
}

/// The place in the patient; of enhanced ultrasound, that in the volume's own space (PS3.3 C.7.6.16.2.21).
fn position(scope: &FrameScope<'_>) -> Result<Option<DVec3>, FieldFault> {
    const PATIENT: Attribute = attr::IMAGE_POSITION_PATIENT;
    let of_patient = scope.find(attr::PLANE_POSITION_SEQUENCE, PATIENT).decimals::<3>(PATIENT)?;
    let in_volume = || {
        let item = scope.find(attr::PLANE_POSITION_VOLUME_SEQUENCE, attr::IMAGE_POSITION_VOLUME);
        item.floats::<3>(attr::IMAGE_POSITION_VOLUME)
    };
    Ok(match of_patient {
        Some(position) => Some(position),
        None => in_volume()?,
    }
    .map(DVec3::from_array))
}

/// Directions of growing column and row index; `None` where the file does not say them.
fn orientation(scope: &FrameScope<'_>) -> Result<Option<[DVec3; 2]>, FieldFault> {
    const ORIENTATION: Attribute = attr::IMAGE_ORIENTATION_PATIENT;
    let of_patient = scope.find(attr::PLANE_ORIENTATION_SEQUENCE, ORIENTATION).decimals::<6>(ORIENTATION)?;
    let values = match of_patient {
        Some(values) => Some(values),
        None => {
            let item = scope.find(attr::PLANE_ORIENTATION_VOLUME_SEQUENCE, attr::IMAGE_ORIENTATION_VOLUME);
            item.floats::<6>(attr::IMAGE_ORIENTATION_VOLUME)?
        }
    };
    let Some([a, b, c, d, e, f]) = values else { return Ok(None) };
    let directions = [DVec3::new(a, b, c), DVec3::new(d, e, f)].map(DVec3::try_normalize);
    let [Some(row), Some(column)] = directions else {
        return Err(FieldFault::new(ORIENTATION, "has a direction of no length"));
    };
    // Rounded to a few decimals the two are never quite perpendicular.
    if row.dot(column).abs() > 0.01 {
        return Err(FieldFault::new(ORIENTATION, "has directions that are not perpendicular"));
    }
    Ok(Some([row, column]))
}

/// PixelSpacing is the distance of rows, then of columns: y before x. Where it is zero, which stands for not known,
/// another distance counts if there is one.
fn pixel_spacing(measures: &DataSet, notes: &mut Vec<String>) -> Result<Option<DVec2>, FieldFault> {
    let others = [attr::IMAGER_PIXEL_SPACING, attr::NOMINAL_SCANNED_PIXEL_SPACING];
    let are_lengths = |spacing: &[f64; 2]| spacing.iter().all(|mm| SPACING_MM.contains(mm));
    for attribute in [attr::PIXEL_SPACING].into_iter().chain(others) {
        let Some([row_mm, column_mm]) = measures.decimals::<2>(attribute)? else { continue };
        if are_lengths(&[row_mm, column_mm]) {
            return Ok(Some(DVec2::new(column_mm, row_mm)));
        }
        let other = others.into_iter().find_map(|other| {
            let spacing = measures.decimals::<2>(other).ok().flatten().filter(are_lengths)?;
            Some((other, spacing))
        });
        if let (true, Some((other, [row_mm, column_mm]))) = (row_mm == 0.0 || column_mm == 0.0, other) {
            let note = format!("{attribute} is zero; {other} is taken");
            if !notes.contains(&note) {
                notes.push(note);
            }
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
    if !slope.is_normal() {
        let problem = format!("is {slope:e}, which maps every sample to one value");
        return Err(FieldFault::new(attr::RESCALE_SLOPE, problem));
    }
    if slope.abs() > 1e30 {
        return Err(FieldFault::new(attr::RESCALE_SLOPE, format!("is {slope:e}, beyond any value")));
    }
    if intercept.abs() > 1e30 {
        return Err(FieldFault::new(attr::RESCALE_INTERCEPT, format!("is {intercept:e}, beyond any value")));
    }
    Ok([slope, intercept])
}

fn rescale_type(scope: &FrameScope<'_>) -> RescaleType {
    let sequence = attr::PIXEL_VALUE_TRANSFORMATION_SEQUENCE;
    match scope.find(sequence, attr::RESCALE_TYPE).text(attr::RESCALE_TYPE) {
        None => RescaleType::Absent,
        Some(text) => units::unit(&text).map_or(RescaleType::Unknown, RescaleType::Known),
    }
}

/// The mapping to Bq/ml, else to SUV by body weight, that an enhanced PET image has in place of Units
/// (PS3.3 C.7.6.16.2.11); else that to the first unit that is known, else to plain numbers. Of several to one unit it is one that holds for all
/// values that may be stored, and of a single one it is said where it does not.
fn real_world(scope: &FrameScope<'_>, format: &PixelFormat, notes: &mut Vec<String>) -> Option<RealWorld> {
    let mapping = |item: &DataSet| {
        let unit = item.items(attr::MEASUREMENT_UNITS_CODE_SEQUENCE).first()?.text(attr::CODE_VALUE)?;
        // UCUM's codes, and those of DICOM's context group 85.
        let unit = match unit.as_str() {
            "Bq/ml" | "Bq/mL" => "BQML".into(),
            "g/ml{SUVbw}" | "{SUVbw}g/ml" => "GML".into(),
            other if units::is_plain_number(other) => "".into(),
            other => units::unit(other)?,
        };
        let rescale =
            [item.float(attr::REAL_WORLD_VALUE_SLOPE)?, item.float(attr::REAL_WORLD_VALUE_INTERCEPT)?];
        let is_scale = rescale[0].is_normal() && rescale.iter().all(|part| part.abs() < 1e30);
        is_scale.then(|| (RealWorld { unit, rescale }, mapped_values(item, format)))
    };
    let sets = [scope.own, scope.shared, Some(scope.data)].into_iter().flatten();
    let items = sets.flat_map(|set| set.items(attr::REAL_WORLD_VALUE_MAPPING_SEQUENCE).iter());
    let mut mappings: Vec<_> = items.take(MOST_MAPPINGS).filter_map(mapping).collect();
    let is_of = |unit: &str| mappings.iter().any(|(mapping, _)| mapping.unit == unit);
    let unit: Unit = match ["BQML", "GML"].into_iter().find(|unit| is_of(unit)) {
        Some(unit) => unit.into(),
        None => {
            let mut units = mappings.iter().map(|(mapping, _)| &mapping.unit);
            units.find(|unit| !unit.is_empty()).or(mappings.first().map(|(first, _)| &first.unit))?.clone()
        }
    };
    mappings.retain(|(mapping, _)| mapping.unit == unit);
    let [lowest, highest] = stored_values(format);
    let holds = |[first, last]: [f64; 2]| first <= lowest && highest <= last;
    if let Some((mapping, _)) = mappings.iter().find(|(_, values)| values.is_none_or(holds)) {
        return Some(mapping.clone());
    }
    let to = if unit.is_empty() { "plain numbers" } else { &*unit };
    // Often the values that are there, not those that might be. Once for all frames, each of which has its own.
    const BEGIN: &str = "the mapping to real world values";
    let (found, note) = match &mappings[..] {
        [(mapping, Some([first, last]))] => (
            Some(mapping.clone()),
            format!("{BEGIN} ({to}) is given for stored values from {first} to {last} only"),
        ),
        _ => (None, format!("{BEGIN} is unclear: several mappings to {to} hold for a part each")),
    };
    if !notes.iter().any(|note| note.starts_with(BEGIN)) {
        notes.push(note);
    }
    found
}

/// The first and the last of the stored values that a mapping holds for; `None` where it does not say.
fn mapped_values(mapping: &DataSet, format: &PixelFormat) -> Option<[f64; 2]> {
    let word = |attribute| {
        let word = *mapping.words(attribute)?.first()?;
        Some(if format.signed { f64::from(word as i16) } else { word.into() })
    };
    let integers =
        [attr::REAL_WORLD_VALUE_FIRST_VALUE_MAPPED, attr::REAL_WORLD_VALUE_LAST_VALUE_MAPPED].map(word);
    let doubles = [
        attr::DOUBLE_FLOAT_REAL_WORLD_VALUE_FIRST_VALUE_MAPPED,
        attr::DOUBLE_FLOAT_REAL_WORLD_VALUE_LAST_VALUE_MAPPED,
    ]
    .map(|attribute| mapping.float(attribute));
    let [first, last] = [integers[0].or(doubles[0])?, integers[1].or(doubles[1])?];
    Some([first.min(last), first.max(last)])
}

/// The lowest and the highest value that may be stored.
fn stored_values(format: &PixelFormat) -> [f64; 2] {
    let count = f64::from(format.bits_stored).exp2();
    match (format.kind, format.signed) {
        (SampleKind::Float, _) => [f64::NEG_INFINITY, f64::INFINITY],
        (SampleKind::Integer, false) => [0.0, count - 1.0],
        (SampleKind::Integer, true) => [-count / 2.0, count / 2.0 - 1.0],
    }
}

fn phase_key(scope: &FrameScope<'_>) -> PhaseKey {
    let data = scope.data;
    let number = |attribute| data.integer_text(attribute).ok().flatten().unwrap_or(0);
    let millionths = |value: Option<f64>| value.map_or(0, |value| (value * 1e6).round() as i64);
    let decimal = |attribute| data.decimal(attribute).ok().flatten();
    let content = |attribute| scope.find(attr::FRAME_CONTENT_SEQUENCE, attribute).unsigned(attribute);
    let temporal_position = match content(attr::TEMPORAL_POSITION_INDEX) {
        Some(index) => index.into(),
        None => number(attr::TEMPORAL_POSITION_IDENTIFIER),
    };
    let b_value = scope
        .find(attr::MR_DIFFUSION_SEQUENCE, attr::DIFFUSION_B_VALUE)
        .float(attr::DIFFUSION_B_VALUE)
        .or_else(|| {
            // Before there was a public element, or where it was forgotten.
            let private = |attribute| data.find_private(attribute);
            let siemens = private(attr::SIEMENS_B_VALUE).and_then(decimal);
            let ge = || Some(decimal(private(attr::GE_B_VALUE)?)? % GE_B_VALUE_OFFSET);
            siemens.or_else(ge).or_else(|| data.float(private(attr::PHILIPS_B_VALUE)?))
        });
    let echo_time = scope
        .find(attr::MR_ECHO_SEQUENCE, attr::EFFECTIVE_ECHO_TIME)
        .float(attr::EFFECTIVE_ECHO_TIME)
        .or_else(|| decimal(attr::ECHO_TIME));
    let delay = scope
        .find(attr::CARDIAC_SYNCHRONIZATION_SEQUENCE, attr::NOMINAL_CARDIAC_TRIGGER_DELAY_TIME)
        .float(attr::NOMINAL_CARDIAC_TRIGGER_DELAY_TIME);
    let time = decimal(attr::FRAME_REFERENCE_TIME)
        .map(|ms| ms / 1e3)
        .or_else(|| data.seconds_of_day(attr::ACQUISITION_TIME))
        .or_else(|| data.seconds_of_day(attr::CONTENT_TIME));
    PhaseKey {
        temporal_position,
        b_value: millionths(b_value),
        // Echoes have numbers, or times alone.
        echo: match number(attr::ECHO_NUMBERS) {
            0 => millionths(echo_time),
            number => number,
        },
        trigger_time: millionths(delay.or_else(|| decimal(attr::TRIGGER_TIME))),
        // Of the file, not of a frame.
        contrast: 0,
        acquisition: match content(attr::FRAME_ACQUISITION_NUMBER) {
            Some(number) => number.into(),
            None => number(attr::ACQUISITION_NUMBER),
        },
        time: millionths(time),
        instance: number(attr::INSTANCE_NUMBER),
    }
}

/// [`PhaseKey::contrast`] of all frames.
fn contrast_agent(data: &DataSet) -> i64 {
    data.text(attr::CONTRAST_BOLUS_AGENT).map_or(0, |agent| {
        let mut hasher = DefaultHasher::new();
        agent.hash(&mut hasher);
        // Above 0, which is none.
        (hasher.finish() >> 1) as i64 | 1
    })
}

fn segment(scope: &FrameScope<'_>) -> Option<u16> {
    let number = attr::REFERENCED_SEGMENT_NUMBER;
    scope.find(attr::SEGMENT_IDENTIFICATION_SEQUENCE, number).unsigned(number)?.try_into().ok()
}
