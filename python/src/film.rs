//! Films: sums over samples as arrays, and their way to pixels.

use lumivox_core::PerspectiveCamera;
use lumivox_renderer::display::put_on;
use lumivox_renderer::{self as renderer, Background, DisplaySettings, ToneMap};
use numpy::{PyArray1, PyArray2, PyArray3, PyArray4, PyArrayMethods, PyReadonlyArray4};
use pyo3::prelude::*;

use crate::description::{Camera, Scene};
use crate::errors;
use crate::fork;

/// What samples add up to, and nothing else: see the renderer's `Film`.
#[pyclass(frozen, module = "lumivox._native")]
pub struct Film(pub renderer::Film);

type Layer<'py> = PyResult<Bound<'py, PyArray3<f32>>>;
type Plane<'py> = PyResult<Bound<'py, PyArray2<f32>>>;

impl Film {
    fn shape(&self) -> [usize; 2] {
        let [width, height] = self.0.size();
        [height as usize, width as usize]
    }

    fn count(&self) -> usize {
        let [height, width] = self.shape();
        height * width
    }

    /// One number for each pixel.
    fn plane<'py>(&self, py: Python<'py>, of: impl Fn(usize) -> f64 + Sync + Send) -> Plane<'py> {
        let values: Vec<f32> = fork::detach(py, || (0..self.count()).map(|pixel| of(pixel) as f32).collect());
        PyArray1::from_vec(py, values).reshape(self.shape())
    }

    /// Three numbers for each pixel.
    fn layer<'py>(&self, py: Python<'py>, of: impl Fn(usize) -> [f64; 3] + Sync + Send) -> Layer<'py> {
        let values: Vec<f32> =
            fork::detach(py, || (0..self.count()).flat_map(|pixel| of(pixel).map(|x| x as f32)).collect());
        let [height, width] = self.shape();
        PyArray1::from_vec(py, values).reshape([height, width, 3])
    }
}

#[pymethods]
impl Film {
    /// From sums (planes, rows, columns, 4), of 2 planes, or 4 with guides.
    #[new]
    fn new(py: Python<'_>, sums: PyReadonlyArray4<'_, f32>) -> PyResult<Self> {
        let &[planes, height, width, 4] = sums.as_array().shape() else {
            return Err(errors::value("a film's sums must be (planes, rows, columns, 4)"));
        };
        let flat = sums.as_slice().map_err(|_| errors::value("the array is not contiguous"))?;
        let pixels = height * width;
        let planes: Vec<Vec<[f32; 4]>> = fork::detach(py, || {
            (0..planes)
                .map(|plane| bytemuck::cast_slice(&flat[plane * pixels * 4..][..pixels * 4]).to_vec())
                .collect()
        });
        let film = renderer::Film::from_planes(width as u32, height as u32, planes);
        film.map(Self).ok_or_else(|| errors::value("a film has 2 planes, or 4 with guides"))
    }

    /// The sums (planes, rows, columns, 4): radiance and alpha; depth, squared luminance, samples, 0; albedo; normal.
    fn sums<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray4<f32>>> {
        let planes = self.0.planes();
        let flat: Vec<f32> = fork::detach(py, || planes.concat().into_flattened());
        let [height, width] = self.shape();
        PyArray1::from_vec(py, flat).reshape([planes.len(), height, width, 4])
    }

    /// Columns and rows.
    #[getter]
    fn size(&self) -> [u32; 2] {
        self.0.size()
    }

    #[getter]
    fn has_guides(&self) -> bool {
        self.0.has_guides()
    }

    #[getter]
    fn min_samples(&self) -> u32 {
        self.0.min_samples()
    }

    #[getter]
    fn noise(&self) -> Option<f64> {
        self.0.noise()
    }

    fn samples<'py>(&self, py: Python<'py>) -> Plane<'py> {
        self.plane(py, |pixel| f64::from(self.0.samples(pixel)))
    }

    fn radiance<'py>(&self, py: Python<'py>) -> Layer<'py> {
        self.layer(py, |pixel| self.0.radiance(pixel))
    }

    fn alpha<'py>(&self, py: Python<'py>) -> Plane<'py> {
        self.plane(py, |pixel| self.0.alpha(pixel))
    }

    /// In world metres.
    fn depth<'py>(&self, py: Python<'py>) -> Plane<'py> {
        self.plane(py, |pixel| self.0.depth(pixel))
    }

    fn variance<'py>(&self, py: Python<'py>) -> Plane<'py> {
        self.plane(py, |pixel| self.0.luminance(pixel).1)
    }

    fn albedo<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray3<f32>>>> {
        let there = self.0.has_guides();
        there.then(|| self.layer(py, |pixel| self.0.albedo(pixel).unwrap_or_default())).transpose()
    }

    fn normal<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray3<f32>>>> {
        let there = self.0.has_guides();
        there.then(|| self.layer(py, |pixel| self.0.normal(pixel).unwrap_or_default())).transpose()
    }

    /// The film with less noise, for a little bias.
    fn denoised(&self, py: Python<'_>) -> Self {
        Self(fork::detach(py, || self.0.denoised()))
    }

    /// Displayable pixels (rows, columns, 4): red, green, blue and straight alpha, 8 bits each.
    #[allow(clippy::too_many_arguments, reason = "what the command asks for, one by one")]
    fn pixels<'py>(
        &self,
        py: Python<'py>,
        scene: Scene,
        camera: Camera,
        background: &str,
        exposure: f64,
        tone: &str,
        gamma: f64,
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let (kind, color) = background_of(background)?;
        let tone_map = match tone {
            "agx" => ToneMap::Agx,
            "aces" => ToneMap::Aces,
            "plain" => ToneMap::Plain,
            other => return Err(errors::value(format!("tone '{other}' is not 'agx', 'aces' or 'plain'"))),
        };
        let settings = DisplaySettings { background: kind, exposure_ev: exposure, tone_map, gamma };
        let (environment, camera): (_, PerspectiveCamera) = (scene.environment()?, camera.build());
        let rgba = fork::detach(py, || {
            let mut rgba = settings.pixels(&self.0, &environment, &camera).into_flattened();
            if let Some(color) = color {
                put_on(&mut rgba, color);
            }
            rgba
        });
        let [height, width] = self.shape();
        PyArray1::from_vec(py, rgba).reshape([height, width, 4])
    }
}

/// What stands behind, and the colour that is put behind the finished picture, as the command does it.
fn background_of(word: &str) -> PyResult<(Background, Option<[u8; 3]>)> {
    match word {
        "transparent" => return Ok((Background::Transparent, None)),
        "environment" => return Ok((Background::Environment, None)),
        _ => {}
    }
    word.strip_prefix('#')
        .filter(|hex| hex.len() == 6 && hex.bytes().all(|b| b.is_ascii_hexdigit()))
        .and_then(|hex| u32::from_str_radix(hex, 16).ok())
        .map(|rgb| (Background::Transparent, Some([(rgb >> 16) as u8, (rgb >> 8) as u8, rgb as u8])))
        .ok_or_else(|| {
            errors::value("background must be transparent, environment or a colour such as #202428")
        })
}
