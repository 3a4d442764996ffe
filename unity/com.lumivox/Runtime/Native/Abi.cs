// The structs that cross the border to the native library, as crates/lumivox-unity/src/abi.rs has them.
using System;
using System.Runtime.InteropServices;
using UnityEngine;

namespace Lumivox.Native
{
    [StructLayout(LayoutKind.Sequential)]
    internal unsafe struct VolumeInfo
    {
        public fixed uint dimensions[3];
        public uint bytesPerVoxel;
        public fixed double spacingMm[3];
        public fixed double valueRange[2];
        public Vector3 boundsMin;
        public Vector3 boundsMax;
        public Matrix4x4 objectFromClip;
        public Matrix4x4 objectFromPatient;
        public uint modality;
        public uint isHounsfield;
        public uint hasSurroundings;
        public uint padding;
        public fixed byte unit[16];
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct OpacityKnot
    {
        public double value;
        public double opacity;
        public uint ease;
        public uint padding;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct ColorStop
    {
        public double value;
        public double red, green, blue;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct Medium
    {
        public float density;
        public float albedo;
        public float anisotropy;
        public uint maxBounces;
        public uint filter;
        public uint extinctionSpace;
        public float surfaceStrength;
        public float surfaceGradient;
        public float surfaceRoughness;
        public float surfaceSpecular;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct ClipShape
    {
        public Matrix4x4 worldFromShape;
        public uint kind;
        public uint inverted;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct LabelInfo
    {
        public uint value;
        public Vector3 color;
        public double milliliters;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct LabelStyle
    {
        public uint value;
        public uint visible;
        public uint painted;
        public uint clipped;
        public Vector3 color;
        public float opacity;
        public float density;
        public uint hasSurface;
        public float surfaceStrength;
        public float surfaceGradient;
        public float surfaceRoughness;
        public float surfaceSpecular;
        public IntPtr transferFunction;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct Instance
    {
        public IntPtr volume;
        public IntPtr part;
        public IntPtr transferFunction;
        public IntPtr labelling;
        public Matrix4x4 worldFromObject;
        public Vector3 clipMin;
        public Vector3 clipMax;
        public uint layers;
        public Medium medium;
        public float peelMm;
        public uint firstClip;
        public uint clipCount;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct LightSource
    {
        public const uint Directional = 0, Point = 1, Spot = 2;
        public const uint InverseSquare = 0, BuiltIn = 1;

        public uint kind;
        public uint layers;
        public Vector3 position;
        public Vector3 direction;
        public Vector3 strength;
        public float radius;
        public float range;
        public uint falloff;
        public float outerHalfAngle;
        public float innerHalfAngle;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct Surroundings
    {
        public const uint Plain = 0, Gradient = 1, Studio = 2, Map = 3;

        public uint kind;
        public Vector3 zenith;
        public Vector3 horizon;
        public Vector3 nadir;
        public float rotation;
        public float strength;
        public IntPtr map;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct DeviceLimits
    {
        public uint maxTexture3D;
        public uint maxTexture2D;
        public ulong maxBufferBytes;
        public ulong voxelBytes;
        public uint unorm16;
        public uint isSoftware;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct ViewFrame
    {
        public Matrix4x4 worldFromCamera;
        public Matrix4x4 clipFromCamera;
        public uint width;
        public uint height;
        public uint hasDepth;
        public float depthClear;
        public uint isJittered;
        public uint writeDepth;
        public float exposure;
        public Vector3 ambient;
        public float resolutionScale;
        public uint targetSamples;
        public float targetNoise;
        public float frameBudgetMs;
        public uint denoise;
        public uint fog;
        public Vector3 fogColor;
        public float fogStart;
        public float fogEnd;
        public float fogDensity;
        public uint atOnce;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct ViewStatus
    {
        public uint samples;
        public uint isConverged;
        public uint awaitsFeedback;
        public uint lostPixels;
        public ulong pixelSamples;
        public ulong depth;
        public ulong color;
        public ulong writtenDepth;
        public ulong ticket;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal unsafe struct Slice
    {
        public byte* data;
        public ulong length;
    }

    internal enum StepKind : uint
    {
        CreateBuffer = 0,
        CreateTexture = 1,
        WriteBuffer = 2,
        WriteTexture = 3,
        CopyTexture = 4,
        ClearBuffer = 5,
        Dispatch = 6,
        Draw = 7,
        ReadBuffer = 8,
        Free = 9,
    }

    [StructLayout(LayoutKind.Sequential)]
    internal unsafe struct Step
    {
        public StepKind kind;
        public uint format;
        public ulong id;
        public ulong from;
        public fixed uint origin[3];
        public fixed uint size[3];
        public ulong offset;
        public ulong length;
        public byte* data;
        public byte* label;
        public uint kernel;
        public uint uniformCount;
        public Slice* uniforms;
        public ulong* resources;
        public uint resourceCount;
        public fixed uint workgroups[2];
        public uint padding;
    }

    internal enum Outcome
    {
        Executed = 0,
        NoMemory = 1,
        Failed = 2,
    }

    internal enum JobState
    {
        Running = 0,
        Done = 1,
        Failed = 2,
        Cancelled = 3,
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct Progress
    {
        public IntPtr stage;
        public ulong done;
        public ulong total;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal unsafe struct ImportOptions
    {
        public byte* series;
        public uint phase;
        public uint leaveGaps;
        public uint fillDamaged;
        public uint allowOutsideData;
        public uint keepEverything;
        public uint labels;
        public uint padding;
        public byte* raw;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal unsafe struct Picture
    {
        public uint width;
        public uint height;
        public byte* rgba;
    }
}
