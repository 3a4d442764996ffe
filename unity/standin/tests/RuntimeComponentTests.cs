// Components and assets by their properties: defaults, ranges, what is refused, what is warned of.
using System.Linq;
using NUnit.Framework;
using StandIn;
using UnityEngine;

namespace Lumivox.Tests
{
    public sealed class RuntimeComponentTests
    {
        static LumivoxVolume Volume() => new GameObject("Head").AddComponent<LumivoxVolume>();

        [TearDown]
        public void End()
        {
            LumivoxRuntime.Stop();
            foreach (var thing in Object.FindObjectsByType<GameObject>(FindObjectsSortMode.None)) Object.DestroyImmediate(thing);
        }

        [Test]
        public void AVolumeHasTheDefaultsOfOtherHosts()
        {
            var volume = Volume();
            Assert.AreEqual(2f, volume.density);
            Assert.AreEqual(1f, volume.albedo);
            Assert.AreEqual(0f, volume.anisotropy);
            Assert.AreEqual(100, volume.maxBounces);
            Assert.AreEqual(LumivoxVolume.Filter.Smooth, volume.filter);
            Assert.AreEqual(LumivoxVolume.ExtinctionSpace.Volume, volume.extinctionSpace);
            Assert.AreEqual(1f, volume.surfaceStrength);
            Assert.AreEqual(0f, volume.surfaceGradient);
            Assert.AreEqual(0.4f, volume.surfaceRoughness);
            Assert.AreEqual(0.04f, volume.surfaceSpecular);
            Assert.AreEqual(0f, volume.surfaceMetallic);
            Assert.AreEqual(Vector3.zero, volume.clipMin);
            Assert.AreEqual(Vector3.one, volume.clipMax);
        }

        [Test]
        public void AnEffectHasTheDefaultsOfOtherHosts()
        {
            var effect = new GameObject("Effect").AddComponent<LumivoxEffect>();
            Assert.AreEqual(0f, effect.exposure);
            Assert.AreEqual(512, effect.targetSamples);
            Assert.AreEqual(8f, effect.frameBudgetMs);
            Assert.AreEqual(1f, effect.resolutionScale);
            Assert.IsTrue(effect.writeDepth);
            Assert.IsFalse(effect.denoise);
            Assert.IsTrue(effect.keptLight);
            Assert.AreEqual(LumivoxEnvironmentSource.Scene, effect.environmentSource);
        }

        [Test]
        public void NumbersBeyondTheirRangeBecomeTheNearestInIt()
        {
            var volume = Volume();
            volume.density = -1f;
            Assert.AreEqual(0f, volume.density);
            volume.density = 5e9f;
            Assert.AreEqual(LumivoxVolume.MaxDensity, volume.density);
            volume.anisotropy = -3f;
            Assert.AreEqual(-0.99f, volume.anisotropy);
            volume.maxBounces = 0;
            Assert.AreEqual(1, volume.maxBounces);
            volume.filter = (LumivoxVolume.Filter)7;
            Assert.AreEqual(LumivoxVolume.Filter.Smooth, volume.filter);
            volume.clipMax = new Vector3(2f, -1f, 0.5f);
            Assert.AreEqual(new Vector3(1f, 0f, 0.5f), volume.clipMax);
            var effect = new GameObject("Effect").AddComponent<LumivoxEffect>();
            effect.exposure = 100f;
            Assert.AreEqual(64f, effect.exposure);
            effect.targetSamples = 1 << 20;
            Assert.AreEqual(65536, effect.targetSamples);
            effect.frameBudgetMs = 0f;
            Assert.AreEqual(0.5f, effect.frameBudgetMs);
            effect.resolutionScale = 3f;
            Assert.AreEqual(1f, effect.resolutionScale);
        }

        [Test]
        public void WhatIsNoNumberIsRefusedWithAnError()
        {
            var volume = Volume();
            Log.Expect(LogType.Error, "LumivoxVolume.density takes neither NaN nor infinity, and stays as it was.");
            volume.density = float.NaN;
            Assert.AreEqual(2f, volume.density);
            Log.Expect(LogType.Error, "LumivoxVolume.clipMin takes neither NaN nor infinity");
            volume.clipMin = new Vector3(0f, float.PositiveInfinity, 0f);
            Assert.AreEqual(Vector3.zero, volume.clipMin);
            var effect = new GameObject("Effect").AddComponent<LumivoxEffect>();
            Log.Expect(LogType.Error, "LumivoxEffect.frameBudgetMs must be a finite number, not NaN; it stays 8.");
            effect.frameBudgetMs = float.NaN;
            Assert.AreEqual(8f, effect.frameBudgetMs);
            var function = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
            Log.Expect(LogType.Error, "LumivoxTransferFunction.shift takes neither NaN nor infinity");
            function.shift = float.NegativeInfinity;
            Assert.AreEqual(0f, function.shift);
            Object.DestroyImmediate(function);
        }

        [Test]
        public void WarningsSayWhyNothingIsSeen()
        {
            var volume = Volume();
            Assert.IsTrue(volume.GetWarnings().Any(warning => warning.Contains("There is no scan to show")));
            volume.volume = LumivoxVolumeAsset.Phantom("cube", 8);
            Assert.AreEqual(0, volume.GetWarnings().Count, string.Join("; ", volume.GetWarnings()));
            volume.density = 0f;
            Assert.IsTrue(volume.GetWarnings().Any(warning => warning.Contains("'Density' is 0")));
            volume.density = 1f;
            volume.clipMin = new Vector3(0.5f, 0f, 0f);
            volume.clipMax = new Vector3(0.5f, 1f, 1f);
            Assert.IsTrue(volume.GetWarnings().Any(warning => warning.Contains("The clip box is flat")));
            volume.clipMax = new Vector3(0.2f, 1f, 1f);
            Assert.IsTrue(volume.GetWarnings().Any(warning => warning.Contains("'Clip Min' lies beyond 'Clip Max'")));
            volume.transferFunction = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
            Assert.IsTrue(volume.GetWarnings().Any(warning => warning.Contains("no opacity knots")));
            bool IsScaleWrong() => volume.GetWarnings().Any(warning => warning.Contains("scale is 0"));
            foreach (var scale in new[] { new Vector3(1f, 0f, 1f), Vector3.one * float.NaN, Vector3.one * float.PositiveInfinity })
            {
                volume.transform.localScale = scale;
                Assert.IsTrue(IsScaleWrong(), $"{scale}");
            }
            volume.transform.localScale = new Vector3(-1f, 0.001f, 1000f);
            Assert.IsFalse(IsScaleWrong());
        }

        [Test]
        public void APointOfTwoAtTheSameValueKeepsItsPlace()
        {
            var function = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
            var told = 0;
            function.changed += () => told++;
            function.SetPoints(
                new[]
                {
                    new LumivoxTransferFunction.OpacityKnot(300f, 0.5f), new LumivoxTransferFunction.OpacityKnot(100f, 0f),
                    new LumivoxTransferFunction.OpacityKnot(100f, 1f), new LumivoxTransferFunction.OpacityKnot(-50f, 0f),
                },
                new[] { new LumivoxTransferFunction.ColorStop(0f, Color.red) });
            Assert.AreEqual(1, told);
            CollectionAssert.AreEqual(new[] { -50f, 100f, 100f, 300f }, function.opacityKnots.Select(knot => knot.value));
            CollectionAssert.AreEqual(new[] { 0f, 0f, 1f, 0.5f }, function.opacityKnots.Select(knot => knot.opacity));
            Assert.AreEqual(0f, function.GetOpacity(0f), 1e-6f);
            Assert.AreEqual(0.75f, function.GetOpacity(200f), 1e-5f);
            Assert.AreEqual(1f, function.GetColor(0f).r, 1e-5f);
            function.shift = 100f;
            Assert.AreEqual(0.75f, function.GetOpacity(300f), 1e-5f);
            Object.DestroyImmediate(function);
        }

        [Test]
        public void NothingIsNoTransferFunctionAndNoArray()
        {
            var function = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
            StringAssert.Contains("it is null", Assert.Throws<LumivoxException>(() => function.CopyFrom(null)).Message);
            StringAssert.Contains("it is null", Assert.Throws<LumivoxException>(() => function.Sample(0f, 1f, null)).Message);
            Object.DestroyImmediate(function);
        }

        [Test]
        public void APresetBringsItsWholeLook()
        {
            var volume = Volume();
            Assert.IsTrue(LumivoxVolume.PresetNames.Count > 3);
            volume.density = 77f;
            volume.preset = LumivoxVolume.PresetNames[0];
            Assert.AreEqual(LumivoxVolume.PresetNames[0], volume.preset);
            Assert.AreNotEqual(77f, volume.density);
            Assert.IsTrue(volume.transferFunction.opacityKnots.Count > 0);
            var before = volume.transferFunction;
            Log.Expect(LogType.Error, "LumivoxVolume.preset:");
            volume.preset = "no such preset";
            Assert.AreSame(before, volume.transferFunction);
        }

        [Test]
        public void APhantomIsOpenedByWhoShowsItAndClosedAfterwards()
        {
            var scan = LumivoxVolumeAsset.Phantom("cube", 16);
            Assert.AreEqual(LumivoxVolumeState.Closed, scan.state);
            var volume = Volume();
            volume.volume = scan;
            Assert.AreEqual(LumivoxVolumeState.Loading, scan.state);
            Wait(() => scan.state == LumivoxVolumeState.Ready);
            Assert.AreEqual(new Vector3Int(16, 16, 16), scan.dimensions);
            Assert.IsTrue(volume.localBounds.size.x > 0f);
            Assert.IsTrue(scan.GetHistogram(10, scan.valueRange).Sum() > 4000f);
            volume.enabled = false;
            LumivoxVolumeAsset.CloseUnused(0f);
            Assert.AreEqual(LumivoxVolumeState.Closed, scan.state);
            Assert.AreEqual(new Vector3Int(16, 16, 16), scan.dimensions);
            Object.DestroyImmediate(scan);
        }

        [Test]
        public void AScanOfAScriptIsSavedAndRead()
        {
            var voxels = Enumerable.Range(0, 4 * 5 * 6).Select(i => (ushort)i).ToArray();
            var place = new double[] { 1, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0 };
            var scan = LumivoxVolumeAsset.Create<ushort>(new Vector3Int(4, 5, 6), voxels, 1, -100, place, "CT");
            Assert.AreEqual(new Vector2(-100f, 19f), scan.valueRange);
            Assert.AreEqual("CT", scan.modality);
            Assert.AreEqual(0.012f, scan.sizeM.z, 1e-6f);
            var path = System.IO.Path.Combine(Application.temporaryCachePath, "scan.lumivox");
            var saved = scan.Save(path);
            Wait(() => saved.IsCompleted);
            Assert.IsNull(saved.Exception);
            var loading = LumivoxVolumeAsset.LoadFile(path);
            Wait(() => loading.IsCompleted);
            Assert.AreEqual(scan.valueRange, loading.Result.valueRange);
            Assert.AreEqual(scan.localBounds, loading.Result.localBounds);
            Assert.Throws<LumivoxException>(() => LumivoxVolumeAsset.Create<ushort>(new Vector3Int(4, 5, 7), voxels, 1, 0, place));
            Assert.Throws<LumivoxException>(() => LumivoxVolumeAsset.Phantom("cube", 4));
            Assert.Throws<LumivoxException>(() => LumivoxVolumeAsset.Phantom("heart"));
            Object.DestroyImmediate(scan);
        }

        [Test]
        public void AnImporterTellsWhatIsWrongAndMayBeCancelled()
        {
            using (var importer = new LumivoxImporter())
            {
                Assert.Throws<LumivoxException>(() => importer.Load(new string[0]));
                string failure = null;
                importer.failed += message => failure = message;
                var loading = importer.Load(new[] { "/nowhere/at/all" });
                Assert.IsTrue(importer.isRunning);
                Assert.Throws<LumivoxException>(() => importer.Scan(new[] { "/nowhere" }));
                Wait(() => loading.IsCompleted);
                Assert.IsFalse(importer.isRunning);
                StringAssert.Contains("/nowhere/at/all", failure);
                Assert.Throws<LumivoxException>(() => importer.RequestThumbnail(0));
            }
        }

        internal static void Wait(System.Func<bool> isSo)
        {
            Assert.IsTrue(Waiting.Turns(isSo, Ticker.Tick));
        }
    }
}
