using UnityEngine;

namespace Lumivox
{
    internal static class Projections
    {
        /// <summary>
        /// The projection with which a depth buffer was filled, with the image's first row in memory at y = -1 and the
        /// depth that the buffer holds in z. `projection` is in OpenGL's convention, as cameras have it.
        /// </summary>
        /// <remarks>
        /// Unity keeps images bottom row first, on every graphics API: where textures begin at the top it turns what it
        /// draws into them upside down. So the first row is at y = -1 without turning anything, but in a back buffer.
        /// </remarks>
        public static Matrix4x4 ClipFromCamera(Matrix4x4 projection, bool isTopFirst)
        {
            var clip = GL.GetGPUProjectionMatrix(projection, false);
            if (!SystemInfo.usesReversedZBuffer)
            {
                // OpenGL's z runs from -1 to 1, and its depth buffer from 0 to 1.
                clip.m20 = (clip.m20 + clip.m30) * 0.5f;
                clip.m21 = (clip.m21 + clip.m31) * 0.5f;
                clip.m22 = (clip.m22 + clip.m32) * 0.5f;
                clip.m23 = (clip.m23 + clip.m33) * 0.5f;
            }
            if (isTopFirst)
            {
                clip.m10 = -clip.m10;
                clip.m11 = -clip.m11;
                clip.m12 = -clip.m12;
                clip.m13 = -clip.m13;
            }
            return clip;
        }
    }
}
