/* The C ABI of Lumivox for Unity, made of crates/lumivox-unity by its test `header`.
 *
 * Functions that give a pointer give null, those that give an int32_t a negative number where something is wrong;
 * lumivox_last_error says what, to the thread that asked. Handles are freed once by the function of their name; to free
 * null does nothing. Any thread may call anything, but a LumivoxStage and its recordings belong to one thread at a time.
 * Strings are UTF-8, ended by 0. Places and matrices are in Unity's conventions. */

#ifndef LUMIVOX_UNITY_H
#define LUMIVOX_UNITY_H

#include <stdint.h>

/**
 * Raised whenever a struct or a function of the border changes. A package refuses a library of another one.
 */
#define LUMIVOX_ABI_VERSION 8

/**
 * How far long work is.
 */
typedef enum LumivoxJobState {
  /**
   * It goes on.
   */
  LumivoxJobState_Running = 0,
  /**
   * What it makes can be taken.
   */
  LumivoxJobState_Done = 1,
  /**
   * `lumivox_job_error` says why.
   */
  LumivoxJobState_Failed = 2,
  /**
   * It was stopped.
   */
  LumivoxJobState_Cancelled = 3,
} LumivoxJobState;

/**
 * What a step does.
 */
typedef enum LumivoxStepKind {
  /**
   * Make the storage buffer `id` of `length` bytes, zeros.
   */
  LumivoxStepKind_CreateBuffer = 0,
  /**
   * Make the texture `id` of `size` and `format`; 2D where the last of `size` is 0.
   */
  LumivoxStepKind_CreateTexture = 1,
  /**
   * Write `data` at byte `offset` of buffer `id`.
   */
  LumivoxStepKind_WriteBuffer = 2,
  /**
   * Write `data`, without padding, into the box of `size` at `origin` of texture `id`.
   */
  LumivoxStepKind_WriteTexture = 3,
  /**
   * Copy the box of `size` at `origin` of texture `from` to the same place of texture `id`.
   */
  LumivoxStepKind_CopyTexture = 4,
  /**
   * Fill buffer `id` with zeros.
   */
  LumivoxStepKind_ClearBuffer = 5,
  /**
   * Run `kernel` in `workgroups`.
   */
  LumivoxStepKind_Dispatch = 6,
  /**
   * Draw one triangle with `kernel` over texture `id`.
   */
  LumivoxStepKind_Draw = 7,
  /**
   * Bring `length` bytes from `offset` of buffer `id` back, to `lumivox_stage_feedback`.
   */
  LumivoxStepKind_ReadBuffer = 8,
  /**
   * Nothing uses `id` any more, once what was asked for before has been done.
   */
  LumivoxStepKind_Free = 9,
} LumivoxStepKind;

/**
 * Long work, and what it makes.
 */
typedef struct LumivoxJob LumivoxJob;

/**
 * A label map with the looks of its labels. What shows it goes on without the handle.
 */
typedef struct LumivoxLabelling LumivoxLabelling;

/**
 * A panorama of light. Handles share it.
 */
typedef struct LumivoxMap LumivoxMap;

/**
 * A recording under way, and its steps as C sees them.
 */
typedef struct LumivoxRecording LumivoxRecording;

/**
 * A scene document that was opened.
 */
typedef struct LumivoxScene LumivoxScene;

/**
 * Everything that is shown on one device.
 */
typedef struct LumivoxStage LumivoxStage;

/**
 * Files whose headers were read. Handles share it.
 */
typedef struct LumivoxStudy LumivoxStudy;

/**
 * Text of the library's, until it is freed.
 */
typedef struct LumivoxText LumivoxText;

/**
 * Opacity and colour of values, and of values where they change steeply.
 */
typedef struct LumivoxTransferFunction LumivoxTransferFunction;

/**
 * A scan. Handles share it.
 */
typedef struct LumivoxVolume LumivoxVolume;

/**
 * What a scan is and how it lies in its object.
 */
typedef struct LumivoxVolumeInfo {
  /**
   * Voxels along the scan's own x, y and z axes.
   */
  uint32_t dimensions[3];
  /**
   * Bytes of a voxel: 1, 2 or 4.
   */
  uint32_t bytes_per_voxel;
  /**
   * Millimetres between neighbouring voxels along those axes.
   */
  double spacing_mm[3];
  /**
   * Smallest and largest value, in the scan's unit.
   */
  double value_range[2];
  /**
   * The corners of what it fills along the object's axes, in metres.
   */
  float bounds_min[3];
  /**
   * The other corner.
   */
  float bounds_max[3];
  /**
   * From clip coordinates, 0 to 1 along each edge of its box, to the object's metres.
   */
  float object_from_clip[16];
  /**
   * From the patient's millimetres (LPS) to the object's metres.
   */
  float object_from_patient[16];
  /**
   * 0 other, 1 CT, 2 MR, 3 PET.
   */
  uint32_t modality;
  /**
   * 1 where values are Hounsfield units.
   */
  uint32_t is_hounsfield;
  /**
   * 1 where something that lies around the patient was put aside: part 1 of `lumivox_part_find` shows it.
   */
  uint32_t has_surroundings;
  /**
   * Nothing.
   */
  uint32_t padding;
  /**
   * The unit's name in UTF-8, ended by 0: `HU`, `SUV`; empty where it is not known.
   */
  uint8_t unit[16];
} LumivoxVolumeInfo;

/**
 * A point of an opacity curve.
 */
typedef struct LumivoxOpacityKnot {
  /**
   * In the scan's unit.
   */
  double value;
  /**
   * 0 to 1.
   */
  double opacity;
  /**
   * How the curve leaves towards the next: 0 straight, 1 slowly at both ends.
   */
  uint32_t ease;
  /**
   * Nothing.
   */
  uint32_t padding;
} LumivoxOpacityKnot;

/**
 * A point of a colour ramp.
 */
typedef struct LumivoxColorStop {
  /**
   * In the scan's unit.
   */
  double value;
  /**
   * Linear, 0 to 1.
   */
  double red;
  /**
   * Linear, 0 to 1.
   */
  double green;
  /**
   * Linear, 0 to 1.
   */
  double blue;
} LumivoxColorStop;

/**
 * How boundaries inside a scan reflect.
 */
typedef struct LumivoxSurface {
  /**
   * How strongly boundaries reflect like surfaces, 0 to 1.
   */
  float strength;
  /**
   * How steep a boundary must be, in value units per millimetre; 0: as suits the scan, of a label's the instance's.
   */
  float gradient;
  /**
   * Width of the highlights, 0 glossy to 1 matt.
   */
  float roughness;
  /**
   * Share of the light that the highlights reflect seen head-on, 0 to 1.
   */
  float specular;
  /**
   * How much of the medium's colour the highlights have, 0 to 1, as of metal.
   */
  float metallic;
} LumivoxSurface;

/**
 * How light and a scan meet. The defaults are those of the component.
 */
typedef struct LumivoxMedium {
  /**
   * Multiplies the extinction of 1 per millimetre at an opacity of 1; 0 to 1000.
   */
  float density;
  /**
   * Fraction of the light that survives each scattering, 0 to 1.
   */
  float albedo;
  /**
   * Where light goes when it scatters, -0.99 (back) to 0.99 (onwards).
   */
  float anisotropy;
  /**
   * Scatterings after which light is no longer followed, 1 to 1000.
   */
  uint32_t max_bounces;
  /**
   * 0 nearest, 1 trilinear, 2 tricubic, 3 smooth.
   */
  uint32_t filter;
  /**
   * What a millimetre of extinction is measured in: 0 the scan's own, 1 the scene's.
   */
  uint32_t extinction_space;
  /**
   * How its boundaries reflect.
   */
  struct LumivoxSurface surface;
} LumivoxMedium;

/**
 * A label of a map.
 */
typedef struct LumivoxLabel {
  /**
   * The value of its voxels, 1 to 255.
   */
  uint32_t value;
  /**
   * Linear RGB, 0 to 1.
   */
  float color[3];
  /**
   * Of all its voxels, in ml; of what is made, nothing.
   */
  double milliliters;
} LumivoxLabel;

/**
 * How the voxels of one label look.
 */
typedef struct LumivoxLabelStyle {
  /**
   * Its value; 0 is what has no label.
   */
  uint32_t value;
  /**
   * 1 where they are seen.
   */
  uint32_t visible;
  /**
   * 1 where `color` takes the place of the transfer function's colours.
   */
  uint32_t painted;
  /**
   * 1 where clip shapes cut them, 0 where they are spared.
   */
  uint32_t clipped;
  /**
   * Linear RGB, 0 to 1.
   */
  float color[3];
  /**
   * Multiplies their opacity, 0 to 1.
   */
  float opacity;
  /**
   * In place of the instance's; below 0: that.
   */
  float density;
  /**
   * 1 where the surface below takes the place of the instance's.
   */
  uint32_t has_surface;
  /**
   * How their boundaries reflect.
   */
  struct LumivoxSurface surface;
  /**
   * In place of the instance's, without rows for gradients; null: that.
   */
  const struct LumivoxTransferFunction *transfer_function;
} LumivoxLabelStyle;

/**
 * What to load where there is a choice. Strings are UTF-8; null: not said.
 */
typedef struct LumivoxImportOptions {
  /**
   * Which series of a DICOM study: its position from 1, its SeriesInstanceUID or its number.
   */
  const char *series;
  /**
   * Which volume of a series with several, from 1; 0: the first that is whole.
   */
  uint32_t phase;
  /**
   * 1: slices that are missing stay empty.
   */
  uint32_t leave_gaps;
  /**
   * 1: slices that are damaged are filled in.
   */
  uint32_t fill_damaged;
  /**
   * 1: a header may name data files anywhere.
   */
  uint32_t allow_outside_data;
  /**
   * 1: what lies around the patient in a CT is a part of the scan: the table, clothes, cables. 0: it is put aside, where
   * it can be told from the patient for sure.
   */
  uint32_t keep_everything;
  /**
   * Whether the file is a label map: 0 no, 1 yes, 2 where it looks like one. The scan that is made has labels then.
   */
  uint32_t labels;
  /**
   * Nothing.
   */
  uint32_t padding;
  /**
   * What the bytes of a RAW file mean, such as `256x256x108:i16le:spacing=1,1,2`.
   */
  const char *raw;
} LumivoxImportOptions;

/**
 * How far a job is.
 */
typedef struct LumivoxProgress {
  /**
   * A phrase for people, such as `decoding slices`; lives as long as the library.
   */
  const char *stage;
  /**
   * Steps of this stage that are done.
   */
  uint64_t done;
  /**
   * Steps of this stage; each stage counts anew.
   */
  uint64_t total;
} LumivoxProgress;

/**
 * A small picture.
 */
typedef struct LumivoxPicture {
  /**
   * Pixels.
   */
  uint32_t width;
  /**
   * Pixels.
   */
  uint32_t height;
  /**
   * `4 * width * height` bytes, rows from the top: sRGB and straight alpha; valid until the job is freed.
   */
  const uint8_t *rgba;
} LumivoxPicture;

/**
 * A scan as it stands in a world.
 */
typedef struct LumivoxInstance {
  /**
   * The scan; an instance without one is passed over.
   */
  const struct LumivoxVolume *volume;
  /**
   * What of it is seen in place of the patient, of `lumivox_part_find`; null: the scan as it is.
   */
  const struct LumivoxVolume *part;
  /**
   * Opacity and colour of its values; null: those of the preset that suits the scan.
   */
  const struct LumivoxTransferFunction *transfer_function;
  /**
   * What its parts are and how they look; null: it has none.
   */
  const struct LumivoxLabelling *labelling;
  /**
   * The object's `Transform.localToWorldMatrix`.
   */
  float world_from_object[16];
  /**
   * The corner of what is kept with the smallest coordinates, as fractions of its box, 0 to 1.
   */
  float clip_min[3];
  /**
   * The opposite corner. Where it lies before `clip_min`, what is between them is kept.
   */
  float clip_max[3];
  /**
   * `1 << GameObject.layer`.
   */
  uint32_t layers;
  /**
   * The rest of its look.
   */
  struct LumivoxMedium medium;
  /**
   * Millimetres below the skin that are taken off, once `lumivox_skin_find` has found it.
   */
  float peel_mm;
  /**
   * The first of the clip shapes of its world that cut it.
   */
  uint32_t first_clip;
  /**
   * How many do.
   */
  uint32_t clip_count;
} LumivoxInstance;

/**
 * Where an object stands: what its `Transform` is set to.
 */
typedef struct LumivoxPose {
  /**
   * Metres.
   */
  float position[3];
  /**
   * A quaternion: x, y, z, w.
   */
  float rotation[4];
  /**
   * Along its own axes.
   */
  float scale[3];
} LumivoxPose;

/**
 * A shape that cuts instances open: what it keeps of them is seen.
 */
typedef struct LumivoxClipShape {
  /**
   * The shape's `Transform.localToWorldMatrix`.
   */
  float world_from_shape[16];
  /**
   * 0 a plane, which keeps the side of the shape's +y; 1 a cube of one metre, 2 a ball of one metre across, both about
   * its origin.
   */
  uint32_t kind;
  /**
   * 1: what it would keep is cut away, and the rest kept.
   */
  uint32_t inverted;
} LumivoxClipShape;

/**
 * From where a scene of a file is seen, the image that is rendered, and how light becomes pixels.
 */
typedef struct LumivoxSavedView {
  /**
   * `Camera.cameraToWorldMatrix`.
   */
  float world_from_camera[16];
  /**
   * Degrees between the bottom and the top of the image.
   */
  float field_of_view;
  /**
   * Pixels across.
   */
  uint32_t width;
  /**
   * Pixels down.
   */
  uint32_t height;
  /**
   * Paths per pixel; 0: not said.
   */
  uint32_t samples;
  /**
   * The same seed gives the same noise.
   */
  uint32_t seed;
  /**
   * Relative noise at which it is done before; 0: by its samples alone.
   */
  float noise;
  /**
   * 1 where the noise that is left is smoothed out.
   */
  uint32_t denoise;
  /**
   * What stands behind: 0 nothing, 1 the light, 2 `color`.
   */
  uint32_t background;
  /**
   * sRGB, 0 to 1.
   */
  float color[3];
  /**
   * Stops brighter.
   */
  float exposure;
  /**
   * The curve from light to pixels: 0 none, 1 AgX, 2 ACES.
   */
  uint32_t tone;
  /**
   * Brightens the mid-tones above 1.
   */
  float gamma;
} LumivoxSavedView;

/**
 * A light that reaches volumes.
 */
typedef struct LumivoxLight {
  /**
   * 0 directional, 1 point, 2 spot.
   */
  uint32_t kind;
  /**
   * `Light.cullingMask`: it lights the instances that share a layer with it.
   */
  uint32_t layers;
  /**
   * Of a point or a spot.
   */
  float position[3];
  /**
   * Where the light of a sun or a spot travels to.
   */
  float direction[3];
  /**
   * Linear RGB: the irradiance of a sun, the radiant intensity of a lamp. A white surface that faces a sun of
   * irradiance pi has a radiance of 1, which is what Unity gives an intensity of 1.
   */
  float strength[3];
  /**
   * Of a lamp, in metres; a sun's is an angle in radians.
   */
  float radius;
  /**
   * Metres after which a lamp does not shine; infinity: it has no end.
   */
  float range;
  /**
   * How a lamp's light falls off: 0 as URP and HDRP have it (by `decay`, ending smoothly at the range), 1 as the
   * built-in pipeline has it.
   */
  uint32_t falloff;
  /**
   * The power of the distance by which a lamp's light falls off; 0 stands for 2, which is physical.
   */
  float decay;
  /**
   * Angle in radians from a spot's axis to the edge of its cone.
   */
  float outer_half_angle;
  /**
   * Angle within which a spot is as bright as on its axis.
   */
  float inner_half_angle;
  /**
   * 1: a spot falls off by the power `attenuation` of the way to its edge, as Godot's, and not from the inner angle on.
   */
  uint32_t has_attenuation;
  /**
   * See `has_attenuation`.
   */
  float attenuation;
} LumivoxLight;

/**
 * The light from all around.
 */
typedef struct LumivoxEnvironment {
  /**
   * 0 one colour, 1 a gradient, 2 Lumivox' studio, 3 a map.
   */
  uint32_t kind;
  /**
   * Linear RGB radiance: of the one colour, or from straight up.
   */
  float zenith[3];
  /**
   * Of a gradient, from the horizon.
   */
  float horizon[3];
  /**
   * Of a gradient, from straight down.
   */
  float nadir[3];
  /**
   * Turns it about the vertical axis, in radians, as `Transform.eulerAngles.y` turns an object.
   */
  float rotation;
  /**
   * Multiplies the radiance.
   */
  float strength;
  /**
   * Of a map; null is darkness.
   */
  const struct LumivoxMap *map;
} LumivoxEnvironment;

/**
 * Bytes of the library's.
 */
typedef struct LumivoxSlice {
  /**
   * The first.
   */
  const uint8_t *data;
  /**
   * How many.
   */
  uint64_t length;
} LumivoxSlice;

/**
 * One step of a recording. Fields that its kind does not name are 0.
 */
typedef struct LumivoxStep {
  /**
   * What it does.
   */
  enum LumivoxStepKind kind;
  /**
   * Of a texture: 0 R8 norm, 1 R16 norm, 2 R16 float, 3 RGBA32 float.
   */
  uint32_t format;
  /**
   * What it does it to.
   */
  uint64_t id;
  /**
   * Where it takes it from.
   */
  uint64_t from;
  /**
   * First texel.
   */
  uint32_t origin[3];
  /**
   * Texels.
   */
  uint32_t size[3];
  /**
   * First byte.
   */
  uint64_t offset;
  /**
   * Bytes.
   */
  uint64_t length;
  /**
   * What is written; valid until the recording is freed.
   */
  const uint8_t *data;
  /**
   * For debuggers; lives as long as the library.
   */
  const char *label;
  /**
   * See `lumivox_kernel_name`.
   */
  uint32_t kernel;
  /**
   * How many.
   */
  uint32_t uniform_count;
  /**
   * The contents of the kernel's uniform buffers, in the order of its table.
   */
  const struct LumivoxSlice *uniforms;
  /**
   * Buffers and textures that it binds, in that order, too.
   */
  const uint64_t *resources;
  /**
   * How many.
   */
  uint32_t resource_count;
  /**
   * Workgroups along x and y.
   */
  uint32_t workgroups[2];
  /**
   * Nothing.
   */
  uint32_t padding;
} LumivoxStep;

/**
 * What the GPU can do, as `SystemInfo` tells it.
 */
typedef struct LumivoxDeviceLimits {
  /**
   * `maxTexture3DSize`.
   */
  uint32_t max_texture_3d;
  /**
   * `maxTextureSize`.
   */
  uint32_t max_texture_2d;
  /**
   * `maxGraphicsBufferSize`.
   */
  uint64_t max_buffer_bytes;
  /**
   * Bytes that volumes may fill on it, with the light that is kept in them; 0: as many as there is room for.
   */
  uint64_t voxel_bytes;
  /**
   * 1 where R16_UNorm textures can be filtered and written.
   */
  uint32_t unorm16;
  /**
   * 1 for a device in software, whose dispatches take long.
   */
  uint32_t is_software;
} LumivoxDeviceLimits;

/**
 * One view of one frame: a camera, or an eye of a headset.
 */
typedef struct LumivoxViewFrame {
  /**
   * `Camera.cameraToWorldMatrix`, or the inverse of an eye's view matrix.
   */
  float world_from_camera[16];
  /**
   * The projection with which the depth buffer was filled, with the image's first row in memory at y = -1 and the
   * depth that the buffer holds in z: `GL.GetGPUProjectionMatrix`, its second row negated where the first row is at 1.
   */
  float clip_from_camera[16];
  /**
   * Pixels across and down.
   */
  uint32_t size[2];
  /**
   * 1 where the host's depth ends rays.
   */
  uint32_t has_depth;
  /**
   * What the depth texture holds where nothing was drawn: 0 where z is reversed, else 1.
   */
  float depth_clear;
  /**
   * 1 where the camera is shifted by part of a pixel in each frame.
   */
  uint32_t is_jittered;
  /**
   * 1 where volumes write their depth.
   */
  uint32_t write_depth;
  /**
   * Multiplies the light.
   */
  float exposure;
  /**
   * Linear RGB radiance from everywhere, besides the world's light.
   */
  float ambient[3];
  /**
   * Pixels traced per pixel of the view along a side, 0.1 to 1.
   */
  float resolution_scale;
  /**
   * Samples per pixel after which the image is done.
   */
  uint32_t target_samples;
  /**
   * Relative noise at which it is done before; 0: by its samples alone.
   */
  float target_noise;
  /**
   * Milliseconds of the GPU's time in a frame.
   */
  float frame_budget_ms;
  /**
   * 1 where noise is filtered out of what is shown at rest.
   */
  uint32_t denoise;
  /**
   * 1 where light is kept in the volumes, for pictures while something moves.
   */
  uint32_t kept_light;
  /**
   * 0 none, 1 linear, 2 exponential, 3 exponential squared: `RenderSettings.fogMode`.
   */
  uint32_t fog;
  /**
   * Linear RGB of the fog.
   */
  float fog_color[3];
  /**
   * Metres where linear fog begins.
   */
  float fog_start;
  /**
   * Metres where linear fog hides everything.
   */
  float fog_end;
  /**
   * Of exponential fog, per metre.
   */
  float fog_density;
  /**
   * 1 where this frame must show its world whole, however long that takes: none follows.
   */
  uint32_t at_once;
} LumivoxViewFrame;

/**
 * How far a view's image is.
 */
typedef struct LumivoxViewStatus {
  /**
   * Samples that every pixel has.
   */
  uint32_t samples;
  /**
   * 1 where there is nothing more to trace unless something changes.
   */
  uint32_t is_converged;
  /**
   * 1 while that may turn out to be wrong: a host that draws on demand goes on until it is 0.
   */
  uint32_t awaits_feedback;
  /**
   * Pixels whose paths the driver ended before their time.
   */
  uint32_t lost_pixels;
  /**
   * Pixel samples that this frame traces.
   */
  uint64_t pixel_samples;
  /**
   * Bytes of the GPU's memory that light takes which is kept for this view; 0 where none is.
   */
  uint64_t light_bytes;
  /**
   * The names under which the steps mean the host's depth to read, its colour, and its depth to write.
   */
  uint64_t depth;
  /**
   * See `depth`.
   */
  uint64_t color;
  /**
   * See `depth`.
   */
  uint64_t written_depth;
  /**
   * Whom read-backs of these steps belong to.
   */
  uint64_t ticket;
} LumivoxViewStatus;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The characters of a text, UTF-8, ended by 0; an empty text for null.
 *
 * # Safety
 * `text` is null, or a live handle.
 */
const char *lumivox_text(const struct LumivoxText *text);

/**
 * Frees a text.
 *
 * # Safety
 * `text` is null, or a live handle.
 */
void lumivox_text_free(struct LumivoxText *text);

/**
 * What went wrong in the last call of this thread, ready to be shown; empty if nothing did. Valid until its next call.
 */
const char *lumivox_last_error(void);

/**
 * The version of the border, see `LUMIVOX_ABI_VERSION`.
 */
uint32_t lumivox_abi_version(void);

/**
 * The version of Lumivox.
 */
const char *lumivox_version(void);

/**
 * Compares the sizes of the structs of the border, in the order in which the header has them, with those that the caller
 * knows; -1 where they differ.
 *
 * # Safety
 * `sizes` points to `count` numbers.
 */
int32_t lumivox_check_layout(const uint32_t *sizes,
                             uint32_t count);

/**
 * A scan that is computed, `head`, `torso` (without a table) or `cube`, with `size` voxels along a side, 8 to 1024; 0 stands for 128. Waits for it.
 *
 * # Safety
 * `kind` is a string.
 */
struct LumivoxVolume *lumivox_volume_phantom(const char *kind,
                                             uint32_t size);

/**
 * A scan of voxels that are copied: `dimensions` along x (fastest), y and z, `bytes_per_voxel` 1 and 2 (unsigned) or 4
 * (float), value = stored * slope + intercept. `patient_from_voxel` holds three columns and an origin, in millimetres of
 * the patient (LPS); `modality` as in `LumivoxVolumeInfo`.
 *
 * # Safety
 * `dimensions` points to 3 numbers, `voxels` to `length` bytes, `patient_from_voxel` to 12 numbers.
 */
struct LumivoxVolume *lumivox_volume_new(const uint32_t *dimensions,
                                         uint32_t bytes_per_voxel,
                                         const void *voxels,
                                         uint64_t length,
                                         double slope,
                                         double intercept,
                                         const double *patient_from_voxel,
                                         uint32_t modality);

/**
 * Another handle of the same scan.
 *
 * # Safety
 * `volume` is a live handle.
 */
struct LumivoxVolume *lumivox_volume_clone(const struct LumivoxVolume *volume);

/**
 * Frees a handle of a scan.
 *
 * # Safety
 * `volume` is null, or a live handle.
 */
void lumivox_volume_free(struct LumivoxVolume *volume);

/**
 * What a scan is.
 *
 * # Safety
 * `volume` is a live handle, `out` can be written.
 */
int32_t lumivox_volume_info(const struct LumivoxVolume *volume, struct LumivoxVolumeInfo *out);

/**
 * The number of voxels in each of `bins` equal parts of the values `low..=high`. The first call of a scan looks at every
 * voxel.
 *
 * # Safety
 * `volume` is a live handle, `counts` can hold `bins` numbers.
 */
int32_t lumivox_volume_histogram(const struct LumivoxVolume *volume,
                                 double low,
                                 double high,
                                 uint32_t bins,
                                 float *counts);

/**
 * What is kept of how a scan was read, as JSON: `format`, `notes`, `series`; `null` where it was not.
 *
 * # Safety
 * `volume` is a live handle.
 */
struct LumivoxText *lumivox_volume_report(const struct LumivoxVolume *volume);

/**
 * Names the program `lumivox-codecs` that lies beside the library: it decodes JPEG-LS and JPEG 2000, so that a file which
 * crashes a decoder costs its slice and not the engine. Null, or a program that is not there: in this process.
 *
 * # Safety
 * `path` is null or a string.
 */
void lumivox_set_codec_program(const char *path);

/**
 * A transfer function of points in any order; those that are not finite are passed over. Without knots nothing is seen,
 * without stops it is white. The whole is widened by `window_scale` about its centre and moved by `shift`.
 *
 * # Safety
 * `knots` and `stops` point to so many.
 */
struct LumivoxTransferFunction *lumivox_transfer_function_new(const struct LumivoxOpacityKnot *knots,
                                                              uint32_t knot_count,
                                                              const struct LumivoxColorStop *stops,
                                                              uint32_t stop_count,
                                                              double shift,
                                                              double window_scale);

/**
 * Adds what holds where values change by `per_mm` per millimetre, moved and widened as the function itself is: a row of a
 * function of value and gradient. To be called before anything else has the function.
 *
 * # Safety
 * `function` is a live handle, `knots` and `stops` point to so many.
 */
int32_t lumivox_transfer_function_add_gradient(struct LumivoxTransferFunction *function,
                                               double per_mm,
                                               const struct LumivoxOpacityKnot *knots,
                                               uint32_t knot_count,
                                               const struct LumivoxColorStop *stops,
                                               uint32_t stop_count);

/**
 * How many rows for gradients it has; 0 for a function of the value alone.
 *
 * # Safety
 * `function` is a live handle.
 */
uint32_t lumivox_transfer_function_gradient_count(const struct LumivoxTransferFunction *function);

/**
 * A row for a gradient, which is written to `per_mm`, as a function of its own.
 *
 * # Safety
 * `function` is a live handle, `per_mm` can be written.
 */
struct LumivoxTransferFunction *lumivox_transfer_function_gradient(const struct LumivoxTransferFunction *function,
                                                                   uint32_t index,
                                                                   double *per_mm);

/**
 * Frees a transfer function.
 *
 * # Safety
 * `function` is null, or a live handle.
 */
void lumivox_transfer_function_free(struct LumivoxTransferFunction *function);

/**
 * `count` samples of it from the value `low` to `high`: linear RGB and opacity of each.
 *
 * # Safety
 * `function` is a live handle, `rgba` can hold `4 * count` numbers.
 */
int32_t lumivox_transfer_function_sample(const struct LumivoxTransferFunction *function,
                                         double low,
                                         double high,
                                         uint32_t count,
                                         float *rgba);

/**
 * A transfer function of Lumivox' or of UnityVolumeRendering's making.
 *
 * # Safety
 * `file` is a string.
 */
struct LumivoxTransferFunction *lumivox_transfer_function_load(const char *file);

/**
 * Writes it as Lumivox' JSON, with its rows for gradients.
 *
 * # Safety
 * `function` is a live handle, `file` a string.
 */
int32_t lumivox_transfer_function_save(const struct LumivoxTransferFunction *function,
                                       const char *file);

/**
 * Its opacity knots by rising value, as many as there is room for; returns how many there are.
 *
 * # Safety
 * `function` is a live handle, `out` can hold `capacity`.
 */
uint32_t lumivox_transfer_function_knots(const struct LumivoxTransferFunction *function,
                                         struct LumivoxOpacityKnot *out,
                                         uint32_t capacity);

/**
 * Its colour stops by rising value, as many as there is room for; returns how many there are.
 *
 * # Safety
 * `function` is a live handle, `out` can hold `capacity`.
 */
uint32_t lumivox_transfer_function_stops(const struct LumivoxTransferFunction *function,
                                         struct LumivoxColorStop *out,
                                         uint32_t capacity);

/**
 * How many presets there are.
 */
uint32_t lumivox_preset_count(void);

/**
 * The name of a preset; null beyond the last.
 */
const char *lumivox_preset_name(uint32_t index);

/**
 * What a preset shows; null beyond the last.
 */
const char *lumivox_preset_description(uint32_t index);

/**
 * The name of the preset that suits a scan.
 *
 * # Safety
 * `volume` is a live handle.
 */
const char *lumivox_preset_for(const struct LumivoxVolume *volume);

/**
 * The part of a scan that a preset is for, see `lumivox_part_find`; 0: all that is seen without it.
 *
 * # Safety
 * `name` is a string.
 */
uint32_t lumivox_preset_part(const char *name);

/**
 * The look of a preset. `volume` may be null for those of CT; others place themselves by its values. What a preset says
 * nothing of (filter, extinction space) is left as it is in `medium`.
 *
 * # Safety
 * `name` is a string, `volume` null or a live handle, `out` can be written.
 */
struct LumivoxTransferFunction *lumivox_preset(const char *name,
                                               const struct LumivoxVolume *volume,
                                               struct LumivoxMedium *out);

/**
 * A panorama of `width * height` linear RGB texels, rows from the top (straight up); the middle column is Unity's +z. They
 * are copied.
 *
 * # Safety
 * `rgb` points to `3 * width * height` numbers.
 */
struct LumivoxMap *lumivox_map_new(uint32_t width,
                                   uint32_t height,
                                   const float *rgb);

/**
 * A panorama from a Radiance (`.hdr`) file.
 *
 * # Safety
 * `file` is a string.
 */
struct LumivoxMap *lumivox_map_load(const char *file);

/**
 * Says which file a map was read from, which scene documents name; otherwise they come with a copy of it.
 *
 * # Safety
 * `map` is a live handle that nothing shows yet, `file` a string.
 */
int32_t lumivox_map_set_file(struct LumivoxMap *map,
                             const char *file);

/**
 * The file that a map was read from; empty where that is not known.
 *
 * # Safety
 * `map` is a live handle.
 */
struct LumivoxText *lumivox_map_file(const struct LumivoxMap *map);

/**
 * The texels of a map, as `lumivox_map_new` takes them, valid until it is freed; writes its width and height.
 *
 * # Safety
 * `map` is a live handle, `size` can hold two numbers.
 */
const float *lumivox_map_texels(const struct LumivoxMap *map,
                                uint32_t *size);

/**
 * Frees a map.
 *
 * # Safety
 * `map` is null, or a live handle.
 */
void lumivox_map_free(struct LumivoxMap *map);

/**
 * A label map of voxels that are copied: values of labels, 0 where there is none, `dimensions` along x (fastest), y and z;
 * `patient_from_voxel` as in `lumivox_volume_new`.
 *
 * # Safety
 * `dimensions` points to 3 numbers, `voxels` to `length` bytes, `patient_from_voxel` to 12 numbers, `labels` to `count` labels
 * and `names` to as many strings.
 */
struct LumivoxVolume *lumivox_labels_new(const uint32_t *dimensions,
                                         const uint8_t *voxels,
                                         uint64_t length,
                                         const double *patient_from_voxel,
                                         const struct LumivoxLabel *labels,
                                         const char *const *names,
                                         uint32_t count);

/**
 * How many labels a label map has; -1 for a scan that is none.
 *
 * # Safety
 * `map` is a live handle.
 */
int32_t lumivox_labels_count(const struct LumivoxVolume *map);

/**
 * The labels of a map by rising value, as many as there is room for.
 *
 * # Safety
 * `map` is a live handle, `out` can hold `capacity`.
 */
int32_t lumivox_labels_list(const struct LumivoxVolume *map,
                            struct LumivoxLabel *out,
                            uint32_t capacity);

/**
 * What the label at a place of that list is called.
 *
 * # Safety
 * `map` is a live handle.
 */
struct LumivoxText *lumivox_labels_name(const struct LumivoxVolume *map, uint32_t index);

/**
 * The share of a map's labelled voxels that lie in a scan, 0 where they are of another patient or place; -1 where nothing is
 * labelled. Some of the voxels are looked at.
 *
 * # Safety
 * `map` and `volume` are live handles.
 */
double lumivox_labels_share_in(const struct LumivoxVolume *map,
                               const struct LumivoxVolume *volume);

/**
 * Looks of the labels of a map; of those that are not listed, the default.
 *
 * # Safety
 * `map` is a live handle, `styles` points to `count` of them, whose transfer functions are null or live handles.
 */
struct LumivoxLabelling *lumivox_labelling_new(const struct LumivoxVolume *map,
                                               const struct LumivoxLabelStyle *styles,
                                               uint32_t count);

/**
 * Frees looks of labels.
 *
 * # Safety
 * `labelling` is null, or a live handle.
 */
void lumivox_labelling_free(struct LumivoxLabelling *labelling);

/**
 * Whether a scan's skin was found: 0 nobody has looked, 1 it was, 2 none is there for sure, and nothing is peeled.
 *
 * # Safety
 * `volume` is a live handle.
 */
uint32_t lumivox_volume_skin(const struct LumivoxVolume *volume);

/**
 * Reads the headers of one file of any format, a folder, a zip archive, or several DICOM files. The job gives a study and
 * its report.
 *
 * # Safety
 * `paths` points to `count` strings, `options` is null or points to options.
 */
struct LumivoxJob *lumivox_import_scan(const char *const *paths,
                                       uint32_t count,
                                       const struct LumivoxImportOptions *options);

/**
 * Loads a scan; from `study`, whose headers are not read again, where it is not null. The job gives the scan and the
 * report. A label map is the first of `paths`, whatever the study.
 *
 * # Safety
 * As [`lumivox_import_scan`]; `study` is null or a live handle.
 */
struct LumivoxJob *lumivox_import_load(const char *const *paths,
                                       uint32_t count,
                                       const struct LumivoxImportOptions *options,
                                       const struct LumivoxStudy *study);

/**
 * Finds by itself what a scan shows: of a CT the body, lungs, airways and gas, table and clothes; of an MR the body. The
 * job gives a label map, whose report says how sure it is.
 *
 * # Safety
 * `volume` is a live handle.
 */
struct LumivoxJob *lumivox_labels_find(const struct LumivoxVolume *volume);

/**
 * Finds the skin of a scan, for what is peeled of it: see `lumivox_volume_skin`. The scan keeps it.
 *
 * # Safety
 * `volume` is a live handle.
 */
struct LumivoxJob *lumivox_skin_find(const struct LumivoxVolume *volume);

/**
 * What of a scan is seen in place of the patient: 1 all that was scanned, 2 the airways alone, 3 the vessels of the lungs
 * alone. The job gives a scan for `LumivoxInstance::part`; none where there is no such part, or it is not found for sure.
 *
 * # Safety
 * `volume` is a live handle.
 */
struct LumivoxJob *lumivox_part_find(const struct LumivoxVolume *volume,
                                     uint32_t part);

/**
 * A picture of the middle slice of a series of a study, counted from 0, at most `side` pixels wide and high.
 *
 * # Safety
 * `study` is a live handle.
 */
struct LumivoxJob *lumivox_study_thumbnail(const struct LumivoxStudy *study,
                                           uint32_t series,
                                           uint32_t side);

/**
 * A picture of a scan from the front, at most `side` pixels (256 or fewer) wide and high, transparent where nothing is
 * seen: as a preset shows it, or, where `preset` is null, as the one that suits it.
 *
 * # Safety
 * `volume` is a live handle, `preset` null or a string.
 */
struct LumivoxJob *lumivox_volume_picture(const struct LumivoxVolume *volume,
                                          const char *preset,
                                          uint32_t side);

/**
 * Frees a study.
 *
 * # Safety
 * `study` is null, or a live handle.
 */
void lumivox_study_free(struct LumivoxStudy *study);

/**
 * As `lumivox_volume_phantom`, without waiting.
 *
 * # Safety
 * `kind` is a string.
 */
struct LumivoxJob *lumivox_phantom_start(const char *kind, uint32_t size);

/**
 * Stores a scan as a file that opens at once; whole, or not at all.
 *
 * # Safety
 * `volume` is a live handle, `file` a string.
 */
struct LumivoxJob *lumivox_volume_save(const struct LumivoxVolume *volume, const char *file);

/**
 * Copies the file of a stored scan without what tells where the scan was read from: for a game that is given to others.
 *
 * # Safety
 * `from` and `to` are strings.
 */
int32_t lumivox_stored_copy_nameless(const char *from,
                                     const char *to);

/**
 * Opens a stored scan.
 *
 * # Safety
 * `file` is a string.
 */
struct LumivoxJob *lumivox_volume_open(const char *file);

/**
 * Opens a stored scan whose file is in memory, for platforms that keep a game's files in an archive. The bytes are
 * copied before this returns.
 *
 * # Safety
 * `data` points to `length` bytes.
 */
struct LumivoxJob *lumivox_volume_open_bytes(const void *data,
                                             uint64_t length);

/**
 * How far a job is. `out` may be null.
 *
 * # Safety
 * `job` is a live handle, `out` null or can be written.
 */
enum LumivoxJobState lumivox_job_poll(const struct LumivoxJob *job, struct LumivoxProgress *out);

/**
 * Asks a job to stop. It says that it was once it has.
 *
 * # Safety
 * `job` is null, or a live handle.
 */
void lumivox_job_cancel(const struct LumivoxJob *job);

/**
 * Frees a job; one that is under way is asked to stop, and not waited for.
 *
 * # Safety
 * `job` is null, or a live handle.
 */
void lumivox_job_free(struct LumivoxJob *job);

/**
 * Why a job has failed; empty if it has not.
 *
 * # Safety
 * `job` is a live handle.
 */
struct LumivoxText *lumivox_job_error(const struct LumivoxJob *job);

/**
 * The scan that a job has made.
 *
 * # Safety
 * `job` is a live handle.
 */
struct LumivoxVolume *lumivox_job_take_volume(struct LumivoxJob *job);

/**
 * The study that a job has made.
 *
 * # Safety
 * `job` is a live handle.
 */
struct LumivoxStudy *lumivox_job_take_study(struct LumivoxJob *job);

/**
 * What an import found and did, as JSON; null for jobs that are none.
 *
 * # Safety
 * `job` is a live handle.
 */
struct LumivoxText *lumivox_job_report(const struct LumivoxJob *job);

/**
 * The picture that a job has made; valid until the job is freed.
 *
 * # Safety
 * `job` is a live handle, `out` can be written.
 */
int32_t lumivox_job_picture(const struct LumivoxJob *job, struct LumivoxPicture *out);

/**
 * Jobs whose threads still run, freed ones too.
 */
uint32_t lumivox_jobs_running(void);

/**
 * Stops all jobs and waits for them: before the library is unloaded.
 */
void lumivox_jobs_stop_all(void);

/**
 * Opens a scene document. The job gives the scene.
 *
 * # Safety
 * `file` is a string.
 */
struct LumivoxJob *lumivox_scene_open(const char *file, uint32_t allow_outside_data);

/**
 * The scene that a job has opened.
 *
 * # Safety
 * `job` is a live handle.
 */
struct LumivoxScene *lumivox_job_take_scene(struct LumivoxJob *job);

/**
 * Whether a file is a scene document, by how it begins: 1 or 0; -1 where it cannot be read.
 *
 * # Safety
 * `file` is a string.
 */
int32_t lumivox_scene_is_one(const char *file);

/**
 * Frees a scene. What was taken of it goes on.
 *
 * # Safety
 * `scene` is null, or a live handle.
 */
void lumivox_scene_free(struct LumivoxScene *scene);

/**
 * What people should know of a scene, a line each; empty where all is well.
 *
 * # Safety
 * `scene` is a live handle.
 */
struct LumivoxText *lumivox_scene_notes(const struct LumivoxScene *scene);

/**
 * The document of a scene as it was opened, written out: what 32 bits would round of it is kept in this, for
 * `lumivox_stage_save_world`. It names no files: players of a built game need not know whose they were.
 *
 * # Safety
 * `scene` is a live handle.
 */
struct LumivoxText *lumivox_scene_document(const struct LumivoxScene *scene);

/**
 * The files that a scene names, a line each, as seen from where the program is.
 *
 * # Safety
 * `scene` is a live handle.
 */
struct LumivoxText *lumivox_scene_files(const struct LumivoxScene *scene);

/**
 * How many volumes a scene has.
 *
 * # Safety
 * `scene` is a live handle.
 */
uint32_t lumivox_scene_volume_count(const struct LumivoxScene *scene);

/**
 * A volume's scan.
 *
 * # Safety
 * `scene` is a live handle.
 */
struct LumivoxVolume *lumivox_scene_volume(const struct LumivoxScene *scene, uint32_t index);

/**
 * A volume's label map; null where it has none, and `lumivox_last_error` then says nothing.
 *
 * # Safety
 * `scene` is a live handle.
 */
struct LumivoxVolume *lumivox_scene_labels(const struct LumivoxScene *scene, uint32_t index);

/**
 * A volume's transfer function.
 *
 * # Safety
 * `scene` is a live handle.
 */
struct LumivoxTransferFunction *lumivox_scene_transfer_function(const struct LumivoxScene *scene,
                                                                uint32_t index);

/**
 * How a volume stands, without handles; `clip_count` shapes cut it, see `lumivox_scene_clip`.
 *
 * # Safety
 * `scene` is a live handle, `out` and `pose` can be written.
 */
int32_t lumivox_scene_instance(const struct LumivoxScene *scene,
                               uint32_t index,
                               struct LumivoxInstance *out,
                               struct LumivoxPose *pose);

/**
 * A shape that cuts a volume, and where it stands in the volume's object.
 *
 * # Safety
 * `scene` is a live handle, `out` and `pose` can be written.
 */
int32_t lumivox_scene_clip(const struct LumivoxScene *scene,
                           uint32_t index,
                           uint32_t clip,
                           struct LumivoxClipShape *out,
                           struct LumivoxPose *pose);

/**
 * How many labels of a volume have a style.
 *
 * # Safety
 * `scene` is a live handle.
 */
uint32_t lumivox_scene_style_count(const struct LumivoxScene *scene, uint32_t index);

/**
 * A style of a volume's labels; its transfer function is the scene's.
 *
 * # Safety
 * `scene` is a live handle, `out` can be written.
 */
int32_t lumivox_scene_style(const struct LumivoxScene *scene,
                            uint32_t index,
                            uint32_t style,
                            struct LumivoxLabelStyle *out);

/**
 * From where a scene is seen, its image and display.
 *
 * # Safety
 * `scene` is a live handle, `out` and `pose` can be written.
 */
int32_t lumivox_scene_view(const struct LumivoxScene *scene,
                           struct LumivoxSavedView *out,
                           struct LumivoxPose *pose);

/**
 * How many lights a scene has.
 *
 * # Safety
 * `scene` is a live handle.
 */
uint32_t lumivox_scene_light_count(const struct LumivoxScene *scene);

/**
 * A light of a scene.
 *
 * # Safety
 * `scene` is a live handle, `out` and `pose` can be written.
 */
int32_t lumivox_scene_light(const struct LumivoxScene *scene,
                            uint32_t index,
                            struct LumivoxLight *out,
                            struct LumivoxPose *pose);

/**
 * The light around a scene; its map is the scene's.
 *
 * # Safety
 * `scene` is a live handle, `out` can be written.
 */
int32_t lumivox_scene_environment(const struct LumivoxScene *scene, struct LumivoxEnvironment *out);

/**
 * Writes what is in a world, seen so, as a scene document; whole, or not at all. A sky that came from no file is written
 * beside it as OpenEXR, to the bit. `radiance` is what is as bright in this engine as a radiance of 1 in documents. `opened` is
 * the text of `lumivox_scene_document` where the view is one of a scene that was opened, else null or empty: numbers that are
 * still those of that scene, as far as 32 bits tell, are written with all their digits.
 *
 * # Safety
 * `stage` is a live handle, `view` points to a view, `opened` is null or a string, `file` is a string.
 */
int32_t lumivox_stage_save_world(const struct LumivoxStage *stage,
                                 uint64_t world,
                                 const struct LumivoxSavedView *view,
                                 float radiance,
                                 const char *opened,
                                 const char *file);

/**
 * How many kernels there are, in all variants: more than Unity's half has.
 */
uint32_t lumivox_kernel_count(void);

/**
 * The name of a step's kernel, which is that of its file; null beyond the last.
 */
const char *lumivox_kernel_name(uint32_t index);

/**
 * The steps of a recording, in order; valid until it is finished.
 *
 * # Safety
 * `recording` is a live handle, `count` can be written.
 */
const struct LumivoxStep *lumivox_recording_steps(const struct LumivoxRecording *recording,
                                                  uint32_t *count);

/**
 * A stage for a device.
 *
 * # Safety
 * `limits` points to limits.
 */
struct LumivoxStage *lumivox_stage_new(const struct LumivoxDeviceLimits *limits);

/**
 * Frees a stage. What the device holds for it is the executor's to free.
 *
 * # Safety
 * `stage` is null, or a live handle.
 */
void lumivox_stage_free(struct LumivoxStage *stage);

/**
 * The engine begins a frame.
 *
 * # Safety
 * `stage` is a live handle.
 */
void lumivox_stage_begin_frame(struct LumivoxStage *stage);

/**
 * What is in a world from now on. Cheap where that is what was there.
 *
 * # Safety
 * `stage` is a live handle, the others point to so many, with live handles in them.
 */
int32_t lumivox_stage_set_world(struct LumivoxStage *stage,
                                uint64_t world,
                                const struct LumivoxInstance *instances,
                                uint32_t instance_count,
                                const struct LumivoxClipShape *clips,
                                uint32_t clip_count,
                                const struct LumivoxLight *lights,
                                uint32_t light_count,
                                const struct LumivoxEnvironment *environment);

/**
 * Records what brings a world's copy on the device up to date; null where there is nothing to do, and
 * `lumivox_last_error` then says nothing.
 *
 * # Safety
 * `stage` is a live handle.
 */
struct LumivoxRecording *lumivox_stage_record_world(struct LumivoxStage *stage,
                                                    uint64_t world,
                                                    uint32_t at_once);

/**
 * Records a view's frame of a world; null where there is nothing to draw yet, and `lumivox_last_error` then says nothing.
 *
 * # Safety
 * `stage` is a live handle, `frame` points to a frame, `out` can be written.
 */
struct LumivoxRecording *lumivox_stage_record_view(struct LumivoxStage *stage,
                                                   uint64_t view,
                                                   uint64_t world,
                                                   const struct LumivoxViewFrame *frame,
                                                   struct LumivoxViewStatus *out);

/**
 * Tells what became of a recording, one of `LumivoxOutcome`, and frees it. To be called for each, in the order in which
 * they were recorded; `why` says in words what was refused, or is null.
 *
 * # Safety
 * `stage` and `recording` are live handles, `why` is null or a string.
 */
int32_t lumivox_recording_finish(struct LumivoxStage *stage,
                                 struct LumivoxRecording *recording,
                                 uint32_t outcome,
                                 const char *why);

/**
 * Hands over what a read-back has brought; `length` 0 if it got lost. Those of a ticket come in the order of their steps.
 *
 * # Safety
 * `stage` is a live handle, `bytes` points to `length` bytes.
 */
void lumivox_stage_feedback(struct LumivoxStage *stage,
                            uint64_t ticket,
                            const void *bytes,
                            uint64_t length);

/**
 * Tells how long the GPU took for the view's frame of a ticket, where the engine knows.
 *
 * # Safety
 * `stage` is a live handle.
 */
void lumivox_stage_measured(struct LumivoxStage *stage, uint64_t ticket, double milliseconds);

/**
 * How far a view is, with the read-backs that have come; -1 for one that was never recorded.
 *
 * # Safety
 * `stage` is a live handle, `out` can be written.
 */
int32_t lumivox_stage_view_status(const struct LumivoxStage *stage,
                                  uint64_t view,
                                  struct LumivoxViewStatus *out);

/**
 * Records that everything is freed that belongs to no view or world named; null where there is nothing.
 *
 * # Safety
 * `stage` is a live handle, the others point to so many.
 */
struct LumivoxRecording *lumivox_stage_sweep(struct LumivoxStage *stage,
                                             const uint64_t *views,
                                             uint32_t view_count,
                                             const uint64_t *worlds,
                                             uint32_t world_count);

/**
 * Bytes of voxels that are on the device.
 *
 * # Safety
 * `stage` is a live handle.
 */
uint64_t lumivox_stage_voxel_bytes(const struct LumivoxStage *stage);

/**
 * Bytes of the light on the device that is kept in volumes.
 *
 * # Safety
 * `stage` is a live handle.
 */
uint64_t lumivox_stage_light_bytes(const struct LumivoxStage *stage);

/**
 * At what part of its resolution a scan is shown: `1 / factor` along a side, 0 where none of it is there; `arriving` is 1
 * while finer voxels are on their way.
 *
 * # Safety
 * `stage` and `volume` are live handles, the others can be written.
 */
int32_t lumivox_volume_resolution(const struct LumivoxStage *stage,
                                  const struct LumivoxVolume *volume,
                                  uint32_t *factor,
                                  uint32_t *arriving);

/**
 * How far a world is: 0 there, 1 arriving, 2 the one before is shown, 3 nothing is there.
 *
 * # Safety
 * `stage` is a live handle.
 */
uint32_t lumivox_stage_world_progress(const struct LumivoxStage *stage, uint64_t world);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* LUMIVOX_UNITY_H */
