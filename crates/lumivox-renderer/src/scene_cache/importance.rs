//! An environment's importance grid: where light comes from, so that samples go there.

use std::f64::consts::PI;
use std::sync::{Arc, Mutex, PoisonError};

use lumivox_core::color::luminance;
use lumivox_core::{Environment, EnvironmentMap, EnvironmentSource};
use lumivox_shaders::layout::ImportanceCell;

use crate::derived::Derived;

/// Largest importance grid; finer maps are summed into it.
const MAX_GRID: [usize; 2] = [1024, 512];

/// Texels that are weighed in less time than it takes to hand them to another thread and wait for a frame.
const QUICK_TEXELS: usize = 1 << 12;

/// Cells of equal size over the map's unit square, to be drawn in proportion to luminance times sin(theta).
#[derive(Debug)]
pub(crate) struct ImportanceGrid {
    pub size: [usize; 2],
    pub cells: Arc<[ImportanceCell]>,
    /// Of the radiance from all around.
    pub mean_luminance: f64,
}

/// The grids of maps that scenes share.
static GRIDS: Derived<EnvironmentMap, (), ImportanceGrid> = Derived::new();

/// The studio's map, for it is always the same.
static STUDIO: Mutex<Option<Arc<EnvironmentMap>>> = Mutex::new(None);

/// A source's map and grid, and whether that took long because nobody had computed the grid before.
pub(super) fn of(source: &EnvironmentSource) -> (Arc<EnvironmentMap>, Arc<ImportanceGrid>, bool) {
    let map = known_map(source).unwrap_or_else(|| {
        let map = Environment { source: source.clone(), rotation: 0.0, strength: 1.0 }.to_map();
        if *source == EnvironmentSource::Studio {
            *STUDIO.lock().unwrap_or_else(PoisonError::into_inner) = Some(map.clone());
        }
        map
    });
    let (grid, computed) = GRIDS.get_or(&map, (), || ImportanceGrid::new(&map));
    (map, grid, computed && takes_long(source))
}

/// Whether [`of`] takes no longer than a frame has time for.
pub(super) fn is_known(source: &EnvironmentSource) -> bool {
    !takes_long(source) || known_map(source).is_some_and(|map| GRIDS.get(&map, &()).is_some())
}

fn known_map(source: &EnvironmentSource) -> Option<Arc<EnvironmentMap>> {
    match source {
        EnvironmentSource::Map(map) => Some(map.clone()),
        EnvironmentSource::Studio => STUDIO.lock().unwrap_or_else(PoisonError::into_inner).clone(),
        _ => None,
    }
}

fn takes_long(source: &EnvironmentSource) -> bool {
    match source {
        EnvironmentSource::Map(map) => map.texels.len() > QUICK_TEXELS,
        EnvironmentSource::Studio => true,
        _ => false,
    }
}

impl ImportanceGrid {
    pub fn new(map: &EnvironmentMap) -> Self {
        let size = [map.width.min(MAX_GRID[0]), map.height.min(MAX_GRID[1])];
        let mut weights = vec![0.0f64; size[0] * size[1]];
        let (mut sum, mut solid_angle) = (0.0, 0.0);
        for y in 0..map.height {
            // Light from a row of the map fills a solid angle in proportion to the sine of its polar angle.
            let sin_theta = ((y as f64 + 0.5) / map.height as f64 * PI).sin();
            for x in 0..map.width {
                // Bilinear radiance spreads a texel over its neighbours' cells; so does its weight, or light would
                // arrive from where no sample goes.
                let weight = luminance(map.texels[y * map.width + x].map(f64::from)) * sin_theta;
                sum += weight;
                solid_angle += sin_theta;
                for (dx, dy, share) in NEIGHBOURS {
                    let nx = (x as i64 + dx).rem_euclid(map.width as i64) as usize;
                    let ny = (y as i64 + dy).clamp(0, map.height as i64 - 1) as usize;
                    let cell = ny * size[1] / map.height * size[0] + nx * size[0] / map.width;
                    weights[cell] += weight * share;
                }
            }
        }
        Self { size, cells: alias_table(&weights).into(), mean_luminance: sum / solid_angle }
    }
}

/// Shares of a texel's bilinear tent that fall into its own and its neighbours' squares: 3/4 and 1/8 along an axis.
const NEIGHBOURS: [(i64, i64, f64); 9] = [
    (-1, -1, 0.015625),
    (0, -1, 0.09375),
    (1, -1, 0.015625),
    (-1, 0, 0.09375),
    (0, 0, 0.5625),
    (1, 0, 0.09375),
    (-1, 1, 0.015625),
    (0, 1, 0.09375),
    (1, 1, 0.015625),
];

/// Vose's construction ("A Linear Algorithm for Generating Random Numbers with a Given Distribution", 1991). Without
/// any weight, every cell is as likely.
fn alias_table(weights: &[f64]) -> Vec<ImportanceCell> {
    let n = weights.len();
    let total: f64 = weights.iter().sum();
    let density = |i: usize| if total > 0.0 { weights[i] * n as f64 / total } else { 1.0 };
    let mut cells: Vec<ImportanceCell> = (0..n)
        .map(|i| {
            let density = density(i) as f32;
            ImportanceCell { threshold: 1.0, alias_index: i as u32, density, alias_density: density }
        })
        .collect();
    let mut rest: Vec<f64> = (0..n).map(density).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| rest[i] < 1.0);
    while let (Some(&poor), Some(&rich)) = (small.last(), large.last()) {
        small.pop();
        cells[poor].threshold = rest[poor] as f32;
        cells[poor].alias_index = rich as u32;
        cells[poor].alias_density = cells[rich].density;
        rest[rich] -= 1.0 - rest[poor];
        if rest[rich] < 1.0 {
            large.pop();
            small.push(rich);
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_alias_table_draws_what_the_densities_say() {
        let weights: Vec<f64> = (0..64).map(|i| ((i * 37) % 11) as f64).collect();
        let cells = alias_table(&weights);
        let mut drawn = vec![0.0; weights.len()];
        for (i, cell) in cells.iter().enumerate() {
            drawn[i] += f64::from(cell.threshold);
            drawn[cell.alias_index as usize] += 1.0 - f64::from(cell.threshold);
        }
        for (drawn, cell) in drawn.iter().zip(&cells) {
            assert!((drawn - f64::from(cell.density)).abs() < 1e-5);
        }
    }

    #[test]
    fn a_black_map_has_a_table() {
        assert!(alias_table(&[0.0; 4]).iter().all(|c| c.threshold == 1.0 && c.density == 1.0));
    }
}
