using System;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.HighDefinition;

namespace Lumivox.HighDefinition
{
    /// <summary>
    /// Draws volumes in the High Definition Render Pipeline. It need not be added to a Custom Pass Volume: it is there for
    /// all cameras, before transparent things; one that is added all the same draws nothing. Custom passes have to be on in
    /// the cameras' frame settings, as they are unless somebody turned them off.
    /// </summary>
    [Serializable]
    public sealed class LumivoxCustomPass : CustomPass
    {
        readonly Eyes eyes = new Eyes();
        readonly ExposureReader exposure = new ExposureReader();

        /// <inheritdoc/>
        protected override void Execute(CustomPassContext ctx)
        {
            var camera = ctx.hdCamera.camera;
            if (this != HighDefinitionHost.Pass || !LumivoxRuntime.Draws(camera)) return;
            RTHandle color = ctx.cameraColorBuffer, depth = ctx.cameraDepthBuffer;
            var isStereo = camera.stereoEnabled;
            var isArray = color.rt.dimension == TextureDimension.Tex2DArray;
            var isSinglePass = isStereo && isArray && color.rt.volumeDepth > 1;
            var brightness = exposure.Read(ctx.hdCamera);
            HighDefinitionHost.Stack = ctx.hdCamera.volumeStack;
            if (isSinglePass) SinglePass.Suspend(ctx.cmd);
            var count = isSinglePass ? 2 : 1;
            for (var i = 0; i < count; i++)
            {
                var eye = isSinglePass ? i : isStereo ? eyes.Next(camera) : 0;
                var stereoEye = eye == 0 ? Camera.StereoscopicEye.Left : Camera.StereoscopicEye.Right;
                // HDRP draws around the camera; the cameras' own matrices are the world's.
                var inputs = new ViewInputs
                {
                    Camera = camera,
                    Eye = eye,
                    EyeCount = isStereo ? 2 : 1,
                    WorldFromCamera = isStereo ? camera.GetStereoViewMatrix(stereoEye).inverse : camera.cameraToWorldMatrix,
                    Projection = isStereo ? camera.GetStereoNonJitteredProjectionMatrix(stereoEye) : camera.nonJitteredProjectionMatrix,
                    Width = ctx.hdCamera.actualWidth,
                    Height = ctx.hdCamera.actualHeight,
                    HasDepth = true,
                    IsDepthArray = TextureXR.useTexArray,
                    DepthSlice = isSinglePass ? i : 0,
                    Color = color,
                    Depth = depth,
                    Slice = isSinglePass ? i : 0,
                    IsJittered = camera.TryGetComponent<HDAdditionalCameraData>(out var extra)
                        && extra.antialiasing == HDAdditionalCameraData.AntialiasingMode.TemporalAntialiasing,
                    Exposure = brightness,
                    HasOwnFog = true,
                };
                LumivoxRuntime.Record(ctx.cmd, inputs);
            }
            if (isSinglePass) SinglePass.Resume(ctx.cmd, count);
        }
    }
}
