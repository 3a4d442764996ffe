//! Contours as labels: each slice of a structure set is filled where an odd number of a structure's contours is around a voxel, so that
//! a contour within another is a hole, and so is what a line leads to and back.
//!
//! A structure set has no grid. Slices are as near to each other as its planes, and within them voxels are as large as 512 of them need
//! to be. A plane reaches half way to its structure's next ones: where scans have thick and thin slices, or contours are in every
//! second one, nothing is left out between them.

use std::ops::Range;
use std::path::Path;

use lumivox_core::{
    CancelToken, Label,
    glam::{DAffine3, DMat3, DVec3},
};

use super::{
    ImportedLabels, Numbered, finish, no_labels,
    table::{self, Table},
    values::{MOST_LABELS, NoLabels},
};
use crate::{ImportReport, claims::Claims, colors, dicom::Structure, error::ImportError, payload};

/// Voxels across what all contours take, and their sides in mm at least and at most.
const ACROSS: f64 = 512.0;
const SIDES_MM: [f64; 2] = [0.4, 4.0];
/// Planes nearer to each other are one.
const SAME_PLANE_MM: f64 = 0.02;
/// The distance of slices where there is only one.
const ONE_SLICE_MM: f64 = 3.0;
/// Planes of a structure that are so many times as far apart as usual have a gap between them.
const GAP: f64 = 2.5;
/// The part of the usual distance of planes below which they differ by a rounding.
const ROUNDING: f64 = 0.25;
/// A contour is in a plane where its corners leave it by no more.
const FLAT_MM: f64 = 0.5;
/// More voxels than that become larger ones.
const MOST_VOXELS: f64 = 134_217_728.0;

/// The labels of a structure set. `given` names them, before all else.
pub(super) fn labels(
    path: &Path,
    structures: &[Structure],
    given: Option<&Table>,
    cancel: &CancelToken,
) -> Result<ImportedLabels, ImportError> {
    if structures.len() > MOST_LABELS {
        return Err(no_labels(path, NoLabels::TooMany));
    }
    let grid = Grid::of(path, structures)?;
    let [nx, ny, nz] = grid.dims;
    let mut claims = Claims::new(nx * ny * nz).map_err(|_| payload::too_many_voxels(path, grid.dims))?;
    for (place, structure) in structures.iter().enumerate() {
        for Plane { contours, slices } in grid.planes(structure) {
            cancel.check()?;
            fill(&contours, [nx, ny], |x, y| {
                for slice in slices.clone() {
                    claims.add((slice * ny + y) * nx + x, place as u16 + 1);
                }
            });
        }
    }
    let settled = claims.settle();
    let listed = |structure: &Structure| given.and_then(|table| table.get(&i128::from(structure.number)));
    let label = |(place, structure): (usize, &Structure)| {
        let value = place as u8 + 1;
        let listed = listed(structure);
        let own = Some(table::clean(&structure.name)).filter(|name| !name.is_empty());
        let name = listed.map(|entry| entry.name.clone()).or(own);
        Label {
            value,
            name: name.unwrap_or_else(|| format!("label {}", structure.number)),
            color: listed
                .and_then(|entry| entry.color)
                .or(structure.color)
                .unwrap_or_else(|| colors::default_color(value)),
        }
    };
    let labels: Vec<Label> = structures.iter().enumerate().map(label).collect();
    let mut report = ImportReport { format: "DICOM".to_owned(), ..ImportReport::default() };
    report.notes = notes(structures, &grid);
    report.notes.extend(settled.notes(|label| labels[usize::from(label) - 1].name.clone()));
    let numbers =
        structures.iter().zip(&labels).map(|(own, label)| (i128::from(own.number), label.value)).collect();
    let mut voxels = settled.voxels.iter().map(|label| *label as u8).collect::<Vec<u8>>();
    voxels.shrink_to_fit();
    finish(path, grid.dims, grid.patient_from_voxel(), Numbered { voxels, labels, numbers }, report)
}

fn notes(structures: &[Structure], grid: &Grid) -> Vec<String> {
    let mut notes = vec![format!(
        "contours of a structure set, filled in {} slices of {} mm",
        grid.dims[2], grid.step_mm[2]
    )];
    let empty = structures.iter().filter(|structure| structure.contours.is_empty()).count();
    if empty > 0 {
        notes.push(format!("{empty} of {} structures have no closed contour", structures.len()));
    }
    let open: usize = structures.iter().map(|structure| structure.open).sum();
    if open > 0 {
        notes.push(format!("{open} points and open lines are left out: they enclose nothing"));
    }
    notes
}

/// A structure's contours in one plane, in voxels, and the slices that it reaches.
struct Plane {
    contours: Vec<Vec<[f64; 2]>>,
    slices: Range<usize>,
}

/// Where contours become voxels.
struct Grid {
    /// Right, down and from slice to slice in the patient.
    axes: DMat3,
    /// Where the first voxel's centre is, along the axes.
    first_mm: DVec3,
    step_mm: DVec3,
    /// The usual distance of planes.
    usual_mm: f64,
    dims: [usize; 3],
}

impl Grid {
    fn of(path: &Path, structures: &[Structure]) -> Result<Self, ImportError> {
        let fault = |what: &str, remedy: &str| ImportError::Unsupported {
            path: path.to_owned(),
            what: what.to_owned(),
            remedy: remedy.to_owned(),
        };
        let contours = || structures.iter().flat_map(|structure| &structure.contours);
        let largest = contours()
            .map(|contour| area_vector(contour))
            .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        let normal = largest.and_then(DVec3::try_normalize).ok_or_else(|| {
            fault("a structure set without closed contours", "Export its structures as closed contours")
        })?;
        let axes = axes_of(normal);
        let own = |point: &DVec3| axes.transpose() * *point;
        let is_flat = |contour: &&Vec<DVec3>| {
            let depths = contour.iter().map(|corner| own(corner).z);
            let [low, high] =
                depths.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)]);
            high - low <= FLAT_MM
        };
        if !contours().all(|contour| is_flat(&contour)) {
            let remedy = "Export the contours of one orientation, or a segmentation of voxels";
            return Err(fault(
                "a structure set whose contours lie in planes of several orientations",
                remedy,
            ));
        }
        let mut planes: Vec<f64> = contours().map(|contour| depth(contour, &axes)).collect();
        planes.sort_by(f64::total_cmp);
        planes.dedup_by(|a, b| *a - *b < SAME_PLANE_MM);
        let usual_mm = usual_distance(&planes).unwrap_or(ONE_SLICE_MM);
        let steps = planes.windows(2).map(|pair| pair[1] - pair[0]);
        let step = steps.filter(|step| *step >= ROUNDING * usual_mm).fold(usual_mm, f64::min);
        let corners = || contours().flatten().map(own);
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        let extent = high - low;
        let slices = ((planes[planes.len() - 1] - planes[0]) / step).round() + 1.0;
        let mut side = (extent.x.max(extent.y) / ACROSS).clamp(SIDES_MM[0], SIDES_MM[1]);
        while (extent.x / side + 2.0) * (extent.y / side + 2.0) * slices > MOST_VOXELS {
            side *= 1.25;
            if !side.is_finite() || slices > MOST_VOXELS {
                return Err(fault("contours that lie too far apart", "Export the structures of one scan"));
            }
        }
        let count = |extent: f64| (extent / side).ceil() as usize + 2;
        Ok(Self {
            axes,
            first_mm: DVec3::new(low.x - 0.5 * side, low.y - 0.5 * side, planes[0]),
            step_mm: DVec3::new(side, side, step),
            usual_mm,
            dims: [count(extent.x), count(extent.y), slices as usize],
        })
    }

    fn patient_from_voxel(&self) -> DAffine3 {
        let matrix = self.axes * DMat3::from_diagonal(self.step_mm);
        DAffine3::from_mat3_translation(matrix, self.axes * self.first_mm)
    }

    /// The planes of a structure, from one end to the other. Of its slices none is in two of them.
    fn planes(&self, structure: &Structure) -> Vec<Plane> {
        let mut contours: Vec<(f64, &Vec<DVec3>)> =
            structure.contours.iter().map(|contour| (depth(contour, &self.axes), contour)).collect();
        contours.sort_by(|a, b| a.0.total_cmp(&b.0));
        let planes: Vec<&[(f64, &Vec<DVec3>)]> =
            contours.chunk_by(|a, b| b.0 - a.0 < SAME_PLANE_MM).collect();
        let depths: Vec<f64> = planes.iter().map(|plane| plane[0].0).collect();
        let usual = usual_distance(&depths).unwrap_or(self.usual_mm);
        // Half of the way to the next plane; at an end, and before a gap, of the usual one.
        let reach = |a: usize, b: usize| {
            let way = match (depths.get(a), depths.get(b)) {
                (Some(a), Some(b)) if b - a <= GAP * usual => b - a,
                _ => usual,
            };
            0.5 * way
        };
        // The first slice at a depth or beyond.
        let slice = |depth: f64| {
            let at = (depth - self.first_mm.z) / self.step_mm.z;
            ((at - 1e-6).ceil().max(0.0) as usize).min(self.dims[2])
        };
        let plane = |(place, plane): (usize, &&[(f64, &Vec<DVec3>)])| {
            let at = depths[place];
            let [before, after] = [reach(place.wrapping_sub(1), place), reach(place, place + 1)];
            let in_slice = |contour: &Vec<DVec3>| contour.iter().map(|it| self.in_slice(*it)).collect();
            Plane {
                contours: plane.iter().map(|(_, contour)| in_slice(contour)).collect(),
                slices: slice(at - before)..slice(at + after),
            }
        };
        planes.iter().enumerate().map(plane).collect()
    }

    /// A corner in voxels of its slice.
    fn in_slice(&self, corner: DVec3) -> [f64; 2] {
        let at = (self.axes.transpose() * corner - self.first_mm) / self.step_mm;
        [at.x, at.y]
    }
}

/// The median of the ways from plane to plane; `None` of one plane. Gaps are larger.
fn usual_distance(planes: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = planes.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied()
}

/// The patient's own axes where a normal is one of them, else right-handed ones around it.
fn axes_of(normal: DVec3) -> DMat3 {
    const EXACT: f64 = 1.0 - 1e-6;
    let normal = if normal[normal.abs().max_position()] < 0.0 { -normal } else { normal };
    match normal.abs().max_position() {
        2 if normal.z > EXACT => DMat3::IDENTITY,
        1 if normal.y > EXACT => DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y),
        0 if normal.x > EXACT => DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X),
        _ => {
            let (u, v) = normal.any_orthonormal_pair();
            let axes = DMat3::from_cols(u, v, normal);
            if axes.determinant() > 0.0 { axes } else { DMat3::from_cols(v, u, normal) }
        }
    }
}

/// The way out of a contour's plane, as long as twice its area (Newell).
fn area_vector(contour: &[DVec3]) -> DVec3 {
    let first = contour[0];
    contour.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first)).sum()
}

fn depth(contour: &[DVec3], axes: &DMat3) -> f64 {
    contour.iter().map(|corner| corner.dot(axes.z_axis)).sum::<f64>() / contour.len() as f64
}

/// Every voxel of a slice whose centre has an odd number of contours around it.
fn fill(contours: &[Vec<[f64; 2]>], [nx, ny]: [usize; 2], mut add: impl FnMut(usize, usize)) {
    let mut crossings = Vec::new();
    for y in 0..ny {
        crossings.clear();
        for contour in contours {
            for (place, [x0, y0]) in contour.iter().enumerate() {
                let [x1, y1] = contour[(place + 1) % contour.len()];
                let row = y as f64;
                // Half open, so that a corner counts once.
                if (*y0 <= row) != (y1 <= row) {
                    crossings.push(x0 + (row - y0) / (y1 - y0) * (x1 - x0));
                }
            }
        }
        crossings.sort_by(f64::total_cmp);
        for pair in crossings.chunks_exact(2) {
            let first = pair[0].ceil().max(0.0) as usize;
            let last = pair[1].min(nx as f64 - 0.5);
            (first..nx).take_while(|x| (*x as f64) < last).for_each(|x| add(x, y));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(tag: u32, vr: &[u8; 2], mut value: Vec<u8>) -> Vec<u8> {
        if value.len() % 2 == 1 {
            value.push(if vr == b"UI" { 0 } else { b' ' });
        }
        let mut bytes = [(tag >> 16) as u16, tag as u16].map(u16::to_le_bytes).concat();
        bytes.extend(vr);
        match vr {
            b"SQ" => {
                bytes.extend([0, 0]);
                bytes.extend((value.len() as u32).to_le_bytes());
            }
            _ => bytes.extend((value.len() as u16).to_le_bytes()),
        }
        bytes.extend(value);
        bytes
    }

    fn text(tag: u32, vr: &[u8; 2], text: &str) -> Vec<u8> {
        element(tag, vr, text.as_bytes().to_vec())
    }

    fn sequence(tag: u32, items: Vec<Vec<u8>>) -> Vec<u8> {
        let item = |content: Vec<u8>| {
            let mut bytes = [0xFFFE_u16, 0xE000].map(u16::to_le_bytes).concat();
            bytes.extend((content.len() as u32).to_le_bytes());
            bytes.extend(content);
            bytes
        };
        element(tag, b"SQ", items.into_iter().flat_map(item).collect())
    }

    fn contour(corners: &[[f64; 3]]) -> Vec<u8> {
        contour_of("CLOSED_PLANAR", corners)
    }

    fn contour_of(kind: &str, corners: &[[f64; 3]]) -> Vec<u8> {
        let numbers: Vec<String> = corners.iter().flatten().map(|x| format!("{x}")).collect();
        [text(0x3006_0042, b"CS", kind), text(0x3006_0050, b"DS", &numbers.join("\\"))].concat()
    }

    fn square(center: [f64; 2], half: f64, z: f64) -> Vec<u8> {
        let [x, y] = center;
        contour(&[
            [x - half, y - half, z],
            [x + half, y - half, z],
            [x + half, y + half, z],
            [x - half, y + half, z],
        ])
    }

    fn roi(number: &str, color: &str, contours: Vec<Vec<u8>>) -> Vec<u8> {
        [text(0x3006_002A, b"IS", color), sequence(0x3006_0040, contours), text(0x3006_0084, b"IS", number)]
            .concat()
    }

    /// A structure set of these regions, called `Shell` and `Core^Doe`.
    fn file(folder: &Path, regions: Vec<Vec<u8>>) -> std::path::PathBuf {
        let name = |number: &str, name: &str| {
            [text(0x3006_0022, b"IS", number), text(0x3006_0026, b"LO", name)].concat()
        };
        let meta = [text(0x0002_0010, b"UI", "1.2.840.10008.1.2.1")].concat();
        let data = [
            vec![0; 128],
            b"DICM".to_vec(),
            element(0x0002_0000, b"UL", (meta.len() as u32).to_le_bytes().to_vec()),
            meta,
            text(0x0008_0016, b"UI", "1.2.840.10008.5.1.4.1.1.481.3"),
            text(0x0008_0060, b"CS", "RTSTRUCT"),
            text(0x0010_0010, b"PN", "Doe^Jane"),
            sequence(0x3006_0020, vec![name("7", "Shell"), name("300", "Core")]),
            sequence(0x3006_0039, regions),
        ]
        .concat();
        let path = folder.join("structures.dcm");
        std::fs::write(&path, data).unwrap();
        path
    }

    fn load(path: &Path) -> Result<ImportedLabels, ImportError> {
        super::super::load_labels(
            path,
            &Default::default(),
            lumivox_core::Progress::SILENT,
            &CancelToken::new(),
        )
    }

    #[test]
    fn contours_are_filled_with_their_holes() {
        let folder = tempfile::tempdir().unwrap();
        let at = [12.0, -30.0];
        let levels = [-6.0, -3.0, 0.0, 3.0, 6.0];
        let shell = levels.iter().flat_map(|z| [square(at, 10.0, *z), square(at, 5.0, *z)]).collect();
        let core = levels[1..4].iter().map(|z| square(at, 5.0, *z)).collect();
        let path = file(folder.path(), vec![roi("7", "255\\0\\0", shell), roi("300", "0\\255\\0", core)]);
        let ImportedLabels { labels, numbers, report } = load(&path).unwrap();
        let names: Vec<&str> = labels.labels().iter().map(|label| label.name.as_str()).collect();
        assert_eq!((names, numbers), (vec!["Shell", "Core"], vec![(7, 1), (300, 2)]));
        assert_eq!(labels.labels()[0].color, [1.0, 0.0, 0.0]);
        assert_eq!(labels.dims()[2], 5);
        let counts = labels.counts();
        let ml = |value: usize| counts[value] as f64 * labels.voxel_mm3() / 1e3;
        // 300 square mm in five slices of 3 mm, and 100 in three.
        assert!((ml(1) - 4.5).abs() < 0.1 && (ml(2) - 0.9).abs() < 0.05, "{} {}", ml(1), ml(2));
        let value = |point: [f64; 3]| {
            let voxel = labels.patient_from_voxel().inverse().transform_point3(DVec3::from_array(point));
            labels.value(voxel.round().to_array().map(|x| x as usize))
        };
        assert_eq!(value([19.0, -30.0, 6.0]), 1);
        assert_eq!((value([12.0, -30.0, 0.0]), value([12.0, -30.0, 6.0])), (2, 0));
        assert!(report.notes.iter().any(|note| note.contains("5 slices of 3 mm")), "{:?}", report.notes);
    }

    /// Thick slices and thin ones, contours in every second slice, and a gap.
    #[test]
    fn nothing_is_lost_between_planes_of_other_distances() {
        let folder = tempfile::tempdir().unwrap();
        let squares = |at: [f64; 2], levels: &[f64]| levels.iter().map(|z| square(at, 5.0, *z)).collect();
        let mixed = squares([0.0, 0.0], &[0.0, 5.0, 10.0, 12.5, 15.0, 20.0, 25.0]);
        let apart = squares([30.0, 0.0], &[0.0, 5.0, 20.0, 25.0]);
        let path = file(folder.path(), vec![roi("7", "1\\2\\3", mixed), roi("300", "3\\2\\1", apart)]);
        let labels = load(&path).unwrap().labels;
        let value = |x: f64, z: f64| {
            let voxel = labels.patient_from_voxel().inverse().transform_point3(DVec3::new(x, 0.0, z));
            labels.value(voxel.round().to_array().map(|x| x as usize))
        };
        assert_eq!(labels.dims()[2], 11, "slices of 2.5 mm");
        for slice in 0..11 {
            let z = 2.5 * f64::from(slice);
            assert_eq!(value(0.0, z), 1, "at {z} mm");
            // Half of the usual way into the gap, and no further.
            let is_there = !(7.5..17.5).contains(&z);
            assert_eq!(value(30.0, z) == 2, is_there, "at {z} mm");
        }
        let every_second = squares([0.0, 0.0], &[0.0, 6.0, 12.0]);
        let all = squares([30.0, 0.0], &[0.0, 3.0, 6.0, 9.0, 12.0]);
        let path = file(folder.path(), vec![roi("7", "1\\2\\3", every_second), roi("300", "3\\2\\1", all)]);
        let counts = load(&path).unwrap().labels.counts();
        assert_eq!(counts[1], counts[2]);
    }

    #[test]
    fn what_encloses_nothing_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let point = [text(0x3006_0042, b"CS", "POINT"), text(0x3006_0050, b"DS", "1\\2\\3")].concat();
        let path = file(folder.path(), vec![roi("7", "1\\2\\3", vec![point.clone()])]);
        let error = load(&path).unwrap_err().to_string();
        assert!(error.contains("structures.dcm") && error.contains("closed contours"), "{error}");
        let corners = [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]];
        let xor = contour_of("CLOSEDPLANAR_XOR", &corners);
        assert!(load(&file(folder.path(), vec![roi("7", "1\\2\\3", vec![xor])])).is_ok());
        let regions = vec![roi("7", "1\\2\\3", vec![point, square([0.0, 0.0], 5.0, 1.0)])];
        let loaded = load(&file(folder.path(), regions)).unwrap();
        assert!(loaded.report.notes.iter().any(|note| note.starts_with("1 points and open lines")));
        // One contour across another's plane.
        let upright = contour(&[[0.0, 0.0, 0.0], [0.0, 5.0, 0.0], [0.0, 5.0, 8.0]]);
        let regions = vec![roi("7", "1\\2\\3", vec![square([0.0, 0.0], 5.0, 1.0), upright])];
        let error = load(&file(folder.path(), regions)).unwrap_err().to_string();
        assert!(error.contains("several orientations"), "{error}");
    }
}
