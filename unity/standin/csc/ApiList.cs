// One list of unity/api: names and signatures of Unity's public API, of several versions side by side.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;

/// How a version has a member.
enum ApiState { Absent, There, Warns, Fails }

sealed class ApiList
{
    /// One character a version, in the list's first column.
    const string States = "-+we";

    public readonly List<string> Versions = new List<string>();
    /// Those whose types' names are all here.
    public readonly SortedSet<string> Namespaces = new SortedSet<string>(StringComparer.Ordinal);
    /// By id what it is, and in which versions it is that: some change from one to the next.
    readonly SortedDictionary<string, List<(string what, ApiState[] states)>> lines = new SortedDictionary<string, List<(string, ApiState[])>>(StringComparer.Ordinal);

    public IEnumerable<string> Ids => lines.Keys;
    public bool Knows(string id) => lines.ContainsKey(id);

    public void Add(string id, string what, int version, ApiState state)
    {
        if (!lines.TryGetValue(id, out var all)) lines[id] = all = new List<(string, ApiState[])>();
        var line = all.FirstOrDefault(one => one.what == what);
        if (line.states == null) all.Add(line = (what, new ApiState[Versions.Count]));
        line.states[version] = state;
    }

    /// How all of these versions have it: what the last says that it is, and the worst of how they are.
    public (string what, ApiState state) Find(string id, IEnumerable<string> versions)
    {
        (string what, ApiState state) found = (null, ApiState.There);
        foreach (var version in versions)
        {
            var column = Versions.IndexOf(version);
            if (column < 0) throw new BuildException($"unity/api has no {version}, but {string.Join(", ", Versions)}.");
            var line = lines.TryGetValue(id, out var all) ? all.FirstOrDefault(one => one.states[column] != ApiState.Absent) : default;
            if (line.states == null) return (null, ApiState.Absent);
            found = (line.what, line.states[column] > found.state ? line.states[column] : found.state);
        }
        return found;
    }

    /// Whether of a version more is told than types and accessors: an older list has neither parameters' names nor values.
    public bool TellsRest(string version)
    {
        var column = Versions.IndexOf(version);
        return lines.Values.Any(all => all.Any(one => one.states[column] != ApiState.Absent && one.what.Contains(Surface.Rest)));
    }

    /// Lists of the same versions as one.
    public static ApiList Read(params string[] files)
    {
        var list = new ApiList();
        foreach (var line in files.SelectMany(File.ReadLines).Where(line => line != "" && line[0] != '#'))
        {
            var words = line.Split(' ', 3);
            if (words[0] == "version")
            {
                if (!list.Versions.Contains(words[1])) list.Versions.Add(words[1]);
            }
            else if (words[0] == "namespace") list.Namespaces.Add(words.Length > 1 ? words[1] : "");
            else
                for (var version = 0; version < list.Versions.Count; version++)
                    if (words[0][version] != States[0]) list.Add(words[1], words[2], version, (ApiState)States.IndexOf(words[0][version]));
        }
        return list;
    }

    public void Write(string file, string heading)
    {
        var text = heading.Split('\n').Select(line => ("# " + line).TrimEnd()).Concat(Versions.Select(version => "version " + version))
            .Concat(Namespaces.Select(space => ("namespace " + space).TrimEnd()));
        var told = from line in lines
                   from one in line.Value
                   select $"{string.Concat(one.states.Select(state => States[(int)state]))} {line.Key} {one.what}";
        File.WriteAllText(file, string.Join("\n", text.Concat(told)) + "\n");
    }
}
