using System;
using System.Collections;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using Unity.Collections.LowLevel.Unsafe;

namespace Unity.Collections
{
    public enum Allocator { Invalid, None, Temp, TempJob, Persistent, AudioKernel, FirstUserIndex = 64 }
    public enum NativeArrayOptions { UninitializedMemory, ClearMemory }
    [AttributeUsage(AttributeTargets.Field | AttributeTargets.Parameter | AttributeTargets.ReturnValue)] public sealed class ReadOnlyAttribute : Attribute { }
    [AttributeUsage(AttributeTargets.Field | AttributeTargets.Parameter | AttributeTargets.ReturnValue)] public sealed class WriteOnlyAttribute : Attribute { }

    public unsafe struct NativeArray<T> : IDisposable, IEnumerable<T>, IEquatable<NativeArray<T>> where T : struct
    {
        internal void* m_Buffer;
        internal int m_Length;
        internal Allocator m_AllocatorLabel;
#if ENABLE_UNITY_COLLECTIONS_CHECKS
        internal AtomicSafetyHandle m_Safety;
#endif
        public NativeArray(int length, Allocator allocator, NativeArrayOptions options = NativeArrayOptions.ClearMemory)
        {
            if (allocator <= Allocator.None) throw new ArgumentException("Allocator must be Temp, TempJob or Persistent", nameof(allocator));
            if (length < 0) throw new ArgumentOutOfRangeException(nameof(length), "Length must be >= 0");
            var bytes = (long)length * UnsafeUtility.SizeOf<T>();
            m_Buffer = UnsafeUtility.Malloc(bytes, 16, allocator);
            m_Length = length;
            m_AllocatorLabel = allocator;
#if ENABLE_UNITY_COLLECTIONS_CHECKS
            m_Safety = AtomicSafetyHandle.Create();
#endif
            if (options == NativeArrayOptions.ClearMemory) UnsafeUtility.MemClear(m_Buffer, bytes);
        }
        public NativeArray(T[] array, Allocator allocator) : this(array.Length, allocator, NativeArrayOptions.UninitializedMemory) => CopyFrom(array);
        public NativeArray(NativeArray<T> array, Allocator allocator) : this(array.Length, allocator, NativeArrayOptions.UninitializedMemory) => CopyFrom(array);

        internal void CheckRead()
        {
#if ENABLE_UNITY_COLLECTIONS_CHECKS
            AtomicSafetyHandle.CheckReadAndThrow(m_Safety);
#endif
        }
        internal void CheckWrite()
        {
#if ENABLE_UNITY_COLLECTIONS_CHECKS
            AtomicSafetyHandle.CheckWriteAndThrow(m_Safety);
#endif
        }
        public int Length => m_Length;
        public bool IsCreated => m_Buffer != null;
        public T this[int index]
        {
            get { CheckRead(); return InRange(index)[index]; }
            set { CheckWrite(); InRange(index)[index] = value; }
        }
        Span<T> InRange(int index)
        {
            if ((uint)index >= (uint)m_Length) throw new IndexOutOfRangeException($"Index {index} is out of range of '{m_Length}' Length.");
            return new Span<T>(m_Buffer, m_Length);
        }
        public void Dispose()
        {
            if (m_Buffer == null) throw new ObjectDisposedException("The NativeArray is already disposed.");
            if (m_AllocatorLabel == Allocator.Invalid) throw new InvalidOperationException("The NativeArray can not be Disposed because it was not allocated with a valid allocator.");
#if ENABLE_UNITY_COLLECTIONS_CHECKS
            AtomicSafetyHandle.Release(m_Safety);
#endif
            if (m_AllocatorLabel > Allocator.None) UnsafeUtility.Free(m_Buffer, m_AllocatorLabel);
            m_Buffer = null;
            m_AllocatorLabel = Allocator.Invalid;
        }
        public Span<T> AsSpan() { CheckWrite(); return new Span<T>(m_Buffer, m_Length); }
        public ReadOnlySpan<T> AsReadOnlySpan() { CheckRead(); return new ReadOnlySpan<T>(m_Buffer, m_Length); }
        public ReadOnly AsReadOnly() => new ReadOnly { array = this };
        public T[] ToArray() => AsReadOnlySpan().ToArray();
        public void CopyFrom(T[] array) { if (array.Length != m_Length) throw new ArgumentException("source and destination length must be the same"); CheckWrite(); new Span<T>(array).CopyTo(new Span<T>(m_Buffer, m_Length)); }
        public void CopyFrom(NativeArray<T> array) => Copy(array, this);
        public void CopyTo(T[] array) { if (array.Length != m_Length) throw new ArgumentException("source and destination length must be the same"); AsReadOnlySpan().CopyTo(array); }
        public void CopyTo(NativeArray<T> array) => Copy(this, array);
        public static void Copy(NativeArray<T> src, NativeArray<T> dst) { if (src.Length != dst.Length) throw new ArgumentException("source and destination length must be the same"); Copy(src, 0, dst, 0, src.Length); }
        public static void Copy(T[] src, NativeArray<T> dst) => dst.CopyFrom(src);
        public static void Copy(NativeArray<T> src, T[] dst) => src.CopyTo(dst);
        public static void Copy(NativeArray<T> src, int srcIndex, NativeArray<T> dst, int dstIndex, int length) { dst.CheckWrite(); src.AsReadOnlySpan().Slice(srcIndex, length).CopyTo(new Span<T>(dst.m_Buffer, dst.m_Length).Slice(dstIndex)); }
        public static void Copy(T[] src, int srcIndex, NativeArray<T> dst, int dstIndex, int length) { dst.CheckWrite(); new ReadOnlySpan<T>(src, srcIndex, length).CopyTo(new Span<T>(dst.m_Buffer, dst.m_Length).Slice(dstIndex)); }
        public static void Copy(NativeArray<T> src, int srcIndex, T[] dst, int dstIndex, int length) => src.AsReadOnlySpan().Slice(srcIndex, length).CopyTo(new Span<T>(dst, dstIndex, length));
        public NativeArray<T> GetSubArray(int start, int length)
        {
            CheckRead();
            if (start < 0 || length < 0 || start + length > m_Length) throw new ArgumentOutOfRangeException(nameof(length), $"sub array range {start}-{start + length - 1} is outside the range of the native array 0-{m_Length - 1}");
            var part = this;
            part.m_Buffer = (byte*)m_Buffer + (long)start * UnsafeUtility.SizeOf<T>();
            part.m_Length = length;
            part.m_AllocatorLabel = Allocator.None;
            return part;
        }
        public NativeArray<U> Reinterpret<U>(int expectedTypeSize) where U : struct
        {
            CheckRead();
            if (expectedTypeSize != UnsafeUtility.SizeOf<T>()) throw new InvalidOperationException($"Type {typeof(T)} was expected to be {expectedTypeSize} but is {UnsafeUtility.SizeOf<T>()} bytes");
            long bytes = (long)m_Length * expectedTypeSize;
            if (bytes % UnsafeUtility.SizeOf<U>() != 0) throw new InvalidOperationException($"Types {typeof(T)} (array length {m_Length}) and {typeof(U)} cannot be aliased due to size constraints.");
            var other = new NativeArray<U> { m_Buffer = m_Buffer, m_Length = (int)(bytes / UnsafeUtility.SizeOf<U>()), m_AllocatorLabel = m_AllocatorLabel };
#if ENABLE_UNITY_COLLECTIONS_CHECKS
            other.m_Safety = m_Safety;
#endif
            return other;
        }
        public NativeArray<U> Reinterpret<U>() where U : struct => UnsafeUtility.SizeOf<T>() == UnsafeUtility.SizeOf<U>() ? Reinterpret<U>(UnsafeUtility.SizeOf<T>()) : throw new InvalidOperationException($"Types {typeof(T)} and {typeof(U)} are different sizes - direct reinterpretation is not possible.");
        public bool Equals(NativeArray<T> other) => m_Buffer == other.m_Buffer && m_Length == other.m_Length;
        public override bool Equals(object obj) => obj is NativeArray<T> array && Equals(array);
        public override int GetHashCode() => (int)(long)m_Buffer * 397 ^ m_Length;
        public static bool operator ==(NativeArray<T> left, NativeArray<T> right) => left.Equals(right);
        public static bool operator !=(NativeArray<T> left, NativeArray<T> right) => !left.Equals(right);
        public Enumerator GetEnumerator() => new Enumerator { array = this, index = -1 };
        IEnumerator<T> IEnumerable<T>.GetEnumerator() => GetEnumerator();
        IEnumerator IEnumerable.GetEnumerator() => GetEnumerator();
        public struct Enumerator : IEnumerator<T>
        {
            internal NativeArray<T> array;
            internal int index;
            public bool MoveNext() => ++index < array.Length;
            public T Current => array[index];
            object IEnumerator.Current => Current;
            public void Reset() => index = -1;
            public void Dispose() { }
        }
        public struct ReadOnly
        {
            internal NativeArray<T> array;
            public int Length => array.Length;
            public T this[int index] => array[index];
            public T[] ToArray() => array.ToArray();
            public ReadOnlySpan<T> AsReadOnlySpan() => array.AsReadOnlySpan();
        }
        public static implicit operator ReadOnlySpan<T>(in NativeArray<T> source) => source.AsReadOnlySpan();
        public static implicit operator Span<T>(in NativeArray<T> source) => source.AsSpan();
    }
}

namespace Unity.Collections.LowLevel.Unsafe
{
    [AttributeUsage(AttributeTargets.Field)] public sealed class NativeDisableUnsafePtrRestrictionAttribute : Attribute { }

    public static unsafe class UnsafeUtility
    {
        static class Size<T> where T : struct { internal static readonly int bytes = MemoryMarshal.AsBytes(new Span<T>(new T[1])).Length; }
        static readonly HashSet<IntPtr> allocated = new HashSet<IntPtr>();
        /// Allocations that were not freed.
        internal static int live { get { lock (allocated) return allocated.Count; } }
        public static int SizeOf<T>() where T : struct => Size<T>.bytes;
        public static void* Malloc(long size, int alignment, Allocator allocator)
        {
            // Aligned by hand, with what was allocated before it.
            var raw = Marshal.AllocHGlobal((IntPtr)(size + alignment + 16));
            var at = (byte*)(((long)raw + 8 + alignment - 1) / alignment * alignment);
            ((IntPtr*)at)[-1] = raw;
            lock (allocated) allocated.Add((IntPtr)at);
            return at;
        }
        public static void Free(void* memory, Allocator allocator)
        {
            lock (allocated) if (!allocated.Remove((IntPtr)memory)) throw new InvalidOperationException("memory is freed that was not allocated, or twice");
            Marshal.FreeHGlobal(((IntPtr*)memory)[-1]);
        }
        public static void MemCpy(void* destination, void* source, long size) => Buffer.MemoryCopy(source, destination, size, size);
        public static void MemMove(void* destination, void* source, long size) => Buffer.MemoryCopy(source, destination, size, size);
        public static void MemSet(void* destination, byte value, long size) { for (long at = 0; at < size; at += 1 << 30) new Span<byte>((byte*)destination + at, (int)Math.Min(1 << 30, size - at)).Fill(value); }
        public static void MemClear(void* destination, long size) => MemSet(destination, 0, size);
        public static int MemCmp(void* ptr1, void* ptr2, long size) => new ReadOnlySpan<byte>(ptr1, checked((int)size)).SequenceCompareTo(new ReadOnlySpan<byte>(ptr2, (int)size));
        public static bool IsBlittable<T>() where T : struct { try { return SizeOf<T>() > 0; } catch (TypeInitializationException) { return false; } }
        public static T ReadArrayElement<T>(void* source, int index) => new Span<T>(source, index + 1)[index];
        public static void WriteArrayElement<T>(void* destination, int index, T value) => new Span<T>(destination, index + 1)[index] = value;
        public static void* PinGCArrayAndGetDataAddress(Array target, out ulong gcHandle) { var handle = GCHandle.Alloc(target, GCHandleType.Pinned); gcHandle = (ulong)(long)GCHandle.ToIntPtr(handle); return (void*)handle.AddrOfPinnedObject(); }
        public static void ReleaseGCObject(ulong gcHandle) => GCHandle.FromIntPtr((IntPtr)(long)gcHandle).Free();
    }

    public static unsafe class NativeArrayUnsafeUtility
    {
        public static NativeArray<T> ConvertExistingDataToNativeArray<T>(void* dataPointer, int length, Allocator allocator) where T : struct
        {
            if (length < 0) throw new ArgumentOutOfRangeException(nameof(length), "Length must be >= 0");
            return new NativeArray<T> { m_Buffer = dataPointer, m_Length = length, m_AllocatorLabel = allocator };
        }
        public static void* GetUnsafePtr<T>(this NativeArray<T> nativeArray) where T : struct { nativeArray.CheckWrite(); return nativeArray.m_Buffer; }
        public static void* GetUnsafeReadOnlyPtr<T>(this NativeArray<T> nativeArray) where T : struct { nativeArray.CheckRead(); return nativeArray.m_Buffer; }
        public static void* GetUnsafeBufferPointerWithoutChecks<T>(NativeArray<T> nativeArray) where T : struct => nativeArray.m_Buffer;
#if ENABLE_UNITY_COLLECTIONS_CHECKS
        public static AtomicSafetyHandle GetAtomicSafetyHandle<T>(NativeArray<T> array) where T : struct => array.m_Safety;
        public static void SetAtomicSafetyHandle<T>(ref NativeArray<T> array, AtomicSafetyHandle safety) where T : struct => array.m_Safety = safety;
#endif
    }

#if ENABLE_UNITY_COLLECTIONS_CHECKS
    /// Says whether memory may be used: a place in a table, and which of its successive users this is.
    public struct AtomicSafetyHandle
    {
        sealed class Node { internal int version = 1; internal bool isFree; }
        static readonly Stack<Node> free = new Stack<Node>();
        static readonly Node temporary = new Node();
        Node node;
        int version;
        internal static int live;
        public static AtomicSafetyHandle Create()
        {
            lock (free)
            {
                var node = free.Count > 0 ? free.Pop() : new Node();
                node.isFree = false;
                live++;
                return new AtomicSafetyHandle { node = node, version = node.version };
            }
        }
        public static AtomicSafetyHandle GetTempMemoryHandle() => new AtomicSafetyHandle { node = temporary, version = temporary.version };
        public static AtomicSafetyHandle GetTempUnsafePtrSliceHandle() => GetTempMemoryHandle();
        public static bool IsTempMemoryHandle(AtomicSafetyHandle handle) => handle.node == temporary;
        public static bool IsHandleValid(in AtomicSafetyHandle handle) => handle.node != null && handle.node.version == handle.version;
        public static bool IsDefaultValue(in AtomicSafetyHandle handle) => handle.node == null;
        public static void Release(AtomicSafetyHandle handle)
        {
            CheckExistsAndThrow(handle);
            if (handle.node == temporary) return;
            lock (free) { handle.node.version++; handle.node.isFree = true; live--; free.Push(handle.node); }
        }
        public static void CheckExistsAndThrow(in AtomicSafetyHandle handle)
        {
            if (handle.node == null) throw new NullReferenceException("The NativeArray has no AtomicSafetyHandle: in the editor, memory that was converted needs one (NativeArrayUnsafeUtility.SetAtomicSafetyHandle).");
            if (handle.node.version != handle.version) throw new ObjectDisposedException("The NativeArray has been deallocated, it is not allowed to access it");
        }
        public static void CheckReadAndThrow(AtomicSafetyHandle handle) => CheckExistsAndThrow(handle);
        public static void CheckWriteAndThrow(AtomicSafetyHandle handle) => CheckExistsAndThrow(handle);
        public static void CheckDeallocateAndThrow(AtomicSafetyHandle handle) => CheckExistsAndThrow(handle);
        public static void CheckGetSecondaryDataPointerAndThrow(AtomicSafetyHandle handle) => CheckExistsAndThrow(handle);
    }
#endif
}
