// What parts of volumes are and what is left of them, beside the wgpu host's pictures of the same.
using System.Linq;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed class TwinPartsTests : TwinScene
    {
        LumivoxVolume Head(string preset)
        {
            var volume = Add("head", 40, preset, Vector3.zero, Quaternion.Euler(5f, 25f, 0f));
            volume.transform.localScale = Vector3.one * 0.8f;
            // What is asked of kernels is the same, and they are slow in software.
            volume.maxBounces = 4;
            return volume;
        }

        /// What a camera shows now, to be told from what it shows then.
        Color[] Shown()
        {
            Settle();
            return Pictures.Color(camera).pixels;
        }

        static float Difference(Color[] a, Color[] b) => Enumerable.Range(0, a.Length).Sum(i => Mathf.Abs(a[i].r - b[i].r) + Mathf.Abs(a[i].g - b[i].g) + Mathf.Abs(a[i].b - b[i].b));

        static LumivoxClip Clip(LumivoxVolume of, LumivoxClip.Shape shape, bool inverted, Vector3 position, Quaternion rotation, Vector3 scale)
        {
            var clip = new GameObject(shape.ToString()).AddComponent<LumivoxClip>();
            clip.transform.SetParent(of.transform, false);
            clip.transform.SetLocalPositionAndRotation(position, rotation);
            clip.transform.localScale = scale;
            (clip.shape, clip.inverted) = (shape, inverted);
            return clip;
        }

        LumivoxLabels Found(LumivoxVolume volume)
        {
            var finding = LumivoxLabels.FoundIn(volume.volume);
            RuntimeComponentTests.Wait(() => finding.IsCompleted);
            made.Add(finding.Result.map);
            made.Add(finding.Result);
            return finding.Result;
        }

        [Test]
        public void AHeadThatIsCutOpenIsWhatTheWgpuHostShows()
        {
            var volume = Head("ct-skin");
            var whole = Shown();
            Clip(volume, LumivoxClip.Shape.Plane, false, new Vector3(0.02f, 0f, 0f), Quaternion.Euler(0f, 0f, 80f), Vector3.one);
            Clip(volume, LumivoxClip.Shape.Box, true, new Vector3(-0.05f, 0.06f, -0.08f), Quaternion.Euler(10f, 30f, 0f), new Vector3(0.09f, 0.08f, 0.07f));
            Clip(volume, LumivoxClip.Shape.Sphere, false, Vector3.zero, Quaternion.Euler(0f, 0f, 20f), new Vector3(0.22f, 0.26f, 0.24f));
            Assert.IsTrue(Difference(whole, Compare("cut")) > 5f, "it is cut");
        }

        [Test]
        public void AHeadOfLabelsIsWhatTheWgpuHostShows()
        {
            var volume = Head("ct-skin");
            var plain = Shown();
            var labels = Found(volume);
            Assert.IsTrue(labels.TryGetLook("body", out var body), string.Join(", ", labels.GetNames()));
            (body.painted, body.color, body.opacity, body.density) = (true, new Color(0.2f, 0.5f, 0.9f), 0.4f, 6f);
            (body.ownSurface, body.surfaceStrength, body.surfaceRoughness) = (true, 0.7f, 0.1f);
            labels.SetLook(body);
            volume.labels = labels;
            Clip(volume, LumivoxClip.Shape.Plane, false, Vector3.zero, Quaternion.Euler(0f, 0f, -60f), Vector3.one);
            Assert.IsTrue(Difference(plain, Compare("labels")) > 5f, "labels are seen");
        }

        [Test]
        public void AHeadThatIsPeeledIsWhatTheWgpuHostShows()
        {
            var volume = Head("ct-skin");
            var whole = Shown();
            volume.peelMm = 9f;
            Engine.Frame();
            RuntimeComponentTests.Wait(() => volume.volume.NeedSkin());
            Assert.IsTrue(Difference(whole, Compare("peeled")) > 5f, "it is peeled");
        }

        // What it is read, shown and saved as, RuntimePartsTests.RowsForGradientsAreReadShownAndSaved has.
        [Test, Category("Slow")]
        public void AFunctionOfValueAndGradientIsWhatTheWgpuHostShows()
        {
            var volume = Head("ct-muscle");
            var plain = Shown();
            var function = volume.transferFunction;
            function.SetGradients(new[]
            {
                new LumivoxTransferFunction.GradientRow(60f, new[] { new LumivoxTransferFunction.OpacityKnot(-300f, 0f), new LumivoxTransferFunction.OpacityKnot(100f, 0.8f) }, new[] { new LumivoxTransferFunction.ColorStop(0f, new Color(0.9f, 0.6f, 0.1f)) }),
                new LumivoxTransferFunction.GradientRow(200f, new[] { new LumivoxTransferFunction.OpacityKnot(0f, 1f) }, new[] { new LumivoxTransferFunction.ColorStop(0f, new Color(0.1f, 0.8f, 0.4f)) }),
            });
            Assert.IsTrue(Difference(plain, Compare("borders")) > 5f, "rows are followed");
        }
    }
}
