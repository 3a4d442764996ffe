// The compiler's driver: hands C# to Roslyn. `compile` takes csc's own options; `unity` compiles what has assembly
// definitions as Unity's editor, or a player's build, would.
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

static class Program
{
    static int Main(string[] arguments)
    {
        try
        {
            switch (arguments.FirstOrDefault())
            {
                case "compile": return Compile(arguments.Skip(1).ToArray()) ? 0 : 1;
                case "unity" when arguments.Length >= 8:
                    return Unity(arguments[1], arguments[2], new ClassLibraries(arguments[3], arguments[4]), arguments[5], arguments[6], arguments.Skip(7).ToArray()) ? 0 : 1;
                case "api" when arguments.Length >= 6:
                    ApiLists.Make(arguments[1], arguments[2], new ClassLibraries(arguments[3], arguments[4]), arguments.Skip(5).ToArray());
                    return 0;
                case "test" when arguments.Length == 2: return ConformityTests.Run(arguments[1]) ? 0 : 1;
                default:
                    Console.Error.WriteLine("usage: csc compile OPTIONS... | csc test NETSTANDARD | csc unity VERSION,... OUT NETSTANDARD FRAMEWORK NUNIT API FOLDER... | csc api LISTS API NETSTANDARD FRAMEWORK FOLDER...");
                    return 2;
            }
        }
        catch (BuildException error)
        {
            Console.Error.WriteLine("error: " + error.Message);
            return 1;
        }
    }

    /// Compiles folders as versions of Unity do, each into a folder of its own.
    static bool Unity(string versions, string output, ClassLibraries libraries, string nunit, string api, string[] folders)
    {
        var all = true;
        foreach (var name in versions == "all" ? UnityVersion.All : versions.Split(','))
        {
            Console.WriteLine($"==> As Unity {name}");
            var build = new UnityBuild(new UnityVersion(name), Path.Combine(output, name), libraries, nunit, api, folders);
            ApiLists.RequireAllOf(build.Used(), api);
            all &= build.Run();
        }
        return all;
    }

    /// Compiles one assembly by csc's options. An assembly whose inputs are those of the last time is left as it is.
    public static bool Compile(string[] options, bool areScripts = false)
    {
        var here = Directory.GetCurrentDirectory();
        var parsed = CSharpCommandLineParser.Default.Parse(options, here, Path.GetDirectoryName(typeof(object).Assembly.Location));
        foreach (var error in parsed.Errors) Console.Error.WriteLine(error);
        if (parsed.Errors.Any(error => error.Severity == DiagnosticSeverity.Error)) return false;
        if (parsed.OutputFileName == null) throw new BuildException("-out: is missing");

        var output = Path.Combine(parsed.OutputDirectory, parsed.OutputFileName);
        var stamp = Stamp(options, parsed);
        if (File.Exists(output) && File.Exists(output + ".stamp") && File.ReadAllText(output + ".stamp") == stamp) return true;
        File.Delete(output + ".stamp");

        var trees = parsed.SourceFiles.AsParallel().AsOrdered().Select(file =>
        {
            using (var stream = File.OpenRead(file.Path))
                return CSharpSyntaxTree.ParseText(SourceText.From(stream, Encoding.UTF8, canBeEmbedded: false), parsed.ParseOptions, Path.GetRelativePath(here, file.Path));
        }).ToList();
        var references = parsed.MetadataReferences.Select(reference => MetadataReference.CreateFromFile(Path.GetFullPath(reference.Reference)));
        var name = Path.GetFileNameWithoutExtension(parsed.OutputFileName);
        var compilation = CSharpCompilation.Create(name, trees, references, parsed.CompilationOptions);
        using (var assembly = new MemoryStream())
        using (var symbols = new MemoryStream())
        {
            var result = compilation.Emit(assembly, symbols, options: parsed.EmitOptions.WithDebugInformationFormat(DebugInformationFormat.PortablePdb));
            foreach (var diagnostic in result.Diagnostics)
                if (diagnostic.Severity >= DiagnosticSeverity.Warning && !diagnostic.IsSuppressed) Console.Error.WriteLine(diagnostic);
            var unsaved = areScripts ? ScriptFiles.Missing(compilation.Assembly).ToList() : new List<string>();
            foreach (var problem in unsaved) Console.Error.WriteLine(problem);
            if (!result.Success || unsaved.Count > 0)
            {
                File.Delete(output);
                return false;
            }
            Replace(output, assembly.ToArray());
            Replace(Path.ChangeExtension(output, ".pdb"), symbols.ToArray());
        }
        File.WriteAllText(output + ".stamp", stamp);
        return true;
    }

    /// Programs may run that have the old file mapped: it is not written over, but replaced.
    public static void Replace(string file, byte[] contents)
    {
        var made = $"{file}.{System.Diagnostics.Process.GetCurrentProcess().Id}";
        File.WriteAllBytes(made, contents);
        File.Move(made, file, true);
    }

    /// A hash of all that the outcome depends on.
    static string Stamp(string[] options, CommandLineArguments parsed)
    {
        using (var hash = IncrementalHash.CreateHash(HashAlgorithmName.SHA256))
        {
            hash.AppendData(Encoding.UTF8.GetBytes(string.Join("\n", options)));
            hash.AppendData(File.ReadAllBytes(typeof(Program).Assembly.Location));
            foreach (var file in parsed.SourceFiles.Select(file => file.Path).Concat(parsed.MetadataReferences.Select(reference => reference.Reference)))
                if (File.Exists(file)) hash.AppendData(File.ReadAllBytes(file));
            return BitConverter.ToString(hash.GetHashAndReset());
        }
    }
}

/// What a person has to mend, without a stack.
sealed class BuildException : Exception
{
    public BuildException(string message) : base(message) { }
}
