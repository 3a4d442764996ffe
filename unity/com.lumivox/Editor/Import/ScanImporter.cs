using System;
using System.IO;
using System.Threading.Tasks;
using Lumivox.Native;
using UnityEditor;
using UnityEditor.AssetImporters;
using UnityEngine;

namespace Lumivox.Editor
{
    /// <summary>
    /// Imports scans and label maps that are one file: NIfTI, NRRD and MetaImage by themselves; gz, zip, DICOM and RAW where somebody says so.
    /// </summary>
    /// <remarks>
    /// Unity goes by the last part of a name, and gz, zip and raw are often a project's own files: those are left alone
    /// until the inspector's 'Importer' or 'Assets > Lumivox > Import as Scan' says that one is a scan. Names that say it
    /// themselves (`.nii.gz`, `.dcm.zip`, `.dicom.zip`) are taken at once. The voxels go from the file straight to a file
    /// of Lumivox' own among the import's results; they are never on the managed heap.
    /// </remarks>
    [ScriptedImporter(6, new[] { "nii", "nrrd", "nhdr", "mha", "mhd" }, new[] { "gz", "zip", "dcm", "dicom", "ima", "raw" }, AllowCaching = true)]
    public sealed class ScanImporter : ScriptedImporter
    {
        static readonly string[] known = { ".nii.gz", ".dcm.zip", ".dicom.zip" };
        static readonly string[] possible = { ".gz", ".zip", ".dcm", ".dicom", ".ima", ".raw" };

        [SerializeField, Tooltip("Which series of a DICOM study: its position from 1, its SeriesInstanceUID or its number. Empty: the best.")]
        string m_Series = "";
        [SerializeField, Min(0), Tooltip("Which volume of a series with several, from 1. 0: the first that is whole.")]
        int m_Phase;
        [SerializeField, Tooltip("Slices that are missing stay empty; otherwise a scan that lacks some is not imported.")]
        bool m_LeaveGaps;
        [SerializeField, Tooltip("Slices that are damaged are filled in from their neighbours; otherwise they stay empty.")]
        bool m_FillDamaged;
        [SerializeField, Tooltip("Of a header that you trust: its data may be files that lie neither beside it nor below it.")]
        bool m_AllowOutsideData;
        [SerializeField, Tooltip("Of a CT: the table, clothes and cables are a part of the scan. Otherwise they are put aside, and Keep Everything of a volume shows them.")]
        bool m_KeepEverything;
        [SerializeField, Tooltip("Whether the file is a scan or a map of labels, such as a segmentation. Automatic: what it looks like.")]
        LumivoxLabelMaps m_LabelMap = LumivoxLabelMaps.Automatic;
        [SerializeField, Tooltip("What a file without a header holds, such as 256x256x108:i16le:spacing=1,1,2.")]
        string m_Raw = "";

        /// <summary>Whether a file's whole name says that it is a scan, though its last part is anybody's.</summary>
        internal static bool ShouldOverride(string path) =>
            EndsWith(path, known) && AssetDatabase.GetImporterOverride(path) == null;

        /// <summary>Whether somebody may say that a file is a scan.</summary>
        internal static bool CanOverride(string path) => EndsWith(path, possible);

        static bool EndsWith(string path, string[] ends)
        {
            foreach (var end in ends)
                if (path.EndsWith(end, StringComparison.OrdinalIgnoreCase)) return true;
            return false;
        }

        LumivoxImportOptions Options => new LumivoxImportOptions
        {
            series = Said(m_Series),
            phase = m_Phase,
            leaveGaps = m_LeaveGaps,
            fillDamaged = m_FillDamaged,
            allowOutsideData = m_AllowOutsideData,
            keepEverything = m_KeepEverything,
            labelMaps = m_LabelMap,
            raw = Said(m_Raw),
        };

        static string Said(string text) => string.IsNullOrWhiteSpace(text) ? null : text.Trim();

        public override void OnImportAsset(AssetImportContext ctx)
        {
            var file = StoredScans.ProjectFile(ctx.assetPath);
            foreach (var data in DetachedData.Of(ctx.assetPath)) ctx.DependsOnSourceAsset(data);
            using (var importer = new LumivoxImporter())
            {
                var progress = default(LumivoxProgress);
                importer.progressed += now => progress = now;
                // Whoever waits sees how far it is, and may stop it.
                void Show()
                {
                    var text = string.IsNullOrEmpty(progress.stage) ? "Reading" : progress.stage;
                    if (EditorUtility.DisplayCancelableProgressBar("Import " + Path.GetFileName(ctx.assetPath), text, progress.fraction)) importer.Cancel();
                }
                LumivoxVolumeAsset made = null;
                try
                {
                    var options = Options;
                    var report = EditorWork.Wait(importer.Scan(new[] { file }, options), Show);
                    made = EditorWork.Wait(importer.Load(new[] { file }, options), Show);
                    StoredScans.Keep(ctx, into => EditorWork.Wait(made.Save(into), () => EditorUtility.DisplayProgressBar("Import " + Path.GetFileName(ctx.assetPath), "Writing the scan", 1)));
                    var asset = LumivoxVolumeAsset.Stored(AssetDatabase.AssetPathToGUID(ctx.assetPath), made.Handle);
                    ScanPictures.Add(ctx, asset, made);
                    Tell(ctx, asset.GetReport(), report);
                }
                catch (TaskCanceledException)
                {
                    ctx.LogImportError($"{Path.GetFileName(ctx.assetPath)} was not imported: it was stopped. Choose 'Reimport' to try again.");
                }
                catch (LumivoxException error)
                {
                    ctx.LogImportError($"{Path.GetFileName(ctx.assetPath)} was not imported: {error.Message}{Remedy(ctx.assetPath)}");
                }
                finally
                {
                    EditorUtility.ClearProgressBar();
                    if (made != null) DestroyImmediate(made);
                }
            }
        }

        string Remedy(string path)
        {
            if (Border.Fault != null) return Afterwards;
            if (path.EndsWith(".raw", StringComparison.OrdinalIgnoreCase) && Said(m_Raw) == null) return " Describe it under 'Raw' in the inspector.";
            return CanOverride(path) ? " If it is no scan, choose another 'Importer' in the inspector." : "";
        }

        /// <summary>Unity imports no file again because a library has come.</summary>
        internal const string Afterwards = " Then choose 'Reimport'.";

        static void Tell(AssetImportContext ctx, LumivoxReport scan, LumivoxReport study)
        {
            foreach (var note in scan.notes) ctx.LogImportWarning($"{Path.GetFileName(ctx.assetPath)}: {note}");
            if (study.series.Length > 1 && study.format == "DICOM")
                ctx.LogImportWarning($"{Path.GetFileName(ctx.assetPath)} is of a study with {study.series.Length} series. Set 'Series' in the inspector to take another, or import several with Assets > Lumivox > Import Scan File.");
        }
    }
}
