// Unity knows a script by its file: scenes, assets and importers' settings refer to the class that is called as the file is.
// A class in a file of another name compiles, works until it is saved, and is a missing script from then on.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using Microsoft.CodeAnalysis;

static class ScriptFiles
{
    static readonly string[] saved = { "UnityEngine.MonoBehaviour", "UnityEngine.ScriptableObject", "UnityEditor.AssetImporters.ScriptedImporter" };

    /// Of an assembly's classes that are saved by their file, those whose file is called otherwise.
    public static IEnumerable<string> Missing(IAssemblySymbol assembly) =>
        Types(assembly.GlobalNamespace).Where(type => !type.IsAbstract && IsSaved(type))
            .Where(type => !type.DeclaringSyntaxReferences.Any(at => Path.GetFileNameWithoutExtension(at.SyntaxTree.FilePath) == type.Name))
            .Select(type => $"{type.DeclaringSyntaxReferences[0].SyntaxTree.FilePath}: {type.Name} has to be in {type.Name}.cs: Unity finds the script of what is saved by its file's name.");

    static bool IsSaved(INamedTypeSymbol type)
    {
        // Inspectors are found by what they inspect.
        for (var at = type.BaseType; at != null && at.ToDisplayString() != "UnityEditor.Editor"; at = at.BaseType)
            if (saved.Contains(at.ToDisplayString())) return true;
        return false;
    }

    static IEnumerable<INamedTypeSymbol> Types(INamespaceOrTypeSymbol within) =>
        within.GetMembers().OfType<INamespaceOrTypeSymbol>().SelectMany(member => (member is INamedTypeSymbol type ? new[] { type } : Enumerable.Empty<INamedTypeSymbol>()).Concat(Types(member)));
}
