// A turn of the main thread, outside of all rendering: in players and in play mode by a hidden object, else by the editor.
using System;
using UnityEngine;

namespace Lumivox
{
    internal static class Ticker
    {
        static bool isHooked;
        static TickerBehaviour behaviour;

        /// <summary>Called in each turn, besides what every turn does.</summary>
        public static event Action Ticked;

        /// <summary>The scene of objects that no change of scenes destroys; not valid where there is none.</summary>
        public static UnityEngine.SceneManagement.Scene LastingScene => behaviour != null ? behaviour.gameObject.scene : default;

        /// <summary>Sees to it that there are turns.</summary>
        public static void Need()
        {
            if (!isHooked)
            {
                isHooked = true;
                Application.quitting += LumivoxRuntime.Stop;
#if UNITY_EDITOR
                UnityEditor.EditorApplication.update += Tick;
                // What the domain knows of the GPU and of threads is lost with it.
                UnityEditor.AssemblyReloadEvents.beforeAssemblyReload += StopForReload;
#endif
            }
            if (behaviour == null && Application.isPlaying)
            {
                // What is not to be saved would outlive play mode, too.
                var hidden = new GameObject("Lumivox") { hideFlags = HideFlags.HideInHierarchy };
                UnityEngine.Object.DontDestroyOnLoad(hidden);
                behaviour = hidden.AddComponent<TickerBehaviour>();
            }
        }

        /// <summary>One turn.</summary>
        public static void Tick()
        {
            Jobs.Poll();
            LumivoxRuntime.Tick();
            Ticked?.Invoke();
        }

#if UNITY_EDITOR
        static void StopForReload()
        {
            UnityEditor.EditorApplication.update -= Tick;
            Jobs.StopAll();
            LumivoxRuntime.Stop();
        }
#endif
    }
}
