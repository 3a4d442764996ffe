// The scene's lights, found without garbage: known ones are looked at in each frame, new ones are searched for a little at
// a time.
using System.Collections.Generic;
using System.Diagnostics;
using UnityEngine;
using UnityEngine.SceneManagement;

namespace Lumivox
{
    internal static class LightFinder
    {
        /// <summary>Milliseconds of a turn that the search may take, and seconds from one search of everything to the next.</summary>
        const double Patience = 0.1, Interval = 0.5;

        static readonly List<Light> known = new List<Light>();
        static readonly HashSet<ulong> knownIds = new HashSet<ulong>();
        static readonly List<Light> found = new List<Light>();
        static readonly List<GameObject> roots = new List<GameObject>();
        static readonly Stopwatch watch = new Stopwatch();
        static int nextRoot = -1;
        static double nextSearch;
        static int rootCount;
        static bool isHooked;

        /// <summary>Lights that are there, enabled or not; some may be gone.</summary>
        public static List<Light> Known => known;

        /// <summary>Finds all lights now.</summary>
        public static void FindAll()
        {
            Begin();
            while (nextRoot >= 0) LookAtNextRoot();
        }

        /// <summary>A light that somebody came across.</summary>
        public static void Add(Light light)
        {
            if (light != null && knownIds.Add(Identity.Of(light))) known.Add(light);
        }

        /// <summary>Goes on with the search.</summary>
        public static void Tick()
        {
            if (!isHooked)
            {
                isHooked = true;
                SceneManager.sceneLoaded += (_, __) => FindAll();
#if UNITY_EDITOR
                UnityEditor.EditorApplication.hierarchyChanged += () => nextSearch = 0;
#endif
                FindAll();
                return;
            }
            if (nextRoot < 0)
            {
                if (Time.realtimeSinceStartupAsDouble < nextSearch && CountRoots() == rootCount) return;
                Begin();
            }
            watch.Restart();
            while (nextRoot >= 0 && watch.Elapsed.TotalMilliseconds < Patience) LookAtNextRoot();
        }

        static void Begin()
        {
            nextSearch = Time.realtimeSinceStartupAsDouble + Interval;
            roots.Clear();
            for (var i = 0; i < SceneManager.sceneCount; i++) AddRoots(SceneManager.GetSceneAt(i));
            AddRoots(Ticker.LastingScene);
            rootCount = CountRoots();
            nextRoot = roots.Count - 1;
            for (var i = known.Count - 1; i >= 0; i--)
                if (known[i] == null)
                {
                    known.RemoveAt(i);
                    knownIds.Clear();
                }
            if (knownIds.Count != known.Count)
                foreach (var light in known) knownIds.Add(Identity.Of(light));
        }

        static void AddRoots(Scene scene)
        {
            if (!scene.IsValid() || !scene.isLoaded) return;
            scratch.Clear();
            scene.GetRootGameObjects(scratch);
            roots.AddRange(scratch);
        }

        static readonly List<GameObject> scratch = new List<GameObject>();

        static int CountRoots()
        {
            var count = 0;
            for (var i = 0; i < SceneManager.sceneCount; i++)
            {
                var scene = SceneManager.GetSceneAt(i);
                if (scene.isLoaded) count += scene.rootCount;
            }
            return count;
        }

        static void LookAtNextRoot()
        {
            var root = roots[nextRoot--];
            if (root == null) return;
            root.GetComponentsInChildren(true, found);
            foreach (var light in found) Add(light);
            found.Clear();
        }
    }
}
