using UnityEngine;
using UnityEngine.Rendering;

namespace Lumivox
{
    /// <summary>
    /// The eyes of a headset in one pass of a scriptable pipeline, which has every draw repeated for each of them: here each eye
    /// has draws of its own, which would be blended twice.
    /// </summary>
    internal static class SinglePass
    {
        /// <summary>From here on draws are drawn once.</summary>
        public static void Suspend(CommandBuffer cmd)
        {
            // With multiview it is the target that has views, and a single layer has none.
            if (!SystemInfo.supportsMultiview) cmd.SetInstanceMultiplier(1);
        }

        /// <summary>As the pipeline left it.</summary>
        public static void Resume(CommandBuffer cmd, int eyeCount)
        {
            if (!SystemInfo.supportsMultiview) cmd.SetInstanceMultiplier((uint)eyeCount);
        }
    }
}
