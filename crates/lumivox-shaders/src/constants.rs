//! Numbers that Rust and WGSL share: one list makes both, and [`Kernel::wgsl`](crate::Kernel::wgsl) begins with it.

macro_rules! constants {
    ($($(#[$doc:meta])* $name:ident: $kind:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: $kind = $value;)*

        /// The same in WGSL.
        pub(crate) fn wgsl() -> String {
            let all = [$((stringify!($name), stringify!($kind), format!("{:?}", $name))),*];
            all.map(|(name, kind, value)| format!("const {name}: {kind} = {value};\n")).concat()
        }
    };
}

constants! {
    /// Entries of a transfer function's table.
    TABLE_SIZE: u32 = 4096;
    /// Pairs of numbers that it takes.
    TABLE_PAIRS: u32 = 12288;
    /// Pairs of a volume's classification before its clip shapes, of each of those, and of each label's style.
    CLASS_PAIRS: u32 = 5;
    #[expect(missing_docs, reason = "as above")]
    SHAPE_PAIRS: u32 = 8;
    #[expect(missing_docs, reason = "as above")]
    STYLE_PAIRS: u32 = 8;
    /// In a cell's class: nothing is taken off any of its points.
    CLASS_IS_WHOLE: u32 = 32;
    /// Looks of labels that cells can name: five bits, of which 0 says that there may be several.
    MOST_CELL_LOOKS: u32 = 31;
    /// Rows of four numbers of each style, and of each clip shape, where majorants are made.
    CELL_STYLE_ROWS: u32 = 2;
    #[expect(missing_docs, reason = "as above")]
    CELL_SHAPE_ROWS: u32 = 4;
    /// Kinds of clip shapes.
    CLIP_PLANE: u32 = 0;
    #[expect(missing_docs, reason = "as above")]
    CLIP_BOX: u32 = 1;
    #[expect(missing_docs, reason = "as above")]
    CLIP_SPHERE: u32 = 2;
    /// The number of labels of a cell that may have more than a set holds.
    SET_OF_MANY: u32 = 8;
    /// Voxels along a side of a brick: what the store of voxels deals in.
    BRICK_SIZE: u32 = 32;
    /// Texels along its side in a pool. A brick also holds what lies one voxel beyond it, so that a filter within it
    /// never needs another.
    BRICK_TEXELS: u32 = 33;
    /// Bits of a brick's place in its pool, in bricks along each axis, x lowest; then comes the pool.
    PAGE_BITS: u32 = 6;
    /// Bricks of a volume along an axis at most.
    MAX_BRICKS: u32 = 128;
    /// Pools that a kernel can read, where it can read more than one. Each costs every look at a voxel a little: eight 10%
    /// on an H200, four 4%.
    MAX_POOLS: u32 = 4;
    /// The weight of the second byte of a texel that is one number of 16 bits in two bytes; the first has the rest.
    LOW_BYTE: f32 = 1.0 / 257.0;

    /// Cells that a ray passes at once at most, for all around it are empty; less than the bits of any majorant.
    MAX_EMPTY_DISTANCE: u32 = 16;

    /// Set in a child of a node of the hierarchy that is a volume and not another node.
    IS_VOLUME: u32 = 0x8000_0000;

    /// [`Instance::filter_kind`](crate::layout::Instance::filter_kind).
    FILTER_NEAREST: u32 = 0;
    #[expect(missing_docs, reason = "as above")]
    FILTER_TRILINEAR: u32 = 1;
    #[expect(missing_docs, reason = "as above")]
    FILTER_TRICUBIC: u32 = 2;

    /// Set in [`Instance::labels`](crate::layout::Instance::labels) where a label's voxels are those of the volume.
    LABELS_LIE_ON_VOXELS: u32 = 0x8000_0000;

    /// Odd numbers that make three of a random number, where a label is drawn.
    FIRST_DRAW: u32 = 0x9e37_79b9;
    #[expect(missing_docs, reason = "as above")]
    SECOND_DRAW: u32 = 0xb22b_b7fb;
    #[expect(missing_docs, reason = "as above")]
    THIRD_DRAW: u32 = 0xfd90_e703;

    /// Added to a place in voxels, whose last bits become whole 512ths of one: the middle of the floats of which that is so. So many
    /// voxels, MAX_BRICKS of bricks and more, fit in before and behind; whole ones are the 13 bits above the 512ths.
    PLACE_ZERO: f32 = 24576.0;

    /// [`Light::kind`](crate::layout::Light::kind).
    LIGHT_DIRECTIONAL: u32 = 0;
    #[expect(missing_docs, reason = "as above")]
    LIGHT_POINT: u32 = 1;
    #[expect(missing_docs, reason = "as above")]
    LIGHT_SPOT: u32 = 2;
    /// Metres from a lamp below which it gets no brighter.
    MIN_LIGHT_DISTANCE: f32 = 1e-3;

    /// [`Frame::lone_invocation`](crate::layout::Frame::lone_invocation): all work.
    NONE_IS_ALONE: u32 = 0xffff_ffff;
    /// State of a pixel's path in its film: none is under way.
    PATH_NONE: f32 = 0.0;
    /// One is put aside.
    PATH_ASIDE: f32 = 1.0;
    /// One is put aside, though it had had an invocation's turns for a single event.
    PATH_STARVED: f32 = 2.0;
    /// One had all turns that there are for a single event, and is given up.
    PATH_STUCK: f32 = 3.0;
    /// Invocations, at most, that a driver in software runs together as one vector.
    TOGETHER: u32 = 16;

    /// Samples of a live pixel after which the coarse film is out of the picture.
    FINE_ALONE: u32 = 32;
    /// Samples of a live pixel after which kept light is out of the picture, which is unbiased then.
    KEPT_LIGHT_UNTIL: u32 = 256;
    /// [`LivePictureParams::fog_kind`](crate::layout::LivePictureParams::fog_kind).
    FOG_NONE: u32 = 0;
    #[expect(missing_docs, reason = "as above")]
    FOG_EXPONENTIAL: u32 = 1;
    #[expect(missing_docs, reason = "as above")]
    FOG_BETWEEN: u32 = 2;
    #[expect(missing_docs, reason = "as above")]
    FOG_LINEAR_IN_DEPTH: u32 = 3;
    #[expect(missing_docs, reason = "as above")]
    FOG_EXPONENTIAL_IN_DEPTH: u32 = 4;
    #[expect(missing_docs, reason = "as above")]
    FOG_EXPONENTIAL_SQUARED_IN_DEPTH: u32 = 5;

    /// [`DisplayParams::tone_operator`](crate::layout::DisplayParams::tone_operator).
    TONE_PLAIN: u32 = 0;
    #[expect(missing_docs, reason = "as above")]
    TONE_AGX: u32 = 1;
    #[expect(missing_docs, reason = "as above")]
    TONE_ACES: u32 = 2;
    /// [`DisplayParams::background_kind`](crate::layout::DisplayParams::background_kind).
    BACKGROUND_TRANSPARENT: u32 = 0;
    #[expect(missing_docs, reason = "as above")]
    BACKGROUND_COLOR: u32 = 1;
    #[expect(missing_docs, reason = "as above")]
    BACKGROUND_ENVIRONMENT: u32 = 2;
}
