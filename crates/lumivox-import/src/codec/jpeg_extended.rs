//! JPEG extended, sequential with Huffman coding and 12 bits a sample (ITU-T T.81, process 4), which no maintained
//! crate decodes. One component only: DICOM's grey images.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Samples of a block.
const BLOCK: usize = 64;
/// Order in which a block's coefficients are written (T.81 figure A.6).
const ZIGZAG: [u8; BLOCK] = [
    0, 1, 8, 16, 9, 2, 3, 10, 17, 24, 32, 25, 18, 11, 4, 5, 12, 19, 26, 33, 40, 48, 41, 34, 27, 20, 13, 6, 7,
    14, 21, 28, 35, 42, 49, 56, 57, 50, 43, 36, 29, 22, 15, 23, 30, 37, 44, 51, 58, 59, 52, 45, 38, 31, 39,
    46, 53, 60, 61, 54, 47, 55, 62, 63,
];

type Fault = &'static str;
const CUT: Fault = "ends in the middle of its JPEG stream";

/// Decodes a stream of `columns` x `rows` samples.
///
/// # Errors
/// A verb phrase about what is wrong with the stream.
pub(crate) fn decode(stream: &[u8], columns: usize, rows: usize) -> Result<Vec<u16>, Fault> {
    let mut tables = Tables::default();
    let mut frame = None;
    let mut at = 2;
    loop {
        let marker = loop {
            match (stream.get(at).ok_or(CUT)?, stream.get(at + 1).ok_or(CUT)?) {
                (0xFF, 0xFF) => at += 1,
                (0xFF, &marker) => break marker,
                _ => return Err("has a JPEG stream without a marker where one belongs"),
            }
        };
        let length = stream.get(at + 2..at + 4).map(|l| usize::from(u16::from_be_bytes([l[0], l[1]])));
        let length = length.filter(|length| *length >= 2).ok_or(CUT)?;
        let segment = stream.get(at + 4..at + 2 + length).ok_or(CUT)?;
        at += 2 + length;
        match marker {
            0xC0 | 0xC1 => frame = Some(Frame::of(segment, columns, rows)?),
            0xC4 => tables.huffman(segment)?,
            0xDB => tables.quantization(segment)?,
            0xDD => tables.restart = usize::from(u16::from_be_bytes(*segment.first_chunk().ok_or(CUT)?)),
            0xDA => {
                let frame = frame.ok_or("has a JPEG scan before its frame header")?;
                let selector = *segment.get(2).ok_or(CUT)?;
                return scan(stream.get(at..).ok_or(CUT)?, &frame, &tables, selector);
            }
            0xC2..=0xCF => return Err("has a JPEG stream of another process than its header says"),
            _ => {}
        }
    }
}

#[derive(Clone, Copy)]
struct Frame {
    columns: usize,
    rows: usize,
    precision: u32,
    quantization: usize,
}

impl Frame {
    fn of(segment: &[u8], columns: usize, rows: usize) -> Result<Self, Fault> {
        let &[precision, r0, r1, c0, c1, components, _, _, quantization, ..] = segment else {
            return Err(CUT);
        };
        let size = [u16::from_be_bytes([c0, c1]), u16::from_be_bytes([r0, r1])].map(usize::from);
        if size != [columns, rows] || components != 1 || ![8, 12].contains(&precision) || quantization > 3 {
            return Err("has a JPEG frame header that does not fit the image");
        }
        Ok(Self { columns, rows, precision: precision.into(), quantization: quantization.into() })
    }
}

/// A Huffman table as T.81 F.2.2.3 uses it, by length of code.
#[derive(Clone, Default)]
struct Huffman {
    /// The first code that is too large for each length.
    beyond: [i32; 17],
    /// What is added to a code to find its value.
    offset: [i32; 17],
    values: Vec<u8>,
}

#[derive(Default)]
struct Tables {
    quantization: [Option<[f64; BLOCK]>; 4],
    /// DC, then AC.
    huffman: [[Option<Huffman>; 4]; 2],
    /// Blocks between restart markers; 0 without any.
    restart: usize,
}

impl Tables {
    fn quantization(&mut self, mut segment: &[u8]) -> Result<(), Fault> {
        while let Some((&head, rest)) = segment.split_first() {
            let bytes = if head >> 4 == 0 { 1 } else { 2 };
            let (table, after) = rest.split_at_checked(BLOCK * bytes).ok_or(CUT)?;
            let slot = self.quantization.get_mut(usize::from(head & 15)).ok_or("has a damaged JPEG table")?;
            let mut steps = [0.0; BLOCK];
            for (k, step) in table.chunks_exact(bytes).enumerate() {
                let step = step.iter().fold(0u16, |n, &b| n << 8 | u16::from(b));
                steps[usize::from(ZIGZAG[k])] = step.into();
            }
            *slot = Some(steps);
            segment = after;
        }
        Ok(())
    }

    fn huffman(&mut self, mut segment: &[u8]) -> Result<(), Fault> {
        while let Some((&head, rest)) = segment.split_first() {
            let (counts, rest) = rest.split_at_checked(16).ok_or(CUT)?;
            let total = counts.iter().map(|&n| usize::from(n)).sum();
            let (values, after) = rest.split_at_checked(total).ok_or(CUT)?;
            let slot = self
                .huffman
                .get_mut(usize::from(head >> 4))
                .and_then(|of| of.get_mut(usize::from(head & 15)));
            let mut table = Huffman { values: values.to_vec(), ..Huffman::default() };
            let (mut code, mut index) = (0i32, 0i32);
            for length in 1..=16 {
                let count = i32::from(counts[length - 1]);
                table.offset[length] = index - code;
                code += count;
                index += count;
                table.beyond[length] = code;
                code <<= 1;
            }
            *slot.ok_or("has a damaged JPEG table")? = Some(table);
            segment = after;
        }
        Ok(())
    }
}

/// The bits of a scan, without stuffing; zeros after its end, as decoders do.
struct Bits<'a> {
    stream: &'a [u8],
    at: usize,
    held: u32,
    count: u32,
    /// Bits that were not there.
    missing: usize,
}

impl Bits<'_> {
    fn bit(&mut self) -> u32 {
        if self.count == 0 {
            self.held = match self.stream.get(self.at) {
                Some(0xFF) if self.stream.get(self.at + 1) != Some(&0) => {
                    self.missing += 8;
                    0
                }
                Some(&byte) => {
                    self.at += if byte == 0xFF { 2 } else { 1 };
                    byte.into()
                }
                None => {
                    self.missing += 8;
                    0
                }
            };
            self.count = 8;
        }
        self.count -= 1;
        (self.held >> self.count) & 1
    }

    fn value(&mut self, table: &Huffman) -> Result<u8, Fault> {
        let mut code = 0;
        for length in 1..=16 {
            code = code << 1 | self.bit() as i32;
            if code < table.beyond[length] {
                let index = code + table.offset[length];
                return usize::try_from(index)
                    .ok()
                    .and_then(|index| table.values.get(index).copied())
                    .ok_or("has a damaged JPEG table");
            }
        }
        Err("has a JPEG scan with a code that is none")
    }

    /// A number of so many bits, whose leading 0 says that it is negative (T.81 F.2.2.1).
    fn signed(&mut self, bits: u8) -> i32 {
        let number = (0..bits).fold(0, |n, _| n << 1 | self.bit() as i32);
        if bits > 0 && number < 1 << (bits - 1) { number - (1 << bits) + 1 } else { number }
    }

    /// Steps over a restart marker.
    fn restart(&mut self) {
        self.count = 0;
        while let Some(&byte) = self.stream.get(self.at) {
            match (byte, self.stream.get(self.at + 1)) {
                (0xFF, Some(0xD0..=0xD7)) => {
                    self.at += 2;
                    return;
                }
                (0xFF, Some(0xD9)) => return,
                _ => self.at += 1,
            }
        }
    }
}

fn scan(stream: &[u8], frame: &Frame, tables: &Tables, selector: u8) -> Result<Vec<u16>, Fault> {
    const MISSING: Fault = "has a JPEG scan whose tables are missing";
    let table =
        |class: usize, index: u8| tables.huffman[class].get(usize::from(index)).and_then(Option::as_ref);
    let dc = table(0, selector >> 4).ok_or(MISSING)?;
    let ac = table(1, selector & 15).ok_or(MISSING)?;
    let steps = tables.quantization[frame.quantization].as_ref().ok_or(MISSING)?;
    let basis = basis();
    let (middle, largest) = (f64::from(1 << (frame.precision - 1)), f64::from((1u32 << frame.precision) - 1));
    let mut samples = vec![0u16; frame.columns * frame.rows];
    let mut bits = Bits { stream, at: 0, held: 0, count: 0, missing: 0 };
    let (across, down) = (frame.columns.div_ceil(8), frame.rows.div_ceil(8));
    let mut last_dc = 0i32;
    for block in 0..across * down {
        if tables.restart > 0 && block > 0 && block.is_multiple_of(tables.restart) {
            bits.restart();
            last_dc = 0;
        }
        let mut coefficients = [0.0; BLOCK];
        let size = bits_of(bits.value(dc)?)?;
        last_dc = last_dc.wrapping_add(bits.signed(size));
        coefficients[0] = f64::from(last_dc) * steps[0];
        let mut k = 1;
        while k < BLOCK {
            let code = bits.value(ac)?;
            match (usize::from(code >> 4), code & 15) {
                (15, 0) => k += 16,
                (_, 0) => break,
                (run, size) => {
                    k += run;
                    let place =
                        usize::from(*ZIGZAG.get(k).ok_or("has a JPEG block of more than 64 samples")?);
                    coefficients[place] = f64::from(bits.signed(size)) * steps[place];
                    k += 1;
                }
            }
        }
        // A few bits may lack at the end; a block that is made of nothing is a stream that is cut short.
        if bits.missing > 64 {
            return Err(CUT);
        }
        let (left, top) = (block % across * 8, block / across * 8);
        let values = inverse(&coefficients, &basis);
        for y in 0..8.min(frame.rows - top) {
            for x in 0..8.min(frame.columns - left) {
                let value = (values[y * 8 + x] + middle).round().clamp(0.0, largest);
                samples[(top + y) * frame.columns + left + x] = value as u16;
            }
        }
    }
    Ok(samples)
}

/// The size of a difference; 12-bit samples have 15 bits at most.
fn bits_of(size: u8) -> Result<u8, Fault> {
    if size <= 16 { Ok(size) } else { Err("has a JPEG scan with a difference of too many bits") }
}

/// The cosines of the inverse transform, by frequency and place.
fn basis() -> [[f64; 8]; 8] {
    std::array::from_fn(|u| {
        let scale = if u == 0 { FRAC_1_SQRT_2 / 2.0 } else { 0.5 };
        std::array::from_fn(|x| scale * ((2 * x + 1) as f64 * u as f64 * PI / 16.0).cos())
    })
}

/// The inverse cosine transform of a block (T.81 A.3.3), rows before columns.
fn inverse(coefficients: &[f64; BLOCK], basis: &[[f64; 8]; 8]) -> [f64; BLOCK] {
    let mut rows = [0.0; BLOCK];
    for v in 0..8 {
        for u in (0..8).filter(|u| coefficients[v * 8 + u] != 0.0) {
            for x in 0..8 {
                rows[v * 8 + x] += coefficients[v * 8 + u] * basis[u][x];
            }
        }
    }
    let mut values = [0.0; BLOCK];
    for v in 0..8 {
        for y in 0..8 {
            for x in 0..8 {
                values[y * 8 + x] += rows[v * 8 + x] * basis[v][y];
            }
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stream of 8 x 8 samples with these Huffman-coded bits.
    fn stream(bits: &[u8]) -> Vec<u8> {
        let mut bytes = vec![0xFF, 0xD8, 0xFF, 0xDB, 0, 67, 0];
        bytes.extend([8; 64]);
        bytes.extend([0xFF, 0xC1, 0, 11, 12, 0, 8, 0, 8, 1, 1, 0x11, 0]);
        // One code of one bit for each: a difference of 10 bits, and the end of the block.
        for (class, value) in [(0x00, 10), (0x10, 0)] {
            bytes.extend([0xFF, 0xC4, 0, 20, class, 1]);
            bytes.extend([0; 15]);
            bytes.push(value);
        }
        bytes.extend([0xFF, 0xDA, 0, 8, 1, 1, 0, 0, 63, 0]);
        bytes.extend(bits);
        bytes.extend([0xFF, 0xD9]);
        bytes
    }

    #[test]
    fn a_flat_block_has_its_mean() {
        // 0, then 10 bits of 1000, then 0: a mean of 1000 * 8 / 8 above the middle.
        let bits = [0b0111_1101, 0b0000_1111];
        assert_eq!(decode(&stream(&bits), 8, 8).unwrap(), [2048 + 1000; 64]);
        // A leading 0 is negative: 0000010111 is 23 - 1023.
        let bits = [0b0000_0010, 0b1110_1111];
        assert_eq!(decode(&stream(&bits), 8, 8).unwrap(), [2048 - 1000; 64]);
    }

    #[test]
    fn damage_is_an_error() {
        let good = stream(&[0b0111_1101, 0b0000_1111]);
        for end in 0..good.len() - 4 {
            assert!(decode(&good[..end], 8, 8).is_err(), "cut at {end}");
        }
        assert!(decode(&good, 9, 8).is_err());
        assert!(decode(&stream(&[0xFE, 0xFE]), 8, 8).is_err());
    }
}
