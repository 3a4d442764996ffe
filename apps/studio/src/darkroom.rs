//! Stills beside the interface: looks as tiles of this scan, and pictures for files. On a device of its own, so that the view goes on.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lumivox_core::document::{Backdrop, Film, SceneDocument, View};
use lumivox_core::{Modality, PerspectiveCamera, Preset, Scene, Volume, Voxels};
use lumivox_renderer::{DisplaySettings, display};
use lumivox_wgpu::{Gpu, HeadlessRenderer, Outcome, RenderRequest};
use rayon::prelude::*;

use crate::files;
use crate::grid::Grid;
use crate::jobs::{Busy, Desk};
use crate::opening::show;
use crate::words::{Language, Word};

/// The side of a look's tile, in pixels.
pub const TILE: u32 = 96;
/// Samples of its pixels: enough for a small picture that is smoothed.
const TILE_SAMPLES: u32 = 16;
/// Voxels along the longest edge of the scan that tiles are made of.
pub(crate) const TILE_VOXELS: usize = 80;

/// The device that stills are made on, opened when the first is wanted. One at a time.
#[derive(Clone, Default)]
pub struct Darkroom(Arc<Mutex<Option<Gpu>>>);

impl Darkroom {
    fn enter(&self) -> Result<MutexGuard<'_, Option<Gpu>>, String> {
        let mut room = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if room.is_none() {
            let name = std::env::var("LUMIVOX_GPU").ok();
            *room = Some(Gpu::open(name.as_deref()).map_err(|error| error.to_string())?);
        }
        Ok(room)
    }
}

/// A picture of eight bits a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Red, green, blue and straight alpha, rows from the top.
    pub rgba: Vec<u8>,
}

/// A look's tile.
pub struct Tile {
    /// Which look it is.
    pub preset: Preset,
    /// How this scan looks in it.
    pub picture: Picture,
}

/// The looks that may suit a scan, those of its modality first.
pub fn looks_for(volume: &Volume) -> Vec<Preset> {
    let of = |prefix: &str| -> Vec<Preset> {
        Preset::ALL.into_iter().filter(|preset| preset.name().starts_with(prefix)).collect()
    };
    let mut looks = match volume.modality() {
        Modality::Ct => of("ct-"),
        Modality::Mr => of("mr-"),
        Modality::Pet => of("pet-"),
        Modality::Other => vec![Preset::SignedMap],
    };
    let own = Preset::default_for(volume);
    looks.retain(|look| *look != own);
    looks.insert(0, own);
    if own != Preset::Plain {
        looks.push(Preset::Plain);
    }
    looks
}

/// Makes a tile of each of these looks, one after the other; tells them as they come.
pub fn develop_tiles(
    room: &Darkroom,
    document: &SceneDocument,
    scan: &Arc<Volume>,
    looks: Vec<Preset>,
    desk: &Desk<Tile>,
) {
    let small = Arc::new(reduced(scan, TILE_VOXELS, usize::MAX));
    let total = looks.len() as u64;
    for (done, preset) in (0..).zip(looks) {
        desk.report(Busy { stage: None, done, total });
        if desk.cancel().is_cancelled() {
            return;
        }
        // A look that cannot be shown has no tile, and says why when it is chosen.
        if let Ok(picture) = tile(room, document, &small, preset, desk) {
            desk.tell(Tile { preset, picture });
        }
    }
}

fn tile(
    room: &Darkroom,
    document: &SceneDocument,
    small: &Arc<Volume>,
    preset: Preset,
    desk: &Desk<Tile>,
) -> Result<Picture, String> {
    let document = tile_document(document, preset);
    let (scene, _) = show(&document, vec![small.clone()], desk)?;
    let camera = document.camera.camera(&scene, 1.0).ok_or("there is nothing to see")?;
    let mut on_progress =
        |_: f32| desk.cancel().check().map_or(ControlFlow::Break(()), |()| ControlFlow::Continue(()));
    develop(room, &document, &scene, &camera, &mut on_progress).map(|still| still.picture)
}

/// What a look's tile shows of a document: its first scan, whole, in the usual light.
pub(crate) fn tile_document(document: &SceneDocument, preset: Preset) -> SceneDocument {
    let mut document = document.clone();
    document.volumes.truncate(1);
    for entry in &mut document.volumes {
        entry.look = lumivox_core::document::Look::of_preset(preset);
        (entry.labels, entry.clip, entry.peel) = (None, None, None);
        entry.clip_shapes.clear();
        entry.lassos.clear();
        entry.world_from_patient = None;
    }
    document.environment = Default::default();
    document.lights.clear();
    document.camera = View { azimuth: Some(25.0), elevation: Some(6.0), ..View::default() };
    document.film.size = [TILE; 2];
    (document.film.samples, document.film.denoise) = (Some(TILE_SAMPLES), true);
    document
}

/// The same scan of fewer voxels: means of neighbours, of so many along each axis at most.
pub(crate) fn reduced(volume: &Volume, side: usize, most: usize) -> Volume {
    let grid = Grid::of(volume, side);
    if grid.is_whole() {
        return volume.clone().without_source();
    }
    let mean = |index: usize| {
        let all = grid.within(index, most);
        let (sum, count) =
            all.fold((0.0, 0.0), |(sum, count), voxel| (sum + volume.value(voxel), count + 1.0));
        (sum / count) as f32
    };
    let values = (0..grid.count()).into_par_iter().map(mean).collect();
    let place = grid.patient_from_voxel;
    let new = Volume::new(grid.dims, Voxels::F32(values), [1.0, 0.0], place, volume.modality());
    let new = new.map(|new| new.with_unit(volume.unit().to_owned()).with_subject(volume.subject()));
    // What has no means, such as values that are no numbers, is taken as it is.
    new.unwrap_or_else(|_| volume.clone().without_source())
}

/// A picture, and whether it is of a coarser scan.
pub(crate) struct Still {
    pub picture: Picture,
    pub is_reduced: bool,
}

/// Renders what a document says, as the command does: the same pixels.
pub(crate) fn develop(
    room: &Darkroom,
    document: &SceneDocument,
    scene: &Scene,
    camera: &PerspectiveCamera,
    on_progress: &mut dyn FnMut(f32) -> ControlFlow<()>,
) -> Result<Still, String> {
    let mut room = room.enter()?;
    let gpu = room.as_mut().ok_or("there is no GPU")?;
    let film = document.film;
    let [width, height] = film.size;
    let samples = film.samples.unwrap_or(DEFAULT_SAMPLES);
    let request = RenderRequest::new(width, height, samples).with(|it| {
        it.seed = film.seed;
        it.noise = film.noise;
        it.guides = film.denoise;
    });
    let mut renderer = HeadlessRenderer::new(gpu);
    let rendered = renderer.render(gpu, scene, camera, &request, &mut |progress| {
        on_progress((progress.samples / f64::from(progress.target.max(1))) as f32)
    });
    renderer.free(gpu);
    let rendered = match rendered {
        Ok(rendered) => rendered,
        Err(error) => {
            // A device that failed is opened anew for the next picture.
            *room = None;
            return Err(error.to_string());
        }
    };
    match rendered.outcome {
        Outcome::Complete | Outcome::TimeUp => {}
        Outcome::Stopped => return Err(lumivox_core::Cancelled.to_string()),
        Outcome::Failed(error) => {
            *room = None;
            return Err(error.to_string());
        }
    }
    let traced = if film.denoise { rendered.film.denoised() } else { rendered.film };
    let pixels = DisplaySettings::from(&document.display).pixels(&traced, &scene.environment, camera);
    let mut rgba = pixels.into_flattened();
    if let Backdrop::Color(color) = document.display.background {
        display::put_on(&mut rgba, color);
    }
    let is_reduced = rendered.reductions.iter().any(|factor| *factor > 1);
    Ok(Still { picture: Picture { size: film.size, rgba }, is_reduced })
}

/// Samples of a picture that does not say how many, as the command has it.
pub const DEFAULT_SAMPLES: u32 = 512;

/// A picture that is about to be rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExportDraft {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Paths of a pixel.
    pub samples: u32,
    /// Whether it has an alpha channel.
    pub transparent: bool,
    /// Whether the noise that is left is smoothed.
    pub denoise: bool,
    /// Whether it is a turn around the scan, in so many pictures.
    pub turn: Option<u32>,
}

impl ExportDraft {
    /// Of a document; as large as the view, where it was never said how large.
    pub fn of(document: &SceneDocument, view: [u32; 2]) -> Self {
        let film = document.film;
        Self {
            size: if film.size == Film::default().size { view } else { film.size },
            samples: film.samples.unwrap_or(DEFAULT_SAMPLES),
            transparent: document.display.background == Backdrop::Transparent,
            denoise: film.denoise,
            turn: None,
        }
    }

    /// Says it in the document, so that the command renders the same.
    pub fn put_into(self, document: &mut SceneDocument) {
        document.film.size = self.size;
        document.film.samples = Some(self.samples);
        document.film.denoise = self.denoise;
        let is_transparent = document.display.background == Backdrop::Transparent;
        if self.transparent != is_transparent {
            document.display.background =
                if self.transparent { Backdrop::Transparent } else { Backdrop::default() };
        }
    }
}

/// What becomes of a picture.
pub enum Exported {
    /// It is written; something may be worth telling.
    Written(Option<Word>),
    /// The pictures of a turn are.
    Turned {
        /// How many.
        steps: u32,
        /// Whether they are of a coarser scan.
        is_reduced: bool,
        /// Whether there is a film of them.
        has_film: bool,
    },
    /// Why it is not.
    Failed(String),
}

/// The file of a turn's step: `head-007.png` of `head.png`.
pub fn step_file(file: &Path, step: u32) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    file.with_file_name(format!("{stem}-{step:03}.png"))
}

/// The file of a turn's film.
pub fn film_file(file: &Path) -> PathBuf {
    file.with_extension("mp4")
}

/// Renders a picture and writes it: whole, or not at all.
pub fn export(
    room: &Darkroom,
    document: &SceneDocument,
    scene: &Scene,
    camera: &PerspectiveCamera,
    file: &Path,
    desk: &Desk<Exported>,
) {
    let mut on_progress = |part: f32| {
        desk.report(Busy { stage: None, done: (part * 1000.0) as u64, total: 1000 });
        desk.cancel().check().map_or(ControlFlow::Break(()), |()| ControlFlow::Continue(()))
    };
    let developed = develop(room, document, scene, camera, &mut on_progress);
    if desk.cancel().is_cancelled() {
        return;
    }
    desk.tell(match developed.and_then(|still| keep(file, &still.picture).map(|()| still.is_reduced)) {
        Ok(is_reduced) => Exported::Written(is_reduced.then_some(Word::Reduced)),
        Err(why) => Exported::Failed(why),
    });
}

/// Keeps a picture, with what it is not for.
///
/// # Errors
/// A sentence that names the file.
pub fn keep(file: &Path, picture: &Picture) -> Result<(), String> {
    files::save(file, &mut |out| {
        let [width, height] = picture.size;
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.add_text_chunk("Software".into(), "Lumivox Studio".into())?;
        encoder.add_text_chunk("Disclaimer".into(), Word::NoDevice.of(Language::English).into())?;
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&picture.rgba)?;
        Ok(writer.finish()?)
    })
}
