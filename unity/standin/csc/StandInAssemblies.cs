// Unity's assemblies as scripts of one version see them: what the stand-in declares, compared with unity/api, and the names of the rest.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Security.Cryptography;
using System.Text;
using Microsoft.CodeAnalysis;
using Microsoft.CodeAnalysis.CSharp;
using Microsoft.CodeAnalysis.Emit;
using Microsoft.CodeAnalysis.Text;

sealed class StandInAssemblies
{
    public static readonly CSharpCompilationOptions Options = new CSharpCompilationOptions(OutputKind.DynamicallyLinkedLibrary, allowUnsafe: true, deterministic: true);

    readonly UnityVersion version;
    readonly MetadataReference[] library;
    readonly string stamp;
    /// As they are written, in the order in which they refer to each other.
    readonly List<(AssemblyDefinition definition, CSharpCompilation compilation)> written = new List<(AssemblyDefinition, CSharpCompilation)>();

    /// `inOrder`: definitions of the stand-in, each after what it refers to.
    public StandInAssemblies(UnityVersion version, string[] library, IReadOnlyCollection<AssemblyDefinition> inOrder, Func<AssemblyDefinition, IEnumerable<string>> referencesOf, Func<AssemblyDefinition, IEnumerable<string>> symbolsOf)
    {
        this.version = version;
        this.library = library.Select(file => (MetadataReference)MetadataReference.CreateFromFile(file)).ToArray();
        var stamped = new StringBuilder(version.Name);
        foreach (var file in library) stamped.Append(file).Append(new FileInfo(file).Length);
        foreach (var definition in inOrder)
        {
            var symbols = symbolsOf(definition).OrderBy(symbol => symbol, StringComparer.Ordinal).ToList();
            stamped.Append(definition.Name).Append(string.Join(";", symbols));
            var parse = new CSharpParseOptions(LanguageVersion.CSharp9, DocumentationMode.None, SourceCodeKind.Regular, symbols);
            var trees = definition.Sources.AsParallel().AsOrdered().Select(file => Parse(file, parse)).ToList();
            foreach (var tree in trees) stamped.Append(tree.FilePath).Append(tree.GetText());
            var references = from name in referencesOf(definition)
                             join other in written on name equals other.definition.Name
                             select other.compilation.ToMetadataReference();
            written.Add((definition, CSharpCompilation.Create(definition.Name, trees, references.Concat(this.library), Options)));
        }
        stamp = Hash(stamped);
    }

    static SyntaxTree Parse(string file, CSharpParseOptions options)
    {
        using (var stream = File.OpenRead(file))
            return CSharpSyntaxTree.ParseText(SourceText.From(stream, Encoding.UTF8), options, Path.GetRelativePath(Directory.GetCurrentDirectory(), file));
    }

    static string Hash(StringBuilder text)
    {
        text.Append(BitConverter.ToString(File.ReadAllBytes(typeof(StandInAssemblies).Assembly.Location)));
        using (var sha = SHA256.Create()) return BitConverter.ToString(sha.ComputeHash(Encoding.UTF8.GetBytes(text.ToString())));
    }

    /// All that they declare, by list of unity/api.
    public IEnumerable<(string list, ISymbol symbol)> Declared() =>
        from one in written
        from symbol in Surface.Of(one.compilation.Assembly.GlobalNamespace)
        select (UnityVersion.ListOfAssembly(one.definition.Name), symbol);

    /// Writes what scripts are compiled against into a folder. False if something is not as in Unity.
    public bool Write(string api, string folder)
    {
        Directory.CreateDirectory(folder);
        var lists = written.Select(one => UnityVersion.ListOfAssembly(one.definition.Name)).Distinct().ToDictionary(name => name, name => Path.Combine(api, name + ".txt"));
        var stamped = stamp + Hash(new StringBuilder(string.Concat(lists.Values.Select(File.ReadAllText))));
        var stampFile = Path.Combine(folder, "stamp");
        if (File.Exists(stampFile) && File.ReadAllText(stampFile) == stamped) return true;
        File.Delete(stampFile);

        var count = 0;
        var faults = new List<string>();
        foreach (var one in lists)
        {
            var list = ApiList.Read(one.Value);
            // Types move from the editor to the engine, which an editor has beside it.
            var all = one.Key == "UnityEditor" ? ApiList.Read(one.Value, lists["UnityEngine"]) : list;
            var versions = version.VersionsOf(one.Key);
            var own = written.Where(other => UnityVersion.ListOfAssembly(other.definition.Name) == one.Key).ToList();
            foreach (var (definition, compilation) in own)
            {
                var conformity = new Conformity(all, versions);
                conformity.Check(compilation);
                count += conformity.Count;
                faults.AddRange(conformity.Faults);
                faults.AddRange(Emit(SeenSources.Of(compilation, conformity), folder));
            }
            var types = written.SelectMany(other => Surface.Of(other.compilation.Assembly.GlobalNamespace)).OfType<INamedTypeSymbol>();
            faults.AddRange(Emit(Names.Compile(list, one.Key, versions, types, library, Options), folder));
        }
        foreach (var fault in faults) Console.Error.WriteLine(fault);
        if (faults.Count > 0)
        {
            Console.Error.WriteLine($"{faults.Count} faults: the stand-in is not as Unity {version.Name} is.");
            return false;
        }
        Console.WriteLine($"    the stand-in: {count} types and members are as in Unity {version.Name}");
        File.WriteAllText(stampFile, stamped);
        return true;
    }

    static IEnumerable<string> Emit(CSharpCompilation compilation, string folder)
    {
        using (var assembly = new MemoryStream())
        {
            var faults = Emit(compilation, assembly);
            if (faults.Count == 0) Program.Replace(Path.Combine(folder, compilation.AssemblyName + ".dll"), assembly.ToArray());
            return faults;
        }
    }

    /// An assembly without what is in its methods, and without what is internal. Returns what is wrong with it.
    public static List<string> Emit(CSharpCompilation compilation, Stream assembly) =>
        compilation.Emit(assembly, options: new EmitOptions(metadataOnly: true, includePrivateMembers: false)).Diagnostics
            .Where(diagnostic => diagnostic.Severity == DiagnosticSeverity.Error).Select(diagnostic => diagnostic.ToString()).ToList();
}
