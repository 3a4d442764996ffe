// Parts of volumes: labels, clip shapes, peeling, functions of value and gradient, as they are seen and as they are misused.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Threading.Tasks;
using Lumivox.Native;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed class RuntimePartsTests : CubeScene
    {
        readonly List<Object> made = new List<Object>();

        protected override float Scale => 8f;

        /// Pictures are traced whole, not coarse first.
        [SetUp]
        public void BeginParts() => LumivoxRenderer.RenderAtOnce = true;

        [TearDown]
        public void EndParts()
        {
            LumivoxRenderer.RenderAtOnce = false;
            foreach (var one in made) Object.DestroyImmediate(one);
            made.Clear();
        }

        T Kept<T>(T one) where T : Object
        {
            made.Add(one);
            return one;
        }

        /// The patient's left half of the cube, which is on the picture's right, has a label; what is beyond the map has none.
        LumivoxLabels Halves(double shift = 0, int n = 24)
        {
            var voxels = Enumerable.Range(0, n * n * n).Select(i => (byte)(i % n < n / 2 ? 0 : 7)).ToArray();
            var first = 0.5 - n / 2;
            var place = new[] { 1, 0, 0, 0, 1, 0, 0, 0, 1, shift + first, first, first };
            var labels = Kept(LumivoxLabels.Create(Vector3Int.one * n, voxels, place, new[] { new LumivoxLabel(7, "Left", Color.red) }));
            Kept(labels.map);
            return labels;
        }

        static void Look(LumivoxLabels labels, string name, Func<LumivoxLabels.Look, LumivoxLabels.Look> change)
        {
            Assert.IsTrue(labels.TryGetLook(name, out var look), name);
            labels.SetLook(change(look));
        }

        LumivoxClip Clip(LumivoxClip.Shape shape, Transform parent = null)
        {
            var clip = new GameObject("Clip").AddComponent<LumivoxClip>();
            clip.transform.SetParent(parent != null ? parent : volume.transform, false);
            // The scan is shown eight times as large: a shape of its size is.
            clip.transform.localScale = Vector3.one * 0.008f;
            clip.shape = shape;
            return clip;
        }

        /// The mean of nine pixels: of few samples each may be dark for itself.
        static Color Around(StandIn.Picture picture, float u, float v)
        {
            var (x, y) = ((int)(u * picture.width), (int)(v * picture.height));
            var sum = Color.clear;
            for (var i = 0; i < 9; i++) sum += picture.At(x + i % 3 - 1, y + i / 3 - 1);
            return sum / 9f;
        }

        /// What is seen left and right of the middle, above and below, and at a corner.
        (float left, float right, float up, float down, float corner) Seen()
        {
            // Where light goes is another matter.
            volume.maxBounces = 2;
            Settle();
            var picture = Pictures.Color(camera);
            return (Light(Around(picture, 0.35f, 0.5f)), Light(Around(picture, 0.65f, 0.5f)), Light(Around(picture, 0.5f, 0.65f)), Light(Around(picture, 0.5f, 0.35f)), Light(At(picture, 0.72f, 0.72f)));
        }

        const float Bright = 0.02f, Dark = 1e-3f;

        [Test]
        public void NothingHasPartsByItself()
        {
            Assert.IsNull(volume.labels);
            Assert.AreEqual(0f, volume.peelMm);
            var clip = Clip(LumivoxClip.Shape.Plane);
            Assert.IsFalse(clip.inverted);
            Assert.AreSame(volume, clip.volume);
            var labels = Halves(n: 16);
            CollectionAssert.AreEqual(new[] { "Left", "unlabelled" }, labels.GetNames());
            Assert.IsTrue(labels.TryGetLook("LEFT", out var look));
            Assert.AreEqual((true, 1f, -1f, false, true, false), (look.visible, look.opacity, look.density, look.painted, look.clipped, look.ownSurface));
            Assert.AreEqual((1f, 0f, 0.4f, 0.04f, 0f), (look.surfaceStrength, look.surfaceGradient, look.surfaceRoughness, look.surfaceSpecular, look.surfaceMetallic));
            Assert.AreEqual(2.048, labels.map.labels.Single().milliliters, 1e-9);
            (look.opacity, look.density, look.surfaceStrength, look.name) = (7f, 1e10f, float.NaN, "another");
            labels.SetLook(look);
            Assert.IsTrue(labels.TryGetLook("left", out look), "what it is called is its map's to say");
            Assert.AreEqual((1f, LumivoxVolume.MaxDensity, 1f), (look.opacity, look.density, look.surfaceStrength));
            volume.peelMm = 100f;
            Assert.AreEqual(60f, volume.peelMm);
            Log.Expect(LogType.Error, "LumivoxVolume.peelMm takes neither NaN nor infinity");
            volume.peelMm = float.NaN;
            clip.shape = (LumivoxClip.Shape)9;
            Assert.AreEqual(LumivoxClip.Shape.Sphere, clip.shape);
        }

        [Test]
        public void APlaneKeepsTheSideOfItsObjectsY()
        {
            var all = Seen();
            Assert.IsTrue(all.left > Bright && all.right > Bright && all.up > Bright && all.down > Bright && all.corner > Bright, $"{all}");
            var clip = Clip(LumivoxClip.Shape.Plane);
            var seen = Seen();
            Assert.IsTrue(seen.up > Bright && seen.down < Dark, $"{seen}");
            clip.inverted = true;
            seen = Seen();
            Assert.IsTrue(seen.down > Bright && seen.up < Dark, $"inverted: {seen}");
            clip.inverted = false;
            // Its y goes to the left.
            clip.transform.localRotation = Quaternion.Euler(0f, 0f, 90f);
            seen = Seen();
            Assert.IsTrue(seen.left > Bright && seen.right < Dark, $"turned: {seen}");
            // To the side, and upside down by its scale.
            clip.transform.localScale = new Vector3(3f, -0.1f, 1e-3f);
            seen = Seen();
            Assert.IsTrue(seen.right > Bright && seen.left < Dark, $"mirrored: {seen}");
            clip.transform.localPosition = new Vector3(-0.02f, 0f, 0f);
            seen = Seen();
            Assert.IsTrue(seen.right > Bright && seen.left > Bright, $"moved: {seen}");
        }

        [Test]
        public void ABoxAndABallKeepWhatIsWithin()
        {
            var clip = Clip(LumivoxClip.Shape.Sphere);
            clip.transform.localScale = Vector3.one * 0.016f;
            var seen = Seen();
            Assert.IsTrue(seen.left > Bright && seen.corner < Dark, $"a ball as wide as the cube leaves its corners: {seen}");
            clip.inverted = true;
            // Nearer than the middle of its faces, the cube is open.
            seen = Seen();
            Assert.IsTrue(seen.corner > Bright, $"{seen}");
            (clip.inverted, clip.shape) = (false, LumivoxClip.Shape.Box);
            seen = Seen();
            Assert.IsTrue(seen.left > Bright && seen.corner > Bright, $"a box as large as the cube takes nothing: {seen}");
            clip.transform.localScale = new Vector3(0.016f, 0.003f, 0.016f);
            seen = Seen();
            Assert.IsTrue(seen.left > Bright && seen.right > Bright && seen.up < Dark && seen.down < Dark, $"a slab: {seen}");
            // Two keep what each of them keeps.
            Clip(LumivoxClip.Shape.Plane).transform.localRotation = Quaternion.Euler(0f, 0f, 90f);
            seen = Seen();
            Assert.IsTrue(seen.left > Bright && seen.right < Dark, $"half a slab: {seen}");
        }

        [Test]
        public void AShapeBelongsToTheNearestVolumeAboveIt()
        {
            var group = new GameObject("Group");
            group.transform.SetParent(volume.transform, false);
            var clip = Clip(LumivoxClip.Shape.Plane, group.transform);
            Assert.AreSame(volume, clip.volume);
            Assert.IsTrue(Seen().down < Dark);
            volume.transform.position = new Vector3(0f, 0.02f, 0f);
            Assert.IsTrue(Seen().up > Bright, "it goes with its volume");
            volume.transform.position = Vector3.zero;
            // The group is hung elsewhere, and the shape with it.
            group.transform.SetParent(null, true);
            Assert.IsNull(clip.volume);
            Assert.IsTrue(clip.GetWarnings().Single().Contains("It cuts nothing"));
            Assert.IsTrue(Seen().down > Bright);
            group.transform.SetParent(volume.transform, true);
            Assert.IsTrue(Seen().down < Dark);
            clip.enabled = false;
            Assert.IsTrue(Seen().down > Bright);
            clip.enabled = true;
            group.SetActive(false);
            Assert.IsTrue(Seen().down > Bright);
            group.SetActive(true);
            Assert.IsTrue(Seen().down < Dark);
            // A volume that comes between takes it over.
            var between = group.AddComponent<LumivoxVolume>();
            Assert.AreSame(between, clip.volume);
            Assert.IsTrue(Seen().down > Bright);
            Object.DestroyImmediate(group);
            Assert.IsTrue(Seen().down > Bright);
            var flat = Clip(LumivoxClip.Shape.Box);
            flat.transform.localScale = new Vector3(1f, 0f, 1f);
            Assert.IsTrue(flat.GetWarnings().Single().Contains("scale is 0"));
            Assert.IsTrue(Seen().down > Bright, "what has no inside keeps everything");
            flat.transform.localScale = Vector3.one * float.NaN;
            Assert.IsTrue(Seen().down > Bright);
            Assert.AreEqual("", LumivoxRenderer.LastError);
        }

        [Test]
        public void OfManyShapesTheFirstCutAndTheOthersSaySo()
        {
            var clips = Enumerable.Range(0, LumivoxClip.Most + 1).Select(_ => Clip(LumivoxClip.Shape.Sphere)).ToArray();
            foreach (var clip in clips) clip.transform.localScale = Vector3.one;
            Assert.IsTrue(clips.Take(LumivoxClip.Most).All(clip => clip.GetWarnings().Count == 0));
            Assert.IsTrue(clips.Last().GetWarnings().Single().Contains($"{LumivoxClip.Most} shapes cut a volume at most"));
            clips[0].enabled = false;
            Assert.AreEqual(0, clips.Last().GetWarnings().Count, "there is room now");
        }

        [Test]
        public void AClonedVolumeHasItsOwnShapesAndSharesItsLabels()
        {
            Clip(LumivoxClip.Shape.Plane);
            volume.labels = Halves();
            var other = Object.Instantiate(volume.gameObject).GetComponent<LumivoxVolume>();
            Assert.AreSame(other, other.GetComponentInChildren<LumivoxClip>().volume);
            Assert.AreSame(volume.labels, other.labels);
            Object.DestroyImmediate(volume.gameObject);
            volume = other;
            Assert.IsTrue(Seen().down < Dark);
        }

        [Test]
        public void LabelsLookAsTheyAreTold()
        {
            var labels = Halves();
            volume.labels = labels;
            var all = Seen();
            Assert.IsTrue(all.left > Bright && all.right > Bright, $"{all}");
            Look(labels, "Left", look => { look.visible = false; return look; });
            var seen = Seen();
            Assert.IsTrue(seen.left > Bright && seen.right < Dark, $"hidden: {seen}");
            Look(labels, "unlabelled", look => { look.visible = false; return look; });
            Look(labels, "Left", look => { (look.visible, look.painted, look.color) = (true, true, Color.red); return look; });
            seen = Seen();
            Assert.IsTrue(seen.left < Dark && seen.right > Bright, $"the other one: {seen}");
            var red = Around(Pictures.Color(camera), 0.65f, 0.5f);
            Assert.IsTrue(red.r > Bright && red.g < 0.2f * red.r && red.b < 0.2f * red.r, $"painted: {red}");
            Look(labels, "Left", look => { (look.painted, look.opacity) = (false, 0f); return look; });
            Assert.IsTrue(Seen().right < Dark, "of no opacity");
            // A function of its own, which is edited afterwards.
            var own = Kept(ScriptableObject.CreateInstance<LumivoxTransferFunction>());
            own.SetPoints(new[] { new LumivoxTransferFunction.OpacityKnot(-10000f, 1f) }, new[] { new LumivoxTransferFunction.ColorStop(0f, Color.green) });
            Look(labels, "Left", look => { (look.opacity, look.transferFunction) = (1f, own); return look; });
            Settle();
            var green = Around(Pictures.Color(camera), 0.65f, 0.5f);
            Assert.IsTrue(green.g > Bright && green.r < 0.2f * green.g, $"{green}");
            own.SetPoints(new[] { new LumivoxTransferFunction.OpacityKnot(-10000f, 0f) }, null);
            Assert.IsTrue(Seen().right < Dark, "its function is another");
            Look(labels, "Left", look => { (look.density, look.transferFunction) = (0f, null); return look; });
            Assert.IsTrue(Seen().right < Dark, "of no density");
            volume.labels = null;
            Assert.IsTrue(Seen().right > Bright && Seen().left > Bright);
        }

        [Test]
        public void LabelsCanBeSparedByShapes()
        {
            var labels = Halves();
            volume.labels = labels;
            // Everything is cut away.
            Clip(LumivoxClip.Shape.Plane).transform.localPosition = Vector3.up;
            var seen = Seen();
            Assert.IsTrue(seen.left < Dark && seen.right < Dark, $"{seen}");
            Look(labels, "Left", look => { look.clipped = false; return look; });
            seen = Seen();
            Assert.IsTrue(seen.left < Dark && seen.right > Bright, $"{seen}");
        }

        [Test]
        public void WhatIsWrongWithLabelsIsSaid()
        {
            string Warnings() => string.Join("\n", volume.GetWarnings());
            volume.labels = Halves(n: 16);
            Assert.AreEqual("", Warnings());
            volume.labels = Halves(5, 16);
            StringAssert.Contains("% of what is labelled lies beyond the scan: are they of the same patient?", Warnings());
            volume.labels = Halves(5000);
            StringAssert.Contains("None of the labels lies in the scan: they are of another patient", Warnings());
            Assert.IsTrue(Seen().right > Bright, "the scan is seen");
            var none = Kept(LumivoxLabels.Create(Vector3Int.one, new byte[] { 0 }, new double[] { 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0 }, new LumivoxLabel[0]));
            Kept(none.map);
            volume.labels = none;
            StringAssert.Contains("Nothing is labelled", Warnings());
            var empty = Kept(ScriptableObject.CreateInstance<LumivoxLabels>());
            volume.labels = empty;
            StringAssert.Contains("no label map", Warnings());
            Assert.IsTrue(Seen().right > Bright);
            StringAssert.Contains("is a scan and no label map", Assert.Throws<LumivoxException>(() => empty.map = scan).Message);
            StringAssert.Contains("is a scan and no label map", Assert.Throws<LumivoxException>(() => LumivoxLabels.Of(scan)).Message);
            StringAssert.Contains("it is null", Assert.Throws<LumivoxException>(() => LumivoxLabels.Of(null)).Message);
            StringAssert.Contains("no label of the value 99", Assert.Throws<LumivoxException>(() => Halves().SetLook(new LumivoxLabels.Look(99, "", Color.red))).Message);
            var place = new double[] { 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0 };
            StringAssert.Contains("which no label has", Assert.Throws<LumivoxException>(() => LumivoxLabels.Create(Vector3Int.one, new byte[] { 3 }, place, null)).Message);
            StringAssert.Contains("1 to 255", Assert.Throws<LumivoxException>(() => LumivoxLabels.Create(Vector3Int.one, new byte[] { 0 }, place, new[] { new LumivoxLabel(256, "a", Color.red) })).Message);
            // What ends while it is shown is shown no longer, and nothing else is wrong.
            var gone = Halves();
            Look(gone, "Left", look => { look.visible = false; return look; });
            volume.labels = gone;
            Assert.IsTrue(Seen().right < Dark);
            Object.DestroyImmediate(gone.map);
            Assert.IsTrue(Seen().right > Bright);
            StringAssert.Contains("no label map", Warnings());
            Object.DestroyImmediate(gone);
            Assert.IsTrue(Seen().right > Bright);
            Assert.AreEqual("", LumivoxRenderer.LastError);
        }

        static string Error(Task task)
        {
            RuntimeComponentTests.Wait(() => task.IsCompleted);
            return task.Exception?.GetBaseException().Message ?? "";
        }

        [Test]
        public void LabelsAreReadAndFound()
        {
            var folder = Path.Combine(Path.GetTempPath(), Path.GetRandomFileName());
            Directory.CreateDirectory(folder);
            try
            {
                StringAssert.Contains("none.nrrd", Error(LumivoxLabels.LoadFile(Path.Combine(folder, "none.nrrd"))));
                var path = Path.Combine(folder, "halves.seg.nrrd");
                File.WriteAllBytes(path, EditorProject.Segmentation());
                var loading = LumivoxLabels.LoadFile(path);
                Assert.AreEqual("", Error(loading));
                var labels = Kept(loading.Result);
                Kept(labels.map);
                CollectionAssert.AreEqual(new[] { "liver", "bone", "unlabelled" }, labels.GetNames());
                Assert.IsTrue(labels.map.isLabelMap);
                File.WriteAllBytes(path, EditorProject.Nrrd());
                StringAssert.Contains("no label map", Error(LumivoxLabels.LoadFile(path)), "a scan is none");
            }
            finally
            {
                Directory.Delete(folder, true);
            }
            var head = Kept(LumivoxVolumeAsset.Phantom("head", 40));
            StringAssert.Contains("open it first", Error(LumivoxLabels.FoundIn(head)));
            head.Open();
            RuntimeComponentTests.Wait(() => head.state == LumivoxVolumeState.Ready);
            using (var importer = new LumivoxImporter())
            {
                var stages = new List<string>();
                importer.progressed += progress => stages.Add(progress.stage);
                var finding = importer.FindLabels(head);
                Assert.Throws<LumivoxException>(() => importer.FindLabels(head));
                Assert.AreEqual("", Error(finding));
                Kept(finding.Result.map);
                CollectionAssert.Contains(Kept(finding.Result).GetNames(), "body");
                Assert.IsTrue(finding.Result.map.GetReport().notes.Any(note => note.StartsWith("confidence")));
                CollectionAssert.Contains(stages, "finding the patient");
                var stopped = importer.FindLabels(head);
                importer.Cancel();
                RuntimeComponentTests.Wait(() => stopped.IsCompleted);
                Assert.IsTrue(stopped.IsCanceled);
            }
        }

        [Test]
        public void PeelingWaitsForTheSkinAndSaysWhereThereIsNone()
        {
            volume.peelMm = 5f;
            Engine.Frame();
            // The library knows, on another thread; its end has not been told.
            Waiting.Turns(() => Library.lumivox_volume_skin(scan.Handle.Pointer) != 0, () => { });
            Assert.AreEqual(1, Jobs.Count);
            Assert.AreEqual(0, volume.GetWarnings().Count);
            Assert.IsTrue(Seen().right > Bright);
            RuntimeComponentTests.Wait(() => volume.GetWarnings().Count > 0);
            StringAssert.Contains("Nothing is peeled off the scan: No skin was found", volume.GetWarnings().Single());
            // Whoever asks again is told at once.
            Assert.AreEqual(0, Jobs.Count);
            Engine.Frames(3);
            Assert.AreEqual(0, Jobs.Count);
            volume.peelMm = 0f;
            Assert.AreEqual(0, volume.GetWarnings().Count);
        }

        [Test]
        public void RowsForGradientsAreReadShownAndSaved()
        {
            var path = Path.Combine(Path.GetTempPath(), Path.GetRandomFileName() + ".json");
            // The cube's values change by some 240 per mm everywhere.
            File.WriteAllText(path, "{ \"lumivox_transfer_function\": 1, \"unit\": \"HU\", \"opacity\": [{ \"value\": -5000, \"opacity\": 1 }], \"color\": [{ \"value\": 0, \"color\": \"#ffffff\" }], \"gradients\": [{ \"per_mm\": 20, \"opacity\": [{ \"value\": -5000, \"opacity\": 0, \"ease\": \"in-out\" }], \"color\": [{ \"value\": 100, \"color\": [1, 0, 0] }] }] }");
            try
            {
                var function = Kept(LumivoxTransferFunction.LoadFile(path));
                var row = function.gradients.Single();
                Assert.AreEqual((20f, -5000f, 0f, LumivoxTransferFunction.Ease.InOut), (row.perMm, row.opacityKnots.Single().value, row.opacityKnots.Single().opacity, row.opacityKnots.Single().ease));
                Assert.AreEqual(Color.red, row.colorStops.Single().color);
                volume.transferFunction = function;
                Assert.IsTrue(Seen().right < Dark, "where values change nothing is seen");
                function.SetGradients(null);
                Assert.IsTrue(Seen().right > Bright);
                function.SetGradients(new[] { row });
                var copy = Kept(ScriptableObject.CreateInstance<LumivoxTransferFunction>());
                copy.CopyFrom(function);
                copy.shift = 50f;
                copy.SaveFile(path);
                var again = Kept(LumivoxTransferFunction.LoadFile(path));
                Assert.AreEqual(-4950f, again.gradients.Single().opacityKnots.Single().value, 1e-3f, "rows lie under the same window");
                Assert.AreEqual(150f, again.gradients.Single().colorStops.Single().value, 1e-3f);
                Assert.AreEqual(LumivoxTransferFunction.Ease.InOut, again.gradients.Single().opacityKnots.Single().ease);
                // What says nothing yet spoils nothing, and too many are told.
                function.SetGradients(new[] { row, new LumivoxTransferFunction.GradientRow(0f, null, null), new LumivoxTransferFunction.GradientRow(float.NaN, null, null) });
                Assert.IsTrue(Seen().right < Dark);
                Assert.Throws<LumivoxException>(() => function.SetGradients(Enumerable.Repeat(row, 33)));
                Assert.AreEqual("", LumivoxRenderer.LastError);
            }
            finally
            {
                File.Delete(path);
            }
        }

        /// Path tracers that were loaded.
        static string[] Tracers()
        {
            const BindingFlags inner = BindingFlags.Instance | BindingFlags.NonPublic;
            var kernels = typeof(Executor).GetField("kernels", inner).GetValue(LumivoxRuntime.Executor);
            var programs = (Program[])typeof(KernelLibrary).GetField("programs", inner).GetValue(kernels);
            return programs.Where(program => program != null && program.Name.StartsWith("path_trace")).Select(program => program.Name).ToArray();
        }

        [TestCase("labels", Category = "Slow")]
        [TestCase("a shape")]
        [TestCase("gradients")]
        [TestCase("peeling", Category = "Slow")]
        public void KernelsForPartsAreLoadedWhereSomethingHasAny(string what)
        {
            Settle();
            Assert.IsTrue(Tracers().Length > 0 && !Tracers().Any(name => name.Contains("_classes")), string.Join(", ", Tracers()));
            if (what == "labels") volume.labels = Halves();
            else if (what == "a shape") Clip(LumivoxClip.Shape.Plane);
            else if (what == "gradients") look.SetGradients(new[] { new LumivoxTransferFunction.GradientRow(5f, new[] { new LumivoxTransferFunction.OpacityKnot(0f, 1f) }, null) });
            else
            {
                var head = Kept(LumivoxVolumeAsset.Phantom("head", 40));
                (volume.volume, volume.peelMm) = (head, 4f);
                RuntimeComponentTests.Wait(() => head.NeedSkin());
            }
            Settle();
            Assert.IsTrue(Tracers().Any(name => name.Contains("_classes")), string.Join(", ", Tracers()));
            Assert.AreEqual("", LumivoxRenderer.LastError);
        }

        [Test]
        public void LabelsAndTenShapesLeaveNoGarbage()
        {
            var labels = Halves();
            volume.labels = labels;
            for (var i = 0; i < 10; i++) Clip((LumivoxClip.Shape)(i % 3)).transform.localScale = Vector3.one * (0.03f + 0.001f * i);
            var moved = Clip(LumivoxClip.Shape.Plane);
            moved.transform.localPosition = new Vector3(0f, -0.006f, 0f);
            var effect = camera.GetComponent<LumivoxEffect>();
            LumivoxRenderer.RenderAtOnce = false;
            volume.maxBounces = 2;
            Settle();
            (effect.frameBudgetMs, effect.resolutionScale) = (1f, 0.25f);
            Garbage.IsLeftByNone(20, 40, i => moved.transform.localPosition = new Vector3(0f, -0.006f - 0.0001f * (i % 9), 0f), () => { });
            Assert.IsTrue(LumivoxRenderer.GetStatus(camera).isShown);
        }

        [TestCase(455, 182)]
        [TestCase(1000, 273, Category = "Slow")]
        public void ChangesOfPartsLeaveNothingBehind(int changes, int counted)
        {
            var clips = Enumerable.Range(0, 4).Select(i => Clip((LumivoxClip.Shape)(i % 3))).ToArray();
            foreach (var clip in clips) clip.transform.localScale = Vector3.one * 0.03f;
            var maps = new[] { Halves(), Halves(2) };
            volume.labels = maps[0];
            LumivoxRenderer.RenderAtOnce = false;
            volume.maxBounces = 2;
            Settle();
            camera.GetComponent<LumivoxEffect>().frameBudgetMs = 1f;
            int buffers = 0, textures = 0;
            for (var i = 0; i < changes; i++)
            {
                switch (i % 5)
                {
                    case 0:
                        Look(maps[i / 5 % 2], "Left", look => { (look.visible, look.opacity) = (i % 3 > 0, 0.01f * (i % 50)); return look; });
                        break;
                    case 1:
                        // Not often: a driver in software compiles kernels anew for other textures.
                        if (i % 100 == 1) volume.labels = i % 200 == 1 ? maps[1] : null;
                        else if (i % 100 == 36) volume.labels = maps[0];
                        else maps[i % 2].map = maps[i % 2].map;
                        break;
                    case 2:
                        // One stays: other kernels are another matter, and drivers in software forget them.
                        clips[1 + i % 3].enabled = !clips[1 + i % 3].enabled;
                        break;
                    case 3:
                        clips[i % 4].transform.localPosition = new Vector3(0f, 0.0001f * (i % 20), 0f);
                        break;
                    default:
                        look.SetGradients(new[] { new LumivoxTransferFunction.GradientRow(5f + i, new[] { new LumivoxTransferFunction.OpacityKnot(0f, 1f) }, null) });
                        break;
                }
                // Not each of them: a frame after a change takes a second or two in software.
                if (i % 91 == 0)
                {
                    Engine.Frame();
                    Ticker.Tick();
                }
                if (i == counted) (buffers, textures) = (Live.buffers, Live.renderTextures);
            }
            Settle();
            Assert.IsTrue(Live.buffers <= buffers + 8, $"{buffers} buffers became {Live.buffers}:\n{Live.Describe()}");
            Assert.IsTrue(Live.renderTextures <= textures + 4, $"{textures} textures became {Live.renderTextures}:\n{Live.Describe()}");
            Assert.AreEqual("", LumivoxRenderer.LastError);
            volume.enabled = false;
            LumivoxRuntime.Stop();
            Assert.AreEqual(0, Live.buffers, Live.Describe());
            Assert.AreEqual(0, Live.renderTextures, Live.Describe());
            Engine.Frames(4);
            Assert.AreEqual(0, Live.safetyHandles);
        }
    }
}
