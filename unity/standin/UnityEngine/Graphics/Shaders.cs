using System;
using System.Collections.Generic;
using System.Linq;
using System.Text.RegularExpressions;
using StandIn;
using UnityEngine;
using UnityEngine.Rendering;

namespace UnityEngine
{
    public sealed class Shader : Object
    {
        internal Shader() { }
        static readonly Dictionary<string, int> ids = new Dictionary<string, int>();
        static readonly List<string> names = new List<string>();
        internal static readonly PropertySheet globals = new PropertySheet();
        internal static readonly HashSet<string> globalKeywords = new HashSet<string>();
        internal readonly List<ShaderPass> passes = new List<ShaderPass>();
        internal readonly Dictionary<string, object> properties = new Dictionary<string, object>();
        internal string file;
        /// Why the program that was asked for last does not compile.
        internal string error;

        internal static Shader Load(string file)
        {
            var shader = new Shader { file = file, isAsset = true };
            ShaderLab.Read(System.IO.File.ReadAllText(file), out var name, shader.passes, shader.properties);
            shader.name = name;
            return shader;
        }
        public static int PropertyToID(string name)
        {
            lock (ids)
            {
                if (ids.TryGetValue(name, out var id)) return id;
                ids[name] = id = names.Count;
                names.Add(name);
                return id;
            }
        }
        internal static string NameOf(int id) { lock (ids) return id >= 0 && id < names.Count ? names[id] : $"property {id}"; }
        /// Null where no shader of the package, or of the stand-in's own, is named so.
        public static Shader Find(string name)
        {
            Threads.Main("Shader.Find");
            return Resources.Shaders().FirstOrDefault(shader => shader.label == name) ?? Engines(name);
        }
        static readonly Dictionary<string, Shader> engines = new Dictionary<string, Shader>();
        /// The pipelines' own that packages ask for.
        static Shader Engines(string name)
        {
            if (engines.TryGetValue(name, out var found)) return found;
            var properties = name switch
            {
                "Standard" => new[] { "_Color", "_EmissionColor", "_Glossiness", "_SpecularHighlights", "_GlossyReflections" },
                "Universal Render Pipeline/Unlit" => new[] { "_BaseColor" },
                "HDRP/Unlit" => new[] { "_UnlitColor" },
                _ => null,
            };
            if (properties == null) return null;
            var made = new Shader { name = name, isAsset = true };
            foreach (var property in properties) made.properties[property] = Vector4.one;
            return engines[name] = made;
        }
        public bool isSupported => error == null && !Faults.noComputeShaders;
        public int passCount => passes.Count;
        public int renderQueue => 2000;
        public int GetPropertyCount() => properties.Count;
        public int FindPropertyIndex(string propertyName) => properties.Keys.ToList().IndexOf(propertyName);
        public string GetPropertyName(int propertyIndex) => properties.Keys.ElementAt(propertyIndex);
        public static void SetGlobalTexture(int nameID, Texture value) { Threads.Main("SetGlobalTexture"); globals.Set(nameID, value); }
        public static void SetGlobalTexture(string name, Texture value) => SetGlobalTexture(PropertyToID(name), value);
        public static void SetGlobalBuffer(int nameID, GraphicsBuffer value) => globals.Set(nameID, value);
        public static void SetGlobalConstantBuffer(int nameID, GraphicsBuffer value, int offset, int size) => globals.SetConstant(nameID, value, offset, size);
        public static void SetGlobalFloat(int nameID, float value) => globals.Set(nameID, value);
        public static void SetGlobalFloat(string name, float value) => globals.Set(PropertyToID(name), value);
        public static void SetGlobalInt(int nameID, int value) => globals.Set(nameID, value);
        public static void SetGlobalVector(int nameID, Vector4 value) => globals.Set(nameID, value);
        public static void SetGlobalVector(string name, Vector4 value) => globals.Set(PropertyToID(name), value);
        public static void SetGlobalMatrix(int nameID, Matrix4x4 value) => globals.Set(nameID, value);
        public static Texture GetGlobalTexture(int nameID) => globals.Texture(nameID);
        public static Texture GetGlobalTexture(string name) => GetGlobalTexture(PropertyToID(name));
        public static Vector4 GetGlobalVector(int nameID) => globals.Vector(nameID);
        public static void EnableKeyword(string keyword) => globalKeywords.Add(keyword);
        public static void DisableKeyword(string keyword) => globalKeywords.Remove(keyword);
        public static bool IsKeywordEnabled(string keyword) => globalKeywords.Contains(keyword);
        public static void WarmupAllShaders() { }

        /// The program of a pass with these keywords; 0 where it does not compile.
        internal unsafe uint Program(ShaderPass pass, HashSet<string> keywords)
        {
            var wanted = pass.keywordSets.SelectMany(set => set).Where(word => keywords.Contains(word) || globalKeywords.Contains(word)).Distinct().OrderBy(word => word, StringComparer.Ordinal).ToArray();
            var key = string.Join(" ", wanted);
            if (pass.programs.TryGetValue(key, out var program)) return program;
            try
            {
                var defines = wanted.Select(word => word + "=1").ToArray();
                if (pass.vertex == "" || pass.fragment == "") throw new UnityException($"a pass of '{label}' lacks #pragma vertex or #pragma fragment");
                byte[] vertex = ShaderCompiler.Compile(pass.code, file, pass.vertex, "vs_6_0", defines), fragment = ShaderCompiler.Compile(pass.code, file, pass.fragment, "ps_6_0", defines);
                Gpu.Open();
                fixed (byte* v = vertex, f = fragment) program = Native.sg_create_program(v, (ulong)vertex.Length / 4, f, (ulong)fragment.Length / 4);
                Gpu.Check($"Shader '{label}'");
            }
            catch (Exception error) when (!(error is NotImplementedException)) { Debug.LogError(error.Message); this.error = error.Message; }
            if (program != 0) pass.variables[program] = new[] { Variable.Read(Gpu.Describe(program, 0), out _), Variable.Read(Gpu.Describe(program, 1), out _) };
            return pass.programs[key] = program;
        }
    }

    public class Material : Object
    {
        internal readonly PropertySheet sheet = new PropertySheet();
        internal readonly HashSet<string> keywords = new HashSet<string>();
        Shader m_Shader;
        public Material(Shader shader)
        {
            Threads.Main("Material..ctor");
            if (shader == null) throw new ArgumentNullException(nameof(shader));
            m_Shader = shader;
            name = shader.name;
        }
        public Material(Material source) : this(source.shader) { name = source.name; sheet.CopyFrom(source.sheet); keywords.UnionWith(source.keywords); renderQueue = source.renderQueue; }
        public Shader shader { get { Alive(); return m_Shader; } set => m_Shader = value; }
        public int passCount => shader.passCount;
        public int renderQueue { get; set; } = 2000;
        public bool enableInstancing { get; set; }
        public string[] shaderKeywords { get => keywords.ToArray(); set { keywords.Clear(); keywords.UnionWith(value); } }
        public int FindPass(string passName) => shader.passes.FindIndex(pass => pass.name.Equals(passName, StringComparison.OrdinalIgnoreCase));
        public string GetPassName(int pass) => shader.passes[pass].name;
        public void EnableKeyword(string keyword) => keywords.Add(keyword);
        public void DisableKeyword(string keyword) => keywords.Remove(keyword);
        public bool IsKeywordEnabled(string keyword) => keywords.Contains(keyword);
        public bool SetPass(int pass) => throw new NotImplementedException("the stand-in draws by command buffers only");
        /// Whether the shader lists it, or it was set.
        public bool HasProperty(int nameID) => shader.properties.ContainsKey(Shader.NameOf(nameID)) || sheet.Has(nameID);
        public bool HasProperty(string name) => HasProperty(Shader.PropertyToID(name));
        public bool HasTexture(int nameID) => sheet.Texture(nameID) != null || shader.properties.TryGetValue(Shader.NameOf(nameID), out var value) && value is string;
        public bool HasTexture(string name) => HasTexture(Shader.PropertyToID(name));
        public bool HasFloat(string name) => HasProperty(name);
        public bool HasColor(string name) => HasProperty(name);
        void Main(string member) { Threads.Main(member); Alive(); }
        public void SetFloat(int nameID, float value) { Main("SetFloat"); sheet.Set(nameID, value); }
        public void SetFloat(string name, float value) => SetFloat(Shader.PropertyToID(name), value);
        public void SetInt(int nameID, int value) { Main("SetInt"); sheet.Set(nameID, (float)value); }
        public void SetInt(string name, int value) => SetInt(Shader.PropertyToID(name), value);
        public void SetInteger(int nameID, int value) { Main("SetInteger"); sheet.Set(nameID, value); }
        public void SetInteger(string name, int value) => SetInteger(Shader.PropertyToID(name), value);
        public void SetVector(int nameID, Vector4 value) { Main("SetVector"); sheet.Set(nameID, value); }
        public void SetVector(string name, Vector4 value) => SetVector(Shader.PropertyToID(name), value);
        public void SetColor(int nameID, Color value) => SetVector(nameID, value);
        public void SetColor(string name, Color value) => SetVector(name, value);
        public void SetMatrix(int nameID, Matrix4x4 value) { Main("SetMatrix"); sheet.Set(nameID, value); }
        public void SetMatrix(string name, Matrix4x4 value) => SetMatrix(Shader.PropertyToID(name), value);
        public void SetTexture(int nameID, Texture value) { Main("SetTexture"); sheet.Set(nameID, value); }
        public void SetTexture(string name, Texture value) => SetTexture(Shader.PropertyToID(name), value);
        public void SetBuffer(int nameID, GraphicsBuffer value) { Main("SetBuffer"); sheet.Set(nameID, value); }
        public void SetBuffer(string name, GraphicsBuffer value) => SetBuffer(Shader.PropertyToID(name), value);
        public void SetConstantBuffer(int nameID, GraphicsBuffer value, int offset, int size) { Main("SetConstantBuffer"); sheet.SetConstant(nameID, value, offset, size); }
        object Default(int id) => shader.properties.TryGetValue(Shader.NameOf(id), out var value) ? value : null;
        public float GetFloat(int nameID) => sheet.Has(nameID) ? sheet.Vector(nameID).x : Default(nameID) is float value ? value : 0;
        public float GetFloat(string name) => GetFloat(Shader.PropertyToID(name));
        public int GetInt(string name) => (int)GetFloat(name);
        public int GetInteger(string name) => sheet.Integer(Shader.PropertyToID(name));
        public Vector4 GetVector(int nameID) => sheet.Has(nameID) ? sheet.Vector(nameID) : Default(nameID) is Vector4 value ? value : Vector4.zero;
        public Vector4 GetVector(string name) => GetVector(Shader.PropertyToID(name));
        public Color GetColor(int nameID) => GetVector(nameID);
        public Color GetColor(string name) => GetVector(name);
        public Texture GetTexture(int nameID) => sheet.Texture(nameID);
        public Texture GetTexture(string name) => GetTexture(Shader.PropertyToID(name));
        public Texture mainTexture { get => GetTexture("_MainTex"); set => SetTexture("_MainTex", value); }
        public Color color { get => GetColor("_Color"); set => SetColor("_Color", value); }
        public string GetTag(string tag, bool searchFallbacks) => GetTag(tag, searchFallbacks, "");
        public string GetTag(string tag, bool searchFallbacks, string defaultValue) => shader.passes.Count > 0 && shader.passes[0].tags.TryGetValue(tag, out var value) ? value : defaultValue;
        /// Another one where the shader, a keyword or a property is.
        public int ComputeCRC()
        {
            Main("ComputeCRC");
            int sum = m_Shader.GetInstanceID();
            foreach (var keyword in keywords) sum += 17 * keyword.GetHashCode();
            foreach (var pair in sheet)
            {
                var of = pair.Value;
                sum += 31 * (pair.Key * 7919 + of.value.GetHashCode() * 31 + of.integer * 13 + (of.resource is Object item ? item.GetInstanceID() : 0));
            }
            return sum;
        }
    }

    public sealed class MaterialPropertyBlock
    {
        internal readonly PropertySheet sheet = new PropertySheet();
        public bool isEmpty => sheet.isEmpty;
        public void Clear() => sheet.Clear();
        public void SetFloat(int nameID, float value) => sheet.Set(nameID, value);
        public void SetFloat(string name, float value) => sheet.Set(Shader.PropertyToID(name), value);
        public void SetInt(int nameID, int value) => sheet.Set(nameID, (float)value);
        public void SetInteger(int nameID, int value) => sheet.Set(nameID, value);
        public void SetVector(int nameID, Vector4 value) => sheet.Set(nameID, value);
        public void SetVector(string name, Vector4 value) => sheet.Set(Shader.PropertyToID(name), value);
        public void SetColor(int nameID, Color value) => sheet.Set(nameID, (Vector4)value);
        public void SetMatrix(int nameID, Matrix4x4 value) => sheet.Set(nameID, value);
        public void SetTexture(int nameID, Texture value) { if (value == null) throw new ArgumentNullException(nameof(value)); sheet.Set(nameID, value); }
        public void SetTexture(string name, Texture value) => SetTexture(Shader.PropertyToID(name), value);
        public void SetBuffer(int nameID, GraphicsBuffer value) => sheet.Set(nameID, value);
        public void SetBuffer(string name, GraphicsBuffer value) => sheet.Set(Shader.PropertyToID(name), value);
        public void SetConstantBuffer(int nameID, GraphicsBuffer value, int offset, int size) => sheet.SetConstant(nameID, value, offset, size);
        public void SetConstantBuffer(string name, GraphicsBuffer value, int offset, int size) => sheet.SetConstant(Shader.PropertyToID(name), value, offset, size);
    }

    public sealed class ComputeShader : Object
    {
        internal ComputeShader() { }
        internal sealed class Kernel
        {
            internal string entry, error;
            internal string[] defines;
            internal readonly Dictionary<string, (uint handle, List<Variable> variables, int[] threads)> programs = new Dictionary<string, (uint, List<Variable>, int[])>();
            internal readonly PropertySheet sheet = new PropertySheet();
        }
        internal readonly List<Kernel> kernels = new List<Kernel>();
        internal readonly PropertySheet sheet = new PropertySheet();
        internal readonly HashSet<string> keywords = new HashSet<string>();
        List<string[]> keywordSets;
        string file, text;

        internal static ComputeShader Load(string file)
        {
            var shader = new ComputeShader { file = file, text = System.IO.File.ReadAllText(file), isAsset = true };
            shader.name = System.IO.Path.GetFileNameWithoutExtension(file);
            foreach (Match match in Regex.Matches(shader.text, @"^[ \t]*#pragma[ \t]+kernel[ \t]+(\w+)([^\r\n]*)", RegexOptions.Multiline))
                shader.kernels.Add(new Kernel { entry = match.Groups[1].Value, defines = match.Groups[2].Value.Split(new[] { ' ', '\t' }, StringSplitOptions.RemoveEmptyEntries) });
            shader.keywordSets = ShaderLab.KeywordSets(shader.text);
            return shader;
        }
        /// Of text, for tests.
        internal static ComputeShader FromText(string name, string text)
        {
            var file = System.IO.Path.Combine(System.IO.Path.GetTempPath(), $"standin-{System.Diagnostics.Process.GetCurrentProcess().Id}-{name}.compute");
            System.IO.File.WriteAllText(file, text);
            try { return Load(file); } finally { System.IO.File.Delete(file); }
        }
        /// Of SPIR-V that is there already, for tests.
        internal static ComputeShader FromSpirV(string name, string entry, byte[] spirv)
        {
            var shader = new ComputeShader { isAsset = true, keywordSets = new List<string[]>() };
            shader.name = name;
            var kernel = new Kernel { entry = entry, defines = new string[0] };
            shader.kernels.Add(kernel);
            kernel.programs[""] = shader.Make(kernel, spirv);
            return shader;
        }
        unsafe (uint, List<Variable>, int[]) Make(Kernel kernel, byte[] spirv)
        {
            Gpu.Open();
            uint handle;
            fixed (byte* words = spirv) handle = Native.sg_create_kernel(words, (ulong)spirv.Length / 4);
            Gpu.Check($"ComputeShader '{label}', kernel '{kernel.entry}'");
            if (handle == 0) return default;
            var variables = Variable.Read(Gpu.Describe(handle, 2), out var threads);
            return (handle, variables, threads);
        }
        internal (uint handle, List<Variable> variables, int[] threads) Program(int kernelIndex)
        {
            var kernel = kernels[kernelIndex];
            var wanted = keywordSets.SelectMany(set => set).Where(word => keywords.Contains(word) || Shader.globalKeywords.Contains(word)).Distinct().OrderBy(word => word, StringComparer.Ordinal).ToArray();
            var key = string.Join(" ", wanted);
            if (kernel.programs.TryGetValue(key, out var program)) return program;
            try { program = Make(kernel, ShaderCompiler.Compile(text, file, kernel.entry, "cs_6_0", kernel.defines.Concat(wanted.Select(word => word + "=1")))); }
            catch (UnityException error) { Debug.LogError(error.Message); kernel.error = error.Message; }
            return kernel.programs[key] = program;
        }

        public bool HasKernel(string name) { Threads.Main("HasKernel"); return kernels.Exists(kernel => kernel.entry == name); }
        public int FindKernel(string name)
        {
            Threads.Main("FindKernel");
            int index = kernels.FindIndex(kernel => kernel.entry == name);
            return index >= 0 ? index : throw new ArgumentException($"Kernel '{name}' not found.");
        }
        public bool IsSupported(int kernelIndex) { Valid(kernelIndex); return !Faults.noComputeShaders && Program(kernelIndex).handle != 0; }
        internal void Valid(int kernelIndex) { Alive(); if (kernelIndex < 0 || kernelIndex >= kernels.Count) throw new ArgumentException($"Invalid kernelIndex ({kernelIndex}) passed, must be non-negative less than {kernels.Count}."); }
        public void GetKernelThreadGroupSizes(int kernelIndex, out uint x, out uint y, out uint z) { Valid(kernelIndex); var threads = Program(kernelIndex).threads; x = (uint)threads[0]; y = (uint)threads[1]; z = (uint)threads[2]; }
        public void EnableKeyword(string keyword) => keywords.Add(keyword);
        public void DisableKeyword(string keyword) => keywords.Remove(keyword);
        public bool IsKeywordEnabled(string keyword) => keywords.Contains(keyword);
        void Main(string member) { Threads.Main(member); Alive(); }
        public void SetBuffer(int kernelIndex, int nameID, GraphicsBuffer buffer) { Main("SetBuffer"); Valid(kernelIndex); kernels[kernelIndex].sheet.Set(nameID, buffer); }
        public void SetBuffer(int kernelIndex, string name, GraphicsBuffer buffer) => SetBuffer(kernelIndex, Shader.PropertyToID(name), buffer);
        public void SetTexture(int kernelIndex, int nameID, Texture texture) { Main("SetTexture"); Valid(kernelIndex); kernels[kernelIndex].sheet.Set(nameID, texture); }
        public void SetTexture(int kernelIndex, string name, Texture texture) => SetTexture(kernelIndex, Shader.PropertyToID(name), texture);
        public void SetConstantBuffer(int nameID, GraphicsBuffer buffer, int offset, int size) { Main("SetConstantBuffer"); sheet.SetConstant(nameID, buffer, offset, size); }
        public void SetConstantBuffer(string name, GraphicsBuffer buffer, int offset, int size) => SetConstantBuffer(Shader.PropertyToID(name), buffer, offset, size);
        public void SetInt(int nameID, int val) { Main("SetInt"); sheet.Set(nameID, val); }
        public void SetInt(string name, int val) => SetInt(Shader.PropertyToID(name), val);
        public void SetFloat(int nameID, float val) { Main("SetFloat"); sheet.Set(nameID, val); }
        public void SetFloat(string name, float val) => SetFloat(Shader.PropertyToID(name), val);
        public void SetVector(int nameID, Vector4 val) { Main("SetVector"); sheet.Set(nameID, val); }
        public void SetVector(string name, Vector4 val) => SetVector(Shader.PropertyToID(name), val);
        public void SetMatrix(int nameID, Matrix4x4 val) { Main("SetMatrix"); sheet.Set(nameID, val); }
        public void Dispatch(int kernelIndex, int threadGroupsX, int threadGroupsY, int threadGroupsZ)
        {
            Main("Dispatch");
            using (var commands = new CommandBuffer { name = "Dispatch" })
            {
                commands.DispatchCompute(this, kernelIndex, threadGroupsX, threadGroupsY, threadGroupsZ);
                Graphics.ExecuteCommandBuffer(commands);
            }
        }
    }
}

namespace StandIn
{
    enum PropertyKind { Float, Integer, Vector, Matrix, Texture, Target, Buffer, Constant }

    /// Values by the numbers of their names.
    struct Property
    {
        internal PropertyKind kind;
        internal Matrix4x4 value;
        internal int integer, offset, size, level;
        internal object resource;
        internal RenderTargetIdentifier target;
    }

    sealed class PropertySheet
    {
        readonly Dictionary<int, Property> all = new Dictionary<int, Property>();
        internal bool isEmpty => all.Count == 0;
        internal void Clear() => all.Clear();
        internal bool Has(int id) => all.ContainsKey(id);
        internal bool TryGet(int id, out Property property) => all.TryGetValue(id, out property);
        internal void Put(int id, Property property) => all[id] = property;
        public Dictionary<int, Property>.Enumerator GetEnumerator() => all.GetEnumerator();
        internal void CopyFrom(PropertySheet other) { foreach (var pair in other.all) all[pair.Key] = pair.Value; }
        internal void Set(int id, float value) => all[id] = new Property { kind = PropertyKind.Float, value = new Matrix4x4 { m00 = value } };
        internal void Set(int id, int value) => all[id] = new Property { kind = PropertyKind.Integer, integer = value };
        internal void Set(int id, Vector4 value) { var m = new Matrix4x4(); m.SetColumn(0, value); all[id] = new Property { kind = PropertyKind.Vector, value = m }; }
        internal void Set(int id, Matrix4x4 value) => all[id] = new Property { kind = PropertyKind.Matrix, value = value };
        internal void Set(int id, Texture value) { if (value is null) all.Remove(id); else all[id] = new Property { kind = PropertyKind.Texture, resource = value }; }
        internal void Set(int id, GraphicsBuffer value) { if (value == null) all.Remove(id); else all[id] = new Property { kind = PropertyKind.Buffer, resource = value }; }
        internal void SetConstant(int id, GraphicsBuffer value, int offset, int size) { if (value == null) all.Remove(id); else all[id] = new Property { kind = PropertyKind.Constant, resource = value, offset = offset, size = size }; }
        internal Vector4 Vector(int id) => all.TryGetValue(id, out var found) ? found.kind == PropertyKind.Integer ? new Vector4(found.integer, 0) : found.value.GetColumn(0) : Vector4.zero;
        internal int Integer(int id) => all.TryGetValue(id, out var found) ? found.kind == PropertyKind.Integer ? found.integer : (int)found.value.m00 : 0;
        internal Texture Texture(int id) => all.TryGetValue(id, out var found) ? found.kind == PropertyKind.Target ? found.target.texture : found.resource as Texture : null;
    }
}
