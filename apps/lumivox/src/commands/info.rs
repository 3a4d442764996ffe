//! `lumivox info`: what a scan holds. Nothing that names a patient: no DICOM text, no names of files.

use std::{collections::BTreeMap, fmt::Write, path::PathBuf};

use lumivox_core::{
    Label, LabelVolume, Preset, ValueStatistics, Volume,
    color::srgb_from_linear,
    looks_like_labels,
    placement::side_letters,
    words::{lengths, number},
};
use lumivox_import::{ImportReport, Imported, ImportedLabels};
use lumivox_segmentation::{Finding, PatientAlone, patient_alone};
use serde_json::{Value, json};

use crate::{
    args::InfoArgs,
    exit::{self, Failure},
    inputs::{self, modality},
    opening::check_are_scans,
    output,
    progress::Reporter,
};

/// Bins of the histogram that is counted.
const BINS: usize = 4096;

/// Rows of the histogram that is drawn.
const ROWS: usize = 24;

/// Columns of its longest bar.
const COLUMNS: usize = 48;

/// What percentiles are told.
const PERCENTILES: [f64; 5] = [1.0, 25.0, 50.0, 75.0, 99.0];

/// Prints what each scan holds.
pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    inputs::check(&args.input)?;
    check_are_scans(&args.input)?;
    let cancel = exit::cancel_on_ctrl_c()?;
    let reporter = Reporter::new(args.json || args.quiet);
    let scans = inputs::load(&args.input, reporter, &cancel)?;
    let paths = inputs::scans(&args.input.inputs);
    let look = |(scan, paths): (Imported, Vec<PathBuf>)| {
        let statistics = ValueStatistics::new(&scan.volume, BINS);
        let labels = match &paths[..] {
            [path] if looks_like_labels(&scan.volume) => {
                inputs::labels(&args.input, path, reporter, &cancel)?
            }
            _ => None,
        };
        let percentiles = scan.volume.percentiles(&PERCENTILES.map(|p| p / 100.0));
        let alone = reporter.stages(|progress| patient_alone(scan.volume, progress, &cancel))?;
        Ok(Known { statistics, percentiles, alone, labels, report: scan.report })
    };
    let scans = scans.into_iter().zip(paths).map(look).collect::<Result<Vec<_>, Failure>>()?;
    let text = if args.json {
        let scans: Vec<Value> = scans.iter().map(to_json).collect();
        format!("{:#}\n", json!({ "scans": scans }))
    } else {
        let heading =
            |i| if scans.len() > 1 { format!("Scan {} of {}\n", i + 1, scans.len()) } else { String::new() };
        scans.iter().enumerate().map(|(i, scan)| heading(i) + &to_text(scan)).collect::<Vec<_>>().join("\n")
    };
    output::print(&text)
}

/// What is told about a scan.
struct Known {
    /// Of the values as they were scanned.
    statistics: ValueStatistics,
    /// Those of [`PERCENTILES`], of the same values.
    percentiles: Vec<f64>,
    /// What 'render' shows of it.
    alone: PatientAlone,
    /// Of a label map.
    labels: Option<ImportedLabels>,
    report: ImportReport,
}

/// Towards which sides of the patient the axes run: `L`, or `LP` where they are oblique.
fn axes(volume: &Volume) -> [String; 3] {
    /// As PatientOrientation (0020,0020) does: what contributes little is left out. Here, under 6 degrees.
    const LEAST: f64 = 0.1;
    let directions = volume.directions();
    [directions.x_axis, directions.y_axis, directions.z_axis].map(|axis| side_letters(axis, LEAST))
}

/// Reasons for leaving files out, with how many. Names of files stay out: hospitals put patients' names there.
fn skipped(report: &ImportReport) -> BTreeMap<&str, usize> {
    let mut reasons = BTreeMap::new();
    for file in &report.skipped {
        *reasons.entry(file.reason.as_str()).or_default() += 1;
    }
    reasons
}

fn to_text(scan: &Known) -> String {
    let Known { statistics, percentiles, alone, labels, report } = scan;
    let volume = &alone.volume;
    let unit = volume.unit();
    let mut rows: Vec<(&str, String)> = Vec::new();
    let three = |v: [String; 3], between: &str| v.join(between);
    rows.push(("format", report.format.clone()));
    rows.push(("modality", modality(volume).unwrap_or("not known").to_owned()));
    rows.push(("voxels", three(volume.dims().map(|n| n.to_string()), " x ")));
    rows.push(("spacing", lengths(volume.spacing_mm().to_array(), 4)));
    rows.push(("size", lengths(volume.size_mm().to_array(), 1)));
    rows.push(("axes run to", format!("{}  (L left, P posterior, H head)", three(axes(volume), ", "))));
    rows.push((
        "centre",
        format!("{} mm (LPS)", three(volume.center_mm().to_array().map(|c| format!("{c:.1}")), ", ")),
    ));
    let megabytes = volume.voxels().as_bytes().len() as f64 / 1e6;
    rows.push((
        "memory",
        format!("{megabytes:.1} MB, {} bits a voxel", 8 * volume.voxels().bytes_per_sample()),
    ));
    let [low, high] = statistics.range.map(number);
    rows.push(("values", format!("{low} to {high} {unit}").trim_end().to_owned()));
    let told = |(p, value): (f64, &f64)| format!("{p}%: {}", number(*value));
    let percentiles: Vec<String> = PERCENTILES.into_iter().zip(percentiles).map(told).collect();
    rows.push(("percentiles", percentiles.join("  ")));
    if let Some(found) = &alone.report {
        let parts: Vec<String> =
            found.findings.iter().map(|part| format!("{} {}", part.class.name(), part.size())).collect();
        let parts =
            if found.is_sure() { parts.join(", ") } else { "what is the patient is not sure".to_owned() };
        rows.push(("shows", parts));
        rows.push(("", format!("confidence {:.2} of 1", found.confidence)));
    }
    let preset = Preset::default_for(volume);
    rows.push(("preset", format!("{} ({})", preset.name(), preset.description())));

    let mut text = String::new();
    for (name, value) in rows {
        let _ = writeln!(text, "{name:>12}  {value}");
    }
    if report.series.len() > 1 {
        text += "\nSeries (take another with --series):\n";
        for (place, series) in report.series.iter().enumerate() {
            let mark = if place == report.chosen { '*' } else { ' ' };
            let _ = writeln!(text, "{mark} {}  {}", place + 1, series.description);
        }
    }
    let notes = notes(scan, volume);
    if !notes.is_empty() {
        text += "\nNotes:\n";
        notes.iter().for_each(|note| text += &format!("  {note}\n"));
    }
    let skipped = skipped(report);
    if !skipped.is_empty() {
        text += "\nLeft out:\n";
        skipped.iter().for_each(|(reason, count)| text += &format!("  {count} x {reason}\n"));
    }
    match labels {
        Some(labels) => text + "\nLabels:\n" + &label_list(&labels.labels),
        None => text + "\n" + &histogram(statistics, unit),
    }
}

/// Number, colour, size and name of each label.
fn label_list(labels: &LabelVolume) -> String {
    let counts = labels.counts();
    let line = |label: &Label| {
        let ml = counts[usize::from(label.value)] as f64 * labels.voxel_mm3() / 1000.0;
        format!("{:>12}  {}  {ml:10.2} ml  {}\n", label.value, hex(label.color), label.name)
    };
    labels.labels().iter().map(line).collect()
}

/// A linear colour as `#rrggbb` of sRGB.
fn hex(color: [f64; 3]) -> String {
    let [r, g, b] = color.map(|part| (255.0 * srgb_from_linear(part)).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// What is worth knowing of the files and of what they show.
fn notes<'a>(scan: &'a Known, volume: &Volume) -> Vec<&'a str> {
    let found = scan.alone.report.iter().flat_map(|found| &found.notes);
    // Those on the labels hold those on the file.
    let file = scan.labels.as_ref().map_or(&scan.report.notes, |labels| &labels.report.notes);
    let of_holes = inputs::note_of_holes(&scan.report, volume);
    file.iter().map(String::as_str).chain(of_holes).chain(found.map(String::as_str)).collect()
}

/// The histogram, one row per range of values, bars by the logarithm of the count: air outnumbers everything.
fn histogram(statistics: &ValueStatistics, unit: &str) -> String {
    let [low, high] = statistics.range;
    let per_row = statistics.histogram.len().div_ceil(ROWS);
    let counts: Vec<u64> = statistics.histogram.chunks(per_row).map(|bins| bins.iter().sum()).collect();
    let total: u64 = counts.iter().sum();
    let most = counts.iter().copied().max().unwrap_or(0).max(1);
    let bin = (high - low) / statistics.histogram.len() as f64;
    let mut text =
        format!("{:>12}  voxels, logarithmic\n", if unit.is_empty() { "value from" } else { unit });
    for (row, &count) in counts.iter().enumerate() {
        let from = number(low + (row * per_row) as f64 * bin);
        // Eighths of a column.
        let length =
            ((count as f64 + 1.0).ln() / (most as f64 + 1.0).ln() * COLUMNS as f64 * 8.0).round() as usize;
        let mut bar = "█".repeat(length / 8);
        bar.extend(['▏', '▎', '▍', '▌', '▋', '▊', '▉'].get((length % 8).wrapping_sub(1)));
        let share = 100.0 * count as f64 / total.max(1) as f64;
        let padding = " ".repeat((COLUMNS + 1).saturating_sub(bar.chars().count()));
        let _ = writeln!(text, "{from:>12}  {bar}{padding}{share:7.3}%");
        // All values are the same: one row says it.
        if bin <= 0.0 {
            break;
        }
    }
    text
}

fn to_json(scan: &Known) -> Value {
    let Known { statistics, percentiles, alone, labels, report } = scan;
    let volume = &alone.volume;
    let shows = alone.report.as_ref().map(|found| {
        let part = |part: &Finding| json!({ "what": part.class.name(), "volume_mm3": part.volume_mm3 });
        let parts: Vec<Value> = found.findings.iter().map(part).collect();
        json!({ "parts": parts, "confidence": found.confidence })
    });
    let labels = labels.as_ref().map(|labels| {
        let labels = &labels.labels;
        let counts = labels.counts();
        let label = |label: &Label| {
            let voxels = counts[usize::from(label.value)];
            json!({
                "value": label.value,
                "name": label.name,
                "color": hex(label.color),
                "volume_mm3": voxels as f64 * labels.voxel_mm3(),
            })
        };
        labels.labels().iter().map(label).collect::<Vec<Value>>()
    });
    let percentiles: serde_json::Map<String, Value> =
        PERCENTILES.iter().zip(percentiles).map(|(p, value)| (p.to_string(), json!(value))).collect();
    let place = volume.patient_from_voxel();
    let columns = [place.matrix3.x_axis, place.matrix3.y_axis, place.matrix3.z_axis, place.translation];
    json!({
        "format": report.format,
        "modality": modality(volume),
        "dims": volume.dims(),
        "spacing_mm": volume.spacing_mm().to_array(),
        "size_mm": volume.size_mm().to_array(),
        "center_mm": volume.center_mm().to_array(),
        "orientation": axes(volume),
        "patient_from_voxel_columns": columns.map(|c| c.to_array()),
        "bits": 8 * volume.voxels().bytes_per_sample(),
        "unit": volume.unit(),
        "value_range": statistics.range,
        "percentiles": percentiles,
        "histogram": { "range": statistics.range, "counts": statistics.histogram },
        "shows": shows,
        "labels": labels,
        "preset": Preset::default_for(volume).name(),
        "series": report.series.iter().map(|s| json!({
            "id": s.uid, "description": s.description, "files": s.files,
        })).collect::<Vec<_>>(),
        "chosen_series": report.chosen,
        "notes": notes(scan, volume),
        "skipped": skipped(report),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_histogram_has_bars_and_survives_a_single_value() {
        let statistics = ValueStatistics { range: [-1000.0, 3000.0], histogram: vec![10; 4096] };
        let text = histogram(&statistics, "HU");
        assert_eq!(text.lines().count(), ROWS + 1, "{text}");
        assert!(text.lines().nth(1).unwrap().contains("-1000  ████"));
        let mut one = ValueStatistics { range: [5.0, 5.0], histogram: vec![0; 4096] };
        one.histogram[0] = 50;
        assert_eq!(histogram(&one, "").lines().count(), 2);
    }
}
