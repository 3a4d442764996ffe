//! Scenes, cameras and requests as Python describes them: dataclasses of `lumivox.scene` and `lumivox.look`, read by the
//! names of their attributes. Lengths are millimetres and angles degrees, as on the command line.

use std::f64::consts::PI;
use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::Duration;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{
    self as core, Ease, Environment, EnvironmentMap, EnvironmentSource, ExtinctionSpace, Filter,
    GradientFunction, Lamp, Light, LightKind, MOST_CLIP_SHAPES, PerspectiveCamera, SurfaceReflection,
    VolumeInstance, document::View, framing, world_from_patient,
};
use lumivox_wgpu::RenderRequest;
use pyo3::prelude::*;

use crate::classification::{ClipShape, Named, Peel, Style, labelling};
use crate::errors;
use crate::fork;
use crate::looks;
use crate::volume::{Rows, Volume, affine, rows};

const METRES_PER_MM: f64 = 1e-3;

/// `lumivox.TransferFunction`.
#[derive(FromPyObject)]
pub struct TransferFunction {
    opacity: Vec<(f64, f64, String)>,
    color: Vec<(f64, [f64; 3])>,
    /// Gradients in units per mm, and what is for them.
    gradients: Vec<(f64, TransferFunction)>,
}

impl TransferFunction {
    /// Whether it has rows for gradients.
    pub fn has_gradients(&self) -> bool {
        !self.gradients.is_empty()
    }

    /// Its rows for gradients.
    pub fn rows(&self) -> PyResult<Vec<GradientFunction>> {
        let row = |(per_mm, row): &(f64, Self)| {
            Ok(GradientFunction { per_mm: *per_mm, transfer_function: row.build()? })
        };
        self.gradients.iter().map(row).collect()
    }

    /// A medium of the function alone.
    pub fn medium(&self) -> PyResult<core::Medium> {
        Ok(core::Medium { gradients: self.rows()?, ..core::Medium::new(self.build()?) }.sanitized())
    }

    /// The transfer function described, for where values do not change.
    pub fn build(&self) -> PyResult<core::TransferFunction> {
        let ease = |word: &str| match word {
            "linear" => Ok(Ease::Linear),
            "in-out" => Ok(Ease::InOut),
            other => Err(errors::value(format!("ease '{other}' is not 'linear' or 'in-out'"))),
        };
        let knots = (self.opacity.iter())
            .map(|(value, opacity, word)| {
                Ok(core::OpacityKnot { value: *value, opacity: *opacity, ease: ease(word)? })
            })
            .collect::<PyResult<_>>()?;
        let stops = self.color.iter().map(|&(value, color)| core::ColorStop { value, color }).collect();
        core::TransferFunction::new(knots, stops).map_err(errors::value)
    }
}

/// `lumivox.SurfaceReflection`.
#[derive(FromPyObject)]
pub struct Surface {
    strength: f64,
    gradient_per_mm: f64,
    roughness: f64,
    specular: f64,
}

impl Surface {
    /// The reflection described.
    pub fn build(&self) -> SurfaceReflection {
        let Self { strength, gradient_per_mm, roughness, specular } = *self;
        SurfaceReflection { strength, gradient_per_mm, roughness, specular }
    }
}

/// `lumivox.Medium`.
#[derive(FromPyObject)]
struct Medium {
    transfer_function: TransferFunction,
    density: f64,
    albedo: f64,
    anisotropy: f64,
    bounces: u32,
    filter: String,
    surface: Surface,
    extinction_space: String,
}

impl Medium {
    fn build(&self) -> PyResult<core::Medium> {
        let medium = core::Medium {
            transfer_function: self.transfer_function.build()?,
            gradients: self.transfer_function.rows()?,
            density_scale: self.density,
            albedo: self.albedo,
            anisotropy: self.anisotropy,
            max_bounces: self.bounces,
            filter: match self.filter.as_str() {
                "nearest" => Filter::Nearest,
                "trilinear" => Filter::Trilinear,
                "tricubic" => Filter::Tricubic,
                "smooth" => Filter::Smooth,
                other => {
                    let known = "'nearest', 'trilinear', 'tricubic' or 'smooth'";
                    return Err(errors::value(format!("filter '{other}' is not {known}")));
                }
            },
            surface: self.surface.build(),
            extinction_space: match self.extinction_space.as_str() {
                "volume" => ExtinctionSpace::Volume,
                "world" => ExtinctionSpace::World,
                other => {
                    return Err(errors::value(format!(
                        "extinction_space '{other}' is not 'volume' or 'world'"
                    )));
                }
            },
        };
        Ok(medium.sanitized())
    }
}

/// `lumivox.Volume`, of which the native half counts.
#[derive(FromPyObject)]
pub struct Wrapped {
    native: Py<Volume>,
}

impl Wrapped {
    /// The volume, shared.
    pub fn shared(&self) -> Arc<core::Volume> {
        self.native.get().shared()
    }
}

/// `lumivox.VolumeInstance`.
#[derive(FromPyObject)]
pub struct Instance {
    volume: Wrapped,
    medium: Medium,
    clip: ([f64; 3], [f64; 3]),
    world_from_patient: Option<Rows>,
    layers: u32,
    labels: Option<Named>,
    label_styles: Vec<(u8, Style)>,
    clip_shapes: Vec<ClipShape>,
    peel: Option<Peel>,
}

impl Instance {
    fn build(&self, usual: DAffine3) -> PyResult<VolumeInstance> {
        let (low, high) = self.clip;
        let world_from_patient = self.world_from_patient.map_or(usual, |rows| in_metres() * affine(rows));
        if self.clip_shapes.len() > MOST_CLIP_SHAPES {
            let given = self.clip_shapes.len();
            return Err(errors::value(format!(
                "clip_shapes are {given}, of which {MOST_CLIP_SHAPES} are possible"
            )));
        }
        let labels = self.labels.as_ref().map(|labels| labelling(labels, &self.label_styles)).transpose()?;
        let shapes = self.clip_shapes.iter().map(|shape| shape.build(world_from_patient));
        Ok(VolumeInstance {
            clip_box: [DVec3::from_array(low), DVec3::from_array(high)],
            layers: self.layers,
            labels,
            peel: self.peel.as_ref().map(Peel::build),
            clip_shapes: shapes.collect::<PyResult<_>>()?,
            ..VolumeInstance::new(self.volume.shared(), self.medium.build()?, world_from_patient)
        })
    }
}

/// `lumivox.Environment`.
#[derive(FromPyObject)]
struct Surroundings {
    source: Source,
    strength: f64,
    rotation: f64,
    color: [f64; 3],
    zenith: [f64; 3],
    horizon: [f64; 3],
    nadir: [f64; 3],
}

#[derive(FromPyObject)]
enum Source {
    Name(String),
    Map(Mapped),
}

/// `lumivox.EnvironmentMap`, of which the native half counts.
#[derive(FromPyObject)]
struct Mapped {
    native: Py<looks::Map>,
}

impl Surroundings {
    fn build(&self) -> PyResult<Environment> {
        let source = match &self.source {
            Source::Map(map) => EnvironmentSource::Map(map.native.get().0.clone()),
            Source::Name(name) => match name.as_str() {
                "studio" => EnvironmentSource::Studio,
                "uniform" => EnvironmentSource::Uniform(self.color),
                "gradient" => EnvironmentSource::Gradient {
                    zenith: self.zenith,
                    horizon: self.horizon,
                    nadir: self.nadir,
                },
                other => {
                    let known = "'studio', 'uniform', 'gradient' or a map";
                    return Err(errors::value(format!("environment '{other}' is not {known}")));
                }
            },
        };
        Ok(Environment { source, rotation: self.rotation.to_radians(), strength: self.strength })
    }
}

/// `lumivox.Sun`, `lumivox.PointLight` or `lumivox.SpotLight`.
#[derive(FromPyObject)]
enum AnyLight {
    Sun(Sun),
    Spot(Spot),
    Point(Point),
}

#[derive(FromPyObject)]
struct Sun {
    layers: u32,
    azimuth: f64,
    elevation: f64,
    strength: f64,
    degrees: f64,
}

#[derive(FromPyObject)]
struct Point {
    layers: u32,
    position: [f64; 3],
    intensity: [f64; 3],
    radius: f64,
}

#[derive(FromPyObject)]
struct Spot {
    layers: u32,
    position: [f64; 3],
    intensity: [f64; 3],
    radius: f64,
    target: [f64; 3],
    half_angle: f64,
}

impl AnyLight {
    fn build(&self) -> Light {
        let lamp = |position: [f64; 3], intensity, radius: f64| Lamp {
            radius: radius * METRES_PER_MM,
            ..Lamp::new(DVec3::from_array(position) * METRES_PER_MM, intensity)
        };
        let (light, layers) = match self {
            Self::Sun(sun) => {
                let (sin_a, cos_a) = sun.azimuth.to_radians().sin_cos();
                let (sin_e, cos_e) = sun.elevation.to_radians().sin_cos();
                let kind = LightKind::Directional {
                    direction: -DVec3::new(sin_a * cos_e, sin_e, cos_a * cos_e),
                    irradiance: [sun.strength * PI; 3],
                    angular_radius: sun.degrees.to_radians(),
                };
                (kind.into(), sun.layers)
            }
            Self::Point(point) => {
                (Light::point(lamp(point.position, point.intensity, point.radius)), point.layers)
            }
            Self::Spot(spot) => {
                let direction = DVec3::from_array(spot.target) - DVec3::from_array(spot.position);
                let lamp = lamp(spot.position, spot.intensity, spot.radius);
                (Light::spot(lamp, direction, spot.half_angle.to_radians()), spot.layers)
            }
        };
        Light { layers, ..light }
    }
}

/// `lumivox.Scene`.
#[derive(FromPyObject)]
pub struct Scene {
    volumes: Vec<Instance>,
    environment: Surroundings,
    lights: Vec<AnyLight>,
}

impl Scene {
    /// The scene described. Volumes that are placed nowhere share the first one's patient space, its centre at the origin.
    pub fn build(&self) -> PyResult<core::Scene> {
        let center = self.volumes.first().map(|first| first.volume.shared().center_mm());
        let usual = world_from_patient() * DAffine3::from_translation(-center.unwrap_or_default());
        let volumes = self.volumes.iter().map(|instance| instance.build(usual)).collect::<PyResult<_>>()?;
        let lights = self.lights.iter().map(AnyLight::build).collect();
        Ok(core::Scene { volumes, environment: self.environment.build()?, lights })
    }
}

/// The light of a `lumivox.Scene`, without what it falls on.
#[derive(FromPyObject)]
pub struct Lit {
    environment: Surroundings,
}

impl Lit {
    /// The environment described.
    pub fn build(&self) -> PyResult<Environment> {
        self.environment.build()
    }
}

/// `lumivox.Camera`.
#[derive(FromPyObject)]
pub struct Camera {
    world_from_camera: Rows,
    fov: f64,
}

impl Camera {
    /// The camera described.
    pub fn build(&self) -> PerspectiveCamera {
        // Its own space is of metres, too: only where it stands is scaled.
        let mut world_from_camera = affine(self.world_from_camera);
        world_from_camera.translation *= METRES_PER_MM;
        PerspectiveCamera { world_from_camera, vertical_fov: self.fov.to_radians() }
    }
}

/// World metres from the scene's mm.
fn in_metres() -> DAffine3 {
    DAffine3::from_scale(DVec3::splat(METRES_PER_MM))
}

/// A camera's place as rows in mm.
fn rows_of(camera: &PerspectiveCamera) -> Rows {
    let mut world_from_camera = camera.world_from_camera;
    world_from_camera.translation /= METRES_PER_MM;
    rows(world_from_camera)
}

/// A camera around what a scene shows, or at an `eye` in mm, as rows in mm.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "what the command asks for, one by one")]
pub fn frame(
    py: Python<'_>,
    scene: Scene,
    azimuth: Option<f64>,
    elevation: Option<f64>,
    zoom: Option<f64>,
    fov: f64,
    aspect: f64,
    eye: Option<[f64; 3]>,
    target: Option<[f64; 3]>,
) -> PyResult<Rows> {
    let scene = scene.build()?;
    let view = View { azimuth, elevation, zoom, eye, target, fov, ..View::default() };
    let camera = fork::detach(py, || view.camera(&scene, aspect));
    camera.as_ref().map(rows_of).ok_or_else(looks_at_itself)
}

/// Degrees around the vertical and above the horizon from which a scene is seen where nothing is said.
#[pyfunction]
pub fn usual_angles(scene: Scene) -> PyResult<[f64; 2]> {
    let scene = scene.build()?;
    let front = scene.volumes.first().and_then(framing::front);
    Ok(front.unwrap_or_default().map(f64::to_degrees))
}

/// Those of a volume's labels that are asked for and of which hardly anything is seen.
#[pyfunction]
pub fn unseen_labels(py: Python<'_>, instance: Instance, asked: Vec<u8>) -> PyResult<Vec<u8>> {
    let instance = instance.build(DAffine3::IDENTITY)?;
    Ok(fork::detach(py, || instance.unseen_labels(&asked)))
}

fn looks_at_itself() -> PyErr {
    errors::value("eye is the point looked at; move it, or give another target")
}

/// A camera at a place in mm that looks at another, as rows in mm.
#[pyfunction]
pub fn look_at(eye: [f64; 3], target: [f64; 3], up: [f64; 3], fov: f64) -> PyResult<Rows> {
    let [eye, target, up] = [eye, target, up].map(DVec3::from_array);
    if eye.distance(target) <= 1e-6 {
        return Err(looks_at_itself());
    }
    let camera =
        PerspectiveCamera::look_at(eye * METRES_PER_MM, target * METRES_PER_MM, up, fov.to_radians());
    Ok(rows_of(&camera))
}

/// `lumivox.rendering.Request`.
#[derive(FromPyObject)]
pub struct Request {
    size: [u32; 2],
    samples: u32,
    time: Option<f64>,
    seed: u32,
    guides: bool,
    first_sample: u32,
    pass_samples: Option<u32>,
    window: Option<[u32; 4]>,
}

impl Request {
    /// The request described.
    pub fn build(&self) -> PyResult<RenderRequest> {
        let [width, height] = self.size;
        let time = self.time.map(Duration::try_from_secs_f64).transpose().map_err(errors::value)?;
        let pass_samples = self.pass_samples.map(|samples| {
            NonZeroU32::new(samples).ok_or_else(|| errors::value("pass_samples must be at least 1"))
        });
        if self.first_sample >= self.samples {
            return Err(errors::value("first_sample must be below samples"));
        }
        Ok(RenderRequest {
            time,
            seed: self.seed,
            guides: self.guides,
            first_sample: self.first_sample,
            pass_samples: pass_samples.transpose()?,
            window: self.window.map(|[x, y, width, height]| [[x, y], [width, height]]),
            ..RenderRequest::new(width, height, self.samples)
        })
    }
}

/// A map, checked.
pub fn environment_map(width: usize, height: usize, texels: Vec<[f32; 3]>) -> PyResult<Arc<EnvironmentMap>> {
    EnvironmentMap::new(width, height, texels).map(Arc::new).map_err(errors::value)
}
