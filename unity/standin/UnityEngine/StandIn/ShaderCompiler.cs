// HLSL to SPIR-V, by DXC without optimisation, kept by the hash of what went in.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Security.Cryptography;
using System.Text;
using System.Text.RegularExpressions;

namespace StandIn
{
    /// STANDIN_DXC names the program (`dxc IN OUT ENTRY TARGET OPTION...`), STANDIN_SPIRV the folder of what it made.
    public static class ShaderCompiler
    {
        /// The layout of constant buffers is Direct3D's.
        static readonly string[] options = { "-spirv", "-O0", "-fvk-use-dx-layout", "-Wno-ignored-attributes" };
        static readonly string[] macros = { "UNITY_VERSION=60000058", "SHADER_API_VULKAN=1", "SHADER_TARGET=50", "UNITY_REVERSED_Z=1", "UNITY_UV_STARTS_AT_TOP=1" };
        static readonly Dictionary<string, byte[]> known = new Dictionary<string, byte[]>();
        /// How many programs had to be compiled by DXC in this process.
        public static int compiled { get; private set; }

        /// SPIR-V of one entry point of HLSL text that stands in a file.
        public static byte[] Compile(string text, string file, string entry, string target, IEnumerable<string> defines)
        {
            var source = Inline(text, Path.GetDirectoryName(file), new HashSet<string>());
            // What Unity reads of the pragmas is no business of DXC's.
            source = Regex.Replace(source, @"^[ \t]*#pragma[ \t]+(kernel|vertex|fragment|target|multi_compile\w*|shader_feature\w*|only_renderers|exclude_renderers|require|editor_sync_compilation|use_dxc|never_use_dxc|enable_d3d11_debug_symbols)\b.*$", "", RegexOptions.Multiline);
            var arguments = options.Concat(macros.Concat(defines).SelectMany(define => new[] { "-D", define })).ToArray();
            string key;
            using (var hash = SHA256.Create())
                key = BitConverter.ToString(hash.ComputeHash(Encoding.UTF8.GetBytes(string.Join("\n", arguments) + $"\n{entry}\n{target}\n{source}"))).Replace("-", "").ToLowerInvariant();
            if (known.TryGetValue(key, out var spirv)) return spirv;
            var folder = Environment.GetEnvironmentVariable("STANDIN_SPIRV") ?? Path.Combine(Path.GetTempPath(), "standin-spirv");
            Directory.CreateDirectory(folder);
            var kept = Path.Combine(folder, key + ".spv");
            if (!File.Exists(kept)) Run(source, file, entry, target, arguments, kept);
            return known[key] = File.ReadAllBytes(kept);
        }

        static void Run(string source, string file, string entry, string target, string[] arguments, string kept)
        {
            var dxc = Environment.GetEnvironmentVariable("STANDIN_DXC");
            if (string.IsNullOrEmpty(dxc)) throw new NotImplementedException($"{Path.GetFileName(file)} needs DXC: STANDIN_DXC names its program");
            var process = Process.GetCurrentProcess().Id;
            string input = $"{kept}.{process}.hlsl", output = $"{kept}.{process}.new";
            File.WriteAllText(input, source);
            var start = new ProcessStartInfo(dxc) { RedirectStandardError = true, RedirectStandardOutput = true, UseShellExecute = false };
            foreach (var argument in new[] { input, output, entry, target }.Concat(arguments)) start.ArgumentList.Add(argument);
            using (var run = Process.Start(start))
            {
                var read = run.StandardOutput.ReadToEndAsync();
                var said = run.StandardError.ReadToEnd() + read.Result;
                run.WaitForExit();
                File.Delete(input);
                if (run.ExitCode != 0 || !File.Exists(output)) throw new UnityEngine.UnityException($"Shader error in '{Path.GetFileName(file)}', entry '{entry}':\n{said}");
            }
            compiled++;
            if (File.Exists(kept)) File.Delete(output); else File.Move(output, kept);
        }

        static string Inline(string text, string folder, HashSet<string> above)
        {
            return Regex.Replace(text, "^[ \\t]*#include(?:_with_pragmas)?[ \\t]+\"([^\"]+)\".*$", match =>
            {
                var path = Packages.Resolve(match.Groups[1].Value) ?? Path.GetFullPath(Path.Combine(folder, match.Groups[1].Value));
                if (!File.Exists(path)) throw new NotImplementedException($"the stand-in has no include file {match.Groups[1].Value}");
                return above.Add(path) ? Inline(File.ReadAllText(path), Path.GetDirectoryName(path), above) : "";
            }, RegexOptions.Multiline);
        }
    }

    /// Where packages and the project's assets lie. STANDIN_PACKAGES names the packages' folders, with colons between.
    public static class Packages
    {
        static readonly List<string> folders = (Environment.GetEnvironmentVariable("STANDIN_PACKAGES") ?? "").Split(new[] { ':' }, StringSplitOptions.RemoveEmptyEntries).ToList();
        public static void Add(string folder) { if (!folders.Contains(folder)) folders.Add(folder); }
        public static IEnumerable<string> all => folders;
        /// The file of a path that begins with `Packages/NAME/`; null for others.
        public static string Resolve(string path)
        {
            foreach (var folder in folders)
            {
                var start = $"Packages/{Path.GetFileName(folder.TrimEnd('/'))}/";
                if (path.StartsWith(start, StringComparison.Ordinal)) return Path.Combine(folder, path.Substring(start.Length));
            }
            return null;
        }
        /// All files that Unity sees, with its slashes.
        internal static IEnumerable<string> Files(string pattern) => folders.SelectMany(folder => Directory.EnumerateFiles(folder, pattern, SearchOption.AllDirectories).Select(file => file.Replace(Path.DirectorySeparatorChar, '/')).Where(file => !file.Substring(folder.Length).Split('/').Any(part => part.EndsWith("~") || part.StartsWith("."))));
    }
}
