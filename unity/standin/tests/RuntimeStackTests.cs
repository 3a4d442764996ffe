// URP's stacks: a base camera, and others that are drawn over it into the same target.
using System.Linq;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.Universal;

namespace Lumivox.Tests
{
    public sealed class RuntimeStackTests : CubeScene
    {
        /// Of what the overlay sees and the base does not.
        const int OverlayLayer = 5;

        protected override float Scale => 6f;

        static readonly Color sign = new Color(1f, 0f, 0f);

        /// A camera over the base, which sees a layer of its own; where it is the volume's, it does not see what the base sees.
        Camera Overlay(int layer = OverlayLayer)
        {
            var overlay = PlainCamera.Make(Side);
            overlay.cullingMask = 1 << layer;
            camera.cullingMask &= ~(1 << layer);
            overlay.GetUniversalAdditionalCameraData().renderType = CameraRenderType.Overlay;
            camera.GetUniversalAdditionalCameraData().cameraStack.Add(overlay);
            return overlay;
        }

        static float Worst(Picture a, Picture b) =>
            Enumerable.Range(0, Side * Side).Max(i => Mathf.Abs(Light(a.At(i % Side, i / Side)) - Light(b.At(i % Side, i / Side))));

        /// What is drawn twice shows less of the green plane behind it.
        void MakeTranslucent()
        {
            volume.density = 0.02f;
            Props.Plane(new Vector3(0f, 0f, 0.4f), Vector3.back, new Color(0f, 1f, 0f));
        }

        static bool IsLacking(string kind)
        {
#if UNITY_6000_0_OR_NEWER
            return false;
#else
            return kind != "compatibility";
#endif
        }

        [TestCase("graph")]
        [TestCase("feature")]
        [TestCase("compatibility")]
        public void ABasesVolumeIsDrawnOnceAndUnderItsOverlays(string kind)
        {
            if (IsLacking(kind)) return;
            MakeTranslucent();
            Settle();
            var alone = Pictures.Color(camera);
            Assert.IsTrue(At(alone, 0.5f, 0.5f).r > 0.1f, "the volume is not seen");
            using (var pipeline = new Pipeline(kind))
            {
                if (kind == "feature") pipeline.Add<Universal.LumivoxFeature>();
                var overlay = Overlay();
                Settle();
                var empty = Pictures.Color(camera);
                Assert.IsTrue(Worst(empty, alone) < 0.01f, $"under an overlay that sees nothing: off by {Worst(empty, alone)}");
                // Behind the volume, were it the base's.
                Props.Sphere(new Vector3(0f, 0f, 0.1f), 0.02f, sign, OverlayLayer);
                Settle();
                var over = Pictures.Color(camera);
                Assert.AreEqual(sign, At(over, 0.5f, 0.5f));
                Assert.IsTrue(At(alone, 0.35f, 0.5f).r > 0.1f, "the volume is beside it");
                Assert.AreEqual(Light(At(alone, 0.35f, 0.5f)), Light(At(over, 0.35f, 0.5f)), 0.01f, "beside what the overlay shows");
                // One that is switched off shows nothing, nor does one in no stack.
                overlay.enabled = false;
                Settle();
                Assert.IsTrue(Worst(Pictures.Color(camera), alone) < 0.01f, "with the overlay switched off");
                overlay.enabled = true;
                camera.GetUniversalAdditionalCameraData().cameraStack.Clear();
                Settle();
                Assert.IsTrue(Worst(Pictures.Color(camera), alone) < 0.01f, "with the overlay in no stack");
            }
        }

        [TestCase("graph")]
        [TestCase("compatibility")]
        public void AnOverlaysVolumeIsDrawnOverWhatTheBaseShows(string kind)
        {
            if (IsLacking(kind)) return;
            MakeTranslucent();
            Settle();
            var alone = Pictures.Color(camera);
            using (new Pipeline(kind))
            {
                volume.gameObject.layer = OverlayLayer;
                var overlay = Overlay();
                // Before the volume, for the base: overlays clear the depth.
                Props.Clear();
                Props.Plane(new Vector3(0f, 0f, -0.2f), Vector3.back, new Color(0f, 1f, 0f));
                Engine.FramesUntil(() => LumivoxRenderer.IsConverged(overlay), 200, "the overlay's volume is at rest");
                Assert.IsTrue(Worst(Pictures.Color(camera), alone) < 0.01f, $"off by {Worst(Pictures.Color(camera), alone)}");
            }
        }

        [TestCase("graph")]
        [TestCase("compatibility")]
        public void PostProcessingOfTheLastCameraComesAfterAllVolumes(string kind)
        {
            if (IsLacking(kind)) return;
            MakeTranslucent();
            Settle();
            var alone = Pictures.Color(camera);
            using (new Pipeline(kind))
            {
                StandInUniversal.post = color => new Color(color.r / 2f, color.g / 2f, color.b / 2f, color.a);
                Overlay().GetUniversalAdditionalCameraData().renderPostProcessing = true;
                Settle();
                var post = Pictures.Color(camera);
                StandInUniversal.post = null;
                foreach (var (u, v) in new[] { (0.5f, 0.5f), (0.3f, 0.4f), (0.05f, 0.05f) })
                    Assert.AreEqual(Light(At(alone, u, v)) / 2f, Light(At(post, u, v)), 0.01f, $"at {u}, {v}");
            }
        }

        [TestCase("graph")]
        [TestCase("compatibility")]
        public void OtherRenderScalesShowTheSameWithFewerPixels(string kind)
        {
            if (IsLacking(kind)) return;
            MakeTranslucent();
            camera.GetComponent<LumivoxEffect>().targetSamples = 256;
            Settle();
            var alone = Pictures.Color(camera);
            using (var pipeline = new Pipeline(kind))
            {
                pipeline.RenderScale = 0.5f;
                Settle();
                var half = Pictures.Color(camera);
                Assert.AreEqual(half.At(0, 0), half.At(1, 1), "two pixels are one");
                float Mean(Picture of) => of.pixels.Average(Light);
                Assert.AreEqual(Mean(alone), Mean(half), 0.06f * Mean(alone));
                // Noise aside, also where the volume is.
                float Middle(Picture of) => Enumerable.Range(0, 64).Average(i => Light(of.At(Side / 2 - 4 + i % 8, Side / 2 - 4 + i / 8)));
                Assert.AreEqual(Middle(alone), Middle(half), 0.05f * Middle(alone));
            }
        }

#if !UNITY_6000_3_OR_NEWER
        [TestCase(false)]
        [TestCase(true)]
        public void TransparentsOfAStackAreSeenWhileAScanLoads(bool isOverlays)
        {
            var paint = new PaintPass(Color.blue);
            var another = LumivoxVolumeAsset.Phantom("cube", 48);
            using (new Pipeline("compatibility"))
            {
                var overlay = Overlay();
                var painted = isOverlays ? overlay : camera;
                // The overlay sees the volumes, too.
                overlay.cullingMask |= 1;
                void Enqueue(ScriptableRenderContext context, Camera drawn)
                {
                    if (drawn == painted) drawn.GetUniversalAdditionalCameraData().scriptableRenderer.EnqueuePass(paint);
                }
                RenderPipelineManager.beginCameraRendering += Enqueue;
                try
                {
                    Settle();
                    var second = new GameObject("Second").AddComponent<LumivoxVolume>();
                    second.volume = another;
                    Object.DestroyImmediate(volume.gameObject);
                    Assert.AreNotEqual(LumivoxVolumeState.Ready, another.state);
                    for (var i = 0; i < 3; i++)
                    {
                        Engine.Frame();
                        Assert.AreEqual(Color.blue, At(Pictures.Color(camera), 0.05f, 0.05f), $"in frame {i}, the scan is {another.state}");
                    }
                    RuntimeComponentTests.Wait(() => another.state == LumivoxVolumeState.Ready);
                }
                finally
                {
                    RenderPipelineManager.beginCameraRendering -= Enqueue;
                    Object.DestroyImmediate(another);
                }
            }
        }
#endif
    }
}
