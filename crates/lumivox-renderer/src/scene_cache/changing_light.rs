//! Light that changes, and what becomes of films then.
//!
//! A lamp that flickers changes the scene in every frame, and films that start over in every frame stay as coarse as they
//! can be. Light is linear: where all that shines has become so many times as bright, what was traced is shown so many times
//! as bright, and goes on. Where something else about it has changed a little (one of several lamps flickers, the sun wanders, a
//! torch is carried by), live films keep a part of what they have, see [`LightPast`], and start over once it rests. Where it
//! has changed much, they start over at once.

use lumivox_core::glam::{DVec3, Vec3};
use lumivox_core::{Environment, EnvironmentSource, Light};
use lumivox_shaders::layout;

use super::hierarchy::Bounds;
use super::{SceneCache, lights};
use crate::recording::Recording;

/// The same colour but for rounding.
const TOLERANCE: f64 = 1e-5;

/// The [change](change_of) from which on films start over.
const MUCH: f64 = 0.3;

/// How many times the change of the light films forget of what they have.
const FORGETS: f64 = 2.0;

/// A shadow moves with its light: the angle, in radians, by which it is another altogether.
const OTHER_ANGLE: f64 = 0.3;

/// What films have been through since the light was another, in sums: a film knows where it was, and takes the difference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LightPast {
    /// Changes in which films keep a part of what they have.
    pub changes: u32,
    /// Of the parts that they keep, the logarithms.
    log_kept: f64,
    /// Of how many times as bright their light has become besides, the logarithms.
    log_scale: f64,
}

impl LightPast {
    /// Another change, of so much.
    fn add(&mut self, change: f64, scale: f64) {
        self.changes = self.changes.wrapping_add(1);
        self.log_kept += kept_after(change).ln();
        self.log_scale += scale.ln();
    }

    /// What a film from `before` keeps, and how many times as bright that has become.
    pub fn since(&self, before: &Self) -> [f64; 2] {
        [self.log_kept - before.log_kept, self.log_scale - before.log_scale].map(f64::exp)
    }
}

/// The part that films keep where light changes by so much.
pub(crate) fn kept_after(change: f64) -> f64 {
    1.0 - FORGETS * change.min(MUCH)
}

/// How much a colour has changed, 0 to 1, by the channel in which it has most.
pub(crate) fn change_of_color(before: [f32; 3], now: [f32; 3]) -> f64 {
    let change = |(a, b): (f32, f32)| if a == b { 0.0 } else { f64::from((a - b).abs() / a.max(b)) };
    before.into_iter().zip(now).map(change).fold(0.0, f64::max)
}

/// Whether films start over after such a change.
pub(crate) fn is_much(change: f64) -> bool {
    change > MUCH
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
        lights: &[Light],
        recording: &mut Recording,
    ) -> bool {
        let lights = lights::twins(lights, self.origin);
        let shown_scale = std::mem::replace(&mut self.light_scale, 1.0);
        let mut little = None;
        if self.follows_light && self.lights.buffer.is_some() && self.environment.holds(&environment.source) {
            let turned = turn(self.environment.rotation, environment.rotation);
            if turned == 0.0
                && let Some(factor) =
                    common_factor(&self.lights.list, &lights, self.environment.strength, environment)
            {
                self.light_scale = factor;
                return false;
            }
            let as_shown: Vec<layout::Light> =
                self.lights.list.iter().map(|l| scaled(l, shown_scale)).collect();
            let strengths = [self.environment.strength * shown_scale, environment.strength];
            let change = change_of(&as_shown, &lights, &self.around)
                .max(change_of_color([strengths[0] as f32; 3], [strengths[1] as f32; 3]))
                .max(turned / OTHER_ANGLE);
            little = Some(change).filter(|&change| !is_much(change));
        }
        let environment_changed = self.environment.update(environment, &mut self.unprepared, recording);
        let changed = self.lights.update("lights", lights, recording) | environment_changed;
        match little {
            Some(change) if changed => self.light_past.add(change, shown_scale),
            _ => return changed,
        }
        false
    }
}

/// The angle between two rotations in radians.
fn turn(before: f64, now: f64) -> f64 {
    let angle = (now - before).rem_euclid(std::f64::consts::TAU);
    angle.min(std::f64::consts::TAU - angle)
}

fn scaled(light: &layout::Light, scale: f64) -> layout::Light {
    layout::Light { color: light.color.map(|c| (f64::from(c) * scale) as f32), ..*light }
}

/// How much the light of lamps and suns has changed where volumes are, about: 0 for not at all, 1 and more for other light.
fn change_of(before: &[layout::Light], now: &[layout::Light], around: &Bounds) -> f64 {
    if before.len() != now.len() {
        return f64::INFINITY;
    }
    before.iter().zip(now).map(|(a, b)| change_of_light(a, b, around)).fold(0.0, f64::max)
}

fn change_of_light(before: &layout::Light, now: &layout::Light, around: &Bounds) -> f64 {
    let elsewhere = |light: &layout::Light| layout::Light {
        color: [0.0; 3],
        position: [0.0; 3],
        axis: [0.0; 3],
        ..*light
    };
    if elsewhere(before) != elsewhere(now) {
        return f64::INFINITY;
    }
    let [a, b] = [before, now].map(|light| Vec3::from_array(light.axis).as_dvec3());
    let turned = a.cross(b).length().atan2(a.dot(b));
    let [a, b] = [before, now].map(|light| Vec3::from_array(light.position).as_dvec3());
    let moved: DVec3 = b - a;
    // Seen from the nearest of what it lights, or from amid.
    let distance = around.distance(a).min(around.distance(b)).max(around.size() / 4.0);
    let angle = turned.max(moved.length() / distance);
    change_of_color(before.color, now.color).max(if angle == 0.0 { 0.0 } else { angle / OTHER_ANGLE })
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
    #[test]
    fn a_little_is_what_shadows_and_colours_hardly_show() {
        let lamp = layout::Light {
            color: [1.0, 0.5, 0.25],
            position: [0.0, 0.0, 3.0],
            kind: 1,
            ..Default::default()
        };
        let sun = layout::Light { color: [2.0; 3], axis: [0.0, 0.0, 1.0], kind: 0, ..Default::default() };
        let around = Bounds::around([Bounds::cube(1.0)].into_iter());
        let change = |lamp_now: layout::Light, sun_now: layout::Light| {
            change_of(&[lamp, sun], &[lamp_now, sun_now], &around)
        };
        assert_eq!(change(lamp, sun), 0.0);
        let dimmed = layout::Light { color: [0.9, 0.5, 0.25], ..lamp };
        assert!((change(dimmed, sun) - 0.1).abs() < 1e-6);
        // A third of a degree, and 3 cm at 2 m.
        let wandered = layout::Light { axis: [0.0, 0.006_f64.sin() as f32, 0.006_f64.cos() as f32], ..sun };
        assert!((change(lamp, wandered) - 0.02).abs() < 1e-4);
        let carried = layout::Light { position: [0.0, 0.03, 3.0], ..lamp };
        assert!((change(carried, sun) - 0.05).abs() < 1e-3, "{}", change(carried, sun));
        // Another light, one more, one that is out.
        assert!(is_much(change(layout::Light { size: 0.1, ..lamp }, sun)));
        assert!(is_much(change(layout::Light { position: [0.0, 3.0, 0.0], ..lamp }, sun)));
        assert!(is_much(change_of(&[lamp], &[lamp, sun], &around)));
        assert!(is_much(change(scaled(&lamp, 0.5), sun)));
        // What is forgotten adds up, whoever looks when.
        let mut past = LightPast::default();
        past.add(0.1, 2.0);
        let before = past;
        past.add(0.05, 1.0);
        past.add(0.05, 3.0);
        let [kept, scale] = past.since(&before);
        assert!((kept - 0.81).abs() < 1e-9 && (scale - 3.0).abs() < 1e-9);
        assert!((turn(0.1, 0.1 + std::f64::consts::TAU) < 1e-9) && (turn(6.0, 0.1) - 0.383).abs() < 1e-3);
    }
}
