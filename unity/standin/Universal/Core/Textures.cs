// Textures that pipelines share among cameras, and how these are drawn for headsets.
using System;

namespace UnityEngine.Experimental.Rendering
{
    public class XRPass
    {
        internal int views = 1;
        public bool enabled { get; internal set; }
        public bool singlePassEnabled => enabled && views > 1;
        public int viewCount => views;
        public int multipassId { get; internal set; }
    }
}

namespace UnityEngine.Rendering
{
    public class RTHandle
    {
        readonly RenderTexture texture;
        readonly RenderTargetIdentifier identifier;
        public RenderTexture rt => texture;
        public RenderTargetIdentifier nameID => identifier;
        public string name => texture != null ? texture.name : "";
        internal RTHandle(RenderTexture texture) { this.texture = texture; identifier = new RenderTargetIdentifier(texture, 0, CubemapFace.Unknown, RenderTargetIdentifier.AllDepthSlices); }
        public static implicit operator RenderTargetIdentifier(RTHandle handle) => handle != null ? handle.nameID : default;
        public static implicit operator Texture(RTHandle handle) => handle?.rt;
        public static implicit operator RenderTexture(RTHandle handle) => handle?.rt;
        public void Release() { }
    }

    public static class RTHandles
    {
        public static RTHandle Alloc(RenderTexture tex) => new RTHandle(tex);
    }

    public static class TextureXR
    {
        public static bool useTexArray => true;
        public static int slices => 1;
        public static TextureDimension dimension => TextureDimension.Tex2DArray;
    }

    public static class CommandBufferPool
    {
        static readonly System.Collections.Generic.Stack<CommandBuffer> spare = new System.Collections.Generic.Stack<CommandBuffer>();
        public static CommandBuffer Get() => Get("");
        public static CommandBuffer Get(string name)
        {
            var cmd = spare.Count > 0 ? spare.Pop() : new CommandBuffer();
            // The pool's own is no one's leak.
            StandIn.Live.Remove(cmd);
            cmd.name = name;
            return cmd;
        }
        public static void Release(CommandBuffer buffer)
        {
            if (spare.Contains(buffer)) throw new InvalidOperationException("Trying to release a command buffer that is already released to the pool.");
            buffer.Clear();
            spare.Push(buffer);
        }
    }

    public class ProfilingSampler
    {
        public string name { get; }
        public ProfilingSampler(string name) => this.name = name;
    }
}
