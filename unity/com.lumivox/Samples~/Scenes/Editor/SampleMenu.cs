using System.IO;
using UnityEditor;
using UnityEditor.SceneManagement;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Samples.Editor
{
    /// <summary>Opens a new scene with a sample in it; press Play.</summary>
    static class SampleMenu
    {
        const string Menu = "Window/Lumivox/Samples/";

        [MenuItem(Menu + "Cube at Distances", false, 2410)]
        static void CubeAtDistances() => Open<CubeAtDistances>();

        [MenuItem(Menu + "Several Volumes", false, 2411)]
        static void SeveralVolumes() => Open<SeveralVolumes>();

        [MenuItem(Menu + "Occlusion", false, 2412)]
        static void Occlusion() => Open<Occlusion>();

        [MenuItem(Menu + "Headset Rig", false, 2413)]
        static void HeadsetRig() => Open<HeadsetRig>();

        [MenuItem(Menu + "Runtime Import", false, 2414)]
        static void RuntimeImport()
        {
            var sample = Open<RuntimeImport>();
            if (sample != null) sample.GetComponent<UIDocument>().panelSettings = Settings();
        }

        static T Open<T>() where T : SampleScene
        {
            if (!EditorSceneManager.SaveCurrentModifiedScenesIfUserWantsTo()) return null;
            EditorSceneManager.NewScene(NewSceneSetup.EmptyScene, NewSceneMode.Single);
            var sample = new GameObject(ObjectNames.NicifyVariableName(typeof(T).Name)).AddComponent<T>();
            Selection.activeGameObject = sample.gameObject;
            return sample;
        }

        /// What a running game draws its interface with: a theme lies beside this sample.
        static PanelSettings Settings()
        {
            foreach (var guid in AssetDatabase.FindAssets("t:ThemeStyleSheet"))
            {
                var path = AssetDatabase.GUIDToAssetPath(guid);
                if (Path.GetFileName(path) != "LumivoxSamples.tss") continue;
                var target = Path.ChangeExtension(path, ".asset");
                var known = AssetDatabase.LoadAssetAtPath<PanelSettings>(target);
                if (known != null) return known;
                var made = ScriptableObject.CreateInstance<PanelSettings>();
                made.themeStyleSheet = AssetDatabase.LoadAssetAtPath<ThemeStyleSheet>(path);
                AssetDatabase.CreateAsset(made, target);
                return made;
            }
            Debug.LogError("LumivoxSamples.tss is missing: import the samples again with the Package Manager.");
            return null;
        }
    }
}
