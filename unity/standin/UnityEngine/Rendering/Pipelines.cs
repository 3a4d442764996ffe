using System;
using System.Collections.Generic;
using System.Linq;

namespace UnityEngine
{
    public class Graphics
    {
        public static void ExecuteCommandBuffer(UnityEngine.Rendering.CommandBuffer buffer)
        {
            StandIn.Threads.Main("ExecuteCommandBuffer");
            if (buffer == null) throw new ArgumentNullException(nameof(buffer));
            var execution = StandIn.Engine.current ?? new StandIn.Execution();
            execution.Run(buffer);
            if (StandIn.Engine.current == null) execution.End();
        }
        public static void Blit(Texture source, RenderTexture dest)
        {
            using (var commands = new UnityEngine.Rendering.CommandBuffer { name = "Blit" }) { commands.Blit(source, dest); ExecuteCommandBuffer(commands); }
        }
        public static void Blit(Texture source, RenderTexture dest, Material mat) => throw new NotImplementedException("the stand-in blits without materials");
        public static void Blit(Texture source, RenderTexture dest, Material mat, int pass) => throw new NotImplementedException("the stand-in blits without materials");
        public static void CopyTexture(Texture src, Texture dst)
        {
            using (var commands = new UnityEngine.Rendering.CommandBuffer { name = "CopyTexture" }) { commands.CopyTexture(src, dst); ExecuteCommandBuffer(commands); }
        }
        public static void CopyTexture(Texture src, int srcElement, Texture dst, int dstElement)
        {
            using (var commands = new UnityEngine.Rendering.CommandBuffer { name = "CopyTexture" }) { commands.CopyTexture(src, srcElement, dst, dstElement); ExecuteCommandBuffer(commands); }
        }
        public static void SetRenderTarget(RenderTexture rt) => RenderTexture.active = rt;
    }

    public sealed class GL
    {
        public static bool sRGBWrite { get; set; }
        public static bool invertCulling { get; set; }
        /// Of OpenGL's projection, that of the device: depth from 1 to 0, and rows upside down where a texture is drawn to.
        public static Matrix4x4 GetGPUProjectionMatrix(Matrix4x4 proj, bool renderIntoTexture)
        {
            for (int c = 0; c < 4; c++)
            {
                if (renderIntoTexture && SystemInfo.graphicsUVStartsAtTop) proj[1, c] = -proj[1, c];
                proj[2, c] = SystemInfo.usesReversedZBuffer ? .5f * (proj[3, c] - proj[2, c]) : .5f * (proj[3, c] + proj[2, c]);
            }
            return proj;
        }
        public static void Clear(bool clearDepth, bool clearColor, Color backgroundColor) => throw new NotImplementedException("the stand-in clears by command buffers only");
    }
}

namespace UnityEngine.Rendering
{
    public abstract class RenderPipelineAsset : ScriptableObject
    {
        protected abstract RenderPipeline CreatePipeline();
        internal RenderPipeline Make() => CreatePipeline();
        public virtual Material defaultMaterial => null;
        protected virtual void OnValidate() { }
        protected virtual void OnDisable() { }
    }
    public abstract class RenderPipelineAsset<TRenderPipeline> : RenderPipelineAsset where TRenderPipeline : RenderPipeline { }
    public abstract class RenderPipeline
    {
        public bool disposed { get; private set; }
#if UNITY_6000_3_OR_NEWER
        protected virtual void Render(ScriptableRenderContext context, Camera[] cameras) { }
#else
        protected abstract void Render(ScriptableRenderContext context, Camera[] cameras);
#endif
        protected virtual void Render(ScriptableRenderContext context, List<Camera> cameras) => Render(context, cameras.ToArray());
        internal void InternalRender(ScriptableRenderContext context, List<Camera> cameras) => Render(context, cameras);
        internal void Dispose() { Dispose(true); disposed = true; }
        protected virtual void Dispose(bool disposing) { }
        protected static void BeginFrameRendering(ScriptableRenderContext context, Camera[] cameras) => RenderPipelineManager.BeginContext(context, cameras.ToList());
        protected static void BeginContextRendering(ScriptableRenderContext context, List<Camera> cameras) => RenderPipelineManager.BeginContext(context, cameras);
        protected static void EndContextRendering(ScriptableRenderContext context, List<Camera> cameras) => RenderPipelineManager.EndContext(context, cameras);
        protected static void BeginCameraRendering(ScriptableRenderContext context, Camera camera) => RenderPipelineManager.BeginCamera(context, camera);
        protected static void EndCameraRendering(ScriptableRenderContext context, Camera camera) => RenderPipelineManager.EndCamera(context, camera);
    }
    public static class RenderPipelineManager
    {
        public static RenderPipeline currentPipeline => StandIn.Engine.pipeline;
        public static event Action<ScriptableRenderContext, List<Camera>> beginContextRendering, endContextRendering;
        public static event Action<ScriptableRenderContext, Camera[]> beginFrameRendering;
        public static event Action<ScriptableRenderContext, Camera[]> endFrameRendering;
        public static event Action<ScriptableRenderContext, Camera> beginCameraRendering, endCameraRendering;
        public static event Action activeRenderPipelineTypeChanged, activeRenderPipelineCreated, activeRenderPipelineDisposed;
        public static event Action<RenderPipelineAsset, RenderPipelineAsset> activeRenderPipelineAssetChanged;
        internal static void BeginContext(ScriptableRenderContext context, List<Camera> cameras) { beginFrameRendering?.Invoke(context, cameras.ToArray()); beginContextRendering?.Invoke(context, cameras); }
        internal static void EndContext(ScriptableRenderContext context, List<Camera> cameras) { endFrameRendering?.Invoke(context, cameras.ToArray()); endContextRendering?.Invoke(context, cameras); }
        internal static void BeginCamera(ScriptableRenderContext context, Camera camera) { using (StandIn.Callbacks.Counted()) beginCameraRendering?.Invoke(context, camera); }
        internal static void EndCamera(ScriptableRenderContext context, Camera camera) { using (StandIn.Callbacks.Counted()) endCameraRendering?.Invoke(context, camera); }
        internal static void Created() => activeRenderPipelineCreated?.Invoke();
        internal static void Disposed() => activeRenderPipelineDisposed?.Invoke();
        internal static void Changed(RenderPipelineAsset from, RenderPipelineAsset to) { activeRenderPipelineAssetChanged?.Invoke(from, to); if (from?.GetType() != to?.GetType()) activeRenderPipelineTypeChanged?.Invoke(); }
        internal static void Forget()
        {
            beginContextRendering = endContextRendering = null;
            beginFrameRendering = endFrameRendering = null;
            beginCameraRendering = endCameraRendering = null;
            activeRenderPipelineTypeChanged = activeRenderPipelineCreated = activeRenderPipelineDisposed = null;
            activeRenderPipelineAssetChanged = null;
        }
    }
    public struct ScriptableRenderContext : IEquatable<ScriptableRenderContext>
    {
        internal List<CommandBuffer> queued;
        /// Kept as it is now; executed with `Submit`.
        public void ExecuteCommandBuffer(CommandBuffer commandBuffer)
        {
            StandIn.Threads.Main("ScriptableRenderContext.ExecuteCommandBuffer");
            if (commandBuffer == null) throw new ArgumentNullException(nameof(commandBuffer));
            if (queued == null) throw new InvalidOperationException("The ScriptableRenderContext instance has not been correctly initialized.");
            using (StandIn.Callbacks.Own()) queued.Add(commandBuffer.Copy());
        }
        public void Submit()
        {
            if (queued == null) throw new InvalidOperationException("The ScriptableRenderContext instance has not been correctly initialized.");
            foreach (var commands in queued) { Graphics.ExecuteCommandBuffer(commands); commands.Dispose(); }
            queued.Clear();
        }
        public void SetupCameraProperties(Camera camera, bool stereoSetup = false) => StandIn.Engine.Setup(camera);
        public void DrawSkybox(Camera camera) => throw new NotImplementedException("the stand-in's context draws no sky");
        public bool Equals(ScriptableRenderContext other) => queued == other.queued;
    }
    public sealed class GraphicsSettings : Object
    {
        GraphicsSettings() { }
        static RenderPipelineAsset asset;
        public static RenderPipelineAsset defaultRenderPipeline { get => asset; set { var from = currentRenderPipeline; asset = value; StandIn.Engine.PipelineChanged(from, currentRenderPipeline); } }
        public static RenderPipelineAsset renderPipelineAsset { get => defaultRenderPipeline; set => defaultRenderPipeline = value; }
        public static RenderPipelineAsset currentRenderPipeline => QualitySettings.renderPipeline != null ? QualitySettings.renderPipeline : asset != null ? asset : null;
        public static bool lightsUseLinearIntensity { get; set; }
        public static bool lightsUseColorTemperature { get; set; }
        public static bool useScriptableRenderPipelineBatching { get; set; }
        public static bool HasShaderDefine(BuiltinShaderDefine defineHash) => false;
    }
    public enum BuiltinShaderDefine { UNITY_NO_DXT5nm }
}

namespace UnityEngine
{
    public sealed class QualitySettings : Object
    {
        QualitySettings() { }
        static UnityEngine.Rendering.RenderPipelineAsset asset;
        public static UnityEngine.Rendering.RenderPipelineAsset renderPipeline { get => asset; set { var from = UnityEngine.Rendering.GraphicsSettings.currentRenderPipeline; asset = value; StandIn.Engine.PipelineChanged(from, UnityEngine.Rendering.GraphicsSettings.currentRenderPipeline); } }
        public static ColorSpace activeColorSpace { get; internal set; } = ColorSpace.Linear;
        public static ColorSpace desiredColorSpace => activeColorSpace;
        public static int antiAliasing { get; set; }
        public static int vSyncCount { get; set; } = 1;
        public static string[] names => new[] { "High" };
        public static int GetQualityLevel() => 0;
    }
}
