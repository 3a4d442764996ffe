// Inspectors, handles, menus and windows over volumes, with undo.
using System.Linq;
using Lumivox.Editor;
using NUnit.Framework;
using StandIn;
using UnityEditor;
using UnityEditor.UIElements;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Tests
{
    public sealed class EditorInspectorTests
    {
        [SetUp]
        public void Begin() => EditorProject.Begin();

        [TearDown]
        public void End()
        {
            if (EditorWindow.HasOpenInstances<TransferFunctionWindow>()) EditorWindow.GetWindow<TransferFunctionWindow>().Close();
            foreach (var volume in Object.FindObjectsByType<LumivoxVolume>(FindObjectsSortMode.None)) Object.DestroyImmediate(volume.gameObject);
        }

        static LumivoxVolume Volume(string name = "Head") => new GameObject(name).AddComponent<LumivoxVolume>();

        static LumivoxVolume VolumeWithScan(string name = "Head")
        {
            var volume = Volume(name);
            volume.volume = AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>("Assets/head.nrrd") ?? EditorProject.ImportScan("Assets/head.nrrd");
            EditorProject.Until(() => volume.volume.state == LumivoxVolumeState.Ready, "the scan is read");
            return volume;
        }

        [Test]
        public void PropertiesAreEditedForSeveralVolumesAndUndone()
        {
            LumivoxVolume a = Volume("A"), b = Volume("B");
            a.density = 5;
            var (_, panel) = EditorHost.Inspect(a, b);
            var density = panel.visualTree.Query<PropertyField>().ToList().Single(one => one.bindingPath == "m_Density").Q<FloatField>();
            Assert.That(density.showMixedValue);
            Assert.That(density.tooltip, Does.Contain("extinction"));
            density.value = 7;
            Assert.That((a.density, b.density), Is.EqualTo((7f, 7f)));
            Undo.PerformUndo();
            Assert.That((a.density, b.density), Is.EqualTo((5f, 2f)));
            Undo.PerformRedo();
            Assert.That((a.density, b.density), Is.EqualTo((7f, 7f)));
        }

        [Test]
        public void EveryPropertyOfAVolumeIsInItsInspector()
        {
            var (_, panel) = EditorHost.Inspect(Volume());
            var shown = panel.visualTree.Query<PropertyField>().ToList().Select(field => field.bindingPath).Append("m_Preset").ToList();
            Assert.That(Node.FieldsOf(typeof(LumivoxVolume)).Select(field => field.Name), Is.SubsetOf(shown));
            foreach (var field in panel.visualTree.Query<PropertyField>().ToList()) Assert.That(field.tooltip, Is.Not.Empty, field.bindingPath);
        }

        [Test]
        public void WhatIsWrongIsSaid()
        {
            var volume = Volume();
            var (_, panel) = EditorHost.Inspect(volume);
            string Warnings() => string.Join("\n", panel.visualTree.Query<HelpBox>().ToList().Select(box => box.text));
            Assert.That(Warnings(), Does.Contain("There is no scan to show"));
            Assert.That(panel.visualTree.Q("start").resolvedStyle.display, Is.EqualTo(DisplayStyle.Flex));
            volume.density = 0;
            panel.Advance(600);
            Assert.That(Warnings(), Does.Contain("'Density' is 0"));
            panel.Click(panel.visualTree.Q<Button>("phantom").worldBound.center);
            Assert.That(volume.volume, Is.Not.Null);
            Assert.That(panel.visualTree.Q("start").resolvedStyle.display, Is.EqualTo(DisplayStyle.None));
            Undo.PerformUndo();
            Assert.That(volume.volume, Is.Null);
        }

        [Test]
        public void AnInspectorThatIsMadeAnewSaysWhatIsWrongAgain()
        {
            var volume = new GameObject("Volume").AddComponent<LumivoxVolume>();
            var editor = UnityEditor.Editor.CreateEditor(volume);
            for (var time = 0; time < 2; time++)
            {
                var root = editor.CreateInspectorGUI();
                Assert.That(root.Q("warnings").childCount, Is.EqualTo(1), $"time {time}");
            }
            Object.DestroyImmediate(editor);
        }

        [Test]
        public void APresetIsOneStepForAllThatAreSelected()
        {
            LumivoxVolume a = VolumeWithScan("A"), b = VolumeWithScan("B");
            a.density = 5;
            var (_, panel) = EditorHost.Inspect(a, b);
            var preset = panel.visualTree.Q<PresetField>("preset");
            Assert.That(preset.Text, Is.EqualTo("None"));
            Choose(panel, "ct-bone");
            Assert.That((a.preset, b.preset), Is.EqualTo(("ct-bone", "ct-bone")));
            Assert.That(a.transferFunction, Is.Not.Null.And.Not.SameAs(b.transferFunction));
            Assert.That(Undo.Names[0], Is.EqualTo("Apply Preset to 2 Volumes"));
            Undo.PerformUndo();
            Assert.That((a.preset, b.preset, a.density), Is.EqualTo(("", "", 5f)));
            Assert.That(a.transferFunction == null && b.transferFunction == null);
            panel.Advance(600);
            Assert.That(preset.Text, Is.EqualTo("None"));
            // One has another, and is given it too.
            VolumeActions.ApplyPreset(new[] { b }, "ct-skin");
            EditorHost.Frame();
            panel.Advance(600);
            Assert.That((a.preset, b.preset), Is.EqualTo(("", "ct-skin")));
            Assert.That(preset.Text, Is.EqualTo("Several"));
            Choose(panel, "ct-skin");
            Assert.That((a.preset, b.preset, preset.Text), Is.EqualTo(("ct-skin", "ct-skin", "CT skin")));
            Choose(panel, "none");
            Assert.That((a.preset, b.preset, preset.Text), Is.EqualTo(("", "", "None")));
            Assert.That(a.transferFunction, Is.Not.Null, "the look stays");
        }

        /// Unfolds the presets of an inspector or a window, and clicks one.
        static void Choose(Panel panel, string preset)
        {
            panel.Click(panel.visualTree.Q<Button>("open") is Button open && open.parent is PresetField ? open.worldBound.center : panel.visualTree.Q<Button>("presets").worldBound.center);
            var gallery = panel.visualTree.Q<PresetGallery>();
            Assert.That(gallery.isOpen);
            panel.Click(gallery.Q<Button>(preset).worldBound.center);
            Assert.That(!gallery.isOpen && gallery.childCount == 0);
        }

        [Test]
        public void PresetsAreChosenByPicturesOfTheScan()
        {
            var volume = VolumeWithScan();
            var (_, panel) = EditorHost.Inspect(volume);
            var gallery = panel.visualTree.Q<PresetGallery>();
            Assert.That(gallery.resolvedStyle.display, Is.EqualTo(DisplayStyle.None));
            panel.Click(panel.visualTree.Q<Button>("open").worldBound.center);
            var tiles = LumivoxVolume.PresetNames.Select(name => gallery.Q<Button>(name)).ToList();
            // Until there is a picture, the colours are seen.
            Assert.That(tiles.All(tile => tile.tooltip != "" && tile.Q<PresetSwatch>() is var swatch && panel.DrawnBy(swatch).Count == 2), "each shows its function");
            var bone = panel.DrawnBy(gallery.Q<Button>("ct-bone").Q<PresetSwatch>())[1].Vertices.Select(vertex => vertex.tint).ToList();
            var skin = panel.DrawnBy(gallery.Q<Button>("ct-skin").Q<PresetSwatch>())[1].Vertices.Select(vertex => vertex.tint).ToList();
            Assert.That(bone, Is.Not.EqualTo(skin));
            EditorProject.Until(() => tiles.All(tile => tile.Q<Image>().image != null), "the presets are pictured", panel);
            Assert.That(tiles.All(tile => panel.DrawnBy(tile.Q<PresetSwatch>()).Count == 0), "pictures are before nothing");
            var pictures = tiles.Select(tile => ((Texture2D)tile.Q<Image>().image)).ToList();
            Assert.That(pictures.Any(one => !one.GetPixels32().SequenceEqual(pictures[0].GetPixels32())), "they differ");
            // Escape folds them, and what was made for them is freed.
            panel.Focus(gallery.Q<Button>("ct-bone"));
            panel.Key(KeyCode.Escape);
            Assert.That(!gallery.isOpen && pictures.All(one => one == null));
            Assert.That(volume.preset, Is.EqualTo(""));
        }

        [Test]
        public void WithoutAScanPresetsThatNeedOneCannotBeChosen()
        {
            var (_, panel) = EditorHost.Inspect(Volume());
            panel.Click(panel.visualTree.Q<Button>("open").worldBound.center);
            var gallery = panel.visualTree.Q<PresetGallery>();
            Assert.That(gallery.Q<Button>("ct-bone").enabledSelf);
            Assert.That(gallery.Q<Button>("mr-head").enabledSelf, Is.False);
            Assert.That(gallery.Q<Button>("mr-head").tooltip, Does.Contain("give the volume a scan"));
        }

        [Test]
        public void TheProjectWindowPicturesPhantomsAndTransferFunctions()
        {
            var phantom = VolumeActions.Phantom();
            var preview = UnityEditor.Editor.CreateEditor(phantom).RenderStaticPreview(AssetDatabase.GetAssetPath(phantom), null, 64, 64);
            Assert.That(Mathf.Max(preview.width, preview.height), Is.EqualTo(64));
            Assert.That(preview.GetPixels32().Count(pixel => pixel.a > 128), Is.GreaterThan(64 * 64 / 4));
            Assert.That(phantom.state, Is.EqualTo(LumivoxVolumeState.Closed), "the phantom itself is not computed for it");
            Object.DestroyImmediate(preview);
            // Imported scans have their picture from their importer.
            var scan = EditorProject.ImportScan("Assets/head.nrrd");
            Assert.That(UnityEditor.Editor.CreateEditor(scan).RenderStaticPreview("Assets/head.nrrd", null, 64, 64), Is.Null);
            var function = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
            var editor = UnityEditor.Editor.CreateEditor(function);
            Assert.That(editor.RenderStaticPreview("", null, 64, 64), Is.Null, "there is nothing to show");
            function.SetPoints(new[] { new LumivoxTransferFunction.OpacityKnot(0, 0), new LumivoxTransferFunction.OpacityKnot(100, 1) }, new[] { new LumivoxTransferFunction.ColorStop(0, Color.red), new LumivoxTransferFunction.ColorStop(100, Color.blue) });
            preview = editor.RenderStaticPreview("", null, 64, 32);
            Assert.That((preview.width, preview.height), Is.EqualTo((64, 32)));
            Color left = preview.GetPixel(1, 0), right = preview.GetPixel(62, 16), above = preview.GetPixel(8, 28);
            Assert.That(left.r > 0.9f && left.b < 0.3f && right.b > 0.9f && right.r < 0.3f, "colours run from the lowest point to the highest");
            Assert.That(right.a, Is.EqualTo(1f));
            Assert.That(above.a, Is.LessThan(0.5f), "what is above the curve is faint");
            Object.DestroyImmediate(preview);
            Object.DestroyImmediate(function);
        }

        [Test]
        public void APrefabKeepsItsPresetInAnAssetBesideIt()
        {
            var volume = VolumeWithScan();
            UnityEditor.SceneManagement.PrefabStageUtility.current = ScriptableObject.CreateInstance<UnityEditor.SceneManagement.PrefabStage>();
            UnityEditor.SceneManagement.PrefabStageUtility.current.assetPath = "Assets/Head.prefab";
            UnityEditor.SceneManagement.PrefabStageUtility.current.prefabContentsRoot = volume.gameObject;
            try
            {
                VolumeActions.ApplyPreset(new[] { volume }, "ct-skin");
                Assert.That(AssetDatabase.GetAssetPath(volume.transferFunction), Is.EqualTo("Assets/Head ct-skin.asset"));
            }
            finally
            {
                Object.DestroyImmediate(UnityEditor.SceneManagement.PrefabStageUtility.current);
                UnityEditor.SceneManagement.PrefabStageUtility.current = null;
            }
        }

        [Test]
        public void TheClipBoxIsDraggedInTheSceneAndUndone()
        {
            var volume = VolumeWithScan();
            var editor = UnityEditor.Editor.CreateEditor(volume);
            SceneHands.Drag = (ref Vector3 low, ref Vector3 high) => high.x = 0.25f;
            Undo.IncrementCurrentGroup();
            EditorHost.DrawScene(editor, volume);
            Assert.That(volume.clipMax, Is.EqualTo(new Vector3(0.25f, 1, 1)));
            SceneHands.Drag = (ref Vector3 low, ref Vector3 high) => low = new Vector3(-3, -3, 7);
            Undo.IncrementCurrentGroup();
            EditorHost.DrawScene(editor, volume);
            Assert.That(volume.clipMin.x, Is.EqualTo(0));
            Assert.That(volume.clipMin.z, Is.LessThan(1));
            Assert.That(volume.clipMax.z, Is.GreaterThan(volume.clipMin.z));
            Undo.PerformUndo();
            Undo.PerformUndo();
            Assert.That((volume.clipMin, volume.clipMax), Is.EqualTo((Vector3.zero, Vector3.one)));
            Assert.That(SceneHands.Labels, Is.SupersetOf(new[] { "L", "R", "H", "F", "A", "P" }));
            Object.DestroyImmediate(editor);
        }

        [Test]
        public void APictureThatCannotBeMadeBreaksNoInspector()
        {
            var phantom = LumivoxVolumeAsset.Phantom("cube", 16);
            AssetDatabase.CreateAsset(phantom, "Assets/phantom.asset");
            var editor = UnityEditor.Editor.CreateEditor(phantom);
            Faults.missingFormats.Add(UnityEngine.Experimental.Rendering.GraphicsFormat.R8G8B8A8_SRGB);
            Assert.That(editor.RenderStaticPreview("Assets/phantom.asset", null, 64, 64), Is.Null);
            Assert.That(Log.entries.Last(entry => entry.type == LogType.Warning).message, Does.Contain("phantom has no picture").And.Contain("asked for by a test"));
            Faults.missingFormats.Clear();
            var picture = editor.RenderStaticPreview("Assets/phantom.asset", null, 64, 64);
            Assert.That(picture != null);
            Object.DestroyImmediate(picture);
            Object.DestroyImmediate(editor);
        }

        [Test]
        public void AFileThatCannotBeLookedForIsSaidInTheInspector()
        {
            var scan = EditorProject.ImportScan("Assets/head.nrrd");
            var (_, panel) = EditorHost.Inspect(scan);
            var find = LumivoxVolumeAsset.EditorFile;
            try
            {
                LumivoxVolumeAsset.EditorFile = _ => throw new System.UnauthorizedAccessException("Library is locked");
                panel.Click(panel.visualTree.Q<Button>("open").worldBound.center);
                Assert.That(panel.visualTree.Q<Label>("state").text, Does.Contain("Library is locked"));
            }
            finally
            {
                LumivoxVolumeAsset.EditorFile = find;
            }
            panel.Click(panel.visualTree.Q<Button>("open").worldBound.center);
            EditorProject.Until(() => scan.state == LumivoxVolumeState.Ready, "the scan is read", panel);
            Assert.That(panel.visualTree.Q<Label>("state").text, Is.Empty);
        }

        [Test]
        public void PresetsWithoutPicturesSayWhyAndCanBeChosen()
        {
            var volume = VolumeWithScan();
            var (_, panel) = EditorHost.Inspect(volume);
            Faults.missingFormats.Add(UnityEngine.Experimental.Rendering.GraphicsFormat.R8G8B8A8_SRGB);
            panel.Click(panel.visualTree.Q<Button>("open").worldBound.center);
            var tiles = panel.visualTree.Q<PresetGallery>().Query<Button>().ToList().Where(tile => tile.enabledSelf && tile.name != "none").ToList();
            EditorProject.Until(() => tiles.All(tile => tile.tooltip.Contains("no picture")), "all were tried", panel);
            Assert.That(tiles.First().tooltip, Does.Contain("asked for by a test"));
            panel.Click(tiles.First().worldBound.center);
            Assert.That(volume.preset, Is.EqualTo(tiles.First().name));
        }

        [Test]
        public void AScanThatLeftTheProjectIsSaidToHaveLeft()
        {
            var scan = EditorProject.ImportScan("Assets/head.nrrd");
            var (_, panel) = EditorHost.Inspect(scan);
            AssetDatabase.DeleteAsset("Assets/head.nrrd");
            Log.Expect(LogType.Error, "not in the project any more");
            panel.Click(panel.visualTree.Q<Button>("open").worldBound.center);
            Assert.That(panel.visualTree.Q<Label>("state").text, Is.EqualTo("Its file is not in the project any more. Import the scan again."));
        }

        [Test]
        public void TheMenuMakesAVolumeWhereItShouldBe()
        {
            var parent = new GameObject("Table") { layer = 5 };
            EditorHost.Menu("GameObject/Lumivox/Volume", parent);
            var made = Selection.activeGameObject.GetComponent<LumivoxVolume>();
            Assert.That(made.transform.parent, Is.EqualTo(parent.transform));
            Assert.That(made.gameObject.layer, Is.EqualTo(5));
            Assert.That(Undo.Names[0], Is.EqualTo("Create Volume"));
            Undo.PerformUndo();
            Assert.That(made == null);
            EditorHost.Menu("GameObject/Lumivox/Effect");
            Assert.That(Selection.activeGameObject.GetComponent<LumivoxEffect>(), Is.Not.Null);
            Object.DestroyImmediate(Selection.activeGameObject);
            Object.DestroyImmediate(parent);
        }

        [Test]
        public void AnEffectsSettingsAreThereAndSayForWhom()
        {
            var effect = new GameObject("Effect").AddComponent<LumivoxEffect>();
            var (_, panel) = EditorHost.Inspect(effect);
            Assert.That(panel.visualTree.Q<HelpBox>("reach").text, Does.Contain("all cameras"));
            Assert.That(panel.visualTree.Query<PropertyField>().ToList().Count, Is.EqualTo(Node.FieldsOf(typeof(LumivoxSettings)).Count()));
            panel.visualTree.Query<PropertyField>().ToList().Single(one => one.bindingPath.EndsWith("exposure")).Q<FloatField>().value = 2;
            Assert.That(effect.exposure, Is.EqualTo(2));
            Object.DestroyImmediate(effect.gameObject);
        }

        [Test]
        public void AScanSaysWhatItIsAndCountsItsValues()
        {
            var scan = EditorProject.ImportScan("Assets/head.nrrd");
            var (_, panel) = EditorHost.Inspect(scan);
            Assert.That(panel.visualTree.Q<Label>("facts").text, Does.Contain("12 \u00d7 10 \u00d7 8 voxels of 1 \u00d7 1 \u00d7 2 mm, 0 to 959"));
            Assert.That(panel.visualTree.Q("histogram").resolvedStyle.display, Is.EqualTo(DisplayStyle.None));
            panel.Click(panel.visualTree.Q<Button>("open").worldBound.center);
            EditorProject.Until(() => panel.visualTree.Q("histogram").resolvedStyle.display == DisplayStyle.Flex, "values are counted", panel);
            Assert.That(panel.DrawnBy(panel.visualTree.Q("histogram")), Is.Not.Empty);
        }

        static LumivoxTransferFunction Function()
        {
            var function = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
            function.SetPoints(
                new[] { new LumivoxTransferFunction.OpacityKnot(0, 0), new LumivoxTransferFunction.OpacityKnot(500, 0.5f), new LumivoxTransferFunction.OpacityKnot(900, 1) },
                new[] { new LumivoxTransferFunction.ColorStop(0, Color.white) });
            return function;
        }

        static void DragKnot(TransferFunctionField field, int knot, Vector2 by)
        {
            var panel = (Panel)field.panel;
            panel.Update();
            var at = field.Graph.worldBound.position + field.Graph.PlaceOf(knot);
            panel.PointerDown(at);
            for (var i = 1; i <= 3; i++) panel.PointerMove(at + by * (i / 3f));
            panel.PointerUp(at + by);
        }

        [Test]
        public void ADragInTheInspectorIsOneStepOfUndo()
        {
            var function = Function();
            AssetDatabase.CreateAsset(function, "Assets/Function.asset");
            var (_, panel) = EditorHost.Inspect(function);
            var field = panel.visualTree.Q<TransferFunctionField>("editor");
            var before = function.GetState();
            DragKnot(field, 1, new Vector2(20, 10));
            DragKnot(field, 1, new Vector2(20, 10));
            var after = function.GetState();
            Assert.That(after, Is.Not.EqualTo(before));
            Assert.That(EditorUtility.IsDirty(function));
            Assert.That(Undo.Names, Is.EqualTo(new[] { "Move Knot", "Move Knot" }));
            Undo.PerformUndo();
            Undo.PerformUndo();
            Assert.That(function.GetState(), Is.EqualTo(before));
            Assert.That(field.Model.State, Is.EqualTo(before), "the editor shows what undo brought back");
            Undo.PerformRedo();
            Undo.PerformRedo();
            Assert.That(function.GetState(), Is.EqualTo(after));
            // Keys that follow each other are one step, and what is given up is none.
            panel.Click(field.Graph.worldBound.position + field.Graph.PlaceOf(1));
            for (var i = 0; i < 4; i++) panel.Key(KeyCode.UpArrow);
            Assert.That(Undo.Names.Length, Is.EqualTo(3));
            panel.PointerDown(field.Graph.worldBound.position + field.Graph.PlaceOf(1));
            panel.PointerMove(field.Graph.worldBound.position + field.Graph.PlaceOf(1) + new Vector2(30, 0));
            panel.Key(KeyCode.Escape);
            Assert.That(Undo.Names.Length, Is.EqualTo(3));
            Object.DestroyImmediate(function, true);
        }

        [Test]
        public void TheWindowFollowsTheSelectionAndTheFirstEditMakesAFunctionTheVolumesOwn()
        {
            var volume = VolumeWithScan();
            Assert.That(volume.transferFunction, Is.Null);
            EditorHost.Menu("Window/Lumivox/Transfer Function");
            var window = EditorWindow.GetWindow<TransferFunctionWindow>();
            Assert.That(window.rootVisualElement.Q<Label>("message").text, Does.StartWith("Select a Lumivox Volume"));
            Selection.activeGameObject = volume.gameObject;
            window.panel.Advance(400);
            Assert.That(window.rootVisualElement.Q<Label>("notice").text, Does.Contain("which suits its scan"));
            Assert.That(volume.transferFunction, Is.Null, "to look at it changes nothing");
            DragKnot(window.Field, 1, new Vector2(4, 12));
            Assert.That(volume.transferFunction, Is.Not.Null);
            Assert.That(volume.transferFunction, Is.SameAs(window.Field.transferFunction));
            Undo.PerformUndo();
            Assert.That(volume.transferFunction == null, "one undo takes the edit and the function back");
            window.panel.Advance(400);
            Assert.That(window.Field.transferFunction, Is.Not.Null);
            // Another volume's is shown when that is selected.
            var other = Volume("Other");
            other.transferFunction = Function();
            Selection.activeGameObject = other.gameObject;
            window.panel.Advance(400);
            Assert.That(window.Field.transferFunction, Is.SameAs(other.transferFunction));
            Object.DestroyImmediate(other.gameObject);
            window.panel.Advance(400);
            Assert.That(window.rootVisualElement.Q<Label>("message").text, Does.StartWith("Select a Lumivox Volume"));
        }

        [Test]
        public void PresetsOfTheWindowSetTheWholeMedium()
        {
            var volume = VolumeWithScan();
            volume.density = 9;
            Selection.activeGameObject = volume.gameObject;
            TransferFunctionWindow.Open();
            var window = EditorWindow.GetWindow<TransferFunctionWindow>();
            window.panel.Advance(400);
            Choose(window.panel, "ct-bone");
            Assert.That(volume.preset, Is.EqualTo("ct-bone"));
            Assert.That(window.Field.transferFunction, Is.SameAs(volume.transferFunction));
            Undo.PerformUndo();
            Assert.That((volume.preset, volume.density), Is.EqualTo(("", 9f)));
        }

        [Test]
        public void FunctionsAreSavedAndLoadedAsFiles()
        {
            var function = Function();
            AssetDatabase.CreateAsset(function, "Assets/Function.asset");
            var (_, panel) = EditorHost.Inspect(function);
            var before = function.GetState();
            var file = System.IO.Path.Combine(System.IO.Path.GetTempPath(), System.IO.Path.GetRandomFileName() + ".json");
            Dialogs.Paths.Enqueue(file);
            panel.Click(panel.visualTree.Q<Button>("save").worldBound.center);
            function.SetPoints(new[] { new LumivoxTransferFunction.OpacityKnot(1, 1) }, null);
            Dialogs.Paths.Enqueue(file);
            panel.Click(panel.visualTree.Q<Button>("load").worldBound.center);
            Assert.That(function.GetState(), Is.EqualTo(before));
            Assert.That(Undo.Names[0], Is.EqualTo("Load Transfer Function"));
            System.IO.File.WriteAllText(file, "no function");
            Dialogs.Paths.Enqueue(file);
            panel.Click(panel.visualTree.Q<Button>("load").worldBound.center);
            Assert.That(Dialogs.Shown.Single().message, Does.Contain("was not loaded"));
            Assert.That(function.GetState(), Is.EqualTo(before));
            System.IO.File.Delete(file);
            Object.DestroyImmediate(function, true);
        }
    }
}
