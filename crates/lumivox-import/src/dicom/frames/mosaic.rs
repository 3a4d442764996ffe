//! Mosaics: all slices of a volume tiled in one picture, with their places in a private header.
//!
//! Siemens has a header of its own for each image (CSA), whose layout is known from NiBabel's documentation, "Siemens
//! format DICOM with CSA header"; where it is lost, the protocol of the series, a text, tells how many slices there are
//! and in which order. United Imaging has a sequence of the slices' positions (ImageType VFRAME; the tags are known from
//! dcm2niix's notes).

use lumivox_core::glam::DVec3;

use crate::dicom::{
    elements::{attributes as attr, data_set::DataSet},
    frames::frame::Frame,
    header::pixel_format::Mosaic,
};

/// More tiles than any scanner makes.
const MOST_TILES: usize = 1024;

/// What the private header says about a mosaic.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    pub(crate) mosaic: Mosaic,
    places: Places,
}

/// Where the slices are.
#[derive(Clone, Debug, PartialEq)]
enum Places {
    /// One after the other along the normal, in this unit direction if it is known.
    Along(Option<DVec3>),
    /// The centre of the first pixel of each.
    At(Vec<DVec3>),
}

/// Whether a data set calls itself a mosaic.
pub(crate) fn is_mosaic(data: &DataSet) -> bool {
    data.texts(attr::IMAGE_TYPE).iter().any(|value| value == "MOSAIC" || value == "VFRAME")
}

impl Layout {
    /// The layout of a picture of `columns` x `rows` pixels, if its header tells it.
    pub(crate) fn of(data: &DataSet, columns: usize, rows: usize) -> Option<Self> {
        Self::of_siemens(data, columns, rows).or_else(|| Self::of_united_imaging(data, columns, rows))
    }

    fn of_siemens(data: &DataSet, columns: usize, rows: usize) -> Option<Self> {
        // Anonymizers may take the creator's name and leave the block, which names its elements itself.
        let header = |private| data.bytes(data.find_nameless_private(private));
        let of_image = header(attr::SIEMENS_CSA_HEADER).and_then(|csa| {
            let slices = csa_numbers(csa, "NumberOfImagesInMosaic")?.first().copied()?;
            Some((slices, csa_numbers(csa, "SliceNormalVector").and_then(direction)))
        });
        let (slices, normal) = of_image.or_else(|| {
            let protocol = Protocol(header(attr::SIEMENS_CSA_SERIES_HEADER)?);
            Some((protocol.number("sSliceArray.lSize")?, protocol.slice_normal()))
        })?;
        let slices = tiles(slices)?;
        let across = side_of(slices);
        if !columns.is_multiple_of(across) || !rows.is_multiple_of(across) {
            return None;
        }
        Some(Self { mosaic: Mosaic { across, down: across, slices }, places: Places::Along(normal) })
    }

    fn of_united_imaging(data: &DataSet, columns: usize, rows: usize) -> Option<Self> {
        let number = data.decimal(data.find_nameless_private(attr::UIH_SLICES)).ok()??;
        let slices = tiles(number)?;
        let place = |item: &DataSet| {
            let position = item.decimals::<3>(attr::IMAGE_POSITION_PATIENT).ok()??;
            Some(DVec3::from_array(position)).filter(|p| p.abs().max_element() <= 1e6)
        };
        let items = data.private_items(attr::UIH_FRAME_SEQUENCE);
        let places: Vec<DVec3> = items.iter().map(place).collect::<Option<_>>()?;
        let across = side_of(slices);
        // As many rows of tiles as it takes, unless the picture is a square of tiles.
        let needed = slices.div_ceil(across);
        let is_square = |down: usize| rows.is_multiple_of(down) && columns / across == rows / down;
        let down = [needed, across].into_iter().find(|down| is_square(*down)).unwrap_or(needed);
        if places.len() != slices || !columns.is_multiple_of(across) || !rows.is_multiple_of(down) {
            return None;
        }
        Some(Self { mosaic: Mosaic { across, down, slices }, places: Places::At(places) })
    }

    /// The slices of a picture, given as one frame whose tiles have `columns` x `rows` pixels.
    pub(crate) fn slices(&self, picture: &Frame, columns: usize, rows: usize) -> Vec<Frame> {
        let normal = match &self.places {
            Places::At(places) => {
                let slice = |place: &DVec3| Frame { position: Some(*place), ..picture.clone() };
                return places.iter().map(slice).collect();
            }
            Places::Along(normal) => *normal,
        };
        let spare = (self.mosaic.across - 1) as f64 / 2.0;
        // The position given is that of the corner of a picture of this size around the first slice's centre.
        let to_first = picture.row_direction * (picture.spacing_mm.x * columns as f64 * spare)
            + picture.column_direction * (picture.spacing_mm.y * rows as f64 * spare);
        let plane_normal = picture.row_direction.cross(picture.column_direction);
        let normal = match normal {
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

/// A number of tiles.
fn tiles(number: f64) -> Option<usize> {
    (number.fract() == 0.0 && (1.0..=MOST_TILES as f64).contains(&number)).then_some(number as usize)
}

/// How many tiles lie side by side, of so many.
fn side_of(tiles: usize) -> usize {
    (1..).find(|side| side * side >= tiles).expect("squares grow without end")
}

fn direction(values: Vec<f64>) -> Option<DVec3> {
    DVec3::from_array(values.try_into().ok()?).try_normalize()
}

/// Siemens' protocol of a series (ASCCONV): lines of `key = value` somewhere between binary data.
struct Protocol<'a>(&'a [u8]);

impl Protocol<'_> {
    /// The number that a key has, decimal or as `0x1`.
    fn number(&self, key: &str) -> Option<f64> {
        let at = |found: usize| {
            let rest = &self.0[found + key.len()..];
            let line = rest.split(|byte| b"\r\n\0".contains(byte)).next()?;
            let value = std::str::from_utf8(line).ok()?.trim_start().strip_prefix('=')?.trim();
            match value.strip_prefix("0x") {
                Some(digits) => u32::from_str_radix(digits, 16).ok().map(f64::from),
                None => value.parse().ok().filter(|number: &f64| number.is_finite()),
            }
        };
        let found = self.0.windows(key.len()).enumerate().filter(|(_, window)| *window == key.as_bytes());
        found.map(|(found, _)| found).find_map(at)
    }

    /// The unit direction from slice to slice: that of the first slice, against which the slices lie where their
    /// numbering is reversed.
    fn slice_normal(&self) -> Option<DVec3> {
        let part = |axis: &str| self.number(&format!("sSliceArray.asSlice[0].sNormal.d{axis}"));
        // A part that is zero is not written.
        let normal = DVec3::from_array(["Sag", "Cor", "Tra"].map(|axis| part(axis).unwrap_or(0.0)));
        let is_reversed = ["Sag", "Cor", "Tra"]
            .iter()
            .any(|axis| self.number(&format!("sSliceArray.ucImageNumb{axis}")).is_some_and(|n| n != 0.0));
        normal.try_normalize().map(|normal| if is_reversed { -normal } else { normal })
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
