//! A copy of a volume on its way into its bricks.

use std::sync::Arc;

use lumivox_shaders::constants::BRICK_TEXELS;

use super::bricks::{self, Run};
use super::cutter::Cutter;
use super::pools::{self, Pools};
use super::value_ranges::Ranges;
use super::{AT_ONCE, Resident, Source, WeakSource};
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
    cutter: Option<Cutter>,
    /// Bricks that are there.
    done: usize,
    /// The copy's pages, for the kernel that looks at what is there.
    pages: Option<ResourceId>,
}

impl Arrival {
    pub fn new(source: &Source) -> Self {
        Self { source: source.downgrade(), prepared: None, cutter: None, done: 0, pages: None }
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
    pub fn is_done(&self, resident: &Resident, ranges: &[Ranges]) -> bool {
        self.done == resident.pages.len() && ranges.iter().all(Ranges::is_whole)
    }

    /// Records as many bricks more as the budget allows and as are cut by now, and the value ranges of as much of what is
    /// there then: to look at voxels takes a device as long as to bring them.
    pub fn advance(
        &mut self,
        resident: &Resident,
        ranges: &mut [Ranges],
        pools: &Pools,
        budget: &mut u64,
        recording: &mut Recording,
    ) {
        if self.source.is_gone() {
            return;
        }
        let (_, format) = pools.texture_of(resident.pages[0]);
        let all = pools.bytes_of(format, resident.pages.len() as u64);
        let least = if *budget > 0 { pools.bytes_of(format, 1) } else { 0 };
        let share = least.max(*budget) as f64 / all as f64;
        let only_looks = self.done == resident.pages.len();
        let granted = *budget;
        while *budget > 0 && self.done < resident.pages.len() {
            let (texture, format) = pools.texture_of(resident.pages[self.done]);
            let Some((run, texels)) = self.next(resident, pools, format, granted, *budget) else { break };
            *budget = budget.saturating_sub(texels.bytes().len() as u64);
            recording.push(Step::WriteTexture {
                id: texture,
                origin: pools::first_texel(resident.pages[self.done]),
                size: [run.size[0] * BRICK_TEXELS, run.size[1] * BRICK_TEXELS, BRICK_TEXELS],
                data: texels,
            });
            self.done += run.bricks();
        }
        if let Some(cutter) = &mut self.cutter {
            let of_page = |page: u32| {
                let (_, format) = pools.texture_of(page);
                (format, pools.bytes_of(format, 1))
            };
            cutter.go_on(resident, of_page, granted);
        }
        let layer = (resident.bricks.counts[0] * resident.bricks.counts[1]) as usize;
        let layers = (self.done / layer) as u32;
        if ranges.iter().any(|ranges| ranges.wants(resident, layers)) {
            let pages =
                *self.pages.get_or_insert_with(|| recording.create_buffer_with("pages", &resident.pages));
            for ranges in ranges {
                ranges.record(resident, pages, pools, layers, share, recording);
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
        resident: &Resident,
        pools: &Pools,
        format: TextureFormat,
        granted: u64,
        left: u64,
    ) -> Option<(Run, Payload)> {
        if granted < AT_ONCE && self.prepared.is_none() && Cutter::has_threads() {
            let cutter = self.cutter.get_or_insert_with(|| Cutter::new(&self.source, self.done));
            // The first, however large: they were cut for frames as this one.
            return cutter.take(if left == granted { u64::MAX } else { left });
        }
        // What others are at comes too late.
        self.cutter = None;
        let most = left.min(UPLOAD_BYTES) / pools.bytes_of(format, 1);
        let run = bricks::run(resident, self.done, most.max(1) as usize);
        let texels = match &self.prepared {
            Some(prepared) => bricks::prepared_texels(prepared, resident, run, format),
            None => bricks::texels(&self.source.upgrade()?, resident.factor, resident.bricks, run, format),
        };
        Some((run, texels))
    }

    pub fn free(self, recording: &mut Recording) {
        recording.free(self.pages);
    }
}
