//! The container of Blosc 1, in which most chunks of Zarr are: blocks, each shuffled and compressed by one of a few codecs.
//!
//! After c-blosc's README_CHUNK_FORMAT. Lengths are compared with what is there before memory is taken for them.

const HEADER_BYTES: usize = 16;
const SHUFFLED: u8 = 1;
const STORED: u8 = 2;
const BIT_SHUFFLED: u8 = 4;
/// Whether blocks are compressed as a whole, and not in a stream for each byte of a sample.
const UNSPLIT: u8 = 16;

/// What a chunk inflates to, which is no longer than `most` bytes.
///
/// # Errors
/// Says what is wrong, as a verb phrase.
pub(super) fn decode(chunk: &[u8], most: usize) -> Result<Vec<u8>, String> {
    let cut = || "is cut short".to_owned();
    let long = |at: usize| {
        let four = chunk.get(at..).and_then(|rest| rest.first_chunk::<4>());
        four.map(|b| u32::from_le_bytes(*b) as usize).ok_or_else(cut)
    };
    let [_, _, flags, sample, ..] = *chunk else { return Err(cut()) };
    let sample = usize::from(sample).max(1);
    let (length, block) = (long(4)?, long(8)?);
    if length > most {
        return Err(format!("says that it holds {length} bytes where {most} belong"));
    }
    if flags & STORED != 0 {
        return chunk.get(HEADER_BYTES..HEADER_BYTES + length).map(<[u8]>::to_vec).ok_or_else(cut);
    }
    if length == 0 {
        return Ok(Vec::new());
    }
    if block == 0 {
        return Err("has blocks of no length".to_owned());
    }
    let codec = flags >> 5;
    let mut out = Vec::new();
    for (index, start) in (0..length).step_by(block).enumerate() {
        let wanted = block.min(length - start);
        let at = long(HEADER_BYTES + 4 * index)?;
        let stream = chunk.get(at..).ok_or_else(cut)?;
        let is_whole = wanted == block;
        let splits =
            if flags & UNSPLIT == 0 && is_whole && wanted.is_multiple_of(sample) { sample } else { 1 };
        let mut bytes = inflate_block(stream, wanted, splits, codec);
        // Older writers split blocks by rules of their own.
        if bytes.is_err() && splits > 1 {
            bytes = inflate_block(stream, wanted, 1, codec);
        }
        let bytes = bytes?;
        if flags & SHUFFLED != 0 && sample > 1 {
            unshuffle(&bytes, sample, &mut out);
        } else if flags & BIT_SHUFFLED != 0 {
            unshuffle_bits(&bytes, sample, &mut out);
        } else {
            out.extend_from_slice(&bytes);
        }
    }
    Ok(out)
}

/// The bytes of a block, from so many streams that follow each other with their lengths.
fn inflate_block(stream: &[u8], wanted: usize, splits: usize, codec: u8) -> Result<Vec<u8>, String> {
    let cut = || "is cut short".to_owned();
    let each = wanted / splits;
    let mut rest = stream;
    let mut out = Vec::new();
    for _ in 0..splits {
        let (length, after) = rest.split_first_chunk::<4>().ok_or_else(cut)?;
        let length = u32::from_le_bytes(*length) as usize;
        let packed = after.get(..length).ok_or_else(cut)?;
        rest = &after[length..];
        if length == each {
            out.extend_from_slice(packed);
            continue;
        }
        let bytes = inflate(packed, each, codec)?;
        if bytes.len() != each {
            return Err(format!("has a block of {} bytes where {each} belong", bytes.len()));
        }
        out.extend_from_slice(&bytes);
    }
    Ok(out)
}

fn inflate(packed: &[u8], wanted: usize, codec: u8) -> Result<Vec<u8>, String> {
    match codec {
        0 => blosclz(packed, wanted),
        1 => lz4(packed, wanted),
        3 => super::streams::zlib(packed, wanted),
        4 => super::streams::zstd(packed, wanted),
        2 => Err("is compressed by Blosc's snappy, which is not read".to_owned()),
        other => Err(format!("is compressed by codec {other} of Blosc, which is not known")),
    }
}

/// LZ4's blocks shrink nothing by more than 255 times: no memory is taken for more.
pub(super) fn lz4(packed: &[u8], wanted: usize) -> Result<Vec<u8>, String> {
    let room = wanted.min(packed.len().saturating_mul(256));
    lz4_flex::block::decompress(packed, room).map_err(|fault| format!("has damaged LZ4 data ({fault})"))
}

/// Blosc's own codec, after FastLZ: literals, and copies of what came before.
fn blosclz(packed: &[u8], wanted: usize) -> Result<Vec<u8>, String> {
    const FAR: usize = 8191;
    let cut = || "has BloscLZ data that are cut short".to_owned();
    let mut input = packed.iter().map(|byte| usize::from(*byte));
    let mut out = Vec::new();
    // The first instruction is one of literals.
    let mut control = input.next().ok_or_else(cut)? & 31;
    loop {
        if control >= 32 {
            let mut length = (control >> 5) - 1;
            let mut distance = (control & 31) << 8;
            if length == 6 {
                loop {
                    let more = input.next().ok_or_else(cut)?;
                    length += more;
                    if more != 255 {
                        break;
                    }
                }
            }
            let low = input.next().ok_or_else(cut)?;
            length += 3;
            distance += low;
            if low == 255 && distance - low == 31 << 8 {
                distance = input.next().ok_or_else(cut)? << 8;
                distance += input.next().ok_or_else(cut)? + FAR;
            }
            let from = out.len().checked_sub(distance + 1).ok_or("has BloscLZ data that point nowhere")?;
            if out.len() + length > wanted {
                return Err("has BloscLZ data that do not end".to_owned());
            }
            // It may overlap what it makes.
            for at in from..from + length {
                out.push(out[at]);
            }
        } else {
            if out.len() + control + 1 > wanted {
                return Err("has BloscLZ data that do not end".to_owned());
            }
            for _ in 0..=control {
                out.push(input.next().ok_or_else(cut)? as u8);
            }
        }
        match input.next() {
            Some(next) => control = next,
            None => return Ok(out),
        }
    }
}

/// Puts together samples whose first bytes come first, then their second, ...; what is no whole sample follows.
fn unshuffle(bytes: &[u8], sample: usize, out: &mut Vec<u8>) {
    let count = bytes.len() / sample;
    out.extend((0..count).flat_map(|i| (0..sample).map(move |byte| bytes[byte * count + i])));
    out.extend_from_slice(&bytes[count * sample..]);
}

/// As [`unshuffle`], of bits: of as many samples as are a multiple of eight.
fn unshuffle_bits(bytes: &[u8], sample: usize, out: &mut Vec<u8>) {
    let count = bytes.len() / sample / 8 * 8;
    let row = count / 8;
    let byte = |i: usize, byte: usize| -> u8 {
        (0..8).map(|bit| (bytes[(byte * 8 + bit) * row + i / 8] >> (i % 8) & 1) << bit).sum()
    };
    out.extend((0..count).flat_map(|i| (0..sample).map(move |k| byte(i, k))));
    out.extend_from_slice(&bytes[count * sample..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chunk of one block of `length` bytes.
    fn chunk(flags: u8, sample: u8, length: usize, block: usize, streams: &[&[u8]]) -> Vec<u8> {
        let mut out = vec![2, 1, flags, sample];
        out.extend((length as u32).to_le_bytes());
        out.extend((block as u32).to_le_bytes());
        out.extend([0; 4]);
        out.extend(20u32.to_le_bytes());
        for stream in streams {
            out.extend((stream.len() as u32).to_le_bytes());
            out.extend_from_slice(stream);
        }
        out
    }

    #[test]
    fn blocks_are_inflated_and_put_in_order() {
        let samples: Vec<u8> = (0..64u16).flat_map(|n| (n * 3).to_le_bytes()).collect();
        let shuffled: Vec<u8> =
            samples.iter().step_by(2).chain(samples.iter().skip(1).step_by(2)).copied().collect();
        let lz4 = lz4_flex::block::compress(&shuffled);
        assert_eq!(decode(&chunk(1 << 5 | UNSPLIT | SHUFFLED, 2, 128, 128, &[&lz4]), 128).unwrap(), samples);
        // In a stream for each byte, of which one is stored.
        let [low, high] = [&shuffled[..64], &shuffled[64..]];
        let packed = lz4_flex::block::compress(high);
        assert!(packed.len() < 64);
        assert_eq!(decode(&chunk(1 << 5 | SHUFFLED, 2, 128, 128, &[low, &packed]), 128).unwrap(), samples);
        let mut stored = chunk(STORED, 2, 128, 128, &[]);
        stored.truncate(HEADER_BYTES);
        stored.extend_from_slice(&samples);
        assert_eq!(decode(&stored, 128).unwrap(), samples);
    }

    #[test]
    fn bits_are_put_in_order() {
        let samples: Vec<u8> = (0..16u8).map(|n| n * 17).collect();
        let mut planes = vec![0u8; 16];
        for (i, sample) in samples.iter().enumerate() {
            for bit in 0..8 {
                planes[bit * 2 + i / 8] |= (sample >> bit & 1) << (i % 8);
            }
        }
        let mut out = Vec::new();
        unshuffle_bits(&planes, 1, &mut out);
        assert_eq!(out, samples);
    }

    #[test]
    fn blosclz_copies_what_came_before() {
        // Three literals, then a copy of 5 bytes that begins two back, then a literal.
        let packed = [2, b'a', b'b', b'c', 3 << 5, 1, 0, b'z'];
        assert_eq!(blosclz(&packed, 9).unwrap(), b"abcbcbcbz");
        assert!(blosclz(&packed, 8).is_err());
        assert!(blosclz(&[2, b'a', b'b', b'c', 3 << 5, 9], 9).unwrap_err().contains("nowhere"));
        for end in 0..packed.len() {
            let _ = blosclz(&packed[..end], 9);
        }
    }

    #[test]
    fn damage_is_an_error() {
        let whole = chunk(1 << 5 | UNSPLIT, 1, 600, 600, &[&lz4_flex::block::compress(&[7; 600])]);
        assert_eq!(decode(&whole, 600).unwrap(), [7; 600]);
        for end in 0..whole.len() {
            assert!(decode(&whole[..end], 600).is_err(), "{end}");
        }
        assert!(decode(&whole, 599).unwrap_err().contains("where 599 belong"));
        for at in 0..whole.len() {
            for byte in [0, 1, 0x7F, 0xFF] {
                let mut wrong = whole.clone();
                wrong[at] = byte;
                let _ = decode(&wrong, 600);
            }
        }
        let mut zero = whole;
        zero[8..12].fill(0);
        assert!(decode(&zero, 600).unwrap_err().contains("no length"));
    }
}
