using System;
using System.Collections.Generic;
using StandIn;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine.Experimental.Rendering;

namespace UnityEngine.Rendering
{
    public enum BuiltinRenderTextureType { PropertyName = -4, BufferPtr = -3, RenderTexture = -2, BindableTexture = -1, None = 0, CurrentActive = 1, CameraTarget = 2, Depth = 3, DepthNormals = 4, ResolvedDepth = 5 }

    public struct RenderTargetIdentifier : IEquatable<RenderTargetIdentifier>
    {
        internal BuiltinRenderTextureType type;
        internal int nameID, level, slice;
        internal CubemapFace face;
        internal Texture texture;
        internal bool isDepthBuffer;
        /// The slices of a whole array: as many draws as it has.
        public const int AllDepthSlices = -1;
        public RenderTargetIdentifier(BuiltinRenderTextureType type) : this(type, 0) { }
        public RenderTargetIdentifier(BuiltinRenderTextureType type, int mipLevel = 0, CubemapFace cubeFace = CubemapFace.Unknown, int depthSlice = 0) : this() { this.type = type; level = mipLevel; face = cubeFace; slice = depthSlice; }
        public RenderTargetIdentifier(string name) : this(Shader.PropertyToID(name)) { }
        public RenderTargetIdentifier(int nameID, int mipLevel = 0, CubemapFace cubeFace = CubemapFace.Unknown, int depthSlice = 0) : this() { type = BuiltinRenderTextureType.PropertyName; this.nameID = nameID; level = mipLevel; face = cubeFace; slice = depthSlice; }
        public RenderTargetIdentifier(Texture tex) : this(tex, 0) { }
        public RenderTargetIdentifier(Texture tex, int mipLevel = 0, CubemapFace cubeFace = CubemapFace.Unknown, int depthSlice = 0) : this() { type = tex is RenderTexture ? BuiltinRenderTextureType.RenderTexture : tex is null ? BuiltinRenderTextureType.None : BuiltinRenderTextureType.BindableTexture; texture = tex; level = mipLevel; face = cubeFace; slice = depthSlice; }
        public RenderTargetIdentifier(RenderTargetIdentifier renderTargetIdentifier, int mipLevel, CubemapFace cubeFace = CubemapFace.Unknown, int depthSlice = 0) { this = renderTargetIdentifier; level = mipLevel; face = cubeFace; slice = depthSlice; }
        public RenderTargetIdentifier(RenderBuffer buf, int mipLevel = 0, CubemapFace cubeFace = CubemapFace.Unknown, int depthSlice = 0) : this(buf.of, mipLevel, cubeFace, depthSlice) => isDepthBuffer = buf.isDepth;
        public static implicit operator RenderTargetIdentifier(BuiltinRenderTextureType type) => new RenderTargetIdentifier(type);
        public static implicit operator RenderTargetIdentifier(string name) => new RenderTargetIdentifier(name);
        public static implicit operator RenderTargetIdentifier(int nameID) => new RenderTargetIdentifier(nameID);
        public static implicit operator RenderTargetIdentifier(Texture tex) => new RenderTargetIdentifier(tex);
        public static implicit operator RenderTargetIdentifier(RenderBuffer buf) => new RenderTargetIdentifier(buf);
        public bool Equals(RenderTargetIdentifier rhs) => type == rhs.type && nameID == rhs.nameID && texture == rhs.texture && level == rhs.level && slice == rhs.slice && isDepthBuffer == rhs.isDepthBuffer;
        public override bool Equals(object obj) => obj is RenderTargetIdentifier identifier && Equals(identifier);
        public override int GetHashCode() => (int)type ^ nameID << 4 ^ (texture is null ? 0 : texture.instanceID) ^ slice << 20;
        public static bool operator ==(RenderTargetIdentifier lhs, RenderTargetIdentifier rhs) => lhs.Equals(rhs);
        public static bool operator !=(RenderTargetIdentifier lhs, RenderTargetIdentifier rhs) => !lhs.Equals(rhs);
        public override string ToString() => type == BuiltinRenderTextureType.PropertyName ? Shader.NameOf(nameID) : texture is null ? type.ToString() : texture.label;
    }

    enum Operation
    {
        SetBufferData, SetComputeProperty, SetComputeTexture, SetGlobal, SetGlobalTexture, Dispatch, Draw, SetTarget, Clear, SetViewport, CopyTexture, CopyBuffer, ReadBuffer, ReadTexture,
        GetTemporary, ReleaseTemporary, Blit, BeginSample, EndSample, Keyword, InvertCulling, Stereo, InstanceMultiplier,
    }

    /// One recorded command: what it needs of these.
    struct Command
    {
        internal Operation operation;
        internal object a, b;
        internal int i, j, k, l, m, n;
        internal long offset, length;
        internal Property property;
        internal RenderTargetIdentifier from, to;
        internal Vector4 vector;
        internal RenderTextureDescriptor descriptor;
    }

    /// Records into memory that is kept for the next recording: nothing is left for the garbage collector.
    public class CommandBuffer : IDisposable
    {
        internal Command[] commands = new Command[64];
        internal int count;
        /// What is to be written, as it was when it was recorded.
        internal byte[] data = new byte[4096];
        internal int used;
        /// The properties of blocks, as they were.
        internal readonly List<KeyValuePair<int, Property>> properties = new List<KeyValuePair<int, Property>>();
        internal CommandBufferExecutionFlags flags;
        bool isDisposed;
        int open;

        public CommandBuffer() => Live.Add(this);
        public string name { get; set; } = "";
        public int sizeInBytes => count * 64 + used;
        public void Dispose() { Clear(); if (!isDisposed) Live.Remove(this); isDisposed = true; GC.SuppressFinalize(this); }
        public void Release() => Dispose();
        public void Clear()
        {
            Array.Clear(commands, 0, count);
            count = used = open = 0;
            properties.Clear();
        }
        internal bool disposed => isDisposed;
        /// The same commands, which go their own way from here.
        internal CommandBuffer Copy()
        {
            var copy = new CommandBuffer { name = name, commands = (Command[])commands.Clone(), count = count, data = (byte[])data.Clone(), used = used, flags = flags, open = open };
            copy.properties.AddRange(properties);
            return copy;
        }
        ref Command Add(Operation operation, string member)
        {
            if (isDisposed) throw new ObjectDisposedException(nameof(CommandBuffer), $"{member}: the CommandBuffer '{name}' was disposed");
            if (count == commands.Length) Array.Resize(ref commands, count * 2);
            ref var command = ref commands[count++];
            command = default;
            command.operation = operation;
            return ref command;
        }
        int Keep(int bytes)
        {
            // A multiple of four, as the device wants it.
            int at = used;
            used += (bytes + 3) / 4 * 4;
            if (used > data.Length) Array.Resize(ref data, Math.Max(used, data.Length * 2));
            return at;
        }
        static T Some<T>(T value, string what) where T : class => value is null || value is Object item && item == null ? throw new ArgumentNullException(what) : value;

        public void SetExecutionFlags(CommandBufferExecutionFlags flags) { if (count > 0) throw new InvalidOperationException("SetExecutionFlags is called on an empty CommandBuffer only"); this.flags = flags; }

        // Buffers.
        public unsafe void SetBufferData<T>(GraphicsBuffer buffer, NativeArray<T> data) where T : struct => SetBufferData(buffer, data, 0, 0, data.Length);
        public unsafe void SetBufferData<T>(GraphicsBuffer buffer, NativeArray<T> data, int nativeBufferStartIndex, int graphicsBufferStartIndex, int count) where T : struct
        {
            Some(buffer, nameof(buffer)).Valid();
            if (count < 0 || nativeBufferStartIndex < 0 || nativeBufferStartIndex + count > data.Length) throw new ArgumentOutOfRangeException(nameof(count), $"Bad indices/count arguments (nativeBufferStartIndex:{nativeBufferStartIndex} graphicsBufferStartIndex:{graphicsBufferStartIndex} count:{count})");
            int size = UnsafeUtility.SizeOf<T>();
            buffer.CheckRange((long)graphicsBufferStartIndex * size, (long)count * size, nameof(count));
            int bytes = checked(count * size);
            Write(buffer, (byte*)data.GetUnsafeReadOnlyPtr() + (long)nativeBufferStartIndex * size, (long)graphicsBufferStartIndex * size, bytes);
        }
        unsafe void Write(GraphicsBuffer buffer, void* source, long at, int bytes)
        {
            if (bytes % 4 != 0 || at % 4 != 0) throw new ArgumentException("what is written to a buffer starts at, and is, a multiple of 4 bytes");
            int kept = Keep(bytes);
            fixed (byte* to = this.data) UnsafeUtility.MemCpy(to + kept, source, bytes);
            ref var command = ref Add(Operation.SetBufferData, "SetBufferData");
            command.a = buffer;
            command.i = kept;
            command.j = bytes;
            command.offset = at;
        }
        public unsafe void SetBufferData(GraphicsBuffer buffer, Array data)
        {
            Some(buffer, nameof(buffer)).Valid();
            var bytes = Pinned.Bytes(Some(data, nameof(data)));
            buffer.CheckRange(0, bytes.Length, nameof(data));
            fixed (byte* source = bytes) Write(buffer, source, 0, bytes.Length);
        }
        public void SetBufferData<T>(GraphicsBuffer buffer, List<T> data) where T : struct => SetBufferData(buffer, data.ToArray());
        public void SetBufferCounterValue(GraphicsBuffer buffer, uint counterValue) => throw new NotImplementedException("the stand-in's buffers have no counters");
        public void CopyBuffer(GraphicsBuffer source, GraphicsBuffer dest)
        {
            Some(source, nameof(source)).Valid();
            Some(dest, nameof(dest)).Valid();
            if ((source.target & GraphicsBuffer.Target.CopySource) == 0) throw new ArgumentException("Source buffer must be created with Target.CopySource", nameof(source));
            if ((dest.target & GraphicsBuffer.Target.CopyDestination) == 0) throw new ArgumentException("Destination buffer must be created with Target.CopyDestination", nameof(dest));
            if ((long)source.count * source.stride != (long)dest.count * dest.stride) throw new ArgumentException("Source and destination buffers must have the same size");
            ref var command = ref Add(Operation.CopyBuffer, "CopyBuffer");
            command.a = source;
            command.b = dest;
            command.length = (long)source.count * source.stride;
        }

        // Compute.
        void Compute(ComputeShader shader, int kernel, int id, Property property, string member)
        {
            Some(shader, "computeShader");
            if (kernel >= 0) shader.Valid(kernel);
            ref var command = ref Add(Operation.SetComputeProperty, member);
            command.a = shader;
            command.i = kernel;
            command.j = id;
            command.property = property;
        }
        public void SetComputeBufferParam(ComputeShader computeShader, int kernelIndex, int nameID, GraphicsBuffer buffer) { Some(buffer, nameof(buffer)).Valid(); Kernel(computeShader, kernelIndex); Compute(computeShader, kernelIndex, nameID, new Property { kind = PropertyKind.Buffer, resource = buffer }, "SetComputeBufferParam"); }
        public void SetComputeBufferParam(ComputeShader computeShader, int kernelIndex, string name, GraphicsBuffer buffer) => SetComputeBufferParam(computeShader, kernelIndex, Shader.PropertyToID(name), buffer);
        static void Kernel(ComputeShader shader, int index) => Some(shader, "computeShader").Valid(index);
        public void SetComputeTextureParam(ComputeShader computeShader, int kernelIndex, int nameID, RenderTargetIdentifier rt) => SetComputeTextureParam(computeShader, kernelIndex, nameID, rt, 0);
        public void SetComputeTextureParam(ComputeShader computeShader, int kernelIndex, string name, RenderTargetIdentifier rt) => SetComputeTextureParam(computeShader, kernelIndex, Shader.PropertyToID(name), rt, 0);
        public void SetComputeTextureParam(ComputeShader computeShader, int kernelIndex, string name, RenderTargetIdentifier rt, int mipLevel) => SetComputeTextureParam(computeShader, kernelIndex, Shader.PropertyToID(name), rt, mipLevel);
        public void SetComputeTextureParam(ComputeShader computeShader, int kernelIndex, int nameID, RenderTargetIdentifier rt, int mipLevel) { Kernel(computeShader, kernelIndex); Compute(computeShader, kernelIndex, nameID, new Property { kind = PropertyKind.Target, target = rt, level = mipLevel }, "SetComputeTextureParam"); }
        public void SetComputeTextureParam(ComputeShader computeShader, int kernelIndex, int nameID, RenderTargetIdentifier rt, int mipLevel, RenderTextureSubElement element)
        {
            if (element == RenderTextureSubElement.Stencil) throw new NotImplementedException("the stand-in has no stencil");
            rt.isDepthBuffer = element == RenderTextureSubElement.Depth;
            SetComputeTextureParam(computeShader, kernelIndex, nameID, rt, mipLevel);
        }
        public void SetComputeConstantBufferParam(ComputeShader computeShader, int nameID, GraphicsBuffer buffer, int offset, int size)
        {
            Constant(buffer, offset, size);
            Compute(computeShader, -1, nameID, new Property { kind = PropertyKind.Constant, resource = buffer, offset = offset, size = size }, "SetComputeConstantBufferParam");
        }
        public void SetComputeConstantBufferParam(ComputeShader computeShader, string name, GraphicsBuffer buffer, int offset, int size) => SetComputeConstantBufferParam(computeShader, Shader.PropertyToID(name), buffer, offset, size);
        static void Constant(GraphicsBuffer buffer, int offset, int size)
        {
            Some(buffer, nameof(buffer)).Valid();
            if ((buffer.target & GraphicsBuffer.Target.Constant) == 0) throw new ArgumentException("Constant buffers are made with GraphicsBuffer.Target.Constant", nameof(buffer));
            if (offset % SystemInfo.constantBufferOffsetAlignment != 0) throw new ArgumentException($"the offset of a constant buffer is a multiple of SystemInfo.constantBufferOffsetAlignment ({SystemInfo.constantBufferOffsetAlignment})", nameof(offset));
            if (size <= 0) throw new ArgumentException("a constant buffer's size is more than zero", nameof(size));
            buffer.CheckRange(offset, size, nameof(size));
        }
        public void SetComputeIntParam(ComputeShader computeShader, int nameID, int val) => Compute(computeShader, -1, nameID, new Property { kind = PropertyKind.Integer, integer = val }, "SetComputeIntParam");
        public void SetComputeIntParam(ComputeShader computeShader, string name, int val) => SetComputeIntParam(computeShader, Shader.PropertyToID(name), val);
        public void SetComputeFloatParam(ComputeShader computeShader, int nameID, float val) => Compute(computeShader, -1, nameID, new Property { kind = PropertyKind.Float, value = new Matrix4x4 { m00 = val } }, "SetComputeFloatParam");
        public void SetComputeFloatParam(ComputeShader computeShader, string name, float val) => SetComputeFloatParam(computeShader, Shader.PropertyToID(name), val);
        public void SetComputeVectorParam(ComputeShader computeShader, int nameID, Vector4 val) => Compute(computeShader, -1, nameID, Vector(val), "SetComputeVectorParam");
        public void SetComputeVectorParam(ComputeShader computeShader, string name, Vector4 val) => SetComputeVectorParam(computeShader, Shader.PropertyToID(name), val);
        public void SetComputeMatrixParam(ComputeShader computeShader, int nameID, Matrix4x4 val) => Compute(computeShader, -1, nameID, new Property { kind = PropertyKind.Matrix, value = val }, "SetComputeMatrixParam");
        public void SetComputeIntParams(ComputeShader computeShader, int nameID, params int[] values) => throw new NotImplementedException("the stand-in sets no arrays of integers");
        static Property Vector(Vector4 value) { var property = new Property { kind = PropertyKind.Vector }; property.value.SetColumn(0, value); return property; }
        public void DispatchCompute(ComputeShader computeShader, int kernelIndex, int threadGroupsX, int threadGroupsY, int threadGroupsZ)
        {
            Kernel(computeShader, kernelIndex);
            ref var command = ref Add(Operation.Dispatch, "DispatchCompute");
            command.a = computeShader;
            command.i = kernelIndex;
            command.j = threadGroupsX;
            command.k = threadGroupsY;
            command.l = threadGroupsZ;
        }
        public void DispatchCompute(ComputeShader computeShader, int kernelIndex, GraphicsBuffer indirectBuffer, uint argsOffset) => throw new NotImplementedException("the stand-in dispatches nothing indirectly");

        // Globals.
        void Global(int id, Property property, string member)
        {
            ref var command = ref Add(Operation.SetGlobal, member);
            command.j = id;
            command.property = property;
        }
        public void SetGlobalFloat(int nameID, float value) => Global(nameID, new Property { kind = PropertyKind.Float, value = new Matrix4x4 { m00 = value } }, "SetGlobalFloat");
        public void SetGlobalFloat(string name, float value) => SetGlobalFloat(Shader.PropertyToID(name), value);
        public void SetGlobalInt(int nameID, int value) => Global(nameID, new Property { kind = PropertyKind.Integer, integer = value }, "SetGlobalInt");
        public void SetGlobalVector(int nameID, Vector4 value) => Global(nameID, Vector(value), "SetGlobalVector");
        public void SetGlobalVector(string name, Vector4 value) => SetGlobalVector(Shader.PropertyToID(name), value);
        public void SetGlobalMatrix(int nameID, Matrix4x4 value) => Global(nameID, new Property { kind = PropertyKind.Matrix, value = value }, "SetGlobalMatrix");
        public void SetGlobalTexture(int nameID, RenderTargetIdentifier value) => Global(nameID, new Property { kind = PropertyKind.Target, target = value }, "SetGlobalTexture");
        public void SetGlobalTexture(string name, RenderTargetIdentifier value) => SetGlobalTexture(Shader.PropertyToID(name), value);
        public void SetGlobalBuffer(int nameID, GraphicsBuffer value) { Some(value, nameof(value)).Valid(); Global(nameID, new Property { kind = PropertyKind.Buffer, resource = value }, "SetGlobalBuffer"); }
        public void SetGlobalConstantBuffer(GraphicsBuffer buffer, int nameID, int offset, int size) { Constant(buffer, offset, size); Global(nameID, new Property { kind = PropertyKind.Constant, resource = buffer, offset = offset, size = size }, "SetGlobalConstantBuffer"); }
        public void EnableShaderKeyword(string keyword) { ref var command = ref Add(Operation.Keyword, "EnableShaderKeyword"); command.a = keyword; command.i = 1; }
        public void DisableShaderKeyword(string keyword) { ref var command = ref Add(Operation.Keyword, "DisableShaderKeyword"); command.a = keyword; }

        // Drawing.
        public void DrawProcedural(Matrix4x4 matrix, Material material, int shaderPass, MeshTopology topology, int vertexCount) => DrawProcedural(matrix, material, shaderPass, topology, vertexCount, 1, null);
        public void DrawProcedural(Matrix4x4 matrix, Material material, int shaderPass, MeshTopology topology, int vertexCount, int instanceCount) => DrawProcedural(matrix, material, shaderPass, topology, vertexCount, instanceCount, null);
        public void DrawProcedural(Matrix4x4 matrix, Material material, int shaderPass, MeshTopology topology, int vertexCount, int instanceCount, MaterialPropertyBlock properties)
        {
            Some(material, nameof(material));
            if (shaderPass < 0) throw new NotImplementedException("the stand-in draws one pass at a time");
            int first = this.properties.Count;
            if (properties != null) foreach (var pair in properties.sheet) this.properties.Add(pair);
            ref var command = ref Add(Operation.Draw, "DrawProcedural");
            command.a = material;
            command.i = shaderPass;
            command.j = vertexCount;
            command.k = instanceCount;
            command.l = (int)topology;
            command.m = first;
            command.n = this.properties.Count - first;
            command.property.value = matrix;
        }
        public void SetRenderTarget(RenderTargetIdentifier rt) => Target(rt, rt, 0, CubemapFace.Unknown, rt.slice);
        public void SetRenderTarget(RenderTargetIdentifier rt, int mipLevel) => Target(rt, rt, mipLevel, CubemapFace.Unknown, rt.slice);
        public void SetRenderTarget(RenderTargetIdentifier rt, int mipLevel, CubemapFace cubemapFace) => Target(rt, rt, mipLevel, cubemapFace, rt.slice);
        public void SetRenderTarget(RenderTargetIdentifier rt, int mipLevel, CubemapFace cubemapFace, int depthSlice) => Target(rt, rt, mipLevel, cubemapFace, depthSlice);
        public void SetRenderTarget(RenderTargetIdentifier rt, RenderBufferLoadAction loadAction, RenderBufferStoreAction storeAction) => Target(rt, rt, 0, CubemapFace.Unknown, rt.slice);
        public void SetRenderTarget(RenderTargetIdentifier color, RenderTargetIdentifier depth) => Target(color, depth, 0, CubemapFace.Unknown, color.slice);
        public void SetRenderTarget(RenderTargetIdentifier color, RenderTargetIdentifier depth, int mipLevel) => Target(color, depth, mipLevel, CubemapFace.Unknown, color.slice);
        public void SetRenderTarget(RenderTargetIdentifier color, RenderTargetIdentifier depth, int mipLevel, CubemapFace cubemapFace) => Target(color, depth, mipLevel, cubemapFace, color.slice);
        public void SetRenderTarget(RenderTargetIdentifier color, RenderTargetIdentifier depth, int mipLevel, CubemapFace cubemapFace, int depthSlice) => Target(color, depth, mipLevel, cubemapFace, depthSlice);
        public void SetRenderTarget(RenderTargetIdentifier color, RenderBufferLoadAction colorLoadAction, RenderBufferStoreAction colorStoreAction, RenderTargetIdentifier depth, RenderBufferLoadAction depthLoadAction, RenderBufferStoreAction depthStoreAction) => Target(color, depth, 0, CubemapFace.Unknown, color.slice);
        public void SetRenderTarget(RenderTargetIdentifier[] colors, RenderTargetIdentifier depth) { if (colors.Length != 1) throw new NotImplementedException("the stand-in has one target"); Target(colors[0], depth, 0, CubemapFace.Unknown, colors[0].slice); }
        void Target(RenderTargetIdentifier color, RenderTargetIdentifier depth, int level, CubemapFace face, int slice)
        {
            if (level != 0) throw new NotImplementedException("the stand-in draws to the first level only");
            ref var command = ref Add(Operation.SetTarget, "SetRenderTarget");
            command.from = color;
            command.to = depth;
            command.i = slice;
        }
        public void ClearRenderTarget(bool clearDepth, bool clearColor, Color backgroundColor) => ClearRenderTarget(clearDepth, clearColor, backgroundColor, 1);
        public void ClearRenderTarget(bool clearDepth, bool clearColor, Color backgroundColor, float depth)
        {
            ref var command = ref Add(Operation.Clear, "ClearRenderTarget");
            command.i = clearColor ? 1 : 0;
            command.j = clearDepth ? 1 : 0;
            command.vector = backgroundColor;
            command.property.value.m00 = depth;
        }
#if UNITY_6000_0_OR_NEWER
        public void ClearRenderTarget(RTClearFlags clearFlags, Color backgroundColor, float depth = 1, uint stencil = 0) => ClearRenderTarget((clearFlags & RTClearFlags.Depth) != 0, (clearFlags & RTClearFlags.Color) != 0, backgroundColor, depth);
#else
        public void ClearRenderTarget(RTClearFlags clearFlags, Color backgroundColor, float depth, uint stencil) => ClearRenderTarget((clearFlags & RTClearFlags.Depth) != 0, (clearFlags & RTClearFlags.Color) != 0, backgroundColor, depth);
#endif
        public void SetViewport(Rect pixelRect) { ref var command = ref Add(Operation.SetViewport, "SetViewport"); command.vector = new Vector4(pixelRect.x, pixelRect.y, pixelRect.width, pixelRect.height); }
        public void SetViewProjectionMatrices(Matrix4x4 view, Matrix4x4 proj) => throw new NotImplementedException("the stand-in has no view of its own in a command buffer");
        public void SetInvertCulling(bool invertCulling) { ref var command = ref Add(Operation.InvertCulling, "SetInvertCulling"); command.i = invertCulling ? 1 : 0; }
        /// What has every draw repeated for each eye, whatever it draws.
        public void SetInstanceMultiplier(uint multiplier) => Add(Operation.InstanceMultiplier, "SetInstanceMultiplier").i = checked((int)multiplier);
        /// The same for the built-in pipeline.
        public void SetSinglePassStereo(SinglePassStereoMode mode)
        {
            if (mode == SinglePassStereoMode.SideBySide || mode == SinglePassStereoMode.Multiview && !SystemInfo.supportsMultiview) throw new NotImplementedException($"the stand-in's headset does no {mode}");
            Add(Operation.Stereo, "SetSinglePassStereo").i = (int)mode;
        }
        public void Blit(Texture source, RenderTargetIdentifier dest) => Blit(new RenderTargetIdentifier(source), dest);
        public void Blit(RenderTargetIdentifier source, RenderTargetIdentifier dest) { ref var command = ref Add(Operation.Blit, "Blit"); command.from = source; command.to = dest; }
        public void Blit(RenderTargetIdentifier source, RenderTargetIdentifier dest, Material mat) => throw new NotImplementedException("the stand-in blits without materials; DrawProcedural draws with them");
        public void Blit(RenderTargetIdentifier source, RenderTargetIdentifier dest, Material mat, int pass) => throw new NotImplementedException("the stand-in blits without materials; DrawProcedural draws with them");
        public void DrawMesh(Mesh mesh, Matrix4x4 matrix, Material material) => DrawMesh(mesh, matrix, material, 0, -1, null);
        public void DrawMesh(Mesh mesh, Matrix4x4 matrix, Material material, int submeshIndex, int shaderPass, MaterialPropertyBlock properties) => throw new NotImplementedException("the stand-in draws no meshes");

        // Textures.
        public void CopyTexture(RenderTargetIdentifier src, RenderTargetIdentifier dst) { ref var command = ref Add(Operation.CopyTexture, "CopyTexture"); command.from = src; command.to = dst; command.i = command.j = -1; }
        public void CopyTexture(RenderTargetIdentifier src, int srcElement, RenderTargetIdentifier dst, int dstElement) { ref var command = ref Add(Operation.CopyTexture, "CopyTexture"); command.from = src; command.to = dst; command.i = srcElement; command.j = dstElement; }
        public void CopyTexture(RenderTargetIdentifier src, int srcElement, int srcMip, RenderTargetIdentifier dst, int dstElement, int dstMip) { if (srcMip != 0 || dstMip != 0) throw new NotImplementedException("the stand-in copies the first level only"); CopyTexture(src, srcElement, dst, dstElement); }
        public void CopyTexture(RenderTargetIdentifier src, int srcElement, int srcMip, int srcX, int srcY, int srcWidth, int srcHeight, RenderTargetIdentifier dst, int dstElement, int dstMip, int dstX, int dstY)
        {
            if (srcMip != 0 || dstMip != 0) throw new NotImplementedException("the stand-in copies the first level only");
            ref var command = ref Add(Operation.CopyTexture, "CopyTexture");
            command.from = src; command.to = dst; command.i = srcElement; command.j = dstElement;
            command.k = dstX; command.l = dstY;
            command.vector = new Vector4(srcX, srcY, srcWidth, srcHeight);
        }
        public void GetTemporaryRT(int nameID, RenderTextureDescriptor desc) => GetTemporaryRT(nameID, desc, FilterMode.Point);
        public void GetTemporaryRT(int nameID, RenderTextureDescriptor desc, FilterMode filter) { ref var command = ref Add(Operation.GetTemporary, "GetTemporaryRT"); command.j = nameID; command.descriptor = desc; command.i = (int)filter; }
        public void GetTemporaryRT(int nameID, int width, int height) => GetTemporaryRT(nameID, width, height, 0, FilterMode.Point, RenderTextureFormat.Default);
        public void GetTemporaryRT(int nameID, int width, int height, int depthBuffer, FilterMode filter, RenderTextureFormat format) => GetTemporaryRT(nameID, new RenderTextureDescriptor(width, height, format, depthBuffer), filter);
        public void GetTemporaryRT(int nameID, int width, int height, int depthBuffer, FilterMode filter, GraphicsFormat format) => GetTemporaryRT(nameID, new RenderTextureDescriptor(width, height, format, depthBuffer), filter);
        public void GetTemporaryRT(int nameID, int width, int height, int depthBuffer, FilterMode filter, GraphicsFormat format, int antiAliasing, bool enableRandomWrite) => GetTemporaryRT(nameID, new RenderTextureDescriptor(width, height, format, depthBuffer) { msaaSamples = antiAliasing, enableRandomWrite = enableRandomWrite }, filter);
        public void ReleaseTemporaryRT(int nameID) => Add(Operation.ReleaseTemporary, "ReleaseTemporaryRT").j = nameID;

        // Read-backs.
        public void RequestAsyncReadback(GraphicsBuffer src, Action<AsyncGPUReadbackRequest> callback) => RequestAsyncReadback(src, Some(src, nameof(src)).count * src.stride, 0, callback);
        public void RequestAsyncReadback(GraphicsBuffer src, int size, int offset, Action<AsyncGPUReadbackRequest> callback)
        {
            Some(src, nameof(src)).Valid();
            if (size <= 0) throw new ArgumentException("a read-back of no bytes", nameof(size));
            src.CheckRange(offset, size, nameof(size));
            ref var command = ref Add(Operation.ReadBuffer, "RequestAsyncReadback");
            command.a = src;
            command.b = Some(callback, nameof(callback));
            command.offset = offset;
            command.length = size;
        }
        public void RequestAsyncReadback(Texture src, Action<AsyncGPUReadbackRequest> callback) => RequestAsyncReadback(src, 0, callback);
        public void RequestAsyncReadback(Texture src, int mipIndex, Action<AsyncGPUReadbackRequest> callback)
        {
            if (mipIndex != 0) throw new NotImplementedException("the stand-in reads the first level only");
            ref var command = ref Add(Operation.ReadTexture, "RequestAsyncReadback");
            command.a = Some(src, nameof(src));
            command.b = Some(callback, nameof(callback));
        }
        public void WaitAllAsyncReadbackRequests() => throw new NotImplementedException("the stand-in's command buffers do not wait");

        // Samples, fences.
        public void BeginSample(string name) { open++; Add(Operation.BeginSample, "BeginSample").a = name; }
        public void EndSample(string name) { open--; Add(Operation.EndSample, "EndSample").a = name; }
        public void BeginSample(UnityEngine.Profiling.CustomSampler sampler) => BeginSample("sampler");
        public void EndSample(UnityEngine.Profiling.CustomSampler sampler) => EndSample("sampler");
        /// Samples without an end.
        internal int openSamples => open;
        public GraphicsFence CreateAsyncGraphicsFence() => throw new NotImplementedException("the stand-in has one queue");
        public void IssuePluginEvent(IntPtr callback, int eventID) => throw new NotImplementedException("the stand-in calls no plugins");
    }

    public struct GraphicsFence { public bool passed => throw new NotImplementedException("the stand-in has one queue"); }
    public enum RenderTextureSubElement { Color, Depth, Stencil, Default }
    public enum SinglePassStereoMode { None, SideBySide, Instancing, Multiview }
}
