//! Encapsulated pixel data (PS3.5 annex A.4): from fragments to frames, and from a compressed frame to samples.
//!
//! A codestream's own header is compared with the file's before a decoder sees it, so that none takes memory for an
//! image of another size.

use std::panic::{AssertUnwindSafe, catch_unwind};

use super::{header::PixelFormat, rle, source::Input};

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
            "4.50" | "4.51" | "4.57" | "4.70" => Encoding::Jpeg,
            "4.80" | "4.81" => Encoding::JpegLs,
            "4.90" | "4.91" | "4.92" | "4.93" | "4.201" | "4.202" | "4.203" => Encoding::Jpeg2000,
            "4.110" | "4.111" | "4.112" => return Err("JPEG XL".to_owned()),
            "4.100" | "4.101" => return Err("MPEG-2 video".to_owned()),
            "4.102" | "4.103" | "4.104" | "4.105" | "4.106" => return Err("MPEG-4 video".to_owned()),
            "4.107" | "4.108" => return Err("HEVC video".to_owned()),
            _ => return Err(format!("'{uid}'")),
        })
    }
}

/// Reads the fragments at `input`'s position and joins them to one codestream per frame.
///
/// # Errors
/// A verb phrase about what is wrong with the fragments.
pub(crate) fn read_frames(input: &mut Input, frames: usize) -> Result<Vec<Vec<u8>>, String> {
    let (offsets, fragments) = read_fragments(input).map_err(|e| format!("has damaged fragments ({e})"))?;
    if frames == 1 {
        return Ok(vec![fragments.concat()]);
    }
    if fragments.len() == frames {
        return Ok(fragments);
    }
    let starts: Vec<usize> = if offsets.len() == frames {
        // Offsets count the heads of the items too.
        let mut end = 0;
        let mut positions = Vec::with_capacity(fragments.len());
        for fragment in &fragments {
            positions.push(end);
            end += 8 + fragment.len() as u64;
        }
        let find = |offset: &u32| positions.binary_search(&u64::from(*offset)).ok();
        offsets.iter().map(find).collect::<Option<_>>().ok_or("has an offset table that points nowhere")?
    } else {
        // Without a table, frames begin where codestreams do: JPEG's start of image, JPEG 2000's start of codestream.
        let begins =
            |fragment: &Vec<u8>| fragment.starts_with(&[0xFF, 0xD8]) || fragment.starts_with(&[0xFF, 0x4F]);
        fragments.iter().enumerate().filter(|(_, fragment)| begins(fragment)).map(|(k, _)| k).collect()
    };
    if starts.len() != frames || starts.first() != Some(&0) || !starts.is_sorted() {
        return Err(format!("has {} fragments that do not make {frames} frames", fragments.len()));
    }
    let ends = starts.iter().skip(1).copied().chain([fragments.len()]);
    Ok(starts.iter().zip(ends).map(|(&start, end)| fragments[start..end].concat()).collect())
}

/// The basic offset table and the fragments. Never more memory than there are bytes in the file.
fn read_fragments(input: &mut Input) -> std::io::Result<(Vec<u32>, Vec<Vec<u8>>)> {
    let mut items = Vec::new();
    loop {
        let mut head = [0; 8];
        // Some writers leave the delimiter out.
        if input.read_up_to(&mut head)? < 8 {
            break;
        }
        let [.., a, b, c, d] = head;
        match &head[..4] {
            [0xFE, 0xFF, 0x00, 0xE0] => {
                items.push(input.read_vec(u32::from_le_bytes([a, b, c, d]).into())?);
            }
            [0xFE, 0xFF, 0xDD, 0xE0] => break,
            _ => return Err(std::io::ErrorKind::InvalidData.into()),
        }
    }
    if items.is_empty() {
        return Err(std::io::ErrorKind::UnexpectedEof.into());
    }
    let table = items.remove(0);
    let offsets = table.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    Ok((offsets, items))
}

/// Samples of a frame as a codec gives them: little endian, with bytes of their own number.
#[derive(Debug)]
pub(crate) struct Decoded {
    pub(crate) samples: Vec<u8>,
    pub(crate) bytes: usize,
}

/// Why a frame could not be decoded.
#[derive(Debug)]
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
pub(crate) fn decode(stream: &[u8], format: &PixelFormat) -> Result<Decoded, CodecFault> {
    // No decoder is known to panic on what passes the checks; if one does, it costs a slice and not the program.
    let decoded = catch_unwind(AssertUnwindSafe(|| match format.encoding {
        Encoding::Native | Encoding::Raw => Ok(Decoded { samples: stream.to_vec(), bytes: format.bytes }),
        Encoding::Deflate => Ok(inflate(stream, format)?),
        Encoding::Rle => {
            let samples = rle::decode(stream, format.columns * format.rows, format.bytes)?;
            Ok(Decoded { samples, bytes: format.bytes })
        }
        Encoding::Jpeg => jpeg(stream, format),
        Encoding::JpegLs => Ok(jpeg_ls(stream, format)?),
        Encoding::Jpeg2000 => Ok(jpeg_2000(stream, format)?),
    }))
    .unwrap_or_else(|_| Err("has a compressed frame that its decoder gave up on".into()))?;
    let expected = format.columns * format.rows * decoded.bytes;
    if decoded.samples.len() < expected {
        return Err(format!("holds {} bytes of samples instead of {expected}", decoded.samples.len()).into());
    }
    Ok(decoded)
}

fn inflate(stream: &[u8], format: &PixelFormat) -> Result<Decoded, String> {
    use std::io::Read;
    let mut samples = Vec::new();
    flate2::read::DeflateDecoder::new(stream)
        .take(format.frame_bytes() as u64)
        .read_to_end(&mut samples)
        .map_err(|e| format!("has damaged deflated frames ({e})"))?;
    Ok(Decoded { samples, bytes: format.bytes })
}

/// What a codestream's own header says.
struct StreamInfo {
    columns: usize,
    rows: usize,
    precision: usize,
    components: usize,
}

impl StreamInfo {
    fn check(&self, format: &PixelFormat) -> Result<(), String> {
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
                    precision: (*stream.get(at + 4)?).into(),
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

fn jpeg(stream: &[u8], format: &PixelFormat) -> Result<Decoded, CodecFault> {
    use jpeg_decoder::PixelFormat::{L8, L16};
    let info = jpeg_info(stream).ok_or("has a JPEG stream without a frame header")?;
    info.check(format)?;
    let mut decoder = jpeg_decoder::Decoder::new(stream);
    decoder.set_max_decoding_buffer_size(format.columns * format.rows * 2);
    let samples = decoder.decode().map_err(|e| match e {
        jpeg_decoder::Error::Unsupported(_) => {
            CodecFault::Unsupported(format!("it is compressed as JPEG of {} bits", info.precision))
        }
        e => CodecFault::Damaged(format!("has a damaged JPEG stream ({e})")),
    })?;
    match decoder.info().map(|info| info.pixel_format) {
        Some(L8) => Ok(Decoded { samples, bytes: 1 }),
        Some(L16) => Ok(Decoded { samples: little_endian_16(samples), bytes: 2 }),
        _ => Err("has a JPEG stream in colour".into()),
    }
}

fn jpeg_ls(stream: &[u8], format: &PixelFormat) -> Result<Decoded, String> {
    let info = jpeg_info(stream).ok_or("has a JPEG-LS stream without a frame header")?;
    info.check(format)?;
    let samples = charls::CharLS::default()
        .decode(stream)
        .map_err(|e| format!("has a damaged JPEG-LS stream ({e})"))?;
    if info.precision <= 8 {
        Ok(Decoded { samples, bytes: 1 })
    } else {
        Ok(Decoded { samples: little_endian_16(samples), bytes: 2 })
    }
}

fn jpeg_2000(stream: &[u8], format: &PixelFormat) -> Result<Decoded, String> {
    // The codestream begins with SOC and SIZ, by itself or within the boxes of a JP2 file.
    const BEGIN: [u8; 4] = [0xFF, 0x4F, 0xFF, 0x51];
    const SEARCHED: usize = 4096;
    let head = &stream[..stream.len().min(SEARCHED)];
    let start = head
        .windows(4)
        .position(|window| window == BEGIN)
        .ok_or("has no JPEG 2000 stream where one belongs")?;
    let siz = stream.get(start + 8..start + 42).ok_or("has a JPEG 2000 stream that is cut short")?;
    let long = |at: usize| u32::from_be_bytes([siz[at], siz[at + 1], siz[at + 2], siz[at + 3]]);
    StreamInfo {
        columns: long(0).saturating_sub(long(8)) as usize,
        rows: long(4).saturating_sub(long(12)) as usize,
        components: u16::from_be_bytes([siz[32], siz[33]]).into(),
        precision: 0,
    }
    .check(format)?;
    // Strict: a stream that is cut short is an error, not a blurred slice.
    let parameters = jpeg2k::DecodeParameters::new().strict(true);
    let image = jpeg2k::Image::from_bytes_with(stream, parameters)
        .map_err(|e| format!("has a damaged JPEG 2000 stream ({e})"))?;
    let component = image.components().first().ok_or("has an empty JPEG 2000 stream")?;
    if (component.width() as usize, component.height() as usize) != (format.columns, format.rows) {
        return Err("has a subsampled JPEG 2000 stream".to_owned());
    }
    let data = component.data();
    // Never narrower than the file's own samples, since these may have a sign.
    Ok(match component.precision().max(8 * format.bytes as u32) {
        ..=8 => Decoded { samples: data.iter().map(|&s| s as u8).collect(), bytes: 1 },
        9..=16 => {
            Decoded { samples: data.iter().flat_map(|&s| (s as u16).to_le_bytes()).collect(), bytes: 2 }
        }
        _ => Decoded { samples: data.iter().flat_map(|&s| s.to_le_bytes()).collect(), bytes: 4 },
    })
}

/// Little endian samples from native ones.
fn little_endian_16(mut samples: Vec<u8>) -> Vec<u8> {
    if cfg!(target_endian = "big") {
        samples.chunks_exact_mut(2).for_each(|pair| pair.swap(0, 1));
    }
    samples
}
