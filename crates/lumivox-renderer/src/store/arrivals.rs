//! How volumes come: room for them first, then their bricks, as many as a budget allows.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::arrival::Arrival;
use super::bricks::{self, BrickGrid};
use super::coarse::{QUICK_BYTES, coarse_copy};
use super::pools::Wanted;
use super::value_ranges::GridKey;
use super::{AT_ONCE, Bricks, Source, Store, StoredCopy};
use crate::error::RenderError;
use crate::recording::{Recording, TextureFormat};

/// Halvings after which there is no room for anything.
const MAX_FACTOR: u32 = 64;

/// What there has to be room for.
pub(super) struct ArrivalPlan {
    pub source: Source,
    /// Voxels of the volume along an axis for one of the copy.
    pub factor: u32,
    /// Whether it may come in one piece.
    pub at_once: bool,
    /// Those of the coarse copy that comes first, if one does.
    pub coarse: Option<u32>,
}

impl ArrivalPlan {
    /// The copies that come, the coarse one last: it lies behind the other.
    fn factors(&self) -> impl Iterator<Item = u32> {
        let coarse = self.coarse.filter(|coarse| *coarse > self.factor);
        std::iter::once(self.factor).chain(coarse)
    }
}

impl Store {
    /// Makes room for what is not there, reduced as far as it must be, and for those that could be finer by now. Of a large
    /// volume that more than `budget` bytes have to be brought of, a coarse copy comes first.
    pub(super) fn begin_arrivals(
        &mut self,
        wanted: &[(Source, GridKey)],
        budget: u64,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        let is_new = |source: &&Source| {
            self.entry(source).is_some_and(|entry| entry.shown.is_none() && entry.arriving.is_empty())
        };
        self.pools.expected = self.expected(wanted.iter().map(|(source, _)| source).filter(is_new));
        let begun = self.begin_expected(wanted, budget, recording);
        self.pools.expected.clear();
        begun
    }

    /// Bricks of volumes that come whole.
    pub(super) fn expected<'a>(
        &self,
        sources: impl Iterator<Item = &'a Source>,
    ) -> Vec<(TextureFormat, usize)> {
        let bricks = |source: &Source| {
            let volume = &source.volume;
            let count = BrickGrid::new(volume.dims(), bricks::least_factor(volume.dims())).count();
            (self.pools.format(volume), count as usize)
        };
        sources.map(bricks).collect()
    }

    fn begin_expected(
        &mut self,
        wanted: &[(Source, GridKey)],
        mut budget: u64,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        let mut new: Vec<ArrivalPlan> = vec![];
        if self.pools.is_growing() && budget < AT_ONCE {
            // What comes meanwhile would have a pool begin anew: it comes when there is room.
            return Ok(());
        }
        for (source, _) in wanted {
            let Some(index) = self.index(source) else { continue };
            let volume = &source.volume;
            let entry = &self.entries[index];
            let is_coarse = entry.shown.as_ref().is_some_and(|shown| shown.bricks.factor > 1);
            let is_sparse = entry.shown.as_ref().is_some_and(|shown| self.pools.is_left(&shown.bricks.pages));
            let may_be_finer = is_coarse && entry.tried != self.releases;
            if entry.arriving.is_empty() && (entry.shown.is_none() || may_be_finer || is_sparse) {
                let whole = BrickGrid::new(volume.dims(), 1).count();
                let bytes = self.pools.bytes_of(self.pools.format(volume), whole);
                // What the budget was learnt from was cut on other threads: little is cut in a frame.
                let at_most = if budget < AT_ONCE { budget.min(QUICK_BYTES) } else { budget };
                let comes_at_once = bytes <= at_most;
                budget -= if comes_at_once { bytes } else { 0 };
                new.push(ArrivalPlan {
                    source: source.clone(),
                    factor: bricks::least_factor(volume.dims()),
                    at_once: comes_at_once,
                    coarse: self.coarse_first(source, comes_at_once),
                });
            }
        }
        if new.is_empty() {
            return Ok(());
        }
        let mut capacity = self.capacity;
        let mut made = Recording::new();
        let mut pages = loop {
            match self.pools.allocate(&self.bricks_of(&new), capacity, &mut made) {
                Some(pages) => break pages.into_iter(),
                None if self.pools.drop_ahead(|_| true, recording) => {}
                None if self.evict(recording) => {
                    // It may have stood in.
                    for plan in &mut new {
                        plan.coarse = self.coarse_first(&plan.source, plan.at_once);
                    }
                }
                None => {
                    let count =
                        |plan: &ArrivalPlan| BrickGrid::new(plan.source.volume.dims(), plan.factor).count();
                    let largest = new.iter_mut().max_by_key(|plan| count(plan));
                    // Nothing takes less than a brick.
                    match largest.filter(|plan| count(plan) > 1 && plan.factor < MAX_FACTOR) {
                        Some(plan) => plan.factor *= 2,
                        // Little is better than nothing.
                        None if capacity < u64::MAX => capacity = u64::MAX,
                        None => return Err(RenderError::NoRoom { count: wanted.len() }),
                    }
                }
            }
        };
        // What was made ahead and is not what they lie in gives its room first.
        self.drop_stale(recording);
        recording.steps.append(&mut made.steps);
        for plan in new {
            let copies: Vec<(u32, Vec<u32>)> = plan.factors().zip(&mut pages).collect();
            self.begin_arrival(&plan, copies);
        }
        Ok(())
    }

    /// Has copies of a volume come, the last one first: their factors, and their pages.
    fn begin_arrival(&mut self, plan: &ArrivalPlan, copies: Vec<(u32, Vec<u32>)>) {
        let index = self.index(&plan.source).expect("all that is wanted has an entry");
        let volume = &plan.source.volume;
        let Self { entries, pools, unprepared, releases, .. } = self;
        let entry = &mut entries[index];
        entry.tried = *releases;
        for (factor, pages) in copies.into_iter().rev() {
            let bricks = Bricks {
                source: entry.id,
                factor,
                grid: BrickGrid::new(volume.dims(), factor),
                pages,
                lender: None,
                is_lost: AtomicBool::new(false),
            };
            // No finer than what there is: it stays.
            let better = entry.shown.as_ref().is_none_or(|shown| {
                let before = &shown.bricks;
                bricks.factor < before.factor
                    || bricks.factor == before.factor && pools.is_left(&before.pages)
            });
            if !better {
                pools.release(bricks.pages);
                continue;
            }
            let arrival = if plan.coarse == Some(bricks.factor) {
                let (copy, is_late) = coarse_copy(&plan.source);
                *unprepared += u64::from(is_late);
                Arrival::of_prepared(&plan.source, copy)
            } else {
                Arrival::new(&plan.source)
            };
            entry.arriving.push_back((StoredCopy { bricks: Arc::new(bricks), ranges: vec![] }, arrival));
        }
    }

    /// The bricks of the copies that come, in their order.
    pub(super) fn bricks_of(&self, new: &[ArrivalPlan]) -> Vec<Wanted> {
        new.iter()
            .flat_map(|plan| {
                let format = self.pools.format(&plan.source.volume);
                plan.factors().map(move |factor| Wanted {
                    format,
                    bricks: BrickGrid::new(plan.source.volume.dims(), factor),
                    passes: factor != plan.factor,
                })
            })
            .collect()
    }

    /// Brings more of a volume that is under way, and shows each copy once it is whole. The first one comes in one piece,
    /// if there is any budget left or no other has begun, unless there is something to show meanwhile.
    pub(super) fn advance(
        &mut self,
        source: &Source,
        key: GridKey,
        budget: &mut u64,
        has_begun: &mut bool,
        recording: &mut Recording,
    ) {
        let Some(index) = self.index(source) else { return };
        let stands_in = self.stand_in(source).is_some();
        let Self { entries, pools, .. } = self;
        let entry = &mut entries[index];
        let is_new = entry.shown.is_none() && !stands_in && *budget < AT_ONCE;
        while let Some((copy, arrival)) = entry.arriving.front_mut() {
            if pools.is_growing_at(&copy.bricks.pages) {
                return;
            } else if entry.shown.is_some() && is_new {
                // Tables and films follow it: the frame is late enough.
                *budget = 0;
                return;
            } else if entry.shown.is_some() || stands_in {
                copy.want(key, recording);
                arrival.advance(&copy.bricks, &mut copy.ranges, pools, budget, recording);
            } else if *budget > 0 || !*has_begun {
                *has_begun = true;
                copy.want(key, recording);
                let mut all = u64::MAX;
                arrival.advance(&copy.bricks, &mut copy.ranges, pools, &mut all, recording);
                *budget = budget.saturating_sub(u64::MAX - all);
            }
            if !arrival.is_done(&copy.bricks, &copy.ranges) {
                return;
            }
            if let Some((copy, arrival)) = entry.arriving.pop_front() {
                arrival.free(recording);
                if let Some(before) = entry.shown.replace(copy) {
                    before.free_ranges(recording);
                    pools.retire(before.bricks);
                }
            }
        }
    }
}
