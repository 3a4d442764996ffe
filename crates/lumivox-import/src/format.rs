//! What a file is, by its content.

use std::{
    io::{BufRead, BufReader},
    path::Path,
};

use lumivox_core::document::SceneDocument;

use crate::{
    error::ImportError,
    files::File,
    metaimage, mgh, nifti, npy, nrrd,
    payload::{GZIP_MAGIC, fill, inflate},
    pictures, raw,
};

/// A format that Lumivox reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Format {
    Dicom,
    /// An archive, which may hold a DICOM folder.
    Zip,
    Nifti,
    Nrrd,
    MetaImage,
    Mgh,
    /// An array of NumPy.
    Npy,
    /// Pages, which may be the slices of a volume.
    Tiff,
    /// Samples without a header that something describes.
    Raw,
}

/// How much of a file is looked at.
const HEAD_BYTES: usize = 1024;

/// Recognises a file by its content; a RAW file by what describes it.
///
/// # Errors
/// [`ImportError::UnknownFormat`] says in words what it is instead.
pub(crate) fn recognise(path: &Path) -> Result<Format, ImportError> {
    let metadata = crate::files::metadata(path).map_err(ImportError::io(path))?;
    let unknown = |found: &str| ImportError::UnknownFormat { path: path.to_owned(), found: found.to_owned() };
    if metadata.is_dir() {
        return Err(unknown("it is a folder"));
    }
    // Reading a pipe or a device might never end.
    if !metadata.is_file() {
        return Err(unknown("it is not a plain file"));
    }
    let mut file = BufReader::new(File::open(path).map_err(ImportError::io(path))?);
    let mut head = vec![0; HEAD_BYTES];
    let start = file.fill_buf().map_err(ImportError::io(path))?;
    let gzip = start.starts_with(&GZIP_MAGIC);
    let filled = if gzip {
        match inflate(file).and_then(|mut input| fill(&mut *input, &mut head)) {
            Ok(filled @ 1..) => filled,
            _ => return Err(unknown("it is a damaged or empty gzip archive; copy or download it again")),
        }
    } else {
        fill(&mut file, &mut head).map_err(ImportError::io(path))?
    };
    head.truncate(filled);

    match (sniff(&head), gzip) {
        (Some(format @ (Format::Nifti | Format::Mgh)), _) => return Ok(format),
        (Some(format), false) => return Ok(format),
        (Some(format), true) => {
            return Err(unknown(&format!("it is a gzip archive of one {} file; unpack it", format.name())));
        }
        (None, _) => {}
    }
    if !gzip && metadata.length() > 0 && raw::find_description(path)?.is_some() {
        return Ok(Format::Raw);
    }
    // After RAW, whose first samples can look like it.
    if !gzip && is_bare_dicom(&head) {
        return Ok(Format::Dicom);
    }
    if let Some(header) = header_beside(path) {
        return Err(unknown(&format!("it holds samples only; open its header {header}")));
    }
    if gzip {
        return Err(unknown("it is a gzip archive of something else; unpack it"));
    }
    let found = describe(&head);
    if [ZEROS, NO_KIND].contains(&found.as_str()) && is_named_as_samples(path) {
        return Err(unknown(&format!(
            "{found}; if it holds samples without a header, describe them, for example as 256x256x108:i16le"
        )));
    }
    Err(unknown(&found))
}

/// Whether a file has a name that RAW has.
fn is_named_as_samples(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default();
    ["raw", "bin", "dat"].iter().any(|known| extension.eq_ignore_ascii_case(known))
}

impl Format {
    /// What people call it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Format::Dicom => "DICOM",
            Format::Zip => "zip",
            Format::Nifti => "NIfTI",
            Format::Nrrd => "NRRD",
            Format::MetaImage => "MetaImage",
            Format::Mgh => "MGH",
            Format::Npy => "NPY",
            Format::Tiff => "TIFF",
            Format::Raw => "RAW",
        }
    }
}

/// The format of a file that begins so.
pub(crate) fn sniff(head: &[u8]) -> Option<Format> {
    if head.starts_with(nrrd::MAGIC) {
        Some(Format::Nrrd)
    } else if nifti::is_nifti(head) {
        Some(Format::Nifti)
    } else if head.get(128..132) == Some(b"DICM") {
        Some(Format::Dicom)
    } else if head.starts_with(b"PK\x03\x04") || head.starts_with(b"PK\x05\x06") {
        Some(Format::Zip)
    } else if head.starts_with(npy::MAGIC) {
        Some(Format::Npy)
    } else if pictures::is_tiff(head) {
        Some(Format::Tiff)
    } else if metaimage::is_metaimage(head) {
        Some(Format::MetaImage)
    } else if mgh::is_mgh(head) {
        Some(Format::Mgh)
    } else {
        None
    }
}

/// Whether a file begins with a DICOM element, without the preamble that it should have.
fn is_bare_dicom(head: &[u8]) -> bool {
    if head.starts_with(b"DICM") {
        return true;
    }
    let big_endian = head.first() == Some(&0);
    let u16_at = |i: usize| {
        let bytes = [*head.get(i)?, *head.get(i + 1)?];
        Some(if big_endian { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) })
    };
    // Files begin with the file meta group or the identifying group.
    let (Some(group @ (0x0002 | 0x0008)), Some(0..=0x20)) = (u16_at(0), u16_at(2)) else { return false };
    let vrs = [b"UL", b"UI", b"CS", b"SH", b"DA", b"TM", b"LO"];
    let length = match (head.get(4..6), u16_at(6)) {
        (Some(vr), Some(length)) if vrs.iter().any(|known| *known == vr) => length,
        // Without a VR the length has four bytes: it is short and even.
        (Some(&[low, 0]), Some(0)) if !big_endian && low % 2 == 0 => low.into(),
        _ => return false,
    };
    // Two elements in a row are hardly chance.
    u16_at(8 + usize::from(length)).is_none_or(|next| next == group || next == 0x0008)
}

/// The header beside a file of samples: the same name with another extension.
fn header_beside(path: &Path) -> Option<String> {
    // `scan.raw.gz` goes with `scan.nhdr`.
    let is_gzip = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gz"));
    let plain = if is_gzip { path.with_extension("") } else { path.to_owned() };
    ["hdr", "mhd", "nhdr"].into_iter().map(|extension| plain.with_extension(extension)).find_map(|header| {
        if header == path || !crate::files::is_file(&header) {
            return None;
        }
        let mut head = vec![0; HEAD_BYTES];
        let n = fill(&mut File::open(&header).ok()?, &mut head).ok()?;
        sniff(&head[..n])?;
        Some(header.file_name()?.to_string_lossy().into_owned())
    })
}

/// Beginnings of files that people mistake for scans, and what those are.
const OTHERS: [(&[u8], &str); 26] = [
    (b"\x89PNG", "this is a PNG image; a folder of slices, with nothing else in it, is read as a stack"),
    (b"\xff\xd8\xff", "this is a JPEG image"),
    (b"GIF8", "this is a GIF image"),
    (b"RIFF", "this is a WebP image or a film"),
    (b"\0\0\0\x0cjP", "this is a JPEG 2000 image"),
    (b"%PDF", "this is a PDF document"),
    (b"{\\rtf", "this is an RTF document"),
    (b"\xd0\xcf\x11\xe0", "this is an Office document"),
    (b"v/1\x01", "this is an OpenEXR image: light for a scene, not a scan"),
    (b"#?RADIANCE", "this is a Radiance HDR image: light for a scene, not a scan"),
    (b"#?RGBE", "this is a Radiance HDR image: light for a scene, not a scan"),
    (b"\x89HDF", "this is an HDF5 file, perhaps MINC; convert it to NIfTI"),
    (b"CDF", "this is a NetCDF file, perhaps MINC 1; convert it to NIfTI"),
    (b"# vtk DataFile", "this is a VTK file; save it as MetaImage or NRRD"),
    (b"MATLAB", "this is a MATLAB file; save it as NIfTI"),
    (b"mrtrix image", "this is an image of MRtrix (MIF); convert it with 'mrconvert image.mif image.nii.gz'"),
    (b"solid ", "this is an STL surface, not a volume"),
    (b"glTF", "this is a glTF scene, not a volume"),
    (b"ply\n", "this is a PLY surface, not a volume"),
    (b"BZh", "this is a bzip2 archive; unpack it"),
    (b"\xfd7zXZ", "this is an xz archive; unpack it"),
    (b"7z\xbc\xaf", "this is a 7-Zip archive; unpack it, or pack it as zip"),
    (b"Rar!", "this is a RAR archive; unpack it, or pack it as zip"),
    (b"\x28\xb5\x2f\xfd", "this is a Zstandard archive; unpack it"),
    (b"\x7fELF", "this is a program"),
    (b"version https://git-lfs", "this is a Git LFS pointer; fetch the file that it stands for"),
];

const ZEROS: &str = "it begins with nothing but zeros";
const NO_KIND: &str = "its content is of no known kind";

/// What an unknown file is, in words.
fn describe(head: &[u8]) -> String {
    if head.is_empty() {
        return "it is empty".to_owned();
    }
    if let Some((_, what)) = OTHERS.iter().find(|(magic, _)| head.starts_with(magic)) {
        return (*what).to_owned();
    }
    if let Some(what) = describe_text(head) {
        return what.to_owned();
    }
    if nifti::is_analyze(head) {
        return "this is an Analyze 7.5 header, which does not tell left from right; convert it to NIfTI"
            .to_owned();
    }
    if head.iter().all(|b| *b == 0) {
        return ZEROS.to_owned();
    }
    let text = String::from_utf8_lossy(head);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let lower = text.get(..text.len().min(15)).unwrap_or_default().to_ascii_lowercase();
    let printable = head.iter().all(|b| (*b >= b' ' && *b != 0x7f) || b.is_ascii_whitespace());
    if lower.starts_with("<!doctype html") || lower.starts_with("<html") {
        "this is an HTML page, perhaps a failed download".to_owned()
    } else if lower.starts_with("<?xml") || lower.starts_with("<vtkfile") {
        "this is an XML file".to_owned()
    } else if SceneDocument::is_one(head) {
        "this is a scene of Lumivox's, which names scans, and no scan".to_owned()
    } else if printable && (text.starts_with('{') || text.starts_with('[')) {
        "this is a JSON file".to_owned()
    } else if printable && text.starts_with("dim") {
        "this describes a RAW volume; open that".to_owned()
    } else if printable {
        "this is a text file".to_owned()
    } else {
        NO_KIND.to_owned()
    }
}

/// What a header of text is, by its words: of formats that other programs turn into ones that are read.
fn describe_text(head: &[u8]) -> Option<&'static str> {
    let text = String::from_utf8_lossy(head);
    let start = text.trim_start();
    if start.starts_with("type = string-attribute")
        || start.starts_with("type = integer-attribute")
        || start.starts_with("type = float-attribute")
    {
        return Some("this is the header of an AFNI dataset (HEAD, BRIK); convert it with '3dAFNItoNIFTI'");
    }
    let is_par = start.starts_with("# === DATA DESCRIPTION FILE")
        || start.starts_with("#") && text.contains("CLINICAL TRYOUT");
    is_par.then_some("this is the header of a Philips PAR/REC export; convert it with 'dcm2niix'")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recognised(name: &str, content: &[u8]) -> Result<Format, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        recognise(&path).map_err(|e| e.to_string())
    }

    #[test]
    fn names_do_not_matter() {
        assert_eq!(recognised("scan.dcm", b"NRRD0004\n"), Ok(Format::Nrrd));
        assert_eq!(recognised("scan", b"ObjectType = Image\nNDims = 3\n"), Ok(Format::MetaImage));
        assert_eq!(recognised("scan.png", b"PK\x03\x04...."), Ok(Format::Zip));
        let mut dicom = vec![0; 128];
        dicom.extend(b"DICM");
        assert_eq!(recognised("a.nii", &dicom), Ok(Format::Dicom));
        let bare = [&b"\x08\0\x05\0CS\x0a\0ISO_IR 100\x08\0\x16\0UI"[..], &[0; 40]].concat();
        assert_eq!(recognised("a.raw", &bare), Ok(Format::Dicom));
        let big = [&b"\0\x08\0\x05CS\0\x0aISO_IR 100\0\x08\0\x16UI"[..], &[0; 40]].concat();
        assert_eq!(recognised("a", &big), Ok(Format::Dicom));
        let implicit = [&b"\x08\0\x05\0\x0a\0\0\0ISO_IR 100\x08\0\x16\0"[..], &[0; 40]].concat();
        assert_eq!(recognised("a", &implicit), Ok(Format::Dicom));
        assert_eq!(recognised("a", b"DICM\x02\0\0\0UL\x04\0"), Ok(Format::Dicom));
    }

    #[test]
    fn what_is_not_a_scan_is_called_by_its_name() {
        let of = |content: &[u8]| recognised("scan.dcm", content).unwrap_err();
        assert!(of(b"").contains("it is empty"));
        assert!(of(b"\x89PNG\r\n\x1a\n").contains("this is a PNG image; a folder of slices"));
        assert!(of(b"mrtrix image\ndim: 2,2,2\n").contains("mrconvert"));
        assert!(of(b"\ntype = string-attribute\nname = TYPESTRING\n").contains("3dAFNItoNIFTI"));
        assert!(
            of(b"# === DATA DESCRIPTION FILE ====\n#\n# CAUTION - Investigational device\n")
                .contains("dcm2niix")
        );
        assert!(of(b"<!DOCTYPE html>").contains("this is an HTML page"));
        assert!(of(b"hello, doctor").contains("this is a text file"));
        assert!(of(&[0; 500]).contains("nothing but zeros"));
        assert!(of(b"\x01\x02\x03\xff\xfe").contains("of no known kind"));
        for name in ["scan.raw", "scan.BIN", "scan.dat"] {
            let error = recognised(name, b"\x01\x02\x03\xff\xfe").unwrap_err();
            assert!(error.contains("as 256x256x108:i16le"), "{error}");
        }
        assert!(!of(b"\x01\x02\x03\xff\xfe").contains("256x256x108"));
        assert!(of(b"\x1f\x8b garbage").contains("gzip archive"));
        let folder = tempfile::tempdir().unwrap();
        assert!(recognise(folder.path()).unwrap_err().to_string().contains("it is a folder"));
        assert!(matches!(recognise(&folder.path().join("none")), Err(ImportError::Io { .. })));
    }

    #[test]
    fn samples_lead_to_their_description_or_header() {
        assert_eq!(recognised("head_2x2x2_uint8.raw", &[1; 8]), Ok(Format::Raw));
        assert!(recognised("head_2x2x2_uint8.raw", &[]).unwrap_err().contains("it is empty"));
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path().join("a.raw");
        std::fs::write(&data, [1, 2, 3, 0xff]).unwrap();
        std::fs::write(data.with_extension("mhd"), "ObjectType = Image\nNDims = 3\n").unwrap();
        assert!(recognise(&data).unwrap_err().to_string().contains("open its header a.mhd"));
        std::fs::write(folder.path().join("a.raw.ini"), "dimx:2\ndimy:2\ndimz:1\nformat:uint8").unwrap();
        assert_eq!(recognise(&data).unwrap(), Format::Raw);
    }
}
