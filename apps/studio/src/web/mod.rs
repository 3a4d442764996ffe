//! The Studio as a page: a canvas, the browser's dialogs and downloads, and a Worker for what takes longer than a frame. What of
//! the browser is easier said in its own language is in `web/studio.js`, which the page hands over as [`Hooks`].

mod exposure;
mod worker;

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;

use js_sys::{Array, Function, Promise, Uint8Array};
use lumivox_browser::{begin, best_texels, pace};
use lumivox_renderer::FineTexels;
use wasm_bindgen::prelude::*;
use wasm_bindgen_futures::JsFuture;

use crate::app::{App, Choice, Chooser, Launch};
use crate::arrivals::{Arrivals, Given};
use crate::errands;
use crate::session::Session;
use crate::settings::{Drawer, Settings};
use crate::sharing::SIDES;
use crate::state::{Action, Ask};
use crate::words::{Language, Word};

pub(crate) use exposure::{TilePress, expose};
pub(crate) use worker::{Arrived, leaving};

#[wasm_bindgen]
extern "C" {
    /// What the page does for the program.
    #[derive(Clone)]
    pub type Hooks;

    /// A dialog that files or a folder are chosen in; the paths of what was. `apart` where each file is asked for by itself.
    #[wasm_bindgen(method)]
    fn choose(this: &Hooks, folder: bool, apart: bool) -> Promise;

    /// Gives somebody a file, as a download.
    #[wasm_bindgen(method)]
    fn save(this: &Hooks, name: &str, bytes: &Uint8Array);

    /// One of the page's own files.
    #[wasm_bindgen(method)]
    fn fetch(this: &Hooks, name: &str) -> Promise;

    /// Has a Worker do an errand; `told` hears of it, and is called with `null` when the Worker breaks. Ends it when called.
    #[wasm_bindgen(method)]
    fn work(this: &Hooks, letter: &str, bytes: &Array, told: &Function) -> Function;

    #[wasm_bindgen(js_namespace = console)]
    fn error(text: &str);
}

/// What belongs to the page: it has one thread.
pub(crate) struct Surroundings {
    hooks: Hooks,
    software: bool,
    device: Option<(eframe::wgpu::Device, eframe::wgpu::Queue)>,
    /// How that device stores voxels best, where it said so.
    fine_texels: Option<FineTexels>,
}

impl Surroundings {
    /// Gives somebody a file.
    pub(crate) fn save(&self, name: &str, bytes: &Uint8Array) {
        self.hooks.save(name, bytes);
    }
}

thread_local! {
    static SURROUNDINGS: RefCell<Option<Surroundings>> = const { RefCell::new(None) };
    static ARRIVALS: RefCell<Arrivals> = RefCell::default();
}

/// Where files that come together lie: what stands before each of their paths, and then the paths of what is opened.
#[wasm_bindgen]
pub fn place(paths: Vec<String>, sizes: Vec<f64>, changed: Vec<f64>, apart: bool) -> Vec<String> {
    let numbers = sizes.into_iter().zip(changed);
    let given = paths.into_iter().zip(numbers).map(|(path, (size, changed))| Given { path, size, changed });
    let placed = ARRIVALS.with(|all| all.borrow_mut().place(&given.collect::<Vec<_>>(), apart));
    [placed.before].into_iter().chain(placed.tops).collect()
}

/// What was given to the page.
pub(crate) fn with_arrivals<T>(work: impl FnOnce(&Arrivals) -> T) -> T {
    ARRIVALS.with(|all| work(&all.borrow()))
}

/// Works with what belongs to the page.
pub(crate) fn with_page<T>(work: impl FnOnce(&Surroundings) -> T) -> Option<T> {
    SURROUNDINGS.with(|page| page.borrow().as_ref().map(work))
}

/// Whether a processor does the work of a GPU.
pub(crate) fn is_software() -> bool {
    with_page(|page| page.software).unwrap_or_default()
}

/// Pixels of a view that a processor draws at most: whatever is traced of them, its other passes go over all, which takes a second for
/// those of a whole screen, and leaves none for tracing.
const MOST_SOFTWARE_PIXELS: u32 = 1 << 16;

/// The program in a page.
#[wasm_bindgen]
pub struct Page(eframe::WebRunner);

#[wasm_bindgen]
impl Page {
    /// Begins on a canvas. `software` says that a processor does the work of a GPU.
    ///
    /// # Errors
    /// Why there is no picture.
    pub async fn open(
        canvas: web_sys::HtmlCanvasElement,
        hooks: Hooks,
        software: bool,
    ) -> Result<Page, JsValue> {
        begin();
        SURROUNDINGS.with(|page| {
            *page.borrow_mut() =
                Some(Surroundings { hooks: hooks.clone(), software, device: None, fine_texels: None })
        });
        let runner = eframe::WebRunner::new();
        let options = eframe::WebOptions { wgpu_options: crate::gpu_options(), ..Default::default() };
        let launch = Launch {
            open: vec![],
            drawer: Box::new(Storage),
            chooser: Box::new(Dialogs(hooks)),
            makes_tiles: true,
        };
        let create: eframe::AppCreator<'static> = Box::new(move |context| {
            let mut app = App::new(context, launch);
            if let Some(live) = app.live_mut() {
                *live.viewport_mut().pace_mut() = pace(software);
                if software {
                    live.set_patience(None);
                    live.set_most_pixels(MOST_SOFTWARE_PIXELS);
                }
                let state = live.render_state();
                let device = Some((state.device.clone(), state.queue.clone()));
                SURROUNDINGS.with(|page| {
                    if let Some(page) = page.borrow_mut().as_mut() {
                        page.device = device;
                    }
                });
            }
            Ok(Box::new(app))
        });
        runner.start(canvas, options, create).await?;
        let page = Page(runner);
        // Before anybody gives it a scan.
        page.ask_device().await;
        Ok(page)
    }

    /// Opens files and folders that were dropped, by their paths.
    pub fn bring(&self, paths: Vec<String>) {
        if let Some(mut app) = self.0.app_mut::<App>() {
            app.state.act(Action::Open(paths.into_iter().map(PathBuf::from).collect()));
            (app.wake())();
        }
    }

    /// Grows a head, for whoever has no scan.
    pub fn phantom(&self, size: usize) {
        if let Some(mut app) = self.0.app_mut::<App>() {
            let job = errands::phantom(size, app.wake().clone());
            app.begin(job);
            (app.wake())();
        }
    }

    /// Says why files cannot be opened.
    pub fn fail(&self, why: String) {
        if let Some(mut app) = self.0.app_mut::<App>() {
            app.state.failed = Some((Word::CannotOpen, why));
            (app.wake())();
        }
    }

    /// Whether work would be lost with the page.
    #[wasm_bindgen(getter, js_name = hasWork)]
    pub fn has_work(&self) -> bool {
        let app = self.0.app_mut::<App>();
        app.is_some_and(|app| app.state.session.as_ref().is_some_and(Session::has_work))
    }

    /// How the program broke, if it did.
    #[wasm_bindgen(getter)]
    pub fn broken(&self) -> Option<String> {
        self.0.panic_summary().map(|panic| panic.message())
    }

    /// Writes a page for others without asking anybody: for programs that try this page.
    pub fn share(&self) {
        if let Some(mut app) = self.0.app_mut::<App>() {
            app.state.act(Action::Ask(Ask::SavePage("shared.html".to_owned(), SIDES[0])));
            (app.wake())();
        }
    }

    /// How far it is, for programs: as JSON.
    pub fn told(&self) -> String {
        let Some(app) = self.0.app_mut::<App>() else { return "{}".to_owned() };
        let state = &app.state;
        let session = state.session.as_ref();
        serde_json::json!({
            "name": session.map(|session| session.name()),
            "dims": session.map(|session| session.scan().dims()),
            "series": state.strip.series.len(),
            "busy": state.busy.is_some(),
            "failed": state.failed.as_ref().map(|(_, why)| why),
            "done": state.done,
            "samples": state.progress.samples,
            "part": state.progress.part,
            "isShown": state.progress.is_shown,
            "rests": state.progress.rests,
            "tiles": state.tiles.len(),
            "looks": state.looks.len(),
        })
        .to_string()
    }
}

/// Settings in the browser's storage of this page.
struct Storage;

const KEY: &str = "lumivox-studio";

impl Storage {
    fn open() -> Option<web_sys::Storage> {
        web_sys::window()?.local_storage().ok()?
    }
}

impl Drawer for Storage {
    fn read(&self) -> Option<Settings> {
        serde_json::from_str(&Self::open()?.get_item(KEY).ok()??).ok()
    }

    fn write(&self, settings: &Settings) {
        if let (Some(storage), Ok(text)) = (Self::open(), serde_json::to_string(settings)) {
            // What cannot be kept is asked again next time.
            let _ = storage.set_item(KEY, &text);
        }
    }
}

/// The browser's dialogs. Where a file is saved, it asks itself or has a folder for downloads.
struct Dialogs(Hooks);

impl Chooser for Dialogs {
    fn ask(&self, ask: &Ask, _: Language) -> Choice {
        match ask {
            Ask::Files | Ask::Folder | Ask::Labels | Ask::LabelFolder | Ask::Light => {
                // At once: browsers show dialogs only to who has just clicked.
                let is_folder = matches!(ask, Ask::Folder | Ask::LabelFolder);
                let is_no_scan = matches!(ask, Ask::Labels | Ask::Light);
                let chosen = JsFuture::from(self.0.choose(is_folder, is_no_scan));
                Box::pin(async move {
                    let paths = chosen.await.map(|paths| Array::from(&paths)).unwrap_or_default();
                    paths.iter().filter_map(|path| path.as_string().map(PathBuf::from)).collect()
                })
            }
            Ask::SaveScene(name)
            | Ask::SavePicture(name)
            | Ask::SavePage(name, _)
            | Ask::SaveTable(name)
            | Ask::SaveTurn(name, _) => {
                let name = PathBuf::from(name);
                Box::pin(async move { vec![name] })
            }
        }
    }
}

/// One of the page's own files.
///
/// # Errors
/// Why it does not come.
pub(crate) async fn fetch(name: &str) -> Result<Vec<u8>, String> {
    let asked = with_page(|page| page.hooks.fetch(name)).ok_or("there is no page")?;
    match JsFuture::from(asked).await {
        Ok(bytes) => Ok(Uint8Array::new(&bytes).to_vec()),
        Err(error) => Err(js_sys::Error::from(error).message().into()),
    }
}

/// What was wrong, where only programmers look.
pub(crate) fn complain(text: &str) {
    error(text);
}

/// A function of the page's that hears a Worker.
type Heard = Closure<dyn FnMut(JsValue, JsValue)>;

/// Has the Worker do an errand. What it says is read by `read`, until that is true: an empty word is its last, none
/// says that it broke.
pub(crate) fn send(
    letter: &str,
    bytes: &Array,
    mut read: impl FnMut(Option<&str>, &Array) -> bool + 'static,
) -> Box<dyn FnOnce()> {
    let own: Rc<RefCell<Option<Heard>>> = Rc::default();
    let kept = own.clone();
    let heard = Heard::new(move |letter: JsValue, bytes: JsValue| {
        if read(letter.as_string().as_deref(), &Array::from(&bytes)) {
            // It is being called: it goes when the browser comes by again.
            let kept = kept.clone();
            wasm_bindgen_futures::spawn_local(async move { drop(kept.borrow_mut().take()) });
        }
    });
    let told: Function = heard.as_ref().unchecked_ref::<Function>().clone();
    *own.borrow_mut() = Some(heard);
    let end = with_page(|page| page.hooks.work(letter, bytes, &told));
    Box::new(move || {
        if let Some(end) = end {
            let _ = end.call0(&JsValue::NULL);
        }
        drop(own.borrow_mut().take());
    })
}

impl Page {
    /// Finds out how the device stores voxels best.
    async fn ask_device(&self) {
        let Some((device, queue)) = with_page(|page| page.device.clone()).flatten() else { return };
        let Ok(fine_texels) = best_texels(&device, &queue).await else { return };
        if let Some(mut app) = self.0.app_mut::<App>()
            && let Some(live) = app.live_mut()
        {
            live.viewport_mut().store_as(fine_texels);
        }
        SURROUNDINGS.with(|page| {
            if let Some(page) = page.borrow_mut().as_mut() {
                page.fine_texels = Some(fine_texels);
            }
        });
    }
}
