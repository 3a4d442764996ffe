//! What a live view does with its film while the scene's light changes a little from frame to frame.
//!
//! It keeps a part of the film, the smaller the more light differs from what the film has seen, and traces on: the film is then a
//! mean of the last moments. Once light rests, the film makes way for one of that light
//! alone, behind which it is seen until that is as good: a finished picture is never of two lights.

use crate::scene_cache::{LightPast, SceneCache, change_of_color, kept_after};

/// Ambient light that differs less is the same: it is rounded in two units.
const TOLERANCE: f64 = 1e-6;

/// Frames without a change after which light rests: what flickers may pause as long.
const REST: u32 = 30;

/// The least that a film keeps: one of which less is left begins anew.
pub(super) const LEAST_KEPT: f64 = 0.2;

/// The light that falls on a view's volumes in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct FrameLight {
    /// Of lamps and surroundings.
    pub past: LightPast,
    /// From everywhere besides, as films have it.
    pub ambient: [f32; 3],
}

impl FrameLight {
    /// Of a scene, and ambient light besides it.
    pub fn of(cache: &SceneCache, ambient: [f64; 3]) -> Self {
        // What is shown of it is scaled with the scene's light.
        let scaled = |c: f64| (c.max(0.0) / cache.light_scale()) as f32;
        let ambient = ambient.map(|c| if c.is_finite() { scaled(c) } else { 0.0 });
        Self { past: cache.light_past(), ambient }
    }

    /// What is kept of what was seen in the light before, and how many times as bright that has become.
    pub fn since(&self, before: &Self) -> [f64; 2] {
        let [kept, scale] = self.past.since(&before.past);
        let ambient = before.ambient.map(|c| (f64::from(c) * scale) as f32);
        let of_ambient = match change_of_color(ambient, self.ambient) {
            change if change <= TOLERANCE => 1.0,
            change => kept_after(change).unwrap_or(0.0),
        };
        [kept * of_ambient, scale]
    }
}

/// What becomes of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Change {
    None,
    /// It keeps a part, so many times as bright.
    Little([f64; 2]),
    /// Another light: it starts over.
    Much,
}

/// The light of a view's film.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LightOfFilm {
    light: FrameLight,
    /// How often it changed since the film was empty.
    changes: u32,
    /// Frames since then.
    rest: u32,
}

impl LightOfFilm {
    /// Of an empty film.
    pub fn new(light: FrameLight) -> Self {
        Self { light, changes: 0, rest: 0 }
    }

    /// The light of the next frame.
    pub fn follow(&mut self, now: FrameLight) -> Change {
        let before = std::mem::replace(&mut self.light, now);
        if before == now {
            self.rest = self.rest.saturating_add(1);
            return Change::None;
        }
        let [kept, scale] = now.since(&before);
        if kept < LEAST_KEPT {
            return Change::Much;
        }
        self.changes += 1;
        self.rest = 0;
        Change::Little([kept, scale])
    }

    /// Whether the film holds light that is no longer there.
    pub fn is_mixed(&self) -> bool {
        self.changes > 0
    }

    /// Whether light has rested so long that it will, or the film `is_done` and shows nothing new.
    pub fn rests(&self, is_done: bool) -> bool {
        self.is_mixed() && (self.rest >= REST || self.rest > 0 && is_done)
    }

    /// The seed of what is traced: samples that a pixel has forgotten are not drawn again.
    pub fn seed(&self, seed: u32) -> u32 {
        seed ^ self.changes.wrapping_mul(0x9e37_79b9)
    }
}
