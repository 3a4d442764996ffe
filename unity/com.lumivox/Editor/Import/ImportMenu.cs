using System.Linq;
using UnityEditor;

namespace Lumivox.Editor
{
    /// <summary>The ways to a scan in Unity's Assets menu.</summary>
    static class ImportMenu
    {
        const string FolderItem = "Assets/Lumivox/Import DICOM Folder...", FileItem = "Assets/Lumivox/Import Scan File...", MarkItem = "Assets/Lumivox/Import as Scan";
        const int Priority = 320;
        static readonly string[] filters = { "Scans", "zip,nii,gz,nrrd,nhdr,mha,mhd,dcm,raw", "All files", "*" };

        [MenuItem(FolderItem, false, Priority)]
        static void ImportFolder()
        {
            var path = EditorUtility.OpenFolderPanel("Import a DICOM folder", "", "");
            if (!string.IsNullOrEmpty(path)) ImportWindow.Open(path);
        }

        [MenuItem(FileItem, false, Priority + 1)]
        static void ImportFile()
        {
            var path = EditorUtility.OpenFilePanelWithFilters("Import a scan", "", filters);
            if (!string.IsNullOrEmpty(path)) ImportWindow.Open(path);
        }

        /// Files that may be anybody's become scans when somebody says so.
        [MenuItem(MarkItem, false, Priority + 2)]
        static void MarkSelected()
        {
            foreach (var path in Markable()) AssetDatabase.SetImporterOverride<ScanImporter>(path);
        }

        [MenuItem(MarkItem, true)]
        static bool CanMarkSelected() => Markable().Length > 0;

        static string[] Markable() => Selection.objects.Select(AssetDatabase.GetAssetPath)
            .Where(path => path != "" && !AssetDatabase.IsValidFolder(path) && ScanImporter.CanOverride(path) && AssetDatabase.GetImporterOverride(path) == null).Distinct().ToArray();
    }
}
