//! Encapsulated pixel data (PS3.5 annex A.4): from fragments to one codestream per frame.

use crate::{
    codec::{JPEG_XL_CODESTREAM, JPEG_XL_FILE},
    dicom::bytes::source::Input,
};

/// Reads the fragments at `input`'s position and joins them to one codestream per frame; fewer where the file is cut
/// short or broken after the first ones.
///
/// `extended` is the extended offset table, which counts before the basic one; mostly empty.
///
/// # Errors
/// A verb phrase about what is wrong with the fragments.
pub(crate) fn read_frames(
    input: &mut Input,
    frames: usize,
    extended: &[u64],
) -> Result<Vec<Vec<u8>>, String> {
    let Fragments { basic, fragments, broken } =
        read_fragments(input).map_err(|e| format!("has damaged fragments ({e})"))?;
    if let Some(fault) = &broken
        && (frames == 1 || fragments.is_empty())
    {
        return Err(format!("has damaged fragments ({fault})"));
    }
    if frames == 1 {
        return Ok(vec![fragments.concat()]);
    }
    if fragments.len() == frames {
        return Ok(fragments);
    }
    // Offsets count the heads of the items too.
    let mut end = 0;
    let mut positions = Vec::with_capacity(fragments.len());
    for fragment in &fragments {
        positions.push(end);
        end += 8 + fragment.len() as u64;
    }
    let offsets = if extended.len() == frames { extended } else { &basic[..] };
    if broken.is_some() {
        return Ok(whole_frames(
            fragments,
            &positions,
            end,
            if offsets.len() == frames { offsets } else { &[] },
        ));
    }
    let starts: Vec<usize> = if offsets.len() == frames {
        let find = |offset: &u64| positions.binary_search(offset).ok();
        offsets.iter().map(find).collect::<Option<_>>().ok_or("has an offset table that points nowhere")?
    } else {
        // Without a table, frames begin where codestreams do: JPEG's start of image, JPEG 2000's start of codestream,
        // JPEG XL's signatures.
        fragments.iter().enumerate().filter(|(_, fragment)| begins_frame(fragment)).map(|(k, _)| k).collect()
    };
    if starts.len() != frames || starts.first() != Some(&0) || !starts.is_sorted() {
        return Err(format!("has {} fragments that do not make {frames} frames", fragments.len()));
    }
    let ends = starts.iter().skip(1).copied().chain([fragments.len()]);
    Ok(starts.iter().zip(ends).map(|(&start, end)| fragments[start..end].concat()).collect())
}

/// Whether a fragment begins as a codestream does.
fn begins_frame(fragment: &[u8]) -> bool {
    const STARTS: [&[u8]; 4] = [&[0xFF, 0xD8], &[0xFF, 0x4F], JPEG_XL_CODESTREAM, JPEG_XL_FILE];
    STARTS.iter().any(|start| fragment.starts_with(start))
}

/// The frames before the place where `fragments`, which begin at `positions` and reach to `end`, break off. `offsets`
/// are those of all frames, if there is a table.
fn whole_frames(mut fragments: Vec<Vec<u8>>, positions: &[u64], end: u64, offsets: &[u64]) -> Vec<Vec<u8>> {
    if !offsets.is_empty() {
        // The last fragments may belong to a frame that goes on where nothing could be read.
        let find = |offset: &u64| match *offset == end {
            true => Some(positions.len()),
            false => positions.binary_search(offset).ok(),
        };
        let starts: Vec<usize> = offsets.iter().map_while(find).collect();
        let pairs = starts.windows(2).take_while(|pair| pair[0] < pair[1]);
        return pairs.map(|pair| fragments[pair[0]..pair[1]].concat()).collect();
    }
    // Without a table only frames of one fragment each are sure to be whole.
    if !fragments.iter().all(|fragment| begins_frame(fragment))
        && fragments.iter().any(|fragment| begins_frame(fragment))
    {
        fragments.clear();
    }
    fragments
}

/// What encapsulated pixel data are made of.
struct Fragments {
    /// The basic offset table.
    basic: Vec<u64>,
    fragments: Vec<Vec<u8>>,
    /// Why they break off.
    broken: Option<std::io::Error>,
}

/// The basic offset table and the fragments, as far as they can be read. Never more memory than there are bytes in the
/// file.
fn read_fragments(input: &mut Input) -> std::io::Result<Fragments> {
    use std::io::ErrorKind::{InvalidData, UnexpectedEof};
    let mut items = Vec::new();
    let broken = loop {
        let mut head = [0; 8];
        // Some writers leave the delimiter out.
        if input.read_up_to(&mut head)? < 8 {
            break None;
        }
        let [.., a, b, c, d] = head;
        match &head[..4] {
            [0xFE, 0xFF, 0x00, 0xE0] => match input.read_vec(u32::from_le_bytes([a, b, c, d]).into()) {
                Ok(item) => items.push(item),
                Err(fault) if fault.kind() == UnexpectedEof => break Some(fault),
                Err(fault) => return Err(fault),
            },
            [0xFE, 0xFF, 0xDD, 0xE0] => break None,
            _ => break Some(InvalidData.into()),
        }
    };
    if items.is_empty() {
        return Err(broken.unwrap_or(UnexpectedEof.into()));
    }
    let table = items.remove(0);
    let offset = |b: &[u8]| u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let basic = table.chunks_exact(4).map(offset).collect();
    Ok(Fragments { basic, fragments: items, broken })
}
