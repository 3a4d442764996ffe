// Makes unity/api anew from lists of all that versions of Unity have, one file a list and version.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;

static class ApiLists
{
    const string Heading = "Names and signatures of Unity's public API, by version; script/unity-api makes this file. The first column tells how the\n"
        + "versions below have a type or member: + there, - not, w obsolete with a warning, e with an error. Of the namespaces all\n"
        + "types are told, of what the stand-in declares all else: after a bar parameters, or the value.";

    /// Of the lists, what scripts and the stand-in in the folders use.
    public static void Make(string lists, string api, ClassLibraries libraries, string[] folders)
    {
        var declared = new HashSet<string>();
        var used = new HashSet<string> { "" };
        foreach (var version in UnityVersion.All)
        {
            var build = new UnityBuild(new UnityVersion(version), api, libraries, null, null, folders);
            used.UnionWith(build.Used());
            declared.UnionWith(build.StandIn().Declared().Select(one => Surface.Id(one.symbol)));
        }
        foreach (var name in UnityVersion.Lists) Make(name, lists, declared, used).Write(Path.Combine(api, name + ".txt"), Heading);
    }

    /// Fails where scripts import a namespace of Unity's whose types are not told, but for those of its test framework.
    public static void RequireAllOf(IEnumerable<string> used, string api)
    {
        var told = new HashSet<string>(UnityVersion.Lists.SelectMany(name => ApiList.Read(Path.Combine(api, name + ".txt")).Namespaces));
        foreach (var space in used.Where(space => space.StartsWith("Unity") && !space.Contains(".TestTools") && !told.Contains(space)))
            throw new BuildException($"unity/api does not tell the types of {space}, which a script imports: make it anew by script/unity-api.");
    }

    static ApiList Make(string name, string lists, ISet<string> declared, ISet<string> used)
    {
        var made = new ApiList();
        made.Versions.AddRange(UnityVersion.VersionsIn(name));
        for (var version = 0; version < made.Versions.Count; version++)
        {
            var lines = File.ReadLines(Path.Combine(lists, $"{name}-{made.Versions[version]}.txt")).Select(line => line.Split('\t')).ToList();
            var types = new HashSet<string>(lines.Select(line => line[0]).Where(id => id.StartsWith("T:")));
            foreach (var line in lines)
            {
                var space = Names.Space(line[0]);
                var isName = line[0].StartsWith("T:") && used.Contains(space) && !types.Contains("T:" + space);
                if (isName) made.Namespaces.Add(space);
                var what = line[1];
                if (what == $"static {space} const") what = Surface.Enumerator;
                // Of a type that is but a name its base is of no use.
                if (isName && !declared.Contains(line[0])) what = what.Split(Surface.Rest)[0].Split(" : ")[0];
                if (isName || declared.Contains(line[0])) made.Add(line[0], what, version, State(line.ElementAtOrDefault(2)));
            }
        }
        return made;
    }

    static ApiState State(string obsolete)
    {
        switch (obsolete)
        {
            case null: return ApiState.There;
            case "obsolete: warning": return ApiState.Warns;
            case "obsolete: error": return ApiState.Fails;
            default: throw new BuildException($"no list says '{obsolete}'");
        }
    }
}
