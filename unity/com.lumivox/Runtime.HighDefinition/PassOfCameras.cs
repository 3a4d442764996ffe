// The pass in HDRP before version 16, which has no passes for all cameras: a hidden volume of one pass for each.
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.HighDefinition;

namespace Lumivox.HighDefinition
{
    /// <summary>
    /// A volume that is for one camera holds wherever that is, and whichever layers it takes volumes from. While a prefab is
    /// edited in isolation HDRP asks no volumes outside of it.
    /// </summary>
    internal static class PassOfCameras
    {
        static readonly List<CustomPassVolume> all = new List<CustomPassVolume>();
        static bool isHooked;

        public static void Hook()
        {
            if (isHooked) return;
            isHooked = true;
            RenderPipelineManager.beginCameraRendering += BeginCamera;
#if UNITY_EDITOR
            // They would outlive the list of them.
            UnityEditor.AssemblyReloadEvents.beforeAssemblyReload += Unhook;
#endif
        }

        public static void Unhook()
        {
            isHooked = false;
            RenderPipelineManager.beginCameraRendering -= BeginCamera;
#if UNITY_EDITOR
            UnityEditor.AssemblyReloadEvents.beforeAssemblyReload -= Unhook;
#endif
            foreach (var volume in all)
                if (volume != null) Object.DestroyImmediate(volume.gameObject);
            all.Clear();
        }

        static void BeginCamera(ScriptableRenderContext context, Camera camera)
        {
            if (!(GraphicsSettings.currentRenderPipeline is HDRenderPipelineAsset) || !LumivoxRuntime.Draws(camera)) return;
            foreach (var volume in all)
                if (volume != null && ReferenceEquals(volume.targetCamera, camera)) return;
            Forget();
            var hidden = new GameObject("Lumivox") { hideFlags = HideFlags.HideAndDontSave };
            var made = hidden.AddComponent<CustomPassVolume>();
            made.injectionPoint = CustomPassInjectionPoint.BeforeTransparent;
            made.targetCamera = camera;
            made.customPasses.Add(HighDefinitionHost.Pass);
            all.Add(made);
        }

        /// <summary>Cameras that are gone need none.</summary>
        static void Forget()
        {
            for (var i = all.Count - 1; i >= 0; i--)
            {
                var volume = all[i];
                if (volume != null && volume.targetCamera != null) continue;
                if (volume != null) Disposal.Destroy(volume.gameObject);
                all.RemoveAt(i);
            }
        }
    }
}
