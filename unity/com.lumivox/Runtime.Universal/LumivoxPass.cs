// One camera's volumes in URP: an unsafe pass of the render graph (17), or of the renderer itself (14, and 17.0's
// compatibility mode, which Unity 6000.3 has only where a project defines URP_COMPATIBILITY_MODE, and 6000.4 never). Both
// hand the same inputs to the same recorder.
#if !UNITY_6000_3_OR_NEWER || URP_COMPATIBILITY_MODE && !UNITY_6000_4_OR_NEWER
#define HAS_EXECUTE
#endif
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.Universal;
#if LUMIVOX_URP_17
using UnityEngine.Rendering.RenderGraphModule;
#endif

namespace Lumivox.Universal
{
    internal sealed class LumivoxPass : ScriptableRenderPass
    {
#if HAS_EXECUTE
        readonly Eyes eyes = new Eyes();

#endif
        readonly bool isInjected;

        /// <param name="isInjected">Whether no feature brings it.</param>
        public LumivoxPass(bool isInjected)
        {
            this.isInjected = isInjected;
            profilingSampler = new ProfilingSampler("Lumivox");
            ConfigureInput(ScriptableRenderPassInput.Depth);
#if LUMIVOX_URP_17
            // A back buffer's depth cannot be read, and its rows may run the other way.
            requiresIntermediateTexture = true;
#endif
        }

        /// <summary>A camera of URP's, as it is drawn in this frame.</summary>
        struct Frame
        {
            public Camera Camera;
            public RenderTextureDescriptor Descriptor;
            public Matrix4x4 LeftView, RightView, LeftProjection, RightProjection;
            public RenderTargetIdentifier Color, Depth;
            public Texture DepthTexture;
            public bool IsTopFirst, IsStereo, IsJittered;
            public int PassEye;
        }

        bool Draws(Camera camera) => LumivoxRuntime.Draws(camera) && (!isInjected || LumivoxInjector.Takes(camera));

        static void Record(CommandBuffer cmd, in Frame frame)
        {
            // In a headset one texture may have a layer for each eye; else each eye has a pass.
            var isSinglePass = frame.IsStereo && frame.Descriptor.dimension == TextureDimension.Tex2DArray && frame.Descriptor.volumeDepth > 1;
            if (isSinglePass) SinglePass.Suspend(cmd);
            var count = isSinglePass ? 2 : 1;
            for (var i = 0; i < count; i++)
            {
                var inputs = new ViewInputs
                {
                    Camera = frame.Camera,
                    Eye = isSinglePass ? i : frame.PassEye,
                    EyeCount = frame.IsStereo ? 2 : 1,
                    WorldFromCamera = (i == 0 ? frame.LeftView : frame.RightView).inverse,
                    Projection = i == 0 ? frame.LeftProjection : frame.RightProjection,
                    IsTopFirst = frame.IsTopFirst,
                    Width = frame.Descriptor.width,
                    Height = frame.Descriptor.height,
                    HasDepth = true,
                    IsDepthArray = frame.Descriptor.dimension == TextureDimension.Tex2DArray,
                    DepthSlice = i,
                    DepthTexture = frame.DepthTexture,
                    Color = frame.Color,
                    Depth = frame.Depth,
                    Slice = i,
                    IsJittered = frame.IsJittered,
                    Exposure = 1f,
                };
                LumivoxRuntime.Record(cmd, inputs);
            }
            if (isSinglePass) SinglePass.Resume(cmd, count);
#if HAS_EXECUTE
            // Whoever is drawn next without a render graph takes what is bound for the camera's.
            cmd.SetRenderTarget(frame.Color, frame.Depth, 0, CubemapFace.Unknown, isSinglePass ? RenderTargetIdentifier.AllDepthSlices : 0);
#endif
        }

#if LUMIVOX_URP_17
        sealed class PassData
        {
            public LumivoxPass Pass;
            public UniversalCameraData CameraData;
            public TextureHandle Color, Depth, DepthTexture;
        }

        static readonly BaseRenderFunc<PassData, UnsafeGraphContext> draw = Draw;

        public override void RecordRenderGraph(RenderGraph renderGraph, ContextContainer frameData)
        {
            var resources = frameData.Get<UniversalResourceData>();
            var cameraData = frameData.Get<UniversalCameraData>();
            if (resources.isActiveTargetBackBuffer || !Draws(cameraData.camera)) return;
            using (var builder = renderGraph.AddUnsafePass<PassData>("Lumivox", out var data, profilingSampler))
            {
                data.Pass = this;
                data.CameraData = cameraData;
                data.Color = resources.activeColorTexture;
                data.Depth = resources.activeDepthTexture;
                data.DepthTexture = resources.cameraDepthTexture;
                builder.UseTexture(data.Color, AccessFlags.ReadWrite);
                builder.UseTexture(data.Depth, AccessFlags.ReadWrite);
                if (data.DepthTexture.IsValid()) builder.UseTexture(data.DepthTexture, AccessFlags.Read);
                // What it does to the library's own resources the graph does not see.
                builder.AllowPassCulling(false);
                builder.AllowGlobalStateModification(true);
                builder.SetRenderFunc(draw);
            }
        }

        static void Draw(PassData data, UnsafeGraphContext context)
        {
            var cmd = CommandBufferHelpers.GetNativeCommandBuffer(context.cmd);
            var camera = data.CameraData;
            RTHandle color = data.Color, depth = data.Depth;
            RTHandle depthTexture = data.DepthTexture.IsValid() ? (RTHandle)data.DepthTexture : null;
            var isStereo = camera.xr.enabled;
            var frame = new Frame
            {
                Camera = camera.camera,
                Descriptor = camera.cameraTargetDescriptor,
                LeftView = camera.GetViewMatrix(0),
                LeftProjection = camera.GetProjectionMatrix(0),
                Color = color.nameID,
                Depth = depth.nameID,
                DepthTexture = depthTexture != null ? (Texture)depthTexture.rt : null,
                IsTopFirst = SystemInfo.graphicsUVStartsAtTop && !camera.IsRenderTargetProjectionMatrixFlipped(color, depth),
                IsStereo = isStereo,
                IsJittered = IsJittered(camera.antialiasing),
                PassEye = isStereo && !camera.xr.singlePassEnabled ? camera.xr.multipassId : 0,
            };
            if (isStereo && camera.xr.singlePassEnabled)
            {
                frame.RightView = camera.GetViewMatrix(1);
                frame.RightProjection = camera.GetProjectionMatrix(1);
            }
            Record(cmd, frame);
        }

#pragma warning disable 618, 672 // What follows is the compatibility mode's.
#endif
#if HAS_EXECUTE
        public override void Execute(ScriptableRenderContext context, ref RenderingData renderingData)
        {
            ref var camera = ref renderingData.cameraData;
            if (!Draws(camera.camera)) return;
            var renderer = camera.renderer;
            var isStereo = camera.camera.stereoEnabled;
            var isSinglePass = isStereo && camera.cameraTargetDescriptor.volumeDepth > 1;
            var frame = new Frame
            {
                Camera = camera.camera,
                Descriptor = camera.cameraTargetDescriptor,
                LeftView = camera.GetViewMatrix(0),
                LeftProjection = camera.GetProjectionMatrix(0),
                Color = renderer.cameraColorTargetHandle.nameID,
                Depth = renderer.cameraDepthTargetHandle.nameID,
                IsTopFirst = SystemInfo.graphicsUVStartsAtTop && !camera.IsCameraProjectionMatrixFlipped(),
                IsStereo = isStereo,
                IsJittered = IsJittered(camera.antialiasing),
                PassEye = isStereo && !isSinglePass ? eyes.Next(camera.camera) : 0,
            };
            if (isSinglePass)
            {
                frame.RightView = camera.GetViewMatrix(1);
                frame.RightProjection = camera.GetProjectionMatrix(1);
            }
            var cmd = CommandBufferPool.Get("Lumivox");
            Record(cmd, frame);
            context.ExecuteCommandBuffer(cmd);
            cmd.Clear();
            CommandBufferPool.Release(cmd);
        }
#endif
#if LUMIVOX_URP_17
#pragma warning restore 618, 672
#endif

        static bool IsJittered(AntialiasingMode mode) => mode == AntialiasingMode.TemporalAntiAliasing;
    }
}
