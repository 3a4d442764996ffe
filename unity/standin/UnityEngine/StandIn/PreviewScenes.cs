// Scenes of the editor that no other camera sees than those that are put into them.
using System.Collections.Generic;
using System.Linq;
using UnityEngine;
using UnityEngine.SceneManagement;

namespace StandIn
{
    public static class PreviewScenes
    {
        const int First = 3;
        static readonly SortedSet<int> open = new SortedSet<int>();

        /// Those that nobody has closed.
        public static int count => open.Count;

        internal static bool IsOpen(Scene scene) => open.Contains(scene.handleOf);

        internal static Scene Open()
        {
            var handle = First;
            while (open.Contains(handle)) handle++;
            open.Add(handle);
            return new Scene { handleOf = handle };
        }

        internal static bool Close(Scene scene)
        {
            if (!IsOpen(scene)) return false;
            foreach (var root in scene.GetRootGameObjects()) Object.DestroyImmediate(root);
            return open.Remove(scene.handleOf);
        }

        /// The bit of a preview scene; null for others.
        internal static ulong? MaskOf(Scene scene) => scene.handleOf >= First ? 1ul << (scene.handleOf - First) : (ulong?)null;

        /// Of which scenes a camera draws the objects.
        internal static ulong SeenBy(Camera camera) =>
            camera.overrideSceneCullingMask != 0 ? camera.overrideSceneCullingMask : MaskOf(camera.scene) ?? 1ul << 63;
    }
}
