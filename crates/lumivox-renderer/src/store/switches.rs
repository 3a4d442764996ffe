//! A volume whose filter is switched, so that it is read otherwise: what is there stands in for what comes, and goes once
//! that is whole.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::coarse::{coarse_factor, needs_coarse_copy};
use super::{Bricks, Entry, GridKey, SceneCopy, Source, Store};
use crate::recording::{Recording, ResourceId};

impl Store {
    /// The same volume as the other filters read it.
    fn other(&self, source: &Source) -> Option<&Entry> {
        let is_other = |entry: &&Entry| entry.source.is_like(source) && entry.source != *source;
        self.entries.iter().find(is_other)
    }

    /// What scenes show of a volume of which nothing is there as they read it: how the other filters do, unless a coarse
    /// copy would be finer.
    pub(super) fn stand_in(&self, source: &Source) -> Option<&Entry> {
        if self.entry(source).is_some_and(|entry| entry.shown.is_some()) {
            return None;
        }
        let is_fine =
            |other: &&Entry| other.factor().is_some_and(|factor| factor <= coarse_factor(&source.volume));
        self.other(source).filter(is_fine)
    }

    /// The factor of the coarse copy that comes before a volume that takes more than a frame to bring, where nothing else
    /// can be shown meanwhile.
    pub(super) fn coarse_first(&self, source: &Source, comes_at_once: bool) -> Option<u32> {
        let has_any = self.entry(source).is_some_and(|entry| entry.shown.is_some());
        let comes_coarse = !has_any
            && !comes_at_once
            && needs_coarse_copy(&source.volume)
            && self.stand_in(source).is_none();
        comes_coarse.then(|| coarse_factor(&source.volume))
    }

    /// Gives a scene the copy that stands in.
    pub(super) fn lend(
        &mut self,
        source: &Source,
        key: GridKey,
        recording: &mut Recording,
    ) -> Option<SceneCopy> {
        let id = self.stand_in(source)?.id;
        let lending = self.entries.iter().position(|entry| entry.id == id)?;
        let SceneCopy { bricks: lender, ranges } = self.look_at(lending, key, recording)?;
        let index = self.index(source)?;
        Some(SceneCopy { bricks: self.entries[index].borrow(lender), ranges })
    }

    /// Whether a volume is there as its filter reads it, and also as no scene reads it any more.
    pub(super) fn is_left_over(&self, source: &Source) -> bool {
        self.other(source).is_some_and(|other| !other.is_in_use())
    }

    /// Gives up copies that no scene wants of volumes that scenes have as other filters read them.
    pub(super) fn drop_left_over(&mut self, recording: &mut Recording) {
        let is_wanted = |entry: &Entry| entry.asked == self.clock || entry.is_in_use();
        let takes_place = |entry: &Entry, other: &Entry| {
            entry.source.is_of_same(&other.source)
                && entry.id != other.id
                && is_wanted(entry)
                && entry.shown.is_some()
                && entry.arriving.is_empty()
        };
        let is_left_over =
            |other: &Entry| !is_wanted(other) && self.entries.iter().any(|entry| takes_place(entry, other));
        let gone: Vec<ResourceId> =
            self.entries.iter().filter(|entry| is_left_over(entry)).map(|entry| entry.id).collect();
        for id in gone {
            self.give_up(id, recording);
        }
    }
}

impl Entry {
    fn factor(&self) -> Option<u32> {
        self.shown.as_ref().map(|shown| shown.bricks.factor)
    }

    /// Another entry's copy in the name of this one: who holds it wants this one.
    fn borrow(&mut self, lender: Arc<Bricks>) -> Arc<Bricks> {
        let is_of =
            |bricks: &Arc<Bricks>| bricks.lender.as_ref().is_some_and(|before| Arc::ptr_eq(before, &lender));
        if let Some(known) = self.borrowed.upgrade().filter(is_of) {
            return known;
        }
        let Bricks { factor, grid, .. } = *lender;
        let pages = lender.pages.clone();
        let is_lost = AtomicBool::new(false);
        let borrowed =
            Arc::new(Bricks { source: self.id, factor, grid, pages, lender: Some(lender), is_lost });
        self.borrowed = Arc::downgrade(&borrowed);
        borrowed
    }
}
