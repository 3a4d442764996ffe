//! A film of a live view, where its primary rays end, and what the denoiser makes of it.

use lumivox_shaders::{Kernel, layout};

use super::{HostDepth, Traced};
use crate::error::RenderError;
use crate::film::bytes_per_pixel;
use crate::frame;
use crate::recording::{Recording, ResourceId, Step};
use crate::scene_cache::{SceneCache, check_binding};
use crate::unfinished::Unfinished;

/// Rows that are traced together: a workgroup's.
pub(super) const GROUP_ROWS: u32 = 8;

/// Bytes that say where a pixel's primary rays end.
const LIMIT_BYTES: u64 = 4;

/// Pixels between the taps of the denoiser's passes.
const DENOISE_STEPS: &[u32] = &[1, 2, 4, 8];

/// Those of a coarse film: its pixels are many times as large, and it would blend a head with what is behind it.
const COARSE_DENOISE_STEPS: &[u32] = &[1];

#[derive(Debug)]
pub(super) struct LiveFilm {
    /// Its planes, and behind them where its primary rays end.
    pub film: ResourceId,
    pub unfinished: Unfinished,
    /// Pixels there is room for.
    pub capacity: u64,
    pub size: [u32; 2],
    /// The denoiser's pixels, and a second buffer for its passes.
    denoised: Option<[ResourceId; 2]>,
    /// Whether the film changed since it was denoised.
    pub stale: bool,
}

impl LiveFilm {
    pub fn new(size: [u32; 2], cache: &SceneCache, recording: &mut Recording) -> Result<Self, RenderError> {
        let capacity = pixels(size);
        let bytes = (capacity * (bytes_per_pixel(false) + LIMIT_BYTES)).next_multiple_of(16);
        let remedy = "Lower the resolution scale";
        check_binding("film", bytes, cache.limits().max_storage_binding, remedy)?;
        Ok(Self {
            unfinished: Unfinished::new(capacity, false, cache.limits(), remedy, recording)?,
            film: recording.create_buffer("live film", bytes),
            capacity,
            size,
            denoised: None,
            stale: true,
        })
    }

    /// Empties it; no ray ends.
    pub fn clear(&mut self, recording: &mut Recording) {
        recording.push(Step::ClearBuffer { id: self.film });
        self.unfinished.forget();
        self.stale = true;
    }

    /// Keeps a part of its samples, whose light is so many times as bright as when they were traced.
    pub fn record_fade(&mut self, [kept, scale]: [f64; 2], recording: &mut Recording) {
        let params = layout::FilmFadeParams { film_size: self.size, kept: kept as f32, scale: scale as f32 };
        self.dispatch(Kernel::FilmFade, &params, vec![self.film], recording);
        self.stale = true;
    }

    /// Ends primary rays at the host's surfaces; pixels where those changed start over, and are counted.
    /// None counts that is farther than `farthest`.
    pub fn record_host_depth(
        &mut self,
        depth: &HostDepth,
        farthest: f64,
        restarts: ResourceId,
        recording: &mut Recording,
    ) {
        let params = layout::HostDepthParams {
            view_depth_from_ndc: depth.view_depth_from_ndc.map(|x| x as f32),
            film_size: self.size,
            clear: depth.clear as f32,
            jittered: u32::from(depth.jittered),
            farthest: farthest as f32,
            ..Default::default()
        };
        let resources = vec![depth.texture, self.film, restarts];
        self.dispatch(Kernel::HostDepth, &params, resources, recording);
    }

    /// `samples` more for each pixel of some rows, `limit` at most in all. Rows count in the order of
    /// [`padded_height`].
    pub fn record_samples(
        &mut self,
        traced: Traced,
        cache: &SceneCache,
        samples: u32,
        limit: u32,
        rows: [u32; 2],
        recording: &mut Recording,
    ) {
        let params = self.frame(traced, cache, [samples, limit, 1], rows);
        self.record_trace(cache, params, self.unfinished.dispatches(params), recording);
    }

    /// Up to `samples` for each pixel that has fewer than `others`: for few, those that started over. Those of them that
    /// starve are not waited for.
    pub fn record_first_aid(
        &mut self,
        traced: Traced,
        cache: &SceneCache,
        samples: u32,
        others: u32,
        recording: &mut Recording,
    ) {
        let rows = [0, padded_height(self.size)];
        let all = self.frame(traced, cache, [samples, samples, 1], rows);
        let params = layout::Frame { only_below: others, ..all };
        self.record_trace(cache, params, self.unfinished.dispatches(params), recording);
    }

    /// `samples` more for each pixel whose path starved, `limit` at most in all.
    pub fn record_starved(
        &mut self,
        traced: Traced,
        cache: &SceneCache,
        samples: u32,
        limit: u32,
        recording: &mut Recording,
    ) {
        let params = self.frame(traced, cache, [samples, limit, 1], [0, padded_height(self.size)]);
        self.record_trace(cache, params, self.unfinished.lone_dispatches(params), recording);
    }

    /// Records that a count of the film comes back: whether every pixel has `samples`.
    pub fn record_count(&self, samples: u32, recording: &mut Recording) {
        self.unfinished.record_count(self.film, pixels(self.size), samples, recording);
    }

    /// So many samples of every pixel at once, by as many invocations as may share it: what a film of few pixels needs
    /// to keep a large GPU busy.
    pub fn record_all(
        &mut self,
        traced: Traced,
        cache: &SceneCache,
        samples: u32,
        recording: &mut Recording,
    ) {
        let most = cache.variant(false, true).most_sharers();
        let sharers = 1 << samples.clamp(1, most).ilog2();
        let params = self.frame(traced, cache, [samples, samples, sharers], [0, padded_height(self.size)]);
        self.record_trace(cache, params, self.unfinished.dispatches(params), recording);
    }

    /// What the kernel needs to know of all dispatches for some rows.
    fn frame(
        &self,
        traced: Traced,
        cache: &SceneCache,
        [samples, limit, sharers]: [u32; 3],
        [row_begin, row_end]: [u32; 2],
    ) -> layout::Frame {
        layout::Frame {
            seed: traced.seed,
            roulette_start: traced.key.roulette_start,
            image_size: self.size,
            film_size: self.size,
            samples,
            sample_limit: limit,
            group_stride: group_stride(padded_height(self.size) / GROUP_ROWS),
            row_begin,
            row_end,
            sharers,
            ambient: traced.ambient,
            only_below: 0,
            ..frame::of(cache, &traced.key.camera)
        }
    }

    fn record_trace(
        &self,
        cache: &SceneCache,
        common: layout::Frame,
        dispatches: impl Iterator<Item = layout::Frame>,
        recording: &mut Recording,
    ) {
        let variant = cache.variant(false, true).for_sharers(common.sharers);
        let kernel = Kernel::PathTrace(variant);
        let mut resources = cache.path_trace_resources();
        resources.push(self.film);
        resources.extend(self.unfinished.resources());
        resources.extend(cache.pools());
        let [x, y] = kernel.workgroup_size();
        let rows = common.row_end - common.row_begin;
        let workgroups = [(self.size[0] * common.sharers).div_ceil(x), rows.div_ceil(y)];
        for params in dispatches {
            let uniforms = vec![bytemuck::bytes_of(&params).to_vec()];
            recording.push(Step::Dispatch { kernel, uniforms, resources: resources.clone(), workgroups });
        }
    }

    /// Denoises what changed. A pixel of the film is as large as `factor` of the finest along a side; of a coarse film,
    /// pixels that outshine their neighbours are held back.
    pub fn record_denoise(&mut self, factor: u32, recording: &mut Recording) {
        if !std::mem::take(&mut self.stale) {
            return;
        }
        let bytes = self.capacity * bytes_per_pixel(false);
        let [mut to, mut from] = *self
            .denoised
            .get_or_insert_with(|| [(); 2].map(|()| recording.create_buffer("denoised film", bytes)));
        // The last pass writes to the first buffer.
        let steps = if factor > 1 { COARSE_DENOISE_STEPS } else { DENOISE_STEPS };
        if steps.len() % 2 == 0 {
            std::mem::swap(&mut from, &mut to);
        }
        let params =
            |step| layout::DenoiseParams { film_size: self.size, step, bounded: u32::from(factor > 1) };
        self.dispatch(Kernel::DenoisePrepare, &params(0), vec![self.film, from], recording);
        for &step in steps {
            self.dispatch(Kernel::DenoiseWavelet, &params(step), vec![from, to], recording);
            std::mem::swap(&mut from, &mut to);
        }
    }

    pub fn drop_denoised(&mut self, recording: &mut Recording) {
        for id in self.denoised.take().into_iter().flatten() {
            recording.push(Step::Free { id });
        }
        self.stale = true;
    }

    /// Where light and alpha are shown from; the film itself where it is not denoised.
    pub fn shown(&self) -> ResourceId {
        self.denoised.map_or(self.film, |[last, _]| last)
    }

    pub fn record_read(&self, recording: &mut Recording) {
        recording.push(Step::ReadBuffer { id: self.film, range: 0..self.read_bytes() });
    }

    /// Bytes that come back then.
    pub fn read_bytes(&self) -> u64 {
        pixels(self.size) * bytes_per_pixel(false)
    }

    pub fn free(mut self, recording: &mut Recording) {
        self.drop_denoised(recording);
        self.unfinished.free(recording);
        recording.push(Step::Free { id: self.film });
    }

    /// One invocation for each pixel.
    fn dispatch(
        &self,
        kernel: Kernel,
        params: &impl bytemuck::NoUninit,
        resources: Vec<ResourceId>,
        recording: &mut Recording,
    ) {
        let [x, y] = kernel.workgroup_size();
        recording.push(Step::Dispatch {
            kernel,
            uniforms: vec![bytemuck::bytes_of(params).to_vec()],
            resources,
            workgroups: [self.size[0].div_ceil(x), self.size[1].div_ceil(y)],
        });
    }
}

/// A stride that visits every one of `count` groups of rows, neighbours in time far apart in the image: near the golden
/// section, and coprime to the count.
fn group_stride(count: u32) -> u32 {
    let coprime = |stride: u32| {
        let (mut a, mut b) = (count, stride);
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a == 1
    };
    let golden = (f64::from(count) * 0.618).round() as u32;
    (golden.max(1)..=count.max(1)).find(|&stride| coprime(stride)).unwrap_or(1)
}

/// Rows in the order in which they are traced, in groups of a workgroup's height; the last may not all be there.
pub(super) fn padded_height([_, height]: [u32; 2]) -> u32 {
    height.next_multiple_of(GROUP_ROWS)
}

pub(super) fn pixels([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_group_of_rows_is_traced_once() {
        assert_eq!(Kernel::PathTrace(Default::default()).workgroup_size()[1], GROUP_ROWS);
        for count in 1..300 {
            let stride = group_stride(count);
            let mut visited: Vec<u32> = (0..count).map(|i| i * stride % count).collect();
            visited.sort_unstable();
            assert!(visited.into_iter().eq(0..count), "{count} groups with a stride of {stride}");
        }
    }
}
