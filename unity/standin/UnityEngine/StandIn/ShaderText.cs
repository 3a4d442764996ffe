// The text of .shader and .compute files, as far as the stand-in draws and dispatches what they say.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using System.Text.RegularExpressions;
using UnityEngine;
using UnityEngine.Rendering;

namespace StandIn
{
    /// One pass of ShaderLab.
    sealed class ShaderPass
    {
        internal string name = "", code = "", vertex, fragment;
        internal readonly Dictionary<string, string> tags = new Dictionary<string, string>();
        internal readonly Dictionary<string, string[]> states = new Dictionary<string, string[]>();
        internal readonly Dictionary<string, uint> programs = new Dictionary<string, uint>();
        internal readonly Dictionary<uint, List<Variable>[]> variables = new Dictionary<uint, List<Variable>[]>();
        internal List<string[]> keywordSets = new List<string[]>();

        internal Native.DrawState State(Func<string, float> property)
        {
            string[] Words(string key, params string[] otherwise) => states.TryGetValue(key, out var words) ? words : otherwise;
            T Name<T>(string word) where T : struct
            {
                if (word.StartsWith("[")) return (T)(object)(int)property(word.Trim('[', ']'));
                if (typeof(T) == typeof(CompareFunction)) word = word.Replace("LEqual", "LessEqual").Replace("GEqual", "GreaterEqual");
                if (typeof(T) == typeof(BlendOp)) word = word.Replace("RevSub", "ReverseSubtract").Replace("Sub", "Subtract").Replace("ReverseSubtracttract", "ReverseSubtract");
                return Enum.TryParse<T>(word, true, out var value) ? value : throw new NotImplementedException($"the stand-in knows no state '{word}'");
            }
            var state = new Native.DrawState
            {
                cull = (uint)Name<CullMode>(Words("Cull", "Back")[0]),
                depthTest = (uint)Name<CompareFunction>(Words("ZTest", "LEqual")[0]),
                depthWrite = Words("ZWrite", "On")[0].Equals("On", StringComparison.OrdinalIgnoreCase) ? 1u : 0,
                colorMask = Mask(Words("ColorMask", "RGBA")[0]),
            };
            // Depth is reversed: what is nearer is greater.
            if (SystemInfo.usesReversedZBuffer)
                state.depthTest = (CompareFunction)state.depthTest switch
                {
                    CompareFunction.Less => (uint)CompareFunction.Greater, CompareFunction.LessEqual => (uint)CompareFunction.GreaterEqual,
                    CompareFunction.Greater => (uint)CompareFunction.Less, CompareFunction.GreaterEqual => (uint)CompareFunction.LessEqual, _ => state.depthTest,
                };
            var blend = Words("Blend", "Off");
            if (!blend[0].Equals("Off", StringComparison.OrdinalIgnoreCase))
            {
                if (blend.Length != 2 && blend.Length != 4) throw new NotImplementedException("the stand-in has one target: Blend " + string.Join(" ", blend));
                var operation = Words("BlendOp", "Add");
                state.blend = 1;
                state.source = (uint)Name<BlendMode>(blend[0]);
                state.destination = (uint)Name<BlendMode>(blend[1]);
                state.alphaSource = (uint)Name<BlendMode>(blend[blend.Length - 2]);
                state.alphaDestination = (uint)Name<BlendMode>(blend[blend.Length - 1]);
                state.operation = (uint)Name<BlendOp>(operation[0]);
                state.alphaOperation = (uint)Name<BlendOp>(operation[operation.Length - 1]);
            }
            return state;
        }

        static uint Mask(string word)
        {
            if (word == "0") return 0;
            uint mask = 0;
            foreach (var letter in word.ToUpperInvariant()) mask |= letter switch { 'R' => 8u, 'G' => 4u, 'B' => 2u, 'A' => 1u, _ => throw new NotImplementedException($"ColorMask {word}") };
            return mask;
        }
    }

    /// What a program binds, as the device's library reads it from the SPIR-V.
    sealed class Variable
    {
        internal string name, kind;
        internal int id;
        internal uint binding, size;
        internal List<(int id, string name, int offset, int size)> members = new List<(int, string, int, int)>();
        internal bool isBuffer => kind == "raw" || kind == "structured" || kind == "any" || kind == "rwraw" || kind == "rwstructured" || kind == "rwany";
        internal bool isWritten => kind.StartsWith("rw");
        internal bool isTexture => !isBuffer && kind != "constant" && kind != "sampler";

        internal static List<Variable> Read(string description, out int[] threads)
        {
            var all = new List<Variable>();
            threads = new[] { 1, 1, 1 };
            foreach (var line in description.Split('\n'))
            {
                var words = line.Split('\t');
                switch (words[0])
                {
                    case "threads": threads = words.Skip(1).Select(int.Parse).ToArray(); break;
                    case "variable": all.Add(new Variable { name = words[1], id = Shader.PropertyToID(words[1]), kind = words[2], binding = uint.Parse(words[3]), size = uint.Parse(words[4]) }); break;
                    case "member": all[all.Count - 1].members.Add((Shader.PropertyToID(words[1]), words[1], int.Parse(words[2]), int.Parse(words[3]))); break;
                }
            }
            return all;
        }
    }

    /// A reader of ShaderLab.
    static class ShaderLab
    {
        sealed class Words
        {
            internal List<string> all = new List<string>();
            internal int at;
            internal string next => at < all.Count ? all[at] : null;
            internal string Take() => at < all.Count ? all[at++] : throw new UnityException("a shader's text ends too early");
            internal void Expect(string word) { var found = Take(); if (found != word) throw new UnityException($"a shader's text has '{found}' where '{word}' is due"); }
            internal void Skip() { Expect("{"); for (int depth = 1; depth > 0;) { var word = Take(); if (word == "{") depth++; else if (word == "}") depth--; } }
        }
        const string Code = "\u0001";

        internal static void Read(string text, out string name, List<ShaderPass> passes, Dictionary<string, object> properties)
        {
            text = Regex.Replace(text, @"/\*.*?\*/", "", RegexOptions.Singleline);
            var code = new List<string>();
            text = Regex.Replace(text, @"\b(HLSLPROGRAM|CGPROGRAM|HLSLINCLUDE|CGINCLUDE)\b(.*?)\b(ENDHLSL|ENDCG)\b", match =>
            {
                code.Add((match.Groups[1].Value.EndsWith("INCLUDE") ? "I" : "P") + match.Groups[2].Value);
                return $" {Code}{code.Count - 1} ";
            }, RegexOptions.Singleline);
            text = Regex.Replace(text, @"//.*", "");
            var words = new Words { all = Regex.Matches(text, "\"[^\"]*\"|[{}]|\\[[^\\]]*\\]|[^\\s{}\",]+|,").Cast<Match>().Select(match => match.Value).ToList() };
            words.Expect("Shader");
            name = words.Take().Trim('"');
            words.Expect("{");
            var include = "";
            while (words.next != "}")
            {
                var word = words.Take();
                switch (word)
                {
                    case "Properties": Properties(words, properties); break;
                    case "SubShader" when passes.Count == 0: SubShader(words, passes, code, ref include); break;
                    case "SubShader": words.Skip(); break;
                    case "Fallback": case "FallBack": case "CustomEditor": words.Take(); break;
                    default:
                        if (word.StartsWith(Code)) { include += code[int.Parse(word.Substring(1))].Substring(1); break; }
                        throw new NotImplementedException($"the stand-in knows no '{word}' in a shader");
                }
            }
        }

        static void Properties(Words words, Dictionary<string, object> properties)
        {
            // Of each: NAME ("label", Type) = value.
            var start = words.at;
            words.Skip();
            var text = string.Join(" ", words.all.Skip(start + 1).Take(words.at - start - 2));
            foreach (Match match in Regex.Matches(text, @"(\w+) \( ?""[^""]*"" , (\w+)( \([^)]*\))? ?\) = (\([^)]*\)|""[^""]*""|[-+.\deE]+)"))
            {
                var value = match.Groups[4].Value;
                if (value.StartsWith("\"")) properties[match.Groups[1].Value] = value.Trim('"');
                else if (value.StartsWith("(")) { var n = value.Trim('(', ')').Split(',').Select(part => float.Parse(part, CultureInfo.InvariantCulture)).ToArray(); properties[match.Groups[1].Value] = new Vector4(n[0], n[1], n[2], n[3]); }
                else properties[match.Groups[1].Value] = float.Parse(value, CultureInfo.InvariantCulture);
            }
        }

        static void SubShader(Words words, List<ShaderPass> passes, List<string> code, ref string include)
        {
            words.Expect("{");
            var shared = new ShaderPass();
            while (words.next != "}")
                if (words.next == "Pass")
                {
                    words.Take();
                    words.Expect("{");
                    var pass = new ShaderPass();
                    foreach (var pair in shared.states) pass.states[pair.Key] = pair.Value;
                    foreach (var pair in shared.tags) pass.tags[pair.Key] = pair.Value;
                    while (words.next != "}") State(words, pass, code, ref include);
                    words.Take();
                    passes.Add(pass);
                }
                else State(words, shared, code, ref include);
            words.Take();
        }

        static void State(Words words, ShaderPass pass, List<string> code, ref string include)
        {
            var word = words.Take();
            switch (word)
            {
                case "Tags":
                    words.Expect("{");
                    while (words.next != "}") { var key = words.Take().Trim('"'); words.Expect("="); pass.tags[key] = words.Take().Trim('"'); }
                    words.Take();
                    break;
                case "Name": pass.name = words.Take().Trim('"'); break;
                case "LOD": words.Take(); break;
                case "PackageRequirements": words.Skip(); break;
                case "Cull": case "ZTest": case "ZWrite": case "ColorMask": case "ZClip": pass.states[word] = new[] { words.Take() }; break;
                case "Blend": case "BlendOp":
                    var values = new List<string>();
                    do { if (words.next == ",") words.Take(); values.Add(words.Take()); }
                    while (words.next == "," || word == "Blend" && values.Count == 1 && !values[0].Equals("Off", StringComparison.OrdinalIgnoreCase) || values.Count == 3);
                    pass.states[word] = values.ToArray();
                    break;
                default:
                    if (!word.StartsWith(Code)) throw new NotImplementedException($"the stand-in knows no '{word}' in a shader's pass");
                    var text = code[int.Parse(word.Substring(1))];
                    if (text[0] == 'I') { include += text.Substring(1); break; }
                    pass.code = include + text.Substring(1);
                    pass.vertex = Regex.Match(text, @"#pragma\s+vertex\s+(\w+)").Groups[1].Value;
                    pass.fragment = Regex.Match(text, @"#pragma\s+fragment\s+(\w+)").Groups[1].Value;
                    pass.keywordSets = KeywordSets(text);
                    break;
            }
        }

        internal static List<string[]> KeywordSets(string text) => Regex.Matches(text, @"#pragma\s+(?:multi_compile|shader_feature)\w*\s+(.+)").Cast<Match>().Select(match => match.Groups[1].Value.Split(new[] { ' ', '\t', '\r' }, StringSplitOptions.RemoveEmptyEntries)).ToList();
    }
}
