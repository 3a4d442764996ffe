using System;
using System.Collections.Generic;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;

namespace UnityEngine
{
    public struct GraphicsBufferHandle
    {
        public readonly uint value;
        internal GraphicsBufferHandle(uint value) => this.value = value;
    }

    public sealed class GraphicsBuffer : IDisposable
    {
        [Flags]
        public enum Target { Vertex = 1, Index = 2, CopySource = 4, CopyDestination = 8, Structured = 16, Raw = 32, Append = 64, Counter = 128, IndirectArguments = 256, Constant = 512 }
        [Flags]
        public enum UsageFlags { None = 0, LockBufferForWrite = 1 }

        internal uint handle;
        readonly UsageFlags usage;
        public int count { get; }
        public int stride { get; }
        public Target target { get; }
        public UsageFlags usageFlags => usage;
        string label = "";
        public string name { internal get => label; set => label = value; }

        public GraphicsBuffer(Target target, int count, int stride) : this(target, UsageFlags.None, count, stride) { }
        public GraphicsBuffer(Target target, UsageFlags usageFlags, int count, int stride)
        {
            StandIn.Threads.Main("GraphicsBuffer..ctor");
            if (count <= 0) throw new ArgumentException("Attempting to create a zero length graphics buffer", nameof(count));
            if (stride <= 0) throw new ArgumentException("Attempting to create a graphics buffer with a negative or null stride", nameof(stride));
            if ((target & Target.Index) != 0 && stride != 2 && stride != 4) throw new ArgumentException("Attempting to create an index buffer with an invalid stride: " + stride, nameof(stride));
            if ((target & Target.Index) == 0 && stride % 4 != 0) throw new ArgumentException($"Stride must be a multiple of 4 unless the buffer is intended to be used as an index buffer. ({stride})", nameof(stride));
            if ((target & Target.Raw) != 0 && stride != 4) throw new ArgumentException($"A raw buffer has a stride of 4 bytes. ({stride})", nameof(stride));
            var bytes = (ulong)count * (ulong)stride;
            if ((target & Target.Constant) != 0 && bytes > 65536) throw new ArgumentException($"A constant buffer has at most 65536 bytes. ({bytes})", nameof(count));
            if ((target & Target.Constant) != 0 && bytes % 16 != 0) throw new ArgumentException($"A constant buffer's size is a multiple of 16 bytes. ({bytes})", nameof(count));
            if (bytes > (ulong)SystemInfo.maxGraphicsBufferSize) throw new ArgumentException($"The total size of the graphics buffer ({bytes} bytes) exceeds the maximum buffer size. Maximum supported buffer size: {SystemInfo.maxGraphicsBufferSize} bytes", nameof(count));
            if (StandIn.Faults.TakeAllocation()) throw new UnityException("Failed to create a graphics buffer: out of memory (asked for by a test)");
            StandIn.Gpu.Open();
            this.target = target;
            this.count = count;
            this.stride = stride;
            usage = usageFlags;
            handle = StandIn.Native.sg_create_buffer(bytes, (target & Target.Constant) != 0 ? 1u : 0);
            StandIn.Gpu.Check("GraphicsBuffer..ctor");
            if (handle == 0) throw new UnityException("Failed to create a graphics buffer");
            StandIn.Live.Add(this);
        }
        ~GraphicsBuffer()
        {
            if (handle != 0) Debug.LogWarning($"GarbageCollector disposing of GraphicsBuffer. Please use GraphicsBuffer.Release() or .Dispose() to manually release the buffer. {label}");
        }
        public bool IsValid() => handle != 0;
        public void Dispose() => Release();
        public void Release()
        {
            StandIn.Threads.Main("GraphicsBuffer.Release");
            if (handle == 0) return;
            StandIn.Native.sg_free(handle);
            handle = 0;
            StandIn.Live.Remove(this);
            GC.SuppressFinalize(this);
        }
        internal void Valid()
        {
            if (handle == 0) throw new NullReferenceException($"The GraphicsBuffer '{label}' was released.");
        }
        internal void CheckRange(long start, long length, string what)
        {
            if (start < 0 || length < 0 || start + length > (long)count * stride) throw new ArgumentOutOfRangeException(what, $"Bad indices/count: bytes {start} to {start + length} of a GraphicsBuffer of {(long)count * stride}");
        }
        public void SetData<T>(NativeArray<T> data) where T : struct => SetData(data, 0, 0, data.Length);
        public unsafe void SetData<T>(NativeArray<T> data, int nativeBufferStartIndex, int graphicsBufferStartIndex, int count) where T : struct
        {
            StandIn.Threads.Main("GraphicsBuffer.SetData");
            Valid();
            int size = UnsafeUtility.SizeOf<T>();
            if (nativeBufferStartIndex < 0 || count < 0 || nativeBufferStartIndex + count > data.Length) throw new ArgumentOutOfRangeException(nameof(count), $"Bad indices/count arguments (nativeBufferStartIndex:{nativeBufferStartIndex} graphicsBufferStartIndex:{graphicsBufferStartIndex} count:{count})");
            CheckRange((long)graphicsBufferStartIndex * size, (long)count * size, nameof(count));
            StandIn.Native.sg_write_buffer(handle, (ulong)graphicsBufferStartIndex * (ulong)size, (byte*)data.GetUnsafeReadOnlyPtr() + (long)nativeBufferStartIndex * size, (ulong)count * (ulong)size);
            StandIn.Gpu.Submit("GraphicsBuffer.SetData");
        }
        public void SetData(Array data)
        {
            var elements = data.GetType().GetElementType();
            var bytes = StandIn.Pinned.Bytes(data);
            using (var copy = new NativeArray<byte>(bytes, Allocator.Temp)) SetData(copy, 0, 0, bytes.Length);
        }
        public void SetData<T>(List<T> data) where T : struct => SetData(data.ToArray());
        public void SetData(Array data, int managedBufferStartIndex, int graphicsBufferStartIndex, int count) => throw new NotImplementedException("the stand-in sets whole arrays only");
        public void GetData(Array data)
        {
            StandIn.Threads.Main("GraphicsBuffer.GetData");
            Valid();
            int bytes = System.Runtime.InteropServices.Marshal.SizeOf(data.GetType().GetElementType()) * data.Length;
            CheckRange(0, bytes, nameof(data));
            var read = StandIn.Pictures.Read(this, 0, bytes);
            Buffer.BlockCopy(read, 0, data, 0, bytes);
        }
        public static void CopyCount(GraphicsBuffer src, GraphicsBuffer dst, int dstOffsetBytes) => throw new NotImplementedException("the stand-in's buffers have no counters");
        public NativeArray<T> LockBufferForWrite<T>(int bufferStartIndex, int count) where T : struct => throw new NotImplementedException("the stand-in's buffers are not locked");
    }
}

namespace StandIn
{
    static class Pinned
    {
        internal static byte[] Bytes(Array data)
        {
            int size = System.Runtime.InteropServices.Marshal.SizeOf(data.GetType().GetElementType());
            var bytes = new byte[size * data.Length];
            var pin = System.Runtime.InteropServices.GCHandle.Alloc(data, System.Runtime.InteropServices.GCHandleType.Pinned);
            try { System.Runtime.InteropServices.Marshal.Copy(pin.AddrOfPinnedObject(), bytes, 0, bytes.Length); }
            finally { pin.Free(); }
            return bytes;
        }
    }

    /// What a test makes go wrong.
    public static class Faults
    {
        /// How many more buffers and textures can be made; -1: any number.
        public static int allocationsLeft = -1;
        internal static bool TakeAllocation() => allocationsLeft >= 0 && allocationsLeft-- == 0 && Stay();
        static bool Stay() { allocationsLeft = 0; return true; }
        /// Read-backs come back with `hasError`.
        public static bool failReadBacks;
        /// `GraphicsFormat`s that the device is said not to have, for reading or for writing by kernels.
        public static readonly HashSet<UnityEngine.Experimental.Rendering.GraphicsFormat> missingFormats = new HashSet<UnityEngine.Experimental.Rendering.GraphicsFormat>();
        /// Those that render textures cannot have, and those that no read-back takes, as where they are compressed.
        public static readonly HashSet<UnityEngine.Experimental.Rendering.GraphicsFormat> missingRender = new HashSet<UnityEngine.Experimental.Rendering.GraphicsFormat>(), missingReadPixels = new HashSet<UnityEngine.Experimental.Rendering.GraphicsFormat>();
        public static readonly HashSet<UnityEngine.Experimental.Rendering.GraphicsFormat> missingLoadStore = new HashSet<UnityEngine.Experimental.Rendering.GraphicsFormat>();
        public static bool noComputeShaders, noAsyncReadback;
        public static int maxTexture3DSize, maxTextureSize;
        public static long maxGraphicsBufferSize;
        public static void Clear()
        {
            allocationsLeft = -1;
            failReadBacks = noComputeShaders = noAsyncReadback = false;
            missingFormats.Clear();
            missingLoadStore.Clear();
            missingRender.Clear();
            missingReadPixels.Clear();
            maxTexture3DSize = maxTextureSize = 0;
            maxGraphicsBufferSize = 0;
        }
    }
}
