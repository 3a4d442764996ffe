//! A scene described once, built twice: here for the renderer, in `project/build_case.gd` for Godot.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::light::{self, Cone, Falloff, LightKind};
use lumivox_core::{
    Camera, CancelToken, ClipKind, ClipShape, ColorStop, Ease, Environment, EnvironmentMap,
    EnvironmentSource, Filter, LabelStyle, Labelling, Medium, OpacityKnot, PerspectiveCamera, Preset,
    Progress, Projection, Scene, SurfaceReflection, TransferFunction, VolumeInstance,
};
use lumivox_renderer::{DistanceFog, HeightFog};
use serde::Serialize;

use crate::scans;

/// A place: columns of the linear part, then the origin, as Godot's `Transform3D`.
#[derive(Clone, Copy, Serialize)]
pub struct Place(pub [f64; 12]);

impl Place {
    pub fn new(rotation_scale: DMat3, origin: DVec3) -> Self {
        let mut numbers = [0.0; 12];
        numbers[..9].copy_from_slice(&rotation_scale.to_cols_array());
        numbers[9..].copy_from_slice(&origin.to_array());
        Self(numbers)
    }

    pub fn at(origin: DVec3) -> Self {
        Self::new(DMat3::IDENTITY, origin)
    }

    pub fn affine(&self) -> DAffine3 {
        let columns: [f64; 9] = self.0[..9].try_into().unwrap();
        let origin = DVec3::from_slice(&self.0[9..]);
        DAffine3 { matrix3: DMat3::from_cols_array(&columns), translation: origin }
    }
}

/// A shape that cuts a volume, whose child it is.
#[derive(Clone, Copy, Serialize)]
pub struct Clip {
    /// 0 plane, 1 box, 2 sphere.
    pub shape: u32,
    /// In the volume's node.
    pub place: Place,
    pub inverted: bool,
}

impl Clip {
    /// As the class says: planes keep what is above y = 0, boxes and spheres what is within half a metre.
    fn shape(&self, patient_from_node: DAffine3) -> ClipShape {
        let half = DAffine3::from_scale(DVec3::splat(0.5));
        let (kind, node_from_shape) = match self.shape {
            0 => (ClipKind::Plane, DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y))),
            1 => (ClipKind::Box, half),
            _ => (ClipKind::Sphere, half),
        };
        let patient_from_shape = patient_from_node * self.place.affine() * node_from_shape;
        ClipShape { kind, patient_from_shape, inverted: self.inverted }
    }
}

/// A phantom, its look and its place.
#[derive(Clone, Serialize)]
pub struct Volume {
    /// `cube` or `head`, or `table`: a torso on its table, which is loaded from a series of files.
    pub phantom: &'static str,
    pub series: PathBuf,
    /// Of a torso on its table: whether that is seen.
    pub keep_everything: bool,
    /// The preset that was chosen before the look was changed, which may show an organ alone.
    pub preset: &'static str,
    /// A preset whose whole look takes the place of all below but the filter; empty for none.
    pub look: &'static str,
    /// Voxels along a side.
    pub size: usize,
    pub place: Place,
    /// Value, opacity, 1 to ease in and out.
    pub knots: Vec<[f64; 3]>,
    /// Value, linear RGB.
    pub stops: Vec<[f64; 4]>,
    /// A file with a function of value and gradient in place of both; empty for none.
    pub function: PathBuf,
    pub density: f64,
    pub albedo: f64,
    pub anisotropy: f64,
    pub max_bounces: u32,
    /// 0 nearest, 1 trilinear, 2 tricubic, 3 smooth.
    pub filter: u32,
    /// Strength, gradient per mm, roughness, specular, metallic.
    pub surface: [f64; 5],
    pub clip_min: [f64; 3],
    pub clip_max: [f64; 3],
    pub clips: Vec<Clip>,
    /// Of labels that are found in the phantom: their names, and whether each is seen.
    pub shown_labels: Vec<(&'static str, bool)>,
    /// Bits of the layers that it is on.
    pub layers: u32,
    pub visible: bool,
}

impl Volume {
    /// Translucent, coloured, in the middle.
    pub fn soft() -> Self {
        Self {
            phantom: "cube",
            series: PathBuf::new(),
            keep_everything: false,
            preset: "",
            look: "",
            size: 24,
            place: Place::at(DVec3::ZERO),
            knots: vec![[-500.0, 0.0, 0.0], [200.0, 0.3, 1.0], [1500.0, 1.0, 0.0]],
            stops: vec![[0.0, 0.9, 0.5, 0.3], [1200.0, 0.9, 0.9, 0.8]],
            function: PathBuf::new(),
            density: 0.08,
            albedo: 0.9,
            anisotropy: 0.2,
            max_bounces: 20,
            filter: 1,
            surface: [0.0, 100.0, 0.4, 0.04, 0.0],
            clip_min: [0.0; 3],
            clip_max: [1.0; 3],
            clips: vec![],
            shown_labels: vec![],
            layers: 1,
            visible: true,
        }
    }

    /// A head whose surfaces reflect.
    pub fn head() -> Self {
        Self {
            phantom: "head",
            size: 40,
            knots: vec![[-300.0, 0.0, 1.0], [300.0, 0.6, 1.0], [1500.0, 1.0, 0.0]],
            density: 0.3,
            surface: [0.7, 60.0, 0.4, 0.04, 0.0],
            ..Self::soft()
        }
    }

    /// A head whose borders are of another colour than what lies between them, by a file.
    pub fn borders() -> Self {
        static FILE: OnceLock<PathBuf> = OnceLock::new();
        let file = FILE.get_or_init(|| {
            let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("borders.json");
            let points = |opacity: f64, color: &str| {
                format!(
                    "\"opacity\": [{{\"value\": -300, \"opacity\": 0}}, {{\"value\": 300, \"opacity\": {opacity}, \
                     \"ease\": \"in-out\"}}], \"color\": [{{\"value\": 0, \"color\": {color}}}]"
                )
            };
            let rows = [(50.0, 0.125, "[0.25, 0.75, 0.25]"), (300.0, 0.75, "[0.25, 0.25, 1]")]
                .map(|(per_mm, opacity, color)| format!("{{\"per_mm\": {per_mm}, {}}}", points(opacity, color)));
            let flat = points(0.5, "[1, 0.5, 0.25]");
            let text = format!("{{\"lumivox_transfer_function\": 1, {flat}, \"gradients\": [{}]}}", rows.join(", "));
            std::fs::write(&file, text).unwrap();
            file
        });
        Self { function: file.clone(), ..Self::head() }
    }

    /// A torso on its table.
    pub fn table() -> Self {
        const SIZE: usize = 96;
        static SERIES: OnceLock<PathBuf> = OnceLock::new();
        let series = SERIES.get_or_init(|| {
            let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("table_{SIZE}"));
            scans::write_series(&scans::torso(SIZE), &folder);
            folder
        });
        Self { phantom: "table", series: series.clone(), size: SIZE, density: 0.2, ..Self::head() }
    }

    /// Nothing behind it shines through, and it is red: a hole in it is seen.
    pub fn solid() -> Self {
        Self {
            knots: vec![[-1020.0, 0.0, 0.0], [-900.0, 1.0, 0.0]],
            stops: vec![[0.0, 0.8, 0.1, 0.05]],
            density: 30.0,
            anisotropy: 0.0,
            ..Self::soft()
        }
    }

    /// What is seen of a torso on its table.
    fn on_table(&self) -> lumivox_core::Volume {
        let (silent, never) = (Progress::SILENT, CancelToken::new());
        let torso = scans::torso(self.size);
        if self.keep_everything {
            return torso;
        }
        let found = lumivox_segmentation::patient_alone(torso, silent, &never).unwrap();
        let Ok(preset) = Preset::from_name(self.preset) else { return found.volume };
        let (organ, labels) = (preset.organ().unwrap(), found.labels.unwrap());
        lumivox_segmentation::organ_alone(found.volume, &labels, organ, silent, &never).unwrap()
    }

    fn instance(&self) -> VolumeInstance {
        let knots = self.knots.iter().map(|&[value, opacity, ease]| OpacityKnot {
            value,
            opacity,
            ease: if ease > 0.0 { Ease::InOut } else { Ease::Linear },
        });
        let stops = self.stops.iter().map(|&[value, r, g, b]| ColorStop { value, color: [r, g, b] });
        let [strength, gradient_per_mm, roughness, specular, metallic] = self.surface;
        let medium = Medium {
            density_scale: self.density,
            albedo: self.albedo,
            anisotropy: self.anisotropy,
            max_bounces: self.max_bounces,
            filter: [Filter::Nearest, Filter::Trilinear, Filter::Tricubic, Filter::Smooth]
                [self.filter as usize],
            surface: SurfaceReflection { strength, gradient_per_mm, roughness, specular, metallic },
            ..Medium::new(TransferFunction::new(knots.collect(), stops.collect()).unwrap())
        };
        let medium = if self.function.as_os_str().is_empty() {
            medium
        } else {
            let loaded = lumivox_import::load_transfer_function_2d(&self.function, [0.0, 1.0]).unwrap();
            Medium { transfer_function: loaded.0, gradients: loaded.1, ..medium }
        };
        let volume = match self.phantom {
            "cube" => lumivox_phantom::cube(self.size),
            "table" => self.on_table(),
            _ => scans::head(self.size),
        };
        let medium = match Preset::from_name(self.look) {
            Ok(preset) => Medium { filter: medium.filter, ..preset.medium(&volume) },
            Err(_) => medium,
        };
        let mut instance = VolumeInstance::centered(Arc::new(volume), medium);
        instance.world_from_patient = self.place.affine() * instance.world_from_patient;
        // In the node's frame y is up, the patient's z, and z is towards the viewer, the patient's front (-y).
        let [low, high] = [self.clip_min, self.clip_max];
        instance.clip_box =
            [DVec3::new(low[0], 1.0 - high[2], low[1]), DVec3::new(high[0], 1.0 - low[2], high[1])];
        instance.layers = self.layers;
        let patient_from_node = instance.world_from_patient.inverse() * self.place.affine();
        instance.clip_shapes = self.clips.iter().map(|clip| clip.shape(patient_from_node)).collect();
        if !self.shown_labels.is_empty() {
            let never = CancelToken::new();
            let found = lumivox_segmentation::segment(&instance.volume, Progress::SILENT, &never).unwrap();
            let mut labelling = Labelling::new(Arc::new(found.labels));
            for &(name, visible) in &self.shown_labels {
                for value in labelling.labels.values_of(name, &[]) {
                    labelling.set_style(value, LabelStyle { visible, ..Default::default() });
                }
            }
            instance.labels = Some(labelling);
        }
        instance
    }
}

/// A box of one flat colour, for depth.
#[derive(Clone, Copy, Serialize)]
pub struct Mesh {
    /// Whole sides in metres.
    pub size: [f64; 3],
    pub place: Place,
    /// Linear RGB, unshaded.
    pub color: [f64; 3],
}

/// What kind of node a lamp is.
#[derive(Clone, Copy, PartialEq, Serialize)]
pub enum LampKind {
    Directional,
    Omni,
    Spot,
}

/// A light in the scene, with the properties of Godot's nodes.
#[derive(Clone, Copy, Serialize)]
pub struct Lamp {
    pub kind: LampKind,
    /// It shines along its -z.
    pub place: Place,
    /// Linear RGB.
    pub color: [f64; 3],
    pub energy: f64,
    /// The angle across a sun in degrees, else a radius in metres.
    pub size: f64,
    pub range: f64,
    pub attenuation: f64,
    /// From the axis to the edge, in degrees.
    pub spot_angle: f64,
    pub spot_attenuation: f64,
    /// Bits of the layers that it lights.
    pub layers: u32,
}

impl Lamp {
    /// White, of energy 1, with Godot's defaults.
    pub fn new(kind: LampKind, place: Place) -> Self {
        Self {
            kind,
            place,
            color: [1.0; 3],
            energy: 1.0,
            size: 0.0,
            range: 5.0,
            attenuation: 1.0,
            spot_angle: 45.0,
            spot_attenuation: 1.0,
            layers: u32::MAX >> 12,
        }
    }

    /// What Godot's manual says of it: at an energy of 1 a white surface that faces a sun is white.
    pub fn light(&self) -> light::Light {
        let place = self.place.affine();
        let direction = -place.matrix3.z_axis;
        let white = self.color.map(|c| c * self.energy * std::f64::consts::PI);
        let lamp = light::Lamp {
            position: place.translation,
            intensity: white,
            radius: self.size,
            falloff: Falloff::Power { range: self.range, decay: self.attenuation },
        };
        let kind = match self.kind {
            LampKind::Directional => LightKind::Directional {
                direction,
                irradiance: white,
                angular_radius: (self.size / 2.0).to_radians(),
            },
            LampKind::Omni => LightKind::Point(lamp),
            LampKind::Spot => LightKind::Spot {
                lamp,
                direction,
                half_angle: self.spot_angle.to_radians(),
                cone: Cone::Power { attenuation: 1.0 / self.spot_attenuation },
            },
        };
        light::Light { kind, layers: self.layers }
    }

    /// What a white Lambert surface reflects of it, without any shadow; of lamps that are points.
    pub fn reflected(&self, point: DVec3, normal: DVec3) -> [f64; 3] {
        let place = self.place.affine();
        let axis = -place.matrix3.z_axis.normalize();
        let (towards, factor) = match self.kind {
            LampKind::Directional => (-axis, 1.0),
            LampKind::Omni | LampKind::Spot => {
                let offset = place.translation - point;
                let towards = offset.normalize();
                let cone = match self.kind {
                    LampKind::Spot => LightKind::cone_factor(
                        -towards.dot(axis),
                        self.spot_angle.to_radians(),
                        Cone::Power { attenuation: 1.0 / self.spot_attenuation },
                    ),
                    _ => 1.0,
                };
                let falloff = Falloff::Power { range: self.range, decay: self.attenuation };
                (towards, falloff.at(offset.length()) * cone)
            }
        };
        self.color.map(|c| c * self.energy * factor * normal.dot(towards).max(0.0))
    }
}

/// Light from all around.
#[derive(Clone, Serialize)]
pub enum Light {
    /// A background of one colour, linear RGB.
    Color([f64; 3]),
    /// A panorama: texels across and down, and the angle it is turned by around the vertical, in radians.
    Panorama { width: usize, height: usize, texels: Vec<[f32; 3]>, rotation: f64, energy: f64 },
}

/// The engine's fog, by its manual's names; `depth` is between two distances.
#[derive(Clone, Copy, Serialize)]
pub struct Fog {
    /// Linear RGB.
    pub color: [f64; 3],
    pub energy: f64,
    pub density: f64,
    /// Begin, end and curve.
    pub depth: Option<[f64; 3]>,
    pub height: f64,
    pub height_density: f64,
}

impl Fog {
    pub fn core(&self) -> lumivox_renderer::Fog {
        let density = self.density;
        lumivox_renderer::Fog {
            color: self.color.map(|c| c * self.energy),
            by_distance: match self.depth {
                Some([begin, end, curve]) => DistanceFog::Between { begin, end, curve, density },
                None => DistanceFog::Exponential { density },
            },
            by_height: Some(HeightFog { height: self.height, density: self.height_density }),
        }
    }
}

/// How a viewport makes pixels.
#[derive(Clone, Copy, Serialize)]
pub struct Output {
    /// Samples of the rasteriser: 1, 2, 4 or 8.
    pub msaa: u32,
    /// Pixels that are drawn per pixel that is shown, along a side.
    pub scale: f64,
    /// 0 bilinear, 1 FSR 1, 2 FSR 2.
    pub scaling: u32,
    pub hdr: bool,
    pub transparent: bool,
    pub taa: bool,
}

/// A scene, a camera and how long to look.
#[derive(Clone, Serialize)]
pub struct Case {
    pub name: &'static str,
    pub size: [u32; 2],
    pub samples: u32,
    pub camera: Place,
    /// Vertical field of view in degrees, or 0 for a parallel view.
    pub fov: f64,
    /// Metres from the bottom to the top of a parallel view.
    pub height: f64,
    /// Left, right, bottom and top edge of a view at distance 1, instead of `fov` and the pixels' own shape.
    pub tangents: Option<[f64; 4]>,
    pub light: Light,
    /// Whether volumes are lit by Lumivox' studio in place of it.
    pub studio: bool,
    /// In stops.
    pub exposure: f64,
    pub volumes: Vec<Volume>,
    pub meshes: Vec<Mesh>,
    pub lamps: Vec<Lamp>,
    /// Boxes that the lamps light; white Lambert surfaces, times their colour.
    pub lit_meshes: Vec<Mesh>,
    /// Boxes that let half of what is behind them through.
    pub glass: Vec<Mesh>,
    /// Boxes that refract what the screen shows behind them, by no angle: they show just that.
    pub clear_glass: Vec<Mesh>,
    /// Boxes that show their colour where the depth behind them is that of something, and black elsewhere.
    pub depth_readers: Vec<Mesh>,
    /// Boxes that scatter light below their surface, and shine.
    pub skin: Vec<Mesh>,
    pub output: Output,
    /// Milliseconds of tracing in a frame.
    pub budget: f64,
    /// Whether what moves is shown by kept light, as it is by default. Of an image at rest nothing of it is left, and it takes
    /// half as long again: most cases do without.
    pub kept_light: bool,
    pub fog: Option<Fog>,
}

impl Case {
    /// The test cube in white light, a little from above.
    pub fn new(name: &'static str) -> Self {
        Self {
            name,
            size: [96, 72],
            samples: 24,
            camera: look_at(DVec3::new(0.022, 0.028, 0.085), DVec3::ZERO),
            fov: 35.0,
            height: 0.0,
            tangents: None,
            light: Light::Color([0.4, 0.45, 0.5]),
            studio: false,
            exposure: 0.0,
            volumes: vec![Volume::soft()],
            meshes: vec![],
            lamps: vec![],
            lit_meshes: vec![],
            glass: vec![],
            clear_glass: vec![],
            depth_readers: vec![],
            skin: vec![],
            output: Output { msaa: 1, scale: 1.0, scaling: 0, hdr: false, transparent: false, taa: false },
            budget: 50.0,
            kept_light: false,
            fog: None,
        }
    }

    pub fn scene(&self) -> Scene {
        let environment = match &self.light {
            _ if self.studio => Environment::default(),
            &Light::Color(color) => {
                Environment { source: EnvironmentSource::Uniform(color), ..Environment::default() }
            }
            Light::Panorama { width, height, texels, rotation, energy } => {
                // Godot's panoramas begin at -z, where the core's have their middle.
                let mut texels = texels.clone();
                texels.chunks_exact_mut(*width).for_each(|row| row.rotate_left(width / 2));
                let map = EnvironmentMap::new(*width, *height, texels).unwrap();
                Environment {
                    source: EnvironmentSource::Map(Arc::new(map)),
                    rotation: *rotation,
                    strength: *energy,
                }
            }
        };
        Scene {
            volumes: self.volumes.iter().filter(|v| v.visible).map(Volume::instance).collect(),
            environment,
            lights: self.lamps.iter().map(Lamp::light).collect(),
        }
    }

    pub fn camera(&self) -> Camera {
        let aspect = f64::from(self.size[0]) / f64::from(self.size[1]);
        let world_from_camera = self.camera.affine();
        if let Some(tangents) = self.tangents {
            return Camera { world_from_camera, projection: Projection::Perspective { tangents } };
        }
        if self.fov > 0.0 {
            return PerspectiveCamera { world_from_camera, vertical_fov: self.fov.to_radians() }
                .with_aspect(aspect);
        }
        let half = self.height / 2.0;
        let extents = [-half * aspect, half * aspect, -half, half];
        Camera { world_from_camera, projection: Projection::Orthographic { extents } }
    }
}

/// A camera's place.
pub fn look_at(eye: DVec3, target: DVec3) -> Place {
    let affine = PerspectiveCamera::look_at(eye, target, DVec3::Y, 1.0).world_from_camera;
    Place::new(affine.matrix3, affine.translation)
}
