using System.Collections.Generic;
using System.IO;
using UnityEditor;
using UnityEditor.SceneManagement;
using UnityEngine;

namespace Lumivox.Editor
{
    /// <summary>What people do to volumes in the editor, each as one step of undo.</summary>
    static class VolumeActions
    {
        const int Priority = 10, PhantomSize = 128;

        [MenuItem("GameObject/Lumivox/Volume", false, Priority)]
        static void CreateEmpty(MenuCommand command) => Selection.activeGameObject = Create(Selection.activeObject as LumivoxVolumeAsset, command.context as GameObject).gameObject;

        [MenuItem("GameObject/Lumivox/Head Phantom", false, Priority + 1)]
        static void CreatePhantom(MenuCommand command)
        {
            var volume = Create(Phantom(), command.context as GameObject);
            Selection.activeGameObject = volume.gameObject;
        }

        [MenuItem("GameObject/Lumivox/Clip", false, Priority + 2)]
        static void CreateClip(MenuCommand command) => Selection.activeGameObject = CreateClip(command.context as GameObject).gameObject;

        [MenuItem("GameObject/Lumivox/Effect", false, Priority + 3)]
        static void CreateEffect(MenuCommand command)
        {
            var made = Make("Lumivox Effect", command.context as GameObject);
            made.AddComponent<LumivoxEffect>();
            Finish(made, "Create Lumivox Effect");
        }

        /// <summary>An object that shows a scan; null shows nothing yet.</summary>
        public static LumivoxVolume Create(LumivoxVolumeAsset scan, GameObject parent)
        {
            var made = Make(scan != null ? scan.name : "Volume", parent);
            var volume = made.AddComponent<LumivoxVolume>();
            if (scan != null) volume.volume = scan;
            Finish(made, "Create Volume");
            return volume;
        }

        /// <summary>A plane through the middle of a volume that cuts it open; its upper half is seen.</summary>
        public static LumivoxClip CreateClip(GameObject parent)
        {
            var made = Make("Clip", parent);
            var clip = made.AddComponent<LumivoxClip>();
            Finish(made, "Create Clip");
            return clip;
        }

        static GameObject Make(string name, GameObject parent)
        {
            var made = new GameObject(name);
            GameObjectUtility.SetParentAndAlign(made, parent);
            GameObjectUtility.EnsureUniqueNameForSibling(made);
            return made;
        }

        static void Finish(GameObject made, string name)
        {
            Undo.RegisterCreatedObjectUndo(made, name);
            Undo.SetCurrentGroupName(name);
            Selection.activeGameObject = made;
        }

        /// <summary>The phantom of a head, for those who have no scan at hand: an asset that says how it is computed.</summary>
        public static LumivoxVolumeAsset Phantom()
        {
            const string path = "Assets/Head Phantom.asset";
            var known = AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>(path);
            if (known != null) return known;
            var made = LumivoxVolumeAsset.Phantom("head", PhantomSize);
            AssetDatabase.CreateAsset(made, AssetDatabase.GenerateUniqueAssetPath(path));
            return made;
        }

        /// <summary>Sets a volume's scan.</summary>
        public static void GiveVolume(LumivoxVolume volume, LumivoxVolumeAsset scan)
        {
            Undo.IncrementCurrentGroup();
            Undo.RecordObject(volume, "Set Volume");
            volume.volume = scan;
            PrefabUtility.RecordPrefabInstancePropertyModifications(volume);
            EditorUtility.SetDirty(volume);
        }

        /// <summary>
        /// Gives volumes the look of a preset. Those that it does not suit stay as they are. The transfer function is the
        /// scene's own; a prefab, which cannot keep one, gets an asset beside it.
        /// </summary>
        public static void ApplyPreset(IReadOnlyList<LumivoxVolume> volumes, string preset)
        {
            if (volumes.Count == 0) return;
            var name = volumes.Count == 1 ? "Apply Preset" : $"Apply Preset to {volumes.Count} Volumes";
            Undo.IncrementCurrentGroup();
            Undo.SetCurrentGroupName(name);
            var group = Undo.GetCurrentGroup();
            foreach (var volume in volumes)
            {
                Undo.RegisterCompleteObjectUndo(volume, name);
                if (string.IsNullOrEmpty(preset)) volume.preset = "";
                else if (!volume.ApplyPreset(preset)) continue;
                else Keep(volume, name);
                PrefabUtility.RecordPrefabInstancePropertyModifications(volume);
                EditorUtility.SetDirty(volume);
            }
            Undo.SetCurrentGroupName(name);
            Undo.CollapseUndoOperations(group);
        }

        /// <summary>Sees to it that the function that a volume was just given is saved with it.</summary>
        public static void Keep(LumivoxVolume volume, string undoName)
        {
            var function = volume.transferFunction;
            if (function == null || AssetDatabase.Contains(function)) return;
            var prefab = PrefabOf(volume);
            if (string.IsNullOrEmpty(prefab))
            {
                Undo.RegisterCreatedObjectUndo(function, undoName);
                return;
            }
            var folder = Path.GetDirectoryName(prefab).Replace('\\', '/');
            AssetDatabase.CreateAsset(function, AssetDatabase.GenerateUniqueAssetPath($"{folder}/{Path.GetFileNameWithoutExtension(prefab)} {function.name}.asset"));
        }

        /// The prefab that a volume is edited in; empty for one of a scene.
        static string PrefabOf(LumivoxVolume volume)
        {
            if (EditorUtility.IsPersistent(volume)) return AssetDatabase.GetAssetPath(volume);
            var stage = PrefabStageUtility.GetPrefabStage(volume.gameObject);
            return stage != null ? stage.assetPath : "";
        }
    }
}
