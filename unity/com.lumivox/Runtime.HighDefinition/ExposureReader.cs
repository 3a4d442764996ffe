// What HDRP multiplies all light by, which the GPU alone knows where exposure is automatic: read back, some frames late.
using System;
using UnityEngine;
using UnityEngine.Rendering;

namespace Lumivox.HighDefinition
{
    internal sealed class ExposureReader
    {
        static readonly int exposureTexture = Shader.PropertyToID("_ExposureTexture");

        readonly Action<AsyncGPUReadbackRequest> came;
        float exposure = 1f;
        bool isWaiting;

        public ExposureReader() => came = Came;

        /// <summary>As known now, and asks again.</summary>
        public float Read()
        {
            var texture = Shader.GetGlobalTexture(exposureTexture);
            if (!isWaiting && texture != null && SystemInfo.supportsAsyncGPUReadback)
            {
                isWaiting = true;
                AsyncGPUReadback.Request(texture, 0, TextureFormat.RGBAFloat, came);
            }
            return exposure;
        }

        void Came(AsyncGPUReadbackRequest request)
        {
            isWaiting = false;
            if (request.hasError) return;
            var value = request.GetData<float>()[0];
            if (float.IsNaN(value) || float.IsInfinity(value) || value <= 0f) return;
            if (Mathf.Abs(value - exposure) > 1e-3f * exposure) LumivoxRuntime.RequestFrames();
            exposure = value;
        }
    }
}
