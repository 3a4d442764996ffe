//! A chest of simple shapes among simple things, in every position and sampling: what is what is known at each voxel.

use lumivox_core::{
    Modality, Volume, Voxels,
    glam::{DAffine3, DMat3, DVec2, DVec3},
};

/// What is at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Truth {
    Air,
    Body,
    Lung,
    Gas,
    Thing,
}

use Truth::*;

/// How a scan is made.
#[derive(Clone, Copy)]
pub struct Scan {
    /// Voxels, and their size in mm.
    pub dims: [usize; 3],
    pub spacing: DVec3,
    /// How the patient lies on the table: turned around z, in degrees.
    pub turned: f64,
    /// The gantry's tilt, in degrees: slices are turned around x, and follow each other along z.
    pub tilt: f64,
    pub noise: f64,
    /// What lies outside the round field of view, in HU; none where it is square.
    pub padding: Option<f64>,
    /// The field of view's centre, in mm.
    pub center: DVec3,
}

impl Default for Scan {
    fn default() -> Self {
        Self {
            dims: [128, 128, 60],
            spacing: DVec3::new(3.4, 3.4, 5.0),
            turned: 0.0,
            tilt: 0.0,
            noise: 20.0,
            padding: None,
            center: DVec3::ZERO,
        }
    }
}

fn ellipse(p: DVec2, center: DVec2, radii: DVec2) -> f64 {
    ((p - center) / radii).length()
}

/// A chest with arms beside it. Its axes: x to the left, y to the back, z to the head, from -150 to 150 mm.
fn chest(p: DVec3) -> (f64, Truth) {
    let xy = p.truncate();
    // Narrower at the waist, and at the neck.
    let size = 1.0 - 0.10 * (p.z / 150.0).powi(2) - 0.25 * ((p.z - 110.0) / 40.0).clamp(0.0, 1.0);
    let trunk = ellipse(xy, DVec2::ZERO, DVec2::new(150.0, 100.0) * size);
    for side in [-1.0, 1.0] {
        let arm =
            ellipse(xy, DVec2::new(side * (172.0 + 0.04 * p.z), 25.0 + 0.05 * p.z), DVec2::new(30.0, 34.0));
        if arm < 1.0 {
            return (
                if arm < 0.3 {
                    400.0
                } else if arm < 0.85 {
                    55.0
                } else {
                    -95.0
                },
                Body,
            );
        }
        let lung = (p - DVec3::new(side * 68.0, -8.0, 40.0)) / DVec3::new(48.0, 66.0, 140.0);
        if lung.length() < 1.0 && trunk < 0.85 {
            return (-860.0, Lung);
        }
    }
    if (xy - DVec2::new(0.0, -15.0)).length() < 8.5 && p.z > 20.0 {
        return (-990.0, Gas);
    }
    if (p - DVec3::new(-40.0, -50.0, -120.0)).length() < 22.0 {
        return (-985.0, Gas);
    }
    if trunk >= 1.0 {
        return (-1000.0, Air);
    }
    let spine = ellipse(xy, DVec2::new(0.0, 62.0), DVec2::splat(18.0));
    (
        if spine < 1.0 {
            350.0
        } else if trunk > 0.9 {
            -100.0
        } else {
            50.0
        },
        Body,
    )
}

/// A table whose shell touches the back, a blanket, a cable, and specks.
fn things(p: DVec3) -> Option<f64> {
    let curve = 98.0 - 0.0012 * p.x * p.x;
    let below = p.y - curve;
    if p.x.abs() < 230.0 && ((1.0..4.5).contains(&below) || (45.0..48.5).contains(&below)) {
        return Some(120.0);
    }
    if p.x.abs() < 230.0 && (4.5..45.0).contains(&below) {
        return Some(-930.0);
    }
    let blanket = -128.0 + 8.0 * (p.x * 0.06 + p.z * 0.02).sin();
    if p.x.abs() < 190.0 && (p.y - blanket).abs() < 2.0 && p.z < 60.0 {
        return Some(-780.0);
    }
    // A cable over the chest, and one beside the table.
    let cable =
        DVec2::new(p.y + 140.0, p.z - 0.2 * p.x).length().min(DVec2::new(p.x - 205.0, p.y + 20.0).length());
    (cable < 2.6).then_some(1500.0)
}

pub fn noise(i: usize, sigma: f64) -> f64 {
    let mut hash = i as u64;
    let mut sum = -6.0;
    for _ in 0..12 {
        hash = (hash ^ 0x9e37_79b9_7f4a_7c15).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        hash ^= hash >> 29;
        sum += (hash >> 11) as f64 / (1u64 << 53) as f64;
    }
    sum * sigma
}

/// The scan, and the truth of its voxels.
pub fn scan(scan: Scan) -> (Volume, Vec<Truth>) {
    let [nx, ny, nz] = scan.dims;
    let (sine, cosine) = scan.tilt.to_radians().sin_cos();
    let matrix = DMat3::from_cols(
        DVec3::X * scan.spacing.x,
        DVec3::new(0.0, cosine, -sine) * scan.spacing.y,
        DVec3::Z * scan.spacing.z,
    );
    let middle = DVec3::new(nx as f64 - 1.0, ny as f64 - 1.0, nz as f64 - 1.0) / 2.0;
    let place = DAffine3::from_mat3_translation(matrix, scan.center - matrix * middle);
    let turn = DMat3::from_rotation_z(scan.turned.to_radians());
    let mut truth = Vec::with_capacity(nx * ny * nz);
    let mut samples = Vec::with_capacity(nx * ny * nz);
    for i in 0..nx * ny * nz {
        let voxel = DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64);
        let p = turn * place.transform_point3(voxel);
        let (mut hu, mut what) = chest(p);
        if let (Air, Some(thing)) = (what, things(p)) {
            (hu, what) = (thing, Thing);
        }
        hu += noise(i, scan.noise);
        let off = (voxel - middle).truncate() / DVec2::new(nx as f64 / 2.0, ny as f64 / 2.0);
        if let Some(padding) = scan.padding
            && off.length() > 1.0
        {
            (hu, what) = (padding, Air);
        }
        samples.push((hu.max(-3024.0) + 4000.0).round() as u16);
        truth.push(what);
    }
    let volume = Volume::new(scan.dims, Voxels::U16(samples), [1.0, -4000.0], place, Modality::Ct).unwrap();
    (volume, truth)
}
