// Packages of the project: the one that is tested.
using System;
using System.IO;
using System.Reflection;
using System.Text.RegularExpressions;

namespace UnityEditor.PackageManager
{
    public sealed class PackageInfo
    {
        PackageInfo() { }
        public string name { get; internal set; } = "";
        /// Where its files are.
        public string resolvedPath { get; internal set; } = "";
        /// Null for what lies in Assets.
        public string version { get; internal set; } = "";
        public static PackageInfo FindForAssembly(Assembly assembly)
        {
            if (assembly == null) throw new ArgumentNullException(nameof(assembly));
            var folder = (Environment.GetEnvironmentVariable("STANDIN_PACKAGES") ?? "").Split(':')[0];
            return folder == "" ? null : new PackageInfo { name = "com.lumivox", resolvedPath = folder, version = Regex.Match(File.ReadAllText(Path.Combine(folder, "package.json")), "\"version\": *\"([^\"]+)\"").Groups[1].Value };
        }
    }
}
