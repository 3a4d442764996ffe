//! What the axes of an array are, for files that do not say.

use std::{fmt, str::FromStr};

use crate::{lengths::SPACING_MM, text_header::parse_list};

/// The axes of an array in the order in which its shape lists them, as letters: `x`, `y` and `z` of space, `t` for moments
/// or other volumes one after the other, `c` for red, green and blue; `zyx`, `xyz`, `tzyx`, `zyxc`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ArrayLayout(String);

/// A text is no [`ArrayLayout`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the letters of axes are expected in the order of the array's shape, each once: x and y, z, t for moments, c for colours; such as zyx or tzyx"
)]
pub struct UnknownLayout;

impl FromStr for ArrayLayout {
    type Err = UnknownLayout;

    fn from_str(text: &str) -> Result<Self, UnknownLayout> {
        let text = text.trim().to_ascii_lowercase();
        let is_known = |letter: char| "xyztc".contains(letter) && text.matches(letter).count() == 1;
        let has_plane = text.contains('x') && text.contains('y');
        if has_plane && text.chars().all(is_known) { Ok(Self(text)) } else { Err(UnknownLayout) }
    }
}

impl fmt::Display for ArrayLayout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// A text is no distance between voxels along three axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("three lengths in mm are expected, such as 0.5,0.5,2")]
pub struct UnknownSpacing;

/// Distances between voxels along x, y and z in mm, as people write them: `0.5,0.5,2`.
///
/// # Errors
/// [`UnknownSpacing`], also where nothing has such voxels.
pub fn parse_spacing(text: &str) -> Result<[f64; 3], UnknownSpacing> {
    let lengths = parse_list(text).and_then(|lengths| <[f64; 3]>::try_from(lengths).ok());
    lengths.filter(|lengths| lengths.iter().all(|mm| SPACING_MM.contains(mm))).ok_or(UnknownSpacing)
}

/// An array as a grid of voxels.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ArrayGrid {
    /// Voxels along the axes of space, the fastest first.
    pub(crate) dims: [usize; 3],
    /// Which axes these are: 0 for x, 1 for y, 2 for z.
    pub(crate) space: [usize; 3],
    pub(crate) phases: usize,
    /// Whether phases are the fastest axis.
    pub(crate) interleaved: bool,
    /// Samples of each voxel, one after the other.
    pub(crate) channels: usize,
}

impl ArrayGrid {
    /// Its size, for people.
    pub(crate) fn words(&self) -> String {
        let [x, y, z] = self.dims;
        let phases = if self.phases > 1 { format!(", {} moments", self.phases) } else { String::new() };
        let channels =
            if self.channels > 1 { format!(", {} channels", self.channels) } else { String::new() };
        format!("{x} x {y} x {z}{phases}{channels}")
    }
}

impl ArrayLayout {
    /// What arrays of such a shape mostly are: three or four small whole numbers beside each other, last and among longer axes,
    /// are a colour.
    pub(crate) fn usual(shape: &[usize], are_small_whole_numbers: bool) -> Option<Self> {
        let around = shape.split_last().filter(|(last, _)| (3..=4).contains(*last)).map(|(_, around)| around);
        let is_long = |size: &usize| *size > 4 || *size == 1;
        let are_colours = are_small_whole_numbers && around.is_some_and(|around| around.iter().all(is_long));
        let text = match (shape.len(), are_colours) {
            (2, _) => "yx",
            (3, false) => "zyx",
            (3, true) => "yxc",
            (4, false) => "tzyx",
            (4, true) => "zyxc",
            _ => return None,
        };
        Some(Self(text.to_owned()))
    }

    /// The letters from the fastest axis on; the shape lists the fastest one last, unless `fastest_first`.
    pub(crate) fn letters_by_speed(&self, fastest_first: bool) -> Vec<char> {
        if fastest_first { self.0.chars().collect() } else { self.0.chars().rev().collect() }
    }

    /// The grid of an array whose axes are `letters` long `sizes`, the fastest first. `None` where moments or colours lie
    /// between the axes of space.
    pub(crate) fn grid(&self, letters: &[char], sizes: &[usize]) -> Option<ArrayGrid> {
        let size_of = |wanted: char| {
            let at = letters.iter().position(|letter| *letter == wanted);
            at.map_or(1, |at| sizes[at])
        };
        let place =
            |wanted: char| letters.iter().position(|letter| *letter == wanted).filter(|at| sizes[*at] > 1);
        let space: Vec<char> = letters.iter().copied().filter(|letter| "xyz".contains(*letter)).collect();
        let first = letters.iter().position(|letter| "xyz".contains(*letter))?;
        let last = letters.iter().rposition(|letter| "xyz".contains(*letter))?;
        let is_around = |at: usize| at < first || at > last;
        let (moments, colours) = (place('t'), place('c'));
        // Colours of a voxel follow each other, and moments come first or last.
        if !moments.is_none_or(is_around)
            || colours.is_some_and(|at| at != 0)
            || moments == Some(0) && colours.is_some()
        {
            return None;
        }
        let mut axes = space.iter().map(|letter| "xyz".find(*letter).unwrap_or(0)).collect::<Vec<_>>();
        let mut dims: Vec<usize> = space.iter().map(|letter| size_of(*letter)).collect();
        if let Some(missing) = (0..3).find(|axis| !axes.contains(axis)).filter(|_| axes.len() < 3) {
            axes.push(missing);
            dims.push(1);
        }
        Some(ArrayGrid {
            dims: dims.try_into().ok()?,
            space: axes.try_into().ok()?,
            phases: size_of('t'),
            interleaved: moments.is_some_and(|at| at < first),
            channels: size_of('c'),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spacings_are_three_lengths() {
        for text in ["0.5,0.5,2", "(0.5, 0.5, 2)", "0.5 0.5 2"] {
            assert_eq!(parse_spacing(text), Ok([0.5, 0.5, 2.0]));
        }
        for wrong in ["", "1,1", "1,1,1,1", "1,1,0", "1,1,nan", "1,1,-1", "a,b,c"] {
            assert_eq!(parse_spacing(wrong), Err(UnknownSpacing), "{wrong}");
        }
    }

    #[test]
    fn colours_are_told_from_moments() {
        let usual = |shape: &[usize], small| ArrayLayout::usual(shape, small).map(|layout| layout.0);
        assert_eq!(usual(&[40, 50, 60, 3], true).as_deref(), Some("zyxc"));
        assert_eq!(usual(&[50, 60, 4], true).as_deref(), Some("yxc"));
        // A field of vectors, and volumes with few voxels along x.
        assert_eq!(usual(&[40, 50, 60, 3], false).as_deref(), Some("tzyx"));
        assert_eq!(usual(&[2, 50, 60, 3], true).as_deref(), Some("tzyx"));
        assert_eq!(usual(&[50, 60, 5], true).as_deref(), Some("zyx"));
        assert_eq!(usual(&[5; 5], true), None);
    }

    #[test]
    fn letters_name_axes() {
        let grid = |text: &str, sizes: &[usize]| {
            let layout: ArrayLayout = text.parse().unwrap();
            let mut sizes = sizes.to_vec();
            sizes.reverse();
            layout.grid(&layout.letters_by_speed(false), &sizes)
        };
        let plain = grid("zyx", &[4, 3, 2]).unwrap();
        assert_eq!((plain.dims, plain.space, plain.phases, plain.channels), ([2, 3, 4], [0, 1, 2], 1, 1));
        let turned = grid("XYZ", &[4, 3, 2]).unwrap();
        assert_eq!((turned.dims, turned.space), ([2, 3, 4], [2, 1, 0]));
        let moments = grid("tzyx", &[5, 4, 3, 2]).unwrap();
        assert_eq!((moments.phases, moments.interleaved), (5, false));
        let fast = grid("zyxt", &[4, 3, 2, 5]).unwrap();
        assert_eq!((fast.phases, fast.interleaved), (5, true));
        assert_eq!(grid("zyxc", &[4, 3, 2, 3]).unwrap().channels, 3);
        assert_eq!(grid("yx", &[3, 2]).unwrap().dims, [2, 3, 1]);
        assert_eq!(grid("ztyx", &[4, 5, 3, 2]), None);
        assert_eq!(grid("czyx", &[3, 4, 3, 2]), None);
        assert_eq!(grid("ztyx", &[4, 1, 3, 2]).unwrap().dims, [2, 3, 4]);
        for wrong in ["", "zy", "zyxx", "zyxq", "z y x", "xÿ"] {
            assert_eq!(wrong.parse::<ArrayLayout>(), Err(UnknownLayout), "{wrong}");
        }
    }
}
