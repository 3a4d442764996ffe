// Reloading the scripts' domain, as the editor does when scripts were compiled and when play mode is entered: what is
// serialised survives, all else begins anew.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using UnityEngine;
using Object = UnityEngine.Object;

namespace StandIn
{
    public static class Domain
    {
        /// What the editor does before, with the new assemblies, and when objects run again.
        public static event Action beforeReload, loaded, afterReload;

        /// Assemblies of scripts: those that know the engine and are neither its own nor the tests'.
        public static IEnumerable<Assembly> Scripts() => AppDomain.CurrentDomain.GetAssemblies().Where(assembly =>
        {
            if (assembly.IsDynamic) return false;
            var name = assembly.GetName().Name;
            return !name.StartsWith("Unity") && !name.StartsWith("StandIn") && !name.Contains(".Tests") && assembly.GetReferencedAssemblies().Any(reference => reference.Name == "UnityEngine");
        });

        public static void Reload()
        {
            Threads.Main("a domain reload");
            beforeReload?.Invoke();
            var running = Lifecycle.Running();
            foreach (var script in running) { Lifecycle.Forget(script); script.isRunning = false; Messages.Send(script, "OnDisable"); }
            var objects = Objects.All();
            foreach (var item in objects.OfType<ScriptableObject>()) if (item.isEnabled) { item.isEnabled = false; Messages.Send(item, "OnDisable"); }
            foreach (var script in objects.OfType<MonoBehaviour>()) Coroutines.Stop(script, null);

            // What was posted to the main thread is the old domain's.
            (System.Threading.SynchronizationContext.Current as MainContext)?.Forget();

            // New instances in place of the old, under the same numbers. Constructors run before statics are reset, as
            // nothing may be seen of that: they may not call the engine.
            ClearStatics();
            var map = new Dictionary<Object, Object>(new ByReference());
            foreach (var old in objects) if (!old.isDestroyed && IsScript(old)) map[old] = Fresh(old);
            foreach (var pair in map)
            {
                TakeOver(pair.Key, pair.Value);
                if (!(pair.Key is MonoBehaviour was)) continue;
                var now = (MonoBehaviour)pair.Value;
                now.isAwake = was.isAwake;
                now.isStarted = was.isStarted;
                was.owner.components[was.owner.components.IndexOf(was)] = now;
            }
            foreach (var pair in map) Serializer.Copy(pair.Key, pair.Value, item => item, isReload: true);
            foreach (var old in map.Keys) old.isDestroyed = true;
            Application.ForgetListeners();
            UnityEngine.Rendering.RenderPipelineManager.Forget();
            Camera.Forget();

            // Whatever waits for the assemblies runs before any object does.
            loaded?.Invoke();
            Begin(map.Values);
            afterReload?.Invoke();
        }

        static bool IsScript(Object item) => (item is MonoBehaviour || item is ScriptableObject) && item.GetType().Assembly != typeof(Object).Assembly;

        /// An instance of the same class that no object is yet.
        static Object Fresh(Object old)
        {
            Objects.isReplacing = true;
            try { return (Object)Objects.Make(old.GetType()); }
            finally { Objects.isReplacing = false; }
        }

        /// One instance takes another's number, name and place; not its state.
        static void TakeOver(Object old, Object made)
        {
            Objects.Replace(old.instanceID, made);
            made.TakeIdentity(old);
            if (!(old is MonoBehaviour was)) return;
            var now = (MonoBehaviour)made;
            now.owner = was.owner;
            now.TakeOver(was.isOn);
            now.runInEditMode = was.runInEditMode;
        }

        /// Objects that were loaded begin to run.
        static void Begin(IEnumerable<Object> made)
        {
            foreach (var asset in made.OfType<ScriptableObject>())
            {
                Messages.Send(asset, "OnValidate");
                asset.isEnabled = true;
                Messages.Send(asset, "OnEnable");
            }
            foreach (var script in made.OfType<MonoBehaviour>())
            {
                script.update = Messages.Bind(script, "Update");
                script.lateUpdate = Messages.Bind(script, "LateUpdate");
                script.fixedUpdate = Messages.Bind(script, "FixedUpdate");
                if (script.isDestroyed) continue;
                Messages.Send(script, "OnValidate");
                Lifecycle.Refresh(script);
            }
        }

        sealed class ByReference : IEqualityComparer<Object>
        {
            public bool Equals(Object a, Object b) => ReferenceEquals(a, b);
            public int GetHashCode(Object item) => System.Runtime.CompilerServices.RuntimeHelpers.GetHashCode(item);
        }

        /// What initialisers gave to statics. The runtime runs them once only.
        static readonly Dictionary<FieldInfo, object> initial = new Dictionary<FieldInfo, object>();

        /// Before any script runs.
        public static void Remember()
        {
            foreach (var type in Scripts().SelectMany(assembly => assembly.GetTypes()).Where(type => !type.ContainsGenericParameters))
            {
                System.Runtime.CompilerServices.RuntimeHelpers.RunClassConstructor(type.TypeHandle);
                foreach (var field in type.GetFields(BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly))
                    if (!field.IsLiteral && !field.IsInitOnly && !field.FieldType.IsPointer) initial[field] = field.GetValue(null);
            }
        }

        /// Statics begin anew, as initialisers say; readonly ones stay.
        static void ClearStatics()
        {
            foreach (var pair in initial) pair.Key.SetValue(null, pair.Value);
        }

        static void RuntimeInitialize(params RuntimeInitializeLoadType[] when)
        {
            foreach (var kind in when)
                foreach (var type in Scripts().SelectMany(assembly => assembly.GetTypes()))
                    foreach (var method in type.GetMethods(BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly))
                        if (method.GetCustomAttribute<RuntimeInitializeOnLoadMethodAttribute>() is RuntimeInitializeOnLoadMethodAttribute attribute && attribute.loadType == kind)
                            method.Invoke(null, null);
        }

        /// What is saved of the scene while it plays: its scripts, and what else is saved with them, by the objects that they were.
        static readonly Dictionary<Object, Object> saved = new Dictionary<Object, Object>(new ByReference());
        static readonly HashSet<Object> edited = new HashSet<Object>();

        static bool IsSaved(Object item) => (item.hideFlags & HideFlags.DontSaveInEditor) == 0;
        static bool IsInScene(MonoBehaviour script) => IsScript(script) && script.isInScene && IsSaved(script.owner) && IsSaved(script);
        static IEnumerable<GameObject> Roots() => Objects.All().OfType<GameObject>().Where(item => item.transform.above is null && !item.isPrefab);

        static void SaveScene()
        {
            saved.Clear();
            edited.Clear();
            edited.UnionWith(Objects.All().OfType<GameObject>());
            var left = new Queue<Object>(Objects.All().OfType<MonoBehaviour>().Where(IsInScene));
            while (left.Count > 0)
            {
                var item = left.Dequeue();
                if (saved.ContainsKey(item)) continue;
                var copy = saved[item] = Fresh(item);
                Serializer.Copy(item, copy, other =>
                {
                    // What is in no file is saved with the scene that refers to it.
                    if (other is ScriptableObject && IsScript(other) && !other.isAsset && IsSaved(other)) left.Enqueue(other);
                    return other;
                });
            }
        }

        /// The scene is loaded from what was saved: its scripts are other instances, with what is serialised of them.
        /// Objects, and components of the engine's own, stay as they are.
        static void LoadScene(Action unloaded)
        {
            var places = new Dictionary<Object, int>(new ByReference());
            var owners = new Dictionary<Object, GameObject>(new ByReference());
            foreach (var old in saved.Keys)
            {
                var now = Objects.Find(old.instanceID);
                if (now == null) continue;
                if (now is MonoBehaviour script) { owners[old] = script.owner; places[old] = script.owner.components.IndexOf(script); }
                else places[old] = 0;
            }
            foreach (var old in places.Keys.ToArray()) if (Objects.Find(old.instanceID) is Object now) Objects.DestroyNow(now);
            unloaded();
            var made = new List<Object>();
            foreach (var pair in saved.Where(pair => places.ContainsKey(pair.Key)).OrderBy(pair => places[pair.Key]))
            {
                owners.TryGetValue(pair.Key, out var owner);
                if (owner is GameObject && owner.isDestroyed) continue;
                var now = Fresh(pair.Key);
                TakeOver(pair.Key, now);
                made.Add(now);
                if (owner is GameObject) owner.components.Insert(Math.Min(places[pair.Key], owner.components.Count), (MonoBehaviour)now);
            }
            foreach (var now in made) Serializer.Copy(saved.First(pair => pair.Key.instanceID == now.instanceID).Value, now, item => item);
            Begin(made);
            foreach (var item in Roots().ToArray()) Lifecycle.Refresh(item);
        }

        /// Enters play mode: with a new domain unless the project says that it keeps it, whose statics then live on.
        public static void Play(bool reloads = true)
        {
            if (Application.isPlaying) throw new InvalidOperationException("it is playing");
            if (reloads) Reload();
            SaveScene();
            LoadScene(() =>
            {
                Application.playing = true;
                RuntimeInitialize(RuntimeInitializeLoadType.SubsystemRegistration, RuntimeInitializeLoadType.AfterAssembliesLoaded, RuntimeInitializeLoadType.BeforeSplashScreen, RuntimeInitializeLoadType.BeforeSceneLoad);
            });
            RuntimeInitialize(RuntimeInitializeLoadType.AfterSceneLoad);
        }

        /// Back to editing: the scene is what it was, and objects that were made in play mode end, as they were not saved; but
        /// for those that nothing but their maker ends, by HideFlags. Statics live on.
        public static void Stop()
        {
            if (!Application.isPlaying) throw new InvalidOperationException("it is not playing");
            Application.Quitting();
            LoadScene(() =>
            {
                foreach (var item in Roots().Where(item => IsSaved(item) && !edited.Contains(item)).ToArray()) Objects.DestroyNow(item);
                Application.playing = false;
                foreach (var script in Objects.All().OfType<MonoBehaviour>()) { Lifecycle.Stop(script); script.isAwake = script.isStarted = false; }
            });
            saved.Clear();
            edited.Clear();
        }
    }
}
