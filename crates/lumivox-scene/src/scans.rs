//! The scans of a document: each is read once, and what is shown of it is found once, however often it stands in the scene.

use std::{path::Path, sync::Arc};

use lumivox_core::{
    CancelToken, Preset, Volume,
    document::{Entry, Keep, Scan, SceneDocument, TakenOff},
};
use lumivox_import::{ImportReport, Imported};

use crate::{Audience, OpenError, Opening, load::load, load::say_if_another};

/// A scan as it lies in its files.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Its voxels, which all entries share that read the same files alike.
    pub volume: Arc<Volume>,
    /// How it was read.
    pub report: Arc<ImportReport>,
    /// Whether an entry before shares it, of which all was told.
    pub is_shared: bool,
}

impl From<Imported> for Loaded {
    fn from(imported: Imported) -> Self {
        Self { volume: Arc::new(imported.volume), report: Arc::new(imported.report), is_shared: false }
    }
}

/// Loads the scans of a document, one for each entry; files that several read alike are read once.
///
/// # Errors
/// A file that is missing or no scan, and what no option can be, with the entry.
pub fn load_scans(
    document: &SceneDocument,
    folder: &Path,
    opening: &Opening,
    audience: &impl Audience,
    cancel: &CancelToken,
) -> Result<Vec<Loaded>, OpenError> {
    let entries = &document.volumes;
    let readings: Vec<Scan> = entries.iter().map(|entry| reading(&entry.scan)).collect();
    let mut scans: Vec<Loaded> = Vec::with_capacity(entries.len());
    for (index, entry) in entries.iter().enumerate() {
        let known = readings[..index].iter().position(|other| *other == readings[index]);
        let loaded = match known {
            Some(known) => {
                let is_told = entries[..index].iter().zip(&readings).any(|(other, reading)| {
                    *reading == readings[index] && other.scan.content == entry.scan.content
                });
                if !is_told {
                    say_if_another(index, &entry.scan, &scans[known].volume, audience);
                }
                Loaded { is_shared: true, ..scans[known].clone() }
            }
            None => {
                // Whether it is another scan, somebody later may ask.
                let mut alike = entries[index..].iter().zip(&readings[index..]);
                let is_asked =
                    alike.any(|(other, reading)| *reading == readings[index] && other.scan.content.is_some());
                let opening = Opening { identify: opening.identify || is_asked, ..*opening };
                let loaded = load(index, &entry.scan, folder, &opening, audience, cancel)
                    .map_err(|kind| OpenError::of_scan(index, kind))?;
                Loaded::from(loaded)
            }
        };
        scans.push(loaded);
    }
    Ok(scans)
}

/// What of a scan decides how its files are read: not what of it is shown, nor what it was.
fn reading(scan: &Scan) -> Scan {
    Scan { content: None, keep: Keep::default(), taken_off: None, ..scan.clone() }
}

/// What decides what of a scan is shown.
#[derive(PartialEq)]
pub struct Shows {
    volume: *const Volume,
    keep: Keep,
    taken_off: Option<TakenOff>,
    preset: Option<Preset>,
    has_function: bool,
    finds_labels: bool,
    peel: Option<f64>,
}

impl Shows {
    /// Of an entry with its scan.
    pub fn of(entry: &Entry, scan: &Arc<Volume>) -> Self {
        Self {
            volume: Arc::as_ptr(scan),
            keep: entry.scan.keep,
            taken_off: entry.scan.taken_off,
            preset: entry.look.preset,
            has_function: entry.look.transfer_function.is_some(),
            finds_labels: entry.labels.as_ref().is_some_and(|labels| labels.files.is_empty()),
            peel: entry.peel,
        }
    }
}
