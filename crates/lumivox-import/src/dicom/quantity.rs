//! What stored values mean beyond rescale slope and intercept: dose grids, PET and its SUV, the modality LUT.

use lumivox_core::Modality;

use super::{
    attributes::{self as attr, Attribute},
    elements::DataSet,
    frames::Frame,
    values::FieldFault,
};

/// What the values of an image are, and the factor that makes them so.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Quantity {
    /// What rescaled values are multiplied by.
    pub(crate) factor: f64,
    /// The unit for people; empty where there is none.
    pub(crate) unit: &'static str,
    /// A sentence worth telling.
    pub(crate) note: Option<String>,
}

/// Finds the quantity of a data set whose images are of `modality`. Frames of an enhanced PET image get the rescale that
/// leads to its unit.
///
/// # Errors
/// Where a dose grid has no believable scale.
pub(crate) fn quantity(
    data: &DataSet,
    modality: Modality,
    code: &str,
    frames: &mut [Frame],
) -> Result<Quantity, FieldFault> {
    let plain = |unit| Quantity { factor: 1.0, unit, note: None };
    match (modality, code) {
        (Modality::Ct, _) => Ok(plain("HU")),
        (Modality::Pet, _) => Ok(pet(data, frames)),
        (_, "RTDOSE") => {
            let Some(factor) = data.decimal(attr::DOSE_GRID_SCALING)? else { return Ok(plain("")) };
            if !factor.is_normal() || !(1e-30..1e30).contains(&factor) {
                return Err(FieldFault::new(attr::DOSE_GRID_SCALING, format!("is {factor}, no scale")));
            }
            let unit = if data.text(attr::DOSE_UNITS).as_deref() == Some("GY") { "Gy" } else { "" };
            let note = (unit == "Gy").then(|| "values are doses in Gy".to_owned());
            Ok(Quantity { factor, unit, note })
        }
        _ => Ok(plain("")),
    }
}

fn pet(data: &DataSet, frames: &mut [Frame]) -> Quantity {
    let told = |unit, note: &str| Quantity { factor: 1.0, unit, note: Some(note.to_owned()) };
    let units = data.text(attr::UNITS);
    // An enhanced image has it frame by frame.
    let of_frame = frames.first().and_then(|frame| frame.real_world).map(|real_world| real_world.unit);
    let is_of_all = |unit| frames.iter().all(|frame| frame.real_world.is_some_and(|real| real.unit == unit));
    let enhanced = of_frame.filter(|unit| units.is_none() && is_of_all(*unit));
    if enhanced.is_some() {
        let rescale =
            |frame: &mut Frame| frame.rescale = frame.real_world.map_or(frame.rescale, |real| real.rescale);
        frames.iter_mut().for_each(rescale);
    }
    let factor = if enhanced.is_some() { enhanced_suv_factor } else { suv_factor };
    match enhanced.or(units.as_deref()) {
        Some("BQML") => match factor(data) {
            Ok(factor) => Quantity {
                factor,
                unit: "SUV",
                note: Some("values are SUV (body weight), made from Bq/ml".to_owned()),
            },
            Err(why) => told("Bq/ml", &format!("values are Bq/ml; no SUV, for {why}")),
        },
        Some("GML") => told("SUV", "values are SUV as the scanner gives them (g/ml)"),
        Some("CNTS") => told("counts", "values are counts, which are no SUV"),
        _ => Quantity { factor: 1.0, unit: "", note: None },
    }
}

/// What Bq/ml are multiplied by to become the standardized uptake value by body weight, in g/ml: weight over the dose
/// that was left when the scan began (QIBA, <https://qibawiki.rsna.org/index.php/Standardized_Uptake_Value_(SUV)>).
///
/// # Errors
/// What is missing.
fn suv_factor(data: &DataSet) -> Result<f64, &'static str> {
    let corrections = data.texts(attr::CORRECTED_IMAGE);
    let corrected = |name: &str| corrections.iter().any(|correction| correction == name);
    if !corrected("ATTN") || !corrected("DECY") {
        return Err(NOT_CORRECTED);
    }
    let weight = body_weight(data)?;
    let item = data.items(attr::RADIOPHARMACEUTICAL_INFORMATION_SEQUENCE).first();
    let item = item.ok_or("the radiopharmaceutical is not given")?;
    // Less than a tenth of a megabecquerel was surely written in another unit.
    let dose = positive(item, attr::RADIONUCLIDE_TOTAL_DOSE)
        .filter(|bq| (1e5..1e12).contains(bq))
        .ok_or("the dose is not given in Bq")?;
    let left = match data.text(attr::DECAY_CORRECTION).as_deref() {
        Some("ADMIN") => 1.0,
        Some("START") => {
            let half_life =
                positive(item, attr::RADIONUCLIDE_HALF_LIFE).ok_or("the half-life is not given")?;
            let given = item
                .seconds_of_day(attr::RADIOPHARMACEUTICAL_START_DATE_TIME)
                .or_else(|| item.seconds_of_day(attr::RADIOPHARMACEUTICAL_START_TIME))
                .ok_or("the time of injection is not given")?;
            let scan = data.seconds_of_day(attr::SERIES_TIME).ok_or("the time of the scan is not given")?;
            // A series made anew has a time that says nothing about the scan.
            let acquired = data.seconds_of_day(attr::ACQUISITION_TIME).unwrap_or(scan);
            let same_day = data.text(attr::SERIES_DATE) == data.text(attr::ACQUISITION_DATE)
                || data.bytes(attr::ACQUISITION_DATE).is_none();
            if !same_day || scan > acquired + 1.0 {
                return Err("the series was made after the scan");
            }
            const DAY: f64 = 86_400.0;
            (-(scan - given).rem_euclid(DAY) / half_life).exp2()
        }
        _ => return Err("it is not said to which time decay is corrected"),
    };
    Ok(weight * 1000.0 / (dose * left))
}

const NOT_CORRECTED: &str = "the image is not corrected for attenuation and decay";

/// As [`suv_factor`], of an enhanced PET image (PS3.3 C.8.22).
fn enhanced_suv_factor(data: &DataSet) -> Result<f64, &'static str> {
    let corrected = |attribute| data.text(attribute).as_deref() == Some("YES");
    if !corrected(attr::ATTENUATION_CORRECTED) || !corrected(attr::DECAY_CORRECTED) {
        return Err(NOT_CORRECTED);
    }
    let weight = body_weight(data)?;
    let item = match data.items(attr::RADIOPHARMACEUTICAL_INFORMATION_SEQUENCE) {
        [] => return Err("the radiopharmaceutical is not given"),
        [item] => item,
        _ => return Err("several radiopharmaceuticals were given"),
    };
    // Here in MBq (C.8.22.4), where classic images have Bq; as many MBq as Bq would be were surely written in these.
    let dose = positive(item, attr::RADIONUCLIDE_TOTAL_DOSE)
        .filter(|mbq| (0.1..1e5).contains(mbq))
        .ok_or("the dose is not given in MBq")?;
    let half_life = positive(item, attr::RADIONUCLIDE_HALF_LIFE).ok_or("the half-life is not given")?;
    let (given, given_zone) = item
        .instant(attr::RADIOPHARMACEUTICAL_START_DATE_TIME)
        .ok_or("the time of injection is not given")?;
    let (corrected_to, zone) = data
        .instant(attr::DECAY_CORRECTION_DATE_TIME)
        .ok_or("it is not said to which time decay is corrected")?;
    let ahead = match (given_zone, zone) {
        (Some(given), Some(zone)) => zone - given,
        (None, None) => 0.0,
        _ => return Err("one of its times has a time zone and the other has none"),
    };
    let elapsed = corrected_to - given - ahead;
    // Nobody scans what has decayed to a thousandth.
    if !(-1.0..10.0 * half_life).contains(&elapsed) {
        return Err("decay is corrected to a time that makes no sense");
    }
    Ok(weight * 1000.0 / (dose * 1e6 * (-elapsed / half_life).exp2()))
}

fn positive(data: &DataSet, attribute: Attribute) -> Option<f64> {
    data.decimal(attribute).ok().flatten().filter(|x| *x > 0.0)
}

fn body_weight(data: &DataSet) -> Result<f64, &'static str> {
    positive(data, attr::PATIENT_WEIGHT)
        .filter(|kg| (0.1..1000.0).contains(kg))
        .ok_or("the body weight is not given")
}

/// A table from stored values to those of the modality (PS3.3 C.11.1.1).
#[derive(Debug, PartialEq)]
pub(crate) struct ModalityLut {
    /// The stored value of the first entry.
    first: i64,
    /// Never empty.
    entries: Vec<u16>,
}

impl ModalityLut {
    /// The table of a data set, if it has one.
    ///
    /// # Errors
    /// Where the table is not what its descriptor says.
    pub(crate) fn of(data: &DataSet, signed: bool) -> Result<Option<Self>, FieldFault> {
        let Some(item) = data.items(attr::MODALITY_LUT_SEQUENCE).first() else { return Ok(None) };
        let Some([count, first, bits]) =
            item.words(attr::LUT_DESCRIPTOR).and_then(|words| <[u16; 3]>::try_from(words).ok())
        else {
            return Err(FieldFault::new(attr::LUT_DESCRIPTOR, "does not have three values"));
        };
        // PS3.3 C.11.1.1.1: 0 stands for 65536, and the first value mapped has the sign of the pixels.
        let count = if count == 0 { 1 << 16 } else { usize::from(count) };
        let first = if signed { i64::from(first as i16) } else { i64::from(first) };
        let entries = match item.bytes(attr::LUT_DATA) {
            // Some writers pack entries of 8 bits.
            Some(bytes) if bits <= 8 && bytes.len() < 2 * count && bytes.len() >= count => {
                bytes[..count].iter().map(|&b| b.into()).collect()
            }
            _ => item.words(attr::LUT_DATA).unwrap_or_default(),
        };
        if entries.len() < count {
            let problem = format!("has {} entries where its descriptor says {count}", entries.len());
            return Err(FieldFault::new(attr::LUT_DATA, problem));
        }
        Ok(Some(Self { first, entries: entries[..count].to_vec() }))
    }

    /// The value of a stored one; beyond the table the nearest entry counts.
    #[inline]
    pub(crate) fn get(&self, stored: i64) -> u16 {
        let index = (stored - self.first).clamp(0, self.entries.len() as i64 - 1);
        self.entries[index as usize]
    }

    /// The largest value of the table.
    pub(crate) fn largest(&self) -> u16 {
        self.entries.iter().copied().max().unwrap_or(0)
    }
}
