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

    /// Between what a member is and the rest: names and defaults of its parameters, or its value.
    public const string Rest = " | ";

    /// Kind and base of a type; of a member whether it is static, its type, its accessors, and whether it may be overridden.
    public static string What(ISymbol symbol)
    {
        if (symbol is INamedTypeSymbol type) return What(type);
        switch (symbol)
        {
            case IFieldSymbol field when field.HasConstantValue: return Plain(symbol) + Rest + SymbolDisplay.FormatPrimitive(field.ConstantValue, quoteStrings: true, useHexadecimalNumbers: false);
            case IMethodSymbol method when method.Parameters.Length > 0: return Plain(symbol) + Rest + Parameters(method.Parameters, method.IsExtensionMethod);
            case IPropertySymbol property when property.Parameters.Length > 0: return Plain(symbol) + Rest + Parameters(property.Parameters, false);
            default: return Plain(symbol);
        }
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
