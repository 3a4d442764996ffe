//! Stacks of pictures as volumes: folders of PNG or TIFF slices, and TIFF files of several pages, those of OME and ImageJ
//! too.
//!
//! A picture has no place: slices follow each other by their names, counted as people count (`slice9` before `slice10`),
//! pages by their order. Distances are those that OME-TIFF and ImageJ write, else what [`ImportOptions`] say.

mod ome;
mod png;
mod tiff;

use std::{
    io::Read,
    path::{Path, PathBuf},
    sync::Arc,
};

use lumivox_core::CancelToken;

use crate::{
    ImportOptions,
    error::ImportError,
    files::File,
    placement::placement,
    sample::SampleType,
    samples::{Planes, Samples},
    single::Single,
};
use ome::Pages;

/// No file of pictures unpacks to more than so many times its size, and some more: deflate cannot.
const LARGEST_RATIO: u64 = 1032;
const ALWAYS: u64 = 1 << 20;
/// Pictures in a stack; more are no scan.
const MOST_PICTURES: usize = 1 << 16;

/// What a picture is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shape {
    width: usize,
    height: usize,
    sample: SampleType,
    /// 1 grey, 2 grey and opacity, 3 and 4 colours.
    channels: usize,
}

impl Shape {
    /// Bytes of a picture; `None` for more than memory has.
    fn bytes(&self) -> Option<usize> {
        let samples = self.width.checked_mul(self.height)?.checked_mul(self.channels)?;
        samples.checked_mul(self.sample.bytes()).filter(|bytes| *bytes <= isize::MAX as usize)
    }
}

/// What pictures are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Png,
    Tiff,
}

/// Whether a file begins as TIFF does.
pub(crate) fn is_tiff(head: &[u8]) -> bool {
    [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|magic| head.starts_with(*magic))
}

fn kind(path: &Path) -> Option<Kind> {
    // Opening a pipe might wait for ever.
    let is_file = crate::files::metadata(path).is_ok_and(|metadata| metadata.is_file());
    let mut head = [0; 8];
    let file = is_file.then(|| File::open(path).ok()).flatten();
    file?.read_exact(&mut head).ok()?;
    match head {
        [0x89, b'P', b'N', b'G', ..] => Some(Kind::Png),
        _ if is_tiff(&head) => Some(Kind::Tiff),
        _ => None,
    }
}

/// Whether files are PNG or TIFF, all of them, and any.
pub(crate) fn are_pictures(files: &[PathBuf]) -> bool {
    !files.is_empty() && files.iter().all(|file| kind(file).is_some())
}

/// The volumes of a TIFF file, one for each channel.
///
/// # Errors
/// [`ImportError`] names the file, and what is wrong with it.
pub(crate) fn open_tiff(
    path: &Path,
    options: &ImportOptions,
    cancel: &CancelToken,
) -> Result<Vec<Single>, ImportError> {
    let document = tiff::read(path, cancel)?;
    if document.pages == 1 {
        return Err(ImportError::Unsupported {
            path: path.to_owned(),
            what: "a picture of one page (TIFF)".to_owned(),
            remedy: "Open the folder that holds all slices, with nothing else in it".to_owned(),
        });
    }
    check_size(path, &document.shape, document.pages)?;
    let mut notes = document.notes;
    let Pages { pages, channels, depth, moments, spacing } =
        ome::pages(path, &document.description, document.pages)?
            .unwrap_or_else(|| Pages::plain(document.pages));
    let per_channel = |channel: usize| -> Vec<usize> {
        pages.iter().filter(|page| page.channel == channel).map(|page| page.at).collect()
    };
    let source = Arc::new(tiff::Source::new(vec![path.to_owned()]));
    let shape = document.shape;
    let spacing_mm = spacing.and_then(|spacing| spacing.mm(options, &mut notes));
    let patient_from_voxel = placement(options, &[0, 1, 2], spacing_mm, &mut notes);
    let single = |channel: usize| {
        let stack = Stack { source: source.clone(), pages: per_channel(channel), shape };
        let mut notes = notes.clone();
        if channels > 1 {
            notes.push(format!("channel {} of {channels}", channel + 1));
        }
        Single {
            path: path.to_owned(),
            format: "TIFF",
            dims: [shape.width, shape.height, depth],
            phases: moments,
            payload: stack.samples(vec![path.to_owned()]),
            rescale: [1.0, 0.0],
            patient_from_voxel,
            modality: None,
            notes,
        }
        .checked()
    };
    (0..channels).map(single).collect()
}

/// The volume of pictures that are slices, in the order of their names; `None` where some are none.
///
/// # Errors
/// [`ImportError`] names the file, and what is wrong with it.
pub(crate) fn open_slices(
    paths: &[PathBuf],
    options: &ImportOptions,
    cancel: &CancelToken,
) -> Result<Option<Single>, ImportError> {
    let Some(first) = paths.first() else { return Ok(None) };
    let Some(kind) = kind(first) else { return Ok(None) };
    if paths.len() < 2
        || paths.len() > MOST_PICTURES
        || paths[1..].iter().any(|path| self::kind(path) != Some(kind))
    {
        return Ok(None);
    }
    let mut paths = paths.to_vec();
    paths.sort_by_cached_key(|path| natural(&path.file_name().unwrap_or_default().to_string_lossy()));
    let mut shapes = Vec::with_capacity(paths.len());
    for path in &paths {
        cancel.check()?;
        let own = match kind {
            Kind::Png => png::shape(path)?,
            Kind::Tiff => {
                let document = tiff::read(path, cancel)?;
                if document.pages > 1 {
                    return Err(ImportError::Unsupported {
                        path: path.clone(),
                        what: format!("a stack of {} pages among other files", document.pages),
                        remedy: "Open it by itself".to_owned(),
                    });
                }
                document.shape
            }
        };
        check_size(path, &own, 1)?;
        shapes.push(own);
    }
    if let Some(error) = odd_one(&paths, &shapes) {
        return Err(error);
    }
    let shape = shapes[0];
    let (path, count) = (paths[0].clone(), paths.len());
    let mut notes = vec![format!("{count} pictures, in the order of their names")];
    notes.extend(gaps(&paths));
    let patient_from_voxel = placement(options, &[0, 1, 2], None, &mut notes);
    let source: Arc<dyn Source> = match kind {
        Kind::Png => Arc::new(png::Source(paths.clone())),
        Kind::Tiff => Arc::new(tiff::Source::new(paths.clone())),
    };
    let stack = Stack { source, pages: (0..count).collect(), shape };
    Single {
        path,
        format: match kind {
            Kind::Png => "PNG",
            Kind::Tiff => "TIFF",
        },
        dims: [shape.width, shape.height, count],
        phases: 1,
        payload: stack.samples(paths),
        rescale: [1.0, 0.0],
        patient_from_voxel,
        modality: None,
        notes,
    }
    .checked()
    .map(Some)
}

/// The error about pictures that are not like most: by its size another program's picture, or a rendered one, is told from slices.
fn odd_one(paths: &[PathBuf], shapes: &[Shape]) -> Option<ImportError> {
    let mut counts: Vec<(Shape, usize)> = Vec::new();
    for shape in shapes {
        match counts.iter_mut().find(|(known, _)| known == shape) {
            Some((_, count)) => *count += 1,
            None => counts.push((*shape, 1)),
        }
    }
    // Of as many, those that come first.
    let (usual, like) = counts.iter().rev().max_by_key(|(_, count)| *count).copied()?;
    let odd = shapes.iter().position(|shape| *shape != usual)?;
    let words = |shape: Shape| {
        format!("{} x {} pixels, {} of {}", shape.width, shape.height, shape.channels, shape.sample)
    };
    let others = if shapes[0] == usual { "the first has" } else { "the others have" };
    let remedy = match shapes.len() - like {
        1 => "Move it elsewhere: slices of one stack have a folder of their own".to_owned(),
        n => {
            format!("Move it, and {} more, elsewhere: slices of one stack have a folder of their own", n - 1)
        }
    };
    Some(ImportError::Unsupported {
        path: paths[odd].clone(),
        what: format!("a slice of {} where {others} {}", words(shapes[odd]), words(usual)),
        remedy,
    })
}

/// Refuses pictures that are larger than their file can hold, before memory is taken for them.
fn check_size(path: &Path, shape: &Shape, pages: usize) -> Result<(), ImportError> {
    let actual = crate::files::metadata(path).map_err(ImportError::io(path))?.length();
    let expected = shape.bytes().and_then(|bytes| bytes.checked_mul(pages)).map(|bytes| bytes as u64);
    match expected {
        Some(expected)
            if expected > 0 && expected <= actual.saturating_mul(LARGEST_RATIO).saturating_add(ALWAYS) =>
        {
            Ok(())
        }
        _ => Err(damaged(path, &format!("of {actual} bytes cannot hold the pictures that it promises"))),
    }
}

/// Text and numbers in turn, so that names are in the order in which people count.
fn natural(name: &str) -> Vec<(String, Option<u128>)> {
    let mut parts = Vec::new();
    let mut rest = name;
    while !rest.is_empty() {
        let text = rest.find(|c: char| c.is_ascii_digit()).unwrap_or(rest.len());
        let digits = rest[text..].find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len() - text);
        let number = (digits > 0).then(|| rest[text..text + digits].parse().unwrap_or(u128::MAX));
        parts.push((rest[..text].to_lowercase(), number));
        rest = &rest[text + digits..];
    }
    parts
}

/// What to say of a folder that holds pictures beside other files; `None` where there are hardly any.
pub(crate) fn beside_others(folder: &Path, files: &[PathBuf]) -> Option<ImportError> {
    let pictures = files.iter().filter(|file| kind(file).is_some()).count();
    (2..files.len()).contains(&pictures).then(|| ImportError::Unsupported {
        path: folder.to_owned(),
        what: format!("{pictures} pictures (PNG or TIFF) among {} files", files.len()),
        remedy: "Keep the slices of one stack in a folder of their own, with nothing else in it".to_owned(),
    })
}

/// A sentence about pictures that seem to be missing: names alike but for a number, whose steps are even but for gaps.
fn gaps(paths: &[PathBuf]) -> Option<String> {
    /// More gaps are not listed.
    const LISTED: usize = 5;
    let names: Vec<_> =
        paths.iter().map(|path| natural(&path.file_name().unwrap_or_default().to_string_lossy())).collect();
    let first = names.first()?;
    let is_like_first = |name: &Vec<(String, Option<u128>)>| {
        name.len() == first.len() && name.iter().zip(first).all(|(own, other)| own.0 == other.0)
    };
    let differs = |part: usize| names.iter().any(|name| name[part].1 != first[part].1);
    if !names.iter().all(is_like_first) {
        return None;
    }
    let parts: Vec<usize> = (0..first.len()).filter(|part| differs(*part)).collect();
    let [part] = parts[..] else { return None };
    let numbers: Vec<u128> = names.iter().map(|name| name[part].1).collect::<Option<_>>()?;
    let steps: Vec<u128> = numbers.windows(2).map(|pair| pair[1].saturating_sub(pair[0])).collect();
    let step = steps.iter().copied().min().filter(|step| *step > 0)?;
    // Numbers without a step are no count of slices.
    let even = steps.iter().filter(|own| **own == step).count();
    if 2 * even <= steps.len() || steps.iter().any(|own| own % step != 0) {
        return None;
    }
    let missing: Vec<String> = numbers
        .windows(2)
        .filter(|pair| pair[1] - pair[0] > step)
        .map(|pair| match (pair[0] + step, pair[1] - step) {
            (from, to) if from == to => from.to_string(),
            (from, to) => format!("{from} to {to}"),
        })
        .collect();
    let more = if missing.len() > LISTED { " and more" } else { "" };
    (!missing.is_empty()).then(|| {
        format!(
            "by their names, pictures are missing: {}{more}; those around a gap lie side by side",
            missing[..missing.len().min(LISTED)].join(", ")
        )
    })
}

fn damaged(path: &Path, problem: &str) -> ImportError {
    ImportError::Damaged { path: path.to_owned(), problem: problem.to_owned() }
}

/// Decodes pictures by number.
trait Source: Send + Sync {
    /// The samples of picture `index`, little endian, into `out`, which is as long as they are.
    fn decode(&self, index: usize, out: &mut [u8]) -> Result<(), ImportError>;
    /// The file that holds it.
    fn path(&self, index: usize) -> &Path;
}

/// Pictures that are the slices of a volume.
struct Stack {
    source: Arc<dyn Source>,
    /// Which picture each slice is.
    pages: Vec<usize>,
    shape: Shape,
}

impl Stack {
    fn samples(self, files: Vec<PathBuf>) -> Samples {
        let Shape { sample, channels, .. } = self.shape;
        Samples::Planes { planes: Box::new(self), sample, channels, files }
    }
}

impl Planes for Stack {
    fn plane(&self, index: usize, cancel: &CancelToken) -> Result<Vec<u8>, ImportError> {
        cancel.check()?;
        let page = self.pages[index];
        let path = self.source.path(page);
        let bytes = self.shape.bytes().unwrap_or(0);
        let mut out = Vec::new();
        if out.try_reserve_exact(bytes).is_err() {
            return Err(damaged(path, "promises more than memory has"));
        }
        out.resize(bytes, 0);
        // No decoder is known to panic; if one does, it costs the file and not the program.
        let decoded =
            std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| self.source.decode(page, &mut out)));
        decoded.unwrap_or_else(|_| Err(damaged(path, "has a picture that its decoder gave up on")))?;
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use lumivox_core::{Progress, glam::DVec3};

    use super::*;
    use crate::Imported;

    fn load(single: Single) -> Imported {
        single.load(None, &crate::values::Told::default(), Progress::SILENT, &CancelToken::new()).unwrap()
    }

    fn values(imported: &Imported) -> Vec<f64> {
        let volume = &imported.volume;
        (0..volume.voxel_count())
            .map(|i| volume.voxels().get(i) * volume.slope() + volume.intercept())
            .collect()
    }

    fn write_png(path: &Path, color: ::png::ColorType, depth: ::png::BitDepth, width: u32, data: &[u8]) {
        let mut encoder = ::png::Encoder::new(std::fs::File::create(path).unwrap(), width, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(data).unwrap();
    }

    fn slices(paths: &[PathBuf], options: &ImportOptions) -> Result<Option<Single>, ImportError> {
        open_slices(paths, options, &CancelToken::new())
    }

    #[test]
    fn png_slices_follow_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let mut paths = Vec::new();
        for k in [10u16, 9, 1] {
            let path = folder.path().join(format!("slice{k}.png"));
            let data: Vec<u8> = [256 * k, 7].iter().flat_map(|n| n.to_be_bytes()).collect();
            write_png(&path, ::png::ColorType::Grayscale, ::png::BitDepth::Sixteen, 2, &data);
            paths.push(path);
        }
        let mut options = ImportOptions::default();
        let imported = load(slices(&paths, &options).unwrap().unwrap());
        assert_eq!((imported.volume.dims(), imported.report.series[0].files), ([2, 1, 3], 3));
        assert_eq!(values(&imported), [256.0, 7.0, 2304.0, 7.0, 2560.0, 7.0]);
        assert!(imported.report.notes.iter().any(|note| note.contains("taken as 1 mm")));
        options.spacing_mm = Some([0.1, 0.2, 0.5]);
        let imported = load(slices(&paths, &options).unwrap().unwrap());
        assert_eq!(imported.volume.spacing_mm(), DVec3::new(0.1, 0.2, 0.5));

        // Colours, by their luminance.
        for path in &paths {
            write_png(path, ::png::ColorType::Rgb, ::png::BitDepth::Eight, 1, &[0, 255, 0]);
        }
        let imported = load(slices(&paths, &options).unwrap().unwrap());
        assert_eq!(values(&imported), [182.0; 3]);
        assert!(imported.report.notes.iter().any(|note| note.contains("luminance")));

        write_png(&paths[1], ::png::ColorType::Rgb, ::png::BitDepth::Eight, 2, &[0; 6]);
        let error = slices(&paths, &options).err().unwrap().to_string();
        assert!(error.contains("slice9.png") && error.contains("where the first has 1 x 1"), "{error}");
        // The one that is unlike the others is named, be it the first.
        write_png(&paths[1], ::png::ColorType::Rgb, ::png::BitDepth::Eight, 1, &[0; 3]);
        write_png(&paths[2], ::png::ColorType::Rgb, ::png::BitDepth::Eight, 2, &[0; 6]);
        let error = slices(&paths, &options).err().unwrap().to_string();
        assert!(error.contains("slice1.png") && error.contains("Move it elsewhere"), "{error}");
        std::fs::write(&paths[1], "text, nothing else").unwrap();
        assert!(slices(&paths, &options).unwrap().is_none());
        let error = beside_others(folder.path(), &paths).unwrap().to_string();
        assert!(error.contains("2 pictures (PNG or TIFF) among 3 files"), "{error}");
        assert!(beside_others(folder.path(), &paths[..1]).is_none());
    }

    fn tiff(path: &Path, description: &str, pages: &[[u16; 2]]) {
        tiff_with(path, description, None, pages);
    }

    /// With so many pixels in a unit of length.
    fn tiff_with(path: &Path, description: &str, pixels: Option<[u32; 2]>, pages: &[[u16; 2]]) {
        use ::tiff::{
            encoder::{Rational, TiffEncoder, colortype::Gray16},
            tags::{ResolutionUnit, Tag},
        };
        let mut encoder = TiffEncoder::new(std::fs::File::create(path).unwrap()).unwrap();
        for page in pages {
            let mut image = encoder.new_image::<Gray16>(2, 1).unwrap();
            if let Some([n, d]) = pixels {
                image.resolution(ResolutionUnit::None, Rational { n, d });
            }
            if !description.is_empty() {
                image.encoder().write_tag(Tag::ImageDescription, description).unwrap();
            }
            image.write_data(page).unwrap();
        }
        // The encoder writes ASCII only, and other programs do not.
        let mut bytes = std::fs::read(path).unwrap();
        while let Some(at) = bytes.windows(3).position(|three| three == b"QQm") {
            bytes[at..at + 2].copy_from_slice("µ".as_bytes());
        }
        std::fs::write(path, bytes).unwrap();
    }

    #[test]
    fn pages_of_a_tiff_are_slices_channels_and_moments() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("stack.tif");
        let pages: Vec<[u16; 2]> = (0..8).map(|k| [k, 100 + k]).collect();
        let open = |description: &str| {
            tiff(&path, description, &pages);
            open_tiff(&path, &ImportOptions::default(), &CancelToken::new())
        };
        let plain = open("").unwrap();
        assert_eq!((plain.len(), plain[0].dims, plain[0].phases), (1, [2, 1, 8], 1));
        let ome = "<?xml version=\"1.0\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\"><Image ID=\"Image:0\">\
                   <Pixels DimensionOrder=\"XYCZT\" SizeX=\"2\" SizeY=\"1\" SizeZ=\"2\" SizeC=\"2\" SizeT=\"2\" Type=\"uint16\" \
                   PhysicalSizeX=\"0.5\" PhysicalSizeY=\"0.5\" PhysicalSizeZ=\"2\" PhysicalSizeZUnit=\"QQm\"/></Image></OME>";
        let mut channels = open(ome).unwrap();
        assert_eq!((channels.len(), channels[0].dims, channels[0].phases), (2, [2, 1, 2], 2));
        let second = load(channels.remove(1));
        assert_eq!(values(&second), [1.0, 101.0, 3.0, 103.0]);
        assert!(second.volume.spacing_mm().distance(DVec3::new(5e-4, 5e-4, 2e-3)) < 1e-12);
        let imagej =
            "ImageJ=1.53t\nimages=8\nchannels=2\nslices=4\nhyperstack=true\nunit=micron\nspacing=3.0\n";
        let mut channels = open(imagej).unwrap();
        assert_eq!((channels.len(), channels[0].dims, channels[0].phases), (2, [2, 1, 4], 1));
        assert_eq!(values(&load(channels.remove(0))), [0.0, 100.0, 2.0, 102.0, 4.0, 104.0, 6.0, 106.0]);
        for (description, words) in [
            (ome.replace("SizeZ=\"2\"", "SizeZ=\"3\""), "other files"),
            (
                imagej
                    .replace("images=8", "images=9")
                    .replace("slices=4", "slices=9")
                    .replace("channels=2", "channels=1"),
                "ImageJ",
            ),
        ] {
            let error = open(&description).err().unwrap().to_string();
            assert!(error.contains(words), "{error}");
        }
    }

    #[test]
    fn distances_of_imagej_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("stack.tif");
        let pages: Vec<[u16; 2]> = (0..4).map(|k| [k, 100 + k]).collect();
        let open = |unit: &str, pixels| {
            let description = format!("ImageJ=1.53t\nimages=4\nslices=4\nunit={unit}\nspacing=0.3\n");
            tiff_with(&path, &description, Some(pixels), &pages);
            load(open_tiff(&path, &ImportOptions::default(), &CancelToken::new()).unwrap().remove(0))
        };
        let is_near = |a: DVec3, b: [f64; 3]| (a / DVec3::from_array(b) - 1.0).abs().max_element() < 1e-9;
        let micron = open("micron", [10, 1]);
        assert!(is_near(micron.volume.spacing_mm(), [1e-4, 1e-4, 3e-4]), "{}", micron.volume.spacing_mm());
        let mm = open("mm", [3, 2]);
        assert!(is_near(mm.volume.spacing_mm(), [2.0 / 3.0, 2.0 / 3.0, 0.3]), "{}", mm.volume.spacing_mm());
        // Without a unit the proportions are left.
        let pixel = open("pixel", [1, 1]);
        assert!(is_near(pixel.volume.spacing_mm(), [1.0, 1.0, 0.3]), "{}", pixel.volume.spacing_mm());
        let notes = &pixel.report.notes;
        assert!(notes.iter().any(|note| note.contains("1 x 1 x 0.3, have no known unit")), "{notes:?}");
        assert!(!notes.iter().any(|note| note.contains("1 mm")), "{notes:?}");
    }

    #[test]
    fn slices_of_tiff_and_what_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let paths: Vec<PathBuf> = (0..3).map(|k| folder.path().join(format!("{k}.tiff"))).collect();
        for (k, path) in (0..).zip(&paths) {
            tiff(path, "", &[[k, 5]]);
        }
        let options = ImportOptions::default();
        assert_eq!(values(&load(slices(&paths, &options).unwrap().unwrap())), [0.0, 5.0, 1.0, 5.0, 2.0, 5.0]);
        let one = open_tiff(&paths[0], &options, &CancelToken::new()).err().unwrap().to_string();
        assert!(one.contains("Open the folder"), "{one}");
        // Cut anywhere, it is read or refused in words.
        let whole = std::fs::read(&paths[1]).unwrap();
        for end in 0..whole.len() {
            std::fs::write(&paths[1], &whole[..end]).unwrap();
            if let Ok(Some(single)) = slices(&paths, &options) {
                let _ =
                    single.load(None, &crate::values::Told::default(), Progress::SILENT, &CancelToken::new());
            }
        }
    }

    #[test]
    fn pictures_that_are_missing_are_named() {
        let of = |numbers: &[u32]| {
            let paths: Vec<PathBuf> =
                numbers.iter().map(|k| PathBuf::from(format!("s1/img{k:02}.png"))).collect();
            gaps(&paths)
        };
        assert!(of(&[1, 2, 3, 4, 5, 9, 10, 11]).unwrap().contains("missing: 6 to 8;"));
        assert!(of(&[10, 20, 30, 40, 60]).unwrap().contains("missing: 50;"));
        assert_eq!(of(&[4, 5, 6]), None);
        assert_eq!(of(&[2, 4, 6]), None);
        assert_eq!(of(&[1, 17, 4711]), None, "no count");
        assert_eq!(gaps(&["a.png", "b2.png", "b9.png"].map(PathBuf::from)), None);
    }

    #[test]
    fn names_are_in_the_order_of_their_numbers() {
        let mut names = ["b2", "a10", "a9", "A1", "a9b", "a"];
        names.sort_by_cached_key(|name| natural(name));
        assert_eq!(names, ["a", "A1", "a9", "a9b", "a10", "b2"]);
    }
}
