//! Whatever series is written, the same is read: every voxel has its value, at its place in the patient.

use crate::common::load;
use crate::writer::*;
use lumivox_core::glam::{DMat3, DQuat, DVec3};

/// How samples are stored.
#[derive(Clone, Copy, Debug)]
struct Stored {
    allocated: u16,
    stored: u16,
    high: u16,
    signed: bool,
}

impl Stored {
    fn any(random: &mut Random) -> Self {
        let allocated = random.one(&[8u16, 16, 16, 16, 32]);
        let stored = match allocated {
            8 => random.one(&[8, 7, 5]),
            16 => random.one(&[16, 12, 12, 10]),
            _ => random.one(&[32, 24]),
        };
        let high = if random.below(4) == 0 { allocated - 1 } else { stored - 1 };
        Self { allocated, stored, high, signed: random.below(2) == 0 }
    }

    fn value(self, random: &mut Random) -> i64 {
        let number = random.below(1 << self.stored) as i64;
        if self.signed { number - (1 << (self.stored - 1)) } else { number }
    }

    /// The bits of a value, with junk around them.
    fn bits(self, value: i64, random: &mut Random) -> u64 {
        let mask = ((1u64 << self.stored) - 1) << (self.high + 1 - self.stored);
        let junk = random.below(1 << self.allocated) as u64;
        (value as u64) << (self.high + 1 - self.stored) & mask | junk & !mask
    }
}

/// A rotation: along the axes, as most are, or any.
fn rotation(random: &mut Random) -> DMat3 {
    if random.below(2) == 0 {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let x = random.below(3);
        let y = (x + 1 + random.below(2)) % 3;
        let sign = |random: &mut Random| random.one(&[-1.0, 1.0]);
        let (x, y) = (axes[x] * sign(random), axes[y] * sign(random));
        return DMat3::from_cols(x, y, x.cross(y));
    }
    let axis = DVec3::new(random.within(-1.0, 1.0), random.within(-1.0, 1.0), random.within(-1.0, 1.0));
    let axis = axis.try_normalize().unwrap_or(DVec3::Z);
    DMat3::from_quat(DQuat::from_axis_angle(axis, random.within(-3.1, 3.1)))
}

/// A written series, and what it holds.
struct Written {
    files: Vec<Vec<u8>>,
    dims: [usize; 3],
    /// The value of each voxel and its place, x fastest.
    truth: Vec<(DVec3, f64)>,
    what: String,
}

fn series(random: &mut Random) -> Written {
    let stored = Stored::any(random);
    let syntaxes = [Syntax::Explicit, Syntax::Implicit, Syntax::BigEndian, Syntax::Deflated, Syntax::Rle];
    let syntax = random.one(&syntaxes);
    let dims = [1 + random.below(6), 1 + random.below(6), 1 + random.below(7)];
    let [columns, rows, slices] = dims;
    let turn = rotation(random);
    let spacing = DVec3::new(random.within(0.1, 3.0), random.within(0.1, 3.0), random.within(0.2, 6.0));
    let tilt = if random.below(3) == 0 { random.within(-0.5, 0.5) } else { 0.0 };
    let step = (turn.z_axis + turn.y_axis * tilt) * spacing.z * random.one(&[-1.0, 1.0]);
    let origin =
        DVec3::new(random.within(-500.0, 500.0), random.within(-500.0, 500.0), random.within(-2e3, 2e3));
    let rescale = random.one(&[[1.0, 0.0], [1.0, -1024.0], [2.5, 7.0], [-1.0, 0.0], [0.001, -3.0]]);
    let mut truth = Vec::new();
    let mut files = Vec::new();
    for k in 0..slices {
        let place = origin + step * k as f64;
        let mut bytes = Vec::new();
        for j in 0..rows {
            for i in 0..columns {
                let at = place + turn.x_axis * (spacing.x * i as f64) + turn.y_axis * (spacing.y * j as f64);
                let value = stored.value(random);
                truth.push((at, value as f64 * rescale[0] + rescale[1]));
                let word = stored.bits(value, random).to_le_bytes();
                bytes.extend(&word[..usize::from(stored.allocated) / 8]);
            }
        }
        let sample = usize::from(stored.allocated) / 8;
        if syntax == Syntax::BigEndian && sample > 1 {
            bytes.chunks_exact_mut(sample).for_each(<[u8]>::reverse);
        }
        let [x, y] = [turn.x_axis, turn.y_axis];
        let mut image = image("MR", columns as u16, rows as u16, vec![])
            .short(BITS_ALLOCATED, stored.allocated)
            .short(BITS_STORED, stored.stored)
            .short(HIGH_BIT, stored.high)
            .short(PIXEL_REPRESENTATION, stored.signed.into())
            .decimals(IMAGE_POSITION_PATIENT, &place.to_array())
            .decimals(IMAGE_ORIENTATION_PATIENT, &[x.x, x.y, x.z, y.x, y.y, y.z])
            .decimals(PIXEL_SPACING, &[spacing.y, spacing.x])
            .decimals(RESCALE_SLOPE, &[rescale[0]])
            .decimals(RESCALE_INTERCEPT, &[rescale[1]])
            // As misleading as it can be.
            .text(INSTANCE_NUMBER, "IS", &random.below(100).to_string());
        if syntax == Syntax::Rle {
            image.set(PIXEL_DATA, "OB", Value::Fragments(vec![rle(&bytes, sample)]));
        } else {
            image.set(PIXEL_DATA, "OB", Value::Bytes(bytes));
        }
        files.push(image.file(syntax));
    }
    let what = format!("{stored:?} {syntax:?} {dims:?} {spacing} tilt {tilt} {rescale:?} {turn}");
    Written { files, dims, truth, what }
}

/// Writes files under names in any order.
fn write(files: &[Vec<u8>], random: &mut Random) -> (tempfile::TempDir, Vec<std::path::PathBuf>) {
    let folder = tempfile::tempdir().unwrap();
    let paths: Vec<_> =
        (0..files.len()).map(|k| folder.path().join(format!("{:05} {k}", random.below(100_000)))).collect();
    files.iter().zip(&paths).for_each(|(file, path)| std::fs::write(path, file).unwrap());
    (folder, paths)
}

#[test]
fn what_is_written_is_read() {
    let rounds = std::env::var("LUMIVOX_ROUNDS").ok().and_then(|n| n.parse().ok()).unwrap_or(400);
    for seed in 0..rounds {
        let mut random = Random(seed);
        let written = series(&mut random);
        let (folder, _) = write(&written.files, &mut random);
        let imported = load(folder.path()).unwrap_or_else(|e| panic!("seed {seed}: {e}\n{}", written.what));
        let volume = &imported.volume;
        assert_eq!(volume.dims(), written.dims, "seed {seed}: {}", written.what);
        assert!(volume.patient_from_voxel().matrix3.determinant() > 0.0, "seed {seed}: mirrored");
        let voxel_from_patient = volume.patient_from_voxel().inverse();
        for (place, value) in &written.truth {
            let at = voxel_from_patient.transform_point3(*place);
            assert!(at.distance(at.round()) < 1e-6, "seed {seed}: {place} is at {at}\n{}", written.what);
            let found = volume.value(at.round().to_array().map(|n| n as usize));
            // 32 stored bits become floating-point samples.
            let error = 1e-6 * value.abs() + 1e-9;
            assert!(
                (found - value).abs() <= error,
                "seed {seed}: {found} is not {value} at {at}\n{}",
                written.what
            );
        }
        let summary = &imported.report.series[0];
        assert_eq!((summary.dims, summary.phases), (written.dims, 1), "seed {seed}");
    }
}

#[test]
fn a_slice_that_is_cut_short_costs_itself_only() {
    let mut kinds = [0; 4];
    for seed in 0..150 {
        let mut random = Random(1_000_000 + seed);
        let mut written = series(&mut random);
        let slices = written.dims[2];
        if slices < 3 {
            continue;
        }
        let cut = random.below(slices);
        let file = &mut written.files[cut];
        // Anywhere, or in the pixels.
        let left = if seed % 2 == 0 { random.below(file.len()) } else { file.len() - 12 - random.below(14) };
        file.truncate(left);
        let (folder, paths) = write(&written.files, &mut random);
        let imported = load(folder.path()).unwrap_or_else(|e| panic!("seed {seed}: {e}\n{}", written.what));
        let volume = &imported.volume;
        let report = &imported.report;
        assert_eq!(report.skipped.len(), 1, "seed {seed}: {:?}\n{}", report.skipped, written.what);
        assert_eq!(report.skipped[0].path, paths[cut], "seed {seed}");
        let inner = (1..slices - 1).contains(&cut) && slices > 3;
        if inner {
            // Cut in its pixels, its place is known; cut in its header, that it is an image, mostly; cut to next to
            // nothing, it is not even DICOM.
            let damaged = format!("1 of {slices} slices is damaged; left empty: slice ");
            let missing = format!("1 of {slices} slices is missing; ");
            let note =
                report.notes.iter().find(|note| note.starts_with(&damaged) || note.starts_with(&missing));
            let note = note.unwrap_or_else(|| panic!("seed {seed}: {:?}", report.notes));
            let filled = note.ends_with("filled in from the neighbours' values");
            let unlike = ["it holds no image", "not a DICOM", "not known", "no format"];
            let reason = &report.skipped[0].reason;
            assert_eq!(
                filled,
                unlike.iter().any(|words| reason.contains(words)),
                "seed {seed}: {note}: {reason}"
            );
            let empty = if filled { 0 } else { 1 };
            assert_eq!(report.empty_slices.len(), empty, "seed {seed}: {note}: {reason}");
            kinds[usize::from(filled) + 2 * usize::from(note.starts_with(&damaged))] += 1;
        }
        let voxel_from_patient = volume.patient_from_voxel().inverse();
        let slice_len = written.dims[0] * written.dims[1];
        for (k, (place, value)) in written.truth.iter().enumerate().filter(|(k, _)| k / slice_len != cut) {
            let at = voxel_from_patient.transform_point3(*place);
            assert!(at.distance(at.round()) < 1e-6, "seed {seed}: voxel {k} is at {at}");
            let found = volume.value(at.round().to_array().map(|n| n as usize));
            assert!(
                (found - value).abs() <= 1e-6 * value.abs() + 1e-9,
                "seed {seed}: {found} is not {value}"
            );
        }
    }
    println!("left empty with a place unknown, filled in, left empty with a place known: {:?}", &kinds[..3]);
    assert!(kinds[2] > 10, "{kinds:?}");
}
