// Draws the volumes of cameras whose renderer does not have the feature, so that a project need set up nothing.
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.Universal;

namespace Lumivox.Universal
{
    /// <summary>
    /// Every camera gets a pass before its renderer is asked for its features' passes: where the feature is among these, the
    /// pass draws nothing. So it does not matter which renderers there are, nor when URP makes them and their features anew.
    /// </summary>
    internal static class LumivoxInjector
    {
        static LumivoxPass pass;
        static Camera yielding;
        static bool isHooked;

        /// <summary>Whether the camera's renderer has a feature of its own for this.</summary>
        public static bool Yields(Camera camera) => ReferenceEquals(yielding, camera);

        /// <summary>A feature draws what this camera sees.</summary>
        public static void Yield(Camera camera) => yielding = camera;

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
            yielding = null;
            if (!(GraphicsSettings.currentRenderPipeline is UniversalRenderPipelineAsset asset) || !LumivoxRuntime.Draws(camera)) return;
            // As URP chooses: asking for the camera's data by its extension would add a component to the user's camera.
            var isOfAsset = camera.cameraType == CameraType.SceneView || !camera.TryGetComponent<UniversalAdditionalCameraData>(out _);
            var renderer = isOfAsset ? asset.scriptableRenderer : camera.GetUniversalAdditionalCameraData().scriptableRenderer;
            if (renderer == null) return;
            if (pass == null) pass = new LumivoxPass(true) { renderPassEvent = RenderPassEvent.BeforeRenderingTransparents };
            renderer.EnqueuePass(pass);
        }
    }
}
