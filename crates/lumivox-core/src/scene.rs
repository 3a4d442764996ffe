//! Volumes placed in a world, and the light around them.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use crate::{
    classification::{ClipShape, Labelling, MOST_CLIP_SHAPES, Peel},
    environment::Environment,
    light::Light,
    medium::{Medium, SIGMA_UNIT_PER_MM},
    volume::Volume,
};

/// One volume in a scene. Any number may overlap, rotated and scaled at will: their media superpose.
#[derive(Clone, Debug)]
pub struct VolumeInstance {
    /// The scan; instances may share it.
    pub volume: Arc<Volume>,
    /// Its look.
    pub medium: Medium,
    /// World metres from patient millimetres.
    pub world_from_patient: DAffine3,
    /// What is kept of the volume, as opposite corners in box coordinates (`[0, 1]^3` is everything).
    pub clip_box: [DVec3; 2],
    /// Its layers, a bit each: a [`Light`] reaches it if its mask shares one. The environment always does.
    pub layers: u32,
    /// Which of its parts are what, and how they look.
    pub labels: Option<Labelling>,
    /// What of it lies too near to the skin to be seen.
    pub peel: Option<Peel>,
    /// What is kept of it besides the clip box.
    pub clip_shapes: Vec<ClipShape>,
}

impl VolumeInstance {
    /// A whole volume, without labels, on the first layer.
    pub fn new(volume: Arc<Volume>, medium: Medium, world_from_patient: DAffine3) -> Self {
        Self {
            volume,
            medium,
            world_from_patient,
            clip_box: [DVec3::ZERO, DVec3::ONE],
            layers: 1,
            labels: None,
            peel: None,
            clip_shapes: vec![],
        }
    }

    /// A volume at true size, its centre at the world's origin, upright and facing +z.
    pub fn centered(volume: Arc<Volume>, medium: Medium) -> Self {
        let world_from_patient = world_from_patient() * DAffine3::from_translation(-volume.center_mm());
        Self::new(volume, medium, world_from_patient)
    }

    /// The clip shapes that cut it: those that are [solid](ClipShape::is_solid), the first [`MOST_CLIP_SHAPES`].
    pub fn cuts(&self) -> impl Iterator<Item = &ClipShape> {
        self.clip_shapes.iter().filter(|shape| shape.is_solid()).take(MOST_CLIP_SHAPES)
    }

    /// Whether another looks the same, see [`Scene::is_same`].
    fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.volume, &other.volume)
            && self.world_from_patient == other.world_from_patient
            && self.clip_box == other.clip_box
            && self.medium == other.medium
            && self.layers == other.layers
            && self.clip_shapes == other.clip_shapes
            && same(&self.labels, &other.labels, Labelling::is_same)
            && same(&self.peel, &other.peel, Peel::is_same)
    }

    /// Extinctions of voxels, per mm, that labels, peeling and clip shapes leave; of steep places as if they were flat, of
    /// labels as the nearest voxel says.
    pub(crate) fn extinctions(&self) -> impl Fn([usize; 3]) -> f64 + Sync + use<'_> {
        let patient_from_voxel = self.volume.patient_from_voxel();
        let extinction = self.extinctions_of_values();
        move |voxel| {
            let point = patient_from_voxel.transform_point3(DVec3::from_array(voxel.map(|i| i as f64)));
            extinction(point, self.volume.value(voxel))
        }
    }

    /// Extinctions at points of the patient's space, by the value there, per mm: what labels, peeling and clip shapes leave,
    /// while the clip box is not asked. Of steep places as if they were flat, of labels as the nearest voxel says.
    pub fn extinctions_of_values(&self) -> impl Fn(DVec3, f64) -> f64 + Sync + use<'_> {
        let voxel_from_patient = |volume: &Volume| volume.patient_from_voxel().inverse();
        let labels = self.labels.as_ref().map(|labelling| {
            let styles: Vec<_> = (0..=u8::MAX).map(|value| labelling.style(value)).collect();
            (labelling, voxel_from_patient(labelling.labels.volume()), styles)
        });
        let peel = self.peel.as_ref().filter(|peel| peel.is_active());
        let peel = peel.map(|peel| (peel, voxel_from_patient(&peel.depth)));
        let shapes: Vec<_> = self.cuts().map(|shape| (shape, shape.patient_from_shape.inverse())).collect();
        move |point, value| {
            let style = labels.as_ref().map(|(labelling, voxel_from_patient, styles)| {
                let labels = labelling.labels.volume();
                let at = nearest(labels, voxel_from_patient.transform_point3(point));
                &styles[at.map_or(0, |at| usize::from(labelling.labels.value(at)))]
            });
            let clipped = style.is_none_or(|style| style.clipped);
            let is_cut = |(shape, shape_from_patient): &(&ClipShape, DAffine3)| {
                !shape.keeps(shape_from_patient.transform_point3(point))
            };
            if clipped && shapes.iter().any(is_cut) {
                return 0.0;
            }
            let left = peel.as_ref().map_or(1.0, |(peel, voxel_from_patient)| {
                let at = voxel_from_patient.transform_point3(point);
                nearest(&peel.depth, at).map_or(1.0, |at| peel.share(peel.depth.value(at)))
            });
            let own = style.and_then(|style| style.transfer_function.as_ref());
            let function = own.unwrap_or(&self.medium.transfer_function);
            let density = style.map_or_else(
                || self.medium.density_scale_in(&self.volume),
                |style| style.density(&self.medium, &self.volume),
            );
            left * function.opacity(value) * density * SIGMA_UNIT_PER_MM
        }
    }

    /// World metres from box coordinates, where the volume fills `[0, 1]^3`.
    pub fn world_from_box(&self) -> DAffine3 {
        self.world_from_patient * self.volume.patient_from_box()
    }
}

/// The voxel nearest to a point of voxel space, if there is one.
pub(crate) fn nearest(volume: &Volume, point: DVec3) -> Option<[usize; 3]> {
    let at = point.round();
    let dims = DVec3::from_array(volume.dims().map(|n| n as f64));
    let is_inside = at.cmpge(DVec3::ZERO).all() && at.cmplt(dims).all();
    is_inside.then(|| at.to_array().map(|x| x as usize))
}

fn same<T>(a: &Option<T>, b: &Option<T>, is_same: impl Fn(&T, &T) -> bool) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => is_same(a, b),
        (None, None) => true,
        _ => false,
    }
}

/// What is rendered: volumes in the light of an environment and of any number of lamps.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The volumes, in any order.
    pub volumes: Vec<VolumeInstance>,
    /// The light from all around.
    pub environment: Environment,
    /// The engine's lights, in any order; one that is not finite is not there.
    pub lights: Vec<Light>,
}

impl Scene {
    /// A scene with one centred volume in the default environment.
    pub fn with_volume(volume: Arc<Volume>, medium: Medium) -> Self {
        Self { volumes: vec![VolumeInstance::centered(volume, medium)], ..Self::default() }
    }

    /// Whether another looks the same, by the identity of volumes and maps and not by what is in them: what an engine asks
    /// in every frame.
    pub fn is_same(&self, other: &Self) -> bool {
        self.volumes.len() == other.volumes.len()
            && self.volumes.iter().zip(&other.volumes).all(|(a, b)| a.is_same(b))
            && self.lights == other.lights
            && self.environment.is_same(&other.environment)
    }
}

/// World metres from patient millimetres (LPS) for an upright patient who faces +z: left is +x, head is +y.
pub fn world_from_patient() -> DAffine3 {
    const METRES_PER_MM: f64 = 1e-3;
    DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y) * METRES_PER_MM)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_patient_stands_upright_faces_the_viewer_and_is_not_mirrored() {
        let world = world_from_patient();
        let along = |lps: DVec3| world.transform_vector3(lps * 1000.0);
        assert_eq!(along(DVec3::Z), DVec3::Y, "head up");
        assert_eq!(along(DVec3::NEG_Y), DVec3::Z, "face towards the viewer");
        assert_eq!(along(DVec3::X), DVec3::X, "the patient's left is at the viewer's right");
        assert!(world.matrix3.determinant() > 0.0);
    }

    #[test]
    fn shapes_that_are_none_take_no_place() {
        let volume = crate::Volume::new(
            [1; 3],
            crate::Voxels::U8(vec![0]),
            [1.0, 0.0],
            DAffine3::IDENTITY,
            crate::Modality::Other,
        );
        let medium = Medium::new(crate::TransferFunction::constant(0.5, [1.0; 3]));
        let mut instance = VolumeInstance::centered(Arc::new(volume.unwrap()), medium);
        instance.clip_shapes = vec![ClipShape::sphere(DVec3::ZERO, 0.0); 5];
        assert_eq!(instance.cuts().count(), 0);
        instance.clip_shapes.extend(vec![ClipShape::sphere(DVec3::ZERO, 1.0); MOST_CLIP_SHAPES + 5]);
        assert_eq!(instance.cuts().count(), MOST_CLIP_SHAPES);
    }
}
