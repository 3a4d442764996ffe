using System;
using System.Collections.Generic;
using UnityEngine.Experimental.Rendering;
using UnityEngine.Rendering;

namespace UnityEngine
{
    public struct RenderBuffer { internal RenderTexture of; internal bool isDepth; }

    public struct RenderTextureDescriptor
    {
        public int width { get; set; }
        public int height { get; set; }
        public int msaaSamples { get; set; }
        public int volumeDepth { get; set; }
        public int mipCount { get; set; }
        public GraphicsFormat graphicsFormat { get; set; }
        public GraphicsFormat depthStencilFormat { get; set; }
        public GraphicsFormat stencilFormat { get; set; }
        public TextureDimension dimension { get; set; }
        public ShadowSamplingMode shadowSamplingMode { get; set; }
        public VRTextureUsage vrUsage { get; set; }
        public RenderTextureMemoryless memoryless { get; set; }
        public bool useMipMap { get; set; }
        public bool autoGenerateMips { get; set; }
        public bool enableRandomWrite { get; set; }
        public bool bindMS { get; set; }
        public bool useDynamicScale { get; set; }
        public bool sRGB { get => GraphicsFormatUtility.IsSRGBFormat(graphicsFormat); set => graphicsFormat = value && graphicsFormat == GraphicsFormat.R8G8B8A8_UNorm ? GraphicsFormat.R8G8B8A8_SRGB : !value && graphicsFormat == GraphicsFormat.R8G8B8A8_SRGB ? GraphicsFormat.R8G8B8A8_UNorm : graphicsFormat; }
        public int depthBufferBits { get => depthStencilFormat == GraphicsFormat.None ? 0 : 32; set => depthStencilFormat = GraphicsFormatUtility.GetDepthStencilFormat(value); }
        public RenderTextureFormat colorFormat
        {
            get => RenderTexture.FormatOf(graphicsFormat, depthStencilFormat);
            set { graphicsFormat = GraphicsFormatUtility.GetGraphicsFormat(value, sRGB); if (value == RenderTextureFormat.Depth && depthStencilFormat == GraphicsFormat.None) depthStencilFormat = GraphicsFormat.D32_SFloat; }
        }
        public RenderTextureDescriptor(int width, int height) : this(width, height, GraphicsFormat.R8G8B8A8_UNorm, GraphicsFormat.None) { }
        public RenderTextureDescriptor(int width, int height, RenderTextureFormat colorFormat) : this(width, height, colorFormat, 0) { }
        public RenderTextureDescriptor(int width, int height, RenderTextureFormat colorFormat, int depthBufferBits) : this(width, height, GraphicsFormatUtility.GetGraphicsFormat(colorFormat, false), colorFormat == RenderTextureFormat.Depth ? GraphicsFormat.D32_SFloat : GraphicsFormatUtility.GetDepthStencilFormat(depthBufferBits)) { }
        public RenderTextureDescriptor(int width, int height, GraphicsFormat colorFormat, int depthBufferBits) : this(width, height, colorFormat, GraphicsFormatUtility.GetDepthStencilFormat(depthBufferBits)) { }
        public RenderTextureDescriptor(int width, int height, GraphicsFormat colorFormat, GraphicsFormat depthStencilFormat) : this()
        {
            this.width = width; this.height = height; graphicsFormat = colorFormat; this.depthStencilFormat = depthStencilFormat;
            msaaSamples = 1; volumeDepth = 1; mipCount = -1; dimension = TextureDimension.Tex2D; autoGenerateMips = true;
        }
    }

    public class RenderTexture : Texture
    {
        RenderTextureDescriptor described;
        /// The depth buffer beside the colour, or the texture itself where it has no colour.
        internal uint depthHandle;
        bool isCreated;

        public RenderTexture(RenderTextureDescriptor desc)
        {
            StandIn.Threads.Main("RenderTexture..ctor");
            described = desc;
            wrapMode = TextureWrapMode.Clamp;
            Check();
            Take();
        }
        public RenderTexture(int width, int height, int depth) : this(new RenderTextureDescriptor(width, height, RenderTextureFormat.Default, depth)) { }
        public RenderTexture(int width, int height, int depth, RenderTextureFormat format) : this(new RenderTextureDescriptor(width, height, format, depth)) { }
        public RenderTexture(int width, int height, int depth, RenderTextureFormat format, RenderTextureReadWrite readWrite) : this(new RenderTextureDescriptor(width, height, format, depth) { sRGB = readWrite == RenderTextureReadWrite.sRGB }) { }
        public RenderTexture(int width, int height, int depth, GraphicsFormat format) : this(new RenderTextureDescriptor(width, height, format, depth)) { }
        public RenderTexture(int width, int height, GraphicsFormat colorFormat, GraphicsFormat depthStencilFormat) : this(new RenderTextureDescriptor(width, height, colorFormat, depthStencilFormat)) { }
        public RenderTexture(RenderTexture textureToCopy) : this(textureToCopy.described) { }

        internal static RenderTextureFormat FormatOf(GraphicsFormat color, GraphicsFormat depth) => color switch
        {
            GraphicsFormat.None => depth == GraphicsFormat.None ? RenderTextureFormat.Default : RenderTextureFormat.Depth,
            GraphicsFormat.R16G16B16A16_SFloat => RenderTextureFormat.ARGBHalf, GraphicsFormat.R32G32B32A32_SFloat => RenderTextureFormat.ARGBFloat, GraphicsFormat.R32_SFloat => RenderTextureFormat.RFloat,
            GraphicsFormat.R16_SFloat => RenderTextureFormat.RHalf, GraphicsFormat.R8_UNorm => RenderTextureFormat.R8, GraphicsFormat.R16_UNorm => RenderTextureFormat.R16,
            GraphicsFormat.B10G11R11_UFloatPack32 => RenderTextureFormat.RGB111110Float, _ => RenderTextureFormat.ARGB32,
        };
        void Check()
        {
            var most = described.dimension == TextureDimension.Tex3D ? SystemInfo.maxTexture3DSize : SystemInfo.maxTextureSize;
            if (described.width <= 0 || described.height <= 0 || described.volumeDepth <= 0) throw new ArgumentException("RenderTextureDesc width, height and volumeDepth must be greater than zero.");
            if (described.width > most || described.height > most || described.dimension == TextureDimension.Tex3D && described.volumeDepth > most) throw new ArgumentException($"RenderTextureDesc width, height or volumeDepth is more than {most}.");
            if (described.graphicsFormat != GraphicsFormat.None && !SystemInfo.Has(described.graphicsFormat, false, true, false)) throw new ArgumentException($"RenderTextureDesc graphicsFormat must be a supported GraphicsFormat. {described.graphicsFormat} is not supported on this platform.", "desc.graphicsFormat");
            if (described.msaaSamples > 1) throw new NotImplementedException("the stand-in's render textures have one sample a pixel");
            if (described.dimension == TextureDimension.Cube && (described.width != described.height || described.volumeDepth != 1)) throw new ArgumentException("A cube render texture is square, and has no volumeDepth.");
            if (described.graphicsFormat == GraphicsFormat.None && described.depthStencilFormat == GraphicsFormat.None) throw new ArgumentException("RenderTextureDesc graphicsFormat and depthStencilFormat cannot both be None.");
            if (described.enableRandomWrite && GraphicsFormatUtility.IsSRGBFormat(described.graphicsFormat)) throw new ArgumentException("A render texture of an sRGB format is not written by kernels.");
        }
        void Take()
        {
            m_Width = described.width; m_Height = described.height; m_Depth = described.dimension == TextureDimension.Cube ? 6 : described.volumeDepth; m_Dimension = described.dimension;
            m_Format = described.graphicsFormat == GraphicsFormat.None ? described.depthStencilFormat : described.graphicsFormat;
            m_Levels = described.useMipMap ? described.mipCount > 0 ? described.mipCount : Mathf.CeilToInt(Mathf.Log(Mathf.Max(m_Width, m_Height), 2)) + 1 : 1;
        }
        T Before<T>(T value, string what) { if (isCreated) { Debug.LogError($"Setting {what} of already created render texture is not supported!"); } return value; }
        public RenderTextureDescriptor descriptor { get => described; set { Before(0, "descriptor"); if (isCreated) return; described = value; Check(); Take(); } }
        public override int width { get => m_Width; set { Before(0, "width"); if (isCreated) return; described.width = value; Check(); Take(); } }
        public override int height { get => m_Height; set { Before(0, "height"); if (isCreated) return; described.height = value; Check(); Take(); } }
        public override TextureDimension dimension { get => m_Dimension; set { Before(0, "dimension"); if (isCreated) return; described.dimension = value; Check(); Take(); } }
        public int volumeDepth { get => described.volumeDepth; set { Before(0, "volume depth"); if (isCreated) return; described.volumeDepth = value; Check(); Take(); } }
        public bool enableRandomWrite { get => described.enableRandomWrite; set { Before(0, "enableRandomWrite"); if (isCreated) return; described.enableRandomWrite = value; Check(); } }
        public bool useMipMap { get => described.useMipMap; set { Before(0, "mipmap mode"); if (isCreated) return; described.useMipMap = value; Take(); } }
        public bool autoGenerateMips { get => described.autoGenerateMips; set => described.autoGenerateMips = value; }
        public int antiAliasing { get => described.msaaSamples; set { Before(0, "anti-aliasing"); if (isCreated) return; described.msaaSamples = value; Check(); } }
        public RenderTextureFormat format { get => FormatOf(described.graphicsFormat, described.depthStencilFormat); set => Reformat(() => described.colorFormat = value); }
        public new GraphicsFormat graphicsFormat { get => described.graphicsFormat; set => Reformat(() => described.graphicsFormat = value); }
        public GraphicsFormat depthStencilFormat { get => described.depthStencilFormat; set => Reformat(() => described.depthStencilFormat = value); }
        public int depth { get => described.depthBufferBits; set => Reformat(() => described.depthBufferBits = value); }
        void Reformat(Action change) { Before(0, "format"); if (isCreated) return; change(); Check(); Take(); }
        public bool sRGB => described.sRGB;
        public VRTextureUsage vrUsage { get => described.vrUsage; set => described.vrUsage = value; }
        public RenderBuffer colorBuffer => new RenderBuffer { of = this };
        public RenderBuffer depthBuffer => new RenderBuffer { of = this, isDepth = true };
        internal override bool isRandomWritten => described.enableRandomWrite;
        internal bool hasColor => described.graphicsFormat != GraphicsFormat.None;
        public static RenderTexture active { get; set; }

        public bool Create()
        {
            StandIn.Threads.Main("RenderTexture.Create");
            Alive();
            if (isCreated) return true;
            if (described.enableRandomWrite && StandIn.Faults.missingLoadStore.Contains(described.graphicsFormat)) { Debug.LogError($"RenderTexture.Create failed: format unsupported for random writes - {described.graphicsFormat}."); return false; }
            // Volumes are not drawn to.
            CreateOnDevice(described.enableRandomWrite, described.dimension != TextureDimension.Tex3D);
            if (handle == 0) return false;
            if (!hasColor) depthHandle = handle;
            else if (described.depthStencilFormat != GraphicsFormat.None)
                depthHandle = StandIn.Native.sg_create_texture((uint)GraphicsFormat.D32_SFloat, 2, (uint)m_Width, (uint)m_Height, (uint)m_Depth, 1, 0, 1);
            StandIn.Gpu.Check($"RenderTexture '{label}'");
            isCreated = true;
            return true;
        }
        public bool IsCreated() => isCreated;
        public void Release()
        {
            StandIn.Threads.Main("RenderTexture.Release");
            if (active == this) { Debug.LogWarning("Releasing render texture that is set as RenderTexture.active!"); active = null; }
            if (depthHandle != 0 && depthHandle != handle) StandIn.Native.sg_free(depthHandle);
            depthHandle = 0;
            ReleaseFromDevice();
            isCreated = false;
        }
        public void DiscardContents() { }
        public void DiscardContents(bool discardColor, bool discardDepth) { }
        public void GenerateMips() => throw new NotImplementedException("the stand-in makes no mipmaps");
        internal override void OnDestroyed()
        {
            if (active == this) active = null;
            if (depthHandle != 0 && depthHandle != handle) StandIn.Native.sg_free(depthHandle);
            depthHandle = 0;
            ReleaseFromDevice();
        }

        static readonly List<RenderTexture> temporary = new List<RenderTexture>();
        public static RenderTexture GetTemporary(RenderTextureDescriptor desc)
        {
            var found = temporary.Find(texture => texture.described.Equals(desc));
            if (found == null) { found = new RenderTexture(desc) { name = "TempBuffer", hideFlags = HideFlags.HideAndDontSave }; found.Create(); } else temporary.Remove(found);
            StandIn.Live.Add(found);
            return found;
        }
        public static RenderTexture GetTemporary(int width, int height) => GetTemporary(width, height, 0);
        public static RenderTexture GetTemporary(int width, int height, int depthBuffer) => GetTemporary(width, height, depthBuffer, RenderTextureFormat.Default);
        public static RenderTexture GetTemporary(int width, int height, int depthBuffer, RenderTextureFormat format) => GetTemporary(new RenderTextureDescriptor(width, height, format, depthBuffer));
        public static void ReleaseTemporary(RenderTexture temp) { if (temp == null) return; if (temporary.Contains(temp)) throw new InvalidOperationException("a temporary render texture is released twice"); temporary.Add(temp); StandIn.Live.Remove(temp); }
    }
}
