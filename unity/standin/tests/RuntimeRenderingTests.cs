// Whole frames: what cameras show of a volume in every pipeline, with meshes before and behind, in a headset, over many
// changes, after a reload of the scripts.
using System;
using System.Linq;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.HighDefinition;
using UnityEngine.Rendering.Universal;
using UnityEngine.XR;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed class RuntimeRenderingTests
    {
        const int Side = 32;

        Camera camera;
        LumivoxVolume volume;
        LumivoxVolumeAsset scan;
        LumivoxTransferFunction look;

        [SetUp]
        public void Begin()
        {
            Engine.Clear();
            Engine.SetScreen(Side, Side);
            camera = new GameObject("Camera").AddComponent<Camera>();
            camera.transform.position = new Vector3(0f, 0f, -0.3f);
            camera.nearClipPlane = 0.01f;
            camera.farClipPlane = 10f;
            camera.fieldOfView = 40f;
            camera.allowHDR = true;
            camera.clearFlags = CameraClearFlags.SolidColor;
            camera.backgroundColor = Color.black;
            var effect = camera.gameObject.AddComponent<LumivoxEffect>();
            effect.targetSamples = 8;
            effect.frameBudgetMs = 1000f;
            effect.environmentSource = LumivoxEnvironmentSource.Studio;
            scan = LumivoxVolumeAsset.Phantom("cube", 16);
            look = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
            look.SetPoints(new[] { new LumivoxTransferFunction.OpacityKnot(-10000f, 1f) }, new[] { new LumivoxTransferFunction.ColorStop(0f, Color.white) });
            volume = new GameObject("Cube").AddComponent<LumivoxVolume>();
            volume.volume = scan;
            volume.transferFunction = look;
            volume.density = 50f;
            volume.surfaceStrength = 0f;
            RuntimeComponentTests.Wait(() => scan.state == LumivoxVolumeState.Ready);
        }

        [TearDown]
        public void End()
        {
            LumivoxRuntime.Stop();
            Headset.isOn = false;
            StandInUniversal.usesCompatibilityMode =
#if UNITY_6000_0_OR_NEWER
                false;
#else
                true;
#endif
            Object.DestroyImmediate(scan);
            Object.DestroyImmediate(look);
            Engine.Clear();
        }

        void Settle(int most = 200)
        {
            for (var i = 0; i < most; i++)
            {
                Engine.Frame();
                Ticker.Tick();
                if (i > 2 && LumivoxRenderer.IsConverged(camera)) return;
            }
            var status = LumivoxRenderer.GetStatus(camera);
            Assert.Fail($"after {most} frames: {status.samples} of {status.target} samples, shown: {status.isShown}, error: '{LumivoxRenderer.LastError}'");
        }

        static Color At(Picture picture, float u, float v) => picture.At((int)(u * picture.width), (int)(v * picture.height));

        static float Light(Color color) => (color.r + color.g + color.b) / 3f;

        [Test]
        public void TheScanIsSeenInTheMiddleAndNotBesideIt()
        {
            Settle();
            var picture = Pictures.Color(camera);
            Assert.IsTrue(Light(At(picture, 0.5f, 0.5f)) > 0.02f, $"{At(picture, 0.5f, 0.5f)}");
            Assert.AreEqual(0f, Light(At(picture, 0.03f, 0.03f)));
            Assert.AreEqual("", LumivoxRenderer.LastError);
            var status = LumivoxRenderer.GetStatus(camera);
            Assert.IsTrue(status.samples >= 8 && status.isConverged);
            var center = camera.WorldToViewportPoint(volume.transform.position);
            var depth = At(Pictures.Depth(camera), center.x, center.y).r;
            Assert.IsTrue(depth > 0f, "no depth was written");
        }

        [Test]
        public void UpIsUp()
        {
            volume.transform.position = new Vector3(0f, 0.06f, 0f);
            Settle();
            var picture = Pictures.Color(camera);
            float Half(int from) => Enumerable.Range(from, Side / 2).Sum(y => Enumerable.Range(0, Side).Sum(x => Light(picture.At(x, y))));
            Assert.IsTrue(Half(Side / 2) > 4f * Half(0), $"{Half(Side / 2)} above, {Half(0)} below");
        }

        [Test]
        public void WhatStandsBeforeItHidesItAndWhatStandsBehindIsHidden()
        {
            Props.Plane(new Vector3(0f, 0f, -0.2f), Vector3.back, new Color(0.25f, 0.5f, 0.125f));
            Settle();
            var before = At(Pictures.Color(camera), 0.5f, 0.5f);
            Assert.AreEqual(0.5f, before.g, 0.01f);
            Assert.AreEqual(0.125f, before.b, 0.01f);
            Props.Clear();
            Props.Plane(new Vector3(0f, 0f, 0.4f), Vector3.back, new Color(0f, 1f, 0f));
            Settle();
            var behind = Pictures.Color(camera);
            Assert.AreEqual(1f, At(behind, 0.03f, 0.03f).g, 0.01f);
            Assert.IsTrue(At(behind, 0.5f, 0.5f).r > 0.02f, "the volume does not hide the plane");
        }

        [Test]
        public void EveryPipelineShowsTheSame()
        {
            Settle();
            var builtIn = Pictures.Color(camera);
            foreach (var kind in new[] { "graph", "compatibility", "HDRP" })
            {
#if !UNITY_6000_0_OR_NEWER
                if (kind == "graph") continue;
#endif
                LumivoxRuntime.Stop();
                StandInUniversal.usesCompatibilityMode = kind == "compatibility";
                var asset = kind == "HDRP" ? (RenderPipelineAsset)ScriptableObject.CreateInstance<HDRenderPipelineAsset>() : ScriptableObject.CreateInstance<UniversalRenderPipelineAsset>();
                Hook(kind == "HDRP" ? typeof(HighDefinition.LumivoxCustomPass).Assembly : typeof(Universal.LumivoxFeature).Assembly);
                GraphicsSettings.defaultRenderPipeline = asset;
                // One that somebody adds besides draws nothing once more.
                var another = new HighDefinition.LumivoxCustomPass();
                if (kind == "HDRP") CustomPassVolume.RegisterGlobalCustomPass(CustomPassInjectionPoint.BeforeTransparent, another);
                // The studio is as bright as HDRP's skies: its cameras are exposed for those.
                var exposure = kind == "HDRP" ? 1f / 30000f : 1f;
                Exposed(exposure);
                Settle();
                var picture = Pictures.Color(camera);
                var worst = Enumerable.Range(0, Side * Side).Max(i => Mathf.Abs(Light(picture.At(i % Side, i / Side)) - Light(builtIn.At(i % Side, i / Side))));
                // Half floats.
                Assert.IsTrue(worst < 0.01f, $"{kind}: off by {worst}");
                CustomPassVolume.UnregisterGlobalCustomPass(another);
                GraphicsSettings.defaultRenderPipeline = null;
                Object.DestroyImmediate(asset);
            }
        }

        /// HDRP's own exposure, as it is on the GPU.
        static void Exposed(float exposure)
        {
            var texture = new Texture2D(1, 1, UnityEngine.Experimental.Rendering.GraphicsFormat.R32G32B32A32_SFloat, UnityEngine.Experimental.Rendering.TextureCreationFlags.None);
            texture.SetPixel(0, 0, new Color(exposure, 0f, 0f));
            texture.Apply();
            Shader.SetGlobalTexture("_ExposureTexture", texture);
        }

        /// What the engine calls when scripts are loaded.
        static void Hook(System.Reflection.Assembly assembly)
        {
            foreach (var type in assembly.GetTypes())
                type.GetMethod("Hook", System.Reflection.BindingFlags.Static | System.Reflection.BindingFlags.NonPublic)?.Invoke(null, null);
        }

        [Test]
        public void AFeatureOfARendererTakesThePlaceOfTheInjectedPass()
        {
            var asset = ScriptableObject.CreateInstance<UniversalRenderPipelineAsset>();
            Hook(typeof(Universal.LumivoxFeature).Assembly);
            GraphicsSettings.defaultRenderPipeline = asset;
            Engine.Frame();
            Assert.AreEqual(1, StandInUniversal.passes);
            var feature = StandInUniversal.Add<Universal.LumivoxFeature>(asset);
            Engine.Frame();
            Assert.AreEqual(1, StandInUniversal.passes);
            feature.SetActive(false);
            Engine.Frame();
            Assert.AreEqual(1, StandInUniversal.passes);
            StandInUniversal.Remove(asset, feature);
            camera.GetComponent<LumivoxEffect>().enabled = false;
            Engine.Frame();
            Assert.AreEqual(0, StandInUniversal.passes);
            GraphicsSettings.defaultRenderPipeline = null;
            Object.DestroyImmediate(asset);
        }

        [TestCase(XRSettings.StereoRenderingMode.SinglePassInstanced)]
        [TestCase(XRSettings.StereoRenderingMode.MultiPass)]
        public void BothEyesSeeTheScanFromTheirPlace(XRSettings.StereoRenderingMode mode)
        {
            Headset.mode = mode;
            Headset.isOn = true;
            Headset.width = Headset.height = Side;
            Headset.separation = 0.12f;
            Settle();
            float Middle(Camera.StereoscopicEye eye)
            {
                var picture = Pictures.Color(camera, eye);
                float sum = 0f, weighted = 0f;
                for (var y = 0; y < Side; y++)
                    for (var x = 0; x < Side; x++)
                    {
                        sum += Light(picture.At(x, y));
                        weighted += x * Light(picture.At(x, y));
                    }
                Assert.IsTrue(sum > 1f, $"{eye} sees nothing");
                return weighted / sum;
            }
            Assert.IsTrue(Middle(Camera.StereoscopicEye.Left) > Middle(Camera.StereoscopicEye.Right) + 1f);
        }

        [Test]
        public void LayersAndSwitchesDecideWhoSeesIt()
        {
            Settle();
            camera.cullingMask = 1 << 3;
            Engine.Frames(3);
            Assert.AreEqual(0f, Light(At(Pictures.Color(camera), 0.5f, 0.5f)));
            volume.gameObject.layer = 3;
            Settle();
            Assert.IsTrue(Light(At(Pictures.Color(camera), 0.5f, 0.5f)) > 0.02f);
            volume.enabled = false;
            Engine.Frames(3);
            Assert.AreEqual(0f, Light(At(Pictures.Color(camera), 0.5f, 0.5f)));
            Assert.IsTrue(LumivoxRenderer.IsConverged(camera));
        }

        [Test]
        public void AFrameLeavesNoGarbage()
        {
            Settle();
            camera.GetComponent<LumivoxEffect>().frameBudgetMs = 1f;
            camera.GetComponent<LumivoxEffect>().resolutionScale = 0.25f;
            long garbage = 0, from = 0, ticks = 0;
            var isCounted = false;
            void Begin(Camera _) => from = GC.GetAllocatedBytesForCurrentThread();
            void End(Camera _)
            {
                if (isCounted) garbage += GC.GetAllocatedBytesForCurrentThread() - from;
            }
            // All that the package does in a frame happens in these, and in its turns.
            Camera.onPreCull = (Camera.CameraCallback)Begin + Camera.onPreCull + End;
            Camera.onPreRender = (Camera.CameraCallback)Begin + Camera.onPreRender + End;
            Camera.onPostRender = (Camera.CameraCallback)Begin + Camera.onPostRender + End;
            for (var i = 0; i < 100; i++)
            {
                isCounted = i >= 50;
                // Moving cameras trace, resting ones only draw.
                if (i % 2 == 0) camera.transform.position = new Vector3(0.0001f * i, 0f, -0.3f);
                if (i % 10 == 0) volume.density = 40f + i % 3;
                Engine.Frame();
                var before = GC.GetAllocatedBytesForCurrentThread();
                LumivoxRuntime.Tick();
                if (isCounted) ticks += GC.GetAllocatedBytesForCurrentThread() - before;
            }
            Camera.onPreCull -= Begin;
            // A pool may still grow.
            Assert.IsTrue(garbage < 4096, $"{garbage} bytes while 50 frames were recorded");
            Assert.AreEqual(0, ticks, "bytes in 50 turns");
        }

        [Test]
        public void AThousandChangesLeaveNothingBehind()
        {
            Settle();
            camera.GetComponent<LumivoxEffect>().frameBudgetMs = 1f;
            int buffers = 0, textures = 0;
            for (var i = 0; i < 1000; i++)
            {
                switch (i % 5)
                {
                    case 0:
                        volume.density = 10f + i % 40;
                        break;
                    case 1:
                        look.shift = i % 7;
                        break;
                    case 2:
                        volume.enabled = !volume.enabled;
                        break;
                    case 3:
                        volume.clipMax = new Vector3(1f, 1f, 0.5f + i % 50 * 0.01f);
                        break;
                    default:
                        volume.transform.position = new Vector3(0f, 0.001f * (i % 10), 0f);
                        break;
                }
                if (i % 10 == 0)
                {
                    Engine.Frame();
                    Ticker.Tick();
                }
                if (i == 200) (buffers, textures) = (Live.buffers, Live.renderTextures);
            }
            volume.enabled = true;
            Settle();
            Assert.IsTrue(Live.buffers <= buffers + 8, $"{buffers} buffers became {Live.buffers}:\n{Live.Describe()}");
            Assert.IsTrue(Live.renderTextures <= textures + 2, $"{textures} textures became {Live.renderTextures}:\n{Live.Describe()}");
            volume.enabled = false;
            LumivoxRuntime.Stop();
            Assert.AreEqual(0, Live.buffers, Live.Describe());
            Assert.AreEqual(0, Live.renderTextures, Live.Describe());
            // Those of the last read-backs end with a frame.
            Engine.Frames(4);
            Assert.AreEqual(0, Live.safetyHandles);
        }

        [Test]
        public void AfterADomainReloadItIsSeenAgain()
        {
            Settle();
            Domain.Reload();
            Assert.AreEqual(0, Live.buffers, Live.Describe());
            camera = Object.FindObjectsByType<Camera>(FindObjectsSortMode.None).Single();
            volume = Object.FindObjectsByType<LumivoxVolume>(FindObjectsSortMode.None).Single();
            (scan, look) = (volume.volume, volume.transferFunction);
            RuntimeComponentTests.Wait(() => volume.volume.state == LumivoxVolumeState.Ready);
            Settle();
            Assert.IsTrue(Light(At(Pictures.Color(camera), 0.5f, 0.5f)) > 0.02f);
        }

        [Test]
        public void WithoutRoomItSaysSoAndGoesOnWhenThereIsSome()
        {
            Settle();
            var other = LumivoxVolumeAsset.Phantom("cube", 48);
            var second = new GameObject("Second").AddComponent<LumivoxVolume>();
            second.volume = other;
            RuntimeComponentTests.Wait(() => other.state == LumivoxVolumeState.Ready);
            Log.Expect(LogType.Error, "Lumivox cannot draw the volumes: ");
            Faults.allocationsLeft = 1;
            Engine.Frames(1);
            Assert.IsTrue(LumivoxRenderer.LastError.Length > 0);
            Faults.Clear();
            second.density = 40f;
            Settle();
            Assert.AreEqual("", LumivoxRenderer.LastError);
            Assert.IsTrue(Light(At(Pictures.Color(camera), 0.5f, 0.5f)) > 0.02f);
            Object.DestroyImmediate(second.gameObject);
            Object.DestroyImmediate(other);
        }

        [Test]
        public void LostReadBacksDoNotStopIt()
        {
            Faults.failReadBacks = true;
            for (var i = 0; i < 20; i++)
            {
                Engine.Frame();
                Ticker.Tick();
            }
            Assert.IsTrue(Light(At(Pictures.Color(camera), 0.5f, 0.5f)) > 0.02f);
            Faults.Clear();
            Settle();
        }
    }
}
