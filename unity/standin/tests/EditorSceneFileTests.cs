// Scene documents as assets of a project: imported as objects, saved of what a view shows.
using System.IO;
using System.Linq;
using Lumivox.Editor;
using NUnit.Framework;
using StandIn;
using UnityEditor;
using UnityEditor.Build;
using UnityEngine;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed class EditorSceneFileTests
    {
        const string Path = "Assets/head.lumivox";

        [SetUp]
        public void Begin()
        {
            Engine.Clear();
            EditorProject.Begin();
            File.WriteAllBytes(EditorProject.Full("Assets/scan.nrrd"), EditorProject.Nrrd());
            File.WriteAllBytes(EditorProject.Full("Assets/labels.seg.nrrd"), EditorProject.Segmentation());
        }

        [TearDown]
        public void End()
        {
            SceneView.lastActiveSceneView = null;
            LumivoxRuntime.Stop();
            Engine.Clear();
        }

        static void Write(string volume)
        {
            File.WriteAllText(EditorProject.Full(Path), $"{{\"lumivox_scene\": 1,\n\"volumes\": [{{\"scan\": {{\"files\": [\"scan.nrrd\"], \"keep\": \"everything\"}}, {volume}}}],\n\"lights\": [{{\"kind\": \"sun\", \"direction\": [0, -1, 0], \"irradiance\": [1, 1, 1]}}],\n\"camera\": {{\"fov\": 30}}}}");
            AssetDatabase.ImportAsset(Path);
        }

        const string Labelled = "\"look\": {\"preset\": \"mr-head\"}, \"labels\": {\"files\": [\"labels.seg.nrrd\"], \"styles\": [{\"label\": \"liver\", \"visible\": false}]}, \"clip_shapes\": [{\"kind\": \"box\", \"from_shape\": [[5, 0, 0, 0], [0, 5, 0, 0], [0, 0, 5, 0]]}]";

        [Test]
        public void ASceneIsAnAssetWithVolumesLightsAndACamera()
        {
            Write(Labelled);
            Assert.That(Dialogs.ImportErrors, Is.Empty);
            var scene = AssetDatabase.LoadMainAssetAtPath(Path) as GameObject;
            Assert.That(scene, Is.Not.Null);
            var volume = scene.GetComponentInChildren<LumivoxVolume>(true);
            Assert.That(volume.GetComponentsInChildren<LumivoxClip>(true).Single().shape, Is.EqualTo(LumivoxClip.Shape.Box));
            Assert.That(scene.GetComponentInChildren<Light>(true).type, Is.EqualTo(LightType.Directional));
            Assert.That(scene.GetComponent<LumivoxScene>().sceneCamera.fieldOfView, Is.EqualTo(30f).Within(1e-4f));
            // The looks are the asset's own, and the voxels lie in files of their own.
            var inside = AssetDatabase.LoadAllAssetsAtPath(Path);
            foreach (var one in new Object[] { volume.volume, volume.transferFunction, volume.labels, volume.labels.map }) Assert.That(inside, Does.Contain(one));
            Assert.That(volume.labels.TryGetLook("liver", out var liver) && !liver.visible);
            var ids = new[] { volume.volume.StoredId, volume.labels.map.StoredId };
            Assert.That(ids.Distinct().Count(), Is.EqualTo(2));
            foreach (var id in ids) Assert.That(File.Exists(StoredScans.FileOf(id)), id);
            Assert.That(AssetDatabase.entries[Path].import.SourceDependencies, Is.EquivalentTo(new[] { "Assets/scan.nrrd", "Assets/labels.seg.nrrd" }));
            // An asset is in no scene; a copy is.
            Assert.That(LumivoxVolume.All, Is.Empty);
            var copy = Object.Instantiate(scene);
            Assert.That(LumivoxVolume.All.Single().volume, Is.SameAs(volume.volume));
            EditorProject.Until(() => volume.volume.state == LumivoxVolumeState.Ready && volume.labels.map.state == LumivoxVolumeState.Ready, "the scans are read");
            Assert.That(volume.volume.dimensions, Is.EqualTo(new Vector3Int(12, 10, 8)));
            Object.DestroyImmediate(copy);
        }

        [Test]
        public void PlayersGetTheScansOfAScene()
        {
            Write(Labelled);
            EditorBuildSettings.scenes = new EditorBuildSettingsScene[0];
            PlayerSettings.preloaded = new[] { AssetDatabase.LoadMainAssetAtPath(Path) };
            try
            {
                var build = new BuildPlayerContext(default);
                foreach (var type in EditorTypes.Of<BuildPlayerProcessor>()) ((BuildPlayerProcessor)System.Activator.CreateInstance(type)).PrepareForBuild(build);
                Assert.That(build.Added.Count, Is.EqualTo(2));
                foreach (var (from, to) in build.Added)
                {
                    Assert.That(to, Does.StartWith("lumivox/" + AssetDatabase.AssetPathToGUID(Path)));
                    Assert.That(System.Text.Encoding.UTF8.GetString(File.ReadAllBytes(from)), Does.Not.Contain(".nrrd"), "players are not told whose files they were");
                }
            }
            finally
            {
                PlayerSettings.preloaded = System.Array.Empty<Object>();
            }
        }

        [Test]
        public void AFaultIsToldByItsLineAndNothingHalfIsImported()
        {
            Write("\"look\": {\n\"preset\": \"ct-boen\"}");
            Assert.That(Dialogs.ImportErrors.Single(), Does.StartWith("head.lumivox was not imported: ").And.Contain("line 3").And.Contain("ct-boen"));
            Assert.That(AssetDatabase.LoadAllAssetsAtPath(Path), Is.Empty);
            // Mended, it is there.
            Write("\"look\": {}");
            Assert.That(AssetDatabase.LoadMainAssetAtPath(Path), Is.InstanceOf<GameObject>());
            // A scan that is another than it was is told, and shown.
            Write("\"look\": {}");
            File.WriteAllText(EditorProject.Full(Path), File.ReadAllText(EditorProject.Full(Path)).Replace("\"keep\"", "\"content\": \"sha256:00\", \"keep\""));
            AssetDatabase.ImportAsset(Path);
            Assert.That(AssetDatabase.entries[Path].import.Warnings, Has.Some.Contain("line 2").And.Some.Contain("not the scan that the scene was saved with"));
        }

        [Test]
        public void WhatTheSceneViewShowsBecomesAnAsset()
        {
            EditorHost.Menu("Assets/Create/Lumivox/Scene from View");
            Assert.That(Dialogs.Shown.Last().message, Does.Contain("There is no scene view"));
            var view = ScriptableObject.CreateInstance<SceneView>();
            view.viewed = PlainCamera.Make(16);
            view.viewed.cameraType = CameraType.SceneView;
            SceneView.lastActiveSceneView = view;
            EditorHost.Menu("Assets/Create/Lumivox/Scene from View");
            Assert.That(Dialogs.Shown.Last().message, Does.Contain("The view was not saved: The camera sees no volume"));
            var scan = EditorProject.ImportScan("Assets/scan.nrrd");
            var volume = new GameObject("Scan").AddComponent<LumivoxVolume>();
            volume.volume = scan;
            AssetDatabase.ImportAsset("Assets/labels.seg.nrrd");
            volume.labels = Object.Instantiate(AssetDatabase.LoadAssetAtPath<LumivoxLabels>("Assets/labels.seg.nrrd"));
            volume.labels.TryGetLook("bone", out var bone);
            bone.opacity = 0.5f;
            volume.labels.SetLook(bone);
            EditorProject.Until(() => scan.state == LumivoxVolumeState.Ready && volume.labels.map.state == LumivoxVolumeState.Ready, "the scans are read");
            EditorHost.Menu("Assets/Create/Lumivox/Scene from View");
            Assert.That(Dialogs.ImportErrors, Is.Empty);
            // What was imported has its file in its stored scan, and so has what was saved of that.
            Assert.That(File.ReadAllText(EditorProject.Full("Assets/Scene.lumivox")), Does.Contain("\"scan.nrrd\"").And.Contain("\"labels.seg.nrrd\"").And.Contain("\"bone\""));
            var made = AssetDatabase.LoadMainAssetAtPath("Assets/Scene.lumivox") as GameObject;
            Assert.That(made.GetComponentInChildren<LumivoxVolume>(true).volume.dimensions, Is.EqualTo(new Vector3Int(12, 10, 8)));
            var labels = made.GetComponentInChildren<LumivoxVolume>(true).labels;
            Assert.That(labels.TryGetLook("bone", out var again) && again.opacity == 0.5f);
            Assert.That(Selection.activeObject, Is.SameAs(made));
            Object.DestroyImmediate(volume.labels);
            Object.DestroyImmediate(view);
        }
    }
}
