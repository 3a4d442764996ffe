//! JPEG XL: frames of grey integers of up to 16 bits, whatever lies around their codestream.

use std::borrow::Cow;

use super::{CodecFault, Decoded, FrameShape, JPEG_XL_CODESTREAM, JPEG_XL_FILE, StreamInfo};

pub(super) fn decode(stream: &[u8], format: &FrameShape) -> Result<Decoded, CodecFault> {
    use jxl_oxide::{AllocTracker, InitializeResult, JxlImage, image::BitDepth};
    /// What the decoder may take, besides so much for every pixel: several planes of 32 bits.
    const MEMORY: usize = 64 << 20;
    const MEMORY_OF_PIXEL: usize = 64;
    let damaged =
        |e: &dyn std::fmt::Display| CodecFault::Damaged(format!("has a damaged JPEG XL stream ({e})"));
    let unsupported =
        |what: &str| Err(CodecFault::Unsupported(format!("it is compressed as JPEG XL {what}")));
    let cut = || CodecFault::from("has a JPEG XL stream that is cut short");

    let codestream = jpeg_xl_codestream(stream).ok_or_else(cut)?;
    if !codestream.starts_with(JPEG_XL_CODESTREAM) {
        return Err("has no JPEG XL stream where one belongs".into());
    }
    let (columns, rows) = jpeg_xl_size(&codestream).ok_or_else(cut)?;
    let info = StreamInfo { marker: 0, columns, rows, precision: 0, signed: false, components: 1 };
    info.check(format)?;
    let pixels = format.columns * format.rows;
    // Wide buffers: exact even where a stream says wrongly that 16 bits with a sign suffice.
    let mut decoder = JxlImage::builder()
        .alloc_tracker(AllocTracker::with_limit(
            pixels.saturating_mul(MEMORY_OF_PIXEL).saturating_add(MEMORY),
        ))
        .force_wide_buffers(true)
        .build_uninit();
    decoder.feed_bytes(&codestream).map_err(|e| damaged(&e))?;
    let InitializeResult::Initialized(image) = decoder.try_init().map_err(|e| damaged(&e))? else {
        return Err(cut());
    };
    let metadata = &image.image_header().metadata;
    let colours = if metadata.grayscale() { 1 } else { 3 };
    StreamInfo { components: colours + metadata.ec_info.len(), ..info }.check(format)?;
    let bits = match metadata.bit_depth {
        BitDepth::IntegerSample { bits_per_sample: bits @ 1..=16 } => bits,
        BitDepth::IntegerSample { bits_per_sample } => {
            return unsupported(&format!("of {bits_per_sample} bits"));
        }
        BitDepth::FloatSample { .. } => return unsupported("of floating-point samples"),
    };
    // Whether the turn is meant beside DICOM's own orientation is a guess, and left is not right.
    if metadata.orientation != 1 {
        return unsupported("with an orientation of its own");
    }
    // The samples would depend on the profile.
    if metadata.xyb_encoded && image.original_icc().is_some() {
        return unsupported("with a colour profile");
    }
    if !image.is_loading_done() {
        return Err(cut());
    }
    if image.num_loaded_keyframes() != 1 {
        let found = image.num_loaded_keyframes();
        return Err(format!("has a JPEG XL stream of {found} images instead of one").into());
    }
    let render = image.render_frame(0).map_err(|e| damaged(&e))?;
    let mut rendered = render.stream();
    if (rendered.width() as usize, rendered.height() as usize, rendered.channels())
        != (format.columns, format.rows, 1)
    {
        return Err("has a JPEG XL stream that decodes to another size".into());
    }
    let mut fractions = vec![0.0f32; pixels];
    let written = rendered.write_to_buffer(&mut fractions);
    fractions.truncate(written);
    // The decoder gives fractions of the largest sample; their 24 bits tell samples of 16 apart.
    let largest = f64::from((1u32 << bits) - 1);
    let integers = fractions.iter().map(|&f| (f64::from(f) * largest).round().clamp(0.0, largest) as u16);
    Ok(if bits <= 8 && format.bytes == 1 {
        Decoded { samples: integers.map(|s| s as u8).collect(), bytes: 1 }
    } else {
        Decoded { samples: integers.flat_map(u16::to_le_bytes).collect(), bytes: 2 }
    })
}

/// The codestream of a JPEG XL stream: itself, or out of the boxes of a file. The decoder never sees other boxes, which
/// may inflate without limit. `None` if a box is cut short.
fn jpeg_xl_codestream(stream: &[u8]) -> Option<Cow<'_, [u8]>> {
    if !stream.starts_with(JPEG_XL_FILE) {
        return Some(stream.into());
    }
    let mut codestream = Vec::new();
    let mut rest = stream;
    // Less than a box's head is padding.
    while let Some((head, _)) = rest.split_first_chunk::<8>() {
        let [a, b, c, d, kind @ ..] = *head;
        let (start, length) = match u32::from_be_bytes([a, b, c, d]) {
            0 => (8, rest.len()),
            1 => (16, usize::try_from(u64::from_be_bytes(*rest.get(8..)?.first_chunk()?)).ok()?),
            length => (8, length as usize),
        };
        let content = rest.get(start..length)?;
        match &kind {
            b"jxlc" => codestream.extend_from_slice(content),
            // After the part's number.
            b"jxlp" => codestream.extend_from_slice(content.get(4..)?),
            _ => {}
        }
        rest = &rest[length..];
    }
    Some(codestream.into())
}

/// Columns and rows by the size header of a JPEG XL codestream (ISO/IEC 18181-1), whose bits count from the lowest.
fn jpeg_xl_size(codestream: &[u8]) -> Option<(usize, usize)> {
    let mut at = 16;
    let mut bits = |count: usize| {
        let mut value = 0;
        for bit in 0..count {
            value |= usize::from(codestream.get(at / 8)? >> (at % 8) & 1) << bit;
            at += 1;
        }
        Some(value)
    };
    let eights = bits(1)? == 1;
    let side = |bits: &mut dyn FnMut(usize) -> Option<usize>| {
        let (count, unit) = if eights { (5, 8) } else { ([9, 13, 18, 30][bits(2)?], 1) };
        Some((bits(count)? + 1) * unit)
    };
    let rows = side(&mut bits)?;
    let columns = match bits(3)? {
        1 => rows,
        2 => rows * 6 / 5,
        3 => rows * 4 / 3,
        4 => rows * 3 / 2,
        5 => rows * 16 / 9,
        6 => rows * 5 / 4,
        7 => rows * 2,
        _ => side(&mut bits)?,
    };
    Some((columns, rows))
}
