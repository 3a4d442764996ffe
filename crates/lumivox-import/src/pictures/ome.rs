//! What microscopes' programs write beside the pages of a TIFF: OME's XML, ImageJ's lines. Both say how pages are slices,
//! channels and moments, and how far apart pixels lie.

use std::path::Path;

use super::tiff::Description;
use crate::{error::ImportError, lengths::mm_per_unit, placement::Spacing};

/// Elements of a document that are looked at.
const MOST_ELEMENTS: u32 = 1 << 18;
/// Channels and moments beyond these are no scan's.
const MOST: usize = 1 << 16;

/// What pages are, in the order of their volumes: those of later moments after those of the first, slice by slice.
#[derive(Debug, PartialEq)]
pub(super) struct Pages {
    pub(super) pages: Vec<Page>,
    pub(super) channels: usize,
    pub(super) depth: usize,
    pub(super) moments: usize,
    pub(super) spacing: Option<Spacing>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Page {
    /// Its place in the file.
    pub(super) at: usize,
    pub(super) channel: usize,
}

impl Pages {
    /// Slices, one after the other.
    pub(super) fn plain(count: usize) -> Self {
        let pages = (0..count).map(|at| Page { at, channel: 0 }).collect();
        Self { pages, channels: 1, depth: count, moments: 1, spacing: None }
    }

    /// Pages that follow each other in `order`, the fastest first, of `C`, `Z` and `T`.
    fn ordered(order: &[char], [channels, depth, moments]: [usize; 3], spacing: Option<Spacing>) -> Self {
        let size = |letter: char| match letter {
            'C' => channels,
            'Z' => depth,
            _ => moments,
        };
        let stride = |letter: char| {
            order.iter().take_while(|other| **other != letter).map(|other| size(*other)).product::<usize>()
        };
        let [of_c, of_z, of_t] = ['C', 'Z', 'T'].map(stride);
        let mut pages = Vec::with_capacity(channels * depth * moments);
        for moment in 0..moments {
            for slice in 0..depth {
                let page = |channel| Page { at: moment * of_t + slice * of_z + channel * of_c, channel };
                pages.extend((0..channels).map(page));
            }
        }
        Self { pages, channels, depth, moments, spacing }
    }
}

/// What a description says of `count` pages; `None` where it says nothing of them.
///
/// # Errors
/// Where they are not all in this file.
pub(super) fn pages(
    path: &Path,
    description: &Description,
    count: usize,
) -> Result<Option<Pages>, ImportError> {
    let text = description.text.trim();
    let (found, refused) = if text.starts_with("ImageJ=") {
        let what = "a stack of ImageJ whose slices are no pages of their own";
        (imagej(text, description.resolution), (what, "Save it in Fiji as OME-TIFF or NRRD"))
    } else if text.contains("<OME") || text.contains(":OME") {
        let what = "an OME-TIFF whose pages are in other files, too";
        (ome(text), (what, "Save it as one file, for example with Fiji"))
    } else {
        return Ok(None);
    };
    let Some((order, sizes, spacing)) = found else { return Ok(None) };
    let all = sizes.iter().try_fold(1usize, |all, size| all.checked_mul(*size));
    if all != Some(count) {
        let (what, remedy) = refused;
        return Err(ImportError::Unsupported {
            path: path.to_owned(),
            what: format!(
                "{what} ({} x {} x {} are told, {count} pages there)",
                sizes[0], sizes[1], sizes[2]
            ),
            remedy: remedy.to_owned(),
        });
    }
    Ok(Some(Pages::ordered(&order, sizes, spacing)))
}

/// The order of pages, the numbers of channels, slices and moments, and how far apart voxels lie.
type Told = (Vec<char>, [usize; 3], Option<Spacing>);

fn imagej(text: &str, resolution: Option<[f64; 2]>) -> Option<Told> {
    let value = |key: &str| {
        text.lines()
            .find_map(|line| line.split_once('=').filter(|(own, _)| own.trim() == key))
            .map(|(_, value)| value.trim())
    };
    let number = |key: &str| {
        value(key).and_then(|value| value.parse::<usize>().ok()).filter(|n| (1..=MOST).contains(n))
    };
    let images = number("images").unwrap_or(1);
    let (channels, moments) = (number("channels").unwrap_or(1), number("frames").unwrap_or(1));
    let depth = number("slices").unwrap_or_else(|| (images / (channels * moments)).max(1));
    let [x, y] = resolution.map_or([1.0; 2], |pixels| pixels.map(|pixels| 1.0 / pixels));
    let apart = value("spacing").and_then(|value| value.parse::<f64>().ok()).map(f64::abs);
    let spacing = match (value("unit").and_then(mm_per_unit), apart) {
        (Some(mm), _) => Some(Spacing::Mm([x * mm, y * mm, apart.unwrap_or(1.0) * mm])),
        (None, Some(z)) => Some(Spacing::OfUnknownUnit([x, y, z])),
        (None, None) => None,
    };
    let spacing = spacing.filter(|spacing| match spacing {
        Spacing::Mm(lengths) | Spacing::OfUnknownUnit(lengths) => {
            lengths.iter().all(|length| length.is_normal())
        }
    });
    Some((vec!['C', 'Z', 'T'], [channels, depth, moments], spacing))
}

fn ome(text: &str) -> Option<Told> {
    let options = roxmltree::ParsingOptions { nodes_limit: MOST_ELEMENTS, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(text, options).ok()?;
    let pixels = document.descendants().find(|node| node.tag_name().name() == "Pixels")?;
    let size =
        |name: &str| pixels.attribute(name)?.trim().parse::<usize>().ok().filter(|n| (1..=MOST).contains(n));
    // The samples of a colour are channels, too, but in one page.
    let channel = |node: &roxmltree::Node<'_, '_>| node.tag_name().name() == "Channel";
    let of_colours: usize = pixels
        .children()
        .filter(channel)
        .filter_map(|node| node.attribute("SamplesPerPixel")?.trim().parse::<usize>().ok())
        .map(|samples| samples.clamp(1, 4) - 1)
        .sum();
    let channels = size("SizeC")?.saturating_sub(of_colours).max(1);
    let order: Vec<char> =
        pixels.attribute("DimensionOrder")?.chars().filter(|letter| "CZT".contains(*letter)).collect();
    if order.len() != 3 {
        return None;
    }
    let length = |axis: char| {
        let length = pixels.attribute(format!("PhysicalSize{axis}").as_str())?.trim().parse::<f64>().ok()?;
        Some(length).filter(|length| length.is_normal() && *length > 0.0)
    };
    let mm = |axis: char| {
        let unit = pixels.attribute(format!("PhysicalSize{axis}Unit").as_str());
        Some(length(axis)? * unit.map_or(Some(1e-3), mm_per_unit)?)
    };
    let spacing = match (mm('X').zip(mm('Y')), length('X').zip(length('Y')), length('Z')) {
        (Some((x, y)), _, _) => Some(Spacing::Mm([x, y, mm('Z').unwrap_or(x)])),
        (None, Some((x, y)), Some(z)) => Some(Spacing::OfUnknownUnit([x, y, z])),
        _ => None,
    };
    Some((order, [channels, size("SizeZ")?, size("SizeT")?], spacing))
}
