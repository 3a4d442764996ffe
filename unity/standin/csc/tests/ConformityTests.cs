// Whether conformity sees what differs from a list, and scripts what a version has: on a made-up API of two versions.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using Microsoft.CodeAnalysis;
using Microsoft.CodeAnalysis.CSharp;

static class ConformityTests
{
    const string Api = @"
version 1
version 2
namespace Space
namespace Other
++ E:Space.Thing.changed System.Action
+- F:Space.Kind.Gone const | 0
++ F:Space.Kind.Left const | 1
++ F:Space.Thing.Most static int const | 3
++ F:Space.Thing.zero Space.Thing readonly
++ M:Space.Kind.#ctor void
+- M:Space.Old.#ctor void
++ M:Space.Thing.#ctor(System.Int32) void | size = 7
+e M:Space.Thing.Forbidden void
++ M:Space.Thing.Free static void
++ M:Space.Mark.#ctor void
++ M:Space.Thing.Find``1 T | where T: Space.Base
+- M:Space.Thing.Lost(Space.Old) void | old
++ M:Space.Thing.Move(System.Single@) bool virtual | ref by
++ M:Space.Thing.Own protected void
+w M:Space.Thing.Warned void
++ M:Space.Base.#ctor protected void
++ P:Space.Thing.size int get set
++ T:Other.Attached class
++ T:Other.Clash struct
++ T:Space.Base class abstract
++ T:Space.Clash class
++ T:Space.Kind enum | flags
++ T:Space.Mark class : System.Attribute | usage 4 multiple
+- T:Space.Old class
++ T:Space.Thing class : Space.Base
";

    const string Source = @"
using System;
[assembly: System.Runtime.CompilerServices.InternalsVisibleTo(""Script"")]
namespace Space
{
    public abstract class Base { public override string ToString() => """"; }
    public class Old { }
    [Flags] public enum Kind { Gone, Left }
    [AttributeUsage(AttributeTargets.Class, AllowMultiple = true)] public class Mark : Attribute { }
    public class Thing : Base
    {
        public const int Most = 3;
        public readonly Thing zero;
        public event Action changed;
        public int size { get; set; }
        internal int steered;
        public Thing(int size = 7) { }
        public static void Free() { }
        public virtual bool Move(ref float by) => true;
        public void Lost(Old old) { }
        public T Find<T>() where T : Base => null;
        public void Warned() { }
        public void Forbidden() => Warned();
        protected void Own() { }
    }
}
namespace StandIn { public static class Steering { public static int Of(Space.Thing thing) => thing.steered; } }
public static class StandInMore { }
";

    static string netstandard;

    /// Runs all tests and says how many passed; false if one did not.
    public static bool Run(string netstandardFolder)
    {
        netstandard = Path.Combine(netstandardFolder, "netstandard.dll");
        var tests = new Action[] { WhatIsAsInUnityHasNoFault, WhatDiffersIsAFault, AnOlderListIsComparedInWhatItTells, WhatAVersionLacksIsNotSeen, WhatIsObsoleteIsSaid, ANameOfTwoThingsIsAmbiguous, WhatTestsSteerWithIsNotSeen, EnumeratorsKeepTheirValues, AListIsReadAsItIsWritten };
        foreach (var test in tests) test();
        Console.WriteLine($"    {tests.Length} tests of conformity passed");
        return true;
    }

    static void WhatIsAsInUnityHasNoFault()
    {
        foreach (var version in new[] { "1", "2" }) Same(Faults(Source, version), "", "faults of what is right");
    }

    static void WhatDiffersIsAFault()
    {
        var changes = new (string from, string to, string id)[]
        {
            ("public int size { get; set; }", "public int size { get; }", "P:Space.Thing.size"),
            ("public int size { get; set; }", "public int size { get; protected set; }", ""),
            ("public int size { get; set; }", "public float size { get; set; }", "P:Space.Thing.size"),
            ("public int size { get; set; }", "public static int size { get; set; }", "P:Space.Thing.size"),
            ("public int size { get; set; }", "public int size;", "F:Space.Thing.size"),
            ("public const int Most = 3;", "public static readonly int Most = 3;", "F:Space.Thing.Most"),
            ("public readonly Thing zero;", "public Thing zero;", "F:Space.Thing.zero"),
            ("public event Action changed;", "public event Action<int> changed;", "E:Space.Thing.changed"),
            ("public Thing(int size = 7) { }", "public Thing(int size = 7) { } public Thing() { }", "M:Space.Thing.#ctor"),
            ("public Thing(int size = 7) { }", "", "M:Space.Thing.#ctor"),
            ("public Thing(int size = 7) { }", "public Thing(int size) { }", "M:Space.Thing.#ctor(System.Int32)"),
            ("public Thing(int size = 7) { }", "public Thing(int size = 8) { }", "M:Space.Thing.#ctor(System.Int32)"),
            ("public Thing(int size = 7) { }", "public Thing(int length = 7) { }", "M:Space.Thing.#ctor(System.Int32)"),
            ("public virtual bool Move(ref float by) => true;", "public virtual bool Move(in float by) => true;", "M:Space.Thing.Move(System.Single@)"),
            ("public const int Most = 3;", "public const int Most = 4;", "F:Space.Thing.Most"),
            ("public enum Kind { Gone, Left }", "public enum Kind { Left, Gone }", "F:Space.Kind.Left"),
            ("[Flags] public enum", "public enum", "T:Space.Kind"),
            ("class Mark", "sealed class Mark", "T:Space.Mark"),
            ("AllowMultiple = true", "AllowMultiple = false", "T:Space.Mark"),
            ("AttributeTargets.Class,", "AttributeTargets.All,", "T:Space.Mark"),
            ("where T : Base => null", "=> default", "M:Space.Thing.Find``1"),
            ("where T : Base => null", "where T : Base, new() => null", "M:Space.Thing.Find``1"),
            ("public static void Free() { }", "public void Free() { }", "M:Space.Thing.Free"),
            ("public static void Free() { }", "public static void Free(int of) { }", "M:Space.Thing.Free(System.Int32)"),
            ("public static void Free() { }", "public static int Free() => 0;", "M:Space.Thing.Free"),
            ("public virtual bool Move(ref float by)", "public bool Move(ref float by)", "M:Space.Thing.Move(System.Single@)"),
            ("public virtual bool Move(ref float by)", "public virtual bool Move(float by)", "M:Space.Thing.Move(System.Single)"),
            ("protected void Own() { }", "public void Own() { }", "M:Space.Thing.Own"),
            ("class Thing : Base", "sealed class Thing : Base", "T:Space.Thing"),
            ("class Thing : Base", "class Thing", "T:Space.Thing"),
            ("public abstract class Base", "public class Base", "T:Space.Base"),
            ("public enum Kind { Gone, Left }", "public enum Kind { Gone, Left, Right }", "F:Space.Kind.Right"),
            ("public class Old { }", "public class Old { } public class New { }", "T:Space.New"),
        };
        foreach (var (from, to, id) in changes)
        {
            if (!Source.Contains(from)) throw new BuildException($"the source has no '{from}'");
            var faults = Check(Source.Replace(from, to), "1").conformity.Faults;
            if (id == "" ? faults.Count > 0 : !faults.Any(fault => fault.Contains($": {id} (1): "))) throw new BuildException($"'{to}': a fault of '{id}' was to be seen, not '{string.Join("; ", faults)}'");
        }
    }

    /// One without parameters' names, values and the like.
    static void AnOlderListIsComparedInWhatItTells()
    {
        var older = string.Join("\n", Api.Split('\n').Select(line => line.Split(" | ")[0]));
        var source = Source.Replace("[Flags] ", "").Replace("Lost(Old old)", "Lost(Old it)");
        Same(string.Join("\n", Check(source, "1", older).conformity.Faults), "", "what an older list does not tell");
        if (Check(source.Replace("static void Free", "void Free"), "1", older).conformity.Faults.Count != 1) throw new BuildException("what an older list tells is not compared");
    }

    static void WhatAVersionLacksIsNotSeen()
    {
        const string script = "class Script { void M(Space.Thing thing) { thing.Lost(null); } }";
        Same(Errors(script, "1"), "", "what the first version has");
        Same(Errors(script, "2"), "CS1061", "what the second lacks");
        Same(Errors("class Script : Space.Old { }", "2"), "CS0122", "a type that the second lacks");
    }

    static void WhatIsObsoleteIsSaid()
    {
        const string warned = "class Script { void M(Space.Thing thing) { thing.Warned(); } }", forbidden = "class Script { void M(Space.Thing thing) { thing.Forbidden(); } }";
        Same(Errors(warned, "1") + Errors(forbidden, "1"), "", "what is not obsolete yet");
        Same(Errors(warned, "2"), "CS0618", "a warning");
        Same(Errors(forbidden, "2"), "CS0619", "an error");
    }

    static void ANameOfTwoThingsIsAmbiguous()
    {
        Same(Errors("using Space; using Other; class Script { Clash clash; }", "1"), "CS0104", "a name of two types that the stand-in lacks");
        Same(Errors("using Other; class Script { Clash? clash; Attached attached; }", "1"), "", "a name of one");
    }

    static void WhatTestsSteerWithIsNotSeen()
    {
        Same(Errors("class Script { int M(Space.Thing thing) => thing.steered; }", "1"), "CS1061", "a member");
        Same(Errors("class Script { int M(Space.Thing thing) => StandIn.Steering.Of(thing); }", "1"), "CS0122", "a class of the namespace");
        Same(Errors("class Script { System.Type M() => typeof(StandInMore); }", "1"), "CS0122", "a class of the name");
    }

    static void EnumeratorsKeepTheirValues()
    {
        Same(Errors("class Script { const int kind = 1 / (int)Space.Kind.Left; }", "2"), "", "the value 1, not 0");
        Same(Errors("class Script { const int kind = (int)Space.Kind.Gone; }", "2"), "CS0117", "what is gone");
    }

    static void AListIsReadAsItIsWritten()
    {
        var file = Path.GetTempFileName();
        try
        {
            List().Write(file, "A heading\nof two lines");
            Same(string.Join("\n", File.ReadLines(file).Where(line => line[0] != '#').OrderBy(line => line, StringComparer.Ordinal)),
                string.Join("\n", Api.Trim().Split('\n').Select(line => line.Trim()).OrderBy(line => line, StringComparer.Ordinal)), "the list");
        }
        finally { File.Delete(file); }
    }

    static ApiList List(string api = Api)
    {
        var file = Path.GetTempFileName();
        try
        {
            File.WriteAllText(file, api);
            return ApiList.Read(file);
        }
        finally { File.Delete(file); }
    }

    static CSharpCompilation Compile(string name, string source, IEnumerable<MetadataReference> references) => CSharpCompilation.Create(name,
        new[] { CSharpSyntaxTree.ParseText(source, new CSharpParseOptions(LanguageVersion.CSharp9), "Source.cs") },
        references.Append(MetadataReference.CreateFromFile(netstandard)), StandInAssemblies.Options);

    static (CSharpCompilation compilation, Conformity conformity) Check(string source, string version, string api = Api)
    {
        var compilation = Compile("Engine", source, Enumerable.Empty<MetadataReference>());
        var conformity = new Conformity(List(api), new[] { version });
        conformity.Check(compilation);
        return (compilation, conformity);
    }

    static string Faults(string source, string version) => string.Join("\n", Check(source, version).conformity.Faults);

    /// What a script is told that is compiled against what it sees of a version.
    static string Errors(string script, string version)
    {
        var (compilation, conformity) = Check(Source, version);
        var types = Surface.Of(compilation.Assembly.GlobalNamespace).OfType<INamedTypeSymbol>();
        var names = Names.Compile(List(), "Engine", new[] { version }, types, new[] { (MetadataReference)MetadataReference.CreateFromFile(netstandard) }, StandInAssemblies.Options);
        var seen = new[] { SeenSources.Of(compilation, conformity), names }.Select(one =>
        {
            using (var stream = new MemoryStream())
            {
                var faults = StandInAssemblies.Emit(one, stream);
                if (faults.Count > 0) throw new BuildException(string.Join("\n", faults));
                return (MetadataReference)MetadataReference.CreateFromImage(stream.ToArray());
            }
        }).ToList();
        var ignored = new[] { "CS0169", "CS0649" };
        return string.Join(" ", Compile("Script", script, seen).GetDiagnostics().Where(one => one.Severity >= DiagnosticSeverity.Warning && !ignored.Contains(one.Id)).Select(one => one.Id));
    }

    static void Same(string found, string expected, string what)
    {
        if (found != expected) throw new BuildException($"{what}: '{found}' and not '{expected}'");
    }
}
