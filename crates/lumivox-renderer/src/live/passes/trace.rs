//! Samples of a film.

use std::fmt;

use lumivox_core::Camera;
use lumivox_shaders::{Kernel, constants, layout};

use super::light::forget_points;
use super::{FramePass, Use};
use crate::frame;
use crate::live::film::{GROUP_ROWS, padded_height};
use crate::live::images::FilmImages;
use crate::live::light::LightFields;
use crate::recording::{Recording, ResourceId, Step};
use crate::scene_cache::SceneCache;
use crate::unfinished::Unfinished;

/// The paths of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSettings {
    /// Where they begin.
    pub camera: Camera,
    /// Chooses the random numbers.
    pub seed: u32,
    /// Bounces before Russian roulette may end one.
    pub roulette_start: u32,
    /// Linear RGB radiance from everywhere besides the surroundings.
    pub ambient: [f32; 3],
}

/// A share of a film's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// So many more for each pixel,
    pub samples: u32,
    /// so many at most in all,
    pub limit: u32,
    /// in these rows: from the first to before the second. They count in the order in which rows are traced; all of them are
    /// the height, rounded up to a workgroup's.
    pub rows: [u32; 2],
    /// Only pixels that have fewer get any; 0 for all.
    pub only_below: u32,
    /// Invocations that share the samples of a pixel; a power of two.
    pub sharers: u32,
}

impl Share {
    /// Of all pixels of an image, whatever they have.
    pub fn of_all(size: [u32; 2], samples: u32, limit: u32) -> Self {
        Self { samples, limit, rows: [0, padded_height(size)], only_below: 0, sharers: 1 }
    }
}

/// Adds samples to a film.
#[derive(Clone)]
pub struct TracePass<'a> {
    /// What is traced.
    pub scene: &'a SceneCache,
    /// What the samples go into.
    pub film: FilmImages,
    /// Where paths are put aside on devices that limit the turns of loops, 64 bytes for each pixel; 96
    /// where the film has guides.
    pub paths: Option<ResourceId>,
    /// Where paths leave points for the light that is kept, if they do, and for how many there is room. Not with guides.
    pub points: Option<(ResourceId, u32)>,
    /// The parameters of its dispatches, which are of the same rows and sharers.
    pub dispatches: Vec<layout::Frame>,
}

impl<'a> TracePass<'a> {
    /// One dispatch: it traces each path as far as a dispatch may take it.
    pub fn new(
        scene: &'a SceneCache,
        film: FilmImages,
        paths: Option<ResourceId>,
        settings: &PathSettings,
        share: Share,
    ) -> Self {
        let params = layout::Frame {
            seed: settings.seed,
            roulette_start: settings.roulette_start,
            image_size: film.size,
            film_size: film.size,
            samples: share.samples,
            sample_limit: share.limit,
            group_stride: group_stride(padded_height(film.size) / GROUP_ROWS),
            row_begin: share.rows[0],
            row_end: share.rows[1],
            sharers: share.sharers,
            ambient: settings.ambient,
            only_below: share.only_below,
            turn_limit: scene.limits().loop_turns.map_or(u32::MAX, |turns| turns.shared),
            lone_invocation: constants::NONE_IS_ALONE,
            ..frame::of(scene, &settings.camera)
        };
        Self { scene, film, paths, points: None, dispatches: vec![params] }
    }

    /// Paths leave points.
    pub(crate) fn with_points(mut self, points: ResourceId, capacity: u32, fields: LightFields) -> Self {
        self.points = Some((points, capacity));
        for params in &mut self.dispatches {
            *params = fields.put_into(*params);
        }
        self
    }

    /// The dispatches that its paths ask for, by what is known of them.
    pub(crate) fn with_starved(self, unfinished: &Unfinished) -> Self {
        let dispatches = self.dispatches.iter().flat_map(|params| unfinished.dispatches(*params)).collect();
        Self { dispatches, ..self }
    }

    /// Those for starved paths alone.
    pub(crate) fn of_starved(self, unfinished: &Unfinished) -> Self {
        let dispatches =
            self.dispatches.iter().flat_map(|params| unfinished.lone_dispatches(*params)).collect();
        Self { dispatches, ..self }
    }
}

impl fmt::Debug for TracePass<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A scene is long.
        let Self { film, paths, points, dispatches, .. } = self;
        let mut this = f.debug_struct("TracePass");
        this.field("film", film)
            .field("paths", paths)
            .field("points", points)
            .field("dispatches", dispatches);
        this.finish_non_exhaustive()
    }
}

impl FramePass for TracePass<'_> {
    fn name(&self) -> &'static str {
        "trace"
    }

    fn uses(&self) -> Vec<Use> {
        self.film.sums().map(Use::change).chain([Use::read(self.film.ray_limits())]).collect()
    }

    fn record(&self, recording: &mut Recording) {
        let mut resources = self.scene.path_trace_resources();
        resources.push(self.film.buffer);
        resources.extend(self.paths);
        resources.extend(self.points.map(|(points, _)| points));
        resources.extend(self.scene.pools());
        if let Some((points, capacity)) = self.points {
            forget_points(points, capacity, recording);
        }
        for params in &self.dispatches {
            let variant = self.scene.variant(self.film.guides, true);
            let kernel = Kernel::PathTrace(match self.points {
                Some(_) => variant.for_points(),
                None => variant.for_sharers(params.sharers),
            });
            let [x, y] = kernel.workgroup_size();
            let rows = params.row_end - params.row_begin;
            recording.push(Step::Dispatch {
                kernel,
                uniforms: vec![bytemuck::bytes_of(params).to_vec()],
                resources: resources.clone(),
                workgroups: [(self.film.size[0] * params.sharers).div_ceil(x), rows.div_ceil(y)],
            });
        }
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
