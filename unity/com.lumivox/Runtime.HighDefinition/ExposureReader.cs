// What HDRP multiplies all light of a camera by, which the GPU alone knows where exposure is automatic: read back, some frames
// late.
using System;
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.HighDefinition;

namespace Lumivox.HighDefinition
{
    internal sealed class ExposureReader
    {
        static readonly int exposureTexture = Shader.PropertyToID("_ExposureTexture");

        sealed class Exposure
        {
            public readonly Camera Camera;
            public readonly Action<AsyncGPUReadbackRequest> Callback;
            public float Value = 1f;
            public bool IsWaiting;

            public Exposure(Camera camera)
            {
                Camera = camera;
                Callback = Came;
            }

            void Came(AsyncGPUReadbackRequest request)
            {
                IsWaiting = false;
                if (request.hasError) return;
                var value = request.GetData<float>()[0];
                if (float.IsNaN(value) || float.IsInfinity(value) || value <= 0f) return;
                if (Mathf.Abs(value - Value) > 1e-3f * Value) LumivoxRuntime.RequestFrames();
                Value = value;
            }
        }

        readonly List<Exposure> all = new List<Exposure>();

        /// <summary>As known now, and asks again.</summary>
        public float Read(HDCamera of)
        {
            // Without exposure nothing is kept, and what is bound is of the camera that was drawn before.
            if (!of.frameSettings.IsEnabled(FrameSettingsField.ExposureControl)) return 1f;
            var exposure = Find(of.camera);
            if (exposure.IsWaiting || !SystemInfo.supportsAsyncGPUReadback) return exposure.Value;
            // What is bound while commands are recorded is of the camera that was drawn before: the scene view's, say.
            var kept = of.GetPreviousFrameRT((int)HDCameraFrameHistoryType.Exposure);
            var texture = kept != null ? kept.rt : Shader.GetGlobalTexture(exposureTexture);
            if (texture == null || !Formats.CanBeReadBack(texture.graphicsFormat)) return exposure.Value;
            exposure.IsWaiting = true;
            AsyncGPUReadback.Request(texture, 0, TextureFormat.RGBAFloat, exposure.Callback);
            return exposure.Value;
        }

        Exposure Find(Camera camera)
        {
            foreach (var exposure in all)
                if (ReferenceEquals(exposure.Camera, camera)) return exposure;
            // One more camera: others may be gone.
            for (var i = all.Count - 1; i >= 0; i--)
                if (all[i].Camera == null) all.RemoveAt(i);
            var made = new Exposure(camera);
            all.Add(made);
            return made;
        }
    }
}
