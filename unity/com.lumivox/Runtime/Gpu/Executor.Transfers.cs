// Bytes into buffers and boxes of textures: from the library's memory to the GPU's, never over the managed heap.
using System;
using Lumivox.Native;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine;
using UnityEngine.Experimental.Rendering;
using UnityEngine.Rendering;

namespace Lumivox
{
    internal sealed unsafe partial class Executor
    {
        /// <summary>Most bytes that one command carries.</summary>
        const ulong LargestWrite = 16 << 20;

        // Threads of a group of the kernels that write boxes.
        const uint GroupWidth = 32, GroupHeight = 4;

        struct TransferParams
        {
            public uint originX, originY, originZ, originW;
            public uint sizeX, sizeY, sizeZ, sizeW;
        }

        /// <summary>The library's memory as Unity's arrays, without a copy.</summary>
        NativeArray<uint> Words(void* data, int count)
        {
            var array = NativeArrayUnsafeUtility.ConvertExistingDataToNativeArray<uint>(data, count, Allocator.None);
#if ENABLE_UNITY_COLLECTIONS_CHECKS
            NativeArrayUnsafeUtility.SetAtomicSafetyHandle(ref array, safety);
#endif
            return array;
        }

        /// <summary>Unity copies the bytes while it records: the library may free them afterwards.</summary>
        void WriteBuffer(CommandBuffer cmd, GraphicsBuffer buffer, byte* data, ulong offset, ulong length)
        {
            for (ulong done = 0; done < length; done += LargestWrite)
            {
                var words = (int)(Math.Min(LargestWrite, length - done) / 4);
                cmd.SetBufferData(buffer, Words(data + done, words), 0, checked((int)((offset + done) / 4)), words);
            }
        }

        void Clear(CommandBuffer cmd, GraphicsBuffer buffer)
        {
            // 64 threads of 16 bytes make a group, and the most groups along x a row.
            const uint group = 1024, row = 65535u * group;
            var bytes = checked((uint)((ulong)buffer.count * 4));
            var parameters = new TransferParams { sizeX = bytes, sizeY = row };
            var program = kernels[OwnKernels.ClearBuffer];
            Transfer(cmd, program, ref parameters);
            cmd.SetComputeBufferParam(program.Shader, program.Kernel, program.Resources[0], buffer);
            cmd.DispatchCompute(program.Shader, program.Kernel, (int)(Math.Min(bytes, row) + group - 1) / (int)group, (int)((bytes - 1) / row) + 1, 1);
        }

        void WriteTexture(CommandBuffer cmd, ref Step step)
        {
            var texture = OwnTexture(step.id);
            var isFlat = texture.dimension == TextureDimension.Tex2D;
            var isWidened = widened.Contains(step.id);
            var program = isWidened ? kernels[OwnKernels.WriteR8f] : WriterOf(texture, isFlat);
            var bytesPerTexel = isWidened ? 1u : BytesOf(texture);
            ulong row = (ulong)step.size[0] * bytesPerTexel, slice = row * step.size[1];
            var slicesAtOnce = (uint)Math.Max(1, Math.Min(StagingPool.Largest / Math.Max(slice, 1), step.size[2]));
            var rowsAtOnce = slice <= StagingPool.Largest ? step.size[1] : (uint)Math.Max(1, StagingPool.Largest / row);
            for (uint z = 0; z < step.size[2]; z += slicesAtOnce)
                for (uint y = 0; y < step.size[1]; y += rowsAtOnce)
                {
                    var parameters = new TransferParams
                    {
                        originX = step.origin[0],
                        originY = step.origin[1] + y,
                        originZ = step.origin[2] + z,
                        sizeX = step.size[0],
                        sizeY = Math.Min(rowsAtOnce, step.size[1] - y),
                        sizeZ = Math.Min(slicesAtOnce, step.size[2] - z),
                    };
                    var bytes = checked((int)(row * parameters.sizeY * parameters.sizeZ));
                    var source = Stage(step.data + z * slice + y * row, bytes);
                    Transfer(cmd, program, ref parameters);
                    cmd.SetComputeTextureParam(program.Shader, program.Kernel, program.Resources[0], texture);
                    cmd.SetComputeBufferParam(program.Shader, program.Kernel, program.Resources[1], source);
                    DispatchBox(cmd, program, parameters);
                }
        }

        void CopyTexture(CommandBuffer cmd, ref Step step)
        {
            RenderTexture from = OwnTexture(step.from), to = OwnTexture(step.id);
            var isHalf = to.graphicsFormat == GraphicsFormat.R16_SFloat;
            var program = kernels[isHalf ? OwnKernels.CopyHalf : OwnKernels.CopyNorm];
            var parameters = new TransferParams
            {
                originX = step.origin[0],
                originY = step.origin[1],
                originZ = step.origin[2],
                sizeX = step.size[0],
                sizeY = step.size[1],
                sizeZ = step.size[2],
            };
            Transfer(cmd, program, ref parameters);
            cmd.SetComputeTextureParam(program.Shader, program.Kernel, program.Resources[0], to);
            cmd.SetComputeTextureParam(program.Shader, program.Kernel, program.Resources[1], from);
            DispatchBox(cmd, program, parameters);
        }

        void Transfer(CommandBuffer cmd, Program program, ref TransferParams parameters)
        {
            fixed (TransferParams* contents = &parameters)
            {
                var buffer = Constant(cmd, new Slice { data = (byte*)contents, length = (ulong)sizeof(TransferParams) }, out var bytes);
                cmd.SetComputeConstantBufferParam(program.Shader, program.Uniforms[0], buffer, 0, bytes);
            }
        }

        static void DispatchBox(CommandBuffer cmd, Program program, in TransferParams box) =>
            cmd.DispatchCompute(program.Shader, program.Kernel, (int)((box.sizeX + GroupWidth - 1) / GroupWidth), (int)((box.sizeY + GroupHeight - 1) / GroupHeight), (int)box.sizeZ);

        /// <summary>Bytes in a buffer of the GPU's, at once: commands that are recorded now are executed later.</summary>
        GraphicsBuffer Stage(byte* data, int bytes)
        {
            var buffer = staging.Take(bytes, turn);
            var words = bytes / 4;
            if (words > 0) buffer.SetData(Words(data, words), 0, 0, words);
            if (bytes % 4 == 0) return buffer;
            uint last = 0;
            for (var i = 0; i < bytes % 4; i++) last |= (uint)data[words * 4 + i] << (8 * i);
            buffer.SetData(Words(&last, 1), 0, words, 1);
            return buffer;
        }

        Program WriterOf(RenderTexture texture, bool isFlat)
        {
            switch (texture.graphicsFormat)
            {
                case GraphicsFormat.R8_UNorm when !isFlat: return kernels[OwnKernels.WriteR8];
                case GraphicsFormat.R16_UNorm when !isFlat: return kernels[OwnKernels.WriteR16];
                case GraphicsFormat.R16_SFloat when !isFlat: return kernels[OwnKernels.WriteR16f];
                case GraphicsFormat.R32G32B32A32_SFloat when isFlat: return kernels[OwnKernels.WriteRgba32fFlat];
                case GraphicsFormat.R32G32B32A32_SFloat: return kernels[OwnKernels.WriteRgba32f];
                default: throw new LumivoxException($"a fault in Lumivox: nothing writes {texture.graphicsFormat} textures that are {(isFlat ? "flat" : "solid")}");
            }
        }

        static uint BytesOf(RenderTexture texture) =>
            texture.graphicsFormat == GraphicsFormat.R8_UNorm ? 1u : texture.graphicsFormat == GraphicsFormat.R32G32B32A32_SFloat ? 16u : 2u;

        RenderTexture OwnTexture(ulong id)
        {
            if (textures.TryGetValue(id, out var texture)) return texture;
            throw new LumivoxException($"a fault in Lumivox: {id} is no texture of its own");
        }
    }
}
