// Small buffers that every frame needs anew: contents of constant buffers, and texels on their way into textures.
using System;
using System.Collections.Generic;
using UnityEngine;

namespace Lumivox
{
    /// <summary>Constant buffers by size. Each is written once per recording, and taken again in the next frame.</summary>
    internal sealed class ConstantPool : IDisposable
    {
        sealed class Size
        {
            public readonly List<GraphicsBuffer> Buffers = new List<GraphicsBuffer>();
            public int Used;
        }

        readonly Dictionary<int, Size> sizes = new Dictionary<int, Size>();

        public GraphicsBuffer Take(int bytes)
        {
            if (!sizes.TryGetValue(bytes, out var size)) sizes[bytes] = size = new Size();
            if (size.Used == size.Buffers.Count)
                size.Buffers.Add(new GraphicsBuffer(GraphicsBuffer.Target.Constant, bytes / 16, 16));
            return size.Buffers[size.Used++];
        }

        public void BeginFrame()
        {
            foreach (var size in sizes.Values) size.Used = 0;
        }

        public void Dispose()
        {
            foreach (var size in sizes.Values)
                foreach (var buffer in size.Buffers) buffer.Dispose();
            sizes.Clear();
        }
    }

    /// <summary>Raw buffers that texels are uploaded through. One is not written again before it was surely read.</summary>
    internal sealed class StagingPool : IDisposable
    {
        /// <summary>Most bytes of a buffer.</summary>
        public const int Largest = 64 << 20;

        const int Smallest = 64 << 10;
        /// <summary>Turns after which what was written has been read, and after which a buffer is no longer kept.</summary>
        const int Busy = 3, Kept = 300;

        struct Entry
        {
            public GraphicsBuffer Buffer;
            public int Bytes;
            public long Taken;
        }

        readonly List<Entry> entries = new List<Entry>();

        public GraphicsBuffer Take(int bytes, long turn)
        {
            var wanted = Smallest;
            while (wanted < bytes) wanted *= 2;
            for (var i = 0; i < entries.Count; i++)
            {
                var entry = entries[i];
                if (entry.Bytes != wanted || turn - entry.Taken < Busy) continue;
                entry.Taken = turn;
                entries[i] = entry;
                return entry.Buffer;
            }
            var buffer = new GraphicsBuffer(GraphicsBuffer.Target.Raw, wanted / 4, 4);
            entries.Add(new Entry { Buffer = buffer, Bytes = wanted, Taken = turn });
            return buffer;
        }

        public void Trim(long turn)
        {
            for (var i = entries.Count - 1; i >= 0; i--)
            {
                if (turn - entries[i].Taken < Kept) continue;
                entries[i].Buffer.Dispose();
                entries.RemoveAt(i);
            }
        }

        public void Dispose()
        {
            foreach (var entry in entries) entry.Buffer.Dispose();
            entries.Clear();
        }
    }
}
