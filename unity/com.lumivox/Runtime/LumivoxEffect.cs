using System.Collections.Generic;
using UnityEngine;

namespace Lumivox
{
    /// <summary>
    /// How volumes are drawn: on a camera for that camera, on any other object for all cameras without one of their own.
    /// Without any, the project's defaults hold (<see cref="LumivoxProjectSettings"/>).
    /// </summary>
    /// <remarks>
    /// While the camera moves the image is made of the light that is kept in the volumes (<see cref="keptLight"/>), or is coarse, and
    /// answers at once; at rest it converges to
    /// <see cref="targetSamples"/> per pixel, as much in each frame as fits into <see cref="frameBudgetMs"/>. A camera
    /// whose own effect is disabled draws no volumes. Values beyond a setting's range become the nearest in it; what is no
    /// finite number is refused with an error.
    /// </remarks>
    [ExecuteAlways, DisallowMultipleComponent, AddComponentMenu("Lumivox/Lumivox Effect")]
    public sealed class LumivoxEffect : MonoBehaviour
    {
        [SerializeField]
        LumivoxSettings m_Settings = LumivoxSettings.Default;

        static readonly List<LumivoxEffect> all = new List<LumivoxEffect>();

        /// <summary>Brightens the volumes by so many stops: +1 doubles their light. From -64 to 64.</summary>
        public float exposure
        {
            get => m_Settings.exposure;
            set => Put("exposure", ref m_Settings.exposure, value, -64f, 64f);
        }

        /// <summary>Samples per pixel after which the image is done and costs nothing more. From 1 to 65536.</summary>
        public int targetSamples
        {
            get => m_Settings.targetSamples;
            set
            {
                m_Settings.targetSamples = Mathf.Clamp(value, 1, 65536);
                LumivoxRuntime.RequestFrames();
            }
        }

        /// <summary>Noise at which the image is done before it has all its samples, relative to its brightness; 0: by its samples alone. From 0 to 1.</summary>
        public float targetNoise
        {
            get => m_Settings.targetNoise;
            set => Put("targetNoise", ref m_Settings.targetNoise, value, 0f, 1f);
        }

        /// <summary>Milliseconds of the GPU's time that tracing may take in a frame. From 0.5 to 10000.</summary>
        public float frameBudgetMs
        {
            get => m_Settings.frameBudgetMs;
            set => Put("frameBudgetMs", ref m_Settings.frameBudgetMs, value, 0.5f, 10000f);
        }

        /// <summary>Pixels traced per pixel of the view along each side. From 0.1 to 1.</summary>
        public float resolutionScale
        {
            get => m_Settings.resolutionScale;
            set => Put("resolutionScale", ref m_Settings.resolutionScale, value, 0.1f, 1f);
        }

        /// <summary>Whether volumes write their depth where they hide more than half of what is behind them.</summary>
        public bool writeDepth
        {
            get => m_Settings.writeDepth;
            set
            {
                m_Settings.writeDepth = value;
                LumivoxRuntime.RequestFrames();
            }
        }

        /// <summary>
        /// Whether the noise that is left is filtered out of the image at rest while it has fewer than 256 samples: it is a little soft
        /// then. With <see cref="keptLight"/> that is so anyway; there it counts for images that end before, by their samples or noise.
        /// </summary>
        public bool denoise
        {
            get => m_Settings.denoise;
            set
            {
                m_Settings.denoise = value;
                LumivoxRuntime.RequestFrames();
            }
        }

        /// <summary>
        /// Whether light is kept in the volumes, for clean pictures while something moves; on unless it is turned off. At rest the image
        /// is the same with it and without. Where the GPU has no room for it, and in scenes with labels, peeling, clip shapes or
        /// rows for gradients, nothing is kept and nothing said (<see cref="LumivoxRenderer.KeptLightBytes"/>).
        /// </summary>
        public bool keptLight
        {
            get => m_Settings.keptLight;
            set
            {
                m_Settings.keptLight = value;
                LumivoxRuntime.RequestFrames();
            }
        }

        /// <summary>What lights the volumes besides the scene's lights.</summary>
        public LumivoxEnvironmentSource environmentSource
        {
            get => m_Settings.environmentSource;
            set
            {
                m_Settings.environmentSource = (LumivoxEnvironmentSource)Mathf.Clamp((int)value, 0, 1);
                LumivoxRuntime.RequestFrames();
            }
        }

        /// <summary>All of it.</summary>
        public LumivoxSettings settings
        {
            get => m_Settings;
            set
            {
                m_Settings = value.Clamped();
                LumivoxRuntime.RequestFrames();
            }
        }

        /// <summary>What holds for a camera; false where it draws no volumes.</summary>
        internal static bool TryGet(Camera camera, out LumivoxSettings settings)
        {
            if (camera.TryGetComponent<LumivoxEffect>(out var own))
            {
                settings = own.m_Settings;
                return own.isActiveAndEnabled;
            }
            foreach (var effect in all)
                if (!effect.TryGetComponent<Camera>(out _))
                {
                    settings = effect.m_Settings;
                    return true;
                }
            settings = LumivoxProjectSettings.Effect;
            return true;
        }

        void OnEnable()
        {
            if (LumivoxRuntime.IsMakingAssets) return;
            all.Add(this);
            LumivoxRuntime.RequestFrames();
        }

        void OnDisable()
        {
            all.Remove(this);
            LumivoxRuntime.RequestFrames();
        }

        void OnValidate()
        {
            m_Settings = m_Settings.Clamped();
            LumivoxRuntime.RequestFrames();
        }

        void Put(string property, ref float field, float value, float low, float high)
        {
            if (!Numbers.IsFinite(value))
            {
                Debug.LogError($"LumivoxEffect.{property} must be a finite number, not {value}; it stays {field}.", this);
                return;
            }
            field = Mathf.Clamp(value, low, high);
            LumivoxRuntime.RequestFrames();
        }
    }
}
