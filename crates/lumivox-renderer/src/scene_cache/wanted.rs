//! What a scene wants of the store: its volumes, each once, and the grids of cells over them.

use super::Placed;
use super::cell_size::CellSize;
use super::fields::Field;
use crate::store::{BrickGrid, GridKey, MAX_CELL_SIZE, Source, grid};

/// Each volume once, in the order of its first instance, and the grid that its filters need and its first look wants; then
/// the fields. And how many instances or fields each is of.
pub(super) fn distinct(
    instances: &[Placed<'_>],
    cell_size: CellSize,
) -> (Vec<(Source, GridKey)>, Vec<usize>) {
    let mut volumes: Vec<(Source, GridKey)> = vec![];
    let mut uses: Vec<usize> = vec![];
    for placed in instances {
        let source = placed.source();
        match volumes.iter().position(|(known, _)| *known == source) {
            Some(known) => {
                volumes[known].1.wide |= GridKey::new(placed.medium.filter, None).wide;
                uses[known] += 1;
            }
            None => {
                let cell_size = cell_size.voxels(&placed.instance.volume, &placed.medium);
                volumes.push((source, GridKey::new(placed.medium.filter, cell_size)));
                uses.push(1);
            }
        }
    }
    for field in Field::all(instances) {
        match volumes.iter().position(|(known, _)| *known == field.source) {
            Some(known) => uses[known] += 1,
            None => {
                let key = field.grid_key();
                volumes.push((field.source, key));
                uses.push(1);
            }
        }
    }
    (volumes, uses)
}

/// Enlarges the cells of the largest grids while all have more of them than `most`: rays take longer then, but no voxel is
/// lost. `uses` counts the grids that are made of each volume.
pub(super) fn widen(wanted: &mut [(Source, GridKey)], uses: &[usize], most: usize) {
    let grid_of = |(source, key): &(Source, GridKey)| {
        let (cells, size) = grid(BrickGrid::new(source.volume.dims(), 1).dims, key.cell_size);
        (cells.iter().map(|&n| n as usize).product::<usize>(), size)
    };
    loop {
        let cells: Vec<usize> = wanted.iter().zip(uses).map(|(of, uses)| grid_of(of).0 * uses).collect();
        if cells.iter().sum::<usize>() <= most {
            return;
        }
        let can_widen = |&index: &usize| grid_of(&wanted[index]).1 < MAX_CELL_SIZE;
        let Some(largest) = (0..wanted.len()).filter(can_widen).max_by_key(|&index| cells[index]) else {
            return;
        };
        wanted[largest].1.cell_size = Some(2 * grid_of(&wanted[largest]).1);
    }
}
