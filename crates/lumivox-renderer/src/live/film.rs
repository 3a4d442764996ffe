//! A film of a live view: the buffers that its images lie in, what they lack, and the passes over them.

use super::images::{FilmImages, Grain, Image, LiveImage, PixelFormat, pixels};
use super::passes::{ClearPass, CountPass, DenoisePass, FadePass, PathSettings, Share, ShownFilm, TracePass};
use crate::error::RenderError;
use crate::limits::DeviceLimits;
use crate::recording::{Recording, ResourceId, Step};
use crate::scene_cache::{SceneCache, check_binding};
use crate::unfinished::Unfinished;

/// Rows that are traced together: a workgroup's.
pub(super) const GROUP_ROWS: u32 = 8;

/// Planes of what the denoiser makes.
const DENOISED_PLANES: u32 = 2;

#[derive(Debug)]
pub(super) struct LiveFilm {
    buffer: ResourceId,
    pub unfinished: Unfinished,
    /// Pixels there is room for, and whether for guides, too.
    pub capacity: u64,
    pub has_guides: bool,
    pub size: [u32; 2],
    /// The denoised image, and a second buffer for what is in between.
    denoised: Option<[ResourceId; 2]>,
    /// Whether the film changed since it was denoised.
    pub stale: bool,
}

impl LiveFilm {
    /// With room for guides, or without.
    pub fn new(
        size: [u32; 2],
        guides: bool,
        cache: &SceneCache,
        recording: &mut Recording,
    ) -> Result<Self, RenderError> {
        Self::check(size, guides, cache)?;
        let limits = cache.limits();
        let unfinished = Unfinished::new(pixels(size), guides, limits, remedy(guides), recording)?;
        Ok(Self::with(size, guides, unfinished, recording))
    }

    /// For paths that leave points.
    pub fn for_points(
        size: [u32; 2],
        cache: &SceneCache,
        recording: &mut Recording,
    ) -> Result<Self, RenderError> {
        Self::check(size, false, cache)?;
        let unfinished = Unfinished::for_points(pixels(size), cache.limits(), remedy(false), recording)?;
        Ok(Self::with(size, false, unfinished, recording))
    }

    /// Bytes of a pixel of one for paths that leave points, with what is put aside of them.
    pub fn bytes_of_points(limits: DeviceLimits) -> u64 {
        FilmImages::buffer_bytes(4, false) / 4 + Unfinished::bytes_per_pixel_of_points(limits)
    }

    fn check(size: [u32; 2], guides: bool, cache: &SceneCache) -> Result<(), RenderError> {
        let bytes = FilmImages::buffer_bytes(pixels(size), guides);
        check_binding("film", bytes, cache.limits().max_storage_binding, remedy(guides))
    }

    fn with(size: [u32; 2], guides: bool, unfinished: Unfinished, recording: &mut Recording) -> Self {
        let capacity = pixels(size);
        Self {
            unfinished,
            buffer: recording.create_buffer("live film", FilmImages::buffer_bytes(capacity, guides)),
            capacity,
            has_guides: guides,
            size,
            denoised: None,
            stale: true,
        }
    }

    /// Its images, as those of the film that it serves as. Guides are of the fine one alone.
    pub fn images(&self, grain: Grain) -> FilmImages {
        let guides = self.has_guides && grain == Grain::Fine;
        FilmImages { grain, buffer: self.buffer, size: self.size, guides }
    }

    /// Empties it; no ray ends.
    pub fn clear(&mut self, grain: Grain) -> ClearPass {
        self.unfinished.forget();
        self.stale = true;
        ClearPass { film: self.images(grain) }
    }

    /// Keeps a part of its samples, whose light is so many times as bright as when they were traced.
    pub fn fade(&mut self, grain: Grain, [kept, scale]: [f64; 2]) -> FadePass {
        self.stale = true;
        FadePass { film: self.images(grain), kept, scale }
    }

    /// More samples. Paths that starve, where some are known to, are among them.
    pub fn trace<'a>(
        &self,
        grain: Grain,
        scene: &'a SceneCache,
        settings: &PathSettings,
        share: Share,
    ) -> TracePass<'a> {
        TracePass::new(scene, self.images(grain), self.unfinished.paths(), settings, share)
            .with_starved(&self.unfinished)
    }

    /// More samples for each pixel whose path starved.
    pub fn trace_starved<'a>(
        &self,
        grain: Grain,
        scene: &'a SceneCache,
        settings: &PathSettings,
        share: Share,
    ) -> TracePass<'a> {
        TracePass::new(scene, self.images(grain), self.unfinished.paths(), settings, share)
            .of_starved(&self.unfinished)
    }

    /// A count of it comes back: whether every pixel has `samples`.
    pub fn count(&self, grain: Grain, samples: u32) -> CountPass {
        CountPass { film: self.images(grain), samples, count: self.unfinished.count() }
    }

    /// What is shown of it anew, if it changed. A pixel of it is as large as `factor` of the finest along a side.
    /// With a picture of kept light it is what the film shows more than that.
    pub fn denoise(
        &mut self,
        grain: Grain,
        factor: u32,
        kept_light: Option<Image>,
        recording: &mut Recording,
    ) -> Option<DenoisePass> {
        if !std::mem::take(&mut self.stale) {
            return None;
        }
        let bytes = self.capacity * u64::from(DENOISED_PLANES) * PixelFormat::FourFloats.bytes();
        let [_, spare] = *self
            .denoised
            .get_or_insert_with(|| [(); 2].map(|()| recording.create_buffer("denoised film", bytes)));
        let denoised = self.denoised(grain)?;
        let film = self.images(grain);
        Some(DenoisePass { film, denoised, spare, kept_light, is_coarse: factor > 1 })
    }

    /// What the denoiser made of it, while that is what it shows.
    pub fn denoised(&self, grain: Grain) -> Option<Image> {
        let [buffer, _] = self.denoised.filter(|_| !self.stale)?;
        Some(Image {
            name: LiveImage::Denoised(grain),
            buffer,
            offset: 0,
            size: self.size,
            planes: DENOISED_PLANES,
            format: PixelFormat::FourFloats,
        })
    }

    pub fn drop_denoised(&mut self, recording: &mut Recording) {
        for id in self.denoised.take().into_iter().flatten() {
            recording.push(Step::Free { id });
        }
        self.stale = true;
    }

    /// It as the picture has it.
    pub fn shown(&self, grain: Grain) -> ShownFilm {
        ShownFilm { film: self.images(grain), denoised: self.denoised(grain) }
    }

    pub fn free(mut self, recording: &mut Recording) {
        self.drop_denoised(recording);
        self.unfinished.free(recording);
        recording.push(Step::Free { id: self.buffer });
    }
}

/// What helps where a film is too large.
fn remedy(guides: bool) -> &'static str {
    match guides {
        true => "Lower the resolution scale, or do without guides",
        false => "Lower the resolution scale",
    }
}

/// Rows in the order in which they are traced, in groups of a workgroup's height; the last may not all be there.
pub(super) fn padded_height([_, height]: [u32; 2]) -> u32 {
    height.next_multiple_of(GROUP_ROWS)
}
