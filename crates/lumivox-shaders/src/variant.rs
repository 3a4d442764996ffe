//! What path-tracing kernels are specialised for, as data: each flag's part of a kernel's name, and its constant in WGSL.

use crate::Kernel;

/// What media may depend on besides values. Each costs a kernel registers, whether a point asks for it or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Classes {
    /// Labels with looks of their own.
    pub labels: bool,
    /// Several transfer functions of a volume: labels' own, or rows by gradients.
    pub functions: bool,
    /// The gradient's magnitude. Comes with several functions.
    pub gradients: bool,
    /// Depth below the skin, by which is peeled.
    pub depth: bool,
    /// Shapes that clip.
    pub clip_shapes: bool,
    /// Some of that takes a share of the opacity off at points: labels whose opacities differ, several functions, peeling, shapes
    /// that rays are not clipped against as a whole. Otherwise a point is asked for its label where light collides, and not before.
    pub shares: bool,
}

impl Classes {
    /// Nothing.
    pub const NONE: Self = Self {
        labels: false,
        functions: false,
        gradients: false,
        depth: false,
        clip_shapes: false,
        shares: false,
    };

    /// All of it.
    pub const ALL: Self =
        Self { labels: true, functions: true, gradients: true, depth: true, clip_shapes: true, shares: true };

    /// Every set of them that there is.
    pub fn sets() -> impl Iterator<Item = Self> {
        let all = (0..64u32).map(|bits| Self {
            labels: bits & 1 != 0,
            functions: bits & 2 != 0,
            gradients: bits & 4 != 0,
            depth: bits & 8 != 0,
            clip_shapes: bits & 16 != 0,
            shares: bits & 32 != 0,
        });
        all.filter(|classes| {
            let has_several = classes.labels || classes.gradients;
            let always = classes.functions || classes.depth;
            let may = always || classes.labels || classes.clip_shapes;
            (if classes.functions { has_several } else { !classes.gradients })
                && if classes.shares { may } else { !always }
        })
    }

    /// Whether it is anything.
    pub fn any(self) -> bool {
        self != Self::NONE
    }

    /// What either holds.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            labels: self.labels | other.labels,
            functions: self.functions | other.functions,
            gradients: self.gradients | other.gradients,
            depth: self.depth | other.depth,
            clip_shapes: self.clip_shapes | other.clip_shapes,
            shares: self.shares | other.shares,
        }
    }
}

/// What a path-tracing kernel is specialised for. What is off costs nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct PathTraceVariant {
    /// Next-event estimation with multiple importance sampling. A uniform environment needs none: sampling the phase
    /// function is already perfect.
    pub environment_sampling: bool,
    /// Some volume reflects at surfaces.
    pub surface: bool,
    /// The film also holds first-hit albedo and normal.
    pub guides: bool,
    /// Some volume is filtered otherwise than linearly.
    pub mixed_filters: bool,
    /// Into a host's image: primary rays end at what the host has drawn, and every pixel counts its own samples.
    pub live: bool,
    /// Some light of the engine reaches some volume.
    pub lights: bool,
    /// There are so many volumes that rays look for them in a hierarchy.
    pub many_volumes: bool,
    /// The medium of some volume depends on more than its values: on these.
    pub classes: Classes,
    /// All voxels lie in one pool.
    pub one_pool: bool,
    /// Some pool may hold values of 16 bits in two channels of 8.
    pub split_texels: bool,
    /// The driver ends invocations after so many turns of their loops: paths are put aside in time, and taken up by the
    /// next dispatch.
    pub limited_turns: bool,
    /// Several invocations may share the samples of a pixel, as many as each dispatch says. Not with guides, nor where paths
    /// are put aside: those belong to a pixel.
    pub shared: bool,
    /// Of pictures of kept light alone: there is not just one volume.
    pub several: bool,
    /// Paths leave points for the light that is kept in volumes. Of live films without guides, whose pixels nobody shares.
    pub points: bool,
}

impl PathTraceVariant {
    /// Every combination that there is. But of classes: some of them come with nothing else and with everything else alone, as
    /// split texels do.
    pub fn all() -> impl Iterator<Item = Self> {
        let all = Classes::sets().flat_map(|classes| {
            let is_whole = !classes.any() || classes == Classes::ALL;
            let is_chosen = move |bits: u32| [0, 1023 & !4 & !256, 1024 + 255 - 4].contains(&bits);
            (0..4096u32).filter(move |bits| is_whole && *bits < 2048 || is_chosen(bits & 2047)).map(
                move |bits| Self {
                    environment_sampling: bits & 1 != 0,
                    surface: bits & 2 != 0,
                    guides: bits & 4 != 0,
                    mixed_filters: bits & 8 != 0,
                    live: bits & 16 != 0,
                    lights: bits & 32 != 0,
                    many_volumes: bits & 64 != 0,
                    one_pool: bits & 128 != 0,
                    limited_turns: bits & 256 != 0,
                    shared: bits & 512 != 0,
                    points: bits & 1024 != 0,
                    split_texels: bits & 2048 != 0,
                    several: false,
                    classes,
                },
            )
        });
        all.filter(|variant| {
            let is_for_points = variant.live && !variant.guides && !variant.shared;
            (!variant.shared || variant.most_sharers() > 1) && (!variant.points || is_for_points)
        })
    }

    /// What of it says what media are like, and where they are: what a picture of kept light is specialised for. One volume is
    /// looked for in no hierarchy.
    pub fn of_picture(self, several: bool) -> Self {
        Self {
            several,
            surface: self.surface,
            mixed_filters: self.mixed_filters,
            many_volumes: self.many_volumes && several,
            classes: self.classes,
            one_pool: self.one_pool,
            split_texels: self.split_texels,
            ..Self::default()
        }
    }

    /// The kernel whose paths leave points, and whose pixels nobody shares.
    pub fn for_points(self) -> Self {
        Self { points: true, shared: false, ..self }
    }

    /// The kernel where so many invocations share a pixel: one of its own, or the same.
    pub fn for_sharers(self, sharers: u32) -> Self {
        Self { shared: self.shared || sharers > 1, ..self }
    }

    /// Invocations that may share a pixel where the kernel is the one for that; 1 where there is no such kernel.
    pub fn most_sharers(self) -> u32 {
        let [in_a_row, _] = Kernel::PathTrace(self).workgroup_size();
        if self.guides || self.limited_turns || self.points { 1 } else { in_a_row }
    }
}

/// A flag of a variant.
pub(crate) struct Flag {
    /// In the kernel's name.
    pub name: &'static str,
    /// In its text, where its modules ask for it. What is none chooses modules or bindings.
    pub constant: Option<&'static str>,
    pub is_on: fn(&PathTraceVariant) -> bool,
}

const fn flag(
    name: &'static str,
    constant: Option<&'static str>,
    is_on: fn(&PathTraceVariant) -> bool,
) -> Flag {
    Flag { name, constant, is_on }
}

/// Those before the classes in a kernel's name.
pub(crate) const FLAGS: &[Flag] = &[
    flag("live", Some("LIVE"), |v| v.live),
    flag("guides", Some("GUIDES"), |v| v.guides),
    flag("environment", Some("ENVIRONMENT_SAMPLING"), |v| v.environment_sampling),
    flag("surface", Some("SURFACE"), |v| v.surface),
    flag("lights", Some("LIGHTS"), |v| v.lights),
    flag("filters", Some("MIXED_FILTERS"), |v| v.mixed_filters),
    flag("several", None, |v| v.several),
    flag("many", None, |v| v.many_volumes),
];

/// Of the classes. All of them are called `classes` for short.
pub(crate) const CLASSES: &[Flag] = &[
    flag("labels", Some("LABELS"), |v| v.classes.labels),
    flag("functions", Some("FUNCTIONS"), |v| v.classes.functions),
    flag("gradients", Some("GRADIENTS"), |v| v.classes.gradients),
    flag("depth", Some("PEELING"), |v| v.classes.depth),
    flag("clips", Some("CLIP_SHAPES"), |v| v.classes.clip_shapes),
    flag("shares", Some("SHARES"), |v| v.classes.shares),
];

/// Those behind them.
pub(crate) const LAST_FLAGS: &[Flag] = &[
    flag("pool", None, |v| v.one_pool),
    flag("split", None, |v| v.split_texels),
    flag("turns", None, |v| v.limited_turns),
    flag("shared", None, |v| v.shared),
    flag("points", Some("POINTS"), |v| v.points),
];

impl PathTraceVariant {
    /// The names of what is on, in the order of a kernel's name.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        let on =
            |flags: &'static [Flag]| flags.iter().filter(|flag| (flag.is_on)(self)).map(|flag| flag.name);
        let classes = if self.classes == Classes::ALL { vec!["classes"] } else { on(CLASSES).collect() };
        on(FLAGS).chain(classes).chain(on(LAST_FLAGS)).collect()
    }

    /// Its constants in WGSL.
    pub(crate) fn constants(&self) -> String {
        let flags = FLAGS.iter().chain(CLASSES).chain(LAST_FLAGS);
        let of = |flag: &Flag| Some(format!("const {}: bool = {};\n", flag.constant?, (flag.is_on)(self)));
        flags.filter_map(of).collect::<String>() + &format!("const CLASSES: bool = {};\n", self.classes.any())
    }
}
