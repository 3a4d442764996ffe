//! What a film still lacks, as its GPU counts it: hosts compare what they asked for with what they got.
//!
//! A sample counts when its path has ended. Where the driver ends invocations after so many turns of their loops
//! ([`LoopTurns`](crate::LoopTurns)), paths that take more are put aside and go on in later dispatches.

use lumivox_shaders::layout::{self, FilmCount};
use lumivox_shaders::{Kernel, constants};

use crate::error::RenderError;
use crate::limits::{DeviceLimits, LoopTurns};
use crate::recording::{Payload, Recording, ResourceId, Step};
use crate::scene_cache::check_binding;

/// Bytes that are put aside for the path of a pixel.
fn path_bytes(guides: bool) -> u64 {
    if guides { 96 } else { 64 }
}

/// The same, where it leaves a point for the light that is kept.
const PATH_BYTES_WITH_POINT: u64 = 96;

/// Invocations that count a film at most. Each takes every n-th pixel, of n invocations.
const COUNTERS: u64 = 1 << 14;

/// The paths of a film that are put aside, and what its last count said.
#[derive(Debug)]
pub(crate) struct Unfinished {
    turns: Option<LoopTurns>,
    paths: Option<ResourceId>,
    count: ResourceId,
    last: FilmCount,
    /// Of its pixels, those that will not get what they lack.
    lost: u32,
    /// Whether what the last count found missing has been recorded since.
    retried: bool,
}

impl Unfinished {
    /// For a film of `pixels`.
    ///
    /// # Errors
    /// [`RenderError`] when the device does not bind so much.
    pub fn new(
        pixels: u64,
        guides: bool,
        limits: DeviceLimits,
        remedy: &'static str,
        recording: &mut Recording,
    ) -> Result<Self, RenderError> {
        Self::with_bytes(pixels * path_bytes(guides), limits, remedy, recording)
    }

    /// For paths that leave points.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn for_points(
        pixels: u64,
        limits: DeviceLimits,
        remedy: &'static str,
        recording: &mut Recording,
    ) -> Result<Self, RenderError> {
        Self::with_bytes(pixels * PATH_BYTES_WITH_POINT, limits, remedy, recording)
    }

    fn with_bytes(
        bytes: u64,
        limits: DeviceLimits,
        remedy: &'static str,
        recording: &mut Recording,
    ) -> Result<Self, RenderError> {
        if limits.loop_turns.is_some() {
            check_binding("buffer of a film's paths", bytes, limits.max_storage_binding, remedy)?;
        }
        Ok(Self {
            turns: limits.loop_turns,
            paths: limits.loop_turns.map(|_| recording.create_buffer("paths", bytes)),
            count: recording.create_buffer("film count", size_of::<FilmCount>() as u64),
            last: FilmCount::default(),
            lost: 0,
            retried: false,
        })
    }

    /// Bytes of a pixel in the buffer of paths, which is there where loops have a limit.
    pub fn bytes_per_pixel(guides: bool, limits: DeviceLimits) -> u64 {
        limits.loop_turns.map_or(0, |_| path_bytes(guides))
    }

    /// The same, of paths that leave points.
    pub fn bytes_per_pixel_of_points(limits: DeviceLimits) -> u64 {
        limits.loop_turns.map_or(0, |_| PATH_BYTES_WITH_POINT)
    }

    /// Whether a dispatch may leave paths behind.
    pub fn puts_aside(&self) -> bool {
        self.turns.is_some()
    }

    /// Where paths are put aside, if any are: what the kernel binds behind the film.
    pub fn paths(&self) -> Option<ResourceId> {
        self.paths
    }

    /// Where the film is counted: a [`FilmCount`].
    pub fn count(&self) -> ResourceId {
        self.count
    }

    /// The dispatches by which every pixel of a film gets as far as one dispatch takes it, as the parameters in which
    /// they differ. [Those for starved paths](Self::lone_dispatches) are among them where the last count found some.
    pub fn dispatches(&self, frame: layout::Frame) -> impl Iterator<Item = layout::Frame> + use<> {
        let all = layout::Frame {
            turn_limit: self.turns.map_or(u32::MAX, |turns| turns.shared),
            lone_invocation: constants::NONE_IS_ALONE,
            ..frame
        };
        let some_starved = self.last.starved > 0;
        [all].into_iter().chain(self.lone_dispatches(frame).filter(move |_| some_starved))
    }

    /// The dispatches for starved paths, in which each has its invocation alone; none where the driver limits no loop.
    pub fn lone_dispatches(&self, frame: layout::Frame) -> impl Iterator<Item = layout::Frame> + use<> {
        self.turns.into_iter().flat_map(move |turns| {
            (0..constants::TOGETHER).map(move |lone_invocation| layout::Frame {
                turn_limit: turns.alone,
                lone_invocation,
                ..frame
            })
        })
    }

    /// Records that a count of the film comes back, for [`counted`](Self::counted).
    pub fn record_count(
        &self,
        film: ResourceId,
        pixels: u64,
        target_samples: u32,
        recording: &mut Recording,
    ) {
        record_count(self.count, film, pixels, target_samples, recording);
    }

    /// Takes the bytes of a count.
    ///
    /// # Errors
    /// [`RenderError::SamplesLost`] when pixels lack samples and no dispatch will bring them. Others may, and are
    /// [`missing`](Self::missing).
    ///
    /// # Panics
    /// If those are fewer bytes than a [`FilmCount`] has.
    pub fn counted(&mut self, bytes: &[u8]) -> Result<FilmCount, RenderError> {
        let count: FilmCount = bytemuck::pod_read_unaligned(&bytes[..size_of::<FilmCount>()]);
        let retried = std::mem::take(&mut self.retried);
        self.last = count;
        self.lost = if retried && self.turns.is_none() { count.short.max(count.stuck) } else { count.stuck };
        match self.lost {
            0 => Ok(count),
            pixels => Err(RenderError::SamplesLost { pixels }),
        }
    }

    /// Pixels that lack samples by the last count, or have a path put aside, and can get what they lack.
    pub fn missing(&self) -> u32 {
        self.last.short.saturating_sub(self.lost).max(self.last.aside + self.last.starved)
    }

    /// Whether anything is missing. If so, what is recorded next has to bring it: where nothing is put aside, what is
    /// missing after that is lost.
    pub fn begin_retry(&mut self) -> bool {
        self.retried = self.missing() > 0;
        self.retried
    }

    /// The film is empty again.
    pub fn forget(&mut self) {
        self.last = FilmCount::default();
        self.lost = 0;
        self.retried = false;
    }

    /// Records that everything is freed.
    pub fn free(self, recording: &mut Recording) {
        recording.free(self.paths);
        recording.push(Step::Free { id: self.count });
    }
}

/// Records that a film is counted, and that the count comes back.
pub(crate) fn record_count(
    count: ResourceId,
    film: ResourceId,
    pixels: u64,
    target_samples: u32,
    recording: &mut Recording,
) {
    let kernel = Kernel::FilmCount;
    let [x, _] = kernel.workgroup_size();
    let workgroups = pixels.min(COUNTERS).div_ceil(u64::from(x)) as u32;
    let params = layout::FilmCountParams {
        pixels: pixels as u32,
        invocations: workgroups * x,
        target_samples,
        padding: 0,
    };
    let nothing = FilmCount { samples: u32::MAX, ..Default::default() };
    recording.push(Step::WriteBuffer { id: count, offset: 0, data: Payload::copy_of(&[nothing]) });
    recording.push(Step::Dispatch {
        kernel,
        uniforms: vec![bytemuck::bytes_of(&params).to_vec()],
        resources: vec![film, count],
        workgroups: [workgroups, 1],
    });
    recording.push(Step::ReadBuffer { id: count, range: 0..size_of::<FilmCount>() as u64 });
}
