using System;
using UnityEngine.Experimental.Rendering;

namespace Lumivox
{
    /// <summary>A program that is written by hand, beside those that the native library asks for.</summary>
    internal sealed class OwnKernel
    {
        public readonly string File, Entry;
        public readonly string[] Uniforms, Resources;
        public readonly bool[] IsBuffer;
        /// <summary>What it is for alone: where textures of that format cannot be written, nobody runs it.</summary>
        public readonly GraphicsFormat Format;

        /// <param name="entry">Of a compute shader; null: it is drawn.</param>
        public OwnKernel(string file, string entry, string[] uniforms, string[] resources, bool[] isBuffer, GraphicsFormat format = GraphicsFormat.None) =>
            (File, Entry, Uniforms, Resources, IsBuffer, Format) = (file, entry, uniforms, resources, isBuffer, format);

        public bool IsDrawn => Entry == null;
    }

    /// <summary>What moves data to, from and between the GPU's resources.</summary>
    internal static class OwnKernels
    {
        static readonly string[] parameters = { "params_buffer" }, none = Array.Empty<string>();

        public static readonly OwnKernel ClearBuffer = new OwnKernel("LumivoxClearBuffer", "clear_buffer", parameters, new[] { "cleared" }, new[] { true });
        public static readonly OwnKernel WriteR8 = Writer("LumivoxWriteR8", "write_r8", "norm_box", GraphicsFormat.R8_UNorm);
        /// <summary>Values of 8 bits into halves.</summary>
        public static readonly OwnKernel WriteR8f = Writer("LumivoxWriteR8f", "write_r8f", "half_box", GraphicsFormat.R16_SFloat);
        public static readonly OwnKernel WriteR16 = Writer("LumivoxWriteR16", "write_r16", "norm_box", GraphicsFormat.R16_UNorm);
        public static readonly OwnKernel WriteR16f = Writer("LumivoxWriteR16f", "write_r16f", "half_box", GraphicsFormat.R16_SFloat);
        public static readonly OwnKernel WriteRgba32f = Writer("LumivoxWriteRgba32f", "write_rgba32f", "float_box", GraphicsFormat.R32G32B32A32_SFloat);
        public static readonly OwnKernel WriteRgba32fFlat = Writer("LumivoxWriteRgba32fFlat", "write_rgba32f_flat", "float_flat", GraphicsFormat.R32G32B32A32_SFloat);
        public static readonly OwnKernel CopyHalf = Copier("LumivoxCopyHalf", "copy_half", "half_box", GraphicsFormat.R16_SFloat);
        public static readonly OwnKernel CopyNorm = Copier("LumivoxCopyNorm", "copy_norm", "norm_box", GraphicsFormat.R16_UNorm);
        public static readonly OwnKernel CubeFaces = new OwnKernel("LumivoxCubeFaces", "cube_faces", none, new[] { "faces", "cube" }, new[] { true, false });
        public static readonly OwnKernel Depth = new OwnKernel("LumivoxDepth", null, none, none, Array.Empty<bool>());
        public static readonly OwnKernel DepthArray = new OwnKernel("LumivoxDepthArray", null, parameters, none, Array.Empty<bool>());

        public static readonly OwnKernel[] All =
        {
            ClearBuffer, WriteR8, WriteR8f, WriteR16, WriteR16f, WriteRgba32f, WriteRgba32fFlat, CopyHalf, CopyNorm, CubeFaces, Depth, DepthArray,
        };

        static OwnKernel Writer(string file, string entry, string written, GraphicsFormat format) =>
            new OwnKernel(file, entry, parameters, new[] { written, "texels" }, new[] { false, true }, format);

        static OwnKernel Copier(string file, string entry, string written, GraphicsFormat format) =>
            new OwnKernel(file, entry, parameters, new[] { written, "copied" }, new[] { false, false }, format);
    }
}
