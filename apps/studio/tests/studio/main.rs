//! The whole program on software Vulkan, by clicks on what a person reads: phantoms always, the shared real scans where they are.
//!
//! `LUMIVOX_SCREENSHOTS=FOLDER` keeps a picture of each step.

mod archive;
mod arrivals;
mod cuts;
mod first_start;
mod gallery;
mod keeping;
mod lasso;
mod leaders;
mod looks;
mod measure;
mod opening;
mod parcel;
mod pictures;
mod pixels;
mod real_scans;
mod renderer;
mod sharing;
mod slabs;
mod structures;
mod views;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, Once, PoisonError};
use std::time::{Duration, Instant};

use eframe::egui::{self, DroppedFile, Key, Modifiers, PointerButton, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use lumivox_core::{CancelToken, Progress};
use lumivox_phantom::{AnatomyOptions, SeriesDescription, anatomy, write_dicom_series};
use lumivox_studio::app::{App, Choice, Chooser, Launch};
use lumivox_studio::session::Session;
use lumivox_studio::settings::{Drawer, Forgetful, Settings};
use lumivox_studio::state::Ask;
use lumivox_studio::words::Language;
use lumivox_viewport::Pace;
use tempfile::TempDir;

/// Nobody waits longer for anything here.
const LONGEST: Duration = Duration::from_secs(240);
/// The patient that phantoms are written with: it must never be seen.
const PATIENT: &str = "Doe^Jane";

type Studio = Harness<'static, App>;

/// Where pictures of each step are kept.
fn pictures_folder() -> Option<PathBuf> {
    std::env::var_os("LUMIVOX_SCREENSHOTS").map(PathBuf::from)
}

/// What file dialogs say in tests.
#[derive(Clone, Default)]
struct Answers {
    next: Arc<Mutex<Vec<PathBuf>>>,
    held: Arc<Mutex<Option<Receiver<PathBuf>>>>,
}

impl Answers {
    fn next(&self, file: impl Into<PathBuf>) {
        *self.next.lock().unwrap() = vec![file.into()];
    }

    /// The next dialog stays until somebody sends what it says.
    fn hold(&self) -> Sender<PathBuf> {
        let (send, held) = channel();
        *self.held.lock().unwrap() = Some(held);
        send
    }
}

impl Chooser for Answers {
    fn ask(&self, _: &Ask, _: Language) -> Choice {
        let files = std::mem::take(&mut *self.next.lock().unwrap());
        match self.held.lock().unwrap().take() {
            Some(held) => Box::pin(async move { held.recv().into_iter().collect() }),
            None => Box::pin(async move { files }),
        }
    }
}

/// One at a time: they share two cores and a device in software.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The program as it starts, with the notice read.
fn studio() -> (Studio, Answers) {
    studio_with(Settings { has_agreed: true, ..Settings::default() })
}

fn studio_with(settings: Settings) -> (Studio, Answers) {
    launch(settings, false)
}

fn launch(settings: Settings, makes_tiles: bool) -> (Studio, Answers) {
    launch_with(Box::new(Forgetful(settings)), makes_tiles)
}

fn launch_with(drawer: Box<dyn Drawer>, makes_tiles: bool) -> (Studio, Answers) {
    let answers = Answers::default();
    let launch = Launch { open: vec![], drawer, chooser: Box::new(answers.clone()), makes_tiles };
    let mut studio = Harness::builder()
        .with_size([1360.0, 900.0])
        .with_max_steps(4)
        .renderer(renderer::Painter::new())
        .build_eframe(move |context| App::new(context, launch));
    if let Some(live) = studio.state_mut().live_mut() {
        live.set_samples(4);
        // A processor traces: films of few pixels say the same, in pictures of few where nobody looks at them.
        *live.viewport_mut().pace_mut() = Pace { moving: 20.0, resting: 40.0, most_pixels: 1 << 12 };
        live.set_most_pixels(if pictures_folder().is_some() { u32::MAX } else { 1 << 15 });
    }
    studio.step();
    (studio, answers)
}

/// Frames until something is so.
fn wait(studio: &mut Studio, what: &str, is_so: impl Fn(&App) -> bool) {
    let begin = Instant::now();
    while !is_so(studio.state()) {
        studio.step();
        let state = &studio.state().state;
        assert!(
            begin.elapsed() < LONGEST,
            "{what}: {:?} {:?} {:?}, {} tiles",
            state.busy,
            state.failed,
            state.progress,
            state.tiles.len()
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    studio.step();
}

/// Frames until nothing goes on any more.
fn settle(studio: &mut Studio) {
    // What was asked for begins with the frame after.
    studio.step();
    studio.step();
    wait(studio, "it settles", App::is_quiet);
    studio.step();
}

fn drop_files(studio: &mut Studio, files: &[&Path]) {
    let dropped =
        files.iter().map(|file| DroppedFile { path: Some(file.to_path_buf()), ..Default::default() });
    studio.input_mut().dropped_files = dropped.collect();
    studio.step();
    studio.input_mut().dropped_files.clear();
}

/// Opens files by dropping them, and waits until the scan is seen.
fn open(studio: &mut Studio, files: &[&Path]) {
    drop_files(studio, files);
    wait(studio, "it is read", |app| app.state.session.is_some());
    settle(studio);
}

/// The program with a head of so many voxels that is seen; the folder goes with the test.
fn with_head(size: usize) -> (Studio, Answers, TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let scan = head(folder.path(), size);
    let (mut studio, answers) = studio();
    open(&mut studio, &[&scan]);
    (studio, answers, folder)
}

/// What is open.
fn session(studio: &Studio) -> &Session {
    studio.state().state.session.as_ref().unwrap()
}

/// Where a view is in the window.
fn view(studio: &Studio, name: &str) -> egui::Rect {
    let all = studio.get_all_by_label(name).map(|node| node.rect());
    all.max_by(|a, b| a.area().total_cmp(&b.area())).unwrap()
}

fn press(studio: &mut Studio, at: Pos2, button: PointerButton, pressed: bool) {
    studio.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE });
    studio.step();
}

fn drag(studio: &mut Studio, button: PointerButton, from: Pos2, to: Pos2) {
    studio.event(egui::Event::PointerMoved(from));
    studio.step();
    press(studio, from, button, true);
    for share in [0.3, 0.7, 1.0] {
        studio.event(egui::Event::PointerMoved(from + (to - from) * share));
        studio.step();
    }
    press(studio, to, button, false);
    studio.step();
}

fn click_at(studio: &mut Studio, at: Pos2) {
    click_with(studio, at, PointerButton::Primary);
}

fn click_with(studio: &mut Studio, at: Pos2, button: PointerButton) {
    studio.event(egui::Event::PointerMoved(at));
    studio.step();
    press(studio, at, button, true);
    press(studio, at, button, false);
    studio.run_steps(2);
}

/// A command back, by its keys.
fn undo(studio: &mut Studio) {
    studio.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    studio.run_steps(2);
}

/// A head as a DICOM series in a folder.
fn head(folder: &Path, size: usize) -> PathBuf {
    let volume =
        anatomy(AnatomyOptions { size, ..Default::default() }, Progress::SILENT, &CancelToken::new());
    let scan = folder.join("scan");
    let series = SeriesDescription { patient_name: PATIENT.into(), ..SeriesDescription::default() };
    write_dicom_series(&volume.unwrap(), &scan, &series, Progress::SILENT, &CancelToken::new()).unwrap();
    scan
}

/// The window as it is seen.
struct Seen {
    size: [u32; 2],
    rgba: Vec<u8>,
}

impl Seen {
    /// The colour at a place of the window.
    fn color(&self, at: Pos2) -> [u8; 4] {
        let place = 4 * (at.y as usize * self.size[0] as usize + at.x as usize);
        self.rgba[place..place + 4].try_into().unwrap()
    }

    /// How bright a part of the window is on the whole, 0 to 255.
    fn mean(&self, part: egui::Rect) -> f64 {
        let pixels = |low: f32, high: f32, size: u32| {
            let [low, high] = [low, high].map(|n| n.clamp(0.0, size as f32) as usize);
            low..high
        };
        let [width, height] = self.size;
        let columns = pixels(part.min.x, part.max.x, width);
        let (mut sum, mut count) = (0.0, 0.0);
        for y in pixels(part.min.y, part.max.y, height) {
            for x in columns.clone() {
                let place = 4 * (y * width as usize + x);
                sum += self.rgba[place..place + 3].iter().map(|c| f64::from(*c)).sum::<f64>() / 3.0;
                count += 1.0;
            }
        }
        sum / f64::max(count, 1.0)
    }
}

/// The window as it is seen; kept where somebody wants to look.
fn screenshot(studio: &mut Studio, name: &str) -> Seen {
    let state = studio.state_mut().live_mut().unwrap().render_state().clone();
    let (width, height, rgba) = pixels::draw(&state, &studio.ctx, studio.output());
    if let Some(folder) = pictures_folder() {
        std::fs::create_dir_all(&folder).unwrap();
        let file = std::fs::File::create(folder.join(name).with_extension("png")).unwrap();
        let mut encoder = png::Encoder::new(file, width, height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.write_header().unwrap().write_image_data(&rgba).unwrap();
    }
    Seen { size: [width, height], rgba }
}

/// Everything that can be read in the window.
fn texts(studio: &Studio) -> Vec<String> {
    let mut found = vec![];
    for node in studio.root().children_recursive() {
        found.extend(node.accesskit_node().label());
        found.extend(node.accesskit_node().value());
    }
    found
}

fn says(studio: &Studio, words: &str) -> bool {
    texts(studio).iter().any(|text| text.contains(words))
}

fn click(studio: &mut Studio, label: &str) {
    // A dialog moves in the frame after its contents grew; nobody's hand is faster than that.
    let (begin, mut before) = (Instant::now(), None);
    loop {
        assert!(begin.elapsed() < LONGEST, "'{label}' does not stand still");
        let found: Vec<_> = studio.query_all_by_label(label).collect();
        let Some(node) = found.last() else { panic!("there is no '{label}' among {:?}", texts(studio)) };
        let now = node.rect();
        if before.replace(now) == Some(now) {
            node.click();
            break;
        }
        studio.step();
    }
    // Down, up, what is asked for, what comes of it.
    studio.run_steps(4);
}

/// Where `name` of the shared scans is; `None` where they are absent, of which one line is said.
fn shared(name: &str) -> Option<PathBuf> {
    static SAID: Once = Once::new();
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    let path = std::env::var_os("LUMIVOX_TEST_SCANS").map_or(PathBuf::from(beside), PathBuf::from).join(name);
    if path.exists() {
        return Some(path);
    }
    SAID.call_once(|| {
        let _ = writeln!(
            std::io::stderr(),
            "real scans are absent ({}): tests of them check nothing",
            path.display()
        );
    });
    None
}
