// Labels and clips in the editor: label maps as assets, inspectors, menus, undo, prefabs, builds, reloads.
using System.IO;
using System.Linq;
using Lumivox.Editor;
using NUnit.Framework;
using StandIn;
using UnityEditor;
using UnityEditor.Build;
using UnityEditor.UIElements;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Tests
{
    public sealed class EditorPartsTests
    {
        const string Scan = "Assets/head.nrrd", Map = "Assets/parts.nrrd";

        [SetUp]
        public void Begin() => EditorProject.Begin();

        [TearDown]
        public void End()
        {
            foreach (var volume in Object.FindObjectsByType<LumivoxVolume>(FindObjectsSortMode.None)) Object.DestroyImmediate(volume.gameObject);
        }

        static LumivoxLabels ImportLabels(string path = Map)
        {
            File.WriteAllBytes(EditorProject.Full(path), EditorProject.Segmentation());
            AssetDatabase.ImportAsset(path);
            return AssetDatabase.LoadAssetAtPath<LumivoxLabels>(path);
        }

        static LumivoxVolume Volume(string name = "Head")
        {
            var volume = new GameObject(name).AddComponent<LumivoxVolume>();
            volume.volume = AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>(Scan) ?? EditorProject.ImportScan(Scan);
            EditorProject.Until(() => volume.volume.state == LumivoxVolumeState.Ready, "the scan is read");
            return volume;
        }

        [Test]
        public void ALabelMapBecomesLabelsAndAScanDoesNot()
        {
            var labels = ImportLabels();
            Assert.That(labels, Is.Not.Null, string.Join("\n", Dialogs.ImportErrors));
            Assert.That(AssetDatabase.LoadMainAssetAtPath(Map), Is.SameAs(labels));
            Assert.That(labels.GetNames(), Is.EqualTo(new[] { "liver", "bone", "unlabelled" }));
            Assert.That(labels.TryGetLook("liver", out var liver) && liver.color == Color.red);
            Assert.That(labels.map, Is.SameAs(AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>(Map)));
            Assert.That(labels.map.labels.Select(label => label.milliliters), Is.EqualTo(new[] { 0.48, 0.48 }).Within(1e-9));
            Assert.That(File.Exists(StoredScans.FileOf(AssetDatabase.AssetPathToGUID(Map))));
            var volume = Volume();
            Assert.That(AssetDatabase.LoadAssetAtPath<LumivoxLabels>(Scan), Is.Null);
            Assert.That(volume.volume.isLabelMap, Is.False);
            volume.labels = labels;
            EditorProject.Until(() => labels.map.state == LumivoxVolumeState.Ready, "the labels are read");
            Assert.That(volume.GetWarnings(), Is.Empty);
            // Its file becomes another: the looks that there were stay, and the map is read again.
            liver.visible = false;
            labels.SetLook(liver);
            var copy = Object.Instantiate(labels);
            AssetDatabase.CreateAsset(copy, "Assets/looks.asset");
            volume.labels = copy;
            File.WriteAllText(EditorProject.Full(Map), "nothing");
            AssetDatabase.ImportAsset(Map);
            Assert.That(Dialogs.ImportErrors.Single(), Does.Contain("parts.nrrd was not imported"));
        }

        [Test]
        public void WhatAFileIsTakenForCanBeChosen()
        {
            ImportLabels();
            var importer = (ScanImporter)AssetDatabase.entries[Map].importer;
            var serialized = new SerializedObject(importer);
            serialized.FindProperty("m_LabelMap").enumValueIndex = (int)LumivoxLabelMaps.No;
            serialized.ApplyModifiedProperties();
            AssetDatabase.ImportAsset(Map);
            Assert.That(AssetDatabase.LoadAssetAtPath<LumivoxLabels>(Map), Is.Null);
            Assert.That(AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>(Map).isLabelMap, Is.False);
            EditorProject.ImportScan(Scan);
            serialized = new SerializedObject((ScanImporter)AssetDatabase.entries[Scan].importer);
            serialized.FindProperty("m_LabelMap").enumValueIndex = (int)LumivoxLabelMaps.Yes;
            serialized.ApplyModifiedProperties();
            AssetDatabase.ImportAsset(Scan);
            Assert.That(Dialogs.ImportErrors.Single(), Does.Contain("head.nrrd was not imported").And.Contain("no label map"));
        }

        [Test]
        public void LooksOfImportedLabelsAreEditedInAnAssetOfTheirOwn()
        {
            LumivoxVolume a = Volume("A"), b = Volume("B");
            a.labels = b.labels = ImportLabels();
            var (_, panel) = EditorHost.Inspect(a, b);
            panel.Advance(600);
            panel.Click(panel.visualTree.Q<Button>("looks").worldBound.center);
            Assert.That(AssetDatabase.GetAssetPath(a.labels), Is.EqualTo("Assets/parts looks.asset"));
            Assert.That(b.labels, Is.SameAs(a.labels));
            Assert.That(a.labels.map, Is.SameAs(AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>(Map)), "the voxels are shared");
            panel.Advance(600);
            Assert.That(panel.visualTree.Q<Button>("looks").resolvedStyle.display, Is.EqualTo(DisplayStyle.None));
            Assert.That(Undo.Names[0], Is.EqualTo("Edit Looks of Labels"));
            Undo.PerformUndo();
            Assert.That(AssetDatabase.GetAssetPath(a.labels), Is.EqualTo(Map));
        }

        [Test]
        public void WhatWasPutAsideIsShownByASwitchOfTheInspector()
        {
            const string patient = "Assets/patient.lumivox", raw = "Assets/patient.bytes";
            File.WriteAllBytes(EditorProject.Full(raw), RuntimeImportTests.Patient(64));
            using (var importer = new LumivoxImporter())
            {
                var loading = importer.Load(new[] { EditorProject.Full(raw) }, new LumivoxImportOptions { raw = "64x64x64:i16le:spacing=4,4,4:modality=CT" });
                EditorProject.Until(() => loading.IsCompleted, "the patient is read");
                ScanSaver.Save(loading.Result, patient, (saved, problem) => Assert.That(problem, Is.Null));
                EditorProject.Until(() => AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>(patient) != null, "the patient is saved");
                Object.DestroyImmediate(loading.Result);
            }
            var scan = AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>(patient);
            Assert.That((scan.state, scan.hasSurroundings), Is.EqualTo((LumivoxVolumeState.Closed, true)), "it is known before the scan is read");
            var volume = new GameObject("Patient").AddComponent<LumivoxVolume>();
            volume.volume = scan;
            EditorProject.Until(() => scan.state == LumivoxVolumeState.Ready, "the scan is read");
            var (_, panel) = EditorHost.Inspect(volume);
            panel.visualTree.Query<PropertyField>().ToList().Single(one => one.bindingPath == "m_KeepEverything").Q<Toggle>().value = true;
            Assert.That(volume.keepEverything);
            Assert.That(volume.isPreparing);
            panel.Advance(600);
            Assert.That(panel.visualTree.Q<Label>("finding").text, Is.EqualTo("What lies around the patient is being put back."));
            EditorProject.Until(() => !volume.isPreparing, "it is there");
            panel.Advance(600);
            Assert.That(panel.visualTree.Q<Label>("finding").text, Is.Empty);
            Undo.PerformUndo();
            Assert.That(volume.keepEverything, Is.False);
            Assert.That(volume.GetWarnings(), Is.Empty);
        }

        static T Field<T>(Panel panel, string label, string property) where T : VisualElement =>
            panel.visualTree.Q("labels").Children().Single(row => row.name == label).Query<PropertyField>().ToList().Single(one => one.bindingPath.EndsWith("." + property)).Q<T>();

        [Test]
        public void LooksAreEditedAndUndone()
        {
            var labels = LumivoxLabels.Of(ImportLabels().map);
            AssetDatabase.CreateAsset(labels, "Assets/looks.asset");
            var (_, panel) = EditorHost.Inspect(labels);
            bool Visible(string name) => labels.TryGetLook(name, out var look) && look.visible;
            foreach (var field in panel.visualTree.Q("labels").Query<PropertyField>().ToList()) Assert.That(field.tooltip, Is.Not.Empty, field.bindingPath);
            Field<Toggle>(panel, "liver", "visible").value = false;
            Assert.That((Visible("liver"), Visible("bone")), Is.EqualTo((false, true)));
            Undo.IncrementCurrentGroup();
            Field<FloatField>(panel, "bone", "opacity").value = 7f;
            Assert.That(labels.TryGetLook("bone", out var bone) && bone.opacity == 1f, "beyond its range it is the nearest in it");
            Undo.IncrementCurrentGroup();
            panel.Click(panel.visualTree.Q<Button>("hide-all").worldBound.center);
            Assert.That(labels.looks.All(look => !look.visible));
            Undo.PerformUndo();
            Assert.That((Visible("liver"), Visible("bone")), Is.EqualTo((false, true)));
            // Only what is listed.
            panel.visualTree.Q<TextField>("search").value = "LIV";
            Undo.IncrementCurrentGroup();
            panel.Click(panel.visualTree.Q<Button>("show-all").worldBound.center);
            panel.Click(panel.visualTree.Q<Button>("hide-all").worldBound.center);
            Assert.That((Visible("liver"), Visible("bone"), Visible("unlabelled")), Is.EqualTo((false, true, true)));
            // Two with the same labels are edited together, others one by one.
            var other = LumivoxLabels.Of(labels.map);
            AssetDatabase.CreateAsset(other, "Assets/other.asset");
            (_, panel) = EditorHost.Inspect(labels, other);
            Field<FloatField>(panel, "bone", "density").value = 3f;
            Assert.That(new[] { labels, other }.Select(one => one.TryGetLook("bone", out var look) ? look.density : 0f), Is.EqualTo(new[] { 3f, 3f }));
            var empty = ScriptableObject.CreateInstance<LumivoxLabels>();
            AssetDatabase.CreateAsset(empty, "Assets/empty.asset");
            (_, panel) = EditorHost.Inspect(labels, empty);
            Assert.That(panel.visualTree.Q("labels").childCount, Is.Zero);
            Assert.That(panel.visualTree.Q<HelpBox>("note").text, Does.Contain("one by one"));
            (_, panel) = EditorHost.Inspect(empty);
            Assert.That(panel.visualTree.Q<HelpBox>("note").text, Does.Contain("no label map"));
        }

        [Test]
        public void LabelsAreFoundInAScanAndSavedBesideIt()
        {
            var volume = new GameObject("Head").AddComponent<LumivoxVolume>();
            Directory.CreateDirectory(EditorProject.Full("Assets/Scans"));
            AssetDatabase.CreateAsset(LumivoxVolumeAsset.Phantom("head", 40), "Assets/Scans/phantom.asset");
            volume.volume = AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>("Assets/Scans/phantom.asset");
            var (_, panel) = EditorHost.Inspect(volume);
            Button Find() => panel.visualTree.Q<Button>("find");
            Assert.That(Find().enabledSelf, Is.False, "the scan is not there yet");
            EditorProject.Until(() => volume.volume.state == LumivoxVolumeState.Ready, "the phantom is there", panel);
            panel.Advance(600);
            panel.Click(Find().worldBound.center);
            Assert.That(Find().text, Is.EqualTo("Stop"));
            panel.Click(Find().worldBound.center);
            EditorProject.Until(() => !LabelActions.IsFinding, "it is stopped", panel);
            Assert.That(volume.labels, Is.Null);
            Assert.That(Log.entries.Last(entry => entry.type == LogType.Warning).message, Does.Contain("No labels were found: It was stopped."));
            panel.Advance(600);
            panel.Click(Find().worldBound.center);
            EditorProject.Until(() => !LabelActions.IsFinding, "labels are found", panel);
            Assert.That(AssetDatabase.GetAssetPath(volume.labels), Is.EqualTo("Assets/Scans/phantom looks.asset"));
            Assert.That(AssetDatabase.GetAssetPath(volume.labels.map), Is.EqualTo("Assets/Scans/phantom labels.lumivox"));
            Assert.That(volume.labels.GetNames(), Does.Contain("body"));
            Assert.That(volume.labels.map.GetReport().notes, Is.Not.Empty);
            EditorProject.Until(() => volume.labels.map.state == LumivoxVolumeState.Ready, "the labels are read", panel);
            Assert.That(volume.GetWarnings(), Is.Empty);
            Undo.PerformUndo();
            Assert.That(volume.labels, Is.Null);
        }

        [Test]
        public void AClipIsMadeDrawnEditedAndUndone()
        {
            var volume = Volume();
            EditorHost.Menu("GameObject/Lumivox/Clip", volume.gameObject);
            var clip = Selection.activeGameObject.GetComponent<LumivoxClip>();
            Assert.That(clip.volume, Is.SameAs(volume));
            Assert.That(Undo.Names[0], Is.EqualTo("Create Clip"));
            Undo.PerformUndo();
            Assert.That(clip == null && volume.Clips.Count == 0);
            var (_, panel) = EditorHost.Inspect(volume);
            panel.Click(panel.visualTree.Q<Button>("add-clip").worldBound.center);
            clip = volume.Clips.Single();
            var other = VolumeActions.CreateClip(null);
            (_, panel) = EditorHost.Inspect(clip, other);
            Assert.That(panel.visualTree.Query<HelpBox>().ToList().Single().text, Does.Contain("It cuts nothing"));
            var fields = panel.visualTree.Query<PropertyField>().ToList();
            Assert.That(Node.FieldsOf(typeof(LumivoxClip)).Select(field => field.Name), Is.EquivalentTo(fields.Select(field => field.bindingPath)));
            Assert.That(fields.All(field => field.tooltip != ""));
            Undo.IncrementCurrentGroup();
            fields.Single(field => field.bindingPath == "m_Inverted").Q<Toggle>().value = true;
            Assert.That(clip.inverted && other.inverted);
            Undo.PerformUndo();
            Assert.That(!clip.inverted && !other.inverted);
            other.transform.SetParent(volume.transform, false);
            panel.Advance(600);
            Assert.That(panel.visualTree.Query<HelpBox>().ToList(), Is.Empty);
            Object.DestroyImmediate(other.gameObject);
            // Each shape is drawn as it is.
            clip.transform.localScale = new Vector3(0.1f, 0.2f, 0.3f);
            foreach (var (shape, kind, size) in new[] { (LumivoxClip.Shape.Box, "wire cube", 0.2f), (LumivoxClip.Shape.Sphere, "wire sphere", 0.1f) })
            {
                clip.shape = shape;
                Gizmos.drawn.Clear();
                EditorHost.DrawScene(null, clip);
                Assert.That(Gizmos.drawn.Select(one => one.kind), Is.All.EqualTo(kind));
                Assert.That(Gizmos.drawn.Last().matrix.m11, Is.EqualTo(size).Within(1e-6));
            }
            clip.shape = LumivoxClip.Shape.Plane;
            Gizmos.drawn.Clear();
            EditorHost.DrawScene(null, clip);
            // As large as the scan, whatever its scale: 12 x 10 x 16 mm.
            Assert.That(Gizmos.drawn.First(one => one.kind == "wire cube").matrix.m00, Is.EqualTo(0.05f).Within(1e-6));
            Assert.That(Gizmos.drawn.Count(one => one.kind == "line"), Is.EqualTo(2), "faint for all, and strong for what is selected");
        }

        [Test]
        public void ABuildTakesAlongTheMapsOfLabels()
        {
            var labels = LumivoxLabels.Of(ImportLabels().map);
            AssetDatabase.CreateAsset(labels, "Assets/looks.asset");
            AssetDatabase.dependencies["Assets/Main.unity"] = new[] { "Assets/looks.asset" };
            AssetDatabase.dependencies["Assets/looks.asset"] = new[] { Map };
            var build = new BuildPlayerContext(new BuildPlayerOptions { scenes = new[] { "Assets/Main.unity" } });
            foreach (var type in EditorTypes.Of<BuildPlayerProcessor>()) ((BuildPlayerProcessor)System.Activator.CreateInstance(type)).PrepareForBuild(build);
            Assert.That(build.Added.Select(file => file.to), Is.EqualTo(new[] { $"lumivox/{AssetDatabase.AssetPathToGUID(Map)}.lumivox" }));
        }

        [Test]
        public void PartsAreThereAgainWhenScriptsAreLoadedAnew()
        {
            var volume = Volume();
            volume.labels = LumivoxLabels.Of(ImportLabels().map);
            AssetDatabase.CreateAsset(volume.labels, "Assets/looks.asset");
            Assert.That(volume.labels.TryGetLook("liver", out var liver));
            liver.visible = false;
            volume.labels.SetLook(liver);
            volume.peelMm = 3f;
            VolumeActions.CreateClip(volume.gameObject).inverted = true;
            EditorProject.Until(() => volume.labels.map.state == LumivoxVolumeState.Ready, "the labels are read");
            Domain.Reload();
            volume = Object.FindObjectsByType<LumivoxVolume>(FindObjectsSortMode.None).Single();
            Assert.That(volume.peelMm, Is.EqualTo(3f));
            Assert.That(volume.Clips.Single().inverted && volume.Clips.Single().volume == volume);
            Assert.That(volume.labels.TryGetLook("liver", out liver) && !liver.visible);
            EditorProject.Until(() => volume.labels.map.state == LumivoxVolumeState.Ready && volume.volume.state == LumivoxVolumeState.Ready, "both are read again");
            Assert.That(volume.labels.map.labels.Count, Is.EqualTo(2));
            Assert.That(volume.labels.Problem, Is.Null);
        }

        [Test]
        public void AFunctionKeepsItsRowsThroughEditsAndFiles()
        {
            var function = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
            function.SetPoints(
                new[] { new LumivoxTransferFunction.OpacityKnot(0, 0), new LumivoxTransferFunction.OpacityKnot(500, 0.5f), new LumivoxTransferFunction.OpacityKnot(900, 1) },
                new[] { new LumivoxTransferFunction.ColorStop(0, Color.white) });
            function.SetGradients(new[] { new LumivoxTransferFunction.GradientRow(120f, new[] { new LumivoxTransferFunction.OpacityKnot(100, 1) }, new[] { new LumivoxTransferFunction.ColorStop(0, Color.red) }) });
            AssetDatabase.CreateAsset(function, "Assets/Function.asset");
            var (_, panel) = EditorHost.Inspect(function);
            var field = panel.visualTree.Q<TransferFunctionField>("editor");
            var shown = panel.visualTree.Q<Label>("gradients");
            Assert.That(shown.text, Is.EqualTo("Besides these, a row for gradients of 120 per mm."));
            Assert.That(shown.resolvedStyle.display, Is.EqualTo(DisplayStyle.Flex));
            var before = function.GetState();
            // A point is moved, under a window that is written into all points for it.
            function.shift = 10f;
            field.Refresh();
            panel.Update();
            var at = field.Graph.worldBound.position + field.Graph.PlaceOf(1);
            panel.PointerDown(at);
            panel.PointerMove(at + new Vector2(20, 10));
            panel.PointerUp(at + new Vector2(20, 10));
            Assert.That(function.shift, Is.Zero);
            Assert.That(function.gradients.Single().opacityKnots.Single().value, Is.EqualTo(110f).Within(1e-3));
            Undo.PerformUndo();
            Assert.That(function.gradients.Single().opacityKnots.Single().value, Is.EqualTo(100f));
            var file = Path.Combine(Path.GetTempPath(), Path.GetRandomFileName() + ".json");
            function.shift = 0f;
            Dialogs.Paths.Enqueue(file);
            panel.Click(panel.visualTree.Q<Button>("save").worldBound.center);
            function.SetGradients(null);
            field.Refresh();
            Assert.That(shown.resolvedStyle.display, Is.EqualTo(DisplayStyle.None));
            Dialogs.Paths.Enqueue(file);
            panel.Click(panel.visualTree.Q<Button>("load").worldBound.center);
            Assert.That(function.GetState(), Is.EqualTo(before));
            Assert.That(function.gradients.Single().perMm, Is.EqualTo(120f));
            Undo.PerformUndo();
            Assert.That(function.gradients, Is.Empty);
            File.Delete(file);
            Object.DestroyImmediate(function, true);
        }
    }
}
