// The samples as a person has them: imported into a project, opened from the menu, played, drawn.
using System;
using System.IO;
using System.Linq;
using Lumivox.Samples;
using NUnit.Framework;
using StandIn;
using UnityEditor;
using UnityEngine;
using UnityEngine.UIElements;
using UnityEngine.XR;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed class SampleTests
    {
        const int Side = 40;
        const string Imported = "Assets/Samples/Lumivox/Scenes";

        [SetUp]
        public void Begin()
        {
            Engine.Clear();
            EditorProject.Begin();
            Engine.SetScreen(Side, Side);
            Headset.width = Headset.height = Side;
        }

        [TearDown]
        public void End()
        {
            if (Application.isPlaying) Domain.Stop();
            LumivoxRuntime.Stop();
            Directory.Delete(EditorProject.Full("Assets/Samples"), true);
            Engine.Clear();
            EditorProject.Begin();
        }

        /// Opens a sample from the menu and presses Play. `voxels` along each side, or the scan that the sample chooses.
        static T Play<T>(string item, int voxels = 40, Action<T> change = null) where T : SampleScene
        {
            Import();
            EditorHost.Menu("Window/Lumivox/Samples/" + item);
            var sample = Selection.activeGameObject.GetComponent<T>();
            if (voxels > 0) sample.scan = LumivoxVolumeAsset.Phantom("head", voxels);
            change?.Invoke(sample);
            // A still for each picture: what is not the sample's own stays out of the way.
            var effect = new GameObject("Effect").AddComponent<LumivoxEffect>();
            (effect.targetSamples, effect.frameBudgetMs) = (8, 1000f);
            Domain.Play();
            sample = Object.FindObjectsByType<T>(FindObjectsSortMode.None).Single();
            Engine.Frame();
            return sample;
        }

        /// What the Package Manager's button does.
        static void Import()
        {
            var folder = Path.Combine(Packages.all.First(), "Samples~/Scenes");
            foreach (var file in Directory.GetFiles(folder, "*", SearchOption.AllDirectories))
            {
                var to = EditorProject.Full(Path.Combine(Imported, Path.GetRelativePath(folder, file)));
                Directory.CreateDirectory(Path.GetDirectoryName(to));
                File.Copy(file, to, true);
            }
            AssetDatabase.Refresh();
        }

        static Picture Settled()
        {
            bool IsThere() => LumivoxVolume.All.Count > 0 && LumivoxRenderer.IsConverged(Camera.main) && LumivoxVolume.All.All(volume => volume.volume.state == LumivoxVolumeState.Ready);
            if (Waiting.Frames(IsThere, EditorHost.Frame)) return Pictures.Color(Camera.main);
            var status = LumivoxRenderer.GetStatus(Camera.main);
            Assert.Fail($"{status.samples} of {status.target} samples, shown: {status.isShown}, error: '{LumivoxRenderer.LastError}'");
            return null;
        }

        /// The same without volumes.
        static Picture Empty()
        {
            var volumes = LumivoxVolume.All.ToArray();
            foreach (var volume in volumes) volume.enabled = false;
            Engine.Frame();
            var picture = Pictures.Color(Camera.main);
            foreach (var volume in volumes) volume.enabled = true;
            return picture;
        }

        static Color At(Picture picture, Vector3 place)
        {
            var at = Camera.main.WorldToViewportPoint(place);
            return picture.At((int)(at.x * picture.width), (int)(at.y * picture.height));
        }

        static float Off(Color a, Color b) => Mathf.Abs(a.r - b.r) + Mathf.Abs(a.g - b.g) + Mathf.Abs(a.b - b.b);

        static int Changed(Picture a, Picture b) => Enumerable.Range(0, a.pixels.Length).Count(i => Off(a.pixels[i], b.pixels[i]) > 0.02f);

        [Test]
        public void CubesAtDistancesLookAlikeUnlessExtinctionIsTheWorlds()
        {
            (float covered, Color light)[] Three(LumivoxVolume.ExtinctionSpace space)
            {
                Play<CubeAtDistances>("Cube at Distances", 0, sample => sample.extinctionSpace = space);
                var with = Settled();
                var without = Empty();
                Assert.AreEqual(3, LumivoxVolume.All.Count);
                Assert.IsTrue(LumivoxVolume.All.All(volume => volume.extinctionSpace == space && volume.volume.dimensions.x == 96));
                var three = LumivoxVolume.All.OrderBy(volume => volume.transform.localScale.x).Select(volume =>
                {
                    // Its third of the picture.
                    var at = Camera.main.WorldToViewportPoint(volume.transform.position).x;
                    Assert.IsTrue(Off(At(with, volume.transform.position), At(without, volume.transform.position)) > 0.05f, $"nothing is seen of {volume.name}");
                    var (sum, count) = (Color.clear, 0);
                    for (var x = (int)((at - 1f / 6f) * Side); x < (at + 1f / 6f) * Side; x++)
                        for (var y = 0; y < Side; y++)
                        {
                            if (x < 0 || x >= Side || Off(with.At(x, y), without.At(x, y)) < 0.02f) continue;
                            sum += with.At(x, y);
                            count++;
                        }
                    return ((float)count, sum / count);
                }).ToArray();
                Domain.Stop();
                return three;
            }
            var alike = Three(LumivoxVolume.ExtinctionSpace.Volume);
            var other = Three(LumivoxVolume.ExtinctionSpace.World);
            float Redness(Color color) => color.r / (color.g + color.b);
            foreach (var one in alike) Assert.AreEqual(alike[0].covered, one.covered, 0.2f * alike[0].covered);
            foreach (var one in alike) Assert.AreEqual(Redness(alike[0].light), Redness(one.light), 0.25f * Redness(alike[0].light));
            Assert.IsTrue(Redness(other[2].light) > 1.2f * Redness(other[0].light), "the largest is no redder in the world's millimetres");
        }

        [Test]
        public void SeveralVolumesAreAllSeenAndShareFourFunctions()
        {
            var sample = Play<SeveralVolumes>("Several Volumes", 24);
            var with = Settled();
            Assert.AreEqual(sample.count, LumivoxVolume.All.Count);
            Assert.AreEqual(4, LumivoxVolume.All.Select(volume => volume.transferFunction).Distinct().Count());
            Assert.IsTrue(LumivoxVolume.All.All(volume => volume.volume == sample.scan));
            // Each leaves something less to see.
            var unseen = 0;
            foreach (var volume in LumivoxVolume.All.ToArray())
            {
                if (Off(At(with, volume.transform.position), Color.black) < 0.02f) unseen++;
            }
            Assert.IsTrue(unseen < sample.count / 4, $"{unseen} of {sample.count} lie where nothing is seen");
            Assert.IsTrue(Changed(with, Empty()) > Side * Side / 10);
        }

        [Test]
        public void OcclusionHasASphereBeforeOneInsideOneBehindAndOneThatFlies()
        {
            var sample = Play<Occlusion>("Occlusion", 40, one => one.period = 0f);
            var with = Settled();
            var without = Empty();
            Assert.IsTrue(Off(At(with, Vector3.zero), At(without, Vector3.zero)) > 0.05f, "nothing is seen of the head");
            Color Of(int index) => sample.GetComponentsInChildren<Renderer>()[index].material.color.linear;
            // In the order in which they are made: before, behind, the floor, the traveller, inside.
            var spheres = sample.GetComponentsInChildren<Renderer>().Select(renderer => renderer.transform).ToArray();
            Assert.AreEqual(5, spheres.Length);
            Assert.IsTrue(Off(Of(0), At(with, spheres[0].position)) < 0.01f, $"{At(with, spheres[0].position)} is before everything");
            Assert.IsTrue(Off(Of(0), At(without, spheres[0].position)) < 0.01f);
            Assert.IsTrue(Off(Of(4), At(with, spheres[4].position)) > 0.05f, $"{At(with, spheres[4].position)} is in the head");
            Assert.IsTrue(Off(Of(4), At(without, spheres[4].position)) < 0.01f);
            // From where one begins, the one behind is seen in part beside the head, and in part through it.
            var across = Camera.main.transform.right * (spheres[1].localScale.x * 0.35f);
            Assert.IsTrue(Off(Of(1), At(with, spheres[1].position - across)) < 0.05f, $"{At(with, spheres[1].position - across)} is beside the head");
            Assert.IsTrue(Off(Of(1), At(with, spheres[1].position + across)) > 0.05f, $"{At(with, spheres[1].position + across)} is behind it");
            float Distance(Vector3 place) => Camera.main.WorldToViewportPoint(place).z;
            Assert.IsTrue(Distance(spheres[0].position) < Distance(Vector3.zero) && Distance(spheres[1].position) > Distance(Vector3.zero));
            // Seen through the head, the other one is not as it is; from the other side it is.
            var view = Camera.main.GetComponent<OrbitCamera>();
            view.Move(Mathf.Atan2(spheres[1].position.x, spheres[1].position.z) * Mathf.Rad2Deg - view.azimuth, 0f, 1f);
            var through = Settled();
            Assert.IsTrue(Off(Of(1), At(through, spheres[1].position)) > 0.05f, $"{At(through, spheres[1].position)} is behind the head");
            Assert.IsTrue(Off(Of(1), At(Empty(), spheres[1].position)) < 0.01f);
            view.Move(180f, 0f, 1f);
            var turned = Settled();
            Assert.IsTrue(Off(Of(1), At(turned, spheres[1].position)) < 0.01f, $"{At(turned, spheres[1].position)} is before everything from there");
            var still = spheres[3].position;
            Engine.Frames(3);
            Assert.AreEqual(still, spheres[3].position);
            sample.period = 9f;
            Engine.Frames(3);
            Assert.AreNotEqual(still, spheres[3].position);
        }

        [Test]
        public void TheHeadsetRigIsASceneLikeOthersWithoutAHeadset()
        {
            Play<HeadsetRig>("Headset Rig");
            var with = Settled();
            Assert.IsTrue(Changed(with, Empty()) > 20, "nothing is seen of the head");
            Assert.IsTrue(Camera.main.GetComponent<OrbitCamera>().enabled);
            Assert.AreEqual(0, Object.FindObjectsByType<Renderer>(FindObjectsSortMode.None).Length, "no hands are seen");
        }

        [Test]
        public void InAHeadsetHandsMoveScaleAndCutTheHead()
        {
            Headset.isOn = true;
            foreach (var node in new[] { XRNode.CenterEye, XRNode.LeftHand, XRNode.RightHand }) Devices.Connect(node);
            void Place(XRNode node, float x, float y, float z) => Devices.Tell(node, CommonUsages.devicePosition, new Vector3(x, y, z));
            Devices.Tell(XRNode.CenterEye, CommonUsages.centerEyePosition, new Vector3(0f, 1.25f, -0.7f));
            Devices.Tell(XRNode.CenterEye, CommonUsages.centerEyeRotation, Quaternion.identity);
            Place(XRNode.LeftHand, -0.3f, 1.2f, -0.3f);
            Place(XRNode.RightHand, 0.3f, 1.2f, -0.3f);
            Play<HeadsetRig>("Headset Rig");
            var head = LumivoxVolume.All.Single();
            Settled();
            Assert.IsFalse(Camera.main.GetComponent<OrbitCamera>().enabled);
            Assert.AreEqual(new Vector3(0f, 1.25f, -0.7f), Camera.main.transform.position);
            foreach (Camera.StereoscopicEye eye in Enum.GetValues(typeof(Camera.StereoscopicEye)))
            {
                var picture = Pictures.Color(Camera.main, eye);
                Assert.IsTrue(picture.pixels.Count(color => Off(color, Color.black) > 0.02f) > 20, $"the {eye} eye sees nothing");
            }

            // One hand takes it along.
            var at = head.transform.position;
            Devices.Tell(XRNode.RightHand, CommonUsages.grip, 1f);
            Engine.Frame();
            Place(XRNode.RightHand, 0.4f, 1.3f, -0.3f);
            Engine.Frame();
            Assert.IsTrue((head.transform.position - at - new Vector3(0.1f, 0.1f, 0f)).magnitude < 1e-4f, $"{head.transform.position}");
            // Two scale it by their distance.
            Place(XRNode.RightHand, 0.3f, 1.2f, -0.3f);
            Engine.Frame();
            Devices.Tell(XRNode.LeftHand, CommonUsages.grip, 1f);
            Engine.Frame();
            Place(XRNode.LeftHand, -0.6f, 1.2f, -0.3f);
            Place(XRNode.RightHand, 0.6f, 1.2f, -0.3f);
            Engine.Frame();
            Assert.AreEqual(2f, head.transform.localScale.x, 1e-3f);
            // Nobody holds it any more.
            Devices.Tell(XRNode.LeftHand, CommonUsages.grip, 0f);
            Devices.Tell(XRNode.RightHand, CommonUsages.grip, 0f);
            at = head.transform.position;
            Place(XRNode.LeftHand, -0.3f, 1.2f, -0.3f);
            Engine.Frames(2);
            Assert.AreEqual(at, head.transform.position);

            // A hand before it, pointing away from the eyes, cuts to where it is; it is seen.
            var whole = Settled();
            var box = head.volume.localBounds;
            var halfway = head.transform.TransformPoint(box.center);
            Place(XRNode.RightHand, halfway.x, halfway.y, halfway.z);
            Devices.Tell(XRNode.RightHand, CommonUsages.deviceRotation, Quaternion.identity);
            Devices.Tell(XRNode.RightHand, CommonUsages.trigger, 1f);
            Engine.Frame();
            var clip = head.clipMax - head.clipMin;
            Assert.AreEqual(0.5f, Mathf.Min(clip.x, Mathf.Min(clip.y, clip.z)), 0.01f, $"{head.clipMin} {head.clipMax}");
            Devices.Tell(XRNode.RightHand, CommonUsages.trigger, 0f);
            Place(XRNode.RightHand, 0.9f, 1.2f, -0.3f);
            Place(XRNode.LeftHand, -0.9f, 1.2f, -0.3f);
            Assert.IsTrue(Changed(whole, Settled()) > 20, "nobody sees the cut");
            Devices.Tell(XRNode.RightHand, CommonUsages.primaryButton, true);
            Engine.Frame();
            Assert.AreEqual(Vector3.zero, head.clipMin);
            Assert.AreEqual(Vector3.one, head.clipMax);
            // Taken off, the camera circles again.
            Headset.isOn = false;
            Devices.Disconnect(XRNode.CenterEye);
            Engine.Frame();
            Assert.IsTrue(Camera.main.GetComponent<OrbitCamera>().enabled);
        }

        [Test]
        public void AGameImportsAScanAndShowsIt()
        {
            var sample = Play<RuntimeImport>("Runtime Import");
            var document = sample.GetComponent<UIDocument>();
            Assert.AreEqual($"{Imported}/LumivoxSamples.asset", AssetDatabase.GetAssetPath(document.panelSettings));
            Assert.AreEqual("LumivoxSamples", document.panelSettings.themeStyleSheet.name);
            var panel = new Panel(document.rootVisualElement, 900, 600);
            Button Named(string text) => document.rootVisualElement.Query<Button>().ToList().Single(button => button.text == text);
            string Said() => document.rootVisualElement.Query<Label>().ToList().Select(label => label.text).First(text => text != "Scan" && text.Length > 3);
            void Choose(string path)
            {
                document.rootVisualElement.Q<TextField>().value = path;
                panel.Update();
                panel.Click(Named("Import").worldBound.center);
                Assert.IsFalse(Named("Import").enabledSelf);
                Assert.IsTrue(Named("Stop").enabledSelf);
                Assert.IsTrue(Waiting.Turns(() => Named("Import").enabledSelf, () => Engine.Frame()), Said());
            }
            var volume = LumivoxVolume.All.Single();
            Assert.IsTrue(Changed(Settled(), Empty()) > 20, "nothing is seen of the head");

            Choose("/nowhere/at/all");
            StringAssert.Contains("/nowhere/at/all", Said());
            Assert.AreSame(sample.scan, volume.volume);

            Choose(Scan("ball.nrrd"));
            StringAssert.StartsWith("16 x 16 x 16 voxels.", Said());
            var first = volume.volume;
            Assert.AreEqual(new Vector3Int(16, 16, 16), first.dimensions);
            Assert.AreSame(volume.transferFunction, document.rootVisualElement.Q<TransferFunctionField>().transferFunction);
            Assert.IsTrue(Changed(Settled(), Empty()) > 20, "nothing is seen of what was imported");
            // What came before is nobody's any more.
            Choose(Scan("ball.nrrd"));
            Engine.Frame();
            Assert.IsTrue(first == null && volume.volume != null);
        }

        /// A ball of bright voxels, a decimetre wide.
        static string Scan(string name)
        {
            const int side = 16;
            var header = System.Text.Encoding.ASCII.GetBytes($"NRRD0004\ntype: uint16\ndimension: 3\nspace: left-posterior-superior\nsizes: {side} {side} {side}\nspace directions: (10,0,0) (0,10,0) (0,0,10)\nspace origin: (0,0,0)\nendian: little\nencoding: raw\n\n");
            var bytes = new byte[header.Length + 2 * side * side * side];
            header.CopyTo(bytes, 0);
            for (var i = 0; i < side * side * side; i++)
            {
                var from = new Vector3(i % side, i / side % side, i / side / side) - Vector3.one * 7.5f;
                BitConverter.GetBytes((ushort)(from.magnitude < 6f ? 900 : i % 10)).CopyTo(bytes, header.Length + 2 * i);
            }
            var path = Path.Combine(EditorProject.Full("Assets/Samples"), name);
            File.WriteAllBytes(path, bytes);
            return path;
        }

        [Test]
        public void KeysTurnTheCameraAndItStaysWhereTheyLeaveIt()
        {
            Play<SeveralVolumes>("Several Volumes", 16, sample => sample.count = 1);
            var view = Camera.main.GetComponent<OrbitCamera>();
            var (azimuth, elevation, distance) = (view.azimuth, view.elevation, view.distance);
            Keys.held.Add(KeyCode.LeftArrow);
            Keys.held.Add(KeyCode.DownArrow);
            Engine.Frames(30);
            Keys.held.Clear();
            Assert.AreEqual(azimuth + 30f, view.azimuth, 0.01f);
            Assert.AreEqual(elevation - 30f, view.elevation, 0.01f);
            Keys.held.Add(KeyCode.PageUp);
            Engine.Frame();
            Keys.held.Clear();
            Assert.IsTrue(view.distance < distance);
            var place = view.transform.position;
            Engine.Frames(5);
            Assert.AreEqual(place, view.transform.position);
            Assert.AreEqual(view.distance, (place - view.pivot).magnitude, 1e-4f);
            Assert.IsTrue(Vector3.Angle(view.transform.forward, view.pivot - place) < 0.1f);
        }

        [Test]
        public void AMenuItemMakesASceneAndUsesThePanelSettingsThatAreThere()
        {
            Import();
            var old = new GameObject("What was there");
            EditorHost.Menu("Window/Lumivox/Samples/Runtime Import");
            Assert.IsTrue(old == null, "the scene is a new one");
            var settings = Selection.activeGameObject.GetComponent<UIDocument>().panelSettings;
            EditorHost.Menu("Window/Lumivox/Samples/Runtime Import");
            Assert.AreSame(settings, Selection.activeGameObject.GetComponent<UIDocument>().panelSettings);
            // Who does not want to lose a scene keeps it.
            Dialogs.Answers.Enqueue(false);
            var kept = Selection.activeGameObject;
            EditorHost.Menu("Window/Lumivox/Samples/Occlusion");
            Assert.IsTrue(kept != null);
            Assert.AreSame(kept, Selection.activeGameObject);
        }
    }
}
