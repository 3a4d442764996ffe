//! A line that is drawn around something in a picture, and cuts it out of a scan: all that lies behind what the line encloses.
//!
//! What is cut away becomes a label of its own that is not there: every host shows that, borders are as smooth as those of other
//! labels, and the scan keeps its values.

use std::sync::{
    Arc,
    atomic::{AtomicUsize, Ordering},
};

use glam::{DAffine3, DVec2, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::{
    document::{Rows, affine, rows},
    labels::{CutAway, Label, LabelVolume, UNLABELLED},
    scene::nearest,
    task::{CancelToken, Cancelled, Progress, WorkStage},
    volume::Volume,
};

/// A closed line in a picture. What it encloses of a scan is cut away, as deep as the scan is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Lasso {
    /// The picture's space to the patient's (LPS), in mm. It looks along its -z, its y up; where lines of sight meet, they do so at its
    /// origin.
    #[cfg_attr(test, schemars(transform = crate::document::ranges::COORDINATE.said()))]
    pub from_picture: Rows,
    /// Whether lines of sight are parallel, as through a slice; else they meet in an eye.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub parallel: bool,
    /// The line's corners, to the right and up: at the distance of 1 mm from the eye, or where lines of sight are parallel. The last
    /// is joined to the first; what the line goes around more than once is enclosed, too.
    #[cfg_attr(test, schemars(length(min = 3, max = MOST_LASSO_POINTS), transform = crate::document::ranges::schema::points))]
    pub points: Vec<[f64; 2]>,
    /// Whether what it encloses is kept, and the rest cut away.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub inverted: bool,
}

/// Corners of a lasso at most.
pub const MOST_LASSO_POINTS: usize = 4096;

/// Lassos of a scan at most.
pub const MOST_LASSOS: usize = 256;

/// Why lassos cut nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LassoError {
    /// All values of the label map have a meaning of their own.
    #[error(
        "a scan with 255 labels has none left for what lassos cut away: hide labels instead, or take fewer of them"
    )]
    NoValueLeft,
    /// It was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl Lasso {
    /// What was drawn in a picture whose space lies in the patient like that; see the fields.
    pub fn new(patient_from_picture: DAffine3, parallel: bool, points: Vec<[f64; 2]>) -> Self {
        Self { from_picture: rows(patient_from_picture), parallel, points, inverted: false }
    }

    /// Whether it encloses a point of the patient, in mm. For many points: [`Enclosed`].
    pub fn encloses(&self, point: DVec3) -> bool {
        Enclosed::by(self).holds(point)
    }
}

/// What a lasso encloses, for many points.
pub struct Enclosed {
    picture_from_patient: DAffine3,
    parallel: bool,
    low: DVec2,
    high: DVec2,
    corners: Vec<DVec2>,
    /// The line's edges, by the corners that they begin at, by the heights that they reach over, from [`low`](Self::low) up.
    bands: Vec<Vec<u32>>,
}

impl Enclosed {
    /// Looks at a lasso once.
    pub fn by(lasso: &Lasso) -> Self {
        const MOST_BANDS: usize = 512;
        let corners: Vec<DVec2> = lasso.points.iter().copied().map(DVec2::from_array).collect();
        let far = DVec2::splat(f64::INFINITY);
        let around = |(low, high): (DVec2, DVec2), corner: &DVec2| (low.min(*corner), high.max(*corner));
        let (low, high) = corners.iter().fold((far, -far), around);
        let mut own = Self {
            picture_from_patient: affine(lasso.from_picture).inverse(),
            parallel: lasso.parallel,
            low,
            high,
            bands: vec![vec![]; corners.len().clamp(1, MOST_BANDS)],
            corners,
        };
        for index in 0..own.corners.len() {
            let [one, other] = own.edge(index).map(|end| own.band(end.y));
            for band in one.min(other)..=one.max(other) {
                own.bands[band].push(index as u32);
            }
        }
        own
    }

    /// From a corner to the next.
    fn edge(&self, index: usize) -> [DVec2; 2] {
        [self.corners[index], self.corners[(index + 1) % self.corners.len()]]
    }

    fn band(&self, y: f64) -> usize {
        let share = (y - self.low.y) / (self.high.y - self.low.y).max(f64::MIN_POSITIVE);
        ((share * self.bands.len() as f64) as usize).min(self.bands.len() - 1)
    }

    /// Whether it holds a point of the patient, in mm.
    pub fn holds(&self, point: DVec3) -> bool {
        let own = self.picture_from_patient.transform_point3(point);
        let at = match self.parallel {
            true => own.truncate(),
            // What lies behind the eye is not seen.
            false if own.z >= 0.0 => return false,
            false => own.truncate() / -own.z,
        };
        let is_near = at.cmpge(self.low).all() && at.cmple(self.high).all();
        is_near && self.turns(at) != 0
    }

    /// How often the line goes around a point: by the edges that a ray to the right crosses upwards, and downwards.
    fn turns(&self, at: DVec2) -> i32 {
        let turns = self.bands[self.band(at.y)].iter().map(|index| {
            let [from, to] = self.edge(*index as usize);
            let side = (to - from).perp_dot(at - from);
            match (from.y <= at.y, to.y <= at.y) {
                (true, false) if side > 0.0 => 1,
                (false, true) if side < 0.0 => -1,
                _ => 0,
            }
        });
        turns.sum()
    }
}

/// What the label of what lassos cut away is called.
pub const CUT_AWAY: &str = "cut away";

/// Labels of a scan in which all that lassos cut away has a label of its own, which [`Labelling`](crate::Labelling) hides. On the grid
/// of `labels`; on the scan's, where there are none or they are coarser or lie not all over it, each voxel with the label at its
/// centre. Labels that are `spared`, by their values, are not cut. Without lassos, the labels as they were.
///
/// # Errors
/// [`LassoError`] when no value is left, or `cancel` was used.
pub fn cut_by_lassos(
    volume: &Volume,
    labels: Option<&Arc<LabelVolume>>,
    lassos: &[Lasso],
    spared: &[bool; 256],
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Option<Arc<LabelVolume>>, LassoError> {
    let before = labels.and_then(|labels| match labels.cut_away() {
        Some(cut) => cut.before.clone(),
        None => Some(labels.clone()),
    });
    if lassos.is_empty() {
        return Ok(before);
    }
    let table = before.as_ref().map_or(vec![], |labels| labels.labels().to_vec());
    let is_free = |value: &u8| table.iter().all(|label| label.value != *value);
    let value = (1..=u8::MAX).rev().find(is_free).ok_or(LassoError::NoValueLeft)?;
    let own = before.as_deref().filter(|labels| are_as_fine(labels, volume));
    let (dims, patient_from_voxel) = match own {
        Some(labels) => (labels.dims(), labels.patient_from_voxel()),
        None => (volume.dims(), volume.patient_from_voxel()),
    };
    let [nx, ny, nz] = dims;
    let mut voxels = match (own, &before) {
        (Some(labels), _) => labels.voxels().to_vec(),
        (None, Some(labels)) => on_grid_of(volume, labels),
        (None, None) => vec![UNLABELLED; nx * ny * nz],
    };
    let (done, total) = (AtomicUsize::new(0), (nz * lassos.len()) as u64);
    // One after the other: what finds out quickly whether a point is enclosed takes memory.
    for lasso in lassos {
        let enclosed = Enclosed::by(lasso);
        voxels.par_chunks_mut(nx * ny).enumerate().try_for_each(|(z, slice)| {
            for (y, row) in slice.chunks_mut(nx).enumerate() {
                cancel.check()?;
                for (x, voxel) in row.iter_mut().enumerate() {
                    let point = patient_from_voxel.transform_point3(DVec3::new(x as f64, y as f64, z as f64));
                    if !spared[usize::from(*voxel)] && enclosed.holds(point) != lasso.inverted {
                        *voxel = value;
                    }
                }
            }
            progress.report(WorkStage::Cutting, done.fetch_add(1, Ordering::Relaxed) as u64 + 1, total);
            Ok::<_, Cancelled>(())
        })?;
    }
    let mut labels = table;
    labels.push(Label { value, name: CUT_AWAY.to_owned(), color: [0.5; 3] });
    let cut = LabelVolume::new(dims, voxels, patient_from_voxel, labels)
        .expect("a label for each voxel of a volume, and a value that nothing had");
    let cut = cut.with_cut(CutAway { lassos: lassos.to_vec(), value, before });
    Ok(Some(Arc::new(cut)))
}

/// Whether labels lie as close as a scan's voxels, or closer, and all over it.
fn are_as_fine(labels: &LabelVolume, volume: &Volume) -> bool {
    /// Voxels by which corners may be off.
    const NEAR: f64 = 1e-3;
    let own_from_box = labels.patient_from_voxel().inverse() * volume.patient_from_box();
    let dims = DVec3::from_array(labels.dims().map(|n| n as f64));
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
    let is_within = (0..8)
        .map(|i| own_from_box.transform_point3(corner(i)) + 0.5)
        .all(|at| at.cmpge(DVec3::splat(-NEAR)).all() && at.cmple(dims + NEAR).all());
    let voxel_mm3 = volume.patient_from_voxel().matrix3.determinant().abs();
    is_within && labels.voxel_mm3() <= voxel_mm3 * (1.0 + NEAR)
}

/// The labels at the centres of a scan's voxels.
fn on_grid_of(volume: &Volume, labels: &LabelVolume) -> Vec<u8> {
    let own_from_voxel = labels.patient_from_voxel().inverse() * volume.patient_from_voxel();
    let [nx, ny, nz] = volume.dims();
    let at = |index: usize| {
        let voxel = [index % nx, index / nx % ny, index / (nx * ny)].map(|i| i as f64);
        let own = nearest(labels.volume(), own_from_voxel.transform_point3(DVec3::from_array(voxel)));
        own.map_or(UNLABELLED, |own| labels.value(own))
    };
    (0..nx * ny * nz).into_par_iter().map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Labelling,
        labels::LabelSource,
        volume::{Modality, Voxels},
    };

    fn square(half: f64) -> Vec<[f64; 2]> {
        vec![[-half, -half], [half, -half], [half, half], [-half, half]]
    }

    /// 20 voxels of 2 mm along each axis, its middle at the origin.
    fn scan() -> Volume {
        let place = DAffine3::from_translation(DVec3::splat(-19.0)) * DAffine3::from_scale(DVec3::splat(2.0));
        Volume::new([20; 3], Voxels::U8(vec![7; 8000]), [1.0, 0.0], place, Modality::Other).unwrap()
    }

    fn cut(labels: Option<&Arc<LabelVolume>>, lassos: &[Lasso], spared: &[u8]) -> Option<Arc<LabelVolume>> {
        let spared = std::array::from_fn(|value| spared.contains(&(value as u8)));
        cut_by_lassos(&scan(), labels, lassos, &spared, Progress::SILENT, &CancelToken::new()).unwrap()
    }

    #[test]
    fn a_line_encloses_what_lies_behind_it() {
        // From 100 mm in front of the origin, looking along -z.
        let eye = DAffine3::from_translation(DVec3::Z * 100.0);
        let lasso = Lasso::new(eye, false, square(0.1));
        for (point, wanted) in [
            (DVec3::new(9.9, -9.9, 0.0), true),
            (DVec3::new(10.1, 0.0, 0.0), false),
            (DVec3::new(10.1, 0.0, -50.0), true),
            (DVec3::new(0.0, 0.0, 101.0), false),
        ] {
            assert_eq!(lasso.encloses(point), wanted, "{point}");
        }
        let parallel = Lasso { parallel: true, points: square(10.0), ..lasso };
        for (point, wanted) in [
            (DVec3::new(9.9, -9.9, 500.0), true),
            (DVec3::new(9.9, -9.9, -500.0), true),
            (DVec3::new(10.1, 0.0, 0.0), false),
        ] {
            assert_eq!(parallel.encloses(point), wanted, "{point}");
        }
    }

    #[test]
    fn a_line_that_crosses_itself_encloses_what_it_goes_around() {
        let flat = |points| Lasso::new(DAffine3::IDENTITY, true, points);
        // A pentagram: its middle is gone around twice.
        let tip = |i: usize| {
            let (sin, cos) = (std::f64::consts::TAU * (i * 2 % 5) as f64 / 5.0).sin_cos();
            [sin, cos]
        };
        let star = flat((0..5).map(tip).collect());
        assert!(star.encloses(DVec3::ZERO) && star.encloses(DVec3::new(0.0, 0.9, 0.0)));
        assert!(!star.encloses(DVec3::new(0.0, -0.6, 0.0)), "between two tips");
        // A horseshoe is not its hull; a line without an inside encloses nothing, wherever it lies.
        let shoe = flat(vec![
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 5.0],
            [4.0, 5.0],
            [4.0, 1.0],
            [1.0, 1.0],
            [1.0, 5.0],
            [0.0, 5.0],
        ]);
        assert!(!shoe.encloses(DVec3::new(2.5, 3.0, 0.0)) && shoe.encloses(DVec3::new(4.5, 3.0, 0.0)));
        let line = flat(vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]);
        assert!(!line.encloses(DVec3::new(1.0, 0.0, 0.0)));
        // Of a wavy line with many corners, against the plain sum of angles.
        let wavy: Vec<[f64; 2]> = (0..600)
            .map(|i| {
                let turn = std::f64::consts::TAU * f64::from(i) / 600.0;
                let radius = 1.0 + 0.4 * (7.0 * turn).sin() + 0.05 * (61.0 * turn).cos();
                [radius * turn.cos(), radius * turn.sin()]
            })
            .collect();
        let enclosed = flat(wavy.clone());
        for i in 0..900 {
            let at = DVec2::new(f64::from(i % 30) / 10.0 - 1.49, f64::from(i / 30) / 10.0 - 1.49);
            let angle = |k: usize| {
                let [a, b] = [wavy[k], wavy[(k + 1) % 600]].map(|corner| DVec2::from_array(corner) - at);
                a.angle_to(b)
            };
            let turns = (0..600).map(angle).sum::<f64>() / std::f64::consts::TAU;
            assert_eq!(enclosed.encloses(at.extend(0.0)), turns.abs() > 0.5, "{at} {turns}");
        }
    }

    #[test]
    fn what_is_cut_away_is_a_label_that_is_not_there() {
        let lasso = Lasso::new(DAffine3::from_translation(DVec3::Z * 100.0), false, square(0.1));
        let labels = cut(None, std::slice::from_ref(&lasso), &[]).unwrap();
        let cone = |z: usize| {
            let half = 0.1 * (100.0 - (2.0 * z as f64 - 19.0));
            (0..20).filter(|x| (2.0 * f64::from(*x) - 19.0).abs() <= half).count()
        };
        let wanted: usize = (0..20).map(|z| cone(z) * cone(z)).sum();
        let [own] = labels.labels() else { panic!("one label") };
        assert_eq!(labels.counts()[usize::from(own.value)], wanted as u64);
        assert!(!Labelling::new(labels.clone()).style(own.value).visible);
        assert_eq!(labels.cut_away().unwrap().lassos, std::slice::from_ref(&lasso));
        // What was kept is what is cut of the inverted one, and of two lassos all that any cuts.
        let rest = Lasso { inverted: true, ..lasso.clone() };
        let other = cut(None, std::slice::from_ref(&rest), &[]).unwrap();
        assert_eq!(other.counts()[usize::from(own.value)], 8000 - wanted as u64);
        let both = cut(None, &[lasso.clone(), rest], &[]).unwrap();
        assert_eq!(both.counts()[usize::from(own.value)], 8000);
        assert!(cut(Some(&both), &[], &[]).is_none(), "as it was");
    }

    #[test]
    fn labels_stay_where_nothing_is_cut_and_can_be_spared() {
        let scan = scan();
        // A map of half as many voxels along each axis: its left half is a liver.
        let place = scan.patient_from_voxel()
            * DAffine3::from_translation(DVec3::splat(0.5))
            * DAffine3::from_scale(DVec3::splat(2.0));
        let liver = Label { value: u8::MAX, name: "liver".into(), color: [0.5; 3] };
        let voxels = (0..1000).map(|i| if i % 10 < 5 { u8::MAX } else { 0 }).collect();
        let source = LabelSource { files: vec!["l.nrrd".into()], ..LabelSource::default() };
        let map = LabelVolume::new([10; 3], voxels, place, vec![liver]).unwrap().with_source(source);
        let map = Arc::new(map);
        let lasso = Lasso::new(DAffine3::IDENTITY, true, square(4.0));
        let all = cut(Some(&map), std::slice::from_ref(&lasso), &[]).unwrap();
        let value = all.cut_away().unwrap().value;
        assert_eq!(value, 254, "a value that the map does not have");
        let counts = all.counts();
        assert_eq!([counts[254], counts[255]], [16 * 20, (10 - 2) * 4 * 20 + 10 * 16 * 20]);
        assert_eq!(all.source(), map.source());
        let spared = cut(Some(&all), std::slice::from_ref(&lasso), &[u8::MAX]).unwrap();
        let counts = spared.counts();
        assert_eq!([counts[254], counts[255]], [8 * 20, 4000], "of the map as it was before");
        let again = cut(Some(&spared), &[], &[]).unwrap();
        assert!(Arc::ptr_eq(&again, &map));
    }

    #[test]
    fn cutting_can_fail_and_be_cancelled() {
        let table = (1..=u8::MAX).map(|value| Label { value, name: value.to_string(), color: [0.5; 3] });
        let full = LabelVolume::new([1; 3], vec![1], DAffine3::IDENTITY, table.collect()).unwrap();
        let lasso = [Lasso::new(DAffine3::IDENTITY, true, square(4.0))];
        let cancel = CancelToken::new();
        let full = Arc::new(full);
        let cut = |labels| {
            cut_by_lassos(&scan(), labels, &lasso, &[false; 256], Progress::SILENT, &cancel).unwrap_err()
        };
        assert_eq!(cut(Some(&full)), LassoError::NoValueLeft);
        cancel.cancel();
        assert_eq!(cut(None), LassoError::Cancelled(Cancelled));
    }

    #[test]
    fn finer_labels_keep_their_grid() {
        let scan = scan();
        let place = scan.patient_from_voxel()
            * DAffine3::from_translation(DVec3::splat(-0.25))
            * DAffine3::from_scale(DVec3::splat(0.5));
        let thin = Label { value: 9, name: "membrane".into(), color: [0.5; 3] };
        let voxels = (0..64_000).map(|i| if i % 40 == 13 { 9 } else { 0 }).collect();
        let map = Arc::new(LabelVolume::new([40; 3], voxels, place, vec![thin]).unwrap());
        let lasso = Lasso::new(DAffine3::IDENTITY, true, square(4.0));
        let cut = cut(Some(&map), std::slice::from_ref(&lasso), &[]).unwrap();
        assert_eq!((cut.dims(), cut.patient_from_voxel()), ([40; 3], place));
        assert_eq!(cut.counts()[9], 40 * 40, "it lies beside what is cut");
        assert_eq!(cut.counts()[usize::from(cut.cut_away().unwrap().value)], 8 * 8 * 40);
        // Nobody knows whose they are that came from nowhere; what lassos cut alone is of no file.
        assert!(cut.source().is_none());
        let again =
            LabelVolume::clone(&map).with_cut(CutAway { before: None, ..cut.cut_away().unwrap().clone() });
        assert!(again.source().is_none() && again.has_own());
    }
}
