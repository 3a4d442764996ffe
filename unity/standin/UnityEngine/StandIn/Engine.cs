// A frame of the engine: scripts, cameras through the built-in pipeline or the one that is set, the GPU, what comes back.
using System;
using System.Collections.Generic;
using System.Linq;
using UnityEngine;
using UnityEngine.Experimental.Rendering;
using UnityEngine.Rendering;

namespace StandIn
{
    /// What a camera draws to: an intermediate texture, or the screen's or the target's own.
    sealed class CameraTargets : IDisposable
    {
        internal RenderTexture color, depth, depthTexture;
        /// Whether rows lie upside down, as of all textures that are drawn to; the screen's do not.
        internal bool isFlipped;
        bool owns;
        readonly string key;
        internal CameraTargets(Camera camera)
        {
            key = KeyOf(camera);
            isFlipped = IsFlipped(camera);
            var target = camera.targetTexture;
            if (target != null)
            {
                target.Create();
                color = target;
                depth = target.depthHandle != 0 ? target : Make(target.width, target.height, 1, GraphicsFormat.None, GraphicsFormat.D32_SFloat, "Camera depth");
                owns = depth != target;
            }
            else
            {
                int layers = Engine.IsSinglePass(camera) ? 2 : 1;
                color = Make(camera.scaledPixelWidth, camera.scaledPixelHeight, layers, camera.allowHDR ? GraphicsFormat.R16G16B16A16_SFloat : GraphicsFormat.R8G8B8A8_SRGB, GraphicsFormat.None, "Camera color");
                depth = Make(camera.scaledPixelWidth, camera.scaledPixelHeight, layers, GraphicsFormat.None, GraphicsFormat.D32_SFloat, "Camera depth");
            }
        }
        static string KeyOf(Camera camera) => $"{camera.scaledPixelWidth} {camera.scaledPixelHeight} {camera.allowHDR} {camera.stereoEnabled} {Headset.mode} {(camera.targetTexture == null ? 0 : camera.targetTexture.GetInstanceID())} {IsFlipped(camera)}";
        internal static bool IsFlipped(Camera camera) => camera.targetTexture != null || camera.forceIntoRenderTexture || camera.allowHDR || camera.stereoEnabled;
        internal bool Fits(Camera camera) => key == KeyOf(camera) && color != null && color.IsCreated();
        internal static RenderTexture Make(int width, int height, int layers, GraphicsFormat format, GraphicsFormat depth, string name)
        {
            var made = new RenderTexture(new RenderTextureDescriptor(width, height, format, depth) { volumeDepth = layers, dimension = layers > 1 ? TextureDimension.Tex2DArray : TextureDimension.Tex2D }) { name = name, hideFlags = HideFlags.HideAndDontSave };
            made.Create();
            // The engine's own is no one's leak.
            Live.Remove(made);
            return made;
        }
        internal RenderTexture DepthTexture()
        {
            if (depthTexture == null) depthTexture = Make(color.width, color.height, color.volumeDepth, GraphicsFormat.None, GraphicsFormat.D32_SFloat, "_CameraDepthTexture");
            return depthTexture;
        }
        public void Dispose()
        {
            if (depthTexture != null) UnityEngine.Object.DestroyImmediate(depthTexture);
            if (depth != null && depth != color && (owns || !ReferenceEquals(depth, color))) UnityEngine.Object.DestroyImmediate(depth);
            if (color != null && color.label == "Camera color") UnityEngine.Object.DestroyImmediate(color);
        }
    }

    public static class Engine
    {
        /// What executes while a camera is rendered.
        internal static Execution current;
        internal static RenderPipeline pipeline;
        static readonly int depthTextureID = Shader.PropertyToID("_CameraDepthTexture");
        /// Called where a frame begins, before all scripts: what the editor does then.
        public static event Action frameBegins;
        /// Called where scripts ran, before cameras are rendered.
        public static event Action scriptsRan;

        /// One frame, and the time that goes by with it.
        public static void Frame(float seconds = 1 / 60f)
        {
            Threads.Main("a frame");
            Time.frames++;
            Time.delta = seconds;
            Time.seconds += seconds;
            Gizmos.drawn.Clear();
            frameBegins?.Invoke();
            (System.Threading.SynchronizationContext.Current as MainContext)?.Run();
            Lifecycle.Start();
            Lifecycle.Update();
            Coroutines.Update();
            Lifecycle.LateUpdate();
            Objects.EndFrame();
            scriptsRan?.Invoke();
            Application.BeforeRender();
            RenderAll();
            ReadBacks.Frame();
            Gpu.Check("the frame");
            if (Samples.open != 0) Debug.LogError($"{Samples.open} profiler samples were begun but not ended in this frame");
        }
        public static void Frames(int count) { for (int i = 0; i < count; i++) Frame(); }
        /// Frames until something is so; fails after so many.
        public static void FramesUntil(Func<bool> isSo, int most, string what)
        {
            for (int i = 0; i < most; i++) { if (isSo()) return; Frame(); }
            if (!isSo()) throw new TimeoutException($"after {most} frames still not: {what}");
        }

        static void RenderAll()
        {
            var cameras = Camera.allCameras.Where(camera => camera.cameraType == CameraType.Game || camera.cameraType == CameraType.SceneView).ToList();
            if (cameras.Count == 0) return;
            if (GraphicsSettings.currentRenderPipeline != null) RenderWithPipeline(cameras);
            // A camera's listeners may have destroyed one that comes after it.
            else foreach (var camera in cameras) if (camera != null) Render(camera);
#if UNITY_EDITOR
            Lifecycle.Gizmos();
#endif
        }

        static void RenderWithPipeline(List<Camera> cameras)
        {
            if (pipeline == null)
            {
                pipeline = GraphicsSettings.currentRenderPipeline.Make();
                if (pipeline == null) throw new NotImplementedException($"{GraphicsSettings.currentRenderPipeline.GetType().Name} makes no pipeline here");
                RenderPipelineManager.Created();
            }
            var context = new ScriptableRenderContext { queued = new List<CommandBuffer>() };
            current = new Execution();
            try { pipeline.InternalRender(context, cameras); context.Submit(); }
            finally { current.End(); current = null; }
        }
        internal static void PipelineChanged(RenderPipelineAsset from, RenderPipelineAsset to)
        {
            if (from == to) return;
            if (pipeline != null) { pipeline.Dispose(); pipeline = null; RenderPipelineManager.Disposed(); }
            RenderPipelineManager.Changed(from, to);
        }

        internal static bool IsSinglePass(Camera camera) => camera.stereoEnabled && Headset.mode != UnityEngine.XR.XRSettings.StereoRenderingMode.MultiPass;

        internal static CameraTargets TargetsOf(Camera camera)
        {
            if (camera.targets == null || !camera.targets.Fits(camera)) { camera.targets?.Dispose(); camera.targets = new CameraTargets(camera); }
            return camera.targets;
        }
        /// What a pipeline that renders this camera draws to.
        public static RenderTexture ColorOf(Camera camera) => TargetsOf(camera).color;
        public static RenderTexture DepthOf(Camera camera) => TargetsOf(camera).depth;
        public static bool IsFlipped(Camera camera) => TargetsOf(camera).isFlipped;
        internal static void Setup(Camera camera) => Setup(TargetsOf(camera).color, TargetsOf(camera).depth);
        /// What commands that name the camera's target draw to.
        internal static void Setup(RenderTexture color, RenderTexture depth)
        {
            current.camera = new BoundTarget { color = color, depth = depth };
            current.Bind(current.camera);
        }

        /// The built-in pipeline, forward.
        internal static void Render(Camera camera)
        {
            if (GraphicsSettings.currentRenderPipeline != null) { RenderWithPipeline(new List<Camera> { camera }); return; }
            if (camera.stereoEnabled && !IsSinglePass(camera))
            {
                // One after the other, each with its own matrices.
                for (int eye = 0; eye < 2; eye++)
                {
                    camera.stereoActiveEye = (Camera.MonoOrStereoscopicEye)eye;
                    Draw(camera, (Camera.StereoscopicEye)eye);
                }
                camera.stereoActiveEye = Camera.MonoOrStereoscopicEye.Mono;
            }
            else Draw(camera, null);
        }

        static void Draw(Camera camera, Camera.StereoscopicEye? eye)
        {
            var outer = current;
            Camera.current = camera;
            using (Callbacks.Counted()) Camera.onPreCull?.Invoke(camera);
            Tell(camera, "OnPreCull");
            using (Callbacks.Counted()) Camera.onPreRender?.Invoke(camera);
            Tell(camera, "OnPreRender");
            var targets = TargetsOf(camera);
            current = new Execution { camera = new BoundTarget { color = targets.color, depth = targets.depth, slice = IsSinglePass(camera) ? -1 : 0 }, stereo = IsSinglePass(camera) ? SinglePassStereoMode.Instancing : SinglePassStereoMode.None };
            var execution = current;
            try
            {
                execution.Bind(execution.camera);
                if ((camera.depthTextureMode & DepthTextureMode.Depth) != 0)
                {
                    Run(camera, CameraEvent.BeforeDepthTexture);
                    Props.Draw(camera, eye, null, targets.DepthTexture(), targets.isFlipped);
                    Shader.globals.Set(depthTextureID, targets.DepthTexture());
                    Run(camera, CameraEvent.AfterDepthTexture);
                }
                else Shader.globals.Set(depthTextureID, (Texture)null);
                Run(camera, CameraEvent.BeforeForwardOpaque);
                Props.Draw(camera, eye, targets.color, targets.depth, targets.isFlipped);
                Run(camera, CameraEvent.AfterForwardOpaque);
                Run(camera, CameraEvent.BeforeSkybox);
                Run(camera, CameraEvent.AfterSkybox);
                Run(camera, CameraEvent.BeforeImageEffectsOpaque);
                Run(camera, CameraEvent.AfterImageEffectsOpaque);
                Run(camera, CameraEvent.BeforeForwardAlpha);
                Run(camera, CameraEvent.AfterForwardAlpha);
                Run(camera, CameraEvent.BeforeImageEffects);
                Run(camera, CameraEvent.AfterImageEffects);
                Run(camera, CameraEvent.AfterEverything);
            }
            finally { execution.End(); current = outer; }
            using (Callbacks.Counted()) Camera.onPostRender?.Invoke(camera);
            Tell(camera, "OnPostRender");
            Camera.current = null;
            if (eye is Camera.StereoscopicEye one) Pictures.KeepEye(camera, one);
        }

        /// Shapes and sky only: scripts hear of each face, their commands are not run.
        internal static void RenderCube(Camera camera, RenderTexture cube, int faces)
        {
            var isBuiltIn = GraphicsSettings.currentRenderPipeline == null;
            if (camera.commandBufferCount > 0) throw new NotImplementedException("the stand-in runs no command buffers in cubes");
            for (int face = 0; face < 6; face++)
            {
                if ((faces >> face & 1) == 0) continue;
                Camera.current = camera;
                if (isBuiltIn) Camera.onPreCull?.Invoke(camera);
                else RenderPipelineManager.BeginCamera(default, camera);
                if (isBuiltIn) Camera.onPreRender?.Invoke(camera);
                Props.DrawFace(camera, cube, face);
                if (isBuiltIn) Camera.onPostRender?.Invoke(camera);
                else RenderPipelineManager.EndCamera(default, camera);
                Camera.current = null;
            }
        }

        static void Run(Camera camera, CameraEvent at)
        {
            foreach (var (when, commands) in camera.commandBuffers.ToArray())
                if (when == at) { current.Bind(current.camera); current.Run(commands); }
        }
        static void Tell(Camera camera, string message)
        {
            foreach (var component in camera.gameObject.components.ToArray())
                if (component is MonoBehaviour script && script.isRunning) Messages.Send(script, message);
        }

        /// Ends all that a test left, so that the next begins anew.
        public static void Clear()
        {
            Objects.Clear();
            ReadBacks.Forget();
            GraphicsSettings.defaultRenderPipeline = null;
            QualitySettings.renderPipeline = null;
            RenderSettings.Default();
            Props.Clear();
            Faults.Clear();
            Headset.Reset();
            Devices.Reset();
            Keys.Reset();
            Shader.globals.Clear();
            Shader.globalKeywords.Clear();
            Resources.placed.Clear();
            ScalableBufferManager.ResizeBuffers(1, 1);
            Screen.width = 640;
            Screen.height = 480;
            Application.playing = false;
            ReadBacks.latency = 2;
        }
        public static void SetScreen(int width, int height) { Screen.width = width; Screen.height = height; }
        public static void SetColorSpace(ColorSpace space) => QualitySettings.activeColorSpace = space;
    }

    /// What is posted to the main thread, as by `await`, runs with the next frame.
    public sealed class MainContext : System.Threading.SynchronizationContext
    {
        readonly System.Collections.Concurrent.ConcurrentQueue<(System.Threading.SendOrPostCallback, object)> posted = new System.Collections.Concurrent.ConcurrentQueue<(System.Threading.SendOrPostCallback, object)>();
        public override void Post(System.Threading.SendOrPostCallback callback, object state) => posted.Enqueue((callback, state));
        public override void Send(System.Threading.SendOrPostCallback callback, object state) => throw new NotImplementedException("the stand-in's context only posts");
        public override System.Threading.SynchronizationContext CreateCopy() => this;
        internal void Forget() => posted.Clear();
        public void Run()
        {
            for (int left = posted.Count; left > 0 && posted.TryDequeue(out var item); left--)
                try { item.Item1(item.Item2); }
                catch (Exception error) { Debug.LogException(error); }
        }
    }
}
