// The border to standin_gpu, and what is alive on its device.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Runtime.InteropServices;
using System.Text;
using UnityEngine;
using UnityEngine.Rendering;

namespace StandIn
{
    static unsafe class Native
    {
        const string Library = "standin_gpu";

        [StructLayout(LayoutKind.Sequential)] public struct Bind { public uint stage, binding, handle, level; public ulong offset, size; }
        [StructLayout(LayoutKind.Sequential)] public struct Target { public uint color, colorLayer, depth, depthLayer; public float x, y, width, height; }
        [StructLayout(LayoutKind.Sequential)] public struct Region { public uint texture, level, x, y, z; }
        [StructLayout(LayoutKind.Sequential)]
        public struct DrawState { public uint blend, source, destination, operation, alphaSource, alphaDestination, alphaOperation, colorMask, depthWrite, depthTest, cull, topology; }

        [DllImport(Library)] public static extern uint sg_open(byte* text, uint capacity);
        [DllImport(Library)] public static extern uint sg_name(byte* text, uint capacity);
        [DllImport(Library)] public static extern ulong sg_number(uint which);
        [DllImport(Library)] public static extern uint sg_fault(byte* text, uint capacity);
        [DllImport(Library)] public static extern uint sg_create_buffer(ulong size, uint constant);
        [DllImport(Library)] public static extern uint sg_create_texture(uint format, uint dimension, uint width, uint height, uint depth, uint levels, uint storage, uint target);
        [DllImport(Library)] public static extern void sg_free(uint handle);
        [DllImport(Library)] public static extern void sg_write_buffer(uint buffer, ulong offset, void* data, ulong length);
        [DllImport(Library)] public static extern void sg_write_texture(Region to, uint width, uint height, uint depth, void* data, ulong length);
        [DllImport(Library)] public static extern void sg_copy_buffer(uint from, ulong fromOffset, uint to, ulong toOffset, ulong size);
        [DllImport(Library)] public static extern void sg_copy_texture(Region from, Region to, uint width, uint height, uint depth);
        [DllImport(Library)] public static extern uint sg_create_kernel(void* words, ulong count);
        [DllImport(Library)] public static extern uint sg_create_program(void* vertex, ulong vertexCount, void* fragment, ulong fragmentCount);
        [DllImport(Library)] public static extern uint sg_describe(uint number, uint stage, byte* text, uint capacity);
        [DllImport(Library)] public static extern void sg_dispatch(uint kernel, Bind* binds, uint count, uint x, uint y, uint z);
        [DllImport(Library)] public static extern void sg_draw(uint program, Target target, DrawState state, Bind* binds, uint count, uint vertices, uint instances);
        [DllImport(Library)] public static extern void sg_clear(Target target, uint color, float r, float g, float b, float a, uint depth, float value);
        [DllImport(Library)] public static extern void sg_fill(Target target, uint width, void* pixels, ulong length);
        [DllImport(Library)] public static extern void sg_blit(uint from, uint layer, Target target, uint flip);
        [DllImport(Library)] public static extern uint sg_read_buffer(uint from, ulong offset, ulong size);
        [DllImport(Library)] public static extern uint sg_read_texture(Region from, uint width, uint height, uint depth);
        [DllImport(Library)] public static extern void sg_submit();
        [DllImport(Library)] public static extern uint sg_collect(uint ticket, void* data, ulong length);
    }

    /// The device behind the engine.
    public static unsafe class Gpu
    {
        static bool isOpen;
        static string deviceName;
        static readonly byte[] text = new byte[1 << 16];

        internal static void Open()
        {
            if (isOpen) return;
            fixed (byte* to = text)
            {
                uint length = Native.sg_open(to, (uint)text.Length);
                if (length > 0) throw new InvalidOperationException("the stand-in has no GPU: " + Text(length));
                deviceName = Text(Native.sg_name(to, (uint)text.Length));
            }
            isOpen = true;
        }
        static string Text(uint length) => Encoding.UTF8.GetString(text, 0, (int)Math.Min(length, text.Length));
        public static string name { get { Open(); return deviceName; } }
        internal static ulong Number(uint which) { Open(); return Native.sg_number(which); }
        /// Resources on the device, the stand-in's own included.
        public static int resources => (int)Number(5);
        /// How often work was submitted.
        public static long submissions => (long)Number(6);

        /// Logs what the device found wrong.
        internal static void Check(string during)
        {
            fixed (byte* to = text)
                for (uint length; (length = Native.sg_fault(to, (uint)text.Length)) > 0;) Debug.LogError($"{during}: {Text(length)}");
        }
        internal static string Describe(uint number, uint stage) { fixed (byte* to = text) return Text(Native.sg_describe(number, stage, to, (uint)text.Length)); }
        internal static void Submit(string during) { Native.sg_submit(); Check(during); }
    }

    /// What holds memory of the device and was not released.
    public static class Live
    {
        static readonly HashSet<object> all = new HashSet<object>();
        internal static void Add(object resource) => all.Add(resource);
        internal static void Remove(object resource) => all.Remove(resource);
        public static int buffers => all.Count(item => item is GraphicsBuffer);
        public static int textures => all.Count(item => item is Texture && !(item is RenderTexture));
        public static int renderTextures => all.Count(item => item is RenderTexture);
        public static int commandBuffers => all.Count(item => item is CommandBuffer);
        /// Native arrays and other memory from Unity's allocators.
        public static int allocations => Unity.Collections.LowLevel.Unsafe.UnsafeUtility.live;
#if ENABLE_UNITY_COLLECTIONS_CHECKS
        public static int safetyHandles => Unity.Collections.LowLevel.Unsafe.AtomicSafetyHandle.live;
#else
        public static int safetyHandles => 0;
#endif
        public static long bytes => all.Sum(item => item switch { GraphicsBuffer buffer => (long)buffer.count * buffer.stride, Texture texture => texture.bytes, _ => 0 });
        public static int total => buffers + textures + renderTextures + commandBuffers;
        /// A line each, for messages.
        public static string Describe() => string.Join("\n", all.Select(item => item switch
        {
            GraphicsBuffer buffer => $"GraphicsBuffer '{buffer.name}' ({buffer.target}, {(long)buffer.count * buffer.stride} bytes)",
            Texture texture => $"{texture.GetType().Name} '{texture.label}' ({texture.width} x {texture.height}, {texture.graphicsFormat})",
            CommandBuffer commands => $"CommandBuffer '{commands.name}'",
            _ => item.ToString(),
        }));
    }
}
