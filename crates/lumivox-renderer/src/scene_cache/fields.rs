//! What instances read besides their own voxels: labels, and depths below the skin. Each is a volume in the store and an
//! entry behind the instances, which no ray meets.

use lumivox_core::glam::DAffine3;
use lumivox_shaders::constants;
use lumivox_shaders::layout::Instance;

use super::{Placed, affine_rows, voxel_from_patient};
use crate::store::{GridKey, MAX_CELL_SIZE, SceneCopy, Source, TexelScale};

/// What a field holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FieldKind {
    Labels,
    Depth,
}

/// Depths along a side of a cell.
const DEPTH_CELL_SIZE: u32 = 8;

/// As in `frame.wgsl`: there is none.
const NO_VOLUME: u32 = u32::MAX;

/// A field of an instance. Instances share its voxels, not its place.
#[derive(Clone, Debug)]
pub(super) struct Field {
    /// Which instance reads it.
    pub of: usize,
    pub kind: FieldKind,
    pub source: Source,
}

impl Field {
    /// The fields of instances.
    pub fn all(instances: &[Placed<'_>]) -> Vec<Self> {
        let of = |(of, placed): (usize, &Placed<'_>)| {
            Self::sources(placed).map(move |(kind, source)| Self { of, kind, source }).collect::<Vec<_>>()
        };
        instances.iter().enumerate().flat_map(of).collect()
    }

    /// What an instance reads.
    pub fn sources(placed: &Placed<'_>) -> impl Iterator<Item = (FieldKind, Source)> + use<> {
        let labels = placed.instance.labels.as_ref();
        let labels = labels.map(|l| (FieldKind::Labels, Source::labels(l.labels.volume())));
        let peel = placed.instance.peel.as_ref().filter(|peel| peel.is_active());
        let depth =
            peel.map(|peel| (FieldKind::Depth, Source::new(&peel.depth, lumivox_core::Filter::Trilinear)));
        labels.into_iter().chain(depth)
    }

    /// The place among all of an instance's field.
    pub fn find(fields: &[Self], of: usize, kind: FieldKind) -> Option<usize> {
        fields.iter().position(|field| field.of == of && field.kind == kind)
    }

    /// Its grid: large cells of labels, for they only say where voxels are. Those of depths also say how deep it is in them.
    pub fn grid_key(&self) -> GridKey {
        let cell_size = match self.kind {
            FieldKind::Labels => MAX_CELL_SIZE,
            FieldKind::Depth => DEPTH_CELL_SIZE,
        };
        GridKey::new(lumivox_core::Filter::Trilinear, Some(cell_size))
    }

    /// All as kernels read them. `acquired` has what is there of a source, `grid` where the cells of a field begin.
    pub fn twins<'a>(
        fields: &[Self],
        instances: &[Placed<'_>],
        acquired: impl Fn(&Source) -> &'a SceneCopy,
        grid: impl Fn(usize) -> usize,
    ) -> Vec<Instance> {
        let twin = |(i, field): (usize, &Self)| {
            let of = &instances[field.of];
            let factor = acquired(&of.source()).bricks.factor;
            let patient_from_voxel = voxel_from_patient(&of.instance.volume, factor).inverse();
            field.twin(acquired(&field.source), patient_from_voxel, grid(i))
        };
        fields.iter().enumerate().map(twin).collect()
    }

    /// As kernels read it: `voxel_from_world` maps from the voxel space of the instance, and `table_scale` and
    /// `table_bias` send texels to values.
    fn twin(&self, copy: &SceneCopy, patient_from_voxel: DAffine3, grid_offset: usize) -> Instance {
        let SceneCopy { bricks, ranges } = copy;
        let volume = &*self.source.volume;
        let texel = TexelScale::of(volume);
        Instance {
            voxel_from_world: affine_rows(voxel_from_patient(volume, bricks.factor) * patient_from_voxel),
            bricks: bricks.grid.counts,
            dims: bricks.grid.dims.map(|n| n as f32),
            grid_dims: ranges.grid_dims,
            grid_offset: grid_offset as u32,
            cell_size: ranges.cell_size as f32,
            cells_per_voxel: 1.0 / ranges.cell_size as f32,
            table_scale: texel.per_texel as f32,
            table_bias: texel.at_zero as f32,
            filter_kind: constants::FILTER_TRILINEAR,
            cells_per_brick: constants::BRICK_SIZE / ranges.cell_size,
            ..Default::default()
        }
    }

    /// What kernels are told of the labels of instance `of`: their place among all instances, where fields begin at `first`, and
    /// whether their voxels are those of the volume. `twins` are the fields as kernels read them.
    pub fn labels_of(of: usize, fields: &[Self], twins: &[Instance], first: usize) -> u32 {
        let Some(at) = Self::find(fields, of, FieldKind::Labels) else { return NO_VOLUME };
        let of_voxels = affine_rows(DAffine3::IDENTITY);
        let rows = twins[at].voxel_from_world.iter().flatten().zip(of_voxels.iter().flatten());
        // Far less than what a label is drawn by, which has steps of 1/256 voxel.
        let is_same = rows.map(|(own, same)| (own - same).abs()).all(|apart| apart < 1e-6);
        (first + at) as u32 | if is_same { constants::LABELS_LIE_ON_VOXELS } else { 0 }
    }
}
