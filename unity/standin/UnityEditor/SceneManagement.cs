// Prefabs that are edited on a stage of their own, and which scenes cameras see.
using UnityEngine;
using UnityEngine.SceneManagement;

namespace UnityEditor.SceneManagement
{
    public static class SceneCullingMasks
    {
        public const ulong DefaultSceneCullingMask = 1UL << 61 | 1UL << 62 | 1UL << 63;
        public const ulong GameViewObjects = 1UL << 63;
        public const ulong MainStageSceneViewObjects = 1UL << 61 | 1UL << 62;
    }

    public enum NewSceneSetup { EmptyScene, DefaultGameObjects }
    public enum NewSceneMode { Single, Additive }

    public sealed class EditorSceneManager : UnityEngine.SceneManagement.SceneManager
    {
        public static bool SaveCurrentModifiedScenesIfUserWantsTo() => StandIn.Dialogs.Answer("Scene(s) Have Been Modified", "Do you want to save the changes?");
        public static Scene NewScene(NewSceneSetup setup, NewSceneMode mode)
        {
            foreach (var root in SceneManager.GetActiveScene().GetRootGameObjects()) Object.DestroyImmediate(root);
            return SceneManager.GetActiveScene();
        }
        public static ulong GetSceneCullingMask(Scene scene) => SceneCullingMasks.DefaultSceneCullingMask;
        public static bool MarkSceneDirty(Scene scene) => true;
    }

    public abstract class Stage : ScriptableObject { public string assetPath { get; internal set; } }
    public abstract class PreviewSceneStage : Stage { }

    public sealed class PrefabStage : PreviewSceneStage
    {
        internal PrefabStage() { }
        public GameObject prefabContentsRoot { get; internal set; }
    }

    public static class PrefabStageUtility
    {
        /// What a test has on the stage.
        internal static PrefabStage current;
        public static PrefabStage GetCurrentPrefabStage() => current;
        public static PrefabStage GetPrefabStage(GameObject gameObject) => current != null && gameObject.transform.IsChildOf(current.prefabContentsRoot.transform) ? current : null;
    }
}
