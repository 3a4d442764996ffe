// The self-check as whoever has Unity starts it, where all is well and where something is not.
using System;
using System.IO;
using System.Linq;
using System.Text.RegularExpressions;
using Lumivox.Editor;
using Lumivox.SelfChecks;
using NUnit.Framework;
using StandIn;
using UnityEditor;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.HighDefinition;
using UnityEngine.Rendering.RenderGraphModule;
using UnityEngine.Rendering.Universal;
using UnityEngine.UIElements;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed class EditorSelfCheckTests
    {
        [SetUp]
        public void Begin()
        {
            Engine.Clear();
            EditorProject.Begin();
        }

        [TearDown]
        public void End()
        {
            if (EditorWindow.HasOpenInstances<SelfCheckWindow>()) EditorWindow.GetWindow<SelfCheckWindow>().Close();
            CheckPicture.ExpectedFolder = null;
            Resources.placed.Clear();
            Engine.SetColorSpace(ColorSpace.Linear);
            LumivoxRuntime.Stop();
            Engine.Clear();
            EditorProject.Begin();
        }

        /// Runs checks of these names to their end.
        static Check[] Run(params string[] names)
        {
            var checks = SelfCheckList.All().Where(one => names.Any(one.Name.EndsWith)).ToArray();
            Assert.AreEqual(names.Length, checks.Length);
            using (var run = new SelfCheckRun(checks))
                EditorProject.Until(() => !run.Step(), "the checks end");
            return checks;
        }

        static void Passes(params string[] names)
        {
            var checks = Run(names);
            Assert.IsTrue(checks.All(check => check.Now == Check.State.Passed), SelfCheckReport.Of(checks));
        }

        static void Fails(string name, params string[] words)
        {
            var check = Run(name).Single();
            Assert.AreEqual(Check.State.Failed, check.Now, name);
            var report = SelfCheckReport.Of(new[] { check });
            foreach (var word in words.Append("1 of 1 FAILED")) StringAssert.Contains(word, report);
        }

        static void NothingIsLeft()
        {
            Assert.AreEqual(0, PreviewScenes.count);
            Assert.IsEmpty(Resources.FindObjectsOfTypeAll<GameObject>());
            Assert.IsEmpty(Resources.FindObjectsOfTypeAll<LumivoxVolumeAsset>().Where(scan => !scan.isAsset));
            Assert.IsEmpty(Directory.GetFileSystemEntries(EditorProject.Full("Assets")).Where(path => !path.EndsWith("StreamingAssets")));
            Assert.IsFalse(File.Exists(Path.Combine(SelfCheckRun.Folder, "scan.nrrd")));
        }

        [Test]
        public void FromTheCommandLineAllIsWell()
        {
            EditorHost.ExitCode = null;
            SelfCheck.RunFromCommandLine();
            EditorProject.Until(() => EditorHost.ExitCode != null, "the editor ends");
            var report = File.ReadAllText(SelfCheckRun.ReportFile);
            Assert.AreEqual(0, EditorHost.ExitCode, report);
            Assert.AreEqual(1, Log.Count(LogType.Log, report.Split('\n')[0].Trim()), "the log has the report");
            Assert.AreEqual(3 * CheckScene.All.Length, Directory.GetFiles(SelfCheckRun.Folder, "*.png").Length);
            NothingIsLeft();
            // The manual's example is such a report: of the same lines, but for numbers.
            var example = Path.Combine(Packages.all.First(), "Documentation~/self-check-report.txt");
            if (Environment.GetEnvironmentVariable("UPDATE_SELF_CHECK_REPORT") == "1") File.WriteAllText(example, Regex.Replace(report, "(?<=this report: ).*(?=Library)", ""));
            Assert.AreEqual(Shape(File.ReadAllText(example)), Shape(report));
        }

        /// Without what differs from run to run and from machine to machine.
        static string Shape(string report)
        {
            var facts = Regex.Replace(report, "(?m)^(System|Graphics|Driver|Run at|Unity|Pictures and this report):.*$", "$1");
            return Regex.Replace(facts, "[0-9.]+( [KMG]B)?", "N");
        }

        [Test]
        public void WhatFailsIsTheExitCode()
        {
            Faults.noComputeShaders = true;
            EditorHost.ExitCode = null;
            SelfCheck.RunFromCommandLine();
            EditorProject.Until(() => EditorHost.ExitCode != null, "the editor ends");
            Assert.AreEqual(1, EditorHost.ExitCode);
            var report = File.ReadAllText(SelfCheckRun.ReportFile);
            StringAssert.Contains($"{2 + CheckScene.All.Length} of {SelfCheckList.All().Count} FAILED", report);
            StringAssert.Contains("Project Settings > Player > Graphics APIs", report);
            NothingIsLeft();
        }

        [Test]
        public void AWindowShowsWhatCameOfIt()
        {
            var window = SelfCheckWindow.Open();
            window.Begin(SelfCheckList.All().Where(check => check.Name == "Phantom" || check.Name.EndsWith("occlusion")).ToList());
            var root = window.rootVisualElement;
            Assert.IsTrue(root.Q<Button>("stop").enabledSelf);
            EditorProject.Until(() => window.Run.IsOver, "the checks end", window.panel);
            EditorHost.Frame();
            StringAssert.StartsWith("OK", root.Q<Label>("verdict").text);
            Assert.AreEqual(3, root.Query<Image>().ToList().Count, "seen, expected, different");
            window.panel.Click(root.Q<Button>("copy").worldBound.center);
            StringAssert.Contains("OK       Picture: occlusion", GUIUtility.systemCopyBuffer);
            Assert.IsTrue(root.Q<Button>("start").enabledSelf);
            window.Close();
            NothingIsLeft();
        }

        [TestCase("Phantom")]
        [TestCase("Import as an asset")]
        [TestCase("Picture: lights")]
        public void StoppedItLeavesNothing(string name)
        {
            var check = SelfCheckList.All().Single(one => one.Name == name);
            var run = new SelfCheckRun(new[] { check });
            // Within its first step, before it could have ended.
            run.Advance();
            Assert.AreEqual(Check.State.Running, check.Now);
            run.Dispose();
            Assert.AreEqual(Check.State.Waiting, check.Now);
            StringAssert.Contains("1 not run", run.Report);
            NothingIsLeft();
        }

        [Test]
        public void PlayModeStopsIt()
        {
            var window = SelfCheckWindow.Open();
            window.Begin(SelfCheckList.All().Where(check => check.Name.EndsWith("occlusion")).ToList());
            EditorHost.Frame();
            Assert.IsFalse(window.Run.IsOver);
            EditorApplication.Send(PlayModeStateChange.ExitingEditMode);
            Assert.IsTrue(window.Run.IsOver);
            NothingIsLeft();
        }

        [Test]
        public void AKernelThatIsMissingOrBrokenIsNamed()
        {
            var computed = KernelTable.Entries.Where(entry => !entry.IsDrawn).Take(2).ToArray();
            Resources.placed["Lumivox/" + computed[0].Name] = null;
            Resources.placed["Lumivox/" + computed[1].Name] = ComputeShader.FromText("broken", $"#pragma kernel {computed[1].EntryPoint}\n[numthreads(1,1,1)] void {computed[1].EntryPoint}() {{ nonsense; }}\n");
            Log.Expect(LogType.Error, "nonsense");
            Resources.placed["Lumivox/LumivoxCubeFaces"] = null;
            Fails("Kernels", $"the kernel '{computed[0].Name}' is missing from the package", "the kernel 'LumivoxCubeFaces' is missing from the package", $"cannot run Lumivox' kernel '{computed[1].Name}'", "Update its driver");
        }

        [Test]
        public void AnotherPictureThanExpectedFails()
        {
            var folder = Directory.CreateDirectory(Path.Combine(Path.GetTempPath(), "lumivox-" + Path.GetRandomFileName())).FullName;
            try
            {
                CheckPicture.Expected("lights").Save(Path.Combine(folder, "occlusion.png"));
                CheckPicture.ExpectedFolder = folder;
                Fails("occlusion", "the picture is not what it should be", "occlusion-expected.png", "attach both");
                Fails("cube-at-distances", "cube-at-distances.png is missing from the package");
            }
            finally
            {
                Directory.Delete(folder, true);
            }
        }

        [Test]
        public void TheProjectIsToldWhatToChange()
        {
            Engine.SetColorSpace(ColorSpace.Gamma);
            Fails("Project settings", "colour space is Gamma", "Set Project Settings > Player");
        }

        /// A renderer feature of the project's own, which paints over all that is drawn.
        sealed class Paint : ScriptableRendererFeature
        {
            sealed class Pass : ScriptableRenderPass
            {
                public Pass() => renderPassEvent = RenderPassEvent.AfterRenderingTransparents;

                public override void RecordRenderGraph(RenderGraph renderGraph, ContextContainer frameData)
                {
                    var color = frameData.Get<UniversalResourceData>().activeColorTexture;
                    using (var builder = renderGraph.AddUnsafePass<Pass>("Paint", out var data))
                    {
                        builder.UseTexture(color, AccessFlags.Write);
                        builder.AllowPassCulling(false);
                        builder.SetRenderFunc((Pass pass, UnsafeGraphContext context) =>
                        {
                            var cmd = CommandBufferHelpers.GetNativeCommandBuffer(context.cmd);
                            cmd.SetRenderTarget(((RTHandle)color).nameID);
                            cmd.ClearRenderTarget(false, true, Color.red);
                        });
                    }
                }
            }

            public override void Create() { }

            public override void AddRenderPasses(ScriptableRenderer renderer, ref RenderingData renderingData) => renderer.EnqueuePass(new Pass());
        }

        [Test]
        public void WhatAProjectDoesToAllPicturesOfUrpIsOutOfForce()
        {
            using (var pipeline = new Pipeline("graph"))
            {
                pipeline.RenderScale = 0.5f;
                var paint = pipeline.Add<Paint>();
                Passes("occlusion");
                Assert.AreEqual(0.5f, pipeline.RenderScale);
                Assert.IsTrue(paint.isActive);
            }
        }

        [Test]
        public void WhatIsWrongWithAnotherCameraIsNoFaultOfTheCheck()
        {
            var scan = LumivoxVolumeAsset.Phantom("cube", 64);
            var camera = PlainCamera.Make(16);
            new GameObject("Volume").AddComponent<LumivoxVolume>().volume = scan;
            EditorProject.Until(() => scan.state == LumivoxVolumeState.Ready, "the phantom is computed");
            // The scene that is open is drawn between the check's steps, and something is wrong there.
            void DrawOther()
            {
                camera.Render();
                LumivoxRuntime.Report("there is no room");
            }
            Log.Expect(LogType.Error, "Lumivox cannot draw the volumes: ");
            var check = SelfCheckList.All().Single(one => one.Name.EndsWith("occlusion"));
            using (var run = new SelfCheckRun(new[] { check }))
                EditorProject.Until(() =>
                {
                    var goesOn = run.Step();
                    if (goesOn) DrawOther();
                    return !goesOn;
                }, "the check ends");
            Assert.AreEqual(Check.State.Passed, check.Now, SelfCheckReport.Of(new[] { check }));
            Object.DestroyImmediate(scan);
        }

        [Test]
        public void PicturesDoNotShowWhatIsDrawnWhileShadersAreCompiled()
        {
            Assert.IsTrue(ShaderUtil.allowAsyncCompilation);
            bool? wasOn = null;
            void Look(Camera drawn) => wasOn = ShaderUtil.allowAsyncCompilation;
            Camera.onPreRender += Look;
            try
            {
                using (var stage = new CheckStage(true, 1))
                {
                    stage.Shape(CheckStage.Cube, Vector3.forward, Vector3.one, Color.red);
                    stage.Draw();
                }
            }
            finally
            {
                Camera.onPreRender -= Look;
            }
            Assert.AreEqual(false, wasOn);
            Assert.IsTrue(ShaderUtil.allowAsyncCompilation);
        }

        [Test]
        public void EachStepIsATurnOfTheEditor()
        {
            var steps = 0;
            System.Collections.IEnumerator Work(Check check)
            {
                for (; steps < 3; steps++) yield return null;
            }
            using (var run = new SelfCheckRun(new[] { new Check("Steps", Work) }))
                for (var i = 0; i < 3; i++)
                {
                    Assert.IsTrue(run.Step());
                    Assert.AreEqual(i, steps);
                }
        }

        /// Whatever the open scene has: fog, volumes, lights, light around it.
        [TestCase("Built-in", "occlusion lights", Category = "Slow")]
        [TestCase("graph", "occlusion lights", Category = "Slow")]
        [TestCase("HDRP", "occlusion lights", Category = "Slow")]
        [TestCase("graph", "occlusion")]
        [TestCase("HDRP", "occlusion")]
        public void AllPipelinesShowTheSameAndTheSceneThatIsOpenStaysAsItIs(string kind, string scenes)
        {
            using (new Pipeline(kind))
            {
                StandInHighDefinition.exposure = camera => 0.01f;
                (RenderSettings.fog, RenderSettings.fogDensity, RenderSettings.fogColor) = (true, 5f, Color.red);
                RenderSettings.ambientLight = Color.green;
                var sun = new GameObject("Sun").AddComponent<Light>();
                sun.type = LightType.Directional;
                var ball = GameObject.CreatePrimitive(PrimitiveType.Sphere);
                var scan = LumivoxVolumeAsset.Phantom("cube", 16);
                new GameObject("Volume").AddComponent<LumivoxVolume>().volume = scan;
                var before = Resources.FindObjectsOfTypeAll<GameObject>().Length;
                Passes(scenes.Split(' ').Prepend("Project settings").ToArray());
                Assert.AreEqual(before, Resources.FindObjectsOfTypeAll<GameObject>().Length);
                Assert.AreEqual((true, 5f, Color.red, Color.green), (RenderSettings.fog, RenderSettings.fogDensity, RenderSettings.fogColor, RenderSettings.ambientLight));
                Object.DestroyImmediate(scan);
                Engine.Clear();
            }
        }

        [Test]
        public void CustomPassesThatAreOffAreNoted()
        {
            using (new Pipeline("HDRP"))
            {
                ((HDRenderPipelineAsset)UnityEngine.Rendering.GraphicsSettings.currentRenderPipeline).currentPlatformRenderPipelineSettings = default;
                Fails("Project settings", "has Rendering > Custom Pass turned off");
            }
        }

        /// Of what the limits must tell: a picture against itself, changed.
        [TestCase("brighter")]
        [TestCase("redder")]
        [TestCase("upside down")]
        [TestCase("shifted")]
        public void LimitsTellWhatIsWrong(string how)
        {
            foreach (var scene in CheckScene.All)
            {
                var expected = CheckPicture.Expected(scene.Name);
                Assert.AreEqual((0f, 0f), expected.DifferenceFrom(expected));
                var texture = expected.ToTexture(true);
                int side = CheckStage.Side;
                var pixels = texture.GetPixels32();
                byte Scale(byte value, float by) => (byte)Mathf.Min(255, value * by);
                var changed = new Color32[pixels.Length];
                for (var y = 0; y < side; y++)
                    for (var x = 0; x < side; x++)
                    {
                        var pixel = pixels[y * side + x];
                        if (how == "upside down") pixel = pixels[(side - 1 - y) * side + x];
                        if (how == "shifted") pixel = pixels[y * side + Math.Min(side - 1, x + 3)];
                        if (how == "brighter") pixel = new Color32(Scale(pixel.r, 1.1f), Scale(pixel.g, 1.1f), Scale(pixel.b, 1.1f), 255);
                        if (how == "redder") pixel = new Color32(Scale(pixel.r, 1.2f), pixel.g, pixel.b, 255);
                        changed[y * side + x] = pixel;
                    }
                texture.SetPixels32(changed);
                var (mean, most) = CheckPicture.Of(texture).DifferenceFrom(expected);
                Object.DestroyImmediate(texture);
                Assert.IsTrue(mean > CheckPicture.LargestMean || most > CheckPicture.LargestOfSquare, $"{scene}, {how}: {mean}, {most}");
            }
        }
    }
}
