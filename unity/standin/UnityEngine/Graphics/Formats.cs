using System;

namespace UnityEngine.Experimental.Rendering
{
    public enum GraphicsFormat
    {
        None = 0, R8_SRGB = 1, R8G8B8A8_SRGB = 4, R8_UNorm = 5, R8G8_UNorm = 6, R8G8B8A8_UNorm = 8, R8_UInt = 13, R8G8B8A8_UInt = 16, R16_UNorm = 21, R16G16_UNorm = 22,
        R16G16B16A16_UNorm = 24, R16_SNorm = 25, R16_UInt = 29, R16_SInt = 33, R32_UInt = 37, R32G32_UInt = 38, R32G32B32A32_UInt = 40, R32_SInt = 41, R16_SFloat = 45, R16G16_SFloat = 46,
        R16G16B16A16_SFloat = 48, R32_SFloat = 49, R32G32_SFloat = 50, R32G32B32A32_SFloat = 52, B8G8R8A8_SRGB = 57, B8G8R8A8_UNorm = 59, B10G11R11_UFloatPack32 = 74,
        D16_UNorm = 90, D24_UNorm = 91, D24_UNorm_S8_UInt = 92, D32_SFloat = 93, D32_SFloat_S8_UInt = 94, S8_UInt = 95,
    }
    [Flags]
    public enum TextureCreationFlags { None = 0, MipChain = 1, DontInitializePixels = 4, Crunch = 64, DontUploadUponCreate = 1024, IgnoreMipmapLimit = 2048 }
#if UNITY_6000_0_OR_NEWER
    [Flags]
    public enum GraphicsFormatUsage { None = 0, Sample = 1, Linear = 2, Sparse = 4, Render = 16, Blend = 32, GetPixels = 64, SetPixels = 128, SetPixels32 = 256, ReadPixels = 512, LoadStore = 1024, MSAA2x = 2048, MSAA4x = 4096, MSAA8x = 8192, StencilSampling = 65536 }
#else
    public enum FormatUsage { Sample = 0, Linear = 1, Sparse = 2, Render = 4, Blend = 5, GetPixels = 6, SetPixels = 7, SetPixels32 = 8, ReadPixels = 9, LoadStore = 10, MSAA2x = 11, MSAA4x = 12, MSAA8x = 13, StencilSampling = 16 }
#endif
    public enum DefaultFormat { LDR, HDR, DepthStencil, Shadow, Video }

    public class GraphicsFormatUtility
    {
        /// Bytes of a texel.
        public static uint GetBlockSize(GraphicsFormat format)
        {
            switch (format)
            {
                case GraphicsFormat.R8_SRGB: case GraphicsFormat.R8_UNorm: case GraphicsFormat.R8_UInt: case GraphicsFormat.S8_UInt: return 1;
                case GraphicsFormat.R8G8_UNorm: case GraphicsFormat.R16_UNorm: case GraphicsFormat.R16_SNorm: case GraphicsFormat.R16_UInt: case GraphicsFormat.R16_SInt: case GraphicsFormat.R16_SFloat: case GraphicsFormat.D16_UNorm: return 2;
                case GraphicsFormat.R16G16B16A16_UNorm: case GraphicsFormat.R16G16B16A16_SFloat: case GraphicsFormat.R32G32_SFloat: case GraphicsFormat.R32G32_UInt: return 8;
                case GraphicsFormat.R32G32B32A32_SFloat: case GraphicsFormat.R32G32B32A32_UInt: return 16;
                case GraphicsFormat.D24_UNorm_S8_UInt: case GraphicsFormat.D32_SFloat_S8_UInt: return 8;
                case GraphicsFormat.None: return 0;
                default: return 4;
            }
        }
        public static uint GetComponentCount(GraphicsFormat format)
        {
            switch (format)
            {
                case GraphicsFormat.R8G8_UNorm: case GraphicsFormat.R16G16_UNorm: case GraphicsFormat.R16G16_SFloat: case GraphicsFormat.R32G32_SFloat: case GraphicsFormat.R32G32_UInt: return 2;
                case GraphicsFormat.B10G11R11_UFloatPack32: return 3;
                case GraphicsFormat.R8G8B8A8_SRGB: case GraphicsFormat.R8G8B8A8_UNorm: case GraphicsFormat.R8G8B8A8_UInt: case GraphicsFormat.R16G16B16A16_UNorm: case GraphicsFormat.R16G16B16A16_SFloat:
                case GraphicsFormat.R32G32B32A32_SFloat: case GraphicsFormat.R32G32B32A32_UInt: case GraphicsFormat.B8G8R8A8_SRGB: case GraphicsFormat.B8G8R8A8_UNorm: return 4;
                default: return 1;
            }
        }
        public static bool IsDepthFormat(GraphicsFormat format) => format >= GraphicsFormat.D16_UNorm && format <= GraphicsFormat.D32_SFloat_S8_UInt;
        public static bool IsSRGBFormat(GraphicsFormat format) => format == GraphicsFormat.R8_SRGB || format == GraphicsFormat.R8G8B8A8_SRGB || format == GraphicsFormat.B8G8R8A8_SRGB;
        public static bool IsHDRFormat(GraphicsFormat format) => format >= GraphicsFormat.R16_SFloat && format <= GraphicsFormat.R32G32B32A32_SFloat || format == GraphicsFormat.B10G11R11_UFloatPack32;
        public static GraphicsFormat GetGraphicsFormat(TextureFormat format, bool isSRGB)
        {
            switch (format)
            {
                case TextureFormat.R8: return isSRGB ? GraphicsFormat.R8_SRGB : GraphicsFormat.R8_UNorm;
                case TextureFormat.R16: return GraphicsFormat.R16_UNorm;
                case TextureFormat.RHalf: return GraphicsFormat.R16_SFloat;
                case TextureFormat.RFloat: return GraphicsFormat.R32_SFloat;
                case TextureFormat.RGBA32: return isSRGB ? GraphicsFormat.R8G8B8A8_SRGB : GraphicsFormat.R8G8B8A8_UNorm;
                case TextureFormat.BGRA32: return isSRGB ? GraphicsFormat.B8G8R8A8_SRGB : GraphicsFormat.B8G8R8A8_UNorm;
                case TextureFormat.RGBAHalf: return GraphicsFormat.R16G16B16A16_SFloat;
                case TextureFormat.RGBAFloat: return GraphicsFormat.R32G32B32A32_SFloat;
                case TextureFormat.RGHalf: return GraphicsFormat.R16G16_SFloat;
                case TextureFormat.RGFloat: return GraphicsFormat.R32G32_SFloat;
                default: throw new NotImplementedException($"the stand-in has no textures of TextureFormat.{format}");
            }
        }
        public static GraphicsFormat GetGraphicsFormat(RenderTextureFormat format, bool isSRGB)
        {
            switch (format)
            {
                case RenderTextureFormat.ARGB32: case RenderTextureFormat.Default: return isSRGB ? GraphicsFormat.R8G8B8A8_SRGB : GraphicsFormat.R8G8B8A8_UNorm;
                case RenderTextureFormat.ARGBHalf: case RenderTextureFormat.DefaultHDR: return GraphicsFormat.R16G16B16A16_SFloat;
                case RenderTextureFormat.ARGBFloat: return GraphicsFormat.R32G32B32A32_SFloat;
                case RenderTextureFormat.RFloat: return GraphicsFormat.R32_SFloat;
                case RenderTextureFormat.RHalf: return GraphicsFormat.R16_SFloat;
                case RenderTextureFormat.R8: return GraphicsFormat.R8_UNorm;
                case RenderTextureFormat.R16: return GraphicsFormat.R16_UNorm;
                case RenderTextureFormat.RGFloat: return GraphicsFormat.R32G32_SFloat;
                case RenderTextureFormat.RGHalf: return GraphicsFormat.R16G16_SFloat;
                case RenderTextureFormat.RGB111110Float: return GraphicsFormat.B10G11R11_UFloatPack32;
                case RenderTextureFormat.Depth: case RenderTextureFormat.Shadowmap: return GraphicsFormat.None;
                default: throw new NotImplementedException($"the stand-in has no render textures of RenderTextureFormat.{format}");
            }
        }
        public static GraphicsFormat GetDepthStencilFormat(int depthBits) => depthBits <= 0 ? GraphicsFormat.None : GraphicsFormat.D32_SFloat;
    }
}

namespace UnityEngine
{
    public enum TextureFormat { Alpha8 = 1, RGB24 = 3, RGBA32 = 4, ARGB32 = 5, R16 = 9, BGRA32 = 14, RHalf = 15, RGHalf = 16, RGBAHalf = 17, RFloat = 18, RGFloat = 19, RGBAFloat = 20, RG16 = 62, R8 = 63 }
    public enum RenderTextureFormat { ARGB32 = 0, Depth = 1, ARGBHalf = 2, Shadowmap = 3, Default = 7, DefaultHDR = 9, ARGBFloat = 11, RGFloat = 12, RGHalf = 13, RFloat = 14, RHalf = 15, R8 = 16, RGB111110Float = 22, R16 = 28 }
    public enum RenderTextureReadWrite { Default, Linear, sRGB }
    public enum FilterMode { Point, Bilinear, Trilinear }
    public enum TextureWrapMode { Repeat, Clamp, Mirror, MirrorOnce }
    public enum CubemapFace { Unknown = -1, PositiveX, NegativeX, PositiveY, NegativeY, PositiveZ, NegativeZ }
    [Flags] public enum RenderTextureMemoryless { None = 0, Color = 1, Depth = 2, MSAA = 4 }
    public enum VRTextureUsage { None, OneEye, TwoEyes, DeviceSpecific }
    public enum MeshTopology { Triangles = 0, Quads = 2, Lines = 3, LineStrip = 4, Points = 5 }
}

namespace UnityEngine.Rendering
{
    public enum TextureDimension { Unknown = -1, None, Any, Tex2D, Tex3D, Cube, Tex2DArray, CubeArray }
    public enum CompareFunction { Disabled, Never, Less, Equal, LessEqual, Greater, NotEqual, GreaterEqual, Always }
    public enum CullMode { Off, Front, Back }
    public enum BlendMode { Zero, One, DstColor, SrcColor, OneMinusDstColor, SrcAlpha, OneMinusSrcColor, DstAlpha, OneMinusDstAlpha, SrcAlphaSaturate, OneMinusSrcAlpha }
    public enum BlendOp { Add, Subtract, ReverseSubtract, Min, Max }
    [Flags] public enum ColorWriteMask { Alpha = 1, Blue = 2, Green = 4, Red = 8, All = 15 }
    public enum GraphicsDeviceType { Direct3D11 = 2, Null = 4, OpenGLES3 = 11, Metal = 16, OpenGLCore = 17, Direct3D12 = 18, Vulkan = 21, WebGPU = 28 }
    public enum RenderBufferLoadAction { Load, Clear, DontCare }
    public enum RenderBufferStoreAction { Store, Resolve, StoreAndResolve, DontCare }
    public enum ShadowSamplingMode { CompareDepths, RawDepth, None }
    [Flags] public enum RTClearFlags { None = 0, Color = 1, Depth = 2, Stencil = 4, All = 7, ColorDepth = 3, DepthStencil = 6 }
    public enum RenderingThreadingMode { Direct, SingleThreaded, MultiThreaded, LegacyJobified, NativeGraphicsJobs }
    public enum CommandBufferExecutionFlags { None = 0, AsyncCompute = 2 }
    public enum SynchronisationStageFlags { VertexProcessing = 1, PixelProcessing = 2, ComputeProcessing = 4, AllGPUOperations = 7 }
    public enum GraphicsFenceType { AsyncQueueSynchronisation, CPUSynchronisation }
}
