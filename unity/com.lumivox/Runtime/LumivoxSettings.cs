using System;
using UnityEngine;

namespace Lumivox
{
    /// <summary>What lights the volumes besides the scene's lights.</summary>
    public enum LumivoxEnvironmentSource
    {
        /// <summary>The environment of the scene's lighting settings.</summary>
        Scene = 0,
        /// <summary>Lumivox' own studio light, whatever the scene's is.</summary>
        Studio = 1,
    }

    /// <summary>How volumes are drawn.</summary>
    [Serializable]
    public struct LumivoxSettings
    {
        /// <summary>Brightens the volumes by so many stops: +1 doubles their light. From -64 to 64.</summary>
        [Range(-10f, 10f), Tooltip("Brightens the volumes by so many stops: +1 doubles their light.")]
        public float exposure;
        /// <summary>Samples per pixel after which the image is done and costs nothing more. From 1 to 65536.</summary>
        [Min(1), Tooltip("Samples per pixel after which the image is done and costs nothing more. Noise halves with four times as many.")]
        public int targetSamples;
        /// <summary>Noise at which the image is done before it has all its samples, relative to its brightness; 0: by its samples alone. From 0 to 1.</summary>
        [Range(0f, 1f), Tooltip("Noise at which the image is done before it has all its samples, relative to its brightness: 0.05 is hardly seen. 0 ends it by its samples alone.")]
        public float targetNoise;
        /// <summary>Milliseconds of the GPU's time that tracing may take in a frame. From 0.5 to 10000.</summary>
        [Min(0.5f), Tooltip("Milliseconds of the GPU's time that tracing may take in a frame. More converges sooner and lowers the frame rate until it has.")]
        public float frameBudgetMs;
        /// <summary>Pixels traced per pixel of the view along each side. From 0.1 to 1.</summary>
        [Range(0.1f, 1f), Tooltip("Pixels traced per pixel of the view along each side. Below 1 it converges sooner and is less sharp.")]
        public float resolutionScale;
        /// <summary>Whether volumes write their depth where they hide more than half of what is behind them.</summary>
        [Tooltip("Writes the depth of volumes where they hide more than half of what is behind them: they hide transparent materials there.")]
        public bool writeDepth;
        /// <summary>Whether the noise that is left is filtered out of the image at rest while it has fewer than 256 samples.</summary>
        [Tooltip("Filters noise out of the image at rest until a pixel has 256 samples; what is shown until then is softer than the truth. With Kept Light that is so anyway: then it counts for images that end before, by their samples or noise. It changes nothing of what moves.")]
        public bool denoise;
        /// <summary>Whether light is kept in the volumes, for clean pictures while something moves. At rest the image is the same with it and without.</summary>
        [Tooltip("Keeps light in the volumes, for clean pictures while something moves. At rest the image is the same with it and without. It takes memory of the GPU, of what Voxel Megabytes grant. Without it a moving picture is coarse, as it is in scenes with labels, peeling, clip shapes or rows for gradients.")]
        public bool keptLight;
        /// <summary>What lights the volumes besides the scene's lights.</summary>
        [Tooltip("What lights the volumes besides the scene's lights: the environment of its lighting settings, or Lumivox' own studio light.")]
        public LumivoxEnvironmentSource environmentSource;

        /// <summary>Those of a project that says nothing else.</summary>
        public static LumivoxSettings Default => new LumivoxSettings
        {
            exposure = 0f,
            targetSamples = 512,
            targetNoise = 0f,
            frameBudgetMs = 8f,
            resolutionScale = 1f,
            writeDepth = true,
            denoise = false,
            keptLight = true,
            environmentSource = LumivoxEnvironmentSource.Scene,
        };

        /// <summary>With every number in its range.</summary>
        internal LumivoxSettings Clamped()
        {
            var result = this;
            var usual = Default;
            result.exposure = Numbers.Within(exposure, -64f, 64f, usual.exposure);
            result.targetSamples = Mathf.Clamp(targetSamples, 1, 65536);
            result.targetNoise = Numbers.Within(targetNoise, 0f, 1f, usual.targetNoise);
            result.frameBudgetMs = Numbers.Within(frameBudgetMs, 0.5f, 10000f, usual.frameBudgetMs);
            result.resolutionScale = Numbers.Within(resolutionScale, 0.1f, 1f, usual.resolutionScale);
            result.environmentSource = (LumivoxEnvironmentSource)Mathf.Clamp((int)environmentSource, 0, 1);
            return result;
        }
    }
}
