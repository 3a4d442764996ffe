//! Which kernels a picture needs, known before it is recorded, so that a host can make them ahead of the frame that
//! wants them (see [`Workshop`](crate::Workshop)).

use lumivox_core::{Filter, Scene};
use lumivox_shaders::{Classes, Kernel, PathTraceVariant};

use crate::limits::{DeviceLimits, FineTexels};
use crate::scene_cache::{MANY_VOLUMES, Placed, effective_lights, place};

/// What a scene holds that kernels are specialised for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Features {
    /// Light from all around that is more than one colour: a map, a gradient, the studio.
    pub environment: bool,
    /// Some volume reflects at surfaces.
    pub surface: bool,
    /// Some volume is filtered otherwise than linearly.
    pub filters: bool,
    /// Some light of the engine reaches some volume.
    pub lights: bool,
    /// There are so many volumes that rays look for them in a hierarchy.
    pub many_volumes: bool,
    /// What the media of volumes depend on besides their values.
    pub classes: Classes,
}

/// What looks at a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ViewKind {
    /// A [`View`](crate::View); with [guides](crate::ViewSettings::guides), or without.
    Still {
        /// Whether its film also holds first-hit albedo and normal.
        guides: bool,
    },
    /// A [`LiveView`](crate::LiveView), denoised or not: its coarse picture always is. With
    /// [guides](crate::LiveSettings::guides) and [kept light](crate::LiveSettings::kept_light), or without.
    Live {
        /// Whether its fine film also holds first-hit albedo and normal.
        guides: bool,
        /// Whether light is kept in the volumes for it.
        kept_light: bool,
    },
}

impl Features {
    /// Everything.
    pub const ALL: Self = Self {
        environment: true,
        surface: true,
        filters: true,
        lights: true,
        many_volumes: true,
        classes: Classes::ALL,
    };

    /// What `scene` holds.
    pub fn of(scene: &Scene) -> Self {
        let placed = place(scene);
        Self::of_placed(scene, &placed, !effective_lights(&scene.lights, &placed).is_empty())
    }

    pub(crate) fn of_placed(scene: &Scene, placed: &[Placed<'_>], lights: bool) -> Self {
        Self {
            environment: !scene.environment.is_uniform(),
            surface: placed.iter().any(Placed::reflects),
            filters: placed.iter().any(|p| matches!(p.medium.filter, Filter::Nearest | Filter::Tricubic)),
            lights,
            many_volumes: placed.len() >= MANY_VOLUMES,
            classes: placed.iter().map(Placed::classes).fold(Classes::NONE, Classes::union),
        }
    }

    /// Every scene that holds some of this, and nothing else: each has kernels of its own.
    pub fn subsets(self) -> impl Iterator<Item = Self> {
        let with = |classes| {
            (0..32u32).map(move |bits| Self {
                environment: bits & 1 != 0,
                surface: bits & 2 != 0,
                filters: bits & 4 != 0,
                lights: bits & 8 != 0,
                many_volumes: bits & 16 != 0,
                classes,
            })
        };
        Classes::sets().flat_map(with).filter(move |part| part.union(self) == self)
    }

    /// What either holds.
    pub fn union(self, other: Self) -> Self {
        Self {
            environment: self.environment | other.environment,
            surface: self.surface | other.surface,
            filters: self.filters | other.filters,
            lights: self.lights | other.lights,
            many_volumes: self.many_volumes | other.many_volumes,
            classes: self.classes.union(other.classes),
        }
    }

    /// The kernels with which a view of exactly this is recorded for a device.
    pub fn kernels(self, view: ViewKind, limits: DeviceLimits) -> Vec<Kernel> {
        use Kernel::*;
        let (alone, more) = match view {
            ViewKind::Still { guides } => (self.variant(guides, false, limits), vec![Display]),
            ViewKind::Live { .. } => (
                self.variant(false, true, limits),
                vec![
                    HostDepth,
                    FilmFade,
                    LivePicture,
                    CompositeColor,
                    CompositeDepth,
                    DenoisePrepare,
                    DenoiseWavelet,
                ],
            ),
        };
        let mut kernels = vec![
            PathTrace(alone),
            ValueRanges { one_pool: limits.one_pool },
            MajorantGrid,
            EmptySpace,
            FilmCount,
        ];
        if alone.most_sharers() > 1 && !alone.shared {
            // Of small images, and coarse ones.
            kernels.push(PathTrace(alone.for_sharers(alone.most_sharers())));
        }
        if let ViewKind::Live { guides: true, .. } = view {
            // Of the fine film; the coarse one has none.
            kernels.push(PathTrace(self.variant(true, true, limits)));
        }
        if let ViewKind::Live { kept_light: true, .. } = view
            && self.can_keep_light(limits)
        {
            kernels.extend([PathTrace(alone.for_points()), LightMarch(alone.of_picture(true))]);
            // Few may be one at any time.
            if !self.many_volumes {
                kernels.push(LightMarch(alone.of_picture(false)));
            }
            kernels.extend([LightBegin, LightInsert, LightGather, LightResolve, LightSmooth, LightFill]);
        }
        kernels.extend(more);
        kernels
    }

    pub(crate) fn variant(self, guides: bool, live: bool, limits: DeviceLimits) -> PathTraceVariant {
        // What is rare can do everything, and what takes compilers long is not made twice.
        let classified = self.classes.any();
        let variant = PathTraceVariant {
            environment_sampling: self.environment || limits.few_kernels && (classified || self.filters),
            surface: self.surface || limits.few_kernels,
            guides,
            mixed_filters: self.filters || limits.few_kernels && classified,
            live,
            lights: self.lights || limits.few_kernels,
            many_volumes: self.has_hierarchy(limits),
            classes: if classified && limits.few_kernels { Classes::ALL } else { self.classes },
            one_pool: limits.one_pool,
            split_texels: limits.fine_texels == FineTexels::TwoBytes,
            limited_turns: limits.loop_turns.is_some(),
            shared: false,
            several: false,
            points: false,
        };
        PathTraceVariant { shared: limits.few_kernels && variant.most_sharers() > 1, ..variant }
    }

    /// Whether light is kept in volumes like these: not where few kernels should do and media depend on more than values, for
    /// of those kernels alone compilers take minutes.
    pub(crate) fn can_keep_light(self, limits: DeviceLimits) -> bool {
        !limits.few_kernels || !self.classes.any()
    }

    /// Whether rays look for volumes in a hierarchy.
    pub(crate) fn has_hierarchy(self, limits: DeviceLimits) -> bool {
        self.many_volumes || limits.few_kernels && self.classes.any()
    }
}
