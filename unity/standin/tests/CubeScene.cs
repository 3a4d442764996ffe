// A white, dense cube before a camera, without noise that matters: what tests of whole frames begin with.
using NUnit.Framework;
using StandIn;
using UnityEngine;
using UnityEngine.Rendering.Universal;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public abstract class CubeScene
    {
        protected const int Side = 32;

        protected Camera camera;
        protected LumivoxVolume volume;
        protected LumivoxVolumeAsset scan;
        protected LumivoxTransferFunction look;

        /// How much of the picture it fills.
        protected virtual float Scale => 1f;

        [SetUp]
        public void Begin()
        {
            Engine.Clear();
            camera = PlainCamera.Make(Side);
            scan = LumivoxVolumeAsset.Phantom("cube", 16);
            look = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
            look.SetPoints(new[] { new LumivoxTransferFunction.OpacityKnot(-10000f, 1f) }, new[] { new LumivoxTransferFunction.ColorStop(0f, Color.white) });
            volume = new GameObject("Cube").AddComponent<LumivoxVolume>();
            volume.transform.localScale = Vector3.one * Scale;
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

        protected void Settle()
        {
            if (Waiting.Frames(() => LumivoxRenderer.IsConverged(camera))) return;
            var status = LumivoxRenderer.GetStatus(camera);
            Assert.Fail($"{status.samples} of {status.target} samples, shown: {status.isShown}, error: '{LumivoxRenderer.LastError}'");
        }

        protected static Color At(Picture picture, float u, float v) => picture.At((int)(u * picture.width), (int)(v * picture.height));

        protected static float Light(Color color) => (color.r + color.g + color.b) / 3f;
    }
}
