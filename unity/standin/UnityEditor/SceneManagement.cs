// Prefabs that are edited on a stage of their own, and which scenes cameras see.
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
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
        public static ulong GetSceneCullingMask(Scene scene) => StandIn.PreviewScenes.MaskOf(scene) ?? SceneCullingMasks.DefaultSceneCullingMask;
        public static Scene NewPreviewScene() => StandIn.PreviewScenes.Open();
        public static bool ClosePreviewScene(Scene scene) => StandIn.PreviewScenes.Close(scene);
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

namespace UnityEditor
{
    /// Lighting settings of another scene than the active one, while something is drawn.
    public static class Unsupported
    {
        static readonly Dictionary<int, Dictionary<PropertyInfo, object>> settings = new Dictionary<int, Dictionary<PropertyInfo, object>>();
        static Dictionary<PropertyInfo, object> active;
        static int current;

        static Dictionary<PropertyInfo, object> Now() => typeof(RenderSettings).GetProperties(BindingFlags.Static | BindingFlags.Public).Where(one => one.CanWrite).ToDictionary(one => one, one => one.GetValue(null));
        static void Put(Dictionary<PropertyInfo, object> values) { foreach (var pair in values) pair.Key.SetValue(null, pair.Value); }

        public static bool SetOverrideLightingSettings(Scene scene)
        {
            if (!scene.IsValid()) return false;
            RestoreOverrideLightingSettings();
            active = Now();
            current = scene.handle;
            if (settings.TryGetValue(current, out var known)) Put(known); else RenderSettings.Default();
            return true;
        }

        public static void RestoreOverrideLightingSettings()
        {
            if (active == null) return;
            settings[current] = Now();
            Put(active);
            active = null;
        }
    }
}
