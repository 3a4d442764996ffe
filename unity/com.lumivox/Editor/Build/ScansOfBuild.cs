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
                var scan = AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>(path);
                // Phantoms are computed where they are shown, and looks of labels refer to their map.
                if (scan == null || scan.StoredId == "") continue;
                var file = StoredScans.FileOf(scan.StoredId);
                if (file == null || !File.Exists(file)) throw new BuildFailedException($"The voxels of {path} are not there: reimport it, then build again.");
                buildPlayerContext.AddAdditionalPathToStreamingAssets(file, $"{LumivoxVolumeAsset.StreamingFolder}/{scan.StoredId}{LumivoxVolumeAsset.FileExtension}");
            }
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
