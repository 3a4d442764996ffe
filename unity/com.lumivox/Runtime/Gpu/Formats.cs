using UnityEngine;
using UnityEngine.Experimental.Rendering;

namespace Lumivox
{
    /// <summary>What textures of a format can be on the device at hand.</summary>
    internal static class Formats
    {
        /// <summary>
        /// Whether kernels can write a texture and sample it with a filter. Unity makes no render texture, which alone kernels
        /// write, of a format that cannot be drawn to, though nobody draws to this one.
        /// </summary>
        public static bool AreWritten(GraphicsFormat format) => CanBeDrawnTo(format) &&
#if UNITY_2023_2_OR_NEWER
            SystemInfo.IsFormatSupported(format, GraphicsFormatUsage.Linear) && SystemInfo.IsFormatSupported(format, GraphicsFormatUsage.LoadStore);
#else
            SystemInfo.IsFormatSupported(format, FormatUsage.Linear) && SystemInfo.IsFormatSupported(format, FormatUsage.LoadStore);
#endif

        public static bool CanBeDrawnTo(GraphicsFormat format) =>
#if UNITY_2023_2_OR_NEWER
            SystemInfo.IsFormatSupported(format, GraphicsFormatUsage.Render);
#else
            SystemInfo.IsFormatSupported(format, FormatUsage.Render);
#endif

        public static bool CanBeReadBack(GraphicsFormat format) =>
#if UNITY_2023_2_OR_NEWER
            SystemInfo.IsFormatSupported(format, GraphicsFormatUsage.ReadPixels);
#else
            SystemInfo.IsFormatSupported(format, FormatUsage.ReadPixels);
#endif
    }
}
