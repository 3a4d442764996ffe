using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using UnityEditor;
using UnityEngine;
using Object = UnityEngine.Object;

namespace Lumivox.Editor
{
    /// <summary>What people do to the labels of volumes in the editor, each as one step of undo.</summary>
    static class LabelActions
    {
        /// <summary>What is under way; null where nothing is.</summary>
        static LumivoxImporter finding;

        /// <summary>How far the search for labels is, or what came of it; empty before the first.</summary>
        public static string State { get; private set; } = "";

        /// <summary>Whether labels are being looked for.</summary>
        public static bool IsFinding => finding != null;

        /// <summary>Gives volumes labels.</summary>
        public static void Give(IEnumerable<LumivoxVolume> volumes, LumivoxLabels labels, string name)
        {
            Undo.IncrementCurrentGroup();
            Undo.SetCurrentGroupName(name);
            foreach (var volume in volumes.Where(volume => volume != null))
            {
                Undo.RecordObject(volume, name);
                volume.labels = labels;
                PrefabUtility.RecordPrefabInstancePropertyModifications(volume);
                EditorUtility.SetDirty(volume);
            }
        }

        /// <summary>
        /// Whether the looks of labels cannot be edited: those of an imported file are made anew with each import.
        /// </summary>
        public static bool AreImported(LumivoxLabels labels) =>
            labels != null && AssetDatabase.Contains(labels) && !AssetDatabase.GetAssetPath(labels).EndsWith(".asset", StringComparison.OrdinalIgnoreCase);

        /// <summary>Gives volumes an asset of their own with the looks of their imported labels, to be edited; those with the same labels share one.</summary>
        public static void EditLooks(IReadOnlyList<LumivoxVolume> volumes)
        {
            foreach (var group in volumes.Where(volume => AreImported(volume.labels)).GroupBy(volume => volume.labels).ToList())
            {
                var path = AssetDatabase.GetAssetPath(group.Key);
                Give(group, Copy(group.Key, $"{Path.GetDirectoryName(path).Replace('\\', '/')}/{Path.GetFileNameWithoutExtension(path)} looks.asset"), "Edit Looks of Labels");
            }
        }

        static LumivoxLabels Copy(LumivoxLabels of, string path)
        {
            var copy = Object.Instantiate(of);
            AssetDatabase.CreateAsset(copy, AssetDatabase.GenerateUniqueAssetPath(path));
            return copy;
        }

        /// <summary>
        /// Finds the parts of a volume's scan on another thread, saves them as a label map in the project, and gives the volume
        /// labels of it. `done` is told why it came to nothing, or null.
        /// </summary>
        public static void Find(LumivoxVolume volume, Action<string> done)
        {
            if (finding != null)
            {
                done("Labels are being found already.");
                return;
            }
            var scan = volume.volume;
            var importer = finding = new LumivoxImporter();
            State = "";
            importer.progressed += progress => State = $"{progress.stage} {100 * progress.fraction:0}%";
            void End(string problem)
            {
                finding = null;
                importer.Dispose();
                State = problem ?? "";
                done(problem);
            }
            System.Threading.Tasks.Task<LumivoxLabels> task;
            try
            {
                task = importer.FindLabels(scan);
            }
            catch (LumivoxException error)
            {
                End(error.Message);
                return;
            }
            EditorWork.WhenDone(task, problem =>
            {
                if (problem != null)
                {
                    End(problem);
                    return;
                }
                var found = task.Result;
                var (name, folder) = (scan != null ? scan.name : "Scan", FolderOf(scan));
                ScanSaver.Save<LumivoxLabels>(found.map, ScanSaver.FreePath($"{name} labels", folder), (saved, why) =>
                {
                    Object.DestroyImmediate(found.map);
                    Object.DestroyImmediate(found);
                    // It may have gone meanwhile: the labels stay.
                    if (saved != null && volume != null) Give(new[] { volume }, Copy(saved, $"{folder}/{name} looks.asset"), "Find Labels");
                    End(why);
                });
            });
        }

        /// <summary>Stops what is under way.</summary>
        public static void Cancel() => finding?.Cancel();

        static string FolderOf(LumivoxVolumeAsset scan)
        {
            var path = scan != null ? AssetDatabase.GetAssetPath(scan) : "";
            return path.StartsWith("Assets/", StringComparison.Ordinal) ? Path.GetDirectoryName(path).Replace('\\', '/') : "Assets";
        }
    }
}
