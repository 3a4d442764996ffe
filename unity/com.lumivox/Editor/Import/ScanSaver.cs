using System;
using System.IO;
using System.Threading.Tasks;
using UnityEditor;
using UnityEngine;

namespace Lumivox.Editor
{
    /// <summary>Saves a scan that was imported into the project, as an asset; goes on though its window is closed.</summary>
    static class ScanSaver
    {
        /// <summary>Whether a path can be that of a scan in the project; why not otherwise.</summary>
        public static bool IsTarget(string path, out string problem)
        {
            problem = null;
            if (string.IsNullOrWhiteSpace(path) || !path.Replace('\\', '/').StartsWith("Assets/", StringComparison.Ordinal) || path.Contains(".."))
                problem = $"Save the scan inside the project: Assets/name{LumivoxVolumeAsset.FileExtension}";
            else if (Path.GetFileNameWithoutExtension(path).Trim() == "" || path.IndexOfAny(Path.GetInvalidPathChars()) >= 0 || Path.GetFileName(path).IndexOfAny(Path.GetInvalidFileNameChars()) >= 0)
                problem = $"'{Path.GetFileName(path)}' is no name for a file.";
            return problem == null;
        }

        /// <summary>With the ending that says what it is.</summary>
        public static string WithExtension(string path)
        {
            path = path.Trim().Replace('\\', '/');
            return path.EndsWith(LumivoxVolumeAsset.FileExtension, StringComparison.OrdinalIgnoreCase) ? path : path + LumivoxVolumeAsset.FileExtension;
        }

        /// <summary>A path that is free, of what a series is called: folders and archives are often called by the patient's name.</summary>
        public static string FreePath(string name, string folder)
        {
            foreach (var no in Path.GetInvalidFileNameChars()) name = name.Replace(no, ' ');
            name = name.Trim();
            return AssetDatabase.GenerateUniqueAssetPath($"{folder}/{(name == "" ? "Scan" : name)}{LumivoxVolumeAsset.FileExtension}");
        }

        /// <summary>Writes a scan and imports it; then tells the asset, or why there is none. What was made is kept until then.</summary>
        public static void Save(LumivoxVolumeAsset made, string path, Action<LumivoxVolumeAsset, string> done) => Save<LumivoxVolumeAsset>(made, path, done);

        /// <summary>The same of what the file then is: a label map is labels.</summary>
        public static void Save<T>(LumivoxVolumeAsset made, string path, Action<T, string> done) where T : UnityEngine.Object
        {
            var file = StoredScans.ProjectFile(path);
            Task saving;
            try
            {
                Directory.CreateDirectory(Path.GetDirectoryName(file));
                saving = made.Save(file);
            }
            catch (Exception error) when (error is IOException || error is UnauthorizedAccessException || error is LumivoxException)
            {
                done(null, $"{path} could not be written: {error.Message}");
                return;
            }
            EditorWork.WhenDone(saving, problem =>
            {
                if (problem != null)
                {
                    done(null, $"{path} could not be written: {problem}");
                    return;
                }
                AssetDatabase.ImportAsset(path);
                var asset = AssetDatabase.LoadAssetAtPath<T>(path);
                done(asset, asset == null ? $"{path} was written, but not imported; the console says why." : null);
            });
        }
    }
}
