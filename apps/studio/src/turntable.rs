//! A turn around the scan: a PNG for each step, and a film of them where ffmpeg is there.

use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, Stdio};

use lumivox_core::document::SceneDocument;
use lumivox_core::{Orbit, Scene};

use crate::darkroom::{Darkroom, Exported, develop, film_file, keep, step_file};
use crate::jobs::{Busy, Desk};
use crate::words::{Language, Word};

/// Pictures a second of the film.
const RATE: u32 = 24;

/// Renders a whole turn in so many pictures, from where the camera stands.
pub fn turntable(
    room: &Darkroom,
    document: &SceneDocument,
    scene: &Scene,
    start: Orbit,
    (file, steps): (&Path, u32),
    desk: &Desk<Exported>,
) {
    let mut is_reduced = false;
    for step in 0..steps {
        let mut on_progress = |part: f32| {
            let done = 1000 * u64::from(step) + (part * 1000.0) as u64;
            desk.report(Busy { stage: None, done, total: 1000 * u64::from(steps) });
            desk.cancel().check().map_or(ControlFlow::Break(()), |()| ControlFlow::Continue(()))
        };
        let turned = std::f64::consts::TAU * f64::from(step) / f64::from(steps);
        let camera = Orbit { azimuth: start.azimuth + turned, ..start }.camera();
        let developed = develop(room, document, scene, &camera, &mut on_progress);
        if desk.cancel().is_cancelled() {
            return;
        }
        let written = developed.and_then(|still| {
            is_reduced |= still.is_reduced;
            keep(&step_file(file, step), &still.picture)
        });
        if let Err(why) = written {
            return desk.tell(Exported::Failed(why));
        }
    }
    let has_film = film(file, steps).status().is_ok_and(|status| status.success());
    desk.tell(Exported::Turned { steps, is_reduced, has_film });
}

/// What makes a film of so many pictures, and of no older ones beside them.
pub fn film(file: &Path, steps: u32) -> Command {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    // A percent sign of a name is not one of the pattern.
    let pattern = file.with_file_name(format!("{}-%03d.png", stem.replace('%', "%%")));
    let [rate, steps] = [RATE, steps].map(|n| n.to_string());
    let says = format!("comment={}", Word::NoDevice.of(Language::English));
    let mut film = Command::new("ffmpeg");
    film.args(["-nostdin", "-y", "-loglevel", "error", "-framerate", &rate, "-start_number", "0", "-i"])
        .arg(pattern)
        .args(["-frames:v", &steps])
        // Films of this kind have sides of even numbers.
        .args(["-vf", "scale=trunc(iw/2)*2:trunc(ih/2)*2", "-pix_fmt", "yuv420p", "-metadata", &says])
        .arg(film_file(file))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    film
}
