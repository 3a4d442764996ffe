// Compiles folders with assembly definitions as Unity does: each assembly sees what its definition names, no more.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Text.RegularExpressions;

sealed class UnityBuild
{
    readonly string output, nunit, api;
    /// The class library's files.
    readonly string[] library;
    readonly string[] folders;
    readonly UnityVersion version;
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

    /// `output`: a folder of this version's own, in one of what is compiled with it; `api`: the lists of Unity's API.
    public UnityBuild(UnityVersion version, string output, ClassLibraries libraries, string nunit, string api, string[] folders)
    {
        this.version = version;
        this.output = Path.GetFullPath(output);
        library = libraries.Of(version);
        this.nunit = nunit;
        this.api = api;
        this.folders = folders;
        foreach (var folder in folders)
            if (Directory.Exists(folder)) Find(folder, Path.GetFileName(folder.TrimEnd('/')) == "standin");
    }

    /// Where what scripts are compiled against lies, the same for all that is compiled: Unity's assemblies without what is in
    /// their methods.
    string SeenFolder => Path.GetFullPath(Path.Combine(output, "../../seen", version.Name));

    public bool Run()
    {
        if (!StandIn().Write(api, SeenFolder)) return false;
        var all = true;
        foreach (var definition in known.Values.OrderBy(definition => definition.Name, StringComparer.Ordinal).ToList())
            all &= Build(definition, new List<string>()) || !failed.Contains(definition.Name);
        return all;
    }

    /// Unity's assemblies in this version, as the stand-in has them.
    public StandInAssemblies StandIn()
    {
        var inOrder = new List<AssemblyDefinition>();
        void Add(AssemblyDefinition definition)
        {
            if (!definition.PlaysUnity || inOrder.Contains(definition) || !IsWanted(definition)) return;
            foreach (var name in ReferencesOf(definition))
                if (known.TryGetValue(name, out var other)) Add(other);
            inOrder.Add(definition);
        }
        foreach (var definition in known.Values.OrderBy(definition => definition.Name, StringComparer.Ordinal)) Add(definition);
        return new StandInAssemblies(version, library, inOrder, ReferencesOf, SymbolsOf);
    }

    /// The namespaces that scripts import, but for those of the stand-in's tests.
    public IEnumerable<string> Used() =>
        from definition in known.Values
        where !definition.IsStandIn
        from file in definition.Sources
        from Match match in Regex.Matches(File.ReadAllText(file), @"^\s*using ([\w.]+);", RegexOptions.Multiline)
        select match.Groups[1].Value;

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
        var own = new HashSet<string>(version.Symbols);
        own.UnionWith(definition.Defined(version.Packages));
        return own;
    }

    bool IsWanted(AssemblyDefinition definition) => definition.IsWanted(SymbolsOf(definition), version.IsEditor);

    bool Build(AssemblyDefinition definition, List<string> above)
    {
        if (done.TryGetValue(definition.Name, out var built)) return built;
        if (above.Contains(definition.Name)) throw new BuildException($"Assemblies refer to each other: {string.Join(" -> ", above)} -> {definition.Name}");
        if (!IsWanted(definition))
        {
            // Constraints are about packages and tests, which are there: whatever they leave out nobody would ever miss.
            if (version.HasAll && definition.IsOfPlatform(version.IsEditor))
                throw new BuildException($"{definition.File} leaves {definition.Name} out of Unity {version.Name}: there is no {string.Join(", no ", definition.Unmet(SymbolsOf(definition)))}.");
            Console.WriteLine($"    {definition.Name}: left out, by its platforms or constraints");
            return done[definition.Name] = false;
        }
        if (definition.Sources.Count == 0)
        {
            Console.WriteLine($"    {definition.Name}: has no scripts");
            return done[definition.Name] = false;
        }
        if (definition.IsStandIn && version.Name != UnityVersion.Run) return done[definition.Name] = definition.PlaysUnity;
        above = above.Append(definition.Name).ToList();
        var references = new List<AssemblyDefinition>();
        foreach (var name in ReferencesOf(definition))
        {
            if (!known.TryGetValue(name, out var other))
            {
                // Unity leaves a missing reference out; what uses it then fails to compile.
                if (!definition.IsStandIn) continue;
                Console.WriteLine($"    {definition.Name}: left out, as there is no {name}");
                return done[definition.Name] = false;
            }
            if (Build(other, above)) references.Add(other);
            else if (failed.Contains(name)) return Failed(definition, $"{name} failed");
        }

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
        options.AddRange(references.SelectMany(reference => FilesOf(reference, definition)).Distinct().OrderBy(file => file, StringComparer.Ordinal).Select(file => "-r:" + file));
        if (definition.PrecompiledReferences.Contains("nunit.framework.dll") || definition.IsTest)
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

    /// The assemblies that one refers to by their names, and those of the engine, which all see.
    IEnumerable<string> ReferencesOf(AssemblyDefinition definition)
    {
        foreach (var reference in definition.References)
        {
            var name = reference;
            if (!name.StartsWith("GUID:") || nameOfGuid.TryGetValue(name.Substring(5), out name)) yield return name;
        }
        if (definition.NoEngineReferences || Engine.Any(engine => engine.assembly == definition.Name)) yield break;
        foreach (var (_, assembly, editorOnly) in Engine)
            if (!editorOnly || version.IsEditor) yield return assembly;
    }

    /// What is referred to is the stand-in itself for what belongs to it, and for all others what Unity would let them see.
    IEnumerable<string> FilesOf(AssemblyDefinition reference, AssemblyDefinition user)
    {
        if (!reference.PlaysUnity || user.IsStandIn) return new[] { Path.Combine(output, reference.Name + ".dll") };
        return new[] { reference.Name, Names.AssemblyOf(UnityVersion.ListOfAssembly(reference.Name)) }.Select(name => Path.Combine(SeenFolder, name + ".dll"));
    }

    bool Failed(AssemblyDefinition definition, string why)
    {
        Console.WriteLine($"    {definition.Name}: FAILED, {why}");
        failed.Add(definition.Name);
        return done[definition.Name] = false;
    }
}
