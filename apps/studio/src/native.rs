//! The Studio as a program of a desktop: window, file dialogs, settings in a file, the command line.

use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;

use eframe::egui::{IconData, Vec2, ViewportBuilder, vec2};
use eframe::wgpu;
use lumivox_import::CodecWorker;
use lumivox_wgpu::Gpu;
use rfd::{AsyncFileDialog, FileHandle};

use crate::app::{App, Choice, Chooser, Launch};
use crate::settings::{Drawer, Settings};
use crate::state::Ask;
use crate::words::{Language, Word};

const USAGE: &str = "\
Usage: lumivox-studio [SCAN or SCENE]...

Opens files or a folder of a scan, or a scene file (.lumivox, .json).
Not a medical device. Education, research and illustration only.";

/// The first argument of this program where it is a decoder for another run of it, which survives its crashes.
const CODEC_WORKER: &str = "--codec-worker";

/// Runs until the window is closed.
pub fn main() -> ExitCode {
    if std::env::args_os().nth(1).is_some_and(|first| first == CODEC_WORKER) {
        // What a decoder panics about, the other end hears as a damaged frame.
        std::panic::set_hook(Box::new(|_| {}));
        let served = lumivox_import::serve_codecs(std::io::stdin().lock(), std::io::stdout().lock());
        return if served.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    }
    if let Ok(program) = std::env::current_exe() {
        lumivox_import::set_codec_worker(Some(CodecWorker::new(program, [CODEC_WORKER])));
    }
    let mut open = vec![];
    for argument in std::env::args_os().skip(1) {
        match argument.to_str() {
            Some("--help" | "-h") => {
                println!("{USAGE}");
                return ExitCode::SUCCESS;
            }
            Some("--version" | "-V") => {
                println!("lumivox-studio {}", env!("CARGO_PKG_VERSION"));
                return ExitCode::SUCCESS;
            }
            Some(option) if option.starts_with("--") => {
                eprintln!("there is no option '{option}'\n\n{USAGE}");
                return ExitCode::from(2);
            }
            _ => open.push(PathBuf::from(argument)),
        }
    }
    let options = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_inner_size([1440.0, 900.0])
            .with_min_inner_size([980.0, 620.0])
            .with_title("Lumivox Studio")
            .with_app_id("lumivox-studio")
            .with_icon(icon())
            .with_drag_and_drop(true),
        wgpu_options: crate::gpu_options(),
        ..Default::default()
    };
    let launch =
        Launch { open, drawer: Box::new(SettingsFile), chooser: Box::new(Desktop), makes_tiles: true };
    let create: eframe::AppCreator<'_> = Box::new(|context| Ok(Box::new(App::new(context, launch))));
    match eframe::run_native("Lumivox Studio", options, create) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let why = format!(
                "{error}\nA Vulkan, Direct3D 12 or Metal driver is needed; 'lumivox doctor' says what to install."
            );
            eprintln!("{why}");
            // There it has no console.
            #[cfg(windows)]
            rfd::MessageDialog::new()
                .set_level(rfd::MessageLevel::Error)
                .set_title("Lumivox Studio")
                .set_description(&why)
                .show();
            ExitCode::FAILURE
        }
    }
}

/// Of the devices that show the window the one that the command would take, which was tried where there are several.
///
/// # Errors
/// Where none shows it.
pub fn choose_adapter(
    adapters: &[wgpu::Adapter],
    window: Option<&wgpu::Surface<'_>>,
) -> Result<wgpu::Adapter, String> {
    let shows = |adapter: &&wgpu::Adapter| window.is_none_or(|window| adapter.is_surface_supported(window));
    let mut able: Vec<&wgpu::Adapter> = adapters.iter().filter(shows).collect();
    if able.len() > 1
        && let Ok(gpu) = Gpu::open(None)
    {
        let (name, backend) = (gpu.description.name, gpu.description.backend);
        let is_best = |info: wgpu::AdapterInfo| info.name == name && format!("{:?}", info.backend) == backend;
        able.sort_by_key(|adapter| !is_best(adapter.get_info()));
    }
    able.first().map(|adapter| (*adapter).clone()).ok_or_else(|| "no driver shows windows here".to_owned())
}

/// The window's icon, as `web/icon.svg` draws it: a cube's edges on a plate.
fn icon() -> IconData {
    const SIZE: u32 = 128;
    /// In the units of the drawing, which is 64 of them wide.
    const WIDTH: f32 = 1.6;
    let outline = [[32.0, 10.0], [51.0, 21.0], [51.0, 43.0], [32.0, 54.0], [13.0, 43.0], [13.0, 21.0]];
    let inner = [[[13.0, 21.0], [32.0, 32.0]], [[32.0, 32.0], [51.0, 21.0]], [[32.0, 32.0], [32.0, 54.0]]];
    let edges: Vec<_> = (0..6).map(|i| [outline[i], outline[(i + 1) % 6]]).collect();
    let far = |at: Vec2, [from, to]: [[f32; 2]; 2]| {
        let (from, to) = (Vec2::from(from), Vec2::from(to));
        let along = ((at - from).dot(to - from) / (to - from).length_sq()).clamp(0.0, 1.0);
        (at - from - along * (to - from)).length()
    };
    let nearest = |at: Vec2, lines: &[[[f32; 2]; 2]]| {
        lines.iter().map(|line| far(at, *line)).fold(f32::INFINITY, f32::min)
    };
    let scale = 64.0 / SIZE as f32;
    // How much of a pixel lies within, by how far its middle is from the edge.
    let cover = |distance: f32| (0.5 - distance / scale).clamp(0.0, 1.0);
    let pixel = |i: u32| {
        let at = vec2((i % SIZE) as f32 + 0.5, (i / SIZE) as f32 + 0.5) * scale;
        let beyond = (at - Vec2::splat(32.0)).abs() - Vec2::splat(20.0);
        let plate = beyond.max(Vec2::ZERO).length() + beyond.max_elem().min(0.0) - 12.0;
        let layers =
            [(nearest(at, &edges), [223.0, 228.0, 234.0]), (nearest(at, &inner), [90.0, 176.0, 240.0])];
        let mut color = [20.0, 23.0, 28.0_f32];
        for (distance, own) in layers {
            let share = cover(distance - WIDTH);
            for (channel, own) in color.iter_mut().zip(own) {
                *channel += share * (own - *channel);
            }
        }
        let [r, g, b] = color.map(|channel| channel.round() as u8);
        [r, g, b, (255.0 * cover(plate)).round() as u8]
    };
    IconData { rgba: (0..SIZE * SIZE).flat_map(pixel).collect(), width: SIZE, height: SIZE }
}

/// The desktop's own file dialogs.
struct Desktop;

impl Chooser for Desktop {
    fn ask(&self, ask: &Ask, language: Language) -> Choice {
        let paths = |files: Vec<FileHandle>| files.iter().map(|file| file.path().to_owned()).collect();
        let one = |file: Option<FileHandle>| file.map(|file| file.path().to_owned()).into_iter().collect();
        let titled = |word: Word| AsyncFileDialog::new().set_title(word.of(language));
        match ask {
            Ask::Files => {
                let choice = titled(Word::OpenFiles).pick_files();
                Box::pin(async move { choice.await.map_or_else(Vec::new, paths) })
            }
            Ask::Folder => {
                let choice = titled(Word::OpenFolder).pick_folder();
                Box::pin(async move { one(choice.await) })
            }
            Ask::SaveScene(name) => {
                let dialog = titled(Word::SaveScene).add_filter("Lumivox", &["lumivox", "json"]);
                let choice = dialog.set_file_name(name).save_file();
                Box::pin(async move { one(choice.await) })
            }
            Ask::Light => {
                let dialog = titled(Word::EnvironmentFile).add_filter("HDR, EXR", &["hdr", "exr"]);
                let choice = dialog.pick_file();
                Box::pin(async move { one(choice.await) })
            }
            Ask::Labels => {
                let choice = titled(Word::StructuresOpen).pick_files();
                Box::pin(async move { choice.await.map_or_else(Vec::new, paths) })
            }
            Ask::LabelFolder => {
                let choice = titled(Word::StructuresFolder).pick_folder();
                Box::pin(async move { one(choice.await) })
            }
            Ask::SaveTable(name) => {
                let dialog = titled(Word::SaveTable).add_filter("CSV", &["csv"]);
                let choice = dialog.set_file_name(name).save_file();
                Box::pin(async move { one(choice.await) })
            }
            Ask::SavePage(name, _) => {
                let dialog = titled(Word::ShareTitle).add_filter("HTML", &["html"]);
                let choice = dialog.set_file_name(name).save_file();
                Box::pin(async move { one(choice.await) })
            }
            Ask::SavePicture(name) | Ask::SaveTurn(name, _) => {
                let dialog = titled(Word::SavePicture).add_filter("PNG", &["png"]);
                let choice = dialog.set_file_name(name).save_file();
                Box::pin(async move { one(choice.await) })
            }
        }
    }
}

/// Settings in the folder where the system keeps such.
struct SettingsFile;

impl SettingsFile {
    fn path() -> Option<PathBuf> {
        Some(Self::folder("APPDATA", ("XDG_CONFIG_HOME", ".config"))?.join("studio.json"))
    }

    /// Our folder where the system keeps such things: by what Windows calls the place, and what others do, or have in the home.
    fn folder(windows: &str, (xdg, in_home): (&str, &str)) -> Option<PathBuf> {
        let of = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let folder = if cfg!(windows) {
            of(windows)
        } else if cfg!(target_os = "macos") {
            of("HOME").map(|home| home.join("Library/Application Support"))
        } else {
            of(xdg).or_else(|| of("HOME").map(|home| home.join(in_home)))
        };
        folder.map(|folder| folder.join("lumivox"))
    }
}

impl Drawer for SettingsFile {
    fn archive_folder(&self) -> Option<PathBuf> {
        // Images are no settings, which move with a person from machine to machine.
        Some(Self::folder("LOCALAPPDATA", ("XDG_DATA_HOME", ".local/share"))?.join("archive"))
    }

    fn rescue_folder(&self) -> Option<PathBuf> {
        Some(Self::path()?.with_file_name("unsaved"))
    }

    fn read(&self) -> Option<Settings> {
        serde_json::from_slice(&fs::read(Self::path()?).ok()?).ok()
    }

    fn write(&self, settings: &Settings) {
        let write = || -> Option<()> {
            let path = Self::path()?;
            fs::create_dir_all(path.parent()?).ok()?;
            fs::write(&path, serde_json::to_vec_pretty(settings).ok()?).ok()
        };
        // What cannot be kept is asked again next time.
        let _ = write();
    }
}
