//! What the points of an instance are besides their values, as kernels read it: styles of labels, peeling, clip shapes (see
//! `classified_media.wgsl`).

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{ClipKind, LabelStyle, Medium, SurfaceReflection, TransferFunction, VolumeInstance};
use lumivox_shaders::constants;

use super::tables::Function;
use crate::store::TexelScale;

/// Whether the medium of an instance depends on more than its values.
pub(super) fn is_classified(instance: &VolumeInstance, medium: &Medium) -> bool {
    instance.labels.is_some()
        || instance.peel.as_ref().is_some_and(|peel| peel.is_active())
        || instance.cuts().next().is_some()
        || !medium.gradients.is_empty()
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
        looks
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

    /// Whether another has the same majorants, where the functions are the same.
    pub fn absorb_like(&self, other: &Self) -> bool {
        let of = |style: &Style| (style.function, style.factor);
        self.styles.iter().map(of).eq(other.styles.iter().map(of))
    }

    /// Rows of all functions.
    pub fn rows(&self) -> usize {
        self.functions.iter().map(Vec::len).sum()
    }

    /// By label: scale and bias of the table's coordinate, the first of the maxima of its function, and the factor, for the
    /// kernel that makes majorants. `first` says where a function's maxima begin.
    pub fn for_majorants(
        &self,
        functions: &[Function],
        texel: TexelScale,
        first: impl Fn(usize) -> usize,
    ) -> Vec<[f32; 4]> {
        let of = |style: &Style| {
            let (scale, bias) = functions[style.function].coordinate(texel);
            [scale as f32, bias as f32, first(style.function) as f32, style.factor as f32]
        };
        self.styles.iter().map(of).collect()
    }
}

/// The fields of an instance: where they are among all instances.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Fields {
    pub labels: Option<usize>,
    pub depth: Option<usize>,
}

/// Pairs that the classification of an instance takes.
pub(super) fn pairs_of(instance: &VolumeInstance, looks: &Looks) -> usize {
    let shapes = instance.cuts().count();
    constants::CLASS_PAIRS as usize
        + shapes * constants::SHAPE_PAIRS as usize
        + looks.styles.len() * constants::STYLE_PAIRS as usize
        + looks.places.len()
}

/// The classification of an instance that begins at pair `begin`; `table` says where a function begins.
pub(super) fn pairs(
    instance: &VolumeInstance,
    looks: &Looks,
    functions: &[Function],
    voxel_from_patient: DAffine3,
    fields: Fields,
    begin: usize,
    table: impl Fn(usize) -> usize,
) -> Vec<[f32; 2]> {
    // By way of 32 bits, which need no branch: compilers convert before they ask whether there is one, and valgrind objects.
    let place = |field: Option<usize>| field.map_or(-1.0, |index| index as u32 as f32);
    let flag = |is_on: bool| f32::from(u8::from(is_on));
    let shapes: Vec<_> = instance.cuts().collect();
    let first_style =
        begin + constants::CLASS_PAIRS as usize + shapes.len() * constants::SHAPE_PAIRS as usize;
    let first_place = first_style + looks.styles.len() * constants::STYLE_PAIRS as usize;
    let [peel, width] = instance.peel.as_ref().map_or([0.0, 1.0], |peel| [peel.mm, peel.width_mm()]);
    let cut_width = instance.volume.spacing_mm().min_element();
    let mut pairs = vec![
        [place(fields.labels), place(fields.depth)],
        [peel as f32, (1.0 / width) as f32],
        [shapes.len() as f32, (1.0 / cut_width) as f32],
        [first_style as f32, 0.0],
    ];
    for shape in shapes {
        let m = shape.patient_from_shape.inverse() * voxel_from_patient.inverse();
        let linear = m.matrix3.transpose();
        let row = |r: DVec3, w: f64| [[r.x as f32, r.y as f32], [r.z as f32, w as f32]];
        pairs.extend(row(linear.x_axis, m.translation.x));
        pairs.extend(row(linear.y_axis, m.translation.y));
        pairs.extend(row(linear.z_axis, m.translation.z));
        let kind = match shape.kind {
            ClipKind::Plane => constants::CLIP_PLANE,
            ClipKind::Box => constants::CLIP_BOX,
            ClipKind::Sphere => constants::CLIP_SPHERE,
        };
        pairs.push([kind as f32, if shape.inverted { -1.0 } else { 1.0 }]);
        pairs.push([0.0; 2]);
    }
    let texel = TexelScale::of(&instance.volume);
    for style in &looks.styles {
        let (scale, bias) = functions[style.function].coordinate(texel);
        let [r, g, b] = style.color.unwrap_or_default().map(|c| c as f32);
        let rows = looks.functions[style.function].len() - 1;
        pairs.extend([
            [scale as f32, bias as f32],
            [table(style.function) as f32, style.factor as f32],
            [r, g],
            [b, flag(style.color.is_some())],
            [style.surface.strength as f32, (1.0 / style.surface.gradient_per_mm) as f32],
            [style.surface.lobe_anisotropy() as f32, style.surface.specular as f32],
            [rows as f32, first_place as f32],
            [flag(style.clipped), 0.0],
        ]);
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
