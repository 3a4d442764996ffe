using System.IO;
using Lumivox.Native;
using UnityEditor;
using UnityEngine;
// UnityEditor has another type of that name.
using PackageInfo = UnityEditor.PackageManager.PackageInfo;

namespace Lumivox.Editor
{
    /// <summary>
    /// The program that decodes JPEG-LS and JPEG 2000 beside the editor: a file that crashes a decoder costs a slice then, and
    /// not what was not saved. It lies beside the native library; where there is none, and in players, they are decoded in
    /// the process itself.
    /// </summary>
    static class CodecProgram
    {
        [InitializeOnLoadMethod]
        static void Hook()
        {
            var package = PackageInfo.FindForAssembly(typeof(CodecProgram).Assembly);
            Border.CodecProgram = Find(package != null ? Path.Combine(package.resolvedPath, "Runtime", "Plugins") : null, Path.Combine(Application.dataPath, "Plugins"));
        }

        /// <summary>The program of this system in the package's folder of plugins, or in the project's; null where there is none.</summary>
        internal static string Find(string ofPackage, string ofProject)
        {
            var (folder, name) = Application.platform == RuntimePlatform.WindowsEditor ? ("Windows/x86_64", "lumivox-codecs.exe")
                : Application.platform == RuntimePlatform.OSXEditor ? ("macOS", "lumivox-codecs")
                : ("Linux/x86_64", "lumivox-codecs");
            if (ofPackage != null && File.Exists(Path.Combine(ofPackage, folder, name))) return Path.Combine(ofPackage, folder, name);
            return File.Exists(Path.Combine(ofProject, name)) ? Path.Combine(ofProject, name) : null;
        }
    }
}
