//! Radiance's picture format (`.hdr`, `.pic`): shared exponents, run lengths, and the exposure of the header.
//!
//! After Greg Ward, "Real Pixels", Graphics Gems II, 1991, and Radiance's `color.c`.

use std::{
    io::{BufRead, Read},
    path::Path,
};

use crate::{
    error::ImportError,
    panorama::{check_size, damaged},
    payload::fill,
};

/// No header is longer.
const LONGEST_HEADER: u64 = 1 << 16;

/// Linear sRGB from CIE XYZ (with white at 1, 1, 1 as Radiance has it).
const RGB_FROM_XYZ: [[f32; 3]; 3] = [[2.690, -1.276, -0.414], [-1.022, 1.978, 0.044], [0.061, -0.224, 1.163]];

/// What a header says.
struct Header {
    width: usize,
    height: usize,
    /// Whether rows run from the bottom, and columns from the right.
    upwards: bool,
    leftwards: bool,
    /// What pixels must be divided by to be radiance.
    exposure: f32,
    xyz: bool,
}

/// Reads width, height and linear RGB texels, rows from the top.
pub(crate) fn read(
    path: &Path,
    mut input: impl BufRead,
) -> Result<(usize, usize, Vec<[f32; 3]>), ImportError> {
    let header = read_header(path, &mut input)?;
    let Header { width, height, .. } = header;
    let mut texels = Vec::new();
    let mut line = vec![[0u8; 4]; width];
    for row in 0..height {
        let complete = read_line(&mut input, &mut line).map_err(ImportError::io(path))?;
        if !complete {
            let problem = format!("ends or is damaged in line {} of {height}", row + 1);
            return Err(damaged(path, "the image data", problem));
        }
        texels.extend(line.iter().map(|pixel| header.texel(*pixel)));
    }
    if header.leftwards {
        texels.chunks_exact_mut(width).for_each(<[_]>::reverse);
    }
    if header.upwards {
        for row in 0..height / 2 {
            let (top, bottom) = texels.split_at_mut((height - 1 - row) * width);
            top[row * width..(row + 1) * width].swap_with_slice(&mut bottom[..width]);
        }
    }
    Ok((width, height, texels))
}

impl Header {
    fn texel(&self, [r, g, b, e]: [u8; 4]) -> [f32; 3] {
        if e == 0 {
            return [0.0; 3];
        }
        let scale = (f32::from(e) - 136.0).exp2() / self.exposure;
        let color = [r, g, b].map(|c| f32::from(c) * scale);
        if self.xyz {
            RGB_FROM_XYZ.map(|row| row[0] * color[0] + row[1] * color[1] + row[2] * color[2])
        } else {
            color
        }
    }
}

fn read_header(path: &Path, input: &mut impl BufRead) -> Result<Header, ImportError> {
    let mut left = LONGEST_HEADER;
    let mut next_line = || -> Result<String, ImportError> {
        let mut line = Vec::new();
        let read = input.by_ref().take(left).read_until(b'\n', &mut line).map_err(ImportError::io(path))?;
        left -= read as u64;
        if line.pop() != Some(b'\n') {
            return Err(damaged(path, "the header", "does not end".to_owned()));
        }
        Ok(String::from_utf8_lossy(&line).trim_end_matches('\r').to_owned())
    };
    let (mut exposure, mut xyz) = (1.0f32, false);
    loop {
        let line = next_line()?;
        if line.is_empty() {
            break;
        }
        match line.split_once('=') {
            Some(("EXPOSURE", value)) => {
                let value: Option<f32> = value.trim().parse().ok();
                // It may be given several times: each program that scaled the pixels adds its own.
                exposure *= value
                    .filter(|v| v.is_normal() && *v > 0.0)
                    .ok_or_else(|| damaged(path, "EXPOSURE", "is not a positive number".to_owned()))?;
            }
            Some(("FORMAT", value)) => match value.trim() {
                "32-bit_rle_rgbe" => xyz = false,
                "32-bit_rle_xyze" => xyz = true,
                other => {
                    return Err(damaged(path, "FORMAT", format!("'{other}' is not known")));
                }
            },
            _ => {}
        }
    }
    if !exposure.is_normal() {
        return Err(damaged(path, "EXPOSURE", "is out of range".to_owned()));
    }
    let size = next_line()?;
    let words: Vec<&str> = size.split_whitespace().collect();
    let (upwards, leftwards, height, width) = match words[..] {
        [y @ ("-Y" | "+Y"), height, x @ ("+X" | "-X"), width] => (y == "+Y", x == "-X", height, width),
        ["-X" | "+X", _, "-Y" | "+Y", _] => {
            return Err(ImportError::Unsupported {
                path: path.to_owned(),
                what: format!("a Radiance image written column by column ({size})"),
                remedy: "Save it the usual way up".to_owned(),
            });
        }
        _ => return Err(damaged(path, "the image size", "is not given as -Y height +X width".to_owned())),
    };
    let number = |text: &str| {
        text.parse::<usize>().map_err(|_| damaged(path, "the image size", format!("'{text}' is no number")))
    };
    let (width, height) = (number(width)?, number(height)?);
    check_size(path, width, height)?;
    Ok(Header { width, height, upwards, leftwards, exposure, xyz })
}

/// Reads one line of pixels; `false` when the data ends or breaks the rules.
fn read_line(input: &mut impl BufRead, line: &mut [[u8; 4]]) -> std::io::Result<bool> {
    let width = line.len();
    let mut first = [0; 4];
    if fill(input, &mut first)? < 4 {
        return Ok(false);
    }
    // A marker that no normalised pixel looks like announces the newer run lengths.
    let newer = (8..=0x7fff).contains(&width) && first[..2] == [2, 2] && first[2] < 128;
    if !newer {
        return read_flat_or_old(input, first, line);
    }
    if usize::from(u16::from_be_bytes([first[2], first[3]])) != width {
        return Ok(false);
    }
    for component in [0, 1, 2, 3] {
        let mut x = 0;
        while x < width {
            let mut code = [0; 1];
            if fill(input, &mut code)? < 1 {
                return Ok(false);
            }
            let (run, mut bytes) =
                if code[0] > 128 { (code[0] - 128, [0; 128]) } else { (code[0], [0; 128]) };
            let count = usize::from(run);
            let distinct = if code[0] > 128 { 1 } else { count };
            if count == 0 || x + count > width || fill(input, &mut bytes[..distinct])? < distinct {
                return Ok(false);
            }
            for i in 0..count {
                line[x + i][component] = bytes[i.min(distinct - 1)];
            }
            x += count;
        }
    }
    Ok(true)
}

/// Pixels one after the other, or with the older run lengths: a pixel of mantissas 1, 1, 1 repeats the last one as
/// often as its exponent says, times 256 for each such pixel directly before.
fn read_flat_or_old(input: &mut impl BufRead, first: [u8; 4], line: &mut [[u8; 4]]) -> std::io::Result<bool> {
    let mut pixel = first;
    let (mut x, mut shift) = (0, 0);
    loop {
        if pixel[..3] == [1, 1, 1] {
            let count = usize::from(pixel[3]) << shift;
            if x == 0 || count > line.len() - x {
                return Ok(false);
            }
            let last = line[x - 1];
            line[x..x + count].fill(last);
            x += count;
            // A third one in a row would repeat more pixels than any line has.
            shift = (shift + 8).min(24);
        } else {
            line[x] = pixel;
            x += 1;
            shift = 0;
        }
        if x == line.len() {
            return Ok(true);
        }
        if fill(input, &mut pixel)? < 4 {
            return Ok(false);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\n";

    fn decode(header: &str, size: &str, data: &[u8]) -> Result<(usize, usize, Vec<[f32; 3]>), String> {
        let bytes = [header.as_bytes(), b"\n", size.as_bytes(), b"\n", data].concat();
        read(Path::new("light.hdr"), &bytes[..]).map_err(|e| e.to_string())
    }

    /// Mantissa 128 at exponent 129 is 1.
    const ONE: [u8; 4] = [128, 128, 128, 129];

    #[test]
    fn flat_pixels_have_their_values_and_places() {
        let data = [ONE, [255, 0, 128, 128], [0; 4], [64, 64, 64, 137]].concat();
        let (_, _, texels) = decode(HEADER, "-Y 1 +X 2", &data).unwrap();
        assert_eq!(texels, [[1.0; 3], [255.0 / 256.0, 0.0, 0.5]]);
        let data: Vec<u8> = (1..=8).flat_map(|m| [16 * m, 0, 0, 136]).collect();
        let reds = |size: &str| -> Vec<f32> {
            decode(HEADER, size, &data).unwrap().2.iter().map(|t| t[0] / 16.0).collect()
        };
        assert_eq!(reds("-Y 2 +X 4"), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        assert_eq!(reds("+Y 2 +X 4"), [5.0, 6.0, 7.0, 8.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(reds("-Y 2 -X 4"), [4.0, 3.0, 2.0, 1.0, 8.0, 7.0, 6.0, 5.0]);
    }

    #[test]
    fn old_runs_repeat_the_last_pixel() {
        let data = [ONE, [1, 1, 1, 3], [2, 0, 0, 136], [1, 1, 1, 3]].concat();
        let (_, _, texels) = decode(HEADER, "-Y 2 +X 4", &data).unwrap();
        assert_eq!(texels[..4], [[1.0; 3]; 4]);
        assert_eq!(texels[4..], [[2.0, 0.0, 0.0]; 4]);
        for bad in [[[1, 1, 1, 3], ONE], [ONE, [1, 1, 1, 200]]] {
            assert!(decode(HEADER, "-Y 2 +X 4", &bad.concat()).unwrap_err().contains("line 1 of 2"));
        }
    }

    #[test]
    fn new_runs_are_read_component_by_component() {
        let mut data = Vec::new();
        for _ in 0..4 {
            data.extend([2, 2, 0, 8]);
            data.extend([128 + 8, 64]); // red: a run
            data.extend([8, 1, 2, 3, 4, 5, 6, 7, 8]); // green: as they are
            data.extend([128 + 4, 0, 128 + 4, 9]); // blue: two runs
            data.extend([128 + 8, 136]);
        }
        let (_, _, texels) = decode(HEADER, "-Y 4 +X 8", &data).unwrap();
        assert_eq!(texels[8], [64.0, 1.0, 0.0]);
        assert_eq!(texels[15], [64.0, 8.0, 9.0]);
        for cut in 0..data.len() {
            assert!(decode(HEADER, "-Y 4 +X 8", &data[..cut]).is_err());
        }
        let mut long = data.clone();
        long[4] = 255;
        assert!(decode(HEADER, "-Y 4 +X 8", &long).is_err(), "a run beyond the line");
    }

    #[test]
    fn exposure_and_xyz_are_undone() {
        let exposed = "#?RADIANCE\nEXPOSURE=2\nEXPOSURE= 4\nFORMAT=32-bit_rle_rgbe\n";
        assert_eq!(decode(exposed, "-Y 1 +X 2", &[ONE, ONE].concat()).unwrap().2[0], [0.125; 3]);
        let xyz = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n";
        let white = decode(xyz, "-Y 1 +X 2", &[ONE, ONE].concat()).unwrap().2[0];
        assert!(white.iter().all(|c| (c - 1.0).abs() < 0.002), "{white:?}");
    }

    #[test]
    fn impossible_headers_are_refused() {
        let error = |header: &str, size: &str| decode(header, size, &[]).unwrap_err();
        assert!(error(HEADER, "-Y 1000000000 +X 2000000000").contains("at most"));
        assert!(error(HEADER, "-Y 0 +X 0").contains("0 x 0"));
        assert!(error(HEADER, "-Y x +X 2").contains("no number"));
        assert!(error(HEADER, "+X 4 -Y 2").contains("column by column"));
        assert!(error(HEADER, "hello").contains("not given"));
        assert!(error("#?RADIANCE\nEXPOSURE=0\n", "-Y 1 +X 2").contains("EXPOSURE"));
        assert!(error("#?RADIANCE\nFORMAT=jpeg\n", "-Y 1 +X 2").contains("'jpeg'"));
        assert!(read(Path::new("x"), &[b'#'; 1 << 18][..]).is_err());
        assert!(read(Path::new("x"), &b"#?RADIANCE\n"[..]).is_err());
    }
}
