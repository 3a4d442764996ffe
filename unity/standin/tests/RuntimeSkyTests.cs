// Skies that are baked: one for all worlds that show it, gone with the last of them.
using System.Linq;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using UnityEngine.Rendering;

namespace Lumivox.Tests
{
    public sealed class RuntimeSkyTests : CubeScene
    {
        const int Other = 3;

        Camera second;
        Material red, blue;

        /// After the base's.
        void BeginWorlds()
        {
            var shader = Resources.Load<Shader>("Lumivox/LumivoxDepth");
            (red, blue) = (new Material(shader), new Material(shader));
            Props.skies[red] = _ => new Color(1f, 0.05f, 0.05f);
            Props.skies[blue] = _ => new Color(0.05f, 0.05f, 1f);
            RenderSettings.ambientMode = AmbientMode.Skybox;
            RenderSettings.skybox = red;
            camera.GetComponent<LumivoxEffect>().environmentSource = LumivoxEnvironmentSource.Scene;
            camera.cullingMask = 1;
            // A world of its own: another layer, another volume.
            second = PlainCamera.Make(Side);
            second.GetComponent<LumivoxEffect>().environmentSource = LumivoxEnvironmentSource.Scene;
            second.cullingMask = 1 << Other;
            var twin = new GameObject("Twin") { layer = Other }.AddComponent<LumivoxVolume>();
            (twin.volume, twin.transferFunction, twin.density, twin.surfaceStrength) = (scan, look, 50f, 0f);
        }

        [TearDown]
        public void EndSkies()
        {
            Camera.onPreCull -= SwapSky;
            RenderSettings.skybox = null;
            Props.Clear();
            Object.DestroyImmediate(red);
            Object.DestroyImmediate(blue);
        }

        /// As where the editor shows a prefab in one view and the scene in another.
        void SwapSky(Camera seen) => RenderSettings.skybox = seen == second ? blue : red;

        static int Baked => Objects.All().OfType<Camera>().Count(one => one != null && one.name == "Lumivox Sky");

        void SettleBoth()
        {
            if (Waiting.Frames(() => LumivoxRenderer.IsConverged(camera) && LumivoxRenderer.IsConverged(second))) return;
            Assert.Fail($"{LumivoxRenderer.GetStatus(camera).isConverged} and {LumivoxRenderer.GetStatus(second).isConverged}, {Baked} baked, error: '{LumivoxRenderer.LastError}'");
        }

        Color Middle(Camera of) => At(Pictures.Color(of), 0.5f, 0.5f);

        [Test]
        public void WorldsUnderOneSkyShareIt()
        {
            BeginWorlds();
            SettleBoth();
            Assert.AreEqual(1, Baked);
            foreach (var one in new[] { camera, second }) Assert.IsTrue(Middle(one).r > 3f * Middle(one).b, $"{Middle(one)}");
            RenderSettings.skybox = null;
            SettleBoth();
            Assert.AreEqual(0, Baked, "nobody shows it any more");
        }

        [Test]
        public void WorldsUnderTwoSkiesAreEachLitByTheirOwn()
        {
            BeginWorlds();
            Camera.onPreCull += SwapSky;
            SettleBoth();
            Assert.AreEqual(2, Baked);
            Assert.IsTrue(Middle(camera).r > 3f * Middle(camera).b, $"{Middle(camera)}");
            Assert.IsTrue(Middle(second).b > 3f * Middle(second).r, $"{Middle(second)}");
            // The world of a camera that is gone is kept for a while, should it come back.
            Object.DestroyImmediate(second.gameObject);
            for (var i = 0; i < 310; i++) Engine.Frame();
            Ticker.Tick();
            Assert.AreEqual(1, Baked);
            Assert.IsTrue(LumivoxRenderer.IsConverged(camera));
        }

        [Test]
        public void ASkyStaysUntilTheNextOneIsThere()
        {
            BeginWorlds();
            SettleBoth();
            RenderSettings.skybox = blue;
            Waiting.Frames(() => Middle(camera).r <= Middle(camera).b, () => Assert.IsTrue(Light(Middle(camera)) > 0.02f, $"{Middle(camera)}"));
            SettleBoth();
            Assert.IsTrue(Middle(camera).b > 3f * Middle(camera).r, $"{Middle(camera)}");
            Assert.AreEqual(1, Baked);
        }

        [Test]
        public void NobodyWaitsForASkyThatLightsNothing()
        {
            BeginWorlds();
            Engine.Frame();
            Ticker.Tick();
            RenderSettings.ambientMode = AmbientMode.Flat;
            SettleBoth();
            Assert.AreEqual(0, Baked);
        }
    }
}
