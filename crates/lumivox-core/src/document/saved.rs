//! The way back: from a scene to its document.

use super::{Entry, Labels, Lighting, Look, SceneDocument, Shape, Style, Surroundings, numbers::world_rows};
use crate::{
    classification::Labelling,
    labels::{LabelVolume, UNLABELLED},
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
        let entry = |(index, instance)| Entry::of(index, instance);
        Ok(Self {
            volumes: scene.volumes.iter().enumerate().map(entry).collect::<Result<_, _>>()?,
            environment: Surroundings::of(&scene.environment).ok_or(Unsaved::Map)?,
            lights: scene.lights.iter().map(Lighting::of).collect(),
            ..Self::default()
        })
    }
}

impl Entry {
    fn of(index: usize, instance: &VolumeInstance) -> Result<Self, Unsaved> {
        let scan = instance.volume.source().ok_or(Unsaved::Volume(index))?.clone();
        let [low, high] = instance.clip_box;
        Ok(Self {
            scan,
            look: Look::of_medium(&instance.medium),
            world_from_patient: Some(world_rows(instance.world_from_patient)),
            layers: instance.layers,
            clip: ((low, high) != (DVec3::ZERO, DVec3::ONE)).then(|| [low.to_array(), high.to_array()]),
            clip_shapes: instance.clip_shapes.iter().map(Shape::of).collect(),
            labels: instance.labels.as_ref().map(|labels| labels_of(labels, index)).transpose()?,
            peel: instance.peel.as_ref().map(|peel| peel.mm),
        })
    }
}

fn labels_of(labelling: &Labelling, index: usize) -> Result<Labels, Unsaved> {
    let source = labelling.labels.source().ok_or(Unsaved::Labels(index))?;
    let style =
        |(value, style): &(u8, _)| Style::of(label_name(&labelling.labels, &source.numbers, *value), style);
    Ok(Labels {
        files: source.files.clone(),
        table: source.table.clone(),
        content: None,
        styles: labelling.styles.iter().map(style).collect(),
    })
}

/// The word by which a document knows a label: its name where that is the only one, else its number.
fn label_name(labels: &LabelVolume, numbers: &[(i128, u8)], value: u8) -> String {
    let name = match value {
        UNLABELLED => "unlabelled",
        _ => labels.label(value).map_or("", |label| label.name.as_str()),
    };
    if labels.values_of(name, numbers) == [value] {
        return name.to_owned();
    }
    let number =
        numbers.iter().find(|(_, own)| *own == value).map_or(i128::from(value), |(number, _)| *number);
    format!("#{number}")
}
