using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using System.Text;
using Lumivox.Native;
using UnityEngine;
using UnityEngine.Rendering;
using PackageInfo = UnityEditor.PackageManager.PackageInfo;

namespace Lumivox.Editor
{
    /// <summary>The text that can be pasted into an issue. It names no person and no path but those of the project.</summary>
    internal static class SelfCheckReport
    {
        public static string Of(IReadOnlyList<Check> checks)
        {
            var text = new StringBuilder();
            text.Append("Lumivox self-check: ").AppendLine(Verdict(checks));
            text.AppendLine();
            foreach (var (name, value) in Facts()) text.Append($"{name}:".PadRight(16)).AppendLine(value);
            text.AppendLine();
            foreach (var check in checks) Add(text, check);
            text.AppendLine();
            text.Append("Pictures and this report: ").AppendLine(SelfCheckRun.ProjectFolder);
            return WithoutPaths(text.ToString());
        }

        /// What others say may name the folders of the project and of the person.
        static string WithoutPaths(string text)
        {
            foreach (var (folder, name) in new[] { (StoredScans.ProjectFile("."), "PROJECT"), (Environment.GetFolderPath(Environment.SpecialFolder.UserProfile), "~") })
            {
                var path = folder.TrimEnd('/', '\\');
                if (path.Length > 1) text = text.Replace(path, name).Replace(path.Replace('\\', '/'), name);
            }
            return text;
        }

        /// <summary>In one line.</summary>
        public static string Verdict(IReadOnlyList<Check> checks)
        {
            int passed = checks.Count(check => check.Now == Check.State.Passed), failed = checks.Count(check => check.Now == Check.State.Failed);
            if (passed == checks.Count) return $"OK, {passed} checks";
            var left = checks.Count - passed - failed;
            return $"{(failed > 0 ? $"{failed} of {checks.Count} FAILED" : $"{passed} of {checks.Count} passed")}{(left > 0 ? $", {left} not run" : "")}";
        }

        /// <summary>What came of a check, in a word.</summary>
        public static string Word(Check.State state)
        {
            switch (state)
            {
                case Check.State.Passed: return "OK";
                case Check.State.Failed: return "FAILED";
                case Check.State.Running: return "running";
                default: return "not run";
            }
        }

        static void Add(StringBuilder text, Check check)
        {
            text.Append(Word(check.Now).PadRight(9)).Append(check.Name);
            text.AppendLine(check.Seconds > 0 ? $" ({check.Seconds.ToString("0.00", CultureInfo.InvariantCulture)} s)" : "");
            foreach (var fault in check.Faults)
            {
                text.Append("           ").AppendLine(fault.What);
                if (fault.Remedy.Length > 0) text.Append("           > ").AppendLine(fault.Remedy);
            }
            foreach (var note in check.Notes) text.Append("           ").AppendLine(note);
        }

        static IEnumerable<(string, string)> Facts()
        {
            var package = PackageInfo.FindForAssembly(typeof(SelfCheckReport).Assembly);
            var pipeline = GraphicsSettings.currentRenderPipeline;
            var pipelinePackage = pipeline != null ? PackageInfo.FindForAssembly(pipeline.GetType().Assembly) : null;
            yield return ("Unity", $"{Application.unityVersion}, {Application.platform}{(Application.isBatchMode ? ", batch mode" : "")}{(Application.isPlaying ? ", play mode" : "")}");
            yield return ("Package", package != null ? $"{package.name} {package.version}" : "in Assets");
            yield return ("Native library", Border.Fault == null ? $"{LumivoxRenderer.Version}, border {Abi.Version}" : "cannot be used");
            yield return ("Pipeline", $"{PipelineHost.Current?.Name ?? pipeline.GetType().FullName}{(pipelinePackage != null ? $", {pipelinePackage.name} {pipelinePackage.version}" : "")}");
            yield return ("Colour space", QualitySettings.activeColorSpace.ToString());
            yield return ("System", $"{SystemInfo.operatingSystem}; {SystemInfo.processorType}, {SystemInfo.processorCount} cores, {SystemInfo.systemMemorySize} MB");
            yield return ("Graphics", $"{SystemInfo.graphicsDeviceType}; {SystemInfo.graphicsDeviceName} ({SystemInfo.graphicsDeviceVendor}), {SystemInfo.graphicsMemorySize} MB");
            yield return ("Driver", SystemInfo.graphicsDeviceVersion);
            yield return ("Run at", DateTime.UtcNow.ToString("yyyy-MM-dd HH:mm", CultureInfo.InvariantCulture) + " UTC");
        }
    }
}
