//! What is filmed: scans, looks, and what moves. A moment of a film is a pure function of its time.

use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::{Camera, CancelToken, ClipShape, Orbit, Preset, Progress, Scene, Volume, framing};
use lumivox_phantom::{AnatomyOptions, TorsoOptions, anatomy, torso};

/// Frames of a second.
pub const RATE: f64 = 60.0;

/// Degrees.
const AZIMUTH: f64 = 25.0;

/// Radians.
const ELEVATION: f64 = 0.05;
const FOV: f64 = 0.49;

/// By how much of everything a second is: degrees of the camera, Hounsfield units of the function, degrees of the light, the
/// part of the body that the plane takes off.
const ORBIT: f64 = 30.0;
const FUNCTION: f64 = 120.0;
const LIGHT: f64 = 60.0;
const PLANE: f64 = 0.45;

/// Degrees from the last frame of an orbit to what follows after the cut.
const CUT: f64 = 120.0;

/// A scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    Head,
    Torso,
}

impl Body {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Head, Self::Torso];

    /// As options and tables have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Head => "head",
            Self::Torso => "torso",
        }
    }

    /// Made, of so many voxels along a side.
    pub fn volume(self, size: usize) -> Result<Arc<Volume>, String> {
        let (silent, never) = (Progress::SILENT, CancelToken::new());
        let made = match self {
            Self::Head => anatomy(AnatomyOptions { size, ..Default::default() }, silent, &never),
            Self::Torso => torso(TorsoOptions { size, ..Default::default() }, silent, &never),
        };
        made.map(Arc::new).map_err(|error| format!("the phantom {}: {error}", self.name()))
    }
}

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// The camera, around the subject.
    Orbit,
    /// The transfer function, along the scan's values.
    Function,
    /// The light, around the subject.
    Light,
    /// A board of the host's, in front of the subject and through it.
    Mesh,
    /// A clip plane, from the subject's front into it.
    Plane,
    /// The scan, as on a turntable, before a camera that stands.
    Turn,
}

impl Motion {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Orbit, Self::Function, Self::Light, Self::Mesh, Self::Plane, Self::Turn];

    /// As options and tables have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Orbit => "orbit",
            Self::Function => "function",
            Self::Light => "light",
            Self::Mesh => "mesh",
            Self::Plane => "plane",
            Self::Turn => "turn",
        }
    }
}

/// A scan in a look, and where it is looked at from.
pub struct Set {
    name: String,
    scene: Scene,
    orbit: Orbit,
    aspect: f64,
    /// What is seen of the scan, in its millimetres.
    seen_mm: [DVec3; 2],
}

/// All that a frame shows.
pub struct Moment {
    pub scene: Scene,
    pub camera: Camera,
    pub board: Option<Board>,
}

impl Set {
    /// Framed from the front, a little to the left.
    pub fn new(body: Body, volume: &Arc<Volume>, look: Preset, aspect: f64) -> Self {
        let name = format!("{}-{}", body.name(), look.name());
        let scene = Scene::with_volume(volume.clone(), look.medium(volume));
        let orbit = framing::frame(&scene, AZIMUTH.to_radians(), ELEVATION, FOV, aspect);
        let seen = framing::visible_box(volume, &scene.volumes[0].medium);
        let dims = DVec3::from_array(volume.dims().map(|n| n as f64));
        let corners = seen.map(|corner| volume.patient_from_voxel().transform_point3(corner * dims - 0.5));
        let seen_mm = [corners[0].min(corners[1]), corners[0].max(corners[1])];
        Self { name, scene, orbit, aspect, seen_mm }
    }

    /// As files have it.
    pub fn name(&self, motion: Motion) -> String {
        format!("{}-{}", self.name, motion.name())
    }

    /// So many seconds after the beginning.
    pub fn at(&self, motion: Motion, seconds: f64) -> Moment {
        let mut moment = Moment { scene: self.scene.clone(), camera: self.camera(0.0), board: None };
        let instance = &mut moment.scene.volumes[0];
        match motion {
            Motion::Orbit => moment.camera = self.camera(ORBIT * seconds),
            Motion::Function => {
                let function = &mut instance.medium.transfer_function;
                *function = function.remapped(1.0, FUNCTION * seconds);
            }
            Motion::Light => moment.scene.environment.rotation = (LIGHT * seconds).to_radians(),
            Motion::Mesh => moment.board = Some(self.board(seconds)),
            Motion::Plane => {
                let [low, high] = self.seen_mm;
                // Patient y grows towards the back.
                let mut point = (low + high) / 2.0;
                point.y = low.y + (high.y - low.y) * (0.02 + PLANE * seconds);
                instance.clip_shapes = vec![ClipShape::plane(point, DVec3::Y)];
            }
            Motion::Turn => {
                let [low, high] = self.seen_mm;
                let centre = instance.world_from_patient.transform_point3((low + high) / 2.0);
                let turn = DAffine3::from_rotation_y((ORBIT * seconds).to_radians());
                let about = DAffine3::from_translation(centre) * turn * DAffine3::from_translation(-centre);
                instance.world_from_patient = about * instance.world_from_patient;
            }
        }
        moment
    }

    /// What is seen after the cut that follows a film: another side of an orbit; of others a frame of the film, for which there is
    /// a converged picture.
    pub fn after_cut(&self, motion: Motion, film_seconds: f64, frame_seconds: f64) -> Moment {
        match motion {
            Motion::Orbit => self.at(motion, film_seconds + CUT / ORBIT),
            _ => self.at(motion, frame_seconds),
        }
    }

    fn camera(&self, degrees: f64) -> Camera {
        let azimuth = self.orbit.azimuth + degrees.to_radians();
        Orbit { azimuth, ..self.orbit }.camera().with_aspect(self.aspect)
    }

    /// It comes from the left, nearer than the subject, and goes to the right, through it.
    fn board(&self, seconds: f64) -> Board {
        let world_from_patient = self.scene.volumes[0].world_from_patient;
        let [low, high] = self.seen_mm;
        let centre = world_from_patient.transform_point3((low + high) / 2.0);
        let half = world_from_patient.transform_vector3((high - low) / 2.0).abs().max_element();
        let camera = self.camera(0.0).world_from_camera.matrix3;
        let place = camera.x_axis * (2.0 * seconds - 1.0) * 1.1 + camera.z_axis * (1.1 - 0.9 * seconds);
        let turn = camera * DMat3::from_rotation_y(25f64.to_radians());
        let size = DMat3::from_diagonal(DVec3::new(0.12, 0.7, 0.04) * half);
        let world_from_board = DAffine3 { matrix3: turn * size, translation: centre + place * half };
        Board { board_from_world: world_from_board.inverse(), world_from_board }
    }
}

/// A box of the host's: whatever lies between -1 and 1 of its own space.
pub struct Board {
    board_from_world: DAffine3,
    world_from_board: DAffine3,
}

impl Board {
    /// View depths in metres of all pixels, rows from the top; 0 where it is not.
    pub fn depths(&self, camera: &Camera, [width, height]: [u32; 2]) -> Vec<f64> {
        let mut depths = vec![0.0; width as usize * height as usize];
        let forward = -camera.world_from_camera.matrix3.z_axis;
        let [columns, rows] = self.pixels_around(camera, [width, height]);
        for y in rows[0]..rows[1] {
            for x in columns[0]..columns[1] {
                let uv = [(x as f64 + 0.5) / f64::from(width), (y as f64 + 0.5) / f64::from(height)];
                let ray = camera.ray(uv);
                let origin = self.board_from_world.transform_point3(ray.origin);
                let direction = self.board_from_world.transform_vector3(ray.direction);
                let (a, b) = ((-1.0 - origin) / direction, (1.0 - origin) / direction);
                let (near, far) = (a.min(b).max_element(), a.max(b).min_element());
                if near <= far && near > 0.0 {
                    depths[y * width as usize + x] = near * ray.direction.dot(forward);
                }
            }
        }
        depths
    }

    /// Columns and rows outside of which it cannot be.
    fn pixels_around(&self, camera: &Camera, size: [u32; 2]) -> [[usize; 2]; 2] {
        let camera_from_world = camera.world_from_camera.inverse();
        let corner = |i: usize| DVec3::from_array([0, 1, 2].map(|axis| (i >> axis & 1) as f64 * 2.0 - 1.0));
        let corners = (0..8)
            .map(|i| camera_from_world.transform_point3(self.world_from_board.transform_point3(corner(i))));
        // The image plane at a distance of 1, from the rays through its corners.
        let on_plane = |uv| {
            let direction = camera_from_world.transform_vector3(camera.ray(uv).direction);
            direction / -direction.z
        };
        let (top_left, bottom_right) = (on_plane([0.0; 2]), on_plane([1.0; 2]));
        let mut around = [[usize::MAX, 0]; 2];
        for p in corners {
            if p.z >= -1e-6 {
                // It reaches behind the camera.
                return size.map(|n| [0, n as usize]);
            }
            for axis in 0..2 {
                let part = (p[axis] / -p.z - top_left[axis]) / (bottom_right[axis] - top_left[axis]);
                let pixel = (part * f64::from(size[axis])).clamp(0.0, f64::from(size[axis]));
                around[axis][0] = around[axis][0].min(pixel.floor() as usize);
                around[axis][1] = around[axis][1].max(pixel.ceil() as usize);
            }
        }
        around
    }
}
