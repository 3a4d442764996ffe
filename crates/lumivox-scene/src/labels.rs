//! Labels of a document: their files, and how each label looks.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use lumivox_core::{
    CancelToken, LabelVolume, Labelling, Volume,
    document::{Labels, Style},
};
use lumivox_import::{LabelOptions, load_label_files};

use crate::{Audience, Note, OpenErrorKind, Opening, content_of};

/// The label maps of a document, each loaded once.
#[derive(Default)]
pub struct LabelMaps(Vec<(Vec<PathBuf>, Arc<LabelVolume>)>);

impl LabelMaps {
    /// The map of these files.
    ///
    /// # Errors
    /// A file that is missing or holds no labels.
    pub fn load(
        &mut self,
        labels: &Labels,
        folder: &Path,
        opening: &Opening,
        audience: &impl Audience,
        cancel: &CancelToken,
    ) -> Result<Arc<LabelVolume>, OpenErrorKind> {
        let files: Vec<PathBuf> =
            labels.files.iter().chain(&labels.table).map(|file| folder.join(file)).collect();
        if let Some((_, known)) = self.0.iter().find(|(known, _)| *known == files) {
            return Ok(known.clone());
        }
        let loaded = load(labels, folder, opening, audience, cancel)?;
        self.0.push((files, loaded.clone()));
        Ok(loaded)
    }
}

fn load(
    labels: &Labels,
    folder: &Path,
    opening: &Opening,
    audience: &impl Audience,
    cancel: &CancelToken,
) -> Result<Arc<LabelVolume>, OpenErrorKind> {
    let mut options = LabelOptions::default();
    options.import.allow_outside_data = opening.allow_outside_data;
    options.table = labels.table.as_deref().map(|table| folder.join(table));
    let files: Vec<PathBuf> = labels.files.iter().map(|file| folder.join(file)).collect();
    let loaded = audience.watch(|progress| load_label_files(&files, &options, progress, cancel))?;
    let names: Vec<&str> = loaded.labels.labels().iter().map(|label| label.name.as_str()).collect();
    let list = match names.len() {
        0 => "no labels".to_owned(),
        1 => format!("1 label: {}", names[0]),
        count => format!("{count} labels: {}", names.join(", ")),
    };
    let files: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
    audience.say(&format!("{}: {list}", files.join(", ")));
    loaded.report.notes.iter().for_each(|note| audience.note(Note::new(note)));
    if let Some(expected) = &labels.content
        && *expected != content_of(loaded.labels.volume())
    {
        audience.note(Note::new(
            "these are not the labels that the scene was saved with: look whether the picture is right",
        ));
    }
    Ok(Arc::new(loaded.labels))
}

/// Labels with the looks that styles give them in a scan, in turn.
///
/// # Errors
/// A label that there is not, with those that there are.
pub fn labelling(
    labels: Arc<LabelVolume>,
    styles: &[Style],
    volume: &Volume,
) -> Result<Labelling, OpenErrorKind> {
    let numbers = labels.numbers();
    let mut labelling = Labelling::new(labels);
    for style in styles {
        let values = labelling.labels.values_of(&style.label, &numbers);
        if values.is_empty() {
            let names = labelling.labels.labels().iter().map(|label| label.name.as_str());
            let known = names.chain(["unlabelled"]).collect::<Vec<_>>().join(", ");
            return Err(OpenErrorKind::NoSuchLabel { label: style.label.clone(), known });
        }
        for value in values {
            let own = labelling.labels.label(value).map(|label| label.color);
            let mut changed = labelling.style(value);
            style.apply(own, volume, &mut changed);
            labelling.set_style(value, changed);
        }
    }
    Ok(labelling)
}

/// Whether labels lie in a scan, and what is to be said where many do not.
///
/// # Errors
/// When none of them does.
pub fn lie_within(labels: &LabelVolume, volume: &Volume) -> Result<Option<Note>, String> {
    /// Of the scan's size.
    const LOST: &str = "the labels have as many voxels as the scan along each axis, but lie elsewhere: if they were drawn on it, \
                        their file has lost its place (a NIfTI's affine, for example); save them with that of the scan";
    let has_lost = labels.is_of_size_but_elsewhere(volume);
    match labels.share_within(volume) {
        Some(0.0) if has_lost => Err(format!("none of its labels lies in the scan: {LOST}")),
        Some(0.0) => Err("none of its labels lies in the scan: they are of another patient, or of another place; take the \
                          labels of this scan"
            .into()),
        Some(_) if has_lost => Ok(Some(Note::new(LOST))),
        Some(share) if share < 0.5 => Ok(Some(Note::new(format!(
            "{:.0}% of what is labelled lies beyond the scan: are they of the same patient?",
            100.0 * (1.0 - share)
        )))),
        // That there are none was said when they were read.
        None | Some(_) => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use lumivox_core::{
        Label, Modality, Voxels,
        glam::{DAffine3, DVec3},
    };

    use super::*;

    #[test]
    fn labels_of_the_scans_size_at_another_place_are_told() {
        let place = DAffine3::from_scale(DVec3::splat(1.5));
        let scan = Volume::new([8; 3], Voxels::U8(vec![0; 512]), [1.0, 0.0], place, Modality::Ct).unwrap();
        let told = |place| {
            let label = Label { value: 1, name: "liver".into(), color: [0.5; 3] };
            let labels = LabelVolume::new([8; 3], vec![1; 512], place, vec![label]).unwrap();
            lie_within(&labels, &scan).map(|note| note.map(|note| note.text))
        };
        assert_eq!(told(place), Ok(None));
        let note = told(DAffine3::IDENTITY).unwrap().unwrap();
        assert!(note.contains("their file has lost its place"), "{note}");
        let error = told(DAffine3::from_translation(DVec3::X * 500.0)).unwrap_err();
        assert!(error.starts_with("none of its labels lies in the scan: the labels have"), "{error}");
    }
}
