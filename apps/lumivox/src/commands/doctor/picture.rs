//! The test picture: a small head, which each device renders, and which is known.

use std::sync::Arc;

use lumivox_core::{CancelToken, PerspectiveCamera, Preset, Progress, Scene, framing};
use lumivox_phantom::AnatomyOptions;
use lumivox_renderer::{DisplaySettings, Film};
use lumivox_wgpu::{Gpu, HeadlessError, Outcome, RenderRequest, render};

use crate::{exit::Failure, output::Picture};

/// Voxels along its longest side.
const VOXELS: usize = 48;

/// Pixels along a side, and samples of each.
const SIZE: u32 = 96;
const SAMPLES: u32 = 8;

/// What of it is covered, and its light in the mean over all pixels: paths are the same on every device but for rounding.
const ALPHA: f64 = 0.3795;
const LIGHT: f64 = 0.06238;

/// By which part they may be others: a device that works is not to be called broken for how it rounds, and those that do not are
/// far off.
const TOLERANCE: f64 = 0.1;

/// The scene, made once for all devices.
pub struct TestPicture {
    scene: Scene,
    camera: PerspectiveCamera,
}

impl TestPicture {
    /// Grows the head: a tenth of a second.
    pub fn new() -> Result<Self, Failure> {
        let options = AnatomyOptions { size: VOXELS, ..AnatomyOptions::default() };
        let head = lumivox_phantom::anatomy(options, Progress::SILENT, &CancelToken::new())
            .map_err(|error| Failure::other(error.to_string()))?;
        let head = Arc::new(head);
        let scene = Scene::with_volume(head.clone(), Preset::CtMuscle.medium(&head));
        let camera = framing::frame(&scene, 0.5, 0.1, 0.5, 1.0).camera();
        Ok(Self { scene, camera })
    }

    /// Rendered by a device.
    ///
    /// # Errors
    /// What the device has against it, or what is wrong with what it made.
    pub fn by(&self, gpu: &mut Gpu) -> Result<Picture, String> {
        let request = RenderRequest::new(SIZE, SIZE, SAMPLES);
        let rendered =
            render(gpu, &self.scene, &self.camera, &request, &mut |_| std::ops::ControlFlow::Continue(()));
        let film = match rendered {
            Ok(rendered) => match rendered.outcome {
                Outcome::Failed(error) => return Err(error.to_string()),
                _ => rendered.film,
            },
            Err(HeadlessError::Gpu(error)) => return Err(error.to_string()),
            Err(error) => return Err(error.to_string()),
        };
        check(means(&film))?;
        let rgba =
            DisplaySettings::default().pixels(&film, &self.scene.environment, &self.camera).into_flattened();
        Ok(Picture { width: SIZE, height: SIZE, rgba })
    }
}

/// Alpha and light, in the mean over all pixels.
fn means(film: &Film) -> [f64; 2] {
    let pixels = (SIZE * SIZE) as usize;
    let sum = |value: &dyn Fn(usize) -> f64| (0..pixels).map(value).sum::<f64>() / pixels as f64;
    [sum(&|pixel| film.alpha(pixel)), sum(&|pixel| film.radiance(pixel).iter().sum::<f64>() / 3.0)]
}

fn check([alpha, light]: [f64; 2]) -> Result<(), String> {
    for (what, is, wanted) in [("covers", alpha, ALPHA), ("is as bright as", light, LIGHT)] {
        // What is no number is no picture either.
        if !(1.0 - TOLERANCE..=1.0 + TOLERANCE).contains(&(is / wanted)) {
            return Err(format!(
                "its test picture is wrong: it {what} {:.0}% of what it should",
                100.0 * is / wanted
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_picture_is_none() {
        assert_eq!(check([ALPHA, LIGHT]), Ok(()));
        assert_eq!(check([1.02 * ALPHA, 0.98 * LIGHT]), Ok(()));
        let said = |means| check(means).unwrap_err();
        assert_eq!(
            said([ALPHA, 0.5 * LIGHT]),
            "its test picture is wrong: it is as bright as 50% of what it should"
        );
        assert_eq!(said([0.0, 0.0]), "its test picture is wrong: it covers 0% of what it should");
        assert!(said([ALPHA, f64::NAN]).contains("NaN%"));
    }
}
