//! Panoramas of light in files: Radiance `.hdr` and OpenEXR `.exr` to an [`EnvironmentMap`].
//!
//! The picture is equirectangular: twice as wide as it is high, straight up at the top. Negative radiance, which
//! resampling leaves behind, becomes 0; an infinite one, as half floats make of the sun, the largest of the map.

use std::{
    io::BufReader,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

use lumivox_core::EnvironmentMap;

use crate::{
    error::ImportError,
    files::File,
    panorama::{WIDEST, check_size, damaged},
    payload::fill,
    radiance, source,
};

/// Loads a panorama of light, by its content.
///
/// # Errors
/// [`ImportError`] when the file cannot be read, is of another kind or damaged, or is not twice as wide as high.
pub fn load_environment(path: &Path) -> Result<EnvironmentMap, ImportError> {
    let mut head = [0; 10];
    let mut file = BufReader::new(File::open(path).map_err(ImportError::io(path))?);
    let n = fill(&mut file, &mut head).map_err(ImportError::io(path))?;
    file.seek_relative(-(n as i64)).map_err(ImportError::io(path))?;
    let (width, height, mut texels) = match &head[..n] {
        [b'#', b'?', ..] => radiance::read(path, file)?,
        [0x76, 0x2f, 0x31, 0x01, ..] => read_exr(path)?,
        _ => {
            return Err(ImportError::Unsupported {
                path: path.to_owned(),
                what: "this is neither a Radiance HDR nor an OpenEXR image".to_owned(),
                remedy: "Light needs a high dynamic range panorama: a .hdr or .exr file".to_owned(),
            });
        }
    };
    sanitize(path, width, &mut texels)?;
    EnvironmentMap::new(width, height, texels)
        .map(|map| map.with_file(&source::whole(path)))
        .map_err(|problem| damaged(path, "the texels", format!("are wrong: {problem}")))
}

/// Writes a panorama as OpenEXR, from which [`load_environment`] gets every texel back to the bit. A file that is there is
/// replaced only when the new one is whole.
///
/// # Errors
/// [`ImportError`] when the map is no panorama, not twice as wide as high, or the file cannot be written.
pub fn save_environment(path: &Path, map: &EnvironmentMap) -> Result<(), ImportError> {
    check_size(path, map.width, map.height)?;
    let aside = path.with_extension(format!("{}.part", std::process::id()));
    let texel = |x: usize, y: usize| {
        let [r, g, b] = map.texels[y * map.width + x];
        (r, g, b)
    };
    let written = match exr::prelude::write_rgb_file(&aside, map.width, map.height, texel) {
        Ok(()) => std::fs::rename(&aside, path),
        Err(exr::error::Error::Io(error)) => Err(error),
        Err(other) => Err(std::io::Error::other(other.to_string())),
    };
    written.map_err(|error| {
        let _ = std::fs::remove_file(&aside);
        ImportError::io(path)(error)
    })
}

/// Makes every texel a radiance.
fn sanitize(path: &Path, width: usize, texels: &mut [[f32; 3]]) -> Result<(), ImportError> {
    if let Some(i) = texels.iter().position(|t| t.iter().any(|c| c.is_nan())) {
        let problem = format!("at ({}, {}) is not a number", i % width, i / width);
        return Err(damaged(path, "the texel", problem));
    }
    let components = || texels.iter().flatten().copied();
    let largest = components().filter(|c| c.is_finite()).fold(0.0, f32::max);
    for component in texels.iter_mut().flatten() {
        *component = component.clamp(0.0, largest);
    }
    Ok(())
}

fn read_exr(path: &Path) -> Result<(usize, usize, Vec<[f32; 3]>), ImportError> {
    // The decoder meets strangers' bytes: should it panic, that is one damaged file and not the end of the program.
    match catch_unwind(AssertUnwindSafe(|| decode_exr(path))) {
        Ok(result) => result,
        Err(_) => Err(damaged(path, "the OpenEXR image", "is damaged".to_owned())),
    }
}

/// A frame of `width * height` texels that a smaller picture is put into.
struct Frame {
    width: usize,
    height: usize,
    /// Where the picture begins.
    left: i64,
    top: i64,
    texels: Vec<[f32; 3]>,
}

fn decode_exr(path: &Path) -> Result<(usize, usize, Vec<[f32; 3]>), ImportError> {
    use exr::prelude::{MetaData, ReadChannels as _, ReadLayers as _, Vec2};

    let wrong = |error: exr::error::Error| match error {
        exr::error::Error::Io(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
            ImportError::Io { path: path.to_owned(), source }
        }
        exr::error::Error::NotSupported(what) => ImportError::Unsupported {
            path: path.to_owned(),
            what: format!("an OpenEXR image that cannot be read ({what})"),
            remedy: "Save it with channels R, G and B and ZIP compression".to_owned(),
        },
        other => damaged(path, "the OpenEXR image", format!("is damaged or lacks R, G and B ({other})")),
    };
    // The sizes are checked before anything is made room for.
    let meta = MetaData::read_from_file(path, false).map_err(wrong)?;
    for header in &meta.headers {
        let window = header.shared_attributes.display_window.size;
        check_size(path, window.width(), window.height())?;
        if header.layer_size.width() > WIDEST || header.layer_size.height() > WIDEST {
            return Err(damaged(path, "dataWindow", "is larger than any panorama".to_owned()));
        }
    }
    let display = meta.headers.first().map(|h| h.shared_attributes.display_window);
    let Some(display) = display else {
        return Err(damaged(path, "the OpenEXR image", "has no layer".to_owned()));
    };
    let position = meta.headers.first().map_or(Vec2(0, 0), |h| h.own_attributes.layer_position);
    let (width, height) = (display.size.width(), display.size.height());
    let (left, top) = (
        i64::from(position.x()) - i64::from(display.position.x()),
        i64::from(position.y()) - i64::from(display.position.y()),
    );
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |_, _| Frame { width, height, left, top, texels: vec![[0.0; 3]; width * height] },
            |frame, position, (r, g, b, _): (f32, f32, f32, f32)| {
                let (x, y) = (position.x() as i64 + frame.left, position.y() as i64 + frame.top);
                let inside = (0..frame.width as i64).contains(&x) && (0..frame.height as i64).contains(&y);
                if inside {
                    frame.texels[y as usize * frame.width + x as usize] = [r, g, b];
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_file(path)
        .map_err(wrong)?;
    let frame = image.layer_data.channel_data.pixels;
    Ok((frame.width, frame.height, frame.texels))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(path: &Path) -> String {
        load_environment(path).unwrap_err().to_string()
    }

    #[test]
    fn exr_keeps_its_texels_and_their_places() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("light.exr");
        exr::prelude::write_rgb_file(&path, 8, 4, |x, y| {
            (x as f32, y as f32, if x == 0 { -1.0 } else { 1e9 })
        })
        .unwrap();
        let map = load_environment(&path).unwrap();
        assert_eq!((map.width, map.height), (8, 4));
        assert_eq!(map.texels[2 * 8 + 5], [5.0, 2.0, 1e9]);
        assert_eq!(map.texels[3 * 8], [0.0, 3.0, 0.0], "negative light is none");
    }

    #[test]
    fn a_panorama_comes_back_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("light.exr");
        let texels = (0..128u16).map(|i| [f32::from(i) / 3.0, 1e-30, 65_000.5 * f32::from(i)]).collect();
        let map = EnvironmentMap::new(16, 8, texels).unwrap();
        save_environment(&path, &map).unwrap();
        assert_eq!(load_environment(&path).unwrap(), map.with_file(&path));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside it");
        let square = EnvironmentMap::new(2, 2, vec![[1.0; 3]; 4]).unwrap();
        assert!(save_environment(&path, &square).unwrap_err().to_string().contains("twice as wide"));
        let nowhere = folder.path().join("none/light.exr");
        assert!(save_environment(&nowhere, &map_of_one()).is_err());
    }

    fn map_of_one() -> EnvironmentMap {
        EnvironmentMap::new(2, 1, vec![[1.0; 3]; 2]).unwrap()
    }

    #[test]
    fn damaged_exr_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("light.exr");
        exr::prelude::write_rgb_file(&path, 32, 16, |x, y| (x as f32, y as f32, 0.5f32)).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for length in (0..whole.len()).step_by(7) {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(load_environment(&path).is_err(), "cut to {length}");
        }
        // Any byte may be wrong: an error or another picture, but no panic and no hang.
        for i in 0..whole.len().min(500) {
            let mut bytes = whole.clone();
            bytes[i] ^= 0xff;
            std::fs::write(&path, &bytes).unwrap();
            let _ = load_environment(&path);
        }
    }

    #[test]
    fn what_is_no_panorama_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("light.exr");
        exr::prelude::write_rgb_file(&path, 4, 4, |_, _| (1.0f32, 1.0f32, 1.0f32)).unwrap();
        assert!(message(&path).contains("not twice as wide as high"));
        exr::prelude::write_rgb_file(&path, 4, 2, |x, _| {
            (1.0f32, if x == 2 { f32::NAN } else { 1.0 }, 1.0f32)
        })
        .unwrap();
        assert!(message(&path).contains("texel at (2, 0) is not a number"));
        std::fs::write(&path, b"\x89PNG").unwrap();
        assert!(message(&path).contains("neither a Radiance HDR nor an OpenEXR"));
        std::fs::write(&path, b"").unwrap();
        assert!(message(&path).contains("neither"));
    }

    #[test]
    fn an_infinite_sun_becomes_the_brightest_of_the_others() {
        let mut texels = vec![[1.0, f32::INFINITY, 7.0], [-0.5, 2.0, f32::NEG_INFINITY]];
        sanitize(Path::new("x"), 2, &mut texels).unwrap();
        assert_eq!(texels, [[1.0, 7.0, 7.0], [0.0, 2.0, 0.0]]);
    }
}
