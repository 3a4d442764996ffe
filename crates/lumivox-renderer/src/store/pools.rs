//! All textures full of bricks, each of one format: which volume gets which of their bricks.

use std::sync::Arc;

use lumivox_core::{Volume, Voxels};
use lumivox_shaders::constants::{BRICK_TEXELS, LOW_BYTE, PAGE_BITS};
use lumivox_shaders::layout::POOL_COUNT;

use super::bricks::BrickGrid;
use super::pool::{Pool, shape, volume};
use super::texture_ahead::TextureAhead;
use super::{Bricks, TEXELS};
use crate::limits::{DeviceLimits, FineTexels};
use crate::recording::{Recording, ResourceId, TextureFormat};

/// Bytes by which a pool may be too large to be used again.
const SLACK_BYTES: u64 = 64 << 20;

/// Pools of 8 bits at most: there is always one left for 16.
const MAX_EIGHT_BIT: usize = POOL_COUNT / 2;

/// All pools of a device.
#[derive(Clone, Debug)]
pub(super) struct Pools {
    /// By the number in pages.
    list: Vec<Option<Pool>>,
    /// Bricks along an axis of a pool at most.
    max_side: u32,
    max_bytes: u64,
    fine_format: TextureFormat,
    /// What is bound where there is no pool.
    nothing: Option<ResourceId>,
    /// Copies that were replaced, as long as some scene shows them, and their pages.
    retired: Vec<(Arc<Bricks>, Vec<u32>)>,
    /// Textures that are made for pools to come.
    pub ahead: Vec<TextureAhead>,
    /// Bricks of what is about to come: no pool is left that has room for them.
    pub expected: Vec<(TextureFormat, usize)>,
}

/// A copy of a volume that wants bricks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    pub format: TextureFormat,
    pub bricks: BrickGrid,
    /// Whether another takes its place soon.
    pub passes: bool,
}

/// The pool of a page.
pub(super) fn pool(page: u32) -> usize {
    (page >> (3 * PAGE_BITS)) as usize
}

fn place(page: u32) -> [u32; 3] {
    [0, 1, 2].map(|axis| page >> (axis * PAGE_BITS) & ((1 << PAGE_BITS) - 1))
}

fn page(pool: usize, [x, y, z]: [u32; 3]) -> u32 {
    (pool as u32) << (3 * PAGE_BITS) | z << (2 * PAGE_BITS) | y << PAGE_BITS | x
}

/// The first texel of a page's brick.
pub(super) fn first_texel(page: u32) -> [u32; 3] {
    place(page).map(|n| n * BRICK_TEXELS)
}

/// Whether a page is so many bricks away from another along x and y.
pub(super) fn is_beside(other: u32, origin: u32, [dx, dy]: [u32; 2]) -> bool {
    let [x, y, z] = place(origin);
    pool(other) == pool(origin) && place(other) == [x + dx, y + dy, z]
}

impl Pools {
    pub fn new(limits: &DeviceLimits) -> Self {
        let max_side = (limits.max_texture_3d / BRICK_TEXELS).clamp(1, 1 << PAGE_BITS);
        Self {
            list: vec![None; if limits.one_pool { 1 } else { POOL_COUNT }],
            max_side,
            max_bytes: limits.max_texture_bytes,
            fine_format: match limits.fine_texels {
                FineTexels::Norms => TextureFormat::R16Unorm,
                FineTexels::TwoBytes => TextureFormat::Rg8Unorm,
                FineTexels::Halves => TextureFormat::R16Float,
            },
            nothing: None,
            retired: vec![],
            ahead: vec![],
            expected: vec![],
        }
    }

    fn pools(&self) -> impl Iterator<Item = &Pool> {
        self.list.iter().flatten()
    }

    /// Bytes of all textures, those that are made ahead too.
    pub fn bytes(&self) -> u64 {
        self.lasting_bytes() + self.pools().map(Pool::passing_bytes).sum::<u64>()
    }

    /// But for those that larger ones take the place of.
    pub fn lasting_bytes(&self) -> u64 {
        self.pools().map(Pool::bytes).sum::<u64>() + self.ahead.iter().map(TextureAhead::bytes).sum::<u64>()
    }

    /// Of so many bricks.
    pub fn bytes_of(&self, format: TextureFormat, bricks: u64) -> u64 {
        bricks * TEXELS * format.bytes_per_texel() as u64
    }

    /// The format of a volume's texels: what it needs, unless there is no pool to be had of that.
    pub fn format(&self, volume: &Volume) -> TextureFormat {
        let eight_bit = self.pools().filter(|pool| pool.format == TextureFormat::R8Unorm).count();
        let can_have_one = eight_bit > 0 || self.list.iter().any(Option::is_none);
        match volume.voxels() {
            Voxels::U8(_) if self.list.len() > 1 && can_have_one => TextureFormat::R8Unorm,
            _ => self.fine_format,
        }
    }

    /// Where a page's brick lies.
    pub fn texture_of(&self, page: u32) -> (ResourceId, TextureFormat) {
        let pool = self.list[pool(page)].as_ref().expect("a page is in a pool");
        (pool.texture, pool.format)
    }

    /// As kernels bind them: something at every place.
    pub fn textures(&self) -> Vec<ResourceId> {
        let any = self.pools().next().map(|pool| pool.texture).or(self.nothing);
        self.list
            .iter()
            .map(|pool| pool.as_ref().map(|pool| pool.texture).or(any).expect("there is something to bind"))
            .collect()
    }

    /// One over the texels along each axis of each, and the weight of their second channel.
    pub fn inverse_sizes(&self) -> [[f32; 4]; POOL_COUNT] {
        std::array::from_fn(|i| {
            let size = self.list.get(i).and_then(Option::as_ref).map_or([1; 3], |pool| pool.texture_size);
            let [x, y, z] = size.map(|n| 1.0 / (n * BRICK_TEXELS) as f32);
            [x, y, z, if self.is_split(i) { LOW_BYTE } else { 0.0 }]
        })
    }

    /// A bit for each whose values are stored in two bytes.
    pub fn split(&self) -> u32 {
        (0..self.list.len()).map(|i| u32::from(self.is_split(i)) << i).sum()
    }

    fn is_split(&self, index: usize) -> bool {
        let pool = self.list.get(index).and_then(Option::as_ref);
        pool.is_some_and(|pool| pool.format == TextureFormat::Rg8Unorm)
    }

    /// A scene without volumes has to bind a texture, too.
    pub fn ensure_one_to_bind(&mut self, recording: &mut Recording) {
        let format = self.fine_format;
        self.nothing.get_or_insert_with(|| recording.create_texture("no voxels", format, [1; 3]));
    }

    /// Whether pages lie in a pool that is left.
    pub fn is_left(&self, pages: &[u32]) -> bool {
        let left = self.left();
        pages.iter().any(|page| left[pool(*page)])
    }

    /// Pools that their last volumes leave, where there can be others.
    fn left(&self) -> Vec<bool> {
        let expected = |format| self.expected.iter().filter(|(f, _)| *f == format).map(|(_, n)| n).sum();
        let is_left =
            |pool: &Option<Pool>| pool.as_ref().is_some_and(|pool| pool.is_sparse(expected(pool.format)));
        self.list.iter().map(|pool| self.list.len() > 1 && is_left(pool)).collect()
    }

    /// Pages for each of some copies; `None` if there is no room for all, or only beyond `capacity` bytes.
    pub fn allocate(
        &mut self,
        copies: &[Wanted],
        capacity: u64,
        recording: &mut Recording,
    ) -> Option<Vec<Vec<u32>>> {
        self.reclaim();
        let mut planned = self.clone();
        let mut steps = Recording::new();
        let mut pages = vec![vec![]; copies.len()];
        // What soon goes again lies apart, where there can be another pool for it.
        let parts: &[&[bool]] = if self.list.len() > 1 { &[&[false], &[true]] } else { &[&[false, true]] };
        for format in [TextureFormat::R8Unorm, planned.fine_format] {
            let bricks = |part: &[bool]| {
                let of_part = copies.iter().filter(|c| c.format == format && part.contains(&c.passes));
                of_part.map(|c| c.bricks.count()).sum::<u64>() as usize
            };
            let needed = bricks(&[false, true]);
            if needed == 0 {
                continue;
            }
            // An empty pool is used again if it suits: textures that are freed may be there a little longer.
            let slack = needed.min((SLACK_BYTES / planned.bytes_of(format, 1)) as usize);
            let suits = |pool: &Pool| pool.format == format && pool.capacity() <= needed + slack;
            planned.free_empty_but(suits, &mut steps);
            for part in parts {
                let members = copies.iter().zip(&mut pages);
                let members = members.filter(|(c, _)| c.format == format && part.contains(&c.passes));
                let members: Vec<(BrickGrid, &mut Vec<u32>)> = members.map(|(c, p)| (c.bricks, p)).collect();
                let widest =
                    |axis: usize| members.iter().map(|(grid, _)| grid.counts[axis]).max().unwrap_or(1);
                planned.make_room(format, bricks(part), [widest(0), widest(1)], &mut steps)?;
                let mut free = planned.free_pages(format).into_iter();
                for (grid, pages) in members {
                    *pages = free.by_ref().take(grid.count() as usize).collect();
                    for page in &*pages {
                        planned.set_taken(*page, true);
                    }
                }
            }
        }
        if planned.lasting_bytes() > capacity {
            return None;
        }
        *self = planned;
        recording.steps.append(&mut steps.steps);
        Some(pages)
    }

    /// Sees to it that `needed` bricks of a format are free: in new pools, or in larger ones where there are all that can
    /// be.
    fn make_room(
        &mut self,
        format: TextureFormat,
        needed: usize,
        widest: [u32; 2],
        recording: &mut Recording,
    ) -> Option<()> {
        let brick = TEXELS * format.bytes_per_texel() as u64;
        let most = (self.max_bytes / brick).min(u64::from(self.max_side).pow(3)) as usize;
        let max_side = self.max_side;
        loop {
            let rest = needed.saturating_sub(self.free_pages(format).len());
            if rest == 0 {
                return Some(());
            }
            let of_format = self.pools().filter(|pool| pool.format == format).count();
            let may_be_one_more = format != TextureFormat::R8Unorm || of_format < MAX_EIGHT_BIT;
            let empty = self.list.iter().position(Option::is_none).filter(|_| may_be_one_more);
            if let Some(index) = empty {
                let size =
                    shape([widest[0], widest[1], 1].map(|n| n.min(max_side)), rest.min(most), max_side)
                        .filter(|size| volume(*size) <= most)
                        .or_else(|| shape([1; 3], rest.min(most), max_side))?;
                self.list[index] = Some(Pool::new(format, size, &mut self.ahead, recording));
                continue;
            }
            // The smallest that can grow: what has to be copied is little.
            let growing = self.list.iter_mut().flatten().filter(|pool| pool.format == format);
            let pool = growing.filter(|pool| pool.capacity() < most).min_by_key(|pool| pool.capacity())?;
            let wanted = (pool.capacity() + rest).min(most);
            // As wide as what comes, if that wastes little: rows of bricks come in one piece.
            let wider =
                [0, 1, 2].map(|axis| pool.size[axis].max(*widest.get(axis).unwrap_or(&1)).min(max_side));
            let size = shape(wider, wanted, max_side)
                .filter(|size| volume(*size) <= most.min(wanted + wanted / 8))
                .or_else(|| shape(pool.size, wanted, max_side).filter(|size| volume(*size) <= most))
                .or_else(|| shape(pool.size, wanted - volume([pool.size[0], pool.size[1], 1]), max_side))
                .filter(|size| volume(*size) > pool.capacity())?;
            pool.grow(size, &mut self.ahead, recording);
        }
    }

    /// Goes on with pools that grow.
    pub fn grow_on(&mut self, budget: &mut u64, recording: &mut Recording) {
        for pool in self.list.iter_mut().flatten() {
            pool.move_on(budget, recording);
        }
    }

    /// Whether some pool grows.
    pub fn is_growing(&self) -> bool {
        self.pools().any(|pool| pool.successor.is_some())
    }

    /// Whether pages lie in a pool that grows, so that nothing can be written there.
    pub fn is_growing_at(&self, pages: &[u32]) -> bool {
        let grows = |page: &u32| self.list[pool(*page)].as_ref().is_some_and(|pool| pool.successor.is_some());
        self.is_growing() && pages.iter().any(grows)
    }

    /// In the order in which they are given away.
    fn free_pages(&self, format: TextureFormat) -> Vec<u32> {
        let left = self.left();
        let pools = self.list.iter().enumerate().filter(|(index, _)| !left[*index]);
        let of_format = pools.filter_map(|(index, pool)| {
            pool.as_ref().filter(|pool| pool.format == format && pool.free() > 0).map(|pool| (index, pool))
        });
        of_format
            .flat_map(|(index, pool)| {
                let free = pool.taken.iter().enumerate().filter(|(_, taken)| !**taken);
                free.map(move |(brick, _)| page(index, pool.place(brick)))
            })
            .collect()
    }

    fn set_taken(&mut self, page: u32, is_taken: bool) {
        let Some(pool) = &mut self.list[pool(page)] else { return };
        let index = pool.index(place(page));
        let was_taken = std::mem::replace(&mut pool.taken[index], is_taken);
        pool.taken_count = pool.taken_count + usize::from(is_taken) - usize::from(was_taken);
    }

    /// Gives bricks back.
    pub fn release(&mut self, pages: impl IntoIterator<Item = u32>) {
        for page in pages {
            self.set_taken(page, false);
        }
    }

    /// Gives a copy's bricks back as soon as no scene shows it.
    pub fn retire(&mut self, bricks: Arc<Bricks>) {
        let pages = bricks.pages.clone();
        self.retired.push((bricks, pages));
    }

    /// Gives back the bricks of copies that no scene shows any more.
    pub fn reclaim(&mut self) {
        let (shown, gone): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.retired).into_iter().partition(|(copy, _)| Arc::strong_count(copy) > 1);
        self.retired = shown;
        for (_, pages) in gone {
            self.release(pages);
        }
    }

    /// Frees pools without bricks.
    pub fn free_empty(&mut self, recording: &mut Recording) {
        self.free_empty_but(|_| false, recording);
    }

    fn free_empty_but(&mut self, keep: impl Fn(&Pool) -> bool, recording: &mut Recording) {
        for slot in &mut self.list {
            if slot.as_ref().is_some_and(|pool| pool.taken_count == 0 && !keep(pool)) {
                slot.take().into_iter().for_each(|pool| pool.free_textures(recording));
            }
        }
    }

    /// Drops the pools whose textures are gone, or spoilt because what was to be copied into them was not; returns their
    /// numbers, and adds textures that nobody uses any more to `orphans`. No copy may be on its way.
    pub fn forget(
        &mut self,
        is_gone: impl Fn(ResourceId) -> bool,
        is_spoilt: impl Fn(ResourceId) -> bool,
        orphans: &mut Vec<ResourceId>,
    ) -> Vec<usize> {
        if self.nothing.is_some_and(&is_gone) {
            self.nothing = None;
        }
        let is_lost = |id: ResourceId| is_gone(id) || is_spoilt(id);
        let mut lost = vec![];
        for (index, slot) in self.list.iter_mut().enumerate() {
            if let Some(pool) = slot.take_if(|pool| is_lost(pool.texture)) {
                orphans.push(pool.texture);
                orphans.extend(pool.successor.map(|successor| successor.texture));
                lost.push(index);
            } else if let Some(pool) = slot
                && pool.successor.is_some_and(|successor| is_lost(successor.texture))
            {
                orphans.extend(pool.stay().map(|successor| successor.texture));
            }
        }
        // Their numbers are given away again.
        for (_, pages) in &mut self.retired {
            pages.retain(|page| !lost.contains(&pool(*page)));
        }
        lost
    }

    /// Gives up textures that are made ahead; returns whether any was. One that is being made at this moment stays.
    pub fn drop_ahead(
        &mut self,
        is_stale: impl Fn(&TextureAhead) -> bool,
        recording: &mut Recording,
    ) -> bool {
        let before = self.ahead.len();
        self.ahead.retain(|ahead| !(is_stale(ahead) && ahead.give_up(recording)));
        self.ahead.len() < before
    }

    pub fn free(&mut self, recording: &mut Recording) {
        for slot in &mut self.list {
            slot.take().into_iter().for_each(|pool| pool.free_textures(recording));
        }
        recording.free(self.nothing.take());
        self.retired.clear();
        self.drop_ahead(|_| true, recording);
    }
}
