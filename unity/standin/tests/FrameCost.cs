// What a frame costs the main thread, for a look and not for a verdict: gathering the scene, handing it to the native library,
// its recording, and the commands that are recorded of it. What the GPU does is not in it.
//
//     script/unity --frame-cost
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using StandIn;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.HighDefinition;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public static class FrameCost
    {
        const int Volumes = 10, Lights = 8;
        /// Those that pools grow in, and those that count.
        const int WarmUp = 40, Frames = 80;

        /// Prints medians of each pipeline, in milliseconds.
        public static void Print()
        {
            Console.WriteLine($"{Volumes} volumes, {Lights} lights, {SystemInfo.graphicsDeviceName}, {Environment.ProcessorCount} cores: ms of the main thread, median (90th percentile) of {Frames} frames");
            // The run-time compiles what is run often anew: not while it counts.
            Measure("Built-in", false);
            foreach (var kind in new[] { "Built-in", "graph", "compatibility", "HDRP" }) Measure(kind, true);
        }

        static void Measure(string kind, bool isPrinted)
        {
            Engine.Clear();
            Engine.SetScreen(32, 24);
            using (new Pipeline(kind))
            {
                var (camera, volumes) = Scene(kind == "HDRP");
                void Of(string what, Action<int> change)
                {
                    var line = Measure(camera, change);
                    if (isPrinted) Console.WriteLine($"{kind,-14} {what,-16} {line}");
                }
                Of("at rest", i => { });
                Of("camera moves", i => camera.transform.position = new Vector3(0.0001f * (i % 7), 0f, -0.6f));
                Of("volume moves", i => volumes[i % Volumes].transform.position += Vector3.up * (i % 2 == 0 ? 0.0001f : -0.0001f));
                Of("density changes", i => volumes[i % Volumes].density = 40f + i % 3);
            }
            LumivoxRuntime.Stop();
            Engine.Clear();
            LumivoxVolumeAsset.CloseUnused(0f);
        }

        static (Camera camera, LumivoxVolume[] volumes) Scene(bool isHighDefinition)
        {
            var camera = new GameObject("Camera").AddComponent<Camera>();
            camera.transform.position = new Vector3(0f, 0f, -0.6f);
            (camera.nearClipPlane, camera.farClipPlane, camera.fieldOfView) = (0.01f, 10f, 40f);
            var effect = camera.gameObject.AddComponent<LumivoxEffect>();
            // As little as there is for the device to do: it has the same cores.
            (effect.targetSamples, effect.frameBudgetMs, effect.resolutionScale) = (4, 0.5f, 0.25f);
            RenderSettings.ambientMode = AmbientMode.Trilight;
            var volumes = Enumerable.Range(0, Volumes).Select(i =>
            {
                var volume = new GameObject($"Volume {i}").AddComponent<LumivoxVolume>();
                volume.volume = LumivoxVolumeAsset.Phantom("cube", 16);
                volume.transform.position = new Vector3(0.04f * (i % 5 - 2), 0.05f * (i / 5), 0.02f * i);
                volume.SetWholeLook();
                return volume;
            }).ToArray();
            for (var i = 0; i < Lights; i++)
            {
                var light = new GameObject($"Light {i}").AddComponent<Light>();
                light.type = i == 0 ? LightType.Directional : i % 2 == 0 ? LightType.Point : LightType.Spot;
                light.transform.position = new Vector3(0.2f * (i - 4), 0.5f, -0.5f);
                light.transform.LookAt(Vector3.zero);
                if (isHighDefinition) light.gameObject.AddComponent<HDAdditionalLightData>();
            }
            if (isHighDefinition) VolumeManager.instance.stack.GetComponent<VisualEnvironment>().skyType.value = (int)SkyType.Gradient;
            RuntimeComponentTests.Wait(() => volumes.All(volume => volume.volume.state == LumivoxVolumeState.Ready));
            LumivoxRenderer.FindLights();
            for (var i = 0; i < 500 && !(i > 10 && LumivoxRenderer.IsConverged(camera)); i++) Turn();
            if (!LumivoxRenderer.IsConverged(camera)) throw new InvalidOperationException($"the scene is not shown: {LumivoxRenderer.LastError}");
            return (camera, volumes);
        }

        static void Turn()
        {
            Engine.Frame();
            Ticker.Tick();
        }

        static string Measure(Camera camera, Action<int> change)
        {
            List<double> turns = new List<double>(), frames = new List<double>();
            var watch = new System.Diagnostics.Stopwatch();
            for (var i = -WarmUp; i < Frames; i++)
            {
                change(i + WarmUp);
                Callbacks.Reset();
                Engine.Frame();
                watch.Restart();
                Ticker.Tick();
                var turn = watch.Elapsed.TotalMilliseconds;
                if (i < 0) continue;
                turns.Add(turn);
                frames.Add(Callbacks.milliseconds + turn);
            }
            if (!LumivoxRenderer.GetStatus(camera).isShown) throw new InvalidOperationException($"the scene is not shown: {LumivoxRenderer.LastError}");
            return $"{Of(frames)}, of which the turn between frames {Of(turns)}";
        }

        static string Of(List<double> all)
        {
            all.Sort();
            return string.Format(CultureInfo.InvariantCulture, "{0:0.000} ({1:0.000})", all[all.Count / 2], all[all.Count * 9 / 10]);
        }
    }
}
