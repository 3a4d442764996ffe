// The pictures of Documentation~: `script/unity --pictures` makes them anew. They show phantoms only.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using Lumivox.Editor;
using NUnit.Framework;
using StandIn;
using UnityEditor;
using UnityEngine;
using UnityEngine.UIElements;
using Image = UnityEngine.UIElements.Image;
using Object = UnityEngine.Object;
using Picture = StandIn.Picture;

namespace Lumivox.Tests
{
    [Explicit]
    public sealed partial class DocumentationPictures
    {
        const int Width = 480, Height = 320;
        /// Of those that show what is small.
        const int LargeWidth = 720, LargeHeight = 480;

        /// Of a pixel. STANDIN_SAMPLES asks for fewer, to look at how a picture is framed.
        static int Samples => int.TryParse(Environment.GetEnvironmentVariable("STANDIN_SAMPLES"), out var samples) ? samples : 24;

        readonly List<Object> made = new List<Object>();
        Camera camera;
        LumivoxEffect effect;

        static string Folder
        {
            get
            {
                var folder = Environment.GetEnvironmentVariable("STANDIN_DOCUMENTATION");
                Assert.IsFalse(string.IsNullOrEmpty(folder), "STANDIN_DOCUMENTATION names no folder: script/unity --pictures does");
                return folder;
            }
        }

        [SetUp]
        public void Begin()
        {
            EditorProject.Begin();
            Engine.Clear();
            Engine.SetScreen(Width, Height);
            // A new project's: a sun, and a sky that is blue above and grey below.
            Props.sky = Sky;
            Props.isShaded = true;
            RenderSettings.skybox = Keep(new Material(Resources.Load<Shader>("Lumivox/LumivoxDepth")));
            RenderSettings.ambientMode = UnityEngine.Rendering.AmbientMode.Skybox;
            var sun = new GameObject("Directional Light").AddComponent<Light>();
            sun.type = LightType.Directional;
            sun.color = new Color(1f, 0.957f, 0.839f);
            sun.transform.rotation = Quaternion.Euler(50f, -30f, 0f);
            camera = new GameObject("Main Camera").AddComponent<Camera>();
            camera.tag = "MainCamera";
            camera.nearClipPlane = 0.02f;
            camera.transform.position = new Vector3(0f, 0f, -0.5f);
            camera.allowHDR = true;
            effect = camera.gameObject.AddComponent<LumivoxEffect>();
            effect.targetSamples = Samples;
            effect.denoise = true;
            effect.frameBudgetMs = 1000f;
        }

        [TearDown]
        public void End()
        {
            if (Application.isPlaying) Domain.Stop();
            LumivoxRuntime.Stop();
            Props.Clear();
            RenderSettings.skybox = null;
            foreach (var one in made) Object.DestroyImmediate(one);
            made.Clear();
            Engine.Clear();
        }

        T Keep<T>(T one) where T : Object
        {
            made.Add(one);
            return one;
        }

        static Color Sky(Vector3 way)
        {
            if (way.y < 0f) return Color.Lerp(new Color(0.36f, 0.38f, 0.4f), new Color(0.1f, 0.095f, 0.09f), Mathf.Sqrt(-way.y));
            return Color.Lerp(new Color(0.55f, 0.63f, 0.7f), new Color(0.07f, 0.16f, 0.33f), Mathf.Pow(way.y, 0.6f));
        }

        LumivoxVolume Head(string preset = "", int size = 160)
        {
            var volume = new GameObject("Head Phantom").AddComponent<LumivoxVolume>();
            volume.volume = Keep(LumivoxVolumeAsset.Phantom("head", size));
            EditorProject.Until(() => volume.volume.state == LumivoxVolumeState.Ready, "the phantom is computed");
            if (preset != "") volume.ApplyPreset(preset);
            return volume;
        }

        /// What the camera sees when nothing is missing any more.
        Picture Shoot()
        {
            for (var i = 0; i < 4000; i++)
            {
                Engine.Frame();
                Ticker.Tick();
                if (i > 2 && LumivoxRuntime.StatusOf(camera).isConverged) break;
                Assert.IsTrue(i < 3999, $"no end; error: '{LumivoxRuntime.Error}'");
            }
            return Pictures.Color(camera);
        }

        static void Save(string name, Picture picture, bool encode = true)
        {
            var file = Path.Combine(Folder, name + ".png");
            Directory.CreateDirectory(Folder);
            File.WriteAllBytes(file, Png.Of(picture, encode));
            Console.WriteLine($"  {name}.png: {picture.width} x {picture.height}, {new FileInfo(file).Length / 1024} KB");
            Assert.IsTrue(new FileInfo(file).Length < 200 << 10, $"{name}.png is large for a picture in a manual");
        }

        GameObject Shape(PrimitiveType type, Vector3 position, float size, Color color)
        {
            var shape = GameObject.CreatePrimitive(type);
            shape.transform.localPosition = position;
            shape.transform.localScale = Vector3.one * size;
            var look = Keep(new Material(shape.GetComponent<Renderer>().sharedMaterial));
            look.color = color;
            shape.GetComponent<Renderer>().sharedMaterial = look;
            return shape;
        }

        [Test]
        public void FirstPicture()
        {
            Engine.SetScreen(LargeWidth, LargeHeight);
            Head();
            Save("first-picture", Shoot());
        }

        [Test]
        public void BoneAndCube()
        {
            Head("ct-bone");
            Shape(PrimitiveType.Cube, new Vector3(0.07f, -0.05f, -0.13f), 0.05f, new Color(0.8f, 0.45f, 0.2f)).transform.rotation = Quaternion.Euler(20f, 35f, 0f);
            Shape(PrimitiveType.Cube, Vector3.zero, 0.1f, new Color(0.2f, 0.45f, 0.8f));
            Save("bone-and-cube", Shoot());
        }

        [Test]
        public void ClipHandles()
        {
            Engine.SetScreen(LargeWidth, LargeHeight);
            var volume = Head("ct-skin");
            volume.clipMax = new Vector3(0.5f, 1f, 1f);
            // From the side that is cut away.
            var turn = Quaternion.Euler(10f, -38f, 0f);
            camera.transform.SetPositionAndRotation(turn * Vector3.back * 0.58f, turn);
            var shot = Shoot();
            var canvas = new Canvas(shot.width, shot.height);
            canvas.Image(canvas.Clip, shot.width, shot.height, (x, y) => shot.At(x, y).gamma);
            SceneHands.Clear();
            Gizmos.drawn.Clear();
            var editor = UnityEditor.Editor.CreateEditor(volume);
            EditorHost.DrawScene(editor, volume);
            Object.DestroyImmediate(editor);
            var depth = Pictures.Depth(camera);
            foreach (var (kind, matrix, color) in Gizmos.drawn)
                if (kind == "wire cube") Wire(canvas, matrix, color, depth);
            foreach (var (matrix, center, size, color) in SceneHands.Boxes)
            {
                var box = matrix * Matrix4x4.TRS(center, Quaternion.identity, size);
                Wire(canvas, box, color, null);
                Dots(canvas, box, color);
            }
            foreach (var (position, text) in SceneHands.Places) canvas.Text(text, Seen(canvas, position) + new Vector2(-5f, 6f), 16f, Color.white, true);
            Save("clip-handles", canvas.ToPicture(), encode: false);
        }

        [Test]
        public void CutOpen()
        {
            var volume = Head("ct-skin", 192);
            volume.transferFunction = Section();
            volume.maxBounces = Bounces;
            effect.exposure = 0.3f;
            effect.targetSamples = Samples / 2;
            // Before a plain, dark wall.
            camera.clearFlags = CameraClearFlags.SolidColor;
            camera.backgroundColor = new Color(0.16f, 0.19f, 0.24f);
            // A quarter of the head, above the eyes, on the side that is seen.
            var clip = new GameObject("Clip").AddComponent<LumivoxClip>();
            clip.transform.SetParent(volume.transform, false);
            clip.transform.localPosition = new Vector3(0.2f, 0.245f, -0.19f);
            clip.transform.localScale = Vector3.one * 0.4f;
            (clip.shape, clip.inverted) = (LumivoxClip.Shape.Box, true);
            Look(new Vector3(-0.005f, 0.045f, 0f), Quaternion.Euler(24f, -46f, 0f), 0.52f, 36f);
            Save("cut-open", Shoot());
        }

        /// Tissues in the colours of an atlas, each as opaque as the others: for sections.
        LumivoxTransferFunction Section()
        {
            var section = Keep(ScriptableObject.CreateInstance<LumivoxTransferFunction>());
            LumivoxTransferFunction.ColorStop Stop(float value, float r, float g, float b) => new LumivoxTransferFunction.ColorStop(value, new Color(r, g, b));
            section.SetPoints(
                new[] { new LumivoxTransferFunction.OpacityKnot(-600f, 0f), new LumivoxTransferFunction.OpacityKnot(-350f, 1f) },
                new[]
                {
                    // Skin where it meets the air, fat, fluid, white and grey matter, muscle, bone.
                    Stop(-250f, 0.91f, 0.73f, 0.63f), Stop(-110f, 0.96f, 0.85f, 0.6f), Stop(-30f, 0.85f, 0.6f, 0.5f), Stop(-4f, 0.62f, 0.4f, 0.42f),
                    Stop(18f, 0.98f, 0.9f, 0.82f), Stop(30f, 0.98f, 0.88f, 0.8f), Stop(39f, 0.84f, 0.52f, 0.47f), Stop(50f, 0.82f, 0.48f, 0.43f), Stop(66f, 0.72f, 0.26f, 0.22f), Stop(130f, 0.85f, 0.55f, 0.45f),
                    Stop(300f, 0.96f, 0.92f, 0.82f), Stop(1500f, 1f, 0.99f, 0.96f),
                });
            return section;
        }

        /// Kernels for parts are slow in software, and more bounces hardly show.
        const int Bounces = 8;

        /// The camera before a point, seen so many degrees high.
        void Look(Vector3 at, Quaternion turn, float distance, float degrees)
        {
            camera.fieldOfView = degrees;
            camera.transform.SetPositionAndRotation(at + turn * Vector3.back * distance, turn);
        }

        [Test]
        public void Labels()
        {
            var volume = new GameObject("Torso Phantom").AddComponent<LumivoxVolume>();
            volume.volume = Keep(LumivoxVolumeAsset.Phantom("torso", 192));
            EditorProject.Until(() => volume.volume.state == LumivoxVolumeState.Ready, "the phantom is computed");
            volume.ApplyPreset("ct-bone");
            var finding = LumivoxLabels.FoundIn(volume.volume);
            EditorProject.Until(() => finding.IsCompleted, "the labels are found");
            var labels = Keep(finding.Result);
            Keep(labels.map);
            Paint(labels, "lungs", new Color(0.93f, 0.55f, 0.55f), 0.03f);
            Paint(labels, "airways", new Color(0.3f, 0.7f, 0.98f), 3f);
            Paint(labels, "gas in the body", new Color(0.98f, 0.8f, 0.35f), 1f);
            volume.labels = labels;
            volume.maxBounces = Bounces;
            effect.exposure = 0.4f;
            effect.targetSamples = Samples / 2;
            Look(Vector3.zero, Quaternion.Euler(6f, -28f, 0f), 0.78f, 36f);
            Save("labels", Shoot());
        }

        /// Of one colour, whatever its values are.
        void Paint(LumivoxLabels labels, string name, Color color, float density)
        {
            Assert.IsTrue(labels.TryGetLook(name, out var look), name);
            var solid = Keep(ScriptableObject.CreateInstance<LumivoxTransferFunction>());
            solid.SetPoints(new[] { new LumivoxTransferFunction.OpacityKnot(-1024f, 1f) }, new[] { new LumivoxTransferFunction.ColorStop(0f, color) });
            (look.transferFunction, look.density) = (solid, density);
            labels.SetLook(look);
        }

        Vector2 Seen(Canvas canvas, Vector3 world)
        {
            var at = camera.WorldToViewportPoint(world);
            return new Vector2(at.x * canvas.width, (1f - at.y) * canvas.height);
        }

        /// The edges of a unit cube. Gizmos are faint where something is before them, handles nowhere.
        void Wire(Canvas canvas, Matrix4x4 matrix, Color color, Picture depth)
        {
            var clip = GL.GetGPUProjectionMatrix(camera.projectionMatrix, false) * camera.worldToCameraMatrix;
            bool IsHidden(Vector3 world)
            {
                var at = camera.WorldToViewportPoint(world);
                int x = (int)(at.x * canvas.width), y = (int)(at.y * canvas.height);
                if (depth == null || x < 0 || y < 0 || x >= canvas.width || y >= canvas.height) return false;
                var point = clip * new Vector4(world.x, world.y, world.z, 1f);
                return depth.At(x, y).r > point.z / point.w;
            }
            const int parts = 120;
            Vector3 Corner(int i) => matrix.MultiplyPoint3x4(new Vector3((i & 1) - 0.5f, (i >> 1 & 1) - 0.5f, (i >> 2 & 1) - 0.5f));
            for (var i = 0; i < 8; i++)
                for (var axis = 1; axis < 8; axis *= 2)
                {
                    if ((i & axis) != 0) continue;
                    Vector3 from = Corner(i), to = Corner(i | axis);
                    for (var part = 0; part < parts; part++)
                    {
                        Vector3 a = Vector3.Lerp(from, to, part / (float)parts), b = Vector3.Lerp(from, to, (part + 1f) / parts);
                        var shown = color;
                        if (IsHidden((a + b) / 2f)) shown.a *= 0.15f;
                        canvas.Line(new[] { Seen(canvas, a), Seen(canvas, b) }, shown, 1.5f);
                    }
                }
        }

        /// A handle in the middle of each face, faint on those that look away.
        void Dots(Canvas canvas, Matrix4x4 matrix, Color color)
        {
            for (var side = 0; side < 6; side++)
            {
                var normal = Vector3.zero;
                normal[side / 2] = side % 2 == 0 ? -1f : 1f;
                var middle = matrix.MultiplyPoint3x4(normal * 0.5f);
                var isAway = Vector3.Dot(matrix.MultiplyVector(normal), middle - camera.transform.position) > 0f;
                var at = Seen(canvas, middle);
                canvas.Fill(new Rect(at.x - 4f, at.y - 4f, 8f, 8f), new Color(color.r, color.g, color.b, isAway ? 0.3f : 1f));
            }
        }

        /// A sample as it is when it is played.
        T Sample<T>(float degrees) where T : Lumivox.Samples.SampleScene
        {
            foreach (var light in Object.FindObjectsByType<Light>(FindObjectsSortMode.None)) Object.DestroyImmediate(light.gameObject);
            new GameObject(typeof(T).Name).AddComponent<T>();
            Domain.Play();
            Engine.Frame();
            camera = Camera.main;
            // Closer than one plays it.
            camera.fieldOfView = degrees;
            EditorProject.Until(() => LumivoxVolume.All.Count > 0 && LumivoxVolume.All.All(volume => volume.volume != null && volume.volume.state == LumivoxVolumeState.Ready), "the scans are computed");
            return Object.FindObjectsByType<T>(FindObjectsSortMode.None).Single();
        }

        /// A window or an inspector, after the editor's turns that it wants.
        void SavePanel(string name, Panel panel, int width, int height) => Save(name, PanelPicture.Of(panel, width, height), encode: false);

        [Test]
        public void TransferFunctionWindow()
        {
            var volume = Head("ct-skin", 96);
            Selection.activeGameObject = volume.gameObject;
            Lumivox.Editor.TransferFunctionWindow.Open();
            var window = EditorWindow.GetWindow<Lumivox.Editor.TransferFunctionWindow>();
            // At its size in the picture, for what is drawn is told by it.
            window.panel.Resize(720, 340);
            EditorProject.Until(() => window.panel.Milliseconds > 1000, "the histogram is taken", window.panel);
            window.Field.Colors.Selected = 1;
            SavePanel("transfer-function", window.panel, 720, 340);
            window.Close();
        }

        [Test]
        public void VolumeInspector()
        {
            var volume = Head("ct-skin", 96);
            var (_, panel) = EditorHost.Inspect(volume);
            panel.Click(panel.visualTree.Q<Button>("open").worldBound.center);
            var gallery = panel.visualTree.Q<PresetGallery>();
            EditorProject.Until(() => gallery.Query<Image>().ToList().All(image => image.image != null), "the presets are pictured", panel);
            SavePanel("presets", panel, 460, 760);
            gallery.Fold();
        }

        [Test]
        public void ScanInspector()
        {
            var scan = Keep(LumivoxVolumeAsset.Phantom("head", 96));
            scan.name = "Head Phantom";
            scan.Open();
            EditorProject.Until(() => scan.state == LumivoxVolumeState.Ready, "the phantom is computed");
            var (_, panel) = EditorHost.Inspect(scan);
            SavePanel("scan-inspector", panel, 440, 145);
        }

        [Test]
        public void ImportWindow()
        {
            var study = Environment.GetEnvironmentVariable("STANDIN_STUDY");
            Assert.IsTrue(Directory.Exists(study), "STANDIN_STUDY names no folder of DICOM files: script/unity --pictures makes one of phantoms");
            var window = Lumivox.Editor.ImportWindow.Open(study);
            EditorProject.Until(() => window.Now == Lumivox.Editor.ImportWindow.Step.Ready && window.rootVisualElement.Q<Image>("thumbnail").image != null, "the study is looked at", window.panel);
            // Where it lies on one machine is nobody's business.
            window.rootVisualElement.Q<TextField>("path").SetValueWithoutNotify("/home/me/scans/phantoms");
            SavePanel("import-window", window.panel, 640, 460);
            window.Close();
        }

        /// What the self-check expects to see: the same scenes, with hardly any noise.
        [TestCase("cube-at-distances")]
        [TestCase("occlusion")]
        [TestCase("several-volumes")]
        [TestCase("lights")]
        public void Expected(string name)
        {
            Object.DestroyImmediate(camera.gameObject);
            // The meshes shine by themselves.
            Props.isShaded = false;
            var file = Path.Combine(Folder, "../../SelfCheck/Expected~", name + ".png");
            var drawing = SelfChecks.CheckScene.All.Single(one => one.Name == name).Draw(true, ExpectedSamples, picture => picture.Save(file));
            while (drawing.MoveNext()) EditorHost.Frame();
            Console.WriteLine($"  {name}.png: {new FileInfo(file).Length / 1024} KB");
        }

        const int ExpectedSamples = 256;

        [Test]
        public void CubeAtDistances()
        {
            Sample<Lumivox.Samples.CubeAtDistances>(46f);
            Save("cube-at-distances", Shoot());
        }

        [Test]
        public void Occlusion()
        {
            Sample<Lumivox.Samples.Occlusion>(36f).period = 0f;
            Save("occlusion", Shoot());
        }

        [Test]
        public void SeveralVolumes()
        {
            Sample<Lumivox.Samples.SeveralVolumes>(38f);
            Save("several-volumes", Shoot());
        }
    }
}
