// A package whose native library is missing, as after an installation from git, or another version's: in a process of its
// own, as this one has the right one loaded.
using System.Diagnostics;
using System.IO;
using System.Linq;
using Lumivox.Editor;
using NUnit.Framework;
using StandIn;
using UnityEditor;
using UnityEngine;
using UnityEngine.UIElements;
using Debug = UnityEngine.Debug;

namespace Lumivox.Tests
{
    public sealed class RuntimeLibraryTests
    {
        /// What a compiler makes the library of that is in place of ours; null: there is none.
        static string SourceOf(string how) =>
            how == "AnotherVersion" ? "unsigned lumivox_abi_version(void) { return 2; }\n" : how == "NoVersion" ? "int nothing;\n" : null;

        [TestCase("Missing")]
        [TestCase("AnotherVersion")]
        [TestCase("NoVersion")]
        public void ItIsSaidOnceWhatToDo(string how)
        {
            var source = SourceOf(how);
            var here = Path.GetDirectoryName(typeof(RuntimeLibraryTests).Assembly.Location);
            var folder = Path.Combine(Path.GetTempPath(), "lumivox-" + Path.GetRandomFileName());
            Directory.CreateDirectory(folder);
            try
            {
                foreach (var file in Directory.GetFiles(here))
                    if (!file.EndsWith("liblumivox_unity.so")) File.Copy(file, Path.Combine(folder, Path.GetFileName(file)));
                if (source != null)
                {
                    File.WriteAllText(Path.Combine(folder, "library.c"), source);
                    Assert.AreEqual(0, Run("c++", $"-x c -shared -fPIC -o {folder}/liblumivox_unity.so {folder}/library.c", out var said), said);
                }
                var code = Run(Process.GetCurrentProcess().MainModule.FileName, $"{folder}/StandIn.Tests.Program.dll WithoutLibrary.{how}", out var output);
                Assert.AreEqual(0, code, output);
                StringAssert.Contains("1 passed, 0 failed", output);
            }
            finally
            {
                Directory.Delete(folder, true);
            }
        }

        static int Run(string program, string arguments, out string output)
        {
            var start = new ProcessStartInfo(program, arguments) { RedirectStandardOutput = true, RedirectStandardError = true, UseShellExecute = false };
            // Cargo's tests find libraries where they were built.
            start.Environment.Remove("LD_LIBRARY_PATH");
            using (var process = Process.Start(start))
            {
                var errors = process.StandardError.ReadToEndAsync();
                output = process.StandardOutput.ReadToEnd() + errors.Result;
                process.WaitForExit();
                return process.ExitCode;
            }
        }
    }

    /// What the other process runs.
    [Explicit]
    public sealed class WithoutLibrary
    {
        [SetUp]
        public void Begin() => EditorProject.Begin();

        [TearDown]
        public void End()
        {
            if (EditorWindow.HasOpenInstances<ImportWindow>()) EditorWindow.GetWindow<ImportWindow>().Close();
            if (EditorWindow.HasOpenInstances<TransferFunctionWindow>()) EditorWindow.GetWindow<TransferFunctionWindow>().Close();
        }

        [Test]
        public void Missing() => EverythingGoesOn("Lumivox' native library, liblumivox_unity.so, is not there", "Assets/Plugins", "cargo build --release -p lumivox-unity");

        [Test]
        public void AnotherVersion() => EverythingGoesOn("its border is version 2", $"version {Native.Abi.Version}", "restart Unity");

        [Test]
        public void NoVersion() => EverythingGoesOn("one that tells no version", "restart Unity");

        static void Says(string text, string[] words)
        {
            foreach (var word in words) Assert.That(text, Does.Contain(word));
        }

        static void EverythingGoesOn(params string[] words)
        {
            // In all that follows it is logged once.
            Log.Expect(LogType.Error, words[0]);
            PlainCamera.Make(32);
            var volumes = Enumerable.Range(0, 3).Select(i =>
            {
                var volume = new GameObject($"Volume {i}").AddComponent<LumivoxVolume>();
                volume.volume = LumivoxVolumeAsset.Phantom("cube", 16);
                return volume;
            }).ToArray();
            for (var i = 0; i < 20; i++)
            {
                Engine.Frame();
                Ticker.Tick();
            }
            Says(LumivoxRenderer.LastError, words);
            Assert.That(LumivoxRenderer.Version, Is.EqualTo(""));
            foreach (var volume in volumes)
            {
                Assert.That(volume.volume.state, Is.EqualTo(LumivoxVolumeState.Failed));
                Says(string.Join("\n", volume.GetWarnings()), words);
            }
            // Every window and inspector opens, and says it where it matters.
            var (_, panel) = EditorHost.Inspect(volumes[0]);
            Says(string.Join("\n", panel.visualTree.Query<HelpBox>().ToList().Select(box => box.text)), words);
            panel.Click(panel.visualTree.Q<Button>("open").worldBound.center);
            panel.Advance(600);
            EditorHost.Inspect(volumes[0].volume).panel.Advance(600);
            var function = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
            function.SetPoints(new[] { new LumivoxTransferFunction.OpacityKnot(0f, 1f) }, null);
            EditorHost.Inspect(function).panel.Advance(600);
            TransferFunctionWindow.Open();
            Selection.activeGameObject = volumes[0].gameObject;
            EditorWindow.GetWindow<TransferFunctionWindow>().panel.Advance(600);
            File.WriteAllBytes(EditorProject.Full("Assets/scan.bin"), EditorProject.Nrrd());
            var window = ImportWindow.Open(EditorProject.Full("Assets/scan.bin"));
            Assert.That(window.Now, Is.EqualTo(ImportWindow.Step.Choose));
            Says(window.panel.visualTree.Q<HelpBox>("problems").text, words);
            // A script's calls throw what people can read.
            Says(Assert.Throws<LumivoxException>(() => new LumivoxImporter().Load(new[] { "scan.nii" })).Message, words);
            Says(Assert.Throws<LumivoxException>(() => function.GetOpacity(0f)).Message, words);
            Says(Assert.Throws<LumivoxException>(() => LumivoxTransferFunction.Preset("ct-bone")).Message, words);
            // A preset is refused with an error of its own, for somebody has asked for it.
            Log.Expect(LogType.Error, "LumivoxVolume.preset: ");
            Assert.That(volumes[0].ApplyPreset("ct-bone"), Is.False);
            // And a file says what is left to do once there is a library.
            Assert.That(EditorProject.ImportScan("Assets/head.nrrd"), Is.Null);
            Says(Dialogs.ImportErrors.Single(), words);
            Assert.That(Dialogs.ImportErrors.Single(), Does.EndWith("Then choose 'Reimport'."));
            // The self-check says it first, and goes through to its end.
            var checks = SelfCheckList.All();
            using (var run = new SelfCheckRun(checks))
                EditorProject.Until(() => !run.Step(), "the checks end");
            Says(checks[0].Faults.Single().What, words);
            Says(SelfCheckReport.Of(checks), new[] { "FAILED   Native library", "See 'Native library'", "cannot be used" });
            // Whoever loads scripts anew is told again.
            Log.Expect(LogType.Error, words[0]);
            Domain.Reload();
        }
    }
}
