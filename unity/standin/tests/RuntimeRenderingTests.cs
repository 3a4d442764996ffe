// Whole frames: what cameras show of a volume in every pipeline, with meshes before and behind, in a headset, over many
// changes, after a reload of the scripts.
using System;
using System.Linq;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.HighDefinition;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed class RuntimeRenderingTests : CubeScene
    {
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
        public void ItEndsByItsNoiseWhereThatIsAsked()
        {
            var effect = camera.GetComponent<LumivoxEffect>();
            (effect.targetSamples, effect.targetNoise) = (2048, 0.25f);
            Settle();
            var samples = LumivoxRenderer.GetStatus(camera).samples;
            Assert.IsTrue(samples >= 16 && samples < 2048, $"{samples} samples");
            effect.targetNoise = 3f;
            Assert.AreEqual(1f, effect.targetNoise);
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
                var pipeline = new Pipeline(kind);
                // One that somebody adds besides draws nothing once more.
                var another = new HighDefinition.LumivoxCustomPass();
                if (kind == "HDRP") CustomPassVolume.RegisterGlobalCustomPass(CustomPassInjectionPoint.BeforeTransparent, another);
                // The studio is as bright as HDRP's skies: its cameras are exposed for those.
                var exposure = kind == "HDRP" ? 1f / 30000f : 1f;
                StandInHighDefinition.exposure = _ => exposure;
                Settle();
                var picture = Pictures.Color(camera);
                var worst = Enumerable.Range(0, Side * Side).Max(i => Mathf.Abs(Light(picture.At(i % Side, i / Side)) - Light(builtIn.At(i % Side, i / Side))));
                // Half floats.
                Assert.IsTrue(worst < 0.01f, $"{kind}: off by {worst}");
                CustomPassVolume.UnregisterGlobalCustomPass(another);
                pipeline.Dispose();
            }
        }

        [TestCase("Built-in")]
        [TestCase("graph")]
        [TestCase("HDRP")]
        public void ACameraThatIsDestroyedWhileAnotherIsDrawnTakesOnlyItsOwnViewAlong(string kind)
        {
#if !UNITY_6000_0_OR_NEWER
            if (kind == "graph") return;
#endif
            var pipeline = kind == "Built-in" ? null : new Pipeline(kind);
            var other = PlainCamera.Make(Side);
            Engine.Frames(3);
            void Destroy(Camera drawn)
            {
                if (drawn == camera && other != null) Object.DestroyImmediate(other.gameObject);
            }
            void DestroyInPipeline(ScriptableRenderContext context, Camera drawn) => Destroy(drawn);
            Camera.onPreRender += Destroy;
            RenderPipelineManager.beginCameraRendering += DestroyInPipeline;
            Settle();
            Camera.onPreRender -= Destroy;
            RenderPipelineManager.beginCameraRendering -= DestroyInPipeline;
            Assert.IsTrue(other == null);
            Assert.IsTrue(Light(At(Pictures.Color(camera), 0.5f, 0.5f)) > 0.02f);
            Assert.AreEqual("", LumivoxRenderer.LastError);
            pipeline?.Dispose();
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

        [TestCase("Built-in")]
        [TestCase("graph")]
        [TestCase("compatibility")]
        [TestCase("feature")]
        [TestCase("HDRP")]
        public void AFrameLeavesNoGarbage(string kind)
        {
#if !UNITY_6000_0_OR_NEWER
            if (kind == "graph") kind = "compatibility";
#endif
            using (var pipeline = new Pipeline(kind))
            {
                // Lit by all that a pipeline's own lights and skies are read from.
                var effect = camera.GetComponent<LumivoxEffect>();
                effect.environmentSource = LumivoxEnvironmentSource.Scene;
                RenderSettings.ambientMode = AmbientMode.Trilight;
                foreach (var type in new[] { LightType.Directional, LightType.Point, LightType.Spot })
                {
                    var light = new GameObject(type.ToString()).AddComponent<UnityEngine.Light>();
                    light.type = type;
                    light.transform.position = new Vector3(0.3f, 0.5f, -0.3f);
                    if (kind == "HDRP") light.gameObject.AddComponent<HDAdditionalLightData>();
                }
                if (kind == "HDRP")
                {
                    VolumeManager.instance.stack.GetComponent<VisualEnvironment>().skyType.value = (int)SkyType.Gradient;
                    StandInHighDefinition.exposure = _ => 0.1f;
                }
                if (kind == "feature") pipeline.Add<Universal.LumivoxFeature>();
                LumivoxRenderer.FindLights();
                Settle();
                effect.frameBudgetMs = 1f;
                effect.resolutionScale = 0.25f;
                var passes = 0;
                Garbage.IsLeftByNone(50, 50, i =>
                {
                    // Moving cameras trace, resting ones only draw.
                    if (i % 2 == 0) camera.transform.position = new Vector3(0.0001f * i, 0f, -0.3f);
                    if (i % 10 == 0) volume.density = 40f + i % 3;
                }, () => passes += LumivoxRenderer.GetStatus(camera).isShown ? 1 : 0);
                Assert.AreEqual(50, passes, "not all frames were drawn");
            }
        }

        [Test]
        public void GarbageIsSeenWhereverScriptsAreCalled()
        {
            object kept = null;
            void Leave() => kept = new byte[1000];
            void Check(string what, Action once)
            {
                Callbacks.Reset();
                once();
                Assert.IsTrue(Callbacks.bytes >= 1000 && kept != null, $"{what}: {Callbacks.bytes} bytes");
                kept = null;
            }
            void Rendering(Camera _) => Leave();
            Camera.onPreRender += Rendering;
            Check("a camera's callback", () => Engine.Frame());
            Camera.onPreRender -= Rendering;
            Check("a read-back", () =>
            {
                AsyncGPUReadback.Request(Texture2D.whiteTexture, 0, _ => Leave());
                Engine.Frames(4);
            });
            void Beginning(ScriptableRenderContext _, Camera __) => Leave();
            RenderPipelineManager.beginCameraRendering += Beginning;
            using (new Pipeline("graph")) Check("a camera of a pipeline", () => Engine.Frame());
            RenderPipelineManager.beginCameraRendering -= Beginning;
            var pass = new Leaving { leave = Leave };
            using (new Pipeline("HDRP"))
            {
                CustomPassVolume.RegisterGlobalCustomPass(CustomPassInjectionPoint.BeforeTransparent, pass);
                Check("a custom pass", () => Engine.Frame());
                CustomPassVolume.UnregisterGlobalCustomPass(pass);
            }
        }

        sealed class Leaving : CustomPass
        {
            internal Action leave;
            protected override void Execute(CustomPassContext ctx) => leave();
        }

        [Test]
        public void WhatIsCutOpenRestsWhenItHasItsSamples()
        {
            camera.GetComponent<LumivoxEffect>().targetSamples = 64;
            int Frames()
            {
                // Those that wait for another thread trace nothing.
                var frames = 0;
                void Count() => frames += LumivoxRenderer.GetStatus(camera).pixelSamples > 0 ? 1 : 0;
                Assert.IsTrue(Waiting.Frames(() => LumivoxRenderer.IsConverged(camera), Count), "it never rests");
                var samples = LumivoxRenderer.GetStatus(camera).samples;
                Assert.IsTrue(samples >= 64, $"it rests with {samples} samples");
                return frames;
            }
            var whole = Frames();
            // From the side that is cut away.
            volume.clipMax = new Vector3(0.5f, 1f, 1f);
            camera.transform.SetPositionAndRotation(Quaternion.Euler(10f, -38f, 0f) * Vector3.back * 0.3f, Quaternion.Euler(10f, -38f, 0f));
            var cut = Frames();
            Assert.IsTrue(cut <= whole + 4, $"{whole} frames became {cut}");
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
