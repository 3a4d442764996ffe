// A version of Unity, in the editor or for players: what it defines, which packages it has, and which lists tell its API.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;

sealed class UnityVersion
{
    /// The one whose stand-in runs; of the others there is what scripts are compiled against.
    public const string Run = "6000.0";

    /// By version of Unity: that of the render pipelines, and the versions in unity/api that it plays. A member has to be in
    /// all of them: nobody has 17.3 there, so that it is what 17.1 and 17.5 agree on, and of HDRP 17.1 is the newest.
    static readonly (string unity, string pipelines, string[] engine, string[] universal, string[] highDefinition)[] Known =
    {
        ("2022.3", "14.0.12", new[] { "2022.3.62f2" }, new[] { "14.0.12" }, new[] { "14.0.8" }),
        ("6000.0", "17.0.4", new[] { "6000.0.78f1" }, new[] { "17.0.4" }, new[] { "17.0.4" }),
        ("6000.3", "17.3.0", new[] { "6000.3.19f1" }, new[] { "17.1.0", "17.5.0" }, new[] { "17.1.0" }),
        ("6000.5", "17.5.0", new[] { "6000.5.2f1" }, new[] { "17.5.0" }, new[] { "17.1.0" }),
    };

    /// By assembly of Unity, the list that has its types.
    static readonly Dictionary<string, string> ListOf = new Dictionary<string, string>
    {
        ["UnityEngine"] = "UnityEngine",
        ["UnityEngine.UIElementsModule"] = "UnityEngine",
        ["UnityEditor"] = "UnityEditor",
        ["Unity.RenderPipelines.Core.Runtime"] = "RenderPipelines.Core",
        ["Unity.RenderPipelines.Universal.Runtime"] = "RenderPipelines.Universal",
        ["Unity.RenderPipelines.HighDefinition.Runtime"] = "RenderPipelines.HighDefinition",
    };

    public static readonly string[] Lists = ListOf.Values.Distinct().ToArray();
    public static string ListOfAssembly(string assembly) =>
        ListOf.TryGetValue(assembly, out var list) ? list : throw new BuildException($"{assembly} is in no list of unity/api, so that nobody knows whether it is as Unity's.");

    /// All versions in a list that any version of Unity plays.
    public static IEnumerable<string> VersionsIn(string list) => Known.SelectMany(known => new UnityVersion(known.unity).VersionsOf(list)).Distinct();
    public static IEnumerable<string> All => Known.SelectMany(known => new[] { known.unity, known.unity + "-player" }).Append(Run + "-framework");

    public readonly string Name;
    public readonly bool IsEditor;
    /// What Project Settings > Player > Api Compatibility Level says; editors' own assemblies are compiled so in any case.
    public readonly bool IsFramework;
    public readonly HashSet<string> Symbols;
    public readonly Dictionary<string, Version> Packages;
    /// Whether all packages are there that anything is constrained to, and tests.
    public readonly bool HasAll;
    readonly string[] engine, universal, highDefinition;

    /// `6000.0` or `2022.3`, with `-player` appended as for a player, with `-framework` against .NET Framework instead of .NET Standard.
    public UnityVersion(string name)
    {
        Name = name;
        IsEditor = !name.EndsWith("-player");
        IsFramework = name.EndsWith("-framework");
        var version = name.Split('-')[0];
        var index = Array.FindIndex(Known, known => known.unity == version);
        if (index < 0) throw new BuildException($"Unity {version} is not one that the stand-in stands for: {string.Join(", ", Known.Select(known => known.unity))}.");
        string pipelines;
        (_, pipelines, engine, universal, highDefinition) = Known[index];

        Symbols = new HashSet<string> { "UNITY_64", "UNITY_STANDALONE", "UNITY_STANDALONE_LINUX", "CSHARP_7_3_OR_NEWER", "ENABLE_VR", "ENABLE_PROFILER", "ENABLE_MONO", "UNITY_ASSERTIONS", "STAND_IN" };
        Symbols.UnionWith(IsFramework ? new[] { "NET_4_6", "NET_UNITY_4_8" } : new[] { "NET_STANDARD_2_1", "NET_STANDARD", "NETSTANDARD", "NETSTANDARD2_1" });
        if (IsEditor) Symbols.UnionWith(new[] { "UNITY_EDITOR", "UNITY_EDITOR_64", "UNITY_EDITOR_LINUX", "ENABLE_UNITY_COLLECTIONS_CHECKS", "DEVELOPMENT_BUILD", "DEBUG", "TRACE" });
        if (IsEditor && !IsFramework) Symbols.Add("UNITY_INCLUDE_TESTS");
        // Whether there is the old input manager is up to the project: both are compiled.
        if (name != "6000.0-player") Symbols.Add("ENABLE_LEGACY_INPUT_MANAGER");
        Symbols.Add("UNITY_" + version.Replace('.', '_'));
        Symbols.Add("UNITY_" + version.Split('.')[0]);
        var older = new List<string> { "2019_4", "2020_1", "2020_2", "2020_3", "2021_1", "2021_2", "2021_3", "2022_1", "2022_2", "2022_3" };
        if (version != "2022.3")
        {
            older.AddRange(new[] { "2023_1", "2023_2", "2023_3" });
            older.AddRange(Enumerable.Range(0, int.Parse(version.Split('.')[1]) + 1).Select(minor => $"6000_{minor}"));
        }
        Symbols.UnionWith(older.Select(one => $"UNITY_{one}_OR_NEWER"));

        Packages = new Dictionary<string, Version>
        {
            ["Unity"] = AssemblyDefinition.Parse(version),
            ["com.unity.render-pipelines.core"] = AssemblyDefinition.Parse(pipelines),
            ["com.unity.render-pipelines.universal"] = AssemblyDefinition.Parse(pipelines),
            ["com.unity.render-pipelines.high-definition"] = AssemblyDefinition.Parse(pipelines),
            ["com.unity.test-framework"] = AssemblyDefinition.Parse("1.4.5"),
            ["com.unity.modules.imageconversion"] = AssemblyDefinition.Parse("1.0.0"),
            ["com.unity.modules.xr"] = AssemblyDefinition.Parse("1.0.0"),
        };
        if (version != "6000.5") Packages["com.unity.modules.vr"] = AssemblyDefinition.Parse("1.0.0");
        // Packages that are not there for this run, for what a project without them compiles.
        var without = Environment.GetEnvironmentVariable("UNITY_WITHOUT") ?? "";
        foreach (var missing in without.Split(' ')) Packages.Remove(missing);
        HasAll = without == "" && Symbols.Contains("UNITY_INCLUDE_TESTS");
    }

    public string[] VersionsOf(string list) =>
        !list.StartsWith("RenderPipelines.") ? engine : list == "RenderPipelines.HighDefinition" ? highDefinition : universal;
}

/// Where the class libraries lie that scripts may be compiled against.
sealed class ClassLibraries
{
    readonly string netstandard, framework;

    /// `framework`: Mono's of .NET Framework.
    public ClassLibraries(string netstandard, string framework)
    {
        this.netstandard = netstandard;
        this.framework = framework;
    }

    public string[] Of(UnityVersion version) => version.IsFramework
        ? new[] { "mscorlib", "System", "System.Core", "System.Numerics" }.Select(name => Path.Combine(framework, name + ".dll")).ToArray()
        : new[] { Path.Combine(netstandard, "netstandard.dll") };
}
