// Kernels by the numbers of the native library: their programs, and by which names they bind.
using System;
using System.Collections.Generic;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>A kernel that is ready to run or to be drawn.</summary>
    internal sealed class Program
    {
        public string Name;
        public ComputeShader Shader;
        public int Kernel;
        /// <summary>What is drawn instead of run.</summary>
        public Shader Drawn;
        public Material Material;
        public int[] Uniforms;
        public int[] Resources;
        public bool[] IsBuffer;
    }

    /// <summary>Finds programs by name, in the package's `Resources` folder, so that every player holds them.</summary>
    internal sealed class KernelLibrary : IDisposable
    {
        const string Folder = "Lumivox/";
        // A checkout has none until they are made.
        const string Missing = "is missing from the package. Install it anew; a checkout of its repository makes its kernels with `cargo xtask unity-kernels`";

        readonly Program[] programs;
        readonly Dictionary<OwnKernel, Program> own = new Dictionary<OwnKernel, Program>();

        public KernelLibrary() => programs = new Program[Library.lumivox_kernel_count()];

        /// <summary>The kernel of a step.</summary>
        /// <exception cref="LumivoxException">The package does not have it, or this machine cannot run it.</exception>
        public Program this[uint index]
        {
            get
            {
                if (index >= programs.Length) throw new LumivoxException($"a fault in Lumivox: there is no kernel {index}");
                return programs[index] ?? (programs[index] = Load(Border.Text(Library.lumivox_kernel_name(index))));
            }
        }

        /// <summary>One of the package's own.</summary>
        public Program this[OwnKernel kernel] => own.TryGetValue(kernel, out var known) ? known : own[kernel] = Load(kernel);

        public void Dispose()
        {
            foreach (var program in programs) Disposal.Destroy(program?.Material);
            foreach (var program in own.Values) Disposal.Destroy(program?.Material);
            Array.Clear(programs, 0, programs.Length);
            own.Clear();
        }

        /// <summary>The kernel of a name.</summary>
        /// <exception cref="LumivoxException">The package does not have it, or this machine cannot run it.</exception>
        public static Program Load(string name)
        {
            foreach (var entry in KernelTable.Entries)
            {
                if (entry.Name != name) continue;
                var isBuffer = Array.ConvertAll(entry.Kinds, kind => kind == KernelTable.Kind.Buffer);
                return entry.IsDrawn
                    ? Drawn(name, entry.Uniforms, entry.Resources, isBuffer)
                    : Computed(name, name, entry.EntryPoint, entry.Uniforms, entry.Resources, isBuffer);
            }
            throw new LumivoxException($"the package has no kernel '{name}', which its native library asks for: one of the two is of another version. Install the package anew");
        }

        /// <summary>One of the package's own.</summary>
        /// <exception cref="LumivoxException">The package does not have it, or this machine cannot run it.</exception>
        public static Program Load(OwnKernel kernel) => kernel.IsDrawn
            ? Drawn(kernel.File, kernel.Uniforms, kernel.Resources, kernel.IsBuffer)
            : Computed(kernel.Entry, kernel.File, kernel.Entry, kernel.Uniforms, kernel.Resources, kernel.IsBuffer);

        static Program Computed(string name, string file, string entry, string[] uniforms, string[] resources, bool[] isBuffer)
        {
            var shader = UnityEngine.Resources.Load<ComputeShader>(Folder + file);
            if (shader == null) throw new LumivoxException($"the kernel '{file}' {Missing}");
            if (!shader.HasKernel(entry)) throw new LumivoxException($"the kernel '{name}' does not compile on this platform: Unity's console says why");
            var kernel = shader.FindKernel(entry);
            if (!shader.IsSupported(kernel)) throw new LumivoxException($"this graphics device ({SystemInfo.graphicsDeviceType}) cannot run Lumivox' kernel '{name}'. Update its driver, or choose another graphics API");
            return new Program { Name = name, Shader = shader, Kernel = kernel, Uniforms = Ids(uniforms), Resources = Ids(resources), IsBuffer = isBuffer };
        }

        static Program Drawn(string name, string[] uniforms, string[] resources, bool[] isBuffer)
        {
            var shader = UnityEngine.Resources.Load<Shader>(Folder + name);
            if (shader == null) throw new LumivoxException($"the shader '{name}' {Missing}");
            if (!shader.isSupported) throw new LumivoxException($"this graphics device ({SystemInfo.graphicsDeviceType}) cannot draw Lumivox' shader '{name}'. Update its driver, or choose another graphics API");
            var material = new Material(shader) { hideFlags = HideFlags.HideAndDontSave };
            return new Program { Name = name, Drawn = shader, Material = material, Uniforms = Ids(uniforms), Resources = Ids(resources), IsBuffer = isBuffer };
        }

        static int[] Ids(string[] names) => Array.ConvertAll(names, UnityEngine.Shader.PropertyToID);
    }
}
