//! What a segmentation says of its segments.

use crate::{
    colors,
    dicom::{
        elements::{attributes as attr, charset::Charset, data_set::DataSet},
        header::{names::PatientNames, palette},
    },
};

/// Segments that are named in the report.
const MOST_NAMED: usize = 64;

/// What the frames of a segmentation hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// One segment each: in or out.
    Binary,
    /// One segment each: probability or occupancy, up to this.
    Fractional(u32),
    /// Numbers of segments.
    Labels,
}

impl Kind {
    pub(crate) fn of(data: &DataSet) -> Self {
        match data.text(attr::SEGMENTATION_TYPE).as_deref() {
            Some("FRACTIONAL") => {
                Kind::Fractional(data.unsigned(attr::MAXIMUM_FRACTIONAL_VALUE).unwrap_or(255).max(1))
            }
            Some("LABELMAP") => Kind::Labels,
            _ => Kind::Binary,
        }
    }
}

/// Whether a data set is a segmentation that is made of pixels.
pub(crate) fn is_segmentation(data: &DataSet) -> bool {
    let sop_class = data.text(attr::SOP_CLASS_UID).unwrap_or_default();
    ["1.2.840.10008.5.1.4.1.1.66.4", "1.2.840.10008.5.1.4.1.1.66.7"].contains(&sop_class.as_str())
}

/// What is not an image, but tells which voxels belong to what.
#[derive(Clone, Debug)]
pub(crate) struct Segmentation {
    pub(crate) kind: Kind,
    pub(crate) segments: Vec<Segment>,
    /// Whether the file says where its frames lie.
    pub(crate) has_places: bool,
    /// SeriesInstanceUID of what it was made on.
    pub(crate) referenced_series: Option<String>,
}

/// A segment of a segmentation.
#[derive(Clone, Debug)]
pub(crate) struct Segment {
    /// The value of its voxels.
    pub(crate) number: u32,
    /// Empty where none may be told.
    pub(crate) name: String,
    /// As it is best shown, by its own word or the palette's; linear, sRGB primaries.
    pub(crate) color: Option<[f64; 3]>,
}

impl Segmentation {
    /// The description in a data set. Nothing is required: segments without a name have numbers.
    pub(crate) fn of(data: &DataSet, has_places: bool) -> Self {
        let names = PatientNames::of(data);
        let label = |item: &DataSet| {
            let number = item.unsigned(attr::SEGMENT_NUMBER)?;
            // No longer than it may be, and of one piece: a damaged one may reach into what is said of the patient.
            let label = Charset::of(item, data).text(item, attr::SEGMENT_LABEL);
            let label = label.filter(|label| label.chars().count() <= 64 && !label.contains('\0'));
            let cielab = item.words(attr::RECOMMENDED_DISPLAY_CIELAB_VALUE);
            let cielab: Option<[u16; 3]> = cielab.and_then(|words| words.try_into().ok());
            let color = cielab.map(colors::from_dicom_lab);
            let color = color.or_else(|| palette::color(data, number).map(colors::from_srgb));
            Some(Segment { number, name: names.without(&label.unwrap_or_default()), color })
        };
        // A label map may describe what belongs to no segment, too.
        let segments = data.items(attr::SEGMENT_SEQUENCE).iter().filter_map(label);
        let segments: Vec<Segment> = segments.filter(|segment| segment.number != 0).collect();
        let series = data.items(attr::REFERENCED_SERIES_SEQUENCE).first();
        Self {
            kind: Kind::of(data),
            has_places,
            segments,
            referenced_series: series.and_then(|item| item.text(attr::SERIES_INSTANCE_UID)),
        }
    }

    /// Whether values are fractions of the only segment.
    pub(crate) fn is_one_fraction(&self) -> bool {
        matches!(self.kind, Kind::Fractional(_)) && self.segments.len() <= 1
    }

    /// What the report says.
    pub(crate) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        notes.push(match self.kind {
            _ if self.is_one_fraction() => {
                "a fractional segmentation: values are fractions from 0 to 1".to_owned()
            }
            Kind::Fractional(_) => {
                "a fractional segmentation: values are numbers of segments, where one fills at least half"
                    .to_owned()
            }
            _ => "a segmentation: values are numbers of segments".to_owned(),
        });
        let named: Vec<String> = self
            .segments
            .iter()
            .take(MOST_NAMED)
            .map(|segment| format!("{} {}", segment.number, segment.name).trim_end().to_owned())
            .collect();
        if self.segments.iter().any(|segment| !segment.name.is_empty()) {
            notes.push(format!("segments: {}", named.join(", ")));
        }
        notes
    }
}
