//! A copy of a volume on its way into its bricks.

use std::sync::Arc;

use lumivox_shaders::constants::BRICK_TEXELS;

use super::bricks::{self, Run};
use super::bricks_ahead::BricksAhead;
use super::pools::{self, Pools};
use super::value_ranges::Ranges;
use super::{AT_ONCE, Bricks, Source, WeakSource};
use crate::recording::{Payload, Recording, ResourceId, Step, TextureFormat};

/// Bytes of one upload: small enough to bound the memory of staging, large enough to be fast.
const UPLOAD_BYTES: u64 = 32 << 20;

/// What is on its way, and how far it is.
#[derive(Debug)]
pub(super) struct Arrival {
    source: WeakSource,
    /// All texels, made ahead.
    prepared: Option<Arc<Vec<u16>>>,
    /// Cuts what other frames bring.
    ahead: Option<BricksAhead>,
    /// Bricks that are there.
    done: usize,
    /// The copy's pages, for the kernel that looks at what is there.
    pages: Option<ResourceId>,
}

impl Arrival {
    pub fn new(source: &Source) -> Self {
        Self { source: source.downgrade(), prepared: None, ahead: None, done: 0, pages: None }
    }

    /// Of texels in the order of bricks.
    pub fn of_prepared(source: &Source, prepared: Arc<Vec<u16>>) -> Self {
        Self { prepared: Some(prepared), ..Self::new(source) }
    }

    /// What it has on the device besides bricks.
    pub fn buffer(&self) -> Option<ResourceId> {
        self.pages
    }

    /// Whether all bricks are there, and their value ranges.
    pub fn is_done(&self, bricks: &Bricks, ranges: &[Ranges]) -> bool {
        self.done == bricks.pages.len() && ranges.iter().all(Ranges::is_whole)
    }

    /// Records as many bricks more as the budget allows and as are cut by now, and the value ranges of as much of what is
    /// there then: to look at voxels takes a device as long as to bring them.
    pub fn advance(
        &mut self,
        bricks: &Bricks,
        ranges: &mut [Ranges],
        pools: &Pools,
        budget: &mut u64,
        recording: &mut Recording,
    ) {
        if self.source.is_gone() {
            return;
        }
        let (_, format) = pools.texture_of(bricks.pages[0]);
        let all = pools.bytes_of(format, bricks.pages.len() as u64);
        let least = if *budget > 0 { pools.bytes_of(format, 1) } else { 0 };
        let share = least.max(*budget) as f64 / all as f64;
        let only_looks = self.done == bricks.pages.len();
        let granted = *budget;
        while *budget > 0 && self.done < bricks.pages.len() {
            let (texture, format) = pools.texture_of(bricks.pages[self.done]);
            let Some((run, texels)) = self.next(bricks, pools, format, granted, *budget) else { break };
            *budget = budget.saturating_sub(texels.bytes().len() as u64);
            recording.push(Step::WriteTexture {
                id: texture,
                origin: pools::first_texel(bricks.pages[self.done]),
                size: [run.size[0] * BRICK_TEXELS, run.size[1] * BRICK_TEXELS, BRICK_TEXELS],
                data: texels,
            });
            self.done += run.bricks();
        }
        if let Some(ahead) = &mut self.ahead {
            let of_page = |page: u32| {
                let (_, format) = pools.texture_of(page);
                (format, pools.bytes_of(format, 1))
            };
            ahead.go_on(bricks, of_page, granted);
        }
        let layer = (bricks.grid.counts[0] * bricks.grid.counts[1]) as usize;
        let layers = (self.done / layer) as u32;
        if ranges.iter().any(|ranges| ranges.wants(bricks, layers)) {
            let pages =
                *self.pages.get_or_insert_with(|| recording.create_buffer_with("pages", &bricks.pages));
            for ranges in ranges {
                ranges.record(bricks, pages, pools, layers, share, recording);
            }
            if only_looks {
                // The frame's time went into looking.
                *budget = budget.saturating_sub(all);
            }
        }
    }

    /// The next run and its texels; `None` while others are cutting it, or if it is more than is left of what was granted.
    fn next(
        &mut self,
        bricks: &Bricks,
        pools: &Pools,
        format: TextureFormat,
        granted: u64,
        left: u64,
    ) -> Option<(Run, Payload)> {
        if granted < AT_ONCE && self.prepared.is_none() && BricksAhead::has_threads() {
            let ahead = self.ahead.get_or_insert_with(|| BricksAhead::new(&self.source, self.done));
            // The first, however large: they were cut for frames as this one.
            return ahead.take(if left == granted { u64::MAX } else { left });
        }
        // What others are at comes too late.
        self.ahead = None;
        let most = left.min(UPLOAD_BYTES) / pools.bytes_of(format, 1);
        let run = bricks::run(bricks, self.done, most.max(1) as usize);
        let texels = match &self.prepared {
            Some(prepared) => bricks::prepared_texels(prepared, bricks, run, format),
            None => bricks::texels(&self.source.upgrade()?, bricks.factor, bricks.grid, run, format),
        };
        Some((run, texels))
    }

    pub fn free(self, recording: &mut Recording) {
        recording.free(self.pages);
    }
}
