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
            source.decay = source.attenuation = 0f;
            source.hasAttenuation = 0;
            source.innerHalfAngle = isBuiltIn ? source.outerHalfAngle * BuiltInCone : Mathf.Min(light.innerSpotAngle, light.spotAngle) * 0.5f * Mathf.Deg2Rad;
            Adapt?.Invoke(light, ref source);
            if (light.TryGetComponent<LumivoxLight>(out var own) && own.isActiveAndEnabled) own.Adapt(ref source);
            return true;
        }

        /// <summary>Gives a light the colour and intensity that are read as a strength, in the units of the pipeline.</summary>
        internal static void SetColor(Light light, Vector3 strength)
        {
            var host = PipelineHost.Current;
            var linear = strength * ((host != null ? host.SunIntensity : 1f) / Mathf.PI);
            var color = new Color(linear.x, linear.y, linear.z, 1f);
            var most = Mathf.Max(linear.x, Mathf.Max(linear.y, linear.z));
            if (most <= 0f)
            {
                (light.color, light.intensity) = (Color.black, 0f);
                return;
            }
            light.useColorTemperature = false;
            if (GraphicsSettings.lightsUseLinearIntensity)
            {
                color = new Color(linear.x / most, linear.y / most, linear.z / most, 1f).gamma;
                (light.color, light.intensity) = (color, most);
                return;
            }
            color = color.gamma;
            most = Mathf.Max(color.r, Mathf.Max(color.g, color.b));
            (light.color, light.intensity) = (new Color(color.r / most, color.g / most, color.b / most, 1f), most);
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
