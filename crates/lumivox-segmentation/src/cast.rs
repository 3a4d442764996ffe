//! What the patient wears all around: casts of plaster or resin. Along a limb they are shells as a table is; but no table goes
//! around the patient.

use lumivox_core::{CancelToken, Cancelled};

use crate::{
    components::{Components, boxes},
    grid::Grid,
};

/// The widest and the shortest cast, in mm, and how much wider than high its cross-section is at most.
const WIDEST_MM: f32 = 350.0;
const SHORTEST_MM: f32 = 20.0;
const ROUND: f32 = 2.5;

/// Directions around the body that are told apart, and how many of them a cast lies in.
const SECTORS: usize = 24;
const MOST_SECTORS: usize = 22;

/// The share of its slices in which a cast goes around.
const MOST_SLICES: f64 = 0.7;

/// The least value of what is hard enough to hold a bone, in HU.
const FIRM_HU: f32 = 100.0;

/// The cells of casts: of `thin` solids, those that go around cells of the `body`.
pub fn casts(
    grid: &Grid,
    means: &[f32],
    thin: &[bool],
    body: impl Fn(usize) -> bool,
    cancel: &CancelToken,
) -> Result<Vec<bool>, Cancelled> {
    let sets = Components::new(grid, |i| thin[i], cancel)?;
    let is_candidate: Vec<bool> = boxes(grid, &sets)
        .iter()
        .enumerate()
        .map(|(number, [low, high])| {
            let [x, y, z] =
                [0, 1, 2].map(|axis| (high[axis] + 1).saturating_sub(low[axis]) as f32 * grid.cell_mm[axis]);
            number > 0 && z >= SHORTEST_MM && x.max(y) <= WIDEST_MM && x.max(y) <= ROUND * x.min(y)
        })
        .collect();
    let of = |i: usize| {
        let number = sets.of[i] as usize;
        (thin[i] && is_candidate[number]).then_some(number)
    };
    // Slices in which a set goes around, those in which it is, its firm cells and all.
    let mut counts = vec![[0usize; 4]; sets.sizes.len()];
    for z in 0..grid.dims[2] {
        cancel.check()?;
        for (number, cells) in cells_of_slice(grid, z, &of) {
            let [around, slices, firm, all] = &mut counts[number];
            *slices += 1;
            *around += usize::from(goes_around(grid, z, &cells, &body));
            *firm += cells.iter().filter(|&&i| means[i] >= FIRM_HU).count();
            *all += cells.len();
        }
    }
    let is_cast = |number: usize| {
        let [around, slices, firm, all] = counts[number];
        slices > 0 && around as f64 >= MOST_SLICES * slices as f64 && 2 * firm >= all
    };
    Ok((0..grid.len()).map(|i| of(i).is_some_and(is_cast)).collect())
}

/// The cells of each candidate in a slice.
fn cells_of_slice(grid: &Grid, z: usize, of: &impl Fn(usize) -> Option<usize>) -> Vec<(usize, Vec<usize>)> {
    let mut found: Vec<(usize, Vec<usize>)> = Vec::new();
    for i in z * grid.slice_len()..(z + 1) * grid.slice_len() {
        let Some(number) = of(i) else { continue };
        match found.iter_mut().find(|(known, _)| *known == number) {
            Some((_, cells)) => cells.push(i),
            None => found.push((number, vec![i])),
        }
    }
    found
}

/// Whether cells lie in nearly all directions from the middle of the body within their box.
fn goes_around(grid: &Grid, z: usize, cells: &[usize], body: &impl Fn(usize) -> bool) -> bool {
    let place = |i: usize| {
        let [x, y, _] = grid.cell(i);
        [x, y]
    };
    let extent = |axis: usize| {
        let places = || cells.iter().map(|&i| place(i)[axis]);
        (places().min().unwrap_or(0), places().max().unwrap_or(0))
    };
    let (left, right) = extent(0);
    let (front, back) = extent(1);
    let (mut sum, mut count) = ([0.0f32; 2], 0.0f32);
    for y in front..=back {
        for x in left..=right {
            if body(grid.index([x, y, z])) {
                sum = [sum[0] + x as f32, sum[1] + y as f32];
                count += 1.0;
            }
        }
    }
    if count == 0.0 {
        return false;
    }
    let mut sectors = [false; SECTORS];
    for &i in cells {
        let [x, y] = place(i);
        let [dx, dy] =
            [(x as f32 - sum[0] / count) * grid.cell_mm[0], (y as f32 - sum[1] / count) * grid.cell_mm[1]];
        let turn = dy.atan2(dx) / std::f32::consts::TAU + 0.5;
        sectors[((turn * SECTORS as f32) as usize).min(SECTORS - 1)] = true;
    }
    sectors.iter().filter(|sector| **sector).count() >= MOST_SECTORS
}

#[cfg(test)]
mod tests {
    use lumivox_core::{
        CancelToken, Modality, Progress, Volume, Voxels,
        glam::{DAffine3, DVec3},
    };

    use crate::{Class, segment};

    /// A CT of 2 mm voxels, by the place in mm from its middle.
    fn ct(value: impl Fn(DVec3) -> f64) -> Volume {
        let dims = [90, 100, 90];
        let middle = DVec3::from_array(dims.map(|n| n as f64)) - 1.0;
        let voxel = |i: usize| {
            let at = DVec3::from_array([i % 90, i / 90 % 100, i / 9000].map(|k| 2.0 * k as f64)) - middle;
            (value(at) + 1024.0) as u16
        };
        let voxels = Voxels::U16((0..dims.iter().product()).map(voxel).collect());
        let place = DAffine3::from_scale(DVec3::splat(2.0));
        Volume::new(dims, voxels, [1.0, -1024.0], place, Modality::Ct).unwrap()
    }

    /// Muscle in fat, on a table.
    fn limb(at: DVec3) -> f64 {
        match at.truncate().length() {
            r if r < 28.0 => 55.0,
            r if r < 36.0 => -100.0,
            _ if (70.0..76.0).contains(&at.y) => 150.0,
            _ => -1000.0,
        }
    }

    /// The share of the voxels where `part` is that have each of these classes.
    fn shares<const N: usize>(
        volume: &Volume,
        part: impl Fn(DVec3) -> bool,
        classes: [Class; N],
    ) -> [f64; N] {
        let found = segment(volume, Progress::SILENT, &CancelToken::new()).unwrap();
        assert!(found.report.is_sure(), "{}", found.report);
        let middle = DVec3::from_array(volume.dims().map(|n| n as f64)) - 1.0;
        let inside: Vec<u8> = (0..volume.voxel_count())
            .filter(|i| {
                part(DVec3::from_array([i % 90, i / 90 % 100, i / 9000].map(|k| 2.0 * k as f64)) - middle)
            })
            .map(|i| found.labels.voxels()[i])
            .collect();
        classes.map(|class| {
            inside.iter().filter(|label| **label == class.value()).count() as f64 / inside.len() as f64
        })
    }

    #[test]
    fn a_cast_is_the_patients_and_a_table_is_none() {
        let is_cast = |at: DVec3| (46.0..53.0).contains(&at.truncate().length()) && at.z.abs() < 70.0;
        let scan = ct(|at| if is_cast(at) { 600.0 } else { limb(at) });
        let is_inside = |at: DVec3| (48.0..51.0).contains(&at.truncate().length()) && at.z.abs() < 66.0;
        let [body, table] = shares(&scan, is_inside, [Class::Body, Class::Table]);
        assert!(body > 0.95 && table < 0.02, "body {body}, table {table}");
        let [body, table] = shares(&scan, |at| (72.0..75.0).contains(&at.y), [Class::Body, Class::Table]);
        assert!(table > 0.95 && body < 0.02, "body {body}, table {table}");
        // Half of it, as a splint or a head-rest is, does not go around.
        let half = ct(|at| if is_cast(at) && at.y > 0.0 { 600.0 } else { limb(at) });
        let [body] = shares(&half, |at| is_inside(at) && at.y > 4.0, [Class::Body]);
        assert!(body < 0.1, "{body}");
    }

    #[test]
    fn a_prosthesis_is_the_patients() {
        // A tube of metal that goes on from where the limb ends, behind a liner that is hardly seen.
        let is_metal = |at: DVec3| at.truncate().length() < 16.0 && (-80.0..8.0).contains(&at.z);
        let scan = ct(|at| match () {
            () if is_metal(at) => 2800.0,
            () if at.z < 18.0 && at.y < 60.0 => -1000.0,
            () => limb(at),
        });
        let is_inside = |at: DVec3| at.truncate().length() < 12.0 && (-74.0..2.0).contains(&at.z);
        let [body, table] = shares(&scan, is_inside, [Class::Body, Class::Table]);
        assert!(body > 0.95 && table == 0.0, "body {body}, table {table}");
    }
}
