using System.IO;
using Lumivox.Native;
using UnityEditor;
using UnityEditor.AssetImporters;

namespace Lumivox.Editor
{
    /// <summary>Imports scans that were saved into the project: the file is what is read, so nothing is copied.</summary>
    [ScriptedImporter(4, "lumivox")]
    public sealed class StoredScanImporter : ScriptedImporter
    {
        public override void OnImportAsset(AssetImportContext ctx)
        {
            LumivoxVolumeAsset opened = null;
            try
            {
                opened = EditorWork.Wait(LumivoxVolumeAsset.LoadFile(StoredScans.ProjectFile(ctx.assetPath)),
                    () => EditorUtility.DisplayProgressBar("Import " + Path.GetFileName(ctx.assetPath), "Reading the scan", 0.5f));
                var asset = LumivoxVolumeAsset.Stored(AssetDatabase.AssetPathToGUID(ctx.assetPath), opened.Handle);
                ScanPictures.Add(ctx, asset, opened);
            }
            catch (LumivoxException error)
            {
                ctx.LogImportError($"{Path.GetFileName(ctx.assetPath)} was not imported: {error.Message}{(Border.Fault != null ? ScanImporter.Afterwards : "")}");
            }
            finally
            {
                EditorUtility.ClearProgressBar();
                if (opened != null) DestroyImmediate(opened);
            }
        }
    }
}
