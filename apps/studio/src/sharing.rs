//! A scene as one file that a browser opens: the program for pages, the scan in fewer voxels, and how it looks. Neither where the scan came
//! from is in it, nor what lassos cut away of it or was taken off from its skin: that is left out of every number before voxels are
//! made fewer, and what lies beside it is made of what is kept.

use std::fmt::Write as _;
use std::io::Write as _;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use lumivox_core::document::{Backdrop, Display, SceneDocument, Style, View, rows};
use lumivox_core::glam::DVec3;
use lumivox_core::{
    CancelToken, LabelVolume, Labelling, Peel, PerspectiveCamera, Preset, Scene, UNLABELLED, Volume,
    VolumeInstance, Voxels,
};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::grid::Grid;
use crate::words::{self, Language, Word};

/// Sides of shared scans, in voxels at most: a face is one from some 96 on.
pub const SIDES: [usize; 3] = [96, 160, 256];

const PAGE: &str = include_str!("../share/page.html");
const STYLE: &str = include_str!("../share/page.css");
const SCRIPT: &str = include_str!("../share/page.js");

/// The program for pages: files of the npm package.
pub struct Viewer([Vec<u8>; 3]);

impl Viewer {
    /// The names of its files: what pages call, what binds that to WebAssembly, and the WebAssembly. Packages have them in
    /// `viewer` (`xtask/src/package/studio.rs`).
    pub const FILES: [&str; 3] = ["lumivox.js", "lumivox_wasm.js", "lumivox_wasm_bg.wasm"];

    /// Of the contents of its files.
    pub fn new(files: [Vec<u8>; 3]) -> Self {
        Self(files)
    }
}

/// What is shared.
pub struct Sharing {
    /// What is seen.
    pub scene: Scene,
    /// How it is seen.
    pub document: SceneDocument,
    /// From where.
    pub camera: PerspectiveCamera,
    /// What it is called, without a patient's name.
    pub title: String,
    /// Other looks that it can have.
    pub looks: Vec<Preset>,
    /// The language of its page.
    pub language: Language,
    /// Voxels along each side of a scan at most.
    pub side: usize,
}

/// The parts of a page that are no text.
#[derive(Default)]
struct Blocks(String);

impl Blocks {
    fn push(&mut self, bytes: &[u8]) -> Result<(), String> {
        let mut packed = GzEncoder::new(vec![], Compression::default());
        let packed = packed.write_all(bytes).and_then(|()| packed.finish());
        let packed = packed.map_err(|error| error.to_string())?;
        self.0 += "<script type=\"application/gzip\">";
        STANDARD.encode_string(packed, &mut self.0);
        self.0 += "</script>\n";
        Ok(())
    }
}

/// Numbers as typed arrays of JavaScript have them.
struct Packed {
    kind: &'static str,
    slope: f64,
    intercept: f64,
    bytes: Vec<u8>,
}

impl Packed {
    /// Values on a grid, stored as a scan's are; those of floats in 16 bits.
    fn of(values: &[f64], like: &Volume) -> Self {
        let [low, high] = like.value_range();
        let (kind, slope, intercept) = match like.voxels() {
            Voxels::U8(_) => ("uint8", like.slope(), like.intercept()),
            Voxels::U16(_) => ("uint16", like.slope(), like.intercept()),
            Voxels::F32(_) if high > low => ("uint16", (high - low) / f64::from(u16::MAX), low),
            Voxels::F32(_) => ("uint16", 1.0, low),
        };
        let most = f64::from(if kind == "uint8" { u16::from(u8::MAX) } else { u16::MAX });
        let stored = |value: f64| ((value - intercept) / slope).round().clamp(0.0, most) as u16;
        let bytes = match kind {
            "uint8" => values.par_iter().map(|value| stored(*value) as u8).collect(),
            _ => values.par_iter().flat_map_iter(|value| stored(*value).to_le_bytes()).collect(),
        };
        Self { kind, slope, intercept, bytes }
    }

    fn description(&self, volume: &Volume, grid: &Grid) -> Value {
        json!({
            "dims": grid.dims,
            "patientFromVoxel": rows(grid.patient_from_voxel),
            "slope": self.slope,
            "intercept": self.intercept,
            "modality": volume.modality(),
            "unit": volume.unit(),
        })
    }
}

/// The voxel of a volume that is nearest to a patient's point, if that lies within.
fn nearest(volume: &Volume, patient: DVec3) -> Option<[usize; 3]> {
    let at = volume.patient_from_voxel().inverse().transform_point3(patient).round();
    let dims = volume.dims();
    let is_within = at.cmpge(DVec3::ZERO).all() && (0..3).all(|axis| at[axis] < dims[axis] as f64);
    is_within.then(|| at.to_array().map(|n| n as usize))
}

/// The label at a patient's point: beyond its grid there is none.
fn label(labels: &LabelVolume, patient: DVec3) -> u8 {
    nearest(labels.volume(), patient).map_or(UNLABELLED, |voxel| labels.value(voxel))
}

/// How much is left of what lies at a patient's point.
fn share_left(peel: &Peel, patient: DVec3) -> f64 {
    let last = DVec3::from_array(peel.depth.dims().map(|n| n as f64 - 1.0));
    let at = peel.depth.patient_from_voxel().inverse().transform_point3(patient);
    let at = at.clamp(DVec3::ZERO, last);
    peel.depth.interpolated(at).map_or(1.0, |depth| peel.share(depth))
}

/// What a page is told of a scan; its voxels, labels and depths become blocks, in this order.
fn scan(instance: &VolumeInstance, side: usize, blocks: &mut Blocks) -> Result<Value, String> {
    let volume = &instance.volume;
    let grid = Grid::of(volume, side);
    let labels = instance.labels.as_ref().map(|labelling| &labelling.labels);
    let cut = labels.and_then(|labels| Some((labels, labels.cut_away()?.value)));
    let peel = instance.peel.as_ref().filter(|peel| peel.is_active());
    let place = volume.patient_from_voxel();
    let is_kept = |voxel: [usize; 3]| {
        let point = || place.transform_point3(DVec3::from_array(voxel.map(|i| i as f64)));
        cut.is_none_or(|(labels, value)| label(labels, point()) != value)
            && peel.is_none_or(|peel| share_left(peel, point()) > 0.0)
    };
    let packed = match (cut, peel) {
        (None, None) => Packed::of(&grid.means(volume, |_| true), volume),
        _ => Packed::of(&grid.means(volume, is_kept), volume),
    };
    blocks.push(&packed.bytes)?;
    let mut told = json!({ "kind": packed.kind, "description": packed.description(volume, &grid) });
    if let Some(labels) = labels {
        // An outline that is left of skin would tell as much.
        let is_left = |at: DVec3| peel.is_none_or(|peel| share_left(peel, at) > 0.0);
        let values = grid.map(|at| if is_left(at) { label(labels, at) } else { UNLABELLED });
        let named = labels.labels().iter();
        told["labels"] =
            named.map(|it| json!({ "value": it.value, "name": it.name, "color": it.color })).collect();
        blocks.push(&values)?;
    }
    if let Some(peel) = peel {
        let grid = Grid::of(&peel.depth, side);
        // How deep it is beyond the border tells where the skin was.
        let width = grid
            .patient_from_voxel
            .matrix3
            .to_cols_array_2d()
            .map(|column| DVec3::from_array(column).length());
        let width = width.into_iter().fold(f64::INFINITY, f64::min);
        let border = |depth: f64| depth.clamp(peel.mm - 0.5 * width, peel.mm + 0.5 * width);
        let depths = grid.means(&peel.depth, |_| true).into_iter().map(border).collect::<Vec<_>>();
        let packed = Packed::of(&depths, &peel.depth);
        told["depth"] = json!({ "kind": packed.kind, "description": packed.description(&peel.depth, &grid) });
        blocks.push(&packed.bytes)?;
    }
    Ok(told)
}

/// Labels are told from each other by their values: names may be alike.
fn styles(labelling: &Labelling) -> Vec<Style> {
    labelling.styles.iter().map(|(value, style)| Style::of(format!("#{value}"), style)).collect()
}

/// How it is seen, of which nothing says where it came from.
fn document(sharing: &Sharing) -> SceneDocument {
    let mut document = SceneDocument::described(&sharing.scene);
    for (entry, instance) in document.volumes.iter_mut().zip(&sharing.scene.volumes) {
        entry.scan = Default::default();
        entry.lassos.clear();
        let grid = Grid::of(&instance.volume, sharing.side);
        entry.clip = entry.clip.map(|corners| corners.map(|corner| grid.fractions(corner)));
        if let (Some(labels), Some(labelling)) = (&mut entry.labels, &instance.labels) {
            (labels.files, labels.table) = (vec![], None);
            labels.styles = styles(labelling);
        }
    }
    // Pages know no light of files.
    if document.environment.file().is_some() {
        document.environment.source = Default::default();
    }
    document.camera = View::of(&sharing.camera);
    document.display = sharing.document.display;
    // Nothing lies behind a page's picture that could be seen.
    if document.display.background == Backdrop::Transparent {
        document.display.background = Display::default().background;
    }
    document.film.seed = sharing.document.film.seed;
    document
}

/// The file, as HTML.
///
/// # Errors
/// Where it was cancelled.
pub fn page(sharing: &Sharing, viewer: &Viewer, cancel: &CancelToken) -> Result<String, String> {
    let mut blocks = Blocks::default();
    viewer.0.iter().try_for_each(|file| blocks.push(file))?;
    let scans = sharing.scene.volumes.iter().map(|instance| {
        cancel.check().map_err(|cancelled| cancelled.to_string())?;
        scan(instance, sharing.side, &mut blocks)
    });
    let scans = scans.collect::<Result<Vec<_>, String>>()?;
    let say = |word: Word| word.of(sharing.language);
    let looks = sharing.looks.iter().map(|look| {
        let name = words::look(*look).map_or(look.name(), say);
        json!({ "preset": look.name(), "name": name })
    });
    let first = sharing.scene.volumes.first().and_then(|instance| instance.labels.as_ref());
    let structures = first.into_iter().flat_map(|labelling| {
        let of = |label: &lumivox_core::Label| {
            let is_visible = labelling.style(label.value).visible;
            json!({ "label": format!("#{}", label.value), "name": label.name, "isVisible": is_visible })
        };
        labelling.labels.own_labels().map(of).collect::<Vec<_>>()
    });
    let told = json!({
        "scans": scans,
        "document": document(sharing),
        "looks": looks.collect::<Vec<_>>(),
        "structures": structures.collect::<Vec<_>>(),
        "words": {
            "asShared": say(Word::PageAsShared),
            "samples": say(Word::Samples),
        },
    });
    let told = told.to_string().replace('<', "\\u003c");
    let mut page = String::with_capacity(PAGE.len() + blocks.0.len() + told.len());
    // From one mark to the next: what was filled in is not looked at again.
    let mut rest = PAGE;
    while let Some((before, behind)) = rest.split_once("{{") {
        let (mark, behind) = behind.split_once("}}").ok_or("the page is damaged")?;
        page += before;
        match mark {
            "style" => page += STYLE,
            "script" => page += SCRIPT,
            "told" => page += &told,
            "blocks" => page += &blocks.0,
            "language" => page += if sharing.language == Language::German { "de" } else { "en" },
            "title" => page += &escaped(&sharing.title),
            "no device" => page += &escaped(say(Word::NoDevice)),
            "hint" => page += &escaped(say(Word::PageHint)),
            "look" => page += &escaped(say(Word::Looks)),
            "structures" => page += &escaped(say(Word::Structures)),
            "reset" => page += &escaped(say(Word::PageReset)),
            "loading" => page += &escaped(say(Word::Preparing)),
            _ => return Err(format!("the page has a mark {mark}")),
        }
        rest = behind;
    }
    page += rest;
    Ok(page)
}

fn escaped(text: &str) -> String {
    text.chars().fold(String::new(), |mut all, letter| {
        match letter {
            '&' | '<' | '>' | '"' => _ = write!(all, "&#{};", u32::from(letter)),
            _ => all.push(letter),
        }
        all
    })
}
