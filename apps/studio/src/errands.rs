//! What is done beside the interface, each on a thread of its own.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lumivox_core::document::SceneDocument;
use lumivox_core::{Orbit, PerspectiveCamera, Preset, Scene, Volume};

use crate::app::Choice;
use crate::darkroom::{self, Darkroom, Exported, Tile};
use crate::files;
use crate::jobs::{Desk, Job, Wake, start};
use crate::opening::{self, Shown, Source, Told};
use crate::session::Wanted;
use crate::sharing::{self, Sharing, Viewer};
use crate::turntable::turntable;
use crate::words::{Language, Word};

/// Opens files, or a series of some that are open.
pub fn open(source: Source, wake: Wake) -> Job<Told> {
    start("open a scan", wake, move |desk: &Desk<Told>| opening::open(source, desk))
}

/// Finds what of scans is shown.
pub fn show(wanted: Wanted, wake: Wake) -> Job<Shown> {
    start("show a scan", wake, move |desk: &Desk<Shown>| {
        let Wanted { document, scans, to_cut } = wanted;
        desk.tell(match to_cut {
            Some((parts, map)) => opening::cut_anew(&document, parts, map, desk),
            None => opening::show(&document, scans, desk),
        });
    })
}

/// Makes a tile of each of these looks.
pub fn tiles(
    room: Darkroom,
    document: SceneDocument,
    scan: Arc<Volume>,
    looks: Vec<Preset>,
    wake: Wake,
) -> Job<Tile> {
    let work = move |desk: &Desk<Tile>| darkroom::develop_tiles(&room, &document, &scan, looks, desk);
    start("make tiles", wake, work)
}

/// Renders a picture and keeps it.
pub fn export(
    room: Darkroom,
    document: SceneDocument,
    scene: Scene,
    camera: PerspectiveCamera,
    file: PathBuf,
    wake: Wake,
) -> Job<Exported> {
    let work = move |desk: &Desk<Exported>| darkroom::export(&room, &document, &scene, &camera, &file, desk);
    start("render a picture", wake, work)
}

/// Whether turns are made here.
pub const MAKES_TURNS: bool = true;

/// Renders a turn around a scan in so many pictures, and keeps them.
pub fn turn(
    room: Darkroom,
    document: SceneDocument,
    scene: Scene,
    start_at: Orbit,
    (file, steps): (PathBuf, u32),
    wake: Wake,
) -> Job<Exported> {
    let work =
        move |desk: &Desk<Exported>| turntable(&room, &document, &scene, start_at, (&file, steps), desk);
    start("render a turn", wake, work)
}

/// Writes a page for others.
pub fn share(sharing: Sharing, file: PathBuf, wake: Wake) -> Job<Exported> {
    start("write a page", wake, move |desk: &Desk<Exported>| {
        let language = sharing.language;
        let viewer = viewer(language);
        let page = viewer.and_then(|viewer| sharing::page(&sharing, &viewer, desk.cancel()));
        if desk.cancel().is_cancelled() {
            return;
        }
        let kept = page.and_then(|page| files::save(&file, &mut |out| Ok(out.write_all(page.as_bytes())?)));
        desk.tell(kept.map_or_else(Exported::Failed, |()| Exported::Written(None)));
    })
}

/// The program for pages: in the folder that `LUMIVOX_VIEWER` names, or beside this program, where Linux keeps what programs share, or where
/// a clone makes it.
fn viewer(language: Language) -> Result<Viewer, String> {
    let read = |folder: &Path| {
        let [calls, binding, wasm] = Viewer::FILES.map(|name| std::fs::read(folder.join(name)));
        Some(Viewer::new([calls.ok()?, binding.ok()?, wasm.ok()?]))
    };
    let none = || Word::ShareNoViewer.of(language).to_owned();
    if let Some(told) = std::env::var_os("LUMIVOX_VIEWER").map(PathBuf::from) {
        return read(&told).ok_or_else(|| format!("LUMIVOX_VIEWER={}: {}", told.display(), none()));
    }
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let own = program.parent().ok_or_else(none)?;
    let folders = ["viewer", "../share/lumivox-studio/viewer", "../npm"];
    folders.into_iter().find_map(|folder| read(&own.join(folder))).ok_or_else(none)
}

/// Waits for a file dialog.
pub fn choose(choice: Choice, wake: Wake) -> Job<Vec<PathBuf>> {
    start("file dialog", wake, move |desk: &Desk<Vec<PathBuf>>| desk.tell(pollster::block_on(choice)))
}
