//! What the interface takes of a frame, and how soon a scan is seen:
//! `cargo bench -p lumivox-studio --bench interface [VOXELS] [WIDTHxHEIGHT]`, or `out/bench/interface` of `script/bench`.
//!
//! The whole program without a window: each frame is laid out, painted into a texture and waited for. For screen readers, too,
//! which a desktop asks for only where there is one.

#[path = "../tests/studio/renderer.rs"]
mod renderer;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use eframe::egui::{self, DroppedFile, Event, Key, Modifiers, PointerButton};
use eframe::wgpu;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use lumivox_core::{CancelToken, Preset, Progress};
use lumivox_phantom::{AnatomyOptions, SeriesDescription, anatomy, write_dicom_series};
use lumivox_studio::app::{App, Choice, Chooser, Launch};
use lumivox_studio::settings::{Forgetful, Settings};
use lumivox_studio::state::Ask;
use lumivox_studio::words::{Language, Word};

const FRAMES: usize = 120;
/// Nobody waits longer for anything here.
const LONGEST: Duration = Duration::from_secs(300);

struct Nobody;

impl Chooser for Nobody {
    fn ask(&self, _: &Ask, _: Language) -> Choice {
        Box::pin(async { vec![] })
    }
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let voxels = words.iter().find_map(|word| word.parse().ok()).unwrap_or(512);
    let size = words.iter().find_map(|word| {
        let (width, height) = word.split_once('x')?;
        Some([width.parse().ok()?, height.parse().ok()?])
    });
    let size: [f32; 2] = size.unwrap_or([1920.0, 1080.0]);
    let mut bench = Bench::new(size);
    println!("{}, {} x {}", bench.gpu(), size[0], size[1]);

    let folder = tempfile::tempdir().expect("a folder for the scan");
    let scan = folder.path().join("scan");
    let options = AnatomyOptions { size: voxels, ..Default::default() };
    let head = anatomy(options, Progress::SILENT, &CancelToken::new()).expect("nobody cancels");
    let series = SeriesDescription::default();
    write_dicom_series(&head, &scan, &series, Progress::SILENT, &CancelToken::new())
        .expect("room for the scan");
    drop(head);

    println!("{:<44} {:>8} {:>8} {:>8} {:>8}", "frames, ms", "median", "95%", "longest", "laid out");
    bench.times("nothing open", |_, _| ());
    bench.open(scan);
    bench.times("at rest", |_, _| ());
    let three_d = bench.view("3D").center();
    bench.pointer(three_d, true);
    bench.times("the scan turns", |bench, frame| {
        // Round and round: no two frames see the same.
        let angle = frame as f32 * 0.1;
        bench.studio.event(Event::PointerMoved(three_d + 80.0 * egui::vec2(angle.cos(), angle.sin())));
    });
    bench.pointer(three_d, false);
    bench.rest();
    // Keys are for the view that was clicked.
    let axial = bench.view("Axial").center();
    bench.pointer(axial, true);
    bench.pointer(axial, false);
    bench.rest();
    bench.times("slices pass by", |bench, frame| {
        let key = if frame % 24 < 12 { Key::ArrowUp } else { Key::ArrowDown };
        bench.studio.event(Event::Key {
            key,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers: Modifiers::NONE,
        });
    });
    bench.rest();
    let looks = [Preset::CtSkin, Preset::CtMuscle, Preset::CtBone];
    bench.times("another look in each frame", |bench, frame| {
        let session = bench.studio.state_mut().state.session.as_mut().expect("a scan is open");
        session.change(Word::Looks, |document| document.volumes[0].look.preset = Some(looks[frame % 3]));
    });
}

struct Bench {
    studio: Harness<'static, App>,
    target: wgpu::TextureView,
}

impl Bench {
    fn new([width, height]: [f32; 2]) -> Self {
        let settings = Settings { has_agreed: true, ..Settings::default() };
        let launch = Launch {
            open: vec![],
            drawer: Box::new(Forgetful(settings)),
            chooser: Box::new(Nobody),
            makes_tiles: false,
        };
        let mut studio = Harness::builder()
            .with_size([width, height])
            .renderer(renderer::Painter::new())
            .build_eframe(move |context| App::new(context, launch));
        let state = studio.state_mut().live_mut().expect("a device").render_state().clone();
        let target = renderer::target(&state, [width as u32, height as u32]).create_view(&Default::default());
        Self { studio, target }
    }

    fn gpu(&mut self) -> String {
        self.studio.state_mut().live_mut().map_or_else(String::new, |live| live.gpu_name().to_owned())
    }

    /// A frame; how long it took, and its layout alone.
    fn frame(&mut self) -> [Duration; 2] {
        let begin = Instant::now();
        self.studio.step();
        let laid_out = begin.elapsed();
        let state = self.studio.state_mut().live_mut().expect("a device").render_state().clone();
        renderer::paint(&state, &self.studio.ctx, self.studio.output(), &self.target);
        state.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device");
        [begin.elapsed(), laid_out]
    }

    /// Prints what frames take before each of which something happens.
    fn times(&mut self, name: &str, mut happens: impl FnMut(&mut Self, usize)) {
        let mut all = vec![];
        for frame in 0..FRAMES {
            happens(self, frame);
            all.push(self.frame().map(|time| time.as_secs_f64() * 1e3));
        }
        let sorted = |which: usize| {
            let mut times: Vec<f64> = all.iter().map(|times| times[which]).collect();
            times.sort_by(f64::total_cmp);
            times
        };
        let [whole, laid_out] = [0, 1].map(sorted);
        println!(
            "{name:<44} {:>8.2} {:>8.2} {:>8.2} {:>8.2}",
            whole[FRAMES / 2],
            whole[FRAMES * 95 / 100],
            whole[FRAMES - 1],
            laid_out[FRAMES / 2]
        );
    }

    /// Drops a scan, and prints when what of it was seen.
    fn open(&mut self, scan: PathBuf) {
        self.studio.input_mut().dropped_files = vec![DroppedFile { path: Some(scan), ..Default::default() }];
        let begin = Instant::now();
        let mut longest = self.frame()[0];
        self.studio.input_mut().dropped_files.clear();
        let (mut slices, mut picture) = (None, None);
        while picture.is_none() {
            longest = longest.max(self.frame()[0]);
            let state = &self.studio.state().state;
            assert!(state.failed.is_none() && begin.elapsed() < LONGEST, "{:?}", state.failed);
            slices = slices.or_else(|| state.session.as_ref().map(|_| begin.elapsed()));
            picture = (state.session.is_some() && state.progress.is_shown).then(|| begin.elapsed());
        }
        let seconds = |time: Option<Duration>| time.unwrap_or_default().as_secs_f64();
        println!(
            "opened: slices after {:.2} s, a path-traced picture after {:.2} s; the longest frame until then {:.0} ms",
            seconds(slices),
            seconds(picture),
            longest.as_secs_f64() * 1e3
        );
        self.rest();
    }

    /// Frames until nothing goes on any more.
    fn rest(&mut self) {
        let begin = Instant::now();
        while !(self.studio.state().is_quiet() && self.studio.state().state.progress.rests) {
            self.frame();
            assert!(begin.elapsed() < LONGEST, "it does not come to rest");
        }
    }

    /// Where a view is in the window.
    fn view(&self, name: &str) -> egui::Rect {
        let all = self.studio.get_all_by_label(name).map(|node| node.rect());
        all.max_by(|a, b| a.area().total_cmp(&b.area())).expect("a view")
    }

    fn pointer(&mut self, at: egui::Pos2, pressed: bool) {
        self.studio.event(Event::PointerMoved(at));
        self.frame();
        let button = PointerButton::Primary;
        self.studio.event(Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE });
        self.frame();
    }
}
