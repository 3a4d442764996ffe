//! Scans as they are shown, with their looks, at their places.

use std::{collections::BTreeSet, sync::Arc};

use lumivox_core::{
    Environment, LabelVolume, Light, Medium, Modality, Peel, Scene, Volume, VolumeInstance,
    document::{self, Entry, Look, Style},
    glam::{DAffine3, DVec3},
    medium::most_density_scale,
    presets,
    words::{lengths, number},
    world_from_patient,
};

use crate::{Audience, Note, OpenError, Remedy, labels::labelling, show::Shown};

/// What becomes a volume of a scene, as it is shown.
#[derive(Clone, Debug)]
pub struct Part {
    /// Its voxels.
    pub volume: Arc<Volume>,
    /// Its labels.
    pub labels: Option<Arc<LabelVolume>>,
    /// What is not seen of it though it is there.
    pub peel: Option<Peel>,
}

impl Part {
    /// A scan as it is shown, with the labels that were found in it.
    pub fn new(shown: Shown) -> Self {
        Self { volume: Arc::new(shown.volume), labels: shown.found.map(Arc::new), peel: shown.peel }
    }
}

/// The scene of a document's entries. Those without a place share the first one's patient space, its centre at the origin.
///
/// # Errors
/// [`OpenError`] for styles of labels that there are not.
pub fn place(
    entries: &[Entry],
    parts: Vec<Part>,
    lights: Vec<Light>,
    environment: Environment,
    audience: &impl Audience,
) -> Result<Scene, OpenError> {
    let center = parts.first().map(|part| part.volume.center_mm()).unwrap_or_default();
    let usual = world_from_patient() * DAffine3::from_translation(-center);
    // The same look of the same scan is placed once, and what is worth saying of it said once.
    let mut looks: Vec<(Arc<Volume>, usize, Medium)> = vec![];
    let instance = |(index, (entry, part)): (usize, (&Entry, Part))| {
        let world_from_patient = entry.world_from_patient.map_or(usual, document::world_from_patient);
        let known = looks
            .iter()
            .find(|(volume, of, _)| Arc::ptr_eq(volume, &part.volume) && entries[*of].look == entry.look)
            .map(|(_, _, medium)| medium.clone());
        let medium = known.unwrap_or_else(|| {
            let medium = look(&entry.look, &part.volume, audience);
            looks.push((part.volume.clone(), index, medium.clone()));
            medium
        });
        let styles = entry.labels.as_ref().map_or(&[][..], |labels| &labels.styles);
        let labels =
            part.labels.map(|labels| labelling(labels, styles, &part.volume, medium.surface)).transpose();
        let labels = labels.map_err(|kind| OpenError::of(index, &["labels", "styles"], kind))?;
        let densest = styles.iter().filter_map(|style| style.density).max_by(f64::total_cmp);
        if let Some(density) = densest.filter(|_| labels.is_some()) {
            say_if_too_dense(density, &part.volume, audience);
        }
        let [low, high] = entry.clip.unwrap_or([[0.0; 3], [1.0; 3]]);
        Ok(VolumeInstance {
            clip_box: [DVec3::from_array(low), DVec3::from_array(high)],
            layers: entry.layers,
            labels,
            peel: part.peel,
            clip_shapes: entry.clip_shapes.iter().map(|shape| shape.placed(world_from_patient)).collect(),
            ..VolumeInstance::new(part.volume, medium, world_from_patient)
        })
    };
    let volumes = entries.iter().zip(parts).enumerate().map(instance).collect::<Result<_, OpenError>>()?;
    Ok(Scene { volumes, environment, lights })
}

/// Says of which labels that are named hardly anything is seen. What is meant for all is not about any of them.
pub fn say_if_unseen(instance: &VolumeInstance, styles: &[Style], audience: &impl Audience) {
    let Some(labels) = instance.labels.as_ref().map(|labelling| &labelling.labels) else { return };
    let named = styles.iter().filter(|style| style.label != "*");
    let named: BTreeSet<u8> =
        named.flat_map(|style| labels.values_of(&style.label, &labels.numbers())).collect();
    let unseen = instance.unseen_labels(&Vec::from_iter(named));
    let names: Vec<&str> =
        unseen.iter().filter_map(|value| labels.label(*value)).map(|label| label.name.as_str()).collect();
    if !names.is_empty() {
        let text =
            format!("hardly anything is seen of {}: the look makes what it is of clear", names.join(", "));
        audience.note(Note::new(text).with(Remedy::LabelPreset));
    }
}

/// Says where a volume takes less than the density that was asked for.
fn say_if_too_dense(density: f64, volume: &Volume, audience: &impl Audience) {
    let most = most_density_scale(volume);
    if density > most {
        let [density, most] = [density, most].map(number);
        audience.note(Note::new(format!(
            "a density of {density} is more than a scan of this size takes: it is rendered with {most}, as nothing is seen through it either"
        )));
    }
}

/// A look, placed for a scan, and what is worth saying of it.
pub fn look(look: &Look, volume: &Volume, audience: &impl Audience) -> Medium {
    let is_ct = volume.is_hounsfield() || volume.may_be_hounsfield() || volume.modality() == Modality::Ct;
    match look.preset {
        Some(preset) if preset.name().starts_with("ct-") && !is_ct => audience.note(Note::new(format!(
            "{} is a look of CT, placed here by where air and soft tissue seem to lie",
            preset.name()
        ))),
        None if look.transfer_function.is_none() => {
            let preset = look.base(volume);
            audience.say(&format!("  preset {} ({})", preset.name(), preset.description()));
        }
        _ => {}
    }
    let medium = look.medium(volume);
    if let Some(density) = look.density {
        say_if_too_dense(density, volume, audience);
    }
    let factor = presets::size_factor(volume);
    if factor != 1.0 && look.density.is_none() {
        let size = volume.size_mm().max_element();
        let text = format!(
            "{} across is no body's size: extinction follows it, {} times that of a body",
            lengths([size], 1),
            number(factor)
        );
        audience.note(Note::new(text).with(Remedy::Density(medium.density_scale / factor)));
    }
    medium
}
