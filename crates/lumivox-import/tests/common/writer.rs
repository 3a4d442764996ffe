//! Writes small DICOM files, good and odd ones. Shares nothing with the reader.

use std::path::Path;

/// How a data set is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Syntax {
    Explicit,
    Implicit,
    /// GE's own: implicit, with pixels in big endian.
    GePrivate,
    BigEndian,
    Deflated,
    Rle,
    JpegXl,
    JpegLs,
    #[allow(dead_code, reason = "not every test program uses all of it")]
    Jpeg2000,
    /// Of each frame.
    DeflatedFrames,
    /// Retired processes of JPEG.
    JpegSpectral,
    JpegProgressive,
}

impl Syntax {
    fn uid(self) -> &'static str {
        match self {
            Syntax::Explicit => "1.2.840.10008.1.2.1",
            Syntax::Implicit => "1.2.840.10008.1.2",
            Syntax::GePrivate => "1.2.840.113619.5.2",
            Syntax::BigEndian => "1.2.840.10008.1.2.2",
            Syntax::Deflated => "1.2.840.10008.1.2.1.99",
            Syntax::Rle => "1.2.840.10008.1.2.5",
            Syntax::JpegXl => "1.2.840.10008.1.2.4.110",
            Syntax::JpegLs => "1.2.840.10008.1.2.4.80",
            Syntax::Jpeg2000 => "1.2.840.10008.1.2.4.90",
            Syntax::DeflatedFrames => "1.2.840.10008.1.2.8.1",
            Syntax::JpegSpectral => "1.2.840.10008.1.2.4.53",
            Syntax::JpegProgressive => "1.2.840.10008.1.2.4.55",
        }
    }
}

/// A value, by the way it is written.
#[derive(Clone, Debug)]
pub enum Value {
    Text(String),
    Short(u16),
    /// Pixels of 8 bits.
    Bytes(Vec<u8>),
    /// Pixels of 16 bits.
    Words(Vec<u16>),
    Items(Vec<Elements>),
    /// Value bytes as they are, after a head with this length.
    Raw(u32, Vec<u8>),
    /// An empty offset table and one fragment for each.
    Fragments(Vec<Vec<u8>>),
}

/// The elements of a data set: tag, VR and value.
#[derive(Clone, Debug, Default)]
pub struct Elements(pub Vec<(u32, &'static str, Value)>);

impl Elements {
    /// Sets a text.
    pub fn text(mut self, tag: u32, vr: &'static str, text: &str) -> Self {
        self.set(tag, vr, Value::Text(text.to_owned()));
        self
    }

    /// Sets a US.
    pub fn short(mut self, tag: u32, value: u16) -> Self {
        self.set(tag, "US", Value::Short(value));
        self
    }

    /// Sets decimals.
    pub fn decimals(self, tag: u32, values: &[f64]) -> Self {
        let text = values.iter().map(|v| v.to_string()).collect::<Vec<_>>().join("\\");
        self.text(tag, "DS", &text)
    }

    /// Sets a sequence.
    pub fn items(mut self, tag: u32, items: Vec<Elements>) -> Self {
        self.set(tag, "SQ", Value::Items(items));
        self
    }

    /// Sets any value.
    pub fn set(&mut self, tag: u32, vr: &'static str, value: Value) {
        self.0.retain(|(t, ..)| *t != tag);
        self.0.push((tag, vr, value));
        self.0.sort_by_key(|(t, ..)| *t);
    }

    /// Leaves an element out.
    pub fn without(mut self, tag: u32) -> Self {
        self.0.retain(|(t, ..)| *t != tag);
        self
    }

    /// The data set's bytes.
    pub fn data_set(&self, syntax: Syntax) -> Vec<u8> {
        let big = syntax == Syntax::BigEndian;
        let short = |n: u16| if big { n.to_be_bytes() } else { n.to_le_bytes() };
        let long = |n: u32| if big { n.to_be_bytes() } else { n.to_le_bytes() };
        let tag_bytes = |tag: u32| [short((tag >> 16) as u16), short(tag as u16)].concat();
        let mut out = Vec::new();
        for (tag, vr, value) in &self.0 {
            let (declared, mut bytes) = match value {
                Value::Text(text) => (None, text.clone().into_bytes()),
                Value::Short(n) => (None, short(*n).to_vec()),
                Value::Bytes(bytes) => (None, bytes.clone()),
                Value::Words(words) if syntax == Syntax::GePrivate && *tag == PIXEL_DATA => {
                    (None, words.iter().flat_map(|w| w.to_be_bytes()).collect())
                }
                Value::Words(words) => (None, words.iter().flat_map(|w| short(*w)).collect()),
                Value::Raw(length, bytes) => (Some(*length), bytes.clone()),
                Value::Items(items) => {
                    let item = |item: &Elements| {
                        let data = item.data_set(syntax);
                        [tag_bytes(0xFFFE_E000), long(data.len() as u32).to_vec(), data].concat()
                    };
                    (None, items.iter().flat_map(item).collect())
                }
                Value::Fragments(fragments) => {
                    let item = |data: &[u8]| {
                        [tag_bytes(0xFFFE_E000), long(data.len() as u32).to_vec(), data.to_vec()].concat()
                    };
                    let mut bytes = item(&[]);
                    fragments.iter().for_each(|fragment| bytes.extend(item(fragment)));
                    bytes.extend([tag_bytes(0xFFFE_E0DD), long(0).to_vec()].concat());
                    (Some(u32::MAX), bytes)
                }
            };
            if bytes.len() % 2 == 1 && declared.is_none() {
                bytes.push(if matches!(value, Value::Text(_)) && *vr != "UI" { b' ' } else { 0 });
            }
            let length = declared.unwrap_or(bytes.len() as u32);
            out.extend(tag_bytes(*tag));
            if [Syntax::Implicit, Syntax::GePrivate].contains(&syntax) {
                out.extend(long(length));
            } else {
                out.extend(vr.as_bytes());
                if ["OB", "OW", "SQ", "UN", "UT"].contains(vr) {
                    out.extend([0, 0]);
                    out.extend(long(length));
                } else {
                    out.extend(short(length as u16));
                }
            }
            out.extend(bytes);
        }
        out
    }

    /// A whole file's bytes.
    pub fn file(&self, syntax: Syntax) -> Vec<u8> {
        let meta = Elements::default().text(0x0002_0010, "UI", syntax.uid()).data_set(Syntax::Explicit);
        let mut data = self.data_set(syntax);
        if syntax == Syntax::Deflated {
            use std::io::Write;
            let mut encoder = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::fast());
            encoder.write_all(&data).unwrap();
            data = encoder.finish().unwrap();
        }
        let mut head = vec![0; 128];
        head.extend(b"DICM");
        head.extend([2, 0, 0, 0, b'U', b'L', 4, 0]);
        head.extend((meta.len() as u32).to_le_bytes());
        [head, meta, data].concat()
    }

    /// Writes a file.
    pub fn write(&self, path: &Path, syntax: Syntax) {
        std::fs::write(path, self.file(syntax)).unwrap();
    }
}

pub const MODALITY: u32 = 0x0008_0060;
pub const IMAGE_TYPE: u32 = 0x0008_0008;
pub const PATIENT_NAME: u32 = 0x0010_0010;
pub const SPACING_BETWEEN_SLICES: u32 = 0x0018_0088;
pub const SERIES_INSTANCE_UID: u32 = 0x0020_000E;
pub const SERIES_NUMBER: u32 = 0x0020_0011;
pub const INSTANCE_NUMBER: u32 = 0x0020_0013;
pub const IMAGE_POSITION_PATIENT: u32 = 0x0020_0032;
pub const IMAGE_ORIENTATION_PATIENT: u32 = 0x0020_0037;
pub const FRAME_OF_REFERENCE_UID: u32 = 0x0020_0052;
pub const SAMPLES_PER_PIXEL: u32 = 0x0028_0002;
pub const PHOTOMETRIC_INTERPRETATION: u32 = 0x0028_0004;
pub const NUMBER_OF_FRAMES: u32 = 0x0028_0008;
pub const ROWS: u32 = 0x0028_0010;
pub const COLUMNS: u32 = 0x0028_0011;
pub const PIXEL_SPACING: u32 = 0x0028_0030;
pub const BITS_ALLOCATED: u32 = 0x0028_0100;
pub const BITS_STORED: u32 = 0x0028_0101;
pub const HIGH_BIT: u32 = 0x0028_0102;
pub const PIXEL_REPRESENTATION: u32 = 0x0028_0103;
pub const PIXEL_PADDING_VALUE: u32 = 0x0028_0120;
pub const PIXEL_PADDING_RANGE_LIMIT: u32 = 0x0028_0121;
pub const RESCALE_INTERCEPT: u32 = 0x0028_1052;
pub const RESCALE_SLOPE: u32 = 0x0028_1053;
pub const PIXEL_DATA: u32 = 0x7FE0_0010;

/// A grey image of `columns` x `rows` 16-bit samples at a place in the patient.
pub fn image(modality: &str, columns: u16, rows: u16, samples: Vec<u16>) -> Elements {
    let mut elements = Elements::default()
        .text(0x0008_0016, "UI", "1.2.840.10008.5.1.4.1.1.7")
        .text(MODALITY, "CS", modality)
        .text(PATIENT_NAME, "PN", "SECRET^NAME")
        .text(0x0010_0020, "LO", "SECRETID")
        .text(SERIES_INSTANCE_UID, "UI", "1.2.3")
        .text(SERIES_NUMBER, "IS", "7")
        .text(INSTANCE_NUMBER, "IS", "1")
        .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, 0.0])
        .decimals(IMAGE_ORIENTATION_PATIENT, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0])
        .short(SAMPLES_PER_PIXEL, 1)
        .text(PHOTOMETRIC_INTERPRETATION, "CS", "MONOCHROME2")
        .short(ROWS, rows)
        .short(COLUMNS, columns)
        .decimals(PIXEL_SPACING, &[1.0, 1.0])
        .short(BITS_ALLOCATED, 16)
        .short(BITS_STORED, 16)
        .short(HIGH_BIT, 15)
        .short(PIXEL_REPRESENTATION, 0);
    elements.set(PIXEL_DATA, "OW", Value::Words(samples));
    elements
}

/// RLE Lossless of samples with `bytes` bytes each, given in little endian; repeats nothing.
pub fn rle(samples: &[u8], bytes: usize) -> Vec<u8> {
    let plane = |byte: usize| -> Vec<u8> {
        let plane: Vec<u8> = samples.iter().skip(byte).step_by(bytes).copied().collect();
        plane.chunks(128).flat_map(|run| [vec![run.len() as u8 - 1], run.to_vec()].concat()).collect()
    };
    let planes: Vec<Vec<u8>> = (0..bytes).rev().map(plane).collect();
    let mut head = vec![bytes as u32];
    let mut offset = 64;
    for plane in &planes {
        head.push(offset);
        offset += plane.len() as u32;
    }
    head.resize(16, 0);
    head.iter().flat_map(|n| n.to_le_bytes()).chain(planes.concat()).collect()
}

/// Numbers that look random, and are the same in every run.
pub struct Random(pub u64);

impl Random {
    /// A number below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        // SplitMix64.
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % n as u64) as usize
    }

    /// A number from `low` to `high`.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.below(1 << 24) as f64 / (1 << 24) as f64
    }

    /// One of several.
    pub fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }
}
