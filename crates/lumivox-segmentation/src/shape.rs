//! Size, make-up and form of solid things: what tells a limb from a slab.

use crate::grid::Grid;

/// Depths beyond this are not told apart, in mm.
pub const DEEPEST_MM: f32 = 60.0;

/// How often a slab is wider than it is thick. Limbs are hardly twice.
const SLAB_RATIO: f32 = 4.0;

/// What is known of a solid thing.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// Its cells.
    pub cells: usize,
    /// Share of cells with values of fat, and of muscle, organs and blood.
    pub fat: f64,
    /// See `fat`.
    pub muscle: f64,
    /// Share of cells with values of anything in a body, bone included.
    pub tissue: f64,
    /// Share of cells with values of metal.
    pub metal: f64,
    /// Largest distance from its surface, in mm.
    pub deep_mm: f32,
    /// Its extent along x, y, z, in mm.
    pub size_mm: [f32; 3],
    /// Share of cells in columns along z that it fills nearly all along its length: 1 for a constant cross-section.
    pub constant: f64,
}

impl Shape {
    /// The shapes of the `members` of each component, as lists of cells.
    pub fn new(grid: &Grid, means: &[f32], depth: &[f32], members: &[usize]) -> Self {
        let share = |low: f32, high: f32| {
            let within = members.iter().filter(|&&i| (low..high).contains(&means[i])).count();
            within as f64 / members.len().max(1) as f64
        };
        let (mut low, mut high) = (grid.dims, [0; 3]);
        let mut columns = vec![0u32; grid.slice_len()];
        let mut deep_mm = 0f32;
        for &i in members {
            for (axis, at) in grid.cell(i).into_iter().enumerate() {
                low[axis] = low[axis].min(at);
                high[axis] = high[axis].max(at);
            }
            columns[i % grid.slice_len()] += 1;
            deep_mm = deep_mm.max(depth[i].min(DEEPEST_MM));
        }
        let size_mm =
            [0, 1, 2].map(|axis| (high[axis] + 1).saturating_sub(low[axis]) as f32 * grid.cell_mm[axis]);
        let long = (high[2] + 1).saturating_sub(low[2]) as f64;
        let full: u64 = columns.iter().filter(|&&n| f64::from(n) >= 0.8 * long).map(|&n| u64::from(n)).sum();
        Self {
            cells: members.len(),
            fat: share(-150.0, -30.0),
            muscle: share(0.0, 110.0),
            tissue: share(-250.0, 1300.0),
            metal: share(1300.0, f32::INFINITY),
            deep_mm,
            size_mm,
            constant: full as f64 / members.len().max(1) as f64,
        }
    }

    /// Whether it is a mixture as only bodies are.
    pub fn is_mixed(&self) -> bool {
        self.fat >= 0.05 && self.muscle >= 0.05
    }

    /// Whether it is made of metal, as what is worn or implanted: nothing of a body, and no rail that is the same all along.
    pub fn may_be_prosthesis(&self, scan_mm: f32) -> bool {
        let is_rail = self.constant >= 0.8 && self.size_mm[2] >= 0.9 * scan_mm;
        self.tissue < 0.2 && self.metal >= 0.5 && !is_rail
    }

    /// Whether it looks like a table: wide and flat, and either nothing of a body or the same all along.
    pub fn is_slab(&self) -> bool {
        let wide = self.size_mm[0].max(self.size_mm[1]);
        let flat = wide >= SLAB_RATIO * 2.0 * self.deep_mm && self.deep_mm < DEEPEST_MM;
        !self.is_mixed() && flat && (self.constant >= 0.8 || self.tissue < 0.2)
    }
}
