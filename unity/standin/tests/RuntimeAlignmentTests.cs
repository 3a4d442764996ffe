// A scan in another's place in the patient: a PET in its CT.
using System.Collections.Generic;
using System.Linq;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed class RuntimeAlignmentTests
    {
        readonly List<Object> made = new List<Object>();

        [TearDown]
        public void End()
        {
            LumivoxRuntime.Stop();
            foreach (var one in made) Object.DestroyImmediate(one);
            made.Clear();
            Engine.Clear();
        }

        T Kept<T>(T one) where T : Object
        {
            made.Add(one);
            return one;
        }

        /// `n` voxels of `mm` along a side, whose first one's centre lies at `origin` in the patient; dense within 25 mm of the point `dense`.
        LumivoxVolume Add(string name, int n, float mm, Vector3 origin, Vector3 dense, string modality)
        {
            var voxels = new short[n * n * n];
            for (var i = 0; i < voxels.Length; i++)
            {
                var place = origin + mm * new Vector3(i % n, i / n % n, i / n / n);
                voxels[i] = (short)((place - dense).magnitude < 25f ? 1000 : 0);
            }
            var matrix = new double[] { mm, 0, 0, 0, mm, 0, 0, 0, mm, origin.x, origin.y, origin.z };
            var volume = new GameObject(name).AddComponent<LumivoxVolume>();
            volume.volume = Kept(LumivoxVolumeAsset.Create<short>(Vector3Int.one * n, voxels, 1, 0, matrix, modality));
            return volume;
        }

        static readonly Vector3 Place = new Vector3(40f, -90f, 260f);

        LumivoxVolume Ct() => Add("CT", 24, 8f, new Vector3(-60f, -180f, 150f), Place, "CT");

        LumivoxVolume Pet() => Add("PET", 30, 7f, new Vector3(-120f, -200f, 120f), Place, "PT");

        /// Where a point of the patient is in the world.
        static Vector3 At(LumivoxVolume volume, Vector3 patient) => volume.transform.TransformPoint(volume.patientTransform.MultiplyPoint3x4(patient));

        static void AreOver(LumivoxVolume a, LumivoxVolume b, float within = 1e-5f)
        {
            foreach (var point in new[] { Place, Vector3.zero, new Vector3(100f, 0f, 0f), new Vector3(0f, 100f, 0f), new Vector3(0f, 0f, 100f) })
                Assert.IsTrue((At(a, point) - At(b, point)).magnitude < within, $"{point}: {At(a, point)} and {At(b, point)}");
        }

        [Test]
        public void TheSidesOfThePatientAreThoseOfTheObject()
        {
            var ct = Ct();
            var map = ct.patientTransform;
            Assert.IsTrue((map.MultiplyVector(new Vector3(1000f, 0f, 0f)) - Vector3.right).magnitude < 1e-6f, "left: a camera that was not turned sees it on its right");
            Assert.IsTrue((map.MultiplyVector(new Vector3(0f, 1000f, 0f)) - Vector3.forward).magnitude < 1e-6f, "back: away from that camera");
            Assert.IsTrue((map.MultiplyVector(new Vector3(0f, 0f, 1000f)) - Vector3.up).magnitude < 1e-6f, "head");
            Assert.IsTrue(map.MultiplyPoint3x4(new Vector3(32f, -88f, 242f)).magnitude < 1e-6f, "its centre is the object's origin");
            Assert.AreEqual(ct.patientTransform, ct.volume.objectFromPatient);
            Assert.AreEqual(Matrix4x4.identity, new GameObject("Empty").AddComponent<LumivoxVolume>().patientTransform);
        }

        [Test]
        public void ScansLieOverEachOtherAsInThePatient()
        {
            var (ct, pet) = (Ct(), Pet());
            Assert.IsTrue((At(ct, Place) - At(pet, Place)).magnitude > 0.01f, "their centres are not one place of the patient");
            Assert.IsTrue(pet.AlignWith(ct));
            AreOver(pet, ct);
            ct.transform.SetPositionAndRotation(new Vector3(1f, -2f, 3f), Quaternion.Euler(20f, 130f, -40f));
            ct.transform.localScale = new Vector3(2f, 2f, 2f);
            Assert.IsTrue(pet.AlignWith(ct));
            AreOver(pet, ct);
            // Again is no other place, and the other way round neither.
            var place = pet.transform.position;
            Assert.IsTrue(pet.AlignWith(ct) && ct.AlignWith(pet));
            Assert.IsTrue((pet.transform.position - place).magnitude < 1e-6f);
            AreOver(pet, ct);
        }

        [Test]
        public void ParentsDoNotMatter()
        {
            var (ct, pet) = (Ct(), Pet());
            var (a, b) = (new GameObject("A").transform, new GameObject("B").transform);
            (a.position, a.rotation, a.localScale) = (new Vector3(0f, 1f, 0f), Quaternion.Euler(0f, 70f, 0f), Vector3.one * 3f);
            (b.position, b.rotation, b.localScale) = (new Vector3(-1f, 0f, 2f), Quaternion.Euler(30f, 0f, 10f), Vector3.one * 0.5f);
            ct.transform.SetParent(a, false);
            ct.transform.localPosition = new Vector3(0.2f, 0f, 0f);
            pet.transform.SetParent(b, false);
            Assert.IsTrue(pet.AlignWith(ct));
            AreOver(pet, ct, 1e-4f);
            // Siblings, whose parent is scaled unevenly.
            a.localScale = new Vector3(1f, 2f, 3f);
            pet.transform.SetParent(a, false);
            ct.transform.localRotation = Quaternion.Euler(0f, 0f, 30f);
            Assert.IsTrue(pet.AlignWith(ct));
            AreOver(pet, ct);
        }

        [Test]
        public void WhatHasNoPlaceIsNotAlignedAndStaysWhereItIs()
        {
            var (ct, empty) = (Ct(), new GameObject("Empty").AddComponent<LumivoxVolume>());
            ct.transform.position = Vector3.up;
            Assert.IsFalse(ct.AlignWith(null) || ct.AlignWith(ct) || ct.AlignWith(empty) || empty.AlignWith(ct));
            var coming = Kept(LumivoxVolumeAsset.Phantom("cube", 16));
            empty.enabled = false;
            empty.volume = coming;
            Assert.IsFalse(empty.AlignWith(ct), "nobody knows where it lies before it was computed");
            Assert.AreEqual((Vector3.up, Vector3.zero), (ct.transform.position, empty.transform.position));
            empty.enabled = true;
            RuntimeComponentTests.Wait(() => coming.state == LumivoxVolumeState.Ready);
            Assert.IsTrue(empty.AlignWith(ct));
            AreOver(empty, ct);
        }

        [Test]
        public void TheyAreSeenOverEachOther()
        {
            var camera = PlainCamera.Make(48);
            camera.transform.position = new Vector3(0f, 0f, -0.5f);
            var look = Kept(ScriptableObject.CreateInstance<LumivoxTransferFunction>());
            look.SetPoints(new[] { new LumivoxTransferFunction.OpacityKnot(400f, 0f), new LumivoxTransferFunction.OpacityKnot(500f, 1f) }, new[] { new LumivoxTransferFunction.ColorStop(0f, Color.white) });
            var (ct, pet) = (Ct(), Pet());
            foreach (var volume in new[] { ct, pet }) (volume.transferFunction, volume.density, volume.maxBounces) = (look, 50f, 2);
            ct.transform.SetPositionAndRotation(new Vector3(0.03f, 0.02f, 0f), Quaternion.Euler(0f, 25f, 0f));
            pet.AlignWith(ct);
            LumivoxRenderer.RenderAtOnce = true;
            try
            {
                // The middle of what one of them shows, in pixels.
                Vector2 Middle(LumivoxVolume of)
                {
                    (ct.enabled, pet.enabled) = (of == ct, of == pet);
                    for (var i = 0; i < 5 || !LumivoxRenderer.IsConverged(camera); i++)
                    {
                        Engine.Frame();
                        Ticker.Tick();
                        Assert.IsTrue(i < 200, LumivoxRenderer.LastError);
                    }
                    var picture = Pictures.Color(camera);
                    var lit = Enumerable.Range(0, 48 * 48).Where(i => picture.At(i % 48, i / 48).r > 0.02f).ToArray();
                    Assert.IsTrue(lit.Length > 20, $"{of.name}: {lit.Length} pixels");
                    return new Vector2((float)lit.Average(i => i % 48), (float)lit.Average(i => i / 48));
                }
                var (a, b) = (Middle(ct), Middle(pet));
                Assert.IsTrue((a - b).magnitude < 1f, $"{a} and {b}");
                var seen = camera.WorldToViewportPoint(At(ct, Place)) * 48f;
                Assert.IsTrue((a - new Vector2(seen.x, seen.y)).magnitude < 2f, $"{a}, and the place of it {seen}");
            }
            finally
            {
                LumivoxRenderer.RenderAtOnce = false;
            }
        }
    }
}
