// The stand-in's sources as scripts of one version of Unity see them: without what it lacks, and with what is obsolete in it.
using System.Collections.Generic;
using System.Linq;
using Microsoft.CodeAnalysis;
using Microsoft.CodeAnalysis.CSharp;
using Microsoft.CodeAnalysis.CSharp.Syntax;

sealed class SeenSources : CSharpSyntaxRewriter
{
    readonly Conformity conformity;

    SeenSources(Conformity conformity) => this.conformity = conformity;

    public static CSharpCompilation Of(CSharpCompilation compilation, Conformity conformity)
    {
        var rewriter = new SeenSources(conformity);
        return compilation.RemoveAllSyntaxTrees().AddSyntaxTrees(compilation.SyntaxTrees.Select(tree =>
            CSharpSyntaxTree.Create((CSharpSyntaxNode)rewriter.Visit(tree.GetRoot()), (CSharpParseOptions)tree.Options, tree.FilePath, tree.Encoding)));
    }

    public override SyntaxNode Visit(SyntaxNode node)
    {
        var visited = base.Visit(node);
        if (node == null || !conformity.Changes.TryGetValue(node, out var state)) return visited;
        if (state != ApiState.Absent) return Obsolete((MemberDeclarationSyntax)visited, state == ApiState.Fails);
        return IsAlwaysPublic(node) ? null : Hidden((MemberDeclarationSyntax)visited);
    }

    // What others do not see of a member.
    public override SyntaxNode VisitBlock(BlockSyntax node) => node;
    public override SyntaxNode VisitArrowExpressionClause(ArrowExpressionClauseSyntax node) => node;
    public override SyntaxNode VisitEqualsValueClause(EqualsValueClauseSyntax node) => node;

    public override SyntaxNode VisitAttributeList(AttributeListSyntax node) =>
        node.Attributes.Any(attribute => attribute.Name.ToString().Split('.').Last() == "InternalsVisibleTo") ? null : node;

    public override SyntaxNode VisitEnumDeclaration(EnumDeclarationSyntax node)
    {
        var seen = node.Members.Where(member => !conformity.Changes.TryGetValue(member, out var state) || state != ApiState.Absent);
        return node.WithMembers(SyntaxFactory.SeparatedList(seen.Select(member => (EnumMemberDeclarationSyntax)Visit(member))));
    }

    public override SyntaxNode VisitEnumMemberDeclaration(EnumMemberDeclarationSyntax node) =>
        conformity.Values.TryGetValue(node, out var value) ? node.WithEqualsValue(SyntaxFactory.EqualsValueClause(SyntaxFactory.ParseExpression(value))) : node;

    static bool IsAlwaysPublic(SyntaxNode node) =>
        node is OperatorDeclarationSyntax || node is ConversionOperatorDeclarationSyntax || node.Parent is InterfaceDeclarationSyntax;

    static MemberDeclarationSyntax Obsolete(MemberDeclarationSyntax member, bool fails) =>
        member.AddAttributeLists(SyntaxFactory.AttributeList(SyntaxFactory.SingletonSeparatedList(SyntaxFactory.Attribute(
            SyntaxFactory.ParseName("global::System.ObsoleteAttribute"),
            SyntaxFactory.ParseAttributeArgumentList($"(\"It is obsolete in this version of Unity.\", {(fails ? "true" : "false")})")))));

    static MemberDeclarationSyntax Hidden(MemberDeclarationSyntax member)
    {
        if (member is BasePropertyDeclarationSyntax property && property.AccessorList != null)
            member = property.WithAccessorList(property.AccessorList.WithAccessors(SyntaxFactory.List(
                property.AccessorList.Accessors.Select(accessor => accessor.WithModifiers(default)))));
        var others = member.Modifiers.Where(modifier => !modifier.IsKind(SyntaxKind.PublicKeyword) && !modifier.IsKind(SyntaxKind.ProtectedKeyword) && !modifier.IsKind(SyntaxKind.InternalKeyword));
        return member.WithModifiers(SyntaxFactory.TokenList(others.Prepend(SyntaxFactory.Token(SyntaxKind.InternalKeyword).WithTrailingTrivia(SyntaxFactory.Space))));
    }
}
