//! NIfTI-1 and NIfTI-2 scans: `.nii`, `.nii.gz`, and pairs of `.hdr` and `.img`.
//!
//! After `nifti1.h` and `nifti2.h` of the NIfTI Data Format Working Group (<https://nifti.nimh.nih.gov>). Their space
//! is RAS: it is turned to LPS here. The `sform` is preferred to the `qform`, and that to bare spacing.

use std::{
    io::{BufReader, Read},
    path::{Path, PathBuf},
};

use lumivox_core::glam::{DAffine3, DMat3, DVec3};

use crate::{
    error::ImportError,
    files::File,
    payload::{ByteSkip, Encoding, GZIP_MAGIC, Payload, fill, inflate},
    sample::SampleType,
    single::{Single, axis_aligned, is_placement, lps_from_ras},
};

/// The longer of the two headers.
const HEADER_BYTES: usize = 540;

/// Which NIfTI a header is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    One,
    Two,
}

/// A header's bytes, read in their own byte order.
struct RawHeader {
    bytes: [u8; HEADER_BYTES],
    version: Version,
    big_endian: bool,
    /// Whether the samples lie in an `.img` file beside it.
    detached: bool,
}

/// Whether a file that begins with these bytes (after inflating) is NIfTI.
pub(crate) fn is_nifti(head: &[u8]) -> bool {
    recognise(head).is_some()
}

/// Whether a file begins as Analyze 7.5 does, NIfTI's forerunner without orientation.
pub(crate) fn is_analyze(head: &[u8]) -> bool {
    let size = [348u32.to_le_bytes(), 348u32.to_be_bytes()];
    head.len() >= 348 && size.iter().any(|s| head.starts_with(s)) && !is_nifti(head)
}

fn recognise(head: &[u8]) -> Option<(Version, bool, bool)> {
    let size: [u8; 4] = head.get(..4)?.try_into().ok()?;
    let (version, magic) = match (u32::from_le_bytes(size), u32::from_be_bytes(size)) {
        (348, _) | (_, 348) => (Version::One, head.get(344..348)?),
        (540, _) | (_, 540) => (Version::Two, head.get(4..8)?),
        _ => return None,
    };
    let detached = match (version, magic) {
        (Version::One, b"n+1\0") | (Version::Two, b"n+2\0") => false,
        (Version::One, b"ni1\0") | (Version::Two, b"ni2\0") => true,
        _ => return None,
    };
    Some((version, u32::from_le_bytes(size) > 0xffff, detached))
}

impl RawHeader {
    fn at<const N: usize>(&self, one: usize, two: usize) -> [u8; N] {
        let offset = if self.version == Version::One { one } else { two };
        let mut bytes: [u8; N] =
            self.bytes[offset..offset + N].try_into().expect("offsets lie in the header");
        if self.big_endian {
            bytes.reverse();
        }
        bytes
    }

    /// A field that is `i16` in version 1 and `i64` in version 2 (`dim`).
    fn dim(&self, i: usize) -> i64 {
        match self.version {
            Version::One => i16::from_le_bytes(self.at(40 + 2 * i, 0)).into(),
            Version::Two => i64::from_le_bytes(self.at(0, 16 + 8 * i)),
        }
    }

    /// A field that is `i16` in version 1 and `i32` in version 2.
    fn code(&self, one: usize, two: usize) -> i32 {
        match self.version {
            Version::One => i16::from_le_bytes(self.at(one, two)).into(),
            Version::Two => i32::from_le_bytes(self.at(one, two)),
        }
    }

    /// A field that is `f32` in version 1 and `f64` in version 2; `i` counts from the first of an array.
    fn float(&self, one: usize, two: usize, i: usize) -> f64 {
        match self.version {
            Version::One => f32::from_le_bytes(self.at(one + 4 * i, 0)).into(),
            Version::Two => f64::from_le_bytes(self.at(0, two + 8 * i)),
        }
    }

    fn pixdim(&self, i: usize) -> f64 {
        self.float(76, 104, i)
    }

    fn datatype(&self) -> i16 {
        i16::from_le_bytes(self.at(70, 12))
    }

    /// Millimetres in the header's unit of length.
    fn mm_per_unit(&self) -> f64 {
        let units = match self.version {
            Version::One => i32::from(self.bytes[123]),
            Version::Two => i32::from_le_bytes(self.at(0, 500)),
        };
        match units & 7 {
            1 => 1000.0,
            3 => 0.001,
            _ => 1.0,
        }
    }
}

/// Reads the header of a NIfTI scan.
///
/// # Errors
/// [`ImportError`] names the field, or the data that are missing.
pub(crate) fn open(path: &Path) -> Result<Single, ImportError> {
    let field = |field: &str, problem: String, remedy: &str| ImportError::Field {
        path: path.to_owned(),
        field: field.to_owned(),
        problem,
        remedy: remedy.to_owned(),
    };
    let (header, deflated) = read_header(path)?;
    let mut notes = Vec::new();

    let rank = header.dim(0);
    if !(1..=7).contains(&rank) {
        return Err(field("dim[0]", format!("is {rank}, not a number of axes"), "The header is damaged"));
    }
    let mut dim = [1usize; 8];
    for (i, size) in dim.iter_mut().enumerate().take(rank as usize + 1).skip(1) {
        let stored = header.dim(i);
        *size = usize::try_from(stored).ok().filter(|n| *n > 0).ok_or_else(|| {
            field(
                &format!("dim[{i}]"),
                format!("is {stored}, not a number of voxels"),
                "The header is damaged",
            )
        })?;
    }
    if dim[5..].iter().any(|n| *n > 1) {
        return Err(ImportError::Unsupported {
            path: path.to_owned(),
            what: format!("several values for each voxel ({} x {} x {})", dim[5], dim[6], dim[7]),
            remedy: "Export one component as a scan of its own".to_owned(),
        });
    }

    let (sample, channels) = sample_type(header.datatype()).map_err(|what| ImportError::Unsupported {
        path: path.to_owned(),
        what,
        remedy: "Convert it to a scan with one real number for each voxel".to_owned(),
    })?;
    let offset = match header.version {
        Version::One => header.float(108, 0, 0),
        Version::Two => i64::from_le_bytes(header.at(0, 168)) as f64,
    };
    // A single file's samples cannot begin inside its header.
    let least = match (header.detached, header.version) {
        (true, _) => 0.0,
        (false, Version::One) => 348.0,
        (false, Version::Two) => 540.0,
    };
    // Some writers leave it at 0 and begin behind the header and its four bytes of extension flags.
    let offset = if offset == 0.0 && !header.detached { least + 4.0 } else { offset };
    if !(least..1e15).contains(&offset) {
        let problem = format!("is {offset}, where no samples can begin");
        return Err(field("vox_offset", problem, "The header is damaged"));
    }

    let (data, deflated) = if header.detached { data_file(path)? } else { (path.to_owned(), deflated) };
    let payload = Payload {
        encoding: if deflated { Encoding::Deflate } else { Encoding::Raw },
        byte_skip: ByteSkip::Bytes(offset as u64),
        channels,
        ..Payload::in_file(&data, sample, header.big_endian, 0)
    };
    let dims = [dim[1], dim[2], dim[3]];
    let rescale = rescale(&header, &mut notes);
    let patient_from_voxel = placement(&header, rank as usize, path, &mut notes)?;
    Single {
        path: path.to_owned(),
        format: "NIfTI",
        dims,
        phases: dim[4],
        payload: payload.into(),
        rescale,
        patient_from_voxel,
        modality: None,
        notes,
    }
    .checked()
}

/// The contents of a header's extensions, in which programs leave what NIfTI has no field for.
///
/// # Errors
/// [`ImportError`] where the file cannot be read; what is no extension is none.
pub(crate) fn extensions(path: &Path) -> Result<Vec<Vec<u8>>, ImportError> {
    /// None is longer.
    const LONGEST: u64 = 4 << 20;
    let (header, deflated) = read_header(path)?;
    let size = if header.version == Version::One { 348 } else { 540 };
    let end = match (header.detached, header.version) {
        (true, _) => LONGEST,
        (false, Version::One) => header.float(108, 0, 0) as u64,
        (false, Version::Two) => i64::from_le_bytes(header.at(0, 168)) as u64,
    };
    let file = BufReader::new(File::open(path).map_err(ImportError::io(path))?);
    let input: Box<dyn Read> =
        if deflated { inflate(file).map_err(ImportError::io(path))? } else { Box::new(file) };
    let mut bytes = Vec::new();
    // A file that breaks off is complained about where its samples are read.
    let _ = input.take(end.min(LONGEST)).read_to_end(&mut bytes);
    let mut found = Vec::new();
    let has_any = bytes.get(size).is_some_and(|flag| *flag != 0);
    let mut rest = bytes.get(size + 4..).filter(|_| has_any).unwrap_or_default();
    while let Some((length, _)) = rest.split_first_chunk::<4>() {
        let length =
            if header.big_endian { i32::from_be_bytes(*length) } else { i32::from_le_bytes(*length) };
        let length = usize::try_from(length).ok().filter(|length| *length > 8);
        let Some(content) = length.and_then(|length| rest.get(8..length)) else { break };
        found.push(content.to_vec());
        rest = &rest[content.len() + 8..];
    }
    Ok(found)
}

/// The header, and whether its file is compressed.
fn read_header(path: &Path) -> Result<(RawHeader, bool), ImportError> {
    let mut file = BufReader::new(File::open(path).map_err(ImportError::io(path))?);
    let mut magic = [0; 2];
    let n = fill(&mut file, &mut magic).map_err(ImportError::io(path))?;
    file.seek_relative(-(n as i64)).map_err(ImportError::io(path))?;
    let deflated = magic == GZIP_MAGIC;
    let mut input: Box<dyn Read> =
        if deflated { inflate(file).map_err(ImportError::io(path))? } else { Box::new(file) };
    let mut bytes = [0; HEADER_BYTES];
    let n = fill(&mut *input, &mut bytes).map_err(ImportError::io(path))?;
    let (version, big_endian, detached) =
        recognise(&bytes[..n]).ok_or_else(|| ImportError::UnknownFormat {
            path: path.to_owned(),
            found: "it has no complete NIfTI header".to_owned(),
        })?;
    let size = if version == Version::One { 348 } else { 540 };
    if n < size {
        return Err(ImportError::Truncated {
            path: path.to_owned(),
            expected: size as u64,
            actual: n as u64,
        });
    }
    Ok((RawHeader { bytes, version, big_endian, detached }, deflated))
}

/// The `.img` beside a `.hdr`, and whether it is compressed.
fn data_file(header: &Path) -> Result<(PathBuf, bool), ImportError> {
    // `scan.hdr.gz` goes with `scan.img.gz`.
    let plain = if header.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz")) {
        header.with_extension("")
    } else {
        header.to_owned()
    };
    let candidates =
        ["img", "img.gz", "IMG"].map(|extension| (plain.with_extension(extension), extension == "img.gz"));
    let fallback = candidates[0].clone();
    Ok(candidates.into_iter().find(|(path, _)| crate::files::is_file(path)).unwrap_or(fallback))
}

/// The sample type of a NIfTI `datatype` code, or what it is instead.
/// With the samples of a voxel, which are several where it has a colour.
fn sample_type(code: i16) -> Result<(SampleType, usize), String> {
    let sample = match code {
        128 => return Ok((SampleType::U8, 3)),
        2304 => return Ok((SampleType::U8, 4)),
        2 => SampleType::U8,
        4 => SampleType::I16,
        8 => SampleType::I32,
        16 => SampleType::F32,
        64 => SampleType::F64,
        256 => SampleType::I8,
        512 => SampleType::U16,
        768 => SampleType::U32,
        1024 => SampleType::I64,
        1280 => SampleType::U64,
        1 => return Err("samples of one bit (datatype 1)".to_owned()),
        32 | 1792 | 2048 => return Err(format!("complex numbers (datatype {code})")),
        1536 => return Err("128-bit floats (datatype 1536)".to_owned()),
        _ => return Err(format!("samples of an unknown type (datatype {code})")),
    };
    Ok((sample, 1))
}

/// `scl_slope` and `scl_inter`; a slope of 0 means that there are none.
fn rescale(header: &RawHeader, notes: &mut Vec<String>) -> [f64; 2] {
    let [slope, intercept] = [header.float(112, 176, 0), header.float(116, 184, 0)];
    if slope == 0.0 {
        return [1.0, 0.0];
    }
    if !slope.is_normal() || !intercept.is_finite() {
        notes.push(format!("scl_slope {slope} and scl_inter {intercept} were ignored"));
        return [1.0, 0.0];
    }
    [slope, intercept]
}

/// LPS millimetres from voxel indices.
fn placement(
    header: &RawHeader,
    rank: usize,
    path: &Path,
    notes: &mut Vec<String>,
) -> Result<DAffine3, ImportError> {
    let lps = |ras: DAffine3| DAffine3::from_scale(DVec3::splat(header.mm_per_unit())) * lps_from_ras() * ras;
    if header.code(254, 348) > 0 {
        let row = |axis: usize| {
            std::array::from_fn::<f64, 4, _>(|i| header.float(280 + 16 * axis, 400 + 32 * axis, i))
        };
        let [x, y, z] = [row(0), row(1), row(2)];
        let column = |i: usize| DVec3::new(x[i], y[i], z[i]);
        let sform = lps(DAffine3::from_cols(column(0), column(1), column(2), column(3)));
        if is_placement(sform) {
            return Ok(sform);
        }
        notes.push("the sform is no placement in space and was ignored".to_owned());
    }

    let mut spacing = [1.0; 3];
    for (i, spacing) in spacing.iter_mut().enumerate() {
        let stored = header.pixdim(i + 1);
        if stored.is_normal() {
            *spacing = stored.abs();
        } else if i < rank && header.dim(i + 1) > 1 {
            return Err(ImportError::Field {
                path: path.to_owned(),
                field: format!("pixdim[{}]", i + 1),
                problem: format!("is {stored}, not a distance between voxels"),
                remedy: "Correct the header or export the scan again".to_owned(),
            });
        }
    }
    if header.code(252, 344) > 0 {
        let [b, c, d] = [0, 1, 2].map(|i| header.float(256, 352, i));
        let offset = [0, 1, 2].map(|i| header.float(268, 376, i));
        let qform = lps(DAffine3::from_mat3_translation(
            rotation([b, c, d])
                * DMat3::from_diagonal(DVec3::new(
                    spacing[0],
                    spacing[1],
                    // pixdim[0], the "qfac", mirrors the slices' axis.
                    if header.pixdim(0) < 0.0 { -spacing[2] } else { spacing[2] },
                )),
            DVec3::from_array(offset),
        ));
        if is_placement(qform) {
            return Ok(qform);
        }
        notes.push("the qform is no placement in space and was ignored".to_owned());
    }
    notes.push("no orientation is given: axes are taken for right, anterior, superior".to_owned());
    Ok(lps(axis_aligned(spacing, [0.0; 3])))
}

/// The rotation of a unit quaternion given by its vector part, as `nifti1.h` has it.
fn rotation([mut b, mut c, mut d]: [f64; 3]) -> DMat3 {
    let mut a = 1.0 - (b * b + c * c + d * d);
    if a < 1e-7 {
        // Rounding made it longer than 1: a half turn.
        let length = (b * b + c * c + d * d).sqrt();
        (a, b, c, d) = (0.0, b / length, c / length, d / length);
    } else {
        a = a.sqrt();
    }
    DMat3::from_quat(lumivox_core::glam::DQuat::from_xyzw(b, c, d, a))
}

#[cfg(test)]
mod tests;
