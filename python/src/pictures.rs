//! Files of pictures, as bytes.

use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage, f16,
};
use numpy::{PyArrayLike2, PyArrayLike3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::ending;
use crate::errors;

/// 8-bit pixels (rows, columns, 4) as a PNG: without alpha where all of it is opaque.
#[pyfunction]
pub fn encode_png<'py>(py: Python<'py>, rgba: PyArrayLike3<'py, u8>) -> PyResult<Bound<'py, PyBytes>> {
    let &[height, width, 4] = rgba.shape() else {
        return Err(errors::value("pixels must be (rows, columns, 4)"));
    };
    let pixels: Vec<u8> = rgba.as_array().iter().copied().collect();
    let bytes =
        ending::detach(py, || png_bytes(&pixels, width as u32, height as u32)).map_err(errors::value)?;
    Ok(PyBytes::new(py, &bytes))
}

fn png_bytes(rgba: &[u8], width: u32, height: u32) -> Result<Vec<u8>, png::EncodingError> {
    let opaque = rgba.chunks_exact(4).all(|pixel| pixel[3] == 255);
    let mut bytes = vec![];
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(if opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    if opaque {
        let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
        writer.write_image_data(&rgb)?;
    } else {
        writer.write_image_data(rgba)?;
    }
    writer.finish()?;
    Ok(bytes)
}

/// Named channels (rows, columns) of 32-bit floats as an OpenEXR file; those in `half` are kept in 16 bits.
#[pyfunction]
pub fn encode_exr<'py>(
    py: Python<'py>,
    channels: Vec<(String, PyArrayLike2<'py, f32>)>,
    half: bool,
) -> PyResult<Bound<'py, PyBytes>> {
    let size = channels.first().map_or([0, 0], |(_, plane)| [plane.shape()[0], plane.shape()[1]]);
    let mut list = vec![];
    for (name, plane) in &channels {
        if plane.shape() != size {
            return Err(errors::value("all channels must have one shape"));
        }
        let values = plane.as_array();
        let samples = match half {
            true => FlatSamples::F16(values.iter().map(|&value| f16::from_f32(value)).collect()),
            false => FlatSamples::F32(values.iter().copied().collect()),
        };
        list.push(AnyChannel::new(name.as_str(), samples));
    }
    let bytes = ending::detach(py, || {
        let layer = Layer::new(
            (size[1], size[0]),
            LayerAttributes::default(),
            Encoding::FAST_LOSSLESS,
            AnyChannels::sort(list.into()),
        );
        let mut bytes = Cursor::new(vec![]);
        Image::from_layer(layer).write().to_buffered(&mut bytes).map(|()| bytes.into_inner())
    });
    Ok(PyBytes::new(py, &bytes.map_err(errors::value)?))
}
