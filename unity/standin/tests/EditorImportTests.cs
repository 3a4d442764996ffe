// Scans as assets: importers, the import window, and what a build takes along.
using System.IO;
using System.Linq;
using Lumivox.Editor;
using NUnit.Framework;
using StandIn;
using UnityEditor;
using UnityEditor.Build;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Tests
{
    public sealed class EditorImportTests
    {
        string outside;

        [SetUp]
        public void Begin()
        {
            EditorProject.Begin();
            outside = Path.Combine(Path.GetTempPath(), Path.GetRandomFileName());
            Directory.CreateDirectory(outside);
        }

        [TearDown]
        public void End()
        {
            if (EditorWindow.HasOpenInstances<ImportWindow>()) EditorWindow.GetWindow<ImportWindow>().Close();
            Directory.Delete(outside, true);
        }

        static void IsTheScan(LumivoxVolumeAsset scan)
        {
            Assert.That(scan, Is.Not.Null, string.Join("\n", Dialogs.ImportErrors));
            Assert.That(scan.dimensions, Is.EqualTo(new Vector3Int(12, 10, 8)));
            Assert.That(scan.spacingMm.z, Is.EqualTo(2).Within(1e-5));
            Assert.That(scan.valueRange, Is.EqualTo(new Vector2(0, 959)));
        }

        static void CanBeRead(LumivoxVolumeAsset scan)
        {
            var opened = scan.Open();
            EditorProject.Until(() => opened.IsCompleted, "the scan is read");
            Assert.That(opened.Result, Is.True, scan.error);
            Assert.That(scan.GetHistogram(4, new Vector2(-0.5f, 959.5f)), Is.EqualTo(new[] { 240f, 240f, 240f, 240f }));
        }

        /// The project window shows the scan of 12 x 10 x 16 mm from the front.
        static void IsPictured(string path)
        {
            var picture = AssetDatabase.entries[path].import.thumbnail;
            Assert.That(picture != null, $"{path} has no picture");
            Assert.That(picture.height, Is.EqualTo(128));
            Assert.That(picture.width, Is.InRange(80, 110));
            // Values rise towards the head, and low ones are not seen.
            float Light(int row) => Enumerable.Range(0, picture.width).Sum(x => picture.GetPixel(x, row).a * picture.GetPixel(x, row).grayscale);
            Assert.That(Light(110), Is.GreaterThan(0.2f * picture.width).And.GreaterThan(Light(4)));
        }

        [Test]
        public void AFileBecomesAnAssetWhoseVoxelsLieInAFileOfTheirOwn()
        {
            var scan = EditorProject.ImportScan("Assets/Scans/head.nrrd");
            IsTheScan(scan);
            var stored = StoredScans.FileOf(AssetDatabase.AssetPathToGUID("Assets/Scans/head.nrrd"));
            Assert.That(stored, Does.Contain("Library").And.EndWith(".lumivox"));
            Assert.That(File.Exists(stored));
            Assert.That(scan.isStored);
            CanBeRead(scan);
            IsPictured("Assets/Scans/head.nrrd");
            Assert.That(Dialogs.ProgressBars.Last().title, Is.Null, "the progress bar was taken away");
        }

        [Test]
        public void CompressedNiftiIsTakenByItsWholeNameAndOtherArchivesAreNot()
        {
            File.WriteAllBytes(EditorProject.Full("Assets/head.nii.gz"), EditorProject.NiftiGz());
            File.WriteAllText(EditorProject.Full("Assets/saves.gz"), "a game's own");
            File.WriteAllText(EditorProject.Full("Assets/levels.zip"), "a game's own");
            AssetDatabase.Refresh();
            var scan = AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>("Assets/head.nii.gz");
            Assert.That(scan, Is.Not.Null, string.Join("\n", Dialogs.ImportErrors));
            Assert.That(scan.dimensions, Is.EqualTo(new Vector3Int(12, 10, 8)));
            Assert.That(AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>("Assets/saves.gz"), Is.Null);
            Assert.That(AssetDatabase.GetImporterOverride("Assets/levels.zip"), Is.Null);
            Assert.That(Dialogs.ImportErrors, Is.Empty);
            // Somebody says that one is a scan, and takes it back.
            Selection.activeObject = AssetDatabase.LoadMainAssetAtPath("Assets/levels.zip");
            Assert.That(EditorHost.IsMenuEnabled("Assets/Lumivox/Import as Scan"));
            EditorHost.Menu("Assets/Lumivox/Import as Scan");
            Assert.That(Dialogs.ImportErrors.Single(), Does.Contain("levels.zip was not imported").And.Contain("choose another 'Importer'"));
            Assert.That(AssetDatabase.GetImporterOverride("Assets/levels.zip"), Is.EqualTo(typeof(ScanImporter)));
        }

        [Test]
        public void AHeaderDependsOnItsDataFile()
        {
            EditorProject.WriteMetaImage("Assets/head.mhd");
            AssetDatabase.ImportAsset("Assets/head.mhd");
            IsTheScan(AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>("Assets/head.mhd"));
            Assert.That(AssetDatabase.entries["Assets/head.mhd"].import.SourceDependencies, Is.EqualTo(new[] { "Assets/voxels.bin" }));
        }

        [Test]
        public void WhatIsNoScanIsSaidInTheLibrarysWords()
        {
            File.WriteAllText(EditorProject.Full("Assets/broken.nrrd"), "NRRD0004\ntype: nonsense\n\n");
            AssetDatabase.ImportAsset("Assets/broken.nrrd");
            Assert.That(AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>("Assets/broken.nrrd"), Is.Null);
            Assert.That(Dialogs.ImportErrors.Single(), Does.StartWith("broken.nrrd was not imported: "));
            // Mended, it is imported by itself.
            File.WriteAllBytes(EditorProject.Full("Assets/broken.nrrd"), EditorProject.Nrrd());
            AssetDatabase.ImportAsset("Assets/broken.nrrd");
            IsTheScan(AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>("Assets/broken.nrrd"));
        }

        [Test]
        public void DecodersThatMayCrashRunInTheProgramBesideTheLibrary()
        {
            string package = EditorProject.Full("Package"), project = EditorProject.Full("Plugins");
            Assert.That(CodecProgram.Find(package, project), Is.Null);
            Assert.That(CodecProgram.Find(null, project), Is.Null);
            string Put(string path)
            {
                Directory.CreateDirectory(Path.GetDirectoryName(path));
                File.WriteAllText(path, "");
                return path;
            }
            var ofProject = Put(Path.Combine(project, "lumivox-codecs"));
            Assert.That(CodecProgram.Find(package, project), Is.EqualTo(ofProject));
            var ofPackage = Put(Path.Combine(package, "Linux/x86_64/lumivox-codecs"));
            Assert.That(CodecProgram.Find(package, project), Is.EqualTo(ofPackage));
            Assert.That(CodecProgram.Find(null, project), Is.EqualTo(ofProject));
            Directory.Delete(package, true);
            Directory.Delete(project, true);
            // Begin() did what the editor does when scripts are loaded.
            var there = Path.Combine(UnityEditor.PackageManager.PackageInfo.FindForAssembly(typeof(CodecProgram).Assembly).resolvedPath, "Runtime/Plugins/Linux/x86_64/lumivox-codecs");
            Assert.That(Native.Border.CodecProgram, File.Exists(there) ? Is.EqualTo(there) : Is.Null);
        }

        [Test]
        public void WhoStopsAnImportIsToldHowToTryAgain()
        {
            Dialogs.CancelsProgress = true;
            File.WriteAllBytes(EditorProject.Full("Assets/head.nrrd"), EditorProject.Nrrd());
            AssetDatabase.ImportAsset("Assets/head.nrrd");
            // So small a scan may be there before anybody could stop it.
            if (AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>("Assets/head.nrrd") == null)
                Assert.That(Dialogs.ImportErrors.Single(), Does.Contain("it was stopped").And.Contain("Reimport"));
            else
                Assert.That(Dialogs.ImportErrors, Is.Empty);
        }

        ImportWindow Open(string path)
        {
            var window = ImportWindow.Open(path);
            EditorProject.Until(() => window.Now != ImportWindow.Step.Scanning, "the file is looked at", window.panel);
            return window;
        }

        void SaveInto(ImportWindow window, string target)
        {
            window.rootVisualElement.Q<TextField>("target").value = target;
            window.panel.Click(window.rootVisualElement.Q<Button>("import").worldBound.center);
            EditorProject.Until(() => window.Now == ImportWindow.Step.Choose || window.Now == ImportWindow.Step.Ready, "the scan is imported and saved", window.panel);
        }

        static string Problem(ImportWindow window)
        {
            var box = window.rootVisualElement.Q<HelpBox>("problems");
            return box.resolvedStyle.display == DisplayStyle.Flex ? box.text : "";
        }

        [Test]
        public void TheWindowShowsWhatIsThereAndSavesItAsAnAsset()
        {
            var file = Path.Combine(outside, "scan.nrrd");
            File.WriteAllBytes(file, EditorProject.Nrrd());
            Dialogs.Paths.Enqueue(file);
            EditorHost.Menu("Assets/Lumivox/Import Scan File...");
            var window = EditorWindow.GetWindow<ImportWindow>();
            EditorProject.Until(() => window.Now == ImportWindow.Step.Ready, "the file is looked at", window.panel);
            Assert.That(window.Report.series.Length, Is.EqualTo(1));
            var list = window.rootVisualElement.Q<ListView>("series");
            Assert.That(list.GetRootElementForIndex(0).Q<Label>("line").text, Does.Contain("12 \u00d7 10 \u00d7 8"));
            Assert.That(window.rootVisualElement.Q<Label>("details").text, Does.Contain("voxels of 1 \u00d7 1 \u00d7 2 mm"));
            EditorProject.Until(() => window.rootVisualElement.Q<Image>("thumbnail").image != null, "the slice is pictured", window.panel);
            SaveInto(window, "Assets/Patients/head");
            Assert.That(Problem(window), Is.Empty);
            var scan = AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>("Assets/Patients/head.lumivox");
            IsTheScan(scan);
            // Its file is the asset itself.
            Assert.That(StoredScans.FileOf(AssetDatabase.AssetPathToGUID("Assets/Patients/head.lumivox")), Is.EqualTo(EditorProject.Full("Assets/Patients/head.lumivox")));
            CanBeRead(scan);
            IsPictured("Assets/Patients/head.lumivox");
            var volume = Selection.activeGameObject.GetComponent<LumivoxVolume>();
            Assert.That(volume.volume, Is.EqualTo(scan));
            Undo.PerformUndo();
            Assert.That(volume == null, "an object that was added goes with undo");
            Assert.That(AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>("Assets/Patients/head.lumivox"), Is.Not.Null);
        }

        [Test]
        public void WhatIsDroppedOnTheWindowIsLookedAt()
        {
            var file = Path.Combine(outside, "scan.nrrd");
            File.WriteAllBytes(file, EditorProject.Nrrd());
            var window = ImportWindow.Open("");
            var middle = window.rootVisualElement.Q<ListView>("series").worldBound.center;
            float Border() => window.rootVisualElement.style.borderTopWidth.value;
            Assert.That(Drags.Over(window, middle, file), Is.EqualTo(DragAndDropVisualMode.Copy));
            Assert.That(Border(), Is.GreaterThan(0), "it is seen that it would be taken");
            Drags.Leave(window);
            Assert.That((Border(), window.Now), Is.EqualTo((0f, ImportWindow.Step.Choose)));
            Assert.That(Drags.Over(window, middle, Path.Combine(outside, "missing")), Is.EqualTo(DragAndDropVisualMode.Rejected));
            Assert.That(Drags.Over(window, middle), Is.EqualTo(DragAndDropVisualMode.Rejected), "objects of a scene have no path");
            // Over a field, too, whose text it does not become.
            Drags.Drop(window, window.rootVisualElement.Q<TextField>("path").worldBound.center, file);
            Assert.That(Drags.IsAccepted);
            Assert.That(Drags.Over(window, middle, file), Is.EqualTo(DragAndDropVisualMode.Rejected), "one scan at a time");
            Drags.Leave(window);
            EditorProject.Until(() => window.Now == ImportWindow.Step.Ready, "the file is looked at", window.panel);
            Assert.That(window.rootVisualElement.Q<TextField>("path").value, Is.EqualTo(file));
            Assert.That(window.Report.series.Length, Is.EqualTo(1));
            Assert.That(Border(), Is.EqualTo(0));
            // From the project window, whose paths begin at the project's folder.
            File.WriteAllBytes(EditorProject.Full("Assets/scan.bin"), EditorProject.Nrrd());
            Drags.Drop(window, middle, "Assets/scan.bin");
            EditorProject.Until(() => window.Now == ImportWindow.Step.Ready, "the file is looked at", window.panel);
            Assert.That(window.rootVisualElement.Q<TextField>("path").value, Is.EqualTo(EditorProject.Full("Assets/scan.bin")));
        }

        [Test]
        public void AFolderAnArchiveAndTheFilesOfASeriesCanBeDropped()
        {
            var folder = Path.Combine(outside, "series");
            Directory.CreateDirectory(Path.Combine(outside, "other"));
            Directory.CreateDirectory(folder);
            var files = Enumerable.Range(0, 3).Select(i => Path.Combine(folder, $"{i}")).ToArray();
            foreach (var file in files) File.WriteAllText(file, "no slice");
            File.WriteAllText(Path.Combine(outside, "other", "one"), "no slice");
            var archive = Path.Combine(outside, "scan.zip");
            using (var zip = System.IO.Compression.ZipFile.Open(archive, System.IO.Compression.ZipArchiveMode.Create))
            using (var entry = zip.CreateEntry("scan.nrrd").Open()) entry.Write(EditorProject.Nrrd(), 0, EditorProject.Nrrd().Length);
            var window = ImportWindow.Open("");
            var middle = window.rootVisualElement.worldBound.center;
            string Looked(params string[] paths)
            {
                Drags.Drop(window, middle, paths);
                EditorProject.Until(() => window.Now != ImportWindow.Step.Scanning, "it is looked at", window.panel);
                return window.rootVisualElement.Q<TextField>("path").value;
            }
            Assert.That(Looked(archive), Is.EqualTo(archive));
            Assert.That(Looked(folder), Is.EqualTo(folder));
            Assert.That(Looked(archive), Is.EqualTo(archive));
            Assert.That(Looked(files), Is.EqualTo(folder), "slices are those of their folder");
            Assert.That(Problem(window), Is.Not.Empty, "and these are none");
            Assert.That(Drags.Over(window, middle, files[0], Path.Combine(outside, "other", "one")), Is.EqualTo(DragAndDropVisualMode.Rejected));
            Assert.That(Drags.Over(window, middle, folder, archive), Is.EqualTo(DragAndDropVisualMode.Rejected));
        }

        [Test]
        public void WhatCannotBeImportedIsSaidAndTheWindowGoesOn()
        {
            var window = Open(Path.Combine(outside, "missing"));
            Assert.That(Problem(window), Does.Contain("There is no folder or file"));
            window = Open(outside);
            Assert.That(window.Now, Is.EqualTo(ImportWindow.Step.Choose));
            Assert.That(Problem(window), Is.Not.Empty);
            File.WriteAllBytes(Path.Combine(outside, "scan.nrrd"), EditorProject.Nrrd());
            window = Open(Path.Combine(outside, "scan.nrrd"));
            Assert.That(Problem(window), Is.Empty);
            SaveInto(window, "../elsewhere");
            Assert.That(Problem(window), Does.Contain("inside the project"));
            Assert.That(window.Now, Is.EqualTo(ImportWindow.Step.Ready));
        }

        [Test]
        public void AScanThatCannotBeWrittenIsNotReadAgain()
        {
            var file = Path.Combine(outside, "scan.nrrd");
            File.WriteAllBytes(file, EditorProject.Nrrd());
            var window = Open(file);
            File.WriteAllText(EditorProject.Full("Assets/taken"), "a file where a folder should be");
            SaveInto(window, "Assets/taken/head");
            Assert.That(Problem(window), Does.Contain("could not be written"));
            File.Delete(file);
            SaveInto(window, "Assets/head");
            Assert.That(Problem(window), Is.Empty);
            IsTheScan(AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>("Assets/head.lumivox"));
        }

        [Test]
        public void AFileThatIsThereIsReplacedOnlyWhenSomebodySaysSo()
        {
            var file = Path.Combine(outside, "scan.nrrd");
            File.WriteAllBytes(file, EditorProject.Nrrd());
            var window = Open(file);
            SaveInto(window, "Assets/head");
            window = Open(file);
            Dialogs.Answers.Enqueue(false);
            window.rootVisualElement.Q<TextField>("target").value = "Assets/head";
            window.Import();
            Assert.That(window.Now, Is.EqualTo(ImportWindow.Step.Ready));
            Assert.That(Dialogs.Shown.Single().message, Does.Contain("Replace"));
        }

        [Test]
        public void AWindowThatIsClosedWhileItSavesLosesNothing()
        {
            var file = Path.Combine(outside, "scan.nrrd");
            File.WriteAllBytes(file, EditorProject.Nrrd());
            var window = Open(file);
            window.rootVisualElement.Q<TextField>("target").value = "Assets/head.lumivox";
            window.Import();
            EditorProject.Until(() => window.Now == ImportWindow.Step.Saving || window.Now == ImportWindow.Step.Choose, "it is saved", null);
            window.Close();
            Object.DestroyImmediate(window);
            EditorProject.Until(() => AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>("Assets/head.lumivox") != null, "the scan is in the project");
        }

        /// Nobody but who made them ends those: neither a change of scenes nor a reload does.
        internal static int LastingPictures => Objects.All().OfType<Texture2D>().Count(texture => texture != null && texture.hideFlags == HideFlags.DontSave);

        [TestCase("another choice")]
        [TestCase("another scan")]
        [TestCase("close")]
        [TestCase("close at once")]
        public void NoPictureOutlivesWhatShowsIt(string end)
        {
            var before = LastingPictures;
            var file = Path.Combine(outside, "scan.nrrd");
            File.WriteAllBytes(file, EditorProject.Nrrd());
            var window = Open(file);
            var list = window.rootVisualElement.Q<ListView>("series");
            if (end == "close at once")
            {
                // One that is on its way.
                window.Close();
                for (var i = 0; i < 50; i++)
                {
                    EditorHost.Frame();
                    System.Threading.Thread.Sleep(5);
                }
                Assert.That(LastingPictures, Is.EqualTo(before));
                return;
            }
            void Pictured() => EditorProject.Until(() => window.rootVisualElement.Q<Image>("thumbnail").image != null, "the slice is pictured", window.panel);
            Pictured();
            Assert.That(LastingPictures, Is.EqualTo(before + 1));
            if (end == "another choice")
            {
                list.SetSelection(-1);
                Assert.That(LastingPictures, Is.EqualTo(before));
                list.SetSelection(0);
                Pictured();
                Assert.That(LastingPictures, Is.EqualTo(before + 1));
            }
            else if (end == "another scan")
            {
                window.Scan();
                Assert.That(LastingPictures, Is.EqualTo(before));
                EditorProject.Until(() => window.Now == ImportWindow.Step.Ready, "the file is looked at", window.panel);
                Pictured();
                Assert.That(LastingPictures, Is.EqualTo(before + 1));
            }
            window.Close();
            Assert.That(LastingPictures, Is.EqualTo(before));
        }

        [Test]
        public void AnImportersPictureEndsWithItsImport()
        {
            var before = LastingPictures;
            IsTheScan(EditorProject.ImportScan("Assets/head.nrrd"));
            EditorHost.Frame();
            Assert.That(LastingPictures, Is.EqualTo(before));
            IsPictured("Assets/head.nrrd");
        }

        [Test]
        public void AScanThatCannotBePicturedIsImportedAllTheSame()
        {
            // Small scans are decoded without one: the first texture is the picture.
            Faults.missingFormats.Add(UnityEngine.Experimental.Rendering.GraphicsFormat.R8G8B8A8_SRGB);
            IsTheScan(EditorProject.ImportScan("Assets/head.nrrd"));
            Assert.That(AssetDatabase.entries["Assets/head.nrrd"].import.Warnings, Has.Some.Contains("head.nrrd has no picture").And.Contains("asked for by a test"));
            Assert.That(Dialogs.ImportErrors, Is.Empty);
        }

        [Test]
        public void ABuildTakesAlongTheScansThatItUsesAndNoOthers()
        {
            EditorProject.ImportScan("Assets/used.nrrd");
            EditorProject.ImportScan("Assets/unused.nrrd");
            EditorProject.ImportScan("Assets/Resources/loaded.nrrd");
            AssetDatabase.dependencies["Assets/Main.unity"] = new[] { "Assets/Head.prefab" };
            AssetDatabase.dependencies["Assets/Head.prefab"] = new[] { "Assets/used.nrrd", "Assets/phantom.asset" };
            AssetDatabase.CreateAsset(LumivoxVolumeAsset.Phantom("cube", 16), "Assets/phantom.asset");
            var build = new BuildPlayerContext(new BuildPlayerOptions { scenes = new[] { "Assets/Main.unity" } });
            foreach (var type in EditorTypes.Of<BuildPlayerProcessor>()) ((BuildPlayerProcessor)System.Activator.CreateInstance(type)).PrepareForBuild(build);
            var ids = new[] { "Assets/used.nrrd", "Assets/Resources/loaded.nrrd" }.Select(AssetDatabase.AssetPathToGUID);
            Assert.That(build.Added.Select(file => file.to), Is.EquivalentTo(ids.Select(id => $"lumivox/{id}.lumivox")));
            File.Delete(StoredScans.FileOf(ids.First()));
            var error = Assert.Throws<BuildFailedException>(() => { foreach (var type in EditorTypes.Of<BuildPlayerProcessor>()) ((BuildPlayerProcessor)System.Activator.CreateInstance(type)).PrepareForBuild(build); });
            Assert.That(error.Message, Does.Contain("Assets/used.nrrd").And.Contain("reimport"));
        }

        sealed class Teller : AssetPostprocessor
        {
            public static System.Action Told;
            static void OnPostprocessAllAssets(string[] importedAssets, string[] deletedAssets, string[] movedAssets, string[] movedFromAssetPaths) => Told?.Invoke();
        }

        [Test]
        public void AWindowThatIsOpenedWhileFilesAreImportedLooksWhenItHasContents()
        {
            File.WriteAllBytes(EditorProject.Full("Assets/scan.bin"), EditorProject.Nrrd());
            ImportWindow window = null;
            Teller.Told = () => window = ImportWindow.Open(EditorProject.Full("Assets/scan.bin"));
            try { EditorProject.ImportScan("Assets/other.nrrd"); }
            finally { Teller.Told = null; }
            EditorProject.Until(() => window.Now == ImportWindow.Step.Ready, "it has looked", window.panel);
            window.Close();
        }
    }
}
