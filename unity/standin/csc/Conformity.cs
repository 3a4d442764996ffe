// Compares what an assembly of the stand-in offers with the list of what Unity's has.
using System;
using System.Collections.Generic;
using System.Linq;
using Microsoft.CodeAnalysis;
using Microsoft.CodeAnalysis.CSharp;
using Microsoft.CodeAnalysis.CSharp.Syntax;

sealed class Conformity
{
    readonly ApiList list;
    readonly string[] versions;
    readonly bool tellsRest;
    readonly HashSet<ISymbol> hidden = new HashSet<ISymbol>(SymbolEqualityComparer.Default);

    /// What is not as in Unity, with where it is declared.
    public readonly List<string> Faults = new List<string>();
    /// Declarations that scripts of this version do not see, or are warned of, or may not use.
    public readonly Dictionary<SyntaxNode, ApiState> Changes = new Dictionary<SyntaxNode, ApiState>();
    /// The values of enumerators whose enumeration loses others.
    public readonly Dictionary<SyntaxNode, string> Values = new Dictionary<SyntaxNode, string>();
    /// How many types and members are as in Unity.
    public int Count { get; private set; }

    public Conformity(ApiList list, string[] versions)
    {
        this.list = list;
        this.versions = versions;
        tellsRest = versions.All(list.TellsRest);
    }

    public void Check(CSharpCompilation compilation)
    {
        foreach (var symbol in Surface.Of(compilation.Assembly.GlobalNamespace))
            if (IsOwn(symbol))
            {
                if (symbol.ContainingType == null) Change(symbol, ApiState.Absent);
            }
            else if (symbol.ContainingType == null || !hidden.Contains(symbol.ContainingType)) Compare(symbol);
    }

    /// What tests steer the stand-in with is no part of Unity, and is named so: the namespace StandIn, and types whose names begin so.
    static bool IsOwn(ISymbol symbol)
    {
        var type = symbol as INamedTypeSymbol ?? symbol.ContainingType;
        while (type.ContainingType != null) type = type.ContainingType;
        return type.Name.StartsWith("StandIn") || type.ContainingNamespace.ToDisplayString() == "StandIn";
    }

    void Compare(ISymbol symbol)
    {
        var id = Surface.Id(symbol);
        var (there, state) = list.Find(id, versions);
        if (state == ApiState.Absent)
        {
            // What overrides is seen through what it overrides.
            if (symbol.IsOverride) return;
            if (list.Knows(id)) Change(symbol, ApiState.Absent);
            else Fault(symbol, "Unity has no such thing, or has made it otherwise");
            return;
        }
        var here = Surface.What(symbol);
        if (!IsSame(here, there)) Fault(symbol, $"it is '{here}', and '{there}' in Unity");
        Count++;
        if (state != ApiState.There) Change(symbol, state);
    }

    bool IsSame(string here, string there)
    {
        if (!tellsRest) (here, there) = (here.Split(new[] { Surface.Rest }, StringSplitOptions.None)[0], there.Split(new[] { Surface.Rest }, StringSplitOptions.None)[0]);
        // Whether Unity overrides, or inherits, is nothing that scripts see.
        return here.Replace(" override", "") == there.Replace(" override", "");
    }

    void Fault(ISymbol symbol, string what)
    {
        var place = symbol.Locations[0].GetLineSpan();
        Faults.Add($"{place.Path}({place.StartLinePosition.Line + 1}): {Surface.Id(symbol)} ({string.Join(", ", versions)}): {what}");
    }

    void Change(ISymbol symbol, ApiState state)
    {
        if (state == ApiState.Absent) hidden.Add(symbol);
        var declarations = symbol.DeclaringSyntaxReferences.Select(reference => Declaration(reference.GetSyntax())).ToList();
        // Attributes of one part are the whole's.
        if (state != ApiState.Absent) declarations = declarations.Take(1).ToList();
        if (declarations.Count == 0) Fault(symbol, "not every version has it: it has to be declared");
        foreach (var declaration in declarations)
        {
            if (declaration is BaseFieldDeclarationSyntax fields && fields.Declaration.Variables.Count > 1)
                Fault(symbol, "not every version has it so: it has to be declared by itself");
            Changes[declaration] = state;
        }
        if (state == ApiState.Absent && symbol.ContainingType?.TypeKind == TypeKind.Enum)
            foreach (var other in symbol.ContainingType.GetMembers().OfType<IFieldSymbol>())
                foreach (var reference in other.DeclaringSyntaxReferences) Values[reference.GetSyntax()] = other.ConstantValue.ToString();
    }

    static SyntaxNode Declaration(SyntaxNode node) => node is VariableDeclaratorSyntax ? node.Parent.Parent : node;
}
