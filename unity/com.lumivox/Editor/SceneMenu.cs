using System.IO;
using UnityEditor;
using UnityEngine;

namespace Lumivox.Editor
{
    /// <summary>A scene document of what the scene view shows, as an asset.</summary>
    static class SceneMenu
    {
        const string Item = "Assets/Create/Lumivox/Scene from View", Title = "Scene from view";

        [MenuItem(Item, false, 312)]
        static void Create()
        {
            var view = SceneView.lastActiveSceneView;
            if (view == null)
            {
                Tell("There is no scene view: open one with Window > General > Scene.");
                return;
            }
            var path = AssetDatabase.GenerateUniqueAssetPath($"{Folder()}/Scene{LumivoxVolumeAsset.FileExtension}");
            try
            {
                LumivoxScene.Save(view.camera, StoredScans.ProjectFile(path));
            }
            catch (LumivoxException error)
            {
                Tell($"The view was not saved: {error.Message}");
                return;
            }
            AssetDatabase.Refresh();
            AssetDatabase.ImportAsset(path);
            Selection.activeObject = AssetDatabase.LoadMainAssetAtPath(path);
        }

        static void Tell(string what) => EditorUtility.DisplayDialog(Title, what, "OK");

        /// <summary>That of what is selected in the project window.</summary>
        static string Folder()
        {
            var path = Selection.activeObject != null ? AssetDatabase.GetAssetPath(Selection.activeObject) : "";
            if (string.IsNullOrEmpty(path) || !path.StartsWith("Assets")) return "Assets";
            return AssetDatabase.IsValidFolder(path) ? path : Path.GetDirectoryName(path).Replace('\\', '/');
        }
    }
}
