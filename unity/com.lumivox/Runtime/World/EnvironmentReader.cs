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

        readonly Vector3[] directions = { Vector3.up, Vector3.forward, Vector3.down };
        readonly Color[] colors = new Color[3];

        /// <summary>How bright the studio is in a pipeline whose light is physical; null elsewhere.</summary>
        internal static Func<float> StudioStrength;

        public static Surroundings Studio => new Surroundings { kind = Surroundings.Studio, strength = StudioStrength != null ? StudioStrength() : 1f };

        /// <summary>What lights a world besides its lights.</summary>
        public void Read(WorldSky sky, bool hasLights, ref Surroundings surroundings)
        {
            surroundings = new Surroundings { strength = 1f };
            if (Adapt == null || GraphicsSettings.currentRenderPipeline == null || !Adapt(sky, hasLights, ref surroundings)) ReadScene(sky, hasLights, ref surroundings);
            if (surroundings.kind == Surroundings.Map)
            {
                surroundings.map = sky.Use();
                if (surroundings.map == IntPtr.Zero) ReadProbe(ref surroundings);
            }
            // Nobody waits for a sky that lights nothing.
            else sky.LookAway();
        }

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
