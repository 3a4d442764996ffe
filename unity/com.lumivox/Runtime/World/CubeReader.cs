// A cube's faces, on their way back from the GPU as floats. A kernel writes them into a buffer, as a texture is read back only
// where Unity can read its format: skies are often compressed.
using System;
using UnityEngine;
using UnityEngine.Rendering;

namespace Lumivox
{
    internal sealed class CubeReader : IDisposable
    {
        // Threads along a side of a group.
        const int Group = 8;

        static readonly int side = Shader.PropertyToID("side"), texels = Shader.PropertyToID("texels"), level = Shader.PropertyToID("level");

        readonly int most;
        GraphicsBuffer buffer;
        Program program;

        /// <param name="most">Texels along a side, at most.</param>
        public CubeReader(int most) => this.most = most;

        /// <summary>Texels along a side of the faces that were asked for last.</summary>
        public int Side { get; private set; }

        /// <summary>
        /// Asks for +x, -x, +y, -y, +z, -z, in rows of linear RGBA. One asks again only when the answer has come.
        /// </summary>
        /// <exception cref="LumivoxException">This machine cannot run the kernel.</exception>
        public void Read(Texture of, Action<AsyncGPUReadbackRequest> came)
        {
            program ??= KernelLibrary.Load(OwnKernels.CubeFaces);
            // Finer ones have a level of about the size, or several texels become one.
            var mip = 0;
            while (of.width >> mip > most && mip + 1 < of.mipmapCount) mip++;
            var width = Math.Max(1, of.width >> mip);
            var each = (width + most - 1) / most;
            Side = width / each;
            var count = 6 * Side * Side * 4;
            if (buffer == null || buffer.count != count)
            {
                buffer?.Dispose();
                buffer = new GraphicsBuffer(GraphicsBuffer.Target.Raw, count, 4) { name = "Lumivox Sky" };
            }
            using (var cmd = new CommandBuffer { name = "Lumivox Sky" })
            {
                cmd.SetComputeIntParam(program.Shader, side, Side);
                cmd.SetComputeIntParam(program.Shader, texels, each);
                cmd.SetComputeIntParam(program.Shader, level, mip);
                cmd.SetComputeBufferParam(program.Shader, program.Kernel, program.Resources[0], buffer);
                cmd.SetComputeTextureParam(program.Shader, program.Kernel, program.Resources[1], of);
                cmd.DispatchCompute(program.Shader, program.Kernel, (Side + Group - 1) / Group, (Side + Group - 1) / Group, 6);
                cmd.RequestAsyncReadback(buffer, came);
                Graphics.ExecuteCommandBuffer(cmd);
            }
        }

        public void Dispose()
        {
            buffer?.Dispose();
            buffer = null;
        }
    }
}
