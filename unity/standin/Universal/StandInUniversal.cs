// Draws cameras with the Universal Render Pipeline's passes, over the stand-in's shapes.
using System.Collections.Generic;
using System.Linq;
using StandIn;
#if UNITY_6000_0_OR_NEWER
using UnityEngine.Rendering.RenderGraphModule;
#endif

namespace UnityEngine.Rendering.Universal
{
    /// What tests steer it with.
    public static class StandInUniversal
    {
        /// Whether renderer's passes are executed by themselves, as before the render graph.
        public static bool usesCompatibilityMode =
#if UNITY_6000_0_OR_NEWER
            false;
#else
            true;
#endif

        /// Passes of the frame that was drawn last.
        public static int passes;

        internal static bool IsExecuting;

        /// Adds a feature to the renderer, as its inspector would.
        public static T Add<T>(UniversalRenderPipelineAsset asset) where T : ScriptableRendererFeature
        {
            var feature = ScriptableObject.CreateInstance<T>();
            feature.Create();
            asset.renderer.features.Add(feature);
            return feature;
        }

        /// What URP does with its renderers when their asset, or the quality level, is another: the features' objects live on.
        public static void Reload(UniversalRenderPipelineAsset asset)
        {
            foreach (var feature in asset.renderer.features) feature.Dispose();
            foreach (var feature in asset.renderer.features) feature.Create();
        }

        public static void Remove(UniversalRenderPipelineAsset asset, ScriptableRendererFeature feature)
        {
            asset.renderer.features.Remove(feature);
            feature.Dispose();
            Object.DestroyImmediate(feature);
        }
    }

    public sealed class UniversalRenderPipeline : RenderPipeline
    {
        readonly UniversalRenderPipelineAsset asset;
#if UNITY_6000_0_OR_NEWER
        readonly RenderGraph graph = new RenderGraph();
#endif

        public UniversalRenderPipeline(UniversalRenderPipelineAsset asset) => this.asset = asset;

        protected override void Render(ScriptableRenderContext renderContext, Camera[] cameras)
        {
            StandInUniversal.passes = 0;
            foreach (var camera in cameras)
            {
                if (camera == null) continue;
                var isMultiPass = camera.stereoEnabled && Headset.mode == XR.XRSettings.StereoRenderingMode.MultiPass;
                // Each eye that is drawn by itself begins and ends.
                for (var eye = 0; eye < (isMultiPass ? 2 : 1); eye++)
                {
                    BeginCameraRendering(renderContext, camera);
                    Render(renderContext, camera, isMultiPass ? eye : -1);
                    EndCameraRendering(renderContext, camera);
                }
            }
        }

        /// As XRPass has the draws of both eyes in one pass.
        static void Multiply(ScriptableRenderContext context, uint eyes)
        {
            var cmd = CommandBufferPool.Get("XR");
            cmd.SetInstanceMultiplier(eyes);
            context.ExecuteCommandBuffer(cmd);
            CommandBufferPool.Release(cmd);
        }

        void Render(ScriptableRenderContext context, Camera camera, int eye)
        {
            var renderer = asset.renderer;
            var isSinglePass = camera.stereoEnabled && eye < 0;
            Matrix4x4[] views, projections;
            if (camera.stereoEnabled)
            {
                var eyes = isSinglePass ? new[] { Camera.StereoscopicEye.Left, Camera.StereoscopicEye.Right } : new[] { (Camera.StereoscopicEye)eye };
                views = eyes.Select(one => camera.GetStereoViewMatrix(one)).ToArray();
                projections = eyes.Select(one => camera.GetStereoProjectionMatrix(one)).ToArray();
            }
            else
            {
                views = new[] { camera.worldToCameraMatrix };
                projections = new[] { camera.projectionMatrix };
            }
            var antialiasing = camera.TryGetComponent<UniversalAdditionalCameraData>(out var extra) ? extra.antialiasing : AntialiasingMode.None;
            var data = new RenderingData { cameraData = new CameraData { camera = camera, renderer = renderer, antialiasing = antialiasing, views = views, projections = projections } };
            foreach (var feature in renderer.features)
                if (feature.isActive)
                    using (Callbacks.Counted()) feature.AddRenderPasses(renderer, ref data);
            var passes = renderer.queue.OrderBy(pass => pass.renderPassEvent).ToList();
            renderer.queue.Clear();
#if UNITY_6000_0_OR_NEWER
            var isForced = camera.forceIntoRenderTexture;
            camera.forceIntoRenderTexture |= passes.Any(pass => pass.requiresIntermediateTexture);
#endif
            Engine.Setup(camera);
            var targets = Engine.TargetsOf(camera);
#if UNITY_6000_0_OR_NEWER
            camera.forceIntoRenderTexture = isForced;
#endif
            renderer.color = new RTHandle(targets.color);
            renderer.depth = new RTHandle(targets.depth);
            var which = eye < 0 ? (Camera.StereoscopicEye?)null : (Camera.StereoscopicEye)eye;
            Props.Draw(camera, which, targets.color, targets.depth, targets.isFlipped);
            // Only where a pass asks for it is there a copy.
            var hasDepth = passes.Any(pass => (pass.input & ScriptableRenderPassInput.Depth) != 0);
            if (hasDepth) Props.Draw(camera, which, null, targets.DepthTexture(), targets.isFlipped);
            Shader.SetGlobalTexture("_CameraDepthTexture", hasDepth ? targets.DepthTexture() : null);
            data.cameraData.cameraTargetDescriptor = targets.color.descriptor;
            data.cameraData.isFlipped = targets.isFlipped;
            StandInUniversal.passes += passes.Count;
#if !UNITY_6000_3_OR_NEWER
            if (StandInUniversal.usesCompatibilityMode)
            {
                // Nothing is bound anew for a pass that did not ask for other targets: it draws into what the one before left.
                StandInUniversal.IsExecuting = true;
                try
                {
                    if (isSinglePass) Multiply(context, 2);
#pragma warning disable 618
                    foreach (var pass in passes)
                        using (Callbacks.Counted()) pass.Execute(context, ref data);
#pragma warning restore 618
                    if (isSinglePass) Multiply(context, 1);
                }
                finally { StandInUniversal.IsExecuting = false; }
            }
#endif
#if UNITY_6000_0_OR_NEWER
            if (!StandInUniversal.usesCompatibilityMode)
            {
                var container = new ContextContainer();
                var resources = container.Create<UniversalResourceData>();
                resources.activeColorTexture = graph.ImportTexture(renderer.color);
                resources.activeDepthTexture = graph.ImportTexture(renderer.depth);
                resources.isActiveTargetBackBuffer = !targets.isFlipped;
                if (hasDepth) resources.cameraDepthTexture = graph.ImportTexture(new RTHandle(targets.DepthTexture()));
                var frame = container.Create<UniversalCameraData>();
                frame.camera = camera;
                frame.cameraTargetDescriptor = targets.color.descriptor;
                frame.renderer = renderer;
                frame.antialiasing = antialiasing;
                frame.views = views;
                frame.projections = projections;
                frame.isFlipped = targets.isFlipped;
                frame.xr.enabled = camera.stereoEnabled;
                frame.xr.views = views.Length;
                frame.xr.multipassId = Mathf.Max(0, eye);
                foreach (var pass in passes)
                    using (Callbacks.Counted()) pass.RecordRenderGraph(graph, container);
                var cmd = CommandBufferPool.Get("RenderGraph");
                if (isSinglePass) cmd.SetInstanceMultiplier(2);
                graph.Execute(cmd);
                if (isSinglePass) cmd.SetInstanceMultiplier(1);
                context.ExecuteCommandBuffer(cmd);
                CommandBufferPool.Release(cmd);
            }
#endif
            context.Submit();
            if (eye >= 0) Pictures.KeepEye(camera, (Camera.StereoscopicEye)eye);
        }
    }
}
