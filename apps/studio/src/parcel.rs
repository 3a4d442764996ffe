//! What goes between a page and its Worker, which share no memory: words as JSON, voxels as bytes. What arrives is what was
//! sent, to the bit.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lumivox_core::document::{Scan, SceneDocument};
use lumivox_core::glam::DAffine3;
use lumivox_core::labels::{CutAway, Label, LabelSource};
use lumivox_core::{
    EnvironmentMap, EnvironmentSource, LabelVolume, Modality, Peel, Scene, Subject, Volume, Voxels, WorkStage,
};
use lumivox_import::{ImportReport, SeriesSummary, Thumbnail};
use lumivox_scene::Part;
use serde::{Deserialize, Serialize};

/// What a page asks of its Worker.
#[derive(Serialize, Deserialize)]
pub enum Errand {
    /// Opens files and folders.
    Open(Vec<PathBuf>),
    /// Loads a series of files that were opened, by its place in the list.
    Series(Vec<PathBuf>, usize),
    /// Finds what is shown of scans.
    Show(String, Vec<usize>),
    /// Grows a head of so many voxels along each axis.
    Phantom(usize),
}

/// What a Worker says.
#[derive(Serialize, Deserialize)]
pub enum Word {
    /// How far it is.
    Busy(Option<WorkStage>, u64, u64),
    /// Which series there are, which of them is loaded now, and of which files they are.
    Series(Vec<SeriesSummary>, usize, Vec<PathBuf>),
    /// A series' picture.
    Thumbnail(usize, Thumbnail),
    /// A scene is open.
    Opened(OpenedWords),
    /// A scan is read of which it is still looked for what is shown. Both sides know its volumes from then on.
    Scan(OpenedWords),
    /// What tells it from others.
    Content(String),
    /// What was found of it.
    Found(SceneWords, Vec<String>),
    /// What is shown of scans.
    Shown(SceneWords, Vec<String>),
    /// Why it is not open, or not shown.
    Failed(String),
}

/// An opened scene.
#[derive(Serialize, Deserialize)]
pub struct OpenedWords {
    /// Its volumes as they lie in their files.
    pub scans: Vec<usize>,
    /// What is shown.
    pub scene: SceneWords,
    /// Whether nobody said from where it is seen.
    pub is_framed: bool,
    /// How the first scan was read.
    pub report: ImportReport,
    /// What else is worth telling.
    pub notes: Vec<String>,
}

/// A scene: its document, and what that names.
#[derive(Serialize, Deserialize)]
pub struct SceneWords {
    document: String,
    /// Each once, however many volumes share them.
    labels: Vec<LabelWords>,
    parts: Vec<PartWords>,
}

#[derive(Serialize, Deserialize)]
struct PartWords {
    volume: usize,
    /// By their place in the scene's list.
    labels: Option<usize>,
    peel: Option<(usize, f64)>,
}

/// Where labels come from: files, a table of names, and the numbers that names were given.
type SourceWords = (Vec<PathBuf>, Option<PathBuf>, Vec<(String, u8)>);

#[derive(Serialize, Deserialize)]
struct LabelWords {
    volume: usize,
    table: Vec<(u8, String, [f64; 3])>,
    source: Option<SourceWords>,
    cut: Option<CutAway>,
}

#[derive(Serialize, Deserialize)]
struct VolumeWords {
    dims: [usize; 3],
    bytes_per_sample: usize,
    rescale: [f64; 2],
    place: [f64; 12],
    modality: Modality,
    unit: String,
    subject: Subject,
    source: Option<Scan>,
}

/// A map of light, which is the last of the bytes.
#[derive(Serialize, Deserialize)]
struct MapWords {
    size: [usize; 2],
    file: Option<PathBuf>,
}

#[derive(Serialize, Deserialize)]
struct Letter<T> {
    word: T,
    /// So many volumes were sent before and have the first numbers.
    known: usize,
    volumes: Vec<VolumeWords>,
    map: Option<MapWords>,
}

/// Things to send.
#[derive(Default)]
pub struct Packer {
    known: Vec<Arc<Volume>>,
    volumes: Vec<Arc<Volume>>,
    map: Option<Arc<EnvironmentMap>>,
}

impl Packer {
    /// For who has some volumes already, which are not sent again.
    pub fn knowing(known: Vec<Arc<Volume>>) -> Self {
        Self { known, ..Self::default() }
    }

    /// Puts a volume in, once; its number.
    pub fn volume(&mut self, volume: &Arc<Volume>) -> usize {
        let mut all = self.known.iter().chain(&self.volumes);
        all.position(|known| Arc::ptr_eq(known, volume)).unwrap_or_else(|| {
            self.volumes.push(volume.clone());
            self.known.len() + self.volumes.len() - 1
        })
    }

    /// Puts a scene in.
    ///
    /// # Errors
    /// Where a document names files that are no Unicode.
    pub fn scene(&mut self, document: &SceneDocument, scene: &Scene) -> Result<SceneWords, String> {
        if let EnvironmentSource::Map(map) = &scene.environment.source {
            self.map = Some(map.clone());
        }
        let mut labels: Vec<&Arc<LabelVolume>> = vec![];
        let mut place = |own| {
            labels.iter().position(|known| Arc::ptr_eq(known, own)).unwrap_or_else(|| {
                labels.push(own);
                labels.len() - 1
            })
        };
        let parts = scene.volumes.iter().map(|instance| PartWords {
            volume: self.volume(&instance.volume),
            labels: instance.labels.as_ref().map(|labelling| place(&labelling.labels)),
            peel: instance.peel.as_ref().map(|peel| (self.volume(&peel.depth), peel.mm)),
        });
        let parts = parts.collect();
        let labels = labels.into_iter().map(|own| self.labels(own)).collect();
        Ok(SceneWords { document: document.to_json().map_err(|error| error.to_string())?, labels, parts })
    }

    fn labels(&mut self, labels: &LabelVolume) -> LabelWords {
        let of = |label: &Label| (label.value, label.name.clone(), label.color);
        let source = labels.source().map(|source| {
            let numbers = source.numbers.iter().map(|(number, value)| (number.to_string(), *value)).collect();
            (source.files.clone(), source.table.clone(), numbers)
        });
        LabelWords {
            volume: self.volume(labels.volume()),
            table: labels.labels().iter().map(of).collect(),
            source,
            cut: labels.cut_away().cloned(),
        }
    }

    /// The letter that goes with what was put in.
    pub fn letter<T: Serialize>(&self, word: T) -> String {
        let of = |volume: &Arc<Volume>| VolumeWords {
            dims: volume.dims(),
            bytes_per_sample: volume.voxels().bytes_per_sample(),
            rescale: [volume.slope(), volume.intercept()],
            place: volume.patient_from_voxel().to_cols_array(),
            modality: volume.modality(),
            unit: volume.unit().to_owned(),
            subject: volume.subject(),
            source: volume.source().cloned(),
        };
        let map = self
            .map
            .as_ref()
            .map(|map| MapWords { size: [map.width, map.height], file: map.file().map(Path::to_owned) });
        let (known, volumes) = (self.known.len(), self.volumes.iter().map(of).collect());
        let letter = Letter { word, known, volumes, map };
        serde_json::to_string(&letter).expect("all of it is text and numbers")
    }

    /// The bytes that go with it.
    pub fn bytes(&self) -> impl Iterator<Item = &[u8]> {
        let map = self.map.iter().map(|map| bytemuck::cast_slice(map.texels.as_flattened()));
        self.volumes.iter().map(|volume| volume.voxels().as_bytes()).chain(map)
    }
}

/// Bytes that have arrived.
pub trait Bytes {
    /// How many there are of a number.
    fn length(&self, number: usize) -> usize;

    /// Copies them to where there is room for so many.
    fn copy(&self, number: usize, into: &mut [u8]);
}

/// Things that have arrived.
pub struct Unpacker<'a> {
    words: Vec<VolumeWords>,
    map: Option<MapWords>,
    /// Those that were sent before, and as many of the others as were asked for.
    made: Vec<Option<Arc<Volume>>>,
    known: usize,
    bytes: &'a dyn Bytes,
}

/// Why nothing is in a parcel that something was in: a fault of ours.
fn lost(what: impl std::fmt::Display) -> String {
    format!("a part of the page sent another what that does not understand: {what}")
}

impl<'a> Unpacker<'a> {
    /// The word of a letter, and what came with it.
    ///
    /// # Errors
    /// Where it is no letter.
    pub fn open<T: for<'de> Deserialize<'de>>(
        letter: &str,
        bytes: &'a dyn Bytes,
    ) -> Result<(T, Self), String> {
        let Letter { word, known, volumes, map } = serde_json::from_str(letter).map_err(lost)?;
        let made = vec![None; known + volumes.len()];
        Ok((word, Self { words: volumes, map, made, known, bytes }))
    }

    /// The volumes that were sent before.
    ///
    /// # Errors
    /// Where the other side knows others.
    pub fn know(&mut self, known: &[Arc<Volume>]) -> Result<(), String> {
        if known.len() != self.known {
            return Err(lost("a volume is not there"));
        }
        self.made.iter_mut().zip(known).for_each(|(made, known)| *made = Some(known.clone()));
        Ok(())
    }

    /// What was said of a volume that came with this letter, and the number of its bytes.
    fn words(&self, number: usize) -> Result<(&VolumeWords, usize), String> {
        let own = number.checked_sub(self.known);
        let words = own.and_then(|own| self.words.get(own).zip(Some(own)));
        words.ok_or_else(|| lost("a volume is not there"))
    }

    /// Samples by the number of their bytes.
    fn samples<S: bytemuck::Pod>(&self, number: usize) -> Vec<S> {
        let mut samples = vec![S::zeroed(); self.bytes.length(number) / size_of::<S>()];
        self.bytes.copy(number, bytemuck::cast_slice_mut(&mut samples));
        samples
    }

    /// A volume, by its number.
    ///
    /// # Errors
    /// Where there is none.
    pub fn volume(&mut self, number: usize) -> Result<Arc<Volume>, String> {
        if let Some(Some(made)) = self.made.get(number) {
            return Ok(made.clone());
        }
        let (words, bytes) = self.words(number)?;
        let voxels = match words.bytes_per_sample {
            1 => Voxels::U8(self.samples(bytes)),
            2 => Voxels::U16(self.samples(bytes)),
            _ => Voxels::F32(self.samples(bytes)),
        };
        let place = DAffine3::from_cols_array(&words.place);
        let volume = Volume::new(words.dims, voxels, words.rescale, place, words.modality).map_err(lost)?;
        let volume = volume.with_unit(words.unit.clone()).with_subject(words.subject);
        let volume = Arc::new(match &words.source {
            Some(source) => volume.with_source(source.clone()),
            None => volume,
        });
        self.made[number] = Some(volume.clone());
        Ok(volume)
    }

    fn labels(&mut self, words: LabelWords) -> Result<Arc<LabelVolume>, String> {
        let (of, bytes) = self.words(words.volume)?;
        let table =
            words.table.into_iter().map(|(value, name, color)| Label { value, name, color }).collect();
        let place = DAffine3::from_cols_array(&of.place);
        let labels = LabelVolume::new(of.dims, self.samples(bytes), place, table).map_err(lost)?;
        let labels = match words.source {
            Some((files, table, numbers)) => {
                let number = |(number, value): (String, u8)| {
                    number.parse().map(|number| (number, value)).map_err(lost)
                };
                let numbers = numbers.into_iter().map(number).collect::<Result<_, String>>()?;
                labels.with_source(LabelSource { files, table, numbers })
            }
            None => labels,
        };
        Ok(Arc::new(match words.cut {
            Some(cut) => labels.with_cut(cut),
            None => labels,
        }))
    }

    /// A scene and its document.
    ///
    /// # Errors
    /// Where it is none.
    pub fn scene(&mut self, words: SceneWords) -> Result<(SceneDocument, Scene), String> {
        let document = SceneDocument::parse_described(&words.document).map_err(|error| lost(error.why))?;
        let labels = words.labels.into_iter().map(|words| self.labels(words));
        let all = labels.collect::<Result<Vec<_>, String>>()?;
        let mut parts = vec![];
        for part in words.parts {
            let peel = match part.peel {
                Some((depth, mm)) => Some(Peel { depth: self.volume(depth)?, mm }),
                None => None,
            };
            let labels = part.labels.map(|place| all.get(place).ok_or_else(|| lost("labels are not there")));
            let labels = labels.transpose()?.cloned();
            parts.push(Part { volume: self.volume(part.volume)?, labels, peel });
        }
        let scene = lumivox_scene::assemble(&document, parts, self.map()?).map_err(lost)?;
        Ok((document, scene))
    }

    fn map(&self) -> Result<Option<Arc<EnvironmentMap>>, String> {
        let Some(MapWords { size: [width, height], file }) = &self.map else { return Ok(None) };
        let numbers: Vec<f32> = self.samples(self.words.len());
        let texels = numbers.as_chunks::<3>().0.to_vec();
        let map = EnvironmentMap::new(*width, *height, texels).map_err(lost)?;
        Ok(Some(Arc::new(match file {
            Some(file) => map.with_file(file),
            None => map,
        })))
    }
}
