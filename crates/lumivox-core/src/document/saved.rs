//! The way back: from a scene to its document.

use super::{Entry, Labels, Lighting, Look, SceneDocument, Shape, Style, Surroundings, numbers::world_rows};
use crate::{
    classification::Labelling,
    scene::{Scene, VolumeInstance},
};
use glam::DVec3;

/// What of a scene has no file, so that no document can name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unsaved {
    /// A volume's voxels.
    #[error("scan {} was made in memory: write it to a file, and load that, before the scene is saved", .0 + 1)]
    Volume(usize),
    /// A volume's labels.
    #[error("the labels of scan {} were made in memory: write them to a file, and load that, before the scene is saved", .0 + 1)]
    Labels(usize),
    /// The map of the light.
    #[error(
        "the light's map was made in memory: write it to a file, and load that, before the scene is saved"
    )]
    Map,
}

impl SceneDocument {
    /// A scene as it is, seen and rendered as documents are by default. Files are named as the scene's scans name theirs.
    ///
    /// # Errors
    /// [`Unsaved`] where something came from no file.
    pub fn of(scene: &Scene) -> Result<Self, Unsaved> {
        for (index, instance) in scene.volumes.iter().enumerate() {
            instance.volume.source().ok_or(Unsaved::Volume(index))?;
            if let Some(labelling) = &instance.labels {
                labelling.labels.source().ok_or(Unsaved::Labels(index))?;
            }
        }
        Surroundings::of(&scene.environment).ok_or(Unsaved::Map)?;
        let mut document = Self::described(scene);
        for (entry, instance) in document.volumes.iter_mut().zip(&scene.volumes) {
            without_cut(entry, instance);
        }
        Ok(document)
    }

    /// A scene as it is for whoever gets its scans, labels and the light's map beside it: what came from no file has no name.
    pub fn described(scene: &Scene) -> Self {
        let environment = &scene.environment;
        let nameless = || Surroundings {
            strength: environment.strength,
            rotation: environment.rotation.to_degrees(),
            ..Surroundings::default()
        };
        Self {
            volumes: scene.volumes.iter().map(Entry::of).collect(),
            environment: Surroundings::of(environment).unwrap_or_else(nameless),
            lights: scene.lights.iter().map(Lighting::of).collect(),
            ..Self::default()
        }
    }
}

impl Entry {
    fn of(instance: &VolumeInstance) -> Self {
        let [low, high] = instance.clip_box;
        let labels = instance.labels.as_ref().map(|labelling| &labelling.labels);
        Self {
            scan: instance.volume.source().cloned().unwrap_or_default(),
            look: Look::of_medium(&instance.medium),
            world_from_patient: Some(world_rows(instance.world_from_patient)),
            layers: instance.layers,
            clip: ((low, high) != (DVec3::ZERO, DVec3::ONE)).then(|| [low.to_array(), high.to_array()]),
            clip_shapes: instance.clip_shapes.iter().map(Shape::of).collect(),
            lassos: labels.and_then(|labels| labels.cut_away()).map_or(vec![], |cut| cut.lassos.clone()),
            labels: instance.labels.as_ref().map(labels_of),
            peel: instance.peel.as_ref().map(|peel| peel.mm),
        }
    }
}

fn labels_of(labelling: &Labelling) -> Labels {
    let style = |(value, style): &(u8, _)| Style::of(labelling.labels.word_of(*value), style);
    let source = labelling.labels.source();
    Labels {
        files: source.map(|source| source.files.clone()).unwrap_or_default(),
        table: source.and_then(|source| source.table.clone()),
        content: None,
        styles: labelling.styles.iter().map(style).collect(),
    }
}

/// Who opens a file cuts by its lassos anew: its labels are those before that.
fn without_cut(entry: &mut Entry, instance: &VolumeInstance) {
    let Some(labels) = instance.labels.as_ref().map(|labelling| &labelling.labels) else { return };
    let Some(cut) = labels.cut_away() else { return };
    let word = labels.word_of(cut.value);
    match &mut entry.labels {
        Some(own) if labels.has_own() => own.styles.retain(|style| style.label != word),
        own => *own = None,
    }
}
