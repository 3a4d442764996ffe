// Replays recordings of the native library as Unity's commands. It knows Unity's graphics API and the steps, nothing of
// what they are for. The same commands serve every pipeline.
using System;
using System.Collections.Generic;
using Lumivox.Native;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine;
using UnityEngine.Experimental.Rendering;
using UnityEngine.Rendering;

namespace Lumivox
{
    /// <summary>Something that the GPU has no room for.</summary>
    internal sealed class NoMemoryException : Exception
    {
        public NoMemoryException(string message) : base(message) { }
    }

    internal sealed unsafe partial class Executor : IDisposable
    {
        /// <summary>Turns of the main thread or frames after which every command that was recorded has been executed.</summary>
        const int TurnsUntilExecuted = 3;

        struct Freed
        {
            public GraphicsBuffer Buffer;
            public RenderTexture Texture;
            public long Turn;
        }

        readonly Dictionary<ulong, GraphicsBuffer> buffers = new Dictionary<ulong, GraphicsBuffer>();
        readonly Dictionary<ulong, RenderTexture> textures = new Dictionary<ulong, RenderTexture>();
        // Textures of bytes that are kept as half floats, where there are none of bytes.
        readonly HashSet<ulong> widened = new HashSet<ulong>();
        readonly Dictionary<IntPtr, string> labels = new Dictionary<IntPtr, string>();
        readonly List<Freed> freed = new List<Freed>();
        readonly ConstantPool constants = new ConstantPool();
        readonly StagingPool staging = new StagingPool();
        readonly MaterialPropertyBlock block = new MaterialPropertyBlock();
        readonly KernelLibrary kernels = new KernelLibrary();
        readonly ReadBacks readBacks;
        long turn;
#if ENABLE_UNITY_COLLECTIONS_CHECKS
        // Unity's own arrays have one each; those over the library's memory share this.
        readonly AtomicSafetyHandle safety = AtomicSafetyHandle.Create();
#endif

        readonly bool hasBytes = Formats.AreWritten(GraphicsFormat.R8_UNorm);

        public Executor(IntPtr stage) => readBacks = new ReadBacks(stage);

        /// <summary>Resources that are alive.</summary>
        public int Count => buffers.Count + textures.Count;

        /// <summary>Resources that wait until they are no longer used.</summary>
        public int FreedCount => freed.Count;

        /// <summary>Whether anything is on its way back.</summary>
        public bool AwaitsFeedback => readBacks.IsWaiting;

        /// <summary>Whether the device was lost, and what it held.</summary>
        public bool IsLost
        {
            get
            {
                foreach (var texture in textures.Values) return texture == null || !texture.IsCreated();
                return false;
            }
        }

        /// <summary>A frame begins: what the last one used may be used again.</summary>
        public void BeginFrame()
        {
            constants.BeginFrame();
            Turn();
        }

        /// <summary>Frees what nothing uses any more. Between two turns all that was recorded before them is executed.</summary>
        public void Turn()
        {
            turn++;
            var kept = 0;
            for (var i = 0; i < freed.Count; i++)
            {
                var entry = freed[i];
                if (turn - entry.Turn < TurnsUntilExecuted)
                {
                    freed[kept++] = entry;
                    continue;
                }
                Destroy(entry);
            }
            freed.RemoveRange(kept, freed.Count - kept);
            staging.Trim(turn);
            readBacks.Trim(turn);
        }

        /// <summary>Records the steps' commands. What became of them is `why` empty, or what to tell the library.</summary>
        public Outcome Execute(CommandBuffer cmd, Step* steps, uint count, in HostTargets host, out string why)
        {
            why = null;
            try
            {
                for (uint i = 0; i < count; i++) Do(cmd, ref steps[i], host);
                return Outcome.Executed;
            }
            catch (NoMemoryException error)
            {
                why = error.Message;
                Discard(steps, count);
                return Outcome.NoMemory;
            }
            catch (Exception error)
            {
                why = error.Message;
                if (!(error is LumivoxException)) Debug.LogException(error);
                Discard(steps, count);
                return Outcome.Failed;
            }
        }

        public void Dispose()
        {
            readBacks.Forget();
            foreach (var entry in freed) Destroy(entry);
            freed.Clear();
            foreach (var buffer in buffers.Values) buffer.Dispose();
            buffers.Clear();
            foreach (var texture in textures.Values) Destroy(texture);
            textures.Clear();
            constants.Dispose();
            staging.Dispose();
            kernels.Dispose();
#if ENABLE_UNITY_COLLECTIONS_CHECKS
            AtomicSafetyHandle.Release(safety);
#endif
        }

        void Do(CommandBuffer cmd, ref Step step, in HostTargets host)
        {
            switch (step.kind)
            {
                case StepKind.CreateBuffer:
                    CreateBuffer(cmd, ref step);
                    break;
                case StepKind.CreateTexture:
                    CreateTexture(ref step);
                    break;
                case StepKind.WriteBuffer:
                    WriteBuffer(cmd, Buffer(step.id), step.data, step.offset, step.length);
                    break;
                case StepKind.WriteTexture:
                    WriteTexture(cmd, ref step);
                    break;
                case StepKind.CopyTexture:
                    CopyTexture(cmd, ref step);
                    break;
                case StepKind.ClearBuffer:
                    Clear(cmd, Buffer(step.id));
                    break;
                case StepKind.Dispatch:
                    Dispatch(cmd, ref step, host);
                    break;
                case StepKind.Draw:
                    Draw(cmd, ref step, host);
                    break;
                case StepKind.ReadBuffer:
                    readBacks.Ask(cmd, Buffer(step.id), checked((int)step.length), checked((int)step.offset), host.Ticket, turn);
                    break;
                case StepKind.Free:
                    Free(step.id);
                    break;
                default:
                    throw new LumivoxException($"a fault in Lumivox: there is no step {(uint)step.kind}");
            }
        }

        void CreateBuffer(CommandBuffer cmd, ref Step step)
        {
            var megabytes = step.length >> 20;
            if (step.length > (ulong)SystemInfo.maxGraphicsBufferSize || step.length / 4 > int.MaxValue) throw NoRoom(step.label, megabytes);
            GraphicsBuffer buffer;
            try
            {
                const GraphicsBuffer.Target target = GraphicsBuffer.Target.Raw | GraphicsBuffer.Target.CopySource | GraphicsBuffer.Target.CopyDestination;
                buffer = new GraphicsBuffer(target, (int)(step.length / 4), 4);
            }
            catch (UnityException)
            {
                throw NoRoom(step.label, megabytes);
            }
            if (!buffer.IsValid())
            {
                buffer.Dispose();
                throw NoRoom(step.label, megabytes);
            }
            buffer.name = Label(step.label);
            buffers[step.id] = buffer;
            // Unity does not promise zeros.
            Clear(cmd, buffer);
        }

        void CreateTexture(ref Step step)
        {
            var isFlat = step.size[2] == 0;
            var depth = isFlat ? 1 : (int)step.size[2];
            var format = Format(step.format);
            var isWidened = format == GraphicsFormat.R8_UNorm && !hasBytes;
            var descriptor = new RenderTextureDescriptor((int)step.size[0], (int)step.size[1], isWidened ? GraphicsFormat.R16_SFloat : format, 0)
            {
                dimension = isFlat ? TextureDimension.Tex2D : TextureDimension.Tex3D,
                volumeDepth = depth,
                enableRandomWrite = true,
                msaaSamples = 1,
                useMipMap = false,
                autoGenerateMips = false,
            };
            var texture = new RenderTexture(descriptor)
            {
                name = Label(step.label),
                hideFlags = HideFlags.HideAndDontSave,
                filterMode = FilterMode.Bilinear,
                wrapMode = TextureWrapMode.Clamp,
            };
            if (!texture.Create())
            {
                Destroy(texture);
                var bytes = (ulong)step.size[0] * step.size[1] * (ulong)depth * BytesOf(step.format);
                throw NoRoom(step.label, bytes >> 20);
            }
            textures[step.id] = texture;
            if (isWidened) widened.Add(step.id);
        }

        void Dispatch(CommandBuffer cmd, ref Step step, in HostTargets host)
        {
            var program = kernels[step.kernel];
            Expect(program, ref step);
            for (var i = 0; i < program.Uniforms.Length; i++)
            {
                var buffer = Constant(cmd, step.uniforms[i], out var bytes);
                cmd.SetComputeConstantBufferParam(program.Shader, program.Uniforms[i], buffer, 0, bytes);
            }
            for (var i = 0; i < program.Resources.Length; i++)
            {
                var id = step.resources[i];
                if (program.IsBuffer[i]) cmd.SetComputeBufferParam(program.Shader, program.Kernel, program.Resources[i], Buffer(id));
                else cmd.SetComputeTextureParam(program.Shader, program.Kernel, program.Resources[i], TextureOf(id, host));
            }
            cmd.DispatchCompute(program.Shader, program.Kernel, (int)step.workgroups[0], (int)step.workgroups[1], 1);
        }

        void Draw(CommandBuffer cmd, ref Step step, in HostTargets host)
        {
            if (step.id != host.ColorId && step.id != host.WrittenDepthId) throw new LumivoxException("a fault in Lumivox: it draws to what nobody lent");
            var program = kernels[step.kernel];
            Expect(program, ref step);
            block.Clear();
            for (var i = 0; i < program.Uniforms.Length; i++)
            {
                var buffer = Constant(cmd, step.uniforms[i], out var bytes);
                block.SetConstantBuffer(program.Uniforms[i], buffer, 0, bytes);
            }
            for (var i = 0; i < program.Resources.Length; i++)
            {
                var id = step.resources[i];
                if (program.IsBuffer[i]) block.SetBuffer(program.Resources[i], Buffer(id));
                else block.SetTexture(program.Resources[i], TextureOf(id, host));
            }
            cmd.SetRenderTarget(host.Color, host.WrittenDepth, 0, CubemapFace.Unknown, host.Slice);
            cmd.SetViewport(new Rect(0f, 0f, host.Width, host.Height));
            cmd.DrawProcedural(Matrix4x4.identity, program.Material, 0, MeshTopology.Triangles, 3, 1, block);
        }

        /// <summary>Draws the host's depth into a texture of the view's own.</summary>
        public void CopyDepth(CommandBuffer cmd, RenderTexture to, bool fromArray, int slice, Texture explicitly)
        {
            var program = kernels[fromArray ? OwnKernels.DepthArray : OwnKernels.Depth];
            block.Clear();
            if (fromArray)
            {
                var index = stackalloc uint[] { (uint)slice, 0, 0, 0 };
                var buffer = Constant(cmd, new Slice { data = (byte*)index, length = 16 }, out var bytes);
                block.SetConstantBuffer(program.Uniforms[0], buffer, 0, bytes);
            }
            if (explicitly != null) block.SetTexture(CameraDepthTexture, explicitly);
            cmd.SetRenderTarget(to, 0, CubemapFace.Unknown, 0);
            cmd.SetViewport(new Rect(0f, 0f, to.width, to.height));
            cmd.DrawProcedural(Matrix4x4.identity, program.Material, 0, MeshTopology.Triangles, 3, 1, block);
        }

        static readonly int CameraDepthTexture = UnityEngine.Shader.PropertyToID("_CameraDepthTexture");

        /// <summary>A constant buffer of these bytes, for what is recorded next.</summary>
        GraphicsBuffer Constant(CommandBuffer cmd, in Slice contents, out int bytes)
        {
            bytes = checked((int)((contents.length + 15) / 16 * 16));
            var buffer = constants.Take(bytes);
            WriteBuffer(cmd, buffer, contents.data, 0, contents.length);
            return buffer;
        }

        static void Expect(Program program, ref Step step)
        {
            if (program.Uniforms.Length != step.uniformCount || program.Resources.Length != step.resourceCount)
                throw new LumivoxException($"the kernel '{program.Name}' binds other things than the native library gives it: one of the two is of another version. Install the package anew");
        }

        GraphicsBuffer Buffer(ulong id)
        {
            if (buffers.TryGetValue(id, out var buffer)) return buffer;
            throw new LumivoxException($"a fault in Lumivox: {id} is no buffer");
        }

        RenderTexture TextureOf(ulong id, in HostTargets host)
        {
            if (textures.TryGetValue(id, out var texture)) return texture;
            if (id == host.DepthId && host.Depth != null) return host.Depth;
            throw new LumivoxException($"a fault in Lumivox: {id} is no texture");
        }

        void Free(ulong id)
        {
            if (buffers.TryGetValue(id, out var buffer))
            {
                buffers.Remove(id);
                freed.Add(new Freed { Buffer = buffer, Turn = turn });
            }
            else if (textures.TryGetValue(id, out var texture))
            {
                textures.Remove(id);
                widened.Remove(id);
                freed.Add(new Freed { Texture = texture, Turn = turn });
            }
        }

        /// <summary>After an error nobody else frees what a recording makes or would have freed.</summary>
        void Discard(Step* steps, uint count)
        {
            for (uint i = 0; i < count; i++)
                if (steps[i].kind == StepKind.CreateBuffer || steps[i].kind == StepKind.CreateTexture || steps[i].kind == StepKind.Free)
                    Free(steps[i].id);
        }

        static void Destroy(in Freed entry)
        {
            entry.Buffer?.Dispose();
            if (entry.Texture != null) Destroy(entry.Texture);
        }

        internal static void Destroy(RenderTexture texture)
        {
            if (texture == null) return;
            texture.Release();
            Disposal.Destroy(texture);
        }

        string Label(byte* label)
        {
            var pointer = (IntPtr)label;
            if (!labels.TryGetValue(pointer, out var text)) labels[pointer] = text = "Lumivox " + Border.Text(pointer);
            return text;
        }

        NoMemoryException NoRoom(byte* label, ulong megabytes) =>
            new NoMemoryException($"the GPU has no room for '{Border.Text((IntPtr)label)}' ({megabytes} MB). Use smaller or fewer volumes");

        static GraphicsFormat Format(uint format)
        {
            switch (format)
            {
                case 0: return GraphicsFormat.R8_UNorm;
                case 1: return GraphicsFormat.R16_UNorm;
                case 2: return GraphicsFormat.R16_SFloat;
                case 3: return GraphicsFormat.R32G32B32A32_SFloat;
                default: throw new LumivoxException($"a fault in Lumivox: there is no format {format}");
            }
        }

        static uint BytesOf(uint format) => format == 0 ? 1u : format == 3 ? 16u : 2u;
    }
}
