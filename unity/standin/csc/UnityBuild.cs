// Compiles folders with assembly definitions as Unity does: each assembly sees what its definition names, no more.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Text.RegularExpressions;

sealed class UnityBuild
{
    readonly string output, nunit;
    /// The class library: netstandard 2.1, or .NET Framework's of Mono.
    readonly string[] library;
    readonly string[] folders;
    readonly bool editor;
    readonly HashSet<string> symbols;
    readonly Dictionary<string, Version> packages;
    readonly Dictionary<string, AssemblyDefinition> known = new Dictionary<string, AssemblyDefinition>();
    readonly Dictionary<string, string> nameOfGuid = new Dictionary<string, string>();
    readonly HashSet<string> failed = new HashSet<string>();
    /// Compiled assemblies by name: true, failed or left out: false.
    readonly Dictionary<string, bool> done = new Dictionary<string, bool>();

    /// Folders of the stand-in that need no assembly definition, with the assembly that Unity has their types in.
    static readonly (string folder, string assembly, bool editorOnly)[] Engine =
    {
        ("UnityEngine", "UnityEngine", false),
        ("UnityEngine.UIElements", "UnityEngine.UIElementsModule", false),
        ("UnityEditor", "UnityEditor", true),
    };

    public UnityBuild(string version, string output, string library, string nunit, string[] folders)
    {
        this.output = Path.GetFullPath(output);
        this.nunit = nunit;
        this.folders = folders;
        editor = !version.EndsWith("-player");
        // Whether there is the old input manager is up to the project: both are compiled.
        var hasOldInput = version != "6000.0-player";
        // What Project Settings > Player > Api Compatibility Level says; editors' own assemblies are compiled so in any case.
        var isFramework = version.EndsWith("-framework");
        this.library = (isFramework ? new[] { "mscorlib", "System", "System.Core", "System.Numerics" } : new[] { "netstandard" }).Select(name => Path.Combine(library, name + ".dll")).ToArray();
        version = version.Replace("-player", "").Replace("-framework", "");
        symbols = new HashSet<string> { "UNITY_64", "UNITY_STANDALONE", "UNITY_STANDALONE_LINUX", "CSHARP_7_3_OR_NEWER", "ENABLE_VR", "ENABLE_PROFILER", "ENABLE_MONO", "UNITY_ASSERTIONS", "STAND_IN" };
        symbols.UnionWith(isFramework ? new[] { "NET_4_6", "NET_UNITY_4_8" } : new[] { "NET_STANDARD_2_1", "NET_STANDARD", "NETSTANDARD", "NETSTANDARD2_1" });
        if (editor) symbols.UnionWith(new[] { "UNITY_EDITOR", "UNITY_EDITOR_64", "UNITY_EDITOR_LINUX", "ENABLE_UNITY_COLLECTIONS_CHECKS", "DEVELOPMENT_BUILD", "DEBUG", "TRACE" });
        if (editor && !isFramework) symbols.Add("UNITY_INCLUDE_TESTS");
        if (hasOldInput) symbols.Add("ENABLE_LEGACY_INPUT_MANAGER");
        foreach (var older in new[] { "2019_4", "2020_1", "2020_2", "2020_3", "2021_1", "2021_2", "2021_3", "2022_1", "2022_2", "2022_3" }) symbols.Add($"UNITY_{older}_OR_NEWER");
        string pipelines;
        switch (version)
        {
            case "6000.0":
            case "6000.3":
                symbols.UnionWith(new[] { "UNITY_6000", "UNITY_" + version.Replace('.', '_'), "UNITY_2023_1_OR_NEWER", "UNITY_2023_2_OR_NEWER", "UNITY_2023_3_OR_NEWER", "UNITY_6000_0_OR_NEWER" });
                if (version == "6000.3") symbols.UnionWith(new[] { "UNITY_6000_1_OR_NEWER", "UNITY_6000_2_OR_NEWER", "UNITY_6000_3_OR_NEWER" });
                pipelines = version == "6000.0" ? "17.0.4" : "17.3.0";
                break;
            case "2022.3":
                symbols.UnionWith(new[] { "UNITY_2022", "UNITY_2022_3" });
                pipelines = "14.0.12";
                break;
            default: throw new BuildException($"Unity {version} is not one that the stand-in stands for: 6000.0, 6000.3 or 2022.3.");
        }
        packages = new Dictionary<string, Version>
        {
            ["Unity"] = AssemblyDefinition.Parse(version),
            ["com.unity.render-pipelines.core"] = AssemblyDefinition.Parse(pipelines),
            ["com.unity.render-pipelines.universal"] = AssemblyDefinition.Parse(pipelines),
            ["com.unity.render-pipelines.high-definition"] = AssemblyDefinition.Parse(pipelines),
            ["com.unity.test-framework"] = AssemblyDefinition.Parse("1.4.5"),
            ["com.unity.modules.vr"] = AssemblyDefinition.Parse("1.0.0"),
            ["com.unity.modules.xr"] = AssemblyDefinition.Parse("1.0.0"),
        };
        // Packages that are not there for this run, for what a project without them compiles.
        foreach (var missing in (Environment.GetEnvironmentVariable("UNITY_WITHOUT") ?? "").Split(' ')) packages.Remove(missing);
    }

    public bool Run()
    {
        foreach (var folder in folders)
            if (Directory.Exists(folder)) Find(folder, Path.GetFileName(folder.TrimEnd('/')) == "standin");
        var all = true;
        foreach (var definition in known.Values.OrderBy(definition => definition.Name, StringComparer.Ordinal).ToList())
            all &= Build(definition, new List<string>()) || !failed.Contains(definition.Name);
        return all;
    }

    void Find(string folder, bool isStandIn)
    {
        // Unity sees nothing below that is hidden or ends in a tilde. Samples do, but are named by themselves: projects copy them.
        bool IsSeen(string file) => !Path.GetRelativePath(folder, file).Split('/').Any(part => part.EndsWith("~") || part.StartsWith("."));
        var definitions = Directory.EnumerateFiles(folder, "*.asmdef", SearchOption.AllDirectories).Where(IsSeen)
            .OrderBy(file => file, StringComparer.Ordinal).Select(file => AssemblyDefinition.Read(file, isStandIn)).ToList();
        foreach (var same in definitions.GroupBy(definition => definition.Folder).Where(group => group.Count() > 1))
            throw new BuildException($"{same.Key} has {same.Count()} assembly definitions; Unity takes one a folder.");
        if (isStandIn)
            foreach (var (name, assembly, editorOnly) in Engine)
            {
                var path = Path.Combine(folder, name);
                if (!Directory.Exists(path) || definitions.Any(definition => definition.Folder == path)) continue;
                var definition = new AssemblyDefinition { File = path, Folder = path, Name = assembly, IsStandIn = true, AllowUnsafeCode = true };
                if (editorOnly) definition.IncludePlatforms.Add("Editor");
                definition.References.AddRange(Engine.TakeWhile(other => other.folder != name).Select(other => other.assembly));
                definitions.Add(definition);
            }
        // A script belongs to the nearest definition above it.
        foreach (var script in Directory.EnumerateFiles(folder, "*.cs", SearchOption.AllDirectories).Where(IsSeen).OrderBy(file => file, StringComparer.Ordinal))
        {
            var at = Path.GetDirectoryName(script);
            AssemblyDefinition owner = null;
            while (owner == null && at != null && at.Length >= folder.TrimEnd('/').Length)
            {
                owner = definitions.Find(definition => definition.Folder == at);
                at = Path.GetDirectoryName(at);
            }
            if (owner != null) owner.Sources.Add(script);
            else if (!isStandIn) throw new BuildException($"{script} belongs to no assembly definition; in a package Unity does not compile it.");
        }
        foreach (var definition in definitions)
        {
            if (known.ContainsKey(definition.Name)) throw new BuildException($"Two assembly definitions are named {definition.Name}: {definition.File} and {known[definition.Name].File}.");
            known[definition.Name] = definition;
            var meta = definition.File + ".meta";
            if (!File.Exists(meta)) continue;
            var guid = Regex.Match(File.ReadAllText(meta), @"^guid: *([0-9a-f]{32})", RegexOptions.Multiline);
            if (guid.Success) nameOfGuid[guid.Groups[1].Value] = definition.Name;
        }
    }

    HashSet<string> SymbolsOf(AssemblyDefinition definition)
    {
        var own = new HashSet<string>(symbols);
        own.UnionWith(definition.Defined(packages));
        return own;
    }

    bool IsWanted(AssemblyDefinition definition) => definition.IsWanted(SymbolsOf(definition), editor);

    bool Build(AssemblyDefinition definition, List<string> above)
    {
        if (done.TryGetValue(definition.Name, out var built)) return built;
        if (above.Contains(definition.Name)) throw new BuildException($"Assemblies refer to each other: {string.Join(" -> ", above)} -> {definition.Name}");
        if (!IsWanted(definition))
        {
            Console.WriteLine($"    {definition.Name}: left out, by its platforms or constraints");
            return done[definition.Name] = false;
        }
        if (definition.Sources.Count == 0)
        {
            Console.WriteLine($"    {definition.Name}: has no scripts");
            return done[definition.Name] = false;
        }
        above = above.Append(definition.Name).ToList();
        var references = new HashSet<string>();
        string missing = null;
        bool Refer(string name)
        {
            if (!known.TryGetValue(name, out var other))
            {
                // Unity leaves a missing reference out; what uses it then fails to compile.
                missing = name;
                return false;
            }
            if (Build(other, above)) references.Add(name);
            return references.Contains(name);
        }
        foreach (var reference in definition.References)
        {
            var name = reference;
            if (name.StartsWith("GUID:") && !nameOfGuid.TryGetValue(name.Substring(5), out name)) continue;
            if (!Refer(name) && known.TryGetValue(name, out var other) && failed.Contains(name)) return Failed(definition, $"{name} failed");
        }
        if (missing != null && definition.IsStandIn)
        {
            Console.WriteLine($"    {definition.Name}: left out, as there is no {missing}");
            return done[definition.Name] = false;
        }
        if (!definition.NoEngineReferences && !Engine.Any(engine => engine.assembly == definition.Name))
            foreach (var (_, assembly, editorOnly) in Engine)
                if ((!editorOnly || editor) && known.TryGetValue(assembly, out var engine) && engine.Sources.Count > 0 && !Refer(assembly)) return Failed(definition, $"{assembly} failed");

        Directory.CreateDirectory(output);
        var options = new List<string>
        {
            // As Unity does: fields that only the serialiser sets are no fault.
            "-nologo", "-nostdlib+", "-langversion:9", "-warnaserror+", "-nullable-", "-debug:portable", "-optimize+", "-nowarn:0649,0169,1701,1702",
            "-target:" + (definition.Name.EndsWith(".Program") ? "exe" : "library"), $"-out:{Path.Combine(output, definition.Name + ".dll")}",
            "-define:" + string.Join(";", SymbolsOf(definition).OrderBy(symbol => symbol, StringComparer.Ordinal)),
        };
        options.AddRange(library.Select(file => "-r:" + file));
        if (definition.AllowUnsafeCode) options.Add("-unsafe+");
        foreach (var reference in references.OrderBy(name => name, StringComparer.Ordinal)) options.Add("-r:" + Path.Combine(output, reference + ".dll"));
        if (definition.PrecompiledReferences.Contains("nunit.framework.dll") || definition.OptionalUnityReferences.Contains("TestAssemblies"))
        {
            options.Add("-r:" + nunit);
            var beside = Path.Combine(output, Path.GetFileName(nunit));
            if (!File.Exists(beside)) Program.Replace(beside, File.ReadAllBytes(nunit));
        }
        foreach (var other in definition.PrecompiledReferences.Where(other => other != "nunit.framework.dll"))
            throw new BuildException($"{definition.File} refers to {other}, which the stand-in does not have.");
        options.AddRange(definition.Sources);
        // Tests' own objects are saved nowhere.
        if (!Program.Compile(options.ToArray(), areScripts: !definition.IsStandIn && !definition.Name.Contains(".Tests"))) return Failed(definition, "see above");
        Console.WriteLine($"    {definition.Name}: compiled");
        return done[definition.Name] = true;
    }

    bool Failed(AssemblyDefinition definition, string why)
    {
        Console.WriteLine($"    {definition.Name}: FAILED, {why}");
        failed.Add(definition.Name);
        return done[definition.Name] = false;
    }
}
