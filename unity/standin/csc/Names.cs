// Types that Unity has and the stand-in lacks, empty: a script that uses such a name with another in mind fails as it does in Unity.
using System.Collections.Generic;
using System.Linq;
using System.Text;
using Microsoft.CodeAnalysis;
using Microsoft.CodeAnalysis.CSharp;

static class Names
{
    /// The name of the assembly that has those of a list.
    public static string AssemblyOf(string list) => list + ".Names";

    public static CSharpCompilation Compile(ApiList list, string name, string[] versions, IEnumerable<INamedTypeSymbol> declared, MetadataReference[] library, CSharpCompilationOptions options)
    {
        var known = new HashSet<string>(declared.Select(Surface.Id));
        var text = new StringBuilder();
        foreach (var id in list.Ids.Where(id => IsOutermost(list, id) && !known.Contains(id)))
        {
            var (what, state) = list.Find(id, versions);
            if (state != ApiState.Absent) Declare(id, what, state, text);
        }
        var tree = CSharpSyntaxTree.ParseText(text.ToString(), new CSharpParseOptions(LanguageVersion.CSharp9));
        return CSharpCompilation.Create(AssemblyOf(name), new[] { tree }, library, options);
    }

    /// Whether it is the id of a type that is in no other.
    public static bool IsOutermost(ApiList list, string id) => id.StartsWith("T:") && !list.Knows("T:" + Space(id));

    /// What the type of an id is in: a namespace, or another type.
    public static string Space(string id) => id.LastIndexOf('.') is var dot && dot < 0 ? "" : id.Substring(2, dot - 2);

    static void Declare(string id, string what, ApiState state, StringBuilder text)
    {
        var space = Space(id);
        var words = id.Substring(space == "" ? 2 : space.Length + 3).Split('`');
        var generic = words.Length == 1 ? "" : "<" + string.Join(", ", Enumerable.Range(0, int.Parse(words[1])).Select(index => "T" + index)) + ">";
        var name = words[0] + generic;
        if (space != "") text.Append("namespace ").Append(space).Append(" { ");
        if (state != ApiState.There) text.Append($"[global::System.Obsolete(\"It is obsolete in this version of Unity.\", {(state == ApiState.Fails ? "true" : "false")})] ");
        switch (what.Split(' ')[0])
        {
            case "delegate": text.Append($"public delegate void {name}();"); break;
            case "class" when what == "class static": text.Append($"public static class {name} {{ }}"); break;
            // As attributes they compete with others only if they are some.
            case "class" when words[0].EndsWith("Attribute"): text.Append($"public class {name} : global::System.Attribute {{ }}"); break;
            default: text.Append($"public {what.Split(' ')[0]} {name} {{ }}"); break;
        }
        text.Append(space != "" ? " }\n" : "\n");
    }
}
