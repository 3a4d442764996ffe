// The light around a scene, from Unity's lighting settings.
using System;
using Lumivox.Native;
using UnityEngine;
using UnityEngine.Rendering;

namespace Lumivox
{
    internal sealed class EnvironmentReader
    {
        /// <summary>What a pipeline with skies of its own reads instead; false where it has none.</summary>
        internal delegate bool Adaptation(WorldSky sky, bool hasLights, ref Surroundings surroundings);

        /// <summary>That of the pipeline, where it has one.</summary>
        internal static Adaptation Adapt;

        /// <summary>What tells one sky of a pipeline that has skies of its own from another; null where there are none.</summary>
        internal static Func<ulong> NumberOfPipelinesSky;

        readonly Vector3[] directions = { Vector3.up, Vector3.forward, Vector3.down };
        readonly Color[] colors = new Color[3];

        /// <summary>How bright the studio is in a pipeline whose light is physical; null elsewhere.</summary>
        internal static Func<float> StudioStrength;

        /// <summary>What is as bright in this pipeline as a radiance of 1 in others.</summary>
        public static float Radiance => StudioStrength != null ? StudioStrength() : 1f;

        public static Surroundings Studio => new Surroundings { kind = Surroundings.Studio, strength = Radiance };

        /// <summary>What lights a world besides its lights.</summary>
        public void Read(in WorldKey key, WorldSky sky, bool hasLights, ref Surroundings surroundings)
        {
            surroundings = new Surroundings { strength = 1f };
            var own = LumivoxEnvironment.Of(key);
            if (own != null)
            {
                sky.LookAway();
                own.Read(ref surroundings);
                return;
            }
            if (Adapt == null || GraphicsSettings.currentRenderPipeline == null || !Adapt(sky, hasLights, ref surroundings)) ReadScene(sky, hasLights, ref surroundings);
            if (surroundings.kind == Surroundings.Map)
            {
                surroundings.map = sky.Use();
                if (surroundings.map == IntPtr.Zero) ReadProbe(ref surroundings);
            }
            // Nobody waits for a sky that lights nothing.
            else sky.LookAway();
        }

        /// <summary>
        /// Tells the surroundings of the camera that is being drawn from those of others: pipelines may have one sky for each.
        /// </summary>
        public static ulong NumberOfSky(in WorldKey key)
        {
            var own = LumivoxEnvironment.Of(key);
            if (own != null) return own.Number;
            if (NumberOfPipelinesSky != null && GraphicsSettings.currentRenderPipeline != null)
            {
                var number = NumberOfPipelinesSky();
                if (number != 0) return number;
            }
            var mode = RenderSettings.ambientMode;
            var hash = Mix(FirstHash, (int)mode);
            if (mode == AmbientMode.Trilight) return Mix(Mix(Mix(hash, RenderSettings.ambientSkyColor), RenderSettings.ambientEquatorColor), RenderSettings.ambientGroundColor);
            if (mode == AmbientMode.Flat) return Mix(hash, RenderSettings.ambientLight);
            var skybox = RenderSettings.skybox;
            return skybox == null ? Mix(hash, RenderSettings.ambientLight) : Mix(Mix(hash, Identity.Of(skybox)), RenderSettings.ambientIntensity);
        }

        /// <summary>FNV-1a, from here on.</summary>
        internal const ulong FirstHash = 14695981039346656037ul;

        internal static ulong Mix(ulong hash, int value) => (hash ^ (uint)value) * 1099511628211ul;

        internal static ulong Mix(ulong hash, ulong value) => Mix(Mix(hash, unchecked((int)value)), unchecked((int)(value >> 32)));

        internal static ulong Mix(ulong hash, float value) => Mix(hash, BitConverter.SingleToInt32Bits(value));

        internal static ulong Mix(ulong hash, Color value) => Mix(Mix(Mix(hash, value.r), value.g), value.b);

        static void ReadScene(WorldSky sky, bool hasLights, ref Surroundings surroundings)
        {
            switch (RenderSettings.ambientMode)
            {
                case AmbientMode.Flat:
                    surroundings.kind = Surroundings.Plain;
                    surroundings.zenith = Numbers.Linear(RenderSettings.ambientLight);
                    return;
                case AmbientMode.Trilight:
                    surroundings.kind = Surroundings.Gradient;
                    surroundings.zenith = Numbers.Linear(RenderSettings.ambientSkyColor);
                    surroundings.horizon = Numbers.Linear(RenderSettings.ambientEquatorColor);
                    surroundings.nadir = Numbers.Linear(RenderSettings.ambientGroundColor);
                    return;
            }
            var skybox = RenderSettings.skybox;
            if (skybox == null)
            {
                // Nothing lights the scene: a studio does, so that a volume alone is seen.
                if (!hasLights) surroundings = Studio;
                else
                {
                    surroundings.kind = Surroundings.Plain;
                    surroundings.zenith = Numbers.Linear(RenderSettings.ambientLight);
                }
                return;
            }
            sky.Look(skybox);
            surroundings.kind = Surroundings.Map;
            surroundings.strength = RenderSettings.ambientIntensity;
        }

        /// <summary>Until the sky is there, what the engine lights its own objects with.</summary>
        void ReadProbe(ref Surroundings surroundings)
        {
            var probe = RenderSettings.ambientProbe;
            probe.Evaluate(directions, colors);
            surroundings.kind = Surroundings.Gradient;
            surroundings.strength = 1f;
            surroundings.zenith = Positive(colors[0]);
            surroundings.horizon = Positive(colors[1]);
            surroundings.nadir = Positive(colors[2]);
        }

        static Vector3 Positive(Color color) => new Vector3(Mathf.Max(0f, color.r), Mathf.Max(0f, color.g), Mathf.Max(0f, color.b));
    }
}
