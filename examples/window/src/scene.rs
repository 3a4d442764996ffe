//! What is shown: a scene document, a scan as it looks by itself, or a head that nobody scanned; and the way back to a file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lumivox_core::camera::Orbit;
use lumivox_core::document::{Entry, Scan, SceneDocument, View};
use lumivox_core::glam::DVec3;
use lumivox_core::{CancelToken, PerspectiveCamera, Preset, Progress, Scene, framing};
use lumivox_phantom::{AnatomyOptions, anatomy};
use lumivox_scene::{Audience, Note, Opening};

use crate::Fallible;

/// A scene and where it is seen from.
pub struct Opened {
    pub scene: Scene,
    pub camera: PerspectiveCamera,
    /// What it came from: how it is rendered and displayed elsewhere.
    document: SceneDocument,
}

impl Opened {
    /// Reads what a path leads to; without one, a head as its CT would be. For a thread of its own.
    pub fn read(path: Option<&Path>) -> Result<Self, String> {
        let Some(path) = path else { return Ok(Self::head()) };
        let of_document = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let mut document = SceneDocument { volumes: vec![Entry::new(Scan::default())], ..Default::default() };
        let mut folder = PathBuf::new();
        let is_document = path.is_file() && path.extension().is_some_and(|e| e == "lumivox" || e == "json");
        if is_document {
            let written = lumivox_scene::read(path).map_err(|error| error.to_string())?;
            (document, folder) = (written.document.clone(), written.folder().to_owned());
        } else {
            document.volumes[0].scan.files = vec![path.to_owned()];
        }
        let opened =
            lumivox_scene::open(&document, &folder, &Opening::default(), &Terminal, &CancelToken::new());
        let lumivox_scene::Opened { scene, camera } =
            opened.map_err(|error| if is_document { of_document(&error) } else { error.to_string() })?;
        Ok(Self { scene, camera, document })
    }

    fn head() -> Self {
        let options = AnatomyOptions { size: 160, ..Default::default() };
        let volume =
            Arc::new(anatomy(options, Progress::SILENT, &CancelToken::new()).expect("nobody cancels"));
        let scene = Scene::with_volume(volume.clone(), Preset::CtMuscle.medium(&volume));
        let camera = framing::frame(&scene, 0.45, 0.08, 0.5, 4.0 / 3.0).camera();
        Self { scene, camera, document: SceneDocument::default() }
    }

    /// Writes what is seen as a scene document, which the command, Python and the engines open.
    pub fn save(&self, file: &Path, [width, height]: [u32; 2]) -> Fallible {
        let mut document = SceneDocument::of(&self.scene)?;
        document.camera = View::of(&self.camera);
        document.film = self.document.film;
        document.film.size = [width, height];
        document.display = self.document.display;
        Ok(lumivox_scene::save(&document, file)?)
    }

    /// The camera as one that turns around what there is to see.
    pub fn orbit(&self) -> Orbit {
        let PerspectiveCamera { world_from_camera, vertical_fov } = self.camera;
        let eye = world_from_camera.translation;
        let back = (world_from_camera.matrix3 * DVec3::Z).normalize();
        let center = framing::frame(&self.scene, 0.0, 0.0, vertical_fov, 1.0).target;
        // What is seen in the middle, about as far away as the scan is.
        let distance = (eye - center).dot(back).max(0.01);
        Orbit {
            target: eye - distance * back,
            azimuth: back.x.atan2(back.z),
            elevation: back.y.clamp(-1.0, 1.0).asin(),
            distance,
            vertical_fov,
        }
    }
}

/// What is told goes to the terminal.
struct Terminal;

impl Audience for Terminal {
    fn note(&self, note: Note) {
        eprintln!("note: {}", note.text);
    }

    fn say(&self, line: &str) {
        eprintln!("{line}");
    }

    fn watch<T>(&self, work: impl FnOnce(Progress<'_>) -> T) -> T {
        work(Progress::SILENT)
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use lumivox_phantom::SeriesDescription;
    use lumivox_renderer::Film;
    use lumivox_testing::hosts;
    use lumivox_wgpu::{Gpu, RenderRequest};

    use super::*;

    /// A scene's film: equal ones are equal pictures.
    fn rendered(gpu: &mut Gpu, file: &Path) -> Film {
        let Opened { scene, camera, document } = Opened::read(Some(file)).unwrap();
        let [width, height] = document.film.size;
        let request = RenderRequest::new(width, height, document.film.samples.unwrap())
            .with(|it| it.seed = document.film.seed);
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        lumivox_wgpu::render(gpu, &scene, &camera, &request, go_on).unwrap().film
    }

    /// What a person does: opens a scene, turns it, and saves it. And every host's scene, saved as it is.
    #[test]
    fn a_scene_of_every_hosts_is_the_same_picture_saved_here() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let options = AnatomyOptions { size: hosts::SCAN_SIZE, ..Default::default() };
        let head = anatomy(options, Progress::SILENT, &CancelToken::new()).unwrap();
        let (series, silent) = (SeriesDescription::default(), Progress::SILENT);
        lumivox_phantom::write_dicom_series(&head, &at(hosts::SCAN), &series, silent, &CancelToken::new())
            .unwrap();
        hosts::copy_scenes(folder.path());
        let mut turned = Opened::read(Some(&at("command.lumivox"))).unwrap();
        let mut orbit = turned.orbit();
        orbit.azimuth -= 0.5;
        orbit.distance *= 0.9;
        turned.camera = orbit.camera();
        turned.save(&at("own.lumivox"), turned.document.film.size).unwrap();
        hosts::assert_written("window", &at("own.lumivox"));
        let name = std::env::var("LUMIVOX_GPU").ok();
        let mut gpu = Gpu::open(name.as_deref()).expect("a GPU or software Vulkan");
        for host in hosts::HOSTS {
            let (scene, again) = (at(&format!("{host}.lumivox")), at(&format!("of-{host}.lumivox")));
            let opened = Opened::read(Some(&scene)).unwrap();
            opened.save(&again, opened.document.film.size).unwrap();
            let [one, other] = [&scene, &again].map(|file| rendered(&mut gpu, file));
            assert!(one.planes() == other.planes() && one.alpha(500) > 0.0, "{host}");
        }
    }
}
