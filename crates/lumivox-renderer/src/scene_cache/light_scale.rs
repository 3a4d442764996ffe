//! Light that changes by a factor alone: a film of it is the same film, times that factor.
//!
//! A lamp that flickers changes the scene in every frame, and films that start over in every frame stay as coarse as they
//! can be. Light is linear: where all that shines has become so many times as bright, what was traced is shown so many times
//! as bright, and goes on. Where one of several lights changes, films start over.

use lumivox_core::{Environment, EnvironmentSource, Light};
use lumivox_shaders::layout;

use super::{SceneCache, lights};
use crate::recording::Recording;

/// The same colour but for rounding.
const TOLERANCE: f64 = 1e-5;

impl SceneCache {
    /// Has light that changes by a factor alone change no [version](Self::version): live views show their films as many times
    /// as bright. For a cache that is shown by those alone, and not by a [`View`](crate::View).
    pub fn follow_light(&mut self) {
        self.follows_light = true;
    }

    /// What a film of this is to be multiplied by.
    pub(crate) fn light_scale(&self) -> f64 {
        self.light_scale
    }

    /// Brings lights and environment up to date; returns whether films have to start over.
    pub(super) fn update_light(
        &mut self,
        environment: &Environment,
        lights: &[Light],
        recording: &mut Recording,
    ) -> bool {
        let lights = lights::twins(lights, self.origin);
        self.light_scale = 1.0;
        if self.follows_light
            && self.lights.buffer.is_some()
            && self.environment.holds(&environment.source)
            && self.environment.rotation == environment.rotation
            && let Some(factor) =
                common_factor(&self.lights.list, &lights, self.environment.strength, environment)
        {
            self.light_scale = factor;
            return false;
        }
        let environment_changed = self.environment.update(environment, &mut self.unprepared, recording);
        self.lights.update("lights", lights, recording) | environment_changed
    }
}

/// How many times as bright all that shines has become, if it differs in nothing else.
fn common_factor(
    before: &[layout::Light],
    now: &[layout::Light],
    strength: f64,
    environment: &Environment,
) -> Option<f64> {
    if before.len() != now.len() {
        return None;
    }
    let colorless = |light: &layout::Light| layout::Light { color: [0.0; 3], ..*light };
    if before.iter().zip(now).any(|(a, b)| colorless(a) != colorless(b)) {
        return None;
    }
    let channels = before.iter().zip(now).flat_map(|(a, b)| a.color.into_iter().zip(b.color));
    let mut pairs: Vec<[f64; 2]> = channels.map(|(a, b)| [a, b].map(f64::from)).collect();
    if environment.source != EnvironmentSource::Uniform([0.0; 3]) {
        pairs.push([strength, environment.strength]);
    }
    let brightest = pairs.iter().copied().max_by(|a, b| a[0].total_cmp(&b[0]))?;
    let factor = brightest[1] / brightest[0];
    let is_same = |[a, b]: &[f64; 2]| (a * factor - b).abs() <= TOLERANCE * (a * factor).max(*b);
    (factor.is_finite() && factor > 0.0 && pairs.iter().all(is_same)).then_some(factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_light_that_changes_by_one_factor_has_one() {
        let light = |color: [f32; 3], kind| layout::Light { color, kind, ..Default::default() };
        let dark = Environment { source: EnvironmentSource::Uniform([0.0; 3]), ..Environment::default() };
        let sky =
            |strength| Environment { source: EnvironmentSource::Uniform([0.5; 3]), strength, ..dark.clone() };
        let before = [light([1.0, 0.5, 0.25], 1), light([2.0, 0.0, 4.0], 2)];
        let twice = [light([2.0, 1.0, 0.5], 1), light([4.0, 0.0, 8.0], 2)];
        assert_eq!(common_factor(&before, &twice, 1.0, &dark), Some(2.0));
        assert_eq!(common_factor(&before, &before, 1.0, &dark), Some(1.0));
        assert_eq!(common_factor(&before, &twice, 1.0, &sky(2.0)), Some(2.0));
        assert_eq!(common_factor(&[], &[], 0.5, &sky(0.25)), Some(0.5));
        // A sky that stays, one of two lamps, a colour, another place, another lamp.
        assert_eq!(common_factor(&before, &twice, 1.0, &sky(1.0)), None);
        assert_eq!(common_factor(&before, &[twice[0], before[1]], 1.0, &dark), None);
        assert_eq!(common_factor(&before[..1], &[light([2.0, 1.0, 0.6], 1)], 1.0, &dark), None);
        assert_eq!(common_factor(&before[..1], &[light([2.0, 1.0, 0.5], 0)], 1.0, &dark), None);
        assert_eq!(common_factor(&before, &before[..1], 1.0, &dark), None);
        // There is nothing to scale.
        assert_eq!(common_factor(&[], &[], 1.0, &dark), None);
    }
}
