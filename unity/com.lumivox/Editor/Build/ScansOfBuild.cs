// A player's build takes along the files of the scans that it uses, and of no others.
using System.Collections.Generic;
using System.IO;
using System.Linq;
using UnityEditor;
using UnityEditor.Build;
using UnityEngine;

namespace Lumivox.Editor
{
    sealed class ScansOfBuild : BuildPlayerProcessor
    {
        public override int callbackOrder => 0;

        public override void PrepareForBuild(BuildPlayerContext buildPlayerContext)
        {
            foreach (var path in Used(buildPlayerContext.BuildPlayerOptions.scenes))
            {
                foreach (var scan in StoredScans.At(path))
                {
                    // Phantoms are computed where they are shown, and looks of labels refer to their map.
                    if (scan.StoredId == "") continue;
                    var file = StoredScans.FileOf(scan.StoredId);
                    if (file == null || !File.Exists(file)) throw new BuildFailedException($"The voxels of {path} are not there: reimport it, then build again.");
                    buildPlayerContext.AddAdditionalPathToStreamingAssets(Nameless(file, scan.StoredId), $"{LumivoxVolumeAsset.StreamingFolder}/{scan.StoredId}{LumivoxVolumeAsset.FileExtension}");
                }
            }
        }

        /// <summary>A copy that does not tell players where the scan's files lay on this machine; Unity empties Temp when it ends.</summary>
        static string Nameless(string file, string id)
        {
            var copy = StoredScans.ProjectFile($"Temp/Lumivox/{id}{LumivoxVolumeAsset.FileExtension}");
            Directory.CreateDirectory(Path.GetDirectoryName(copy));
            try
            {
                LumivoxVolumeAsset.CopyNameless(file, copy);
            }
            catch (LumivoxException error)
            {
                throw new BuildFailedException(error.Message);
            }
            return copy;
        }

        /// <summary>Scans and label maps that scenes, resources and preloaded assets refer to, or things that these do.</summary>
        internal static IEnumerable<string> Used(string[] scenes)
        {
            var roots = new List<string>();
            if (scenes != null && scenes.Length > 0) roots.AddRange(scenes);
            else roots.AddRange(EditorBuildSettings.scenes.Where(scene => scene.enabled).Select(scene => scene.path));
            roots.AddRange(AssetDatabase.GetAllAssetPaths().Where(path => path.Contains("/Resources/") && !path.Contains("/Editor/")));
            roots.AddRange(PlayerSettings.GetPreloadedAssets().Where(asset => asset != null).Select(AssetDatabase.GetAssetPath));
            return AssetDatabase.GetDependencies(roots.Where(path => !string.IsNullOrEmpty(path)).Distinct().ToArray(), true)
                .Where(StoredScans.MayHold).Distinct();
        }
    }
}
