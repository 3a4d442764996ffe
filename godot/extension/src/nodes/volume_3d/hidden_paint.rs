//! Labels that are painted where the look shows nothing: no colour is seen there, and whoever painted them is told why.

use std::sync::Arc;

use godot::prelude::*;
use lumivox_core::{LabelValues, LabelVolume, Volume};

use super::LumivoxVolume3D;

/// The scan's values in its labels: they are taken once.
pub struct Compared {
    scan: Arc<Volume>,
    labels: Arc<LabelVolume>,
    values: LabelValues,
}

impl LumivoxVolume3D {
    /// That labels are painted, but the look hides them.
    pub(super) fn hidden_paint(&self) -> Option<String> {
        let labels = self.labels.as_ref()?.bind();
        // Most volumes have none, and nothing is to be compared.
        labels.painted().next()?;
        let (map, resource) = (labels.labels()?, self.volume.as_ref()?.bind());
        let scan = resource.volume()?;
        let medium = self.medium(resource.default_medium()?);
        let mut compared = self.compared.borrow_mut();
        let is_of = |old: &Compared| Arc::ptr_eq(&old.scan, scan) && Arc::ptr_eq(&old.labels, map);
        if !compared.as_ref().is_some_and(is_of) {
            let values = LabelValues::of(scan, map);
            *compared = Some(Compared { scan: scan.clone(), labels: map.clone(), values });
        }
        let values = &compared.as_ref()?.values;
        let hidden = labels.painted().filter(|(value, _, style)| !values.shows(*value, style, &medium, scan));
        let names: Vec<String> = hidden.map(|(_, name, _)| format!("'{name}'")).collect();
        let (are, them) = if names.len() == 1 { ("is", "it") } else { ("are", "them") };
        (!names.is_empty()).then(|| {
            format!(
                "{} {are} painted, but the look hides {them}: no colour is seen where the transfer function is clear. \
                 Choose a look that shows {them}, or give {them} a transfer function of their own.",
                names.join(", ")
            )
        })
    }

    /// Says so in a game, where nobody looks at the scene dock, when other labels are painted than before.
    pub(super) fn tell_hidden_paint(&self) {
        let painted =
            self.labels.as_ref().map(|labels| labels.bind().painted().map(|(value, ..)| value).collect());
        let painted = painted.unwrap_or_default();
        if self.painted.replace(painted) == *self.painted.borrow() {
            return;
        }
        if let Some(why) = self.hidden_paint() {
            godot_warn!("LumivoxVolume3D: {why}");
        }
    }
}
