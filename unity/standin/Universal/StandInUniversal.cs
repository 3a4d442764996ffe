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

        /// What post-processing makes of a colour, for each camera that has it; null: nothing.
        public static System.Func<Color, Color> post;

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
                // Overlays are drawn with the stack that they are in, or not at all.
                if (camera != null && !IsOverlay(camera)) RenderStack(renderContext, camera);
        }

        static bool IsOverlay(Camera camera) => camera.TryGetComponent<UniversalAdditionalCameraData>(out var data) && data.renderType == CameraRenderType.Overlay;

        static List<Camera> OverlaysOf(Camera camera)
        {
            var overlays = new List<Camera>();
            if (!camera.TryGetComponent<UniversalAdditionalCameraData>(out var data)) return overlays;
            data.cameraStack.RemoveAll(one => one == null);
            foreach (var one in data.cameraStack)
                if (!one.isActiveAndEnabled) continue;
                else if (IsOverlay(one)) overlays.Add(one);
                else Debug.LogWarning($"Stack can only contain Overlay cameras. The camera: {one.name} has a type Base that is not supported. Will skip rendering.");
            return overlays;
        }

        /// A camera and its overlays, one after the other into the same targets.
        void RenderStack(ScriptableRenderContext context, Camera camera)
        {
            var overlays = OverlaysOf(camera);
            var isMultiPass = camera.stereoEnabled && Headset.mode == XR.XRSettings.StereoRenderingMode.MultiPass;
            // Each eye that is drawn by itself begins and ends.
            for (var eye = 0; eye < (isMultiPass ? 2 : 1); eye++)
            {
                BeginCameraRendering(context, camera);
                var stack = new Stack { camera = camera, hasOverlays = overlays.Count > 0 };
                Render(context, camera, stack, isMultiPass ? eye : -1);
                EndCameraRendering(context, camera);
                foreach (var overlay in overlays)
                {
                    BeginCameraRendering(context, overlay);
                    Render(context, overlay, stack, isMultiPass ? eye : -1);
                    EndCameraRendering(context, overlay);
                }
                stack.Resolve();
                if (isMultiPass) Pictures.KeepEye(camera, (Camera.StereoscopicEye)eye);
            }
        }

        /// What the cameras of a stack draw to: the first one's targets, or others of another scale that are spread over them.
        sealed class Stack
        {
            internal Camera camera;
            internal bool hasOverlays;
            internal RenderTexture color, depth, depthTexture;
            internal bool isFlipped;
            CameraTargets whole;

            /// As URP: the scene view is never scaled, nor is what differs by little.
            internal static float ScaleOf(Camera camera, float scale) => camera.cameraType == CameraType.SceneView || Mathf.Abs(1f - scale) < .05f ? 1f : scale;

            internal void Begin(float renderScale)
            {
                whole = Engine.TargetsOf(camera);
                isFlipped = whole.isFlipped;
                (color, depth) = (whole.color, whole.depth);
                var scale = ScaleOf(camera, renderScale);
                if (scale == 1f) return;
                int width = Mathf.Max(1, (int)(color.width * scale)), height = Mathf.Max(1, (int)(color.height * scale));
                color = CameraTargets.Make(width, height, color.volumeDepth, color.graphicsFormat, Experimental.Rendering.GraphicsFormat.None, "Scaled color");
                depth = CameraTargets.Make(width, height, color.volumeDepth, Experimental.Rendering.GraphicsFormat.None, Experimental.Rendering.GraphicsFormat.D32_SFloat, "Scaled depth");
            }

            internal RenderTexture DepthTexture()
            {
                if (color == whole.color) return whole.DepthTexture();
                if (depthTexture == null) depthTexture = CameraTargets.Make(color.width, color.height, color.volumeDepth, Experimental.Rendering.GraphicsFormat.None, Experimental.Rendering.GraphicsFormat.D32_SFloat, "Scaled depth texture");
                return depthTexture;
            }

            internal void Resolve()
            {
                if (color == whole.color) return;
                for (var layer = 0; layer < color.volumeDepth; layer++) Pictures.Spread(Pictures.Read(color, layer), whole.color, layer);
                foreach (var one in new[] { color, depth, depthTexture })
                    if (one != null) Object.DestroyImmediate(one);
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

        void Render(ScriptableRenderContext context, Camera camera, Stack stack, int eye)
        {
            var isOverlay = camera != stack.camera;
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
            if (!isOverlay)
            {
                var isForced = camera.forceIntoRenderTexture;
                camera.forceIntoRenderTexture |= stack.hasOverlays || Stack.ScaleOf(camera, asset.renderScale) != 1f;
#if UNITY_6000_0_OR_NEWER
                camera.forceIntoRenderTexture |= passes.Any(pass => pass.requiresIntermediateTexture);
#endif
                stack.Begin(asset.renderScale);
                camera.forceIntoRenderTexture = isForced;
            }
            Engine.Setup(stack.color, stack.depth);
            renderer.color = new RTHandle(stack.color);
            renderer.depth = new RTHandle(stack.depth);
            var which = eye < 0 ? (Camera.StereoscopicEye?)null : (Camera.StereoscopicEye)eye;
            // Overlays leave the colours that they do not draw over, and the depth if they are told to.
            var under = !isOverlay ? null : Under.Of(stack.color, stack.depth, extra.clearDepth);
            Props.Draw(camera, which, stack.color, stack.depth, stack.isFlipped, under);
            // Only where a pass asks for it is there a copy.
            var hasDepth = passes.Any(pass => (pass.input & ScriptableRenderPassInput.Depth) != 0);
            if (hasDepth) Props.Draw(camera, which, null, stack.DepthTexture(), stack.isFlipped, under);
            Shader.SetGlobalTexture("_CameraDepthTexture", hasDepth ? stack.DepthTexture() : null);
            data.cameraData.cameraTargetDescriptor = stack.color.descriptor;
            data.cameraData.isFlipped = stack.isFlipped;
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
                resources.isActiveTargetBackBuffer = !stack.isFlipped;
                if (hasDepth) resources.cameraDepthTexture = graph.ImportTexture(new RTHandle(stack.DepthTexture()));
                var frame = container.Create<UniversalCameraData>();
                frame.camera = camera;
                frame.cameraTargetDescriptor = stack.color.descriptor;
                frame.renderer = renderer;
                frame.antialiasing = antialiasing;
                frame.views = views;
                frame.projections = projections;
                frame.isFlipped = stack.isFlipped;
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
            if (extra != null && extra.renderPostProcessing && StandInUniversal.post != null)
                for (var layer = 0; layer < stack.color.volumeDepth; layer++) Pictures.Change(stack.color, layer, StandInUniversal.post);
        }
    }
}
