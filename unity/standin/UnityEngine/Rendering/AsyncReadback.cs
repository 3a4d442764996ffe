using System;
using System.Collections.Generic;
using System.Linq;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;

namespace UnityEngine.Rendering
{
    public struct AsyncGPUReadbackRequest
    {
        internal StandIn.ReadBacks.Pending pending;
        StandIn.ReadBacks.Pending Known => pending ?? throw new InvalidOperationException("an AsyncGPUReadbackRequest that nobody made");
        public bool done => Known.isDone;
        public bool hasError => Known.hasError;
        public int layerCount => Known.depth;
        public int layerDataSize => Known.bytes / Math.Max(Known.depth, 1);
        public int width => Known.width;
        public int height => Known.height;
        public int depth => Known.depth;
        public bool forcePlayerLoopUpdate { get; set; }
        public void Update() { StandIn.Threads.Main("AsyncGPUReadbackRequest.Update"); }
        public void WaitForCompletion() { StandIn.Threads.Main("WaitForCompletion"); StandIn.ReadBacks.Complete(Known); }
        /// Its bytes, which are there in the frame in which it was done.
        public NativeArray<T> GetData<T>(int layer = 0) where T : struct
        {
            StandIn.Threads.Main("GetData");
            if (!done || hasError) throw new InvalidOperationException("Cannot access the data as it is not available");
            if (Known.isGone) throw new InvalidOperationException("Cannot access the data as it is no longer available: it lasts for one frame");
            if (layer < 0 || layer >= layerCount) throw new ArgumentException($"Layer index is out of range {layer} / {layerCount}");
            return Known.data.GetSubArray(layer * layerDataSize, layerDataSize).Reinterpret<T>(1);
        }
    }

    public static class AsyncGPUReadback
    {
        static AsyncGPUReadbackRequest Ask(Action<CommandBuffer> record, Action<AsyncGPUReadbackRequest> callback)
        {
            StandIn.Threads.Main("AsyncGPUReadback.Request");
            using (var commands = new CommandBuffer { name = "AsyncGPUReadback" }) { record(commands); Graphics.ExecuteCommandBuffer(commands); }
            return new AsyncGPUReadbackRequest { pending = StandIn.ReadBacks.last };
        }
        static readonly Action<AsyncGPUReadbackRequest> nothing = request => { };
        public static AsyncGPUReadbackRequest Request(GraphicsBuffer src, Action<AsyncGPUReadbackRequest> callback = null) => Ask(commands => commands.RequestAsyncReadback(src, callback ?? nothing), callback);
        public static AsyncGPUReadbackRequest Request(GraphicsBuffer src, int size, int offset, Action<AsyncGPUReadbackRequest> callback = null) => Ask(commands => commands.RequestAsyncReadback(src, size, offset, callback ?? nothing), callback);
        static AsyncGPUReadbackRequest Readable(Texture src, AsyncGPUReadbackRequest request)
        {
            if (UnityEngine.SystemInfo.Has(src.m_Format, false, false, false, true)) return request;
            Debug.LogError($"'{src.m_Format}' doesn't support ReadPixels usage on this platform. Async GPU readback failed.");
            request.pending.isRefused = true;
            return request;
        }
        public static AsyncGPUReadbackRequest Request(Texture src, int mipIndex = 0, Action<AsyncGPUReadbackRequest> callback = null) => Readable(src, AskTexture(src, mipIndex, callback));
        static AsyncGPUReadbackRequest AskTexture(Texture src, int mipIndex, Action<AsyncGPUReadbackRequest> callback) => Ask(commands => commands.RequestAsyncReadback(src, mipIndex, callback ?? nothing), callback);
        public static AsyncGPUReadbackRequest Request(Texture src, int mipIndex, TextureFormat dstFormat, Action<AsyncGPUReadbackRequest> callback = null)
        {
            var wanted = UnityEngine.Experimental.Rendering.GraphicsFormatUtility.GetGraphicsFormat(dstFormat, src.isDataSRGB);
            AsyncGPUReadbackRequest request;
            using (StandIn.Callbacks.Own()) request = Request(src, mipIndex, callback);
            if (wanted == src.m_Format) return request;
            if (src.isDataSRGB) throw new NotImplementedException("the stand-in converts no read-backs of encoded colours");
            request.pending.Convert(src.m_Format, wanted);
            return request;
        }
        public static void WaitAllRequests() { StandIn.Threads.Main("WaitAllRequests"); StandIn.ReadBacks.CompleteAll(); }
    }
}

namespace StandIn
{
    public static class ReadBacks
    {
        internal sealed class Pending
        {
            internal Action<UnityEngine.Rendering.AsyncGPUReadbackRequest> callback;
            internal uint ticket;
            internal int bytes, width, height, depth, age;
            internal bool isDone, hasError, isGone, isRefused;
            internal NativeArray<byte> data;
            UnityEngine.Experimental.Rendering.GraphicsFormat from, to;
            int raw;

            /// What is kept on the device, and what is asked for.
            internal void Convert(UnityEngine.Experimental.Rendering.GraphicsFormat from, UnityEngine.Experimental.Rendering.GraphicsFormat to)
            {
                (this.from, this.to, raw) = (from, to, bytes);
                bytes = checked((int)(bytes / Size(from) * Size(to)));
            }
            static uint Size(UnityEngine.Experimental.Rendering.GraphicsFormat format) => UnityEngine.Experimental.Rendering.GraphicsFormatUtility.GetBlockSize(format);

            internal unsafe bool Collect()
            {
                if (raw == 0) return Native.sg_collect(ticket, data.GetUnsafePtr(), (ulong)bytes) != 0;
                var came = new byte[raw];
                fixed (byte* at = came) if (Native.sg_collect(ticket, at, (ulong)raw) == 0) return false;
                var converted = new byte[bytes];
                uint a = Size(from), b = Size(to);
                for (int i = 0; i < raw / a; i++) Pictures.Encode(Pictures.Decode(came, i * a, from), converted, i * b, to);
                data.CopyFrom(converted);
                return true;
            }
        }
        static readonly List<Pending> waiting = new List<Pending>(), done = new List<Pending>();
        internal static Pending last;
        /// Frames after which a read-back arrives.
        public static int latency = 2;
        public static int count => waiting.Count;

        internal static void Add(Action<UnityEngine.Rendering.AsyncGPUReadbackRequest> callback, uint ticket, int bytes, int width, int height, int depth) =>
            waiting.Add(last = new Pending { callback = callback, ticket = ticket, bytes = bytes, width = width, height = height, depth = depth });

        /// A frame went by.
        internal static void Frame()
        {
            foreach (var old in done) { old.isGone = true; old.data.Dispose(); }
            done.Clear();
            foreach (var pending in waiting.ToArray()) if (++pending.age > latency) Complete(pending);
        }
        internal static void Complete(Pending pending)
        {
            if (!waiting.Remove(pending)) return;
            pending.data = new NativeArray<byte>(pending.bytes, Allocator.Persistent);
            pending.hasError = pending.ticket == 0 || !pending.Collect() || pending.isRefused || Faults.failReadBacks;
            Gpu.Check("a read-back");
            pending.isDone = true;
            done.Add(pending);
            try { using (Callbacks.Counted()) pending.callback(new UnityEngine.Rendering.AsyncGPUReadbackRequest { pending = pending }); }
            catch (Exception error) { UnityEngine.Debug.LogException(error); }
        }
        internal static void CompleteAll() { while (waiting.Count > 0) Complete(waiting[0]); }
        /// Between tests: what is on its way comes to nobody.
        public static void Forget()
        {
            foreach (var pending in waiting) pending.callback = request => { };
            CompleteAll();
            foreach (var old in done) { old.isGone = true; old.data.Dispose(); }
            done.Clear();
        }
    }
}
