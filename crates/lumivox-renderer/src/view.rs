//! One camera's film, and how it fills: samples, bands, budget.

use std::num::NonZeroU32;

use lumivox_core::PerspectiveCamera;
use lumivox_shaders::Kernel;
use lumivox_shaders::layout::{self, FilmCount};

use crate::display::DisplaySettings;
use crate::error::RenderError;
use crate::film::bytes_per_pixel;
use crate::frame;
use crate::limits::DeviceLimits;
use crate::recording::{Payload, Recording, ResourceId, Step};
use crate::scene_cache::{SceneCache, check_binding};
use crate::unfinished::Unfinished;

/// Invocations that keep a large GPU busy: images of fewer pixels have several for each.
const BUSY_INVOCATIONS: u64 = 1 << 20;

/// Samples for which another invocation is worth it: what a group of them takes is what the longest one does, and few
/// samples differ more.
const SAMPLES_OF_SHARER: u32 = 16;

/// What a view shows, besides scene and camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ViewSettings {
    /// Pixels of the whole image across and down.
    pub image_size: [u32; 2],
    /// Top left pixel of the window of the image that this view holds.
    pub window_origin: [u32; 2],
    /// Pixels of the window.
    pub window_size: [u32; 2],
    /// Chooses the random numbers; the same seed gives the same image.
    pub seed: u32,
    /// Whether the film also holds first-hit albedo and normal.
    pub guides: bool,
    /// Bounces before Russian roulette may end a path.
    pub roulette_start: u32,
    /// The first sample of each pixel; those before it are another view's, on another device maybe. The film's counts
    /// include them, its sums do not: see [`Film::insert_samples`](crate::Film::insert_samples).
    pub first_sample: u32,
    /// Samples of a pixel that are added up before the film is, from the first on; `None` leaves that to the budget. Sums of
    /// 32 bits depend on it in their last bits: a film that has it is the same to the last bit on every device of a kind,
    /// whatever its windows and the budget, and so is the sum of films that hold a pass each, added in order.
    pub pass_samples: Option<NonZeroU32>,
}

impl ViewSettings {
    /// A view of a whole image.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            image_size: [width, height],
            window_origin: [0, 0],
            window_size: [width, height],
            seed: 0,
            guides: false,
            roulette_start: 4,
            first_sample: 0,
            pass_samples: None,
        }
    }

    /// Bytes of a pixel in the largest buffer that a view of the film binds.
    pub fn bytes_per_pixel(&self, limits: DeviceLimits) -> u64 {
        bytes_per_pixel(self.guides).max(Unfinished::bytes_per_pixel(self.guides, limits))
    }

    /// The same with changes.
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }
}

/// A film on the GPU. Each view of a scene has its own, and none knows of another.
#[derive(Debug)]
pub struct View {
    settings: ViewSettings,
    film: ResourceId,
    pixels: Option<ResourceId>,
    camera: Option<PerspectiveCamera>,
    scene_version: u64,
    /// Samples that were recorded for every pixel.
    complete: u32,
    /// Samples that the rows above `next_row` have beyond `complete`, while a pass is under way.
    pass_samples: u32,
    next_row: u32,
    unfinished: Unfinished,
}

impl View {
    /// A view with an empty film.
    ///
    /// # Errors
    /// [`RenderError`] when the image has no pixel, or the film is larger than the device binds.
    pub fn new(
        settings: ViewSettings,
        cache: &SceneCache,
        recording: &mut Recording,
    ) -> Result<Self, RenderError> {
        let [width, height] = settings.window_size;
        if width == 0 || height == 0 {
            return Err(RenderError::EmptyImage { width, height });
        }
        let pixels = u64::from(width) * u64::from(height);
        let bytes = pixels * bytes_per_pixel(settings.guides);
        let remedy = "Render it in windows";
        check_binding("film", bytes, cache.limits().max_storage_binding, remedy)?;
        let unfinished = Unfinished::new(pixels, settings.guides, cache.limits(), remedy, recording)?;
        let film = recording.create_buffer("film", bytes);
        let complete = settings.first_sample;
        let view = Self {
            settings,
            film,
            pixels: None,
            camera: None,
            scene_version: 0,
            complete,
            pass_samples: 0,
            next_row: 0,
            unfinished,
        };
        view.record_first_sample(recording);
        Ok(view)
    }

    /// Records that every pixel of an empty film counts the samples that are another view's: kernels go on behind them.
    fn record_first_sample(&self, recording: &mut Recording) {
        let first = self.settings.first_sample;
        if first == 0 {
            return;
        }
        let [width, height] = self.settings.window_size;
        let pixels = width as usize * height as usize;
        let counts = vec![[0.0, 0.0, first as f32, 0.0]; pixels];
        // The second plane.
        let offset = pixels as u64 * size_of::<[f32; 4]>() as u64;
        recording.push(Step::WriteBuffer { id: self.film, offset, data: Payload::copy_of(&counts) });
    }

    /// The view's settings.
    pub fn settings(&self) -> &ViewSettings {
        &self.settings
    }

    /// Samples that were recorded for every pixel, with those before the first; [`record_count`](Self::record_count) asks for what it got.
    pub fn samples(&self) -> u32 {
        self.complete
    }

    /// Records more samples, about `max_pixel_samples` of them (a row at least), until every pixel has `target_samples`.
    /// Starts over if the camera or the scene changed. Returns how many pixel samples were recorded: 0 at the target.
    ///
    /// # Panics
    /// Before the cache's first [`update`](SceneCache::update), and where its store was freed since the last.
    pub fn record_samples(
        &mut self,
        cache: &SceneCache,
        camera: &PerspectiveCamera,
        target_samples: u32,
        max_pixel_samples: u64,
        recording: &mut Recording,
    ) -> u64 {
        if self.camera != Some(*camera) || self.scene_version != cache.version() {
            if self.camera.is_some() {
                recording.push(Step::ClearBuffer { id: self.film });
                self.record_first_sample(recording);
            }
            self.camera = Some(*camera);
            self.scene_version = cache.version();
            (self.complete, self.pass_samples, self.next_row) = (self.settings.first_sample, 0, 0);
            self.unfinished.forget();
        }
        let [width, height] = self.settings.window_size;
        let (row, mut recorded) = (u64::from(width), 0);
        while self.complete < target_samples {
            let affordable = max_pixel_samples.saturating_sub(recorded);
            if self.next_row == 0 {
                let left = u64::from(target_samples - self.complete);
                let most = u64::from(cache.limits().max_samples_per_dispatch * self.most_sharers(cache));
                let samples = match self.settings.pass_samples {
                    Some(samples) => u64::from(samples.get()).min(left),
                    None => (affordable / (row * u64::from(height))).clamp(1, left.min(most)),
                };
                self.pass_samples = samples as u32;
            }
            // A row is the least that is done, however small the budget: it makes progress.
            let rows =
                (affordable / (row * u64::from(self.pass_samples))).min(u64::from(height - self.next_row));
            if rows == 0 && recorded > 0 {
                break;
            }
            let rows = rows.max(1) as u32;
            let end = self.complete + self.pass_samples;
            let sharers = self.pass_samples / SAMPLES_OF_SHARER;
            let rows_of_band = [self.next_row, self.next_row + rows];
            self.record_band(cache, camera, end, sharers, rows_of_band, recording);
            recorded += row * u64::from(rows) * u64::from(self.pass_samples);
            self.next_row += rows;
            if self.next_row == height {
                self.next_row = 0;
                self.complete += self.pass_samples;
                // What is put aside of a pass is not to be added up with the next.
                if self.settings.pass_samples.is_some() && self.unfinished.puts_aside() {
                    break;
                }
            }
            if recorded >= max_pixel_samples {
                break;
            }
        }
        recorded
    }

    /// Records that a count of the film comes back, for [`counted`](Self::counted): whether every pixel has the samples
    /// that were recorded for it.
    pub fn record_count(&self, recording: &mut Recording) {
        let [width, height] = self.settings.window_size;
        let pixels = u64::from(width) * u64::from(height);
        self.unfinished.record_count(self.film, pixels, self.complete, recording);
    }

    /// Takes the bytes of a count, and says what they mean.
    ///
    /// # Errors
    /// [`RenderError::SamplesLost`] when pixels lack samples and no dispatch will bring them.
    ///
    /// # Panics
    /// If those are fewer bytes than a [`FilmCount`] has.
    pub fn counted(&mut self, bytes: &[u8]) -> Result<FilmCount, RenderError> {
        self.unfinished.counted(bytes)
    }

    /// Records what the last count found missing: paths that were put aside go on, and pixels catch up with the samples
    /// that were recorded for them. Returns whether anything was.
    pub fn record_missing(&mut self, cache: &SceneCache, recording: &mut Recording) -> bool {
        let Some(camera) = self.camera.filter(|_| self.unfinished.begin_retry()) else { return false };
        // Rows of a pass under way have more, each of their pixels as many: were those with the long paths left behind,
        // they would weigh too little.
        let (begun, height) = (self.next_row, self.settings.window_size[1]);
        let bands = [(self.complete + self.pass_samples, [0, begun]), (self.complete, [begun, height])];
        for (sample_limit, rows) in bands {
            if sample_limit > 0 && rows[1] > rows[0] {
                self.record_band(cache, &camera, sample_limit, 1, rows, recording);
            }
        }
        true
    }

    /// How many invocations may share the samples of a pixel.
    fn most_sharers(&self, cache: &SceneCache) -> u32 {
        // Where a film is to be the same in any windows, they share as the whole image would.
        let [width, height] = match self.settings.pass_samples {
            Some(_) => self.settings.image_size,
            None => self.settings.window_size,
        };
        let pixels = u64::from(width) * u64::from(height);
        let most = cache.variant(self.settings.guides, false).most_sharers();
        (BUSY_INVOCATIONS / pixels.max(1)).clamp(1, u64::from(most)) as u32
    }

    /// Rows of pixels, until each has `sample_limit` samples or its invocation comes to its end. So many invocations share a
    /// pixel at most.
    fn record_band(
        &self,
        cache: &SceneCache,
        camera: &PerspectiveCamera,
        sample_limit: u32,
        sharers: u32,
        [row_begin, row_end]: [u32; 2],
        recording: &mut Recording,
    ) {
        let frame = self.frame(cache, camera);
        let sharers = 1 << sharers.clamp(1, self.most_sharers(cache)).ilog2();
        let variant = cache.variant(self.settings.guides, false).for_sharers(sharers);
        let kernel = Kernel::PathTrace(variant);
        let frame =
            layout::Frame { samples: sample_limit, sample_limit, sharers, row_begin, row_end, ..frame };
        let mut resources = cache.path_trace_resources();
        resources.push(self.film);
        resources.extend(self.unfinished.paths());
        resources.extend(cache.pools());
        let [x, y] = kernel.workgroup_size();
        let columns = self.settings.window_size[0] * sharers;
        let workgroups = [columns.div_ceil(x), (row_end - row_begin).div_ceil(y)];
        for frame in self.unfinished.dispatches(frame) {
            let uniforms = vec![bytemuck::bytes_of(&frame).to_vec()];
            recording.push(Step::Dispatch { kernel, uniforms, resources: resources.clone(), workgroups });
        }
    }

    fn frame(&self, cache: &SceneCache, camera: &PerspectiveCamera) -> layout::Frame {
        let [width, height] = self.settings.image_size;
        let camera = camera.with_aspect(f64::from(width) / f64::from(height));
        layout::Frame {
            seed: self.settings.seed,
            image_size: self.settings.image_size,
            film_origin: self.settings.window_origin,
            film_size: self.settings.window_size,
            row_end: self.settings.window_size[1],
            roulette_start: self.settings.roulette_start,
            ..frame::of(cache, &camera)
        }
    }

    /// Records that the film comes back, for [`Film::insert`](crate::Film::insert).
    pub fn record_read_film(&self, recording: &mut Recording) {
        let [width, height] = self.settings.window_size;
        let bytes = u64::from(width) * u64::from(height) * bytes_per_pixel(self.settings.guides);
        recording.push(Step::ReadBuffer { id: self.film, range: 0..bytes });
    }

    /// Records the film's way to displayable pixels and returns their buffer: four bytes each, red first, alpha not
    /// premultiplied, rows from the top.
    pub fn record_display(
        &mut self,
        cache: &SceneCache,
        settings: &DisplaySettings,
        recording: &mut Recording,
    ) -> ResourceId {
        let [width, height] = self.settings.window_size;
        let pixels = *self.pixels.get_or_insert_with(|| {
            recording.create_buffer("pixels", u64::from(width) * u64::from(height) * 4)
        });
        let camera = self
            .camera
            .unwrap_or(PerspectiveCamera { world_from_camera: Default::default(), vertical_fov: 1.0 });
        let frame = self.frame(cache, &camera);
        let [x, y] = Kernel::Display.workgroup_size();
        recording.push(Step::Dispatch {
            kernel: Kernel::Display,
            uniforms: vec![
                bytemuck::bytes_of(&frame).to_vec(),
                bytemuck::bytes_of(&settings.params()).to_vec(),
            ],
            resources: vec![self.film, cache.environment_resources()[0], pixels],
            workgroups: [width.div_ceil(x), height.div_ceil(y)],
        });
        pixels
    }

    /// Records that everything is freed.
    pub fn free(self, recording: &mut Recording) {
        recording.push(Step::Free { id: self.film });
        recording.free(self.pixels);
        self.unfinished.free(recording);
    }
}
