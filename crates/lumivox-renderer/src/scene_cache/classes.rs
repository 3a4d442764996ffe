//! What the points of an instance are besides their values, as kernels read it: styles of labels, peeling, clip shapes (see
//! `classified_media.wgsl`).

use lumivox_core::glam::DAffine3;
use lumivox_core::{
    ClipKind, ClipShape, LabelStyle, Medium, SurfaceReflection, TransferFunction, VolumeInstance,
};
use lumivox_shaders::{Classes, constants};

use super::affine_rows;
use super::tables::{Envelope, Function};
use crate::store::TexelScale;

/// What the medium of an instance depends on besides its values.
pub(super) fn classes_of(instance: &VolumeInstance, medium: &Medium, looks: &Looks) -> Classes {
    let functions = looks.has_envelope();
    let depth = instance.peel.as_ref().is_some_and(|peel| peel.is_active());
    Classes {
        labels: instance.labels.is_some(),
        functions,
        gradients: !medium.gradients.is_empty(),
        depth,
        clip_shapes: instance.cuts().next().is_some(),
        shares: functions || depth || !looks.are_full() || Shapes::new(instance, looks).ask_points(),
    }
}

/// The looks of an instance: the medium's own, and those of its labels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Looks {
    /// Each a row, or rows by rising gradient: the medium's, then those that labels have of their own.
    pub functions: Vec<Vec<TransferFunction>>,
    /// Where rows after the first lie, per mm.
    places: Vec<f64>,
    /// The density that factors are of: the medium's, or where that is nothing the largest of a label.
    pub density: f64,
    /// By label, or the only one.
    pub styles: Vec<Style>,
    /// Of the styles that show something, one for each that is different, as many as cells can name.
    in_cells: Vec<usize>,
}

/// How a label looks.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Style {
    /// Its function among those of the instance.
    pub function: usize,
    /// Of the opacity, beside the density of the instance.
    pub factor: f64,
    color: Option<[f64; 3]>,
    surface: SurfaceReflection,
    clipped: bool,
}

impl Looks {
    pub fn new(instance: &VolumeInstance, medium: &Medium) -> Self {
        let rows = medium.gradients.iter().map(|row| row.transfer_function.clone());
        let own = std::iter::once(medium.transfer_function.clone()).chain(rows).collect();
        let styles = match &instance.labels {
            Some(labelling) => (0..=u8::MAX).map(|value| labelling.style(value)).collect(),
            None => vec![LabelStyle::default()],
        };
        let density_of = |style: &LabelStyle| style.density(medium, &instance.volume);
        let density = match medium.density_scale {
            0.0 => styles.iter().map(density_of).fold(0.0, f64::max),
            density => density,
        };
        let mut looks = Self {
            functions: vec![own],
            places: medium.gradients.iter().map(|row| row.per_mm).collect(),
            density,
            styles: vec![],
            in_cells: vec![],
        };
        for style in styles {
            let function = style.transfer_function.as_ref().map_or(0, |own| looks.function(own));
            looks.styles.push(Style {
                function,
                factor: if density > 0.0 { density_of(&style) / density } else { 0.0 },
                color: style.color,
                surface: style.surface.unwrap_or(medium.surface),
                clipped: style.clipped,
            });
        }
        for (index, style) in looks.styles.iter().enumerate() {
            let is_known = style.factor == 0.0 || looks.in_cells.iter().any(|&at| looks.styles[at] == *style);
            if !is_known && looks.in_cells.len() < constants::MOST_CELL_LOOKS as usize {
                looks.in_cells.push(index);
            }
        }
        let Self { styles, in_cells, .. } = &mut looks;
        in_cells.sort_by_key(|&at| styles[at].factor != 1.0);
        looks
    }

    /// Rows that the looks that cells can name take. Those of labels begin at a place that kernels know.
    fn rows_in_cells(&self) -> usize {
        if self.styles.len() > 1 { constants::MOST_CELL_LOOKS as usize } else { self.in_cells.len() }
    }

    /// How many of the looks that cells can name leave the opacity of their function as it is: the first ones.
    pub fn full_in_cells(&self) -> usize {
        self.in_cells.iter().take_while(|&&at| self.styles[at].factor == 1.0).count()
    }

    /// Whether all of them leave the opacity of their function as it is.
    fn are_full(&self) -> bool {
        self.styles.iter().all(|style| style.factor as f32 == 1.0)
    }

    /// The place, from 1, of a style among those that cells can name, or 0.
    fn place_in_cells(&self, style: &Style) -> usize {
        let place = self.in_cells.iter().position(|&at| self.styles[at] == *style);
        place.map_or(0, |place| place + 1)
    }

    /// Whether some label reflects.
    pub fn reflect(&self) -> bool {
        self.styles.iter().any(|style| style.surface.strength as f32 > 0.0)
    }

    /// The place of a label's own function among those of the instance.
    fn function(&mut self, own: &TransferFunction) -> usize {
        let known = self.functions.iter().skip(1).position(|rows| rows[0] == *own);
        known.map_or_else(
            || {
                self.functions.push(vec![own.clone()]);
                self.functions.len() - 1
            },
            |place| place + 1,
        )
    }

    /// Whether what a value can show at most is told by another table than its function's: there are several, or more is shown.
    pub fn has_envelope(&self) -> bool {
        self.rows() > 1 || self.styles.iter().any(|style| style.factor > 1.0)
    }

    /// That table.
    pub fn envelope(&self, functions: &[Function]) -> Option<Envelope> {
        let most = |function: usize| {
            let of_it = self.styles.iter().filter(|style| style.function == function);
            of_it.map(|style| style.factor).fold(0.0, f64::max)
        };
        let all: Vec<_> = functions.iter().enumerate().map(|(at, function)| (function, most(at))).collect();
        self.has_envelope().then(|| Envelope::new(&all))
    }

    /// Whether another has the same, where the functions are the same.
    pub fn is_bounded_like(&self, other: &Self) -> bool {
        let of = |style: &Style| (style.function, style.factor);
        self.styles.iter().map(of).eq(other.styles.iter().map(of))
    }

    /// Rows of all functions.
    pub fn rows(&self) -> usize {
        self.functions.iter().map(Vec::len).sum()
    }

    /// Of each label, as the kernel that makes majorants reads them. `first` says where a function's maxima begin.
    pub fn for_majorants(
        &self,
        functions: &[Function],
        texel: TexelScale,
        first: impl Fn(usize) -> usize,
    ) -> Vec<[f32; 4]> {
        let of = |style: &Style| {
            let (scale, bias) = functions[style.function].coordinate(texel);
            [
                [scale as f32, bias as f32, first(style.function) as f32, style.factor as f32],
                [self.place_in_cells(style) as f32, flag(style.clipped), 0.0, 0.0],
            ]
        };
        self.styles.iter().flat_map(of).collect()
    }
}

/// The clip shapes of an instance.
pub(super) struct Shapes {
    /// Those that keep one part of any ray first.
    list: Vec<ClipShape>,
    /// How many of them rays are clipped against as a whole.
    pub of_rays: usize,
}

impl Shapes {
    pub fn new(instance: &VolumeInstance, looks: &Looks) -> Self {
        // Where some label is not cut, each point has to be asked for its own.
        let cut_all = looks.styles.iter().all(|style| style.clipped || style.factor == 0.0);
        let (mut list, others): (Vec<_>, Vec<_>) =
            instance.cuts().copied().partition(|shape| cut_all && !shape.inverted);
        let of_rays = list.len();
        list.extend(others);
        Self { list, of_rays }
    }

    /// Whether there are others, which each point has to be asked for.
    fn ask_points(&self) -> bool {
        self.of_rays < self.list.len()
    }

    /// As the kernel that makes majorants reads them.
    pub fn for_majorants(&self, voxel_from_patient: DAffine3) -> Vec<[f32; 4]> {
        let of = |shape: &ClipShape| {
            let [x, y, z] = affine_rows(shape_from_voxel(shape, voxel_from_patient));
            let [kind, sign] = kind_and_sign(shape);
            [x, y, z, [kind, sign, 0.0, 0.0]]
        };
        self.list.iter().flat_map(of).collect()
    }
}

fn shape_from_voxel(shape: &ClipShape, voxel_from_patient: DAffine3) -> DAffine3 {
    shape.patient_from_shape.inverse() * voxel_from_patient.inverse()
}

/// Its kind, and -1 where it is inverted.
fn kind_and_sign(shape: &ClipShape) -> [f32; 2] {
    let kind = match shape.kind {
        ClipKind::Plane => constants::CLIP_PLANE,
        ClipKind::Box => constants::CLIP_BOX,
        ClipKind::Sphere => constants::CLIP_SPHERE,
    };
    [kind as f32, if shape.inverted { -1.0 } else { 1.0 }]
}

fn flag(is_on: bool) -> f32 {
    f32::from(u8::from(is_on))
}

/// Pairs that the classification of an instance takes.
pub(super) fn pairs_of(instance: &VolumeInstance, looks: &Looks) -> usize {
    let shapes = instance.cuts().count();
    constants::CLASS_PAIRS as usize
        + shapes * constants::SHAPE_PAIRS as usize
        + (looks.rows_in_cells() + looks.styles.len()) * constants::STYLE_PAIRS as usize
        + looks.places.len()
}

/// The classification of an instance that begins at pair `begin`; `depth` says where its field of depths is among all instances,
/// `table` where a function begins.
pub(super) fn pairs(
    instance: &VolumeInstance,
    looks: &Looks,
    functions: &[Function],
    voxel_from_patient: DAffine3,
    depth: Option<usize>,
    begin: usize,
    table: impl Fn(usize) -> usize,
) -> Vec<[f32; 2]> {
    let Shapes { list: shapes, of_rays } = Shapes::new(instance, looks);
    let first_style =
        begin + constants::CLASS_PAIRS as usize + looks.rows_in_cells() * constants::STYLE_PAIRS as usize;
    let first_shape = first_style + looks.styles.len() * constants::STYLE_PAIRS as usize;
    let first_place = first_shape + shapes.len() * constants::SHAPE_PAIRS as usize;
    let [peel, width] = instance.peel.as_ref().map_or([0.0, 1.0], |peel| [peel.mm, peel.width_mm()]);
    let cut_width = instance.volume.spacing_mm().min_element();
    // By way of 32 bits, which need no branch: compilers convert before they ask whether there is one, and valgrind objects.
    let mut pairs = vec![
        [0.0, depth.map_or(-1.0, |index| index as u32 as f32)],
        [peel as f32, (1.0 / width) as f32],
        [shapes.len() as f32, (1.0 / cut_width) as f32],
        [first_style as f32, first_shape as f32],
        [of_rays as f32, 0.0],
    ];
    let texel = TexelScale::of(&instance.volume);
    let of_style = |style: &Style| {
        let (scale, bias) = functions[style.function].coordinate(texel);
        let [r, g, b] = style.color.unwrap_or_default().map(|c| c as f32);
        let rows = looks.functions[style.function].len() - 1;
        [
            [scale as f32, bias as f32],
            [table(style.function) as f32, style.factor as f32],
            [r, g],
            [b, flag(style.color.is_some())],
            [style.surface.strength as f32, (1.0 / style.surface.gradient_per_mm) as f32],
            [style.surface.lobe_anisotropy() as f32, style.surface.specular as f32],
            [rows as f32, first_place as f32],
            [flag(style.clipped), style.surface.metallic as f32],
        ]
    };
    pairs.extend(looks.in_cells.iter().flat_map(|&at| of_style(&looks.styles[at])));
    pairs.resize(first_style - begin, [0.0; 2]);
    pairs.extend(looks.styles.iter().flat_map(of_style));
    for shape in &shapes {
        let rows = affine_rows(shape_from_voxel(shape, voxel_from_patient));
        pairs.extend(rows.into_iter().flat_map(|[x, y, z, w]| [[x, y], [z, w]]));
        pairs.extend([kind_and_sign(shape), [0.0; 2]]);
    }
    let before = std::iter::once(0.0).chain(looks.places.iter().copied());
    pairs.extend(
        looks
            .places
            .iter()
            .zip(before)
            .map(|(&place, before)| [place as f32, (1.0 / (place - before)) as f32]),
    );
    pairs
}
