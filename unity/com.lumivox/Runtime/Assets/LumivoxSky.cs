using System;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>A map of light from all around, of a Radiance (.hdr) or OpenEXR (.exr) panorama, for <see cref="LumivoxEnvironment"/>.</summary>
    [PreferBinarySerialization]
    public sealed unsafe class LumivoxSky : ScriptableObject
    {
        [SerializeField, HideInInspector]
        int m_Width;
        [SerializeField, HideInInspector]
        int m_Height;
        /// Linear RGB, rows from straight up, as 32-bit floats lie in memory.
        [SerializeField, HideInInspector]
        byte[] m_Texels = Array.Empty<byte>();
        [SerializeField, HideInInspector]
        string m_File = "";

        [NonSerialized] MapHandle handle;

        /// <summary>Texels around the horizon, and from pole to pole.</summary>
        public Vector2Int size => new Vector2Int(m_Width, m_Height);

        /// <summary>The file that it was read from; empty where there is none.</summary>
        public string file => m_File;

        /// <summary>Reads a panorama, twice as wide as it is high; its middle looks along Unity's +z.</summary>
        /// <exception cref="LumivoxException">It cannot be read.</exception>
        public static LumivoxSky LoadFile(string path)
        {
            Border.Need();
            fixed (byte* utf8 = Border.Utf8(path))
                using (var map = new MapHandle(Border.Checked(Library.lumivox_map_load(utf8))))
                    return Of(map.Pointer);
        }

        /// <summary>What the library has, copied.</summary>
        internal static LumivoxSky Of(IntPtr map)
        {
            var size = stackalloc uint[2];
            var texels = Library.lumivox_map_texels(map, size);
            if (texels == null) throw Border.Error();
            var sky = CreateInstance<LumivoxSky>();
            (sky.m_Width, sky.m_Height) = ((int)size[0], (int)size[1]);
            sky.m_Texels = new byte[12L * size[0] * size[1]];
            new ReadOnlySpan<byte>(texels, sky.m_Texels.Length).CopyTo(sky.m_Texels);
            sky.m_File = Border.TakeText(Library.lumivox_map_file(map)) ?? "";
            sky.name = sky.m_File.Length > 0 ? System.IO.Path.GetFileNameWithoutExtension(sky.m_File) : "Sky";
            return sky;
        }

        /// <summary>For the native library; zero where there is no map in it.</summary>
        internal IntPtr Pointer
        {
            get
            {
                if (handle == null && m_Texels.Length > 0) Build();
                return handle != null ? handle.Pointer : IntPtr.Zero;
            }
        }

        void Build()
        {
            fixed (byte* texels = m_Texels) handle = new MapHandle(Border.Checked(Library.lumivox_map_new((uint)m_Width, (uint)m_Height, (float*)texels)));
            if (m_File.Length == 0) return;
            fixed (byte* utf8 = Border.Utf8(m_File)) Border.Checked(Library.lumivox_map_set_file(handle.Pointer, utf8));
        }

        void OnDisable()
        {
            handle?.Dispose();
            handle = null;
        }
    }
}
