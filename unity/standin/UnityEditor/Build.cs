// What a player's build asks of packages.
using System;
using System.Collections.Generic;
using System.IO;

namespace UnityEditor
{
    public enum BuildTarget { NoTarget = -2, StandaloneOSX = 2, StandaloneWindows64 = 19, Android = 13, StandaloneLinux64 = 24, iOS = 9, WebGL = 20 }
    public enum BuildTargetGroup { Unknown = 0, Standalone = 1, iOS = 4, Android = 7 }
    [Flags] public enum BuildOptions { None = 0, Development = 1 }

    public struct BuildPlayerOptions
    {
        public string[] scenes { get; set; }
        public string locationPathName { get; set; }
        public BuildTarget target { get; set; }
        public BuildTargetGroup targetGroup { get; set; }
        public BuildOptions options { get; set; }
    }
}

namespace UnityEditor.Build
{
    public interface IOrderedCallback { int callbackOrder { get; } }

    public abstract class BuildPlayerProcessor : IOrderedCallback
    {
        public virtual int callbackOrder => 0;
        public abstract void PrepareForBuild(BuildPlayerContext buildPlayerContext);
    }

    public sealed class BuildPlayerContext
    {
        internal readonly List<(string from, string to)> Added = new List<(string, string)>();
        internal BuildPlayerContext(BuildPlayerOptions options) { BuildPlayerOptions = options; }
        public BuildPlayerOptions BuildPlayerOptions { get; }
        public void AddAdditionalPathToStreamingAssets(string directoryOrFile, string pathInStreamingAssets = null)
        {
            if (!File.Exists(directoryOrFile) && !Directory.Exists(directoryOrFile)) throw new FileNotFoundException($"{directoryOrFile} is not there");
            Added.Add((directoryOrFile, pathInStreamingAssets ?? Path.GetFileName(directoryOrFile)));
        }
    }

    public class BuildFailedException : Exception
    {
        public BuildFailedException(string message) : base(message) { }
        public BuildFailedException(Exception innerException) : base("", innerException) { }
    }
}
