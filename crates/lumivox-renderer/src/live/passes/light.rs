//! Light that is kept in volumes: what cells learn of paths' points, and what is seen of it.

use std::fmt;

use lumivox_shaders::{Kernel, layout};

use super::{FramePass, Use, dispatch};
use crate::live::images::{FilmImages, Image};
use crate::recording::{Payload, Recording, ResourceId, Step};
use crate::scene_cache::SceneCache;

/// Tiers of cells: as `LAST_TIER` of `light_cells.wgsl` has it.
const TIERS: u32 = 5;

/// Cells of a block.
const CELLS: u32 = 8;

/// Invocations in a row of dispatches over points and cells: as `ROW` of `light_params.wgsl` has it.
const ROW: u32 = 1 << 15;

/// What kept light lies in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightResources {
    /// The cells.
    pub cells: ResourceId,
    /// A frame's points.
    pub points: ResourceId,
}

/// Cells learn of the points that a frame's paths have left.
#[derive(Clone, Copy, Debug)]
pub struct LightCellsPass {
    /// The cells and the points.
    pub resources: LightResources,
    /// What holds for all of it.
    pub params: layout::LightParams,
}

impl FramePass for LightCellsPass {
    fn name(&self) -> &'static str {
        "light cells"
    }

    fn uses(&self) -> Vec<Use> {
        vec![]
    }

    fn record(&self, recording: &mut Recording) {
        let LightResources { cells, points } = self.resources;
        let slots = [self.params.slots, 1];
        dispatch(Kernel::LightBegin, &self.params, vec![cells], slots, recording);
        for (kernel, count) in
            [(Kernel::LightInsert, self.params.points), (Kernel::LightGather, CELLS * self.params.slots)]
        {
            let size = [ROW.min(count), count.div_ceil(ROW)];
            dispatch(kernel, &self.params, vec![cells, points], size, recording);
        }
        for tier in (0..TIERS).rev() {
            let params = layout::LightParams { tier, ..self.params };
            dispatch(Kernel::LightResolve, &params, vec![cells], slots, recording);
        }
    }
}

/// Records that no point is there, and for how many there is room.
pub(super) fn forget_points(points: ResourceId, capacity: u32, recording: &mut Recording) {
    let header = [0, capacity, 0, 0, 0, 0, 0, 0];
    recording.push(Step::WriteBuffer { id: points, offset: 0, data: Payload::copy_of(&header) });
}

/// How far it is from tap to tap of the passes that smooth a picture at most, of its height: 32 pixels of 1080. What is seen of light
/// itself is as large in a small picture.
const FARTHEST_TAP: f64 = 0.03;

/// Pixels are smoothed over taps so far apart as long as they are less sure than this, in doublings of points; over those twice as
/// far apart as long as they are less sure by one.
const SURE: f32 = 9.0;

/// What of a picture was marched is averaged along its surfaces, where cells have few points.
#[derive(Clone, Copy, Debug)]
pub struct LightSmoothPass {
    /// Planes as `light_picture.wgsl` has them, marched and not filled in.
    pub picture: Image,
    /// From where, and which pixels were.
    pub frame: layout::Frame,
}

impl FramePass for LightSmoothPass {
    fn name(&self) -> &'static str {
        "light smooth"
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::change(self.picture)]
    }

    fn record(&self, recording: &mut Recording) {
        let Self { picture, frame } = self;
        let size = marched_size(*picture, frame);
        let mut pass = |params| dispatch(Kernel::LightSmooth, &params, vec![picture.buffer], size, recording);
        let params = layout::LightSmoothParams {
            film_size: picture.size,
            first: frame.march_first,
            stride: frame.march_stride,
            pixel_size: frame.pixel_size,
            camera_parallel: frame.orthographic,
            ..Default::default()
        };
        pass(params);
        let farthest = FARTHEST_TAP * f64::from(picture.size[1]);
        let is_near = |step: &u32| *step == 1 || f64::from(step * frame.march_stride) <= farthest;
        let steps: Vec<u32> = (0..).map(|i| 1 << i).take_while(is_near).collect();
        for (i, &step) in steps.iter().enumerate() {
            pass(layout::LightSmoothParams {
                step,
                flips: (i % 2) as u32,
                is_last: u32::from(i + 1 == steps.len()),
                sure: SURE - ((step * frame.march_stride) as f32).log2(),
                ..params
            });
        }
    }
}

/// Pixels along each axis whose rays are marched.
fn marched_size(picture: Image, frame: &layout::Frame) -> [u32; 2] {
    std::array::from_fn(|axis| (picture.size[axis] - frame.march_first[axis]).div_ceil(frame.march_stride))
}

/// The picture's pixels, of those between the ones whose rays were marched.
#[derive(Clone, Copy, Debug)]
pub struct LightFill {
    /// What is known of the picture before. Sizes are set when it is recorded.
    pub params: layout::LightFillParams,
    /// That picture, and this one for the next; any others where neither is kept.
    pub buffers: [ResourceId; 2],
}

/// A picture from the light that is kept.
#[derive(Clone)]
pub struct LightPicturePass<'a> {
    /// What is seen.
    pub scene: &'a SceneCache,
    /// Its light.
    pub cells: ResourceId,
    /// Rays end where those of this film do.
    pub film: FilmImages,
    /// What comes out: planes as `light_picture.wgsl` has them.
    pub picture: Image,
    /// How pixels between those whose rays are marched are filled in.
    pub fill: LightFill,
    /// From where, and how.
    pub frame: layout::Frame,
}

impl fmt::Debug for LightPicturePass<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A scene is long.
        let Self { cells, film, picture, fill, frame, .. } = self;
        let mut this = f.debug_struct("LightPicturePass");
        this.field("cells", cells).field("film", film).field("picture", picture);
        this.field("fill", fill).field("frame", frame);
        this.finish_non_exhaustive()
    }
}

impl FramePass for LightPicturePass<'_> {
    fn name(&self) -> &'static str {
        "light picture"
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::read(self.film.ray_limits()), Use::make(self.picture)]
    }

    fn record(&self, recording: &mut Recording) {
        let several = self.frame.volume_count != 1;
        let kernel = Kernel::LightMarch(self.scene.variant(false, true).of_picture(several));
        let mut resources = self.scene.media_resources();
        resources.extend([self.cells, self.film.buffer, self.picture.buffer]);
        resources.extend(self.scene.pools());
        let (first, stride) = (self.frame.march_first, self.frame.march_stride);
        dispatch(kernel, &self.frame, resources, marched_size(self.picture, &self.frame), recording);
        let smooth = LightSmoothPass { picture: self.picture, frame: self.frame };
        smooth.record(recording);
        let film_size = self.picture.size;
        let params = layout::LightFillParams { film_size, first, stride, ..self.fill.params };
        let [before, kept] = self.fill.buffers;
        let resources = vec![self.film.buffer, self.picture.buffer, before, kept];
        dispatch(Kernel::LightFill, &params, resources, film_size, recording);
    }
}
