//! Light that changes, and what becomes of films then.
//!
//! A lamp that flickers changes the scene in every frame, and films that start over in every frame stay as coarse as they
//! can be. Light is linear: where all that shines has become so many times as bright, what was traced is shown so many times
//! as bright, and goes on. Where something else about it has changed a little (one of several lamps flickers, the sun wanders, a
//! torch is carried by), live films go on, too, and start over once it rests. A film is then of the mean of the light that it
//! has seen. As far as today's differs from that, films keep a part of what they have, see [`LightPast`]; where it differs much,
//! they start over at once. A flicker about a mean costs little.

use std::f64::consts::{PI, TAU};

use lumivox_core::color::luminance;
use lumivox_core::glam::Vec3;
use lumivox_core::{Environment, EnvironmentSource, Light};
use lumivox_shaders::layout;

use super::environment::NewMap;
use super::hierarchy::Bounds;
use super::{SceneCache, lights};
use crate::recording::Recording;

/// The same colour but for rounding.
const TOLERANCE: f64 = 1e-5;

/// The part of all light by which today's may differ from a film's for it to forget no more than that asks.
const LITTLE: f64 = 0.1;

/// The part from which on films start over.
const MUCH: f64 = 0.4;

/// How many times what lies between films forget.
const FORGETS: f64 = 2.0;

/// A shadow moves with its light: the angle, in radians, by which it is another altogether.
const OTHER_ANGLE: f64 = 0.3;

/// Changes that films remember at most: what flickers is to be seen to do so.
const MEMORY: f64 = 32.0;

/// What films have been through since the light was another, in sums: a film knows where it was, and takes the difference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LightPast {
    /// Changes in which films go on.
    pub changes: u32,
    /// Of the parts that they keep, the logarithms.
    log_kept: f64,
    /// Of how many times as bright their light has become besides, the logarithms.
    log_scale: f64,
}

impl LightPast {
    /// Another change, after which films keep a part that is so many times as bright.
    fn add(&mut self, kept: f64, scale: f64) {
        self.changes = self.changes.wrapping_add(1);
        self.log_kept += kept.ln();
        self.rescale(scale);
    }

    /// Light that has nothing to do with what was before.
    fn begin_anew(&mut self, scale: f64) {
        self.log_kept += f64::EPSILON.ln();
        self.rescale(scale);
    }

    /// So many times as bright. Light that is gone comes back at some time.
    fn rescale(&mut self, scale: f64) {
        self.log_scale += scale.clamp(1e-12, 1e12).ln();
    }

    /// What a film from `before` keeps, and how many times as bright that has become.
    pub fn since(&self, before: &Self) -> [f64; 2] {
        [self.log_kept - before.log_kept, self.log_scale - before.log_scale].map(f64::exp)
    }
}

/// The part that films keep whose light differs from today's by such a part of all; `None` where they start over.
pub(crate) fn kept_after(difference: f64) -> Option<f64> {
    (difference <= MUCH).then(|| (1.0 - FORGETS * (difference - LITTLE)).min(1.0 - 1.0 / MEMORY))
}

/// How much a colour has changed, 0 to 1, by the channel in which it has most.
pub(crate) fn change_of_color(before: [f32; 3], now: [f32; 3]) -> f64 {
    let change = |(a, b): (f32, f32)| if a == b { 0.0 } else { f64::from((a - b).abs() / a.max(b)) };
    before.into_iter().zip(now).map(change).fold(0.0, f64::max)
}

/// The light of films, in the mean.
#[derive(Clone, Debug, Default)]
pub(super) struct MeanLight {
    lights: Vec<layout::Light>,
    strength: f64,
    rotation: f64,
    /// So many changes it is the mean of; of films that rested, as many as they may remember.
    count: f64,
}

impl MeanLight {
    /// Of films that are empty.
    fn new(lights: &[layout::Light], environment: &Environment) -> Self {
        let Environment { strength, rotation, .. } = *environment;
        Self { lights: lights.to_vec(), strength, rotation, count: MEMORY }
    }

    /// The part of all light, about, in which today's differs where volumes are.
    fn difference(
        &self,
        lights: &[layout::Light],
        environment: &Environment,
        radiance: f64,
        around: &Bounds,
    ) -> f64 {
        let sky = |strength: f64| PI * strength * radiance;
        let (before, now) = (sky(self.strength), sky(environment.strength));
        let turned = (turn(self.rotation, environment.rotation) / OTHER_ANGLE).min(1.0);
        let mut differs = (before - now).abs().max(turned * before.max(now));
        let mut all = before.max(now);
        let mut add = |brighter: f64, difference: f64| {
            all += brighter;
            differs += difference;
        };
        let bright = |light: &layout::Light| brightness(light, around);
        if self.lights.len() == lights.len() {
            for (a, b) in self.lights.iter().zip(lights) {
                let brighter = bright(a).max(bright(b));
                add(brighter, brighter * change_of_light(a, b, around));
            }
        } else {
            // What came or went, and what stayed as it was.
            let is_in = |light: &layout::Light, list: &[layout::Light]| list.contains(light);
            for light in &self.lights {
                add(bright(light), if is_in(light, lights) { 0.0 } else { bright(light) });
            }
            for light in lights.iter().filter(|light| !is_in(light, &self.lights)) {
                add(bright(light), bright(light));
            }
        }
        if all > 0.0 { differs / all } else { 0.0 }
    }

    /// So many times as bright.
    fn scaled(&self, scale: f64) -> Self {
        let brighter = |light: &layout::Light| layout::Light {
            color: light.color.map(|c| (f64::from(c) * scale) as f32),
            ..*light
        };
        Self { lights: self.lights.iter().map(brighter).collect(), strength: self.strength * scale, ..*self }
    }

    /// Films keep a part, and see other light from now on.
    fn follow(&mut self, lights: &[layout::Light], environment: &Environment, kept: f64) {
        if self.lights.len() != lights.len() {
            *self = Self::new(lights, environment);
            return;
        }
        self.count = self.count * kept + 1.0;
        let share = 1.0 / self.count;
        let mix = |a: f64, b: f64| a + share * (b - a);
        let mix_all = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|i| mix(a[i].into(), b[i].into()) as f32);
        self.strength = mix(self.strength, environment.strength);
        self.rotation += share * signed_turn(self.rotation, environment.rotation);
        for (mean, now) in self.lights.iter_mut().zip(lights) {
            *mean = layout::Light {
                color: mix_all(mean.color, now.color),
                position: mix_all(mean.position, now.position),
                axis: mix_all(mean.axis, now.axis),
                ..*now
            };
        }
    }
}

impl SceneCache {
    /// Has light that changes by a factor alone, or a little, change no [version](Self::version): live views show their films
    /// as many times as bright, or keep a part of them. For a cache that is shown by those alone, and not by a
    /// [`View`](crate::View).
    pub fn follow_light(&mut self) {
        self.follows_light = true;
    }

    /// What a film of this is to be multiplied by.
    pub(crate) fn light_scale(&self) -> f64 {
        self.light_scale
    }

    /// What films have been through.
    pub(crate) fn light_past(&self) -> LightPast {
        self.light_past
    }

    /// Brings lights and environment up to date; returns whether films have to start over.
    pub(super) fn update_light(
        &mut self,
        environment: &Environment,
        new_map: Option<NewMap>,
        lights: &[Light],
        recording: &mut Recording,
    ) -> bool {
        let lights = lights::twins(lights, self.origin);
        let scale = std::mem::replace(&mut self.light_scale, 1.0);
        let mut kept = None;
        if self.follows_light && self.environment.holds(&environment.source) {
            if self.environment.rotation == environment.rotation
                && let Some(factor) =
                    common_factor(&self.lights.list, &lights, self.environment.strength, environment)
            {
                self.light_scale = factor;
                return false;
            }
            if scale != 1.0 {
                self.mean_light = self.mean_light.scaled(scale);
            }
            let radiance = self.environment.mean_luminance;
            kept = kept_after(self.mean_light.difference(&lights, environment, radiance, &self.around));
        }
        let environment_changed = self.environment.update(environment, new_map, recording);
        let changed = self.lights.update(lights.into(), recording) | environment_changed;
        match kept {
            Some(kept) if changed => {
                self.light_past.add(kept, scale);
                self.mean_light.follow(&self.lights.list, environment, kept);
                false
            }
            _ => {
                if changed {
                    self.light_past.begin_anew(scale);
                    self.mean_light = MeanLight::new(&self.lights.list, environment);
                }
                changed
            }
        }
    }
}

/// The signed angle from a rotation to another, in radians.
fn signed_turn(before: f64, now: f64) -> f64 {
    let angle = (now - before).rem_euclid(TAU);
    if angle > PI { angle - TAU } else { angle }
}

fn turn(before: f64, now: f64) -> f64 {
    signed_turn(before, now).abs()
}

/// About what a light brings to volumes where it brings most, unshadowed.
fn brightness(light: &layout::Light, around: &Bounds) -> f64 {
    let all = luminance(light.color.map(f64::from));
    if light.kind == lumivox_shaders::constants::LIGHT_DIRECTIONAL {
        return all;
    }
    let distance = distance(light, around);
    let nearness = distance * f64::from(light.inverse_range);
    if light.decay < 0.0 {
        return all * (5.0 - 5.0 * nearness).clamp(0.0, 1.0) / (1.0 + 25.0 * nearness * nearness);
    }
    all * (1.0 - nearness.powi(4)).max(0.0).powi(2) * distance.powf(-f64::from(light.decay))
}

/// Of a lamp from the nearest of what it lights, or from amid.
fn distance(light: &layout::Light, around: &Bounds) -> f64 {
    around.distance(Vec3::from_array(light.position).as_dvec3()).max(around.size() / 4.0).max(1e-6)
}

/// How much a light has changed, 0 for not at all to 1 for another.
fn change_of_light(before: &layout::Light, now: &layout::Light, around: &Bounds) -> f64 {
    let elsewhere = |light: &layout::Light| layout::Light {
        color: [0.0; 3],
        position: [0.0; 3],
        axis: [0.0; 3],
        ..*light
    };
    if elsewhere(before) != elsewhere(now) {
        return 1.0;
    }
    let vectors =
        |of: fn(&layout::Light) -> [f32; 3]| [before, now].map(|l| Vec3::from_array(of(l)).as_dvec3());
    let [a, b] = vectors(|light| light.axis);
    let turned = a.cross(b).length().atan2(a.dot(b));
    let [a, b] = vectors(|light| light.position);
    let angle = turned.max((b - a).length() / distance(before, around).min(distance(now, around)));
    // By luminance: a channel alone that hardly shines is hardly seen.
    let differs: f64 = luminance([0, 1, 2].map(|i| f64::from((before.color[i] - now.color[i]).abs())));
    let brighter = luminance([0, 1, 2].map(|i| f64::from(before.color[i].max(now.color[i]))));
    let of_color = if brighter > 0.0 { differs / brighter } else { 0.0 };
    of_color.max(angle / OTHER_ANGLE).min(1.0)
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
    const SKY: Environment =
        Environment { source: EnvironmentSource::Uniform([1.0; 3]), rotation: 0.0, strength: 1.0 };

    fn lamp() -> layout::Light {
        layout::Light {
            color: [1.0, 0.5, 0.25],
            position: [0.0, 0.0, 3.0],
            kind: 1,
            decay: 2.0,
            ..Default::default()
        }
    }

    fn sun() -> layout::Light {
        layout::Light { color: [2.0; 3], axis: [0.0, 0.0, 1.0], kind: 0, ..Default::default() }
    }

    /// In a cube of 2 m, under a sky of so much radiance.
    fn differs(before: &[layout::Light], now: &[layout::Light], radiance: f64) -> f64 {
        MeanLight::new(before, &SKY).difference(now, &SKY, radiance, &Bounds::cube(1.0))
    }

    #[test]
    fn a_light_counts_by_its_share() {
        let (lamp, sun) = (lamp(), sun());
        assert_eq!(differs(&[lamp, sun], &[lamp, sun], 1.0), 0.0);
        let dimmed = layout::Light { color: lamp.color.map(|c| 0.9 * c), ..lamp };
        assert!((differs(&[lamp], &[dimmed], 0.0) - 0.1).abs() < 1e-6);
        // The lamp, 2 m away, brings an eighth of a sun of 1.
        let share = luminance([1.0, 0.5, 0.25]) / 4.0;
        assert!((differs(&[lamp, sun], &[dimmed, sun], 0.0) - 0.1 * share / (share + 2.0)).abs() < 1e-6);
        assert!((differs(&[lamp], &[dimmed], 1.0) - 0.1 * share / (share + PI)).abs() < 1e-6);
        // A channel that hardly shines hardly counts.
        let bluish = layout::Light { color: [1.0, 0.5, 0.15], ..lamp };
        assert!(differs(&[lamp], &[bluish], 0.0) < 0.02);
        // A spark comes; the only lamp goes.
        let spark = layout::Light { color: [0.05; 3], ..lamp };
        assert!((differs(&[sun], &[sun, spark], 0.0) - 0.0125 / 2.0125).abs() < 1e-6);
        assert_eq!(differs(&[lamp], &[], 0.0), 1.0);
        assert_eq!(differs(&[lamp], &[layout::Light { size: 0.1, ..lamp }], 0.0), 1.0);
    }

    #[test]
    fn shadows_move_with_their_lights() {
        let (lamp, sun) = (lamp(), sun());
        // A third of a degree, and 3 cm at 2 m.
        let wandered = layout::Light { axis: [0.0, 0.006_f64.sin() as f32, 0.006_f64.cos() as f32], ..sun };
        assert!((differs(&[sun], &[wandered], 0.0) - 0.02).abs() < 1e-4);
        let carried = layout::Light { position: [0.0, 0.03, 3.0], ..lamp };
        assert!((differs(&[lamp], &[carried], 0.0) - 0.05).abs() < 1e-3);
        assert_eq!(differs(&[lamp], &[layout::Light { position: [0.0, 3.0, 0.0], ..lamp }], 0.0), 1.0);
        assert!((turn(0.1, 0.1 + TAU) < 1e-9) && (turn(6.0, 0.1) - 0.383).abs() < 1e-3);
    }

    #[test]
    fn a_flicker_about_a_mean_is_kept_and_a_change_is_followed() {
        let at = |factor: f32| [layout::Light { color: lamp().color.map(|c| c * factor), ..lamp() }];
        let mut mean = MeanLight::new(&at(1.0), &SKY);
        let next = |mean: &mut MeanLight, factor| {
            let difference = mean.difference(&at(factor), &SKY, 0.0, &Bounds::cube(1.0));
            let kept = kept_after(difference);
            mean.follow(&at(factor), &SKY, kept.unwrap_or(0.0));
            kept
        };
        // By a fifth to either side, which is a third from one extreme to the other.
        let flicker: Vec<_> = (0..64).map(|i| next(&mut mean, [1.2, 0.8, 0.9, 1.1][i % 4])).collect();
        assert!(flicker[8..].iter().all(|kept| kept.is_some_and(|kept| kept > 0.6)), "{flicker:?}");
        assert!(flicker[8..].iter().map(|kept| kept.unwrap()).sum::<f64>() > 0.75 * 56.0, "{flicker:?}");
        // To twice as much: the mean is never far behind.
        for i in 0..60 {
            let factor = 1.0 + i as f32 / 60.0;
            assert!(next(&mut mean, factor).is_some());
            let behind = mean.difference(&at(factor), &SKY, 0.0, &Bounds::cube(1.0));
            assert!(behind < 0.2, "{behind} behind at {factor}");
        }
        assert_eq!(next(&mut mean, 0.2), None, "it goes out");
    }

    #[test]
    fn what_is_forgotten_adds_up_whoever_looks_when() {
        let mut past = LightPast::default();
        past.add(0.8, 2.0);
        let before = past;
        past.add(0.9, 1.0);
        past.add(0.9, 3.0);
        let [kept, scale] = past.since(&before);
        assert!((kept - 0.81).abs() < 1e-9 && (scale - 3.0).abs() < 1e-9);
    }
}
