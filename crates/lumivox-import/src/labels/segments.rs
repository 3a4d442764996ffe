//! What 3D Slicer writes of the segments of a segmentation into the header of a NRRD file (`.seg.nrrd`).

use std::path::Path;

use super::table;
use crate::{colors, error::ImportError, nrrd, text_header::Fields};

/// More segments than these are not believed.
const MOST_SEGMENTS: usize = 1 << 12;

/// A segment of a segmentation.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Segment {
    pub name: String,
    /// Linear, sRGB primaries.
    pub color: Option<[f64; 3]>,
    /// The value of its voxels.
    pub value: i128,
    /// The layer that they are in, from 0.
    pub layer: usize,
}

/// The segments that a NRRD header tells of; none in one that is no segmentation.
///
/// # Errors
/// [`ImportError`] names the field.
pub(crate) fn read(path: &Path, allow_outside_data: bool) -> Result<Vec<Segment>, ImportError> {
    let fields = nrrd::fields(path, allow_outside_data)?;
    (0..MOST_SEGMENTS).map_while(|n| segment(&fields, n).transpose()).collect()
}

/// Segment `n` of a header, if there is one.
fn segment(fields: &Fields<'_>, n: usize) -> Result<Option<Segment>, ImportError> {
    let get = |what: &str| fields.get(&[&format!("Segment{n}_{what}")]);
    let (name, id, value) = (get("Name"), get("ID"), get("LabelValue"));
    if name.is_none() && id.is_none() && value.is_none() {
        return Ok(None);
    }
    // Before 3D Slicer 4.11 each segment had a layer of its own, of zeros and ones.
    let value = value.map_or(Ok(1), |field| fields.number(field, "a whole number"))?;
    let layer = get("Layer").map_or(Ok(n), |field| fields.number(field, "a number of a layer"))?;
    let color = match get("Color") {
        None => None,
        Some(field) => {
            let codes: Vec<f64> = fields.numbers(field, 3, "parts of red, green and blue")?;
            let is_color = codes.iter().all(|code| (0.0..=1.0).contains(code));
            if !is_color {
                return Err(fields.bad(field, "parts of red, green and blue from 0 to 1"));
            }
            Some(colors::from_srgb([codes[0], codes[1], codes[2]]))
        }
    };
    let name = name.or(id).map(|field| table::clean(&field.value)).unwrap_or_default();
    Ok(Some(Segment { name, color, value, layer }))
}
