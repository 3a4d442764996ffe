//! Labels of a document: their files, and how each label looks.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use lumivox_core::{
    CancelToken, LabelVolume, Labelling, Progress, SurfaceReflection, Volume,
    document::{Entry, Labels, Style},
    lasso::{LassoError, cut_by_lassos},
};
use lumivox_import::{LabelOptions, load_label_files};

use crate::{Audience, Note, OpenErrorKind, Opening, content_of, load::within};

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
            labels.files.iter().chain(&labels.table).map(|file| within(folder, file)).collect();
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
    options.table = labels.table.as_deref().map(|table| within(folder, table));
    let files: Vec<PathBuf> = labels.files.iter().map(|file| within(folder, file)).collect();
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
    surfaces: SurfaceReflection,
) -> Result<Labelling, OpenErrorKind> {
    let numbers = labels.numbers();
    let mut labelling = Labelling::new(labels);
    for (index, style) in styles.iter().enumerate() {
        let values = labelling.labels.values_of(&style.label, &numbers);
        if values.is_empty() {
            let names = labelling.labels.own_labels().map(|label| label.name.as_str());
            let known = names.chain(["unlabelled"]).collect::<Vec<_>>().join(", ");
            return Err(OpenErrorKind::NoSuchLabel { style: index, label: style.label.clone(), known });
        }
        for value in values {
            let own = labelling.labels.label(value).map(|label| label.color);
            let mut changed = labelling.style(value);
            style.apply(own, volume, surfaces, &mut changed);
            labelling.set_style(value, changed);
        }
    }
    Ok(labelling.without_cut())
}

/// The labels of a scan with what an entry's lassos cut away of it, but for labels that are spared.
///
/// # Errors
/// Where no value is left for that, and when `cancel` was used.
pub fn cut(
    entry: &Entry,
    volume: &Volume,
    labels: Option<&Arc<LabelVolume>>,
    audience: &impl Audience,
    cancel: &CancelToken,
) -> Result<Option<Arc<LabelVolume>>, OpenErrorKind> {
    let mut spared = [false; 256];
    if entry.lassos.is_empty() {
        let uncut = cut_by_lassos(volume, labels, &[], &spared, Progress::SILENT, cancel);
        return uncut.map_err(|error| OpenErrorKind::Wrong(error.to_string()));
    }
    if let (Some(labels), Some(named)) = (labels, &entry.labels) {
        let numbers = labels.numbers();
        for style in &named.styles {
            let Some(is_clipped) = style.clipped else { continue };
            let values = labels.values_of(&style.label, &numbers);
            values.into_iter().for_each(|value| spared[usize::from(value)] = !is_clipped);
        }
    }
    let cut =
        audience.watch(|progress| cut_by_lassos(volume, labels, &entry.lassos, &spared, progress, cancel));
    cut.map_err(|error| match error {
        LassoError::NoValueLeft => OpenErrorKind::Wrong(error.to_string()),
        LassoError::Cancelled(cancelled) => cancelled.into(),
    })
}
