// Draws volumes where no renderer has the feature, so that a project need set up nothing.
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.Universal;

namespace Lumivox.Universal
{
    internal static class LumivoxInjector
    {
        static readonly List<LumivoxFeature> features = new List<LumivoxFeature>();
        static LumivoxPass pass;
        static bool isHooked;

        /// <summary>A feature comes, or goes.</summary>
        public static void Count(LumivoxFeature feature, bool isThere)
        {
            features.Remove(feature);
            if (isThere) features.Add(feature);
        }

#if UNITY_EDITOR
        [UnityEditor.InitializeOnLoadMethod]
#endif
        [RuntimeInitializeOnLoadMethod(RuntimeInitializeLoadType.BeforeSceneLoad)]
        static void Hook()
        {
            if (isHooked) return;
            isHooked = true;
            RenderPipelineManager.beginCameraRendering += BeginCamera;
        }

        static void BeginCamera(ScriptableRenderContext context, Camera camera)
        {
            if (!(GraphicsSettings.currentRenderPipeline is UniversalRenderPipelineAsset) || !LumivoxRuntime.Draws(camera)) return;
            foreach (var feature in features)
                if (feature != null && feature.isActive) return;
            var renderer = camera.GetUniversalAdditionalCameraData().scriptableRenderer;
            if (renderer == null) return;
            if (pass == null) pass = new LumivoxPass { renderPassEvent = RenderPassEvent.BeforeRenderingTransparents };
            renderer.EnqueuePass(pass);
        }
    }
}
