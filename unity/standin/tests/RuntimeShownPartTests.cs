// What of a scan is seen in place of the patient: all that was scanned, or one organ, while other threads compute it.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Text;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed class RuntimeShownPartTests : CubeScene
    {
        const int Voxels = 64;
        readonly List<Object> made = new List<Object>();
        string folder;

        [SetUp]
        public void BeginParts()
        {
            LumivoxRenderer.RenderAtOnce = true;
            folder = Path.Combine(Path.GetTempPath(), Path.GetRandomFileName());
            Directory.CreateDirectory(folder);
        }

        [TearDown]
        public void EndParts()
        {
            LumivoxRenderer.RenderAtOnce = false;
            foreach (var one in made) Object.DestroyImmediate(one);
            made.Clear();
            Directory.Delete(folder, true);
        }

        /// What is as dense as a table, of 256 mm of patient from her feet.
        void LookForTables()
        {
            volume.transform.localScale = Vector3.one;
            volume.transform.rotation = Quaternion.Euler(-90f, 0f, 0f);
            camera.transform.position = new Vector3(0f, 0f, -0.7f);
            look.SetPoints(new[] { new LumivoxTransferFunction.OpacityKnot(80f, 0f), new LumivoxTransferFunction.OpacityKnot(100f, 1f) }, new[] { new LumivoxTransferFunction.ColorStop(0f, Color.white) });
            volume.maxBounces = 2;
        }

        T Kept<T>(T one) where T : Object
        {
            made.Add(one);
            return one;
        }

        /// Muscle and fat above a table.
        LumivoxVolumeAsset Patient(bool keepEverything = false)
        {
            var path = Path.Combine(folder, "patient.raw");
            File.WriteAllBytes(path, RuntimeImportTests.Patient(Voxels));
            using (var importer = new LumivoxImporter())
            {
                var options = new LumivoxImportOptions { raw = $"{Voxels}x{Voxels}x{Voxels}:i16le:spacing=4,4,4:modality=CT", keepEverything = keepEverything };
                var loading = importer.Load(new[] { path }, options);
                RuntimeComponentTests.Wait(() => loading.IsCompleted);
                return Kept(loading.Result);
            }
        }

        LumivoxVolumeAsset Opened(string path)
        {
            var loading = LumivoxVolumeAsset.LoadFile(path);
            RuntimeComponentTests.Wait(() => loading.IsCompleted);
            return Kept(loading.Result);
        }

        string Saved(LumivoxVolumeAsset of)
        {
            var path = Path.Combine(folder, "patient.lumivox");
            var saving = of.Save(path);
            RuntimeComponentTests.Wait(() => saving.IsCompleted);
            Assert.IsNull(saving.Exception);
            return path;
        }

        /// The brightest of what is seen where the table is, and nothing else that is as dense.
        float Table()
        {
            Settle();
            var picture = Pictures.Color(camera);
            return Enumerable.Range(0, Side * Side).Max(i => Light(picture.At(i % Side, i / Side)));
        }

        void Ready() => RuntimeComponentTests.Wait(() => !volume.isPreparing);

        const float Bright = 0.02f, Dark = 1e-3f;

        [Test]
        public void WhatLiesAroundComesBackAndGoesAgainWhileItIsLookedAt()
        {
            LookForTables();
            Assert.IsFalse(volume.keepEverything);
            volume.volume = Patient();
            Assert.IsTrue(volume.volume.hasSurroundings);
            Assert.IsTrue(Table() < Dark, "the patient alone");
            Assert.AreEqual(0, Jobs.Count);
            volume.keepEverything = true;
            Assert.IsTrue(volume.isPreparing);
            Assert.AreEqual("What lies around the patient is being put back.", volume.Preparing);
            // Meanwhile the scan is seen without, and no frame waits: news come between frames only.
            Engine.Frame();
            Assert.IsTrue(volume.isPreparing);
            Assert.AreEqual(1, Jobs.Count);
            Ready();
            Assert.IsTrue(Table() > Bright, "the table");
            CollectionAssert.IsEmpty(volume.GetWarnings());
            Garbage.IsLeftByNone(10, 20, _ => { }, () => { });
            volume.keepEverything = false;
            Assert.IsFalse(volume.isPreparing);
            Assert.IsTrue(Table() < Dark, "the patient alone again");
            // What is not seen is not computed.
            volume.keepEverything = true;
            volume.enabled = false;
            Assert.IsFalse(volume.isPreparing);
            volume.enabled = true;
            Ready();
            Assert.IsTrue(Table() > Bright);
            Assert.AreEqual("", LumivoxRenderer.LastError);
        }

        [Test]
        public void AStoredScanHasItsSurroundingsAndOneThatKeptEverythingNone()
        {
            LookForTables();
            var path = Saved(Patient());
            volume.volume = Opened(path);
            Assert.IsTrue(volume.volume.hasSurroundings);
            Assert.IsTrue(Table() < Dark);
            volume.keepEverything = true;
            Ready();
            Assert.IsTrue(Table() > Bright);
            volume.keepEverything = false;
            // Nothing was taken out of this one, so that nothing is to be put back.
            volume.volume = Patient(true);
            Assert.IsFalse(volume.volume.hasSurroundings);
            Assert.IsTrue(Table() > Bright);
            volume.keepEverything = true;
            Assert.IsFalse(volume.isPreparing);
            Assert.AreEqual(0, Jobs.Count);
            Assert.IsTrue(Table() > Bright);
            CollectionAssert.IsEmpty(volume.GetWarnings());
        }

        /// A stored scan as older versions wrote it.
        static byte[] WithoutSurroundings(byte[] stored)
        {
            var length = (int)BitConverter.ToUInt64(stored, 8);
            var header = Encoding.UTF8.GetString(stored, 16, length);
            var at = header.IndexOf(",\"surroundings\":{", StringComparison.Ordinal);
            Assert.IsTrue(at > 0, header);
            var older = Encoding.UTF8.GetBytes(header.Substring(0, at) + header.Substring(header.IndexOf('}', at) + 1));
            int Padded(int n) => (n + 15) / 16 * 16;
            var file = new byte[16 + Padded(older.Length) + 2 * Voxels * Voxels * Voxels];
            Array.Copy(stored, file, 8);
            BitConverter.GetBytes((ulong)older.Length).CopyTo(file, 8);
            older.CopyTo(file, 16);
            Array.Copy(stored, 16 + Padded(length), file, 16 + Padded(older.Length), 2 * Voxels * Voxels * Voxels);
            return file;
        }

        [Test]
        public void OfAScanOfAnOlderVersionNothingComesBackAndAWarningSaysWhy()
        {
            LookForTables();
            var path = Saved(Patient());
            File.WriteAllBytes(path, WithoutSurroundings(File.ReadAllBytes(path)));
            volume.volume = Opened(path);
            Assert.IsFalse(volume.volume.hasSurroundings);
            CollectionAssert.IsEmpty(volume.GetWarnings());
            volume.keepEverything = true;
            Assert.IsFalse(volume.isPreparing);
            Assert.IsTrue(Table() < Dark);
            StringAssert.Contains("'Keep Everything' has nothing to put back", volume.GetWarnings().Single());
            StringAssert.Contains("Import it again", volume.GetWarnings().Single());
        }

        [Test]
        public void WhoShowsTheSameSharesItAndTheLastOneEndsIt()
        {
            LookForTables();
            volume.volume = Patient();
            var other = new GameObject("Other").AddComponent<LumivoxVolume>();
            other.volume = volume.volume;
            volume.keepEverything = other.keepEverything = true;
            Assert.IsTrue(volume.isPreparing && other.isPreparing);
            Assert.AreEqual(1, Jobs.Count, "it is computed once");
            Ready();
            Assert.IsFalse(other.isPreparing);
            var ended = Native.NativeHandle.Ended;
            other.keepEverything = false;
            Engine.Frame();
            Assert.AreEqual(ended, Native.NativeHandle.Ended, "one shows it still");
            Object.DestroyImmediate(volume.gameObject);
            Assert.AreEqual(ended + 1, Native.NativeHandle.Ended);
            // One that ends while it is computed is told nothing.
            other.keepEverything = true;
            Assert.IsTrue(other.isPreparing);
            Object.DestroyImmediate(other.volume);
            Assert.IsFalse(other.isPreparing);
            Object.DestroyImmediate(other.gameObject);
            RuntimeComponentTests.Wait(() => Jobs.Count == 0);
        }

        [Test]
        public void APresetForAnOrganShowsItAlone()
        {
            LookForTables();
            var torso = Kept(LumivoxVolumeAsset.Phantom("torso", 128));
            (volume.volume, volume.transferFunction) = (torso, null);
            volume.transform.rotation = Quaternion.identity;
            RuntimeComponentTests.Wait(() => torso.state == LumivoxVolumeState.Ready);
            Assert.IsTrue(volume.ApplyPreset("ct-airways"));
            Assert.IsTrue(volume.isPreparing);
            Assert.AreEqual("The organ is being found.", volume.Preparing);
            float Lit()
            {
                Settle();
                var picture = Pictures.Color(camera);
                return Enumerable.Range(0, Side * Side).Count(i => Light(picture.At(i % Side, i / Side)) > Bright);
            }
            var before = Lit();
            // Quick machines have found it by now.
            var isBefore = volume.isPreparing;
            Ready();
            CollectionAssert.IsEmpty(volume.GetWarnings());
            var airways = Lit();
            // Everything comes before the organ.
            Assert.IsFalse(torso.hasSurroundings);
            volume.keepEverything = true;
            var all = Lit();
            Assert.IsTrue(airways > 0 && airways < 0.7f * all, $"{airways} of {all} pixels");
            if (isBefore) Assert.AreEqual(all, before, 0.05f * all);
            volume.keepEverything = false;
            Ready();
            Assert.AreEqual(airways, Lit(), 0.05f * all + 1f);
            // The curve stays when the preset's name goes.
            volume.preset = "";
            Assert.IsFalse(volume.isPreparing);
            Assert.AreEqual(all, Lit(), 0.05f * all);
        }

        [Test]
        public void AnOrganThatIsNotThereIsSaidAndAllIsSeen()
        {
            LookForTables();
            Assert.IsTrue(volume.ApplyPreset("ct-lung-vessels"));
            volume.transferFunction = look;
            Ready();
            Assert.IsTrue(Table() > Bright, "the cube is seen");
            Assert.AreEqual("No lungs with vessels were found in the scan for sure: all of it is seen with the preset ct-lung-vessels.", volume.GetWarnings().Single());
            // Whoever asks again is told at once.
            Engine.Frames(3);
            Assert.AreEqual(0, Jobs.Count);
            Assert.IsTrue(volume.ApplyPreset("ct-bone"));
            CollectionAssert.IsEmpty(volume.GetWarnings());
        }

        [Test]
        public void AGameIsToldOnceThatAnOrganIsNotThere()
        {
            LookForTables();
            Domain.Play(false);
            try
            {
                volume = Object.FindObjectsByType<LumivoxVolume>(FindObjectsSortMode.None).Single();
                volume.volume = Kept(LumivoxVolumeAsset.Phantom("cube", 16));
                RuntimeComponentTests.Wait(() => volume.volume.state == LumivoxVolumeState.Ready);
                Assert.IsTrue(volume.ApplyPreset("ct-airways"));
                Ready();
                Engine.Frames(4);
                Assert.AreEqual(1, Log.Count(LogType.Warning, "LumivoxVolume: No airways were found in the scan for sure"));
            }
            finally
            {
                Domain.Stop();
            }
        }
    }
}
