//! Files become voxels, in a Worker: it takes longer than a page may stand still.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use js_sys::{Array, Float32Array, Function, Object, Reflect, Uint8Array, Uint16Array};
use lumivox_browser::give_files;
use lumivox_core::document::{Entry, Keep, SceneDocument};
use lumivox_core::host::Moment;
use lumivox_core::{CancelToken, Preset, Progress, Voxels, WorkStage};
use lumivox_import::{ImportOptions, SeriesSummary, load};
use lumivox_scene::{Notes, Opening, Remedy, open_loaded};
use serde::Deserialize;
use wasm_bindgen::prelude::*;

use crate::scan::Description;
use crate::wrong;

/// What is wanted of files.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Wanted {
    /// Which series, as the command has it.
    series: Option<String>,
    /// Which phase of it, from 1.
    phase: Option<usize>,
    /// What of a CT is kept.
    keep: Keep,
    /// Which look it is to have, which decides what is taken off.
    preset: Option<Preset>,
}

/// The page hears this often how far it is.
const OFTEN: Duration = Duration::from_millis(50);

thread_local! {
    /// Who hears how far it is, and when that was last. A Worker has one thread, and reads one scan at a time.
    static HEARS: RefCell<Option<(Function, Option<Moment>)>> = const { RefCell::new(None) };
}

fn tell(stage: WorkStage, done: u64, total: u64) {
    HEARS.with_borrow_mut(|hears| {
        if let Some((told, last)) = hears
            && last.is_none_or(|at| at.elapsed() > OFTEN)
        {
            *last = Some(Moment::now());
            // Who does not listen holds nothing up.
            let _ = told.call3(
                &JsValue::NULL,
                &stage.label().into(),
                &(done as f64).into(),
                &(total as f64).into(),
            );
        }
    });
}

/// What would show all of it, as JavaScript has it.
fn remedy(remedy: Remedy) -> Option<String> {
    Some(match remedy {
        Remedy::KeepEverything => " (keep: 'everything' shows it)".to_owned(),
        _ => String::new(),
    })
}

/// Reads the best series, or the one that is asked for, of files: pairs of a path and a browser's `File`. `told` hears what is done:
/// words, a number of steps, and of how many.
///
/// What comes of it is an object: `voxels`, `description` for [`Scan`](crate::Scan), `series` and `notes`, each of the last three JSON.
///
/// # Errors
/// Which file is wrong, and what to do.
#[wasm_bindgen]
pub fn read(files: &Array, wanted: &str, told: &Function) -> Result<Object, JsError> {
    let wanted: Wanted = serde_json::from_str(wanted).map_err(wrong)?;
    give_files(files);
    let paths: Vec<PathBuf> =
        files.iter().filter_map(|pair| Array::from(&pair).get(0).as_string().map(PathBuf::from)).collect();
    HEARS.set(Some((told.clone(), None)));
    let progress = Progress::new(&tell);
    let cancel = CancelToken::new();
    let mut options = ImportOptions::default();
    (options.series, options.phase) = (wanted.series, wanted.phase);
    let imported = load(&paths, &options, progress, &cancel).map_err(wrong)?;
    let mut entry = Entry::default();
    (entry.scan.keep, entry.look.preset) = (wanted.keep, wanted.preset);
    let document = SceneDocument { volumes: vec![entry], ..SceneDocument::default() };
    let notes = Notes::new(progress, remedy);
    let scans = vec![Arc::new(imported.volume)];
    let opened = open_loaded(&document, scans, Path::new(""), &Opening::default(), &notes, &cancel);
    let opened = opened.map_err(wrong)?;
    let volume = opened.scene.volumes.first().ok_or_else(|| wrong("nothing of it is left"))?.volume.clone();
    let voxels: JsValue = match volume.voxels() {
        Voxels::U8(voxels) => Uint8Array::from(&voxels[..]).into(),
        Voxels::U16(voxels) => Uint16Array::from(&voxels[..]).into(),
        Voxels::F32(voxels) => Float32Array::from(&voxels[..]).into(),
    };
    let of_series = |series: &SeriesSummary| series.description.clone();
    let series: Vec<String> = imported.report.series.iter().map(of_series).collect();
    let mut notes = notes.into_sentences();
    notes.extend(imported.report.notes.iter().cloned());
    let read = Object::new();
    let set = |name: &str, value: &JsValue| Reflect::set(&read, &name.into(), value).map(drop);
    let json = |text: Result<String, serde_json::Error>| text.map(JsValue::from).map_err(wrong);
    set("voxels", &voxels)
        .and(set("description", &json(serde_json::to_string(&Description::of(&volume)))?))
        .and(set("series", &json(serde_json::to_string(&series))?))
        .and(set("notes", &json(serde_json::to_string(&notes))?))
        .map_err(|_| wrong("the browser takes no result"))?;
    Ok(read)
}
