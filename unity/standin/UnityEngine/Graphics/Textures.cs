using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine.Experimental.Rendering;
using UnityEngine.Rendering;

namespace UnityEngine
{
    public partial class Texture : Object
    {
        protected Texture() { }
        internal uint handle;
        internal int m_Width, m_Height, m_Depth = 1, m_Levels = 1;
        internal GraphicsFormat m_Format;
        internal TextureDimension m_Dimension = TextureDimension.Tex2D;
        internal virtual bool isRandomWritten => false;
        public virtual int width { get => m_Width; set => throw new NotImplementedException(); }
        public virtual int height { get => m_Height; set => throw new NotImplementedException(); }
        public virtual TextureDimension dimension { get => m_Dimension; set => throw new NotImplementedException(); }
        public virtual bool isReadable => !isMadeUnreadable;
        public GraphicsFormat graphicsFormat => m_Format;
        public int mipmapCount => m_Levels;
        public bool isDataSRGB => GraphicsFormatUtility.IsSRGBFormat(m_Format);
        public FilterMode filterMode { get; set; } = FilterMode.Bilinear;
        TextureWrapMode wrap = TextureWrapMode.Repeat;
        public TextureWrapMode wrapMode { get => wrap; set => wrap = value; }
        public TextureWrapMode wrapModeU { get => wrap; set => wrap = value; }
        public TextureWrapMode wrapModeV { get => wrap; set => wrap = value; }
        public TextureWrapMode wrapModeW { get => wrap; set => wrap = value; }
        public int anisoLevel { get; set; } = 1;
        public float mipMapBias { get; set; }
        public uint updateCount { get; internal set; }
        public void IncrementUpdateCount() => updateCount++;
        public Vector2 texelSize => new Vector2(1f / width, 1f / height);
        public IntPtr GetNativeTexturePtr() => throw new NotImplementedException("the stand-in lends no textures of the driver's");
        internal long bytes => (long)m_Width * m_Height * m_Depth * GraphicsFormatUtility.GetBlockSize(m_Format);

        internal void CreateOnDevice(bool storage, bool target)
        {
            StandIn.Gpu.Open();
            if (StandIn.Faults.missingFormats.Contains(m_Format)) throw new UnityException($"Failed to create texture '{label}': the format {m_Format} is not supported (asked for by a test)");
            if (StandIn.Faults.TakeAllocation()) { Debug.LogError($"Failed to create texture '{label}': out of memory (asked for by a test)"); return; }
            uint dimension = m_Dimension == TextureDimension.Tex3D ? 3u : 2;
            handle = StandIn.Native.sg_create_texture((uint)m_Format, dimension, (uint)m_Width, (uint)m_Height, (uint)m_Depth, (uint)m_Levels, storage ? 1u : 0, target ? 1u : 0);
            StandIn.Gpu.Check($"{GetType().Name} '{label}'");
            if (handle != 0) StandIn.Live.Add(this);
        }
        internal void ReleaseFromDevice()
        {
            if (handle == 0) return;
            StandIn.Native.sg_free(handle);
            handle = 0;
            StandIn.Live.Remove(this);
        }
        internal override void OnDestroyed() => ReleaseFromDevice();
        internal static void CheckSide(int side, int most, string what)
        {
            if (side <= 0 || side > most) throw new UnityException($"Failed to create texture because of invalid parameters: {what} of {side}, of at most {most}.");
        }
    }

    // Texels are kept on the CPU, too, and uploaded with `Apply`; but for render textures.
    public partial class Texture
    {
        private protected byte[] texels;
        bool isMadeUnreadable;
        private protected void Begin(int width, int height, int depth, GraphicsFormat format, TextureDimension dimension, bool mipChain)
        {
            StandIn.Threads.Main(GetType().Name + "..ctor");
            if (GraphicsFormatUtility.IsDepthFormat(format)) throw new ArgumentException("A readable texture has no format of depths.");
            m_Width = width; m_Height = height; m_Depth = depth; m_Format = format; m_Dimension = dimension;
            m_Levels = 1;
            if (mipChain) for (int side = Math.Max(width, height); side > 1; side /= 2) m_Levels++;
            texels = new byte[bytes];
            CreateOnDevice(false, false);
        }
        private protected void Readable() { Alive(); if (isMadeUnreadable) throw new UnityException($"Texture '{label}' is not readable, the texture memory can not be accessed from scripts. You can make the texture readable in the Texture Import Settings."); }
        private protected unsafe void Upload(bool makeNoLongerReadable)
        {
            StandIn.Threads.Main("Apply");
            Readable();
            if (handle == 0) return;
            fixed (byte* data = texels) StandIn.Native.sg_write_texture(new StandIn.Native.Region { texture = handle }, (uint)m_Width, (uint)m_Height, (uint)m_Depth, data, (ulong)texels.Length);
            StandIn.Gpu.Submit($"Apply of '{label}'");
            updateCount++;
            if (makeNoLongerReadable) { isMadeUnreadable = true; texels = null; }
        }
        private protected unsafe void Set<T>(NativeArray<T> data, long at, long length) where T : struct
        {
            Readable();
            if ((long)data.Length * UnsafeUtility.SizeOf<T>() < length) throw new UnityException("SetPixelData: not enough data provided (will result in overread).");
            fixed (byte* to = texels) UnsafeUtility.MemCpy(to + at, data.GetUnsafeReadOnlyPtr(), length);
        }
        /// What an array holds from an element on; of what is no plain data Unity says so when it runs.
        private protected static NativeArray<byte> BytesOf<T>(T[] data, int from)
        {
            GCHandle pinned;
            try { pinned = GCHandle.Alloc(data, GCHandleType.Pinned); }
            catch (ArgumentException) { throw new ArgumentException($"{typeof(T)} type used in SetPixelData() must be blittable"); }
            try
            {
                var size = data.Length == 0 ? 0 : Marshal.SizeOf(data[0]);
                var bytes = new byte[Math.Max(0, data.Length - from) * size];
                Marshal.Copy(pinned.AddrOfPinnedObject() + from * size, bytes, 0, bytes.Length);
                return new NativeArray<byte>(bytes, Allocator.Temp);
            }
            finally { pinned.Free(); }
        }
        private protected Color Get(long texel)
        {
            Readable();
            return StandIn.Pictures.Decode(texels, texel * GraphicsFormatUtility.GetBlockSize(m_Format), m_Format);
        }
        private protected void Put(long texel, Color color)
        {
            Readable();
            StandIn.Pictures.Encode(color, texels, texel * GraphicsFormatUtility.GetBlockSize(m_Format), m_Format);
        }
    }

    public sealed class Texture2D : Texture
    {
        public Texture2D(int width, int height) : this(width, height, TextureFormat.RGBA32, true) { }
        public Texture2D(int width, int height, TextureFormat textureFormat, bool mipChain) : this(width, height, textureFormat, mipChain, false) { }
        public Texture2D(int width, int height, TextureFormat textureFormat, bool mipChain, bool linear) => Make(width, height, GraphicsFormatUtility.GetGraphicsFormat(textureFormat, !linear && textureFormat <= TextureFormat.BGRA32 && textureFormat != TextureFormat.R16), mipChain);
        public Texture2D(int width, int height, GraphicsFormat format, TextureCreationFlags flags) => Make(width, height, format, (flags & TextureCreationFlags.MipChain) != 0);
        void Make(int width, int height, GraphicsFormat format, bool mipChain)
        {
            CheckSide(width, SystemInfo.maxTextureSize, "a width");
            CheckSide(height, SystemInfo.maxTextureSize, "a height");
            Begin(width, height, 1, format, TextureDimension.Tex2D, mipChain);
        }
        internal void Resize(int width, int height)
        {
            ReleaseFromDevice();
            Make(width, height, m_Format, m_Levels > 1);
        }
        static Texture2D white, black;
        static Texture2D Plain(ref Texture2D texture, Color color)
        {
            if (texture != null) return texture;
            texture = new Texture2D(4, 4, TextureFormat.RGBA32, false) { isAsset = true };
            for (int i = 0; i < 16; i++) texture.Put(i, color);
            texture.Apply();
            StandIn.Live.Remove(texture);
            return texture;
        }
        public static Texture2D whiteTexture => Plain(ref white, Color.white);
        public static Texture2D blackTexture => Plain(ref black, new Color(0, 0, 0, 0));
        public TextureFormat format => m_Format switch { GraphicsFormat.R8_UNorm => TextureFormat.R8, GraphicsFormat.R16_UNorm => TextureFormat.R16, GraphicsFormat.R16_SFloat => TextureFormat.RHalf, GraphicsFormat.R32_SFloat => TextureFormat.RFloat, GraphicsFormat.R8G8B8A8_UNorm => TextureFormat.RGBA32, GraphicsFormat.R8G8B8A8_SRGB => TextureFormat.RGBA32, GraphicsFormat.R16G16B16A16_SFloat => TextureFormat.RGBAHalf, GraphicsFormat.R32G32B32A32_SFloat => TextureFormat.RGBAFloat, _ => throw new NotImplementedException(m_Format.ToString()) };
        public Color GetPixel(int x, int y) => Get(Mathf.Clamp(y, 0, m_Height - 1) * m_Width + Mathf.Clamp(x, 0, m_Width - 1));
        public Color GetPixelBilinear(float u, float v)
        {
            float x = u * m_Width - .5f, y = v * m_Height - .5f;
            int i = Mathf.FloorToInt(x), j = Mathf.FloorToInt(y);
            int Wrap(int at, int side) => wrapMode == TextureWrapMode.Repeat ? (at % side + side) % side : Mathf.Clamp(at, 0, side - 1);
            Color At(int a, int b) => Get(Wrap(b, m_Height) * m_Width + Wrap(a, m_Width));
            return Color.Lerp(Color.Lerp(At(i, j), At(i + 1, j), x - i), Color.Lerp(At(i, j + 1), At(i + 1, j + 1), x - i), y - j);
        }
        public Color[] GetPixels() => GetPixels(0);
        public Color[] GetPixels(int miplevel) { if (miplevel != 0) throw new NotImplementedException("the stand-in keeps the first level only"); var all = new Color[m_Width * m_Height]; for (int i = 0; i < all.Length; i++) all[i] = Get(i); return all; }
        public Color32[] GetPixels32() => Array.ConvertAll(GetPixels(), color => (Color32)color);
        public void SetPixel(int x, int y, Color color) => Put(y * m_Width + x, color);
        public void SetPixels(Color[] colors) { if (colors.Length != m_Width * m_Height) throw new UnityException("Array size must be at least width*height"); for (int i = 0; i < colors.Length; i++) Put(i, colors[i]); }
        public void SetPixels32(Color32[] colors) => SetPixels(Array.ConvertAll(colors, color => (Color)color));
        public void SetPixelData<T>(T[] data, int mipLevel, int sourceDataStartIndex = 0) { using (var copy = BytesOf(data, sourceDataStartIndex)) SetPixelData(copy, mipLevel); }
        public void SetPixelData<T>(NativeArray<T> data, int mipLevel, int sourceDataStartIndex = 0) where T : struct
        {
            if (mipLevel != 0) throw new NotImplementedException("the stand-in keeps the first level only");
            Set(data.GetSubArray(sourceDataStartIndex, data.Length - sourceDataStartIndex), 0, texels.Length);
        }
        public void LoadRawTextureData(byte[] data) { if (data.Length < texels.Length) throw new UnityException("LoadRawTextureData: not enough data provided (will result in overread)."); SetPixelData(data, 0); }
        public void LoadRawTextureData<T>(NativeArray<T> data) where T : struct => SetPixelData(data, 0);
        public byte[] GetRawTextureData() { Readable(); return (byte[])texels.Clone(); }
        public unsafe NativeArray<T> GetRawTextureData<T>() where T : struct => GetPixelData<T>(0);
        public NativeArray<T> GetPixelData<T>(int mipLevel) where T : struct => throw new NotImplementedException("the stand-in lends no texels; SetPixelData and GetPixels copy them");
        public void Apply() => Upload(false);
        public void Apply(bool updateMipmaps) => Upload(false);
        public void Apply(bool updateMipmaps, bool makeNoLongerReadable) => Upload(makeNoLongerReadable);
        public bool Reinitialize(int width, int height) => throw new NotImplementedException("the stand-in's textures keep their size");
        /// From what is the render target now: `RenderTexture.active`.
        public void ReadPixels(Rect source, int destX, int destY) => ReadPixels(source, destX, destY, true);
        public void ReadPixels(Rect source, int destX, int destY, bool recalculateMipMaps)
        {
            var from = RenderTexture.active;
            if (from == null) throw new NotImplementedException("the stand-in reads no pixels of the screen");
            var all = StandIn.Pictures.Read(from);
            for (int y = 0; y < (int)source.height; y++)
                for (int x = 0; x < (int)source.width; x++)
                    Put((destY + y) * m_Width + destX + x, all.At((int)source.x + x, (int)source.y + y));
        }
    }

    public sealed class Texture3D : Texture
    {
        public Texture3D(int width, int height, int depth, TextureFormat textureFormat, bool mipChain) : this(width, height, depth, GraphicsFormatUtility.GetGraphicsFormat(textureFormat, false), mipChain ? TextureCreationFlags.MipChain : TextureCreationFlags.None) { }
        public Texture3D(int width, int height, int depth, GraphicsFormat format, TextureCreationFlags flags)
        {
            foreach (var side in new[] { width, height, depth }) CheckSide(side, SystemInfo.maxTexture3DSize, "a side");
            Begin(width, height, depth, format, TextureDimension.Tex3D, (flags & TextureCreationFlags.MipChain) != 0);
        }
        public int depth => m_Depth;
        public void SetPixelData<T>(T[] data, int mipLevel, int sourceDataStartIndex = 0) { using (var copy = BytesOf(data, sourceDataStartIndex)) SetPixelData(copy, mipLevel); }
        public void SetPixelData<T>(NativeArray<T> data, int mipLevel, int sourceDataStartIndex = 0) where T : struct => Set(data.GetSubArray(sourceDataStartIndex, data.Length - sourceDataStartIndex), 0, texels.Length);
        public Color GetPixel(int x, int y, int z) => Get(((long)z * m_Height + y) * m_Width + x);
        public void SetPixel(int x, int y, int z, Color color) => Put(((long)z * m_Height + y) * m_Width + x, color);
        public void Apply() => Upload(false);
        public void Apply(bool updateMipmaps) => Upload(false);
        public void Apply(bool updateMipmaps, bool makeNoLongerReadable) => Upload(makeNoLongerReadable);
    }

    public sealed class Texture2DArray : Texture
    {
        public Texture2DArray(int width, int height, int depth, GraphicsFormat format, TextureCreationFlags flags) => Begin(width, height, depth, format, TextureDimension.Tex2DArray, (flags & TextureCreationFlags.MipChain) != 0);
        public int depth => m_Depth;
        public void SetPixelData<T>(T[] data, int mipLevel, int element, int sourceDataStartIndex = 0) { using (var copy = BytesOf(data, sourceDataStartIndex)) Set(copy, element * (texels.Length / m_Depth), texels.Length / m_Depth); }
        public void Apply() => Upload(false);
        public void Apply(bool updateMipmaps) => Upload(false);
        public void Apply(bool updateMipmaps, bool makeNoLongerReadable) => Upload(makeNoLongerReadable);
    }

    public sealed class Cubemap : Texture
    {
        public Cubemap(int width, TextureFormat textureFormat, bool mipChain) : this(width, GraphicsFormatUtility.GetGraphicsFormat(textureFormat, textureFormat == TextureFormat.RGBA32), mipChain ? TextureCreationFlags.MipChain : TextureCreationFlags.None) { }
        public Cubemap(int width, GraphicsFormat format, TextureCreationFlags flags)
        {
            CheckSide(width, SystemInfo.maxCubemapSize, "a width");
            Begin(width, width, 6, format, TextureDimension.Cube, (flags & TextureCreationFlags.MipChain) != 0);
        }
        long At(CubemapFace face, int x, int y) => ((long)face * m_Height + y) * m_Width + x;
        public Color GetPixel(CubemapFace face, int x, int y) => Get(At(face, x, y));
        public void SetPixel(CubemapFace face, int x, int y, Color color) => Put(At(face, x, y), color);
        public Color[] GetPixels(CubemapFace face) => GetPixels(face, 0);
        public Color[] GetPixels(CubemapFace face, int miplevel) { if (miplevel != 0) throw new NotImplementedException("the stand-in keeps the first level only"); var all = new Color[m_Width * m_Height]; for (int i = 0; i < all.Length; i++) all[i] = Get(At(face, 0, 0) + i); return all; }
        public void SetPixels(Color[] colors, CubemapFace face) { for (int i = 0; i < colors.Length; i++) Put(At(face, 0, 0) + i, colors[i]); }
        public void SetPixelData<T>(T[] data, int mipLevel, CubemapFace face, int sourceDataStartIndex = 0) { using (var copy = BytesOf(data, sourceDataStartIndex)) Set(copy, (int)face * (texels.Length / 6), texels.Length / 6); }
        public void Apply() => Upload(false);
        public void Apply(bool updateMipmaps) => Upload(false);
        public void Apply(bool updateMipmaps, bool makeNoLongerReadable) => Upload(makeNoLongerReadable);
    }
}
