//! What of its scan a node shows: the patient, one organ, or all that was scanned.

use std::sync::Arc;

use godot::classes::Engine;
use godot::prelude::*;
use lumivox_core::{Organ, Preset, Volume};

use super::LumivoxVolume3D;
use crate::resources::{Derived, Part};
use crate::shared;

/// A part of a scan that is shown in its place.
pub struct ShownPart {
    part: Part,
    /// The scan that it is of.
    of: Arc<Volume>,
    derived: Derived,
    /// Whether a game was told that there is no such part.
    is_told: bool,
}

/// What is seen.
pub struct Shown {
    pub volume: Arc<Volume>,
    /// Whether something else will be, once another thread has computed it.
    pub is_coming: bool,
}

impl LumivoxVolume3D {
    /// What is to be seen in place of the patient.
    fn wanted_part(&self) -> Option<Part> {
        if self.keep_everything {
            return Some(Part::Everything);
        }
        let preset = Preset::from_name(&self.chosen_preset.to_string()).ok()?;
        preset.organ().map(Part::Organ)
    }

    /// What is seen of the scan; `None` without one.
    pub(super) fn shown(&self) -> Option<Shown> {
        let resource = self.volume.as_ref()?.bind();
        let scan = resource.volume()?.clone();
        let mut held = self.part.borrow_mut();
        let wanted = self.wanted_part();
        if held.as_ref().is_some_and(|held| Some(held.part) != wanted || !Arc::ptr_eq(&held.of, &scan)) {
            *held = None;
        }
        let Some(part) = wanted else { return Some(Shown { volume: scan, is_coming: false }) };
        if held.is_none() {
            let new = |derived| ShownPart { part, of: scan.clone(), derived, is_told: false };
            *held = resource.part(part).map(new);
        }
        let computed = held.as_ref().map(|held| held.derived.get());
        let is_coming = matches!(computed, Some(None));
        Some(Shown { volume: computed.flatten().flatten().unwrap_or(scan), is_coming })
    }

    /// Whether something was still computed when it was last drawn.
    pub fn is_waiting(&self) -> bool {
        self.is_waiting.get()
    }

    /// Has the engine draw until what is computed is there, and tells what became of it.
    pub(super) fn follow(&self, is_coming: bool) {
        if is_coming {
            // After this frame: what asks for another before it is drawn asks for nothing.
            shared::lock().wants_frame = true;
        } else if self.is_waiting.get() {
            if let Some(why) = self.part_warning().filter(|_| !Engine::singleton().is_editor_hint()) {
                let mut held = self.part.borrow_mut();
                let is_told = held.as_mut().map(|held| std::mem::replace(&mut held.is_told, true));
                if is_told == Some(false) {
                    godot_warn!("LumivoxVolume3D: {why}");
                }
            }
            // Not now: its contents are being looked at.
            self.to_gd().call_deferred("_contents_changed", &[]);
            self.to_gd().call_deferred("_tell_prepared", &[]);
        }
        self.is_waiting.set(is_coming);
    }

    /// Why what was computed is not what was asked for.
    pub(super) fn preparation_failure(&self) -> Option<String> {
        let has_no_depth = || self.peel_mm > 0.0 && self.has_scan() && matches!(self.peel(), (None, false));
        let no_skin = "No skin was found in the scan for sure: nothing is peeled off.";
        self.part_warning().or_else(|| has_no_depth().then(|| no_skin.to_owned()))
    }

    /// Why something else is seen than was asked for.
    pub(super) fn part_warning(&self) -> Option<String> {
        let held = self.part.borrow();
        let held = held.as_ref().filter(|held| matches!(held.derived.get(), Some(None)))?;
        let Part::Organ(organ) = held.part else { return None };
        let what = match organ {
            Organ::Airways => "airways",
            _ => "lungs with vessels",
        };
        let preset = &self.chosen_preset;
        Some(format!(
            "No {what} were found in the scan for sure: all of it is seen with the preset {preset}."
        ))
    }
}
