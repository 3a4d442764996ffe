// The package's films and pictures beside those of the wgpu host, which the library of the tests makes of the same scenes.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Runtime.InteropServices;
using Lumivox.Native;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using UnityEngine.Rendering;
using Object = UnityEngine.Object;
using Picture = StandIn.Picture;

namespace Lumivox.Tests
{
    static unsafe class Twin
    {
        [DllImport(Library.Name)] public static extern uint lumivox_twin_scene_count();
        [DllImport(Library.Name)] public static extern IntPtr lumivox_twin_scene_name(uint index);
        [DllImport(Library.Name)] public static extern IntPtr lumivox_twin_still(uint index, uint side, uint samples);
        [DllImport(Library.Name)] public static extern uint lumivox_twin_still_film(uint index, uint side, uint samples, float* film, uint capacity);
        [DllImport(Library.Name)] public static extern int lumivox_twin_picture(IntPtr stage, ulong view, float* color, float* depth);
    }

    /// Stills of all test scenes, from recordings that were never live.
    public sealed unsafe class TwinStillTests
    {
        const uint Side = 32, Samples = 8;

        static readonly DeviceLimits limits = new DeviceLimits { maxTexture3d = 2048, maxTexture2d = 8192, maxBufferBytes = 1 << 27, unorm16 = 1, isSoftware = 1 };

        /// What stills bind, which the package has no kernels for: a line for each, its name, entry point and bindings.
        static Dictionary<string, string[]> Table()
        {
            var folder = Environment.GetEnvironmentVariable("STANDIN_STILLS");
            Assert.IsFalse(string.IsNullOrEmpty(folder), "STANDIN_STILLS names no folder of kernels: script/unity makes one");
            return File.ReadAllLines(Path.Combine(folder, "table.txt")).Select(line => line.Split(' ')).ToDictionary(words => words[0]);
        }

        static Program ProgramOf(string[] words)
        {
            string[] Names(string kinds) => words.Skip(2).Where(word => kinds.IndexOf(word[0]) >= 0).Select(word => word.Substring(2)).ToArray();
            var shader = UnityEngine.Resources.Load<ComputeShader>("Lumivox/" + words[0]);
            Assert.IsTrue(shader != null, $"there is no kernel {words[0]}");
            return new Program
            {
                Name = words[0],
                Shader = shader,
                Kernel = shader.FindKernel(words[1]),
                Uniforms = Names("u").Select(Shader.PropertyToID).ToArray(),
                Resources = Names("bt").Select(Shader.PropertyToID).ToArray(),
                IsBuffer = words.Skip(2).Where(word => word[0] != 'u').Select(word => word[0] == 'b').ToArray(),
            };
        }

        /// Gives the executor the kernels of a recording that the package lacks.
        static void Teach(Executor executor, Step* steps, uint count, Dictionary<string, string[]> table)
        {
            const BindingFlags inner = BindingFlags.Instance | BindingFlags.NonPublic;
            var kernels = typeof(Executor).GetField("kernels", inner).GetValue(executor);
            var programs = (Program[])typeof(KernelLibrary).GetField("programs", inner).GetValue(kernels);
            for (uint i = 0; i < count; i++)
            {
                if (steps[i].kind != StepKind.Dispatch || programs[steps[i].kernel] != null) continue;
                var name = Border.Text(Library.lumivox_kernel_name(steps[i].kernel));
                if (KernelTable.Entries.All(entry => entry.Name != name)) programs[steps[i].kernel] = ProgramOf(table[name]);
            }
        }

        static float[] Film(uint scene, Dictionary<string, string[]> table)
        {
            var of = limits;
            var stage = Library.lumivox_stage_new(&of);
            var recording = Twin.lumivox_twin_still(scene, Side, Samples);
            uint count;
            var steps = Library.lumivox_recording_steps(recording, &count);
            ulong id = 0, offset = 0, length = 0;
            for (uint i = 0; i < count; i++)
                if (steps[i].kind == StepKind.ReadBuffer) (id, offset, length) = (steps[i].id, steps[i].offset, steps[i].length);
            Assert.IsTrue(length > 0, "the film is read back");
            using (var executor = new Executor(stage))
            using (var cmd = new CommandBuffer { name = "still" })
            {
                Teach(executor, steps, count, table);
                executor.BeginFrame();
                var outcome = executor.Execute(cmd, steps, count, default, out var why);
                Assert.AreEqual(Outcome.Executed, outcome, why);
                Graphics.ExecuteCommandBuffer(cmd);
                const BindingFlags inner = BindingFlags.Instance | BindingFlags.NonPublic;
                var buffers = (Dictionary<ulong, GraphicsBuffer>)typeof(Executor).GetField("buffers", inner).GetValue(executor);
                var bytes = Pictures.Read(buffers[id], (int)offset, (int)length);
                AsyncGPUReadback.WaitAllRequests();
                Library.lumivox_recording_finish(stage, recording, (uint)Outcome.Executed, null);
                Library.lumivox_stage_free(stage);
                var floats = new float[bytes.Length / 4];
                System.Buffer.BlockCopy(bytes, 0, floats, 0, bytes.Length);
                return floats;
            }
        }

        [Test]
        public void FilmsAreTheWgpuHostsToTheLastBit() => Compare(8);

        [Test, Category("Slow")]
        public void EveryFilmIsTheWgpuHostsToTheLastBit() => Compare(1);

        /// Of so many scenes one.
        static void Compare(uint step)
        {
            var table = Table();
            var differing = new List<string>();
            for (uint scene = 0; scene < Twin.lumivox_twin_scene_count(); scene += step)
            {
                var name = Border.Text(Twin.lumivox_twin_scene_name(scene));
                var film = Film(scene, table);
                var expected = new float[film.Length];
                fixed (float* first = expected) Assert.AreEqual((uint)film.Length, Twin.lumivox_twin_still_film(scene, Side, Samples, first, (uint)expected.Length));
                Assert.IsTrue(expected.Any(value => value != 0f), $"{name} shows nothing");
                var others = Enumerable.Range(0, film.Length).Where(i => !film[i].Equals(expected[i])).ToArray();
                var most = others.Length == 0 ? 0f : others.Max(i => Math.Abs(film[i] - expected[i]));
                Console.WriteLine($"  {name}: {others.Length} of {film.Length} floats differ" + (others.Length == 0 ? "" : $", by {most} at most"));
                if (others.Length > 0) differing.Add(name);
            }
            CollectionAssert.IsEmpty(differing);
        }
    }

    /// Live views at rest: the film, the composite and the depth that it writes.
    public abstract unsafe class TwinScene
    {
        /// STANDIN_SIDE asks for larger ones, to look at; those have more samples, too.
        static readonly int Side = int.TryParse(Environment.GetEnvironmentVariable("STANDIN_SIDE"), out var side) ? side : 32;

        protected Camera camera;
        protected readonly List<Object> made = new List<Object>();

        [SetUp]
        public void Begin()
        {
            Engine.Clear();
            camera = PlainCamera.Make(Side, Side > 32 ? 64 : 8);
            camera.transform.position = new Vector3(0.05f, 0.04f, -0.3f);
            camera.transform.LookAt(Vector3.zero);
            camera.backgroundColor = new Color(0.02f, 0.05f, 0.1f, 1f);
        }

        [TearDown]
        public void End()
        {
            LumivoxRuntime.Stop();
            Props.Clear();
            Headset.isOn = false;
            foreach (var one in made) Object.DestroyImmediate(one);
            made.Clear();
            Engine.Clear();
        }

        protected LumivoxVolume Add(string kind, int size, string preset, Vector3 position, Quaternion rotation)
        {
            var scan = LumivoxVolumeAsset.Phantom(kind, size);
            made.Add(scan);
            var volume = new GameObject(kind).AddComponent<LumivoxVolume>();
            volume.transform.SetPositionAndRotation(position, rotation);
            volume.volume = scan;
            RuntimeComponentTests.Wait(() => scan.state == LumivoxVolumeState.Ready);
            volume.ApplyPreset(preset);
            return volume;
        }

        /// Frames until the picture was at rest: more where the machine has other work, for a view keeps to its budget.
        int settled;

        protected void Settle()
        {
            for (settled = 0; settled < 400; settled++)
            {
                Engine.Frame();
                Ticker.Tick();
                if (settled > 2 && IsDone()) return;
            }
            Assert.Fail($"no end; error: '{LumivoxRuntime.Error}'");
        }

        bool IsDone() => LumivoxRuntime.StatusOf(camera).isConverged;

        /// The picture of a camera, which is given back, and that of the wgpu host of the same view.
        protected Color[] Compare(string name)
        {
            var volumes = LumivoxVolume.All.ToArray();
            // What the host draws by itself: what volumes are drawn over, and what ends their rays.
            foreach (var volume in volumes) volume.enabled = false;
            Engine.Frame();
            var (color, depth) = (Pictures.Color(camera), Pictures.Depth(camera));
            foreach (var volume in volumes) volume.enabled = true;
            Settle();
            var (shown, written) = (Pictures.Color(camera), Pictures.Depth(camera));
            var colors = color.pixels.SelectMany(pixel => new[] { pixel.r, pixel.g, pixel.b, pixel.a }).ToArray();
            var depths = depth.pixels.Select(pixel => pixel.r).ToArray();
            var stage = (IntPtr)typeof(LumivoxRuntime).GetField("stage", BindingFlags.Static | BindingFlags.NonPublic).GetValue(null);
            fixed (float* first = colors)
            fixed (float* nearest = depths)
            {
                var samples = Twin.lumivox_twin_picture(stage, 1, first, nearest);
                Assert.IsTrue(samples >= 8, $"{samples} samples: {Border.LastError()}");
            }
            float most = 0f, farthest = 0f;
            double sum = 0, light = 0;
            for (var i = 0; i < shown.pixels.Length; i++)
            {
                for (var c = 0; c < 3; c++)
                {
                    var off = Math.Abs(shown.pixels[i][c] - colors[4 * i + c]);
                    most = Math.Max(most, off);
                    sum += off;
                    light += colors[4 * i + c];
                }
                farthest = Math.Max(farthest, Math.Abs(written.pixels[i].r - depths[i]));
            }
            Console.WriteLine($"  {name}: colours differ by {sum / light:e1} of the light on average and {most:g3} at most, depths by {farthest:g3} at most");
            Save(name, shown, colors);
            // Halves have 11 bits, and two compilers round an exponential differently.
            var others = Enumerable.Range(0, shown.pixels.Length).Count(i => Enumerable.Range(0, 3).Any(c => Math.Abs(shown.pixels[i][c] - colors[4 * i + c]) > 1e-3f));
            var status = LumivoxRuntime.StatusOf(camera);
            Assert.IsTrue(sum / light < 1e-3, $"{name}: {sum / light}, in {others} of {shown.pixels.Length} pixels, after {settled} frames and {status.samples} samples");
            Assert.IsTrue(farthest < 1e-4f, $"{name}: depths differ by {farthest}");
            return shown.pixels;
        }

        /// Both pictures, beside each other, where somebody wants to look at them.
        static void Save(string name, Picture shown, float[] colors)
        {
            var folder = Environment.GetEnvironmentVariable("STANDIN_PICTURES");
            if (string.IsNullOrEmpty(folder)) return;
            var both = new Picture(2 * shown.width, shown.height);
            for (var i = 0; i < shown.pixels.Length; i++)
            {
                var at = i / shown.width * both.width + i % shown.width;
                both.pixels[at] = shown.pixels[i];
                both.pixels[at + shown.width] = new Color(colors[4 * i], colors[4 * i + 1], colors[4 * i + 2], 1f);
            }
            Directory.CreateDirectory(folder);
            File.WriteAllBytes(Path.Combine(folder, $"live-{name}.png"), Png.Of(both));
        }
    }

    public sealed class TwinLiveTests : TwinScene
    {
        [Test]
        public void AHeadIsWhatTheWgpuHostShows()
        {
            Add("head", 48, "ct-skin", Vector3.zero, Quaternion.Euler(0f, 30f, 0f));
            Compare("head");
        }

        [Test]
        public void AHeadAmongMeshesIsWhatTheWgpuHostShows()
        {
            Add("head", 32, "ct-bone", Vector3.zero, Quaternion.Euler(10f, -20f, 5f));
            Props.Plane(new Vector3(0.05f, 0f, -0.02f), new Vector3(0.4f, 0f, -1f), new Color(0.2f, 0.4f, 0.1f));
            Compare("meshes");
        }

        [Test]
        public void FiveVolumesInTheLightOfLampsAreWhatTheWgpuHostShows()
        {
            for (var i = 0; i < 5; i++)
            {
                var volume = Add("cube", 16, "ct-skin", new Vector3(0.035f * (i - 2), 0.03f * (i % 2), 0.02f * i), Quaternion.Euler(15f * i, 40f * i, 0f));
                volume.transform.localScale = Vector3.one * (2f + 0.5f * i);
                volume.SetWholeLook();
            }
            var sun = new GameObject("Sun").AddComponent<Light>();
            sun.type = LightType.Directional;
            sun.transform.rotation = Quaternion.Euler(50f, -30f, 0f);
            var lamp = new GameObject("Lamp").AddComponent<Light>();
            lamp.type = LightType.Point;
            lamp.color = new Color(1f, 0.6f, 0.2f);
            lamp.range = 0.6f;
            lamp.transform.position = new Vector3(-0.1f, 0.1f, -0.1f);
            var spot = new GameObject("Spot").AddComponent<Light>();
            spot.type = LightType.Spot;
            spot.range = 1f;
            spot.spotAngle = 40f;
            spot.transform.position = new Vector3(0.1f, 0.2f, -0.2f);
            spot.transform.LookAt(Vector3.zero);
            RenderSettings.fog = true;
            RenderSettings.fogMode = FogMode.Exponential;
            RenderSettings.fogDensity = 1.5f;
            RenderSettings.fogColor = new Color(0.3f, 0.3f, 0.35f);
            try
            {
                Compare("lamps");
            }
            finally
            {
                RenderSettings.fog = false;
            }
        }
    }

    static class Looks
    {
        /// All values scatter: a test body has values that no preset knows.
        public static void SetWholeLook(this LumivoxVolume volume)
        {
            var look = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
            look.SetPoints(new[] { new LumivoxTransferFunction.OpacityKnot(-10000f, 1f) }, new[] { new LumivoxTransferFunction.ColorStop(0f, new Color(0.9f, 0.7f, 0.6f)) });
            volume.transferFunction = look;
            volume.density = 20f;
        }
    }
}
