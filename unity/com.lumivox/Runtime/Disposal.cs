using UnityEngine;

namespace Lumivox
{
    /// <summary>The end of objects that the package made for itself.</summary>
    static class Disposal
    {
        /// <summary>In edit mode at once: Unity destroys nothing later there.</summary>
        public static void Destroy(Object made)
        {
            if (made == null) return;
            if (Application.isPlaying) Object.Destroy(made);
            else Object.DestroyImmediate(made);
        }
    }
}
