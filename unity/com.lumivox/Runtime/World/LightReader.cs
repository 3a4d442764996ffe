// Unity's lights as physical ones.
using Lumivox.Native;
using UnityEngine;
using UnityEngine.Rendering;

namespace Lumivox
{
    internal static class LightReader
    {
        /// <summary>What a pipeline with light units of its own changes of a light that was read.</summary>
        internal delegate void Adaptation(Light light, ref LightSource source);

        /// <summary>That of the pipeline, where it has one.</summary>
        internal static Adaptation Adapt;

        /// <summary>
        /// The share of a spot's cone, along its angle, in which the built-in pipeline's own cookie is still white: an
        /// estimate, as that picture is not public.
        /// </summary>
        const float BuiltInCone = 0.8f;

        /// <summary>Whether a light shines on volumes, and how. Areas do not: they are baked, or HDRP's alone.</summary>
        public static bool TryRead(Light light, ref LightSource source)
        {
            if (light == null || !light.isActiveAndEnabled || light.intensity <= 0f) return false;
            var isBuiltIn = GraphicsSettings.currentRenderPipeline == null;
            switch (light.type)
            {
                case LightType.Directional:
                    source.kind = LightSource.Directional;
                    break;
                case LightType.Point:
                    source.kind = LightSource.Point;
                    break;
                case LightType.Spot:
                    source.kind = LightSource.Spot;
                    break;
                default:
                    return false;
            }
            var place = light.transform;
            source.layers = unchecked((uint)light.cullingMask);
            source.position = place.position;
            source.direction = place.forward;
            // A white surface reflects a pi-th of what it receives, and Unity's intensities are what it reflects.
            source.strength = ColorOf(light) * Mathf.PI;
            source.radius = 0f;
            source.range = light.range;
            source.falloff = isBuiltIn ? LightSource.BuiltIn : LightSource.InverseSquare;
            source.outerHalfAngle = light.spotAngle * 0.5f * Mathf.Deg2Rad;
            source.innerHalfAngle = isBuiltIn ? source.outerHalfAngle * BuiltInCone : Mathf.Min(light.innerSpotAngle, light.spotAngle) * 0.5f * Mathf.Deg2Rad;
            Adapt?.Invoke(light, ref source);
            return true;
        }

        /// <summary>Linear colour times intensity, as Unity's shaders get it.</summary>
        internal static Vector3 ColorOf(Light light)
        {
            if (!GraphicsSettings.lightsUseLinearIntensity) return Numbers.Linear(light.color * light.intensity);
            var color = Numbers.Linear(light.color) * light.intensity;
            if (!light.useColorTemperature || !GraphicsSettings.lightsUseColorTemperature) return color;
            var white = Mathf.CorrelatedColorTemperatureToRGB(light.colorTemperature);
            return Vector3.Scale(color, new Vector3(white.r, white.g, white.b));
        }
    }
}
