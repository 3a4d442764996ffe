using UnityEngine;

namespace Lumivox
{
    /// <summary>How far a camera's image of volumes is.</summary>
    public readonly struct LumivoxStatus
    {
        /// <summary>Whether the camera shows volumes at all.</summary>
        public readonly bool isShown;
        /// <summary>Samples that every pixel has, and after which the image is done.</summary>
        public readonly int samples, target;
        /// <summary>Whether there is nothing more to trace unless something changes.</summary>
        public readonly bool isConverged;
        /// <summary>Pixel samples that the last frame traced.</summary>
        public readonly long pixelSamples;
        /// <summary>Pixels whose paths the driver ended before their time.</summary>
        public readonly long lostPixels;

        internal LumivoxStatus(int samples, int target, bool isConverged, long pixelSamples, long lostPixels)
        {
            isShown = true;
            this.samples = samples;
            this.target = target;
            this.isConverged = isConverged;
            this.pixelSamples = pixelSamples;
            this.lostPixels = lostPixels;
        }
    }

    /// <summary>How the volumes on screen are doing, for scripts.</summary>
    public static class LumivoxRenderer
    {
        /// <summary>How far the image of a camera is, as known of the frame that was drawn last; of a headset, that of the eye which is behind.</summary>
        public static LumivoxStatus GetStatus(Camera camera) => LumivoxRuntime.StatusOf(camera);

        /// <summary>
        /// Whether the image of a camera is done. Also true if it shows no volume, be it because its
        /// <see cref="LumivoxEffect"/> is disabled. This is known of the frame that was drawn last: after a change, wait
        /// for the end of the next frame first.
        /// </summary>
        public static bool IsConverged(Camera camera)
        {
            if (camera == null)
            {
                Debug.LogError("LumivoxRenderer.IsConverged: there is no camera: it is null.");
                return false;
            }
            var status = LumivoxRuntime.StatusOf(camera);
            // A volume that was not drawn yet is not done.
            return status.isShown ? status.isConverged : !LumivoxRuntime.Draws(camera);
        }

        /// <summary>Why volumes cannot be drawn, or an empty string.</summary>
        public static string LastError => LumivoxRuntime.Error;

        /// <summary>Bytes of voxels on the GPU.</summary>
        public static ulong VoxelBytes => LumivoxRuntime.VoxelBytes;

        /// <summary>
        /// Bytes on the GPU of the light that is kept in volumes, for all cameras (<see cref="LumivoxEffect.keptLight"/>); 0 where none is kept.
        /// With <see cref="VoxelBytes"/> they stay within <see cref="LumivoxProjectSettings.voxelMegabytes"/>.
        /// </summary>
        public static ulong KeptLightBytes => LumivoxRuntime.KeptLightBytes;

        /// <summary>The version of the native library; empty where it cannot be used.</summary>
        public static string Version => Native.Border.Fault == null ? Native.Border.Text(Native.Library.lumivox_version()) : "";

        /// <summary>
        /// Whether frames show their scene whole, however long that takes: for films and stills, where no frame follows
        /// that could show what one lacks.
        /// </summary>
        public static bool RenderAtOnce { get; set; }

        /// <summary>Looks for lights at once, which are otherwise found within half a second of being made.</summary>
        public static void FindLights() => LightFinder.FindAll();
    }
}
