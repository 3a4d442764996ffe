//! Standardized uptake values of PET, after QIBA's pseudo-code
//! (<https://qibawiki.rsna.org/index.php/Standardized_Uptake_Value_(SUV)>).
//!
//! SUV by body weight is the activity over what was injected and is left when decay is corrected to, times the weight.
//! Where a part of that is missing or makes no sense, values stay what they are and the reason is told.

use crate::dicom::{
    elements::{
        attributes::{self as attr, Attribute},
        data_set::DataSet,
    },
    frames::frame::{Frame, take_real_world},
    header::units::Quantity,
};

const DAY: f64 = 86_400.0;
/// What has decayed for so many half-lives is not scanned any more.
const MOST_HALF_LIVES: f64 = 10.0;
/// A dynamic scan begins before the injection, to see the first pass: by seconds, by minutes where somebody was late. No
/// other scan does, and one that seems to begin much earlier has a time that is wrong.
const MOST_SECONDS_BEFORE: f64 = 300.0;
/// Nuclides that decay no faster are scanned days after the injection, too, so that a time of day does not suffice.
const SCANNED_FOR_DAYS: f64 = 10.0 * 3600.0;

/// What the values of a PET image are.
pub(crate) fn pet(data: &DataSet, frames: &mut [Frame]) -> Quantity {
    let data = &with_leftovers(data);
    let units = data.text(attr::UNITS);
    // An enhanced image has it frame by frame.
    let of_frame = frames.first().and_then(|frame| Some(frame.real_world.as_ref()?.unit.clone()));
    let is_of_all = |unit: &str| {
        frames.iter().all(|frame| frame.real_world.as_ref().is_some_and(|real| real.unit == unit))
    };
    let enhanced = of_frame.filter(|unit| units.is_none() && is_of_all(unit));
    if let Some(unit) = enhanced {
        take_real_world(frames);
        return match &*unit {
            "BQML" => by_weight(enhanced_suv_factor(data), 1.0),
            "GML" => as_given(data),
            "" => Quantity::told("", "values are plain numbers, which are no SUV"),
            _ => Quantity::told(unit.clone(), format!("values are {unit}, which are no SUV")),
        };
    }
    match units.as_deref() {
        Some("BQML") => by_weight(suv_factor(data), 1.0),
        Some("GML") => as_given(data),
        Some("CNTS") => counts(data),
        _ => Quantity { factor: 1.0, unit: "".into(), note: None },
    }
}

/// A legacy converted image keeps what it was converted from, and has no place for, in sequences of its own
/// (PS3.3 C.7.6.16.2.25): of a data set with them, all values as if it had them itself.
fn with_leftovers(data: &DataSet) -> DataSet {
    let group = |sequence| data.items(sequence).first();
    let shared = group(attr::SHARED_FUNCTIONAL_GROUPS_SEQUENCE);
    let own = group(attr::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE);
    fn leftovers(group: Option<&DataSet>, of: Attribute) -> Option<&DataSet> {
        group?.items(of).first()
    }
    let others = [
        leftovers(shared, attr::UNASSIGNED_SHARED_CONVERTED_ATTRIBUTES_SEQUENCE),
        leftovers(own, attr::UNASSIGNED_PER_FRAME_CONVERTED_ATTRIBUTES_SEQUENCE),
        leftovers(shared, attr::FRAME_CONTENT_SEQUENCE),
        leftovers(own, attr::FRAME_CONTENT_SEQUENCE),
    ];
    data.completed_by(others.into_iter().flatten(), attr::RADIOPHARMACEUTICAL_INFORMATION_SEQUENCE)
}

/// Activities, `to_bqml` times what is stored in Bq/ml, as SUV if there is a factor for it.
fn by_weight(factor: Result<f64, &str>, to_bqml: f64) -> Quantity {
    match factor {
        Ok(factor) => Quantity {
            factor: factor * to_bqml,
            ..Quantity::told("SUV", "values are SUV (body weight), made from Bq/ml")
        },
        Err(why) => Quantity {
            factor: to_bqml,
            ..Quantity::told("Bq/ml", format!("values are Bq/ml; no SUV, for {why}"))
        },
    }
}

/// Values in g/ml, which are SUV unless something else was divided by.
fn as_given(data: &DataSet) -> Quantity {
    match data.text(attr::SUV_TYPE).as_deref() {
        None | Some("BW") => Quantity::told("SUV", "values are SUV as the scanner gives them (g/ml)"),
        Some(_) => Quantity::told("g/ml", "values are uptake by another measure than body weight (SUVType)"),
    }
}

/// Counts, of which Philips tells what makes SUV or Bq/ml of them.
fn counts(data: &DataSet) -> Quantity {
    let scale = |private| {
        let scale = data.find_private(private).and_then(|scale| positive(data, scale));
        scale.filter(|scale| (1e-30..1e30).contains(scale))
    };
    if let Some(why) = not_corrected(data) {
        return Quantity::told("counts", format!("values are counts; no SUV, for {why}"));
    }
    if let Some(factor) = scale(attr::PHILIPS_SUV_SCALE) {
        let note = "values are SUV (body weight), made from counts by the scanner's own factor";
        return Quantity { factor, ..Quantity::told("SUV", note) };
    }
    match scale(attr::PHILIPS_ACTIVITY_SCALE) {
        Some(to_bqml) => by_weight(suv_factor(data), to_bqml),
        None => Quantity::told("counts", "values are counts, which are no SUV"),
    }
}

/// What Bq/ml are multiplied by to become the standardized uptake value by body weight, in g/ml: weight over the dose
/// that was left when the scan began.
///
/// # Errors
/// What is missing.
fn suv_factor(data: &DataSet) -> Result<f64, &'static str> {
    if let Some(why) = not_corrected(data) {
        return Err(why);
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
            scan_start(data, half_life)?.part_left(data, item, half_life)?
        }
        Some("NONE") => return Err(NO_DECAY_CORRECTION),
        _ => return Err("it is not said to which time decay is corrected"),
    };
    Ok(weight * 1000.0 / (dose * left))
}

const NO_DECAY_CORRECTION: &str = "the image is not corrected for decay";

/// Which correction of a classic image is missing that SUV needs.
fn not_corrected(data: &DataSet) -> Option<&'static str> {
    let corrections = data.texts(attr::CORRECTED_IMAGE);
    let corrected = |name: &str| corrections.iter().any(|correction| correction == name);
    match (corrected("ATTN"), corrected("DECY")) {
        (true, true) => None,
        (true, false) => Some(NO_DECAY_CORRECTION),
        (false, true) => Some("the image is not corrected for attenuation"),
        (false, false) => Some("the image is not corrected for attenuation and decay"),
    }
}

/// A moment of a scan, by the clock where it was made.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Moment {
    /// Seconds since 1970 at midnight before it; `None` where only the time of day is known.
    day: Option<f64>,
    /// Seconds since midnight.
    time: f64,
}

impl Moment {
    /// Of a date and a time of day.
    fn of(data: &DataSet, date: Attribute, time: Attribute) -> Option<Self> {
        Some(Self { day: data.day(date), time: data.seconds_of_day(time)? })
    }

    /// Of both in one.
    fn of_instant(data: &DataSet, attribute: Attribute) -> Option<Self> {
        let (instant, _) = data.instant(attribute)?;
        Some(Self::at(instant))
    }

    fn at(instant: f64) -> Self {
        let time = instant.rem_euclid(DAY);
        Self { day: Some(instant - time), time }
    }

    fn earlier_by(self, seconds: f64) -> Self {
        match self.day {
            Some(day) => Self::at(day + self.time - seconds),
            None => Self { day: None, time: (self.time - seconds).rem_euclid(DAY) },
        }
    }

    /// Seconds since `other`; of times of day alone, less than half a day either way.
    fn since(self, other: Self) -> f64 {
        match (self.day, other.day) {
            (Some(a), Some(b)) => a + self.time - (b + other.time),
            _ => (self.time - other.time + DAY / 2.0).rem_euclid(DAY) - DAY / 2.0,
        }
    }

    /// What part of the dose is left at this moment.
    fn part_left(self, data: &DataSet, drug: &DataSet, half_life: f64) -> Result<f64, &'static str> {
        let stamp = drug.instant(attr::RADIOPHARMACEUTICAL_START_DATE_TIME);
        if let (Some((given, zone)), Some(day)) = (stamp, self.day) {
            // Where both say how far they are ahead of UTC, that counts, too.
            let ahead = match (zone, data.zone(attr::TIMEZONE_OFFSET_FROM_UTC)) {
                (Some(given), Some(scan)) => scan - given,
                _ => 0.0,
            };
            if let Some(left) = part_left_after(day + self.time - given - ahead, half_life) {
                return Ok(left);
            }
            // Anonymizers move one of the dates, which leaves the times of day.
            if half_life >= SCANNED_FOR_DAYS {
                return Err("the injection's date makes no sense");
            }
        }
        if half_life >= SCANNED_FOR_DAYS {
            return Err("the day of the injection is not given, and the nuclide is scanned for days");
        }
        let given = drug
            .seconds_of_day(attr::RADIOPHARMACEUTICAL_START_TIME)
            .or_else(|| drug.seconds_of_day(attr::RADIOPHARMACEUTICAL_START_DATE_TIME))
            .ok_or("the time of injection is not given")?;
        // Midnight may lie between.
        let elapsed = (self.time - given + MOST_SECONDS_BEFORE).rem_euclid(DAY) - MOST_SECONDS_BEFORE;
        part_left_after(elapsed, half_life).ok_or("the time of injection makes no sense")
    }
}

/// What part of a dose is left so many seconds after the injection, or makes up for so many before it; `None` where
/// nobody scans.
fn part_left_after(elapsed: f64, half_life: f64) -> Option<f64> {
    let longest = MOST_HALF_LIVES * half_life;
    let is_scanned = elapsed >= -longest.min(MOST_SECONDS_BEFORE) && elapsed < longest;
    is_scanned.then(|| (-elapsed / half_life).exp2())
}

/// When the scan began, which is the time that decay is corrected to.
///
/// # Errors
/// Where no time is that of the beginning, as in a series that was made anew.
fn scan_start(data: &DataSet, half_life: f64) -> Result<Moment, &'static str> {
    let series = Moment::of(data, attr::SERIES_DATE, attr::SERIES_TIME);
    let acquired = Moment::of(data, attr::ACQUISITION_DATE, attr::ACQUISITION_TIME)
        .or_else(|| Moment::of_instant(data, attr::ACQUISITION_DATE_TIME))
        .or_else(|| Moment::of_instant(data, attr::FRAME_ACQUISITION_DATE_TIME));
    // No scan takes a day: a series that is older than that has a date of its own.
    let is_of_scan =
        |series: &Moment| acquired.is_none_or(|acquired| (-1.0..DAY).contains(&acquired.since(*series)));
    if let Some(series) = series.filter(is_of_scan) {
        return Ok(series);
    }
    if let Some(private) = data.find_private(attr::GE_SCAN_DATE_TIME)
        && let Some(start) = Moment::of_instant(data, private)
    {
        return Ok(start);
    }
    if series.is_none() && acquired.is_none() {
        return Err("the time of the scan is not given");
    }
    // Back from the bed position, whose mean count rate is at the frame's reference time.
    let milliseconds =
        |attribute| data.decimal(attribute).ok().flatten().filter(|ms| *ms > 0.0).map(|ms| ms / 1e3);
    let (Some(acquired), Some(reference), Some(duration)) =
        (acquired, milliseconds(attr::FRAME_REFERENCE_TIME), milliseconds(attr::ACTUAL_FRAME_DURATION))
    else {
        return Err(match series {
            Some(_) => "the series was made after the scan",
            None => "the time of the series is not given",
        });
    };
    let decay = std::f64::consts::LN_2 / half_life;
    let in_frame = decay * duration;
    let mean = (in_frame / -(-in_frame).exp_m1()).ln() / decay;
    Ok(acquired.earlier_by(reference - mean))
}

/// As [`suv_factor`], of an enhanced PET image (PS3.3 C.8.22).
fn enhanced_suv_factor(data: &DataSet) -> Result<f64, &'static str> {
    let corrected = |attribute| data.text(attribute).as_deref() == Some("YES");
    if !corrected(attr::ATTENUATION_CORRECTED) || !corrected(attr::DECAY_CORRECTED) {
        return Err("the image is not corrected for attenuation and decay");
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
    let left = part_left_after(corrected_to - given - ahead, half_life)
        .ok_or("decay is corrected to a time that makes no sense")?;
    Ok(weight * 1000.0 / (dose * 1e6 * left))
}

fn positive(data: &DataSet, attribute: Attribute) -> Option<f64> {
    data.decimal(attribute).ok().flatten().filter(|x| *x > 0.0)
}

fn body_weight(data: &DataSet) -> Result<f64, &'static str> {
    positive(data, attr::PATIENT_WEIGHT)
        .filter(|kg| (0.1..1000.0).contains(kg))
        .ok_or("the body weight is not given")
}
