// What was drawn, as numbers and as files.
using System;
using System.Collections.Generic;
using System.IO;
using System.IO.Compression;
using UnityEngine;
using UnityEngine.Experimental.Rendering;

namespace StandIn
{
    /// Pixels by rows; which row comes first is up to where it was read.
    public sealed class Picture
    {
        public readonly int width, height;
        public readonly Color[] pixels;
        public Picture(int width, int height) { this.width = width; this.height = height; pixels = new Color[width * height]; }
        public Color At(int x, int y) => pixels[y * width + x];
        public Color mean { get { var sum = Color.clear; foreach (var pixel in pixels) sum += pixel; return sum / pixels.Length; } }
        public Picture Flipped()
        {
            var other = new Picture(width, height);
            for (int y = 0; y < height; y++) Array.Copy(pixels, y * width, other.pixels, (height - 1 - y) * width, width);
            return other;
        }
        /// Colours in linear light as a PNG for the screen; `encode` off leaves them as they are. The first row is the lowest.
        public byte[] ToPng(bool encode = true)
        {
            var rows = new byte[height * (1 + width * 4)];
            for (int y = 0, at = 0; y < height; y++)
            {
                rows[at++] = 0;
                for (int x = 0; x < width; x++)
                {
                    var color = At(x, height - 1 - y);
                    if (encode) color = color.gamma;
                    for (int c = 0; c < 4; c++) rows[at++] = (byte)Math.Round(Mathf.Clamp01(float.IsNaN(color[c]) ? 0 : color[c]) * 255);
                }
            }
            return Packed(width, height, 6, rows);
        }
        /// A PNG of filtered rows of so many colours: 2 RGB, 6 with alpha.
        internal static byte[] Packed(int width, int height, byte kind, byte[] rows)
        {
            var packed = new MemoryStream();
            packed.Write(new byte[] { 0x78, 1 }, 0, 2);
            using (var deflate = new DeflateStream(packed, CompressionLevel.Optimal, true)) deflate.Write(rows, 0, rows.Length);
            uint a = 1, b = 0;
            foreach (var value in rows) { a = (a + value) % 65521; b = (b + a) % 65521; }
            packed.Write(Big(b << 16 | a), 0, 4);
            var png = new MemoryStream();
            png.Write(new byte[] { 0x89, 0x50, 0x4e, 0x47, 13, 10, 26, 10 }, 0, 8);
            var header = new MemoryStream();
            header.Write(Big((uint)width), 0, 4);
            header.Write(Big((uint)height), 0, 4);
            header.Write(new byte[] { 8, kind, 0, 0, 0 }, 0, 5);
            Chunk(png, "IHDR", header.ToArray());
            Chunk(png, "IDAT", packed.ToArray());
            Chunk(png, "IEND", new byte[0]);
            return png.ToArray();
        }
        public void Save(string file) { Directory.CreateDirectory(Path.GetDirectoryName(Path.GetFullPath(file))); File.WriteAllBytes(file, ToPng()); }
        static byte[] Big(uint value) => new[] { (byte)(value >> 24), (byte)(value >> 16), (byte)(value >> 8), (byte)value };
        static void Chunk(Stream to, string name, byte[] data)
        {
            var body = new byte[4 + data.Length];
            for (int i = 0; i < 4; i++) body[i] = (byte)name[i];
            data.CopyTo(body, 4);
            to.Write(Big((uint)data.Length), 0, 4);
            to.Write(body, 0, body.Length);
            uint crc = ~0u;
            foreach (var value in body) { crc ^= value; for (int bit = 0; bit < 8; bit++) crc = (crc & 1) != 0 ? crc >> 1 ^ 0xedb88320 : crc >> 1; }
            to.Write(Big(~crc), 0, 4);
        }
    }

    public static unsafe class Pictures
    {
        static readonly Dictionary<(int, Camera.StereoscopicEye), (Picture color, Picture depth)> eyes = new Dictionary<(int, Camera.StereoscopicEye), (Picture, Picture)>();
        internal static void KeepEye(Camera camera, Camera.StereoscopicEye eye) => eyes[(camera.GetInstanceID(), eye)] = (Color(camera), Depth(camera));
        /// What an eye saw last, where eyes are rendered one after the other.
        public static Picture Color(Camera camera, Camera.StereoscopicEye eye) => Engine.IsSinglePass(camera) ? Upright(camera, Read(Engine.ColorOf(camera), (int)eye)) : eyes[(camera.GetInstanceID(), eye)].color;
        public static Picture Depth(Camera camera, Camera.StereoscopicEye eye) => Engine.IsSinglePass(camera) ? Upright(camera, ReadDepth(Engine.DepthOf(camera), (int)eye)) : eyes[(camera.GetInstanceID(), eye)].depth;
        /// What a camera drew: linear colours, the lowest row first.
        public static Picture Color(Camera camera) => Upright(camera, Read(Engine.ColorOf(camera)));
        /// Its depth as the device keeps it: 1 near, 0 far; the lowest row first.
        public static Picture Depth(Camera camera) => Upright(camera, ReadDepth(Engine.DepthOf(camera)));
        static Picture Upright(Camera camera, Picture picture) => Engine.IsFlipped(camera) ? picture : picture.Flipped();

        /// A texture's texels as they lie, decoded to linear colours.
        public static Picture Read(Texture texture, int layer = 0) => Read(texture.handle, texture.m_Width, texture.m_Height, layer, texture.m_Format);
        public static Picture ReadDepth(RenderTexture texture, int layer = 0) => Read(texture.depthHandle, texture.m_Width, texture.m_Height, layer, GraphicsFormat.D32_SFloat);
        static Picture Read(uint handle, int width, int height, int layer, GraphicsFormat format)
        {
            var picture = new Picture(width, height);
            uint size = GraphicsFormatUtility.GetBlockSize(format), ticket = Native.sg_read_texture(new Native.Region { texture = handle, z = (uint)layer }, (uint)width, (uint)height, 1);
            var bytes = Collect(ticket, (int)size * width * height);
            for (int i = 0; i < picture.pixels.Length; i++) picture.pixels[i] = Decode(bytes, i * size, format);
            return picture;
        }
        /// Makes other colours of a layer's.
        internal static void Change(RenderTexture texture, int layer, Func<Color, Color> change)
        {
            var picture = Read(texture, layer);
            for (int i = 0; i < picture.pixels.Length; i++) picture.pixels[i] = change(picture.pixels[i]);
            Spread(picture, texture, layer);
        }
        /// Fills a layer with a picture of any size, whose rows lie as the texture's.
        internal static void Spread(Picture picture, RenderTexture texture, int layer)
        {
            int width = texture.m_Width, height = texture.m_Height;
            var pixels = new float[width * height * 5];
            for (int y = 0; y < height; y++)
                for (int x = 0; x < width; x++)
                    for (int c = 0; c < 4; c++) pixels[(y * width + x) * 5 + c] = picture.At(x * picture.width / width, y * picture.height / height)[c];
            fixed (float* data = pixels) Native.sg_fill(new Native.Target { color = texture.handle, colorLayer = (uint)layer }, (uint)width, data, (ulong)pixels.Length * 4);
            Gpu.Submit("a picture");
        }
        public static byte[] Read(GraphicsBuffer buffer, int offset, int bytes) => Collect(Native.sg_read_buffer(buffer.handle, (ulong)offset, (ulong)bytes), bytes);
        /// A layer of a texture, byte by byte.
        public static byte[] Bytes(Texture texture, int layer = 0)
        {
            uint ticket = Native.sg_read_texture(new Native.Region { texture = texture.handle, z = (uint)layer }, (uint)texture.m_Width, (uint)texture.m_Height, 1);
            return Collect(ticket, (int)GraphicsFormatUtility.GetBlockSize(texture.m_Format) * texture.m_Width * texture.m_Height);
        }
        static byte[] Collect(uint ticket, int count)
        {
            var bytes = new byte[count];
            Native.sg_submit();
            bool came;
            fixed (byte* to = bytes) came = Native.sg_collect(ticket, to, (ulong)count) != 0;
            Gpu.Check("reading back");
            return came ? bytes : throw new InvalidOperationException("nothing came back; the log says why");
        }

        internal static Color Decode(byte[] bytes, long at, GraphicsFormat format)
        {
            int i = (int)at;
            float Half(int n) => StandIn.Half.ToSingle(BitConverter.ToUInt16(bytes, i + n * 2));
            float Single(int n) => BitConverter.ToSingle(bytes, i + n * 4);
            float Bits(uint value, int exponentShift, int mantissaBits)
            {
                uint exponent = value >> mantissaBits & 31, mantissa = value & (1u << mantissaBits) - 1;
                return exponent == 0 ? mantissa * Mathf.Pow(2, -14 - mantissaBits) : Mathf.Pow(2, (int)exponent - 15) * (1 + mantissa / (float)(1 << mantissaBits));
            }
            switch (format)
            {
                case GraphicsFormat.R8_UNorm: return new Color(bytes[i] / 255f, 0, 0);
                case GraphicsFormat.R8G8_UNorm: return new Color(bytes[i] / 255f, bytes[i + 1] / 255f, 0);
                case GraphicsFormat.R8G8B8A8_UNorm: return new Color32(bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]);
                case GraphicsFormat.R8G8B8A8_SRGB: return ((Color)new Color32(bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3])).linear;
                case GraphicsFormat.B8G8R8A8_UNorm: return new Color32(bytes[i + 2], bytes[i + 1], bytes[i], bytes[i + 3]);
                case GraphicsFormat.B8G8R8A8_SRGB: return ((Color)new Color32(bytes[i + 2], bytes[i + 1], bytes[i], bytes[i + 3])).linear;
                case GraphicsFormat.R16_UNorm: return new Color(BitConverter.ToUInt16(bytes, i) / 65535f, 0, 0);
                case GraphicsFormat.R16_SFloat: return new Color(Half(0), 0, 0);
                case GraphicsFormat.R16G16_SFloat: return new Color(Half(0), Half(1), 0);
                case GraphicsFormat.R16G16B16A16_SFloat: return new Color(Half(0), Half(1), Half(2), Half(3));
                case GraphicsFormat.R32_SFloat: case GraphicsFormat.D32_SFloat: return new Color(Single(0), 0, 0);
                case GraphicsFormat.R32G32_SFloat: return new Color(Single(0), Single(1), 0);
                case GraphicsFormat.R32G32B32A32_SFloat: return new Color(Single(0), Single(1), Single(2), Single(3));
                case GraphicsFormat.B10G11R11_UFloatPack32:
                    uint packed = BitConverter.ToUInt32(bytes, i);
                    return new Color(Bits(packed & 0x7ff, 6, 6), Bits(packed >> 11 & 0x7ff, 6, 6), Bits(packed >> 22, 5, 5));
                default: throw new NotImplementedException($"the stand-in decodes no {format}");
            }
        }
        internal static void Encode(Color color, byte[] bytes, long at, GraphicsFormat format)
        {
            int i = (int)at;
            void Half(int n) { var half = StandIn.Half.FromSingle(color[n]); bytes[i + n * 2] = (byte)half; bytes[i + n * 2 + 1] = (byte)(half >> 8); }
            void Single(int n) => BitConverter.GetBytes(color[n]).CopyTo(bytes, i + n * 4);
            void Norm(Color32 value) { bytes[i] = value.r; bytes[i + 1] = value.g; bytes[i + 2] = value.b; bytes[i + 3] = value.a; }
            switch (format)
            {
                case GraphicsFormat.R8_UNorm: bytes[i] = ((Color32)color).r; break;
                case GraphicsFormat.R8G8B8A8_UNorm: case GraphicsFormat.R8G8B8A8_SRGB: Norm(color); break;
                case GraphicsFormat.R16_UNorm: BitConverter.GetBytes((ushort)Math.Round(Mathf.Clamp01(color.r) * 65535)).CopyTo(bytes, i); break;
                case GraphicsFormat.R16_SFloat: Half(0); break;
                case GraphicsFormat.R16G16B16A16_SFloat: for (int n = 0; n < 4; n++) Half(n); break;
                case GraphicsFormat.R32_SFloat: Single(0); break;
                case GraphicsFormat.R32G32B32A32_SFloat: for (int n = 0; n < 4; n++) Single(n); break;
                default: throw new NotImplementedException($"the stand-in encodes no {format}");
            }
        }
    }
}
