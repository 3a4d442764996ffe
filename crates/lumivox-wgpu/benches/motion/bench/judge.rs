//! What a picture is worth: measured against the converged one of the same moment, on threads of their own, for the GPU goes on
//! meanwhile.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::thread::JoinHandle;

use lumivox_renderer::ToneMap;
use lumivox_testing::flip::{FlipReference, PIXELS_PER_DEGREE, reach};
use lumivox_testing::motion::{brightness_within, flicker_within, mean_within, psnr_within};
use lumivox_testing::png_io::SrgbImage;

use super::host::Picture;

/// Alpha of the converged picture from which on a pixel is one of the subject.
const SUBJECT: f32 = 0.01;

/// Linear light behind the volumes.
const BACKGROUND: [f64; 3] = [0.008, 0.009, 0.012];

/// Pixels over which flicker is averaged.
pub const BLURS: [usize; 3] = [0, 8, 32];

/// A part of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    from: [usize; 2],
    size: [usize; 2],
}

impl Part {
    /// What `mask` is in, and as much around it as its differences depend on.
    fn around(mask: &[bool], size: [usize; 2]) -> Self {
        let mut bounds = [[usize::MAX, 0]; 2];
        for (i, _) in mask.iter().enumerate().filter(|(_, inside)| **inside) {
            for (bounds, at) in bounds.iter_mut().zip([i % size[0], i / size[0]]) {
                *bounds = [bounds[0].min(at), bounds[1].max(at + 1)];
            }
        }
        if bounds[0][1] == 0 {
            return Self { from: [0; 2], size: [1; 2] };
        }
        let margin = reach(PIXELS_PER_DEGREE);
        let from = [0, 1].map(|axis| bounds[axis][0].saturating_sub(margin));
        let end = [0, 1].map(|axis| (bounds[axis][1] + margin).min(size[axis]));
        Self { from, size: [end[0] - from[0], end[1] - from[1]] }
    }

    fn cut<T: Copy>(&self, pixels: &[T], width: usize) -> Vec<T> {
        let [columns, rows] = self.size;
        let row = |y: usize| (self.from[1] + y) * width + self.from[0];
        (0..rows).flat_map(|y| pixels[row(y)..row(y) + columns].iter().copied()).collect()
    }

    /// As it is shown.
    fn shown(&self, pixels: &[[f32; 4]], width: usize, tone: ToneMap) -> SrgbImage {
        let code = |pixel: [f32; 4]| {
            let through = 1.0 - f64::from(pixel[3]);
            let light = std::array::from_fn(|i| f64::from(pixel[i]) + through * BACKGROUND[i]);
            tone.apply(light).map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8)
        };
        let pixels = self.cut(pixels, width).into_iter().map(code).collect();
        SrgbImage { width: self.size[0], height: self.size[1], pixels }
    }
}

/// The converged picture of a moment, and what of it others are compared with.
pub struct Converged {
    picture: Arc<Picture>,
    width: usize,
    tone: ToneMap,
    part: Part,
    /// Of the part.
    subject: Vec<bool>,
    /// What was hidden a moment ago, of the part.
    uncovered: Vec<bool>,
    shown: SrgbImage,
    reference: FlipReference,
}

/// One that whoever needs it first makes.
pub type ConvergedLater = Arc<LazyLock<Converged, Box<dyn FnOnce() -> Converged + Send>>>;

impl Converged {
    /// Of a picture; `uncovered` are the pixels that something hid a moment ago.
    pub fn later(picture: Picture, uncovered: Vec<bool>, width: usize, tone: ToneMap) -> ConvergedLater {
        let make = move || Self::new(picture, &uncovered, width, tone);
        Arc::new(LazyLock::new(Box::new(make)))
    }

    fn new(picture: Picture, uncovered: &[bool], width: usize, tone: ToneMap) -> Self {
        let subject: Vec<bool> = picture.iter().map(|pixel| pixel[3] > SUBJECT).collect();
        let part = Part::around(&subject, [width, picture.len() / width]);
        let shown = part.shown(&picture, width, tone);
        let subject = part.cut(&subject, width);
        let uncovered = part.cut(uncovered, width);
        let uncovered = uncovered.into_iter().zip(&subject).map(|(u, s)| u && *s).collect();
        let reference = FlipReference::new(&shown);
        Self { picture: Arc::new(picture), width, tone, part, subject, uncovered, shown, reference }
    }

    /// What a picture of this moment is worth. `before` is the frame before, of which it is seen how it flickers.
    pub fn judge(&self, picture: &Picture, before: Option<(&Picture, &Converged)>, strip: usize) -> Judged {
        let shown = self.part.shown(picture, self.width, self.tone);
        let map = self.reference.flip(&shown);
        let light = |picture: &Picture| self.part.cut(picture, self.width);
        let flicker = before.and_then(|(picture, converged)| {
            let [truth, test] =
                [&*converged.picture, picture].map(|picture| self.part.shown(picture, self.width, self.tone));
            let measure = |blur| flicker_within([&truth, &test], [&self.shown, &shown], &self.subject, blur);
            let [all, some, few] = BLURS.map(measure);
            Some([all?, some?, few?])
        });
        let strip = (strip > 0).then(|| self.strip(&shown, &map.values, strip));
        Judged {
            flip: mean_within(&map.values, &self.subject),
            psnr: psnr_within(&self.shown, &shown, &self.subject),
            brightness: brightness_within(&light(&self.picture), &light(picture), &self.subject),
            flicker,
            uncovered: mean_within(&map.values, &self.uncovered),
            strip,
        }
    }

    /// The picture, the converged one and the difference, side by side: the midst of the subject, pixel by pixel.
    fn strip(&self, shown: &SrgbImage, differences: &[f64], side: usize) -> SrgbImage {
        let size = self.part.size.map(|n| n.min(side));
        let from = [0, 1].map(|axis| (self.part.size[axis] - size[axis]) / 2);
        let window = Part { from, size };
        let width = self.part.size[0];
        let grey = |value: &f64| [(value.clamp(0.0, 1.0) * 255.0).round() as u8; 3];
        let differences: Vec<[u8; 3]> = differences.iter().map(grey).collect();
        let panels = [&shown.pixels, &self.shown.pixels, &differences];
        let panels = panels.map(|pixels| window.cut(pixels, width));
        let row = |y: usize| panels.iter().flat_map(move |p| p[y * size[0]..(y + 1) * size[0]].iter());
        let pixels = (0..size[1]).flat_map(row).copied().collect();
        SrgbImage { width: 3 * size[0], height: size[1], pixels }
    }
}

/// What is measured of a picture; `None` where there is nothing to measure it of.
#[derive(Clone, Debug, Default)]
pub struct Judged {
    pub flip: Option<f64>,
    pub psnr: Option<f64>,
    pub brightness: Option<f64>,
    /// At [`BLURS`].
    pub flicker: Option<[f64; 3]>,
    /// Of pixels that were uncovered a moment ago.
    pub uncovered: Option<f64>,
    pub strip: Option<SrgbImage>,
}

type Job = Box<dyn FnOnce() + Send>;

/// Threads that judge.
pub struct Judges {
    jobs: Option<SyncSender<Job>>,
    threads: Vec<JoinHandle<()>>,
}

impl Judges {
    /// As many as there are processors but one, which keeps the GPU busy.
    pub fn new() -> Self {
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        let count = processors.saturating_sub(1).clamp(1, 32);
        // Each job holds a picture.
        let (jobs, taken) = sync_channel::<Job>(2 * count);
        let taken = Arc::new(Mutex::new(taken));
        let threads = (0..count).map(|_| {
            let taken = taken.clone();
            std::thread::spawn(move || {
                while let Some(job) = next(&taken) {
                    job()
                }
            })
        });
        Self { jobs: Some(jobs), threads: threads.collect() }
    }

    /// Has something done; waits while all have enough to do.
    pub fn ask(&self, job: impl FnOnce() + Send + 'static) {
        if let Some(jobs) = &self.jobs {
            // They end with this, not before.
            _ = jobs.send(Box::new(job));
        }
    }
}

impl Drop for Judges {
    fn drop(&mut self) {
        self.jobs = None;
        for thread in self.threads.drain(..) {
            _ = thread.join();
        }
    }
}

fn next(taken: &Mutex<Receiver<Job>>) -> Option<Job> {
    taken.lock().unwrap_or_else(PoisonError::into_inner).recv().ok()
}
