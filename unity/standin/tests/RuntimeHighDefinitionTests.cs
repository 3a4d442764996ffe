// HDRP's lights, skies and exposure, in whole pictures: beside those of other pipelines whose numbers mean the same light.
using System;
using System.Linq;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.HighDefinition;

namespace Lumivox.Tests
{
    public sealed class RuntimeHighDefinitionTests : CubeScene
    {
        /// What lux, candela and nits are exposed by here.
        const float Exposure = 1f / 20000f;

        protected override float Scale => 6f;

        /// The camera's picture in a pipeline, of a scene that `build` completes.
        Picture In(string kind, Action build, float exposure = Exposure)
        {
            using (new Pipeline(kind))
            {
                GraphicsSettings.lightsUseLinearIntensity = true;
                StandInHighDefinition.exposure = _ => exposure;
                camera.GetComponent<LumivoxEffect>().environmentSource = LumivoxEnvironmentSource.Scene;
                RenderSettings.ambientMode = AmbientMode.Flat;
                RenderSettings.ambientLight = Color.black;
                build();
                LumivoxRenderer.FindLights();
                Settle();
                // What comes back late: exposure, and maps of skies.
                Waiting.Frames(() => LumivoxRenderer.IsConverged(camera), least: 9);
                var picture = Pictures.Color(camera);
                foreach (var light in UnityEngine.Object.FindObjectsByType<Light>(FindObjectsSortMode.None)) UnityEngine.Object.DestroyImmediate(light.gameObject);
                LumivoxRuntime.Stop();
                GraphicsSettings.lightsUseLinearIntensity = false;
                return picture;
            }
        }

        static HDAdditionalLightData Lamp(LightType type, float intensity, Vector3 place, bool isPhysical)
        {
            var light = new GameObject(type.ToString()).AddComponent<Light>();
            light.type = type;
            light.color = new Color(1f, 0.8f, 0.6f);
            light.intensity = intensity;
            // Its edge crosses the cube.
            (light.spotAngle, light.innerSpotAngle) = (8f, 2f);
            light.range = 20f;
            light.transform.position = place;
            light.transform.LookAt(Vector3.zero);
            if (!isPhysical) return null;
            // Without a size: others' have none.
            var data = light.gameObject.AddComponent<HDAdditionalLightData>();
            data.angularDiameter = data.shapeRadius = 0f;
            data.innerSpotPercent = 25f;
            return data;
        }

        static T Sky<T>(SkyType type) where T : SkySettings
        {
            var stack = VolumeManager.instance.stack;
            stack.GetComponent<VisualEnvironment>().skyType.value = (int)type;
            return stack.GetComponent<T>();
        }

        static float Mean(Picture picture) => picture.pixels.Average(Light);

        static void Same(Picture expected, Picture shown, string what)
        {
            Assert.IsTrue(Mean(expected) > 0.01f, $"{what}: there is nothing to compare with, {Mean(expected)}");
            var worst = Enumerable.Range(0, Side * Side).Max(i => Enumerable.Range(0, 3).Max(c => Mathf.Abs(expected.pixels[i][c] - shown.pixels[i][c]) / (0.1f + expected.pixels[i][c])));
            // Half floats, twice.
            Assert.IsTrue(worst < 0.02f, $"{what}: {worst} off, {Mean(shown)} in place of {Mean(expected)}");
        }

        static readonly Vector3 place = new Vector3(0.4f, 0.5f, -0.6f);

        [Test]
        public void ASunsLuxAreIrradiance()
        {
            // A sun of 1 elsewhere has an irradiance of pi.
            var expected = In("Built-in", () => Lamp(LightType.Directional, 1f, place, false));
            Same(expected, In("HDRP", () => Lamp(LightType.Directional, Mathf.PI / Exposure, place, true)), "lux");
            Same(expected, In("HDRP", () => Lamp(LightType.Directional, 4f * Mathf.PI / Exposure, place, true).lightDimmer = 0.25f), "dimmed");
            var dark = In("HDRP", () => Lamp(LightType.Directional, Mathf.PI / Exposure, place, true).affectDiffuse = false);
            Assert.AreEqual(0f, Mean(dark), 1e-4f);
            // As large as it is in the sky, it casts softer shadows, of the same light.
            var soft = In("HDRP", () => Lamp(LightType.Directional, Mathf.PI / Exposure, place, true).angularDiameter = 20f);
            Assert.AreEqual(Mean(expected), Mean(soft), 0.1f * Mean(expected));
            Assert.AreNotEqual(Mean(expected), Mean(soft));
        }

        [TestCase(LightType.Point)]
        [TestCase(LightType.Spot)]
        public void ALampsCandelaAreIntensity(LightType type)
        {
            var expected = In("compatibility", () => Lamp(type, 0.5f, place, false));
            Same(expected, In("HDRP", () => Lamp(type, 0.5f * Mathf.PI / Exposure, place, true)), "candela");
            // One of two gets each path: noisier, and the same light.
            var halves = In("HDRP", () =>
            {
                Lamp(type, 0.25f * Mathf.PI / Exposure, place, true);
                Lamp(type, 0.25f * Mathf.PI / Exposure, place, true);
            });
            Assert.AreEqual(Mean(expected), Mean(halves), 0.05f * Mean(expected));
        }

        [Test]
        public void AGradientSkyIsWhatThreeAmbientColorsAre()
        {
            Color top = new Color(0.3f, 0.5f, 0.9f), middle = new Color(0.7f, 0.6f, 0.5f), bottom = new Color(0.4f, 0.2f, 0.1f);
            var expected = In("Built-in", () =>
            {
                RenderSettings.ambientMode = AmbientMode.Trilight;
                (RenderSettings.ambientSkyColor, RenderSettings.ambientEquatorColor, RenderSettings.ambientGroundColor) = (top, middle, bottom);
            });
            var shown = In("HDRP", () =>
            {
                var sky = Sky<GradientSky>(SkyType.Gradient);
                (sky.top.value, sky.middle.value, sky.bottom.value) = (top, middle, bottom);
                sky.skyIntensityMode.value = SkyIntensityMode.Exposure;
                sky.exposure.value = 12f;
            }, 1.2f / 4096f);
            Same(expected, shown, "gradient");
        }

        /// One bright face of a cube, and two dim ones.
        static Color Face(Vector3 way)
        {
            float x = Mathf.Abs(way.x), y = Mathf.Abs(way.y), z = Mathf.Abs(way.z);
            if (x >= y && x >= z) return way.x > 0f ? new Color(4f, 1f, 0.5f) : Color.black;
            if (y >= z) return way.y > 0f ? new Color(0.1f, 0.2f, 0.4f) : Color.black;
            return way.z > 0f ? Color.black : new Color(0.05f, 0.1f, 0.05f);
        }

        static Cubemap Cube(int side = 32)
        {
            var cube = new Cubemap(side, TextureFormat.RGBAHalf, false);
            foreach (CubemapFace face in Enum.GetValues(typeof(CubemapFace)))
            {
                if (face == CubemapFace.Unknown) continue;
                var ways = new[] { Vector3.right, Vector3.left, Vector3.up, Vector3.down, Vector3.forward, Vector3.back };
                for (var i = 0; i < side * side; i++) cube.SetPixel(face, i % side, i / side, Face(ways[(int)face]));
            }
            cube.Apply();
            return cube;
        }

        [TestCase(0f, Category = "Slow")]
        [TestCase(90f)]
        [TestCase(200f, Category = "Slow")]
        public void AnHDRISkyLightsFromWhereItIs(float rotation)
        {
            // Skies are compressed, and Unity reads back no such texture.
            Faults.missingReadPixels.Add(UnityEngine.Experimental.Rendering.GraphicsFormat.R16G16B16A16_SFloat);
            camera.GetComponent<LumivoxEffect>().targetSamples = 48;
            // Turned by 90 degrees, what was to the right of the scene is behind it.
            var turn = Quaternion.Euler(0f, rotation, 0f);
            Material skybox = null;
            var expected = In("Built-in", () =>
            {
                RenderSettings.ambientMode = AmbientMode.Skybox;
                RenderSettings.skybox = skybox = Skybox();
                Props.sky = way => Face(turn * way);
            });
            Props.sky = null;
            RenderSettings.skybox = null;
            UnityEngine.Object.DestroyImmediate(skybox);
            var cube = Cube();
            var shown = In("HDRP", () =>
            {
                var sky = Sky<HDRISky>(SkyType.HDRI);
                sky.hdriSky.value = cube;
                sky.rotation.value = rotation;
                sky.exposure.value = 10f;
            }, 1.2f / 1024f);
            UnityEngine.Object.DestroyImmediate(cube);
            for (var c = 0; c < 3; c++) Assert.AreEqual(expected.mean[c], shown.mean[c], 0.05f * expected.mean[c]);
            // Which sides are lit.
            foreach (var (x, y) in new[] { (0, 0), (Side / 2, 0), (0, Side / 2), (Side / 2, Side / 2) })
            {
                float Quarter(Picture of) => Enumerable.Range(0, Side * Side / 4).Average(i => Light(of.At(x + i % (Side / 2), y + i / (Side / 2))));
                Assert.AreEqual(Quarter(expected), Quarter(shown), 0.06f * Quarter(expected) + 0.002f, $"at {x}, {y}");
            }
        }

        [Test]
        public void ASkysIntensityIsWhatItsModeSays()
        {
            var cube = Cube();
            Picture Shown(SkyIntensityMode mode) => In("HDRP", () =>
            {
                var sky = Sky<HDRISky>(SkyType.HDRI);
                sky.hdriSky.value = cube;
                sky.skyIntensityMode.value = mode;
                sky.exposure.value = 11f;
                sky.multiplier.value = 2048f / 1.2f;
                sky.upperHemisphereLuxValue.value = 3f;
                sky.desiredLuxValue.value = 6144f / 1.2f;
            }, 1.2f / 2048f);
            var exposed = Shown(SkyIntensityMode.Exposure);
            Same(exposed, Shown(SkyIntensityMode.Multiplier), "a multiplier");
            Same(exposed, Shown(SkyIntensityMode.Lux), "lux");
            UnityEngine.Object.DestroyImmediate(cube);
        }

        /// The stand-in draws its own sky for any.
        static Material Skybox() => new Material(Resources.FindObjectsOfTypeAll<Shader>().First());

        [Test]
        public void ASkyThatCannotBeReadIsWhatTheSceneIsLitWith()
        {
            var probe = new SphericalHarmonicsL2();
            probe.AddAmbientLight(4000f * new Color(0.5f, 0.3f, 0.2f));
            var expected = In("Built-in", () =>
            {
                RenderSettings.ambientMode = AmbientMode.Trilight;
                RenderSettings.ambientSkyColor = RenderSettings.ambientEquatorColor = RenderSettings.ambientGroundColor = new Color(0.5f, 0.3f, 0.2f).gamma;
            });
            var cube = Cube();
            var shown = In("HDRP", () =>
            {
                // What was there before leaves nothing behind.
                Sky<HDRISky>(SkyType.HDRI).hdriSky.value = cube;
                Settle();
                Sky<HDRISky>(SkyType.PhysicallyBased);
                RenderSettings.ambientProbe = probe;
            }, 1f / 4000f);
            // Each began with other random numbers.
            for (var c = 0; c < 3; c++) Assert.AreEqual(expected.mean[c], shown.mean[c], 0.01f * expected.mean[c]);
            UnityEngine.Object.DestroyImmediate(cube);
        }

        [Test]
        public void WithoutASkyOnlyLampsShine()
        {
            RenderSettings.skybox = Skybox();
            Props.sky = _ => Color.white * 1000f;
            var expected = In("Built-in", () => Lamp(LightType.Directional, 1f, place, false));
            // HDRP knows nothing of the scene's own skybox and ambient colours.
            Same(expected, In("HDRP", () =>
            {
                Lamp(LightType.Directional, Mathf.PI / Exposure, place, true);
                RenderSettings.ambientMode = AmbientMode.Skybox;
            }), "no sky");
            Same(expected, In("HDRP", () =>
            {
                Lamp(LightType.Directional, Mathf.PI / Exposure, place, true);
                Sky<HDRISky>(SkyType.HDRI);
                RenderSettings.ambientMode = AmbientMode.Skybox;
            }), "a sky without a picture");
            // Where nothing shines, a studio does, as elsewhere.
            var studio = In("HDRP", () => RenderSettings.ambientMode = AmbientMode.Skybox, 1f / 30000f);
            Same(In("Built-in", () => camera.GetComponent<LumivoxEffect>().environmentSource = LumivoxEnvironmentSource.Studio), studio, "studio");
        }

        [TestCase(true)]
        [TestCase(false)]
        public void ExposureMultipliesWhatItsOwnCameraSees(bool keepsExposures)
        {
            using (new Pipeline("HDRP"))
            {
                StandInHighDefinition.keepsExposures = keepsExposures;
                var exposure = 1f / 30000f;
                StandInHighDefinition.exposure = of => exposure;
                Settle();
                Engine.Frames(8);
                var once = Mean(Pictures.Color(camera));
                Assert.IsTrue(once > 0.01f);
                exposure *= 2f;
                Engine.Frames(8);
                Assert.AreEqual(2f * once, Mean(Pictures.Color(camera)), 0.01f * once);
                // A stop of the effect's own comes on top.
                camera.GetComponent<LumivoxEffect>().exposure = -1f;
                Engine.Frames(8);
                Assert.AreEqual(once, Mean(Pictures.Color(camera)), 0.01f * once);
                // What is no exposure changes nothing.
                foreach (var none in new[] { 0f, float.NaN, float.PositiveInfinity })
                {
                    exposure = none;
                    Engine.Frames(8);
                    Assert.AreEqual(once, Mean(Pictures.Color(camera)), 0.01f * once, $"{none}");
                }
            }
        }

        [Test]
        public void TwoCamerasOfTheSameLayersHaveTheirOwnSkies()
        {
            var target = new RenderTexture(Side, Side, 24, RenderTextureFormat.ARGBHalf);
            using (new Pipeline("HDRP"))
            {
                camera.GetComponent<LumivoxEffect>().environmentSource = LumivoxEnvironmentSource.Scene;
                var other = UnityEngine.Object.Instantiate(camera.gameObject).GetComponent<Camera>();
                other.targetTexture = target;
                other.depth = 1f;
                VolumeStack Stack(Color color)
                {
                    var stack = new VolumeStack();
                    stack.GetComponent<VisualEnvironment>().skyType.value = (int)SkyType.Gradient;
                    var sky = stack.GetComponent<GradientSky>();
                    sky.top.value = sky.middle.value = sky.bottom.value = color;
                    return stack;
                }
                VolumeStack red = Stack(Color.red), blue = Stack(Color.blue);
                StandInHighDefinition.stack = of => of == other ? blue : red;
                void Rest()
                {
                    Assert.IsTrue(Waiting.Frames(() => LumivoxRenderer.IsConverged(camera) && LumivoxRenderer.IsConverged(other), least: 13), "they rest");
                }
                void Shows(Camera of, int channel, string when)
                {
                    var mean = Pictures.Color(of).mean;
                    for (var c = 0; c < 3; c++) Assert.IsTrue(c == channel ? mean[c] > 0.01f : mean[c] < 1e-4f, $"{when}: {mean}");
                }
                Rest();
                Shows(camera, 0, "the first under its sky");
                Shows(other, 2, "the second under its own");
                // A sky that changes in each frame makes no new world.
                for (var i = 0; i < 10; i++)
                {
                    red.GetComponent<GradientSky>().exposure.value = 0.05f * i;
                    Engine.Frame();
                }
                Assert.AreEqual(2, LumivoxRuntime.Worlds.Count);
                Rest();
                // Where both are under one, they share it again.
                StandInHighDefinition.stack = of => blue;
                Rest();
                Shows(camera, 2, "the first under the other's");
                Shows(other, 2, "the second as before");
                UnityEngine.Object.DestroyImmediate(other.gameObject);
            }
            target.Release();
            UnityEngine.Object.DestroyImmediate(target);
        }

        [Test]
        public void TwoCamerasHaveTheirOwnExposures()
        {
            var target = new RenderTexture(Side, Side, 24, RenderTextureFormat.ARGBHalf);
            using (new Pipeline("HDRP"))
            {
                var other = UnityEngine.Object.Instantiate(camera.gameObject).GetComponent<Camera>();
                other.targetTexture = target;
                other.depth = 1f;
                StandInHighDefinition.exposure = of => (of == other ? 4f : 1f) / 30000f;
                Assert.IsTrue(Waiting.Frames(() => LumivoxRenderer.IsConverged(camera) && LumivoxRenderer.IsConverged(other), least: 13), "they rest");
                float one = Mean(Pictures.Color(camera)), four = Mean(Pictures.Color(other));
                Assert.IsTrue(one > 0.01f);
                Assert.AreEqual(4f * one, four, 0.02f * four);
                UnityEngine.Object.DestroyImmediate(other.gameObject);
            }
            target.Release();
            UnityEngine.Object.DestroyImmediate(target);
        }
    }
}
