// Scans by all ways: computed, loaded by a script, imported as an asset.
using System.Collections;
using System.IO;
using System.Text;
using UnityEditor;
using UnityEngine;
using Object = UnityEngine.Object;

namespace Lumivox.Editor
{
    internal static class ImportChecks
    {
        /// <summary>Voxels along the axes of the scan that is imported, whose values count from 0.</summary>
        static readonly Vector3Int size = new Vector3Int(12, 10, 8);

        const int PhantomSize = 32;
        const string Remedy = "Unity's console may say why; attach this report to an issue.";

        public static IEnumerator Phantom(Check check)
        {
            var scan = LumivoxVolumeAsset.Phantom("cube", PhantomSize);
            try
            {
                var opening = scan.Open();
                while (!opening.IsCompleted) yield return null;
                if (!opening.GetAwaiter().GetResult() || scan.state != LumivoxVolumeState.Ready) check.Fail($"the phantom could not be computed: {scan.error}", Remedy);
                else if (scan.dimensions != Vector3Int.one * PhantomSize) check.Fail($"the phantom has {scan.dimensions} voxels, not {PhantomSize} along each side", Remedy);
            }
            finally
            {
                Object.DestroyImmediate(scan);
            }
        }

        public static IEnumerator Import(Check check)
        {
            var file = Path.Combine(SelfCheckRun.Folder, "scan.nrrd");
            File.WriteAllBytes(file, Nrrd());
            LumivoxVolumeAsset scan = null;
            try
            {
                using (var importer = new LumivoxImporter())
                {
                    var loading = importer.Load(new[] { file });
                    while (!loading.IsCompleted) yield return null;
                    scan = loading.GetAwaiter().GetResult();
                }
                Compare(check, scan);
            }
            finally
            {
                if (scan != null) Object.DestroyImmediate(scan);
                File.Delete(file);
            }
        }

        public static IEnumerator Asset(Check check)
        {
            // A folder of its own, which goes with all that is in it.
            var folder = AssetDatabase.GenerateUniqueAssetPath("Assets/Lumivox Self-Check");
            AssetDatabase.CreateFolder("Assets", Path.GetFileName(folder));
            try
            {
                var path = folder + "/scan.nrrd";
                File.WriteAllBytes(StoredScans.ProjectFile(path), Nrrd());
                AssetDatabase.ImportAsset(path, ImportAssetOptions.ForceSynchronousImport);
                yield return null;
                if (!(AssetImporter.GetAtPath(path) is ScanImporter importer))
                {
                    check.Fail($"{Path.GetFileName(path)} was imported by {AssetImporter.GetAtPath(path)?.GetType().Name ?? "nothing"}, not by Lumivox", "Remove what else imports .nrrd files from the project.");
                    yield break;
                }
                ChangeSettings(check, importer, path);
                yield return null;
                var scan = AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>(path);
                if (scan == null)
                {
                    check.Fail("the file was imported, but is no scan", Remedy);
                    yield break;
                }
                var opening = scan.Open();
                while (!opening.IsCompleted) yield return null;
                if (!opening.GetAwaiter().GetResult()) check.Fail($"the imported scan could not be opened: {scan.error}", Remedy);
                else Compare(check, scan);
            }
            finally
            {
                AssetDatabase.DeleteAsset(folder);
            }
        }

        /// A setting that is changed is kept, and the file imported with it.
        static void ChangeSettings(Check check, ScanImporter importer, string path)
        {
            using (var settings = new SerializedObject(importer))
            {
                var kept = settings.FindProperty("m_KeepEverything");
                kept.boolValue = true;
                settings.ApplyModifiedPropertiesWithoutUndo();
            }
            importer.SaveAndReimport();
            using (var settings = new SerializedObject(AssetImporter.GetAtPath(path)))
                if (!settings.FindProperty("m_KeepEverything").boolValue) check.Fail("the importer lost a setting when the file was imported again", Remedy);
        }

        static void Compare(Check check, LumivoxVolumeAsset scan)
        {
            var last = size.x * size.y * size.z - 1;
            if (scan.dimensions != size) check.Fail($"the scan has {scan.dimensions} voxels instead of {size}", Remedy);
            if (scan.spacingMm != new Vector3(1, 1, 2)) check.Fail($"its voxels are {scan.spacingMm} mm large instead of (1, 1, 2)", Remedy);
            if (scan.valueRange != new Vector2(0, last)) check.Fail($"its values are {scan.valueRange} instead of 0 to {last}", Remedy);
        }

        static byte[] Nrrd()
        {
            var header = Encoding.ASCII.GetBytes($"NRRD0004\ntype: uint16\ndimension: 3\nspace: left-posterior-superior\nsizes: {size.x} {size.y} {size.z}\n"
                + "space directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (0,0,0)\nendian: little\nencoding: raw\n\n");
            var file = new byte[header.Length + size.x * size.y * size.z * 2];
            header.CopyTo(file, 0);
            for (var i = 0; i < size.x * size.y * size.z; i++)
            {
                file[header.Length + 2 * i] = (byte)i;
                file[header.Length + 2 * i + 1] = (byte)(i >> 8);
            }
            return file;
        }
    }
}
