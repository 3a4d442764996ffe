//! What is done beside the interface: in a Worker, which shares no memory with the page, or between frames.

use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::Arc;

use js_sys::Array;
use lumivox_browser::pause;
use lumivox_core::document::SceneDocument;
use lumivox_core::{Orbit, PerspectiveCamera, Preset, Scene, Volume};
use wasm_bindgen_futures::spawn_local;

use crate::app::Choice;
use crate::darkroom::{self, Darkroom, Exported, Picture, Tile};
use crate::files;
use crate::jobs::{Busy, Desk, Job, Wake, elsewhere};
use crate::opening::{Opened, SharedStudy, Shown, Source, Told};
use crate::parcel::{Errand, OpenedWords, Packer, Unpacker, Word};
use crate::session::Wanted;
use crate::sharing::{self, Sharing, Viewer};
use crate::web::{Arrived, TilePress, expose, fetch, is_software, leaving, send};

/// Sends an errand, and reads what comes of it. `None` of `read` is what was told of it already.
fn begin<M: Send + 'static>(
    errand: Errand,
    packer: &Packer,
    wake: Wake,
    read: impl Fn(Word, &mut Unpacker<'_>) -> Result<Option<M>, String> + 'static,
    failed: impl Fn(String) -> M + 'static,
) -> Job<M> {
    let ends = std::rc::Rc::new(std::cell::RefCell::new(None::<Box<dyn FnOnce()>>));
    let end = ends.clone();
    let (job, desk) = elsewhere(wake, move || {
        if let Some(end) = end.borrow_mut().take() {
            end();
        }
    });
    let mut desk: Option<Desk<M>> = Some(desk);
    let hear = move |letter: Option<&str>, bytes: &Array| {
        let Some(own) = &desk else { return true };
        let arrived = Arrived(bytes.clone());
        let Some(letter) = letter.filter(|letter| !letter.is_empty()) else {
            if letter.is_some() {
                own.done();
            }
            // The interface looks in its next frame, when the desk is gone.
            own.wake();
            desk = None;
            return true;
        };
        match Unpacker::open::<Word>(letter, &arrived) {
            Ok((Word::Busy(stage, done, total), _)) => own.report(Busy { stage, done, total }),
            Ok((Word::Failed(why), _)) | Err(why) => own.tell(failed(why)),
            Ok((word, mut with)) => match read(word, &mut with) {
                Ok(told) => told.into_iter().for_each(|told| own.tell(told)),
                Err(why) => own.tell(failed(why)),
            },
        }
        false
    };
    let letter = packer.letter(errand);
    *ends.borrow_mut() = Some(send(&letter, &leaving(packer), hear));
    job
}

fn opened(words: OpenedWords, with: &mut Unpacker<'_>) -> Result<Box<Opened>, String> {
    let OpenedWords { scans, scene, is_framed, report, notes } = words;
    let scans = scans.into_iter().map(|scan| with.volume(scan)).collect::<Result<_, _>>()?;
    let (document, scene) = with.scene(scene)?;
    let camera = document.camera.camera(&scene, document.film.aspect());
    let camera = camera.ok_or("the camera is the point looked at")?;
    Ok(Box::new(Opened { document, scans, scene, camera, is_framed, report, notes }))
}

fn opening(errand: Errand, known: Option<SharedStudy>, wake: Wake) -> Job<Told> {
    let before = RefCell::new(vec![]);
    let read = move |word: Word, with: &mut Unpacker<'_>| {
        Ok(match word {
            Word::Series(series, chosen, files) => {
                let study = known.clone().unwrap_or_else(|| SharedStudy::of(&files));
                Some(Told::Series { series, chosen, study })
            }
            Word::Thumbnail(place, picture) => Some(Told::Thumbnail(place, picture)),
            Word::Opened(words) => Some(Told::Opened(opened(words, with)?)),
            Word::Scan(words) => {
                let opened = opened(words, with)?;
                before.replace(opened.scans.clone());
                Some(Told::Scan(opened))
            }
            Word::Content(content) => Some(Told::Content(content)),
            Word::Found(scene, notes) => {
                with.know(&before.take())?;
                Some(Told::Found(with.scene(scene)?.1, notes))
            }
            _ => None,
        })
    };
    begin(errand, &Packer::default(), wake, read, Told::Failed)
}

/// Opens files, or a series of some that are open.
pub fn open(source: Source, wake: Wake) -> Job<Told> {
    match source {
        Source::Files(files) => opening(Errand::Open(files), None, wake),
        Source::Series(study, place) => {
            opening(Errand::Series(study.files().to_vec(), place), Some(study), wake)
        }
    }
}

/// Grows a head of so many voxels along each axis.
pub fn phantom(size: usize, wake: Wake) -> Job<Told> {
    opening(Errand::Phantom(size), None, wake)
}

/// Finds what of scans is shown: all of it anew, for a Worker keeps nothing.
pub fn show(wanted: Wanted, wake: Wake) -> Job<Shown> {
    let Wanted { document, scans, .. } = wanted;
    let mut packer = Packer::default();
    let scans = scans.iter().map(|scan| packer.volume(scan)).collect();
    // A document that came here as text goes as text.
    let text = document.to_json().unwrap_or_default();
    let read = |word: Word, with: &mut Unpacker<'_>| {
        Ok(match word {
            Word::Shown(scene, notes) => Some(Ok((with.scene(scene)?.1, notes))),
            _ => None,
        })
    };
    begin(Errand::Show(text, scans), &packer, wake, read, Err)
}

/// Samples of a tile's pixels; and where a processor does the work of a GPU, which has some seconds for each.
const TILE_SAMPLES: [u32; 2] = [64, 8];
/// Voxels along each axis that one of a tile's is the mean of at most: the page waits for it.
const TILE_MEANS: usize = 2;

/// Makes a tile of each of these looks, one after the other: Workers find what is shown, the page's device traces it between frames.
pub fn tiles(
    _: Darkroom,
    document: SceneDocument,
    scan: Arc<Volume>,
    looks: Vec<Preset>,
    wake: Wake,
) -> Job<Tile> {
    let (job, desk) = elsewhere(wake.clone(), || {});
    spawn_local(async move {
        let small = Arc::new(darkroom::reduced(&scan, darkroom::TILE_VOXELS, TILE_MEANS));
        drop(scan);
        if let Ok(mut press) = TilePress::new() {
            let total = looks.len() as u64;
            for (done, preset) in (0..).zip(looks) {
                desk.report(Busy { stage: None, done, total });
                // A look that cannot be shown has no tile, and says why when it is chosen.
                if let Ok(Some(picture)) = tile(&mut press, &document, &small, preset, (&desk, &wake)).await {
                    desk.tell(Tile { preset, picture });
                }
                if desk.cancel().is_cancelled() {
                    break;
                }
            }
        }
        desk.done();
        desk.wake();
    });
    job
}

async fn tile(
    press: &mut TilePress,
    document: &SceneDocument,
    small: &Arc<Volume>,
    preset: Preset,
    (desk, wake): (&Desk<Tile>, &Wake),
) -> Result<Option<Picture>, String> {
    let document = darkroom::tile_document(document, preset);
    let scans = vec![small.clone()];
    let mut showing = show(Wanted { document: document.clone(), scans, to_cut: None }, wake.clone());
    let scene = loop {
        if let Some(shown) = showing.poll().pop() {
            break shown?.0;
        }
        if desk.cancel().is_cancelled() || showing.is_over() {
            return Ok(None);
        }
        pause().await;
    };
    let samples = TILE_SAMPLES[usize::from(is_software())];
    press.print(&document, &scene, samples, desk).await
}

/// Renders a picture between frames, and gives it to somebody as a download.
pub fn export(
    _: Darkroom,
    document: SceneDocument,
    scene: Scene,
    camera: PerspectiveCamera,
    file: PathBuf,
    wake: Wake,
) -> Job<Exported> {
    let (job, desk) = elsewhere(wake, || {});
    spawn_local(async move {
        let exported = expose(&document, &scene, &camera, &file, &desk).await;
        if !desk.cancel().is_cancelled() {
            desk.tell(exported.map_or_else(Exported::Failed, |()| Exported::Written(None)));
        }
        desk.done();
        desk.wake();
    });
    job
}

/// Whether turns are made here: a hundred downloads would be none that anybody wants.
pub const MAKES_TURNS: bool = false;

/// Pages offer no turns.
pub fn turn(
    _: Darkroom,
    _: SceneDocument,
    _: Scene,
    _: Orbit,
    _: (PathBuf, u32),
    wake: Wake,
) -> Job<Exported> {
    let (job, desk) = elsewhere(wake, || {});
    desk.done();
    job
}

/// Writes a page for others, by the program for pages that lies beside this one.
pub fn share(sharing: Sharing, file: PathBuf, wake: Wake) -> Job<Exported> {
    let (job, desk) = elsewhere(wake, || {});
    spawn_local(async move {
        let page = match viewer().await {
            Ok(viewer) => {
                // What goes on is seen before the page stands still.
                pause().await;
                sharing::page(&sharing, &viewer, desk.cancel())
            }
            Err(why) => Err(why),
        };
        if !desk.cancel().is_cancelled() {
            let kept =
                page.and_then(|page| files::save(&file, &mut |out| Ok(out.write_all(page.as_bytes())?)));
            desk.tell(kept.map_or_else(Exported::Failed, |()| Exported::Written(None)));
        }
        desk.done();
        desk.wake();
    });
    job
}

async fn viewer() -> Result<Viewer, String> {
    let mut all = vec![];
    for name in Viewer::FILES {
        all.push(fetch(&format!("viewer/{name}")).await?);
    }
    all.try_into().map(Viewer::new).map_err(|_| String::new())
}

/// Waits for a file dialog.
pub fn choose(choice: Choice, wake: Wake) -> Job<Vec<PathBuf>> {
    let (job, desk) = elsewhere(wake, || {});
    spawn_local(async move {
        desk.tell(choice.await);
        desk.done();
        desk.wake();
    });
    job
}
