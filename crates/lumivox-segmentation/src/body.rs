//! Which solid cells are the patient's.
//!
//! A morphological opening, in mm and by distances (J. Serra: Image analysis and mathematical morphology, 1982), keeps
//! what is thick: trunk, head, limbs. What it takes away is thin, and either the patient's (ears, nose, fingers, folds)
//! or a thing's (shells of tables, clothes, cables); size, shape and contact tell which.

use lumivox_core::{CancelToken, Cancelled};
use rayon::prelude::*;

use crate::{
    cast,
    class::Class,
    components::{Components, boxes, reach},
    distance::distances,
    grid::Grid,
    lungs,
    outside::Outside,
    shape::{DEEPEST_MM, Shape},
    table,
};

/// Cells above this are solid, in HU: a little more than half of one is skin.
pub const SOLID_HU: f32 = -450.0;

/// Half the thickness from which on something is thick, in mm.
const OPENING_MM: f32 = 5.0;

/// The smallest thick thing that counts by itself, in ml.
const LEAST_CORE_ML: f64 = 1.0;

/// Extent up to which a thin thing at the body is part of it, in mm; of longer ones only what is near.
const APPENDIX_MM: f32 = 100.0;
const NEAR_MM: f32 = 20.0;

/// Thin things at a table with values above this are of the table, in HU: bone lies deep in the body.
pub const HARD_HU: f32 = 200.0;

/// How far the inside of a prosthesis lies from that of the body, in mm.
const WORN_MM: f32 = 30.0;

/// The smallest thing that is one, in ml. Smaller ones are noise.
const LEAST_THING_ML: f64 = 0.5;

/// The solid cells, told apart.
pub struct Solids {
    /// The class of each solid cell, as its value: body, table, objects or noise; 0 of others.
    pub class: Vec<u8>,
    /// Share of the body's cells with values of fat, of muscle, and of anything in a body.
    pub body: Shape,
    /// Volume of what is solid and neither body nor table, in ml.
    pub objects_ml: f64,
}

/// Tells the solid cells apart; `None` when nothing in the scan is thick enough to be a body.
pub fn solids(grid: &Grid, means: &[f32], cancel: &CancelToken) -> Result<Option<Solids>, Cancelled> {
    let solid: Vec<bool> = means.par_iter().map(|&mean| mean > SOLID_HU).collect();
    // A chest's wall may be thin: what counts is the chest with its lungs.
    let lung = enclosed_lungs(grid, means, &solid, cancel)?;
    let full = |i: usize| solid[i] || lung[i];
    let depth = distances(grid, &|i| !full(i), DEEPEST_MM, cancel)?;
    // What nothing airy is near of lies deepest of all.
    let core = Components::new(grid, |i| full(i) && depth[i] > OPENING_MM, cancel)?;
    let Some(kinds) = judge_cores(grid, means, &depth, &core, cancel)? else { return Ok(None) };
    let is_core = |i: usize, kind: Class| kinds[core.of[i] as usize] == Some(kind);
    let margin = OPENING_MM + grid.cell_mm[0].max(grid.cell_mm[1]);
    let to_body = distances(grid, &|i| is_core(i, Class::Body), margin, cancel)?;
    let to_table = distances(grid, &|i| is_core(i, Class::Table), margin, cancel)?;

    let mut class = vec![0u8; grid.len()];
    class.par_iter_mut().enumerate().filter(|(i, _)| full(*i)).for_each(|(i, class)| {
        if to_body[i].is_finite() && to_body[i] <= to_table[i] {
            *class = Class::Body.value();
        } else if to_table[i].is_finite() {
            *class = Class::Table.value();
        }
    });
    let thin: Vec<bool> =
        class.par_iter().zip(&solid).map(|(&class, &solid)| solid && class != Class::Body.value()).collect();
    let cast = cast::casts(grid, means, &thin, |i| class[i] == Class::Body.value(), cancel)?;
    class
        .iter_mut()
        .zip(&cast)
        .filter(|&(_, &cast)| cast)
        .for_each(|(class, _)| *class = Class::Body.value());
    let thin: Vec<bool> = thin.iter().zip(&cast).map(|(&thin, &cast)| thin && !cast).collect();
    let shell = table::shells(grid, means, &thin, &depth, cancel)?;
    for (class, _) in class.iter_mut().zip(&shell).filter(|&(_, &shell)| shell) {
        *class = Class::Table.value();
    }
    judge_rest(grid, means, &solid, &mut class, cancel)?;
    class.iter_mut().zip(&solid).filter(|&(_, &solid)| !solid).for_each(|(class, _)| *class = 0);
    Ok(Some(summary(grid, means, &depth, class)))
}

/// Lungs as far as they can be told while the body is not known: hollows with the values of lungs that solids enclose.
/// Foam in a table has such values, too, but is a slab.
fn enclosed_lungs(
    grid: &Grid,
    means: &[f32],
    solid: &[bool],
    cancel: &CancelToken,
) -> Result<Vec<bool>, Cancelled> {
    let wall: Vec<u8> = solid.iter().map(|&solid| if solid { Class::Body.value() } else { 0 }).collect();
    let outside = Outside::new(grid, means, &wall, cancel)?;
    let mut lung = lungs::lungs(grid, means, &|i| !solid[i] && !outside.cells[i], cancel)?;
    let sets = Components::new(grid, |i| lung[i], cancel)?;
    let depth = distances(grid, &|i| !lung[i], DEEPEST_MM, cancel)?;
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); sets.sizes.len()];
    for (i, &set) in sets.of.iter().enumerate().filter(|&(_, &set)| set != 0) {
        members[set as usize].push(i);
    }
    for members in members.iter().filter(|members| Shape::new(grid, means, &depth, members).is_slab()) {
        members.iter().for_each(|&i| lung[i] = false);
    }
    Ok(lung)
}

/// Body or table, for each thick component; `None` where it is too small for a judgement. Nothing at all when none is a
/// body.
fn judge_cores(
    grid: &Grid,
    means: &[f32],
    depth: &[f32],
    core: &Components,
    cancel: &CancelToken,
) -> Result<Option<Vec<Option<Class>>>, Cancelled> {
    let least = (LEAST_CORE_ML / grid.cell_ml()).ceil() as usize;
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); core.sizes.len()];
    for (i, &number) in core.of.iter().enumerate() {
        if core.sizes[number as usize] >= least {
            members[number as usize].push(i);
        }
    }
    let shapes: Vec<Option<Shape>> = members
        .par_iter()
        .map(|members| (!members.is_empty()).then(|| Shape::new(grid, means, depth, members)))
        .collect();
    let mut kinds: Vec<Option<Class>> = shapes
        .iter()
        .map(|shape| {
            let shape = shape.as_ref()?;
            Some(if shape.is_slab() || shape.tissue < 0.2 { Class::Table } else { Class::Body })
        })
        .collect();
    if !kinds.contains(&Some(Class::Body)) {
        return Ok(None);
    }
    // What is of metal and close to the body is a part of it by now.
    let scan_mm = grid.dims[2] as f32 * grid.cell_mm[2];
    let is_metal =
        |number: usize| shapes[number].as_ref().is_some_and(|shape| shape.may_be_prosthesis(scan_mm));
    let metal: Vec<usize> = (0..kinds.len()).filter(|&number| is_metal(number)).collect();
    if !metal.is_empty() {
        let is_body = |i: usize| kinds[core.of[i] as usize] == Some(Class::Body);
        let to_body = distances(grid, &is_body, WORN_MM, cancel)?;
        for number in metal {
            let is_worn = members[number].iter().any(|&i| to_body[i] <= WORN_MM);
            // Elsewhere it is judged as all that is thin: by what it touches.
            kinds[number] = is_worn.then_some(Class::Body);
        }
    }
    Ok(Some(kinds))
}

/// Judges the solid cells without a class: connected sets of them, by size and by what they touch.
fn judge_rest(
    grid: &Grid,
    means: &[f32],
    solid: &[bool],
    class: &mut [u8],
    cancel: &CancelToken,
) -> Result<(), Cancelled> {
    let [body, table] = [Class::Body, Class::Table].map(Class::value);
    // Before all: what is as hard as no thin part of a body, and goes on from the table.
    let hard = |i: usize| solid[i] && class[i] == 0 && means[i] > HARD_HU;
    let hard = reach(grid, |i| class[i] == table, hard, NEAR_MM, cancel)?;
    class.iter_mut().zip(&hard).filter(|&(_, &hard)| hard).for_each(|(class, _)| *class = table);
    let rest = Components::new(grid, |i| solid[i] && class[i] == 0, cancel)?;
    let mut contacts = vec![[0usize; 2]; rest.sizes.len()];
    for (i, &number) in rest.of.iter().enumerate().filter(|&(_, &number)| number != 0) {
        grid.neighbours(i, |next| {
            let [at_body, at_table] = &mut contacts[number as usize];
            *at_body += usize::from(class[next] == body);
            *at_table += usize::from(class[next] == table);
        });
    }
    let extents: Vec<f32> = boxes(grid, &rest)
        .iter()
        .map(|[low, high]| {
            let extent = |axis: usize| (high[axis] + 1).saturating_sub(low[axis]) as f32 * grid.cell_mm[axis];
            extent(0).max(extent(1)).max(extent(2))
        })
        .collect();
    #[derive(Clone, Copy, PartialEq)]
    enum Verdict {
        All(Class),
        WhatIsNear,
    }
    let verdicts: Vec<Verdict> = (0..rest.sizes.len())
        .map(|number| {
            let [at_body, at_table] = contacts[number];
            let ml = rest.sizes[number] as f64 * grid.cell_ml();
            match (at_body, at_table) {
                (0, 0) if ml < LEAST_THING_ML => Verdict::All(Class::Noise),
                (0, 0) => Verdict::All(Class::Objects),
                _ if at_table > 2 * at_body => Verdict::All(Class::Table),
                _ if extents[number] <= APPENDIX_MM => Verdict::All(Class::Body),
                _ => Verdict::WhatIsNear,
            }
        })
        .collect();
    let partly = |i: usize| rest.of[i] != 0 && verdicts[rest.of[i] as usize] == Verdict::WhatIsNear;
    let near = if verdicts.contains(&Verdict::WhatIsNear) {
        reach(grid, |i| class[i] == body, partly, NEAR_MM, cancel)?
    } else {
        Vec::new()
    };
    for (i, &number) in rest.of.iter().enumerate().filter(|&(_, &number)| number != 0) {
        class[i] = match verdicts[number as usize] {
            Verdict::All(class) => class.value(),
            Verdict::WhatIsNear if near[i] => body,
            Verdict::WhatIsNear => Class::Objects.value(),
        };
    }
    Ok(())
}

fn summary(grid: &Grid, means: &[f32], depth: &[f32], class: Vec<u8>) -> Solids {
    let body: Vec<usize> = (0..grid.len()).filter(|&i| class[i] == Class::Body.value()).collect();
    let objects = class.iter().filter(|&&class| class == Class::Objects.value()).count();
    let body = Shape::new(grid, means, depth, &body);
    Solids { class, body, objects_ml: objects as f64 * grid.cell_ml() }
}
