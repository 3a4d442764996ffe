//! From a compressed frame of DICOM to its samples. Knows no file.
//!
//! A codestream's own header is compared with the file's before a decoder sees it, so that none takes memory for an
//! image of another size.

#[cfg(feature = "jpeg")]
mod jpeg;
#[cfg(feature = "jpeg-2000")]
mod jpeg_2000;
#[cfg(feature = "jpeg")]
mod jpeg_extended;
#[cfg(feature = "jpeg-ls")]
mod jpeg_ls;
#[cfg(feature = "jpeg-xl")]
mod jpeg_xl;
mod rle;

use std::panic::{AssertUnwindSafe, catch_unwind};

/// How a bare codestream of JPEG XL begins.
pub(super) const JPEG_XL_CODESTREAM: &[u8] = &[0xFF, 0x0A];
/// How a file of JPEG XL begins: boxes, among them the codestream.
pub(super) const JPEG_XL_FILE: &[u8] = b"\0\0\0\x0cJXL \r\n\x87\n";

/// How pixel data are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// Not at all, and not encapsulated.
    Native,
    /// Not at all, but encapsulated.
    Raw,
    /// Deflate, frame by frame.
    Deflate,
    /// RLE Lossless.
    Rle,
    /// JPEG baseline, extended and lossless.
    Jpeg,
    /// JPEG-LS.
    JpegLs,
    /// JPEG 2000 and High-Throughput JPEG 2000.
    Jpeg2000,
    /// JPEG XL.
    JpegXl,
}

impl Encoding {
    /// How encapsulated pixel data of a transfer syntax are compressed; the error is its name.
    pub(crate) fn of_transfer_syntax(uid: &str) -> Result<Self, String> {
        // In a damaged file it may be any text, a patient's name too: that is not quoted.
        if !uid.bytes().all(|b| b.is_ascii_digit() || b == b'.') {
            return Err("something unknown (its TransferSyntaxUID is damaged)".to_owned());
        }
        let Some(suffix) = uid.strip_prefix("1.2.840.10008.1.2.") else {
            return Err(if uid.is_empty() { "it does not say".to_owned() } else { format!("'{uid}'") });
        };
        Ok(match suffix {
            "1.98" => Encoding::Raw,
            "8.1" => Encoding::Deflate,
            "5" => Encoding::Rle,
            // Progressive ones, too, which are retired.
            "4.50" | "4.51" | "4.53" | "4.55" | "4.57" | "4.70" => Encoding::Jpeg,
            "4.80" | "4.81" => Encoding::JpegLs,
            "4.90" | "4.91" | "4.92" | "4.93" | "4.201" | "4.202" | "4.203" => Encoding::Jpeg2000,
            "4.110" | "4.111" | "4.112" => Encoding::JpegXl,
            "4.100" | "4.101" => return Err("MPEG-2 video".to_owned()),
            "4.102" | "4.103" | "4.104" | "4.105" | "4.106" => return Err("MPEG-4 video".to_owned()),
            "4.107" | "4.108" => return Err("HEVC video".to_owned()),
            _ => return Err(format!("'{uid}'")),
        })
    }

    /// Why this build decodes none of it, and what to do; `None` where it does.
    pub(crate) fn left_out(self) -> Option<LeftOut> {
        self.codec().filter(|codec| !codec.is_here)
    }

    fn codec(self) -> Option<LeftOut> {
        macro_rules! codec {
            ($name:literal, $feature:literal) => {
                LeftOut {
                    what: concat!("it is compressed as ", $name, ", which this build of Lumivox does not decode"),
                    remedy: concat!(
                        "Use one with the feature '",
                        $feature,
                        "' of lumivox-import, or convert it to an uncompressed transfer syntax, for example with \
                         'gdcmconv --raw'"
                    ),
                    is_here: cfg!(feature = $feature),
                }
            };
        }
        Some(match self {
            Encoding::Native | Encoding::Raw | Encoding::Deflate | Encoding::Rle => return None,
            Encoding::Jpeg => codec!("JPEG", "jpeg"),
            Encoding::JpegLs => codec!("JPEG-LS", "jpeg-ls"),
            Encoding::Jpeg2000 => codec!("JPEG 2000", "jpeg-2000"),
            Encoding::JpegXl => codec!("JPEG XL", "jpeg-xl"),
        })
    }
}

/// What is said of a codec that a build is without.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeftOut {
    /// What a file is that needs it.
    pub(crate) what: &'static str,
    /// What its owner can do, a sentence.
    pub(crate) remedy: &'static str,
    is_here: bool,
}

/// The fault of a frame that is not there, since the file ends before it.
pub(crate) fn cut_off() -> CodecFault {
    "ends in the middle of its pixel data".into()
}

/// What the header says of a compressed frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FrameShape {
    pub(crate) encoding: Encoding,
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// Bytes of a sample in the file's own words.
    pub(crate) bytes: usize,
    /// Whether samples are single bits, of which eight make a byte.
    pub(crate) single_bits: bool,
}

impl FrameShape {
    fn samples(&self) -> usize {
        self.columns * self.rows
    }

    /// Bytes of a frame that is not compressed by more than its bits are packed.
    fn packed_bytes(&self) -> usize {
        if self.single_bits { self.samples().div_ceil(8) } else { self.samples() * self.bytes }
    }

    /// The samples of a frame in the file's own words.
    fn own_words(&self, words: Vec<u8>) -> Decoded {
        // Some writers compress a byte for each bit.
        if !self.single_bits || words.len() >= self.samples() {
            return Decoded { samples: words, bytes: self.bytes };
        }
        // The first sample is in the lowest bit (PS3.5 8.1.1).
        let bits = words.iter().flat_map(|byte| (0..8).map(move |bit| byte >> bit & 1));
        Decoded { samples: bits.take(self.samples()).collect(), bytes: 1 }
    }
}

/// Samples of a frame as a codec gives them: little endian, with bytes of their own number.
#[derive(Debug)]
pub(crate) struct Decoded {
    pub(crate) samples: Vec<u8>,
    pub(crate) bytes: usize,
}

/// Why a frame could not be decoded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum CodecFault {
    /// The codestream is broken; how, as a verb phrase.
    Damaged(String),
    /// No decoder is there for it; what it is, as a sentence.
    Unsupported(String),
}

impl From<String> for CodecFault {
    fn from(problem: String) -> Self {
        CodecFault::Damaged(problem)
    }
}

impl From<&str> for CodecFault {
    fn from(problem: &str) -> Self {
        CodecFault::Damaged(problem.to_owned())
    }
}

/// Decodes one frame.
///
/// # Errors
/// [`CodecFault`].
pub(crate) fn decode(stream: &[u8], format: &FrameShape) -> Result<Decoded, CodecFault> {
    // No decoder is known to panic on what passes the checks; if one does, it costs a slice and not the program.
    let decoded = catch_unwind(AssertUnwindSafe(|| match format.encoding {
        Encoding::Native | Encoding::Raw => Ok(format.own_words(stream.to_vec())),
        Encoding::Deflate => Ok(format.own_words(inflate(stream, format)?)),
        Encoding::Rle if format.single_bits => {
            let packed = rle::decode(stream, format.samples(), 1);
            let words = packed.or_else(|_| rle::decode(stream, format.packed_bytes(), 1))?;
            Ok(format.own_words(words))
        }
        Encoding::Rle => Ok(format.own_words(rle::decode(stream, format.samples(), format.bytes)?)),
        #[cfg(feature = "jpeg")]
        Encoding::Jpeg => jpeg::decode(stream, format),
        #[cfg(feature = "jpeg-ls")]
        Encoding::JpegLs => Ok(jpeg_ls::decode(stream, format)?),
        #[cfg(feature = "jpeg-2000")]
        Encoding::Jpeg2000 => Ok(jpeg_2000::decode(stream, format)?),
        #[cfg(feature = "jpeg-xl")]
        Encoding::JpegXl => jpeg_xl::decode(stream, format),
        // Headers are refused that name one of these.
        #[cfg(not(all(feature = "jpeg", feature = "jpeg-ls", feature = "jpeg-2000", feature = "jpeg-xl")))]
        other => Err(CodecFault::Unsupported(
            other.left_out().map_or("it is compressed", |codec| codec.what).into(),
        )),
    }))
    .unwrap_or_else(|_| Err("has a compressed frame that its decoder gave up on".into()))?;
    let expected = format.samples() * decoded.bytes;
    if decoded.samples.len() < expected {
        return Err(format!("holds {} bytes of samples instead of {expected}", decoded.samples.len()).into());
    }
    Ok(decoded)
}

/// The bits of a sample by the codestream's own word, and whether they have a sign; `None` where the samples are the file's
/// own bytes.
pub(crate) fn precision(stream: &[u8], encoding: Encoding) -> Option<(u32, bool)> {
    let of = |info: StreamInfo| (info.precision as u32, info.signed);
    match encoding {
        Encoding::Native | Encoding::Raw | Encoding::Deflate | Encoding::Rle => None,
        Encoding::Jpeg | Encoding::JpegLs => jpeg_info(stream).map(of),
        Encoding::Jpeg2000 => jpeg_2000_info(stream).ok().map(of),
        // As wide as they may be, and no wider than they come.
        Encoding::JpegXl => Some((16, false)),
    }
}

fn inflate(stream: &[u8], format: &FrameShape) -> Result<Vec<u8>, String> {
    use std::io::Read;
    let mut words = Vec::new();
    flate2::read::DeflateDecoder::new(stream)
        .take((format.samples() * format.bytes) as u64)
        .read_to_end(&mut words)
        .map_err(|e| format!("has damaged deflated frames ({e})"))?;
    Ok(words)
}

/// What a codestream's own header says.
#[cfg_attr(
    not(all(feature = "jpeg", feature = "jpeg-ls", feature = "jpeg-2000", feature = "jpeg-xl")),
    allow(dead_code, reason = "each codec looks at its own part")
)]
struct StreamInfo {
    /// The frame header's marker, for JPEG: which process it is.
    marker: usize,
    columns: usize,
    rows: usize,
    /// Bits of a sample.
    precision: usize,
    /// Whether samples have a sign, which those of JPEG and JPEG-LS never have.
    signed: bool,
    components: usize,
}

#[cfg_attr(
    not(all(feature = "jpeg", feature = "jpeg-ls", feature = "jpeg-2000", feature = "jpeg-xl")),
    allow(dead_code, reason = "each codec looks at its own part")
)]
impl StreamInfo {
    fn check(&self, format: &FrameShape) -> Result<(), String> {
        if (self.columns, self.rows) != (format.columns, format.rows) {
            return Err(format!(
                "has a codestream of {} x {} where Columns and Rows say {} x {}",
                self.columns, self.rows, format.columns, format.rows
            ));
        }
        if self.components != 1 {
            return Err(format!("has a codestream of {} components instead of one", self.components));
        }
        Ok(())
    }
}

/// Finds the frame header (SOF marker segment) of a JPEG or JPEG-LS stream.
fn jpeg_info(stream: &[u8]) -> Option<StreamInfo> {
    let word = |at: usize| Some(usize::from(u16::from_be_bytes([*stream.get(at)?, *stream.get(at + 1)?])));
    let mut at = 2;
    loop {
        // Any number of fill bytes may stand before a marker.
        while stream.get(at)? == &0xFF && stream.get(at + 1)? == &0xFF {
            at += 1;
        }
        let marker = word(at)?;
        match marker {
            // DHT, JPG and DAC lie among the SOF markers.
            0xFFC4 | 0xFFC8 | 0xFFCC => {}
            0xFFC0..=0xFFCF | 0xFFF7 => {
                return Some(StreamInfo {
                    marker,
                    precision: (*stream.get(at + 4)?).into(),
                    signed: false,
                    rows: word(at + 5)?,
                    columns: word(at + 7)?,
                    components: (*stream.get(at + 9)?).into(),
                });
            }
            0xFF01..=0xFFFE => {}
            _ => return None,
        }
        at += 2 + word(at + 2)?.max(2);
    }
}

/// What the SIZ segment of a JPEG 2000 stream says.
fn jpeg_2000_info(stream: &[u8]) -> Result<StreamInfo, String> {
    // The codestream begins with SOC and SIZ, by itself or within the boxes of a JP2 file.
    const BEGIN: [u8; 4] = [0xFF, 0x4F, 0xFF, 0x51];
    const SEARCHED: usize = 4096;
    let head = &stream[..stream.len().min(SEARCHED)];
    let start = head
        .windows(4)
        .position(|window| window == BEGIN)
        .ok_or("has no JPEG 2000 stream where one belongs")?;
    let siz = stream.get(start + 8..start + 43).ok_or("has a JPEG 2000 stream that is cut short")?;
    let long = |at: usize| u32::from_be_bytes([siz[at], siz[at + 1], siz[at + 2], siz[at + 3]]);
    Ok(StreamInfo {
        marker: 0,
        columns: long(0).saturating_sub(long(8)) as usize,
        rows: long(4).saturating_sub(long(12)) as usize,
        components: u16::from_be_bytes([siz[32], siz[33]]).into(),
        // Of the first component: one less, and whether it has a sign.
        precision: usize::from(siz[34] & 0x7F) + 1,
        signed: siz[34] & 0x80 != 0,
    })
}

/// Little endian samples from native ones.
#[cfg(any(feature = "jpeg", feature = "jpeg-ls"))]
fn little_endian_16(mut samples: Vec<u8>) -> Vec<u8> {
    if cfg!(target_endian = "big") {
        samples.chunks_exact_mut(2).for_each(|pair| pair.swap(0, 1));
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_codec_that_is_left_out_is_named_with_its_feature() {
        for (encoding, name, feature, is_here) in [
            (Encoding::Jpeg, "JPEG,", "'jpeg'", cfg!(feature = "jpeg")),
            (Encoding::JpegLs, "JPEG-LS,", "'jpeg-ls'", cfg!(feature = "jpeg-ls")),
            (Encoding::Jpeg2000, "JPEG 2000,", "'jpeg-2000'", cfg!(feature = "jpeg-2000")),
            (Encoding::JpegXl, "JPEG XL,", "'jpeg-xl'", cfg!(feature = "jpeg-xl")),
        ] {
            let codec = encoding.codec().expect("it is a codec of others");
            assert!(codec.what.contains(name) && codec.remedy.contains(feature), "{codec:?}");
            assert_eq!(encoding.left_out().is_none(), is_here, "{encoding:?}");
        }
        for always in [Encoding::Native, Encoding::Raw, Encoding::Deflate, Encoding::Rle] {
            assert!(always.left_out().is_none());
        }
    }
}
