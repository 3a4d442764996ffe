// The part of the Universal Render Pipeline that passes of one's own meet. StandInUniversal draws a camera with it.
using System;
using System.Collections.Generic;
#if UNITY_6000_0_OR_NEWER
using UnityEngine.Rendering.RenderGraphModule;
#endif

namespace UnityEngine.Rendering.Universal
{
    public enum RenderPassEvent
    {
        BeforeRendering = 0, BeforeRenderingShadows = 50, AfterRenderingShadows = 100, BeforeRenderingPrePasses = 150, AfterRenderingPrePasses = 200,
        BeforeRenderingGbuffer = 210, AfterRenderingGbuffer = 220, BeforeRenderingDeferredLights = 230, AfterRenderingDeferredLights = 240,
        BeforeRenderingOpaques = 250, AfterRenderingOpaques = 300, BeforeRenderingSkybox = 350, AfterRenderingSkybox = 400, BeforeRenderingTransparents = 450,
        AfterRenderingTransparents = 500, BeforeRenderingPostProcessing = 550, AfterRenderingPostProcessing = 600, AfterRendering = 1000,
    }

    [Flags]
    public enum ScriptableRenderPassInput { None = 0, Depth = 1, Normal = 2, Color = 4, Motion = 8 }

    public enum CameraRenderType { Base, Overlay }

    public enum AntialiasingMode { None, FastApproximateAntialiasing, SubpixelMorphologicalAntiAliasing, TemporalAntiAliasing }

    public abstract class ScriptableRenderer
    {
        internal readonly List<ScriptableRenderPass> queue = new List<ScriptableRenderPass>();
        internal readonly List<ScriptableRendererFeature> features = new List<ScriptableRendererFeature>();
        internal RTHandle color, depth;
        internal ScriptableRenderer() { }
#if !UNITY_6000_3_OR_NEWER
        public RTHandle cameraColorTargetHandle => StandInUniversal.IsExecuting ? color : throw new InvalidOperationException("You can only call cameraColorTarget inside the scope of a ScriptableRenderPass.");
        public RTHandle cameraDepthTargetHandle => StandInUniversal.IsExecuting ? depth : throw new InvalidOperationException("You can only call cameraDepthTarget inside the scope of a ScriptableRenderPass.");
#endif
        public void EnqueuePass(ScriptableRenderPass pass) => queue.Add(pass);
    }

    public sealed class UniversalRenderer : ScriptableRenderer { internal UniversalRenderer() { } }

    public class UniversalRenderPipelineAsset
#if UNITY_6000_0_OR_NEWER
        : RenderPipelineAsset<UniversalRenderPipeline>
#else
        : RenderPipelineAsset
#endif
    {
        internal readonly UniversalRenderer renderer = new UniversalRenderer();
        float scale = 1f;
        public ScriptableRenderer scriptableRenderer => renderer;
        public float renderScale { get => scale; set => scale = Mathf.Clamp(value, .1f, 2f); }
        protected override RenderPipeline CreatePipeline() => new UniversalRenderPipeline(this);
    }

    public class UniversalAdditionalCameraData : MonoBehaviour
    {
        public ScriptableRenderer scriptableRenderer => (GraphicsSettings.currentRenderPipeline as UniversalRenderPipelineAsset)?.renderer;
        public AntialiasingMode antialiasing { get; set; }
        public bool renderPostProcessing { get; set; }

        readonly List<Camera> stack = new List<Camera>();
        [SerializeField] bool m_ClearDepth = true;
        public CameraRenderType renderType { get; set; }
        public bool clearDepth => m_ClearDepth;
        public List<Camera> cameraStack
        {
            get
            {
                if (renderType == CameraRenderType.Base) return stack;
                Debug.LogWarning($"{name}: This camera is of {renderType} type. Only Base cameras can have a camera stack.");
                return null;
            }
        }
    }

    public static class CameraExtensions
    {
        public static UniversalAdditionalCameraData GetUniversalAdditionalCameraData(this Camera camera)
        {
            if (!camera.TryGetComponent<UniversalAdditionalCameraData>(out var data)) data = camera.gameObject.AddComponent<UniversalAdditionalCameraData>();
            return data;
        }
    }

    public struct CameraData
    {
        internal Matrix4x4[] views, projections;
        internal bool isFlipped;
#if UNITY_6000_0_OR_NEWER
        public Camera camera { get; internal set; }
        public RenderTextureDescriptor cameraTargetDescriptor { get; internal set; }
        public ScriptableRenderer renderer { get; internal set; }
        public AntialiasingMode antialiasing { get; internal set; }
#else
        public Camera camera;
        public RenderTextureDescriptor cameraTargetDescriptor;
        public ScriptableRenderer renderer;
        public AntialiasingMode antialiasing;
#endif
        public Matrix4x4 GetViewMatrix(int viewIndex = 0) => views[viewIndex];
        public Matrix4x4 GetProjectionMatrix(int viewIndex = 0) => projections[viewIndex];
#if !UNITY_6000_3_OR_NEWER
        public bool IsCameraProjectionMatrixFlipped() => isFlipped;
#endif
    }

    public struct RenderingData { public CameraData cameraData; }

#if UNITY_6000_0_OR_NEWER
    public class UniversalCameraData : ContextItem
    {
        internal Matrix4x4[] views, projections;
        internal bool isFlipped = true;
        public Camera camera;
        public RenderTextureDescriptor cameraTargetDescriptor;
        public ScriptableRenderer renderer;
        public AntialiasingMode antialiasing;
        public Experimental.Rendering.XRPass xr { get; internal set; } = new Experimental.Rendering.XRPass();
        public Matrix4x4 GetViewMatrix(int viewIndex = 0) => views[viewIndex];
        public Matrix4x4 GetProjectionMatrix(int viewIndex = 0) => projections[viewIndex];
        public bool IsRenderTargetProjectionMatrixFlipped(RTHandle color, RTHandle depth = null) => isFlipped;
        public override void Reset() { }
    }

    public abstract class UniversalResourceDataBase : ContextItem { }

    public class UniversalResourceData : UniversalResourceDataBase
    {
        public TextureHandle activeColorTexture { get; internal set; }
        public TextureHandle activeDepthTexture { get; internal set; }
        public TextureHandle cameraDepthTexture { get; internal set; }
        public bool isActiveTargetBackBuffer { get; internal set; }
        public override void Reset() { }
    }
#endif

    public abstract class ScriptableRenderPass
    {
        internal ScriptableRenderPassInput input;
        public ScriptableRenderPass() { }
        public RenderPassEvent renderPassEvent { get; set; } = RenderPassEvent.AfterRenderingOpaques;
        protected internal ProfilingSampler profilingSampler { get; set; }
        public void ConfigureInput(ScriptableRenderPassInput passInput) => input = passInput;
#if UNITY_6000_0_OR_NEWER
        public bool requiresIntermediateTexture { get; set; }
        public virtual void RecordRenderGraph(RenderGraph renderGraph, ContextContainer frameData) => Debug.LogWarning("The render pass " + this + " does not have an implementation of the RecordRenderGraph method.");
#endif
        // From 6000.3 on only projects that define URP_COMPATIBILITY_MODE have it, and from 6000.4 on none.
#if !UNITY_6000_3_OR_NEWER
#if UNITY_6000_0_OR_NEWER
        public virtual void Execute(ScriptableRenderContext context, ref RenderingData renderingData) { }
#else
        public abstract void Execute(ScriptableRenderContext context, ref RenderingData renderingData);
#endif
#endif
    }

    [AttributeUsage(AttributeTargets.Class)]
    public class DisallowMultipleRendererFeature : Attribute
    {
        public string customTitle { get; }
        public DisallowMultipleRendererFeature(string customTitle = null) => this.customTitle = customTitle;
    }

    public abstract class ScriptableRendererFeature : ScriptableObject, IDisposable
    {
        bool m_Active = true;
        public new bool isActive => m_Active;
        public abstract void Create();
        public abstract void AddRenderPasses(ScriptableRenderer renderer, ref RenderingData renderingData);
        public void SetActive(bool active) => m_Active = active;
        public void Dispose() { Dispose(true); GC.SuppressFinalize(this); }
        protected virtual void Dispose(bool disposing) { }
        // Of classes that have messages of these names themselves, these are not called.
        void OnEnable() => Create();
        void OnValidate() => Create();
    }
}
