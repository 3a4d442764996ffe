//! What a point of a volume is besides its value: which label it has, how deep below the skin it lies, and whether it is
//! clipped away.
//!
//! A [`VolumeInstance`](crate::VolumeInstance) carries all three. They act on what its medium says of a value, in this order:
//! a label may have a look of its own, clipping and peeling take away.

use std::sync::Arc;

use glam::DAffine3;

use crate::{
    labels::LabelVolume,
    medium::{MAX_DENSITY_SCALE, Medium, SurfaceReflection, most_density_scale},
    transfer_function::TransferFunction,
    volume::Volume,
};

/// Clip shapes of a volume at most, in every host: each point of a path asks all of them. Long before, drivers in software end
/// paths, which is told as lost samples. [`VolumeInstance::cuts`](crate::VolumeInstance::cuts) leaves out those beyond, and
/// hosts say so.
pub const MOST_CLIP_SHAPES: usize = 1024;

/// How the voxels of one label look; what is `None` is as the medium says.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelStyle {
    /// Whether they are there at all.
    pub visible: bool,
    /// Their colour, linear RGB of 0 to 1, in place of the transfer function's.
    pub color: Option<[f64; 3]>,
    /// Their transfer function, with its colours and without gradients.
    pub transfer_function: Option<TransferFunction>,
    /// Their density, see [`Medium::density_scale`].
    pub density_scale: Option<f64>,
    /// Multiplies their opacity, 0 to 1.
    pub opacity: f64,
    /// Their surface reflection.
    pub surface: Option<SurfaceReflection>,
    /// Whether [clip shapes](ClipShape) cut them, as they do by default.
    pub clipped: bool,
}

impl Default for LabelStyle {
    fn default() -> Self {
        Self {
            visible: true,
            color: None,
            transfer_function: None,
            density_scale: None,
            opacity: 1.0,
            surface: None,
            clipped: true,
        }
    }
}

impl LabelStyle {
    /// What is not there.
    pub fn hidden() -> Self {
        Self { visible: false, ..Self::default() }
    }

    /// The same style with every number inside its documented range; what is not a number becomes the default.
    #[must_use]
    pub fn sanitized(mut self) -> Self {
        let clamp = |x: f64, high: f64, or: f64| if x.is_nan() { or } else { x.clamp(0.0, high) };
        self.opacity = clamp(self.opacity, 1.0, 1.0);
        self.density_scale = self.density_scale.map(|x| clamp(x, MAX_DENSITY_SCALE, 1.0));
        self.color = self.color.map(|color| color.map(|c| clamp(c, 1.0, 1.0)));
        self.surface = self.surface.map(SurfaceReflection::sanitized);
        self
    }

    /// What the opacity of its transfer function is multiplied by, in place of the medium's [`density_scale`](Medium::density_scale):
    /// its own density or the medium's, [as much as the volume takes](most_density_scale), thinned by its opacity; 0 of what is
    /// not there.
    pub fn density(&self, medium: &Medium, volume: &Volume) -> f64 {
        let density = self.density_scale.unwrap_or(medium.density_scale).min(most_density_scale(volume));
        if self.visible { self.opacity * density } else { 0.0 }
    }
}

/// The labels of a scan, and how each looks.
///
/// Labels may lie on any grid: another resolution, orientation or extent than the scan's. Its outer voxels end half a voxel
/// beyond their centres, and there with their labels: where the grid is the scan's, all of the scan has one. Beyond the
/// grid there is none. Between their voxels' centres a point is of each label to the share that a cubic B-spline gives it, so that borders are
/// smooth and not stairs: the medium is the mixture of those of all labels, each in its share.
#[derive(Clone, Debug)]
pub struct Labelling {
    /// Which voxels are what. Shared by all volumes of a scan.
    pub labels: Arc<LabelVolume>,
    /// Styles by the label's value, [`UNLABELLED`](crate::UNLABELLED) included; of those that are not listed, the default. Of
    /// two for the same value, the later counts.
    pub styles: Vec<(u8, LabelStyle)>,
}

impl Labelling {
    /// Labels that all look as the medium says, but for what [lassos](crate::Lasso) cut away: that is not there.
    pub fn new(labels: Arc<LabelVolume>) -> Self {
        Self { labels, styles: vec![] }.without_cut()
    }

    /// The same, without what lassos cut away, whatever styles say of it.
    #[must_use]
    pub fn without_cut(mut self) -> Self {
        if let Some(value) = self.labels.cut_away().map(|cut| cut.value) {
            self.set_style(value, LabelStyle::hidden());
        }
        self
    }

    /// The style of a label.
    pub fn style(&self, value: u8) -> LabelStyle {
        let of = self.styles.iter().rev().find(|(of, _)| *of == value);
        of.map(|(_, style)| style.clone().sanitized()).unwrap_or_default()
    }

    /// Sets the style of a label.
    pub fn set_style(&mut self, value: u8, style: LabelStyle) {
        self.styles.retain(|(of, _)| *of != value);
        self.styles.push((value, style.sanitized()));
    }

    /// Whether another looks the same, by the identity of the labels.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.labels, &other.labels) && self.styles == other.styles
    }
}

/// What lies less deep below the skin is not there.
#[derive(Clone, Debug)]
pub struct Peel {
    /// Depth below the skin in mm, on any grid; read linearly, as the nearest voxel says beyond it.
    pub depth: Arc<Volume>,
    /// What is taken off, in mm; nothing at 0 or less. The border is one of the depth's voxels wide.
    pub mm: f64,
}

impl Peel {
    /// The width of the border in mm: the least distance between the depth's voxels.
    pub fn width_mm(&self) -> f64 {
        self.depth.spacing_mm().min_element()
    }

    /// Whether anything is taken off.
    pub fn is_active(&self) -> bool {
        self.mm > 0.0
    }

    /// The share of what is at such a depth that is left.
    pub fn share(&self, depth_mm: f64) -> f64 {
        ((depth_mm - self.mm) / self.width_mm() + 0.5).clamp(0.0, 1.0)
    }

    /// Whether another takes off the same, by the identity of the depths.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.depth, &other.depth) && self.mm == other.mm
    }
}

/// A kind of [`ClipShape`], in a space of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum ClipKind {
    /// Keeps what lies above z = 0.
    #[default]
    Plane,
    /// Keeps what lies within -1 to 1 along each axis.
    Box,
    /// Keeps what lies within the distance of 1 from the origin.
    Sphere,
}

/// Of a volume, what a shape keeps. Of several, what each of them keeps.
///
/// Within about a voxel of the shape, matter is a surface like that of a cut, with the medium's
/// [reflection](SurfaceReflection).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipShape {
    /// Its form.
    pub kind: ClipKind,
    /// The scan's millimetres from the shape's own space: where it is, how it is turned, how large it is.
    pub patient_from_shape: DAffine3,
    /// Whether what it would keep is cut away, and the rest kept.
    pub inverted: bool,
}

impl ClipShape {
    /// The half-space beyond a plane through a point, on the side that `normal` points to; in patient millimetres.
    pub fn plane(point: glam::DVec3, normal: glam::DVec3) -> Self {
        let z = normal.normalize_or(glam::DVec3::Z);
        let (x, y) = z.any_orthonormal_pair();
        let patient_from_shape = DAffine3::from_mat3_translation(glam::DMat3::from_cols(x, y, z), point);
        Self { kind: ClipKind::Plane, patient_from_shape, inverted: false }
    }

    /// A box around the axes between two corners; in patient millimetres.
    pub fn aligned_box(low: glam::DVec3, high: glam::DVec3) -> Self {
        let patient_from_shape =
            DAffine3::from_translation((low + high) / 2.0) * DAffine3::from_scale((high - low).abs() / 2.0);
        Self { kind: ClipKind::Box, patient_from_shape, inverted: false }
    }

    /// A sphere; in patient millimetres.
    pub fn sphere(centre: glam::DVec3, radius: f64) -> Self {
        let patient_from_shape =
            DAffine3::from_translation(centre) * DAffine3::from_scale(glam::DVec3::splat(radius));
        Self { kind: ClipKind::Sphere, patient_from_shape, inverted: false }
    }

    /// The same shape, cutting away what it kept.
    #[must_use]
    pub fn invert(self) -> Self {
        Self { inverted: !self.inverted, ..self }
    }

    /// Whether a point of its own space is kept.
    pub(crate) fn keeps(&self, point: glam::DVec3) -> bool {
        let is_inside = match self.kind {
            ClipKind::Plane => point.z >= 0.0,
            ClipKind::Box => point.abs().max_element() <= 1.0,
            ClipKind::Sphere => point.length() <= 1.0,
        };
        is_inside != self.inverted
    }

    /// Whether it has an inside that 32-bit floats can tell: a shape that is flattened to nothing, or placed nowhere, keeps
    /// everything.
    pub fn is_solid(&self) -> bool {
        const MOST: f64 = 1e18;
        let is_small = |map: DAffine3| map.to_cols_array().iter().all(|x| x.abs() < MOST);
        is_small(self.patient_from_shape)
            && self.patient_from_shape.matrix3.determinant().is_normal()
            && is_small(self.patient_from_shape.inverse())
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{
        labels::Label,
        volume::{Modality, Voxels},
    };

    #[test]
    fn styles_are_found_by_value_and_values_by_name() {
        let label = |value, name: &str| Label { value, name: name.into(), color: [1.0; 3] };
        let labels = LabelVolume::new(
            [2, 1, 1],
            vec![3, 5],
            DAffine3::IDENTITY,
            vec![label(3, "Liver"), label(5, "bone")],
        );
        let mut labelling = Labelling::new(Arc::new(labels.unwrap()));
        assert_eq!(labelling.style(3), LabelStyle::default());
        labelling.set_style(
            3,
            LabelStyle { opacity: f64::NAN, density_scale: Some(-1.0), ..LabelStyle::hidden() },
        );
        let style = labelling.style(3);
        assert!(!style.visible && style.opacity == 1.0 && style.density_scale == Some(0.0));
        let other = labelling.clone();
        assert!(labelling.is_same(&other));
        labelling.set_style(3, LabelStyle::default());
        assert!(!labelling.is_same(&other));
    }

    #[test]
    fn shapes_without_an_inside_are_told() {
        use glam::DVec3;
        let sphere = |radius| ClipShape::sphere(DVec3::ZERO, radius);
        assert!(sphere(1e-3).is_solid() && sphere(1e9).is_solid());
        assert!(
            ![0.0, f64::NAN, f64::INFINITY, 1e300, 1e-300]
                .into_iter()
                .any(|radius| sphere(radius).is_solid())
        );
        assert!(!ClipShape::plane(DVec3::splat(f64::NAN), DVec3::Z).is_solid());
        assert!(ClipShape::plane(DVec3::ZERO, DVec3::ZERO).is_solid(), "it looks along z");
        assert!(sphere(2.0).invert().keeps(DVec3::splat(3.0)) && sphere(2.0).keeps(DVec3::ZERO));
    }

    #[test]
    fn a_labels_density_takes_the_place_of_the_mediums() {
        let medium = Medium { density_scale: 4.0, ..Medium::new(TransferFunction::constant(1.0, [1.0; 3])) };
        let place = DAffine3::from_scale(DVec3::splat(500.0));
        let body = Volume::new([2; 3], Voxels::U8(vec![0; 8]), [1.0, 0.0], place, Modality::Ct).unwrap();
        assert_eq!(LabelStyle::default().density(&medium, &body), 4.0);
        assert_eq!(LabelStyle::hidden().density(&medium, &body), 0.0);
        let thin = LabelStyle { density_scale: Some(1.0), opacity: 0.5, ..LabelStyle::default() };
        assert_eq!(thin.density(&medium, &body), 0.5);
        let nothing = Medium { density_scale: 0.0, ..medium };
        let of = |style: &LabelStyle| style.density(&nothing, &body);
        assert_eq!([LabelStyle::default(), thin].map(|style| of(&style)), [0.0, 0.5]);
        // In a metre, a micrometre is the shortest free path.
        let most = LabelStyle { density_scale: Some(MAX_DENSITY_SCALE), ..LabelStyle::default() };
        assert_eq!(of(&most), 1e3);
    }
}
