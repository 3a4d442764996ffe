// Draws cameras with the High Definition Render Pipeline's custom passes, over the stand-in's shapes.
using System.Collections.Generic;
using StandIn;
using UnityEngine.Experimental.Rendering;

namespace UnityEngine.Rendering.HighDefinition
{
    /// What tests steer it with.
    public static class StandInHighDefinition
    {
        /// What a camera's light is multiplied by; 1 without.
        public static System.Func<Camera, float> exposure;
        /// Whether exposures are kept with their cameras, or only bound while those are drawn.
        public static bool keepsExposures = true;
        /// The stack of a camera, where it is not the one that all have.
        public static System.Func<Camera, VolumeStack> stack;
        public static void Reset() => (exposure, keepsExposures, stack) = (null, true, null);
    }

    public class HDRenderPipeline : RenderPipeline
    {
        /// Its textures are as large as the largest camera's, and arrays of a layer for each eye: what is drawn is a part.
        const int Spare = 5;

        readonly Dictionary<Camera, Buffers> buffers = new Dictionary<Camera, Buffers>();

        readonly bool hadLinearIntensity, hadColorTemperature;

        sealed class Buffers
        {
            public RenderTexture color, depth, depthTexture;
            /// This frame's and the last one's, the newest last.
            public readonly RenderTexture[] exposures = new RenderTexture[2];
            public readonly HDCamera camera = new HDCamera();
        }

        /// Lights are physical: intensities are those of linear light.
        public HDRenderPipeline(HDRenderPipelineAsset asset)
        {
            (hadLinearIntensity, hadColorTemperature) = (GraphicsSettings.lightsUseLinearIntensity, GraphicsSettings.lightsUseColorTemperature);
            GraphicsSettings.lightsUseLinearIntensity = GraphicsSettings.lightsUseColorTemperature = true;
        }

        protected override void Render(ScriptableRenderContext renderContext, Camera[] cameras)
        {
            foreach (var camera in cameras)
            {
                if (camera == null) continue;
                BeginCameraRendering(renderContext, camera);
                Render(renderContext, camera);
                EndCameraRendering(renderContext, camera);
            }
        }

        protected override void Dispose(bool disposing)
        {
            foreach (var of in buffers.Values)
                foreach (var texture in new[] { of.color, of.depth, of.depthTexture, of.exposures[0], of.exposures[1] })
                    if (texture != null) Object.DestroyImmediate(texture);
            buffers.Clear();
            (GraphicsSettings.lightsUseLinearIntensity, GraphicsSettings.lightsUseColorTemperature) = (hadLinearIntensity, hadColorTemperature);
        }

        Buffers Of(Camera camera)
        {
            int width = camera.scaledPixelWidth + Spare, height = camera.scaledPixelHeight + Spare, layers = camera.stereoEnabled ? 2 : 1;
            if (buffers.TryGetValue(camera, out var known) && known.color.width == width && known.color.height == height && known.color.volumeDepth == layers) return known;
            RenderTexture Make(GraphicsFormat color, GraphicsFormat depth)
            {
                var made = new RenderTexture(new RenderTextureDescriptor(width, height, color, depth) { dimension = TextureDimension.Tex2DArray, volumeDepth = layers }) { name = "HDRP" };
                made.Create();
                Live.Remove(made);
                return made;
            }
            return buffers[camera] = new Buffers
            {
                color = Make(GraphicsFormat.R16G16B16A16_SFloat, GraphicsFormat.None),
                depth = Make(GraphicsFormat.None, GraphicsFormat.D32_SFloat),
                depthTexture = Make(GraphicsFormat.None, GraphicsFormat.D32_SFloat),
            };
        }

        /// This frame's exposure, which is kept as that of the frame before: a multiplier, and its logarithm.
        static unsafe RenderTexture Expose(Buffers of)
        {
            (of.exposures[0], of.exposures[1]) = (of.exposures[1], of.exposures[0]);
            var texture = of.exposures[1];
            if (texture == null)
            {
                texture = of.exposures[1] = new RenderTexture(new RenderTextureDescriptor(1, 1, GraphicsFormat.R32G32_SFloat, GraphicsFormat.None)) { name = "Exposure" };
                texture.Create();
                Live.Remove(texture);
            }
            var pixel = stackalloc float[5];
            var isExposed = of.camera.frameSettings.IsEnabled(FrameSettingsField.ExposureControl);
            pixel[0] = isExposed ? StandInHighDefinition.exposure?.Invoke(of.camera.camera) ?? 1 : 1;
            Native.sg_fill(new Native.Target { color = texture.handle }, 1, pixel, 5 * sizeof(float));
            Gpu.Submit("an exposure");
            for (var i = 0; i < 2; i++) of.camera.exposures[i] = isExposed && StandInHighDefinition.keepsExposures && of.exposures[i] != null ? RTHandles.Alloc(of.exposures[i]) : null;
            return texture;
        }

        /// Where the first pixels of a larger texture show what a camera sees.
        static Matrix4x4 Within(int width, int height, RenderTexture all)
        {
            float x = (float)width / all.width, y = (float)height / all.height;
            var part = Matrix4x4.identity;
            (part.m00, part.m03) = (x, x - 1f);
            (part.m11, part.m13) = (y, y - 1f);
            return part;
        }

        void Render(ScriptableRenderContext context, Camera camera)
        {
            int width = camera.scaledPixelWidth, height = camera.scaledPixelHeight;
            Engine.Setup(camera);
            var of = Of(camera);
            var targets = Engine.TargetsOf(camera);
            Props.cleared = camera.TryGetComponent<HDAdditionalCameraData>(out var extra) && extra.clearColorMode == HDAdditionalCameraData.ClearColorMode.Color ? extra.backgroundColorHDR : (Color?)null;
            for (var layer = 0; layer < of.color.volumeDepth; layer++)
            {
                var eye = (Camera.StereoscopicEye)layer;
                var view = camera.stereoEnabled ? camera.GetStereoViewMatrix(eye) : camera.worldToCameraMatrix;
                var projection = Within(width, height, of.color) * (camera.stereoEnabled ? camera.GetStereoProjectionMatrix(eye) : camera.projectionMatrix);
                Props.Draw(camera, view, projection, layer, of.color, of.depth, true);
                Props.Draw(camera, view, projection, layer, null, of.depthTexture, true);
            }
            of.camera.frameSettings = camera.TryGetComponent<HDAdditionalCameraData>(out var data) ? data.Overridden() : default;
            Props.cleared = null;
            var cmd = CommandBufferPool.Get("HDRP");
            Shader.SetGlobalTexture("_CameraDepthTexture", of.depthTexture);
            var hdCamera = of.camera;
            (hdCamera.camera, hdCamera.actualWidth, hdCamera.actualHeight) = (camera, width, height);
            hdCamera.volumeStack = StandInHighDefinition.stack?.Invoke(camera) ?? VolumeManager.instance.stack;
            // Bound when the commands run: until then, what was bound is of the camera that was drawn before.
            cmd.SetGlobalTexture("_ExposureTexture", Expose(of));
            if (camera.stereoEnabled) cmd.SetInstanceMultiplier(2);
            foreach (CustomPassInjectionPoint at in System.Enum.GetValues(typeof(CustomPassInjectionPoint)))
            {
                var passes = CustomPassVolume.global.TryGetValue(at, out var global) ? new List<CustomPass>(global) : new List<CustomPass>();
                foreach (var volume in CustomPassVolume.active)
                    if (volume.injectionPoint == at && volume.IsFor(camera)) passes.AddRange(volume.customPasses);
                foreach (var pass in passes)
                    if (pass.enabled && hdCamera.frameSettings.IsEnabled(FrameSettingsField.CustomPass)) pass.Run(new CustomPassContext(context, cmd, hdCamera, new RTHandle(of.color), new RTHandle(of.depth)));
            }
            if (camera.stereoEnabled) cmd.SetInstanceMultiplier(1);
            for (var layer = 0; layer < of.color.volumeDepth; layer++)
                cmd.CopyTexture(of.color, layer, 0, 0, 0, width, height, targets.color, layer, 0, 0, 0);
            context.ExecuteCommandBuffer(cmd);
            CommandBufferPool.Release(cmd);
            context.Submit();
        }
    }
}
