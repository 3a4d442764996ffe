// An assembly definition (.asmdef), read as Unity's manual describes it.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Text.Json;
using System.Text.RegularExpressions;

sealed class AssemblyDefinition
{
    public string File, Folder, Name;
    /// Whether it belongs to what stands in for Unity's own assemblies.
    public bool IsStandIn;
    public bool IsTest => OptionalUnityReferences.Contains("TestAssemblies");
    /// Whether it is one of Unity's own, as the stand-in has it.
    public bool PlaysUnity => IsStandIn && !IsTest;
    public List<string> References = new List<string>(), IncludePlatforms = new List<string>(), ExcludePlatforms = new List<string>();
    public List<string> DefineConstraints = new List<string>(), PrecompiledReferences = new List<string>(), OptionalUnityReferences = new List<string>();
    public List<(string name, string expression, string define)> VersionDefines = new List<(string, string, string)>();
    public bool AllowUnsafeCode, NoEngineReferences, OverrideReferences;
    public List<string> Sources = new List<string>();

    public static AssemblyDefinition Read(string file, bool isStandIn)
    {
        JsonDocument json;
        try { json = JsonDocument.Parse(System.IO.File.ReadAllText(file)); }
        catch (JsonException error) { throw new BuildException($"{file} is no JSON: {error.Message}"); }
        var root = json.RootElement;
        var definition = new AssemblyDefinition { File = file, Folder = Path.GetDirectoryName(file), IsStandIn = isStandIn };
        List<string> Strings(string key) => root.TryGetProperty(key, out var list) ? list.EnumerateArray().Select(item => item.GetString()).ToList() : new List<string>();
        bool Flag(string key) => root.TryGetProperty(key, out var flag) && flag.GetBoolean();
        if (!root.TryGetProperty("name", out var name)) throw new BuildException($"{file} has no \"name\".");
        definition.Name = name.GetString();
        // The Test Framework is a package of scripts, compiled as such; there are no lists of it.
        definition.IsStandIn &= definition.Name != "UnityEngine.TestRunner";
        definition.References = Strings("references");
        definition.IncludePlatforms = Strings("includePlatforms");
        definition.ExcludePlatforms = Strings("excludePlatforms");
        if (definition.IncludePlatforms.Count > 0 && definition.ExcludePlatforms.Count > 0)
            throw new BuildException($"{file} both includes and excludes platforms; Unity takes one of the two.");
        definition.DefineConstraints = Strings("defineConstraints");
        definition.PrecompiledReferences = Strings("precompiledReferences");
        definition.OptionalUnityReferences = Strings("optionalUnityReferences");
        definition.AllowUnsafeCode = Flag("allowUnsafeCode");
        definition.NoEngineReferences = Flag("noEngineReferences");
        definition.OverrideReferences = Flag("overrideReferences");
        if (root.TryGetProperty("versionDefines", out var defines))
            foreach (var define in defines.EnumerateArray())
                definition.VersionDefines.Add((define.GetProperty("name").GetString(), define.GetProperty("expression").GetString(), define.GetProperty("define").GetString()));
        return definition;
    }

    /// What Unity defines of it, given the versions of the packages that there are.
    public IEnumerable<string> Defined(IReadOnlyDictionary<string, Version> packages) =>
        from define in VersionDefines
        where packages.TryGetValue(define.name, out var version) && Matches(define.expression, version)
        select define.define;

    /// Whether it is compiled with these symbols.
    public bool IsWanted(ISet<string> symbols, bool editor) => IsOfPlatform(editor) && !Unmet(symbols).Any();

    public bool IsOfPlatform(bool editor)
    {
        var platform = editor ? "Editor" : "LinuxStandalone64";
        return (IncludePlatforms.Count == 0 || IncludePlatforms.Contains(platform)) && !ExcludePlatforms.Contains(platform);
    }

    /// Constraints that these symbols do not meet; one is a symbol, `!symbol`, or several with `||`.
    public IEnumerable<string> Unmet(ISet<string> symbols) =>
        (IsTest ? DefineConstraints.Prepend("UNITY_INCLUDE_TESTS") : DefineConstraints).Where(constraint => !constraint.Split(new[] { "||" }, StringSplitOptions.None)
            .Select(part => part.Trim()).Any(part => part.StartsWith("!") ? !symbols.Contains(part.Substring(1).Trim()) : symbols.Contains(part)));

    /// `1.2` is at least that, `[1.2]` just that, `[1.0,2.0)` a range with or without its ends, and none is any version.
    public static bool Matches(string expression, Version version)
    {
        expression = expression.Replace(" ", "");
        if (expression == "") return true;
        if (Regex.IsMatch(expression, @"^[0-9]")) return version >= Parse(expression);
        var exact = Regex.Match(expression, @"^\[([^,\]]+)\]$");
        if (exact.Success) return version == Parse(exact.Groups[1].Value);
        var range = Regex.Match(expression, @"^([\[(])([^,]*),([^,]*)([\])])$");
        if (!range.Success) throw new BuildException($"Unity takes no such expression for a version: {expression}");
        string low = range.Groups[2].Value, high = range.Groups[3].Value;
        if (low != "" && (range.Groups[1].Value == "[" ? version < Parse(low) : version <= Parse(low))) return false;
        return high == "" || (range.Groups[4].Value == "]" ? version <= Parse(high) : version < Parse(high));
    }

    public static Version Parse(string text)
    {
        // What follows a hyphen, and the letters of Unity's own versions, say how finished it is.
        var numbers = Regex.Match(text, @"^[0-9]+(\.[0-9]+){0,2}").Value.Split('.').Select(int.Parse).Concat(new[] { 0, 0 }).ToArray();
        return new Version(numbers[0], numbers[1], numbers[2]);
    }
}
