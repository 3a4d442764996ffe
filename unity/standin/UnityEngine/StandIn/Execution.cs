// What a command buffer's commands do when they are executed, and what an engine would complain of.
using System;
using System.Collections.Generic;
using System.Linq;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine;
using UnityEngine.Experimental.Rendering;
using UnityEngine.Rendering;

namespace StandIn
{
    /// What is drawn to: a texture for colour and one for depth, or none, and which layer.
    struct BoundTarget { internal RenderTexture color, depth; internal int slice; }

    /// Executes command buffers. Of a camera's frame all share one, with the camera's targets.
    unsafe sealed class Execution
    {
        /// What `BuiltinRenderTextureType.CameraTarget` is.
        internal BoundTarget camera;
        BoundTarget bound;
        bool hasTarget, invertsCulling;
        /// How the built-in pipeline draws the eyes of a headset.
        internal SinglePassStereoMode stereo;
        int instanceMultiplier = 1;
        Vector4 viewport;
        readonly Dictionary<int, RenderTexture> temporary = new Dictionary<int, RenderTexture>();
        readonly List<uint> transient = new List<uint>();
        readonly List<Native.Bind> binds = new List<Native.Bind>();
        readonly PropertySheet block = new PropertySheet();
        string where;

        static readonly string[] builtIn = { "unity_", "_Time", "_SinTime", "_CosTime", "_ScreenParams", "_ProjectionParams", "_ZBufferParams", "_WorldSpaceCameraPos", "_ScaledScreenParams", "glstate_" };

        internal void Bind(BoundTarget target) { bound = target; hasTarget = true; viewport = Vector4.zero; }

        internal void Run(CommandBuffer commands)
        {
            if (commands.disposed) { Debug.LogError($"the CommandBuffer '{commands.name}' was disposed before it was executed"); return; }
            Gpu.Open();
            if (commands.openSamples != 0) Debug.LogError($"CommandBuffer '{commands.name}': BeginSample and EndSample do not match");
            for (int i = 0; i < commands.count; i++)
            {
                where = $"CommandBuffer '{commands.name}', command {i} ({commands.commands[i].operation})";
                Do(commands, ref commands.commands[i]);
                Gpu.Check(where);
            }
            Gpu.Submit($"CommandBuffer '{commands.name}'");
            foreach (var buffer in transient) Native.sg_free(buffer);
            transient.Clear();
        }

        /// The frame is over: what was temporary is given back.
        internal void End()
        {
            foreach (var texture in temporary.Values) RenderTexture.ReleaseTemporary(texture);
            temporary.Clear();
        }

        bool Usable(GraphicsBuffer buffer, string what)
        {
            if (buffer.handle != 0) return true;
            Debug.LogError($"{where}: {what}: the GraphicsBuffer '{buffer.name}' was released before the CommandBuffer was executed");
            return false;
        }

        void Do(CommandBuffer commands, ref Command command)
        {
            switch (command.operation)
            {
                case Operation.SetBufferData:
                    if (Usable((GraphicsBuffer)command.a, "SetBufferData"))
                        fixed (byte* data = commands.data) Native.sg_write_buffer(((GraphicsBuffer)command.a).handle, (ulong)command.offset, data + command.i, (ulong)command.j);
                    break;
                case Operation.CopyBuffer:
                    if (Usable((GraphicsBuffer)command.a, "CopyBuffer") && Usable((GraphicsBuffer)command.b, "CopyBuffer"))
                        Native.sg_copy_buffer(((GraphicsBuffer)command.a).handle, 0, ((GraphicsBuffer)command.b).handle, 0, (ulong)command.length);
                    break;
                case Operation.SetComputeProperty:
                    var computed = (ComputeShader)command.a;
                    (command.i < 0 ? computed.sheet : computed.kernels[command.i].sheet).Put(command.j, command.property);
                    break;
                case Operation.SetGlobal: Shader.globals.Put(command.j, Settled(command.property)); break;
                case Operation.Keyword: if (command.i == 1) Shader.globalKeywords.Add((string)command.a); else Shader.globalKeywords.Remove((string)command.a); break;
                case Operation.Dispatch: Dispatch((ComputeShader)command.a, command.i, command.j, command.k, command.l); break;
                case Operation.Draw: Draw(commands, ref command); break;
                case Operation.SetTarget: SetTarget(ref command); break;
                case Operation.Clear:
                    if (!HasTarget()) break;
                    // Far is 0 where depth is reversed.
                    var depth = SystemInfo.usesReversedZBuffer ? 1 - command.property.value.m00 : command.property.value.m00;
                    foreach (var target in Targets(command.i != 0, command.j != 0)) Native.sg_clear(target, target.color != 0 ? 1u : 0, command.vector.x, command.vector.y, command.vector.z, command.vector.w, target.depth != 0 ? 1u : 0, depth);
                    break;
                case Operation.SetViewport: viewport = command.vector; break;
                case Operation.InvertCulling: invertsCulling = command.i != 0; break;
                case Operation.CopyTexture: CopyTexture(ref command); break;
                case Operation.Blit: Blit(ref command); break;
                case Operation.GetTemporary:
                    if (temporary.ContainsKey(command.j)) { Debug.LogWarning($"{where}: temporary render texture {Shader.NameOf(command.j)} is already there"); break; }
                    var made = RenderTexture.GetTemporary(command.descriptor);
                    made.filterMode = (FilterMode)command.i;
                    temporary[command.j] = made;
                    break;
                case Operation.ReleaseTemporary:
                    if (temporary.TryGetValue(command.j, out var given)) { temporary.Remove(command.j); RenderTexture.ReleaseTemporary(given); }
                    else Debug.LogWarning($"{where}: temporary render texture {Shader.NameOf(command.j)} is not there");
                    break;
                case Operation.ReadBuffer:
                    ReadBacks.Add((Action<AsyncGPUReadbackRequest>)command.b, Usable((GraphicsBuffer)command.a, "RequestAsyncReadback") ? Native.sg_read_buffer(((GraphicsBuffer)command.a).handle, (ulong)command.offset, (ulong)command.length) : 0, (int)command.length, (int)command.length, 1, 1);
                    break;
                case Operation.ReadTexture:
                    var source = Resolve(new RenderTargetIdentifier((Texture)command.a), "RequestAsyncReadback");
                    if (source != null) ReadBacks.Add((Action<AsyncGPUReadbackRequest>)command.b, Native.sg_read_texture(new Native.Region { texture = source.handle }, (uint)source.m_Width, (uint)source.m_Height, (uint)source.m_Depth), checked((int)source.bytes), source.m_Width, source.m_Height, source.m_Depth);
                    break;
                case Operation.BeginSample: case Operation.EndSample: break;
                case Operation.Stereo: stereo = (SinglePassStereoMode)command.i; break;
                case Operation.InstanceMultiplier: instanceMultiplier = command.i; break;
                default: throw new NotImplementedException(command.operation.ToString());
            }
        }

        /// A property whose target is known by now, for when others use it.
        Property Settled(Property property)
        {
            if (property.kind != PropertyKind.Target || property.target.texture is object) return property;
            var texture = Resolve(property.target, "SetGlobalTexture");
            return new Property { kind = PropertyKind.Target, target = new RenderTargetIdentifier(texture) { isDepthBuffer = property.target.isDepthBuffer || property.target.type == BuiltinRenderTextureType.Depth } };
        }

        /// The texture that is meant; null, with an error, where there is none that can be used.
        Texture Resolve(RenderTargetIdentifier target, string what)
        {
            Texture texture = null;
            switch (target.type)
            {
                case BuiltinRenderTextureType.RenderTexture: case BuiltinRenderTextureType.BindableTexture: texture = target.texture; break;
                case BuiltinRenderTextureType.CameraTarget: texture = camera.color; break;
                case BuiltinRenderTextureType.Depth: texture = camera.depth; break;
                case BuiltinRenderTextureType.CurrentActive: texture = bound.color; break;
                case BuiltinRenderTextureType.PropertyName:
                    if (temporary.TryGetValue(target.nameID, out var found)) texture = found;
                    else if (Shader.globals.TryGet(target.nameID, out var property)) texture = property.kind == PropertyKind.Target ? property.target.texture : property.resource as Texture;
                    break;
                case BuiltinRenderTextureType.None: return null;
                default: throw new NotImplementedException($"the stand-in has no {target.type}");
            }
            if (texture is null) { Debug.LogError($"{where}: {what}: there is no texture {target}"); return null; }
            if (texture.isDestroyed) { Debug.LogError($"{where}: {what}: the texture '{texture.label}' was destroyed before the CommandBuffer was executed"); return null; }
            if (texture is RenderTexture rendered && !rendered.IsCreated()) rendered.Create();
            if (texture.handle == 0) { Debug.LogError($"{where}: {what}: the texture '{texture.label}' was released before the CommandBuffer was executed"); return null; }
            return texture;
        }

        bool Find(int id, PropertySheet first, PropertySheet second, out Property property) =>
            first != null && first.TryGet(id, out property) || second != null && second.TryGet(id, out property) || Shader.globals.TryGet(id, out property);

        /// Adds what a program's stage binds. False, with an error that names what is missing, where a draw or dispatch must be skipped.
        bool Bindings(uint stage, List<Variable> variables, PropertySheet first, PropertySheet second, string owner)
        {
            foreach (var variable in variables)
            {
                var bind = new Native.Bind { stage = stage, binding = variable.binding };
                if (variable.kind == "sampler")
                {
                    bind.handle = Sampler(variable.name, first, second);
                    binds.Add(bind);
                    continue;
                }
                bool isSet = Find(variable.id, first, second, out var property);
                if (!isSet && variable.kind == "constant" && Values(variable, first, second, owner, out bind.handle)) { binds.Add(bind); continue; }
                if (!isSet) { Debug.LogError($"{owner}: Property ({variable.name}) is not set"); return false; }
                switch (property.kind)
                {
                    case PropertyKind.Buffer: case PropertyKind.Constant:
                        var buffer = (GraphicsBuffer)property.resource;
                        if (!Usable(buffer, $"{owner}, property ({variable.name})")) return false;
                        if (variable.isTexture) { Debug.LogError($"{owner}: Property ({variable.name}) is a texture, but a buffer is set"); return false; }
                        if (variable.kind == "constant" && (property.kind != PropertyKind.Constant || (buffer.target & GraphicsBuffer.Target.Constant) == 0)) { Debug.LogError($"{owner}: Property ({variable.name}) is a constant buffer, set by a constant-buffer method with a GraphicsBuffer of Target.Constant"); return false; }
                        if (variable.kind == "constant" && property.size < variable.size) { Debug.LogError($"{owner}: Property ({variable.name}) has {variable.size} bytes, but {property.size} are set"); return false; }
                        if (variable.isBuffer && property.kind == PropertyKind.Constant) { Debug.LogError($"{owner}: Property ({variable.name}) is no constant buffer"); return false; }
                        if (variable.kind.EndsWith("raw") && (buffer.target & GraphicsBuffer.Target.Raw) == 0) { Debug.LogError($"{owner}: Property ({variable.name}) is a ByteAddressBuffer, but the GraphicsBuffer '{buffer.name}' has no Target.Raw"); return false; }
                        if (variable.kind.EndsWith("structured") && (buffer.target & GraphicsBuffer.Target.Structured) == 0) { Debug.LogError($"{owner}: Property ({variable.name}) is a StructuredBuffer, but the GraphicsBuffer '{buffer.name}' has no Target.Structured"); return false; }
                        bind.handle = buffer.handle;
                        bind.offset = (ulong)property.offset;
                        bind.size = (ulong)property.size;
                        break;
                    case PropertyKind.Texture: case PropertyKind.Target:
                        if (!variable.isTexture) { Debug.LogError($"{owner}: Property ({variable.name}) is a buffer, but a texture is set"); return false; }
                        var target = property.kind == PropertyKind.Target ? property.target : new RenderTargetIdentifier((Texture)property.resource);
                        var texture = Resolve(target, $"{owner}, property ({variable.name})");
                        if (texture == null) return false;
                        var form = texture.dimension switch { TextureDimension.Tex2D => "flat", TextureDimension.Tex2DArray => "array", TextureDimension.Tex3D => "solid", TextureDimension.Cube => "cube", _ => texture.dimension.ToString() };
                        if (variable.kind.Replace("rw", "") != form) { Debug.LogError($"{owner}: Property ({variable.name}) wants a texture that is {variable.kind.Replace("rw", "")}, but '{texture.label}' is {form} ({texture.dimension})"); return false; }
                        if (variable.isWritten && !texture.isRandomWritten) { Debug.LogError($"{owner}: Property ({variable.name}) is written, but the texture '{texture.label}' was created without the UAV usage flag set (enableRandomWrite)"); return false; }
                        bind.handle = texture is RenderTexture rendered && (target.isDepthBuffer || target.type == BuiltinRenderTextureType.Depth) && rendered.depthHandle != 0 ? rendered.depthHandle : texture.handle;
                        bind.level = (uint)property.level;
                        break;
                    default:
                        Debug.LogError($"{owner}: Property ({variable.name}) is a resource, but a number is set");
                        return false;
                }
                binds.Add(bind);
            }
            return true;
        }

        /// A constant buffer of single values; those that were not set are zero, as Unity has them.
        bool Values(Variable variable, PropertySheet first, PropertySheet second, string owner, out uint handle)
        {
            handle = 0;
            bool any = variable.name == "$Globals" || variable.name == "type.$Globals";
            foreach (var (id, _, _, _) in variable.members) any |= Find(id, first, second, out _);
            if (!any) return false;
            var bytes = new byte[(variable.size + 15) / 16 * 16];
            foreach (var (id, name, offset, size) in variable.members)
            {
                if (!Find(id, first, second, out var property))
                {
                    if (builtIn.Any(name.StartsWith)) throw new NotImplementedException($"{owner}: the stand-in does not set {name}");
                    continue;
                }
                fixed (byte* at = &bytes[offset])
                    if (property.kind == PropertyKind.Integer) UnsafeUtility.MemCpy(at, &property.integer, Math.Min(4, size));
                    else UnsafeUtility.MemCpy(at, &property.value, Math.Min(property.kind == PropertyKind.Matrix ? 64 : property.kind == PropertyKind.Vector ? 16 : 4, size));
            }
            handle = Native.sg_create_buffer((ulong)bytes.Length, 1);
            transient.Add(handle);
            fixed (byte* at = bytes) Native.sg_write_buffer(handle, 0, at, (ulong)bytes.Length);
            return true;
        }

        /// `sampler_linear_clamp` by its words; `sampler` and a texture's name by that texture.
        uint Sampler(string name, PropertySheet first, PropertySheet second)
        {
            var lower = name.ToLowerInvariant();
            if (name.StartsWith("sampler") && Find(Shader.PropertyToID(name.Substring(7)), first, second, out var property))
            {
                var texture = property.kind == PropertyKind.Target ? property.target.texture : property.resource as Texture;
                if (texture is object) return (texture.filterMode == FilterMode.Point ? 0u : 1) | (uint)(texture.wrapMode == TextureWrapMode.Repeat ? 0 : texture.wrapMode == TextureWrapMode.Clamp ? 1 : 2) << 2;
            }
            uint filter = lower.Contains("point") ? 0u : lower.Contains("linear") ? 1u : throw new UnityException($"Unrecognized sampler '{name}' - does not match any texture and is not a recognized inline name (should contain filter and wrap modes).");
            uint wrap = lower.Contains("clamp") ? 1u : lower.Contains("repeat") ? 0u : lower.Contains("mirror") ? 2u : throw new UnityException($"Unrecognized sampler '{name}' - does not match any texture and is not a recognized inline name (should contain filter and wrap modes).");
            return filter | wrap << 2;
        }

        void Dispatch(ComputeShader shader, int index, int x, int y, int z)
        {
            if (shader == null) { Debug.LogError($"{where}: the compute shader was destroyed"); return; }
            var kernel = shader.kernels[index];
            var owner = $"Compute shader ({shader.label}): kernel '{kernel.entry}' (index {index})";
            if (x <= 0 || y <= 0 || z <= 0) { Debug.LogError($"{owner}: Thread group count must be above zero ({x}, {y}, {z})"); return; }
            if (x > 65535 || y > 65535 || z > 65535) { Debug.LogError($"{owner}: Thread group count is above the maximum allowed limit. Maximum allowed thread group count is 65535 ({x}, {y}, {z})"); return; }
            var program = shader.Program(index);
            if (program.handle == 0) { Debug.LogError($"{owner}: the kernel is not supported, or did not compile"); return; }
            binds.Clear();
            if (!Bindings(0, program.variables, kernel.sheet, shader.sheet, owner)) return;
            var all = binds.ToArray();
            fixed (Native.Bind* list = all) Native.sg_dispatch(program.handle, list, (uint)all.Length, (uint)x, (uint)y, (uint)z);
        }

        void Draw(CommandBuffer commands, ref Command command)
        {
            var material = (Material)command.a;
            if (material == null) { Debug.LogError($"{where}: the material was destroyed before the CommandBuffer was executed"); return; }
            if (!HasTarget()) return;
            var owner = $"Shader ({material.shader.label}), pass {command.i}";
            if (command.i >= material.shader.passes.Count) { Debug.LogError($"{owner}: there is no such pass"); return; }
            var pass = material.shader.passes[command.i];
            var program = material.shader.Program(pass, material.keywords);
            if (program == 0) return;
            block.Clear();
            for (int i = 0; i < command.n; i++) block.Put(commands.properties[command.m + i].Key, commands.properties[command.m + i].Value);
            binds.Clear();
            var variables = pass.variables[program];
            if (!Bindings(0, variables[0], block, material.sheet, owner) || !Bindings(1, variables[1], block, material.sheet, owner)) return;
            var state = pass.State(name => material.GetFloat(name));
            state.topology = (uint)command.l;
            if (invertsCulling && state.cull != 0) state.cull = 3 - state.cull;
            var all = binds.ToArray();
            foreach (var target in Targets(true, true))
                fixed (Native.Bind* list = all) Native.sg_draw(program, target, state, list, (uint)all.Length, (uint)command.j, (uint)(command.k * instanceMultiplier * (stereo == SinglePassStereoMode.Instancing ? 2 : 1)));
        }

        bool HasTarget()
        {
            if (hasTarget) return true;
            Debug.LogError($"{where}: nothing is the render target");
            return false;
        }

        void SetTarget(ref Command command)
        {
            // Of CameraTarget, colour and depth are two textures.
            RenderTexture color = command.from.type == BuiltinRenderTextureType.Depth ? null : Resolve(command.from, "SetRenderTarget") as RenderTexture, depth;
            if (command.to.type == BuiltinRenderTextureType.CameraTarget || command.to.type == BuiltinRenderTextureType.Depth) depth = camera.depth;
            else if (command.to.type == BuiltinRenderTextureType.CurrentActive) depth = bound.depth;
            else depth = Resolve(command.to, "SetRenderTarget") as RenderTexture;
            if (command.from.type != BuiltinRenderTextureType.None && command.from.type != BuiltinRenderTextureType.Depth && color == null) return;
            if (color != null && !color.hasColor) { if (depth == null) depth = color; color = null; }
            if (depth != null && depth.depthHandle == 0) depth = null;
            if (color == null && depth == null) { Debug.LogError($"{where}: neither colour nor depth"); return; }
            if (color != null && depth != null && (color.width != depth.width || color.height != depth.height)) { Debug.LogError($"{where}: Dimensions of color surface does not match dimensions of depth surface ({color.width} x {color.height}, {depth.width} x {depth.height})"); return; }
            if ((color ?? depth).dimension == TextureDimension.Tex3D) throw new NotImplementedException("the stand-in draws to no volumes");
            if (command.i >= (color ?? depth).volumeDepth) { Debug.LogError($"{where}: there is no depth slice {command.i}"); return; }
            bound = new BoundTarget { color = color, depth = depth, slice = command.i };
            hasTarget = true;
            viewport = Vector4.zero;
        }

        /// What is bound, one of each layer where all are.
        IEnumerable<Native.Target> Targets(bool color, bool depth)
        {
            var result = new List<Native.Target>();
            var any = bound.color ?? bound.depth;
            if (any == null || any.isDestroyed || any.handle == 0 || bound.depth is object && (bound.depth.isDestroyed || bound.depth.depthHandle == 0)) { Debug.LogError($"{where}: the render target was released"); return result; }
            int first = bound.slice < 0 ? 0 : bound.slice, last = bound.slice < 0 ? any.volumeDepth - 1 : bound.slice;
            if (color && depth && bound.slice < 0 && any.volumeDepth > 1) throw new NotImplementedException("the stand-in draws to one depth slice at a time");
            for (int slice = first; slice <= last; slice++)
            {
                var target = new Native.Target { colorLayer = (uint)slice, depthLayer = bound.depth is object && slice < bound.depth.volumeDepth ? (uint)slice : 0 };
                if (color && bound.color is object) target.color = bound.color.handle;
                if (depth && bound.depth is object) target.depth = bound.depth.depthHandle;
                if (viewport.z > 0) { target.x = viewport.x; target.y = viewport.y; target.width = viewport.z; target.height = viewport.w; }
                if (target.color != 0 || target.depth != 0) result.Add(target);
            }
            return result;
        }

        void CopyTexture(ref Command command)
        {
            Texture from = Resolve(command.from, "CopyTexture"), to = Resolve(command.to, "CopyTexture");
            if (from == null || to == null) return;
            if (from.m_Format != to.m_Format) { Debug.LogError($"{where}: Graphics.CopyTexture called with mismatching formats: {from.m_Format} and {to.m_Format}"); return; }
            int width = (int)command.vector.z, height = (int)command.vector.w, layers = 1;
            if (width == 0) { width = from.m_Width; height = from.m_Height; }
            if (command.i < 0) layers = from.m_Depth;
            var source = new Native.Region { texture = from.handle, x = (uint)command.vector.x, y = (uint)command.vector.y, z = (uint)Math.Max(command.i, 0) };
            var destination = new Native.Region { texture = to.handle, x = (uint)command.k, y = (uint)command.l, z = (uint)Math.Max(command.j, 0) };
            if (command.vector.x + width > from.m_Width || command.vector.y + height > from.m_Height || command.k + width > to.m_Width || command.l + height > to.m_Height || destination.z + layers > to.m_Depth || source.z + layers > from.m_Depth) { Debug.LogError($"{where}: Graphics.CopyTexture called with a region outside of a texture"); return; }
            Native.sg_copy_texture(source, destination, (uint)width, (uint)height, (uint)layers);
        }

        void Blit(ref Command command)
        {
            var from = Resolve(command.from, "Blit");
            var to = Resolve(command.to, "Blit") as RenderTexture;
            if (from == null || to == null) return;
            if (GraphicsFormatUtility.IsDepthFormat(from.m_Format) || !to.hasColor) throw new NotImplementedException("the stand-in blits no depth");
            Native.sg_blit(from.handle, (uint)Math.Max(command.from.slice, 0), new Native.Target { color = to.handle, colorLayer = (uint)Math.Max(command.to.slice, 0) }, 0);
            bound = new BoundTarget { color = to };
            hasTarget = true;
        }
    }
}
