// HDRP's lights and skies, and the pass for all cameras.
using Lumivox.Native;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.HighDefinition;

namespace Lumivox.HighDefinition
{
    internal static class HighDefinitionHost
    {
        /// <summary>Nits of a bright sky, as bright beside HDRP's suns as Lumivox' studio beside others'.</summary>
        const float SkyNits = 30000f;

        /// <summary>The pass for all cameras. Another one would draw the same light once more.</summary>
        internal static LumivoxCustomPass Pass { get; private set; }

        /// <summary>What the volumes set for the camera that is being drawn: each has its own.</summary>
        internal static VolumeStack Stack;

        static bool isHooked;

#if UNITY_EDITOR
        [UnityEditor.InitializeOnLoadMethod]
#endif
        [RuntimeInitializeOnLoadMethod(RuntimeInitializeLoadType.BeforeSceneLoad)]
        static void Hook()
        {
            if (isHooked) return;
            isHooked = true;
            LightReader.Adapt += AdaptLight;
            EnvironmentReader.Adapt += ReadSky;
            EnvironmentReader.NumberOfPipelinesSky = NumberOfSky;
            EnvironmentReader.StudioStrength = () => GraphicsSettings.currentRenderPipeline is HDRenderPipelineAsset ? SkyNits : 1f;
            Pass = new LumivoxCustomPass { name = "Lumivox" };
#if LUMIVOX_HDRP_16
            CustomPassVolume.RegisterGlobalCustomPass(CustomPassInjectionPoint.BeforeTransparent, Pass);
#else
            PassOfCameras.Hook();
#endif
        }

        /// <summary>
        /// HDRP keeps lux of a sun and candela of a lamp in the light's intensity, and its surfaces reflect a pi-th of what
        /// they receive. Lights have a size.
        /// </summary>
        internal static void AdaptLight(Light light, ref LightSource source)
        {
            if (!(GraphicsSettings.currentRenderPipeline is HDRenderPipelineAsset)) return;
            source.strength /= Mathf.PI;
            if (!light.TryGetComponent<HDAdditionalLightData>(out var data)) return;
            var dimmer = data.lightDimmer;
            source.strength *= dimmer;
            source.radius = source.kind == LightSource.Directional ? data.angularDiameter * 0.5f * Mathf.Deg2Rad : data.shapeRadius;
            if (source.kind == LightSource.Spot) source.innerHalfAngle = source.outerHalfAngle * Mathf.Clamp01(data.innerSpotPercent * 0.01f);
            if (!data.affectDiffuse) source.strength = Vector3.zero;
        }

        /// <summary>The sky of HDRP's volumes where it is one that can be told: a cube, or a gradient.</summary>
        internal static bool ReadSky(WorldSky worldSky, bool hasLights, ref Surroundings surroundings)
        {
            if (!(GraphicsSettings.currentRenderPipeline is HDRenderPipelineAsset)) return false;
            var stack = Stack ?? VolumeManager.instance.stack;
            var kind = stack.GetComponent<VisualEnvironment>().skyType.value;
            if (kind == (int)SkyType.HDRI)
            {
                var sky = stack.GetComponent<HDRISky>();
                var cube = sky.hdriSky.value as Cubemap;
                if (cube == null) return ReadNothing(hasLights, ref surroundings);
                worldSky.Look(cube);
                surroundings.kind = Surroundings.Map;
                surroundings.rotation = -sky.rotation.value * Mathf.Deg2Rad;
                surroundings.strength = StrengthOf(sky);
                return true;
            }
            if (kind == (int)SkyType.Gradient)
            {
                var sky = stack.GetComponent<GradientSky>();
                var strength = StrengthOf(sky);
                surroundings.kind = Surroundings.Gradient;
                surroundings.strength = strength;
                surroundings.zenith = Numbers.Linear(sky.top.value);
                surroundings.horizon = Numbers.Linear(sky.middle.value);
                surroundings.nadir = Numbers.Linear(sky.bottom.value);
                return true;
            }
            if (kind == 0) return ReadNothing(hasLights, ref surroundings);
            // A sky of HDRP's own shaders: what it lights the scene's objects with stands for it.
            worldSky.LookAway();
            surroundings.kind = Surroundings.Map;
            return true;
        }

        /// <summary>
        /// What tells the sky of the camera that is being drawn from those of others; 0 where another pipeline draws.
        /// </summary>
        internal static ulong NumberOfSky()
        {
            if (!(GraphicsSettings.currentRenderPipeline is HDRenderPipelineAsset)) return 0;
            var stack = Stack ?? VolumeManager.instance.stack;
            var kind = stack.GetComponent<VisualEnvironment>().skyType.value;
            var hash = EnvironmentReader.Mix(EnvironmentReader.FirstHash, kind);
            if (kind == (int)SkyType.HDRI)
            {
                var sky = stack.GetComponent<HDRISky>();
                var cube = sky.hdriSky.value;
                hash = EnvironmentReader.Mix(hash, Identity.Of(cube));
                return EnvironmentReader.Mix(EnvironmentReader.Mix(hash, sky.rotation.value), StrengthOf(sky));
            }
            if (kind == (int)SkyType.Gradient)
            {
                var sky = stack.GetComponent<GradientSky>();
                hash = EnvironmentReader.Mix(EnvironmentReader.Mix(EnvironmentReader.Mix(hash, sky.top.value), sky.middle.value), sky.bottom.value);
                return EnvironmentReader.Mix(hash, StrengthOf(sky));
            }
            return hash;
        }

        /// <summary>HDRP draws nothing then, whatever the scene's own lighting settings say; but a volume alone is seen.</summary>
        static bool ReadNothing(bool hasLights, ref Surroundings surroundings)
        {
            if (hasLights) surroundings.kind = Surroundings.Plain;
            else surroundings = EnvironmentReader.Studio;
            return true;
        }

        static float StrengthOf(SkySettings sky)
        {
            switch (sky.skyIntensityMode.value)
            {
                // As HDRP's ColorUtils.ConvertEV100ToExposure: a sensor saturates at 1.2 times that luminance (ISO 12232).
                case SkyIntensityMode.Exposure: return Mathf.Pow(2f, sky.exposure.value) / 1.2f;
                case SkyIntensityMode.Multiplier: return sky.multiplier.value;
                default: return sky.desiredLuxValue.value / Mathf.Max(1e-6f, sky is HDRISky hdri ? hdri.upperHemisphereLuxValue.value : 1f);
            }
        }
    }
}
