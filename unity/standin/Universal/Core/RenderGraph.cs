#if UNITY_6000_0_OR_NEWER
// A render graph that runs its passes in the order in which they were recorded, and culls those that nothing is seen of.
using System;
using System.Collections.Generic;

namespace UnityEngine.Rendering
{
    public abstract class ContextItem { public abstract void Reset(); }

    public class ContextContainer : IDisposable
    {
        readonly Dictionary<Type, ContextItem> items = new Dictionary<Type, ContextItem>();
        public T Get<T>() where T : ContextItem, new() => items.TryGetValue(typeof(T), out var item) ? (T)item : throw new InvalidOperationException($"Type {typeof(T).FullName} has not been created yet.");
        public T Create<T>() where T : ContextItem, new() { var made = new T(); items.Add(typeof(T), made); return made; }
        public bool Contains<T>() where T : ContextItem, new() => items.ContainsKey(typeof(T));
        public void Dispose() => items.Clear();
    }

    public class BaseCommandBuffer
    {
        internal CommandBuffer wrapped;
        internal BaseCommandBuffer() { }
    }
    public class UnsafeCommandBuffer : BaseCommandBuffer { internal UnsafeCommandBuffer() { } }

    public struct CommandBufferHelpers
    {
        public static CommandBuffer GetNativeCommandBuffer(UnsafeCommandBuffer baseBuffer) => baseBuffer.wrapped;
    }
}

namespace UnityEngine.Rendering.RenderGraphModule
{
    [Flags]
    public enum AccessFlags { None = 0, Read = 1, Write = 2, Discard = 4, WriteAll = Write | Discard, ReadWrite = Read | Write }

    public delegate void BaseRenderFunc<PassData, ContextType>(PassData data, ContextType renderGraphContext) where PassData : class, new();

    public struct TextureHandle
    {
        internal RTHandle handle;
        internal RenderGraph graph;
        internal int execution;
        public static TextureHandle nullHandle => default;
        public bool IsValid() => handle != null;
        static RTHandle Resolve(TextureHandle texture)
        {
            if (!texture.IsValid()) return null;
            // As the graph itself: outside of a pass, and in one that did not say so, there is no texture.
            if (texture.execution != texture.graph.execution) throw new InvalidOperationException("Trying to use a texture handle of another execution of the render graph.");
            if (texture.graph.running == null) throw new InvalidOperationException("Trying to access a RTHandle outside of a render graph pass.");
            if (!texture.graph.running.used.Contains(texture.handle)) throw new InvalidOperationException($"Pass '{texture.graph.running.name}' uses the texture '{texture.handle.name}' without having declared it.");
            return texture.handle;
        }
        public static implicit operator RTHandle(TextureHandle texture) => Resolve(texture);
        public static implicit operator RenderTargetIdentifier(TextureHandle texture) => texture.IsValid() ? Resolve(texture).nameID : default;
        public static implicit operator RenderTexture(TextureHandle texture) => texture.IsValid() ? Resolve(texture).rt : null;
    }

    public class UnsafeGraphContext { public UnsafeCommandBuffer cmd; }

    public interface IBaseRenderGraphBuilder : IDisposable
    {
        void UseTexture(in TextureHandle input, AccessFlags flags = AccessFlags.Read);
        void UseAllGlobalTextures(bool enable);
        void AllowPassCulling(bool value);
        void AllowGlobalStateModification(bool value);
    }

    public interface IUnsafeRenderGraphBuilder : IBaseRenderGraphBuilder
    {
        void SetRenderFunc<PassData>(BaseRenderFunc<PassData, UnsafeGraphContext> renderFunc) where PassData : class, new();
    }

    abstract class UnsafePass : IUnsafeRenderGraphBuilder
    {
        internal string name;
        internal RenderGraph graph;
        internal bool isCullable, mayChangeGlobals;
        internal readonly HashSet<RTHandle> used = new HashSet<RTHandle>();
        bool isDisposed;

        internal virtual void Begin(string name, RenderGraph graph)
        {
            (this.name, this.graph) = (name, graph);
            (isCullable, mayChangeGlobals, isDisposed) = (true, false, false);
            used.Clear();
        }
        public void UseTexture(in TextureHandle input, AccessFlags flags = AccessFlags.Read)
        {
            if (!input.IsValid()) throw new ArgumentException("Trying to use an invalid resource (pass " + name + ").");
            if (flags == AccessFlags.None) throw new ArgumentException("UseTexture needs to be told what the texture is used for");
            used.Add(input.handle);
        }
        public void UseAllGlobalTextures(bool enable) { }
        public void AllowPassCulling(bool value) => isCullable = value;
        public void AllowGlobalStateModification(bool value) => mayChangeGlobals = value;
        public abstract void SetRenderFunc<PassData>(BaseRenderFunc<PassData, UnsafeGraphContext> renderFunc) where PassData : class, new();
        protected abstract bool HasFunction { get; }
        internal abstract void Run(UnsafeGraphContext context);
        public void Dispose()
        {
            if (isDisposed) return;
            isDisposed = true;
            if (!HasFunction) throw new InvalidOperationException($"Pass '{name}' has no render function.");
            graph.passes.Add(this);
        }
    }

    /// Passes and their data are used again, with what was in them.
    sealed class UnsafePass<Data> : UnsafePass where Data : class, new()
    {
        internal readonly Data data = new Data();
        BaseRenderFunc<Data, UnsafeGraphContext> function;

        internal override void Begin(string name, RenderGraph graph) { base.Begin(name, graph); function = null; }
        protected override bool HasFunction => function != null;
        public override void SetRenderFunc<PassData>(BaseRenderFunc<PassData, UnsafeGraphContext> renderFunc)
        {
            if (renderFunc.Target != null)
                using (StandIn.Callbacks.Own())
                    if (!renderFunc.Target.GetType().Name.StartsWith("<>c") || renderFunc.Target.GetType().GetFields(System.Reflection.BindingFlags.Instance | System.Reflection.BindingFlags.Public).Length > 0)
                        throw new InvalidOperationException($"The render function of pass '{name}' captures something; it must be static.");
            function = (BaseRenderFunc<Data, UnsafeGraphContext>)(object)renderFunc;
        }
        internal override void Run(UnsafeGraphContext context) => function(data, context);
    }

    public class RenderGraph
    {
        internal readonly List<UnsafePass> passes = new List<UnsafePass>();
        readonly Dictionary<Type, Stack<UnsafePass>> spare = new Dictionary<Type, Stack<UnsafePass>>();
        readonly UnsafeCommandBuffer commands = new UnsafeCommandBuffer();
        internal UnsafePass running;
        readonly UnsafeGraphContext context = new UnsafeGraphContext();
        internal RenderGraph() { }
        /// Counts executions: what was imported for one is nothing to the next.
        internal int execution;
        public TextureHandle ImportTexture(RTHandle rt) => new TextureHandle { handle = rt, graph = this, execution = execution };
        public IUnsafeRenderGraphBuilder AddUnsafePass<PassData>(string passName, out PassData passData, ProfilingSampler sampler, [System.Runtime.CompilerServices.CallerFilePath] string file = "", [System.Runtime.CompilerServices.CallerLineNumber] int line = 0) where PassData : class, new() => AddUnsafePass(passName, out passData, file, line);
        public IUnsafeRenderGraphBuilder AddUnsafePass<PassData>(string passName, out PassData passData, [System.Runtime.CompilerServices.CallerFilePath] string file = "", [System.Runtime.CompilerServices.CallerLineNumber] int line = 0) where PassData : class, new()
        {
            UnsafePass<PassData> pass;
            using (StandIn.Callbacks.Own()) pass = spare.TryGetValue(typeof(UnsafePass<PassData>), out var kept) && kept.Count > 0 ? (UnsafePass<PassData>)kept.Pop() : new UnsafePass<PassData>();
            pass.Begin(passName, this);
            passData = pass.data;
            return pass;
        }
        internal void Execute(CommandBuffer cmd)
        {
            commands.wrapped = cmd;
            context.cmd = commands;
            foreach (var pass in passes)
            {
                if (!spare.TryGetValue(pass.GetType(), out var kept)) spare[pass.GetType()] = kept = new Stack<UnsafePass>();
                kept.Push(pass);
                // It writes nothing that the graph shows.
                if (pass.isCullable) continue;
                running = pass;
                try { using (StandIn.Callbacks.Counted()) pass.Run(context); }
                finally { running = null; }
            }
            passes.Clear();
            execution++;
        }
    }
}
#endif
