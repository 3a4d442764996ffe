// What pipelines do around a pass: features that come and go, eyes of a headset, passes that are drawn next, devices that lack
// formats.
using System.Collections.Generic;
using System.Linq;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using UnityEngine.Experimental.Rendering;
using UnityEngine.Rendering;
using UnityEngine.Rendering.HighDefinition;
using UnityEngine.Rendering.Universal;
using UnityEngine.XR;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed class RuntimePipelineTests : CubeScene
    {
        /// Whatever is drawn twice shows less of what is behind it.
        void MakeTranslucent()
        {
            volume.density = 0.02f;
            Props.Plane(new Vector3(0f, 0f, 0.4f), Vector3.back, new Color(0f, 1f, 0f));
        }

        static float Worst(Picture a, Picture b) =>
            Enumerable.Range(0, Side * Side).Max(i => Mathf.Abs(Light(a.At(i % Side, i / Side)) - Light(b.At(i % Side, i / Side))));

        Picture Settled()
        {
            Settle();
            return Pictures.Color(camera);
        }

        [TestCase("graph")]
        [TestCase("compatibility")]
        public void VolumesAreDrawnOnceWhateverBecomesOfFeatures(string kind)
        {
#if !UNITY_6000_0_OR_NEWER
            if (kind == "graph") return;
#endif
            MakeTranslucent();
            var expected = Settled();
            // The light of the cube is white, and what it lets through is green.
            var middle = At(expected, 0.5f, 0.5f);
            Assert.IsTrue(middle.r > 0.1f && middle.g > middle.r + 0.1f, $"the cube is no veil: {middle}");
            var asset = ScriptableObject.CreateInstance<UniversalRenderPipelineAsset>();
            Pipeline.Hook(typeof(Universal.LumivoxFeature).Assembly);
            StandInUniversal.usesCompatibilityMode = kind == "compatibility";
            GraphicsSettings.defaultRenderPipeline = asset;
            void Check(string when) => Assert.IsTrue(Worst(Settled(), expected) < 0.01f, $"{when}: off by {Worst(Pictures.Color(camera), expected)}");
            Check("without a feature");
            // URP begins a camera, and gives it up: what was enqueued for it stays.
            Settle();
            RenderPipelineManager.BeginCamera(default, camera);
            Engine.Frame();
            Assert.IsTrue(Worst(Pictures.Color(camera), expected) < 0.01f, $"after a frame that was given up: off by {Worst(Pictures.Color(camera), expected)}");
            var feature = StandInUniversal.Add<Universal.LumivoxFeature>(asset);
            Check("with a feature");
            // As when a value of the asset, the renderer or the quality level is changed.
            StandInUniversal.Reload(asset);
            Check("with a feature of a pipeline that was made anew");
            feature.SetActive(false);
            Check("with a feature that is switched off");
            feature.SetActive(true);
            Check("with a feature that is switched on again");
            StandInUniversal.Remove(asset, feature);
            Check("after the feature");
            GraphicsSettings.defaultRenderPipeline = null;
            Object.DestroyImmediate(asset);
        }

        [TestCase("Built-in", XRSettings.StereoRenderingMode.SinglePassInstanced)]
        [TestCase("graph", XRSettings.StereoRenderingMode.SinglePassInstanced)]
        [TestCase("graph", XRSettings.StereoRenderingMode.MultiPass)]
        [TestCase("compatibility", XRSettings.StereoRenderingMode.SinglePassInstanced)]
        [TestCase("compatibility", XRSettings.StereoRenderingMode.MultiPass)]
        [TestCase("HDRP", XRSettings.StereoRenderingMode.SinglePassInstanced)]
        public void BothEyesSeeTheScanFromTheirPlaceInEveryPipeline(string kind, XRSettings.StereoRenderingMode mode)
        {
#if !UNITY_6000_0_OR_NEWER
            if (kind == "graph") return;
#endif
            MakeTranslucent();
            Headset.isOn = true;
            Headset.width = Headset.height = Side;
            Headset.separation = 0.12f;
            Headset.mode = XRSettings.StereoRenderingMode.MultiPass;
            Settle();
            Picture left = Pictures.Color(camera, Camera.StereoscopicEye.Left), right = Pictures.Color(camera, Camera.StereoscopicEye.Right);
            Assert.IsTrue(Middle(left) > Middle(right) + 1f, $"{Middle(left)} and {Middle(right)}");
            Headset.mode = mode;
            using (new Pipeline(kind))
            {
                StandInHighDefinition.exposure = _ => kind == "HDRP" ? 1f / 30000f : 1f;
                Settle();
                float worst = Mathf.Max(Worst(Pictures.Color(camera, Camera.StereoscopicEye.Left), left), Worst(Pictures.Color(camera, Camera.StereoscopicEye.Right), right));
                Save(kind, mode);
                Assert.IsTrue(worst < 0.01f, $"off by {worst}");
            }
        }

        /// Where pictures of both eyes are wanted.
        void Save(string kind, XRSettings.StereoRenderingMode mode)
        {
            var folder = System.Environment.GetEnvironmentVariable("STANDIN_PICTURES");
            if (string.IsNullOrEmpty(folder)) return;
            foreach (var eye in new[] { Camera.StereoscopicEye.Left, Camera.StereoscopicEye.Right })
                Pictures.Color(camera, eye).Save(System.IO.Path.Combine(folder, $"eyes-{kind}-{mode}-{eye}.png"));
        }

        /// Where the cube is, along x: what is no green plane alone.
        static float Middle(Picture picture)
        {
            float sum = 0f, weighted = 0f;
            for (var y = 0; y < Side; y++)
                for (var x = 0; x < Side; x++)
                {
                    sum += picture.At(x, y).r;
                    weighted += x * picture.At(x, y).r;
                }
            Assert.IsTrue(sum > 1f, "it is not seen");
            return weighted / sum;
        }

#if !UNITY_6000_3_OR_NEWER
        [Test]
        public void WhatIsDrawnNextIsDrawnToTheCameraWhetherAScanIsThereYetOrNot()
        {
            var paint = new PaintPass(Color.green);
            var another = LumivoxVolumeAsset.Phantom("cube", 48);
            void Enqueue(ScriptableRenderContext context, Camera drawn) => drawn.GetUniversalAdditionalCameraData().scriptableRenderer.EnqueuePass(paint);
            using (new Pipeline("compatibility"))
            {
                RenderPipelineManager.beginCameraRendering += Enqueue;
                try
                {
                    Settle();
                    Assert.AreEqual(Color.green, At(Pictures.Color(camera), 0.5f, 0.5f), "over the volume");
                    // Another scan comes, and there is no room for it yet.
                    var second = new GameObject("Second").AddComponent<LumivoxVolume>();
                    second.volume = another;
                    RuntimeComponentTests.Wait(() => another.state == LumivoxVolumeState.Ready);
                    Log.Expect(LogType.Error, "Lumivox cannot draw the volumes: ");
                    Faults.allocationsLeft = 1;
                    Engine.Frame();
                    Faults.Clear();
                    Assert.AreNotEqual("", LumivoxRenderer.LastError);
                    Assert.AreEqual(Color.green, At(Pictures.Color(camera), 0.5f, 0.5f), "while there is nothing to show");
                }
                finally
                {
                    RenderPipelineManager.beginCameraRendering -= Enqueue;
                    Object.DestroyImmediate(another);
                }
            }
        }
#endif

        static List<CustomPassVolume> Hidden => Objects.All().OfType<CustomPassVolume>().Where(one => one != null).ToList();

        [Test]
        public void BeforePassesForAllCamerasEachHasAVolumeOfItsOwn()
        {
            MakeTranslucent();
            var expected = Settled();
            using (new Pipeline("HDRP"))
            {
                Assert.IsTrue(CustomPassVolume.UnregisterGlobalCustomPass(HighDefinition.HighDefinitionHost.Pass));
                StandInHighDefinition.exposure = _ => 1f / 30000f;
                HighDefinition.PassOfCameras.Hook();
                try
                {
                    Assert.IsTrue(Worst(Settled(), expected) < 0.01f, $"off by {Worst(Pictures.Color(camera), expected)}");
                    var other = PlainCamera.Make(Side);
                    Settle();
                    Assert.AreEqual(2, Hidden.Count);
                    Assert.IsTrue(Worst(Pictures.Color(other), expected) < 0.01f && Worst(Pictures.Color(camera), expected) < 0.01f, "both cameras see it once");
                    Assert.IsTrue(Hidden.All(one => one.gameObject.hideFlags == HideFlags.HideAndDontSave));
                    // One more camera: what was for one that is gone goes.
                    Object.DestroyImmediate(other.gameObject);
                    PlainCamera.Make(Side);
                    Settle();
                    Assert.AreEqual(2, Hidden.Count);
                }
                finally
                {
                    HighDefinition.PassOfCameras.Unhook();
                    CustomPassVolume.RegisterGlobalCustomPass(CustomPassInjectionPoint.BeforeTransparent, HighDefinition.HighDefinitionHost.Pass);
                }
                Assert.AreEqual(0, Hidden.Count);
            }
        }

        [TestCase(GraphicsFormat.R16_UNorm)]
        [TestCase(GraphicsFormat.R8_UNorm)]
        public void WhatNoRenderTextureHoldsIsKeptInHalfFloats(GraphicsFormat missing)
        {
            MakeTranslucent();
            // Of 8 bits, where that is what is missing.
            if (missing == GraphicsFormat.R8_UNorm)
            {
                var values = new byte[16 * 16 * 16];
                for (var i = 0; i < values.Length; i++) values[i] = (byte)(i % 16 * 16);
                Object.DestroyImmediate(scan);
                // Columns, and where the first voxel lies.
                var patientFromVoxel = new double[] { 12, 0, 0, 0, 12, 0, 0, 0, 12, -90, -90, -90 };
                scan = LumivoxVolumeAsset.Create<byte>(new Vector3Int(16, 16, 16), values, 1, 0, patientFromVoxel);
                volume.volume = scan;
                look.SetPoints(new[] { new LumivoxTransferFunction.OpacityKnot(0f, 0f), new LumivoxTransferFunction.OpacityKnot(240f, 1f) }, new[] { new LumivoxTransferFunction.ColorStop(0f, Color.white) });
            }
            var expected = Settled();
            LumivoxRuntime.Stop();
            Faults.missingRender.Add(missing);
            var picture = Settled();
            Assert.AreEqual("", LumivoxRenderer.LastError);
            Assert.IsTrue(At(picture, 0.5f, 0.5f).r > 0.02f, "it is not seen");
            // Values that are rounded otherwise let a few paths end elsewhere.
            float Mean(Picture of) => Enumerable.Range(0, Side * Side).Average(i => Light(of.At(i % Side, i / Side)));
            Assert.AreEqual(Mean(expected), Mean(picture), 0.01f * Mean(expected), $"off by {Worst(picture, expected)} at most");
        }

        [Test]
        public void ADeviceWithoutHalfFloatsIsTold()
        {
            Faults.missingRender.Add(GraphicsFormat.R16_SFloat);
            Log.Expect(LogType.Error, "R16_SFloat");
            Engine.Frames(3);
            StringAssert.Contains("half floats (R16_SFloat)", LumivoxRenderer.LastError);
        }
    }
}
