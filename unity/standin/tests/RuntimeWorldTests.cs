// Lights, environments and cameras as numbers of the native library.
using Lumivox.Native;
using NUnit.Framework;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.Universal;

namespace Lumivox.Tests
{
    public sealed class RuntimeWorldTests
    {
        [TearDown]
        public void End()
        {
            GraphicsSettings.defaultRenderPipeline = null;
            foreach (var thing in Object.FindObjectsByType<GameObject>(FindObjectsSortMode.None)) Object.DestroyImmediate(thing);
        }

        static Light Light(LightType type)
        {
            var light = new GameObject("Light").AddComponent<Light>();
            light.type = type;
            light.color = Color.white;
            light.intensity = 1f;
            return light;
        }

        static void Near(Vector3 expected, Vector3 value) => Assert.IsTrue((expected - value).magnitude < 1e-4f * (1f + expected.magnitude), $"{value} is not {expected}");

        [Test]
        public void AWhiteSunOfOneHasAnIrradianceOfPi()
        {
            var sun = Light(LightType.Directional);
            sun.transform.rotation = Quaternion.Euler(90f, 0f, 0f);
            var source = default(LightSource);
            Assert.IsTrue(LightReader.TryRead(sun, ref source));
            Assert.AreEqual(LightSource.Directional, source.kind);
            Near(Vector3.one * Mathf.PI, source.strength);
            Near(Vector3.down, source.direction);
        }

        [Test]
        public void IntensityIsTakenAsThePipelineTakesIt()
        {
            var lamp = Light(LightType.Point);
            lamp.intensity = 2f;
            lamp.range = 7f;
            lamp.color = new Color(0.5f, 1f, 1f);
            var source = default(LightSource);
            GraphicsSettings.lightsUseLinearIntensity = false;
            Assert.IsTrue(LightReader.TryRead(lamp, ref source));
            // Without linear intensities colour and intensity are multiplied before they are made linear.
            Near(new Vector3(Mathf.GammaToLinearSpace(1f), Mathf.GammaToLinearSpace(2f), Mathf.GammaToLinearSpace(2f)) * Mathf.PI, source.strength);
            Assert.AreEqual(LightSource.BuiltIn, source.falloff);
            Assert.AreEqual(7f, source.range);
            GraphicsSettings.lightsUseLinearIntensity = true;
            Assert.IsTrue(LightReader.TryRead(lamp, ref source));
            Near(new Vector3(Mathf.GammaToLinearSpace(0.5f), 1f, 1f) * 2f * Mathf.PI, source.strength);
            GraphicsSettings.defaultRenderPipeline = ScriptableObject.CreateInstance<UniversalRenderPipelineAsset>();
            Assert.IsTrue(LightReader.TryRead(lamp, ref source));
            Assert.AreEqual(LightSource.InverseSquare, source.falloff);
            GraphicsSettings.lightsUseLinearIntensity = false;
        }

        [Test]
        public void ASpotsAnglesAreHalvesInRadians()
        {
            var spot = Light(LightType.Spot);
            spot.spotAngle = 60f;
            spot.innerSpotAngle = 20f;
            spot.cullingMask = 1 << 5;
            GraphicsSettings.defaultRenderPipeline = ScriptableObject.CreateInstance<UniversalRenderPipelineAsset>();
            var source = default(LightSource);
            Assert.IsTrue(LightReader.TryRead(spot, ref source));
            Assert.AreEqual(Mathf.PI / 6f, source.outerHalfAngle, 1e-5f);
            Assert.AreEqual(Mathf.PI / 18f, source.innerHalfAngle, 1e-5f);
            Assert.AreEqual(32u, source.layers);
        }

        [Test]
        public void ASpotOfTheBuiltInPipelineIsSoftInItsOuterFifth()
        {
            var spot = Light(LightType.Spot);
            spot.spotAngle = 50f;
            spot.innerSpotAngle = 10f;
            spot.range = 7f;
            var source = default(LightSource);
            Assert.IsTrue(LightReader.TryRead(spot, ref source));
            Assert.AreEqual(LightSource.BuiltIn, source.falloff);
            Assert.AreEqual(7f, source.range);
            Assert.AreEqual(25f * Mathf.Deg2Rad, source.outerHalfAngle, 1e-5f);
            Assert.AreEqual(20f * Mathf.Deg2Rad, source.innerHalfAngle, 1e-5f);
        }

        [Test]
        public void HDRPKeepsTheInnerConeAsAShareOfTheOuter()
        {
            GraphicsSettings.defaultRenderPipeline = ScriptableObject.CreateInstance<UnityEngine.Rendering.HighDefinition.HDRenderPipelineAsset>();
            var spot = Light(LightType.Spot);
            spot.spotAngle = 60f;
            var data = spot.gameObject.AddComponent<UnityEngine.Rendering.HighDefinition.HDAdditionalLightData>();
            data.innerSpotPercent = 50f;
            data.shapeRadius = 0.1f;
            var source = default(LightSource);
            // Its adaptation alone, whichever pipelines' are hooked.
            var hooked = LightReader.Adapt;
            LightReader.Adapt = HighDefinition.HighDefinitionHost.AdaptLight;
            var isRead = LightReader.TryRead(spot, ref source);
            LightReader.Adapt = hooked;
            Assert.IsTrue(isRead);
            Assert.AreEqual(LightSource.InverseSquare, source.falloff);
            Assert.AreEqual(30f * Mathf.Deg2Rad, source.outerHalfAngle, 1e-5f);
            Assert.AreEqual(15f * Mathf.Deg2Rad, source.innerHalfAngle, 1e-5f);
            Assert.AreEqual(0.1f, source.radius);
            Near(Vector3.one, source.strength);
        }

        [Test]
        public void WhatIsOffOrDarkDoesNotShine()
        {
            var light = Light(LightType.Point);
            var source = default(LightSource);
            light.intensity = 0f;
            Assert.IsFalse(LightReader.TryRead(light, ref source));
            light.intensity = 1f;
            light.enabled = false;
            Assert.IsFalse(LightReader.TryRead(light, ref source));
            light.enabled = true;
            light.gameObject.SetActive(false);
            Assert.IsFalse(LightReader.TryRead(light, ref source));
            Object.DestroyImmediate(light.gameObject);
            Assert.IsFalse(LightReader.TryRead(light, ref source));
        }

        [Test]
        public void AmbientModesAreTheirSurroundings()
        {
            using (var skies = new Skies())
            {
                var reader = new EnvironmentReader();
                var sky = new WorldSky(skies);
                var surroundings = default(Surroundings);
                RenderSettings.ambientMode = AmbientMode.Flat;
                RenderSettings.ambientLight = new Color(0.5f, 0.5f, 0.5f);
                reader.Read(default, sky, false, ref surroundings);
                Assert.AreEqual(Surroundings.Plain, surroundings.kind);
                Near(Vector3.one * Mathf.GammaToLinearSpace(0.5f), surroundings.zenith);
                RenderSettings.ambientMode = AmbientMode.Trilight;
                RenderSettings.ambientSkyColor = Color.blue;
                RenderSettings.ambientEquatorColor = Color.white;
                RenderSettings.ambientGroundColor = Color.red;
                reader.Read(default, sky, false, ref surroundings);
                Assert.AreEqual(Surroundings.Gradient, surroundings.kind);
                Near(new Vector3(0f, 0f, 1f), surroundings.zenith);
                Near(Vector3.one, surroundings.horizon);
                Near(new Vector3(1f, 0f, 0f), surroundings.nadir);
                RenderSettings.ambientMode = AmbientMode.Skybox;
                RenderSettings.skybox = null;
                reader.Read(default, sky, false, ref surroundings);
                Assert.AreEqual(Surroundings.Studio, surroundings.kind);
                reader.Read(default, sky, true, ref surroundings);
                Assert.AreEqual(Surroundings.Plain, surroundings.kind);
            }
        }

        [Test]
        public void APanoramaHasZInTheMiddleAndXToItsRight()
        {
            const int side = 8, width = 64, height = 32;
            for (var face = 0; face < 6; face++)
            {
                var faces = new float[6 * side * side * 4];
                for (var i = 0; i < side * side * 4; i++) faces[face * side * side * 4 + i] = 1f;
                var map = CubeMap.Panorama(faces, side, width, height, 2f);
                float At(int x, int y) => map[3 * (y * width + x)];
                var lit = new[] { At(48, 16), At(16, 16), At(32, 0), At(32, 31), At(32, 16), At(0, 16) };
                for (var which = 0; which < 6; which++) Assert.AreEqual(which == face ? 2f : 0f, lit[which], $"face {face}, place {which}");
            }
        }

        [Test]
        public void APanoramaHoldsWhatIsDarkAtNoNumber()
        {
            var faces = new float[6 * 4];
            faces[0] = float.NaN;
            faces[4] = float.PositiveInfinity;
            faces[8] = -1f;
            foreach (var value in CubeMap.Panorama(faces, 1, 8, 4, 1f)) Assert.IsTrue(value == 0f, $"{value}");
        }

        [Test]
        public void TheFirstRowInMemoryIsTheLowest()
        {
            var projection = Matrix4x4.Perspective(60f, 1f, 0.5f, 100f);
            var clip = Projections.ClipFromCamera(projection, false);
            var below = clip * new Vector4(0f, -1f, -10f, 1f);
            Assert.IsTrue(below.y / below.w < 0f);
            var turned = Projections.ClipFromCamera(projection, true) * new Vector4(0f, -1f, -10f, 1f);
            Assert.AreEqual(-below.y, turned.y);
            var near = clip * new Vector4(0f, 0f, -0.5f, 1f);
            var far = clip * new Vector4(0f, 0f, -100f, 1f);
            Assert.AreEqual(SystemInfo.usesReversedZBuffer ? 1f : 0f, near.z / near.w, 1e-5f);
            Assert.AreEqual(SystemInfo.usesReversedZBuffer ? 0f : 1f, far.z / far.w, 1e-5f);
        }

        [Test]
        public void NewLightsAreFoundWithinHalfASecond()
        {
            LightFinder.FindAll();
            var light = Light(LightType.Point);
            for (var i = 0; i < 200 && !LightFinder.Known.Contains(light); i++)
            {
                LightFinder.Tick();
                System.Threading.Thread.Sleep(5);
            }
            Assert.IsTrue(LightFinder.Known.Contains(light));
        }

        [Test]
        public void ACamerasOwnEffectGoesFirst()
        {
            var camera = new GameObject("Camera").AddComponent<Camera>();
            Assert.IsTrue(LumivoxEffect.TryGet(camera, out var settings));
            Assert.AreEqual(512, settings.targetSamples);
            var global = new GameObject("Effect").AddComponent<LumivoxEffect>();
            global.targetSamples = 64;
            Assert.IsTrue(LumivoxEffect.TryGet(camera, out settings));
            Assert.AreEqual(64, settings.targetSamples);
            var own = camera.gameObject.AddComponent<LumivoxEffect>();
            own.targetSamples = 32;
            Assert.IsTrue(LumivoxEffect.TryGet(camera, out settings));
            Assert.AreEqual(32, settings.targetSamples);
            own.enabled = false;
            Assert.IsFalse(LumivoxEffect.TryGet(camera, out settings));
        }
    }
}
