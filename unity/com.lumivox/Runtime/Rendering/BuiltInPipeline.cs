// The built-in pipeline: commands of each camera, before its transparent things, recorded anew in each of its frames.
// How eyes are drawn is known to a module of its own, which a project may lack; since 6000.5 to that of headsets.
#if LUMIVOX_VR || UNITY_6000_5_OR_NEWER
#define HAS_STEREO_MODE
#endif
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.Rendering;

namespace Lumivox
{
    internal static class BuiltInPipeline
    {
        const CameraEvent Place = CameraEvent.BeforeForwardAlpha;

        sealed class Commands
        {
            public Camera Camera;
            public CommandBuffer Buffer;
            public bool WasForced;
            public bool IsForced;
        }

        static readonly List<Commands> all = new List<Commands>();
        static bool isHooked;

        /// <summary>Listens to cameras.</summary>
        public static void Need()
        {
            if (isHooked) return;
            isHooked = true;
            Camera.onPreCull += BeforeCulling;
            Camera.onPreRender += BeforeRendering;
            Camera.onPostRender += AfterRendering;
        }

        /// <summary>Leaves every camera as it was found, until it is drawn again.</summary>
        public static void Release()
        {
            foreach (var commands in all) Release(commands);
            all.Clear();
        }

        static void BeforeCulling(Camera camera)
        {
            if (GraphicsSettings.currentRenderPipeline != null) return;
            var commands = Find(camera);
            if (!LumivoxRuntime.Draws(camera))
            {
                if (commands != null)
                {
                    Release(commands);
                    all.Remove(commands);
                }
                return;
            }
            if (commands == null)
            {
                Forget();
                commands = new Commands { Camera = camera, Buffer = new CommandBuffer { name = "Lumivox" } };
                camera.AddCommandBuffer(Place, commands.Buffer);
                all.Add(commands);
            }
            // Rays end at the scene's depth, which this pipeline draws only where it is asked to.
            camera.depthTextureMode |= DepthTextureMode.Depth;
            // A back buffer may lie the other way up, and begin elsewhere than the view. For the frame only: cameras keep it
            // in their scenes.
            if (!commands.IsForced)
            {
                commands.WasForced = camera.forceIntoRenderTexture;
                commands.IsForced = true;
                camera.forceIntoRenderTexture = true;
            }
        }

        static void BeforeRendering(Camera camera)
        {
            if (GraphicsSettings.currentRenderPipeline != null) return;
            var commands = Find(camera);
            if (commands == null) return;
            commands.Buffer.Clear();
            // Of a headset, one pass may draw both eyes, or each has its own.
            if (camera.stereoEnabled && IsSinglePass)
            {
                commands.Buffer.SetSinglePassStereo(SinglePassStereoMode.None);
                for (var eye = 0; eye < 2; eye++) Record(commands, eye, 2, eye);
                commands.Buffer.SetSinglePassStereo(SystemInfo.supportsMultiview ? SinglePassStereoMode.Multiview : SinglePassStereoMode.Instancing);
            }
            else if (camera.stereoEnabled)
            {
                var eye = camera.stereoActiveEye == Camera.MonoOrStereoscopicEye.Right ? 1 : 0;
                Record(commands, eye, 2, 0);
            }
            else
            {
                Record(commands, 0, 1, 0);
            }
        }

#if HAS_STEREO_MODE
        static bool IsSinglePass => UnityEngine.XR.XRSettings.stereoRenderingMode != UnityEngine.XR.XRSettings.StereoRenderingMode.MultiPass;
#else
        static bool IsSinglePass => false;
#endif

        static void AfterRendering(Camera camera)
        {
            var commands = Find(camera);
            if (commands == null || !commands.IsForced) return;
            camera.forceIntoRenderTexture = commands.WasForced;
            commands.IsForced = false;
        }

        static void Record(Commands commands, int eye, int eyeCount, int slice)
        {
            var camera = commands.Camera;
            var isStereo = eyeCount > 1;
            var stereoEye = eye == 0 ? Camera.StereoscopicEye.Left : Camera.StereoscopicEye.Right;
            var inputs = new ViewInputs
            {
                Camera = camera,
                Eye = eye,
                EyeCount = eyeCount,
                WorldFromCamera = isStereo ? camera.GetStereoViewMatrix(stereoEye).inverse : camera.cameraToWorldMatrix,
                Projection = isStereo ? camera.GetStereoNonJitteredProjectionMatrix(stereoEye) : camera.nonJitteredProjectionMatrix,
                Width = camera.scaledPixelWidth,
                Height = camera.scaledPixelHeight,
                HasDepth = true,
                IsDepthArray = isStereo && IsSinglePass,
                DepthSlice = slice,
                Color = BuiltinRenderTextureType.CameraTarget,
                Depth = BuiltinRenderTextureType.CameraTarget,
                Slice = slice,
                IsJittered = !isStereo && camera.projectionMatrix != camera.nonJitteredProjectionMatrix,
                Exposure = 1f,
            };
            LumivoxRuntime.Record(commands.Buffer, inputs);
        }

        static Commands Find(Camera camera)
        {
            foreach (var commands in all)
                if (ReferenceEquals(commands.Camera, camera)) return commands;
            return null;
        }

        static void Forget()
        {
            for (var i = all.Count - 1; i >= 0; i--)
                if (all[i].Camera == null)
                {
                    all[i].Buffer.Dispose();
                    all.RemoveAt(i);
                }
        }

        static void Release(Commands commands)
        {
            if (commands.Camera != null)
            {
                commands.Camera.RemoveCommandBuffer(Place, commands.Buffer);
                if (commands.IsForced) commands.Camera.forceIntoRenderTexture = commands.WasForced;
            }
            commands.Buffer.Dispose();
        }
    }
}
