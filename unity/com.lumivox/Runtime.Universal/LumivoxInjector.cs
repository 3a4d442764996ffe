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
        /// Whose volumes the pass has yet to draw.
        static Camera awaited;
        static bool isHooked;

        /// <summary>Whether the pass is to draw for this camera: once, and only where no feature does.</summary>
        public static bool Takes(Camera camera)
        {
            // URP may give a camera up after it has begun; its pass is then met again with the next one's.
            if (!ReferenceEquals(awaited, camera)) return false;
            awaited = null;
            return true;
        }

        /// <summary>A feature draws what is seen by the camera that has begun.</summary>
        public static void Yield() => awaited = null;

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
            awaited = null;
            if (!(GraphicsSettings.currentRenderPipeline is UniversalRenderPipelineAsset asset) || !LumivoxRuntime.Draws(camera)) return;
            // As URP chooses: asking for the camera's data by its extension would add a component to the user's camera.
            var isOfAsset = camera.cameraType == CameraType.SceneView || !camera.TryGetComponent<UniversalAdditionalCameraData>(out _);
            var renderer = isOfAsset ? asset.scriptableRenderer : camera.GetUniversalAdditionalCameraData().scriptableRenderer;
            if (renderer == null) return;
            if (pass == null) pass = new LumivoxPass(true) { renderPassEvent = RenderPassEvent.BeforeRenderingTransparents };
            renderer.EnqueuePass(pass);
            awaited = camera;
        }
    }
}
