// Made by `cargo xtask unity-border` of crates/lumivox-unity.
using System;
using System.Runtime.InteropServices;
using UnityEngine;

namespace Lumivox.Native
{
    /// <summary>What the library and this package must have in common.</summary>
    internal static unsafe class Abi
    {
        /// <summary>Raised with the library's own.</summary>
        public const uint Version = 8;

        /// <summary>Bytes of the structs, in their order.</summary>
        public static uint[] Sizes => new[]
        {
            (uint)sizeof(VolumeInfo),
            (uint)sizeof(OpacityKnot),
            (uint)sizeof(ColorStop),
            (uint)sizeof(Surface),
            (uint)sizeof(Medium),
            (uint)sizeof(ClipShape),
            (uint)sizeof(LabelInfo),
            (uint)sizeof(LabelStyle),
            (uint)sizeof(Instance),
            (uint)sizeof(LightSource),
            (uint)sizeof(Surroundings),
            (uint)sizeof(ObjectPose),
            (uint)sizeof(SavedView),
            (uint)sizeof(DeviceLimits),
            (uint)sizeof(ViewFrame),
            (uint)sizeof(ViewStatus),
            (uint)sizeof(Slice),
            (uint)sizeof(Step),
            (uint)sizeof(Progress),
            (uint)sizeof(ImportOptions),
            (uint)sizeof(Picture),
        };
    }

    /// <summary>What a scan is and how it lies in its object.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal unsafe partial struct VolumeInfo
    {
        /// <summary>Voxels along the scan's own x, y and z axes.</summary>
        public fixed uint dimensions[3];
        /// <summary>Bytes of a voxel: 1, 2 or 4.</summary>
        public uint bytesPerVoxel;
        /// <summary>Millimetres between neighbouring voxels along those axes.</summary>
        public fixed double spacingMm[3];
        /// <summary>Smallest and largest value, in the scan's unit.</summary>
        public fixed double valueRange[2];
        /// <summary>The corners of what it fills along the object's axes, in metres.</summary>
        public Vector3 boundsMin;
        /// <summary>The other corner.</summary>
        public Vector3 boundsMax;
        /// <summary>From clip coordinates, 0 to 1 along each edge of its box, to the object's metres.</summary>
        public Matrix4x4 objectFromClip;
        /// <summary>From the patient's millimetres (LPS) to the object's metres.</summary>
        public Matrix4x4 objectFromPatient;
        /// <summary>0 other, 1 CT, 2 MR, 3 PET.</summary>
        public uint modality;
        /// <summary>1 where values are Hounsfield units.</summary>
        public uint isHounsfield;
        /// <summary>1 where something that lies around the patient was put aside: part 1 of `lumivox_part_find` shows it.</summary>
        public uint hasSurroundings;
        /// <summary>Nothing.</summary>
        public uint padding;
        /// <summary>The unit's name in UTF-8, ended by 0: `HU`, `SUV`; empty where it is not known.</summary>
        public fixed byte unit[16];
    }

    /// <summary>A point of an opacity curve.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal partial struct OpacityKnot
    {
        /// <summary>In the scan's unit.</summary>
        public double value;
        /// <summary>0 to 1.</summary>
        public double opacity;
        /// <summary>How the curve leaves towards the next: 0 straight, 1 slowly at both ends.</summary>
        public uint ease;
        /// <summary>Nothing.</summary>
        public uint padding;
    }

    /// <summary>A point of a colour ramp.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal partial struct ColorStop
    {
        /// <summary>In the scan's unit.</summary>
        public double value;
        /// <summary>Linear, 0 to 1.</summary>
        public double red;
        /// <summary>Linear, 0 to 1.</summary>
        public double green;
        /// <summary>Linear, 0 to 1.</summary>
        public double blue;
    }

    /// <summary>How boundaries inside a scan reflect.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal partial struct Surface
    {
        /// <summary>How strongly boundaries reflect like surfaces, 0 to 1.</summary>
        public float strength;
        /// <summary>How steep a boundary must be, in value units per millimetre; 0: as suits the scan, of a label's the instance's.</summary>
        public float gradient;
        /// <summary>Width of the highlights, 0 glossy to 1 matt.</summary>
        public float roughness;
        /// <summary>Share of the light that the highlights reflect seen head-on, 0 to 1.</summary>
        public float specular;
        /// <summary>How much of the medium's colour the highlights have, 0 to 1, as of metal.</summary>
        public float metallic;
    }

    /// <summary>How light and a scan meet. The defaults are those of the component.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal partial struct Medium
    {
        /// <summary>Multiplies the extinction of 1 per millimetre at an opacity of 1; 0 to 1000.</summary>
        public float density;
        /// <summary>Fraction of the light that survives each scattering, 0 to 1.</summary>
        public float albedo;
        /// <summary>Where light goes when it scatters, -0.99 (back) to 0.99 (onwards).</summary>
        public float anisotropy;
        /// <summary>Scatterings after which light is no longer followed, 1 to 1000.</summary>
        public uint maxBounces;
        /// <summary>0 nearest, 1 trilinear, 2 tricubic, 3 smooth.</summary>
        public uint filter;
        /// <summary>What a millimetre of extinction is measured in: 0 the scan's own, 1 the scene's.</summary>
        public uint extinctionSpace;
        /// <summary>How its boundaries reflect.</summary>
        public Surface surface;
    }

    /// <summary>A shape that cuts instances open: what it keeps of them is seen.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal partial struct ClipShape
    {
        /// <summary>The shape's `Transform.localToWorldMatrix`.</summary>
        public Matrix4x4 worldFromShape;
        /// <summary>0 a plane, which keeps the side of the shape's +y; 1 a cube of one metre, 2 a ball of one metre across, both about its origin.</summary>
        public uint kind;
        /// <summary>1: what it would keep is cut away, and the rest kept.</summary>
        public uint inverted;
    }

    /// <summary>A label of a map.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal partial struct LabelInfo
    {
        /// <summary>The value of its voxels, 1 to 255.</summary>
        public uint value;
        /// <summary>Linear RGB, 0 to 1.</summary>
        public Vector3 color;
        /// <summary>Of all its voxels, in ml; of what is made, nothing.</summary>
        public double milliliters;
    }

    /// <summary>How the voxels of one label look.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal partial struct LabelStyle
    {
        /// <summary>Its value; 0 is what has no label.</summary>
        public uint value;
        /// <summary>1 where they are seen.</summary>
        public uint visible;
        /// <summary>1 where `color` takes the place of the transfer function's colours.</summary>
        public uint painted;
        /// <summary>1 where clip shapes cut them, 0 where they are spared.</summary>
        public uint clipped;
        /// <summary>Linear RGB, 0 to 1.</summary>
        public Vector3 color;
        /// <summary>Multiplies their opacity, 0 to 1.</summary>
        public float opacity;
        /// <summary>In place of the instance's; below 0: that.</summary>
        public float density;
        /// <summary>1 where the surface below takes the place of the instance's.</summary>
        public uint hasSurface;
        /// <summary>How their boundaries reflect.</summary>
        public Surface surface;
        /// <summary>In place of the instance's, without rows for gradients; null: that.</summary>
        public IntPtr transferFunction;
    }

    /// <summary>A scan as it stands in a world.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal partial struct Instance
    {
        /// <summary>The scan; an instance without one is passed over.</summary>
        public IntPtr volume;
        /// <summary>What of it is seen in place of the patient, of `lumivox_part_find`; null: the scan as it is.</summary>
        public IntPtr part;
        /// <summary>Opacity and colour of its values; null: those of the preset that suits the scan.</summary>
        public IntPtr transferFunction;
        /// <summary>What its parts are and how they look; null: it has none.</summary>
        public IntPtr labelling;
        /// <summary>The object's `Transform.localToWorldMatrix`.</summary>
        public Matrix4x4 worldFromObject;
        /// <summary>The corner of what is kept with the smallest coordinates, as fractions of its box, 0 to 1.</summary>
        public Vector3 clipMin;
        /// <summary>The opposite corner. Where it lies before `clip_min`, what is between them is kept.</summary>
        public Vector3 clipMax;
        /// <summary>`1 &lt;&lt; GameObject.layer`.</summary>
        public uint layers;
        /// <summary>The rest of its look.</summary>
        public Medium medium;
        /// <summary>Millimetres below the skin that are taken off, once `lumivox_skin_find` has found it.</summary>
        public float peelMm;
        /// <summary>The first of the clip shapes of its world that cut it.</summary>
        public uint firstClip;
        /// <summary>How many do.</summary>
        public uint clipCount;
    }

    /// <summary>A light that reaches volumes.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal partial struct LightSource
    {
        /// <summary>0 directional, 1 point, 2 spot.</summary>
        public uint kind;
        /// <summary>`Light.cullingMask`: it lights the instances that share a layer with it.</summary>
        public uint layers;
        /// <summary>Of a point or a spot.</summary>
        public Vector3 position;
        /// <summary>Where the light of a sun or a spot travels to.</summary>
        public Vector3 direction;
        /// <summary>Linear RGB: the irradiance of a sun, the radiant intensity of a lamp. A white surface that faces a sun of irradiance pi has a radiance of 1, which is what Unity gives an intensity of 1.</summary>
        public Vector3 strength;
        /// <summary>Of a lamp, in metres; a sun's is an angle in radians.</summary>
        public float radius;
        /// <summary>Metres after which a lamp does not shine; infinity: it has no end.</summary>
        public float range;
        /// <summary>How a lamp's light falls off: 0 as URP and HDRP have it (by `decay`, ending smoothly at the range), 1 as the built-in pipeline has it.</summary>
        public uint falloff;
        /// <summary>The power of the distance by which a lamp's light falls off; 0 stands for 2, which is physical.</summary>
        public float decay;
        /// <summary>Angle in radians from a spot's axis to the edge of its cone.</summary>
        public float outerHalfAngle;
        /// <summary>Angle within which a spot is as bright as on its axis.</summary>
        public float innerHalfAngle;
        /// <summary>1: a spot falls off by the power `attenuation` of the way to its edge, as Godot's, and not from the inner angle on.</summary>
        public uint hasAttenuation;
        /// <summary>See `has_attenuation`.</summary>
        public float attenuation;
    }

    /// <summary>The light from all around.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal partial struct Surroundings
    {
        /// <summary>0 one colour, 1 a gradient, 2 Lumivox' studio, 3 a map.</summary>
        public uint kind;
        /// <summary>Linear RGB radiance: of the one colour, or from straight up.</summary>
        public Vector3 zenith;
        /// <summary>Of a gradient, from the horizon.</summary>
        public Vector3 horizon;
        /// <summary>Of a gradient, from straight down.</summary>
        public Vector3 nadir;
        /// <summary>Turns it about the vertical axis, in radians, as `Transform.eulerAngles.y` turns an object.</summary>
        public float rotation;
        /// <summary>Multiplies the radiance.</summary>
        public float strength;
        /// <summary>Of a map; null is darkness.</summary>
        public IntPtr map;
    }

    /// <summary>Where an object stands: what its `Transform` is set to.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal partial struct ObjectPose
    {
        /// <summary>Metres.</summary>
        public Vector3 position;
        /// <summary>A quaternion: x, y, z, w.</summary>
        public Quaternion rotation;
        /// <summary>Along its own axes.</summary>
        public Vector3 scale;
    }

    /// <summary>From where a scene of a file is seen, the image that is rendered, and how light becomes pixels.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal partial struct SavedView
    {
        /// <summary>`Camera.cameraToWorldMatrix`.</summary>
        public Matrix4x4 worldFromCamera;
        /// <summary>Degrees between the bottom and the top of the image.</summary>
        public float fieldOfView;
        /// <summary>Pixels across.</summary>
        public uint width;
        /// <summary>Pixels down.</summary>
        public uint height;
        /// <summary>Paths per pixel; 0: not said.</summary>
        public uint samples;
        /// <summary>The same seed gives the same noise.</summary>
        public uint seed;
        /// <summary>Relative noise at which it is done before; 0: by its samples alone.</summary>
        public float noise;
        /// <summary>1 where the noise that is left is smoothed out.</summary>
        public uint denoise;
        /// <summary>What stands behind: 0 nothing, 1 the light, 2 `color`.</summary>
        public uint background;
        /// <summary>sRGB, 0 to 1.</summary>
        public Vector3 color;
        /// <summary>Stops brighter.</summary>
        public float exposure;
        /// <summary>The curve from light to pixels: 0 none, 1 AgX, 2 ACES.</summary>
        public uint tone;
        /// <summary>Brightens the mid-tones above 1.</summary>
        public float gamma;
    }

    /// <summary>What the GPU can do, as `SystemInfo` tells it.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal partial struct DeviceLimits
    {
        /// <summary>`maxTexture3DSize`.</summary>
        public uint maxTexture3d;
        /// <summary>`maxTextureSize`.</summary>
        public uint maxTexture2d;
        /// <summary>`maxGraphicsBufferSize`.</summary>
        public ulong maxBufferBytes;
        /// <summary>Bytes that volumes may fill on it, with the light that is kept in them; 0: as many as there is room for.</summary>
        public ulong voxelBytes;
        /// <summary>1 where R16_UNorm textures can be filtered and written.</summary>
        public uint unorm16;
        /// <summary>1 for a device in software, whose dispatches take long.</summary>
        public uint isSoftware;
    }

    /// <summary>One view of one frame: a camera, or an eye of a headset.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal unsafe partial struct ViewFrame
    {
        /// <summary>`Camera.cameraToWorldMatrix`, or the inverse of an eye's view matrix.</summary>
        public Matrix4x4 worldFromCamera;
        /// <summary>The projection with which the depth buffer was filled, with the image's first row in memory at y = -1 and the depth that the buffer holds in z: `GL.GetGPUProjectionMatrix`, its second row negated where the first row is at 1.</summary>
        public Matrix4x4 clipFromCamera;
        /// <summary>Pixels across and down.</summary>
        public fixed uint size[2];
        /// <summary>1 where the host's depth ends rays.</summary>
        public uint hasDepth;
        /// <summary>What the depth texture holds where nothing was drawn: 0 where z is reversed, else 1.</summary>
        public float depthClear;
        /// <summary>1 where the camera is shifted by part of a pixel in each frame.</summary>
        public uint isJittered;
        /// <summary>1 where volumes write their depth.</summary>
        public uint writeDepth;
        /// <summary>Multiplies the light.</summary>
        public float exposure;
        /// <summary>Linear RGB radiance from everywhere, besides the world's light.</summary>
        public Vector3 ambient;
        /// <summary>Pixels traced per pixel of the view along a side, 0.1 to 1.</summary>
        public float resolutionScale;
        /// <summary>Samples per pixel after which the image is done.</summary>
        public uint targetSamples;
        /// <summary>Relative noise at which it is done before; 0: by its samples alone.</summary>
        public float targetNoise;
        /// <summary>Milliseconds of the GPU's time in a frame.</summary>
        public float frameBudgetMs;
        /// <summary>1 where noise is filtered out of what is shown at rest.</summary>
        public uint denoise;
        /// <summary>1 where light is kept in the volumes, for pictures while something moves.</summary>
        public uint keptLight;
        /// <summary>0 none, 1 linear, 2 exponential, 3 exponential squared: `RenderSettings.fogMode`.</summary>
        public uint fog;
        /// <summary>Linear RGB of the fog.</summary>
        public Vector3 fogColor;
        /// <summary>Metres where linear fog begins.</summary>
        public float fogStart;
        /// <summary>Metres where linear fog hides everything.</summary>
        public float fogEnd;
        /// <summary>Of exponential fog, per metre.</summary>
        public float fogDensity;
        /// <summary>1 where this frame must show its world whole, however long that takes: none follows.</summary>
        public uint atOnce;
    }

    /// <summary>How far a view's image is.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal partial struct ViewStatus
    {
        /// <summary>Samples that every pixel has.</summary>
        public uint samples;
        /// <summary>1 where there is nothing more to trace unless something changes.</summary>
        public uint isConverged;
        /// <summary>1 while that may turn out to be wrong: a host that draws on demand goes on until it is 0.</summary>
        public uint awaitsFeedback;
        /// <summary>Pixels whose paths the driver ended before their time.</summary>
        public uint lostPixels;
        /// <summary>Pixel samples that this frame traces.</summary>
        public ulong pixelSamples;
        /// <summary>Bytes of the GPU's memory that light takes which is kept for this view; 0 where none is.</summary>
        public ulong lightBytes;
        /// <summary>The names under which the steps mean the host's depth to read, its colour, and its depth to write.</summary>
        public ulong depth;
        /// <summary>See `depth`.</summary>
        public ulong color;
        /// <summary>See `depth`.</summary>
        public ulong writtenDepth;
        /// <summary>Whom read-backs of these steps belong to.</summary>
        public ulong ticket;
    }

    /// <summary>Bytes of the library's.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal unsafe partial struct Slice
    {
        /// <summary>The first.</summary>
        public byte* data;
        /// <summary>How many.</summary>
        public ulong length;
    }

    /// <summary>What a step does.</summary>
    internal enum StepKind : uint
    {
        /// <summary>Make the storage buffer `id` of `length` bytes, zeros.</summary>
        CreateBuffer = 0,
        /// <summary>Make the texture `id` of `size` and `format`; 2D where the last of `size` is 0.</summary>
        CreateTexture = 1,
        /// <summary>Write `data` at byte `offset` of buffer `id`.</summary>
        WriteBuffer = 2,
        /// <summary>Write `data`, without padding, into the box of `size` at `origin` of texture `id`.</summary>
        WriteTexture = 3,
        /// <summary>Copy the box of `size` at `origin` of texture `from` to the same place of texture `id`.</summary>
        CopyTexture = 4,
        /// <summary>Fill buffer `id` with zeros.</summary>
        ClearBuffer = 5,
        /// <summary>Run `kernel` in `workgroups`.</summary>
        Dispatch = 6,
        /// <summary>Draw one triangle with `kernel` over texture `id`.</summary>
        Draw = 7,
        /// <summary>Bring `length` bytes from `offset` of buffer `id` back, to `lumivox_stage_feedback`.</summary>
        ReadBuffer = 8,
        /// <summary>Nothing uses `id` any more, once what was asked for before has been done.</summary>
        Free = 9,
    }

    /// <summary>One step of a recording. Fields that its kind does not name are 0.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal unsafe partial struct Step
    {
        /// <summary>What it does.</summary>
        public StepKind kind;
        /// <summary>Of a texture: 0 R8 norm, 1 R16 norm, 2 R16 float, 3 RGBA32 float.</summary>
        public uint format;
        /// <summary>What it does it to.</summary>
        public ulong id;
        /// <summary>Where it takes it from.</summary>
        public ulong from;
        /// <summary>First texel.</summary>
        public fixed uint origin[3];
        /// <summary>Texels.</summary>
        public fixed uint size[3];
        /// <summary>First byte.</summary>
        public ulong offset;
        /// <summary>Bytes.</summary>
        public ulong length;
        /// <summary>What is written; valid until the recording is freed.</summary>
        public byte* data;
        /// <summary>For debuggers; lives as long as the library.</summary>
        public byte* label;
        /// <summary>See `lumivox_kernel_name`.</summary>
        public uint kernel;
        /// <summary>How many.</summary>
        public uint uniformCount;
        /// <summary>The contents of the kernel's uniform buffers, in the order of its table.</summary>
        public Slice* uniforms;
        /// <summary>Buffers and textures that it binds, in that order, too.</summary>
        public ulong* resources;
        /// <summary>How many.</summary>
        public uint resourceCount;
        /// <summary>Workgroups along x and y.</summary>
        public fixed uint workgroups[2];
        /// <summary>Nothing.</summary>
        public uint padding;
    }

    /// <summary>What became of a recording.</summary>
    internal enum Outcome : uint
    {
        /// <summary>It is on its way to the GPU.</summary>
        Executed = 0,
        /// <summary>The GPU has no room for something.</summary>
        NoMemory = 1,
        /// <summary>Something else was refused.</summary>
        Failed = 2,
    }

    /// <summary>How far long work is.</summary>
    internal enum JobState : uint
    {
        /// <summary>It goes on.</summary>
        Running = 0,
        /// <summary>What it makes can be taken.</summary>
        Done = 1,
        /// <summary>`lumivox_job_error` says why.</summary>
        Failed = 2,
        /// <summary>It was stopped.</summary>
        Cancelled = 3,
    }

    /// <summary>How far a job is.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal unsafe partial struct Progress
    {
        /// <summary>A phrase for people, such as `decoding slices`; lives as long as the library.</summary>
        public byte* stage;
        /// <summary>Steps of this stage that are done.</summary>
        public ulong done;
        /// <summary>Steps of this stage; each stage counts anew.</summary>
        public ulong total;
    }

    /// <summary>What to load where there is a choice. Strings are UTF-8; null: not said.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal unsafe partial struct ImportOptions
    {
        /// <summary>Which series of a DICOM study: its position from 1, its SeriesInstanceUID or its number.</summary>
        public byte* series;
        /// <summary>Which volume of a series with several, from 1; 0: the first that is whole.</summary>
        public uint phase;
        /// <summary>1: slices that are missing stay empty.</summary>
        public uint leaveGaps;
        /// <summary>1: slices that are damaged are filled in.</summary>
        public uint fillDamaged;
        /// <summary>1: a header may name data files anywhere.</summary>
        public uint allowOutsideData;
        /// <summary>1: what lies around the patient in a CT is a part of the scan: the table, clothes, cables. 0: it is put aside, where it can be told from the patient for sure.</summary>
        public uint keepEverything;
        /// <summary>Whether the file is a label map: 0 no, 1 yes, 2 where it looks like one. The scan that is made has labels then.</summary>
        public uint labels;
        /// <summary>Nothing.</summary>
        public uint padding;
        /// <summary>What the bytes of a RAW file mean, such as `256x256x108:i16le:spacing=1,1,2`.</summary>
        public byte* raw;
    }

    /// <summary>A small picture.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal unsafe partial struct Picture
    {
        /// <summary>Pixels.</summary>
        public uint width;
        /// <summary>Pixels.</summary>
        public uint height;
        /// <summary>`4 * width * height` bytes, rows from the top: sRGB and straight alpha; valid until the job is freed.</summary>
        public byte* rgba;
    }
}
