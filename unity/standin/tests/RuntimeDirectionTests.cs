// Which way round things are, seen in pictures: skies, and patients.
using System;
using System.Collections.Generic;
using System.Linq;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using UnityEngine.Rendering;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed class RuntimeDirectionTests
    {
        const int Side = 48;

        readonly List<Object> made = new List<Object>();
        Camera camera;
        LumivoxVolume volume;

        [SetUp]
        public void Begin()
        {
            camera = PlainCamera.Make(Side);
        }

        [TearDown]
        public void End()
        {
            LumivoxRuntime.Stop();
            foreach (var thing in made) Object.DestroyImmediate(thing);
            made.Clear();
            Engine.Clear();
        }

        /// Nothing below a value, all above it.
        void Show(LumivoxVolumeAsset scan, float from)
        {
            made.Add(scan);
            var look = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
            made.Add(look);
            look.SetPoints(
                new[] { new LumivoxTransferFunction.OpacityKnot(from - 100f, 0f), new LumivoxTransferFunction.OpacityKnot(from, 1f) },
                new[] { new LumivoxTransferFunction.ColorStop(0f, Color.white) });
            volume = new GameObject("Scan").AddComponent<LumivoxVolume>();
            volume.volume = scan;
            volume.transferFunction = look;
            volume.density = 100f;
            volume.maxBounces = 2;
            volume.surfaceStrength = 0f;
            RuntimeComponentTests.Wait(() => scan.state == LumivoxVolumeState.Ready);
        }

        void Settle()
        {
            Assert.IsTrue(Waiting.Frames(() => LumivoxRenderer.IsConverged(camera)), $"it is not done; error: '{LumivoxRenderer.LastError}'");
        }

        static float Light(Color color) => (color.r + color.g + color.b) / 3f;

        static float Sum(Picture picture, Func<int, int, bool> isIn) =>
            Enumerable.Range(0, Side).Sum(row => Enumerable.Range(0, Side).Sum(column => isIn(column, row) ? Light(picture.At(column, row)) : 0f));

        /// Metres from the camera's plane to what is seen through a pixel.
        static float Distance(Camera camera, Picture depth, int column, int row)
        {
            float near = camera.nearClipPlane, far = camera.farClipPlane;
            return near * far / (near + depth.At(column, row).r * (far - near));
        }

        [TestCase(1f, 0f, 0f)]
        [TestCase(-1f, 0f, 0f)]
        [TestCase(0f, 1f, 0f)]
        [TestCase(0f, -1f, 0f)]
        [TestCase(0f, 0f, 1f)]
        [TestCase(0f, 0f, -1f)]
        public void ASkyLightsItFromTheSideWhereItIsBright(float x, float y, float z)
        {
            var bright = new Vector3(x, y, z);
            Show(LumivoxVolumeAsset.Phantom("cube", 16), -10000f);
            Props.sky = direction => Vector3.Dot(direction, bright) > 0.6f ? Color.white : Color.black;
            var sky = new Material(Resources.Load<Shader>("Lumivox/LumivoxDepth"));
            RenderSettings.ambientMode = AmbientMode.Skybox;
            RenderSettings.skybox = sky;
            camera.GetComponent<LumivoxEffect>().environmentSource = LumivoxEnvironmentSource.Scene;
            // Two of its sides are seen, left and right, or above and below.
            if (x != 0f) volume.transform.rotation = Quaternion.Euler(0f, 45f, 0f);
            if (y != 0f) volume.transform.rotation = Quaternion.Euler(45f, 0f, 0f);
            Settle();
            var picture = Pictures.Color(camera);
            float right = Sum(picture, (column, _) => column >= Side / 2), left = Sum(picture, (column, _) => column < Side / 2);
            float above = Sum(picture, (_, row) => row >= Side / 2), below = Sum(picture, (_, row) => row < Side / 2);
            var said = $"right {right}, left {left}, above {above}, below {below}";
            if (x != 0f) Assert.IsTrue(x * (right - left) > 0.8f * (right + left) && right + left > 0.1f, said);
            if (y != 0f) Assert.IsTrue(y * (above - below) > 0.8f * (above + below) && above + below > 0.1f, said);
            // Seen from -z: what is behind it does not light the side that is seen.
            if (z < 0f) Assert.IsTrue(right + left > 0.1f, said);
            if (z > 0f) Assert.IsTrue(right + left < 0.01f, said);
            // Another look of the same material, and it is lit from the other side.
            Props.sky = direction => Vector3.Dot(direction, bright) < -0.6f ? Color.white : Color.black;
            sky.SetFloat("_Exposure", 2f);
            for (var i = 0; i < 20; i++)
            {
                Engine.Frame();
                Ticker.Tick();
            }
            Settle();
            picture = Pictures.Color(camera);
            float rightAfter = Sum(picture, (column, _) => column >= Side / 2), leftAfter = Sum(picture, (column, _) => column < Side / 2);
            float aboveAfter = Sum(picture, (_, row) => row >= Side / 2), belowAfter = Sum(picture, (_, row) => row < Side / 2);
            Assert.IsTrue(x * (rightAfter - leftAfter) < 0f || y * (aboveAfter - belowAfter) < 0f || z != 0f && z * (rightAfter + leftAfter - right - left) > 0f, "the sky before is still there");
            RenderSettings.skybox = null;
            Object.DestroyImmediate(sky);
        }

        /// DICOM's x runs to the patient's left, y to the back, z to the head.
        [TestCase(0, true, "right")]
        [TestCase(0, false, "left")]
        [TestCase(2, true, "above")]
        [TestCase(2, false, "below")]
        [TestCase(1, false, "near")]
        [TestCase(1, true, "far")]
        public void APatientStandsUprightAndFacesACameraThatWasNotTurned(int axis, bool isHigh, string where)
        {
            const int n = 16;
            var voxels = new ushort[n * n * n];
            for (var i = 0; i < voxels.Length; i++)
            {
                var at = new[] { i % n, i / n % n, i / n / n }[axis];
                voxels[i] = (ushort)(at >= n / 2 == isHigh ? 1000 : 0);
            }
            Show(LumivoxVolumeAsset.Create<ushort>(new Vector3Int(n, n, n), voxels, 1, 0, new double[] { 6, 0, 0, 0, 6, 0, 0, 0, 6, 0, 0, 0 }, "CT"), 500f);
            Settle();
            var picture = Pictures.Color(camera);
            float right = Sum(picture, (column, _) => column >= Side / 2), left = Sum(picture, (column, _) => column < Side / 2);
            float above = Sum(picture, (_, row) => row >= Side / 2), below = Sum(picture, (_, row) => row < Side / 2);
            var distance = Distance(camera, Pictures.Depth(camera), Side / 2 + (where == "right" ? 6 : -6), Side / 2 + (where == "above" ? 6 : -6));
            var said = $"right {right}, left {left}, above {above}, below {below}, at {distance} m";
            Assert.IsTrue(right + left > 1f, said);
            if (where == "right") Assert.IsTrue(right > 5f * left, said);
            if (where == "left") Assert.IsTrue(left > 5f * right, said);
            if (where == "above") Assert.IsTrue(above > 5f * below, said);
            if (where == "below") Assert.IsTrue(below > 5f * above, said);
            // Half of 96 mm nearer than the middle, or where the middle is.
            if (where == "near") Assert.AreEqual(0.3f - 0.048f, distance, 0.006f, said);
            if (where == "far") Assert.AreEqual(0.3f, distance, 0.006f, said);
        }

        [Test]
        public void AHeadShowsItsFaceAndHasItsNeckBelow()
        {
            Show(LumivoxVolumeAsset.Phantom("head", 72), -300f);
            camera.transform.position = new Vector3(0f, 0f, -0.6f);
            Settle();
            var front = Pictures.Depth(camera);
            camera.transform.position = new Vector3(0f, 0f, 0.6f);
            camera.transform.rotation = Quaternion.Euler(0f, 180f, 0f);
            Settle();
            var back = Pictures.Depth(camera);
            // Nothing of the back of a head stands out as a nose does, by millimetres over what is four pixels beside it.
            float Relief(Picture depth) => Enumerable.Range(20, 14).Max(row => 1000f * (
                Mathf.Min(Distance(camera, depth, Side / 2 - 4, row), Distance(camera, depth, Side / 2 + 4, row)) - Distance(camera, depth, Side / 2, row)));
            Assert.IsTrue(Relief(front) > 20f && Relief(back) < 15f, $"{Relief(front)} mm before, {Relief(back)} mm behind");
            // The lower, the head, the neck, the shoulders.
            var widths = Enumerable.Range(0, Side).Select(row => Enumerable.Range(0, Side).Count(column => Distance(camera, front, column, row) < 1f)).ToArray();
            int head = widths.Skip(Side / 2).Max(), shoulders = widths.Take(Side / 2).Max();
            var neck = widths.Skip(Array.IndexOf(widths, shoulders)).Take(Side / 2 - Array.IndexOf(widths, shoulders)).Min();
            Assert.IsTrue(neck < 0.75f * head && head < 0.75f * shoulders, $"pixels across: head {head}, neck {neck}, shoulders {shoulders}");
        }
    }
}
