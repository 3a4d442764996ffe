// What an assembly offers to others, each member told as the lists of Unity's API tell it: its documentation id, and what it is.
using System.Collections.Generic;
using System.Linq;
using Microsoft.CodeAnalysis;
using Microsoft.CodeAnalysis.CSharp;

static class Surface
{
    /// All public and protected types below a namespace, and their members.
    public static IEnumerable<ISymbol> Of(INamespaceSymbol space) =>
        space.GetTypeMembers().SelectMany(Of).Concat(space.GetNamespaceMembers().SelectMany(Of));

    static IEnumerable<ISymbol> Of(INamedTypeSymbol type)
    {
        if (!IsSeen(type)) yield break;
        yield return type;
        foreach (var member in type.GetMembers())
            if (member is INamedTypeSymbol nested)
                foreach (var symbol in Of(nested)) yield return symbol;
            else if (IsSeen(member) && IsDeclared(member)) yield return member;
    }

    static bool IsSeen(ISymbol symbol) => symbol.DeclaredAccessibility == Accessibility.Public
        || symbol.DeclaredAccessibility == Accessibility.Protected || symbol.DeclaredAccessibility == Accessibility.ProtectedOrInternal;

    /// Accessors are told with their property or event. Of what the compiler adds, constructors count.
    static bool IsDeclared(ISymbol member)
    {
        if (!(member is IMethodSymbol method)) return !member.IsImplicitlyDeclared;
        switch (method.MethodKind)
        {
            case MethodKind.PropertyGet:
            case MethodKind.PropertySet:
            case MethodKind.EventAdd:
            case MethodKind.EventRemove: return false;
            case MethodKind.Constructor: return true;
            default: return !method.IsImplicitlyDeclared;
        }
    }

    /// An enumerator is what its enumeration is.
    public const string Enumerator = "const";

    public static string Id(ISymbol symbol) => symbol.GetDocumentationCommentId();

    /// Between what something is and the rest: names and defaults of a member's parameters, or its value; of a type whether it
    /// is of flags, and what it may be an attribute of; what types of both have to be.
    public const string Rest = " | ";

    /// Kind and base of a type; of a member whether it is static, its type, its accessors, and whether it may be overridden.
    public static string What(ISymbol symbol)
    {
        var parts = Parts(symbol).Where(part => part != "").ToList();
        var plain = symbol is INamedTypeSymbol type ? What(type) : Plain(symbol);
        return parts.Count == 0 ? plain : plain + Rest + string.Join(" ", parts);
    }

    static IEnumerable<string> Parts(ISymbol symbol)
    {
        switch (symbol)
        {
            case IFieldSymbol field when field.HasConstantValue:
                yield return SymbolDisplay.FormatPrimitive(field.ConstantValue, quoteStrings: true, useHexadecimalNumbers: false);
                break;
            case IMethodSymbol method:
                yield return Parameters(method.Parameters, method.IsExtensionMethod);
                // What overrides has its constraints from there.
                if (!method.IsOverride) yield return Constraints(method.TypeParameters);
                break;
            case IPropertySymbol property:
                yield return Parameters(property.Parameters, false);
                break;
            case INamedTypeSymbol type:
                if (type.TypeKind == TypeKind.Enum && type.GetAttributes().Any(one => one.AttributeClass?.Name == "FlagsAttribute")) yield return "flags";
                yield return Usage(type);
                yield return Constraints(type.TypeParameters);
                break;
        }
    }

    /// What a class may be an attribute of: its own word, or that of the nearest above it that says any.
    static string Usage(INamedTypeSymbol type)
    {
        for (var at = type; at != null && at.ToDisplayString() != "System.Attribute"; at = at.BaseType)
            foreach (var said in at.GetAttributes().Where(one => one.AttributeClass?.Name == "AttributeUsageAttribute" && one.ConstructorArguments.Length == 1))
            {
                bool Named(string name, bool otherwise) => said.NamedArguments.FirstOrDefault(one => one.Key == name).Value.Value as bool? ?? otherwise;
                return $"usage {said.ConstructorArguments[0].Value}{(Named("AllowMultiple", false) ? " multiple" : "")}{(Named("Inherited", true) ? "" : " alone")}";
            }
        return "";
    }

    static string Constraints(IEnumerable<ITypeParameterSymbol> types) => string.Join(" ", types.Select(Constraint).Where(one => one != ""));

    static string Constraint(ITypeParameterSymbol type)
    {
        var all = new List<string>();
        if (type.HasReferenceTypeConstraint) all.Add("class");
        if (type.HasUnmanagedTypeConstraint) all.Add("unmanaged");
        else if (type.HasValueTypeConstraint) all.Add("struct");
        all.AddRange(type.ConstraintTypes.Select(one => one.ToDisplayString()).OrderBy(one => one, System.StringComparer.Ordinal));
        if (type.HasConstructorConstraint) all.Add("new()");
        return all.Count == 0 ? "" : $"where {type.Name}: {string.Join(", ", all)}";
    }

    static string Parameters(IEnumerable<IParameterSymbol> parameters, bool isExtension) => (isExtension ? "this " : "") + string.Join(", ", parameters.Select(one =>
        (one.IsParams ? "params " : one.RefKind == RefKind.None ? "" : one.RefKind.ToString().ToLowerInvariant() + " ") + one.Name
        + (one.HasExplicitDefaultValue ? " = " + SymbolDisplay.FormatPrimitive(one.ExplicitDefaultValue, quoteStrings: true, useHexadecimalNumbers: false) : "")));

    static string Plain(ISymbol symbol)
    {
        if (symbol is IFieldSymbol && symbol.ContainingType.TypeKind == TypeKind.Enum) return Enumerator;
        return (symbol.IsStatic ? "static " : "") + (symbol.DeclaredAccessibility == Accessibility.Public ? "" : "protected ") + Member(symbol);
    }

    static string What(INamedTypeSymbol type)
    {
        var what = type.TypeKind.ToString().ToLowerInvariant();
        if (type.TypeKind != TypeKind.Class) return what;
        if (type.IsStatic) return what + " static";
        if (type.IsSealed) what += " sealed";
        if (type.IsAbstract) what += " abstract";
        return type.BaseType == null || type.BaseType.SpecialType == SpecialType.System_Object ? what : what + " : " + type.BaseType.ToDisplayString();
    }

    static string Member(ISymbol symbol)
    {
        switch (symbol)
        {
            case IFieldSymbol field: return field.Type.ToDisplayString() + (field.IsConst ? " const" : field.IsReadOnly ? " readonly" : "");
            case IPropertySymbol property:
                return property.Type.ToDisplayString() + (property.GetMethod != null && IsSeen(property.GetMethod) ? " get" : "")
                    + (property.SetMethod != null && IsSeen(property.SetMethod) ? " set" : "");
            case IMethodSymbol method: return method.ReturnType.ToDisplayString() + (method.IsVirtual ? " virtual" : method.IsAbstract ? " abstract" : method.IsOverride ? " override" : "");
            case IEventSymbol happening: return happening.Type.ToDisplayString();
            default: return "";
        }
    }
}
