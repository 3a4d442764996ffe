//! The structs that cross the border to C#, as C sees them.
//!
//! Positions, directions and matrices are in Unity's conventions: metres, y up, left-handed, matrices in columns, as
//! `Matrix4x4` lies in memory. `convert` turns them into Lumivox' right-handed world.

use std::ffi::c_char;

/// Raised whenever a struct or a function of the border changes. A package refuses a library of another one.
pub const LUMIVOX_ABI_VERSION: u32 = 8;

/// What a scan is and how it lies in its object.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LumivoxVolumeInfo {
    /// Voxels along the scan's own x, y and z axes.
    pub dimensions: [u32; 3],
    /// Bytes of a voxel: 1, 2 or 4.
    pub bytes_per_voxel: u32,
    /// Millimetres between neighbouring voxels along those axes.
    pub spacing_mm: [f64; 3],
    /// Smallest and largest value, in the scan's unit.
    pub value_range: [f64; 2],
    /// The corners of what it fills along the object's axes, in metres.
    pub bounds_min: [f32; 3],
    /// The other corner.
    pub bounds_max: [f32; 3],
    /// From clip coordinates, 0 to 1 along each edge of its box, to the object's metres.
    pub object_from_clip: [f32; 16],
    /// From the patient's millimetres (LPS) to the object's metres.
    pub object_from_patient: [f32; 16],
    /// 0 other, 1 CT, 2 MR, 3 PET.
    pub modality: u32,
    /// 1 where values are Hounsfield units.
    pub is_hounsfield: u32,
    /// 1 where something that lies around the patient was put aside: part 1 of `lumivox_part_find` shows it.
    pub has_surroundings: u32,
    /// Nothing.
    pub padding: u32,
    /// The unit's name in UTF-8, ended by 0: `HU`, `SUV`; empty where it is not known.
    pub unit: [u8; 16],
}

/// A point of an opacity curve.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LumivoxOpacityKnot {
    /// In the scan's unit.
    pub value: f64,
    /// 0 to 1.
    pub opacity: f64,
    /// How the curve leaves towards the next: 0 straight, 1 slowly at both ends.
    pub ease: u32,
    /// Nothing.
    pub padding: u32,
}

/// A point of a colour ramp.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LumivoxColorStop {
    /// In the scan's unit.
    pub value: f64,
    /// Linear, 0 to 1.
    pub red: f64,
    /// Linear, 0 to 1.
    pub green: f64,
    /// Linear, 0 to 1.
    pub blue: f64,
}

/// How boundaries inside a scan reflect.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LumivoxSurface {
    /// How strongly boundaries reflect like surfaces, 0 to 1.
    pub strength: f32,
    /// How steep a boundary must be, in value units per millimetre; 0: as suits the scan, of a label's the instance's.
    pub gradient: f32,
    /// Width of the highlights, 0 glossy to 1 matt.
    pub roughness: f32,
    /// Share of the light that the highlights reflect seen head-on, 0 to 1.
    pub specular: f32,
    /// How much of the medium's colour the highlights have, 0 to 1, as of metal.
    pub metallic: f32,
}

/// How light and a scan meet. The defaults are those of the component.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LumivoxMedium {
    /// Multiplies the extinction of 1 per millimetre at an opacity of 1; 0 to 1000.
    pub density: f32,
    /// Fraction of the light that survives each scattering, 0 to 1.
    pub albedo: f32,
    /// Where light goes when it scatters, -0.99 (back) to 0.99 (onwards).
    pub anisotropy: f32,
    /// Scatterings after which light is no longer followed, 1 to 1000.
    pub max_bounces: u32,
    /// 0 nearest, 1 trilinear, 2 tricubic, 3 smooth.
    pub filter: u32,
    /// What a millimetre of extinction is measured in: 0 the scan's own, 1 the scene's.
    pub extinction_space: u32,
    /// How its boundaries reflect.
    pub surface: LumivoxSurface,
}

/// A shape that cuts instances open: what it keeps of them is seen.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LumivoxClipShape {
    /// The shape's `Transform.localToWorldMatrix`.
    pub world_from_shape: [f32; 16],
    /// 0 a plane, which keeps the side of the shape's +y; 1 a cube of one metre, 2 a ball of one metre across, both about
    /// its origin.
    pub kind: u32,
    /// 1: what it would keep is cut away, and the rest kept.
    pub inverted: u32,
}

/// A label of a map.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LumivoxLabel {
    /// The value of its voxels, 1 to 255.
    pub value: u32,
    /// Linear RGB, 0 to 1.
    pub color: [f32; 3],
    /// Of all its voxels, in ml; of what is made, nothing.
    pub milliliters: f64,
}

/// How the voxels of one label look.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LumivoxLabelStyle {
    /// Its value; 0 is what has no label.
    pub value: u32,
    /// 1 where they are seen.
    pub visible: u32,
    /// 1 where `color` takes the place of the transfer function's colours.
    pub painted: u32,
    /// 1 where clip shapes cut them, 0 where they are spared.
    pub clipped: u32,
    /// Linear RGB, 0 to 1.
    pub color: [f32; 3],
    /// Multiplies their opacity, 0 to 1.
    pub opacity: f32,
    /// In place of the instance's; below 0: that.
    pub density: f32,
    /// 1 where the surface below takes the place of the instance's.
    pub has_surface: u32,
    /// How their boundaries reflect.
    pub surface: LumivoxSurface,
    /// In place of the instance's, without rows for gradients; null: that.
    pub transfer_function: *const crate::look::LumivoxTransferFunction,
}

/// A scan as it stands in a world.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LumivoxInstance {
    /// The scan; an instance without one is passed over.
    pub volume: *const crate::volume::LumivoxVolume,
    /// What of it is seen in place of the patient, of `lumivox_part_find`; null: the scan as it is.
    pub part: *const crate::volume::LumivoxVolume,
    /// Opacity and colour of its values; null: those of the preset that suits the scan.
    pub transfer_function: *const crate::look::LumivoxTransferFunction,
    /// What its parts are and how they look; null: it has none.
    pub labelling: *const crate::labels::LumivoxLabelling,
    /// The object's `Transform.localToWorldMatrix`.
    pub world_from_object: [f32; 16],
    /// The corner of what is kept with the smallest coordinates, as fractions of its box, 0 to 1.
    pub clip_min: [f32; 3],
    /// The opposite corner. Where it lies before `clip_min`, what is between them is kept.
    pub clip_max: [f32; 3],
    /// `1 << GameObject.layer`.
    pub layers: u32,
    /// The rest of its look.
    pub medium: LumivoxMedium,
    /// Millimetres below the skin that are taken off, once `lumivox_skin_find` has found it.
    pub peel_mm: f32,
    /// The first of the clip shapes of its world that cut it.
    pub first_clip: u32,
    /// How many do.
    pub clip_count: u32,
}

/// A light that reaches volumes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LumivoxLight {
    /// 0 directional, 1 point, 2 spot.
    pub kind: u32,
    /// `Light.cullingMask`: it lights the instances that share a layer with it.
    pub layers: u32,
    /// Of a point or a spot.
    pub position: [f32; 3],
    /// Where the light of a sun or a spot travels to.
    pub direction: [f32; 3],
    /// Linear RGB: the irradiance of a sun, the radiant intensity of a lamp. A white surface that faces a sun of
    /// irradiance pi has a radiance of 1, which is what Unity gives an intensity of 1.
    pub strength: [f32; 3],
    /// Of a lamp, in metres; a sun's is an angle in radians.
    pub radius: f32,
    /// Metres after which a lamp does not shine; infinity: it has no end.
    pub range: f32,
    /// How a lamp's light falls off: 0 as URP and HDRP have it (by `decay`, ending smoothly at the range), 1 as the
    /// built-in pipeline has it.
    pub falloff: u32,
    /// The power of the distance by which a lamp's light falls off; 0 stands for 2, which is physical.
    pub decay: f32,
    /// Angle in radians from a spot's axis to the edge of its cone.
    pub outer_half_angle: f32,
    /// Angle within which a spot is as bright as on its axis.
    pub inner_half_angle: f32,
    /// 1: a spot falls off by the power `attenuation` of the way to its edge, as Godot's, and not from the inner angle on.
    pub has_attenuation: u32,
    /// See `has_attenuation`.
    pub attenuation: f32,
}

/// The light from all around.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LumivoxEnvironment {
    /// 0 one colour, 1 a gradient, 2 Lumivox' studio, 3 a map.
    pub kind: u32,
    /// Linear RGB radiance: of the one colour, or from straight up.
    pub zenith: [f32; 3],
    /// Of a gradient, from the horizon.
    pub horizon: [f32; 3],
    /// Of a gradient, from straight down.
    pub nadir: [f32; 3],
    /// Turns it about the vertical axis, in radians, as `Transform.eulerAngles.y` turns an object.
    pub rotation: f32,
    /// Multiplies the radiance.
    pub strength: f32,
    /// Of a map; null is darkness.
    pub map: *const crate::look::LumivoxMap,
}

/// Where an object stands: what its `Transform` is set to.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LumivoxPose {
    /// Metres.
    pub position: [f32; 3],
    /// A quaternion: x, y, z, w.
    pub rotation: [f32; 4],
    /// Along its own axes.
    pub scale: [f32; 3],
}

/// From where a scene of a file is seen, the image that is rendered, and how light becomes pixels.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LumivoxSavedView {
    /// `Camera.cameraToWorldMatrix`.
    pub world_from_camera: [f32; 16],
    /// Degrees between the bottom and the top of the image.
    pub field_of_view: f32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Paths per pixel; 0: not said.
    pub samples: u32,
    /// The same seed gives the same noise.
    pub seed: u32,
    /// Relative noise at which it is done before; 0: by its samples alone.
    pub noise: f32,
    /// 1 where the noise that is left is smoothed out.
    pub denoise: u32,
    /// What stands behind: 0 nothing, 1 the light, 2 `color`.
    pub background: u32,
    /// sRGB, 0 to 1.
    pub color: [f32; 3],
    /// Stops brighter.
    pub exposure: f32,
    /// The curve from light to pixels: 0 none, 1 AgX, 2 ACES.
    pub tone: u32,
    /// Brightens the mid-tones above 1.
    pub gamma: f32,
}

/// What the GPU can do, as `SystemInfo` tells it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LumivoxDeviceLimits {
    /// `maxTexture3DSize`.
    pub max_texture_3d: u32,
    /// `maxTextureSize`.
    pub max_texture_2d: u32,
    /// `maxGraphicsBufferSize`.
    pub max_buffer_bytes: u64,
    /// Bytes that volumes may fill on it, with the light that is kept in them; 0: as many as there is room for.
    pub voxel_bytes: u64,
    /// 1 where R16_UNorm textures can be filtered and written.
    pub unorm16: u32,
    /// 1 for a device in software, whose dispatches take long.
    pub is_software: u32,
}

/// One view of one frame: a camera, or an eye of a headset.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LumivoxViewFrame {
    /// `Camera.cameraToWorldMatrix`, or the inverse of an eye's view matrix.
    pub world_from_camera: [f32; 16],
    /// The projection with which the depth buffer was filled, with the image's first row in memory at y = -1 and the
    /// depth that the buffer holds in z: `GL.GetGPUProjectionMatrix`, its second row negated where the first row is at 1.
    pub clip_from_camera: [f32; 16],
    /// Pixels across and down.
    pub size: [u32; 2],
    /// 1 where the host's depth ends rays.
    pub has_depth: u32,
    /// What the depth texture holds where nothing was drawn: 0 where z is reversed, else 1.
    pub depth_clear: f32,
    /// 1 where the camera is shifted by part of a pixel in each frame.
    pub is_jittered: u32,
    /// 1 where volumes write their depth.
    pub write_depth: u32,
    /// Multiplies the light.
    pub exposure: f32,
    /// Linear RGB radiance from everywhere, besides the world's light.
    pub ambient: [f32; 3],
    /// Pixels traced per pixel of the view along a side, 0.1 to 1.
    pub resolution_scale: f32,
    /// Samples per pixel after which the image is done.
    pub target_samples: u32,
    /// Relative noise at which it is done before; 0: by its samples alone.
    pub target_noise: f32,
    /// Milliseconds of the GPU's time in a frame.
    pub frame_budget_ms: f32,
    /// 1 where noise is filtered out of what is shown at rest.
    pub denoise: u32,
    /// 1 where light is kept in the volumes, for pictures while something moves.
    pub kept_light: u32,
    /// 0 none, 1 linear, 2 exponential, 3 exponential squared: `RenderSettings.fogMode`.
    pub fog: u32,
    /// Linear RGB of the fog.
    pub fog_color: [f32; 3],
    /// Metres where linear fog begins.
    pub fog_start: f32,
    /// Metres where linear fog hides everything.
    pub fog_end: f32,
    /// Of exponential fog, per metre.
    pub fog_density: f32,
    /// 1 where this frame must show its world whole, however long that takes: none follows.
    pub at_once: u32,
}

/// How far a view's image is.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct LumivoxViewStatus {
    /// Samples that every pixel has.
    pub samples: u32,
    /// 1 where there is nothing more to trace unless something changes.
    pub is_converged: u32,
    /// 1 while that may turn out to be wrong: a host that draws on demand goes on until it is 0.
    pub awaits_feedback: u32,
    /// Pixels whose paths the driver ended before their time.
    pub lost_pixels: u32,
    /// Pixel samples that this frame traces.
    pub pixel_samples: u64,
    /// Bytes of the GPU's memory that light takes which is kept for this view; 0 where none is.
    pub light_bytes: u64,
    /// The names under which the steps mean the host's depth to read, its colour, and its depth to write.
    pub depth: u64,
    /// See `depth`.
    pub color: u64,
    /// See `depth`.
    pub written_depth: u64,
    /// Whom read-backs of these steps belong to.
    pub ticket: u64,
}

/// Bytes of the library's.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LumivoxSlice {
    /// The first.
    pub data: *const u8,
    /// How many.
    pub length: u64,
}

/// What a step does.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LumivoxStepKind {
    /// Make the storage buffer `id` of `length` bytes, zeros.
    CreateBuffer = 0,
    /// Make the texture `id` of `size` and `format`; 2D where the last of `size` is 0.
    CreateTexture = 1,
    /// Write `data` at byte `offset` of buffer `id`.
    WriteBuffer = 2,
    /// Write `data`, without padding, into the box of `size` at `origin` of texture `id`.
    WriteTexture = 3,
    /// Copy the box of `size` at `origin` of texture `from` to the same place of texture `id`.
    CopyTexture = 4,
    /// Fill buffer `id` with zeros.
    ClearBuffer = 5,
    /// Run `kernel` in `workgroups`.
    Dispatch = 6,
    /// Draw one triangle with `kernel` over texture `id`.
    Draw = 7,
    /// Bring `length` bytes from `offset` of buffer `id` back, to `lumivox_stage_feedback`.
    ReadBuffer = 8,
    /// Nothing uses `id` any more, once what was asked for before has been done.
    Free = 9,
}

/// One step of a recording. Fields that its kind does not name are 0.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LumivoxStep {
    /// What it does.
    pub kind: LumivoxStepKind,
    /// Of a texture: 0 R8 norm, 1 R16 norm, 2 R16 float, 3 RGBA32 float.
    pub format: u32,
    /// What it does it to.
    pub id: u64,
    /// Where it takes it from.
    pub from: u64,
    /// First texel.
    pub origin: [u32; 3],
    /// Texels.
    pub size: [u32; 3],
    /// First byte.
    pub offset: u64,
    /// Bytes.
    pub length: u64,
    /// What is written; valid until the recording is freed.
    pub data: *const u8,
    /// For debuggers; lives as long as the library.
    pub label: *const c_char,
    /// See `lumivox_kernel_name`.
    pub kernel: u32,
    /// How many.
    pub uniform_count: u32,
    /// The contents of the kernel's uniform buffers, in the order of its table.
    pub uniforms: *const LumivoxSlice,
    /// Buffers and textures that it binds, in that order, too.
    pub resources: *const u64,
    /// How many.
    pub resource_count: u32,
    /// Workgroups along x and y.
    pub workgroups: [u32; 2],
    /// Nothing.
    pub padding: u32,
}

/// What became of a recording.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LumivoxOutcome {
    /// It is on its way to the GPU.
    Executed = 0,
    /// The GPU has no room for something.
    NoMemory = 1,
    /// Something else was refused.
    Failed = 2,
}

/// How far long work is.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LumivoxJobState {
    /// It goes on.
    Running = 0,
    /// What it makes can be taken.
    Done = 1,
    /// `lumivox_job_error` says why.
    Failed = 2,
    /// It was stopped.
    Cancelled = 3,
}

/// How far a job is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LumivoxProgress {
    /// A phrase for people, such as `decoding slices`; lives as long as the library.
    pub stage: *const c_char,
    /// Steps of this stage that are done.
    pub done: u64,
    /// Steps of this stage; each stage counts anew.
    pub total: u64,
}

/// What to load where there is a choice. Strings are UTF-8; null: not said.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LumivoxImportOptions {
    /// Which series of a DICOM study: its position from 1, its SeriesInstanceUID or its number.
    pub series: *const c_char,
    /// Which volume of a series with several, from 1; 0: the first that is whole.
    pub phase: u32,
    /// 1: slices that are missing stay empty.
    pub leave_gaps: u32,
    /// 1: slices that are damaged are filled in.
    pub fill_damaged: u32,
    /// 1: a header may name data files anywhere.
    pub allow_outside_data: u32,
    /// 1: what lies around the patient in a CT is a part of the scan: the table, clothes, cables. 0: it is put aside, where
    /// it can be told from the patient for sure.
    pub keep_everything: u32,
    /// Whether the file is a label map: 0 no, 1 yes, 2 where it looks like one. The scan that is made has labels then.
    pub labels: u32,
    /// Nothing.
    pub padding: u32,
    /// What the bytes of a RAW file mean, such as `256x256x108:i16le:spacing=1,1,2`.
    pub raw: *const c_char,
}

/// A small picture.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LumivoxPicture {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// `4 * width * height` bytes, rows from the top: sRGB and straight alpha; valid until the job is freed.
    pub rgba: *const u8,
}
