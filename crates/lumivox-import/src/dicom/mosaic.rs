//! Siemens mosaics: all slices of a volume tiled in one picture, with their places in a private header (CSA).
//!
//! The header's layout is known from NiBabel's documentation, "Siemens format DICOM with CSA header".

use lumivox_core::glam::DVec3;

use super::{attributes as attr, elements::DataSet, frames::Frame};

/// More tiles than any scanner makes.
const MOST_TILES: usize = 1024;

/// How a picture is tiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mosaic {
    /// Tiles from left to right, and from top to bottom.
    pub(crate) across: usize,
    /// Tiles that are slices; the last ones are empty.
    pub(crate) slices: usize,
}

/// What the private header says about a mosaic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Layout {
    pub(crate) mosaic: Mosaic,
    /// Unit direction from slice to slice.
    normal: Option<DVec3>,
}

impl Layout {
    /// The layout of a picture of `columns` x `rows` pixels, if its header tells it.
    pub(crate) fn of(data: &DataSet, columns: usize, rows: usize) -> Option<Self> {
        // Anonymizers may take the creator's name and leave the block, which names its elements itself.
        let private = attr::SIEMENS_CSA_HEADER;
        let csa = data.bytes(data.find_private(private).unwrap_or(private.in_block(0x10)))?;
        let slices = csa_numbers(csa, "NumberOfImagesInMosaic")?.first().copied()?;
        if slices.fract() != 0.0 || !(1.0..=MOST_TILES as f64).contains(&slices) {
            return None;
        }
        let slices = slices as usize;
        let across = (1..).find(|across| across * across >= slices)?;
        if !columns.is_multiple_of(across) || !rows.is_multiple_of(across) {
            return None;
        }
        let normal = csa_numbers(csa, "SliceNormalVector").and_then(|values| {
            <[f64; 3]>::try_from(values).ok().and_then(|v| DVec3::from_array(v).try_normalize())
        });
        Some(Self { mosaic: Mosaic { across, slices }, normal })
    }

    /// The slices of a picture, given as one frame whose tiles have `columns` x `rows` pixels.
    pub(crate) fn slices(&self, picture: &Frame, columns: usize, rows: usize) -> Vec<Frame> {
        let spare = (self.mosaic.across - 1) as f64 / 2.0;
        // The position given is that of the corner of a picture of this size around the first slice's centre.
        let to_first = picture.row_direction * (picture.spacing_mm.x * columns as f64 * spare)
            + picture.column_direction * (picture.spacing_mm.y * rows as f64 * spare);
        let plane_normal = picture.row_direction.cross(picture.column_direction);
        let normal = match self.normal {
            Some(normal) if normal.dot(plane_normal) < 0.0 => -plane_normal,
            _ => plane_normal,
        };
        let slice = |k: usize| Frame {
            position: picture.position.map(|p| p + to_first + normal * (picture.thickness_mm * k as f64)),
            ..picture.clone()
        };
        (0..self.mosaic.slices).map(slice).collect()
    }
}

/// The numbers of element `name` of a CSA header. Nothing in it is believed; `None` wherever it ends early.
fn csa_numbers(csa: &[u8], name: &str) -> Option<Vec<f64>> {
    let long = |at: usize| {
        let four = csa.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes([four[0], four[1], four[2], four[3]]) as usize)
    };
    // The newer form has a magic number and four bytes more.
    let newer = csa.starts_with(b"SV10");
    let start = if newer { 8 } else { 0 };
    let (elements, mut at) = (long(start)?, start + 8);
    let mut first_items = None;
    for _ in 0..elements.min(4096) {
        // Name (64), VM, VR (4), syngo's type, number of items, a check number.
        let found = csa.get(at..at.checked_add(84)?)?;
        let is_it = found[..64].split(|b| *b == 0).next() == Some(name.as_bytes());
        let items = long(at + 76)?;
        let multiplicity = long(at + 64)?;
        let first_items = *first_items.get_or_insert(items);
        at += 84;
        let mut numbers = Vec::new();
        for index in 0..items.min(4096) {
            // The older form counts the items of the first element on top.
            let length = if newer { long(at + 4)? } else { long(at)?.checked_sub(first_items)? };
            at += 16;
            let text = csa.get(at..at.checked_add(length)?)?;
            if is_it && index < multiplicity.max(1) {
                let text = String::from_utf8_lossy(text);
                let text = text.split('\0').next().unwrap_or_default().trim();
                if let Ok(number) = text.parse::<f64>()
                    && number.is_finite()
                {
                    numbers.push(number);
                }
            }
            at = at.checked_add(length.next_multiple_of(4))?;
        }
        if is_it {
            return Some(numbers);
        }
    }
    None
}
