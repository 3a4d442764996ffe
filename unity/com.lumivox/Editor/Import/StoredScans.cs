// Where the editor keeps the files of scans: what importers made lies among Unity's own results in Library, and what was
// saved into the project is the asset itself.
using System;
using System.IO;
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

        /// <summary>The file of the scan with an asset's GUID; null where there is none.</summary>
        public static string FileOf(string id)
        {
            var asset = AssetDatabase.GUIDToAssetPath(id);
            if (string.IsNullOrEmpty(asset)) return null;
            if (asset.EndsWith(LumivoxVolumeAsset.FileExtension, StringComparison.OrdinalIgnoreCase)) return ProjectFile(asset);
            var artifact = AssetDatabaseExperimental.LookupArtifact(new ArtifactKey(new GUID(id)));
            if (!artifact.isValid || !AssetDatabaseExperimental.GetArtifactPaths(artifact, out var paths)) return null;
            foreach (var path in paths)
                if (path.EndsWith(LumivoxVolumeAsset.FileExtension, StringComparison.OrdinalIgnoreCase)) return ProjectFile(path);
            return null;
        }

        /// <summary>Has an importer's scan written where Unity keeps its results.</summary>
        public static void Keep(AssetImportContext ctx, Action<string> write)
        {
            // Absolute, for the library knows no project.
#if UNITY_6000_5_OR_NEWER
            // Unity does not say when it copies the file: it stays until the import is over, in a folder that goes with the editor.
            var written = ProjectFile(FileUtil.GetUniqueTempPathInProject());
            EditorApplication.delayCall += () => File.Delete(written);
            write(written);
            ctx.SetOutputArtifactFile(Artifact, written);
#else
            write(ProjectFile(ctx.GetOutputArtifactFilePath(Artifact)));
#endif
        }

        /// <summary>Whether there may be a scan at a path, or a label map, which comes with its labels.</summary>
        public static bool MayHold(string path)
        {
            var type = AssetDatabase.GetMainAssetTypeAtPath(path);
            return type == typeof(LumivoxVolumeAsset) || type == typeof(LumivoxLabels);
        }

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
                var asset = AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>(path);
                if (asset != null && asset.state != LumivoxVolumeState.Closed) asset.Reopen();
            }
        }
    }
}
