using UnityEngine;

namespace Lumivox
{
    /// <summary>The end of objects that the package made for itself.</summary>
    static class Disposal
    {
        /// <summary>Whether nothing comes later: play mode ends, or the domain of the scripts.</summary>
        public static bool IsLast;

        /// <summary>In edit mode at once: Unity destroys nothing later there.</summary>
        public static void Destroy(Object made)
        {
            if (made == null) return;
            if (Application.isPlaying && !IsLast) Object.Destroy(made);
            else Object.DestroyImmediate(made);
        }
    }
}
