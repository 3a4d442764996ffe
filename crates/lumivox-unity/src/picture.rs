//! Small pictures of scans for lists and asset browsers: from the front, in a light beside the viewer. They are marched on
//! the CPU, for an importer may have no GPU, and a picture of a thumb's size needs no paths.

use lumivox_core::color::srgb_from_linear;
use lumivox_core::glam::DVec3;
use lumivox_core::{CancelToken, Medium, Volume, framing, placement};
use lumivox_import::Thumbnail;

use crate::border::Outcome;

/// Most pixels along a side.
pub const MAX_SIDE: usize = 256;

/// What is left of a ray that is followed no longer.
const LEAST_TRANSMITTANCE: f64 = 0.01;

/// Entries of the look's table: more than a picture's bytes can tell apart.
const LEVELS: usize = 2048;

/// Light without direction, and that of the lamp.
const AMBIENT: f64 = 0.25;
const LAMP: f64 = 0.95;

/// sRGB with straight alpha, rows from the top.
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pub rgba: Vec<u8>,
}

impl From<Thumbnail> for Picture {
    fn from(Thumbnail { width, height, grey, .. }: Thumbnail) -> Self {
        Self { width, height, rgba: grey.into_iter().flat_map(|level| [level, level, level, 255]).collect() }
    }
}

impl Picture {
    /// A scan as a medium shows it, at most `side` pixels wide and high; transparent where nothing is.
    pub fn of(volume: &Volume, medium: &Medium, side: usize, cancel: &CancelToken) -> Outcome<Self> {
        let side = side.clamp(1, MAX_SIDE);
        let [low, high] = seen(volume, medium);
        let extent = high - low;
        let pixel = (extent.x.max(extent.y) / side as f64).max(f64::MIN_POSITIVE);
        let pixels = |metres: f64, most: usize| ((metres / pixel).round() as usize).clamp(1, most);
        let size = [pixels(extent.x, side), pixels(extent.y, side), pixels(extent.z, 2 * side)];
        let step = extent / DVec3::from_array(size.map(|n| n as f64));
        let levels = levels(volume, DVec3::new(low.x, high.y, high.z), step, size, cancel)?;
        let look = Look::new(volume, medium, step.z);
        let mut rgba = Vec::with_capacity(4 * size[0] * size[1]);
        for y in 0..size[1] {
            cancel.check().map_err(|error| error.to_string())?;
            for x in 0..size[0] {
                rgba.extend(look.along(&Grid { levels: &levels, size, step }, x, y));
            }
        }
        Ok(Self { width: size[0], height: size[1], rgba })
    }
}

/// The corners of what is seen of a scan, in metres of its object.
fn seen(volume: &Volume, medium: &Medium) -> [DVec3; 2] {
    let node_from_box = placement::node_from_patient(volume) * volume.patient_from_box();
    let ends = framing::visible_box(volume, medium);
    let corners = (0..8).map(|i: usize| {
        let end = |axis: usize| ends[i >> axis & 1][axis];
        node_from_box.transform_point3(DVec3::new(end(0), end(1), end(2)))
    });
    corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

/// Outside the scan.
const OUTSIDE: u16 = u16::MAX;

/// The scan's values as places in the look's table, in cells that go to the right, down and back from `start`.
fn levels(
    volume: &Volume,
    start: DVec3,
    step: DVec3,
    [width, height, depth]: [usize; 3],
    cancel: &CancelToken,
) -> Outcome<Vec<u16>> {
    let voxel_from_node = (placement::node_from_patient(volume) * volume.patient_from_voxel()).inverse();
    let start = voxel_from_node.transform_point3(start);
    let [x_step, y_step, z_step] = [DVec3::X * step.x, DVec3::NEG_Y * step.y, DVec3::NEG_Z * step.z]
        .map(|v| voxel_from_node.matrix3 * v);
    let whole = (x_step.abs() + y_step.abs() + z_step.abs()).max_element();
    // A cell of several voxels is their mean, roughly; one that is smaller lies between them.
    let parts = (whole > 1.5).then(|| {
        [0, 1, 2, 3, 4, 5, 6, 7].map(|i| {
            let side = |bit: usize| if i >> bit & 1 == 0 { -0.25 } else { 0.25 };
            x_step * side(0) + y_step * side(1) + z_step * side(2)
        })
    });
    let [low, high] = volume.value_range();
    let scale = (LEVELS - 1) as f64 / (high - low).max(f64::MIN_POSITIVE);
    let end = DVec3::from_array(volume.dims().map(|n| n as f64)) - 0.5;
    let mut levels = Vec::with_capacity(width * height * depth);
    for z in 0..depth {
        cancel.check().map_err(|error| error.to_string())?;
        for y in 0..height {
            let row = start + z_step * (z as f64 + 0.5) + y_step * (y as f64 + 0.5);
            for x in 0..width {
                let at = row + x_step * (x as f64 + 0.5);
                if at.cmplt(DVec3::splat(-0.5)).any() || at.cmpgt(end).any() {
                    levels.push(OUTSIDE);
                    continue;
                }
                let value = match &parts {
                    Some(parts) => parts.iter().map(|part| nearest(volume, at + *part)).sum::<f64>() / 8.0,
                    None => between(volume, at),
                };
                levels.push(((value - low) * scale).round().clamp(0.0, (LEVELS - 1) as f64) as u16);
            }
        }
    }
    Ok(levels)
}

fn nearest(volume: &Volume, at: DVec3) -> f64 {
    let dims = volume.dims();
    volume.value([0, 1, 2].map(|axis| ((at[axis] + 0.5).max(0.0) as usize).min(dims[axis] - 1)))
}

/// Trilinear.
fn between(volume: &Volume, at: DVec3) -> f64 {
    let first = at.floor();
    let (part, rest) = (at - first, first + 1.0 - at);
    (0..8)
        .map(|i| {
            let side = [i & 1, i >> 1 & 1, i >> 2];
            let share: f64 =
                (0..3).map(|axis| if side[axis] == 1 { part[axis] } else { rest[axis] }).product();
            share * nearest(volume, first + DVec3::from_array(side.map(|n: usize| n as f64)))
        })
        .sum()
}

/// Cells of a scan, and how large they are in metres.
struct Grid<'a> {
    levels: &'a [u16],
    size: [usize; 3],
    step: DVec3,
}

impl Grid<'_> {
    fn at(&self, [x, y, z]: [usize; 3]) -> u16 {
        self.levels[(z * self.size[1] + y) * self.size[0] + x]
    }
}

/// A medium over the levels of a scan.
struct Look {
    /// Linear RGB.
    colors: Vec<[f64; 3]>,
    /// The share of light that a step to the back takes.
    alphas: Vec<f64>,
}

impl Look {
    fn new(volume: &Volume, medium: &Medium, step: f64) -> Self {
        let [low, high] = volume.value_range();
        let value = |level: usize| low + (high - low) * level as f64 / (LEVELS - 1) as f64;
        let color =
            |level| medium.transfer_function.color(value(level)).map(|channel| channel * medium.albedo);
        let alpha = |level| 1.0 - (-medium.sigma_t_per_mm(value(level)) * step * 1000.0).exp();
        Self { colors: (0..LEVELS).map(color).collect(), alphas: (0..LEVELS).map(alpha).collect() }
    }

    /// Colour and alpha of the ray through a pixel.
    fn along(&self, grid: &Grid, x: usize, y: usize) -> [u8; 4] {
        let (mut light, mut transmittance) = ([0.0; 3], 1.0);
        for z in 0..grid.size[2] {
            let level = grid.at([x, y, z]);
            let alpha = self.alpha(level) * transmittance;
            if alpha < 1e-4 {
                continue;
            }
            let lit = alpha * self.lit(grid, [x, y, z]);
            light
                .iter_mut()
                .zip(self.colors[level as usize])
                .for_each(|(sum, channel)| *sum += channel * lit);
            transmittance -= alpha;
            if transmittance < LEAST_TRANSMITTANCE {
                transmittance = 0.0;
                break;
            }
        }
        let alpha = 1.0 - transmittance;
        let byte = |x: f64| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
        let [r, g, b] = light.map(|sum| byte(srgb_from_linear(sum / alpha.max(f64::MIN_POSITIVE))));
        [r, g, b, byte(alpha)]
    }

    fn alpha(&self, level: u16) -> f64 {
        self.alphas.get(usize::from(level)).copied().unwrap_or(0.0)
    }

    /// How bright a cell is: by the slope of what takes light, towards a lamp to the upper left of the viewer.
    fn lit(&self, grid: &Grid, cell: [usize; 3]) -> f64 {
        let slope = [0, 1, 2].map(|axis| {
            let alpha = |by: isize| {
                let mut at = cell;
                let moved = at[axis].checked_add_signed(by).filter(|to| *to < grid.size[axis]);
                moved.map_or(0.0, |to| {
                    at[axis] = to;
                    self.alpha(grid.at(at))
                })
            };
            (alpha(-1) - alpha(1) + (alpha(-2) - alpha(2)) / 2.0) / grid.step[axis]
        });
        // To the right, down and back: out of what is dense.
        let facing = match DVec3::from_array(slope).try_normalize() {
            Some(outwards) => outwards.dot(DVec3::new(-0.45, -0.55, -0.7).normalize()).max(0.0),
            // Inside, nothing faces anywhere.
            None => 0.6,
        };
        AMBIENT + LAMP * facing
    }
}

#[cfg(test)]
mod tests {
    use lumivox_core::glam::{DAffine3, DMat3};
    use lumivox_core::{Ease, Modality, TransferFunction, Voxels};

    use super::*;

    /// 8 x 4 x 16 voxels of 1 x 2 x 1 mm: opaque at the patient's left, at the front and at the head's end only.
    fn scan() -> Volume {
        let mut voxels = vec![0; 8 * 4 * 16];
        // x to the left, y to the back, z to the head.
        for z in 12..16 {
            for y in 0..2 {
                for x in 6..8 {
                    voxels[(z * 4 + y) * 8 + x] = 200;
                }
            }
        }
        let place = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(1.0, 2.0, 1.0)));
        Volume::new([8, 4, 16], Voxels::U8(voxels), [1.0, 0.0], place, Modality::Other).unwrap()
    }

    fn look(values: [f64; 2]) -> Medium {
        let function = TransferFunction::from_points(
            Ease::Linear,
            &[(values[0], 0.0), (values[1], 1.0)],
            &[(0.0, [0.0, 0.0, 1.0]), (200.0, [1.0, 0.5, 0.25])],
        );
        let mut medium = Medium::new(function.unwrap());
        medium.density_scale = 100.0;
        medium
    }

    fn of(medium: &Medium, side: usize) -> Picture {
        Picture::of(&scan(), medium, side, &CancelToken::new()).unwrap()
    }

    #[test]
    fn all_of_a_scan_is_pictured_upright_from_the_front() {
        // Everything takes light, so nothing is cut off.
        let picture = of(&look([-200.0, 200.0]), 32);
        assert_eq!((picture.width, picture.height), (16, 32));
        assert_eq!(picture.rgba.len(), 4 * 16 * 32);
        let at = |x: usize, y: usize| picture.rgba[4 * (y * 16 + x)..][..4].to_vec();
        // The patient looks at the viewer: the left is at the picture's right, the head above.
        assert!(at(14, 3)[0] > 60 && at(14, 3)[3] == 255, "{:?}", at(14, 3));
        for (x, y) in [(2, 3), (14, 28), (2, 28)] {
            assert!(at(x, y)[0] < 10 && at(x, y)[2] > 20, "{x} {y}: {:?}", at(x, y));
        }
    }

    #[test]
    fn what_is_not_seen_takes_no_room() {
        let picture = of(&look([100.0, 200.0]), 32);
        // Two voxels by four, and those beside them that trilinear values reach into.
        assert!(picture.width * 3 < picture.height * 4, "{} x {}", picture.width, picture.height);
        let covered = picture.rgba.chunks_exact(4).filter(|pixel| pixel[3] > 128).count();
        assert!(5 * covered > 2 * picture.width * picture.height, "{covered} pixels show something");
    }

    #[test]
    fn a_picture_of_nothing_is_empty_and_one_of_many_voxels_small() {
        let nothing = Medium::new(TransferFunction::constant(0.0, [1.0; 3]));
        let picture = of(&nothing, 8);
        assert!(picture.rgba.chunks_exact(4).all(|pixel| pixel[3] == 0));
        let small = of(&look([-1.0, 200.0]), 1);
        assert_eq!((small.width, small.height, small.rgba.len()), (1, 1, 4));
        assert_eq!(of(&nothing, 1 << 20).height, MAX_SIDE);
    }

    #[test]
    fn the_side_towards_the_lamp_is_the_brighter() {
        let n = 24_usize;
        let inside = |i: usize| {
            let place = |i: usize| i as f64 - (n - 1) as f64 / 2.0;
            let at = DVec3::new(place(i % n), place(i / n % n), place(i / n / n));
            (220.0 - 20.0 * (at.length() - 4.0).max(0.0)).clamp(0.0, 200.0) as u8
        };
        let voxels = Voxels::U8((0..n * n * n).map(inside).collect());
        let ball = Volume::new([n; 3], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Other).unwrap();
        let medium = look([80.0, 120.0]);
        for side in [12, 64] {
            let picture = Picture::of(&ball, &medium, side, &CancelToken::new()).unwrap();
            let at = |x: usize, y: usize| u32::from(picture.rgba[4 * (y * picture.width + x)]);
            let (low, high) = (side * 3 / 10, side * 7 / 10);
            assert!(at(low, low) > at(high, high) + 40, "{side}: {} and {}", at(low, low), at(high, high));
        }
    }

    #[test]
    fn a_picture_can_be_stopped() {
        let cancel = CancelToken::new();
        cancel.cancel();
        assert!(Picture::of(&scan(), &look([0.0, 200.0]), 64, &cancel).is_err());
    }
}
