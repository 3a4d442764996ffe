// Scene documents, scans and pictures of the command, for tests that give scenes from one host to another.
using System;
using System.Diagnostics;
using System.IO;
using System.Linq;
using NUnit.Framework;
using StandIn;
using UnityEngine;

namespace Lumivox.Tests
{
    /// A folder with a scan of the command's making, and what is rendered there.
    sealed class SceneFiles : IDisposable
    {
        public readonly string Folder = Path.Combine(Path.GetTempPath(), Path.GetRandomFileName());

        public SceneFiles(string kind = "head", int size = 32)
        {
            Directory.CreateDirectory(Folder);
            Run($"phantom {kind} --size {size} --quiet --out scan");
        }

        public void Dispose() => Directory.Delete(Folder, true);

        public string At(string name) => Path.Combine(Folder, name);

        public string Write(string name, string text)
        {
            File.WriteAllText(At(name), text);
            return At(name);
        }

        /// The command, which is what people have: it must be there.
        public void Run(string arguments)
        {
            var command = Environment.GetEnvironmentVariable("LUMIVOX_COMMAND");
            Assert.IsTrue(!string.IsNullOrEmpty(command) && File.Exists(command), $"LUMIVOX_COMMAND names no program: '{command}'; script/unity builds it");
            var start = new ProcessStartInfo(command, arguments) { WorkingDirectory = Folder, RedirectStandardError = true, RedirectStandardOutput = true, UseShellExecute = false };
            using (var process = Process.Start(start))
            {
                var said = process.StandardError.ReadToEndAsync();
                process.StandardOutput.ReadToEnd();
                process.WaitForExit();
                Assert.AreEqual(0, process.ExitCode, $"lumivox {arguments}: {said.Result}");
            }
        }

        /// What the command makes of a scene, the lowest row first.
        public Color32[] Render(string scene, out int width)
        {
            Run($"render {scene} --quiet -o {scene}.png");
            Assert.IsTrue(Png.TryRead(File.ReadAllBytes(At(scene + ".png")), out width, out _, out var pixels), "it is a picture");
            Assert.IsTrue(pixels.Any(pixel => pixel.r != pixels[0].r), $"{scene} shows something");
            return pixels;
        }

        public Color32[] Render(string scene) => Render(scene, out _);

        /// How far two pictures are from each other: pixels that differ, by how much at most, and of the whole on average.
        public static (int pixels, int most, double mean) Differences(Color32[] a, Color32[] b)
        {
            Assert.AreEqual(a.Length, b.Length, "pictures of one size");
            int Off(int i) => Math.Max(Math.Abs(a[i].r - b[i].r), Math.Max(Math.Abs(a[i].g - b[i].g), Math.Abs(a[i].b - b[i].b)));
            var all = Enumerable.Range(0, a.Length).Select(Off).ToArray();
            return (all.Count(off => off > 0), all.Max(), all.Average() / 255);
        }

        /// Opens a scene as games do.
        public LumivoxScene Load(string name)
        {
            var loading = LumivoxScene.Load(At(name));
            RuntimeComponentTests.Wait(() => loading.IsCompleted);
            return loading.GetAwaiter().GetResult();
        }

        public static void Destroy(LumivoxScene scene)
        {
            var assets = scene.assets.ToArray();
            UnityEngine.Object.DestroyImmediate(scene.gameObject);
            foreach (var asset in assets) UnityEngine.Object.DestroyImmediate(asset);
        }

        /// Hosts whose scenes lie in the folder that LUMIVOX_SCENES names, as each wrote its own.
        public static readonly string[] Hosts = { "command", "window", "python", "godot", "unity" };

        static string Written(string host) => Path.Combine(Environment.GetEnvironmentVariable("LUMIVOX_SCENES") ?? "", host + ".lumivox");

        public void CopyScenesOfHosts()
        {
            foreach (var host in Hosts) File.Copy(Written(host), At(host + ".lumivox"));
        }

        /// What Unity wrote is what it wrote before; where LUMIVOX_UPDATE is set it is kept instead.
        public void IsAsWritten(string name)
        {
            var text = File.ReadAllText(At(name));
            if (!string.IsNullOrEmpty(Environment.GetEnvironmentVariable("LUMIVOX_UPDATE"))) File.WriteAllText(Written("unity"), text);
            Assert.AreEqual(File.ReadAllText(Written("unity")), text, "LUMIVOX_UPDATE=1 keeps what is written now");
        }

        /// Opened and saved again.
        public void PassOn(string from, string to)
        {
            var scene = Load(from);
            LumivoxScene.Save(scene.sceneCamera, At(to));
            Destroy(scene);
        }
    }
}
