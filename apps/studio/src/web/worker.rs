//! The other end of the page's errands: the same program, in a Worker with a memory of its own.

use std::cell::RefCell;
use std::sync::Arc;
use std::time::Duration;

use js_sys::{Array, Function, Uint8Array};
use lumivox_browser::give_files;
use lumivox_core::Volume;
use lumivox_core::document::SceneDocument;
use lumivox_core::host::Moment;
use lumivox_import::{ImportReport, SeriesSummary};
use lumivox_phantom::{AnatomyOptions, anatomy};
use wasm_bindgen::prelude::*;

use crate::jobs::{Desk, elsewhere};
use crate::opening::{self, Opened, SharedStudy, Shown, Source, Told};
use crate::parcel::{Bytes, Errand, OpenedWords, Packer, Unpacker, Word};

/// Bytes as JavaScript has them.
pub(crate) struct Arrived(pub(crate) Array);

impl Bytes for Arrived {
    fn length(&self, number: usize) -> usize {
        self.0.get(number as u32).dyn_into::<Uint8Array>().map_or(0, |bytes| bytes.length() as usize)
    }

    fn copy(&self, number: usize, into: &mut [u8]) {
        if let Ok(bytes) = self.0.get(number as u32).dyn_into::<Uint8Array>() {
            bytes.copy_to(into);
        }
    }
}

/// A packer's bytes as JavaScript has them.
pub(crate) fn leaving(packer: &Packer) -> Array {
    packer.bytes().map(|bytes| JsValue::from(Uint8Array::from(bytes))).collect()
}

/// Takes letters and their bytes to the page.
#[derive(Clone)]
struct Post(Function);

impl Post {
    fn say(&self, packer: &Packer, word: Word) {
        let posted = self.0.call2(&JsValue::NULL, &packer.letter(word).into(), &leaving(packer));
        // Too much for the browser, perhaps: the page hears that the work stopped.
        if posted.is_err() {
            wasm_bindgen::throw_str("the page does not hear its Worker");
        }
    }
}

/// Does an errand of the page's; `post` takes a letter and its bytes there.
#[wasm_bindgen]
pub fn work(letter: &str, bytes: &Array, files: &Array, post: Function) {
    lumivox_browser::begin();
    // The page says that the work stopped; why is for programmers.
    std::panic::set_hook(Box::new(|panic| super::complain(&panic.to_string())));
    give_files(files);
    let post = Post(post);
    if let Err(why) = answer(letter, bytes, &post) {
        post.say(&Packer::default(), Word::Failed(why));
    }
}

thread_local! {
    /// Takes what a job has said to the page.
    static PUMP: RefCell<Option<Box<dyn FnMut()>>> = const { RefCell::new(None) };
}

fn pump() {
    PUMP.with(|pump| {
        if let Ok(mut pump) = pump.try_borrow_mut()
            && let Some(pump) = pump.as_mut()
        {
            pump();
        }
    });
}

/// The page hears this often how far it is.
const OFTEN: Duration = Duration::from_millis(50);

/// Does a job here; what it says goes to the page at once.
fn at_desk<M: Send + 'static>(post: &Post, tell: impl Fn(M) + 'static, work: impl FnOnce(&Desk<M>)) {
    let (mut job, desk) = elsewhere(Arc::new(pump), || {});
    let post = post.clone();
    let (mut last, mut at) = (job.busy(), None::<Moment>);
    let listen = move || {
        job.poll().into_iter().for_each(&tell);
        let busy = job.busy();
        if busy != last && at.is_none_or(|at| at.elapsed() > OFTEN) {
            post.say(&Packer::default(), Word::Busy(busy.stage, busy.done, busy.total));
            (last, at) = (busy, Some(Moment::now()));
        }
    };
    PUMP.set(Some(Box::new(listen)));
    work(&desk);
    pump();
    PUMP.set(None);
}

/// A head, as if it had been read.
fn grow(size: usize, desk: &Desk<Told>) -> Result<(), String> {
    let options = AnatomyOptions { size, ..AnatomyOptions::default() };
    let grown = desk.watch(|progress| anatomy(options, progress, desk.cancel()));
    let mut series = SeriesSummary::default();
    series.name = "Phantom".to_owned();
    let mut report = ImportReport::default();
    report.series = vec![series];
    opening::present(grown.map_err(|error| error.to_string())?, report, desk)
}

/// A scan that the page has, while it is looked for what is shown of it.
type Before = RefCell<(SceneDocument, Vec<Arc<Volume>>)>;

/// What a job told, to the page.
fn tell(post: &Post, before: &Before, told: Told) {
    let mut packer = Packer::default();
    let word = match told {
        Told::Series { series, chosen, study } => Word::Series(series, chosen, study.files().to_vec()),
        Told::Thumbnail(place, picture) => Word::Thumbnail(place, picture),
        Told::Failed(why) => Word::Failed(why),
        Told::Opened(opened) => pack(*opened, &mut packer).map_or_else(Word::Failed, Word::Opened),
        Told::Scan(opened) => {
            before.replace((opened.document.clone(), opened.scans.clone()));
            pack(*opened, &mut packer).map_or_else(Word::Failed, Word::Scan)
        }
        Told::Content(content) => Word::Content(content),
        Told::Found(scene, notes) => {
            let (document, scans) = before.take();
            packer = Packer::knowing(scans);
            let packed = packer.scene(&document, &scene);
            packed.map_or_else(Word::Failed, |scene| Word::Found(scene, notes))
        }
    };
    post.say(&packer, word);
}

fn pack(opened: Opened, packer: &mut Packer) -> Result<OpenedWords, String> {
    let Opened { document, scans, scene, camera: _, is_framed, report, notes } = opened;
    // The page knows them by these numbers in what comes later.
    let scans = scans.iter().map(|scan| packer.volume(scan)).collect();
    Ok(OpenedWords { scans, scene: packer.scene(&document, &scene)?, is_framed, report, notes })
}

fn answer(letter: &str, bytes: &Array, post: &Post) -> Result<(), String> {
    let arrived = Arrived(bytes.clone());
    let (errand, mut with) = Unpacker::open::<Errand>(letter, &arrived)?;
    let own = post.clone();
    let before = Before::default();
    let told = move |told: Told| tell(&own, &before, told);
    match errand {
        Errand::Open(files) => at_desk(post, told, |desk| opening::open(Source::Files(files), desk)),
        Errand::Series(files, place) => {
            let source = Source::Series(SharedStudy::of(&files), place);
            at_desk(post, told, |desk| opening::open(source, desk));
        }
        Errand::Phantom(size) => at_desk(post, told, |desk| {
            if let Err(why) = grow(size, desk) {
                desk.tell(Told::Failed(why));
            }
        }),
        Errand::Show(document, scans) => {
            let document = SceneDocument::parse_described(&document).map_err(|error| error.why)?;
            let scans = scans.into_iter().map(|scan| with.volume(scan)).collect::<Result<Vec<_>, _>>()?;
            let (own, of) = (post.clone(), document.clone());
            let shown = move |shown: Shown| {
                let mut packer = Packer::default();
                let packed = shown.and_then(|(scene, notes)| Ok((packer.scene(&of, &scene)?, notes)));
                let word = packed.map_or_else(Word::Failed, |(scene, notes)| Word::Shown(scene, notes));
                own.say(&packer, word);
            };
            at_desk(post, shown, |desk| desk.tell(opening::show(&document, scans, desk)));
        }
    }
    Ok(())
}
