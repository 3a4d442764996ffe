// Where the editor keeps the files of scans: what importers made lies among Unity's own results in Library, and what was
// saved into the project is the asset itself.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using UnityEditor;
using UnityEditor.AssetImporters;
using UnityEditor.Experimental;
using UnityEngine;

namespace Lumivox.Editor
{
    static class StoredScans
    {
        /// <summary>What an importer calls its result.</summary>
        const string Artifact = "scan" + LumivoxVolumeAsset.FileExtension;

        [InitializeOnLoadMethod]
        static void Hook() => LumivoxVolumeAsset.EditorFile = FileOf;

        /// <summary>What a scene's scan is called in its players: the scene's GUID and a number.</summary>
        public static string IdOf(string guid, int number) => $"{guid}-{number}";

        /// <summary>The file of the scan with an id, an asset's GUID or that of a scene and a number; null where there is none.</summary>
        public static string FileOf(string id)
        {
            var dash = id.IndexOf('-');
            var guid = dash < 0 ? id : id.Substring(0, dash);
            var asset = AssetDatabase.GUIDToAssetPath(guid);
            if (string.IsNullOrEmpty(asset)) return null;
            var ending = LumivoxVolumeAsset.FileExtension + (dash < 0 ? "" : id.Substring(dash + 1));
            if (dash < 0 && asset.EndsWith(ending, StringComparison.OrdinalIgnoreCase)) return ProjectFile(asset);
            var artifact = AssetDatabaseExperimental.LookupArtifact(new ArtifactKey(new GUID(guid)));
            if (!artifact.isValid || !AssetDatabaseExperimental.GetArtifactPaths(artifact, out var paths)) return null;
            foreach (var path in paths)
                if (path.EndsWith(ending, StringComparison.OrdinalIgnoreCase)) return ProjectFile(path);
            return null;
        }

        /// <summary>Has an importer's scan written where Unity keeps its results; of several each has a number.</summary>
        public static void Keep(AssetImportContext ctx, Action<string> write, string number = "")
        {
            // Absolute, for the library knows no project.
#if UNITY_6000_5_OR_NEWER
            // Unity does not say when it copies the file: it stays until the import is over, in a folder that goes with the editor.
            var written = ProjectFile(FileUtil.GetUniqueTempPathInProject());
            EditorApplication.delayCall += () => File.Delete(written);
            write(written);
            ctx.SetOutputArtifactFile(Artifact + number, written);
#else
            write(ProjectFile(ctx.GetOutputArtifactFilePath(Artifact + number)));
#endif
        }

        /// <summary>Whether there may be a scan at a path, a label map, which comes with its labels, or a scene with several.</summary>
        public static bool MayHold(string path)
        {
            var type = AssetDatabase.GetMainAssetTypeAtPath(path);
            return type == typeof(LumivoxVolumeAsset) || type == typeof(LumivoxLabels) || type == typeof(GameObject) && path.EndsWith(LumivoxVolumeAsset.FileExtension, StringComparison.OrdinalIgnoreCase);
        }

        /// <summary>The scans and label maps at a path.</summary>
        public static IEnumerable<LumivoxVolumeAsset> At(string path) => AssetDatabase.LoadAllAssetsAtPath(path).OfType<LumivoxVolumeAsset>();

        /// <summary>The full path of a file that Unity names from the project's folder.</summary>
        public static string ProjectFile(string path) => Path.GetFullPath(Path.Combine(Path.GetDirectoryName(Application.dataPath) ?? ".", path));
    }

    /// <summary>Scans whose files have become others are read again.</summary>
    sealed class ImportedScans : AssetPostprocessor
    {
        static void OnPostprocessAllAssets(string[] importedAssets, string[] deletedAssets, string[] movedAssets, string[] movedFromAssetPaths)
        {
            foreach (var path in importedAssets)
            {
                if (ScanImporter.ShouldOverride(path))
                {
                    AssetDatabase.SetImporterOverride<ScanImporter>(path);
                    continue;
                }
                if (!StoredScans.MayHold(path)) continue;
                foreach (var asset in StoredScans.At(path))
                    if (asset.state != LumivoxVolumeState.Closed) asset.Reopen();
            }
        }
    }
}
