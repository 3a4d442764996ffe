using UnityEngine;

namespace Lumivox
{
    internal static class Fog
    {
        /// <summary>Whether a camera shows the scene's fog: a scene view may be told not to.</summary>
        public static bool IsSeenBy(Camera camera)
        {
#if UNITY_EDITOR
            if (camera.cameraType == CameraType.SceneView)
            {
                var view = UnityEditor.SceneView.currentDrawingSceneView;
                return view == null || view.sceneViewState.fogEnabled;
            }
#endif
            return true;
        }
    }
}
