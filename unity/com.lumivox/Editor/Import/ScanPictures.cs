using System;
using System.IO;
using UnityEditor;
using UnityEditor.AssetImporters;
using UnityEngine;
using Object = UnityEngine.Object;

namespace Lumivox.Editor
{
    /// <summary>The pictures that the project window shows of scans.</summary>
    static class ScanPictures
    {
        const int Side = 128;

        /// <summary>
        /// A scan that is open, as the preset that suits it shows it; null where it cannot be pictured, and then why. Waits
        /// for it. Whoever asks destroys it.
        /// </summary>
        public static Texture2D Of(LumivoxVolumeAsset scan, out string problem, int side = Side)
        {
            problem = null;
            try
            {
                return EditorWork.Wait(scan.RequestPicture(side));
            }
            catch (Exception error) when (EditorWork.IsOutside(error))
            {
                problem = error.Message;
                return null;
            }
        }

        /// <summary>
        /// Adds a scan to what an importer makes, with the picture of the same scan where it is open. A label map comes as
        /// labels that all look as their volume says, which can be shown at once.
        /// </summary>
        public static void Add(AssetImportContext ctx, LumivoxVolumeAsset asset, LumivoxVolumeAsset opened)
        {
            var picture = Of(opened, out var problem);
            // A scan without a picture is still a scan.
            if (problem != null) ctx.LogImportWarning($"{Path.GetFileName(ctx.assetPath)} has no picture: {problem}");
            ctx.AddObjectToAsset("scan", asset, picture);
            if (asset.isLabelMap)
            {
                asset.name = Path.GetFileNameWithoutExtension(ctx.assetPath);
                var labels = LumivoxLabels.Of(asset);
                ctx.AddObjectToAsset("labels", labels, picture);
                ctx.SetMainObject(labels);
            }
            else ctx.SetMainObject(asset);
            // The import, which ends before that, keeps a copy.
            if (picture != null) EditorApplication.delayCall += () => Object.DestroyImmediate(picture);
        }
    }
}
