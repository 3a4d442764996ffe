// The pictures of what pipelines do around a volume, in URP: both eyes of a headset, an asset that is changed, a stack of cameras.
using NUnit.Framework;
using StandIn;
using UnityEngine;
using UnityEngine.Rendering.Universal;
using Object = UnityEngine.Object;
using Picture = StandIn.Picture;

namespace Lumivox.Tests
{
    public sealed partial class DocumentationPictures
    {
        /// Of each of several pictures in a row.
        const int PartSide = 240;

        /// A head that hides half of what is behind it: where it is drawn twice, it hides more.
        LumivoxVolume Veil()
        {
            var volume = Head("ct-skin");
            volume.density = 0.4f;
            Shape(PrimitiveType.Cube, new Vector3(0.09f, -0.07f, -0.12f), 0.06f, new Color(0.8f, 0.45f, 0.2f)).transform.rotation = Quaternion.Euler(20f, 35f, 0f);
            return volume;
        }

        /// Pictures of one height beside each other.
        static Picture Row(params Picture[] parts)
        {
            int width = 0, height = parts[0].height;
            foreach (var part in parts) width += part.width;
            var row = new Picture(width, height);
            var left = 0;
            foreach (var part in parts)
            {
                for (var y = 0; y < height; y++)
                    for (var x = 0; x < part.width; x++) row.pixels[y * width + left + x] = part.At(x, y);
                left += part.width;
            }
            return row;
        }

        /// URP in one pass for both eyes, with its feature, after the pipeline was made anew.
        [Test]
        public void HeadsetEyes()
        {
            using (var pipeline = new Pipeline("feature"))
            {
                pipeline.Add<Universal.LumivoxFeature>();
                Headset.mode = UnityEngine.XR.XRSettings.StereoRenderingMode.SinglePassInstanced;
                (Headset.isOn, Headset.width, Headset.height, Headset.separation) = (true, Height, Height, 0.064f);
                Veil();
                Shoot();
                pipeline.Reload();
                Shoot();
                var both = Row(Pictures.Color(camera, Camera.StereoscopicEye.Left), Pictures.Color(camera, Camera.StereoscopicEye.Right));
                Headset.isOn = false;
                Save("headset-eyes", both);
            }
        }

        /// Before any change, after one that makes the renderers anew, and with the feature switched off.
        [Test]
        public void ChangedAsset()
        {
            Engine.SetScreen(PartSide, PartSide);
            using (var pipeline = new Pipeline("feature"))
            {
                var feature = pipeline.Add<Universal.LumivoxFeature>();
                Veil();
                var before = Shoot();
                pipeline.Reload();
                var after = Shoot();
                feature.SetActive(false);
                Save("changed-asset", Row(before, after, Shoot()));
            }
        }

        /// A base that sees the head, and an overlay that sees a sign: while the scan loads, with what is there first, at rest.
        [Test]
        public void CameraStack()
        {
            const int signs = 5;
            Engine.SetScreen(PartSide, PartSide);
            using (new Pipeline("compatibility"))
            {
                Shape(PrimitiveType.Cube, new Vector3(0.09f, -0.07f, -0.12f), 0.06f, new Color(0.8f, 0.45f, 0.2f)).transform.rotation = Quaternion.Euler(20f, 35f, 0f);
                // Behind the head, were it the base's.
                Shape(PrimitiveType.Sphere, new Vector3(-0.12f, 0.12f, 0.2f), 0.06f, new Color(0.2f, 0.75f, 0.35f)).layer = signs;
                var overlay = Object.Instantiate(camera.gameObject).GetComponent<Camera>();
                overlay.cullingMask = 1 << signs;
                camera.cullingMask = ~overlay.cullingMask;
                overlay.GetUniversalAdditionalCameraData().renderType = CameraRenderType.Overlay;
                camera.GetUniversalAdditionalCameraData().cameraStack.Add(overlay);
                var volume = new GameObject("Head Phantom").AddComponent<LumivoxVolume>();
                volume.volume = Keep(LumivoxVolumeAsset.Phantom("head", 160));
                volume.ApplyPreset("ct-skin");
                Engine.Frame();
                Assert.AreEqual(LumivoxVolumeState.Loading, volume.volume.state);
                var loading = Pictures.Color(camera);
                EditorProject.Until(() => volume.volume.state == LumivoxVolumeState.Ready, "the phantom is computed");
                Engine.FramesUntil(() => LumivoxRenderer.GetStatus(camera).samples > 0, 100, "the first samples come");
                var first = Pictures.Color(camera);
                Save("camera-stack", Row(loading, first, Shoot()));
            }
        }
    }
}
