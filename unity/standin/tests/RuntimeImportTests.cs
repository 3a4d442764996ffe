// Files through the importer as games use it: in the background, with news, reports and an end in between.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Text;
using System.Threading;
using NUnit.Framework;
using UnityEngine;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed class RuntimeImportTests
    {
        readonly List<string> files = new List<string>();

        [TearDown]
        public void End()
        {
            foreach (var file in files) File.Delete(file);
            files.Clear();
            LumivoxRuntime.Stop();
        }

        string Write(string name, byte[] bytes)
        {
            var path = Path.Combine(Application.temporaryCachePath, name);
            Directory.CreateDirectory(Application.temporaryCachePath);
            File.WriteAllBytes(path, bytes);
            files.Add(path);
            return path;
        }

        /// A cube of voxels that takes a while to read.
        string Large(int side)
        {
            var header = Encoding.ASCII.GetBytes($"NRRD0004\ntype: uint16\ndimension: 3\nspace: left-posterior-superior\nsizes: {side} {side} {side}\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nendian: little\nencoding: raw\n\n");
            var bytes = new byte[header.Length + 2 * side * side * side];
            header.CopyTo(bytes, 0);
            for (var i = header.Length; i < bytes.Length; i += 2) bytes[i] = (byte)(i >> 9);
            return Write("large.nrrd", bytes);
        }

        /// Muscle and fat above a table.
        internal static byte[] Patient(int side)
        {
            var bytes = new byte[2 * side * side * side];
            for (var i = 0; i < side * side * side; i++)
            {
                float x = i % side - side / 2, y = i / side % side - side * 0.45f;
                var radius = Mathf.Sqrt(x * x + y * y);
                var isTable = i / side % side is var row && row >= side - 8 && row < side - 5 && Mathf.Abs(x) < side * 0.4f;
                var hu = (short)(radius < side * 0.2f ? 50 : radius < side * 0.3f ? -100 : isTable ? 120 : -1000);
                BitConverter.GetBytes(hu).CopyTo(bytes, 2 * i);
            }
            return bytes;
        }

        [Test]
        public void ThePatientIsImportedAloneUnlessEverythingIsAskedFor()
        {
            var path = Write("patient.raw", Patient(64));
            using (var importer = new LumivoxImporter())
            {
                (float dense, bool hidden) Load(bool everything)
                {
                    var loading = importer.Load(new[] { path }, new LumivoxImportOptions { raw = "64x64x64:i16le:spacing=4,4,4:modality=CT", keepEverything = everything });
                    RuntimeComponentTests.Wait(() => loading.IsCompleted);
                    var scan = loading.Result;
                    var found = (scan.GetHistogram(1, new Vector2(100f, 200f))[0], scan.GetReport().notes.Any(note => note.StartsWith("hidden: table and supports (")));
                    Object.DestroyImmediate(scan);
                    return found;
                }
                Assert.AreEqual((0f, true), Load(false));
                var (dense, hidden) = Load(true);
                Assert.IsTrue(dense > 8000f, $"{dense} voxels of the table");
                Assert.IsFalse(hidden);
            }
        }

        [TestCase("scan.nrrd", "NRRD")]
        [TestCase("scan.nii.gz", "NIfTI")]
        public void AFileIsLoadedWithItsValuesAndItsReport(string name, string format)
        {
            var path = Write(name, name.EndsWith("nrrd") ? EditorProject.Nrrd() : EditorProject.NiftiGz());
            using (var importer = new LumivoxImporter())
            {
                LumivoxVolumeAsset told = null;
                importer.finished += volume => told = volume;
                var loading = importer.Load(new[] { path });
                Assert.IsTrue(importer.isRunning);
                Assert.IsFalse(loading.IsCompleted);
                RuntimeComponentTests.Wait(() => loading.IsCompleted);
                var scan = loading.Result;
                Assert.AreSame(told, scan);
                Assert.AreEqual(LumivoxVolumeState.Ready, scan.state);
                Assert.AreEqual(new Vector3Int(12, 10, 8), scan.dimensions);
                Assert.AreEqual(new Vector3(1f, 1f, 2f), scan.spacingMm);
                Assert.AreEqual(new Vector2(0f, 959f), scan.valueRange);
                Assert.IsFalse(scan.isHounsfield);
                // 0 to 959 once each: ten in a bin of ten.
                foreach (var count in scan.GetHistogram(96, new Vector2(0f, 960f))) Assert.AreEqual(10f, count);
                var size = scan.localBounds.size;
                Assert.AreEqual(0.012f, size.x, 1e-5f);
                Assert.AreEqual(0.016f, size.y, 1e-5f);
                Assert.AreEqual(0.010f, size.z, 1e-5f);
                Assert.IsTrue(scan.localBounds.center.magnitude < 1e-5f);
                var report = scan.GetReport();
                StringAssert.Contains(format.ToLowerInvariant(), report.format.ToLowerInvariant());
                Assert.IsFalse(report.notes.Any(note => note.Contains(Application.temporaryCachePath)), "a scan keeps no names of files");
                Object.DestroyImmediate(scan);
            }
        }

        [Test]
        public void WhatWasScannedIsReportedPicturedAndLoaded()
        {
            var path = Write("scan.nrrd", EditorProject.Nrrd());
            using (var importer = new LumivoxImporter())
            {
                LumivoxReport told = null;
                importer.scanned += report => told = report;
                var scanning = importer.Scan(new[] { path });
                RuntimeComponentTests.Wait(() => scanning.IsCompleted);
                var found = scanning.Result;
                Assert.AreSame(told, found);
                Assert.AreEqual("NRRD", found.format);
                Assert.AreEqual(1, found.series.Length);
                CollectionAssert.AreEqual(new[] { 12, 10, 8 }, found.chosenSeries.dims);
                CollectionAssert.AreEqual(new[] { 1f, 1f, 2f }, found.chosenSeries.spacing_mm);
                Assert.AreEqual(12 * 10 * 8 * 2, found.chosenSeries.bytes);
                Assert.AreEqual(0, found.skipped.Length);
                var picturing = importer.RequestThumbnail(0, 64);
                RuntimeComponentTests.Wait(() => picturing.IsCompleted);
                var picture = picturing.Result;
                Assert.IsNotNull(picture);
                Assert.IsTrue(picture.width <= 64 && picture.height <= 64);
                Object.DestroyImmediate(picture);
                var loading = importer.Load(new[] { path });
                RuntimeComponentTests.Wait(() => loading.IsCompleted);
                Assert.AreEqual(new Vector3Int(12, 10, 8), loading.Result.dimensions);
                Object.DestroyImmediate(loading.Result);
            }
        }

        [Test]
        public void AGameGoesOnWhileAScanIsLoaded()
        {
            var path = Large(192);
            using (var importer = new LumivoxImporter())
            {
                var stages = new List<(string stage, long done, long total)>();
                var thread = Thread.CurrentThread.ManagedThreadId;
                importer.progressed += progress =>
                {
                    Assert.AreEqual(thread, Thread.CurrentThread.ManagedThreadId);
                    stages.Add((progress.stage, progress.done, progress.total));
                };
                var loading = importer.Load(new[] { path });
                var turns = 0;
                while (!loading.IsCompleted && turns < 100000)
                {
                    Ticker.Tick();
                    turns++;
                    Thread.Sleep(1);
                }
                Assert.AreEqual(192, loading.Result.dimensions.x);
                Assert.IsTrue(turns > 2, $"it took {turns} turns: the main thread waited");
                Assert.IsTrue(stages.Count > 0, "no news came");
                Assert.IsTrue(stages.All(at => at.stage.Length > 0), string.Join(", ", stages));
                for (var i = 1; i < stages.Count; i++)
                    if (stages[i].stage == stages[i - 1].stage) Assert.IsTrue(stages[i].done >= stages[i - 1].done, string.Join(", ", stages));
                Object.DestroyImmediate(loading.Result);
            }
        }

        [Test]
        public void AListenerThatThrowsKeepsNobodyWaiting()
        {
            var path = Write("scan.nrrd", EditorProject.Nrrd());
            using (var importer = new LumivoxImporter())
            {
                var thrown = 0;
                void Throw(string what)
                {
                    thrown++;
                    StandIn.Log.Expect(LogType.Exception, what);
                    throw new System.InvalidOperationException(what);
                }
                importer.progressed += _ => Throw("progress");
                importer.scanned += _ => Throw("scanned");
                importer.finished += _ => Throw("finished");
                importer.failed += _ => Throw("failed");
                var scanning = importer.Scan(new[] { path });
                RuntimeComponentTests.Wait(() => scanning.IsCompleted);
                Assert.AreEqual(1, scanning.Result.series.Length);
                var loading = importer.Load(new[] { path });
                RuntimeComponentTests.Wait(() => loading.IsCompleted);
                Assert.AreEqual(12, loading.Result.dimensions.x);
                var failing = importer.Load(new[] { "/nowhere" });
                RuntimeComponentTests.Wait(() => failing.IsCompleted);
                Assert.IsTrue(failing.IsFaulted);
                Assert.IsFalse(importer.isRunning);
                Assert.IsTrue(thrown >= 3);
                Assert.AreEqual(0, Jobs.Count);
                Object.DestroyImmediate(loading.Result);
            }
        }

        [Test]
        public void APictureThatCannotBeMadeIsItsTasksError()
        {
            var path = Write("scan.nrrd", EditorProject.Nrrd());
            using (var importer = new LumivoxImporter())
            {
                var scanning = importer.Scan(new[] { path });
                RuntimeComponentTests.Wait(() => scanning.IsCompleted);
                StandIn.Faults.missingFormats.Add(UnityEngine.Experimental.Rendering.GraphicsFormat.R8G8B8A8_SRGB);
                var picturing = importer.RequestThumbnail(0, 64);
                RuntimeComponentTests.Wait(() => picturing.IsCompleted);
                Assert.IsTrue(picturing.IsFaulted);
            }
        }

        [Test]
        public void OtherThreadsAreToldThatTheyAreNone()
        {
            var path = Write("scan.nrrd", EditorProject.Nrrd());
            var scan = LumivoxVolumeAsset.Phantom("cube", 16);
            scan.Open();
            RuntimeComponentTests.Wait(() => scan.state == LumivoxVolumeState.Ready);
            var look = LumivoxTransferFunction.Preset("ct-skin");
            var volume = new GameObject("Volume").AddComponent<LumivoxVolume>();
            (volume.volume, volume.transferFunction) = (scan, look);
            using (var importer = new LumivoxImporter())
            {
                var calls = new System.Action[]
                {
                    () => importer.Load(new[] { path }), () => importer.Scan(new[] { path }), () => importer.RequestThumbnail(0),
                    () => scan.Open(), () => scan.Save(path + ".lumivox"), () => scan.RequestPicture(), () => LumivoxVolumeAsset.LoadFile(path),
                    () => volume.volume = null, () => volume.transferFunction = null, () => volume.ApplyPreset("ct-bone"),
                    () => look.SetPoints(null, null), () => look.shift = 1f, () => look.windowScale = 2f, () => look.CopyFrom(look),
                };
                foreach (var call in calls)
                {
                    var error = Assert.Throws<LumivoxException>(() => System.Threading.Tasks.Task.Run(call).GetAwaiter().GetResult());
                    StringAssert.Contains("main thread", error.Message);
                }
                Assert.AreEqual(0, Jobs.Count, "nothing was begun");
                Assert.IsFalse(importer.isRunning);
                Assert.AreEqual((scan, look, ""), (volume.volume, volume.transferFunction, volume.preset));
                Assert.AreEqual((0f, 1f), (look.shift, look.windowScale));
            }
            Object.DestroyImmediate(volume.gameObject);
            Object.DestroyImmediate(look);
            Object.DestroyImmediate(scan);
        }

        [TestCase(true)]
        [TestCase(false)]
        public void WhatIsCancelledGivesNothing(bool byToken)
        {
            var path = Large(192);
            using (var importer = new LumivoxImporter())
            using (var source = new CancellationTokenSource())
            {
                int cancelled = 0, others = 0;
                importer.cancelled += () => cancelled++;
                importer.finished += _ => others++;
                importer.failed += _ => others++;
                var loading = importer.Load(new[] { path }, null, source.Token);
                if (byToken) source.Cancel();
                else importer.Cancel();
                Assert.AreEqual(0, cancelled, "events come with turns");
                RuntimeComponentTests.Wait(() => loading.IsCompleted);
                Assert.IsTrue(loading.IsCanceled);
                Assert.AreEqual((1, 0), (cancelled, others));
                Assert.IsFalse(importer.isRunning);
                // And it is ready for the next.
                var again = importer.Load(new[] { path });
                RuntimeComponentTests.Wait(() => again.IsCompleted);
                Assert.AreEqual(192, again.Result.dimensions.y);
                Object.DestroyImmediate(again.Result);
                // What has ended is beyond a token.
                source.Cancel();
            }
        }
    }
}
