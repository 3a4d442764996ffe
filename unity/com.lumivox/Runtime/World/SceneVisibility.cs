// Which scenes a camera of the editor sees, and what is hidden in its scene view. In players everything is in every scene.
using UnityEngine;

namespace Lumivox
{
    internal static class SceneVisibility
    {
        const ulong Everything = ulong.MaxValue;

        public static ulong ScenesOf(Camera camera)
        {
#if UNITY_EDITOR
            // Prefab stages and previews have scenes of their own.
            if (camera.overrideSceneCullingMask != 0) return camera.overrideSceneCullingMask;
            if (camera.scene.IsValid()) return UnityEditor.SceneManagement.EditorSceneManager.GetSceneCullingMask(camera.scene);
            return camera.cameraType == CameraType.SceneView
                ? UnityEditor.SceneManagement.SceneCullingMasks.MainStageSceneViewObjects
                : UnityEditor.SceneManagement.SceneCullingMasks.GameViewObjects;
#else
            return Everything;
#endif
        }

        public static bool IsIn(GameObject thing, in WorldKey key)
        {
#if UNITY_EDITOR
            return key.Scenes == Everything || (thing.sceneCullingMask & key.Scenes) != 0;
#else
            return true;
#endif
        }

        public static bool IsSeen(GameObject thing, in WorldKey key)
        {
            if (!IsIn(thing, key)) return false;
#if UNITY_EDITOR
            if (key.IsSceneView && UnityEditor.SceneVisibilityManager.instance.IsHidden(thing)) return false;
#endif
            return true;
        }
    }
}
