//! RLE Lossless (PS3.5 annex G): byte planes, each packed by PackBits.

/// Decodes one frame of `pixels` samples with `bytes` bytes each to little endian samples.
///
/// # Errors
/// A verb phrase about what is wrong with the frame.
pub(crate) fn decode(frame: &[u8], pixels: usize, bytes: usize) -> Result<Vec<u8>, String> {
    const HEAD: usize = 64;
    let long = |index: usize| {
        let at = index * 4;
        let four = frame.get(at..at + 4).and_then(|b| b.first_chunk::<4>());
        four.map(|b| u32::from_le_bytes(*b) as usize).ok_or("has an RLE header that is cut short")
    };
    let segments = long(0)?;
    if segments != bytes {
        return Err(format!("has {segments} RLE segments for samples of {bytes} bytes"));
    }
    let mut samples = vec![0; pixels * bytes];
    for segment in 0..segments {
        let start = long(1 + segment)?;
        let end = if segment + 1 < segments { long(2 + segment)? } else { frame.len() };
        let packed =
            frame.get(start..end).filter(|_| start >= HEAD).ok_or("has RLE segments outside of its frame")?;
        // The most significant bytes come first.
        let plane = samples.iter_mut().skip(bytes - 1 - segment).step_by(bytes);
        unpack(packed, plane)
            .map_err(|missing| format!("has an RLE segment that ends {missing} bytes early"))?;
    }
    Ok(samples)
}

/// Unpacks PackBits into `plane`; the error is the number of bytes that are missing.
fn unpack<'a>(packed: &[u8], mut plane: impl ExactSizeIterator<Item = &'a mut u8>) -> Result<(), usize> {
    let mut packed = packed.iter();
    while plane.len() > 0 {
        let Some(&control) = packed.next() else { return Err(plane.len()) };
        match control {
            // That many bytes plus one, as they are.
            0..=127 => {
                for _ in 0..=control {
                    let (Some(&byte), Some(sample)) = (packed.next(), plane.next()) else { break };
                    *sample = byte;
                }
            }
            128 => {}
            // One byte, repeated.
            129.. => {
                let Some(&byte) = packed.next() else { return Err(plane.len()) };
                plane.by_ref().take(257 - usize::from(control)).for_each(|sample| *sample = byte);
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame of the given packed planes.
    fn frame(planes: &[&[u8]]) -> Vec<u8> {
        let mut head = vec![planes.len() as u32];
        let mut offset = 64;
        for plane in planes {
            head.push(offset);
            offset += plane.len() as u32;
        }
        head.resize(16, 0);
        head.iter().flat_map(|n| n.to_le_bytes()).chain(planes.concat()).collect()
    }

    #[test]
    fn planes_are_unpacked_high_byte_first() {
        // 4 x 0x01; then 0x10 0x20 and 2 x 0x30.
        let frame = frame(&[&[0xFD, 0x01], &[0x01, 0x10, 0x20, 0x80, 0xFF, 0x30]]);
        assert_eq!(decode(&frame, 4, 2).unwrap(), [0x10, 1, 0x20, 1, 0x30, 1, 0x30, 1]);
    }

    #[test]
    fn damage_is_an_error() {
        let good = frame(&[&[0xFD, 0x01]]);
        assert_eq!(decode(&good, 4, 1).unwrap(), [1; 4]);
        for end in 0..good.len() {
            assert!(decode(&good[..end], 4, 1).is_err(), "cut at {end}");
        }
        assert!(decode(&good, 4, 2).is_err());
        assert!(decode(&good, 5, 1).is_err());
        let mut outside = good.clone();
        outside[4..8].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(decode(&outside, 4, 1).is_err());
    }
}
