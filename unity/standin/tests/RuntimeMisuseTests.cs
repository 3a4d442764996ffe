// What scripts and editors do that no manual recommends: objects that end while a frame is drawn, numbers that are none,
// components in any order, play mode that begins and ends, tokens that live for ever.
using System;
using System.Linq;
using System.Reflection;
using System.Runtime.CompilerServices;
using System.Threading;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using UnityEngine.Scripting;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed class RuntimeMisuseTests : CubeScene
    {
        static float Middle(Camera of) => Light(At(Pictures.Color(of), 0.5f, 0.5f));

        /// Another camera, which sees other layers as well: its world is not that of the first.
        Camera Another()
        {
            var other = Object.Instantiate(camera.gameObject).GetComponent<Camera>();
            other.cullingMask = ~(1 << 9);
            var second = Object.Instantiate(volume.gameObject);
            second.layer = 9;
            second.transform.position = new Vector3(0f, 0f, 5f);
            return other;
        }

        [TestCase("the scan")]
        [TestCase("its object")]
        [TestCase("its function")]
        public void WhatEndsBetweenTwoCamerasOfAFrameIsNotShownByTheSecond(string what)
        {
            var other = Another();
            LumivoxRenderer.RenderAtOnce = true;
            Engine.Frames(3);
            camera.enabled = other.enabled = false;
            camera.Render();
            Assert.IsTrue(Middle(camera) > 0.02f);
            if (what == "the scan") Object.DestroyImmediate(scan);
            else if (what == "its object") Object.DestroyImmediate(volume.gameObject);
            else
            {
                // Without one of its own it is shown with what suits it.
                Object.DestroyImmediate(look);
                volume.density = 0f;
            }
            other.Render();
            Assert.AreEqual(0f, Middle(other), 1e-3f);
            Assert.AreEqual("", LumivoxRenderer.LastError);
            LumivoxRenderer.RenderAtOnce = false;
        }

        [TestCase("a place")]
        [TestCase("a function")]
        [TestCase("a light")]
        public void WhatAScriptChangesBetweenTwoCamerasOfAFrameTheSecondSees(string what)
        {
            LumivoxRenderer.RenderAtOnce = true;
            var other = Object.Instantiate(camera.gameObject).GetComponent<Camera>();
            other.GetComponent<LumivoxEffect>().environmentSource = camera.GetComponent<LumivoxEffect>().environmentSource = LumivoxEnvironmentSource.Scene;
            RenderSettings.ambientMode = UnityEngine.Rendering.AmbientMode.Flat;
            RenderSettings.ambientLight = what == "a light" ? Color.black : Color.white;
            var lamp = new GameObject("Lamp").AddComponent<Light>();
            (lamp.type, lamp.intensity) = (LightType.Directional, what == "a light" ? 1f : 0f);
            LumivoxRenderer.FindLights();
            Engine.Frames(3);
            camera.enabled = other.enabled = false;
            camera.Render();
            Assert.IsTrue(Middle(camera) > 0.02f, $"{Middle(camera)}");
            if (what == "a place") volume.transform.position = new Vector3(0f, 3f, 0f);
            else if (what == "a function") look.SetPoints(new LumivoxTransferFunction.OpacityKnot[0], null);
            else lamp.enabled = false;
            other.Render();
            Assert.AreEqual(0f, Middle(other), 1e-3f);
            // And the first, when its turn comes again.
            camera.Render();
            Assert.AreEqual(0f, Middle(camera), 1e-3f);
            LumivoxRenderer.RenderAtOnce = false;
        }

        [Test]
        public void AnObjectWithoutAPlaceOrSizeHidesNoOther()
        {
            var others = new[] { new Vector3(1f, 0f, 1f), Vector3.one * float.NaN, Vector3.one * float.PositiveInfinity, Vector3.one * 1e-30f, Vector3.one * 1e30f }.Select(scale =>
            {
                var other = Object.Instantiate(volume.gameObject);
                other.transform.localScale = scale;
                return other;
            }).ToArray();
            Settle();
            Assert.AreEqual("", LumivoxRenderer.LastError);
            Assert.IsTrue(Middle(camera) > 0.02f);
            Assert.AreEqual(0f, Light(At(Pictures.Color(camera), 0.03f, 0.03f)));
            foreach (var other in others) Object.DestroyImmediate(other);
        }

        [Test]
        public void AMirroredObjectIsTheMirrorImage()
        {
            camera.GetComponent<LumivoxEffect>().environmentSource = LumivoxEnvironmentSource.Scene;
            RenderSettings.ambientMode = UnityEngine.Rendering.AmbientMode.Flat;
            RenderSettings.ambientLight = Color.white;
            // Half of it, to the right.
            volume.clipMin = new Vector3(0.5f, 0f, 0f);
            float Half(Picture picture, int from) => Enumerable.Range(from, Side / 2).Sum(x => Enumerable.Range(0, Side).Sum(y => Light(picture.At(x, y))));
            Settle();
            var picture = Pictures.Color(camera);
            Assert.IsTrue(Half(picture, Side / 2) > 4f * Half(picture, 0));
            volume.transform.localScale = new Vector3(-1f, 1f, 1f);
            Settle();
            var mirrored = Pictures.Color(camera);
            Assert.IsTrue(Half(mirrored, 0) > 4f * Half(mirrored, Side / 2));
            Assert.AreEqual(Half(picture, Side / 2), Half(mirrored, 0), 0.1f * Half(mirrored, 0));
            Assert.AreEqual("", LumivoxRenderer.LastError);
        }

        [Test]
        public void PointsThatAreNoNumbersSpoilNoPicture()
        {
            Settle();
            var expected = Pictures.Color(camera).mean;
            look.SetPoints(new[]
            {
                new LumivoxTransferFunction.OpacityKnot(float.NaN, 1f), new LumivoxTransferFunction.OpacityKnot(-10000f, 1f),
                new LumivoxTransferFunction.OpacityKnot(0f, float.NaN), new LumivoxTransferFunction.OpacityKnot(float.PositiveInfinity, 1f),
            }, new[] { new LumivoxTransferFunction.ColorStop(0f, Color.white), new LumivoxTransferFunction.ColorStop(5f, new Color(float.NaN, 1f, 1f)) });
            Settle();
            Assert.AreEqual("", LumivoxRenderer.LastError);
            var shown = Pictures.Color(camera).mean;
            for (var c = 0; c < 3; c++) Assert.AreEqual(expected[c], shown[c], 0.05f * expected[c]);
        }

        [Test]
        public void AnEffectIsItsCamerasWhicheverCameFirst()
        {
            // Before its camera it is everybody's; from then on that camera's alone.
            var made = new GameObject("Second camera");
            var effect = made.AddComponent<LumivoxEffect>();
            effect.targetSamples = 77;
            var plain = new GameObject("Third camera").AddComponent<Camera>();
            Assert.IsTrue(LumivoxEffect.TryGet(plain, out var settings));
            Assert.AreEqual(77, settings.targetSamples);
            var second = made.AddComponent<Camera>();
            Assert.IsTrue(LumivoxEffect.TryGet(second, out settings));
            Assert.AreEqual(77, settings.targetSamples);
            Assert.IsTrue(LumivoxEffect.TryGet(plain, out settings));
            Assert.AreEqual(LumivoxSettings.Default.targetSamples, settings.targetSamples);
        }

        [Test]
        public void WhereNothingIsShownNothingStaysOnTheGpu()
        {
            Settle();
            Assert.IsTrue(LumivoxRenderer.VoxelBytes > 0);
            volume.enabled = false;
            Engine.Frame();
            Ticker.Tick();
            // It may be shown again at once.
            Assert.IsTrue(LumivoxRenderer.VoxelBytes > 0);
            var watch = System.Diagnostics.Stopwatch.StartNew();
            while (LumivoxRenderer.VoxelBytes > 0 && watch.Elapsed.TotalSeconds < 120)
            {
                Engine.Frame();
                Ticker.Tick();
                Thread.Sleep(20);
            }
            Assert.AreEqual(0, LumivoxRenderer.VoxelBytes);
            Assert.AreEqual(0, Live.buffers, Live.Describe());
            Assert.AreEqual(0, Live.renderTextures, Live.Describe());
            volume.enabled = true;
            RuntimeComponentTests.Wait(() => scan.state == LumivoxVolumeState.Ready);
            Settle();
            Assert.IsTrue(Middle(camera) > 0.02f);
        }

        [TestCase(true)]
        [TestCase(false)]
        public void NothingOfOursOutlivesPlayMode(bool reloads)
        {
            RenderSettings.ambientMode = UnityEngine.Rendering.AmbientMode.Skybox;
            RenderSettings.skybox = new Material(Resources.Load<Shader>("Lumivox/LumivoxDepth"));
            camera.GetComponent<LumivoxEffect>().environmentSource = LumivoxEnvironmentSource.Scene;
            string[] Ours() => Objects.All().Where(item => !item.isDestroyed && (item.name ?? "").StartsWith("Lumivox") && (item is GameObject || item is RenderTexture)).Select(item => $"{item.GetType().Name} {item.name}").ToArray();
            for (var time = 0; time < 2; time++)
            {
                Domain.Play(reloads);
                camera = Object.FindObjectsByType<Camera>(FindObjectsSortMode.None).Single(one => one.name == "Camera");
                for (var i = 0; i < 12; i++)
                {
                    Engine.Frame();
                    Thread.Sleep(2);
                }
                Assert.IsTrue(Ours().Length > 0);
                Domain.Stop();
                Assert.AreEqual(0, Ours().Length, string.Join(", ", Ours()));
            }
            RenderSettings.skybox = null;
        }

        [MethodImpl(MethodImplOptions.NoInlining)]
        static WeakReference Loaded(CancellationToken token)
        {
            var importer = new LumivoxImporter();
            var loading = importer.Load(new[] { "/nowhere/at/all" }, null, token);
            RuntimeComponentTests.Wait(() => loading.IsCompleted);
            Assert.IsTrue(loading.IsFaulted);
            importer.Dispose();
            return new WeakReference(importer);
        }

        [Test]
        public void ATokenThatLivesForEverHoldsNoImport()
        {
            using (var source = new CancellationTokenSource())
            {
                var importer = Loaded(source.Token);
                for (var i = 0; i < 10 && importer.IsAlive; i++)
                {
                    Engine.Frame();
                    Ticker.Tick();
                    GC.Collect();
                    GC.WaitForPendingFinalizers();
                }
                Assert.IsFalse(importer.IsAlive);
                GC.KeepAlive(source);
            }
        }

        [Test]
        public void PlayersKeepTheAssembliesThatNothingButTheEngineCalls()
        {
            var called = Domain.Scripts().Where(assembly => assembly.GetTypes().Any(type => type.GetMethods(BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic).Any(method => method.IsDefined(typeof(RuntimeInitializeOnLoadMethodAttribute)))))
                .Where(assembly => assembly.GetName().Name.StartsWith("Lumivox")).ToList();
            Assert.IsTrue(called.Count >= 2, "URP's and HDRP's halves begin so");
            foreach (var assembly in called) Assert.IsTrue(assembly.IsDefined(typeof(AlwaysLinkAssemblyAttribute)), assembly.FullName);
        }
    }
}
