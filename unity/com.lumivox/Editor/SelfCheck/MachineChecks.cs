// What a project and a machine must have before anything is drawn.
using System;
using System.Collections;
using System.Collections.Generic;
using Lumivox.Native;
using UnityEditor;
using UnityEditor.Rendering;
using UnityEngine;
using UnityEngine.Experimental.Rendering;
using UnityEngine.Rendering;
using Object = UnityEngine.Object;

namespace Lumivox.Editor
{
    internal static class MachineChecks
    {
        public static void Library(Check check)
        {
            if (Border.Fault != null) check.Fail(Border.Fault);
            else check.Note($"version {LumivoxRenderer.Version}, border {Abi.Version}");
        }

        public static void Device(Check check)
        {
            var fault = LumivoxRuntime.DeviceFault();
            if (fault != null)
            {
                check.Fail(fault, SystemInfo.graphicsDeviceType == GraphicsDeviceType.Null
                    ? "Start Unity without -nographics; a machine without a display needs a virtual one, such as Xvfb."
                    : "Update the driver, or choose another graphics API in Project Settings > Player.");
                return;
            }
            check.Note($"3D textures up to {SystemInfo.maxTexture3DSize}, buffers up to {EditorUtility.FormatBytes(SystemInfo.maxGraphicsBufferSize)}, {(SystemInfo.supportsAsyncGPUReadback ? "" : "no ")}asynchronous read-backs");
            foreach (var format in narrow)
                check.Note(Formats.AreWritten(format) ? $"{format}: voxels are kept as they are" : $"{format} cannot be written here: voxels are kept in half floats");
        }

        /// What voxels are kept in where there is that.
        static readonly GraphicsFormat[] narrow = { GraphicsFormat.R8_UNorm, GraphicsFormat.R16_UNorm };

        public static void Project(Check check)
        {
            if (QualitySettings.activeColorSpace != ColorSpace.Linear)
                check.Fail("the project's colour space is Gamma: volumes are too dark in it", "Set Project Settings > Player > Other Settings > Color Space to Linear.");
            var host = PipelineHost.Current;
            if (host == null)
            {
                check.Fail($"volumes are not drawn in {GraphicsSettings.currentRenderPipeline.GetType().FullName}", "Use the Built-in, the Universal (14 or later) or the High Definition pipeline (14 or later).");
                return;
            }
            check.Note($"volumes are drawn {host.Way}");
            if (host.Problem is string problem) check.Fail(problem);
        }

        public static IEnumerator Kernels(Check check)
        {
            if (LumivoxRuntime.DeviceFault() is string fault)
            {
                check.Fail(fault, "See 'Graphics device'.");
                yield break;
            }
            foreach (var entry in KernelTable.Entries)
            {
                Load(check, entry.Name, () => KernelLibrary.Load(entry.Name));
                yield return null;
            }
            foreach (var kernel in OwnKernels.All)
            {
                if (kernel.Format != GraphicsFormat.None && !Formats.AreWritten(kernel.Format)) continue;
                Load(check, kernel.File, () => KernelLibrary.Load(kernel));
                yield return null;
            }
            if (check.Faults.Count == 0) check.Note($"all {KernelTable.Entries.Length} of the library's and {OwnKernels.All.Length} others are there and run on {SystemInfo.graphicsDeviceType}");
        }

        static void Load(Check check, string name, Func<Program> load)
        {
            Program program;
            try
            {
                program = load();
            }
            catch (LumivoxException error)
            {
                check.Fail(error.Message);
                return;
            }
            if (program.Material != null) Object.DestroyImmediate(program.Material);
            var messages = program.Shader != null ? ShaderUtil.GetComputeShaderMessages(program.Shader) : ShaderUtil.GetShaderMessages(program.Drawn);
            foreach (var message in Errors(messages)) check.Fail($"{name}: {message}", "Attach this report to an issue.");
        }

        /// What the compiler said, for any graphics API of the project.
        static IEnumerable<string> Errors(ShaderMessage[] messages)
        {
            foreach (var message in messages)
                if (message.severity == ShaderCompilerMessageSeverity.Error) yield return message.message;
        }
    }
}
