// Scene documents between Unity and the command: what one saves, the other shows.
using System;
using System.IO;
using System.Linq;
using System.Threading;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using UnityEngine.Rendering;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed class RuntimeSceneFileTests
    {
        const string Head = "\"scan\": {\"files\": [\"scan\"]}", Film = "\"film\": {\"size\": [40, 32], \"samples\": 4, \"seed\": 7}";
        /// Nothing in it has more digits than a 32-bit number.
        const string Straight = "\"camera\": {\"world_from_camera\": [[1, 0, 0, 0], [0, 1, 0, 10], [0, 0, 1, 640]], \"fov\": 24}";

        SceneFiles files;

        [SetUp]
        public void Begin()
        {
            Engine.Clear();
            files = new SceneFiles();
        }

        [TearDown]
        public void End()
        {
            LumivoxRuntime.Stop();
            Props.Clear();
            RenderSettings.skybox = null;
            Engine.Clear();
            files.Dispose();
        }

        static string Document(string volume, string rest) => $"{{\"lumivox_scene\": 1,\n\"volumes\": [{{{volume}}}],\n{rest}}}";

        void AreEqual(string a, string b)
        {
            var (pixels, most, _) = SceneFiles.Differences(files.Render(a), files.Render(b));
            Assert.AreEqual((0, 0), (pixels, most), $"{a}, {b}: {pixels} pixels differ, by {most} at most");
        }

        [Test]
        public void ASceneOfTheCommandsPassesThroughUnityToTheLastBit()
        {
            files.Write("own.json", Document(Head + ", \"look\": {\"preset\": \"ct-bone\", \"bounces\": 8}", $"\"environment\": {{\"source\": \"gradient\", \"rotation\": 30, \"strength\": 1.2}}, {Straight}, {Film}, \"display\": {{\"exposure\": 0.5, \"tone\": \"aces\", \"gamma\": 1.1}}"));
            files.PassOn("own.json", "unity.lumivox");
            AreEqual("own.json", "unity.lumivox");
            var text = File.ReadAllText(files.At("unity.lumivox"));
            foreach (var part in new[] { "\"scan\"", "\"content\": \"sha256:", "\"keep\": \"patient\"", "\"samples\": 4", "\"seed\": 7", "\"aces\"", "\"exposure\": 0.5", "\"fov\": 24.0", "\"rotation\": 30.0" }) Assert.That(text, Does.Contain(part));
            Assert.That(text, Does.Not.Contain(files.Folder), "files are named as seen from the document");
        }

        [Test]
        public void WhatEveryHostSavedIsTheSamePictureSavedByUnity()
        {
            files.CopyScenesOfHosts();
            var scene = files.Load("command.lumivox");
            var volume = scene.GetComponentInChildren<LumivoxVolume>();
            volume.transform.position += new Vector3(0.02f, -0.01f, 0f);
            volume.transform.rotation = Quaternion.Euler(0f, 20f, 0f) * volume.transform.rotation;
            volume.density = 0.7f;
            var lamp = new GameObject("Lamp").AddComponent<Light>();
            lamp.transform.SetParent(scene.transform, false);
            lamp.transform.localPosition = new Vector3(0.3f, 0.2f, -0.4f);
            lamp.type = LightType.Point;
            lamp.range = 3f;
            lamp.intensity = 0.5f;
            scene.sceneCamera.fieldOfView = 31f;
            LightFinder.FindAll();
            LumivoxScene.Save(scene.sceneCamera, files.At("own.lumivox"));
            SceneFiles.Destroy(scene);
            files.IsAsWritten("own.lumivox");
            foreach (var host in SceneFiles.Hosts)
            {
                files.PassOn(host + ".lumivox", "of-" + host + ".lumivox");
                AreEqual(host + ".lumivox", "of-" + host + ".lumivox");
            }
        }

        [Test]
        public void WhatIsCutLabelledAndLitPassesThroughUnity()
        {
            const string cuts = "\"clip\": [[0, 0, 0], [1, 1, 0.9]], \"clip_shapes\": [{\"kind\": \"plane\", \"from_shape\": [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0]], \"space\": \"world\"}, {\"kind\": \"sphere\", \"from_shape\": [[60, 0, 0, 30], [0, 60, 0, 30], [0, 0, 60, 20]], \"space\": \"world\", \"inverted\": true}]";
            const string labels = "\"labels\": {\"styles\": [{\"label\": \"body\", \"color\": [0.2, 0.5, 0.9], \"opacity\": 0.5, \"preset\": \"ct-skin\"}, {\"label\": \"unlabelled\", \"visible\": false}]}";
            const string lights = "\"lights\": [{\"kind\": \"sun\", \"direction\": [0, -1, -1], \"irradiance\": [3, 2.5, 2], \"degrees\": 2}, {\"kind\": \"point\", \"lamp\": {\"position\": [200, 100, 300], \"intensity\": [0.3, 0.2, 0.1], \"radius\": 20, \"falloff\": {\"power\": {\"range\": 900, \"decay\": 1.5}}}}, {\"kind\": \"spot\", \"lamp\": {\"position\": [-200, 300, 400], \"intensity\": [0.5, 0.6, 0.9], \"falloff\": {\"relative\": {\"range\": 2000}}}, \"direction\": [2, -3, -4], \"half_angle\": 20, \"cone\": {\"attenuation\": 0.7}}]";
            files.Write("own.json", Document($"{Head}, \"look\": {{\"preset\": \"ct-skin\", \"bounces\": 8}}, \"peel\": 4, \"world_from_patient\": [[0, 1, 0, 0], [0, 0, 1, -90], [1, 0, 0, 0]], {cuts}, {labels}", $"{lights}, \"environment\": {{\"source\": \"uniform\", \"color\": [0.2, 0.2, 0.3]}}, \"camera\": {{\"azimuth\": 35, \"elevation\": 10}}, {Film}, \"display\": {{\"background\": \"transparent\"}}"));
            files.PassOn("own.json", "unity.lumivox");
            AreEqual("own.json", "unity.lumivox");
            files.PassOn("unity.lumivox", "again.lumivox");
            AreEqual("unity.lumivox", "again.lumivox");
        }

        [Test]
        public void LightIsSavedAlikeInEveryPipeline()
        {
            const string lights = "\"lights\": [{\"kind\": \"sun\", \"direction\": [0, -1, 0], \"irradiance\": [3, 2.5, 2]}, {\"kind\": \"spot\", \"lamp\": {\"position\": [-200, 300, 400], \"intensity\": [0.5, 0.6, 0.9]}, \"direction\": [0, -1, 0], \"half_angle\": 20, \"cone\": {\"inner_half_angle\": 10}}]";
            files.Write("own.json", Document(Head, $"{lights}, \"environment\": {{\"source\": \"uniform\", \"color\": [0.2, 0.4, 3]}}, {Straight}, {Film}"));
            files.PassOn("own.json", "built-in.lumivox");
            var text = File.ReadAllText(files.At("built-in.lumivox"));
            foreach (var part in new[] { "[3.0, 2.5, 2.0]", "[0.5, 0.6, 0.9]", "[0.2, 0.4, 3.0]", "\"inner_half_angle\": 10.0", "[0.0, -1.0, 0.0]" }) Assert.That(text, Does.Contain(part));
            foreach (var kind in new[] { "graph", "HDRP" })
                using (new Pipeline(kind))
                {
                    GraphicsSettings.lightsUseLinearIntensity = true;
                    files.PassOn("own.json", "other.lumivox");
                    GraphicsSettings.lightsUseLinearIntensity = false;
                    Assert.AreEqual(text, File.ReadAllText(files.At("other.lumivox")), kind);
                }
        }

        [Test]
        public void AViewOfUnitysIsWhatTheCommandRenders()
        {
            const int side = 24;
            var camera = PlainCamera.Make(side, 160);
            camera.transform.position = new Vector3(0.2f, 0.1f, -0.5f);
            camera.transform.LookAt(Vector3.zero);
            camera.backgroundColor = new Color(0.2f, 0.3f, 0.4f, 1f);
            using (var importer = new LumivoxImporter())
            {
                var loading = importer.Load(new[] { files.At("scan") });
                RuntimeComponentTests.Wait(() => loading.IsCompleted);
                var volume = new GameObject("Head").AddComponent<LumivoxVolume>();
                volume.transform.SetPositionAndRotation(new Vector3(0.01f, 0.02f, 0f), Quaternion.Euler(5f, 25f, -10f));
                volume.volume = loading.Result;
                volume.ApplyPreset("ct-bone");
                volume.maxBounces = 4;
                Waiting.Frames(() => LumivoxRuntime.StatusOf(camera).isConverged);
                LumivoxScene.Save(camera, files.At("view.lumivox"));
                var rendered = files.Render("view.lumivox", out var width);
                Assert.AreEqual(side, width);
                var shown = Pictures.Color(camera).pixels.Select(pixel => (Color32)new Color(Mathf.LinearToGammaSpace(Mathf.Clamp01(pixel.r)), Mathf.LinearToGammaSpace(Mathf.Clamp01(pixel.g)), Mathf.LinearToGammaSpace(Mathf.Clamp01(pixel.b)))).ToArray();
                var (_, most, mean) = SceneFiles.Differences(shown, rendered);
                Console.WriteLine($"  Unity's view and the command's: {most} of 255 at most, {mean:e1} on average");
                Assert.IsTrue(mean < 0.02, $"{mean} on average");
                // What noise there is left cancels out.
                for (var c = 0; c < 3; c++) Assert.AreEqual(rendered.Average(pixel => pixel.ToColor()[c]), shown.Average(pixel => pixel.ToColor()[c]), 0.004);
                Object.DestroyImmediate(volume.transferFunction);
                Object.DestroyImmediate(loading.Result);
            }
        }

        [Test]
        public void WhatLiesAroundThePatientIsSavedWhereItIsSeen()
        {
            using (var torso = new SceneFiles("torso", 40))
            using (var importer = new LumivoxImporter())
            {
                var camera = PlainCamera.Make(8);
                var loading = importer.Load(new[] { torso.At("scan") });
                RuntimeComponentTests.Wait(() => loading.IsCompleted);
                Assert.IsTrue(loading.Result.hasSurroundings);
                var volume = new GameObject("Torso").AddComponent<LumivoxVolume>();
                volume.volume = loading.Result;
                string Saved()
                {
                    LumivoxScene.Save(camera, torso.At("view.lumivox"));
                    return File.ReadAllText(torso.At("view.lumivox"));
                }
                Assert.That(Saved(), Does.Contain("\"keep\": \"patient\""));
                volume.keepEverything = true;
                RuntimeComponentTests.Wait(() => !volume.isPreparing);
                Assert.That(Saved(), Does.Contain("\"keep\": \"everything\""));
                torso.Run("scene check view.lumivox");
                Object.DestroyImmediate(loading.Result);
            }
        }

        [Test]
        public void ASkyOfNoFileIsWrittenBesideTheScene()
        {
            Engine.SetScreen(8, 8);
            files.Write("own.json", Document(Head, $"{Straight}, {Film}"));
            var scene = files.Load("own.json");
            scene.sceneCamera.GetComponent<LumivoxEffect>().frameBudgetMs = 1f;
            var material = new Material(Resources.Load<Shader>("Lumivox/LumivoxDepth"));
            Props.skies[material] = direction => new Color(1f + direction.x, 0.5f, 0.25f);
            RenderSettings.ambientMode = AmbientMode.Skybox;
            RenderSettings.skybox = material;
            Object.DestroyImmediate(scene.GetComponent<LumivoxEnvironment>());
            var error = Assert.Throws<LumivoxException>(() => LumivoxScene.Save(scene.sceneCamera, files.At("sky.lumivox")));
            Assert.That(error.Message, Does.Contain("The sky that lights the volumes is still being read"));
            bool IsSaved()
            {
                Engine.Frame();
                try
                {
                    LumivoxScene.Save(scene.sceneCamera, files.At("sky.lumivox"));
                    return true;
                }
                catch (LumivoxException)
                {
                    return false;
                }
            }
            RuntimeComponentTests.Wait(IsSaved);
            Assert.That(File.ReadAllText(files.At("sky.lumivox")), Does.Contain("\"source\": \"sky.sky.exr\""));
            SceneFiles.Destroy(scene);
            Object.DestroyImmediate(material);
            // It is a map of a file from now on, whose texels are those to the bit.
            var again = files.Load("sky.lumivox");
            var environment = again.GetComponent<LumivoxEnvironment>();
            Assert.AreEqual(LumivoxEnvironment.Kind.Map, environment.kind);
            Assert.AreEqual(new Vector2Int(512, 256), environment.sky.size);
            LumivoxScene.Save(again.sceneCamera, files.At("again.lumivox"));
            Assert.IsFalse(File.Exists(files.At("again.sky.exr")));
            AreEqual("sky.lumivox", "again.lumivox");
            SceneFiles.Destroy(again);
        }

        string Fault(string name)
        {
            var before = Objects.All().OfType<GameObject>().Count();
            var loading = LumivoxScene.Load(files.At(name));
            RuntimeComponentTests.Wait(() => loading.IsCompleted);
            Assert.AreEqual(before, Objects.All().OfType<GameObject>().Count(), "nothing half appears");
            return loading.Exception.GetBaseException().Message;
        }

        [Test]
        public void WhatIsWrongWithASceneIsToldByItsLine()
        {
            files.Write("unknown.json", "{\"lumivox_scene\": 1,\n\"volumes\": [],\n\"camrea\": {}}");
            Assert.That(Fault("unknown.json"), Does.Contain("unknown.json, line 3").And.Contain("camrea"));
            files.Write("newer.json", "{\n\"lumivox_scene\": 2}");
            Assert.That(Fault("newer.json"), Does.Contain("newer.json, line 2").And.Contain("version 2"));
            files.Write("missing.json", Document("\n\"scan\": {\"files\": [\"none\"]}", Film));
            Assert.That(Fault("missing.json"), Does.Contain("missing.json, line 3").And.Contain("none"));
            files.Write("slanted.json", Document(Head + ",\n\"world_from_patient\": [[1, 0.5, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]", Film));
            Assert.That(Fault("slanted.json"), Does.Contain("slanted.json, line 3").And.Contain("slanted"));
            files.Write("label.json", Document(Head + ",\n\"labels\": {\n\"styles\": [{\"label\": \"liver\"}]}", Film));
            Assert.That(Fault("label.json"), Does.Contain("label.json, line 4").And.Contain("liver"));
            Assert.That(Fault("nowhere.json"), Does.Contain("cannot read").And.Contain("nowhere.json"));
        }

        [Test]
        public void AnotherScanInItsPlaceIsSaid()
        {
            files.Write("changed.json", Document("\n\"scan\": {\"files\": [\"scan\"], \"content\": \"sha256:00\"}", Film));
            var scene = files.Load("changed.json");
            Assert.IsTrue(scene.notes.Any(note => note.Contains("changed.json, line 3, column ") && note.Contains(": scan: this is not the scan that the scene was saved with")), string.Join("\n", scene.notes));
            SceneFiles.Destroy(scene);
        }

        [Test]
        public void OpeningTellsHowFarItIsAndCanBeStopped()
        {
            files.Write("own.json", Document(Head, Film));
            var stages = new System.Collections.Generic.List<string>();
            var opening = LumivoxScene.Load(files.At("own.json"), progress => stages.Add(progress.stage));
            RuntimeComponentTests.Wait(() => opening.IsCompleted);
            SceneFiles.Destroy(opening.Result);
            Assert.IsTrue(stages.Count > 0 && stages.All(stage => stage.Length > 0), string.Join(", ", stages));
            using (var stop = new CancellationTokenSource())
            {
                var loading = LumivoxScene.Load(files.At("own.json"), null, stop.Token);
                stop.Cancel();
                RuntimeComponentTests.Wait(() => loading.IsCompleted);
                Assert.IsTrue(loading.IsCanceled);
            }
        }

        [Test]
        public void WhatCannotBeSavedSaysWhy()
        {
            string Refusal(Camera of) => Assert.Throws<LumivoxException>(() => LumivoxScene.Save(of, files.At("no.lumivox"))).Message;
            var camera = PlainCamera.Make(8);
            Assert.That(Refusal(null), Does.Contain("no camera"));
            Assert.That(Refusal(camera), Does.Contain("sees no volume"));
            var scan = LumivoxVolumeAsset.Phantom("cube", 16);
            var volume = new GameObject("Cube").AddComponent<LumivoxVolume>();
            volume.volume = scan;
            Assert.That(Refusal(camera), Does.Contain("'Cube' is still being read"));
            RuntimeComponentTests.Wait(() => scan.state == LumivoxVolumeState.Ready);
            Assert.That(Refusal(camera), Does.Contain("scan 1 was made in memory: write it to a file"));
            camera.orthographic = true;
            Assert.That(Refusal(camera), Does.Contain("orthographic"));
            camera.orthographic = false;
            camera.GetComponent<LumivoxEffect>().enabled = false;
            Assert.That(Refusal(camera), Does.Contain("draws no volumes"));
            camera.GetComponent<LumivoxEffect>().enabled = true;
            Assert.IsFalse(File.Exists(files.At("no.lumivox")));
            Object.DestroyImmediate(scan);
            // Nor is anything left where it cannot be written.
            files.Write("own.json", Document(Head, Film));
            var scene = files.Load("own.json");
            var error = Assert.Throws<LumivoxException>(() => LumivoxScene.Save(scene.sceneCamera, files.At("none/no.lumivox")));
            Assert.That(error.Message, Does.Contain("cannot write").And.Contain("no.lumivox"));
            SceneFiles.Destroy(scene);
        }
    }

    static class Colors
    {
        internal static Color ToColor(this Color32 color) => color;
    }
}
