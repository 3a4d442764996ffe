// What a reload of the scripts' domain does to the editor's half.
using System.Linq;
using Lumivox.Editor;
using NUnit.Framework;
using StandIn;
using UnityEditor;
using UnityEngine;

namespace Lumivox.Tests
{
    public sealed class EditorReloadTests
    {
        [SetUp]
        public void Begin() => EditorProject.Begin();

        [TearDown]
        public void End()
        {
            foreach (var volume in Object.FindObjectsByType<LumivoxVolume>(FindObjectsSortMode.None)) Object.DestroyImmediate(volume.gameObject);
        }

        [Test]
        public void AVolumeInTheSceneIsReadAgainFromTheEditorsFile()
        {
            var volume = new GameObject("Head").AddComponent<LumivoxVolume>();
            volume.volume = EditorProject.ImportScan("Assets/head.nrrd");
            EditorProject.Until(() => volume.volume.state == LumivoxVolumeState.Ready, "the scan is read");
            Domain.Reload();
            var after = Object.FindObjectsByType<LumivoxVolume>(FindObjectsSortMode.None).Single();
            Assert.That(after, Is.Not.SameAs(volume), "it is another instance");
            Assert.That(after.volume, Is.Not.Null);
            Assert.That(AssetDatabase.GetAssetPath(after.volume), Is.EqualTo("Assets/head.nrrd"));
            EditorProject.Until(() => after.volume.state == LumivoxVolumeState.Ready, "the scan is read again");
            Assert.That(after.volume.dimensions, Is.EqualTo(new Vector3Int(12, 10, 8)));
        }

        [Test]
        public void AScanKnowsHowItWasImportedWhenScriptsAreLoadedAnew()
        {
            var scan = EditorProject.ImportScan("Assets/head.nrrd");
            var opened = scan.Open();
            EditorProject.Until(() => opened.IsCompleted, "the scan is read");
            // Nobody has asked since it was read: Unity makes something of nothing.
            Domain.Reload();
            scan = AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>("Assets/head.nrrd");
            Assert.That(scan.GetReport().format, Is.EqualTo("NRRD"));
        }

        /// A scan of as many slices.
        static void Write(string path, int slices) => System.IO.File.WriteAllBytes(EditorProject.Full(path), EditorProject.Nrrd(slices: slices));

        [TestCase(true)]
        [TestCase(false)]
        public void AScanIsTheSameWhenItsFileBecomesAnother(bool isShown)
        {
            const string path = "Assets/head.nrrd";
            var scan = EditorProject.ImportScan(path);
            var volume = new GameObject("Head").AddComponent<LumivoxVolume>();
            if (isShown)
            {
                volume.volume = scan;
                EditorProject.Until(() => scan.state == LumivoxVolumeState.Ready, "the scan is read");
            }
            Assert.That(scan.GetReport().chosenSeries.dims[2], Is.EqualTo(8));
            var before = scan.Handle;
            Write(path, 4);
            AssetDatabase.ImportAsset(path);
            Assert.That(AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>(path), Is.SameAs(scan));
            Assert.That(scan.GetReport().chosenSeries.dims[2], Is.EqualTo(4));
            Assert.That(scan.dimensions.z, Is.EqualTo(4));
            if (isShown) EditorProject.Until(() => scan.state == LumivoxVolumeState.Ready && scan.Handle != before, "its new file is read");
            // What cannot be imported is gone.
            System.IO.File.WriteAllText(EditorProject.Full(path), "nothing");
            AssetDatabase.ImportAsset(path);
            Assert.That(scan == null && volume.volume == null);
            EditorHost.Frame();
        }

        [Test]
        public void TheImportWindowStaysAndItsPictureEnds()
        {
            var before = EditorImportTests.LastingPictures;
            System.IO.File.WriteAllBytes(EditorProject.Full("Assets/scan.bin"), EditorProject.Nrrd());
            var window = ImportWindow.Open(EditorProject.Full("Assets/scan.bin"));
            EditorProject.Until(() => EditorImportTests.LastingPictures > before, "the slice is pictured", window.panel);
            Domain.Reload();
            Assert.That(EditorImportTests.LastingPictures, Is.EqualTo(before));
            window = EditorWindow.GetWindow<ImportWindow>();
            Assert.That(window.Now, Is.EqualTo(ImportWindow.Step.Choose));
            window.Scan();
            EditorProject.Until(() => EditorImportTests.LastingPictures > before, "it can be looked at again", window.panel);
            window.Close();
            Assert.That(EditorImportTests.LastingPictures, Is.EqualTo(before));
        }

        [Test]
        public void AnImportThatIsUnderWayEndsWithTheDomain()
        {
            var volume = new GameObject("Head").AddComponent<LumivoxVolume>();
            volume.volume = LumivoxVolumeAsset.Phantom("head", 64);
            Assert.That(volume.volume.state, Is.EqualTo(LumivoxVolumeState.Loading));
            Domain.Reload();
            // Nobody waits for what the old domain began; the new one begins anew.
            var after = Object.FindObjectsByType<LumivoxVolume>(FindObjectsSortMode.None).Single();
            EditorProject.Until(() => after.volume.state == LumivoxVolumeState.Ready, "the phantom is computed again");
        }
    }
}
