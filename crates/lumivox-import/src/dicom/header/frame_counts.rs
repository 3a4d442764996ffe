//! How many frames a file has: by its own word, and by the bytes that are there.

use crate::{
    codec::Encoding,
    dicom::{
        bytes::source::inflation_limit,
        elements::{
            attributes as attr,
            data_set::{DataSet, PixelElement},
            values::FieldFault,
        },
        header::refusal::Refusal,
    },
};

/// More frames than any scan has; each costs memory before a pixel is read.
const MOST_FRAMES: i64 = 100_000;
/// A compressed frame may always grow to this size, and beyond it to [`LARGEST_RATIO`] times its own.
const COMPRESSED_AT_LEAST: u64 = 64 << 20;
const LARGEST_RATIO: u64 = 256;

/// Pixel data that end before their first frame does, in bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Truncated {
    pub(crate) expected: u64,
    pub(crate) actual: u64,
}

/// How many frames are there.
pub(super) type FramesThere = Result<usize, Truncated>;

/// What to tell of frames that are cut off, where one at least is there.
pub(super) fn missing_frames(frames: usize, there: FramesThere) -> Option<String> {
    let complete = there.ok().filter(|complete| *complete < frames)?;
    Some(format!("the file is cut short: {complete} of {frames} frames are there"))
}

/// How many frames the file declares, and how many it can hold: what is declared is checked against the bytes that are
/// there before memory is taken for it.
pub(super) fn frame_counts(
    data: &DataSet,
    pixels: &PixelElement,
    [columns, rows, bits]: [usize; 3],
    encoding: Encoding,
) -> Result<(usize, FramesThere), Refusal> {
    // Bits of a frame, and so many bytes when unpacked.
    let frame_bits = columns as u64 * rows as u64 * bits as u64;
    let frame_bytes = columns as u64 * rows as u64 * bits.div_ceil(8) as u64;
    let available = match (pixels.length, pixels.available) {
        (declared, Some(there)) => declared.unwrap_or(there).min(there),
        // The length of an inflated data set is known at its end only, but it has a limit.
        (declared, None) => declared.unwrap_or(0).min(inflation_limit(u64::from(u32::MAX))),
    };
    // Written as 0 by some that mean a single image, and left out of files that describe each frame, be it there or not.
    let described = data.items(attr::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE).len() as u64;
    let there = if encoding == Encoding::Native {
        available.saturating_mul(8) / frame_bits.max(1)
    } else {
        described
    };
    let described = described.min(there).max(1) as i64;
    let frames = match data.integer_text(attr::NUMBER_OF_FRAMES)?.unwrap_or(0) {
        0 if described <= MOST_FRAMES => described as usize,
        n @ 1..=MOST_FRAMES => n as usize,
        n => {
            let problem = format!("is {n}, not a number from 1 to {MOST_FRAMES}");
            return Err(FieldFault::new(attr::NUMBER_OF_FRAMES, problem).into());
        }
    };
    if frame_bytes > isize::MAX as u64 {
        return Err(FieldFault::new(
            attr::ROWS,
            format!("is {rows}, with {columns} columns more than memory"),
        )
        .into());
    }
    if encoding == Encoding::Native {
        let complete = (available.saturating_mul(8) / frame_bits).min(frames as u64) as usize;
        if complete == 0 {
            let expected = (frame_bits / 8).max(1).saturating_mul(frames as u64);
            // One frame marks its place; memory is not taken for others.
            return Ok((1, Err(Truncated { expected, actual: available })));
        }
        return Ok((frames, Ok(complete)));
    }
    // Every frame has at least one fragment with a head of 8 bytes.
    if frames as u64 > available / 8 {
        let problem = format!("is {frames}, more than {available} bytes of pixel data can hold");
        return Err(FieldFault::new(attr::NUMBER_OF_FRAMES, problem).into());
    }
    if frame_bytes > COMPRESSED_AT_LEAST.max(available.saturating_mul(LARGEST_RATIO)) {
        let problem = format!("is {rows}, with {columns} columns more than {available} bytes can hold");
        return Err(FieldFault::new(attr::ROWS, problem).into());
    }
    Ok((frames, Ok(frames)))
}
