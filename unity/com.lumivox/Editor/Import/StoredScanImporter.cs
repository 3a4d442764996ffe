using System.IO;
using Lumivox.Native;
using UnityEditor;
using UnityEditor.AssetImporters;
using UnityEngine;

namespace Lumivox.Editor
{
    /// <summary>
    /// Imports what Lumivox has saved into the project: scans, whose file is what is read, so that nothing is copied; and scene
    /// documents, which begin otherwise, and become objects.
    /// </summary>
    [ScriptedImporter(5, "lumivox")]
    public sealed class StoredScanImporter : ScriptedImporter
    {
        [SerializeField, Tooltip("Of a scene that you trust: headers of its scans may name data files that lie neither beside them nor below.")]
        bool m_AllowOutsideData;

        public override void OnImportAsset(AssetImportContext ctx)
        {
            if (SceneImport.IsScene(ctx.assetPath))
            {
                SceneImport.Import(ctx, m_AllowOutsideData);
                return;
            }
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
