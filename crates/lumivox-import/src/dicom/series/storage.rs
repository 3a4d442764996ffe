//! How the samples of a volume are kept: scans with one rescale keep their stored integers, with an offset in the intercept
//! where they are signed. Where the rescale changes from slice to slice (PET), integers survive if the change is a whole
//! number of steps; else the samples become floating-point values.

use crate::dicom::{
    frames::frame::Frame,
    header::pixel_format::{PixelFormat, SampleKind},
    images::image_file::{ImageFile, Slice},
};

/// Bytes of a label.
pub(crate) const LABEL_BYTES: usize = 2;

/// Bytes that a sample of these slices takes in memory.
pub(crate) fn sample_bytes(files: &[ImageFile], slices: &[Slice]) -> usize {
    match Plan::new(files, slices).storage {
        Storage::U8 => 1,
        Storage::U16 => 2,
        Storage::F32 => 4,
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Storage {
    U8,
    U16,
    F32,
}

/// How samples are kept, decided from headers alone.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) storage: Storage,
    /// Slope and intercept of the volume.
    pub(crate) rescale: [f64; 2],
    /// Per slice of the stack, what is added to its integers.
    pub(crate) offsets: Vec<i32>,
}

impl Plan {
    pub(crate) fn new(files: &[ImageFile], slices: &[Slice]) -> Self {
        let of = |slice: &Slice| (&files[slice.file].format, &files[slice.file].frames[slice.frame]);
        Self::integers(&slices.iter().map(of).collect::<Vec<_>>()).unwrap_or_else(|| Plan {
            storage: Storage::F32,
            rescale: [1.0, 0.0],
            offsets: vec![0; slices.len()],
        })
    }

    /// A plan that keeps integers; `None` if 16 bits cannot hold all slices exactly.
    fn integers(slices: &[(&PixelFormat, &Frame)]) -> Option<Self> {
        let [slope, intercept] = slices[0].1.rescale;
        let (mut lowest, mut highest) = (i64::MAX, i64::MIN);
        let mut steps = Vec::with_capacity(slices.len());
        for (format, frame) in slices {
            if format.kind == SampleKind::Float || frame.rescale[0] != slope {
                return None;
            }
            if let Some(lut) = &format.lut {
                lowest = lowest.min(0);
                highest = highest.max(lut.largest().into());
                steps.push(0);
                continue;
            }
            if format.bits_stored > 16 {
                return None;
            }
            // Where intercepts differ by whole steps, stored integers can be shifted without loss.
            let step = (frame.rescale[1] - intercept) / slope;
            if step.abs() > 65535.0 || (step - step.round()).abs() > 1e-6 {
                return None;
            }
            let step = step.round() as i64;
            let range = if format.signed { -(1 << (format.bits_stored - 1)) } else { 0 };
            lowest = lowest.min(range + step);
            highest = highest.max(range + (1 << format.bits_stored) - 1 + step);
            steps.push(step);
        }
        let (storage, bias) = match (lowest, highest) {
            (0.., ..=255) => (Storage::U8, 0),
            (-128.., ..=127) => (Storage::U8, 128),
            (0.., ..=65535) => (Storage::U16, 0),
            (-32768.., ..=32767) => (Storage::U16, 32768),
            _ if highest - lowest <= 65535 => (Storage::U16, -lowest),
            _ => return None,
        };
        let offsets = steps.iter().map(|step| (step + bias) as i32).collect();
        Some(Plan { storage, rescale: [slope, intercept - bias as f64 * slope], offsets })
    }
}
