using System;
using StandIn;
using UnityEngine.Experimental.Rendering;
using UnityEngine.Rendering;

namespace UnityEngine
{
    public sealed class SystemInfo
    {
        public const string unsupportedIdentifier = "n/a";
        public static GraphicsDeviceType graphicsDeviceType => GraphicsDeviceType.Vulkan;
        public static string graphicsDeviceName => Gpu.name;
        public static string graphicsDeviceVendor => "Stand-in";
        public static string graphicsDeviceVersion => "Vulkan";
        public static int graphicsDeviceID => 1;
        public static int graphicsMemorySize => 4096;
        public static int graphicsShaderLevel => 50;
        public static bool graphicsMultiThreaded => false;
        public static RenderingThreadingMode renderingThreadingMode => RenderingThreadingMode.Direct;
        public static bool graphicsUVStartsAtTop => true;
        public static bool usesReversedZBuffer => true;
        public static bool supportsComputeShaders => !Faults.noComputeShaders;
        public static bool supportsAsyncGPUReadback => !Faults.noAsyncReadback;
        public static bool supports3DTextures => true;
        public static bool supports3DRenderTextures => true;
        public static bool supports2DArrayTextures => true;
        public static bool supportsAsyncCompute => false;
        public static bool supportsGraphicsFence => false;
        public static bool supportsSetConstantBuffer => true;
        public static bool supportsMultiview => false;
        public static bool supportsInstancing => true;
        public static CopyTextureSupport copyTextureSupport => CopyTextureSupport.Basic | CopyTextureSupport.Copy3D | CopyTextureSupport.TextureToRT | CopyTextureSupport.RTToTexture | CopyTextureSupport.DifferentTypes;
        public static int constantBufferOffsetAlignment => 256;
        public static int maxConstantBufferSize => 65536;
        public static int maxTextureSize => Faults.maxTextureSize > 0 ? Faults.maxTextureSize : (int)Math.Min(Gpu.Number(0), 16384);
        public static int maxTexture3DSize => Faults.maxTexture3DSize > 0 ? Faults.maxTexture3DSize : (int)Math.Min(Gpu.Number(1), 2048);
        public static int maxTextureArraySlices => 2048;
        public static int maxCubemapSize => maxTextureSize;
        public static long maxGraphicsBufferSize => Faults.maxGraphicsBufferSize > 0 ? Faults.maxGraphicsBufferSize : (long)Math.Min(Gpu.Number(2), 1ul << 31);
        public static int maxComputeBufferInputsCompute => 8;
        public static int maxComputeBufferInputsFragment => 8;
        public static int maxComputeWorkGroupSize => (int)Gpu.Number(4);
        public static int maxComputeWorkGroupSizeX => 1024;
        public static int maxComputeWorkGroupSizeY => 1024;
        public static int maxComputeWorkGroupSizeZ => 64;
        public static int processorCount => Environment.ProcessorCount;
        public static int systemMemorySize => 16384;
        public static string operatingSystem => "Linux";
        public static string deviceUniqueIdentifier => unsupportedIdentifier;
        public static string deviceModel => "Stand-in";
        public static string processorType => "x86_64";

        internal static bool Has(GraphicsFormat format, bool linear, bool render, bool loadStore, bool readPixels = false)
        {
            if (render && Faults.missingRender.Contains(format) || readPixels && Faults.missingReadPixels.Contains(format)) return false;
            if (Faults.missingFormats.Contains(format)) return false;
            bool depth = GraphicsFormatUtility.IsDepthFormat(format), srgb = GraphicsFormatUtility.IsSRGBFormat(format);
            if (loadStore && (depth || srgb || Faults.missingLoadStore.Contains(format))) return false;
            if (linear && (depth || GraphicsFormatUtility.GetBlockSize(format) / GraphicsFormatUtility.GetComponentCount(format) == 4 && GraphicsFormatUtility.IsHDRFormat(format) && format != GraphicsFormat.B10G11R11_UFloatPack32 && Gpu.Number(7) == 0)) return false;
            switch (format)
            {
                case GraphicsFormat.R8G8B8A8_SRGB: case GraphicsFormat.R8_UNorm: case GraphicsFormat.R8G8_UNorm: case GraphicsFormat.R8G8B8A8_UNorm: case GraphicsFormat.R16_UNorm: case GraphicsFormat.R16G16_UNorm: case GraphicsFormat.R16G16B16A16_UNorm:
                case GraphicsFormat.R32_UInt: case GraphicsFormat.R16_SFloat: case GraphicsFormat.R16G16_SFloat: case GraphicsFormat.R16G16B16A16_SFloat: case GraphicsFormat.R32_SFloat: case GraphicsFormat.R32G32_SFloat: case GraphicsFormat.R32G32B32A32_SFloat:
                case GraphicsFormat.B8G8R8A8_SRGB: case GraphicsFormat.B8G8R8A8_UNorm: case GraphicsFormat.B10G11R11_UFloatPack32: case GraphicsFormat.D32_SFloat: return true;
                default: return false;
            }
        }
#if UNITY_6000_0_OR_NEWER
        public static bool IsFormatSupported(GraphicsFormat format, GraphicsFormatUsage usage) => Has(format, (usage & GraphicsFormatUsage.Linear) != 0, (usage & GraphicsFormatUsage.Render) != 0, (usage & GraphicsFormatUsage.LoadStore) != 0, (usage & GraphicsFormatUsage.ReadPixels) != 0);
        public static GraphicsFormat GetCompatibleFormat(GraphicsFormat format, GraphicsFormatUsage usage) => IsFormatSupported(format, usage) ? format : GraphicsFormat.None;
#else
        public static bool IsFormatSupported(GraphicsFormat format, FormatUsage usage) => Has(format, usage == FormatUsage.Linear, usage == FormatUsage.Render, usage == FormatUsage.LoadStore, usage == FormatUsage.ReadPixels);
        public static GraphicsFormat GetCompatibleFormat(GraphicsFormat format, FormatUsage usage) => IsFormatSupported(format, usage) ? format : GraphicsFormat.None;
#endif
        public static GraphicsFormat GetGraphicsFormat(DefaultFormat format) => format switch { DefaultFormat.LDR => GraphicsFormat.R8G8B8A8_SRGB, DefaultFormat.HDR => GraphicsFormat.R16G16B16A16_SFloat, DefaultFormat.DepthStencil => GraphicsFormat.D32_SFloat, _ => throw new NotImplementedException(format.ToString()) };
        public static bool SupportsRenderTextureFormat(RenderTextureFormat format) { try { var color = GraphicsFormatUtility.GetGraphicsFormat(format, false); return color == GraphicsFormat.None || Has(color, false, true, false); } catch (NotImplementedException) { return false; } }
        public static bool SupportsRandomWriteOnRenderTextureFormat(RenderTextureFormat format) { try { return Has(GraphicsFormatUtility.GetGraphicsFormat(format, false), false, false, true); } catch (NotImplementedException) { return false; } }
        public static bool SupportsTextureFormat(TextureFormat format) { try { return Has(GraphicsFormatUtility.GetGraphicsFormat(format, false), false, false, false); } catch (NotImplementedException) { return false; } }
    }
}
