//! Light that is kept in volumes, as far as it is a stage's: who will want it, and views that have to do without.

use super::world::World;
use super::{Key, Refusal, Stage, StageError};
use crate::features::ViewKind;
use crate::recording::Recording;

impl<W: Key, V: Key> Stage<W, V> {
    /// Says how a world will be looked at, before the first view does: what that takes is prepared with it. What a view asks for
    /// that was not expected, it gets later.
    pub fn expect(&mut self, world: W, view: ViewKind) {
        if let ViewKind::Live { guides, kept_light } = view {
            let place = self.worlds.entry(world).or_insert_with(|| World::new(&self.store));
            place.has_guides |= guides;
            place.wants_light |= kept_light;
        }
    }

    /// The device has refused a view's recording. One that keeps light can perhaps be shown without; else it is an error.
    pub(super) fn view_refused(&mut self, view: V, refusal: Refusal) -> Result<(), StageError> {
        // What it made is gone: it makes everything anew in the next frame.
        let gone = self.eyes.remove(&view);
        let kept_light = gone.as_ref().is_some_and(|eye| eye.live.status().light_bytes > 0);
        if let Some(eye) = gone {
            let mut frees = Recording::new();
            eye.free(&mut frees);
            self.left_over.extend(frees.steps);
        }
        if !kept_light {
            return Err(refusal.into());
        }
        match refusal {
            Refusal::Memory(_) => self.store.refuse_light(),
            Refusal::Other(_) => self.refuses_light = true,
        }
        self.drop_light();
        Ok(())
    }

    /// No view goes on with the light that was kept for it.
    pub(super) fn drop_light(&mut self) {
        let mut frees = Recording::new();
        self.eyes.values_mut().for_each(|eye| eye.live.drop_light(&mut frees));
        self.left_over.extend(frees.steps);
    }
}
