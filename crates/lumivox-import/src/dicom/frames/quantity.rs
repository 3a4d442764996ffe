//! What stored values mean beyond rescale slope and intercept: units, dose grids. Of PET see [`uptake`].

use lumivox_core::Modality;

use crate::dicom::{
    elements::{attributes as attr, data_set::DataSet, values::FieldFault},
    frames::{
        frame::{Frame, RescaleType, take_real_world},
        uptake,
    },
    header::{
        modality_lut::modality_lut,
        units::{self, Quantity, Unit},
    },
};

/// Finds the quantity of a data set whose images are of `modality`. Frames with a mapping to real world values in place
/// of a rescale get that.
///
/// # Errors
/// Where a dose grid has no believable scale.
pub(crate) fn quantity(
    data: &DataSet,
    modality: Modality,
    code: &str,
    frames: &mut [Frame],
) -> Result<Quantity, FieldFault> {
    match (modality, code) {
        (Modality::Pet, _) => Ok(uptake::pet(data, frames)),
        (_, "RTDOSE") => {
            let Some(factor) = data.decimal(attr::DOSE_GRID_SCALING)? else { return Ok(Quantity::plain("")) };
            if !factor.is_normal() || !(1e-30..1e30).contains(&factor) {
                return Err(FieldFault::new(attr::DOSE_GRID_SCALING, format!("is {factor}, no scale")));
            }
            let is_gray = data.text(attr::DOSE_UNITS).as_deref() == Some("GY");
            let note = is_gray.then(|| "values are doses in Gy".to_owned());
            Ok(Quantity { factor, unit: if is_gray { "Gy" } else { "" }.into(), note })
        }
        // With a rescale of its own, a CT has Hounsfield units beside plain numbers.
        (Modality::Ct, _) if frames.iter().any(is_rescaled_and_mapped_to_numbers) => {
            Ok(hounsfield_or_nothing(data, frames))
        }
        (Modality::Ct, _) => Ok(match scale(data, frames) {
            Some(unit) if unit == units::HOUNSFIELD => Quantity::plain(unit),
            Some(unit) => {
                let values = if unit.is_empty() { "plain numbers" } else { &*unit };
                let note = format!("values are {values}, not Hounsfield units");
                Quantity::told(unit, note)
            }
            None => hounsfield_or_nothing(data, frames),
        }),
        _ => Ok(Quantity::plain(scale(data, frames).unwrap_or_default())),
    }
}

/// The unit that a file tells: of its table or rescale, else of the mapping to real world values that all frames have
/// and that then takes the place of their rescale.
fn scale(data: &DataSet, frames: &mut [Frame]) -> Option<Unit> {
    let lut = modality_lut(data);
    let told = match lut.and_then(|lut| lut.text(attr::MODALITY_LUT_TYPE)) {
        Some(text) => units::unit(&text),
        None => frames.first().and_then(|frame| frame.rescale_type.known()),
    };
    if told.is_some() {
        return told;
    }
    let unit = frames.first()?.real_world.as_ref()?.unit.clone();
    let is_of_all =
        frames.iter().all(|frame| frame.real_world.as_ref().is_some_and(|real| real.unit == unit));
    (is_of_all && lut.is_none()).then(|| {
        take_real_world(frames);
        unit
    })
}

fn is_rescaled_and_mapped_to_numbers(frame: &Frame) -> bool {
    frame.rescale != [1.0, 0.0] && frame.real_world.as_ref().is_some_and(|real| real.unit.is_empty())
}

/// Kinds of CT that are maps of something else, as ImageType and FrameType call them (PS3.3 C.8.15.2, C.8.2.1.1.1).
const MAPS: [&str; 15] = [
    "EFF_ATOMIC_NUM",
    "ELECTRON_DENSITY",
    "MAT_SPECIFIC",
    "MAT_FRACTIONAL",
    "MAT_VALUE_BASED",
    "CBF",
    "CBV",
    "RCBF",
    "RCBV",
    "REGIONAL_CBF",
    "REGIONAL_CBV",
    "MTT",
    "TTP",
    "TMAX",
    "PERMEABILITY",
];

/// What a CT shows that tells no unit.
fn hounsfield_or_nothing(data: &DataSet, frames: &[Frame]) -> Quantity {
    let types = data.texts(attr::IMAGE_TYPE);
    let kinds = frames.iter().flat_map(|frame| frame.kind.split(' ')).map(str::to_uppercase);
    let is_map = types.iter().cloned().chain(kinds).any(|word| MAPS.contains(&word.as_str()));
    let is_original = types.first().is_some_and(|origin| origin == "ORIGINAL");
    // Some scanners call the unit of every image unspecified.
    let begins_at_air = || frames.iter().all(|frame| frame.rescale[1] <= -1000.0);
    match frames.first().map(|frame| &frame.rescale_type) {
        _ if is_map => {
            Quantity::told("", "a map of another quantity than Hounsfield units, which tells no unit")
        }
        Some(RescaleType::Unknown) if is_original && begins_at_air() => Quantity::told(
            units::HOUNSFIELD,
            "RescaleType tells no unit; taken for Hounsfield units, since the images are original ones of a CT",
        ),
        Some(RescaleType::Unknown) => {
            Quantity::told("", "RescaleType tells no unit that is known: values are not Hounsfield units")
        }
        _ => Quantity::plain(units::HOUNSFIELD),
    }
}
