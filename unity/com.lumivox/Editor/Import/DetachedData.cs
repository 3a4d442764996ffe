using System;
using System.Collections.Generic;
using System.IO;

namespace Lumivox.Editor
{
    /// <summary>The files that a header names its voxels in, so that a change of theirs is one of the scan's.</summary>
    static class DetachedData
    {
        /// Headers are text, and name their data within their first lines.
        const int LongestHeader = 1 << 16;

        public static IEnumerable<string> Of(string assetPath)
        {
            var extension = Path.GetExtension(assetPath).ToLowerInvariant();
            var key = extension == ".mhd" ? "elementdatafile" : extension == ".nhdr" ? "data file" : null;
            if (key == null) yield break;
            foreach (var line in Head(StoredScans.ProjectFile(assetPath)).Split('\n'))
            {
                var parts = line.Split(new[] { extension == ".mhd" ? '=' : ':' }, 2);
                if (parts.Length < 2 || parts[0].Trim().ToLowerInvariant() != key) continue;
                var name = parts[1].Trim();
                // Several files are named by a pattern or a list; those have no one name.
                if (name == "" || name == "LOCAL" || name.StartsWith("LIST", StringComparison.Ordinal) || name.Contains("%") || Path.IsPathRooted(name)) continue;
                var data = Path.GetDirectoryName(assetPath).Replace('\\', '/') + "/" + name;
                if (!name.Contains("..") && File.Exists(StoredScans.ProjectFile(data))) yield return data;
            }
        }

        static string Head(string file)
        {
            try
            {
                using (var reader = new StreamReader(file))
                {
                    var text = new char[LongestHeader];
                    return new string(text, 0, reader.ReadBlock(text, 0, text.Length));
                }
            }
            catch (IOException)
            {
                return "";
            }
        }
    }
}
